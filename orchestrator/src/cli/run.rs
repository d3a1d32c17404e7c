//! `bladeoff run`: computes a study on all cores.

use super::answer::{answers_of_run, check_questions, refinement, understood, waiting};
use super::budget::BudgetArgs;
use super::error::CliError;
use super::exit::Exit;
use super::functions;
use super::output::{remark, tell, width, width_of_errors};
use super::shard::ShardArgs;
use crate::dispatch::{self, DispatchError, Ended, limit_preparation, time_left, watch_before};
use crate::engine_choice::by_starts;
use crate::html_report::{Horizon, LimitTable, bearings_of};
use crate::plausible::implausible_of;
use crate::questions::{Refinement, check_asked, columns_asked};
use crate::run::directory::LEDGER;
use crate::run::shards::{SHARDS, cores, row_files};
use crate::run::{
    Finished, PrecisionCheck, Refining, Request, Rerun, RunError, TRUST, Watched, give_back, own_columns,
    resume_command, run,
};
use crate::start_check::check_starts;
use crate::terminal::Tally;
use bladeoff_answers::ask::{Ask, Figure};
use bladeoff_answers::summary::are;
use bladeoff_answers::summary::{Summary, counted, duration, wrapped};
use bladeoff_model::outcome::{Cause, Status};
use bladeoff_protocol::domain::DomainError;
use bladeoff_study::sampling::layout::LayoutKind;
use bladeoff_study::{Samples, Study, check_machines, load_checked, parse_duration};
use bladeoff_system::shown;
use bladeoff_worker::fault::Faults;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::thread;
use std::time::{Duration, Instant};

/// Long help, with one line per paragraph; clap would join a list within a doc comment to one paragraph.
const ABOUT: &str = "\
Compute a study on all cores and write its result directory

The whole study is checked before anything runs. Worker processes compute its samples. A result counts only when it is on \
disk. The run ends with a summary. The result directory contains:

  results.parquet   one row per sample: parameters, status,
                    cause, quantities; the unit is in each
                    column's name
  study.toml, machine.toml, points.csv
                    copies of the inputs
  timings.parquet   CPU time, worker, attempt of each sample
  answers.json, answers/NAME.parquet
                    answers to the questions of the study,
                    and their curves
  manifest.json     versions, build, host, dates, command,
                    BLAKE3 of the tables
  status.json       data of `status`
  workers.log       messages of the worker processes
  plan.json, basis.bin
                    input of the workers
  ledger.redb       the durable record, from which tables
                    are made and runs are resumed
  run.lock          lock of the running process

The same study gives the same bytes of results.parquet, regardless of the number of workers and of interruptions.

Rerun the same command to resume after Ctrl-C, a crash or a full disk. An existing result directory keeps its finished \
samples, and the table is the one that an undisturbed run would have written. The study may have grown meanwhile: more \
points, a larger --limit or run.step_limit, other [limits]. A study that has changed otherwise is rejected with the \
differences.

