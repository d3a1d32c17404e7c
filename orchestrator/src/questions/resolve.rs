//! Validation of the questions and gates of a study file; errors are reported at their places in the file.

use super::rows::design_kind;
use super::vocabulary::{Vocabulary, column_of, label};
use bladeoff_answers::ask::{Problem, Question, QuestionDef, SensitivityMethod};
use bladeoff_answers::estimate::input::Label;
use bladeoff_answers::gate::Gate;
use bladeoff_study::sampling::layout::{LayoutKind, SamplingLayout};
use bladeoff_study::{Asked, AskedGate, AskedQuestion, Parameter, Placed, Samples, ToCheck};
use bladeoff_text::document::{Collector, Problems};
use std::ops::Range;

/// Valid questions and gates.
#[derive(Debug, Clone, Default)]
pub struct Meant {
    /// Questions in the order of the file.
    pub questions: Vec<Question>,
    /// Gates in the order of the file.
    pub gates: Vec<Gate>,
}

/// A file with questions.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// Name of the file.
    pub file: &'a str,
    /// Text of the file.
    pub text: &'a str,
    /// Questions and gates as parsed.
    pub asked: &'a Asked,
}

/// Relative tolerance for a value of a range to be equal to the value as written.
const SAME: f64 = 1e-9;

/// Validates the questions and gates of a file for these samples.
///
/// # Errors
/// All errors of questions and gates.
pub fn meant(samples: &Samples, source: Source<'_>) -> Result<Meant, Problems> {
    let mut problems = Collector::new(source.file, source.text);
    let mut found = Meant::default();
    match (samples.layout(), Vocabulary::of(samples)) {
        (None, vocabulary) => {
            needs_design(source.asked, &mut problems);
            if let Some(vocabulary) = vocabulary {
                found = understand(&vocabulary, source.asked, false, &mut problems);
            }
        }
        (Some(layout), Some(vocabulary)) => {
            refuse_inexact(layout, source.asked, &mut problems);
            refuse_methods(layout, source.asked, &mut problems);
            found = understand(&vocabulary, source.asked, true, &mut problems);
        }
        (Some(_), None) => {}
    }
    problems.finish().map(|()| found)
}

/// Checks questions and gates of a file that was just read. Returns samples, questions and gates if all are valid.
pub(super) fn check_questions(to_check: &ToCheck<'_>, problems: &mut Collector<'_>) -> Option<(Samples, Meant)> {
    let &ToCheck { asked, study, machine, is_function, names, has_design } = to_check;
    if !has_design {
        needs_design(asked, problems);
        if !asked.questions.iter().any(|question| question.map.is_some()) {
            return None;
        }
    }
    let is_partly = study.is_none() || !problems.is_empty();
    // too many samples: reported when the study is run
    let samples = study.and_then(|study| Samples::new(study.clone(), None, None).ok());
    let whole = samples.as_ref().and_then(Vocabulary::of);
    if let (Some(samples), Some(_)) = (&samples, &whole)
        && let Some(layout) = samples.layout()
    {
        refuse_inexact(layout, asked, problems);
        refuse_methods(layout, asked, problems);
    }
    // without other problems, a machine that cannot be built belongs to a sample and is reported with the samples
    let of_machine = || Vocabulary::of_machine(machine).filter(|_| is_partly && (machine.is_some() || is_function));
    let mut vocabulary = whole.or_else(of_machine)?;
    if is_partly {
        vocabulary.mention(names);
    }
    let meant = understand(&vocabulary, asked, has_design, problems);
    drop(vocabulary);
    samples.filter(|_| problems.is_empty()).map(|samples| (samples, meant))
}

fn needs_design(asked: &Asked, problems: &mut Collector<'_>) {
    // maps also work for chosen values
    let is_map = |question: &AskedQuestion| question.map.is_some() || question.has_map;
    let question = asked.questions.iter().enumerate().find(|(_, question)| !is_map(question));
    let first = question.map(|(at, question)| (format!("question[{at}]"), question.span.clone()));
    let first = first.or(asked.gates.first().map(|gate| ("gate[0].require".to_owned(), gate.require.span.clone())));
    if let Some((key, span)) = first {
        let message = "questions and gates need random points, so a [design]";
        problems.add(span, key, message).allowed =
            Some("[design] with kind = \"monte-carlo\" and samples = 1000, and [[uncertain]] parameters".to_owned());
    }
}

