//! Sensitivities from any table of random points, regardless of its design.
//!
//! ```text
//! rows with a number --> spearman, rank regression (regression.rs)      t of 16 parts, each left out once (jackknife)
//!                    --> first order by ranks (successor.rs)            independent points: t of 16 parts, each alone;
//!                                                                       replicates: t, each left out once
//!                    --> HSIC with a p-value, the first 2000 rows       none
//! ```
//! The parts are every 16th row of independent points, or the replicates of the design. For first orders of independent points each part is
//! evaluated alone: leaving rows out changes the neighbours of the others and overestimates the scatter (measured coverage 98 to 99 % instead
//! of 95 %). A replicate of a sequence alone is biased, because its neighbours depend on each other, so there one replicate is left out at a
//! time. Words have no order: they have a first order and a dependence, but no correlation and no regression coefficient.
//! Sources of the intervals: M. H. Quenouille (1956), J. W. Tukey (1958); B. W. Schmeiser (1982).

use super::blocks::{Blocks, counted, number};
use super::hsic::{Centred, MOST_ROWS, Similar};
use super::indices::{Hsic, Index, Indices, OfParameter, SensitivityError};
use super::ranks::Ordered;
use super::regression::{Regression, of_ranks};
use super::successor::{FEWEST_FOR_SUCCESSORS, of_order};
use bladeoff_numerics::probability::student;

/// Number of parts of independent points.
const PARTS: usize = 16;

/// Smallest number of rows for an interval.
pub const FEWEST_ROWS: usize = 2 * PARTS;

/// Values of a parameter.
#[derive(Debug, Clone)]
pub struct Input<'a> {
    /// Name of the parameter.
    pub name: String,
    /// Value of each row; words as indices into their list.
    pub values: &'a [f64],
    /// Whether the values are words.
    pub has_words: bool,
}

/// Parts of the rows from which intervals are estimated.
#[derive(Debug, Clone)]
pub enum Parts<'a> {
    /// Independent points, divided evenly.
    Independent,
    /// The replicate of each row, and the number of replicates.
    Replicates(&'a [u32], usize),
    /// No interval, and the reason.
    Without(String),
}

/// The parameters of a table and one output.
#[derive(Debug, Clone)]
pub struct Given<'a> {
    /// Parameters of the table.
    pub inputs: Vec<Input<'a>>,
    /// Output of each row; `None` without a number.
    pub output: &'a [Option<f64>],
    /// Parts from which intervals are estimated.
    pub parts: Parts<'a>,
}

/// Half widths from the scatter of parts, each left out in turn or each alone.
struct Scatter {
    parts: usize,
    t: f64,
}

impl Scatter {
    fn index(&self, estimate: f64, parts: &[f64], left_out: bool) -> Index {
        let n = self.parts as f64;
        let mean = parts.iter().sum::<f64>() / n;
        let squares: f64 = parts.iter().map(|value| (value - mean) * (value - mean)).sum();
        let error = libm::sqrt(if left_out { (n - 1.0) / n * squares } else { squares / (n * (n - 1.0)) });
        let half = self.t * error;
        let known = estimate.is_finite() && half.is_finite();
        let end = |value: f64| known.then_some(value);
        Index {
            low: end(estimate - half),
            high: end(estimate + half),
            ..Index::alone(Some(estimate).filter(|e| e.is_finite()))
        }
    }
}

/// All indices that need no special design.
///
/// # Errors
/// Columns have different lengths.
pub fn given_data(given: &Given<'_>, alpha: f64) -> Result<Indices, SensitivityError> {
    let of = given.output.len();
    check(given)?;
    let rows: Vec<usize> = (0..of).filter(|row| number(given.output[*row]).is_some()).collect();
    let n = rows.len();
    let y: Vec<f64> = rows.iter().filter_map(|row| given.output[*row]).collect();
    let columns: Vec<Vec<f64>> =
        given.inputs.iter().map(|input| rows.iter().map(|row| input.values[*row]).collect()).collect();
    let mut notes = Vec::new();
    Blocks::new(given.output, 1).told("rows", &mut notes);
    let (part, parts): (Vec<u32>, usize) = match &given.parts {
        Parts::Independent => ((0..n).map(|row| (row % PARTS) as u32).collect(), PARTS),
        Parts::Replicates(of, parts) => (rows.iter().map(|row| of[*row]).collect(), *parts),
        Parts::Without(why) => {
            notes.push(why.clone());
            (Vec::new(), 0)
        }
    };
    let mut scatter = (parts >= PARTS).then(|| Scatter { parts, t: student(parts as f64 - 1.0, alpha) });
    if parts > 0 && parts < PARTS {
        let parts = counted(parts, "replicates");
        notes.push(format!("no interval: {parts} show too little of the scatter, {PARTS} are enough"));
    } else if parts > 0 && n < FEWEST_ROWS {
        let rows = counted(n, "rows");
        notes.push(format!("no interval: {rows} of {FEWEST_ROWS} needed"));
        scatter = None;
    }
    let inputs: Vec<Ordered<'_>> = columns.iter().map(|values| Ordered::new(values)).collect();
    let output = Ordered::new(&y);
    let mut found = vec![OfParameter::default(); inputs.len()];
    let (mut r2, mut without) = (None, None);
    if n == 0 {
        without = Some("no row has a value");
    } else if n == 1 {
        without = Some("one row does not vary");
    } else if output.is_constant() {
        without = Some("the output does not vary");
        notes.push("the output does not vary: it has no drivers".to_owned());
    } else {
        r2 = ranked(given, (&inputs, &output), (&part, scatter.as_ref()), &mut found, &mut notes);
        let left_out = matches!(given.parts, Parts::Replicates(..));
        first_orders((&inputs, &y), (&part, left_out, scatter.as_ref()), &mut found, &mut notes);
        dependences(given, (&columns, &y), &mut found, &mut notes);
    }
    // a single row gets no note: `without` gives the reason
    for (input, _) in given.inputs.iter().zip(&inputs).filter(|(_, ordered)| n > 1 && ordered.is_constant()) {
        notes.push(format!("{} does not vary", input.name));
    }
    Ok(Indices {
        of: given.inputs.iter().map(|input| input.name.clone()).zip(found).collect(),
        pairs: Vec::new(),
        r2,
        interval: if scatter.is_some() { "replicates-t" } else { "none" },
        n: n as u64,
        left_out: (of - n) as u64,
        without,
        notes,
    })
}

