//! GNU parallel, on this host or over ssh on several: for a few workstations without a scheduler.

use super::{Command, Job, Script};
use bladeoff_system::call::word;

const NAME: &str = "shards.sh";

pub(super) fn scripts(job: &Job) -> Vec<Script> {
    // `:` is this host, without ssh.
    let hosts = if job.hosts.is_empty() { ":".to_owned() } else { job.hosts.join(",") };
    let numbers: Vec<String> = job.todo.iter().map(u64::to_string).collect();
    let shards = if numbers.is_empty() {
        "# Nothing is missing.\n".to_owned()
    } else {
        format!(
            "# One shard at a time on each host. A shard that fails is tried again, up to three times, on another host if there is one.\n\
             parallel --sshlogin {} --jobs 1 --retries 4 --joblog {} --line-buffer --tag \\\n  {} \\\n  ::: {}\n",
            word(&hosts),
            job.path("shards.joblog"),
            word(job.shard("{}")),
            numbers.join(" ")
        )
    };
    let text = format!(
        "#!/bin/bash
# The shards of the study by GNU parallel, then the merge. All hosts must see the paths below under the same names, and this user must
# reach them by ssh without a password. It may be ended and started again at any time: what is published is kept.
{shards}
# Exit code 5: chunks are missing, named here; the same script, or `bladeoff submit` again, resumes.
exec {}
",
        job.merge()
    );
    vec![Script { name: NAME, text }]
}

pub(super) fn commands(job: &Job) -> Vec<Command> {
    vec![Command::of(&["bash", &job.plain(NAME)])]
}
