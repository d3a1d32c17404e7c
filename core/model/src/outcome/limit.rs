//! Limits of the physical model: `[run.limit.NAME]` of a machine file.

use super::Cause;

/// One limit of the physical model. A run exceeds it where the ratio of its quantity to the limit's value is above 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Limit {
    /// (largest eccentricity at the ring - gap) / mean radius of the ring.
    RingDisplacement,
    /// Largest ring stress / yield strength of the ring's material.
    RingYield,
    /// Largest stress of the diaphragm's blades / yield strength of their material.
    BladeYield,
    /// Largest von Mises stress of the shaft / yield strength of its section's material.
    ShaftYield,
    /// Largest displacement of a journal / radial clearance of its bearing.
    JournalClearance,
    /// Largest growth of a whirl mode's amplitude over one of its revolutions: above 1 the mode is unstable.
    UnstableRotor,
}

impl Limit {
    /// Every limit, in the order of the machine file's keys and of the table's columns.
    pub const ALL: [Limit; 6] = [
        Limit::RingDisplacement,
        Limit::RingYield,
        Limit::BladeYield,
        Limit::ShaftYield,
        Limit::JournalClearance,
        Limit::UnstableRotor,
    ];

    /// Cause in a row whose run exceeds this limit.
    #[must_use]
    pub fn cause(self) -> Cause {
        match self {
            Limit::RingDisplacement => Cause::RingDisplacement,
            Limit::RingYield => Cause::RingYield,
            Limit::BladeYield => Cause::BladeYield,
            Limit::ShaftYield => Cause::ShaftYield,
            Limit::JournalClearance => Cause::JournalClearance,
            Limit::UnstableRotor => Cause::UnstableRotor,
        }
    }

    /// The limit of a cause; `None` for a numerical cause.
    #[must_use]
    pub fn of(cause: Cause) -> Option<Self> {
        Self::ALL.into_iter().find(|limit| limit.cause() == cause)
    }

    /// Name in files and tables.
    #[must_use]
    pub fn word(self) -> &'static str {
        self.cause().word()
    }

    /// Quantities that its ratio compares, for the table of columns.
    #[must_use]
    pub fn quantity(self) -> &'static str {
        match self {
            Limit::RingDisplacement => "largest eccentricity at the ring less the gap, over the ring's mean radius",
            Limit::RingYield => "largest ring stress over the yield strength",
            Limit::BladeYield => "largest blade stress over the yield strength",
            Limit::ShaftYield => "largest von Mises stress of the shaft over the yield strength",
            Limit::JournalClearance => "largest journal displacement over the radial clearance of its bearing",
            Limit::UnstableRotor => "largest growth of a whirl mode's amplitude over one of its revolutions",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_limit_has_a_cause_of_its_own() {
        for limit in Limit::ALL {
            assert_eq!(Limit::of(limit.cause()), Some(limit));
        }
        assert_eq!(Limit::of(Cause::Diverged), None);
    }
}
