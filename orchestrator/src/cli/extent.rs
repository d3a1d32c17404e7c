//! Numbers of samples for which `check` prints the time, for studies that may end early or that compute a part of their grid.

use super::answer::{refinement, waiting};
use super::error::CliError;
use bladeoff_answers::summary::{counted, duration};
use bladeoff_study::Samples;

/// A number of samples, with a name such as "the whole study".
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Extent {
    pub name: String,
    pub samples: u64,
}

impl Extent {
    fn new(name: &str, samples: u64) -> Self {
        Self { name: name.to_owned(), samples }
    }
}

/// Extents for which the time is printed: the whole study; with `[stop]` also the samples up to its first interim analysis, with `[refine]` its
/// first round.
///
/// # Errors
/// Questions with errors.
pub(super) fn extents(samples: &Samples) -> Result<Vec<Extent>, CliError> {
    if let Some([first, most]) = refinement(samples)?.map(|refinement| refinement.samples()) {
        let (first_name, most_name) = (
            format!("the first round of [refine], {}", counted(first, "sample")),
            format!("the whole study, at most {}", counted(most, "sample")),
        );
        return Ok(vec![Extent::new(&first_name, first), Extent::new(&most_name, most)]);
    }
    let Some(waiting) = waiting(samples)? else { return Ok(vec![Extent::new("the whole study", samples.count())]) };
    let (first, last) = waiting.ends();
    let whole = match last == samples.count() {
        true => "the whole study".to_owned(),
        false => format!("the whole study, {} by [stop]", counted(last, "sample")),
    };
    let Some(first) = first.filter(|first| *first < last) else { return Ok(vec![Extent::new(&whole, last)]) };
    let to_first = format!("to the first interim analysis of [stop], {}", counted(first, "sample"));
    Ok(vec![Extent::new(&to_first, first), Extent::new(&format!("{whole}, where no interim analysis ends it"), last)])
}

/// Line with the largest wall time by `[stop]`; empty without one.
pub(super) fn wall_told(samples: &Samples) -> String {
    let wall = samples.study().stop.and_then(|stop| stop.wall);
    wall.map_or_else(String::new, |wall| format!("[stop] ends a run after {}\n", duration(wall)))
}
