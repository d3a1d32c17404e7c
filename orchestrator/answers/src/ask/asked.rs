//! Answers the questions of a study from its table.

use super::answer::{Answer, Answers, SCHEMA};
use super::mapped::answers_of;
use super::question::{Ask, Figure, Question};
use super::scale::Scale;
use super::sensitive::sensitivities;
use super::sentence::{of_curve, sentence};
use super::wording::{CONDITION, LEFT_OUT, NO_LEVEL, kind, note_empty, note_undefined, subject, with_unit};
use crate::estimate::along::{Family, families, together};
use crate::estimate::bad::Bad;
use crate::estimate::curve::{Curve, CurvePoint};
use crate::estimate::exceedance::exceedance;
use crate::estimate::figures::{Figures, Method};
use crate::estimate::formula::Formula;
use crate::estimate::fragility::bins;
use crate::estimate::input::{Group, InputError, Label, Nature, Study};
use crate::estimate::known::{Truths, Values, levels, reached, truths, values};
use crate::estimate::mean::mean;
use crate::estimate::proportion::{Tally, none_seen, proportion_by, tallies};
use crate::estimate::scheme::Scheme;
use crate::estimate::undecided::Undecided;
use crate::estimate::{difference, quantile};
use crate::map::maps;
use crate::share::percent_given;
use bladeoff_model::outcome::Status;

/// Answers to a question, one for each group, and its curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Answered {
    /// Answers in the order of groups.
    pub answers: Vec<Answer>,
    /// Content of `answers/NAME.parquet`.
    pub curve: Option<Curve>,
}

/// Answers of all questions, and their curves by name.
///
/// # Errors
/// The columns have different lengths or do not fit the design. A question with a missing column gets an answer that gives the reason.
pub fn answer_all(study: &Study<'_>, questions: &[Question]) -> Result<(Answers, Vec<(String, Curve)>), InputError> {
    let answered = answer_each(study, questions)?;
    Ok(collected(questions.iter().zip(answered), study.design.complete))
}

/// The answer of each question.
///
/// # Errors
/// As [`answer_all`].
pub fn answer_each<'q>(
    study: &Study<'_>,
    questions: impl IntoIterator<Item = &'q Question>,
) -> Result<Vec<Answered>, InputError> {
    study.check()?;
    let points = study.points() as u64;
    // a question that fails does not prevent the answers of the others
    let one = |question| answer(study, question).unwrap_or_else(|why| unanswered(points, question, &why));
    Ok(questions.into_iter().map(one).collect())
}

/// Collects the answers and curves of all questions.
#[must_use]
pub fn collected<'q>(
    all: impl IntoIterator<Item = (&'q Question, Answered)>,
    complete: bool,
) -> (Answers, Vec<(String, Curve)>) {
    let (mut answers, mut curves) = (Vec::new(), Vec::new());
    for (question, answered) in all {
        answers.extend(answered.answers);
        curves.extend(answered.curve.map(|curve| (question.name.clone(), curve)));
    }
    (Answers { schema: SCHEMA, complete, answers }, curves)
}

/// The answer to a question that cannot be answered from these rows: no number, and the reason.
pub(super) fn unanswered(points: u64, question: &Question, why: &InputError) -> Answered {
    let kind = match &question.ask {
        Ask::One(figure) => kind(figure),
        Ask::Exceedance(_) => "exceedance",
        Ask::Fragility(..) => "fragility",
        Ask::Difference(..) => "difference",
        Ask::Map(_) => "map",
        Ask::Sensitivity(_) => "sensitivity",
    };
    let figures = Figures::over(points);
    let mut answer = Answer::of(&question.name, kind, Group::default(), Bad::default(), question.confidence, figures);
    answer.sentence = format!("not answered: {why}");
    answer.notes.push(answer.sentence.clone());
    Answered { answers: vec![answer], curve: None }
}

/// Note of every answer from combinations that `[refine]` chose by their results.
const REFINED: &str = "[refine] chose the combinations by their results, more of them where the result changes: they \
                       are not a random sample, and their shares are not those of the map";

/// Additional note where such an answer has limits.
const REFINED_LIMITS: &str = "limits hold for a combination that was named beforehand; combinations that were added \
                              by results of the same points are missed more often";

/// Note of an interim analysis that has limits, before their confidence level.
const INTERIM: &str = "one of several interim analyses of [stop]: the limits are those of this analysis alone";

