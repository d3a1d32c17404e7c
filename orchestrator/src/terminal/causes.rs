//! Text for the causes of invalid runs: meaning of a cause, and by how much a guard was broken or a limit exceeded.

use bladeoff_answers::summary::percent;
use bladeoff_model::machine::{Diaphragm, DiaphragmKind, Machine};
use bladeoff_model::outcome::{Cause, Limit};
use bladeoff_text::document::units::{format_digits, format_quantity};

/// Meaning of a cause.
#[must_use]
pub fn cause_in_words(cause: Cause) -> &'static str {
    match cause {
        Cause::Diverged => {
            "the state grew beyond ten times the machine's size, or the iteration of a step or of the start did not settle"
        }
        Cause::NonFinite => "the state became NaN or infinite",
        Cause::EnergyBalance => "the energy balance does not close within `run.guard.energy_balance`",
        Cause::NormalWork => {
            "the normal contact force did more work than `run.guard.normal_work` allows: impacts lose or create energy"
        }
        Cause::Penetration => {
            "rotor and ring overlap at the end of a converged step by more than `run.guard.penetration` allows: the contact place changed within the \
             step, or the gap is so small that rounding matters"
        }
        Cause::SlipReversal => {
            "the slip velocity changed sign; the friction model only slides, so what follows is not physical"
        }
        Cause::LossOfUniqueness => "the contact force of a step is not unique (W <= 0)",
        Cause::StepLimit => "more steps than `run.step_limit`",
        Cause::Panicked => "the solver stopped with an internal error: a bug",
        Cause::TimeLimit => "longer than the time limit",
        Cause::WorkerKilled => {
            "other programs killed its worker process several times while it computed this sample alone"
        }
        Cause::WorkerCrashed => "its worker process crashed more than once while computing it alone",
        Cause::OutOfMemory => "its worker process ran out of memory",
        Cause::OutsideRing => "the rotor's centre left the ring of the diaphragm, where the model ends",
        Cause::ModalBasis => {
            "too few modes are kept for the contact: the truncated modes would not follow its force at once, as the model assumes; the shorter the \
             impacts, the more modes are needed"
        }
        Cause::NoBasis => {
            "the exponential engine has no modal basis at the start or at a speed of the run: two whirl motions are nearly identical, or its steps cannot resolve an unbalance"
        }
        Cause::RingDisplacement => {
            "the rotor pushed the ring out farther than the small-displacement ring model covers (`run.limit.ring_displacement`)"
        }
        Cause::RingYield => {
            "the ring's stress exceeds the allowed part of its yield strength; the model is elastic (`run.limit.ring_yield`)"
        }
        Cause::BladeYield => {
            "the stress of a diaphragm blade exceeds the allowed part of its yield strength; the model is elastic (`run.limit.blade_yield`)"
        }
        Cause::ShaftYield => {
            "the shaft's von Mises stress exceeds the allowed part of its yield strength; the model is elastic (`run.limit.shaft_yield`)"
        }
        Cause::JournalClearance => {
            "a journal moves farther than the clearance of its bearing, and the linear bearing has no clearance \
             (`run.limit.journal_clearance`)"
        }
        Cause::UnstableRotor => {
            "a whirl mode of the rotor grows at a speed of the run: the linear bearings or the rotor's damping drive it (`run.limit.unstable_rotor`)"
        }
        Cause::TableRange => "the speed left the table of a bearing, which has no coefficients there",
        Cause::UnderResolved => "impacts are shorter than the step resolves (`run.guard.impact_steps`)",
    }
}

/// How far a diverged run got: the state grew, or a step did not converge.
#[must_use]
pub fn diverged_at(number: impl Fn(&str) -> Option<f64>) -> Option<String> {
    let steps = number("steps")?;
    let most =
        [("largest eccentricity", "max_eccentricity_m", "m"), ("largest bearing load", "max_bearing_load_N", "N")];
    let most = most.into_iter().filter_map(|(name, column, unit)| {
        number(column).map(|value| format!(", {name} {}", format_quantity(value, unit)))
    });
    let plural = if (steps - 1.0).abs() < 0.5 { "" } else { "s" };
    Some(format!("{steps} step{plural}{}", most.collect::<String>()))
}

