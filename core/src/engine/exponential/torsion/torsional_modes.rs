//! Torsional modes over a step: free motion, an angular impulse at its beginning, torques over it.
//!
//! ```text
//! free       (n, n')+ = exp(B h) (n, n')                                  [`super::oscillators`]
//! impulse    (n, n')+ += exp(B h) (0, J t)                                J: angular impulse on a diaphragm's node, t: its row
//! torques    (n, n')+ += g(B) (0, f),   f = sum_r M_r t_r                 M_r: torque of an unbalance or of the brakes along its row t_r
//! rows       s_r = t_r.n, t_r.n'                                          rotation and rate along each row                               (1)
//! course     (n, n')+ += response to f0 + f1 (s/h - 1/2), s from the beginning of the step: torques over time ([`super::torques`])        (4)
//! work       + J (s'(n) + J t.t/2) + sum_r M_r (s_r(n+1) - s_r(n))        damping has dissipated this work less the energy at n          (2)
//!            s'(n) of an impulse has the jumps of those before it
//! predicted  (1) of the free motion + response of the resolved modes to the torques of the last step                                     (3)
//! ```
//! n: amplitude of a mode of unit inertia \[rad (kg m2)^0.5\]. Rows: those of the unbalances, that of the brakes, and those of the
//! diaphragms' nodes. The response of (1) to impulse and torques is a table. All of it is exact, because the
//! motion is. The work of (4) is `f0 [n(n+1) - n(n)] + f1 L` with
//!
//! ```text
//! L = [n(n) + n(n+1)]/2 - (1/h) integral of n,     integral of n = [F - (n'(n+1) - n'(n)) - c (n(n+1) - n(n))]/w^2                        (5)
//! ```
//! F: impulse of all torques on the mode in the step. (5) is n'' + c n' + w^2 n = f, integrated once.
//!
//! The functions are inlined into the kernels of `stepping/step_kernels.rs`. Lists have a multiple of eight entries. Verified by
//! `damping_dissipates_the_work_less_the_energy`, `a_steady_train_of_blows_makes_the_static_turn` and the energy balances of
//! `tests/exponential/exponential_run.rs`.

use super::oscillators::{OscillatorLanes, OscillatorStep};
use crate::engine::exponential::modal::plane_block::SplitBlock;
use bladeoff_numerics::linalg::dot;
use bladeoff_numerics::linalg::lanes::{LANES, Lane};

/// Number of rows that are evaluated together.
const GROUP: usize = LANES / 2;

/// Value of `(w h)^2` below which the step resolves a mode.
const RESOLVED: f64 = 1.0;

/// State of the torsional modes at n.
#[derive(Debug, Clone)]
pub(crate) struct TorsionalModes {
    /// Block B = [[0, 1], [-w^2, -c]] of each mode.
    blocks: Vec<SplitBlock>,
    /// w^2 \[1/s2\] and c \[1/s\] of each mode.
    squared_frequencies: Vec<f64>,
    dampings: Vec<f64>,
    /// Amplitude n and rate n' of each mode.
    displacement: Vec<f64>,
    rate: Vec<f64>,
    /// Rows one after the other; number of those along which torques act. Impulses act along the rows behind these.
    rows: Vec<f64>,
    torque_rows: usize,
    /// Entries of groups of four rows, mode by mode.
    row_groups: Vec<[f64; GROUP]>,
    /// (1) of groups of four rows, rotations before rates: at n, after [`TorsionalModes::propagate_free`] at n+1; and at the
    /// beginning of the step.
    row_motion: Vec<Lane>,
    previous_row_motion: Vec<Lane>,
    /// Response of (1) to the torques of the last step in the resolved modes, for (3).
    predicted_change: Vec<Lane>,
    /// Torques over the step along the rows \[N m\].
    torques: Vec<f64>,
    /// Torques over the step on the modes themselves, and the amplitudes at its beginning; empty where there are no such torques.
    added_torques: Vec<f64>,
    initial_displacement: Vec<f64>,
    /// Torques over time (4); `None` without.
    course: Option<Box<Course>>,
    /// Work of impulses and torques (2) \[J\].
    work: f64,
    /// Products of each two rows of impulses, t.t \[1/(kg m2)\], and the impulses of the step along these rows \[N m s\].
    impulse_row_products: Vec<f64>,
    impulses: Vec<f64>,
    has_impulses: bool,
}

