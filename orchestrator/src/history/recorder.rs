//! Follower of a run that records a history.

use super::channels::{Channel, ContactForces, Context, catalogue, of_ring, select};
use super::csv::CsvSink;
use super::mcap_file::McapSink;
use super::staging::usual;
use super::table::ParquetSink;
use super::{Format, HISTORY_VERSION, HistoryError, Sink};
use bladeoff_answers::figures::CRITICAL_SPEEDS;
use bladeoff_answers::history::About;
use bladeoff_answers::tables::CsvStyle;
use bladeoff_core::engine::TimeStep;
use bladeoff_core::record::{Follower, Frame, columns};
use bladeoff_core::stress::ShaftStresses;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{DiaphragmKind, Machine, RotorKind};
use bladeoff_model::outcome::{ColumnKind, Outcome};
use bladeoff_text::document::units::format_digits;
use std::path::{Path, PathBuf};

/// Default interval between records \[s\].
const EVERY: f64 = 1e-4;
/// Largest number of records of a run at the default interval.
const RECORDS: f64 = 1e5;

/// Interval between recorded instants.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Decimation {
    /// Every 0.1 ms, or a hundred-thousandth of `run.end_time` if that is longer.
    #[default]
    Default,
    /// Interval \[s\], rounded to whole steps, at least one.
    Every(f64),
    /// Interval in steps.
    Steps(u64),
}

/// Settings of a recorder.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Path of the file; the extension determines the format.
    pub path: PathBuf,
    /// Channel patterns; empty for the default channels.
    pub channels: Vec<String>,
    /// Interval between records.
    pub decimation: Decimation,
    /// Separator and decimal sign of a CSV file.
    pub csv: CsvStyle,
}

impl Settings {
    /// Format of the file, and the selected channels.
    ///
    /// # Errors
    /// Errors of the request itself: [`HistoryError::Extension`], [`HistoryError::DecimalComma`], [`HistoryError::Channel`].
    pub(crate) fn channels(
        &self,
        machine: &Machine,
        structure: &Structure,
    ) -> Result<(Format, Vec<Channel>), HistoryError> {
        let format = Format::of(&self.path)?;
        if self.csv == CsvStyle::Comma && format != Format::Csv {
            return Err(HistoryError::DecimalComma { path: self.path.clone() });
        }
        Ok((format, select(catalogue(machine, structure), &self.channels)?))
    }
}

/// Summary of a written history.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// Path of the file.
    pub path: PathBuf,
    /// Number of channels.
    pub channels: usize,
    /// Number of recorded instants.
    pub records: u64,
    /// Interval between records \[s\].
    pub every: f64,
    /// Whether an existing file was replaced.
    pub replaced: bool,
}

/// Recorder of one run.
pub struct Recorder {
    path: PathBuf,
    channels: Vec<Channel>,
    shaft: Option<ShaftStresses>,
    /// Static displacements of the truncated modes, which contribute to the moments of the shaft.
    truncated: Option<Vec<f64>>,
    /// `None` after an error.
    sink: Option<Box<dyn Sink>>,
    failed: Option<HistoryError>,
    /// Path of the file until it is complete.
    temporary: Option<PathBuf>,
    every_steps: u64,
    step: f64,
    /// Contact forces of each diaphragm.
    forces: Vec<ContactForces>,
    values: Vec<f64>,
    records: u64,
}

impl Recorder {
    /// A recorder for a run that is about to start. [`Recorder::finish`] reports a file that cannot be opened.
    ///
    /// # Errors
    /// Errors in the settings: [`HistoryError::Extension`], [`HistoryError::DecimalComma`], [`HistoryError::Channel`].
    pub fn new(
        settings: &Settings,
        machine: &Machine,
        structure: &Structure,
        time_step: &TimeStep,
    ) -> Result<Self, HistoryError> {
        let (format, channels) = settings.channels(machine, structure)?;
        let every_steps = match settings.decimation {
            Decimation::Steps(steps) => steps.max(1),
            Decimation::Every(every) => steps_of(every, time_step.step),
            Decimation::Default => steps_of(EVERY.max(machine.run.end_time / RECORDS), time_step.step),
        };
        let about = about(machine, time_step, every_steps);
        let path = settings.path.clone();
        let opened: Result<Box<dyn Sink>, HistoryError> = match format {
            Format::Mcap => McapSink::create(&path, &channels, &about).map(|sink| Box::new(sink) as Box<dyn Sink>),
            Format::Csv => CsvSink::create(&path, &channels, settings.csv).map(|sink| Box::new(sink) as Box<dyn Sink>),
            Format::Parquet => Ok(Box::new(ParquetSink::new(&path, &channels, about))),
        };
        let (sink, failed) = match opened {
            Ok(sink) => (Some(sink), None),
            Err(error) => (None, Some(error)),
        };
        let temporary = sink.as_ref().and_then(|sink| sink.temporary()).map(Path::to_path_buf);
        let shaft = match &machine.rotor.kind {
            RotorKind::Shaft(shaft) => Some(ShaftStresses::new(shaft)),
            RotorKind::PointMass(_) => None,
        };
        Ok(Self {
            path,
            values: Vec::with_capacity(channels.len()),
            channels,
            shaft,
            truncated: structure.truncated_seats(&machine.rotor),
            sink,
            failed,
            temporary,
            every_steps,
            step: time_step.step,
            forces: machine.diaphragms.iter().map(|_| ContactForces::new(time_step.step)).collect(),
            records: 0,
        })
    }

    /// Path of the file until it is complete; an incomplete file stays there.
    #[must_use]
    pub fn temporary(&self) -> Option<&Path> {
        self.temporary.as_deref()
    }

