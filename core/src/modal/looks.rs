//! Looks at a rotor at single speeds, of which a question is worth only so many.

use std::cell::Cell;

use super::matrices::Reduced;
use super::shape::Mode;
use super::whirl::Lateral;
use bladeoff_numerics::linalg::EigenError;
use bladeoff_text::document::units::format_digits;

/// Why modes were not found, or not followed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModesError {
    /// An eigenvalue problem.
    #[error(transparent)]
    Eigen(#[from] EigenError),
    /// From one speed to the next they change so much that it is not clear which is which, however small the steps.
    #[error(
        "the modes change too much with the speed to be followed: after a look at {looks} speeds they are followed up to {} of {}; is a unit wrong, \
         such as a diameter of 25 m instead of 25 mm?",
        speed(*.reached), speed(*.wanted)
    )]
    Unclear {
        /// Speeds looked at.
        looks: usize,
        /// How far they were followed \[rad/s\].
        reached: f64,
        /// How far they were to be \[rad/s\].
        wanted: f64,
    },
}

fn speed(value: f64) -> String {
    format_digits(value, "rad/s", 4)
}

/// Looks beyond those planned that a way is worth: seconds. Of the machines of the tests, whose modes can all be followed, the worst takes
/// eighty.
const MORE: usize = 1000;

/// A rotor at single speeds, on the way from rest to another one.
pub(super) struct Looks<'a> {
    pub lateral: &'a Lateral,
    reduced: Option<&'a Reduced>,
    taken: Cell<usize>,
    most: usize,
    wanted: f64,
}

impl<'a> Looks<'a> {
    pub fn new(lateral: &'a Lateral, reduced: Option<&'a Reduced>) -> Self {
        Self { lateral, reduced, taken: Cell::new(0), most: MORE, wanted: 0.0 }
    }

    /// The way leads to this speed, with so many looks where all is clear.
    pub fn plan(&mut self, wanted: f64, looks: usize) {
        (self.wanted, self.most) = (wanted, MORE + looks);
    }

    /// Every solution at a speed. `reached`: how far the way is.
    ///
    /// # Errors
    /// [`ModesError`].
    pub fn spectrum(&self, speed: f64, reached: f64) -> Result<Vec<Mode>, ModesError> {
        let looks = self.taken.get();
        if looks >= self.most {
            return Err(ModesError::Unclear { looks, reached, wanted: self.wanted });
        }
        self.taken.set(looks + 1);
        Ok(self.lateral.spectrum_in(self.reduced, speed)?)
    }
}
