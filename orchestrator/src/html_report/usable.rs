//! Table of the numbers of a page: which of them may be used for design.
//!
//! ```text
//! yes:        every run counts: an interval holds whether runs that are not ok are harmless or harmful
//! restricted: something that the number leaves out, or a setting that weakens its checks, is named beside it
//! no:         the model does not describe it
//! ```

use super::limits::{LimitTable, UnjudgedStress};
use super::rows::Seen;
use crate::questions::Looked;
use bladeoff_answers::ask::{Answer, Ask, Figure, Question, in_words};
use bladeoff_answers::gate::{Decision, Verdict};
use bladeoff_answers::page::{Block, Table};
use bladeoff_answers::summary::counted;
use bladeoff_model::machine::Reservation;

/// One row of the table.
#[derive(Debug, Clone, PartialEq)]
struct Use {
    number: String,
    word: &'static str,
    why: String,
}

const YES: &str = "yes";
const RESTRICTED: &str = "restricted";
const NO: &str = "no";
/// Beginning of the name of the group of all ok results.
const OF_OK_RUNS: &str = "results of the ok runs";

/// Circumstances that restrict numbers in addition to their own runs.
pub(super) struct Circumstances<'a> {
    /// Limits of the model.
    pub limits: &'a LimitTable,
    /// Settings that weaken `ok`, and bearings whose peak loads are not those of the machine.
    pub reservations: &'a [Reservation],
    /// Sentences on what the ends of the runs leave unknown.
    pub horizon: &'a [String],
    /// Sentence on sensitive runs, if there are any.
    pub sensitive: Option<&'a str>,
}

/// The table; empty before the first run has ended.
pub(super) fn usable(
    seen: &Seen,
    of: u64,
    looked: Option<&Looked>,
    questions: &[Question],
    circumstances: &Circumstances<'_>,
) -> Vec<Block> {
    let Circumstances { limits, reservations, horizon, sensitive } = *circumstances;
    if seen.rows == 0 {
        return Vec::new();
    }
    let mut uses: Vec<Use> = Vec::new();
    if let Some(looked) = looked {
        let answers = &looked.answering.answers.answers;
        for question in questions {
            let of: Vec<&Answer> = answers.iter().filter(|answer| answer.name == question.name).collect();
            uses.extend(of_question(question, &of));
        }
        // the decisions of a gate follow one another
        uses.extend(looked.decisions.chunk_by(|one, other| one.gate == other.gate).filter_map(of_gate));
    }
    uses.extend(of_rows(seen));
    let unjudged = limits.unjudged_stresses();
    for stress in &unjudged {
        for one in uses.iter_mut().filter(|one| one.number.contains(stress.column)) {
            one.word = stress.word();
            one.why = format!("the stress of {} is not judged: see its line below", stress.part);
        }
    }
    if let Some(why) = broken(&unjudged, seen.ok()) {
        uses.iter_mut().filter(|one| one.word != NO).for_each(|one| restrict(one, &why));
    }
    for one in uses.iter_mut().filter(|one| one.word != NO) {
        let is_concerned = |of: &&Reservation| concerns(of, &one.number);
        let mut topics: Vec<&str> = reservations.iter().filter(is_concerned).map(|of| of.topic).collect();
        topics.dedup();
        if !topics.is_empty() {
            restrict(one, &format!("see {} below", topics.join(", ")));
        }
    }
    let put = |(number, word, why): (String, &'static str, String)| Use { number, word, why };
    uses.extend(unjudged.iter().map(|of| put((format!("stress of {}", of.part), of.word(), of.why.clone()))));
    uses.extend(limits.noted().into_iter().map(|why| put(("runs above a noted limit".to_owned(), RESTRICTED, why))));
    uses.extend(reservations.iter().map(|one| put((one.topic.to_owned(), RESTRICTED, one.text.clone()))));
    uses.extend(sensitive.map(|why| put(("values of single runs".to_owned(), RESTRICTED, why.to_owned()))));
    uses.extend(horizon.iter().map(|why| put(("events after the end of the runs".to_owned(), NO, why.clone()))));
    let place = |word| [YES, RESTRICTED, NO].iter().position(|one| *one == word);
    uses.sort_by_key(|one| place(one.word));
    let head = ["number", "for design", "why"].map(str::to_owned).to_vec();
    let rows = uses.into_iter().map(|one| vec![one.number, one.word.to_owned(), one.why]).collect();
    let mut blocks = vec![Block::Table(Table { head, rows, verbatim: Vec::new() })];
    if seen.rows < of {
        let more = "The study is not complete: a number that may be used will still change, within its interval in most cases.";
        blocks.push(Block::Note(more.to_owned()));
    }
    blocks
}

/// Whether a reservation concerns a number; the group of all ok results contains every column.
fn concerns(of: &Reservation, number: &str) -> bool {
    of.columns.is_empty() || number.starts_with(OF_OK_RUNS) || of.columns.iter().any(|part| number.contains(part))
}

/// Restricts a number for a further reason.
fn restrict(one: &mut Use, why: &str) {
    one.word = RESTRICTED;
    one.why += &format!("; but {why}");
}

impl UnjudgedStress {
    /// Word for whether the number may be used.
    fn word(&self) -> &'static str {
        if self.above > 0 { NO } else { RESTRICTED }
    }
}

