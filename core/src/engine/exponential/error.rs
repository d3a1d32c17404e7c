//! Machines and steps that the exponential engine cannot compute.

use crate::engine::time_step::StartError;
use bladeoff_model::outcome::Cause;
use bladeoff_numerics::linalg::EigenError;

/// A machine that the exponential engine cannot compute.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExponentialError {
    /// Modal basis in which rounding errors would be amplified too much.
    #[error("the whirl states at {speed} rad/s have a basis of condition {condition:.1e}, above {limit:.0e}")]
    IllConditioned {
        /// Speed \[rad/s\].
        speed: f64,
        /// Condition of the basis, in the 2-norm.
        condition: f64,
        /// Largest allowed condition.
        limit: f64,
    },
    /// Conjugate eigenvectors that span no real invariant plane.
    #[error("the whirl modes at {speed} rad/s do not form pairs")]
    NotInvariant {
        /// Speed \[rad/s\].
        speed: f64,
    },
    /// Eigenmotions that are no basis of all states.
    #[error("the motions at {speed} rad/s are not a basis of all whirl states")]
    NoBasis {
        /// Speed \[rad/s\].
        speed: f64,
    },
    /// A matrix without an inverse.
    #[error("the mass matrix of {part} is singular")]
    Singular {
        /// Part of the machine.
        part: &'static str,
    },
    /// Contact conditions of a step that no impulses fulfil.
    #[error("no contact impulses fulfil the conditions of a step")]
    NoImpulses,
    /// Ring whose displacement under a constant force is not that of its stiffness: a fault of the program.
    #[error(
        "a constant force displaces the ring of diaphragm {diaphragm} by {found:.6e} m/N in contact steps, and by {expected:.6e} m/N by its \
         stiffness: an internal error, please report it with the machine"
    )]
    StaticCompliance {
        /// Name of the diaphragm.
        diaphragm: String,
        /// Radial displacement per force in contact steps \[m/N\].
        found: f64,
        /// Radial displacement per force by the stiffness of ring and blades \[m/N\].
        expected: f64,
    },
    /// Feature that only other engines compute.
    #[error("the exponential engine does not cover {what}: use run.engine = \"reduced\"")]
    NotCovered {
        /// Name of the feature.
        what: &'static str,
    },
    /// Machine whose run cannot start.
    #[error(transparent)]
    Start(#[from] StartError),
    /// Eigenvalue problem of a modal basis that did not converge.
    #[error(transparent)]
    Eigen(#[from] EigenError),
}

impl From<ExponentialError> for Cause {
    /// Cause of a run that ends with this error.
    fn from(error: ExponentialError) -> Self {
        match error {
            ExponentialError::NoImpulses => Self::LossOfUniqueness,
            _ => Self::NoBasis,
        }
    }
}
