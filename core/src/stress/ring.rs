//! Membrane and bending stress of the diaphragm's ring.

use super::blades::BladeStresses;
use super::fibres::{Amplitudes, Bounds, Fibres, GROUPS, Pairs};
use super::force_columns::ForceColumns;
use crate::stator::NodalForces;
use crate::structure::{Coordinates, RingPart};
use bladeoff_model::machine::FlexibleStator;
use bladeoff_numerics::linalg::Matrix;
use std::sync::OnceLock;

/// Recovery of the stresses of a ring and its blades from the ring's coordinates and the contact forces on it.
///
/// ```text
/// sigma = E [(v/R + u,s) +- (h/2) (v/R^2 + v,ss)]        at the inner and the outer face; h radial thickness, R mean radius
/// ```
/// u: tangential displacement, v: radial displacement, s: arc length. The stress is evaluated at every node of the ring, where u,s and v,s
/// are degrees of freedom. v,ss of a node is the mean of the adjacent elements. A blade root introduces a moment into the ring, so the two
/// sides of its node are evaluated separately. Source: membrane strain and change of curvature in the element's own strain energy
/// (docs/theory/02-diaphragm.md); Timoshenko and Gere, Theory of Elastic Stability, art. 7.1. Deviation: none; the paper reports no
/// stresses.
///
/// # Units
/// SI; angles from blade 0, in the diaphragm's own axes.
/// # Limits
/// Nominal, planar, thin: no bending out of the plane, no torsion of the section, no stress concentration at a blade root. The bending
/// stress of a curved bar is included without its factor `R/(R +- h/2)`, with its term `M/(A R)`. Under a load inside an element of length
/// l, the bending moment is too small by up to `F l/8`. The truncated modes of a reduced engine respond statically to the contact forces
/// ([`ForceColumns`]).
/// # Verified by
/// `a_pinched_ring_has_timoshenko_s_stresses`, `tests/runs/stresses.rs`
#[derive(Debug, Clone)]
pub(crate) struct RingStresses {
    /// Pairs of ring modes with equal frequency.
    pairs: Pairs,
    /// Stresses at the nodes of the ring.
    ring: Fibres,
    /// Stresses of the blades; `None` without blades.
    blades: Option<BladeStresses>,
    /// Bounds of the stresses of the ring, of the blades, and of the bending stresses of the blades.
    bounds: Bounds,
    /// Node of each evaluated position (two faces per position).
    nodes: Vec<usize>,
    /// Angle between two nodes \[rad\].
    spacing: f64,
    amplitudes: Amplitudes,
    last: Last,
}

/// Coordinates and contact forces of the last evaluation.
#[derive(Debug, Clone)]
struct Last {
    /// Ring coordinates q.
    coordinates: Vec<f64>,
    /// Contact forces \[N\].
    forces: NodalForces,
    /// Bounds of the stresses by these contact forces \[Pa\].
    by_forces: [f64; GROUPS],
    /// Bounds of the stresses at the last evaluation \[Pa\]: ring, blades, bending of the blades.
    most: [f64; 3],
}

/// Rounding of a stress relative to the bound of its terms, for about a thousand terms.
const ROUNDING: f64 = 1e-12;

/// Stresses above which an evaluation is needed \[Pa\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known {
    /// Hoop plus bending stress of the ring.
    pub ring: f64,
    /// Axial plus bending stress of the blades.
    pub blades: f64,
    /// Bending stress of the blades.
    pub bending: f64,
}

/// Largest stresses of an instant \[Pa\]; `None` where a stress cannot exceed the known one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Largest {
    /// Hoop plus bending stress of the ring.
    pub ring: Option<f64>,
    /// Axial plus bending stress.
    pub blades: Option<f64>,
    /// Bending stress of the blades.
    pub bending: Option<f64>,
}

impl RingStresses {
    /// Stress recovery of a flexible stator, prepared once for all runs that share its part.
    pub fn of(stator: &FlexibleStator, part: &RingPart) -> Self {
        let kept: &OnceLock<Self> = part.stress_cache.get();
        kept.get_or_init(|| Self::new(stator, part)).clone()
    }

