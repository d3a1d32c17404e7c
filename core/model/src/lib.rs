//! Machines and outcomes: a file's text -> [`machine::MachineDef`] (values that may be varied by path) -> [`machine::Machine`]
//! (validated, SI); and what a run of it comes to: [`outcome::Outcome`], a row of the result table. It knows no matrices, modes or
//! time steps; who computes or varies a machine depends on it.
//!
//! A [`machine::Machine`] has passed every check there is, also that of what is lost against what is there: nobody who builds one can
//! forget a check, and all mistakes of a file come at once.

pub mod machine;
pub mod outcome;
