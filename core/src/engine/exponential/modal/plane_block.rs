//! Functions of a real 2 x 2 block: what a pair of motions does in a step, exactly.
//!
//! ```text
//! B = m 1 + D,  D traceless,  D^2 = delta 1:     f(B) = f_a 1 + f_b D                                                    (1)
//! eigenvalues z = m +- sqrt(delta):              f_a = [f(z1) + f(z2)]/2,  f_b = [f(z1) - f(z2)]/(z1 - z2)                (2)
//! free      exp(B h):  f_a = e^{mh} cosh r,  f_b = h e^{mh} sinh(r)/r,  r^2 = delta h^2                                     (3)
//! harmonic  y' = B y + Re(l F e^{iWt}),  F e^{iWt} = f in the middle of the step:
//!           y+ = exp(B h) y + Re(g(B) l f),   g(z) = (e^{iWh/2} - e^{zh - iWh/2})/(iW - z) = h e^{zh/2} sinh(s)/s,  s = (iW - z) h/2   (4)
//! ```
//! Both branches of (3) meet at delta = 0: a pair of conjugate eigenvalues, two real ones, and the double one between are one case. The
//! phase in the middle of the step makes (4) insensitive to a small error of W: of second order in `W h`.
//! Source: Sylvester's formula (1), variation of constants (4). Limits: none of the step. Verified by the tests below and the closed forms of
//! `tests/exponential.rs`.

use nalgebra::Complex;

/// A real 2 x 2 matrix, by rows.
pub(crate) type PlaneBlock = [f64; 4];

/// |B|, a pair's rate where it swings.
pub(crate) fn block_norm(b: &PlaneBlock) -> f64 {
    (0.5 * b.iter().map(|entry| entry * entry).sum::<f64>()).sqrt()
}

/// Both eigenvalues (re, im); of conjugates the one with im > 0 first.
pub(crate) fn eigenvalues(b: &PlaneBlock) -> [[f64; 2]; 2] {
    let SplitBlock { mean, square, .. } = SplitBlock::of(b);
    let root = square.abs().sqrt();
    if square < 0.0 { [[mean, root], [mean, -root]] } else { [[mean + root, 0.0], [mean - root, 0.0]] }
}

/// Below this `|delta| h^2` the series of (3) are exact to rounding, and (2) is a difference of two that are nearly one.
const EQUAL_EIGENVALUES: f64 = 1e-6;
/// Below this `|s|` sinh(s)/s by its series: the plain form would lose digits.
const SMALL: f64 = 0.25;

/// B taken apart: m, D and delta.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SplitBlock {
    mean: f64,
    traceless: PlaneBlock,
    square: f64,
}

/// What a step is driven by: `e^{iWh/2}`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Harmonic {
    rate: f64,
    h: f64,
    ahead: Complex<f64>,
}

/// `exp(B h)`, and f_a and f_b of g; none where the eigenvalues are nearly one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockStep {
    pub free: PlaneBlock,
    response: Option<(Complex<f64>, Complex<f64>)>,
}

/// An eigenvalue, `e^{zh/2}` and `e^{zh}`.
struct Eigenvalue {
    z: Complex<f64>,
    half: Complex<f64>,
    whole: Complex<f64>,
}

impl SplitBlock {
    pub fn of(b: &PlaneBlock) -> Self {
        let (mean, half) = (0.5 * (b[0] + b[3]), 0.5 * (b[0] - b[3]));
        Self { mean, traceless: [half, b[1], b[2], -half], square: half * half + b[1] * b[2] }
    }

    /// `exp(B h)`, by (3).
    pub fn exponential(&self, h: f64) -> PlaneBlock {
        let (x, decay) = (self.square * h * h, libm::exp(self.mean * h));
        let (same, turned) = if x < -EQUAL_EIGENVALUES {
            let r = (-x).sqrt();
            let (sin, cos) = libm::sincos(r);
            (decay * cos, decay * sin / r)
        } else if x > EQUAL_EIGENVALUES {
            // not cosh and sinh: each may be beyond all numbers where the product is small
            let r = x.sqrt();
            let (slow, fast) = (libm::exp(self.mean * h + r), libm::exp(self.mean * h - r));
            (0.5 * (slow + fast), 0.5 * (slow - fast) / r)
        } else {
            (decay * (1.0 + x * (0.5 + x / 24.0)), decay * (1.0 + x * (1.0 / 6.0 + x / 120.0)))
        };
        let [a, b, c, d] = self.traceless.map(|entry| entry * (h * turned));
        [same + a, b, c, same + d]
    }