    /// Path of an existing file that occupies the usual temporary name and is left unchanged.
    #[must_use]
    pub fn in_its_way(&self) -> Option<PathBuf> {
        let usual = usual(&self.path);
        self.temporary.as_ref().is_some_and(|temporary| *temporary != usual).then_some(usual)
    }

    /// Completes the file.
    ///
    /// # Errors
    /// The first error, at the start, during the run or now. It does not affect the outcome of the run.
    pub fn finish(mut self, machine: &Machine, outcome: &Outcome) -> Result<Written, HistoryError> {
        if let Some(error) = self.failed.take() {
            return Err(error);
        }
        let replaced = self.path.symlink_metadata().is_ok();
        if let Some(sink) = self.sink.take() {
            sink.finish(&outcome_of(machine, outcome))?;
        }
        Ok(Written {
            path: self.path,
            channels: self.channels.len(),
            records: self.records,
            every: self.every_steps as f64 * self.step,
            replaced,
        })
    }
}

impl Follower for Recorder {
    fn contact_force(&mut self, diaphragm: usize, _time: f64, force: f64) {
        self.forces[diaphragm].see(force);
    }

    fn wants(&mut self, step: u64, _time: f64) -> bool {
        self.sink.is_some() && step.is_multiple_of(self.every_steps)
    }

    fn wants_end(&mut self) -> bool {
        self.sink.is_some()
    }

    fn see(&mut self, frame: &Frame<'_>) {
        let Some(sink) = &mut self.sink else { return };
        self.forces.iter_mut().for_each(ContactForces::filter);
        let whole = self.truncated.as_ref().map(|truncated| {
            frame.displacement.iter().zip(truncated).map(|(x, truncated)| x + truncated).collect::<Vec<f64>>()
        });
        let bent = whole.as_deref().unwrap_or(frame.displacement);
        let context = Context { forces: &self.forces, shaft: self.shaft.as_ref(), bent };
        self.values.clear();
        self.values.extend(self.channels.iter().map(|channel| channel.value(frame, &context)));
        self.forces.iter_mut().for_each(ContactForces::recorded);
        self.records += 1;
        if let Err(error) = sink.record(frame.time, &self.values) {
            self.failed = Some(error);
            self.sink = None;
        }
    }
}

fn steps_of(every: f64, step: f64) -> u64 {
    ((every / step).round() as u64).max(1)
}

/// Metadata of the run for the reader of the history.
fn about(machine: &Machine, time_step: &TimeStep, every_steps: u64) -> About {
    let mut about = About::new();
    let mut put = |key: &str, value: String| about.insert(key.to_owned(), value);
    put("history_version", HISTORY_VERSION.to_string());
    put("program", format!("bladeoff {}", env!("CARGO_PKG_VERSION")));
    put("numerics_version", bladeoff_core::NUMERICS_VERSION.to_string());
    put("exponential_revision", bladeoff_core::engine::exponential::EXPONENTIAL_REVISION.to_string());
    put("machine", machine.name.clone());
    put("engine", machine.run.engine.word().to_owned());
    put("step_s", number(time_step.step));
    put("every_s", number(time_step.step * every_steps as f64));
    if let Some(detection) = crate::engine::detection(machine) {
        put("detection", detection.to_owned());
    }
    if let Some(speeds) = critical_speeds(machine) {
        put(CRITICAL_SPEEDS, speeds);
    }
    for diaphragm in &machine.diaphragms {
        let contact = &diaphragm.contact;
        let mut put = |group: &str, key: &str, value: String| {
            put(&format!("{}.{key}", of_ring(group, machine, diaphragm)), value);
        };
        put("contact", "rotor_radius_m", number(contact.rotor_radius));
        put("contact", "gap_m", number(contact.gap));
        if let DiaphragmKind::Flexible(stator) = &diaphragm.kind {
            put("ring", "nodes", stator.ring.elements.to_string());
            put("ring", "mean_radius_m", number(stator.ring.mean_radius));
            put("ring", "thickness_m", number(stator.ring.thickness));
            let blades = stator.blades.map_or(0, |blades| blades.count);
            put("ring", "blades", blades.to_string());
        }
    }
    about
}

/// Critical speeds that unbalance excites, to five digits, for marks in pictures; `None` without any, or if the modes cannot be
/// computed.
fn critical_speeds(machine: &Machine) -> Option<String> {
    let report = crate::engine::modes(machine, &[]).ok()?;
    let excited = report.critical_speeds.iter().filter(|critical| critical.is_excited_by_unbalance());
    let speeds: Vec<String> = excited.map(|critical| format_digits(critical.speed, "", 5)).collect();
    (!speeds.is_empty()).then(|| speeds.join(" "))
}

fn outcome_of(machine: &Machine, outcome: &Outcome) -> About {
    let mut about = About::new();
    about.insert("status".to_owned(), outcome.status.word().to_owned());
    about.insert("end_cause".to_owned(), outcome.end_cause.word().to_owned());
    if let Some(causes) = outcome.causes.words() {
        about.insert("causes".to_owned(), causes);
    }
    for (column, value) in columns(machine).iter().zip(&outcome.values) {
        if let Some(value) = *value {
            let text = match column.kind {
                ColumnKind::Choice(words) => words.get(value as usize).copied().unwrap_or_default().to_owned(),
                ColumnKind::Real | ColumnKind::Count => number(value),
            };
            about.insert(column.name.clone(), text);
        }
    }
    about
}

/// Shortest decimal that parses to the same bits.
fn number(value: f64) -> String {
    format!("{value:?}")
}
