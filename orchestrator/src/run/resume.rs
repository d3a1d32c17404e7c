//! Resume: takes over the record of an earlier run by the keys of the samples.
//!
//! ```text
//! no record              new record                                     all samples are computed
//! same samples           record unchanged                               missing samples are computed
//! grown study, rerun,    new record of the entries that belong to       it replaces the old one, which is set aside
//!   damaged record       the present study                              if it is damaged
//! an entry without a present sample                                     rejected with the difference: nothing is lost
//! ```
//! A sample whose workers were killed by another process is computed again, once.
//!
//! [`compare`] decides and only reads, so a rejected directory is unchanged. [`Comparison::go_on`] writes.

use super::change::changes;
use super::chosen::Chosen;
use super::directory::{LEDGER, RunDirectory};
use super::end::TableEnd;
use super::error::RunError;
use super::prepare::{Prepared, SAMPLES_KEY};
use super::reuse::{Worth, worth};
use crate::schedule::Todo;
use crate::terminal::Tally;
use bladeoff_answers::summary::{are, counted};
use bladeoff_model::outcome::{Cause, Status};
use bladeoff_record::{Head, Reader, Record, RecordError, Remains};
use bladeoff_system::files::FileError;
use bladeoff_system::folder::Folder;
use bladeoff_system::place;
use bladeoff_worker::fault::{At, Faults, NoFaults};
use std::collections::BTreeMap;
use std::ops::Range;

/// Finished samples that `--rerun` selects.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Rerun {
    /// Failed and quarantined ones.
    Failed,
    /// Samples with one of these causes.
    Causes(Vec<Cause>),
}

impl Rerun {
    fn takes(&self, status: Status, cause: Option<Cause>) -> bool {
        match self {
            Rerun::Failed => matches!(status, Status::Failed | Status::Quarantined),
            Rerun::Causes(causes) => cause.is_some_and(|cause| causes.contains(&cause)),
        }
    }
}

/// Finished samples that are computed again: the selected ones, and once each those for which [`tries`](Again::tries) is true.
#[derive(Clone, Copy)]
pub(super) struct Again<'a> {
    pub rerun: Option<&'a Rerun>,
    pub suspects: bool,
}

impl Again<'_> {
    fn takes(self, head: &Head) -> bool {
        self.rerun.is_some_and(|rerun| rerun.takes(head.status, head.cause))
    }

    /// Whether the workers of a sample were killed by another process, which may not happen again.
    fn tries(self, head: &Head) -> bool {
        self.suspects && head.status == Status::Quarantined && head.cause == Some(Cause::WorkerKilled)
    }
}

/// Record ready to be continued.
pub(super) struct Opened {
    pub record: Record,
    /// Missing samples.
    pub todo: Todo,
    /// Counts of the finished samples.
    pub tally: Tally,
    /// Notes for the user about the record.
    pub notes: Vec<String>,
}

/// Comparison of a directory with the present study. Nothing has been written yet.
pub(super) struct Comparison {
    record: Continuation,
    found: Found,
    notes: Vec<String>,
}

/// Action on the record.
enum Continuation {
    /// Create a new record.
    New,
    /// Continue the record unchanged. Its header.
    Same(Reader, BTreeMap<String, String>),
    /// Create a new record of these entries: sample, place in the old record.
    Old { old: Old, taken: Vec<(u64, u64)> },
}

/// Opens or creates the record of a directory, with inputs, plan and basis beside it.
pub(super) fn open(directory: &RunDirectory, prepared: &Prepared<'_>, again: Again<'_>) -> Result<Opened, RunError> {
    compare(directory.open(), prepared, again)?.go_on(directory, prepared, &NoFaults)
}

/// Compares a directory with the present study. Reads only.
pub(super) fn compare(directory: &Folder, prepared: &Prepared<'_>, again: Again<'_>) -> Result<Comparison, RunError> {
    let path = directory.place(LEDGER);
    if !path.exists() {
        if again.rerun.is_some() {
            return Err(RunError::NothingToRerun { path: directory.path().to_path_buf() });
        }
        return Ok(Comparison { record: Continuation::New, found: Found::default(), notes: Vec::new() });
    }
    match compare_store(&path, directory, prepared, again) {
        Err(RunError::Record(RecordError::Damaged { detail, .. })) => {
            let remains = Remains::read(&path, prepared.steps)?;
            let whole = remains.entries().len() as u64;
            let note = format!(
                "the record of finished samples is damaged ({detail}): {} in it {} undamaged and kept, the rest is \
                 computed again",
                of_record(whole),
                are(whole)
            );
            let mut compared = select(Old::Remains(remains), directory, prepared, again)?;
            compared.notes.insert(0, note);
            Ok(compared)
        }
        compared => compared,
    }
}

