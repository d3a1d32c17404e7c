//! Halton's sequence: the digits of the index in the base of each dimension's prime, mirrored at the point; scrambled by a random
//! permutation of the digits for each node of the tree that the digits above lead to (digit' = a digit + c mod the prime).
//!
//! Source: J. H. Halton, "On the efficiency of certain quasi-random sequences of points" (1960); A. B. Owen, "A randomized
//! Halton algorithm in R" (2017), with the linear permutations of J. Matousek (1998).

use super::random::mixed;

/// Cells of a coordinate at most: the middle of one and its complement are exact.
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

/// The coordinate as it stands in the sequence: 0 is its first.
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

/// The same scrambled: the middle of its cell.
#[must_use]
pub fn scrambled(mut index: u64, prime: u64, key: u64) -> f64 {
    let (mut mirrored, mut cells, mut node) = (0u64, 1u64, 0u64);
    while cells <= MOST_CELLS / prime {
        let digit = index % prime;
        // the node that the digits above lead to: their own number, apart for each level
        let bits = mixed(key, mixed(cells, node));
        let (factor, shift) = (1 + (bits >> 32) % (prime - 1), (bits & 0xffff_ffff) % prime);
        mirrored = mirrored * prime + (factor * digit + shift) % prime;
        node = node * prime + digit;
        cells *= prime;
        index /= prime;
    }
    (mirrored as f64 + 0.5) / cells as f64
}

#[cfg(test)]
mod tests {
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
            let mut cells: Vec<u64> = (0..count).map(|i| (scrambled(i, prime, 77) * count as f64) as u64).collect();
            cells.sort_unstable();
            assert!(cells.into_iter().eq(0..count), "{prime}");
        }
        let extreme = (0..100_000).map(|i| scrambled(i, 719, 1));
        assert!(extreme.into_iter().all(|u| u > 0.0 && u < 1.0));
    }
}
