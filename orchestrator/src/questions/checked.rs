//! Check of a study file just read: whether its table can answer its questions.

use super::refining::Refinement;
use super::resolve::check_questions;
use bladeoff_study::ToCheck;
use bladeoff_text::document::Collector;

/// Checks questions, gates and `[refine]`; a [`bladeoff_study::CheckAsked`].
pub fn check_asked(to_check: &ToCheck<'_>, problems: &mut Collector<'_>) {
    if let Some((samples, meant)) = check_questions(to_check, problems)
        && let Err(unrefined) = Refinement::of(&samples, &meant)
    {
        unrefined.tell(&samples, problems);
    }
}
