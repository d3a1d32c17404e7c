//! Sense of a whirl mode (forward, backward, mixed or planar) from the orbits of its nodes.
//!
//! ```text
//! u, v complex amplitudes of a node:  x = Re(u e^{lambda t}),  y = Re(v e^{lambda t})
//! f = (u + i v)/2,  b = (u - i v)/2         circles with and against the spin; |f| + |b| is the major half axis          (1)
//! s = (|f| - |b|)/(|f| + |b|)               share of a node: minor over major half axis, signed by the sense             (2)
//! net share = sum of (|f| - |b|) / sum of (|f| + |b|)       mean of (2), weighted by the major half axes                 (3)
//! ```
//! Source: (1) is the usual decomposition of an ellipse into two circles (Childs, Turbomachinery Rotordynamics, 1993); (2) is the ratio
//! "kappa" of rotordynamics programs. Verified by the tests below.

use super::shape::Mode;
use crate::rotor::RotorMatrices;

/// Sense of a whirl.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Whirl {
    /// With the spin.
    Forward,
    /// Against the spin.
    Backward,
    /// Forward on one part of the shaft, backward on another.
    Mixed,
    /// Motion along a straight line, or nearly so: at rest, or with a net share below [`STRAIGHT`] in magnitude.
    Planar,
}

impl Whirl {
    /// All senses, in the order of a legend.
    pub const ALL: [Whirl; 4] = [Whirl::Forward, Whirl::Backward, Whirl::Mixed, Whirl::Planar];

    /// Name of the sense in tables and figures.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Whirl::Forward => "forward",
            Whirl::Backward => "backward",
            Whirl::Mixed => "mixed",
            Whirl::Planar => "planar",
        }
    }
}

/// Magnitude of the share (2) below which an orbit counts as a straight line. Such an ellipse is at least 20 times as long as wide. Its
/// forward circle is more than 0.475 of the major half axis, so unbalance excites the mode almost equally for either sign of the share.
pub const STRAIGHT: f64 = 0.05;
/// Minimum major half axis of a counted node, relative to the largest. Near a vibration node the forward and backward circles vanish at
/// different places, and the share there does not characterise the mode.
pub const NOTABLE: f64 = 0.1;
/// Forward part of the motion, `(1 + net share)/2`, above which unbalance excites a mode. Modes of isotropic machines are exact circles:
/// the forward part of their backward modes is 0 except for rounding.
const EXCITED: f64 = 1e-3;

/// Returns whether unbalance excites a mode with this net share, that is, whether the mode has a forward part. Limit: the criterion uses
/// the mode shape only, not the axial position of the unbalance.
#[must_use]
pub fn excited_by_unbalance(share: f64) -> bool {
    0.5 * (1.0 + share) > EXCITED
}

/// Returns the share (2) \[-\] and the major half axis (in units of the mode shape) of each node.
pub(super) fn orbits(mode: &Mode, rotor: &RotorMatrices) -> Vec<[f64; 2]> {
    let orbit = |node: usize| {
        let [[ur, ui], [vr, vi]] = rotor.plane_places(node).map(|place| mode.at(place));
        let forward = 0.5 * libm::hypot(ur - vi, ui + vr);
        let backward = 0.5 * libm::hypot(ur + vi, ui - vr);
        let size = forward + backward;
        [if size > 0.0 { (forward - backward) / size } else { 0.0 }, size]
    };
    (0..rotor.nodes).map(orbit).collect()
}

/// Returns the sense and the net share (3) of the orbits of all nodes.
///
/// `mixed`: among the nodes with a notable orbit ([`NOTABLE`]), one has a share of at least [`STRAIGHT`] and another a share of at most
/// `-STRAIGHT`. Otherwise `planar` if the magnitude of the net share is below [`STRAIGHT`], else the sign of the net share.
pub(super) fn sense(orbits: &[[f64; 2]]) -> (Whirl, f64) {
    let largest = orbits.iter().map(|[_, size]| *size).fold(0.0, f64::max);
    let (whole, turning) = orbits.iter().fold((0.0, 0.0), |(a, b), [share, size]| (a + size, b + share * size));
    let net = if whole > 0.0 { turning / whole } else { 0.0 };
    let notable = || orbits.iter().filter(|[_, size]| *size >= NOTABLE * largest).map(|[share, _]| *share);
    let whirl = if notable().any(|share| share >= STRAIGHT) && notable().any(|share| share <= -STRAIGHT) {
        Whirl::Mixed
    } else if net.abs() < STRAIGHT {
        Whirl::Planar
    } else if net > 0.0 {
        Whirl::Forward
    } else {
        Whirl::Backward
    };
    (whirl, net)
}

