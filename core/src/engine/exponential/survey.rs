//! Where a ring's candidates are near the rotor, and the places at which it is nearest.
//!
//! ```text
//! block of candidates a..b:   g_c >= R_i - R_r + min(v_a - x.e_a, v_b - x.e_b) - sum_j |q_j| bend_j - |x| D^2/8     no candidate of it in reach if > 0   (1)
//! clearance       r_c = R_i + v_c - x.e_r - R_r <= g_c,   g_c - r_c = (x.e_t - u_c)^2/2R_i, nearly: 2 um 0.2 rad beside the least one of a turbine
//! later           v - x.e of (1) is no less than it was, less all ways since: sum over steps of  |x+ - x| + sum_j |q_j+ - q_j| reach_j                  (3)
//! nearest place   xi = -(g_+ - g_-)/(2 (g_+ - 2 g_c + g_-)) spacings beyond a candidate c that has no nearer one beside it                          (2)
//! ```
//! So most of the ring is not looked at in most steps, and what is found is what a look at all of it would find.
//! `|P - x| >= (P - x).e_r` and the bend of a mode between the ends of a block make (1) a bound. Displacements between candidates are those of a parabola.
//! Conditions at the candidates alone would let the rotor nearer by up to `|x| d^2/8` between two of them, and have the force jump from one to the next (lab rig, 192
//! of them: 0.6 % of its bearing loads).
//! Verified by `no_candidate_in_reach_is_missed`, `tests/exponential_rub.rs`.

use super::bound::length;
use super::candidates::{BLOCK, Candidates, parabola};

/// A nearest place is no farther from its candidate, in spacings: half of one, and room for candidates that differ less in their clearances than in their gaps.
const FARTHEST: f64 = 0.75;

/// Ways are summed with room for the rounding of their sum, and begun anew beyond this one \[m\].
const ROUNDED_UP: f64 = 1.0 + 1e-9;
const FORGETS: f64 = 10.0;

/// What is known of all candidates in one step; those that are not near are looked at where they are asked for.
#[derive(Debug, Clone)]
pub(super) struct Survey {
    /// R_i and R_r \[m\].
    radius: f64,
    rotor_radius: f64,
    step: u64,
    /// By blocks: the step in which they were looked at, and radial clearances, radial displacements.
    seen: Vec<u64>,
    clearances: Vec<[f64; BLOCK]>,
    displacements: Vec<[f64; BLOCK]>,
    /// The same of tangential displacements.
    seen_along: Vec<u64>,
    along: Vec<[f64; BLOCK]>,
    firsts: Vec<f64>,
    /// Amplitudes and place of the last look, and how far anything may have come to the rotor since the first.
    last: (Vec<f64>, [f64; 2]),
    moved: f64,
    /// By fours of blocks: `moved` when their firsts were taken, and the least of these and the very first of them, with it added.
    taken: Vec<f64>,
    lowest: Vec<[f64; 2]>,
    near: Vec<usize>,
    /// Candidates whose radial clearance is below the sagitta of a cell, and it.
    pub low: Vec<(usize, f64)>,
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
    /// Of so many candidates on a radius R_i with so many modes, about a rotor of radius R_r \[m\].
    pub fn new(count: usize, modes: usize, radius: f64, rotor_radius: f64) -> Self {
        let blocks = count / BLOCK;
        Self {
            radius,
            rotor_radius,
            step: 0,
            seen: vec![0; blocks],
            clearances: vec![[0.0; BLOCK]; blocks],
            displacements: vec![[0.0; BLOCK]; blocks],
            seen_along: vec![0; blocks],
            along: vec![[0.0; BLOCK]; blocks],
            firsts: vec![0.0; blocks.next_multiple_of(BLOCK)],
            last: (vec![0.0; modes], [0.0; 2]),
            moved: 0.0,
            taken: vec![f64::NEG_INFINITY; blocks.div_ceil(BLOCK)],
            lowest: vec![[f64::NEG_INFINITY; 2]; blocks.div_ceil(BLOCK)],
            near: Vec::with_capacity(blocks),
            low: Vec::with_capacity(count),
        }
    }

