//! Steady-state unbalance response over speed.
//!
//! ```text
//! [K + K_skew - W^2 M + i W (C + W G)] X = F,   F_u = m d W^2 e^{i a},  F_v = -i F_u
//! ```
//! Source: the synchronous part of the equations of motion at constant speed. The same system gives the initial state of a run with
//! residual unbalance ([`crate::engine`]), which `tests/rotor/linear_rotors.rs` compares with the reference. M excludes the unbalance
//! masses, except for a point mass, which may have no other mass. Verified by `a_jeffcott_rotor_responds_in_closed_form`.

use crate::rotor::{RotorMatrices, UnbalanceSite};
use bladeoff_model::machine::{Machine, RotorKind};
use bladeoff_numerics::linalg::{ComplexFactors, Matrix, Vector};

/// Unbalance response at one speed.
#[derive(Debug, Clone, PartialEq)]
pub struct UnbalanceResponse {
    /// Speed \[rad/s\].
    pub speed: f64,
    /// Largest displacement of each node over a revolution (major half axis of its orbit) \[m\].
    pub nodes: Vec<f64>,
    /// Phase of the displacement along X at each node \[rad\], positive ahead of the spin angle.
    pub phases: Vec<f64>,
    /// Largest load of each bearing over a revolution \[N\].
    pub bearings: Vec<f64>,
    /// Largest load of each pedestal over a revolution, in the order of the bearings with a pedestal \[N\].
    pub pedestals: Vec<f64>,
}

/// Largest norm over a revolution of the vector `(Re(x e^{i psi}), Re(y e^{i psi}))`.
fn major(x: [f64; 2], y: [f64; 2]) -> f64 {
    let sum = 0.5 * (x[0] * x[0] + x[1] * x[1] + y[0] * y[0] + y[1] * y[1]);
    // magnitude of the sum of the squared complex amplitudes
    let re = x[0] * x[0] - x[1] * x[1] + y[0] * y[0] - y[1] * y[1];
    let im = 2.0 * (x[0] * x[1] + y[0] * y[1]);
    (sum + 0.5 * (re * re + im * im).sqrt()).sqrt()
}

/// Returns the responses to all unbalances of a machine at given speeds \[rad/s\]. A speed at which the system is singular (undamped
/// critical speed) is skipped.
#[must_use]
pub fn unbalance_response(machine: &Machine, speeds: &[f64]) -> Vec<UnbalanceResponse> {
    let rotor = LinearRotor::new(machine);
    speeds.iter().filter_map(|&speed| rotor.response(speed)).collect()
}

/// Lateral matrices of the rotor with its unbalances, for steady and transient responses at constant speed.
pub(super) struct LinearRotor {
    pub matrices: RotorMatrices,
    pub sites: Vec<UnbalanceSite>,
    /// Lateral mass matrix; for a point mass with its unbalances.
    pub mass: Matrix,
    /// Stiffness of shaft and bearings, skew terms included.
    pub stiffness: Matrix,
    /// Gyroscopic matrix G per unit spin [kg m2].
    pub gyroscopic: Matrix,
    /// Polar moment of inertia of the complete rotor \[kg m2\].
    pub inertia: f64,
}

impl LinearRotor {
    pub fn new(machine: &Machine) -> Self {
        let matrices = RotorMatrices::assemble(&machine.rotor);
        let sites: Vec<UnbalanceSite> = machine.rotor.unbalances.iter().map(UnbalanceSite::new).collect();
        let mut mass = matrices.mass.clone();
        if matches!(machine.rotor.kind, RotorKind::PointMass(_)) {
            for site in &sites {
                for dof in matrices.plane_places(site.node) {
                    mass[(dof, dof)] += site.mass;
                }
            }
        }
        let (stiffness, gyroscopic) = (&matrices.stiffness + matrices.skew_stiffness(), matrices.gyroscopic());
        let inertia = matrices.torsional_mass.iter().sum();
        Self { matrices, sites, mass, stiffness, gyroscopic, inertia }
    }

