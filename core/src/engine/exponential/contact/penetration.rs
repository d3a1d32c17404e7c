//! The least gap that impulses leave among the candidates that took no part in them.
//!
//! ```text
//! g_c = g_c(free) + e.(v, u) + n.r          e, n: from the rotor to the candidate, polar and in the stator's axes                                        (1)
//!                                           (v, u), r: moved by all impulses, of the ring's modes, of its modes left out, of the rotor
//! g   = the same at the nearest place about a candidate                                                                                                  (2)
//! ```
//! (1) is taken for eight candidates at a time, and is (2) where the candidate is the nearest place itself. So (2) is taken of the least one, of those that are less by (1) than
//! that is, and of those about which a place is nearer than they are. What is left out before: blocks whose clearances along their radii stay open, by bounds of what moves them and by the
//! sagitta |x| d^2/8 of what is between two candidates. No gap is less than the clearance, (1) at most by the square of a way along the ring over 2R: picometres.
//! Verified by `what_remains_is_the_least_of_all`, `whip_is_that_of_the_reduced_engine` (`tests/exponential_run.rs`).

use super::broad_phase::BroadPhase;
use super::contact_point::{ContactPoint, PressedPoint};
use super::contact_predictor::ContactPredictor;
use super::delassus_operator::DelassusOperator;
use super::ring_kernels::{broadcast, each_along, load_lanes, weighted};
use super::ring_points::{BLOCK, RingPoints};
use crate::contact::complementarity::POINTS;
use crate::engine::exponential::modal::displacement_bound::length;
use crate::engine::exponential::plane::product;
use crate::linalg::eight::{Eight, columns_times};
use crate::linalg::lanes::Lane;

/// More than what (1) and (2) of a candidate that is the nearest place itself differ by: rounding of lengths of metres \[m\].
const ROUNDING: f64 = 1e-12;

/// Room for what is looked at.
#[derive(Debug, Clone)]
pub(crate) struct PenetrationSearch {
    /// Blocks that impulses may have brought in reach, and what the ring's modes move along the radii of their candidates.
    near: Vec<usize>,
    opens: Vec<Lane>,
    /// Of those blocks, what the modes left out move along the radii, and the clearances with that and the rotor's.
    outwards: Vec<Lane>,
    after: Vec<Lane>,
    /// By blocks: a bit for each candidate that is a point, or beside one; and the blocks with such bits.
    barred: Vec<u8>,
    taken: Vec<usize>,
    /// Candidates where impulses act, and these in polar axes, less a share of those of the step before.
    pressing: Vec<(usize, [f64; 2])>,
    closed: Vec<ClosedBlock>,
}

/// A block about which a place may be closed: (1), infinite for candidates of which none is.
#[derive(Debug, Clone, Copy)]
struct ClosedBlock {
    block: usize,
    gaps: Lane,
}

/// What impulses do.
pub(crate) struct AfterImpulses<'a> {
    pub candidates: &'a RingPoints,
    pub points: &'a [ContactPoint],
    pub foreseen: &'a ContactPredictor,
    pub moved: &'a DelassusOperator,
    /// What they make of the ring's modes.
    pub impulses: &'a [Lane],
    /// The rotor as it is foreseen, in the stator's axes.
    pub x: [f64; 2],
    /// Of the step before.
    pub pressed: &'a [PressedPoint],
}

impl AfterImpulses<'_> {
    #[inline(always)]
    fn pressing(&self) -> impl Iterator<Item = &ContactPoint> {
        self.points.iter().filter(|point| point.force.normal > 0.0)
    }
}

impl PenetrationSearch {
    /// Of a ring with so many candidates.
    pub fn new(count: usize) -> Self {
        let blocks = count / BLOCK;
        Self {
            near: Vec::with_capacity(blocks),
            opens: vec![Lane::default(); blocks],
            outwards: vec![Lane::default(); blocks],
            after: vec![Lane::default(); blocks],
            barred: vec![0; blocks],
            taken: Vec::with_capacity(3 * POINTS),
            pressing: Vec::with_capacity(POINTS),
            closed: Vec::with_capacity(blocks),
        }
    }

