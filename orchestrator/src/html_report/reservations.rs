//! Settings that weaken the meaning of `ok`, over the samples of a study: those of the machine files, numbers of modes that are set, and implausible
//! values.

use crate::plausible::implausible_of;
use bladeoff_core::modal::{ModalPart, fewer_modes};
use bladeoff_model::machine::{Machine, Reservation};
use bladeoff_study::{Chosen, Samples};

/// Largest number of samples that are checked.
const MOST: u64 = 1024;
/// Columns on which a small number of torsional modes has an effect.
const TORSIONAL: &[&str] = &["torsional_moment", "shear_stress", "von_mises", "shaft_yield"];

/// Returns the reservations of samples at corners of the axes. Equal settings of several samples are one entry.
#[must_use]
pub fn reservations_of(samples: &Samples) -> Vec<Reservation> {
    let Some(subject) = samples.study().machine() else { return Vec::new() };
    if samples.parameters().is_empty() {
        return subject.def.build().map(|machine| reservations(&machine)).unwrap_or_default();
    }
    let chosen = Chosen::new(samples, MOST);
    let every = (chosen.count() / MOST).max(1) as usize;
    let machines: Vec<Machine> =
        (0..chosen.count()).rev().step_by(every).filter_map(|at| chosen.machine(at).build().ok()).collect();
    let mut found: Vec<(Reservation, usize)> = Vec::new();
    let mut modes: Vec<(ModeNumbers, Vec<Reservation>)> = Vec::new();
    for machine in &machines {
        let numbers = mode_numbers(machine);
        if !modes.iter().any(|(known, _)| *known == numbers) {
            modes.push((numbers, few_modes(machine)));
        }
        let few = modes.iter().find(|(known, _)| *known == numbers).map(|(_, few)| few.clone()).unwrap_or_default();
        for one in machine.reservations().into_iter().chain(few) {
            let key = |of: &Reservation| of.text.split(" = ").next().map(str::to_owned);
            match found.iter_mut().find(|(other, _)| key(other) == key(&one)) {
                Some((_, count)) => *count += 1,
                None => found.push((one, 1)),
            }
        }
    }
    let all = machines.len();
    let text = |text: String, count| if count < all { format!("{text} (in some samples)") } else { text };
    found.into_iter().map(|(one, count)| Reservation { text: text(one.text, count), ..one }).collect()
}

/// Returns the reservations of one machine.
#[must_use]
pub fn reservations(machine: &Machine) -> Vec<Reservation> {
    machine.reservations().into_iter().chain(few_modes(machine)).collect()
}

/// Returns the reservations of a page: the settings, and implausible values.
pub(super) fn reservations_of_page(samples: &Samples) -> Vec<Reservation> {
    let implausible = implausible_of(samples).into_iter();
    let implausible = implausible.map(|text| Reservation { topic: "implausible values", text, columns: &[] });
    reservations_of(samples).into_iter().chain(implausible).collect()
}

/// Keys on which the numbers of modes depend, besides the matrices.
type ModeNumbers = ([Option<usize>; 3], &'static str);

fn mode_numbers(machine: &Machine) -> ModeNumbers {
    let run = &machine.run;
    ([run.rotor_modes, run.torsional_modes, run.ring_modes], run.engine.word())
}

fn few_modes(machine: &Machine) -> Vec<Reservation> {
    // a machine without a basis is rejected before its run
    let few = fewer_modes(machine).unwrap_or_default().into_iter();
    few.map(|few| {
        let (what, columns, effect): (_, &'static [&'static str], _) = match few.part {
            ModalPart::Rotor => ("rotor modes", &[], "results of the rotor and its contact may lack a part"),
            ModalPart::Torsion => (
                "torsional modes",
                TORSIONAL,
                "torsional moments and stresses of the shaft may be many times too small",
            ),
            ModalPart::Rings => ("ring modes", &[], "contact forces and results of the ring may be wrong"),
        };
        let (kept, default) = (few.kept, few.default);
        let text = format!("{what} = {kept} (default {default}): {effect}, and no check of a run finds it");
        Reservation { topic: "modes", text, columns }
    })
    .collect()
}