    /// Prepares the stress recovery of a flexible stator.
    pub fn new(stator: &FlexibleStator, part: &RingPart) -> Self {
        let coordinates = &part.part.coordinates;
        let pairs = Pairs::of(&part.part);
        let (columns, nodes) = columns_of(stator, coordinates);
        let nodal = part.residual.as_ref().map(|_| columns_of(stator, &Coordinates::nodal(part.matrices.size())).0);
        let by_forces = nodal.and_then(|nodal| ForceColumns::new(&nodal, part));
        let ring = Fibres::new(&columns, by_forces, &pairs, coordinates.shapes().is_some());
        let blades = BladeStresses::new(stator, part, &pairs);
        let bounds = match &blades {
            Some(blades) => Bounds::new(&[&ring, &blades.both, &blades.bending]),
            None => Bounds::new(&[&ring]),
        };
        let last = Last {
            coordinates: vec![0.0; coordinates.size()],
            forces: NodalForces::none(),
            by_forces: [0.0; GROUPS],
            most: [0.0; 3],
        };
        let spacing = 2.0 * std::f64::consts::PI / stator.ring.elements as f64;
        Self { ring, blades, bounds, pairs, nodes, spacing, amplitudes: Amplitudes::default(), last }
    }

    /// Returns whether the diaphragm has blades.
    pub fn has_blades(&self) -> bool {
        self.blades.is_some()
    }

    /// Returns the largest stresses for coordinates and contact forces, where the bounds allow a stress above the known one.
    ///
    /// The bounds also make a ring at rest cheap: its coordinates decay to subnormal numbers, whose products are slow.
    pub fn above(&mut self, known: &Known, q: &[f64], forces: &NodalForces) -> Largest {
        let Self { pairs, ring, blades, bounds, amplitudes, last, .. } = self;
        let far = bounds.of(pairs.distances(q, &last.coordinates, amplitudes));
        let by_forces = bounds.of_forces(forces.all().iter().copied());
        let far_by_forces = match forces.changes(&last.forces) {
            Some(changes) => bounds.of_forces(changes),
            None => std::array::from_fn(|group| by_forces[group] + last.by_forces[group]),
        };
        let known = [known.ring, known.blades, known.bending];
        let mut most = [0, 1, 2].map(|group| last.most[group] + (far[group] + far_by_forces[group]));
        if (0..3).all(|group| most[group] <= known[group]) {
            return Largest::default();
        }
        let whole = bounds.of(pairs.amplitudes(q, amplitudes));
        let whole = [0, 1, 2].map(|group| whole[group] + by_forces[group]);
        let mut of = |group: usize, fibres: Option<&mut Fibres>, may: bool| {
            most[group] = most[group].min(whole[group]);
            let found = fibres.filter(|_| may && most[group] > known[group]).map(|fibres| fibres.largest(q, forces));
            most[group] = found.unwrap_or(most[group]);
            found
        };
        let ring = of(0, Some(ring), true);
        let both = of(1, blades.as_mut().map(|blades| &mut blades.both), true);
        // the bending stress is at most the stress with the axial part
        let bends = both.is_none_or(|both| both > known[2]);
        let bending = of(2, blades.as_mut().map(|blades| &mut blades.bending), bends);
        last.coordinates.copy_from_slice(q);
        last.forces.clone_from(forces);
        last.by_forces = by_forces;
        last.most = [0, 1, 2].map(|group| most[group] + ROUNDING * whole[group]);
        Largest { ring, blades: both, bending }
    }

    /// Returns whether the stress bounds for coordinates, or for bounds of their amplitudes, are at most the known stresses.
    pub fn are_below(&mut self, known: &Known, q: &[f64]) -> bool {
        let [ring, blades, bending, ..] = self.bounds.of(self.pairs.amplitudes(q, &mut self.amplitudes));
        ring <= known.ring && blades <= known.blades && bending <= known.bending
    }