    /// The least gap below zero that is left, and of which candidate.
    #[inline(always)]
    pub fn closest_violated_point<V: Eight>(
        &mut self,
        survey: &mut BroadPhase,
        struck: &AfterImpulses<'_>,
    ) -> (f64, Option<usize>) {
        self.collect(struck);
        let (lowest, room) = self.scan::<V>(survey, struck);
        let mut first = None;
        if let Some((closed, k)) = lowest {
            let closed = &self.closed[closed];
            let index = closed.block * BLOCK + k;
            first = Some((index, gap_left::<V>(survey, struck, index, self.opens[closed.block].0[k])));
        }
        let bound = first.map_or(0.0, |(_, gap)| gap.min(0.0));
        let mut least = (0.0, None);
        for closed in &self.closed {
            let gaps = V::load(&closed.gaps);
            let near = gaps.less(V::all(bound + room));
            let no_more = !V::all(bound + ROUNDING).less(gaps);
            let between = survey.between::<V>(struck.candidates, closed.block, near, (struck.x, &struck.foreseen.ring));
            let mut bits = near & (no_more | between);
            while bits != 0 {
                let k = bits.trailing_zeros() as usize;
                bits &= bits - 1;
                let index = closed.block * BLOCK + k;
                let gap = match first {
                    Some((first, gap)) if first == index => gap,
                    _ => gap_left::<V>(survey, struck, index, self.opens[closed.block].0[k]),
                };
                if gap < least.0 {
                    least = (gap, Some(index));
                }
            }
        }
        least
    }

    /// What presses, and what takes part.
    #[inline(always)]
    fn collect(&mut self, struck: &AfterImpulses<'_>) {
        for &block in &self.taken {
            self.barred[block] = 0;
        }
        self.taken.clear();
        for point in struck.points {
            let index = point.position.index;
            let [before, behind] = struck.candidates.neighbours(index);
            for c in [before, index, behind] {
                self.barred[c / BLOCK] |= 1 << (c % BLOCK);
                self.taken.push(c / BLOCK);
            }
        }
        self.pressing.clear();
        for ContactPoint { acting, force, .. } in struck.pressing() {
            let [along, aside] = acting.polar;
            self.pressing.push((acting.index, [along * force.normal, aside * force.normal]));
        }
        for PressedPoint { position, force, .. } in struck.pressed {
            let [along, aside] = position.polar;
            let less = -struck.candidates.static_correction.previous_share() * force.normal;
            let less = [along * less, aside * less];
            match self.pressing.iter_mut().find(|(index, _)| *index == position.index) {
                Some((_, impulse)) => *impulse = [impulse[0] + less[0], impulse[1] + less[1]],
                None => self.pressing.push((position.index, less)),
            }
        }
    }

