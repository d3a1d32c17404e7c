//! Tests of [`super`]: the steps of a run with contact.

use super::*;
use crate::engine::exponential::plane::length;
use bladeoff_model::machine::MachineDef;

#[test]
fn the_bound_of_the_way_is_one() {
    let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).expect("a machine of the repository");
    let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
    let structure = Structure::build(&machine, None).expect("buildable");
    let mut free_motion = FreeMotion::new(&machine, &structure, StepSettings::of_step(2e-5)).expect("has a basis");
    let (mut closest, mut count) = (0.0_f64, 0);
    for round in 0..40 {
        for (doublings, contact_steps) in [(4, 16), (7, 128)] {
            let from = free_motion.contact_motion(0)[0];
            free_motion.bound_states();
            let velocity = free_motion.bounded_velocity(0);
            let max_deviation = free_motion.max_deviation(0, doublings);
            let mut ahead = free_motion.clone();
            for n in 1..=contact_steps {
                ahead.advance(0).expect("has a basis");
                let (to, t) = (ahead.contact_motion(0)[0], f64::from(n) * 2e-5);
                let deviation = length([to[0] - from[0] - t * velocity[0], to[1] - from[1] - t * velocity[1]]);
                assert!(deviation <= max_deviation, "round {round}: {deviation} beyond {max_deviation}");
                closest = closest.max(deviation / max_deviation);
                count += 1;
            }
        }
        // an impulse between the rounds, so that states of every kind occur
        free_motion.propagate(0).expect("has a basis");
        let turn = f64::from(round);
        let impulse = [0.3 * turn.sin(), 0.2 * turn.cos()];
        let impulse = ContactImpulse { impulse, torque: 1e-3, ..ContactImpulse::default() };
        free_motion.complete_step(0, &[impulse]).expect("has a basis");
        (0..50).for_each(|_| free_motion.advance(1).expect("has a basis"));
    }
    assert!(count > 5000 && closest > 0.05, "the bound is close: {closest}");
}
