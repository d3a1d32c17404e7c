//! Search for the deepest penetration that the impulses of a step leave at ring points that are no contact points.
//!
//! ```text
//! g_c = g_c(predicted) + e.(v, u) + n.r      e, n: unit vector from the rotor to point c, in polar and in the stator's axes           (1)
//!                                            (v, u), r: response of ring and rotor to all impulses, less the predicted one
//! g   = the same at the gap minimum beside c                                                                                          (2)
//! ```
//! (1) is evaluated for eight points at a time, and equals (2) where the point is the minimum itself. (2) is evaluated for the
//! deepest point, for those that (1) has below it, and for those beside which the gap has a minimum between two points. Blocks
//! whose clearances along the radii stay open by bounds of the response, sagitta |x| d^2/8 included, are skipped. A gap
//! is never below its clearance; (1) is low by at most the square of the tangential response over 2R (picometres).
//!
//! Verified by `what_remains_is_the_least_of_all`, `whip_is_that_of_the_reduced_engine` (`tests/exponential/exponential_run.rs`).

use super::broad_phase::BroadPhase;
use super::contact_point::{ContactPoint, PressedPoint};
use super::contact_predictor::ContactPredictor;
use super::delassus_operator::DelassusOperator;
use super::ring_kernels::{broadcast, load_lanes, products_with, weighted_sum};
use super::ring_points::{BLOCK, RingPoints, TruncatedImpulse};
use crate::contact::complementarity::POINTS;
use crate::eight::{Eight, columns_times};
use crate::engine::exponential::plane::length;
use crate::engine::exponential::plane::product;
use bladeoff_numerics::linalg::lanes::Lane;

/// Bound of the rounding difference of (1) and (2) at the same position, for lengths of metres \[m\].
const ROUNDING: f64 = 1e-12;

/// Buffers of the search.
#[derive(Debug, Clone)]
pub(crate) struct PenetrationSearch {
    /// Blocks that the impulses may have closed, and the radial response of the ring's modes at their points \[m\].
    near_blocks: Vec<usize>,
    radial_response: Vec<Lane>,
    /// Radial response of the truncated modes in these blocks, and clearances with it and with the response of the rotor \[m\].
    truncated_radial: Vec<Lane>,
    clearances: Vec<Lane>,
    /// Bit for each point of a block that is a contact point or next to one.
    excluded: Vec<u8>,
    /// Points with impulses on the truncated modes, in polar axes \[N s\]: those of this step less a share of those of the last
    /// step.
    truncated_impulses: Vec<TruncatedImpulse>,
    /// Blocks with closed points.
    closed_blocks: Vec<ClosedBlock>,
}

/// Block with a closed point: gaps (1) of its closed points \[m\], infinite for the others.
#[derive(Debug, Clone, Copy)]
struct ClosedBlock {
    block: usize,
    gaps: Lane,
}

/// State of a step whose impulses are known.
pub(crate) struct AfterImpulses<'a> {
    pub ring_points: &'a RingPoints,
    pub points: &'a [ContactPoint],
    pub predictor: &'a ContactPredictor,
    pub operator: &'a DelassusOperator,
    /// Response of the ring's modes at n+1 to the impulses, less the predicted one.
    pub impulses: &'a [Lane],
    /// Predicted displacement of the rotor in the stator's axes \[m\].
    pub x: [f64; 2],
    /// Contact points of the last step.
    pub pressed: &'a [PressedPoint],
}

impl AfterImpulses<'_> {
    /// Contact points with an impulse.
    #[inline(always)]
    fn pressing(&self) -> impl Iterator<Item = &ContactPoint> {
        self.points.iter().filter(|point| point.force.normal > 0.0)
    }
}

