//! Report: the table, the orderings, and measured data on their causes.

use super::causes::causes;
use super::done::Done;
use super::quantity::{CPU, DETECTIONS, FORCE, LOAD, MEAN_FORCE, PENETRATION, Quantity, digits, ratio, spreads};
use super::separation::{CHANCE, Verdict, accident};
use bladeoff_model::machine::Engine;

/// Pairs of detections.
const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

/// Rows of the paper's Table 1, followed by quantities that converge with the step.
const TABLE: [&Quantity; 7] = [
    &CPU,
    &LOAD,
    &FORCE,
    &PENETRATION,
    &MEAN_FORCE,
    &Quantity { name: "friction energy [MJ]", paper: None, ours: |run| Some(run.value("friction_energy_J")? * 1e-6) },
    &Quantity { name: "end speed [rad/s]", paper: None, ours: |run| run.value("end_speed_rad_s") },
];

/// The report in Markdown.
#[must_use]
pub fn report(done: &[Done]) -> String {
    let engines: Vec<&str> =
        Engine::WORDS.into_iter().filter(|engine| done.iter().any(|run| run.engine == *engine)).collect();
    let starts = 1 + done.iter().map(|run| run.start).max().unwrap_or(0);
    let mut lines = vec![
        "# Table 1 of DETC2007-34625 beside ours".to_owned(),
        String::new(),
        "The machine is ours (`studies/machines/lp_turbine_paper.toml`), not the paper's, whose data are not printed; its braking is"
            .to_owned(),
        "about 100 times real windage, so that rub begins near 3 s as in the paper. Orderings and orders of magnitude can be"
            .to_owned(),
        "compared, not numbers.".to_owned(),
        String::new(),
        format!(
            "Ours: value from the machine's own start (smallest to largest over {starts} starts: phase, up to 1 % of the lost \
             mass)."
        ),
    ];
    for engine in &engines {
        lines.push(format!("\n## {engine} engine\n"));
        lines.extend(table(done, engine));
        for run in done.iter().filter(|run| run.engine == *engine) {
            if let Some(status) = run.trouble() {
                lines.push(format!("\n- {}, start {}: {status}", run.detection, run.start));
            }
        }
    }
    lines.extend(orderings(done, &engines, starts));
    lines.extend(causes(done, &engines));
    lines.join("\n") + "\n"
}

fn table(done: &[Done], engine: &str) -> Vec<String> {
    let mut lines = vec!["| | | hyp1 | hyp2 | hyp2-frozen |".to_owned(), "|---|---|---|---|---|".to_owned()];
    for quantity in TABLE {
        if let Some([a, b, c]) = quantity.paper {
            lines.push(format!("| {} | paper | {a} | {b} | {c} |", quantity.name));
        }
        let cells = spreads(done, engine, quantity).map(|spread| {
            spread.map_or("-".to_owned(), |spread| {
                format!("{} ({} to {})", digits(spread.own), digits(spread.low()), digits(spread.high()))
            })
        });
        let name = if quantity.paper.is_some() { "" } else { quantity.name };
        lines.push(format!("| {name} | ours | {} |", cells.join(" | ")));
    }
    lines
}

