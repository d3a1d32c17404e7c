//! The modes of twist over a step: set out free, struck by impulses at its beginning, settled with the torques over it.
//!
//! ```text
//! free     (n, n')+ = exp(B h) (n, n')                                             [`super::oscillators`]
//! settle   f = T b + sum_s M_s t_s,   (n, n')+ += g(B) (0, f)                       torques T of the brakes, M_s of the unbalances
//! damped   += sum_j f_j (n_j+ - n_j) + E(n, after impulses) - E(n+1)                 what damping takes: exact, as the motion is       (1)
//! seen     t.n, t.n'   of each unbalance's row t, and of b
//! ```
//! One pass over the modes each; all lists have a multiple of eight entries. (1) is (5) of [`super::spin`], its works summed mode by mode. Verified by
//! `what_damping_takes_is_what_is_missing` and the energy balances of `tests/exponential_run.rs`.

use super::oscillators::{Eight, OscillatorStep, Oscillators};
use crate::linalg::lanes::{LANES, kernel, sum};

/// Modes of twist under way.
#[derive(Debug, Clone)]
pub(super) struct Twist {
    pub modes: Oscillators,
    /// w^2 of each.
    pub squares: Vec<f64>,
    /// Places and rates at the beginning of the step, after impulses there.
    begun: [Vec<f64>; 2],
    /// Rows of the unbalances, one after the other, and that of the brakes.
    rows: Vec<f64>,
    shift: Vec<f64>,
}

impl Twist {
    /// At rest, of modes `(w^2, c)` \[1/s2, 1/s\].
    pub fn new(modes: &[(f64, f64)], rows: Vec<f64>, shift: Vec<f64>) -> Self {
        let zeros = vec![0.0; modes.len()];
        Self {
            modes: Oscillators::new(modes.iter().copied()),
            squares: modes.iter().map(|mode| mode.0).collect(),
            begun: [zeros.clone(), zeros],
            rows,
            shift,
        }
    }

    /// The row of an unbalance.
    pub fn row(&self, s: usize) -> &[f64] {
        let count = self.squares.len();
        &self.rows[s * count..(s + 1) * count]
    }

    /// Goes to n+1 as if nothing acted; the unbalances' turns there and the rates of those.
    pub fn set_out(&mut self, step: &OscillatorStep, seen: &mut [[f64; 2]]) {
        let Self { modes, begun: [place, rate], rows, .. } = self;
        std::mem::swap(place, &mut modes.place);
        std::mem::swap(rate, &mut modes.rate);
        set_out(&step.eights, [place, rate], &mut modes.place, &mut modes.rate, rows, seen);
    }

    /// Adds an impulse along a row at the beginning of the step, between [`Twist::set_out`] and [`Twist::settle`].
    pub fn strike(&mut self, step: &OscillatorStep, impulse: f64, row: &[f64]) {
        let Self { modes, begun: [_, begun], .. } = self;
        strike(&step.eights, impulse, row, begun, &mut modes.place, &mut modes.rate);
    }

    /// Adds the torques of brakes and unbalances over the step. Gives what damping has taken \[J\] and `b.n, b.n'` at its end, and the unbalances' turns there with their rates.
    pub fn settle(&mut self, step: &OscillatorStep, torques: (f64, &[f64]), seen: &mut [[f64; 2]]) -> [f64; 3] {
        let Self { modes, squares, begun: [place, rate], rows, shift } = self;
        let begun = [place.as_slice(), rate];
        settle(&step.eights, torques, begun, [squares, shift, rows], &mut modes.place, &mut modes.rate, seen)
    }

    /// Turn along a row, and its rate.
    pub fn along(&self, row: &[f64]) -> [f64; 2] {
        along(row, &self.modes.place, &self.modes.rate)
    }
}

/// Products of a row with places and rates; inside a kernel.
#[inline(always)]
fn along_inline(row: &[f64], place: &[f64], rate: &[f64]) -> [f64; 2] {
    let mut sums = [[0.0; LANES]; 2];
    let modes = place.as_chunks::<LANES>().0.iter().zip(rate.as_chunks::<LANES>().0);
    for (row, (place, rate)) in row.as_chunks::<LANES>().0.iter().zip(modes) {
        for k in 0..LANES {
            sums[0][k] += row[k] * place[k];
        }
        for k in 0..LANES {
            sums[1][k] += row[k] * rate[k];
        }
    }
    [sum(sums[0]), sum(sums[1])]
}

kernel! {
    fn along(row: &[f64], place: &[f64], rate: &[f64]) -> [f64; 2] {
        along_inline(row, place, rate)
    }
}

kernel! {
    fn set_out(
        step: &[Eight],
        from: [&[f64]; 2],
        place: &mut [f64],
        rate: &mut [f64],
        rows: &[f64],
        seen: &mut [[f64; 2]],
    ) {
        let before = from[0].as_chunks::<LANES>().0.iter().zip(from[1].as_chunks::<LANES>().0);
        let after = place.as_chunks_mut::<LANES>().0.iter_mut().zip(rate.as_chunks_mut::<LANES>().0);
        for (eight, ((n, v), (place, rate))) in step.iter().zip(before.zip(after)) {
            [*place, *rate] = eight.after(n, v);
        }
        if place.is_empty() {
            return;
        }
        for (seen, row) in seen.iter_mut().zip(rows.chunks_exact(place.len())) {
            *seen = along_inline(row, place, rate);
        }
    }
}

