//! `[stop]` of a study: whether the rows of a stage answer its questions with the required precision.

use super::forecast::Awaited;
use super::resolve::Meant;
use super::rows::{AnsweringError, Rows};
use super::shortfall::{is_left_open, short_of};
use super::vocabulary::Vocabulary;
use crate::run::{EndWhy, PrecisionCheck, PrecisionError, PrecisionResult, Stage, TableEnd};
use bladeoff_answers::ask::{Answer, Ask, Question, answer_all, percent_given};
use bladeoff_answers::estimate::figures::Figures;
use bladeoff_answers::gate;
use bladeoff_answers::stop::{InterimAnalysis, StopRule, interim_analyses};
use bladeoff_answers::summary::duration;
use bladeoff_study::sampling::layout::{LayoutKind, MOST_POINTS};
use bladeoff_study::{FIRST_LOOK, Samples, StopDef, block, is_blocked};
use std::path::Path;
use std::time::Duration;

const _: () = assert!(MOST_POINTS == gate::MOST_POINTS, "no gate waits for more points than a study may have");
const _: () = assert!(FIRST_LOOK == gate::FIRST_LOOK, "what a study file is checked by is where it is looked at");

/// Stopping rule of a study, with its questions and stages.
#[derive(Debug, Clone)]
pub struct Waiting {
    samples: Samples,
    questions: Vec<Question>,
    def: StopDef,
    stages: Vec<Stage>,
}

/// The rule for the precision of figures.
fn rule(def: &StopDef) -> StopRule {
    StopRule { half_width: def.half_width, relative: def.relative, samples: def.samples }
}

impl Waiting {
    /// Stopping rule of a study with `[stop]`.
    #[must_use]
    pub fn of(samples: &Samples, meant: &Meant) -> Option<Self> {
        let (def, layout) = (samples.study().stop?, samples.layout()?);
        // Saltelli: base points are counted, because their sequence is balanced at powers of two; Morris: points of the trajectories
        let base = if layout.kind() == LayoutKind::Saltelli { layout.rows() } else { 1 };
        let each = if is_blocked(layout) { layout.rows() } else { 1 };
        let end = rule(&def).end(samples.points() / each) * each;
        let stage = |look: &InterimAnalysis| {
            let points = layout.limited(look.points * base);
            let share = if def.asks_for_width() { look.alpha } else { 1.0 };
            Stage { points, samples: points * samples.groups().len() as u64, share }
        };
        let stages = interim_analyses(end / base, 1.0).iter().map(stage).collect();
        let waited_for = |question: &&Question| match &question.ask {
            Ask::One(_) | Ask::Difference(..) => !is_blocked(layout),
            Ask::Exceedance(_) | Ask::Fragility(..) | Ask::Map(_) => false,
            Ask::Sensitivity(_) => true,
        };
        let questions = meant.questions.iter().filter(waited_for).cloned().collect();
        Some(Self { samples: samples.clone(), questions, def, stages })
    }

    /// Number of samples at the first interim analysis, `None` without one; and the largest number of samples.
    #[must_use]
    pub fn ends(&self) -> (Option<u64>, u64) {
        let of = |stage: Option<&Stage>| stage.map(|stage| stage.samples);
        let first = of(self.stages.first()).filter(|_| self.def.asks_for_width());
        (first, of(self.stages.last()).unwrap_or(self.samples.count()))
    }

    /// Requirements of `[stop]`, for forecasts.
    #[must_use]
    pub fn awaited(&self) -> Awaited {
        Awaited {
            rule: rule(&self.def),
            names: self.questions.iter().map(|question| question.name.clone()).collect(),
            analyses: self.stages.iter().map(|stage| stage.points).collect(),
        }
    }

    /// Answers to the questions of `[stop]`, from the rows of a stage.
    fn answers(&self, stage: &Stage, table: &Path) -> Result<Vec<Answer>, AnsweringError> {
        let vocabulary = Vocabulary::of(&self.samples).ok_or(AnsweringError::Unread)?;
        let mut columns: Vec<String> =
            self.questions.iter().flat_map(|question| question.columns(&vocabulary.names)).collect();
        columns.sort();
        columns.dedup();
        let &Stage { points, samples, share } = stage;
        let end = TableEnd { points, samples, share, why: EndWhy::Design };
        let rows = Rows::read(&[table.to_path_buf()], &self.samples, &vocabulary, (&columns, Some(end), None))??;
        let (mut answers, _) = answer_all(&rows.study(), &self.questions)?;
        // an unanswered question is not precise
        answers.answers.iter_mut().filter(|answer| answer.figures.is_empty()).for_each(|answer| {
            answer.figures = vec![Figures::over(0)];
        });
        Ok(answers.answers)
    }

    /// Figures of these answers that are less precise than required, with the reason; `only_hindered`: only those that more points cannot improve.
    #[must_use]
    pub fn short_of(&self, answers: &[Answer], only_hindered: bool) -> Vec<(String, String)> {
        let is_asked = |answer: &&Answer| self.questions.iter().any(|question| question.name == answer.name);
        let rule = rule(&self.def);
        if !rule.asks_for_width() {
            return Vec::new();
        }
        let mut short: Vec<(String, String)> =
            answers.iter().filter(is_asked).flat_map(|answer| short_of(&rule, answer, only_hindered)).collect();
        if answers.iter().filter(is_asked).any(|answer| is_left_open(&rule, answer)) {
            short.push((
                "runs beyond the model".to_owned(),
                "more points cannot narrow what they leave open".to_owned(),
            ));
        }
        short
    }

    /// The rule as text: "half of every interval at most 5 % of its figure; interim analyses after 256, 512 ... points; 8 h".
    #[must_use]
    pub fn in_words(&self) -> Vec<String> {
        let StopDef { half_width, relative, samples, wall } = self.def;
        let mut lines = Vec::new();
        let mut widths = Vec::new();
        widths.extend(half_width.map(|width| format!("{width} (SI)")));
        widths.extend(relative.map(|part| format!("{} of its figure", percent_given(part))));
        let points: Vec<String> = self.stages.iter().map(|stage| stage.points.to_string()).collect();
        if !widths.is_empty() {
            let names: Vec<&str> = self.questions.iter().map(|question| question.name.as_str()).collect();
            lines.push(format!("half of every interval of {} at most {}", names.join(", "), widths.join(" and ")));
            lines.push(format!("interim analyses after {} points", points.join(", ")));
        }
        if let Some(samples) = samples {
            let what = self.samples.layout().and_then(block).map_or("points", |(_, name)| name);
            lines.push(format!("{samples} {what} at most"));
        }
        lines.extend(wall.map(|wall| format!("{} at most", duration(wall))));
        lines
    }
}

impl PrecisionCheck for Waiting {
    fn stages(&self) -> &[Stage] {
        &self.stages
    }

    fn looks(&self) -> bool {
        self.def.asks_for_width()
    }

    fn wall(&self) -> Option<Duration> {
        self.def.wall
    }

    fn look(&self, stage: &Stage, table: &Path) -> Result<PrecisionResult, PrecisionError> {
        let answers = self.answers(stage, table).map_err(|error| PrecisionError(Box::new(error)))?;
        let figures: Vec<Figures> = answers.iter().flat_map(|answer| answer.figures.iter().cloned()).collect();
        Ok(PrecisionResult { is_enough: rule(&self.def).is_enough(&figures), hindered: self.short_of(&answers, true) })
    }
}
