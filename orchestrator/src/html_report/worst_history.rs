//! The history of the worst run: its largest values in equal intervals of time, so that no peak falls between two plotted points.

use super::Computed;
use super::rows::{Extreme, Seen};
use super::words::kind_in_words;
use bladeoff_answers::figures::Scale;
use bladeoff_answers::page::Block;
use bladeoff_answers::page::chart::{Axis, Chart, Series, Shape};
use bladeoff_answers::summary::worst_least;
use bladeoff_core::record::{Follower, Frame, LastMillisecond};
use bladeoff_model::machine::Machine;
use bladeoff_text::document::units::format_digits;

/// Number of intervals of time.
const PARTS: usize = 600;
/// Largest sampling interval \[s\].
const EVERY: f64 = 1e-4;

/// Largest values within one interval of time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Part {
    /// Last sampled time of the interval \[s\].
    time: f64,
    /// Spin speed at that time \[rad/s\].
    speed: f64,
    /// Largest bearing load of all bearings \[N\].
    load: f64,
    /// Largest distance of the rotor centre from the centre of a diaphragm \[m\].
    eccentricity: f64,
    /// Largest 1 ms mean of the contact force on one diaphragm \[N\].
    force: f64,
}

/// Observer of a run that keeps the largest values of each interval of time.
#[derive(Debug)]
pub struct Envelope {
    parts: Vec<Part>,
    /// Length of an interval \[s\].
    part: f64,
    /// Time between two samples, and the time of the next one \[s\].
    every: f64,
    next: f64,
    /// Contact forces on each diaphragm over the last millisecond.
    forces: Vec<LastMillisecond>,
}

impl Envelope {
    /// An observer of a run of this machine in steps of `step` \[s\].
    #[must_use]
    pub fn new(machine: &Machine, step: f64) -> Self {
        let part = (machine.run.end_time / PARTS as f64).max(step);
        Self {
            parts: Vec::new(),
            part,
            every: EVERY.min(0.25 * part),
            next: 0.0,
            forces: machine.diaphragms.iter().map(|_| LastMillisecond::new(step)).collect(),
        }
    }

    /// The interval that contains a time; it is added if it does not exist.
    fn part_of(&mut self, time: f64) -> &mut Part {
        let at = ((time / self.part) as usize).min(PARTS);
        // rounding may leave an interval without a sample: it takes the values of the interval before
        while self.parts.len() < at {
            self.parts.push(self.parts.last().copied().unwrap_or_default());
        }
        if self.parts.len() == at {
            self.parts.push(Part { time, speed: self.parts.last().map_or(0.0, |last| last.speed), ..Part::default() });
        }
        &mut self.parts[at]
    }
}

impl Follower for Envelope {
    fn contact_force(&mut self, diaphragm: usize, time: f64, force: f64) {
        let Some(last) = self.forces.get_mut(diaphragm) else { return };
        last.slide(force);
        if let Some(sum) = last.sum() {
            let mean = sum / last.length() as f64;
            let part = self.part_of(time);
            part.force = part.force.max(mean);
        }
    }

    fn wants(&mut self, _step: u64, time: f64) -> bool {
        let is_due = time >= self.next;
        if is_due {
            self.next = time + self.every;
        }
        is_due
    }

    fn wants_end(&mut self) -> bool {
        true
    }

    fn wants_energies(&self) -> bool {
        false
    }

    fn see(&mut self, frame: &Frame<'_>) {
        let size = |[x, y]: [f64; 2]| x.hypot(y);
        let load = frame.bearing_loads.iter().map(|load| size(*load)).fold(0.0, f64::max);
        let eccentricity = frame.contacts.iter().map(|contact| size(contact.rotor)).fold(0.0, f64::max);
        let part = self.part_of(frame.time);
        (part.time, part.speed) = (frame.time, frame.speed);
        part.load = part.load.max(load);
        part.eccentricity = part.eccentricity.max(eccentricity);
    }
}

/// The run whose history is shown: the worst of the first result that is ranked.
pub(super) fn worst_run(seen: &Seen) -> Option<(&str, &Extreme)> {
    seen.coordinates.iter().zip(&seen.ends).filter(|(of, _)| of.is_result).find_map(|(of, ends)| {
        let end = if worst_least(&of.column).is_some() { &ends.least } else { &ends.largest };
        Some((of.name.as_str(), end.all.first()?))
    })
}

/// The charts, one for each quantity that the run has.
pub(super) fn blocks(name: &str, worst: &Extreme, computed: &Computed) -> Vec<Block> {
    let Computed { machine, envelope, differs } = computed;
    let (parts, has_contact) = (&envelope.parts, !machine.diaphragms.is_empty());
    let every = format_digits(envelope.part, "s", 2);
    let mut blocks = vec![
        Block::Heading(format!("History of sample {}, the worst run by {name}", worst.sample)),
        Block::Text(format!(
            "Status {}. The run was computed again for this page. Each point is the largest value within {every}; the speed is that at its end.",
            kind_in_words(&worst.kind)
        )),
    ];
    blocks.extend(differs.clone().map(Block::Warning));
    type Read = fn(&Part) -> f64;
    let quantities: [(&str, &str, Read, bool); 4] = [
        ("speed", "rad/s", |part| part.speed, true),
        ("bearing load", "N", |part| part.load, !machine.rotor.bearings.is_empty()),
        ("eccentricity at the diaphragm", "m", |part| part.eccentricity, has_contact),
        ("contact force, 1 ms mean", "N", |part| part.force, has_contact),
    ];
    for (name, unit, read, is_there) in quantities {
        let largest = parts.iter().map(read).fold(0.0, f64::max);
        if !is_there || largest == 0.0 {
            continue;
        }
        let scale = Scale::of(unit, largest);
        let line: Vec<(f64, f64)> = parts.iter().map(|part| (part.time, read(part) * scale.factor)).collect();
        // the axis has room only for the text before the comma
        let short = name.split(',').next().unwrap_or(name).trim_end_matches(" at the diaphragm");
        let chart = Chart {
            x: Axis::numbers("time [s]", line.iter().map(|point| point.0)),
            y: Axis::numbers(scale.label(short), line.iter().map(|point| point.1).chain([0.0])),
            series: vec![Series { name: String::new(), colour: "c0", shape: Shape::Line(line, false) }],
            height: 140,
        };
        blocks.push(chart.figure(format!("Sample {}: {name}, over time.", worst.sample), None).into());
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_core::record::Energies;

    #[test]
    fn a_peak_between_two_points_is_kept() {
        let mut envelope = Envelope {
            parts: Vec::new(),
            part: 0.01,
            every: 1e-4,
            next: 0.0,
            forces: vec![LastMillisecond::new(1e-4)],
        };
        for (time, load) in [(0.0, 1.0), (0.004, 7.0), (0.009, 2.0), (0.035, 3.0)] {
            envelope.see(&Frame {
                time,
                angle: 0.0,
                speed: 100.0,
                displacement: &[],
                velocity: &[],
                torsion_angles: &[],
                bearing_loads: &[[load, 0.0]],
                pedestal_loads: &[],
                contacts: &[],
                energies: Energies::default(),
            });
        }
        let loads: Vec<f64> = envelope.parts.iter().map(|part| part.load).collect();
        assert_eq!(loads, [7.0, 7.0, 7.0, 3.0]);
        // ten steps of 1e-4 s are 1 ms: the force of one step contributes a tenth of it to the mean
        envelope.contact_force(0, 0.036, 50.0);
        assert_eq!(envelope.parts[3].force, 5.0);
    }
}
