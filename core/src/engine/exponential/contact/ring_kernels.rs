//! Products and sums of the ring's modes in a contact step, by eights: zeros stand behind the last mode.
//!
//! Each is part of the function of one width that calls it ([`crate::linalg::eight`]).

use crate::linalg::eight::Eight;
use crate::linalg::lanes::Lane;

/// Rows that a point has: along its normal and tangent, and what unit impulses along those at its acting place make of the modes.
const ROWS: usize = 4;

/// Rows of points, one after the other.
#[derive(Debug, Clone)]
pub(crate) struct PointRows {
    lanes: usize,
    all: Vec<Lane>,
}

impl PointRows {
    /// For so many points of so many eights of modes.
    pub fn new(points: usize, lanes: usize) -> Self {
        Self { lanes, all: vec![Lane::default(); points * ROWS * lanes] }
    }

    #[inline(always)]
    fn from(&self, slot: usize) -> &[Lane] {
        &self.all[slot * ROWS * self.lanes..(slot + 1) * ROWS * self.lanes]
    }

    /// Along normal and tangent.
    #[inline(always)]
    pub fn along(&self, slot: usize) -> [&[Lane]; 2] {
        let (normal, rest) = self.from(slot).split_at(self.lanes);
        [normal, &rest[..self.lanes]]
    }

    /// By normal and tangential impulses.
    #[inline(always)]
    pub fn by(&self, slot: usize) -> [&[Lane]; 2] {
        let (normal, tangential) = self.from(slot)[2 * self.lanes..].split_at(self.lanes);
        [normal, tangential]
    }

    /// All four, to be written.
    #[inline(always)]
    pub fn of_mut(&mut self, slot: usize) -> [&mut [Lane]; ROWS] {
        let all = &mut self.all[slot * ROWS * self.lanes..(slot + 1) * ROWS * self.lanes];
        let (along, by) = all.split_at_mut(2 * self.lanes);
        let ((a, b), (c, d)) = (along.split_at_mut(self.lanes), by.split_at_mut(self.lanes));
        [a, b, c, d]
    }
}

/// The first so many of lists. (`map` of arrays is a function of its own, without the vectors of the one it is in.)
#[inline(always)]
fn truncated_rows<const N: usize>(mut rows: [&[Lane]; N], count: usize) -> [&[Lane]; N] {
    for row in &mut rows {
        *row = &row[..count];
    }
    rows
}

/// Each of two numbers eight times.
#[inline(always)]
pub(crate) fn broadcast<V: Eight>([a, b]: [f64; 2]) -> [V; 2] {
    [V::all(a), V::all(b)]
}

/// Two lanes.
#[inline(always)]
pub(crate) fn load_lanes<V: Eight>([a, b]: &[Lane; 2]) -> [V; 2] {
    [V::load(a), V::load(b)]
}

/// Lists of the modes in a step: what they yield to impulses, their way over the step, and what of impulses that are foreseen is undone.
#[derive(Clone, Copy)]
pub(crate) struct StepState<'a> {
    pub yields: &'a [Lane],
    pub way: &'a [Lane],
    pub undone: &'a [Lane],
}

/// What rows say of a step: the tangent's product with the way, the normal's with what is undone, and both rows' with what impulses make, as `along_both`.
pub(crate) struct RowSums {
    pub passed: f64,
    pub opened: f64,
    pub own: [f64; 4],
}

