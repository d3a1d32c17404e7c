//! Quantities that stepping and observers read of the spin: rates, energies, torsion of the nodes, and the stability of a step.

use super::spin::Spin;
use super::unbalance::Unbalance;
use crate::structure::Structure;
use bladeoff_model::machine::Braking;
use nalgebra::Complex;

/// Sum of the feedback over a whole run below which growth is negligible.
const NEGLIGIBLE_FEEDBACK: f64 = 0.1;

impl Spin {
    /// Spin after a time, extrapolated with its slope \[rad/s\].
    pub fn speed_after(&self, time: f64) -> f64 {
        self.rotor_rotation()[0] + time * self.slope
    }

    /// Rate at which the part of the braking torque that depends on the spin slows it at n, dT/dW over J \[1/s\].
    pub fn braking_rate(&self, braking: &Braking) -> f64 {
        braking.largest_slope(self.speed) / self.loaded_modes.inertia
    }

    /// Relative error of the predicted spin that is expected at the end of a step of `h` \[s\].
    pub fn prediction_error(&self, h: f64) -> f64 {
        h * h * self.slope_rate / self.speed
    }

    /// Shift of the spin per change of the gyroscopic momentum \[1/(kg m2)\].
    pub fn gyroscopic_compliance(&self) -> f64 {
        1.0 / (self.loaded_modes.inertia + self.loaded_modes.compliance_inertia.iter().sum::<f64>())
    }

    /// Kinetic and potential energy of spin, unbalances and torsion \[J\] at a shifted spin; of the unbalances the part that
    /// their masses on the nodes do not have. `velocities`: those of their nodes \[m/s\].
    pub fn energies(&self, shift: f64, velocities: &[[f64; 2]]) -> [f64; 2] {
        let speed = self.speed + shift;
        let mut kinetic = match &self.drive {
            None => 0.5 * self.loaded_modes.inertia * speed * speed,
            Some(drive) => drive.energy(speed, self.unbalances.iter().map(|unbalance| unbalance.rate)),
        };
        let mut potential = 0.0;
        for (s, (unbalance, &velocity)) in self.unbalances.iter().zip(velocities).enumerate() {
            let unit = unbalance.phasor.at(unbalance.angle).unit;
            let [whirl_part, _] = unbalance.exchange(unit, unbalance.rate, velocity, [0.0; 2]);
            kinetic +=
                (unbalance.rate + shift) * (0.5 * self.compliance_momentum(s, |other| other.rate + shift) + whirl_part);
            potential -= unbalance.moment * (self.gravity[0] * unit.re + self.gravity[1] * unit.im);
        }
        let torsion = self.torsion.energies();
        [kinetic + torsion[0], potential + torsion[1]]
    }

    /// Amplitudes of the torsional modes \[rad (kg m2)^0.5\].
    pub fn torsional_amplitudes(&self) -> &[f64] {
        self.torsion.displacement()
    }

    /// Static correction of the torsional modes for a train of contact impulses on a diaphragm's node at intervals of `h` \[s\], in
    /// amplitudes per angular impulse.
    pub fn static_correction(&self, diaphragm: usize, h: f64) -> Vec<f64> {
        self.torsion.static_correction(diaphragm, h)
    }

    /// Angular impulse of the contact at each diaphragm in the last step \[N m s\].
    pub fn impulse_torques(&self) -> &[f64] {
        self.torsion.impulses()
    }

    /// Writes the torsion of nodes \[rad\] with these rows of [`Spin::torsion_row`].
    pub fn torsion_angles(&self, rows: &[Vec<f64>], angles: &mut [f64]) {
        for (angle, row) in angles.iter_mut().zip(rows) {
            *angle = self.torsion.along(row);
        }
    }

    /// Feedback of the unbalances on the torsion over a step: the part of the predicted change of their rates that returns,
    /// because the step does not resolve the whole lateral response. `responses`: mean velocity of each node over the step per
    /// impulse on it \[1/kg\].
    pub fn feedback(&self, responses: impl Iterator<Item = f64>) -> f64 {
        let of = |((s, unbalance), response): ((usize, &Unbalance), f64)| {
            (self.loaded_modes.compliance_inertia[(s, s)] - unbalance.moment * unbalance.moment * response).abs()
                * self.rate_jump(self.torsion.row(s), self.torsion.row(s))
        };
        self.unbalances.iter().enumerate().zip(responses).map(of).sum()
    }

    /// Whether no torsional mode grows in steps of `h` \[s\] with this feedback: the damping of each mode that the step does not
    /// resolve is above the feedback, or the feedback is negligible over a run of `time` \[s\].
    pub fn is_stable(&self, h: f64, feedback: f64, time: f64) -> bool {
        let is_damped = |&(square, damping): &(f64, f64)| square * h * h < 1.0 || 0.5 * damping * h >= feedback;
        feedback <= 1.0 && (feedback * time < NEGLIGIBLE_FEEDBACK * h || self.loaded_modes.modes.iter().all(is_damped))
    }

    /// Mean spin of the rotor without unbalances \[rad/s\] and its angle \[rad\]: those that are reported and that brakes act on.
    pub fn rotor_rotation(&self) -> [f64; 2] {
        let [angle, speed] = self.torsion.at_row(self.unbalances.len());
        [self.speed + speed, self.angle + angle]
    }

    /// Energy that the damping of the torsion has dissipated so far \[J\].
    pub fn torsional_dissipation(&self) -> f64 {
        self.torsion.dissipation()
    }

    /// Row of a node on the torsional modes: its torsion per amplitude, zeros up to a multiple of eight.
    pub fn torsion_row(&self, structure: &Structure, node: usize) -> Vec<f64> {
        self.loaded_modes.torsion_row(structure, node)
    }

    /// Row of a node's rotation beside the mean angle of rotor and unbalances, per amplitude, zeros up to a multiple of eight.
    pub fn rotation_row(&self, structure: &Structure, node: usize) -> Vec<f64> {
        self.loaded_modes.row(structure, node)
    }

    /// Energy that brakes have dissipated so far \[J\].
    pub fn braking_work(&self) -> f64 {
        self.braking_work
    }

    /// Circular frequency of the lowest torsional mode \[rad/s\]; 0 without one.
    pub fn lowest_torsional_rate(&self) -> f64 {
        self.loaded_modes.lowest_square().sqrt()
    }

    /// Work of the torques over time so far \[J\].
    pub fn torque_work(&self) -> f64 {
        self.torques.as_ref().map_or(0.0, |torques| torques.work)
    }

    /// Work of the drive of a prescribed speed so far \[J\].
    pub fn drive_work(&self) -> f64 {
        self.drive.as_ref().map_or(0.0, |drive| drive.work)
    }

    /// Whether a run ends where the rotor stops: the speed is not prescribed, and the rotor did not start at rest.
    pub fn can_stop(&self) -> bool {
        self.drive.is_none() && !self.starts_at_rest
    }

    /// Whether the rotor starts at rest without a drive.
    pub fn starts_at_rest(&self) -> bool {
        self.starts_at_rest
    }

    /// Number of unbalances.
    pub fn unbalance_count(&self) -> usize {
        self.unbalances.len()
    }

    /// Slope of the spin over the last step \[rad/s2\].
    pub fn slope(&self) -> f64 {
        self.slope
    }

    /// Forces of the unbalances at n \[N\].
    pub fn forces_now(&self) -> impl Iterator<Item = Complex<f64>> {
        self.unbalances.iter().map(|unbalance| unbalance.force)
    }
}
