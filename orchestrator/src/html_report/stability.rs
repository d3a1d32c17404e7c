//! Speeds at which a study's machine is unstable: first the machine as its file and `[set]` define it, then samples at corners of the varied parameters.

use crate::engine;
use crate::terminal::{matrices_of, unstable, with_word};
use bladeoff_core::engine::speeds_of_run;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_study::{Chosen, Samples};

/// Largest number of samples whose damping is computed: each takes about a tenth of a second.
const MOST_LOOKS: usize = 16;
/// Number of samples from which these are chosen.
const MOST_COMPARED: u64 = 64;

/// One line for each unstable range of speeds of the study's machine, and one for the samples at corners; empty if all are stable, or the study has
/// no machine.
#[must_use]
pub fn unstable_of(samples: &Samples) -> Vec<String> {
    let Some(machine) = samples.study().machine().and_then(|machine| machine.def.build().ok()) else {
        return Vec::new();
    };
    with_word(
        || format!("{}, to see at which speeds it is unstable", matrices_of(&machine)),
        || look(samples, &machine),
    )
}

fn look(samples: &Samples, machine: &Machine) -> Vec<String> {
    let mut checked = CheckedMachines::default();
    let mut lines = checked.at(machine).unwrap_or_default();
    if samples.parameters().is_empty() {
        return lines;
    }
    let chosen = Chosen::new(samples, MOST_COMPARED);
    let (mut looked, mut found, mut first) = (0_u64, 0_u64, None);
    // the samples at corners come last
    for at in (0..chosen.count()).rev() {
        let Ok(machine) = chosen.machine(at).build() else { continue };
        let Some(ranges) = checked.at(&machine) else { continue };
        looked += 1;
        if let Some(range) = ranges.into_iter().next() {
            found += 1;
            first.get_or_insert_with(|| format!("{range}, with {}", chosen.describe(at)));
        }
    }
    if let Some(first) = first {
        lines.push(format!(
            "{found} of {looked} samples at corners of what varies are unstable; one of them is {first}"
        ));
    }
    lines
}

/// Machines whose stability has been computed, with their unstable ranges of speeds.
#[derive(Default)]
struct CheckedMachines {
    seen: Vec<(Structure, [u64; 2])>,
}

impl CheckedMachines {
    /// Unstable ranges of a machine over the speeds of its run; `None` if a machine with the same dynamics has been checked, or [`MOST_LOOKS`] is
    /// reached. Unbalance masses are not compared, because they do not change stability.
    fn at(&mut self, machine: &Machine) -> Option<Vec<String>> {
        let speeds = speeds_of_run(machine);
        let bits = speeds.map(f64::to_bits);
        if self.seen.iter().any(|(structure, other)| *other == bits && structure.fits(machine))
            || self.seen.len() == MOST_LOOKS
        {
            return None;
        }
        // the ring modes are reused where the rings are the same
        let structure = match self.seen.last() {
            Some((last, _)) => last.rebuilt(machine).ok()?,
            None => engine::build(machine).ok()?,
        };
        let found = unstable(machine, &structure, speeds);
        self.seen.push((structure, bits));
        Some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_study::load;
    use std::fs;

    fn said(coupling: &str, study: &str) -> Vec<String> {
        let folder = tempfile::tempdir().expect("temporary directory");
        let machine = include_str!("../../../studies/machines/lab_rig.toml");
        let bearing = format!("stiffness = [[2e6, {coupling}], [-{coupling}, 2e6]]");
        fs::write(folder.path().join("m.toml"), machine.replace("stiffness = \"2e6 N/m\"", &bearing)).expect("written");
        let file = folder.path().join("s.toml");
        fs::write(&file, format!("schema = 1\nmachine = \"m.toml\"\n{study}")).expect("written");
        unstable_of(&Samples::new(load(&file, |_| Vec::new()).expect("valid"), None, None).expect("small"))
    }

    #[test]
    fn a_stable_machine_has_no_line_and_an_unstable_one_its_speeds() {
        let study = "[[vary]]\npath = \"contact.friction\"\nfrom = 0.1\nto = 0.3\ncount = 50\n";
        assert_eq!(said("0.0", study), [] as [String; 0]);
        let found = said("3e6", study);
        assert!(found.len() == 1 && found[0].starts_with("unstable between ") && found[0].contains("rpm"), "{found:?}");
    }

    #[test]
    fn a_corner_that_is_unstable_is_found() {
        let study = "[[vary]]\npath = \"rotor.damping.mass_proportional\"\nfrom = 0\nto = 10\ncount = 41\n";
        let found = said("5e5", study);
        assert!(found.len() == 1 && found[0].contains("at corners of what varies are unstable"), "{found:?}");
        assert!(found[0].contains("mass_proportional = 0"), "{found:?}");
    }
}
