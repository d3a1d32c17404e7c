//! Section loads of the shaft at n: bending moments are evaluated only where their bound exceeds the largest value of their section so far.

use super::nodal_motion::NodalMotion;
use crate::engine::exponential::modal::row_batch::RowBatch;
use crate::engine::exponential::modal::section_loads::SECTIONS_AT_ONCE;
use crate::engine::exponential::stepping::free_motion::FreeMotion;
use crate::engine::motion::{DIVERGED, size};
use crate::engine::torques::TruncatedTorsion;
use crate::record::{At, Recorders};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::Cause;
use bladeoff_numerics::linalg::axpy;

/// Section loads of the shaft of a run.
pub(crate) struct ShaftStresses {
    /// Torsional moment of each element per torsional modal coordinate.
    torsion: RowBatch,
    /// Static correction of the torsional moments for a train of impulses at each diaphragm, per angular impulse \[1/s\].
    static_corrections: Vec<Vec<f64>>,
    /// Torsion of the truncated modes, and torsional moment of each element per torque over time.
    truncated: TruncatedTorsion,
    of_truncated: Vec<Vec<f64>>,
    /// Torsional moments \[N m\].
    moments: Vec<f64>,
    /// Bounds of the bending moments of each block of sections \[N m\], and of the displacements \[m\].
    bounds: Vec<f64>,
    /// Contact step \[s\].
    step: f64,
    /// Displacement beyond which a run has diverged \[m\].
    reach: f64,
}

impl ShaftStresses {
    /// Section loads of a run in contact steps of `step` \[s\].
    pub fn new(
        machine: &Machine,
        structure: &Structure,
        free_motion: &FreeMotion,
        recorders: &Recorders,
        step: f64,
    ) -> Self {
        let torsion_angles: Vec<Vec<f64>> =
            (0..structure.rotor.nodes).map(|node| free_motion.spin().torsion_row(structure, node)).collect();
        let torsion = RowBatch::new(&recorders.torsional_rows(&torsion_angles));
        let static_correction = |diaphragm: usize| {
            let mut moments = Vec::new();
            torsion.multiply(&free_motion.spin().static_correction(diaphragm, step), &mut moments);
            moments
        };
        let static_corrections = (0..machine.diaphragms.len()).map(static_correction).collect();
        let reach = DIVERGED * size(machine);
        let truncated = TruncatedTorsion::new(machine, structure);
        let of_truncated = truncated.at(0.0).map(|(_, angles)| {
            let rows: Vec<Vec<f64>> = angles.iter().map(|angle| vec![*angle]).collect();
            recorders.torsional_rows(&rows).as_slice().to_vec()
        });
        let of_truncated = of_truncated.collect();
        Self {
            torsion,
            static_corrections,
            truncated,
            of_truncated,
            moments: Vec::new(),
            bounds: Vec::new(),
            step,
            reach,
        }
    }

    /// Records the torsional moments at n.
    pub fn update_torsion(&mut self, free_motion: &FreeMotion, recorders: &mut Recorders, at: At) {
        let Self { torsion, static_corrections, truncated, of_truncated, moments, .. } = self;
        torsion.multiply(free_motion.spin().torsional_amplitudes(), moments);
        for (torque, static_correction) in free_motion.spin().impulse_torques().iter().zip(static_corrections) {
            axpy(*torque, static_correction, moments);
        }
        // without torsional modes there is no torsional moment
        moments.resize(recorders.elements(), 0.0);
        for ((torque, _), part) in truncated.at(free_motion.time()).zip(&*of_truncated) {
            axpy(torque, part, moments);
        }
        recorders.see_torsion(moments, at);
    }

    /// Records the moments at n that may be larger than those before.
    ///
    /// # Errors
    /// [`Cause::NonFinite`] and [`Cause::Diverged`] of a motion that cannot be.
    pub fn update(
        &mut self,
        free_motion: &mut FreeMotion,
        recorders: &mut Recorders,
        structure: &Structure,
        at: At,
    ) -> Result<(), Cause> {
        self.update_torsion(free_motion, recorders, at);
        let Self { moments, bounds, .. } = self;
        free_motion.moment_bounds(bounds);
        let blocks = recorders.elements().div_ceil(SECTIONS_AT_ONCE);
        let (rows, modal_state) = free_motion.moment_rows();
        for (block, (bound, torsion)) in bounds[..blocks].iter().zip(moments.chunks(SECTIONS_AT_ONCE)).enumerate() {
            let first = SECTIONS_AT_ONCE * block;
            let elements = first..first + torsion.len();
            if recorders.asks_for_bending(elements.clone(), *bound, torsion) {
                recorders.see_bending(elements, &rows.multiply_block(block, modal_state), torsion, at);
            }
        }
        let reach = bounds[blocks];
        if !reach.is_finite() {
            return Err(Cause::NonFinite);
        }
        // a bound: the displacements themselves decide
        if reach > self.reach {
            let mut nodal_motion = NodalMotion::new(structure, free_motion.spin(), self.step);
            nodal_motion.take(free_motion, structure);
            if nodal_motion.nodal.iter().any(|x| x.abs() > self.reach) {
                return Err(Cause::Diverged);
            }
        }
        Ok(())
    }
}
