//! A look at the shaft's moments at n: those that may be larger than what their sections have had.

use super::eights::Eights;
use super::flight::Flight;
use super::measured::BESIDE;
use super::shape::Shape;
use crate::engine::motion::{DIVERGED, size};
use crate::linalg::axpy;
use crate::record::{At, Recorders};
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_model::outcome::Cause;

/// Looks at the shaft of a run.
pub(super) struct ShaftLook {
    /// Torsional moments of the shaft's elements, on the modes of twist.
    torsion: Eights,
    /// Moments that a train of impulses lacks, per angular impulse.
    lacking: Vec<f64>,
    /// Torsional moments at the last look \[N m\].
    moments: Vec<f64>,
    bounds: Vec<f64>,
    /// Contact step \[s\].
    step: f64,
    /// Largest displacement that is believed \[m\].
    reach: f64,
}

impl ShaftLook {
    /// Looks of a run in contact steps of `step` \[s\]; `touches`: with something to touch.
    pub fn new(
        machine: &Machine,
        structure: &Structure,
        flight: &Flight,
        recorders: &Recorders,
        (step, touches): (f64, bool),
    ) -> Self {
        let twists: Vec<Vec<f64>> =
            (0..structure.rotor.nodes).map(|node| flight.spin().twist_of(structure, node)).collect();
        let torsion = Eights::new(&recorders.torsional_rows(&twists));
        let mut lacking = Vec::new();
        if touches {
            torsion.times(&flight.spin().lacking(step), &mut lacking);
        }
        let reach = DIVERGED * size(machine);
        Self { torsion, lacking, moments: Vec::new(), bounds: Vec::new(), step, reach }
    }

    /// Takes moments at n that may be larger than those before.
    ///
    /// # Errors
    /// [`Cause::NonFinite`] and [`Cause::Diverged`] of a motion that nothing believes.
    pub fn see(
        &mut self,
        flight: &mut Flight,
        recorders: &mut Recorders,
        structure: &Structure,
        at: At,
    ) -> Result<(), Cause> {
        let Self { torsion, lacking, moments, bounds, .. } = self;
        torsion.times(flight.spin().twist(), moments);
        axpy(flight.spin().blow(), lacking, moments);
        // without torsional modes there is no torsional moment
        moments.resize(recorders.elements(), 0.0);
        recorders.see_torsion(moments, at);
        flight.bounds(bounds);
        let blocks = recorders.elements().div_ceil(BESIDE);
        for (block, bound) in bounds[..blocks].iter().enumerate() {
            let elements = BESIDE * block..recorders.elements().min(BESIDE * (block + 1));
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
            let mut shape = Shape::new(structure, flight.spin(), self.step);
            shape.take(flight, structure);
            if shape.nodal.iter().any(|x| x.abs() > self.reach) {
                return Err(Cause::Diverged);
            }
        }
        Ok(())
    }
}
