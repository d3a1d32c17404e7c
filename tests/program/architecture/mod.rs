//! ARCHITECTURE.md and README.md against the source tree: folders, packages, permitted libraries, commands. Design documents: `documents`.

mod documents;

use crate::support::{root, say};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

fn read(name: &str) -> String {
    fs::read_to_string(root().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Every file below a folder, except `target` and hidden ones.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("readable") {
        let path = entry.expect("readable").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if name.starts_with('.') || name == "target" || path == root().join("runs") {
            continue;
        }
        if path.is_dir() { found.extend(files(&path)) } else { found.push(path) }
    }
    found
}

/// The folders drawn in the first code block of ARCHITECTURE.md, as paths.
fn drawn_folders() -> Vec<PathBuf> {
    let text = read("ARCHITECTURE.md");
    let block = text.split("```").nth(1).expect("a code block");
    let mut parents: Vec<String> = Vec::new();
    let mut drawn = Vec::new();
    for line in block.lines().skip(1) {
        let depth = (line.len() - line.trim_start().len()) / 2;
        let Some(name) = line.split_whitespace().next().filter(|name| name.ends_with('/')) else { continue };
        parents.truncate(depth);
        parents.push(name.to_owned());
        drawn.push(PathBuf::from(parents.concat()));
    }
    assert!(drawn.len() > 15, "the drawing was understood: {drawn:?}");
    drawn
}

/// Packages in the order of dependency.
const PACKAGES: [&str; 13] = [
    "worker/protocol",
    "orchestrator/study",
    "orchestrator/record",
    "orchestrator/import",
    "orchestrator/answers",
    "orchestrator/dev",
    "system",
    "core/numerics",
    "core/text",
    "core/model",
    "core",
    "worker",
    "orchestrator",
];

/// Folder of a drawn path: packages keep their modules in `src`.
fn real(drawn: &Path) -> PathBuf {
    let inside = |package: &&str| Some(root().join(package).join("src").join(drawn.strip_prefix(package).ok()?));
    let module = PACKAGES.iter().find_map(inside).filter(|path| path.is_dir());
    module.unwrap_or_else(|| root().join(drawn))
}

#[test]
fn every_folder_drawn_exists() {
    for folder in drawn_folders() {
        assert!(real(&folder).is_dir(), "ARCHITECTURE.md draws {}", folder.display());
    }
}

#[test]
fn every_module_folder_is_drawn() {
    let drawn: Vec<PathBuf> = drawn_folders().iter().map(|folder| real(folder)).collect();
    for package in PACKAGES {
        for entry in fs::read_dir(root().join(package).join("src")).expect("a package") {
            let path = entry.expect("readable").path();
            assert!(!path.is_dir() || drawn.contains(&path), "ARCHITECTURE.md does not draw {}", path.display());
        }
    }
}

#[test]
fn libraries_are_named_where_they_may_be() {
    // library, and the files that may name it
    let rules: [(&str, &dyn Fn(&str) -> bool); 6] = [
        ("polars", &|file| file.starts_with("orchestrator/answers/src/tables/")),
        ("iceoryx2", &|file| file.starts_with("worker/protocol/src/ipc")),
        ("mcap", &|file| file.starts_with("orchestrator/src/history/")),
        ("tokio", &|file| file.starts_with("orchestrator/src/dispatch/")),
        ("redb", &|file| file.starts_with("orchestrator/record/src/")),
        ("faer", &|file| file == "core/numerics/src/linalg/display.rs"),
    ];
    let mut seen = 0;
    for path in files(&root()).into_iter().filter(|path| path.extension().is_some_and(|end| end == "rs")) {
        let file = path.strip_prefix(root()).expect("below the root").to_string_lossy().into_owned();
        if file.contains("/tests/") || file.starts_with("tests/") || file.contains("/examples/") {
            continue;
        }
        for (library, may) in rules {
            let names = |line: &str| {
                let code = line.split("//").next().unwrap_or("");
                code.contains(&format!("{library}::")) || code.contains(&format!("{library}_"))
            };
            if fs::read_to_string(&path).expect("UTF-8").lines().any(names) {
                seen += 1;
                assert!(may(&file), "{file} names {library}");
            }
        }
    }
    assert!(seen > 5, "the libraries were found at all");
}

/// Packages, and the packages of the project on which each may depend.
const LAYERS: [(&str, &[&str]); 13] = [
    ("core/numerics", &[]),
    ("core/text", &[]),
    ("core/model", &["text"]),
    ("core", &["numerics", "text", "model"]),
    ("system", &["text"]),
    ("worker/protocol", &["model", "system"]),
    ("worker", &["text", "model", "core", "system", "protocol"]),
    ("orchestrator/study", &["numerics", "text", "model", "system"]),
    ("orchestrator/record", &["model", "system", "study"]),
    ("orchestrator/import", &["text", "model"]),
    ("orchestrator/answers", &["numerics", "text", "model", "system"]),
    (
        "orchestrator",
        &["numerics", "text", "model", "core", "system", "protocol", "worker", "study", "record", "import", "answers"],
    ),
    ("orchestrator/dev", &["model", "core", "system", "protocol", "worker", "study", "record", "answers", "bladeoff"]),
];

/// External libraries, and the packages that may depend on each.
const LIBRARIES: [(&str, &[&str]); 12] = [
    // parser of the input files, and matrices: packages that read use no matrices, packages that compute do not read
    ("toml", &["core/text", "core/model"]),
    ("nalgebra", &["core/numerics", "core"]),
    ("iceoryx2", &["worker/protocol"]),
    ("iceoryx2-bb-posix", &["worker/protocol"]),
    ("mcap", &["orchestrator"]),
    ("polars", &["orchestrator/answers"]),
    ("polars-parquet", &["orchestrator/answers"]),
    ("rayon", &["system", "orchestrator/study", "orchestrator", "orchestrator/dev"]),
    ("redb", &["orchestrator/record"]),
    ("resvg", &["orchestrator/answers"]),
    ("tokio", &["orchestrator"]),
    ("clap", &["orchestrator", "orchestrator/dev"]),
];

/// Dependencies of a package, including those for tests.
fn dependencies(package: &str) -> Vec<String> {
    let manifest = read(&format!("{package}/Cargo.toml"));
    let mut within = false;
    let mut found = Vec::new();
    for line in manifest.lines() {
        if line.starts_with('[') {
            within = line.ends_with("dependencies]");
            assert!(within || !line.contains("dependencies"), "{package}: {line} is not read by this test");
        } else if let Some(name) = line.split(['.', ' ', '=']).next().filter(|name| within && !name.is_empty()) {
            found.push(name.to_owned());
        }
    }
    assert!(!found.is_empty(), "{package} depends on something");
    found
}

#[test]
fn packages_depend_in_one_direction() {
    let members = read("Cargo.toml");
    let members = members.lines().find(|line| line.starts_with("members = ")).expect("the members");
    let members: BTreeSet<&str> = members.split('"').skip(1).step_by(2).collect();
    assert_eq!(members, LAYERS.map(|(package, _)| package).into(), "every package has its layer");
    assert_eq!(members, PACKAGES.into());
    for (package, may) in LAYERS {
        let found = dependencies(package);
        for name in found.iter().filter(|name| name.starts_with("bladeoff")) {
            let layer = name.strip_prefix("bladeoff-").unwrap_or(name);
            assert!(may.contains(&layer), "{package} depends on {name}");
        }
        for (library, packages) in LIBRARIES {
            assert!(
                !found.iter().any(|name| name == library) || packages.contains(&package),
                "{package} names {library}"
            );
        }
    }
    for (library, packages) in LIBRARIES {
        for package in packages {
            assert!(dependencies(package).iter().any(|name| name == library), "{package} has no use for {library}");
        }
    }
}

/// Module of a file below a package's `src`: `run/open.rs` is `run::open`.
fn module_of(file: &Path) -> Vec<String> {
    let mut names: Vec<String> = file.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    let last = names.pop().expect("a file");
    match last.trim_end_matches(".rs") {
        "mod" | "lib" | "main" => {}
        name => names.push(name.to_owned()),
    }
    names
}

/// Paths in a `use` tree or an expression: `a::{b, c::d}` is `a::b` and `a::c::d`.
fn leaves(tree: &str, before: &str, found: &mut Vec<String>) {
    let Some((head, group)) = tree.split_once('{') else { return found.push(format!("{before}{}", tree.trim())) };
    let (group, mut depth, mut from) = (group.strip_suffix('}').unwrap_or(group), 0, 0);
    let before = format!("{before}{}", head.trim());
    for (at, sign) in group.char_indices().chain([(group.len(), ',')]) {
        match sign {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                leaves(&group[from..at], &before, found);
                from = at + 1;
            }
            _ => {}
        }
    }
}

