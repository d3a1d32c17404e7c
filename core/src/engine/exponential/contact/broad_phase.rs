//! Where a ring's candidates are near the rotor, and the places at which it is nearest.
//!
//! ```text
//! clearance       r_c = R_i + v_c - x.e_r - R_r <= g_c,   g_c - r_c = (x.e_t - u_c)^2/2R_i, nearly: 2 um 0.2 rad beside the least one of a turbine
//! later           r_c + e.x, with e the direction of its block's middle, is no less than it was, less the way since: sum over steps of
//!                 |e_r - e| |x+ - x| + sum_j |q_j+ - q_j| reach_j                                                                                    (1)
//! in reach        r_c < |x| d^2/8, the sagitta of what is between two candidates of a round ring
//! nearest place   xi = -(g_+ - g_-)/(2 (g_+ - 2 g_c + g_-)) spacings beyond a candidate c that has no nearer one beside it                          (2)
//! ```
//! Candidates are looked at by blocks, and a block again only when (1) says that one of its candidates may have come in reach. So most of the ring is not looked
//! at in most steps, and what is found is what a look at all of it would find. Displacements between candidates are those of a parabola. Limit: where the ring's modes bend it
//! inwards, what is between is nearer by (|x| + v'') d^2/8, so that a place may not be seen before it penetrates by v'' d^2/8 (below a micrometre on the turbine).
//! Conditions at the candidates alone would let the rotor nearer by up to `|x| d^2/8` between two of them, and have the force jump from one to the next (lab rig, 192
//! of them: 0.6 % of its bearing loads).
//! Verified by `no_candidate_in_reach_is_missed`, `tests/exponential_rub.rs`.

use super::ring_kernels::{broadcast, each_along, load_lanes};
use super::ring_points::{BLOCK, RingPoints, parabola};
use crate::engine::exponential::modal::displacement_bound::length;
use crate::linalg::eight::{Eight, by_width, columns_times};
use crate::linalg::lanes::{Lane, lanes_of};

/// A nearest place is no farther from its candidate, in spacings: half of one, and room for candidates that differ less in their clearances than in their gaps.
const FARTHEST: f64 = 0.75;

/// More than what e.x and what is added to it are rounded by: metres \[m\].
const ROUNDING: f64 = 1e-14;
/// Ways are summed with room for the rounding of their sum, and begun anew beyond this one \[m\].
const ROUNDED_UP: f64 = 1.0 + 1e-9;
const FORGETS: f64 = 0.1;

/// What is known of all candidates; those that are not near are looked at where they are asked for.
#[derive(Debug, Clone)]
pub(crate) struct BroadPhase {
    /// R_i and R_r \[m\].
    radius: f64,
    rotor_radius: f64,
    step: u64,
    /// By blocks: the step in which they were looked at, radial clearances, the least of these, and the same with e.x and `moved` of then added: (1), infinite behind the last.
    evaluated_at: Vec<u64>,
    clearances: Vec<Lane>,
    least: Vec<f64>,
    bounds: Vec<Lane>,
    /// By blocks: cos and sin of e; and the most of |e_r - e|.
    middles: Vec<[Lane; 2]>,
    apart: f64,
    /// The same of displacements along the ring, and of gaps.
    bounded_at: Vec<u64>,
    along: Vec<Lane>,
    gaps: Vec<Lane>,
    /// Amplitudes and place of the last look, and how far anything may have come to the rotor since the first.
    last: (Vec<Lane>, [f64; 2]),
    moved: f64,
    /// Room for blocks.
    due: Vec<usize>,
    /// Candidates in reach with no nearer one beside them, in their order.
    pub minima: Vec<usize>,
}

/// A place on the ring, its gap, and the unit vector to it from the rotor.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct GapMinimum {
    /// Nearest candidate, and how many spacings beyond it.
    pub index: usize,
    pub offset: f64,
    pub gap: f64,
    /// In the place's polar axes, and in the stator's.
    pub polar: [f64; 2],
    pub normal: [f64; 2],
}

