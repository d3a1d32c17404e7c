//! Random histories of the scheduler in environments with various rates of faults, by `simulation`.

use std::collections::BTreeSet;
use std::time::Duration;

use super::simulation::{Simulation, World};
use super::{Ended, Moment, RunLimits, Signal, TimeOfDay, Until};

const KIND: World = World { death: 0, silence: 0, lies: 0, doubles: 0, losses: 0, poison: 0, doom: 0 };

fn play_all(seeds: std::ops::Range<u64>, world: World) -> (u64, u64, u64) {
    let (mut recorded, mut quarantined, mut dropped) = (0, 0, 0);
    for seed in seeds {
        let mut simulation = Simulation::new(seed, world);
        simulation.play();
        if !simulation.gave_up {
            assert!(simulation.scheduler.is_complete(), "seed {seed}");
        }
        recorded += simulation.recorded.len() as u64;
        quarantined += simulation.quarantined.len() as u64;
        dropped += simulation.scheduler.dropped();
    }
    (recorded, quarantined, dropped)
}

#[test]
fn in_a_kind_world_every_sample_is_recorded_and_nothing_dropped() {
    let (recorded, quarantined, dropped) = play_all(0..500, KIND);
    assert!(recorded > 10_000);
    assert_eq!((quarantined, dropped), (0, 0));
}

/// The last assignment of a sample counts; the result of the other worker is not a discarded message.
#[test]
fn what_is_taken_back_from_behind_long_samples_is_recorded_once() {
    let mut relieved = 0;
    for seed in 20_000..22_000 {
        let mut simulation = Simulation::new(seed, KIND);
        simulation.play();
        assert!(simulation.scheduler.is_complete() && simulation.scheduler.dropped() == 0, "seed {seed}");
        relieved += simulation.relieved;
    }
    assert!(relieved > 40, "{relieved}");
}

#[test]
fn doubled_late_and_lying_reports_change_no_record() {
    let (recorded, quarantined, dropped) = play_all(1000..2500, World { doubles: 20, lies: 10, ..KIND });
    assert_eq!(quarantined, 0);
    assert!(recorded > 30_000 && dropped > 10_000, "{recorded} {dropped}");
}

#[test]
fn dying_and_silent_workers_cost_no_sample_its_end() {
    let (recorded, quarantined, _) = play_all(3000..4500, World { death: 3, silence: 1, ..KIND });
    assert!(recorded > 20_000 && quarantined > 0, "{recorded} {quarantined}");
}

#[test]
fn poisoned_samples_and_no_others_are_quarantined() {
    for seed in 5000..6000 {
        let mut simulation = Simulation::new(seed, World { poison: 10, doubles: 5, ..KIND });
        simulation.play();
        assert!(simulation.scheduler.is_complete());
        assert_eq!(simulation.quarantined, simulation.poisoned, "seed {seed}");
    }
}

/// Kills are counted separately from crashes, a suspect has one attempt, and a sample that an earlier run gave up needlessly is computed.
#[test]
fn samples_whose_workers_are_killed_and_no_others_are_quarantined() {
    let (mut tried_once, mut computed) = (0, 0);
    for seed in 7000..8000 {
        let mut simulation = Simulation::new(seed, World { doom: 10, poison: 5, doubles: 5, ..KIND });
        simulation.play();
        assert!(simulation.scheduler.is_complete());
        let given_up: BTreeSet<u64> = simulation.poisoned.union(&simulation.doomed).copied().collect();
        assert_eq!(simulation.quarantined, given_up, "seed {seed}");
        tried_once += simulation.suspects.intersection(&simulation.doomed).count();
        computed += simulation.suspects.difference(&given_up).count();
    }
    assert!(tried_once > 100 && computed > 1000, "{tried_once} {computed}");
}

#[test]
fn in_a_world_with_every_fault_every_sample_ends_once() {
    let world = World { death: 2, silence: 1, lies: 5, doubles: 10, losses: 3, poison: 5, doom: 5 };
    let (recorded, quarantined, dropped) = play_all(10_000..14_000, world);
    assert!(recorded > 50_000 && quarantined > 1000 && dropped > 10_000, "{recorded} {quarantined} {dropped}");
}

#[test]
fn workers_that_never_start_make_the_run_give_up() {
    let mut simulation = Simulation::new(1, World { death: 100, ..KIND });
    simulation.play();
    assert!(simulation.gave_up && simulation.recorded.is_empty() && simulation.quarantined.is_empty());
}

#[test]
fn a_stopped_run_ends_whatever_the_workers_do() {
    for seed in 0..1000 {
        let world = World { death: 1, silence: 3, lies: 5, doubles: 5, losses: 3, poison: 3, doom: 3 };
        let mut simulation = Simulation::new(seed, world);
        let mut effects = Vec::new();
        simulation.scheduler.start(simulation.now, &mut effects);
        simulation.carry_out(effects, None);
        for _ in 0..simulation.random.below(200) {
            simulation.step();
        }
        let mut effects = Vec::new();
        simulation.scheduler.on_stop(simulation.now, Signal::Terminate, &mut effects);
        simulation.carry_out(effects, None);
        for _ in 0..2000 {
            if !simulation.scheduler.is_over() {
                simulation.step();
            }
        }
        assert!(simulation.scheduler.is_over(), "seed {seed}: {:?}", simulation.scheduler.snapshot(simulation.now));
        let stopped = simulation.stopped.map(|(why, ..)| why);
        assert!(stopped.is_none_or(|why| why == Ended::Signalled(Signal::Terminate)), "seed {seed}: {stopped:?}");
    }
}

