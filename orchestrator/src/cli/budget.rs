//! Options that limit a run and its samples.

use crate::dispatch::{TimeOfDay, next_time_of_day};
use crate::schedule::RunLimits;
use bladeoff_study::{SampleLimits, parse_duration, parse_memory};
use std::time::Duration;

/// What a run and its samples may take.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Budget")]
pub struct BudgetArgs {
    /// End the run after this time from the start of the program (s, min, h, d, such as 8h or 1h30m); what is finished is
    /// recorded, and the same command resumes it later. Sleep of the machine does not count
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    wall: Option<Duration>,

    /// End the run when the local clock next shows this time, such as 06:30
    #[arg(long, value_name = "HH:MM")]
    until: Option<TimeOfDay>,

    /// End the run once more than N samples of the study have failed or been quarantined, those of earlier runs included: if
    /// there are so many already, nothing is computed. `--rerun failed` takes them out
    #[arg(long, value_name = "N")]
    max_failures: Option<u64>,

    /// Quarantine a sample in which its worker has crashed N times while alone with it [default: that of the study, or 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    crash_limit: Option<u32>,

    /// Quarantine a sample in which its worker was killed from outside (by an operator, or by a system short of memory) or stopped N
    /// times while alone with it; every later run tries such a sample once more [default: that of the study, or 5]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    kill_limit: Option<u32>,

    /// Longest time of one sample; a longer one loses its worker, which counts for --crash-limit. Depends on the
    /// machine: run.step_limit does not. Measured from the heartbeats of the worker, two a second: a sample may take up to
    /// 0.7 s more [default: that of the study, or none]
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    time_limit: Option<Duration>,

    /// Memory that a worker may allocate, such as 2GB; beyond it the sample loses its worker, which counts for
    /// --crash-limit [default: that of the study, or none]
    #[arg(long, value_name = "SIZE", value_parser = parse_memory)]
    memory_limit: Option<u64>,
}

impl BudgetArgs {
    /// What one sample may take: as the study says, but for what is given here.
    pub fn of_sample(&self, study: SampleLimits) -> SampleLimits {
        SampleLimits {
            time: self.time_limit.or(study.time),
            memory: self.memory_limit.or(study.memory),
            crashes: self.crash_limit.unwrap_or(study.crashes),
            kills: self.kill_limit.unwrap_or(study.kills),
        }
    }

    /// What the run may take, from this moment on.
    pub fn of_run(&self) -> RunLimits {
        RunLimits { wall: self.wall, until: self.until.map(next_time_of_day), max_failures: self.max_failures }
    }
}