/// Restriction of numbers that include ok runs with stresses above any elastic limit, with the number of `ok` runs; `None` without such a
/// run.
fn broken(stresses: &[UnjudgedStress], ok: u64) -> Option<String> {
    let above = || stresses.iter().filter(|of| of.above > 0);
    let most = above().map(|of| of.above).max()?;
    let parts: Vec<&str> = above().map(|of| of.part).collect();
    Some(format!(
        "in {}{most} of {} the stress of {} exceeds the elastic limit of any steel. Contact forces and all results that \
         depend on them are then not those of the machine. With a yield_strength such runs count as beyond the model",
        if parts.len() > 1 { "at least " } else { "" },
        counted(ok, "ok run"),
        parts.join(" and ")
    ))
}

/// Whether the answers to a question may be used; `None` without an answer.
fn of_question(question: &Question, answers: &[&Answer]) -> Option<Use> {
    let (bad, n) = (answers.iter().map(|answer| answer.bad).max()?, answers.iter().map(|answer| answer.n).max()?);
    let runs =
        if answers.len() > 1 { format!("up to {} of a group", counted(bad, "run")) } else { counted(bad, "run") };
    let is_one_number = matches!(question.ask, Ask::One(_) | Ask::Difference(..));
    let has_interval = answers.iter().any(|answer| answer.low.is_some() || answer.high.is_some());
    let (word, why) = match &question.ask {
        _ if n == 0 => (NO, "no point has a value".to_owned()),
        _ if bad >= n => (NO, "no run of it is ok".to_owned()),
        _ if is_one_number && !has_interval => (NO, "there is no interval".to_owned()),
        _ if is_one_number && answers.iter().any(|answer| answer.low.is_none() || answer.high.is_none()) => {
            let missing = |end: fn(&Answer) -> Option<f64>| answers.iter().all(|answer| end(answer).is_none());
            let what = match (missing(|answer| answer.low), missing(|answer| answer.high)) {
                (false, true) => "it has a lower limit only: the value may be far above it",
                (true, false) => "it has an upper limit only: the value may be far below it",
                _ => "it has a limit on one side only",
            };
            (RESTRICTED, what.to_owned())
        }
        Ask::Sensitivity(_)
            if answers.iter().all(|answer| answer.without_interval().is_some_and(|why| why.starts_with("no "))) =>
        {
            (NO, "no index has an interval".to_owned())
        }
        Ask::Sensitivity(_) if answers.iter().any(|answer| !answer.notes.is_empty()) => {
            (RESTRICTED, "the notes below it list what it does not describe".to_owned())
        }
        _ if bad == 0 => (YES, "all its runs are ok".to_owned()),
        Ask::One(Figure::Mean(_)) | Ask::Difference(Figure::Mean(_), ..) | Ask::Sensitivity(_) => {
            (RESTRICTED, format!("it describes the ok runs only; {runs} not ok are left out"))
        }
        Ask::Map(_) => (RESTRICTED, format!("hatched cells have runs that are not ok ({runs})")),
        Ask::One(_) | Ask::Difference(..) | Ask::Exceedance(_) | Ask::Fragility(..) => {
            (YES, format!("use the interval, not the estimate: it holds for any outcome of the {runs} not ok"))
        }
    };
    Some(Use { number: format!("answer {}", in_words(question)), word, why })
}

/// Whether the decisions of a gate, one for each group, may be used; `None` without a decision.
fn of_gate(decisions: &[Decision]) -> Option<Use> {
    let first = decisions.first()?;
    let open = decisions.iter().filter(|decision| decision.verdict == Verdict::Open).count();
    let bad = decisions.iter().map(|decision| decision.bad).max()?;
    let (word, why) = match open {
        0 if bad == 0 => (YES, "all its runs are ok".to_owned()),
        0 => (YES, format!("the decision holds for any outcome of the {} not ok", counted(bad, "run"))),
        _ if open == decisions.len() => (NO, "it is open: neither passed nor failed".to_owned()),
        _ => (RESTRICTED, format!("{open} of {} are open", counted(decisions.len() as u64, "group"))),
    };
    Some(Use { number: format!("gate {}", first.gate), word, why })
}

