//! The equations of motion that the step loop evaluates are the derivative of the Lagrangian of docs/theory/01-shaft-line.md.
//!
//! The test implements the Lagrangian independently, from the energies: shape functions from the differential equation of the beam, fields integrated
//! along the shaft, unbalance masses as points. Hyper-dual numbers give `d/dt dL/dq' - dL/dq` exactly. The result is compared with mass, stiffness,
//! forces and torques of [`ShaftLine`] on random states.

use proptest::prelude::*;

use super::{ShaftLine, masses};
use crate::rotor::UnbalanceSite;
use crate::structure::Structure;
use bladeoff_model::machine::{Machine, MachineDef, RotorKind, Shaft};
use bladeoff_numerics::linalg::{Matrix, Vector};

/// Hyper-dual number `a + b e1 + c e2 + d e1 e2`, e1^2 = e2^2 = 0.
#[derive(Clone, Copy)]
struct Dual([f64; 4]);

const ZERO: Dual = Dual([0.0; 4]);

impl std::ops::Add for Dual {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Dual(std::array::from_fn(|i| self.0[i] + o.0[i]))
    }
}
impl std::ops::Sub for Dual {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Dual(std::array::from_fn(|i| self.0[i] - o.0[i]))
    }
}
impl std::ops::Mul for Dual {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, o.0);
        Dual([a * e, a * f + b * e, a * g + c * e, a * h + b * g + c * f + d * e])
    }
}
impl std::ops::Mul<f64> for Dual {
    type Output = Self;
    fn mul(self, o: f64) -> Self {
        Dual(self.0.map(|x| x * o))
    }
}
impl Dual {
    fn sin_cos(self) -> (Self, Self) {
        let [a, b, c, d] = self.0;
        let (s, k) = a.sin_cos();
        (Dual([s, k * b, k * c, k * d - s * b * c]), Dual([k, -s * b, -s * c, -s * d - k * b * c]))
    }
}

/// Displacements and rotations of a node: u, v, theta_u, theta_v, psi.
type Node = [Dual; 5];
const U: usize = 0;
const V: usize = 1;
const TU: usize = 2;
const TV: usize = 3;
const PSI: usize = 4;

/// Deflection w, section angle s, s' and w''' at z of a beam element, as rows over `[w1, s1, w2, s2]`, from the static
/// solution:
/// `w` cubic, `s = w' + (E I/k G S) w'''`.
fn beam_rows(length: f64, ratio: f64, z: f64) -> [[f64; 4]; 4] {
    let w = |z: f64| [1.0, z, z * z, z * z * z];
    let s = |z: f64| [0.0, 1.0, 2.0 * z, 3.0 * z * z + 6.0 * ratio];
    let ds = [0.0, 0.0, 2.0, 6.0 * z];
    let rows = [w(0.0), s(0.0), w(length), s(length)];
    let inverse = nalgebra::Matrix4::from_fn(|i, j| rows[i][j]).try_inverse().expect("the ends fix a cubic");
    [w(z), s(z), ds, [0.0, 0.0, 0.0, 6.0]]
        .map(|row| std::array::from_fn(|j| (0..4).map(|i| row[i] * inverse[(i, j)]).sum()))
}

