//! Candidate places of contact: fixed angles of a ring, so close that the force may pass from one to the next.
//!
//! ```text
//! P_c = (R_i + v_c) e_r + u_c e_theta,   (v_c, u_c) = sum_j (V_cj, U_cj) q_j            g_c = |P_c - x| - R_r                  (1)
//! ```
//! With g >= 0 at all of them nothing has to be searched: no closest point, no place that jumps, no fixed point. Where they are looked for is [`super::survey`].
//! Source: the conditions of docs/theory/03-contact.md at fixed angles (collocation). Verified by `tests/exponential_rub.rs`.

use super::ExponentialError;
use super::bound::length;
use crate::linalg::{axpy, column_of};
use crate::stator::Surface;
use crate::structure::{RingPart, Structure};
use bladeoff_model::machine::{ContactSurface, Diaphragm};

/// Candidates of a block: their number is a multiple of it.
pub(super) const BLOCK: usize = 4;

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
    /// V and U of the four candidates of each block, mode by mode; and V of the first candidates of four blocks.
    radial: Vec<f64>,
    tangential: Vec<f64>,
    firsts: Vec<f64>,
    /// V and then U of each candidate.
    rows: Vec<f64>,
    modes: usize,
    /// Largest displacement of any candidate per amplitude, for each mode; its radial part; and the most that its radial part is from the straight line
    /// between the ends of a block.
    reach: Vec<f64>,
    pub radial_reach: Vec<f64>,
    pub bend: Vec<f64>,
    /// Displacements per impulse of the modes left out between two candidates: radial and tangential, by rows; empty where none are.
    left_out: Vec<[f64; 4]>,
    /// The most that a unit impulse displaces any candidate along its radius in them.
    pub most_left_out: f64,
}

