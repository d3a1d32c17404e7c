//! Dissipation: energy that damping takes over one contact step, in one speed interval, exact for steps of any length.
//!
//! ```text
//! y(t)  = eta(t) + E z,  E = exp(B t),  z = y + l J - eta(0)                      modal state after n, with an impulse J at n             (1)
//! eta   = Re[(iW - B)^-1 (l_u - i l_v) f e^{iWt}] - B^-1 l_w                      steady response to the unbalances f and the weight     (2)
//! P h   = h lost(<y>) + z^T Q z,   Q = int E^T D E dt - (int E dt)^T D (int E dt)/h,   lost(y) = y^T D y                               (3)
//! lost  = q'^T C q' + q'^T K_a q                                                  power of the damping (`section_loads`)
//! ```
//!
//! | symbol | quantity |
//! |---|---|
//! | `P` | mean power of the damping over the step \[W\] |
//! | `<y>` | mean modal state over the step |
//! | `z` | transient part of the modal state just after the impulse |
//! | `D` | matrix of the power `lost` on the modal state |
//! | `Q` | additional loss by the variation of the transient within the step |
//! | `B`, `l` | plane blocks, input vectors (`l_u`, `l_v` of an unbalance, `l_w` of the weight) |
//!
//! The power of the mean velocities at n would not be enough where impulses act in every step: between two of them the velocities of a whipping rotor fall by much
//! of the jump of one impulse. (3) neglects how eta rotates within the step, of second order in `W h`.
//! A plane as slow as the spin (`SLOW_RATIO`) may be in resonance with the unbalance, with eta many times as large as y. The eta of such a plane contains the response to the weight only. The
//! response of its `<y>` to the unbalance is a power series in h. The neglected part is then small compared with y.
//!
//! The integrals use Gauss-Legendre quadrature with six points on each of four pieces, which become shorter towards the impulse: a plane may decay within a hundredth of the step.
//! D and Q are computed at the modal bases and interpolated linearly, as all quantities of a speed interval.
//! Verified by `free_motion_dissipates_its_loss_of_energy`, `forced_motion_dissipates_the_integral_of_the_power`, `dissipation_is_linear_between_bases` (`speed_grid.rs`) and the energy balances of `tests/exponential/exponential_run.rs`.

use super::interval_model::IntervalModel;
use super::plane_block::{PlaneBlock, SplitBlock, block_norm};
use super::quadratic_form::QuadraticForm;
use super::row_batch::Interpolate;
use bladeoff_numerics::linalg::Matrix;
use bladeoff_numerics::linalg::lanes::kernel;
use nalgebra::Complex;

/// Positive abscissas and weights of the six-point Gauss-Legendre quadrature on -1 to 1.
const QUADRATURE: [(f64, f64); 3] = [
    (0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_4),
];
/// Ends of the quadrature pieces, as shares of the step.
const PIECE_ENDS: [f64; 5] = [0.0, 1.0 / 256.0, 1.0 / 32.0, 1.0 / 4.0, 1.0];
/// Largest ratio of |B| to W of a slow plane.
const SLOW_RATIO: f64 = 1.5;
/// Largest `|B| h` of a slow plane.
const SLOW_ANGLE: f64 = 0.1;

/// Dissipation of the modal state over one contact step.
#[derive(Debug, Clone, Default)]
pub(crate) struct Dissipation {
    /// D: power of a modal state \[W\].
    power_form: QuadraticForm,
    /// Q: additional loss of the transient over the step \[J\].
    variation_form: QuadraticForm,
    /// `int E dt/h` of each plane: mean of the transient per z.
    mean_blocks: Vec<PlaneBlock>,
}

/// Contributions of the forces to z and `<y>` in (3), in one speed interval.
///
/// Contributions of an unbalance are complex per unit force, as real and imaginary parts.
#[derive(Debug)]
pub(crate) struct ForcedDissipation {
    /// eta at n of each unbalance.
    unbalance_response: Vec<[Vec<f64>; 2]>,
    /// Contribution of each unbalance to `<y>`, in addition to the mean of E y.
    unbalance_mean: Vec<[Vec<f64>; 2]>,
    /// Static response of the weight.
    weight_response: Vec<f64>,
    /// Contribution of the weight to `<y>`, in addition to the mean of E y.
    weight_mean: Vec<f64>,
}

/// Buffers for z and `<y>`.
#[derive(Debug, Clone, Default)]
pub(crate) struct DissipationBuffer {
    z: Vec<f64>,
    mean: Vec<f64>,
}

