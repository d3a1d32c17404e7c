//! What damping takes over a contact step, in one cell: exactly for any step.
//!
//! ```text
//! y(t)  = eta(t) + E z,  E = exp(B t),  z = y + l J - eta(0)                      from n on, with an impulse J there                     (1)
//! eta   = Re[(iW - B)^-1 (l_u - i l_v) f e^{iWt}] - B^-1 l_w                      what unbalances f and the weight keep                (2)
//! P h   = h lost(<y>) + z^T Q z,   Q = int E^T D E dt - (int E dt)^T D (int E dt)/h,   lost(y) = y^T D y                               (3)
//! lost  = q'^T C q' + q'^T K_a q                                                  ([`super::measured`])
//! ```
//! P is the mean power over the step, `<y>` the mean of (1) in it. Powers of the mean rates at n are not enough where impulses act at every step: between two of them the rates
//! of a whipping rotor fall by much of what an impulse gives, some modes swing, and others come to rest. What is left out in (3) is how eta turns within the step: of second order in `W h`.
//! A pair as slow as the spin (`SLOW`) may be in resonance with the unbalance, eta many times as large as y: its z in (3) is `y + l J` less what stands, and what the force makes of `<y>` is taken by
//! powers of the step. So what is left out is small beside y.
//! Integrals by Gauss and Legendre at six places of each of four pieces, which become shorter towards the impulse: pairs may come to rest within a hundredth of the step. Taken at the stations, and linear between them, as all of a cell is.
//! Verified by `what_a_free_motion_loses_is_what_its_energy_lacks`, `what_a_forced_motion_loses_is_what_it_has_lost`, `dissipation_is_linear_between_bases` (`speed_grid.rs`) and the balances of `tests/exponential_run.rs`.

use super::interval_model::IntervalModel;
use super::plane_block::{PlaneBlock, SplitBlock, block_norm};
use super::quadratic_form::QuadraticForm;
use super::row_batch::Interpolate;
use crate::linalg::Matrix;
use crate::linalg::lanes::kernel;
use nalgebra::Complex;

/// Places and weights on -1..1 that integrate a polynomial of the eleventh degree (Gauss and Legendre).
const PLACES: [(f64, f64); 3] = [
    (0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_4),
];
/// Ends of the pieces, as parts of the step.
const ENDS: [f64; 5] = [0.0, 1.0 / 256.0, 1.0 / 32.0, 1.0 / 4.0, 1.0];
/// A pair is slow whose |B| is less than so many times W, and less than this over a step.
const SLOW: f64 = 1.5;
const SHORT: f64 = 0.1;

/// D, Q and `int E dt/h` of (3).
#[derive(Debug, Clone, Default)]
pub(crate) struct Dissipation {
    lost: QuadraticForm,
    more: QuadraticForm,
    mean: Vec<PlaneBlock>,
}

/// What forces make in a cell: of z in (3), and of `<y>` beside the mean of E y. Of each unbalance real and imaginary parts per unit force, and what stands.
#[derive(Debug)]
pub(crate) struct ForcedDissipation {
    turning: Vec<[Vec<f64>; 2]>,
    turning_mean: Vec<[Vec<f64>; 2]>,
    still: Vec<f64>,
    still_mean: Vec<f64>,
}

/// Room for z and `<y>`.
#[derive(Debug, Clone, Default)]
pub(crate) struct DissipationBuffer {
    z: Vec<f64>,
    mean: Vec<f64>,
}

impl Dissipation {
    /// Of pairs B and the matrix D, in steps of `h` \[s\].
    pub fn new(blocks: &[PlaneBlock], lost: &Matrix, h: f64) -> Self {
        let split: Vec<SplitBlock> = blocks.iter().map(SplitBlock::of).collect();
        let lost = (lost + lost.transpose()) * 0.5;
        let mut more = Matrix::zeros(lost.nrows(), lost.ncols());
        let (mut mean, mut parts) = (vec![[0.0; 4]; blocks.len()], Default::default());
        for piece in ENDS.windows(2) {
            let (middle, half) = (0.5 * h * (piece[0] + piece[1]), 0.5 * h * (piece[1] - piece[0]));
            for &(place, weight) in &PLACES {
                for t in [middle - place * half, middle + place * half] {
                    let turns: Vec<PlaneBlock> = split.iter().map(|block| block.exponential(t)).collect();
                    add(&mut more, weight * half, &lost, &turns, &mut parts);
                    for (sum, turn) in mean.iter_mut().flatten().zip(turns.iter().flatten()) {
                        *sum += weight * half / h * turn;
                    }
                }
            }
        }
        add(&mut more, -h, &lost, &mean, &mut parts);
        Self { lost: QuadraticForm::new(&lost), more: QuadraticForm::new(&more), mean }
    }

