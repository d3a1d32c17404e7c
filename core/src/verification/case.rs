//! A number of a reference case beside its reference.

/// Engine of a number that no run has a part in: a frequency, a static displacement, a probability.
pub const NO_RUN: &str = "-";

/// One number of a reference case.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// The case.
    pub case: &'static str,
    /// Engine of the run that the number is read from; [`NO_RUN`] where there is none.
    pub engine: &'static str,
    /// What is compared.
    pub quantity: String,
    /// Computed here; `None` if the case could not be computed.
    pub ours: Option<f64>,
    /// Reference.
    pub reference: f64,
    /// Largest relative difference that the source supports.
    pub tolerance: f64,
    /// Unit of both, "" for a pure number.
    pub unit: &'static str,
    /// Where the reference comes from.
    pub source: &'static str,
}

impl Check {
    /// Relative difference; `None` if there is no number to compare.
    #[must_use]
    pub fn error(&self) -> Option<f64> {
        let ours = self.ours.filter(|value| value.is_finite())?;
        Some((ours - self.reference).abs() / self.reference.abs())
    }

    /// Whether ours agrees with the reference.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.error().is_some_and(|error| error <= self.tolerance)
    }
}

/// Name, engine, unit, source and tolerance that the numbers of one case share.
#[derive(Debug, Clone, Copy)]
pub(super) struct Case {
    pub name: &'static str,
    pub engine: &'static str,
    pub unit: &'static str,
    pub source: &'static str,
    pub tolerance: f64,
}

impl Case {
    /// Adds one number.
    pub fn check(&self, checks: &mut Vec<Check>, quantity: impl Into<String>, ours: Option<f64>, reference: f64) {
        let Case { name: case, engine, unit, source, tolerance } = *self;
        checks.push(Check { case, engine, quantity: quantity.into(), ours, reference, tolerance, unit, source });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_is_off_or_missing_does_not_hold() {
        let check = |ours| Check {
            case: "c",
            engine: NO_RUN,
            quantity: "q".into(),
            ours,
            reference: 2.0,
            tolerance: 1e-3,
            unit: "",
            source: "s",
        };
        assert!(check(Some(2.001)).holds() && !check(Some(2.01)).holds());
        assert!(!check(None).holds() && !check(Some(f64::NAN)).holds());
    }
}
