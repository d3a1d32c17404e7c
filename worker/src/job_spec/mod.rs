//! The frozen work plan: everything a worker needs beside sample numbers and parameter values.
//!
//! The orchestrator writes it into the result directory before the first worker starts; every worker checks its hash, which
//! it was given on its command line, and with it that of the basis file. So all samples of a result directory come from
//! one plan, whatever happens to the files a study was read from.
//!
//! There are two kinds, each a format with a version of its own: of a machine, and of formulas.

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

/// What all samples of a study share.
#[derive(Debug, Clone, PartialEq)]
pub enum JobSpec {
    /// Transients of a machine.
    Machine(MachineJob),
    /// Formulas.
    Function(FunctionJob),
}

/// Why a plan could not be written, or read as the one expected.
#[derive(Debug, thiserror::Error)]
pub enum JobSpecError {
    /// A file operation failed.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is not the one the run was started with.
    #[error("{} has changed: blake3 {found}, expected {expected}", shown(path))]
    Changed {
        /// The file.
        path: PathBuf,
        /// Its hash.
        found: String,
        /// The hash it should have.
        expected: String,
    },
    /// The file is not a plan of a version that is read.
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
        /// Where reading failed; `None` if it is another format or version.
        #[source]
        source: Option<serde_json::Error>,
    },
    /// A number in the plan cannot be read.
    #[error("{}: {text:?} is not a number", shown(path))]
    Number {
        /// The file.
        path: PathBuf,
        /// What stands there.
        text: String,
    },
}

/// What every plan begins with.
#[derive(Deserialize)]
struct Head {
    format: String,
    version: u32,
}

fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

impl JobSpec {
    /// The hash [`write`](JobSpec::write) would return: the same for the same plan.
    #[must_use]
    pub fn hash(&self) -> String {
        hash(self.text().as_bytes())
    }

    /// What [`write`](JobSpec::write) puts into the file.
    #[must_use]
    pub fn text(&self) -> String {
        match self {
            JobSpec::Machine(job) => job.text(),
            JobSpec::Function(job) => job.text(),
        }
    }

    /// The reduced basis that goes with it; `None` if no sample needs one.
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
    /// A file that is not there, has changed, or is of another version.
    pub fn read(dir: &Path, expected: &str) -> Result<Self, JobSpecError> {
        Self::read_in(&Folder::open(dir).map_err(FileError::at("open", dir))?, expected)
    }

    /// The same in an open directory.
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
