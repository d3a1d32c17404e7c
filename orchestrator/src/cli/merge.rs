//! `bladeoff merge`: the table of a study that was computed in shards.

use super::answer::{answers_of_run, waiting};
use super::error::CliError;
use super::exit::Exit;
use super::output::{remark, tell, width};
use super::run::{summary, verdict_of};
use crate::run::PrecisionCheck;
use crate::run::shards::{ShardError, merge, restore, samples_of};
use bladeoff_answers::summary::counted;
use bladeoff_system::shown;
use std::path::PathBuf;

/// Make the table of a study that was computed in shards
///
/// Checks that every sample exists once and that all samples come from one study, program and basis. Writes
/// results.parquet, timings.parquet and manifest.json (with nodes and attempts) into the directory. Then prints the
/// summary and the answers, and returns the exit codes of `run`. The table is, byte for byte, the one of a single computer with the same basis.
///
/// If chunks are missing, they are listed and the exit code is 5: run the shards again, or `bladeoff submit` again. A
/// damaged chunk is put aside and counts as missing. In a study with `[stop]`, merge finds the end at the same interim
/// analyses as a run on one computer. Chunks beyond the first analysis that is precise enough are not needed. Before the
/// merge, `status`, `why`, `answer`, `gate`, `replay` and `export` work with the published chunks.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  bladeoff merge runs/night")]
pub struct Args {
    /// Directory that the shards share
    directory: PathBuf,

    /// Work in a directory that belongs to another user or that others can write in
    #[arg(long)]
    trust_dir: bool,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let none = || ShardError::None { path: args.directory.clone() };
    restore(&args.directory, args.trust_dir, &|text| remark(text))?;
    let samples = samples_of(&args.directory)?.ok_or_else(none)?;
    let waiting = waiting(&samples)?;
    let looking = waiting.as_ref().map(|waiting| waiting as &dyn PrecisionCheck);
    let merged = merge(&args.directory, args.trust_dir, &samples, looking, &|text| remark(text))?;
    if merged.attempts > 0 {
        remark(&format!(
            "{} of {} on {} merged",
            counted(merged.chunks, "chunk"),
            counted(merged.attempts, "attempt"),
            counted(merged.nodes, "node")
        ));
    }
    let (study, total) = (samples.study(), samples.count());
    let mut text = format!("\n{}: {} of {}\n\n", study.name, merged.tally.done(), counted(total, "sample"));
    if let Some(end) = &merged.end {
        text.push_str(&format!("{}\n\n", end.words(&samples)));
    }
    text.push_str(&summary(&samples, &args.directory, width())?);
    text.push_str(&format!("\nTable: {}\n", shown(&merged.table)));
    let (answers, exit_of_answers) = answers_of_run(&args.directory, &samples, args.trust_dir)?;
    text.push_str(&answers);
    match tell(&text) {
        // The table is written, so a reader that closes the pipe does not change the result.
        Ok(()) | Err(CliError::ReaderLeft) => {}
        Err(error) => return Err(error),
    }
    Ok(match verdict_of(study, &merged.tally, merged.end.map_or(total, |end| end.samples)) {
        Exit::Ok => exit_of_answers,
        exit => exit,
    })
}
