//! Plane block: functions of the real 2 x 2 matrix of one modal plane, which give the exact motion of the plane over a step.
//!
//! ```text
//! B = m 1 + D,  D traceless,  D^2 = delta 1:     f(B) = f_a 1 + f_b D                                                    (1)
//! eigenvalues z = m +- sqrt(delta):              f_a = [f(z1) + f(z2)]/2,  f_b = [f(z1) - f(z2)]/(z1 - z2)                (2)
//! free      exp(B h):  f_a = e^{mh} cosh r,  f_b = h e^{mh} sinh(r)/r,  r^2 = delta h^2                                     (3)
//! harmonic  y' = B y + Re(l F e^{iWt}),  F e^{iWt} = f in the middle of the step:
//!           y+ = exp(B h) y + Re(g(B) l f),   g(z) = (e^{iWh/2} - e^{zh - iWh/2})/(iW - z) = h e^{zh/2} sinh(s)/s,  s = (iW - z) h/2   (4)
//! ```
//!
//! | symbol | quantity |
//! |---|---|
//! | `B` | plane block \[1/s\]; `m` its mean eigenvalue, `D` its traceless part, `delta` the square of half the eigenvalue difference |
//! | `h` | length of the step \[s\] |
//! | `W` | angular rate of the force \[rad/s\] |
//! | `l` | complex input vector of the plane; `f` complex force in the middle of the step |
//! | `y`, `y+` | modal state of the plane at the beginning and at the end of the step |
//!
//! The two branches of (3) meet at delta = 0, so conjugate, real and double eigenvalues are one case. The phase of the force is taken in the middle of the
//! step: a small error of W then has an effect of second order in `W h`.
//! Source: Sylvester's formula (1), variation of constants (4). Limits: none on the length of the step. Verified by the tests below and the closed forms of
//! `tests/exponential/exponential.rs`.

use nalgebra::Complex;

/// Real 2 x 2 matrix of a modal plane \[1/s\], by rows.
pub(crate) type PlaneBlock = [f64; 4];

/// Norm |B| \[1/s\]: the angular frequency of an oscillating plane.
pub(crate) fn block_norm(b: &PlaneBlock) -> f64 {
    (0.5 * b.iter().map(|entry| entry * entry).sum::<f64>()).sqrt()
}

/// Both eigenvalues as (real, imaginary) \[1/s\]; of a conjugate pair the one with positive imaginary part first.
pub(crate) fn eigenvalues(b: &PlaneBlock) -> [[f64; 2]; 2] {
    let SplitBlock { mean, delta, .. } = SplitBlock::of(b);
    let root = delta.abs().sqrt();
    if delta < 0.0 { [[mean, root], [mean, -root]] } else { [[mean + root, 0.0], [mean - root, 0.0]] }
}

/// Value of `|delta| h^2` below which the series of (3) are exact to rounding; (2) would be a difference of two nearly equal numbers.
const EQUAL_EIGENVALUES: f64 = 1e-6;
/// Value of `|s|` below which sinh(s)/s is computed by its series; the closed form would lose digits.
const MAX_SERIES_ARGUMENT: f64 = 0.25;

/// Decomposition of a plane block by (1): m, D and delta.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SplitBlock {
    mean: f64,
    traceless: PlaneBlock,
    delta: f64,
}

/// Harmonic force over one step: its rate W \[rad/s\], the length h of the step \[s\] and the phase factor `e^{iWh/2}` of half a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Harmonic {
    rate: f64,
    h: f64,
    half_step_phase: Complex<f64>,
}

/// Step of one plane block.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockStep {
    /// `exp(B h)`.
    pub free: PlaneBlock,
    /// Coefficients f_a and f_b of g in (4); `None` for nearly equal eigenvalues.
    response: Option<(Complex<f64>, Complex<f64>)>,
}

/// Eigenvalue z of a block with its exponentials over a step.
struct Eigenvalue {
    z: Complex<f64>,
    /// `e^{zh/2}`.
    half_step: Complex<f64>,
    /// `e^{zh}`.
    full_step: Complex<f64>,
}