/// Checks that columns have equal lengths and parts exist.
pub(super) fn check(given: &Given<'_>) -> Result<(), SensitivityError> {
    let rows = given.output.len();
    if given.inputs.is_empty() {
        return Err(SensitivityError::Parameters);
    }
    let lengths = given.inputs.iter().map(|input| (input.name.clone(), input.values.len()));
    let parts = match &given.parts {
        Parts::Replicates(of, parts) => {
            if let Some(row) = of.iter().position(|part| *part as usize >= *parts) {
                return Err(SensitivityError::Part { row, found: of[row] as usize, parts: *parts });
            }
            Some(("parts".to_owned(), of.len()))
        }
        _ => None,
    };
    match lengths.chain(parts).find(|(_, found)| *found != rows) {
        Some((what, found)) => Err(SensitivityError::Length { what, found, rows }),
        None => Ok(()),
    }
}

/// Spearman's rho and the rank regression of each parameter; returns R2.
fn ranked(
    given: &Given<'_>,
    (inputs, output): (&[Ordered<'_>], &Ordered<'_>),
    (part, scatter): (&[u32], Option<&Scatter>),
    found: &mut [OfParameter],
    notes: &mut Vec<String>,
) -> Option<Index> {
    let places: Vec<usize> = (0..inputs.len()).filter(|place| !given.inputs[*place].has_words).collect();
    let all: Vec<&Ordered<'_>> = places.iter().map(|place| &inputs[*place]).collect();
    if places.len() < inputs.len() {
        notes.push("parameters with words as values have no order: the regression leaves them out".to_owned());
    }
    let whole = of_ranks(&all, output, |_| true);
    if whole.coefficients.is_none() && !all.is_empty() {
        notes.push("no regression: too few rows, or ranks of one parameter follow from those of others".to_owned());
    }
    let parts = scatter.map_or(0, |scatter| scatter.parts);
    let without: Vec<Regression> =
        (0..parts).map(|out| of_ranks(&all, output, |row| part[row] as usize != out)).collect();
    let index = |estimate: Option<f64>, of: &dyn Fn(&Regression) -> Option<f64>| {
        let parts: Vec<f64> = without.iter().map(|one| of(one).unwrap_or(f64::NAN)).collect();
        match (estimate, scatter) {
            (Some(estimate), Some(scatter)) => scatter.index(estimate, &parts, true),
            _ => Index::alone(estimate),
        }
    };
    let coefficient = |one: &Regression, place: usize| one.coefficients.as_ref().and_then(|(of, _)| of[place]);
    for (place, &at) in places.iter().enumerate() {
        found[at].spearman = Some(index(whole.spearman[place], &|one| one.spearman[place]));
        found[at].rank_regression = Some(index(coefficient(&whole, place), &|one| coefficient(one, place)));
    }
    let r2 = |one: &Regression| one.coefficients.as_ref().map(|(_, r2)| *r2);
    r2(&whole).map(|estimate| index(Some(estimate), &r2))
}

fn first_orders(
    (inputs, y): (&[Ordered<'_>], &[f64]),
    (part, left_out, scatter): (&[u32], bool, Option<&Scatter>),
    found: &mut [OfParameter],
    notes: &mut Vec<String>,
) {
    let enough = y.len() >= FEWEST_FOR_SUCCESSORS;
    if scatter.is_some() && !enough {
        notes.push(format!("first orders by ranks have an interval from {FEWEST_FOR_SUCCESSORS} rows on"));
    }
    for (input, found) in inputs.iter().zip(found).filter(|(input, _)| !input.is_constant()) {
        let estimate = of_order(input, y, |_| true);
        found.first = Some(match scatter.filter(|_| enough) {
            Some(scatter) => {
                let one = |at: usize| of_order(input, y, |row| (part[row] as usize == at) != left_out);
                scatter.index(estimate, &(0..scatter.parts).map(one).collect::<Vec<_>>(), left_out)
            }
            None => Index::alone(Some(estimate).filter(|estimate| estimate.is_finite())),
        });
    }
}

fn dependences(
    given: &Given<'_>,
    (columns, y): (&[Vec<f64>], &[f64]),
    found: &mut [OfParameter],
    notes: &mut Vec<String>,
) {
    let rows = y.len().min(MOST_ROWS);
    if rows < y.len() {
        notes.push(format!("HSIC of the first {rows} rows"));
    }
    let Some(output) = Centred::new(&y[..rows], Similar::Near) else { return };
    for ((input, column), found) in given.inputs.iter().zip(columns).zip(found) {
        let similar = if input.has_words { Similar::Same } else { Similar::Near };
        let dependence = Centred::new(&column[..rows], similar).and_then(|input| input.with(&output));
        found.hsic = dependence.map(|of| Hsic { normalised: of.normalised, p_value: of.p_value });
    }
}