impl BroadPhase {
    /// Of a ring's candidates on a radius R_i, about a rotor of radius R_r \[m\].
    pub fn new(ring: &RingPoints, radius: f64, rotor_radius: f64) -> Self {
        let blocks = ring.count() / BLOCK;
        let none = vec![Lane::default(); blocks];
        let (middles, apart) = middles(ring);
        Self {
            radius,
            rotor_radius,
            step: 0,
            evaluated_at: vec![0; blocks],
            clearances: none.clone(),
            least: vec![0.0; blocks],
            bounds: unknown_gaps(blocks),
            middles,
            apart,
            bounded_at: vec![0; blocks],
            along: none.clone(),
            gaps: none,
            last: (vec![Lane::default(); ring.radial_reach.len()], [0.0; 2]),
            moved: 0.0,
            due: Vec::with_capacity(blocks),
            minima: Vec::with_capacity(ring.count()),
        }
    }

    /// Looks at the candidates of a ring with amplitudes q from a rotor at x.
    #[inline(always)]
    pub fn find_minima<V: Eight>(&mut self, ring: &RingPoints, x: [f64; 2], q: &[Lane]) {
        self.step += 1;
        self.minima.clear();
        let (last, from) = &mut self.last;
        let way = way::<V>(last, q, &ring.radial_reach) + self.apart * length([x[0] - from[0], x[1] - from[1]]);
        *from = x;
        self.moved += way * ROUNDED_UP;
        if self.moved > FORGETS {
            self.moved = 0.0;
            self.bounds = unknown_gaps(self.evaluated_at.len());
        }
        let sagitta = ring.sagitta(x);
        let mut due = std::mem::take(&mut self.due);
        self.is_nearer::<V>(ring, (sagitta, [0.0; 2]), x, q, &mut due);
        for &block in &due {
            self.find_block_minima::<V>(ring, block, sagitta, x, q);
        }
        self.due = due;
    }

