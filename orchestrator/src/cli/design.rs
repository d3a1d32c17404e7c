//! `bladeoff design export`: points of a design for other programs.
//!
//! ```text
//! SALib   a problem (num_vars, names, bounds, dists) as JSON, and the points as CSV          salib.readthedocs.io
//!         unif [from, to], triang [from, to, peak as part of the width], norm [mean, sd],
//!         truncnorm [from, to, mean, sd], lognorm [mean, sd of ln x], logunif [from, to], weibull [shape, scale]
//! Dakota  annotated tabular data: `%eval_id interface`, variables, responses, between spaces  snl-dakota.github.io
//! ```

use super::error::CliError;
use super::exit::Exit;
use super::output::remark;
use super::refusals::DesignExportError;
use super::run::PartArgs;
use super::why::frozen;
use crate::run::directory::read_current;
use crate::run::refuse_changed;
use crate::run::shards::row_files;
use bladeoff_answers::summary::counted;
use bladeoff_answers::tables::Table;
use bladeoff_model::machine::ParamValue;
use bladeoff_study::derived::Variable;
use bladeoff_study::uncertain::{Plain, Uncertain};
use bladeoff_study::{Origin, Parameter, Samples};
use bladeoff_system::files::{FileError, Pending};
use bladeoff_system::shown;
use clap::Subcommand;
use serde_json::json;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// The points of a design for other programs
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    Export(ExportArgs),
}

/// The long help.
const ABOUT: &str = "\
Write the points of a design for SALib and Dakota

The folder gets three files:

  salib-problem.json   the problem with its distributions
  salib-points.csv     one row per point, one column per
                       variable of the problem
  dakota.dat           annotated tabular data of Dakota,
                       one row per sample

A column is named by the full path of its parameter with the SI unit, or by the name of its variable. Numbers are in SI. \
[points] of a study reads both tables. A distribution that SALib does not have is missing in its two files, with a message. \
Correlations are in the points, not in the problem.";

/// Write the points of a design for SALib and Dakota
#[derive(Debug, clap::Args)]
#[command(long_about = ABOUT, after_help = "Examples:
  bladeoff design export studies/blade-off-risk.toml \\
    --out design
  bladeoff design export runs/blade-off-risk --out design \\
    --response max_bearing_load_N")]
struct ExportArgs {
    /// Study file, or result directory of `bladeoff run`
    #[arg(value_name = "STUDY|DIRECTORY")]
    path: PathBuf,

    /// Folder, made if it does not exist; no file in it is overwritten
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,

    /// Column of the results as a response of dakota.dat; may be given several times. Empty cells and those of runs that
    /// are not ok are nan
    #[arg(long, value_name = "COLUMN")]
    response: Vec<String>,

    #[command(flatten)]
    part: PartArgs,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let What::Export(args) = &args.what;
    let samples = if args.path.is_dir() { frozen(&args.path)? } else { args.part.load(&args.path)? };
    if samples.layout().is_none() {
        return Err(DesignExportError::None { path: args.path.clone() }.into());
    }
    let responses = responses(args, &samples)?;
    let files = ["salib-problem.json", "salib-points.csv", "dakota.dat"].map(|name| args.out.join(name));
    if let Some(path) = files.iter().find(|path| path.symlink_metadata().is_ok()) {
        return Err(CliError::Exists { path: path.clone() });
    }
    fs::create_dir_all(&args.out).map_err(FileError::at("create", &args.out))?;
    let problem = Problem::of(&samples);
    problem.left_out.iter().for_each(|why| remark(&format!("left out of the SALib problem: {why}")));
    if !samples.study().sampled.values.is_independent() {
        remark("the parameters are correlated: SALib's problem has no correlations, the points have them");
    }
    write(&files[0], |out| out.write_all(problem.json().as_bytes()))?;
    write(&files[1], |out| points(&samples, &problem, out))?;
    write(&files[2], |out| dakota(&samples, &responses, out))?;
    let [points, rows] = [counted(samples.points(), "point"), counted(samples.count(), "sample")];
    remark(&format!("wrote {points} for SALib, {rows} for Dakota into {}", shown(&args.out)));
    Ok(Exit::Ok)
}

