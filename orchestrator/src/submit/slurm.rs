//! Slurm job array: one task for each shard, then the merge.
//!
//! The array is submitted before the merge, which waits until all tasks have ended in any way (`afterany`): the merge then reports missing
//! chunks, which a merge that never starts could not. Slurm requeues tasks of failed nodes (`--requeue`).

use super::{Command, Job, Script};
use bladeoff_system::call::word;
use std::time::Duration;

const SHARD: &str = "shard.sbatch";
const MERGE: &str = "merge.sbatch";

pub(super) fn scripts(job: &Job) -> Vec<Script> {
    let mut options = vec![
        format!("--job-name={}", job.study),
        "--nodes=1".to_owned(),
        "--ntasks=1".to_owned(),
        "--requeue".to_owned(),
        "--open-mode=append".to_owned(),
        format!("--output={}", word(log(job, "shard-%a.log"))),
    ];
    match job.cpus {
        Some(cpus) => options.push(format!("--cpus-per-task={cpus}")),
        // without this, Slurm allocates one core
        None => options.extend(["--exclusive", "--mem=0"].map(str::to_owned)),
    }
    options.extend(job.time.map(|time| format!("--time={}", minutes(time))));
    let mut last = vec![
        format!("--job-name={}-merge", job.study),
        "--nodes=1".to_owned(),
        "--ntasks=1".to_owned(),
        "--requeue".to_owned(),
        "--open-mode=append".to_owned(),
        format!("--output={}", word(log(job, "merge.log"))),
    ];
    for options in [&mut options, &mut last] {
        options.extend(job.partition.as_ref().map(|partition| format!("--partition={partition}")));
        options.extend(job.account.as_ref().map(|account| format!("--account={account}")));
    }
    let lines = |options: &[String]| options.iter().map(|option| format!("#SBATCH {option}\n")).collect::<String>();
    let again = if job.time.is_some() {
        "  5) # its time was over: the rest in another one\n    [ \"${SLURM_RESTART_COUNT:-0}\" -lt 100 ] && again ;;\n"
    } else {
        ""
    };
    let shard = format!(
        "#!/bin/bash
{}
# One task of the array: one shard of the study, on one node, with the cores that the task was given. It may be killed and started again at
# any time: what it has published is kept, and nothing is computed twice but unfinished chunks. Without --cpus a task has the node (--exclusive)
# and its memory (--mem=0).
set -u
task=${{SLURM_ARRAY_TASK_ID:?is set for the tasks of an array}}
{} &
run=$!
# Ended by scancel or by its time limit: in order.
trap 'kill -TERM \"$run\" 2>/dev/null' TERM
wait \"$run\"; code=$?
while kill -0 \"$run\" 2>/dev/null; do wait \"$run\"; code=$?; done

again() {{ scontrol requeue \"${{SLURM_ARRAY_JOB_ID}}_$task\" && exit 0; }}
failures={}/failures-$SLURM_ARRAY_JOB_ID-$task
case $code in
{again}  6) # a file, a disk or a process failed: three more times
    echo \"$(date) $(hostname)\" >> \"$failures\"
    [ \"$(wc -l < \"$failures\")\" -le 3 ] && again ;;
esac
exit \"$code\"
",
        lines(&options),
        job.shard("\"$task\""),
        word(job.folder()),
    );
    let merge = format!(
        "#!/bin/bash
{}
# After all tasks, however they ended. Exit code 5: chunks are missing, named in the log; `bladeoff submit` again submits these.
exec {}
",
        lines(&last),
        job.merge()
    );
    vec![Script { name: SHARD, text: shard }, Script { name: MERGE, text: merge }]
}

pub(super) fn commands(job: &Job) -> Vec<Command> {
    let (shard, merge) = (job.plain(SHARD), job.plain(MERGE));
    if job.todo.is_empty() {
        return vec![Command::of(&["sbatch", "--parsable", &merge])];
    }
    let array = format!("--array={}", job.array());
    vec![
        Command::of(&["sbatch", "--parsable", &array, &shard]),
        Command::of(&["sbatch", "--parsable", "--dependency=afterany:{0}", &merge]),
    ]
}

/// Path in which Slurm replaces no patterns.
fn log(job: &Job, name: &str) -> String {
    format!("{}/{name}", job.folder().to_string_lossy().replace('%', "%%"))
}

/// Time in minutes, rounded up, for `--time`.
fn minutes(time: Duration) -> u64 {
    time.as_secs().div_ceil(60).max(1)
}
