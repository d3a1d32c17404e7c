//! Products and sums over the ring's modes in a contact step, in groups of eight with zeros behind the last mode.
//!
//! Each function is inlined into the function of one vector width that calls it ([`crate::eight`]).

use crate::eight::Eight;
use bladeoff_numerics::linalg::lanes::Lane;

/// Rows of a contact point, in groups of eight modes.
#[derive(Debug, Clone)]
pub(crate) struct PointRows {
    /// Mode shapes along normal and tangent.
    along: [Vec<Lane>; 2],
    /// Response of the modes at n+1 to unit impulses along normal and tangent of the acting position.
    responses: [Vec<Lane>; 2],
}

impl PointRows {
    /// Creates rows for `lanes` groups of eight modes.
    pub fn new(lanes: usize) -> Self {
        let rows = || [vec![Lane::default(); lanes], vec![Lane::default(); lanes]];
        Self { along: rows(), responses: rows() }
    }

    /// Mode shapes along normal and tangent.
    #[inline(always)]
    pub fn along(&self) -> [&[Lane]; 2] {
        let [normal, tangent] = &self.along;
        [normal, tangent]
    }

    /// Response of the modes at n+1 to a unit normal and a unit tangential impulse.
    #[inline(always)]
    pub fn responses(&self) -> [&[Lane]; 2] {
        let [normal, tangential] = &self.responses;
        [normal, tangential]
    }
}

/// The first `count` groups of each row. (`map` of arrays would be a function of its own, without the vectors of its caller.)
#[inline(always)]
fn leading_groups<const N: usize>(mut rows: [&[Lane]; N], count: usize) -> [&[Lane]; N] {
    for row in &mut rows {
        *row = &row[..count];
    }
    rows
}

/// Each of two numbers in all eight places of a vector.
#[inline(always)]
pub(crate) fn broadcast<V: Eight>([a, b]: [f64; 2]) -> [V; 2] {
    [V::all(a), V::all(b)]
}

/// Two groups of eight as vectors.
#[inline(always)]
pub(crate) fn load_lanes<V: Eight>([a, b]: &[Lane; 2]) -> [V; 2] {
    [V::load(a), V::load(b)]
}

/// State of the ring's modes in a contact step: compliance, displacement over the step, and the displacement that the predictor
/// has assumed.
#[derive(Clone, Copy)]
pub(crate) struct StepState<'a> {
    pub compliance: &'a [Lane],
    pub travel: &'a [Lane],
    pub assumed: &'a [Lane],
}

/// Products of a point's rows with the state of a step.
pub(crate) struct RowSums {
    /// Displacement of the ring along the tangent over the step \[m\].
    pub travel_along_tangent: f64,
    /// Displacement along the normal that the predictor has assumed \[m\].
    pub assumed_opening: f64,
    /// Displacements at the point per impulse at its acting position, in the order of [`row_products`] \[m/(N s)\].
    pub coupling: [f64; 4],
}

/// Writes the rows of a contact point. Its mode shapes are a weighted sum of those of three ring points, along two directions of
/// its polar axes; the impulses act along the acting rows, otherwise along the point's own rows.
#[inline(always)]
pub(crate) fn write_rows<V: Eight>(
    three: [[&[Lane]; 2]; 3],
    weights: [f64; 3],
    directions: [[f64; 2]; 2],
    acting_rows: Option<[&[Lane]; 2]>,
    step: StepState<'_>,
    rows: &mut PointRows,
) -> RowSums {
    let (a, b, c) = (V::all(weights[0]), V::all(weights[1]), V::all(weights[2]));
    let [[np, nq], [tp, tq]] = [broadcast::<V>(directions[0]), broadcast::<V>(directions[1])];
    let PointRows { along: [normal, tangent], responses: [by_normal, by_tangent] } = rows;
    let count = normal.len();
    let [[va, ua], [vb, ub], [vc, uc]] =
        [leading_groups(three[0], count), leading_groups(three[1], count), leading_groups(three[2], count)];
    let StepState { compliance, travel, assumed } = step;
    let (compliance, travel, assumed) = (&compliance[..count], &travel[..count], &assumed[..count]);
    let (normal, tangent) = (&mut normal[..count], &mut tangent[..count]);
    let (by_normal, by_tangent) = (&mut by_normal[..count], &mut by_tangent[..count]);
    for i in 0..count {
        let v = a * V::load(&va[i]) + b * V::load(&vb[i]) + c * V::load(&vc[i]);
        let u = a * V::load(&ua[i]) + b * V::load(&ub[i]) + c * V::load(&uc[i]);
        (np * v + nq * u).store(&mut normal[i]);
        (tp * v + tq * u).store(&mut tangent[i]);
    }
    let [m, s] = leading_groups(acting_rows.unwrap_or([&*normal, &*tangent]), count);
    let mut sums = [V::all(0.0); 6];
    for i in 0..count {
        let (n, t) = (V::load(&normal[i]), V::load(&tangent[i]));
        let compliance = V::load(&compliance[i]);
        let responses = [compliance * V::load(&m[i]), compliance * V::load(&s[i])];
        let (travel, assumed) = (V::load(&travel[i]), V::load(&assumed[i]));
        sums[0] = sums[0] + t * travel;
        sums[1] = sums[1] + n * assumed;
        sums[2] = sums[2] + n * responses[0];
        sums[3] = sums[3] + n * responses[1];
        sums[4] = sums[4] + t * responses[0];
        sums[5] = sums[5] + t * responses[1];
        responses[0].store(&mut by_normal[i]);
        responses[1].store(&mut by_tangent[i]);
    }
    let [travel_along_tangent, assumed_opening, nn, nt, tn, tt] = sums;
    RowSums {
        travel_along_tangent: travel_along_tangent.sum(),
        assumed_opening: assumed_opening.sum(),
        coupling: [nn.sum(), nt.sum(), tn.sum(), tt.sum()],
    }
}

/// Products of two rows with two others: of the first with both, then of the second with both.
#[inline(always)]
pub(crate) fn row_products<V: Eight>(rows: [&[Lane]; 2], others: [&[Lane]; 2]) -> [f64; 4] {
    let count = rows[0].len();
    let ([n, t], [m, s]) = (leading_groups(rows, count), leading_groups(others, count));
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

/// Products of rows with a list.
#[inline(always)]
pub(crate) fn products_with<V: Eight, const N: usize>(rows: [&[Lane]; N], list: &[Lane]) -> [f64; N] {
    let count = list.len();
    let rows = leading_groups(rows, count);
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

/// Adds a x + b y to sums.
#[inline(always)]
pub(crate) fn add_scaled_rows<V: Eight>(factors: [f64; 2], rows: [&[Lane]; 2], sums: &mut [Lane]) {
    let [a, b] = broadcast::<V>(factors);
    let count = sums.len();
    let [x, y] = leading_groups(rows, count);
    for i in 0..count {
        (V::load(&sums[i]) + a * V::load(&x[i]) + b * V::load(&y[i])).store(&mut sums[i]);
    }
}

/// `sum_j |x_j| y_j`.
#[inline(always)]
pub(crate) fn weighted_sum<V: Eight>(x: &[Lane], y: &[Lane]) -> f64 {
    let mut sums = V::all(0.0);
    for (x, y) in x.iter().zip(y) {
        sums = sums + V::load(x).size() * V::load(y);
    }
    sums.sum()
}
