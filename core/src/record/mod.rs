//! What a run is watched for: recorders, each of one quantity of interest or a few, and the row of the table they make.
//!
//! An engine hands in a `RotorInstant`, plain numbers that say what all recorders together need of the state, and a `RingInstant` for each
//! diaphragm; of energies it adds the works of a step and writes the stores, as its scheme has them. A recorder knows no engine. It reports each of its columns together with its value, in one place (`Row`), so that
//! [`columns`] and the values of an outcome cannot disagree. The order of the table is that of `Recorders::report`.
//! Who follows the motion itself, for a history, is a [`Follower`].

mod contact;
mod damping;
mod end;
mod energies;
mod filter;
mod follow;
mod limits;
mod loads;
mod monitor;
mod peak;
mod phases;
mod releases;
mod ring;
mod ring_stresses;
mod row;
mod stresses;
mod twin;
mod verdict;
mod von_mises;
mod whirl;

pub use energies::Energies;
pub use filter::LastMillisecond;
pub use follow::{ContactFrame, Follower, Frame, NoHistory};

pub(crate) use contact::Touch;
pub(crate) use end::End;
pub(crate) use energies::EnergyBalance;
pub(crate) use peak::{At, Peak};
pub(crate) use ring::RingInstant;
pub(crate) use ring_stresses::RingState;
pub(crate) use twin::{Compared, Twin};

use end::Steps;
use limits::LimitRecorder;
use loads::LoadRecorder;
use monitor::MonitorRecorder;
use releases::ReleaseRecorder;
use ring::RingRecorders;
use row::Row;
use stresses::StressRecorder;
use verdict::{Guards, Verdict};

use crate::modal::{DampingGrid, LeastDamping};
use crate::structure::{RingPart, Structure};
use bladeoff_model::machine::{Machine, OnExceed};
use bladeoff_model::outcome::{Column, Group, Limit, Outcome, Status};
use bladeoff_numerics::linalg::Matrix;
use std::ops::Range;

/// The numeric columns of one machine's outcome, in table order. They depend on its bearing names and on the number of its
/// shaft sections alone, never on what a study varies. Of the sections the first 12 have columns of their own. The last columns have what
/// was reached while all guards held ([`Column::guarded`]).
#[must_use]
pub fn columns(machine: &Machine) -> Vec<Column> {
    let mut columns = Vec::new();
    // neither a ring's matrices nor the step have a say in them
    let recorders = Recorders::new(machine, &[], 0.0);
    let mut row = Row::columns(&mut columns);
    recorders.report(None, None, &mut row);
    row.end(true);
    columns
}

/// Place of the number of whole time steps among [`columns`].
#[must_use]
pub fn place_of_steps(machine: &Machine) -> usize {
    columns(machine).iter().position(|column| column.name == Steps::DONE).expect("every run counts its steps")
}

/// Loads, displacements and torsion angles of the rotor at one instant, from any engine.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RotorInstant<'a> {
    pub at: At,
    pub loads: Loads<'a>,
    /// Lateral displacements and torsion angles of the nodes.
    pub lateral: &'a [f64],
    pub torsion_angles: &'a [f64],
}

/// Forces and displacements at the bearings at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Loads<'a> {
    /// Loads of all bearings, in the machine's order \[N\].
    pub bearings: &'a [[f64; 2]],
    /// Loads of the pedestals, in the order of the bearings that have one \[N\].
    pub pedestals: &'a [[f64; 2]],
    /// Displacements of the journals whose bearings have a clearance, in the machine's order \[m\].
    pub journals: &'a [[f64; 2]],
    /// Displacements of the shaft at the monitors, in the machine's order \[m\].
    pub monitors: &'a [[f64; 2]],
}

fn square([x, y]: [f64; 2]) -> f64 {
    x * x + y * y
}

/// The recorders of one run.
#[derive(Debug, Clone)]
pub(crate) struct Recorders {
    pub energies: EnergyBalance,
    damping: LeastDamping,
    loads: LoadRecorder,
    monitors: MonitorRecorder,
    releases: ReleaseRecorder,
    stresses: StressRecorder,
    steps: Steps,
    /// One for each diaphragm, in the machine's order.
    rings: Vec<RingRecorders>,
    guards: Guards,
    pub limits: LimitRecorder,
    /// A material has a yield strength.
    yields: bool,
    /// The machine has a twin run.
    twins: bool,
}