/// Plays a simulation; returns whether the run was cut short, after checking that the given reason is reported.
fn play_to_its_end(simulation: &mut Simulation, reason: Ended) -> bool {
    simulation.play();
    let told = simulation.stopped.map(|(why, ..)| why);
    assert!(told.is_none_or(|why| why == reason), "{told:?}");
    if simulation.scheduler.is_complete() {
        assert_eq!(simulation.scheduler.ended(), Some(Ended::Complete));
        return false;
    }
    if !simulation.gave_up {
        assert_eq!((told, simulation.scheduler.ended()), (Some(reason), Some(reason)));
    }
    told.is_some()
}

const ROUGH: World = World { death: 2, silence: 1, lies: 2, doubles: 5, losses: 2, poison: 5, doom: 5 };

#[test]
fn a_run_ends_at_the_first_tick_after_its_wall_time() {
    let mut cut = 0;
    for seed in 30_000..31_000 {
        let wall = Duration::from_millis(seed % 20 * 500);
        let limits = RunLimits { wall: Some(wall), ..RunLimits::default() };
        let mut simulation = Simulation::limited(seed, ROUGH, limits);
        cut += u32::from(play_to_its_end(&mut simulation, Ended::Wall));
        if let Some((_, at, before)) = simulation.stopped {
            assert!(at >= wall && (before < wall || before.is_zero()), "seed {seed}: {before:?}, {at:?}");
        }
    }
    assert!((300..900).contains(&cut), "some end early, some do not: {cut}");
}

/// The wall clock may be set during a run: the new time applies.
#[test]
fn a_run_ends_at_the_first_tick_after_its_time_of_the_day() {
    const DAY: i64 = 86_400_000;
    fn zone(wall: i64, days: i32, time: TimeOfDay) -> i64 {
        let of_day = (i64::from(time.hour) * 60 + i64::from(time.minute)) * 60_000;
        (wall.div_euclid(DAY) + i64::from(days)) * DAY + of_day
    }
    let (mut cut, mut cut_by_setting) = (0, 0);
    for seed in 40_000..41_000 {
        let left = (seed % 20 * 500) as i64;
        let wall = 20_000 * DAY + 390 * 60_000 - left;
        let until = Until::next("06:30".parse().expect("a time"), Moment { boot: 0, wall: wall - 1 }, zone);
        let limits = RunLimits { until: Some(until), ..RunLimits::default() };
        let mut simulation = Simulation::limited(seed, ROUGH, limits);
        let is_set = seed % 3 == 0;
        // set from just before 6:30 to 6:45: the run ends at the first tick
        simulation.wall_clock = if is_set { wall + 15 * 60_000 } else { wall };
        let was_cut = play_to_its_end(&mut simulation, Ended::Until);
        *(if is_set { &mut cut_by_setting } else { &mut cut }) += u32::from(was_cut);
        if let Some((_, at, before)) = simulation.stopped {
            let end = if is_set { Duration::ZERO } else { Duration::from_millis(left as u64) };
            assert!(at >= end && (before < end || before.is_zero()), "seed {seed}: {before:?}, {at:?}");
        }
    }
    assert!((200..600).contains(&cut) && cut_by_setting > 300, "{cut} {cut_by_setting}");
}

#[test]
fn a_run_with_too_many_failures_ends_with_the_one_too_many() {
    let mut cut = 0;
    for seed in 50_000..51_000 {
        let most = seed % 4;
        let limits = RunLimits { max_failures: Some(most), ..RunLimits::default() };
        let mut simulation = Simulation::limited(seed, World { poison: 10, doubles: 5, ..KIND }, limits);
        let was_cut = play_to_its_end(&mut simulation, Ended::TooManyFailures);
        let failed = simulation.quarantined.len() as u64;
        assert!(if was_cut { failed > most } else { failed <= most + 1 }, "seed {seed}: {failed} of {most}");
        cut += u32::from(was_cut);
    }
    assert!((300..900).contains(&cut), "{cut}");
}

#[test]
fn the_first_reason_to_stop_is_the_one_that_is_told() {
    let limits = RunLimits { wall: Some(Duration::from_secs(1)), ..RunLimits::default() };
    let mut signalled = 0;
    for seed in 60_000..60_500 {
        let mut simulation = Simulation::limited(seed, KIND, limits);
        let mut effects = Vec::new();
        simulation.scheduler.start(simulation.now, &mut effects);
        simulation.scheduler.on_stop(simulation.now, Signal::Interrupt, &mut effects);
        simulation.carry_out(effects, None);
        while !simulation.scheduler.is_over() {
            simulation.step();
        }
        if !simulation.scheduler.is_complete() {
            assert_eq!(simulation.scheduler.ended(), Some(Ended::Signalled(Signal::Interrupt)), "seed {seed}");
            signalled += u32::from(simulation.now > Duration::from_secs(1));
        }
    }
    assert!(signalled > 50, "past their wall, too: {signalled}");
}