    /// Looks at the candidates of a ring with amplitudes q from a rotor at x.
    pub fn look(&mut self, ring: &Candidates, x: [f64; 2], q: &[f64]) {
        self.step += 1;
        self.low.clear();
        self.near.clear();
        let slack = self.come_nearer(ring, x, q);
        let far = length(x);
        let width = BLOCK as f64 * ring.spacing;
        let room = self.radius - self.rotor_radius;
        // of their cells too: half a spacing beyond
        let sagitta = 0.125 * ring.spacing * ring.spacing * far;
        let least = room - slack - 0.125 * width * width * far - sagitta;
        let fours = self.lowest.len();
        for four in 0..fours {
            let next = if four + 1 == fours { 0 } else { four + 1 };
            // (3)
            if least + self.lowest[four][0].min(self.lowest[next][1]) - self.moved < 0.0 {
                self.see_near(ring, [four, next], least, x, q);
            }
        }
        for at in 0..self.near.len() {
            let block = self.near[at];
            self.see(ring, block, x, q);
            for (k, clearance) in self.clearances[block].iter().enumerate() {
                if *clearance < sagitta {
                    self.low.push((block * BLOCK + k, *clearance));
                }
            }
        }
    }

    /// Adds the way of ring and rotor since the last look, and returns the most that the ring bends away from the straight lines of (1).
    fn come_nearer(&mut self, ring: &Candidates, x: [f64; 2], q: &[f64]) -> f64 {
        let (last, from) = &mut self.last;
        let modes = q.len();
        let (last, bend, reach) = (&mut last[..modes], &ring.bend[..modes], &ring.radial_reach[..modes]);
        let mut sums = [[0.0; 2]; 2];
        let mut add = |j: usize, k: usize| {
            sums[0][k] += q[j].abs() * bend[j];
            sums[1][k] += (q[j] - last[j]).abs() * reach[j];
            last[j] = q[j];
        };
        for j in (0..modes / 2 * 2).step_by(2) {
            add(j, 0);
            add(j + 1, 1);
        }
        if modes % 2 == 1 {
            add(modes - 1, 0);
        }
        let [slack, way] = sums.map(|[one, other]| one + other);
        let way = way + length([x[0] - from[0], x[1] - from[1]]);
        *from = x;
        self.moved += way * ROUNDED_UP;
        if self.moved > FORGETS {
            self.moved = 0.0;
            self.taken.fill(f64::NEG_INFINITY);
            self.lowest.fill([f64::NEG_INFINITY; 2]);
        }
        slack
    }

    /// Takes the blocks of a four that (1) does not exclude.
    fn see_near(&mut self, ring: &Candidates, fours: [usize; 2], least: f64, x: [f64; 2], q: &[f64]) {
        let blocks = self.seen.len();
        for four in fours {
            if self.taken[four] == self.moved {
                continue;
            }
            self.taken[four] = self.moved;
            let values = ring.radials_of_firsts(four, q);
            let (from, to) = (four * BLOCK, ((four + 1) * BLOCK).min(blocks));
            let mut lowest = f64::INFINITY;
            for block in from..to {
                let (sin, cos) = ring.angles[block * BLOCK];
                self.firsts[block] = values[block - from] - (x[0] * cos + x[1] * sin);
                lowest = lowest.min(self.firsts[block]);
            }
            self.lowest[four] = [lowest + self.moved, self.firsts[from] + self.moved];
        }
        let (from, to) = (fours[0] * BLOCK, ((fours[0] + 1) * BLOCK).min(blocks));
        for block in from..to {
            let end = self.firsts[if block + 1 == blocks { 0 } else { block + 1 }];
            if least + self.firsts[block].min(end) < 0.0 {
                self.near.push(block);
            }
        }
    }

    /// Blocks in reach.
    pub fn near(&self) -> &[usize] {
        &self.near
    }

    /// Radial clearances of a block that has been looked at.
    pub fn clearances(&self, block: usize) -> [f64; BLOCK] {
        self.clearances[block]
    }

    /// Looks at a block.
    fn see(&mut self, ring: &Candidates, block: usize, x: [f64; 2], q: &[f64]) {
        if self.seen[block] == self.step {
            return;
        }
        self.seen[block] = self.step;
        let moved = ring.radials(block, q);
        let room = self.radius - self.rotor_radius;
        self.displacements[block] = moved;
        self.clearances[block] = std::array::from_fn(|k| {
            let (sin, cos) = ring.angles[block * BLOCK + k];
            room + moved[k] - (x[0] * cos + x[1] * sin)
        });
    }

