//! Sobol's sequence: Joe and Kuo's direction numbers 6.21201 (the file of the first 1000 dimensions), points in Gray-code order.
//!
//! ```text
//! polynomial of degree s with bits a, initial m_1 .. m_s odd, m_k < 2^k
//! m_k = 2 a_1 m_(k-1) ^ 4 a_2 m_(k-2) ^ ... ^ 2^s m_(k-s) ^ m_(k-s),  v_k = m_k/2^k
//! point i: the v_k of the bits k that are set in i ^ (i >> 1), added without carry
//! ```
//! Source: S. Joe, F. Y. Kuo, "Constructing Sobol sequences with better two-dimensional projections" (2008); the table is theirs
//! (BSD licence beside it). 2^m points from index 0 on form a net: use powers of two, never skip the first.

use super::owen::scrambled;
use super::random::{BITS, Source, unit};

const TABLE: &str = include_str!("joe-kuo-6.1000.txt");
/// Number of dimensions in the table.
pub const MOST_DIMENSIONS: usize = 1000;
const COLUMNS: usize = BITS as usize;

/// The first dimensions of the sequence.
#[derive(Debug, Clone)]
pub struct Sobol {
    /// Direction numbers v_k of each dimension, as numbers of [`BITS`] bits.
    directions: Vec<[u64; COLUMNS]>,
}

impl Sobol {
    /// The first `dimensions` dimensions, at most [`MOST_DIMENSIONS`].
    #[must_use]
    pub fn new(dimensions: usize) -> Self {
        assert!(dimensions <= MOST_DIMENSIONS, "the table has {MOST_DIMENSIONS} dimensions");
        let first = [0; COLUMNS].map(|_: u64| 1);
        let rows = TABLE.lines().skip(1).map(numerators);
        let all = std::iter::once(first).chain(rows).take(dimensions);
        let shifted = |m: [u64; COLUMNS]| std::array::from_fn(|k| m[k] << (COLUMNS - 1 - k));
        Self { directions: all.map(shifted).collect() }
    }

    /// The bits of a coordinate of a point.
    #[must_use]
    pub fn bits(&self, index: u64, dimension: usize) -> u64 {
        let directions = &self.directions[dimension];
        let mut gray = index ^ index >> 1;
        let mut bits = 0;
        while gray != 0 {
            bits ^= directions[gray.trailing_zeros() as usize];
            gray &= gray - 1;
        }
        bits
    }

    /// The coordinates of a point without scrambling; index 0 is the first point.
    pub fn plain(&self, index: u64, point: &mut [f64]) {
        for (dimension, coordinate) in point.iter_mut().enumerate() {
            *coordinate = self.bits(index, dimension) as f64 * (1.0 / (1u64 << BITS) as f64);
        }
    }

    /// The coordinates of a point, scrambled with one key per dimension.
    pub fn scrambled(&self, index: u64, keys: &[u64], point: &mut [f64]) {
        for (dimension, (coordinate, &key)) in point.iter_mut().zip(keys).enumerate() {
            *coordinate = unit(scrambled(self.bits(index, dimension), key));
        }
    }
}

/// Scrambling keys of the dimensions of a replicate.
#[must_use]
pub fn keys(source: &Source, dimensions: usize) -> Vec<u64> {
    (0..dimensions).map(|dimension| source.key(dimension)).collect()
}

/// Numbers m_k of a line of the table: dimension, degree, polynomial, initial numbers.
fn numerators(line: &str) -> [u64; COLUMNS] {
    let numbers: Vec<u64> =
        line.split_whitespace().map(|word| word.parse().expect("the table holds numbers")).collect();
    let (degree, polynomial, initial) = (numbers[1] as usize, numbers[2], &numbers[3..]);
    let mut m = [0; COLUMNS];
    m[..degree].copy_from_slice(&initial[..degree]);
    for k in degree..COLUMNS {
        m[k] = m[k - degree] ^ m[k - degree] << degree;
        for j in 1..degree {
            if polynomial >> (degree - 1 - j) & 1 == 1 {
                m[k] ^= m[k - j] << j;
            }
        }
    }
    m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_points_are_those_of_the_dialect() {
        let sobol = Sobol::new(4);
        let expected = [
            [0.0; 4],
            [0.5; 4],
            [0.75, 0.25, 0.25, 0.25],
            [0.25, 0.75, 0.75, 0.75],
            [0.375, 0.375, 0.625, 0.875],
            [0.875, 0.875, 0.125, 0.375],
        ];
        for (index, expected) in expected.iter().enumerate() {
            let mut point = [0.0; 4];
            sobol.plain(index as u64, &mut point);
            assert_eq!(point, *expected, "{index}");
        }
    }

    #[test]
    fn every_dimension_is_stratified_scrambled_or_not_over_any_block_of_a_power_of_two() {
        let (sobol, source) = (Sobol::new(MOST_DIMENSIONS), Source::new(3, "sobol", 5));
        let keys = keys(&source, MOST_DIMENSIONS);
        for dimension in (0..MOST_DIMENSIONS).step_by(37) {
            for first in [0, 256, 1 << 20] {
                for key in [None, Some(keys[dimension])] {
                    let cell = |index| {
                        let bits = sobol.bits(index, dimension);
                        key.map_or(bits, |key| scrambled(bits, key)) >> (BITS - 8)
                    };
                    let mut cells: Vec<u64> = (first..first + 256).map(cell).collect();
                    cells.sort_unstable();
                    assert!(cells.into_iter().eq(0..256), "dimension {dimension} from {first}");
                }
            }
        }
    }

    #[test]
    fn the_first_two_dimensions_fill_every_box_of_a_net() {
        let (sobol, source) = (Sobol::new(2), Source::new(3, "sobol", 0));
        let keys = keys(&source, 2);
        for split in 0..=6u32 {
            let mut boxes = [0; 64];
            for index in 0..64 {
                let of = |d: usize| scrambled(sobol.bits(index, d), keys[d]);
                boxes[((of(0) >> (BITS - split)) << (6 - split) | of(1) >> (BITS - (6 - split))) as usize] += 1;
            }
            assert_eq!(boxes, [1; 64], "{split}");
        }
    }
}
