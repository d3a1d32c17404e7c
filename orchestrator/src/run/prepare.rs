//! Data shared by all samples: frozen basis, plan of the workers, provenance of the table.

use super::columns::{function_schema, table_schema};
use super::directory::{LEDGER, RunDirectory};
use super::error::RunError;
use super::provenance::provenance;
use super::work::job_spec;
use crate::engine;
use crate::terminal::{matrices_of, with_word};
use crate::version::VERSIONS;
use bladeoff_answers::tables::TableSchema;
use bladeoff_core::modal::Basis;
use bladeoff_model::machine::Machine;
use bladeoff_record::Reader;
use bladeoff_study::{SampleKeys, Samples};
use bladeoff_system::folder::Folder;
use bladeoff_text::document::Problems;
use bladeoff_worker::job_spec::{BASIS_FILE, JobSpec, MOST_BASIS, planned_basis};

/// Study ready for computation.
#[derive(Debug)]
pub(super) struct Prepared<'a> {
    pub samples: &'a Samples,
    /// Columns of the table.
    pub schema: TableSchema,
    /// Contact detection, if it is the same in all samples.
    pub detection: Option<String>,
    /// Engine, if it is the same in all samples.
    pub engine: Option<String>,
    pub job: JobSpec,
    pub plan_hash: String,
    pub provenance: Vec<(String, String)>,
    pub keys: SampleKeys<'a>,
    /// Hash of all sample keys in order.
    pub digest: String,
    /// Place of the number of steps among the values of an outcome; `None`: the study has no steps.
    pub steps: Option<usize>,
}

/// Machines whose basis may be frozen, in order of preference: that of the study without varied parameters, because it stays the
/// same when the study grows; then that of the first sample, if the former is invalid or has no modes.
fn basis_machines(samples: &Samples) -> impl Iterator<Item = Result<Machine, Problems>> {
    let without = samples.study().machine().and_then(|machine| machine.def.build().ok()).map(Ok);
    without.into_iter().chain(std::iter::once_with(|| samples.machine(0).build()))
}

/// Basis of a study as bytes; `None`: a study of formulas.
pub(super) type BasisBytes = Option<Vec<u8>>;

/// Computes the basis of a study without a directory.
pub(super) fn new_basis(samples: &Samples) -> Result<BasisBytes, RunError> {
    if samples.study().function().is_some() {
        return Ok(None);
    }
    basis(samples, None).map(Some)
}

/// Accepts a basis that another process has frozen for this study, if it fits.
pub(super) fn basis_of_others(samples: &Samples, bytes: Vec<u8>) -> Result<BasisBytes, RunError> {
    basis(samples, Some(bytes)).map(Some)
}

/// Reads the frozen basis of the directory if it fits this study; computes a new one otherwise. Another version may compute other
/// last digits, so a frozen basis is never computed again unless it is damaged: record and plan both contain its hash.
pub(super) fn frozen_basis(samples: &Samples, directory: &Folder, note: &dyn Fn(&str)) -> Result<BasisBytes, RunError> {
    if samples.study().function().is_some() {
        return Ok(None);
    }
    let frozen = directory.place(BASIS_FILE).read(MOST_BASIS).ok();
    let recorded = Reader::peek(directory.place(LEDGER)).ok().and_then(|record| record.header().ok());
    let recorded = recorded.and_then(|mut header| header.remove("basis_blake3"));
    let known: Vec<String> = planned_basis(directory).into_iter().chain(recorded).collect();
    match frozen {
        Some(bytes) if !known.is_empty() && !known.contains(&hash(&bytes)) => {
            let again = "it is damaged (its BLAKE3 differs from that in job and record) and is computed again. If its \
                         last digits then differ, because the version of the program differs, restore the file from a \
                         copy";
            note(&format!("{BASIS_FILE}: {again}"));
            basis(samples, None)
        }
        frozen => basis(samples, frozen),
    }
    .map(Some)
}

fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// Returns the frozen bytes if they are a basis of this study, a computed basis otherwise.
fn basis(samples: &Samples, frozen: Option<Vec<u8>>) -> Result<Vec<u8>, RunError> {
    let read = frozen.as_deref().and_then(|bytes| Basis::from_bytes(bytes).ok());
    let mut last = None;
    for machine in basis_machines(samples) {
        let machine = machine?;
        if let (Some(bytes), Some(basis)) = (&frozen, &read)
            && with_word(|| matrices_of(&machine), || engine::build_with(&machine, basis)).is_ok()
        {
            return Ok(bytes.clone());
        }
        match with_word(|| matrices_of(&machine), || engine::build(&machine)) {
            Ok(structure) => return Ok(structure.basis().to_bytes()),
            Err(error) => last = Some(error),
        }
    }
    Err(last.expect("the first sample was tried").into())
}

impl<'a> Prepared<'a> {
    pub(super) fn new(samples: &'a Samples, basis: BasisBytes) -> Result<Self, RunError> {
        Self::with_digest(samples, basis, None)
    }

    /// Prepares a study; `digest`: hash of all sample keys, if it is known for these inputs. Computing it takes a key of every
    /// sample.
    pub(super) fn with_digest(
        samples: &'a Samples,
        basis: BasisBytes,
        digest: Option<String>,
    ) -> Result<Self, RunError> {
        let (schema, detection, steps) = match samples.study().function() {
            Some(model) => (function_schema(samples, model), None, None),
            None => {
                let machine = samples.machine(0).build()?;
                let detection = engine::detection(&machine).map(str::to_owned);
                (table_schema(samples, &machine), detection, Some(engine::place_of_steps(&machine)))
            }
        };
        let engine = samples.study().engine().map(|choice| choice.engine.word().to_owned());
        let mut keys = SampleKeys::new(samples, VERSIONS, basis.as_deref().unwrap_or_default());
        let job = job_spec(samples, basis);
        let plan_hash = job.hash();
        let provenance = provenance(samples, &plan_hash, job.basis());
        let digest = digest.unwrap_or_else(|| keys.digest());
        Ok(Self { samples, schema, detection, engine, job, plan_hash, provenance, keys, digest, steps })
    }

    /// Writes inputs, plan and basis into the directory.
    pub(super) fn write(&self, directory: &RunDirectory) -> Result<(), RunError> {
        directory.write_inputs(self.samples.study())?;
        if JobSpec::read_in(directory.open(), &self.plan_hash).is_err() {
            self.job.write(directory.open())?;
        }
        Ok(())
    }

    /// Header of the record: all that its entries depend on.
    pub(super) fn header(&self) -> Vec<(String, String)> {
        let mut header = self.provenance.clone();
        header.push((SAMPLES_KEY.to_owned(), self.digest.clone()));
        header
    }
}

/// Header key of the hash of all sample keys.
pub(super) const SAMPLES_KEY: &str = "samples_blake3";
