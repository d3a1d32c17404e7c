//! Mass matrices of a run: those of the structure, plus the constant inertia of its unbalances.

use crate::rotor::UnbalanceSite;
use crate::structure::Structure;
use bladeoff_model::machine::Machine;
use bladeoff_numerics::linalg::{Matrix, add_outer};

/// The unbalances of a machine at their nodes.
pub(crate) fn sites(machine: &Machine) -> Vec<UnbalanceSite> {
    machine.rotor.unbalances.iter().map(UnbalanceSite::new).collect()
}

/// Lateral and torsional mass matrices on the coordinates.
pub(crate) fn masses(structure: &Structure, unbalances: &[UnbalanceSite]) -> (Matrix, Matrix) {
    let (mut lateral, mut twist) = (structure.lateral.mass.clone(), structure.twist.mass.clone());
    for site in unbalances {
        for dof in structure.rotor.plane_places(site.node) {
            add_outer(&mut lateral, site.mass, &structure.lateral.coordinates.row(dof));
        }
        add_outer(&mut twist, site.mass * site.radius * site.radius, &structure.twist.coordinates.row(site.twist_node));
    }
    (lateral, twist)
}
