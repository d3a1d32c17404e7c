//! Which worker computes which sample when: a state machine without clock, files, processes.
//!
//! Time is an argument and effects are return values, so that thousands of random histories can be played through it
//! (the tests of `histories`); [`dispatch`](crate::dispatch) plays the real one. In words:
//!
//! **Samples.** A sample is always in exactly one place: not yet assigned ([`Todo`], ranges, so that a million cost
//! nothing), to be retried, in work with one worker, or done. It leaves `in work` by a result of that worker for that batch and
//! attempt, which is recorded, by the worker's end, which sends it to be retried, or by being taken back, as if it had never been assigned. Any other result is late, doubled
//! or a lie: it is counted and dropped. So every sample is recorded once.
//!
//! **Workers.** There are as many slots as workers asked for. The worker of a slot is `Starting` until it asks for work, then
//! `Idle` or `Busy`, and at last `Leaving`; when its process has ended, the slot is `Gone` until a new worker with
//! a new number is started, at once after the first death and after a growing pause when deaths follow each other. When worker
//! after worker dies before it ever asks, the run is given up: its message is in the log.
//!
//! **Batches.** A worker gets as many samples as it computes in about `BATCH_TARGET`, measured on
//! those before, and fewer towards the end, so that all finish together. When a worker has nothing to do, what waits with another behind a
//! sample that takes long is taken back and assigned anew (`work_stealing`). How samples are batched changes no result.
//!
//! **Deaths.** When a worker ends without having been told to, its unfinished samples are retried one by one, before
//! new ones. Only the death of a worker that had a single sample from the start counts against that sample. At so many crashes (it ended by
//! itself, or was killed for the time or memory that the sample takes) or kills (a signal of somebody else, or it was stopped until it
//! was replaced) as [`SampleLimits`](bladeoff_study::SampleLimits) says it is quarantined. So a sample that kills its worker is found, its
//! neighbours in the batch are not blamed, and an operator or a lack of memory has to come back many times before it costs a row. What that
//! quarantined in an earlier run is a suspect: tried after all others, alone, and until the first kill.
//!
//! **Watching.** Time is attended time: a gap between two events longer than `LONGEST_STEP` means that
//! we were stopped ourselves (or the machine slept) and counts as that long only, so nobody is called late for our own absence.
//! A worker not heard of for `stale_after` is shown as stale, after `replace_after` it is killed. One whose heartbeats say
//! that it waits while a batch of it is open has missed a message and is killed as well; that counts against nobody. A sample whose
//! heartbeats show it in work for longer than the time limit has its worker killed, which counts like a death.
//!
//! **More.** A run that is fed gets its samples bit by bit: it asks for more when what waits is done within moments, and is complete when there
//! are no more (`feeding`).
//!
//! **Ending.** When all samples are done, idle workers are told to stop. On a signal, at a limit of the run ([`RunLimits`]: time, clock, failures) no sample is
//! assigned any more, reports are answered by the order to stop, and what is not finished after `grace` is killed.

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
