//! Test of the displacement bound and of the reach of a ringing ring against brute force. A rotor is struck and twisted, ring
//! modes vibrate, and no ring point is reached during a step that the clearance allows.

use super::free_motion::FreeMotion;
use super::transient::{SHORT_STEP_DOUBLINGS, Transient};
use crate::engine::exponential::contact::ring_points::{BLOCK, ring_points};
use crate::engine::exponential::contact::stator::Stator;
use crate::engine::exponential::plane::length;
use crate::engine::exponential::settings::{MAX_DOUBLINGS, StepSettings};
use crate::engine::exponential::torsion::spin::ContactImpulse;
use crate::structure::Structure;
use bladeoff_model::machine::MachineDef;
use bladeoff_numerics::linalg::lanes::{LANES, Lane, flat, rows_times};

struct Stream(u64);

impl Stream {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn sign(&mut self) -> f64 {
        2.0 * self.next() - 1.0
    }
}

/// Takes a contact step with an impulse \[N s\] and an angular impulse \[N m s\] on the rotor.
fn step_with_impulse(motion: &mut FreeMotion, impulse: [f64; 2], torque: f64) {
    motion.propagate(0).expect("has a basis");
    let impulse = ContactImpulse { impulse, torque, ..ContactImpulse::default() };
    motion.complete_step(0, &[impulse]).expect("has a basis");
}

#[test]
fn free_motion_never_reaches_a_ringing_ring() {
    // contact step, impulses on the rotor and on its spin
    for (name, h, impulse, torque) in [("lab_rig", 3.4e-6, 0.2, 2e-3), ("lp_turbine_paper", 2.7e-5, 400.0, 40.0)] {
        let path = format!("{}/../studies/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let mut transient = Transient::new(&machine, &structure, StepSettings::of_step(h), true).expect("covered");
        let diaphragm = &machine.diaphragms[0];
        let ring = ring_points(diaphragm, &structure, 0, h);
        let (initial, max_doublings) = (transient.free_motion.clone(), transient.max_doublings);
        let lengths: [f64; MAX_DOUBLINGS + 1] = std::array::from_fn(|doublings| initial.step_length(doublings));
        let mut random = Stream(7);
        let (mut steps_taken, mut refused, mut least) = ([0_u32; MAX_DOUBLINGS + 1], 0, f64::INFINITY);
        for round in 0..600 {
            if round % 40 == 0 {
                transient.free_motion = initial.clone();
            }
            let random_impulse = [impulse * random.sign(), impulse * random.sign()];
            step_with_impulse(&mut transient.free_motion, random_impulse, torque * random.sign());
            // one to three ring modes vibrate, so far that the clearance is at most what a long step needs
            let Some(Stator::Ring(contact)) = transient.contacts.first_mut().map(|contact| &mut contact.stator.stator)
            else {
                panic!("a ring")
            };
            let modes = &mut contact.ring;
            let count = modes.amplitudes().len();
            modes.displacement.fill(Lane::default());
            modes.velocity.fill(Lane::default());
            for _ in 0..=round % 3 {
                let j = (random.next() * count as f64) as usize;
                modes.displacement[j / LANES].0[j % LANES] = random.sign() / flat(&ring.reach)[j];
            }
            let x = contact.axes.displacement_from_centre(transient.free_motion.contact_displacement(0));
            let reach = contact.ring.reach(&ring.reach);
            let static_clearance = contact.clearance() + reach - length(x);
            transient.free_motion.bound_states();
            let velocity = transient.free_motion.bounded_velocity(0);
            // doublings of the longest steps, or of the common ones
            let limit = if round % 2 == 0 { max_doublings } else { SHORT_STEP_DOUBLINGS };
            let longest = lengths[limit];
            let travel = longest * length(velocity) + transient.free_motion.max_deviation(0, limit);
            let wanted = static_clearance - 1.5 * travel * random.next();
            let scale = wanted.max(0.0) / reach;
            contact.ring.displacement.iter_mut().flat_map(|lane| &mut lane.0).for_each(|q| *q *= scale);
            // the choice of `Transient::next_step_doublings`, without its bound of peaks
            let clearance_now = contact.clearance();
            let Some(doublings) = transient
                .free_motion
                .longest_step_within(0, &lengths, [x, velocity], clearance_now, limit)
                .filter(|_| length(x) < clearance_now)
            else {
                refused += 1;
                continue;
            };
            steps_taken[doublings] += 1;
            let contact_step = transient.contacts.first().and_then(|contact| contact.stator.ring()).expect("a ring");
            let (mut motion, mut vibrating_ring) = (transient.free_motion.clone(), contact_step.ring.clone());
            let step = vibrating_ring.propagator(h);
            for _ in 0..1 << doublings {
                motion.advance(0).expect("has a basis");
                vibrating_ring.propagate(&step);
                let x = contact_step.axes.place(motion.contact_displacement(0));
                for block in 0..ring.count() / BLOCK {
                    let radial = rows_times(ring.radial(block), vibrating_ring.amplitudes());
                    for (k, v) in radial.into_iter().enumerate() {
                        let (sin, cos) = ring.angles[BLOCK * block + k];
                        let clearance = diaphragm.contact.gap + v - (x[0] * cos + x[1] * sin);
                        assert!(clearance > 0.0, "{name}, round {round}, doublings {doublings}: {clearance}");
                        least = least.min(clearance / diaphragm.contact.gap);
                    }
                }
            }
        }
        println!(
            "{name}: steps by doublings {steps_taken:?}, refused {refused}, least clearance {least:.1e} of the gap"
        );
        assert!(
            steps_taken[SHORT_STEP_DOUBLINGS..].iter().sum::<u32>() > 50
                && steps_taken[..SHORT_STEP_DOUBLINGS].iter().sum::<u32>() > 50
                && refused > 5,
            "{name}: {steps_taken:?} {refused}"
        );
        assert!(least < 0.2, "{name}: some steps come near the ring: {least}");
    }
}
