//! Products and sums of the ring's modes in a contact step. All lists have a multiple of eight entries, zeros behind the last mode.

use crate::linalg::lanes::{LANES, Lane, kernel, least_of, rows_times_inline, sum};

kernel! {
    /// Rows along two directions of polar axes of a place whose V and U are so much of those of three candidates, and the product of the second with a list.
    pub(super) fn rows_at(
        three: [(&[f64], &[f64]); 3],
        weights: [f64; 3],
        directions: [[f64; 2]; 2],
        normal: &mut [f64],
        tangent: &mut [f64],
        list: &[f64],
    ) -> f64 {
        let [a, b, c] = weights;
        let [[np, nq], [tp, tq]] = directions;
        let count = normal.len();
        let [(va, ua), (vb, ub), (vc, uc)] = three;
        let (va, vb, vc) = (&va[..count], &vb[..count], &vc[..count]);
        let (ua, ub, uc) = (&ua[..count], &ub[..count], &uc[..count]);
        let tangent = &mut tangent[..count];
        for j in 0..count {
            let v = a * va[j] + b * vb[j] + c * vc[j];
            let u = a * ua[j] + b * ub[j] + c * uc[j];
            normal[j] = np * v + nq * u;
            tangent[j] = tp * v + tq * u;
        }
        let mut sums = [0.0; LANES];
        for (t, list) in tangent.as_chunks::<LANES>().0.iter().zip(list.as_chunks::<LANES>().0) {
            for k in 0..LANES {
                sums[k] += t[k] * list[k];
            }
        }
        sum(sums)
    }
}

kernel! {
    /// Keeps a row along which impulses act, and it times what the modes yield.
    pub(super) fn yielding(yields: &[f64], act: &[f64], kept: &mut [f64], by: &mut [f64]) {
        let count = yields.len();
        let (act, kept, by) = (&act[..count], &mut kept[..count], &mut by[..count]);
        for j in 0..count {
            kept[j] = act[j];
            by[j] = yields[j] * act[j];
        }
    }
}

kernel! {
    /// `sums += a x + b y`.
    pub(super) fn add_both(factors: [f64; 2], rows: [&[f64]; 2], sums: &mut [f64]) {
        let [a, b] = factors;
        let count = sums.len();
        let (x, y) = (&rows[0][..count], &rows[1][..count]);
        for j in 0..count {
            sums[j] = sums[j] + a * x[j] + b * y[j];
        }
    }
}

kernel! {
    /// `statics *= lacking, foreseen = place + statics`.
    pub(super) fn add_statics(lacking: &[f64], place: &[f64], statics: &mut [f64], foreseen: &mut [f64]) {
        let count = statics.len();
        let (lacking, place, foreseen) = (&lacking[..count], &place[..count], &mut foreseen[..count]);
        for j in 0..count {
            statics[j] *= lacking[j];
            foreseen[j] = place[j] + statics[j];
        }
    }
}

kernel! {
    /// `sum_j |x_j| y_j`.
    pub(super) fn weighted(x: &[f64], y: &[f64]) -> f64 {
        let mut sums = [0.0; LANES];
        for (x, y) in x.as_chunks::<LANES>().0.iter().zip(y.as_chunks::<LANES>().0) {
            for k in 0..LANES {
                sums[k] += x[k].abs() * y[k];
            }
        }
        sum(sums)
    }
}

/// Products of two rows with a list.
pub(super) fn both_products(rows: [&[f64]; 2], list: &[f64]) -> [f64; 2] {
    let mut lanes = [[0.0; LANES]; 2];
    both_lanes(rows[0], rows[1], list, &mut lanes);
    lanes.map(sum)
}

/// Products of two rows with two others: of the first with both, then of the second.
pub(super) fn along_both(rows: [&[f64]; 2], others: [&[f64]; 2]) -> [f64; 4] {
    let mut lanes = [[[0.0; LANES]; 2]; 2];
    let [one, other] = &mut lanes;
    both_lanes(others[0], others[1], rows[0], one);
    both_lanes(others[0], others[1], rows[1], other);
    let [[a, b], [c, d]] = lanes;
    [a, b, c, d].map(sum)
}

kernel! {
    /// Products of two rows with a list, lane by lane. (Summed here, the lanes would be shuffled to sum them all at once.)
    fn both_lanes(a: &[f64], b: &[f64], list: &[f64], lanes: &mut [[f64; LANES]; 2]) {
        let list = list.as_chunks::<LANES>().0;
        let count = list.len();
        let (a, b) = (&a.as_chunks::<LANES>().0[..count], &b.as_chunks::<LANES>().0[..count]);
        let (mut one, mut other) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..count {
            for k in 0..LANES {
                one[k] += a[i][k] * list[i][k];
            }
            for k in 0..LANES {
                other[k] += b[i][k] * list[i][k];
            }
        }
        *lanes = [one, other];
    }
}

kernel! {
    /// The least of eight clearances after the rotor has moved, with the places' directions.
    pub(super) fn least_moved(clearances: &[f64; LANES], directions: &[[f64; LANES]; 2], rotor: [f64; 2]) -> f64 {
        let mut moved = *clearances;
        for k in 0..LANES {
            moved[k] = moved[k] + rotor[0] * directions[0][k] + rotor[1] * directions[1][k];
        }
        least_of(moved)
    }
}

kernel! {
    /// Those clearances after the ring has moved besides, by the columns of V, the least of them, and what the ring has moved.
    pub(super) fn moved_clearances(
        radial: &[Lane],
        q: &[f64],
        clearances: &[f64; LANES],
        directions: &[[f64; LANES]; 2],
        rotor: [f64; 2],
    ) -> (f64, [[f64; LANES]; 2]) {
        let ring = rows_times_inline(radial, &q[..radial.len()]);
        let mut moved = *clearances;
        for k in 0..LANES {
            moved[k] = moved[k] + ring[k] + rotor[0] * directions[0][k] + rotor[1] * directions[1][k];
        }
        (least_of(moved), [moved, ring])
    }
}
