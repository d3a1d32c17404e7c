//! Outcomes of samples with solvers that process a batch as a whole, and with solvers that break their contract.

mod support;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use bladeoff_model::outcome::{Cause, Status};
use bladeoff_protocol::link::HubLink;
use bladeoff_protocol::messages::{BatchId, FromWorkerBlock, MAX_BATCH, Report, SampleReport, ToWorker, ToWorkerBlock};
use bladeoff_protocol::transport::{PortError, WorkerPort};
use bladeoff_worker::batch_recorder::{BatchRecorder, Sample, Stopped};
use bladeoff_worker::heartbeat::Heartbeat;
use bladeoff_worker::process::thread_cpu_time;
use bladeoff_worker::solver::Solver;
use support::transports::{MemoryNet, MemoryWorker};
use support::{RUN, WORKER, batch, fine, play, receive, report, results, start};

/// Calls of a solver: the samples of each call; a recovery is recorded as 0.
type Calls = Arc<Mutex<Vec<Vec<u64>>>>;

/// A solver that calls a function.
struct Like<F> {
    solve: F,
    calls: Calls,
}

impl<F: FnMut(&[Sample<'_>], &mut BatchRecorder<'_>) -> Result<(), Stopped>> Solver for Like<F> {
    fn solve_batch(&mut self, samples: &[Sample<'_>], recorder: &mut BatchRecorder<'_>) -> Result<(), Stopped> {
        self.calls.lock().expect("whole").push(samples.iter().map(|sample| sample.number).collect());
        (self.solve)(samples, recorder)
    }
    fn recover(&mut self) {
        self.calls.lock().expect("whole").push(vec![0]);
    }
}

/// Runs one batch with a solver; returns the reports and the calls of the solver.
fn play_like<F>(samples: &[u64], solve: F) -> (Vec<Report>, Vec<Vec<u64>>)
where
    F: FnMut(&[Sample<'_>], &mut BatchRecorder<'_>) -> Result<(), Stopped> + Send + 'static,
{
    let calls = Calls::default();
    let solver = Like { solve, calls: calls.clone() };
    let reports = play(move || solver, batch(samples.to_vec()));
    let calls = calls.lock().expect("whole").clone();
    (reports, calls)
}

fn one_by_one(samples: &[Sample<'_>], recorder: &mut BatchRecorder<'_>) -> Result<(), Stopped> {
    (0..samples.len()).try_for_each(|index| {
        let begun = recorder.begin(index);
        let outcome = fine(vec![Some(begun.sample.params[0])]);
        recorder.finish(begun, outcome)
    })
}

/// Asserts that these samples failed as panicked, and that all others have their own value.
fn assert_failed(results: &BTreeMap<u64, &SampleReport>, samples: &[u64], failed: &[u64]) {
    assert_eq!(results.keys().copied().collect::<Vec<_>>(), samples);
    for (sample, done) in results {
        let expected = if failed.contains(sample) { Some(Cause::Panicked) } else { None };
        assert_eq!(done.outcome.cause, expected, "sample {sample}");
        assert_eq!(done.outcome.status == Status::Failed, expected.is_some(), "sample {sample}");
        let values = if expected.is_some() { vec![] } else { vec![Some(*sample as f64)] };
        assert_eq!(done.outcome.values, values, "sample {sample}");
    }
}

#[test]
fn a_batch_of_any_size_is_handed_to_the_solver_as_a_whole() {
    for size in [1, 2, 63, MAX_BATCH as u64] {
        let samples: Vec<u64> = (1..=size).collect();
        let (reports, calls) = play_like(&samples, one_by_one);
        assert_failed(&results(&reports), &samples, &[]);
        assert_eq!(calls, [samples]);
    }
}

#[test]
fn samples_may_be_under_way_together_and_finish_in_any_order() {
    let samples = [1, 2, 3, 4, 5, 6, 7];
    let (reports, calls) = play_like(&samples, |samples, recorder| {
        for four in (0..samples.len()).collect::<Vec<_>>().chunks(4) {
            let under_way: Vec<_> = four.iter().map(|&index| recorder.begin(index)).collect();
            for begun in under_way.into_iter().rev() {
                let outcome = fine(vec![Some(begun.sample.params[0])]);
                recorder.finish(begun, outcome)?;
            }
        }
        Ok(())
    });
    assert_failed(&results(&reports), &samples, &[]);
    assert_eq!(calls.len(), 1);
}

#[test]
fn when_several_are_under_way_in_a_panic_each_is_tried_alone_and_one_is_guilty() {
    let samples = [11, 12, 13, 14, 15, 16];
    let (reports, calls) = play_like(&samples, |samples, recorder| {
        for three in (0..samples.len()).collect::<Vec<_>>().chunks(3) {
            let under_way: Vec<_> = three.iter().map(|&index| recorder.begin(index)).collect();
            assert!(under_way.iter().all(|begun| begun.sample.number != 15), "the fifteenth");
            for begun in under_way {
                let outcome = fine(vec![Some(begun.sample.params[0])]);
                recorder.finish(begun, outcome)?;
            }
        }
        Ok(())
    });
    assert_failed(&results(&reports), &samples, &[15]);
    assert_eq!(calls, [&samples[..], &[0], &[14], &[15], &[0], &[16]]);
}

#[test]
fn the_rest_of_a_batch_goes_on_after_a_panic_without_what_is_finished() {
    let samples = [11, 12, 13, 14];
    let (reports, calls) = play_like(&samples, |samples, recorder| {
        (0..samples.len()).try_for_each(|index| {
            let begun = recorder.begin(index);
            assert!(begun.sample.number != 12, "the twelfth");
            let outcome = fine(vec![Some(begun.sample.params[0])]);
            recorder.finish(begun, outcome)
        })
    });
    assert_failed(&results(&reports), &samples, &[12]);
    assert_eq!(calls, [&samples[..], &[0], &[13, 14]]);
}

#[test]
fn a_panic_with_none_under_way_is_nobodys_until_each_was_tried_alone() {
    let samples = [11, 12, 13, 14];
    let (reports, calls) = play_like(&samples, |samples, recorder| {
        // Preparation of all samples at once.
        assert!(samples.iter().all(|sample| sample.number != 13), "the thirteenth");
        one_by_one(samples, recorder)
    });
    assert_failed(&results(&reports), &samples, &[13]);
    assert_eq!(calls, [&samples[..], &[0], &[11], &[12], &[13], &[0], &[14]]);
}

#[test]
fn a_panic_after_the_last_sample_costs_none() {
    let samples = [11, 12];
    let (reports, calls) = play_like(&samples, |samples, recorder| {
        one_by_one(samples, recorder)?;
        panic!("too late");
    });
    assert_failed(&results(&reports), &samples, &[]);
    assert_eq!(calls, [&samples[..], &[0]]);
}

#[test]
fn a_sample_that_the_solver_leaves_out_is_tried_alone_and_fails_if_it_is_left_out_again() {
    let samples = [11, 12, 13, 14];
    let (reports, calls) = play_like(&samples, |samples, recorder| {
        for (index, sample) in samples.iter().enumerate() {
            let is_left_out = sample.number == 14 || (sample.number == 12 && samples.len() > 1);
            if is_left_out {
                continue;
            }
            let begun = recorder.begin(index);
            let outcome = fine(vec![Some(begun.sample.params[0])]);
            recorder.finish(begun, outcome)?;
        }
        Ok(())
    });
    assert_failed(&results(&reports), &samples, &[14]);
    assert_eq!(calls, [&samples[..], &[0], &[12], &[14], &[0]]);
}

#[test]
fn a_sample_that_is_begun_and_never_finished_is_left_out() {
    let samples = [11, 12];
    let (reports, calls) = play_like(&samples, |samples, recorder| {
        (0..samples.len()).try_for_each(|index| {
            let begun = recorder.begin(index);
            if begun.sample.number == 11 {
                return Ok(());
            }
            let outcome = fine(vec![Some(begun.sample.params[0])]);
            recorder.finish(begun, outcome)
        })
    });
    assert_failed(&results(&reports), &samples, &[11]);
    assert_eq!(calls, [&samples[..], &[0], &[11], &[0]]);
}

#[test]
fn a_sample_that_is_begun_twice_while_it_is_under_way_fails() {
    let samples = [11, 12, 13];
    let (reports, calls) = play_like(&samples, |samples, recorder| {
        (0..samples.len()).try_for_each(|index| {
            let begun = recorder.begin(index);
            if begun.sample.number == 12 {
                let again = recorder.begin(index);
                drop(again);
            }
            let outcome = fine(vec![Some(begun.sample.params[0])]);
            recorder.finish(begun, outcome)
        })
    });
    assert_failed(&results(&reports), &samples, &[12]);
    assert_eq!(calls, [&samples[..], &[0], &[13]]);
}

/// A computed outcome is final; a second one is discarded.
#[test]
fn a_sample_that_is_begun_again_after_its_end_keeps_its_outcome() {
    let samples = [11, 12, 13];
    let (reports, calls) = play_like(&samples, |samples, recorder| {
        for index in 0..samples.len() {
            for value in [samples[index].params[0], f64::from(99)] {
                let begun = recorder.begin(index);
                recorder.finish(begun, fine(vec![Some(value)]))?;
            }
        }
        Ok(())
    });
    assert_failed(&results(&reports), &samples, &[]);
    assert_eq!(calls, [&samples[..], &[0], &[12], &[0], &[13], &[0]]);
}

#[test]
fn a_sample_that_is_not_in_the_batch_cannot_be_begun() {
    let (reports, _) = play_like(&[11], |samples, recorder| {
        one_by_one(samples, recorder)?;
        let begun = recorder.begin(samples.len());
        recorder.finish(begun, fine(vec![]))
    });
    assert_failed(&results(&reports), &[11], &[]);
}

#[test]
fn the_heartbeat_names_the_sample_begun_last_of_those_under_way() {
    let net = MemoryNet::default();
    let mut hub = HubLink::new(net.hub(), RUN);
    let heartbeat = Heartbeat::default();
    let seen = Arc::new(Mutex::new(Vec::new()));
    let (beats, shown) = (seen.clone(), heartbeat.clone());
    let solve = move |_: &[Sample<'_>], recorder: &mut BatchRecorder<'_>| {
        let look = || beats.lock().expect("whole").push(shown.beat());
        let first = recorder.begin(0);
        look();
        let second = recorder.begin(1);
        look();
        recorder.finish(second, fine(vec![]))?;
        look();
        recorder.finish(first, fine(vec![]))
    };
    let worker = start(net.worker(), &heartbeat, move || Like { solve, calls: Calls::default() });
    for answer in [ToWorker::Continue, ToWorker::Batch(batch(vec![11, 12]))] {
        let ticket = receive(&mut hub).ticket;
        hub.answer(ticket, WORKER, &answer).expect("answered");
    }
    let last = receive(&mut hub);
    let samples = seen.lock().expect("whole").iter().map(|beat| (beat.batch, beat.sample)).collect::<Vec<_>>();
    assert_eq!(samples, [11, 12, 11].map(|sample| (BatchId(1), Some(sample))));
    hub.answer(last.ticket, WORKER, &ToWorker::Stop).expect("answered");
    worker.join().expect("no panic").expect("told to stop");
    assert_eq!(heartbeat.beat().sample, None, "it waits");
}

/// Uses this much CPU time.
fn burn(milliseconds: u64) {
    let begun = thread_cpu_time();
    while thread_cpu_time() - begun < Duration::from_millis(milliseconds) {
        std::hint::spin_loop();
    }
}

#[test]
fn cpu_time_is_shared_by_those_under_way_and_preparation_by_all_that_are_left() {
    let (reports, _) = play_like(&[11, 12, 13], |_, recorder| {
        burn(90);
        let alone = recorder.begin(0);
        burn(50);
        recorder.finish(alone, fine(vec![]))?;
        let together = [recorder.begin(1), recorder.begin(2)];
        burn(200);
        together.into_iter().try_for_each(|begun| recorder.finish(begun, fine(vec![])))
    });
    let results = results(&reports);
    let cpu_s = [11, 12, 13].map(|sample| results[&sample].cpu_s);
    for (found, expected) in cpu_s.into_iter().zip([0.08, 0.13, 0.13]) {
        assert!((found - expected).abs() < 0.02, "{cpu_s:?}");
    }
}

#[test]
fn what_a_solver_hands_in_after_the_order_to_stop_is_not_sent() {
    let net = MemoryNet::default();
    let mut hub = HubLink::new(net.hub(), RUN);
    let refused = Arc::new(Mutex::new(Vec::new()));
    let log = refused.clone();
    let solve = move |samples: &[Sample<'_>], recorder: &mut BatchRecorder<'_>| {
        for index in 0..samples.len() {
            let begun = recorder.begin(index);
            // Sixteen of these fill a message.
            if recorder.finish(begun, fine(vec![Some(1.0); 256])).is_err() {
                log.lock().expect("whole").push(samples[index].number);
            }
        }
        panic!("also that is no matter now");
    };
    let worker = start(net.worker(), &Heartbeat::default(), move || Like { solve, calls: Calls::default() });
    for answer in [ToWorker::Continue, ToWorker::Batch(batch((20..84).collect())), ToWorker::Stop] {
        let ticket = receive(&mut hub).ticket;
        hub.answer(ticket, WORKER, &answer).expect("answered");
    }
    worker.join().expect("no panic").expect("told to stop");
    let mut last = Vec::new();
    while let Some(incoming) = hub.try_receive().expect("memory does not fail") {
        last.push(report(incoming));
    }
    let refused = refused.lock().expect("whole").clone();
    assert!(refused.len() > 1 && refused.ends_with(&[83]), "{refused:?}");
    assert!(last.iter().all(|report| !report.asks));
    assert!(results(&last).keys().all(|sample| *sample <= refused[0]), "{refused:?}");
}

/// Samples that wait behind a long one may meanwhile have been given to other workers.
#[test]
fn a_worker_told_to_leave_its_batch_begins_no_more_of_it_and_asks_for_the_next() {
    let net = MemoryNet::default();
    let mut hub = HubLink::new(net.hub(), RUN);
    let begun = Arc::new(Mutex::new(Vec::new()));
    let log = begun.clone();
    let solve = move |samples: &[Sample<'_>], recorder: &mut BatchRecorder<'_>| {
        (0..samples.len()).try_for_each(|index| {
            let begun = recorder.begin(index);
            log.lock().expect("whole").push(begun.sample.number);
            if begun.sample.number == 12 {
                std::thread::sleep(Duration::from_millis(500));
            }
            recorder.finish(begun, fine(vec![Some(1.0)]))
        })
    };
    let calls = Calls::default();
    let asked = calls.clone();
    let worker = start(net.worker(), &Heartbeat::default(), move || Like { solve, calls: asked });
    for answer in [ToWorker::Continue, ToWorker::Batch(batch(vec![11, 12, 13, 14]))] {
        let ticket = receive(&mut hub).ticket;
        hub.answer(ticket, WORKER, &answer).expect("answered");
    }
    let long = receive(&mut hub);
    let ticket = long.ticket;
    let long = report(long);
    assert!(!long.asks && results(&[long]).into_keys().eq([11, 12]));
    hub.answer(ticket, WORKER, &ToWorker::Leave).expect("answered");
    let next = receive(&mut hub);
    let ticket = next.ticket;
    assert_eq!(report(next), Report { batch: Some((BatchId(1), 1)), samples: Vec::new(), asks: true });
    hub.answer(ticket, WORKER, &ToWorker::Batch(batch(vec![15]))).expect("answered");
    let last = receive(&mut hub);
    let ticket = last.ticket;
    let last = report(last);
    assert!(last.asks && results(&[last]).into_keys().eq([15]));
    hub.answer(ticket, WORKER, &ToWorker::Stop).expect("answered");
    worker.join().expect("no panic").expect("told to stop");
    assert_eq!(*begun.lock().expect("whole"), [11, 12, 15]);
    assert_eq!(*calls.lock().expect("whole"), [vec![11, 12, 13, 14], vec![15]], "it is no fault to recover from");
}

/// A connection that panics at its third message.
struct Brittle(MemoryWorker, u32);

impl WorkerPort for Brittle {
    fn send(&mut self, block: &FromWorkerBlock) -> Result<(), PortError> {
        self.1 += 1;
        assert!(self.1 < 3, "the connection panics");
        self.0.send(block)
    }
    fn try_receive(&mut self, block: &mut ToWorkerBlock) -> Result<bool, PortError> {
        self.0.try_receive(block)
    }
    fn wait(&mut self) -> Result<(), PortError> {
        self.0.wait()
    }
}

/// Without this distinction, the results in that message would be lost and a sample would be blamed.
#[test]
fn a_panic_of_the_connection_is_not_taken_for_one_of_the_solver() {
    let net = MemoryNet::default();
    let mut hub = HubLink::new(net.hub(), RUN);
    let calls = Calls::default();
    let asked = calls.clone();
    let solve = |samples: &[Sample<'_>], recorder: &mut BatchRecorder<'_>| {
        (0..samples.len()).try_for_each(|index| {
            let begun = recorder.begin(index);
            recorder.finish(begun, fine(vec![Some(1.0); 256]))
        })
    };
    let worker = start(Brittle(net.worker(), 0), &Heartbeat::default(), move || Like { solve, calls: asked });
    for answer in [ToWorker::Continue, ToWorker::Batch(batch((20..84).collect()))] {
        let ticket = receive(&mut hub).ticket;
        hub.answer(ticket, WORKER, &answer).expect("answered");
    }
    assert!(worker.join().is_err(), "the worker ends");
    assert_eq!(calls.lock().expect("whole").len(), 1);
}
