//! Beyond one machine: a study in shards, each an ordinary run on one node, by a directory that all of them share.
//!
//! ```text
//! freeze:   inputs, basis, plan, chunk -> shards.json                      once, by whoever is first     freeze, frozen, published
//! shard:    which chunk next -> run with its own record in scratch -> chunk -> link(2)                   choose, shard, publisher
//! merge:    every chunk checked -> results.parquet, the bytes of one machine                             merge
//! look:     chunks on disk, attempts; rows of chunks as parts                                            see, rows
//! ```
//! Nothing here talks over a network, and no lock on the shared disk is trusted. Whoever computes a chunk, however often and on however many
//! nodes at once, whoever comes first publishes it, and all others drop theirs: equal keys, equal outcomes. A scheduler says who runs;
//! what is done is known by the chunks alone.

mod attempt;
mod begin;
mod choose;
mod chunk;
mod error;
mod freeze;
mod frozen;
mod given;
mod layout;
mod leftovers;
mod measure;
mod merge;
mod patience;
mod publish;
mod published;
mod publisher;
mod rows;
mod see;
mod shard;
mod shared;
#[cfg(test)]
mod simulation;
mod stop;
mod takeover;
mod wrong;

pub use attempt::AttemptSeen;
pub use begin::{begin, shards_to_do};
pub use error::ShardError;
pub use freeze::restore;
pub use given::{cores, memory_of_worker};
pub use layout::{MOST_SHARDS, SCHEDULER, SHARDS, Shard};
pub use merge::{Merged, merge};
pub use rows::{forget, is_unmerged, row_files, timing_files, unread};
pub use see::{ShardsSeen, samples_of, see, see_shards, verify_chunks};
pub use shard::{ShardFinished, ShardRequest, run_shard};
