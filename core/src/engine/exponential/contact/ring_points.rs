//! Ring points: fixed angles of a ring at which the gap to the rotor is evaluated, so close that the contact force passes
//! smoothly from one to the next.
//!
//! ```text
//! P_c = (R_i + v_c) e_r + u_c e_theta,   (v_c, u_c) = sum_j (V_cj, U_cj) q_j                                                     (1)
//! g_c = |P_c - x| - R_r                                                                                                         (2)
//! ```
//! P_c: position of point c \[m\]; R_i: radius of the ring's surface; v, u: radial and tangential displacement; q_j: amplitude of
//! mode j; V, U: its shape; x: displacement of the rotor's centre; R_r: radius of the rotor; g: gap \[m\].
//!
//! Contact is a condition g >= 0 at all points (collocation of docs/theory/03-contact.md). No closest point has to be iterated
//! for. The points near the rotor are found by [`super::broad_phase`]. Verified by `tests/exponential/exponential_rub.rs`.

use super::impulsed_ring::StaticCorrection;
use super::ring_kernels::broadcast;
use super::static_compliance::StaticCompliance;
use crate::eight::Eight;
use crate::engine::exponential::plane::length;
use crate::engine::time_step::CONTACT_FRACTION;
use crate::stator::Surface;
use crate::structure::{RingPart, Structure};
use bladeoff_model::machine::{ContactSurface, Diaphragm, DiaphragmKind};
use bladeoff_numerics::linalg::lanes::{LANES, Lane, lanes_of};
use bladeoff_numerics::linalg::{Matrix, axpy, column_of};

/// Number of ring points of a block. The number of points is a multiple of it.
pub(crate) const BLOCK: usize = LANES;

/// Smallest number of ring points. Contact points beside a gap minimum are two spacings from it or more: with 192 points the
/// turbine's 1 ms force is 0.3 % off.
const POINT_COUNT: usize = 384;
/// Relative difference below which displacements in two sectors are the same, apart from the rounding of the ring's modes.
const SECTOR_TOLERANCE: f64 = 1e-8;
/// Largest number of elements that have points at the same places each. The points of finer rings are as many as the elements, or a few more: a common multiple of a
/// prime number of elements and [`BLOCK`] would make a table of the truncated modes of several hundred megabytes.
const MAX_ALIKE_ELEMENTS: usize = 200;
/// Points of one ring, with the mode shapes and the response of the truncated modes there.
#[derive(Debug, Clone)]
pub(crate) struct RingPoints {
    /// Surface of the ring, for its shape functions: rings that touch at their mean line share these points whatever their gap.
    pub surface: Surface,
    /// Angle between two points \[rad\].
    pub spacing: f64,
    /// Sine and cosine of each point's angle.
    pub angles: Vec<(f64, f64)>,
    /// Cosines and sines of the angles, by blocks.
    pub directions: Vec<[Lane; 2]>,
    /// V and U of the points of each block, mode by mode.
    radial: Vec<Lane>,
    tangential: Vec<Lane>,
    /// V, then U, of each point over the modes, zeros behind the last mode.
    rows: Vec<Lane>,
    /// Number of modes.
    modes: usize,
    /// Number of groups of eight modes.
    lanes: usize,
    /// Largest displacement of any point per amplitude of each mode, and largest radial displacement.
    pub reach: Vec<Lane>,
    pub radial_reach: Vec<Lane>,
    /// Response of the truncated modes between two points: displacements per impulse, radial and tangential, by rows \[m/(N s)\].
    /// The table has all blocks of the ring for each acting point of the first sector, from one blade to the next. Other sectors
    /// are the same, rotated. Empty without truncated modes.
    truncated_flexibility: Vec<[Lane; 4]>,
    /// Smallest and largest radial displacement per radial impulse, and largest size of one per tangential impulse \[m/(N s)\].
    direct_range: [f64; 2],
    cross_range: f64,
    /// Largest displacement per radial and per tangential impulse \[m/(N s)\].
    max_truncated_flexibility: [f64; 2],
    /// Table entry of each acting point.
    columns: Vec<TruncatedColumn>,
    /// Response of the truncated modes to a train of impulses.
    pub static_correction: StaticCorrection,
    /// Compliances of the ring under a constant force; empty for a rigid ring.
    pub static_compliances: Vec<StaticCompliance>,
}

