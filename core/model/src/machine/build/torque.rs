//! `[torques.NAME]`: torques on the shaft over time, and their equilibrium at t = 0.

use super::path::{Path, below, joined};
use super::places::{self, Nodes};
use super::reader::Reader;
use crate::machine::model::{Braking, ShortCircuit, Torque};
use crate::machine::schema::FLAG;
use bladeoff_text::document::units::{format_digits, format_quantity};

/// Largest number of torques: each adds to the cost of every step.
const MOST: usize = 20;
/// Largest sum of all torques at t = 0 that counts as equilibrium, as a share of the largest torque.
const ROUNDED: f64 = 1e-6;

/// Keys of a short circuit; start, frequency, amplitude and decay are required.
const SHORT_CIRCUIT: [&str; 6] = ["start", "frequency", "amplitude", "decay", "double_amplitude", "double_decay"];

/// All torques; `None`: a problem was reported.
pub(super) fn torques(
    reader: &mut Reader<'_>,
    nodes: Option<&Nodes>,
    braking: Option<&Braking>,
) -> Option<Vec<Torque>> {
    let names: Vec<String> = reader.layout.group("torques").iter().map(|member| member.name.clone()).collect();
    if names.len() > MOST {
        reader.fail("torques", format!("{} torques", names.len()), format!("at most {MOST}"));
    }
    let balances: Vec<usize> = (0..names.len()).filter(|&at| is_balance(reader, &names[at])).collect();
    if let [first, second, ..] = balances[..] {
        let path = joined(&["torques.", &names[second], ".balance"]);
        let message = format!("{} has balance = true too", names[first]);
        reader.fail(&path, message, "balance = true of one torque");
        return None;
    }
    let all: Vec<Option<Torque>> = names.iter().map(|name| torque(reader, nodes, name)).collect();
    let mut torques: Vec<Torque> = all.into_iter().collect::<Option<_>>()?;
    if torques.is_empty() {
        return Some(torques);
    }
    let speed = reader.number("rotor.initial_speed")?;
    let slowing = braking?.torque(speed);
    let given: f64 = torques.iter().map(Torque::before).sum();
    match balances.first() {
        Some(&at) => {
            // its values are still factors, with 1 at t = 0
            let lacking = -(given - torques[at].before() + slowing);
            torques[at].values.iter_mut().for_each(|factor| *factor *= lacking);
        }
        None => check_sum(reader, &torques, slowing)?,
    }
    Some(torques)
}

fn is_balance(reader: &Reader<'_>, name: &str) -> bool {
    reader.word(&joined(&["torques.", name, ".balance"])) == Some(FLAG[1])
}

/// A free shaft line rotates steadily before t = 0, so the sum of all torques must be zero. A drive compensates any remainder.
fn check_sum(reader: &mut Reader<'_>, torques: &[Torque], slowing: f64) -> Option<()> {
    let is_driven = reader.is_given("rotor.speed_law.acceleration") || reader.is_given("rotor.speed_law.speeds");
    let sum = torques.iter().map(Torque::before).sum::<f64>() + slowing;
    let largest = torques.iter().map(|torque| torque.before().abs()).fold(slowing.abs(), f64::max);
    if is_driven || sum.abs() <= ROUNDED * largest {
        return Some(());
    }
    let shown = |torque: f64| format_digits(torque, "N m", 6);
    let braking = if slowing == 0.0 { String::new() } else { format!(" (braking: {})", shown(slowing)) };
    let message = format!("the torques and braking add up to {} at t = 0{braking}, not to 0", shown(sum));
    let allowed = "balance = true of one torque, which then takes the rest, or values that add up to 0";
    reader.fail("torques", message, allowed);
    None
}

