//! The result of one run in words: end cause, whether the result is valid, and the main quantities with the time at which they were reached.

use super::causes::{broken_by, cause_in_words, diverged_at, exceeded_at, exceeded_by};
use bladeoff_answers::summary::percent;
use bladeoff_model::machine::{Machine, TWIN};
use bladeoff_model::outcome::{Cause, CauseSet, Column, ColumnKind, EndCause, Group, Outcome, Part, Status};
use bladeoff_text::document::units::format_quantity;
use std::fmt::Write;

/// An outcome with the columns that name its values.
#[derive(Debug, Clone, Copy)]
pub struct OutcomeView<'a> {
    /// Columns of the machine.
    pub columns: &'a [Column],
    /// The outcome.
    pub outcome: &'a Outcome,
}

impl OutcomeView<'_> {
    /// Value of a column; `None` if the value is null or no column has this name.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<f64> {
        let place = self.columns.iter().position(|column| column.name == name)?;
        self.outcome.values.get(place).copied().flatten()
    }
}

/// Whether a line of a log or of the workers' activities is about a sample, which means that it contains the sample number.
#[must_use]
pub fn mentions(line: &str, sample: u64) -> bool {
    let name = format!("sample {sample}");
    let ends_there = |at: usize| !line[at + name.len()..].starts_with(|c: char| c.is_ascii_digit());
    line.match_indices(&name).any(|(at, _)| ends_there(at))
}

/// The cause of a run's end in words.
#[must_use]
pub fn end_cause_in_words(cause: EndCause) -> &'static str {
    match cause {
        EndCause::Stopped => "the rotor came to rest",
        EndCause::EndTime => "`run.end_time` was reached",
        EndCause::EndSpeed => "the spin fell to `run.end_speed`",
        EndCause::Failure => "the run failed",
        EndCause::TableRange => "the speed left the table of a bearing",
        EndCause::Limit => "a limit of the model was exceeded",
        EndCause::Evaluated => "the formulas were evaluated",
    }
}

/// The block that `simulate` prints about a run of a machine.
#[must_use]
pub fn describe_outcome(machine: &Machine, view: OutcomeView<'_>) -> String {
    let mut text = String::new();
    let outcome = view.outcome;
    line(&mut text, "status", &status_line(outcome));
    for cause in outcome.causes.iter() {
        line(&mut text, cause.word(), cause_in_words(cause));
        if let Some(broken) = broken_by(cause, machine, |name| view.value(name)) {
            line(&mut text, "  by how much", &broken);
        }
        if cause == Cause::Diverged {
            line(&mut text, "  until then", &diverged_at(|name| view.value(name)).unwrap_or_default());
        }
    }
    for note in outcome.notes.iter() {
        line(&mut text, note.word(), &format!("noted: {}", cause_in_words(note)));
        if let Some(exceeded) = exceeded_by(note, |name| view.value(name)) {
            line(&mut text, "  by how much", &exceeded);
        }
    }
    if let Some(at) = exceeded_at(outcome.causes.iter(), |name| view.value(name)) {
        line(&mut text, "limit exceeded", &at);
    }
    let end = match (view.value("end_time_s"), view.value("end_speed_rad_s")) {
        (Some(time), Some(speed)) => format!(
            "{} at {}, spin {}",
            end_cause_in_words(outcome.end_cause),
            format_quantity(time, "s"),
            format_quantity(speed, "rad/s")
        ),
        _ => end_cause_in_words(outcome.end_cause).to_owned(),
    };
    line(&mut text, "end", &end);
    text.push_str(&describe_values(view.columns, &outcome.values));
    text
}

/// The quantities of a run in groups: a heading, then a line for each quantity with its time and speed.
#[must_use]
pub fn describe_values(columns: &[Column], values: &[Option<f64>]) -> String {
    let at = |place: usize| values.get(place).copied().flatten();
    let mut text = String::new();
    for group in Group::ALL {
        let heading = group.heading();
        let is_shown = |(_, column): &(usize, &Column)| {
            let is_whole = matches!(column.part, Part::Whole | Part::Peak);
            is_whole && !OTHERWISE.contains(&column.name.as_str()) && column.group == group
        };
        let grouped: Vec<(usize, &Column)> = columns.iter().enumerate().filter(is_shown).collect();
        if grouped.is_empty() {
            continue;
        }
        // A machine without a diaphragm has no rub; a group without values is reported nevertheless.
        if !matches!(group, Group::Course | Group::Functions) && grouped.iter().all(|(place, _)| at(*place).is_none()) {
            text.push_str(&format!("\n{heading}: none\n"));
            continue;
        }
        text.push_str(&format!("\n{heading}\n"));
        grouped.into_iter().for_each(|(place, column)| {
            let guarded = column.guarded().and_then(|name| at(columns.iter().position(|other| other.name == name)?));
            line(&mut text, label(column), &shown(column, guarded, |by| at(place + by)));
        });
    }
    text
}

