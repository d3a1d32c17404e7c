//! Tables for the observations of a run in its speed interval, interpolated between the two modal bases when they are first needed.
//!
//! A run owns its tables and overwrites them from interval to interval. The tables of all intervals would take about 50 kB each, more than the processor caches hold;
//! the tables of the two bases stay in the caches, and interpolation takes a fifth of the time (docs/theory/08-exponential-engine.md).
//! Verified by `an_interpolated_table_is_that_of_its_interval`.

use super::dissipation::Dissipation;
use super::modal_basis::LateralModel;
use super::quadratic_form::QuadraticForm;
use super::row_batch::{Interpolate, RowBatch};
use super::speed_interval::SpeedInterval;

/// Interpolated value with the index of its speed interval; `None` before the first interpolation.
#[derive(Debug, Clone, Default)]
struct Interpolated<T> {
    interval: Option<i64>,
    value: T,
}

impl<T: Interpolate> Interpolated<T> {
    /// Value in an interval, given by its index and the shares of its two bases.
    fn of(&mut self, (interval, shares): (i64, [f64; 2]), bases: [&T; 2]) -> &T {
        if self.interval != Some(interval) {
            self.value.interpolate(bases, shares);
            self.interval = Some(interval);
        }
        &self.value
    }
}

/// Tables of a run, for the intervals of one grid and one contact step.
#[derive(Debug, Clone, Default)]
pub(crate) struct IntervalTables {
    momentum: Interpolated<QuadraticForm>,
    bounds: Interpolated<RowBatch>,
    bearings: Interpolated<RowBatch>,
    moments: Interpolated<RowBatch>,
    displacements: Interpolated<RowBatch>,
    velocities: Interpolated<RowBatch>,
    dissipation: Interpolated<Dissipation>,
}

impl IntervalTables {
    /// Gyroscopic momentum as a quadratic form of the modal state \[kg m2/s\].
    pub fn momentum(&mut self, interval: &SpeedInterval) -> &QuadraticForm {
        self.momentum.of(interval.interpolation(), interval.bases.each_ref().map(|basis| &basis.gyroscopic_momentum))
    }

    /// Bounds of bending moments and displacements ([`super::section_loads::SectionLoads::bounds`]).
    pub fn bounds(&mut self, interval: &SpeedInterval, model: &LateralModel) -> &RowBatch {
        self.bounds.of(interval.interpolation(), interval.section_loads(model).map(|at| &at.bounds))
    }

    /// Rows of the bearing motion.
    pub fn bearings(&mut self, interval: &SpeedInterval, model: &LateralModel) -> &RowBatch {
        self.bearings.of(interval.interpolation(), interval.section_loads(model).map(|at| &at.bearings))
    }

    /// Rows of the bending moments.
    pub fn moments(&mut self, interval: &SpeedInterval, model: &LateralModel) -> &RowBatch {
        self.moments.of(interval.interpolation(), interval.section_loads(model).map(|at| &at.moments))
    }

    /// Rows of the lateral coordinates q.
    pub fn displacements(&mut self, interval: &SpeedInterval, model: &LateralModel) -> &RowBatch {
        self.displacements.of(interval.interpolation(), interval.section_loads(model).map(|at| &at.motion[0]))
    }

    /// Rows of the velocities q'.
    pub fn velocities(&mut self, interval: &SpeedInterval, model: &LateralModel) -> &RowBatch {
        self.velocities.of(interval.interpolation(), interval.section_loads(model).map(|at| &at.motion[1]))
    }

    /// Dissipation over contact steps of `h` \[s\].
    pub fn dissipation(&mut self, interval: &SpeedInterval, model: &LateralModel, h: f64) -> &Dissipation {
        self.dissipation
            .of(interval.interpolation(), interval.bases.each_ref().map(|basis| basis.dissipation(model, h)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_numerics::linalg::Matrix;

    #[test]
    fn an_interpolated_table_is_that_of_its_interval() {
        let value = |i: usize, j: usize| ((i * 7 + j * 3) % 11) as f64 - 4.0;
        let [one, other] = [0, 5].map(|n| Matrix::from_fn(13, 9, |i, j| value(i + n, j)));
        let y: Vec<f64> = (0..9).map(|i| value(i, 2)).collect();
        let mut table = Interpolated::<RowBatch>::default();
        let rows = [RowBatch::new(&one), RowBatch::new(&other)];
        // back and forth between intervals, as with a spin that oscillates about an edge
        for (interval, share) in [(7, 0.25), (8, 0.75), (7, 0.25), (7, 0.25), (-3, 0.5)] {
            let shares = [1.0 - share, share];
            let (mut found, mut wanted) = (Vec::new(), Vec::new());
            table.of((interval, shares), [&rows[0], &rows[1]]).multiply(&y, &mut found);
            RowBatch::new(&(&one * (1.0 - share) + &other * share)).multiply(&y, &mut wanted);
            assert_eq!(found.len(), wanted.len());
            assert!(found.iter().zip(&wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-12), "{share}");
        }
    }
}
