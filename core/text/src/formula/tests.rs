//! Examples of the language: values, and errors with their positions.

use super::{FormulaError, Kind, Measure, parse, parse_measured};

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
        ("sqrt(1, 2)", 0..4, "takes 1 argument, not 2"),
        ("x = 2", 2..3, "write `==`"),
        ("2mmm", 1..4, "unknown unit `mmm`"),
        ("x $ 2", 2..3, "is not allowed in a formula"),
        ("`abc", 0..4, "not closed"),
        ("``", 0..2, "name is missing"),
        ("1e999", 0..5, "finite"),
        ("x >", 3..3, "ends too early"),
        ("foo(2)", 0..3, "no function `foo`"),
        ("max_load", 0..8, "did you mean `max_load_N`?"),
        ("x > 1", 0..5, "a number is expected"),
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
fn units_are_those_of_files() {
    let second = ["s", "m", "h", "x"];
    let known = |name: &str| second.iter().position(|known| *known == name);
    let value = |text: &str| {
        let program = parse(text, Kind::Number, &known, &|_| None)?;
        Ok::<f64, FormulaError>(program.value(|variable| [4.0, 2.0, 5.0, 3.0][variable], &mut Vec::new()))
    };
    // products written with blanks, and units that begin with 1
    for (text, found) in [
        ("2 N m", 2.0),
        ("6e5 kN t", 6e11),
        ("2 1/min", 2.0 / 60.0),
        ("3 N mm^2*x", 9e-6),
        ("2 kg/(mm t)*x", 6.0),
        ("2 N kg/(x + 1)", 0.5),
        ("2 s", 2.0),
        ("8 mm / s", 2e-3),
        ("2 km * h", 1e4),
        ("x*2 N m", 6.0),
    ] {
        assert_eq!(value(text), Ok(found), "{text}");
    }
    // the name is both a unit and a variable
    for (text, place, name) in
        [("1 mm/s", 5..6, "s"), ("2 m*h", 4..5, "h"), ("x + 2 N/(m s)", 9..10, "m"), ("3 N/m^2", 4..5, "m")]
    {
        let error = value(text).expect_err(text);
        assert!(error.message.starts_with(&format!("`{name}` is a unit here and a variable")), "{text}: {error}");
        assert_eq!(error.place, place, "{text}");
    }
    // no unit begins with this 1, and a word without an operator is not a factor
    for (text, place, said) in [
        ("2 1/x", 2..3, "`1` is not expected here: an operator is missing"),
        ("2 N x", 4..5, "`x` is not expected here: an operator is missing"),
        ("x 2.50", 2..6, "`2.50` is not expected here"),
        ("2 N / kg", 6..8, "a unit follows a number"),
        ("2 K", 2..3, "unknown unit `K`"),
        ("x**2", 1..3, "write `^`"),
        ("pow(x, 2)", 0..3, "did you mean `a^b`?"),
        ("ceil(x)", 0..4, "did you mean `-floor(-x)`?"),
        ("sqr(x)", 0..3, "atan2, hypot, floor, min, max; did you mean `sqrt`?"),
    ] {
        let error = value(text).expect_err(text);
        assert!(error.message.contains(said), "{text}: {error}");
        assert_eq!(error.place, place, "{text}: {error}");
    }
    assert_eq!(value("2 K").expect_err("no kelvin").message, "unknown unit `K`");
}

#[test]
fn depth_and_length_have_bounds() {
    for text in ["(".repeat(300), "-".repeat(9000), format!("{}1", "2^".repeat(3000)), "not ".repeat(2000)] {
        assert!(evaluate(&text, Kind::Number).expect_err("too deep").message.contains("nested brackets"));
    }
    assert!(evaluate(&"1+".repeat(6000), Kind::Number).expect_err("too long").message.contains("longer than"));
    assert_eq!(evaluate(&format!("1{}", "+1".repeat(4000)), Kind::Number), Ok(4001.0), "long sums are not deep");
}

/// Dimension of a formula of a load in N, a gap in m, a speed in rad/s, an angle in rad, a friction coefficient and a variable x without a unit.
fn measured(text: &str, kind: Kind) -> Result<Option<Measure>, String> {
    let names = ["load", "gap", "speed", "angle", "mu", "x"];
    let units = ["N", "m", "rad/s", "rad", "", "?"];
    let known = |name: &str| names.iter().position(|known| *known == name);
    parse_measured(text, kind, &known, &|_| None, &|number| Measure::of_unit(units[number]))
        .map(|(_, measure)| measure)
        .map_err(|error| format!("{}: {}", &text[error.place], error.message))
}