/// Absolute paths that a file names by `super::` and `crate::`, without its unit tests.
fn named_by(text: &str, module: &[String]) -> Vec<Vec<String>> {
    let own = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    let code: Vec<&str> = own.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
    let code = code.join(" ");
    let mut found = Vec::new();
    for start in ["super::", "crate::"] {
        for (at, _) in code.match_indices(start).filter(|(at, _)| !code[..*at].ends_with("::")) {
            let rest = &code[at..];
            let (mut depth, mut end) = (0, rest.len());
            for (at, sign) in rest.char_indices() {
                match sign {
                    '{' if rest[..at].trim_end().ends_with("::") || depth > 0 => depth += 1,
                    '}' if depth > 0 => depth -= 1,
                    ':' | '_' => {}
                    _ if depth > 0 || sign.is_alphanumeric() => {}
                    _ => {
                        end = at;
                        break;
                    }
                }
            }
            leaves(&rest[..end], "", &mut found);
        }
    }
    let absolute = |path: String| {
        let mut names: Vec<String> = path.split("::").map(|name| name.trim().to_owned()).collect();
        let mut base = if names[0] == "crate" { Vec::new() } else { module.to_vec() };
        if names[0] == "crate" {
            names.remove(0);
        }
        while names.first().is_some_and(|name| name == "super") {
            names.remove(0);
            base.pop();
        }
        base.extend(names);
        base
    };
    found.into_iter().map(absolute).collect()
}