impl Dissipation {
    /// Dissipation over steps of `h` \[s\], of plane blocks and the matrix `d` of the power.
    pub fn new(blocks: &[PlaneBlock], d: &Matrix, h: f64) -> Self {
        let split: Vec<SplitBlock> = blocks.iter().map(SplitBlock::of).collect();
        let d = (d + d.transpose()) * 0.5;
        let mut q = Matrix::zeros(d.nrows(), d.ncols());
        let (mut mean, mut entries) = (vec![[0.0; 4]; blocks.len()], Default::default());
        for piece in PIECE_ENDS.windows(2) {
            let (middle, half) = (0.5 * h * (piece[0] + piece[1]), 0.5 * h * (piece[1] - piece[0]));
            for &(abscissa, weight) in &QUADRATURE {
                for t in [middle - abscissa * half, middle + abscissa * half] {
                    let exponentials: Vec<PlaneBlock> = split.iter().map(|block| block.exponential(t)).collect();
                    add_congruence(&mut q, weight * half, &d, &exponentials, &mut entries);
                    for (sum, exponential) in mean.iter_mut().flatten().zip(exponentials.iter().flatten()) {
                        *sum += weight * half / h * exponential;
                    }
                }
            }
        }
        add_congruence(&mut q, -h, &d, &mean, &mut entries);
        Self { power_form: QuadraticForm::new(&d), variation_form: QuadraticForm::new(&q), mean_blocks: mean }
    }

    /// Power of the damping in a modal state \[W\].
    pub fn power_at(&self, y: &[f64]) -> f64 {
        self.power_form.value(y)
    }

    /// Mean power P \[W\] over a step of `h` \[s\] that begins with the modal state y, after the impulse, under the forces of the unbalances \[N\].
    pub fn power(
        &self,
        forced: &ForcedDissipation,
        h: f64,
        y: &[f64],
        forces: &[Complex<f64>],
        buffer: &mut DissipationBuffer,
    ) -> f64 {
        let DissipationBuffer { z, mean } = buffer;
        z.clear();
        z.extend(y.iter().zip(&forced.weight_response).map(|(y, weight_response)| y - weight_response));
        mean.clear();
        mean.extend_from_slice(&forced.weight_mean);
        for ((force, unbalance_response), unbalance_mean) in
            forces.iter().zip(&forced.unbalance_response).zip(&forced.unbalance_mean)
        {
            apply_force([force.re, force.im], unbalance_response, unbalance_mean, z, mean);
        }
        add_transient_means(&self.mean_blocks, y, mean);
        self.power_form.value(mean) + self.variation_form.value(z) / h
    }
}

impl Interpolate for Dissipation {
    fn interpolate(&mut self, [lower, upper]: [&Self; 2], factors: [f64; 2]) {
        self.power_form.interpolate([&lower.power_form, &upper.power_form], factors);
        self.variation_form.interpolate([&lower.variation_form, &upper.variation_form], factors);
        let mean = lower.mean_blocks.iter().zip(&upper.mean_blocks);
        self.mean_blocks.clear();
        self.mean_blocks.extend(
            mean.map(|(a, b)| -> PlaneBlock { std::array::from_fn(|i| factors[0] * a[i] + factors[1] * b[i]) }),
        );
    }
}

impl ForcedDissipation {
    /// Contributions of the forces over steps of `h` \[s\] in the speed interval of a model, for a number of unbalances.
    pub fn new(model: &IntervalModel, dissipation: &Dissipation, h: f64, unbalances: usize) -> Self {
        let (planes, weight) = (model.blocks.len(), &model.input_vectors[2 * unbalances]);
        let zeros = vec![0.0; 2 * planes];
        let mut forced = Self {
            unbalance_response: vec![[zeros.clone(), zeros.clone()]; unbalances],
            unbalance_mean: vec![[zeros.clone(), zeros.clone()]; unbalances],
            weight_response: zeros.clone(),
            weight_mean: zeros,
        };
        let (sin, cos) = libm::sincos(0.5 * model.speed * h);
        let middle = Complex::new(cos, sin) * (sin / (0.5 * model.speed * h));
        for (k, (b, mean)) in model.blocks.iter().zip(&dissipation.mean_blocks).enumerate() {
            let entries = [k, planes + k];
            let weight_response = static_response(b, entries.map(|at| weight[at]));
            let [first, second] = weight_response;
            let mean_of_transient = [mean[0] * first + mean[1] * second, mean[2] * first + mean[3] * second];
            for (i, at) in entries.into_iter().enumerate() {
                (forced.weight_response[at], forced.weight_mean[at]) =
                    (weight_response[i], weight_response[i] - mean_of_transient[i]);
            }
            for (s, [u, v]) in model.input_vectors.as_chunks::<2>().0[..unbalances].iter().enumerate() {
                let input_vector = entries.map(|at| Complex::new(u[at], -v[at]));
                let (eta, of_mean) = if is_slow_plane(b, model.speed, h) {
                    ([Complex::default(); 2], mean_slow_response(b, model.speed, h, input_vector))
                } else {
                    let eta = harmonic_response(b, model.speed, input_vector);
                    (eta, [0, 1].map(|i| eta[i] * middle - eta[0] * mean[2 * i] - eta[1] * mean[2 * i + 1]))
                };
                for (i, at) in entries.into_iter().enumerate() {
                    (forced.unbalance_response[s][0][at], forced.unbalance_response[s][1][at]) = (eta[i].re, eta[i].im);
                    (forced.unbalance_mean[s][0][at], forced.unbalance_mean[s][1][at]) = (of_mean[i].re, of_mean[i].im);
                }
            }
        }
        forced
    }
}