/// Entry of an acting point in the table of the truncated modes: its first block there, and its rotation in blocks.
#[derive(Debug, Clone, Copy)]
struct TruncatedColumn {
    from: usize,
    turned: usize,
}

/// Impulse on the truncated modes at a ring point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TruncatedImpulse {
    pub index: usize,
    /// Radial and tangential component \[N s\].
    pub impulse: [f64; 2],
    column: TruncatedColumn,
}

impl RingPoints {
    /// Creates the `count` points of a ring with `sectors` equal sectors; `count` is a multiple of [`BLOCK`]. `part`: `None` for a rigid ring.
    pub fn new(
        part: Option<&RingPart>,
        surface: &Surface,
        count: usize,
        sectors: usize,
        statics: StaticCorrection,
    ) -> Self {
        // point c is (c + 1/2)/count of a turn
        let location = |c: usize| {
            let (half_steps, whole) = ((2 * c + 1) * surface.nodes, 2 * count);
            (half_steps / whole, (half_steps % whole) as f64 / whole as f64)
        };
        let locations: Vec<(usize, f64)> = (0..count).map(location).collect();
        let modes = part.map_or(0, |part| part.part.coordinates.size());
        let width = modes.next_multiple_of(LANES);
        let mut shapes = vec![0.0; 2 * count * width];
        if let Some(part) = part {
            for (&(element, xi), rows) in locations.iter().zip(shapes.chunks_exact_mut(2 * width)) {
                let (v, u) = rows.split_at_mut(width);
                for (dof, radial, tangential) in surface.shapes(element, xi) {
                    part.part.coordinates.add_row(dof, radial, &mut v[..modes]);
                    part.part.coordinates.add_row(dof, tangential, &mut u[..modes]);
                }
            }
        }
        let at = |c: usize, j: usize| [shapes[2 * c * width + j], shapes[(2 * c + 1) * width + j]];
        let largest = |of: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            (0..width).map(|j| (0..count).map(|c| of(c, j)).fold(0.0, f64::max)).collect()
        };
        let (reach, radial_reach) =
            (lanes_of(&largest(&|c, j| length(at(c, j)))), lanes_of(&largest(&|c, j| at(c, j)[0].abs())));
        let (sector, truncated_flexibility) = match part.and_then(|part| part.residual.as_ref()) {
            Some(flexibility) => truncated_table(flexibility, surface, &locations, sectors, statics.gain()),
            None => (count, Vec::new()),
        };
        let by_blocks = |part: usize| -> Vec<Lane> {
            let entries = (0..count / BLOCK).flat_map(|block| (0..modes).map(move |j| (block, j)));
            entries.map(|(block, j)| Lane(std::array::from_fn(|k| at(block * BLOCK + k, j)[part]))).collect()
        };
        let blocks = count / BLOCK;
        let column = |c: usize| TruncatedColumn { from: c % sector * blocks, turned: c / sector * (sector / BLOCK) };
        let angles: Vec<(f64, f64)> =
            locations.iter().map(|&(element, xi)| libm::sincos(surface.angle(element, xi))).collect();
        Self {
            surface: *surface,
            direct_range: truncated_flexibility
                .iter()
                .flat_map(|[a, ..]| a.0)
                .fold([0.0; 2], |[smallest, largest], a| [a.min(smallest), a.max(largest)]),
            cross_range: truncated_flexibility
                .iter()
                .flat_map(|[_, b, ..]| b.0)
                .fold(0.0, |largest, b| largest.max(b.abs())),
            max_truncated_flexibility: [0, 1].map(|i| {
                let pairs = truncated_flexibility.iter().flat_map(|table| table[i].0.into_iter().zip(table[i + 2].0));
                pairs.fold(0.0_f64, |largest, (v, u)| largest.max(length([v, u])))
            }),
            columns: (0..count).map(column).collect(),
            spacing: 2.0 * std::f64::consts::PI / count as f64,
            directions: angles
                .chunks_exact(BLOCK)
                .map(|block| [Lane(std::array::from_fn(|k| block[k].1)), Lane(std::array::from_fn(|k| block[k].0))])
                .collect(),
            angles,
            truncated_flexibility,
            static_correction: statics,
            static_compliances: part
                .map_or_else(Vec::new, |part| StaticCompliance::of(part, surface, &locations, sectors)),
            radial: by_blocks(0),
            tangential: by_blocks(1),
            rows: lanes_of(&shapes),
            modes,
            lanes: width / LANES,
            reach,
            radial_reach,
        }
    }

    /// Number of points.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.angles.len()
    }

    /// Whether modes are truncated, and follow the contact forces.
    pub fn has_truncated_modes(&self) -> bool {
        !self.truncated_flexibility.is_empty()
    }

    /// V of the points of a block, mode by mode.
    #[inline(always)]
    pub fn radial(&self, block: usize) -> &[Lane] {
        &self.radial[block * self.modes..(block + 1) * self.modes]
    }

    /// U of the points of a block, mode by mode.
    #[inline(always)]
    pub fn tangential(&self, block: usize) -> &[Lane] {
        &self.tangential[block * self.modes..(block + 1) * self.modes]
    }

    /// V and U of a point over the modes.
    #[inline(always)]
    pub fn rows(&self, c: usize) -> [&[Lane]; 2] {
        let (v, u) = self.rows[2 * c * self.lanes..2 * (c + 1) * self.lanes].split_at(self.lanes);
        [v, u]
    }

    /// Sagitta |x| d^2/8 of the arc between two points with spacing d \[m\]: a rotor displaced by x may be nearer to a round ring
    /// between two points than at them by this.
    #[inline(always)]
    pub fn sagitta(&self, x: [f64; 2]) -> f64 {
        0.125 * self.spacing * self.spacing * length(x)
    }

    /// The two points beside a point.
    #[inline(always)]
    pub fn neighbours(&self, c: usize) -> [usize; 2] {
        let count = self.count();
        [if c == 0 { count - 1 } else { c - 1 }, if c + 1 == count { 0 } else { c + 1 }]
    }

    /// Nearest point to an angle \[rad\], and the offset of the angle from it in spacings.
    #[inline(always)]
    pub fn locate(&self, angle: f64) -> (usize, f64) {
        let position = angle / self.spacing - 0.5;
        let nearest = libm::round(position);
        ((nearest as i64).rem_euclid(self.count() as i64) as usize, position - nearest)
    }

    /// Number of equal sectors.
    #[cfg(test)]
    pub fn sectors(&self) -> usize {
        self.columns.iter().filter(|column| column.from == 0).count()
    }

    /// Impulse on the truncated modes at a point, in polar axes \[N s\].
    #[inline(always)]
    pub fn truncated_impulse(&self, index: usize, impulse: [f64; 2]) -> TruncatedImpulse {
        TruncatedImpulse { index, impulse, column: self.columns[index] }
    }

    /// Table entries of the points of a block for an acting point.
    #[inline(always)]
    fn truncated_lanes(&self, block: usize, TruncatedColumn { from, turned }: TruncatedColumn) -> &[Lane; 4] {
        let back = if block >= turned { block - turned } else { block + self.directions.len() - turned };
        &self.truncated_flexibility[from + back]
    }

    /// Response of the truncated modes at a point to a unit impulse at another, in polar axes, by rows \[m/(N s)\].
    #[inline(always)]
    pub fn truncated_response(&self, at: usize, acting: usize) -> [f64; 4] {
        if self.truncated_flexibility.is_empty() {
            return [0.0; 4];
        }
        let ([a, b, c, d], k) = (self.truncated_lanes(at / BLOCK, self.columns[acting]), at % BLOCK);
        [a.0[k], b.0[k], c.0[k], d.0[k]]
    }

    /// Response of the truncated modes at the points of a block to impulses in polar axes \[m\]: the radial part (0) or the
    /// tangential one (1).
    #[inline(always)]
    pub fn block_truncated_response<V: Eight>(&self, block: usize, acting: &[TruncatedImpulse], part: usize) -> V {
        let mut sum = V::all(0.0);
        if self.truncated_flexibility.is_empty() {
            return sum;
        }
        for point in acting {
            let table = self.truncated_lanes(block, point.column);
            let [radial, tangential] = broadcast::<V>(point.impulse);
            sum = sum + V::load(&table[2 * part]) * radial + V::load(&table[2 * part + 1]) * tangential;
        }
        sum
    }

    /// Bounds of the response of the truncated modes to impulses in polar axes: of the closure of a gap along the radius, and of
    /// the displacement of a point \[m\].
    #[inline(always)]
    pub fn truncated_bounds(&self, acting: &[TruncatedImpulse]) -> [f64; 2] {
        let (mut closure, mut displacement, [smallest, largest]) = (0.0, 0.0, self.direct_range);
        for &TruncatedImpulse { impulse: [radial, tangential], .. } in acting {
            closure += self.cross_range * tangential.abs() - radial * if radial < 0.0 { largest } else { smallest };
            displacement +=
                self.max_truncated_flexibility[0] * radial.abs() + self.max_truncated_flexibility[1] * tangential.abs();
        }
        [closure, displacement]
    }
}

