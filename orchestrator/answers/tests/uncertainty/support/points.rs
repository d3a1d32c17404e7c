//! Point sets for tests: random bits by BLAKE3, scrambled Sobol (two dimensions), scrambled Halton, and a hypercube that grows.
//!
//! Those of studies are elsewhere and are tested there; answers know none of them.

use blake3::Hasher;

/// Bits of a coordinate.
pub const BITS: u32 = 53;

/// The coordinate of so many bits: the middle of its cell.
pub fn unit(bits: u64) -> f64 {
    (bits | 1) as f64 * (1.0 / (1u64 << BITS) as f64)
}

/// What the random bits of a replicate depend on.
#[derive(Debug, Clone)]
pub struct Source {
    key: [u8; 32],
}

impl Source {
    /// Of a replicate of a study's design; `purpose` keeps designs of different kinds apart.
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

    /// A key of its own, for a dimension.
    pub fn key(&self, dimension: usize) -> u64 {
        let hash =
            Hasher::new_keyed(&self.key).update(b"dimension").update(&(dimension as u64).to_le_bytes()).finalize();
        u64::from_le_bytes(hash.as_bytes()[..8].try_into().expect("eight of 32 bytes"))
    }
}

/// Random bits of a node under a key.
#[inline]
pub fn mixed(key: u64, node: u64) -> u64 {
    finaliser(finaliser(node.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ key).wrapping_add(key.rotate_left(32)))
}

#[inline]
fn finaliser(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The scrambled bits of a coordinate of [`BITS`] bits.
pub fn scrambled(bits: u64, key: u64) -> u64 {
    let mut flips = 0;
    for level in 0..BITS {
        // a node: a leading one, and the bits above this one
        let node = 1u64 << level | bits >> (BITS - level);
        flips = flips << 1 | mixed(key, node) >> 63;
    }
    bits ^ flips
}

/// A permutation of `0..count`.
#[derive(Debug, Clone)]
pub struct Shuffle {
    key: [u8; 32],
    count: u64,
    half_bits: u32,
}

const ROUNDS: u8 = 4;

impl Shuffle {
    /// The permutation of `0..count` (count <= 2^62) that belongs to `seed`.
    pub fn new(seed: u64, count: u64) -> Self {
        let mut hasher = blake3::Hasher::new_derive_key("bladeoff study shuffle v1");
        hasher.update(&seed.to_le_bytes());
        hasher.update(&count.to_le_bytes());
        let bits = u64::BITS - count.saturating_sub(1).leading_zeros();
        Self { key: *hasher.finalize().as_bytes(), count, half_bits: bits.div_ceil(2).max(1) }
    }

    /// Image of `position` < count.
    pub fn apply(&self, position: u64) -> u64 {
        debug_assert!(position < self.count);
        // The domain is less than four times the count, so a walk takes fewer than four steps on average; it ends
        // because the cycle comes back to `position`, which is inside.
        let mut image = self.network(position);
        while image >= self.count {
            image = self.network(image);
        }
        image
    }

    fn network(&self, value: u64) -> u64 {
        let mask = (1u64 << self.half_bits) - 1;
        let (mut left, mut right) = (value >> self.half_bits, value & mask);
        for round in 0..ROUNDS {
            (left, right) = (right, left ^ (self.round(round, right) & mask));
        }
        left << self.half_bits | right
    }

    fn round(&self, round: u8, half: u64) -> u64 {
        let mut hasher = blake3::Hasher::new_keyed(&self.key);
        hasher.update(&[round]);
        hasher.update(&half.to_le_bytes());
        let hash = hasher.finalize();
        u64::from_le_bytes(hash.as_bytes()[..8].try_into().expect("eight of 32 bytes"))
    }
}

/// Cells of a coordinate at most: the middle of one and its complement are exact.
const MOST_CELLS: u64 = 1 << 52;

/// The primes of the first dimensions.
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

/// A coordinate of a scrambled Halton sequence.
pub fn halton(mut index: u64, prime: u64, key: u64) -> f64 {
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

/// A coordinate of the first two dimensions of Sobol's sequence, scrambled.
pub fn sobol(index: u64, dimension: usize, key: u64) -> f64 {
    assert!(dimension < 2, "two dimensions are here");
    let gray = index ^ index >> 1;
    let (mut bits, mut m) = (0, 1u64);
    for k in 0..BITS {
        if gray >> k & 1 == 1 {
            bits ^= m << (BITS - 1 - k);
        }
        // of the second dimension, of degree 1: m_k = 2 m_(k-1) ^ m_(k-1)
        if dimension == 1 {
            m ^= m << 1;
        }
    }
    unit(scrambled(bits, key))
}

/// One dimension of a Latin hypercube: a scrambled van der Corput sequence, shuffled within each doubling.
pub struct Cube {
    key: u64,
    permutations: Vec<Shuffle>,
}

impl Cube {
    /// For at most so many points.
    pub fn new(key: u64, samples: u64) -> Self {
        let doublings = u64::BITS - samples.saturating_sub(1).leading_zeros();
        let permutations = (0..doublings).map(|k| Shuffle::new(key.wrapping_add(u64::from(k)), 1 << k)).collect();
        Self { key, permutations }
    }

    /// Of a point.
    pub fn coordinate(&self, index: u64) -> f64 {
        let placed = match index.checked_ilog2() {
            None => 0,
            Some(k) => (1 << k) + self.permutations[k as usize].apply(index - (1 << k)),
        };
        unit(scrambled(placed.reverse_bits() >> (u64::BITS - BITS), self.key))
    }
}