impl Recorders {
    /// For a run in steps of `step` \[s\] with the structure's flexible rings.
    pub fn new(machine: &Machine, rings: &[Option<RingPart>], step: f64) -> Self {
        let part = |i: usize| rings.get(i).and_then(Option::as_ref);
        let ring =
            |(i, diaphragm)| RingRecorders::new(diaphragm, ring::diaphragm_name(machine, diaphragm), part(i), step);
        let mut all = Self {
            loads: LoadRecorder::new(&machine.rotor),
            monitors: MonitorRecorder::new(&machine.monitors),
            releases: ReleaseRecorder::new(&machine.rotor),
            stresses: StressRecorder::new(&machine.rotor.kind),
            energies: EnergyBalance::default(),
            damping: LeastDamping::default(),
            steps: Steps { length: step },
            rings: machine.diaphragms.iter().enumerate().map(ring).collect(),
            guards: Guards::default(),
            limits: LimitRecorder::new(machine, step),
            yields: false,
            twins: machine.run.twin > 0.0,
        };
        all.yields = [all.ring_yield(), all.blade_yield(), all.shaft_yield()].iter().any(Option::is_some);
        all
    }

    /// Adds to the bending of the shaft the static response of the truncated modes to the forces of bearing seats off the bearing line.
    pub fn settle_shaft(&mut self, machine: &Machine, structure: &Structure) {
        if let Some(lateral) = structure.truncated_seats(&machine.rotor) {
            self.stresses.settle(lateral);
        }
    }

