//! `[run.limit.NAME]`: the limits of the model, and whether the machine has the quantity of each.

use super::reader::Reader;
use crate::machine::model::{Diaphragm, DiaphragmKind, Machine, ModelLimit, OnExceed, Rotor, RotorKind};
use crate::machine::schema::{Need, default_of};
use crate::outcome::Limit;

/// Path of a key of a limit.
fn path(limit: Limit, key: &str) -> String {
    format!("run.limit.{}.{key}", limit.word())
}

pub(super) fn limits(reader: &Reader<'_>) -> Option<[ModelLimit; Limit::ALL.len()]> {
    let read = |limit: Limit| {
        let on_exceed =
            if reader.word(&path(limit, "on_exceed"))? == "note" { OnExceed::Note } else { OnExceed::Beyond };
        Some(ModelLimit { limit, value: reader.number(&path(limit, "value"))?, on_exceed })
    };
    let all: Vec<ModelLimit> = Limit::ALL.into_iter().map(read).collect::<Option<_>>()?;
    all.try_into().ok()
}

const NO_RING: &str = "a diaphragm with a flexible ring";

/// The part or key that a machine needs so that a limit can be checked; `None`: the limit is checked.
fn lacks(limit: Limit, rotor: &Rotor, diaphragms: &[Diaphragm]) -> Option<&'static str> {
    let of_rings = |has: &dyn Fn(bool, Option<f64>) -> bool| {
        diaphragms.iter().any(|diaphragm| match &diaphragm.kind {
            DiaphragmKind::Flexible(stator) => has(stator.blades.is_some(), stator.yield_strength),
            DiaphragmKind::Rigid | DiaphragmKind::RadialSpring { .. } => false,
        })
    };
    let is_point = matches!(rotor.kind, RotorKind::PointMass(_));
    let (has_rings, has_blades) = (of_rings(&|_, _| true), of_rings(&|blades, _| blades));
    let (has, needed) = match limit {
        Limit::RingDisplacement => (has_rings, NO_RING),
        // a missing part has no stress
        Limit::RingYield if !has_rings => (false, NO_RING),
        Limit::BladeYield if !has_blades => (false, "a diaphragm with blades"),
        Limit::ShaftYield if is_point => (false, "a shaft"),
        Limit::RingYield => (of_rings(&|_, strength| strength.is_some()), "diaphragms.NAME.material.yield_strength"),
        Limit::BladeYield => (
            of_rings(&|blades, strength| blades && strength.is_some()),
            "diaphragms.NAME.material.yield_strength of a diaphragm with blades",
        ),
        Limit::ShaftYield => (
            matches!(&rotor.kind, RotorKind::Shaft(shaft) if shaft.elements.iter().any(|e| e.yield_strength.is_some())),
            "rotor.material.yield_strength or rotor.shaft[i].material.yield_strength",
        ),
        Limit::JournalClearance => {
            (rotor.bearings.iter().any(|bearing| bearing.clearance.is_some()), "rotor.bearings.NAME.clearance")
        }
        Limit::UnstableRotor => (true, ""),
    };
    (!has).then_some(needed)
}

impl Machine {
    /// The part or key that this machine needs so that a limit can be checked; `None`: the limit is checked.
    #[must_use]
    pub fn lacks(&self, limit: Limit) -> Option<&'static str> {
        lacks(limit, &self.rotor, &self.diaphragms)
    }
}

/// Rejects a limit that the file sets although the machine lacks its quantity; the limit would have no effect.
pub(super) fn check(reader: &mut Reader<'_>, rotor: Option<&Rotor>, diaphragms: Option<&[Diaphragm]>) {
    let (Some(rotor), Some(diaphragms)) = (rotor, diaphragms) else { return };
    for limit in Limit::ALL {
        if let Some(needed) = lacks(limit, rotor, diaphragms)
            && let Some(set) = set_path(reader, limit)
        {
            let message = format!("{} needs {needed}, which this machine does not have", limit.word());
            reader.fail(&set, message, format!("set {needed}, or delete this limit"));
        }
    }
}

/// Path of a limit's value that differs from its default. A written default has no effect, with or without the quantity.
fn set_path(reader: &Reader<'_>, limit: Limit) -> Option<String> {
    ["value", "on_exceed"].into_iter().map(|key| path(limit, key)).find(|path| match default_of(path) {
        Some(Need::Number(default)) => reader.number(path).is_some_and(|value| value != default),
        Some(Need::Word(default)) => reader.word(path).is_some_and(|word| word != default),
        _ => false,
    })
}
