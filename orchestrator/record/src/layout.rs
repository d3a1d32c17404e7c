//! Tables of the store.

use redb::TableDefinition;

pub(super) const RESULTS: TableDefinition<u64, &[u8]> = TableDefinition::new("results");
pub(super) const HEADER: TableDefinition<&str, &str> = TableDefinition::new("header");

/// Version of the store's layout.
pub const RECORD_VERSION: u32 = 4;
pub(super) const VERSION_KEY: &str = "ledger_version";
/// Memory for the store's page cache \[bytes\]. Entries are written and read in order, so a small cache is enough.
pub(super) const CACHE_BYTES: usize = 32 << 20;
