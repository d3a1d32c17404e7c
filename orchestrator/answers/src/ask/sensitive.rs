//! Sensitivity questions: from the rows of a study to indices in every group, and to text.
//!
//! A run that is not ok, or that has no value in the output column, has no number. [`crate::sensitivity`] defines the treatment of its
//! block and of the excluded share.

use super::answer::{Answer, OfRegime, Sensitivities};
use super::method::{Sensitivity, SensitivityMethod};
use super::question::{Check, Question, QuestionDef, near};
use super::scale::Scale;
use super::sentence::{counted, prefix};
use crate::estimate::figures::{Figures, Method};
use crate::estimate::input::{Cells, Design, Group, InputError, Layout, Study};
use crate::estimate::scheme::Scheme;
use crate::map::REGIME;
use crate::sensitivity::{
    Given, Index, Indices, Input, OfParameter, Parts, Regime, by_regime, given_data, morris, regimes, sobol, warning,
};
use crate::share::{percent, percent_given};
use bladeoff_model::outcome::Status;
use bladeoff_text::document::units::format_digits;

/// Largest number of parameters that a sentence names.
const NAMED: usize = 4;

/// Answers of a sensitivity question in every group.
///
/// # Errors
/// The estimator is not valid for this design, or a column is missing.
pub(super) fn sensitivities(
    study: &Study<'_>,
    question: &Question,
    wanted: &Sensitivity,
    (scheme, alpha): (&Scheme, f64),
) -> Result<Vec<Answer>, InputError> {
    wanted.method.check(study.design.kind, study.design.replicates).map_err(InputError::Method)?;
    let unit = study.column(&wanted.output)?.unit.clone();
    let groups = study.groups.iter().enumerate();
    let rows = Rows { study, wanted, scheme, alpha };
    groups.map(|(at, group)| rows.group(at, group, question, &unit)).collect()
}

/// Scales outputs whose squares would overflow or underflow by a power of two, to a largest magnitude near 1; also returns the factor
/// that undoes the scaling. Variance shares and ranks are invariant; effects are scaled back by [`enlarge`].
fn in_range(mut output: Vec<Option<f64>>) -> (Vec<Option<f64>>, f64) {
    let finite = output.iter().flatten().filter(|value| value.is_finite());
    let largest = finite.fold(0.0_f64, |most, value| most.max(value.abs()));
    if largest == 0.0 || (LEAST..MOST).contains(&largest) {
        return (output, 1.0);
    }
    let power = libm::ilogb(largest);
    output.iter_mut().flatten().for_each(|value| *value = libm::scalbn(*value, -power));
    (output, libm::scalbn(1.0, power))
}

/// Range of magnitudes whose squares can be summed over any number of rows.
const LEAST: f64 = 1e-100;
const MOST: f64 = 1e100;

/// Scales effects back to the unit of the output.
fn enlarge(indices: &mut Indices, factor: f64) {
    let of = |value: Option<f64>| value.map(|value| value * factor);
    let mut has_lost = false;
    for (_, found) in &mut indices.of {
        for index in [&mut found.mu_star, &mut found.mu, &mut found.sigma].into_iter().flatten() {
            let [estimate, low, high] = [index.estimate, index.low, index.high].map(of);
            has_lost |= [estimate, low, high].iter().flatten().any(|value| !value.is_finite());
            let held = |value: Option<f64>| value.filter(|value| value.is_finite());
            *index = Index { estimate: held(estimate), low: held(low), high: held(high) };
        }
    }
    if has_lost {
        indices.notes.push("effects beyond 1.8e308 have no number".to_owned());
    }
}

struct Rows<'a> {
    study: &'a Study<'a>,
    wanted: &'a Sensitivity,
    scheme: &'a Scheme,
    alpha: f64,
}