kernel! {
    fn strike(step: &[Eight], impulse: f64, row: &[f64], begun: &mut [f64], place: &mut [f64], rate: &mut [f64]) {
        let after = place.as_chunks_mut::<LANES>().0.iter_mut().zip(rate.as_chunks_mut::<LANES>().0);
        let modes = begun.as_chunks_mut::<LANES>().0.iter_mut().zip(after);
        for ((eight, row), (begun, (place, rate))) in step.iter().zip(row.as_chunks::<LANES>().0).zip(modes) {
            for k in 0..LANES {
                let jump = impulse * row[k];
                begun[k] += jump;
                place[k] += eight.free[1].0[k] * jump;
                rate[k] += eight.free[3].0[k] * jump;
            }
        }
    }
}

kernel! {
    fn settle(
        step: &[Eight],
        torques: (f64, &[f64]),
        begun: [&[f64]; 2],
        fixed: [&[f64]; 3],
        place: &mut [f64],
        rate: &mut [f64],
        seen: &mut [[f64; 2]],
    ) -> [f64; 3] {
        let (brake, torques) = torques;
        let [squares, shift, rows] = fixed;
        let count = place.len();
        let eights = count / LANES;
        let step = &step[..eights];
        let [n, v, squares, b] = [begun[0], begun[1], squares, shift].map(|list| &list.as_chunks::<LANES>().0[..eights]);
        let rate = &mut rate[..count];
        let rows = &rows[..torques.len() * count];
        let mut sums = [[0.0; LANES]; 3];
        {
            let place = &mut place.as_chunks_mut::<LANES>().0[..eights];
            let rate = &mut rate.as_chunks_mut::<LANES>().0[..eights];
            for i in 0..eights {
                let mut force = [0.0; LANES];
                for k in 0..LANES {
                    force[k] = brake * b[i][k];
                }
                for (s, torque) in torques.iter().enumerate() {
                    let Some(row) = rows[s * count + LANES * i..].first_chunk::<LANES>() else { break };
                    for k in 0..LANES {
                        force[k] += torque * row[k];
                    }
                }
                let [of_place, of_rate] = &step[i].force;
                let (mut m, mut w) = (place[i], rate[i]);
                for k in 0..LANES {
                    m[k] += of_place.0[k] * force[k];
                    w[k] += of_rate.0[k] * force[k];
                }
                (place[i], rate[i]) = (m, w);
                for k in 0..LANES {
                    let (moved, mean) = (m[k] - n[i][k], 0.5 * (m[k] + n[i][k]));
                    let slowed = 0.5 * ((v[i][k] - w[k]) * (v[i][k] + w[k]));
                    sums[0][k] += moved * (force[k] - squares[i][k] * mean) + slowed;
                }
                for k in 0..LANES {
                    sums[1][k] += b[i][k] * m[k];
                }
                for k in 0..LANES {
                    sums[2][k] += b[i][k] * w[k];
                }
            }
        }
        if count > 0 {
            for (seen, row) in seen.iter_mut().zip(rows.chunks_exact(count)) {
                *seen = along_inline(row, place, rate);
            }
        }
        sums.map(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight modes, damped and not, under torques and a blow: (1) is nothing of those without damping, and of all what the energy lacks.
    #[test]
    fn what_damping_takes_is_what_is_missing() {
        for damping in [0.0, 3.0] {
            let modes: Vec<(f64, f64)> = (1..=8).map(|j| (f64::from(j * j) * 100.0, damping)).collect();
            let row: Vec<f64> = (0..8).map(|j| 0.5 - 0.2 * f64::from(j)).collect();
            let shift: Vec<f64> = (0..8).map(|j| 0.1 * f64::from(j) - 0.3).collect();
            let mut twist = Twist::new(&modes, row.clone(), shift.clone());
            let step = twist.modes.step(0.02);
            let energy = |twist: &Twist| -> f64 {
                let modes = twist.modes.place.iter().zip(&twist.modes.rate).zip(&twist.squares);
                modes.map(|((n, v), square)| 0.5 * (v * v + square * n * n)).sum()
            };
            let (mut put_in, mut taken) = (0.0, 0.0);
            for n in 0..50 {
                let mut seen = [[0.0; 2]];
                let before = twist.clone();
                twist.set_out(&step, &mut seen);
                let blow = if n % 7 == 0 { 1.3 } else { 0.0 };
                twist.strike(&step, blow, &row);
                let own: f64 = row.iter().map(|part| part * part).sum();
                put_in += blow * (before.along(&row)[1] + 0.5 * blow * own);
                let (brake, torque) = (-2.0, 4.0 * libm::sin(0.3 * f64::from(n)));
                let [lost, b, b_rate] = twist.settle(&step, (brake, &[torque]), &mut seen);
                taken += lost;
                put_in += torque * (twist.along(&row)[0] - before.along(&row)[0]);
                put_in += brake * (twist.along(&shift)[0] - before.along(&shift)[0]);
                assert!((seen[0][0] - twist.along(&row)[0]).abs() < 1e-15);
                assert!((b - twist.along(&shift)[0]).abs() < 1e-15 && (b_rate - twist.along(&shift)[1]).abs() < 1e-15);
            }
            assert!((put_in - energy(&twist) - taken).abs() < 1e-11, "{damping}: {put_in} {taken}");
            assert!(if damping > 0.0 { taken > 0.1 } else { taken.abs() < 1e-11 }, "{damping}: {taken}");
        }
    }
}
