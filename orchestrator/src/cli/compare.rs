//! `bladeoff compare`: differences between two results.

use super::compared::{Opened, open};
use super::error::CliError;
use super::exit::Exit;
use super::output::{print_json, remark, tell, width};
use super::refusals::NotCompared;
use crate::run::{STOP, TableEnd, study_changes};
use bladeoff_answers::compare::{Asked, CompareError, Compared, Differs, Source, compare, told};
use std::path::PathBuf;

/// Largest number of attempts to read tables that a run replaces meanwhile.
const TRIES: usize = 3;

/// List the differences between two results and check tolerances
///
/// A is the reference and B the result of another build, engine, setting or design. Rows match if all their inputs
/// (everything that differs between samples) are exactly equal. Of matching pairs the differences B - A are printed, with
/// an interval if the study was drawn at random. Rows without a partner are compared as two samples: means and quantiles.
///
/// A run that is not ok has no value to compare. Pairs of different status, or failed for different causes, are counted
/// and named. With tolerances they count as out of tolerance, and so does a row of A without a partner. Additional rows
/// of B do not.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff compare runs/before runs/after
  bladeoff compare runs/before runs/after \\
    --tolerance \"max_bearing_load_N 1 %\" \\
    --tolerance \"end_speed_rad_s 1 rpm\"
  bladeoff compare runs/hyp1 runs/hyp2 \\
    --ignore contact.detection
  bladeoff compare before.parquet runs/after --json \\
    | jq .status

Exit codes: 0 compared, and within every tolerance; 4 out of tolerance.")]
pub struct Args {
    /// The reference: a result directory of `bladeoff run`, or its table (results.parquet, in any place)
    #[arg(value_name = "A")]
    a: PathBuf,

    /// The result that is compared with it: a directory or a table
    #[arg(value_name = "B")]
    b: PathBuf,

    /// Largest allowed change of a result in any pair: COLUMN VALUE, in the SI unit of the column, in another unit of its
    /// kind, or in % of the value of A (if that is 0, only 0 is allowed). May be given several times
    #[arg(long, value_name = "TOLERANCE", allow_hyphen_values = true)]
    tolerance: Vec<String>,

    /// Input that is ignored when rows are matched: its column, its path or the end of it. May be given several times.
    /// Rows with equal other inputs then match in the order of their samples if both tables have equally many, otherwise
    /// not at all
    #[arg(long, value_name = "PATH")]
    ignore: Vec<String>,

    /// Print everything as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let found = compared(args)?;
    if args.json {
        let text = serde_json::to_string_pretty(&found).map_err(|error| CliError::stdout(error.into()))?;
        print_json(&(text + "\n"))?;
    } else {
        tell(&told(&found, width()))?;
    }
    Ok(if found.out_of_tolerance == Some(true) { Exit::Failures } else { Exit::Ok })
}

/// Reads both tables; repeats if a run replaced a file meanwhile.
fn compared(args: &Args) -> Result<Compared, CliError> {
    for _ in 0..TRIES {
        let (a, b) = (open(&args.a)?, open(&args.b)?);
        let asked = Asked { tolerances: &args.tolerance, ignore: &args.ignore };
        let found = compare(&a.source(), &b.source(), &asked);
        if !a.is_as_opened() || !b.is_as_opened() {
            continue;
        }
        let mut found = found.map_err(|error: CompareError| CliError::from(NotCompared::from(error)))?;
        [("A", &a), ("B", &b)].into_iter().for_each(|(side, opened)| {
            opened.remarks.iter().for_each(|text| remark(&format!("warning: {side}: {text}")));
        });
        found.differs.iter_mut().filter(|one| one.what == STOP).for_each(in_words);
        found.differs.extend(differing(&a, &b));
        return Ok(found);
    }
    Err(NotCompared::Changing.into())
}

/// Converts the end of a table by `[stop]` to text.
fn in_words(one: &mut Differs) {
    one.what = "end by [stop]".to_owned();
    for said in [&mut one.a, &mut one.b].into_iter().flatten() {
        if let Some(end) = serde_json::from_str(said).ok().and_then(|value| TableEnd::of_json(&value)) {
            *said = end.brief();
        }
    }
}

/// Provenance that directories have in addition to their tables: commit of the program, and every parameter.
fn differing(a: &Opened, b: &Opened) -> Vec<Differs> {
    let mut found = Vec::new();
    if let (Some(a), Some(b)) = (&a.commit, &b.commit)
        && a != b
    {
        found.push(Differs { what: "commit".to_owned(), a: Some(a.clone()), b: Some(b.clone()) });
    }
    if let (Some(a), Some(b)) = (&a.samples, &b.samples) {
        let changes = study_changes(a.study(), b.study());
        found.extend(changes.into_iter().map(|one| Differs { what: one.key, a: Some(one.from), b: Some(one.to) }));
    }
    found
}

impl Opened {
    fn source(&self) -> Source<'_> {
        Source { name: self.name.clone(), files: &self.files, draw: &self.draw }
    }
}
