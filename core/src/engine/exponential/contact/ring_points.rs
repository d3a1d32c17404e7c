//! Candidate places of contact: fixed angles of a ring, so close that the force may pass from one to the next.
//!
//! ```text
//! P_c = (R_i + v_c) e_r + u_c e_theta,   (v_c, u_c) = sum_j (V_cj, U_cj) q_j            g_c = |P_c - x| - R_r                  (1)
//! ```
//! With g >= 0 at all of them nothing has to be searched: no closest point, no place that jumps, no fixed point. Where they are looked for is [`super::survey`].
//! Source: the conditions of docs/theory/03-contact.md at fixed angles (collocation). Verified by `tests/exponential_rub.rs`.

use super::impulsed_ring::StaticCorrection;
use super::ring_kernels::broadcast;
use crate::engine::exponential::error::ExponentialError;
use crate::engine::exponential::modal::displacement_bound::length;
use crate::engine::time_step::CONTACT_FRACTION;
use crate::linalg::eight::Eight;
use crate::linalg::lanes::{LANES, Lane, lanes_of};
use crate::linalg::{Matrix, axpy, column_of};
use crate::stator::Surface;
use crate::structure::{RingPart, Structure};
use bladeoff_model::machine::{ContactSurface, Diaphragm, DiaphragmKind};

/// Candidates of a block: their number is a multiple of it.
pub(crate) const BLOCK: usize = LANES;

/// Candidates of a ring, at least. Places that press beside the nearest one are candidates, two spacings from it or more: with 192 of them the turbine's 1 ms force is
/// 0.3 % off.
const POINT_COUNT: usize = 384;
/// Parts of the largest by which displacements in two sectors differ that are the same: rounding of a ring's modes.
const SAME: f64 = 1e-8;
/// Elements of a ring at most: the table between candidates grows with their square.
const ELEMENTS: usize = 200;
/// The candidates of one ring.
#[derive(Debug, Clone)]
pub(crate) struct RingPoints {
    /// From one to the next \[rad\].
    pub spacing: f64,
    /// sin and cos of their angles.
    pub angles: Vec<(f64, f64)>,
    /// cos and sin of those of each block.
    pub directions: Vec<[Lane; 2]>,
    /// V and U of the candidates of each block, mode by mode.
    radial: Vec<Lane>,
    tangential: Vec<Lane>,
    /// V and then U of each candidate, zeros behind the last mode.
    rows: Vec<Lane>,
    modes: usize,
    /// Lanes of a row.
    lanes: usize,
    /// Largest displacement of any candidate per amplitude, for each mode, and its radial part.
    pub reach: Vec<Lane>,
    pub radial_reach: Vec<Lane>,
    /// Displacements per impulse of the modes left out between two candidates, radial and tangential, by rows: of the blocks behind that of an acting one side by
    /// side, for each acting one of the first sector, from one blade to the next. The others have the same, turned. Empty where no modes are left out.
    truncated_flexibility: Vec<[Lane; 4]>,
    /// The least and the largest of the first of those four, and the largest size of the second.
    along_range: [f64; 2],
    aside_range: f64,
    /// The largest displacement per impulse along the radius, and along the ring.
    max_truncated_flexibility: [f64; 2],
    /// Of each candidate, where those that it acts on begin in the table, and by how many blocks it is turned.
    columns: Vec<TruncatedColumn>,
    /// How the modes left out follow impulses.
    pub static_correction: StaticCorrection,
}

/// Of a candidate where impulses act: its part of the table of the modes left out.
#[derive(Debug, Clone, Copy)]
struct TruncatedColumn {
    from: usize,
    turned: usize,
}

impl RingPoints {
    /// So many of each element, a multiple of [`BLOCK`] of all, on a ring of so many equal sectors.
    pub fn new(
        part: &RingPart,
        surface: &Surface,
        per_element: usize,
        sectors: usize,
        statics: StaticCorrection,
    ) -> Self {
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
        let (reach, radial_reach) =
            (lanes_of(&most(&|c, j| length(at(c, j)))), lanes_of(&most(&|c, j| at(c, j)[0].abs())));
        let (sector, left_out) = match &part.residual {
            Some(flexibility) => truncated_table(flexibility, surface, &places, sectors, statics.gain()),
            None => (count, Vec::new()),
        };
        let by_blocks = |part: usize| -> Vec<Lane> {
            let entries = (0..count / BLOCK).flat_map(|block| (0..modes).map(move |j| (block, j)));
            entries.map(|(block, j)| Lane(std::array::from_fn(|k| at(block * BLOCK + k, j)[part]))).collect()
        };
        let blocks = count / BLOCK;
        let column = |c: usize| TruncatedColumn { from: c % sector * blocks, turned: c / sector * (sector / BLOCK) };
        let angles: Vec<(f64, f64)> =
            places.iter().map(|&(element, xi)| libm::sincos(surface.angle(element, xi))).collect();
        Self {
            along_range: left_out
                .iter()
                .flat_map(|[a, ..]| a.0)
                .fold([0.0; 2], |[least, most], a| [a.min(least), a.max(most)]),
            aside_range: left_out.iter().flat_map(|[_, b, ..]| b.0).fold(0.0, |most, b| most.max(b.abs())),
            max_truncated_flexibility: [0, 1].map(|i| {
                let pairs = left_out.iter().flat_map(|table| table[i].0.into_iter().zip(table[i + 2].0));
                pairs.fold(0.0_f64, |most, (v, u)| most.max(length([v, u])))
            }),
            columns: (0..count).map(column).collect(),
            spacing: 2.0 * std::f64::consts::PI / count as f64,
            directions: angles
                .chunks_exact(BLOCK)
                .map(|block| [Lane(std::array::from_fn(|k| block[k].1)), Lane(std::array::from_fn(|k| block[k].0))])
                .collect(),
            angles,
            truncated_flexibility: left_out,
            static_correction: statics,
            radial: by_blocks(0),
            tangential: by_blocks(1),
            rows: lanes_of(&shapes),
            modes,
            lanes: width / LANES,
            reach,
            radial_reach,
        }
    }

