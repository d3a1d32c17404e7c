//! Where a ring's candidates are near the rotor, and the places at which it is nearest.
//!
//! ```text
//! clearance       r_c = R_i + v_c - x.e_r - R_r <= g_c,   g_c - r_c = (x.e_t - u_c)^2/2R_i, nearly: 2 um 0.2 rad beside the least one of a turbine
//! later           r_c is no less than it was, less the way since: sum over steps of  |x+ - x| + sum_j |q_j+ - q_j| reach_j                  (1)
//! in reach        r_c < |x| d^2/8, the sagitta of what is between two candidates
//! nearest place   xi = -(g_+ - g_-)/(2 (g_+ - 2 g_c + g_-)) spacings beyond a candidate c that has no nearer one beside it                          (2)
//! ```
//! Candidates are looked at by blocks, and a block again only when (1) says that one of its candidates may have come in reach. So most of the ring is not looked
//! at in most steps, and what is found is what a look at all of it would find. Displacements between candidates are those of a parabola.
//! Conditions at the candidates alone would let the rotor nearer by up to `|x| d^2/8` between two of them, and have the force jump from one to the next (lab rig, 192
//! of them: 0.6 % of its bearing loads).
//! Verified by `no_candidate_in_reach_is_missed`, `tests/exponential_rub.rs`.

use super::bound::length;
use super::candidates::{BLOCK, Candidates, parabola};
use crate::linalg::lanes::{LANES, Lane, kernel, least_of, rows_times_inline, sum};

/// A nearest place is no farther from its candidate, in spacings: half of one, and room for candidates that differ less in their clearances than in their gaps.
const FARTHEST: f64 = 0.75;

/// Ways are summed with room for the rounding of their sum, and begun anew beyond this one \[m\].
const ROUNDED_UP: f64 = 1.0 + 1e-9;
const FORGETS: f64 = 10.0;

/// What is known of all candidates; those that are not near are looked at where they are asked for.
#[derive(Debug, Clone)]
pub(super) struct Survey {
    /// R_i and R_r \[m\].
    radius: f64,
    rotor_radius: f64,
    step: u64,
    /// By blocks: the step in which they were looked at, radial clearances, and the least of these with `moved` of then added: (1), infinite behind the last.
    seen: Vec<u64>,
    clearances: Vec<[f64; BLOCK]>,
    least: Vec<f64>,
    /// The same of displacements along the ring, and of gaps.
    sighted: Vec<u64>,
    along: Vec<[f64; BLOCK]>,
    gaps: Vec<[f64; BLOCK]>,
    /// Amplitudes and place of the last look, and how far anything may have come to the rotor since the first.
    last: (Vec<f64>, [f64; 2]),
    moved: f64,
    /// Room for blocks.
    due: Vec<usize>,
    /// Candidates in reach with no nearer one beside them, in their order.
    pub least_ones: Vec<usize>,
}

/// A place on the ring, its gap, and the unit vector to it from the rotor.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Place {
    /// Nearest candidate, and how many spacings beyond it.
    pub index: usize,
    pub share: f64,
    pub gap: f64,
    /// In the place's polar axes, and in the stator's.
    pub polar: [f64; 2],
    pub normal: [f64; 2],
}

impl Survey {
    /// Of a ring's candidates on a radius R_i, about a rotor of radius R_r \[m\].
    pub fn new(ring: &Candidates, radius: f64, rotor_radius: f64) -> Self {
        let blocks = ring.count() / BLOCK;
        let mut least = vec![f64::INFINITY; blocks.next_multiple_of(LANES)];
        least[..blocks].fill(f64::NEG_INFINITY);
        Self {
            radius,
            rotor_radius,
            step: 0,
            seen: vec![0; blocks],
            clearances: vec![[0.0; BLOCK]; blocks],
            least,
            sighted: vec![0; blocks],
            along: vec![[0.0; BLOCK]; blocks],
            gaps: vec![[0.0; BLOCK]; blocks],
            last: (vec![0.0; ring.radial_reach.len()], [0.0; 2]),
            moved: 0.0,
            due: Vec::with_capacity(blocks),
            least_ones: Vec::with_capacity(ring.count()),
        }
    }

