//! Keyboard: `s` and Enter print the activity of each worker, as SIGUSR1 does.

use std::io::{BufRead, IsTerminal};

use rustix::event::{PollFd, PollFlags, Timespec};
use rustix::termios::LocalModes;
use tokio::sync::mpsc::UnboundedSender;

use super::event::Event;

/// Reads standard input while the receiver exists, if standard input is a terminal. A background process does not read: reading would
/// stop it (SIGTTIN).
pub(super) fn watch(events: &UnboundedSender<Event>) {
    let stdin = std::io::stdin();
    if !stdin.is_terminal() {
        return;
    }
    let events = events.clone();
    let body = move || {
        let a_second = Timespec { tv_sec: 1, tv_nsec: 0 };
        while !events.is_closed() {
            let mut fds = [PollFd::new(&stdin, PollFlags::IN)];
            let has_input = rustix::event::poll(&mut fds, Some(&a_second)).is_ok_and(|ready| ready > 0);
            if !has_input {
                continue;
            }
            if !is_in_foreground() {
                std::thread::sleep(std::time::Duration::from_secs(1));
                continue;
            }
            let mut line = String::new();
            match stdin.lock().read_line(&mut line) {
                Ok(0) | Err(_) => return,
                Ok(_) => {
                    if shows_what_is_typed(&stdin) {
                        let _ = events.send(Event::Typed);
                    }
                    if line.trim().eq_ignore_ascii_case("s") {
                        let _ = events.send(Event::Asked);
                    }
                }
            }
        }
    };
    // Without the thread, SIGUSR1 still works.
    let _ = std::thread::Builder::new().name("keyboard".into()).stack_size(64 << 10).spawn(body);
}

/// Whether the terminal echoes lines, which is its default.
fn shows_what_is_typed(stdin: &std::io::Stdin) -> bool {
    rustix::termios::tcgetattr(stdin).is_ok_and(|modes| modes.local_modes.contains(LocalModes::ECHO))
}

/// Whether this process group is the foreground group of the terminal, from /proc.
fn is_in_foreground() -> bool {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // After the name in parentheses: state, parent, group, session, terminal, the terminal's foreground group.
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    matches!(fields[..], [_, _, group, _, _, foreground, ..] if group == foreground)
}