/// Torques over time (4) in a step.
#[derive(Debug, Clone)]
struct Course {
    /// f0 and f1 of each mode.
    torques: [Vec<f64>; 2],
    /// Amplitudes and rates at the beginning of the step.
    before: [Vec<f64>; 2],
    /// Work in the step \[J\].
    work: f64,
}

/// Tables of a step.
#[derive(Debug, Clone)]
pub(crate) struct TorsionalStep {
    modes: OscillatorStep,
    /// Response of (1) to a unit torque along each row, and to a unit impulse along the rows behind these.
    impulse_outputs: Vec<Lane>,
    /// Response of (1) to unit torques in the resolved modes alone, by groups of four rows.
    resolved: Vec<Lane>,
    /// Length \[s\], and amplitude and rate of each mode behind the step per unit f1 of (4); empty without torques over time.
    h: f64,
    linear: Vec<[f64; 2]>,
}

impl TorsionalModes {
    /// Creates modes `(w^2, c)` \[1/s2, 1/s\] at rest; torques act along the first `torque_rows` rows.
    pub fn new(modes: &[(f64, f64)], rows: &[Vec<f64>], torque_rows: usize) -> Self {
        let count = modes.len();
        let at = |r: usize, j: usize| rows.get(r).map_or(0.0, |row| row[j]);
        let groups = (0..rows.len()).step_by(GROUP);
        let row_groups = groups.flat_map(|first| (0..count).map(move |j| std::array::from_fn(|k| at(first + k, j))));
        let (zeros, row_motion) = (vec![0.0; count], vec![Lane::default(); rows.len().div_ceil(GROUP)]);
        let impulse_rows = &rows[torque_rows.min(rows.len())..];
        Self {
            blocks: modes.iter().map(|(square, damping)| SplitBlock::of(&[0.0, 1.0, -square, -damping])).collect(),
            squared_frequencies: modes.iter().map(|mode| mode.0).collect(),
            dampings: modes.iter().map(|mode| mode.1).collect(),
            displacement: zeros.clone(),
            rate: zeros,
            row_groups: row_groups.collect(),
            rows: rows.concat(),
            torque_rows,
            previous_row_motion: row_motion.clone(),
            predicted_change: row_motion.clone(),
            row_motion,
            torques: vec![0.0; torque_rows],
            added_torques: Vec::new(),
            initial_displacement: Vec::new(),
            course: None,
            work: 0.0,
            impulse_row_products: impulse_rows
                .iter()
                .flat_map(|one| impulse_rows.iter().map(|other| dot(one, other)))
                .collect(),
            impulses: vec![0.0; impulse_rows.len()],
            has_impulses: false,
        }
    }

    /// Replaces the damping of the modes \[1/s\].
    pub fn set_damping(&mut self, modes: &[(f64, f64)]) {
        self.blocks = modes.iter().map(|(square, damping)| SplitBlock::of(&[0.0, 1.0, -square, -damping])).collect();
        self.dampings = modes.iter().map(|mode| mode.1).collect();
    }

    /// Prepares for torques over time (4), before the first step.
    pub fn expect_course(&mut self) {
        let zeros = || vec![0.0; self.displacement.len()];
        let course = Course { torques: [zeros(), zeros()], before: [zeros(), zeros()], work: 0.0 };
        self.course = Some(Box::new(course));
    }

