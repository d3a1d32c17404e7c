//! Comparison of a run with its twin: a second run with a slightly larger initial speed.
//!
//! ```text
//! change = (twin - own)/own,   sensitive = |change| > run.twin_limit for any quantity, or one run has a quantity that the other lacks
//! ```
//! Verified by the tests below and `tests/runs/twin.rs`.

use super::row::Row;
use bladeoff_model::machine::{TWIN, TWIN_LIMIT};
use bladeoff_model::outcome::{Empty, Status};

/// Words of the column `twin_status`.
const STATUS: &[&str] = &["ok", "invalid", "failed", "beyond"];
/// Words of the column `sensitive`.
const SENSITIVE: &[&str] = &["no", "yes"];

/// Columns of the changes, each with the column that it compares. The first is the oldest.
const CHANGES: [(&str, &str); 6] = [
    ("twin_bearing_load_change", "max_bearing_load_N"),
    ("twin_filtered_contact_force_change", "max_filtered_contact_force_N"),
    ("twin_contact_impulse_change", "contact_impulse_Ns"),
    ("twin_friction_energy_change", "friction_energy_J"),
    ("twin_eccentricity_change", "max_eccentricity_m"),
    ("twin_torsional_moment_change", "max_torsional_moment_Nm"),
];

/// Compared results of one run in the order of [`CHANGES`]: one value, or one per diaphragm. `None`: the run has no such result.
#[derive(Debug, Clone, Default)]
pub(crate) struct Compared(pub [Vec<Option<f64>>; CHANGES.len()]);

/// Comparison of a run with its twin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Twin {
    /// Relative changes (twin - own)/own \[-\] in the order of [`CHANGES`]; `None` without a comparison.
    changes: [Option<f64>; CHANGES.len()],
    /// Whether the run is sensitive; `None` if the two runs cannot be compared.
    sensitive: Option<bool>,
    /// Status of the twin run.
    status: Status,
}

impl Twin {
    /// Result for a twin that cannot be compared.
    pub fn alone(status: Status) -> Self {
        Self { changes: [None; CHANGES.len()], sensitive: None, status }
    }

    /// Compares a run with its twin. `limit`: largest relative change of a run that is not sensitive \[-\].
    pub fn of(own: &Compared, twin: &Compared, limit: f64, status: Status) -> Self {
        let mut changes = [None; CHANGES.len()];
        let mut sensitive = false;
        for (change, (own, twin)) in changes.iter_mut().zip(own.0.iter().zip(&twin.0)) {
            for (own, twin) in own.iter().zip(twin) {
                // a quantity of zero counts as absent: no contact, no friction
                let [own, twin] = [own, twin].map(|value| value.filter(|value| value.is_finite() && *value > 0.0));
                sensitive |= own.is_some() != twin.is_some();
                let Some(own) = own else { continue };
                let found = (twin.unwrap_or(0.0) - own) / own;
                sensitive |= found.abs() > limit;
                if change.is_none_or(|largest: f64| found.abs() > largest.abs()) {
                    *change = Some(found);
                }
            }
        }
        Self { changes, sensitive: Some(sensitive), status }
    }

    /// Reports the columns of the comparison. `runs`: the machine has a twin run.
    pub(super) fn report(of: Option<&Self>, runs: bool, row: &mut Row<'_>) {
        let lacks = (!runs).then(|| format!("`{TWIN}` above 0"));
        row.with(Empty::Unjudged, lacks.as_deref(), |row| Self::report_changes(of, row));
    }

    fn report_changes(of: Option<&Self>, row: &mut Row<'_>) {
        for (at, (name, compared)) in CHANGES.iter().enumerate() {
            row.real(
                name,
                "",
                format_args!(
                    "relative difference of {compared} in a second run whose initial speed is larger by {TWIN} of it: \
                     (twin - own)/own; of several diaphragms the largest. Null without such a run, without a value in \
                     this run, and where one of the two runs is neither ok nor invalid"
                ),
                of.and_then(|twin| twin.changes[at]),
            );
        }
        let status = of.and_then(|twin| STATUS.iter().position(|word| *word == twin.status.word()));
        row.choice("twin_status", STATUS, "status of that second run; null without one", status);
        row.choice(
            "sensitive",
            SENSITIVE,
            &format!(
                "whether one of these differences exceeds {TWIN_LIMIT}, or one of the two runs has a contact, a friction energy or another of these quantities that the other lacks; \
                 null where they are not compared"
            ),
            of.and_then(|twin| twin.sensitive).map(usize::from),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compared(values: [Option<f64>; CHANGES.len()]) -> Compared {
        Compared(values.map(|value| vec![value]))
    }

    #[test]
    fn the_largest_change_makes_a_run_sensitive() {
        let own = [Some(100.0), Some(50.0), Some(10.0), Some(0.0), Some(1e-3), None];
        let with = |at: usize, value: Option<f64>| {
            let mut twin = own;
            twin[at] = value;
            Twin::of(&compared(own), &compared(twin), 0.02, Status::Ok)
        };
        assert_eq!(with(0, Some(101.0)).sensitive, Some(false));
        let impulse = with(2, Some(9.5));
        assert_eq!((impulse.changes[0], impulse.changes[2], impulse.sensitive), (Some(0.0), Some(-0.05), Some(true)));
        assert_eq!((impulse.changes[3], impulse.changes[5]), (None, None), "zero, and nothing to compare");
        // a quantity that only one of the two runs has
        for (at, value, change) in [(1, None, Some(-1.0)), (2, Some(0.0), Some(-1.0)), (3, Some(1.0), None)] {
            let twin = with(at, value);
            assert_eq!((twin.changes[at], twin.sensitive), (change, Some(true)), "{at}");
        }
        assert_eq!(Twin::alone(Status::Failed).sensitive, None);
    }

    #[test]
    fn of_several_diaphragms_the_one_with_the_largest_change_counts() {
        let rings = |forces: [f64; 3]| {
            let mut all = Compared::default();
            all.0[1] = forces.map(Some).to_vec();
            all
        };
        let twin = Twin::of(&rings([10.0, 20.0, 30.0]), &rings([10.1, 19.0, 30.0]), 0.1, Status::Ok);
        assert_eq!((twin.changes[1], twin.sensitive), (Some(-0.05), Some(false)));
    }
}
