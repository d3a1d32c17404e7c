//! Rotors on pedestals and on bearings with tables, and two diaphragms on one shaft, compared with an independent program.

use std::collections::BTreeMap;

use super::case::{Case, Check, NO_RUN};
use super::machine::{machine, stepping};
use crate::engine::simulate;
use crate::modal::{UnbalanceResponse, report, unbalance_response};
use crate::record::{NoHistory, columns};
use crate::structure::Structure;
use bladeoff_model::machine::Engine;

const ELEMENTS: &str = "independent finite elements";
const INTEGRATION: &str = "independent finite elements and Radau IIA integration";
const EXPONENTIAL: &str = "independent finite elements, matrix exponential in steps of 1 us";

pub(super) fn add(checks: &mut Vec<Check>) {
    pedestals(checks);
    tables(checks);
    two_diaphragms(checks);
}

fn pedestals(checks: &mut Vec<Check>) {
    let at_rest = on_pedestals("[rotor]\ninitial_speed = 0\n[run]\nend_time = 1\n");
    let critical = [
        [277.739_242_640_913_06, -6.411_304_163_234_179],
        [303.265_557_533_256_5, -3.331_760_922_794_566],
        [732.853_437_101_291_4, -49.222_149_848_734_08],
        [913.862_795_525_883_4, -56.821_026_781_364_99],
    ];
    criticals(checks, "skew bearings on pedestals", &at_rest, &critical);
    overdamped(checks, &at_rest);
    responses(checks, &at_rest);
    for (engine, step, tolerance) in [(Engine::Reduced, Some(2e-6), 1e-6), (Engine::Exponential, None, 1e-5)] {
        let step = step.map_or(format!("engine = \"{}\"\n", engine.word()), |step| stepping(engine, step));
        let text = on_pedestals(&format!(
            "[rotor]\ninitial_speed = 350\n[rotor.speed_law]\nacceleration = 0\n[run]\nend_time = 0.3\n{step}"
        ));
        let case =
            Case { name: "blade-off on pedestals", engine: engine.word(), unit: "N", source: EXPONENTIAL, tolerance };
        let row = row(&text);
        for (column, reference) in [
            ("max_bearing_force_x_left_N", 923.320_918_689),
            ("max_bearing_force_y_right_N", 2_081.631_651_807),
            ("max_pedestal_force_x_right_N", 1_300.789_182_765),
            ("max_pedestal_force_y_left_N", 1_944.670_978_216),
        ] {
            case.check(checks, column, value(&row, column), reference);
        }
    }
}

fn tables(checks: &mut Vec<Check>) {
    for (name, interpolation, critical) in [
        (
            "bearing table, linear",
            "linear",
            [[314.935_330_807_023_7, -8.308_138_880_993_809], [320.498_728_193_198_76, -7.011_672_315_516_616]],
        ),
        (
            "bearing table, pchip",
            "pchip",
            [[314.846_295_812_810_3, -8.264_855_559_036_76], [320.424_108_897_223_4, -7.048_803_444_264_763]],
        ),
    ] {
        criticals(checks, name, &on_table(interpolation), &critical);
        for (speed, of, disc) in TABLE_RESPONSES {
            if of == interpolation {
                let found = response(&on_table(interpolation), speed);
                let case = Case { name, engine: NO_RUN, unit: "m", source: ELEMENTS, tolerance: 1e-9 };
                case.check(
                    checks,
                    format!("orbit of the disc, {speed} rad/s"),
                    found.map(|it| it.nodes[2]),
                    major(disc),
                );
            }
        }
    }
}

/// Critical speeds of overdamped motions, and their damping ratios.
fn overdamped(checks: &mut Vec<Check>, text: &str) {
    let name = "skew bearings on pedestals";
    let case = Case { name, engine: NO_RUN, unit: "rad/s", source: ELEMENTS, tolerance: 1e-9 };
    let found = machine(text).and_then(|machine| report(&machine, &[]).ok());
    let ours = |k: usize| found.as_ref().and_then(|found| found.overdamped_critical_speeds.get(k));
    for (k, [speed, decay]) in
        [[184.378_537_377_146_84, -840.447_107_207_564], [190.560_699_890_667_22, -891.243_006_906_989_6]]
            .into_iter()
            .enumerate()
    {
        let what = format!("overdamped critical speed {}", k + 1);
        case.check(checks, what, ours(k).map(|one| one.speed), speed);
        let (damping, reference) = (Case { unit: "", ..case }, -decay / libm::hypot(decay, speed));
        damping.check(checks, format!("its damping ratio {}", k + 1), ours(k).map(|one| one.damping_ratio), reference);
    }
}

