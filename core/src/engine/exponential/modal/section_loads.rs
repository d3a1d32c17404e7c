//! What a look at the motion measures: bounds and moments of the shaft and the bearings' motion from the whirl states, energies from the motion (q, q').
//!
//! ```text
//! z = Z y = (q, q')
//! moments   of the shaft's elements at their ends: rows on y,     |M| <= sum over pairs of s_k |y_k|                                   (1)
//! reach     |x_i| <= sum over pairs of |Z_i| |y_k|
//! energy    q'^T M q'/2 + q^T K q/2 - w^T q  + W q'^T G q/2       lost   q'^T C q' + q'^T K_a q,   K_a the skew part of K             (2)
//! ```
//! s_k is the largest norm of the 2 x 2 matrices from y_k to the moments (XZ, YZ) of the ends that are bounded together: no moment is larger than (1), so a look takes
//! those moments alone whose bound is above what their section has had. Bearings' parts of `lost` are rank two each; what is left of it, of the shaft's structure, takes
//! all rates. All rows are linear between two stations, as Z is: a bound of each is one of what lies between.
//! Verified by `no_moment_is_beyond_its_bound`, `energies_of_coordinates_are_those_of_the_motion`, and the balances of `tests/exponential_run.rs`.

use super::displacement_bound::length;
use super::quadratic_form::QuadraticForm;
use super::row_batch::RowBatch;
use super::state_space::StateSpace;
use crate::linalg::lanes::{LANES, kernel};
use crate::linalg::{Matrix, dot, mul, mul_tn};
use crate::rotor::BearingSite;
use crate::stress::ShaftStresses;
use crate::structure::Structure;
use bladeoff_model::machine::{Machine, RotorKind};

/// Moments of one element: both planes at both ends.
const MOMENTS_PER_ELEMENT: usize = 4;
/// Elements whose moments are bounded, and taken, together.
pub(crate) const SECTIONS_AT_ONCE: usize = LANES / MOMENTS_PER_ELEMENT;
/// Room for the rounding of a bound's sum.
const ROUNDED_UP: f64 = 1.0 + 1e-12;

/// What is measured, in coordinates.
#[derive(Debug, Clone)]
pub(crate) struct SectionLoadModel {
    /// Moments in the planes XZ and YZ of each element at its two ends.
    moments: Matrix,
    /// Displacements of all nodes.
    nodal: Matrix,
    /// Bearings, rows on (q, q') of the velocities of their nodes, two each, then of the places of those that have skew stiffness, two each.
    bearings: Vec<BearingSite>,
    skew: Vec<usize>,
    sites: Matrix,
    /// What impulses along the axes of the first diaphragm's node make of those rows at once.
    site_jumps: [Vec<f64>; 2],
    energies: EnergyForms,
}

/// Forms of (2) on q or q'.
#[derive(Debug, Clone)]
struct EnergyForms {
    mass: QuadraticForm,
    stiffness: QuadraticForm,
    gyroscopic: RowBatch,
    weight: Vec<f64>,
}

/// Energies of a motion: (2) without the gyroscopic part \[J\], and the gyroscopic momentum \[kg m2/s\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct StoredEnergy {
    pub energy: f64,
    pub gyroscopic: f64,
}

/// What is seen of whirl states: rows on y at one station, or between two.
#[derive(Debug, Clone)]
pub(crate) struct SectionLoads {
    /// Eights on |y_k|: (1) of each [`BESIDE`] elements, then the reach.
    pub bounds: RowBatch,
    /// Those of [`Measures`] on the bearings' motion.
    pub bearings: RowBatch,
    pub moments: RowBatch,
    /// Z: of q and of q'.
    pub motion: [RowBatch; 2],
}

