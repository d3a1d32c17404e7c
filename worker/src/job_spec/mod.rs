//! Frozen plan of a study: all that a worker needs besides sample numbers and parameter values.
//!
//! The orchestrator writes it into the result directory before the first worker starts. Every worker checks its hash against its
//! command line, and with it the hash of the basis. So all samples of a result directory come from one plan, even if the study's
//! files change.
//!
//! Two kinds of plans, each a format with its own version: of a machine, and of formulas.

mod function;
mod machine;

pub use function::{Formula, FunctionJob, Variable};
pub use machine::{MachineJob, Varied, planned_basis, planned_engine};

use std::path::{Path, PathBuf};

use bladeoff_system::files::{FileError, write_whole};
use bladeoff_system::folder::Folder;
use bladeoff_system::place::Place;
use bladeoff_system::shown;
use serde::Deserialize;

/// Name of the plan in a result directory.
pub const PLAN_FILE: &str = "plan.json";
/// Name of the frozen basis in a result directory.
pub const BASIS_FILE: &str = "basis.bin";
/// Largest plan that is read.
const MOST_PLAN: u64 = 64 << 20;
/// Largest basis that is read.
pub const MOST_BASIS: u64 = 256 << 20;

/// Data shared by all samples of a study.
#[derive(Debug, Clone, PartialEq)]
pub enum JobSpec {
    /// Transients of a machine.
    Machine(MachineJob),
    /// Formulas.
    Function(FunctionJob),
}

/// Error of writing or reading a plan.
#[derive(Debug, thiserror::Error)]
pub enum JobSpecError {
    /// A file operation failed.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is not that of the run.
    #[error("{} has changed: blake3 {found}, expected {expected}", shown(path))]
    Changed {
        /// The file.
        path: PathBuf,
        /// Hash found.
        found: String,
        /// Expected hash.
        expected: String,
    },
    /// The file is not a plan of a known version.
    #[error(
        "{} is not a {} of version {}, nor a {} of version {}",
        shown(path),
        machine::FORMAT,
        machine::VERSION,
        function::FORMAT,
        function::VERSION
    )]
    NotAPlan {
        /// The file.
        path: PathBuf,
        /// Place of the error; `None`: another format or version.
        #[source]
        source: Option<serde_json::Error>,
    },
    /// A number in the plan cannot be read.
    #[error("{}: {text:?} is not a number", shown(path))]
    Number {
        /// The file.
        path: PathBuf,
        /// Text found.
        text: String,
    },
}

/// Beginning of every plan.
#[derive(Deserialize)]
struct Head {
    format: String,
    version: u32,
}

fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

impl JobSpec {
    /// Hash that [`write`](JobSpec::write) returns: the same for the same plan.
    #[must_use]
    pub fn hash(&self) -> String {
        hash(self.text().as_bytes())
    }

    /// Contents of the file of [`write`](JobSpec::write).
    #[must_use]
    pub fn text(&self) -> String {
        match self {
            JobSpec::Machine(job) => job.text(),
            JobSpec::Function(job) => job.text(),
        }
    }

    /// Reduced basis of the plan; `None`: no sample needs one.
    #[must_use]
    pub fn basis(&self) -> Option<&[u8]> {
        match self {
            JobSpec::Machine(job) => job.basis.as_deref(),
            JobSpec::Function(_) => None,
        }
    }

    /// Writes plan and basis into a result directory, durably, and returns the plan's hash.
    ///
    /// # Errors
    /// A file that could not be written.
    pub fn write(&self, dir: &Folder) -> Result<String, JobSpecError> {
        if let Some(basis) = self.basis() {
            write_whole(dir.place(BASIS_FILE), basis)?;
        }
        let text = self.text();
        write_whole(dir.place(PLAN_FILE), text.as_bytes())?;
        Ok(hash(text.as_bytes()))
    }

