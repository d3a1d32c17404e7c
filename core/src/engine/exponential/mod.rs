//! The exponential engine: exact propagation, flight in large steps, contact by impulses.
//!
//! Main path: a [`Flight`] is begun from the motion at t = 0 and advanced in steps of any size. Its lateral motion (`system`) is taken
//! apart into `pairs` of motions at the speeds of a `grid` (a `station` each, a `transfer` from one to the next), so that a step (`propagator`) is a 2 x 2
//! `block` for each pair. The `spin` follows from its momentum, the twist in closed form (`oscillators`). What a run reads of the motion are its `outputs`.
//! A `transient` flies where nothing can touch (`bound`), as far as no peak is `missed` (both seen by an `outlook`), and takes contact steps where something may: a `rub` finds the impulses between
//! the `candidates` of a `kicked_ring` and the rotor, which they `kick`. A `run` watches it to its end, by what is `measured` of the whirl states in `forms`, whose `tables` it mixes in each cell; an `eye` sees its
//! instants for a follower, with its energies `apart`.
//!
//! Theory, measurements and limits: docs/theory/08-exponential-engine.md.

mod contact;
mod modal;
mod observe;
mod plane;
mod settings;
mod stepping;
mod torsion;

pub use settings::StepSettings;
pub use stepping::free_motion::FreeMotion;
pub use stepping::free_run::{FreeRun, free_run};
pub use stepping::rubbing_run::{RubbingRun, rubbing_run};
pub use stepping::shared_model::same_bases;

pub(super) use modal::grid_spacing::GridSpacing;
pub(super) use modal::modal_basis::MOST_CONDITION;
pub(super) use observe::run::run;

use super::plan::StartError;
use crate::linalg::EigenError;
use bladeoff_model::outcome::Cause;

/// A machine that the exponential engine cannot compute.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExponentialError {
    /// A basis in which rounding would be multiplied too much.
    #[error("the whirl states at {speed} rad/s have a basis of condition {condition:.1e}, above {limit:.0e}")]
    IllConditioned {
        /// Speed \[rad/s\].
        speed: f64,
        /// 2-norm condition.
        condition: f64,
        /// Largest allowed.
        limit: f64,
    },
    /// Pairs that do not go on in themselves.
    #[error("the whirl states at {speed} rad/s do not fall into pairs")]
    NotInvariant {
        /// Speed \[rad/s\].
        speed: f64,
    },
    /// Motions that are not a basis.
    #[error("the motions at {speed} rad/s are not a basis of all whirl states")]
    NoBasis {
        /// Speed \[rad/s\].
        speed: f64,
    },
    /// A matrix without an inverse.
    #[error("the mass matrix of {part} is singular")]
    Singular {
        /// Which part.
        part: &'static str,
    },
    /// Contact impulses that nothing solves.
    #[error("no contact impulses fulfil the conditions of a step")]
    NoImpulses,
    /// What only other engines compute.
    #[error("the exponential engine does not cover {what}: use run.engine = \"reduced\"")]
    NotCovered {
        /// What.
        what: &'static str,
    },
    /// No start.
    #[error(transparent)]
    Start(#[from] StartError),
    /// Eigenvalue problem of a basis.
    #[error(transparent)]
    Eigen(#[from] EigenError),
}

impl From<ExponentialError> for Cause {
    /// Of a run that cannot go on.
    fn from(error: ExponentialError) -> Self {
        match error {
            ExponentialError::NoImpulses => Self::LossOfUniqueness,
            _ => Self::NoBasis,
        }
    }
}
