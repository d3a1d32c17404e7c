//! Questions about a study whose points are random: what a study file may ask, and the answer as JSON, as curves and in words.
//!
//! ```text
//! a file's words --question--> what is asked of which columns --asked--> answers by group, curves
//!   --answer--> answers.json      --sentence--> for a person
//! ```

mod answer;
mod asked;
mod question;
mod sentence;

pub use crate::estimate::formula::Known;
pub use answer::{Answer, Answers, LEFT_WIDE, SCHEMA};
pub use asked::{Answered, answer, answer_all, in_words};
pub use question::{Ask, CONFIDENCE, Figure, Names, Problem, Question, QuestionDef};
pub use sentence::percent_given;
pub(crate) use sentence::{counted, percent, prefix};
