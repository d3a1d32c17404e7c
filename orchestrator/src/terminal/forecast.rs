//! The forecast of contact in words: the predicted amplitude of the linear rotor compared with the gap.

use super::stability::Stability;
use bladeoff_core::modal::{ContactForecast, contact_forecasts};
use bladeoff_model::machine::{Braking, Machine, Rotor, Torque};
use bladeoff_text::document::units::format_digits;

/// Note below every forecast.
pub const CAVEAT: &str = "The forecast is that of the linear rotor without contact. The release is followed for its first 40 turns; on the shipped machines complete runs \
    without contact reach 98 to 101 % of it. A rotor that passes a critical speed quickly stays below its steady response.";

/// One line for each diaphragm, "mid: contact expected: ...", or one line that no forecast is made: the linear amplitude of an unstable rotor grows
/// without a limit.
#[must_use]
pub fn forecast_lines(machine: &Machine, stability: &mut Stability) -> Vec<String> {
    if machine.diaphragms.is_empty() {
        return Vec::new();
    }
    if let Some(unstable) = stability.unstable(machine) {
        return vec![format!("no forecast: {unstable}")];
    }
    contact_forecasts(machine).iter().map(|one| line(machine, one)).collect()
}

fn line(machine: &Machine, forecast: &ContactForecast) -> String {
    let name = machine.diaphragms.get(forecast.diaphragm).map_or("", |diaphragm| diaphragm.name.as_str());
    format!("{name}: {}", in_words(forecast))
}

/// The verdict of a forecast with its numbers.
#[must_use]
pub fn in_words(forecast: &ContactForecast) -> String {
    let length = |value: f64| format_digits(value, "m", 3);
    let times = |share: f64| format!("{} of the gap", format_digits(share, "", 2));
    let gap = length(forecast.gap);
    let at_rest = if forecast.at_rest > 0.0 {
        format!(", of which {} are taken at rest by sag and offset", length(forecast.at_rest))
    } else {
        String::new()
    };
    let release = format!("{} after the release ({})", length(forecast.release), times(forecast.release_share()));
    let steady = format!(
        "unbalance response {} at {} ({})",
        length(forecast.response),
        rpm(forecast.speed),
        if forecast.at_rest > 0.0 {
            format!("{} with that at rest", times(forecast.steady_share()))
        } else {
            times(forecast.steady_share())
        }
    );
    let verdict = if forecast.release_share() >= 1.0 {
        format!("contact expected: {release}")
    } else if forecast.steady_share() >= 1.0 {
        format!("contact expected where the run passes a critical speed: {release}")
    } else {
        format!("no contact expected: {release}")
    };
    let [low, high] = forecast.speeds;
    format!("{verdict}, {steady} within {} to {}, for a gap of {gap}{at_rest}", rpm(low), rpm(high))
}

/// Whether contact is expected.
#[must_use]
pub fn is_expected(forecast: &ContactForecast) -> bool {
    forecast.share() >= 1.0
}

fn rpm(speed: f64) -> String {
    format!("{} rpm", format_digits(speed * 30.0 / std::f64::consts::PI, "", 4))
}

/// Inputs of a forecast except the gap.
#[derive(Debug, Clone, PartialEq)]
struct Inputs {
    rotor: Rotor,
    braking: Braking,
    torques: Vec<Torque>,
    ends: [f64; 2],
    places: Vec<(usize, [f64; 2])>,
}

/// Forecasts already made: machines that differ only in gap, friction and the like share one.
#[derive(Debug, Clone, Default)]
pub struct Forecasts(Vec<(Inputs, Vec<ContactForecast>)>);

impl Forecasts {
    /// Forecasts for the diaphragms of a machine.
    pub fn of(&mut self, machine: &Machine) -> Vec<ContactForecast> {
        let inputs = Inputs {
            rotor: machine.rotor.clone(),
            braking: machine.braking.clone(),
            torques: machine.torques.clone(),
            ends: [machine.run.end_time, machine.run.end_speed],
            places: machine.diaphragms.iter().map(|one| (one.contact.node, one.contact.offset)).collect(),
        };
        let found = match self.0.iter().find(|(one, _)| *one == inputs) {
            Some((_, found)) => found.clone(),
            None => {
                let found = contact_forecasts(machine);
                self.0.push((inputs, found.clone()));
                found
            }
        };
        let gap = |forecast: ContactForecast| {
            let contact = machine.diaphragms.get(forecast.diaphragm).map(|diaphragm| diaphragm.contact.gap);
            ContactForecast { gap: contact.unwrap_or(forecast.gap), ..forecast }
        };
        found.into_iter().map(gap).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    fn forecast(release: f64, response: f64, at_rest: f64) -> ContactForecast {
        let speeds = [0.0, 100.0 * std::f64::consts::PI];
        ContactForecast {
            diaphragm: 0,
            gap: 8e-3,
            at_rest,
            speeds,
            response,
            speed: 27.0 * std::f64::consts::PI,
            release,
        }
    }

    #[test]
    fn machines_that_differ_in_the_gap_alone_share_a_forecast() {
        let text = include_str!("../../../studies/machines/lab_rig.toml");
        let machine = |text: &str| MachineDef::parse("rig.toml", text).expect("valid").build().expect("valid");
        let mut forecasts = Forecasts::default();
        let wide = forecasts.of(&machine(text)).remove(0);
        let narrow = forecasts.of(&machine(&text.replace("gap = \"0.5 mm\"", "gap = \"0.4 mm\""))).remove(0);
        assert_eq!((forecasts.0.len(), wide.gap, narrow.gap), (1, 0.5e-3, 0.4e-3));
        assert_eq!(ContactForecast { gap: wide.gap, ..narrow }, wide);
        forecasts.of(&machine(&text.replace("mass = \"10 g\"", "mass = \"11 g\"")));
        assert_eq!(forecasts.0.len(), 2);
    }

    #[test]
    fn the_verdict_follows_the_release_first() {
        let said = in_words(&forecast(9.4e-3, 4e-3, 0.0));
        let expected = "contact expected: 9.4 mm after the release (1.2 of the gap), unbalance response 4 mm at 810 rpm (0.5 of the gap) within 0 rpm to \
             3000 rpm, for a gap of 8 mm";
        assert_eq!(said, expected);
        let steady = in_words(&forecast(7e-3, 9e-3, 0.0));
        assert!(steady.starts_with("contact expected where the run passes a critical speed: 7 mm"), "{steady}");
        let none = in_words(&forecast(4e-3, 3e-3, 1e-3));
        assert!(
            none.starts_with("no contact expected: ")
                && none.ends_with("of which 1 mm are taken at rest by sag and offset")
        );
        assert!(
            none.contains("unbalance response 3 mm at 810 rpm (0.5 of the gap with that at rest)"),
            "with what is taken at rest: {none}"
        );
    }
}
