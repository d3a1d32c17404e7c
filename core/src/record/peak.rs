//! A largest value, and where it was.

/// When something was: time \[s\] and mean spin \[rad/s\].
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct At {
    pub time: f64,
    pub speed: f64,
}

/// A largest value, and when it was first reached; no value before the first.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Peak {
    pub value: Option<f64>,
    pub at: At,
}

impl Peak {
    /// One that has a value at t = 0 already.
    pub fn at_start(value: f64) -> Self {
        Self { value: Some(value), at: At::default() }
    }

    /// Takes a value of an instant.
    #[inline]
    pub fn see(&mut self, value: f64, at: At) {
        if self.value.is_none_or(|largest| value > largest) {
            *self = Self { value: Some(value), at };
        }
    }

    /// The same peak of a growing function of the quantity: squares and moments are watched, roots and stresses reported.
    pub fn map(self, of: impl FnOnce(f64) -> f64) -> Self {
        Self { value: self.value.map(of), ..self }
    }
}
