//! Quantities of interest, collected step by step.

use std::collections::VecDeque;

use super::ledger::Ledger;
use super::plan::Plan;
use super::rub::StepContact;
use super::stress_peaks::StressPeaks;
use super::whirl::RubMotion;
use crate::outcome::{Cause, CauseSet, EndCause, Outcome, Status, columns};
use crate::structure::{MODAL_LAG, Structure};
use bladeoff_model::machine::{Detection, FrictionLaw, Machine};

/// Length of the force filter, and how long the gap must stay open for an impact to end \[s\].
pub const FILTER: f64 = 1e-3;

/// A largest value, and where it was.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Peak {
    pub value: Option<f64>,
    pub time: f64,
    pub speed: f64,
}

impl Peak {
    pub fn see(&mut self, value: f64, time: f64, speed: f64) {
        if self.value.is_none_or(|largest| value > largest) {
            *self = Self { value: Some(value), time, speed };
        }
    }
}

/// Collector of one run.
#[derive(Debug, Clone)]
pub(crate) struct Monitor {
    dt: f64,
    bearings: Vec<Peak>,
    any_bearing: Peak,
    eccentricity: Peak,
    force: Peak,
    filtered: Peak,
    penetration: Peak,
    /// Penetration that the contact of the last step left at its end \[m\].
    left: Option<f64>,
    first_contact: Option<f64>,
    last_contact: Option<f64>,
    impulse: f64,
    contact_time: f64,
    stick_time: f64,
    impacts: u64,
    no_fixed_point: u64,
    several_points: u64,
    several_minima: u64,
    reversals: u64,
    window: VecDeque<f64>,
    window_length: usize,
    window_sum: f64,
    window_filled: usize,
    /// What of the contact the modes left out have without their inertia.
    modal_lag: f64,
    pub stress: StressPeaks,
    pub motion: RubMotion,
    pub steps: u64,
    pub iterations: u64,
}

impl Monitor {
    pub fn new(machine: &Machine, structure: &Structure, dt: f64) -> Self {
        let window_length = ((FILTER / dt).round() as usize).max(1);
        let contact = if machine.diaphragms.is_empty() { None } else { Some(0.0) };
        let count = Peak { value: contact, ..Peak::default() };
        Self {
            dt,
            bearings: vec![Peak::default(); machine.rotor.bearings.len()],
            any_bearing: Peak::default(),
            eccentricity: Peak::default(),
            force: Peak { value: None, ..count },
            filtered: Peak::default(),
            penetration: Peak::default(),
            left: None,
            first_contact: None,
            last_contact: None,
            impulse: 0.0,
            contact_time: 0.0,
            stick_time: 0.0,
            impacts: 0,
            no_fixed_point: 0,
            several_points: 0,
            several_minima: 0,
            reversals: 0,
            window: VecDeque::new(),
            window_length,
            window_sum: 0.0,
            window_filled: 0,
            modal_lag: structure.lag_at_contact(machine),
            stress: StressPeaks::new(machine, structure),
            motion: RubMotion::default(),
            steps: 0,
            iterations: 0,
        }
    }

    pub fn bearing(&mut self, index: usize, load_squared: f64, time: f64, speed: f64) {
        // squares: one root at the end
        self.bearings[index].see(load_squared, time, speed);
        self.any_bearing.see(load_squared, time, speed);
    }

    pub fn eccentricity(&mut self, squared: f64, time: f64, speed: f64) {
        self.eccentricity.see(squared, time, speed);
    }

    pub fn contact(&mut self, contact: Option<&StepContact>, time: f64, speed: f64) {
        let force = contact.map_or(0.0, |contact| contact.force.normal);
        self.finish(time, speed);
        self.slide_window(force * self.dt);
        if self.window_filled > 0 {
            self.filtered.see(self.window_sum / (self.window_length as f64 * self.dt), time, speed);
        }
        let Some(contact) = contact else { return };
        self.first_contact.get_or_insert(time);
        // a step longer than that shows no gap between two contacts that follow each other
        if self.last_contact.is_none_or(|last| time - last > FILTER.max(1.5 * self.dt)) {
            self.impacts += 1;
        }
        self.last_contact = Some(time);
        self.impulse += force * self.dt;
        self.contact_time += self.dt;
        if contact.force.sticks {
            self.stick_time += self.dt;
        }
        self.no_fixed_point += u64::from(contact.no_fixed_point);
        self.several_points += u64::from(contact.points > 1);
        self.several_minima += u64::from(contact.several_minima);
        self.reversals += u64::from(contact.reversed);
        self.force.see(force, time, speed);
        self.left = Some((-contact.gap.value).max(0.0));
    }

    /// What the last contact left, at the instant it left it: that of the next step, or the end.
    pub fn finish(&mut self, time: f64, speed: f64) {
        if let Some(depth) = self.left.take() {
            self.penetration.see(depth, time, speed);
        }
    }

    fn slide_window(&mut self, impulse: f64) {
        // grown by what has happened: a step of no size would ask for more than there is
        let full = self.window.len() >= self.window_length;
        let leaving = if full { self.window.pop_front().unwrap_or(0.0) } else { 0.0 };
        self.window.push_back(impulse);
        self.window_filled -= usize::from(leaving != 0.0);
        self.window_filled += usize::from(impulse != 0.0);
        self.window_sum += impulse - leaving;
        if self.window_filled == 0 {
            // rounding of the sliding sum does not outlive the contact
            self.window_sum = 0.0;
        }
    }