fn compare_store(
    path: &place::Place,
    directory: &Folder,
    prepared: &Prepared<'_>,
    again: Again<'_>,
) -> Result<Comparison, RunError> {
    let reader = Reader::open(path)?;
    let header = reader.header()?;
    let is_same_study = header.get(SAMPLES_KEY) == Some(&prepared.digest);
    if is_same_study {
        let mut found = Found::default();
        let mut unfit = 0u64;
        reader.for_each_head(prepared.steps, |sample, head| match head {
            Ok(head) if head.key != prepared.keys.key(sample) => unfit += 1,
            Ok(head) if again.takes(&head) || again.tries(&head) => unfit += 1,
            Ok(head) => found.add(sample, head.status, head.cause),
            Err(_) => unfit += 1,
        })?;
        if unfit == 0 {
            let mut notes = Vec::new();
            if again.rerun.is_some() {
                notes.push("no finished sample has a status that is to be computed again".to_owned());
            }
            return Ok(Comparison { record: Continuation::Same(reader, header), found, notes });
        }
    }
    select(Old::Store(reader, is_same_study), directory, prepared, again)
}

/// Source of entries.
enum Old {
    /// Undamaged store; whether its numbers and limits are those of the present study.
    Store(Reader, bool),
    Remains(Remains),
}

/// Head of an entry, and place of its bytes.
struct Candidate {
    head: Head,
    place: u64,
    used: bool,
}

impl Old {
    /// Lists the valid entries in key order, the best first for equal keys, and counts the damaged ones.
    fn index(&self, prepared: &Prepared<'_>) -> Result<(Vec<Candidate>, u64), RecordError> {
        let mut index = Vec::new();
        let mut damaged = 0;
        let mut add = |head: Head, place| index.push(Candidate { head, place, used: false });
        match self {
            Old::Store(reader, _) => reader.for_each_head(prepared.steps, |sample, head| match head {
                Ok(head) => add(head, sample),
                Err(_) => damaged += 1,
            })?,
            Old::Remains(remains) => {
                remains.entries().iter().for_each(|(head, place)| add(*head, *place));
            }
        }
        index.sort_unstable_by_key(|place| (place.head.key, place.head.status == Status::Quarantined, place.place));
        Ok((index, damaged))
    }

    fn bytes(&self, place: u64) -> Result<Option<Vec<u8>>, RecordError> {
        match self {
            Old::Store(reader, _) => reader.bytes(place),
            Old::Remains(remains) => remains.bytes_at(place).map(Some),
        }
    }

    fn header(&self) -> BTreeMap<String, String> {
        match self {
            Old::Store(reader, _) => reader.header().unwrap_or_default(),
            Old::Remains(_) => BTreeMap::new(),
        }
    }
}

/// Formats a number of entries: "1 entry", "2 entries".
pub(super) fn of_record(count: u64) -> String {
    if count == 1 { "1 entry".to_owned() } else { format!("{count} entries") }
}

