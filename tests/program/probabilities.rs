//! Known probabilities, from the study file to the answer: formula studies through real workers, record, table and estimators.
//!
//! ```text
//! published (events g < 0)
//!   RP22            2.5 - (x1 + x2)/sqrt 2 + 0.1 (x1 - x2)^2                                              4.207305511300e-3
//!   four branches   min of 3 + 0.1 (x1 - x2)^2 -+ (x1 + x2)/sqrt 2, +-(x1 - x2) + 7/sqrt 2                2.222795066194e-3
//!   R - S           N(4, 1) - N(2, 1), correlation 0.5                                                    2.275013194818e-2
//!   RP107           5 sqrt 10 - sum of 10 N(0, 1)                                                         2.866515718792e-7
//! ```
//! The closed forms of all other events stand beside them. The seeds are the first ones tried. Quantiles of the distributions and exact limits are
//! compared with mpmath elsewhere (`core/numerics`, `orchestrator/answers/tests/uncertainty`).

use crate::support::{Folder, json, say};
use bladeoff_numerics::probability::{gamma_tails, normal_tails};
use serde_json::Value;
use std::f64::consts::PI;
use std::fmt::Write;

/// P(N(0, 1) > x).
fn above(x: f64) -> f64 {
    normal_tails(x).1
}

/// A condition and its probability.
struct Event {
    condition: &'static str,
    truth: f64,
}

fn event(condition: &'static str, truth: f64) -> Event {
    Event { condition, truth }
}

/// Runs a study to its end and answers it: the answers, and the printed text.
fn answers(folder: &Folder, name: &str, text: &str) -> (Vec<Value>, String) {
    let study = folder.write(&format!("{name}.toml"), &format!("schema = 1\nmodel = \"function\"\nseed = 12\n{text}"));
    let out = folder.name(name);
    let run = say(&["run", &study, "--out", &out, "--workers", "2"]);
    assert_eq!(run.code, 0, "{name}: {}", run.err);
    let told = say(&["answer", &out, "--json"]);
    assert_eq!(told.code, 0, "{name}: {}", told.err);
    let mut all = json(&told.out);
    assert_eq!(all["complete"], true);
    let Value::Array(answers) = all["answers"].take() else { panic!("{name}: {}", told.out) };
    (answers, run.out)
}

/// Questions for the probability of each event at two confidences.
fn asked(events: &[Event], confidences: &[f64]) -> String {
    let mut text = String::new();
    for (at, event) in events.iter().enumerate() {
        for confidence in confidences {
            let percent = 100.0 * confidence;
            let _ = writeln!(
                text,
                "[[question]]\nname = \"q{at}-{percent:.0}\"\nprobability = \"{}\"\nconfidence = {confidence}",
                event.condition
            );
        }
    }
    text
}

fn uncertain(name: &str, law: &str) -> String {
    let (distribution, keys) = law.split_once(", ").expect("a law and its keys");
    format!("[[uncertain]]\nname = \"{name}\"\ndistribution = \"{distribution}\"\n{}\n", keys.replace("; ", "\n"))
}

fn number(answer: &Value, key: &str) -> f64 {
    answer[key].as_f64().unwrap_or_else(|| panic!("no {key}: {answer}"))
}

/// Whether the limits contain the truth.
fn holds(answer: &Value, truth: f64) -> bool {
    number(answer, "low") <= truth && truth <= number(answer, "high")
}

/// Asserts an error of at most four standard errors of equally many independent points.
#[track_caller]
fn is_near(answer: &Value, truth: f64) {
    let error = (truth * (1.0 - truth) / number(answer, "n")).sqrt();
    let estimate = number(answer, "estimate");
    assert!((estimate - truth).abs() <= 4.0 * error, "{estimate} against {truth}, standard error {error}: {answer}");
}

const NORMALS: [&str; 10] = ["x1", "x2", "x3", "x4", "x5", "x6", "x7", "x8", "x9", "x10"];

