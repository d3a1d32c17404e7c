//! Section loads and other observations of the lateral motion: bending moments with their bounds, bearing powers, displacements and stored energy.
//!
//! ```text
//! z = Z y = (q, q')                                                    motion
//! moments        of the shaft elements at their ends: rows on y,     |M| <= sum over planes of s_k |y_k|                              (1)
//! displacements  |x_i| <= sum over planes of |Z_i| |y_k|
//! energy         q'^T M q'/2 + q^T K q/2 - w^T q  + W q'^T G q/2      stored
//! lost           q'^T C q' + q'^T K_a q                               power of the damping; K_a: skew part of K                       (2)
//! ```
//! `y`: modal state; `s_k`: largest 2-norm of the 2 x 2 matrices from y_k to the moments (XZ, YZ) of the element ends that are bounded together; `w`: weight.
//!
//! No moment exceeds (1). An observation therefore computes only the moments whose bound exceeds the largest moment of their section so far.
//! The part of a bearing in `lost` has rank two; the part of the shaft's own damping needs all velocities. All rows are linear between two modal bases, as Z is,
//! so the interpolation of two bounds is a bound of the interpolated rows.
//! Verified by `no_moment_exceeds_its_bound`, `stored_energy_and_bearing_powers_are_those_of_the_motion`, and the energy balances of `tests/exponential/exponential_run.rs`.

use super::bearing_tables::TableChanges;
use super::quadratic_form::QuadraticForm;
use super::row_batch::RowBatch;
use super::state_space::StateSpace;
use crate::engine::exponential::plane::length;
use crate::rotor::BearingSite;
use crate::stress::ShaftStresses;
use crate::structure::Structure;
use bladeoff_model::machine::{Machine, RotorKind};
use bladeoff_numerics::linalg::lanes::{LANES, kernel};
use bladeoff_numerics::linalg::{Matrix, dot, mul, mul_tn};

/// Bending moments of one shaft element: in both planes at both ends.
const MOMENTS_PER_ELEMENT: usize = 4;
/// Shaft elements whose moments are bounded and computed together.
pub(crate) const SECTIONS_AT_ONCE: usize = LANES / MOMENTS_PER_ELEMENT;
/// Margin of a bound for the rounding of its sum.
const ROUNDING_MARGIN: f64 = 1.0 + 1e-12;

/// Observed quantities of a machine, as rows and forms on the lateral coordinates.
#[derive(Debug, Clone)]
pub(crate) struct SectionLoadModel {
    /// Rows on q: bending moments in the planes XZ and YZ of each element at its two ends \[N m\].
    moments: Matrix,
    /// Rows on q: displacements and rotations of all nodes \[m, rad\].
    nodal: Matrix,
    /// Bearings, with the constant parts of their tables, then pedestals.
    bearings: Vec<BearingSite>,
    /// Indices of the bearings with skew stiffness or a table.
    skew: Vec<usize>,
    /// Index of each bearing with a table, and its place in `skew`.
    tables: Vec<[usize; 2]>,
    /// Rows on (q, q'): velocities across all bearings and pedestals, then displacements across those with skew stiffness, two each.
    bearing_rows: Matrix,
    /// Jump of these rows by unit impulses along u and v on each diaphragm's node.
    impulse_jumps: Vec<[Vec<f64>; 2]>,
    energies: EnergyForms,
}

/// Matrices of the energy in (2), on q or q'.
#[derive(Debug, Clone)]
struct EnergyForms {
    /// M, on q'.
    mass: QuadraticForm,
    /// K, on q.
    stiffness: QuadraticForm,
    /// Rows of G, on q.
    gyroscopic: RowBatch,
    /// Weight in the coordinates.
    weight: Vec<f64>,
}

/// Stored energy of a motion by (2).
#[derive(Debug, Clone, Copy)]
pub(crate) struct StoredEnergy {
    /// Kinetic, strain and gravity energy without the gyroscopic part \[J\].
    pub energy: f64,
    /// Gyroscopic momentum `q'^T G q/2` \[kg m2/s\].
    pub gyroscopic: f64,
}

/// Rows on the modal state at one modal basis, for observations.
#[derive(Debug, Clone)]
pub(crate) struct SectionLoads {
    /// Rows on |y_k|: bound (1) of each [`SECTIONS_AT_ONCE`] elements \[N m\], then the bound of all displacements.
    pub bounds: RowBatch,
    /// Velocities across bearings and pedestals, then displacements across those with skew stiffness.
    pub bearings: RowBatch,
    /// Bending moments \[N m\].
    pub moments: RowBatch,
    /// Z: rows of q and of q'.
    pub motion: [RowBatch; 2],
}

