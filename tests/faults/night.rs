//! Unattended runs: budgets, signals, events for programs, status queries.

use crate::running::{PAUSE, Running, SAMPLES, STUDY, handed_out, signal, state, wait_until};
use crate::support::shared_studies::{LARGE_RECORD, MANY};
use crate::support::{Folder, RUNTIME_VARIABLE, Said, bladeoff, runtime, said};
use std::collections::BTreeSet;
use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A study with so many samples that no run with pauses completes before it is ended.
fn long(folder: &Folder) -> String {
    folder.write("long.toml", &STUDY.replace("count = 5", "count = 500"))
}

fn run(study: &str, out: &str, more: &[&str], fault: Option<&str>) -> Said {
    let mut args = vec!["run", study, "--out", out, "--workers", "2"];
    args.extend(more);
    let mut command = bladeoff(&args);
    if let Some(fault) = fault {
        command.env("BLADEOFF_FAULT", fault);
    }
    said(command.output().expect("it starts"))
}

fn assert_stopped(said: &Said, out: &str, why: &str) {
    assert_eq!(said.code, 5, "{}", said.err);
    assert!(said.err.contains(&format!("ended by {why}")), "{}", said.err);
    assert!(said.err.contains("resume with: "), "{}", said.err);
    assert!(fs::exists(format!("{out}/parts/part-000001.parquet")).expect("readable"));
    assert!(!fs::exists(format!("{out}/results.parquet")).expect("readable"));
}

#[test]
fn a_run_ends_with_its_time_and_says_how_to_go_on() {
    let folder = Folder::new();
    let study = long(&folder);
    // repeated with longer times until a sample is finished on a busy machine
    let in_time = |option: &str, value: &dyn Fn(u32) -> String| {
        let ran = [2, 8, 32, 64].into_iter().find_map(|seconds| {
            let out = folder.name(&format!("{}-{seconds}", &option[2..]));
            let said = run(&study, &out, &[option, &value(seconds)], Some(PAUSE));
            fs::exists(format!("{out}/parts/part-000001.parquet")).expect("readable").then_some((said, out))
        });
        let (said, out) = ran.expect("a sample in a minute");
        assert_stopped(&said, &out, option);
    };
    in_time("--wall", &|seconds| format!("{seconds} s"));
    in_time("--until", &|seconds| {
        let date = Command::new("date").args(["-d", &format!("+{seconds} seconds"), "+%H:%M:%S"]).output();
        String::from_utf8(date.expect("date runs").stdout).expect("UTF-8").trim().to_owned()
    });
    let out = folder.name("wrong");
    for wrong in [
        ["--until", "25:00"],
        ["--wall", "8 hours"],
        ["--memory-limit", "2"],
        ["--crash-limit", "0"],
        ["--kill-limit", "0"],
    ] {
        assert_eq!(run(&study, &out, &wrong, None).code, 2, "{wrong:?}");
    }
}

/// Preparing this study takes one core a minute.
#[test]
fn a_preparation_that_lasts_longer_than_the_run_may_is_ended() {
    let folder = Folder::new();
    let text = "schema = 1\nmodel = \"function\"\n[function]\ng = \"x\"\n[design]\nkind = \"monte-carlo\"\nsamples = 100000000\n\
                [[uncertain]]\nname = \"x\"\ndistribution = \"normal\"\nmean = 0\nsd = 1\n";
    let study = folder.write("many.toml", text);
    let until = Command::new("date").args(["-d", "+2 seconds", "+%H:%M:%S"]).output().expect("date runs").stdout;
    let until = String::from_utf8(until).expect("UTF-8").trim().to_owned();
    for (option, value) in [("--until", until.as_str()), ("--wall", "1 s")] {
        let out = folder.name(&option[2..]);
        let begun = Instant::now();
        let mut command = bladeoff(&["run", &study, "--out", &out, option, value]);
        let ended = said(command.env("RAYON_NUM_THREADS", "1").output().expect("it starts"));
        assert_eq!(ended.code, 5, "{}", ended.err);
        let word = format!("ended by {option} before the first sample was assigned");
        assert!(ended.err.contains(&word), "{}", ended.err);
        // the limit, 5 s more, and the delay of a busy machine
        assert!(begun.elapsed() < Duration::from_secs(40), "{:?}", begun.elapsed());
        let status = said(bladeoff(&["status", &out]).output().expect("it starts"));
        assert!(!status.out.contains("killed"), "{}", status.out);
    }
}

