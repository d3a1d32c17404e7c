//! Puts questions to a study.

use super::answer::{Answer, Answers, SCHEMA};
use super::mapped::{answers_of, map_in_words};
use super::question::{Ask, Figure, Question};
use super::scale::{Scale, percent, percent_given};
use super::sensitive::sensitivities;
use super::sentence::{counted, of_curve, sentence};
use crate::estimate::along::{Family, families, together};
use crate::estimate::curve::{Curve, CurvePoint};
use crate::estimate::exceedance::exceedance;
use crate::estimate::figures::{Figures, Method};
use crate::estimate::formula::Formula;
use crate::estimate::fragility::bins;
use crate::estimate::input::{Group, InputError, Label, Nature, Study};
use crate::estimate::known::{Truths, Values, reached, truths, values};
use crate::estimate::mean::mean;
use crate::estimate::proportion::{Tally, none_seen, proportion_by, tallies};
use crate::estimate::scheme::Scheme;
use crate::estimate::{difference, quantile};
use crate::map::maps;

/// Answers to a question, one for each group, and its curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Answered {
    /// In the order of groups.
    pub answers: Vec<Answer>,
    /// For `answers/NAME.parquet`.
    pub curve: Option<Curve>,
}

/// Answers of all questions, and their curves by name.
///
/// # Errors
/// Columns do not fit together; a question whose columns are missing is told so in its answer.
pub fn answer_all(study: &Study<'_>, questions: &[Question]) -> Result<(Answers, Vec<(String, Curve)>), InputError> {
    study.check()?;
    let (mut answers, mut curves) = (Vec::new(), Vec::new());
    for question in questions {
        let answered = match answer(study, question) {
            Ok(answered) => answered,
            // the others are answered all the same
            Err(why) => {
                answers.push(unanswered(study, question, &why));
                continue;
            }
        };
        answers.extend(answered.answers);
        curves.extend(answered.curve.map(|curve| (question.name.clone(), curve)));
    }
    Ok((Answers { schema: SCHEMA, complete: study.design.complete, answers }, curves))
}

/// The answer to a question that these rows cannot answer: no number, and why.
fn unanswered(study: &Study<'_>, question: &Question, why: &InputError) -> Answer {
    let kind = match &question.ask {
        Ask::One(figure) => kind(figure),
        Ask::Exceedance(_) => "exceedance",
        Ask::Fragility(..) => "fragility",
        Ask::Difference(..) => "difference",
        Ask::Map(_) => "map",
        Ask::Sensitivity(_) => "sensitivity",
    };
    let figures = Figures::over(study.points() as u64);
    let mut answer = Answer::of(&question.name, kind, Group::default(), 0, question.confidence, figures);
    answer.sentence = format!("not answered: {why}");
    answer.notes.push(answer.sentence.clone());
    answer
}

/// Answers of one question; the study has been checked.
///
/// # Errors
/// It lacks a column.
pub fn answer(study: &Study<'_>, question: &Question) -> Result<Answered, InputError> {
    let (scheme, alpha) = (Scheme::of(&study.design), (1.0 - question.confidence) * study.design.share);
    let asked = Asked { study, question, t: scheme.t(alpha), scheme, alpha };
    let mut answered = match &question.ask {
        Ask::One(figure) => asked.one(figure),
        Ask::Exceedance(column) => asked.exceedance(column),
        Ask::Fragility(path, formula) => asked.fragility(path, formula),
        Ask::Difference(figure, path, values) => asked.difference(figure, path, values),
        Ask::Map(wanted) => {
            Ok(Answered { answers: answers_of(&question.name, maps(study, wanted, alpha)?), curve: None })
        }
        Ask::Sensitivity(wanted) => {
            let answers = sensitivities(study, question, wanted, (&asked.scheme, alpha))?;
            Ok(Answered { answers, curve: None })
        }
    }?;
    if study.design.share < 1.0 {
        let one = percent(1.0 - alpha);
        let note = format!(
            "one of several looks of [stop]: its limits hold with {one}, so that those of all looks hold together with {}",
            percent_given(question.confidence)
        );
        let has_limits = |answer: &&mut Answer| answer.method != Method::Without;
        answered.answers.iter_mut().filter(has_limits).for_each(|answer| answer.notes.push(note.clone()));
    }
    Ok(answered)
}

