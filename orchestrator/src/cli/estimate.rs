//! Estimated computing time of a study, from a few of its samples spread over all axes, measured in parallel and with time limits.

use super::error::CliError;
use super::extent::{Extent, extents, wall_told};
use super::output::{remark, tell, width};
use super::run::default_workers;
use super::shared::structural;
use crate::engine;
use crate::terminal::{matrices_of, with_word};
use bladeoff_answers::summary::{Align, TextTable, counted, duration};
use bladeoff_core::modal::Basis;
use bladeoff_core::record::{Follower, Frame};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::Engine;
use bladeoff_study::Samples;
use bladeoff_worker::process::thread_cpu_time;
use serde_json::{Value, json};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Number of timed samples of a larger study. A prime, so that its multiples visit all places of an axis.
const TIMED: u64 = 7;
/// Largest CPU time of a timed sample; the rest is extrapolated from its steps.
const LONGEST: Duration = Duration::from_secs(20);
/// Total time after which no further sample is timed.
const PATIENCE: Duration = Duration::from_secs(90);
/// Number of steps between two checks of the clock.
const LOOK_EVERY: u64 = 64;
/// Number of samples among which those nearest to the selected places are searched.
const CANDIDATES: u64 = 20_000;
/// Relative error of the mean in addition to the scatter, because the speed of a machine varies.
const NOISE: f64 = 0.1;
/// Standard errors on either side of the mean: 95 % for seven samples.
const ERRORS: f64 = 2.5;

/// One timed sample.
struct Timed {
    sample: u64,
    /// CPU time of the whole run \[s\], extrapolated if it was cut off.
    cpu: f64,
    /// End of the run, or the fraction of the steps at which it was cut off.
    words: String,
    cut: bool,
}

/// Timed samples of a study, and the predicted time of the study.
pub(super) struct Estimate {
    timed: Vec<Timed>,
    /// Whether each sample has matrices of its own.
    is_structural: bool,
    extents: Vec<(Extent, [f64; 2], [f64; 2])>,
}

impl Estimate {
    /// Times samples of the study.
    ///
    /// # Errors
    /// A sample that cannot be built or started.
    pub fn of(samples: &Samples) -> Result<Self, CliError> {
        let chosen = choose(samples);
        let begun = Instant::now();
        let structures = structures(samples)?;
        if let Structures::One(structure) = &structures {
            warm_up(samples, structure, begun + PATIENCE)?;
        }
        let timed = time_all(samples, &chosen, &structures, begun)?;
        let workers = default_workers();
        let cpu: Vec<f64> = timed.iter().map(|one| one.cpu).collect();
        let longest = cpu.iter().copied().fold(0.0, f64::max);
        let mut found = Vec::new();
        if !timed.is_empty() {
            for extent in extents(samples)? {
                let [low, high] = whole(&cpu, extent.samples);
                let shared = (workers as f64).min(extent.samples as f64);
                // at the end all workers wait for the last sample
                let wall = [low / shared, high / shared + longest * (1.0 - 1.0 / shared)];
                found.push((extent, [low, high], wall));
            }
        }
        Ok(Self { timed, is_structural: matches!(structures, Structures::Own(_)), extents: found })
    }

    /// Timed samples and ranges of times \[s\].
    pub fn json(&self) -> Value {
        let timed = |one: &Timed| json!({ "sample": one.sample, "cpu_s": one.cpu, "extrapolated": one.cut });
        let extent = |(extent, cpu, wall): &(Extent, [f64; 2], [f64; 2])| json!({ "name": extent.name, "samples": extent.samples, "cpu_s": cpu, "wall_s": wall });
        json!({
            "workers": default_workers(),
            "timed": self.timed.iter().map(timed).collect::<Vec<_>>(),
            "durations": self.extents.iter().map(extent).collect::<Vec<_>>(),
        })
    }
}

