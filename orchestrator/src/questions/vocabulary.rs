//! Names that questions of a study may use: columns of its table, and their aliases.

use crate::run::{TableColumn, columns_of, columns_without};
use bladeoff_answers::ask::{Ask, Given, Known, Names, Question};
use bladeoff_answers::estimate::along::families;
use bladeoff_answers::estimate::input::{Group, Label};
use bladeoff_answers::tables::{DETECTION, FieldKind};
use bladeoff_model::machine::{MachineDef, ParamValue};
use bladeoff_study::{Origin, Parameter, Samples};
use std::collections::BTreeSet;

/// Names and columns of a study's table.
pub(super) struct Vocabulary<'a> {
    pub names: Names,
    pub columns: Vec<TableColumn>,
    /// Combinations of the values of `[[vary]]`, by the names of their columns.
    pub groups: Vec<Group>,
    /// Parameters that differ from sample to sample.
    pub parameters: &'a [Parameter],
    pub machine: Option<&'a MachineDef>,
    /// Columns of uncertain parameters with words, and their words.
    words: Vec<(String, Vec<String>)>,
}

impl<'a> Vocabulary<'a> {
    /// Names of the samples' study; `None` if the machine cannot be built, which is reported elsewhere.
    pub fn of(samples: &'a Samples) -> Option<Self> {
        let columns = columns_of(samples)?;
        let parameters = samples.parameters();
        let column = |name: &str| {
            let found = parameters.iter().find(|parameter| parameter.info.path == name);
            found.map_or_else(|| name.to_owned(), column_of)
        };
        let group = |values: Vec<(String, ParamValue)>| {
            Group(values.into_iter().map(|(name, value)| (column(&name), label(value))).collect())
        };
        let is_design = samples.layout().is_some();
        // without a design each sample is a point of its own, and its parameters are ordinary columns
        let groups: Vec<Group> =
            if is_design { samples.groups().into_iter().map(group).collect() } else { vec![Group::default()] };
        let is_uncertain = |parameter: &&Parameter| matches!(parameter.origin, Origin::Uncertain(_));
        let is_varied = |parameter: &&Parameter| matches!(parameter.origin, Origin::Varied(..));
        let values = |parameter: &Parameter| {
            let mut values: Vec<Label> = Vec::new();
            let column = column_of(parameter);
            if let (false, Origin::Varied(axis, member)) = (is_design, parameter.origin) {
                let axis = &samples.study().axes[axis];
                let all = (0..axis.length.min(MOST_VALUES)).map(|at| label(axis.varied[member].values.at(at)));
                all.for_each(|label| {
                    if !values.contains(&label) {
                        values.push(label);
                    }
                });
            }
            for label in groups.iter().filter_map(|group| group.label(&column)) {
                if !values.contains(label) {
                    values.push(label.clone());
                }
            }
            (column, values)
        };
        let known = Known {
            columns: columns.iter().map(|column| (column.field.name.clone(), is_number(column.field.kind))).collect(),
            aliases: aliases(parameters),
            lacking: lacking(&columns),
            units: units(&columns, |name| {
                let is_it = |parameter: &&Parameter| column_of(parameter) == name;
                let found = parameters.iter().find(is_it);
                samples.study().machine().is_none() || found.is_some_and(|parameter| parameter.is_variable)
            }),
        };
        let names = Names {
            known,
            uncertain: parameters.iter().filter(is_uncertain).map(column_of).collect(),
            varied: parameters.iter().filter(is_varied).map(values).collect(),
            recurring: recurring(samples, &groups),
            given: parameters.iter().map(given).collect(),
        };
        let machine = samples.study().machine().map(|machine| &machine.def);
        let laws = samples.study().sampled.values.laws();
        let words = parameters.iter().filter_map(|parameter| {
            let Origin::Uncertain(law) = parameter.origin else { return None };
            Some((column_of(parameter), laws.get(law)?.words()?.to_vec()))
        });
        let words = words.collect();
        Some(Self { names, columns, groups, parameters, machine, words })
    }

    /// Names of a study with errors, of which only the machine may be known; formula studies have no machine. `None` if the machine cannot be
    /// built either, so that the columns are unknown.
    pub fn of_machine(machine: Option<&'a MachineDef>) -> Option<Self> {
        let columns = match machine {
            Some(machine) => columns_without(Some(&machine.build().ok()?)),
            None => columns_without(None),
        };
        let known = columns.iter().map(|column| (column.field.name.clone(), is_number(column.field.kind))).collect();
        let names = Names {
            known: Known {
                columns: known,
                units: units(&columns, |_| false),
                lacking: lacking(&columns),
                ..Known::default()
            },
            ..Names::default()
        };
        Some(Self { names, columns, groups: Vec::new(), parameters: &[], machine, words: Vec::new() })
    }