/// A value with its unit, and the time and speed at which it was reached. `guarded`: the value while all guards held; `after`: the value of the
/// column that is a given number of places after this one.
fn shown(column: &Column, guarded: Option<f64>, after: impl Fn(usize) -> Option<f64>) -> String {
    let is_peak = column.part == Part::Peak;
    match after(0) {
        None => "-".to_owned(),
        Some(value) if column.kind == ColumnKind::Count => format!("{value}"),
        Some(value) if matches!(column.kind, ColumnKind::Choice(_)) => word(column.kind, value).to_owned(),
        Some(value) if column.name.starts_with("twin_") && column.name.ends_with("_change") => {
            let more = if value < 0.0 { "less" } else { "more" };
            format!("{} {more} in a run that starts by {TWIN} faster", percent(value.abs()))
        }
        // A peak of zero has as its place the first one searched, so the place is not shown.
        Some(0.0) if is_peak => "none".to_owned(),
        Some(value) => {
            // a value that was reached before a guard or limit was exceeded is not repeated
            let guarded = guarded.filter(|guarded| *guarded != value);
            let guarded =
                guarded.map(|value| format!("  ({} while all guards held)", format_quantity(value, column.unit)));
            let of_peak = |by: usize| if is_peak { after(by) } else { None };
            let time = of_peak(1).map(|time| format!("  at {}", format_quantity(time, "s")));
            let speed = of_peak(2).map(|speed| format!(", {}", format_quantity(speed, "rad/s")));
            let (time, speed) = (time.unwrap_or_default(), speed.unwrap_or_default());
            format!("{}{time}{speed}{}", format_quantity(value, column.unit), guarded.unwrap_or_default())
        }
    }
}

fn word(kind: ColumnKind, index: f64) -> &'static str {
    match kind {
        ColumnKind::Choice(words) => words.get(index as usize).copied().unwrap_or("-"),
        ColumnKind::Real | ColumnKind::Count => "-",
    }
}

/// Columns that are shown elsewhere in the block.
const OTHERWISE: [&str; 2] = ["end_time_s", "end_speed_rad_s"];

/// Name of a column without the unit.
fn label(column: &Column) -> &str {
    let unit = column.unit.replace(' ', "").replace('/', "_");
    column.name.strip_suffix(&unit).map_or(&*column.name, |name| name.trim_end_matches('_'))
}

fn status_line(outcome: &Outcome) -> String {
    match outcome.status {
        Status::Ok => ok_in_words(outcome.notes),
        Status::Beyond if outcome.end_cause == EndCause::Limit => {
            "beyond the model: the run ended at a limit; its values are lower bounds of what would follow".to_owned()
        }
        Status::Beyond => "beyond the model: values after `beyond_s` are not those of this machine".to_owned(),
        Status::Invalid => "invalid: finished, but a numerical check failed".to_owned(),
        Status::Failed => "failed: ended early; the values are those up to then".to_owned(),
        Status::Quarantined => "quarantined: given up".to_owned(),
    }
}

/// "ok", with the limits of severity "note" that the row exceeded.
#[must_use]
pub fn ok_in_words(notes: CauseSet) -> String {
    match notes.words() {
        None => "ok".to_owned(),
        Some(words) => format!("ok: all validity guards held; noted: {}", words.replace(',', ", ")),
    }
}

