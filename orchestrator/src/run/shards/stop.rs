//! Where the table of a study with `[stop]` ends: at the first of the looks of one machine whose rows are precise enough. A look sees the samples
//! before it and nothing else, so it matters neither who has computed them nor what else is there, and the merge need not wait for more.
//!
//! ```text
//! chunks of the next look are there -> rows aside -> precise enough? -> the table ends here
//!                                                    no: the next one
//! one is missing -> the time of [stop] was over for some, and nobody computes: the last look; otherwise it is said what is missing
//! ```

use super::super::end::{EndWhy, Looked, Looking, Stage, TableEnd};
use super::super::error::RunError;
use super::super::stages::{at_the_last, before_any_look, ended};
use super::super::tables::LookWriter;
use super::attempt::{TIME_WAS_OVER, all};
use super::error::ShardError;
use super::merge::{Merging, each_missing};
use super::rows::OwnFolder;
use super::wrong::Wrong;
use bladeoff_system::files::Pending;

impl Merging<'_> {
    /// Where the table ends; `None`: with the design, and nobody looked.
    ///
    /// # Errors
    /// [`ShardError::Missing`] where chunks before the next look are missing or damaged; files.
    pub(super) fn end(&self, looking: &dyn Looking, note: &dyn Fn(&str)) -> Result<Option<TableEnd>, ShardError> {
        let (mut last, mut known): (Option<&Stage>, Vec<String>) = (None, Vec::new());
        for stage in looking.stages() {
            let mut absent = Vec::new();
            each_missing(self.shared, &self.frozen.chunks.up_to(stage.samples), |chunk| absent.push(chunk))?;
            if let Some(&first) = absent.first() {
                if looking.wall().is_none() || !self.is_time_over() {
                    return Err(Wrong::absent(absent).told(self.shared, self.frozen));
                }
                let samples = self.prepared.samples;
                let before = || before_any_look(samples, self.frozen.chunks.range(first).start);
                let end = last.map_or_else(before, |stage| Some(ended(stage, EndWhy::Wall)));
                return end
                    .map_or_else(|| Err(Wrong::absent(absent).told(self.shared, self.frozen)), |end| Ok(Some(end)));
            }
            if looking.looks() && self.look(looking, stage, &mut known, note)? {
                return Ok(Some(ended(stage, EndWhy::Precision)));
            }
            last = Some(stage);
        }
        Ok(last.and_then(|stage| at_the_last(stage, looking, self.prepared.samples)))
    }

    /// Whether `wall` of `[stop]` has ended an attempt, and none computes.
    fn is_time_over(&self) -> bool {
        let attempts = all(self.shared);
        attempts.iter().any(|attempt| attempt.has_said(TIME_WAS_OVER)) && !attempts.iter().any(|attempt| attempt.lives)
    }

    /// Whether a stage is precise enough.
    fn look(
        &self,
        looking: &dyn Looking,
        stage: &Stage,
        known: &mut Vec<String>,
        note: &dyn Fn(&str),
    ) -> Result<bool, ShardError> {
        let aside = OwnFolder::new()?;
        let table = aside.path().join("look.parquet");
        let mut rows = LookWriter::create(self.prepared, Pending::create(&table)?)?;
        let chunks = self.frozen.chunks.up_to(stage.samples);
        let mut wrong = Wrong::default();
        for chunk in 0..chunks.count() {
            match self.read(chunk) {
                Ok(found) => {
                    let of_stage = chunks.range(chunk).zip(found.entries).filter(|(sample, _)| *sample < stage.samples);
                    of_stage.into_iter().try_for_each(|(sample, entry)| rows.push(sample, entry))?;
                }
                Err(error) => self.put_aside(chunk, error, &mut wrong, note)?,
            }
        }
        if !wrong.is_nothing() {
            return Err(wrong.told(self.shared, self.frozen));
        }
        rows.finish()?;
        let Looked { is_enough, hindered } = looking.look(stage, &table).map_err(RunError::from)?;
        for (name, why) in hindered {
            // where it is so first, not at every look again
            if !known.contains(&name) {
                note(&format!("[stop] after {} points: {name}: {why}", stage.points));
                known.push(name);
            }
        }
        Ok(is_enough)
    }
}