    /// How many.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.angles.len()
    }

    /// V of the candidates of a block, column by column.
    #[inline(always)]
    pub fn radial(&self, block: usize) -> &[Lane] {
        &self.radial[block * self.modes..(block + 1) * self.modes]
    }

    /// The same of U.
    #[inline(always)]
    pub fn tangential(&self, block: usize) -> &[Lane] {
        &self.tangential[block * self.modes..(block + 1) * self.modes]
    }

    /// V and U of a candidate.
    #[inline(always)]
    pub fn of(&self, c: usize) -> [&[Lane]; 2] {
        let (v, u) = self.rows[2 * c * self.lanes..2 * (c + 1) * self.lanes].split_at(self.lanes);
        [v, u]
    }

    /// |x| d^2/8, by which a rotor at x may be nearer between two candidates of a round ring than at them \[m\].
    #[inline(always)]
    pub fn sagitta(&self, x: [f64; 2]) -> f64 {
        0.125 * self.spacing * self.spacing * length(x)
    }

    /// The candidates beside one.
    #[inline(always)]
    pub fn neighbours(&self, c: usize) -> [usize; 2] {
        let count = self.count();
        [if c == 0 { count - 1 } else { c - 1 }, if c + 1 == count { 0 } else { c + 1 }]
    }

    /// Sectors that are alike.
    #[cfg(test)]
    pub fn sectors(&self) -> usize {
        self.columns.iter().filter(|column| column.from == 0).count()
    }

    /// That of a block by one acting: its lanes in the table.
    #[inline(always)]
    fn left_out_of(&self, block: usize, acting: usize) -> &[Lane; 4] {
        let TruncatedColumn { from, turned } = self.columns[acting];
        let back = if block >= turned { block - turned } else { block + self.directions.len() - turned };
        &self.truncated_flexibility[from + back]
    }

    /// Displacement of a candidate by a unit impulse at another in the modes left out, in polar axes, by rows.
    #[inline(always)]
    pub fn left_out(&self, at: usize, acting: usize) -> [f64; 4] {
        if self.truncated_flexibility.is_empty() {
            return [0.0; 4];
        }
        let ([a, b, c, d], k) = (self.left_out_of(at / BLOCK, acting), at % BLOCK);
        [a.0[k], b.0[k], c.0[k], d.0[k]]
    }

    /// The same of the candidates of a block by impulses in polar axes at others: the radial part (0) or the tangential one (1).
    #[inline(always)]
    pub fn all_left_out<V: Eight>(&self, block: usize, acting: &[(usize, [f64; 2])], part: usize) -> V {
        let mut sum = V::all(0.0);
        if self.truncated_flexibility.is_empty() {
            return sum;
        }
        for &(at, impulse) in acting {
            let table = self.left_out_of(block, at);
            let [along, aside] = broadcast::<V>(impulse);
            sum = sum + V::load(&table[2 * part]) * along + V::load(&table[2 * part + 1]) * aside;
        }
        sum
    }

    /// What the modes left out close at most of any clearance, by such impulses; and how far they move any candidate at most.
    #[inline(always)]
    pub fn most_left_out(&self, acting: &[(usize, [f64; 2])]) -> [f64; 2] {
        let (mut closed, mut moved, [least, most]) = (0.0, 0.0, self.along_range);
        for &(_, [along, aside]) in acting {
            closed += self.aside_range * aside.abs() - along * if along < 0.0 { most } else { least };
            moved += self.max_truncated_flexibility[0] * along.abs() + self.max_truncated_flexibility[1] * aside.abs();
        }
        [closed, moved]
    }
}