    /// Looks at the candidates of a ring with amplitudes q, zeros behind the last mode, from a rotor at x.
    pub fn look(&mut self, ring: &Candidates, x: [f64; 2], q: &[f64]) {
        self.step += 1;
        self.least_ones.clear();
        let (last, from) = &mut self.last;
        let way = way(last, q, &ring.radial_reach) + length([x[0] - from[0], x[1] - from[1]]);
        *from = x;
        self.moved += way * ROUNDED_UP;
        if self.moved > FORGETS {
            self.moved = 0.0;
            self.least[..self.seen.len()].fill(f64::NEG_INFINITY);
        }
        // of what is between two candidates
        let sagitta = 0.125 * ring.spacing * ring.spacing * length(x);
        let mut due = std::mem::take(&mut self.due);
        self.find_due(sagitta, &mut due);
        self.see(ring, &due, x, q);
        due.retain(|&block| self.least[block] < sagitta + self.moved);
        for &block in &due {
            self.find_least_ones(ring, block, sagitta, x, q);
        }
        self.due = due;
    }

    /// Blocks of which a candidate may have less clearance than this, by (1).
    fn find_due(&self, than: f64, due: &mut Vec<usize>) {
        due.clear();
        let limit = than + self.moved;
        for (at, eight) in self.least.as_chunks::<LANES>().0.iter().enumerate() {
            if least_of(*eight) < limit {
                due.extend((0..LANES).filter(|&k| eight[k] < limit).map(|k| at * LANES + k));
            }
        }
    }

    /// Adds those of a block.
    fn find_least_ones(&mut self, ring: &Candidates, block: usize, below: f64, x: [f64; 2], q: &[f64]) {
        let (clearances, first) = (self.clearances[block], block * BLOCK);
        for k in 0..BLOCK {
            let here = clearances[k];
            if here >= below || (k > 0 && clearances[k - 1] < here) || (k + 1 < BLOCK && clearances[k + 1] <= here) {
                continue;
            }
            // at the end of a block, the next one's has a say
            let [before, behind] = ring.beside(first + k);
            if (k == 0 && self.clearance(ring, before, x, q) < here)
                || (k + 1 == BLOCK && self.clearance(ring, behind, x, q) <= here)
            {
                continue;
            }
            self.least_ones.push(first + k);
        }
    }

    /// The blocks of which a candidate has less clearance than this, looked at where they were not.
    pub fn nearer(&mut self, ring: &Candidates, than: f64, x: [f64; 2], q: &[f64], blocks: &mut Vec<usize>) {
        self.find_due(than, blocks);
        self.see(ring, blocks, x, q);
        blocks.retain(|&block| self.least[block] < than + self.moved);
    }

    /// Clearances of a block that has been looked at.
    pub fn clearances(&self, block: usize) -> &[f64; BLOCK] {
        &self.clearances[block]
    }

    fn clearance(&mut self, ring: &Candidates, c: usize, x: [f64; 2], q: &[f64]) -> f64 {
        self.see(ring, &[c / BLOCK], x, q);
        self.clearances[c / BLOCK][c % BLOCK]
    }

    /// Looks at the clearances of blocks.
    fn see(&mut self, ring: &Candidates, blocks: &[usize], x: [f64; 2], q: &[f64]) {
        for &block in blocks {
            if self.seen[block] != self.step {
                self.seen[block] = self.step;
                let Self { clearances: all, least, moved, radius, rotor_radius, .. } = self;
                let (room, directions) = (*radius - *rotor_radius, &ring.directions[block]);
                least[block] = clearances(ring.radial(block), q, directions, x, room, &mut all[block]) + *moved;
            }
        }
    }

    /// Looks at the gaps of a block where they were not.
    #[inline]
    fn sight(&mut self, ring: &Candidates, block: usize, x: [f64; 2], q: &[f64]) {
        if self.sighted[block] != self.step {
            self.sight_anew(ring, block, x, q);
        }
    }

    fn sight_anew(&mut self, ring: &Candidates, block: usize, x: [f64; 2], q: &[f64]) {
        self.see(ring, &[block], x, q);
        self.sighted[block] = self.step;
        let Self { clearances, along, gaps: found, rotor_radius, .. } = self;
        let (directions, clearances) = (&ring.directions[block], &clearances[block]);
        [along[block], found[block]] = gaps(ring.tangential(block), q, directions, x, clearances, *rotor_radius);
    }

