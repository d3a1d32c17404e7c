//! Broad phase of the contact search: ring points near the rotor, and the minima of the gap.
//!
//! ```text
//! clearance   r_c = R_i + v_c - x.e_r - R_r <= g_c                 along the radius of point c; symbols of [`super::ring_points`]        (1)
//!             g_c - r_c = (x.e_t - u_c)^2/2R_i nearly              2 um at 0.2 rad from the smallest gap of a turbine
//! bound       r_c + e.x >= (r_c + e.x)_0 - s,                      e: direction of the middle of the point's block; 0: last evaluation
//!             s = sum over steps of  max|e_r - e| |x+ - x| + sum_j |q_j+ - q_j| reach_j                                                  (2)
//! in reach    r_c < |x| d^2/8                                      sagitta of the arc between two points of a round ring                 (3)
//! ```
//! Points are evaluated in blocks, and a block is evaluated only when (2) does not exclude that one of its points is in reach. In
//! most steps most of the ring is not evaluated, and the result is that of an evaluation of the whole ring.
//!
//! Between points the gap is that of a parabola ([`super::gap_minimum`]). Conditions at the points alone would let the rotor come nearer by |x| d^2/8
//! between two of them, and the force would jump from point to point (0.6 % of the lab rig's bearing loads with 192 points).
//!
//! Limits: where the ring's modes bend it inwards, the gap between two points is smaller by (|x| + v'') d^2/8; such a minimum may
//! be found only after a penetration of v'' d^2/8 (below a micrometre on the turbine). Verified by
//! `no_candidate_in_reach_is_missed`, `tests/exponential/exponential_rub.rs`.

pub(super) mod minimum;

use super::gap_minimum::MAX_OFFSET;
use super::ring_kernels::{broadcast, load_lanes};
use super::ring_points::{BLOCK, RingPoints};
use crate::eight::{Eight, by_width, columns_times};
use crate::engine::exponential::plane::length;
use bladeoff_numerics::linalg::lanes::{LANES, Lane, lanes_of};

/// Bound of the rounding errors of the two sides of (2), for lengths of metres \[m\].
const ROUNDING: f64 = 1e-14;
/// Factor that covers the rounding of the sum s.
const ROUNDING_FACTOR: f64 = 1.0 + 1e-9;
/// Value of s at which all bounds are discarded and the sum is begun anew \[m\].
const MAX_TRAVEL: f64 = 0.1;

/// Clearances of the ring points, evaluated where they are needed.
#[derive(Debug, Clone)]
pub(crate) struct BroadPhase {
    /// Radius R_i of the ring's surface, and radius R_r of the rotor \[m\].
    pub(super) radius: f64,
    pub(super) rotor_radius: f64,
    /// Number of the present step.
    step: u64,
    /// Step in which each block was evaluated, its clearances (1) and the smallest of them \[m\].
    evaluated_at: Vec<u64>,
    clearances: Vec<Lane>,
    smallest: Vec<f64>,
    /// Bound (2) of each block at its last evaluation, with the s of then added; infinite behind the last block.
    clearance_bounds: Vec<Lane>,
    /// Cosine and sine of the direction e of each block.
    block_directions: Vec<[Lane; 2]>,
    /// Largest |e_r - e| of any point.
    direction_spread: f64,
    /// Step in which the gaps of each block were evaluated, tangential displacements u, and gaps \[m\].
    gaps_evaluated_at: Vec<u64>,
    tangential: Vec<Lane>,
    gaps: Vec<Lane>,
    /// Amplitudes of the ring and displacement of the rotor in the last step.
    previous: (Vec<Lane>, [f64; 2]),
    /// Sum s of (2) \[m\].
    travel: f64,
    /// Buffer for blocks.
    near_blocks: Vec<usize>,
    /// Points in reach whose neighbours are not nearer, in their order.
    pub minima: Vec<usize>,
}