    /// Verdict and row.
    pub fn outcome(
        &self,
        machine: &Machine,
        plan: &Plan,
        ledger: &Ledger,
        end: (EndCause, f64, f64),
        failure: Option<Cause>,
    ) -> Outcome {
        let mut causes = CauseSet::default();
        let guard = &machine.run.guard;
        if let Some(cause) = failure {
            causes.insert(cause);
        }
        if ledger.relative_error() > guard.energy_balance {
            causes.insert(Cause::EnergyBalance);
        }
        let reference = ledger.now.friction.max(1e-3 * ledger.initial.abs());
        if ledger.now.normal.abs() > guard.normal_work * reference {
            causes.insert(Cause::NormalWork);
        }
        if let (Some(depth), Some(diaphragm)) = (self.penetration.value, machine.diaphragms.first())
            && depth > guard.penetration * diaphragm.contact.gap
        {
            causes.insert(Cause::Penetration);
        }
        let slips = machine.diaphragms.iter().any(|d| d.contact.friction_law == FrictionLaw::Slip);
        if self.reversals > 0 && slips {
            causes.insert(Cause::SlipReversal);
        }
        if self.first_contact.is_some() && self.modal_lag > MODAL_LAG {
            causes.insert(Cause::ModalBasis);
        }
        let cause = failure.or_else(|| causes.iter().next());
        let status = match (failure, cause) {
            (Some(_), _) => Status::Failed,
            (None, Some(_)) => Status::Invalid,
            (None, None) => Status::Ok,
        };
        let values = columns(machine)
            .iter()
            .map(|column| self.value(&column.name, machine, plan, ledger, end).filter(|value| value.is_finite()))
            .collect();
        Outcome { status, cause, causes, end_cause: end.0, values }
    }

    fn value(
        &self,
        name: &str,
        machine: &Machine,
        plan: &Plan,
        ledger: &Ledger,
        (end_cause, end_time, end_speed): (EndCause, f64, f64),
    ) -> Option<f64> {
        let rubbed = self.first_contact.is_some();
        let rubs = !machine.diaphragms.is_empty();
        let polar = machine.diaphragms.first().is_some_and(|d| d.contact.detection == Detection::Hyp1);
        let count = |n: u64| rubs.then_some(n as f64);
        let energy = |value: f64| rubs.then_some(value);
        if let Some(value) = self.peak(name, machine) {
            return value;
        }
        match name {
            "end_time_s" => Some(end_time),
            "end_speed_rad_s" => Some(end_speed),
            "first_contact_s" => self.first_contact,
            "contact_impulse_Ns" => energy(self.impulse),
            "contact_time_s" => energy(self.contact_time),
            "stick_time_s" => energy(self.stick_time),
            "impacts" => count(self.impacts),
            "whirl_in_rub" => self.motion.whirl(),
            "rub_regime" => rubs.then(|| self.motion.regime()),
            "backward_whirl_time_s" => energy(self.motion.against_spin_time()),
            "friction_energy_J" => energy(ledger.now.friction),
            "normal_work_J" => energy(ledger.now.normal),
            "model_work_J" => (polar && rubbed).then_some(ledger.now.model),
            "energy_error" => Some(ledger.relative_error()),
            "no_fixed_point_steps" => count(self.no_fixed_point),
            "several_points_steps" => count(self.several_points),
            "several_minima_steps" => count(self.several_minima).filter(|_| !polar),
            "slip_reversal_steps" => count(self.reversals),
            "steps" => Some(self.steps as f64),
            "step_s" => Some(plan.step),
            "iterations" => Some(self.iterations as f64),
            "stop_time_s" => (end_cause == EndCause::Stopped).then_some(end_time),
            // filled in when the twin has run
            "twin_bearing_load_change" | "twin_status" => None,
            _ => unreachable!("every column of outcome::columns has its value here: {name}"),
        }
    }

    /// A peak's column: `Some(None)` for a peak that did not happen, `None` for a name that is no peak.
    fn peak(&self, name: &str, machine: &Machine) -> Option<Option<f64>> {
        let squared = |peak: Peak| Peak { value: peak.value.map(f64::sqrt), ..peak };
        let named = |base: &str, unit: &str, peak: Peak| -> Option<Option<f64>> {
            let rest = name.strip_prefix(base)?;
            match rest {
                "_at_s" => Some(peak.value.map(|_| peak.time)),
                "_at_rad_s" => Some(peak.value.map(|_| peak.speed)),
                _ => (rest.strip_prefix('_')? == unit).then_some(peak.value),
            }
        };
        for (bearing, peak) in machine.rotor.bearings.iter().zip(&self.bearings) {
            let found = named(&format!("max_bearing_load_{}", bearing.name), "N", squared(*peak));
            if found.is_some() {
                return found;
            }
        }
        named("max_bearing_load", "N", squared(self.any_bearing))
            .or_else(|| named("max_contact_force", "N", self.force))
            .or_else(|| named("max_filtered_contact_force", "N", self.filtered))
            .or_else(|| named("residual_penetration", "m", self.penetration))
            .or_else(|| named("max_eccentricity", "m", squared(self.eccentricity)))
            .or_else(|| {
                let base = name.strip_suffix("_at_s").or_else(|| name.strip_suffix("_at_rad_s"));
                let base = base.or_else(|| name.strip_suffix("_Nm")).or_else(|| name.strip_suffix("_Pa"))?;
                let peak = self.stress.peak(base)?;
                named(base, "Nm", peak).or_else(|| named(base, "Pa", peak))
            })
    }
}