/// Times samples of the study and prints the predicted time of the whole study.
///
/// # Errors
/// A sample that cannot be built or started.
pub(super) fn estimate(samples: &Samples) -> Result<(), CliError> {
    let Estimate { timed, is_structural, extents } = Estimate::of(samples)?;
    let mut table =
        TextTable::new(&[("sample", Align::Right), ("CPU", Align::Right), ("", Align::Left), ("with", Align::Left)]);
    for one in &timed {
        let cpu = duration(Duration::from_secs_f64(one.cpu));
        let cpu = if one.cut { format!("about {cpu}") } else { cpu };
        table.row(vec![one.sample.to_string(), cpu, one.words.clone(), samples.describe(one.sample)]);
    }
    let mut text = format!(
        "\ntimed {} of {}:\n{}\n",
        timed.len(),
        counted(samples.count(), "sample"),
        table.fitting("  ", width())
    );
    if timed.is_empty() {
        text.push_str(&format!(
            "no sample reached its first step within {}: the duration of the study is unknown\n",
            duration(PATIENCE)
        ));
        return tell(&text);
    }
    if is_structural {
        text.push_str("Each sample's time holds that of its own matrices and modes.\n");
    }
    if timed.iter().any(|one| one.cut) {
        text.push_str(&format!(
            "A sample is stopped after {} of CPU time (all together after {}). Its whole time is extrapolated from its steps up to run.end_time: steps in contact take longer, \
             a rotor that stops ends sooner.\n",
            duration(LONGEST),
            duration(PATIENCE)
        ));
    }
    let workers = default_workers();
    for (extent, cpu, wall) in extents {
        text.push_str(&format!(
            "{}: about {} of CPU time; {} with {} on idle cores\n",
            extent.name,
            range(cpu),
            range(wall),
            counted(workers as u64, "worker")
        ));
    }
    text.push_str(&wall_told(samples));
    tell(&text)
}

fn range([low, high]: [f64; 2]) -> String {
    let [from, to] = [low, high].map(|seconds| duration(Duration::from_secs_f64(seconds.min(1e12))));
    if from == to { from } else { format!("{from} to {to}") }
}

/// CPU time of `count` samples like these \[s\]: from their mean, its standard error and the noise, within the smallest and the
/// largest of them.
fn whole(cpu: &[f64], count: u64) -> [f64; 2] {
    let timed = cpu.len() as f64;
    let mean = cpu.iter().sum::<f64>() / timed;
    let squares: f64 = cpu.iter().map(|one| (one - mean) * (one - mean)).sum();
    // no sampling error if all samples were timed
    let rest = 1.0 - timed / (count as f64).max(timed);
    let error = if cpu.len() > 1 { (squares / (timed - 1.0) / timed * rest).sqrt() } else { 0.0 };
    let (least, most) = cpu.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &one| (low.min(one), high.max(one)));
    let low = (mean - ERRORS * error).max(least) * (1.0 - NOISE);
    let high = (mean + ERRORS * error).min(most) * (1.0 + NOISE);
    [low, high].map(|one| one * count as f64)
}

