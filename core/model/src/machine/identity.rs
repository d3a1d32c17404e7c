//! Identity of a machine: equal for machines that compute the same, whatever their files look like.
//!
//! ```text
//! identity = h(layout) + sum over all parameters of h(path, value)      modulo 2^128, h: blake3 cut to 128 bits
//! ```
//! The sum makes it cheap in a study: exchanging one value is one subtraction and one addition, and a parameter that is
//! varied counts like one that the file gives. Comments, units, number formats, the machine's name and the order of keys do
//! not count; the order of bearings and sections does, because columns and sums follow it. A default and the same value
//! written out in a table that is there anyway are equal. Texts (`disc` of an unbalance) count where the file has them.
//!
//! The default of `run.guard.energy_balance` is the engine's: left out it counts as the 1e-6 that was the default of all engines, and as something of its own with
//! the exponential engine (`of_guard`). The revision of that engine's results is part of the identity of the machines that it computes; the caller passes it.
//!
//! A key that came later than results that are kept counts where a machine has it (`LATER`), so that those without it are what they were.
//!
//! `run.step_limit` does not count: it is a budget. Runs of one identity are step for step the same up to the smaller of
//! their limits, so who keeps outcomes by identity has to ask how many steps each needed ([`MachineDef::step_limit`]).

use super::def::MachineDef;
use super::layout::{Layout, Scalar, Slot, State};
use super::paths::PathInfo;
use super::schema::{CONTACT_STEP, ENGINE, SCHEMA, STEP_LIMIT};
use super::value::{self, ParamValue, ValueError};

/// Keys that a machine of an earlier build has not: without a value of its own, such a key does not count.
const LATER: [&str; 11] = [
    CONTACT_STEP,
    "rotor.shaft[i].end_diameter",
    "rotor.shaft[i].end_inner_diameter",
    "rotor.bearings.NAME.kind",
    "rotor.bearings.NAME.interpolation",
    "rotor.bearings.NAME.stiffness_factor",
    "rotor.bearings.NAME.damping_factor",
    "rotor.bearings.NAME.elevation",
    "rotor.bearings.NAME.pedestal.mass",
    "rotor.bearings.NAME.pedestal.stiffness",
    "rotor.bearings.NAME.pedestal.damping",
];
/// The guard whose default is the engine's, and what it was with every engine.
const BALANCE: (&str, f64) = ("run.guard.energy_balance", 1e-6);

impl MachineDef {
    /// Largest number of steps of a run; `None`: no limit.
    #[must_use]
    pub fn step_limit(&self) -> Option<u64> {
        match self.states[self.layout.find(STEP_LIMIT)?].scalar {
            Scalar::Number(steps) => Some(steps as u64),
            Scalar::Absent | Scalar::Bad | Scalar::Word(_) => None,
        }
    }

    /// Computes the identity with the present values; `exponential_revision`: revision of the results of the exponential engine.
    ///
    /// Verified by `identity_ignores_how_a_file_is_written`, `exchanging_a_value_is_setting_it` and
    /// `a_step_limit_is_no_part_of_the_identity`.
    #[must_use]
    pub fn identity(&self, exponential_revision: u8) -> u128 {
        let slots = self.layout.slots.iter().zip(&self.states);
        let sum = |sum: u128, (slot, state): (&Slot, &State)| {
            sum.wrapping_add(part(slot, &state.scalar, exponential_revision))
        };
        slots.fold(layout_part(&self.layout), sum).wrapping_add(of_guard(self.present(ENGINE), self.present(BALANCE.0)))
    }

    /// The present value of a key; `None`: the machine has no such key.
    fn present(&self, path: &str) -> Option<&Scalar> {
        Some(&self.states[self.layout.find(path)?].scalar)
    }

    /// What is to be added (wrapping) to [`MachineDef::identity`] when a parameter gets a value instead of its present one.
    ///
    /// # Errors
    /// As [`MachineDef::set`].
    pub fn identity_change(
        &self,
        path: &PathInfo,
        value: &ParamValue,
        exponential_revision: u8,
    ) -> Result<u128, ValueError> {
        let index = self.index(path)?;
        let slot = &self.layout.slots[index];
        let new = value::check(slot, value)?;
        let old = &self.states[index].scalar;
        let (engine, guard) = (self.present(ENGINE), self.present(BALANCE.0));
        let guarded = match &*slot.path {
            ENGINE => of_guard(Some(&new), guard),
            path if path == BALANCE.0 => of_guard(engine, Some(&new)),
            _ => of_guard(engine, guard),
        };
        let part = |scalar| part(slot, scalar, exponential_revision);
        let change = part(&new).wrapping_sub(part(old));
        Ok(change.wrapping_add(guarded).wrapping_sub(of_guard(engine, guard)))
    }
}

/// What `set` cannot change: which tables, sections and lists there are, and what texts name.
fn layout_part(layout: &Layout) -> u128 {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&SCHEMA.to_le_bytes());
    let mut word = |text: &str| {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    };
    layout.slots.iter().filter(|slot| !LATER.contains(&slot.key.path)).for_each(|slot| word(&slot.path));
    word("tables");
    layout.tables.keys().for_each(|table| word(table));
    for (group, members) in &layout.groups {
        word(group);
        members.iter().for_each(|member| word(&member.name));
    }
    for (path, text) in &layout.texts {
        word(path);
        word(text.value.as_deref().unwrap_or_default());
    }
    cut(&hasher.finalize())
}

fn is_exponential(path: &str, word: &str) -> bool {
    path == ENGINE && word == "exponential"
}

/// What the exponential engine's own default of the guard adds.
fn of_guard(engine: Option<&Scalar>, guard: Option<&Scalar>) -> u128 {
    match (engine, guard) {
        (Some(Scalar::Word(word)), Some(Scalar::Absent)) if is_exponential(ENGINE, word) => {
            cut(&blake3::hash(b"the default of run.guard.energy_balance is that of the exponential engine"))
        }
        _ => 0,
    }
}

fn part(slot: &Slot, scalar: &Scalar, exponential_revision: u8) -> u128 {
    let path = &*slot.path;
    if LATER.contains(&slot.key.path) && *scalar == State::default_of(slot.key).scalar {
        return 0;
    }
    let mut hasher = blake3::Hasher::new();
    hasher.update(path.as_bytes());
    let scalar = if path == STEP_LIMIT { &Scalar::Absent } else { scalar };
    match scalar {
        Scalar::Absent if path == BALANCE.0 => hasher.update(&[0, 1]).update(&BALANCE.1.to_bits().to_le_bytes()),
        Scalar::Word(word) if is_exponential(path, word) => {
            hasher.update(&[0, 2]).update(word.as_bytes()).update(&[exponential_revision])
        }
        Scalar::Absent | Scalar::Bad => hasher.update(&[0, 0]),
        Scalar::Number(number) => hasher.update(&[0, 1]).update(&number.to_bits().to_le_bytes()),
        Scalar::Word(word) => hasher.update(&[0, 2]).update(word.as_bytes()),
    };
    cut(&hasher.finalize())
}

fn cut(hash: &blake3::Hash) -> u128 {
    u128::from_le_bytes(hash.as_bytes()[..16].try_into().expect("a hash has 32 bytes"))
}
