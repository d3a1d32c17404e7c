//! Explanations of the orderings, from the numbers of the same runs.

use super::done::Done;
use super::quantity::{CPU, DETECTIONS, FORCE, LOAD, MEAN_FORCE, PENETRATION, Quantity, digits, ratio, spreads};
use super::separation::{Spread, Verdict};
use bladeoff_model::machine::Engine;

/// Penetration \[m\] below which a difference is rounding.
const ROUNDING: f64 = 1e-12;

/// Section of the report.
pub(super) fn causes(done: &[Done], engines: &[&str]) -> Vec<String> {
    let mut lines = vec![
        "\n## Why\n".to_owned(),
        "What the detections do: hyp1 takes the ring point at the angle of the rotor centre; hyp2 searches the deformed ring for the"
            .to_owned(),
        "closest point, in each iteration, or frozen once a step; one contact point, as the paper. The penetration is that of the"
            .to_owned(),
        "run's own gap function, which for hyp1 is its approximate one. Measured, medians over the starts:".to_owned(),
    ];
    for engine in engines {
        lines.push(format!("\n**{engine} engine**\n"));
        lines.extend(cpu_time(done, engine));
        lines.extend(spread_by_detection(done, engine));
        lines.extend(contact_force(done, engine));
        lines.extend(penetration(done, engine));
    }
    if engines.len() > 1 {
        lines.push("\n**between the engines**\n".to_owned());
        lines.extend(step(done));
    }
    lines
}

fn median(done: &[Done], engine: &str, detection: &str, value: fn(&Done) -> Option<f64>) -> Option<f64> {
    Spread::of(done, engine, detection, value).map(|spread| spread.median())
}

/// The ratio of CPU times is the product of the ratio of iterations and the ratio of CPU times per iteration.
fn cpu_time(done: &[Done], engine: &str) -> Vec<String> {
    let iterations: fn(&Done) -> Option<f64> = |run| run.value("iterations");
    let of = |detection| {
        Some((median(done, engine, detection, CPU.ours)?, median(done, engine, detection, iterations)?))
            .filter(|(_, iterations)| *iterations > 0.0)
    };
    let Some((cpu, count)) = of(DETECTIONS[0]) else { return Vec::new() };
    DETECTIONS[1..]
        .iter()
        .filter_map(|detection| {
            let (other, other_count) = of(detection)?;
            Some(format!(
                "- CPU time: {detection}/hyp1 {} = iterations {} · CPU time of an iteration {}.",
                ratio(other, cpu),
                ratio(other_count, count),
                ratio(other / other_count, cpu / count)
            ))
        })
        .collect()
}

/// Differences between the detections, compared with the scatter between the starts of one detection.
fn spread_by_detection(done: &[Done], engine: &str) -> Vec<String> {
    let of = |quantity: &Quantity| {
        let all: Vec<Spread> = spreads(done, engine, quantity).into_iter().flatten().collect();
        let medians: Vec<f64> = all.iter().map(Spread::median).collect();
        let share = |low: f64, high: f64| if high > 0.0 { 100.0 * (high - low) / high } else { 0.0 };
        let (low, high) = ends(&medians)?;
        let starts = all.iter().map(|spread| share(spread.low(), spread.high())).fold(0.0, f64::max);
        let paper = quantity.paper.and_then(|paper| ends(&paper)).map(|(low, high)| share(low, high));
        let paper = paper.map_or(String::new(), |share| format!(" (the paper's {share:.0} %)"));
        let between = share(low, high);
        let several = all.iter().any(|spread| spread.sorted.len() > 1);
        let between_starts =
            if several { format!(", the starts of one by up to {starts:.1} %") } else { String::new() };
        Some(format!("- {}: the detections differ by {between:.1} %{paper}{between_starts}.", quantity.name))
    };
    [&LOAD, &FORCE, &MEAN_FORCE].into_iter().filter_map(of).collect()
}

fn ends(values: &[f64]) -> Option<(f64, f64)> {
    let low = values.iter().copied().reduce(f64::min)?;
    Some((low, values.iter().copied().reduce(f64::max)?))
}