/// The published problems with this design.
fn published(design: &str) -> (String, [Event; 4]) {
    let mut text = format!("[design]\n{design}\n");
    NORMALS.iter().for_each(|name| text += &uncertain(name, "normal, mean = 0; sd = 1"));
    text += &(uncertain("r", "normal, mean = 4; sd = 1") + &uncertain("s", "normal, mean = 2; sd = 1"));
    text += "[[correlation]]\nbetween = [\"r\", \"s\"]\nlinear = 0.5\n";
    text += "[function]
rp22 = \"2.5 - (x1 + x2)/sqrt(2) + 0.1*(x1 - x2)^2\"
branches = \"min(3 + 0.1*(x1 - x2)^2 - (x1 + x2)/sqrt(2), 3 + 0.1*(x1 - x2)^2 + (x1 + x2)/sqrt(2), x1 - x2 + 7/sqrt(2), x2 - x1 + 7/sqrt(2))\"
margin = \"r - s\"
rp107 = \"5*sqrt(10) - x1 - x2 - x3 - x4 - x5 - x6 - x7 - x8 - x9 - x10\"
";
    let events = [
        event("rp22 < 0", 4.207305511300e-3),
        event("branches < 0", 2.222795066194e-3),
        event("margin < 0", 2.275013194818e-2),
        event("rp107 < 0", 2.866515718792e-7),
    ];
    (text, events)
}

#[test]
fn published_probabilities_are_within_the_exact_limits_of_independent_points() {
    let folder = Folder::new();
    let (text, events) = published("kind = \"monte-carlo\"\nsamples = 100000");
    let (answers, said) = answers(&folder, "published", &(text + &asked(&events, &[0.95])));
    assert_eq!(answers.len(), events.len());
    for (answer, Event { condition, truth }) in answers.iter().zip(&events) {
        println!("{condition:14} {truth:.4e} {answer}");
        assert_eq!((&answer["n"], &answer["bad"]), (&100_000.into(), &0.into()), "{condition}");
        assert_eq!((&answer["method"], &answer["approximate"]), (&"clopper-pearson".into(), &false.into()));
        assert!(holds(answer, *truth), "{condition}: {truth} is not in {answer}");
        if answer["events"] != 0 {
            is_near(answer, *truth);
            let limits = number(answer, "high") - number(answer, "low");
            assert!(limits < 0.5 * truth, "{condition}: limits that tell nothing: {answer}");
        }
    }
    // an event that was not seen has an upper limit above 0: 1 - 0.025^(1/n)
    let rare = &answers[3];
    assert_eq!((rare["events"].as_u64(), number(rare, "low")), (Some(0), 0.0));
    let bound = 1.0 - 0.025f64.powf(1e-5);
    assert!((number(rare, "high") / bound - 1.0).abs() < 1e-9, "{rare}");
    assert!(said.contains("P(rp107 < 0): no event in 100000 runs, at most 0.0037 %"), "{said}");
}

#[test]
fn replicates_of_even_points_hold_published_probabilities_in_narrower_limits() {
    let folder = Folder::new();
    for kind in ["sobol", "latin-hypercube", "halton"] {
        let (text, events) = published(&format!("kind = \"{kind}\"\nsamples = 2048\nreplicates = 16"));
        let (answers, _) = answers(&folder, kind, &(text + &asked(&events, &[0.95])));
        for (answer, Event { condition, truth }) in answers.iter().zip(&events) {
            println!("{kind:16} {condition:14} {truth:.4e} {answer}");
            assert_eq!((&answer["n"], &answer["approximate"]), (&32768.into(), &true.into()), "{condition}");
            assert!(holds(answer, *truth), "{kind}: {condition}: {truth} is not in {answer}");
            if answer["events"] == 0 {
                assert_eq!(answer["method"], "clopper-pearson", "no event tells no scatter");
                continue;
            }
            assert_eq!(answer["method"], "replicates-t");
            is_near(answer, *truth);
            let independent = 2.0 * 1.96 * (truth * (1.0 - truth) / 32768.0).sqrt();
            let limits = number(answer, "high") - number(answer, "low");
            assert!(limits < 1.5 * independent, "{kind}: {condition}: {limits} against {independent}");
        }
        let width = number(&answers[2], "high") - number(&answers[2], "low");
        let independent = 2.0 * 1.96 * (0.0227 * 0.9773 / 32768f64).sqrt();
        println!("{kind}: R - S in {:.2} of the width of independent points", width / independent);
    }
}

