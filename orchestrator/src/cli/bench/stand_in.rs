//! Substitute for a study in measurements of the dispatch: samples without computation whose records have the form of a run's.

use super::super::error::CliError;
use crate::dispatch::{self, DispatchOptions, Observer, Parameters, Sink, SinkError, Snapshot};
use crate::run::RunError;
use bladeoff_record::{Entry, Record, RecordError};
use bladeoff_study::SampleKey;
use std::path::Path;
use std::time::{Duration, Instant};

/// A sample with four parameters.
pub(super) struct Numbers;

impl Parameters for Numbers {
    fn params(&self, sample: u64, out: &mut Vec<f64>) {
        out.extend([sample as f64, 0.25, -1.5, 3.0]);
    }
}

/// Sink that records every result durably.
pub(super) struct RecordSink(pub Record);

impl Sink for RecordSink {
    fn record(&mut self, sample: u64, entry: Entry) -> Result<(), SinkError> {
        self.0.put(sample, SampleKey(u128::from(sample)), &entry, Instant::now()).map_err(refused)
    }
    fn flush(&mut self) -> Result<(), SinkError> {
        self.0.commit().map_err(refused)
    }
}

fn refused(error: RecordError) -> SinkError {
    SinkError { what: "results cannot be recorded".to_owned(), source: Some(Box::new(error)) }
}

/// Observer that ignores everything.
pub(super) struct Nobody;

impl Observer for Nobody {
    fn progress(&mut self, _: &Snapshot) {}
}

/// Options with workers that keep a core busy for a given time with each sample.
pub(super) fn options(folder: &Path, workers: usize, busy: Duration) -> Result<DispatchOptions, CliError> {
    let command = dispatch::self_command().map_err(RunError::from)?;
    let mut options = DispatchOptions::new(workers, command, folder.to_path_buf(), "none".to_owned());
    options.noop = Some(u64::try_from(busy.as_micros()).unwrap_or(u64::MAX));
    Ok(options)
}
