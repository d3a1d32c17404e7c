//! `bladeoff bench answers`: cost of all figures of a large table, measured on this machine.

use super::super::answer::understood;
use super::super::error::CliError;
use super::super::exit::Exit;
use super::super::output::{print, remark};
use super::cost::measure;
use super::figures::{self, Figure};
use super::host::{Folder, load};
use crate::html_report::{Ahead, Subject, report as page_of};
use crate::questions::{Meant, answer as answers_of, decided, judge, told};
use bladeoff_study::Samples;
use bladeoff_system::files::FileError;
use serde_json::json;
use std::fs;
use std::path::Path;

/// Time and memory of all answers of a large table: probabilities, quantiles, means, curves, differences, a gate
///
/// The tables of two studies of formulas are made in a temporary folder: independent points and replicated Sobol points.
/// Each has two values of a varied parameter, and one run in a hundred failed. A separate process reads each table,
/// compares it with its checksum and answers eleven questions, as `bladeoff answer` and `gate` do. With independent
/// points it also judges a gate. CPU time is printed, because other programs affect only the wall time.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Rows of each table, at least; Sobol points are powers of two
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u64).range(64..=10_000_000))]
    rows: u64,

    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Number of combinations of the varied parameters, and of replicates of the second design.
const GROUPS: u64 = 2;
const REPLICATES: u64 = 16;

const STUDY: &str = r#"schema = 1
model = "function"
seed = 1

[function]
y = "way * x - ln(u)"
fails = "sqrt(u - 0.01)"

[[uncertain]]
name = "x"
distribution = "exponential"
mean = 1

[[uncertain]]
name = "u"
distribution = "uniform"
lower = 0
upper = 1

[[vary]]
name = "way"
values = [1, 2]

[[question]]
name = "probability"
probability = "y > 9.2"

[[question]]
name = "condition"
probability = "y > 9.2 and sqrt(u) < 0.9 or max(y, 3*u) > 12"

[[question]]
name = "quantile"
quantile = 0.95
of = "y"

[[question]]
name = "median"
quantile = 0.5
of = "y"

[[question]]
name = "mean"
mean = "y"

[[question]]
name = "exceedance"
exceedance = "y"

[[question]]
name = "fragility"
fragility = "u"
probability = "y > 4"

[[question]]
name = "by-way"
fragility = "way"
probability = "y > 4"

[[question]]
name = "probabilities-apart"
difference = [2, 1]
vary = "way"
probability = "y > 4"

[[question]]
name = "quantiles-apart"
difference = [2, 1]
vary = "way"
quantile = 0.95
of = "y"

[[question]]
name = "means-apart"
difference = [2, 1]
vary = "way"
mean = "y"
"#;

const GATE: &str = "\n[[gate]]\nrequire = \"P(y > 9.2) < 0.05\"\n";

/// Both studies with their descriptions, files and numbers of rows.
fn studies(rows: u64) -> [(&'static str, String, u64); 2] {
    let points = rows.div_ceil(GROUPS);
    let each = points.div_ceil(REPLICATES).next_power_of_two();
    let independent = format!("{STUDY}{GATE}\n[design]\nkind = \"monte-carlo\"\nsamples = {points}\n");
    let replicated = format!("{STUDY}\n[design]\nkind = \"sobol\"\nsamples = {each}\nreplicates = {REPLICATES}\n");
    [("monte-carlo", independent, GROUPS * points), ("sobol", replicated, GROUPS * each * REPLICATES)]
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let folder = Folder::new()?;
    let load_before = load();
    let mut rows: Vec<Figure> = Vec::new();
    let [first, second] = studies(args.rows);
    let counts = [first.2, second.2];
    let names = [
        (
            "independent points: table made",
            "independent points: answers, CPU",
            "independent points: answers, peak memory",
        ),
        ("Sobol points: table made", "Sobol points: answers, CPU", "Sobol points: answers, peak memory"),
    ];
    for ((word, text, count), (made, cpu, peak)) in [first, second].into_iter().zip(names) {
        let (study, directory) = (folder.0.join(format!("{word}.toml")), folder.0.join(word));
        fs::write(&study, text).map_err(FileError::at("write", &study))?;
        remark(&format!("{count} rows of {word} points: made ..."));
        rows.push((made, measure("tabulate", &study, &directory)?.cpu_s, "s", ""));
        remark(&format!("{count} rows of {word} points: answered ..."));
        let cost = measure("answer", &study, &directory)?;
        rows.push((cpu, cost.cpu_s, "s", "below 10"));
        rows.push((peak, cost.peak_mb, "MB", "below 1000"));
        if word == "monte-carlo" {
            remark("its page: made ...");
            let cost = measure("report", &study, &directory)?;
            let size = fs::metadata(directory.with_extension("html")).ok().map(|page| page.len() as f64 / 1e6);
            rows.push(("independent points: page, CPU", cost.cpu_s, "s", "below 20"));
            rows.push(("independent points: page, size", size, "MB", "below 5"));
        }
    }
    let load_after = load();
    if args.json {
        let figures = figures::json(&rows);
        let text = json!({ "rows": counts, "load_before": load_before, "load_after": load_after, "figures": figures });
        print(&format!("{text}\n"))?;
    } else {
        let [independent, replicated] = counts;
        print(&format!(
            "{independent} and {replicated} rows, load before and after: {load_before}, {load_after}\n\n{}",
            figures::text(&rows)
        ))?;
    }
    Ok(Exit::Ok)
}

/// The report page of a directory, written beside it.
pub(super) fn report(directory: &Path, samples: &Samples) -> Result<(), CliError> {
    let study = samples.study();
    let Meant { questions, gates } = understood(samples, &study.file, &study.text, &study.asked)?;
    let subject = Subject { directory, samples, name: &study.name, questions: &questions, gates: &gates };
    let page = page_of(subject, |_| Ahead::default(), |_| None)?.page.html();
    let path = directory.with_extension("html");
    fs::write(&path, page).map_err(FileError::at("write", &path))?;
    Ok(())
}

/// All answers and decisions of a study about its directory, in words.
pub(super) fn answer(directory: &Path, samples: &Samples) -> Result<String, CliError> {
    let study = samples.study();
    let Meant { questions, gates } = understood(samples, &study.file, &study.text, &study.asked)?;
    let answering = answers_of(directory, samples, &questions)?;
    let mut text = told(&answering) + &answering.answers.json().map_err(|error| CliError::stdout(error.into()))?;
    if !gates.is_empty() {
        let (decisions, points, of) = judge(directory, samples, &gates)?;
        text += &decided(&decisions, points, of);
    }
    Ok(text)
}
