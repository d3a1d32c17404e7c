//! Valid and invalid questions, and their error messages.

use super::support::{names, one, ramp};
use bladeoff_answers::ask::{Ask, Figure, Known, Names, Problem, Question, QuestionDef};
use bladeoff_answers::estimate::input::Label;
use bladeoff_answers::gate::Gate;

fn columns() -> Names {
    let axis = ("way".to_owned(), vec![Label::Word("hyp1".into()), Label::Word("hyp2".into())]);
    let columns = ["max_bearing_load_N", "end_speed_rad_s", "seal.gap_m", "way", "status"];
    let aliases = [("gap", "seal.gap_m"), ("seal.gap", "seal.gap_m"), ("contact.way", "way"), ("word", "status")];
    let aliases = aliases.into_iter().chain([("load", "max_bearing_load_N"), ("load", "end_speed_rad_s")]);
    let known = Known {
        columns: columns.map(|name| (name.to_owned(), !["way", "status"].contains(&name))).to_vec(),
        aliases: aliases.map(|(alias, column)| (alias.to_owned(), column.to_owned())).collect(),
        ..Known::default()
    };
    Names { known, uncertain: vec!["seal.gap_m".into()], varied: vec![axis], ..Names::default() }
}

fn read(def: QuestionDef) -> Result<Question, Vec<String>> {
    Question::new(&def, &columns()).map_err(|problems| {
        problems
            .into_iter()
            .map(|problem| format!("{} {:?}: {}", problem.key, problem.place, problem.message))
            .collect()
    })
}

fn base() -> QuestionDef {
    QuestionDef { name: "overload".into(), ..QuestionDef::default() }
}

#[test]
fn a_question_knows_its_columns() {
    let text = "max_bearing_load_N > 1.2 MN and end_speed_rad_s < 50 or max_bearing_load_N > 2e6";
    let question = read(QuestionDef { probability: Some(text.into()), ..base() }).expect("a question");
    assert_eq!(question.columns(&columns()), ["max_bearing_load_N", "end_speed_rad_s"]);
    assert_eq!(question.confidence, 0.95);
    let Ask::One(Figure::Probability(formula)) = question.ask else { panic!("a probability") };
    assert_eq!(formula.program.value(|number| [1.3e6, 40.0][number], &mut Vec::new()), 1.0);
    assert_eq!(formula.program.value(|number| [1.1e6, 40.0][number], &mut Vec::new()), 0.0);
}

#[test]
fn other_names_of_a_column_mean_it() {
    let question = read(QuestionDef { probability: Some("gap < 1 mm and `seal.gap` > 0".into()), ..base() });
    assert_eq!(question.expect("a question").columns(&columns()), ["seal.gap_m"]);
    let text = Some("end_speed_rad_s < 1".to_owned());
    let over = |path: &str| read(QuestionDef { fragility: Some(path.into()), probability: text.clone(), ..base() });
    let asked = |question: Question| match question.ask {
        Ask::Fragility(column, _) | Ask::Difference(_, column, _) => column,
        other => panic!("{other:?}"),
    };
    for (name, column) in [("gap", "seal.gap_m"), ("seal.gap_m", "seal.gap_m"), ("contact.way", "way")] {
        assert_eq!(asked(over(name).expect("a question")), column, "{name}");
    }
    let values = ["hyp1", "hyp2"].map(|word| Label::Word(word.into()));
    let less =
        QuestionDef { difference: Some(values), vary: Some("contact.way".into()), mean: Some("gap".into()), ..base() };
    assert_eq!(asked(read(less).expect("a question")), "way");
    let one = |def: QuestionDef| read(def).expect_err("a mistake").join("\n");
    let told = one(QuestionDef { mean: Some("load".into()), ..base() });
    assert!(told.contains("`load` could be max_bearing_load_N or end_speed_rad_s"), "{told}");
    let told = one(QuestionDef { probability: Some("load > 1".into()), ..base() });
    assert!(told.contains("`load` could be max_bearing_load_N or end_speed_rad_s"), "{told}");
    let told = one(QuestionDef { probability: Some("word > 1".into()), ..base() });
    assert!(told.contains("`word` is a column of words"), "{told}");
    let told =
        one(QuestionDef { fragility: Some("contact.wey".into()), probability: Some("gap > 1".into()), ..base() });
    assert!(told.contains("neither varied nor uncertain; did you mean `contact.way`?"), "{told}");
}

