//! Default chunk size: about a minute on the node that begins the directory.

use super::super::prepare::Prepared;
use super::layout::{MOST_CHUNKS, MOST_OF_CHUNK};
use bladeoff_system::guarded::guarded;
use bladeoff_worker::core_solver::CoreSolver;
use bladeoff_worker::function_solver::FunctionSolver;
use bladeoff_worker::job_spec::JobSpec;
use std::time::{Duration, Instant};

/// Target time of a chunk.
const TARGET: Duration = Duration::from_secs(60);
/// Timed samples, as quarters of the study: the middle, then towards both ends.
const TIMED: [u64; 3] = [2, 1, 3];
/// Time after which no further sample is timed.
const LONGEST: Duration = Duration::from_secs(10);
/// Smallest number of chunks per shard, so that fast shards can help slow ones.
const LEAST_OF_SHARD: u64 = 4;

/// Determines the chunk size by timing a few samples.
pub(super) fn chunk_size(prepared: &Prepared<'_>, workers: usize, shards: u64) -> u64 {
    let samples = prepared.samples;
    let begun = Instant::now();
    let mut timed = 0u32;
    let mut params = Vec::new();
    let mut machine = None;
    let mut function = None;
    match &prepared.job {
        JobSpec::Machine(job) => machine = CoreSolver::new(job).ok(),
        JobSpec::Function(job) => function = FunctionSolver::new(job).ok(),
    }
    for place in TIMED {
        if timed > 0 && begun.elapsed() > LONGEST {
            break;
        }
        params.clear();
        samples.params(samples.count() * place / 4, &mut params);
        // Only the time matters here.
        guarded(|| {
            machine.as_mut().map(|solver| solver.simulate(&params).is_ok());
            function.as_mut().map(|solver| solver.outcome(&params));
        });
        timed += 1;
    }
    let cost = begun.elapsed() / timed.max(1);
    size(samples.count(), cost, workers as u64, shards)
}

fn size(samples: u64, cost: Duration, workers: u64, shards: u64) -> u64 {
    let of_a_minute = TARGET.as_secs_f64() * workers.max(1) as f64 / cost.as_secs_f64().max(1e-6);
    let fair = samples.div_ceil(LEAST_OF_SHARD * shards.max(1));
    (of_a_minute as u64).clamp(1, MOST_OF_CHUNK).min(fair).max(samples.div_ceil(MOST_CHUNKS)).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chunk_takes_a_minute_and_every_shard_has_several() {
        let second = Duration::from_secs(1);
        assert_eq!(size(1_000_000, second, 64, 16), 60 * 64);
        assert_eq!(size(1000, second, 64, 16), 16, "1000 samples in 64 chunks");
        assert_eq!(size(1_000_000, 600 * second, 2, 16), 1, "longer than a minute");
        assert_eq!(size(100_000_000, Duration::ZERO, 64, 16), MOST_OF_CHUNK);
        assert_eq!(size(100_000_000, 100 * second, 1, 16), 100, "a million chunks at most");
        assert_eq!(size(1, second, 1, 1), 1);
    }
}
