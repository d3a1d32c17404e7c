//! Stresses at many positions of a ring, as rows on its coordinates, and the largest of them.
//!
//! ```text
//! sigma_i = sum_j r_ij q_j,    |sigma_i| <= sum over pairs (j, k) of s_jk sqrt(q_j^2 + q_k^2),    s_jk = max_i sqrt(r_ij^2 + r_ik^2)     (1)
//! ```
//! r_ij: stress at position i per unit coordinate j. Two modes with equal frequency are a pair: a wave travelling around the ring has a
//! constant pair amplitude. The bound (1) is then close to the stress under a single load, where all waves add. A coordinate without a
//! partner is a pair with itself. Verified by `the_largest_size_is_found_with_its_place`, `no_stress_exceeds_its_bound`.

use super::force_columns::ForceColumns;
use crate::eight::{dots, largest_dot};
use crate::stator::NodalForces;
use crate::structure::Part;
use bladeoff_numerics::linalg::lanes::{LANES, Lane, kernel, rows_times};
use bladeoff_numerics::linalg::{Csr, Matrix};

/// Maximum number of groups of positions with bounds of the stresses by contact forces.
pub(super) const GROUPS: usize = 4;
/// Factor on a bound that covers the rounding of its sum.
const ROUNDED_UP: f64 = 1.0 + 1e-12;

/// Coordinates of a ring in pairs of equal frequency; a single coordinate is its own partner.
#[derive(Debug, Clone)]
pub(super) struct Pairs(Vec<[usize; 2]>);

/// Buffers for amplitudes.
#[derive(Debug, Clone, Default)]
pub(super) struct Amplitudes {
    /// Two coordinates of each pair.
    of: [Vec<f64>; 2],
    /// Amplitude of each pair.
    sizes: Vec<f64>,
}

impl Pairs {
    /// Pairs of the coordinates of a part: two successive modes of equal frequency are a pair.
    pub fn of(part: &Part) -> Self {
        let size = part.coordinates.size();
        let square = |j: usize| part.stiffness[(j, j)];
        let (mut pairs, mut j) = (Vec::with_capacity(size), 0);
        while j < size {
            let two = part.modal && j + 1 < size && (square(j + 1) - square(j)).abs() <= 1e-9 * square(j).abs();
            pairs.push([j, j + usize::from(two)]);
            j += 1 + usize::from(two);
        }
        Self(pairs)
    }

    /// Amplitude `sqrt(q_j^2 + q_k^2)` of each pair.
    pub fn amplitudes<'a>(&self, q: &[f64], room: &'a mut Amplitudes) -> &'a [f64] {
        self.sizes(|j| q[j], room)
    }

    /// Pair amplitudes of the difference of two coordinate vectors.
    pub fn distances<'a>(&self, q: &[f64], from: &[f64], room: &'a mut Amplitudes) -> &'a [f64] {
        self.sizes(|j| q[j] - from[j], room)
    }

    #[inline(always)]
    fn sizes<'a>(&self, of: impl Fn(usize) -> f64, room: &'a mut Amplitudes) -> &'a [f64] {
        let Amplitudes { of: [one, other], sizes } = room;
        let count = self.0.len();
        for list in [&mut *one, &mut *other, &mut *sizes] {
            list.resize(count, 0.0);
        }
        for ((one, other), &[j, k]) in one.iter_mut().zip(&mut *other).zip(&self.0) {
            (*one, *other) = (of(j), of(k));
        }
        sizes_of(one, other, sizes);
        sizes
    }

    /// Coefficients s_jk of (1). `columns`: one row per coordinate, one column per position.
    fn largest(&self, columns: &Matrix) -> Vec<f64> {
        let mut largest = vec![0.0_f64; self.0.len()];
        for column in columns.column_iter() {
            for (largest, &[j, k]) in largest.iter_mut().zip(&self.0) {
                // a single coordinate counts twice in its amplitude
                let share = if j == k { 0.25 } else { 1.0 };
                *largest = largest.max(share * (column[j] * column[j] + column[k] * column[k]));
            }
        }
        largest.iter().map(|square| ROUNDED_UP * square.sqrt()).collect()
    }
}

kernel! {
    /// Norms of vectors whose components are in two lists.
    fn sizes_of(a: &[f64], b: &[f64], sizes: &mut [f64]) {
        for (size, (a, b)) in sizes.iter_mut().zip(a.iter().zip(b)) {
            *size = (a * a + b * b).sqrt();
        }
    }
}

