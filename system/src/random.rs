//! Reproducible pseudorandom numbers: splitmix64 (Steele, Lea, Flood 2014), for faults and tests.

/// A sequence of numbers determined by its seed.
#[derive(Debug, Clone)]
pub struct SplitMix(pub u64);

impl SplitMix {
    /// The next 64 bits.
    pub fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        finaliser(self.0)
    }

    /// A number from 0 to `n - 1`; 0 for `n = 0`.
    pub fn below(&mut self, n: u64) -> u64 {
        self.word() % n.max(1)
    }

    /// A number from 0 to 1, 1 excluded.
    pub fn unit(&mut self) -> f64 {
        (self.word() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// One-to-one mixing of bits: each bit of the result depends on all bits of the argument.
#[inline]
#[must_use]
pub fn finaliser(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference: `splitmix64.c` of S. Vigna (prng.di.unimi.it), seed 1234567.
    #[test]
    fn words_are_those_of_the_reference() {
        let mut random = SplitMix(1_234_567);
        let words: Vec<u64> = (0..3).map(|_| random.word()).collect();
        assert_eq!(words, [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]);
        assert!((0.0..1.0).contains(&random.unit()) && random.below(3) < 3 && random.below(0) == 0);
    }
}