struct Asked<'a> {
    study: &'a Study<'a>,
    question: &'a Question,
    scheme: Scheme,
    /// Two-sided.
    alpha: f64,
    /// Student's of the replicates.
    t: f64,
}

/// The word of a figure.
fn kind(figure: &Figure) -> &'static str {
    match figure {
        Figure::Probability(_) => "probability",
        Figure::Quantile(..) => "quantile",
        Figure::Mean(_) => "mean",
    }
}

/// What a question asks, in words: "load-95: 95 % quantile of max_bearing_load_N (95 %)".
#[must_use]
pub fn in_words(question: &Question) -> String {
    let what = match &question.ask {
        Ask::One(figure) => subject(figure),
        Ask::Exceedance(column) => format!("exceedance of {column}"),
        Ask::Fragility(path, formula) => format!("P({}) over {path}", formula.text),
        Ask::Difference(figure, path, [a, b]) => {
            format!("{} at {path} = {a} less that at {b}, paired", subject(figure))
        }
        Ask::Map(wanted) => map_in_words(wanted),
        Ask::Sensitivity(wanted) => format!("sensitivity of {} by {}", wanted.output, wanted.method.word()),
    };
    format!("{}: {what} (confidence {})", question.name, percent_given(question.confidence))
}

fn subject(figure: &Figure) -> String {
    match figure {
        Figure::Probability(formula) => format!("P({})", formula.text),
        Figure::Quantile(u, column) => format!("{} quantile of {column}", percent_given(*u)),
        Figure::Mean(column) => format!("mean of {column}"),
    }
}

/// A column's name ends in its unit.
fn with_unit(name: &str, unit: &str) -> String {
    let unit = unit.replace(' ', "").replace('/', "_");
    if unit.is_empty() { name.to_owned() } else { format!("{name}_{unit}") }
}

/// Ok rows of which a condition says nothing, in words.
fn note_undefined(notes: &mut Vec<String>, undefined: u64) {
    if undefined > 0 {
        let runs = counted(undefined, "run");
        notes.push(format!(
            "in {runs} the condition has no value (such as the root of a negative number): counted both ways"
        ));
    }
}

/// Rows without a value, in words.
fn note_empty(notes: &mut Vec<String>, empty: u64, what: &str) {
    if empty > 0 {
        notes.push(format!("in {empty} runs a column is empty, nothing of the kind happened: {what}"));
    }
}

const CONDITION: &str = "no comparison with it holds but `!=`";
const LEFT_OUT: &str = "they are left out, the figure is that of the runs that have a value";
const NO_LEVEL: &str = "they exceed no level";

