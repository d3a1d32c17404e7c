//! Random histories of the scheduler in worlds of different badness, played by `simulation`.

use std::collections::BTreeSet;

use super::simulation::{Simulation, World};

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
        dropped += simulation.scheduler.dropped;
    }
    (recorded, quarantined, dropped)
}

#[test]
fn in_a_kind_world_every_sample_is_recorded_and_nothing_dropped() {
    let (recorded, quarantined, dropped) = play_all(0..500, KIND);
    assert!(recorded > 10_000);
    assert_eq!((quarantined, dropped), (0, 0));
}

/// By whom it was assigned to last; the other's result is no message to be dropped either.
#[test]
fn what_is_taken_back_from_behind_long_samples_is_recorded_once() {
    let mut relieved = 0;
    for seed in 20_000..22_000 {
        let mut simulation = Simulation::new(seed, KIND);
        simulation.play();
        assert!(simulation.scheduler.is_complete() && simulation.scheduler.dropped == 0, "seed {seed}");
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

/// Kills count apart from crashes, a suspect has one, and what an earlier run gave up without need is computed.
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
        simulation.scheduler.on_stop(simulation.now, &mut effects);
        simulation.carry_out(effects, None);
        for _ in 0..2000 {
            if !simulation.scheduler.is_over() {
                simulation.step();
            }
        }
        assert!(simulation.scheduler.is_over(), "seed {seed}: {:?}", simulation.scheduler.snapshot(simulation.now));
    }
}
