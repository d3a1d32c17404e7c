//! How often the interval that ends a study by `[stop]` covers the true value, and how many points the study needs, in comparison with error spending
//! over the interim analyses. Tested with the points of the designs and the estimators of answers. For the table of docs/intervals.md:
//! `STOP_STUDIES=1000 cargo test --release -p bladeoff --test program stop_coverage:: -- --nocapture` (about 5 minutes; `STOP_CASES=halton`: only the
//! kinds whose name contains this word).

use bladeoff_answers::estimate::figures::Figures;
use bladeoff_answers::estimate::known::Values;
use bladeoff_answers::estimate::mean::mean;
use bladeoff_answers::estimate::proportion::{Tally, proportion};
use bladeoff_answers::estimate::quantile::quantile;
use bladeoff_answers::estimate::scheme::Scheme;
use bladeoff_answers::stop::{StopRule, interim_analyses};
use bladeoff_numerics::probability::normal_quantile;
use bladeoff_study::correlation::Copula;
use bladeoff_study::sampling::layout::{LayoutDef, LayoutKind, SamplingLayout};
use bladeoff_study::uncertain::{Distribution, Uncertain, Written};

/// Largest number of points of a study.
const MOST: u64 = 1 << 16;
/// Number of replicates for designs that need replicates.
const REPLICATES: u64 = 16;
const ALPHA: f64 = 0.05;
/// Relative half width that the first interim analysis reaches in any case: a study of 256 planned points.
const PLANNED: f64 = 1.0;

/// A figure of the output.
#[derive(Clone, Copy)]
enum Of {
    /// P(output > level).
    Above(f64),
    Quantile(f64),
    Mean,
}

/// The output at a point of two coordinates, by its name in the table.
fn output(name: &str, u: &[f64; 2]) -> f64 {
    let normal = |u: f64| normal_quantile(u, 1.0 - u);
    match name {
        "uniform" => u[0],
        "normal" => 5.0 + normal(u[0]),
        "gamma" => -u[0].ln() - u[1].ln(),
        "lognormal" => normal(u[0]).exp(),
        other => panic!("no output {other}"),
    }
}

fn layout(kind: LayoutKind, seed: u64) -> SamplingLayout {
    let is_single = kind == LayoutKind::MonteCarlo;
    let samples = if is_single { MOST } else { MOST / REPLICATES };
    let def =
        LayoutDef { samples: Some(samples), replicates: (!is_single).then_some(REPLICATES), ..LayoutDef::new(kind) };
    let numbers = [("lower", 0.0), ("upper", 1.0)].map(|(key, number)| (key.to_owned(), number));
    let written = Written { numbers: numbers.into_iter().collect(), ..Written::default() };
    let law = Uncertain::new(Distribution::from_word("uniform").expect("a law"), &written, "").expect("a law");
    let names = ["u1", "u2"].map(str::to_owned);
    SamplingLayout::new(&def, seed, &names, &[law.clone(), law], &Copula::independent(2)).expect("a design")
}

/// The points of a design, computed once for all kinds of study with this design.
struct Points {
    layout: SamplingLayout,
    known: Vec<[f64; 2]>,
}

impl Points {
    fn up_to(&mut self, count: u64) -> &[[f64; 2]] {
        for index in self.known.len() as u64..count {
            let mut point = [0.0; 2];
            self.layout.fill(index, &mut point);
            self.known.push(point);
        }
        &self.known[..count as usize]
    }
}

/// A kind of study: design, output, figure, its true value and the largest permitted relative half width.
#[derive(Clone, Copy)]
struct Case {
    kind: LayoutKind,
    output: &'static str,
    of: Of,
    truth: f64,
    relative: f64,
}

impl Case {
    fn name(&self) -> String {
        let of = match self.of {
            Of::Above(_) => format!("probability {:.0} %", 100.0 * self.truth),
            Of::Quantile(u) => format!("quantile {u}, {}", self.output),
            Of::Mean => format!("mean, {}", self.output),
        };
        if self.relative == PLANNED {
            return format!("{}: {of}, 256 points", self.kind.word());
        }
        format!("{}: {of}, within {} %", self.kind.word(), 100.0 * self.relative)
    }

    fn scheme(&self) -> Scheme {
        if self.kind == LayoutKind::MonteCarlo { Scheme::Independent } else { Scheme::Replicated(REPLICATES as usize) }
    }

    fn figures(&self, values: &[f64], alpha: f64) -> Figures {
        let scheme = self.scheme();
        let part = |point: usize| point % scheme.parts();
        if let Of::Above(level) = self.of {
            let mut tallies = vec![Tally::default(); scheme.parts()];
            for (point, value) in values.iter().enumerate() {
                let tally = &mut tallies[part(point)];
                let event = u64::from(*value > level);
                *tally = Tally { n: tally.n + 1, low: tally.low + event, high: tally.high + event };
            }
            return proportion(&tallies, &scheme, alpha);
        }
        let of = Values {
            point: (0..values.len() as u32).collect(),
            low: values.to_vec(),
            high: values.to_vec(),
            ..Values::default()
        };
        match self.of {
            Of::Quantile(u) => quantile(&of, u, &scheme, part, alpha),
            _ => mean(&of, &scheme, part, alpha),
        }
    }

