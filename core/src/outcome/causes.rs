//! The words of `status`, `cause` and `end_cause` (architecture.md, decision 6).

macro_rules! words {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $word:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u8)]
        pub enum $name { $($(#[$vdoc])* $variant),+ }
        impl $name {
            /// Every value, in the order of its code.
            pub const ALL: &'static [$name] = &[$($name::$variant),+];
            /// The word written to tables.
            #[must_use]
            pub fn word(self) -> &'static str { match self { $($name::$variant => $word),+ } }
            /// From the word written to tables.
            #[must_use]
            pub fn from_word(word: &str) -> Option<Self> { match word { $($word => Some($name::$variant),)+ _ => None } }
            /// Code in messages.
            #[must_use]
            pub fn code(self) -> u8 { self as u8 }
            /// From the code in messages; `None` for a code that is not ours.
            #[must_use]
            pub fn from_code(code: u8) -> Option<Self> { Self::ALL.get(usize::from(code)).copied() }
        }
    };
}

words! {
    /// Whether a row may be believed.
    Status {
        /// Finished and within the validity guard.
        Ok = "ok",
        /// Finished, not to be believed; values kept.
        Invalid = "invalid",
        /// Ended early; values so far.
        Failed = "failed",
        /// Given up after it killed its workers.
        Quarantined = "quarantined",
    }
}

words! {
    /// Why a row is not `ok`. All but those of a worker's end are deterministic: the same sample gives them again.
    Cause {
        /// The state grew beyond ten times the size of the machine, or the iteration of a step, or of the start, did not settle.
        Diverged = "diverged",
        /// The state became NaN or infinite.
        NonFinite = "non_finite",
        /// Energy balance error above the guard.
        EnergyBalance = "energy_balance",
        /// Normal contact work above the guard.
        NormalWork = "normal_work",
        /// Residual penetration above the guard.
        Penetration = "penetration",
        /// The slip velocity changed sign and the model has no stick.
        SlipReversal = "slip_reversal",
        /// `W <= 0`: the contact force of a step is not unique.
        LossOfUniqueness = "loss_of_uniqueness",
        /// More steps than `run.step_limit`.
        StepLimit = "step_limit",
        /// The solver panicked: a bug, caught by the worker.
        Panicked = "panicked",
        /// Longer than the time limit.
        TimeLimit = "time_limit",
        /// The worker was killed from outside, again and again, while it computed this sample alone.
        WorkerKilled = "worker_killed",
        /// The worker exceeded its memory limit.
        OutOfMemory = "out_of_memory",
        /// The rotor's centre is beyond the ring: no contact can hold it there.
        OutsideRing = "outside_ring",
        /// The worker crashed while it computed this sample alone, more than once.
        WorkerCrashed = "worker_crashed",
        /// The modes kept cannot carry the contact: those left out would not follow it at once.
        ModalBasis = "modal_basis",
    }
}

words! {
    /// Why a run ended.
    EndCause {
        /// The rotor came to rest.
        Stopped = "stopped",
        /// `run.end_time` was reached.
        EndTime = "end_time",
        /// The spin fell to `run.end_speed`.
        EndSpeed = "end_speed",
        /// The run failed; see `cause`.
        Failure = "failure",
    }
}

impl Cause {
    /// Deterministic causes belong to the sample's bytes and are never retried.
    #[must_use]
    pub fn is_deterministic(self) -> bool {
        !matches!(self, Cause::TimeLimit | Cause::WorkerKilled | Cause::OutOfMemory | Cause::WorkerCrashed)
    }
}

/// A set of causes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CauseSet(u32);

impl CauseSet {
    /// Adds a cause.
    pub fn insert(&mut self, cause: Cause) {
        self.0 |= 1 << cause.code();
    }
    /// Whether the cause is in the set.
    #[must_use]
    pub fn contains(self, cause: Cause) -> bool {
        self.0 & (1 << cause.code()) != 0
    }
    /// The causes in the order of their codes.
    pub fn iter(self) -> impl Iterator<Item = Cause> {
        Cause::ALL.iter().copied().filter(move |&cause| self.contains(cause))
    }
    /// Bits in messages.
    #[must_use]
    pub fn bits(self) -> u32 {
        self.0
    }
    /// From the bits in messages; `None` if a bit is not ours.
    #[must_use]
    pub fn from_bits(bits: u32) -> Option<Self> {
        (bits >> Cause::ALL.len() == 0).then_some(Self(bits))
    }
    /// The words joined by commas, as in the column `causes`; `None` for the empty set.
    #[must_use]
    pub fn words(self) -> Option<String> {
        (self.0 != 0).then(|| self.iter().map(Cause::word).collect::<Vec<_>>().join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_codes_go_there_and_back() {
        for &cause in Cause::ALL {
            assert_eq!(Cause::from_word(cause.word()), Some(cause));
            assert_eq!(Cause::from_code(cause.code()), Some(cause));
        }
        assert_eq!(Cause::from_code(200), None);
        assert_eq!(EndCause::from_word("end_time"), Some(EndCause::EndTime));
    }

    #[test]
    fn a_set_names_its_causes_in_order() {
        let mut set = CauseSet::default();
        assert_eq!(set.words(), None);
        set.insert(Cause::SlipReversal);
        set.insert(Cause::NormalWork);
        assert_eq!(set.words().as_deref(), Some("normal_work,slip_reversal"));
        assert_eq!(CauseSet::from_bits(set.bits()), Some(set));
        assert_eq!(CauseSet::from_bits(1 << 31), None);
    }
}
