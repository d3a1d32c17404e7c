//! Files, folders, locks, threads and random numbers for all packages that read and write.
//!
//! [`files`] are written whole or not at all; [`folder`] and [`place`] say how what lies in a directory that others may write in
//! is opened, [`locks`] who keeps a file locked; [`threads`] and [`guarded`] make errors of what libraries answer with a panic; [`call`] is how a command of this
//! program is printed, so that it can be pasted, [`shown`] how a path is, [`with_causes`] how an error; [`random`] is
//! what storms and tests draw from.

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
