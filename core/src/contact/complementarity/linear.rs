//! Contact conditions of several points as one linear complementarity problem.

use super::conditions::Coupled;
use super::lemke::lemke;
use crate::contact::ContactReaction;
use bladeoff_model::machine::FrictionLaw;

/// Solves the conditions as one linear complementarity problem, with friction `lambda_T = b+ - b-` and sigma the magnitude of the slip:
/// ```text
/// 0 <= lambda _|_ g >= 0,   0 <= b+ _|_ sigma - s >= 0,   0 <= b- _|_ sigma + s >= 0,   0 <= sigma _|_ mu lambda - b+ - b- >= 0
/// ```
/// If W is definite, the matrix of the problem is copositive, and a solution exists (Stewart and Trinkle 1996, Anitescu and Potra 1997).
pub(super) fn complementary(coupled: &Coupled, forces: &mut [ContactReaction]) -> Option<()> {
    let count = forces.len();
    let stick_slip = coupled.law == FrictionLaw::StickSlip;
    let size = if stick_slip { 4 * count } else { count };
    let length = coupled.start[..count].iter().flatten().fold(0.0_f64, |most, start| most.max(start.abs()));
    let compliance = (0..count).map(|k| coupled.w[k][k][0][0]).fold(0.0, f64::max);
    let force = length / compliance;
    let (mut m, mut q) = (vec![0.0; size * size], vec![0.0; size]);
    for k in 0..count {
        q[k] = coupled.start[k][0] / length;
        for j in 0..count {
            let [[nn, nt], [tn, tt]] = coupled.w[k][j].map(|row| row.map(|entry| entry / compliance));
            if !stick_slip {
                m[k * size + j] = nn + coupled.friction * coupled.sign * nt;
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
            q[plus] = -coupled.start[k][1] / length;
            q[minus] = coupled.start[k][1] / length;
            m[plus * size + size_of_slip] = 1.0;
            m[minus * size + size_of_slip] = 1.0;
            m[size_of_slip * size + k] = coupled.friction;
            m[size_of_slip * size + plus] = -1.0;
            m[size_of_slip * size + minus] = -1.0;
        }
    }
    let z = lemke(&m, &q)?;
    for k in 0..count {
        let normal = force * z[k];
        forces[k] = if stick_slip {
            let tangential = force * (z[count + k] - z[2 * count + k]);
            ContactReaction { normal, tangential, sticks: normal > 0.0 && z[3 * count + k] == 0.0 }
        } else {
            ContactReaction { normal, tangential: coupled.friction * coupled.sign * normal, sticks: false }
        };
    }
    Some(())
}
