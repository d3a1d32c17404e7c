//! Sampling of the rows of a finished study.

use super::rows::design_kind;
use bladeoff_answers::compare::Draw;
use bladeoff_answers::estimate::input::{Design, Layout};
use bladeoff_answers::estimate::scheme::Scheme;
use bladeoff_study::Samples;

/// Sampling of the rows of the first `points` points, as the basis of intervals.
#[must_use]
pub fn drawn(samples: &Samples, points: u64) -> Draw {
    let Some(layout) = samples.layout() else {
        return Draw::without("no interval: a study without [design] has chosen samples, not random ones");
    };
    let replicate: Vec<u32> = (0..points).map(|point| layout.replicate(point) as u32).collect();
    let design = Design {
        kind: design_kind(layout),
        scrambled: layout.is_scrambled(),
        replicates: layout.replicates() as usize,
        replicate: &replicate,
        complete: points == samples.points(),
        layout: Layout::Points,
        share: 1.0,
        refined: false,
    };
    let rows_per_point = samples.count() / samples.points().max(1);
    Draw::whole(Scheme::of(&design), rows_per_point, replicate)
}
