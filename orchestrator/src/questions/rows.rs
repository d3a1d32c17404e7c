//! Rows for questions: the required columns of a table, or of its parts, in the order of the samples.
//!
//! In an incomplete study, rows are in the order in which they were finished. Only the points before the first incomplete point are used,
//! because the samples that finish first are not random.

use super::vocabulary::Vocabulary;
use crate::run::{Availability, Chosen, TableEnd};
use bladeoff_answers::estimate::input::{
    Cells, Column, Design, DesignKind, Ended, Group, InputError, Layout, Nature, Study,
};
use bladeoff_answers::gate::GateError;
use bladeoff_answers::sensitivity::Moved;
use bladeoff_answers::tables::{END_CAUSE, END_TIME, FieldKind, Table, TableError};
use bladeoff_model::outcome::{Cause, CauseSet, EndCause, Status};
use bladeoff_study::Samples;
use bladeoff_study::sampling::layout::{LayoutKind, Move, SamplingLayout};
use std::path::PathBuf;

/// Verdict columns that are always read.
const VERDICT: [&str; 5] = ["sample", "status", "causes", END_CAUSE, END_TIME];

/// Reason why a study cannot answer.
#[derive(Debug, thiserror::Error)]
pub enum AnsweringError {
    /// The table cannot be read.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The table lacks a required column, or does not fit the design.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The points do not allow a gate.
    #[error(transparent)]
    Gate(#[from] GateError),
    /// A study without random points.
    #[error("the study has no [design]: its samples are not random and cannot answer a question")]
    NoDesign,
    /// A gate of a study with `[refine]`.
    #[error("[refine] chose the combinations by their results: a gate would not cover the others")]
    Refined,
    /// The machine cannot be built, so that the columns of its table are not known.
    #[error("the machine of the study can no longer be built")]
    Unread,
    /// A row that does not belong to these samples.
    #[error(
        "{}: sample {sample} does not belong to the study, or its status or causes cannot be read",
        bladeoff_system::shown(path)
    )]
    Row {
        /// Path of the file.
        path: PathBuf,
        /// Sample number in the row.
        sample: f64,
    },
}

/// Bound that a bad row gives in a column; see [`Nature`].
enum Known {
    Given,
    Free,
    /// Index of the column with the value reached while all guards and limits held.
    Once(Option<usize>),
    Limit(Option<usize>),
    Grows(Option<usize>),
}

/// Cells of a column.
enum Found {
    Numbers(Vec<Option<f64>>),
    /// Words, and the possible words in order.
    Words(Vec<Option<String>>, Vec<String>),
}

impl Found {
    /// Copies the cells of a piece to the places `at`; returns whether the piece has this column.
    fn take(&mut self, name: &str, piece: &Table, at: &[Option<usize>]) -> bool {
        fn put<T: Clone>(cells: &mut [T], found: &[T], at: &[Option<usize>]) {
            for (at, cell) in at.iter().zip(found) {
                if let Some(at) = at {
                    cells[*at] = cell.clone();
                }
            }
        }
        match self {
            Self::Numbers(cells) => piece.numbers(name).map(|found| put(cells, found, at)).is_some(),
            Self::Words(cells, _) => piece.words(name).map(|found| put(cells, found, at)).is_some(),
        }
    }

    fn keep(&mut self, is_kept: &[bool]) {
        match self {
            Self::Numbers(cells) => keep(cells, is_kept),
            Self::Words(cells, _) => keep(cells, is_kept),
        }
    }

    /// Replaces all cells by `rows` empty ones.
    fn clear(&mut self, rows: usize) {
        match self {
            Self::Numbers(cells) => {
                cells.clear();
                cells.resize(rows, None);
            }
            Self::Words(cells, _) => {
                cells.clear();
                cells.resize(rows, None);
            }
        }
    }

