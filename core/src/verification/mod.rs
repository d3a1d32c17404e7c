//! Verification on the user's machine: reference cases from outside, recomputed, ours beside theirs.
//!
//! Every reference number comes from the literature, a closed form or another program, never from this one. The cases go
//! through the machine format and the same code as any run. The full ladder is in `core/tests`; this is its summary that
//! ships with the program: `bladeoff verify`.

mod annular;
mod case;
mod jeffcott;
mod linear;
mod machine;
mod ring;
mod rub;
mod supports;

pub use case::{Check, NO_RUN};

/// Recomputes every reference case; well under a minute on one core.
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
