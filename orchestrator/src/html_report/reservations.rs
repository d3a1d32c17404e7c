//! Settings that weaken what `ok` promises, over the samples of a study.

use bladeoff_model::machine::{Machine, Reservation};
use bladeoff_study::{Chosen, Samples};

/// Samples that are looked at, beside the machine of the study.
const MOST: u64 = 1024;

/// Returns the reservations of samples at corners of the axes. Equal settings of several samples are one entry.
#[must_use]
pub fn reservations_of(samples: &Samples) -> Vec<Reservation> {
    let Some(subject) = samples.study().machine() else { return Vec::new() };
    if samples.parameters().is_empty() {
        return subject.def.build().map(|machine| machine.reservations()).unwrap_or_default();
    }
    let chosen = Chosen::new(samples, MOST);
    let machines: Vec<Machine> =
        (0..chosen.count().min(MOST)).filter_map(|at| chosen.machine(at).build().ok()).collect();
    let mut found: Vec<(Reservation, usize)> = Vec::new();
    for one in machines.iter().flat_map(Machine::reservations) {
        let key = |of: &Reservation| of.text.split(" = ").next().map(str::to_owned);
        match found.iter_mut().find(|(other, _)| key(other) == key(&one)) {
            Some((_, count)) => *count += 1,
            None => found.push((one, 1)),
        }
    }
    let all = machines.len();
    let text = |text: String, count| if count < all { format!("{text} (in some samples)") } else { text };
    found.into_iter().map(|(one, count)| Reservation { text: text(one.text, count), ..one }).collect()
}
