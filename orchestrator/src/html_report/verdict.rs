//! The first line of a page: the decisions of the gates, and the number of runs for which the model is valid.

use super::limits::LimitTable;
use super::rows::Seen;
use super::words::percent;
use crate::questions::Looked;
use bladeoff_answers::gate::{Decision, Verdict};
use bladeoff_answers::page::Block;
use bladeoff_answers::summary::counted;

/// "Verdict: 2 of 3 gates passed, 1 is open. ..."
pub(super) fn verdict(
    seen: &Seen,
    of: u64,
    looked: Option<&Looked>,
    limits: &LimitTable,
    excess: Option<&str>,
) -> Block {
    let decisions = looked.map_or(&[][..], |looked| &looked.decisions);
    let parts = [gates(decisions), runs(seen), restrictions(limits, excess)];
    let text = parts.into_iter().flatten().collect::<Vec<_>>().join(" ");
    let so_far =
        if seen.rows < of { format!(" so far, {} of {}", seen.rows, counted(of, "run")) } else { String::new() };
    Block::Verdict(format!("Verdict{so_far}: {text}"))
}

/// The results of the gates, failed ones first; a gate is counted once for each group.
fn gates(decisions: &[Decision]) -> Option<String> {
    if decisions.is_empty() {
        return None;
    }
    let count = |verdict| decisions.iter().filter(|decision| decision.verdict == verdict).count() as u64;
    let all = decisions.len() as u64;
    let parts = [(Verdict::Failed, "FAILED"), (Verdict::Open, "open"), (Verdict::Passed, "passed")];
    let parts = parts.map(|(verdict, word)| (count(verdict), word)).into_iter().filter(|(count, _)| *count > 0);
    let parts: Vec<String> = parts.map(|(count, word)| format!("{count} {word}")).collect();
    Some(format!("{}: {}.", counted(all, "gate decision"), parts.join(", ")))
}

/// The number of runs for which the model is valid.
fn runs(seen: &Seen) -> Option<String> {
    if seen.rows == 0 {
        return Some("No run has ended yet.".to_owned());
    }
    let (ok, all) = (seen.ok(), counted(seen.rows, "run"));
    Some(match seen.rows - ok {
        0 if ok == 1 => "The run passed the numerical checks and the limits that end a run.".to_owned(),
        0 => format!("All {all} passed the numerical checks and the limits that end a run."),
        bad if ok == 0 => format!("No run may be used for design ({} not ok).", counted(bad, "run")),
        bad => format!(
            "{ok} of {all} passed the numerical checks and the limits that end a run; {bad} ({}) did not.",
            percent(bad as f64 / seen.rows as f64)
        ),
    })
}

/// Restrictions of the status ok in this study.
fn restrictions(limits: &LimitTable, excess: Option<&str>) -> Option<String> {
    let noted = limits.names_noted();
    let noted = (!noted.is_empty())
        .then(|| format!("ok runs exceed {}, a limit that is noted and ends no run", noted.join(" and ")));
    let above = limits.unjudged_stresses().into_iter().filter(|of| of.above > 0);
    let above: Vec<String> = above
        .map(|of| {
            format!("those of {} exceed the elastic limit of any steel in {}", of.part, counted(of.above, "ok run"))
        })
        .collect();
    let unjudged = limits
        .unjudged()
        .map(|_| std::iter::once("stresses are not judged".to_owned()).chain(above).collect::<Vec<_>>().join("; "));
    let parts: Vec<String> = excess.map(str::to_owned).into_iter().chain(noted).chain(unjudged).collect();
    (!parts.is_empty()).then(|| format!("Restrictions: {}.", parts.join("; ")))
}