#[test]
fn limits_end_a_run_or_quarantine_a_sample() {
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let fired = folder.path("fired");
    fs::create_dir(&fired).expect("created");
    let fault = |what: &str| format!("who=worker,at=running,sample={what},times=99,dir={}", fired.display());
    let out = folder.name("failures");
    let said = run(&study, &out, &["--max-failures", "1"], Some(&fault("any,do=panic")));
    assert_stopped(&said, &out, "--max-failures");
    // failures of earlier runs count until they are removed from the record
    let recorded = |said: &Said| said.err.lines().find(|line| line.contains("samples are recorded")).map(str::to_owned);
    let again = run(&study, &out, &["--max-failures", "1"], None);
    assert_stopped(&again, &out, "--max-failures");
    assert!(recorded(&said).is_some() && recorded(&again) == recorded(&said), "{}", again.err);
    let taken_out = run(&study, &out, &["--max-failures", "1", "--rerun", "failed"], None);
    assert_eq!(taken_out.code, 0, "{}", taken_out.err);
    // limits of the study and of the command line; a sample that never ends, and one that takes all memory
    let limited = folder.write("limited.toml", &format!("{STUDY}\n[limits]\nmax_failed = 1\ntime_limit = \"20 s\"\n"));
    for (name, study, more, what, cause) in [
        ("time", &limited, &["--crash-limit", "1"][..], "3,do=hang", "time_limit"),
        ("memory", &study, &["--crash-limit", "1", "--memory-limit", "300 MB"][..], "4,do=hoard", "out_of_memory"),
    ] {
        let out = folder.name(name);
        let said = run(study, &out, more, Some(&fault(what)));
        assert_eq!(said.code, if name == "time" { 0 } else { 4 }, "{}", said.err);
        let (header, rows) = crate::support::table(&out);
        let at = |name: &str| header.iter().position(|column| column == name).expect("the column");
        let bad: Vec<_> = rows.iter().filter(|row| row[at("status")] == "quarantined").collect();
        assert_eq!(bad.len(), 1, "{}", said.err);
        assert_eq!((bad[0][0].as_str(), bad[0][at("cause")].as_str()), (&what[..1], cause));
    }
    let wrong = folder.write("wrong.toml", &format!("{STUDY}\n[limits]\ntime_limit = \"2 kg\"\nmemory_limit = 5\n"));
    let said = run(&wrong, &out, &[], None);
    assert_eq!(said.code, 3);
    assert!(said.err.contains("limits.time_limit") && said.err.contains("limits.memory_limit"), "{}", said.err);
}

/// Kills by other processes are counted separately from crashes; many are needed to quarantine a sample, and later runs try it again.
#[test]
fn a_sample_whose_worker_is_killed_again_and_again_is_tried_once_by_every_later_run() {
    let folder = Folder::new();
    let study = folder.write("s.toml", &format!("{STUDY}\n[limits]\nkill_limit = 2\n"));
    let (calm, out) = (folder.name("calm"), folder.name("out"));
    assert_eq!(run(&study, &calm, &[], None).code, 0);
    let bytes = |out: &str| fs::read(format!("{out}/results.parquet")).expect("the table");
    // each fault counts its firings in its own folder
    let fault = |name: &str, what: &str| {
        fs::create_dir(folder.path(name)).expect("created");
        format!("who=worker,at=running,sample=3,{what},dir={}", folder.name(name))
    };
    let fired = |name: &str| fs::read_dir(folder.path(name)).expect("readable").count();
    // two kills used to be enough; in a batch, the first kill does not count
    let said = run(&study, &out, &["--kill-limit", "5"], Some(&fault("twice", "do=kill,times=4")));
    assert_eq!((said.code, fired("twice")), (0, 4), "{}", said.err);
    assert!(bytes(&out) == bytes(&calm));
    let out = folder.name("given-up");
    let said = run(&study, &out, &[], Some(&fault("always", "do=kill,times=99")));
    assert!(said.code == 4 && (2..=3).contains(&fired("always")), "{}: {}", fired("always"), said.err);
    let (header, rows) = crate::support::table(&out);
    let at = |name: &str| header.iter().position(|column| column == name).expect("the column");
    assert_eq!((rows[3][at("status")].as_str(), rows[3][at("cause")].as_str()), ("quarantined", "worker_killed"));
    let given_up = bytes(&out);
    // same command: one more try, one more kill, the same table
    let said = run(&study, &out, &[], Some(&fault("once", "do=kill,times=99")));
    assert_eq!((said.code, fired("once")), (4, 1), "{}", said.err);
    assert!(
        said.err.contains("1 sample whose worker was killed by another program") && bytes(&out) == given_up,
        "{}",
        said.err
    );
    assert!(said.err.contains("19 of 20 samples are already finished, 1 is computed"), "{}", said.err);
    // without kills the row is the undisturbed one, and then nothing is computed
    let said = run(&study, &out, &[], Some(&fault("over", "do=kill,times=0")));
    assert!(said.code == 0 && bytes(&out) == bytes(&calm), "{}", said.err);
    let said = run(&study, &out, &[], None);
    assert!(said.code == 0 && said.err.contains("nothing to compute"), "{}", said.err);
    // a crash is attributed to the sample
    let out = folder.name("crashed");
    let said = run(&study, &out, &[], Some(&fault("crash", "do=abort,times=99")));
    assert!(said.code == 4 && (2..=3).contains(&fired("crash")), "{}", said.err);
    assert_eq!(crate::support::table(&out).1[3][at("cause")], "worker_crashed");
    let said = run(&study, &out, &[], None);
    assert!(said.code == 4 && said.err.contains("nothing to compute"), "{}", said.err);
}

