//! A run with contact: flight in large steps where nothing can touch, contact steps where something may.
//!
//! ```text
//! room = gap - |x| - sum over ring modes of amplitude reach         > h v :  a step of h cannot touch
//! ```
//! v bounds the velocity of the rotor's node during the step ([`super::bound`]). Verified by `the_bound_of_the_velocity_is_one` and
//! `flight_misses_no_contact` (`tests/exponential_rub.rs`).

use super::ExponentialError;
use super::bound::length;
use super::flight::{Flight, FlightSettings};
use super::rub::{FreeStep, Rub};
use crate::record::LastMillisecond;
use crate::structure::Structure;
use bladeoff_model::machine::{ContactPoints, Detection, ForceLocation, Machine};

/// A flight step has at most `2^LEVELS` contact steps.
const LEVELS: usize = 4;

/// What a run with contact comes to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RubbingRun {
    /// First contact \[s\].
    pub first_contact: Option<f64>,
    /// Spin at the end \[rad/s\].
    pub end_speed: f64,
    /// Largest load of each bearing, in the machine's order \[N\].
    pub largest_loads: Vec<f64>,
    /// Largest mean of the normal force over 1 ms \[N\].
    pub largest_filtered_force: f64,
    /// Normal impulse of all contact \[N s\].
    pub impulse: f64,
    /// Work of friction \[J\].
    pub friction_energy: f64,
    /// Largest distance of the rotor's node from the stator's centre \[m\].
    pub eccentricity: f64,
    /// Contact steps, those of them that touched, and flight steps.
    pub steps: [u64; 3],
}

/// A whole run up to `run.end_time` with contact at the first diaphragm, in contact steps of `settings.step`; `flies`: in larger ones where it may.
///
/// # Errors
/// [`ExponentialError`].
pub fn rubbing_run(
    machine: &Machine,
    structure: &Structure,
    settings: FlightSettings,
    flies: bool,
) -> Result<RubbingRun, ExponentialError> {
    let [diaphragm] = machine.diaphragms.as_slice() else {
        return Err(ExponentialError::NotCovered { what: "any number of diaphragms but one" });
    };
    let contact = &diaphragm.contact;
    if contact.detection != Detection::Hyp2 || contact.points != ContactPoints::Several {
        return Err(ExponentialError::NotCovered { what: "contact other than hyp2 at several points" });
    }
    if machine.run.force_location != ForceLocation::Next {
        return Err(ExponentialError::NotCovered {
            what: "forces at the place of n (run.force_location = \"current\")",
        });
    }
    let mut flight = Flight::new(machine, structure, settings)?;
    let h = settings.step;
    let mut rub = Rub::new(diaphragm, structure, 0, h)?;
    let bearings = structure.rotor.bearings.len();
    let twist_row = super::spin::Spin::row_of(structure, diaphragm.contact.node);
    let mut filter = LastMillisecond::new(h);
    let window = filter.length() as f64 * h;
    let mut run = RubbingRun { largest_loads: vec![0.0; bearings], ..RubbingRun::default() };
    while flight.time() < machine.run.end_time - 0.5 * h {
        let place = flight.contact(0)[0];
        let offset = diaphragm.contact.offset;
        run.eccentricity = run.eccentricity.max(length([place[0] - offset[0], place[1] - offset[1]]));
        let mut loads: Vec<[f64; 2]> = (0..bearings).map(|bearing| flight.load(bearing)).collect();
        let room = rub.room(place);
        let mut levels = (0..=LEVELS).rev();
        let level = levels.find(|&level| flies && room > flight.step_of(level) * flight.fastest(flight.step_of(level)));
        if let Some(level) = level {
            flight.advance(level)?;
            rub.fly(level, flight.step_of(level));
            (0..1 << level).for_each(|_| filter.slide(0.0));
            run.steps[2] += 1;
        } else {
            let twist_before = flight.spin().twist_at(&twist_row);
            flight.propagate(0)?;
            flight.prepare_kick(0);
            let (kick, spin, spin_step) = flight.striking();
            let free = FreeStep {
                from: place,
                to: flight.contact(0)[0],
                kick,
                turn: spin.turn(&twist_row, twist_before),
                rolling: spin.rolling(spin_step, &twist_row),
                h,
            };
            let impact = rub.touch(&free)?;
            run.steps[0] += 1;
            if let Some(impact) = impact {
                for (bearing, (load, half)) in loads.iter_mut().zip(&kick.loads).enumerate() {
                    let at_once = flight.load_at_once(bearing, impact.on_rotor.map(|part| part / h));
                    for i in 0..2 {
                        load[i] += half[i][0] * impact.on_rotor[0] + half[i][1] * impact.on_rotor[1] + at_once[i];
                    }
                }
                run.steps[1] += 1;
                run.impulse += impact.normal;
                run.friction_energy += impact.friction_work;
                run.first_contact = run.first_contact.or(Some(flight.time() + h));
                flight.strike(impact.on_rotor, impact.torque, &twist_row);
            }
            filter.slide(impact.map_or(0.0, |impact| impact.normal));
            if let Some(sum) = filter.sum() {
                run.largest_filtered_force = run.largest_filtered_force.max(sum / window);
            }
            flight.finish(0)?;
        }
        for (largest, load) in run.largest_loads.iter_mut().zip(&loads) {
            *largest = largest.max(length(*load));
        }
    }
    run.end_speed = flight.speed();
    Ok(run)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    #[test]
    fn the_bound_of_the_velocity_is_one() {
        let path = format!("{}/../studies/machines/lab_rig.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("a machine of the repository");
        let machine = MachineDef::parse(&path, &text).expect("parses").build().expect("valid");
        let structure = Structure::build(&machine, None).expect("buildable");
        let mut flight = Flight::new(&machine, &structure, FlightSettings::of_step(2e-5)).expect("has a basis");
        let (mut closest, mut seen) = (0.0_f64, 0);
        for round in 0..40 {
            for (level, fine) in [(4, 16), (7, 128)] {
                let from = flight.contact(0)[0];
                let bound = flight.step_of(level) * flight.fastest(flight.step_of(level));
                let mut ahead = flight.clone();
                for _ in 0..fine {
                    ahead.advance(0).expect("goes on");
                    let to = ahead.contact(0)[0];
                    let moved = length([to[0] - from[0], to[1] - from[1]]);
                    assert!(moved <= bound, "round {round}: {moved} beyond {bound}");
                    closest = closest.max(moved / bound);
                    seen += 1;
                }
            }
            // states of every kind: struck in between
            flight.propagate(0).expect("goes on");
            flight.prepare_kick(0);
            let turn = f64::from(round);
            flight.strike(
                [0.3 * turn.sin(), 0.2 * turn.cos()],
                1e-3,
                &super::super::spin::Spin::row_of(&structure, machine.diaphragms[0].contact.node),
            );
            flight.finish(0).expect("goes on");
            (0..50).for_each(|_| flight.advance(1).expect("goes on"));
        }
        assert!(seen > 5000 && closest > 0.05, "the bound says something: {closest}");
    }
}
