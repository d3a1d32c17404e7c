//! Tests of the record, and of the salvage of a damaged one.

use super::*;
use bladeoff_model::outcome::{CauseSet, EndCause, Outcome, Status};
use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::FileExt;
use std::path::Path;

fn entry(value: f64) -> Entry {
    let outcome = Outcome {
        status: Status::Ok,
        cause: None,
        causes: CauseSet::default(),
        notes: CauseSet::default(),
        end_cause: EndCause::EndTime,
        values: vec![Some(value); 30],
    };
    Entry { outcome, cpu_s: 0.5, worker: 1, attempt: 2 }
}

fn key(sample: u64) -> SampleKey {
    SampleKey(u128::from(sample) << 64 | 7)
}

fn store(path: &Path, samples: impl IntoIterator<Item = u64>) -> Record {
    let mut record = Record::create(path, &[("study".into(), "a".into())]).expect("create");
    record.publish().expect("publish");
    for sample in samples {
        record.put(sample, key(sample), &entry(sample as f64), Instant::now()).expect("put");
    }
    record
}

fn samples(record: &Record) -> Vec<u64> {
    let mut seen = Vec::new();
    let read = record.reader().for_each::<RecordError>(|sample, found| {
        assert_eq!(found, entry(sample as f64));
        seen.push(sample);
        Ok(())
    });
    read.expect("read");
    seen
}

#[test]
fn results_come_back_in_order_of_their_number_also_after_opening_again() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let path = directory.path().join("ledger.redb");
    let mut record = store(&path, [5, 1, 3]);
    assert_eq!(record.reader().len().expect("read"), 0, "not yet committed");
    record.commit_if_due(Instant::now() + Record::GROUP_AGE).expect("commit");
    assert_eq!(samples(&record), [1, 3, 5]);
    drop(record);
    let record = Record::open(&path).expect("open");
    assert_eq!(samples(&record), [1, 3, 5]);
    assert_eq!(record.reader().header().expect("header")["study"], "a");
    let mut heads = Vec::new();
    record.reader().for_each_head(None, |sample, head| heads.push((sample, head.expect("whole").key))).expect("read");
    assert_eq!(heads, [(1, key(1)), (3, key(3)), (5, key(5))]);
}

#[test]
fn a_store_of_another_version_is_refused_by_name() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let path = directory.path().join("ledger.redb");
    let record = store(&path, [1]);
    let transaction = record.reader().store.begin_write().expect("writable");
    transaction.open_table(HEADER).expect("a table").insert(VERSION_KEY, "1").expect("written");
    transaction.commit().expect("committed");
    drop(record);
    let error = Record::open(&path).expect_err("another version");
    assert!(matches!(&error, RecordError::Version { found, .. } if found == "1"), "{error}");
}

#[test]
fn a_second_opener_is_refused_while_the_first_lives() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let path = directory.path().join("ledger.redb");
    let first = store(&path, []);
    let own = std::process::id();
    assert!(matches!(Record::open(&path), Err(RecordError::Held { by: Some(by), .. }) if by.pid == own));
    drop(first);
    assert!(Record::open(&path).is_ok());
}

#[test]
fn a_store_cut_at_any_byte_gives_some_of_its_samples_or_says_that_it_is_damaged() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let path = directory.path().join("ledger.redb");
    let mut record = store(&path, 0..300);
    record.commit().expect("commit");
    // State after a crash: copied while the store is open, next to the state after an orderly end.
    let crashed = fs::read(&path).expect("readable");
    drop(record);
    let closed = fs::read(&path).expect("readable");
    let all: BTreeSet<u64> = (0..300).collect();
    let cut = directory.path().join("cut.redb");
    let (mut opened, mut salvaged, mut damaged) = (0, 0, 0);
    for whole in [&crashed, &closed] {
        let step = whole.len() / 59 + 1;
        for length in (0..whole.len()).step_by(step).chain(0..16).chain(whole.len() - 16..whole.len()) {
            fs::write(&cut, &whole[..length]).expect("written");
            match Record::open(&cut).and_then(|record| {
                let mut found = BTreeSet::new();
                record.reader().for_each_head(None, |sample, head| {
                    if head.is_ok_and(|head| head.key == key(sample)) {
                        found.insert(sample);
                    }
                })?;
                Ok(found)
            }) {
                Ok(found) => {
                    opened += 1;
                    assert!(found.is_subset(&all));
                }
                Err(RecordError::Damaged { .. }) => {
                    damaged += 1;
                    let remains = Remains::read(&cut, None).expect("readable");
                    for (head, place) in remains.entries() {
                        let (found, content) =
                            Entry::decode(&remains.bytes_at(*place).expect("readable")).expect("checked");
                        let sample = (head.key.0 >> 64) as u64;
                        assert_eq!((found, content), (key(sample), entry(sample as f64)));
                        salvaged += 1;
                    }
                }
                Err(error) => panic!("cut to {length} of {} bytes: {error}: {error:?}", whole.len()),
            }
        }
    }
    assert!(damaged > 60 && salvaged > 3000, "{opened} opened, {damaged} damaged, {salvaged} entries salvaged");
}

