//! Quantities that never decrease during a run: the largest value of a quantity with its time, and sums.
//!
//! Each quantity also keeps its value at the last instant at which all guards of the run held ([`super::Recorders::guard`]). This guarded
//! value comes from valid motion, regardless of how the run ended.

/// Time \[s\] and mean spin \[rad/s\] of an event.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct At {
    /// Time \[s\].
    pub time: f64,
    /// Mean spin \[rad/s\].
    pub speed: f64,
}

/// Largest value of a non-negative quantity, with the time and speed at which it was first reached; no value before the first observation.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Peak {
    /// Largest value; `None` before the first observation.
    pub value: Option<f64>,
    /// Time and speed at which the value was first reached.
    pub at: At,
    /// Largest value while all guards held; zero if there was no value.
    pub guarded: f64,
}

impl Peak {
    /// Peak with a value at t = 0.
    pub fn at_start(value: f64) -> Self {
        Self { value: Some(value), ..Self::default() }
    }

    /// Records the value at an instant.
    #[inline]
    pub fn see(&mut self, value: f64, at: At) {
        if self.value.is_none_or(|largest| value > largest) {
            (self.value, self.at) = (Some(value), at);
        }
    }

    /// Marks the value reached so far as guarded.
    #[inline]
    pub fn hold(&mut self) {
        self.guarded = self.value.unwrap_or(0.0);
    }

    /// Merges the peak of another position.
    pub fn include(&mut self, other: &Self) {
        if let Some(value) = other.value {
            self.see(value, other.at);
        }
        self.guarded = self.guarded.max(other.guarded);
    }

    /// Applies a monotonically increasing function that is zero at zero. Recorders keep squares and moments; the table shows their roots
    /// and stresses.
    pub fn map(self, of: impl Fn(f64) -> f64) -> Self {
        Self { value: self.value.map(&of), at: self.at, guarded: of(self.guarded) }
    }
}

/// Sum of a non-negative quantity.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sum {
    /// Sum so far.
    pub value: f64,
    /// Sum while all guards held.
    pub guarded: f64,
}

impl Sum {
    /// Divides the sum by another quantity.
    pub fn over(self, by: f64) -> Self {
        Self { value: self.value / by, guarded: self.guarded / by }
    }

    /// Marks the sum reached so far as guarded.
    #[inline]
    pub fn hold(&mut self) {
        self.guarded = self.value;
    }

    /// Adds the sum of another position.
    pub fn include(&mut self, other: &Self) {
        self.value += other.value;
        self.guarded += other.guarded;
    }
}