/// Selects the entries that belong to the present study; rejects a selection that would lose some.
fn select(old: Old, directory: &Folder, prepared: &Prepared<'_>, wanted: Again<'_>) -> Result<Comparison, RunError> {
    let (mut index, damaged) = old.index(prepared)?;
    let is_same_study = matches!(old, Old::Store(_, true));
    let mut found = Found::default();
    let mut taken = Vec::new();
    let (mut again, mut longer, mut twins) = (0u64, 0u64, 0u64);
    for sample in 0..prepared.samples.count() {
        let (key, limit) = (prepared.keys.key(sample), prepared.keys.step_limit(sample));
        let first = index.partition_point(|place| place.head.key < key);
        let mut same = None;
        let mut is_superseded = false;
        for place in index[first..].iter_mut().take_while(|place| place.head.key == key) {
            let is_its_own = is_same_study && place.place == sample;
            let worth = worth(&place.head, limit, is_its_own);
            place.used |= worth != Worth::Other;
            is_superseded |= worth == Worth::Superseded;
            if worth == Worth::Same && same.is_none() {
                same = Some((place.head, place.place));
            }
        }
        // The same run with another choice of twins: computing it again loses nothing.
        let is_twin = prepared.keys.otherwise(sample).is_some_and(|other| {
            let first = index.partition_point(|place| place.head.key < other);
            let of_it = index[first..].iter_mut().take_while(|place| place.head.key == other);
            of_it.map(|place| place.used = true).count() > 0
        });
        twins += u64::from(is_twin && same.is_none());
        match same {
            Some((head, _)) if wanted.takes(&head) => again += 1,
            Some((head, _)) if wanted.tries(&head) => found.suspect(sample),
            Some((head, place)) => {
                found.add(sample, head.status, head.cause);
                taken.push((sample, place));
            }
            None => longer += u64::from(is_superseded),
        }
    }
    let lost = index.iter().filter(|place| !place.used).count() as u64;
    if lost > 0 {
        return Err(RunError::Changed {
            path: directory.path().to_path_buf(),
            lost,
            total: index.len() as u64,
            changes: changes(directory, prepared, &old.header()),
        });
    }
    let mut notes = Vec::new();
    if damaged > 0 {
        notes.push(format!(
            "{} of the record {} damaged: lost samples are computed again",
            of_record(damaged),
            are(damaged)
        ));
    }
    if longer > 0 {
        let samples = counted(longer, "sample");
        notes.push(format!("{samples} that ended early under another run.step_limit {} computed again", are(longer)));
    }
    if twins > 0 {
        notes.push(format!(
            "{} {} computed again because twin_share chooses others for a twin run",
            counted(twins, "sample"),
            are(twins)
        ));
    }
    if wanted.rerun.is_some() && (again > 0 || longer == 0) {
        notes.push(format!("{} {} computed again", counted(again, "finished sample"), are(again)));
    }
    match found.suspects.len() {
        0 => {}
        1 => notes.push(
            "1 sample whose worker was killed by another program (worker_killed) is computed once more".to_owned(),
        ),
        many => notes.push(format!(
            "{many} samples whose workers were killed by another program (worker_killed) are computed once more"
        )),
    }
    Ok(Comparison { record: Continuation::Old { old, taken }, found, notes })
}

impl Comparison {
    /// Notes for the user about the comparison.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Number of finished samples.
    pub fn done(&self) -> u64 {
        self.found.tally.done()
    }

    /// Number of finished samples that failed.
    pub fn failed(&self) -> u64 {
        self.found.tally.failed()
    }

    /// Returns the record and its counts if it has every sample, or those up to the end of the table, or the chosen ones, and
    /// needs no change.
    pub fn complete(
        &self,
        prepared: &Prepared<'_>,
        (end, chosen): (Option<&TableEnd>, Option<&Chosen>),
    ) -> Option<(&Reader, &Tally)> {
        let count = prepared.samples.count();
        let has_all = || match chosen {
            Some(chosen) => self.found.lacks(count, |sample| chosen.contains(prepared.samples, sample)).is_none(),
            None => self.found.has_all(end.map_or(count, |end| end.samples)),
        };
        match &self.record {
            Continuation::Same(reader, _) if has_all() => Some((reader, &self.found.tally)),
            _ => None,
        }
    }

    /// Writes the record of the present study, with inputs, plan and basis beside it.
    pub fn go_on(
        self,
        directory: &RunDirectory,
        prepared: &Prepared<'_>,
        faults: &dyn Faults,
    ) -> Result<Opened, RunError> {
        let Self { record, found, .. } = self;
        directory.tidy()?;
        let mut notes = Vec::new();
        let record = match record {
            Continuation::New => {
                prepared.write(directory)?;
                let mut record = Record::create(directory.file(LEDGER), &prepared.header())?;
                record.publish()?;
                record
            }
            Continuation::Same(reader, header) => {
                prepared.write(directory)?;
                let record = reader.into_record()?;
                let wanted = prepared.header();
                if !wanted.iter().all(|(key, value)| header.get(key) == Some(value)) {
                    record.replace_header(&wanted)?;
                }
                record
            }
            Continuation::Old { old, taken } => take_over((&old, &taken), directory, prepared, faults, &mut notes)?,
        };
        let (todo, tally) = found.rest(prepared.samples.count());
        Ok(Opened { record, todo, tally, notes })
    }
}

