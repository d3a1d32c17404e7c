//! The numeric columns of a result row: name with its unit, type, meaning. The one place that names them.

use crate::machine::Machine;

/// How a column is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// f64.
    Real,
    /// A count: u64 in the table, exact in f64 below 2^53.
    Count,
}

/// One numeric column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name; ends in the SI unit where it has one.
    pub name: String,
    /// SI unit, "" for a pure number.
    pub unit: &'static str,
    /// Storage.
    pub kind: ColumnKind,
    /// What it means, one sentence.
    pub meaning: String,
}

/// The numeric columns of one machine's outcome, in table order. They depend on its bearing names alone.
#[must_use]
pub fn columns(machine: &Machine) -> Vec<Column> {
    let mut all = Columns(Vec::new());
    all.real("end_time_s", "s", "simulated time at which the run ended");
    all.real("end_speed_rad_s", "rad/s", "inertia-weighted mean spin at the end");
    all.real("first_contact_s", "s", "time of the first contact; null without contact");
    all.peak("max_bearing_load", "N", "largest bearing load of all bearings, norm in the X-Y plane");
    for bearing in &machine.rotor.bearings {
        all.peak(
            &format!("max_bearing_load_{}", bearing.name),
            "N",
            &format!("largest load of bearing {}, norm in the X-Y plane", bearing.name),
        );
    }
    all.peak("max_contact_force", "N", "largest normal contact force of one step (not a converged quantity: see max_filtered_contact_force_N)");
    all.peak("max_filtered_contact_force", "N", "largest impulse of the last 1 ms divided by 1 ms");
    all.real("contact_impulse_Ns", "N s", "time integral of the normal contact force");
    all.real("contact_time_s", "s", "time with a contact force");
    all.real("stick_time_s", "s", "time in contact without slip");
    all.count("impacts", "impacts; one ends when the gap has stayed open for 1 ms");
    all.peak("residual_penetration", "m", "largest penetration left at a converged step, in the run's own gap function");
    all.peak("max_eccentricity", "m", "largest distance of the rotor centre from the diaphragm's centre at the contact section");
    all.real("friction_energy_J", "J", "energy dissipated by contact friction");
    all.real("normal_work_J", "J", "energy that the normal contact force took out (positive) or put in (negative), Hyp 1's model work apart");
    all.real("model_work_J", "J", "work of the normal force that Hyp 1's approximate gap does not account for; null with other detections");
    all.real("energy_error", "", "largest error of the energy balance over the largest total energy");
    all.count("no_fixed_point_steps", "steps whose exact contact location had no fixed point and took the predicted one");
    all.count("slip_reversal_steps", "contact steps whose slip velocity changed sign");
    all.count("steps", "time steps");
    all.real("step_s", "s", "time step");
    all.count("iterations", "iterations of the non-linear solve, all steps together");
    all.real("stop_time_s", "s", "time at which the rotor came to rest; null unless it stopped");
    all.0
}

struct Columns(Vec<Column>);

impl Columns {
    fn push(&mut self, name: String, unit: &'static str, kind: ColumnKind, meaning: &str) {
        self.0.push(Column { name, unit, kind, meaning: meaning.to_owned() });
    }
    fn real(&mut self, name: &str, unit: &'static str, meaning: &str) {
        self.push(name.to_owned(), unit, ColumnKind::Real, meaning);
    }
    fn count(&mut self, name: &str, meaning: &str) {
        self.push(name.to_owned(), "", ColumnKind::Count, meaning);
    }
    /// A peak, and time and speed at which it was reached.
    fn peak(&mut self, name: &str, unit: &'static str, meaning: &str) {
        self.push(format!("{name}_{unit}"), unit, ColumnKind::Real, meaning);
        self.push(format!("{name}_at_s"), "s", ColumnKind::Real, &format!("time of {name}_{unit}"));
        self.push(
            format!("{name}_at_rad_s"),
            "rad/s",
            ColumnKind::Real,
            &format!("mean spin at the time of {name}_{unit}"),
        );
    }
}