impl SplitBlock {
    /// Decomposition of a plane block.
    pub fn of(b: &PlaneBlock) -> Self {
        let (mean, half) = (0.5 * (b[0] + b[3]), 0.5 * (b[0] - b[3]));
        Self { mean, traceless: [half, b[1], b[2], -half], delta: half * half + b[1] * b[2] }
    }

    /// Matrix exponential `exp(B h)` over a step of `h` \[s\], by (3).
    pub fn exponential(&self, h: f64) -> PlaneBlock {
        let (x, decay) = (self.delta * h * h, libm::exp(self.mean * h));
        let (f_a, f_b) = if x < -EQUAL_EIGENVALUES {
            let r = (-x).sqrt();
            let (sin, cos) = libm::sincos(r);
            (decay * cos, decay * sin / r)
        } else if x > EQUAL_EIGENVALUES {
            // not cosh and sinh: each may overflow although the product is small
            let r = x.sqrt();
            let (slow, fast) = (libm::exp(self.mean * h + r), libm::exp(self.mean * h - r));
            (0.5 * (slow + fast), 0.5 * (slow - fast) / r)
        } else {
            (decay * (1.0 + x * (0.5 + x / 24.0)), decay * (1.0 + x * (1.0 / 6.0 + x / 120.0)))
        };
        let [a, b, c, d] = self.traceless.map(|entry| entry * (h * f_b));
        [f_a + a, b, c, f_a + d]
    }

    /// Step under a harmonic force: `exp(B h)` and the coefficients of g(B).
    pub fn step(&self, force: &Harmonic) -> BlockStep {
        let h = force.h;
        if (self.delta * h * h).abs() <= EQUAL_EIGENVALUES {
            return BlockStep { free: self.exponential(h), response: None };
        }
        let roots = if self.delta < 0.0 {
            // conjugate eigenvalues: one complex exponential is enough
            let frequency = (-self.delta).sqrt();
            let root = Eigenvalue::new(Complex::new(self.mean, frequency), h);
            let conjugate =
                Eigenvalue { z: root.z.conj(), half_step: root.half_step.conj(), full_step: root.full_step.conj() };
            [root, conjugate]
        } else {
            let root = self.delta.sqrt();
            [self.mean + root, self.mean - root].map(|z| Eigenvalue::new(Complex::new(z, 0.0), h))
        };
        let difference = roots[0].z - roots[1].z;
        let coefficients = |one: Complex<f64>, other: Complex<f64>| ((one + other) * 0.5, (one - other) / difference);
        let (f_a, f_b) = coefficients(roots[0].full_step, roots[1].full_step);
        let [a, b, c, d] = self.traceless.map(|entry| entry * f_b.re);
        let [one, other] = roots.each_ref().map(|root| root.response(force));
        BlockStep { free: [f_a.re + a, b, c, f_a.re + d], response: Some(coefficients(one, other)) }
    }

    /// Response `g(B) l` at the end of a step to a harmonic force of rate `rate` \[rad/s\], by (4).
    pub fn harmonic(&self, rate: f64, h: f64, l: [Complex<f64>; 2]) -> [Complex<f64>; 2] {
        let force = Harmonic::new(rate, h);
        self.step(&force).harmonic(self, &force, l)
    }

    /// Response to a harmonic force for nearly equal eigenvalues: `(iW - B)^-1 (e^{iWh/2} - e^{-iWh/2} exp(B h)) l`.
    fn harmonic_equal_eigenvalues(&self, force: &Harmonic, l: [Complex<f64>; 2]) -> [Complex<f64>; 2] {
        let Harmonic { rate, h, half_step_phase } = *force;
        let shifted = Complex::new(-self.mean, rate);
        if shifted.norm_sqr() * h * h < EQUAL_EIGENVALUES * EQUAL_EIGENVALUES {
            // hardly any motion within a step: g = h (1 + B h/2)
            let [a, b, c, d] = self.traceless.map(|entry| 0.5 * h * entry);
            let f_a = 1.0 + 0.5 * h * self.mean;
            return [(l[0] * (f_a + a) + l[1] * b) * h, (l[0] * c + l[1] * (f_a + d)) * h];
        }
        let e = self.exponential(h);
        let half_step_back = half_step_phase.conj();
        let right_side = [
            half_step_phase * l[0] - half_step_back * (l[0] * e[0] + l[1] * e[1]),
            half_step_phase * l[1] - half_step_back * (l[0] * e[2] + l[1] * e[3]),
        ];
        // with w = iW - m: (w - D)^-1 = (w + D)/(w^2 - delta)
        let d = &self.traceless;
        let scale = (shifted * shifted - self.delta).inv();
        [
            (right_side[0] * shifted + right_side[0] * d[0] + right_side[1] * d[1]) * scale,
            (right_side[1] * shifted + right_side[0] * d[2] + right_side[1] * d[3]) * scale,
        ]
    }

