//! Paths composed for look-ups. A study builds a million machines with a hundred look-ups each; paths on the heap would cost more than all
//! checks.

use std::ops::Deref;

/// Longest path \[bytes\], with a margin: `diaphragms.NAME.material.young_modulus` with a name of 64 letters.
const ROOM: usize = 160;

/// A path of a parameter, on the stack.
pub(super) struct Path {
    bytes: [u8; ROOM],
    length: usize,
}

/// Path of a key in a table.
pub(super) fn below(table: &str, key: &str) -> Path {
    joined(&[table, ".", key])
}

/// Concatenates the pieces of a path.
pub(super) fn joined(pieces: &[&str]) -> Path {
    let mut path = Path { bytes: [0; ROOM], length: 0 };
    for piece in pieces {
        let end = path.length + piece.len();
        // Names have at most 64 letters (`load.rs`), so there is always room; if that ever fails, no parameter is found.
        let Some(room) = path.bytes.get_mut(path.length..end) else { break };
        room.copy_from_slice(piece.as_bytes());
        path.length = end;
    }
    path
}

impl Deref for Path {
    type Target = str;

    fn deref(&self) -> &str {
        std::str::from_utf8(&self.bytes[..self.length]).expect("whole pieces of text")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::schema::keys;

    #[test]
    fn every_path_with_the_longest_name_has_room() {
        for key in keys() {
            let longest = key.path.replace("NAME", &"n".repeat(64)).replace("[i]", "[499]");
            assert!(longest.len() + "[1][1]".len() <= ROOM, "{longest}");
            assert_eq!(&*below(&longest, "[0]"), format!("{longest}.[0]"));
        }
    }
}
