//! Stator ring: natural frequencies of the free ring, and the pinched ring.

use super::case::{Case, Check, NO_RUN};
use super::machine::machine;
use crate::modal::report;
use crate::stator::RingMatrices;
use bladeoff_model::machine::DiaphragmKind;
use bladeoff_numerics::linalg::{Vector, solve};

const RADIUS: f64 = 0.369;
const YOUNG: f64 = 1.85e11;
const WIDTH: f64 = 0.05;

pub(super) fn add(checks: &mut Vec<Check>) {
    let meshes = free_ring(0.048, 48).zip(free_ring(0.048, 96));
    let case = Case {
        name: "free ring",
        engine: NO_RUN,
        unit: "Hz",
        source: "curved beam with membrane and rotary inertia, closed form (paper, eqs 7-8)",
        // half a unit of the last digit, of the lowest
        tolerance: 0.5e-3 / 211.331,
    };
    for (k, reference) in [211.331, 595.700, 1136.696, 1826.988].into_iter().enumerate() {
        // fourth order in the element (tests/contact/ring.rs), extrapolated from 48 and 96 elements
        let ours = meshes.as_ref().map(|(coarse, fine)| fine[k] + (fine[k] - coarse[k]) / 15.0);
        case.check(checks, format!("f{}, {} nodal diameters", k + 2, k + 2), ours, reference);
    }
    // thin-ring theory is the limit of vanishing thickness: at 1 mm the error is (h/R)^2
    let thin = free_ring(0.001, 96);
    let case = Case {
        name: "thin ring, 1 mm of 369 mm",
        engine: NO_RUN,
        unit: "Hz",
        source: "thin-ring theory, n(n^2-1)/(2 pi R^2) sqrt(EI/(m(n^2+1)))",
        tolerance: 2e-5,
    };
    // the frequencies of the theory are proportional to the thickness: 211.65 Hz at 48 mm, here with all digits
    let theory = |n: f64| {
        n * (n * n - 1.0) / (2.0 * std::f64::consts::PI * RADIUS * RADIUS)
            * (YOUNG * 1e-6 / (12.0 * 7800.0 * (n * n + 1.0))).sqrt()
    };
    case.check(checks, "f2", thin.as_ref().map(|found| found[0]), theory(2.0));
    let case = Case {
        name: "pinched ring",
        engine: NO_RUN,
        unit: "P R^3/EI",
        source: "inextensional ring, pi/4 - 2/pi and 2/pi - 1/2",
        tolerance: 1e-4,
    };
    let pinched = pinched(0.0025);
    case.check(checks, "diameter under the load closes by", pinched.map(|p| p[0]), 0.148_779);
    case.check(checks, "diameter across opens by", pinched.map(|p| p[1]), 0.136_620);
}

fn text(thickness: f64, elements: usize) -> String {
    format!(
        "schema = 1\nname = \"ring\"\n[run]\nend_time = 1\n\
         [rotor]\nkind = \"point-mass\"\nmass = 1\npolar_inertia = 1\ninitial_speed = 1\n\
         [rotor.bearings.spring]\nstiffness = 1\n\
         [diaphragms.ring.material]\nyoung_modulus = {YOUNG:e}\npoisson_ratio = 0.3\ndensity = 7800\n\
         [diaphragms.ring.ring]\nmean_radius = {RADIUS}\nthickness = {thickness:e}\nwidth = {WIDTH}\n\
         elements = {elements}\n\
         [diaphragms.ring.contact]\nrotor_radius = 0.36\ngap = 0.009\nfriction = 0.1\n"
    )
}

/// Natural frequencies with 2 to 5 nodal diameters \[Hz\].
fn free_ring(thickness: f64, elements: usize) -> Option<[f64; 4]> {
    let found = report(&machine(&text(thickness, elements))?, &[]).ok()?;
    let modes = &found.rings.first()?.1;
    let mut frequencies = [f64::NAN; 4];
    for (k, frequency) in frequencies.iter_mut().enumerate() {
        let mode = modes.iter().skip(3).find(|mode| mode.nodal_diameters == k + 2)?;
        *frequency = mode.frequency / (2.0 * std::f64::consts::PI);
    }
    Some(frequencies)
}

/// Change of the two diameters under two opposite radial unit forces, divided by `R^3/(E I)`.
fn pinched(thickness: f64) -> Option<[f64; 2]> {
    const ELEMENTS: usize = 96;
    let machine = machine(&text(thickness, ELEMENTS))?;
    let DiaphragmKind::Flexible(stator) = &machine.diaphragms.first()?.kind else { return None };
    let ring = RingMatrices::assemble(stator);
    let mut stiffness = ring.stiffness.clone();
    // three soft springs prevent rigid-body motion; a balanced load does not stretch them
    let soft = 1e-6 * stiffness.diagonal().amin();
    for node in [0, ELEMENTS / 4, ELEMENTS / 2] {
        stiffness[(4 * node, 4 * node)] += soft;
    }
    let mut load = Vector::zeros(ring.size());
    load[2] = -1.0;
    load[2 * ELEMENTS + 2] = -1.0;
    let x = solve(&stiffness, &load)?;
    let radial = |node: usize| x[4 * node + 2];
    let unit = RADIUS * RADIUS * RADIUS / (YOUNG * WIDTH * thickness * thickness * thickness / 12.0);
    Some([-(radial(0) + radial(ELEMENTS / 2)) / unit, (radial(ELEMENTS / 4) + radial(3 * ELEMENTS / 4)) / unit])
}
