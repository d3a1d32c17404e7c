//! `bladeoff doctor`: properties of the computer that matter for a run, for error reports.

use super::bench::host;
use super::error::CliError;
use super::exit::Exit;
use super::json::pretty;
use super::output::{print_json, tell};
use super::run::default_workers;
use crate::version::VERSION;
use bladeoff_numerics::linalg::lanes::Width;
use bladeoff_protocol::domain::Domain;
use bladeoff_system::{shown, threads, with_causes};
use rustix::fs::{FlockOperation, flock, statvfs};
use rustix::process::{Resource, Rlimit, getrlimit};
use serde_json::{Value, json};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Check this computer: shared memory, limits, directories, locks
///
/// Prints what a run depends on besides its files: version, processor, memory, /dev/shm, limits of processes, directories
/// and environment. It tries what a run would do: shared memory for its workers, threads, a file and a lock in the
/// directory. All files of these attempts are removed. Add the output to a report of an error.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff doctor
  bladeoff doctor /scratch/me/runs --workers 64
  bladeoff doctor --json

Exit codes: 0 no problem was found, 6 a run would fail here.")]
pub struct Args {
    /// Directory for results [default: the current one]
    directory: Option<PathBuf>,

    /// Number of workers of the run [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    workers: Option<u16>,

    /// Print JSON: version, number of problems, and for each finding its name, its value and its problem or null
    #[arg(long)]
    json: bool,
}

/// One property of the computer.
struct Finding {
    name: String,
    value: String,
    problem: Option<String>,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let directory = args.directory.clone().unwrap_or_else(|| PathBuf::from("."));
    let workers = args.workers.map_or_else(default_workers, usize::from);
    let findings = findings(&directory, workers);
    let problems = findings.iter().filter(|finding| finding.problem.is_some()).count();
    if args.json {
        print_json(&as_json(&findings, problems))?;
    } else {
        tell(&as_text(&findings, problems))?;
    }
    Ok(if problems == 0 { Exit::Ok } else { Exit::Io })
}

fn as_json(findings: &[Finding], problems: usize) -> String {
    let finding = |found: &Finding| json!({ "name": found.name, "value": found.value, "problem": found.problem });
    let findings: Vec<Value> = findings.iter().map(finding).collect();
    pretty(&json!({ "version": VERSION.as_str(), "problems": problems, "findings": findings }))
}

fn as_text(findings: &[Finding], problems: usize) -> String {
    let mut text = String::new();
    for Finding { name, value, problem } in findings {
        text += &format!("{name:<26} {value}\n");
        if let Some(problem) = problem {
            text += &format!("{:<26} PROBLEM: {problem}\n", "");
        }
    }
    let end = match problems {
        0 => "no problem was found".to_owned(),
        1 => "1 problem was found".to_owned(),
        count => format!("{count} problems were found"),
    };
    format!("{text}\n{end}\n")
}

fn findings(directory: &Path, workers: usize) -> Vec<Finding> {
    let mut found = Vec::new();
    let mut add = |name: &str, value: String, problem: Option<String>| {
        found.push(Finding { name: name.to_owned(), value, problem });
    };
    let width = Width::chosen().map_or_else(|error| error.to_string(), |width| width.to_string());
    add("bladeoff", VERSION.as_str().to_owned(), None);
    add(
        "system",
        format!("{} {}", first_line("/proc/sys/kernel/ostype"), first_line("/proc/sys/kernel/osrelease")),
        None,
    );
    add("processor", format!("{}, kernels for {width}", host::hardware()), None);
    add("load", host::load(), None);
    add("memory", memory(), None);
    add("shared memory", space(Path::new("/dev/shm")), None);
    for (name, resource, is_size) in LIMITS {
        let problem = match resource {
            Resource::As => threads::check_address_space().err().map(|error| error.to_string()),
            _ => None,
        };
        add(&format!("limit: {name}"), limit(getrlimit(resource), is_size), problem);
    }
    add("system files", SYSTEM_FILES.join(", "), missing(&SYSTEM_FILES));
    let attempt = Domain::check(workers).err().map(|error| with_causes(&error));
    add("workers", format!("{workers}: shared memory, open files, runtime directory"), attempt);
    add("threads", "one per core".to_owned(), threads::check().err().map(|error| with_causes(&error)));
    let (results, temporary) = (directory, std::env::temp_dir());
    for (name, directory) in [("results", results), ("temporary files", &temporary)] {
        let problem = try_directory(directory).err();
        add(name, format!("{}, {}", shown(directory), space(directory)), problem);
    }
    for name in VARIABLES {
        if let Some(value) = std::env::var_os(name) {
            add(name, shown(Path::new(&value)), None);
        }
    }
    found
}

/// Files outside /dev/shm without which no worker can start; an empty root directory lacks them.
const SYSTEM_FILES: [&str; 3] = ["/proc/self/exe", "/dev/null", "/dev/urandom"];