/// Stress bounds of up to eight groups of positions at once: (1) for coordinates, and a bound per unit force on each degree of freedom.
#[derive(Debug, Clone)]
pub(super) struct Bounds {
    /// Coefficients s_jk of (1) per pair, one lane entry per group.
    pairs: Vec<Lane>,
    /// Largest stress per unit force on each degree of freedom, per group \[Pa/N\].
    forces: Vec<[f64; GROUPS]>,
}

impl Bounds {
    /// Computes the bounds of groups of positions.
    pub fn new(groups: &[&Fibres]) -> Self {
        let pairs = groups.first().map_or(0, |group| group.largest.len());
        let of = |pair: usize| Lane(std::array::from_fn(|k| groups.get(k).map_or(0.0, |group| group.largest[pair])));
        let by_forces: Vec<&[f64]> =
            groups.iter().filter_map(|group| Some(&*group.by_forces.as_ref()?.largest)).collect();
        let dofs = by_forces.first().map_or(0, |largest| largest.len());
        let force =
            |dof: usize| std::array::from_fn(|k| by_forces.get(k).map_or(0.0, |largest| ROUNDED_UP * largest[dof]));
        Self { pairs: (0..pairs).map(of).collect(), forces: (0..dofs).map(force).collect() }
    }

    /// Bounds of the stress magnitudes of each group \[Pa\], from the pair amplitudes of [`Pairs::amplitudes`]. A NaN is passed on; it ends
    /// the run anyway.
    pub fn of(&self, amplitudes: &[f64]) -> [f64; LANES] {
        rows_times(&self.pairs, amplitudes)
    }

    /// Bounds of the stresses of the first [`GROUPS`] groups under contact forces (degree of freedom, force) \[Pa\]; 0 without truncated
    /// modes.
    pub fn of_forces(&self, forces: impl Iterator<Item = (usize, f64)>) -> [f64; GROUPS] {
        let mut sums = [0.0; GROUPS];
        for (dof, force) in forces {
            if let Some(largest) = self.forces.get(dof) {
                sums.iter_mut().zip(largest).for_each(|(sum, largest)| *sum += force.abs() * largest);
            }
        }
        sums
    }
}

/// Stresses of a group of positions.
#[derive(Debug, Clone)]
pub(super) struct Fibres {
    /// Coefficients r_ij of (1).
    rows: Rows,
    /// Static response of the truncated modes to the contact forces; `None` without truncated modes.
    by_forces: Option<ForceColumns>,
    /// Buffer for these stresses \[Pa\].
    added: Vec<Lane>,
    /// Coefficients s_jk of (1).
    largest: Vec<f64>,
}

/// Stress per unit coordinate, one row per position: sparse for nodal degrees of freedom, dense for modes.
#[derive(Debug, Clone)]
enum Rows {
    Nodal(Csr),
    /// Rows in lanes of eight positions, padded with zeros.
    Modal(Vec<Lane>),
}

impl Fibres {
    /// Prepares the stresses of a group. `columns`: one row per coordinate, one column per position. `modal`: the coordinates are modes,
    /// each of which contributes to every position. `by_forces`: stresses of the same positions by contact forces.
    pub fn new(columns: &Matrix, by_forces: Option<ForceColumns>, pairs: &Pairs, modal: bool) -> Self {
        let rows = if modal {
            Rows::Modal((0..columns.ncols()).step_by(LANES).flat_map(|first| eight(columns, first)).collect())
        } else {
            Rows::Nodal(Csr::from_dense(&columns.transpose()))
        };
        Self { rows, by_forces, added: Vec::new(), largest: pairs.largest(columns) }
    }

    /// Largest magnitude of all stresses by coordinates and contact forces \[Pa\].
    pub fn largest(&mut self, q: &[f64], forces: &NodalForces) -> f64 {
        self.add(forces);
        match &self.rows {
            Rows::Nodal(rows) => rows.largest_product(q),
            Rows::Modal(rows) => largest_dot(rows, q, &self.added),
        }
    }

    /// Computes the stresses by contact forces.
    fn add(&mut self, forces: &NodalForces) {
        match &self.by_forces {
            Some(columns) if !forces.is_empty() => columns.stresses(forces, &mut self.added),
            _ => self.added.clear(),
        }
    }

    /// Stresses at all positions \[Pa\].
    #[cfg(test)]
    pub fn products(&self, q: &[f64]) -> Vec<f64> {
        match &self.rows {
            Rows::Nodal(rows) => rows.products(q).collect(),
            Rows::Modal(rows) => {
                let mut stresses = Lane::default();
                let blocks = rows.chunks_exact(q.len());
                blocks
                    .flat_map(|block| {
                        dots(block, q, &mut stresses);
                        stresses.0
                    })
                    .collect()
            }
        }
    }

