//! Tests of the content policy of a page: scripts and requests.

use super::*;
use crate::page::Plot;
use serde_json::json as value;
use std::io::Write;
use std::process::{Command, Stdio};

/// SHA-256 by `sha256sum`, in hexadecimal digits.
pub fn sha256(text: &str) -> String {
    let mut child = Command::new("sha256sum").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("coreutils");
    child.stdin.take().expect("piped").write_all(text.as_bytes()).expect("taken");
    let said = child.wait_with_output().expect("ended").stdout;
    String::from_utf8(said).expect("ASCII")[..64].to_owned()
}

/// Base64 of hexadecimal digits, as used in a policy.
pub fn base64(hex: &str) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let bytes: Vec<u8> =
        (0..hex.len() / 2).map(|at| u8::from_str_radix(&hex[2 * at..2 * at + 2], 16).expect("hex")).collect();
    let mut text = String::new();
    for piece in bytes.chunks(3) {
        let bits = piece.iter().fold(0u32, |bits, byte| bits << 8 | u32::from(*byte)) << (8 * (3 - piece.len()));
        for at in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * at)) as usize & 63];
            text.push(if at > piece.len() { '=' } else { char::from(letter) });
        }
    }
    text
}

#[test]
fn the_library_is_the_published_one_and_the_policy_knows_both_scripts() {
    assert_eq!(sha256(LIBRARY), "79542150855a52c567260e3137095dbe2b744e6d702a5cabe67da246942fba7a");
    assert_eq!([LIBRARY, SCRIPT].map(|script| base64(&sha256(script))), HASHES);
    for script in [LIBRARY, SCRIPT] {
        let lower = script.to_lowercase();
        assert!(!lower.contains("</script") && !lower.contains("<!--"), "it would end its element");
        assert!(!script.contains('\r'), "a page has line feeds alone, and the sum is of what it has");
    }
    assert!(!STYLE.to_lowercase().contains("</style") && !STYLE.contains("url("));
    assert!(LICENSE.starts_with("MIT License"));
}

#[test]
fn hostile_text_is_text_everywhere() {
    let hostile = "</script><script>alert(1)</script><img src=http://example.org/x onerror=alert(1)>\"'";
    let cells = vec![hostile.to_owned(); 3];
    let table = Table { head: cells.clone(), rows: vec![cells], verbatim: vec![0] };
    let figure = Figure {
        caption: hostile.into(),
        drawing: "<svg></svg>".into(),
        plot: Some(Plot::Traces(value!([{ "name": hostile }]), value!({ "title": hostile }))),
        table: Some(table.clone()),
    };
    let text = |text: &dyn Fn(String) -> Block| text(hostile.to_owned());
    let blocks = vec![
        text(&Block::Heading),
        text(&Block::Text),
        text(&Block::Note),
        text(&Block::Warning),
        text(&Block::Verbatim),
        Block::List(vec![hostile.into()]),
        table.into(),
        figure.into(),
        Block::Details(hostile.into(), vec![text(&Block::Text)]),
    ];
    let section = Section { id: "a", heading: hostile.into(), blocks: blocks.clone() };
    let other = Section { id: "b", heading: hostile.into(), blocks: Vec::new() };
    let page = Page { title: hostile.into(), lead: blocks, sections: vec![section, other], reload: None }.html();
    let ours = page.replace(LIBRARY, "").replace(SCRIPT, "").replace(STYLE, "");
    assert_eq!(ours.matches("<script").count(), 3, "data and both scripts");
    assert_eq!(ours.matches("</script").count(), 3);
    assert!(!ours.contains("<img") && !ours.contains("</script><script>alert"));
    assert!(ours.contains("&lt;script&gt;alert(1)"), "it is shown");
}

#[test]
fn a_table_has_its_heads_at_the_cells_and_no_empty_column() {
    let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
    let head = words(&["gate", "group", "runs", "why"]);
    let rows = vec![words(&["a", "", "12 MN", "0 of 400 runs; 46 are left undecided"])];
    let mut body = Body::default();
    body.table(&Table { head, rows, verbatim: Vec::new() });
    assert!(body.text.contains("<td class=\"number\" data-head=\"runs\">12 MN</td>"), "{}", body.text);
    assert!(body.text.contains("<td data-head=\"why\">0 of 400 runs"), "a sentence wraps: {}", body.text);
    assert!(!body.text.contains("group"), "{}", body.text);
    let mut body = Body::default();
    body.table(&Table { head: words(&["", "value"]), rows: vec![words(&["a", "b"])], verbatim: Vec::new() });
    assert!(body.text.contains("<td>a</td><td>b</td>") && !body.text.contains("stacked"), "{}", body.text);
}

#[test]
fn links_lead_somewhere_and_the_same_page_is_the_same_bytes() {
    let section = |id| Section { id, heading: format!("About {id}"), blocks: vec![Block::Text("x".into())] };
    let page =
        Page { title: "A".into(), lead: Vec::new(), sections: vec![section("first"), section("second")], reload: None };
    let text = page.html();
    assert_eq!(text, page.html());
    for id in ["first", "second", "content"] {
        assert!(text.contains(&format!("href=\"#{id}\"")) && text.contains(&format!("id=\"{id}\"")), "{id}");
    }
}
