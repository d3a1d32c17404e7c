//! Formulas of study files know the units of columns and parameters: a difference in dimension is an error at its place in the file.

use crate::support::{Folder, say};

const STUDY: &str = r#"schema = 1
machine = "machines/rig.toml"

[set]
"run.end_time" = "2 ms"

[[uncertain]]
path = "contact.friction"
as = "mu"
distribution = "uniform"
lower = 0.05
upper = 0.25

[[uncertain]]
name = "growth"
distribution = "uniform"
lower = "0.1 mm"
upper = "0.2 mm"

[[derived]]
path = "contact.gap"
formula = "0.7 mm - growth"

[design]
kind = "monte-carlo"
samples = 2
"#;

#[test]
fn a_load_is_not_compared_with_a_mass() {
    let folder = Folder::new();
    let asks = r#"
[[question]]
name = "load"
probability = "max_bearing_load_N > 1 kg"

[[question]]
name = "parameters"
fragility = "mu"
probability = "mu < 0.2 and contact.gap > 1 N"

[[gate]]
require = "P(1 mm + 1 kg > max_bearing_load_N) < 0.5"
"#
    .replace("contact.gap", "`contact.gap`");
    let told = say(&["check", &folder.write("s.toml", &format!("{STUDY}{asks}"))]);
    assert_eq!(told.code, 3, "{}", told.err);
    for part in [
        "s.toml:30:37: question[0].probability = 1 kg: the unit `kg` does not fit: `max_bearing_load_N` is in N; did you mean `kN`?",
        "s.toml:35:45: question[1].probability = 1 N: the unit `N` does not fit: `contact.gap` is in m",
        "s.toml:38:19: gate[0].require = +: a sum of two dimensions: `1 mm` is in mm, and `1 kg` is in kg",
    ] {
        assert!(told.err.contains(part), "{part}\nin\n{}", told.err);
    }
    // a formula must have the dimension of its parameter; a variable has any dimension
    for (formula, part) in [
        ("1 kg*mu", "the formula is in kg, and `diaphragms.seal.contact.gap` is in m"),
        ("1 kg", "the formula is in kg, and `diaphragms.seal.contact.gap` is in m"),
        ("1 kg + 0.7 mm - growth", "a sum of two dimensions: `1 kg` is in kg, and `0.7 mm` is in mm"),
    ] {
        let study = folder.write("s.toml", &STUDY.replace("0.7 mm - growth", formula));
        let told = say(&["check", &study]);
        assert!(told.code == 3 && told.err.contains(part), "{formula}: {}", told.err);
    }
    let sound = "\n[[question]]\nname = \"q\"\nprobability = \"max_bearing_load_N >= 0 N and growth > 0.05 mm and mu < 0.3 \
                 and end_speed_rad_s > 1 rpm\"\n";
    let ran = say(&["run", &folder.write("s.toml", &format!("{STUDY}{sound}")), "--out", &folder.name("out")]);
    assert!(ran.code == 0 && ran.out.contains(" = 100 %"), "{} {}", ran.out, ran.err);
}
