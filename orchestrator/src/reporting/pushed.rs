//! Rings that the rows of a study pushed beyond small displacements: such runs may be consistent to the last joule and still be those of another
//! machine, and they are the worst of a study.
//!
//! ```text
//! pushed = largest eccentricity - gap  >  share x mean radius      per diaphragm that was touched, of rows with status ok
//! ```
//! Gap and radius are those of the row's own sample. Rows whose eccentricity is within the share of the radius alone need no machine.

use crate::report::{BEYOND_SMALL, pushed_share};
use bladeoff_answers::report::counted;
use bladeoff_answers::tables::{Table, TableError};
use bladeoff_core::record::columns;
use bladeoff_model::document::units::format_digits;
use bladeoff_model::machine::{DiaphragmKind, Machine};
use bladeoff_study::Samples;
use std::path::PathBuf;

/// What a ring's radius, or whether it is one, varies by.
const VARIES: [&str; 2] = ["mean_radius", ".kind"];

/// Rows that pushed a ring too far.
#[derive(Debug, Default, PartialEq)]
struct Pushed {
    ok: u64,
    beyond: u64,
    /// Sample, way \[m\] and share of the radius of the one that pushed farthest.
    farthest: Option<(u64, f64, f64)>,
}

/// The line about them, at the end of a summary; empty where there is none.
///
/// # Errors
/// A table that cannot be read.
pub fn pushed_rings(samples: &Samples, files: &[PathBuf]) -> Result<String, TableError> {
    let Some(first) = machine_of(samples, 0) else { return Ok(String::new()) };
    let names: Vec<String> = columns(&first).into_iter().map(|column| column.name).collect();
    let is_asked = |name: &&String| name.ends_with("max_eccentricity_m") || name.ends_with("first_contact_s");
    let asked: Vec<&str> = names.iter().filter(is_asked).map(String::as_str).collect();
    if asked.is_empty() {
        return Ok(String::new());
    }
    let columns: Vec<&str> = ["sample", "status"].into_iter().chain(asked.iter().copied()).collect();
    let near = within_any_radius(samples, &first);
    let mut found = Pushed::default();
    Table::for_each_piece(files, &columns, |piece| {
        found.add(piece, samples, &names, near);
        Ok(())
    })?;
    Ok(found.text())
}

impl Pushed {
    /// `names`: those of all columns of an outcome. `near`: eccentricity \[m\] that is within the share of any ring's radius.
    fn add(&mut self, piece: &Table, samples: &Samples, names: &[String], near: f64) {
        let columns: Vec<Option<&[Option<f64>]>> = names.iter().map(|name| piece.numbers(name)).collect();
        let (status, number) = (piece.words("status").unwrap_or(&[]), piece.numbers("sample").unwrap_or(&[]));
        for row in (0..piece.rows()).filter(|&row| status.get(row).is_some_and(|word| word.as_deref() == Some("ok"))) {
            self.ok += 1;
            let values: Vec<Option<f64>> = columns.iter().map(|column| column.and_then(|column| column[row])).collect();
            let eccentric = |(name, value): (&String, &Option<f64>)| {
                name.ends_with("max_eccentricity_m") && value.is_some_and(|value| value > near)
            };
            let Some(sample) = number.get(row).copied().flatten().map(|number| number as u64) else { continue };
            if sample >= samples.count() || !names.iter().zip(&values).any(eccentric) {
                continue;
            }
            let shares = machine_of(samples, sample).map(|machine| pushed_share(&machine, &values)).unwrap_or_default();
            let most = shares.into_iter().flatten().max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((way, share)) = most.filter(|(_, share)| *share > BEYOND_SMALL) else { continue };
            self.beyond += 1;
            if self.farthest.is_none_or(|(.., most)| share > most) {
                self.farthest = Some((sample, way, share));
            }
        }
    }

    fn text(&self) -> String {
        let Some((sample, way, share)) = self.farthest else { return String::new() };
        format!(
            "{} of {} with status ok pushed a ring beyond small displacements (by more than {:.0} % of its radius; sample {sample} farthest: {}, {:.0} %). The \
             ring's equations are linear and do not hold there: that such a run is bad can be believed, how bad cannot.\n",
            self.beyond,
            counted(self.ok, "row"),
            100.0 * BEYOND_SMALL,
            format_digits(way, "m", 3),
            100.0 * share
        )
    }
}

/// The machine of a sample; of an earlier build's study it may be none.
fn machine_of(samples: &Samples, sample: u64) -> Option<Machine> {
    samples.try_machine(sample).ok().flatten()?.build().ok()
}

/// Eccentricity \[m\] that no ring of the study minds, whatever its gap.
fn within_any_radius(samples: &Samples, first: &Machine) -> f64 {
    if samples.parameters().iter().any(|varied| VARIES.iter().any(|path| varied.info.path.contains(path))) {
        return 0.0;
    }
    let radii = first.diaphragms.iter().filter_map(|diaphragm| match &diaphragm.kind {
        DiaphragmKind::Flexible(stator) => Some(stator.ring.mean_radius),
        _ => None,
    });
    BEYOND_SMALL * radii.fold(f64::INFINITY, f64::min)
}