/// Answers of one question; the study has been checked.
///
/// # Errors
/// A column of the question is missing.
pub fn answer(study: &Study<'_>, question: &Question) -> Result<Answered, InputError> {
    let asked = Asked::of(study, question, Scheme::of(&study.design));
    let answered = match &question.ask {
        Ask::One(figure) => asked.one(figure),
        Ask::Exceedance(column) => asked.exceedance(column),
        Ask::Fragility(path, formula) => asked.fragility(path, formula),
        Ask::Difference(figure, path, values) => asked.difference(figure, path, values),
        Ask::Map(wanted) => {
            Ok(Answered { answers: answers_of(&question.name, maps(study, wanted, asked.alpha)?), curve: None })
        }
        Ask::Sensitivity(wanted) => {
            let answers = sensitivities(study, question, wanted, (&asked.scheme, asked.alpha))?;
            Ok(Answered { answers, curve: None })
        }
    }?;
    Ok(asked.noted(answered))
}

/// A question and the study it is put to. In streaming mode `study` has columns and design only, no rows.
pub(super) struct Asked<'a> {
    pub study: &'a Study<'a>,
    pub question: &'a Question,
    pub scheme: Scheme,
    /// Two-sided error level, 1 - confidence.
    pub alpha: f64,
    /// Quantile of Student's t over the replicates.
    t: f64,
}

impl<'a> Asked<'a> {
    pub fn of(study: &'a Study<'a>, question: &'a Question, scheme: Scheme) -> Self {
        let alpha = 1.0 - question.confidence;
        Self { study, question, t: scheme.t(alpha), scheme, alpha }
    }

    /// Adds the notes that apply to all answers of a refined or interim design.
    pub fn noted(&self, mut answered: Answered) -> Answered {
        let has_limits = |answer: &Answer| match &answer.map {
            Some(map) => map.cells.iter().any(|cell| cell.low.is_some()),
            None => answer.method != Method::Without,
        };
        let design = &self.study.design;
        for answer in &mut answered.answers {
            let has_limits = has_limits(answer);
            if design.is_interim() && has_limits {
                answer.approximate = true;
                let level = percent_given(self.question.confidence);
                answer.notes.push(format!("{INTERIM}, about {level}"));
            }
            if design.refined {
                answer.notes.push(REFINED.to_owned());
                answer.notes.extend(has_limits.then(|| REFINED_LIMITS.to_owned()));
            }
        }
        answered
    }

    fn part(&self) -> impl Fn(usize) -> usize {
        |point| self.scheme.part(&self.study.design, point)
    }

    fn scale(&self, figure: &Figure) -> Result<Scale, InputError> {
        Ok(match figure {
            Figure::Probability(_) => Scale::Share,
            Figure::Quantile(_, column) | Figure::Mean(column) => Scale::Unit(self.study.column(column)?.unit.clone()),
        })
    }

