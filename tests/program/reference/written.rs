//! Commands on the pages: the program must know each command and its options.

use crate::support::root;
use bladeoff::cli::commands;
use clap::error::ErrorKind;
use std::fs;

/// The lines of the `sh` blocks of a page, with continued lines joined.
fn shown(page: &str) -> Vec<String> {
    let blocks = page.split("\n```sh\n").skip(1).filter_map(|rest| rest.split("\n```").next());
    blocks.flat_map(|block| block.replace("\\\n", " ").lines().map(str::to_owned).collect::<Vec<_>>()).collect()
}

/// The words of the `bladeoff` command in a shell line; `None` if the line has no such command.
fn words(line: &str) -> Option<Vec<String>> {
    let line = line.split(" #").next()?.trim();
    let line = line.strip_prefix("nohup ").unwrap_or(line);
    let line = line.replace("cargo run --release -- ", "bladeoff ");
    let line =
        [" || ", " > ", " | ", " &"].iter().fold(line.as_str(), |line, end| line.split(end).next().unwrap_or(line));
    let command = line.strip_prefix("bladeoff ").or(line.strip_prefix("target/release/bladeoff "))?;
    let quoted = command.split('"').enumerate();
    let spaced = quoted.map(|(place, piece)| if place % 2 == 0 { piece.replace(' ', "\n") } else { piece.to_owned() });
    let spaced = spaced.collect::<String>().replace("I/16", "0/16");
    Some(spaced.split('\n').filter(|word| !word.is_empty()).map(str::to_owned).collect())
}

#[test]
fn commands_on_the_pages_are_understood() {
    let mut pages: Vec<_> = fs::read_dir(root().join("docs"))
        .expect("the pages")
        .filter_map(Result::ok)
        .map(|entry| entry.path())
        .collect();
    pages.push(root().join("README.md"));
    let mut seen = 0;
    for page in pages.iter().filter(|page| page.extension().is_some_and(|end| end == "md")) {
        let text = fs::read_to_string(page).expect("a page");
        for line in shown(&text) {
            let Some(words) = words(&line) else { continue };
            let found = commands().try_get_matches_from([vec!["bladeoff".to_owned()], words].concat());
            let is_help =
                |error: &clap::Error| matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
            if let Err(error) = found {
                assert!(is_help(&error), "{}: {line}\n{error}", page.display());
            }
            seen += 1;
        }
    }
    assert!(seen > 60, "{seen} commands");
}
