//! Warning about Morris designs whose levels of an angle are equivalent: if moves are whole periods of the machine, all effects are exactly 0.

use super::angle::period_between;
use super::parameter::Origin;
use super::samples::Samples;
use bladeoff_model::machine::Machine;

/// Warnings about angles with equivalent levels.
#[must_use]
pub fn idle_levels(samples: &Samples) -> Vec<String> {
    let Some(trajectories) = samples.layout().and_then(|layout| layout.trajectories()) else { return Vec::new() };
    if samples.count() == 0 || samples.study().machine().is_none() {
        return Vec::new();
    }
    let Ok(machine) = samples.machine(0).build() else { return Vec::new() };
    let angles = samples.parameters().iter().filter(|parameter| parameter.is_angle());
    angles
        .filter_map(|parameter| {
            let Origin::Uncertain(number) = parameter.origin else { return None };
            let law = samples.law(number)?;
            let values: Vec<f64> = trajectories.levels(number).iter().map(|u| law.quantile(*u, 1.0 - u)).collect();
            said(&machine, &parameter.info.path, &values)
        })
        .collect()
}

/// Warning about the levels of one angle \[rad\].
fn said(machine: &Machine, path: &str, levels: &[f64]) -> Option<String> {
    let period = |a: f64, b: f64| period_between(machine, path, [a, b]);
    let degrees =
        |angle: f64| format!("{:.6}", angle.to_degrees()).trim_end_matches('0').trim_end_matches('.').to_owned();
    let (lower, upper) = levels.split_at(levels.len() / 2);
    let moves: Option<Vec<f64>> = lower.iter().zip(upper).map(|(a, b)| period(*a, *b)).collect();
    if let Some(period) = moves.and_then(|moves| moves.first().copied()) {
        let step = degrees(upper[0] - lower[0]);
        return Some(format!(
            "warning: {path} moves by {step} deg, whole periods of {} deg of this machine: both ends of each step are \
             the same start, and the effects are exactly 0. Choose an interval, or levels, that do not differ by \
             whole periods.",
            degrees(period)
        ));
    }
    let (first, last) = (*levels.first()?, *levels.last()?);
    let period = period(first, last).filter(|_| first != last)?;
    Some(format!(
        "warning: the first and the last level of {path} are the same start, whole periods of {} deg apart: choose an \
         interval, or levels, that do not differ by whole periods.",
        degrees(period)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    #[test]
    fn levels_of_an_angle_that_are_the_same_start_are_told() {
        let text = include_str!("../../../studies/machines/lab_rig.toml");
        let machine = MachineDef::parse("lab_rig.toml", text).and_then(|machine| machine.build()).expect("valid");
        let path = "rotor.unbalances.blade_off.phase";
        let said = |levels: &[f64]| {
            said(&machine, path, &levels.iter().map(|degrees| degrees.to_radians()).collect::<Vec<_>>())
        };
        // eight blades: levels over the whole turn, and over one period
        let idle = said(&[0.0, 90.0, 180.0, 270.0]).expect("half a turn is four periods");
        assert!(idle.contains("moves by 180 deg, whole periods of 45 deg") && idle.contains("exactly 0"), "{idle}");
        assert_eq!(said(&[0.0, 11.25, 22.5, 33.75]), None);
        // uniform over the whole turn: moves of 240 degrees, but both ends are equivalent
        let ends = said(&[0.0, 120.0, 240.0, 360.0]).expect("0 and 360 degrees");
        assert!(ends.contains("first and the last level") && ends.contains("whole periods of 360 deg"), "{ends}");
        assert!(said(&[0.0, 15.0, 30.0, 45.0]).is_some_and(|said| said.contains("whole periods of 45 deg")));
        assert_eq!(said(&[0.0, 13.0, 26.0, 39.0]), None);
    }
}