    /// Creates the tables of a step of `h` \[s\].
    pub fn step(&self, h: f64) -> TorsionalStep {
        let modes = OscillatorStep::new(&self.blocks, h);
        let of = |eight: &OscillatorLanes, along: usize, rate: usize| match along < self.torque_rows {
            true => eight.force[rate],
            false => eight.free[1 + 2 * rate],
        };
        let groups = self.row_motion.len();
        let table = |rows: usize, highest: f64| -> Vec<Lane> {
            let made = |along: usize, r: usize, rate: usize| -> f64 {
                let lanes =
                    modes.lanes.iter().flat_map(|eight| of(eight, along, rate).0).zip(&self.squared_frequencies);
                let rows = self.row(along).iter().zip(self.row(r));
                let kept = lanes.zip(rows).filter(|((_, square), _)| **square * h * h < highest);
                kept.map(|((made, _), (along, row))| made * along * row).sum()
            };
            let lane = |along: usize, group: usize| {
                Lane(std::array::from_fn(|k| made(along, GROUP * group + k % GROUP, k / GROUP)))
            };
            let places = (0..rows).flat_map(|along| (0..groups).map(move |group| (along, group)));
            places.map(|(along, group)| lane(along, group)).collect()
        };
        let (response, resolved) = (table(GROUP * groups, f64::INFINITY), table(self.torque_rows, RESOLVED));
        let by_group = (0..groups).flat_map(|group| (0..self.torque_rows).map(move |along| along * groups + group));
        let linear = if self.course.is_some() { self.linear_responses(h) } else { Vec::new() };
        let resolved = by_group.map(|at| resolved[at]).collect();
        TorsionalStep { impulse_outputs: response, resolved, modes, h, linear }
    }

    /// Response of each mode from rest to `s/h - 1/2` over a step of `h` \[s\]: the difference of the particular solution at both ends, the first of
    /// them in free motion.
    fn linear_responses(&self, h: f64) -> Vec<[f64; 2]> {
        let of = |((block, square), damping): ((&SplitBlock, &f64), &f64)| {
            let [a, b, c, d] = block.exponential(h);
            let rate = 1.0 / (square * h);
            let [before, after] = [-0.5, 0.5].map(|part| (part - damping * rate) / square);
            [after - a * before - b * rate, rate - c * before - d * rate]
        };
        self.blocks.iter().zip(&self.squared_frequencies).zip(&self.dampings).map(of).collect()
    }

    /// Static correction of each mode for a train of impulses on a diaphragm's node at intervals of `h` \[s\], per angular impulse, as
    /// [`ImpulsedRing`](crate::engine::exponential::contact::impulsed_ring::ImpulsedRing) has it of the ring: the static
    /// amplitude less that at n. A train makes nothing of modes with half a turn a step and more.
    pub fn static_correction(&self, diaphragm: usize, h: f64) -> Vec<f64> {
        let of = |(block, square): (&SplitBlock, &f64)| {
            let [a, b, c, d] = block.exponential(h);
            let resolved = square * h * h < std::f64::consts::PI.powi(2);
            // (1 - exp(B h))^-1 exp(B h) (0, 1)
            let determinant = (1.0 - a) * (1.0 - d) - b * c;
            let train = if resolved { ((1.0 - d) * b + b * d) / determinant } else { 0.0 };
            1.0 / (square * h) - train
        };
        let modes = self.blocks.iter().zip(&self.squared_frequencies).map(of);
        // behind the last mode there are zeros
        modes
            .zip(self.row(self.torque_rows + diaphragm))
            .map(|(correction, &row)| if row == 0.0 { 0.0 } else { correction * row })
            .collect()
    }

    /// Angular impulse of the step on each diaphragm's node \[N m s\].
    pub fn impulses(&self) -> &[f64] {
        &self.impulses
    }

    /// Row with an index; empty without one.
    pub fn row(&self, r: usize) -> &[f64] {
        self.rows.chunks_exact(self.displacement.len().max(1)).nth(r).unwrap_or_default()
    }

    /// Rotation along a row \[rad\].
    pub fn along(&self, row: &[f64]) -> f64 {
        dot(row, &self.displacement)
    }

    /// Amplitudes of the modes.
    pub fn displacement(&self) -> &[f64] {
        &self.displacement
    }

    /// Rates of these amplitudes.
    pub fn rate(&self) -> &[f64] {
        &self.rate
    }

