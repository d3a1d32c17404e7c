//! `bladeoff submit` without a cluster scheduler: GNU parallel over hosts, the script of a task, repeated submission.

use crate::support::docs::{blocks, with};
use crate::support::skipped::skipped;
use crate::support::{Folder, RUNTIME_VARIABLE, Said, bladeoff, root, runtime, said, say, write_script};
use std::fs;
use std::path::Path;
use std::process::Command;

/// A study of 120 samples.
const STUDY: &str = r#"schema = 1
name = "f"
model = "function"
seed = 3

[function]
g = "a * k"

[design]
kind = "monte-carlo"
samples = 60

[[uncertain]]
name = "a"
distribution = "normal"
mean = 3
sd = 1

[[vary]]
name = "k"
values = [1, 2]
"#;

fn executable(path: &Path, text: &str) {
    fs::create_dir_all(path.parent().expect("inside a folder")).expect("made");
    write_script(path, text);
}

/// A shell block that uses the program of this build.
fn shell(block: &str) -> Command {
    let mut command = Command::new("bash");
    command.args(["-ec", block]).current_dir(root()).env_remove("BLADEOFF_FAULT").env(RUNTIME_VARIABLE, runtime());
    command
}

/// A replacement for ssh that runs the command on this host; the host `dead` fails.
fn ssh(path: &Path, dead: &str) {
    executable(
        path,
        // like sshd: the shell of the account is in the environment, for any environment of the test
        &format!(
            "#!/bin/sh\nexport SHELL=/bin/sh\nwhile [ \"${{1#-}}\" != \"$1\" ]; do shift; done\nhost=$1; shift; [ \"$1\" = -- ] && shift\n\
             echo \"$host\" >> \"$0.log\"\n[ \"$host\" = \"{dead}\" ] && exit 255\nexec sh -c \"$*\"\n"
        ),
    );
}

fn submit(folder: &Folder, scheduler: &str, more: &[&str]) -> Command {
    let (study, out) = (folder.name("f.toml"), folder.name("out"));
    bladeoff(&[&["submit", &study, "--scheduler", scheduler, "--out", &out, "--chunk", "10"], more].concat())
}

fn same_tables(folder: &Folder, out: &str) {
    let one = say(&["run", &folder.name("f.toml"), "--out", &folder.name("one")]);
    assert_eq!(one.code, 0, "{}", one.err);
    let read = |name: &str| fs::read(folder.path(name)).expect("there");
    assert!(read("one/results.parquet") == read(&format!("{out}/results.parquet")), "other bytes");
}

#[test]
fn gnu_parallel_computes_on_its_hosts_one_of_which_is_dead() {
    if Command::new("parallel").arg("--version").output().is_err() {
        return skipped("a study by GNU parallel", "lacks: parallel");
    }
    let folder = Folder::new();
    folder.write("f.toml", STUDY);
    let ssh = folder.path("ssh");
    self::ssh(&ssh, "red");
    let mut command = submit(&folder, "parallel", &["--shards", "4", "--hosts", "blue,red"]);
    let Said { code, out, err } =
        said(command.env("PARALLEL_SSH", &ssh).env("PARALLEL_HOME", folder.path("home")).output().expect("it starts"));
    assert_eq!(code, 0, "{out}{err}");
    let asked = fs::read_to_string(folder.path("ssh.log")).expect("written");
    assert!(asked.contains("blue") && asked.contains("red"), "{asked}");
    let log = fs::read_to_string(folder.path("out/scheduler/shards.joblog")).expect("written");
    let ended = |host: &str, well: bool| {
        let fields = log.lines().skip(1).map(|line| line.split('\t').collect::<Vec<_>>());
        fields.filter(|fields| fields[1] == host && (fields[6] == "0") == well).count()
    };
    assert!(ended("red", false) + ended("red", true) <= 4 && ended("blue", true) == 4, "{log}");
    same_tables(&folder, "out");
    assert!(out.contains("f: 120 of 120 samples"), "{out}{err}");
    // second time: only the table is left, and it exists
    let again = said(submit(&folder, "parallel", &["--shards", "2"]).output().expect("it starts"));
    assert!(again.code == 0 && again.err.contains("every chunk exists"), "{}", again.err);
}

