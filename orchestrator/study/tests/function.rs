//! `model = "function"`: names and formulas of a study without a machine.

use bladeoff_model::machine::ParamValue;
use bladeoff_study::derived::Variable;
use bladeoff_study::{FunctionError, FunctionModel, MOST_OUTPUTS};

fn variables() -> Vec<Variable> {
    let mut word = Variable::number("kind", None, "");
    word.has_words = true;
    vec![Variable::number("x", None, ""), Variable::number("length", Some("l"), "m"), word]
}

fn outputs(pairs: &[(&str, &str)]) -> Vec<(String, String)> {
    pairs.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect()
}

fn model(pairs: &[(&str, &str)]) -> Result<FunctionModel, Vec<FunctionError>> {
    FunctionModel::new(&outputs(pairs), &variables())
}

#[test]
fn formulas_are_evaluated_over_the_variables_in_their_order() {
    let model = model(&[("g", "3 - x"), ("h_2", "l / 2 mm"), ("k", "length * x")]).expect("a model");
    let values = [0.5, 0.004, 0.0];
    let found: Vec<f64> =
        model.outputs.iter().map(|output| output.program.value(|number| values[number], &mut Vec::new())).collect();
    assert_eq!(found, [2.5, 2.0, 0.002]);
    assert_eq!(model.outputs[0].text, "3 - x");
}

#[test]
fn every_mistake_is_told_with_its_output_and_its_place() {
    let wrong = [
        ("2g", "x"),
        ("max", "x"),
        ("status", "x"),
        ("block", "x"),
        ("x", "x"),
        ("l_m", "x"),
        ("l", "x"),
        ("a", "x + y"),
        ("a", "1 +"),
        ("b", "x > 1"),
        ("c", "kind + 1"),
        ("d", "log(x)"),
        ("fine", "x"),
    ];
    let errors = model(&wrong).expect_err("mistakes");
    let told: Vec<(Option<usize>, String)> = errors.iter().map(|error| (error.output(), error.to_string())).collect();
    let has = |output: usize, words: &str| {
        let found = told.iter().filter(|(at, text)| *at == Some(output) && text.contains(words)).count();
        assert_eq!(found, 1, "{output}: {words}: {told:#?}");
    };
    has(0, "\"2g\" cannot be a name");
    has(1, "`max` is a word of formulas");
    has(2, "a column of every table has the name `status`");
    has(3, "a column of every table has the name `block`");
    has(4, "the variable x has the name `x`");
    has(5, "the variable l has the name `l_m`");
    has(6, "the variable l has the name `l`");
    has(7, "there is no variable `y`");
    has(8, "an output before it has the name `a`");
    has(8, "the formula ends too early");
    has(9, "a number is expected");
    has(10, "`kind` holds words");
    has(11, "write `ln` or `log10`");
    assert_eq!(told.len(), 13, "{told:#?}");
    let place = errors.iter().find_map(|error| match error {
        FunctionError::Formula { output: 7, place, .. } => Some(place.clone()),
        _ => None,
    });
    assert_eq!(place, Some(4..5));
}

#[test]
fn as_many_as_a_message_holds_are_allowed() {
    let many = |count: usize| (0..count).map(|i| (format!("g{i}"), "1".to_owned())).collect::<Vec<_>>();
    assert!(FunctionModel::new(&many(MOST_OUTPUTS), &[]).is_ok());
    let errors = FunctionModel::new(&many(MOST_OUTPUTS + 1), &[]).expect_err("one more");
    assert_eq!(errors, [FunctionError::TooMany { count: 101 }]);
    assert_eq!(errors[0].output(), Some(100), "the first that is too many");
    assert_eq!(FunctionModel::new(&[], &[]).expect_err("none"), [FunctionError::Nothing]);
    let variables = |count: usize| (0..count).map(|i| Variable::number(&format!("x{i}"), None, "")).collect::<Vec<_>>();
    assert!(FunctionModel::new(&many(1), &variables(128)).is_ok());
    let errors = FunctionModel::new(&many(1), &variables(129)).expect_err("one more");
    assert_eq!(errors, [FunctionError::TooManyVariables { count: 129 }]);
}

/// Identities are stored in the record of every result directory, so they must not change.
#[test]
fn an_identity_is_that_of_names_texts_and_values() {
    let of = |pairs: &[(&str, &str)]| model(pairs).expect("a model").identity();
    let base = of(&[("g", "x"), ("h", "l")]);
    assert_eq!(base, of(&[("g", "x"), ("h", "l")]));
    for other in
        [&[("g", "x")][..], &[("h", "l"), ("g", "x")], &[("g", "x"), ("h", "l + 0")], &[("gx", "x"), ("h", "l")]]
    {
        assert_ne!(base, of(other), "{other:?}");
    }
    let part = |name: &str, value: f64| FunctionModel::identity_of(name, &ParamValue::Number(value));
    assert_eq!(part("x", 1.0), part("x", 1.0));
    assert_ne!(part("x", 1.0), part("x", 2.0));
    assert_ne!(part("x", 1.0), part("y", 1.0));
    assert_ne!(part("x", 1.0), FunctionModel::identity_of("x", &ParamValue::Choice("1".to_owned())));
}
