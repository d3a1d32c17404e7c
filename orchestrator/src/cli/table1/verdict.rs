//! The table, the orderings, and what was measured about their causes.

use super::runs::Done;
use std::fmt::Write;

const DETECTIONS: [&str; 3] = ["hyp1", "hyp2", "hyp2-frozen"];

/// A row of the paper's Table 1.
struct Quantity {
    name: &'static str,
    /// The paper's values for hyp1, hyp2, hyp2-frozen in the shown unit.
    paper: [f64; 3],
    /// Ours in the shown unit.
    ours: fn(&Done) -> Option<f64>,
}

const QUANTITIES: [Quantity; 4] = [
    Quantity { name: "CPU time [s]", paper: [7742.0, 24743.0, 6845.0], ours: |run| Some(run.cpu) },
    Quantity {
        name: "max load on bearing [1e5 N]",
        paper: [5.46, 4.95, 5.36],
        ours: |run| Some(run.value("max_bearing_load_N")? * 1e-5),
    },
    Quantity {
        name: "max contact force [MN]",
        paper: [3.49, 4.29, 7.53],
        ours: |run| Some(run.value("max_contact_force_N")? * 1e-6),
    },
    Quantity {
        name: "residual penetration [1e-2 mm]",
        paper: [5.88, 6.75, 12.36],
        ours: |run| Some(run.value("residual_penetration_m")? * 1e5),
    },
];

/// Of our own, beside the paper's: what converges.
const ROBUST: [Quantity; 3] = [
    Quantity {
        name: "max contact force, 1 ms mean [MN]",
        paper: [f64::NAN; 3],
        ours: |run| Some(run.value("max_filtered_contact_force_N")? * 1e-6),
    },
    Quantity {
        name: "friction energy [MJ]",
        paper: [f64::NAN; 3],
        ours: |run| Some(run.value("friction_energy_J")? * 1e-6),
    },
    Quantity { name: "end speed [rad/s]", paper: [f64::NAN; 3], ours: |run| run.value("end_speed_rad_s") },
];

/// Smallest, the start's own, largest.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Range {
    low: f64,
    own: f64,
    high: f64,
}

fn range(done: &[Done], engine: &str, detection: &str, ours: fn(&Done) -> Option<f64>) -> Option<Range> {
    let runs: Vec<&Done> = done.iter().filter(|run| run.engine == engine && run.detection == detection).collect();
    let values: Vec<f64> = runs.iter().filter_map(|run| ours(run)).collect();
    let own = runs.iter().find(|run| run.start == 0).and_then(|run| ours(run))?;
    Some(Range {
        low: values.iter().copied().fold(f64::INFINITY, f64::min),
        own,
        high: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    })
}

/// Whether `a` is below `b` for every pair of starts: 1, above for every pair: -1, or neither: 0.
fn order(a: Range, b: Range) -> i32 {
    if a.high < b.low {
        1
    } else if a.low > b.high {
        -1
    } else {
        0
    }
}

/// The report as Markdown.
pub(super) fn report(done: &[Done]) -> String {
    let mut text = String::new();
    let starts = 1 + done.iter().map(|run| run.start).max().unwrap_or(0);
    let engines: Vec<&str> =
        ["reduced", "full"].into_iter().filter(|engine| done.iter().any(|run| run.engine == *engine)).collect();
    let mut say = |line: String| {
        text.push_str(&line);
        text.push('\n');
    };
    say("# Table 1 of DETC2007-34625 beside ours\n".to_owned());
    say("The machine is ours (`studies/machines/lp_turbine.toml`), not the paper's, whose data are not printed; its braking is".to_owned());
    say("about 100 times real windage, so that rub begins near 3 s as in the paper. Orderings and orders of magnitude can be".to_owned());
    say("compared, not numbers.\n".to_owned());
    say(format!(
        "Ours: value from the machine's own start [smallest, largest over {starts} starts: phase, up to 1 % of the lost mass].\n"
    ));
    for engine in &engines {
        say(format!("## {engine} engine\n"));
        say("| | | hyp1 | hyp2 | hyp2-frozen |\n|---|---|---|---|---|".to_owned());
        for quantity in QUANTITIES.iter().chain(&ROBUST) {
            if quantity.paper[0].is_finite() {
                let [a, b, c] = quantity.paper;
                say(format!("| {} | paper | {a} | {b} | {c} |", quantity.name));
            }
            let cells = DETECTIONS.map(|detection| {
                range(done, engine, detection, quantity.ours).map_or("-".to_owned(), |r| {
                    let digits = |value: f64| {
                        format!(
                            "{value:.prec$}",
                            prec = if r.high >= 1000.0 {
                                0
                            } else if r.high >= 100.0 {
                                1
                            } else {
                                2
                            }
                        )
                    };
                    format!("{} [{}, {}]", digits(r.own), digits(r.low), digits(r.high))
                })
            });
            let name = if quantity.paper[0].is_finite() { "" } else { quantity.name };
            say(format!("| {name} | ours | {} | {} | {} |", cells[0], cells[1], cells[2]));
        }
        say(String::new());
        for (detection, status) in not_ok(done, engine) {
            say(format!("- {detection}: {status}"));
        }
    }
    say("## Orderings\n".to_owned());
    say("Rule: an ordering of two detections is claimed only if their ranges over the starts do not overlap.\n"
        .to_owned());
    if starts < 2 {
        say("**With one start there is no range: nothing is claimed. Take `--scatter 3` or more.**\n".to_owned());
    }
    for engine in &engines {
        for quantity in &QUANTITIES {
            say(format!("- {engine}, {}: {}", quantity.name, orderings(done, engine, quantity, starts)));
        }
    }
    say("\n## Why\n\nMeasured on the same runs:\n".to_owned());
    for engine in &engines {
        for line in causes(done, engine) {
            say(line);
        }
    }
    say(EXPLANATION.to_owned());
    text
}