/// Sibling files and folders form no dependency cycle, directly or through others.
#[test]
fn no_modules_name_each_other_in_a_circle() {
    let mut seen = 0;
    for package in PACKAGES {
        let source = root().join(package).join("src");
        let all: Vec<PathBuf> =
            files(&source).into_iter().filter(|path| path.extension().is_some_and(|end| end == "rs")).collect();
        let modules: BTreeSet<Vec<String>> =
            all.iter().map(|path| module_of(path.strip_prefix(&source).expect("below"))).collect();
        // dependencies between the children of each folder
        let mut edges: BTreeMap<Vec<String>, BTreeSet<(String, String)>> = BTreeMap::new();
        for path in &all {
            let module = module_of(path.strip_prefix(&source).expect("below"));
            for named in named_by(&fs::read_to_string(path).expect("UTF-8"), &module) {
                let Some(target) =
                    (0..=named.len()).rev().map(|length| &named[..length]).find(|path| modules.contains(*path))
                else {
                    continue;
                };
                let common = module.iter().zip(target).take_while(|(a, b)| a == b).count();
                if let (Some(from), Some(to)) = (module.get(common), target.get(common)) {
                    edges.entry(module[..common].to_vec()).or_default().insert((from.clone(), to.clone()));
                    seen += 1;
                }
            }
        }
        for (folder, edges) in edges {
            let mut left = edges.clone();
            // modules without dependencies on remaining ones are in no cycle
            loop {
                let naming: BTreeSet<String> = left.iter().map(|(from, _)| from.clone()).collect();
                let before = left.len();
                left.retain(|(_, to)| naming.contains(to));
                if left.len() == before {
                    break;
                }
            }
            assert!(left.is_empty(), "{package}, {}: in a circle: {left:?}", folder.join("::"));
        }
    }
    assert!(seen > 300, "names were found at all: {seen}");
}

/// Modules of the exponential engine: each names only itself and the modules before it.
const ROOMS: [&str; 5] = ["modal", "torsion", "contact", "stepping", "observe"];

#[test]
fn rooms_of_the_exponential_engine_use_each_other_in_one_direction() {
    let engine = root().join("core/src/engine/exponential");
    let folders =
        fs::read_dir(&engine).expect("the engine").filter(|entry| entry.as_ref().expect("readable").path().is_dir());
    assert_eq!(folders.count(), ROOMS.len(), "every folder of the engine is a room");
    let mut seen = 0;
    for (at, room) in ROOMS.iter().enumerate() {
        for path in files(&engine.join(room)) {
            let module: Vec<String> = ["engine", "exponential", room].iter().map(|&name| name.to_owned()).collect();
            let file = path.file_stem().expect("a name").to_string_lossy().into_owned();
            let module = if file == "mod" { module } else { [module, vec![file]].concat() };
            for named in named_by(&fs::read_to_string(&path).expect("UTF-8"), &module) {
                if let ["engine", "exponential", other, ..] = named.iter().map(String::as_str).collect::<Vec<_>>()[..] {
                    assert!(!ROOMS[at + 1..].contains(&other), "{}: {room} names {other}", path.display());
                    seen += usize::from(other != *room);
                }
            }
        }
    }
    assert!(seen > 40, "rooms name each other: {seen}");
}