/// By how much a guard was broken or a limit of the model was exceeded; `number`: value of a column. `None` if the cause is neither.
#[must_use]
pub fn broken_by(cause: Cause, machine: &Machine, number: impl Fn(&str) -> Option<f64>) -> Option<String> {
    let guard = &machine.run.guard;
    match cause {
        Cause::EnergyBalance => Some(format!(
            "{} of the largest total energy; allowed {}",
            digits(number("energy_error")?),
            digits(guard.energy_balance)
        )),
        Cause::NormalWork => {
            let is_rigid = machine.diaphragms.iter().any(|diaphragm| diaphragm.kind == DiaphragmKind::Rigid);
            // such an impact takes energy of the lateral motion, at any step
            let rigid = "; a rigid ring takes an impact without rebound, so the rotor loses all of its normal kinetic \
                         energy in it at any step; a flexible ring or a radial spring returns it";
            Some(format!(
                "{}, with a friction work of {}; allowed {} of the largest of: friction work, energy of the lateral \
                 motion, a thousandth of the initial energy{}",
                format_quantity(number("normal_work_J")?, "J"),
                format_quantity(number("friction_energy_J")?, "J"),
                percent(guard.normal_work),
                if is_rigid { rigid } else { "" }
            ))
        }
        Cause::Penetration => {
            // names the diaphragm if there are several
            let is_one = machine.diaphragms.len() == 1;
            let left = machine.diaphragms.iter().filter_map(|diaphragm| {
                let column = "residual_penetration_m";
                let depth = if is_one { number(column) } else { number(&format!("{}.{column}", diaphragm.name)) };
                let gap = diaphragm.contact.gap;
                let [depth, gap, allowed] = [depth?, gap, guard.penetration * gap];
                (depth > allowed).then(|| {
                    let [depth, gap, allowed] = [depth, gap, allowed].map(|length| format_quantity(length, "m"));
                    let name = if is_one { String::new() } else { format!("{}: ", diaphragm.name) };
                    format!("{name}{depth} of a gap of {gap}; allowed {allowed}")
                })
            });
            let left: Vec<String> = left.collect();
            (!left.is_empty()).then(|| left.join("; "))
        }
        Cause::ModalBasis => {
            let length = steps_per_impact(machine, &number)? * number("step_s")?;
            // the length for which the number of modes is judged in any case
            (length < 1e-3).then(|| format!("impacts last {} on average", format_quantity(length, "s")))
        }
        Cause::UnderResolved => {
            let steps = steps_per_impact(machine, number)?;
            Some(format!("{} steps per impact; required {}", digits(steps), digits(guard.impact_steps)))
        }
        _ => exceeded_by(cause, number),
    }
}

/// Smallest number of steps per impact of all flexible rings, which alone have impacts of a length of their own.
fn steps_per_impact(machine: &Machine, number: impl Fn(&str) -> Option<f64>) -> Option<f64> {
    let is_one = machine.diaphragms.len() == 1;
    let column = "steps_per_impact";
    let of = |name: &str| if is_one { number(column) } else { number(&format!("{name}.{column}")) };
    let is_flexible = |diaphragm: &&Diaphragm| matches!(diaphragm.kind, DiaphragmKind::Flexible(_));
    machine.diaphragms.iter().filter(is_flexible).filter_map(|diaphragm| of(&diaphragm.name)).reduce(f64::min)
}

/// How far a run exceeded a limit of the model; `number`: value of a column. `None` if the cause is not a limit.
#[must_use]
pub fn exceeded_by(cause: Cause, number: impl Fn(&str) -> Option<f64>) -> Option<String> {
    let limit = Limit::of(cause)?.word();
    let ratio = number(&format!("limit_ratio_{limit}"))?;
    Some(format!("ratio {} to `run.limit.{limit}.value`", just_above(ratio)))
}

/// Time at which a run with these causes exceeded its limit of the model; `None` without such a time, or with several limits: only the time
/// of the first is recorded.
#[must_use]
pub fn exceeded_at(causes: impl Iterator<Item = Cause>, number: impl Fn(&str) -> Option<f64>) -> Option<String> {
    let limits = causes.filter(|cause| Limit::of(*cause).is_some()).count();
    let time = format_quantity(number("beyond_s")?, "s");
    match limits {
        0 => None,
        1 => Some(format!("at {time}")),
        _ => Some(format!("the first of {limits} limits was exceeded at {time}")),
    }
}

