//! Halton's sequence: the digits of the index in the base of each dimension's prime, mirrored at the point.
//!
//! ```text
//! scrambled: first digit   a P(digit) + c mod prime    P: a random permutation of the digits
//! others        a digit + c mod prime       a, c: random numbers of the tree node given by the digits above
//! ```
//! With linear permutations alone, two primes above the number of points give nearly straight lines: columns of 109 and 113 had a
//! correlation of 0.99 over 64 points. The random permutation of the first digit removes this; the shift c makes each point uniform.
//!
//! Source: J. H. Halton, "On the efficiency of certain quasi-random sequences of points" (1960); A. B. Owen, "A randomized
//! Halton algorithm in R" (2017), with the linear permutations of J. Matousek (1998).

use super::random::mixed;
use crate::sampling::shuffle::Network;

/// Most cells of a coordinate: the middle of a cell and its complement are exact.
const MOST_CELLS: u64 = 1 << 52;

/// The primes of the first dimensions.
#[must_use]
pub fn primes(count: usize) -> Vec<u64> {
    let mut primes: Vec<u64> = Vec::with_capacity(count);
    let mut candidate = 2;
    while primes.len() < count {
        if primes.iter().take_while(|&&prime| prime * prime <= candidate).all(|prime| candidate % prime != 0) {
            primes.push(candidate);
        }
        candidate += 1;
    }
    primes
}

/// The coordinate without scrambling; index 0 is the first point.
#[must_use]
pub fn plain(mut index: u64, prime: u64) -> f64 {
    let (mut mirrored, mut cells) = (0u64, 1u64);
    while index > 0 && cells <= MOST_CELLS / prime {
        mirrored = mirrored * prime + index % prime;
        cells *= prime;
        index /= prime;
    }
    mirrored as f64 / cells as f64
}

/// Scrambling of a dimension.
#[derive(Debug, Clone, Copy)]
pub struct Scramble {
    prime: u64,
    key: u64,
    first_digits: Network,
}

impl Scramble {
    /// The scrambling of a prime with a key.
    #[must_use]
    pub fn new(prime: u64, key: u64) -> Self {
        Self { prime, key, first_digits: Network::new(prime) }
    }

