//! Modes followed over speed by their shapes; separation of overdamped motions; critical speeds where a followed mode meets the spin.

use crate::common::{machine, machine_with, study_machine};
use bladeoff_core::modal::{ModesError, OVERDAMPED, SpeedModes, Whirl, followed_modes, report};
use bladeoff_model::machine::Machine;
use std::f64::consts::PI;

/// The lab rig on dampers of half its bearings' stiffness at the running speed, `c W/k = 0.5`.
fn damped(share: f64) -> Machine {
    let (k, speed) = (2e6, 3000.0 * PI / 30.0);
    let damping = format!("{:?}", share * k / speed);
    machine_with(
        &study_machine("lab_rig"),
        &[("rotor.bearings.left.damping", &damping), ("rotor.bearings.right.damping", &damping)],
    )
}

fn speeds(top: f64, count: usize) -> Vec<f64> {
    (0..=count).map(|k| top * k as f64 / count as f64).collect()
}

/// Speed and properties of a numbered mode, at each speed where the mode whirls.
fn line(found: &[SpeedModes], number: usize) -> Vec<(f64, f64, f64, Whirl)> {
    let at = |speed: &SpeedModes| {
        let (_, mode) = speed.whirl.iter().find(|(other, _)| *other == number)?;
        Some((speed.speed, mode.frequency, mode.damping_ratio, mode.whirl))
    };
    found.iter().filter_map(at).collect()
}

#[test]
fn strongly_damped_bearings_leave_the_bending_modes_first_and_their_own_motions_apart() {
    let machine = damped(0.5);
    let top = machine.rotor.initial_speed;
    let found = followed_modes(&machine, &speeds(1.5 * top, 40)).expect("solvable");
    let undamped = followed_modes(&damped(0.0), &[0.0]).expect("solvable");
    assert!(found.iter().all(|speed| !speed.overdamped.is_empty()), "there are motions that do not whirl");
    for speed in &found {
        let modes = || speed.whirl.iter().map(|(_, mode)| mode);
        assert!(modes().all(|mode| mode.damping_ratio < OVERDAMPED && mode.frequency > 0.0));
        assert!(speed.overdamped.iter().all(|mode| mode.damping_ratio >= OVERDAMPED && mode.decay > 0.0));
        // the first two modes are the first bending pair
        let first = undamped[0].whirl[0].1.frequency;
        for (number, mode) in &speed.whirl[..2] {
            assert!(*number <= 2 && (mode.frequency / first - 1.0).abs() < 0.2, "{number} {mode:?} {first}");
        }
    }
    let critical = report(&machine, &[]).expect("solvable").critical_speeds;
    println!("{:?}", critical.iter().map(|c| (c.speed * 30.0 / PI, c.damping_ratio)).collect::<Vec<_>>());
    assert!(critical.len() >= 2 && critical.iter().all(|critical| critical.damping_ratio < OVERDAMPED));
}

/// Lines of modes: no line jumps to another where they cross, and each keeps its whirl sense.
#[test]
fn a_followed_mode_has_a_smooth_line_through_every_crossing() {
    // a heavy overhung disc: its backward modes fall through the forward ones of lower order
    let text = study_machine("lab_rig").replace("polar_inertia = \"1.25e-3 kg m2\"", "polar_inertia = \"2e-2 kg m2\"");
    let text = text.replace("transverse_inertia = \"6.5e-4 kg m2\"", "transverse_inertia = \"1e-2 kg m2\"");
    let machine = machine(&text);
    let top = 3000.0;
    let found = followed_modes(&machine, &speeds(top, 120)).expect("solvable");
    let mut crossings = 0;
    for number in 1..=8 {
        let line = line(&found, number);
        assert_eq!(line.len(), found.len(), "mode {number} has a whole line");
        let reach = line.iter().map(|point| point.1).fold(0.0, f64::max);
        for three in line.windows(3) {
            let bend = (three[0].1 - 2.0 * three[1].1 + three[2].1).abs();
            assert!(bend < 0.02 * reach, "mode {number} jumps at {}: {three:?}", three[1].0);
        }
        assert!(line[1..].iter().all(|point| point.3 == line[1].3), "mode {number} keeps its sense");
        for other in number + 1..=8 {
            let other = self::line(&found, other);
            let above = |k: usize| line[k].1 > other[k].1;
            crossings += (2..line.len()).filter(|&k| above(k) != above(k - 1)).count();
        }
    }
    assert!(crossings > 0, "there is something to follow");
    println!("{crossings} crossings");
}

/// At each critical speed, the mode of that sense has the frequency of the spin.
#[test]
fn critical_speeds_lie_on_followed_lines() {
    for share in [0.0, 0.1, 0.5] {
        let machine = damped(share);
        let critical = report(&machine, &[]).expect("solvable").critical_speeds;
        assert!(!critical.is_empty());
        for critical in &critical {
            let found = &followed_modes(&machine, &[critical.speed]).expect("solvable")[0];
            let meets = |mode: &bladeoff_core::modal::WhirlMode| {
                (mode.frequency / critical.speed - 1.0).abs() < 1e-9 && mode.whirl == critical.whirl
            };
            assert!(found.whirl.iter().any(|(_, mode)| meets(mode)), "{critical:?}");
        }
    }
}

