//! Spectra of a rotor at single speeds, limited in number for each question.

use std::cell::Cell;

use super::matrices::Reduced;
use super::shape::Mode;
use super::whirl::Lateral;
use bladeoff_numerics::linalg::EigenError;
use bladeoff_text::document::units::format_digits;

/// Error in computing or tracking modes.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModesError {
    /// Failure of an eigenvalue problem.
    #[error(transparent)]
    Eigen(#[from] EigenError),
    /// Modes that change too much from one speed to the next to be identified, even with the smallest steps.
    #[error(
        "the modes change too much with the speed to be followed: after {speeds} speeds they are followed up to {} of \
         {}; is a unit wrong, \
         such as a diameter of 25 m instead of 25 mm?",
        speed(*.reached), speed(*.wanted)
    )]
    Unclear {
        /// Number of evaluated speeds.
        speeds: usize,
        /// Speed up to which the modes were tracked \[rad/s\].
        reached: f64,
        /// Speed up to which the modes had to be tracked \[rad/s\].
        wanted: f64,
    },
}

fn speed(value: f64) -> String {
    format_digits(value, "rad/s", 4)
}

/// Maximum number of evaluated speeds beyond the planned ones (a few seconds of work). The machines of the tests, whose modes can all be
/// tracked, need at most eighty.
const MORE: usize = 1000;

/// Evaluator of spectra during the tracking of modes from rest to the speed `wanted` \[rad/s\].
pub(super) struct Spectra<'a> {
    pub lateral: &'a Lateral,
    /// Reduced basis; `None`: the full model is solved.
    reduced: Option<&'a Reduced>,
    /// Number of evaluated speeds so far.
    taken: Cell<usize>,
    /// Maximum number of evaluated speeds.
    most: usize,
    /// Speed up to which modes are tracked \[rad/s\].
    wanted: f64,
}

impl<'a> Spectra<'a> {
    pub fn new(lateral: &'a Lateral, reduced: Option<&'a Reduced>) -> Self {
        Self { lateral, reduced, taken: Cell::new(0), most: MORE, wanted: 0.0 }
    }

    /// Sets the end of the tracking \[rad/s\] and the number of speeds needed if every match is clear.
    pub fn plan(&mut self, wanted: f64, speeds: usize) {
        (self.wanted, self.most) = (wanted, MORE + speeds);
    }

    /// Returns every solution at a speed. `reached`: speed up to which modes are tracked so far \[rad/s\].
    ///
    /// # Errors
    /// [`ModesError`].
    pub fn spectrum(&self, speed: f64, reached: f64) -> Result<Vec<Mode>, ModesError> {
        let speeds = self.taken.get();
        if speeds >= self.most {
            return Err(ModesError::Unclear { speeds, reached, wanted: self.wanted });
        }
        self.taken.set(speeds + 1);
        Ok(self.lateral.spectrum_in(self.reduced, speed)?)
    }
}