    /// Response at the end of a step to a constant force with input vector l: (4) with W = 0.
    pub fn constant_response(&self, h: f64, l: [f64; 2]) -> [f64; 2] {
        self.harmonic(0.0, h, l.map(|part| Complex::new(part, 0.0))).map(|part| part.re)
    }
}

impl BlockStep {
    /// Response `g(B) l` to a harmonic force with the complex input vector l.
    pub fn harmonic(&self, split: &SplitBlock, force: &Harmonic, l: [Complex<f64>; 2]) -> [Complex<f64>; 2] {
        let Some((f_a, f_b)) = self.response else { return split.harmonic_equal_eigenvalues(force, l) };
        let d = &split.traceless;
        [f_a * l[0] + f_b * (l[0] * d[0] + l[1] * d[1]), f_a * l[1] + f_b * (l[0] * d[2] + l[1] * d[3])]
    }
}

impl Harmonic {
    /// Force of rate W \[rad/s\] over a step of `h` \[s\].
    pub fn new(rate: f64, h: f64) -> Self {
        let (sin, cos) = libm::sincos(0.5 * rate * h);
        Self { rate, h, half_step_phase: Complex::new(cos, sin) }
    }
}

impl Eigenvalue {
    /// Eigenvalue z with its exponentials over a step of `h` \[s\].
    fn new(z: Complex<f64>, h: f64) -> Self {
        let half_step = exp(z * (0.5 * h));
        Self { z, half_step, full_step: half_step * half_step }
    }

    /// Response function g(z) of (4) at this eigenvalue.
    fn response(&self, force: &Harmonic) -> Complex<f64> {
        let shifted = Complex::new(-self.z.re, force.rate - self.z.im);
        let s = shifted * (0.5 * force.h);
        if s.norm_sqr() < MAX_SERIES_ARGUMENT * MAX_SERIES_ARGUMENT {
            // the next term of the series is below 1e-18
            let square = s * s;
            let mut series = Complex::new(1.0, 0.0);
            for times in [1.0 / 156.0, 1.0 / 110.0, 1.0 / 72.0, 1.0 / 42.0, 1.0 / 20.0, 1.0 / 6.0] {
                series = series * square * times + 1.0;
            }
            return self.half_step * series * force.h;
        }
        (force.half_step_phase - self.full_step * force.half_step_phase.conj()) / shifted
    }
}