/// zeta = c/(2 m w0): the decrement is the logarithm of two successive peaks of the free motion.
#[test]
fn the_decrement_is_that_of_two_peaks() {
    let text = "schema = 1\nname = \"jeffcott\"\n[rotor]\nkind = \"point-mass\"\nmass = 1.0\npolar_inertia = 1.0\n\
        initial_speed = 1.0\n[rotor.bearings.support]\nstiffness = 4.0\ndamping = 0.4\n[run]\nend_time = 1.0\n";
    let found = followed_modes(&machine(text), &[0.0, 3.0]).expect("solvable");
    let (ratio, frequency) = (0.1, 2.0 * (1.0_f64 - 0.01).sqrt());
    for speed in &found {
        assert_eq!(speed.whirl.len(), 2);
        for (_, mode) in &speed.whirl {
            assert!((mode.damping_ratio - ratio).abs() < 1e-12 && (mode.frequency - frequency).abs() < 1e-12);
            let peaks = (ratio * 2.0 * 2.0 * PI / frequency).exp();
            assert!((mode.decrement() - peaks.ln()).abs() < 1e-12);
        }
    }
    // a circular mode of each sense, though no moment couples the planes
    let mut senses: Vec<Whirl> = found[1].whirl.iter().map(|(_, mode)| mode.whirl).collect();
    senses.sort_by_key(|sense| sense.word());
    assert_eq!(senses, [Whirl::Backward, Whirl::Forward]);
}

