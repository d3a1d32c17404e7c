//! Processes of a domain, as iceoryx2 lists them.

use iceoryx2::prelude::*;

use crate::ipc_services::{Ipc, config};
use crate::names::Address;

/// Whether no process of a domain is alive. The function only reads the state: files of dead processes are removed by name, because iceoryx2's
/// own cleanup can wait without end for an object whose creator was killed (see [`unfinished`](crate::unfinished)).
pub(crate) fn is_deserted(address: &Address) -> bool {
    set_log_level(LogLevel::Fatal);
    let Ok(config) = config(address) else { return false };
    let mut is_deserted = true;
    let listed = Node::<Ipc>::list(&config, |state| {
        is_deserted &= !matches!(state, NodeState::Alive(_));
        CallbackProgression::Continue
    });
    listed.is_ok() && is_deserted
}