/// Writes the rows of a place whose V and U are so much of those of three candidates, along two directions of its polar axes; and what impulses along the rows
/// of its acting place make, or along its own.
#[inline(always)]
pub(crate) fn write_rows<V: Eight>(
    three: [[&[Lane]; 2]; 3],
    weights: [f64; 3],
    directions: [[f64; 2]; 2],
    acts: Option<[&[Lane]; 2]>,
    step: StepState<'_>,
    rows: [&mut [Lane]; ROWS],
) -> RowSums {
    let (a, b, c) = (V::all(weights[0]), V::all(weights[1]), V::all(weights[2]));
    let [[np, nq], [tp, tq]] = [broadcast::<V>(directions[0]), broadcast::<V>(directions[1])];
    let [normal, tangent, by_normal, by_tangent] = rows;
    let count = normal.len();
    let [[va, ua], [vb, ub], [vc, uc]] =
        [truncated_rows(three[0], count), truncated_rows(three[1], count), truncated_rows(three[2], count)];
    let StepState { yields, way, undone } = step;
    let (yields, way, undone) = (&yields[..count], &way[..count], &undone[..count]);
    let (tangent, by_normal, by_tangent) = (&mut tangent[..count], &mut by_normal[..count], &mut by_tangent[..count]);
    for i in 0..count {
        let v = a * V::load(&va[i]) + b * V::load(&vb[i]) + c * V::load(&vc[i]);
        let u = a * V::load(&ua[i]) + b * V::load(&ub[i]) + c * V::load(&uc[i]);
        (np * v + nq * u).store(&mut normal[i]);
        (tp * v + tq * u).store(&mut tangent[i]);
    }
    let [m, s] = truncated_rows(acts.unwrap_or([&*normal, &*tangent]), count);
    let mut sums = [V::all(0.0); 6];
    for i in 0..count {
        let (n, t) = (V::load(&normal[i]), V::load(&tangent[i]));
        let yields = V::load(&yields[i]);
        let by = [yields * V::load(&m[i]), yields * V::load(&s[i])];
        let (way, undone) = (V::load(&way[i]), V::load(&undone[i]));
        sums[0] = sums[0] + t * way;
        sums[1] = sums[1] + n * undone;
        sums[2] = sums[2] + n * by[0];
        sums[3] = sums[3] + n * by[1];
        sums[4] = sums[4] + t * by[0];
        sums[5] = sums[5] + t * by[1];
        by[0].store(&mut by_normal[i]);
        by[1].store(&mut by_tangent[i]);
    }
    let [passed, opened, nn, nt, tn, tt] = sums;
    RowSums { passed: passed.sum(), opened: opened.sum(), own: [nn.sum(), nt.sum(), tn.sum(), tt.sum()] }
}

/// Products of two rows with two others: of the first with both, then of the second.
#[inline(always)]
pub(crate) fn along_both<V: Eight>(rows: [&[Lane]; 2], others: [&[Lane]; 2]) -> [f64; 4] {
    let count = rows[0].len();
    let ([n, t], [m, s]) = (truncated_rows(rows, count), truncated_rows(others, count));
    let mut sums = [V::all(0.0); 4];
    for i in 0..count {
        let (n, t, m, s) = (V::load(&n[i]), V::load(&t[i]), V::load(&m[i]), V::load(&s[i]));
        sums[0] = sums[0] + n * m;
        sums[1] = sums[1] + n * s;
        sums[2] = sums[2] + t * m;
        sums[3] = sums[3] + t * s;
    }
    [sums[0].sum(), sums[1].sum(), sums[2].sum(), sums[3].sum()]
}

/// Products of some rows with a list.
#[inline(always)]
pub(crate) fn each_along<V: Eight, const N: usize>(rows: [&[Lane]; N], list: &[Lane]) -> [f64; N] {
    let count = list.len();
    let rows = truncated_rows(rows, count);
    let mut sums = [V::all(0.0); N];
    for i in 0..count {
        let of_list = V::load(&list[i]);
        for n in 0..N {
            sums[n] = sums[n] + V::load(&rows[n][i]) * of_list;
        }
    }
    let mut all = [0.0; N];
    for n in 0..N {
        all[n] = sums[n].sum();
    }
    all
}

/// `sums += a x + b y`.
#[inline(always)]
pub(crate) fn add_two<V: Eight>(factors: [f64; 2], rows: [&[Lane]; 2], sums: &mut [Lane]) {
    let [a, b] = broadcast::<V>(factors);
    let count = sums.len();
    let [x, y] = truncated_rows(rows, count);
    for i in 0..count {
        (V::load(&sums[i]) + a * V::load(&x[i]) + b * V::load(&y[i])).store(&mut sums[i]);
    }
}

/// `sum_j |x_j| y_j`.
#[inline(always)]
pub(crate) fn weighted<V: Eight>(x: &[Lane], y: &[Lane]) -> f64 {
    let mut sums = V::all(0.0);
    for (x, y) in x.iter().zip(y) {
        sums = sums + V::load(x).size() * V::load(y);
    }
    sums.sum()
}
