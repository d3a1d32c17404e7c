//! The columns of the table of results: name, unit, meaning, meaning of an empty cell.

use super::{codes, head, row};
use crate::support::root;
use bladeoff_answers::tables::{Field, FieldKind, TableSchema};
use bladeoff_core::record::columns;
use bladeoff_model::machine::MachineDef;
use bladeoff_model::outcome::{Column, ColumnKind, Empty, Group, Growth, Part};
use std::fs;

pub fn page() -> String {
    let text = fs::read_to_string(root().join("studies/machines/lp_turbine_paper.toml")).expect("shipped");
    // with a pedestal, a monitor and a release, because they add columns
    let text = format!(
        "{text}\n[rotor.bearings.front.pedestal]\nstiffness = \"1e9 N/m\"\n[monitors.NAME]\nposition = \"1 m\"\ngap = \"1 mm\"\n\
         [rotor.unbalances.NAME]\nposition = \"4.55 m\"\nmass = \"1 kg\"\nradius = \"1 m\"\nrelease_time = \"1 s\"\n"
    );
    let machine = MachineDef::parse("lp_turbine_paper.toml", &text).and_then(|def| def.build()).expect("valid");
    let bearings: Vec<String> = machine.rotor.bearings.iter().map(|bearing| bearing.name.clone()).collect();
    let all = columns(&machine);
    let schema = TableSchema::new(Vec::new(), &all);
    let mut page = String::from("## Identity and status\n\n");
    page += &head(&["column", "meaning"]);
    let first = schema.fields().iter().take(schema.given());
    for Field { name, meaning, .. } in
        first.chain(schema.fields().iter().filter(|field| field.kind == FieldKind::Word).skip(6))
    {
        page += &row(&[format!("`{name}`"), meaning.clone()]);
    }
    for group in Group::ALL {
        let of_group: Vec<&Column> =
            all.iter().filter(|column| column.group == group && is_shown(column, &bearings)).collect();
        if of_group.is_empty() {
            continue;
        }
        page += &format!("\n## {}\n\n", group.heading());
        page += &head(&["column", "unit", "meaning", "empty if"]);
        for column in of_group {
            page += &described(column, &bearings);
        }
    }
    let guarded = all.iter().filter(|column| column.is_guarded && is_shown(column, &bearings));
    let names: Vec<String> = guarded.map(|column| general(&column.name, &bearings)).collect();
    page += "\n## Columns with a guarded value\n\n";
    page += "Each of these columns has a second one, `guarded_COLUMN`, with the value that it had reached while all guards and limits held. ";
    page += "It is empty if the status is `ok`.\n\n";
    for name in names {
        page += &format!("- `{name}`\n");
    }
    page
}

/// Whether a column is listed: of several bearings and sections only one is listed, and times and speeds of peaks are described once.
fn is_shown(column: &Column, bearings: &[String]) -> bool {
    let of_another = |name: &String| mentions(&column.name, name).is_some();
    let section = column.name.find("section").map(|at| &column.name[at + "section".len()..]);
    !matches!(column.part, Part::Guarded | Part::PeakTime | Part::PeakSpeed)
        && !bearings.iter().skip(1).any(of_another)
        && section.is_none_or(|rest| rest.starts_with('0'))
}

/// Position of the name of a bearing within the name of a column.
fn mentions(column: &str, bearing: &str) -> Option<usize> {
    column.find(&format!("_{bearing}_")).map(|at| at + 1)
}

/// The name of a column for any bearing and section.
fn general(name: &str, bearings: &[String]) -> String {
    let name = name.replace("section0", "sectionI");
    match bearings.first().and_then(|bearing| Some((mentions(&name, bearing)?, bearing.len()))) {
        Some((at, length)) => format!("{}NAME{}", &name[..at], &name[at + length..]),
        None => name,
    }
}

fn described(column: &Column, bearings: &[String]) -> String {
    let mut meaning = column.meaning.clone();
    if let Some(bearing) = bearings.first().filter(|bearing| mentions(&column.name, bearing).is_some()) {
        meaning = meaning.replace(&format!(" {bearing}"), " NAME");
    }
    meaning = meaning.replace("section 0", "section I");
    if let ColumnKind::Choice(words) = column.kind {
        meaning += &format!("; one of {}", codes(words));
    }
    match column.growth {
        Growth::Grows if column.kind == ColumnKind::Real && column.part == Part::Whole => meaning += "; only grows",
        _ if column.part == Part::Peak => {
            let name = general(&column.name, bearings);
            let peak = name.strip_suffix(&format!("_{}", column.unit.replace(' ', ""))).unwrap_or(&name);
            meaning += &format!("; time and mean spin: `{peak}_at_s`, `{peak}_at_rad_s`");
        }
        _ => {}
    }
    let empty = match (&column.lacks, column.empty) {
        (Some(part), _) => format!("the machine lacks {part}"),
        (None, Empty::Absent) => String::new(),
        (None, Empty::Unjudged) => "the run has no such quantity".to_owned(),
    };
    row(&[format!("`{}`", general(&column.name, bearings)), column.unit.to_owned(), meaning, empty])
}