impl PenetrationSearch {
    /// Creates the search for a ring with `count` points.
    pub fn new(count: usize) -> Self {
        let blocks = count / BLOCK;
        Self {
            near_blocks: Vec::with_capacity(blocks),
            radial_response: vec![Lane::default(); blocks],
            truncated_radial: vec![Lane::default(); blocks],
            clearances: vec![Lane::default(); blocks],
            excluded: vec![0; blocks],
            truncated_impulses: Vec::with_capacity(POINTS),
            closed_blocks: Vec::with_capacity(blocks),
        }
    }

    /// Smallest negative gap that is left and the index of its ring point; 0 and `None` where all gaps are open.
    #[inline(always)]
    pub fn closest_violated_point<V: Eight>(
        &mut self,
        broad_phase: &mut BroadPhase,
        state: &AfterImpulses<'_>,
    ) -> (f64, Option<usize>) {
        self.collect_impulses(state);
        let (deepest, margin) = self.find_closed_blocks::<V>(broad_phase, state);
        let mut first = None;
        if let Some((closed, k)) = deepest {
            let closed = &self.closed_blocks[closed];
            let index = closed.block * BLOCK + k;
            first = Some((index, gap_beside::<V>(broad_phase, state, index, self.radial_response[closed.block].0[k])));
        }
        let bound = first.map_or(0.0, |(_, gap)| gap.min(0.0));
        let mut smallest = (0.0, None);
        for closed in &self.closed_blocks {
            let gaps = V::load(&closed.gaps);
            let near = gaps.less(V::all(bound + margin));
            let may_be_deeper = !V::all(bound + ROUNDING).less(gaps);
            let offset = broad_phase.has_offset_minimum::<V>(
                state.ring_points,
                closed.block,
                near,
                (state.x, &state.predictor.ring),
            );
            let mut bits = near & (may_be_deeper | offset);
            while bits != 0 {
                let k = bits.trailing_zeros() as usize;
                bits &= bits - 1;
                let index = closed.block * BLOCK + k;
                let gap = match first {
                    Some((first, gap)) if first == index => gap,
                    _ => gap_beside::<V>(broad_phase, state, index, self.radial_response[closed.block].0[k]),
                };
                if gap < smallest.0 {
                    smallest = (gap, Some(index));
                }
            }
        }
        smallest
    }

    /// Collects the impulses on the truncated modes, and the points that are excluded from the search.
    #[inline(always)]
    fn collect_impulses(&mut self, state: &AfterImpulses<'_>) {
        self.excluded.fill(0);
        for point in state.points {
            let index = point.position.index;
            let [before, behind] = state.ring_points.neighbours(index);
            for c in [before, index, behind] {
                self.excluded[c / BLOCK] |= 1 << (c % BLOCK);
            }
        }
        self.truncated_impulses.clear();
        for ContactPoint { acting, force, .. } in state.pressing() {
            let [radial, tangential] = acting.polar;
            let impulse = [radial * force.normal, tangential * force.normal];
            self.truncated_impulses.push(state.ring_points.truncated_impulse(acting.index, impulse));
        }
        for PressedPoint { position, force, .. } in state.pressed {
            let [radial, tangential] = position.polar;
            let share = -state.ring_points.static_correction.previous_share() * force.normal;
            let impulse = [radial * share, tangential * share];
            match self.truncated_impulses.iter_mut().find(|point| point.index == position.index) {
                Some(point) => (0..2).for_each(|i| point.impulse[i] += impulse[i]),
                None => self.truncated_impulses.push(state.ring_points.truncated_impulse(position.index, impulse)),
            }
        }
    }

