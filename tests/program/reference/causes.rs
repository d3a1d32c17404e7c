//! Reference page of causes, ends and statuses of runs, with the texts of `bladeoff why`.

use super::{head, row, sentence};
use bladeoff::terminal::{Ran, advice, cause_in_words, end_cause_in_words};
use bladeoff_model::machine::Engine;
use bladeoff_model::outcome::{Cause, EndCause, Limit};

/// A heading, its introduction, and the condition on its causes.
type Kind = (&'static str, &'static str, fn(Cause) -> bool);

const KINDS: [Kind; 3] = [
    (
        "Numerical checks and ends of a run",
        "The run is `invalid` if it finished and a guard broke, `failed` if it ended early. The same sample always gives the same cause.",
        |cause| cause.is_deterministic() && Limit::of(cause).is_none(),
    ),
    (
        "Limits of the physical model",
        "The run is `beyond`, or keeps its status with a note where the machine file has `on_exceed = \"note\"`.",
        |cause| Limit::of(cause).is_some(),
    ),
    (
        "Deaths of a worker process",
        "The sample is `quarantined`. These causes depend on the computer, and `--rerun` computes the sample again.",
        |cause| !cause.is_deterministic(),
    ),
];

/// Kinds of runs whose advice may differ, with their names.
const RUNS: [(&str, Ran); 4] = [
    ("exponential engine", Ran { engine: Engine::Exponential, is_backward: false, has_one_point: false }),
    (
        "exponential engine, heavy backward whirl",
        Ran { engine: Engine::Exponential, is_backward: true, has_one_point: false },
    ),
    ("reference engines", Ran { engine: Engine::Reduced, is_backward: false, has_one_point: true }),
    (
        "reference engines, heavy backward whirl, one contact point",
        Ran { engine: Engine::Reduced, is_backward: true, has_one_point: true },
    ),
];

pub fn page() -> String {
    let mut page = String::new();
    for (heading, words, is_of) in KINDS {
        page += &format!("## {heading}\n\n{words}\n");
        for &cause in Cause::ALL.iter().filter(|&&cause| is_of(cause)) {
            page += &format!("\n### `{}`\n\n{}\n\n", cause.word(), sentence(cause_in_words(cause)));
            page += &remedies(cause);
        }
        page += "\n";
    }
    page += "## Why a run ended\n\nThe column `end_cause` has one of these words.\n\n";
    page += &head(&["`end_cause`", "meaning"]);
    for &cause in EndCause::ALL {
        page += &row(&[format!("`{}`", cause.word()), sentence(end_cause_in_words(cause))]);
    }
    page
}

/// Advice: one text, or one for each kind of run with its own.
fn remedies(cause: Cause) -> String {
    let texts: Vec<(&str, String)> =
        RUNS.iter().map(|(name, ran)| (*name, sentence(&advice(cause, *ran).text))).collect();
    if texts.iter().all(|(_, text)| *text == texts[0].1) {
        return format!("What to do: {}\n", lowered(&texts[0].1));
    }
    let mut items = String::from("What to do:\n\n");
    let mut kept: Vec<&str> = Vec::new();
    for (name, text) in &texts {
        if !kept.contains(&text.as_str()) {
            kept.push(text);
            items += &format!("- {name}: {}\n", lowered(text));
        }
    }
    items
}

/// A sentence as written after a colon.
fn lowered(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| format!("{}{}", first.to_lowercase(), letters.as_str()))
}
