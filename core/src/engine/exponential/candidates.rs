//! Candidate places of contact: fixed angles of a ring, so close that the force may pass from one to the next.
//!
//! ```text
//! P_c = (R_i + v_c) e_r + u_c e_theta,   (v_c, u_c) = sum_j (V_cj, U_cj) q_j            g_c = |P_c - x| - R_r                  (1)
//! ```
//! With g >= 0 at all of them nothing has to be searched: no closest point, no place that jumps, no fixed point. Where they are looked for is [`super::survey`].
//! Source: the conditions of docs/theory/03-contact.md at fixed angles (collocation). Verified by `tests/exponential_rub.rs`.

use super::ExponentialError;
use super::bound::length;
use crate::linalg::lanes::{LANES, Lane, kernel};
use crate::linalg::{axpy, column_of};
use crate::stator::Surface;
use crate::structure::{RingPart, Structure};
use bladeoff_model::machine::{ContactSurface, Diaphragm};

/// Candidates of a block: their number is a multiple of it.
pub(super) const BLOCK: usize = LANES;

/// Candidates of a ring, at least. Places that press beside the nearest one are candidates, two spacings from it or more: with 192 of them the turbine's 1 ms force is
/// 0.3 % off.
const CANDIDATES: usize = 384;
/// Elements of a ring at most: the table between candidates grows with their square.
const ELEMENTS: usize = 200;
/// The candidates of one ring.
#[derive(Debug, Clone)]
pub(super) struct Candidates {
    /// From one to the next \[rad\].
    pub spacing: f64,
    /// sin and cos of their angles.
    pub angles: Vec<(f64, f64)>,
    /// cos and sin of those of each block.
    pub directions: Vec<[[f64; BLOCK]; 2]>,
    /// V and U of the candidates of each block, mode by mode.
    radial: Vec<Lane>,
    tangential: Vec<Lane>,
    /// V and then U of each candidate, zeros behind the last mode.
    rows: Vec<f64>,
    modes: usize,
    /// Entries of a row: the modes, and zeros up to a multiple of eight.
    width: usize,
    /// Largest displacement of any candidate per amplitude, for each mode, and its radial part.
    reach: Vec<f64>,
    pub radial_reach: Vec<f64>,
    /// Displacements per impulse of the modes left out between two candidates, radial and tangential, by rows, of the blocks of one acting side by side; empty
    /// where none are.
    left_out: Vec<[Lane; 4]>,
    /// What the modes left out close at most of a candidate's clearance, per unit impulse along and across the radius of another.
    pub most_closed: [f64; 2],
}

impl Candidates {
    /// So many of each element, a multiple of [`BLOCK`] of all; the modes left out follow impulses over `h` \[s\].
    pub fn new(part: &RingPart, surface: &Surface, per_element: usize, h: f64) -> Self {
        let places: Vec<(usize, f64)> = (0..surface.nodes * per_element)
            .map(|c| (c / per_element, ((c % per_element) as f64 + 0.5) / per_element as f64))
            .collect();
        let modes = part.part.coordinates.size();
        let (count, width) = (places.len(), modes.next_multiple_of(LANES));
        let mut shapes = vec![0.0; 2 * count * width];
        for (&(element, xi), rows) in places.iter().zip(shapes.chunks_exact_mut(2 * width)) {
            let (v, u) = rows.split_at_mut(width);
            for (dof, radial, tangential) in surface.shapes(element, xi) {
                part.part.coordinates.add_row(dof, radial, &mut v[..modes]);
                part.part.coordinates.add_row(dof, tangential, &mut u[..modes]);
            }
        }
        let at = |c: usize, j: usize| [shapes[2 * c * width + j], shapes[(2 * c + 1) * width + j]];
        let most = |of: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            (0..width).map(|j| (0..count).map(|c| of(c, j)).fold(0.0, f64::max)).collect()
        };
        let (reach, radial_reach) = (most(&|c, j| length(at(c, j))), most(&|c, j| at(c, j)[0].abs()));
        let left_out = part.residual.as_ref().map(|flexibility| {
            // each candidate loads a few freedoms
            let shapes: Vec<[(usize, f64, f64); 8]> =
                places.iter().map(|&(element, xi)| surface.shapes(element, xi)).collect();
            let mut moved = [0, 1].map(|_| vec![0.0; flexibility.nrows()]);
            let mut blocks = vec![[Lane::default(); 4]; count * count / BLOCK];
            for (acting, shape) in shapes.iter().enumerate() {
                moved.iter_mut().for_each(|column| column.fill(0.0));
                for &(dof, radial, tangential) in shape {
                    axpy(radial / h, column_of(flexibility, dof), &mut moved[0]);
                    axpy(tangential / h, column_of(flexibility, dof), &mut moved[1]);
                }
                for (at, shape) in shapes.iter().enumerate() {
                    let (block, k) = (&mut blocks[(acting * count + at) / BLOCK], at % BLOCK);
                    for &(dof, radial, tangential) in shape {
                        let by = [moved[0][dof], moved[1][dof]];
                        block[0].0[k] += radial * by[0];
                        block[1].0[k] += radial * by[1];
                        block[2].0[k] += tangential * by[0];
                        block[3].0[k] += tangential * by[1];
                    }
                }
            }
            blocks
        });
        let left_out = left_out.unwrap_or_default();
        let by_blocks = |part: usize| -> Vec<Lane> {
            let entries = (0..count / BLOCK).flat_map(|block| (0..modes).map(move |j| (block, j)));
            entries.map(|(block, j)| Lane(std::array::from_fn(|k| at(block * BLOCK + k, j)[part]))).collect()
        };
        let angles: Vec<(f64, f64)> =
            places.iter().map(|&(element, xi)| libm::sincos(surface.angle(element, xi))).collect();
        Self {
            most_closed: left_out
                .iter()
                .flat_map(|[a, b, ..]| a.0.into_iter().zip(b.0))
                .fold([0.0; 2], |[one, other]: [f64; 2], (a, b)| [one.max(-a), other.max(b.abs())]),
            spacing: 2.0 * std::f64::consts::PI / count as f64,
            directions: angles
                .chunks_exact(BLOCK)
                .map(|block| [std::array::from_fn(|k| block[k].1), std::array::from_fn(|k| block[k].0)])
                .collect(),
            angles,
            left_out,
            radial: by_blocks(0),
            tangential: by_blocks(1),
            rows: shapes,
            modes,
            width,
            reach,
            radial_reach,
        }
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.angles.len()
    }

    /// Bound of every candidate's displacement per amplitude of each mode.
    pub fn reach(&self) -> &[f64] {
        &self.reach
    }

    /// V of the candidates of a block, column by column.
    pub fn radial(&self, block: usize) -> &[Lane] {
        &self.radial[block * self.modes..(block + 1) * self.modes]
    }

    /// The same of U.
    pub fn tangential(&self, block: usize) -> &[Lane] {
        &self.tangential[block * self.modes..(block + 1) * self.modes]
    }

    /// V and U of a candidate.
    pub fn of(&self, c: usize) -> (&[f64], &[f64]) {
        self.rows[2 * c * self.width..2 * (c + 1) * self.width].split_at(self.width)
    }

    /// The candidates beside one.
    pub fn beside(&self, c: usize) -> [usize; 2] {
        let count = self.count();
        [if c == 0 { count - 1 } else { c - 1 }, if c + 1 == count { 0 } else { c + 1 }]
    }

    /// Displacement of a candidate by a unit impulse at another in the modes left out, in polar axes, by rows.
    pub fn left_out(&self, at: usize, acting: usize) -> [f64; 4] {
        let block = self.left_out.get((acting * self.count() + at) / BLOCK);
        block.map_or([0.0; 4], |block| block.each_ref().map(|part| part.0[at % BLOCK]))
    }

    /// The same of the candidates of a block by impulses in polar axes at others, radial and tangential.
    pub fn all_left_out(&self, block: usize, acting: &[(usize, [f64; 2])]) -> [[f64; BLOCK]; 2] {
        let mut moved = [[0.0; BLOCK]; 2];
        if !self.left_out.is_empty() {
            all_left_out(&self.left_out, self.count() / BLOCK, block, acting, &mut moved);
        }
        moved
    }
}