    /// Finds the blocks with closed points. Returns the position in `closed_blocks` and in its block of the point with the
    /// smallest negative (1), and a bound of the distance of (2) below (1).
    #[inline(always)]
    fn find_closed_blocks<V: Eight>(
        &mut self,
        broad_phase: &mut BroadPhase,
        state: &AfterImpulses<'_>,
    ) -> (Option<(usize, usize)>, f64) {
        let &AfterImpulses { ring_points, predictor, impulses, x, .. } = state;
        let q = &predictor.ring;
        // displacement of the rotor by all impulses
        let mut rotor = predictor.rotor_correction;
        for point in state.pressing() {
            let displacement =
                state.operator.rotor_displacement(&point.acting, point.force.normal, point.force.tangential);
            rotor = [rotor[0] + displacement[0], rotor[1] + displacement[1]];
        }
        // bounds of the response of the ring's modes and of its truncated modes
        let modal_bound = weighted_sum::<V>(impulses, &ring_points.radial_reach);
        let [closure_bound, truncated_bound] = ring_points.truncated_bounds(&self.truncated_impulses);
        let sagitta = ring_points.sagitta(x);
        let shift = [-rotor[0], -rotor[1]];
        broad_phase.evaluate_near_blocks::<V>(
            ring_points,
            (closure_bound + modal_bound + sagitta, shift),
            x,
            q,
            &mut self.near_blocks,
        );
        self.closed_blocks.clear();
        let rotor_vector = broadcast::<V>(rotor);
        // one pass for the clearances of all blocks, without branches between them
        let mut count = 0;
        for at in 0..self.near_blocks.len() {
            let block = self.near_blocks[at];
            let [cos, sin] = load_lanes::<V>(&ring_points.directions[block]);
            let truncated = ring_points.block_truncated_response::<V>(block, &self.truncated_impulses, 0);
            let clearances =
                V::load(broad_phase.clearances(block)) + rotor_vector[0] * cos + rotor_vector[1] * sin + truncated;
            truncated.store(&mut self.truncated_radial[block]);
            clearances.store(&mut self.clearances[block]);
            self.near_blocks[count] = block;
            count += usize::from(clearances.less(V::all(modal_bound + sagitta)) & !self.excluded[block] != 0);
        }
        self.near_blocks.truncate(count);
        let (mut deepest, mut deepest_gap) = (None, 0.0);
        for &block in &self.near_blocks {
            let (truncated, clearances) = (V::load(&self.truncated_radial[block]), V::load(&self.clearances[block]));
            let radial_response = columns_times::<V>(ring_points.radial(block), impulses);
            let near = (clearances + radial_response).less(V::all(sagitta)) & !self.excluded[block];
            if near == 0 {
                continue;
            }
            radial_response.store(&mut self.radial_response[block]);
            let truncated_tangential = ring_points.block_truncated_response::<V>(block, &self.truncated_impulses, 1);
            let tangential_response = columns_times::<V>(ring_points.tangential(block), impulses);
            let response = [radial_response + truncated, tangential_response + truncated_tangential];
            let mut gaps = Lane::default();
            broad_phase.shifted_gaps(ring_points, block, (x, q), rotor, response).store(&mut gaps);
            for (k, gap) in gaps.0.iter_mut().enumerate() {
                if near >> k & 1 == 0 {
                    *gap = f64::INFINITY;
                } else if *gap < deepest_gap {
                    (deepest, deepest_gap) = (Some((self.closed_blocks.len(), k)), *gap);
                }
            }
            self.closed_blocks.push(ClosedBlock { block, gaps });
        }
        if self.closed_blocks.is_empty() {
            return (None, 0.0);
        }
        let ring_bound = weighted_sum::<V>(q, &ring_points.radial_reach);
        let margin = ring_points.spacing * (length(x) + length(rotor) + truncated_bound + modal_bound)
            + 2.0 * ring_bound
            + ROUNDING;
        (deepest, margin)
    }
}

