//! `[refine]` of a study: the next combinations of its map, from the rows of the combinations chosen so far.

use super::resolve::{Meant, Source, meant};
use super::rows::{AnsweringError, Rows};
use super::vocabulary::{Vocabulary, column_of};
use crate::run::{Chosen, EndWhy, PrecisionError, Refining, TableEnd};
use bladeoff_answers::ask::{Ask, Question};
use bladeoff_answers::map::refine::{Grid, kinds};
use bladeoff_answers::map::{Of, REGIME, Wanted, maps};
use bladeoff_answers::tables::TableError;
use bladeoff_model::machine::ParamValue;
use bladeoff_study::{Origin, Samples};
use bladeoff_text::document::Collector;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Spacing of the values that are computed first.
const EVERY: usize = 4;

/// Refinement of a map.
#[derive(Debug, Clone)]
pub struct Refinement {
    samples: Samples,
    question: Question,
    wanted: Wanted,
    along: [Along; 2],
    grid: Grid,
    max_samples: u64,
    /// Number of samples of a combination.
    each: u64,
}

/// An axis of the map: index of the study's axis, and values in ascending order with their positions in the study.
#[derive(Debug, Clone)]
struct Along {
    axis: usize,
    values: Vec<f64>,
    positions: Vec<u64>,
}

/// Reason why a map cannot be refined: error, allowed values, and key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unrefined(String, String, Key);

/// Key of `[refine]`, or the whole table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Key {
    Whole,
    MaxSamples,
    First,
}

impl Unrefined {
    fn new(message: impl Into<String>, allowed: impl Into<String>) -> Self {
        Self(message.into(), allowed.into(), Key::Whole)
    }

    fn by(self, key: Key) -> Self {
        Self(self.0, self.1, key)
    }

    /// Reports the problem at its place in the study file.
    pub fn tell(self, samples: &Samples, problems: &mut Collector<'_>) {
        let def = samples.study().refine.as_ref();
        let place = def.map_or(0..0, |def| match self.2 {
            Key::Whole => def.span.clone(),
            Key::MaxSamples => def.places[0].clone(),
            Key::First => def.places[1].clone(),
        });
        let key = match self.2 {
            Key::Whole => "refine",
            Key::MaxSamples => "refine.max_samples",
            Key::First => "refine.first",
        };
        problems.add(place, key, self.0).allowed = Some(self.1);
    }
}

impl Refinement {
    /// Refinement of a study with `[refine]`; `None` without, and for a part (`--scale`, `--limit`) that is too small to choose from.
    ///
    /// # Errors
    /// The map cannot be refined.
    pub fn of(samples: &Samples, meant: &Meant) -> Result<Option<Self>, Unrefined> {
        let study = samples.study();
        let Some(def) = &study.refine else { return Ok(None) };
        let is_part = samples.scale().is_some() || samples.limit().is_some();
        if samples.layout().is_none() && samples.limit().is_some() {
            return Ok(None);
        }
        let name = study.asked.questions.get(def.question).and_then(|asked| asked.name.as_ref());
        let question = name.and_then(|name| meant.questions.iter().find(|question| question.name == name.value));
        let Some((question, Ask::Map(wanted))) = question.map(|question| (question, &question.ask)) else {
            // the map question has an error that is reported elsewhere
            return Ok(None);
        };
        if matches!(wanted.of, Of::Value(_)) && Vocabulary::of(samples).is_none_or(|known| !has_regimes(&known)) {
            let message = format!("formulas have no regime ({REGIME}), and the map {} is of no event", question.name);
            return Err(Unrefined::new(message, "a map of the probability of an event: of = \"P(...)\""));
        }
        let along = [Along::of(samples, &wanted.x)?, Along::of(samples, &wanted.y)?];
        if along[0].axis == along[1].axis {
            let message = format!("{} and {} advance together", wanted.x, wanted.y);
            return Err(Unrefined::new(message, "a map over two [[vary]]"));
        }
        for (along, column) in along.iter().zip([&wanted.x, &wanted.y]) {
            if let Some(pair) = along.values.windows(2).find(|pair| pair[0] == pair[1]) {
                return Err(Unrefined::new(format!("{column} has the value {} twice", pair[0]), "each value once"));
            }
        }
        let lengths = [0, 1].map(|axis: usize| along[axis].values.len());
        let asked = def.first.map(|first| first.map(|count| usize::try_from(count).unwrap_or(usize::MAX)));
        // a part has at most as many values as exist
        let fitting = |axis: usize, first: usize| if is_part { first.min(lengths[axis]) } else { first };
        let first = asked.map(|first| [fitting(0, first[0]), fitting(1, first[1])]);
        let first = first.unwrap_or(lengths.map(|length| (length.max(1) - 1).div_ceil(EVERY) + 1));
        let Some(grid) = Grid::new(lengths, first) else {
            let message =
                format!("{} and {} values come first, of {} and {}", first[0], first[1], lengths[0], lengths[1]);
            let refused = Unrefined::new(message, "at least 2 values of each axis, and at most all of them");
            let refused = if asked.is_some() { refused.by(Key::First) } else { refused };
            return if is_part { Ok(None) } else { Err(refused) };
        };
        let each = samples.count() / (lengths[0] * lengths[1]) as u64;
        let begun = grid.first().len() as u64 * each;
        if begun > def.max_samples {
            let message = format!("{begun} samples come first, and max_samples = {} allows no more", def.max_samples);
            let refused = Unrefined::new(message, "a larger max_samples, or fewer values in `first`");
            return Err(refused.by(Key::MaxSamples));
        }
        // differences between panels are not needed
        let wanted = Wanted { paired: None, ..wanted.clone() };
        let (samples, question, max_samples) = (samples.clone(), question.clone(), def.max_samples);
        Ok(Some(Self { samples, question, wanted, along, grid, max_samples, each }))
    }

