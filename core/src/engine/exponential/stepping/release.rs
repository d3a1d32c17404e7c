//! Release of an unbalance: the motion continues in the modal basis of a machine with its mass.

use super::free_motion::{FreeMotion, Start, TRIAL_STEP};
use super::shared_model::SharedModel;
use super::transient::Transient;
use crate::engine::exponential::ExponentialError;
use crate::engine::exponential::modal::propagator::Propagator;
use crate::engine::exponential::settings::StepSettings;
use crate::engine::exponential::torsion::spin::Spin;
use crate::engine::shaft_line::PieceMotion;
use crate::rotor::UnbalanceSite;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;

/// Release of one unbalance.
pub(crate) struct Release<'a> {
    /// The machine without the mass and with it.
    pub before: &'a Machine,
    pub after: &'a Machine,
    /// The unbalance at its node.
    pub site: &'a UnbalanceSite,
    /// Time from the release to the present instant \[s\].
    pub late: f64,
}

impl FreeMotion {
    /// Motion of the place of a mass at n. Accelerations are differences over a trial step.
    fn piece(&mut self, structure: &Structure, site: &UnbalanceSite) -> PieceMotion {
        let h = TRIAL_STEP * self.step;
        let mut ahead = self.clone();
        (ahead.step, ahead.trial) = (h, Some(Propagator::new(&self.interval.model, self.spin.unbalance_count(), h)));
        ahead.spin_steps.clear();
        ahead.propagate_first();
        let rows = structure.rotor.plane_places(site.node).map(|dof| structure.lateral.coordinates.row(dof));
        let [mut q, mut v, mut next] = [(); 3].map(|()| Vec::new());
        self.lateral_coordinates(&mut q);
        self.lateral_rates(&mut v);
        ahead.lateral_rates(&mut next);
        let at = |of: &[f64]| [0, 1].map(|axis| rows[axis].iter().zip(of).map(|(row, part)| row * part).sum::<f64>());
        let (velocity, after) = (at(&v), at(&next));
        let ([psi, rate], [_, next_rate]) = (self.spin.arm(structure, site), ahead.spin.arm(structure, site));
        PieceMotion {
            node: [at(&q), velocity, [0, 1].map(|axis| (after[axis] - velocity[axis]) / h)],
            angle: [psi, rate, self.spin.slope() + (next_rate - rate) / h],
        }
    }

    /// The motion behind a release, and the energy of the mass at it \[J\].
    ///
    /// # Errors
    /// [`ExponentialError`] of a machine without a modal basis.
    fn released(
        &mut self,
        release: &Release<'_>,
        structure: &Structure,
        settings: StepSettings,
    ) -> Result<(Self, f64), ExponentialError> {
        let Release { before, after, site, late } = *release;
        let piece = self.piece(structure, site);
        let singular = ExponentialError::Singular { part: "the rotor" };
        let jump = piece.jump(site, before, structure).ok_or(singular)?.times(late);
        let [mut q, mut v] = [(); 2].map(|()| Vec::new());
        self.lateral_coordinates(&mut q);
        self.lateral_rates(&mut v);
        q.truncate(jump.lateral.len());
        v.truncate(jump.lateral.len());
        v.iter_mut().zip(&jump.lateral).for_each(|(rate, jump)| *rate += jump);
        let mut spin = Spin::new(after, structure)?;
        spin.take_over(&self.spin, structure, &jump.torsion)?;
        let shared = SharedModel::of(after, structure, settings)?;
        let start = Start { motion: [q, v], spin, contact_steps: self.contact_steps(), table_work: self.table_work() };
        let motion = Self::begin(after, structure, settings, shared, start)?;
        Ok((motion, piece.energy(site, before.rotor.gravity, late)))
    }
}

impl Transient {
    /// Releases an unbalance at n; returns the energy of its mass at the release \[J\].
    ///
    /// # Errors
    /// [`ExponentialError`] of a machine without a modal basis.
    pub fn release(&mut self, release: &Release<'_>, structure: &Structure) -> Result<f64, ExponentialError> {
        let settings = StepSettings::of_step(self.contact_step());
        let (motion, energy) = self.free_motion.released(release, structure, settings)?;
        self.free_motion = motion;
        let h = self.contact_step();
        for contact in &mut self.contacts {
            contact.follow(release.after, structure, &self.free_motion, h);
        }
        self.follow_release(release.after);
        Ok(energy)
    }
}
