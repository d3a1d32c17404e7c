//! Contact forces at several coupled points.
//!
//! ```text
//! g_k = g0_k + sum_j (W_nn_kj lambda_j + W_nt_kj lambda_T_j),   s_k = s0_k + sum_j (W_tn_kj lambda_j + W_tt_kj lambda_T_j)    (1)
//! lambda_k >= 0, g_k >= 0, lambda_k g_k = 0;   |lambda_T_k| <= mu lambda_k;   s_k = 0 or lambda_T_k = mu lambda_k sign(s_k)
//! ```
//! Pivoting on the states of the points (`pivoting`) almost always finds the forces in a few small solves. If it cycles, Lemke's method solves the
//! same conditions. (Block Gauss-Seidel takes thousands of rounds, because close points are almost identical.)
//! Source: the conditions as in [`crate::contact`]. Verified by `the_laws_hold_at_every_point`, `points_that_are_one_share_a_force`.

mod conditions;
mod lemke;
mod linear;
mod pivoting;

pub(crate) use conditions::{Block, Coupled, POINTS};

use crate::contact::ContactReaction;
use linear::complementary;
use pivoting::{pivot, slides_on};

/// Additional compliance of each point, as a share of its own entry of W. It makes the forces of nearly identical points unique. Larger shares are
/// used only if rounding prevents a solution with a smaller one.
const YIELDS: [f64; 3] = [1e-5, 1e-4, 1e-3];

/// Finds forces that satisfy the conditions, starting from the present ones; `None` if neither method finds a solution.
pub(crate) fn solve(coupled: &mut Coupled, forces: &mut [ContactReaction]) -> Option<()> {
    if let [force] = forces
        && let Some(found) = slides_on(coupled, 1.0 + YIELDS[0], force)
    {
        *force = found;
        return Some(());
    }
    match forces.len() {
        0..=1 => solve_of::<1, 2>(coupled, forces),
        2 => solve_of::<2, 4>(coupled, forces),
        3..=4 => solve_of::<4, 8>(coupled, forces),
        5..=8 => solve_of::<8, 16>(coupled, forces),
        9..=12 => solve_of::<12, 24>(coupled, forces),
        _ => solve_of::<POINTS, { 2 * POINTS }>(coupled, forces),
    }
}

/// Finds forces for at most P points and U = 2 P unknowns.
fn solve_of<const P: usize, const U: usize>(coupled: &mut Coupled, forces: &mut [ContactReaction]) -> Option<()> {
    let mut stiff = [[[0.0; 2]; 2]; P];
    for (k, own) in stiff[..forces.len()].iter_mut().enumerate() {
        *own = coupled.w[k][k];
    }
    for yields in YIELDS {
        for (k, own) in stiff[..forces.len()].iter().enumerate() {
            for row in 0..2 {
                coupled.w[k][k][row][row] = (1.0 + yields) * own[row][row];
            }
        }
        if pivot::<P, U>(coupled, forces).or_else(|| complementary(coupled, forces)).is_some() {
            return Some(());
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::FrictionLaw;
    use proptest::prelude::*;

    /// Points on a structure of unit springs: rows of gap and of (minus) slip, as responses to the same unknowns.
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

    /// Largest violation of the conditions (1), relative to the largest gap, slip and force.
    fn violation(coupled: &Coupled, forces: &[ContactReaction]) -> f64 {
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
                    // sliding: along the slip and on the friction cone; sticking: no slip
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
            let mut forces = vec![ContactReaction::NONE; rows.len()];
            prop_assert!(solve(&mut pressed, &mut forces).is_some());
            let touches = start.iter().any(|start| start[0] < 0.0);
            prop_assert_eq!(touches, forces.iter().any(|force| force.normal > 0.0), "contact");
            prop_assert!(violation(&pressed, &forces) < 1e-8, "{:?} {:e}", forces, violation(&pressed, &forces));
            if touches {
                let mut by_lemke = vec![ContactReaction::NONE; rows.len()];
                prop_assert!(complementary(&pressed, &mut by_lemke).is_some());
                prop_assert!(violation(&pressed, &by_lemke) < 1e-8);
            }
        }

        #[test]
        fn one_point_that_slides_on_is_what_pivoting_finds((rows, start) in points(), friction in 0.0..0.8f64, sign in proptest::bool::ANY, slips in proptest::bool::ANY) {
            let law = if slips { FrictionLaw::Slip } else { FrictionLaw::StickSlip };
            let mut one = coupled(&rows[..1], &[[-start[0][0].abs(), start[0][1]]], friction, law);
            let last = ContactReaction { normal: 1.0, tangential: if sign { friction } else { -friction }, sticks: false };
            let found = slides_on(&one, 1.0 + YIELDS[0], &last);
            for row in 0..2 {
                one.w[0][0][row][row] *= 1.0 + YIELDS[0];
            }
            let mut forces = [last];
            prop_assert!(pivot::<1, 2>(&one, &mut forces).is_some());
            if let Some(found) = found {
                prop_assert_eq!(found.normal.to_bits(), forces[0].normal.to_bits());
                prop_assert_eq!(found.tangential.to_bits(), forces[0].tangential.to_bits());
                prop_assert!(found.normal > 0.0 && !forces[0].sticks);
            } else {
                prop_assert!(forces[0].sticks || forces[0].tangential.signum() != last.tangential.signum() || forces[0].normal == 0.0);
            }
        }

        #[test]
        fn sliding_one_way_holds_its_laws((rows, start) in points(), friction in 0.0..0.05f64) {
            let mut pressed = coupled(&rows, &start, friction, FrictionLaw::Slip);
            let mut forces = vec![ContactReaction::NONE; rows.len()];
            prop_assert!(solve(&mut pressed, &mut forces).is_some());
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
            let mut forces = vec![ContactReaction::NONE; rows.len()];
            prop_assert!(solve(&mut twice, &mut forces).is_some());
            prop_assert!(violation(&twice, &forces) < 1e-7, "{:e}", violation(&twice, &forces));
            if alone.len() == 1 {
                let mut once = coupled(&alone, &alone_start, friction, FrictionLaw::StickSlip);
                let mut force = [ContactReaction::NONE];
                prop_assert!(solve(&mut once, &mut force).is_some());
                let sum = forces[0].normal + forces[1].normal;
                prop_assert!(force[0].normal > 0.0 && (sum / force[0].normal - 1.0).abs() < 10.0 * apart + 1e-4);
            }
        }
    }
}
