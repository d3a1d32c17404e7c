//! What a look at the whole motion measures, straight from the whirl states: energy, what damping takes, bending moments.
//!
//! ```text
//! z = Z y = (q, q')
//! energy    q'^T M q'/2 + q^T K q/2 - w^T q  + W y^T N y          lost   q'^T C q' + q'^T K_a q,   K_a the skew part of K
//! moments   of the shaft's elements at their ends: rows on q       reach  |x_i| <= sum over pairs of |Z_i| |y|
//! ```
//! A form of y takes a fifth of the instructions of the motion of all nodes. Verified by the energy balances of `tests/exponential_run.rs`.

use super::bound::length;
use super::forms::{Form, Rows};
use super::system::LateralSystem;
use crate::linalg::{Matrix, mul, mul_tn};
use crate::stress::ShaftStresses;
use crate::structure::Structure;
use bladeoff_model::machine::{Machine, RotorKind};

/// What is measured, in coordinates.
#[derive(Debug, Clone)]
pub(super) struct Measures {
    weight: Vec<f64>,
    /// Moments in the planes XZ and YZ of each element at its two ends.
    moments: Matrix,
    /// Displacements of all nodes.
    nodal: Matrix,
}

/// The same of whirl states between two stations: at both, and of forms what goes with both.
#[derive(Debug)]
pub(super) struct Between {
    energy: [Form; 3],
    lost: [Form; 3],
    gravity: [Vec<f64>; 2],
    moments: [Rows; 2],
    reach: [Vec<f64>; 2],
}

/// The same of whirl states in one cell.
#[derive(Debug, Clone)]
pub(super) struct Measured {
    pub energy: Form,
    pub lost: Form,
    /// Of the weight.
    pub gravity: Vec<f64>,
    pub moments: Rows,
    /// For each pair, the largest displacement of any node per amplitude.
    reach: Vec<f64>,
}

impl Measures {
    /// Of a machine whose weight in coordinates is given.
    pub fn new(machine: &Machine, structure: &Structure, weight: &[f64]) -> Self {
        let map = &structure.lateral.coordinates;
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
                Matrix::from_column_slice(4 * shaft.elements.len(), map.size(), &columns)
            }
        };
        Self { weight: weight.to_vec(), moments, nodal }
    }

    /// Of whirl states between two stations with these Z.
    pub fn between(&self, system: &LateralSystem, stations: [&Matrix; 2]) -> Between {
        let n = system.size;
        let halves = stations.map(|motion| [motion.rows(0, n).into_owned(), motion.rows(n, n).into_owned()]);
        let [stiffness, mass] = system.stores();
        let skew = (stiffness - stiffness.transpose()) * 0.5;
        // A Z of each station, once
        let by = halves.each_ref().map(|[q, rates]| {
            let mut lost = mul(&system.damping, rates);
            if skew.amax() > 0.0 {
                lost += mul(&skew, q);
            }
            [mul(stiffness, q), mul(mass, rates), lost]
        });
        let energy = |one: usize, other: usize| {
            let ([q, rates], [by_q, by_rates, _]) = (&halves[one], &by[other]);
            (mul_tn(q, by_q) + mul_tn(rates, by_rates)) * 0.5
        };
        let lost = |one: usize, other: usize| mul_tn(&halves[one][1], &by[other][2]);
        let pairs = |of: &dyn Fn(usize, usize) -> Matrix| {
            [of(0, 0), of(0, 1) + of(1, 0), of(1, 1)].map(|matrix| Form::new(&matrix))
        };
        let weight = Matrix::from_column_slice(n, 1, &self.weight);
        Between {
            energy: pairs(&energy),
            lost: pairs(&lost),
            gravity: halves.each_ref().map(|[q, _]| mul_tn(q, &weight).as_slice().to_vec()),
            moments: halves.each_ref().map(|[q, _]| Rows::new(&mul(&self.moments, q))),
            reach: halves.each_ref().map(|[q, _]| self.reach(q)),
        }
    }

    /// For each pair, the largest displacement of any node per amplitude.
    fn reach(&self, q: &Matrix) -> Vec<f64> {
        let (pairs, nodal) = (q.nrows(), mul(&self.nodal, q));
        let of_pair = |k: usize| {
            let of = |i: usize| length([nodal[(i, k)], nodal[(i, pairs + k)]]);
            (0..nodal.nrows()).map(of).fold(0.0, f64::max)
        };
        (0..pairs).map(of_pair).collect()
    }
}

impl Between {
    /// At a share of the way: Z is linear in it, forms are of second order.
    pub fn at(&self, share: f64) -> Measured {
        let (rest, linear) = (1.0 - share, [1.0 - share, share]);
        let forms = |all: &[Form; 3]| Form::mixed(all.each_ref(), [rest * rest, rest * share, share * share]);
        let lists = |[below, above]: &[Vec<f64>; 2]| {
            below.iter().zip(above).map(|(below, above)| rest * below + share * above).collect()
        };
        Measured {
            energy: forms(&self.energy),
            lost: forms(&self.lost),
            gravity: lists(&self.gravity),
            moments: Rows::mixed(self.moments.each_ref(), linear),
            reach: lists(&self.reach),
        }
    }
}

impl Measured {
    /// No displacement of a node is larger than this \[m, rad\].
    pub fn reach(&self, y: &[f64]) -> f64 {
        let (a, b) = y.split_at(self.reach.len());
        self.reach.iter().zip(a.iter().zip(b)).map(|(reach, (a, b))| reach * length([*a, *b])).sum()
    }
}
