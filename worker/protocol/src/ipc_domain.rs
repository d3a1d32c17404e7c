//! What iceoryx2 knows of the processes of a domain.

use iceoryx2::prelude::*;

use crate::domain::Address;
use crate::ipc::{Ipc, config};

/// Releases what dead processes of a domain hold; says whether no process of it is alive any more.
pub(crate) fn release_dead(address: &Address) -> bool {
    set_log_level(LogLevel::Fatal);
    let Ok(config) = config(address) else { return false };
    let mut all_dead = true;
    let listed = Node::<Ipc>::list(&config, |state| {
        match state {
            NodeState::Dead(view) => {
                // Files it leaves have our prefix and are removed by name.
                let _ = view.try_remove_stale_resources();
            }
            NodeState::Alive(_) => all_dead = false,
            NodeState::Inaccessible(_) | NodeState::Undefined(_) => {}
        }
        CallbackProgression::Continue
    });
    listed.is_ok() && all_dead
}
