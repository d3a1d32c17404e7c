//! Which program this is: version, commit, numerics and the revision of the exponential engine.

use bladeoff_core::NUMERICS_VERSION;
use bladeoff_core::engine::exponential::EXPONENTIAL_REVISION;
use bladeoff_study::Versions;
use std::sync::LazyLock;

/// The commit of the sources, with ` modified` after it if they were changed since; `unknown` where it cannot be known
/// (`build.rs` says how it is found).
pub const COMMIT: &str = env!("BLADEOFF_BUILT_FROM");

/// Versions of the results of this build.
pub const VERSIONS: Versions = Versions { numerics: NUMERICS_VERSION, exponential: EXPONENTIAL_REVISION };

/// Shown by `bladeoff --version` behind the name.
pub static VERSION: LazyLock<String> =
    LazyLock::new(|| format!("{} (commit {COMMIT}, {})", env!("CARGO_PKG_VERSION"), numerics()));

/// Versions that results depend on beside their inputs: "numerics 5, exponential engine 15".
#[must_use]
pub fn numerics() -> String {
    format!("numerics {NUMERICS_VERSION}, exponential engine {EXPONENTIAL_REVISION}")
}
