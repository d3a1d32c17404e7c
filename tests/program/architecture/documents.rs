//! Pages of the architecture: length of ARCHITECTURE.md, sections of the design pages, links, types of the glossary.

use super::{files, read};
use crate::support::root;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

/// Pages of `docs/design` by name, without the index.
fn design_pages() -> BTreeMap<String, String> {
    let name = |path: PathBuf| path.file_name().expect("a name").to_string_lossy().into_owned();
    let names = files(&root().join("docs/design")).into_iter().map(name).filter(|name| name != "README.md");
    names.map(|name| (name.clone(), read(&format!("docs/design/{name}")))).collect()
}

#[test]
fn architecture_is_short_and_every_decision_has_its_page() {
    let words = read("ARCHITECTURE.md").split_whitespace().count();
    assert!(words <= 1200, "ARCHITECTURE.md has {words} words, more than 1200");
    let (pages, index) = (design_pages(), read("docs/design/README.md"));
    assert!(pages.len() > 40, "the pages were found: {}", pages.len());
    for (name, text) in &pages {
        let headings: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("## ")).collect();
        let wanted = ["Question", "Decision", "Why", "Rejected alternatives", "Measured"];
        assert!(headings == wanted || headings == wanted[..4], "docs/design/{name} has the sections {headings:?}");
        let words = text.split_whitespace().count();
        assert!((100..=350).contains(&words), "docs/design/{name} has {words} words");
        assert_eq!(index.matches(&format!("({name})")).count(), 1, "docs/design/README.md lists {name} once");
    }
}

/// The anchor of a heading, as Markdown hosts generate it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim_start_matches('#').trim().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

/// Names of the tests and examples that cargo can run: files in their directories, and directories with a `main.rs`.
fn targets() -> BTreeSet<String> {
    let stem = |path: PathBuf| {
        let is_main = path.ends_with("main.rs");
        let target = if is_main { path.parent()?.to_owned() } else { path };
        let folder = target.parent()?.file_name()?;
        (folder == "tests" || folder == "examples")
            .then(|| target.file_stem().map(|stem| stem.to_string_lossy().into()))?
    };
    files(&root()).into_iter().filter(|path| path.extension().is_some_and(|end| end == "rs")).filter_map(stem).collect()
}

/// Names of the test modules in directories: `cargo test --test faults resume::` runs the tests of one.
fn test_modules() -> BTreeSet<String> {
    let name = |path: PathBuf| path.with_extension("").file_name().map(|name| name.to_string_lossy().into_owned());
    let inside = |folder: &str| fs::read_dir(root().join(folder)).expect("readable");
    let folders = inside("tests").chain(inside("core/tests")).map(|entry| entry.expect("readable").path());
    let entries = folders.filter(|folder| folder.is_dir()).flat_map(|folder| fs::read_dir(folder).expect("a folder"));
    entries.filter_map(|entry| name(entry.expect("readable").path())).collect()
}

/// Links, source paths in code font, tests, test modules and examples of ARCHITECTURE.md, the glossary and the design pages.
#[test]
fn what_the_pages_of_the_architecture_name_exists() {
    let mut pages: Vec<String> = design_pages().into_keys().map(|name| format!("docs/design/{name}")).collect();
    pages.extend(["ARCHITECTURE.md", "docs/glossary.md", "docs/design/README.md"].map(str::to_owned));
    let (targets, modules) = (targets(), test_modules());
    let mut missing = Vec::new();
    let mut seen = 0;
    for page in pages {
        let text = read(&page);
        let folder = root().join(&page).parent().expect("a folder").to_owned();
        let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        for link in links.filter(|link| !link.contains("://")) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = fs::read_to_string(folder.join(file)).unwrap_or_default();
            let has = |line: &str| line.starts_with('#') && anchor(line) == heading;
            if target.is_empty() || !heading.is_empty() && !target.lines().any(has) {
                missing.push(format!("{page}: link {link}"));
            }
            seen += 1;
        }
        let sources = text.split('`').filter(|code| code.ends_with(".rs") && code.contains('/'));
        for source in sources.filter(|code| !code.contains(char::is_whitespace)) {
            if !root().join(source).is_file() {
                missing.push(format!("{page}: {source}"));
            }
            seen += 1;
        }
        let named = |word: &str| word.trim_matches(|c: char| !c.is_alphanumeric() && c != '_').to_owned();
        let words: Vec<&str> = text.split_whitespace().collect();
        for pair in words.windows(2).filter(|pair| ["--test", "--example"].contains(&pair[0])) {
            if !targets.contains(&named(pair[1])) {
                missing.push(format!("{page}: {} {}", pair[0], named(pair[1])));
            }
        }
        for module in words.iter().filter_map(|word| word.trim_end_matches(['`', '.', ',', ';']).strip_suffix("::")) {
            if !modules.contains(module) {
                missing.push(format!("{page}: module {module}"));
            }
            seen += 1;
        }
    }
    assert!(missing.is_empty(), "not there:\n{}", missing.join("\n"));
    assert!(seen > 150, "links and paths were found: {seen}");
}

/// Each row of the glossary that names a type also names the file that declares it.
#[test]
fn types_of_the_glossary_are_declared_in_their_files() {
    let glossary = read("docs/glossary.md");
    let rows = glossary.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| Term "));
    let mut wrong = Vec::new();
    let mut types = 0;
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(|cell| cell.trim().trim_matches('`')).collect();
        let [_, term, _, meaning, name, file, _] = cells[..] else { panic!("five cells: {row}") };
        assert!(!term.is_empty() && !meaning.is_empty(), "{row}");
        if name.is_empty() {
            continue;
        }
        types += 1;
        let text = fs::read_to_string(root().join(file)).unwrap_or_default();
        let declares = |line: &str| {
            let words: Vec<&str> = line.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
            let mut pairs = words.windows(2);
            pairs.any(|pair| ["struct", "enum", "trait", "type"].contains(&pair[0]) && pair[1] == name)
        };
        if !text.lines().filter(|line| !line.trim_start().starts_with("//")).any(declares) {
            wrong.push(format!("{term}: `{name}` is not declared in {file}"));
        }
    }
    assert!(wrong.is_empty(), "docs/glossary.md:\n{}", wrong.join("\n"));
    assert!(types > 40, "types were found: {types}");
}
