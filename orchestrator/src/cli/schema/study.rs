//! The JSON Schema of study files. The table of keys states in words what a key holds; `value` gives the type for each phrase.

use super::{document, table, with_unit};
use bladeoff_study::uncertain::Distribution;
use bladeoff_study::{STUDY_KEYS, STUDY_TABLES, StudyKey};
use serde_json::{Map, Value, json};

/// The format as a JSON Schema.
pub(super) fn schema() -> Value {
    document("bladeoff study file", "Samples of a machine and questions to them, version 1 of the format", keys_of(""))
}

/// The keys of one table.
fn keys_of(name: &str) -> Value {
    let mut properties = Map::new();
    let mut required = Vec::new();
    for key in STUDY_KEYS.iter().filter(|key| key.table == name) {
        properties.insert(key.name.to_owned(), described(key));
        if key.default == "required" {
            required.push(key.name.to_owned());
        }
    }
    table(properties, &required)
}

fn described(key: &StudyKey) -> Value {
    // A test checks that every phrase has a type; without one a value of any type would be accepted.
    let mut value = value(key).unwrap_or_else(|| json!({}));
    let default = if key.default == "none" { String::new() } else { format!("; default: {}", key.default) };
    let default = if key.default.starts_with("required") { format!("; {}", key.default) } else { default };
    let text = match (key.holds, STUDY_TABLES.iter().find(|(table, _)| table.trim_matches(['[', ']']) == key.name)) {
        ("table" | "array of tables", Some((_, purpose))) => (*purpose).to_owned(),
        _ => format!("{}; holds: {}{default}", key.meaning, key.holds),
    };
    value["description"] = json!(text);
    value
}

/// Type of a value; `None` if its phrase is unknown.
fn value(key: &StudyKey) -> Option<Value> {
    let quantity = json!({ "anyOf": [{ "type": "number" }, with_unit("")] });
    let text = json!({ "type": "string" });
    let list = |items: &Value| json!({ "type": "array", "items": items });
    let pair = |items: &Value| json!({ "type": "array", "items": items, "minItems": 2, "maxItems": 2 });
    let scalar = json!({ "type": ["number", "string"] });
    let holds = key.holds;
    Some(match holds {
        "table" => table_of(key.name),
        "array of tables" => list(&keys_of(&format!("[[{}]]", key.name))),
        "1" => json!({ "const": 1 }),
        "true or false" => json!({ "type": "boolean" }),
        "quantity" => quantity,
        "word of the table of distributions" => {
            json!({ "enum": Distribution::ALL.iter().map(|(word, _)| word).collect::<Vec<_>>() })
        }
        "list of quantities" => list(&quantity),
        "list of quantities, or of words" => list(&scalar),
        "list of columns" => list(&text),
        "two names" | "two parameters" => pair(&text),
        "two values" => pair(&scalar),
        "two whole numbers" => pair(&whole(1, None)),
        "whole number, at least 2" => whole(2, None),
        "whole number, at most 1024" => whole(1, Some(1024)),
        "whole number, 1 to 1000" => whole(1, Some(1000)),
        "even number, 2 to 64" => json!({ "type": "integer", "minimum": 2, "maximum": 64, "multipleOf": 2 }),
        _ if holds.starts_with("whole number") => whole(0, None),
        "number, or share" | "number, or share such as `\"5 %\"`" => {
            json!({ "anyOf": [whole(0, None), { "type": "string", "pattern": r"^\s*[0-9.]+\s*%\s*$" }] })
        }
        "share such as `\"10 %\"`" | "share such as `\"5 %\"`" => scalar,
        _ if holds.starts_with("time such as") || holds.starts_with("size such as") => scalar,
        "number" | "number above 0" | "number in the SI unit of the answer" => scalar,
        _ if holds.starts_with("number between") => json!({ "type": "number" }),
        _ if holds.starts_with("list of numbers") => list(&json!({ "type": "number" })),
        "`\"P(CONDITION) < NUMBER\"`" => text,
        _ if holds.starts_with('`') => json!({ "enum": words(holds) }),
        _ if TEXTS.iter().any(|begin| holds.starts_with(begin)) => text,
        _ => return None,
    })
}

/// Beginnings of the phrases for texts.
const TEXTS: [&str; 11] = [
    "text",
    "path",
    "letters",
    "up to 64 letters",
    "formula",
    "condition",
    "column",
    "parameter",
    "name of a question",
    "two of",
    "`\"P(",
];

/// Values of the tables whose keys the author of the study chooses, or the keys of a table.
fn table_of(name: &str) -> Value {
    match name {
        // Paths may be nested tables, too.
        "set" => json!({ "type": "object", "additionalProperties": { "type": ["number", "string", "object"] } }),
        "function" => json!({ "type": "object", "additionalProperties": { "type": "string" } }),
        _ => keys_of(&format!("[{name}]")),
    }
}

fn whole(least: u64, most: Option<u64>) -> Value {
    let mut whole = json!({ "type": "integer", "minimum": least });
    if let Some(most) = most {
        whole["maximum"] = json!(most);
    }
    whole
}

/// The quoted words of a phrase.
fn words(holds: &str) -> Vec<&str> {
    holds.split('"').skip(1).step_by(2).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_has_a_type_and_its_place() {
        let schema = schema();
        for key in STUDY_KEYS {
            assert!(value(key).is_some(), "{} {}: `{}` has no type", key.table, key.name, key.holds);
            let name = key.table.trim_matches(['[', ']']);
            let table = match (key.table, key.table.starts_with("[[")) {
                ("", _) => &schema,
                (_, true) => &schema["properties"][name]["items"],
                (_, false) => &schema["properties"][name],
            };
            assert_eq!(table["additionalProperties"], false, "{name}");
            assert!(table["properties"][key.name]["description"].is_string(), "{name} {}", key.name);
        }
        assert_eq!(schema["required"], json!(["schema"]));
    }

    #[test]
    fn words_are_read_from_the_phrase() {
        let schema = schema();
        let design = &schema["properties"]["design"]["properties"]["kind"]["enum"];
        assert_eq!(design.as_array().map(Vec::len), Some(7));
        assert_eq!(schema["properties"]["vary"]["items"]["properties"]["spacing"]["enum"], json!(["linear", "log"]));
    }
}
