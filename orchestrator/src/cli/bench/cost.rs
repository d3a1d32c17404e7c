//! Measurement of one stage in its own process: time, CPU time, memory.

use super::super::error::CliError;
use bladeoff_system::files::FileError;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// Cost of a stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    pub seconds: f64,
    pub cpu_s: Option<f64>,
    pub peak_mb: Option<f64>,
}

/// Measures one stage of a study in a directory, in its own process.
pub(super) fn measure(what: &str, study: &Path, directory: &Path) -> Result<Cost, CliError> {
    let mut command = Command::new("/proc/self/exe");
    command.args(["bench", "stage", what]).arg(study).arg(directory);
    let failed = FileError::at("measure", directory);
    let output = match command.stderr(Stdio::inherit()).output() {
        Ok(output) => output,
        Err(source) => return Err(failed(source).into()),
    };
    let said: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
    let Some(seconds) = said["seconds"].as_f64().filter(|_| output.status.success()) else {
        return Err(failed(std::io::Error::other(format!("stage {what}: {}", output.status))).into());
    };
    Ok(Cost { seconds, cpu_s: said["cpu_s"].as_f64(), peak_mb: said["peak_mb"].as_f64() })
}

/// Peak memory of this process \[MB\].
pub fn peak_mb() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let kilobytes = status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB"))?;
    Some(kilobytes.parse::<f64>().ok()? / 1e3)
}
