//! Values of samples, drawn once on all cores and stored for later use.
//!
//! A row has the uncertain and the derived values of a sample, in the order of its parameters. Values of `[[vary]]` are part of the study and
//! are not stored. A value depends on study, seed and sample number alone, so a sample without a row is drawn when needed, with the same
//! bytes.

use bladeoff_system::threads::{ThreadsError, in_parallel};
use rayon::prelude::*;
use std::sync::Arc;

/// Largest size of a table \[bytes\]: for example rows of 1 048 576 samples with 32 values each.
pub const TABLE_BYTES: usize = 256 << 20;

/// Number of rows that a thread draws at a time.
const ROWS_AT_ONCE: usize = 256;

/// Rows of the first samples of a study; clones share them.
#[derive(Debug, Clone)]
pub(super) struct ValueTable {
    width: usize,
    numbers: Arc<Vec<f64>>,
}

impl ValueTable {
    /// A table without rows, for samples with this number of uncertain and derived values.
    pub fn empty(width: usize) -> Self {
        Self { width, numbers: Arc::default() }
    }

    /// Rows of the first of `count` samples, as many as fit in `bytes`; `fill` writes the values of a sample to its row, with the scratch memory of
    /// its thread. If the memory is not available, there are no rows.
    ///
    /// # Errors
    /// The threads cannot be started.
    pub fn draw<S>(
        width: usize,
        count: u64,
        bytes: usize,
        scratch: impl Fn() -> S + Send + Sync,
        fill: impl Fn(u64, &mut S, &mut [f64]) + Send + Sync,
    ) -> Result<Self, ThreadsError> {
        let mut numbers = Vec::new();
        let rows = (bytes / size_of::<f64>()).checked_div(width).unwrap_or(0);
        let length = width * rows.min(usize::try_from(count).unwrap_or(usize::MAX));
        if length == 0 || numbers.try_reserve_exact(length).is_err() {
            return Ok(Self::empty(width));
        }
        numbers.resize(length, 0.0);
        in_parallel(|| {
            let blocks = numbers.par_chunks_mut(width * ROWS_AT_ONCE).enumerate();
            blocks.for_each_init(scratch, |scratch, (block, rows)| {
                for (place, row) in rows.chunks_exact_mut(width).enumerate() {
                    fill((block * ROWS_AT_ONCE + place) as u64, scratch, row);
                }
            });
        })?;
        Ok(Self { width, numbers: Arc::new(numbers) })
    }

    /// The row of a sample; `None`: its values must be drawn.
    pub fn row(&self, sample: u64) -> Option<&[f64]> {
        let start = usize::try_from(sample).ok()?.checked_mul(self.width)?;
        self.numbers.get(start..start.checked_add(self.width)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SampleKey, SampleKeys, Samples, Versions, check_machines, load};
    use bladeoff_model::machine::ParamValue;
    use std::fs;
    use std::path::Path;

    /// Uncertain, varied and derived values, words, and a correlation.
    const STUDY: &str = r#"schema = 1
machine = "rig.toml"
[design]
kind = "monte-carlo"
samples = 300
[[uncertain]]
name = "cold"
distribution = "beta"
a = 2
b = 3
lower = "0.4 mm"
upper = "0.6 mm"
[[uncertain]]
path = "contact.friction"
distribution = "uniform"
lower = 0.1
upper = 0.3
[[uncertain]]
path = "contact.detection"
distribution = "discrete"
values = ["hyp1", "hyp2"]
weights = [1, 2]
[[correlation]]
between = ["cold", "contact.friction"]
rank = 0.5
[[vary]]
name = "growth"
values = [0.9, 1.1]
[[derived]]
path = "contact.gap"
formula = "cold * growth"
"#;

    fn study() -> Samples {
        let folder = tempfile::tempdir().expect("temporary directory");
        let rig = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies/machines/lab_rig.toml");
        fs::copy(rig, folder.path().join("rig.toml")).expect("copied");
        fs::write(folder.path().join("s.toml"), STUDY).expect("written");
        let study = load(&folder.path().join("s.toml"), |_| Vec::new()).unwrap_or_else(|error| panic!("{error}"));
        Samples::new(study, None, None).expect("samples")
    }

    /// Results of every use of a sample in a run: check, key, numbers for a worker, cells of its row.
    fn used(samples: &Samples) -> (String, Vec<(SampleKey, Vec<f64>, Vec<Option<ParamValue>>)>) {
        check_machines(samples).unwrap_or_else(|error| panic!("{error}"));
        let mut keys = SampleKeys::new(samples, Versions { numerics: 4, exponential: 1 }, b"a basis");
        let digest = keys.digest();
        let of = |sample| {
            let mut params = Vec::new();
            samples.params(sample, &mut params);
            (keys.key(sample), params, samples.cells(sample))
        };
        (digest, (0..samples.count()).map(of).collect())
    }

    #[test]
    fn a_sample_of_a_table_is_drawn_once_and_every_other_one_to_the_same_values() {
        let mut kept = study();
        assert_eq!(kept.count(), 600);
        kept.draw().unwrap_or_else(|error| panic!("{error}"));
        let known = used(&kept);
        assert_eq!(kept.drawn(), 600);
        // 100 rows of four numbers
        let (mut short, without) = (study(), study());
        short.draw_into(100 * 4 * 8).unwrap_or_else(|error| panic!("{error}"));
        assert!(used(&short) == known && used(&without) == known);
        // draws by the check of values, that of machines, the digest, numbers and cells: the keys are stored
        assert_eq!([short.drawn(), without.drawn()], [100 + 5 * 500, 5 * 600]);
        let first = known.1[0].1.clone();
        assert!(known.1.iter().skip(1).all(|(_, params, _)| *params != first), "samples differ");
    }

    #[test]
    fn rows_are_those_of_their_samples_as_far_as_the_memory_reaches() {
        let fill = |sample: u64, (): &mut (), row: &mut [f64]| {
            row.iter_mut().enumerate().for_each(|(place, number)| *number = (10 * sample + place as u64) as f64);
        };
        let table = ValueTable::draw(3, 1000, 1 << 20, || (), fill).expect("threads");
        for sample in [0, 1, 255, 256, 999] {
            let first = (10 * sample) as f64;
            assert_eq!(table.row(sample), Some(&[first, first + 1.0, first + 2.0][..]));
        }
        assert_eq!(table.row(1000), None);
        assert_eq!(table.row(u64::MAX), None);
        let short = ValueTable::draw(3, 1000, 3 * 8 * 10 + 23, || (), fill).expect("threads");
        assert_eq!(short.row(9), table.row(9));
        assert_eq!(short.row(10), None);
        assert_eq!(ValueTable::draw(3, 1000, 23, || (), fill).expect("threads").row(0), None);
        assert_eq!(ValueTable::empty(0).row(5), Some(&[][..]), "nothing is to be drawn");
        assert_eq!(ValueTable::empty(1).row(0), None);
    }
}
