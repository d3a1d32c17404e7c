//! Preparation of a run, until its workers are started. A signal or a limit of the run ends it.

use super::clock;
use crate::schedule::{Ended, RunLimits};
use std::sync::atomic::{AtomicU8, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Time that a preparation has after a limit of the run is reached.
const GRACE: Duration = Duration::from_secs(5);
/// Interval of clock readings.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// Preparation.
const PREPARES: u8 = 0;
/// Complete study: limits of the run do not count, signals do.
const COMPLETE: u8 = 1;
/// Run that handles signals and limits itself.
const COMPUTES: u8 = 2;
/// The process ends.
const ENDS: u8 = 3;

static STATE: AtomicU8 = AtomicU8::new(PREPARES);

fn change(from: u8, to: u8) -> bool {
    STATE.compare_exchange(from, to, Ordering::SeqCst, Ordering::SeqCst).is_ok()
}

/// Begins the run. Does not return if the process is already ending.
pub(super) fn is_over() {
    if !change(PREPARES, COMPUTES) && !change(COMPLETE, COMPUTES) {
        while STATE.load(Ordering::SeqCst) == ENDS {
            thread::park();
        }
    }
}

/// Marks the study as complete: no limit ends the remaining work.
pub fn nothing_to_compute() {
    change(PREPARES, COMPLETE);
}

/// Whether the caller must end the process, because no run computes yet.
pub(super) fn end() -> bool {
    change(PREPARES, ENDS) || change(COMPLETE, ENDS)
}

/// Ends a preparation that lasts longer than a limit of the run allows: 5 s after the limit `on_end` is called, on a thread of its
/// own, unless a run computes by then. `begun`: when the time of `wall` began.
pub fn limit_preparation(begun: Instant, mut limits: RunLimits, on_end: impl FnOnce(Ended) + Send + 'static) {
    if limits.wall.is_none() && limits.until.is_none() {
        return;
    }
    let mut reached = move || {
        let is_past = |wall: Duration| begun.elapsed() >= wall;
        match &mut limits.until {
            _ if limits.wall.is_some_and(is_past) => Some(Ended::Wall),
            Some(until) => until.is_reached(clock::now()).then_some(Ended::Until),
            None => None,
        }
    };
    let body = move || {
        let mut past: Option<(Instant, Ended)> = None;
        while STATE.load(Ordering::SeqCst) == PREPARES {
            past = past.or_else(|| reached().map(|why| (Instant::now(), why)));
            match past {
                Some((since, why)) if since.elapsed() >= GRACE => {
                    if change(PREPARES, ENDS) {
                        on_end(why);
                    }
                    return;
                }
                _ => thread::sleep(LOOK_EVERY),
            }
        }
    };
    // without the thread the run itself ends by its limit, once it is prepared
    let _ = thread::Builder::new().name("limits".into()).spawn(body);
}
