//! The transport between processes, over iceoryx2; only the files `ipc*.rs` depend on iceoryx2.

pub use crate::ipc_hub::IpcHub;
pub use crate::ipc_services::BACKSTOP;
pub use crate::ipc_worker::IpcWorker;