impl Asked<'_> {
    fn part(&self) -> impl Fn(usize) -> usize {
        |point| self.scheme.part(&self.study.design, point)
    }

    fn scale(&self, figure: &Figure) -> Result<Scale, InputError> {
        Ok(match figure {
            Figure::Probability(_) => Scale::Share,
            Figure::Quantile(_, column) | Figure::Mean(column) => Scale::Unit(self.study.column(column)?.unit.clone()),
        })
    }

    /// What decides a bad run of a probability.
    fn decided_by(&self, figure: &Figure) -> &'static str {
        let Figure::Probability(formula) = figure else { return "" };
        let is_reached = |name: &String| {
            self.study.numbers(name).is_ok_and(|(_, nature)| matches!(nature, Nature::Grows(_) | Nature::Once))
        };
        if formula.columns.iter().any(is_reached) {
            "by what was reached while all guards held"
        } else {
            "decided by its inputs"
        }
    }

    fn told(&self, kind: &'static str, group: Group, bad: u64, figures: Figures) -> Answer {
        let mut answer = Answer::of(&self.question.name, kind, group, bad, self.question.confidence, figures.clone());
        answer.figures.push(figures);
        answer
    }

    fn probability(&self, truths: &Truths) -> Figures {
        let tallies = tallies(truths, self.scheme.parts(), self.part());
        let mut figures = proportion_by(&tallies, &self.scheme, self.alpha, self.t);
        note_empty(&mut figures.notes, truths.empty, CONDITION);
        note_undefined(&mut figures.notes, truths.undefined);
        // points that are random after all, only too few replicates of them
        if matches!(self.scheme, Scheme::Without(_)) && self.study.design.is_random() {
            none_seen(&Tally::of_all(&tallies), self.alpha, &mut figures);
        }
        figures
    }

    fn of_values(&self, figure: &Figure, values: &Values) -> Figures {
        let mut figures = match figure {
            Figure::Quantile(u, _) => quantile::quantile(values, *u, &self.scheme, self.part(), self.alpha),
            _ => mean(values, &self.scheme, self.part(), self.alpha),
        };
        note_empty(&mut figures.notes, values.empty, LEFT_OUT);
        figures
    }

    fn one(&self, figure: &Figure) -> Result<Answered, InputError> {
        let (scale, mut answers) = (self.scale(figure)?, Vec::new());
        for (at, group) in self.study.groups.iter().enumerate() {
            let (figures, bad, decided) = match figure {
                Figure::Probability(formula) => {
                    let truths = truths(self.study, formula, at)?;
                    let (bad, decided) = truths.bad_and_decided();
                    (self.probability(&truths), bad, decided)
                }
                Figure::Quantile(_, column) | Figure::Mean(column) => {
                    let values = values(self.study, column, at)?;
                    (self.of_values(figure, &values), values.bad, 0)
                }
            };
            let mut answer = self.told(kind(figure), group.clone(), bad, figures);
            answer.sentence = sentence(&answer, &subject(figure), &scale, (decided, self.decided_by(figure)));
            answer.scale = scale.clone();
            answers.push(answer);
        }
        Ok(Answered { answers, curve: None })
    }

    /// An answer that stands in a curve.
    fn curved(&self, kind: &'static str, group: &Group, bad: u64, n: u64, method: Method) -> Answer {
        let mut figures = Figures::over(n);
        figures.method = method;
        figures.approximate = method != Method::Without && self.scheme != Scheme::Independent;
        if let Scheme::Without(why) = &self.scheme {
            figures.notes.push(why.clone());
        }
        Answer { figures: Vec::new(), ..self.told(kind, group.clone(), bad, figures) }
    }

    fn exceedance(&self, column: &str) -> Result<Answered, InputError> {
        let unit = &self.study.column(column)?.unit;
        let (mut answers, mut curves) = (Vec::new(), Vec::new());
        let mut points = vec![0; self.scheme.parts()];
        (0..self.study.points()).for_each(|point| points[self.part()(point)] += 1);
        for (at, group) in self.study.groups.iter().enumerate() {
            let values = reached(self.study, column, at)?;
            let (curve, method) = exceedance(&values, &self.scheme, &points, self.part(), self.alpha);
            let mut answer = self.curved("exceedance", group, values.bad, self.study.points() as u64, method);
            if method == Method::Band {
                answer.notes.push("the limits hold for all levels at once".to_owned());
            } else if method != Method::Without {
                answer.notes.push("the limits hold for each level by itself".to_owned());
            }
            note_empty(&mut answer.notes, values.empty, NO_LEVEL);
            answer.sentence = of_curve(&answer, &format!("exceedance of {column}"), &curve, unit, "level");
            answers.push(answer);
            curves.push((group.clone(), curve));
        }
        Ok(Answered { answers, curve: Some(Curve::of(&curves, &[&with_unit("level", unit)])) })
    }

    /// What goes with a varied parameter, in words.
    fn note_along(&self, path: &str, notes: &mut Vec<String>) {
        let along = together(&self.study.groups, path);
        if !along.is_empty() {
            notes.push(format!("{} goes with {path} (zip)", along.join(", ")));
        }
    }

    fn fragility(&self, path: &str, formula: &Formula) -> Result<Answered, InputError> {
        let families = families(&self.study.groups, path)?;
        let (varied, mut all) = (!families.is_empty(), Vec::new());
        let mut single = true;
        if varied {
            for Family { rest: group, members } in families {
                let (mut curve, mut empty) = (Vec::new(), 0);
                for (label, at) in members {
                    let truths = truths(self.study, formula, at)?;
                    let (bad, _) = truths.bad_and_decided();
                    empty += truths.empty;
                    let figures = self.probability(&truths);
                    curve.push(CurvePoint { at: (label.clone(), label), bad, figures });
                }
                all.push((group, curve, empty));
            }
        } else {
            let (bins, is_single) = bins(self.study, path)?;
            single = is_single;
            for (at, group) in self.study.groups.iter().enumerate() {
                let truths = truths(self.study, formula, at)?;
                let of_bin = |points: &[u32]| {
                    let mut tallies = vec![Tally::default(); self.scheme.parts()];
                    let mut bad = 0;
                    for &point in points {
                        tallies[self.part()(point as usize)].see(truths.of[point as usize]);
                        bad += u64::from(truths.bad[point as usize]);
                    }
                    (proportion_by(&tallies, &self.scheme, self.alpha, self.t), bad)
                };
                let curve = bins.iter().map(|bin| {
                    let (figures, bad) = of_bin(&bin.points);
                    CurvePoint { at: bin.range.clone(), bad, figures }
                });
                all.push((group.clone(), curve.collect(), truths.empty));
            }
        }
        let unit = self.study.column(path).map(|column| column.unit.clone()).unwrap_or_default();
        let (mut answers, mut curves) = (Vec::new(), Vec::new());
        for (group, curve, empty) in all {
            let bad = curve.iter().map(|point: &CurvePoint| point.bad).sum();
            let n = curve.iter().map(|point| point.figures.n).sum();
            let method = curve.iter().map(|point| point.figures.method).max_by_key(|method| *method as u8);
            let mut answer = self.curved("fragility", &group, bad, n, method.unwrap_or(Method::Without));
            let what = if single { "value" } else { "bin" };
            if !single {
                answer.notes.push(match curve.len() {
                    1 => "one bin holds all: a bin has at least 50 points".to_owned(),
                    count => format!("{count} bins of equal count: the probability is that over the bin"),
                });
            }
            answer.notes.push(format!("the limits hold for each {what} by itself"));
            note_empty(&mut answer.notes, empty, CONDITION);
            self.note_along(path, &mut answer.notes);
            let subject = format!("P({}) over {path}", formula.text);
            answer.sentence = of_curve(&answer, &subject, &curve, &unit, what);
            answers.push(answer);
            curves.push((group, curve));
        }
        Ok(Answered { answers, curve: Some(Curve::of(&curves, &[&with_unit("from", &unit), &with_unit("to", &unit)])) })
    }

    fn difference(&self, figure: &Figure, path: &str, labels: &[Label; 2]) -> Result<Answered, InputError> {
        let (scale, mut answers) = (self.scale(figure)?, Vec::new());
        for Family { rest: group, members } in families(&self.study.groups, path)? {
            let place = |label: &Label| members.iter().find(|(known, _)| known == label).map(|(_, at)| *at);
            let (Some(a), Some(b)) = (place(&labels[0]), place(&labels[1])) else {
                return Err(InputError::Missing(format!("{path} = {} or {}", labels[0], labels[1])));
            };
            let (figures, bad, decided) = match figure {
                Figure::Probability(formula) => {
                    let (a, b) = (truths(self.study, formula, a)?, truths(self.study, formula, b)?);
                    let mut figures = difference::of_probabilities(&a, &b, &self.scheme, self.part(), self.alpha);
                    note_empty(&mut figures.notes, a.empty + b.empty, CONDITION);
                    let (first, second) = (a.bad_and_decided(), b.bad_and_decided());
                    (figures, first.0 + second.0, first.1 + second.1)
                }
                Figure::Quantile(_, column) | Figure::Mean(column) => {
                    let (a, b) = (values(self.study, column, a)?, values(self.study, column, b)?);
                    let mut figures = if let Figure::Quantile(u, _) = figure {
                        difference::of_quantiles(&a, &b, *u, &self.scheme, self.part(), self.alpha)
                    } else {
                        difference::of_means(&a, &b, &self.scheme, self.part(), self.alpha)
                    };
                    note_empty(&mut figures.notes, a.empty + b.empty, LEFT_OUT);
                    (figures, a.bad + b.bad, 0)
                }
            };
            let mut answer = self.told("difference", group, bad, figures);
            self.note_along(path, &mut answer.notes);
            let of = format!("{}, {path} = {} less {}", subject(figure), labels[0], labels[1]);
            answer.sentence = sentence(&answer, &of, &scale, (decided, self.decided_by(figure)));
            answer.scale = scale.clone();
            answers.push(answer);
        }
        Ok(Answered { answers, curve: None })
    }
}