    /// Finds the blocks about which something may be closed; which of them has the least (1), where that is below zero, and of which candidate; and more than what
    /// a place about a candidate may be nearer.
    #[inline(always)]
    fn scan<V: Eight>(&mut self, survey: &mut BroadPhase, struck: &AfterImpulses<'_>) -> (Option<(usize, usize)>, f64) {
        let &AfterImpulses { candidates, foreseen, impulses, x, .. } = struck;
        let q = &foreseen.ring;
        // what moves the rotor: the sum of all
        let mut rotor = foreseen.rotor_correction;
        for point in struck.pressing() {
            let moves = struck.moved.rotor_displacement(&point.acting, point.force.normal, point.force.tangential);
            rotor = [rotor[0] + moves[0], rotor[1] + moves[1]];
        }
        // what the ring's modes do at most, and those left out
        let most = weighted::<V>(impulses, &candidates.radial_reach);
        let [left_out, all_left_out] = candidates.most_left_out(&self.pressing);
        let sagitta = candidates.sagitta(x);
        let shift = [-rotor[0], -rotor[1]];
        survey.is_nearer::<V>(candidates, (left_out + most + sagitta, shift), x, q, &mut self.near);
        self.closed.clear();
        let moves = broadcast::<V>(rotor);
        // nothing is decided by one block before the next is looked at
        let mut count = 0;
        for at in 0..self.near.len() {
            let block = self.near[at];
            let [cos, sin] = load_lanes::<V>(&candidates.directions[block]);
            let outwards = candidates.all_left_out::<V>(block, &self.pressing, 0);
            let after = V::load(survey.clearances(block)) + moves[0] * cos + moves[1] * sin + outwards;
            outwards.store(&mut self.outwards[block]);
            after.store(&mut self.after[block]);
            self.near[count] = block;
            count += usize::from(after.less(V::all(most + sagitta)) & !self.barred[block] != 0);
        }
        self.near.truncate(count);
        let (mut lowest, mut deepest) = (None, 0.0);
        for &block in &self.near {
            let (outwards, after) = (V::load(&self.outwards[block]), V::load(&self.after[block]));
            let opens = columns_times::<V>(candidates.radial(block), impulses);
            let near = (after + opens).less(V::all(sagitta)) & !self.barred[block];
            if near == 0 {
                continue;
            }
            opens.store(&mut self.opens[block]);
            let aside = candidates.all_left_out::<V>(block, &self.pressing, 1);
            let goes = columns_times::<V>(candidates.tangential(block), impulses);
            let moved = [opens + outwards, goes + aside];
            let mut gaps = Lane::default();
            survey.moved_gaps(candidates, block, (x, q), rotor, moved).store(&mut gaps);
            for (k, gap) in gaps.0.iter_mut().enumerate() {
                if near >> k & 1 == 0 {
                    *gap = f64::INFINITY;
                } else if *gap < deepest {
                    (lowest, deepest) = (Some((self.closed.len(), k)), *gap);
                }
            }
            self.closed.push(ClosedBlock { block, gaps });
        }
        if self.closed.is_empty() {
            return (None, 0.0);
        }
        let bent = weighted::<V>(q, &candidates.radial_reach);
        let room = candidates.spacing * (length(x) + length(rotor) + all_left_out + most) + 2.0 * bent + ROUNDING;
        (lowest, room)
    }
}

/// (2) of a candidate whose radius the ring's modes open so much.
#[inline(always)]
fn gap_left<V: Eight>(survey: &mut BroadPhase, struck: &AfterImpulses<'_>, index: usize, opens: f64) -> f64 {
    let &AfterImpulses { candidates, foreseen, moved, .. } = struck;
    let position = survey.minimum_near(candidates, index, struck.x, &foreseen.ring);
    let [along] = each_along::<V, 1>([candidates.of(index)[1]], struck.impulses);
    let mut gap =
        position.gap + product(position.polar, [opens, along]) + product(position.normal, foreseen.rotor_correction)
            - DelassusOperator::previous_truncated_response(candidates, &position, struck.pressed);
    for point in struck.pressing() {
        let [n, t] = moved.truncated_response(candidates, &position, &point.acting);
        gap += n * point.force.normal + t * point.force.tangential;
    }
    gap
}

#[cfg(test)]
mod tests {
    use super::super::impulsed_ring::ImpulsedRing;
    use super::super::ring_points::{beside, modes, ring_of, ring_points};
    use super::*;
    use crate::contact::ContactForce;
    use crate::engine::exponential::modal::impulse_response::ImpulseResponse;
    use crate::engine::exponential::plane::{across, by_rows};
    use crate::linalg::eight::Plain;
    use crate::linalg::lanes::{LANES, flat, lanes_of};
    use crate::structure::Structure;
    use bladeoff_model::machine::{ContactSurface, MachineDef};

