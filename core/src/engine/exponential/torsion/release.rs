//! Spin and torsion at the release of an unbalance: the same rotation in the loaded modes of another machine.

use super::spin::Spin;
use crate::engine::exponential::ExponentialError;
use crate::rotor::UnbalanceSite;
use crate::structure::Structure;

impl Spin {
    /// Angle of an arm that turns with a node \[rad\], and its rate \[rad/s\].
    pub fn arm(&self, structure: &Structure, site: &UnbalanceSite) -> [f64; 2] {
        let row = self.rotation_row(structure, site.torsional_node);
        let [turn, rate] =
            [self.torsion.displacement(), self.torsion.rate()].map(|of| bladeoff_numerics::linalg::dot(&row, of));
        [self.angle + turn + site.phase, self.speed + rate]
    }

    /// Takes over the rotation of another spin, with a change of its rates in torsional coordinates. [`Spin::start`] follows.
    ///
    /// # Errors
    /// [`ExponentialError::Singular`] where the torsional modes are dependent.
    pub fn take_over(&mut self, other: &Self, structure: &Structure, change: &[f64]) -> Result<(), ExponentialError> {
        let (modes, torsion) = (&other.loaded_modes, &other.torsion);
        let (mean, bare) = modes.to_bare(other.angle, torsion.displacement());
        let (mut mean_rate, mut bare_rate) = modes.to_bare(other.speed, torsion.rate());
        modes.add_to_bare(structure, change, (&mut mean_rate, &mut bare_rate));
        let (angle, displacement) = self.loaded_modes.of_bare(mean, &bare)?;
        let (speed, rate) = self.loaded_modes.of_bare(mean_rate, &bare_rate)?;
        self.torsion.start(&displacement, &rate, torsion.dissipation());
        (self.angle, self.speed, self.next_angle, self.next_speed) = (angle, speed, angle, speed);
        (self.slope, self.slope_without_impulse) = (other.slope, other.slope_without_impulse);
        self.braking_work = other.braking_work;
        if let (Some(drive), Some(other)) = (&mut self.drive, &other.drive) {
            drive.take_over(other);
        }
        if let (Some(torques), Some(other)) = (&mut self.torques, &other.torques) {
            torques.take_over(other);
        }
        self.place_unbalances();
        self.update_forces();
        Ok(())
    }
}
