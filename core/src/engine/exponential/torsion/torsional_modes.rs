//! The modes of twist over a step: set out free, struck by an impulse at its beginning, settled with the torques over it.
//!
//! ```text
//! free      (n, n')+ = exp(B h) (n, n')                                             [`super::oscillators`]
//! strike    (n, n')+ += exp(B h) (0, J t)                                            J angular impulse on the first diaphragm's node
//! settle    (n, n')+ += g(B) (0, f),   f = sum_r M_r t_r                              torques of the unbalances and of the brakes
//! seen      s_r = t_r.n, t_r.n'    of all rows, free; what blows and torques add to them is a table                                  (1)
//! put in    += J (s'(n) + J t.t/2) + sum_r M_r (s_r(n+1) - s_r(n))                    works, so damping has taken  put in - E(n)       (2)
//! foreseen  seen + response of the resolved modes to the torques of the last step                           (3)
//! ```
//! Rows `t_r`: those of the unbalances, that of the brakes, and that of the first diaphragm's node, where there is one. All of it is exact, as the motion is; (2) is (5) of
//! [`super::spin`], summed. Parts of the kernels of [`super::motion`]; lists have a multiple of eight entries. Verified by
//! `what_damping_takes_is_what_is_missing`, `a_steady_train_of_blows_makes_the_static_turn` and the energy balances of `tests/exponential_run.rs`.

use super::oscillators::{OscillatorLanes, OscillatorStep};
use crate::engine::exponential::modal::plane_block::SplitBlock;
use crate::linalg::dot;
use crate::linalg::lanes::{LANES, Lane};

/// Rows that are seen together.
const HALF: usize = LANES / 2;

/// The step resolves a mode where `(w h)^2` is less.
const RESOLVED: f64 = 1.0;

/// Modes of twist under way.
#[derive(Debug, Clone)]
pub(crate) struct TorsionalModes {
    blocks: Vec<SplitBlock>,
    /// w^2 of each.
    squares: Vec<f64>,
    displacement: Vec<f64>,
    rate: Vec<f64>,
    /// One row after the other, and how many of them torques act along; a blow acts along the one behind those.
    rows: Vec<f64>,
    acting: usize,
    /// Entries of four rows after four, mode by mode.
    fours: Vec<[f64; HALF]>,
    /// (1), turns and rates of four rows after four, and that at the beginning of the step.
    seen: Vec<Lane>,
    before: Vec<Lane>,
    /// Parts of the turns and rates that the last torques make (3).
    held: Vec<Lane>,
    /// Torques over the step, along the rows.
    torques: Vec<f64>,
    /// Torques over the step on the modes themselves, and the amplitudes at its beginning; empty where there are no such torques.
    added_torques: Vec<f64>,
    begun: Vec<f64>,
    /// (2) \[J\], and t.t of the blow's row.
    work: f64,
    own: f64,
}

/// What a step size makes of it.
#[derive(Debug, Clone)]
pub(crate) struct TorsionalStep {
    modes: OscillatorStep,
    /// What unit torques along each row, and a blow behind those, make of (1).
    impulse_outputs: Vec<Lane>,
    /// The change of (1) by unit torques along each row in the resolved modes alone, one group of four rows after the other.
    resolved: Vec<Lane>,
}

impl TorsionalModes {
    /// At rest, of modes `(w^2, c)` \[1/s2, 1/s\] and rows along the first of which torques act.
    pub fn new(modes: &[(f64, f64)], rows: &[Vec<f64>], acting: usize) -> Self {
        let count = modes.len();
        let at = |r: usize, j: usize| rows.get(r).map_or(0.0, |row| row[j]);
        let groups = (0..rows.len()).step_by(HALF);
        let fours = groups.flat_map(|first| (0..count).map(move |j| std::array::from_fn(|k| at(first + k, j))));
        let (zeros, seen) = (vec![0.0; count], vec![Lane::default(); rows.len().div_ceil(HALF)]);
        Self {
            blocks: modes.iter().map(|(square, damping)| SplitBlock::of(&[0.0, 1.0, -square, -damping])).collect(),
            squares: modes.iter().map(|mode| mode.0).collect(),
            displacement: zeros.clone(),
            rate: zeros,
            fours: fours.collect(),
            rows: rows.concat(),
            acting,
            before: seen.clone(),
            held: seen.clone(),
            seen,
            torques: vec![0.0; acting],
            added_torques: Vec::new(),
            begun: Vec::new(),
            work: 0.0,
            own: rows.get(acting).map_or(0.0, |row| dot(row, row)),
        }
    }