    /// `exp(B h)` and g(B) of one step.
    pub fn step(&self, drive: &Harmonic) -> BlockStep {
        let h = drive.h;
        if (self.square * h * h).abs() <= EQUAL_EIGENVALUES {
            return BlockStep { free: self.exponential(h), response: None };
        }
        let roots = if self.square < 0.0 {
            // one exponential of half a step for all
            let turn = (-self.square).sqrt();
            let root = Eigenvalue::new(Complex::new(self.mean, turn), h);
            let other = Eigenvalue { z: root.z.conj(), half: root.half.conj(), whole: root.whole.conj() };
            [root, other]
        } else {
            let root = self.square.sqrt();
            [self.mean + root, self.mean - root].map(|z| Eigenvalue::new(Complex::new(z, 0.0), h))
        };
        let distance = roots[0].z - roots[1].z;
        let of = |one: Complex<f64>, other: Complex<f64>| ((one + other) * 0.5, (one - other) / distance);
        let (same, turned) = of(roots[0].whole, roots[1].whole);
        let [a, b, c, d] = self.traceless.map(|entry| entry * turned.re);
        let [one, other] = roots.each_ref().map(|root| root.response(drive));
        BlockStep { free: [same.re + a, b, c, same.re + d], response: Some(of(one, other)) }
    }

    /// `g(B) l`, by (4), for a complex l.
    pub fn harmonic(&self, rate: f64, h: f64, l: [Complex<f64>; 2]) -> [Complex<f64>; 2] {
        let drive = Harmonic::new(rate, h);
        self.step(&drive).harmonic(self, &drive, l)
    }

    /// The same where the eigenvalues are nearly one: `(iW - B)^-1 (e^{iWh/2} - e^{-iWh/2} exp(B h)) l`.
    fn harmonic_of_one(&self, drive: &Harmonic, l: [Complex<f64>; 2]) -> [Complex<f64>; 2] {
        let Harmonic { rate, h, ahead } = *drive;
        let away = Complex::new(-self.mean, rate);
        if away.norm_sqr() * h * h < EQUAL_EIGENVALUES * EQUAL_EIGENVALUES {
            // hardly any motion in a step: g = h (1 + B h/2)
            let [a, b, c, d] = self.traceless.map(|entry| 0.5 * h * entry);
            let same = 1.0 + 0.5 * h * self.mean;
            return [(l[0] * (same + a) + l[1] * b) * h, (l[0] * c + l[1] * (same + d)) * h];
        }
        let e = self.exponential(h);
        let back = ahead.conj();
        let rest =
            [ahead * l[0] - back * (l[0] * e[0] + l[1] * e[1]), ahead * l[1] - back * (l[0] * e[2] + l[1] * e[3])];
        // (away - D)^-1 = (away + D)/(away^2 - delta)
        let d = &self.traceless;
        let scale = (away * away - self.square).inv();
        [
            (rest[0] * away + rest[0] * d[0] + rest[1] * d[1]) * scale,
            (rest[1] * away + rest[0] * d[2] + rest[1] * d[3]) * scale,
        ]
    }

    /// Response to a constant force l over the step: (4) with W = 0.
    pub fn constant_response(&self, h: f64, l: [f64; 2]) -> [f64; 2] {
        self.harmonic(0.0, h, l.map(|part| Complex::new(part, 0.0))).map(|part| part.re)
    }
}

impl BlockStep {
    /// `g(B) l` for a complex l.
    pub fn harmonic(&self, split: &SplitBlock, drive: &Harmonic, l: [Complex<f64>; 2]) -> [Complex<f64>; 2] {
        let Some((same, turned)) = self.response else { return split.harmonic_of_one(drive, l) };
        let d = &split.traceless;
        [same * l[0] + turned * (l[0] * d[0] + l[1] * d[1]), same * l[1] + turned * (l[0] * d[2] + l[1] * d[3])]
    }
}