/// Samples that cover every axis from its first to its last value: the `k`th is at index `k s` (modulo the number of samples) of an axis
/// with its own step `s`. The first is the first sample of the study, a corner.
fn choose(samples: &Samples) -> Vec<u64> {
    let count = samples.count();
    if count <= TIMED {
        return (0..count).collect();
    }
    let axes = samples.study().axes.iter().map(|axis| axis.length);
    let points = samples.layout().map(|_| samples.points());
    let lengths: Vec<u64> = points.into_iter().chain(axes).collect();
    let place = |position: u64, length: u64| if length > 1 { position as f64 / (length - 1) as f64 } else { 0.0 };
    let wanted = |k: u64, axis: usize| ((k * (1 + axis as u64 % (TIMED - 1))) % TIMED) as f64 / (TIMED - 1) as f64;
    let candidates: Vec<(u64, Vec<f64>)> = (0..count.min(CANDIDATES))
        .map(|i| {
            // evenly spread, without a period that could coincide with that of an axis
            let scattered = i.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let sample =
                if count <= CANDIDATES { i } else { ((u128::from(scattered) * u128::from(count)) >> 64) as u64 };
            let positions = samples.point(sample).into_iter().chain(samples.positions(sample));
            let places = positions.zip(&lengths).map(|(position, length)| place(position, *length)).collect();
            (sample, places)
        })
        .collect();
    let mut chosen: Vec<u64> = Vec::new();
    for k in 0..TIMED {
        let distance = |places: &[f64]| -> f64 {
            places.iter().enumerate().map(|(axis, place)| (place - wanted(k, axis)) * (place - wanted(k, axis))).sum()
        };
        let free = candidates.iter().filter(|(sample, _)| !chosen.contains(sample));
        let nearest = free.min_by(|a, b| distance(&a.1).total_cmp(&distance(&b.1)).then(a.0.cmp(&b.0)));
        chosen.extend(nearest.map(|(sample, _)| *sample));
    }
    chosen.sort_unstable();
    chosen
}

