//! The report: the table, the orderings, and what was measured about their causes.

use super::causes::causes;
use super::runs::Done;
use super::separation::{CHANCE, Spread, Verdict, accident};

pub(super) const DETECTIONS: [&str; 3] = ["hyp1", "hyp2", "hyp2-frozen"];
/// Pairs of detections.
const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

/// A row of the table.
pub(super) struct Quantity {
    pub name: &'static str,
    /// The paper's values for hyp1, hyp2, hyp2-frozen in the shown unit; `None`: a row of our own.
    pub paper: Option<[f64; 3]>,
    /// Ours in the shown unit.
    pub ours: fn(&Done) -> Option<f64>,
}

pub(super) const CPU: Quantity =
    Quantity { name: "CPU time [s]", paper: Some([7742.0, 24743.0, 6845.0]), ours: |run| Some(run.cpu) };
pub(super) const LOAD: Quantity = Quantity {
    name: "max load on bearing [1e5 N]",
    paper: Some([5.46, 4.95, 5.36]),
    ours: |run| Some(run.value("max_bearing_load_N")? * 1e-5),
};
pub(super) const FORCE: Quantity = Quantity {
    name: "max contact force [MN]",
    paper: Some([3.49, 4.29, 7.53]),
    ours: |run| Some(run.value("max_contact_force_N")? * 1e-6),
};
pub(super) const PENETRATION: Quantity = Quantity {
    name: "residual penetration [1e-2 mm]",
    paper: Some([5.88, 6.75, 12.36]),
    ours: |run| Some(run.value("residual_penetration_m")? * 1e5),
};
pub(super) const MEAN_FORCE: Quantity = Quantity {
    name: "max contact force, 1 ms mean [MN]",
    paper: None,
    ours: |run| Some(run.value("max_filtered_contact_force_N")? * 1e-6),
};
/// The rows of the paper's Table 1, and then some of our own that converge with the step.
const TABLE: [&Quantity; 7] = [
    &CPU,
    &LOAD,
    &FORCE,
    &PENETRATION,
    &MEAN_FORCE,
    &Quantity { name: "friction energy [MJ]", paper: None, ours: |run| Some(run.value("friction_energy_J")? * 1e-6) },
    &Quantity { name: "end speed [rad/s]", paper: None, ours: |run| run.value("end_speed_rad_s") },
];

/// The report as Markdown.
pub(super) fn report(done: &[Done]) -> String {
    let engines: Vec<&str> =
        ["reduced", "full"].into_iter().filter(|engine| done.iter().any(|run| run.engine == *engine)).collect();
    let starts = 1 + done.iter().map(|run| run.start).max().unwrap_or(0);
    let mut lines = vec![
        "# Table 1 of DETC2007-34625 beside ours".to_owned(),
        String::new(),
        "The machine is ours (`studies/machines/lp_turbine.toml`), not the paper's, whose data are not printed; its braking is"
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

/// Three significant digits, four from 100 on.
pub(super) fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e5).contains(&size) {
        return format!("{value:.1e}");
    }
    let decimals = (2 - size.log10().floor() as i32).max(1) as usize;
    let decimals = if size >= 1e3 { 0 } else { decimals };
    format!("{value:.decimals$}")
}

/// A ratio; where the smaller one is rounding, only that it is.
pub(super) fn ratio(large: f64, small: f64) -> String {
    if large > 1e6 * small { "×>1e6".to_owned() } else { format!("×{}", digits(large / small)) }
}

pub(super) fn spreads(done: &[Done], engine: &str, quantity: &Quantity) -> [Option<Spread>; 3] {
    DETECTIONS.map(|detection| Spread::of(done, engine, detection, quantity.ours))
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

/// The paper's orderings, what each engine says about them, and what is claimed.
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
            if engines.len() > 1 { "both engines say so" } else { "the engine that was run says so" },
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

/// Why an ordering is left open: what each engine says of it, its difference against its scatter.
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
            Verdict::ComesOut => "says so, ",
            Verdict::Reversed => "says the opposite, ",
            Verdict::NotOk => "has runs that are not ok, ",
            _ => "",
        };
        format!("{engine} engine {says}medians {} % apart, starts up to {} %", digits(difference), digits(starts))
    });
    said.collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_three_digits() {
        for (value, text) in
            [(13.0, "13.0"), (1.0, "1.00"), (118.23, "118.2"), (7742.0, "7742"), (2.2e-10, "2.2e-10"), (0.0, "0")]
        {
            assert_eq!(digits(value), text);
        }
        assert_eq!(ratio(6.5, 2e-10), "×>1e6");
    }

    #[test]
    fn the_paper_s_numbers_are_the_paper_s() {
        assert_eq!(CPU.paper, Some([7742.0, 24743.0, 6845.0]));
        assert_eq!(LOAD.paper, Some([5.46, 4.95, 5.36]));
        assert_eq!(FORCE.paper, Some([3.49, 4.29, 7.53]));
        assert_eq!(PENETRATION.paper, Some([5.88, 6.75, 12.36]));
    }
}
