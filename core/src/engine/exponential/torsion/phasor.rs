//! The direction of an angle that moves on in small turns.
//!
//! ```text
//! e^{i(a + d)} = e^{ia} e^{id},   e^{id} by its Taylor series for |d| <= 1/10, exact to rounding        sin d - ... : d^11/11! < 3e-18 d,  d^10/10! < 3e-17
//! ```
//! A turn costs a tenth of a sine and cosine. Each product adds a rounding, so every sixteenth direction is taken anew, as one after a larger turn is. What a direction is depends
//! on the turns of its own run alone. Verified by `directions_are_those_of_sine_and_cosine`.

use nalgebra::Complex;

/// The largest turn that the series is taken for \[rad\].
const SMALL: f64 = 0.1;
/// Turns from one fresh direction to the next.
const FRESH: u32 = 16;

/// `e^{i angle}`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Phasor {
    angle: f64,
    pub unit: Complex<f64>,
    turns: u32,
}

impl Phasor {
    /// Of an angle \[rad\].
    pub fn of(angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self { angle, unit: Complex::new(cos, sin), turns: 0 }
    }

    /// That of another angle, by way of this one.
    #[inline(always)]
    pub fn at(&self, angle: f64) -> Self {
        let turn = angle - self.angle;
        if self.turns >= FRESH || turn.is_nan() || turn.abs() > SMALL {
            return Self::of(angle);
        }
        Self { angle, unit: self.unit * small(turn), turns: self.turns + 1 }
    }
}

/// `e^{id}` of a small turn.
#[inline(always)]
fn small(d: f64) -> Complex<f64> {
    let s = d * d;
    let sin = d + d * s * (-1.0 / 6.0 + s * (1.0 / 120.0 + s * (-1.0 / 5040.0 + s * (1.0 / 362_880.0))));
    let cos = 1.0 + s * (-0.5 + s * (1.0 / 24.0 + s * (-1.0 / 720.0 + s * (1.0 / 40_320.0))));
    Complex::new(cos, sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_those_of_sine_and_cosine() {
        for turn in [1e-9, 3e-4, -0.02, 0.0999, 0.2] {
            let mut direction = Phasor::of(0.3);
            for n in 1..2000 {
                let angle = 0.3 + turn * f64::from(n);
                direction = direction.at(angle);
                let (sin, cos) = libm::sincos(angle);
                // an angle of 200 is itself rounded by 3e-14
                assert!((direction.unit - Complex::new(cos, sin)).norm() < 2e-15 + 2.3e-16 * angle.abs(), "{turn} {n}");
            }
        }
    }
}
