//! Identity of a machine: equal for machines with the same results, however their files are written.
//!
//! ```text
//! identity = h(layout) + sum over all parameters of h(path, value)      modulo 2^128, h: blake3 cut to 128 bits
//! ```
//! The sum keeps identities cheap in a study: changing one value takes one subtraction and one addition, and a varied parameter has the same
//! effect as one in the file. Comments, units, number formats, the machine's name and the order of keys do not affect the identity. The
//! order of bearings and sections does, because columns and sums follow that order. A default and the same value written in a table that
//! exists anyway are equal, unless the default depends on the engine. Texts (`disc` of an unbalance) are included where the file has them.
//!
//! For machines that the exponential engine computes, the identity includes the revision of that engine's results, which the caller passes.
//!
//! All keys are included, so a build with other keys has other identities: its numerics version (of the package `bladeoff-core`) differs.
//!
//! `run.step_limit` is not included, because it is a budget. Runs of one identity agree step by step up to the smaller of their limits. So
//! a store of outcomes by identity has to compare the steps of a run with the limit ([`MachineDef::step_limit`]).

use super::def::MachineDef;
use super::layout::{Layout, Scalar, Slot, State};
use super::paths::PathInfo;
use super::schema::{ENGINE, SCHEMA, STEP_LIMIT};
use super::value::{self, ParamValue, ValueError};

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
        slots.fold(layout_part(&self.layout), sum)
    }

    /// The (wrapping) difference of [`MachineDef::identity`] when a parameter changes from its present value to `value`.
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
        let part = |scalar| part(slot, scalar, exponential_revision);
        Ok(part(&new).wrapping_sub(part(old)))
    }
}

/// Hash of everything that `set` cannot change: tables, sections, lists, and the values of texts.
fn layout_part(layout: &Layout) -> u128 {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&SCHEMA.to_le_bytes());
    let mut word = |text: &str| {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    };
    layout.slots.iter().for_each(|slot| word(&slot.path));
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

fn part(slot: &Slot, scalar: &Scalar, exponential_revision: u8) -> u128 {
    let path = &*slot.path;
    let mut hasher = blake3::Hasher::new();
    hasher.update(path.as_bytes());
    let scalar = if path == STEP_LIMIT { &Scalar::Absent } else { scalar };
    match scalar {
        Scalar::Word(word) if path == ENGINE && *word == "exponential" => {
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