    /// Takes another damping of its modes \[1/s\].
    pub fn damp(&mut self, modes: &[(f64, f64)]) {
        self.blocks = modes.iter().map(|(square, damping)| SplitBlock::of(&[0.0, 1.0, -square, -damping])).collect();
    }

    /// Tables of a step of `h` \[s\].
    pub fn step(&self, h: f64) -> TorsionalStep {
        let modes = OscillatorStep::new(&self.blocks, h);
        let of = |eight: &OscillatorLanes, along: usize, rate: usize| match along < self.acting {
            true => eight.force[rate],
            false => eight.free[1 + 2 * rate],
        };
        let groups = self.seen.len();
        let table = |rows: usize, highest: f64| -> Vec<Lane> {
            let made = |along: usize, r: usize, rate: usize| -> f64 {
                let lanes = modes.lanes.iter().flat_map(|eight| of(eight, along, rate).0).zip(&self.squares);
                let rows = self.row(along).iter().zip(self.row(r));
                let kept = lanes.zip(rows).filter(|((_, square), _)| **square * h * h < highest);
                kept.map(|((made, _), (along, row))| made * along * row).sum()
            };
            let lane = |along: usize, group: usize| {
                Lane(std::array::from_fn(|k| made(along, HALF * group + k % HALF, k / HALF)))
            };
            let places = (0..rows).flat_map(|along| (0..groups).map(move |group| (along, group)));
            places.map(|(along, group)| lane(along, group)).collect()
        };
        let (makes, resolved) = (table(HALF * groups, f64::INFINITY), table(self.acting, RESOLVED));
        let by_group = (0..groups).flat_map(|group| (0..self.acting).map(move |along| along * groups + group));
        TorsionalStep { impulse_outputs: makes, resolved: by_group.map(|at| resolved[at]).collect(), modes }
    }

    /// What trains of blows over steps of `h` \[s\] lack of the static turn of each mode at n, per angular impulse: as [`super::kicked_ring`] has it of the ring. Of modes that turn by half a turn and more over a
    /// step a train makes nothing there.
    pub fn static_correction(&self, h: f64) -> Vec<f64> {
        let of = |(block, square): (&SplitBlock, &f64)| {
            let [a, b, c, d] = block.exponential(h);
            let resolved = square * h * h < std::f64::consts::PI.powi(2);
            // (1 - exp(B h))^-1 exp(B h) (0, 1)
            let determinant = (1.0 - a) * (1.0 - d) - b * c;
            let train = if resolved { ((1.0 - d) * b + b * d) / determinant } else { 0.0 };
            1.0 / (square * h) - train
        };
        let modes = self.blocks.iter().zip(&self.squares).map(of);
        // behind the last mode there are zeros
        modes.zip(self.row(self.acting)).map(|(lacks, &row)| if row == 0.0 { 0.0 } else { lacks * row }).collect()
    }

    /// A row; none where there are no more.
    pub fn row(&self, r: usize) -> &[f64] {
        self.rows.chunks_exact(self.displacement.len().max(1)).nth(r).unwrap_or_default()
    }

    /// Turn along any row.
    pub fn along(&self, row: &[f64]) -> f64 {
        dot(row, &self.displacement)
    }

    /// Amplitudes of the modes.
    pub fn displacement(&self) -> &[f64] {
        &self.displacement
    }

