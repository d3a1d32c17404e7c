//! The samples of a study after `--scale` and `--limit`: each computed from its number when asked for.

use super::axis::{Axis, Column, ColumnKind, Varied, show};
use super::carried::Carried;
use super::definition::Study;
use super::error::StudyError;
use crate::design::{Design, DesignError, Thinned};
use bladeoff_model::document::Collector;
use bladeoff_model::machine::{MachineDef, ParamValue};

/// A study and the part of it that is to be computed.
#[derive(Debug, Clone)]
pub struct Samples {
    study: Study,
    design: Design,
    scale: Option<f64>,
    limit: Option<u64>,
}

impl Samples {
    /// All samples of the study, thinned by `scale`, of which `limit` are taken.
    ///
    /// # Errors
    /// Too many samples, or a scale outside (0, 1].
    pub fn new(study: Study, scale: Option<f64>, limit: Option<u64>) -> Result<Self, StudyError> {
        let lengths: Vec<u64> = study.axes.iter().map(|axis| axis.length).collect();
        let design = Design::new(&lengths, study.seed, scale, limit).map_err(|error| match error {
            DesignError::TooMany { count, limit } => too_many(&study, scale, count, limit),
            error @ DesignError::Scale { .. } => error.into(),
        })?;
        Ok(Self { study, design, scale, limit })
    }

    /// The study.
    #[must_use]
    pub fn study(&self) -> &Study {
        &self.study
    }

