//! Mistakes in the keys of `[design]` that do not depend on the distributions.

use super::def::{
    Base, LEVELS, LayoutDef, LayoutError, LayoutKind, MOST_LEVELS, MOST_POINTS, MOST_QUANTILES, MOST_REPLICATES,
};
use super::saltelli;

/// All mistakes in the keys, for this number of parameters.
pub(super) fn mistakes(def: &LayoutDef, parameters: usize) -> Vec<LayoutError> {
    let mut errors = Vec::new();
    let kind = def.kind;
    let mut surplus = |key: &'static str, given: bool, reason: &dyn Fn() -> String| {
        if given {
            errors.push(LayoutError::Surplus { key, kind, reason: reason() });
        }
    };
    let stepped = kind == LayoutKind::OneAtATime;
    surplus("samples", stepped && def.samples.is_some(), &|| {
        "the number of points follows from the parameters and `quantiles`".to_owned()
    });
    surplus("samples", kind == LayoutKind::Morris && def.samples.is_some(), &|| {
        "the number of points follows from the parameters and `trajectories`".to_owned()
    });
    surplus("replicates", stepped && def.replicates.is_some(), &|| "nothing in it is random".to_owned());
    surplus("scramble", stepped && def.scramble.is_some(), &|| "nothing in it is random".to_owned());
    surplus("replicates", kind == LayoutKind::MonteCarlo && def.replicates.is_some(), &|| {
        let points = def.samples.unwrap_or(0).saturating_mul(def.replicates.unwrap_or(1));
        format!("its points are already independent; allowed: only `samples` = {points}")
    });
    surplus("replicates", kind == LayoutKind::Morris && def.replicates.is_some(), &|| {
        "its trajectories are already independent; allowed: more `trajectories`".to_owned()
    });
    surplus("replicates", kind == LayoutKind::Saltelli && def.replicates.is_some(), &|| {
        "its intervals are made of its base points; allowed: more `samples`".to_owned()
    });
    let drawn = matches!(kind, LayoutKind::MonteCarlo | LayoutKind::LatinHypercube | LayoutKind::Morris);
    surplus("scramble", drawn && def.scramble.is_some(), &|| {
        "its points are random in any case; `scramble` belongs to \"sobol\", \"halton\" and \"saltelli\"".to_owned()
    });
    let of = |kind: LayoutKind| move || format!("it belongs to {:?}", kind.word());
    surplus("base", !stepped && def.base.is_some(), &of(LayoutKind::OneAtATime));
    surplus("quantiles", !stepped && def.quantiles.is_some(), &of(LayoutKind::OneAtATime));
    surplus("trajectories", kind != LayoutKind::Morris && def.trajectories.is_some(), &of(LayoutKind::Morris));
    surplus("levels", kind != LayoutKind::Morris && def.levels.is_some(), &of(LayoutKind::Morris));
    surplus("second_order", kind != LayoutKind::Saltelli && def.second_order.is_some(), &of(LayoutKind::Saltelli));
    match kind {
        LayoutKind::OneAtATime => errors.extend(quantile_mistakes(def)),
        LayoutKind::Morris => {
            errors.extend(level_mistake(def));
            errors.extend(size_mistakes(def, parameters as u64 + 1));
        }
        LayoutKind::Saltelli => {
            errors.extend(size_mistakes(def, saltelli::rows(parameters, def.second_order.unwrap_or(false))));
        }
        _ => errors.extend(size_mistakes(def, 1)),
    }
    errors
}

fn level_mistake(def: &LayoutDef) -> Option<LayoutError> {
    let levels = def.levels.unwrap_or(LEVELS);
    let is_sound = (2..=MOST_LEVELS).contains(&levels) && levels.is_multiple_of(2);
    let allowed = || format!("an even number from 2 to {MOST_LEVELS}: a move goes half of them");
    (!is_sound).then(|| LayoutError::Value { key: "levels", given: levels.to_string(), allowed: allowed() })
}

/// Mistakes in the size of the design; `rows`: points of a block.
fn size_mistakes(def: &LayoutDef, rows: u64) -> Vec<LayoutError> {
    let mut errors = Vec::new();
    let is_single = matches!(def.kind, LayoutKind::MonteCarlo | LayoutKind::Morris | LayoutKind::Saltelli);
    let replicates = if is_single { 1 } else { def.replicates.unwrap_or(1) };
    if !(1..=MOST_REPLICATES).contains(&replicates) {
        let allowed = format!("1 to {MOST_REPLICATES}");
        errors.push(LayoutError::Value { key: "replicates", given: replicates.to_string(), allowed });
    }
    if def.scramble == Some(false) && def.kind != LayoutKind::LatinHypercube && replicates > 1 {
        let allowed = "1: without scrambling all replicates would be the same".to_owned();
        errors.push(LayoutError::Value { key: "replicates", given: replicates.to_string(), allowed });
    }
    let (key, given, allowed) = match def.kind {
        LayoutKind::Morris => ("trajectories", def.trajectories, "the number of trajectories, such as 32"),
        LayoutKind::Saltelli => ("samples", def.samples, "the number of base points, a power of two such as 1024"),
        _ => ("samples", def.samples, "the number of points of a replicate"),
    };
    let Some(samples) = given else {
        errors.push(LayoutError::Missing { key, allowed });
        return errors;
    };
    let most = MOST_POINTS / (replicates.clamp(1, MOST_REPLICATES) * rows);
    let given = samples.to_string();
    if samples == 0 || samples > most {
        let allowed = match (replicates, rows) {
            (1, 1) => format!("1 to {most}"),
            (1, _) => format!("1 to {most} ({MOST_POINTS} points, {rows} for each)"),
            _ => format!("1 to {most} ({MOST_POINTS} points in {replicates} replicates)"),
        };
        errors.push(LayoutError::Value { key, given, allowed });
    } else if def.kind.needs_powers_of_two() && !samples.is_power_of_two() {
        let above = samples.next_power_of_two();
        let above = if above <= most { format!(" or {above}") } else { String::new() };
        let allowed = format!("a power of two: {}{above}", 1u64 << samples.ilog2());
        errors.push(LayoutError::Value { key, given, allowed });
    }
    errors
}

fn quantile_mistakes(def: &LayoutDef) -> Vec<LayoutError> {
    let Some(quantiles) = &def.quantiles else { return Vec::new() };
    if quantiles.is_empty() || quantiles.len() > MOST_QUANTILES {
        let (given, allowed) = (format!("{} values", quantiles.len()), format!("1 to {MOST_QUANTILES} values"));
        return vec![LayoutError::Value { key: "quantiles", given, allowed }];
    }
    let is_median = def.base.as_ref().is_none_or(|base| *base == Base::Median);
    let wrong = |(position, &given): (usize, &f64)| {
        let allowed = if !(0.0..=1.0).contains(&given) {
            "0 to 1"
        } else if quantiles[..position].contains(&given) {
            "each once"
        } else if is_median && given == 0.5 {
            "a value other than 0.5, which is the base point"
        } else {
            return None;
        };
        Some(LayoutError::Element { key: "quantiles", position, given, allowed: allowed.to_owned() })
    };
    quantiles.iter().enumerate().filter_map(wrong).collect()
}
