//! Modal bases that a machine file makes smaller than their default.
//!
//! Every check of a run compares the solution with the equations of the kept modes; no check detects the contribution of the truncated modes
//! completely. So the number is compared with the default, whose errors are measured (docs/theory/convergence.md). Verified by
//! `fewer_modes_than_the_default_are_found`.

use super::basis::{Basis, BasisError};
use crate::rotor::RotorMatrices;
use crate::stator::RingMatrices;
use bladeoff_model::machine::{DiaphragmKind, Engine, Machine};

/// A part of the machine with fewer modes than by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FewerModes {
    /// The part.
    pub part: ModalPart,
    /// Number of kept modes.
    pub kept: usize,
    /// Number that the default keeps.
    pub default: usize,
}

/// Part of a machine with a modal basis of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModalPart {
    /// Lateral motion of the rotor.
    Rotor,
    /// Torsion of the shaft line; its default number depends on the highest kept frequency of rotor and rings.
    Torsion,
    /// Rings of the diaphragms.
    Rings,
}

/// Returns the parts with fewer modes than by default; empty for an engine without modes, and where the file sets no number.
///
/// # Errors
/// [`BasisError`].
pub fn fewer_modes(machine: &Machine) -> Result<Vec<FewerModes>, BasisError> {
    let run = &machine.run;
    let sets_none = run.rotor_modes.is_none() && run.torsional_modes.is_none() && run.ring_modes.is_none();
    if sets_none || run.engine == Engine::Full {
        return Ok(Vec::new());
    }
    let rotor = RotorMatrices::assemble(&machine.rotor);
    let rings: Vec<RingMatrices> = machine
        .diaphragms
        .iter()
        .filter_map(|diaphragm| match &diaphragm.kind {
            DiaphragmKind::Flexible(stator) => Some(RingMatrices::assemble(stator)),
            _ => None,
        })
        .collect();
    let counts = |machine: &Machine| -> Result<[usize; 3], BasisError> {
        let basis = Basis::compute(machine, &rotor, &rings)?;
        // the rigid rotation is one of the torsional modes
        let torsion = basis.torsion.omega_squared.len().saturating_sub(1);
        let of_rings = basis.rings.iter().map(|ring| ring.omega_squared.len()).min().unwrap_or(0);
        Ok([basis.lateral.omega_squared.len(), torsion, of_rings])
    };
    let mut usual = machine.clone();
    (usual.run.rotor_modes, usual.run.torsional_modes, usual.run.ring_modes) = (None, None, None);
    let (kept, default) = (counts(machine)?, counts(&usual)?);
    let parts = [ModalPart::Rotor, ModalPart::Torsion, ModalPart::Rings];
    let all = parts.into_iter().zip(kept.into_iter().zip(default));
    Ok(all
        .filter(|(_, (kept, default))| kept < default)
        .map(|(part, (kept, default))| FewerModes { part, kept, default })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    const RIG: &str = include_str!("../../../studies/machines/lab_rig.toml");

    fn of(keys: &str) -> Vec<(ModalPart, usize)> {
        let text = RIG.replacen("[run]\n", &format!("[run]\n{keys}\n"), 1);
        let machine = MachineDef::parse("m.toml", &text).and_then(|def| def.build());
        let found = fewer_modes(&machine.unwrap_or_else(|problems| panic!("{problems}"))).expect("solvable");
        assert!(found.iter().all(|one| one.kept < one.default), "{found:?}");
        found.into_iter().map(|one| (one.part, one.kept)).collect()
    }

    #[test]
    fn fewer_modes_than_the_default_are_found() {
        assert_eq!(of(""), []);
        assert_eq!(of("torsional_modes = 1"), [(ModalPart::Torsion, 1)]);
        assert_eq!(of("rotor_modes = 10"), [(ModalPart::Rotor, 10)]);
        // a lower highest frequency of the ring leaves fewer torsional modes
        let few = of("ring_modes = 6");
        assert!(few.iter().map(|one| one.0).eq([ModalPart::Torsion, ModalPart::Rings]) && few[1].1 == 6, "{few:?}");
        for more in ["torsional_modes = 10000", "rotor_modes = 10000", "ring_modes = 10000"] {
            assert_eq!(of(more), [], "{more}");
        }
        assert_eq!(of("torsional_modes = 1\nengine = \"full\""), []);
    }
}