/// Table of the response of the truncated modes, and the number of acting points in it: those of one sector, or all points where
/// the sectors are not equal (one mode of a pair is truncated) or a sector is no whole number of blocks.
fn truncated_table(
    flexibility: &Matrix,
    surface: &Surface,
    locations: &[(usize, f64)],
    sectors: usize,
    gain: f64,
) -> (usize, Vec<[Lane; 4]>) {
    let count = locations.len();
    // each point loads a few degrees of freedom
    let shapes: Vec<[(usize, f64, f64); 8]> =
        locations.iter().map(|&(element, xi)| surface.shapes(element, xi)).collect();
    let mut response = [0, 1].map(|_| vec![0.0; flexibility.nrows()]);
    let mut add_column = |acting: usize, blocks: &mut [[Lane; 4]]| {
        response.iter_mut().for_each(|column| column.fill(0.0));
        for &(dof, radial, tangential) in &shapes[acting] {
            axpy(gain * radial, column_of(flexibility, dof), &mut response[0]);
            axpy(gain * tangential, column_of(flexibility, dof), &mut response[1]);
        }
        for (at, shape) in shapes.iter().enumerate() {
            let (block, k) = (&mut blocks[at / BLOCK], at % BLOCK);
            for &(dof, radial, tangential) in shape {
                let displacement = [response[0][dof], response[1][dof]];
                block[0].0[k] += radial * displacement[0];
                block[1].0[k] += radial * displacement[1];
                block[2].0[k] += tangential * displacement[0];
                block[3].0[k] += tangential * displacement[1];
            }
        }
    };
    let blocks = count / BLOCK;
    let mut sector = if count.is_multiple_of(sectors * BLOCK) { count / sectors } else { count };
    if sector < count {
        let mut two = vec![[Lane::default(); 4]; 2 * blocks];
        let (first, second) = two.split_at_mut(blocks);
        add_column(0, first);
        add_column(sector, second);
        let turned = second[sector / BLOCK..].iter().chain(&second[..sector / BLOCK]);
        let pairs = || {
            first
                .iter()
                .zip(turned.clone())
                .flat_map(|(a, b)| a.iter().zip(b))
                .flat_map(|(a, b)| a.0.into_iter().zip(b.0))
        };
        let size = pairs().fold(0.0, |largest: f64, (a, _)| largest.max(a.abs()));
        if pairs().any(|(a, b)| (a - b).abs() > SECTOR_TOLERANCE * size) {
            sector = count;
        }
    }
    let mut table = vec![[Lane::default(); 4]; sector * blocks];
    table.chunks_exact_mut(blocks).enumerate().for_each(|(acting, blocks)| add_column(acting, blocks));
    (sector, table)
}