impl BroadPhase {
    /// Creates the search for a ring with a surface of radius R_i around a rotor of radius R_r \[m\].
    pub fn new(ring: &RingPoints, radius: f64, rotor_radius: f64) -> Self {
        let blocks = ring.count() / BLOCK;
        let none = vec![Lane::default(); blocks];
        let (block_directions, direction_spread) = block_directions(ring);
        Self {
            radius,
            rotor_radius,
            step: 0,
            evaluated_at: vec![0; blocks],
            clearances: none.clone(),
            smallest: vec![0.0; blocks],
            clearance_bounds: unevaluated_bounds(blocks),
            block_directions,
            direction_spread,
            gaps_evaluated_at: vec![0; blocks],
            tangential: none.clone(),
            gaps: none,
            previous: (vec![Lane::default(); ring.radial_reach.len()], [0.0; 2]),
            travel: 0.0,
            near_blocks: Vec::with_capacity(blocks),
            minima: Vec::with_capacity(ring.count()),
        }
    }

    /// Finds the gap minima of a ring with amplitudes q around a rotor displaced by x \[m\].
    #[inline(always)]
    pub fn find_minima<V: Eight>(&mut self, ring: &RingPoints, x: [f64; 2], q: &[Lane]) {
        self.step += 1;
        self.minima.clear();
        let (previous, from) = &mut self.previous;
        let travel = modal_travel::<V>(previous, q, &ring.radial_reach)
            + self.direction_spread * length([x[0] - from[0], x[1] - from[1]]);
        *from = x;
        self.travel += travel * ROUNDING_FACTOR;
        if self.travel > MAX_TRAVEL {
            self.travel = 0.0;
            self.clearance_bounds = unevaluated_bounds(self.evaluated_at.len());
        }
        let sagitta = ring.sagitta(x);
        let mut near = std::mem::take(&mut self.near_blocks);
        self.evaluate_near_blocks::<V>(ring, (sagitta, [0.0; 2]), x, q, &mut near);
        for &block in &near {
            self.find_block_minima::<V>(ring, block, sagitta, x, q);
        }
        self.near_blocks = near;
    }