/// Orderings of the paper, results of each engine, and claims.
fn orderings(done: &[Done], engines: &[&str], starts: usize) -> Vec<String> {
    let (mut rows, mut claims, mut open) = (Vec::new(), Vec::new(), Vec::new());
    for quantity in TABLE {
        let Some(paper) = quantity.paper else { continue };
        for (a, b) in PAIRS {
            let (small, large) = if paper[a] < paper[b] { (a, b) } else { (b, a) };
            let mut cells = vec![
                quantity.name.to_owned(),
                format!("{} < {}", DETECTIONS[small], DETECTIONS[large]),
                ratio(paper[large], paper[small]),
            ];
            let verdicts: Vec<Verdict> = engines
                .iter()
                .map(|engine| {
                    let spreads = spreads(done, engine, quantity);
                    let verdict = Verdict::of(spreads[small].as_ref(), spreads[large].as_ref());
                    let both = spreads[small].as_ref().zip(spreads[large].as_ref());
                    let times =
                        both.map_or(String::new(), |(small, large)| ratio(large.median(), small.median()) + ", ");
                    cells.push(format!("{times}{}", verdict.words()));
                    verdict
                })
                .collect();
            let claim = Verdict::of_all(&verdicts);
            claims.push(claim);
            if !claim.claims() {
                let name = format!("{}, {} < {}", quantity.name, DETECTIONS[small], DETECTIONS[large]);
                open.push(format!("- {name}: {}.", undecided(done, engines, quantity, (small, large), &verdicts)));
            }
            cells.push(
                match claim {
                    Verdict::ComesOut => "yes",
                    Verdict::Reversed => "**reversed**",
                    _ => "-",
                }
                .to_owned(),
            );
            rows.push(format!("| {} |", cells.join(" | ")));
        }
    }
    let count = |wanted: Verdict| claims.iter().filter(|claim| **claim == wanted).count();
    let chance = accident(starts, starts);
    let mut lines = vec![
        "\n## Orderings of the paper\n".to_owned(),
        format!(
            "Rule: an ordering of two detections is claimed where all runs are ok, the two ranges over the starts do not overlap, \
             and this would happen by accident, if the detection made no difference, at most one time in {:.0}; and only if \
             {}. With {starts} start{} each it happens one time in {:.0}: 2/C({}, {starts}). ×: ratio of the \
             larger of the paper to the smaller, ours from the medians.",
            1.0 / CHANCE,
            if engines.len() > 1 { "every engine agrees" } else { "the engine that was run agrees" },
            if starts == 1 { "" } else { "s" },
            1.0 / chance,
            2 * starts,
        ),
        String::new(),
    ];
    if chance > CHANCE {
        lines.push("**So few starts decide nothing. Take `--scatter 4` or more.**\n".to_owned());
    }
    let engine_titles: Vec<String> = engines.iter().map(|engine| format!("{engine} engine")).collect();
    lines.push(format!("| | paper | | {} | claimed |", engine_titles.join(" | ")));
    lines.push(format!("|---|---|---|{}---|", "---|".repeat(engines.len())));
    lines.extend(rows);
    lines.push(format!(
        "\nOf the paper's {} orderings come out: {}; reversed: {}; not decided: {}.",
        claims.len(),
        count(Verdict::ComesOut),
        count(Verdict::Reversed),
        open.len()
    ));
    if !open.is_empty() && chance <= CHANCE {
        lines.push("\nNot decided:\n".to_owned());
        lines.extend(open);
    }
    lines
}

/// Reason why an ordering is undecided: result of each engine, and difference compared with scatter.
fn undecided(
    done: &[Done],
    engines: &[&str],
    quantity: &Quantity,
    (small, large): (usize, usize),
    verdicts: &[Verdict],
) -> String {
    let said = engines.iter().zip(verdicts).map(|(engine, verdict)| {
        let spreads = spreads(done, engine, quantity);
        let Some((a, b)) = spreads[small].as_ref().zip(spreads[large].as_ref()) else {
            return format!("{engine}: {}", verdict.words());
        };
        let size = a.high().max(b.high()).max(f64::MIN_POSITIVE);
        let difference = 100.0 * (b.median() - a.median()).abs() / size;
        let starts = 100.0 * (a.high() - a.low()).max(b.high() - b.low()) / size;
        let says = match verdict {
            Verdict::ComesOut => "as in the paper, ",
            Verdict::Reversed => "reversed, ",
            Verdict::NotOk => "has runs that are not ok, ",
            _ => "",
        };
        format!("{engine} engine {says}medians {} % apart, starts up to {} %", digits(difference), digits(starts))
    });
    said.collect::<Vec<_>>().join("; ")
}