#[test]
fn dimensions_that_differ_are_not_compared_or_added() {
    for (text, told) in [
        ("load > 1 kg", "1 kg: the unit `kg` does not fit: `load` is in N; did you mean `kN`?"),
        ("2 lb < load", "2 lb: the unit `lb` does not fit: `load` is in N; did you mean `lbf`?"),
        ("load > 1 rpm", "1 rpm: the unit `rpm` does not fit: `load` is in N"),
        ("1 mm + 1 kg > x", "+: a sum of two dimensions: `1 mm` is in mm, and `1 kg` is in kg"),
        // a sum with an operand that fits any dimension has the known dimension
        ("x + 1 mm > x - 1 kg", ">: a comparison of two dimensions: `x + 1 mm` is in mm, and `x - 1 kg` is in kg"),
        ("gap - speed > 0", "-: a difference of two dimensions: `gap` is in m, and `speed` is in rad/s"),
        ("x > 0 and gap == mu", "==: a comparison of two dimensions: `gap` is in m, and `mu` is a pure number"),
        ("load*gap <= 3 N", "3 N: the unit `N` does not fit: `load*gap` is in N m"),
        ("2 s > (gap + 1 mm)*gap", "2 s: the unit `s` does not fit: `(gap + 1 mm)*gap` is in m^2"),
        ("gap^2 < 1 mm", "1 mm: the unit `mm` does not fit: `gap^2` is in m^2"),
        ("sqrt(gap*gap) < 1 kg", "1 kg: the unit `kg` does not fit: `sqrt(gap*gap)` is in m; did you mean `km`?"),
        ("min(x, gap, load) > 0", "min(x, gap, load): `min` of two dimensions: `gap` is in m, and `load` is in N"),
        ("max(1 mm, 1 s) > x", "max(1 mm, 1 s): `max` of two dimensions: `1 mm` is in mm, and `1 s` is in s"),
        ("hypot(gap, load) > x", "hypot(gap, load): `hypot` of two dimensions: `gap` is in m, and `load` is in N"),
        ("atan2(gap, load) > x", "atan2(gap, load): `atan2` of two dimensions: `gap` is in m, and `load` is in N"),
        ("-abs(load) != -(5 %)", "!=: a comparison of two dimensions: `-abs(load)` is in N, and `-(5 %)` is in %"),
        ("mu/gap > 1 m", "1 m: the unit `m` does not fit: `mu/gap` is in 1/m"),
        ("load/(gap*speed) > 1 N", "1 N: the unit `N` does not fit: `load/(gap*speed)` is in kg/s"),
        ("gap^(1/3) > gap", ">: a comparison of two dimensions: `gap^(1/3)` is in m^0.3333, and `gap` is in m"),
        // as in files
        ("speed > 5 s^-1", "5 s^-1: the unit `s^-1` does not fit: `speed` is in rad/s"),
        ("mu < 5 deg", "5 deg: the unit `deg` does not fit: `mu` is a pure number"),
        ("sin(gap) > x", "gap: `gap` is in m, and an angle has no dimension"),
        ("gap*sin(angle) > 1 kg", "1 kg: the unit `kg` does not fit: `gap*sin(angle)` is in m; did you mean `km`?"),
        ("x > asin(gap*mu)", "gap*mu: `gap*mu` is in m, and the ratio of two lengths has no dimension"),
        ("exp(load/(2 N)) > exp(load)", "load: `load` is in N, and an exponent has no dimension"),
        ("2^(gap + 1) > x", "(gap + 1): `(gap + 1)` is in m, and an exponent has no dimension"),
    ] {
        assert_eq!(measured(text, Kind::Truth).err().unwrap_or_default(), told, "{text}");
    }
}

#[test]
fn what_fits_is_left_alone() {
    for text in [
        "load > 1.2 MN and gap < 8 mm and speed > 1500 rpm and mu < 20 %",
        "load > 5",
        "1/gap > 1 m",
        "2*load > 1 kg",
        "load*gap > 1 kN*m",
        "load/gap < 2e6 N/m",
        "(gap^3)^(1/3) < 1 mm and gap^-1 > 2 m^-1 and gap^(3 - 1) > 1 m^2 and sqrt(gap^3)*sqrt(gap) > 1 m^2",
        "gap^x > 1 kg",
        "gap*speed > 1 m/s",
        "speed/(2*pi) > 5 s^-1",
        "angle > 30 deg and angle > atan2(gap, 1 m) and angle/(360 deg) < 50 %",
        "angle - 360 deg*floor(angle/(360 deg)) < asin(gap/(3 mm))",
        "load*gap/angle > 1 N*m/rad and sin(angle + pi/2) < mu",
        "log10(load) > 3 and ln(gap) < x",
        "gap^1000^1000^1000 > load",
        "gap*30 deg > 1 mm",
        "exp(ln(load) + x) > 1 kg",
        "atan2(gap, 1 mm) > 30 deg",
        "min(gap, 1 mm, 0) >= floor(gap)",
        "not (load == load)",
    ] {
        assert_eq!(measured(text, Kind::Truth), Ok(None), "{text}");
    }
    let gives = |text: &str| measured(text, Kind::Number).expect(text).map(|measure| measure.shown());
    for (text, shown) in [
        ("gap - 1", Some("in m")),
        ("x*gap", None),
        ("load*gap", Some("in N m")),
        ("load*speed*gap", Some("in kg m^2/s^3")),
        ("gap/gap", Some("a pure number")),
        ("mu", Some("a pure number")),
        ("abs(speed)", Some("in rad/s")),
        ("pi", None),
    ] {
        assert_eq!(gives(text), shown.map(str::to_owned), "{text}");
    }
}
