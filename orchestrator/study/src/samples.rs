//! The samples of a study after `--scale` and `--limit`: each is computed from its number when needed.
//!
//! ```text
//! without [design]   sample = a combination of the positions on the axes           --limit: the first of a shuffle
//! with [design]      sample = point x groups + group; a group is a combination     --limit: the first points, in every group
//! ```

use super::axis::{Axis, show};
use super::column::{Column, ColumnKind};
use super::definition::Study;
use super::error::StudyError;
use super::extra_columns::ExtraColumn;
use super::parameter::{Origin, Parameter};
use super::sample_values::{SampleValues, Scratch};
use super::sampling::layout::SamplingLayout;
use super::uncertain::Uncertain;
use super::value_table::{TABLE_BYTES, ValueTable};
use crate::sampling::combinations::{CombinationError, Combinations, Thinned};
use bladeoff_model::machine::{ENGINE, EngineChoice, MachineDef, ParamValue, ValueError};
use bladeoff_text::document::Collector;

/// Largest number of samples whose values are all examined; in a larger study, this many are.
const MOST_ASKED: u64 = 100_000;

/// Greatest common divisor, by Euclid's algorithm.
fn common_factor(mut a: u64, mut b: u64) -> u64 {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// A study and the part of it that is to be computed.
#[derive(Debug, Clone)]
pub struct Samples {
    study: Study,
    combinations: Combinations,
    /// Values of the study's samples, with fewer points after `--scale`.
    values: SampleValues,
    table: ValueTable,
    scale: Option<f64>,
    limit: Option<u64>,
}

impl Samples {
    /// All samples of the study, thinned by `scale`; `limit` is the number of samples, in a design that of points.
    ///
    /// # Errors
    /// Too many samples, a scale outside (0, 1], or a limit of 0.
    pub fn new(study: Study, scale: Option<f64>, limit: Option<u64>) -> Result<Self, StudyError> {
        let lengths: Vec<u64> = study.axes.iter().map(|axis| axis.length).collect();
        // a scale out of range is rejected below
        let factor = scale.filter(|factor| *factor > 0.0 && *factor < 1.0);
        let values =
            factor.map_or_else(|| study.sampled.values.clone(), |factor| study.sampled.values.clone().scaled(factor));
        let combinations = match values.layout() {
            None => Combinations::new(&lengths, study.seed, scale, limit),
            Some(_) if limit == Some(0) => Err(CombinationError::Nothing),
            Some(layout) => {
                let points = limit.map_or(layout.count(), |limit| layout.limited(limit));
                Combinations::of_points(points, &lengths, scale)
            }
        };
        let combinations = combinations.map_err(|error| match error {
            CombinationError::TooMany { count, limit } => too_many(&study, scale, count, limit),
            error @ (CombinationError::Scale { .. } | CombinationError::Nothing) => error.into(),
        })?;
        let own = study.parameters().iter().filter(|parameter| parameter.is_own()).count();
        Ok(Self { study, combinations, values, table: ValueTable::empty(own), scale, limit })
    }

    /// Draws the values of the first samples on all cores, as many as fit in [`TABLE_BYTES`], and stores them; those of other samples are drawn
    /// whenever they are needed.
    ///
    /// # Errors
    /// The threads cannot be started.
    pub fn draw(&mut self) -> Result<(), StudyError> {
        self.draw_into(TABLE_BYTES)
    }

    /// Number of drawn samples.
    #[cfg(test)]
    pub(crate) fn drawn(&self) -> u64 {
        self.values.drawn.load(std::sync::atomic::Ordering::Relaxed)
    }

    pub(super) fn draw_into(&mut self, bytes: usize) -> Result<(), StudyError> {
        let width = self.parameters().iter().filter(|parameter| parameter.is_own()).count();
        let scratch = || (Scratch::default(), Vec::new());
        let fill = |sample: u64, (scratch, own): &mut (Scratch, Vec<f64>), row: &mut [f64]| {
            let positions = self.combinations.positions(sample);
            self.own_at(self.point_at(&positions), &positions[self.before()..], scratch, own);
            row.copy_from_slice(own);
        };
        self.table = ValueTable::draw(width, self.count(), bytes, scratch, fill)?;
        Ok(())
    }

    /// The study.
    #[must_use]
    pub fn study(&self) -> &Study {
        &self.study
    }

    /// Changes the engine of all samples if `run.engine = "auto"` selected the present one; a named engine stays.
    pub fn settle(&mut self, choice: EngineChoice) {
        self.study.settle(choice);
    }

    /// Number of samples.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.combinations.count()
    }

    /// Number of kept points of each axis.
    #[must_use]
    pub fn kept(&self) -> Vec<u64> {
        self.combinations.kept()[self.before()..].to_vec()
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

    /// Layout of the points; `None` without a `[design]`.
    #[must_use]
    pub fn layout(&self) -> Option<&SamplingLayout> {
        self.values.layout()
    }

    /// Number of points of the design; 0 without a `[design]`.
    #[must_use]
    pub fn points(&self) -> u64 {
        if self.layout().is_some() { self.combinations.kept()[0] } else { 0 }
    }

    /// The point of a sample in a `[design]`.
    #[must_use]
    pub fn point(&self, sample: u64) -> Option<u64> {
        self.layout().map(|_| self.combinations.positions(sample)[0])
    }

    /// The combinations of values of `[[vary]]`, in the order of the samples of a point: path or name, and value. One empty combination if nothing
    /// varies; none without a `[design]`.
    #[must_use]
    pub fn groups(&self) -> Vec<Vec<(String, ParamValue)>> {
        let Some(groups) = self.count().checked_div(self.points()) else { return Vec::new() };
        let varied = |group: u64| {
            let positions = self.positions(group);
            let pairs = self.study.axes.iter().zip(positions);
            let along = |(axis, position): (&Axis, u64)| {
                let pair = |varied: &super::Varied| (varied.info.path.clone(), varied.values.at(position));
                axis.varied.iter().map(pair).collect::<Vec<_>>()
            };
            pairs.flat_map(along).collect()
        };
        (0..groups).map(varied).collect()
    }

    /// All parameters that differ between samples, in the order of a sample's values.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        self.study.parameters()
    }

    /// Number of axes before those of the study: the axis of points in a design.
    fn before(&self) -> usize {
        usize::from(self.layout().is_some())
    }

    /// Position of a sample on each axis, in the numbering of the study file.
    #[must_use]
    pub fn positions(&self, sample: u64) -> Vec<u64> {
        let mut positions = self.combinations.positions(sample);
        positions.drain(..self.before());
        positions
    }

    /// One value per parameter; a derived value that is not finite is NaN (rejected by [`super::check_machines`] if a machine takes it).
    #[must_use]
    pub fn values(&self, sample: u64) -> Vec<ParamValue> {
        let positions = self.combinations.positions(sample);
        let along = &positions[self.before()..];
        match self.table.row(sample) {
            Some(own) => self.put_together(along, own),
            None => self.values_at(self.point_at(&positions), along),
        }
    }

    /// Values at any point and any positions on the axes.
    pub(super) fn values_at(&self, point: u64, positions: &[u64]) -> Vec<ParamValue> {
        let mut own = Vec::new();
        self.own_at(point, positions, &mut Scratch::default(), &mut own);
        self.put_together(positions, &own)
    }

    /// The point, the first of the positions; 0 without a `[design]`.
    fn point_at(&self, positions: &[u64]) -> u64 {
        self.layout().map_or(0, |_| positions[0])
    }

    /// Writes the uncertain and derived values to `own`; values that are not finite become NaN.
    fn own_at(&self, point: u64, positions: &[u64], scratch: &mut Scratch, own: &mut Vec<f64>) {
        own.clear();
        if self.layout().is_none() && !self.values.derives() {
            return;
        }
        let along = self.parameters().iter().filter(|parameter| !parameter.is_own());
        let numbers = along.zip(self.varied_at(positions));
        let numbers: Vec<f64> =
            numbers.map(|(parameter, value)| parameter.number(&value).unwrap_or(f64::NAN)).collect();
        let _ = self.values.values(point, &numbers, scratch, own);
        let uncertain = self.values.laws().len();
        own.drain(uncertain..uncertain + numbers.len());
    }

    /// The values of `[[vary]]` and `[points]`.
    fn varied_at(&self, positions: &[u64]) -> impl Iterator<Item = ParamValue> {
        let axes = self.study.axes.iter().zip(positions);
        axes.flat_map(|(axis, &at)| axis.varied.iter().map(move |varied| varied.values.at(at)))
    }

    /// One value per parameter, from the uncertain and derived values and the positions on the axes.
    fn put_together(&self, positions: &[u64], own: &[f64]) -> Vec<ParamValue> {
        let (mut varied, mut own) = (self.varied_at(positions), own.iter());
        let value = |(place, parameter): (usize, &Parameter)| {
            if parameter.is_own() {
                self.values.param(place, *own.next().expect("a number for each"))
            } else {
                varied.next().expect("a value for each")
            }
        };
        self.parameters().iter().enumerate().map(value).collect()
    }

    /// Appends the values that a worker needs for a sample to `out`; a word is sent as its position in the list.
    pub fn params(&self, sample: u64, out: &mut Vec<f64>) {
        let pairs = self.parameters().iter().zip(self.values(sample));
        let told = pairs.filter(|(parameter, _)| self.study.is_solved(parameter));
        out.extend(told.map(|(parameter, value)| {
            parameter.number(&value).expect("a word of the parameter: checked when the study was read")
        }));
        out.extend(self.twin(sample));
    }

    /// The machine definition of a sample; `None` for a study without a machine.
    ///
    /// # Errors
    /// A drawn or derived value that the machine rejects; in a study that is about to run, [`super::check_machines`] has found such values.
    pub fn try_machine(&self, sample: u64) -> Result<Option<MachineDef>, ValueError> {
        let mut machine = self.with_values(&self.values(sample))?;
        if let (Some(machine), Some(twin), Some(shift)) = (&mut machine, &self.study.twin, self.twin(sample)) {
            machine.set(&twin.info, &ParamValue::Number(shift)).expect("a shift the machine has, or none");
        }
        Ok(machine)
    }

    /// The machine definition of a sample, in a study with a machine that was checked.
    ///
    /// # Panics
    /// The study computes formulas.
    #[must_use]
    pub fn machine(&self, sample: u64) -> MachineDef {
        let machine = self.try_machine(sample).expect("every value was checked when the study was");
        machine.expect("asked of a study with a machine only")
    }

    /// The machine with these values of all parameters.
    pub(super) fn with_values(&self, values: &[ParamValue]) -> Result<Option<MachineDef>, ValueError> {
        let Some(machine) = self.study.machine() else { return Ok(None) };
        let mut machine = machine.def.clone();
        for (parameter, value) in self.parameters().iter().zip(values).filter(|(parameter, _)| !parameter.is_variable) {
            machine.set(&parameter.info, value)?;
        }
        Ok(Some(machine))
    }

    /// `run.twin` of a sample in a study with `twin_share`, depending on its number in the whole study.
    #[must_use]
    pub fn twin(&self, sample: u64) -> Option<f64> {
        let twin = self.study.twin.as_ref()?;
        let places = self.study.axes.iter().zip(self.positions(sample));
        let first = self.point(sample).unwrap_or(0);
        let number = places.fold(first, |number, (axis, place)| number.wrapping_mul(axis.length).wrapping_add(place));
        Some(twin.shift_of(number))
    }

    /// Describes the varied values of a sample: "diaphragms.seal.contact.gap = 0.4 mm, ...".
    #[must_use]
    pub fn describe(&self, sample: u64) -> String {
        self.describe_values(&self.values(sample))
    }

    /// Describes any values.
    pub(super) fn describe_values(&self, values: &[ParamValue]) -> String {
        let pairs = self.parameters().iter().zip(values);
        let shown = pairs.map(|(parameter, value)| format!("{} = {}", parameter.shown(), show(&parameter.info, value)));
        let shown = shown.collect::<Vec<_>>().join(", ");
        if shown.is_empty() { "nothing varied".to_owned() } else { shown }
    }

    /// Some values of a parameter, given by its index: the first, second, middle and last of its axis or of the points.
    #[must_use]
    pub(super) fn some_values(&self, place: usize) -> Vec<ParamValue> {
        let some = |length: u64| [0, 1.min(length - 1), length / 2, length - 1];
        match self.parameters()[place].origin {
            Origin::Varied(axis, member) => {
                let axis = &self.study.axes[axis];
                some(axis.length).map(|at| axis.varied[member].values.at(at)).to_vec()
            }
            _ => some(self.count()).map(|sample| self.values(sample)[place].clone()).to_vec(),
        }
    }

    /// The different values of each parameter, at most `most` of each: along its axis, otherwise of all samples; in a study of more than a hundred
    /// thousand samples, of an evenly spaced part.
    #[must_use]
    pub fn different_values(&self, most: usize) -> Vec<Vec<ParamValue>> {
        let add = |list: &mut Vec<ParamValue>, value: &ParamValue| {
            if list.len() < most && !list.contains(value) {
                list.push(value.clone());
            }
        };
        let mut found = vec![Vec::new(); self.parameters().len()];
        let mut asked = Vec::new();
        for (place, parameter) in self.parameters().iter().enumerate() {
            let Origin::Varied(axis, member) = parameter.origin else {
                asked.push(place);
                continue;
            };
            let axis = &self.study.axes[axis];
            (0..axis.length).for_each(|at| add(&mut found[place], &axis.varied[member].values.at(at)));
        }
        let count = self.count();
        let mut step = count.div_ceil(MOST_ASKED).max(1);
        // samples go through the axes in turn: a step that divides their number may meet only one value of an axis
        while common_factor(step, count) > 1 {
            step += 1;
        }
        for sample in (0..count).step_by(usize::try_from(step).unwrap_or(usize::MAX)) {
            asked.retain(|&place| found[place].len() < most);
            if asked.is_empty() {
                break;
            }
            let values = self.values(sample);
            asked.iter().for_each(|&place| add(&mut found[place], &values[place]));
        }
        found
    }

    /// All values of a parameter along its axis; some quantiles of an uncertain one; for a derived one as [`Samples::some_values`].
    #[must_use]
    pub(super) fn all_or_some_values(&self, place: usize) -> Vec<ParamValue> {
        match self.parameters()[place].origin {
            Origin::Varied(axis, member) => {
                let axis = &self.study.axes[axis];
                (0..axis.length).map(|at| axis.varied[member].values.at(at)).collect()
            }
            Origin::Uncertain(law) => {
                let law = &self.values.laws()[law];
                // multiples of the golden ratio: quarter turns would be whole periods for 4, 8, 12 ... blades
                [0.090_17, 0.381_97, 0.618_03, 0.854_1]
                    .map(|p| self.values.param(place, law.quantile(p, 1.0 - p)))
                    .to_vec()
            }
            Origin::Derived(_) => self.some_values(place),
        }
    }

    /// The distribution of an uncertain parameter, by its index.
    pub(super) fn law(&self, number: usize) -> Option<&Uncertain> {
        self.values.laws().get(number)
    }

    /// Columns of a design's replicate and block, of all parameters, and of extra columns; without the detection, which has a separate
    /// column.
    #[must_use]
    pub fn columns(&self) -> Vec<Column> {
        let twin = self.study.twin.iter().map(|twin| Column {
            name: twin.info.column(),
            unit: String::new(),
            meaning: twin.info.meaning.to_owned(),
            kind: ColumnKind::Real,
        });
        let of_design =
            [("replicate", "which of the independent designs"), ("block", "points that count as a whole only")];
        let of_design = of_design.iter().filter(|_| self.layout().is_some()).map(|(name, meaning)| Column {
            name: (*name).to_owned(),
            unit: String::new(),
            meaning: (*meaning).to_owned(),
            kind: ColumnKind::Integer,
        });
        let varied = self.parameters().iter().filter(|parameter| !parameter.is_detection()).map(Parameter::column);
        of_design.chain(varied).chain(twin).chain(self.study.extra_columns.iter().map(ExtraColumn::column)).collect()
    }

    /// Cells of these columns for a sample; `None` means empty.
    #[must_use]
    pub fn cells(&self, sample: u64) -> Vec<Option<ParamValue>> {
        let number = |number: u64| Some(ParamValue::Number(number as f64));
        let design = self.layout().zip(self.point(sample));
        let design = design.map(|(layout, point)| [number(layout.replicate(point)), number(layout.block(point))]);
        let is_there = |value: &ParamValue| !matches!(value, ParamValue::Number(number) if !number.is_finite());
        let pairs = self.parameters().iter().zip(self.values(sample));
        let varied =
            pairs.filter(|(parameter, _)| !parameter.is_detection()).map(|(_, value)| Some(value).filter(is_there));
        let twin = self.twin(sample).map(|shift| Some(ParamValue::Number(shift)));
        design
            .into_iter()
            .flatten()
            .chain(varied)
            .chain(twin)
            .chain(self.extra_columns(sample).map(|(_, value)| value))
            .collect()
    }

    /// Extra columns of a sample: names and cells.
    pub fn extra_columns(&self, sample: u64) -> impl Iterator<Item = (&str, Option<ParamValue>)> {
        // The points are the first axis.
        let position = if self.study.extra_columns.is_empty() { 0 } else { self.combinations.positions(sample)[0] };
        self.study.extra_columns.iter().map(move |carried| (carried.name.as_str(), carried.at(position)))
    }

    /// The detection of a sample if it varies.
    #[must_use]
    pub fn detection(&self, sample: u64) -> Option<String> {
        self.word(sample, Parameter::is_detection)
    }

    /// The engine of a sample if it varies.
    #[must_use]
    pub fn engine(&self, sample: u64) -> Option<String> {
        self.word(sample, |parameter| parameter.info.path == ENGINE)
    }

    fn word(&self, sample: u64, is_it: impl Fn(&Parameter) -> bool) -> Option<String> {
        let place = self.parameters().iter().position(is_it)?;
        match self.values(sample).swap_remove(place) {
            ParamValue::Choice(word) => Some(word),
            ParamValue::Number(_) => None,
        }
    }
}

