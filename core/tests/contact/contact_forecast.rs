//! The forecast of contact against complete runs of the shipped machines.

use bladeoff_core::engine::simulate;
use bladeoff_core::modal::contact_forecasts;
use bladeoff_core::record::{NoHistory, columns};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Machine, MachineDef};

const LAB: &str = include_str!("../../../studies/machines/lab_rig.toml");
const TURBINE: &str = include_str!("../../../studies/machines/lp_turbine_paper.toml");

fn machine(text: &str, sets: &[(&str, &str)]) -> Machine {
    let mut def = MachineDef::parse("machine.toml", text).unwrap_or_else(|e| panic!("{e}"));
    for (path, value) in sets {
        let info = def.resolve(path).unwrap_or_else(|e| panic!("{e}"));
        let value = def.parse_value(&info, value).unwrap_or_else(|e| panic!("{e}"));
        def.set(&info, &value).unwrap_or_else(|e| panic!("{e}"));
    }
    def.build().unwrap_or_else(|e| panic!("{e}"))
}

/// Largest eccentricity and first contact of a run.
fn run(machine: &Machine) -> (f64, Option<f64>) {
    let structure = Structure::build(machine, None).unwrap_or_else(|e| panic!("{e}"));
    let outcome = simulate(machine, &structure, &mut NoHistory).unwrap_or_else(|e| panic!("{e}"));
    let value = |name: &str| columns(machine).iter().position(|one| one.name == name).and_then(|at| outcome.values[at]);
    (value("max_eccentricity_m").expect("of the one diaphragm"), value("first_contact_s"))
}

/// A case: name, text of the machine, and changed values.
const CASES: [(&str, &str, &[(&str, &str)]); 6] = [
    ("lp_turbine_paper", TURBINE, &[("run.end_time", "1 s")]),
    ("lp_turbine_paper, gravity", TURBINE, &[("run.end_time", "1 s"), ("rotor.gravity[1]", "-9.81")]),
    ("lp_turbine_paper, 1200 rpm", TURBINE, &[("run.end_time", "1 s"), ("rotor.initial_speed", "1200 rpm")]),
    ("lab_rig", LAB, &[("run.end_time", "0.6 s")]),
    ("lab_rig, gravity", LAB, &[("run.end_time", "0.6 s"), ("rotor.gravity[1]", "-9.81")]),
    ("lab_rig, 1500 rpm", LAB, &[("run.end_time", "0.6 s"), ("rotor.initial_speed", "1500 rpm")]),
];

/// With a gap that never closes, a run reaches the forecast: at least the transient of the release, at most the larger of that value and the
/// steady response. A gap 5 % below the forecast of the release leads to contact, a gap 5 % above the larger value does not.
#[test]
fn runs_of_the_shipped_machines_reach_what_is_forecast() {
    for (name, text, sets) in CASES {
        // A rigid circle, because a flexible ring would have to fit the gap.
        let kind = if name.starts_with("lab") { "diaphragms.seal.kind" } else { "diaphragms.mid.kind" };
        let with = |gap: f64| {
            let gap = format!("{gap} m");
            machine(text, &[sets, &[(kind, "rigid"), ("contact.gap", &gap)]].concat())
        };
        let open = with(0.3);
        let found = contact_forecasts(&open).remove(0);
        let (reached, contact) = run(&open);
        assert_eq!(contact, None, "{name}: the gap is wide");
        let most = found.release.max(found.at_rest + found.response);
        println!(
            "{name}: reached {reached:.4e}, release {:.4e}, steady {:.4e} at {:.1}",
            found.release, found.response, found.speed
        );
        assert!((0.98 * found.release..=1.02 * most).contains(&reached), "{name}: {reached} is not within {found:?}");
        assert!(run(&with(0.95 * found.release)).1.is_some(), "{name}: contact was forecast, {found:?}");
        assert_eq!(run(&with(1.05 * most)).1, None, "{name}: no contact was forecast, {found:?}");
    }
}