impl SectionLoadModel {
    /// Of a machine whose weight in coordinates is given.
    pub fn new(machine: &Machine, structure: &Structure, system: &StateSpace, weight: &[f64]) -> Self {
        let (rotor, map) = (&structure.rotor, &structure.lateral.coordinates);
        let mut nodal = Matrix::zeros(map.nodal_size(), map.size());
        for (j, mut column) in nodal.column_iter_mut().enumerate() {
            let mut unit = vec![0.0; map.size()];
            unit[j] = 1.0;
            map.expand(&unit, column.as_mut_slice());
        }
        let moments = match &machine.rotor.kind {
            RotorKind::PointMass(_) => Matrix::zeros(0, map.size()),
            RotorKind::Shaft(shaft) => {
                let stresses = ShaftStresses::new(shaft);
                let of = |column: &[f64]| -> Vec<f64> {
                    (0..shaft.elements.len())
                        .flat_map(|element| stresses.bending_moments(element, column))
                        .flatten()
                        .collect()
                };
                let columns: Vec<f64> = nodal.column_iter().flat_map(|column| of(column.as_slice())).collect();
                Matrix::from_column_slice(MOMENTS_PER_ELEMENT * shaft.elements.len(), map.size(), &columns)
            }
        };
        let skew: Vec<usize> = (0..rotor.bearings.len()).filter(|&i| rotor.bearings[i].skew != 0.0).collect();
        let jumps = match machine.diaphragms.first() {
            Some(diaphragm) => rotor.plane_places(diaphragm.contact.node).map(|dof| system.state_jump(&map.row(dof))),
            None => [vec![0.0; map.size()], vec![0.0; map.size()]],
        };
        let sites = sites(structure, &skew);
        let site_jumps = jumps.each_ref().map(|jump| {
            let rates = [vec![0.0; map.size()].as_slice(), jump].concat();
            sites.row_iter().map(|row| row.iter().zip(&rates).map(|(part, rate)| part * rate).sum()).collect()
        });
        Self {
            moments,
            nodal,
            bearings: rotor.bearings.clone(),
            skew,
            sites,
            site_jumps,
            energies: EnergyForms::new(system, weight),
        }
    }

    /// Of whirl states with this Z.
    pub fn at_basis(&self, motion: &Matrix) -> SectionLoads {
        let half = motion.nrows() / 2;
        let [places, rates] = [0, half].map(|from| motion.rows(from, half).into_owned());
        let moments = mul(&self.moments, &places);
        SectionLoads {
            bounds: RowBatch::new(&self.bounds(&moments, &mul(&self.nodal, &places))),
            bearings: RowBatch::new(&mul(&self.sites, motion)),
            moments: RowBatch::new(&moments),
            motion: [RowBatch::new(&places), RowBatch::new(&rates)],
        }
    }

    /// The matrix of (2) of what damping takes, of whirl states with this Z.
    pub fn damping_power_matrix(&self, system: &StateSpace, motion: &Matrix) -> Matrix {
        let n = system.size;
        let [places, rates] = [0, n].map(|from| motion.rows(from, n).into_owned());
        let stiffness = system.energy_matrices()[0];
        let skew = (stiffness - stiffness.transpose()) * 0.5;
        mul_tn(&rates, &(mul(&system.damping, &rates) + mul(&skew, &places)))
    }

    /// Eights of bounds, of moments and displacements by y.
    fn bounds(&self, moments: &Matrix, nodal: &Matrix) -> Matrix {
        let (pairs, ends) = (nodal.ncols() / 2, moments.nrows() / 2);
        let together = 2 * SECTIONS_AT_ONCE;
        let blocks = ends.div_ceil(together);
        Matrix::from_fn(blocks + 1, pairs, |block, k| {
            let most = |all: &mut dyn Iterator<Item = f64>| all.fold(0.0, f64::max);
            ROUNDED_UP
                * if block < blocks {
                    let end = |i: usize| {
                        let at = |row: usize, column: usize| moments[(2 * i + row, k + column * pairs)];
                        largest_stretch([at(0, 0), at(0, 1), at(1, 0), at(1, 1)])
                    };
                    most(&mut (block * together..ends.min((block + 1) * together)).map(end))
                } else {
                    most(&mut (0..nodal.nrows()).map(|i| length([nodal[(i, k)], nodal[(i, pairs + k)]])))
                }
        })
    }

