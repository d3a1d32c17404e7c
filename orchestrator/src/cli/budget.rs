//! Options that limit a run and its samples.

use crate::dispatch::{TimeOfDay, next_time_of_day};
use crate::schedule::RunLimits;
use bladeoff_study::{SampleLimits, parse_duration, parse_memory};
use std::time::Duration;

/// Limits of a run and of its samples.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Budget")]
pub struct BudgetArgs {
    /// End the run after this time, counted from the start of the program (s, min, h, d, such as 8h or 1h30m). Finished
    /// samples are recorded, and the same command resumes later. Sleep of the computer does not count
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    wall: Option<Duration>,

    /// End the run when the local clock next shows this time, such as 06:30
    #[arg(long, value_name = "HH:MM")]
    until: Option<TimeOfDay>,

    /// End the run once more than N samples of the study have failed or been quarantined, those of earlier runs included.
    /// If there are more already, nothing is computed. `--rerun failed` removes them
    #[arg(long, value_name = "N")]
    max_failures: Option<u64>,

    /// Quarantine a sample if its worker has crashed N times while it computed this sample alone [default: that of the
    /// study, or 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    crash_limit: Option<u32>,

    /// Quarantine a sample if its worker was killed by another program or stopped N times while it computed this sample
    /// alone. Every later run tries such a sample once more [default: that of the study, or 5]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    kill_limit: Option<u32>,

    /// Longest time of one sample. A longer sample loses its worker, which counts for --crash-limit. The limit depends on
    /// the computer, run.step_limit does not. It is checked twice a second: a sample may take up to 0.7 s more [default:
    /// that of the study, or none]
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    time_limit: Option<Duration>,

    /// Memory that a worker may allocate, such as 2GB. A sample that needs more loses its worker, which counts for
    /// --crash-limit [default: that of the study, or none]
    #[arg(long, value_name = "SIZE", value_parser = parse_memory)]
    memory_limit: Option<u64>,
}

impl BudgetArgs {
    /// Limits of one sample: those of the study, replaced by those given here.
    pub fn of_sample(&self, study: SampleLimits) -> SampleLimits {
        SampleLimits {
            time: self.time_limit.or(study.time),
            memory: self.memory_limit.or(study.memory),
            crashes: self.crash_limit.unwrap_or(study.crashes),
            kills: self.kill_limit.unwrap_or(study.kills),
        }
    }

    /// Limits of the run, which begins now.
    pub fn of_run(&self) -> RunLimits {
        RunLimits { wall: self.wall, until: self.until.map(next_time_of_day), max_failures: self.max_failures }
    }
}
