//! Latin hypercube that grows by doubling: for every k, the first 2^k points have one point in each of 2^k equal slices of every dimension.
//!
//! ```text
//! doubling k: points 2^k .. 2^(k+1)     (point 0 before the first)
//! coordinate of point i in dimension d = scrambled mirror image of the bits of pi_(d,k)(i)
//! ```
//! pi is a random permutation within the doubling, a separate one for each dimension. So the coordinates in a dimension are those of a
//! scrambled van der Corput sequence, which has the slices, and the pairing of dimensions is random. Without the permutation, separately
//! scrambled sequences would fill two of four quadrants with every two points.
//! Sources: M. D. McKay, R. J. Beckman, W. J. Conover (1979); growth by doubling: C. J. Sallaberry, J. C. Helton, S. C. Hora (2008).

use super::owen::scrambled;
use super::random::{BITS, Source, unit};
use crate::sampling::shuffle::Shuffle;

/// One replicate.
#[derive(Debug, Clone)]
pub struct Hypercube {
    /// For each dimension: its scrambling key and its permutation in each doubling.
    dimensions: Vec<(u64, Vec<Shuffle>)>,
}

impl Hypercube {
    /// A hypercube of this number of dimensions, for at most `samples` points; more points do not change the first ones.
    #[must_use]
    pub fn new(source: &Source, dimensions: usize, samples: u64) -> Self {
        let doublings = u64::BITS - samples.saturating_sub(1).leading_zeros();
        let one = |dimension| {
            let key = source.key(dimension);
            (key, (0..doublings).map(|k| Shuffle::new(key.wrapping_add(u64::from(k)), 1 << k)).collect())
        };
        Self { dimensions: (0..dimensions).map(one).collect() }
    }

    /// The coordinates of a point.
    pub fn fill(&self, index: u64, point: &mut [f64]) {
        for (coordinate, (key, permutations)) in point.iter_mut().zip(&self.dimensions) {
            let placed = match index.checked_ilog2() {
                None => 0,
                Some(k) => (1 << k) + permutations[k as usize].apply(index - (1 << k)),
            };
            *coordinate = unit(scrambled(placed.reverse_bits() >> (u64::BITS - BITS), *key));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(replicate: u64, count: u64) -> Vec<[f64; 5]> {
        let cube = Hypercube::new(&Source::new(11, "latin-hypercube", replicate), 5, count);
        let point = |index| {
            let mut point = [0.0; 5];
            cube.fill(index, &mut point);
            point
        };
        (0..count).map(point).collect()
    }

    #[test]
    fn every_doubling_is_a_hypercube_and_moves_no_point() {
        let all = points(0, 1024);
        for k in 0..=10 {
            let count = 1usize << k;
            assert_eq!(points(0, count as u64), all[..count]);
            for dimension in 0..5 {
                let mut slices: Vec<usize> =
                    all[..count].iter().map(|point| (point[dimension] * count as f64) as usize).collect();
                slices.sort_unstable();
                assert!(slices.into_iter().eq(0..count), "{count} points, dimension {dimension}");
            }
        }
    }

    #[test]
    fn two_dimensions_are_paired_at_random() {
        // four points over many replicates: every pattern of quadrants occurs, and the correlation is that of a random pairing
        let (mut quadrants, mut products) = (std::collections::BTreeSet::new(), 0.0);
        let replicates = 2000;
        for replicate in 0..replicates {
            let four = points(replicate, 4);
            let pattern: Vec<u8> = four.iter().map(|p| u8::from(p[0] > 0.5) | u8::from(p[1] > 0.5) << 1).collect();
            quadrants.insert(pattern);
            products += four.iter().map(|p| (p[0] - 0.5) * (p[1] - 0.5)).sum::<f64>();
        }
        // each dimension halves the first two and the last two points: 2 x 2 ways per dimension, independently
        assert!(quadrants.len() >= 16);
        let mean = products / (4.0 * replicates as f64) * 12.0;
        assert!(mean.abs() < 5.0 / (4.0 * replicates as f64).sqrt(), "{mean}");
    }
}