    fn decided_by(&self, figure: &Figure) -> &'static str {
        let Figure::Probability(formula) = figure else { return "" };
        decided_by(self.study, formula)
    }

    fn told(&self, kind: &'static str, group: Group, bad: Bad, mut figures: Figures) -> Answer {
        figures.approximate |= self.study.design.is_interim() && figures.method != Method::Without;
        let mut answer = Answer::of(&self.question.name, kind, group, bad, self.question.confidence, figures.clone());
        answer.figures.push(figures);
        answer
    }

    fn probability(&self, truths: &Truths) -> Figures {
        let tallies = tallies(truths, self.scheme.parts(), self.part());
        self.of_tallies(&tallies, truths.empty, &truths.undecided())
    }

    pub fn of_tallies(&self, tallies: &[Tally], empty: u64, undecided: &Undecided) -> Figures {
        let mut figures = proportion_by(tallies, &self.scheme, self.alpha, self.t);
        note_empty(&mut figures.notes, empty, CONDITION);
        note_undefined(&mut figures.notes, undecided.no_value);
        undecided.note(&mut figures.notes);
        // random points, but too few replicates for an interval of their own
        if matches!(self.scheme, Scheme::Without(_)) && self.study.design.is_random() {
            none_seen(&Tally::of_all(tallies), self.alpha, &mut figures);
        }
        figures
    }

    /// Values of a quantile or of a mean in a group.
    fn values(&self, figure: &Figure, column: &str, group: usize) -> Result<Values, InputError> {
        match figure {
            Figure::Quantile(..) => levels(self.study, column, group),
            _ => values(self.study, column, group),
        }
    }

    /// Subject of a sentence; a mean names the share of runs inside the model where others are beyond it.
    fn subject(&self, figure: &Figure, bad: &Bad) -> String {
        let mut text = subject(figure);
        if let Figure::Mean(column) = figure
            && self.study.numbers(column).is_ok_and(|(_, nature)| !matches!(nature, Nature::Given | Nature::Limit(_)))
        {
            text += &bad.inside();
        }
        text
    }

    fn one(&self, figure: &Figure) -> Result<Answered, InputError> {
        let mut found = Vec::new();
        for at in 0..self.study.groups.len() {
            found.push(match figure {
                Figure::Probability(formula) => {
                    let truths = truths(self.study, formula, at)?;
                    (self.probability(&truths), truths.bad())
                }
                Figure::Quantile(_, column) | Figure::Mean(column) => {
                    let values = self.values(figure, column, at)?;
                    let mut figures = match figure {
                        Figure::Quantile(u, _) => {
                            quantile::quantile(&values, *u, &self.scheme, self.part(), self.alpha)
                        }
                        _ => mean(&values, &self.scheme, self.part(), self.alpha),
                    };
                    note_empty(&mut figures.notes, values.empty, LEFT_OUT);
                    (figures, values.bad)
                }
            });
        }
        self.told_of(figure, found)
    }

    /// Builds answers from the figures and bad runs of each group.
    pub fn told_of(&self, figure: &Figure, found: Vec<(Figures, Bad)>) -> Result<Answered, InputError> {
        let (scale, mut answers) = (self.scale(figure)?, Vec::new());
        for (group, (figures, bad)) in self.study.groups.iter().zip(found) {
            let mut answer = self.told(kind(figure), group.clone(), bad, figures);
            answer.sentence = sentence(&answer, &self.subject(figure, &bad), &scale, (&bad, self.decided_by(figure)));
            answer.scale = scale.clone();
            answers.push(answer);
        }
        Ok(Answered { answers, curve: None })
    }

    /// The answer that accompanies a curve.
    fn curved(&self, kind: &'static str, group: &Group, bad: Bad, n: u64, method: Method) -> Answer {
        let mut figures = Figures::over(n);
        figures.method = method;
        figures.approximate = method != Method::Without && self.scheme != Scheme::Independent;
        if let Scheme::Without(why) = &self.scheme {
            figures.notes.push(why.clone());
        }
        Answer { figures: Vec::new(), ..self.told(kind, group.clone(), bad, figures) }
    }

    fn exceedance(&self, column: &str) -> Result<Answered, InputError> {
        let mut points = vec![0; self.scheme.parts()];
        (0..self.study.points()).for_each(|point| points[self.part()(point)] += 1);
        let mut found = Vec::new();
        for at in 0..self.study.groups.len() {
            let values = reached(self.study, column, at)?;
            let (curve, method) = exceedance(&values, &self.scheme, &points, self.part(), self.alpha);
            found.push((curve, method, values.bad, values.empty));
        }
        self.curves_of(column, self.study.points() as u64, found)
    }

    /// Builds answers from curve, method, bad runs and runs without a value of each group.
    pub fn curves_of(
        &self,
        column: &str,
        points: u64,
        found: Vec<(Vec<CurvePoint>, Method, Bad, u64)>,
    ) -> Result<Answered, InputError> {
        let unit = &self.study.column(column)?.unit;
        let (mut answers, mut curves) = (Vec::new(), Vec::new());
        for (group, (curve, method, bad, empty)) in self.study.groups.iter().zip(found) {
            let mut answer = self.curved("exceedance", group, bad, points, method);
            if method == Method::Band {
                answer.notes.push("the limits hold for all levels together".to_owned());
            } else if method != Method::Without {
                answer.notes.push("the limits hold for each level separately".to_owned());
            }
            note_empty(&mut answer.notes, empty, NO_LEVEL);
            answer.sentence = of_curve(&answer, &format!("exceedance of {column}"), &curve, (unit, "level"), &bad);
            answers.push(answer);
            curves.push((group.clone(), curve));
        }
        Ok(Answered { answers, curve: Some(Curve::of(&curves, &[&with_unit("level", unit)])) })
    }

    /// Adds a note that names the parameters zipped with a varied parameter.
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
                let (mut curve, mut empty, mut all_bad) = (Vec::new(), 0, Bad::default());
                for (label, at) in members {
                    let truths = truths(self.study, formula, at)?;
                    let bad = truths.bad();
                    all_bad.add(&bad);
                    empty += truths.empty;
                    let figures = self.probability(&truths);
                    curve.push(CurvePoint { at: (label.clone(), label), bad: bad.all, figures });
                }
                all.push((group, curve, empty, all_bad));
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
                        bad += u64::from(truths.status[point as usize] != Status::Ok);
                    }
                    (proportion_by(&tallies, &self.scheme, self.alpha, self.t), bad)
                };
                let curve = bins.iter().map(|bin| {
                    let (figures, bad) = of_bin(&bin.points);
                    CurvePoint { at: bin.range.clone(), bad, figures }
                });
                all.push((group.clone(), curve.collect(), truths.empty, truths.bad()));
            }
        }
        let unit = self.study.column(path).map(|column| column.unit.clone()).unwrap_or_default();
        let (mut answers, mut curves) = (Vec::new(), Vec::new());
        for (group, curve, empty, bad) in all {
            let curve: Vec<CurvePoint> = curve;
            let n = curve.iter().map(|point| point.figures.n).sum();
            let method = curve.iter().map(|point| point.figures.method).max_by_key(|method| *method as u8);
            let mut answer = self.curved("fragility", &group, bad, n, method.unwrap_or(Method::Without));
            let what = if single { "value" } else { "bin" };
            if !single {
                answer.notes.push(match curve.len() {
                    1 => "one bin contains all points: a bin has at least 50".to_owned(),
                    count => format!("{count} bins of equal count: the probability is that over the bin"),
                });
            }
            if answer.method != Method::Without {
                answer.notes.push(format!("the limits hold for each {what} separately"));
            }
            note_empty(&mut answer.notes, empty, CONDITION);
            self.note_along(path, &mut answer.notes);
            let subject = format!("P({}) over {path}", formula.text);
            answer.sentence = of_curve(&answer, &subject, &curve, (&unit, what), &bad);
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
            let (figures, bad) = match figure {
                Figure::Probability(formula) => {
                    let (a, b) = (truths(self.study, formula, a)?, truths(self.study, formula, b)?);
                    let mut figures = difference::of_probabilities(&a, &b, &self.scheme, self.part(), self.alpha);
                    note_empty(&mut figures.notes, a.empty + b.empty, CONDITION);
                    (figures, both(a.bad(), b.bad()))
                }
                Figure::Quantile(_, column) | Figure::Mean(column) => {
                    let (a, b) = (self.values(figure, column, a)?, self.values(figure, column, b)?);
                    let mut figures = if let Figure::Quantile(u, _) = figure {
                        difference::of_quantiles(&a, &b, *u, &self.scheme, self.part(), self.alpha)
                    } else {
                        difference::of_means(&a, &b, &self.scheme, self.part(), self.alpha)
                    };
                    note_empty(&mut figures.notes, a.empty + b.empty, LEFT_OUT);
                    (figures, both(a.bad, b.bad))
                }
            };
            let mut answer = self.told("difference", group, bad, figures);
            self.note_along(path, &mut answer.notes);
            let of = format!("{}, {path} = {} less {}", self.subject(figure, &bad), labels[0], labels[1]);
            answer.sentence = sentence(&answer, &of, &scale, (&bad, self.decided_by(figure)));
            answer.scale = scale.clone();
            answers.push(answer);
        }
        Ok(Answered { answers, curve: None })
    }
}

/// Note on the values that decide a condition for runs that are not ok, where such values exist.
pub(crate) fn decided_by(study: &Study<'_>, formula: &Formula) -> &'static str {
    let is_reached = |name: &String| {
        study.numbers(name).is_ok_and(|(_, nature)| matches!(nature, Nature::Grows(_) | Nature::Once(_)))
    };
    let is_limit = |name: &String| study.numbers(name).is_ok_and(|(_, of)| matches!(of, Nature::Limit(_)));
    if formula.columns.iter().any(is_reached) {
        "counted by the values reached before a guard or limit was exceeded"
    } else if formula.columns.iter().any(is_limit) {
        "counted by the recorded limits"
    } else {
        "counted by their inputs"
    }
}

/// Sum of the bad runs of both groups of a difference.
fn both(first: Bad, second: Bad) -> Bad {
    let mut sum = first;
    sum.add(&second);
    sum
}
