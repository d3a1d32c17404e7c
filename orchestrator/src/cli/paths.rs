//! `bladeoff paths`: every parameter of a machine.

use super::error::CliError;
use super::exit::Exit;
use super::machine::MachineArgs;
use super::output::{print, print_json, width};
use bladeoff_answers::summary::{Align, TextTable, wrapped};
use bladeoff_model::machine::{ParamValue, PathInfo, PathKind};
use serde_json::{Value, json};

/// List every parameter path of a machine with its value, unit and meaning
///
/// `[set]` and `[[vary]]` of a study and `--set` of simulate and modes accept these paths, and any unique ending of a
/// path: `contact.gap` for `diaphragms.seal.contact.gap`.
///
/// Columns: path, value (or default), unit, allowed values, meaning. Each parameter is one line, for `grep`. On a narrow
/// terminal path and value come first and the rest below them.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bladeoff paths studies/machines/lab_rig.toml
  bladeoff paths studies/machines/lab_rig.toml \\
    | grep contact
  bladeoff paths studies/machines/lab_rig.toml --json \\
    | jq -r '.parameters[] | select(.default) | .path'")]
pub struct Args {
    #[command(flatten)]
    machine: MachineArgs,

    /// Print JSON: for each parameter path, result column, SI unit, value (in that unit; null if not given), value as shown, whether it
    /// is the default, kind, choices, what is allowed and meaning
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn main(args: &Args) -> Result<Exit, CliError> {
    let machine = args.machine.load()?;
    let paths = machine.paths();
    if args.json {
        print_json(&as_json(&paths))?;
        return Ok(Exit::Ok);
    }
    let table = table(&paths);
    print(&match width() {
        Some(width) => fitted(&table, &paths, width),
        None => table,
    })?;
    Ok(Exit::Ok)
}

fn table(paths: &[PathInfo]) -> String {
    let header = ["path", "value", "unit", "allowed", "meaning"].map(|name| (name, Align::Left));
    let mut table = TextTable::new(&header);
    for info in paths {
        let (path, shown, allowed) = (info.path.clone(), info.shown.clone(), info.allowed.clone());
        table.row(vec![path, shown, info.unit.to_owned(), allowed, info.meaning.to_owned()]);
    }
    table.render("")
}

/// The table if it fits into this width; otherwise a few lines for each parameter, which always fit.
fn fitted(table: &str, paths: &[PathInfo], width: usize) -> String {
    if table.lines().all(|line| line.chars().count() <= width) {
        return table.to_owned();
    }
    let mut text = String::new();
    for info in paths {
        let head = format!("{} = {}", info.path, info.shown);
        text.push_str(&wrapped(&head, width, "", "    "));
        text.push_str(&wrapped(&format!("{}; allowed: {}", info.meaning, info.allowed), width, "    ", "    "));
    }
    text
}

fn as_json(paths: &[PathInfo]) -> String {
    let parameter = |info: &PathInfo| {
        let value = match &info.value {
            None => Value::Null,
            Some(ParamValue::Number(number)) => json!(number),
            Some(ParamValue::Choice(word)) => json!(word),
        };
        let (kind, choices) = match info.kind {
            PathKind::Number => ("number", None),
            PathKind::Count => ("count", None),
            PathKind::Choice(words) => ("choice", Some(words)),
            PathKind::NumberOrChoice(words) => ("number or choice", Some(words)),
        };
        json!({
            "path": info.path,
            "column": info.column(),
            "unit": info.unit,
            "value": value,
            "shown": info.shown,
            "default": info.default,
            "kind": kind,
            "choices": choices,
            "allowed": info.allowed,
            "meaning": info.meaning,
        })
    };
    let object = json!({ "parameters": paths.iter().map(parameter).collect::<Vec<_>>() });
    let mut text = serde_json::to_string_pretty(&object).expect("strings and numbers always have a JSON form");
    text.push('\n');
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    #[test]
    fn lines_fit_the_terminal_and_lose_nothing() {
        let rig = include_str!("../../../studies/machines/lab_rig.toml");
        let paths = MachineDef::parse("lab_rig.toml", rig).expect("a machine").paths();
        let table = table(&paths);
        assert_eq!(fitted(&table, &paths, 1000), table);
        assert!(table.lines().any(|line| line.chars().count() > 120), "too wide for most terminals");
        for width in [60, 80, 120] {
            let text = fitted(&table, &paths, width);
            let longest = text.lines().map(|line| line.chars().count()).max();
            assert!(longest.is_some_and(|longest| longest <= width), "{longest:?} in {width}");
            let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>().join(" ");
            for info in &paths {
                assert!(words(&text).contains(&words(&format!("{} = {}", info.path, info.shown))), "{}", info.path);
                assert!(words(&text).contains(&words(info.meaning)), "{}", info.meaning);
            }
        }
    }
}