    /// Whether no candidate beside one has less clearance.
    pub fn is_least(&mut self, ring: &Candidates, c: usize, x: [f64; 2], q: &[f64]) -> bool {
        let (block, k) = (c / BLOCK, c % BLOCK);
        let here = self.clearances[block][k];
        // beside it in its block, which is known, or at the end of another
        if k > 0 && self.clearances[block][k - 1] < here {
            return false;
        }
        if k + 1 < BLOCK && self.clearances[block][k + 1] <= here {
            return false;
        }
        let [before, behind] = ring.beside(c);
        (k > 0 || here <= self.clearance(ring, before, x, q))
            && (k + 1 < BLOCK || here < self.clearance(ring, behind, x, q))
    }

    fn clearance(&mut self, ring: &Candidates, c: usize, x: [f64; 2], q: &[f64]) -> f64 {
        self.see(ring, c / BLOCK, x, q);
        self.clearances[c / BLOCK][c % BLOCK]
    }

    /// Displacement of a candidate, radial and tangential, and its gap.
    fn sight(&mut self, ring: &Candidates, c: usize, x: [f64; 2], q: &[f64]) -> ([f64; 2], f64) {
        let block = c / BLOCK;
        self.see(ring, block, x, q);
        let v = self.displacements[block][c % BLOCK];
        if self.seen_along[block] != self.step {
            self.seen_along[block] = self.step;
            self.along[block] = ring.tangentials(block, q);
        }
        let u = self.along[block][c % BLOCK];
        let (sin, cos) = ring.angles[c];
        let distance = [self.radius + v - (cos * x[0] + sin * x[1]), u - (cos * x[1] - sin * x[0])];
        ([v, u], length(distance) - self.rotor_radius)
    }

    /// The place about a candidate that is nearest to the rotor; the candidate itself where it is not there.
    pub fn place(&mut self, ring: &Candidates, c: usize, x: [f64; 2], q: &[f64]) -> Place {
        let [before, behind] = ring.beside(c);
        let three = [before, c, behind].map(|c| self.sight(ring, c, x, q));
        let gaps = three.map(|(_, gap)| gap);
        let (slope, bend) = (0.5 * (gaps[2] - gaps[0]), gaps[2] - 2.0 * gaps[1] + gaps[0]);
        let share = if bend > 0.0 && slope.abs() <= FARTHEST * bend { -slope / bend } else { 0.0 };
        let weights = parabola(share);
        let (mut v, mut u) = (0.0, 0.0);
        for (weight, ([radial, tangential], _)) in weights.into_iter().zip(three) {
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
        let modes = ring.bend.len();
        let mut survey = Survey::new(ring.count(), modes, contact.rotor_radius + contact.gap, contact.rotor_radius);
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let (mut missing, mut touching, mut looked) = (0, 0, 0);
        for round in 0..400 {
            let (angle, far) = (20.0 * random(), contact.gap * (0.7 + 1.2 * (random() + 0.5)));
            let x = [far * libm::cos(angle), far * libm::sin(angle)];
            // from a ring at rest to one that is bent by half the gap
            let size = 2e-6 * f64::from(round % 20);
            let q: Vec<f64> = (0..modes).map(|j| size * random() / (1.0 + ring.radial_reach[j])).collect();
            survey.look(&ring, x, &q);
            looked += survey.near().len() * BLOCK;
            let (mut normal, mut tangent) = (vec![0.0; modes], vec![0.0; modes]);
            for c in 0..ring.count() {
                ring.rows_at(c, 0.0, [[1.0, 0.0], [0.0, 1.0]], [&mut normal, &mut tangent]);
                let v: f64 = normal.iter().zip(&q).map(|(row, q)| row * q).sum();
                let (sin, cos) = ring.angles[c];
                let clearance = contact.gap + v - (x[0] * cos + x[1] * sin);
                touching += usize::from(clearance < 0.0);
                let found = survey.low.iter().any(|(index, known)| *index == c && (known - clearance).abs() < 1e-15);
                missing += usize::from(clearance < -1e-15 && !found);
            }
        }
        assert_eq!(missing, 0);
        assert!(touching > 1000, "some touch: {touching}");
        assert!(looked < 400 * ring.count() / 2, "and not all are looked at: {looked}");
    }
}
