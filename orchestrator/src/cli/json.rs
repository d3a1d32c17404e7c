//! JSON writer for flat objects: keys in the order of the columns, numbers that are read back with the same bits.

use bladeoff_answers::tables::{Field, FieldKind, Table};

/// A flat JSON object under construction.
#[derive(Debug, Default)]
pub struct JsonObject {
    text: String,
}

impl JsonObject {
    /// Adds a text, or null.
    pub fn word(&mut self, key: &str, value: Option<&str>) {
        let value = value.map_or_else(|| "null".to_owned(), quoted);
        self.raw(key, &value);
    }

    /// Adds a number in the format of its column, or null. JSON has neither NaN nor infinity; both become null.
    pub fn number(&mut self, field: &Field, value: Option<f64>) {
        let value = match value.filter(|value| value.is_finite()) {
            None => "null".to_owned(),
            Some(value) if field.kind == FieldKind::Count => format!("{}", value as u64),
            Some(value) if matches!(field.kind, FieldKind::Choice(_)) => {
                field.kind.word(value).map_or_else(|| "null".to_owned(), quoted)
            }
            Some(value) => number(value),
        };
        self.raw(&field.name, &value);
    }

    /// Adds a value that is already JSON.
    pub fn raw(&mut self, key: &str, value: &str) {
        let comma = if self.text.is_empty() { "" } else { "," };
        self.text.push_str(&format!("{comma}\n  {}: {value}", quoted(key)));
    }

    /// The object and a line feed.
    #[must_use]
    pub fn finish(self) -> String {
        format!("{{{}\n}}\n", self.text)
    }
}

/// The first row of a table, column by column; `fields`: the columns whose kind is known.
#[must_use]
pub fn row(table: &Table, names: &[String], fields: &[Field]) -> String {
    let mut object = JsonObject::default();
    for name in names {
        match (table.numbers(name), table.words(name), fields.iter().find(|field| field.name == *name)) {
            (Some(values), _, Some(field)) => object.number(field, values[0]),
            (Some(values), _, None) => object.raw(name, &values[0].map_or_else(|| "null".to_owned(), number)),
            (None, Some(words), _) => object.word(name, words[0].as_deref()),
            (None, None, _) => {}
        }
    }
    object.finish()
}

/// A JSON value of serde with indentation and a line feed.
#[must_use]
pub fn pretty(value: &serde_json::Value) -> String {
    serde_json::to_string_pretty(value).expect("strings and numbers always have a JSON form") + "\n"
}

/// A JSON string.
#[must_use]
pub fn quoted(text: &str) -> String {
    serde_json::to_string(text).expect("any string is a JSON string")
}

/// A finite number in its shortest form that is read back with the same bits; otherwise null.
#[must_use]
pub fn number(value: f64) -> String {
    serde_json::to_string(&value).expect("any f64 has a JSON form (null if not finite)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_bits_and_null_is_null() {
        let field = |name: &str, kind| Field { name: name.into(), unit: String::new(), meaning: String::new(), kind };
        let mut object = JsonObject::default();
        object.word("status", Some("ok"));
        object.word("cause", None);
        object.number(&field("a", FieldKind::Real), Some(0.1 + 0.2));
        object.number(&field("n", FieldKind::Count), Some(3.0));
        object.number(&field("z", FieldKind::Real), Some(f64::NAN));
        let parsed: serde_json::Value = serde_json::from_str(&object.finish()).expect("valid JSON");
        assert_eq!(parsed["a"].as_f64(), Some(0.1 + 0.2));
        assert_eq!(parsed["n"].as_u64(), Some(3));
        assert!(parsed["cause"].is_null() && parsed["z"].is_null());
    }
}
