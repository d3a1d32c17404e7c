//! Elementary effects of Morris: change of an output per full range of one parameter.
//!
//! ```text
//! effect of the step of parameter i in a trajectory   e = (y after - y before)/(delta s),  s = +1 up, -1 down
//! mu = mean e,  mu* = mean |e|,  sigma^2 = sum (e - mu)^2/(r - 1)                           over r trajectories
//! ```
//! delta is a fraction of the range of a parameter's levels, so effects have the unit of the output. mu* ranks parameters; a large ratio
//! sigma/mu* indicates nonlinearity or interaction. Effects are not shares of a variance.
//! Sources: M. D. Morris (1991); F. Campolongo, J. Cariboni, A. Saltelli, "An effective screening design for sensitivity analysis of
//! large models" (2007).
//! Verified by `tests/sensitivity`: exact figures of the Ishigami function, linear models, coverage.

use super::blocks::Blocks;
use super::indices::{Index, Indices, OfParameter, SensitivityError};
use super::resample::{Sums, told};

/// The parameter step that leads to a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moved {
    /// Index of the parameter.
    pub parameter: usize,
    /// Whether the parameter increased.
    pub up: bool,
}

/// Elementary effects of each parameter.
///
/// * `names` - of the d parameters; `values` - of all rows, trajectory by trajectory, d + 1 each, `None` without a number;
/// * `moves` - of all rows, `None` at the start of a trajectory; `delta` - step size; `alpha` - 1 - confidence.
///
/// # Errors
/// The rows do not form such a design.
pub fn morris(
    names: &[String],
    values: &[Option<f64>],
    moves: &[Option<Moved>],
    delta: f64,
    alpha: f64,
) -> Result<Indices, SensitivityError> {
    let (parameters, rows) = (names.len(), names.len() + 1);
    if parameters == 0 {
        return Err(SensitivityError::Parameters);
    }
    if moves.len() != values.len() {
        return Err(SensitivityError::Length { what: "moves".to_owned(), found: moves.len(), rows: values.len() });
    }
    for (block, moves) in moves.chunks_exact(rows).enumerate() {
        let mut moved: Vec<usize> = moves[1..].iter().flatten().map(|moved| moved.parameter).collect();
        moved.sort_unstable();
        if moves[0].is_some() || !moved.into_iter().eq(0..parameters) {
            return Err(SensitivityError::Moves { block, parameters });
        }
    }
    let blocks = Blocks::new(values, rows);
    let effect = |block: usize, effects: &mut [f64]| {
        let first = block * rows;
        for row in first + 1..first + rows {
            if let (Some(before), Some(after), Some(Moved { parameter, up })) =
                (values[row - 1], values[row], moves[row])
            {
                effects[parameter] = (after - before) / if up { delta } else { -delta };
            }
        }
    };
    let count = blocks.whole.len();
    let mut effects = vec![0.0; parameters];
    let mut means = vec![0.0; parameters];
    for &block in &blocks.whole {
        effect(block, &mut effects);
        means.iter_mut().zip(&effects).for_each(|(mean, e)| *mean += e / count as f64);
    }
    // sums of 1, and for each parameter of e - mean, its square and |e|: subtracting the mean keeps the digits of a small sigma
    let sums = Sums::new(count, 1 + 3 * parameters, |at, sums| {
        effect(blocks.whole[at], &mut effects);
        sums[0] = 1.0;
        for (i, (e, mean)) in effects.iter().zip(&means).enumerate() {
            let from_mean = e - mean;
            sums[1 + 3 * i..4 + 3 * i].copy_from_slice(&[from_mean, from_mean * from_mean, e.abs()]);
        }
    });
    let figures = |sums: &[f64]| {
        let n = sums[0];
        let of = |(i, mean): (usize, &f64)| {
            let [shift, square, star] = [sums[1 + 3 * i], sums[2 + 3 * i], sums[3 + 3 * i]];
            let variance = ((square - shift * shift / n) / (n - 1.0)).max(0.0);
            // one trajectory has no scatter: 0/0
            let sigma = if n > 1.0 { libm::sqrt(variance) } else { f64::NAN };
            [star / n, mean + shift / n, sigma]
        };
        means.iter().enumerate().flat_map(of).collect()
    };
    let mut notes = Vec::new();
    blocks.told("trajectories", &mut notes);
    let interval = told(count, alpha, "trajectories", &mut notes);
    let found = if count > 0 { sums.indices(count, alpha, figures) } else { vec![Index::default(); 3 * parameters] };
    let of = |(name, figures): (&String, &[Index])| {
        let [mu_star, mu, sigma] = [figures[0], figures[1], figures[2]].map(Some);
        (name.clone(), OfParameter { mu_star, mu, sigma, ..OfParameter::default() })
    };
    Ok(Indices {
        of: names.iter().zip(found.chunks_exact(3)).map(of).collect(),
        pairs: Vec::new(),
        r2: None,
        interval,
        n: count as u64,
        left_out: blocks.left_out() as u64,
        without: (count == 0).then_some("no trajectory is whole"),
        notes,
    })
}
