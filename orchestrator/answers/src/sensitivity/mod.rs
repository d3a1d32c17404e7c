//! Sensitivity of an output to the parameters, with its uncertainty.
//!
//! ```text
//! design      rows of a block                   figures of a parameter                          intervals
//! morris      a trajectory: d + 1               mu*, mu, sigma of its elementary effects        bootstrap over trajectories
//! saltelli    a base point: A, AB_i, [BA_i], B  first, total, second order                      bootstrap over base points
//! any random  -                                 Spearman, standardised rank regression,         t over parts
//!                                               first order by ranks, HSIC with a p-value
//! ```
//! A run without a number (bad, or the event did not occur) excludes its block completely, and the excluded share is reported. The remaining
//! blocks represent the successful runs, not all runs: with a share above some per cent the indices answer a different question. Every
//! interval is approximate; measured coverages are in the modules.
//!
//! Results are reproducible: resamples are drawn from a fixed seed, so the same rows give the same bytes.

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
