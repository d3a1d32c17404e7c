//! Place of a contact force if the force itself moves that place.

/// Search for the angle at which a contact force makes its own place the closest one.
///
/// Fixed-point iteration contracts by as little as -0.6 per round in heavy rub, because the ring slides under the rotor when pressed, and diverges
/// beyond -1. The secant through the last two rounds is used while they stay on one minimum.
#[derive(Default)]
pub(crate) struct PlaceSearch {
    /// Angle used and residual (place found - place used) of the last round \[rad\].
    last: Option<(f64, f64)>,
    /// Angle to use in the present round \[rad\].
    used: Option<f64>,
    /// Number of changes to another minimum.
    jumps: u32,
}

impl PlaceSearch {
    /// Next angle to use after `found` was closest; `None` if two minima keep alternating.
    pub fn next(&mut self, found: f64) -> Option<f64> {
        let Some(used) = self.used else {
            self.used = Some(found);
            return Some(found);
        };
        let residual = wrapped(found - used);
        if residual.abs() > JUMP {
            self.jumps += 1;
            if self.jumps > 4 {
                return None;
            }
            (self.last, self.used) = (None, Some(found));
            return self.used;
        }
        let plain = used + residual;
        let next = match self.last {
            Some((before, residual_before)) if (residual - residual_before).abs() > 0.2 * residual_before.abs() => {
                let secant = used - residual * wrapped(used - before) / (residual - residual_before);
                if wrapped(secant - used).abs() <= 5.0 * residual.abs() { secant } else { plain }
            }
            _ => plain,
        };
        self.last = Some((used, residual));
        self.used = Some(next);
        self.used
    }
}

/// Change of the contact angle beyond which it belongs to another minimum \[rad\].
const JUMP: f64 = 0.02;

/// Angle difference in -pi to pi \[rad\].
fn wrapped(angle: f64) -> f64 {
    let turn = 2.0 * std::f64::consts::PI;
    angle - turn * (angle / turn).round()
}
