//! Messages between orchestrator and workers, and the transports that carry them.
//!
//! A worker asks for work, the orchestrator answers with a batch of samples; the worker reports results and asks again (pull). A worker has at
//! most one open request, so no queue can fill. [`messages`] are fixed-size blocks of 64-bit words with a magic number, a version, their
//! run and a checksum; the reader copies a block out of shared memory and checks all of it before creating a Rust value. [`transport`]
//! carries blocks: [`ipc`] over iceoryx2 between processes, other transports in tests. [`link`] combines both: typed messages over any
//! transport. [`beat`] is the heartbeat, a few bytes through a pipe, so that it does not depend on the memory that it monitors. [`domain`]
//! manages the shared memory of a run and its removal.

pub mod beat;
mod bus;
pub mod domain;
mod domain_error;
pub mod ipc;
mod ipc_domain;
mod ipc_hub;
mod ipc_services;
mod ipc_worker;
mod limits;
pub mod link;
pub mod messages;
mod names;
mod owner;
pub mod runtime;
mod shm;
pub mod transport;
pub mod unfinished;