/// Distributions and dependences, each in an event with a closed form.
fn further() -> (String, Vec<Event>) {
    let mut text = String::from("[design]\nkind = \"monte-carlo\"\nsamples = 50000\n");
    let laws = [
        ("l1", "lognormal, median = 1; cv = 0.3"),
        ("l2", "lognormal, median = 2; cv = 0.5"),
        ("l3", "lognormal, median = 1; cv = 0.4"),
        ("l4", "lognormal, median = 1; cv = 0.4"),
        ("shape", "gamma, shape = 3; scale = 2"),
        ("time", "weibull, shape = 1.5; scale = 4"),
        ("g1", "gumbel, location = 10; scale = 2"),
        ("g2", "gumbel, location = 10; scale = 2"),
        ("g3", "gumbel, location = 10; scale = 2"),
        ("w1", "weibull, shape = 2; scale = 3"),
        ("w2", "weibull, shape = 2; scale = 3"),
        ("w3", "weibull, shape = 2; scale = 3"),
        ("blades", "discrete, values = [1, 2, 3]; weights = [5, 4, 1]"),
        ("angle", "periodic, lower = \"0 deg\"; upper = \"360 deg\""),
        ("u1", "uniform, lower = 0; upper = 1"),
        ("u2", "uniform, lower = 0; upper = 1"),
        ("cut", "normal, mean = 0; sd = 1; lower = -1; upper = 3"),
        ("decades", "log-uniform, lower = 1; upper = 1000"),
        ("tri", "triangular, lower = 0; mode = 1; upper = 4"),
        ("be", "beta, a = 2; b = 1; lower = 0; upper = 1"),
        ("ga", "gamma, shape = 2; scale = 1"),
        ("ex", "exponential, mean = 2"),
    ];
    laws.iter().for_each(|(name, law)| text += &uncertain(name, law));
    for (between, strength) in [
        (["l1", "l2"], "linear = 0.4"),
        (["l3", "l4"], "rank = 0.5"),
        (["shape", "time"], "rank = 0.6"),
        (["u1", "g1"], "normal = 0.3"),
    ] {
        let _ = writeln!(text, "[[correlation]]\nbetween = {between:?}\n{strength}");
    }
    text += "[function]
product = \"l1 * l2\"
ratio = \"l3 / l4\"
largest = \"max(g2, g3)\"
weakest = \"min(w1, w2, w3)\"
swing = \"blades * cos(angle)\"
corner = \"u1 + u2\"
";
    // ln(1 + cv^2) of a lognormal; linear correlation by its covariance, rank correlation by 2 sin(pi rho/6)
    let (s1, s2, s3) = (1.09f64.ln(), 1.25f64.ln(), 1.16f64.ln());
    let product = (s1 + s2 + 2.0 * (1.0 + 0.4 * 0.3 * 0.5f64).ln()).sqrt();
    let behind = |rank: f64| 2.0 * (PI * rank / 6.0).sin();
    let ratio = (2.0 * s3 * (1.0 - behind(0.5))).sqrt();
    // medians: gamma of shape 3 has 2.674060314 scales, Weibull ln(2)^(1/1.5)
    let events = vec![
        event("product > 14", above((14f64 / 2.0).ln() / product)),
        event("ratio > 2.5", above(2.5f64.ln() / ratio)),
        // both above their medians, for any distributions: 1/4 + asin(rho)/(2 pi)
        event("shape > 5.3481206274 and time > 3.1328789427", 0.25 + behind(0.6).asin() / (2.0 * PI)),
        // maximum of two: 1 - F^2
        event("largest > 24", 1.0 - (-2.0 * (-7f64).exp()).exp()),
        // minimum of three: 1 - (1 - F)^3
        event("weakest < 0.1", 1.0 - (-3.0 * (0.1f64 / 3.0).powi(2)).exp()),
        event("swing > 2.9", 0.1 * (2.9f64 / 3.0).acos() / PI),
        event("swing > 1.9", 0.4 * (1.9f64 / 2.0).acos() / PI + 0.1 * (1.9f64 / 3.0).acos() / PI),
        // two strips and a corner: the strips overlap, the corner is separate
        event("u1 < 0.002 or u2 < 0.003 or corner > 1.91", 0.002 + 0.003 + 0.5 * 0.09 * 0.09 - 0.002 * 0.003),
        // branches with different variables: 1 - product
        event(
            "weakest < 0.1 or largest > 24 or ex > 18",
            1.0 - (-3.0 * (0.1f64 / 3.0).powi(2)).exp() * (-2.0 * (-7f64).exp()).exp() * (1.0 - (-9f64).exp()),
        ),
        event("cut > 2.5", (above(2.5) - above(3.0)) / (above(-1.0) - above(3.0))),
        event("decades > 900", (1000f64 / 900.0).ln() / 1000f64.ln()),
        event("tri > 3.8", 0.2 * 0.2 / (4.0 * 3.0)),
        event("be < 0.05", 0.05 * 0.05),
        event("ga > 9", 10.0 * (-9f64).exp()),
        event("ex > 18", (-9f64).exp()),
        event("not (ex > 18) and ga <= 9", (1.0 - (-9f64).exp()) * (1.0 - 10.0 * (-9f64).exp())),
    ];
    (text, events)
}

