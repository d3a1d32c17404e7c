//! Files, folders, locks, threads and random numbers for all packages that read and write.
//!
//! [`files`] writes files whole or not at all. [`folder`] and [`place`] open files safely in directories that other users may write in.
//! [`locks`] finds the holder of a file lock. [`threads`] and [`guarded`] turn panics of libraries into errors. [`call`] formats commands of
//! this program for pasting, [`shown`] paths, and [`with_causes`] errors. [`random`] provides reproducible random numbers for fault tests.

pub mod call;
mod causes;
mod error;
pub mod files;
pub mod folder;
pub mod guarded;
pub mod locks;
pub mod place;
pub mod random;
mod shown;
pub mod threads;

pub use causes::{causes, with_causes};
pub use shown::shown;
