//! What is there already: the record of an earlier run, taken over by the keys of the samples.
//!
//! ```text
//! no record              a new one                                      everything is to be computed
//! same samples           the record as it is                            what is missing is to be computed
//! grown study, rerun,    a new record of the entries that belong to     the old one is replaced by it, or kept aside
//!   damaged record       the present study                              if it is damaged
//! an entry that belongs to no present sample                            refused with the difference: nothing is lost
//! ```

use super::RunError;
use super::change::changes;
use super::directory::{LEDGER, RunDirectory};
use super::prepare::{Prepared, SAMPLES_KEY};
use crate::dispatch::DispatchError;
use crate::files::FileError;
use crate::ledger::{Head, Ledger, LedgerError, Remains, SampleKey};
use crate::report::Tally;
use crate::schedule::Todo;
use bladeoff_core::outcome::{Cause, Status};
use bladeoff_worker::fault::{At, Faults, Who};
use std::collections::HashMap;
use std::fs;
use std::ops::Range;
use std::path::PathBuf;

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

/// A record ready to be continued.
pub(super) struct Opened {
    pub ledger: Ledger,
    /// What is to be computed.
    pub todo: Todo,
    /// Counts of what is there.
    pub tally: Tally,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// Opens or makes the record of a directory, with inputs, plan and basis beside it.
pub(super) fn open(
    directory: &RunDirectory,
    prepared: &Prepared<'_>,
    rerun: Option<&Rerun>,
) -> Result<Opened, RunError> {
    let path = directory.file(LEDGER);
    if !path.exists() {
        if rerun.is_some() {
            return Err(RunError::NothingToRerun { path: directory.path().to_path_buf() });
        }
        prepared.write(directory)?;
        let mut ledger = Ledger::create(&path, &prepared.header())?;
        ledger.publish()?;
        let todo = Todo::from(prepared.samples.count());
        return Ok(Opened { ledger, todo, tally: Tally::default(), notes: Vec::new() });
    }
    match open_store(&path, directory, prepared, rerun) {
        Err(RunError::Ledger(LedgerError::Damaged { detail, .. })) => {
            let remains = Remains::read(&path)?;
            let note = format!(
                "the record of finished samples is damaged ({detail}): {} entries in it are whole and kept, the rest is \
                 computed again",
                remains.entries().len()
            );
            let mut opened = take_over(Old::Remains(remains), directory, prepared, rerun)?;
            opened.notes.insert(0, note);
            Ok(opened)
        }
        opened => opened,
    }
}

fn open_store(
    path: &std::path::Path,
    directory: &RunDirectory,
    prepared: &Prepared<'_>,
    rerun: Option<&Rerun>,
) -> Result<Opened, RunError> {
    let ledger = Ledger::open(path)?;
    let header = ledger.header()?;
    if header.get(SAMPLES_KEY) == Some(&prepared.digest) {
        let mut found = Found::default();
        let mut unfit = 0u64;
        ledger.reader().for_each_head(|sample, head| match head {
            Ok(head) if head.key != prepared.keys.key(sample) => unfit += 1,
            Ok(head) if rerun.is_some_and(|rerun| rerun.takes(head.status, head.cause)) => unfit += 1,
            Ok(head) => found.add(sample, head.status, head.cause),
            Err(_) => unfit += 1,
        })?;
        if unfit == 0 {
            prepared.write(directory)?;
            let wanted = prepared.header();
            if !wanted.iter().all(|(key, value)| header.get(key) == Some(value)) {
                ledger.replace_header(&wanted)?;
            }
            let mut notes = Vec::new();
            if rerun.is_some() {
                notes.push("no finished sample is of the kind to be computed again".to_owned());
            }
            let (todo, tally) = found.rest(prepared.samples.count());
            return Ok(Opened { ledger, todo, tally, notes });
        }
    }
    take_over(Old::Store(ledger), directory, prepared, rerun)
}

/// Where entries are taken from.
enum Old {
    Store(Ledger),
    Remains(Remains),
}

/// What is known of an entry, and where its bytes are.
struct Place {
    place: u64,
    status: Status,
    cause: Option<Cause>,
    used: bool,
}

impl Old {
    /// Every whole entry by its key, and the number of those that are not.
    fn index(&self) -> Result<(HashMap<SampleKey, Place>, u64), LedgerError> {
        let mut index = HashMap::new();
        let mut damaged = 0;
        let mut add = |head: Head, place| {
            index.insert(head.key, Place { place, status: head.status, cause: head.cause, used: false });
        };
        match self {
            Old::Store(ledger) => ledger.reader().for_each_head(|sample, head| match head {
                Ok(head) => add(head, sample),
                Err(_) => damaged += 1,
            })?,
            Old::Remains(remains) => {
                remains.entries().iter().for_each(|(head, place)| add(*head, *place as u64));
            }
        }
        Ok((index, damaged))
    }

