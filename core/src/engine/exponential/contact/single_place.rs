//! One contact place per step: the hypotheses `hyp1` and `hyp2-frozen`. `hyp2` at one place begins as `hyp2-frozen`
//! ([`super::fixed_point`]).
//!
//! ```text
//! hyp1          g = R_i + v(gamma) - |x| - R_r          at the angle gamma of the rotor's centre, normal e_r                      (1)
//! hyp2-frozen   g = |P - x| - R_r                       at the point P that is nearest without impulses, normal along P - x       (2)
//! impulse       g + W J_n = 0,  |J_t| <= mu J_n         condition at the place of n+1, one unknown where the surface slides       (3)
//! model work    J_n v_alpha/|x| (e_theta.x')            of (1): the place turns with the rotor, its gap opens by v_alpha gamma'   (4)
//!                                                       all at the place of n, where the impulse acts
//! ```
//! Symbols of [`super::ring_points`]; v_alpha: slope of the ring's radial displacement \[m/rad\]; mu: friction coefficient; W: change
//! of the gap by the impulse and its friction ([`super::delassus_operator`]).
//!
//! Gap and normal are those of the motion that [`super::contact_predictor`] has at n+1, and so is gamma. P is found on the motion
//! without impulses, as the hypothesis asks. (On the predicted motion P alternates between two positions: the last impulse moves
//! its position away.) As for several points, the impulse acts along the normal of n while the place is the same or next to it.
//!
//! Source: forward-increment Lagrange multipliers (docs/theory/04-time-integration.md), docs/theory/09-one-place.md. Limits: the
//! nearest point under the impulses is another one than P; the penetration there falls with the step
//! ([`ContactStep::remaining_gap`]). Verified by `tests/contact/one_place.rs`.

use super::broad_phase::minimum::minimum_at;
use super::contact_point::ContactPoint;
use super::contact_step::ContactStep;
use super::delassus_operator::DelassusOperator;
use super::gap_minimum::{GapMinimum, parabola_offset};
use super::ring_kernels::products_with;
use super::ring_points::{RingPoints, are_adjacent, parabola};
use crate::eight::{Eight, by_width};
use crate::engine::exponential::plane::{across, by_rows, length, product};
use bladeoff_model::machine::Detection;
use bladeoff_numerics::linalg::lanes::Lane;

/// Most ring points that a search goes downhill.
const MAX_WALK: usize = 64;

impl ContactStep {
    /// Place of the step for a rotor displaced by x in a ring with the predicted amplitudes; `None` where nothing is in reach.
    #[inline(always)]
    pub(super) fn single_place<V: Eight>(&mut self, x: [f64; 2]) -> Option<GapMinimum> {
        let Self { ring_points, predictor, broad_phase, pressed, ring, .. } = self;
        if self.detection == Detection::Hyp1 {
            let clearance = broad_phase.radius - broad_phase.rotor_radius;
            let (place, slope) = place_at_rotor_angle::<V>(ring_points, clearance, x, &predictor.ring);
            self.model_slopes[1] = slope;
            return Some(place);
        }
        // P on the motion without impulses
        let [dx, dy] = predictor.rotor_displacement;
        let (free_x, free_ring) = ([x[0] - dx, x[1] - dy], &ring.displacement);
        broad_phase.find_minima::<V>(ring_points, free_x, free_ring);
        let radii = [broad_phase.radius, broad_phase.rotor_radius];
        let mut nearest: Option<GapMinimum> = None;
        if let Some(last) = pressed.first() {
            nearest = Some(nearest_from(ring_points, radii, last.position.index, free_x, free_ring));
        }
        for &index in &broad_phase.minima {
            if nearest.is_some_and(|found| are_adjacent(found.index, index, ring_points.count())) {
                continue;
            }
            let place = nearest_from(ring_points, radii, index, free_x, free_ring);
            if nearest.is_none_or(|found| place.gap < found.gap) {
                nearest = Some(place);
            }
        }
        let GapMinimum { index, offset, .. } = nearest?;
        Some(self.place_on_predicted_motion::<V>((index, offset), x))
    }

    /// Gap and normal on the predicted motion at an offset from a ring point, for a rotor displaced by x.
    #[inline(always)]
    pub(super) fn place_on_predicted_motion<V: Eight>(&self, (index, offset): (usize, f64), x: [f64; 2]) -> GapMinimum {
        let Self { ring_points, predictor, broad_phase, .. } = self;
        let [before, behind] = ring_points.neighbours(index);
        let mut three = [[0.0; 2]; 3];
        for (k, c) in [before, index, behind].into_iter().enumerate() {
            three[k] = products_with::<V, 2>(ring_points.rows(c), &predictor.ring);
        }
        let radii = [broad_phase.radius, broad_phase.rotor_radius];
        minimum_at(ring_points, radii, (index, offset), interpolated(offset, three), x)
    }

