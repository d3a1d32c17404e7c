//! Escaping of text for HTML, XML, chart labels and scripts.

pub(crate) use crate::drawing::html;
use serde_json::Value;

/// Text for a name, title or label of a [`super::Plot`]: Plotly reads `<b>`, `<a href>` and entities as markup.
#[must_use]
pub fn plain(text: &str) -> String {
    html(text).replace('\n', " ").replace("&#39;", "'").replace("&quot;", "\"").replace('$', "\u{ff04}")
}

/// Data inside of a `<script>`: nothing in it ends the element or begins a comment.
#[must_use]
pub fn json(value: &Value) -> String {
    value.to_string().replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json as value;

    #[test]
    fn markup_stays_text() {
        let hostile = "</script><img src=x onerror='alert(1)'>\"&\u{202e}\u{7}";
        let shown = "&lt;/script&gt;&lt;img src=x onerror=&#39;alert(1)&#39;&gt;&quot;&amp;\u{fffd}\u{2407}";
        assert_eq!(html(hostile), shown);
        assert_eq!(plain("<a href='x'>$y$</a>"), "&lt;a href='x'&gt;\u{ff04}y\u{ff04}&lt;/a&gt;");
        let text = json(&value!({ "<!--": "</script>" }));
        assert!(!text.contains('<'), "{text}");
        assert_eq!(serde_json::from_str::<Value>(&text).expect("JSON"), value!({ "<!--": "</script>" }));
    }
}