impl Rows<'_> {
    fn group(&self, at: usize, group: &Group, question: &Question, unit: &str) -> Result<Answer, InputError> {
        let output = self.output(at)?;
        let words = self.words(at);
        let found = regimes(&words, &output);
        let (output, factor) = in_range(output);
        let (mut indices, of_regimes) = self.indices(at, &output, &words)?;
        if self.wanted.method == SensitivityMethod::Morris {
            enlarge(&mut indices, factor);
        }
        let (bad, runs) = (self.study.bad(at), self.study.points() as u64);
        if indices.without.is_some() && bad.all == runs {
            indices.without = Some("no run is ok");
        }
        indices.notes.extend(warning(&found));
        let mut figures = Figures::over(indices.n);
        figures.method = match indices.interval {
            "bootstrap" => Method::Bootstrap,
            "replicates-t" => Method::Replicates,
            _ => Method::Without,
        };
        figures.approximate = figures.method != Method::Without;
        figures.notes.append(&mut indices.notes);
        let mut answer = Answer::of(&question.name, "sensitivity", group.clone(), bad, question.confidence, figures);
        let words = Words { wanted: self.wanted, unit, answer: &answer, inside: bad.inside() };
        let (sentence, mut lines) = (words.sentence(&indices), words.table(&indices));
        for (regime, indices) in &of_regimes {
            lines.push(format!("of the {} in regime {}:", counted(regime.rows.len() as u64, "run"), regime.word));
            lines.extend(words.table(indices));
        }
        if self.wanted.method == SensitivityMethod::Morris {
            answer.scale = Scale::Unit(unit.to_owned());
        }
        answer.figures = waited_for(self.wanted.method, &indices, answer.method);
        (answer.sentence, answer.lines) = (sentence, lines);
        let of_regime = |(regime, mut indices): (Regime, Indices)| {
            for note in std::mem::take(&mut indices.notes) {
                let note = format!("regime {}: {note}", regime.word);
                answer.notes.push(note);
            }
            OfRegime { regime: regime.word, share: regime.share, n: indices.n, indices }
        };
        let regimes = of_regimes.into_iter().map(of_regime).collect();
        let (second_order, r2) = (std::mem::take(&mut indices.pairs), indices.r2);
        let (output, left_out) = (self.wanted.output.clone(), indices.left_out);
        let estimator = self.wanted.method.word();
        let correlated = Vec::new();
        answer.sensitivity =
            Some(Sensitivities { output, estimator, indices, second_order, r2, left_out, correlated, regimes });
        Ok(answer)
    }

    /// Output of every point of a group; `None` for a run that is not ok.
    fn output(&self, group: usize) -> Result<Vec<Option<f64>>, InputError> {
        let (cells, _) = self.study.numbers(&self.wanted.output)?;
        let cell = |point: usize| {
            let row = self.study.row(point, group);
            cells[row].filter(|_| self.study.status[row] == Status::Ok)
        };
        Ok((0..self.study.points()).map(cell).collect())
    }

    /// Regime of every point of a group; `None` if the table has no such column.
    fn words(&self, group: usize) -> Vec<Option<String>> {
        let column = self.wanted.regime.as_ref().and_then(|name| self.study.column(name).ok());
        let cells = column.and_then(|column| match column.cells {
            Cells::Words(words, _) => Some(words),
            Cells::Numbers(..) => None,
        });
        let word = |point: usize| cells.and_then(|words| words[self.study.row(point, group)].clone());
        (0..self.study.points()).map(word).collect()
    }

    /// Indices over all rows, and over each regime where the method allows it and there are several.
    fn indices(
        &self,
        group: usize,
        output: &[Option<f64>],
        words: &[Option<String>],
    ) -> Result<(Indices, Vec<(Regime, Indices)>), InputError> {
        let (study, names) = (self.study, &self.wanted.parameters);
        let Design { layout, .. } = study.design;
        let whole = match (self.wanted.method, layout) {
            (SensitivityMethod::Morris, Layout::Trajectories(moves, delta)) => {
                morris(names, output, &moves[..output.len()], delta, self.alpha)?
            }
            (SensitivityMethod::Sobol, Layout::Saltelli { second_order }) => {
                sobol(names, output, second_order, self.alpha)?
            }
            (SensitivityMethod::GivenData, _) => {
                let columns: Vec<(Vec<f64>, bool)> =
                    names.iter().map(|name| self.input(name, group)).collect::<Result<_, _>>()?;
                let inputs = names.iter().zip(&columns);
                let given = Given {
                    inputs: inputs
                        .map(|(name, (values, has_words))| Input { name: name.clone(), values, has_words: *has_words })
                        .collect(),
                    output,
                    parts: match self.scheme {
                        Scheme::Independent => Parts::Independent,
                        Scheme::Replicated(count) => Parts::Replicates(study.design.replicate, *count),
                        Scheme::Without(why) => Parts::Without(why.clone()),
                    },
                };
                let mut parts = by_regime(&given, words, self.alpha)?;
                if parts.len() < 2 {
                    parts.clear();
                }
                return Ok((given_data(&given, self.alpha)?, parts));
            }
            (method, _) => {
                let why =
                    format!("the rows do not contain how the points of method {:?} belong together", method.word());
                return Err(InputError::Method(why));
            }
        };
        Ok((whole, Vec::new()))
    }

    /// Values of a parameter in a group, and whether the column is text. Text values are given as indices into their list.
    fn input(&self, name: &str, group: usize) -> Result<(Vec<f64>, bool), InputError> {
        let points = 0..self.study.points();
        let row = |point: usize| self.study.row(point, group);
        Ok(match self.study.column(name)?.cells {
            Cells::Numbers(cells, _) => (points.map(|point| cells[row(point)].unwrap_or(f64::NAN)).collect(), false),
            Cells::Words(cells, list) => {
                let place = |word: &Option<String>| list.iter().position(|known| Some(known) == word.as_ref());
                let place = |point: usize| place(&cells[row(point)]).map_or(f64::NAN, |place| place as f64);
                (points.map(place).collect(), true)
            }
        })
    }
}