kernel! {
    /// Subtracts the response to a force from z and adds its contribution to the mean.
    fn apply_force(force: [f64; 2], unbalance_response: &[Vec<f64>; 2], of_mean: &[Vec<f64>; 2], z: &mut [f64], mean: &mut [f64]) {
        let ([f, g], [re, im], [mean_re, mean_im]) = (force, unbalance_response, of_mean);
        for ((z, re), im) in z.iter_mut().zip(re).zip(im) {
            *z -= f * re - g * im;
        }
        for ((mean, re), im) in mean.iter_mut().zip(mean_re).zip(mean_im) {
            *mean += f * re - g * im;
        }
    }
}

kernel! {
    /// Adds the mean of E y over the step to the mean.
    fn add_transient_means(blocks: &[PlaneBlock], y: &[f64], mean: &mut [f64]) {
        let planes = blocks.len();
        let ((y_a, y_b), (mean_a, mean_b)) = (y.split_at(planes), mean.split_at_mut(planes));
        for k in 0..planes {
            let b = &blocks[k];
            mean_a[k] += b[0] * y_a[k] + b[1] * y_b[k];
            mean_b[k] += b[2] * y_a[k] + b[3] * y_b[k];
        }
    }
}

/// Whether a plane is slow: it may be in resonance with the unbalance, and hardly moves within a step.
fn is_slow_plane(b: &PlaneBlock, speed: f64, h: f64) -> bool {
    let norm = block_norm(b);
    norm < SLOW_RATIO * speed.abs() && norm * h < SLOW_ANGLE
}

/// Mean response over a step of a slow plane, from rest, to a force `e^{iWt}`: `1/h int int_0^t e^{B(t-s)} e^{iWs} ds dt l`, to second order in h.
fn mean_slow_response(b: &PlaneBlock, speed: f64, h: f64, l: [Complex<f64>; 2]) -> [Complex<f64>; 2] {
    let on = |i: usize| l[0] * b[2 * i] + l[1] * b[2 * i + 1] + Complex::new(0.0, speed) * l[i];
    [0, 1].map(|i| (l[i] + on(i) * (h / 3.0)) * (0.5 * h))
}

/// Static response `-B^-1 w`; zero for a plane without stiffness.
fn static_response(b: &PlaneBlock, w: [f64; 2]) -> [f64; 2] {
    let determinant = b[0] * b[3] - b[1] * b[2];
    if w == [0.0; 2] || determinant == 0.0 {
        return [0.0; 2];
    }
    [b[1] * w[1] - b[3] * w[0], b[2] * w[0] - b[0] * w[1]].map(|part| part / determinant)
}

/// Steady response `(iW - B)^-1 l` of a plane that is not slow.
fn harmonic_response(b: &PlaneBlock, speed: f64, l: [Complex<f64>; 2]) -> [Complex<f64>; 2] {
    let [diagonal_a, diagonal_b] = [b[0], b[3]].map(|part| Complex::new(-part, speed));
    let determinant = diagonal_a * diagonal_b - b[1] * b[2];
    if determinant.norm_sqr() == 0.0 {
        return [Complex::default(); 2];
    }
    [diagonal_b * l[0] + l[1] * b[1], l[0] * b[2] + diagonal_a * l[1]].map(|part| part / determinant)
}