    /// Starts from amplitudes and their rates; `dissipated`: energy that damping has taken before \[J\].
    pub fn start(&mut self, displacement: &[f64], rate: &[f64], dissipated: f64) {
        self.displacement[..displacement.len()].copy_from_slice(displacement);
        self.rate[..rate.len()].copy_from_slice(rate);
        for r in 0..self.rows.len() / self.displacement.len().max(1) {
            let [turn, rate] = [&self.displacement, &self.rate].map(|of| dot(self.row(r), of));
            let lane = &mut self.row_motion[r / GROUP].0;
            (lane[r % GROUP], lane[GROUP + r % GROUP]) = (turn, rate);
        }
        self.previous_row_motion.clone_from(&self.row_motion);
        self.work = dissipated + self.energies().iter().sum::<f64>();
    }

    /// Rotation along one of the rows and its rate (1).
    #[inline(always)]
    pub fn at_row(&self, r: usize) -> [f64; 2] {
        let lane = &self.row_motion[r / GROUP].0;
        [lane[r % GROUP], lane[GROUP + r % GROUP]]
    }

    /// Rotation along one of the rows and its rate predicted for n+1, (3); after [`TorsionalModes::propagate_free`].
    #[inline(always)]
    pub fn predicted_at_row(&self, r: usize) -> [f64; 2] {
        let ([turn, rate], predicted_change) = (self.at_row(r), &self.predicted_change[r / GROUP].0);
        [turn + predicted_change[r % GROUP], rate + predicted_change[GROUP + r % GROUP]]
    }

    /// Rotation of a diaphragm's node by n+1 per angular impulse on the node of another \[rad/(N m s)\].
    pub fn impulse_compliance(&self, step: &TorsionalStep, at: usize, acting: usize) -> f64 {
        let [at, acting] = [at, acting].map(|diaphragm| self.torque_rows + diaphragm);
        step.impulse_outputs[acting * self.row_motion.len() + at / GROUP].0[at % GROUP]
    }

    /// Torques over the step along the rows \[N m\].
    #[inline(always)]
    pub fn torques(&mut self) -> &mut [f64] {
        &mut self.torques
    }

    /// Sets torques on the modes themselves: minus the changes of their momenta, times `per_step` = 1/h. Between
    /// [`TorsionalModes::propagate_free`] and [`TorsionalModes::apply_torques`], and once before the first step.
    pub fn add_torques(&mut self, changes: &[f64], per_step: f64) {
        if self.initial_displacement.is_empty() {
            (self.added_torques, self.initial_displacement) =
                (vec![0.0; self.displacement.len()], self.displacement.clone());
        }
        self.added_torques
            .iter_mut()
            .zip(changes)
            .for_each(|(torque_on_mode, change)| *torque_on_mode = -change * per_step);
    }

    /// Kinetic and potential energy \[J\].
    pub fn energies(&self) -> [f64; 2] {
        let modes = self.displacement.iter().zip(&self.rate).zip(&self.squared_frequencies);
        modes.fold([0.0; 2], |[kinetic, potential], ((n, v), square)| {
            [kinetic + 0.5 * v * v, potential + 0.5 * square * n * n]
        })
    }

    /// Energy that damping has dissipated so far \[J\].
    pub fn dissipation(&self) -> f64 {
        self.work - self.energies().iter().sum::<f64>()
    }

