//! Comparison of one computed value of a reference case with its reference value.

/// Engine entry of a value that needs no run: a frequency, a static displacement, a probability.
pub const NO_RUN: &str = "-";

/// One value of a reference case.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// Name of the case.
    pub case: &'static str,
    /// Engine of the run that gave the value; [`NO_RUN`] if there is no run.
    pub engine: &'static str,
    /// Quantity that is compared.
    pub quantity: String,
    /// Computed value; `None` if the case could not be computed.
    pub ours: Option<f64>,
    /// Reference value.
    pub reference: f64,
    /// Largest relative difference that the accuracy of the source allows.
    pub tolerance: f64,
    /// Unit of both values, "" for a pure number.
    pub unit: &'static str,
    /// Source of the reference value.
    pub source: &'static str,
}

impl Check {
    /// Relative difference; `None` if there is no computed value.
    #[must_use]
    pub fn error(&self) -> Option<f64> {
        let ours = self.ours.filter(|value| value.is_finite())?;
        Some((ours - self.reference).abs() / self.reference.abs())
    }

    /// Whether the computed value agrees with the reference.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.error().is_some_and(|error| error <= self.tolerance)
    }
}

/// Name, engine, unit, source and tolerance shared by the values of one case.
#[derive(Debug, Clone, Copy)]
pub(super) struct Case {
    /// Name of the case.
    pub name: &'static str,
    /// Engine of the runs, or [`NO_RUN`].
    pub engine: &'static str,
    /// Unit of the values.
    pub unit: &'static str,
    /// Source of the reference values.
    pub source: &'static str,
    /// Largest relative difference that the accuracy of the source allows.
    pub tolerance: f64,
}

impl Case {
    /// Adds one value.
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
