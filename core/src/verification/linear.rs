//! Linear rotors: whirl, critical speeds, torsion, unbalance response.

use std::fmt::Write as _;

use super::case::{Case, Check, NO_RUN};
use super::machine::{machine, stepping, watch};
use crate::modal::{quadratic_modes, report, whirl_modes};
use crate::rotor::RotorMatrices;
use bladeoff_model::machine::{Engine, Machine};
use bladeoff_numerics::linalg::Matrix;

const RPM: f64 = std::f64::consts::PI / 30.0;
const TWO_CODES: &str = "two independent finite-element codes (one of them ROSS 2.3.0)";

pub(super) fn add(checks: &mut Vec<Check>) {
    lalanne_ferraris(checks);
    nelson_mcvaugh(checks);
    sdll(checks);
    spinning_beam(checks);
}

fn lalanne_ferraris(checks: &mut Vec<Check>) {
    let machine = machine(&three_discs([500.0, 700.0], REST));
    let modes = machine.as_ref().and_then(|m| whirl_modes(m, &[25_000.0 * RPM]).ok());
    let case = Case {
        name: "Lalanne-Ferraris rotor, 25000 rpm",
        engine: NO_RUN,
        unit: "rad/s",
        source: TWO_CODES,
        tolerance: 1e-8,
    };
    let mode = |k: usize| modes.as_ref().and_then(|speeds| speeds.first()?.1.get(k).copied());
    let frequencies = [348.156_554_342_794_3, 422.208_144_159_318_7, 992.099_746_198_725_4, 1_216.670_053_757_727_6];
    for (k, reference) in frequencies.into_iter().enumerate() {
        case.check(checks, format!("whirl frequency {}", k + 1), mode(k).map(|m| m.frequency), reference);
    }
    let damping = Case { unit: "", ..case };
    damping.check(checks, "damping ratio 1", mode(0).map(|m| m.damping_ratio), 2.948_575_675_689_71e-4);
    let found = machine.as_ref().and_then(|m| report(m, &[]).ok());
    let case = Case { name: "Lalanne-Ferraris rotor", ..case };
    let criticals = [379.123_613_039_307_26, 397.733_283_979_454_65, 1_048.977_578_072_520_4, 1_181.072_300_558_804_3];
    for (k, reference) in criticals.into_iter().enumerate() {
        let ours = found.as_ref().and_then(|f| Some(f.critical_speeds.get(k)?.speed));
        case.check(checks, format!("critical speed {}", k + 1), ours, reference);
    }
    let ours = found.as_ref().and_then(|f| f.torsion.first().copied());
    case.check(checks, "torsional frequency 1", ours, 1_595.992_702_187_453);
    let case = Case { name: "Lalanne-Ferraris, 0.2 kg mm at 10000 rpm", unit: "m", ..case };
    both_amplitudes(
        checks,
        case,
        ([500.0, 700.0], 2e-4, 10_000.0 * RPM),
        [4.330_149_720_867_453e-5, 1.353_075_020_630_820_9e-5],
    );
}

fn nelson_mcvaugh(checks: &mut Vec<Check>) {
    let with = [1_609.585_544_911_042_7, 1_780.165_993_824_363_3, 4_870.364_187_969_99, 5_216.649_081_595_38];
    let without = [1_621.724_429_903_823_6, 1_795.740_471_072_959_5];
    for (name, shear, criticals) in
        [("Nelson-McVaugh rotor", "cowper", &with[..]), ("Nelson-McVaugh without shear", "none", &without[..])]
    {
        let case = Case { name, engine: NO_RUN, unit: "rad/s", source: TWO_CODES, tolerance: 1e-8 };
        let found = machine(&nelson_mcvaugh_text(shear)).and_then(|m| report(&m, &[]).ok());
        for (k, reference) in criticals.iter().enumerate() {
            let ours = found.as_ref().and_then(|f| Some(f.critical_speeds.get(k)?.speed));
            case.check(checks, format!("critical speed {}", k + 1), ours, *reference);
        }
    }
}

