//! Questions of a study: from the text of the study file to validated columns and conditions.

use super::method::{Sensitivity, SensitivityMethod};
use crate::estimate::formula::{Formula, Known};
use crate::estimate::input::Label;
use crate::map::{Of, REGIME, Wanted};
use bladeoff_text::document::nearest;
use bladeoff_text::formula::FormulaError;
use std::ops::Range;

/// Default confidence level.
pub const CONFIDENCE: f64 = 0.95;

/// A question as written in a study file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct QuestionDef {
    /// Name, `[A-Za-z0-9_-]+`.
    pub name: String,
    /// Condition whose probability is asked.
    pub probability: Option<String>,
    /// Level of a quantile, between 0 and 1, with `of`.
    pub quantile: Option<f64>,
    /// Column of a quantile or map; a map also accepts `P(CONDITION)` or a condition.
    pub of: Option<String>,
    /// Two parameters of a map, with `of`.
    pub map: Option<[String; 2]>,
    /// Column whose mean is asked.
    pub mean: Option<String>,
    /// Column whose exceedance curve is asked.
    pub exceedance: Option<String>,
    /// Output column of a sensitivity, with `method`.
    pub sensitivity: Option<String>,
    /// Estimator of the sensitivity, one of [`SensitivityMethod::ALL`].
    pub method: Option<String>,
    /// Varied or uncertain parameter of a fragility curve, with `probability`.
    pub fragility: Option<String>,
    /// Two values of `vary`, with a probability, a quantile or a mean.
    pub difference: Option<[Label; 2]>,
    /// Varied parameter of a difference.
    pub vary: Option<String>,
    /// Confidence level, between 0 and 1.
    pub confidence: Option<f64>,
}

/// Names that a question may use.
#[derive(Debug, Clone, Default)]
pub struct Names {
    /// Columns of the table.
    pub known: Known,
    /// Columns of uncertain parameters and variables.
    pub uncertain: Vec<String>,
    /// Columns of crossed axes and their values; the values are empty where the axis could not be read.
    pub varied: Vec<(String, Vec<Label>)>,
    /// Columns along which groups cannot be compared (zipped values that recur), and the reason.
    pub recurring: Vec<(String, String)>,
    /// Parameters and variables: the inputs of a run.
    pub given: Vec<Given>,
}

impl Names {
    /// Whether a column is uncertain. A parameter of a file that could not be read is in both lists and does not count as uncertain.
    pub(super) fn is_drawn(&self, column: &String) -> bool {
        self.uncertain.contains(column) && !self.varied.iter().any(|(axis, _)| axis == column)
    }
}

/// A parameter or a variable of a study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Given {
    /// Column of the parameter.
    pub column: String,
    /// Index of its axis in `[[vary]]` or `[points]`.
    pub axis: Option<usize>,
    /// Whether the column is a release angle, whose values differ only within the starts of a map cell.
    pub is_angle: bool,
    /// Whether the column is the contact detection, whose values are compared with each other.
    pub is_detection: bool,
}

/// An error in a question.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Key of the question with the error.
    pub key: &'static str,
    /// Byte range within the value, for a formula.
    pub place: Option<Range<usize>>,
    /// Error message.
    pub message: String,
    /// Allowed values, where known.
    pub allowed: Option<String>,
}

/// Largest number of names that an error message lists.
const LISTED: usize = 8;

/// One number about the runs.
#[derive(Debug, Clone, PartialEq)]
pub enum Figure {
    /// Probability that a condition holds.
    Probability(Formula),
    /// Quantile: level and column.
    Quantile(f64, String),
    /// Mean of a column.
    Mean(String),
}

/// Kind and operands of a question.
#[derive(Debug, Clone, PartialEq)]
pub enum Ask {
    /// One number.
    One(Figure),
    /// Probability that a column exceeds a level, for all levels.
    Exceedance(String),
    /// Probability of a condition as a function of a parameter.
    Fragility(String, Formula),
    /// Difference of a figure between the first and the second value of a varied parameter.
    Difference(Figure, String, [Label; 2]),
    /// A column or a probability over two parameters.
    Map(Wanted),
    /// Sensitivity of a column to the uncertain parameters.
    Sensitivity(Sensitivity),
}