    /// Takes an instant, and that of each diaphragm in the machine's order; energies are taken by themselves, when the works of the step
    /// are known.
    #[inline]
    pub fn see<'r>(&mut self, now: &RotorInstant<'_>, rings: impl Iterator<Item = RingInstant<'r>>) {
        self.loads.see(now.loads, now.at);
        self.monitors.see(now.loads.monitors, now.at);
        self.limits.see_journals(now.loads.journals, now.at);
        self.stresses.see(now.lateral, now.torsion_angles, now.at);
        for (place, (recorders, ring)) in self.rings.iter_mut().zip(rings).enumerate() {
            recorders.see(&ring, now.at);
            self.limits.see_eccentricity(place, square(ring.place), now.at);
        }
        self.see_yields();
    }

    /// Takes the largest ratios to the yield strengths so far: each has the time at which it was reached.
    #[inline]
    pub fn see_yields(&mut self) {
        if !self.yields {
            return;
        }
        let all = [
            (Limit::RingYield, self.ring_yield()),
            (Limit::BladeYield, self.blade_yield()),
            (Limit::ShaftYield, self.shaft_yield()),
        ];
        for (limit, peak) in all {
            if let Some((ratio, at)) = peak.and_then(|peak| Some((peak.value?, peak.at))) {
                self.limits.see(limit, ratio, at);
            }
        }
    }

    /// Takes loads and journals of an instant at which a step begins; `touches`: with contact. An engine whose steps are not equal sees
    /// diaphragms and moments by themselves ([`Recorders::see_ring`], [`Recorders::see_bending`], [`Recorders::see_torsion`]), then
    /// yield strengths ([`Recorders::see_yields`]).
    #[inline(always)]
    pub fn see_loads(&mut self, loads: Loads<'_>, at: At, touches: bool) {
        self.loads.see(loads, at);
        self.loads.see_between(loads, at, !touches);
        self.monitors.see(loads.monitors, at);
        self.limits.see_journals(loads.journals, at);
    }

    /// Takes an instant of a diaphragm: of a step, or of so many at once in which nothing touches; with a [`RingInstant::ring`] where
    /// the engine has one.
    #[inline(always)]
    pub fn see_ring(&mut self, diaphragm: usize, steps: usize, at: At, ring: &RingInstant<'_>) {
        let recorders = &mut self.rings[diaphragm];
        if steps == 1 {
            recorders.see(ring, at);
        } else {
            recorders.pass(steps, ring, at);
        }
        self.limits.see_eccentricity(diaphragm, square(ring.place), at);
    }

    /// Whether a mean spin \[rad/s\] lies beyond those taken by [`Recorders::see_speed`] by more than `noticeable`.
    #[inline]
    pub fn is_new_speed(&self, speed: f64, noticeable: f64) -> bool {
        self.damping.is_new(speed, noticeable)
    }

    /// Takes a time with its mean spin, and the damping of whirl modes over the speed.
    pub fn see_speed(&mut self, at: At, grid: &dyn DampingGrid) {
        let before = self.damping.least();
        if self.damping.see(at.speed, grid) == before {
            return;
        }
        if let Some(growth) = self.damping.growth() {
            self.limits.see(Limit::UnstableRotor, growth, at);
        }
    }

    /// Takes the release of an unbalance, by its place in the machine's list.
    pub fn see_release(&mut self, unbalance: usize, at: At) {
        self.releases.see(unbalance, at);
    }

    /// Of an engine with candidates on the ring, which searches it for no points.
    pub fn search_nothing(&mut self) {
        self.rings.iter_mut().for_each(|ring| ring.contact.searches = false);
    }

    /// Takes the instant at which a run ends: loads, and the rotor's place in each diaphragm. No step begins there.
    pub fn see_end(&mut self, loads: Loads<'_>, places: &[[f64; 2]], at: At) {
        self.loads.see(loads, at);
        self.monitors.see(loads.monitors, at);
        self.limits.see_journals(loads.journals, at);
        for (diaphragm, (ring, place)) in self.rings.iter_mut().zip(places).enumerate() {
            ring.see_place(square(*place), at);
            self.limits.see_eccentricity(diaphragm, square(*place), at);
        }
        self.see_yields();
    }

    /// Elements of the shaft.
    pub fn elements(&self) -> usize {
        self.stresses.elements()
    }

    /// Torsional moments of all elements per unit of each torsional mode, from the mode shapes at the nodes \[N m\].
    pub fn torsional_rows(&self, mode_shapes: &[Vec<f64>]) -> Matrix {
        self.stresses.torsional_rows(mode_shapes)
    }

    /// Takes torsional moments of all elements \[N m\].
    pub fn see_torsion(&mut self, moments: &[f64], at: At) {
        self.stresses.see_torsion(moments, at);
    }

    /// Whether bending moments up to a bound can raise a maximum of some elements' sections, under these torsional moments \[N m\].
    #[inline]
    pub fn asks_for_bending(&self, elements: Range<usize>, bound: f64, torsion: &[f64]) -> bool {
        self.stresses.asks_for_bending(elements, bound, torsion)
    }

    /// Takes bending moments of some elements \[N m\], four each as [`crate::stress::ShaftStresses::bending_moments`] has them, and their torsional moments
    /// at the same instant.
    #[inline]
    pub fn see_bending(&mut self, elements: Range<usize>, moments: &[f64], torsion: &[f64], at: At) {
        self.stresses.see_bending(elements, moments, torsion, at);
    }

    /// Largest ratio of stress and yield strength of all rings, with its time; `None` where no ring's material has a yield strength.
    pub fn ring_yield(&self) -> Option<Peak> {
        self.largest_of_rings(0)
    }

    /// Largest ratio of stress and yield strength of all blades.
    pub fn blade_yield(&self) -> Option<Peak> {
        self.largest_of_rings(1)
    }

    /// Largest ratio of stress and yield strength of the shaft's sections, each with its own yield strength.
    pub fn shaft_yield(&self) -> Option<Peak> {
        self.stresses.yield_ratio()
    }

    fn largest_of_rings(&self, which: usize) -> Option<Peak> {
        let ratios = self.rings.iter().filter_map(|ring| ring.stresses.yield_ratios()[which]);
        ratios.reduce(|mut largest, ratio| {
            largest.include(&ratio);
            largest
        })
    }

    /// Bound of the shaft's ratio, as [`StressRecorder::ratio_bound`].
    pub fn shaft_ratio_bound(&self, together: usize, bounds: &[f64]) -> f64 {
        self.stresses.ratio_bound(together, bounds)
    }

    /// Bounds of the ratios of a diaphragm's ring and blades for coordinates, or for the amplitudes of all of them.
    pub fn ring_ratio_bounds(&mut self, diaphragm: usize, q: &[f64]) -> [f64; 2] {
        self.rings[diaphragm].stresses.ratio_bounds(q)
    }

    /// Whether no coordinates of a diaphragm's ring up to these amplitudes have larger stresses than before.
    pub fn ring_rests(&mut self, diaphragm: usize, amplitudes: &[f64]) -> bool {
        self.rings[diaphragm].stresses.rests(amplitudes)
    }

    /// Takes the state of a diaphragm's ring between two observations, where stresses of ring and blades may be above these ratios to the yield strength.
    pub fn watch_ring(&mut self, diaphragm: usize, ratio: [f64; 2], ring: RingState<'_>, at: At) {
        self.rings[diaphragm].stresses.watch(ratio, ring, at);
    }

    /// Judges the run with its step at n, from which it can go on. As long as all guards hold, what has been reached counts as reached
    /// while they did. Judged with the energy balance, every few steps: what was reached since the last time is left out where a guard breaks.
    #[inline]
    pub fn guard(&mut self, step: u64, machine: &Machine, structure: &Structure) {
        if EnergyBalance::judges(step) || self.limits.is_newly_beyond() {
            self.judge(machine, structure);
        }
    }

    /// Judges the run where an engine says so.
    pub fn judge(&mut self, machine: &Machine, structure: &Structure) {
        let exceeds = self.limits.is_newly_beyond();
        // what follows a limit is not reached inside the model, whether the run ends there or not
        if !self.limits.keeps() {
            return;
        }
        let holds = if exceeds { Guards::hold_now } else { Guards::hold };
        if holds(&mut self.guards, &self.energies, &self.rings, machine, structure) {
            self.hold();
        }
    }

    /// All guards hold: what has been reached counts.
    fn hold(&mut self) {
        self.energies.hold();
        self.loads.hold();
        self.monitors.hold();
        self.releases.hold();
        self.stresses.hold();
        self.rings.iter_mut().for_each(RingRecorders::hold);
        self.limits.hold();
    }

    /// Results that are compared with those of a twin.
    pub fn compared(&self) -> Compared {
        let of_rings = |value: fn(&RingRecorders) -> Option<f64>| self.rings.iter().map(value).collect();
        let friction = (!self.rings.is_empty()).then_some(self.energies.now.friction);
        Compared([
            vec![self.loads.largest()],
            of_rings(|ring| ring.contact.filtered()),
            of_rings(|ring| Some(ring.contact.impulse())),
            vec![friction],
            of_rings(RingRecorders::eccentricity),
            vec![self.stresses.largest_torsion()],
        ])
    }

    /// Takes the end of the run.
    pub fn finish(&mut self, end: &End, machine: &Machine, structure: &Structure) {
        self.energies.finish(end);
        for ring in &mut self.rings {
            ring.finish(end.cause, At { time: end.time, speed: end.speed });
        }
        // a step that could not be gone on from says nothing that may be believed
        if end.is_between_steps() {
            self.judge(machine, structure);
        }
    }

    /// Whether the row of a run that has ended may be believed, after [`Recorders::finish`].
    pub fn verdict(&self, machine: &Machine, structure: &Structure, end: &End) -> Verdict {
        Verdict::of(&self.energies, &self.rings, &self.limits, machine, structure, end)
    }

    /// Verdict and row of a run that has ended, after [`Recorders::finish`].
    pub fn outcome(&self, machine: &Machine, structure: &Structure, end: &End, twin: Option<&Twin>) -> Outcome {
        let Verdict { status, cause, causes } = self.verdict(machine, structure, end);
        let mut values = Vec::new();
        let mut row = Row::values(&mut values);
        self.report(Some(end), twin, &mut row);
        row.end(status == Status::Ok);
        Outcome { status, cause, causes, notes: self.limits.exceeded(OnExceed::Note), end_cause: end.cause, values }
    }

    /// Every column with its value, in table order.
    fn report(&self, end: Option<&End>, twin: Option<&Twin>, row: &mut Row<'_>) {
        let all = RingRecorders::of_all(&self.rings);
        let rings = (&*self.rings, all.as_ref());
        End::report(end, row.of(Group::Course));
        RingRecorders::report(rings, row, RingRecorders::report_first_contact);
        self.limits.report_time(row);
        self.loads.report(row.of(Group::BearingLoads));
        RingRecorders::report(rings, row.of(Group::Contact), RingRecorders::report_contact);
        self.energies.report(&self.rings, row.of(Group::Energy));
        RingRecorders::report(rings, row.of(Group::Energy), RingRecorders::report_friction);
        RingRecorders::report(rings, row.of(Group::Numerics), RingRecorders::report_solves);
        self.steps.report(end, row);
        End::report_stop(end, row.of(Group::Course));
        Twin::report(twin, self.twins, row.of(Group::Numerics));
        damping::report(end.map(|_| &self.damping), row.of(Group::Course));
        RingRecorders::report(rings, row.of(Group::Stresses), RingRecorders::report_stresses);
        self.stresses.report(row);
        self.limits.report(row.of(Group::Course));
        RingRecorders::report(rings, row.of(Group::Numerics), RingRecorders::report_resolution);
        self.loads.report_components(row.of(Group::BearingLoads));
        self.monitors.report(row.of(Group::Contact));
        self.releases.report(end.map(|_| self.energies.now.released), row.of(Group::Course));
    }
}