    /// First position with the stress magnitude `largest`, found by [`Fibres::largest`] for the same coordinates and forces.
    pub fn place_of(&mut self, largest: f64, q: &[f64], forces: &NodalForces) -> usize {
        self.add(forces);
        let found = match &self.rows {
            Rows::Nodal(rows) => rows.products(q).position(|stress| stress.abs() == largest),
            Rows::Modal(rows) => {
                let mut stresses = Lane::default();
                rows.chunks_exact(q.len().max(1)).enumerate().find_map(|(at, block)| {
                    dots(block, q, &mut stresses);
                    let added = self.added.get(at).copied().unwrap_or_default();
                    let mut sums = stresses.0.iter().zip(added.0).map(|(stress, added)| stress + added);
                    sums.position(|stress| stress.abs() == largest).map(|k| LANES * at + k)
                })
            }
        };
        found.unwrap_or(0)
    }
}

/// Lanes of eight columns from `first` on, one lane per row.
fn eight(columns: &Matrix, first: usize) -> Vec<Lane> {
    let count = columns.ncols().min(first + LANES) - first;
    (0..columns.nrows())
        .map(|j| Lane(std::array::from_fn(|k| if k < count { columns[(j, first + k)] } else { 0.0 })))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::Coordinates;

    /// Coordinates of a part whose modes 1 and 2 are a pair.
    fn part(size: usize) -> Part {
        let squares = [1.0, 4.0, 4.0, 9.0, 16.0, 25.0, 25.0, 36.0, 49.0];
        Part {
            coordinates: Coordinates::modal(&Matrix::identity(size, size)),
            mass: Matrix::identity(size, size),
            damping: Matrix::zeros(size, size),
            stiffness: Matrix::from_fn(size, size, |i, j| if i == j { squares[i] } else { 0.0 }),
            modal: true,
            highest: 7.0,
        }
    }

    #[test]
    fn the_largest_size_is_found_with_its_place() {
        let pairs = Pairs::of(&part(9));
        assert_eq!(pairs.0, [[0, 0], [1, 2], [3, 3], [4, 4], [5, 6], [7, 7], [8, 8]]);
        for places in [1, 7, 8, 21] {
            let columns = Matrix::from_fn(9, places, |j, i| ((i * 7919 + j * 104_729) % 1013) as f64 - 506.3);
            let [mut modal, mut nodal] = [true, false].map(|modal| Fibres::new(&columns, None, &pairs, modal));
            for round in 0..20 {
                let q: Vec<f64> = (0..9).map(|j| ((round * 31 + j * 17) % 23) as f64 - 11.2).collect();
                let of = |i: usize| (0..9).map(|j| columns[(j, i)] * q[j]).sum::<f64>().abs();
                let at = (0..places).max_by(|&i, &k| of(i).total_cmp(&of(k))).expect("places");
                for fibres in [&mut modal, &mut nodal] {
                    let largest = fibres.largest(&q, &NodalForces::none());
                    assert!((largest / of(at) - 1.0).abs() < 1e-12);
                    assert_eq!(fibres.place_of(largest, &q, &NodalForces::none()), at);
                }
            }
        }
    }

    #[test]
    fn no_stress_exceeds_its_bound() {
        let pairs = Pairs::of(&part(9));
        let columns = Matrix::from_fn(9, 21, |j, i| ((i * 7919 + j * 104_729) % 1013) as f64 - 506.3);
        let mut fibres = Fibres::new(&columns, None, &pairs, true);
        let (bounds, mut room, mut closest) = (Bounds::new(&[&fibres]), Amplitudes::default(), 0.0_f64);
        for round in 0..200 {
            let q: Vec<f64> = (0..9)
                .map(|j| if round % 9 == j { 1.0 } else { ((round * 31 + j * 17) % 23) as f64 / 11.0 - 1.0 })
                .collect();
            let share = fibres.largest(&q, &NodalForces::none()) / bounds.of(pairs.amplitudes(&q, &mut room))[0];
            closest = closest.max(share);
        }
        // for a single coordinate the bound is the stress itself
        let alone: Vec<f64> = (0..9).map(|j| if j == 3 { -2.0 } else { 0.0 }).collect();
        let one = fibres.largest(&alone, &NodalForces::none()) / bounds.of(pairs.amplitudes(&alone, &mut room))[0];
        assert!(closest <= 1.0 && closest > 0.5, "{closest}");
        assert!(one <= 1.0 && one > 1.0 - 1e-11, "{one}");
    }
}
