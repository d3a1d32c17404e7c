//! Signals to the orchestrator as events.

use tokio::signal::unix::{Signal as Stream, SignalKind, signal};
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};

use super::error::DispatchError;
use super::event::Event;
use super::preparation;
use crate::schedule::Signal;
use bladeoff_system::guarded::guarded;

/// Passes each signal to `on_signal` on a thread of its own until a run handles signals.
pub fn watch_before(on_signal: impl Fn(Signal) + Send + 'static) {
    watch_afterwards(move |signal| {
        if preparation::end() {
            on_signal(signal);
        }
    });
}

/// Turns SIGINT, SIGTERM, SIGHUP (unless it is ignored, as under nohup) and SIGUSR1 into events until the receiver is gone.
pub(super) fn watch(events: &UnboundedSender<Event>) -> Result<(), DispatchError> {
    forward(SignalKind::interrupt(), events, || Event::Signal(Signal::Interrupt))?;
    forward(SignalKind::terminate(), events, || Event::Signal(Signal::Terminate))?;
    if !is_ignored(SignalKind::hangup()) {
        forward(SignalKind::hangup(), events, || Event::Signal(Signal::Terminate))?;
    }
    forward(SignalKind::user_defined1(), events, || Event::Asked)
}

/// Passes each further signal to `on_signal` on a thread of its own, from the end of a run to the end of the process. Otherwise
/// the signals would be ignored.
pub fn watch_afterwards(on_signal: impl Fn(Signal) + Send + 'static) {
    let (listening, listens) = std::sync::mpsc::channel::<()>();
    let body = move || {
        let Ok(runtime) = tokio::runtime::Builder::new_current_thread().enable_all().build() else { return };
        let (send, mut events) = unbounded_channel();
        runtime.block_on(async {
            // if no more files can be opened, the library panics
            if !matches!(guarded(|| watch(&send)), Some(Ok(()))) {
                return;
            }
            drop(listening);
            while let Some(event) = events.recv().await {
                if let Event::Signal(signal) = event {
                    on_signal(signal);
                }
            }
        });
    };
    // Without the thread signals are ignored until the tables are written.
    let _ = std::thread::Builder::new().name("signals".into()).spawn(body);
    // a signal that arrives after this call finds its handler; the thread drops the sender in every case
    let _ = listens.recv();
}

fn forward(kind: SignalKind, events: &UnboundedSender<Event>, event: fn() -> Event) -> Result<(), DispatchError> {
    let mut stream: Stream =
        signal(kind).map_err(|source| DispatchError::System { doing: "listening for signals", source })?;
    let events = events.clone();
    tokio::spawn(async move { while stream.recv().await.is_some() && events.send(event()).is_ok() {} });
    Ok(())
}

/// Whether this process was started with the signal ignored, by the mask in /proc.
fn is_ignored(kind: SignalKind) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (kind.as_raw_value() - 1) & 1 == 1)
}