    /// Turn along one of the rows, and its rate: at n, after [`Twist::set_out`] those foreseen for n+1.
    #[inline(always)]
    pub fn at_row(&self, r: usize) -> [f64; 2] {
        let lane = &self.seen[r / HALF].0;
        [lane[r % HALF], lane[HALF + r % HALF]]
    }

    /// Turn along one of the rows, and its rate, expected at n+1: the free motion with (3); after [`Twist::set_out`].
    #[inline(always)]
    pub fn predicted_at_row(&self, r: usize) -> [f64; 2] {
        let ([turn, rate], held) = (self.at_row(r), &self.held[r / HALF].0);
        [turn + held[r % HALF], rate + held[HALF + r % HALF]]
    }

    /// The turn that a unit blow makes along its own row.
    pub fn impulse_compliance(&self, step: &TorsionalStep) -> f64 {
        step.impulse_outputs[self.acting * self.seen.len() + self.acting / HALF].0[self.acting % HALF]
    }

    /// The torques over the step along the rows.
    #[inline(always)]
    pub fn torques(&mut self) -> &mut [f64] {
        &mut self.torques
    }

    /// Torques over the step on the modes themselves: minus the changes of their momenta, times `over`; between [`Twist::set_out`] and [`Twist::settle`], and once before the first step.
    pub fn add_torques(&mut self, changes: &[f64], over: f64) {
        if self.begun.is_empty() {
            (self.added_torques, self.begun) = (vec![0.0; self.displacement.len()], self.displacement.clone());
        }
        self.added_torques.iter_mut().zip(changes).for_each(|(push, change)| *push = -change * over);
    }

    /// Kinetic and potential energy \[J\].
    pub fn energies(&self) -> [f64; 2] {
        let modes = self.displacement.iter().zip(&self.rate).zip(&self.squares);
        modes.fold([0.0; 2], |[kinetic, potential], ((n, v), square)| {
            [kinetic + 0.5 * v * v, potential + 0.5 * square * n * n]
        })
    }

    /// What damping has taken so far \[J\].
    pub fn damped(&self) -> f64 {
        self.work - self.energies().iter().sum::<f64>()
    }

    /// Goes to n+1 as if nothing acted.
    #[inline(always)]
    pub fn propagate_free(&mut self, step: &TorsionalStep) {
        if !self.begun.is_empty() {
            self.begun.copy_from_slice(&self.displacement);
        }
        let modes = self.displacement.as_chunks_mut::<LANES>().0.iter_mut().zip(self.rate.as_chunks_mut::<LANES>().0);
        for (eight, (place, rate)) in step.modes.lanes.iter().zip(modes) {
            [*place, *rate] = eight.after(place, rate);
        }
        std::mem::swap(&mut self.before, &mut self.seen);
        let mut fours = self.fours.as_slice();
        for seen in &mut self.seen {
            let (group, others) = fours.split_at(self.displacement.len());
            fours = others;
            // two chains: a sum has to wait for the one before it
            let mut chains = [[[0.0; HALF]; 2]; 2];
            let modes = self.displacement.as_chunks::<2>().0.iter().zip(self.rate.as_chunks::<2>().0);
            for (four, (place, rate)) in group.as_chunks::<2>().0.iter().zip(modes) {
                for i in 0..2 {
                    for k in 0..HALF {
                        chains[i][0][k] += four[i][k] * place[i];
                    }
                    for k in 0..HALF {
                        chains[i][1][k] += four[i][k] * rate[i];
                    }
                }
            }
            for k in 0..LANES {
                seen.0[k] = chains[0][k / HALF][k % HALF] + chains[1][k / HALF][k % HALF];
            }
        }
        for (held, resolved) in self.held.iter_mut().zip(step.resolved.chunks_exact(self.acting.max(1))) {
            let mut sums = [0.0; LANES];
            for (resolved, torque) in resolved.iter().zip(&self.torques) {
                for k in 0..LANES {
                    sums[k] += resolved.0[k] * torque;
                }
            }
            held.0 = sums;
        }
    }