#[test]
fn the_commands_of_the_page_without_a_scheduler_make_the_table_of_one_machine() {
    let folder = Folder::new();
    let (study, program) = (folder.write("f.toml", STUDY), env!("CARGO_BIN_EXE_bladeoff"));
    let paths = |out: &str| {
        let commands = [("bladeoff ", format!("{program} ")), ("studies/gap-friction-map.toml", study.clone())];
        [commands.to_vec(), vec![("runs/night", folder.name(out))]].concat()
    };
    let written = |block: &str, out: &str| {
        let paths = paths(out);
        with(block, &paths.iter().map(|(written, other)| (*written, other.as_str())).collect::<Vec<_>>())
    };
    let run = |command: &mut Command| {
        let Said { code, out, err } = said(command.output().expect("bash"));
        assert_eq!(code, 0, "{out}{err}");
    };
    let by_hand = blocks("docs/cluster.md", "--shard I/16");
    let [by_hand] = &by_hand[..] else { panic!("{by_hand:?}") };
    let lines = written(by_hand, "hand");
    let (on_each, once) = lines.split_once('\n').expect("two commands");
    (0..16).for_each(|number| run(&mut shell(&on_each.replace("I/16", &format!("{number}/16")))));
    run(&mut shell(once));
    same_tables(&folder, "hand");
    let parallel = blocks("docs/cluster.md", "--scheduler parallel");
    let [parallel] = &parallel[..] else { panic!("{parallel:?}") };
    if Command::new("parallel").arg("--version").output().is_err() {
        return skipped("the command of docs/cluster.md for GNU parallel", "lacks: parallel");
    }
    let stand_in = folder.path("ssh");
    ssh(&stand_in, "nobody");
    let mut command = shell(&written(parallel, "out"));
    run(command.env("PARALLEL_SSH", &stand_in).env("PARALLEL_HOME", folder.path("home")));
    let asked = fs::read_to_string(folder.path("ssh.log")).expect("written");
    assert!(["blue", "red", "green", "black"].iter().all(|host| asked.contains(host)), "{asked}");
    same_tables(&folder, "out");
}

#[test]
fn what_is_handed_in_again_are_the_shards_that_lack_a_chunk() {
    let folder = Folder::new();
    folder.write("f.toml", STUDY);
    let (study, out, scratch) = (folder.name("f.toml"), folder.name("out"), folder.name("scratch"));
    let dry =
        |more: &[&str]| said(submit(&folder, "slurm", &[&["--dry-run"], more].concat()).output().expect("starts"));
    let first = dry(&["--shards", "16"]);
    assert!(
        first.code == 0 && first.out.contains("job0=$(sbatch --parsable --array=0-11 "),
        "{}{}",
        first.out,
        first.err
    );
    assert!(first.out.contains("\"--dependency=afterany:$job0\""), "{}", first.out);
    // a task has as many workers as allocated cores
    let mut shard = bladeoff(&["run", &study, "--out", &out, "--shard", "0/1", "--scratch", &scratch]);
    let shard = said(shard.env("SLURM_CPUS_ON_NODE", "1").output().expect("it starts"));
    assert!(shard.code == 0 && shard.err.contains("120 samples of 1 formula, 1 worker"), "{}", shard.err);
    for chunk in ["chunk-000001.bin", "chunk-000005.bin"] {
        fs::remove_file(folder.path("out/chunks/000").join(chunk)).expect("it was there");
    }
    let again = dry(&["--shards", "4"]);
    assert!(again.out.contains("--array=1 "), "{}", again.out);
    assert!(dry(&["--shards", "3"]).out.contains("--array=1-2 "));
    let wrong = said(submit(&folder, "slrum", &["--shards", "3"]).output().expect("it starts"));
    assert!(wrong.code == 2 && wrong.err.contains("did you mean slurm?"), "{}", wrong.err);
    let hosts = dry(&["--shards", "3", "--hosts", "a"]);
    assert!(hosts.code == 2 && hosts.err.contains("--scheduler parallel"), "{}", hosts.err);
    let pbs = said(submit(&folder, "pbs", &["--shards", "3"]).output().expect("it starts"));
    assert!(
        pbs.code == 0 && pbs.err.contains("did not run") && pbs.out.contains("job0=$(qsub -J 1-2 "),
        "{}{}",
        pbs.out,
        pbs.err
    );
}

