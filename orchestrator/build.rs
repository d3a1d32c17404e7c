//! The commit that the program is built from, for `--version` and `manifest.json`: in a clone from `git`, if that is there, in an
//! unpacked archive from the environment variable `BLADEOFF_COMMIT`; otherwise `unknown`.
//!
//! It is that of the last build of changed sources: a commit that changes no source makes nothing be compiled again, hence
//! `git`'s own files are not watched. After edit, build and commit the program so says `modified`, as it was when it was built.

use std::path::Path;
use std::process::Command;

/// What the program is made of, seen from the repository.
const SOURCES: [&str; 6] = ["system", "core", "worker", "orchestrator", "Cargo.toml", "Cargo.lock"];

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for source in [
        "system/src",
        "core/numerics/src",
        "core/text/src",
        "core/model/src",
        "core/src",
        "worker/src",
        "worker/protocol/src",
        "orchestrator/study/src",
        "orchestrator/record/src",
        "orchestrator/answers/src",
        "orchestrator/src",
        "Cargo.lock",
    ] {
        println!("cargo::rerun-if-changed={}", root.join(source).display());
    }
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=BLADEOFF_COMMIT");
    let given = std::env::var("BLADEOFF_COMMIT").ok().filter(|text| is_plain(text));
    let commit = given.or_else(|| commit(&root)).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo::rustc-env=BLADEOFF_BUILT_FROM={commit}");
}

fn is_plain(text: &str) -> bool {
    !text.is_empty() && text.len() <= 64 && text.chars().all(|c| c.is_ascii_alphanumeric() || " .+-_".contains(c))
}

fn commit(root: &Path) -> Option<String> {
    // An archive unpacked in somebody's own repository is no part of that.
    git(root, &["ls-files", "--error-unmatch", "orchestrator/build.rs"])?;
    let commit = git(root, &["rev-parse", "--short=10", "HEAD"])?;
    let mut asked = vec!["status", "--porcelain", "--untracked-files=normal", "--"];
    asked.extend(SOURCES);
    let changed = !git(root, &asked)?.is_empty();
    Some(if changed { format!("{commit} modified") } else { commit }).filter(|text| is_plain(text))
}

fn git(root: &Path, arguments: &[&str]) -> Option<String> {
    // Nothing is locked: a `git` of the user's goes on undisturbed.
    let output = Command::new("git").arg("--no-optional-locks").arg("-C").arg(root).args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
