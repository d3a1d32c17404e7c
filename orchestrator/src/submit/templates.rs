//! Scripts for PBS, LSF and HyperQueue: reviewed, but not run in our tests. The user checks and submits them.

use super::{Command, Job, Script};
use bladeoff_system::call::word;
use std::time::Duration;

const SHARD: &str = "shard.sh";
const MERGE: &str = "merge.sh";

/// PBS Pro, OpenPBS. An array has one range and at least two tasks, so there is a job for each range.
pub(super) fn pbs(job: &Job) -> Vec<Script> {
    let mut options = vec!["-r y".to_owned(), "-j oe".to_owned(), format!("-o {}", job.path(""))];
    options.push(
        job.cpus.map_or_else(|| "-l select=1 -l place=excl".to_owned(), |cpus| format!("-l select=1:ncpus={cpus}")),
    );
    options.extend(job.time.map(|time| format!("-l walltime={}", hours(time))));
    let last = vec!["-j oe".to_owned(), format!("-o {}", job.path("merge.log"))];
    scripts(job, "#PBS", ("-N", "-q", "-A"), (&options, &last), "task=${PBS_ARRAY_INDEX:-$SHARD}")
}

pub(super) fn pbs_commands(job: &Job) -> Vec<Command> {
    let (shard, merge) = (job.plain(SHARD), job.plain(MERGE));
    let mut commands = Vec::new();
    let mut depends = Vec::new();
    for (place, (first, last)) in job.ranges().into_iter().enumerate() {
        depends.push(format!("{{{place}}}"));
        commands.push(if first == last {
            Command::of(&["qsub", "-v", &format!("SHARD={first}"), &shard])
        } else {
            Command::of(&["qsub", "-J", &format!("{first}-{last}"), &shard])
        });
    }
    let after = format!("depend=afterany:{}", depends.join(":"));
    commands.push(if depends.is_empty() {
        Command::of(&["qsub", &merge])
    } else {
        Command::of(&["qsub", "-W", &after, &merge])
    });
    commands
}

/// LSF. Tasks are numbered from 1.
pub(super) fn lsf(job: &Job) -> Vec<Script> {
    let one_more: Vec<String> = job
        .ranges()
        .iter()
        .map(
            |(first, last)| {
                if first == last { format!("{}", first + 1) } else { format!("{}-{}", first + 1, last + 1) }
            },
        )
        .collect();
    let mut options = vec![format!("-J \"{}[{}]\"", job.study, one_more.join(",")), "-r".to_owned()];
    options.push(format!("-o {}", job.path("shard-%I.log")));
    options.push("-R \"span[hosts=1]\"".to_owned());
    options.push(job.cpus.map_or_else(|| "-x".to_owned(), |cpus| format!("-n {cpus}")));
    options.extend(job.time.map(|time| format!("-W {}", time.as_secs().div_ceil(60).max(1))));
    let mut last = vec![format!("-J {}-merge", job.study), format!("-o {}", job.path("merge.log"))];
    if !job.todo.is_empty() {
        last.push(format!("-w \"ended({})\"", job.study));
    }
    scripts(job, "#BSUB", ("", "-q", "-P"), (&options, &last), "task=$((LSB_JOBINDEX - 1))")
}

pub(super) fn lsf_commands(job: &Job) -> Vec<Command> {
    let by = |name: &str| Command(vec!["sh".to_owned(), "-c".to_owned(), format!("bsub < {}", job.path(name))]);
    let shards = if job.todo.is_empty() { None } else { Some(by(SHARD)) };
    shards.into_iter().chain([by(MERGE)]).collect()
}

/// HyperQueue. The user starts the merge after `hq job wait last`, or `submit --wait`.
pub(super) fn hyperqueue(job: &Job) -> Vec<Script> {
    let mut options = vec![format!("--array {}", job.array()), format!("--name {}", job.study)];
    options.push("--crash-limit 3".to_owned());
    options.push(format!(
        "--stdout {} --stderr {}",
        job.path("shard-%{TASK_ID}.log"),
        job.path("shard-%{TASK_ID}.err")
    ));
    options.push(job.cpus.map_or_else(|| "--cpus all".to_owned(), |cpus| format!("--cpus {cpus}")));
    options.extend(job.time.map(|time| format!("--time-limit {}s", time.as_secs())));
    let mut all = scripts(job, "#HQ", ("", "", ""), (&options, &[]), "task=$HQ_TASK_ID");
    all.truncate(1);
    all
}

pub(super) fn hyperqueue_commands(job: &Job) -> Vec<Command> {
    let mut commands = Vec::new();
    if !job.todo.is_empty() {
        commands.push(Command::of(&["hq", "submit", "--wait", &job.plain(SHARD)]));
    }
    commands.push(Command(vec!["sh".to_owned(), "-c".to_owned(), job.merge()]));
    commands
}

/// Both scripts of a scheduler. `named`: its options for the name, the queue and the account; `task`: expression for the task number.
fn scripts(
    job: &Job,
    mark: &str,
    named: (&str, &str, &str),
    (options, last): (&[String], &[String]),
    task: &str,
) -> Vec<Script> {
    let (name, queue, account) = named;
    let lines = |options: &[String], called: &str| {
        let named = |option: &str, value: Option<&str>| {
            value.filter(|_| !option.is_empty()).map(|value| format!("{option} {}", word(value)))
        };
        let mut all: Vec<String> = named(name, Some(called)).into_iter().chain(options.iter().cloned()).collect();
        all.extend(named(queue, job.partition.as_deref()));
        all.extend(named(account, job.account.as_deref()));
        all.iter().map(|option| format!("{mark} {option}\n")).collect::<String>()
    };
    let shard = format!(
        "#!/bin/bash
{}
# A template that the developers reviewed but did not run: read it before you submit it. One task: one shard of the study, on one node. It may be
# killed and started again at any time: what it has published is kept. Exit code 5: its time was over; `bladeoff submit` again resumes.
{}
for _ in 1 2 3 4; do
  {}; code=$?
  [ \"$code\" = 6 ] || break # a file, a disk or a process failed: three more times
done
exit \"$code\"
",
        lines(options, &job.study),
        task,
        job.shard("\"$task\"")
    );
    let merge = format!(
        "#!/bin/bash
{}
# After all tasks, however they ended. Exit code 5: chunks are missing, named in the log; `bladeoff submit` again submits these.
{}
",
        lines(last, &format!("{}-merge", job.study)),
        job.merge()
    );
    vec![Script { name: SHARD, text: shard }, Script { name: MERGE, text: merge }]
}

fn hours(time: Duration) -> String {
    let seconds = time.as_secs();
    format!("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}