/// A validated question.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// Name of the question.
    pub name: String,
    /// Kind and operands.
    pub ask: Ask,
    /// Confidence level of the interval.
    pub confidence: f64,
}

impl Question {
    /// Columns that the question reads.
    #[must_use]
    pub fn columns(&self, names: &Names) -> Vec<String> {
        let of = |figure: &Figure| match figure {
            Figure::Probability(formula) => formula.columns.clone(),
            Figure::Quantile(_, column) | Figure::Mean(column) => vec![column.clone()],
        };
        match &self.ask {
            Ask::One(figure) | Ask::Difference(figure, ..) => of(figure),
            Ask::Exceedance(column) => vec![column.clone()],
            Ask::Map(wanted) => {
                let mut columns = vec![wanted.x.clone(), wanted.y.clone()];
                match &wanted.of {
                    Of::Value(column) => columns.push(column.clone()),
                    Of::Probability(formula) => columns.extend(formula.columns.iter().cloned()),
                }
                columns.extend(wanted.panels.iter().chain(&wanted.starts).cloned());
                columns
                    .extend(names.known.columns.iter().map(|(name, _)| name).filter(|name| *name == REGIME).cloned());
                columns
            }
            Ask::Sensitivity(Sensitivity { output, method, parameters, regime }) => {
                let given = parameters.iter().filter(|_| *method == SensitivityMethod::GivenData);
                [output].into_iter().chain(given).chain(regime).cloned().collect()
            }
            Ask::Fragility(path, formula) => {
                let mut columns = formula.columns.clone();
                if !names.varied.iter().any(|(axis, _)| axis == path) {
                    columns.push(path.clone());
                }
                columns
            }
        }
    }

    /// Validates a question of a study file.
    ///
    /// # Errors
    /// All errors of the question.
    pub fn new(def: &QuestionDef, names: &Names) -> Result<Self, Vec<Problem>> {
        let mut check = Check { names, problems: Vec::new() };
        let ask = check.ask(def);
        check.name(&def.name);
        let confidence = check.part("confidence", def.confidence.unwrap_or(CONFIDENCE));
        match (ask, confidence) {
            (Some(ask), Some(confidence)) if check.problems.is_empty() => {
                Ok(Self { name: def.name.clone(), ask, confidence })
            }
            _ => Err(check.problems),
        }
    }
}

pub(super) struct Check<'a> {
    pub names: &'a Names,
    problems: Vec<Problem>,
}

