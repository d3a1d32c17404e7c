//! Contact with one ring: forces, impulse, impacts, residual penetration and solver counts.

use super::filter::{FILTER, Window};
use super::peak::{At, Peak, Sum};
use super::phases::Phases;
use super::row::{FLEXIBLE, Row};
use bladeoff_model::machine::{Contact, ContactPoints, Detection};
use bladeoff_model::outcome::Empty;

/// Contact of one step, as the recorders see it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Touch {
    /// Normal force, sum over all contact points \[N\]; positive in compression.
    pub normal: f64,
    /// Whether the contact sticks (no slip).
    pub sticks: bool,
    /// Gap of the converged step in the run's own gap function \[m\]; negative for penetration.
    pub gap: f64,
    /// Number of contact points with a force.
    pub points: usize,
    /// Whether the solution reversed the slip direction that the prediction had fixed.
    pub reversed: bool,
    /// Whether the single contact point has no fixed point.
    pub no_fixed_point: bool,
    /// Whether the rotor penetrated the predicted ring at more than one local minimum of the distance.
    pub several_minima: bool,
    /// Energy dissipated by friction in the step \[J\].
    pub friction_work: f64,
}

/// Recorder of the contact with one ring, in steps of constant length `dt` \[s\].
#[derive(Debug, Clone)]
pub(crate) struct ContactRecorder {
    /// Time step \[s\].
    dt: f64,
    /// Contact at the angle of the rotor's centre: the gap has one minimum, and the normal force does model work.
    polar: bool,
    /// Largest normal force of one step \[N\].
    force: Peak,
    /// Normal impulses \[N s\] and friction works \[J\] of the last 1 ms.
    window: Window<2>,
    /// Largest mean normal force over 1 ms \[N\].
    filtered: Peak,
    /// Largest mean friction power over 1 ms \[W\].
    power: Peak,
    /// Energy dissipated by friction \[J\].
    friction: Sum,
    /// Axial width of the ring \[m\]; `None` without a flexible ring.
    width: Option<f64>,
    /// Largest residual penetration \[m\].
    penetration: Peak,
    /// Residual penetration at the end of the last contact step \[m\].
    left: Option<f64>,
    /// Time of the first contact \[s\].
    first: Option<f64>,
    /// Time of the first contact \[s\], if all guards held then.
    first_guarded: Option<f64>,
    /// Time of the last contact step \[s\].
    last: Option<f64>,
    /// Normal contact impulse \[N s\].
    impulse: Sum,
    phases: Phases,
    /// Time with a contact force \[s\].
    time: Sum,
    /// Time in contact without slip \[s\].
    stick_time: Sum,
    /// Number of impacts.
    impacts: Sum,
    /// Whether contact points are searched on the ring. The exponential engine uses sampled points instead.
    pub searches: bool,
    /// Whether detection is `hyp2` with one contact point, which the exponential engine also searches.
    has_one_point: bool,
    /// Number of steps whose single contact point has no fixed point.
    no_fixed_point: u64,
    /// Number of steps with more than one contact point.
    several_points: u64,
    /// Number of steps with penetration at more than one local minimum of the distance.
    several_minima: u64,
    /// Number of steps whose slip velocity changed sign.
    reversals: u64,
}

impl ContactRecorder {
    /// Name of the column of the first contact.
    pub const FIRST: &str = "first_contact_s";

    pub fn new(contact: &Contact, width: Option<f64>, dt: f64) -> Self {
        Self {
            dt,
            polar: contact.detection == Detection::Hyp1,
            force: Peak::default(),
            window: Window::new(dt),
            filtered: Peak::default(),
            power: Peak::default(),
            friction: Sum::default(),
            width,
            penetration: Peak::default(),
            left: None,
            first: None,
            first_guarded: None,
            last: None,
            impulse: Sum::default(),
            phases: Phases::default(),
            time: Sum::default(),
            stick_time: Sum::default(),
            impacts: Sum::default(),
            searches: true,
            has_one_point: contact.detection == Detection::Hyp2 && contact.points == ContactPoints::One,
            no_fixed_point: 0,
            several_points: 0,
            several_minima: 0,
            reversals: 0,
        }
    }

    /// Records the contact of a step; `None` without a contact force.
    pub fn see(&mut self, touch: Option<&Touch>, at: At) {
        let force = touch.map_or(0.0, |touch| touch.normal);
        self.finish(at);
        self.phases.see(force * self.dt, at.time, self.dt);
        match touch {
            Some(touch) => self.window.slide([force * self.dt, touch.friction_work]),
            None => self.window.pass(1),
        }
        if let Some([impulse, work]) = self.window.sums() {
            let length = self.window.length() as f64 * self.dt;
            self.filtered.see(impulse / length, at);
            // sticking may return a small amount of energy
            self.power.see((work / length).max(0.0), at);
        }
        let Some(touch) = touch else { return };
        self.friction.value += touch.friction_work;
        self.first.get_or_insert(at.time);
        // a step longer than the filter cannot resolve the gap between two successive contacts
        if self.last.is_none_or(|last| at.time - last > FILTER.max(1.5 * self.dt)) {
            self.impacts.value += 1.0;
        }
        self.last = Some(at.time);
        self.impulse.value += force * self.dt;
        self.time.value += self.dt;
        if touch.sticks {
            self.stick_time.value += self.dt;
        }
        self.no_fixed_point += u64::from(touch.no_fixed_point);
        self.several_points += u64::from(touch.points > 1);
        self.several_minima += u64::from(touch.several_minima);
        self.reversals += u64::from(touch.reversed);
        self.force.see(force, at);
        self.left = Some((-touch.gap).max(0.0));
    }