    /// Number of samples.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.design.count()
    }

    /// Points left of each axis.
    #[must_use]
    pub fn kept(&self) -> Vec<u64> {
        self.design.kept()
    }

    /// `--scale` as given.
    #[must_use]
    pub fn scale(&self) -> Option<f64> {
        self.scale
    }

    /// `--limit` as given.
    #[must_use]
    pub fn limit(&self) -> Option<u64> {
        self.limit
    }

    /// The varied parameters, in the order of the values of a sample.
    pub fn parameters(&self) -> impl Iterator<Item = &Varied> {
        self.study.axes.iter().flat_map(|axis| &axis.varied)
    }

    /// Position of a sample on each axis, in the numbering of the study file.
    #[must_use]
    pub fn positions(&self, sample: u64) -> Vec<u64> {
        self.design.positions(sample)
    }

    /// One value per varied parameter.
    #[must_use]
    pub fn values(&self, sample: u64) -> Vec<ParamValue> {
        let positions = self.design.positions(sample);
        self.values_at(&positions).collect()
    }

    fn values_at(&self, positions: &[u64]) -> impl Iterator<Item = ParamValue> {
        let axes = self.study.axes.iter().zip(positions);
        axes.flat_map(|(axis, &position)| axis.varied.iter().map(move |varied| varied.values.at(position)))
    }

    /// The numbers that say to a worker what varies in a sample, added to `out`: a word is its place among the words.
    pub fn params(&self, sample: u64, out: &mut Vec<f64>) {
        let pairs = self.parameters().zip(self.values(sample));
        out.extend(pairs.map(|(varied, value)| match value {
            ParamValue::Number(number) => number,
            ParamValue::Choice(word) => {
                let words = varied.words().expect("a parameter with a word as value has words");
                let index = words.iter().position(|known| *known == word).expect("checked when the study was read");
                index as f64
            }
        }));
        out.extend(self.twin(sample));
    }

    /// The machine definition of a sample.
    #[must_use]
    pub fn machine(&self, sample: u64) -> MachineDef {
        let mut machine = self.machine_at(&self.design.positions(sample));
        if let (Some(twin), Some(shift)) = (&self.study.twin, self.twin(sample)) {
            machine.set(&twin.info, &ParamValue::Number(shift)).expect("a shift the machine has, or none");
        }
        machine
    }

    /// `run.twin` of a sample of a study with `twin_share`: by its number in the whole study.
    #[must_use]
    pub fn twin(&self, sample: u64) -> Option<f64> {
        let twin = self.study.twin.as_ref()?;
        let positions = self.design.positions(sample);
        let places = self.study.axes.iter().zip(positions);
        let number = places.fold(0u64, |number, (axis, place)| number.wrapping_mul(axis.length).wrapping_add(place));
        Some(twin.shift_of(number))
    }

    /// The same at any positions on the axes.
    pub(super) fn machine_at(&self, positions: &[u64]) -> MachineDef {
        let mut machine = self.study.machine.clone();
        for (varied, value) in self.parameters().zip(self.values_at(positions)) {
            machine.set(&varied.info, &value).expect("type and range were checked when the study was read");
        }
        machine
    }

    /// What varies in a sample, as a person reads it: "diaphragms.seal.contact.gap = 0.4 mm, ...".
    #[must_use]
    pub fn describe(&self, sample: u64) -> String {
        self.describe_at(&self.design.positions(sample))
    }

    /// The same at any positions on the axes.
    pub(super) fn describe_at(&self, positions: &[u64]) -> String {
        let pairs = self.parameters().zip(self.values_at(positions));
        let shown = pairs.map(|(varied, value)| format!("{} = {}", varied.info.path, show(&varied.info, &value)));
        let shown = shown.collect::<Vec<_>>().join(", ");
        if shown.is_empty() { "nothing varied".to_owned() } else { shown }
    }

    /// The columns of the varied parameters, then those that are carried along; the detection is not among them: it has a column
    /// of its own.
    #[must_use]
    pub fn columns(&self) -> Vec<Column> {
        let twin = self.study.twin.iter().map(|twin| Column {
            name: twin.info.column(),
            unit: String::new(),
            meaning: twin.info.meaning.to_owned(),
            kind: ColumnKind::Real,
        });
        let varied = self.parameters().filter(|varied| !varied.is_detection()).map(Varied::column);
        varied.chain(twin).chain(self.study.carried.iter().map(Carried::column)).collect()
    }

    /// The cells of these columns for a sample; `None` is empty.
    #[must_use]
    pub fn cells(&self, sample: u64) -> Vec<Option<ParamValue>> {
        let pairs = self.parameters().zip(self.values(sample));
        let varied = pairs.filter(|(varied, _)| !varied.is_detection()).map(|(_, value)| Some(value));
        let twin = self.twin(sample).map(|shift| Some(ParamValue::Number(shift)));
        varied.chain(twin).chain(self.carried(sample).map(|(_, value)| value)).collect()
    }

    /// What is carried along with a sample: names of columns, and cells.
    pub fn carried(&self, sample: u64) -> impl Iterator<Item = (&str, Option<ParamValue>)> {
        // The points are the first axis.
        let position = if self.study.carried.is_empty() { 0 } else { self.design.positions(sample)[0] };
        self.study.carried.iter().map(move |carried| (carried.name.as_str(), carried.at(position)))
    }

    /// The detection of a sample where it varies.
    #[must_use]
    pub fn detection(&self, sample: u64) -> Option<String> {
        self.parameters().zip(self.values(sample)).find_map(|(varied, value)| match value {
            ParamValue::Choice(word) if varied.is_detection() => Some(word),
            _ => None,
        })
    }
}

/// The refusal at the longest axis, with the length and the line of each.
fn too_many(study: &Study, scale: Option<f64>, count: u128, most: u64) -> StudyError {
    let line = |axis: &Axis| 1 + study.text[..axis.varied[0].place.start].matches('\n').count();
    let kept = |axis: &Axis| Thinned::new(axis.length, scale.unwrap_or(1.0)).kept();
    let factors = study.axes.iter().map(|axis| format!("{} of {} (line {})", kept(axis), axis.name, line(axis)));
    let factors = factors.collect::<Vec<_>>().join(" x ");
    let longest = study.axes.iter().rev().max_by_key(|axis| axis.length).expect("no axis is one sample");
    let mut problems = Collector::new(&study.file, &study.text);
    let message = format!("the study has {count} samples: {factors}");
    problems.add(longest.varied[0].place.clone(), &*longest.name, message).allowed =
        Some(format!("at most {most} samples: fewer values, or --scale"));
    StudyError::Problems(vec![problems.into_problems()])
}
