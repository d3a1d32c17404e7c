//! Morris trajectories: from a random point on a grid of levels, each parameter changes once, in random order.
//!
//! ```text
//! point (d + 1) t + s: trajectory t after s moves                                       block t
//! start     each parameter at one of p levels l = 0 .. p - 1, with equal probability
//! a move    by p/2 levels, up from the lower half, down from the upper: delta = p/(2 (p - 1)) of the whole range
//! level -> coordinate u, depending on the distribution of the parameter:
//!   both ends finite   u = l/(p - 1): from end to end
//!   an infinite end    u = 0.005 + 0.99 l/(p - 1): the middle 99 %, since a level at an end would be infinite
//!   periodic           u = l/p: both ends are the same value, so there are p different levels, and a move is half a turn
//! ```
//! All starts have the same probability, and the direction of a move follows from the start. So each elementary effect of the grid is drawn
//! with the same probability, as in Morris's own construction. A trajectory depends on (seed, t, d, p) alone: more trajectories change none.
//!
//! Source: M. D. Morris, "Factorial sampling plans for preliminary computational experiments" (1991).

use crate::sampling::sequence::random::Source;
use crate::uncertain::Uncertain;

/// Probability outside the outer levels of a distribution with an infinite end.
const TAIL: f64 = 0.005;

/// Coordinates of the levels of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Course {
    Whole,
    Middle,
    Around,
}

/// The trajectories of a design.
#[derive(Debug, Clone)]
pub struct Trajectories {
    source: Source,
    levels: u64,
    courses: Vec<Course>,
}

/// The move from the previous point to this one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Move {
    /// The parameter that differs from the previous point.
    pub parameter: usize,
    /// Whether the coordinate of that parameter increases.
    pub up: bool,
}

impl Trajectories {
    /// Trajectories of parameters with these distributions, on an even number of levels.
    pub(super) fn new(source: Source, levels: u64, laws: &[Uncertain]) -> Self {
        let course = |law: &Uncertain| match law {
            Uncertain::Periodic(..) => Course::Around,
            law if law.ends().iter().all(|end| end.is_finite()) => Course::Whole,
            _ => Course::Middle,
        };
        Self { source, levels, courses: laws.iter().map(course).collect() }
    }

    /// Number of points of a trajectory.
    #[must_use]
    pub fn rows(&self) -> u64 {
        self.courses.len() as u64 + 1
    }

    /// Size of a move as a fraction of the range of a parameter.
    #[must_use]
    pub fn delta(&self) -> f64 {
        self.levels as f64 / (2.0 * (self.levels - 1) as f64)
    }

    /// Starting levels of a trajectory, and the order of its moves.
    fn drawn(&self, trajectory: u64) -> (Vec<u64>, Vec<usize>) {
        let parameters = self.courses.len();
        let mut numbers = vec![0.0; 2 * parameters];
        self.source.fill(trajectory, &mut numbers);
        let (starts, keys) = numbers.split_at(parameters);
        let level = |u: &f64| ((u * self.levels as f64) as u64).min(self.levels - 1);
        let mut order: Vec<usize> = (0..parameters).collect();
        order.sort_by(|&a, &b| keys[a].total_cmp(&keys[b]));
        (starts.iter().map(level).collect(), order)
    }

    fn is_low(&self, level: u64) -> bool {
        level < self.levels / 2
    }

    /// The move to a point; `None` for the start of a trajectory.
    #[must_use]
    pub fn moved(&self, index: u64) -> Option<Move> {
        let (trajectory, step) = (index / self.rows(), index % self.rows());
        let before = usize::try_from(step.checked_sub(1)?).ok()?;
        let (starts, order) = self.drawn(trajectory);
        let parameter = order[before];
        Some(Move { parameter, up: self.is_low(starts[parameter]) })
    }

    /// Coordinates of the levels of a parameter, in order. A move goes to the level half of their number further up or down.
    pub(crate) fn levels(&self, parameter: usize) -> Vec<f64> {
        (0..self.levels).map(|level| self.coordinate(level, self.courses[parameter])).collect()
    }

    fn coordinate(&self, level: u64, course: Course) -> f64 {
        let (level, last) = (level as f64, (self.levels - 1) as f64);
        match course {
            Course::Whole => level / last,
            Course::Middle => TAIL + (1.0 - 2.0 * TAIL) * (level / last),
            Course::Around => level / self.levels as f64,
        }
    }

    /// The coordinates of a point.
    pub(super) fn fill(&self, index: u64, point: &mut [f64]) {
        let (trajectory, step) = (index / self.rows(), index % self.rows());
        let (mut levels, order) = self.drawn(trajectory);
        let half = self.levels / 2;
        for &parameter in &order[..step as usize] {
            let level = &mut levels[parameter];
            *level = if self.is_low(*level) { *level + half } else { *level - half };
        }
        for ((coordinate, &level), &course) in point.iter_mut().zip(&levels).zip(&self.courses) {
            *coordinate = self.coordinate(level, course);
        }
    }
}
