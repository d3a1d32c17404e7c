//! The study that is disturbed.

/// The lab rig of `studies/machines`: a machine that is simulated in a fraction of a second.
pub const LAB_RIG: &str = include_str!("../../../studies/machines/lab_rig.toml");

/// 4 gaps x 5 masses of `machines/rig.toml`; a sample takes a tenth of a second, so that there are results on disk before the
/// last begins.
pub const STUDY: &str = r#"schema = 1
name = "faults"
machine = "machines/rig.toml"

[set]
"run.end_time" = "0.1 s"
"run.engine" = "reduced"

[[vary]]
path = "contact.gap"
from = "0.5 mm"
to = "0.9 mm"
count = 4

[[vary]]
path = "blade_off.mass"
from = "3 g"
to = "10 g"
count = 5
"#;

/// Samples of it.
pub const SAMPLES: u64 = 20;