#[test]
fn probabilities_of_all_laws_and_of_dependent_ones_are_those_of_their_closed_forms() {
    let folder = Folder::new();
    let (text, events) = further();
    let (answers, _) = answers(&folder, "further", &(text + &asked(&events, &[0.95, 0.999])));
    let mut held = 0;
    for (both, Event { condition, truth }) in answers.chunks(2).zip(&events) {
        let [usual, wide] = both else { panic!("two of each") };
        println!("{condition:44} {truth:.4e} {usual}");
        is_near(usual, *truth);
        assert!(holds(wide, *truth), "{condition}: {truth} is not in {wide}");
        held += usize::from(holds(usual, *truth));
    }
    // three or more of 16 intervals of 95 % miss with probability 4 %
    assert!(held + 2 >= events.len(), "{held} of {}", events.len());
}

#[test]
fn sums_of_a_hundred_variables_have_the_tails_of_their_sums() {
    let folder = Folder::new();
    let names: Vec<String> = (1..=100).map(|at| format!("x{at}")).collect();
    let study = |design: &str, law: &str, outputs: &str| {
        let laws: String = names.iter().map(|name| uncertain(name, law)).collect();
        let sum = names.join(" + ");
        format!("[design]\n{design}\n{laws}[function]\nsum = \"{sum}\"\n{outputs}\n")
    };
    // sum of exponentials: Erlang distribution; the largest: 1 - (1 - e^-x)^100
    let (some, others) = names.split_at(50);
    let largest = format!("largest = \"max(max({}), {})\"", some.join(", "), others.join(", "));
    let text = study("kind = \"monte-carlo\"\nsamples = 20000", "exponential, mean = 1", &largest);
    let events = [
        event("sum > 125", gamma_tails(100.0, 125.0).1),
        event("sum < 80", gamma_tails(100.0, 80.0).0),
        event("largest > 9", 1.0 - (1.0 - (-9f64).exp()).powi(100)),
    ];
    // Poisson's sum, to check the truth: P(sum > t) = sum of e^-t t^k/k! over k < 100
    let poisson: f64 =
        (0..100).map(|k| (-125.0 + (1..=k).map(|i| (125.0 / f64::from(i)).ln()).sum::<f64>()).exp()).sum();
    assert!((events[0].truth / poisson - 1.0).abs() < 1e-12);
    let (exponential, _) = answers(&folder, "exponential", &(text + &asked(&events, &[0.95])));
    for (answer, Event { condition, truth }) in exponential.iter().zip(&events) {
        println!("{condition:14} {truth:.4e} {answer}");
        assert!(answer["events"].as_u64() > Some(100) && holds(answer, *truth), "{condition}: {answer}");
        is_near(answer, *truth);
    }
    let text = study("kind = \"sobol\"\nsamples = 512\nreplicates = 16", "normal, mean = 0; sd = 0.1", "");
    let events = [event("sum > 2.5", above(2.5))];
    let (normal, _) = answers(&folder, "normal", &(text + &asked(&events, &[0.95])));
    println!("{}", normal[0]);
    assert_eq!(normal[0]["method"], "replicates-t");
    assert!(holds(&normal[0], events[0].truth), "{}", normal[0]);
    is_near(&normal[0], events[0].truth);
}

const FIGURES: &str = r#"
[[uncertain]]
name = "x"
distribution = "exponential"
mean = 1
[[uncertain]]
name = "z"
distribution = "normal"
mean = 0
sd = 1
[[vary]]
name = "k"
values = [1, 2]
[function]
h = "k*x"
[[question]]
name = "q95"
quantile = 0.95
of = "h"
[[question]]
name = "mean"
mean = "h"
[[question]]
name = "q95-apart"
difference = [2, 1]
vary = "k"
quantile = 0.95
of = "h"
[[question]]
name = "mean-apart"
difference = [2, 1]
vary = "k"
mean = "h"
[[question]]
name = "p-apart"
difference = [2, 1]
vary = "k"
probability = "h > 3"
[[question]]
name = "curve"
exceedance = "h"
confidence = 0.99
[[question]]
name = "by-z"
fragility = "z"
probability = "h > 2 - z"
confidence = 0.999
[[question]]
name = "by-k"
fragility = "k"
probability = "h > 3"
"#;