    /// Adds names from the file whose definitions could not be read, so that they cause no further errors; a missing column may be due to one of
    /// them.
    pub fn mention(&mut self, names: &[String]) {
        for name in names {
            let key = name.rsplit('.').next().unwrap_or(name);
            let needs_it = |why: &str| why.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == key);
            self.names.known.lacking.retain(|(_, why)| !needs_it(why));
            if !self.names.known.meant(name).is_empty() {
                continue;
            }
            let path = self.machine.and_then(|machine| machine.find(name).ok());
            let endings = name.match_indices('.').map(|(dot, _)| name[dot + 1..].to_owned());
            let aliases = endings.chain(path.iter().flat_map(|info| [info.column(), info.path.clone()]));
            self.names.known.aliases.extend(aliases.map(|alias| (alias, name.clone())));
            self.names.known.columns.push((name.clone(), true));
            self.names.uncertain.push(name.clone());
            self.names.varied.push((name.clone(), Vec::new()));
            let column = name.clone();
            self.names.given.push(Given { column, axis: None, is_angle: false, is_detection: false });
        }
    }

    /// Possible words of a column, in order; `None` for a column of numbers.
    pub fn words_of(&self, column: &str) -> Option<Vec<String>> {
        if let Some((_, words)) = self.words.iter().find(|(name, _)| name == column) {
            return Some(words.clone());
        }
        match self.columns.iter().find(|known| known.field.name == column)?.field.kind {
            FieldKind::Choice(words) => Some(words.iter().map(|word| (*word).to_owned()).collect()),
            FieldKind::Word => {
                let varied = self.names.varied.iter().find(|(name, _)| name == column);
                let word = |label: &Label| if let Label::Word(word) = label { Some(word.clone()) } else { None };
                Some(varied.map(|(_, labels)| labels.iter().filter_map(word).collect()).unwrap_or_default())
            }
            _ => None,
        }
    }

    /// The numeric column along which a curve runs.
    pub fn axis_of(&self, question: &Question) -> Option<String> {
        let Ask::Fragility(column, _) = &question.ask else { return None };
        self.names.known.is_number(column).then(|| column.clone())
    }
}

fn is_number(kind: FieldKind) -> bool {
    matches!(kind, FieldKind::Real | FieldKind::Count | FieldKind::Integer)
}

/// Zipped parameters whose values recur, and the error message for them.
fn recurring(samples: &Samples, groups: &[Group]) -> Vec<(String, String)> {
    let zipped = samples.study().axes.iter().filter(|axis| axis.varied.len() > 1 && samples.layout().is_some());
    let of_axis = |path: &String| samples.parameters().iter().find(|parameter| parameter.info.path == *path);
    let columns = zipped.flat_map(|axis| axis.varied.iter().map(|varied| &varied.info.path)).filter_map(of_axis);
    let why = |column: String| families(groups, &column).err().map(|why| (column, why.to_string()));
    columns.map(column_of).filter_map(why).collect()
}

/// Largest number of values of an axis that are distinguished without a design; axes with more have no panels.
const MOST_VALUES: u64 = 1000;

fn given(parameter: &Parameter) -> Given {
    Given {
        column: column_of(parameter),
        axis: if let Origin::Varied(axis, _) = parameter.origin { Some(axis) } else { None },
        is_angle: parameter.is_angle(),
        is_detection: parameter.is_detection(),
    }
}

/// Columns that cannot be used in questions, and the runs in which they are empty.
fn lacking(columns: &[TableColumn]) -> Vec<(String, String)> {
    let guarded: BTreeSet<&str> = columns.iter().filter_map(|column| column.availability.guarded_column()).collect();
    let why = |column: &TableColumn| {
        let name = column.field.name.as_str();
        let lacks = column.lacks.as_ref().map(|needed| format!("every run: the machine needs {needed}"));
        lacks.or_else(|| {
            let of = name.strip_prefix("guarded_").filter(|_| guarded.contains(name))?;
            Some(format!("ok runs: use `{of}`, which counts the guarded value of the other runs"))
        })
    };
    columns.iter().filter_map(|column| Some((column.field.name.clone(), why(column)?))).collect()
}

/// Units of numeric columns, except those for which `has_none` is true.
fn units(columns: &[TableColumn], has_none: impl Fn(&str) -> bool) -> Vec<(String, String)> {
    let fields = columns.iter().map(|column| &column.field).filter(|field| is_number(field.kind));
    let with = fields.filter(|field| !has_none(&field.name));
    with.map(|field| (field.name.clone(), field.unit.clone())).collect()
}

/// A parameter value as a label of the answers package.
pub(super) fn label(value: ParamValue) -> Label {
    match value {
        ParamValue::Number(number) => Label::Number(number),
        ParamValue::Choice(word) => Label::Word(word),
    }
}

/// Table column of a parameter.
pub(super) fn column_of(parameter: &Parameter) -> String {
    if parameter.is_detection() { DETECTION.to_owned() } else { parameter.column().name }
}

/// Aliases of the parameters: short names, paths, and the parts of paths and columns behind a dot.
fn aliases(parameters: &[Parameter]) -> Vec<(String, String)> {
    let mut aliases: Vec<(String, String)> = Vec::new();
    // a complete name refers to its own parameter, whatever other names end with it
    let whole =
        |name: &str| parameters.iter().any(|other| other.info.path == name || other.short.as_deref() == Some(name));
    for parameter in parameters {
        let column = column_of(parameter);
        let mut add = |alias: &str| {
            let pair = (alias.to_owned(), column.clone());
            if !aliases.contains(&pair) {
                aliases.push(pair);
            }
        };
        parameter.short.iter().chain([&parameter.info.path]).for_each(|name| add(name));
        for name in [&parameter.info.path, &column] {
            let endings = name.match_indices('.').map(|(dot, _)| &name[dot + 1..]);
            endings.filter(|ending| !whole(ending)).for_each(&mut add);
        }
    }
    aliases
}