    /// Records several steps without contact.
    pub fn pass(&mut self, steps: usize, at: At) {
        self.finish(at);
        self.window.pass(steps);
        self.phases.pass(steps);
    }

    /// Records the residual penetration of the last contact, at the instant at which it remained: the next step, or the end of the run.
    pub fn finish(&mut self, at: At) {
        if let Some(depth) = self.left.take() {
            self.penetration.see(depth, at);
        }
    }

    /// Marks the values reached so far as guarded.
    pub fn hold(&mut self) {
        self.force.hold();
        self.filtered.hold();
        self.power.hold();
        self.penetration.hold();
        for sum in [&mut self.impulse, &mut self.friction, &mut self.time, &mut self.stick_time, &mut self.impacts] {
            sum.hold();
        }
        self.first_guarded = self.first;
    }

    /// Merges the contact of another ring: the largest peaks, the sums, the earlier first contact.
    pub fn include(&mut self, other: &Self) {
        let earliest = |own: Option<f64>, others: Option<f64>| own.into_iter().chain(others).reduce(f64::min);
        self.force.include(&other.force);
        self.filtered.include(&other.filtered);
        self.power.include(&other.power);
        self.penetration.include(&other.penetration);
        self.left = self.left.into_iter().chain(other.left).reduce(f64::max);
        self.first = earliest(self.first, other.first);
        self.first_guarded = earliest(self.first_guarded, other.first_guarded);
        // the largest energy over width, which may be that of one ring while all guards held and of another at the end
        if let Some(others) = other.width {
            let own = self.width.map(|width| self.friction.over(width)).unwrap_or_default();
            let [own, other] = [own, other.friction.over(others)];
            self.friction = Sum { value: own.value.max(other.value), guarded: own.guarded.max(other.guarded) };
            self.width = Some(1.0);
        }
        self.impulse.include(&other.impulse);
        self.time.include(&other.time);
        self.stick_time.include(&other.stick_time);
        self.impacts.include(&other.impacts);
        self.phases.include(&other.phases);
        // a count that one of the rings lacks is that of the other
        self.polar &= other.polar;
        self.searches |= other.searches;
        self.no_fixed_point += other.no_fixed_point;
        self.several_points += other.several_points;
        self.several_minima += other.several_minima;
        self.reversals += other.reversals;
    }

    /// Largest impulse within 1 ms, divided by 1 ms \[N\]; `None` without contact.
    pub fn filtered(&self) -> Option<f64> {
        self.filtered.value
    }

    /// Total normal contact impulse \[N s\].
    pub fn impulse(&self) -> f64 {
        self.impulse.value
    }

    /// Returns whether contact has occurred.
    pub fn touched(&self) -> bool {
        self.first.is_some()
    }

    /// Returns whether the normal force does work that its approximate gap does not account for.
    pub fn does_model_work(&self) -> bool {
        self.polar
    }

    /// Largest residual penetration \[m\], including that of the last contact step.
    pub fn penetration(&self) -> Option<f64> {
        self.penetration.value.into_iter().chain(self.left).reduce(f64::max)
    }

    /// Equivalent number of steps per contact phase \[-\] that the guard judges ([`Phases::judged`]).
    pub fn steps_per_impact(&self) -> Option<f64> {
        self.phases.judged()
    }

    /// Mean length of the contact phases that the guard judges \[s\].
    pub fn impact_length(&self) -> Option<f64> {
        Some(self.phases.judged()? * self.dt)
    }

    /// Length of the contact phase in progress \[s\].
    pub fn open_length(&self) -> Option<f64> {
        self.phases.open_length()
    }

    /// Judges the resolution of the contact phases at the instant `now` \[s\], at which the run exceeds a limit of the model.
    pub fn judge_at_limit(&mut self, now: f64) {
        self.phases.judge_at_limit(now);
    }

    /// Declares that the run continues beyond the limit.
    pub fn continue_beyond(&mut self) {
        self.phases.continue_beyond();
    }

    /// Number of steps in which the slip velocity changed sign.
    pub fn reversals(&self) -> u64 {
        self.reversals
    }

    pub(super) fn report_first(of: Option<&Self>, row: &mut Row<'_>) {
        let (first, guarded) = of.map_or((None, None), |contact| (contact.first, contact.first_guarded));
        row.once(Self::FIRST, "time of the first contact; null without contact", first, guarded);
    }