    /// Blocks of which a candidate may have less clearance than this from a rotor at x, by (1).
    #[inline(always)]
    fn find_due<V: Eight>(&self, than: f64, x: [f64; 2], due: &mut Vec<usize>) {
        due.clear();
        let (limit, [x, y]) = (V::all(than + self.moved + ROUNDING), broadcast::<V>(x));
        for (at, (lanes, middles)) in self.bounds.chunks(8).zip(self.middles.chunks(8)).enumerate() {
            let mut bits = 0_u64;
            for (i, (lane, middle)) in lanes.iter().zip(middles).enumerate() {
                let [cos, sin] = load_lanes::<V>(middle);
                bits |= u64::from(V::load(lane).less(limit + cos * x + sin * y)) << (8 * i);
            }
            while bits != 0 {
                due.push(64 * at + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        }
    }

    /// Adds those of a block.
    #[inline(always)]
    fn find_block_minima<V: Eight>(&mut self, ring: &RingPoints, block: usize, below: f64, x: [f64; 2], q: &[Lane]) {
        let (clearances, first) = (self.clearances[block].0, block * BLOCK);
        // open at the ends
        let here = V::load(&self.clearances[block]);
        let mut least =
            here.less(V::all(below)) & here.less(here.behind(f64::INFINITY)) & !here.before(f64::INFINITY).less(here);
        while least != 0 {
            let k = least.trailing_zeros() as usize;
            least &= least - 1;
            // at the end of a block, the next one's has a say
            let ([before, behind], here) = (ring.neighbours(first + k), clearances[k]);
            if (k == 0 && self.clearance::<V>(ring, before, x, q) < here)
                || (k + 1 == BLOCK && self.clearance::<V>(ring, behind, x, q) <= here)
            {
                continue;
            }
            self.minima.push(first + k);
        }
    }

    /// The blocks of which a candidate has less clearance than this from a rotor at x, looked at where they were not; with a shift of the rotor, those that may have less after it.
    #[inline(always)]
    pub fn is_nearer<V: Eight>(
        &mut self,
        ring: &RingPoints,
        (than, shift): (f64, [f64; 2]),
        x: [f64; 2],
        q: &[Lane],
        blocks: &mut Vec<usize>,
    ) {
        let than = than + self.apart * length(shift);
        self.find_due::<V>(than, [x[0] + shift[0], x[1] + shift[1]], blocks);
        let mut count = 0;
        for at in 0..blocks.len() {
            let block = blocks[at];
            self.evaluate_gaps::<V>(ring, block, x, q);
            blocks[count] = block;
            count += usize::from(self.least[block] < than + self.towards(block, shift));
        }
        blocks.truncate(count);
    }

    /// e.x of a block.
    #[inline(always)]
    fn towards(&self, block: usize, x: [f64; 2]) -> f64 {
        let ([cos, sin], k) = (&self.middles[block / BLOCK], block % BLOCK);
        cos.0[k] * x[0] + sin.0[k] * x[1]
    }

    /// Clearances of a block that has been looked at.
    #[inline(always)]
    pub fn clearances(&self, block: usize) -> &Lane {
        &self.clearances[block]
    }

    #[inline(always)]
    fn clearance<V: Eight>(&mut self, ring: &RingPoints, c: usize, x: [f64; 2], q: &[Lane]) -> f64 {
        self.evaluate_gaps::<V>(ring, c / BLOCK, x, q);
        self.clearances[c / BLOCK].0[c % BLOCK]
    }

    /// Looks at the clearances of a block where they were not.
    #[inline(always)]
    fn evaluate_gaps<V: Eight>(&mut self, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) {
        if self.evaluated_at[block] != self.step {
            see(self, ring, block, x, q);
        }
    }

    #[inline(always)]
    fn reevaluate_gaps<V: Eight>(&mut self, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) {
        self.evaluated_at[block] = self.step;
        let room = self.radius - self.rotor_radius;
        let [cos, sin] = load_lanes::<V>(&ring.directions[block]);
        let moved = columns_times::<V>(ring.radial(block), q);
        let found = V::all(room) + moved - (V::all(x[0]) * cos + V::all(x[1]) * sin);
        found.store(&mut self.clearances[block]);
        self.least[block] = found.least();
        self.bounds[block / BLOCK].0[block % BLOCK] = self.least[block] + self.towards(block, x) + self.moved;
    }

    /// Looks at the gaps of a block where they were not.
    #[inline(always)]
    fn evaluate_bounds<V: Eight>(&mut self, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) {
        if self.bounded_at[block] != self.step {
            sight(self, ring, block, x, q);
        }
    }

    #[inline(always)]
    fn reevaluate_bounds<V: Eight>(&mut self, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) {
        self.evaluate_gaps::<V>(ring, block, x, q);
        self.bounded_at[block] = self.step;
        let [cos, sin] = load_lanes::<V>(&ring.directions[block]);
        let moved = columns_times::<V>(ring.tangential(block), q);
        let rotor_radius = V::all(self.rotor_radius);
        let outwards = V::load(&self.clearances[block]) + rotor_radius;
        let across = moved - (cos * V::all(x[1]) - sin * V::all(x[0]));
        moved.store(&mut self.along[block]);
        ((outwards * outwards + across * across).root() - rotor_radius).store(&mut self.gaps[block]);
    }

    /// Gaps of a block, looked at from x with amplitudes q, after the rotor and its candidates have moved, these along their radii and along the ring: as far as
    /// gaps are linear in that.
    #[inline(always)]
    pub fn moved_gaps<V: Eight>(
        &mut self,
        ring: &RingPoints,
        block: usize,
        (x, q): ([f64; 2], &[Lane]),
        rotor: [f64; 2],
        [opens, goes]: [V; 2],
    ) -> V {
        self.evaluate_bounds::<V>(ring, block, x, q);
        let (clearances, along) = (V::load(&self.clearances[block]), V::load(&self.along[block]));
        let gaps = V::load(&self.gaps[block]);
        let [cos, sin] = load_lanes::<V>(&ring.directions[block]);
        let ([x, y], [dx, dy], radius) = (broadcast(x), broadcast(rotor), V::all(self.rotor_radius));
        // of the vector from the rotor to the candidate, and what changes along both parts
        let (one, other) = (clearances + radius, along - (cos * y - sin * x));
        let opened = opens + cos * dx + sin * dy;
        let turned = goes + cos * dy - sin * dx;
        gaps + (one * opened + other * turned) / (gaps + radius)
    }

    /// Those of some candidates of a block, by bits, about which a place between candidates may be nearest: (2) says that it is no farther.
    #[inline(always)]
    pub fn between<V: Eight>(&mut self, ring: &RingPoints, block: usize, of: u8, (x, q): ([f64; 2], &[Lane])) -> u8 {
        let (first, blocks) = (block * BLOCK, self.evaluated_at.len());
        let mut gap_of = [f64::INFINITY; 2];
        // at the ends of a block, the next one's have a say
        let [before, _] = ring.neighbours(first);
        let [_, behind] = ring.neighbours(first + BLOCK - 1);
        for (side, (bit, c)) in [(1, before), (1 << (BLOCK - 1), behind)].into_iter().enumerate() {
            if of & bit != 0 && blocks > 1 {
                self.evaluate_bounds::<V>(ring, c / BLOCK, x, q);
                gap_of[side] = self.gaps[c / BLOCK].0[c % BLOCK];
            }
        }
        self.evaluate_bounds::<V>(ring, block, x, q);
        let here = V::load(&self.gaps[block]);
        let (before, behind) = (here.before(gap_of[0]), here.behind(gap_of[1]));
        let slope = V::all(0.5) * (behind - before);
        let bend = behind - V::all(2.0) * here + before;
        of & V::all(0.0).less(bend) & !(V::all(FARTHEST) * bend).less(slope.size())
    }

    /// The place about a candidate that is nearest to the rotor; the candidate itself where it is not there.
    #[inline(always)]
    pub fn minimum_near(&mut self, ring: &RingPoints, c: usize, x: [f64; 2], q: &[Lane]) -> GapMinimum {
        place(self, ring, c, x, q)
    }

    #[inline(always)]
    fn place_in<V: Eight>(&mut self, ring: &RingPoints, c: usize, x: [f64; 2], q: &[Lane]) -> GapMinimum {
        let [before, behind] = ring.neighbours(c);
        let three = [before, c, behind];
        let tangential = each_along::<V, 3>([ring.of(before)[1], ring.of(c)[1], ring.of(behind)[1]], q);
        let [mut clearances, mut gaps] = [[0.0; 3]; 2];
        for i in 0..3 {
            clearances[i] = self.clearance::<V>(ring, three[i], x, q);
            let (sin, cos) = ring.angles[three[i]];
            let (outwards, across) = (clearances[i] + self.rotor_radius, tangential[i] - (cos * x[1] - sin * x[0]));
            gaps[i] = (outwards * outwards + across * across).sqrt() - self.rotor_radius;
        }
        let offset = parabola_offset(gaps);
        let weights = parabola(offset);
        let room = self.radius - self.rotor_radius;
        let (mut v, mut u) = (0.0, 0.0);
        for i in 0..3 {
            let (sin, cos) = ring.angles[three[i]];
            // v from its clearance
            v += weights[i] * (clearances[i] - room + (cos * x[0] + sin * x[1]));
            u += weights[i] * tangential[i];
        }
        // the direction of the place: a small turn from the candidate's
        let turn = offset * ring.spacing;
        let (tilt, square) = (turn * (1.0 - turn * turn / 6.0), turn * turn);
        let straight = 1.0 - 0.5 * square * (1.0 - square / 12.0);
        let (sin, cos) = ring.angles[c];
        let (sin, cos) = (sin * straight + cos * tilt, cos * straight - sin * tilt);
        let distance = [self.radius + v - (cos * x[0] + sin * x[1]), u - (cos * x[1] - sin * x[0])];
        let whole = length(distance);
        let polar = [distance[0] / whole, distance[1] / whole];
        let normal = [cos * polar[0] - sin * polar[1], sin * polar[0] + cos * polar[1]];
        GapMinimum { index: c, offset, gap: whole - self.rotor_radius, polar, normal }
    }
}

// Functions of their own: what is called from many places is once in the processor's store of instructions.
by_width! { fn see(survey: &mut BroadPhase, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) = seen }
by_width! { fn sight(survey: &mut BroadPhase, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) = sighted }
by_width! { fn place(survey: &mut BroadPhase, ring: &RingPoints, c: usize, x: [f64; 2], q: &[Lane]) -> GapMinimum = placed }

#[inline(always)]
fn seen<V: Eight>(survey: &mut BroadPhase, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) {
    survey.reevaluate_gaps::<V>(ring, block, x, q);
}

#[inline(always)]
fn sighted<V: Eight>(survey: &mut BroadPhase, ring: &RingPoints, block: usize, x: [f64; 2], q: &[Lane]) {
    survey.reevaluate_bounds::<V>(ring, block, x, q);
}

#[inline(always)]
fn placed<V: Eight>(survey: &mut BroadPhase, ring: &RingPoints, c: usize, x: [f64; 2], q: &[Lane]) -> GapMinimum {
    survey.place_in::<V>(ring, c, x, q)
}

/// Bounds of so many blocks that say nothing.
fn unknown_gaps(blocks: usize) -> Vec<Lane> {
    let mut least = vec![f64::INFINITY; blocks.next_multiple_of(BLOCK)];
    least[..blocks].fill(f64::NEG_INFINITY);
    lanes_of(&least)
}

/// Cosines and sines of the middles of a ring's blocks, and how far a candidate's direction is from its block's at most.
fn middles(ring: &RingPoints) -> (Vec<[Lane; 2]>, f64) {
    let (mut cos, mut sin, mut apart) = (Vec::new(), Vec::new(), 0.0_f64);
    for block in ring.angles.chunks_exact(BLOCK) {
        let (first, last) = (block[0], block[BLOCK - 1]);
        let (s, c) = (first.0 + last.0, first.1 + last.1);
        let whole = length([c, s]);
        cos.push(c / whole);
        sin.push(s / whole);
        apart = block.iter().fold(apart, |most, &(sin, cos)| most.max(length([cos - c / whole, sin - s / whole])));
    }
    for list in [&mut cos, &mut sin] {
        list.resize(list.len().next_multiple_of(BLOCK), 0.0);
    }
    (lanes_of(&cos).into_iter().zip(lanes_of(&sin)).map(|(cos, sin)| [cos, sin]).collect(), apart)
}

/// (2) of three gaps.
#[inline(always)]
fn parabola_offset([before, here, behind]: [f64; 3]) -> f64 {
    let (slope, bend) = (0.5 * (behind - before), behind - 2.0 * here + before);
    if bend > 0.0 && slope.abs() <= FARTHEST * bend { -slope / bend } else { 0.0 }
}

/// `sum_j |q_j - last_j| reach_j`; last becomes q.
#[inline(always)]
fn way<V: Eight>(last: &mut [Lane], q: &[Lane], reach: &[Lane]) -> f64 {
    let mut ways = V::all(0.0);
    for ((last, q), reach) in last.iter_mut().zip(q).zip(reach) {
        let now = V::load(q);
        ways = ways + (now - V::load(last)).size() * V::load(reach);
        now.store(last);
    }
    ways.sum()
}

#[cfg(test)]
mod tests {
    use super::super::ring_points::ring_points;
    use super::*;
    use crate::linalg::eight::Plain;
    use crate::linalg::lanes::flat;
    use crate::structure::Structure;
    use bladeoff_model::machine::MachineDef;

    #[test]
    fn no_candidate_in_reach_is_missed() {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let contact = &machine.diaphragms[0].contact;
        let ring = ring_points(&machine.diaphragms[0], &structure, 0, 5e-6).expect("has candidates");
        let modes = ring.radial(0).len();
        let mut survey = BroadPhase::new(&ring, contact.rotor_radius + contact.gap, contact.rotor_radius);
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let (mut missing, mut touching, mut looked) = (0, 0, 0);
        let (mut x, mut q) = ([0.0; 2], vec![0.0; modes]);
        for round in 0..400 {
            // from a ring at rest to one that is bent by half the gap
            let size = 2e-6 * f64::from(round / 20);
            if round % 20 == 0 {
                let (angle, far) = (20.0 * random(), contact.gap * (0.7 + 1.2 * (random() + 0.5)));
                x = [far * libm::cos(angle), far * libm::sin(angle)];
                q = (0..modes).map(|j| size * random() / (1.0 + flat(&ring.radial_reach)[j])).collect();
            } else {
                // as far as steps go
                x = x.map(|part| part + 0.02 * contact.gap * random());
                (0..modes).for_each(|j| q[j] += 0.02 * size * random() / (1.0 + flat(&ring.radial_reach)[j]));
            }
            survey.find_minima::<Plain>(&ring, x, &lanes_of(&q));
            looked += survey.evaluated_at.iter().filter(|seen| **seen == survey.step).count() * BLOCK;
            for c in 0..ring.count() {
                let v: f64 = flat(ring.of(c)[0]).iter().zip(&q).map(|(row, q)| row * q).sum();
                let (sin, cos) = ring.angles[c];
                let clearance = contact.gap + v - (x[0] * cos + x[1] * sin);
                touching += usize::from(clearance < 0.0);
                let seen = survey.evaluated_at[c / BLOCK] == survey.step;
                let found = seen && (survey.clearances[c / BLOCK].0[c % BLOCK] - clearance).abs() < 1e-15;
                missing += usize::from(clearance < -1e-15 && !found);
            }
        }
        assert_eq!(missing, 0);
        assert!(touching > 1000, "some touch: {touching}");
        assert!(looked < 400 * ring.count() / 2, "and not all are looked at: {looked}");
    }
}
