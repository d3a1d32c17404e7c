//! `[braking]`: coefficients and table of the braking torque.

use super::reader::Reader;
use crate::machine::model::Braking;
use bladeoff_text::document::units::format_digits;

const SPEEDS: &str = "braking.speeds";
const TORQUES: &str = "braking.torques";

pub(super) fn braking(reader: &mut Reader<'_>) -> Option<Braking> {
    let table = table(reader)?;
    Some(Braking {
        constant: reader.number("braking.constant")?,
        linear: reader.number("braking.linear")?,
        quadratic: reader.number("braking.quadratic")?,
        table,
    })
}

/// Points of the table; empty: not given. `None`: a problem was reported.
fn table(reader: &mut Reader<'_>) -> Option<Vec<[f64; 2]>> {
    match (reader.is_given(SPEEDS), reader.is_given(TORQUES)) {
        (false, false) => return Some(Vec::new()),
        (true, false) => {
            reader.missing_here(TORQUES, TORQUES);
            return None;
        }
        (false, true) => {
            reader.missing_here(SPEEDS, SPEEDS);
            return None;
        }
        (true, true) => {}
    }
    let (speeds, torques) = (reader.list(SPEEDS)?, reader.list(TORQUES)?);
    let shown = |speed: f64| format_digits(speed, "rad/s", 6);
    let found = speeds.len();
    if found != torques.len() {
        reader.fail(TORQUES, format!("{} torques for {found} speeds", torques.len()), "as many torques as speeds");
        return None;
    }
    if speeds[0] != 0.0 {
        reader.fail(&format!("{SPEEDS}[0]"), "the table does not begin at rest", "0 rad/s");
        return None;
    }
    if let Some(i) = (1..found).find(|&i| speeds[i] <= speeds[i - 1]) {
        reader.fail(&format!("{SPEEDS}[{i}]"), "speeds do not ascend", format!("above {}", shown(speeds[i - 1])));
        return None;
    }
    let (last, initial) = (speeds[found - 1], reader.number("rotor.initial_speed")?);
    if last < initial {
        let message = format!("the table ends below rotor.initial_speed = {}", shown(initial));
        reader.fail(&format!("{SPEEDS}[{}]", found - 1), message, format!("at least {}", shown(initial)));
        return None;
    }
    Some(speeds.into_iter().zip(torques).map(|(speed, torque)| [speed, torque]).collect())
}
