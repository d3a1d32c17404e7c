//! Questions about a study with random points: syntax in the study file, and answers as JSON, curves and text.
//!
//! ```text
//! text of the study file --question--> validated questions with their columns --asked--> answers by group, curves
//!   --answer--> answers.json      --sentence--> text
//! ```

mod answer;
mod asked;
mod mapped;
mod mapping;
mod method;
mod question;
mod scale;
mod sensitive;
mod sentence;
mod streamed;
mod wording;

pub use crate::estimate::formula::Known;
pub(crate) use crate::share::percent;
pub use crate::share::percent_given;
pub use answer::{Answer, Answers, Correlated, OfRegime, SCHEMA, Sensitivities, is_of_group};
pub(crate) use asked::decided_by;
pub use asked::{Answered, answer, answer_all, answer_each, collected};
pub use method::{Sensitivity, SensitivityMethod};
pub use question::{Ask, CONFIDENCE, Figure, Given, Names, Problem, Question, QuestionDef};
pub use scale::Scale;
pub(crate) use sentence::{counted, prefix};
pub use streamed::{Streamed, Whole};
pub use wording::in_words;
