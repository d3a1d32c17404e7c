//! Every number of a machine at the ends of its allowed range: an outcome or an error, never a panic, a hang or a huge allocation.
//!
//! With `PROPTEST_CASES` set, that many combinations of ends are tried (default 60).

use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use crate::common::study_machine;
use bladeoff_core::engine::simulate;
use bladeoff_core::record::NoHistory;
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{MachineDef, ParamValue, PathInfo, PathKind};
use proptest::prelude::*;

/// Steps of each run.
const STEPS: f64 = 100.0;
/// A case longer than this counts as a hang. The largest meshes take some seconds, and machines that run tests are busy.
const HANGING: Duration = Duration::from_secs(300);

const POINT: &str = "schema = 1\nname = 'p'\n[run]\nend_time = 1\n[rotor]\nkind = \"point-mass\"\nmass = 10\npolar_inertia = 1\n\
    initial_speed = 100\n[rotor.bearings.b]\nstiffness = [[1e6, 1e4], [-1e4, 1e6]]\ndamping = 10\n[rotor.unbalances.u]\nmass = 0.001\nradius = 0.01\n\
    [rotor.speed_law]\nacceleration = -10\n[diaphragms.d]\nkind = \"radial-spring\"\nstiffness = 1e8\n[diaphragms.d.contact]\n\
    rotor_radius = 0.1\ngap = 1e-5\nfriction = 0.1\n";

/// Aborts the program if the work does not end.
fn watched<T: Send>(what: &str, work: impl FnOnce() -> T + Send) -> T {
    let (done, hangs) = mpsc::channel::<()>();
    let what = what.to_owned();
    thread::spawn(move || {
        if hangs.recv_timeout(HANGING) == Err(mpsc::RecvTimeoutError::Timeout) {
            // written to stderr directly, because the test's captured output is lost on abort
            let _ = writeln!(std::io::stderr(), "{what}: not at its end after {HANGING:?}");
            std::process::abort();
        }
    });
    let result = work();
    drop(done);
    result
}

/// Description of the outcome of a machine with these values; `Err`: the panic.
fn end(def: &MachineDef, values: &[(PathInfo, f64)]) -> Result<String, String> {
    let shown: Vec<String> = values.iter().map(|(info, value)| format!("{} = {value:e}", info.path)).collect();
    let shown = shown.join(", ");
    watched(&shown, || {
        let work = || {
            let mut def = def.clone();
            for (info, value) in values {
                def.set(info, &ParamValue::Number(*value)).unwrap_or_else(|error| panic!("an end is allowed: {error}"));
            }
            let limit = def.resolve("run.step_limit").expect("every machine has one");
            def.set(&limit, &ParamValue::Number(STEPS)).expect("a count");
            let machine = match def.build() {
                Ok(machine) => machine,
                Err(problems) => return format!("refused: {}", problems.list[0].message),
            };
            let structure = match Structure::build(&machine, None) {
                Ok(structure) => structure,
                Err(error) => return format!("no structure: {error}"),
            };
            match simulate(&machine, &structure, &mut NoHistory) {
                Err(error) => format!("no start: {error}"),
                Ok(outcome) => {
                    assert!(outcome.values.iter().flatten().all(|value| value.is_finite()), "null, never NaN");
                    outcome.cause.map_or("ok", |cause| cause.word()).to_owned()
                }
            }
        };
        catch_unwind(AssertUnwindSafe(work)).map_err(|panic| {
            let said = panic.downcast_ref::<String>().cloned();
            let said = said.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
            format!("{shown}: {}", said.unwrap_or_default())
        })
    })
}

