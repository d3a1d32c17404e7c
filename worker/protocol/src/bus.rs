//! Memory that is not there when it is touched.
//!
//! A piece of shared memory is given its size when it is made and its pages when they are touched, by iceoryx2 inside the
//! making. When /dev/shm has filled up in between, the kernel sends SIGBUS, and a process that does not expect it is gone without
//! a word. Here it gets an empty page of its own instead, in the one place where it may be expected: in a call
//! into iceoryx2, at an address of ours in /dev/shm. The call ends, in whatever way; its result is thrown away, and
//! the caller gets [`PortError::MemoryFull`], now and from every later call of its thread: nothing that was read from such a
//! page is believed. Any other SIGBUS does what it did before.

use std::cell::Cell;
use std::ffi::{c_int, c_void};
use std::sync::OnceLock;

use crate::transport::PortError;
use crate::{limits, shm};

thread_local! {
    /// Whether this thread is in a call where memory may be missing.
    static IS_INSIDE: Cell<bool> = const { Cell::new(false) };
    /// Whether memory was missing.
    static RAN_OUT: Cell<bool> = const { Cell::new(false) };
}

/// What is needed inside the handler, where little may be asked for.
struct Before {
    action: libc::sigaction,
    page: usize,
}

static BEFORE: OnceLock<Before> = OnceLock::new();
/// Directory and start of the names of our memory, as the kernel lists mappings.
const OURS: &[u8] = b"/shm/bladeoff_";

/// Does what may touch memory that is not there.
///
/// # Errors
/// Those of `work`; [`PortError::MemoryFull`] if memory was missing, now or before, or if `work` failed while there is none;
/// [`PortError::NoDescriptors`] if it failed with next to no file that could be opened.
pub(crate) fn guarded<T>(work: impl FnOnce() -> Result<T, PortError>) -> Result<T, PortError> {
    install();
    let _inside = Inside::enter();
    let result = work();
    // What was made of missing memory is dropped while it is guarded.
    if RAN_OUT.get() || (result.is_err() && shm::is_full()) {
        drop(result);
        return Err(shm::full());
    }
    // iceoryx2 does not tell why a file could not be opened.
    if let Err(PortError::Failed { .. }) = &result
        && let Some(cause) = limits::few_descriptors()
    {
        return Err(cause);
    }
    result
}

struct Inside;

impl Inside {
    fn enter() -> Self {
        IS_INSIDE.set(true);
        Self
    }
}

impl Drop for Inside {
    fn drop(&mut self) {
        IS_INSIDE.set(false);
    }
}

/// Puts the handler in place, once in the life of a process.
#[expect(unsafe_code, reason = "the standard library sets no signal actions")]
fn install() {
    BEFORE.get_or_init(|| {
        // SAFETY: both structures are plain data for which zero is a valid value; the handler is one for SA_SIGINFO and runs on the
        // alternate stack that the standard library gives every thread. If SIGBUS arrives before `BEFORE` is set, it is
        // handled as nobody's.
        unsafe {
            let mut before: libc::sigaction = std::mem::zeroed();
            let mut ours: libc::sigaction = std::mem::zeroed();
            ours.sa_sigaction = on_bus as extern "C" fn(c_int, *mut libc::siginfo_t, *mut c_void) as usize;
            ours.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            libc::sigaction(libc::SIGBUS, &raw const ours, &raw mut before);
            Before { action: before, page: usize::try_from(libc::sysconf(libc::_SC_PAGESIZE)).unwrap_or(4096) }
        }
    });
}

/// Allocates nothing and takes no lock: everything here may be called in a signal handler.
#[expect(unsafe_code, reason = "a signal handler")]
extern "C" fn on_bus(_signal: c_int, info: *mut libc::siginfo_t, _context: *mut c_void) {
    // SAFETY: the kernel gives a valid siginfo; for SIGBUS it has an address.
    let (code, address) = unsafe { ((*info).si_code, (*info).si_addr() as usize) };
    let is_missing_page = code == libc::BUS_ADRERR && IS_INSIDE.try_with(Cell::get).unwrap_or(false);
    let before = BEFORE.get();
    if let Some(before) = before
        && is_missing_page
        && is_ours(address)
        && put_page(address, before.page)
    {
        let _ = RAN_OUT.try_with(|ran_out| ran_out.set(true));
        return;
    }
    // Not ours: the fault happens again, and finds the handler that was there before.
    // SAFETY: `action` is what the system gave us; zero is the default action.
    unsafe {
        let default: libc::sigaction = std::mem::zeroed();
        let action = before.map_or(&raw const default, |before| &raw const before.action);
        libc::sigaction(libc::SIGBUS, action, std::ptr::null_mut());
    }
}

