//! Libraries that answer damaged files, or the lack of files that may be opened, with a panic.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static IS_GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Whether a panic of this thread is taken for damage of the file that is being read, or what else its caller expects, and none of ours.
#[must_use]
pub fn is_guarded() -> bool {
    IS_GUARDED.get()
}

/// What a library makes; `None` if it panicked: the file that it reads is damaged.
pub fn guarded<T>(read: impl FnOnce() -> T) -> Option<T> {
    let before = IS_GUARDED.replace(true);
    let result = catch_unwind(AssertUnwindSafe(read));
    IS_GUARDED.set(before);
    result.ok()
}
