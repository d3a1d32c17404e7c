//! Messages between orchestrator and workers, and the transports that carry them.
//!
//! A worker asks for work, the orchestrator answers with a batch of samples; the worker reports results and asks again
//! (pull). A worker never has more than one request open, so no queue can fill. [`messages`] are fixed-size blocks of
//! 64-bit words with a magic number, a version, the run they belong to and a checksum; the reader copies a block out of
//! shared memory, checks everything and only then sees a Rust type. [`transport`] carries blocks:
//! [`ipc`] over iceoryx2 between processes, others in the tests. [`link`] joins the two: typed messages over any transport.
//! [`beat`] is the heartbeat, a few bytes through a pipe, so that it does not depend on what it watches. [`domain`] is
//! where a run's shared memory lives and how it is cleaned.

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