/// Complex amplitudes along X and Y, each real and imaginary part.
type Orbit = [[f64; 2]; 2];

/// Half the major axis of an elliptic orbit.
fn major([[a, b], [c, d]]: Orbit) -> f64 {
    0.5 * (libm::hypot(a - d, b + c) + libm::hypot(a + d, c - b))
}

/// Orbits on pedestals: speed \[rad/s\], middle of the shaft \[m\], left pedestal \[m\], force of the right bearing \[N\].
const PEDESTAL_RESPONSES: [(f64, [Orbit; 3]); 3] = [
    (
        100.0,
        [
            [
                [6.773_967_349_755_274e-06, -3.147_194_358_082_14e-08],
                [1.436_571_278_689_342e-07, -5.729_618_175_557_418_5e-06],
            ],
            [
                [9.688_818_631_634_887e-07, -1.699_650_556_436_808_8e-08],
                [-2.488_639_368_852_473e-09, -3.534_770_104_463_977e-07],
            ],
            [[29.229_891_126_489_164, -0.021_789_573_087_137_803], [0.099_370_598_454_724_4, -28.507_625_171_327_39]],
        ],
    ),
    (
        300.0,
        [
            [
                [-0.000_355_975_997_097_253_63, -0.000_153_128_411_494_375_4],
                [-0.001_215_479_777_650_912_4, -0.000_878_258_950_740_598_6],
            ],
            [
                [-6.007_679_295_999_575e-05, -2.385_902_238_274_260_8e-05],
                [-8.111_280_351_178_839e-05, -5.746_670_628_448_314e-05],
            ],
            [[-1_754.392_782_801_977_8, -888.036_319_065_849_3], [-6_730.867_121_101_209, -5_036.784_893_544_884]],
        ],
    ),
    (
        600.0,
        [
            [
                [-5.377_404_140_643_528_4e-05, -2.807_623_162_431_857e-06],
                [-1.108_166_046_543_99e-06, 6.122_392_686_466_201e-05],
            ],
            [
                [-1.161_238_110_709_413_9e-05, -9.620_769_725_490_488e-07],
                [2.896_966_381_156_356e-07, 5.372_437_617_176_954_5e-06],
            ],
            [[-431.749_023_978_545_4, -18.557_863_150_894_924], [-25.151_749_323_595_254, 480.562_233_943_512_2]],
        ],
    ),
];

/// Orbits of the disc on bearings with a table \[m\], between the speeds of the table: speed \[rad/s\], interpolation.
const TABLE_RESPONSES: [(f64, &str, Orbit); 6] = [
    (
        150.0,
        "linear",
        [
            [1.379_605_151_012_754e-05, -4.266_096_460_742_606_7e-07],
            [-4.318_178_942_193_344e-07, -1.441_988_229_012_563_3e-05],
        ],
    ),
    (
        320.0,
        "linear",
        [
            [-0.000_142_218_052_373_763_58, -0.000_741_961_355_811_332_6],
            [-0.000_787_083_586_285_329_7, 0.000_768_433_469_339_545_5],
        ],
    ),
    (
        600.0,
        "linear",
        [
            [-6.604_111_153_122_71e-05, -2.680_312_907_406_582e-06],
            [-1.679_602_317_682_466_3e-06, 6.499_398_179_441_4e-05],
        ],
    ),
    (
        150.0,
        "pchip",
        [
            [1.383_973_819_212_456e-05, -4.039_718_346_554_379e-07],
            [-3.755_037_564_469_805_7e-07, -1.445_053_713_988_015_9e-05],
        ],
    ),
    (
        320.0,
        "pchip",
        [
            [-0.000_153_337_382_493_377_82, -0.000_735_152_328_875_056_3],
            [-0.000_777_203_598_504_503_8, 0.000_779_666_985_118_132_9],
        ],
    ),
    (
        600.0,
        "pchip",
        [
            [-6.588_189_056_935_356e-05, -2.740_628_129_658_772e-06],
            [-1.617_984_890_913_862_2e-06, 6.485_485_436_162_1e-05],
        ],
    ),
];

