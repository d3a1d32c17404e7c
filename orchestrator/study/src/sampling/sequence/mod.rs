//! Sequences of points in the unit cube: independent ([`random`]), or evenly distributed ([`hypercube`], [`sobol`], [`halton`]; scrambled by `owen`
//! and by permutations of digits). Each point is a pure function of (seed, replicate, index).

pub mod halton;
pub mod hypercube;
mod owen;
pub mod random;
pub mod sobol;
