//! Which parameter decides an output, and how surely that is known.
//!
//! ```text
//! design      rows of a block                   figures of a parameter                          intervals
//! morris      a trajectory: d + 1               mu*, mu, sigma of its elementary effects        bootstrap over trajectories
//! saltelli    a base point: A, AB_i, [BA_i], B  first, total, second order                      bootstrap over base points
//! any random  -                                 Spearman, standardised rank regression,         t of parts
//!                                               first order by ranks, HSIC with a p-value
//! ```
//! A run without a number (bad, or nothing of the kind happened) has no effect and no product: its block is left out as a whole, and
//! the share that is out is stated. What is left is a sample of the runs that went well, not of all: with a share above some per cent
//! the indices are those of another question. Every interval is approximate; measured coverages are in the modules.
//!
//! Nothing here is random: resamples are drawn from a fixed seed, so the same rows give the same bytes.

mod blocks;
mod given;
mod hsic;
mod indices;
mod morris;
mod ranks;
mod regimes;
mod regression;
mod resample;
mod sobol;
mod successor;

pub use blocks::Blocks;
pub use given::{FEWEST_ROWS, Given, Input, Parts, given_data};
pub use hsic::{Dependence, MOST_ROWS, Similar, dependence};
pub use indices::{Hsic, Index, Indices, OfParameter, Pair, SensitivityError};
pub use morris::{Moved, morris};
pub use ranks::{midranks, spearman};
pub use regimes::{Regime, by_regime, regimes, warning};
pub use regression::{Regression, rank_regression};
pub use resample::FEWEST_BLOCKS;
pub use sobol::sobol;
pub use successor::{FEWEST_FOR_SUCCESSORS, first_order_by_ranks};