    /// lost(y) \[W\].
    pub fn power_at(&self, y: &[f64]) -> f64 {
        self.lost.value(y)
    }

    /// P \[W\] over a step of `h` \[s\] from states y behind an impulse on, under forces on the unbalances' nodes \[N\].
    pub fn power(
        &self,
        kept: &ForcedDissipation,
        h: f64,
        y: &[f64],
        forces: &[Complex<f64>],
        room: &mut DissipationBuffer,
    ) -> f64 {
        let DissipationBuffer { z, mean } = room;
        z.clear();
        z.extend(y.iter().zip(&kept.still).map(|(y, still)| y - still));
        mean.clear();
        mean.extend_from_slice(&kept.still_mean);
        for ((force, turning), turning_mean) in forces.iter().zip(&kept.turning).zip(&kept.turning_mean) {
            force_on([force.re, force.im], turning, turning_mean, z, mean);
        }
        add_means(&self.mean, y, mean);
        self.lost.value(mean) + self.more.value(z) / h
    }
}

impl Interpolate for Dissipation {
    fn interpolate(&mut self, [one, other]: [&Self; 2], times: [f64; 2]) {
        self.lost.interpolate([&one.lost, &other.lost], times);
        self.more.interpolate([&one.more, &other.more], times);
        let mean = one.mean.iter().zip(&other.mean);
        self.mean.clear();
        self.mean
            .extend(mean.map(|(a, b)| -> PlaneBlock { std::array::from_fn(|i| times[0] * a[i] + times[1] * b[i]) }));
    }
}

impl ForcedDissipation {
    /// In a cell of these means, in steps of `h` \[s\], of so many unbalances.
    pub fn new(local: &IntervalModel, within: &Dissipation, h: f64, unbalances: usize) -> Self {
        let (pairs, weight) = (local.blocks.len(), &local.input_vectors[2 * unbalances]);
        let zeros = vec![0.0; 2 * pairs];
        let mut kept = Self {
            turning: vec![[zeros.clone(), zeros.clone()]; unbalances],
            turning_mean: vec![[zeros.clone(), zeros.clone()]; unbalances],
            still: zeros.clone(),
            still_mean: zeros,
        };
        let (sin, cos) = libm::sincos(0.5 * local.speed * h);
        let middle = Complex::new(cos, sin) * (sin / (0.5 * local.speed * h));
        for (k, (b, mean)) in local.blocks.iter().zip(&within.mean).enumerate() {
            let both = [k, pairs + k];
            let still = static_response(b, both.map(|at| weight[at]));
            let [one, other] = still;
            let gone = [mean[0] * one + mean[1] * other, mean[2] * one + mean[3] * other];
            for (i, at) in both.into_iter().enumerate() {
                (kept.still[at], kept.still_mean[at]) = (still[i], still[i] - gone[i]);
            }
            for (s, [u, v]) in local.input_vectors.as_chunks::<2>().0[..unbalances].iter().enumerate() {
                let push = both.map(|at| Complex::new(u[at], -v[at]));
                let (eta, of_mean) = if is_slow_plane(b, local.speed, h) {
                    ([Complex::default(); 2], mean_slow_response(b, local.speed, h, push))
                } else {
                    let eta = harmonic_response(b, local.speed, push);
                    (eta, [0, 1].map(|i| eta[i] * middle - eta[0] * mean[2 * i] - eta[1] * mean[2 * i + 1]))
                };
                for (i, at) in both.into_iter().enumerate() {
                    (kept.turning[s][0][at], kept.turning[s][1][at]) = (eta[i].re, eta[i].im);
                    (kept.turning_mean[s][0][at], kept.turning_mean[s][1][at]) = (of_mean[i].re, of_mean[i].im);
                }
            }
        }
        kept
    }
}