    /// Reads the plan of a result directory, which must be the one with this hash.
    ///
    /// # Errors
    /// The file is missing, has changed, or is of another version.
    pub fn read(dir: &Path, expected: &str) -> Result<Self, JobSpecError> {
        Self::read_in(&Folder::open(dir).map_err(FileError::at("open", dir))?, expected)
    }

    /// Reads the plan of an open directory, as [`JobSpec::read`].
    ///
    /// # Errors
    /// As [`JobSpec::read`].
    pub fn read_in(dir: &Folder, expected: &str) -> Result<Self, JobSpecError> {
        let place = dir.place(PLAN_FILE);
        let path = place.to_path_buf();
        let bytes = read_file(&place, MOST_PLAN, expected)?;
        let refused = |source| JobSpecError::NotAPlan { path: path.clone(), source: Some(source) };
        let head: Head = serde_json::from_slice(&bytes).map_err(refused)?;
        match (head.format.as_str(), head.version) {
            (machine::FORMAT, machine::VERSION) => MachineJob::from_bytes(&bytes, dir, &path).map(Self::Machine),
            (function::FORMAT, function::VERSION) => {
                FunctionJob::from_bytes(&bytes).map(Self::Function).map_err(refused)
            }
            _ => Err(JobSpecError::NotAPlan { path, source: None }),
        }
    }
}

fn read_file(path: &Place, limit: u64, expected: &str) -> Result<Vec<u8>, JobSpecError> {
    let bytes = path.read(limit)?;
    let found = hash(&bytes);
    if found != expected {
        return Err(JobSpecError::Changed { path: path.to_path_buf(), found, expected: expected.to_owned() });
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn machine() -> JobSpec {
        JobSpec::Machine(machine::example())
    }

    fn function() -> JobSpec {
        JobSpec::Function(function::example())
    }

    #[test]
    fn a_plan_reads_back_exactly_and_its_hash_is_its_own() {
        for job in [machine(), function()] {
            let dir = tempfile::tempdir().expect("temporary directory");
            let hash = job.write(&Folder::open(dir.path()).expect("opened")).expect("written");
            assert_eq!(hash, job.hash());
            assert_eq!(JobSpec::read(dir.path(), &hash).expect("read"), job);
        }
        let other = MachineJob { basis: Some(vec![1, 2, 4]), ..machine::example() };
        assert_ne!(JobSpec::Machine(other).hash(), machine().hash());
    }

    #[test]
    fn a_changed_plan_or_basis_is_refused() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let hash = machine().write(&Folder::open(dir.path()).expect("opened")).expect("written");
        fs::write(dir.path().join(BASIS_FILE), [9]).expect("written");
        let error = JobSpec::read(dir.path(), &hash).expect_err("basis changed");
        assert!(matches!(&error, JobSpecError::Changed { path, .. } if path.ends_with(BASIS_FILE)), "{error}");
        let error = JobSpec::read(dir.path(), "00").expect_err("another plan");
        assert!(matches!(&error, JobSpecError::Changed { path, .. } if path.ends_with(PLAN_FILE)), "{error}");
        let error = JobSpec::read(&dir.path().join("nowhere"), "00").expect_err("not there");
        assert!(matches!(error, JobSpecError::File(_)), "{error}");
    }

    #[test]
    fn a_plan_of_another_version_or_with_other_keys_is_refused() {
        for job in [machine(), function()] {
            let text = job.text();
            let others = [
                text.replace("\"version\": 1", "\"version\": 2"),
                text.replace("plan\",", "plan of later times\","),
                text.replace("\"version\": 1", "\"version\": 1, \"new\": 1"),
            ];
            for other in others {
                assert_ne!(other, text);
                let dir = tempfile::tempdir().expect("temporary directory");
                fs::write(dir.path().join(PLAN_FILE), &other).expect("written");
                let error = JobSpec::read(dir.path(), &hash(other.as_bytes())).expect_err("not known");
                assert!(matches!(error, JobSpecError::NotAPlan { .. }), "{error}");
            }
        }
    }
}