    /// Gap (1) or (2) that the impulses leave \[m\], where it is negative; 0 otherwise. `x`: predicted displacement of the rotor.
    #[inline(always)]
    pub(super) fn remaining_gap<V: Eight>(&mut self, x: [f64; 2], operator: &DelassusOperator) -> f64 {
        let x = self.move_by_impulses::<V>(x, operator);
        let Self { ring_points, broad_phase, impulses: response, points, pressed, .. } = self;
        let Some(point) = points.first() else { return 0.0 };
        let (place, acting, force) = (&point.position, &point.acting, &point.force);
        let radii = [broad_phase.radius, broad_phase.rotor_radius];
        let gap = match self.detection {
            Detection::Hyp1 => place_at_rotor_angle::<V>(ring_points, radii[0] - radii[1], x, response).0.gap,
            _ => nearest_from(ring_points, radii, place.index, x, response).gap,
        };
        let own = by_rows(&ring_points.truncated_response(place.index, acting.index), acting.polar);
        let truncated = force.normal * product(place.polar, own)
            - DelassusOperator::previous_truncated_response(ring_points, place, pressed);
        (gap + truncated).min(0.0)
    }

    /// Takes the response of the ring's modes ([`ContactStep::evaluate_ring_response`]) to their displacement under the impulses of
    /// the one place. Returns the displacement of the rotor under them, from the predicted one \[m\].
    #[inline(always)]
    pub(super) fn move_by_impulses<V: Eight>(&mut self, x: [f64; 2], operator: &DelassusOperator) -> [f64; 2] {
        let Self { predictor, impulses: response, points, .. } = self;
        let Some(ContactPoint { acting, force, .. }) = points.first() else { return x };
        for (response, predicted) in response.iter_mut().zip(&predictor.ring) {
            (V::load(response) + V::load(predicted)).store(response);
        }
        let rotor = operator.rotor_displacement(acting, force.normal, force.tangential);
        [0, 1].map(|i| x[i] - predictor.rotor_correction[i] - rotor[i])
    }

    /// Work (4) of a normal impulse where the rotor has this velocity in the stator's axes \[J\]; 0 but for `hyp1`.
    #[inline(always)]
    pub(super) fn model_work(&self, point: &ContactPoint, velocity: [f64; 2]) -> f64 {
        match self.detection {
            Detection::Hyp1 => {
                let slope = self.model_slopes[usize::from(point.acting_slot.is_none())];
                point.force.normal * slope * product(across(point.acting.normal), velocity)
            }
            Detection::Hyp2 | Detection::Hyp2Frozen => 0.0,
        }
    }
}

/// Place (1), and v_alpha/|x| there; `clearance`: radial gap of the ring at rest \[m\].
#[inline(always)]
fn place_at_rotor_angle<V: Eight>(ring: &RingPoints, clearance: f64, x: [f64; 2], q: &[Lane]) -> (GapMinimum, f64) {
    let eccentricity = length(x);
    let (alpha, normal) = match eccentricity > 0.0 {
        true => (libm::atan2(x[1], x[0]), x.map(|part| part / eccentricity)),
        false => (0.0, [1.0, 0.0]),
    };
    let (index, offset) = ring.locate(alpha);
    let [before, behind] = ring.neighbours(index);
    let radial = products_with::<V, 3>([ring.rows(before)[0], ring.rows(index)[0], ring.rows(behind)[0]], q);
    let weights = parabola(offset);
    let v = weights[0] * radial[0] + weights[1] * radial[1] + weights[2] * radial[2];
    let slope = ((offset - 0.5) * radial[0] - 2.0 * offset * radial[1] + (offset + 0.5) * radial[2]) / ring.spacing;
    let model_slope = if eccentricity > 0.0 { slope / eccentricity } else { 0.0 };
    (GapMinimum { index, offset, gap: clearance + v - eccentricity, polar: [1.0, 0.0], normal }, model_slope)
}

by_width! {
    /// Place (2) that is reached downhill from a ring point; `radii`: of the ring's surface and of the rotor \[m\]. A function of
    /// its own because it is called from several places.
    pub(super) fn nearest_from(ring: &RingPoints, radii: [f64; 2], from: usize, x: [f64; 2], q: &[Lane]) -> GapMinimum = nearest_from_kernel
}

