//! `bladeoff run --shard I/N`: one shard of a study, on one node of a cluster.

use super::error::CliError;
use super::exit::Exit;
use super::output::remark;
use crate::dispatch::Ended;
use crate::run::shards::{SHARDS, Shard, ShardError, ShardFinished, ShardRequest, memory_of_worker, run_shard};
use crate::run::{Request, TRUST, resume_command};
use bladeoff_answers::summary::counted;
use bladeoff_study::{Samples, parse_duration};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Options of one shard.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Shards (docs/cluster.md)")]
pub struct ShardArgs {
    /// Compute shard I of N (0 <= I < N) and publish its chunks in the directory that all shards share. The first shard
    /// publishes study, plan and basis there. A shard that has finished its own chunks computes missing ones of others.
    /// `bladeoff merge DIR` makes the table
    #[arg(long, value_name = "I/N", requires = "out", conflicts_with_all = ["rerun", "json_events", "refresh", "max_failures"])]
    pub shard: Option<Shard>,

    /// Samples per chunk, the unit that is published; fixed when the directory is begun [default: about a minute of a
    /// node]
    #[arg(long, value_name = "N", requires = "shard", value_parser = clap::value_parser!(u64).range(1..))]
    chunk: Option<u64>,

    /// Reuse finished samples of this result directory, or directory of shards, by their keys, for a study that has
    /// grown. That directory is not changed
    #[arg(long, value_name = "OLD", requires = "shard")]
    reuse: Option<PathBuf>,

    /// Folder for the record of the shard: on a disk of this node, not on a shared one [default: $TMPDIR, or /tmp]
    #[arg(long, value_name = "DIR", requires = "shard")]
    scratch: Option<PathBuf>,

    /// Longest time that the shared directory may be unavailable before the shard ends with exit code 6
    #[arg(long, value_name = "TIME", default_value = "10 min", requires = "shard", value_parser = parse_duration)]
    patience: Duration,
}

impl ShardArgs {
    /// Whether the requested shard belongs to an existing directory: then the whole study has been checked.
    pub fn begun(&self, out: Option<&Path>) -> bool {
        self.shard.is_some() && out.is_some_and(|out| out.join(SHARDS).is_file())
    }

    /// Runs the shard.
    pub fn run(&self, shard: Shard, mut run: Request, samples: &Samples) -> Result<Exit, CliError> {
        let scratch = self.scratch.clone().unwrap_or_else(std::env::temp_dir);
        run.sample.memory = run.sample.memory.or_else(|| memory_of_worker(run.workers));
        let trust = if run.trusts { TRUST } else { "" };
        let again = format!("{} --shard {shard}{trust}", resume_command(&run.out, samples));
        let request =
            ShardRequest { run, shard, chunk: self.chunk, reuse: self.reuse.clone(), scratch, patience: self.patience };
        let finished = run_shard(&request, samples, &|text| remark(text)).inspect_err(|error| {
            if !error.is_refusal() && !matches!(error, ShardError::Damaged { .. }) {
                remark(&format!("published chunks are kept; resume with: {again}"));
            }
        })?;
        remark(&in_words(&finished));
        Ok(match finished.ended {
            Ended::Complete | Ended::Stop => Exit::Ok,
            Ended::Signalled(signal) => signal.into(),
            Ended::Wall | Ended::Until | Ended::TooManyFailures => {
                remark(&format!("some of its chunks are missing; resume with: {again}"));
                Exit::Incomplete
            }
        })
    }
}

fn in_words(finished: &ShardFinished) -> String {
    let ShardFinished { ended, published, helped, lost, chunks } = finished;
    let mut text = format!("{}: {published} of {} published here", ended.word(), counted(*chunks, "chunk"));
    if *helped > 0 {
        text.push_str(&format!(", {helped} of them of other shards"));
    }
    if *lost > 0 {
        text.push_str(&format!("; {lost} had been published by others before"));
    }
    text
}
