//! A look at the shaft's moments at n: those that may be larger than what their sections have had.

use super::nodal_motion::NodalMotion;
use crate::engine::exponential::modal::row_batch::RowBatch;
use crate::engine::exponential::modal::section_loads::SECTIONS_AT_ONCE;
use crate::engine::exponential::stepping::free_motion::FreeMotion;
use crate::engine::motion::{DIVERGED, size};
use crate::linalg::axpy;
use crate::record::{At, Recorders};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::Cause;

/// Looks at the shaft of a run.
pub(crate) struct ShaftStresses {
    /// Torsional moments of the shaft's elements, on the modes of twist.
    torsion: RowBatch,
    /// Moments that a train of impulses lacks, per angular impulse.
    static_correction: Vec<f64>,
    /// Torsional moments at the last look \[N m\].
    moments: Vec<f64>,
    bounds: Vec<f64>,
    /// Contact step \[s\].
    step: f64,
    /// Largest displacement that is believed \[m\].
    reach: f64,
}

impl ShaftStresses {
    /// Looks of a run in contact steps of `step` \[s\]; `touches`: with something to touch.
    pub fn new(
        machine: &Machine,
        structure: &Structure,
        flight: &FreeMotion,
        recorders: &Recorders,
        (step, touches): (f64, bool),
    ) -> Self {
        let twists: Vec<Vec<f64>> =
            (0..structure.rotor.nodes).map(|node| flight.spin().torsion_row(structure, node)).collect();
        let torsion = RowBatch::new(&recorders.torsional_rows(&twists));
        let mut lacking = Vec::new();
        if touches {
            torsion.multiply(&flight.spin().static_correction(step), &mut lacking);
        }
        let reach = DIVERGED * size(machine);
        Self { torsion, static_correction: lacking, moments: Vec::new(), bounds: Vec::new(), step, reach }
    }

    /// Takes moments at n that may be larger than those before.
    ///
    /// # Errors
    /// [`Cause::NonFinite`] and [`Cause::Diverged`] of a motion that nothing believes.
    pub fn update(
        &mut self,
        flight: &mut FreeMotion,
        recorders: &mut Recorders,
        structure: &Structure,
        at: At,
    ) -> Result<(), Cause> {
        let Self { torsion, static_correction: lacking, moments, bounds, .. } = self;
        torsion.multiply(flight.spin().torsional_amplitudes(), moments);
        axpy(flight.spin().impulse_torque(), lacking, moments);
        // without torsional modes there is no torsional moment
        moments.resize(recorders.elements(), 0.0);
        recorders.see_torsion(moments, at);
        flight.moment_bounds(bounds);
        let blocks = recorders.elements().div_ceil(SECTIONS_AT_ONCE);
        for (block, bound) in bounds[..blocks].iter().enumerate() {
            let elements = SECTIONS_AT_ONCE * block..recorders.elements().min(SECTIONS_AT_ONCE * (block + 1));
            let torsion = &moments[elements.clone()];
            if recorders.asks_for_bending(elements.clone(), *bound, torsion) {
                recorders.see_bending(elements, &flight.moments(block), torsion, at);
            }
        }
        let reach = bounds[blocks];
        if !reach.is_finite() {
            return Err(Cause::NonFinite);
        }
        // what it bounds is looked at where it might be too far
        if reach > self.reach {
            let mut shape = NodalMotion::new(structure, flight.spin(), self.step);
            shape.take(flight, structure);
            if shape.nodal.iter().any(|x| x.abs() > self.reach) {
                return Err(Cause::Diverged);
            }
        }
        Ok(())
    }
}
