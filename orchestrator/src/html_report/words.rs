//! Formatting of numbers, groups and units on a page.

use crate::run::TableColumn;
use bladeoff_answers::ask::{Answer, Ask, Figure, Question};
use bladeoff_answers::estimate::input::{Group, Label};
use bladeoff_answers::figures::{Scale, plain_name};
use bladeoff_text::document::units::format_digits;
use std::collections::BTreeMap;

/// A share in per cent.
pub(super) fn percent(share: f64) -> String {
    format!("{} %", format_digits(100.0 * share, "", 2))
}

/// Status within a sentence.
pub(super) fn status_in_words(status: &str) -> &str {
    if status == "beyond" { "beyond the model" } else { status }
}

/// Status and cause: "ok", "invalid: energy_balance".
pub(super) fn kind_in_words((status, cause): &(String, String)) -> String {
    let status = status_in_words(status);
    if cause.is_empty() { status.to_owned() } else { format!("{status}: {cause}") }
}

/// Counts by status: "20 ok, 2 invalid", ok first.
pub(super) fn by_status(counts: &BTreeMap<String, u64>) -> String {
    let ok = counts.get("ok").map(|count| format!("{count} ok"));
    let others = counts.iter().filter(|(status, _)| *status != "ok");
    let others = others.map(|(status, count)| format!("{count} {}", status_in_words(status)));
    ok.into_iter().chain(others).collect::<Vec<_>>().join(", ")
}

/// Values of a group: "hyp1, contact.gap = 0.001"; empty for the only group of a study without varied parameters.
pub(super) fn group(group: &Group) -> String {
    let said = group.0.iter().map(|(path, label)| match label {
        Label::Word(word) => word.clone(),
        Label::Number(number) => format!("{path} = {number}"),
    });
    said.collect::<Vec<_>>().join(", ")
}

/// A group as a short chart label: "hyp1, gap 0.567 mm"; uses the last word of a path if that is unique.
pub(super) fn short_group(group: &Group, columns: &[TableColumn]) -> String {
    let last = |path: &str| plain_name(path.rsplit('.').next().unwrap_or(path), unit_of(columns, path));
    let said = group.0.iter().map(|(path, label)| match label {
        Label::Word(word) => word.clone(),
        Label::Number(number) => {
            let is_one = group.0.iter().filter(|(other, _)| last(other) == last(path)).count() == 1;
            let unit = unit_of(columns, path);
            let name = if is_one { last(path) } else { plain_name(path, unit) };
            format!("{name} {}", format_digits(*number, unit, 3))
        }
    });
    said.collect::<Vec<_>>().join(", ")
}

/// A group as a label that is never empty.
pub(super) fn group_or_all(of: &Group, columns: &[TableColumn]) -> String {
    let text = short_group(of, columns);
    if text.is_empty() { "all runs".to_owned() } else { text }
}

/// SI unit of a column.
pub(super) fn unit_of<'a>(columns: &'a [TableColumn], name: &str) -> &'a str {
    columns.iter().find(|column| column.field.name == name).map_or("", |column| column.field.unit.as_str())
}

/// Quantity and scale of a question's figure.
pub(super) struct Quantity {
    pub name: String,
    /// Kind of the quantity in one word.
    pub what: &'static str,
    pub scale: Scale,
}

impl Quantity {
    /// A probability, in per cent.
    pub fn share(name: impl Into<String>) -> Self {
        Self { name: name.into(), what: "probability", scale: Scale { factor: 100.0, unit: "%".to_owned() } }
    }

    /// A column with this largest magnitude.
    pub fn column(columns: &[TableColumn], column: &str, name: Option<String>, largest: f64) -> Self {
        let unit = unit_of(columns, column);
        Self { name: name.unwrap_or_else(|| plain_name(column, unit)), what: "value", scale: Scale::of(unit, largest) }
    }

    /// Quantity of a question for one number.
    pub fn of(question: &Question, columns: &[TableColumn], answers: &[&Answer]) -> Option<Self> {
        let (figure, is_difference) = match &question.ask {
            Ask::One(figure) => (figure, false),
            Ask::Difference(figure, ..) => (figure, true),
            _ => return None,
        };
        let largest =
            answers.iter().flat_map(|answer| numbers(answer)).fold(0.0_f64, |most, value| most.max(value.abs()));
        let of = |what: String, column: &str| {
            Self::column(
                columns,
                column,
                Some(format!("{what} of {}", plain_name(column, unit_of(columns, column)))),
                largest,
            )
        };
        let mut found = match figure {
            Figure::Probability(formula) => Self::share(format!("P({})", formula.text)),
            Figure::Quantile(share, column) => {
                of(format!("{} % quantile", format_digits(100.0 * share, "", 12)), column)
            }
            Figure::Mean(column) => of("mean".to_owned(), column),
        };
        match figure {
            Figure::Probability(_) => {}
            Figure::Quantile(..) => found.what = "quantile",
            Figure::Mean(_) => found.what = "mean",
        }
        if is_difference {
            found.name = format!("difference of {}", found.name);
            found.what = "difference";
        }
        Some(found)
    }

    /// Label of a vertical axis.
    pub fn short(&self) -> String {
        self.scale.label(self.what)
    }

    pub fn label(&self) -> String {
        self.scale.label(&self.name)
    }

    pub fn show(&self, value: f64) -> f64 {
        value * self.scale.factor
    }
}

/// All numbers of an answer.
pub(super) fn numbers(answer: &Answer) -> impl Iterator<Item = f64> + use<> {
    [answer.estimate, answer.estimate_if_bad_harmful, answer.low, answer.high].into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Availability;
    use bladeoff_answers::tables::{Field, FieldKind};

    #[test]
    fn a_group_beside_a_chart_has_the_last_word_of_its_path_and_a_unit_to_read() {
        let column = |name: &str, unit: &str| TableColumn {
            field: Field { name: name.into(), unit: unit.into(), meaning: String::new(), kind: FieldKind::Real },
            availability: Availability::Input,
            unjudged: false,
            lacks: None,
        };
        let columns = [column("diaphragms.seal.contact.gap_m", "m"), column("diaphragms.other.contact.gap_m", "m")];
        let at = |path: &str| (path.to_owned(), Label::Number(0.000_566_666_666_666_666_7));
        let one = Group(vec![("detection".into(), Label::Word("hyp1".into())), at("diaphragms.seal.contact.gap_m")]);
        assert_eq!(short_group(&one, &columns), "hyp1, gap 0.567 mm");
        let two = Group(vec![at("diaphragms.seal.contact.gap_m"), at("diaphragms.other.contact.gap_m")]);
        let both = "diaphragms seal contact gap 0.567 mm, diaphragms other contact gap 0.567 mm";
        assert_eq!(short_group(&two, &columns), both);
        assert_eq!(group_or_all(&Group::default(), &columns), "all runs");
    }
}
