//! Prescribed speed: its course over time, and the drive that enforces it.

use bladeoff_model::machine::SpeedLaw;
use bladeoff_numerics::linalg::{axpy, dot};

/// Drive that keeps the mean spin at a prescribed speed.
#[derive(Debug, Clone)]
pub(crate) struct Prescribed {
    /// Prescribed speed over time, piecewise linear.
    law: SpeedLaw,
    /// A^-1 s: increments per unit drive torque, which is distributed like the inertia [rad/(N m)].
    direction: Vec<f64>,
    /// s . A^-1 s: increment of the mean spin angle per unit drive torque [rad/(N m)].
    compliance: f64,
    /// Drive torque in the last step \[N m\].
    pub torque: f64,
}

impl Prescribed {
    /// `row` is s, `direction` A^-1 s.
    pub fn new(law: SpeedLaw, row: &[f64], direction: Vec<f64>) -> Self {
        let compliance = dot(row, &direction);
        Self { law, direction, compliance, torque: 0.0 }
    }

    /// Changes the increments so that the mean spin follows the prescribed speed over the step at `time`.
    pub fn impose(&mut self, row: &[f64], time: f64, dt: f64, torsion: &mut [f64]) {
        let wanted = angle_of(&self.law, time + dt) - angle_of(&self.law, time);
        self.torque = (wanted - dot(row, torsion)) / self.compliance;
        axpy(self.torque, &self.direction, torsion);
    }

    /// Removes the mean spin from a torsional response; returns the drive torque required for it.
    pub fn hold(&self, row: &[f64], response: &mut [f64]) -> f64 {
        let lever = -dot(row, response) / self.compliance;
        axpy(lever, &self.direction, response);
        lever
    }

    /// Increment of the mean spin angle by the drive torque in a step \[rad\].
    pub fn driven(&self) -> f64 {
        self.torque * self.compliance
    }

    /// Prescribed speed at `time` \[rad/s\].
    pub fn speed(&self, time: f64) -> f64 {
        speed_of(&self.law, time)
    }

    /// Prescribed angular acceleration at t = 0 \[rad/s2\].
    pub fn initial_slope(&self) -> f64 {
        slope_of(&self.law, 0.0)
    }
}

/// Angle of rotation from 0 to `time` at a prescribed speed \[rad\], exact for a piecewise linear speed.
pub(crate) fn angle_of(law: &SpeedLaw, time: f64) -> f64 {
    let mut angle = 0.0;
    for k in 0..law.times.len() {
        let (t0, w0) = (law.times[k], law.speeds[k]);
        if k + 1 < law.times.len() && time > law.times[k + 1] {
            angle += 0.5 * (w0 + law.speeds[k + 1]) * (law.times[k + 1] - t0);
        } else {
            let slope = slope_of(law, t0);
            return angle + (w0 + 0.5 * slope * (time - t0)) * (time - t0);
        }
    }
    angle
}

/// Prescribed speed at `time` \[rad/s\].
pub(crate) fn speed_of(law: &SpeedLaw, time: f64) -> f64 {
    let last = law.times.iter().rposition(|&start| time >= start).unwrap_or(0);
    law.speeds[last] + slope_of(law, time) * (time - law.times[last])
}

/// Angular acceleration of a prescribed speed at `time` \[rad/s2\], right-hand value at a corner.
fn slope_of(law: &SpeedLaw, time: f64) -> f64 {
    for k in (0..law.times.len()).rev() {
        if time >= law.times[k] {
            return match (law.times.get(k + 1), law.speeds.get(k + 1)) {
                (Some(t1), Some(w1)) => (w1 - law.speeds[k]) / (t1 - law.times[k]),
                _ => 0.0,
            };
        }
    }
    0.0
}