/// A ratio with enough digits to show that it differs from 1: a run that ends at its limit exceeds it by one step only.
#[must_use]
pub fn just_above(ratio: f64) -> String {
    let digits = (3..=8).find(|digits| format_digits(ratio, "", *digits) != "1").unwrap_or(9);
    format_digits(ratio, "", digits)
}

fn digits(part: f64) -> String {
    format_digits(part, "", 3)
}

#[cfg(test)]
mod tests {
    use super::super::advice::{Ran, advice};
    use super::*;
    use bladeoff_model::machine::Engine;

    #[test]
    fn a_guard_says_by_how_much_it_broke() {
        let text = include_str!("../../../studies/machines/lp_turbine_paper.toml");
        let machine = bladeoff_model::machine::MachineDef::parse("m.toml", text).and_then(|def| def.build());
        let machine = machine.expect("valid");
        let value = |name: &str| match name {
            "energy_error" => Some(1.234e-5),
            "normal_work_J" => Some(-12.0),
            "friction_energy_J" => Some(1000.0),
            "residual_penetration_m" => Some(3e-4),
            _ => None,
        };
        let told = |cause| broken_by(cause, &machine, value);
        let energy = told(Cause::EnergyBalance).expect("a guard");
        assert!(energy.starts_with("1.23e-5 of") && energy.ends_with("allowed 1e-5"), "{energy}");
        let work = told(Cause::NormalWork).expect("a guard");
        assert!(work.starts_with("-12 J, with a friction work of 1 kJ; allowed 1 %"), "{work}");
        let depth = told(Cause::Penetration).expect("a guard");
        assert!(depth.starts_with("0.3 mm of a gap of 8 mm; allowed 0.16 mm"), "{depth}");
        assert_eq!(told(Cause::Panicked), None);
        let ratio = |name: &str| (name == "limit_ratio_ring_displacement").then_some(1.234);
        let limit = broken_by(Cause::RingDisplacement, &machine, ratio).expect("a limit");
        assert_eq!(limit, "ratio 1.23 to `run.limit.ring_displacement.value`");
        let barely = |name: &str| (name == "limit_ratio_ring_displacement").then_some(1.00042);
        let limit = broken_by(Cause::RingDisplacement, &machine, barely).expect("a limit");
        assert_eq!(limit, "ratio 1.0004 to `run.limit.ring_displacement.value`");
    }

    #[test]
    fn the_time_of_a_limit_is_that_of_the_only_one() {
        let number = |name: &str| (name == "beyond_s").then_some(0.25);
        let at = |causes: &[Cause]| exceeded_at(causes.iter().copied(), number);
        assert_eq!(at(&[Cause::RingYield, Cause::EnergyBalance]).as_deref(), Some("at 0.25 s"));
        let both = at(&[Cause::RingYield, Cause::RingDisplacement]);
        assert_eq!(both.as_deref(), Some("the first of 2 limits was exceeded at 0.25 s"));
        assert_eq!(at(&[Cause::EnergyBalance]), None);
    }

    /// Every cause has a text and advice, and no two causes have the same text.
    #[test]
    fn every_cause_has_a_text_and_advice() {
        for (at, &cause) in Cause::ALL.iter().enumerate() {
            let text = cause_in_words(cause);
            let ran = Ran { engine: Engine::Reduced, is_backward: false, has_one_point: false };
            assert!(!text.is_empty() && !advice(cause, ran).text.is_empty(), "{}", cause.word());
            assert!(Cause::ALL[..at].iter().all(|other| cause_in_words(*other) != text), "{}", cause.word());
            assert!(Limit::of(cause).is_none_or(|limit| text.contains(limit.word())), "its key: {text}");
        }
    }

    #[test]
    fn a_diverged_run_says_how_far_it_got() {
        let values = |name: &str| match name {
            "steps" => Some(22_999.0),
            "max_bearing_load_N" => Some(50.756),
            "max_eccentricity_m" => Some(6.078e-7),
            _ => None,
        };
        let said = diverged_at(values).expect("steps");
        assert!(said.starts_with("22999 steps, largest eccentricity ") && said.contains("50.756 N"), "{said}");
        // before the first step, or without a diaphragm, fewer values are known
        assert_eq!(diverged_at(|name| (name == "steps").then_some(0.0)).as_deref(), Some("0 steps"));
        assert_eq!(diverged_at(|_| None), None);
    }
}
