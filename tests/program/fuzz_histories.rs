//! Histories that are changed anywhere: an error or the right numbers, within the bounds of `fuzz`.

use crate::cap::{self, case};
use crate::fuzz::{MOST, config, mutant};
use crate::support::{Folder, say};
use bladeoff::history::{read, recover};
use bladeoff_answers::history::History;
use proptest::prelude::*;
use std::fs;

/// A small history of each format.
fn histories(folder: &Folder) -> Vec<(&'static str, Vec<u8>)> {
    let rig = folder.name("machines/rig.toml");
    let record = |extension: &'static str| {
        let history = folder.name(&format!("whole.{extension}"));
        let run = ["simulate", &rig, "--set", "run.end_time=20 ms", "--every", "1 ms", "--history", &history];
        let said = say(&[&run[..], &["--channels", "rotor.speed_rad_s,contact.gap_m,contact.normal_force_N"]].concat());
        assert_eq!(said.code, 0, "{}", said.err);
        (extension, fs::read(&history).expect("written"))
    };
    ["mcap", "parquet", "csv"].map(record).to_vec()
}

/// Places at which a file is changed: every byte of its first and last kilobyte, and every fifth between, where metadata and samples repeat the
/// same structure.
fn places(length: usize) -> impl Iterator<Item = usize> {
    const WHOLE: usize = 1024;
    (0..length).filter(move |at| *at < WHOLE || *at + WHOLE >= length || at.is_multiple_of(5))
}

/// Reads a history with these bytes as `plot` does, and recovers an MCAP; returns the history.
fn look_at_history(folder: &Folder, extension: &str, bytes: &[u8]) -> Option<History> {
    let (path, saved) = (folder.path(&format!("h.{extension}")), folder.path("saved.mcap"));
    fs::write(&path, bytes).expect("written");
    case(MOST, || {
        // recover does not overwrite files
        let _ = fs::remove_file(&saved);
        let _ = recover(&path, &saved);
        read(&path).ok()
    })
}

#[test]
fn any_history_is_read_or_refused() {
    let folder = Folder::new();
    let all = histories(&folder);
    let one_of_them = (0..all.len()).prop_flat_map({
        let all = all.clone();
        move |one| (Just(one), mutant(all[one].1.clone()))
    });
    proptest!(config(), |((one, bytes) in one_of_them)| {
        look_at_history(&folder, all[one].0, &bytes);
    });
    println!("{}", cap::figures());
}

/// The numbers of an MCAP and of a Parquet history have a checksum: they are read as written, or not at all.
#[test]
fn a_history_that_is_changed_anywhere_has_its_numbers_or_is_refused() {
    let folder = Folder::new();
    for (extension, whole) in histories(&folder).into_iter().take(2) {
        let known = look_at_history(&folder, extension, &whole).expect("whole");
        let (mut refused, mut count) = (0, 0);
        // one change of each place, of three kinds in turn: a checksum detects each of them
        for (at, flip) in places(whole.len()).zip([0x01, 0x80, 0xff].into_iter().cycle()) {
            let mut bytes = whole.clone();
            bytes[at] ^= flip;
            count += 1;
            match look_at_history(&folder, extension, &bytes) {
                None => refused += 1,
                // messages of an MCAP may be missing, as after a killed run
                Some(found) if extension == "parquet" || found.time.len() == known.time.len() => {
                    let values =
                        |history: &History| history.channels.iter().map(|one| one.values.clone()).collect::<Vec<_>>();
                    assert!(found.time == known.time && values(&found) == values(&known), "byte {at} ^ {flip:#x}");
                }
                Some(_) => {}
            }
        }
        println!("{extension}: {refused} of {count} refused; {}", cap::figures());
        assert!(refused > count / 4, "{extension}: {refused} of {count}");
    }
}

/// A length of 2^64-1, as in a chunk that its writer has begun, in place of the length of every record, and elsewhere.
#[test]
fn no_length_in_an_mcap_is_believed_beyond_its_file() {
    let folder = Folder::new();
    let (_, whole) = histories(&folder).swap_remove(0);
    // a record has an opcode, the length of its content in eight bytes, and its content; before the first and after the last there are eight bytes
    let (mut lengths, mut record) = (Vec::new(), 8);
    while record < whole.len() - 8 {
        lengths.push(record + 1);
        let length = whole[record + 1..record + 9].try_into().map(u64::from_le_bytes).expect("eight bytes");
        record += 9 + length as usize;
    }
    assert!(record == whole.len() - 8 && lengths.len() > 10, "{record}: {lengths:?}");
    let mut refused = 0;
    for at in lengths.into_iter().chain(places(whole.len()).filter(|at| (8..whole.len() - 8).contains(at))) {
        let mut bytes = whole.clone();
        bytes[at..at + 8].fill(0xff);
        refused += u32::from(look_at_history(&folder, "mcap", &bytes).is_none());
    }
    println!("{refused} refused; {}", cap::figures());
    assert!(refused > 100, "{refused}");
}