/// Creates the ring points of a diaphragm for contact steps of `h` \[s\].
pub(crate) fn ring_points(diaphragm: &Diaphragm, structure: &Structure, index: usize, h: f64) -> RingPoints {
    let part = structure.rings[index].as_ref();
    let contact = &diaphragm.contact;
    let inner = contact.surface == ContactSurface::InnerFace;
    let radius = contact.rotor_radius + contact.gap;
    let surface = part.map_or_else(|| Surface::circle(radius), |part| part.matrices.surface(radius, inner));
    let modes = modal_parameters(part);
    let mut count = POINT_COUNT.div_ceil(surface.nodes) * surface.nodes;
    if surface.nodes > MAX_ALIKE_ELEMENTS {
        count = surface.nodes.next_multiple_of(BLOCK).max(POINT_COUNT);
    }
    while !count.is_multiple_of(BLOCK) {
        count += surface.nodes;
    }
    // all blades are alike, and stand at nodes
    let (blades, lag) = match &diaphragm.kind {
        DiaphragmKind::Flexible(stator) => {
            (stator.blades.map_or(0, |blades| blades.count), stator.damping.stiffness_proportional)
        }
        _ => (0, 0.0),
    };
    let sectors = if blades > 0 { blades } else { surface.nodes };
    RingPoints::new(part, &surface, count, sectors, StaticCorrection::new(h, lag * refinement(&modes, h)))
}

