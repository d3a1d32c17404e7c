//! Distribution functions and their inverses, from which studies draw values and answers compute limits.
//!
//! ```text
//! saddle           terms of the gamma and beta densities without cancellation
//!   beta, gamma    tails by series and fractions, quantiles by Newton's method (root)
//!     student      by beta
//! normal           on the error function of `libm`
//! ```
//! Functions take and return both tail probabilities, p and q = 1 - p, so that neither loses digits. Results have the same bytes everywhere:
//! plain operations in order, functions from `libm`.
//!
//! # Limits
//! Parameters must be above 0 and finite; this is not checked. Quantiles have a relative error of 1e-12 in both tails, down to probabilities of
//! 1e-300, for parameters up to 1e6; beyond, continued fractions that begin close to 1 lose digits in proportion (2e-11 for
//! Student's t with 1e8 degrees of freedom).
//! # Verified by
//! `tests.rs`, against values of 60 digits

mod beta;
mod gamma;
mod normal;
mod root;
mod saddle;
mod student;
#[cfg(test)]
mod tests;

pub use beta::{Beta, beta_quantile, beta_tails};
pub use gamma::{gamma_quantile, gamma_tails};
pub use normal::{normal_quantile, normal_tails};
pub use student::student;
