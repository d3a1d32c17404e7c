//! `bladeoff watch`: one page without a terminal, from the files that `status` reads.

use crate::support::{Folder, say};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

fn contents(directory: &str) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(Path::new(directory)).expect("a directory").map(|entry| entry.expect("an entry"));
    let files = entries.filter(|entry| entry.path().is_file());
    files
        .map(|file| (file.file_name().to_string_lossy().into_owned(), fs::read(file.path()).expect("readable")))
        .collect()
}

#[test]
fn a_page_has_state_worst_value_histogram_and_answers() {
    let folder = Folder::new();
    let out = folder.name("out");
    let ran = say(&["run", "studies/detection-error.toml", "--limit", "4", "--out", &out]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let before = contents(&out);
    let page = say(&["watch", &out]);
    assert_eq!(page.code, 0, "{}", page.err);
    assert!(!page.out.contains('\u{1b}'), "no terminal, no escape codes: {:?}", page.out);
    assert!(
        page.out.contains("complete")
            && page.out.contains("max_bearing_load_N, ")
            && page.out.contains(" rows: largest so far "),
        "{}",
        page.out
    );
    let (histogram, _) = page.out.split_once("\nAnswers").expect("answers behind the histogram");
    let bins = histogram.lines().filter(|line| line.contains(" N to ")).count();
    assert_eq!(bins, 10, "{histogram}");
    let counted: u64 = histogram
        .lines()
        .filter(|line| line.contains(" N to "))
        .filter_map(|line| line.split_whitespace().rev().find_map(|word| word.parse::<u64>().ok()))
        .sum();
    assert_eq!(counted, 16, "every run once: {}", page.out);
    assert!(page.out.contains("Answers, of 4 points") || page.out.contains("Answers: of 4 points"), "{}", page.out);
    assert_eq!(contents(&out), before, "it writes nothing");
}

#[test]
fn a_directory_without_a_study_is_refused() {
    let folder = Folder::new();
    let empty = folder.name("empty");
    fs::create_dir(&empty).expect("created");
    let refused = say(&["watch", &empty]);
    assert_ne!(refused.code, 0, "{}", refused.out);
    assert_eq!(refused.code, say(&["status", &empty]).code);
}