    /// Why every sample of a part (`--scale`, `--limit`) of a study with `[refine]` is computed.
    #[must_use]
    pub fn whole_part(samples: &Samples) -> Option<&'static str> {
        let why = if samples.layout().is_none() && samples.limit().is_some() {
            "--limit takes the first samples, anywhere on the map: [refine] cannot leave any out"
        } else {
            "so small a part has fewer than two values along an axis of the map: [refine] cannot leave any out"
        };
        samples.study().refine.as_ref().map(|_| why)
    }

    /// Description of the refinement.
    #[must_use]
    pub fn in_words(&self) -> Vec<String> {
        let [x, y] = self.along.each_ref().map(|along| along.values.len() as u64);
        let (first, [begun, most]) = (self.grid.first().len(), self.samples());
        vec![
            format!("{first} of the {} combinations of {} come first: {begun} samples", x * y, self.question.name),
            format!("more where the regime or event changes: at most {most} samples in all"),
        ]
    }

    /// Number of samples of the first round, and largest number in all rounds.
    #[must_use]
    pub fn samples(&self) -> [u64; 2] {
        let [x, y] = self.along.each_ref().map(|along| along.values.len() as u64);
        [self.grid.first().len() as u64 * self.each, self.max_samples.min(x * y * self.each)]
    }

    /// Positions in the study of places on the map.
    fn cells(&self, places: impl IntoIterator<Item = (usize, usize)>) -> Vec<[u64; 2]> {
        let [x, y] = &self.along;
        places.into_iter().map(|place| [x.positions[place.0], y.positions[place.1]]).collect()
    }

    /// Refinement of a study as stored in its directory; `None` if nothing is refined.
    pub(super) fn of_study(samples: &Samples) -> Option<Self> {
        let study = samples.study();
        study.refine.as_ref()?;
        let meant = meant(samples, Source { file: &study.file, text: &study.text, asked: &study.asked }).ok()?;
        Self::of(samples, &meant).ok()?
    }

    /// Rows in the parts of an incomplete study. For points of a design: the complete points in the combinations of the last complete round,
    /// or of the first round. For chosen values: all rows.
    pub(super) fn so_far(
        &self,
        parts: &[PathBuf],
        vocabulary: &Vocabulary<'_>,
        columns: &[String],
    ) -> Result<Result<Rows, AnsweringError>, TableError> {
        let mut there = None;
        if self.samples.layout().is_some() {
            let (mut chosen, mut goes_on) = (self.first(), true);
            loop {
                let rows = match self.rows(parts, &chosen)? {
                    Ok(rows) => rows,
                    Err(error) => return Ok(Err(error)),
                };
                if rows.points() < self.samples.points() {
                    break;
                }
                there = Some(chosen.clone());
                let (more, others) = match self.after(&rows, &chosen) {
                    Ok(next) if goes_on && !next.0.is_empty() => next,
                    Ok(_) => break,
                    Err(error) => return Ok(Err(error)),
                };
                chosen.cells.extend(more);
                goes_on = others;
            }
            there = there.or_else(|| Some(self.first()));
        }
        let rows = Rows::read(parts, &self.samples, vocabulary, (columns, None, there.as_ref()))?;
        Ok(rows.map(Rows::half_way))
    }

    /// The rows that determine the next combinations.
    fn rows(&self, files: &[PathBuf], chosen: &Chosen) -> Result<Result<Rows, AnsweringError>, TableError> {
        let Some(vocabulary) = Vocabulary::of(&self.samples) else { return Ok(Err(AnsweringError::Unread)) };
        let mut columns = self.question.columns(&vocabulary.names);
        columns.sort();
        columns.dedup();
        let count = self.count(chosen);
        let points = if self.samples.layout().is_some() { self.samples.points() } else { count };
        let end = TableEnd { points, samples: count, share: 1.0, why: EndWhy::Refined };
        Rows::read(files, &self.samples, &vocabulary, (&columns, Some(end), Some(chosen)))
    }

    /// Number of samples in the chosen combinations.
    fn count(&self, chosen: &Chosen) -> u64 {
        chosen.cells.len() as u64 * self.each
    }

    /// The combinations that follow these rows, and whether more may follow.
    fn after(&self, rows: &Rows, chosen: &Chosen) -> Result<(Vec<[u64; 2]>, bool), AnsweringError> {
        let found = maps(&rows.study(), &self.wanted, 1.0 - self.question.confidence)?;
        let known = kinds(&found, self.along.each_ref().map(|along| along.values.as_slice()));
        let room = self.max_samples.saturating_sub(self.count(chosen)) / self.each;
        let next = self.grid.next(&known, usize::try_from(room).unwrap_or(usize::MAX));
        Ok((self.cells(next.places), next.is_all))
    }

    fn wanted_next(&self, chosen: &Chosen, table: &Path) -> Result<(Vec<[u64; 2]>, bool), AnsweringError> {
        let rows = self.rows(&[table.to_path_buf()], chosen)??;
        self.after(&rows, chosen)
    }
}