/// Error of too many samples, at the longest axis, with the length and line of each axis.
fn too_many(study: &Study, scale: Option<f64>, count: u128, most: u64) -> StudyError {
    let line_of = |place: usize| 1 + study.text[..place].matches('\n').count();
    let line = |axis: &Axis| line_of(axis.varied[0].place.start);
    let kept = |axis: &Axis| Thinned::new(axis.length, scale.unwrap_or(1.0)).kept();
    let design = study.sampled.values.layout().map(|layout| {
        let layout = layout.clone().scaled(scale.unwrap_or(1.0));
        format!("{} points (line {})", layout.count(), line_of(study.design_place.start))
    });
    let axes = study.axes.iter().map(|axis| format!("{} of {} (line {})", kept(axis), axis.name, line(axis)));
    let factors = design.into_iter().chain(axes).collect::<Vec<_>>().join(" x ");
    let longest = study.axes.iter().rev().max_by_key(|axis| axis.length);
    let (place, key) = match (study.sampled.values.layout(), longest) {
        (None, Some(longest)) => (longest.varied[0].place.clone(), longest.name.clone()),
        _ => (study.design_place.clone(), "design.samples".to_owned()),
    };
    let mut problems = Collector::new(&study.file, &study.text);
    let message = format!("the study has {count} samples: {factors}");
    problems.add(place, key, message).allowed = Some(format!("at most {most} samples: fewer values, or --scale"));
    StudyError::Problems(vec![problems.into_problems()])
}