kernel! {
    /// Takes what a force makes out of z, and adds what it makes of the mean.
    fn force_on(force: [f64; 2], turning: &[Vec<f64>; 2], of_mean: &[Vec<f64>; 2], z: &mut [f64], mean: &mut [f64]) {
        let ([f, g], [re, im], [mean_re, mean_im]) = (force, turning, of_mean);
        for ((z, re), im) in z.iter_mut().zip(re).zip(im) {
            *z -= f * re - g * im;
        }
        for ((mean, re), im) in mean.iter_mut().zip(mean_re).zip(mean_im) {
            *mean += f * re - g * im;
        }
    }
}

kernel! {
    /// Adds the means of E y.
    fn add_means(blocks: &[PlaneBlock], y: &[f64], mean: &mut [f64]) {
        let pairs = blocks.len();
        let ((one, other), (first, second)) = (y.split_at(pairs), mean.split_at_mut(pairs));
        for k in 0..pairs {
            let b = &blocks[k];
            first[k] += b[0] * one[k] + b[1] * other[k];
            second[k] += b[2] * one[k] + b[3] * other[k];
        }
    }
}

fn is_slow_plane(b: &PlaneBlock, speed: f64, h: f64) -> bool {
    let size = block_norm(b);
    size < SLOW * speed.abs() && size * h < SHORT
}

/// The mean over a step of what a force of e^{iWt} makes of a slow pair from rest on: `1/h int int_0^t e^{B(t-s)} e^{iWs} ds dt l`, to second order.
fn mean_slow_response(b: &PlaneBlock, speed: f64, h: f64, l: [Complex<f64>; 2]) -> [Complex<f64>; 2] {
    let on = |i: usize| l[0] * b[2 * i] + l[1] * b[2 * i + 1] + Complex::new(0.0, speed) * l[i];
    [0, 1].map(|i| (l[i] + on(i) * (h / 3.0)) * (0.5 * h))
}

/// `-B^-1 w`; nothing for a pair without stiffness.
fn static_response(b: &PlaneBlock, w: [f64; 2]) -> [f64; 2] {
    let determinant = b[0] * b[3] - b[1] * b[2];
    if w == [0.0; 2] || determinant == 0.0 {
        return [0.0; 2];
    }
    [b[1] * w[1] - b[3] * w[0], b[2] * w[0] - b[0] * w[1]].map(|part| part / determinant)
}

/// `(iW - B)^-1 l` of a pair that is not slow.
fn harmonic_response(b: &PlaneBlock, speed: f64, l: [Complex<f64>; 2]) -> [Complex<f64>; 2] {
    let [one, other] = [b[0], b[3]].map(|part| Complex::new(-part, speed));
    let determinant = one * other - b[1] * b[2];
    if determinant.norm_sqr() == 0.0 {
        return [Complex::default(); 2];
    }
    [other * l[0] + l[1] * b[1], l[0] * b[2] + one * l[1]].map(|part| part / determinant)
}

/// `sum += times E^T D E`, E of blocks; `parts`: room for their entries one after the other.
fn add(sum: &mut Matrix, times: f64, lost: &Matrix, turns: &[PlaneBlock], parts: &mut [Vec<f64>; 4]) {
    for (i, part) in parts.iter_mut().enumerate() {
        part.clear();
        part.extend(turns.iter().map(|turn| turn[i]));
    }
    let pairs = turns.len();
    let columns = lost.as_slice().chunks_exact(2 * pairs);
    let (first, second) = (columns.clone().take(pairs), columns.skip(pairs));
    let (firsts, seconds) = sum.as_mut_slice().split_at_mut(2 * pairs * pairs);
    let sums = firsts.chunks_exact_mut(2 * pairs).zip(seconds.chunks_exact_mut(2 * pairs));
    for ((turn, columns), sums) in turns.iter().zip(first.zip(second)).zip(sums) {
        let [a, b, c, d] = turn.map(|entry| times * entry);
        add_column([a, c], columns, parts, sums.0);
        add_column([b, d], columns, parts, sums.1);
    }
}