/// Share of the delay of the truncated modes that a contact step takes: 0 at the default step, which damps these modes itself, 1
/// from half of it on.
fn refinement(modes: &[(f64, f64)], h: f64) -> f64 {
    let fastest = modes.iter().fold(0.0_f64, |largest, &(square, _)| largest.max(square)).sqrt();
    (2.0 * CONTACT_FRACTION / (fastest * h) - 1.0).clamp(0.0, 1.0)
}

/// w^2 \[1/s2\] and c \[1/s\] of each mode; none of a rigid ring.
pub(crate) fn modal_parameters(part: Option<&RingPart>) -> Vec<(f64, f64)> {
    let Some(RingPart { part, .. }) = part else { return Vec::new() };
    (0..part.coordinates.size()).map(|j| (part.stiffness[(j, j)], part.damping[(j, j)])).collect()
}

/// Whether two of `count` points are the same or neighbours.
#[inline(always)]
pub(crate) fn are_adjacent(one: usize, other: usize, count: usize) -> bool {
    let apart = one.abs_diff(other);
    apart <= 1 || apart + 1 == count
}

/// Weights of three values at -1, 0 and 1 in the value of their parabola at `offset`.
#[inline(always)]
pub(crate) fn parabola(offset: f64) -> [f64; 3] {
    [0.5 * offset * (offset - 1.0), 1.0 - offset * offset, 0.5 * offset * (offset + 1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eight::Plain;
    use crate::engine::exponential::plane::by_rows;
    use bladeoff_model::machine::MachineDef;

    #[test]
    fn the_table_of_one_sector_gives_the_response_of_all_points() {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let ring = ring_points(&machine.diaphragms[0], &structure, 0, 5e-6);
        // a table of one sector, and one of all points
        let (part, contact) = (structure.rings[0].as_ref().expect("a ring"), &machine.diaphragms[0].contact);
        let inner = contact.surface == ContactSurface::InnerFace;
        let surface = part.matrices.surface(contact.rotor_radius + contact.gap, inner);
        let whole = RingPoints::new(Some(part), &surface, ring.count(), 1, ring.static_correction);
        assert_eq!([ring.sectors(), whole.sectors()], [8, 1]);
        let acting = [(7, [3.0, -1.0]), (120, [0.5, 2.0]), (ring.count() - 3, [-1.0, 0.5])];
        let impulses = acting.map(|(at, impulse)| ring.truncated_impulse(at, impulse));
        let (mut largest, mut error) = (0.0_f64, 0.0_f64);
        for block in 0..ring.count() / BLOCK {
            let mut all = [Lane::default(); 2];
            all.iter_mut()
                .enumerate()
                .for_each(|(part, lane)| ring.block_truncated_response::<Plain>(block, &impulses, part).store(lane));
            for k in 0..BLOCK {
                let mut wanted = [0.0; 2];
                for (at, impulse) in acting {
                    let by = by_rows(&whole.truncated_response(block * BLOCK + k, at), impulse);
                    wanted = [0, 1].map(|i| wanted[i] + by[i]);
                }
                largest = largest.max(wanted[0].abs());
                error = (0..2).fold(error, |largest, i| largest.max((all[i].0[k] - wanted[i]).abs()));
            }
        }
        assert!(largest > 0.0, "there are truncated modes");
        // sectors are alike to the rounding of the ring's modes
        assert!(error < 1e-9 * largest, "{error:e} of {largest:e}");
    }
}