impl SectionLoadModel {
    /// Observed quantities of a machine; `weight`: its weight in the lateral coordinates.
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
                let moments_of = |column: &[f64]| -> Vec<f64> {
                    (0..shaft.elements.len())
                        .flat_map(|element| stresses.bending_moments(element, column))
                        .flatten()
                        .collect()
                };
                let columns: Vec<f64> = nodal.column_iter().flat_map(|column| moments_of(column.as_slice())).collect();
                Matrix::from_column_slice(MOMENTS_PER_ELEMENT * shaft.elements.len(), map.size(), &columns)
            }
        };
        let has_table = |i: usize| rotor.tables.iter().any(|(at, _)| *at == i);
        let skew: Vec<usize> =
            (0..rotor.bearings.len()).filter(|&i| rotor.bearings[i].skew != 0.0 || has_table(i)).collect();
        let tables = rotor.tables.iter().filter_map(|(i, _)| Some([*i, skew.iter().position(|at| at == i)?])).collect();
        let bearing_rows = bearing_motion_rows(structure, &skew);
        let jumps_of = |dof: usize| -> Vec<f64> {
            let velocities = [vec![0.0; map.size()], system.velocity_jump(&map.row(dof))].concat();
            bearing_rows
                .row_iter()
                .map(|row| row.iter().zip(&velocities).map(|(entry, velocity)| entry * velocity).sum())
                .collect()
        };
        let nodes = machine.diaphragms.iter().map(|diaphragm| diaphragm.contact.node);
        let impulse_jumps = nodes.map(|node| rotor.plane_places(node).map(jumps_of)).collect();
        Self {
            moments,
            nodal,
            bearings: rotor.supports().copied().collect(),
            skew,
            tables,
            bearing_rows,
            impulse_jumps,
            energies: EnergyForms::new(system, weight),
        }
    }

    /// Rows on the modal state of a basis with the motion matrix Z.
    pub fn at_basis(&self, motion: &Matrix) -> SectionLoads {
        let half = motion.nrows() / 2;
        let [displacements, velocities] = [0, half].map(|from| motion.rows(from, half).into_owned());
        let moments = mul(&self.moments, &displacements);
        SectionLoads {
            bounds: RowBatch::new(&self.bounds(&moments, &mul(&self.nodal, &displacements))),
            bearings: RowBatch::new(&mul(&self.bearing_rows, motion)),
            moments: RowBatch::new(&moments),
            motion: [RowBatch::new(&displacements), RowBatch::new(&velocities)],
        }
    }

    /// Matrix of the quadratic form `lost` of (2) \[W\] on the modal state of a basis at a spin \[rad/s\] with the motion matrix Z.
    pub fn damping_power_matrix(&self, system: &StateSpace, spin: f64, motion: &Matrix) -> Matrix {
        let n = system.size;
        let [displacements, velocities] = [0, n].map(|from| motion.rows(from, n).into_owned());
        let stiffness = system.stiffness_at(spin);
        let skew = (&*stiffness - stiffness.transpose()) * 0.5;
        mul_tn(&velocities, &(mul(&system.damping_at(spin), &velocities) + mul(&skew, &displacements)))
    }

    /// Bounds on |y_k| of the given rows of moments and nodal displacements on y.
    fn bounds(&self, moments: &Matrix, nodal: &Matrix) -> Matrix {
        let (planes, ends) = (nodal.ncols() / 2, moments.nrows() / 2);
        let ends_at_once = 2 * SECTIONS_AT_ONCE;
        let blocks = ends.div_ceil(ends_at_once);
        Matrix::from_fn(blocks + 1, planes, |block, k| {
            let largest = |all: &mut dyn Iterator<Item = f64>| all.fold(0.0, f64::max);
            ROUNDING_MARGIN
                * if block < blocks {
                    let end = |i: usize| {
                        let at = |row: usize, column: usize| moments[(2 * i + row, k + column * planes)];
                        largest_singular_value([at(0, 0), at(0, 1), at(1, 0), at(1, 1)])
                    };
                    largest(&mut (block * ends_at_once..ends.min((block + 1) * ends_at_once)).map(end))
                } else {
                    largest(&mut (0..nodal.nrows()).map(|i| length([nodal[(i, k)], nodal[(i, planes + k)]])))
                }
        })
    }

    /// Powers \[W\]: dissipated by the damping of the bearings, and supplied by their skew stiffness.
    ///
    /// `motion`: bearing motion of [`SectionLoads::bearings`]; `impulses`: contact impulses at this instant by diaphragm \[N s\], with the mean of the velocities before and after them;
    /// `changes`: those of the bearing tables in the speed interval.
    pub fn bearing_powers(
        &self,
        motion: &[f64],
        impulses: impl Iterator<Item = (usize, [f64; 2])> + Clone,
        changes: &TableChanges,
    ) -> [f64; 2] {
        let velocity = |i: usize| {
            let mut velocity = [motion[2 * i], motion[2 * i + 1]];
            for (diaphragm, [u, v]) in impulses.clone() {
                let [along_u, along_v] = &self.impulse_jumps[diaphragm];
                (0..2).for_each(|k| velocity[k] += 0.5 * (along_u[2 * i + k] * u + along_v[2 * i + k] * v));
            }
            velocity
        };
        let dissipated: f64 =
            self.bearings.iter().enumerate().map(|(i, bearing)| bearing.damping_power(velocity(i))).sum();
        let supplied = |bearing: &BearingSite, at: usize, i: usize| {
            let v = velocity(i);
            let force = bearing.skew_force(self.displacement(motion, at));
            force[0] * v[0] + force[1] * v[1]
        };
        let all = self.skew.iter().enumerate();
        let mut powers = [dissipated, all.map(|(at, &i)| supplied(&self.bearings[i], at, i)).sum()];
        for (change, &[i, at]) in changes.iter().zip(&self.tables) {
            powers[0] += change.damping_power(velocity(i));
            powers[1] += supplied(change, at, i);
        }
        powers
    }

    /// Displacement across the bearing at a place in `skew`, from the bearing motion.
    fn displacement(&self, motion: &[f64], at: usize) -> [f64; 2] {
        let row = 2 * (self.bearings.len() + at);
        [motion[row], motion[row + 1]]
    }

    /// Work of the bearing tables from one speed interval to the next, with their changes in both, at a bearing motion ([`super::bearing_tables`]) \[J\].
    pub fn table_work(&self, motion: &[f64], [from, to]: [&TableChanges; 2]) -> f64 {
        let work = |((from, to), &[_, at]): ((&BearingSite, &BearingSite), &[usize; 2])| {
            let x = self.displacement(motion, at);
            0.5 * (to.stiffness_form(x, x) - from.stiffness_form(x, x))
        };
        from.iter().zip(to).zip(&self.tables).map(work).sum()
    }

    /// Stored energy of a motion q and q', each with zeros behind its entries; `scratch`: buffer.
    pub fn stored_energy(&self, [q, velocities]: [&[f64]; 2], scratch: &mut Vec<f64>) -> StoredEnergy {
        let EnergyForms { mass, stiffness, gyroscopic, weight, .. } = &self.energies;
        let q = &q[..weight.len()];
        gyroscopic.multiply(q, scratch);
        StoredEnergy {
            energy: 0.5 * (mass.value(velocities) + stiffness.value(q)) - dot(weight, q),
            gyroscopic: 0.5 * dot(velocities, scratch),
        }
    }
}