/// The index that ranks parameters.
fn leading(method: SensitivityMethod, of: &OfParameter) -> Option<Index> {
    match method {
        SensitivityMethod::Morris => of.mu_star,
        SensitivityMethod::Sobol => of.total,
        SensitivityMethod::GivenData => of.first,
    }
}

/// Indices with their intervals, for stopping rules on precision.
fn waited_for(method: SensitivityMethod, indices: &Indices, made: Method) -> Vec<Figures> {
    let of = |(_, of): &(String, OfParameter)| match method {
        SensitivityMethod::Sobol => vec![of.first, of.total],
        _ => vec![leading(method, of)],
    };
    let figures = |index: Index| Figures {
        estimate: index.estimate,
        harmful: index.estimate,
        low: index.low,
        high: index.high,
        statistical: index.high.zip(index.low).map(|(high, low)| high - low),
        method: if index.low.is_some() { made } else { Method::Without },
        ..Figures::over(indices.n)
    };
    indices.of.iter().flat_map(of).map(|index| figures(index.unwrap_or_default())).collect()
}

/// Formats indices as text.
struct Words<'a> {
    wanted: &'a Sensitivity,
    unit: &'a str,
    answer: &'a Answer,
    /// " of runs inside the model (83 %)"; empty where no run is beyond it.
    inside: String,
}

