//! `bladeoff submit`: passes the shards of a study to a scheduler.

use super::answer::last_needed;
use super::error::CliError;
use super::exit::Exit;
use super::output::{remark, tell};
use super::run::{PartArgs, at_least_one, default_workers};
use crate::run::TRUST;
use crate::run::shards::{MOST_SHARDS, begin, shards_to_do};
use crate::submit::{Job, Scheduler, as_shell, hand_in, write_scripts};
use bladeoff_answers::summary::{counted, duration};
use bladeoff_study::parse_task_time;
use bladeoff_system::files::FileError;
use bladeoff_system::shown;
use std::path::{Path, PathBuf, absolute};
use std::time::Duration;

/// Compute the shards of a study with a scheduler
///
/// Checks the whole study, begins the directory that the shards share, writes the scripts into DIR/scheduler and submits
/// them: one task for each shard with missing chunks, then the merge. Each task is an ordinary `bladeoff run --shard` on
/// one node. You can read and edit the scripts; an edited script is kept.
///
/// Submitting again submits what is missing, with any number of shards. Published chunks are used. `bladeoff status DIR`
/// shows chunks, attempts and the state of the scheduler. docs/cluster.md is the guide.
///
/// slurm and parallel (GNU parallel, over ssh with --hosts) are tested. pbs, lsf and hyperqueue are templates: the
/// scripts are written, and the commands that submit them are printed.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "bladeoff submit [OPTIONS] --scheduler <NAME>\n       --shards <N> --out <DIR> <STUDY>",
    after_help = "Examples:
  bladeoff submit studies/gap-friction-map.toml \\
    --scheduler slurm --shards 16 --out runs/night \\
    --time 8h --partition long --account turbines

  The same, to be read first:
  bladeoff submit studies/gap-friction-map.toml \\
    --scheduler slurm --shards 16 --out runs/night --dry-run

  Four workstations:
  bladeoff submit studies/gap-friction-map.toml \\
    --scheduler parallel --shards 16 --out runs/night \\
    --hosts blue,red,green,black"
)]
pub struct Args {
    /// Study file; every node needs it under this path
    study: PathBuf,

    /// Scheduler: slurm, parallel, pbs, lsf, hyperqueue
    #[arg(long, value_name = "NAME")]
    scheduler: Scheduler,

    /// Number of shards: about as many as nodes, or a small multiple of them
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MOST_SHARDS))]
    shards: u64,

    /// Directory that the shards share
    #[arg(long, value_name = "DIR")]
    out: PathBuf,

    /// Wall time of a task, such as 8h, 480min or 08:00:00. A task ends a little earlier, publishes its chunks and is
    /// submitted again (slurm)
    #[arg(long, value_name = "TIME", value_parser = parse_task_time)]
    time: Option<Duration>,

    /// Partition or queue
    #[arg(long, value_name = "NAME", value_parser = plain)]
    partition: Option<String>,

    /// Account or project
    #[arg(long, value_name = "NAME", value_parser = plain)]
    account: Option<String>,

    /// Cores of a task [default: those that the scheduler gives]
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    cpus: Option<u64>,

    /// Hosts of GNU parallel, with commas between [default: this one]
    #[arg(long, value_name = "HOSTS", value_parser = plain, value_delimiter = ',')]
    hosts: Vec<String>,

    /// Samples per chunk, the unit that is published; fixed when the directory is begun [default: about a minute of a
    /// node]
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    chunk: Option<u64>,

    /// Reuse finished samples of this result directory, or directory of shards, by their keys, for a study that has
    /// grown. That directory is not changed
    #[arg(long, value_name = "OLD")]
    reuse: Option<PathBuf>,

    /// Folder for the record of a shard on its node [default: $TMPDIR, or /tmp, of the node]
    #[arg(long, value_name = "DIR")]
    scratch: Option<PathBuf>,

    #[command(flatten)]
    part: PartArgs,

    /// Work in a directory that belongs to another user or that others can write in
    #[arg(long)]
    trust_dir: bool,

    /// Write the scripts and print the commands, but submit nothing
    #[arg(long)]
    dry_run: bool,
}

/// Accepts a word without special characters for a shell or a scheduler.
fn plain(text: &str) -> Result<String, String> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-.:@/+".contains(c);
    let is_one = !text.is_empty() && !text.starts_with('-') && text.chars().all(is_plain);
    if is_one { Ok(text.to_owned()) } else { Err("must be of letters, digits and _ - . : @ / +".to_owned()) }
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    if !args.hosts.is_empty() && args.scheduler != Scheduler::Parallel {
        return Err(CliError::Unmeant {
            what: "--hosts is for --scheduler parallel; other schedulers choose nodes themselves".to_owned(),
        });
    }
    let samples = args.part.load(&args.study)?;
    let cores = args.cpus.and_then(|cpus| usize::try_from(cpus).ok()).unwrap_or_else(default_workers);
    begin(&args.out, args.trust_dir, &samples, (args.chunk, cores, args.shards), args.reuse.as_deref(), &|text| {
        remark(text)
    })?;
    let last = last_needed(&samples)?;
    let todo = shards_to_do(&args.out, args.shards, last)?;
    let job = job(args, samples.study().name.clone(), todo)?;
    let kept = write_scripts(&job, args.scheduler)?;
    for name in kept {
        remark(&format!(
            "{} was edited and is kept as it is; remove it to have it written anew",
            shown(job.directory.join("scheduler").join(name))
        ));
    }
    let of = counted(args.shards, "shard");
    if let Some(time) = job.time.filter(|_| !job.todo.is_empty()) {
        let own = job.wall().unwrap_or(time);
        remark(&format!("each task has {}; it ends after {}", duration(time), duration(own)));
    }
    remark(&if job.todo.is_empty() {
        "every chunk exists: only the merge is left".to_owned()
    } else {
        format!(
            "{} of {of} have something to do; scripts in {}",
            job.todo.len(),
            shown(job.directory.join("scheduler"))
        )
    });
    if args.dry_run || !args.scheduler.is_tested() {
        if !args.scheduler.is_tested() && !args.dry_run {
            remark(&format!(
                "the scripts of {} are templates that the developers reviewed but did not run: read them, then submit them with these commands",
                args.scheduler
            ));
        }
        tell(&as_shell(&job.commands(args.scheduler)))?;
        return Ok(Exit::Ok);
    }
    let handed = hand_in(&job, args.scheduler)?;
    if let Some(code) = handed.code {
        return Ok(Exit::of_merge(code));
    }
    tell(&format!("{}: handed in as {}\n", args.scheduler, handed.jobs.join(", ")))?;
    Ok(Exit::Ok)
}

fn job(args: &Args, study: String, todo: Vec<u64>) -> Result<Job, CliError> {
    let whole = |path: &Path| absolute(path).map_err(FileError::at("find", path));
    let program = std::env::current_exe().map_err(FileError::at("find", Path::new("/proc/self/exe")))?;
    Ok(Job {
        study,
        program,
        file: whole(&args.study)?,
        directory: whole(&args.out)?,
        shards: args.shards,
        todo,
        more: args.part.words() + if args.trust_dir { TRUST } else { "" },
        time: args.time,
        partition: args.partition.clone(),
        account: args.account.clone(),
        cpus: args.cpus,
        hosts: args.hosts.clone(),
        scratch: args.scratch.as_deref().map(whole).transpose()?,
    })
}
