//! A prescribed speed: its law over time and the drive that keeps the spin on it.

use bladeoff_model::machine::SpeedLaw;

/// Spin increment over a step of a prescribed speed, as a function of the time at its start.
pub(crate) struct Prescribed {
    pub law: SpeedLaw,
    /// A^-1 s: where the drive torque acts, spread like the inertia.
    pub direction: Vec<f64>,
    pub compliance: f64,
    /// Torque of the drive at the last step \[N m\].
    pub torque: f64,
}

/// Angle turned by a prescribed speed until `time` \[rad\], exact for the piecewise linear law.
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

/// A prescribed speed at `time` \[rad/s\].
pub(crate) fn speed_of(law: &SpeedLaw, time: f64) -> f64 {
    let last = law.times.iter().rposition(|&start| time >= start).unwrap_or(0);
    law.speeds[last] + slope_of(law, time) * (time - law.times[last])
}

/// Angular acceleration of a prescribed speed at `time` \[rad/s2\], from the right at a corner.
pub(crate) fn slope_of(law: &SpeedLaw, time: f64) -> f64 {
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