/// Machines with isotropic bearings: at rest, all their modes are double.
fn isotropic() -> [(&'static str, Machine); 3] {
    [("lab rig", damped(0.0)), ("turbine", machine(&study_machine("lp_turbine_paper"))), ("damped", damped(0.5))]
}

fn numbers(speed: &SpeedModes) -> Vec<usize> {
    let mut numbers: Vec<usize> = speed.whirl.iter().map(|(number, _)| *number).collect();
    numbers.sort_unstable();
    numbers
}

#[test]
fn a_mode_keeps_its_number_from_rest_to_the_running_speed() {
    let rpm = [0.0, 1e-7, 1e-5, 1e-3, 1.0, 10.0, 500.0, 1500.0, 3000.0];
    let rig = || study_machine("lab_rig");
    let mut machines = isotropic().to_vec();
    machines.push(("lab rig as it is", machine(&rig())));
    for (name, machine) in machines {
        let found = followed_modes(&machine, &rpm.map(|rpm| rpm * PI / 30.0)).expect("solvable");
        let rest = &found[0];
        let all: Vec<usize> = (1..=rest.whirl.len()).collect();
        assert_eq!(numbers(rest), all, "{name}");
        let mut known = all.len();
        for (speed, rpm) in found.iter().zip(rpm) {
            let here = numbers(speed);
            println!(
                "{name} {rpm}: {} whirl, {} overdamped, up to {:?}",
                here.len(),
                speed.overdamped.len(),
                here.last()
            );
            assert!(here.windows(2).all(|pair| pair[0] < pair[1]), "{name} {rpm}: {here:?}");
            if speed.whirl.len() == rest.whirl.len() {
                assert!(here == all || known > all.len(), "{name} {rpm}: {here:?}");
            }
            // a number beyond those at rest belongs to a motion that was overdamped at rest
            let highest = here.last().copied().unwrap_or(0);
            assert!(highest <= all.len() + rest.overdamped.len(), "{name} {rpm}: {here:?}");
            known = known.max(highest);
            if rpm > 10.0 {
                continue;
            }
            for (number, mode) in speed.whirl.iter().filter(|(number, _)| *number <= all.len()) {
                let (_, first) = rest.whirl.iter().find(|(other, _)| other == number).expect("at rest");
                let change = (mode.frequency / first.frequency - 1.0).abs();
                assert!(change < 0.01, "{name} {rpm}: mode {number} {} -> {}", first.frequency, mode.frequency);
                if rpm > 0.0 {
                    let sense = if number % 2 == 1 { Whirl::Backward } else { Whirl::Forward };
                    assert_eq!(mode.whirl, sense, "{name} {rpm}: mode {number}");
                }
            }
        }
    }
}

#[test]
fn frequencies_of_a_number_are_continuous() {
    for (name, machine) in isotropic() {
        let found = followed_modes(&machine, &speeds(3000.0 * PI / 30.0, 60)).expect("solvable");
        for two in found.windows(2) {
            for (number, mode) in &two[0].whirl {
                let next = two[1].whirl.iter().find(|(other, _)| other == number);
                let Some((_, next)) = next else {
                    assert!(mode.damping_ratio > 0.85, "{name}: mode {number} ends at {}: {mode:?}", two[0].speed);
                    continue;
                };
                let change = (next.frequency / mode.frequency - 1.0).abs();
                assert!(
                    change < 0.03 || mode.damping_ratio > 0.85,
                    "{name} {}: mode {number} {mode:?} {next:?}",
                    two[1].speed
                );
            }
        }
    }
}

/// The gyroscopic split of a pair has the same slope at a tiny speed as at a larger one, though a tiny split is within the rounding of the whole
/// matrices.
#[test]
fn a_slight_speed_splits_a_pair_as_a_greater_one_does() {
    for (name, machine) in isotropic() {
        let found = followed_modes(&machine, &[0.0, 1e-4, 0.5]).expect("solvable");
        for number in 1..=8 {
            let line = line(&found, number);
            let slope = |point: usize| (line[point].1 - line[0].1) / line[point].0;
            assert!(
                (slope(1) - slope(2)).abs() < 1e-2 * slope(2).abs() + 1e-6,
                "{name} {number}: {} {}",
                slope(1),
                slope(2)
            );
            let damping = |point: usize| (line[point].2 - line[0].2) * line[0].1 / line[point].0;
            assert!(
                (damping(1) - damping(2)).abs() < 1e-2 * damping(2).abs() + 1e-6,
                "{name} {number}: {} {}",
                damping(1),
                damping(2)
            );
        }
    }
}

/// An overdamped pair whose precession is too slow to detect is listed once, as at speeds where the precession is detected.
#[test]
fn an_overdamped_pair_is_listed_once_at_any_speed() {
    let machine = damped(0.5);
    let found = followed_modes(&machine, &[1e-8, 1e-4, 1.0]).expect("solvable");
    let counts: Vec<usize> = found.iter().map(|speed| speed.overdamped.len()).collect();
    assert!(counts[0] > 0 && counts.iter().all(|count| *count == counts[0]), "{counts:?}");
}

/// A shaft of 25 m instead of 25 mm: once, every halving of the step was tried at every speed, for ten minutes.
#[test]
fn modes_that_cannot_be_followed_are_given_up_with_a_word() {
    let metres = [0, 1, 2].map(|section| (format!("rotor.shaft[{section}].diameter"), "25 m"));
    let thick = |sections: &[usize]| {
        let sets: Vec<(&str, &str)> = sections.iter().map(|&at| (metres[at].0.as_str(), metres[at].1)).collect();
        machine_with(&study_machine("lab_rig"), &sets)
    };
    for sections in [&[1][..], &[0, 1, 2]] {
        let error = report(&thick(sections), &[0.0]).expect_err("not to be followed");
        let ModesError::Unclear { speeds, reached, wanted } = error else { panic!("{error}") };
        assert!((1000..1100).contains(&speeds) && reached < wanted && wanted > 0.0, "{speeds} {reached} {wanted}");
        assert!(error.to_string().contains("is a unit wrong"), "{error}");
    }
    // Speeds that are only requested have the same limit; at rest no mode has to be followed.
    let error = followed_modes(&thick(&[0, 1, 2]), &[0.0, 1e4]).expect_err("not to be followed");
    assert!(matches!(error, ModesError::Unclear { wanted: 1e4, .. }), "{error}");
    assert_eq!(followed_modes(&thick(&[1]), &[0.0]).expect("at rest").len(), 1);
}

/// A shaft without any damping: rounding makes no mode unstable or damped. With almost no damping the ratio is not rounded to zero.
#[test]
fn an_undamped_shaft_has_damping_ratios_of_exactly_zero() {
    let text = "schema = 1\nname = \"nodisc\"\n[run]\nend_time = \"20 ms\"\n[rotor]\ninitial_speed = \"3000 rpm\"\n\
        [rotor.material]\nyoung_modulus = \"210 GPa\"\npoisson_ratio = 0.3\ndensity = \"7850 kg/m3\"\n\
        [[rotor.shaft]]\nlength = \"1 m\"\ndiameter = \"50 mm\"\nelements = 16\n\
        [rotor.bearings.l]\nposition = \"0 m\"\nstiffness = \"1e7 N/m\"\naxial_stiffness = \"1e6 N/m\"\n\
        [rotor.bearings.r]\nposition = \"1 m\"\nstiffness = \"1e7 N/m\"\n";
    let ratios = |text: &str| -> Vec<f64> {
        let found = report(&machine(text), &[0.0, 314.0]).expect("solvable");
        let modes = found.speeds.iter().flat_map(|speed| speed.whirl.iter().map(|(_, mode)| mode.damping_ratio));
        modes.chain(found.critical_speeds.iter().map(|critical| critical.damping_ratio)).collect()
    };
    let undamped = ratios(text);
    assert!(undamped.len() > 100, "{}", undamped.len());
    for (place, ratio) in undamped.iter().enumerate() {
        assert!(*ratio == 0.0 && ratio.is_sign_positive(), "{place} of {}: {ratio:e}", undamped.len());
    }
    let damped =
        ratios(&text.replace("stiffness = \"1e7 N/m\"\naxial", "stiffness = \"1e7 N/m\"\ndamping = 1e-3\naxial"));
    // first bending pair at rest: a damping ratio of about 1e-8
    assert!(damped[0] > 1e-10 && damped[0] < 1e-6, "{:e}", damped[0]);
}