/// Complex exponential by the functions of `libm`.
fn exp(z: Complex<f64>) -> Complex<f64> {
    let magnitude = libm::exp(z.re);
    if z.im == 0.0 {
        return Complex::new(magnitude, 0.0);
    }
    let (sin, cos) = libm::sincos(z.im);
    Complex::new(cos, sin) * magnitude
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Matrix exponential by its series with scaling and squaring, independent of (1) to (3).
    fn by_series(b: &PlaneBlock, h: f64) -> PlaneBlock {
        let times = |x: &PlaneBlock, y: &PlaneBlock| {
            [x[0] * y[0] + x[1] * y[2], x[0] * y[1] + x[1] * y[3], x[2] * y[0] + x[3] * y[2], x[2] * y[1] + x[3] * y[3]]
        };
        let part = b.map(|entry| entry * h / 1024.0);
        let (mut sum, mut term) = ([1.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]);
        for k in 1..16 {
            term = times(&term, &part).map(|entry| entry / f64::from(k));
            for i in 0..4 {
                sum[i] += term[i];
            }
        }
        for _ in 0..10 {
            sum = times(&sum, &sum);
        }
        sum
    }

    /// Blocks with conjugate, real, double and nearly double eigenvalues, and an undamped one.
    const BLOCKS: [PlaneBlock; 6] = [
        [-0.3, 2.0, -2.5, -0.1],
        [-1.0, 0.5, 0.4, -2.0],
        [0.0, 1.0, -1.0, -2.0],
        [0.0, 1.0, -1.0, -2.000_000_1],
        [0.0, 1.0, -1.0, -1.999_999_9],
        [0.0, 1.0, -4.0, 0.0],
    ];

    #[test]
    fn the_exponential_of_every_kind_of_block_equals_its_series() {
        for block in BLOCKS {
            for h in [1e-4, 0.3, 2.0] {
                let (found, series) = (SplitBlock::of(&block).exponential(h), by_series(&block, h));
                for i in 0..4 {
                    assert!((found[i] - series[i]).abs() < 2e-13, "{block:?} {h}: {found:?} {series:?}");
                }
            }
        }
    }

    #[test]
    fn a_fast_real_block_decays_without_overflow() {
        let found = SplitBlock::of(&[0.0, 1.0, -1.0, -4e6]).exponential(1e-3);
        assert!(found.iter().all(|entry| entry.is_finite()) && (found[0] - 1.0).abs() < 1e-6);
        let response = SplitBlock::of(&[0.0, 1.0, -1.0, -4e6]).harmonic(
            100.0,
            1e-3,
            [Complex::new(0.0, 0.0), Complex::new(1.0, 0.0)],
        );
        assert!(response.iter().all(|entry| entry.re.is_finite() && entry.im.is_finite()));
    }

    /// Steady motion `(iW - B)^-1 l f e^{iWt}` under a harmonic force remains steady over a step.
    #[test]
    fn steady_motion_remains_steady_for_steps_of_any_length() {
        let l = [Complex::new(0.7, -0.2), Complex::new(0.1, 1.3)];
        for block in &BLOCKS[..5] {
            for (rate, h) in [(1.9, 1e-3), (1.9, 0.4), (0.0, 3.0), (7.0, 1.0)] {
                let split = SplitBlock::of(block);
                let shifted = Complex::new(-split.mean, rate);
                let scale = (shifted * shifted - split.delta).inv();
                let d = split.traceless;
                let steady = [
                    (l[0] * shifted + l[0] * d[0] + l[1] * d[1]) * scale,
                    (l[1] * shifted + l[0] * d[2] + l[1] * d[3]) * scale,
                ];
                let (sin, cos) = libm::sincos(rate * h);
                let (half_sin, half_cos) = libm::sincos(0.5 * rate * h);
                let (e, g) = (split.exponential(h), split.harmonic(rate, h, l));
                for i in 0..2 {
                    let after =
                        steady[0] * e[2 * i] + steady[1] * e[2 * i + 1] + g[i] * Complex::new(half_cos, half_sin);
                    let wanted = steady[i] * Complex::new(cos, sin);
                    assert!((after - wanted).norm() < 1e-12, "{block:?}, W {rate}, h {h}: {after} {wanted}");
                }
            }
        }
    }

    #[test]
    fn an_undamped_plane_in_resonance_grows_linearly() {
        // q'' + 4 q = cos 2t from rest: q = t sin(2t)/4
        let (h, steps) = (0.7, 9);
        let split = SplitBlock::of(&[0.0, 1.0, -4.0, 0.0]);
        let (e, g) = (split.exponential(h), split.harmonic(2.0, h, [Complex::new(0.0, 0.0), Complex::new(1.0, 0.0)]));
        let mut y = [0.0; 2];
        for n in 0..steps {
            let (sin, cos) = libm::sincos(2.0 * h * (f64::from(n) + 0.5));
            let f = Complex::new(cos, sin);
            y = [e[0] * y[0] + e[1] * y[1] + (g[0] * f).re, e[2] * y[0] + e[3] * y[1] + (g[1] * f).re];
        }
        let t = h * f64::from(steps);
        assert!((y[0] - 0.25 * t * libm::sin(2.0 * t)).abs() < 1e-12, "{}", y[0]);
    }

    #[test]
    fn a_constant_force_on_a_free_mass_gives_half_the_square_of_time() {
        let found = SplitBlock::of(&[0.0, 1.0, 0.0, 0.0]).constant_response(0.5, [0.0, 1.0]);
        assert!((found[0] - 0.125).abs() < 1e-15 && (found[1] - 0.5).abs() < 1e-15);
    }
}
