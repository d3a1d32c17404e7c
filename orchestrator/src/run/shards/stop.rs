//! End of the merged table of a study with `[stop]`: the first interim analysis of one machine whose rows are precise enough. An
//! analysis reads the samples before it and nothing else. So it does not matter which attempts computed them, and the merge need
//! not wait for further chunks.
//!
//! ```text
//! chunks of the next analysis exist -> rows in a temporary table -> precise enough? yes: the table ends here
//!                                                                                  no: next analysis
//! a chunk is missing -> `wall` of [stop] ended an attempt and none is alive: the last analysis; otherwise an error
//! ```

use super::super::end::{EndWhy, PrecisionCheck, PrecisionResult, Stage, TableEnd};
use super::super::error::RunError;
use super::super::stages::{at_the_last, before_any_look, ended};
use super::super::tables::LookWriter;
use super::attempt::{TIME_WAS_OVER, all_attempts};
use super::chunk_problems::ChunkProblems;
use super::error::ShardError;
use super::merge::{Merging, each_missing};
use super::rows::OwnFolder;
use bladeoff_system::files::Pending;

impl Merging<'_> {
    /// Determines the end of the table; `None`: the end of the design, without interim analyses.
    ///
    /// # Errors
    /// [`ShardError::Missing`] if chunks before the next analysis are missing or damaged; file errors.
    pub(super) fn end(
        &self,
        looking: &dyn PrecisionCheck,
        note: &dyn Fn(&str),
    ) -> Result<Option<TableEnd>, ShardError> {
        let (mut last, mut known): (Option<&Stage>, Vec<String>) = (None, Vec::new());
        for stage in looking.stages() {
            let mut absent = Vec::new();
            each_missing(self.shared, &self.shards_file.chunks.up_to(stage.samples), |chunk| absent.push(chunk))?;
            if let Some(&first) = absent.first() {
                if looking.wall().is_none() || !self.is_time_over() {
                    return Err(ChunkProblems::missing(absent).into_error(self.shared, self.shards_file));
                }
                let samples = self.prepared.samples;
                let before = || before_any_look(samples, self.shards_file.chunks.range(first).start);
                let end = last.map_or_else(before, |stage| Some(ended(stage, EndWhy::Wall)));
                return end.map_or_else(
                    || Err(ChunkProblems::missing(absent).into_error(self.shared, self.shards_file)),
                    |end| Ok(Some(end)),
                );
            }
            if looking.looks() && self.look(looking, stage, &mut known, note)? {
                return Ok(Some(ended(stage, EndWhy::Precision)));
            }
            last = Some(stage);
        }
        Ok(last.and_then(|stage| at_the_last(stage, looking, self.prepared.samples)))
    }

    /// Whether `wall` of `[stop]` has ended an attempt and no attempt is alive.
    fn is_time_over(&self) -> bool {
        let attempts = all_attempts(self.shared);
        attempts.iter().any(|attempt| attempt.has_reported(TIME_WAS_OVER))
            && !attempts.iter().any(|attempt| attempt.lives)
    }

    /// Whether the rows of a stage are precise enough.
    fn look(
        &self,
        looking: &dyn PrecisionCheck,
        stage: &Stage,
        known: &mut Vec<String>,
        note: &dyn Fn(&str),
    ) -> Result<bool, ShardError> {
        let aside = OwnFolder::new()?;
        let table = aside.path().join("look.parquet");
        let mut rows = LookWriter::create(self.prepared, Pending::create(&table)?)?;
        let chunks = self.shards_file.chunks.up_to(stage.samples);
        let mut problems = ChunkProblems::default();
        for chunk in 0..chunks.count() {
            match self.read(chunk) {
                Ok(found) => {
                    let of_stage = chunks.range(chunk).zip(found.entries).filter(|(sample, _)| *sample < stage.samples);
                    of_stage.into_iter().try_for_each(|(sample, entry)| rows.push(sample, entry))?;
                }
                Err(error) => self.set_aside(chunk, error, &mut problems, note)?,
            }
        }
        if !problems.is_empty() {
            return Err(problems.into_error(self.shared, self.shards_file));
        }
        rows.finish()?;
        let PrecisionResult { is_enough, hindered } = looking.look(stage, &table).map_err(RunError::from)?;
        for (name, why) in hindered {
            // reported at the first analysis only
            if !known.contains(&name) {
                note(&format!("[stop] after {} points: {name}: {why}", stage.points));
                known.push(name);
            }
        }
        Ok(is_enough)
    }
}
