//! Bouncing rubs of a Jeffcott rotor on a stiff radial spring: contact begins and ends within a step, many times.

use crate::common::{Every, machine, run, run_seen};
use bladeoff_model::outcome::{Cause, Status};

/// A reproducible stream of random numbers in 0..1.
struct Stream(u64);

impl Stream {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Random number between two values, uniform in its logarithm.
    fn decades(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.next())
    }

    fn choice<T: Copy>(&mut self, of: &[T]) -> T {
        of[(self.next() * of.len() as f64) as usize]
    }
}

/// Rotor with mass, stiffness and clearance 1; the spring is 3 to 30 000 times as stiff. `run`: further lines of `[run]`.
fn text(random: &mut Stream, inertia: f64, beta: f64, end: f64, run: &str) -> String {
    let speed_law = random.choice(&["", "[rotor.speed_law]\nacceleration = 0\n"]);
    format!(
        "schema = 1\nname = \"bounce\"\n[run]\nend_time = {end:?}\n{run}\n\
         [rotor]\nkind = \"point-mass\"\nmass = 0\npolar_inertia = {:?}\ninitial_speed = {:?}\n{speed_law}\
         [rotor.initial]\nvelocity = [{:?}, {:?}]\n\
         [rotor.bearings.spring]\nstiffness = 1\ndamping = {:?}\n[rotor.unbalances.mass]\nmass = 1\nradius = {:?}\n\
         [diaphragms.ring]\nkind = \"radial-spring\"\nstiffness = {beta:?}\n\
         [diaphragms.ring.contact]\nrotor_radius = {:?}\ngap = 1\nfriction = {:?}\n",
        inertia * random.decades(1.0, 30.0),
        0.7 + 0.8 * random.next(),
        2.0 * random.next() - 1.0,
        2.0 * random.next() - 1.0,
        random.decades(0.006, 0.2),
        0.3 + 0.5 * random.next(),
        random.choice(&[0.5, 1.0, 5.0]),
        random.choice(&[0.0, 0.02, 0.05, 0.1, 0.2]),
    )
}

#[test]
fn bouncing_rubs_keep_their_energy_at_the_default_step() {
    // the exponential engine predicts the spin: an unbalance as heavy as the spin's inertia is of first order in its step
    for (engine, inertia, bound) in [("reduced", 1.0, 1e-7), ("exponential", 10.0, 1e-5)] {
        let mut random = Stream(7);
        let (mut touched, mut impacts, mut worst) = (0, 0.0, 0.0_f64);
        for case in 0..45 {
            let beta = random.decades(3.0, 3e4);
            let text = text(&mut random, inertia, beta, 80.0, &format!("engine = \"{engine}\""));
            if engine == "exponential" && text.contains("speed_law") {
                continue;
            }
            let row = run(machine(&text));
            let causes = row.outcome.causes.words();
            assert_eq!(row.outcome.status, Status::Ok, "{engine}, case {case}: {causes:?}\n{text}");
            let error = row.value("energy_error");
            assert!(error < bound, "{engine}, case {case}: {error}\n{text}");
            touched += u32::from(row.value("impacts") > 0.0);
            impacts += row.value("impacts");
            worst = worst.max(error);
        }
        println!("{engine}: {touched} bouncing rubs, {impacts} impacts, largest energy error {worst:.1e}");
        assert!(touched >= 15 && impacts > 150.0, "contact happened: {touched}, {impacts}");
    }
}

#[test]
fn a_bounce_keeps_its_energy_at_any_stable_step() {
    let mut random = Stream(11);
    let mut touched = 0;
    for case in 0..12 {
        let beta = random.decades(3.0, 3e3);
        // relative to the stability limit of the run in contact
        let step = 2.0 / (1.0 + beta).sqrt() * random.choice(&[0.1, 0.4, 0.8, 0.95]);
        let text = text(&mut random, 1.0, beta, 400.0 * step, &format!("step = {:?}", step.min(0.1)));
        let row = run(machine(&text));
        touched += u32::from(row.value("impacts") > 0.0);
        assert!(row.outcome.status != Status::Failed, "case {case}: {:?}\n{text}", row.outcome.causes.words());
        assert!(
            !row.outcome.causes.contains(Cause::EnergyBalance),
            "case {case}: {}\n{text}",
            row.value("energy_error")
        );
    }
    assert!(touched >= 6, "contact happened: {touched}");
}

#[test]
fn a_bounce_on_a_spring_converges_with_order_two() {
    for seed in [1, 5, 9] {
        // position of the rotor after its bounces
        let place = |step: f64| {
            let mut random = Stream(seed);
            let text = text(&mut random, 1.0, 100.0, 9.0, &format!("step = {step:?}"));
            // sticking is a condition on the step, of first order
            let (head, _) = text.rsplit_once("friction = ").expect("the last line");
            let text = format!("{head}friction = 0.05\nfriction_law = \"slip\"\n");
            let mut place = [0.0; 2];
            let row = run_seen(
                machine(&text),
                &mut Every(|frame| {
                    if (frame.time - 8.0).abs() < 0.1 * step {
                        place = [frame.displacement[0], frame.displacement[1]];
                    }
                }),
            );
            assert!(row.value("impacts") >= 1.0 && row.value("first_contact_s") < 7.0, "contact happened");
            place
        };
        let [coarse, middle, fine] = [4e-3, 2e-3, 1e-3].map(place);
        let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let order = (apart(coarse, middle) / apart(middle, fine)).log2();
        println!("bounce {seed}: {:.1e}, {:.1e} apart, order {order:.2}", apart(coarse, middle), apart(middle, fine));
        assert!(apart(middle, fine) > 0.0 && (1.5..2.6).contains(&order), "{order}");
    }
}
