//! Variables computed by formulas of others.

use bladeoff_study::derived::{Derived, DerivedError, Variable, name_mistakes};

fn variables(derived: &[&str]) -> Vec<Variable> {
    let word = Variable { has_words: true, ..Variable::number("run.braking", Some("braking"), "") };
    let mut all = vec![
        Variable::number("cold_gap", None, "m"),
        Variable::number("diaphragms.seal.contact.friction", Some("mu"), ""),
        Variable::number("rotor.bearings.left.stiffness", None, "N/m"),
        Variable::number("rotor.bearings.right.stiffness", None, "N/m"),
        word,
    ];
    all.extend(derived.iter().map(|name| Variable::number(name, None, "m")));
    all
}

fn made(formulas: &[(&str, &str)]) -> Result<Derived, Vec<DerivedError>> {
    let names: Vec<&str> = formulas.iter().map(|(name, _)| *name).collect();
    let texts: Vec<String> = formulas.iter().map(|(_, text)| (*text).to_owned()).collect();
    Derived::new(variables(&names), &texts)
}

fn values(derived: &Derived) -> Result<Vec<f64>, String> {
    let mut values = vec![2e-3, 0.3, 1e8, 2e8, 1.0];
    derived.extend(&mut values, &mut Vec::new()).map_err(|error| error.to_string())?;
    Ok(values[5..].to_vec())
}

#[test]
fn formulas_are_computed_after_what_they_need_in_any_order_of_the_file() {
    let forward =
        made(&[("growth", "0.5 mm * (1 + mu)"), ("gap", "cold_gap - growth"), ("half", "gap/2 + 0*growth")]).unwrap();
    let backward =
        made(&[("half", "gap/2 + 0*growth"), ("gap", "cold_gap - growth"), ("growth", "0.5 mm * (1 + mu)")]).unwrap();
    let growth = 0.5 * 1e-3 * 1.3;
    let expected = [growth, 2e-3 - growth, (2e-3 - growth) / 2.0];
    assert_eq!(values(&forward).unwrap(), expected);
    assert_eq!(values(&backward).unwrap(), [expected[2], expected[1], expected[0]]);
    // a path, its ending in backquotes, its short name
    let paths = made(&[("a", "`left.stiffness` + `rotor.bearings.right.stiffness`"), ("b", "`contact.friction` - mu")])
        .unwrap();
    assert_eq!(values(&paths).unwrap(), [3e8, 0.0]);
    assert_eq!(values(&made(&[]).unwrap()).unwrap(), [0.0; 0]);
}

#[test]
fn circles_are_refused_by_their_names_each_of_them() {
    let errors = made(&[
        ("a", "b + 1"),
        ("x", "a"),
        ("b", "c*2"),
        ("c", "a - cold_gap"),
        ("self_made", "self_made + 1"),
        ("fine", "mu"),
    ])
    .unwrap_err();
    let shown: Vec<String> = errors.iter().map(ToString::to_string).collect();
    assert_eq!(
        shown,
        ["derived in a circle: a needs b needs c needs a", "derived in a circle: self_made needs self_made"]
    );
    // a variable that depends on a circle is not part of the circle
    let errors = made(&[("x", "a"), ("a", "b"), ("b", "a")]).unwrap_err();
    assert_eq!(errors, [DerivedError::Circle { formula: 1, circle: ["a", "b", "a"].map(str::to_owned).to_vec() }]);
}

#[test]
fn every_mistake_is_found_with_its_place() {
    let errors = made(&[
        ("a", "cold_gpa - 1"),
        ("b", "1 + `stiffness`"),
        ("c", "braking * 2"),
        ("d", "log(mu)"),
        ("e", "f"),
        ("f", "e"),
        ("g", "3 furlong"),
    ])
    .unwrap_err();
    let shown: Vec<(usize, String)> = errors.iter().map(|error| (error.formula(), error.to_string())).collect();
    let expected = [
        (0, "there is no variable `cold_gpa`; did you mean `cold_gap`?"),
        (1, "there is no variable `stiffness`; did you mean `rotor.bearings.left.stiffness`?"),
        (2, "`braking` holds words, not numbers"),
        (3, "`log` means two things: write `ln` or `log10`"),
        (4, "derived in a circle: e needs f needs e"),
        (6, "unknown unit `furlong`"),
    ];
    assert_eq!(shown.len(), expected.len(), "{shown:?}");
    for ((formula, text), (number, expected)) in shown.iter().zip(expected) {
        assert_eq!((*formula, text.as_str()), (number, expected));
    }
    assert!(matches!(&errors[0], DerivedError::Formula { place, .. } if *place == (0..8)));
    assert!(matches!(&errors[1], DerivedError::Formula { place, .. } if *place == (4..15)));
}

#[test]
fn a_value_that_is_not_finite_says_what_led_to_it() {
    let derived = made(&[("zero", "cold_gap - 2 mm"), ("gap", "mu/zero")]).unwrap();
    assert_eq!(values(&derived).unwrap_err(), "gap = inf, derived from mu = 0.3, zero = 0 m");
    let derived = made(&[("gap", "sqrt(-cold_gap)"), ("later", "gap + 1")]).unwrap();
    assert_eq!(values(&derived).unwrap_err(), "gap = NaN, derived from cold_gap = 2 mm");
}

#[test]
fn a_column_ends_in_its_unit() {
    let column = |short, unit| Variable::number("rotor.bearings.left.damping", short, unit).column();
    assert_eq!(column(Some("damping"), "N s/m"), "damping_Ns_m");
    assert_eq!(column(None, "N s/m"), "rotor.bearings.left.damping_Ns_m");
    assert_eq!(column(Some("damping"), ""), "damping");
}

#[test]
fn names_that_formulas_cannot_have_are_refused() {
    let variables = [
        Variable::number("contact.gap", Some("gap"), "m"),
        Variable::number("gap", None, "m"),
        Variable::number("pi", None, ""),
        Variable::number("a.b", Some("2nd"), ""),
        Variable::number("c.d", Some("max"), ""),
        Variable::number("c.d", Some("é"), ""),
        Variable::number("contact.gap_2", Some("gap_2"), "m"),
    ];
    let paths = [0, 3, 4, 5, 6];
    let errors = name_mistakes(&variables, |number| paths.contains(&number));
    let shown: Vec<String> = errors.iter().map(ToString::to_string).collect();
    let letters =
        "cannot be a name; allowed: letters of the English alphabet, digits and `_`, the first no digit, at most 64";
    let expected = [
        "`gap` is already the name of contact.gap; allowed: another name".to_owned(),
        "`pi` is a word of formulas; allowed: another name".to_owned(),
        format!("\"2nd\" {letters}"),
        "`max` is a word of formulas; allowed: another name".to_owned(),
        format!("\"é\" {letters}"),
        "`c.d` is already the name of c.d; allowed: another name".to_owned(),
    ];
    assert_eq!(shown, expected);
}