/// Columns of a curve.
fn curve(folder: &Folder, name: &str) -> Vec<(String, Vec<f64>)> {
    let (columns, _) = bladeoff_answers::tables::read_numbers(&folder.path(name)).expect("a curve");
    columns.into_iter().map(|column| (column.name, column.values)).collect()
}

fn cells(curve: &[(String, Vec<f64>)], name: &str) -> Vec<f64> {
    let (_, values) = curve.iter().find(|(column, _)| column == name).unwrap_or_else(|| panic!("no {name}"));
    assert!(values.iter().all(|value| value.is_finite()), "{name}: nulls");
    values.clone()
}

/// P(k x > 2 - z) for z from `low` to `high`: the mean of e^(-(2 - z)/k), at most 1, by the midpoint rule.
fn over(low: f64, high: f64, k: f64) -> f64 {
    let (mut sum, mut weight) = (0.0, 0.0);
    for step in 0..2000 {
        let z = low + (high - low) * (f64::from(step) + 0.5) / 2000.0;
        let density = (-0.5 * z * z).exp();
        sum += density * (-(2.0 - z) / k).min(0.0).exp();
        weight += density;
    }
    sum / weight
}

#[test]
fn quantiles_means_curves_and_paired_differences_hold_their_closed_forms() {
    let folder = Folder::new();
    let rest = ["kind = \"monte-carlo\"\nsamples = 20000", "kind = \"sobol\"\nsamples = 1024\nreplicates = 16"];
    for (name, design) in ["independent", "sobol"].into_iter().zip(rest) {
        let (answers, _) = answers(&folder, name, &format!("[design]\n{design}\n{FIGURES}"));
        let of = |name: &str| answers.iter().filter(|answer| answer["name"] == name).collect::<Vec<_>>();
        let n = number(&answers[0], "n");
        let (q95, deviation) = (20f64.ln(), 1.0 / n.sqrt());
        for (at, k) in [(0, 1.0), (1, 2.0)] {
            for (question, truth, error) in
                [("q95", k * q95, k * 0.19f64.sqrt() / 0.1 * deviation), ("mean", k, k * deviation)]
            {
                let found = of(question)[at];
                println!("{name}: {question} k = {k}: {truth:.4} {found}");
                assert!(holds(found, truth), "{name}: {truth} is not in {found}");
                let off = (number(found, "estimate") - truth).abs();
                assert!(off < 4.0 * error, "{name}: {off} against {error}: {found}");
            }
        }
        for (question, truth) in [("q95-apart", q95), ("mean-apart", 1.0), ("p-apart", (-1.5f64).exp() - (-3f64).exp())]
        {
            let found = of(question)[0];
            println!("{name}: {question}: {truth:.4} {found}");
            assert!(holds(found, truth), "{name}: {truth} is not in {found}");
        }
        // both use the same points: 2 x - x scatters as x does; with other points as sqrt(5) x
        let apart = of("mean-apart")[0];
        assert!(number(apart, "high") - number(apart, "low") < 1.1 * 2.0 * 1.96 * deviation, "{apart}");
        let all = curve(&folder, &format!("{name}/answers/curve.parquet"));
        let [k, level, low, high] = ["k", "level", "low", "high"].map(|name| cells(&all, name));
        assert!(level.len() > 1500);
        let holds = (0..level.len()).filter(|&at| (low[at]..=high[at]).contains(&(-level[at] / k[at]).exp())).count();
        // a band holds at all levels; limits of replicates hold for each level separately
        let least = if name == "independent" { level.len() } else { level.len() * 9 / 10 };
        assert!(holds >= least, "{name}: {holds} of {} levels", level.len());
    }
    let all = curve(&folder, "independent/answers/by-z.parquet");
    let [k, from, to, low, high] = ["k", "from", "to", "low", "high"].map(|name| cells(&all, name));
    assert_eq!(k.len(), 40, "20 bins of each");
    for at in 0..k.len() {
        let truth = over(from[at], to[at], k[at]);
        assert!(low[at] <= truth && truth <= high[at], "z from {} to {}, k = {}: {truth}", from[at], to[at], k[at]);
        assert!(high[at] - low[at] < 0.11, "1000 points a bin");
    }
    let all = curve(&folder, "independent/answers/by-k.parquet");
    let [low, high] = ["low", "high"].map(|name| cells(&all, name));
    for (at, k) in [1.0, 2.0].into_iter().enumerate() {
        let truth = (-3.0f64 / k).exp();
        assert!(low[at] <= truth && truth <= high[at], "k = {k}: {} {truth} {}", low[at], high[at]);
    }
}