    /// Adds an angular impulse \[N m s\] at the beginning of the step along the row behind those of torques, between [`Twist::set_out`] and [`Twist::settle`].
    #[inline(always)]
    pub fn apply_impulse(&mut self, step: &TorsionalStep, impulse: f64) {
        let (count, struck) = (self.displacement.len(), self.acting);
        let row = &self.rows[struck * count..][..count];
        let modes = self.displacement.as_chunks_mut::<LANES>().0.iter_mut().zip(self.rate.as_chunks_mut::<LANES>().0);
        for ((eight, row), (place, rate)) in step.modes.lanes.iter().zip(row.as_chunks::<LANES>().0).zip(modes) {
            // one list at a time: loops that fill two would be turned inside out
            *place = std::array::from_fn(|k| place[k] + eight.free[1].0[k] * (impulse * row[k]));
            *rate = std::array::from_fn(|k| rate[k] + eight.free[3].0[k] * (impulse * row[k]));
        }
        let rate = self.before[struck / HALF].0[HALF + struck % HALF];
        self.work += impulse * (rate + 0.5 * impulse * self.own);
        add(&step.impulse_outputs[struck * self.seen.len()..], impulse, &mut self.seen);
    }

    /// How far a row has turned over the step, after [`Twist::settle`] \[rad\].
    #[inline(always)]
    pub fn turn(&self, row: usize) -> f64 {
        self.seen[row / HALF].0[row % HALF] - self.before[row / HALF].0[row % HALF]
    }

    /// Adds the torques over the step, those of [`Twist::torques`].
    #[inline(always)]
    pub fn apply_torques(&mut self, step: &TorsionalStep) {
        let modes = self.displacement.as_chunks_mut::<LANES>().0.iter_mut().zip(self.rate.as_chunks_mut::<LANES>().0);
        let count = step.modes.lanes.len() * LANES;
        let mut pushes = self.added_torques.as_chunks::<LANES>().0.iter();
        for (i, (eight, (place, rate))) in step.modes.lanes.iter().zip(modes).enumerate() {
            let mut force = pushes.next().copied().unwrap_or_default();
            for (r, torque) in self.torques.iter().enumerate() {
                let Some(row) = self.rows[r * count + i * LANES..].first_chunk::<LANES>() else { break };
                for k in 0..LANES {
                    force[k] += torque * row[k];
                }
            }
            let [of_place, of_rate] = &eight.force;
            *place = std::array::from_fn(|k| place[k] + of_place.0[k] * force[k]);
            *rate = std::array::from_fn(|k| rate[k] + of_rate.0[k] * force[k]);
        }
        for (makes, torque) in step.impulse_outputs.chunks_exact(self.seen.len()).zip(&self.torques) {
            add(makes, *torque, &mut self.seen);
        }
        if !self.added_torques.is_empty() {
            self.evaluate_rows(step);
        }
        for (r, torque) in self.torques.iter().enumerate() {
            self.work += torque * self.turn(r);
        }
    }

    /// Adds the effect of torques on the modes themselves to (1) and (2).
    fn evaluate_rows(&mut self, step: &TorsionalStep) {
        let count = self.displacement.len();
        for (j, &push) in self.added_torques.iter().enumerate() {
            let [of_place, of_rate] = step.modes.lanes[j / LANES].force.each_ref().map(|lane| lane.0[j % LANES] * push);
            for (r, row) in self.rows.chunks_exact(count).enumerate() {
                let seen = &mut self.seen[r / HALF].0;
                seen[r % HALF] += of_place * row[j];
                seen[HALF + r % HALF] += of_rate * row[j];
            }
            self.work += push * (self.displacement[j] - self.begun[j]);
        }
    }
}

