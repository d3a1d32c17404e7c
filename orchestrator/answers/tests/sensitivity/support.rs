//! Functions with known indices, and points to evaluate them at.
//!
//! The designs of studies belong to another package and are tested there.

use bladeoff_answers::sensitivity::{Index, Indices, Moved, OfParameter};
use bladeoff_system::random::{SplitMix, finaliser};
use std::f64::consts::PI;

/// Ishigami's function with a = 7, b = 0.1, over the unit cube.
pub fn ishigami(u: &[f64]) -> f64 {
    let x: Vec<f64> = u.iter().map(|u| -PI + 2.0 * PI * u).collect();
    libm::sin(x[0]) + 7.0 * libm::sin(x[1]) * libm::sin(x[1]) + 0.1 * x[2] * x[2] * x[2] * x[2] * libm::sin(x[0])
}

/// First-order and total index of each parameter.
pub const ISHIGAMI: [(f64, f64); 3] =
    [(0.313905191147811, 0.557588855209959), (0.442411144790041, 0.442411144790041), (0.0, 0.243683664062148)];

/// Coefficients of the g-function of Sobol.
pub const G: [f64; 4] = [0.0, 1.0, 4.5, 9.0];

pub fn g_function(u: &[f64]) -> f64 {
    u.iter().zip(G).map(|(u, a)| ((4.0 * u - 2.0).abs() + a) / (1.0 + a)).product()
}

/// First order, total and second order of the g-function.
pub fn of_g(i: usize, j: usize) -> (f64, f64, f64) {
    let of = |a: f64| 1.0 / (3.0 * (1.0 + a) * (1.0 + a));
    let all = G.iter().map(|a| 1.0 + of(*a)).product::<f64>();
    let variance = all - 1.0;
    let v = of(G[i]);
    (v / variance, v * all / (1.0 + v) / variance, v * of(G[j]) / variance)
}

pub fn names(count: usize) -> Vec<String> {
    (0..count).map(|i| format!("x{i}")).collect()
}

/// A random stream that is independent of those of other seeds: successive states of the generator form one stream.
fn stream(seed: u64) -> SplitMix {
    SplitMix(finaliser(finaliser(seed.wrapping_add(0x5eed)) ^ seed))
}

pub fn points(seed: u64, count: usize, dimensions: usize) -> Vec<Vec<f64>> {
    let mut random = stream(seed);
    (0..count).map(|_| (0..dimensions).map(|_| random.unit()).collect()).collect()
}

/// Direction numbers of the first dimensions of Sobol's sequence: degree, polynomial, initial numbers (S. Joe, F. Y. Kuo, 2008).
const JOE_KUO: [(usize, u64, [u64; 5]); 7] = [
    (1, 0, [1, 0, 0, 0, 0]),
    (2, 1, [1, 3, 0, 0, 0]),
    (3, 1, [1, 3, 1, 0, 0]),
    (3, 2, [1, 1, 1, 0, 0]),
    (4, 1, [1, 1, 3, 3, 0]),
    (4, 4, [1, 3, 5, 13, 0]),
    (5, 2, [1, 1, 5, 5, 17]),
];
const BITS: usize = 32;

/// Points of Sobol's sequence in up to eight dimensions, from index 0; the bits of each dimension are shifted by `shift`.
pub fn sobol_points(count: usize, shift: &[u64]) -> Vec<Vec<f64>> {
    let directions: Vec<[u64; BITS]> = (0..shift.len())
        .map(|dimension| {
            let mut m = [1u64; BITS];
            if dimension > 0 {
                let (degree, polynomial, initial) = JOE_KUO[dimension - 1];
                m[..degree].copy_from_slice(&initial[..degree]);
                for k in degree..BITS {
                    m[k] = m[k - degree] ^ m[k - degree] << degree;
                    for j in 1..degree {
                        if polynomial >> (degree - 1 - j) & 1 == 1 {
                            m[k] ^= m[k - j] << j;
                        }
                    }
                }
            }
            std::array::from_fn(|k| m[k] << (BITS - 1 - k))
        })
        .collect();
    let coordinate = |index: usize, dimension: usize| {
        let gray = index ^ index >> 1;
        let bits =
            (0..BITS).filter(|k| gray >> k & 1 == 1).fold(shift[dimension], |bits, k| bits ^ directions[dimension][k]);
        bits as f64 / (1u64 << BITS) as f64
    };
    (0..count).map(|index| (0..shift.len()).map(|dimension| coordinate(index, dimension)).collect()).collect()
}

