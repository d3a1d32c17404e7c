//! Worker process: start, output, end.

use std::os::unix::process::ExitStatusExt;
use std::process::{ExitStatus, Stdio};
use std::time::Duration;

use bladeoff_protocol::beat::{BEAT_BYTES, Beat};
use bladeoff_protocol::messages::WorkerId;
use bladeoff_worker::WorkerArgs;
use bladeoff_worker::process::OUT_OF_MEMORY_WORDS;
use tokio::io::{AsyncBufReadExt, AsyncReadExt, BufReader};
use tokio::process::{ChildStderr, ChildStdout, Command};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use super::api::DispatchOptions;
use super::error::DispatchError;
use super::event::{ChildEvent, Event};
use super::log::LONGEST_LINE;
use crate::schedule::Death;

/// Time for which the output of an ended worker is read.
const LAST_WORDS: Duration = Duration::from_secs(2);

/// Handle of the loop to a worker process; dropping it kills the process.
pub(super) struct Child {
    pub pid: u32,
    kill: UnboundedSender<()>,
}

impl Child {
    /// Starts a worker in its own process group, so that Ctrl-C in a terminal reaches only the orchestrator.
    pub fn start(
        options: &DispatchOptions,
        args: &WorkerArgs,
        events: &UnboundedSender<Event>,
    ) -> Result<Self, DispatchError> {
        let mut words = options.worker_command.iter();
        let program = words.next().cloned().unwrap_or_default();
        let failed = |source| DispatchError::Spawn { program: program.clone().into(), source };
        let mut child = Command::new(&program)
            .arg0("bladeoff")
            .args(words)
            .args(args.to_args())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .process_group(0)
            .kill_on_drop(true)
            .spawn()
            .map_err(failed)?;
        let missing = || failed(std::io::ErrorKind::BrokenPipe.into());
        let pid = child.id().ok_or_else(missing)?;
        let (stdout, stderr) = (child.stdout.take().ok_or_else(missing)?, child.stderr.take().ok_or_else(missing)?);
        let (kill, killed) = unbounded_channel();
        let (worker, events) = (args.worker, events.clone());
        tokio::spawn(supervise(worker, child, stdout, stderr, killed, events));
        Ok(Self { pid, kill })
    }

    /// Kills the process; its end comes as an event.
    pub fn kill(&self) {
        // Fails if the process has already ended.
        let _ = self.kill.send(());
    }
}

async fn supervise(
    worker: WorkerId,
    mut child: tokio::process::Child,
    stdout: ChildStdout,
    stderr: ChildStderr,
    mut killed: UnboundedReceiver<()>,
    events: UnboundedSender<Event>,
) {
    let beats = tokio::spawn(read_beats(worker, stdout, events.clone()));
    let words = tokio::spawn(read_lines(worker, stderr, events.clone()));
    let status = tokio::select! {
        status = child.wait() => status,
        // Also if the loop has dropped the child.
        _ = killed.recv() => {
            let _ = child.start_kill();
            child.wait().await
        }
    };
    let out_of_memory = match tokio::time::timeout(LAST_WORDS, words).await {
        Ok(Ok(out_of_memory)) => out_of_memory,
        _ => false,
    };
    beats.abort();
    // Waiting for a child of this process cannot fail; if it does, the worker is treated as ended.
    let status = status.unwrap_or_default();
    let death = Death { out_of_memory, from_outside: is_from_outside(status) };
    let _ = events.send(Event::Child(worker, ChildEvent::Exited(status, death)));
}

/// Whether another process ended it by a signal (an operator, the kernel short of memory), and not the worker itself.
fn is_from_outside(status: ExitStatus) -> bool {
    const OWN: [i32; 7] =
        [libc::SIGILL, libc::SIGTRAP, libc::SIGABRT, libc::SIGBUS, libc::SIGFPE, libc::SIGSEGV, libc::SIGSYS];
    status.signal().is_some_and(|signal| !OWN.contains(&signal))
}

/// Reads heartbeats; other bytes are skipped, so that printed text does not hide later heartbeats.
async fn read_beats(worker: WorkerId, mut stdout: ChildStdout, events: UnboundedSender<Event>) {
    let mut bytes = Vec::with_capacity(16 * BEAT_BYTES);
    while stdout.read_buf(&mut bytes).await.is_ok_and(|n| n > 0) {
        let mut at = 0;
        let mut last = None;
        while let Some(window) = bytes.get(at..at + BEAT_BYTES) {
            match window.try_into().ok().and_then(Beat::decode) {
                Some(beat) => {
                    last = Some(beat);
                    at += BEAT_BYTES;
                }
                None => at += 1,
            }
        }
        bytes.drain(..at);
        if let Some(beat) = last {
            let _ = events.send(Event::Child(worker, ChildEvent::Beat(beat)));
        }
    }
}

/// Reads lines of standard error, cut to a limited length; returns whether a failed allocation was among them.
async fn read_lines(worker: WorkerId, stderr: ChildStderr, events: UnboundedSender<Event>) -> bool {
    let mut reader = BufReader::new(stderr);
    let mut out_of_memory = false;
    let mut line = Vec::new();
    loop {
        line.clear();
        let mut limited = (&mut reader).take(LONGEST_LINE as u64);
        match limited.read_until(b'\n', &mut line).await {
            Ok(0) | Err(_) => return out_of_memory,
            Ok(_) => {}
        }
        let text = String::from_utf8_lossy(&line);
        let text = text.trim_end();
        if !text.is_empty() {
            out_of_memory |= text.starts_with(OUT_OF_MEMORY_WORDS);
            let _ = events.send(Event::Child(worker, ChildEvent::Line(text.to_owned())));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deaths_by_somebody_else_are_told_from_own_ones() {
        let signal = ExitStatus::from_raw;
        for outside in [libc::SIGKILL, libc::SIGTERM, libc::SIGINT, libc::SIGHUP, libc::SIGXCPU, libc::SIGUSR1] {
            assert!(is_from_outside(signal(outside)), "{outside}");
        }
        // The second value: an abort with a core dump.
        for own in [libc::SIGSEGV, libc::SIGABRT | 0x80, libc::SIGBUS, libc::SIGILL, libc::SIGFPE, 0, 6 << 8] {
            assert!(!is_from_outside(signal(own)), "{own}");
        }
    }
}