    /// Whether the interval at the end of a study covers the true value, and the number of points of the study; `spends`: with error
    /// spending.
    fn end(&self, values: &mut Vec<f64>, points: &mut Points, spends: bool) -> (bool, u64) {
        let rule = StopRule { relative: Some(self.relative), ..StopRule::default() };
        for look in interim_analyses(MOST, ALPHA) {
            let begin = values.len();
            values.extend(points.up_to(look.points).iter().skip(begin).map(|point| output(self.output, point)));
            let seen = &values[..look.points as usize];
            let found = self.figures(seen, if spends { look.alpha } else { ALPHA });
            if look.is_last || rule.is_enough(std::slice::from_ref(&found)) {
                let holds =
                    found.low.is_some_and(|low| low <= self.truth) && found.high.is_some_and(|high| self.truth <= high);
                return (holds, look.points);
            }
        }
        unreachable!("the last analysis ends a study")
    }
}

/// The coverage of plain limits and of error spending, and the ratio of the mean numbers of points.
struct Measured {
    plain: f64,
    spending: f64,
    points: [f64; 2],
}

/// Measures kinds of study with the same design.
fn measured(cases: &[Case], repeats: u64) -> Vec<Measured> {
    let mut counts = vec![([0u64; 2], [0u64; 2]); cases.len()];
    for repeat in 0..repeats {
        let mut points = Points { layout: layout(cases[0].kind, 7000 + repeat), known: Vec::new() };
        for (case, (held, ends)) in cases.iter().zip(&mut counts) {
            let mut values = Vec::new();
            for (at, spends) in [false, true].into_iter().enumerate() {
                let (holds, end) = case.end(&mut values, &mut points, spends);
                held[at] += u64::from(holds);
                ends[at] += end;
            }
        }
    }
    let share = |count: u64| count as f64 / repeats as f64;
    let measured = |(held, ends): ([u64; 2], [u64; 2])| Measured {
        plain: share(held[0]),
        spending: share(held[1]),
        points: ends.map(share),
    };
    counts.into_iter().map(measured).collect()
}

fn cases() -> Vec<Case> {
    let gamma_above = |x: f64| (-x).exp() * (1.0 + x);
    // bisection for the quantiles of the sum of two exponential variables
    let gamma_level = |p: f64| {
        let (mut low, mut high) = (0.0, 100.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if gamma_above(middle) > p { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    };
    let mut all = Vec::new();
    for kind in [LayoutKind::MonteCarlo, LayoutKind::Sobol, LayoutKind::LatinHypercube, LayoutKind::Halton] {
        let mut add = |output, of, truth, widths: [f64; 2]| {
            all.extend(widths.map(|relative| Case { kind, output, of, truth, relative }));
        };
        for p in [0.5, 0.2, 0.05] {
            add("gamma", Of::Above(gamma_level(p)), p, [0.2, 0.1]);
        }
        add("gamma", Of::Quantile(0.5), gamma_level(0.5), [0.05, 0.02]);
        add("gamma", Of::Quantile(0.95), gamma_level(0.05), [0.05, 0.02]);
        add("normal", Of::Mean, 5.0, [0.02, 0.005]);
        add("gamma", Of::Mean, 2.0, [0.05, 0.02]);
        let e = 0.5f64.exp();
        add("lognormal", Of::Mean, e, [0.1, 0.05]);
        all.push(Case { kind, output: "lognormal", of: Of::Mean, truth: e, relative: PLANNED });
    }
    all
}

#[test]
fn the_interval_that_ends_a_study_covers_the_true_value_about_as_often_as_it_states() {
    let asked: Option<u64> = std::env::var("STOP_STUDIES").ok().map(|word| word.parse().expect("a number of studies"));
    let wanted = std::env::var("STOP_CASES").unwrap_or_default();
    let repeats = asked.unwrap_or(40);
    let (mut covered, mut counted) = (0.0, 0.0);
    let cases: Vec<Case> = cases().into_iter().filter(|case| case.name().contains(&wanted)).collect();
    let all = cases.chunk_by(|a, b| a.kind == b.kind).flat_map(|cases| measured(cases, repeats));
    for (case, Measured { plain, spending, points: [fewer, more] }) in cases.iter().zip(all) {
        if asked.is_some() {
            println!(
                "{:<56} plain {:5.1} %, spending {:5.1} %, {fewer:7.0} points of {more:7.0}: {:.2}",
                case.name(),
                100.0 * plain,
                100.0 * spending,
                fewer / more
            );
        }
        let is_skewed = case.output == "lognormal";
        let least: f64 = if is_skewed { 0.83 } else { 0.92 };
        let deviation = (least * (1.0 - least) / repeats as f64).sqrt();
        assert!(plain >= least - 3.0 * deviation, "{}: {plain}", case.name());
        assert!(fewer <= more, "{}: {fewer} of {more}", case.name());
        // with independent points error spending needs two to four times as many points, if one analysis is not enough
        if case.kind == LayoutKind::MonteCarlo && more > 256.5 {
            assert!((0.2..=0.6).contains(&(fewer / more)), "{}: {fewer} of {more}", case.name());
        }
        if !is_skewed {
            (covered, counted) = (covered + plain, counted + 1.0);
        }
    }
    assert!(counted == 0.0 || covered / counted > 0.935, "{covered} of {counted}");
}
