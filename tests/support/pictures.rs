//! Assertions about figures that commands write.

use std::fs;
use std::path::Path;

/// Asserts that a figure exists in both formats, with its labels.
pub fn assert_figure(directory: &Path, name: &str, labels: &[&str]) {
    let svg =
        fs::read_to_string(directory.join(format!("{name}.svg"))).unwrap_or_else(|error| panic!("{name}: {error}"));
    for label in labels {
        assert!(svg.contains(label), "{name} has no {label:?}");
    }
    let png = fs::read(directory.join(format!("{name}.png"))).expect("the PNG beside it");
    assert!(png.starts_with(b"\x89PNG") && png.len() > 10_000, "{name}: {} bytes", png.len());
}

/// A path as an argument.
pub fn text(path: &Path) -> String {
    path.display().to_string()
}