/// Response to unbalance at a speed \[rad/s\]. The reference has the unbalance in its mass matrix, the response has not: its mass is added to the disc.
fn response(text: &str, speed: f64) -> Option<UnbalanceResponse> {
    let text = text.replace("mass = 80\n", "mass = 80.05\n");
    Some(unbalance_response(&machine(&text)?, &[speed]).remove(0))
}

fn responses(checks: &mut Vec<Check>, text: &str) {
    let name = "unbalance on pedestals";
    let case = Case { name, engine: NO_RUN, unit: "m", source: ELEMENTS, tolerance: 1e-9 };
    for (speed, [node, pedestal, bearing]) in PEDESTAL_RESPONSES {
        let found = response(text, speed);
        let ours = |of: fn(&UnbalanceResponse) -> f64| found.as_ref().map(of);
        case.check(checks, format!("orbit of the disc, {speed} rad/s"), ours(|it| it.nodes[2]), major(node));
        let force = Case { unit: "N", ..case };
        force.check(checks, format!("right bearing, {speed} rad/s"), ours(|it| it.bearings[1]), major(bearing));
        // force of the pedestal: K x + i W C x
        let load = |[re, im]: [f64; 2], k: f64, c: f64| [k * re - speed * c * im, k * im + speed * c * re];
        let load = major([load(pedestal[0], 3e7, 5e3), load(pedestal[1], 8e7, 8e3)]);
        force.check(checks, format!("left pedestal, {speed} rad/s"), ours(|it| it.pedestals[0]), load);
    }
}

/// Damped critical speeds, and the real parts of their eigenvalues.
fn criticals(checks: &mut Vec<Check>, name: &'static str, text: &str, critical: &[[f64; 2]]) {
    let case = Case { name, engine: NO_RUN, unit: "rad/s", source: ELEMENTS, tolerance: 1e-9 };
    let found = machine(text).and_then(|machine| report(&machine, &[]).ok()).map(|report| report.critical_speeds);
    let from = critical.first().map_or(0.0, |[speed, _]| 0.99 * speed);
    let ours = |k: usize| found.as_ref().and_then(|all| all.iter().filter(|one| one.speed > from).nth(k));
    for (k, [speed, decay]) in critical.iter().enumerate() {
        case.check(checks, format!("critical speed {}", k + 1), ours(k).map(|one| one.speed), *speed);
        let damping = Case { unit: "", ..case };
        let reference = -decay / libm::hypot(*decay, *speed);
        damping.check(checks, format!("damping ratio {}", k + 1), ours(k).map(|one| one.damping_ratio), reference);
    }
}

fn two_diaphragms(checks: &mut Vec<Check>) {
    for (name, gaps, references) in [
        ("two diaphragms, equal gaps", [4e-4, 4e-4], [493.309_672_326, 493.309_672_326, 199.038_054_749_7]),
        ("two diaphragms, unequal gaps", [4e-4, 5.2e-4], [567.880_148_5, 356.835_520_4, 199.109_275_321_7]),
    ] {
        let engine = Engine::Full;
        let case = Case { name, engine: engine.word(), unit: "N", source: INTEGRATION, tolerance: 1e-5 };
        let row = row(&between(&stepping(engine, 4e-6), gaps));
        for (column, reference) in ["max_contact_force_a_N", "max_contact_force_b_N"].into_iter().zip(references) {
            case.check(checks, column, value(&row, column), reference);
        }
        let speed = Case { unit: "rad/s", ..case };
        speed.check(checks, "end_speed_rad_s", value(&row, "end_speed_rad_s"), references[2]);
    }
}

/// Values of a run by column; `None` if the machine cannot be run.
fn row(text: &str) -> Option<BTreeMap<String, f64>> {
    let machine = machine(text)?;
    let structure = Structure::build(&machine, None).ok()?;
    let outcome = simulate(&machine, &structure, &mut NoHistory).ok()?;
    let named = columns(&machine).into_iter().zip(outcome.values);
    Some(named.filter_map(|(column, value)| Some((column.name, value?))).collect())
}