/// Times samples on all cores; samples not begun before the deadline are omitted.
fn time_all(
    samples: &Samples,
    chosen: &[u64],
    structures: &Structures,
    begun: Instant,
) -> Result<Vec<Timed>, CliError> {
    let deadline = begun + PATIENCE;
    let next = AtomicUsize::new(0);
    let (send, receive) = channel();
    let mut timed = Vec::new();
    thread::scope(|scope| {
        for _ in 0..default_workers().min(chosen.len()) {
            let (send, next) = (send.clone(), &next);
            scope.spawn(move || {
                while let Some(sample) = chosen.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if Instant::now() >= deadline || send.send(time(samples, *sample, structures, deadline)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(send);
        let mut wait = Duration::from_secs(1);
        loop {
            match receive.recv_timeout(wait) {
                Ok(one) => timed.extend(one.transpose()),
                Err(RecvTimeoutError::Timeout) => {
                    remark(&format!(
                        "timing {} of {}, at most {}: {} done after {}",
                        chosen.len(),
                        counted(samples.count(), "sample"),
                        duration(PATIENCE),
                        timed.len(),
                        duration(begun.elapsed())
                    ));
                    wait = Duration::from_secs(10);
                }
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
    });
    let mut timed = timed.into_iter().collect::<Result<Vec<Timed>, CliError>>()?;
    timed.sort_unstable_by_key(|one| one.sample);
    Ok(timed)
}

/// Source of the matrices and modes of the samples.
enum Structures {
    /// One structure for all samples.
    One(Box<Structure>),
    /// A structure for each sample; a worker reuses parts of the basis that the run freezes.
    Own(Basis),
}

fn structures(samples: &Samples) -> Result<Structures, CliError> {
    let shared = structural(samples).is_empty();
    let without = samples.study().machine().and_then(|machine| machine.def.build().ok());
    let machine = without.filter(|_| !shared).map_or_else(|| samples.machine(0).build(), Ok)?;
    let structure = with_word(|| matrices_of(&machine), || engine::build(&machine))?;
    Ok(if shared { Structures::One(Box::new(structure)) } else { Structures::Own(structure.basis().clone()) })
}

/// Runs the first sample twice without timing it: the exponential engine computes some data once for all samples of a structure, part of it
/// in the second run. Not needed for a study that is timed completely.
fn warm_up(samples: &Samples, structure: &Structure, deadline: Instant) -> Result<(), CliError> {
    let machine = samples.machine(0).build()?;
    if machine.run.engine != Engine::Exponential || samples.count() <= TIMED {
        return Ok(());
    }
    let mut watch = Watch { begun: thread_cpu_time(), deadline, steps: 0, cut: false };
    for _ in 0..2 {
        if !watch.cut {
            engine::simulate_watched(&machine, structure, &mut watch)?;
        }
    }
    Ok(())
}

/// Times one sample; `None` if no step was finished before the deadline.
fn time(samples: &Samples, sample: u64, structures: &Structures, deadline: Instant) -> Result<Option<Timed>, CliError> {
    let machine = samples.machine(sample).build()?;
    let before = thread_cpu_time();
    let built;
    let (structure, set_up) = match structures {
        Structures::One(structure) => (&**structure, 0.0),
        Structures::Own(basis) => {
            built = engine::build_with(&machine, basis).or_else(|_| engine::build(&machine))?;
            (&built, thread_cpu_time().saturating_sub(before).as_secs_f64())
        }
    };
    let time_step = engine::time_step(&machine, structure)?;
    let mut watch = Watch { begun: thread_cpu_time(), deadline, steps: 0, cut: false };
    let outcome = engine::simulate_watched(&machine, structure, &mut watch)?;
    let cpu = thread_cpu_time().saturating_sub(watch.begun).as_secs_f64();
    if !watch.cut {
        let cause = outcome.cause.map(|cause| format!(" ({})", cause.word())).unwrap_or_default();
        let words = format!("{}{cause}", outcome.status.word());
        return Ok(Some(Timed { sample, cpu: cpu + set_up, words, cut: false }));
    }
    if watch.steps == 0 {
        return Ok(None);
    }
    let steps = (machine.run.end_time / time_step.step).ceil();
    let steps = machine.run.step_limit.map_or(steps, |limit| steps.min(limit as f64));
    // the steps of a twin are counted together with those of the first run
    let steps = if machine.run.twin > 0.0 { 2.0 * steps } else { steps };
    let part = (watch.steps as f64 / steps).min(1.0);
    // a fraction below 0.01 % would print as "0.00 %"
    let words = format!("stopped at {:.2e} of {steps:.2e} steps", watch.steps as f64);
    Ok(Some(Timed { sample, cpu: cpu / part + set_up, words, cut: true }))
}

/// A follower that ends a run at the deadline.
struct Watch {
    begun: Duration,
    deadline: Instant,
    steps: u64,
    cut: bool,
}

impl Follower for Watch {
    fn goes_on(&mut self, step: u64) -> bool {
        self.steps = step;
        if step.is_multiple_of(LOOK_EVERY) {
            self.cut = thread_cpu_time().saturating_sub(self.begun) > LONGEST || Instant::now() > self.deadline;
        }
        !self.cut
    }
    fn follows(&self) -> bool {
        false
    }
    fn wants_energies(&self) -> bool {
        false
    }
    fn wants(&mut self, _step: u64, _time: f64) -> bool {
        false
    }
    fn see(&mut self, _frame: &Frame<'_>) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_study::load;
    use std::collections::BTreeSet;
    use std::fs;

    fn samples(vary: &str, limit: Option<u64>) -> Samples {
        let folder = tempfile::tempdir().expect("temporary directory");
        fs::write(folder.path().join("m.toml"), include_str!("../../../studies/machines/lab_rig.toml"))
            .expect("written");
        let file = folder.path().join("s.toml");
        fs::write(&file, format!("schema = 1\nmachine = \"m.toml\"\n{vary}")).expect("written");
        Samples::new(load(&file, |_| Vec::new()).expect("valid"), None, limit).expect("small")
    }

    const GRID: &str = "[[vary]]\npath = \"contact.gap\"\nfrom = \"0.4 mm\"\nto = \"1 mm\"\ncount = \
                        31\n[[vary]]\npath = \"contact.friction\"\nfrom = 0.1\nto = 0.3\ncount = 21\n[[vary]]\npath = \
                        \"contact.detection\"\nvalues = [\"hyp1\", \"hyp2\", \"hyp2-frozen\"]\n";

    #[test]
    fn timed_samples_see_both_ends_of_every_axis_and_every_word() {
        let all = samples(GRID, None);
        let chosen = choose(&all);
        assert_eq!((chosen.len(), chosen[0]), (7, 0));
        for (axis, length) in [31, 21, 3].into_iter().enumerate() {
            let positions: BTreeSet<u64> = chosen.iter().map(|sample| all.positions(*sample)[axis]).collect();
            assert!(positions.contains(&0) && positions.contains(&(length - 1)), "{axis}: {positions:?}");
            assert!(positions.len() == 7.min(length as usize), "{axis}: {positions:?}");
        }
        let few = samples(GRID, Some(5));
        assert_eq!(choose(&few), [0, 1, 2, 3, 4]);
        let part = samples(GRID, Some(100));
        assert_eq!(choose(&part).iter().collect::<BTreeSet<_>>().len(), 7);
    }

    #[test]
    fn a_large_study_is_chosen_from_without_a_period() {
        let text = "[[vary]]\npath = \"blade_off.mass\"\nfrom = \"1 g\"\nto = \"2 g\"\ncount = 100000\n[[vary]]\npath \
                    = \"contact.detection\"\nvalues = [\"hyp1\", \"hyp2\"]\n";
        let all = samples(text, None);
        let ends: BTreeSet<u64> = choose(&all).iter().map(|sample| all.positions(*sample)[1]).collect();
        assert_eq!(ends.len(), 2);
    }

    #[test]
    fn the_range_holds_the_mean_and_lies_within_the_samples() {
        let [low, high] = whole(&[1.0, 2.0, 3.0], 3);
        assert!((low - 5.4).abs() < 1e-9 && (high - 6.6).abs() < 1e-9, "timed whole: {low} {high}");
        let [low, high] = whole(&[1.0, 2.0, 3.0], 3000);
        assert!(low < 6000.0 && high > 6000.0 && low > 2699.9 && high < 9900.1, "{low} {high}");
        assert_eq!(range([60.0, 60.2]), "1 min 00 s");
        assert_eq!(range([3600.0, 7200.0]), "1 h 00 min to 2 h 00 min");
    }

    #[test]
    fn a_run_that_takes_too_long_is_cut_and_told_from_its_steps() {
        let all = samples("[set]\n\"run.step\" = 1e-10\n", None);
        let one = time(&all, 0, &structures(&all).expect("buildable"), Instant::now()).expect("it starts");
        assert!(one.is_none(), "no step within no time");
        let one = time(&all, 0, &structures(&all).expect("buildable"), Instant::now() + Duration::from_secs(3))
            .expect("it starts")
            .expect("some steps");
        assert!(one.cut && one.words.ends_with("of 6.00e9 steps") && one.cpu > 1000.0, "{} {}", one.words, one.cpu);
        // a twin doubles the steps, and is cut off as well
        let all = samples("[set]\n\"run.step\" = 1e-10\n\"run.twin\" = 1e-6\n", None);
        let one = time(&all, 0, &structures(&all).expect("buildable"), Instant::now() + Duration::from_secs(3))
            .expect("it starts")
            .expect("some steps");
        assert!(one.cut && one.words.ends_with("of 1.20e10 steps"), "{}", one.words);
        let all = samples("[set]\n\"run.end_time\" = 1e-3\n\"run.twin\" = 1e-6\n\"run.engine\" = \"reduced\"\n", None);
        let mut watch = Watch { begun: thread_cpu_time(), deadline: Instant::now() + LONGEST, steps: 0, cut: false };
        let machine = all.machine(0).build().expect("valid");
        let structure = engine::build(&machine).expect("buildable");
        let steps = machine.run.end_time / engine::time_step(&machine, &structure).expect("stable").step;
        engine::simulate_watched(&machine, &structure, &mut watch).expect("it starts");
        assert!(!watch.cut && watch.steps as f64 > 1.9 * steps, "{} of twice {steps}", watch.steps);
    }
}
