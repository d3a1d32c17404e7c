//! The words of `status`, `cause` and `end_cause`.

/// An enum whose values have a number and a word stored in records, messages and tables. Values are only added, at the end: a number or
/// word is never removed, changed or reused, so that every record stays readable.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $code:literal, $word:literal;)+ }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u8)]
        pub enum $name { $($(#[$vdoc])* $variant = $code),+ }
        impl $name {
            /// Every value, in the order of its code: 0, 1, 2 ...
            pub const ALL: &'static [$name] = &[$($name::$variant),+];
            /// The word written to tables.
            #[must_use]
            pub fn word(self) -> &'static str { match self { $($name::$variant => $word),+ } }
            /// From the word written to tables.
            #[must_use]
            pub fn from_word(word: &str) -> Option<Self> { match word { $($word => Some($name::$variant),)+ _ => None } }
            /// Code in records and messages.
            #[must_use]
            pub fn code(self) -> u8 { self as u8 }
            /// From the code in records and messages; `None` for an unknown code.
            #[must_use]
            pub fn from_code(code: u8) -> Option<Self> { match code { $($code => Some($name::$variant),)+ _ => None } }
        }
        // Counts are indexed by code, and sets are stored in the bits of a u32.
        const _: () = {
            let mut at = 0;
            while at < $name::ALL.len() {
                assert!($name::ALL[at] as usize == at, "codes are listed in their order, without a gap");
                at += 1;
            }
            assert!(at <= 32, "a set of them has 32 bits");
        };
    };
}

words! {
    /// Usability of a row. Precedence if several apply: quarantined, failed, invalid, beyond, ok.
    Status {
        /// The numerical checks passed and no limit of the model was exceeded.
        Ok = 0, "ok";
        /// Finished, but a numerical check failed; values kept.
        Invalid = 1, "invalid";
        /// Ended early; values up to the end.
        Failed = 2, "failed";
        /// Given up after killing its workers.
        Quarantined = 3, "quarantined";
        /// A limit of the physical model was exceeded ([`super::Limit`]); the numerical checks passed.
        Beyond = 4, "beyond";
    }
}

words! {
    /// Reasons for a status other than `ok`, and exceeded limits of the model. All except those of a worker's end are deterministic: the same
    /// sample gives them again.
    Cause {
        /// The state grew beyond ten times the size of the machine, or the iteration of a step or of the initial state did not converge.
        Diverged = 0, "diverged";
        /// The state became NaN or infinite.
        NonFinite = 1, "non_finite";
        /// Energy balance error above the guard.
        EnergyBalance = 2, "energy_balance";
        /// Normal contact work above the guard.
        NormalWork = 3, "normal_work";
        /// Residual penetration above the guard.
        Penetration = 4, "penetration";
        /// The slip velocity changed sign and the model has no stick.
        SlipReversal = 5, "slip_reversal";
        /// `W <= 0`: the contact force of a step is not unique.
        LossOfUniqueness = 6, "loss_of_uniqueness";
        /// More steps than `run.step_limit`.
        StepLimit = 7, "step_limit";
        /// The solver panicked: a bug, caught by the worker.
        Panicked = 8, "panicked";
        /// Longer than the time limit.
        TimeLimit = 9, "time_limit";
        /// The worker was killed by a signal from another process, repeatedly, while it computed this sample alone.
        WorkerKilled = 10, "worker_killed";
        /// The worker exceeded its memory limit.
        OutOfMemory = 11, "out_of_memory";
        /// The rotor's centre is beyond the ring: no contact can hold it there.
        OutsideRing = 12, "outside_ring";
        /// The worker crashed while it computed this sample alone, more than once.
        WorkerCrashed = 13, "worker_crashed";
        /// The kept modes cannot carry the contact: the truncated modes would not follow the contact force at once.
        ModalBasis = 14, "modal_basis";
        /// At a speed of the run, the whirl states have no basis that the exponential engine can use.
        NoBasis = 15, "no_basis";
        /// Limit of the model: the rotor displaced the ring too far.
        RingDisplacement = 16, "ring_displacement";
        /// Limit of the model: the ring yields.
        RingYield = 17, "ring_yield";
        /// Limit of the model: a blade of the diaphragm yields.
        BladeYield = 18, "blade_yield";
        /// Limit of the model: the shaft yields.
        ShaftYield = 19, "shaft_yield";
        /// Limit of the model: a journal moves farther than the clearance of its bearing.
        JournalClearance = 20, "journal_clearance";
        /// Limit of the model: a whirl mode grows at a speed of the run.
        UnstableRotor = 21, "unstable_rotor";
        /// Impacts shorter than the step can resolve, above the guard.
        UnderResolved = 22, "under_resolved";
        /// Limit of the model: the speed left the range of a bearing's table.
        TableRange = 23, "table_range";
    }
}

words! {
    /// Reason for the end of a run.
    EndCause {
        /// The rotor came to rest.
        Stopped = 0, "stopped";
        /// `run.end_time` was reached.
        EndTime = 1, "end_time";
        /// The spin fell to `run.end_speed`.
        EndSpeed = 2, "end_speed";
        /// The run failed; see `cause`.
        Failure = 3, "failure";
        /// The formulas of a study without a machine were evaluated.
        Evaluated = 4, "evaluated";
        /// A limit of the physical model was exceeded; see `cause`.
        Limit = 5, "limit";
        /// The speed left the range of a bearing's table.
        TableRange = 6, "table_range";
    }
}

impl Cause {
    /// Whether the cause is a property of the sample, so that a retry gives the same result.
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
    /// Bits in records and messages; the bit of a cause is `1 << code`.
    #[must_use]
    pub fn bits(self) -> u32 {
        self.0
    }
    /// From the bits; `None` if one of them is unknown.
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

    /// Codes and words in records of earlier builds. Lines are added here, never changed or removed.
    #[test]
    fn numbers_and_words_at_rest_stay() {
        let statuses = [(0, "ok"), (1, "invalid"), (2, "failed"), (3, "quarantined"), (4, "beyond")];
        let causes = [
            (0, "diverged"),
            (1, "non_finite"),
            (2, "energy_balance"),
            (3, "normal_work"),
            (4, "penetration"),
            (5, "slip_reversal"),
            (6, "loss_of_uniqueness"),
            (7, "step_limit"),
            (8, "panicked"),
            (9, "time_limit"),
            (10, "worker_killed"),
            (11, "out_of_memory"),
            (12, "outside_ring"),
            (13, "worker_crashed"),
            (14, "modal_basis"),
            (15, "no_basis"),
            (16, "ring_displacement"),
            (17, "ring_yield"),
            (18, "blade_yield"),
            (19, "shaft_yield"),
            (20, "journal_clearance"),
            (21, "unstable_rotor"),
            (22, "under_resolved"),
            (23, "table_range"),
        ];
        let end_causes = [
            (0, "stopped"),
            (1, "end_time"),
            (2, "end_speed"),
            (3, "failure"),
            (4, "evaluated"),
            (5, "limit"),
            (6, "table_range"),
        ];
        assert_eq!(statuses.map(|(code, _)| Status::from_code(code).map(Status::word)), statuses.map(|(_, w)| Some(w)));
        assert_eq!(causes.map(|(code, _)| Cause::from_code(code).map(Cause::word)), causes.map(|(_, w)| Some(w)));
        let ends = end_causes.map(|(code, _)| EndCause::from_code(code).map(EndCause::word));
        assert_eq!(ends, end_causes.map(|(_, word)| Some(word)));
        assert!(statuses.iter().all(|&(code, word)| Status::from_word(word).map(Status::code) == Some(code)));
        assert!(causes.iter().all(|&(code, word)| Cause::from_word(word).map(Cause::code) == Some(code)));
        assert!(end_causes.iter().all(|&(code, word)| EndCause::from_word(word).map(EndCause::code) == Some(code)));
        // A new value needs a line above.
        assert_eq!((statuses.len(), causes.len()), (Status::ALL.len(), Cause::ALL.len()));
        assert_eq!(end_causes.len(), EndCause::ALL.len());
        for (code, word) in causes {
            let set = CauseSet::from_bits(1 << code).expect("a bit of ours");
            assert_eq!((set.words().as_deref(), set.bits()), (Some(word), 1 << code));
        }
        // Codes that a newer build may have added are unknown here.
        assert_eq!((Status::from_code(5), Cause::from_code(24), EndCause::from_code(7)), (None, None, None));
        assert_eq!(CauseSet::from_bits(1 << 24), None);
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
