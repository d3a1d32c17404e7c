//! Comparison of the generated reference pages with the code: columns, causes, commands, keys, events, features of the engines.
//!
//! `scripts/regenerate-docs --reference` writes the pages again.

mod causes;
mod columns;
mod commands;
mod features;
mod keys;
mod written;

use crate::support::root;
use std::fs;

/// A row of a Markdown table.
fn row<T: AsRef<str>>(cells: &[T]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| cell.as_ref().replace('|', "\\|").replace('\n', " ")).collect();
    format!("| {} |\n", cells.join(" | "))
}

/// The head of a Markdown table.
fn head(names: &[&str]) -> String {
    row(names) + &format!("|{}\n", "---|".repeat(names.len()))
}

/// A list of words in code font.
fn codes(words: &[&str]) -> String {
    words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}

/// The text as a sentence: with a capital first letter and a full stop.
fn sentence(text: &str) -> String {
    let text = text.trim().trim_end_matches('.');
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| format!("{}{}.", first.to_uppercase(), letters.as_str()))
}

const MARK: &str = "<!-- Generated from the code below this line: scripts/regenerate-docs --reference -->\n";

/// Compares the text after the mark of a page with the text generated from the code, or writes it if `BLADEOFF_WRITE_DOCS` is
/// set.
fn compare(page: &str, generated: &str) {
    let path = root().join("docs").join(page);
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("docs/{page}: {error}"));
    let (written, found) = text.split_once(MARK).unwrap_or_else(|| panic!("docs/{page} has the line {MARK}"));
    if std::env::var_os("BLADEOFF_WRITE_DOCS").is_some() {
        fs::write(path, format!("{written}{MARK}\n{}\n", generated.trim())).expect("written");
        return;
    }
    let differing = found.trim().lines().zip(generated.trim().lines()).find(|(found, wanted)| found != wanted);
    assert!(
        found.trim() == generated.trim(),
        "docs/{page} is not what the code gives; regenerate it with `scripts/regenerate-docs --reference`. First difference: {differing:?}"
    );
}

#[test]
fn result_columns_are_those_of_the_solver() {
    compare("result-columns.md", &columns::page());
}

#[test]
fn causes_have_the_texts_of_why() {
    compare("causes.md", &causes::page());
}

#[test]
fn the_command_line_is_that_of_the_program() {
    compare("command-line.md", &commands::page());
}

#[test]
fn keys_of_machine_files_are_the_format_itself() {
    compare("machine-keys.md", &keys::machine());
}

#[test]
fn keys_of_study_files_are_the_format_itself() {
    compare("study-keys.md", &keys::study());
}

#[test]
fn events_are_those_of_the_program() {
    compare("events.md", &commands::events());
}

#[test]
fn features_of_the_engines_are_what_machine_files_allow() {
    compare("features.md", &features::page());
}
