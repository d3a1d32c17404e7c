//! Torques over time on the spin and on the torsional modes.
//!
//! ```text
//! T = T0 + T1 (s/h - 1/2),  T0 = I0/h,  T1 = 12 I1/h^2         a torque over the step, s from its beginning                       (1)
//! P(n+1) - P(n)  has  sum_k I0_k                               momentum of the spin                                                (2)
//! Phi            has  -sum_k I1_k/J                            beside the mean of the spin at both ends                            (3)
//! e_j            the response to sum_k row_kj T_k              exact ([`super::torsional_modes`])                                  (4)
//! work           sum_k I0_k [W(n+) + W(n+1)]/2 + that of (4)                                                                       (5)
//! ```
//! I0, I1: integrals of the torque over the step and their first moment about its middle; row_kj: rotation of node k beside the mean angle, per
//! amplitude of mode j; other symbols of [`super::spin`]. (1) has the impulse and the first moment of the torque. So the error of a step is of
//! third order in `w h` where the torque jumps and of fourth order where it is smooth; a torque with straight lines between the ends of steps is exact.
//!
//! Source: variation of constants. Limits: the unbalances feel (2) and (4) through the predicted psi', of second order as in a step without torques.
//! Verified by `core/tests/runs/torques.rs`.

use super::loaded_modes::LoadedModes;
use crate::structure::Structure;
use bladeoff_model::machine::{Machine, Torque};
use bladeoff_numerics::linalg::axpy;

/// Torques of a run.
#[derive(Debug, Clone)]
pub(super) struct Torques {
    torques: Vec<Torque>,
    /// Row of each torque's node on the modes.
    rows: Vec<Vec<f64>>,
    /// J \[kg m2\]; infinite where the speed is prescribed.
    inertia: f64,
    /// Time at n \[s\].
    time: f64,
    /// Sums of I0 \[N m s\] and I1 \[N m s2\] of the step.
    pub moments: [f64; 2],
    /// Parts T0 and T1 on the modes.
    pub on_modes: [Vec<f64>; 2],
    /// Work (5) so far \[J\].
    pub work: f64,
}

impl Torques {
    /// Torques of a machine; `None`: it has none.
    pub fn new(machine: &Machine, structure: &Structure, modes: &LoadedModes) -> Option<Self> {
        let zeros = vec![0.0; modes.modes.len()];
        (!machine.torques.is_empty()).then(|| Self {
            torques: machine.torques.clone(),
            rows: machine.torques.iter().map(|torque| modes.row(structure, torque.node)).collect(),
            inertia: modes.inertia,
            time: 0.0,
            moments: [0.0; 2],
            on_modes: [zeros.clone(), zeros],
            work: 0.0,
        })
    }

    /// Takes over time and work of other torques.
    pub fn take_over(&mut self, other: &Self) {
        (self.time, self.work) = (other.time, other.work);
    }

    /// Evaluates (1) for a step of `h` \[s\].
    pub fn begin_step(&mut self, h: f64) {
        self.moments = [0.0; 2];
        self.on_modes.iter_mut().for_each(|part| part.fill(0.0));
        for (torque, row) in self.torques.iter().zip(&self.rows) {
            let [mean, first] = torque.moments([self.time, self.time + h]);
            self.moments = [self.moments[0] + mean, self.moments[1] + first];
            axpy(mean / h, row, &mut self.on_modes[0]);
            axpy(12.0 * first / (h * h), row, &mut self.on_modes[1]);
        }
    }

    /// Change of the spin over the step by (2) \[rad/s\], and (3) \[rad\].
    pub fn turn(&self) -> [f64; 2] {
        [self.moments[0] / self.inertia, -self.moments[1] / self.inertia]
    }

    /// Ends a step of `h` \[s\] with the mean spin \[rad/s\] and the work of (4) \[J\].
    pub fn finish_step(&mut self, h: f64, speed: f64, on_modes: f64) {
        self.work += self.moments[0] * speed + on_modes;
        self.time += h;
    }
}