#[test]
fn runs_that_fail_where_damage_is_worst_stay_in_and_are_said() {
    let folder = Folder::new();
    // z > 2.5 is the event; failing runs, and the true figures with them harmless and harmful
    let (event, fail) = (above(2.5), above(2.8));
    for (name, formula, harmless, harmful) in [
        ("worst", "ln(2.8 - z)", event - fail, event),
        ("harmless", "ln(2.8 + z)", event, event + fail),
        ("anywhere", "sqrt(u - 0.1)", 0.9 * event, 0.9 * event + 0.1),
    ] {
        let laws = uncertain("z", "normal, mean = 0; sd = 1") + &uncertain("u", "uniform, lower = 0; upper = 1");
        let questions = "
[[question]]
name = \"p\"
probability = \"load > 2.5\"
[[question]]
name = \"known\"
probability = \"z > 2.5\"
[[question]]
name = \"q95\"
quantile = 0.95
of = \"load\"
[[question]]
name = \"mean\"
mean = \"load\"
[[question]]
name = \"curve\"
exceedance = \"load\"
";
        let text = format!(
            "[design]\nkind = \"monte-carlo\"\nsamples = 20000\n{laws}[function]\nload = \"z\"\nother = \"{formula}\"\n{questions}"
        );
        let (answers, said) = answers(&folder, name, &text);
        let [found, known, q95, mean, _] = &answers[..] else { panic!("five answers") };
        println!("{name}: {found}\n{q95}\n{mean}");
        let bad = number(found, "bad");
        let share = if name == "anywhere" { 0.1 } else { fail };
        assert!((bad / 20000.0 - share).abs() < 4.0 * (share / 20000.0).sqrt() && bad > 20.0, "{name}: {bad} fail");
        let [estimate, estimate_harmful] = ["estimate", "estimate_if_bad_harmful"].map(|key| number(found, key));
        for (estimate, truth) in [(estimate, harmless), (estimate_harmful, harmful)] {
            assert!((estimate - truth).abs() < 4.0 * (truth / 20000.0).sqrt(), "{name}: {estimate} against {truth}");
        }
        assert!((estimate_harmful - estimate - bad / 20000.0).abs() < 1e-12, "each of them counts");
        // the limits cover every possible outcome of the bad runs
        assert!(number(found, "low") < harmless && harmful < number(found, "high") && holds(found, event));
        // a parameter is known for bad runs, too
        assert_eq!(known["estimate"], known["estimate_if_bad_harmful"]);
        assert!(holds(known, event));
        let line = said.lines().find(|line| line.contains("P(load > 2.5)")).expect("a sentence");
        assert!(line.contains(" bad runs undecided (the interval covers all possible outcomes)"), "{line}");
        let note = found["notes"].to_string();
        assert!(note.contains("cause most of the uncertainty"), "{name}: {note}");
        // unbounded both ways: the limits of a quantile hold as long as fewer runs fail than lie beyond it
        let truth = 1.6448536269514722;
        assert!(number(q95, "low") <= truth, "{name}: {q95}");
        if name == "anywhere" {
            assert_eq!((&q95["high"], &q95["estimate_if_bad_harmful"]), (&Value::Null, &Value::Null));
        } else {
            assert!(holds(q95, truth), "{name}: {q95}");
        }
        let limits = ["estimate_if_bad_harmful", "low", "high"].map(|key| &mean[key]);
        assert_eq!(limits, [&Value::Null; 3], "{mean}");
        let all = curve(&folder, &format!("{name}/answers/curve.parquet"));
        let [level, low, high] = ["level", "low", "high"].map(|name| cells(&all, name));
        assert!((0..level.len()).all(|at| (low[at]..=high[at]).contains(&above(level[at]))), "{name}: a level");
    }
}
