//! Messages during long work without visible progress: matrices and modes of a large ring take half a minute.

use bladeoff_answers::summary::duration;
use bladeoff_model::machine::{DiaphragmKind, Machine};
use bladeoff_text::document::visible;
use std::io::Write;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Time after which the first message is printed.
const FIRST_AFTER: Duration = Duration::from_secs(2);
/// Time between two messages.
const AGAIN_EVERY: Duration = Duration::from_secs(30);

/// Runs `work`; while it takes long, prints `what()` and the elapsed time on standard error.
pub fn with_word<T>(what: impl Fn() -> String + Send, work: impl FnOnce() -> T) -> T {
    let say = move |elapsed| {
        // a closed standard error does not stop the work
        let _ = writeln!(std::io::stderr(), "{}: {} so far", visible(&what()), duration(elapsed));
    };
    watched([FIRST_AFTER, AGAIN_EVERY], say, work)
}

/// Description of the computation before the first step of a machine.
#[must_use]
pub fn matrices_of(machine: &Machine) -> String {
    let elements = machine.diaphragms.iter().filter_map(|diaphragm| match &diaphragm.kind {
        DiaphragmKind::Flexible(stator) => Some(stator.ring.elements),
        DiaphragmKind::Rigid | DiaphragmKind::RadialSpring { .. } => None,
    });
    let ring = elements.max().map(|count| format!(", its ring of {count} elements")).unwrap_or_default();
    format!("computing the matrices and modes of {}{ring}", machine.name)
}

/// Runs `work`; calls `say` after the time `first`, and then at intervals of `again`.
fn watched<T>([first, again]: [Duration; 2], say: impl Fn(Duration) + Send, work: impl FnOnce() -> T) -> T {
    let (done, over) = channel::<()>();
    thread::scope(move |scope| {
        let begun = Instant::now();
        let watch = move || {
            let mut wait = first;
            while over.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
                say(begun.elapsed());
                wait = again;
            }
        };
        // if no thread can be started, the work runs without messages
        let _ = thread::Builder::new().spawn_scoped(scope, watch);
        let result = work();
        // also dropped by a panic of the work: the thread always ends
        drop(done);
        result
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::mpsc::sync_channel;

    #[test]
    fn long_work_has_a_word_again_and_again_and_short_work_none() {
        let (said, words) = sync_channel(0);
        let brief = Duration::from_millis(1);
        let result = watched(
            [brief, brief],
            |elapsed| {
                let _ = said.send(elapsed);
            },
            || {
                let [first, second] = [words.recv().expect("a word"), words.recv().expect("another")];
                assert!(second > first && first >= brief);
                drop(words);
                7
            },
        );
        assert_eq!(result, 7);
        let hour = Duration::from_secs(3600);
        assert_eq!(watched([hour, hour], |_| panic!("a word about nothing"), || 8), 8);
    }

    #[test]
    fn work_that_panics_does_so_at_once() {
        let hour = Duration::from_secs(3600);
        let work = || watched([hour, hour], |_| (), || panic!("as it should"));
        assert!(catch_unwind(AssertUnwindSafe(work)).is_err());
    }
}