impl Candidates {
    /// So many of each element, a multiple of [`BLOCK`]; the modes left out follow impulses over `h` \[s\].
    pub fn new(part: &RingPart, surface: &Surface, per_element: usize, h: f64) -> Self {
        let places: Vec<(usize, f64)> = (0..surface.nodes * per_element)
            .map(|c| (c / per_element, ((c % per_element) as f64 + 0.5) / per_element as f64))
            .collect();
        let modes = part.part.coordinates.size();
        let count = places.len();
        let mut shapes = vec![0.0; 2 * count * modes];
        for (&(element, xi), rows) in places.iter().zip(shapes.chunks_exact_mut(2 * modes)) {
            let (v, u) = rows.split_at_mut(modes);
            for (dof, radial, tangential) in surface.shapes(element, xi) {
                part.part.coordinates.add_row(dof, radial, v);
                part.part.coordinates.add_row(dof, tangential, u);
            }
        }
        let at = |c: usize, j: usize| [shapes[2 * c * modes + j], shapes[(2 * c + 1) * modes + j]];
        let most = |of: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            (0..modes).map(|j| (0..count).map(|c| of(c, j)).fold(0.0, f64::max)).collect()
        };
        let bend = |c: usize, j: usize| {
            let (first, share) = (c - c % BLOCK, (c % BLOCK) as f64 / BLOCK as f64);
            let ends = [at(first, j)[0], at((first + BLOCK) % count, j)[0]];
            (at(c, j)[0] - ends[0] * (1.0 - share) - ends[1] * share).abs()
        };
        let (reach, radial_reach) = (most(&|c, j| length(at(c, j))), most(&|c, j| at(c, j)[0].abs()));
        let bend = most(&bend);
        let left_out = part.residual.as_ref().map(|flexibility| {
            // each candidate loads a few freedoms
            let shapes: Vec<[(usize, f64, f64); 8]> =
                places.iter().map(|&(element, xi)| surface.shapes(element, xi)).collect();
            let mut moved = [0, 1].map(|_| vec![0.0; flexibility.nrows()]);
            let mut blocks = vec![[0.0; 4]; count * count];
            for (acting, shape) in shapes.iter().enumerate() {
                moved.iter_mut().for_each(|column| column.fill(0.0));
                for &(dof, radial, tangential) in shape {
                    axpy(radial / h, column_of(flexibility, dof), &mut moved[0]);
                    axpy(tangential / h, column_of(flexibility, dof), &mut moved[1]);
                }
                for (at, shape) in shapes.iter().enumerate() {
                    let block = &mut blocks[at * count + acting];
                    for &(dof, radial, tangential) in shape {
                        let by = [moved[0][dof], moved[1][dof]];
                        block[0] += radial * by[0];
                        block[1] += radial * by[1];
                        block[2] += tangential * by[0];
                        block[3] += tangential * by[1];
                    }
                }
            }
            blocks
        });
        let left_out = left_out.unwrap_or_default();
        Self {
            most_left_out: left_out.iter().map(|[a, b, ..]: &[f64; 4]| length([*a, *b])).fold(0.0, f64::max),
            spacing: 2.0 * std::f64::consts::PI / count as f64,
            angles: places.iter().map(|&(element, xi)| libm::sincos(surface.angle(element, xi))).collect(),
            left_out,
            radial: by_fours(modes, count, |c, j| at(c, j)[0]),
            tangential: by_fours(modes, count, |c, j| at(c, j)[1]),
            firsts: by_fours(modes, count / BLOCK, |b, j| at(b * BLOCK, j)[0]),
            rows: shapes,
            modes,
            reach,
            radial_reach,
            bend,
        }
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.angles.len()
    }

    /// Bound of every candidate's displacement \[m\], of the modes' amplitudes.
    pub fn reach(&self, amplitudes: impl Iterator<Item = f64>) -> f64 {
        self.reach.iter().zip(amplitudes).map(|(reach, amplitude)| reach * amplitude).sum()
    }

    /// V of the four candidates of a block, mode by mode.
    pub fn radials(&self, block: usize, q: &[f64]) -> [f64; BLOCK] {
        of_four(&self.radial, block, q)
    }

    /// Radial displacements of the first candidates of four blocks, from the `four`-th four on.
    pub fn radials_of_firsts(&self, four: usize, q: &[f64]) -> [f64; BLOCK] {
        of_four(&self.firsts, four, q)
    }

    /// U of the four candidates of a block, mode by mode.
    pub fn tangentials(&self, block: usize, q: &[f64]) -> [f64; BLOCK] {
        of_four(&self.tangential, block, q)
    }

    /// V and U of a candidate.
    fn of(&self, c: usize) -> (&[f64], &[f64]) {
        self.rows[2 * c * self.modes..2 * (c + 1) * self.modes].split_at(self.modes)
    }

    /// Rows of the place `share` of a spacing beyond a candidate, along two directions of its polar axes: by the parabola through the candidate and those beside it.
    pub fn rows_at(&self, c: usize, share: f64, directions: [[f64; 2]; 2], rows: [&mut [f64]; 2]) {
        let (weights, beside) = (parabola(share), self.beside(c));
        let ([normal, tangent], [[np, nq], [tp, tq]]) = (rows, directions);
        let three = [self.of(beside[0]), self.of(c), self.of(beside[1])];
        let [a, b, c] = weights;
        let modes = self.modes;
        // slices of one length: no checks inside the loop
        let [va, vb, vc] = three.map(|(v, _)| &v[..modes]);
        let [ua, ub, uc] = three.map(|(_, u)| &u[..modes]);
        let (normal, tangent) = (&mut normal[..modes], &mut tangent[..modes]);
        for j in 0..modes {
            let (v, u) = (a * va[j] + b * vb[j] + c * vc[j], a * ua[j] + b * ub[j] + c * uc[j]);
            normal[j] = np * v + nq * u;
            tangent[j] = tp * v + tq * u;
        }
    }

    /// The candidates beside one.
    pub fn beside(&self, c: usize) -> [usize; 2] {
        let count = self.count();
        [if c == 0 { count - 1 } else { c - 1 }, if c + 1 == count { 0 } else { c + 1 }]
    }

    /// Displacement of a candidate by a unit impulse at another in the modes left out, in polar axes.
    pub fn left_out(&self, at: usize, acting: usize) -> &[f64; 4] {
        self.left_out.get(at * self.count() + acting).unwrap_or(&[0.0; 4])
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
    let per_element = CANDIDATES.div_ceil(surface.nodes).next_multiple_of(BLOCK);
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

/// Entries of so many places, those of four beside each other: four sums at a time in one order. Past the last place they are zero.
fn by_fours(modes: usize, count: usize, entry: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let fours = count.div_ceil(BLOCK);
    let of = |place: usize| {
        let (four, j, k) = (place / (modes * BLOCK), place / BLOCK % modes, place % BLOCK);
        if BLOCK * four + k < count { entry(BLOCK * four + k, j) } else { 0.0 }
    };
    (0..fours * modes * BLOCK).map(of).collect()
}

fn of_four(entries: &[f64], four: usize, q: &[f64]) -> [f64; BLOCK] {
    let (rows, _) = entries[four * q.len() * BLOCK..(four + 1) * q.len() * BLOCK].as_chunks::<BLOCK>();
    let mut sums = [0.0; BLOCK];
    for (row, q) in rows.iter().zip(q) {
        for k in 0..BLOCK {
            sums[k] += row[k] * q;
        }
    }
    sums
}

/// Weights of three values at -1, 0 and 1 for the value of their parabola.
pub(super) fn parabola(share: f64) -> [f64; 3] {
    [0.5 * share * (share - 1.0), 1.0 - share * share, 0.5 * share * (share + 1.0)]
}