/// Reads one torque; with `balance = true`, its values are factors.
fn torque(reader: &mut Reader<'_>, nodes: Option<&Nodes>, name: &str) -> Option<Torque> {
    let table = &*below("torques", name);
    let node = places::node(reader, nodes, table);
    let short_circuit = short_circuit(reader, table);
    let course = course(reader, table, is_balance(reader, name));
    let (Some((times, values)), Some(short_circuit), Some(node)) = (course, short_circuit, node) else { return None };
    if values.is_empty() && short_circuit.is_none() {
        reader.missing_here(&below(table, "values"), "torques.NAME.values");
        return None;
    }
    Some(Torque { name: name.to_owned(), node, times, values, short_circuit })
}

/// Times and values, or factors; both empty if the file gives none.
fn course(reader: &mut Reader<'_>, table: &str, is_balance: bool) -> Option<(Vec<f64>, Vec<f64>)> {
    let [times, values, factors] = ["times", "values", "factors"].map(|key| below(table, key));
    if is_balance && reader.is_given(&values) {
        reader.fail(&values, "the torque is what balance makes it", "factors beside balance, or balance = false");
        return None;
    }
    if !is_balance && reader.is_given(&factors) {
        reader.fail(&factors, "factors of nothing", "values, or balance = true");
        return None;
    }
    let (given, pattern) =
        if is_balance { (&factors, "torques.NAME.factors") } else { (&values, "torques.NAME.values") };
    match (reader.is_given(&times), reader.is_given(given)) {
        (false, false) if is_balance => return Some((vec![0.0], vec![1.0])),
        (false, false) => return Some((Vec::new(), Vec::new())),
        (true, false) => {
            reader.missing_here(given, pattern);
            return None;
        }
        (false, true) => {
            reader.missing_here(&times, "torques.NAME.times");
            return None;
        }
        (true, true) => {}
    }
    let (starts, amounts) = (reader.list(&times)?, reader.list(given)?);
    if starts.len() != amounts.len() {
        let message = format!("{} for {} times", amounts.len(), starts.len());
        reader.fail(given, message, "as many as times");
        return None;
    }
    if let Some(i) = (1..starts.len()).find(|&i| starts[i] < starts[i - 1] || i > 1 && starts[i] == starts[i - 2]) {
        let allowed = match starts[i] < starts[i - 1] {
            true => format!("not before {}", format_quantity(starts[i - 1], "s")),
            false => format!("later than {}: a jump has two values at one time", format_quantity(starts[i - 1], "s")),
        };
        reader.fail(&entry(&times, i), "times do not ascend", allowed);
        return None;
    }
    if is_balance && amounts[0] != 1.0 {
        reader.fail(&entry(given, 0), "the torque that balances has the factor 1 at t = 0", "1");
        return None;
    }
    Some((starts, amounts))
}

fn entry(list: &Path, at: usize) -> String {
    format!("{}[{at}]", &**list)
}

/// Inner `None`: not given; outer: a problem was reported.
fn short_circuit(reader: &mut Reader<'_>, torque: &str) -> Option<Option<ShortCircuit>> {
    let path = |key: &str| joined(&[torque, ".short_circuit.", key]);
    if !SHORT_CIRCUIT.iter().any(|key| reader.is_given(&path(key))) {
        return Some(None);
    }
    let mut complete = true;
    for key in &SHORT_CIRCUIT[..4] {
        if !reader.is_given(&path(key)) {
            reader.missing_here(&path(key), &format!("torques.NAME.short_circuit.{key}"));
            complete = false;
        }
    }
    if !complete {
        return None;
    }
    let or = |key: &str, otherwise: f64| match reader.is_given(&path(key)) {
        true => reader.number(&path(key)),
        false => Some(otherwise),
    };
    let number = |key: &str| reader.number(&path(key));
    let decay = number("decay")?;
    Some(Some(ShortCircuit {
        start: number("start")?,
        frequency: number("frequency")?,
        amplitudes: [number("amplitude")?, or("double_amplitude", 0.0)?],
        decays: [decay, or("double_decay", decay)?],
    }))
}
