//! What only grows during a run: a largest value with the place where it was, a sum.
//!
//! Each remembers beside its value what it was when all guards of the run held last ([`super::Recorders::guard`]): that was reached by
//! a motion that may be believed, whatever became of the run.

/// When something was: time \[s\] and mean spin \[rad/s\].
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct At {
    pub time: f64,
    pub speed: f64,
}

/// A largest value, none below zero, and when it was first reached; no value before the first.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Peak {
    pub value: Option<f64>,
    pub at: At,
    /// While all guards held; zero where nothing had been reached.
    pub guarded: f64,
}

impl Peak {
    /// One that has a value at t = 0 already.
    pub fn at_start(value: f64) -> Self {
        Self { value: Some(value), ..Self::default() }
    }

    /// Takes a value of an instant.
    #[inline]
    pub fn see(&mut self, value: f64, at: At) {
        if self.value.is_none_or(|largest| value > largest) {
            (self.value, self.at) = (Some(value), at);
        }
    }

    /// All guards hold.
    #[inline]
    pub fn hold(&mut self) {
        self.guarded = self.value.unwrap_or(0.0);
    }

    /// Takes the peak of another place.
    pub fn include(&mut self, other: &Self) {
        if let Some(value) = other.value {
            self.see(value, other.at);
        }
        self.guarded = self.guarded.max(other.guarded);
    }

    /// The same peak of a growing function of the quantity, zero at zero: squares and moments are watched, roots and stresses reported.
    pub fn map(self, of: impl Fn(f64) -> f64) -> Self {
        Self { value: self.value.map(&of), at: self.at, guarded: of(self.guarded) }
    }
}

/// A sum of what is never negative.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sum {
    pub value: f64,
    /// While all guards held.
    pub guarded: f64,
}

impl Sum {
    /// Sum per unit of another quantity.
    pub fn over(self, by: f64) -> Self {
        Self { value: self.value / by, guarded: self.guarded / by }
    }

    /// All guards hold.
    #[inline]
    pub fn hold(&mut self) {
        self.guarded = self.value;
    }

    /// Adds the sum of another place.
    pub fn include(&mut self, other: &Self) {
        self.value += other.value;
        self.guarded += other.guarded;
    }
}
