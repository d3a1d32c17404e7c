//! Nested uniform scrambling in base 2: each bit of a coordinate is flipped or not, by a random bit of the binary tree node that is given by the
//! bits above. A scrambled net stays a net, and each point is uniform.
//!
//! Source: A. B. Owen, "Randomly permuted (t,m,s)-nets and (t,s)-sequences" (1995).

use super::random::{BITS, mixed};

/// The scrambled bits of a coordinate of [`BITS`] bits.
#[must_use]
pub fn scrambled(bits: u64, key: u64) -> u64 {
    let mut flips = 0;
    for level in 0..BITS {
        // a node: a leading one, and the bits above the present one
        let node = 1u64 << level | bits >> (BITS - level);
        flips = flips << 1 | mixed(key, node) >> 63;
    }
    bits ^ flips
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_stay_cells_at_every_level() {
        for level in 1..8u32 {
            let mut seen: Vec<u64> =
                (0..1u64 << level).map(|cell| scrambled(cell << (BITS - level), 9) >> (BITS - level)).collect();
            seen.sort_unstable();
            assert!(seen.into_iter().eq(0..1 << level));
        }
        // all numbers of one cell are mapped to one cell
        let within = |low: u64| scrambled(5 << (BITS - 3) | low, 9) >> (BITS - 3);
        assert_eq!(within(0), within((1 << (BITS - 3)) - 1));
    }
}
