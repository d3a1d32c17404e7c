//! Where a ring's candidates are near the rotor, and the places at which it is nearest.
//!
//! ```text
//! block of candidates a..b:   g_c >= R_i - R_r + min(v_a - x.e_a, v_b - x.e_b) - sum_j |q_j| bend_j - |x| D^2/8     no candidate of it in reach if > 0   (1)
//! nearest place   xi = -(g_+ - g_-)/(2 (g_+ - 2 g_c + g_-)) spacings beyond a candidate c that has no nearer one beside it                          (2)
//! ```
//! `|P - x| >= (P - x).e_r` and the bend of a mode between the ends of a block make (1) a bound. Displacements between candidates are those of a parabola.
//! Conditions at the candidates alone would let the rotor nearer by up to `|x| d^2/8` between two of them, and have the force jump from one to the next (lab rig, 192
//! of them: 0.6 % of its bearing loads).
//! Verified by `no_candidate_in_reach_is_missed`, `tests/exponential_rub.rs`.

use super::bound::length;
use super::candidates::{BLOCK, Candidates, parabola};

/// What is known of all candidates in one step; those that are not near are looked at where they are asked for.
#[derive(Debug, Clone)]
pub(super) struct Survey {
    /// R_i and R_r \[m\].
    radius: f64,
    rotor_radius: f64,
    step: u64,
    seen: Vec<u64>,
    all: Vec<Sight>,
    /// Those in reach.
    pub near: Vec<Nearness>,
}

/// A candidate.
#[derive(Debug, Clone, Copy, Default)]
struct Sight {
    gap: f64,
    /// Radial and tangential.
    displacement: [f64; 2],
}

/// A candidate in reach, and its gap.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearness {
    pub index: usize,
    pub gap: f64,
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
    /// Of so many candidates on a radius R_i, about a rotor of radius R_r \[m\].
    pub fn new(count: usize, radius: f64, rotor_radius: f64) -> Self {
        Self { radius, rotor_radius, step: 0, seen: vec![0; count], all: vec![Sight::default(); count], near: Vec::new() }
    }

    /// Looks at the candidates of a ring with amplitudes q from a rotor at x.
    pub fn look(&mut self, ring: &Candidates, x: [f64; 2], q: &[f64]) {
        self.step += 1;
        self.near.clear();
        let (mut slack, mut reach) = (0.0, 0.0);
        for ((q, bend), radial) in q.iter().zip(&ring.bend).zip(&ring.radial_reach) {
            slack += q.abs() * bend;
            reach += q.abs() * radial;
        }
        let (far, count) = (length(x), ring.count());
        let width = BLOCK as f64 * ring.spacing;
        let towards = |c: usize| x[0] * ring.angles[c].1 + x[1] * ring.angles[c].0;
        let room = self.radius - self.rotor_radius;
        let most = room - reach - 0.5 * width * far;
        // of their cells too: half a spacing beyond
        let least = room - slack - 0.125 * (width * width + ring.spacing * ring.spacing) * far;
        // the end of the last block that has been looked at
        let mut last = (usize::MAX, 0.0);
        for first in (0..count).step_by(BLOCK) {
            if towards(first + BLOCK / 2) < most {
                continue;
            }
            let next = if first + BLOCK == count { 0 } else { first + BLOCK };
            let near = if last.0 == first { last.1 } else { ring.radial(first, q) - towards(first) };
            let end = ring.radial(next, q) - towards(next);
            last = (next, end);
            if least + near.min(end) < 0.0 {
                for index in first..first + BLOCK {
                    let gap = self.sight(ring, index, x, q).gap;
                    self.near.push(Nearness { index, gap });
                }
            }
        }
    }

    /// The place about a candidate that is nearest to the rotor, where none beside it is nearer; otherwise the candidate itself.
    pub fn place(&mut self, ring: &Candidates, c: usize, x: [f64; 2], q: &[f64]) -> Place {
        let [before, behind] = ring.beside(c);
        let three = [before, c, behind].map(|at| self.sight(ring, at, x, q));
        let mut share = 0.0;
        if three[1].gap <= three[0].gap.min(three[2].gap) {
            let (slope, bend) = (0.5 * (three[2].gap - three[0].gap), three[2].gap - 2.0 * three[1].gap + three[0].gap);
            if bend > 0.0 {
                share = (-slope / bend).clamp(-0.5, 0.5);
            }
        }
        let weights = parabola(share);
        let moved = [0, 1].map(|i| {
            let of = |k: usize| weights[k] * three[k].displacement[i];
            of(0) + of(1) + of(2)
        });
        // the direction of the place: a small turn from the candidate's
        let turn = share * ring.spacing;
        let (tilt, square) = (turn * (1.0 - turn * turn / 6.0), turn * turn);
        let straight = 1.0 - 0.5 * square * (1.0 - square / 12.0);
        let (sin, cos) = ring.angles[c];
        let (sin, cos) = (sin * straight + cos * tilt, cos * straight - sin * tilt);
        let distance =
            [self.radius + moved[0] - (cos * x[0] + sin * x[1]), moved[1] - (cos * x[1] - sin * x[0])];
        let whole = length(distance);
        let polar = distance.map(|part| part / whole);
        let normal = [cos * polar[0] - sin * polar[1], sin * polar[0] + cos * polar[1]];
        Place { index: c, share, gap: whole - self.rotor_radius, polar, normal }
    }

    /// Whether no candidate beside a near one is nearer.
    pub fn is_least(&mut self, ring: &Candidates, c: usize, x: [f64; 2], q: &[f64]) -> bool {
        let [before, behind] = ring.beside(c);
        let here = self.sight(ring, c, x, q).gap;
        here <= self.sight(ring, before, x, q).gap && here < self.sight(ring, behind, x, q).gap
    }

    fn sight(&mut self, ring: &Candidates, c: usize, x: [f64; 2], q: &[f64]) -> Sight {
        if self.seen[c] != self.step {
            let displacement = ring.displacement(c, q);
            let gap = length(ring.distance(c, self.radius, displacement, x)) - self.rotor_radius;
            self.all[c] = Sight { gap, displacement };
            self.seen[c] = self.step;
        }
        self.all[c]
    }
}
