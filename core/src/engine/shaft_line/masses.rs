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
    let (mut lateral, mut torsion) = (structure.lateral.mass.clone(), structure.torsion.mass.clone());
    for site in unbalances {
        for dof in structure.rotor.plane_places(site.node) {
            add_outer(&mut lateral, site.mass, &structure.lateral.coordinates.row(dof));
        }
        add_outer(
            &mut torsion,
            site.mass * site.radius * site.radius,
            &structure.torsion.coordinates.row(site.torsional_node),
        );
    }
    (lateral, torsion)
}