/// Every number of a machine except for its step limit, with its smallest and largest allowed value.
fn numbers(def: &MachineDef) -> Vec<(PathInfo, [f64; 2])> {
    let is_number = |info: &PathInfo| !matches!(info.kind, PathKind::Choice(_)) && info.path != "run.step_limit";
    // An open end is approached by a relative 1e-12.
    let ends = |info: &PathInfo| {
        let [low, high] = info.range.ends();
        [low, high].map(|end| if info.range.contains(end) { end } else { end * (1.0 - 1e-12) })
    };
    def.paths().into_iter().filter(is_number).map(|info| (info.clone(), ends(&info))).collect()
}

fn machines() -> Vec<MachineDef> {
    let rig = study_machine("lab_rig");
    let touching = rig.replace("gap = \"0.5 mm\"", "gap = \"1 um\"");
    assert_ne!(rig, touching);
    let with = |engine: &str| touching.replacen("[run]", &format!("[run]\nengine = \"{engine}\""), 1);
    let point = POINT.replacen("[run]", "[run]\nengine = \"reduced\"", 1);
    assert_ne!(point, POINT);
    [&with("reduced"), &with("full"), &point, &with("exponential")]
        .iter()
        .map(|text| MachineDef::parse("m.toml", text).unwrap_or_else(|problems| panic!("{problems}")))
        .collect()
}

#[test]
fn extremes_end_with_a_word() {
    let mut panics = Vec::new();
    let mut words = std::collections::BTreeMap::<String, usize>::new();
    for (at, def) in machines().into_iter().enumerate() {
        assert_eq!(end(&def, &[]).as_deref(), Ok("step_limit"), "the machine itself runs");
        let all = numbers(&def);
        assert!(all.len() > 20, "{}", all.len());
        for (info, ends) in all {
            for value in ends {
                // The finest meshes take seconds: one engine is enough for them.
                if at > 0 && info.kind == PathKind::Count && value > 100.0 {
                    continue;
                }
                assert!(info.range.contains(value), "{} = {value}", info.path);
                match end(&def, &[(info.clone(), value)]) {
                    Ok(word) => *words.entry(word.split(':').next().unwrap_or_default().to_owned()).or_default() += 1,
                    Err(panic) => panics.push(panic),
                }
            }
        }
    }
    println!("{words:?}");
    assert!(panics.is_empty(), "{}", panics.join("\n"));
    // The test must have covered both: values that are rejected, and values that run.
    assert!(words.contains_key("refused") && words.contains_key("step_limit"), "{words:?}");
}

#[test]
fn what_lies_beyond_the_ends_is_refused_with_the_ends() {
    for def in machines() {
        for (info, _) in numbers(&def) {
            for text in ["1e300", "1e-300", "-1e300"] {
                let value: f64 = text.parse().expect("a number");
                let found = def.parse_value(&info, text);
                assert_eq!(
                    found.is_ok(),
                    info.range.contains(value) && info.kind != PathKind::Count,
                    "{} = {text}",
                    info.path
                );
                if let Err(error) = found {
                    assert!(error.to_string().contains("allowed: "), "{error}");
                }
            }
            let [low, high] = info.range.ends();
            assert!(low.is_finite() && high.is_finite() && low < high, "{}", info.path);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: std::env::var("PROPTEST_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(60),
        failure_persistence: None,
        max_shrink_iters: 20,
        ..ProptestConfig::default()
    })]

    #[test]
    fn extremes_together_end_with_a_word(
        machine in 0..3_usize,
        chosen in prop::collection::vec((any::<prop::sample::Index>(), 0..2_usize), 2..6),
    ) {
        let def = &machines()[machine];
        // The largest meshes take seconds each, and the test above covers one of them.
        let all: Vec<_> = numbers(def).into_iter().filter(|(info, _)| info.kind != PathKind::Count).collect();
        let values: Vec<(PathInfo, f64)> = chosen
            .iter()
            .map(|(at, end)| { let (info, ends) = at.get(&all); (info.clone(), ends[*end]) })
            .collect();
        let found = end(def, &values);
        prop_assert!(found.is_ok(), "{:?}", found);
    }
}