/// The files that cannot be opened, with their reasons.
fn missing(paths: &[&str]) -> Option<String> {
    let reason = |path: &&str| File::open(path).err().map(|error| format!("{path}: {error}"));
    let reasons: Vec<String> = paths.iter().filter_map(reason).collect();
    (!reasons.is_empty()).then(|| reasons.join("; "))
}

/// Limits of this process by their names in `ulimit`, and whether they are sizes in bytes.
const LIMITS: [(&str, Resource, bool); 7] = [
    ("open files (-n)", Resource::Nofile, false),
    ("processes (-u)", Resource::Nproc, false),
    ("file size (-f)", Resource::Fsize, true),
    ("address space (-v)", Resource::As, true),
    ("data (-d)", Resource::Data, true),
    ("stack (-s)", Resource::Stack, true),
    ("CPU seconds (-t)", Resource::Cpu, false),
];

/// Environment variables that a run reads.
const VARIABLES: [&str; 7] = [
    "BLADEOFF_RUNTIME_DIR",
    "XDG_RUNTIME_DIR",
    "TMPDIR",
    "RAYON_NUM_THREADS",
    "POLARS_MAX_THREADS",
    "SLURM_JOB_ID",
    bladeoff_numerics::linalg::lanes::WIDTH_VARIABLE,
];

fn first_line(path: &str) -> String {
    let text = fs::read_to_string(path).unwrap_or_default();
    text.lines().next().unwrap_or("unknown").trim().to_owned()
}

/// Memory of the computer, and the limit of a container.
fn memory() -> String {
    let text = fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let kilobytes = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'));
        line.and_then(|rest| rest.trim().strip_suffix(" kB")?.parse::<u64>().ok())
    };
    let show = |kilobytes: Option<u64>| kilobytes.map_or("unknown".to_owned(), |count| size(count << 10));
    let limit = first_line("/sys/fs/cgroup/memory.max").parse::<u64>().ok();
    let limit = limit.map(|bytes| format!(", container limit {}", size(bytes))).unwrap_or_default();
    format!("{}, available {}{limit}", show(kilobytes("MemTotal")), show(kilobytes("MemAvailable")))
}

/// Size and free space of a file system.
fn space(directory: &Path) -> String {
    match statvfs(directory) {
        Ok(found) => {
            let bytes = |blocks: u64| size(blocks.saturating_mul(found.f_frsize));
            format!("{}, free {}", bytes(found.f_blocks), bytes(found.f_bavail))
        }
        Err(error) => format!("unknown ({error})"),
    }
}

fn limit(found: Rlimit, is_size: bool) -> String {
    let show = |limit: Option<u64>| match limit {
        None => "unlimited".to_owned(),
        Some(limit) if is_size => size(limit),
        Some(limit) => limit.to_string(),
    };
    format!("{} (at most {})", show(found.current), show(found.maximum))
}

/// A number of bytes in decimal units.
fn size(bytes: u64) -> String {
    match bytes {
        0..1_000_000 => format!("{:.0} kB", bytes as f64 / 1e3),
        1_000_000..10_000_000_000 => format!("{:.0} MB", bytes as f64 / 1e6),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}

/// Writes, locks and renames a file in a directory, as a run does, and removes it.
fn try_directory(directory: &Path) -> Result<(), String> {
    let temporary = directory.join(format!(".bladeoff-doctor-{}", std::process::id()));
    let renamed = temporary.with_extension("renamed");
    let attempt = || -> Result<(), String> {
        let mut file = File::create_new(&temporary).map_err(|error| format!("no file can be created: {error}"))?;
        file.write_all(b"bladeoff doctor\n").map_err(|error| format!("no file can be written: {error}"))?;
        file.sync_all().map_err(|error| format!("no file can be synchronised: {error}"))?;
        flock(&file, FlockOperation::NonBlockingLockExclusive)
            .map_err(|error| format!("no file can be locked (flock): {error}; see `File systems without locks`"))?;
        fs::rename(&temporary, &renamed).map_err(|error| format!("no file can be renamed: {error}"))
    };
    let tried = attempt();
    for path in [&temporary, &renamed] {
        // One of the two does not exist.
        let _ = fs::remove_file(path);
    }
    tried
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_is_left_as_it_was_and_a_missing_one_is_a_problem() {
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(try_directory(folder.path()), Ok(()));
        assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 0);
        let missing = try_directory(&folder.path().join("missing")).expect_err("not there");
        assert!(missing.starts_with("no file can be created"), "{missing}");
    }

    #[test]
    fn a_missing_system_file_is_named() {
        assert_eq!(missing(&SYSTEM_FILES), None);
        let found = missing(&["/dev/null", "/nowhere/null"]).expect("one is not there");
        assert!(found.starts_with("/nowhere/null: ") && !found.contains("/dev/null"), "{found}");
    }

    #[test]
    fn sizes_have_units() {
        assert_eq!([999, 67_108_864, 24_000_000_000].map(size), ["1 kB", "67 MB", "24.0 GB"]);
    }
}