    /// Finds the blocks of which a point may have a clearance below a limit \[m\] from a rotor displaced by x, by (2).
    #[inline(always)]
    fn find_near_blocks<V: Eight>(&self, limit: f64, x: [f64; 2], blocks: &mut Vec<usize>) {
        blocks.clear();
        let (limit, [x, y]) = (V::all(limit + self.travel + ROUNDING), broadcast::<V>(x));
        for (at, (bounds, directions)) in self.clearance_bounds.iter().zip(&self.block_directions).enumerate() {
            let [cos, sin] = load_lanes::<V>(directions);
            let mut bits = V::load(bounds).less(limit + cos * x + sin * y);
            while bits != 0 {
                blocks.push(LANES * at + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        }
    }

    /// Adds the points of a block whose clearance is a minimum below a limit \[m\].
    #[inline(always)]
    fn find_block_minima<V: Eight>(&mut self, ring: &RingPoints, block: usize, limit: f64, x: [f64; 2], q: &[Lane]) {
        let (clearances, first) = (self.clearances[block].0, block * BLOCK);
        // the ends of the block count as minima here
        let here = V::load(&self.clearances[block]);
        let mut minima =
            here.less(V::all(limit)) & here.less(here.behind(f64::INFINITY)) & !here.before(f64::INFINITY).less(here);
        while minima != 0 {
            let k = minima.trailing_zeros() as usize;
            minima &= minima - 1;
            // at the ends of a block, the neighbour is in another one
            let ([before, next], here) = (ring.neighbours(first + k), clearances[k]);
            if (k == 0 && self.clearance::<V>(ring, before, x, q) < here)
                || (k + 1 == BLOCK && self.clearance::<V>(ring, next, x, q) <= here)
            {
                continue;
            }
            self.minima.push(first + k);
        }
    }

    /// Finds and evaluates the blocks with a clearance below a limit \[m\] from a rotor displaced by x; with a shift of the
    /// rotor, those whose clearance may be below the limit after the shift.
    #[inline(always)]
    pub fn evaluate_near_blocks<V: Eight>(
        &mut self,
        ring: &RingPoints,
        (limit, shift): (f64, [f64; 2]),
        x: [f64; 2],
        q: &[Lane],
        blocks: &mut Vec<usize>,
    ) {
        let limit = limit + self.direction_spread * length(shift);
        self.find_near_blocks::<V>(limit, [x[0] + shift[0], x[1] + shift[1]], blocks);
        let mut count = 0;
        for at in 0..blocks.len() {
            let block = blocks[at];
            self.evaluate_clearances::<V>(ring, block, x, q);
            blocks[count] = block;
            count += usize::from(self.smallest[block] < limit + self.along_block_direction(block, shift));
        }
        blocks.truncate(count);
    }

    /// Product e.x of a block.
    #[inline(always)]
    fn along_block_direction(&self, block: usize, x: [f64; 2]) -> f64 {
        let ([cos, sin], k) = (&self.block_directions[block / BLOCK], block % BLOCK);
        cos.0[k] * x[0] + sin.0[k] * x[1]
    }

    /// Clearances of a block that was evaluated in this step \[m\].
    #[inline(always)]
    pub fn clearances(&self, block: usize) -> &Lane {
        &self.clearances[block]
    }

    /// Clearance of a point \[m\].
    #[inline(always)]
    pub(super) fn clearance<V: Eight>(&mut self, ring: &RingPoints, c: usize, x: [f64; 2], q: &[Lane]) -> f64 {
        self.evaluate_clearances::<V>(ring, c / BLOCK, x, q);
        self.clearances[c / BLOCK].0[c % BLOCK]
    }

    /// Evaluates the clearances of a block if that was not done in this step.
    #[inline(always)]
    fn evaluate_clearances<V: Eight>(&mut self, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) {
        if self.evaluated_at[block] != self.step {
            compute_clearances(self, ring, block, x, q);
        }
    }

    #[inline(always)]
    fn clearances_kernel<V: Eight>(&mut self, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) {
        self.evaluated_at[block] = self.step;
        let gap = self.radius - self.rotor_radius;
        let [cos, sin] = load_lanes::<V>(&ring.directions[block]);
        let radial = columns_times::<V>(ring.radial(block), q);
        let clearances = V::all(gap) + radial - (V::all(x[0]) * cos + V::all(x[1]) * sin);
        clearances.store(&mut self.clearances[block]);
        self.smallest[block] = clearances.least();
        self.clearance_bounds[block / BLOCK].0[block % BLOCK] =
            self.smallest[block] + self.along_block_direction(block, x) + self.travel;
    }

    /// Evaluates the gaps of a block if that was not done in this step.
    #[inline(always)]
    fn evaluate_gaps<V: Eight>(&mut self, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) {
        if self.gaps_evaluated_at[block] != self.step {
            compute_gaps(self, ring, block, x, q);
        }
    }

    #[inline(always)]
    fn gaps_kernel<V: Eight>(&mut self, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) {
        self.evaluate_clearances::<V>(ring, block, x, q);
        self.gaps_evaluated_at[block] = self.step;
        let [cos, sin] = load_lanes::<V>(&ring.directions[block]);
        let tangential = columns_times::<V>(ring.tangential(block), q);
        let rotor_radius = V::all(self.rotor_radius);
        let outwards = V::load(&self.clearances[block]) + rotor_radius;
        let across = tangential - (cos * V::all(x[1]) - sin * V::all(x[0]));
        tangential.store(&mut self.tangential[block]);
        ((outwards * outwards + across * across).root() - rotor_radius).store(&mut self.gaps[block]);
    }

    /// Gaps of a block after a displacement of the rotor and of the ring (radial, tangential), to first order in these \[m\].
    #[inline(always)]
    pub fn shifted_gaps<V: Eight>(
        &mut self,
        ring: &RingPoints,
        block: usize,
        (x, q): ([f64; 2], &[Lane]),
        rotor: [f64; 2],
        [radial, tangential]: [V; 2],
    ) -> V {
        self.evaluate_gaps::<V>(ring, block, x, q);
        let (clearances, ring_tangential) = (V::load(&self.clearances[block]), V::load(&self.tangential[block]));
        let gaps = V::load(&self.gaps[block]);
        let [cos, sin] = load_lanes::<V>(&ring.directions[block]);
        let ([x, y], [dx, dy], radius) = (broadcast(x), broadcast(rotor), V::all(self.rotor_radius));
        // vector from the rotor to the point, and the changes of both components
        let (outwards, across) = (clearances + radius, ring_tangential - (cos * y - sin * x));
        let outwards_change = radial + cos * dx + sin * dy;
        let across_change = tangential + cos * dy - sin * dx;
        gaps + (outwards * outwards_change + across * across_change) / (gaps + radius)
    }

    /// Selects, as bits, the points of a block beside which the gap may have a minimum with an offset ((1) of
    /// [`super::gap_minimum`]).
    #[inline(always)]
    pub fn has_offset_minimum<V: Eight>(
        &mut self,
        ring: &RingPoints,
        block: usize,
        points: u8,
        (x, q): ([f64; 2], &[Lane]),
    ) -> u8 {
        let (first, blocks) = (block * BLOCK, self.evaluated_at.len());
        let mut gap_of = [f64::INFINITY; 2];
        // at the ends of the block, the neighbour is in another one
        let [before, _] = ring.neighbours(first);
        let [_, next] = ring.neighbours(first + BLOCK - 1);
        for (side, (bit, c)) in [(1, before), (1 << (BLOCK - 1), next)].into_iter().enumerate() {
            if points & bit != 0 && blocks > 1 {
                self.evaluate_gaps::<V>(ring, c / BLOCK, x, q);
                gap_of[side] = self.gaps[c / BLOCK].0[c % BLOCK];
            }
        }
        self.evaluate_gaps::<V>(ring, block, x, q);
        let here = V::load(&self.gaps[block]);
        let (before, next) = (here.before(gap_of[0]), here.behind(gap_of[1]));
        let slope = V::all(0.5) * (next - before);
        let curvature = next - V::all(2.0) * here + before;
        points & V::all(0.0).less(curvature) & !(V::all(MAX_OFFSET) * curvature).less(slope.size())
    }
}

// Functions of their own: code that is called from many places is then only once in the instruction cache.
by_width! { fn compute_clearances(search: &mut BroadPhase, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) = compute_clearances_kernel }
by_width! { fn compute_gaps(search: &mut BroadPhase, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) = compute_gaps_kernel }

#[inline(always)]
fn compute_clearances_kernel<V: Eight>(
    search: &mut BroadPhase,
    ring: &RingPoints,
    block: usize,
    x: [f64; 2],
    q: &[Lane],
) {
    search.clearances_kernel::<V>(ring, block, x, q);
}

#[inline(always)]
fn compute_gaps_kernel<V: Eight>(search: &mut BroadPhase, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) {
    search.gaps_kernel::<V>(ring, block, x, q);
}

/// Bounds of blocks that were not evaluated yet: they exclude nothing.
fn unevaluated_bounds(blocks: usize) -> Vec<Lane> {
    let mut bounds = vec![f64::INFINITY; blocks.next_multiple_of(BLOCK)];
    bounds[..blocks].fill(f64::NEG_INFINITY);
    lanes_of(&bounds)
}

/// Cosines and sines of the directions e of a ring's blocks, and the largest |e_r - e|.
fn block_directions(ring: &RingPoints) -> (Vec<[Lane; 2]>, f64) {
    let (mut cos, mut sin, mut spread) = (Vec::new(), Vec::new(), 0.0_f64);
    for block in ring.angles.chunks_exact(BLOCK) {
        let (first, last) = (block[0], block[BLOCK - 1]);
        let (s, c) = (first.0 + last.0, first.1 + last.1);
        let whole = length([c, s]);
        cos.push(c / whole);
        sin.push(s / whole);
        spread =
            block.iter().fold(spread, |largest, &(sin, cos)| largest.max(length([cos - c / whole, sin - s / whole])));
    }
    for list in [&mut cos, &mut sin] {
        list.resize(list.len().next_multiple_of(BLOCK), 0.0);
    }
    (lanes_of(&cos).into_iter().zip(lanes_of(&sin)).map(|(cos, sin)| [cos, sin]).collect(), spread)
}

/// `sum_j |q_j - previous_j| reach_j`; previous becomes q.
#[inline(always)]
fn modal_travel<V: Eight>(previous: &mut [Lane], q: &[Lane], reach: &[Lane]) -> f64 {
    let mut sums = V::all(0.0);
    for ((previous, q), reach) in previous.iter_mut().zip(q).zip(reach) {
        let now = V::load(q);
        sums = sums + (now - V::load(previous)).size() * V::load(reach);
        now.store(previous);
    }
    sums.sum()
}

#[cfg(test)]
mod tests {
    use super::super::ring_points::ring_points;
    use super::*;
    use crate::eight::Plain;
    use crate::structure::Structure;
    use bladeoff_model::machine::MachineDef;
    use bladeoff_numerics::linalg::lanes::flat;

    #[test]
    fn no_candidate_in_reach_is_missed() {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let contact = &machine.diaphragms[0].contact;
        let ring = ring_points(&machine.diaphragms[0], &structure, 0, 5e-6);
        let modes = ring.radial(0).len();
        let mut broad_phase = BroadPhase::new(&ring, contact.rotor_radius + contact.gap, contact.rotor_radius);
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let (mut missing, mut touching, mut evaluated) = (0, 0, 0);
        let (mut x, mut q) = ([0.0; 2], vec![0.0; modes]);
        for round in 0..400 {
            // from a ring at rest to one that is bent by half the gap
            let size = 2e-6 * f64::from(round / 20);
            if round % 20 == 0 {
                let (angle, far) = (20.0 * random(), contact.gap * (0.7 + 1.2 * (random() + 0.5)));
                x = [far * libm::cos(angle), far * libm::sin(angle)];
                q = (0..modes).map(|j| size * random() / (1.0 + flat(&ring.radial_reach)[j])).collect();
            } else {
                // as far as in one step
                x = x.map(|part| part + 0.02 * contact.gap * random());
                (0..modes).for_each(|j| q[j] += 0.02 * size * random() / (1.0 + flat(&ring.radial_reach)[j]));
            }
            broad_phase.find_minima::<Plain>(&ring, x, &lanes_of(&q));
            evaluated += broad_phase
                .evaluated_at
                .iter()
                .filter(|compute_clearances_kernel| **compute_clearances_kernel == broad_phase.step)
                .count()
                * BLOCK;
            for c in 0..ring.count() {
                let v: f64 = flat(ring.rows(c)[0]).iter().zip(&q).map(|(row, q)| row * q).sum();
                let (sin, cos) = ring.angles[c];
                let clearance = contact.gap + v - (x[0] * cos + x[1] * sin);
                touching += usize::from(clearance < 0.0);
                let compute_clearances_kernel = broad_phase.evaluated_at[c / BLOCK] == broad_phase.step;
                let found = compute_clearances_kernel
                    && (broad_phase.clearances[c / BLOCK].0[c % BLOCK] - clearance).abs() < 1e-15;
                missing += usize::from(clearance < -1e-15 && !found);
            }
        }
        assert_eq!(missing, 0);
        assert!(touching > 1000, "some touch: {touching}");
        assert!(evaluated < 400 * ring.count() / 2, "most blocks are not evaluated: {evaluated}");
    }
}
