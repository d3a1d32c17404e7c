//! Forces of several coupled contact points.
//!
//! ```text
//! g_k = g0_k + sum_j (W_nn_kj lambda_j + W_nt_kj lambda_T_j),   s_k = s0_k + sum_j (W_tn_kj lambda_j + W_tt_kj lambda_T_j)    (1)
//! lambda_k >= 0, g_k >= 0, lambda_k g_k = 0;   |lambda_T_k| <= mu lambda_k;   s_k = 0 or lambda_T_k = mu lambda_k sign(s_k)
//! ```
//! Pivoting on the points' states (`pivoting`) finds them in a few small solves, nearly always; where it goes in circles, Lemke's
//! method on the same conditions does. (Block Gauss-Seidel takes thousands of rounds: close points are nearly one.)
//! Source: the conditions as in [`crate::contact`]. Verified by `the_laws_hold_at_every_point`, `points_that_are_one_share_a_force`.

use super::lemke::lemke;
use crate::contact::ContactForce;
use bladeoff_model::machine::FrictionLaw;

/// Contact points of a ring at most.
pub(super) const POINTS: usize = 16;
/// Compliance of a point's own, as a share of the structures' there: points that are nearly one share their force in one way.
/// More of it only where less leaves a system that rounding does not solve.
const YIELDS: [f64; 3] = [1e-5, 1e-4, 1e-3];

/// Gap and slip at one point by a unit normal and a unit tangential force at another \[m/N\].
pub(super) type Block = [[f64; 2]; 2];

/// The conditions (1) of as many points as forces are asked for.
pub(super) struct Coupled {
    pub w: [[Block; POINTS]; POINTS],
    /// Gap and slip without forces \[m\].
    pub start: [[f64; 2]; POINTS],
    pub friction: f64,
    pub law: FrictionLaw,
    /// Slip direction of [`FrictionLaw::Slip`].
    pub sign: f64,
}

impl Coupled {
    /// Forces that satisfy the conditions, from those that are there; `None` where neither way finds any.
    pub fn solve(&mut self, forces: &mut [ContactForce]) -> Option<()> {
        let stiff: [_; POINTS] = std::array::from_fn(|k| self.w[k][k]);
        for yields in YIELDS {
            for (k, own) in stiff.iter().enumerate() {
                for row in 0..2 {
                    self.w[k][k][row][row] = (1.0 + yields) * own[row][row];
                }
            }
            if self.pivot(forces).or_else(|| self.complementary(forces)).is_some() {
                return Some(());
            }
        }
        None
    }

    /// Gap and slip at a point under all forces \[m\].
    pub(super) fn moved(&self, k: usize, forces: &[[f64; 2]]) -> [f64; 2] {
        let [mut gap, mut slip] = self.start[k];
        for (block, [normal, tangential]) in self.w[k].iter().zip(forces) {
            gap += block[0][0] * normal + block[0][1] * tangential;
            slip += block[1][0] * normal + block[1][1] * tangential;
        }
        [gap, slip]
    }