#[inline(always)]
fn nearest_from_kernel<V: Eight>(
    ring: &RingPoints,
    radii: [f64; 2],
    from: usize,
    x: [f64; 2],
    q: &[Lane],
) -> GapMinimum {
    let [before, behind] = ring.neighbours(from);
    let (mut index, mut three) = (from, [([0.0; 2], 0.0); 3]);
    for (k, c) in [before, from, behind].into_iter().enumerate() {
        three[k] = point_gap::<V>(ring, radii, c, x, q);
    }
    for _ in 0..MAX_WALK {
        let [before, behind] = ring.neighbours(index);
        if three[0].1 < three[1].1 && three[0].1 <= three[2].1 {
            index = before;
            three = [point_gap::<V>(ring, radii, ring.neighbours(index)[0], x, q), three[0], three[1]];
        } else if three[2].1 < three[1].1 {
            index = behind;
            three = [three[1], three[2], point_gap::<V>(ring, radii, ring.neighbours(index)[1], x, q)];
        } else {
            break;
        }
    }
    let offset = parabola_offset([three[0].1, three[1].1, three[2].1]);
    minimum_at(ring, radii, (index, offset), interpolated(offset, [three[0].0, three[1].0, three[2].0]), x)
}

/// Displacement of the ring at a point, and gap there \[m\].
#[inline(always)]
fn point_gap<V: Eight>(ring: &RingPoints, radii: [f64; 2], c: usize, x: [f64; 2], q: &[Lane]) -> ([f64; 2], f64) {
    let [v, u] = products_with::<V, 2>(ring.rows(c), q);
    let (sin, cos) = ring.angles[c];
    let distance = length([radii[0] + v - (cos * x[0] + sin * x[1]), u - (cos * x[1] - sin * x[0])]);
    ([v, u], distance - radii[1])
}

/// Displacement of the ring at an offset from the middle one of three points.
#[inline(always)]
fn interpolated(offset: f64, three: [[f64; 2]; 3]) -> [f64; 2] {
    let [a, b, c] = parabola(offset);
    [0, 1].map(|i| a * three[0][i] + b * three[1][i] + c * three[2][i])
}

#[cfg(test)]
mod tests {
    use super::super::ring_points::ring_points;
    use super::*;
    use crate::contact::{Detector, exact_gap, polar_gap};
    use crate::eight::Plain;
    use crate::structure::Structure;
    use bladeoff_model::machine::{ContactSurface, MachineDef};
    use bladeoff_numerics::linalg::lanes::lanes_of;

    #[test]
    fn places_are_those_of_the_reference_engines() {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let contact = &machine.diaphragms[0].contact;
        let ring = ring_points(&machine.diaphragms[0], &structure, 0, 5e-6);
        let part = structure.rings[0].as_ref().expect("a ring");
        let [outer, inner] = [contact.rotor_radius + contact.gap, contact.rotor_radius];
        let surface = part.matrices.surface(outer, contact.surface == ContactSurface::InnerFace);
        let mut detector = Detector::new(surface);
        let mut field = vec![0.0; 4 * part.matrices.nodes];
        let modes = part.part.coordinates.size();
        // the parabola of three points leaves a few 1e-4 of the bend
        let (mut moved, mut leaning, mut bend) = (0.0_f64, 0.0_f64, 0.0_f64);
        let tolerance = 5e-10;
        for round in 0..60 {
            let turn = 0.37 * f64::from(round);
            let x = [4e-4 * turn.cos(), 4e-4 * turn.sin()];
            // low modes only, bent by some micrometres
            let mut q = vec![0.0; modes];
            for (j, amplitude) in q.iter_mut().take(6).enumerate() {
                *amplitude = 3e-7 * (turn * (j as f64 + 1.3)).sin();
            }
            part.part.coordinates.expand_head(&q, &mut field);
            let lanes = lanes_of(&[q, vec![0.0; modes.next_multiple_of(8) - modes]].concat());
            let polar = polar_gap(&surface, Some(&field), inner, x);
            let (place, slope) = place_at_rotor_angle::<Plain>(&ring, outer - inner, x, &lanes);
            assert!((place.gap - polar.value).abs() < tolerance, "{} {}", place.gap, polar.value);
            assert!((slope - polar.model_slope).abs() < 1e-3, "{slope} {}", polar.model_slope);
            leaning = leaning.max(slope.abs());
            bend = bend.max((polar.value - (outer - inner - length(x))).abs());
            let nearest = detector.closest(&field, x);
            let exact = exact_gap(&surface, Some(&field), inner, x, nearest);
            // from a quarter of the ring away
            let (from, _) = ring.locate(turn + 1.0);
            let place = nearest_from(&ring, [outer, inner], from, x, &lanes);
            assert!((place.gap - exact.value).abs() < tolerance, "{} {}", place.gap, exact.value);
            moved = moved.max((place.gap - polar.value).abs());
        }
        println!("slope {leaning:e}, distance of the two gaps {moved:e}, bend {bend:e}");
        assert!(bend > 1e3 * tolerance && moved > 10.0 * tolerance && leaning > 1e-3, "the ring is bent");
    }
}