    /// The scrambled coordinate, in the middle of its cell.
    #[must_use]
    pub fn coordinate(&self, mut index: u64) -> f64 {
        let Self { prime, key, first_digits } = *self;
        let (mut mirrored, mut cells, mut node) = (0u64, 1u64, 0u64);
        // separate from all nodes, whose level is a number of cells
        let round = |number: u8, half: u64| mixed(key, mixed(0, u64::from(number) << 32 | half));
        while cells <= MOST_CELLS / prime {
            let digit = index % prime;
            let placed = if cells == 1 { first_digits.apply(digit, round) } else { digit };
            // the node given by the digits above: their own number, separate for each level
            let bits = mixed(key, mixed(cells, node));
            let (factor, shift) = (1 + (bits >> 32) % (prime - 1), (bits & 0xffff_ffff) % prime);
            mirrored = mirrored * prime + (factor * placed + shift) % prime;
            node = node * prime + digit;
            cells *= prime;
            index /= prime;
        }
        (mirrored as f64 + 0.5) / cells as f64
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::Source;
    use super::*;

    #[test]
    fn the_first_points_are_known() {
        assert_eq!(primes(6), [2, 3, 5, 7, 11, 13]);
        assert_eq!((0..5).map(|i| plain(i, 2)).collect::<Vec<_>>(), [0.0, 0.5, 0.25, 0.75, 0.125]);
        let thirds: Vec<f64> = (0..4).map(|i| plain(i, 3)).collect();
        assert_eq!(thirds, [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0 / 9.0]);
    }

    #[test]
    fn a_power_of_the_prime_fills_its_cells() {
        for prime in primes(30) {
            let count = prime * prime;
            let scramble = Scramble::new(prime, 77);
            let mut cells: Vec<u64> = (0..count).map(|i| (scramble.coordinate(i) * count as f64) as u64).collect();
            cells.sort_unstable();
            assert!(cells.into_iter().eq(0..count), "{prime}");
        }
        let scramble = Scramble::new(719, 1);
        let extreme = (0..100_000).map(|i| scramble.coordinate(i));
        assert!(extreme.into_iter().all(|u| u > 0.0 && u < 1.0));
    }

    /// Scramblings of the dimensions of a replicate.
    fn scrambles(dimensions: usize, replicate: u64) -> Vec<Scramble> {
        let source = Source::new(5, "halton", replicate);
        primes(dimensions).iter().enumerate().map(|(at, &prime)| Scramble::new(prime, source.key(at))).collect()
    }

    #[test]
    fn every_cell_of_the_first_digits_is_as_likely_as_the_others() {
        for prime in [2u64, 3, 5, 7, 13] {
            let mut counts = vec![0u32; (prime * prime) as usize];
            let replicates = 20_000u32;
            for key in 0..replicates {
                let u = Scramble::new(prime, mixed(u64::from(key), 9)).coordinate(3);
                counts[(u * (prime * prime) as f64) as usize] += 1;
            }
            let mean = f64::from(replicates) / (prime * prime) as f64;
            let chi: f64 = counts.iter().map(|&count| (f64::from(count) - mean).powi(2) / mean).sum();
            let freedom = (prime * prime - 1) as f64;
            assert!(chi < freedom + 5.0 * (2.0 * freedom).sqrt(), "{prime}: {chi}");
        }
    }

    #[test]
    fn two_dimensions_correlate_no_more_than_independent_points_do() {
        for (dimensions, points) in [(30, 64), (60, 64), (60, 256), (60, 1024)] {
            for replicate in 0..4 {
                let scrambles = scrambles(dimensions, replicate);
                let mut centred: Vec<Vec<f64>> = scrambles
                    .iter()
                    .map(|scramble| (0..points).map(|index| scramble.coordinate(index) - 0.5).collect())
                    .collect();
                for column in &mut centred {
                    let mean = column.iter().sum::<f64>() / column.len() as f64;
                    column.iter_mut().for_each(|value| *value -= mean);
                    let norm = column.iter().map(|value| value * value).sum::<f64>().sqrt();
                    column.iter_mut().for_each(|value| *value /= norm);
                }
                let mut worst = (0.0, 0, 0);
                for a in 0..dimensions {
                    for b in 0..a {
                        let r: f64 = centred[a].iter().zip(&centred[b]).map(|(x, y)| x * y).sum();
                        if r.abs() > worst.0 {
                            worst = (r.abs(), a, b);
                        }
                    }
                }
                // for independent points, the largest of 1770 pairs exceeds 4.8 standard deviations once in 350 cases
                assert!(worst.0 < 5.0 / (points as f64).sqrt(), "{dimensions}, {points}: {worst:?}");
            }
        }
    }

    #[test]
    fn errors_of_smooth_integrals_fall_faster_than_those_of_independent_points() {
        // product of 1 + (u - 1/2): integral 1
        let error = |dimensions: usize, points: u64| {
            let replicates = 32;
            let of = |replicate: u64| {
                let scrambles = scrambles(dimensions, replicate);
                let value = |index| scrambles.iter().map(|one| 0.5 + one.coordinate(index)).product::<f64>();
                ((0..points).map(value).sum::<f64>() / points as f64 - 1.0).powi(2)
            };
            ((0..replicates).map(of).sum::<f64>() / replicates as f64).sqrt()
        };
        for dimensions in [2, 5, 10] {
            let independent = ((1.0f64 + 1.0 / 12.0).powi(dimensions as i32) - 1.0).sqrt();
            let found = [64, 512, 4096].map(|points| error(dimensions, points));
            // errors of independent points decrease by a factor of 2.8
            assert!(found.windows(2).all(|pair| pair[0] > 4.0 * pair[1]), "{dimensions}: {found:?}");
            assert!(found[2] < independent / 64.0 / 5.0, "{dimensions}: {found:?}, {}", independent / 64.0);
        }
    }
}
