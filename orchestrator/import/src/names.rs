//! Names of tables, and comments, from texts of other programs.

use bladeoff_text::document::{cut, visible};
use std::collections::HashSet;

/// Longest generated name.
const LONGEST: usize = 40;
/// Longest comment from a text.
const LONGEST_COMMENT: usize = 100;

/// Names that are in use.
#[derive(Debug, Default)]
pub struct Names(HashSet<String>);

impl Names {
    /// An unused name similar to a text. `kind`: first word if the text does not begin with a letter.
    pub fn like(&mut self, text: &str, kind: &str) -> String {
        let mut name = String::new();
        for c in text.chars() {
            match c {
                'a'..='z' | '0'..='9' => name.push(c),
                'A'..='Z' => name.push(c.to_ascii_lowercase()),
                _ if name.ends_with('_') => {}
                _ => name.push('_'),
            }
            if name.len() >= LONGEST {
                break;
            }
        }
        let plain = name.trim_matches('_');
        let plain = if plain.starts_with(|c: char| c.is_ascii_lowercase()) {
            plain.to_owned()
        } else {
            format!("{kind}_{plain}")
        };
        // the name of a bearing must not end like another result column
        let plain = plain.trim_end_matches('_');
        let plain = if plain.ends_with("at_s") { format!("{plain}_{kind}") } else { plain.to_owned() };
        let numbered = (2_usize..).map(|number| format!("{plain}_{number}"));
        let name = std::iter::once(plain.clone()).chain(numbered).find(|name| !self.0.contains(name)).unwrap_or(plain);
        self.0.insert(name.clone());
        name
    }
}

/// The tag of an element: its name without the class.
pub fn tag(element: &str) -> &str {
    element.split_once('_').map_or(element, |(_, tag)| tag)
}

/// Comment made of an untrusted text: one line, visible characters, of limited length.
pub fn in_one_line(text: &str) -> String {
    let shown = cut(text, LONGEST_COMMENT);
    visible(&shown).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_text_makes_a_name_of_its_own() {
        let mut names = Names::default();
        for (text, expected) in [
            ("Bearing 0", "bearing_0"),
            ("Bearing 0", "bearing_0_2"),
            ("BEARING  0", "bearing_0_3"),
            ("0", "bearing_0_4"),
            ("", "bearing"),
            ("é\n\"]", "bearing_2"),
            ("left_at_s", "left_at_s_bearing"),
            ("N", "n"),
        ] {
            assert_eq!(names.like(text, "bearing"), expected, "{text}");
        }
        assert!(names.like(&"x".repeat(500), "disc").len() <= 44);
    }
}