/// What so much along a row makes of (1).
#[inline(always)]
fn add(makes: &[Lane], amount: f64, seen: &mut [Lane]) {
    for (seen, makes) in seen.iter_mut().zip(makes) {
        seen.0 = std::array::from_fn(|k| seen.0[k] + makes.0[k] * amount);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight modes, damped and not, under torques and blows: (2) is nothing of those without damping; (1) is what the modes have.
    #[test]
    fn what_damping_takes_is_what_is_missing() {
        for damping in [0.0, 3.0] {
            let modes: Vec<(f64, f64)> = (1..=8).map(|j| (f64::from(j * j) * 100.0, damping)).collect();
            let row = |a: f64, b: f64| -> Vec<f64> { (0..8).map(|j| a + b * f64::from(j)).collect() };
            let rows = [row(0.5, -0.2), row(-0.3, 0.1), row(0.2, 0.05)];
            let mut twist = TorsionalModes::new(&modes, &rows, 2);
            let step = twist.step(0.02);
            let mut work = 0.0;
            for n in 0..50 {
                let before = twist.clone();
                twist.propagate_free(&step);
                let blow = if n % 7 == 0 { 1.3 } else { 0.0 };
                twist.apply_impulse(&step, blow);
                work += blow * (dot(&rows[2], &before.rate) + 0.5 * blow * dot(&rows[2], &rows[2]));
                let torques = [4.0 * libm::sin(0.3 * f64::from(n)), -2.0];
                twist.torques().copy_from_slice(&torques);
                twist.apply_torques(&step);
                for (torque, row) in torques.iter().zip(&rows) {
                    work += torque * (twist.along(row) - before.along(row));
                }
                for (r, row) in rows.iter().enumerate() {
                    assert!((twist.at_row(r)[0] - twist.along(row)).abs() < 1e-14);
                    assert!((twist.at_row(r)[1] - dot(row, &twist.rate)).abs() < 1e-13);
                }
            }
            let taken = work - twist.energies().iter().sum::<f64>();
            assert!((taken - twist.damped()).abs() < 1e-11, "{damping}: {taken} {}", twist.damped());
            assert!(if damping > 0.0 { taken > 0.1 } else { taken.abs() < 1e-11 }, "{damping}: {taken}");
        }
    }

    /// Of modes with up to a third of a turn a step.
    #[test]
    fn a_steady_train_of_blows_makes_the_static_turn() {
        let (h, blow) = (0.02, 0.7);
        let modes: Vec<(f64, f64)> = (1..=7).map(|j| (f64::from(j * j) * 200.0, 3.0 + f64::from(j))).collect();
        let row: Vec<f64> = (0..8).map(|j| if j < 7 { 0.5 - 0.2 * f64::from(j) } else { 0.0 }).collect();
        // one behind the last mode
        let mut twist =
            TorsionalModes::new(&[modes.as_slice(), &[(1.0, 0.0)]].concat(), &[vec![0.0; 8], row.clone()], 1);
        let (step, lacking) = (twist.step(h), twist.static_correction(h));
        for _ in 0..4000 {
            twist.propagate_free(&step);
            twist.apply_impulse(&step, blow);
            twist.apply_torques(&step);
        }
        let mut most = 0.0_f64;
        for (j, (square, _)) in modes.iter().enumerate() {
            let still = row[j] * blow / (square * h);
            let found = twist.displacement()[j] + lacking[j] * blow;
            assert!((found / still - 1.0).abs() < 1e-9, "{j}: {found} {still}");
            most = most.max((twist.displacement()[j] / still - 1.0).abs());
        }
        assert!(most > 0.3, "what a train lacks is much: {most}");
        assert!(lacking[7] == 0.0);
        let fast =
            TorsionalModes::new(&[[(1e5, 0.1); 1].as_slice(), &[(1.0, 0.0); 7]].concat(), &[vec![0.0; 8], row], 1);
        assert!((fast.static_correction(h)[0] * 1e5 * h / 0.5 - 1.0).abs() < 1e-12, "half a turn and more: all of it");
    }
}