/// Whether rows may be used, by their status.
fn of_rows(seen: &Seen) -> Vec<Use> {
    let (ok, bad) = (seen.ok(), seen.rows - seen.ok());
    let share = |count: u64| format!("{count} of {}", counted(seen.rows, "run"));
    let mut uses = Vec::new();
    if ok > 0 {
        let mut why = "all checks passed, and no limit that ends a run was exceeded".to_owned();
        if bad > 0 {
            why += "; the ok runs are a selection: the runs that are not ok, often the worst ones, are missing";
        }
        let word = if bad > 0 { RESTRICTED } else { YES };
        uses.push(Use { number: format!("{OF_OK_RUNS}: {}", share(ok)), word, why });
    }
    if bad > 0 {
        let why = "the value reached while limits and guards held is a lower bound of a maximum".to_owned();
        uses.push(Use { number: format!("results of runs that are not ok: {}", share(bad)), word: NO, why });
    }
    uses
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html_report::rows::OfKind;
    use bladeoff_answers::estimate::input::Group;
    use std::collections::BTreeMap;

    #[test]
    fn an_open_gate_is_not_for_design() {
        let decision = |verdict, bad| Decision {
            gate: "P(x > 1) < 0.1".to_owned(),
            group: Group(Vec::new()),
            verdict,
            n: 256,
            events: (1, 1 + bad),
            bad,
            beyond: bad,
            undecided: Default::default(),
            limits: (0.0, 0.05),
            level: 0.05,
            more: None,
            sentence: String::new(),
        };
        let found = |decisions: &[Decision]| of_gate(decisions).map(|one| (one.word, one.why));
        let (passed, open) = (decision(Verdict::Passed, 0), decision(Verdict::Open, 3));
        assert_eq!(found(&[]), None);
        assert_eq!(found(std::slice::from_ref(&passed)), Some((YES, "all its runs are ok".to_owned())));
        let failed = found(&[decision(Verdict::Failed, 1)]).expect("a decision");
        assert!(failed.0 == YES && failed.1.contains("any outcome of the 1 run not ok"), "{failed:?}");
        assert_eq!(found(std::slice::from_ref(&open)).map(|one| one.0), Some(NO));
        assert_eq!(found(&[passed, open]), Some((RESTRICTED, "1 of 2 groups are open".to_owned())));
    }

    #[test]
    fn rows_that_are_not_ok_are_not_for_design() {
        let kind = |status: &str, count| OfKind { kind: (status.to_owned(), String::new()), count, first: 0 };
        let mut seen = Seen {
            coordinates: Vec::new(),
            words: Vec::new(),
            rows: 4,
            kinds: vec![kind("ok", 3), kind("beyond", 1)],
            picked: Vec::new(),
            ends: Vec::new(),
            regimes: BTreeMap::new(),
        };
        let words = |seen: &Seen| of_rows(seen).into_iter().map(|one| (one.number, one.word)).collect::<Vec<_>>();
        let some = "results of the ok runs: 3 of 4 runs".to_owned();
        assert_eq!(words(&seen), [(some, RESTRICTED), ("results of runs that are not ok: 1 of 4 runs".to_owned(), NO)]);
        let mut one = of_rows(&Seen { rows: 3, kinds: vec![kind("ok", 3)], ..seen.clone() }).remove(0);
        assert_eq!(one.word, YES);
        let stress = |part, above| UnjudgedStress { column: "c", part, above, why: String::new() };
        assert_eq!(broken(&[stress("ring", 0)], 3), None);
        restrict(&mut one, &broken(&[stress("ring", 0), stress("blades", 2)], 3).expect("blades break"));
        assert!(
            one.word == RESTRICTED && one.why.contains("in 2 of 3 ok runs the stress of blades exceeds"),
            "{one:?}"
        );
        let both = broken(&[stress("ring", 1), stress("blades", 2)], 3).expect("both break");
        assert!(both.starts_with("in at least 2 of 3 ok runs the stress of ring and blades"), "{both}");
        (seen.kinds, seen.rows) = (vec![kind("beyond", 2)], 2);
        assert_eq!(words(&seen), [("results of runs that are not ok: 2 of 2 runs".to_owned(), NO)]);
        seen.rows = 0;
        let none = Circumstances { limits: &LimitTable::default(), reservations: &[], horizon: &[], sensitive: None };
        assert!(usable(&seen, 5, None, &[], &none).is_empty());
    }

    #[test]
    fn a_reservation_concerns_its_columns_and_the_group_of_all_results() {
        let of = |columns| Reservation { topic: "modes", text: String::new(), columns };
        let torsion = of(&["torsional_moment", "shear_stress"]);
        for number in [
            "answer P(max_shear_stress_Pa > 1)",
            "gate P(max_torsional_moment_Nm > 1) < 0.5",
            "results of the ok runs: 3 of 4 runs",
        ] {
            assert!(concerns(&torsion, number), "{number}");
        }
        assert!(
            !concerns(&torsion, "answer P(max_bearing_load_N > 1)")
                && concerns(&of(&[]), "answer P(max_bearing_load_N > 1)")
        );
    }
}
