//! Unbalance response: displacements and bearing loads over speed.

use super::panels::{Line, Panel, panels};
use super::{Figure, FigureError, Scale};
use bladeoff_core::machine::{Machine, RotorKind};
use bladeoff_core::modal::unbalance_response as responses;
use std::f64::consts::PI;

/// Speeds of a curve.
const SPEEDS: usize = 400;

/// Draws the steady response to all unbalances of the machine up to `top` [rad/s]; `None` without an unbalance.
///
/// # Errors
/// The plotting library failed.
pub fn unbalance_response(machine: &Machine, top: f64) -> Result<Option<Figure>, FigureError> {
    if machine.rotor.unbalances.iter().all(|unbalance| unbalance.mass * unbalance.radius == 0.0) {
        return Ok(None);
    }
    let speeds: Vec<f64> = (1..=SPEEDS).map(|k| top * k as f64 / SPEEDS as f64).collect();
    let found = responses(machine, &speeds);
    let mut places: Vec<(String, usize)> =
        machine.rotor.unbalances.iter().map(|unbalance| (unbalance.name.clone(), unbalance.node)).collect();
    if let RotorKind::Shaft(shaft) = &machine.rotor.kind {
        places.extend(shaft.discs.iter().map(|disc| (disc.name.clone(), disc.node)));
    }
    places.extend(
        machine.diaphragms.iter().map(|diaphragm| (format!("diaphragm {}", diaphragm.name), diaphragm.contact.node)),
    );
    places.extend(machine.rotor.bearings.iter().map(|bearing| (bearing.name.clone(), bearing.node)));
    let mut seen = Vec::new();
    places.retain(|(_, node)| {
        let new = !seen.contains(node);
        seen.push(*node);
        new
    });
    places.truncate(7);
    let rpm = |speed: f64| speed * 30.0 / PI;
    let largest =
        |values: &dyn Fn(&bladeoff_core::modal::UnbalanceResponse) -> f64| found.iter().map(values).fold(0.0, f64::max);
    let length = Scale::of("m", largest(&|r| places.iter().map(|(_, node)| r.nodes[*node]).fold(0.0, f64::max)));
    let load = Scale::of("N", largest(&|r| r.bearings.iter().copied().fold(0.0, f64::max)));
    let displacement = places
        .iter()
        .map(|(name, node)| {
            Line::new(
                &name.replace('_', " "),
                found.iter().map(|r| (rpm(r.speed), r.nodes[*node] * length.factor)).collect(),
            )
        })
        .collect();
    let loads = machine
        .rotor
        .bearings
        .iter()
        .enumerate()
        .map(|(i, bearing)| {
            Line::new(&bearing.name, found.iter().map(|r| (rpm(r.speed), r.bearings[i] * load.factor)).collect())
        })
        .collect();
    let panel = |y_label: String, lines| Panel { y_label, lines, y_range: None, thin: false };
    let title = format!("Steady response of {} to its unbalances, without contact", machine.name);
    let both = [panel(length.label("displacement"), displacement), panel(load.label("bearing load"), loads)];
    panels(&title, "spin speed [rpm]", &both).map(Some)
}