/// Gap (2) at the minimum beside a point with this radial response of the ring's modes \[m\].
#[inline(always)]
fn gap_beside<V: Eight>(
    broad_phase: &mut BroadPhase,
    state: &AfterImpulses<'_>,
    index: usize,
    radial_response: f64,
) -> f64 {
    let &AfterImpulses { ring_points, predictor, operator, .. } = state;
    let position = broad_phase.minimum_near(ring_points, index, state.x, &predictor.ring);
    let [tangential_response] = products_with::<V, 1>([ring_points.rows(index)[1]], state.impulses);
    let mut gap = position.gap
        + product(position.polar, [radial_response, tangential_response])
        + product(position.normal, predictor.rotor_correction)
        - DelassusOperator::previous_truncated_response(ring_points, &position, state.pressed);
    for point in state.pressing() {
        let [n, t] = operator.truncated_response(ring_points, &position, &point.acting);
        gap += n * point.force.normal + t * point.force.tangential;
    }
    gap
}

#[cfg(test)]
mod tests {
    use super::super::impulsed_ring::ImpulsedRing;
    use super::super::ring_points::{are_adjacent, modal_parameters, ring_points};
    use super::*;
    use crate::contact::ContactReaction;
    use crate::eight::Plain;
    use crate::engine::exponential::modal::impulse_response::ImpulseResponse;
    use crate::engine::exponential::plane::across;
    use crate::structure::Structure;
    use bladeoff_model::machine::MachineDef;
    use bladeoff_numerics::linalg::lanes::{LANES, flat, lanes_of};

    /// Smallest (2) of all points that are neither a contact point nor next to one.
    fn smallest_of_all(broad_phase: &mut BroadPhase, state: &AfterImpulses<'_>) -> (f64, Option<usize>) {
        let (ring, mut least) = (state.ring_points, (0.0, None));
        for index in 0..ring.count() {
            if state.points.iter().any(|point| are_adjacent(point.position.index, index, ring.count())) {
                continue;
            }
            let [opens] = products_with::<Plain, 1>([ring.rows(index)[0]], state.impulses);
            let gap = gap_beside::<Plain>(broad_phase, state, index, opens);
            if gap < least.0 {
                least = (gap, Some(index));
            }
        }
        least
    }

