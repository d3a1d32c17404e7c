//! Curves as columns of `answers/NAME.parquet`: the groups of a question one below the other.

use super::figures::Figures;
use super::input::{Group, Label};

/// Cells of a curve column.
#[derive(Debug, Clone, PartialEq)]
pub enum CurveCells {
    /// Numbers.
    Numbers(Vec<Option<f64>>),
    /// Words.
    Words(Vec<Option<String>>),
}

/// The curve of a question, with all its groups.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curve {
    /// Names and cells of the columns, all of equal length.
    pub columns: Vec<(String, CurveCells)>,
}

/// A point of a curve: place and figures.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePoint {
    /// Level; or the smallest and the largest value of a bin, equal for a single value.
    pub at: (Label, Label),
    /// Number of bad runs at this point.
    pub bad: u64,
    /// Figures at this point.
    pub figures: Figures,
}

impl Curve {
    /// A curve from groups and their points; `names`: the one or two columns that give the place of a point.
    #[must_use]
    pub fn of(groups: &[(Group, Vec<CurvePoint>)], names: &[&str]) -> Self {
        let mut columns: Vec<(String, CurveCells)> = Vec::new();
        let rows = || groups.iter().flat_map(|(group, points)| points.iter().map(move |point| (group, point)));
        if let Some((first, _)) = groups.first() {
            for (axis, _) in &first.0 {
                let labels = rows().map(|(group, _)| group.label(axis).cloned());
                columns.push((axis.clone(), cells(labels.collect())));
            }
        }
        for (at, name) in names.iter().enumerate() {
            let labels = rows().map(|(_, point)| Some(if at == 0 { point.at.0.clone() } else { point.at.1.clone() }));
            columns.push(((*name).to_owned(), cells(labels.collect())));
        }
        let numbers: [(&str, fn(&CurvePoint) -> Option<f64>); 7] = [
            ("n", |point| Some(point.figures.n as f64)),
            ("events", |point| point.figures.events.map(|events| events as f64)),
            ("bad", |point| Some(point.bad as f64)),
            ("estimate", |point| point.figures.estimate),
            ("estimate_if_bad_harmful", |point| point.figures.harmful),
            ("low", |point| point.figures.low),
            ("high", |point| point.figures.high),
        ];
        for (name, of) in numbers {
            columns.push((name.to_owned(), CurveCells::Numbers(rows().map(|(_, point)| of(point)).collect())));
        }
        Self { columns }
    }

    /// The numbers of a column.
    #[must_use]
    pub fn numbers(&self, name: &str) -> Option<&[Option<f64>]> {
        self.columns.iter().find_map(|(column, cells)| match cells {
            CurveCells::Numbers(numbers) if column == name => Some(numbers.as_slice()),
            _ => None,
        })
    }
}

/// Numeric cells if all labels are numbers, otherwise words.
fn cells(labels: Vec<Option<Label>>) -> CurveCells {
    let words = labels.iter().any(|label| matches!(label, Some(Label::Word(_))));
    if words {
        CurveCells::Words(labels.into_iter().map(|label| label.map(|label| label.to_string())).collect())
    } else {
        let number = |label: Option<Label>| if let Some(Label::Number(number)) = label { Some(number) } else { None };
        CurveCells::Numbers(labels.into_iter().map(number).collect())
    }
}