fn write(path: &Path, fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> Result<(), CliError> {
    let mut pending = Pending::create(path)?;
    let mut out = BufWriter::new(pending.file());
    fill(&mut out).and_then(|()| out.flush()).map_err(FileError::at("write", path))?;
    drop(out);
    Ok(pending.finish_new()?)
}

/// SALib's description of the uncertain parameters.
struct Problem {
    /// Indices among the parameters of the study.
    places: Vec<usize>,
    names: Vec<String>,
    bounds: Vec<Vec<f64>>,
    dists: Vec<&'static str>,
    left_out: Vec<String>,
}

impl Problem {
    fn of(samples: &Samples) -> Self {
        let (places, names, bounds) = (Vec::new(), Vec::new(), Vec::new());
        let mut problem = Self { places, names, bounds, dists: Vec::new(), left_out: Vec::new() };
        let laws = samples.study().sampled.values.laws();
        for (place, parameter) in samples.parameters().iter().enumerate() {
            let Origin::Uncertain(law) = parameter.origin else { continue };
            let name = exported(parameter);
            match distribution(&laws[law]) {
                Ok((dist, bounds)) => {
                    problem.places.push(place);
                    problem.names.push(name);
                    problem.bounds.push(bounds);
                    problem.dists.push(dist);
                }
                Err(why) => problem.left_out.push(format!("{name}: {why}")),
            }
        }
        problem
    }

    fn json(&self) -> String {
        let problem = json!({
            "num_vars": self.names.len(),
            "names": self.names,
            "bounds": self.bounds,
            "dists": self.dists,
        });
        format!("{problem:#}\n")
    }
}

/// Exported name of a parameter: its path, as in a points file, instead of the short name in this study.
fn exported(parameter: &Parameter) -> String {
    Variable { short: None, ..parameter.variable() }.column()
}

/// SALib's name of a distribution and its numbers, or the reason why SALib has none.
fn distribution(law: &Uncertain) -> Result<(&'static str, Vec<f64>), &'static str> {
    match law.plain() {
        Some(Plain::Uniform(from, to)) => Ok(("unif", vec![from, to])),
        Some(Plain::Normal(mean, sd)) => Ok(("norm", vec![mean, sd])),
        Some(Plain::TruncatedNormal(from, to, mean, sd)) => Ok(("truncnorm", vec![from, to, mean, sd])),
        Some(Plain::LogNormal(mu, sigma)) => Ok(("lognorm", vec![mu, sigma])),
        Some(Plain::Triangular(_, _, to)) if to <= 0.0 => Err("SALib refuses a triangle that ends at or below 0"),
        Some(Plain::Triangular(_, mode, to)) if mode >= to => Err("SALib refuses a triangle with its peak at the end"),
        Some(Plain::Triangular(from, mode, to)) => Ok(("triang", vec![from, to, (mode - from) / (to - from)])),
        Some(Plain::LogUniform(from, to)) => Ok(("logunif", vec![from, to])),
        Some(Plain::Weibull(shape, scale)) => Ok(("weibull", vec![shape, scale])),
        None => Err(
            "SALib has no such distribution (it has unif, logunif, triang, norm, truncnorm with both ends, lognorm and weibull)",
        ),
    }
}

/// Writes the points, once for all combinations of varied values.
fn points(samples: &Samples, problem: &Problem, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{}", problem.names.join(","))?;
    let groups = samples.count() / samples.points();
    for point in 0..samples.points() {
        let values = samples.values(point * groups);
        let cells: Vec<String> = problem.places.iter().map(|place| cell(&values[*place])).collect();
        writeln!(out, "{}", cells.join(","))?;
    }
    Ok(())
}

fn dakota(samples: &Samples, responses: &[(String, Vec<f64>)], out: &mut impl Write) -> io::Result<()> {
    let label = |name: &str| name.split_whitespace().collect::<Vec<_>>().join("_");
    let names = samples.parameters().iter().map(|parameter: &Parameter| label(&exported(parameter)));
    let names: Vec<String> = names.chain(responses.iter().map(|(name, _)| label(name))).collect();
    writeln!(out, "%eval_id interface {}", names.join(" "))?;
    for sample in 0..samples.count() {
        let row = usize::try_from(sample).unwrap_or(usize::MAX);
        let values = samples.values(sample).iter().map(cell).collect::<Vec<_>>();
        let found = responses.iter().map(|(_, column)| cell(&ParamValue::Number(column[row])));
        let cells: Vec<String> = values.into_iter().chain(found).collect();
        writeln!(out, "{} NO_ID {}", sample + 1, cells.join(" "))?;
    }
    Ok(())
}

/// The shortest decimal that parses to the same bits.
fn cell(value: &ParamValue) -> String {
    match value {
        ParamValue::Number(number) if number.is_nan() => "nan".to_owned(),
        ParamValue::Number(number) => format!("{number:?}"),
        ParamValue::Choice(word) => word.clone(),
    }
}

/// Columns of the results, nan for runs that are not ok.
fn responses(args: &ExportArgs, samples: &Samples) -> Result<Vec<(String, Vec<f64>)>, CliError> {
    let refused = |column: &String, why: &str| {
        Err(DesignExportError::Response { column: column.clone(), why: why.to_owned() }.into())
    };
    let Some(first) = args.response.first() else { return Ok(Vec::new()) };
    if !args.path.is_dir() {
        return refused(first, "a study file has no results; name its result directory");
    }
    let count = usize::try_from(samples.count()).unwrap_or(usize::MAX);
    let mut seen = 0;
    let mut found: Vec<Option<Vec<f64>>> = vec![None; args.response.len()];
    let names: Vec<&str> = ["sample", "status"].into_iter().chain(args.response.iter().map(String::as_str)).collect();
    read_current(&args.path, row_files, |files| {
        refuse_changed(&args.path)?;
        seen = 0;
        Table::for_each_piece(files, &names, |piece| {
            let rows = piece.numbers("sample").unwrap_or_default();
            let status = piece.words("status").unwrap_or_default();
            seen += rows.len();
            for (name, column) in args.response.iter().zip(&mut found) {
                let Some(cells) = piece.numbers(name) else { continue };
                let column = column.get_or_insert_with(|| vec![f64::NAN; count]);
                for ((row, status), cell) in rows.iter().zip(status).zip(cells) {
                    let place = row.and_then(|row| column.get_mut(row as usize));
                    if let (Some(place), Some("ok"), Some(cell)) = (place, status.as_deref(), cell) {
                        *place = *cell;
                    }
                }
            }
            Ok(())
        })
    })?;
    if seen != count {
        return refused(first, &format!("the study is not complete: {seen} of {}", counted(samples.count(), "sample")));
    }
    let mut all = Vec::new();
    for (name, column) in args.response.iter().zip(found) {
        match column {
            Some(column) => all.push((name.clone(), column)),
            None => return refused(name, "the table has no column of numbers with this name"),
        }
    }
    Ok(all)
}
