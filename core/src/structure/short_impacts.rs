//! Impacts so short that truncated modes do not follow them statically.
//!
//! ```text
//! error(W) = sum over the truncated modes of phi^2/w^2  W^2/(w^2 + W^2),     W = pi/T       (1) of `truncation_error`
//! F(W)     = sum over all modes of           phi^2/(w^2 + W^2)               flexibility for a force that grows as e^{W t}
//! share(T) = (error of the rotor + error of the ring)/(F(W) of the rotor + F(W) of the ring)  <=  MAX_SHARE
//! ```
//! T: mean length of the impacts on a flexible ring, the measured steps per impact times the step (`crate::record`). Truncated modes follow a contact
//! force at once. An impact that is short beside their periods ends before they have moved: in the real machine their masses take part in it, and the
//! ring yields less than in the model. Only T below 1 ms is judged here; `truncation_error` judges 1 ms.
//!
//! Source: ours. Measured by `examples/short_impacts.rs`: impulse of the first contact against full finite elements, on 45 machines with rings,
//! blades and gaps varied at random. With shares below 2 % it is within 2 % in 37 of 38 runs. With 3 to 10 % it is up to 8 %, above 10 % up to 38 %
//! too large. Limits: T is a mean, so a few short impacts among long ones pass. Damping and gyroscopic terms are not in F(W). A part without a static
//! residual has no error here, only share (2). A rigid ring and a radial spring have no impacts of a length of their own. Verified by
//! `core/tests/contact/short_impacts.rs`.

use super::truncation_error::{self, FullPart, TruncationError};
use super::{RingPart, Structure};
use crate::modal::ModeSet;
use bladeoff_model::machine::Machine;
use std::f64::consts::PI;

/// Largest share of a valid run.
const MAX_SHARE: f64 = 0.1;
/// Length of the impacts for which [`Structure::truncation_error_at_contact`] judges \[s\].
const LONG: f64 = PI / truncation_error::RATE;

impl Structure {
    /// Whether contact with the flexible ring of a diaphragm acts on the static residual of truncated modes, of the shaft or of the ring.
    pub(crate) fn has_residual(&self, diaphragm: usize) -> bool {
        self.lowest_cut(diaphragm).is_finite()
    }

    /// Lowest of the highest kept frequencies of shaft and ring, of the parts with a static residual \[rad/s\]; infinite without such a part.
    fn lowest_cut(&self, diaphragm: usize) -> f64 {
        let cut = |modes: &ModeSet, own: usize| modes.omega_squared[own - 1].sqrt();
        let lateral = &self.basis.lateral;
        let shaft =
            self.lateral_residual.as_ref().map(|_| cut(lateral, lateral.omega_squared.len() - self.attachments));
        let of_ring = |ring: &RingPart| {
            ring.residual.as_ref()?;
            let modes = &self.basis.rings[self.flexible_before(diaphragm)];
            Some(cut(modes, modes.omega_squared.len()))
        };
        let ring = self.rings[diaphragm].as_ref().and_then(of_ring);
        shaft.into_iter().chain(ring).fold(f64::INFINITY, f64::min)
    }

    /// Place of the modes of a diaphragm's flexible ring in the basis.
    fn flexible_before(&self, diaphragm: usize) -> usize {
        self.rings[..diaphragm].iter().flatten().count()
    }

    /// Whether the kept modes carry impacts of a length \[s\] whatever the shapes of the truncated modes are: the error of a truncated mode is
    /// W^2/w^2 of its own flexibility F(W), so the share is at most W^2/w_h^2, with the highest kept frequency w_h.
    pub(crate) fn surely_carries(&self, diaphragm: usize, length: f64) -> bool {
        let rate = PI / length;
        length >= LONG || rate * rate < MAX_SHARE * self.lowest_cut(diaphragm).powi(2)
    }

    /// Whether the kept modes carry impacts of a mean length \[s\] on the flexible ring of a diaphragm.
    pub(crate) fn carries_impacts(&self, machine: &Machine, diaphragm: usize, length: f64) -> bool {
        self.surely_carries(diaphragm, length) || self.share_of_impacts(machine, diaphragm, length) <= MAX_SHARE
    }

    /// Share of the truncated modes in the flexibility for impacts of a mean length \[s\] on the flexible ring of a diaphragm, 0 to 1.
    #[must_use]
    pub fn share_of_impacts(&self, machine: &Machine, diaphragm: usize, length: f64) -> f64 {
        self.share_at(PI / length, diaphragm, machine.diaphragms[diaphragm].contact.node)
    }

    /// Share at a node of the shaft in the flexible ring of a diaphragm, for a force that grows with `rate` \[1/s\].
    fn share_at(&self, rate: f64, diaphragm: usize, node: usize) -> f64 {
        let Some(ring) = &self.rings[diaphragm] else { return 0.0 };
        let (rotor, lateral) = (&self.rotor, &self.basis.lateral);
        let whole = FullPart { stiffness: &rotor.stiffness, mass: &rotor.mass, sectors: None, added: self.attachments };
        let shaft = self.rotor_truncation_errors.get(node).map_or(TruncationError::NONE, |now| {
            let place = std::iter::once((rotor.plane_places(node), *now));
            let follows = self.lateral_residual.is_some();
            truncation_error::errors_at(rate, &self.lateral, lateral, whole, follows, place)[0]
        });

        let (matrices, modes) = (&ring.matrices, &self.basis.rings[self.flexible_before(diaphragm)]);
        let (stiffness, mass, sectors) = (&matrices.stiffness, &matrices.mass, Some(&matrices.sectors));
        let whole = FullPart { stiffness, mass, sectors, added: 0 };
        let radial = ring.truncation_errors.iter().enumerate().map(|(node, now)| ([4 * node + 2; 2], *now));
        let follows = ring.residual.is_some();
        let nodes = truncation_error::errors_at(rate, &ring.part, modes, whole, follows, radial);
        let shares = nodes.iter().map(|at| TruncationError::share_of_both(&shaft, at));
        shares.fold(0.0, f64::max)
    }
}