Rows of a study in progress are in parts/*.parquet. These files never change. They have the columns of the table and contain \
each finished row once; read them together (DuckDB: read_parquet('DIR/parts/*.parquet')). They are removed when \
results.parquet exists. `status` shows the progress. `s` and Enter, or SIGUSR1, print what each worker is doing. A second \
Ctrl-C does not wait for samples in progress.

An existing folder that is no result directory is rejected. So is a directory that belongs to another user or that others can write in, unless \
--trust-dir is given. If the directory is removed during the run, the run stops and keeps the finished samples in DIR.kept.";

/// Examples and exit codes of the help.
const EXAMPLES: &str = "\
Examples:
  bladeoff run studies/first-look.toml
  bladeoff run studies/first-look.toml \\
    --out look --workers 2

  A part of every axis, both ends included:
  bladeoff run studies/gap-friction-map.toml --scale 0.3

  50 samples over the study; then all, keeping those 50:
  bladeoff run studies/gap-friction-map.toml --limit 50
  bladeoff run studies/gap-friction-map.toml

  Failed and quarantined samples again:
  bladeoff run studies/gap-friction-map.toml --rerun failed

  Until the morning; rerun the same command to resume:
  bladeoff run studies/gap-friction-map.toml --until 06:30

  Events for programs:
  bladeoff run studies/first-look.toml --json-events | jq .

The exit code is 5 if a budget ended the run. It is 4 if more samples failed, were invalid or beyond the model than [limits] allows. \
By default no sample may fail, and any number may be invalid or beyond the model. In a study with questions or gates any number may fail, \
because their answers include such samples.";

/// Compute a study on all cores and write its result directory
#[derive(Debug, clap::Args)]
#[command(long_about = ABOUT, after_help = EXAMPLES)]
pub struct Args {
    /// Study file (TOML; format in docs/studies.md)
    study: PathBuf,

    /// Result directory [default: runs/<name of the study>]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Number of worker processes [default: one per core]
    #[arg(long, value_name = "N", value_parser = workers)]
    workers: Option<NonZeroUsize>,

    /// Compute finished samples again: `failed` (failed and quarantined ones), or `cause=WORD[,WORD]` (those with these
    /// causes)
    #[arg(long, value_name = "WHICH", value_parser = rerun)]
    rerun: Option<Rerun>,

    /// Time between two parts of finished rows (parts/part-N.parquet) while the study runs; the first ones are written
    /// after 2 s, 4 s, 8 s and so on. Every 65536 rows are a part in any case; 0 writes only these
    #[arg(long, value_name = "TIME", default_value = "60 s", value_parser = refresh)]
    refresh: Duration,

    /// Work in a result directory that belongs to another user or that others can write in. They could change what the
    /// run writes and reads there. A run that another user has begun can be resumed only by that user
    #[arg(long)]
    trust_dir: bool,

    #[command(flatten)]
    part: PartArgs,

    #[command(flatten)]
    budget: BudgetArgs,

    #[command(flatten)]
    shard: ShardArgs,

    /// Print events on standard output, one JSON object per line (docs/events.md); the summary goes to standard error
    #[arg(long)]
    json_events: bool,
}

/// Which part of a study.
#[derive(Debug, clap::Args)]
pub struct PartArgs {
    /// Compute only N samples: the first N of a shuffle that depends on the seed of the study. Of a [design]: its first N
    /// points, with all combinations of [[vary]]
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    limit: Option<u64>,

    /// Keep only this fraction of the values of each axis, at least two, with both ends. Of a [design]: this fraction of
    /// its points, a power of two if the design needs one
    #[arg(long, value_name = "F", value_parser = scale)]
    scale: Option<f64>,
}

fn workers(text: &str) -> Result<NonZeroUsize, String> {
    let all = default_workers();
    text.parse()
        .map_err(|_| format!("must be a whole number from 1 on; without --workers there is one per core, {all} here"))
}

/// Parses a positive integer.
pub fn at_least_one(text: &str) -> Result<u64, String> {
    text.parse().ok().filter(|&number| number > 0).ok_or_else(|| "must be a whole number from 1 on".to_owned())
}

fn rerun(text: &str) -> Result<Rerun, String> {
    if text == "failed" {
        return Ok(Rerun::Failed);
    }
    let words = text.strip_prefix("cause=").ok_or("must be `failed` or `cause=WORD[,WORD]`")?;
    let known = || Cause::ALL.iter().map(|cause| cause.word()).collect::<Vec<_>>().join(", ");
    let cause = |word: &str| Cause::from_word(word).ok_or_else(|| format!("no cause {word:?}; causes are {}", known()));
    words.split(',').map(|word| cause(word.trim())).collect::<Result<_, _>>().map(Rerun::Causes)
}

fn refresh(text: &str) -> Result<Duration, String> {
    if text.trim() == "0" { Ok(Duration::ZERO) } else { parse_duration(text) }
}

fn scale(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text:?} is not a number"))?;
    if value > 0.0 && value <= 1.0 { Ok(value) } else { Err("must be above 0 and at most 1".to_owned()) }
}

impl PartArgs {
    /// The options of the part as text, each preceded by a blank.
    pub fn words(&self) -> String {
        let scale = self.scale.map(|scale| format!(" --scale {scale}")).unwrap_or_default();
        scale + &self.limit.map(|limit| format!(" --limit {limit}")).unwrap_or_default()
    }

    /// Samples of a study file, without the checks made when the directory of shards was begun.
    pub fn load_known(&self, study: &Path) -> Result<Samples, CliError> {
        let mut samples = Samples::new(load_checked(study, own_columns, check_asked)?, self.scale, self.limit)?;
        by_starts(&mut samples);
        Ok(samples)
    }

    /// Checked samples of a study file.
    pub fn load(&self, study: &std::path::Path) -> Result<Samples, CliError> {
        let mut samples = Samples::new(load_checked(study, own_columns, check_asked)?, self.scale, self.limit)?;
        if self.scale.is_some() {
            // a question may use a value that the axis no longer has
            check_questions(&samples)
                .inspect_err(|_| remark("a part of the values of each axis is left by --scale"))?;
        }
        if let Some(told) = self.limit.and_then(|limit| limited(&samples, limit)) {
            remark(&told);
        }
        samples.draw()?;
        if samples.study().function().is_none() {
            check_machines(&samples)?;
            let have_begun = by_starts(&mut samples);
            if !have_begun || self.scale.is_some() || self.limit.is_some() {
                check_starts(&samples)?;
            }
        }
        Ok(samples)
    }
}

/// Explanation if `--limit` results in another number of points.
fn limited(samples: &Samples, limit: u64) -> Option<String> {
    let (layout, points) = (samples.layout()?, samples.points());
    if points == limit.min(layout.count()) {
        return None;
    }
    let why = match layout.kind() {
        LayoutKind::LatinHypercube | LayoutKind::Sobol => {
            format!(": {} in each replicate, a power of two", points / layout.replicates())
        }
        _ if layout.rows() > 1 => format!(", in whole blocks of {}", layout.rows()),
        _ => String::new(),
    };
    Some(format!("--limit {limit} takes the first {}{why}", counted(points, "point")))
}

/// Default number of worker processes: one per core available to this process and allocated by a scheduler.
#[must_use]
pub fn default_workers() -> usize {
    cores(thread::available_parallelism().map_or(1, NonZeroUsize::get))
}

/// Runs the subcommand.
pub fn main(args: &Args, faults: &'static dyn Faults) -> Result<Exit, CliError> {
    let (begun, limits) = (Instant::now(), args.budget.of_run());
    // preparing a design of millions of points takes a while
    watch_before(|signal| end_unprepared(Ended::Signalled(signal)));
    limit_preparation(begun, limits, end_unprepared);
    let samples = match args.shard.begun(args.out.as_deref()) {
        true => args.part.load_known(&args.study),
        false => args.part.load(&args.study),
    };
    // if too few file descriptors are available, an unreadable machine is not an error of the study
    let samples = samples.map_err(|error| match dispatch::preflight(1) {
        Err(few @ DispatchError::Domain(DomainError::FewDescriptors { .. })) => RunError::from(few).into(),
        _ => error,
    })?;
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("runs").join(&samples.study().name));
    if args.shard.shard.is_none() && out.join(SHARDS).is_file() {
        return Err(CliError::OfShards { path: out });
    }
    implausible_of(&samples).iter().for_each(|text| remark(&format!("warning: {text}")));
    let workers = args.workers.map_or_else(default_workers, NonZeroUsize::get);
    let workers = workers.min(usize::try_from(samples.count()).unwrap_or(usize::MAX));
    remark(&format!(
        "{}: {} of {}, {}, results in {}",
        samples.study().name,
        counted(samples.count(), "sample"),
        samples
            .study()
            .function()
            .map_or_else(|| shown(samples.study().subject_name()).to_string(), functions::formulas),
        counted(workers as u64, "worker"),
        shown(&out)
    ));
    if let Some(until) = &limits.until {
        remark(&format!("until {}, in {}", until.time(), duration(time_left(until))));
    }
    let refinement = refinement(&samples)?;
    if let (None, Some(why)) = (&refinement, Refinement::whole_part(&samples)) {
        remark(why);
    }
    let request = Request {
        out: out.clone(),
        trusts: args.trust_dir,
        workers,
        rerun: args.rerun.clone(),
        looking: waiting(&samples)?.map(|waiting| Rc::new(waiting) as Rc<dyn PrecisionCheck>),
        refining: refinement.map(|refinement| Rc::new(refinement) as Rc<dyn Refining>),
        watched: watched(&samples),
        refresh: args.refresh,
        sample: args.budget.of_sample(samples.study().limits.sample),
        limits,
        begun,
        json_events: args.json_events,
        faults,
    };
    if let Some(shard) = args.shard.shard {
        return args.shard.run(shard, request, &samples);
    }
    let trust = if args.trust_dir { TRUST } else { "" };
    let go_on_in = |out: &Path| {
        remark(&format!("finished samples are kept; resume with: {}{trust}", resume_command(out, &samples)))
    };
    let print_command = || go_on_in(&out);
    let finished = run(&request, &samples, &remark).inspect_err(|error| {
        if let RunError::Lost(lost) = error {
            lost.goes_on_in().inspect(|out| go_on_in(out));
        } else if !error.is_refusal() && out.join(LEDGER).exists() {
            print_command();
        }
    })?;
    let incomplete = !finished.ended.is_complete();
    let width = if args.json_events { width_of_errors() } else { width() };
    let mut text =
        format!("\n{}: {} of {}\n\n", samples.study().name, finished.tally.done(), counted(samples.count(), "sample"));
    if let Some(end) = &finished.end {
        text.push_str(&format!("{}\n\n", end.words(&samples)));
    }
    text.push_str(&summary(&samples, &out, width)?);
    let (what, all) = if incomplete { ("Finished rows", "/*.parquet") } else { ("Table", "") };
    if let Some(table) = &finished.table {
        let table = shown(table);
        text.push_str(&format!("\n{what}: {table}{all}\n"));
    }
    let (answers, exit_of_answers) = answers_of_run(&out, &samples, args.trust_dir)?;
    text.push_str(&answers);
    let printed = if args.json_events {
        remark(text.trim_end());
        Ok(())
    } else {
        tell(&text)
    };
    match printed {
        // the table is written: a closed reader of the summary changes nothing
        Ok(()) | Err(CliError::ReaderLeft) => {}
        Err(error) => return Err(error),
    }
    if incomplete {
        remark(&why_it_ended(&finished, samples.count()));
        print_command();
    }
    Ok(match verdict(samples.study(), &finished, samples.count()) {
        Exit::Ok => exit_of_answers,
        exit => exit,
    })
}

/// Ends the program before the first sample is assigned.
fn end_unprepared(why: Ended) {
    let by = why.by_option().map(|option| format!(" by {option}")).unwrap_or_default();
    remark(&format!(
        "ended{by} before the first sample was assigned; rerun the same command to resume, samples finished before are kept"
    ));
    give_back(why);
    let exit = if let Ended::Signalled(signal) = why { Exit::from(signal) } else { Exit::Incomplete };
    std::process::exit(exit as i32);
}

/// Summary of the rows so far.
pub(super) fn summary(samples: &Samples, out: &Path, width: Option<usize>) -> Result<String, CliError> {
    let (study, files) = (samples.study(), row_files(out));
    if let Some(model) = study.function() {
        return functions::summary(model, &files, width);
    }
    let bearings: String = bearings_of(samples).iter().map(|note| format!("note: {note}\n")).collect();
    let limits = LimitTable::of(samples, &files)?;
    let warning = limits
        .unjudged()
        .map(|text| wrapped(&format!("warning: {text}"), width.unwrap_or(usize::MAX), "", "  ") + "\n");
    let horizon: String = Horizon::of(&files)?.sentences().iter().map(|line| format!("{line}\n")).collect();
    let summary = Summary::of(&files)?.with_twin(study.twin_keys()).text(width);
    Ok(warning.unwrap_or_default() + &summary + &horizon + &limits.text(width) + &bearings)
}

/// Text with the reason why the run ended early.
fn why_it_ended(finished: &Finished, total: u64) -> String {
    let why = match (finished.ended, finished.ended.by_option()) {
        (Ended::Complete | Ended::Stop, _) => "complete".to_owned(),
        (_, Some(option)) => format!("ended by {option}"),
        (ended, None) => ended.word().to_owned(),
    };
    let done = finished.tally.done();
    format!("{why}: {done} of {} {} recorded", counted(total, "sample"), are(done))
}

fn verdict(study: &Study, finished: &Finished, total: u64) -> Exit {
    match finished.ended {
        Ended::Signalled(signal) => return signal.into(),
        Ended::Wall | Ended::Until | Ended::TooManyFailures => return Exit::Incomplete,
        Ended::Complete | Ended::Stop => {}
    }
    let total = finished.end.map_or(total, |end| end.samples);
    verdict_of(study, &finished.tally, total)
}

/// Quantities of the progress line: those of the questions.
fn watched(samples: &Samples) -> Watched {
    let study = samples.study();
    // questions with errors were rejected before
    let asked = understood(samples, &study.file, &study.text, &study.asked).unwrap_or_default();
    let probabilities = asked.questions.iter().filter_map(|question| match &question.ask {
        Ask::One(Figure::Probability(formula)) => Some((question.name.clone(), formula.clone())),
        _ => None,
    });
    Watched { columns: columns_asked(samples, &asked.questions, &[]), probabilities: probabilities.collect() }
}

/// Exit code of a complete study: whether more samples failed, were invalid or beyond the model than the study allows.
pub(super) fn verdict_of(study: &Study, tally: &Tally, total: u64) -> Exit {
    let failed = tally.failed();
    let invalid = tally.of(Status::Invalid);
    let limits = study.limits;
    let mut exit = Exit::Ok;
    let counts = [
        ("failed", failed, limits.max_failed),
        ("invalid", invalid, limits.max_invalid),
        ("beyond", tally.of(Status::Beyond), limits.max_beyond),
    ];
    for (what, count, share) in counts {
        if !share.allows(count, total) {
            let total = counted(total, "sample");
            let shown = if what == "beyond" { "beyond the model" } else { what };
            remark(&format!("{count} of {total} {shown}; the study allows {share} ([limits] max_{what})"));
            exit = Exit::Failures;
        }
    }
    exit
}