    fn bytes(&self, place: u64) -> Result<Option<Vec<u8>>, LedgerError> {
        match self {
            Old::Store(ledger) => ledger.reader().bytes(place),
            Old::Remains(remains) => Ok(usize::try_from(place).ok().map(|place| remains.bytes_at(place).to_vec())),
        }
    }
}

/// Makes a new record of the entries that belong to the present study. Refuses to lose any.
fn take_over(
    old: Old,
    directory: &RunDirectory,
    prepared: &Prepared<'_>,
    rerun: Option<&Rerun>,
) -> Result<Opened, RunError> {
    let (mut index, damaged) = old.index()?;
    let count = prepared.samples.count();
    for sample in 0..count {
        if let Some(place) = index.get_mut(&prepared.keys.key(sample)) {
            place.used = true;
        }
    }
    let lost = index.values().filter(|place| !place.used).count() as u64;
    if lost > 0 {
        let total = index.len() as u64;
        return Err(RunError::Changed {
            path: directory.path().to_path_buf(),
            lost,
            total,
            changes: changes(directory, prepared, &old_header(&old)),
        });
    }
    let before = index.len();
    if let Some(rerun) = rerun {
        index.retain(|_, place| !rerun.takes(place.status, place.cause));
    }
    let again = before - index.len();
    let faults = Faults::from_environment(Who::Orchestrator).map_err(DispatchError::from)?;
    prepared.write(directory)?;
    let mut ledger = Ledger::create(&directory.file(LEDGER), &prepared.header())?;
    let mut found = Found::default();
    for sample in 0..count {
        let Some(place) = index.get(&prepared.keys.key(sample)) else { continue };
        if let Some(bytes) = old.bytes(place.place)? {
            ledger.put_bytes(sample, bytes)?;
            found.add(sample, place.status, place.cause);
            faults.reached(At::Growing, sample, None);
        }
    }
    let mut notes = Vec::new();
    if let Old::Remains(_) = old {
        notes.push(format!("the damaged record is kept as {}", keep_aside(&directory.file(LEDGER))?.display()));
    }
    drop(old);
    // Their row numbers, or what they hold, are those of the old record.
    directory.remove_parts()?;
    ledger.publish()?;
    if damaged > 0 {
        notes.push(format!("{damaged} entries of the record are damaged: their samples are computed again"));
    }
    if rerun.is_some() {
        notes.push(format!("{again} finished samples are computed again"));
    }
    let (todo, tally) = found.rest(count);
    Ok(Opened { ledger, todo, tally, notes })
}

fn old_header(old: &Old) -> std::collections::BTreeMap<String, String> {
    match old {
        Old::Store(ledger) => ledger.header().unwrap_or_default(),
        Old::Remains(_) => std::collections::BTreeMap::new(),
    }
}

/// Gives a damaged record a second name, under which it stays when a new one takes its place.
fn keep_aside(path: &std::path::Path) -> Result<PathBuf, FileError> {
    for n in 1u32.. {
        let kept = path.with_file_name(format!("ledger.damaged-{n}.redb"));
        match fs::hard_link(path, &kept) {
            Ok(()) => return Ok(kept),
            Err(source) if source.kind() == std::io::ErrorKind::AlreadyExists => {}
            // A file system without second names.
            Err(_) => match fs::copy(path, &kept) {
                Ok(_) => return Ok(kept),
                Err(source) => return Err(FileError::at("write", &kept)(source)),
            },
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
}

impl Found {
    fn add(&mut self, sample: u64, status: Status, cause: Option<Cause>) {
        if sample > self.next {
            self.gaps.push(self.next..sample);
        }
        self.next = sample + 1;
        self.tally.count(status, cause);
    }

    /// What is missing of `count` samples, and the counts of what is not.
    fn rest(mut self, count: u64) -> (Todo, Tally) {
        if self.next < count {
            self.gaps.push(self.next..count);
        }
        (Todo::from_iter(self.gaps), self.tally)
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
        let (todo, tally) = found.rest(8);
        assert_eq!(todo, Todo::from_iter([0..1, 3..5, 6..8]));
        assert_eq!(tally.done(), 3);
        assert_eq!(Found::default().rest(2).0.left(), 2);
    }
}
