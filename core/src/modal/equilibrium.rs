//! Static equilibrium before a run: sag, and forces of bearings and pedestals, under gravity and with seats off the bearing line.
//!
//! ```text
//! (K + K_skew) q = w        w: weight of rotor, pedestals and residual unbalances, and forces of the seats
//! ```
//! This system also gives the initial state of a run (`engine::beginning`), there in the coordinates of the engine. Limits: the system does
//! not depend on the speed, so a spinning rotor on damped cross-coupled bearings has the same equilibrium. Verified by
//! `the_equilibrium_carries_the_weight`.

use super::unbalance::LinearRotor;
use crate::rotor::UnbalanceSite;
use bladeoff_model::machine::{Machine, Presence, RotorKind};
use bladeoff_numerics::linalg::{Vector, solve};

/// Static equilibrium of the rotor before a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// Largest displacement of a node from the bearing line \[m\].
    pub sag: f64,
    /// Axial position of that node \[m\]; `None` for a point mass.
    pub position: Option<f64>,
    /// Force on each bearing, in the machine's order \[N\].
    pub bearings: Vec<[f64; 2]>,
    /// Force of each pedestal on the ground, in the order of the bearings with a pedestal \[N\].
    pub pedestals: Vec<[f64; 2]>,
}

/// Returns the static equilibrium of a machine; `None` if no force acts or the rotor is not supported.
#[must_use]
pub fn equilibrium(machine: &Machine) -> Option<Equilibrium> {
    let rotor = LinearRotor::new(machine);
    let matrices = &rotor.matrices;
    let before = machine.rotor.unbalances.iter().filter(|unbalance| unbalance.presence == Presence::Before);
    let force = matrices.constant_force(&machine.rotor, &before.map(UnbalanceSite::new).collect::<Vec<_>>());
    if force.iter().all(|force| *force == 0.0) {
        return None;
    }
    let rest = solve(&rotor.stiffness, &Vector::from_vec(force))?;
    let place = |node: usize| matrices.at(node, rest.as_slice()).map(f64::abs);
    let sags = (0..matrices.nodes).map(|node| (node, libm::hypot(place(node)[0], place(node)[1])));
    let (node, sag) = sags.fold((0, 0.0), |largest, sag| if sag.1 > largest.1 { sag } else { largest });
    let load = |site: &crate::rotor::BearingSite| site.load(site.across(rest.as_slice()), [0.0; 2]);
    let bearings = matrices.bearings.iter().zip(matrices.seat_forces(&machine.rotor)).map(|(site, seat)| {
        let load = load(site);
        [load[0] - seat[0], load[1] - seat[1]]
    });
    Some(Equilibrium {
        sag,
        position: match &machine.rotor.kind {
            RotorKind::Shaft(shaft) => Some(shaft.nodes[node]),
            RotorKind::PointMass(_) => None,
        },
        bearings: bearings.collect(),
        pedestals: matrices.pedestals.iter().map(load).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    #[test]
    fn the_equilibrium_carries_the_weight() {
        let text = "schema = 1\nname = \"rest\"\n[rotor]\nkind = \"point-mass\"\nmass = 2.0\npolar_inertia = 1.0\n\
            initial_speed = 1.0\ngravity = [1.0, -10.0]\n[rotor.bearings.one]\nstiffness = 3e3\nelevation = [0.0, 1e-3]\n\
            [rotor.bearings.one.pedestal]\nmass = 4.0\nstiffness = 6e3\n[rotor.bearings.two]\nstiffness = 1e3\n[run]\nend_time = 1.0\n";
        let machine = MachineDef::parse("test.toml", text).expect("valid").build().expect("valid");
        let found = equilibrium(&machine).expect("held");
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()), "{a} {b}");
        for axis in 0..2 {
            // the bearings carry the rotor; the ground of the pedestal carries its bearing load and its own weight
            let g = [1.0, -10.0][axis];
            close(found.bearings[0][axis] + found.bearings[1][axis], 2.0 * g);
            close(found.pedestals[0][axis], found.bearings[0][axis] + 4.0 * g);
        }
        // 2000 N/m (bearing and pedestal in series) parallel to 1000 N/m; seat at 1 mm, minus the sag of the pedestal under its own weight
        let y = (-20.0 + 2e3 * (1e-3 - 40.0 / 6e3)) / 3e3;
        close(found.bearings[1][1], 1e3 * y);
        assert!(
            equilibrium(&{
                let mut free = machine.clone();
                free.rotor.gravity = [0.0; 2];
                free.rotor.bearings[0].elevation = [0.0; 2];
                free
            })
            .is_none()
        );
    }
}
