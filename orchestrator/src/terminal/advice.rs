//! Advice about a cause, which depends on the engine and the regime of the run, and the change of the machine that tests the advice.

use bladeoff_model::machine::{CONTACT_STEP, ENGINE, Engine, STEP};
use bladeoff_model::outcome::Cause;
use std::borrow::Cow;

/// The properties of a run that advice depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ran {
    /// Engine of the run.
    pub engine: Engine,
    /// Whether its column `rub_regime` is [`BACKWARD`].
    pub is_backward: bool,
    /// Whether it has `contact.points = "one"`, or a detection with one contact point.
    pub has_one_point: bool,
}

/// Value of the column `rub_regime` for heavy rub in which the rotor centre moves against the spin direction.
pub const BACKWARD: &str = "backward-whirl";

/// A change of the machine that shows whether the advice helps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// The step of the engine is multiplied by this factor.
    Step(f64),
    /// A path is set to a value.
    Set(&'static str, &'static str),
}

/// Advice about a cause.
#[derive(Debug, Clone, PartialEq)]
pub struct Advice {
    /// The advice in words.
    pub text: Cow<'static, str>,
    /// Change that tests the advice; `None` if no change of a single value does.
    pub change: Option<Change>,
}

/// Key of the engine's time step; that of another engine would be rejected, or would change the engine of a whole study.
#[must_use]
pub fn step_key(engine: Engine) -> &'static str {
    if engine == Engine::Exponential { CONTACT_STEP } else { STEP }
}

const HALF: Change = Change::Step(0.5);
const FIFTH: Change = Change::Step(0.2);

/// Advice about a cause in a run.
#[must_use]
pub fn advice(cause: Cause, ran: Ran) -> Advice {
    let is_exponential = ran.engine == Engine::Exponential;
    let step = step_key(ran.engine);
    let compared = if is_exponential { ", or compare with `run.engine = \"reduced\"`" } else { "" };
    let with = |text: String, change| Advice { text: text.into(), change: Some(change) };
    let plain = |text: &'static str| Advice { text: text.into(), change: None };
    match cause {
        Cause::EnergyBalance | Cause::NormalWork | Cause::Penetration => of_contact(cause, ran),
        Cause::Diverged | Cause::NonFinite => with(
            format!(
                "plot its history (`replay --history`) to see what grew; another `{step}` shows whether the step or \
                 the machine is the reason{compared}"
            ),
            HALF,
        ),
        Cause::SlipReversal => with(
            "`contact.friction_law = \"stick-slip\"` lets the contact stick and slide back".to_owned(),
            Change::Set("contact.friction_law", "stick-slip"),
        ),
        Cause::LossOfUniqueness if is_exponential => with(
            "a smaller `run.contact_step` shows whether the step was the reason; if the run fails again, less \
             friction: the model may have no single answer there"
                .to_owned(),
            HALF,
        ),
        Cause::LossOfUniqueness => {
            plain("less friction or another `contact.detection`; the model has no single answer there")
        }
        Cause::StepLimit => plain(
            "raise `run.step_limit` (`run` then computes such samples again and keeps the others), or shorten `run.end_time` \
             (another study: another --out)",
        ),
        Cause::Panicked => {
            plain("its message is in the log; please report it with study and machine: a replay reproduces it")
        }
        Cause::TimeLimit => plain("compute it again with a longer time limit, or on a less loaded computer"),
        Cause::WorkerKilled => plain(
            "the system log names what killed it (`dmesg`: out of memory?). Every later `run` tries it once more. \
             With fewer workers each has more memory",
        ),
        Cause::WorkerCrashed => {
            plain("its last message is in the log; please report it with study and machine: a replay may reproduce it")
        }
        Cause::OutOfMemory => plain("compute it again with more memory or fewer workers at once"),
        Cause::OutsideRing => with(
            format!(
                "look for a value with a wrong unit (`contact.offset`, `rotor.initial`); a smaller `{step}` if the \
                 rotor passed the ring within one step"
            ),
            HALF,
        ),
        Cause::ModalBasis => with(
            "`run.engine = \"full\"` without `run.contact_step`, which keeps all modes; or more `run.rotor_modes` and \
             `run.ring_modes`: the default if fewer are set"
                .to_owned(),
            Change::Set(ENGINE, Engine::Full.word()),
        ),
        Cause::NoBasis => {
            with("`run.engine = \"reduced\"`, which needs none".to_owned(), Change::Set(ENGINE, Engine::Reduced.word()))
        }
        Cause::RingDisplacement => {
            plain("use the values up to `beyond_s` as lower bounds; what follows needs a model of large displacements")
        }
        Cause::RingYield | Cause::BladeYield | Cause::ShaftYield => {
            plain("use the values up to `beyond_s` as lower bounds; what follows needs a model with plasticity")
        }
        Cause::JournalClearance => {
            plain("use bearing loads with care: a real bearing stiffens or is destroyed where its clearance is used up")
        }
        Cause::UnstableRotor => {
            plain("check the bearings' cross-coupled stiffness and damping (`bladeoff modes` lists unstable speeds)")
        }
        Cause::TableRange => plain(
            "extend the bearing's table, or set `run.end_speed` inside it; the values up to the end are lower bounds",
        ),
        Cause::UnderResolved => with(
            format!(
                "a fifth of `{step}`: a finer step also finds shorter impacts, so the ratio of the numbers above is \
                 not enough"
            ),
            FIFTH,
        ),
    }
}