impl Words<'_> {
    /// Formats a number, with the unit of the output or without a unit.
    fn number(&self, value: f64, has_unit: bool) -> String {
        format_digits(value, if has_unit { self.unit } else { "" }, 3)
    }

    /// Parameters in descending order of importance; ties, and parameters without an index, in the order of the study.
    fn ranked<'i>(&self, indices: &'i Indices) -> Vec<&'i (String, OfParameter)> {
        let key = |of: &OfParameter| leading(self.wanted.method, of).and_then(|index| index.ranking());
        let mut ranked: Vec<&(String, OfParameter)> = indices.of.iter().collect();
        let down = |value: Option<f64>| -value.unwrap_or(f64::NEG_INFINITY);
        ranked.sort_by(|a, b| down(key(&a.1)).total_cmp(&down(key(&b.1))));
        ranked
    }

    /// "sensitivity of y: b makes 44 % of its variance alone (about 95 %: 40 % to 48 %), a 31 % (...); 1024 base points".
    fn sentence(&self, indices: &Indices) -> String {
        let Self { wanted, answer, .. } = self;
        let (what, unit_of, has_unit) = match wanted.method {
            SensitivityMethod::Morris => ("mean size of elementary effects", "trajectory", true),
            SensitivityMethod::Sobol => ("share of the variance, interactions included", "base point", false),
            SensitivityMethod::GivenData => ("share of the variance of each parameter alone", "row", false),
        };
        let show = |value: f64| if has_unit { self.number(value, true) } else { percent(value) };
        let about = if answer.approximate { "about " } else { "" };
        let level = percent_given(answer.confidence);
        let (mut told, mut without) = (Vec::new(), 0);
        for (name, of) in self.ranked(indices) {
            let (estimate, low, high) = match leading(wanted.method, of) {
                Some(Index { estimate: Some(estimate), low: Some(low), high: Some(high) }) => (estimate, low, high),
                Some(Index { estimate: Some(_), .. }) => {
                    without += 1;
                    continue;
                }
                _ => continue,
            };
            let level = if told.is_empty() { format!("{about}{level}: ") } else { String::new() };
            let (low, high) = match (has_unit, Scale::Share.show_both(low, high)) {
                (true, _) => (show(low), show(high)),
                (false, both) => both,
            };
            told.push(format!("{name} {} ({level}{low} to {high})", show(estimate)));
        }
        let more = told.len().saturating_sub(NAMED);
        told.truncate(NAMED);
        let mut text = format!("{}sensitivity of {}{}", prefix(&answer.group), wanted.output, self.inside);
        if told.is_empty() && without == 0 {
            text += " has no number";
            text += &indices.without.map_or(String::new(), |why| format!(": {why}"));
        } else if told.is_empty() {
            text += &format!(", {what}: no ranking, since no index has an interval");
        } else {
            text += &format!(", {what}: {}", told.join(", "));
        }
        if more > 0 {
            text += &format!(", {} below", counted(more as u64, "parameter"));
        }
        if without > 0 && !told.is_empty() {
            text += &format!(", {} without an interval not ranked", counted(without, "parameter"));
        }
        let blocks = match (unit_of, answer.n) {
            ("trajectory", n) if n != 1 => format!("{n} trajectories"),
            (word, n) => counted(n, word),
        };
        text += &format!(", {blocks}");
        if indices.left_out > 0 {
            text += &format!(", {} left out", indices.left_out);
        }
        text
    }

    /// Lines of a table: a head, one line for each parameter in descending order of importance, then pairs.
    fn table(&self, indices: &Indices) -> Vec<String> {
        type Cell = fn(&OfParameter) -> Option<Index>;
        let columns: Vec<(&str, Cell, bool)> = match self.wanted.method {
            SensitivityMethod::Morris => {
                vec![("mu*", |of| of.mu_star, true), ("mu", |of| of.mu, true), ("sigma", |of| of.sigma, true)]
            }
            SensitivityMethod::Sobol => vec![("first", |of| of.first, false), ("total", |of| of.total, false)],
            SensitivityMethod::GivenData => vec![
                ("first", |of| of.first, false),
                ("Spearman", |of| of.spearman, false),
                ("rank regression", |of| of.rank_regression, false),
            ],
        };
        let has_hsic = indices.of.iter().any(|(_, of)| of.hsic.is_some());
        let mut head = vec!["parameter".to_owned()];
        head.extend(columns.iter().map(|(name, ..)| (*name).to_owned()));
        head.extend(has_hsic.then(|| "HSIC (p)".to_owned()));
        let mut rows = vec![head];
        for (name, of) in self.ranked(indices) {
            let mut row = vec![name.clone()];
            row.extend(columns.iter().map(|(_, cell, has_unit)| self.cell(cell(of), *has_unit)));
            if has_hsic {
                let number = |value: f64| format_digits(value, "", 2);
                row.push(
                    of.hsic.map_or("-".to_owned(), |of| format!("{} ({})", number(of.normalised), number(of.p_value))),
                );
            }
            rows.push(row);
        }
        let mut lines = aligned(&rows);
        if !indices.pairs.is_empty() {
            let pair = |pair: &crate::sensitivity::Pair| {
                vec![format!("{} with {}", pair.between[0], pair.between[1]), self.cell(Some(pair.second), false)]
            };
            let head = vec!["pair".to_owned(), "second".to_owned()];
            lines.extend(aligned(&std::iter::once(head).chain(indices.pairs.iter().map(pair)).collect::<Vec<_>>()));
        }
        if let Some(r2) = indices.r2 {
            lines.push(format!("R2 of the rank regression: {}", self.cell(Some(r2), false)));
        }
        lines
    }

    fn cell(&self, index: Option<Index>, has_unit: bool) -> String {
        let Some(Index { estimate: Some(estimate), low, high }) = index else { return "-".to_owned() };
        let show = |value: f64| self.number(value, has_unit);
        match low.zip(high) {
            Some((low, high)) => format!("{} ({} to {})", show(estimate), show(low), show(high)),
            None => show(estimate),
        }
    }
}

/// Pads the cells of a text table to columns.
fn aligned(rows: &[Vec<String>]) -> Vec<String> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect()
}

impl Check<'_> {
    /// Checks the keys of a sensitivity question.
    pub(super) fn sensitivity(&mut self, def: &QuestionDef, column: &str) -> Option<Sensitivity> {
        for (key, is) in [("difference", def.difference.is_some()), ("fragility", def.fragility.is_some())] {
            if is {
                self.wrong::<()>(key, format!("a sensitivity has no {key}"));
            }
        }
        let all = SensitivityMethod::ALL;
        let words = all.map(|(word, _)| format!("{word:?}")).join(", ");
        let method = match &def.method {
            None => self.wrong("method", format!("`sensitivity` needs `method`: one of {words}")),
            Some(given) => match all.iter().find(|(word, _)| word == given) {
                Some((_, method)) => Some(*method),
                None => {
                    let near = near(given, all.iter().map(|(word, _)| *word));
                    self.wrong("method", format!("{given:?} is not one of {words}{near}"))
                }
            },
        };
        let output = self.column("sensitivity", column);
        if let Some(output) = output.as_ref().filter(|output| self.names.is_drawn(output)) {
            self.wrong::<()>(
                "sensitivity",
                format!("`{output}` is an uncertain input itself: no other input affects it"),
            );
        }
        let regime = self.names.known.columns.iter().find(|(name, is_number)| name == REGIME && !is_number);
        Some(Sensitivity {
            output: output?,
            method: method?,
            parameters: self.names.uncertain.clone(),
            regime: regime.map(|(name, _)| name.clone()),
        })
    }
}