/// Rejects gates if the points have no exact limits.
fn refuse_inexact(layout: &SamplingLayout, asked: &Asked, problems: &mut Collector<'_>) {
    if layout.kind() == LayoutKind::MonteCarlo {
        return;
    }
    for (position, gate) in asked.gates.iter().enumerate() {
        let message = format!("a gate needs exact limits, and points of kind {:?} have none", layout.kind().word());
        problems.add(gate.require.span.clone(), format!("gate[{position}].require"), message).allowed =
            Some(format!("kind = {:?} in [design]", LayoutKind::MonteCarlo.word()));
    }
}

/// Rejects sensitivities whose estimator is not valid for these points.
fn refuse_methods(layout: &SamplingLayout, asked: &Asked, problems: &mut Collector<'_>) {
    for (position, question) in asked.questions.iter().enumerate() {
        let Some(Placed { value, span }) = question.method.as_ref().filter(|_| question.sensitivity.is_some()) else {
            continue;
        };
        // an unknown word is rejected elsewhere
        let method = SensitivityMethod::ALL.iter().find(|(word, _)| word == value).map(|(_, method)| *method);
        let check = |method: SensitivityMethod| method.check(design_kind(layout), layout.replicates() as usize);
        let Some(Err(message)) = method.map(check) else { continue };
        let fit = SensitivityMethod::ALL.iter().filter(|(_, method)| check(*method).is_ok());
        let fit: Vec<String> = fit.map(|(word, _)| format!("{word:?}")).collect();
        let told = problems.add(span.clone(), format!("question[{position}].method"), message);
        told.value = Some(format!("{value:?}"));
        told.allowed = Some(match fit.first() {
            Some(_) => format!("method = {} with this [design]", fit.join(" or ")),
            None if *value == SensitivityMethod::GivenData.word() => {
                "kind = \"monte-carlo\" or \"latin-hypercube\", or replicates = 16, in [design]".to_owned()
            }
            None => "another kind in [design]".to_owned(),
        });
    }
}

/// Validates questions and gates; without a design, only maps.
fn understand(vocabulary: &Vocabulary<'_>, asked: &Asked, has_design: bool, problems: &mut Collector<'_>) -> Meant {
    let mut found = Meant::default();
    let mut reader = Reader { vocabulary, problems };
    for (position, question) in asked.questions.iter().enumerate() {
        if !has_design && question.map.is_none() {
            continue;
        }
        found.questions.extend(reader.question(&format!("question[{position}]"), question));
    }
    for (position, gate) in asked.gates.iter().enumerate().filter(|_| has_design) {
        found.gates.extend(reader.gate(&format!("gate[{position}]"), gate));
    }
    found
}

struct Reader<'a, 't> {
    vocabulary: &'a Vocabulary<'a>,
    problems: &'a mut Collector<'t>,
}

impl Reader<'_, '_> {
    fn question(&mut self, key: &str, asked: &AskedQuestion) -> Option<Question> {
        let text = |placed: &Option<Placed<String>>| placed.as_ref().map(|placed| placed.value.clone());
        let number = |placed: &Option<Placed<f64>>| placed.as_ref().map(|placed| placed.value);
        let difference = asked.difference.as_ref().map(|placed| self.values(key, placed, asked.vary.as_ref()));
        let is_misread = matches!(difference, Some(None));
        let def = QuestionDef {
            // a name that could not be read is reported elsewhere
            name: text(&asked.name).unwrap_or_else(|| "unnamed".to_owned()),
            probability: text(&asked.probability),
            quantile: number(&asked.quantile),
            of: text(&asked.of),
            map: asked.map.as_ref().map(|placed| placed.value.clone()),
            mean: text(&asked.mean),
            exceedance: text(&asked.exceedance),
            sensitivity: text(&asked.sensitivity),
            method: text(&asked.method),
            fragility: text(&asked.fragility),
            difference: difference.flatten(),
            // on its own, `vary` would cause an error about the key that could not be read
            vary: text(&asked.vary).filter(|_| !is_misread && (asked.difference.is_some() || !asked.is_partly)),
            confidence: number(&asked.confidence),
        };
        match Question::new(&def, &self.vocabulary.names) {
            Ok(question) => (!asked.is_partly && !is_misread).then_some(question),
            Err(told) => {
                for problem in told {
                    // the missing key may be the one that could not be read
                    if asked.is_partly
                        && problem.place.is_none()
                        && ["name", "vary", "quantile", "method", "map"].contains(&problem.key)
                    {
                        continue;
                    }
                    let formula = if problem.key == "of" { &asked.of } else { &asked.probability };
                    let formula = formula.as_ref().filter(|_| ["of", "probability"].contains(&problem.key));
                    let span = match (&problem.place, formula) {
                        (Some(place), Some(Placed { value, span })) => self.problems.inside(span, value, place),
                        _ => asked.place(problem.key),
                    };
                    self.add(key, &problem, span);
                }
                None
            }
        }
    }