    /// Gaps of a block, looked at from x with amplitudes q, after the rotor and its candidates have moved, these along their radii and along the ring: as far as
    /// gaps are linear in that.
    pub fn moved_gaps(
        &mut self,
        ring: &Candidates,
        block: usize,
        (x, q): ([f64; 2], &[f64]),
        rotor: [f64; 2],
        moved: &[[f64; BLOCK]; 2],
    ) -> [f64; BLOCK] {
        self.sight(ring, block, x, q);
        let known = [&self.clearances[block], &self.along[block], &self.gaps[block]];
        moved_gaps(known, self.rotor_radius, x, &ring.directions[block], rotor, moved)
    }

    /// (2), 0 where the candidate itself is nearest or another one is.
    pub fn share(&mut self, ring: &Candidates, c: usize, x: [f64; 2], q: &[f64]) -> f64 {
        let [before, behind] = ring.beside(c);
        let before = self.gap(ring, before, x, q);
        let here = self.gap(ring, c, x, q);
        let behind = self.gap(ring, behind, x, q);
        let (slope, bend) = (0.5 * (behind - before), behind - 2.0 * here + before);
        if bend > 0.0 && slope.abs() <= FARTHEST * bend { -slope / bend } else { 0.0 }
    }

    #[inline]
    fn gap(&mut self, ring: &Candidates, c: usize, x: [f64; 2], q: &[f64]) -> f64 {
        self.sight(ring, c / BLOCK, x, q);
        self.gaps[c / BLOCK][c % BLOCK]
    }

    /// The place about a candidate that is nearest to the rotor; the candidate itself where it is not there.
    pub fn place(&mut self, ring: &Candidates, c: usize, x: [f64; 2], q: &[f64]) -> Place {
        let share = self.share(ring, c, x, q);
        let [before, behind] = ring.beside(c);
        let room = self.radius - self.rotor_radius;
        let three = [before, c, behind].map(|c| {
            let ((block, k), (sin, cos)) = ((c / BLOCK, c % BLOCK), ring.angles[c]);
            // v from its clearance
            [self.clearances[block][k] - room + (cos * x[0] + sin * x[1]), self.along[block][k]]
        });
        let weights = parabola(share);
        let (mut v, mut u) = (0.0, 0.0);
        for (weight, [radial, tangential]) in weights.into_iter().zip(three) {
            v += weight * radial;
            u += weight * tangential;
        }
        // the direction of the place: a small turn from the candidate's
        let turn = share * ring.spacing;
        let (tilt, square) = (turn * (1.0 - turn * turn / 6.0), turn * turn);
        let straight = 1.0 - 0.5 * square * (1.0 - square / 12.0);
        let (sin, cos) = ring.angles[c];
        let (sin, cos) = (sin * straight + cos * tilt, cos * straight - sin * tilt);
        let distance = [self.radius + v - (cos * x[0] + sin * x[1]), u - (cos * x[1] - sin * x[0])];
        let whole = length(distance);
        let polar = distance.map(|part| part / whole);
        let normal = [cos * polar[0] - sin * polar[1], sin * polar[0] + cos * polar[1]];
        Place { index: c, share, gap: whole - self.rotor_radius, polar, normal }
    }
}

kernel! {
    /// Clearances of eight candidates, by the columns of V, and the least of them.
    fn clearances(
        radial: &[Lane],
        q: &[f64],
        directions: &[[f64; BLOCK]; 2],
        x: [f64; 2],
        room: f64,
        clearances: &mut [f64; BLOCK],
    ) -> f64 {
        let [cos, sin] = directions;
        let mut found = rows_times_inline(radial, &q[..radial.len()]);
        for k in 0..BLOCK {
            found[k] = room + found[k] - (x[0] * cos[k] + x[1] * sin[k]);
        }
        *clearances = found;
        least_of(found)
    }
}