#[test]
fn events_tell_programs_the_whole_story() {
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let mut run = Running::start(&folder, &study, &folder.name("out"), "who=worker,at=running,sample=3,do=kill");
    assert!(run.end().success(), "{}", run.said());
    let events = run.events();
    let name = |event: &serde_json::Value| event["event"].as_str().expect("a name").to_owned();
    let (first, last) = (&events[0], events.last().expect("events"));
    assert_eq!(
        (name(first), first["samples"].as_u64(), first["version"].as_u64()),
        ("started".into(), Some(SAMPLES), Some(2))
    );
    assert_eq!(
        (name(last), last["why"].as_str(), last["done"].as_u64()),
        ("finished".into(), Some("complete"), Some(SAMPLES))
    );
    let samples: Vec<_> = events.iter().filter(|event| name(event) == "sample").collect();
    assert_eq!(
        samples.iter().filter_map(|sample| sample["sample"].as_u64()).collect::<BTreeSet<_>>().len() as u64,
        SAMPLES
    );
    assert_eq!(samples.len() as u64, SAMPLES, "each once");
    assert!(samples.iter().all(|sample| sample["status"] == "ok" && sample["cpu_s"].as_f64() > Some(0.0)));
    let died = events.iter().find(|event| event["died"] == true).expect("a death");
    assert!(events.iter().any(|event| name(event) == "worker_started" && event["replaces"] == died["worker"]));
    assert!(run.said().contains("20 of 20 samples"), "the summary is for people: {}", run.said());
}

#[test]
fn events_of_a_run_whose_record_fails_are_those_of_the_samples_that_the_next_run_finds() {
    let folder = Folder::new();
    let study = folder.write("s.toml", LARGE_RECORD);
    let out = folder.name("out");
    let events = |limit: &str| -> (i32, Vec<serde_json::Value>) {
        let script = format!("ulimit -f {limit}; exec \"$0\" run \"$1\" --out \"$2\" --workers 2 --json-events");
        let mut command = Command::new("bash");
        command.args(["-c", &script, crate::support::BINARY, &study, &out]).env(RUNTIME_VARIABLE, runtime());
        let ran = command.output().expect("bash");
        let ran = said(ran);
        (ran.code, ran.out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect())
    };
    let samples = |events: &[serde_json::Value]| -> BTreeSet<u64> {
        let told = events.iter().filter(|event| event["event"] == "sample");
        let numbers: Vec<u64> = told.map(|event| event["sample"].as_u64().expect("a number")).collect();
        let distinct: BTreeSet<u64> = numbers.iter().copied().collect();
        assert_eq!(distinct.len(), numbers.len(), "each once");
        distinct
    };
    let (code, first) = events("12288");
    assert_eq!((code, first.last().expect("events")["event"].as_str()), (6, Some("failed")));
    let (code, second) = events("unlimited");
    assert_eq!(code, 0);
    let (told, rest) = (samples(&first), samples(&second));
    assert!(!told.is_empty() && !rest.is_empty(), "{} and {}", told.len(), rest.len());
    assert_eq!(second[0]["recorded"].as_u64(), Some(told.len() as u64), "what was told is what is found");
    assert!(told.is_disjoint(&rest) && (told.len() + rest.len()) as u64 == MANY, "{} and {}", told.len(), rest.len());
}