    fn truncate(&mut self, rows: usize) {
        match self {
            Self::Numbers(cells) => cells.truncate(rows),
            Self::Words(cells, _) => cells.truncate(rows),
        }
    }
}

/// Removes the cells that are not kept.
fn keep<T>(cells: &mut Vec<T>, is_kept: &[bool]) {
    let mut is_kept = is_kept.iter();
    cells.retain(|_| is_kept.next() == Some(&true));
}

struct Gathered {
    name: String,
    unit: String,
    known: Known,
    cells: Found,
    is_there: bool,
    unjudged: bool,
}

/// Rows of the first points.
pub(super) struct Rows {
    columns: Vec<Gathered>,
    status: Vec<Status>,
    causes: Vec<CauseSet>,
    /// Reason why each run ended.
    ends: Vec<Ended>,
    replicate: Vec<u32>,
    groups: Vec<Group>,
    kind: DesignKind,
    scrambled: bool,
    replicates: u64,
    layout: Blocks,
    of: u64,
    share: f64,
    /// Whether the combinations were chosen by their results.
    refined: bool,
    /// Whether `[refine]` may still add combinations.
    is_open: bool,
}

/// Dependence of the points of a block.
enum Blocks {
    Points,
    Trajectories(Vec<Option<Moved>>, f64),
    Saltelli { second_order: bool },
}

impl Blocks {
    /// Dependence of the first `points` points of a design.
    fn of(layout: &SamplingLayout, points: u64) -> Self {
        if let Some(trajectories) = layout.trajectories() {
            let moved = |point| trajectories.moved(point).map(|Move { parameter, up }| Moved { parameter, up });
            return Self::Trajectories((0..points).map(moved).collect(), trajectories.delta());
        }
        let saltelli = layout.saltelli().map(|saltelli| Self::Saltelli { second_order: saltelli.has_second_order() });
        saltelli.unwrap_or(Self::Points)
    }
}