    /// Takes the modes to n+1 without impulse and torques.
    #[inline(always)]
    pub fn propagate_free(&mut self, step: &TorsionalStep) {
        if std::mem::take(&mut self.has_impulses) {
            self.impulses.fill(0.0);
        }
        if !self.initial_displacement.is_empty() {
            self.initial_displacement.copy_from_slice(&self.displacement);
        }
        if let Some(course) = &mut self.course {
            course.before[0].copy_from_slice(&self.displacement);
            course.before[1].copy_from_slice(&self.rate);
        }
        let modes = self.displacement.as_chunks_mut::<LANES>().0.iter_mut().zip(self.rate.as_chunks_mut::<LANES>().0);
        for (eight, (place, rate)) in step.modes.lanes.iter().zip(modes) {
            [*place, *rate] = eight.after(place, rate);
        }
        std::mem::swap(&mut self.previous_row_motion, &mut self.row_motion);
        let mut row_groups = self.row_groups.as_slice();
        for row_motion in &mut self.row_motion {
            let (group, others) = row_groups.split_at(self.displacement.len());
            row_groups = others;
            // two independent sums, because each addition waits for the one before it
            let mut chains = [[[0.0; GROUP]; 2]; 2];
            let modes = self.displacement.as_chunks::<2>().0.iter().zip(self.rate.as_chunks::<2>().0);
            for (four, (place, rate)) in group.as_chunks::<2>().0.iter().zip(modes) {
                for i in 0..2 {
                    for k in 0..GROUP {
                        chains[i][0][k] += four[i][k] * place[i];
                    }
                    for k in 0..GROUP {
                        chains[i][1][k] += four[i][k] * rate[i];
                    }
                }
            }
            for k in 0..LANES {
                row_motion.0[k] = chains[0][k / GROUP][k % GROUP] + chains[1][k / GROUP][k % GROUP];
            }
        }
        for (predicted_change, resolved) in
            self.predicted_change.iter_mut().zip(step.resolved.chunks_exact(self.torque_rows.max(1)))
        {
            let mut sums = [0.0; LANES];
            for (resolved, torque) in resolved.iter().zip(&self.torques) {
                for k in 0..LANES {
                    sums[k] += resolved.0[k] * torque;
                }
            }
            predicted_change.0 = sums;
        }
    }

    /// Adds the response to torques over time with these f0 and f1 of (4), after [`TorsionalModes::propagate_free`].
    pub fn drive(&mut self, step: &TorsionalStep, on_modes: &[Vec<f64>; 2]) {
        let Some(course) = &mut self.course else { return };
        let count = self.displacement.len();
        for j in 0..count {
            let [constant, linear] = [on_modes[0][j], on_modes[1][j]];
            (course.torques[0][j], course.torques[1][j]) = (constant, linear);
            let [of_place, of_rate] = step.modes.lanes[j / LANES].force.each_ref().map(|lane| lane.0[j % LANES]);
            let change =
                [of_place * constant + step.linear[j][0] * linear, of_rate * constant + step.linear[j][1] * linear];
            self.displacement[j] += change[0];
            self.rate[j] += change[1];
            for (r, row) in self.rows.chunks_exact(count).enumerate() {
                let row_motion = &mut self.row_motion[r / GROUP].0;
                row_motion[r % GROUP] += change[0] * row[j];
                row_motion[GROUP + r % GROUP] += change[1] * row[j];
            }
        }
    }

    /// Work of the torques over time in the last step \[J\].
    pub fn course_work(&self) -> f64 {
        self.course.as_ref().map_or(0.0, |course| course.work)
    }

    /// Work (5) of the torques over time, at the end of the step.
    fn end_course(&mut self, step: &TorsionalStep) {
        let Some(mut course) = self.course.take() else { return };
        let (h, count) = (step.h, self.displacement.len());
        course.work = 0.0;
        for j in 0..count {
            let [constant, linear] = [course.torques[0][j], course.torques[1][j]];
            let torques = self.torques.iter().zip(self.rows.chunks_exact(count)).map(|(torque, row)| torque * row[j]);
            let impulse_rows = self.rows[self.torque_rows * count..].chunks_exact(count);
            let impulses = self.impulses.iter().zip(impulse_rows).map(|(impulse, row)| impulse * row[j]);
            let added = self.added_torques.get(j).copied().unwrap_or(0.0);
            let impulse = h * (constant + added + torques.sum::<f64>()) + impulses.sum::<f64>();
            let [before, rate_before] = [course.before[0][j], course.before[1][j]];
            let [change, rate_change] = [self.displacement[j] - before, self.rate[j] - rate_before];
            let mean = (impulse - rate_change - self.dampings[j] * change) / (self.squared_frequencies[j] * h);
            course.work += constant * change + linear * (0.5 * (before + self.displacement[j]) - mean);
        }
        self.work += course.work;
        self.course = Some(course);
    }