impl Check<'_> {
    pub(super) fn wrong<T>(&mut self, key: &'static str, message: impl Into<String>) -> Option<T> {
        self.problems.push(Problem { key, place: None, message: message.into(), allowed: None });
        None
    }

    /// As [`Check::wrong`], with the allowed names: those that contain the given name first.
    pub(super) fn none_of<T>(
        &mut self,
        key: &'static str,
        message: impl Into<String>,
        (given, what, mut names): (&str, &str, Vec<&str>),
    ) -> Option<T> {
        let given = given.to_lowercase();
        names.sort_by_key(|name| given.is_empty() || !name.to_lowercase().contains(&given));
        let more = names.len().saturating_sub(LISTED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        names.truncate(LISTED);
        let allowed = if names.is_empty() {
            format!("{what}: this study has none")
        } else {
            format!("{what}: {}{more}", names.join(", "))
        };
        self.problems.push(Problem { key, place: None, message: message.into(), allowed: Some(allowed) });
        None
    }

    fn name(&mut self, name: &str) {
        let allowed = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if name.is_empty() || !name.chars().all(allowed) {
            self.wrong::<()>("name", "a name consists of letters, digits, `_` and `-`, because it names a file");
        } else if name.len() > 100 {
            self.wrong::<()>("name", "a name has 100 characters at most");
        }
    }

    fn part(&mut self, key: &'static str, value: f64) -> Option<f64> {
        if value > 0.0 && value < 1.0 {
            Some(value)
        } else {
            self.wrong(key, format!("{value} is not between 0 and 1"))
        }
    }

    fn condition(&mut self, text: &str) -> Option<Formula> {
        self.condition_in("probability", text, 0)
    }

    /// A condition that begins `from` bytes into the value of a key.
    pub(super) fn condition_in(&mut self, key: &'static str, text: &str, from: usize) -> Option<Formula> {
        match Formula::condition(text, &self.names.known) {
            Ok(formula) => Some(formula),
            Err(FormulaError { place, message }) => {
                let place = Some(place.start + from..place.end + from);
                self.problems.push(Problem { key, place, message, allowed: None });
                None
            }
        }
    }

    pub(super) fn column(&mut self, key: &'static str, name: &str) -> Option<String> {
        let known = &self.names.known;
        match known.meant(name)[..] {
            [column] if known.is_number(column) => match known.lacks(column) {
                Some(why) => self.wrong(key, why),
                None => Some(column.to_owned()),
            },
            ref found @ ([] | [_]) => {
                let message = match found {
                    [column] => format!("`{column}` is a column of words, not of numbers"),
                    _ => {
                        let near = known.near(name).map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
                        format!("there is no column `{name}`{near}")
                    }
                };
                // inputs of a run are not offered as outputs
                let is_output = |column: &&str| {
                    known.is_number(column)
                        && !["sample", "replicate", "block"].contains(column)
                        && !self.names.given.iter().any(|given| given.column == **column)
                };
                let outputs = known.columns.iter().map(|(column, _)| column.as_str()).filter(is_output).collect();
                self.none_of(key, message, (name, "a column of numbers", outputs))
            }
            ref several => self.wrong(key, format!("`{name}` could be {}", several.join(" or "))),
        }
    }

    /// The single question that the definition asks.
    fn ask(&mut self, def: &QuestionDef) -> Option<Ask> {
        let given = [
            ("probability", def.probability.is_some()),
            ("quantile", def.quantile.is_some()),
            ("mean", def.mean.is_some()),
            ("exceedance", def.exceedance.is_some()),
            ("map", def.map.is_some()),
            ("sensitivity", def.sensitivity.is_some()),
        ];
        let given: Vec<&'static str> = given.into_iter().filter(|(_, is)| *is).map(|(key, _)| key).collect();
        if given.len() != 1 {
            let all = "`probability`, `quantile` (with `of`), `mean`, `exceedance`, `sensitivity` (with `method`) or `map` (with `of`), the first with `fragility`, the first three with `difference` and `vary`";
            let found = if given.is_empty() { "none".to_owned() } else { given.join(" and ") };
            return self.wrong("name", format!("a question asks for one of {all}; here is {found}"));
        }
        if def.of.is_some() && def.quantile.is_none() && def.map.is_none() {
            self.wrong::<()>("of", "`of` belongs to `quantile` and `map`");
        }
        if def.vary.is_some() != def.difference.is_some() {
            self.wrong::<()>("vary", "`difference = [a, b]` and `vary = PATH` belong together");
        }
        if let Some(axes) = &def.map {
            return self.map(def, axes).map(Ask::Map);
        }
        if let Some(column) = &def.sensitivity {
            return self.sensitivity(def, column).map(Ask::Sensitivity);
        }
        if def.method.is_some() {
            self.wrong::<()>("method", "`method` belongs to `sensitivity`");
        }
        if let Some(column) = &def.exceedance {
            if def.difference.is_some() || def.fragility.is_some() {
                self.wrong::<()>("exceedance", "a curve has no difference and no fragility");
            }
            return self.column("exceedance", column).map(Ask::Exceedance);
        }
        if let Some(path) = &def.fragility {
            if def.difference.is_some() {
                self.wrong::<()>("fragility", "a fragility has no difference");
            }
            let path = self.parameter(path);
            let Some(text) = &def.probability else {
                return self.wrong("fragility", "`fragility` is that of a `probability`");
            };
            let condition = self.condition(text);
            let path = self.comparable("fragility", path?);
            return Some(Ask::Fragility(path?, condition?));
        }
        let figure = self.figure(def);
        match (&def.difference, &def.vary) {
            (Some(values), Some(path)) => {
                let values = self.pair(values, path);
                let (axis, values) = values?;
                let axis = self.comparable("vary", axis);
                Some(Ask::Difference(figure?, axis?, values))
            }
            _ => figure.map(Ask::One),
        }
    }

    fn figure(&mut self, def: &QuestionDef) -> Option<Figure> {
        if let Some(text) = &def.probability {
            return self.condition(text).map(Figure::Probability);
        }
        if let Some(u) = def.quantile {
            let u = self.part("quantile", u);
            let Some(column) = &def.of else { return self.wrong("quantile", "`quantile` needs `of = COLUMN`") };
            let column = self.column("of", column);
            return Some(Figure::Quantile(u?, column?));
        }
        self.column("mean", def.mean.as_ref()?).map(Figure::Mean)
    }

    /// A parameter that is varied or uncertain.
    fn parameter(&mut self, path: &str) -> Option<String> {
        let all = self.names.varied.iter().map(|(axis, _)| axis).chain(&self.names.uncertain);
        let mut all: Vec<&str> = all.map(String::as_str).collect();
        // in a file with errors a parameter may be in both lists
        all.sort_unstable();
        all.dedup();
        match self.one_of(path, &all)[..] {
            [column] => Some(column.to_owned()),
            [] => {
                let near = self.near(path, &all);
                let message = format!("`{path}` is neither varied nor uncertain{near}");
                self.none_of("fragility", message, (path, "a varied or an uncertain parameter", all))
            }
            ref several => self.wrong("fragility", format!("`{path}` could be {}", several.join(" or "))),
        }
    }

    /// Checks that groups can be compared along a parameter.
    fn comparable(&mut self, key: &'static str, column: String) -> Option<String> {
        match self.names.recurring.iter().find(|(name, _)| *name == column) {
            Some((_, why)) => self.wrong(key, why),
            None => Some(column),
        }
    }

    /// The columns that a name may refer to.
    pub(super) fn one_of<'n>(&self, name: &str, columns: &[&'n str]) -> Vec<&'n str> {
        let meant = self.names.known.meant(name);
        columns.iter().copied().filter(|column| *column == name || meant.contains(column)).collect()
    }

    /// Suggestion of similar column names or aliases, for an error message.
    pub(super) fn near(&self, name: &str, columns: &[&str]) -> String {
        let aliases = self.names.known.aliases.iter().filter(|(_, column)| columns.contains(&column.as_str()));
        near(name, columns.iter().copied().chain(aliases.map(|(alias, _)| alias.as_str())))
    }

    pub(super) fn pair(&mut self, values: &[Label; 2], path: &str) -> Option<(String, [Label; 2])> {
        let names = self.names;
        let all: Vec<&str> = names.varied.iter().map(|(axis, _)| axis.as_str()).collect();
        let axis = match self.one_of(path, &all)[..] {
            [axis] => axis,
            [] => {
                let near = self.near(path, &all);
                let message = format!("`{path}` is not varied{near}");
                return self.none_of("vary", message, (path, "a varied parameter", all));
            }
            ref several => return self.wrong("vary", format!("`{path}` could be {}", several.join(" or "))),
        };
        let known = names.varied.iter().find(|(name, _)| name == axis).map(|(_, known)| known.as_slice());
        let known = known.unwrap_or_default();
        if values[0] == values[1] {
            self.wrong::<()>("difference", format!("both are {}", values[0]));
        }
        let words: Vec<String> = known.iter().map(ToString::to_string).collect();
        let mut fine = true;
        for value in values {
            // the list is empty for an axis that could not be read
            if !known.is_empty() && !known.contains(value) {
                fine = false;
                let near = near(&value.to_string(), words.iter().map(String::as_str));
                self.wrong::<()>(
                    "difference",
                    format!("{value} is not a value of `{path}`: {}{near}", words.join(", ")),
                );
            }
        }
        fine.then(|| (axis.to_owned(), values.clone()))
    }
}

pub(super) fn near<'n>(given: &str, names: impl Iterator<Item = &'n str>) -> String {
    nearest(given, names).map(|name| format!("; did you mean `{name}`?")).unwrap_or_default()
}