/// A coordinate with nested uniform scrambling: each bit is flipped by a random bit that depends on the bits above.
pub fn nested(coordinate: f64, key: u64) -> f64 {
    let bits = (coordinate * (1u64 << BITS) as f64) as u64;
    let flip = |level: usize| {
        let node = 1u64 << level | bits >> (BITS - level);
        finaliser(key ^ finaliser(node)) >> 63 << (BITS - 1 - level)
    };
    let scrambled = (0..BITS).fold(bits, |scrambled, level| scrambled ^ flip(level));
    (scrambled as f64 + 0.5) / (1u64 << BITS) as f64
}

/// Rows of Saltelli's layout from points with twice as many dimensions.
pub fn saltelli(f: impl Fn(&[f64]) -> f64, points: &[Vec<f64>], second_order: bool) -> Vec<Option<f64>> {
    let mut rows = Vec::new();
    for point in points {
        let d = point.len() / 2;
        let (a, b) = point.split_at(d);
        let with = |most: &[f64], other: &[f64], i: usize| {
            let mut point = most.to_vec();
            point[i] = other[i];
            point
        };
        rows.push(Some(f(a)));
        rows.extend((0..d).map(|i| Some(f(&with(a, b, i)))));
        if second_order {
            rows.extend((0..d).map(|i| Some(f(&with(b, a, i)))));
        }
        rows.push(Some(f(b)));
    }
    rows
}

/// Rows and steps of a trajectory on four levels from these starts, in this order of parameters.
pub fn trajectory(
    f: &dyn Fn(&[f64]) -> f64,
    starts: &[usize],
    order: &[usize],
    rows: &mut Vec<Option<f64>>,
    moves: &mut Vec<Option<Moved>>,
) {
    let mut point: Vec<f64> = starts.iter().map(|level| *level as f64 / 3.0).collect();
    rows.push(Some(f(&point)));
    moves.push(None);
    for &parameter in order {
        let up = starts[parameter] < 2;
        point[parameter] = (if up { starts[parameter] + 2 } else { starts[parameter] - 2 }) as f64 / 3.0;
        rows.push(Some(f(&point)));
        moves.push(Some(Moved { parameter, up }));
    }
}

/// Random trajectories on four levels.
pub fn trajectories(
    f: &dyn Fn(&[f64]) -> f64,
    seed: u64,
    count: usize,
    parameters: usize,
) -> (Vec<Option<f64>>, Vec<Option<Moved>>) {
    let mut random = stream(seed);
    let (mut rows, mut moves) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let starts: Vec<usize> = (0..parameters).map(|_| random.below(4) as usize).collect();
        let mut order: Vec<usize> = (0..parameters).collect();
        (1..parameters).rev().for_each(|i| order.swap(i, random.below(i as u64 + 1) as usize));
        trajectory(f, &starts, &order, &mut rows, &mut moves);
    }
    (rows, moves)
}

/// Step size on four levels.
pub const DELTA: f64 = 2.0 / 3.0;

pub fn figure(found: &Indices, i: usize, of: fn(&OfParameter) -> Option<Index>) -> Index {
    of(&found.of[i].1).expect("a figure")
}

#[track_caller]
pub fn near(found: Index, expected: f64, within: f64) {
    let found = found.estimate.expect("an estimate");
    assert!((found - expected).abs() <= within, "{found} is not {expected}");
}

#[track_caller]
pub fn holds(found: Index, expected: f64) {
    let (low, high) = (found.low.expect("a lower limit"), found.high.expect("an upper limit"));
    assert!(low <= expected && expected <= high, "{low} to {high} does not hold {expected}");
    let estimate = found.estimate.expect("an estimate");
    assert!(low <= estimate && estimate <= high && low < high, "{found:?}");
}