    /// Powers that bearings' damping takes and that skew stiffness puts in \[W\], of their motion by [`Measured::bearings`] and the impulse there:
    /// damping acts between the velocities before and after it.
    pub fn bearing_powers(&self, motion: &[f64], struck: [f64; 2]) -> [f64; 2] {
        let velocity = |i: usize| {
            [2 * i, 2 * i + 1].map(|row| {
                motion[row] + 0.5 * (self.site_jumps[0][row] * struck[0] + self.site_jumps[1][row] * struck[1])
            })
        };
        let taken = self.bearings.iter().enumerate().map(|(i, bearing)| bearing.damping_power(velocity(i))).sum();
        let put_in = |(at, &i): (usize, &usize)| {
            let (row, v) = (2 * (self.bearings.len() + at), velocity(i));
            let force = self.bearings[i].skew_force([motion[row], motion[row + 1]]);
            force[0] * v[0] + force[1] * v[1]
        };
        [taken, self.skew.iter().enumerate().map(put_in).sum()]
    }

    /// Energies of a motion: q and q' with zeros behind them.
    pub fn stored_energy(&self, [q, rates]: [&[f64]; 2], room: &mut Vec<f64>) -> StoredEnergy {
        let EnergyForms { mass, stiffness, gyroscopic, weight, .. } = &self.energies;
        let q = &q[..weight.len()];
        gyroscopic.multiply(q, room);
        StoredEnergy {
            energy: 0.5 * (mass.value(rates) + stiffness.value(q)) - dot(weight, q),
            gyroscopic: 0.5 * dot(rates, room),
        }
    }
}

impl EnergyForms {
    fn new(system: &StateSpace, weight: &[f64]) -> Self {
        let [stiffness, mass] = system.energy_matrices();
        Self {
            mass: QuadraticForm::new(mass),
            stiffness: QuadraticForm::new(stiffness),
            gyroscopic: RowBatch::new(&system.gyroscopic),
            weight: weight.to_vec(),
        }
    }
}

/// Eights on (q, q') of the velocities of all bearings' nodes, and of the places of some.
fn sites(structure: &Structure, placed: &[usize]) -> Matrix {
    let (rotor, map) = (&structure.rotor, &structure.lateral.coordinates);
    let n = map.size();
    let mut rows = Matrix::zeros(2 * (rotor.bearings.len() + placed.len()), 2 * n);
    let of = (0..rotor.bearings.len()).map(|i| (i, n)).chain(placed.iter().map(|&i| (i, 0)));
    for (at, (i, from)) in of.enumerate() {
        for (axis, dof) in rotor.plane_places(rotor.bearings[i].node).into_iter().enumerate() {
            for (j, part) in map.row(dof).into_iter().enumerate() {
                rows[(2 * at + axis, from + j)] = part;
            }
        }
    }
    rows
}

/// The largest singular value of a 2 x 2 matrix, by rows.
fn largest_stretch([a, b, c, d]: [f64; 4]) -> f64 {
    let (sum, difference) = (a * a + b * b + c * c + d * d, a * a + b * b - c * c - d * d);
    (0.5 * (sum + length([difference, 2.0 * (a * c + b * d)]))).sqrt()
}