impl Refining for Refinement {
    fn first(&self) -> Chosen {
        let axes = self.along.each_ref().map(|along| along.axis);
        Chosen { axes, cells: self.cells(self.grid.first()).into_iter().collect() }
    }

    fn next(&self, chosen: &Chosen, table: &Path) -> Result<(Vec<[u64; 2]>, bool), PrecisionError> {
        self.wanted_next(chosen, table).map_err(|error| PrecisionError(Box::new(error)))
    }
}

fn has_regimes(vocabulary: &Vocabulary<'_>) -> bool {
    vocabulary.columns.iter().any(|column| column.field.name == REGIME)
}

impl Along {
    /// The axis of a column.
    fn of(samples: &Samples, column: &str) -> Result<Self, Unrefined> {
        let parameter = samples.parameters().iter().find(|parameter| column_of(parameter) == column);
        let allowed = "a map over two [[vary]] of numbers";
        let Some(Origin::Varied(axis, member)) = parameter.map(|parameter| parameter.origin) else {
            return Err(Unrefined::new(format!("{column} has no given values to choose from"), allowed));
        };
        let list = &samples.study().axes[axis].varied[member].values;
        let rows = if samples.layout().is_some() { samples.count() / samples.points().max(1) } else { samples.count() };
        let kept: BTreeSet<u64> = (0..rows).map(|sample| samples.positions(sample)[axis]).collect();
        let mut found: Vec<(f64, u64)> = Vec::new();
        for position in kept {
            match list.at(position) {
                // 0 and -0 are equal, as in maps
                ParamValue::Number(number) => found.push((number + 0.0, position)),
                ParamValue::Choice(_) => return Err(Unrefined::new(format!("values of {column} are words"), allowed)),
            }
        }
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let (values, positions) = found.into_iter().unzip();
        Ok(Self { axis, values, positions })
    }
}
