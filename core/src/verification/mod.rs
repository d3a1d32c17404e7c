//! Verification on the user's machine: published reference cases, recomputed and compared.
//!
//! Every reference value comes from the literature, a closed form or another program. The cases use the machine format and the same code as any run.
//! The complete verification is in `core/tests`; this summary of it is part of the program: `bladeoff verify`.

mod annular;
mod case;
mod jeffcott;
mod linear;
mod machine;
mod ring;
mod rub;
mod supports;

pub use case::{Check, NO_RUN};

/// Recomputes every reference case, in well under a minute on one core.
#[must_use]
pub fn verify() -> Vec<Check> {
    let mut checks = Vec::new();
    linear::add(&mut checks);
    ring::add(&mut checks);
    jeffcott::add(&mut checks);
    rub::add(&mut checks);
    annular::add(&mut checks);
    supports::add(&mut checks);
    checks
}