/// Fault that stops the orchestrator at this state of the second assigned sample.
fn stop_at(state: &str) -> String {
    format!("who=orchestrator,at={state},sample={},do=stop", handed_out(SAMPLES, 1))
}

/// A run whose orchestrator is stopped at a known state, receives these signals, and continues.
fn signalled(fault: &str, signals: &[&str]) -> (Folder, Running) {
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let run = Running::start_slow(&folder, &study, &folder.name("out"), fault);
    let pid = run.child.id();
    wait_until("it stops", || run.fired() > 0 && state(pid) == Some('T'));
    for name in signals {
        assert!(signal(pid, name));
    }
    assert!(signal(pid, "CONT"));
    (folder, run)
}

#[test]
fn a_signal_ends_a_run_in_order() {
    for (name, code, why) in [("INT", 130, "interrupted"), ("TERM", 143, "terminated"), ("HUP", 143, "terminated")] {
        // at the first assignment: later, all samples might be done before the signal is handled
        let (folder, mut run) = signalled(&stop_at("claimed"), &[name]);
        assert_eq!(run.end().code(), Some(code), "{name}: {}", run.said());
        assert_eq!(run.count("stopping"), 1);
        // one word for the reason in every event
        let told = |event: &str| run.events().into_iter().find(|told| told["event"] == event).expect("told");
        assert_eq!((&told("stopping")["why"], &told("finished")["why"]), (&why.into(), &why.into()));
        let read = |name: &str| fs::read(folder.path(&format!("out/{name}"))).expect("there");
        let json = |text: &[u8]| serde_json::from_slice::<serde_json::Value>(text).expect("JSON");
        assert_eq!(
            (&json(&read("manifest.json"))["state"], &json(&read("status.json"))["state"]),
            (&why.into(), &why.into())
        );
        let status = said(bladeoff(&["status", &folder.name("out"), "--json"]).output().expect("it starts"));
        assert_eq!(json(status.out.as_bytes())["ended"], why);
        assert!(run.said().contains(&format!("{why}: ")), "{}", run.said());
        // on a busy machine no sample may have finished within the grace time
        let finished = json(status.out.as_bytes())["done"].as_u64().expect("a number") > 0;
        assert_eq!(folder.path("out/parts/part-000001.parquet").exists(), finished);
    }
}

#[test]
fn a_signal_while_tables_are_written_is_answered_and_the_second_ends_it() {
    let at_tables = "who=orchestrator,at=writing,sample=0,do=stop";
    let (folder, mut run) = signalled(at_tables, &["TERM"]);
    assert_eq!(run.end().code(), Some(0), "{}", run.said());
    assert!(folder.path("out/results.parquet").exists());
    // ended by a first signal; the signal while tables are written is the second
    let (folder, mut run) = signalled(&format!("{};{at_tables}", stop_at("claimed")), &["INT"]);
    let pid = run.child.id();
    wait_until("it stops again", || run.fired() == 2 && state(pid) == Some('T'));
    assert!(signal(pid, "INT") && signal(pid, "CONT"));
    // either the signal or the table may come first; both give exit code 130 and no incomplete file
    assert_eq!(run.end().code(), Some(130), "{}", run.said());
    assert!(!folder.path("out/results.parquet").exists());
}

#[test]
fn under_nohup_a_hangup_is_nothing() {
    let folder = Folder::new();
    let study = folder.write("s.toml", STUDY);
    let out = folder.name("out");
    let bin = bladeoff(&[]).get_program().to_owned();
    let mut child = Command::new("nohup")
        .arg(bin)
        .args(["run", &study, "--out", &out, "--workers", "2"])
        .env(RUNTIME_VARIABLE, runtime())
        .env("BLADEOFF_FAULT", format!("{},dir={}", stop_at("claimed"), folder.name("")))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("nohup runs");
    let pid = child.id();
    wait_until("it stops", || state(pid) == Some('T'));
    assert!(signal(pid, "HUP") && signal(pid, "CONT"));
    assert_eq!(child.wait().expect("a child").code(), Some(0));
}

#[test]
fn whoever_asks_is_told_what_the_workers_do() {
    let (_folder, mut run) = signalled(&stop_at("recorded"), &["USR1"]);
    assert_eq!(run.end().code(), Some(0), "{}", run.said());
    assert!(run.said().contains("worker 1 (process "), "{}", run.said());
    assert!(run.said().contains("worker 2 (process "), "{}", run.said());
}