impl Rows {
    /// Reads columns of these files. `end`: end of the table, if `[stop]` ended the study. `chosen`: combinations in the table, if `[refine]` chose
    /// them; for a design, only these groups are read. The outer error concerns files, which may have been replaced meanwhile.
    pub fn read(
        files: &[PathBuf],
        samples: &Samples,
        vocabulary: &Vocabulary<'_>,
        (columns, end, chosen): (&[String], Option<TableEnd>, Option<&Chosen>),
    ) -> Result<Result<Self, AnsweringError>, TableError> {
        let layout = samples.layout();
        // without a design each sample is a point
        let of = end.map_or(layout.map_or(samples.count(), |_| samples.points()), |end| end.points);
        let all = vocabulary.groups.len();
        let is_kept =
            |group: &usize| layout.is_none() || chosen.is_none_or(|chosen| chosen.contains(samples, *group as u64));
        let kept: Vec<usize> = (0..all).filter(is_kept).collect();
        let groups: Vec<Group> = kept.iter().map(|group| vocabulary.groups[*group].clone()).collect();
        // without a design, places are sample numbers
        let points = if layout.is_some() { of } else { samples.count() };
        let count = usize::try_from(points).unwrap_or(usize::MAX).saturating_mul(groups.len());
        let place = |number: f64| {
            let (point, group) = (number as usize / all, number as usize % all);
            Some(point * kept.len() + kept.binary_search(&group).ok()?).filter(|row| *row < count)
        };
        let mut gathered = gathered(vocabulary, columns, count);
        let mut status: Vec<Option<Status>> = vec![None; count];
        let mut causes = vec![CauseSet::default(); count];
        let mut ends = vec![Ended::Other; count];
        let mut odd = None;
        let wanted: Vec<String> = gathered.iter().map(|column| column.name.clone()).collect();
        let names: Vec<&str> = VERDICT.into_iter().chain(wanted.iter().map(String::as_str)).collect();
        for path in files {
            Table::for_each_piece(std::slice::from_ref(path), &names, |piece| {
                let numbers = piece.numbers("sample").unwrap_or_default();
                let at: Vec<Option<usize>> = numbers.iter().map(|number| place((*number)?)).collect();
                for (row, at) in at.iter().enumerate() {
                    match (at, verdict(piece, row)) {
                        (Some(at), Some((said, why))) => {
                            (status[*at], causes[*at]) = (Some(said), why);
                            ends[*at] = ended(piece, row);
                        }
                        // rows of parts that were recorded with another rule
                        (None, Some(_)) if chosen.is_some() && is_of(samples, numbers[row]) => {}
                        _ => odd = odd.clone().or(Some((path.clone(), numbers[row].unwrap_or(f64::NAN)))),
                    }
                }
                for column in &mut gathered {
                    column.is_there |= column.cells.take(&column.name, piece, &at);
                }
                Ok(())
            })?;
        }
        if let Some((path, sample)) = odd {
            return Ok(Err(AnsweringError::Row { path, sample }));
        }
        let Some(layout) = layout else {
            // chosen values: every row is used, in whatever order the rows were finished
            let is_there: Vec<bool> = status.iter().map(Option::is_some).collect();
            gathered.iter_mut().for_each(|column| column.cells.keep(&is_there));
            keep(&mut causes, &is_there);
            keep(&mut ends, &is_there);
            let status: Vec<Status> = status.into_iter().flatten().collect();
            let replicate = vec![0; status.len()];
            let (kind, scrambled, replicates) = (DesignKind::Chosen, false, 1);
            return Ok(Ok(Self {
                columns: gathered,
                status,
                causes,
                ends,
                replicate,
                groups,
                kind,
                layout: Blocks::Points,
                scrambled,
                replicates,
                of,
                share: 1.0,
                refined: chosen.is_some(),
                is_open: false,
            }));
        };
        let done = status.iter().take_while(|status| status.is_some()).count() / groups.len();
        let rows = done * groups.len();
        gathered.iter_mut().for_each(|column| column.cells.truncate(rows));
        causes.truncate(rows);
        ends.truncate(rows);
        Ok(Ok(Self {
            columns: gathered,
            status: status.into_iter().map_while(|status| status).take(rows).collect(),
            causes,
            ends,
            replicate: (0..done as u64).map(|point| layout.replicate(point) as u32).collect(),
            groups,
            kind: design_kind(layout),
            layout: Blocks::of(layout, done as u64),
            scrambled: layout.is_scrambled(),
            replicates: layout.replicates(),
            of,
            share: end.map_or(1.0, |end| end.share),
            refined: chosen.is_some(),
            is_open: false,
        }))
    }

    /// Columns of a finished table with these column names, and the design of the study, without rows.
    pub fn head(
        samples: &Samples,
        layout: &SamplingLayout,
        vocabulary: &Vocabulary<'_>,
        columns: &[String],
        there: &[String],
        end: Option<TableEnd>,
    ) -> Self {
        let mut columns = gathered(vocabulary, columns, 0);
        columns.iter_mut().for_each(|column| column.is_there = there.contains(&column.name));
        Self {
            columns,
            status: Vec::new(),
            causes: Vec::new(),
            ends: Vec::new(),
            replicate: Vec::new(),
            groups: vocabulary.groups.clone(),
            kind: design_kind(layout),
            layout: Blocks::Points,
            scrambled: layout.is_scrambled(),
            replicates: layout.replicates(),
            of: end.map_or(samples.points(), |end| end.points),
            share: end.map_or(1.0, |end| end.share),
            refined: false,
            is_open: false,
        }
    }

    /// Names of the columns to read.
    pub fn wanted(&self) -> Vec<String> {
        let wanted = self.columns.iter().map(|column| column.name.clone());
        VERDICT.map(str::to_owned).into_iter().chain(wanted).collect()
    }

