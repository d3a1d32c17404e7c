//! SIGBUS on shared memory that runs out when a page is first touched.
//!
//! iceoryx2 sets the size of a piece of shared memory when it creates the piece; the kernel provides the pages when they are first touched.
//! If /dev/shm has filled up in between, the kernel sends SIGBUS, which by default ends the process without a message. The handler here
//! maps an empty private page instead, but only during a call into iceoryx2 and at an address of this program's memory in /dev/shm. The
//! result of that call is discarded, and it and every later call of the thread return [`PortError::MemoryFull`], so that no data from
//! such a page is used. Any other SIGBUS has its previous effect.

use std::cell::Cell;
use std::ffi::{c_int, c_void};
use std::sync::OnceLock;

use crate::transport::PortError;
use crate::{limits, shm};

thread_local! {
    /// Whether this thread is in a call that may touch missing memory.
    static IS_INSIDE: Cell<bool> = const { Cell::new(false) };
    /// Whether this thread has touched missing memory.
    static RAN_OUT: Cell<bool> = const { Cell::new(false) };
}

/// State for the signal handler, stored beforehand because a handler may call few functions.
struct Before {
    action: libc::sigaction,
    page: usize,
}

static BEFORE: OnceLock<Before> = OnceLock::new();
/// Directory and start of the names of this program's shared memory, as `/proc/self/maps` lists mappings.
const OURS: &[u8] = b"/shm/bladeoff_";

/// Runs `work`, which may touch shared memory that has run out.
///
/// # Errors
/// Errors of `work`. [`PortError::MemoryFull`] if this thread has touched missing memory, now or earlier, or if `work` failed while /dev/shm is
/// full; [`PortError::NoDescriptors`] if `work` failed close to the limit on open files.
pub(crate) fn guarded<T>(work: impl FnOnce() -> Result<T, PortError>) -> Result<T, PortError> {
    install();
    let _inside = Inside::enter();
    let result = work();
    // The result may refer to missing memory, so it is dropped while the guard is still active.
    if RAN_OUT.get() || (result.is_err() && shm::is_full()) {
        drop(result);
        return Err(shm::full());
    }
    // iceoryx2 does not report why a file could not be opened.
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

/// Installs the handler, once per process.
#[expect(unsafe_code, reason = "the standard library sets no signal actions")]
fn install() {
    BEFORE.get_or_init(|| {
        // SAFETY: both structures are plain data for which zero is a valid value; the handler is one for SA_SIGINFO and runs on the
        // alternate stack that the standard library gives every thread. If SIGBUS arrives before `BEFORE` is set, it is
        // handled as one outside guarded memory.
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

/// Allocates nothing and takes no lock: every function called here is allowed in a signal handler.
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
    // Not guarded memory: the fault occurs again and reaches the previous handler.
    // SAFETY: the system returned `action`; zero is the default action.
    unsafe {
        let default: libc::sigaction = std::mem::zeroed();
        let action = before.map_or(&raw const default, |before| &raw const before.action);
        libc::sigaction(libc::SIGBUS, action, std::ptr::null_mut());
    }
}

/// Maps an empty private page over a missing one.
#[expect(unsafe_code, reason = "exchanges a page of a mapping")]
fn put_page(address: usize, page: usize) -> bool {
    let start = (address & !(page - 1)) as *mut c_void;
    let protection = libc::PROT_READ | libc::PROT_WRITE;
    let flags = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS | libc::MAP_FIXED;
    // SAFETY: the page belongs to a mapping of this program and has no memory: an access to it has just failed.
    unsafe { libc::mmap(start, page, protection, flags, -1, 0) != libc::MAP_FAILED }
}

/// Whether an address is in a mapping of this program's shared memory, according to `/proc/self/maps`.
#[expect(unsafe_code, reason = "reads a file inside a signal handler")]
fn is_ours(address: usize) -> bool {
    // SAFETY: the path ends in 0, the length of the buffer is right, the descriptor is closed once.
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

    /// Reads a byte of a mapping beyond the only page of its file; returns the byte that the handler provides.
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

    /// Child process of the test below: touches missing memory that the handler must not provide.
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
