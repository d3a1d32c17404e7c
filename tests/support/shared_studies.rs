//! Studies that several test modules use.

use super::{Folder, say};

/// 2000 points of a standard normal variable and its double: P(g < 0) = 0.0228.
pub const NORMAL_STUDY: &str = r#"schema = 1
model = "function"
seed = 5

[function]
g = "2 - x"
h = "x * w"

[[uncertain]]
name = "x"
distribution = "normal"
mean = 0
sd = 1

[[vary]]
name = "w"
values = [1, 2]

[design]
kind = "monte-carlo"
samples = 2000
"#;

/// Samples that take some microseconds, so many that their record is larger than 12 MiB.
pub const LARGE_RECORD: &str = r#"schema = 1
model = "function"

[function]
g = "x"

[[vary]]
name = "x"
from = 0
to = 1
count = 80000
"#;

/// Number of samples of [`LARGE_RECORD`].
pub const MANY: u64 = 80_000;

/// Lines of `[function]` with outputs of an input that take some ten microseconds each: a study of few samples that takes time. Many cheap samples
/// would take most of the time for their preparation.
pub fn slow_outputs(count: u32, input: &str) -> String {
    let terms: String = (0..200).map(|term| format!(" + 0 * sin({input} + {term})")).collect();
    (0..count).map(|output| format!("slow{output} = \"{input}{terms}\"\n")).collect()
}

/// Runs a study of two samples of the rig into a directory within the folder; returns the study file.
pub fn two_samples(folder: &Folder, out: &str) -> String {
    folder.write("p.csv", "blade_off.mass\n3 g\n5 g\n");
    let study = folder.write(
        "s.toml",
        "schema = 1\nname = \"d\"\nmachine = \"machines/rig.toml\"\n[set]\n\"run.end_time\" = \"0.002 s\"\n\
         [points]\nfile = \"p.csv\"\n",
    );
    let made = say(&["run", &study, "--out", &folder.name(out), "--workers", "1"]);
    assert_eq!(made.code, 0, "{}", made.err);
    study
}
