//! Random bits as a pure function of (seed, replicate, purpose, index): any point of a design can be computed alone, in any order.
//!
//! Keys are derived by BLAKE3; the points of a Monte Carlo design are its output. Where a design needs a bit for each node of a
//! tree (scrambling), the key is mixed with the node by the finaliser of SplitMix64 (D. Lea, G. L. Steele, C. H. Flood, "Fast
//! splittable pseudorandom number generators", 2014), twice.
//!
//! A number of 53 bits represents the middle of its cell of width 2^-52, so that no coordinate is 0 or 1 and `1 - u` is exact.

use bladeoff_system::random::finaliser;
use blake3::Hasher;

/// Number of bits of a coordinate.
pub const BITS: u32 = 53;

/// The coordinate of these bits: the middle of its cell.
#[must_use]
pub fn unit(bits: u64) -> f64 {
    (bits | 1) as f64 * (1.0 / (1u64 << BITS) as f64)
}

/// Source of the random bits of a replicate.
#[derive(Debug, Clone)]
pub struct Source {
    key: [u8; 32],
}

impl Source {
    /// The source for a replicate of a study's design; `purpose` separates designs of different kinds.
    #[must_use]
    pub fn new(seed: u64, purpose: &str, replicate: u64) -> Self {
        let mut hasher = Hasher::new_derive_key("bladeoff design v1");
        hasher.update(&seed.to_le_bytes());
        hasher.update(&replicate.to_le_bytes());
        hasher.update(purpose.as_bytes());
        Self { key: *hasher.finalize().as_bytes() }
    }

    /// Fills the coordinates of a point with independent numbers in (0, 1).
    pub fn fill(&self, index: u64, point: &mut [f64]) {
        let mut bits = Hasher::new_keyed(&self.key).update(&index.to_le_bytes()).finalize_xof();
        let mut eight = [0; 8];
        for coordinate in point {
            bits.fill(&mut eight);
            *coordinate = unit(u64::from_le_bytes(eight) >> (64 - BITS));
        }
    }

    /// A separate key for a dimension.
    #[must_use]
    pub fn key(&self, dimension: usize) -> u64 {
        let hash =
            Hasher::new_keyed(&self.key).update(b"dimension").update(&(dimension as u64).to_le_bytes()).finalize();
        u64::from_le_bytes(hash.as_bytes()[..8].try_into().expect("eight of 32 bytes"))
    }
}

/// Random bits of a tree node under a key.
#[inline]
#[must_use]
pub fn mixed(key: u64, node: u64) -> u64 {
    finaliser(finaliser(node.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ key).wrapping_add(key.rotate_left(32)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_pinned_and_no_coordinate_is_0_or_1() {
        let mut point = [0.0; 3];
        Source::new(1, "monte-carlo", 0).fill(7, &mut point);
        // recorded once from this implementation: a change here would change the points of every study
        assert_eq!(point, [0.05063335233323596, 0.14429030368154871, 0.2791994361209932]);
        let mut again = [0.0; 5];
        Source::new(1, "monte-carlo", 0).fill(7, &mut again);
        assert_eq!(point, again[..3], "further dimensions move none");
        assert!(unit(0) > 0.0 && unit((1 << BITS) - 1) < 1.0);
        assert_eq!(1.0 - (1.0 - unit(0)), unit(0));
    }

    #[test]
    fn mixed_bits_of_neighbouring_nodes_are_independent() {
        // each of the 64 output bits over 2^16 nodes: set in half of them, and equal to that of the next node half the time
        let count = 1u64 << 16;
        for bit in 0..64 {
            let (mut set, mut alike) = (0i64, 0i64);
            for node in 0..count {
                let (here, next) = (mixed(42, node) >> bit & 1, mixed(42, node + 1) >> bit & 1);
                set += here as i64;
                alike += i64::from(here == next);
            }
            let bound = 5 * (count as f64).sqrt() as i64 / 2;
            assert!((set - count as i64 / 2).abs() < bound && (alike - count as i64 / 2).abs() < bound, "bit {bit}");
        }
    }
}
