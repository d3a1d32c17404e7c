//! Assignment of samples to workers: a state machine without clock, files or processes.
//!
//! Time is an argument and effects are return values, so that the tests of `histories` can play thousands of random histories;
//! [`dispatch`](crate::dispatch) connects it to real processes.
//!
//! **Samples.** A sample is always in exactly one state: not yet assigned ([`Todo`], stored as ranges, so that a million samples need no
//! memory), to be retried, assigned to one worker, or done. An assigned sample changes its state by a result of that worker for that batch and
//! attempt, which is recorded; by the end of the worker, which sends it to be retried; or by being taken back, as if it had never been
//! assigned. Any other result (late, duplicated or wrong) is counted and discarded. Every sample is therefore recorded once.
//!
//! **Workers.** There are as many slots as requested workers. The worker of a slot is `Starting` until it requests work, then `Idle` or
//! `Busy`, and finally `Leaving`. When its process has ended, the slot is `Gone` until a new worker with a new number is started: immediately
//! after the first death, after a growing pause when deaths follow each other. The run is given up if one worker after another dies before it
//! requests work; the reason is in the log.
//!
//! **Batches.** A worker gets as many samples as it computes in about `BATCH_TARGET`, by the measured time of previous samples, and fewer
//! towards the end, so that all workers finish together. If a worker has nothing to do, samples that wait behind a long sample of another
//! worker are taken back and assigned again (`work_stealing`). Batching does not affect the results.
//!
//! **Deaths.** When a worker ends without an order to stop, its unfinished samples are retried one by one, before new ones. A death counts
//! against a sample only if the worker had that single sample from the start. The sample is quarantined after the number of crashes (the
//! worker ended on its own, or was killed for the time or memory of the sample) or kills (a signal of another process, or the worker was
//! stopped until it was replaced) given by [`SampleLimits`](bladeoff_study::SampleLimits). A sample that kills its worker is thus found, the
//! other samples of its batch are not affected, and kills by an operator or a lack of memory must recur many times before they cost a row.
//! A sample quarantined because of kills in an earlier run is a suspect: it is tried after all others, alone, until the first kill.
//!
//! **Watching.** Time is attended time: a gap between two events longer than `LONGEST_STEP` means that this process was stopped (or the
//! machine slept) and counts as `LONGEST_STEP` only, so that no worker appears late because of it. A worker without a message for
//! `stale_after` is shown as stale; after `replace_after` it is killed. A worker whose heartbeats report waiting while it has a batch has
//! missed a message and is killed as well, which counts against no sample. A worker whose heartbeats show the same sample for longer than the
//! time limit is killed, which counts like a death.
//!
//! **Feeding.** A fed run gets its samples in portions: it requests more shortly before the waiting ones are done, and is complete when there
//! are no more (`feeding`).
//!
//! **Ending.** When all samples are done, idle workers get the order to stop. After a signal, or at a limit of the run ([`RunLimits`]: time, clock,
//! failures), no more samples are assigned, reports are answered by the order to stop, and workers that are not finished after `grace` are
//! killed.

mod batch;
mod clock;
mod counts;
mod ended;
mod ending;
mod feeding;
#[cfg(test)]
mod histories;
#[cfg(test)]
mod makespan;
mod queue;
mod rate;
mod scheduler;
mod settings;
#[cfg(test)]
mod simulation;
mod slot;
mod snapshot;
mod todo;
mod until;
mod work_stealing;
mod workers;

pub use ended::{Ended, Signal};
pub use scheduler::Scheduler;
pub use settings::{RunLimits, Settings};
pub use slot::{Death, Effect, KillReason, Trouble};
pub use snapshot::{Activity, Snapshot, WorkerView};
pub use todo::Todo;
pub use until::{Moment, TimeOfDay, TimeOfDayError, Until};
