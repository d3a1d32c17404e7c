//! Impacts so short that truncated modes do not follow them statically.
//!
//! ```text
//! share(pi/T) > MAX_TRUNCATION_ERROR      share (3) of `truncation_error`, for the mean length T of the impacts on a flexible ring
//! ```
//! Truncated modes follow a contact force at once. An impact that is short beside their periods ends before they have moved, so in the real machine
//! their masses take part in it. T is the measured number of steps per impact times the step (`crate::record`), and counts below 1 ms, the length
//! for which `truncation_error` itself is judged.
//!
//! Source: ours. Measured: impulse of the first contact against full finite elements, over machines whose rings, gaps and blades were varied at
//! random (docs/theory/convergence.md). With shares up to 2 % the engines agree within the error of the step. With 3.4, 5.8 and 18 % the impulse is 8,
//! 9 and 45 % too large. Limits: no such measure exists without a static residual, where share (2) does not depend on T, and for a rigid ring or a
//! radial spring, which have no impacts of a length of their own. Verified by `core/tests/contact/short_impacts.rs`.

use super::Structure;
use super::truncation_error::{self, FullPart, MAX_TRUNCATION_ERROR, TruncationError};
use crate::modal::table_mode_count;
use bladeoff_model::machine::{DiaphragmKind, Machine};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Mutex;

/// Length of the impacts for which [`Structure::truncation_error_at_contact`] judges \[s\].
const LONG: f64 = PI / truncation_error::RATE;
/// Shortest length that is looked for \[s\].
const SHORT: f64 = 1e-7;
/// Halvings of the interval of log T: the shortest impact is found to 1 %.
const HALVINGS: usize = 10;
/// Truncated modes with frequencies above this multiple of `pi/T` have a share of less than 1/37, whatever their flexibility is.
const FAR: f64 = 6.0;

/// Shortest impact that the kept modes carry \[s\], by diaphragm and node of the shaft.
pub(super) type ShortestImpacts = Mutex<BTreeMap<(usize, usize), f64>>;

impl Structure {
    /// Whether modes of the shaft or of a diaphragm's ring are truncated.
    pub(crate) fn is_truncated(&self, diaphragm: usize) -> bool {
        self.lowest_cut(diaphragm).is_finite()
    }

    /// Lowest of the highest kept frequencies of shaft and ring, of the parts with truncated modes \[rad/s\]; infinite without such a part.
    fn lowest_cut(&self, diaphragm: usize) -> f64 {
        let cut = |part: &super::Part| {
            let shapes = part.coordinates.shapes().filter(|shapes| shapes.ncols() < shapes.nrows());
            shapes.map_or(f64::INFINITY, |_| part.highest)
        };
        let ring = self.rings[diaphragm].as_ref().map_or(f64::INFINITY, |ring| cut(&ring.part));
        cut(&self.lateral).min(ring)
    }

    /// Whether the kept modes carry impacts of a mean length \[s\] on the flexible ring of a diaphragm. The first impact below
    /// `FAR` costs several inversions of the matrices of shaft and ring.
    pub(crate) fn carries_impacts(&self, machine: &Machine, diaphragm: usize, length: f64) -> bool {
        if length >= LONG || self.lowest_cut(diaphragm) * length > FAR * PI {
            return true;
        }
        let node = machine.diaphragms[diaphragm].contact.node;
        let found = self.shortest_impacts.get::<ShortestImpacts>();
        let mut found = found.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        length >= *found.entry((diaphragm, node)).or_insert_with(|| self.shortest_impact(diaphragm, node))
    }

    /// Shortest mean impact that the kept modes carry \[s\], by bisection; 0 if they carry all.
    fn shortest_impact(&self, diaphragm: usize, node: usize) -> f64 {
        let is_carried = |length: f64| self.share_at(PI / length, diaphragm, node) <= MAX_TRUNCATION_ERROR;
        if is_carried(SHORT) {
            return 0.0;
        }
        let (mut short, mut long) = (SHORT, LONG);
        for _ in 0..HALVINGS {
            let middle = (short * long).sqrt();
            *(if is_carried(middle) { &mut long } else { &mut short }) = middle;
        }
        long
    }

    /// Share (3) of `truncation_error` at a node of the shaft in the flexible ring of a diaphragm, for a force that grows with `rate` \[1/s\].
    fn share_at(&self, rate: f64, diaphragm: usize, node: usize) -> f64 {
        let rotor = &self.rotor;
        let added = table_mode_count(rotor, (&self.basis.lateral.omega_squared, &self.basis.lateral.shapes));
        let whole = FullPart { stiffness: &rotor.stiffness, mass: &rotor.mass, sectors: None, added };
        let shaft: Vec<TruncationError> = if self.lateral_residual.is_some() {
            let place = std::iter::once(rotor.plane_places(node));
            truncation_error::errors_at(rate, &self.lateral, &self.basis.lateral, whole, place)
        } else {
            self.rotor_truncation_errors.get(node).copied().into_iter().collect()
        };
        let Some(ring) = &self.rings[diaphragm] else { return 0.0 };
        let flexible = self.rings[..diaphragm].iter().flatten().count();
        let matrices = &ring.matrices;
        let whole = FullPart {
            stiffness: &matrices.stiffness,
            mass: &matrices.mass,
            sectors: Some(&matrices.sectors),
            added: 0,
        };
        let ring: Vec<TruncationError> = if ring.residual.is_some() {
            let radial = (0..matrices.nodes).map(|node| [4 * node + 2; 2]);
            truncation_error::errors_at(rate, &ring.part, &self.basis.rings[flexible], whole, radial)
        } else {
            ring.truncation_errors.clone()
        };
        // a stator's motion enters by its static flexibility, so the kind matters for radial springs alone
        truncation_error::at_contact(shaft.first(), &ring, &DiaphragmKind::Rigid)
    }
}