#[test]
fn a_changed_byte_anywhere_never_gives_a_wrong_entry() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let path = directory.path().join("ledger.redb");
    let mut record = store(&path, 0..100);
    record.commit().expect("commit");
    drop(record);
    let whole = fs::read(&path).expect("readable");
    let bad = directory.path().join("bad.redb");
    let (mut kept, mut damaged) = (0u32, 0u32);
    for at in (0..whole.len()).step_by(whole.len() / 400 + 1).chain(0..128) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x55;
        fs::write(&bad, &bytes).expect("written");
        let opened = Record::open(&bad).and_then(|record| {
            record.reader().for_each_head(None, |sample, head| {
                if let Ok(head) = head {
                    // A misplaced entry has the key of another sample, which the caller compares.
                    kept += u32::from(head.key == key(sample));
                }
            })
        });
        match opened {
            Ok(()) => {}
            Err(RecordError::Damaged { .. }) => {
                damaged += 1;
                let remains = Remains::read(&bad, None).expect("readable");
                for (head, place) in remains.entries() {
                    let (_, content) = Entry::decode(&remains.bytes_at(*place).expect("readable")).expect("checked");
                    assert_eq!(content, entry((head.key.0 >> 64) as u64 as f64));
                }
            }
            Err(error) => panic!("byte {at}: {error}: {error:?}"),
        }
    }
    // Most of a small file is free pages.
    assert!(damaged > 20 && kept > 1000, "{damaged} damaged, {kept} entries read");
}

#[test]
fn any_changed_byte_of_the_header_is_damage_whose_entries_are_salvaged_or_harmless() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let path = directory.path().join("ledger.redb");
    let mut record = store(&path, 0..20);
    record.commit().expect("commit");
    // State after a crash, and after an orderly end.
    let crashed = directory.path().join("crashed.redb");
    fs::copy(&path, &crashed).expect("copied");
    drop(record);
    let (mut damaged, mut whole) = (0, 0);
    for path in [&crashed, &path] {
        let bytes = fs::read(path).expect("readable");
        let file = fs::OpenOptions::new().write(true).open(path).expect("writable");
        for at in 0..330 {
            for flip in [0x01, 0x02, 0x03, 0x04, 0x80, 0xff] {
                file.write_all_at(&[bytes[at] ^ flip], at as u64).expect("written");
                let read = Reader::open(path).and_then(|reader| {
                    let mut found = 0;
                    reader.for_each::<RecordError>(|sample, content| {
                        assert_eq!(content, entry(sample as f64));
                        found += 1;
                        Ok(())
                    })?;
                    Ok(found)
                });
                match read {
                    // An older commit may remain: fewer entries, but never wrong ones.
                    Ok(found) => whole += u32::from(found == 20),
                    Err(RecordError::Damaged { .. }) => {
                        damaged += 1;
                        let remains = Remains::read(path, None).expect("readable");
                        assert_eq!(remains.entries().len(), 20, "byte {at} ^ {flip}");
                    }
                    Err(error) => panic!("byte {at} ^ {flip}: {error}: {error:?}"),
                }
            }
            file.write_all_at(&bytes[at..=at], at as u64).expect("written");
        }
        assert!(fs::read(path).expect("readable") == bytes, "reading writes nothing");
    }
    assert!(damaged > 200 && whole > 200, "{damaged} damaged, {whole} whole");
}

#[test]
fn reading_leaves_the_file_as_it_is_also_after_a_crash() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let (path, crashed) = (directory.path().join("ledger.redb"), directory.path().join("crashed.redb"));
    let mut record = store(&path, 0..300);
    record.commit().expect("commit");
    fs::copy(&path, &crashed).expect("copied");
    drop(record);
    for path in [&path, &crashed] {
        let before = fs::read(path).expect("readable");
        for reader in [Reader::open(path).expect("whole"), Reader::peek(path).expect("whole")] {
            assert_eq!((reader.len().expect("read"), reader.header().expect("read")["study"].as_str()), (300, "a"));
            let mut heads = 0;
            reader
                .for_each_head(Some(3), |sample, head| heads += u64::from(head.expect("whole").count == Some(sample)))
                .expect("read");
            assert_eq!(heads, 300);
        }
        assert!(fs::read(path).expect("readable") == before);
        assert_eq!(samples(&Reader::open(path).expect("whole").into_record().expect("writable")).len(), 300);
    }
}