/// Advice for the guards of the contact, based on measurements (docs/theory/08-exponential-engine.md and 03-contact.md).
fn of_contact(cause: Cause, Ran { engine, is_backward, has_one_point }: Ran) -> Advice {
    let (text, change) = match (cause, engine, is_backward) {
        // the error depends on the spacing of the stations
        (Cause::EnergyBalance, Engine::Exponential, true) => (
            "in heavy backward whirl a smaller `run.contact_step` may not reduce this error; compare with `run.engine = \"reduced\"`",
            Change::Set(ENGINE, Engine::Reduced.word()),
        ),
        (Cause::EnergyBalance, Engine::Exponential, false) => (
            "a smaller `run.contact_step`; if the error falls with it, the step was the reason, otherwise compare with `run.engine = \"reduced\"`",
            HALF,
        ),
        (Cause::EnergyBalance, ..) => (
            "a smaller `run.step`; if the error falls with it, the step was the reason, otherwise draw its history (`replay --history`)",
            HALF,
        ),
        // the normal work of a rotor that the ring stops abruptly is correct with a finer step, and larger
        (Cause::NormalWork, Engine::Exponential, _) => (
            "half of `run.contact_step`. If loads and friction energy stay the same and the normal work does not \
             fall, the impacts do this work, and a smaller step does not help: compare with `run.engine = \"reduced\"`",
            HALF,
        ),
        (Cause::NormalWork, _, true) if has_one_point => (
            "`contact.detection = \"hyp2\"` with `contact.points = \"several\"`: in heavy backward whirl one point created energy at every `run.step` tried",
            Change::Set("contact.points", "several"),
        ),
        (Cause::NormalWork, ..) => (
            "a smaller `run.step`; if the work falls with it, the step was the reason, otherwise draw its history (`replay --history`)",
            HALF,
        ),
        (Cause::Penetration, Engine::Exponential, true) => (
            "in heavy backward whirl a smaller `run.contact_step` does not reduce the overlap. Use more modes of the ring (`run.ring_modes`), or compare \
             with `run.engine = \"full\"`. Values reached while all guards held are lower bounds",
            Change::Set(ENGINE, Engine::Full.word()),
        ),
        (Cause::Penetration, Engine::Exponential, false) => (
            "compare with `run.engine = \"reduced\"`; a smaller `run.contact_step`, or more modes of the ring (`run.ring_modes`), help only where the overlap falls with them",
            Change::Set(ENGINE, Engine::Reduced.word()),
        ),
        (Cause::Penetration, _, true) if has_one_point => (
            "`contact.detection = \"hyp2\"` with `contact.points = \"several\"`: in heavy backward whirl one point leaves millimetres at any `run.step`, several leave \
             micrometres; or more modes of the ring (`run.ring_modes`)",
            Change::Set("contact.points", "several"),
        ),
        _ => (
            "a smaller `run.step` (`run.engine = \"full\"` has one), or `contact.detection = \"hyp2\"` with \
             `contact.points = \"several\"`, which leaves almost no overlap at any step; or more modes of the ring \
             (`run.ring_modes`)",
            HALF,
        ),
    };
    Advice { text: text.into(), change: Some(change) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(cause: Cause, engine: Engine, is_backward: bool) -> Advice {
        advice(cause, Ran { engine, is_backward, has_one_point: engine != Engine::Exponential })
    }

    #[test]
    fn advice_names_the_step_of_the_engine() {
        for cause in [Cause::Diverged, Cause::EnergyBalance, Cause::NormalWork, Cause::Penetration, Cause::OutsideRing]
        {
            let exponential = of(cause, Engine::Exponential, false);
            assert!(exponential.text.contains("`run.contact_step`"), "{}", cause.word());
            assert!(!exponential.text.contains("`run.step`"), "{}", cause.word());
            assert!(of(cause, Engine::Reduced, false).text.contains("`run.step`"), "{}", cause.word());
            let tried = if cause == Cause::Penetration { Change::Set("run.engine", "reduced") } else { HALF };
            assert_eq!(exponential.change, Some(tried), "{}", cause.word());
        }
    }

    #[test]
    fn in_backward_whirl_no_smaller_step_is_tried_where_it_does_not_help() {
        for (cause, engine, tried) in [
            (Cause::EnergyBalance, Engine::Exponential, Change::Set("run.engine", "reduced")),
            (Cause::Penetration, Engine::Exponential, Change::Set("run.engine", "full")),
            (Cause::Penetration, Engine::Reduced, Change::Set("contact.points", "several")),
            (Cause::NormalWork, Engine::Full, Change::Set("contact.points", "several")),
        ] {
            let found = of(cause, engine, true);
            assert_eq!(found.change, Some(tried), "{}", cause.word());
            assert!(found.text.contains("in heavy backward whirl"), "{}", found.text);
        }
    }
}