/// Adds `factor E^T D E` to a sum, with E of plane blocks; `entries`: buffer for the entries of E, one list per position in the block.
fn add_congruence(sum: &mut Matrix, factor: f64, d: &Matrix, e: &[PlaneBlock], entries: &mut [Vec<f64>; 4]) {
    for (i, list) in entries.iter_mut().enumerate() {
        list.clear();
        list.extend(e.iter().map(|block| block[i]));
    }
    let planes = e.len();
    let columns = d.as_slice().chunks_exact(2 * planes);
    let (first, second) = (columns.clone().take(planes), columns.skip(planes));
    let (firsts, seconds) = sum.as_mut_slice().split_at_mut(2 * planes * planes);
    let sums = firsts.chunks_exact_mut(2 * planes).zip(seconds.chunks_exact_mut(2 * planes));
    for ((block, columns), sums) in e.iter().zip(first.zip(second)).zip(sums) {
        let [a, b, c, d] = block.map(|entry| factor * entry);
        add_column([a, c], columns, entries, sums.0);
        add_column([b, d], columns, entries, sums.1);
    }
}

kernel! {
    /// Adds `E^T` times the combination of two columns of D to a column of the sum.
    fn add_column(factors: [f64; 2], columns: (&[f64], &[f64]), entries: &[Vec<f64>; 4], sums: &mut [f64]) {
        let ([f, g], [e_aa, e_ab, e_ba, e_bb]) = (factors, entries);
        let (first, second) = columns;
        let planes = e_aa.len();
        let ((first, first_below), (second, second_below)) = (first.split_at(planes), second.split_at(planes));
        let (sums, sums_below) = sums.split_at_mut(planes);
        let (e_ab, e_ba, e_bb) = (&e_ab[..planes], &e_ba[..planes], &e_bb[..planes]);
        let (first_below, second_below, sums_below) = (&first_below[..planes], &second_below[..planes], &mut sums_below[..planes]);
        for k in 0..planes {
            let (x, y) = (f * first[k] + g * second[k], f * first_below[k] + g * second_below[k]);
            sums[k] += e_aa[k] * x + e_ba[k] * y;
            sums_below[k] += e_ab[k] * x + e_bb[k] * y;
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
    use crate::structure::Structure;
    use bladeoff_model::machine::MachineDef;
    use bladeoff_numerics::linalg::{Vector, dot};

    /// Speed of the modal basis \[rad/s\].
    const SPEED: f64 = 240.0;

    /// Calls `then` with the modal basis of the lab rig with weight, one skew bearing and one bearing of the given damping \[N s/m\].
    fn with_model(damping: &str, then: impl FnOnce(&LateralModel, &ModalBasis, &IntervalModel)) {
        with_model_at_rate(damping, |_| SPEED, then);
    }

    /// As [`with_model`], but with forces that rotate at another rate than the speed of the basis.
    fn with_model_at_rate(
        damping: &str,
        force_rate: impl Fn(&[PlaneBlock]) -> f64,
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
        let basis = ModalBasis::new(&model, SPEED, None).expect("has a basis");
        let interval = IntervalModel { speed: force_rate(&basis.blocks), ..basis.interval_model.clone() };
        then(&model, &basis, &interval);
    }

    /// Transient `exp(B t) z`.
    fn after(interval: &IntervalModel, z: &[f64], t: f64) -> Vec<f64> {
        let (planes, mut y) = (interval.blocks.len(), z.to_vec());
        for (k, block) in interval.blocks.iter().enumerate() {
            let e = SplitBlock::of(block).exponential(t);
            y[k] = e[0] * z[k] + e[1] * z[planes + k];
            y[planes + k] = e[2] * z[k] + e[3] * z[planes + k];
        }
        y
    }

    /// Reproducible pseudo-random numbers between -0.5 and 0.5.
    fn random(count: usize) -> Vec<f64> {
        let mut seed = 7_u64;
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn free_motion_dissipates_its_loss_of_energy() {
        // with the last damping, a plane decays within a tenth of the step
        for (damping, limit) in [("\"600 N s/m\"", 1e-9), ("\"6e4 N s/m\"", 1e-4), ("\"2e6 N s/m\"", 1e-3)] {
            with_model(damping, |model, basis, interval| {
                let n = model.state_space.size;
                // without the energy of the spin: at constant speed the gyroscopic moments do no work
                let [stiffness, mass] = model.state_space.energy_matrices();
                let energy = |y: &[f64]| {
                    let motion = &basis.motion_of_state * Vector::from_column_slice(y);
                    let (q, rates) = (motion.rows(0, n), motion.rows(n, n));
                    let twice = (rates.transpose() * mass * rates)[(0, 0)] + (q.transpose() * stiffness * q)[(0, 0)];
                    0.5 * twice - dot(model.outputs.weight(), q.as_slice())
                };
                let y = random(2 * n);
                for h in [1e-6, 5e-6, 5e-5] {
                    let power_matrix =
                        model.measures.damping_power_matrix(&model.state_space, SPEED, &basis.motion_of_state);
                    let dissipation = Dissipation::new(&basis.blocks, &power_matrix, h);
                    let forced = ForcedDissipation::new(interval, &dissipation, h, 1);
                    let weight_response = &forced.weight_response;
                    let z: Vec<f64> =
                        y.iter().zip(weight_response).map(|(y, weight_response)| y - weight_response).collect();
                    let end: Vec<f64> = after(interval, &z, h)
                        .iter()
                        .zip(weight_response)
                        .map(|(z, weight_response)| z + weight_response)
                        .collect();
                    let found =
                        dissipation.power(&forced, h, &y, &[Complex::default()], &mut DissipationBuffer::default());
                    let wanted = (energy(&y) - energy(&end)) / h;
                    assert!(wanted > 0.0 && (found - wanted).abs() < limit * wanted, "{damping} {h}: {found} {wanted}");
                }
            });
        }
    }

    /// Compared with the power in small time steps, for the steady response and for motions that are small beside the response in resonance.
    #[test]
    fn forced_motion_dissipates_the_integral_of_the_power() {
        let lowest = |blocks: &[PlaneBlock]| {
            let rates = blocks.iter().map(|b| (b[0] * b[3] - b[1] * b[2]).sqrt());
            rates.filter(|rate| *rate > 100.0).fold(f64::INFINITY, f64::min)
        };
        // rates between two planes, in resonance with the lowest, and on both sides of the limit of a slow plane
        let rates_of_the_force: [&dyn Fn(&[PlaneBlock]) -> f64; 4] =
            [&|_| SPEED, &lowest, &|blocks| lowest(blocks) / 1.4, &|blocks| lowest(blocks) / 2.9];
        for damping in ["\"60 N s/m\"", "\"600 N s/m\"", "\"2e6 N s/m\""] {
            for (i, force_rate) in rates_of_the_force.into_iter().enumerate() {
                with_model_at_rate(damping, force_rate, |model, basis, interval| {
                    let (n, force, h) = (model.state_space.size, Complex::new(300.0, -120.0), 2e-5);
                    let power_matrix =
                        model.measures.damping_power_matrix(&model.state_space, SPEED, &basis.motion_of_state);
                    let (dissipation, form) =
                        (Dissipation::new(&basis.blocks, &power_matrix, h), QuadraticForm::new(&power_matrix));
                    let forced = ForcedDissipation::new(interval, &dissipation, h, 1);
                    let steady_state = |t: f64| -> Vec<f64> {
                        let (sin, cos) = libm::sincos(interval.speed * t);
                        let mut y = vec![0.0; 2 * n];
                        for (k, b) in interval.blocks.iter().enumerate() {
                            let entries = [k, n + k];
                            let input_vector = entries
                                .map(|at| Complex::new(interval.input_vectors[0][at], -interval.input_vectors[1][at]));
                            let unbalance_response = harmonic_response(b, interval.speed, input_vector);
                            let weight_response = static_response(b, entries.map(|at| interval.input_vectors[2][at]));
                            for (i, at) in entries.into_iter().enumerate() {
                                y[at] =
                                    (unbalance_response[i] * force * Complex::new(cos, sin)).re + weight_response[i];
                            }
                        }
                        y
                    };
                    let start = steady_state(0.0);
                    let largest = start.iter().fold(0.0_f64, |largest, part| largest.max(part.abs()));
                    // the steady state, and a motion 50 times smaller
                    let small_motion: Vec<f64> = random(2 * n).iter().map(|part| 0.02 * largest * part).collect();
                    for (y, limit) in [(&start, 1e-5), (&small_motion, 2e-4)] {
                        let z: Vec<f64> = y.iter().zip(&start).map(|(y, steady_state)| y - steady_state).collect();
                        let at = |t: f64| -> Vec<f64> {
                            after(interval, &z, t)
                                .iter()
                                .zip(steady_state(t))
                                .map(|(z, steady_state)| z + steady_state)
                                .collect()
                        };
                        let found = dissipation.power(&forced, h, y, &[force], &mut DissipationBuffer::default());
                        // a plane decays within a tenth of the step
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