    /// Bounds of the stresses of ring and blades \[Pa\], for coordinates or for bounds of their amplitudes.
    pub fn bounds(&mut self, q: &[f64]) -> [f64; 2] {
        let [ring, blades, ..] = self.bounds.of(self.pairs.amplitudes(q, &mut self.amplitudes));
        [ring, blades]
    }

    /// Angular position \[rad\], in [0, 2 pi), of the largest ring stress found by [`RingStresses::above`].
    pub fn angle_of(&mut self, largest: f64, q: &[f64], forces: &NodalForces) -> f64 {
        self.nodes.get(self.ring.place_of(largest, q, forces) / 2).map_or(0.0, |&node| node as f64 * self.spacing)
    }

    /// Number of the blade, from 0, with the largest blade stress found by [`RingStresses::above`].
    pub fn blade_of(&mut self, largest: f64, q: &[f64], forces: &NodalForces) -> usize {
        self.blades.as_mut().map_or(0, |blades| {
            let place = blades.both.place_of(largest, q, forces);
            blades.blade_of(place)
        })
    }
}

/// Stress per unit coordinate, one column per face of each evaluated position, and the node of each position.
fn columns_of(stator: &FlexibleStator, coordinates: &Coordinates) -> (Matrix, Vec<usize>) {
    let size = coordinates.size();
    let (r, count) = (stator.ring.mean_radius, stator.ring.elements);
    let l = 2.0 * std::f64::consts::PI / count as f64 * r;
    let (young, half) = (stator.young_modulus, 0.5 * stator.ring.thickness);
    let bending = young * half;
    let row = |terms: &[(usize, f64)]| {
        let mut row = vec![0.0; size];
        terms.iter().for_each(|&(dof, factor)| coordinates.add_row(dof, factor, &mut row));
        row
    };
    // index of [u, u_s, v, v_s] of a node
    let at = |node: usize| 4 * (node % count);
    // bending stress from the second derivative of the cubic at a node, on the side towards the next node (1) or the previous one (-1),
    // times `share`
    let curved = |node: usize, side: f64, share: f64| {
        let other = at(if side > 0.0 { node + 1 } else { node + count - 1 });
        let (here, square, factor) = (at(node), l * l, share * bending);
        row(&[
            (here + 2, factor * (1.0 / (r * r) - 6.0 / square)),
            (here + 3, -side * factor * 4.0 / l),
            (other + 2, factor * 6.0 / square),
            (other + 3, -side * factor * 2.0 / l),
        ])
    };
    let feet = stator.blades.map_or(0, |blades| blades.count);
    let (mut entries, mut nodes) = (Vec::new(), Vec::new());
    for node in 0..count {
        let membrane = row(&[(at(node) + 1, young), (at(node) + 2, young / r)]);
        let bent = if feet > 0 && node % (count / feet) == 0 {
            vec![curved(node, -1.0, 1.0), curved(node, 1.0, 1.0)]
        } else {
            let (before, behind) = (curved(node, -1.0, 0.5), curved(node, 1.0, 0.5));
            vec![before.iter().zip(&behind).map(|(one, other)| one + other).collect()]
        };
        for bent in bent {
            nodes.push(node);
            entries.extend(membrane.iter().zip(&bent).map(|(membrane, bent)| membrane + bent));
            entries.extend(membrane.iter().zip(&bent).map(|(membrane, bent)| membrane - bent));
        }
    }
    (Matrix::from_column_slice(size, 2 * nodes.len(), &entries), nodes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stator::RingMatrices;
    use crate::structure::Part;
    use bladeoff_model::machine::{Blades, Rayleigh, Ring};
    use bladeoff_numerics::linalg::{Vector, solve};

    const R: f64 = 0.4;
    const H: f64 = 0.01;
    const WIDTH: f64 = 0.05;

    fn stator(elements: usize, blades: Option<Blades>) -> FlexibleStator {
        FlexibleStator {
            young_modulus: 2e11,
            poisson_ratio: 0.3,
            density: 7800.0,
            yield_strength: None,
            ring: Ring { mean_radius: R, thickness: H, width: WIDTH, elements },
            blades,
            damping: Rayleigh::default(),
        }
    }

    fn part(matrices: &RingMatrices, coordinates: Coordinates) -> RingPart {
        let part = Part {
            coordinates,
            mass: matrices.mass.clone(),
            damping: matrices.mass.clone(),
            stiffness: matrices.stiffness.clone(),
            modal: false,
            highest: 0.0,
        };
        RingPart {
            matrices: matrices.clone(),
            part,
            residual: None,
            truncation_errors: Vec::new(),
            engine_cache: Default::default(),
            stress_cache: Default::default(),
        }
    }

    /// A free ring compressed by two opposite forces P at nodes.
    fn pinched(matrices: &RingMatrices, force: f64) -> Vec<f64> {
        let (n, size) = (matrices.nodes, matrices.size());
        let mut loads = vec![0.0; size];
        loads[2] = -force;
        loads[4 * (n / 2) + 2] = -force;
        // restrained against rigid-body motion where the tangential displacement is zero by symmetry
        let held = [0, 4 * (n / 4), 4 * (n / 2)];
        let free: Vec<usize> = (0..size).filter(|i| !held.contains(i)).collect();
        let k = Matrix::from_fn(free.len(), free.len(), |i, j| matrices.stiffness[(free[i], free[j])]);
        let f = Vector::from_iterator(free.len(), free.iter().map(|&i| loads[i]));
        let solution = solve(&k, &f).expect("held");
        let mut field = vec![0.0; size];
        for (value, &i) in solution.iter().zip(&free) {
            field[i] = *value;
        }
        field
    }

    /// Timoshenko, Strength of Materials II: M = P R/pi and no hoop force under the loads; M = P R (1/2 - 1/pi) and a hoop force P/2 half
    /// way between. The mean line of a curved bar has the stress N/A + M/(A R) (Winkler), which is P/(pi A) everywhere.
    #[test]
    fn a_pinched_ring_has_timoshenko_s_stresses() {
        let force = 1000.0;
        let pi = std::f64::consts::PI;
        let modulus = WIDTH * H * H / 6.0;
        let hoop = force / pi / (WIDTH * H);
        let loaded = force * R / pi / modulus + hoop;
        let beside = force * R * (0.5 - 1.0 / pi) / modulus + hoop;
        let mut errors = Vec::new();
        for elements in [24, 48, 96] {
            let stator = stator(elements, None);
            let matrices = RingMatrices::assemble(&stator);
            let field = pinched(&matrices, force);
            let mut stresses = RingStresses::new(&stator, &part(&matrices, Coordinates::nodal(matrices.size())));
            let largest = stresses.above(&Known { ring: 0.0, blades: 0.0, bending: 0.0 }, &field, &NodalForces::none());
            let found = largest.ring.expect("a stress");
            assert_eq!((largest.blades, largest.bending), (None, None), "there are no blades");
            let angle = stresses.angle_of(found, &field, &NodalForces::none());
            assert!(angle == 0.0 || (angle - pi).abs() < 1e-12, "{angle}");
            let node = elements / 4;
            let here = stresses.ring.products(&field);
            let quarter = here[2 * node].abs().max(here[2 * node + 1].abs());
            errors.push([found / loaded - 1.0, quarter / beside - 1.0]);
            // the bound holds, and no stress exceeds it
            assert!(stresses.bounds(&field)[0] >= found);
            assert_eq!(
                stresses
                    .above(&Known { ring: found, blades: 0.0, bending: 0.0 }, &field, &NodalForces::none())
                    .ring
                    .filter(|s| *s > found),
                None
            );
        }
        println!("of the loads and half way between: {errors:?}");
        // the error is of second order in the element length
        assert!(errors[2].iter().all(|error| error.abs() < 2e-3), "{errors:?}");
        for pair in errors.windows(2) {
            let share = pair[1][1] / pair[0][1];
            assert!(share > 0.2 && share < 0.3, "{errors:?}");
        }
    }

    /// Coordinates rotate around the ring, grow, decay and jump, as in a run. Each maximum equals that of evaluations without stored
    /// bounds.
    #[test]
    fn looks_with_a_memory_find_the_same_maxima() {
        let stator = stator(24, None);
        let matrices = RingMatrices::assemble(&stator);
        let shapes = Matrix::from_fn(matrices.size(), 6, |i, j| {
            let angle = (i / 4) as f64 * std::f64::consts::PI / 12.0 * (2 + j / 2) as f64;
            let wave = if j % 2 == 0 { angle.cos() } else { angle.sin() };
            if i % 4 == 2 { wave } else { 0.0 }
        });
        let part = part(&matrices, Coordinates::modal(&shapes));
        let (mut ours, fresh) = (RingStresses::new(&stator, &part), RingStresses::new(&stator, &part));
        let (mut most, mut evaluated, mut raised) = (0.0_f64, 0, 0);
        for step in 0..4000 {
            let (turn, size) = (2e-3 * f64::from(step), 1e-4 * (1.5 + (4e-3 * f64::from(step)).sin()));
            let jump = if step % 500 == 0 { 1.3 } else { 1.0 };
            let q: Vec<f64> = (0..6)
                .map(|j| {
                    let angle = turn * f64::from(2 + j / 2);
                    size * jump / f64::from(1 + j / 2) * if j % 2 == 0 { angle.cos() } else { angle.sin() }
                })
                .collect();
            let known = Known { ring: most, blades: 0.0, bending: 0.0 };
            let found = ours.above(&known, &q, &NodalForces::none()).ring;
            let exact = fresh
                .clone()
                .above(&Known { ring: -1.0, blades: 0.0, bending: 0.0 }, &q, &NodalForces::none())
                .ring
                .expect("evaluated");
            if exact > most {
                assert_eq!(found.map(f64::to_bits), Some(exact.to_bits()), "step {step}");
                (most, raised) = (exact, raised + 1);
            }
            evaluated += usize::from(found.is_some());
        }
        assert!(raised > 50 && evaluated < 2000, "{raised} {evaluated}");
    }

    /// A blade of one element. Its root has the displacement of a cantilever, clamped at the casing, under a tip force F across and N
    /// along.
    #[test]
    fn a_blade_under_a_tip_load_has_both_stresses() {
        let blades = Blades { count: 4, length: 0.3, thickness: 0.02, width: 0.05, elements: 1 };
        let stator = stator(24, Some(blades));
        let matrices = RingMatrices::assemble(&stator);
        let (across, along, young, l) = (800.0, 5e4, 2e11, 0.3);
        let (area, inertia) = (0.05 * 0.02, 0.05 * 0.02f64.powi(3) / 12.0);
        let (t, slope) = (across * l * l * l / (3.0 * young * inertia), -across * l * l / (2.0 * young * inertia));
        let mut field = vec![0.0; matrices.size()];
        let foot = 4 * (2 * 24 / 4);
        field[foot] = t;
        field[foot + 2] = along * l / (young * area);
        field[foot + 3] = t / R - slope;
        let bends = across * l * 0.01 / inertia;
        let both = bends + along / area;
        let check = |stresses: &mut RingStresses, q: &[f64], factor: f64| {
            let largest = stresses.above(&Known { ring: 0.0, blades: 0.0, bending: 0.0 }, q, &NodalForces::none());
            let (found, bending) = (largest.blades.expect("both"), largest.bending.expect("bending"));
            assert!((found / (factor * both) - 1.0).abs() < 1e-9, "{found} {both}");
            assert!((bending / (factor * bends) - 1.0).abs() < 1e-9, "{bending} {bends}");
            assert_eq!(stresses.blade_of(found, q, &NodalForces::none()), 2);
            assert!(stresses.bounds(q)[1] >= found);
        };
        let nodal = part(&matrices, Coordinates::nodal(matrices.size()));
        check(&mut RingStresses::new(&stator, &nodal), &field, 1.0);
        let shapes = Matrix::from_fn(matrices.size(), 2, |i, j| if j == 0 { field[i] } else { 0.0 });
        check(&mut RingStresses::new(&stator, &part(&matrices, Coordinates::modal(&shapes))), &[2.0, 5.0], 2.0);
    }
}