impl EnergyForms {
    /// Energy matrices of the system.
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

/// Rows on (q, q') of the velocities across all bearings and pedestals and of the displacements across those in `skew`, two each.
fn bearing_motion_rows(structure: &Structure, skew: &[usize]) -> Matrix {
    let (rotor, map) = (&structure.rotor, &structure.lateral.coordinates);
    let (n, supports) = (map.size(), rotor.supports().count());
    let mut rows = Matrix::zeros(2 * (supports + skew.len()), 2 * n);
    let velocities = rotor.supports().map(|site| (site, n));
    let columns = velocities.chain(skew.iter().map(|&i| (&rotor.bearings[i], 0)));
    for (at, (site, from)) in columns.enumerate() {
        for (axis, row) in site.rows(|place| map.row(place)).into_iter().enumerate() {
            for (j, part) in row.into_iter().enumerate() {
                rows[(2 * at + axis, from + j)] = part;
            }
        }
    }
    rows
}

/// Largest singular value of a 2 x 2 matrix, by rows.
fn largest_singular_value([a, b, c, d]: [f64; 4]) -> f64 {
    let (sum, difference) = (a * a + b * b + c * c + d * d, a * a + b * b - c * c - d * d);
    (0.5 * (sum + length([difference, 2.0 * (a * c + b * d)]))).sqrt()
}

kernel! {
    /// Lengths of plane vectors whose components are in two lists.
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

    /// Lab rig with one bearing of skew stiffness in free motion, with an impulse every 30 steps, after which `observe` is called.
    fn for_each_impulse(mut observe: impl FnMut(&Machine, &Structure, &mut FreeMotion, [f64; 2])) {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let text = text.replacen("\"2e6 N/m\"", "[[2e6, 3e5], [-1e5, 1.7e6]]", 1);
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let mut free_motion = FreeMotion::new(&machine, &structure, StepSettings::of_step(2e-5)).expect("has a basis");
        for round in 0..40 {
            let impulse = [0.3 * f64::from(round).sin(), 0.2 * f64::from(round).cos()];
            free_motion.propagate(0).expect("goes on");
            let contact = ContactImpulse { impulse, torque: 1e-3, ..ContactImpulse::default() };
            free_motion.complete_step(0, &[contact]).expect("goes on");
            observe(&machine, &structure, &mut free_motion, impulse);
            (0..30).for_each(|_| free_motion.advance(1).expect("goes on"));
        }
    }

    #[test]
    fn no_moment_exceeds_its_bound() {
        let (mut bounds, mut closest) = (Vec::new(), 0.0_f64);
        for_each_impulse(|machine, structure, free_motion, _| {
            let RotorKind::Shaft(shaft) = &machine.rotor.kind else { panic!("the rig has a shaft") };
            let stresses = ShaftStresses::new(shaft);
            let mut nodal_motion = NodalMotion::new(structure, free_motion.spin(), 2e-5);
            nodal_motion.take(free_motion, structure);
            free_motion.moment_bounds(&mut bounds);
            let blocks = shaft.elements.len().div_ceil(SECTIONS_AT_ONCE);
            let largest = nodal_motion.nodal.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
            assert!(largest <= bounds[blocks], "{largest} {}", bounds[blocks]);
            let largest_bound = bounds[..blocks].iter().copied().fold(0.0, f64::max);
            for element in 0..shaft.elements.len() {
                let (rows, modal_state) = free_motion.moment_rows();
                let moments = rows.multiply_block(element / SECTIONS_AT_ONCE, modal_state);
                let moments = &moments[MOMENTS_PER_ELEMENT * (element % SECTIONS_AT_ONCE)..];
                for (end, moment) in stresses.bending_moments(element, &nodal_motion.nodal).into_iter().enumerate() {
                    let (size, bound) = (length(moment), bounds[element / SECTIONS_AT_ONCE]);
                    assert!(size <= bound, "element {element}: {size} beyond {bound}");
                    closest = closest.max(size / bound);
                    for (i, part) in moment.into_iter().enumerate() {
                        let error = (moments[2 * end + i] - part).abs();
                        assert!(error < 1e-11 * largest_bound, "element {element}: {error} of {largest_bound}");
                    }
                }
            }
        });
        // one step after an impulse the planes have all phases
        assert!(closest > 0.2, "the bound is not far above the moments: {closest}");
    }

    #[test]
    fn stored_energy_and_bearing_powers_are_those_of_the_motion() {
        let (mut q, mut velocities, mut scratch) = (Vec::new(), Vec::new(), Vec::new());
        for_each_impulse(|machine, structure, free_motion, impulse| {
            let (n, spin) = (structure.lateral.coordinates.size(), free_motion.spin().speed);
            free_motion.lateral_rates(&mut velocities);
            let stored = free_motion.stored_energy(&velocities, &mut q, &mut scratch);
            let shared = Arc::clone(free_motion.shared());
            let system = &shared.grid.model.state_space;
            let [kinetic, strain] = system.kinetic_and_elastic_energy(spin, &q[..n], &velocities[..n]);
            let weight: f64 = dot(shared.grid.model.outputs.weight(), &q[..n]);
            let (stored_sum, wanted_sum) = (stored.energy + spin * stored.gyroscopic, kinetic + strain - weight);
            assert!((stored_sum - wanted_sum).abs() < 1e-12 * (kinetic + strain), "{stored_sum} {wanted_sum}");
            // bearing powers at the mean velocities: sum over the bearings, one by one
            let impulses = [ContactImpulse { impulse, ..ContactImpulse::default() }];
            let (mut instant, mut buffer) = (free_motion.instant(), DissipationBuffer::default());
            let ([bearings, skew], _) =
                free_motion.damping_powers_after(&mut instant, &impulses, false, (&mut scratch, &mut buffer));
            let section_load_model = &shared.grid.model.measures;
            let jumps = structure.rotor.plane_places(machine.diaphragms[0].contact.node);
            let jumps = jumps.map(|dof| system.velocity_jump(&structure.lateral.coordinates.row(dof)));
            let mean: Vec<f64> =
                (0..n).map(|j| velocities[j] + 0.5 * (jumps[0][j] * impulse[0] + jumps[1][j] * impulse[1])).collect();
            let mut dissipated = [0.0; 2];
            for bearing in &section_load_model.bearings {
                let rows = bearing.rows(|place| structure.lateral.coordinates.row(place));
                let [v, x] = [&mean, &q[..n].to_vec()].map(|part| rows.each_ref().map(|row| dot(row, part)));
                dissipated[0] += bearing.damping_power(v);
                dissipated[1] += dot(&bearing.skew_force(x), &v);
            }
            for (found, wanted) in [bearings, skew].into_iter().zip(dissipated) {
                assert!((found - wanted).abs() < 1e-11 * (bearings.abs() + skew.abs()), "{found} {wanted}");
            }
        });
    }
}