kernel! {
    /// Adds `E^T` of two columns, so much of each, to a column.
    fn add_column(times: [f64; 2], columns: (&[f64], &[f64]), parts: &[Vec<f64>; 4], sums: &mut [f64]) {
        let ([f, g], [e, above, below, other]) = (times, parts);
        let (one, two) = columns;
        let pairs = e.len();
        let ((one, one_below), (two, two_below)) = (one.split_at(pairs), two.split_at(pairs));
        let (sums, sums_below) = sums.split_at_mut(pairs);
        let (above, below, other) = (&above[..pairs], &below[..pairs], &other[..pairs]);
        let (one_below, two_below, sums_below) = (&one_below[..pairs], &two_below[..pairs], &mut sums_below[..pairs]);
        for k in 0..pairs {
            let (x, y) = (f * one[k] + g * two[k], f * one_below[k] + g * two_below[k]);
            sums[k] += e[k] * x + below[k] * y;
            sums_below[k] += above[k] * x + other[k] * y;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::modal_basis::{LateralModel, ModalBasis};
    use super::super::outputs::Outputs;
    use super::super::section_loads::SectionLoadModel;
    use super::super::state_space::StateSpace;
    use super::*;
    use crate::linalg::{Vector, dot};
    use crate::structure::Structure;
    use bladeoff_model::machine::MachineDef;

    const SPEED: f64 = 240.0;

    /// The rig with weight, a skew bearing and one of such damping \[N s/m\], at a station.
    fn station(damping: &str, then: impl FnOnce(&LateralModel, &ModalBasis, &IntervalModel)) {
        station_of(damping, |_| SPEED, then);
    }

    /// The same with forces that turn as a rotor of that spin, whatever the station's.
    fn station_of(
        damping: &str,
        turn: impl Fn(&[PlaneBlock]) -> f64,
        then: impl FnOnce(&LateralModel, &ModalBasis, &IntervalModel),
    ) {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let text = text.replacen("\"2e6 N/m\"", "[[2e6, 3e5], [-1e5, 1.7e6]]", 1);
        let text =
            text.replacen("\"600 N s/m\"", damping, 1).replacen("gravity = [0.0, 0.0]", "gravity = [0.0, -9.81]", 1);
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        assert!(machine.rotor.gravity[1] < 0.0);
        let structure = Structure::build(&machine, None).expect("buildable");
        let system = StateSpace::new(&machine, &structure).expect("regular");
        let outputs = Outputs::new(&machine, &structure);
        let measures = SectionLoadModel::new(&machine, &structure, &system, outputs.weight());
        let model = LateralModel { state_space: system, outputs, measures };
        let station = ModalBasis::new(&model, SPEED, None).expect("has a basis");
        let local = IntervalModel { speed: turn(&station.blocks), ..station.interval_model.clone() };
        then(&model, &station, &local);
    }

    /// exp(B t) z.
    fn after(local: &IntervalModel, z: &[f64], t: f64) -> Vec<f64> {
        let (pairs, mut y) = (local.blocks.len(), z.to_vec());
        for (k, block) in local.blocks.iter().enumerate() {
            let e = SplitBlock::of(block).exponential(t);
            y[k] = e[0] * z[k] + e[1] * z[pairs + k];
            y[pairs + k] = e[2] * z[k] + e[3] * z[pairs + k];
        }
        y
    }

    fn random(count: usize) -> Vec<f64> {
        let mut seed = 7_u64;
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn what_a_free_motion_loses_is_what_its_energy_lacks() {
        // of the last, a motion comes to rest in a tenth of the step
        for (damping, limit) in [("\"600 N s/m\"", 1e-9), ("\"6e4 N s/m\"", 1e-4), ("\"2e6 N s/m\"", 1e-3)] {
            station(damping, |model, station, local| {
                let n = model.state_space.size;
                // without that of the spin: its gyroscopic moments do no work at one speed
                let [stiffness, mass] = model.state_space.energy_matrices();
                let energy = |y: &[f64]| {
                    let motion = &station.motion_of_state * Vector::from_column_slice(y);
                    let (q, rates) = (motion.rows(0, n), motion.rows(n, n));
                    let twice = (rates.transpose() * mass * rates)[(0, 0)] + (q.transpose() * stiffness * q)[(0, 0)];
                    0.5 * twice - dot(model.outputs.weight(), q.as_slice())
                };
                let y = random(2 * n);
                for h in [1e-6, 5e-6, 5e-5] {
                    let lost = model.measures.damping_power_matrix(&model.state_space, &station.motion_of_state);
                    let within = Dissipation::new(&station.blocks, &lost, h);
                    let kept = ForcedDissipation::new(local, &within, h, 1);
                    let still = &kept.still;
                    let z: Vec<f64> = y.iter().zip(still).map(|(y, still)| y - still).collect();
                    let end: Vec<f64> = after(local, &z, h).iter().zip(still).map(|(z, still)| z + still).collect();
                    let found = within.power(&kept, h, &y, &[Complex::default()], &mut DissipationBuffer::default());
                    let wanted = (energy(&y) - energy(&end)) / h;
                    assert!(wanted > 0.0 && (found - wanted).abs() < limit * wanted, "{damping} {h}: {found} {wanted}");
                }
            });
        }
    }

    /// Against small steps of time: motions that forces keep, and others that are small beside what an unbalance in resonance would keep.
    #[test]
    fn what_a_forced_motion_loses_is_what_it_has_lost() {
        let lowest = |blocks: &[PlaneBlock]| {
            let rates = blocks.iter().map(|b| (b[0] * b[3] - b[1] * b[2]).sqrt());
            rates.filter(|rate| *rate > 100.0).fold(f64::INFINITY, f64::min)
        };
        // between two pairs, in resonance with the lowest, and on both sides of what is slow
        let turns_as: [&dyn Fn(&[PlaneBlock]) -> f64; 4] =
            [&|_| SPEED, &lowest, &|blocks| lowest(blocks) / 1.4, &|blocks| lowest(blocks) / 2.9];
        for damping in ["\"60 N s/m\"", "\"600 N s/m\"", "\"2e6 N s/m\""] {
            for (i, turn) in turns_as.into_iter().enumerate() {
                station_of(damping, turn, |model, station, local| {
                    let (n, force, h) = (model.state_space.size, Complex::new(300.0, -120.0), 2e-5);
                    let lost = model.measures.damping_power_matrix(&model.state_space, &station.motion_of_state);
                    let (within, form) = (Dissipation::new(&station.blocks, &lost, h), QuadraticForm::new(&lost));
                    let kept = ForcedDissipation::new(local, &within, h, 1);
                    let keeps = |t: f64| -> Vec<f64> {
                        let (sin, cos) = libm::sincos(local.speed * t);
                        let mut y = vec![0.0; 2 * n];
                        for (k, b) in local.blocks.iter().enumerate() {
                            let both = [k, n + k];
                            let push =
                                both.map(|at| Complex::new(local.input_vectors[0][at], -local.input_vectors[1][at]));
                            let turning = harmonic_response(b, local.speed, push);
                            let still = static_response(b, both.map(|at| local.input_vectors[2][at]));
                            for (i, at) in both.into_iter().enumerate() {
                                y[at] = (turning[i] * force * Complex::new(cos, sin)).re + still[i];
                            }
                        }
                        y
                    };
                    let start = keeps(0.0);
                    let most = start.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
                    // as the forces keep it; 50 times less
                    let less: Vec<f64> = random(2 * n).iter().map(|part| 0.02 * most * part).collect();
                    for (y, limit) in [(&start, 1e-5), (&less, 2e-4)] {
                        let z: Vec<f64> = y.iter().zip(&start).map(|(y, keeps)| y - keeps).collect();
                        let at = |t: f64| -> Vec<f64> {
                            after(local, &z, t).iter().zip(keeps(t)).map(|(z, keeps)| z + keeps).collect()
                        };
                        let found = within.power(&kept, h, y, &[force], &mut DissipationBuffer::default());
                        // a motion comes to rest in a tenth of the step
                        let pieces = if damping == "\"2e6 N s/m\"" { 40_000 } else { 1000 };
                        let wanted: f64 =
                            (0..pieces).map(|i| form.value(&at(h * (f64::from(i) + 0.5) / f64::from(pieces)))).sum();
                        let wanted = wanted / f64::from(pieces);
                        assert!(
                            wanted > 0.0 && (found - wanted).abs() < limit * wanted,
                            "{damping} {i}: {found} {wanted}"
                        );
                    }
                });
            }
        }
    }
}