#[test]
fn a_task_of_slurm_is_requeued_three_times_after_exit_code_6_and_when_its_time_was_over() {
    let folder = Folder::new();
    folder.write("f.toml", STUDY);
    let dry = submit(&folder, "slurm", &["--dry-run", "--shards", "2", "--time", "1h"]).output().expect("it starts");
    assert!(dry.status.success(), "{}", String::from_utf8_lossy(&dry.stderr));
    // a program with a given exit code, and a scontrol that records its arguments
    executable(&folder.path("bin/bladeoff"), "#!/bin/sh\nexit \"$ENDS\"\n");
    executable(&folder.path("bin/scontrol"), "#!/bin/sh\necho \"$*\" >> \"$TOLD\"\nexit \"$ANSWER\"\n");
    let script = fs::read_to_string(folder.path("out/scheduler/shard.sbatch")).expect("written");
    let script = script.replace(env!("CARGO_BIN_EXE_bladeoff"), &folder.name("bin/bladeoff"));
    assert!(
        script.contains("--time=60") && script.contains("--wall 3240s") && script.contains("--exclusive"),
        "{script}"
    );
    let path = folder.write("shard.sbatch", &script);
    let told = folder.path("told");
    // exit code of the task, and requests to requeue it
    let task = |ends: &str, task: &str, answer: &str, restarts: &str| {
        let _ = fs::remove_file(&told);
        let mut command = Command::new("bash");
        command.arg(&path).env("PATH", format!("{}:{}", folder.name("bin"), std::env::var("PATH").expect("set")));
        command.env("SLURM_ARRAY_TASK_ID", task).env("SLURM_ARRAY_JOB_ID", "70").env("SLURM_RESTART_COUNT", restarts);
        let ended = command.env("ENDS", ends).env("ANSWER", answer).env("TOLD", &told).output().expect("bash");
        let told = fs::read_to_string(&told).unwrap_or_default();
        assert!(told.is_empty() || told == format!("requeue 70_{task}\n"), "{told}");
        (ended.status.code().expect("not killed"), told.lines().count())
    };
    assert_eq!(task("0", "0", "0", "0"), (0, 0));
    for _ in 0..3 {
        assert_eq!(task("6", "1", "0", "0"), (0, 1), "requeued");
    }
    assert_eq!(task("6", "1", "0", "0"), (6, 0), "three times at most");
    assert_eq!(task("6", "0", "1", "0"), (6, 1), "Slurm does not do it: the failure stands");
    assert_eq!(task("5", "0", "0", "7"), (0, 1), "its time was over");
    assert_eq!(task("5", "0", "0", "100"), (5, 0), "not for ever");
    assert_eq!(task("3", "0", "0", "0"), (3, 0), "a wrong study is wrong again");
}

/// Times as users of Slurm write them; 480 alone would be 8 minutes instead of the intended 8 hours.
#[test]
fn the_time_of_a_task_is_read_as_schedulers_write_it_and_a_bare_number_is_refused() {
    let folder = Folder::new();
    folder.write("f.toml", STUDY);
    let dry = |time: &str| {
        let more = ["--dry-run", "--shards", "2", "--time", time];
        said(submit(&folder, "slurm", &more).output().expect("it starts"))
    };
    let bare = dry("480");
    assert!(bare.code == 2 && bare.err.contains("write 480min or 480s"), "{}: {}", bare.code, bare.err);
    assert!(!folder.path("out").exists());
    let unclear = dry("08:00");
    assert!(unclear.code == 2 && unclear.err.contains("write HH:MM:SS"), "{}: {}", unclear.code, unclear.err);
    for (time, minutes, told) in [
        ("480min", 480, "each task has 8 h 00 min; it ends after 7 h 50 min"),
        ("08:00:00", 480, "8 h 00 min"),
        ("1-00:00:00", 1440, "24 h 00 min"),
        ("1-12", 2160, "36 h 00 min"),
        ("1d", 1440, "24 h 00 min"),
        ("1h30m", 90, "1 h 30 min"),
    ] {
        let said = dry(time);
        assert!(said.code == 0 && said.err.contains(told), "{time}: {}", said.err);
        let script = fs::read_to_string(folder.path("out/scheduler/shard.sbatch")).expect("written");
        assert!(script.contains(&format!("#SBATCH --time={minutes}\n")), "{time}: {script}");
    }
}

#[test]
fn a_run_in_a_task_has_as_many_workers_as_the_task_has_cores() {
    let folder = Folder::new();
    let (study, scratch) = (folder.write("f.toml", STUDY), folder.name("scratch"));
    for (out, shard) in [("plain", &[][..]), ("shard", &["--shard", "0/1", "--scratch", &scratch])] {
        let out = folder.name(out);
        let mut command = bladeoff(&[&["run", &study, "--out", &out], shard].concat());
        let run = said(command.env("SLURM_JOB_ID", "1").env("SLURM_CPUS_ON_NODE", "1").output().expect("it starts"));
        assert!(run.code == 0 && run.err.contains("120 samples of 1 formula, 1 worker,"), "{}", run.err);
    }
    // an invalid number of cores is ignored, and never more workers than cores are used
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get);
    for odd in ["24(x2)", "abc", "", "0", "-1", "1e20", "100000"] {
        let out = folder.name(&format!("odd{}", odd.len()));
        let mut command = bladeoff(&["run", &study, "--out", &out]);
        let run = said(command.env("SLURM_CPUS_ON_NODE", odd).output().expect("it starts"));
        assert!(run.code == 0 && run.err.contains(&format!(", {cores} worker")), "{odd}: {}", run.err);
    }
}