fn not_ok<'a>(done: &'a [Done], engine: &str) -> Vec<(&'a str, String)> {
    let runs = done.iter().filter(|run| run.engine == engine && run.status() != "ok");
    runs.map(|run| (run.detection, format!("start {} is {}", run.start, run.status()))).collect()
}

fn orderings(done: &[Done], engine: &str, quantity: &Quantity, starts: usize) -> String {
    let mut said = Vec::new();
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        // in the paper's order: small before large
        let (small, large) = if quantity.paper[a] < quantity.paper[b] { (a, b) } else { (b, a) };
        let ranges = range(done, engine, DETECTIONS[small], quantity.ours).zip(range(
            done,
            engine,
            DETECTIONS[large],
            quantity.ours,
        ));
        let verdict = match ranges {
            None => "not computed",
            Some(_) if starts < 2 => "one start: not decided",
            Some((small, large)) => match order(small, large) {
                1 => "comes out",
                -1 => "**reversed**",
                _ => "not decided (ranges overlap)",
            },
        };
        said.push(format!("{} < {} {verdict}", DETECTIONS[small], DETECTIONS[large]));
    }
    said.join("; ")
}

/// What a reader needs to judge an ordering.
fn causes(done: &[Done], engine: &str) -> Vec<String> {
    let mut lines = Vec::new();
    for detection in DETECTIONS {
        let own = done.iter().find(|run| run.engine == engine && run.detection == detection && run.start == 0);
        let Some(run) = own else { continue };
        let value = |name| run.value(name).unwrap_or(0.0);
        let contact_steps = (value("contact_time_s") / value("step_s").max(f64::MIN_POSITIVE)).max(1.0);
        let mut line = String::new();
        write!(
            line,
            "- {engine} {detection}: {:.2} iterations a step; contact in {:.1} % of the steps, {:.0} % of these without fixed \
             point; raw peak {:.2} times the 1 ms mean; normal work {:+.2} % and model work {:+.2} % of the friction energy",
            value("iterations") / value("steps").max(1.0),
            100.0 * contact_steps / value("steps").max(1.0),
            100.0 * value("no_fixed_point_steps") / contact_steps,
            value("max_contact_force_N") / value("max_filtered_contact_force_N").max(f64::MIN_POSITIVE),
            100.0 * value("normal_work_J") / value("friction_energy_J").max(f64::MIN_POSITIVE),
            100.0 * value("model_work_J") / value("friction_energy_J").max(f64::MIN_POSITIVE),
        )
        .expect("writing to a String cannot fail");
        lines.push(line);
    }
    lines
}

const EXPLANATION: &str = "
- CPU time: near contact hyp1 needs no search of the ring, hyp2-frozen one for each step, hyp2 one for each iteration. Here a bound
  skips the search while contact is impossible, and it looks only at the part of the ring that can be closest, so that the
  detections differ less than the paper's, and the two quick ones are told apart by their one search.
- Max contact force is the force of one step: it grows with the step's fineness and with the local mass, and scatters from
  start to start. The 1 ms mean is the quantity to compare.
- Residual penetration of hyp1 is that of its own, approximate gap. Hyp2 updated leaves penetration where the iteration has no
  fixed point and the predicted place is kept, as hyp2-frozen does in every contact step.
- Bearing loads follow the whirl of the whole shaft line, which sees the contact force only as a mean over its period: they
  depend less on the detection than the contact force does. The paper says so too.
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ordering_is_claimed_only_where_ranges_are_apart() {
        let range = |low, high| Range { low, own: low, high };
        assert_eq!(order(range(1.0, 2.0), range(2.1, 3.0)), 1);
        assert_eq!(order(range(2.1, 3.0), range(1.0, 2.0)), -1);
        assert_eq!(order(range(1.0, 2.0), range(2.0, 3.0)), 0);
        assert_eq!(order(range(1.0, 4.0), range(2.0, 3.0)), 0);
    }

    #[test]
    fn the_paper_s_numbers_are_the_paper_s() {
        assert_eq!(QUANTITIES[1].paper, [5.46, 4.95, 5.36]);
        assert_eq!(QUANTITIES[2].paper, [3.49, 4.29, 7.53]);
    }
}
