//! What the samples of a study share, and which of them are computed twice: what `check` says of their cost.

use bladeoff_answers::report::counted;
use bladeoff_core::structure::same_structure;
use bladeoff_model::document::units::format_digits;
use bladeoff_model::machine::{ParamValue, TWIN};
use bladeoff_study::{Parameter, Samples};

/// Samples up to which twins are counted; of more their share is told.
const COUNTED: u64 = 1_000_000;

/// The parameters that change matrices and modes from sample to sample.
pub(super) fn structural(samples: &Samples) -> Vec<&Parameter> {
    if samples.count() < 2 {
        return Vec::new();
    }
    let base = samples.machine(0);
    let Ok(first) = base.build() else { return Vec::new() };
    // Each value differs from the others, or the parameter would not vary: its second, middle and last say whether that matters.
    let differs = |parameter: &Parameter, value: &ParamValue| {
        let mut other = base.clone();
        let set = other.set(&parameter.info, value).is_ok();
        set && other.build().is_ok_and(|other| !same_structure(&first, &other))
    };
    let of_its_own = |(place, parameter): &(usize, &Parameter)| {
        !parameter.is_variable && samples.some_values(*place).iter().any(|value| differs(parameter, value))
    };
    samples.parameters().iter().enumerate().filter(of_its_own).map(|(_, parameter)| parameter).collect()
}

/// Lines about structures and twins.
pub(super) fn shared(samples: &Samples) -> String {
    let mut text = String::new();
    if samples.count() > 1 {
        let paths: Vec<&str> = structural(samples).iter().map(|varied| varied.info.path.as_str()).collect();
        text.push_str(&match paths[..] {
            [] => "Structure: all samples share one; matrices and modes are computed once.\n".to_owned(),
            [one] => format!("Structure: {one} changes it; matrices and modes are computed for each sample anew.\n"),
            [..] => {
                format!(
                    "Structure: {} change it; matrices and modes are computed for each sample anew.\n",
                    paths.join(", ")
                )
            }
        });
    }
    text.push_str(&twins(samples).unwrap_or_default());
    text
}

fn twins(samples: &Samples) -> Option<String> {
    let study = samples.study();
    let shift = format_digits(study.shift(), "", 3);
    let second = format!("the second time with an initial speed larger by {shift} of it");
    if let Some(share) = &study.twin {
        if samples.count() > COUNTED {
            return Some(format!("Twins: {share} of the samples (twin_share) are computed twice, {second}.\n"));
        }
        let count =
            (0..samples.count()).filter(|sample| samples.twin(*sample).is_some_and(|shift| shift > 0.0)).count();
        let are = bladeoff_answers::report::are(count as u64);
        let of = counted(samples.count(), "sample");
        return Some(format!("Twins: {count} of {of} (twin_share {share}) {are} computed twice, {second}.\n"));
    }
    if let Some(varied) = samples.parameters().iter().position(|one| one.info.path == TWIN) {
        let has_some = samples.some_values(varied).iter().any(|value| *value != ParamValue::Number(0.0));
        return has_some.then(|| "Twins: a sample whose run.twin is above 0 is computed twice.\n".to_owned());
    }
    (study.shift() > 0.0).then(|| format!("Twins: every sample is computed twice (run.twin), {second}.\n"))
}