fn sdll(checks: &mut Vec<Check>) {
    let case = Case {
        name: "SDLL124, 30000 rpm",
        engine: NO_RUN,
        unit: "Hz",
        source: "ROTORINSA verification set, 0.3 %",
        tolerance: 3e-3,
    };
    let modes = machine(&three_discs([500.0, 700.0], REST)).and_then(|m| whirl_modes(&m, &[30_000.0 * RPM]).ok());
    for (k, reference) in [54.112, 68.122, 154.65, 196.0].into_iter().enumerate() {
        let ours = modes.as_ref().and_then(|speeds| Some(speeds.first()?.1.get(k)?.frequency / (60.0 * RPM)));
        case.check(checks, format!("whirl frequency {}", k + 1), ours, reference);
    }
    let case = Case {
        name: "SDLL126, 50 kg mm at 15000 rpm",
        engine: NO_RUN,
        unit: "m",
        source: "ROTORINSA verification set, 0.1 %",
        tolerance: 1e-3,
    };
    both_amplitudes(checks, case, ([5000.0, 7000.0], 0.05, 15_000.0 * RPM), [5.721e-4, 7.023e-4]);
}

/// Amplitudes of disc 2: initial state of the full engine, and one turn of the exponential engine with all modes.
fn both_amplitudes(checks: &mut Vec<Check>, case: Case, rotor: ([f64; 2], f64, f64), [x, y]: [f64; 2]) {
    let left = in_a_cell(&unbalanced(rotor, REST_OF_RUN), rotor.2).unwrap_or(0.0);
    let runs = [
        (Engine::Full, steady_amplitudes(rotor), case.tolerance),
        (Engine::Exponential, turned_amplitudes(rotor), case.tolerance.max(left)),
    ];
    for (engine, found, tolerance) in runs {
        let case = Case { engine: engine.word(), tolerance, ..case };
        case.check(checks, "amplitude x of disc 2", found.map(|a| a[0]), x);
        case.check(checks, "amplitude y of disc 2", found.map(|a| a[1]), y);
    }
}

/// Relative error of the exponential engine's response at a constant spin, as documented. Whirl frequencies are constant in a speed interval of the
/// grid; `half` is half its length. The error is the change of the nearest whirl frequency over half an interval, divided by the distance of that
/// frequency from the speed.
fn in_a_cell(text: &str, speed: f64) -> Option<f64> {
    let half = libm::exp2(libm::round(libm::log2(speed / 150.0))) / 20.0;
    let found = whirl_modes(&machine(text)?, &[speed - half, speed, speed + half]).ok()?;
    let [below, here, above] = found.as_slice() else { return None };
    let distance = |k: usize| here.1.get(k).map_or(f64::INFINITY, |mode| (mode.frequency - speed).abs());
    let nearest = (0..here.1.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)))?;
    let moved = 0.5 * (above.1.get(nearest)?.frequency - below.1.get(nearest)?.frequency).abs();
    Some(moved / distance(nearest))
}

fn spinning_beam(checks: &mut Vec<Check>) {
    let case = Case {
        name: "simply supported beam, 2000 rad/s",
        engine: NO_RUN,
        unit: "rad/s",
        source: "spinning Timoshenko beam, closed form",
        // the error with 40 elements is 4.6e-6 at the first mode
        tolerance: 1e-5,
    };
    let found = supported_beam(40, 2000.0);
    case.check(checks, "first backward", found.map(|f| f[0]), 618.793_447_232_379_8);
    case.check(checks, "first forward", found.map(|f| f[1]), 642.461_827_690_591_2);
}

/// Settings of machines whose run is not used.
const REST_OF_RUN: &str = "[run]\nend_time = 1\n";
const REST: &str = "[rotor]\ninitial_speed = 0\n[run]\nend_time = 1\n";

