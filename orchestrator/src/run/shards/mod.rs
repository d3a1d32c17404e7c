//! Studies on several machines: shards, each an ordinary run on one node, with a shared directory.
//!
//! ```text
//! freeze:   inputs, basis, plan, chunk size -> shards.json, once, by the first process      freeze, shards_file, published
//! shard:    next chunk -> run with its own record in scratch -> chunk -> link(2)            choose, shard, publisher
//! merge:    every chunk checked -> results.parquet, the bytes of one machine                merge
//! status:   chunks on disk, attempts; rows of chunks as parts                               shards_status, rows
//! ```
//! No network messages, and no locks on the shared disk. Several nodes may compute the same chunk: the first one publishes it and
//! the others discard their copies, which is harmless because equal keys give equal outcomes. The scheduler determines which
//! tasks run; only the chunks determine what is done.

mod attempt;
mod begin;
mod choose;
mod chunk;
mod chunk_problems;
mod error;
mod freeze;
mod layout;
mod leftovers;
mod measure;
mod merge;
mod publish;
mod published;
mod publisher;
mod retry;
mod rows;
mod scheduler_resources;
mod shard;
mod shards_file;
mod shards_status;
mod shared;
#[cfg(test)]
mod simulation;
mod stop;
mod takeover;

pub use attempt::AttemptStatus;
pub use begin::{begin, shards_to_do};
pub use error::ShardError;
pub use freeze::restore;
pub use layout::{MOST_SHARDS, SCHEDULER, SHARDS, Shard};
pub use merge::{Merged, merge};
pub use rows::{forget, is_unmerged, row_files, timing_files, unread};
pub use scheduler_resources::{cores, memory_of_worker};
pub use shard::{ShardFinished, ShardRequest, run_shard};
pub use shards_status::{ShardsStatus, directory_status, samples_of, shards_status, verify_chunks};
