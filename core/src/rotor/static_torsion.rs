//! Static torsion of the free shaft line under a torque, which its inertia balances.
//!
//! ```text
//! K beta = e_k - s,  s . beta = 0        s = j/J_t: inertia weights of the mean spin                                   (1)
//! beta_{i+1} = beta_i - (1/k_i) sum_(l <= i) (e_k - s)_l                k_i: stiffness of element i                    (2)
//! ```
//! beta: torsion of the nodes beside the mean angle per torque at node k [rad/(N m)]. K has no inverse, because the shaft line can turn. The inertia of
//! all nodes balances the torque as in a uniform acceleration. (2) is (1) solved along the shaft: the torsional moment of an element is the sum of
//! the torques on its left. Of torques that add up to 0 the parts s cancel.
//!
//! Source: inertia relief of a free structure. Verified by `the_torsion_is_in_equilibrium`.

use super::RotorMatrices;
use bladeoff_numerics::linalg::dot;

impl RotorMatrices {
    /// Torsion (1) of all nodes per torque at a node [rad/(N m)].
    #[must_use]
    pub fn static_torsion(&self, node: usize) -> Vec<f64> {
        let (mut moment, mut angle, mut angles) = (0.0, 0.0, vec![0.0; self.nodes]);
        for i in 1..self.nodes {
            moment += if i - 1 == node { 1.0 } else { 0.0 } - self.spin_weights[i - 1];
            angle += moment / self.torsional_stiffness[(i - 1, i)];
            angles[i] = angle;
        }
        let mean = dot(&self.spin_weights, &angles);
        angles.iter_mut().for_each(|angle| *angle -= mean);
        angles
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;
    use bladeoff_numerics::linalg::mul_vec;

    #[test]
    fn the_torsion_is_in_equilibrium() {
        for name in ["lp_turbine_paper", "lab_rig"] {
            let path = format!("{}/../studies/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
            let text = std::fs::read_to_string(&path).expect("a machine of the repository");
            let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
            let rotor = RotorMatrices::assemble(&machine.rotor);
            for node in [0, 2, rotor.nodes - 1] {
                let angles = rotor.static_torsion(node);
                let mut torques = vec![0.0; rotor.nodes];
                mul_vec(&rotor.torsional_stiffness, &angles, &mut torques);
                for (i, torque) in torques.iter().enumerate() {
                    let wanted = if i == node { 1.0 } else { 0.0 } - rotor.spin_weights[i];
                    assert!((torque - wanted).abs() < 1e-9, "{name} {node} {i}: {torque} {wanted}");
                }
                assert!(dot(&rotor.spin_weights, &angles).abs() < 1e-12 * angles[0].abs());
            }
        }
    }
}