    /// The conditions as one linear complementarity problem, friction `lambda_T = b+ - b-` and sigma the size of the slip:
    /// ```text
    /// 0 <= lambda _|_ g >= 0,   0 <= b+ _|_ sigma - s >= 0,   0 <= b- _|_ sigma + s >= 0,   0 <= sigma _|_ mu lambda - b+ - b- >= 0
    /// ```
    /// W being definite, its matrix is copositive and it has a solution (Stewart and Trinkle 1996, Anitescu and Potra 1997).
    fn complementary(&self, forces: &mut [ContactForce]) -> Option<()> {
        let count = forces.len();
        let stick_slip = self.law == FrictionLaw::StickSlip;
        let size = if stick_slip { 4 * count } else { count };
        let length = self.start[..count].iter().flatten().fold(0.0_f64, |most, start| most.max(start.abs()));
        let compliance = (0..count).map(|k| self.w[k][k][0][0]).fold(0.0, f64::max);
        let force = length / compliance;
        let (mut m, mut q) = (vec![0.0; size * size], vec![0.0; size]);
        for k in 0..count {
            q[k] = self.start[k][0] / length;
            for j in 0..count {
                let [[nn, nt], [tn, tt]] = self.w[k][j].map(|row| row.map(|entry| entry / compliance));
                if !stick_slip {
                    m[k * size + j] = nn + self.friction * self.sign * nt;
                    continue;
                }
                let (plus, minus) = (count + k, 2 * count + k);
                for (row, [by_normal, by_tangential]) in [(k, [nn, nt]), (plus, [-tn, -tt]), (minus, [tn, tt])] {
                    m[row * size + j] = by_normal;
                    m[row * size + count + j] = by_tangential;
                    m[row * size + 2 * count + j] = -by_tangential;
                }
            }
            if stick_slip {
                let (plus, minus, size_of_slip) = (count + k, 2 * count + k, 3 * count + k);
                q[plus] = -self.start[k][1] / length;
                q[minus] = self.start[k][1] / length;
                m[plus * size + size_of_slip] = 1.0;
                m[minus * size + size_of_slip] = 1.0;
                m[size_of_slip * size + k] = self.friction;
                m[size_of_slip * size + plus] = -1.0;
                m[size_of_slip * size + minus] = -1.0;
            }
        }
        let z = lemke(&m, &q)?;
        for k in 0..count {
            let normal = force * z[k];
            forces[k] = if stick_slip {
                let tangential = force * (z[count + k] - z[2 * count + k]);
                ContactForce { normal, tangential, sticks: normal > 0.0 && z[3 * count + k] == 0.0 }
            } else {
                ContactForce { normal, tangential: self.friction * self.sign * normal, sticks: false }
            };
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Points on a structure of unit springs: rows of gap and of (minus) slip, as responses to as many unknowns.
    fn coupled(rows: &[[Vec<f64>; 2]], start: &[[f64; 2]], friction: f64, law: FrictionLaw) -> Coupled {
        let mut coupled = Coupled { w: Default::default(), start: [[0.0; 2]; POINTS], friction, law, sign: 1.0 };
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for (k, [n, t]) in rows.iter().enumerate() {
            coupled.start[k] = start[k];
            for (j, [other_n, other_t]) in rows.iter().enumerate() {
                coupled.w[k][j] =
                    [[product(n, other_n), product(n, other_t)], [-product(t, other_n), -product(t, other_t)]];
            }
        }
        coupled
    }

    /// The largest violation of the conditions (1), relative to the largest gap, slip and force.
    fn violation(coupled: &Coupled, forces: &[ContactForce]) -> f64 {
        let plain: Vec<[f64; 2]> = forces.iter().map(|force| [force.normal, force.tangential]).collect();
        let most = forces.iter().fold(1e-300_f64, |most, force| most.max(force.normal));
        let mut worst = 0.0_f64;
        for (k, force) in forces.iter().enumerate() {
            let [gap, slip] = coupled.moved(k, &plain);
            let (share, grip) = (force.normal / most, coupled.friction * force.normal);
            worst = worst.max(-gap).max(-share).max((gap * share).abs());
            let dragged = match coupled.law {
                FrictionLaw::Slip => (force.tangential - coupled.sign * grip).abs() / most,
                FrictionLaw::StickSlip => {
                    let outside = (force.tangential.abs() - grip) / most;
                    // slides: along the slip and on the cone; sticks: no slip
                    outside.max((grip - slip.signum() * force.tangential) / most * slip.abs().min(1.0))
                }
            };
            worst = worst.max(dragged);
        }
        worst
    }

    fn points() -> impl Strategy<Value = (Vec<[Vec<f64>; 2]>, Vec<[f64; 2]>)> {
        let row = || proptest::collection::vec(-1.0..1.0f64, 24);
        (1usize..=8).prop_flat_map(move |count| {
            let rows = proptest::collection::vec((row(), row()).prop_map(|(n, t)| [n, t]), count);
            let start = proptest::collection::vec((-1.0..0.3f64, -1.0..1.0f64).prop_map(|(g, s)| [g, s]), count);
            (rows, start)
        })
    }

    proptest! {
        #[test]
        fn the_laws_hold_at_every_point((rows, start) in points(), friction in 0.0..0.8f64) {
            let mut pressed = coupled(&rows, &start, friction, FrictionLaw::StickSlip);
            let mut forces = vec![ContactForce::NONE; rows.len()];
            prop_assert!(pressed.solve(&mut forces).is_some());
            let touches = start.iter().any(|start| start[0] < 0.0);
            prop_assert_eq!(touches, forces.iter().any(|force| force.normal > 0.0), "contact");
            prop_assert!(violation(&pressed, &forces) < 1e-8, "{:?} {:e}", forces, violation(&pressed, &forces));
            if touches {
                let mut by_lemke = vec![ContactForce::NONE; rows.len()];
                prop_assert!(pressed.complementary(&mut by_lemke).is_some());
                prop_assert!(violation(&pressed, &by_lemke) < 1e-8);
            }
        }

        #[test]
        fn sliding_one_way_holds_its_laws((rows, start) in points(), friction in 0.0..0.05f64) {
            let mut pressed = coupled(&rows, &start, friction, FrictionLaw::Slip);
            let mut forces = vec![ContactForce::NONE; rows.len()];
            prop_assert!(pressed.solve(&mut forces).is_some());
            prop_assert!(violation(&pressed, &forces) < 1e-8);
        }

        #[test]
        fn points_that_are_one_share_a_force((rows, start) in points(), friction in 0.0..0.8f64, apart in 1e-9..1e-3f64) {
            let (mut rows, mut start) = (rows, start);
            start[0][0] = -1.0;
            let mut beside = rows[0].clone();
            for (entry, other) in beside.iter_mut().flatten().zip(rows[rows.len() - 1].clone().into_iter().flatten()) {
                *entry += apart * other;
            }
            let (alone, alone_start) = (rows.clone(), start.clone());
            rows.push(beside);
            start.push(start[0]);
            let mut twice = coupled(&rows, &start, friction, FrictionLaw::StickSlip);
            let mut forces = vec![ContactForce::NONE; rows.len()];
            prop_assert!(twice.solve(&mut forces).is_some());
            prop_assert!(violation(&twice, &forces) < 1e-7, "{:e}", violation(&twice, &forces));
            if alone.len() == 1 {
                let mut once = coupled(&alone, &alone_start, friction, FrictionLaw::StickSlip);
                let mut force = [ContactForce::NONE];
                prop_assert!(once.solve(&mut force).is_some());
                let sum = forces[0].normal + forces[1].normal;
                prop_assert!(force[0].normal > 0.0 && (sum / force[0].normal - 1.0).abs() < 10.0 * apart + 1e-4);
            }
        }
    }
}
