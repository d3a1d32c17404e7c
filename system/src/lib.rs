//! What all packages that read and write ask of the system.
//!
//! [`files`] are written whole or not at all; [`folder`] and [`place`] say how what lies in a directory that others may write in
//! is opened, [`locks`] who keeps a file locked; [`threads`] and [`guarded`] make errors of what libraries answer with a panic; [`call`] is how a command of this
//! program is printed, so that it can be pasted, [`shown`] how a path is.

pub mod call;
mod error;
pub mod files;
pub mod folder;
pub mod guarded;
pub mod locks;
pub mod place;
mod shown;
pub mod threads;

pub use shown::shown;
