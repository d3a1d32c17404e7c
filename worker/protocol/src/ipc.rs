//! The transport between processes, over iceoryx2; `ipc*.rs` are the only files that name it.

pub use crate::ipc_hub::IpcHub;
pub use crate::ipc_services::BACKSTOP;
pub use crate::ipc_worker::IpcWorker;