fn line(text: &mut String, name: &str, value: &str) {
    writeln!(text, "{name:<32} {value}").expect("writing to a String cannot fail");
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::outcome::{Empty, Growth};
    use std::collections::BTreeSet;

    #[test]
    fn a_line_is_about_the_sample_it_names_in_full() {
        let line = "worker 3: sample 17: the solver panicked";
        assert!(mentions(line, 17) && !mentions(line, 1) && !mentions(line, 3));
        assert!(mentions("ended in sample 9", 9));
    }

    #[test]
    fn a_peak_is_shown_with_its_time_and_a_null_as_a_dash() {
        let column = |name: &str, unit, group, part| Column {
            name: name.into(),
            unit,
            kind: ColumnKind::Real,
            meaning: String::new(),
            group,
            part,
            growth: if part == Part::Peak { Growth::Grows } else { Growth::Free },
            is_guarded: part == Part::Peak,
            empty: Empty::Absent,
            lacks: None,
        };
        let columns = [
            column("max_bearing_load_N", "N", Group::BearingLoads, Part::Peak),
            column("max_bearing_load_at_s", "s", Group::BearingLoads, Part::PeakTime),
            column("max_bearing_load_at_rad_s", "rad/s", Group::BearingLoads, Part::PeakSpeed),
            column("first_contact_s", "s", Group::Course, Part::Whole),
            column("contact_impulse_Ns", "N s", Group::Contact, Part::Whole),
            column("max_blade_bending_stress_Pa", "Pa", Group::Stresses, Part::Peak),
            column("max_blade_bending_stress_at_s", "s", Group::Stresses, Part::PeakTime),
            column("max_blade_bending_stress_at_rad_s", "rad/s", Group::Stresses, Part::PeakSpeed),
            column("guarded_max_bearing_load_N", "N", Group::BearingLoads, Part::Guarded),
        ];
        let mut causes = CauseSet::default();
        causes.insert(Cause::SlipReversal);
        let outcome = Outcome {
            status: Status::Invalid,
            cause: Some(Cause::SlipReversal),
            causes,
            notes: CauseSet::default(),
            end_cause: EndCause::EndTime,
            values: vec![Some(1500.0), Some(0.25), None, None, Some(2.0), Some(0.0), Some(0.0), Some(0.0), Some(80.0)],
        };
        let machine = include_str!("../../../studies/machines/lp_turbine_paper.toml");
        let machine =
            bladeoff_model::machine::MachineDef::parse("lp_turbine_paper.toml", machine).and_then(|def| def.build());
        let view = OutcomeView { columns: &columns, outcome: &outcome };
        let text = describe_outcome(&machine.expect("valid"), view);
        let find = |start: &str| text.lines().find(|line| line.starts_with(start)).expect("the line").to_owned();
        assert!(find("max_bearing_load ").ends_with("1.5 kN  at 0.25 s  (80 N while all guards held)"), "{text}");
        assert!(!text.contains("guarded_"), "shown beside what it belongs to: {text}");
        assert!(find("first_contact ").ends_with('-'), "{text}");
        assert!(find("contact_impulse ").ends_with("2 N s"), "{text}");
        assert_eq!(find("max_blade_bending_stress ").split_whitespace().last(), Some("none"), "never stressed: {text}");
        assert!(find("slip_reversal").contains("changed sign"), "{text}");
    }

    /// A missing text for a status or an end cause is a compile error; this test checks that each text is different.
    #[test]
    fn every_status_and_every_end_has_a_text_of_its_own() {
        let of = |status| Outcome {
            status,
            cause: None,
            causes: CauseSet::default(),
            notes: CauseSet::default(),
            end_cause: EndCause::EndTime,
            values: Vec::new(),
        };
        let statuses: BTreeSet<String> = Status::ALL.iter().map(|status| status_line(&of(*status))).collect();
        assert_eq!(statuses.len(), Status::ALL.len());
        for status in Status::ALL {
            assert!(statuses.iter().any(|text| text.starts_with(status.word())), "{}", status.word());
        }
        let ends: BTreeSet<&str> = EndCause::ALL.iter().map(|end| end_cause_in_words(*end)).collect();
        assert_eq!(ends.len(), EndCause::ALL.len());
    }

    #[test]
    fn every_quantity_of_a_machine_is_shown_once_and_in_a_group_that_has_a_name() {
        let text = include_str!("../../../studies/machines/lp_turbine_paper.toml");
        let machine = bladeoff_model::machine::MachineDef::parse("lp_turbine_paper.toml", text).expect("valid");
        let columns = bladeoff_core::record::columns(&machine.build().expect("valid"));
        let values = vec![Some(0.0); columns.len()];
        let text = describe_values(&columns, &values);
        // A machine has no formulas.
        let headings: Vec<&str> =
            Group::ALL.into_iter().filter(|group| *group != Group::Functions).map(Group::heading).collect();
        for heading in &headings {
            assert_eq!(text.lines().filter(|line| line == heading).count(), 1, "{heading}: {text}");
        }
        let is_shown = |column: &&Column| {
            !column.name.contains("_at_") && column.part != Part::Guarded && !OTHERWISE.contains(&column.name.as_str())
        };
        for column in columns.iter().filter(is_shown) {
            let begins = |line: &&str| line.split_whitespace().next() == Some(label(column));
            assert_eq!(text.lines().filter(begins).count(), 1, "{}", column.name);
        }
        let under = |name: &str| {
            let at = text.lines().position(|line| line.split(' ').next() == Some(name)).expect("shown");
            text.lines().take(at).filter(|line| headings.contains(line)).last().expect("a heading")
        };
        for (name, heading) in [
            ("first_contact", "Course"),
            ("max_bearing_load_rear", "Bearing loads"),
            ("stick_time", "Contact and rub"),
            ("friction_energy", "Energy"),
            ("max_bending_stress_section4", "Moments and stresses"),
            ("steps", "Numerics"),
        ] {
            assert_eq!(under(name), heading, "{name}");
        }
        // A group without values is reported in one line.
        let text = describe_values(&columns, &vec![None; columns.len()]);
        assert_eq!(text.lines().filter(|line| line.ends_with(": none")).count(), 5, "{text}");
    }
}
