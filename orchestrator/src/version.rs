//! Version of the program: version number, commit, numerics and revision of the exponential engine.

use bladeoff_core::NUMERICS_VERSION;
use bladeoff_core::engine::exponential::EXPONENTIAL_REVISION;
use bladeoff_study::Versions;
use std::sync::LazyLock;

/// Commit of the sources, followed by ` modified` if they were changed since; `unknown` if it cannot be determined (see `build.rs`).
pub const COMMIT: &str = env!("BLADEOFF_BUILT_FROM");

/// Versions that determine the results of this build.
pub const VERSIONS: Versions = Versions { numerics: NUMERICS_VERSION, exponential: EXPONENTIAL_REVISION };

/// Output of `bladeoff --version` behind the name.
pub static VERSION: LazyLock<String> =
    LazyLock::new(|| format!("{} (commit {COMMIT}, {})", env!("CARGO_PKG_VERSION"), numerics()));

/// Versions that results depend on besides their inputs: "numerics 5, exponential engine 15".
#[must_use]
pub fn numerics() -> String {
    format!("numerics {NUMERICS_VERSION}, exponential engine {EXPONENTIAL_REVISION}")
}
