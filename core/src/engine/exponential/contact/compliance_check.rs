//! Check at the beginning of a run: the displacement of a ring under a constant force, in contact steps and by its stiffness.
//!
//! ```text
//! by stiffness   u = v^T K^-1 v                                       K: stiffness of ring and blades                           (1)
//! predicted      u = V.(n + (d + c) J) + r (1 - p)                    J = V h: a constant force of 1 N, as impulses             (2)
//! conditions     u = V.(n + (d + 2 c) J - c J) + r (1 - p)            at every n                                                (3)
//! ```
//! u: radial displacement of a ring point per radial force there \[m/N\]; v: shape functions of the point on the degrees of freedom;
//! V: radial mode shapes there; n: amplitudes at n+1 of the motion that the train of impulses sustains, before its impulse at n
//! acts; d, c: [`super::contact_predictor`]; r: response of the truncated modes to the impulse at n, p: share of the impulse at n-1
//! that is subtracted ([`StaticCorrection`](super::impulsed_ring::StaticCorrection)).
//!
//! A static correction moves the places of contact and adds no energy, so no guard of energy finds a wrong one. This check does. It
//! evaluates (2) and (3) with the tables of the run, at a blade and half-way between two blades. With
//! `run.static_residual = "off"` truncated modes do not follow a force, and (1) is `sum_j V_j^2/w_j^2` over the kept modes.
//!
//! Limits: radial forces only. The truncated modes follow no friction force, and the kept modes have one correction for both
//! directions. The correction of the rotor is not checked. Verified by `a_wrong_static_correction_is_found_before_the_run`
//! ([`crate::engine::exponential::observe`]), `rings_have_the_compliance_of_their_stiffness`.

use super::contact_step::ContactStep;
use super::static_compliance::StaticCompliance;
use crate::eight::Plain;
use crate::engine::exponential::ExponentialError;
use bladeoff_numerics::linalg::dot;
use bladeoff_numerics::linalg::lanes::{Lane, flat};

/// Largest relative difference of the compliances.
const TOLERANCE: f64 = 1e-6;

impl ContactStep {
    /// Checks the compliance of the ring in contact steps.
    ///
    /// # Errors
    /// [`ExponentialError::StaticCompliance`] where (2) or (3) differs from (1).
    pub fn check_static_compliance(&self, diaphragm: &str) -> Result<(), ExponentialError> {
        for &StaticCompliance { point, compliance: expected } in &self.ring_points.static_compliances {
            for found in self.compliances_in_steps(point) {
                let is_equal = (found / expected - 1.0).abs() <= TOLERANCE;
                if !is_equal {
                    return Err(ExponentialError::StaticCompliance {
                        diaphragm: diaphragm.to_owned(),
                        found,
                        expected,
                    });
                }
            }
        }
        Ok(())
    }

    /// Compliances (2) and (3) at a ring point \[m/N\].
    fn compliances_in_steps(&self, point: usize) -> [f64; 2] {
        let shape = self.ring_points.rows(point)[0];
        let impulses: Vec<Lane> = shape.iter().map(|lane| Lane(lane.0.map(|v| v * self.h))).collect();
        let mut ring = self.ring.clone();
        ring.sustain(&impulses);
        ring.propagate_free::<Plain>();
        let [predicted, correction] = self.predictor.corrections().map(flat);
        let (conditions, impulses) = (flat(&self.compliance), flat(&impulses));
        let displaced = |compliance: &dyn Fn(usize) -> f64| {
            let amplitude = |(j, free): (usize, &f64)| free + compliance(j) * impulses[j];
            let amplitudes: Vec<f64> = flat(&ring.displacement).iter().enumerate().map(amplitude).collect();
            dot(flat(shape), &amplitudes)
        };
        let truncated = self.h
            * self.ring_points.truncated_response(point, point)[0]
            * (1.0 - self.ring_points.static_correction.previous_share());
        [displaced(&|j| predicted[j]) + truncated, displaced(&|j| conditions[j] - correction[j]) + truncated]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::exponential::contact::ring_points::ring_points;
    use crate::structure::Structure;
    use bladeoff_model::machine::{ContactSurface, MachineDef};
    use bladeoff_numerics::linalg::spd_inverse;
    use std::sync::Arc;

    /// Contact of the lab rig with these settings of `[run]` in contact steps of `h` \[s\], and its structure.
    fn lab_rig(run: &str, h: f64) -> (ContactStep, Structure) {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let text = text.replacen("[run]", &format!("[run]\n{run}"), 1);
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        assert_eq!(machine.diaphragms[0].contact.surface, ContactSurface::InnerFace);
        let structure = Structure::build(&machine, None).expect("buildable");
        let points = Arc::new(ring_points(&machine.diaphragms[0], &structure, 0, h));
        (ContactStep::new(&machine.diaphragms[0], &structure, 0, &points, h), structure)
    }

    #[test]
    fn rings_have_the_compliance_of_their_stiffness() {
        // all modes, half of a pair truncated, 12 modes with and without the truncated ones; default steps and fine ones
        let off = "ring_modes = 12\nstatic_residual = \"off\"";
        for (run, follows) in
            [("", true), ("ring_modes = 500", true), ("ring_modes = 13", true), ("ring_modes = 12", true), (off, false)]
        {
            for h in [1e-6, 1e-7, 1e-8] {
                let (contact, structure) = lab_rig(run, h);
                contact.check_static_compliance("seal").expect("equal");
                let (points, part) = (&contact.ring_points, structure.rings[0].as_ref().expect("a ring"));
                let inverse = spd_inverse(&part.matrices.stiffness).expect("definite");
                assert_eq!(points.static_compliances.len(), 2);
                for at in &points.static_compliances {
                    for found in contact.compliances_in_steps(at.point) {
                        assert!((found / at.compliance - 1.0).abs() < 1e-12, "{run} {h}: {found} {at:?}");
                    }
                    // by the whole matrix, at the angle of the point
                    let (element, xi) = points.surface.locate((at.point as f64 + 0.5) * points.spacing);
                    let shapes = points.surface.shapes(element, xi);
                    let row = |i: usize| shapes.iter().map(|&(j, v, _)| v * inverse[(i, j)]).sum::<f64>();
                    let whole: f64 = shapes.iter().map(|&(i, v, _)| v * row(i)).sum();
                    let ratio = at.compliance / whole;
                    assert!(if follows { (ratio - 1.0).abs() < 1e-9 } else { ratio < 0.99 }, "{run}: {ratio}");
                }
            }
        }
    }

    #[test]
    fn a_wrong_correction_of_one_table_is_found() {
        let wrong = |change: &dyn Fn(&mut ContactStep)| {
            let (mut contact, _) = lab_rig("", 6.2e-6);
            change(&mut contact);
            contact.check_static_compliance("seal")
        };
        assert_eq!(wrong(&|_| ()), Ok(()));
        for found in [
            wrong(&ContactStep::reverse_static_correction),
            wrong(&|contact| drop(contact.predictor.reverse_static_correction())),
            wrong(&|contact| contact.compliance[0].0[2] *= 1.001),
        ] {
            let Err(ExponentialError::StaticCompliance { diaphragm, found, expected }) = found else {
                panic!("found equal")
            };
            assert!(diaphragm == "seal" && (found / expected - 1.0).abs() > 1e-6, "{found} {expected}");
        }
    }
}
