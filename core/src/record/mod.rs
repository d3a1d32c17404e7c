//! Recorders of a run: each watches one quantity of interest or a few, and together they write the row of the result table.
//!
//! An engine passes a `RotorInstant` with the quantities of the rotor that the recorders need, and a `RingInstant` for each diaphragm. For
//! the energy balance it also adds the works of each step and writes the stored energies, as its scheme defines them. A recorder does not
//! depend on an engine. It reports each column together with its value, in one place (`Row`), so [`columns`] and the values of an outcome
//! always agree. `Recorders::report` determines the order of the table. A [`Follower`] observes the motion itself, for example for a
//! history.

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

/// Returns the numeric columns of a machine's outcome, in table order. They depend only on the bearing names, on the other named parts and
/// on the number of shaft sections, and never on the varied inputs of a study. The first 12 shaft sections have columns of their own. The
/// last columns contain the values reached while all guards held ([`Column::guarded`]).
#[must_use]
pub fn columns(machine: &Machine) -> Vec<Column> {
    let mut columns = Vec::new();
    // the columns depend neither on the ring matrices nor on the step
    let recorders = Recorders::new(machine, &[], 0.0);
    let mut row = Row::columns(&mut columns);
    recorders.report(None, None, &mut row);
    row.end(true);
    columns
}

/// Returns the index of the number of completed time steps among [`columns`].
#[must_use]
pub fn place_of_steps(machine: &Machine) -> usize {
    columns(machine).iter().position(|column| column.name == Steps::DONE).expect("every run counts its steps")
}

/// Loads, displacements and torsion angles of the rotor at one instant, for any engine.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RotorInstant<'a> {
    pub at: At,
    pub loads: Loads<'a>,
    /// Lateral displacements [m, rad] of all degrees of freedom, and torsion angles \[rad\] of the nodes.
    pub lateral: &'a [f64],
    pub torsion_angles: &'a [f64],
}

/// Loads and displacements at bearings, pedestals and monitors at one instant, as X and Y components.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Loads<'a> {
    /// Forces of the rotor on all bearings, in the machine's order \[N\].
    pub bearings: &'a [[f64; 2]],
    /// Forces of the pedestals on the ground, in the order of the bearings with a pedestal \[N\].
    pub pedestals: &'a [[f64; 2]],
    /// Displacements of the journals in bearings with a clearance, in the machine's order \[m\].
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
    /// Whether a material has a yield strength.
    yields: bool,
    /// Whether the machine has a twin run.
    twins: bool,
}

impl Recorders {
    /// Recorders of a run with the time step `step` \[s\] and the flexible rings of its structure.
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

    /// Adds the static response of the truncated modes to the bending of the shaft, under the forces of bearing seats off the bearing line.
    pub fn settle_shaft(&mut self, machine: &Machine, structure: &Structure) {
        if let Some(lateral) = structure.truncated_seats(&machine.rotor) {
            self.stresses.settle(lateral);
        }
    }

    /// Records an instant of the rotor and of each diaphragm, in the machine's order. Energies are recorded separately, once the works of
    /// the step are known.
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

    /// Passes the largest ratios of stress to yield strength so far to the limits, each with its time.
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

    /// Records loads and journal displacements at the start of a step. `touches`: the step has contact. An engine with steps of variable
    /// length records diaphragms and moments separately ([`Recorders::see_ring`], [`Recorders::see_bending`], [`Recorders::see_torsion`]),
    /// and then yield ratios ([`Recorders::see_yields`]).
    #[inline(always)]
    pub fn see_loads(&mut self, loads: Loads<'_>, at: At, touches: bool) {
        self.loads.see(loads, at);
        self.loads.see_between(loads, at, !touches);
        self.monitors.see(loads.monitors, at);
        self.limits.see_journals(loads.journals, at);
    }

    /// Records an instant of a diaphragm, valid for one step or for several steps without contact. [`RingInstant::ring`] is present if the
    /// engine has computed the ring's state.
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

