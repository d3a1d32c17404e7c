//! Coverage of the intervals over repeated small studies with known answers: points of the designs of studies, evaluated by the
//! estimators. The table for this number of studies of each kind (1000: about five minutes):
//! `COVERAGE_STUDIES=1000 cargo test --release --workspace --test program coverage:: -- --nocapture`.
//!
//! ```text
//! y = -ln u1 - ln u2        P(y > x) = e^-x (1 + x), mean 2; given u1 = u: min(1, e^-x/u)
//! z = -ln u1 - 0.8 ln u2    P(z > x) = (1.25 e^-x - e^(-1.25 x))/0.25, mean 1.8
//! ```
//! Failing runs: half of the runs with y above 4 fail, and one in a hundred of the others, so that failures correlate with damage. Most of
//! them (in a second kind, all) have the value reached while the guards held.

#[path = "../../orchestrator/answers/tests/uncertainty/support/mod.rs"]
#[allow(dead_code, reason = "made for the tests of the answers")]
mod made_tables;

use bladeoff_answers::ask::{Answer, Answered, QuestionDef, answer};
use bladeoff_answers::estimate::figures::Method;
use bladeoff_answers::estimate::input::DesignKind;
use bladeoff_answers::gate::{Gate, Verdict, verdict};
use bladeoff_study::correlation::Copula;
use bladeoff_study::sampling::layout::{LayoutDef, LayoutKind, SamplingLayout};
use bladeoff_study::sampling::sequence::random::Source;
use bladeoff_study::uncertain::{Distribution, Uncertain, Written};
use bladeoff_text::formula::{Function, call};
use made_tables::made::{Made, MadeColumn};
use made_tables::{asked, less, names};

/// A line of the table.
struct Line {
    name: String,
    approximate: bool,
    /// Studies whose limits contain the truth, studies with limits, and studies without.
    held: u32,
    of: u32,
    without: u32,
    /// Mean width of the intervals.
    width: f64,
    method: Method,
}

/// P(y > x).
fn y_above(x: f64) -> f64 {
    (-x).exp() * (1.0 + x)
}
fn z_above(x: f64) -> f64 {
    (1.25 * (-x).exp() - (-1.25 * x).exp()) / 0.25
}