/// Kinetic minus potential energy of the whole shaft line.
fn lagrangian(machine: &Machine, shaft: &Shaft, q: &[Node], v: &[Node]) -> Dual {
    let g = machine.rotor.gravity;
    let mut twice = ZERO;
    // points and weights of the 6-point Gauss rule on [0, 1], a different rule from that of the elements
    const GAUSS6: [(f64, f64); 3] = [
        (0.238_619_186_083_196_9, 0.467_913_934_572_691),
        (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
        (0.932_469_514_203_152, 0.171_324_492_379_170_35),
    ];
    for (i, e) in shaft.elements.iter().enumerate() {
        let area = std::f64::consts::PI / 4.0 * (e.diameter.powi(2) - e.inner_diameter.powi(2));
        let inertia = std::f64::consts::PI / 64.0 * (e.diameter.powi(4) - e.inner_diameter.powi(4));
        let shear_modulus = e.young_modulus / (2.0 * (1.0 + e.poisson_ratio));
        let rigidity = e.shear_coefficient.map(|k| k * shear_modulus * area);
        let ratio = rigidity.map_or(0.0, |r| e.young_modulus * inertia / r);
        let (a, b) = (i, i + 1);
        let spin = (v[a][PSI] + v[b][PSI]) * 0.5;
        for (x, weight) in GAUSS6.iter().flat_map(|&(x, w)| [(0.5 - 0.5 * x, 0.5 * w), (0.5 + 0.5 * x, 0.5 * w)]) {
            let dz = weight * e.length;
            let [w, s, ds, third] = beam_rows(e.length, ratio, x * e.length);
            let along = |row: &[f64; 4], f: &[Node], d: usize, slope: usize, sign: f64| {
                f[a][d] * row[0] + f[a][slope] * (sign * row[1]) + f[b][d] * row[2] + f[b][slope] * (sign * row[3])
            };
            // theta_v = u,z and theta_u = -v,z, without shear
            let (ut, vt) = (along(&w, v, U, TV, 1.0), along(&w, v, V, TU, -1.0));
            let (tv, tu) = (along(&s, q, U, TV, 1.0), along(&s, q, V, TU, -1.0) * -1.0);
            let (tvt, tut) = (along(&s, v, U, TV, 1.0), along(&s, v, V, TU, -1.0) * -1.0);
            let (bend_u, bend_v) = (along(&ds, q, U, TV, 1.0), along(&ds, q, V, TU, -1.0));
            let psit = v[a][PSI] * (1.0 - x) + v[b][PSI] * x;
            let torsion = (q[b][PSI] - q[a][PSI]) * (1.0 / e.length);
            let (rs, ri) = (e.density * area * dz, e.density * inertia * dz);
            twice = twice + (ut * ut + vt * vt) * rs + (tut * tut + tvt * tvt) * ri + psit * psit * (2.0 * ri);
            // the symmetric form of 2 (phi' + beta') theta_u' theta_v
            twice = twice + spin * (tut * tv - tvt * tu) * (2.0 * ri);
            twice = twice - (bend_u * bend_u + bend_v * bend_v) * (e.young_modulus * inertia * dz);
            twice = twice - torsion * torsion * (shear_modulus * 2.0 * inertia * dz);
            if let Some(rigidity) = rigidity {
                for (d, slope, sign) in [(U, TV, 1.0), (V, TU, -1.0)] {
                    // w' - s = -ratio w'''
                    let shear = along(&third, q, d, slope, sign) * -ratio;
                    twice = twice - shear * shear * (rigidity * dz);
                }
            }
            twice = twice + (along(&w, q, U, TV, 1.0) * g[0] + along(&w, q, V, TU, -1.0) * g[1]) * (2.0 * rs);
        }
    }
    for disc in &shaft.discs {
        let (x, xt) = (&q[disc.node], &v[disc.node]);
        twice = twice + (xt[U] * xt[U] + xt[V] * xt[V]) * disc.mass;
        twice = twice + (xt[TU] * xt[TU] + xt[TV] * xt[TV]) * disc.transverse_inertia;
        twice = twice + (xt[PSI] * xt[PSI] + xt[PSI] * (xt[TU] * x[TV] - xt[TV] * x[TU])) * disc.polar_inertia;
        twice = twice + (x[U] * g[0] + x[V] * g[1]) * (2.0 * disc.mass);
    }
    for bearing in &machine.rotor.bearings {
        let (x, k) = (&q[bearing.node], bearing.stiffness);
        // potential part only; the skew part is a force
        twice = twice - (x[U] * x[U] * k[0][0] + x[U] * x[V] * (k[0][1] + k[1][0]) + x[V] * x[V] * k[1][1]);
    }
    for site in machine.rotor.unbalances.iter().map(UnbalanceSite::new) {
        let (x, xt, d) = (&q[site.node], &v[site.node], site.radius);
        let (psi, psit) = (q[site.torsional_node][PSI], v[site.torsional_node][PSI]);
        let (s, c) = (psi + Dual([site.phase, 0.0, 0.0, 0.0])).sin_cos();
        let (ut, vt) = (xt[U] - psit * s * d, xt[V] + psit * c * d);
        twice = twice + (ut * ut + vt * vt) * site.mass;
        twice = twice + ((x[U] + c * d) * g[0] + (x[V] + s * d) * g[1]) * (2.0 * site.mass);
    }
    twice * 0.5
}

/// Residual `d/dt dL/dq'_i - dL/dq_i` on the path with state q, v and acceleration a, for degree of freedom `(node, kind)`.
fn euler_lagrange(machine: &Machine, shaft: &Shaft, [q, v, a]: &[Vec<[f64; 5]>; 3], node: usize, kind: usize) -> f64 {
    let at = |n: usize, k: usize| if (n, k) == (node, kind) { 1.0 } else { 0.0 };
    let lift = |f: &dyn Fn(usize, usize) -> Dual| -> Vec<Node> {
        (0..q.len()).map(|n| std::array::from_fn(|k| f(n, k))).collect()
    };
    // e1 along the path, e2 along q'_i
    let moving = lift(&|n, k| Dual([q[n][k], v[n][k], 0.0, 0.0]));
    let speeding = lift(&|n, k| Dual([v[n][k], a[n][k], at(n, k), 0.0]));
    let momentum_rate = lagrangian(machine, shaft, &moving, &speeding).0[3];
    // e2 along q_i
    let shifted = lift(&|n, k| Dual([q[n][k], 0.0, at(n, k), 0.0]));
    let still = lift(&|n, k| Dual([v[n][k], 0.0, 0.0, 0.0]));
    momentum_rate - lagrangian(machine, shaft, &shifted, &still).0[2]
}

fn machine() -> Machine {
    let text = "schema = 1\nname = \"lagrangian\"\n[run]\nend_time = 1\nengine = \"full\"\n\
        [rotor]\ninitial_speed = 100\ngravity = [3.0, -9.0]\n\
        [rotor.material]\nyoung_modulus = 2.1e11\npoisson_ratio = 0.3\ndensity = 7850\nshear_coefficient = \"cowper\"\n\
        [[rotor.shaft]]\nlength = 0.4\ndiameter = 0.06\ninner_diameter = 0.02\nelements = 2\n\
        [[rotor.shaft]]\nlength = 0.3\ndiameter = 0.1\nelements = 1\nshear_coefficient = \"none\"\n\
        [[rotor.shaft]]\nlength = 0.3\ndiameter = 0.08\nelements = 1\nshear_coefficient = 0.9\n\
        [rotor.discs.a]\nposition = 0.4\nmass = 12\ntransverse_inertia = 0.2\npolar_inertia = 0.37\n\
        [rotor.discs.b]\nposition = 1.0\nmass = 5\ntransverse_inertia = 0.06\npolar_inertia = 0.1\n\
        [rotor.bearings.left]\nposition = 0\nstiffness = [[2e7, 3e6], [-1e6, 1.5e7]]\naxial_stiffness = 1e6\n\
        damping = [[300.0, 40.0], [-20.0, 500.0]]\n\
        [rotor.bearings.right]\nposition = 0.7\nstiffness = 1.8e7\ndamping = 100\n\
        [rotor.unbalances.blade]\nposition = 0.4\nmass = 0.3\nradius = 0.4\nphase = 0.5\nkind = \"lost\"\n\
        [rotor.unbalances.weight]\nposition = 1.0\nmass = 0.2\nradius = 0.3\nphase = 2.0\n\
        [rotor.unbalances.middle]\nposition = 0.2\nmass = 0.05\nradius = 0.03\nphase = -1.0\npresent = \"before\"\n\
        [rotor.unbalances.row]\ndisc = \"a\"\nposition = 0.2\nmass = 0.4\nradius = 0.5\nphase = 1.3\nkind = \"lost\"\n\
        [rotor.unbalances.ring]\ndisc = \"b\"\nposition = 0.7\nmass = 0.3\nradius = 0.2\nphase = -2.2\n";
    MachineDef::parse("test", text).expect("a valid machine").build().expect("a valid machine")
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn forces_are_the_derivative_of_the_lagrangian(seed in any::<u64>()) {
        let machine = machine();
        prop_assert!(machine.rotor.unbalances.iter().filter(|site| site.torsional_node != site.node).count() == 2);
        let structure = Structure::build(&machine, None).expect("solvable");
        let RotorKind::Shaft(shaft) = &machine.rotor.kind else { unreachable!("a shaft") };
        let rotor = &structure.rotor;
        let mut state = seed | 1;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        // displacements of mm, velocities of m/s, accelerations of 1000 m/s2; spin of hundreds of rad/s with torsion
        let mut draw = |lateral: f64, torsion: f64| -> Vec<[f64; 5]> {
            (0..rotor.nodes).map(|_| std::array::from_fn(|k| random() * if k == PSI { torsion } else { lateral })).collect()
        };
        let mut path = [draw(1e-3, 1e-3), draw(1.0, 5.0), draw(1e3, 1e3)];
        let phi = 2.0 + path[0][0][PSI] * 1e3;
        for node in 0..rotor.nodes {
            path[0][node][PSI] += phi;
            path[1][node][PSI] += 300.0;
        }
        let mut line = ShaftLine::new(&machine, &structure, 1e-6).expect("regular");
        let place = |node: usize, kind: usize| match kind {
            U => rotor.u(node),
            V => rotor.v(node),
            TU => rotor.theta_u(node).expect("a shaft"),
            _ => rotor.theta_v(node).expect("a shaft"),
        };
        let lateral = |f: &Vec<[f64; 5]>| {
            let mut x = vec![0.0; rotor.lateral_size()];
            (0..rotor.nodes).for_each(|node| [U, V, TU, TV].iter().for_each(|&k| x[place(node, k)] = f[node][k]));
            x
        };
        let torsion = |f: &Vec<[f64; 5]>, less: f64| -> Vec<f64> { f.iter().map(|node| node[PSI] - less).collect() };
        line.lateral.x = lateral(&path[0]);
        line.spin.angle = phi;
        line.torsion.x = torsion(&path[0], phi);
        line.refresh();
        (line.lateral.v, line.lateral.a) = (lateral(&path[1]), lateral(&path[2]));
        (line.torsion.v, line.torsion.a) = (torsion(&path[1], 0.0), torsion(&path[2], 0.0));
        line.evaluate_instant();
        let (mass, torsional_mass) = masses(&structure, &line.unbalances.sites);
        let column = |x: &[f64]| Vector::from_column_slice(x);
        let product = |m: &Matrix, x: &[f64]| m * column(x);
        // residual that the step loop sets to zero, without damping and skew stiffness, which have no energy
        let rows = product(&mass, &line.lateral.a) + product(&rotor.stiffness, &line.lateral.x)
            - column(&line.lateral.force)
            - column(&line.weight.projected);
        let torsional_rows = product(&torsional_mass, &line.torsion.a) + product(&rotor.torsional_stiffness, &line.torsion.x)
            - column(&line.torsion.force);
        let scale = rows.amax();
        let torsional_scale = torsional_rows.amax();
        for node in 0..rotor.nodes {
            for kind in [U, V, TU, TV] {
                let exact = euler_lagrange(&machine, shaft, &path, node, kind);
                let ours = rows[place(node, kind)];
                prop_assert!((ours - exact).abs() < 1e-9 * scale, "node {node} kind {kind}: {ours} {exact}");
            }
            let exact = euler_lagrange(&machine, shaft, &path, node, PSI);
            let ours = torsional_rows[node];
            prop_assert!((ours - exact).abs() < 1e-9 * torsional_scale, "torsion of node {node}: {ours} {exact}");
        }
    }
}
