//! Limits of one case of hostile input: memory, counted by the allocator of the test program, and time.
//!
//! The memory is that of the thread of the case; for threads started by a library only single allocations are limited. A watchdog ends the
//! program if a case hangs. An allocation above [`HARDEST`] fails, which ends the program, too.

#![expect(unsafe_code, reason = "an allocator is unsafe by its trait; this one only counts")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, Once, PoisonError};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

/// Largest single allocation \[bytes\].
const HARDEST: usize = 2 << 30;
/// Longest CPU time of one case; test machines are slow.
const LONGEST: Duration = Duration::from_secs(10);
/// Time after which the watchdog ends the program; test machines are busy.
const HANGING: Duration = Duration::from_secs(300);

struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

thread_local! {
    static LIVE: Cell<isize> = const { Cell::new(0) };
    static PEAK: Cell<isize> = const { Cell::new(0) };
}

fn count(more: usize, less: usize) {
    // a thread that ends has no counters any more
    let _ = LIVE.try_with(|live| {
        live.set(live.get() + more as isize - less as isize);
        PEAK.with(|peak| peak.set(peak.get().max(live.get())));
    });
}

// SAFETY: every call is passed to the system's allocator as it came, or answered with the null that says there is no memory.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if layout.size() > HARDEST {
            return std::ptr::null_mut();
        }
        count(layout.size(), 0);
        // SAFETY: the caller's promises are those that the system asks for.
        unsafe { System.alloc(layout) }
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if layout.size() > HARDEST {
            return std::ptr::null_mut();
        }
        count(layout.size(), 0);
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        count(0, layout.size());
        // SAFETY: as above.
        unsafe { System.dealloc(memory, layout) }
    }
    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if size > HARDEST {
            return std::ptr::null_mut();
        }
        count(size, layout.size());
        // SAFETY: as above.
        unsafe { System.realloc(memory, layout, size) }
    }
}

static UNDER_WAY: Mutex<Option<HashMap<ThreadId, Instant>>> = Mutex::new(None);
static CASES: AtomicU64 = AtomicU64::new(0);
static MOST_BYTES: AtomicU64 = AtomicU64::new(0);
static MOST_MICROS: AtomicU64 = AtomicU64::new(0);

fn under_way<T>(change: impl FnOnce(&mut HashMap<ThreadId, Instant>) -> T) -> T {
    change(UNDER_WAY.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_default())
}

/// The case of this thread, until dropped.
struct UnderWay;

impl UnderWay {
    fn begin() -> Self {
        static WATCHDOG: Once = Once::new();
        WATCHDOG.call_once(|| {
            thread::spawn(|| {
                loop {
                    thread::sleep(Duration::from_secs(1));
                    if under_way(|all| all.values().any(|begun| begun.elapsed() > HANGING)) {
                        eprintln!("a case hangs: not at its end after {HANGING:?}");
                        std::process::abort();
                    }
                }
            });
        });
        under_way(|all| all.insert(thread::current().id(), Instant::now()));
        Self
    }
}

impl Drop for UnderWay {
    fn drop(&mut self) {
        under_way(|all| all.remove(&thread::current().id()));
    }
}

/// Runs one case, which may allocate `most` bytes in addition to the present memory.
///
/// # Panics
/// The case took more memory, or too long.
pub fn case<T>(most: usize, work: impl FnOnce() -> T) -> T {
    let watched = UnderWay::begin();
    LIVE.set(0);
    PEAK.set(0);
    let begun = cpu_time();
    let result = work();
    let (bytes, time) = (PEAK.get(), cpu_time().saturating_sub(begun));
    drop(watched);
    CASES.fetch_add(1, Ordering::Relaxed);
    MOST_BYTES.fetch_max(bytes as u64, Ordering::Relaxed);
    MOST_MICROS.fetch_max(time.as_micros() as u64, Ordering::Relaxed);
    assert!(bytes <= most as isize, "{bytes} bytes, at most {most} allowed");
    assert!(time <= LONGEST, "{time:?}, at most {LONGEST:?} allowed");
    result
}

/// CPU time of this thread, independent of other load.
fn cpu_time() -> Duration {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `time` is a valid timespec that outlives the call, which writes to nothing else.
    assert_eq!(unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &raw mut time) }, 0);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// Counts of all cases of the program so far, as text.
pub fn figures() -> String {
    let [cases, bytes, micros] = [&CASES, &MOST_BYTES, &MOST_MICROS].map(|figure| figure.load(Ordering::Relaxed));
    format!(
        "{cases} cases so far; the largest took {:.1} MB, the longest {:.1} ms",
        bytes as f64 / 1e6,
        micros as f64 / 1e3
    )
}

#[test]
#[should_panic = "bytes, at most 1000000 allowed"]
fn memory_is_seen() {
    case(1_000_000, || drop(std::hint::black_box(vec![1_u8; 2_000_000])));
}

#[test]
fn memory_that_is_given_back_is_not_added_up() {
    case(1_000_000, || (0..1000).for_each(|_| drop(std::hint::black_box(vec![1_u8; 500_000]))));
}

#[test]
fn what_nobody_has_is_refused() {
    assert!(Vec::<u8>::new().try_reserve_exact(HARDEST + 1).is_err());
}
