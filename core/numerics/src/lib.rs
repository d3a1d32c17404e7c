//! Linear algebra and distribution functions, without any reference to machines.
//!
//! Everything here is computed in one order of operations, so that the bytes of a row are the same on every x86-64 processor: dense products, factors and eigenvalue problems
//! ([`linalg`]), the eigenvalues of a correlation matrix ([`CorrelationMatrix`]), and beta, gamma, normal and Student distributions with both tails ([`probability`]).

mod correlation_matrix;
pub mod linalg;
pub mod probability;

pub use correlation_matrix::CorrelationMatrix;
