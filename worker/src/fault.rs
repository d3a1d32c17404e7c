//! Points at which a test may disturb the program: the program reports them, and a value that the binary passes in acts.
//!
//! `bladeoff` passes [`NoFaults`]. The binary of the developers' tools passes faults that a test describes in the environment, and starts
//! the same library with them.

use std::fmt::Debug;

/// State of a sample, or of the files of a run, at which a fault may act.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum At {
    /// The sample is in a batch that was received or assigned.
    Claimed,
    /// The sample has begun.
    Running,
    /// The sample's result was sent or received.
    Sent,
    /// The sample's result is durable.
    Recorded,
    /// Rows for an interim analysis are ready; the number of rows takes the place of the sample.
    Looking,
    /// All samples of the run are recorded, the tables are written next; always sample 0.
    Writing,
    /// The sample was copied into a new record.
    Growing,
    /// A partial table is written and has no name yet; the number of the part takes the place of the sample.
    Parting,
    /// The partial table has its name; the number of the part takes the place of the sample.
    Parted,
    /// New partial tables are about to replace the old ones; always sample 0.
    Swapping,
    /// The table has its name, the partial tables are removed next; always sample 0.
    Retiring,
}

/// Faults of one process.
pub trait Faults: Debug + Sync {
    /// Whether no state has a fault. The caller then keeps no list of samples for [`reached`](Faults::reached).
    fn is_empty(&self) -> bool;

    /// Called when a sample is at a state. `worker`: in the orchestrator, the process id of the worker that computes the sample.
    fn reached(&self, at: At, sample: u64, worker: Option<u32>);
}

/// No faults: every state passes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct NoFaults;

impl Faults for NoFaults {
    fn is_empty(&self) -> bool {
        true
    }

    fn reached(&self, _: At, _: u64, _: Option<u32>) {}
}