fn value(row: &Option<BTreeMap<String, f64>>, column: &str) -> Option<f64> {
    row.as_ref()?.get(column).copied()
}

/// Shaft of 1 m with two discs; a closure writes the supports at both ends.
fn two_discs(support: impl Fn(&str) -> String, tail: &str) -> String {
    let end = |name: &str, position: f64, axial: &str| {
        format!("[rotor.bearings.{name}]\nposition = {position:?}\n{axial}{}", support(name))
    };
    format!(
        "schema = 1\nname = \"two discs\"\n\
         [rotor.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\ndensity = 7800\n\
         [[rotor.shaft]]\nlength = 1.0\nelements = 4\ndiameter = 0.07\n\
         [rotor.discs.middle]\nposition = 0.5\nmass = 80\ntransverse_inertia = 0.8\npolar_inertia = 1.5\n\
         [rotor.discs.right]\nposition = 0.75\nmass = 20\ntransverse_inertia = 0.1\npolar_inertia = 0.2\n\
         [rotor.unbalances.blade]\nposition = 0.5\nmass = 0.05\nradius = 0.1\n{}{}{tail}",
        end("left", 0.0, "axial_stiffness = 1e6\n"),
        end("right", 1.0, "")
    )
}

fn on_pedestals(tail: &str) -> String {
    let support = |name: &str| {
        format!(
            "stiffness = [[4e7, 1e7], [-2e7, 8e7]]\ndamping = [[6e4, 0.0], [0.0, 9e4]]\n\
             [rotor.bearings.{name}.pedestal]\nmass = [40.0, 60.0]\nstiffness = [3e7, 8e7]\ndamping = [5e3, 8e3]\n"
        )
    };
    two_discs(support, tail)
}

fn on_table(interpolation: &str) -> String {
    let support = |name: &str| {
        format!(
            "kind = \"table\"\ninterpolation = \"{interpolation}\"\n[rotor.bearings.{name}.coefficients]\n\
             speeds = [100, 200, 300, 450, 700]\nkxx = [9e7, 7e7, 6e7, 5e7, 4.4e7]\nkxy = [3e7, 2.5e7, 2e7, 1.6e7, 1.2e7]\n\
             kyx = [-6e7, -5e7, -4.6e7, -4.2e7, -4e7]\nkyy = [5e7, 5.5e7, 6e7, 6.6e7, 7.5e7]\n\
             cxx = [6e5, 3.4e5, 2.4e5, 1.7e5, 1.2e5]\ncxy = [-5e4, -4e4, -3e4, -2e4, -1.5e4]\n\
             cyx = [-5e4, -4e4, -3e4, -2e4, -1.5e4]\ncyy = [4e5, 2.6e5, 2e5, 1.5e5, 1.1e5]\n"
        )
    };
    two_discs(support, "[rotor]\ninitial_speed = 350\n[run]\nend_time = 1\nend_speed = 100\n")
}

/// Shaft of 1 m with a disc of 20 kg between radial springs at a quarter and three quarters.
fn between(stepping: &str, gaps: [f64; 2]) -> String {
    let spring = |name: &str, position: f64, gap: f64| {
        format!(
            "[diaphragms.{name}]\nkind = \"radial-spring\"\nstiffness = 2e6\n[diaphragms.{name}.contact]\nposition = {position:?}\n\
             rotor_radius = 0.04\ngap = {gap:?}\nfriction = 0.15\nfriction_law = \"slip\"\n"
        )
    };
    let rotor = include_str!("two_diaphragms.toml");
    let springs = spring("a", 0.25, gaps[0]) + &spring("b", 0.75, gaps[1]);
    format!(
        "schema = 1\nname = \"two diaphragms\"\n[run]\nend_time = 0.25\nend_beyond = \"off\"\n{stepping}{rotor}{springs}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_holds() {
        let mut checks = Vec::new();
        add(&mut checks);
        assert_eq!(checks.len(), 8 + 4 + 9 + 8 + 8 + 6 + 6);
        for check in &checks {
            assert!(check.holds(), "{check:?}: {:?}", check.error());
        }
    }
}
