//! The clearance bound of a flight against brute force: no candidate of a ringing ring is reached by a rotor that was struck and twisted, in any of the steps that
//! the room lets it fly.

use super::free_motion::FreeMotion;
use super::transient::{SHORT_STEP_DOUBLINGS, Transient};
use crate::engine::exponential::contact::ring_points::{BLOCK, ring_points};
use crate::engine::exponential::modal::displacement_bound::length;
use crate::engine::exponential::settings::{MAX_DOUBLINGS, StepSettings};
use crate::engine::exponential::torsion::spin::ContactImpulse;
use crate::linalg::lanes::{LANES, Lane, flat, rows_times};
use crate::structure::Structure;
use bladeoff_model::machine::MachineDef;

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

/// Strikes the rotor with impulses \[N s\], \[N m s\] and goes a contact step.
fn strike(flight: &mut FreeMotion, impulse: [f64; 2], torque: f64) {
    flight.propagate(0).expect("goes on");
    flight.complete_step(0, Some(ContactImpulse { impulse, torque })).expect("goes on");
}

#[test]
fn no_flight_reaches_a_ringing_ring() {
    // contact step, impulses on the rotor and on its spin
    for (name, h, impulse, torque) in [("lab_rig", 3.4e-6, 0.2, 2e-3), ("lp_turbine", 2.7e-5, 400.0, 40.0)] {
        let path = format!("{}/../studies/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let mut transient = Transient::new(&machine, &structure, StepSettings::of_step(h), true).expect("covered");
        let diaphragm = &machine.diaphragms[0];
        let ring = ring_points(diaphragm, &structure, 0, h).expect("has candidates");
        let (begun, most) = (transient.free_motion.clone(), transient.max_doublings);
        let lengths: [f64; MAX_DOUBLINGS + 1] = std::array::from_fn(|level| begun.step_length(level));
        let mut random = Stream(7);
        let (mut flown, mut refused, mut least) = ([0_u32; MAX_DOUBLINGS + 1], 0, f64::INFINITY);
        for round in 0..600 {
            if round % 40 == 0 {
                transient.free_motion = begun.clone();
            }
            let hit = [impulse * random.sign(), impulse * random.sign()];
            strike(&mut transient.free_motion, hit, torque * random.sign());
            // a few modes ring, in any phase, so far that the room left is what a long step needs or less
            let contact = transient.contact.as_mut().expect("a diaphragm");
            let modes = &mut contact.contact_step.ring;
            let count = modes.amplitudes().len();
            modes.place.fill(Lane::default());
            modes.rate.fill(Lane::default());
            for _ in 0..=round % 3 {
                let j = (random.next() * count as f64) as usize;
                modes.place[j / LANES].0[j % LANES] = random.sign() / flat(&ring.reach)[j];
            }
            let x = contact.contact_step.displacement_from_centre(transient.free_motion.contact_displacement(0));
            let reach = contact.contact_step.ring.reach(&ring.reach);
            let clear = contact.contact_step.clearance() + reach - length(x);
            let velocity = transient.free_motion.bound_states();
            // as long as the longest may be, or as those that are common
            let top = if round % 2 == 0 { most } else { SHORT_STEP_DOUBLINGS };
            let longest = lengths[top];
            let way = longest * length(velocity) + transient.free_motion.max_deviation(top);
            let wanted = clear - 1.5 * way * random.next();
            let part = wanted.max(0.0) / reach;
            contact.contact_step.ring.place.iter_mut().flat_map(|eight| &mut eight.0).for_each(|q| *q *= part);
            // as `Transient::level` does, whatever peaks ask for
            let room = contact.contact_step.clearance();
            let Some(level) = transient
                .free_motion
                .longest_step_within(&lengths, [x, velocity], room, top)
                .filter(|_| length(x) < room)
            else {
                refused += 1;
                continue;
            };
            flown[level] += 1;
            let rub = &transient.contact.as_ref().expect("a diaphragm").contact_step;
            let (mut flight, mut ringing) = (transient.free_motion.clone(), rub.ring.clone());
            let step = ringing.propagator(h);
            for _ in 0..1 << level {
                flight.advance(0).expect("goes on");
                ringing.propagate(&step);
                let x = rub.displacement_in_stator_axes(flight.contact_displacement(0));
                for block in 0..ring.count() / BLOCK {
                    let moved = rows_times(ring.radial(block), ringing.amplitudes());
                    for (k, v) in moved.into_iter().enumerate() {
                        let (sin, cos) = ring.angles[BLOCK * block + k];
                        let clearance = diaphragm.contact.gap + v - (x[0] * cos + x[1] * sin);
                        assert!(clearance > 0.0, "{name}, round {round}, level {level}: {clearance}");
                        least = least.min(clearance / diaphragm.contact.gap);
                    }
                }
            }
        }
        println!("{name}: flights by level {flown:?}, refused {refused}, least clearance {least:.1e} of the gap");
        assert!(
            flown[SHORT_STEP_DOUBLINGS..].iter().sum::<u32>() > 50
                && flown[..SHORT_STEP_DOUBLINGS].iter().sum::<u32>() > 50
                && refused > 5,
            "{name}: {flown:?} {refused}"
        );
        assert!(least < 0.2, "{name}: it comes near: {least}");
    }
}