    /// Returns the complex amplitudes X at a speed \[rad/s\], real parts before imaginary parts; `None` if the system is singular.
    /// `is_there`: whether the unbalance with a given index acts.
    pub fn amplitudes(&self, speed: f64, is_there: impl Fn(usize) -> bool) -> Option<Vector> {
        let size = self.matrices.lateral_size();
        let mut force = vec![[0.0; 2]; size];
        for (_, site) in self.sites.iter().enumerate().filter(|(place, _)| is_there(*place)) {
            let (sin, cos) = libm::sincos(site.phase);
            let amplitude = site.mass * site.radius * speed * speed;
            let [u, v] = self.matrices.plane_places(site.node);
            for (place, [re, im]) in [(u, [cos, sin]), (v, [sin, -cos])] {
                force[place][0] += amplitude * re;
                force[place][1] += amplitude * im;
            }
        }
        let mut dynamic = &self.stiffness - &self.mass * (speed * speed);
        let mut velocity = (&self.matrices.damping + &self.gyroscopic * speed) * speed;
        if let Some([stiffness, damping]) = self.matrices.change_at(speed) {
            dynamic += stiffness;
            velocity += damping * speed;
        }
        let found = ComplexFactors::new(&dynamic, &velocity).solve(&force);
        let parts = [0, 1].into_iter().flat_map(|part| found.iter().map(move |entry| entry[part]));
        let amplitudes = Vector::from_iterator(2 * size, parts);
        amplitudes.iter().all(|entry| entry.is_finite()).then_some(amplitudes)
    }

    /// Returns the steady-state response to all unbalances at a speed \[rad/s\].
    pub fn response(&self, speed: f64) -> Option<UnbalanceResponse> {
        let (rotor, size) = (&self.matrices, self.matrices.lateral_size());
        let x = self.amplitudes(speed, |_| true)?;
        let at = |dof: usize| [x[dof], x[size + dof]];
        let nodes = (0..rotor.nodes).map(|node| rotor.plane_places(node).map(at)).map(|[u, v]| major(u, v)).collect();
        let phase = |node| {
            let [re, im] = at(rotor.plane_places(node)[0]);
            libm::atan2(im, re)
        };
        let load = |bearing: &crate::rotor::BearingSite| {
            let parts = [0, size].map(|from| bearing.across(&x.as_slice()[from..from + size]));
            let [u, v] = [0, 1].map(|axis| parts.map(|part| part[axis]));
            // load K x + C x' with x' = i W x, real and imaginary part separately
            let real = bearing.load([u[0], v[0]], [-speed * u[1], -speed * v[1]]);
            let imaginary = bearing.load([u[1], v[1]], [speed * u[0], speed * v[0]]);
            major([real[0], imaginary[0]], [real[1], imaginary[1]])
        };
        let mut bearings = rotor.bearings.clone();
        for (place, change) in rotor.table_changes(speed) {
            bearings[place] = bearings[place].changed_by(&change);
        }
        Some(UnbalanceResponse {
            speed,
            nodes,
            phases: (0..rotor.nodes).map(phase).collect(),
            bearings: bearings.iter().map(load).collect(),
            pedestals: rotor.pedestals.iter().map(load).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    /// m = 1 (0.9 and an unbalance of 0.1), k = 4, c = 0.2: |X| = m_u d W^2/|k - W^2 + i W c|.
    #[test]
    fn a_jeffcott_rotor_responds_in_closed_form() {
        let text = "schema = 1\nname = \"jeffcott\"\n[rotor]\nkind = \"point-mass\"\nmass = 0.9\npolar_inertia = 1.0\n\
            initial_speed = 1.0\n[rotor.bearings.support]\nstiffness = 4.0\ndamping = 0.2\n\
            [rotor.unbalances.blade]\nmass = 0.1\nradius = 0.3\nphase = 0.7\n[run]\nend_time = 1.0\n";
        let machine = MachineDef::parse("test.toml", text).expect("valid").build().expect("valid");
        for response in unbalance_response(&machine, &[0.5, 2.0, 7.0]) {
            let w = response.speed;
            let expected = 0.1 * 0.3 * w * w / ((4.0 - w * w).powi(2) + (0.2 * w).powi(2)).sqrt();
            assert!((response.nodes[0] / expected - 1.0).abs() < 1e-12);
            let load = expected * (16.0 + (0.2 * w).powi(2)).sqrt();
            assert!((response.bearings[0] / load - 1.0).abs() < 1e-12);
            // phase lag behind the unbalance (phase 0.7): from 0 below to pi above the critical speed
            let lag = (0.2 * w).atan2(4.0 - w * w);
            assert!((response.phases[0] - (0.7 - lag)).abs() < 1e-12);
        }
    }

    #[test]
    fn the_major_axis_is_the_largest_reach() {
        let (x, y) = ([0.3, -0.8], [1.1, 0.2]);
        let reach = (0..3600).map(|k| {
            let (sin, cos) = (f64::from(k) / 3600.0 * std::f64::consts::TAU).sin_cos();
            (x[0] * cos - x[1] * sin).hypot(y[0] * cos - y[1] * sin)
        });
        assert!((major(x, y) - reach.fold(0.0, f64::max)).abs() < 1e-6);
    }
}