kernel! {
    /// Sums of blocks by two impulses each.
    fn all_left_out(
        table: &[[Lane; 4]],
        blocks: usize,
        block: usize,
        acting: &[(usize, [f64; 2])],
        moved: &mut [[f64; BLOCK]; 2],
    ) {
        let [mut v, mut u] = [[0.0; BLOCK]; 2];
        for &(at, [along, aside]) in acting {
            let [a, b, c, d] = &table[at * blocks + block];
            for k in 0..BLOCK {
                v[k] = v[k] + a.0[k] * along + b.0[k] * aside;
            }
            for k in 0..BLOCK {
                u[k] = u[k] + c.0[k] * along + d.0[k] * aside;
            }
        }
        *moved = [v, u];
    }
}

/// The candidates of a diaphragm, for contact steps of `h` \[s\].
pub(super) fn candidates(
    diaphragm: &Diaphragm,
    structure: &Structure,
    index: usize,
    h: f64,
) -> Result<Candidates, ExponentialError> {
    let part = ring_of(structure, index)?;
    let contact = &diaphragm.contact;
    let inner = contact.surface == ContactSurface::InnerFace;
    let surface = part.matrices.surface(contact.rotor_radius + contact.gap, inner);
    let modes = modes(part);
    if modes.iter().any(|&(square, _)| square <= 0.0) {
        return Err(ExponentialError::NotCovered { what: "a ring that nothing holds" });
    }
    if surface.nodes > ELEMENTS {
        return Err(ExponentialError::NotCovered { what: "a ring of more than 200 elements" });
    }
    let mut per_element = CANDIDATES.div_ceil(surface.nodes);
    while !(per_element * surface.nodes).is_multiple_of(BLOCK) {
        per_element += 1;
    }
    Ok(Candidates::new(part, &surface, per_element, h))
}

/// The flexible ring of a diaphragm.
pub(super) fn ring_of(structure: &Structure, index: usize) -> Result<&RingPart, ExponentialError> {
    structure.rings[index].as_ref().ok_or(ExponentialError::NotCovered { what: "a stator without freedoms" })
}

/// w^2 and c of each mode.
pub(super) fn modes(part: &RingPart) -> Vec<(f64, f64)> {
    (0..part.part.coordinates.size()).map(|j| (part.part.stiffness[(j, j)], part.part.damping[(j, j)])).collect()
}

/// Whether two of so many candidates are one, or beside each other.
pub(super) fn beside(one: usize, other: usize, count: usize) -> bool {
    let apart = one.abs_diff(other);
    apart <= 1 || apart + 1 == count
}

/// Weights of three values at -1, 0 and 1 for the value of their parabola.
pub(super) fn parabola(share: f64) -> [f64; 3] {
    [0.5 * share * (share - 1.0), 1.0 - share * share, 0.5 * share * (share + 1.0)]
}