/// Three discs on a uniform shaft, 13 elements (Lalanne, Ferraris: Rotordynamics Prediction in Engineering).
fn three_discs([cxx, cyy]: [f64; 2], tail: &str) -> String {
    let mut text = String::from(
        "schema = 1\nname = \"three discs\"\n[rotor.material]\nyoung_modulus = 2e11\npoisson_ratio = 0.3\n\
         density = 7800\nshear_coefficient = \"cowper\"\n[[rotor.shaft]]\nlength = 1.3\nelements = 13\ndiameter = 0.1\n",
    );
    let discs = [
        (0.2, "14.580131505310229", "0.06463858300687535", "0.12320211121987142"),
        (0.5, "45.94579255875074", "0.49774608605313314", "0.9763480918734534"),
        (1.0, "55.13495107050088", "0.6023493404452223", "1.171617710248144"),
    ];
    for (k, (position, mass, transverse, polar)) in discs.into_iter().enumerate() {
        let _ = write!(
            text,
            "[rotor.discs.d{k}]\nposition = {position}\nmass = {mass}\ntransverse_inertia = {transverse}\n\
             polar_inertia = {polar}\n"
        );
    }
    for position in ["0", "1.3"] {
        let _ = write!(
            text,
            "[rotor.bearings.at_{}]\nposition = {position}\nstiffness = [[5e7, 0.0], [0.0, 7e7]]\n\
             damping = [[{cxx:?}, 0.0], [0.0, {cyy:?}]]\naxial_stiffness = 1e6\n",
            position.replace('.', "_")
        );
    }
    text + tail
}

/// Nelson, McVaugh 1976 (its table lists radii; diameters here), isotropic bearings.
fn nelson_mcvaugh_text(shear: &str) -> String {
    const ELEMENTS: [(&str, &str, &str); 18] = [
        ("0.0127", "0.0102", "0"),
        ("0.0381", "0.0204", "0"),
        ("0.0254", "0.0152", "0"),
        ("0.0127", "0.0406", "0"),
        ("0.0127", "0.0406", "0"),
        ("0.0051", "0.066", "0"),
        ("0.0076", "0.066", "0.0304"),
        ("0.0127", "0.0508", "0.0356"),
        ("0.0076", "0.0508", "0"),
        ("0.0305", "0.0254", "0"),
        ("0.0254", "0.0254", "0"),
        ("0.0381", "0.0304", "0"),
        ("0.0381", "0.0304", "0"),
        ("0.0203", "0.0254", "0"),
        ("0.0178", "0.0254", "0"),
        ("0.0102", "0.0762", "0"),
        ("0.0304", "0.0406", "0"),
        ("0.0096", "0.0406", "0.0304"),
    ];
    let mut text = format!(
        "schema = 1\nname = \"nelson mcvaugh\"\n[run]\nend_time = 1\n[rotor]\ninitial_speed = 0\n[rotor.material]\n\
         young_modulus = 2.078e11\npoisson_ratio = 0.3\ndensity = 7806\nshear_coefficient = \"{shear}\"\n\
         [rotor.discs.disc]\nposition = 0.0889\nmass = 1.401\ntransverse_inertia = 0.00136\npolar_inertia = 0.002\n\
         [rotor.bearings.left]\nposition = 0.1651\nstiffness = 4.378e7\naxial_stiffness = 1e6\n\
         [rotor.bearings.right]\nposition = 0.287\nstiffness = 4.378e7\n"
    );
    for (length, outer, inner) in ELEMENTS {
        let _ = write!(
            text,
            "[[rotor.shaft]]\nlength = {length}\nelements = 1\ndiameter = {outer}\ninner_diameter = {inner}\n"
        );
    }
    text
}

/// Three discs with an unbalance [kg m] at disc 2. Its radius is so large that its mass is negligible.
fn unbalanced((damping, unbalance, speed): ([f64; 2], f64, f64), tail: &str) -> String {
    let tail = format!(
        "[rotor.unbalances.residual]\nposition = 0.5\nmass = {:e}\nradius = 1e6\npresent = \"before\"\n\
         [rotor]\ninitial_speed = {speed:?}\n{tail}",
        unbalance * 1e-6
    );
    three_discs(damping, &tail)
}