    /// Replaces the rows by those of a piece of a table that begins at sample `first`. Returns `false` if the samples of the piece are not in
    /// consecutive order; the error is the number of a sample whose verdict is invalid.
    pub fn pass(&mut self, layout: &SamplingLayout, piece: &Table, first: u64) -> Result<bool, f64> {
        let (rows, groups) = (piece.rows(), self.groups.len() as u64);
        let numbers = piece.numbers("sample").unwrap_or_default();
        let is_next = |(row, number): (usize, &Option<f64>)| *number == Some((first + row as u64) as f64);
        if numbers.len() != rows || !numbers.iter().enumerate().all(is_next) {
            return Ok(false);
        }
        self.status.clear();
        self.causes.clear();
        self.ends.clear();
        for (row, number) in numbers.iter().enumerate() {
            let (said, why) = verdict(piece, row).ok_or(number.unwrap_or(f64::NAN))?;
            self.status.push(said);
            self.causes.push(why);
            self.ends.push(ended(piece, row));
        }
        let at: Vec<Option<usize>> = (0..rows).map(Some).collect();
        for column in &mut self.columns {
            column.cells.clear(rows);
            column.cells.take(&column.name, piece, &at);
        }
        let points = first / groups..(first + rows as u64).div_ceil(groups);
        self.replicate = points.map(|point| layout.replicate(point) as u32).collect();
        Ok(true)
    }

    /// Marks rows of a study whose combinations are still being chosen.
    pub fn half_way(self) -> Self {
        Self { refined: true, is_open: true, ..self }
    }

    /// Whether the combinations were chosen by their results.
    pub fn are_refined(&self) -> bool {
        self.refined
    }

    /// Whether combinations may still be added.
    pub fn are_open(&self) -> bool {
        self.is_open
    }

    /// Number of points used.
    pub fn points(&self) -> u64 {
        self.replicate.len() as u64
    }

    /// Number of points of the study.
    pub fn of(&self) -> u64 {
        self.of
    }

    fn column<'a>(&'a self, column: &'a Gathered) -> Column<'a> {
        // without this column there are no reached values
        let held = |held: &Option<usize>| {
            let held = held.map(|at| &self.columns[at]).filter(|held| held.is_there)?;
            if let Found::Numbers(cells) = &held.cells { Some(cells.as_slice()) } else { None }
        };
        let cells = match (&column.cells, &column.known) {
            (Found::Words(words, list), _) => Cells::Words(words, list),
            (Found::Numbers(cells), Known::Given) => Cells::Numbers(cells, Nature::Given),
            (Found::Numbers(cells), Known::Limit(at)) => Cells::Numbers(cells, Nature::Limit(held(at))),
            (Found::Numbers(cells), Known::Once(at)) => Cells::Numbers(cells, Nature::Once(held(at))),
            (Found::Numbers(cells), Known::Free) => Cells::Numbers(cells, Nature::Free),
            (Found::Numbers(cells), Known::Grows(at)) => Cells::Numbers(cells, Nature::Grows(held(at))),
        };
        Column { name: column.name.clone(), unit: column.unit.clone(), cells, unjudged: column.unjudged }
    }

    /// The rows as input of the estimators.
    pub fn study(&self) -> Study<'_> {
        let there = self.columns.iter().filter(|column| column.is_there || self.points() == 0);
        Study {
            // a missing column is an error only for the questions that need it
            columns: there.map(|column| self.column(column)).collect(),
            status: &self.status,
            causes: &self.causes,
            ends: &self.ends,
            groups: self.groups.clone(),
            design: Design {
                kind: self.kind,
                scrambled: self.scrambled,
                replicates: self.replicates as usize,
                replicate: &self.replicate,
                complete: self.points() == self.of && !self.is_open,
                layout: match &self.layout {
                    Blocks::Points => Layout::Points,
                    Blocks::Trajectories(moves, delta) => Layout::Trajectories(moves, *delta),
                    Blocks::Saltelli { second_order } => Layout::Saltelli { second_order: *second_order },
                },
                share: self.share,
                refined: self.refined,
            },
        }
    }
}