/// Creates a new record of entries of the old one and replaces it.
fn take_over(
    (old, taken): (&Old, &[(u64, u64)]),
    directory: &RunDirectory,
    prepared: &Prepared<'_>,
    faults: &dyn Faults,
    notes: &mut Vec<String>,
) -> Result<Record, RunError> {
    prepared.write(directory)?;
    let mut record = Record::create(directory.file(LEDGER), &prepared.header())?;
    for &(sample, place) in taken {
        let missing = || RecordError::Missing { sample, path: directory.file(LEDGER).to_path_buf() };
        record.put_bytes(sample, old.bytes(place)?.ok_or_else(missing)?)?;
        faults.reached(At::Growing, sample, None);
    }
    if let Old::Remains(_) = old {
        notes.push(format!("the damaged record is kept as {}", keep_aside(&directory.file(LEDGER))?));
    }
    // Their row numbers or contents are those of the old record.
    directory.remove_parts()?;
    record.publish()?;
    Ok(record)
}

/// Links a damaged record to a second name, which it keeps when a new record replaces it.
fn keep_aside(path: &place::Place) -> Result<place::Place, FileError> {
    for n in 1u32.. {
        let kept = path.with_name(&format!("ledger.damaged-{n}.redb"));
        match path.link_to(&kept) {
            Ok(()) => return Ok(kept),
            Err(source) if source.kind() == std::io::ErrorKind::AlreadyExists => {}
            // A file system without hard links.
            Err(_) if kept.exists() => {}
            Err(_) => {
                let (mut from, mut to) = (path.open()?, kept.create_closed()?);
                let copied = std::io::copy(&mut from, &mut to).and_then(|_| to.sync_all());
                copied.map_err(FileError::at("write", &kept))?;
                return Ok(kept);
            }
        }
    }
    unreachable!("a directory does not hold 2^32 damaged records")
}

/// Finished samples in ascending order.
#[derive(Default)]
struct Found {
    gaps: Vec<Range<u64>>,
    next: u64,
    tally: Tally,
    /// Samples that are tried once more.
    suspects: Vec<u64>,
}

impl Found {
    fn add(&mut self, sample: u64, status: Status, cause: Option<Cause>) {
        self.pass(sample);
        self.tally.count(status, cause);
    }

    fn suspect(&mut self, sample: u64) {
        self.pass(sample);
        self.suspects.push(sample);
    }

    /// Whether the first samples are all finished.
    fn has_all(&self, first: u64) -> bool {
        self.next >= first && self.suspects.is_empty() && self.gaps.first().is_none_or(|gap| gap.start >= first)
    }

    /// First of `count` samples that is wanted and missing.
    fn lacks(&self, count: u64, is_wanted: impl Fn(u64) -> bool) -> Option<u64> {
        let missing = self.gaps.iter().cloned().chain(std::iter::once(self.next..count)).flatten();
        missing.chain(self.suspects.iter().copied()).find(|sample| is_wanted(*sample))
    }

    fn pass(&mut self, sample: u64) {
        if sample > self.next {
            self.gaps.push(self.next..sample);
        }
        self.next = sample + 1;
    }

    /// Missing ones of `count` samples, and counts of the others.
    fn rest(mut self, count: u64) -> (Todo, Tally) {
        if self.next < count {
            self.gaps.push(self.next..count);
        }
        (Todo::from_iter(self.gaps).with_suspects(self.suspects), self.tally)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_found_is_to_be_done() {
        let mut found = Found::default();
        for sample in [1, 2, 5] {
            found.add(sample, Status::Ok, None);
        }
        found.suspect(6);
        let (todo, tally) = found.rest(9);
        assert_eq!(todo, Todo::from_iter([0..1, 3..5, 7..9]).with_suspects(vec![6]));
        assert_eq!(todo.total(), 6);
        assert_eq!(tally.done(), 3);
        assert_eq!(Found::default().rest(2).0.left(), 2);
        let mut found = Found::default();
        [0, 1, 3].into_iter().for_each(|sample| found.add(sample, Status::Ok, None));
        assert_eq!([5, 3].map(|count| found.lacks(count, |_| true)), [Some(2), Some(2)]);
        assert_eq!([5, 4].map(|count| found.lacks(count, |sample| sample != 2)), [Some(4), None]);
        assert!(found.has_all(0) && found.has_all(2) && !found.has_all(3) && !found.has_all(5));
    }
}