/// Level with the exceedance probability p.
fn level(above: fn(f64) -> f64, p: f64) -> f64 {
    let (mut low, mut high) = (0.0, 100.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if above(middle) > p { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Points of a design with two variables.
fn points_of(kind: DesignKind, seed: u64, replicates: usize, samples: usize) -> Vec<[f64; 2]> {
    let def = LayoutDef {
        samples: Some(samples as u64),
        replicates: (replicates > 1).then_some(replicates as u64),
        ..LayoutDef::new(LayoutKind::from_word(kind.word()).expect("a kind of design"))
    };
    let numbers = [("lower", 0.0), ("upper", 1.0)].map(|(key, number)| (key.to_owned(), number));
    let written = Written { numbers: numbers.into_iter().collect(), ..Written::default() };
    let law = Uncertain::new(Distribution::from_word("uniform").expect("a law"), &written, "").expect("a law");
    let names = ["u1", "u2"].map(str::to_owned);
    let layout =
        SamplingLayout::new(&def, seed, &names, &[law.clone(), law], &Copula::independent(2)).expect("a design");
    let point = |index| {
        let mut point = [0.0; 2];
        layout.fill(index, &mut point);
        point
    };
    (0..layout.count()).map(point).collect()
}

/// A study of y, or of y and z alternately; `failing`: with failing runs, of which this share has a reached value.
fn study(kind: DesignKind, seed: u64, replicates: usize, samples: usize, paired: bool, failing: Option<f64>) -> Made {
    let points = points_of(kind, seed, replicates, samples);
    let mut cells = Vec::new();
    for point in &points {
        let [a, b] = point.map(|u| -call(Function::Ln, &[u]));
        cells.push(Some(a + b));
        if paired {
            cells.push(Some(a + 0.8 * b));
        }
    }
    let given = points.iter().flat_map(|point| std::iter::repeat_n(Some(point[0]), 1 + usize::from(paired)));
    let mut made = Made::new(vec![("y", cells), ("u", given.collect())]);
    made.columns[1].nature = 'g';
    made.replicate = (0..points.len()).map(|point| (point % replicates) as u32).collect();
    (made.kind, made.replicates) = (kind, replicates);
    if paired {
        made = made.varied("way", &["a", "b"]);
    }
    if let Some(part) = failing {
        made.columns[0].nature = '>';
        let source = Source::new(seed, "failures", 0);
        for row in 0..made.status.len() {
            let mut draw = [0.0; 2];
            source.fill(row as u64, &mut draw);
            let value = made.columns[0].cells[row].expect("a value");
            if draw[0] < if value > 4.0 { 0.5 } else { 0.01 } {
                made.fail(row, "diverged");
                // lost, but some with the value reached while the guards held
                made.columns[0].cells[row] = Some(1e9 * draw[1]);
                made.columns[0].held[row] = (draw[1] < part).then_some(value * draw[1]);
            }
        }
    }
    made
}

struct Counter<'a> {
    lines: Vec<Line>,
    repeats: u32,
    each: &'a mut dyn FnMut(&Line),
}

impl Counter<'_> {
    /// Counts how often `holds` is true for the answer.
    fn count(&mut self, name: &str, make: impl Fn(u64) -> Made, def: QuestionDef, holds: impl Fn(&Answered) -> bool) {
        let question = asked(def);
        let (mut held, mut without, mut width, mut wide, mut first) = (0, 0, 0.0, 0u32, None::<Answer>);
        for repeat in 0..self.repeats {
            let made = make(1000 + u64::from(repeat));
            let answered = answer(&made.study(), &question).expect("an answer");
            let one = &answered.answers[0];
            if answered.curve.is_none() && one.low.is_none() && one.high.is_none() {
                without += 1;
            } else {
                held += u32::from(holds(&answered));
            }
            if let (Some(low), Some(high)) = (one.low, one.high) {
                width += high - low;
                wide += 1;
            }
            first.get_or_insert_with(|| one.clone());
        }
        let first = first.expect("a study");
        let width = width / f64::from(wide.max(1));
        let line = Line {
            name: name.to_owned(),
            approximate: first.approximate,
            held,
            of: self.repeats - without,
            without,
            width,
            method: first.method,
        };
        (self.each)(&line);
        self.lines.push(line);
    }
}

/// Whether the limits of the first answer contain a number; a missing limit contains any.
fn within(truth: f64) -> impl Fn(&Answered) -> bool {
    move |answered| {
        let one = &answered.answers[0];
        one.low.is_none_or(|low| low <= truth) && one.high.is_none_or(|high| truth <= high)
    }
}

/// Whether the limits of a curve hold at all levels, or at the level next to `probe`.
fn at_levels(all: bool, probe: f64) -> impl Fn(&Answered) -> bool {
    move |answered| {
        let curve = answered.curve.as_ref().expect("a curve");
        let [level, low, high] = ["level", "low", "high"].map(|name| curve.numbers(name).expect("a column"));
        let holds = |at: usize| {
            let [x, low, high] = [level, low, high].map(|column| column[at].expect("a number"));
            low <= y_above(x) && y_above(x) <= high
        };
        if all {
            return (0..level.len()).all(holds);
        }
        holds(level.partition_point(|x| x.expect("a number") < probe).min(level.len() - 1))
    }
}

/// Whether the limits of the bin next to `probe` contain P(y > x) over the bin.
fn in_bin(x: f64, probe: f64) -> impl Fn(&Answered) -> bool {
    // for u below e^-x all, above it e^-x/u
    let below = move |u: f64| {
        let edge = (-x).exp();
        if u < edge { u } else { edge * (1.0 + (u / edge).ln()) }
    };
    move |answered| {
        let curve = answered.curve.as_ref().expect("a curve");
        let [from, to, low, high] = ["from", "to", "low", "high"].map(|name| curve.numbers(name).expect("a column"));
        let at = to.partition_point(|to| to.expect("a number") < probe);
        let [from, to, low, high] = [from, to, low, high].map(|column| column[at].expect("a number"));
        let truth = (below(to) - below(from)) / (to - from);
        low <= truth && truth <= high
    }
}

fn probability(x: f64) -> QuestionDef {
    QuestionDef { probability: Some(format!("y > {x}")), ..QuestionDef::default() }
}

/// All kinds, each over this number of studies; `each` is called with every finished line.
fn table(repeats: u32, each: &mut dyn FnMut(&Line)) -> Vec<Line> {
    let mut counter = Counter { lines: Vec::new(), repeats, each };
    let quantile = |u| QuestionDef { quantile: Some(u), of: Some("y".into()), ..QuestionDef::default() };
    let mean = || QuestionDef { mean: Some("y".into()), ..QuestionDef::default() };
    let curve = || QuestionDef { exceedance: Some("y".into()), ..QuestionDef::default() };
    use DesignKind::{Halton, LatinHypercube, MonteCarlo, Sobol};
    for (kind, replicates, samples) in
        [(MonteCarlo, 1, 1024), (Sobol, 16, 64), (LatinHypercube, 16, 64), (Halton, 16, 64)]
    {
        for failing in [None, Some(0.7)] {
            let word = format!("{}{}", kind.word(), if failing.is_some() { ", failing" } else { "" });
            let make = |paired| move |seed| study(kind, seed, replicates, samples, paired, failing);
            for p in [0.3, 0.05, 0.01, 0.002] {
                let x = level(y_above, p);
                counter.count(&format!("{word}: probability {p}"), make(false), probability(x), within(p));
            }
            // one variable, next to a boundary of the strata: replicates hardly scatter
            let edge = 31.97 / 64.0;
            let def = QuestionDef { probability: Some(format!("u < {edge}")), ..QuestionDef::default() };
            counter.count(&format!("{word}: probability of one variable"), make(false), def, within(edge));
            for u in [0.5, 0.95] {
                let truth = level(y_above, 1.0 - u);
                counter.count(&format!("{word}: quantile {u}"), make(false), quantile(u), within(truth));
            }
            counter.count(&format!("{word}: mean"), make(false), mean(), within(2.0));
            let all = kind == MonteCarlo;
            let probe = level(y_above, 0.2);
            counter.count(&format!("{word}: exceedance"), make(false), curve(), at_levels(all, probe));
            let x = level(y_above, 0.05);
            for probe in [0.03, 0.52] {
                let def = QuestionDef { fragility: Some("u".into()), ..probability(x) };
                counter.count(&format!("{word}: fragility at {probe}"), make(false), def, in_bin(x, probe));
            }
            for p in [0.3, 0.01] {
                let x = level(y_above, p);
                let truth = p - z_above(x);
                counter.count(
                    &format!("{word}: difference of probability {p}"),
                    make(true),
                    less(probability(x)),
                    within(truth),
                );
            }
            let truth = level(y_above, 0.05) - level(z_above, 0.05);
            counter.count(
                &format!("{word}: difference of quantile 0.95"),
                make(true),
                less(quantile(0.95)),
                within(truth),
            );
            counter.count(&format!("{word}: difference of mean"), make(true), less(mean()), within(0.2));
        }
    }
    counter.lines
}

/// Wrong decisions of a gate at the edge of its bound: (passed, failed) in an incomplete study, and with the complete study after all interim
/// analyses, over this number of studies of 2^13 points analysed every 256.
fn gates(repeats: u32) -> ([u32; 2], [u32; 2]) {
    let bound = 0.05;
    let x = level(y_above, bound);
    let gate = Gate::new(&format!("P(y > {x}) < {bound}"), None, &names()).expect("a gate");
    let (mut looked, mut both) = ([0; 2], [0; 2]);
    for repeat in 0..repeats {
        let whole = study(DesignKind::MonteCarlo, 5000 + u64::from(repeat), 1, 1 << 13, false, None);
        let mut seen = [false; 2];
        for points in (256..1 << 13).step_by(256) {
            let part = Made {
                columns: whole
                    .columns
                    .iter()
                    .map(|column| MadeColumn {
                        name: column.name,
                        nature: column.nature,
                        cells: column.cells[..points].to_vec(),
                        held: Vec::new(),
                        unjudged: column.unjudged,
                    })
                    .collect(),
                status: whole.status[..points].to_vec(),
                causes: whole.causes[..points].to_vec(),
                ends: whole.ends[..points].to_vec(),
                groups: whole.groups.clone(),
                replicate: whole.replicate[..points].to_vec(),
                complete: false,
                ..Made::new(vec![("y", Vec::new())])
            };
            match verdict(&gate.judge(&part.study()).expect("a decision")) {
                Verdict::Passed => seen[0] = true,
                Verdict::Failed => seen[1] = true,
                Verdict::Open => continue,
            }
            break;
        }
        // at the bound a pass is wrong, and just below it (practically the same study) a failure
        for at in 0..2 {
            looked[at] += u32::from(seen[at]);
        }
        if seen == [false; 2] {
            match verdict(&gate.judge(&whole.study()).expect("a decision")) {
                Verdict::Passed => seen[0] = true,
                Verdict::Failed => seen[1] = true,
                Verdict::Open => {}
            }
        }
        for at in 0..2 {
            both[at] += u32::from(seen[at]);
        }
    }
    (looked, both)
}

fn studies() -> Option<u32> {
    std::env::var("COVERAGE_STUDIES").ok().map(|word| word.parse().expect("a number of studies"))
}

#[test]
fn intervals_hold_as_often_as_they_say() {
    let asked = studies();
    if asked.is_some() {
        println!("{:<54} {:<33} {:>10} {:>9} {:>11}", "kind", "method", "held", "no limit", "mean width");
    }
    let lines = table(asked.unwrap_or(40), &mut |line| {
        let about = if line.approximate { " (about)" } else { "" };
        let method = format!("{}{about}", line.method.word());
        let held = format!("{}/{}", line.held, line.of);
        if asked.is_some() {
            println!("{:<54} {method:<33} {held:>10} {:>9} {:>11.4e}", line.name, line.without, line.width);
        }
    });
    assert_eq!(lines.len(), 4 * 2 * 15, "four kinds of design, without and with failing runs");
    for line in &lines {
        // 95 % (approximate: 92 %) less three standard deviations for this number of studies
        let share = if line.approximate { 0.92 } else { 0.95 };
        let of = f64::from(line.of);
        let least = share * of - 3.0 * (share * (1.0 - share) * of).sqrt();
        let least = if line.of >= 1000 { if line.approximate { 0.9 * of } else { 0.924 * of } } else { least };
        assert!(f64::from(line.held) >= least, "{}: {} of {}", line.name, line.held, line.of);
    }
    let with = lines.iter().filter(|line| line.without == 0).count();
    assert!(with > 100, "{with} kinds have an interval in every study");
}

#[test]
fn many_looks_at_a_gate_and_the_coverage_of_its_decisions() {
    let repeats = studies().unwrap_or(60);
    let (looked, both) = gates(repeats);
    println!(
        "gate at its bound, looked at every 256 of 8192 points: {looked:?} false passes and failures of {repeats}"
    );
    println!("the same, and the complete study in the end: {both:?}");
    // 5 % and three standard deviations
    let most = 0.05 * f64::from(repeats) + 3.0 * (0.05 * 0.95 * f64::from(repeats)).sqrt();
    assert!(looked.iter().all(|count| f64::from(*count) <= most), "{looked:?}");
}
