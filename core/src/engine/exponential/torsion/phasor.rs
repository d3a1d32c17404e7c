//! Phasor e^{ia} of an angle that changes in small steps.
//!
//! ```text
//! e^{i(a + d)} = e^{ia} e^{id},   e^{id} by its Taylor series for |d| <= 1/10    remainder: d^11/11! < 3e-18 d in the sine, d^10/10! < 3e-17
//! ```
//! A step costs a tenth of a sine and cosine. Each product adds a rounding error, so every sixteenth phasor is evaluated anew, as
//! is one after a larger change. A phasor depends only on the angles of its own run. Verified by
//! `phasors_agree_with_sine_and_cosine`.

use nalgebra::Complex;

/// Largest change of the angle for which the series is used \[rad\].
const MAX_CHANGE: f64 = 0.1;
/// Number of products after which a phasor is evaluated anew.
const MAX_PRODUCTS: u32 = 16;

/// `e^{i angle}`, and the number of products since its last evaluation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Phasor {
    angle: f64,
    pub unit: Complex<f64>,
    products: u32,
}

impl Phasor {
    /// Phasor of an angle \[rad\].
    pub fn of(angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self { angle, unit: Complex::new(cos, sin), products: 0 }
    }

    /// Phasor of another angle \[rad\], by a product with this one where the change is small.
    #[inline(always)]
    pub fn at(&self, angle: f64) -> Self {
        let change = angle - self.angle;
        if self.products >= MAX_PRODUCTS || change.is_nan() || change.abs() > MAX_CHANGE {
            return Self::of(angle);
        }
        Self { angle, unit: self.unit * taylor_series(change), products: self.products + 1 }
    }
}

/// `e^{id}` of a small angle.
#[inline(always)]
fn taylor_series(d: f64) -> Complex<f64> {
    let s = d * d;
    let sin = d + d * s * (-1.0 / 6.0 + s * (1.0 / 120.0 + s * (-1.0 / 5040.0 + s * (1.0 / 362_880.0))));
    let cos = 1.0 + s * (-0.5 + s * (1.0 / 24.0 + s * (-1.0 / 720.0 + s * (1.0 / 40_320.0))));
    Complex::new(cos, sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phasors_agree_with_sine_and_cosine() {
        for change in [1e-9, 3e-4, -0.02, 0.0999, 0.2] {
            let mut phasor = Phasor::of(0.3);
            for n in 1..2000 {
                let angle = 0.3 + change * f64::from(n);
                phasor = phasor.at(angle);
                let (sin, cos) = libm::sincos(angle);
                // an angle of 200 is itself rounded by 3e-14
                assert!((phasor.unit - Complex::new(cos, sin)).norm() < 2e-15 + 2.3e-16 * angle.abs(), "{change} {n}");
            }
        }
    }
}