#[test]
fn every_mistake_is_told_at_once_with_the_nearest_name() {
    let found = read(QuestionDef {
        name: "../x".into(),
        probability: Some("max_bearing_laod_N > 1e6".into()),
        confidence: Some(95.0),
        of: Some("gap".into()),
        ..QuestionDef::default()
    });
    let told = found.expect_err("mistakes").join("\n");
    for part in [
        "name",
        "did you mean `max_bearing_load_N`?",
        "probability Some(0..18)",
        "95 is not between 0 and 1",
        "`of` belongs",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
    let one = |def: QuestionDef| read(def).expect_err("a mistake").join("\n");
    assert!(one(base()).contains("here is none"));
    let two =
        QuestionDef { probability: Some("end_speed_rad_s > 1".into()), mean: Some("end_speed_rad_s".into()), ..base() };
    assert!(one(two).contains("here is probability and mean"));
    assert!(one(QuestionDef { probability: Some("end_speed_rad_s".into()), ..base() }).contains("a condition"));
    assert!(one(QuestionDef { probability: Some("status > 1".into()), ..base() }).contains("column of words"));
    assert!(one(QuestionDef { mean: Some("status".into()), ..base() }).contains("column of words"));
    assert!(one(QuestionDef { mean: Some("end_sped_rad_s".into()), ..base() }).contains("`end_speed_rad_s`"));
    assert!(one(QuestionDef { quantile: Some(0.95), ..base() }).contains("needs `of = COLUMN`"));
    let of = Some("end_speed_rad_s".to_owned());
    assert!(one(QuestionDef { quantile: Some(1.0), of, ..base() }).contains("not between"));
    let fragility = |path: &str| QuestionDef {
        fragility: Some(path.into()),
        probability: Some("end_speed_rad_s > 1".into()),
        ..base()
    };
    assert!(read(fragility("gap")).is_ok() && read(fragility("way")).is_ok());
    // an outcome is not a parameter
    assert!(one(fragility("end_speed_rad_s")).contains("neither varied nor uncertain"));
    let difference = |a: &str, b: &str, path: &str| QuestionDef {
        difference: Some([Label::Word(a.into()), Label::Word(b.into())]),
        vary: Some(path.into()),
        mean: Some("end_speed_rad_s".into()),
        ..base()
    };
    assert!(read(difference("hyp1", "hyp2", "way")).is_ok());
    assert!(one(difference("hyp1", "hyp1", "way")).contains("both are"));
    assert!(one(difference("hyp1", "hyp3", "way")).contains("hyp3 is not a value of `way`: hyp1, hyp2"));
    assert!(one(difference("hyp1", "hyp2", "wya")).contains("did you mean `way`?"));
    let lone = QuestionDef { vary: None, ..difference("hyp1", "hyp2", "way") };
    assert!(one(lone).contains("belong together"));
}

fn gate(text: &str) -> Result<Gate, String> {
    let told = |problems: Vec<Problem>| {
        problems.into_iter().map(|problem| format!("{:?} {}", problem.place, problem.message)).collect::<String>()
    };
    Gate::new(text, None, &columns()).map_err(told)
}

#[test]
fn a_gate_is_read_or_refused_with_words() {
    for (text, bound) in [
        ("P(max_bearing_load_N > 1.2 MN) < 1e-2", 1e-2),
        ("  P ( (max_bearing_load_N > 1e6) and (end_speed_rad_s < 5) )<1 %", 0.01),
        ("P(max(max_bearing_load_N, 2) > 1e6) < 1/1000", 1e-3),
    ] {
        assert_eq!(gate(text).unwrap_or_else(|told| panic!("{text}: {told}")).bound, bound);
    }
    for (text, part) in [
        ("P(max_bearing_load_N > 1) <= 0.1", "write `<`"),
        ("P(max_bearing_load_N > 1) > 0.1", "a gate checks that a probability is small"),
        ("max_bearing_load_N < 5", "a gate is `P(CONDITION) < BOUND`"),
        ("Q(0.95, max_bearing_load_N) < 5", "a gate is"),
        ("P(max_bearing_load_N > 1 < 0.1", "`)` is missing"),
        ("P(max_bearing_load_N > 1)", "a gate is"),
        ("P(max_bearing_load_N > 1) < 0", "above 0 and at most 1"),
        ("P(max_bearing_load_N > 1) < 2", "above 0 and at most 1"),
        ("P(max_bearing_load_N > 1) <", "no formula"),
        // a bound with a unit would be misread: 1 kg is 1
        ("P(max_bearing_load_N > 1) < 5 mm", "Some(30..31) a bound is a plain number"),
        ("P(max_bearing_load_N > 1) < 1°", "a bound is a plain number"),
        ("P(max_bearing_load_N > 1) < 0.1 0.2", "Some(32..35)"),
        ("P(max_bearing_laod_N > 1) < 0.1", "Some(2..20) there is no variable"),
        ("P() < 0.1", "no formula"),
        ("", "a gate is"),
        ("P(ü > 1) < 0.1", "there is no variable"),
    ] {
        let told = gate(text).expect_err(text);
        assert!(told.contains(part), "{text}: {told}");
    }
    assert!(Gate::new("P(y > 1) < 0.1", Some(1.0), &names()).is_err());
}

/// First orders by ranks have an interval from 256 rows on; with fewer there is no ranking.
#[test]
fn indices_without_an_interval_are_not_ranked() {
    let asked =
        || QuestionDef { sensitivity: Some("y".into()), method: Some("given-data".into()), ..QuestionDef::default() };
    let few = one(&ramp(100), asked());
    let says = "share of the variance of each parameter alone: no ranking, since no index has an interval, 100 rows";
    assert!(few.sentence.contains(says), "{}", few.sentence);
    assert_eq!(few.most_decisive(), None);
    assert!(few.lines.iter().any(|line| line.starts_with("u  ")), "{:?}", few.lines);
    let many = one(&ramp(300), asked());
    assert!(
        many.sentence.contains("parameter alone: u 9") && many.sentence.contains("(about 95 %: "),
        "{}",
        many.sentence
    );
    assert_eq!(many.most_decisive(), Some(0));
}
