//! `bladeoff schema`: the formats of machine and study files as JSON Schemas, generated from the tables of their keys.

mod machine;
mod study;

use super::error::CliError;
use super::exit::Exit;
use super::json::pretty;
use super::output::print_json;
use serde_json::{Map, Value, json};

/// Print the JSON Schema of machine or study files
///
/// Editors with a TOML language server (taplo, Even Better TOML) use it to complete keys, to show their meaning and to mark
/// mistakes: unknown keys, wrong types, words that are not allowed. The schema cannot check that parts of a file fit each
/// other; `bladeoff check` does.
///
/// The files that `bladeoff new` writes name their schema in the line that begins with #:schema, relative to the file.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff schema machine > machine.schema.json
  bladeoff schema study > study.schema.json")]
pub struct Args {
    /// Kind of file
    #[arg(value_enum)]
    format: Format,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Format {
    /// Machine files
    Machine,
    /// Study files
    Study,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let schema = match args.format {
        Format::Machine => machine::schema(),
        Format::Study => study::schema(),
    };
    print_json(&pretty(&schema))?;
    Ok(Exit::Ok)
}

/// The head of a schema with its root table, in the draft that TOML editors support.
fn document(title: &str, description: &str, root: Value) -> Value {
    let mut schema = json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": title,
        "description": description,
    });
    extend(&mut schema, root);
    schema
}

/// Adds the members of an object to another.
fn extend(object: &mut Value, more: Value) {
    if let (Value::Object(object), Value::Object(more)) = (object, more) {
        object.extend(more);
    }
}

/// A table with these keys and no others.
fn table(properties: Map<String, Value>, required: &[String]) -> Value {
    let mut table = json!({ "type": "object", "properties": properties, "additionalProperties": false });
    if !required.is_empty() {
        table["required"] = json!(required);
    }
    table
}

/// A string with a number and a unit; a dimensionless number (`unit` empty) needs no unit.
fn with_unit(unit: &str) -> Value {
    let optional = if unit.is_empty() { "?" } else { "" };
    let pattern = format!(r"^\s*[+-]?([0-9]|\.[0-9])[0-9_.]*([eE][+-]?[0-9]+)?(\s*([A-Za-z%°µμΩ]|1/).*){optional}\s*$");
    json!({ "type": "string", "pattern": pattern })
}