kernel! {
    /// Sizes of vectors whose parts are in two lists.
    pub(crate) fn sizes_of(a: &[f64], b: &[f64], sizes: &mut [f64]) {
        for (size, (a, b)) in sizes.iter_mut().zip(a.iter().zip(b)) {
            *size = (a * a + b * b).sqrt();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::dissipation::DissipationBuffer;
    use super::*;
    use crate::engine::exponential::observe::nodal_motion::NodalMotion;
    use crate::engine::exponential::settings::StepSettings;
    use crate::engine::exponential::stepping::free_motion::FreeMotion;
    use crate::engine::exponential::torsion::spin::ContactImpulse;
    use bladeoff_model::machine::MachineDef;
    use std::sync::Arc;

    /// The rig with one bearing of skew stiffness, in free flight, struck time and again.
    fn struck(mut at: impl FnMut(&Machine, &Structure, &mut FreeMotion, [f64; 2])) {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let text = text.replacen("\"2e6 N/m\"", "[[2e6, 3e5], [-1e5, 1.7e6]]", 1);
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let mut flight = FreeMotion::new(&machine, &structure, StepSettings::of_step(2e-5)).expect("has a basis");
        for round in 0..40 {
            let impulse = [0.3 * f64::from(round).sin(), 0.2 * f64::from(round).cos()];
            flight.propagate(0).expect("goes on");
            flight.complete_step(0, Some(ContactImpulse { impulse, torque: 1e-3 })).expect("goes on");
            at(&machine, &structure, &mut flight, impulse);
            (0..30).for_each(|_| flight.advance(1).expect("goes on"));
        }
    }

    #[test]
    fn no_moment_is_beyond_its_bound() {
        let (mut bounds, mut closest) = (Vec::new(), 0.0_f64);
        struck(|machine, structure, flight, _| {
            let RotorKind::Shaft(shaft) = &machine.rotor.kind else { panic!("the rig has a shaft") };
            let stresses = ShaftStresses::new(shaft);
            let mut shape = NodalMotion::new(structure, flight.spin(), 2e-5);
            shape.take(flight, structure);
            flight.moment_bounds(&mut bounds);
            let blocks = shaft.elements.len().div_ceil(SECTIONS_AT_ONCE);
            let largest = shape.nodal.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            assert!(largest <= bounds[blocks], "{largest} {}", bounds[blocks]);
            let whole = bounds[..blocks].iter().copied().fold(0.0, f64::max);
            for element in 0..shaft.elements.len() {
                let seen = flight.moments(element / SECTIONS_AT_ONCE);
                let seen = &seen[MOMENTS_PER_ELEMENT * (element % SECTIONS_AT_ONCE)..];
                for (end, moment) in stresses.bending_moments(element, &shape.nodal).into_iter().enumerate() {
                    let (size, bound) = (length(moment), bounds[element / SECTIONS_AT_ONCE]);
                    assert!(size <= bound, "element {element}: {size} beyond {bound}");
                    closest = closest.max(size / bound);
                    for (i, part) in moment.into_iter().enumerate() {
                        let off = (seen[2 * end + i] - part).abs();
                        assert!(off < 1e-11 * whole, "element {element}: {off} of {whole}");
                    }
                }
            }
        });
        // struck a step ago, pairs are in every phase
        assert!(closest > 0.2, "the bound says something: {closest}");
    }

    #[test]
    fn energies_of_coordinates_are_those_of_the_motion() {
        let (mut q, mut rates, mut room) = (Vec::new(), Vec::new(), Vec::new());
        struck(|machine, structure, flight, impulse| {
            let (n, spin) = (structure.lateral.coordinates.size(), flight.spin().speed);
            flight.lateral_rates(&mut rates);
            let stored = flight.stored_energy(&rates, &mut q, &mut room);
            let shared = Arc::clone(flight.shared());
            let system = &shared.grid.model.state_space;
            let [kinetic, strain] = system.kinetic_and_elastic_energy(spin, &q[..n], &rates[..n]);
            let weight: f64 = dot(shared.grid.model.outputs.weight(), &q[..n]);
            let (ours, theirs) = (stored.energy + spin * stored.gyroscopic, kinetic + strain - weight);
            assert!((ours - theirs).abs() < 1e-12 * (kinetic + strain), "{ours} {theirs}");
            // and what is taken of the mean rates, part by part, is that of bearings' damping and of the skew part of K
            let (mut instant, mut within) = (flight.instant(), DissipationBuffer::default());
            let ([bearings, skew], _) =
                flight.damping_powers_after(&mut instant, impulse, false, (&mut room, &mut within));
            let measures = &shared.grid.model.measures;
            let jumps = structure.rotor.plane_places(machine.diaphragms[0].contact.node);
            let jumps = jumps.map(|dof| system.state_jump(&structure.lateral.coordinates.row(dof)));
            let mean: Vec<f64> =
                (0..n).map(|j| rates[j] + 0.5 * (jumps[0][j] * impulse[0] + jumps[1][j] * impulse[1])).collect();
            let mut taken = [0.0; 2];
            for bearing in &measures.bearings {
                let rows = structure.rotor.plane_places(bearing.node).map(|dof| structure.lateral.coordinates.row(dof));
                let [v, x] = [&mean, &q[..n].to_vec()].map(|part| rows.each_ref().map(|row| dot(row, part)));
                taken[0] += bearing.damping_power(v);
                taken[1] += dot(&bearing.skew_force(x), &v);
            }
            for (found, wanted) in [bearings, skew].into_iter().zip(taken) {
                assert!((found - wanted).abs() < 1e-11 * (bearings.abs() + skew.abs()), "{found} {wanted}");
            }
        });
    }
}