    fn gate(&mut self, key: &str, asked: &AskedGate) -> Option<Gate> {
        let AskedGate { require: Placed { value, span }, confidence } = asked;
        let told = match Gate::new(value, confidence.as_ref().map(|placed| placed.value), &self.vocabulary.names) {
            Ok(gate) => return Some(gate),
            Err(told) => told,
        };
        for problem in told {
            let span = match (&problem.place, confidence) {
                (Some(place), _) => self.problems.inside(span, value, place),
                (None, Some(confidence)) => confidence.span.clone(),
                (None, None) => span.clone(),
            };
            self.add(key, &problem, span);
        }
        None
    }

    fn add(&mut self, key: &str, problem: &Problem, span: Range<usize>) {
        let value = self.problems.excerpt(span.clone());
        let is_header = value.starts_with("[[");
        let told = self.problems.add(span, format!("{key}.{}", problem.key), &problem.message);
        told.allowed.clone_from(&problem.allowed);
        told.value = Some(value.trim().to_owned()).filter(|_| !is_header);
    }

    /// Values of a difference, parsed as values of the varied parameter; `None` if one is not a value of the parameter.
    fn values(&mut self, key: &str, placed: &Placed<[String; 2]>, vary: Option<&Placed<String>>) -> Option<[Label; 2]> {
        let names = &self.vocabulary.names;
        let meant = vary.map(|vary| names.known.meant(&vary.value)).unwrap_or_default();
        let axis = names.varied.iter().find(|(column, _)| meant.contains(&column.as_str()));
        let known = axis.map(|(_, known)| known.as_slice()).unwrap_or_default();
        let of_axis = |parameter: &&Parameter| axis.is_some_and(|(column, _)| column_of(parameter) == *column);
        let parameter = self.vocabulary.parameters.iter().find(of_axis);
        let machine = self.vocabulary.machine.zip(parameter.filter(|parameter| !parameter.is_variable));
        let mut labels = Vec::new();
        for text in &placed.value {
            let parsed = match machine {
                Some((machine, parameter)) => {
                    machine.parse_value(&parameter.info, text).map(label).map_err(|error| error.to_string())
                }
                None => Ok(text.trim().parse().map_or_else(|_| Label::Word(text.clone()), Label::Number)),
            };
            match parsed {
                Ok(Label::Number(number)) => {
                    let near = |other: &&Label| matches!(other, Label::Number(other) if (other - number).abs() <= SAME * number.abs());
                    labels.push(known.iter().find(near).cloned().unwrap_or(Label::Number(number)));
                }
                Ok(word) => labels.push(word),
                Err(message) => {
                    let value = self.problems.excerpt(placed.span.clone());
                    self.problems.add(placed.span.clone(), format!("{key}.difference"), message).value = Some(value);
                }
            }
        }
        labels.try_into().ok()
    }
}

/// Gates from the command line.
///
/// # Errors
/// Text and error message of each invalid gate.
pub fn only_gates(
    samples: &Samples,
    texts: &[String],
    confidence: Option<f64>,
) -> Result<Vec<Gate>, Vec<(String, String)>> {
    let Some(vocabulary) = Vocabulary::of(samples) else { return Ok(Vec::new()) };
    let (mut gates, mut wrong) = (Vec::new(), Vec::new());
    for text in texts {
        let told = match Gate::new(text, confidence, &vocabulary.names) {
            Ok(gate) => {
                gates.push(gate);
                continue;
            }
            Err(told) => told,
        };
        let words = told.into_iter().map(|problem| match problem.place {
            Some(place) if !place.is_empty() && place != (0..text.len()) => {
                format!("at `{}`: {}", text.get(place).unwrap_or(text), problem.message)
            }
            _ => problem.message,
        });
        wrong.push((text.clone(), words.collect::<Vec<_>>().join("; ")));
    }
    if wrong.is_empty() { Ok(gates) } else { Err(wrong) }
}