    pub(super) fn report_forces(of: Option<&Self>, row: &mut Row<'_>) {
        row.peak(
            "max_contact_force",
            "N",
            "largest normal contact force of one step (not a converged quantity: see max_filtered_contact_force_N)",
            of.map(|contact| contact.force),
        );
        row.peak(
            "max_filtered_contact_force",
            "N",
            "largest impulse of the last 1 ms divided by 1 ms",
            of.map(|contact| contact.filtered),
        );
        let impulse = of.map(|contact| contact.impulse);
        row.sum("contact_impulse_Ns", "N s", "time integral of the normal contact force", impulse);
        row.sum("contact_time_s", "s", "time with a contact force", of.map(|contact| contact.time));
        row.sum("stick_time_s", "s", "time in contact without slip", of.map(|contact| contact.stick_time));
        let impacts = of.map(|contact| contact.impacts);
        row.counted("impacts", "impacts; one ends when the gap has stayed open for 1 ms", impacts);
    }

    /// `is_one`: the columns refer to one of several diaphragms, whose friction energy is not that of the run.
    pub(super) fn report_friction(of: Option<&Self>, is_one: bool, row: &mut Row<'_>) {
        if is_one {
            let energy = of.map(|contact| contact.friction);
            row.sum("friction_energy_J", "J", "energy dissipated by friction on this ring", energy);
        }
        row.peak(
            "max_friction_power",
            "W",
            "largest friction work of the last 1 ms divided by 1 ms",
            of.map(|contact| contact.power),
        );
        let per_width = of.and_then(|contact| contact.width.map(|width| contact.friction.over(width)));
        let lacks = per_width.is_none().then_some(FLEXIBLE);
        row.with(Empty::Unjudged, lacks, |row| {
            row.sum(
                "friction_energy_per_width_J_m",
                "J/m",
                "energy dissipated by friction on this ring over the ring's width; null without a flexible ring",
                per_width,
            );
        });
    }

    pub(super) fn report_penetration(of: Option<&Self>, row: &mut Row<'_>) {
        row.peak(
            "residual_penetration",
            "m",
            "largest penetration that a contact force left at the end of its step, in the run's own gap function. A \
             history shows it as contact.gap_m at that instant (0 with a radial spring, which gives way instead)",
            of.map(|contact| contact.penetration),
        );
    }

    pub(super) fn report_solves(of: Option<&Self>, row: &mut Row<'_>) {
        row.with(Empty::Unjudged, None, |row| {
            row.count(
                "no_fixed_point_steps",
                "steps in which one exact contact point had no fixed point; solved with several points, or at the predicted place; \
                 null with engine exponential, except for hyp2 with contact.points = \"one\"",
                of.filter(|contact| contact.searches || contact.has_one_point).map(|contact| contact.no_fixed_point),
            );
        });
        let several = of.map(|contact| contact.several_points);
        row.count("several_points_steps", "steps with more than one contact point on the ring", several);
        row.with(Empty::Unjudged, None, |row| {
            row.count(
                "several_minima_steps",
                "contact steps whose predicted ring is penetrated at more than one local minimum of the distance; null with hyp1 \
                 and with engine exponential",
                of.filter(|contact| !contact.polar && contact.searches).map(|contact| contact.several_minima),
            );
        });
        let reversals = of.map(|contact| contact.reversals);
        row.count("slip_reversal_steps", "contact steps whose slip velocity changed sign", reversals);
    }

    pub(super) fn report_resolution(of: Option<&Self>, row: &mut Row<'_>) {
        row.real(
            "steps_per_impact",
            "",
            "steps per contact phase, counted as for a constant force of the same impulse and mean square; mean over \
             all phases, weighted by impulse, or up to an exceeded limit if that is smaller; null without contact",
            of.and_then(|contact| contact.phases.steps()),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::MachineDef;

    /// The guard counts the penetration left by a contact at once, before the next step reports it.
    #[test]
    fn what_the_last_step_left_counts_at_once() {
        let text = include_str!("../../../studies/machines/lab_rig.toml");
        let machine = MachineDef::parse("rig.toml", text).expect("a machine").build().expect("a machine");
        let mut contact = ContactRecorder::new(&machine.diaphragms[0].contact, None, 1e-5);
        let touch = |gap: f64| Touch {
            normal: 1.0,
            sticks: false,
            gap,
            points: 1,
            reversed: false,
            no_fixed_point: false,
            several_minima: false,
            friction_work: 0.0,
        };
        let at = |step: f64| At { time: 1e-5 * step, speed: 100.0 };
        assert_eq!(contact.penetration(), None);
        contact.see(Some(&touch(-2e-6)), at(1.0));
        assert_eq!((contact.penetration(), contact.penetration.value), (Some(2e-6), None));
        contact.see(Some(&touch(-1e-6)), at(2.0));
        assert_eq!((contact.penetration(), contact.penetration.value), (Some(2e-6), Some(2e-6)));
        contact.see(Some(&touch(-3e-6)), at(3.0));
        contact.hold();
        assert_eq!((contact.penetration(), contact.penetration.guarded), (Some(3e-6), 2e-6));
        contact.finish(at(4.0));
        assert_eq!((contact.penetration.value, contact.penetration.at.time), (Some(3e-6), at(4.0).time));
    }
}