    /// Returns whether a mean spin \[rad/s\] lies outside the range recorded by [`Recorders::see_speed`] by more than `noticeable`
    /// \[rad/s\].
    #[inline]
    pub fn is_new_speed(&self, speed: f64, noticeable: f64) -> bool {
        self.damping.is_new(speed, noticeable)
    }

    /// Records the mean spin at an instant, and the least damping of the whirl modes up to it.
    pub fn see_speed(&mut self, at: At, grid: &dyn DampingGrid) {
        let before = self.damping.least();
        if self.damping.see(at.speed, grid) == before {
            return;
        }
        if let Some(growth) = self.damping.growth() {
            self.limits.see(Limit::UnstableRotor, growth, at);
        }
    }

    /// Records the release of an unbalance, by its index in the machine's list.
    pub fn see_release(&mut self, unbalance: usize, at: At) {
        self.releases.see(unbalance, at);
    }

    /// Declares that the engine uses sampled contact points on the ring and searches for no others.
    pub fn search_nothing(&mut self) {
        self.rings.iter_mut().for_each(|ring| ring.contact.searches = false);
    }

    /// Records the final instant of a run, at which no step begins: loads, and the rotor's position in each diaphragm \[m\].
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

    /// Number of shaft elements.
    pub fn elements(&self) -> usize {
        self.stresses.elements()
    }

    /// Torsional moments of all elements per unit amplitude of each torsional mode \[N m\], from the mode shapes at the nodes.
    pub fn torsional_rows(&self, mode_shapes: &[Vec<f64>]) -> Matrix {
        self.stresses.torsional_rows(mode_shapes)
    }

    /// Records the torsional moments of all elements \[N m\].
    pub fn see_torsion(&mut self, moments: &[f64], at: At) {
        self.stresses.see_torsion(moments, at);
    }

    /// Returns whether bending moments up to `bound` \[N m\] can raise a maximum in the sections of some elements, with the torsional
    /// moments `torsion` \[N m\].
    #[inline]
    pub fn asks_for_bending(&self, elements: Range<usize>, bound: f64, torsion: &[f64]) -> bool {
        self.stresses.asks_for_bending(elements, bound, torsion)
    }

    /// Records the bending moments of some elements \[N m\], four per element in the order of
    /// [`crate::stress::ShaftStresses::bending_moments`], and their torsional moments \[N m\] at the same instant.
    #[inline]
    pub fn see_bending(&mut self, elements: Range<usize>, moments: &[f64], torsion: &[f64], at: At) {
        self.stresses.see_bending(elements, moments, torsion, at);
    }

    /// Largest ratio of stress to yield strength of all rings \[-\], with its time; `None` if no ring material has a yield strength.
    pub fn ring_yield(&self) -> Option<Peak> {
        self.largest_of_rings(0)
    }

    /// Largest ratio of stress to yield strength of all blades \[-\].
    pub fn blade_yield(&self) -> Option<Peak> {
        self.largest_of_rings(1)
    }

    /// Largest ratio of stress to yield strength of the shaft sections \[-\], each with its own yield strength.
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

    /// Bound of the shaft's ratio of stress to yield strength \[-\], see [`StressRecorder::ratio_bound`].
    pub fn shaft_ratio_bound(&self, together: usize, bounds: &[f64]) -> f64 {
        self.stresses.ratio_bound(together, bounds)
    }

    /// Bounds of the ratios of stress to yield strength of a diaphragm's ring and blades \[-\]. `q`: ring coordinates, or bounds of their
    /// amplitudes.
    pub fn ring_ratio_bounds(&mut self, diaphragm: usize, q: &[f64]) -> [f64; 2] {
        self.rings[diaphragm].stresses.ratio_bounds(q)
    }

    /// Returns whether ring coordinates up to these amplitudes cannot raise a maximum stress of the diaphragm.
    pub fn ring_rests(&mut self, diaphragm: usize, amplitudes: &[f64]) -> bool {
        self.rings[diaphragm].stresses.rests(amplitudes)
    }