fn is_of(samples: &Samples, number: Option<f64>) -> bool {
    number.is_some_and(|number| (0.0..samples.count() as f64).contains(&number))
}

/// The required columns, then the columns with their reached values.
fn gathered(vocabulary: &Vocabulary<'_>, columns: &[String], count: usize) -> Vec<Gathered> {
    let mut held: Vec<String> = Vec::new();
    let column = |name: &str| vocabulary.columns.iter().find(|column| column.field.name == name);
    let empty = |name: &str, unit: &str, known| {
        let (name, unit) = (name.to_owned(), unit.to_owned());
        let list = vocabulary.words_of(&name).or_else(|| match column(&name)?.field.kind {
            FieldKind::Choice(words) => Some(words.iter().map(|word| (*word).to_owned()).collect()),
            _ => None,
        });
        let cells = match list {
            Some(list) => Found::Words(vec![None; count], list),
            None => Found::Numbers(vec![None; count]),
        };
        let unjudged = column(&name).is_some_and(|column| column.unjudged);
        Gathered { name, unit, known, cells, is_there: false, unjudged }
    };
    let mut all: Vec<Gathered> = Vec::new();
    let mut further = |guarded: &Option<String>| {
        held.push(guarded.clone()?);
        Some(columns.len() + held.len() - 1)
    };
    for name in columns {
        let found = column(name);
        let known = match found.map(|found| &found.availability) {
            Some(Availability::Input) => Known::Given,
            Some(Availability::LowerBound(guarded)) => Known::Grows(further(guarded)),
            Some(Availability::EventTime(guarded)) => Known::Once(further(guarded)),
            Some(Availability::LimitTime(guarded)) => Known::Limit(further(guarded)),
            Some(Availability::Unavailable) | None => Known::Free,
        };
        all.push(empty(name, found.map_or("", |found| found.field.unit.as_str()), known));
    }
    all.extend(held.iter().map(|name| empty(name, "", Known::Free)));
    all
}

/// Status and causes of a row; `None` if their words are unknown.
fn verdict(piece: &Table, row: usize) -> Option<(Status, CauseSet)> {
    let (status, causes) = (piece.words("status")?, piece.words("causes")?);
    Some((Status::from_word(status[row].as_deref()?)?, caused(causes[row].as_deref())?))
}

/// Reason why the run of a row ended.
fn ended(piece: &Table, row: usize) -> Ended {
    let cause = piece.words(END_CAUSE).and_then(|words| words[row].as_deref());
    let time = || piece.numbers(END_TIME).and_then(|times| times[row]);
    match cause {
        Some(word) if word == EndCause::Limit.word() => Ended::Limit,
        Some(word) if word == EndCause::EndTime.word() => time().map_or(Ended::Other, Ended::Time),
        _ => Ended::Other,
    }
}

/// Parses causes.
fn caused(words: Option<&str>) -> Option<CauseSet> {
    let mut causes = CauseSet::default();
    for word in words.unwrap_or("").split(',').filter(|word| !word.is_empty()) {
        causes.insert(Cause::from_word(word)?);
    }
    Some(causes)
}

/// Kind of a design for the estimators.
pub(super) fn design_kind(layout: &SamplingLayout) -> DesignKind {
    match layout.kind() {
        LayoutKind::MonteCarlo => DesignKind::MonteCarlo,
        LayoutKind::LatinHypercube => DesignKind::LatinHypercube,
        LayoutKind::Sobol => DesignKind::Sobol,
        LayoutKind::Halton => DesignKind::Halton,
        LayoutKind::OneAtATime => DesignKind::OneAtATime,
        LayoutKind::Morris => DesignKind::Morris,
        LayoutKind::Saltelli => DesignKind::Saltelli,
    }
}