    #[test]
    fn what_remains_is_the_least_of_all() {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let contact = &machine.diaphragms[0].contact;
        let h = 5e-6;
        let ring = ring_points(&machine.diaphragms[0], &structure, 0, h);
        let impulsed_ring = ImpulsedRing::new(&modal_parameters(structure.rings[0].as_ref()), h);
        let [compliance, static_correction] = impulsed_ring.compliance();
        let response = ImpulseResponse {
            states: Default::default(),
            outputs: Default::default(),
            displacement: [[3e-6, 1e-7], [-1e-7, 2e-6]],
            static_correction: [[0.0; 2]; 2],
            velocity_jump: [[0.0; 2]; 2],
            at_unbalances: Vec::new(),
            of_unbalances: Vec::new(),
            at_diaphragms: Vec::new(),
            loads: Vec::new(),
        };
        let operator = DelassusOperator::new((0.0, 1.0), [[1e-8, 0.0], [0.0, 1e-8]], &response, 1e-7);
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut broad_phase = BroadPhase::new(&ring, contact.rotor_radius + contact.gap, contact.rotor_radius);
        let mut search = PenetrationSearch::new(ring.count());
        let mut predictor = ContactPredictor::new([compliance.clone(), static_correction]);
        const ROUNDS: u32 = 3000;
        let (mut closed, mut offset, mut grazed, mut evaluated) = (0, 0, 0, 0);
        for round in 0..ROUNDS {
            // in one round of five the gap is negative between two points only
            let grazes = round % 5 == 4;
            let (angle, depth) = (20.0 * random(), random() + 0.5);
            let far = contact.gap + depth * if grazes { ring.sagitta([contact.gap, 0.0]) } else { 4.0 * contact.gap };
            let x = [far * libm::cos(angle), far * libm::sin(angle)];
            // random amplitudes of the ring, in some rounds lobes as large as the gap
            let mut bent = vec![0.0; LANES * compliance.len()];
            for (j, (q, reach)) in bent.iter_mut().zip(flat(&ring.radial_reach)).enumerate() {
                let lobe = round % 16 >= 12 && j < 6;
                let size = if round % 8 < 4 { 2e-5 } else { 1e-6 };
                *q = random() * if lobe { 2.0 * contact.gap / reach } else { size / (1.0 + reach) };
                if grazes {
                    *q = 0.0;
                }
            }
            predictor.ring = lanes_of(&bent);
            let size = if grazes { 1e-10 } else { 1e-5 };
            predictor.rotor_correction = [size * random(), size * random()];
            broad_phase.find_minima::<Plain>(&ring, x, &predictor.ring);
            // three contact points, one of them perhaps the minimum, with impulses that may open the gap
            let mut points = Vec::new();
            let mut impulses = vec![0.0; LANES * compliance.len()];
            for turn in [0.1 * f64::from(round % 2), 0.25, -0.35] {
                let index =
                    (((angle + turn) / ring.spacing).rem_euclid(ring.count() as f64) as usize).min(ring.count() - 1);
                let position = broad_phase.minimum_near(&ring, index, x, &predictor.ring);
                let hardness = if grazes { 1e-3 } else { [1e5, 1e3, 1e1][round as usize / 2 % 3] };
                let size = (far - contact.gap) * hardness * (random() + 0.5);
                let force = ContactReaction { normal: size, tangential: 0.2 * size * random(), sticks: false };
                let sides = [position.polar, across(position.polar)];
                for (j, impulse) in impulses.iter_mut().enumerate() {
                    let shape = ring.rows(index).map(|row| flat(row)[j]);
                    let by = sides.map(|side| product(side, shape));
                    *impulse += flat(&compliance)[j] * (force.normal * by[0] + force.tangential * by[1]);
                }
                points.push(ContactPoint {
                    position,
                    acting: position,
                    acting_slot: None,
                    slot: 0,
                    self_coupling: Default::default(),
                    free: [0.0; 2],
                    force,
                });
            }
            let impulses = lanes_of(&impulses);
            // points of the step before
            let pressed: Vec<PressedPoint> = points
                .iter()
                .take(round as usize % 3)
                .map(|point: &ContactPoint| PressedPoint { position: point.position, force: point.force, slot: 0 })
                .collect();
            let state = AfterImpulses {
                ring_points: &ring,
                points: &points,
                predictor: &predictor,
                operator: &operator,
                impulses: &impulses,
                x,
                pressed: &pressed,
            };
            let found = search.closest_violated_point::<Plain>(&mut broad_phase, &state);
            evaluated += search.closed_blocks.len();
            let expected = smallest_of_all(&mut broad_phase, &state);
            // a minimum in the middle between two points is found from both, by different parabolas
            let tolerance = match (found.1, expected.1) {
                (Some(one), Some(other)) if grazes && one != other => {
                    assert!(are_adjacent(one, other, ring.count()), "{found:?} {expected:?}");
                    1e-3 * ring.sagitta(x)
                }
                (one, other) => {
                    assert_eq!(one, other, "{found:?} {expected:?}");
                    1e-15
                }
            };
            assert!((found.0 - expected.0).abs() < tolerance, "{found:?} {expected:?}");
            if let Some(index) = expected.1 {
                closed += 1;
                offset += usize::from(broad_phase.minimum_near(&ring, index, x, &predictor.ring).offset != 0.0);
                let clearance = broad_phase.clearances(index / BLOCK).0[index % BLOCK];
                grazed += usize::from(clearance > 0.0);
            }
        }
        assert!(closed > 100, "some gaps stay closed: {closed}");
        assert!(offset > 10, "some between two points: {offset}");
        assert!(grazed > 10, "some between two open points: {grazed}");
        assert!(
            evaluated < ROUNDS as usize * ring.count() / BLOCK * 3 / 4,
            "not all blocks are evaluated: {evaluated}"
        );
    }
}
