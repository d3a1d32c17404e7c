//! Cost of processing a result directory with many recorded results. Each stage runs in its own process, because peak memory is measured for a
//! process, and the largest stage would conceal the others.

use super::super::error::CliError;
use super::super::exit::Exit;
use super::super::output::print;
use super::answers;
use super::cost::{Cost, measure, peak_mb};
use super::engines::RIG;
use crate::run::directory::row_files;
use crate::run::{own_columns, rehearsal};
use bladeoff_answers::summary::Summary;
use bladeoff_study::{Samples, load};
use bladeoff_system::files::FileError;
use bladeoff_worker::process::process_cpu_time;
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// One stage, for `bench dispatch` and `bench answers`.
#[derive(Debug, clap::Args)]
pub struct Args {
    what: What,
    study: PathBuf,
    directory: PathBuf,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum What {
    Fill,
    Resume,
    Parts,
    Tables,
    Summary,
    Growth,
    Tabulate,
    Answer,
    Report,
}

/// A study with no-op results for all samples but the last.
pub struct Stages {
    folder: PathBuf,
    counts: (u64, u64),
}

impl Stages {
    /// Prepares a study with at least `samples` samples, as a grid.
    pub fn new(folder: &Path, samples: u64) -> Result<Self, CliError> {
        let columns = samples.clamp(2, 1000);
        let stages = Self { folder: folder.to_path_buf(), counts: (samples.div_ceil(columns).max(2), columns) };
        stages.write("rig.toml", RIG)?;
        let (rows, columns) = stages.counts;
        stages.write("study.toml", &study(rows, columns))?;
        // The range of the larger study contains every point of the smaller one.
        stages.write("growth.toml", &study(2 * rows - 1, columns))?;
        Ok(stages)
    }

    /// Number of samples of the study.
    pub fn samples(&self) -> u64 {
        self.counts.0 * self.counts.1
    }

    /// Runs one stage in its own process and returns its cost.
    pub fn measure(&self, what: &str) -> Result<Cost, CliError> {
        let study = if what == "growth" { "growth.toml" } else { "study.toml" };
        measure(what, &self.folder.join(study), &self.folder.join("stages"))
    }

    fn write(&self, name: &str, text: &str) -> Result<(), FileError> {
        let path = self.folder.join(name);
        fs::write(&path, text).map_err(FileError::at("write", &path))
    }
}

fn study(rows: u64, columns: u64) -> String {
    let axis = |path: &str, from: &str, to: &str, count: u64| {
        format!("[[vary]]\npath = \"{path}\"\nfrom = \"{from}\"\nto = \"{to}\"\ncount = {count}\n")
    };
    let axes = axis("contact.gap", "0.5 mm", "0.9 mm", rows) + &axis("blade_off.mass", "3 g", "10 g", columns);
    format!("schema = 1\nname = \"stages\"\nmachine = \"rig.toml\"\n{axes}")
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let samples = Samples::new(load(&args.study, own_columns)?, None, None)?;
    let directory = &args.directory;
    let begun = Instant::now();
    let time = match args.what {
        What::Fill => rehearsal::fill(directory, &samples).map(|()| begun.elapsed())?,
        What::Resume | What::Growth => rehearsal::time_resume(directory, &samples)?.whole,
        What::Parts => rehearsal::time_parts(directory, &samples)?,
        What::Tables => rehearsal::time_tables(directory, &samples)?,
        What::Summary => {
            std::hint::black_box(Summary::of(&row_files(directory))?.text(None));
            begun.elapsed()
        }
        What::Tabulate => rehearsal::tabulate(directory, &samples).map(|()| begun.elapsed())?,
        What::Answer => {
            std::hint::black_box(answers::answer(directory, &samples)?);
            begun.elapsed()
        }
        What::Report => {
            answers::report(directory, &samples)?;
            begun.elapsed()
        }
    };
    let cpu_s = process_cpu_time().as_secs_f64();
    print(&format!("{}\n", json!({ "seconds": time.as_secs_f64(), "cpu_s": cpu_s, "peak_mb": peak_mb() })))?;
    Ok(Exit::Ok)
}