#[cfg(test)]
mod tests {
    use super::super::follow::critical_speeds;
    use super::super::quadratic::Eigensolver;
    use super::super::whirl::Lateral;
    use super::*;
    use bladeoff_model::machine::MachineDef;

    #[test]
    fn the_words_follow_from_shares_and_sizes() {
        let of = |orbits: &[[f64; 2]]| sense(orbits).0;
        assert_eq!(of(&[[0.9, 1.0], [0.8, 0.5]]), Whirl::Forward);
        assert_eq!(of(&[[-0.9, 1.0], [-0.1, 0.5]]), Whirl::Backward);
        assert_eq!(of(&[[0.17, 1.0], [-0.11, 1.0]]), Whirl::Mixed);
        assert_eq!(of(&[[0.004, 1.0], [-0.004, 1.0]]), Whirl::Planar);
        // a node with a small orbit does not count
        assert_eq!(of(&[[0.9, 1.0], [-0.9, 0.05]]), Whirl::Forward);
        // one orbit that is not quite a line, among larger straight orbits
        assert_eq!(of(&[[0.06, 0.2], [0.01, 1.0]]), Whirl::Planar);
        assert_eq!(sense(&[[0.0, 0.0]]), (Whirl::Planar, 0.0));
    }

    /// Shares along the shaft and critical speeds from an independent finite-element model (scipy eigenvalues), to two decimals.
    #[test]
    fn a_machine_whose_ends_disagree_has_the_shares_computed_elsewhere() {
        let text = include_str!("../../tests/data/two_discs_soft_end.toml");
        let machine = MachineDef::parse("m.toml", text).expect("valid").build().expect("valid");
        let (lateral, rpm) = (Lateral::new(&machine, Eigensolver::Own), std::f64::consts::PI / 30.0);
        let expected: [(f64, Whirl, [f64; 7], f64); 3] = [
            (1503.8, Whirl::Mixed, [0.17, 0.10, 0.05, 0.0, -0.04, -0.07, -0.11], 0.005),
            (1606.3, Whirl::Planar, [0.0; 7], 0.005),
            (1798.4, Whirl::Backward, [-0.73, -0.66, -0.51, -0.01, -0.17, -0.62, -0.77], 0.005),
        ];
        for ((speed, word, shares, off), critical) in
            expected.into_iter().zip(critical_speeds(&lateral).expect("solvable").whirl)
        {
            assert!((critical.speed / rpm - speed).abs() < 0.05, "{speed}: {}", critical.speed / rpm);
            assert_eq!(critical.whirl, word, "{speed}: {}", critical.share);
            assert!(critical.is_excited_by_unbalance());
            let near = |mode: &&Mode| (mode.value[1] - critical.speed).abs();
            let modes = lateral.spectrum(critical.speed).expect("solvable");
            let mode = modes.iter().min_by(|a, b| near(a).total_cmp(&near(b))).expect("modes");
            let found = orbits(mode, &lateral.rotor);
            assert_eq!(sense(&found), (word, critical.share));
            for (node, ([share, _], expected)) in found.iter().zip(shares).enumerate() {
                assert!((share - expected).abs() <= off, "{speed} rpm, node {node}: {share} {expected}");
            }
        }
    }

    #[test]
    fn a_backward_circle_is_not_excited_and_an_ellipse_is() {
        assert!(!excited_by_unbalance(-1.0) && !excited_by_unbalance(-1.0 + 1e-12));
        assert!([-0.77, 0.0, 1.0].into_iter().all(excited_by_unbalance));
    }
}