impl Harmonic {
    /// A force that turns at a rate, over a step of `h` \[s\].
    pub fn new(rate: f64, h: f64) -> Self {
        let (sin, cos) = libm::sincos(0.5 * rate * h);
        Self { rate, h, ahead: Complex::new(cos, sin) }
    }
}

impl Eigenvalue {
    fn new(z: Complex<f64>, h: f64) -> Self {
        let half = exp(z * (0.5 * h));
        Self { z, half, whole: half * half }
    }

    /// g(z) of (4).
    fn response(&self, drive: &Harmonic) -> Complex<f64> {
        let away = Complex::new(-self.z.re, drive.rate - self.z.im);
        let s = away * (0.5 * drive.h);
        if s.norm_sqr() < SMALL * SMALL {
            // the term behind the last is below 1e-18
            let square = s * s;
            let mut series = Complex::new(1.0, 0.0);
            for times in [1.0 / 156.0, 1.0 / 110.0, 1.0 / 72.0, 1.0 / 42.0, 1.0 / 20.0, 1.0 / 6.0] {
                series = series * square * times + 1.0;
            }
            return self.half * series * drive.h;
        }
        (drive.ahead - self.whole * drive.ahead.conj()) / away
    }
}

fn exp(z: Complex<f64>) -> Complex<f64> {
    let size = libm::exp(z.re);
    if z.im == 0.0 {
        return Complex::new(size, 0.0);
    }
    let (sin, cos) = libm::sincos(z.im);
    Complex::new(cos, sin) * size
}

#[cfg(test)]
mod tests {
    use super::*;

    /// exp(B h) by its series after halving, independent of (1) to (3).
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

    /// Conjugate, real, double and nearly double eigenvalues, and no damping.
    const BLOCKS: [PlaneBlock; 6] = [
        [-0.3, 2.0, -2.5, -0.1],
        [-1.0, 0.5, 0.4, -2.0],
        [0.0, 1.0, -1.0, -2.0],
        [0.0, 1.0, -1.0, -2.000_000_1],
        [0.0, 1.0, -1.0, -1.999_999_9],
        [0.0, 1.0, -4.0, 0.0],
    ];

    #[test]
    fn the_exponential_of_every_kind_of_pair_is_that_of_its_series() {
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
    fn a_fast_real_pair_ends_in_nothing_and_not_in_infinity() {
        let found = SplitBlock::of(&[0.0, 1.0, -1.0, -4e6]).exponential(1e-3);
        assert!(found.iter().all(|entry| entry.is_finite()) && (found[0] - 1.0).abs() < 1e-6);
        let response = SplitBlock::of(&[0.0, 1.0, -1.0, -4e6]).harmonic(
            100.0,
            1e-3,
            [Complex::new(0.0, 0.0), Complex::new(1.0, 0.0)],
        );
        assert!(response.iter().all(|entry| entry.re.is_finite() && entry.im.is_finite()));
    }

    /// Steady motion under `l f e^{iWt}`, `(iW - B)^-1 l f`, stays steady in a step.
    #[test]
    fn a_steady_motion_stays_steady_whatever_the_step() {
        let l = [Complex::new(0.7, -0.2), Complex::new(0.1, 1.3)];
        for block in &BLOCKS[..5] {
            for (rate, h) in [(1.9, 1e-3), (1.9, 0.4), (0.0, 3.0), (7.0, 1.0)] {
                let split = SplitBlock::of(block);
                let away = Complex::new(-split.mean, rate);
                let scale = (away * away - split.square).inv();
                let d = split.traceless;
                let steady = [
                    (l[0] * away + l[0] * d[0] + l[1] * d[1]) * scale,
                    (l[1] * away + l[0] * d[2] + l[1] * d[3]) * scale,
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
    fn an_undamped_pair_in_resonance_grows_with_time() {
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
    fn a_constant_force_on_a_free_mass_moves_it_by_half_the_square_of_time() {
        let found = SplitBlock::of(&[0.0, 1.0, 0.0, 0.0]).constant_response(0.5, [0.0, 1.0]);
        assert!((found[0] - 0.125).abs() < 1e-15 && (found[1] - 0.5).abs() < 1e-15);
    }
}
