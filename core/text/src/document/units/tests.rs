//! Accepted and rejected spellings.

use std::f64::consts::PI;

use proptest::prelude::*;

use super::*;

#[test]
fn spellings_give_exact_si_values() {
    let table: &[(&str, &'static str, f64)] = &[
        ("8 mm", "m", 0.008),
        ("8mm", "m", 0.008),
        ("353 mm", "m", 0.353),
        ("0.36 mm", "m", 0.00036),
        ("7 um", "m", 7e-6),
        ("7 µm", "m", 7e-6),
        ("12 cm", "m", 0.12),
        ("1 in", "m", 0.0254),
        ("20 mil", "m", 0.000_508),
        ("1 ft", "m", 0.3048),
        ("2 lb", "kg", 0.907_184_74),
        ("2 lbm", "kg", 0.907_184_74),
        ("1 lbf", "N", 4.448_221_615_260_5),
        ("1 psi", "Pa", 4.448_221_615_260_5 / 6.4516e-4),
        ("30 Mpsi", "Pa", 30e6 * 4.448_221_615_260_5 / 6.4516e-4),
        ("30 ksi", "Pa", 30e3 * 4.448_221_615_260_5 / 6.4516e-4),
        ("1000 lbf/in", "N/m", 4_448.221_615_260_5 / 0.0254),
        ("5 lbf s/in", "N s/m", 5.0 * 4.448_221_615_260_5 / 0.0254),
        ("0.284 lb/in3", "kg/m3", 0.284 * 0.453_592_37 / (0.0254 * 0.0254 * 0.0254)),
        ("3 lb in2", "kg m2", 3.0 * 0.453_592_37 * 0.0254 * 0.0254),
        ("12 lbf in", "N m", 12.0 * 4.448_221_615_260_5 * 0.0254),
        ("600 N-s/m", "N s/m", 600.0),
        ("3.426 lbf-s/in", "N s/m", 3.426 * 4.448_221_615_260_5 / 0.0254),
        ("2 lbf-s**2/in", "kg", 2.0 * 4.448_221_615_260_5 / 0.0254),
        ("3 lbm-in2", "kg m2", 3.0 * 0.453_592_37 * 0.0254 * 0.0254),
        ("6.5e-4 kg-m2", "kg m2", 6.5e-4),
        ("6.5e-4 m2-kg", "kg m2", 6.5e-4),
        ("0.1 N-m", "N m", 0.1),
        ("0.1 N-m-s", "N m s", 0.1),
        ("6e8 kg-s-2", "N/m", 6e8),
        ("8 m**2/m", "m", 8.0),
        ("7.85 g/cc", "kg/m3", 7850.0),
        ("7.85 kg/dm3", "kg/m3", 7850.0),
        ("16 oz", "kg", 0.453_592_37),
        ("1 slug", "kg", 4.448_221_615_260_5 / 0.3048),
        ("2 kgf", "N", 19.6133),
        ("3 krpm", "rad/s", 100.0 * PI),
        ("-2.5e-1 mm", "m", -2.5e-4),
        ("1e3mm", "m", 1.0),
        ("1500 rpm", "rad/s", 50.0 * PI),
        ("1500rpm", "rad/s", 50.0 * PI),
        ("25 rev/s", "rad/s", 50.0 * PI),
        ("157 rad/s", "rad/s", 157.0),
        ("60 rpm/s", "rad/s2", 2.0 * PI),
        ("-3 rad/s2", "rad/s2", -3.0),
        ("180 deg", "rad", PI),
        ("180°", "rad", PI),
        ("0.5 rad", "rad", 0.5),
        ("210 GPa", "Pa", 210e9),
        ("210000 N/mm2", "Pa", 210e9),
        ("7850 kg/m3", "kg/m3", 7850.0),
        ("7850 kg/m^3", "kg/m3", 7850.0),
        ("7.85 g/cm³", "kg/m3", 7850.0),
        ("6.5e-4 kg m2", "kg m2", 6.5e-4),
        ("6.5e-4 kg*m2", "kg m2", 6.5e-4),
        ("6.5e-4 kg·m²", "kg m2", 6.5e-4),
        ("6.5e-4 kg m^2", "kg m2", 6.5e-4),
        ("600 N s/m", "N s/m", 600.0),
        ("600 Ns/m", "N s/m", 600.0),
        ("600 N/(m/s)", "N s/m", f64::NAN),
        ("0.6 N s/mm", "N s/m", 600.0),
        ("600 kg/s", "N s/m", 600.0),
        ("1 N/mm", "N/m", 1000.0),
        ("600 kN/mm", "N/m", 6e8),
        ("6e8 kg s^-2", "N/m", 6e8),
        ("6e8 kg s⁻²", "N/m", 6e8),
        ("30 N m s", "N m s", 30.0),
        ("30 Nm s", "N m s", 30.0),
        ("30 N m s/rad", "N m s", 30.0),
        ("30 N m/(rad/s)", "N m s", f64::NAN),
        ("0.66 N m s2", "N m s2", 0.66),
        ("2 kNm", "N m", 2000.0),
        ("20 1/s", "1/s", 20.0),
        ("20 s^-1", "1/s", 20.0),
        ("20 s-1", "1/s", 20.0),
        ("20/s", "1/s", 20.0),
        ("2e-5 s", "s", 2e-5),
        ("2 ms", "s", 0.002),
        ("20 us", "s", 2e-5),
        ("2 min", "s", 120.0),
        ("10 g", "kg", 0.01),
        ("17 t", "kg", 17_000.0),
        ("9.81 m/s2", "m/s2", 9.81),
        ("9.81 m/s/s", "m/s2", 9.81),
        ("5 mm/s", "m/s", 0.005),
        ("0.1 %", "", 0.001),
        ("0.2", "", 0.2),
        ("+.5", "", 0.5),
        ("0 mm", "m", 0.0),
    ];
    for &(text, si, value) in table {
        match parse_quantity(text, si) {
            // Inch and pound involve a product and may be rounded twice; all others must give the nearest double exactly.
            Ok(found) if ["lb", "si", "slug"].iter().any(|unit| text.contains(unit)) => {
                assert!((found / value - 1.0).abs() < 4.0 * f64::EPSILON, "{text}: {found}");
            }
            Ok(found) => assert_eq!(found, value, "{text}"),
            // Nested division is ambiguous, so it is rejected.
            Err(error) => {
                assert!(value.is_nan() && matches!(error, QuantityError::Malformed { .. }), "{text}: {error}")
            }
        }
    }
}

#[test]
fn wrong_quantities_are_refused_with_their_reason() {
    let table: &[(&str, &'static str, &str)] = &[
        ("8 kg", "m", "m is expected, such as \"8 mm\""),
        ("0.5 deg", "m", "does not fit"),
        ("0.5 deg", "", "a pure number such as 0.2 or \"20 %\" is expected"),
        ("5 1/s", "rad/s", "such as \"1500 rpm\""),
        ("1500 rpm", "1/s", "does not fit"),
        ("50 Hz", "rad/s", "revolutions per second"),
        ("5 mm deg", "m", "does not fit"),
        ("8", "m", "no unit"),
        ("", "m", "does not start with a number"),
        ("mm", "m", "does not start with a number"),
        ("8 mmm", "m", "unknown unit `mmm`"),
        ("210 gpa", "Pa", "unknown unit `gpa`"),
        ("1,5 mm", "m", "comma"),
        ("1.5.2 mm", "m", "cannot be read"),
        ("1e999 m", "m", "finite"),
        ("1e-999 m", "m", "finite"),
        ("1e99999999999999999999 m", "m", "finite"),
        ("nan m", "m", "finite"),
        ("-inf", "", "finite"),
        ("8 m^", "m", "exponent"),
        ("8 m^0", "m", "exponent"),
        ("8 m99999999999", "m", "exponent"),
        ("8 m/", "m", "ends too early"),
        ("8 /m/", "1/s", "ends too early"),
        ("8 N/m s", "N s/m", "before the division sign"),
        ("8 N/(m", "N/m", "ends too early"),
        ("8 *m", "m", "product sign"),
        ("8 m**2", "m", "does not fit"),
        ("8 m**", "m", "exponent"),
        ("8 m**0", "m", "exponent"),
        ("8 m***2", "m", "exponent"),
        ("8 -m", "m", "symbol is expected"),
        ("8 N-", "N", "symbol is expected"),
        ("8 N--m", "N m", "symbol is expected"),
        ("8 N/-m", "N/m", "symbol is expected"),
        ("5 lb-s/in", "N s/m", "did you mean `lbf-s/in`?"),
        ("8 m//s", "m/s", "division sign"),
        ("8 mm 5", "m", "symbol is expected"),
        ("8 h9 h9 h9 h9 h9 h9 h9 h9 h9", "s", "out of range"),
        ("2 lbf", "N/m", "does not fit"),
        ("2 lb/in", "N/m", "does not fit"),
        ("2 kip", "N", "unknown unit"),
        ("10 Tm", "m", "unknown unit"),
    ];
    for &(text, si, part) in table {
        let error = parse_quantity(text, si).expect_err(text);
        assert!(error.to_string().contains(part), "{text}: {error}");
    }
    let nearest = |text, si| match parse_quantity(text, si) {
        Err(QuantityError::UnknownUnit { nearest, .. }) => nearest,
        other => panic!("{other:?}"),
    };
    assert_eq!(nearest("210 gpa", "Pa").as_deref(), Some("GPa"));
    assert_eq!(nearest("1500 RPM", "rad/s").as_deref(), Some("rpm"));
    assert_eq!(nearest("600 n s/m", "N s/m").as_deref(), Some("N"));
    // Not "mN", which is not a length.
    assert_eq!(nearest("8 mn", "m").as_deref(), Some("mm"));
    assert_eq!(nearest("8 furlong", "m"), None);
}

#[test]
fn a_unit_as_people_write_it_is_told_as_it_is_written_here() {
    let table = [
        ("3 inch", "m", "in"),
        ("3 inches", "m", "in"),
        ("5 mils", "m", "mil"),
        ("3 millimeters", "m", "mm"),
        ("3 micron", "m", "um"),
        ("3 metres", "m", "m"),
        ("1 KG", "kg", "kg"),
        ("1 kilogram", "kg", "kg"),
        ("1 lbs", "kg", "lb"),
        ("1 lbs", "N", "lbf"),
        ("1 lbs/in", "N/m", "lbf"),
        ("1 lb/in", "N/m", "lbf/in"),
        ("5 NM", "N m", "Nm"),
        ("5 newton m", "N m", "N"),
        ("2 usec", "s", "us"),
        ("2 milliseconds", "s", "ms"),
        ("2 minutes", "s", "min"),
        ("1500 RPM", "rad/s", "rpm"),
        ("1500 U/min", "rad/s", "rev"),
        ("1500 r/min", "rad/s", "rev"),
        ("50 rps", "rad/s", "rev/s"),
        ("30 degrees", "rad", "deg"),
        ("210 gigapascal", "Pa", "GPa"),
    ];
    for (text, si, meant) in table {
        let error = parse_quantity(text, si).expect_err(text);
        let (message, nearest) = error.clone().parts();
        assert_eq!(nearest.as_deref(), Some(meant), "{text}");
        assert_eq!(error.to_string(), format!("{message}; did you mean `{meant}`?"));
        // The suggestion must be accepted.
        let unit = text.split_once(' ').expect("a unit").1;
        let wrong = message.split('`').nth(1).expect("quoted");
        assert!(parse_quantity(&format!("3 {}", unit.replacen(wrong, meant, 1)), si).is_ok(), "{text}");
    }
    // No suggestion of a unit of another size.
    for (text, si) in
        [("3 Mrpm", "rad/s"), ("3 kdeg", "rad"), ("3 Mbar", "Pa"), ("3 klbf", "N"), ("3 cN", "N"), ("3 ks", "s")]
    {
        assert_eq!(parse_quantity(text, si).expect_err(text).parts().1, None, "{text}");
    }
    // No suggestion of a unit of another dimension.
    for (text, si) in [("3 inch", "kg"), ("2 lb", "m"), ("2 slug/in", "N/m"), ("1500 U", "rad/s")] {
        assert_eq!(parse_quantity(text, si).expect_err(text).parts().1, None, "{text}");
    }
    let told = |text, si| parse_quantity(text, si).expect_err(text).to_string();
    assert!(told("5 N.m", "N m").ends_with("write a space: N m"));
    assert!(told("3\"", "m").ends_with("inches are written `in`"));
}

/// Every unit that the message suggests is accepted in the same place.
#[test]
fn what_is_advised_instead_of_hertz_is_accepted() {
    for (text, si, advised) in [
        ("50 Hz", "rad/s", &["rpm", "rad/s", "rev/s"][..]),
        ("0.05 kHz", "rad/s", &["rpm", "rad/s", "rev/s"]),
        ("50 hz", "1/s", &["1/s"]),
        ("50 Hz/s", "rad/s2", &["rpm/s", "rad/s2"]),
    ] {
        let Err(QuantityError::Hertz { instead, .. }) = parse_quantity(text, si) else { panic!("{text}") };
        assert_eq!(instead, advised, "{text}");
        for unit in instead {
            assert!(parse_quantity(&format!("50 {unit}"), si).is_ok(), "{unit} for {si}");
        }
    }
    let told = parse_quantity("50 Hz", "rad/s").expect_err("two meanings").to_string();
    assert_eq!(told, "`Hz` may mean 1/s or revolutions per second: write the value in rpm or rad/s or rev/s");
    let length = parse_quantity("50 Hz", "m").expect_err("no length");
    assert!(length.to_string().contains("m is expected, such as \"8 mm\""), "{length}");
    let any = parse_any_quantity("50 Hz").expect_err("two meanings").to_string();
    assert!(any.ends_with("rpm or rad/s or rev/s or 1/s"), "{any}");
}

#[test]
fn a_bare_number_is_si_where_there_are_no_quotes() {
    assert_eq!(parse_bare_or_quantity("0.008", "m"), Ok(0.008));
    assert_eq!(parse_bare_or_quantity("8 mm", "m"), Ok(0.008));
    assert!(parse_bare_or_quantity("8 kg", "m").is_err());
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused(text in "[-+0-9.eE a-zµ°%²³⁻*·/^()1Nm]{0,24}", other in ".{0,12}") {
        for si in ["m", "rad/s", "", "N s/m"] {
            for given in [&text, &other] {
                if let Ok(value) = parse_quantity(given, si) {
                    prop_assert!(value.is_finite());
                }
            }
        }
    }

    #[test]
    fn millimetres_are_the_nearest_double(tenths in 0u32..1_000_000) {
        let text = format!("{}.{} mm", tenths / 10, tenths % 10);
        let metres: f64 = format!("{}e-4", tenths).parse().unwrap();
        prop_assert_eq!(parse_quantity(&text, "m"), Ok(metres));
    }
}
