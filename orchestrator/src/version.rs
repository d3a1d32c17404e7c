//! Which program this is: version, commit, numerics.

use bladeoff_core::NUMERICS_VERSION;
use std::sync::LazyLock;

/// The commit of the sources, with ` modified` after it if they were changed since; `unknown` where it cannot be known
/// (`build.rs` says how it is found).
pub const COMMIT: &str = env!("BLADEOFF_BUILT_FROM");

/// Shown by `bladeoff --version` behind the name.
pub static VERSION: LazyLock<String> =
    LazyLock::new(|| format!("{} (commit {COMMIT}, numerics {NUMERICS_VERSION})", env!("CARGO_PKG_VERSION")));