/// Displacements per impulse of the modes left out by each acting candidate of a sector, and how many that are: all where a ring of so many sectors is not
/// the same turned by one (a pair of modes of which one is left out), or where that takes no block to a block.
fn truncated_table(
    flexibility: &Matrix,
    surface: &Surface,
    places: &[(usize, f64)],
    sectors: usize,
    gain: f64,
) -> (usize, Vec<[Lane; 4]>) {
    let count = places.len();
    // each candidate loads a few freedoms
    let shapes: Vec<[(usize, f64, f64); 8]> = places.iter().map(|&(element, xi)| surface.shapes(element, xi)).collect();
    let mut moved = [0, 1].map(|_| vec![0.0; flexibility.nrows()]);
    let mut by = |acting: usize, blocks: &mut [[Lane; 4]]| {
        moved.iter_mut().for_each(|column| column.fill(0.0));
        for &(dof, radial, tangential) in &shapes[acting] {
            axpy(gain * radial, column_of(flexibility, dof), &mut moved[0]);
            axpy(gain * tangential, column_of(flexibility, dof), &mut moved[1]);
        }
        for (at, shape) in shapes.iter().enumerate() {
            let (block, k) = (&mut blocks[at / BLOCK], at % BLOCK);
            for &(dof, radial, tangential) in shape {
                let by = [moved[0][dof], moved[1][dof]];
                block[0].0[k] += radial * by[0];
                block[1].0[k] += radial * by[1];
                block[2].0[k] += tangential * by[0];
                block[3].0[k] += tangential * by[1];
            }
        }
    };
    let blocks = count / BLOCK;
    let mut sector = if (count / sectors).is_multiple_of(BLOCK) { count / sectors } else { count };
    if sector < count {
        let mut two = vec![[Lane::default(); 4]; 2 * blocks];
        let (one, other) = two.split_at_mut(blocks);
        by(0, one);
        by(sector, other);
        let turned = other[sector / BLOCK..].iter().chain(&other[..sector / BLOCK]);
        let pairs = || {
            one.iter()
                .zip(turned.clone())
                .flat_map(|(a, b)| a.iter().zip(b))
                .flat_map(|(a, b)| a.0.into_iter().zip(b.0))
        };
        let size = pairs().fold(0.0, |most: f64, (a, _)| most.max(a.abs()));
        if pairs().any(|(a, b)| (a - b).abs() > SAME * size) {
            sector = count;
        }
    }
    let mut table = vec![[Lane::default(); 4]; sector * blocks];
    table.chunks_exact_mut(blocks).enumerate().for_each(|(acting, blocks)| by(acting, blocks));
    (sector, table)
}

/// The candidates of a diaphragm, for contact steps of `h` \[s\].
pub(crate) fn ring_points(
    diaphragm: &Diaphragm,
    structure: &Structure,
    index: usize,
    h: f64,
) -> Result<RingPoints, ExponentialError> {
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
    let mut per_element = POINT_COUNT.div_ceil(surface.nodes);
    while !(per_element * surface.nodes).is_multiple_of(BLOCK) {
        per_element += 1;
    }
    // all blades are alike, and stand at nodes
    let (blades, lag) = match &diaphragm.kind {
        DiaphragmKind::Flexible(stator) => {
            (stator.blades.map_or(0, |blades| blades.count), stator.damping.stiffness_proportional)
        }
        _ => (0, 0.0),
    };
    let sectors = if blades > 0 { blades } else { surface.nodes };
    Ok(RingPoints::new(part, &surface, per_element, sectors, StaticCorrection::new(h, lag * refinement(&modes, h))))
}

/// How much of the lag of the truncated modes a contact step takes: none at the default step, which damps them itself, all from half of it on.
fn refinement(modes: &[(f64, f64)], h: f64) -> f64 {
    let fastest = modes.iter().fold(0.0_f64, |most, &(square, _)| most.max(square)).sqrt();
    (2.0 * CONTACT_FRACTION / (fastest * h) - 1.0).clamp(0.0, 1.0)
}

/// The flexible ring of a diaphragm.
pub(crate) fn ring_of(structure: &Structure, index: usize) -> Result<&RingPart, ExponentialError> {
    structure.rings[index].as_ref().ok_or(ExponentialError::NotCovered { what: "a stator without freedoms" })
}

/// w^2 and c of each mode.
pub(crate) fn modes(part: &RingPart) -> Vec<(f64, f64)> {
    (0..part.part.coordinates.size()).map(|j| (part.part.stiffness[(j, j)], part.part.damping[(j, j)])).collect()
}

/// Whether two of so many candidates are one, or beside each other.
#[inline(always)]
pub(crate) fn beside(one: usize, other: usize, count: usize) -> bool {
    let apart = one.abs_diff(other);
    apart <= 1 || apart + 1 == count
}

/// Weights of three values at -1, 0 and 1 for the value of their parabola.
#[inline(always)]
pub(crate) fn parabola(share: f64) -> [f64; 3] {
    [0.5 * share * (share - 1.0), 1.0 - share * share, 0.5 * share * (share + 1.0)]
}
