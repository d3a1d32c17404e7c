//! Common parts of the command-line tests: the binary, temporary folders, small studies that take seconds.

#![allow(dead_code, reason = "each test program uses its part")]

pub mod docs;
pub mod hooks;
pub mod pictures;
pub mod processes;
pub mod read_only;
pub mod screen;
pub mod shared_studies;
pub mod skipped;

pub use bladeoff_protocol::runtime::RUNTIME_VARIABLE;
use std::fs;
use std::os::unix::fs::{DirBuilderExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

/// A lock for tests that count processes and files, or whose studies would only compete for the same cores.
pub fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The binary under test: that of the test's package, `bladeoff` or `bladeoff-dev`.
pub const BINARY: &str = match (option_env!("CARGO_BIN_EXE_bladeoff-dev"), option_env!("CARGO_BIN_EXE_bladeoff")) {
    (Some(path), _) | (None, Some(path)) => path,
    (None, None) => panic!("the package of this test has no binary that is tested here"),
};

/// Root folder of the repository.
pub fn root() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.ancestors().find(|folder| folder.join("Cargo.lock").is_file()).expect("the repository").to_path_buf()
}

/// A command with the binary of this build, run in the repository.
pub fn bladeoff(args: &[&str]) -> Command {
    let mut command = Command::new(BINARY);
    command.args(args).current_dir(root()).env_remove("BLADEOFF_FAULT").env(RUNTIME_VARIABLE, runtime());
    command
}

/// Folder for the sockets of this test program, separate from those of the user and of other tests. Its path is short; folders of test
/// programs that have ended are removed by the next one.
pub fn runtime() -> &'static Path {
    static DIRECTORY: OnceLock<PathBuf> = OnceLock::new();
    DIRECTORY.get_or_init(|| {
        let all = PathBuf::from(format!("/tmp/bo-tests-{}", rustix::process::getuid().as_raw()));
        let make = |path: &Path| fs::DirBuilder::new().mode(0o700).recursive(true).create(path).expect("created");
        make(&all);
        let ours = std::process::id();
        for entry in fs::read_dir(&all).expect("readable").flatten() {
            let pid: Option<u32> = entry.file_name().to_str().and_then(|name| name.parse().ok());
            if pid.is_some_and(|pid| pid == ours || !processes::lives(pid)) {
                // another test program may remove it first
                let _ = fs::remove_dir_all(entry.path());
            }
        }
        let own = all.join(ours.to_string());
        make(&own);
        own
    })
}

/// Copies the binary of this build. `cp` writes it: if this program had the file open for writing, a process started by another thread at
/// that moment would inherit the handle, and a file open for writing cannot be executed.
pub fn copy_binary(to: &Path) {
    let copied = Command::new("cp").arg(BINARY).arg(to).status().expect("cp runs");
    assert!(copied.success(), "{}", to.display());
}

/// Writes an executable script; a shell writes it, for the same reason.
pub fn write_script(to: &Path, text: &str) {
    let mut shell = Command::new("sh");
    shell.args(["-c", "printf %s \"$2\" > \"$1\" && chmod 755 \"$1\"", "sh"]).arg(to).arg(text);
    assert!(shell.status().expect("sh runs").success(), "{}", to.display());
}

/// Output and exit code of a command.
pub struct Said {
    /// Exit code.
    pub code: i32,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

/// Runs a command to its end.
pub fn say(args: &[&str]) -> Said {
    said(bladeoff(args).output().expect("the binary starts"))
}

/// Parses JSON.
pub fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// Output of an ended process as text.
pub fn said(output: Output) -> Said {
    Said {
        code: output.status.code().expect("not ended by a signal"),
        out: String::from_utf8(output.stdout).expect("UTF-8"),
        err: String::from_utf8(output.stderr).expect("UTF-8"),
    }
}

/// A folder with a machine that is simulated in a fraction of a second, removed when dropped.
pub struct Folder(tempfile::TempDir);

impl Folder {
    /// A folder with `machines/rig.toml`: the lab rig, with contact from 0.15 s on, up to 0.17 s.
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        let rig = fs::read_to_string(root().join("studies/machines/lab_rig.toml")).expect("the lab rig");
        assert!(rig.contains("end_time = \"0.6 s\""), "the lab rig as this test knows it");
        // one engine for every test, that of studies; tests/program/auto.rs tests machines without a named engine
        let rig = rig.replace("[run]\n", "[run]\nengine = \"exponential\"\n");
        folder.write("machines/rig.toml", &rig.replace("end_time = \"0.6 s\"", "end_time = \"0.17 s\""));
        folder
    }

    /// Path of a file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Path of a file in the folder, as text.
    pub fn name(&self, name: &str) -> String {
        self.path(name).to_str().expect("UTF-8").to_owned()
    }

    /// Writes a file; returns its path.
    pub fn write(&self, name: &str, text: &str) -> String {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("inside the folder")).expect("created");
        fs::write(&path, text).expect("written");
        // runs within a test program change its umask temporarily, and other users read these files
        fs::set_permissions(&path, fs::Permissions::from_mode(0o644)).expect("own");
        self.name(name)
    }

    /// Returns a folder whose machine runs on the reference engine `reduced`, for tests of its equal steps.
    pub fn reduced() -> Self {
        let folder = Self::new();
        let rig = fs::read_to_string(folder.path("machines/rig.toml")).expect("the rig");
        assert!(rig.contains("engine = \"exponential\""), "{rig}");
        folder.write("machines/rig.toml", &rig.replace("engine = \"exponential\"", "engine = \"reduced\""));
        folder
    }

    /// A study of 12 samples, some of which have contact.
    pub fn small_study(&self) -> String {
        self.write("small.toml", SMALL_STUDY)
    }
}

/// Gap x friction (not zipped) x detection: 2 x 2 x 3 samples.
pub const SMALL_STUDY: &str = r#"# a remark that is kept
schema = 1
name = "small"
machine = "machines/rig.toml"
seed = 7

[[vary]]
path = "contact.gap"
values = ["0.5 mm", "0.9 mm"]

[[vary]]
path = "contact.friction"
from = 0.1
to = 0.2
count = 2

[[vary]]
path = "contact.detection"
values = ["hyp1", "hyp2", "hyp2-frozen"]
"#;

/// Rows of a result directory, exported: header and cells.
pub fn table(directory: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let csv = say(&["export", directory, "--csv"]);
    assert_eq!(csv.code, 0, "{}", csv.err);
    let cells = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
    let mut lines = csv.out.lines();
    let header = cells(lines.next().expect("a header"));
    (header, lines.map(cells).collect())
}

/// Whether two lines have equal words and numbers within 2 %, because numbers change slightly with the numerics.
pub fn says_the_same(line: &str, shown: &str) -> bool {
    let words =
        |line: &str| line.split_whitespace().map(|word| word.trim_end_matches(',').to_owned()).collect::<Vec<_>>();
    let (line, shown) = (words(line), words(shown));
    let same = |a: &String, b: &String| match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= 0.02 * b.abs(),
        _ => a == b,
    };
    line.len() == shown.len() && line.iter().zip(&shown).all(|(a, b)| same(a, b))
}
