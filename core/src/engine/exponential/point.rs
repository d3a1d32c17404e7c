//! A place that may press in a step, and the ring's modes along it.

use super::survey::Place;
use crate::contact::ContactForce;

/// A place that may press.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    /// At n+1, where the gap is to stay open, and at n, where the impulse acts.
    pub place: Place,
    pub acting: Place,
    /// Gap and slip without impulses.
    pub start: [f64; 2],
    pub force: ContactForce,
}

/// The ring's modes along normal and tangent of a point at n+1 and at n, and what a unit impulse along those at n makes of them; zeros behind the last mode.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    pub normal: Vec<f64>,
    pub tangent: Vec<f64>,
    pub acting: [Vec<f64>; 2],
    pub by_normal: Vec<f64>,
    pub by_tangent: Vec<f64>,
}
