//! What is there already: the record of an earlier run, taken over by the keys of the samples.
//!
//! ```text
//! no record              a new one                                      everything is to be computed
//! same samples           the record as it is                            what is missing is to be computed
//! grown study, rerun,    a new record of the entries that belong to     the old one is replaced by it, or kept aside
//!   damaged record       the present study                              if it is damaged
//! an entry that belongs to no present sample                            refused with the difference: nothing is lost
//! ```
//! A sample that was given up because its workers were killed from outside is as one of a rerun, but tried once only.
//!
//! [`compare`] decides which, and reads only: whatever is refused has been touched by nobody. [`Comparison::go_on`] does it.

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

/// Which finished samples are to be computed again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Rerun {
    /// Failed and quarantined ones.
    Failed,
    /// Those whose column `cause` is one of these.
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

/// Which finished samples are computed again: those that are asked for, and once each those of which [`tries`](Again::tries) says so.
#[derive(Clone, Copy)]
pub(super) struct Again<'a> {
    pub rerun: Option<&'a Rerun>,
    pub suspects: bool,
}

impl Again<'_> {
    fn takes(self, head: &Head) -> bool {
        self.rerun.is_some_and(|rerun| rerun.takes(head.status, head.cause))
    }

    /// A sample was given up because its workers were killed from outside: that may be over.
    fn tries(self, head: &Head) -> bool {
        self.suspects && head.status == Status::Quarantined && head.cause == Some(Cause::WorkerKilled)
    }
}

/// A record ready to be continued.
pub(super) struct Opened {
    pub record: Record,
    /// What is to be computed.
    pub todo: Todo,
    /// Counts of what is there.
    pub tally: Tally,
    /// What the user should know of how it was made.
    pub notes: Vec<String>,
}

/// What is in a directory, compared with the present study. Nothing has been written to it yet.
pub(super) struct Comparison {
    record: Continuation,
    found: Found,
    notes: Vec<String>,
}

/// What becomes of the record.
enum Continuation {
    /// There is none: a new one is made.
    New,
    /// It goes on as it is. The header: what it says of its entries.
    Same(Reader, BTreeMap<String, String>),
    /// A new one is made of these of its entries: sample, place in the old one.
    Old { old: Old, taken: Vec<(u64, u64)> },
}

/// Opens or makes the record of a directory, with inputs, plan and basis beside it.
pub(super) fn open(directory: &RunDirectory, prepared: &Prepared<'_>, again: Again<'_>) -> Result<Opened, RunError> {
    compare(directory.open(), prepared, again)?.go_on(directory, prepared, &NoFaults)
}

/// Compares what is in a directory with the present study. Reads only.
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
                "the record of finished samples is damaged ({detail}): {} in it {} whole and kept, the rest is computed again",
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
                notes.push("no finished sample is of the kind to be computed again".to_owned());
            }
            return Ok(Comparison { record: Continuation::Same(reader, header), found, notes });
        }
    }
    select(Old::Store(reader, is_same_study), directory, prepared, again)
}

/// Where entries are taken from.
enum Old {
    /// A whole store; whether its numbers and limits are those of the present study.
    Store(Reader, bool),
    Remains(Remains),
}

/// What is known of an entry, and where its bytes are.
struct Candidate {
    head: Head,
    place: u64,
    used: bool,
}

impl Old {
    /// Every whole entry in the order of the keys, the best first of those with one key, and the number of entries that are
    /// not whole.
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

/// How many entries of a record: "1 entry", "2 entries".
pub(super) fn of_record(count: u64) -> String {
    if count == 1 { "1 entry".to_owned() } else { format!("{count} entries") }
}

/// Selects the entries that belong to the present study. Refuses to lose any.
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
        // the same run with another choice of twins: nothing is lost when it is computed again
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
            "{} of the record {} damaged: what is lost by it is computed again",
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
        1 => notes
            .push("1 sample whose worker was killed by another program (worker_killed) is tried once more".to_owned()),
        many => notes.push(format!(
            "{many} samples whose workers were killed by another program (worker_killed) are tried once more"
        )),
    }
    Ok(Comparison { record: Continuation::Old { old, taken }, found, notes })
}

impl Comparison {
    /// What the user should know of the comparison.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Samples that are there.
    pub fn done(&self) -> u64 {
        self.found.tally.done()
    }

    /// Samples that are there and have failed.
    pub fn failed(&self) -> u64 {
        self.found.tally.failed()
    }

    /// The record and its counts, where it holds every sample, or those up to the end of the table, or those that are chosen, and needs
    /// no change.
    pub fn complete(
        &self,
        prepared: &Prepared<'_>,
        (end, chosen): (Option<&TableEnd>, Option<&Chosen>),
    ) -> Option<(&Reader, &Tally)> {
        let count = prepared.samples.count();
        let has_all = || match chosen {
            Some(chosen) => self.found.lacks(count, |sample| chosen.has(prepared.samples, sample)).is_none(),
            None => self.found.has_all(end.map_or(count, |end| end.samples)),
        };
        match &self.record {
            Continuation::Same(reader, _) if has_all() => Some((reader, &self.found.tally)),
            _ => None,
        }
    }

    /// Makes the record that of the present study, with inputs, plan and basis beside it.
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

/// Makes a new record of entries of the old one and puts it in its place.
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
    // Their row numbers, or what they hold, are those of the old record.
    directory.remove_parts()?;
    record.publish()?;
    Ok(record)
}

/// Gives a damaged record a second name, under which it stays when a new one takes its place.
fn keep_aside(path: &place::Place) -> Result<place::Place, FileError> {
    for n in 1u32.. {
        let kept = path.with_name(&format!("ledger.damaged-{n}.redb"));
        match path.link_to(&kept) {
            Ok(()) => return Ok(kept),
            Err(source) if source.kind() == std::io::ErrorKind::AlreadyExists => {}
            // A file system without second names.
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
    /// Tried once more.
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

    /// Whether the first samples are all there.
    fn has_all(&self, first: u64) -> bool {
        self.next >= first && self.suspects.is_empty() && self.gaps.first().is_none_or(|gap| gap.start >= first)
    }

    /// The first of `count` samples that is wanted and not there.
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

    /// What is missing of `count` samples, and the counts of what is not.
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