#[test]
fn no_source_file_is_too_long() {
    for path in files(&root()).into_iter().filter(|path| path.extension().is_some_and(|end| end == "rs")) {
        let lines = fs::read_to_string(&path).expect("UTF-8").lines().count();
        assert!(lines <= 500, "{} has {lines} lines", path.display());
    }
}

/// The end-to-end tests lie beside the packages, where cargo finds no target: each folder with a `main.rs` is declared in a manifest, and each
/// source file in it by its parent module.
#[test]
fn every_file_of_tests_belongs_to_a_target() {
    let manifests: String = PACKAGES.iter().map(|package| read(&format!("{package}/Cargo.toml"))).collect();
    let folders = ["program", "faults", "processes"];
    for entry in fs::read_dir(root().join("tests")).expect("readable") {
        let path = entry.expect("readable").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        assert!(path.is_dir() && path.join("main.rs").is_file() == folders.contains(&&*name), "tests/{name}");
    }
    let mut seen = 0;
    for folder in folders {
        let main = format!("tests/{folder}/main.rs");
        assert!(manifests.contains(&format!("{main}\"")), "no package runs {main}");
        let root = root().join("tests").join(folder);
        for path in files(&root).into_iter().filter(|path| path.extension().is_some_and(|end| end == "rs")) {
            let module = module_of(path.strip_prefix(&root).expect("below"));
            let Some((name, parents)) = module.split_last() else { continue };
            let parent =
                if parents.is_empty() { main.clone() } else { format!("tests/{folder}/{}/mod.rs", parents.join("/")) };
            assert!(
                read(&parent).lines().any(|line| line == format!("mod {name};")),
                "{parent} does not declare {name}"
            );
            seen += 1;
        }
    }
    assert!(seen > 50, "sources were found: {seen}");
}

/// A published package contains only its own files; links are replaced by their targets. Unit tests run in the repository.
#[test]
fn packages_read_only_their_own_files() {
    let owner = |path: &Path| PACKAGES.into_iter().find(|package| path.starts_with(package));
    let mut seen = 0;
    for package in PACKAGES.into_iter().filter(|package| *package != "orchestrator/dev") {
        for path in files(&root().join(package).join("src")) {
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            if !name.ends_with(".rs") || name.ends_with("tests.rs") {
                continue;
            }
            let text = fs::read_to_string(&path).expect("UTF-8");
            let own = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
            let calls = own.split("include_").filter(|rest| rest.starts_with("str!(") || rest.starts_with("bytes!("));
            for included in calls.filter_map(|rest| rest.split('"').nth(1)) {
                let mut place = path.parent().expect("a folder").strip_prefix(root()).expect("below").to_path_buf();
                for part in included.split('/') {
                    match part {
                        ".." => assert!(place.pop(), "{included}"),
                        part => place.push(part),
                    }
                }
                assert!(root().join(&place).is_file(), "{}: {included}", path.display());
                assert_eq!(owner(&place), Some(package), "{} reads {included}", path.display());
                seen += 1;
            }
        }
    }
    assert!(seen > 8, "files were included: {seen}");
}

#[test]
fn studies_that_are_shipped_are_valid() {
    for entry in fs::read_dir(root().join("studies")).expect("the studies") {
        let path = entry.expect("readable").path();
        if path.extension().is_some_and(|end| end == "toml") {
            let file = path.to_str().expect("UTF-8");
            let said = say(&["check", file, "--list"]);
            assert_eq!(said.code, 0, "{file}: {}", said.err);
            let first = fs::read_to_string(&path).expect("UTF-8").lines().next().unwrap_or_default().to_owned();
            assert!(first.starts_with("# Question: "), "{file} begins with its question");
        }
    }
}

#[test]
fn the_readme_names_the_two_commands_and_ci_runs_its_test_command() {
    let readme = read("README.md");
    assert!(readme.contains("cargo run --release -- run studies/first-look.toml"));
    let test = "cargo test --release --workspace";
    assert!(readme.lines().any(|line| line.trim() == test));
    let ci = read(".ci/run");
    assert!(ci.lines().any(|line| line.trim_start().starts_with(test)), ".ci/run runs the README's test command");
}