/// Puts an empty page of this process alone where one is missing.
#[expect(unsafe_code, reason = "exchanges a page of a mapping")]
fn put_page(address: usize, page: usize) -> bool {
    let start = (address & !(page - 1)) as *mut c_void;
    let protection = libc::PROT_READ | libc::PROT_WRITE;
    let flags = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS | libc::MAP_FIXED;
    // SAFETY: the page belongs to a mapping of ours in which there is nothing: an access to it has just failed.
    unsafe { libc::mmap(start, page, protection, flags, -1, 0) != libc::MAP_FAILED }
}

/// Whether an address is in a mapping of our shared memory, by the kernel's list.
#[expect(unsafe_code, reason = "reads a file inside a signal handler")]
fn is_ours(address: usize) -> bool {
    // SAFETY: the path ends in 0, the buffer is as long as said, the descriptor is closed once.
    unsafe {
        let file = libc::open(c"/proc/self/maps".as_ptr(), libc::O_RDONLY | libc::O_CLOEXEC);
        if file < 0 {
            return false;
        }
        let mut lines = Lines { line: [0; 256], length: 0, address, found: false };
        let mut bytes = [0_u8; 1024];
        while let Ok(read @ 1..) = usize::try_from(libc::read(file, bytes.as_mut_ptr().cast(), bytes.len())) {
            bytes.iter().take(read).for_each(|&byte| lines.take(byte));
        }
        libc::close(file);
        lines.found
    }
}

/// Lines of `/proc/self/maps`: `start-end permissions offset device inode path`.
struct Lines {
    /// The first bytes of a line; the path begins near the 74th.
    line: [u8; 256],
    length: usize,
    address: usize,
    found: bool,
}

impl Lines {
    fn take(&mut self, byte: u8) {
        if byte != b'\n' {
            if let Some(place) = self.line.get_mut(self.length) {
                *place = byte;
                self.length += 1;
            }
            return;
        }
        let line = self.line.get(..self.length).unwrap_or_default();
        let mut ends = line.split(|byte| !byte.is_ascii_hexdigit()).map(hexadecimal);
        let is_inside =
            matches!((ends.next(), ends.next()), (Some(start), Some(end)) if (start..end).contains(&self.address));
        self.found |= is_inside && line.windows(OURS.len()).any(|part| part == OURS);
        self.length = 0;
    }
}

fn hexadecimal(digits: &[u8]) -> usize {
    digits.iter().fold(0, |value: usize, &digit| {
        let digit = char::from(digit).to_digit(16).unwrap_or(0);
        value.wrapping_shl(4) | digit as usize
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::fd::AsRawFd;

    /// Reads a byte of the second page of a file that has one page only; says what was there.
    #[expect(unsafe_code, reason = "a mapping beyond the end of a file")]
    fn read_what_is_missing(name: &str) -> u8 {
        let dir = tempfile::tempdir().expect("temporary directory");
        std::fs::create_dir(dir.path().join("shm")).expect("created");
        let path = dir.path().join(name);
        std::fs::write(&path, b"x").expect("written");
        let file = std::fs::File::open(&path).expect("there");
        // SAFETY: a fresh mapping, read within its length.
        unsafe {
            let start =
                libc::mmap(std::ptr::null_mut(), 1 << 20, libc::PROT_READ, libc::MAP_SHARED, file.as_raw_fd(), 0);
            assert!(start != libc::MAP_FAILED);
            start.cast::<u8>().add(1 << 19).read_volatile()
        }
    }

    #[test]
    fn missing_memory_is_an_error_of_this_and_every_later_call_of_the_thread() {
        let result = guarded(|| Ok(read_what_is_missing("shm/bladeoff_test")));
        assert!(matches!(result, Err(PortError::MemoryFull { .. })), "{result:?}");
        let later = guarded(|| Ok(()));
        assert!(matches!(later, Err(PortError::MemoryFull { .. })), "{later:?}");
        let other = std::thread::spawn(|| guarded(|| Ok(1)));
        assert!(matches!(other.join().expect("no panic"), Ok(1)));
    }

    /// Not a test by itself: touches what is missing where that is nobody's business, for the test below.
    #[test]
    fn unexpected_fault() {
        let Ok(what) = std::env::var("BLADEOFF_TEST_FAULT") else { return };
        assert!(guarded(|| Ok(())).is_ok());
        if what == "other file" {
            let _ = guarded(|| Ok(read_what_is_missing("shm/other")));
        } else {
            read_what_is_missing("shm/bladeoff_test");
        }
    }

    #[test]
    fn any_other_fault_ends_the_process_as_ever() {
        use std::os::unix::process::ExitStatusExt;
        for what in ["other file", "outside of a call"] {
            let mut command = std::process::Command::new(std::env::current_exe().expect("this program"));
            command.args(["--exact", "bus::tests::unexpected_fault"]).env("BLADEOFF_TEST_FAULT", what);
            let output = command.output().expect("started");
            assert_eq!(output.status.signal(), Some(libc::SIGBUS), "{what}: {output:?}");
        }
    }
}
