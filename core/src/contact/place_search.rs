//! Where a contact force acts when it moves the place it acts at.

/// Search for the angle at which a contact force makes its own place the closest one.
///
/// Plain iteration converges by as little as -0.6 a round in heavy rub (the ring slides under the rotor as it is pressed), and
/// not at all beyond -1: the secant through the last two rounds is taken while they stay on one minimum.
#[derive(Default)]
pub(crate) struct PlaceSearch {
    /// Angle used and residual (place found - place used) of the last round.
    last: Option<(f64, f64)>,
    used: Option<f64>,
    jumps: u32,
}

impl PlaceSearch {
    /// The angle to use after `found` was closest; `None` when two minima keep taking turns.
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

/// A contact angle that moves by more than this has changed to another minimum \[rad\].
const JUMP: f64 = 0.02;

/// An angle difference in -pi..pi.
fn wrapped(angle: f64) -> f64 {
    let turn = 2.0 * std::f64::consts::PI;
    angle - turn * (angle / turn).round()
}