/// Steady amplitudes |u|, |v| of disc 2 \[m\], from the initial state of the transient.
fn steady_amplitudes(rotor: ([f64; 2], f64, f64)) -> Option<[f64; 2]> {
    let speed = rotor.2;
    let run = format!("[rotor.speed_law]\nacceleration = 0\n[run]\nend_time = 1e-9\n{}", stepping(Engine::Full, 1e-9));
    let text = unbalanced(rotor, &run);
    let places = rotor_of(&machine(&text)?).plane_places(5);
    let mut amplitudes = None;
    watch(&text, |frame| {
        if amplitudes.is_none() {
            // x = Re(X e^{iWt}), x' = Re(iW X e^{iWt})
            amplitudes = Some(places.map(|dof| libm::hypot(frame.displacement[dof], frame.velocity[dof] / speed)));
        }
    })?;
    amplitudes
}

/// Amplitudes |u|, |v| of disc 2 \[m\], from the first harmonic over the tenth turn. The spin is free; the unbalance's arm gives it a large inertia.
fn turned_amplitudes(rotor: ([f64; 2], f64, f64)) -> Option<[f64; 2]> {
    const STEPS: f64 = 1024.0;
    let turn = 2.0 * std::f64::consts::PI / rotor.2;
    let step = turn / STEPS;
    let run =
        format!("[run]\nend_time = {:?}\nrotor_modes = 56\n{}", 10.01 * turn, stepping(Engine::Exponential, step));
    let text = unbalanced(rotor, &run);
    let places = rotor_of(&machine(&text)?).plane_places(5);
    let mut sums = [[0.0; 2]; 2];
    watch(&text, |frame| {
        if (9.0 * turn - 0.5 * step..10.0 * turn - 0.5 * step).contains(&frame.time) {
            let (sin, cos) = libm::sincos(frame.angle);
            for (sum, dof) in sums.iter_mut().zip(places) {
                sum[0] += frame.displacement[dof] * cos;
                sum[1] += frame.displacement[dof] * sin;
            }
        }
    })?;
    Some(sums.map(|[re, im]| 2.0 / STEPS * libm::hypot(re, im)))
}

fn rotor_of(machine: &Machine) -> RotorMatrices {
    RotorMatrices::assemble(&machine.rotor)
}

/// First backward and forward frequency \[rad/s\]. The supported degrees of freedom are removed, because no bearing is rigid.
fn supported_beam(elements: usize, spin: f64) -> Option<[f64; 2]> {
    let text = format!(
        "schema = 1\nname = \"beam\"\n[run]\nend_time = 1\n[rotor]\ninitial_speed = 0\n[rotor.material]\n\
         young_modulus = 2.1e11\npoisson_ratio = 0.3\ndensity = 7850\nshear_coefficient = \"cowper\"\n\
         [[rotor.shaft]]\nlength = 2\nelements = {elements}\ndiameter = 0.2\n\
         [rotor.bearings.a]\nposition = 0\nstiffness = 1\naxial_stiffness = 1\n\
         [rotor.bearings.b]\nposition = 2\nstiffness = 1\n"
    );
    let rotor = rotor_of(&machine(&text)?);
    let fixed = [rotor.u(0), rotor.v(0), rotor.u(elements), rotor.v(elements)];
    let free: Vec<usize> = (0..rotor.lateral_size()).filter(|dof| !fixed.contains(dof)).collect();
    let part = |a: &Matrix| Matrix::from_fn(free.len(), free.len(), |i, j| a[(free[i], free[j])]);
    let (mass, stiffness, gyroscopic) = (part(&rotor.mass), part(&rotor.stiffness), part(&rotor.gyroscopic()));
    let modes = quadratic_modes(&mass, &(gyroscopic * spin), &stiffness, "the beam").ok()?;
    let mut frequencies: Vec<f64> = modes.values.iter().map(|[_, im]| *im).filter(|im| *im > 0.0).collect();
    frequencies.sort_by(f64::total_cmp);
    Some([*frequencies.first()?, *frequencies.get(1)?])
}
