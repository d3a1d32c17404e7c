//! Torques over time in steps of central differences.
//!
//! ```text
//! T_n = (1/dt) integral of T over [t_n - dt/2, t_n + dt/2]        torque of step n                                    (1)
//! work += dt T_n . v_n                                            v_n: centred rate of the node                       (2)
//! ```
//! The mean (1) keeps the angular impulse of a jump inside a step, so a jump is of second order as the scheme is. With (2) the balance of the
//! scheme is exact. Before t = 0 a torque has its first value.
//! Source: docs/theory/01-shaft-line.md. Verified by `core/tests/runs/torques.rs`.

use super::field::Field;
use bladeoff_model::machine::{Machine, Torque};
use bladeoff_numerics::linalg::axpy;

/// Torques of a run.
#[derive(Debug, Clone)]
pub(super) struct Torques {
    torques: Vec<Torque>,
    /// Row of each node on the torsional coordinates.
    rows: Vec<Vec<f64>>,
    /// Time step \[s\].
    dt: f64,
    /// T_n \[N m\], and its generalised torques on the coordinates.
    present: Vec<f64>,
    projected: Vec<f64>,
}

impl Torques {
    /// Torques of a machine; `None`: it has none.
    pub fn new(machine: &Machine, torsion: &Field<'_>, dt: f64) -> Option<Self> {
        let torques = machine.torques.clone();
        (!torques.is_empty()).then(|| Self {
            rows: torques.iter().map(|torque| torsion.row(torque.node)).collect(),
            dt,
            present: torques.iter().map(Torque::before).collect(),
            projected: vec![0.0; torsion.size()],
            torques,
        })
    }

    /// Generalised torques of the step at `time` \[s\].
    pub fn at_step(&mut self, time: f64) -> &[f64] {
        self.projected.fill(0.0);
        for ((torque, row), present) in self.torques.iter().zip(&self.rows).zip(&mut self.present) {
            *present = torque.moments([time - 0.5 * self.dt, time + 0.5 * self.dt])[0] / self.dt;
            axpy(*present, row, &mut self.projected);
        }
        &self.projected
    }

    /// Sum of all torques before t = 0 \[N m\].
    pub fn sum_before(&self) -> f64 {
        self.torques.iter().map(Torque::before).sum()
    }

    /// Work of the step (2) \[J\] with the rates of all nodes \[rad/s\].
    pub fn work(&self, rates: &[f64]) -> f64 {
        let powers = self.torques.iter().zip(&self.present).map(|(torque, present)| present * rates[torque.node]);
        self.dt * powers.sum::<f64>()
    }
}
