//! Student's t, by the incomplete beta function.
//!
//! ```text
//! P(|T| > t) = I_x(nu/2, 1/2),  x = nu/(nu + t^2)
//! ```
//! Source: Abramowitz and Stegun 26.7.1.

use super::beta::beta_quantile;

/// The value of Student's t whose magnitude is exceeded with probability alpha, for the given degrees of freedom.
#[must_use]
pub fn student(freedoms: f64, alpha: f64) -> f64 {
    let (x, y) = beta_quantile(0.5 * freedoms, 0.5, alpha, 1.0 - alpha);
    libm::sqrt(freedoms * y / x)
}
