//! Escaping of untrusted text for terminals: characters that act on the terminal or are invisible are replaced by visible ones.
//!
//! Files, file names and the output of programs may contain escape sequences (colours, cursor moves, titles, links), line feeds inside a
//! line, marks of writing direction and characters without width. Printed as they are, they could show a text other than the real one.
//! else than what is there.

use std::borrow::Cow;
use std::fmt::Write;

/// Whether a character acts on the display instead of being shown: control characters (C0, DEL, C1), marks of writing direction,
/// line separators, characters without width and tags.
#[must_use]
pub fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{ad}' | '\u{34f}' | '\u{61c}' | '\u{115f}' | '\u{1160}' | '\u{17b4}' | '\u{17b5}' | '\u{180b}'..='\u{180f}'
            | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{3164}' | '\u{fe00}'..='\u{fe0f}'
            | '\u{feff}' | '\u{ffa0}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e01ef}')
}

/// Escapes one line of untrusted text: every hidden character, including line feeds and tabs, as `\u{1b}`.
#[must_use]
pub fn visible(text: &str) -> Cow<'_, str> {
    escaped(text, is_hidden)
}

/// Escapes text of several lines: as [`visible`], but line feeds and tabs stay.
#[must_use]
pub fn visible_lines(text: &str) -> Cow<'_, str> {
    escaped(text, is_hidden_in_lines)
}

/// Replaces each hidden character by one visible character (`␛` for escape, `\u{fffd}` where there is no such sign), so that columns stay
/// aligned: for excerpts with an underlined position, and for pictures.
#[must_use]
pub fn pictured_lines(text: &str) -> Cow<'_, str> {
    if !text.contains(is_hidden_in_lines) {
        return Cow::Borrowed(text);
    }
    let picture = |c: char| match c {
        c if !is_hidden_in_lines(c) => c,
        '\0'..='\u{1f}' => char::from_u32(0x2400 + c as u32).unwrap_or(char::REPLACEMENT_CHARACTER),
        '\u{7f}' => '\u{2421}',
        _ => char::REPLACEMENT_CHARACTER,
    };
    Cow::Owned(text.chars().map(picture).collect())
}

/// JSON text with every hidden character as `\u001b`. In valid JSON such characters occur in strings only, so the meaning is unchanged.
#[must_use]
pub fn visible_json(json: &str) -> Cow<'_, str> {
    if !json.contains(is_hidden_in_lines) {
        return Cow::Borrowed(json);
    }
    let mut text = String::with_capacity(json.len() + 16);
    for c in json.chars() {
        if is_hidden_in_lines(c) {
            for unit in c.encode_utf16(&mut [0; 2]) {
                write!(text, "\\u{unit:04x}").expect("writing to a String cannot fail");
            }
        } else {
            text.push(c);
        }
    }
    Cow::Owned(text)
}

fn is_hidden_in_lines(c: char) -> bool {
    is_hidden(c) && c != '\n' && c != '\t'
}

fn escaped(text: &str, is_hidden: fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(is_hidden) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_hidden(c) { shown.extend(c.escape_unicode()) } else { shown.push(c) }
    }
    Cow::Owned(shown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_acts_on_a_terminal_is_shown() {
        let text = "a\u{1b}[31mb\u{9b}2Jc\r\nd\u{202e}e\u{7f}\tµ\u{2028}";
        let all = "a\\u{1b}[31mb\\u{9b}2Jc\\u{d}\\u{a}d\\u{202e}e\\u{7f}\\u{9}µ\\u{2028}";
        assert_eq!(visible(text), all);
        assert_eq!(visible_lines(text), all.replace("\\u{a}", "\n").replace("\\u{9}", "\t"));
        assert_eq!(pictured_lines(text), "a␛[31mb\u{fffd}2Jc␍\nd\u{fffd}e␡\tµ\u{fffd}");
        assert_eq!(visible("a\u{fe0f}b\u{34f}c\u{3164}\u{e0100}"), "a\\u{fe0f}b\\u{34f}c\\u{3164}\\u{e0100}");
        for plain in ["", "Größe 5 µm, 30°: \"x\" \\u{1b}", "ring ✓ 日本"] {
            assert!(matches!(visible(plain), Cow::Borrowed(same) if same == plain));
        }
        let every: String = (0..=0x0010_ffff).filter_map(char::from_u32).collect();
        assert!(!visible(&every).contains(is_hidden) && !visible(&every).contains(char::is_control));
    }

    #[test]
    fn json_keeps_its_meaning() {
        let json = format!("{{\n\t\"a\": {}\n}}", "\"\u{9b}\u{7f}\u{202e}\u{e0041}µ\\u001b\\n\"");
        let shown = visible_json(&json);
        assert!(!shown.contains(is_hidden_in_lines));
        assert_eq!(shown, "{\n\t\"a\": \"\\u009b\\u007f\\u202e\\udb40\\udc41µ\\u001b\\n\"\n}");
    }
}