/// The raw peak is the 1 ms mean times the ratio of the largest step to that mean: which of the two causes the paper's orderings?
fn contact_force(done: &[Done], engine: &str) -> Vec<String> {
    let parts: Vec<String> = DETECTIONS
        .iter()
        .filter_map(|detection| {
            let (raw, mean) = (
                median(done, engine, detection, FORCE.ours)?,
                median(done, engine, detection, MEAN_FORCE.ours).filter(|mean| *mean > 0.0)?,
            );
            Some(format!("{detection} {} = {} · {}", digits(raw), digits(mean), digits(raw / mean)))
        })
        .collect();
    if parts.is_empty() {
        return vec!["- There is no contact.".to_owned()];
    }
    let means = spreads(done, engine, &MEAN_FORCE);
    let paper = FORCE.paper.unwrap_or_default();
    let said: Vec<String> = [(0, 1), (0, 2), (1, 2)]
        .into_iter()
        .map(|(a, b)| {
            let (small, large) = if paper[a] < paper[b] { (a, b) } else { (b, a) };
            let verdict = Verdict::of(means[small].as_ref(), means[large].as_ref());
            format!("{} < {} {}", DETECTIONS[small], DETECTIONS[large], verdict.words())
        })
        .collect();
    vec![
        format!("- Max contact force [MN] = 1 ms mean · how far one step stands out of it: {}.", parts.join("; ")),
        format!("- The paper's orderings of the contact force in the 1 ms mean: {}.", said.join("; ")),
    ]
}

/// Origin of the penetration.
fn penetration(done: &[Done], engine: &str) -> Vec<String> {
    DETECTIONS
        .iter()
        .filter_map(|detection| {
            let run =
                done.iter().find(|run| run.engine == engine && run.detection == *detection && run.start == 0)?;
            let contact = run.value("contact_time_s")? / run.value("step_s")?;
            let (deepest, strongest) = (run.value("residual_penetration_at_s")?, run.value("max_contact_force_at_s")?);
            let residual = run.value("residual_penetration_m")?;
            let apart = (deepest - strongest).abs();
            let when = if apart <= 1e-3 {
                "within 1 ms of the largest contact force".to_owned()
            } else {
                format!("{} s from the largest contact force", digits(apart))
            };
            Some(format!(
                "- Residual penetration of {detection}, own start: {}; {:.0} % of the contact steps found no fixed point; normal work \
                 {} % of the friction energy{}.",
                if residual < ROUNDING {
                    format!("none, {residual:.0e} m is rounding")
                } else {
                    format!("{} of 1e-2 mm at {deepest:.4} s, {when}", digits(residual * 1e5))
                },
                100.0 * run.value("no_fixed_point_steps")? / contact.max(1.0),
                digits(share(run, "normal_work_J")?),
                share(run, "model_work_J").map_or(String::new(), |work| format!(", work of its model {} %", digits(work)))
            ))
        })
        .collect()
}

/// An energy in per cent of the friction energy.
fn share(run: &Done, energy: &str) -> Option<f64> {
    let friction = run.value("friction_energy_J").filter(|friction| *friction > 0.0)?;
    Some(100.0 * run.value(energy)? / friction)
}

/// Differences between the engines other than the detection, mainly the step.
fn step(done: &[Done]) -> Vec<String> {
    let step: fn(&Done) -> Option<f64> = |run| run.value("step_s");
    DETECTIONS
        .iter()
        .filter_map(|detection| {
            let both = |value: fn(&Done) -> Option<f64>| {
                let of = |engine: Engine| median(done, engine.word(), detection, value);
                Some((of(Engine::Reduced)?, of(Engine::Full)?))
            };
            let (coarse, fine) = both(step)?;
            let said: Vec<String> = [&LOAD, &MEAN_FORCE, &FORCE, &PENETRATION]
                .into_iter()
                .filter_map(|quantity| {
                    let (reduced, full) = both(quantity.ours)?;
                    Some(format!("{} {} and {}", quantity.name, digits(reduced), digits(full)))
                })
                .collect();
            Some(format!(
                "- {detection}, reduced and full: step {} and {} us; {}.",
                digits(coarse * 1e6),
                digits(fine * 1e6),
                said.join("; ")
            ))
        })
        .collect()
}