    /// Records the state of a diaphragm's ring between two observations, if its stresses may exceed the given ratios to the yield strength
    /// (ring, blades).
    pub fn watch_ring(&mut self, diaphragm: usize, ratio: [f64; 2], ring: RingState<'_>, at: At) {
        self.rings[diaphragm].stresses.watch(ratio, ring, at);
    }

    /// Judges the run at step n, from which it can continue. While all guards hold, the values reached so far count as guarded. The run is
    /// judged with the energy balance, every few steps. If a guard breaks, the values reached since the last judgement are not guarded.
    #[inline]
    pub fn guard(&mut self, step: u64, machine: &Machine, structure: &Structure) {
        if EnergyBalance::judges(step) || self.limits.newly_beyond().is_some() {
            self.judge(machine, structure);
        }
    }

    /// Judges the run now, on request of the engine.
    pub fn judge(&mut self, machine: &Machine, structure: &Structure) {
        let exceeds = self.limits.newly_beyond();
        // values after the exceeded limit are outside the model, whether the run ends there or not
        if !self.limits.keeps() {
            return;
        }
        let holds = match exceeds {
            Some(at) => self.hold_at_limit(at, machine, structure),
            None => self.guards.hold(&self.energies, &self.rings, machine, structure),
        };
        if holds {
            self.hold();
        }
    }

    /// Judges the run at the limit that it exceeds. Returns whether all guards hold.
    fn hold_at_limit(&mut self, at: At, machine: &Machine, structure: &Structure) -> bool {
        self.rings.iter_mut().for_each(|ring| ring.contact.judge_at_limit(at.time));
        let holds = self.guards.hold_at_limit(&self.energies, &self.rings, machine, structure);
        if !machine.run.end_beyond {
            self.rings.iter_mut().for_each(|ring| ring.contact.continue_beyond());
        }
        holds
    }

    /// Marks the values reached so far as guarded.
    fn hold(&mut self) {
        self.energies.hold();
        self.loads.hold();
        self.monitors.hold();
        self.releases.hold();
        self.stresses.hold();
        self.rings.iter_mut().for_each(RingRecorders::hold);
        self.limits.hold();
    }

    /// Returns the results that are compared with those of the twin run.
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

    /// Records the end of the run.
    pub fn finish(&mut self, end: &End, machine: &Machine, structure: &Structure) {
        self.energies.finish(end);
        for ring in &mut self.rings {
            ring.finish(end.cause, At { time: end.time, speed: end.speed });
        }
        // a step from which the run could not continue has no valid state
        if end.is_between_steps() {
            self.judge(machine, structure);
        }
    }

    /// Returns the smallest ratio of steps per impact to `run.guard.impact_steps`; `None` where the step resolves all impacts, and
    /// where truncated modes do not follow the impacts, which no step changes.
    pub fn impact_resolution(&self, machine: &Machine, structure: &Structure) -> Option<f64> {
        let ratio = verdict::impact_resolution(&self.rings, machine, structure)?;
        verdict::carries_impacts(&self.rings, machine, structure).then_some(ratio)
    }

    /// Returns the status of a run that has ended, after [`Recorders::finish`].
    pub fn verdict(&self, machine: &Machine, structure: &Structure, end: &End) -> Verdict {
        Verdict::of(&self.guards, &self.energies, &self.rings, &self.limits, machine, structure, end)
    }

    /// Returns the status and row of a run that has ended, after [`Recorders::finish`].
    pub fn outcome(&self, machine: &Machine, structure: &Structure, end: &End, twin: Option<&Twin>) -> Outcome {
        let Verdict { status, cause, causes } = self.verdict(machine, structure, end);
        let mut values = Vec::new();
        let mut row = Row::values(&mut values);
        self.report(Some(end), twin, &mut row);
        row.end(status == Status::Ok);
        Outcome { status, cause, causes, notes: self.limits.exceeded(OnExceed::Note), end_cause: end.cause, values }
    }

    /// Reports every column with its value, in table order.
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
