//! Notes of `check` on structures shared by samples, and on samples that are computed twice.

use bladeoff_answers::summary::counted;
use bladeoff_core::engine::exponential::same_bases;
use bladeoff_core::structure::same_structure;
use bladeoff_model::machine::{ENGINE, Engine, Machine, ParamValue, TWIN};
use bladeoff_study::{Parameter, Samples};
use bladeoff_text::document::units::format_digits;

/// Largest number of samples for which twins are counted; above it their share is printed.
const COUNTED: u64 = 1_000_000;

/// Largest number of values of a parameter for which machines are built to find out whether it changes shared data. A number that changes it
/// does so with nearly every value, and no parameter has so many words.
const MOST_TRIED: usize = 16;

/// Parameters that change matrices and modes from sample to sample.
pub(super) fn structural(samples: &Samples) -> Vec<&Parameter> {
    of_structure(samples, &samples.different_values(MOST_TRIED))
}

fn of_structure<'a>(samples: &'a Samples, values: &[Vec<ParamValue>]) -> Vec<&'a Parameter> {
    changing(samples, values, |one, other| !same_structure(one, other))
}

/// Parameters that leave matrices and modes unchanged, but change the bases of the exponential engine.
fn of_bases<'a>(samples: &'a Samples, values: &[Vec<ParamValue>]) -> Vec<&'a Parameter> {
    let is_engine = |(_, parameter): &(usize, &Parameter)| parameter.info.path == ENGINE;
    let varied = samples.parameters().iter().enumerate().find(is_engine);
    let word = ParamValue::Choice(Engine::Exponential.word().to_owned());
    let varies_to_it = varied.is_some_and(|(place, _)| values[place].contains(&word));
    let is_exponential = |machine: &Machine| varies_to_it || machine.run.engine == Engine::Exponential;
    changing(samples, values, |one, other| {
        is_exponential(other) && same_structure(one, other) && !same_bases(one, other)
    })
}

/// Parameters with a value for which `differ` is true, compared with the machine of the first sample.
fn changing<'a>(
    samples: &'a Samples,
    values: &[Vec<ParamValue>],
    differ: impl Fn(&Machine, &Machine) -> bool,
) -> Vec<&'a Parameter> {
    if samples.count() < 2 {
        return Vec::new();
    }
    let base = samples.machine(0);
    let Ok(first) = base.build() else { return Vec::new() };
    let differs = |parameter: &Parameter, value: &ParamValue| {
        let mut other = base.clone();
        let set = other.set(&parameter.info, value).is_ok();
        set && other.build().is_ok_and(|other| differ(&first, &other))
    };
    let of_its_own = |(place, parameter): &(usize, &Parameter)| {
        !parameter.is_variable && values[*place].iter().any(|value| differs(parameter, value))
    };
    samples.parameters().iter().enumerate().filter(of_its_own).map(|(_, parameter)| parameter).collect()
}

/// Lines on structures and twins.
pub(super) fn shared(samples: &Samples) -> String {
    let mut text = String::new();
    if samples.count() > 1 {
        let values = samples.different_values(MOST_TRIED);
        let own = of_structure(samples, &values);
        text.push_str(&match changed_by(&own) {
            None => "Structure: all samples share one; matrices and modes are computed once.\n".to_owned(),
            Some(change) => {
                format!("Structure: {change} it; matrices and modes are computed for each sample anew.\n")
            }
        });
        let of_bases = if own.is_empty() { of_bases(samples, &values) } else { Vec::new() };
        if let Some(change) = changed_by(&of_bases) {
            text.push_str(&format!(
                "Bases of the exponential engine: {change} them; they are computed for each sample anew.\n"
            ));
        }
    }
    text.push_str(&twins(samples).unwrap_or_default());
    text
}

/// Text such as "a, b change"; `None` without parameters.
fn changed_by(parameters: &[&Parameter]) -> Option<String> {
    let paths: Vec<&str> = parameters.iter().map(|parameter| parameter.info.path.as_str()).collect();
    match paths[..] {
        [] => None,
        [one] => Some(format!("{one} changes")),
        [..] => Some(format!("{} change", paths.join(", "))),
    }
}

/// Samples that are computed twice.
fn twins(samples: &Samples) -> Option<String> {
    let twice = computed_twice(samples)?;
    Some(format!("Twins: {twice}. A run with status failed or beyond has no twin.\n"))
}

fn computed_twice(samples: &Samples) -> Option<String> {
    let study = samples.study();
    let shift = format_digits(study.shift(), "", 3);
    let second = format!("the second time with an initial speed larger by {shift} of it");
    if let Some(share) = &study.twin {
        if samples.count() > COUNTED {
            return Some(format!("{share} of the samples (twin_share) are computed twice, {second}"));
        }
        let count =
            (0..samples.count()).filter(|sample| samples.twin(*sample).is_some_and(|shift| shift > 0.0)).count();
        let are = bladeoff_answers::summary::are(count as u64);
        let of = counted(samples.count(), "sample");
        return Some(format!("{count} of {of} (twin_share {share}) {are} computed twice, {second}"));
    }
    if let Some(varied) = samples.parameters().iter().position(|one| one.info.path == TWIN) {
        let has_some = samples.different_values(2)[varied].iter().any(|value| *value != ParamValue::Number(0.0));
        return has_some.then(|| "a sample whose run.twin is above 0 is computed twice".to_owned());
    }
    (study.shift() > 0.0).then(|| format!("every sample is computed twice (run.twin), {second}"))
}
