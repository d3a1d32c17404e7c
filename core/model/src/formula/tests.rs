//! The language by example: values, and refusals with their places.

use super::{FormulaError, Kind, parse};

const NAMES: [&str; 4] = ["x", "y", "max_load_N", "rotor.bearings.left.stiffness"];
const VALUES: [f64; 4] = [2.0, 3.0, 1.3e6, 5.0];

fn evaluate(text: &str, kind: Kind) -> Result<f64, FormulaError> {
    let known = |name: &str| NAMES.iter().position(|known| *known == name);
    let nearest = |name: &str| crate::document::nearest(name, NAMES).map(str::to_owned);
    let program = parse(text, kind, &known, &nearest)?;
    Ok(program.value(|variable| VALUES[variable], &mut Vec::new()))
}

#[test]
fn formulas_have_the_values_of_the_school() {
    let numbers: [(&str, f64); 24] = [
        ("-2^2", -4.0),
        ("2^3^2", 512.0),
        ("2^-1", 0.5),
        ("1e-3*x", 2e-3),
        ("1/2*x", 1.0),
        ("10 - 2 - 3", 5.0),
        ("x/y/2", 2.0 / 3.0 / 2.0),
        ("-x^2", -4.0),
        ("2*-x", -4.0),
        ("+x - -y", 5.0),
        (".5 + 5.", 5.5),
        ("min(x, y, 1)", 1.0),
        ("max(x, -y)", 2.0),
        ("hypot(3, 4)", 5.0),
        ("sqrt(x + y + 4)", 3.0),
        ("pi", std::f64::consts::PI),
        ("ln(exp(1))", 1.0),
        ("log10(1000)", 3.0),
        ("floor(-0.5)", -1.0),
        ("`rotor.bearings.left.stiffness`*2", 10.0),
        ("0.36 mm", 0.000_36),
        ("8 mm + 1 mm", 8e-3 + 1e-3),
        ("3 N/m*x", 6.0),
        ("2 kg*m^2/s", 2.0),
    ];
    for (text, value) in numbers {
        assert_eq!(evaluate(text, Kind::Number), Ok(value), "{text}");
    }
    let truths = [
        ("max_load_N > 1.2e6", true),
        ("max_load_N > 1.2 MN and x < 1", false),
        ("max_load_N > 1.2e6 and x < 1 or y == 3", true),
        ("y == 3 or x < 1 and x > 9", true),
        ("not x > 5", true),
        ("not (x > 1 and y > 1)", false),
        ("x != y", true),
        ("x <= 2 and x >= 2", true),
        ("sqrt(-1) < 1 or sqrt(-1) >= 1 or sqrt(-1) == sqrt(-1)", false),
    ];
    for (text, holds) in truths {
        assert_eq!(evaluate(text, Kind::Truth), Ok(f64::from(u8::from(holds))), "{text}");
    }
}

#[test]
fn a_mistake_is_told_with_its_place() {
    let wrong: [(&str, std::ops::Range<usize>, &str); 22] = [
        ("", 0..0, "there is no formula"),
        ("x x", 2..3, "operator is missing"),
        ("2 x", 2..3, "unknown unit"),
        ("(x", 2..2, "`)` is missing"),
        ("log(x)", 0..3, "`ln` or `log10`"),
        ("1 < 2 < 3", 6..7, "write `a < b and b < c`"),
        ("(x > 1) + 2", 8..9, "not conditions"),
        ("x and y", 2..5, "joins conditions"),
        ("not x", 0..3, "takes a condition"),
        ("min()", 4..5, "is not expected here"),
        ("sqrt(1, 2)", 0..4, "takes 1 arguments, not 2"),
        ("x = 2", 2..3, "write `==`"),
        ("2mmm", 1..4, "unknown unit `mmm`"),
        ("x $ 2", 2..3, "no sign of a formula"),
        ("`abc", 0..4, "not closed"),
        ("``", 0..2, "name is missing"),
        ("1e999", 0..5, "finite"),
        ("x >", 3..3, "ends too early"),
        ("foo(2)", 0..3, "no function `foo`"),
        ("max_load", 0..8, "did you mean `max_load_N`?"),
        ("x > 1", 0..5, "a number is wanted"),
        ("pi(2)", 0..2, "no function `pi`"),
    ];
    for (text, place, message) in wrong {
        let error = evaluate(text, Kind::Number).expect_err(text);
        assert!(error.message.contains(message), "{text}: {error}");
        assert_eq!(error.place, place, "{text}: {error}");
    }
    assert!(evaluate("x + 1", Kind::Truth).expect_err("a number").message.contains("a condition such as"));
}

#[test]
fn depth_and_length_have_bounds() {
    for text in ["(".repeat(300), "-".repeat(9000), format!("{}1", "2^".repeat(3000)), "not ".repeat(2000)] {
        assert!(evaluate(&text, Kind::Number).expect_err("too deep").message.contains("within one another"));
    }
    assert!(evaluate(&"1+".repeat(6000), Kind::Number).expect_err("too long").message.contains("longer than"));
    assert_eq!(evaluate(&format!("1{}", "+1".repeat(4000)), Kind::Number), Ok(4001.0), "long sums are not deep");
}