kernel! {
    /// `sum_j |q_j - last_j| reach_j`; last becomes q.
    fn way(last: &mut [f64], q: &[f64], reach: &[f64]) -> f64 {
        let mut ways = [0.0; LANES];
        let eights = last.as_chunks_mut::<LANES>().0.iter_mut().zip(q.as_chunks::<LANES>().0);
        for ((last, q), reach) in eights.zip(reach.as_chunks::<LANES>().0) {
            for k in 0..LANES {
                ways[k] += (q[k] - last[k]).abs() * reach[k];
            }
            *last = *q;
        }
        sum(ways)
    }
}

kernel! {
    /// Displacements along the ring of eight candidates, by the columns of U, and their gaps.
    fn gaps(
        tangential: &[Lane],
        q: &[f64],
        directions: &[[f64; BLOCK]; 2],
        x: [f64; 2],
        clearances: &[f64; BLOCK],
        rotor_radius: f64,
    ) -> [[f64; BLOCK]; 2] {
        let [cos, sin] = directions;
        let moved = rows_times_inline(tangential, &q[..tangential.len()]);
        let mut found = [0.0; BLOCK];
        for k in 0..BLOCK {
            let (outwards, across) = (clearances[k] + rotor_radius, moved[k] - (cos[k] * x[1] - sin[k] * x[0]));
            found[k] = (outwards * outwards + across * across).sqrt() - rotor_radius;
        }
        [moved, found]
    }
}

kernel! {
    /// Gaps of eight candidates, of known clearances, displacements along the ring and gaps, after they and the rotor have moved.
    fn moved_gaps(
        known: [&[f64; BLOCK]; 3],
        rotor_radius: f64,
        x: [f64; 2],
        directions: &[[f64; BLOCK]; 2],
        rotor: [f64; 2],
        moved: &[[f64; BLOCK]; 2],
    ) -> [f64; BLOCK] {
        let ([clearances, along, gaps], [cos, sin], [opens, goes]) = (known, directions, moved);
        let mut found = [0.0; BLOCK];
        for k in 0..BLOCK {
            // of the vector from the rotor to the candidate, and what changes along both parts
            let (one, other) = (clearances[k] + rotor_radius, along[k] - (cos[k] * x[1] - sin[k] * x[0]));
            let opened = opens[k] + cos[k] * rotor[0] + sin[k] * rotor[1];
            let turned = goes[k] + cos[k] * rotor[1] - sin[k] * rotor[0];
            found[k] = gaps[k] + (one * opened + other * turned) / (gaps[k] + rotor_radius);
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::exponential::candidates::candidates;
    use crate::structure::Structure;
    use bladeoff_model::machine::MachineDef;

    #[test]
    fn no_candidate_in_reach_is_missed() {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let contact = &machine.diaphragms[0].contact;
        let ring = candidates(&machine.diaphragms[0], &structure, 0, 5e-6).expect("has candidates");
        let modes = ring.radial_reach.len();
        let mut survey = Survey::new(&ring, contact.rotor_radius + contact.gap, contact.rotor_radius);
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
                q = (0..modes).map(|j| size * random() / (1.0 + ring.radial_reach[j])).collect();
            } else {
                // as far as steps go
                x = x.map(|part| part + 0.02 * contact.gap * random());
                (0..modes).for_each(|j| q[j] += 0.02 * size * random() / (1.0 + ring.radial_reach[j]));
            }
            survey.look(&ring, x, &q);
            looked += survey.seen.iter().filter(|seen| **seen == survey.step).count() * BLOCK;
            for c in 0..ring.count() {
                let v: f64 = ring.of(c).0.iter().zip(&q).map(|(row, q)| row * q).sum();
                let (sin, cos) = ring.angles[c];
                let clearance = contact.gap + v - (x[0] * cos + x[1] * sin);
                touching += usize::from(clearance < 0.0);
                let seen = survey.seen[c / BLOCK] == survey.step;
                let found = seen && (survey.clearances[c / BLOCK][c % BLOCK] - clearance).abs() < 1e-15;
                missing += usize::from(clearance < -1e-15 && !found);
            }
        }
        assert_eq!(missing, 0);
        assert!(touching > 1000, "some touch: {touching}");
        assert!(looked < 400 * ring.count() / 2, "and not all are looked at: {looked}");
    }
}