    /// (2) of every candidate that is neither a point nor beside one.
    fn of_all(survey: &mut BroadPhase, struck: &AfterImpulses<'_>) -> (f64, Option<usize>) {
        let (ring, mut least) = (struck.candidates, (0.0, None));
        for index in 0..ring.count() {
            if struck.points.iter().any(|point| beside(point.position.index, index, ring.count())) {
                continue;
            }
            let [opens] = each_along::<Plain, 1>([ring.of(index)[0]], struck.impulses);
            let gap = gap_left::<Plain>(survey, struck, index, opens);
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
        let ring = ring_points(&machine.diaphragms[0], &structure, 0, h).expect("has candidates");
        let kicked = ImpulsedRing::new(&modes(ring_of(&structure, 0).expect("a ring")), h);
        let [yields, lacking] = kicked.compliance();
        let kick = ImpulseResponse {
            states: Default::default(),
            outputs: Default::default(),
            displacement: [[3e-6, 1e-7], [-1e-7, 2e-6]],
            static_correction: [[0.0; 2]; 2],
            velocity_jump: [[0.0; 2]; 2],
            at_unbalances: Vec::new(),
            of_unbalances: Vec::new(),
            loads: Vec::new(),
        };
        let moved = DelassusOperator::new((0.0, 1.0), [[1e-8, 0.0], [0.0, 1e-8]], &kick, 1e-7);
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut survey = BroadPhase::new(&ring, contact.rotor_radius + contact.gap, contact.rotor_radius);
        let mut remaining = PenetrationSearch::new(ring.count());
        let mut foreseen = ContactPredictor::new([yields.clone(), lacking]);
        const ROUNDS: u32 = 3000;
        let (mut closed, mut between, mut grazed, mut looked) = (0, 0, 0, 0);
        for round in 0..ROUNDS {
            // in one round of five the rotor comes nearer between two candidates than it is to any, and little else is
            let grazes = round % 5 == 4;
            let (angle, deep) = (20.0 * random(), random() + 0.5);
            let far = contact.gap + deep * if grazes { ring.sagitta([contact.gap, 0.0]) } else { 4.0 * contact.gap };
            let x = [far * libm::cos(angle), far * libm::sin(angle)];
            // bent in all ways, and in two or more lobes as deep as the rotor is far
            let mut bent = vec![0.0; LANES * yields.len()];
            for (j, (q, reach)) in bent.iter_mut().zip(flat(&ring.radial_reach)).enumerate() {
                let lobe = round % 16 >= 12 && j < 6;
                let size = if round % 8 < 4 { 2e-5 } else { 1e-6 };
                *q = random() * if lobe { 2.0 * contact.gap / reach } else { size / (1.0 + reach) };
                if grazes {
                    *q = 0.0;
                }
            }
            foreseen.ring = lanes_of(&bent);
            let undone = if grazes { 1e-10 } else { 1e-5 };
            foreseen.rotor_correction = [undone * random(), undone * random()];
            survey.find_minima::<Plain>(&ring, x, &foreseen.ring);
            // three places, of which one may be the nearest, and what may hold them open
            let mut points = Vec::new();
            let mut impulses = vec![0.0; LANES * yields.len()];
            for turn in [0.1 * f64::from(round % 2), 0.25, -0.35] {
                let index =
                    (((angle + turn) / ring.spacing).rem_euclid(ring.count() as f64) as usize).min(ring.count() - 1);
                let position = survey.minimum_near(&ring, index, x, &foreseen.ring);
                let hard = if grazes { 1e-3 } else { [1e5, 1e3, 1e1][round as usize / 2 % 3] };
                let size = (far - contact.gap) * hard * (random() + 0.5);
                let force = ContactForce { normal: size, tangential: 0.2 * size * random(), sticks: false };
                let sides = [position.polar, across(position.polar)];
                for (j, impulse) in impulses.iter_mut().enumerate() {
                    let shape = ring.of(index).map(|row| flat(row)[j]);
                    let by = sides.map(|side| product(side, shape));
                    *impulse += flat(&yields)[j] * (force.normal * by[0] + force.tangential * by[1]);
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
            // what pressed a step before, somewhat beside, and some that has left
            let pressed: Vec<PressedPoint> = points
                .iter()
                .take(round as usize % 3)
                .map(|point: &ContactPoint| PressedPoint { position: point.position, force: point.force, slot: 0 })
                .collect();
            let struck = AfterImpulses {
                candidates: &ring,
                points: &points,
                foreseen: &foreseen,
                moved: &moved,
                impulses: &impulses,
                x,
                pressed: &pressed,
            };
            let found = remaining.closest_violated_point::<Plain>(&mut survey, &struck);
            looked += remaining.closed.len();
            let whole = of_all(&mut survey, &struck);
            // of one place in the middle between two candidates both know, by parabolas of their own
            let same = match (found.1, whole.1) {
                (Some(one), Some(other)) if grazes && one != other => {
                    assert!(beside(one, other, ring.count()), "{found:?} {whole:?}");
                    1e-3 * ring.sagitta(x)
                }
                (one, other) => {
                    assert_eq!(one, other, "{found:?} {whole:?}");
                    1e-15
                }
            };
            assert!((found.0 - whole.0).abs() < same, "{found:?} {whole:?}");
            if let Some(index) = whole.1 {
                closed += 1;
                between += usize::from(survey.minimum_near(&ring, index, x, &foreseen.ring).offset != 0.0);
                let clearance = survey.clearances(index / BLOCK).0[index % BLOCK];
                grazed += usize::from(clearance > 0.0);
            }
        }
        assert!(closed > 100, "something is left closed: {closed}");
        assert!(between > 10, "and also at a place between candidates: {between}");
        assert!(grazed > 10, "and also between two that stay open: {grazed}");
        assert!(looked < ROUNDS as usize * ring.count() / BLOCK * 3 / 4, "not all are looked at: {looked}");
    }

    #[test]
    fn what_is_left_out_is_that_of_each_candidate() {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let ring = ring_points(&machine.diaphragms[0], &structure, 0, 5e-6).expect("has candidates");
        // a table of one sector, and one of all candidates
        let (part, contact) = (ring_of(&structure, 0).expect("a ring"), &machine.diaphragms[0].contact);
        let inner = contact.surface == ContactSurface::InnerFace;
        let surface = part.matrices.surface(contact.rotor_radius + contact.gap, inner);
        let whole = RingPoints::new(part, &surface, ring.count() / surface.nodes, 1, ring.static_correction);
        assert_eq!([ring.sectors(), whole.sectors()], [8, 1]);
        let acting = [(7, [3.0, -1.0]), (120, [0.5, 2.0]), (ring.count() - 3, [-1.0, 0.5])];
        let (mut largest, mut off) = (0.0_f64, 0.0_f64);
        for block in 0..ring.count() / BLOCK {
            let mut all = [Lane::default(); 2];
            all.iter_mut()
                .enumerate()
                .for_each(|(part, lane)| ring.all_left_out::<Plain>(block, &acting, part).store(lane));
            for k in 0..BLOCK {
                let mut wanted = [0.0; 2];
                for (at, impulse) in acting {
                    let by = by_rows(&whole.left_out(block * BLOCK + k, at), impulse);
                    wanted = [0, 1].map(|i| wanted[i] + by[i]);
                }
                largest = largest.max(wanted[0].abs());
                off = (0..2).fold(off, |most, i| most.max((all[i].0[k] - wanted[i]).abs()));
            }
        }
        assert!(largest > 0.0, "modes are left out");
        // sectors are alike to the rounding of the ring's modes
        assert!(off < 1e-9 * largest, "{off:e} of {largest:e}");
    }
}
