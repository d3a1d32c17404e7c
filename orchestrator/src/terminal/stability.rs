//! Warnings about speeds at which a machine's whirl is unstable.

use crate::engine;
use bladeoff_core::engine::speeds_of_run;
use bladeoff_core::modal::UnstableRange;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_text::document::units::format_digits;
use std::f64::consts::PI;

/// A warning for each range of speeds \[rad/s\], in ascending order, in which a whirl mode of the linear rotor without contact is unstable; empty
/// if no range is unstable, or if the eigenvalue problem fails.
#[must_use]
pub fn unstable(machine: &Machine, structure: &Structure, speeds: [f64; 2]) -> Vec<String> {
    let found = engine::unstable_speeds(machine, structure, speeds).unwrap_or_default();
    found.iter().map(range_in_words).collect()
}

/// One unstable range in words, without a full stop.
#[must_use]
pub fn range_in_words(range: &UnstableRange) -> String {
    let (ratio, at) = (format_digits(range.worst.ratio, "", 3), rpm(range.worst_at));
    let mode = if range.worst.frequency > 0.0 {
        format!("a whirl mode of {} Hz grows, damping ratio", format_digits(range.worst.frequency / (2.0 * PI), "", 4))
    } else {
        "a motion grows without oscillation, damping ratio".to_owned()
    };
    format!("unstable {}: {mode} {ratio} at {at} rpm (linear rotor without contact)", speeds_in_words(range))
}

fn rpm(speed: f64) -> String {
    format_digits(speed * 30.0 / PI, "", 5)
}

/// The speeds of a range: "between 0 and 1500 rpm", or "at 1500 rpm" for a run at one speed.
fn speeds_in_words(range: &UnstableRange) -> String {
    let (from, to) = (rpm(range.from), rpm(range.to));
    if from == to { format!("at {to} rpm") } else { format!("between {from} and {to} rpm") }
}

/// Computes the unstable ranges of several machines in sequence; keeps the structure of the last machine for reuse.
#[derive(Debug, Default)]
pub struct Stability(Option<Structure>);

impl Stability {
    /// Starts with a structure that has already been built.
    #[must_use]
    pub fn with(structure: Structure) -> Self {
        Self(Some(structure))
    }

    /// The unstable speeds of a machine's run: "unstable between 0 and 1500 rpm"; `None` if it is stable or its structure cannot be built.
    pub fn unstable(&mut self, machine: &Machine) -> Option<String> {
        let structure = match self.0.take() {
            Some(last) if last.fits(machine) => last,
            Some(last) => last.rebuilt(machine).ok()?,
            None => engine::build(machine).ok()?,
        };
        let found = engine::unstable_speeds(machine, &structure, speeds_of_run(machine)).unwrap_or_default();
        self.0 = Some(structure);
        let ranges: Vec<String> = found.iter().map(speeds_in_words).collect();
        (!ranges.is_empty()).then(|| format!("unstable {}", ranges.join(" and ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    #[test]
    fn a_range_has_its_limits_in_rpm_and_the_frequency_of_the_mode() {
        let text = "schema = 1\nname = \"m\"\n[rotor]\nkind = \"point-mass\"\nmass = 10.0\npolar_inertia = 0.5\ninitial_speed = 200.0\n\
                    [rotor.bearings.s]\nstiffness = [[1e5, Q], [-Q, 1e5]]\ndamping = 100.0\n[run]\nend_time = 0.1\n";
        let of = |q: &str| {
            let machine = MachineDef::parse("m.toml", &text.replace('Q', q)).expect("valid").build().expect("valid");
            unstable(&machine, &Structure::build(&machine, None).expect("buildable"), [0.0, 200.0])
        };
        assert_eq!(of("5e3"), [] as [String; 0]);
        let found = of("2e4");
        assert!(found.len() == 1, "{found:?}");
        // m z'' + c z' + (k - i q) z = 0: lambda = 4.96 + 100.37 i
        let start = "unstable between 0 and 1909.9 rpm: a whirl mode of 15.97 Hz grows, damping ratio -0.0494 at ";
        assert!(found[0].starts_with(start), "{found:?}");
        let machine =
            |q: &str| MachineDef::parse("m.toml", &text.replace('Q', q)).expect("valid").build().expect("valid");
        let mut stability = Stability::default();
        let three = ["2e4", "5e3", "2e4"].map(|q| stability.unstable(&machine(q)));
        assert_eq!(three[1], None);
        assert!(
            three[0].as_deref().is_some_and(|said| said.starts_with("unstable between ") && said.ends_with(" rpm"))
        );
        assert_eq!(three[0], three[2], "the structure of another machine is not used");
    }
}