    /// Adds an angular impulse on a diaphragm's node at the beginning of the step \[N m s\]; between [`TorsionalModes::propagate_free`]
    /// and [`TorsionalModes::apply_torques`].
    #[inline(always)]
    pub fn apply_impulse(&mut self, step: &TorsionalStep, diaphragm: usize, impulse: f64) {
        let (count, impulse_row) = (self.displacement.len(), self.torque_rows + diaphragm);
        let row = &self.rows[impulse_row * count..][..count];
        let modes = self.displacement.as_chunks_mut::<LANES>().0.iter_mut().zip(self.rate.as_chunks_mut::<LANES>().0);
        for ((eight, row), (place, rate)) in step.modes.lanes.iter().zip(row.as_chunks::<LANES>().0).zip(modes) {
            // one list at a time: the compiler does not vectorise a loop that fills two
            *place = std::array::from_fn(|k| place[k] + eight.free[1].0[k] * (impulse * row[k]));
            *rate = std::array::from_fn(|k| rate[k] + eight.free[3].0[k] * (impulse * row[k]));
        }
        let rate = self.previous_row_motion[impulse_row / GROUP].0[GROUP + impulse_row % GROUP];
        let products = &self.impulse_row_products[diaphragm * self.impulses.len()..][..self.impulses.len()];
        let jump: f64 = products.iter().zip(&self.impulses).map(|(product, before)| product * before).sum();
        self.work += impulse * (rate + jump + 0.5 * impulse * products[diaphragm]);
        self.impulses[diaphragm] += impulse;
        self.has_impulses = true;
        add(&step.impulse_outputs[impulse_row * self.row_motion.len()..], impulse, &mut self.row_motion);
    }

    /// Rotation along a row over the step \[rad\], after [`TorsionalModes::apply_torques`].
    #[inline(always)]
    pub fn turn(&self, row: usize) -> f64 {
        self.row_motion[row / GROUP].0[row % GROUP] - self.previous_row_motion[row / GROUP].0[row % GROUP]
    }

    /// Applies the torques over the step.
    #[inline(always)]
    pub fn apply_torques(&mut self, step: &TorsionalStep) {
        let modes = self.displacement.as_chunks_mut::<LANES>().0.iter_mut().zip(self.rate.as_chunks_mut::<LANES>().0);
        let count = step.modes.lanes.len() * LANES;
        let mut torques_on_modes = self.added_torques.as_chunks::<LANES>().0.iter();
        for (i, (eight, (place, rate))) in step.modes.lanes.iter().zip(modes).enumerate() {
            let mut force = torques_on_modes.next().copied().unwrap_or_default();
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
        for (response, torque) in step.impulse_outputs.chunks_exact(self.row_motion.len()).zip(&self.torques) {
            add(response, *torque, &mut self.row_motion);
        }
        if !self.added_torques.is_empty() {
            self.evaluate_rows(step);
        }
        for (r, torque) in self.torques.iter().enumerate() {
            self.work += torque * self.turn(r);
        }
        if self.course.is_some() {
            self.end_course(step);
        }
    }

    /// Adds the response to torques on the modes themselves to (1) and (2).
    fn evaluate_rows(&mut self, step: &TorsionalStep) {
        let count = self.displacement.len();
        for (j, &torque_on_mode) in self.added_torques.iter().enumerate() {
            let [of_place, of_rate] =
                step.modes.lanes[j / LANES].force.each_ref().map(|lane| lane.0[j % LANES] * torque_on_mode);
            for (r, row) in self.rows.chunks_exact(count).enumerate() {
                let row_motion = &mut self.row_motion[r / GROUP].0;
                row_motion[r % GROUP] += of_place * row[j];
                row_motion[GROUP + r % GROUP] += of_rate * row[j];
            }
            self.work += torque_on_mode * (self.displacement[j] - self.initial_displacement[j]);
        }
    }
}

/// Adds the response of (1) to an amount of torque or impulse along one row.
#[inline(always)]
fn add(response: &[Lane], amount: f64, row_motion: &mut [Lane]) {
    for (row_motion, response) in row_motion.iter_mut().zip(response) {
        row_motion.0 = std::array::from_fn(|k| row_motion.0[k] + response.0[k] * amount);
    }
}

#[cfg(test)]
#[path = "torsional_modes_tests.rs"]
mod tests;
