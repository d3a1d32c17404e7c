//! The numeric columns of a result row: name with its unit, type, meaning. The one place that names them.

use bladeoff_model::machine::{Machine, RotorKind};

/// Columns of an outcome at most: what a message between processes carries.
pub const MAX_COLUMNS: usize = 256;
/// Words of the column `whirl_in_rub`.
pub(crate) const WHIRL_WORDS: &[&str] = &["forward", "backward", "mixed"];
/// Words of the column `rub_regime`.
pub(crate) const REGIME_WORDS: &[&str] = &["free", "light", "heavy", "backward-whirl"];
/// Words of the column `twin_status`.
pub(crate) const TWIN_WORDS: &[&str] = &["ok", "invalid", "failed"];
/// Shaft sections with columns of their own at most; the largest over all sections is always there.
const REPORTED_SECTIONS: usize = 12;
/// Columns of one section.
const SECTION_COLUMNS: usize = 9;

/// How a column is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// f64.
    Real,
    /// A count: u64 in the table, exact in f64 below 2^53.
    Count,
    /// One of these words: text in the table, its index in an [`super::Outcome`].
    Choice(&'static [&'static str]),
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

/// The numeric columns of one machine's outcome, in table order. They depend on its bearing names and on the number of its
/// shaft sections alone, never on what a study varies. Of the sections the first 12 have columns of their own, fewer where
/// many bearings would bring the columns above [`MAX_COLUMNS`].
#[must_use]
pub fn columns(machine: &Machine) -> Vec<Column> {
    let mut all = Columns(Vec::new());
    all.real("end_time_s", "s", "simulated time at which the run ended");
    all.real(
        "end_speed_rad_s",
        "rad/s",
        "inertia-weighted mean spin at the end, of second order; 0 where the rotor stopped",
    );
    all.real("first_contact_s", "s", "time of the first contact; null without contact");
    all.peak("max_bearing_load", "N", "largest bearing load of all bearings, norm in the X-Y plane");
    for bearing in &machine.rotor.bearings {
        all.peak(
            &format!("max_bearing_load_{}", bearing.name),
            "N",
            &format!("largest load of bearing {}, norm in the X-Y plane", bearing.name),
        );
    }
    all.peak(
        "max_contact_force",
        "N",
        "largest normal contact force of one step (not a converged quantity: see max_filtered_contact_force_N)",
    );
    all.peak("max_filtered_contact_force", "N", "largest impulse of the last 1 ms divided by 1 ms");
    all.real("contact_impulse_Ns", "N s", "time integral of the normal contact force");
    all.real("contact_time_s", "s", "time with a contact force");
    all.real("stick_time_s", "s", "time in contact without slip");
    all.count("impacts", "impacts; one ends when the gap has stayed open for 1 ms");
    all.choice(
        "rub_regime",
        REGIME_WORDS,
        "worst rub of the run: free, light (intermittent), heavy (in impacts for at least half of a turn), backward-whirl \
         (heavy, and the rotor centre turned against the spin by a whole turn)",
    );
    all.choice(
        "whirl_in_rub",
        WHIRL_WORDS,
        "sense in which the rotor centre turns about the diaphragm's centre for at least 90 % of the time in contact, against \
         the spin: forward or backward, otherwise mixed; null without contact",
    );
    all.real("backward_whirl_time_s", "s", "time in contact with the rotor centre turning against the spin");
    all.peak(
        "residual_penetration",
        "m",
        "largest penetration that a contact force left at the end of its step, in the run's own gap function; at the instant \
         where it was left, as contact.gap_m of a history shows it (0 with a radial spring, which gives way instead)",
    );
    all.peak(
        "max_eccentricity",
        "m",
        "largest distance of the rotor centre from the diaphragm's centre at the contact section",
    );
    all.real("friction_energy_J", "J", "energy dissipated by contact friction");
    all.real(
        "normal_work_J",
        "J",
        "energy that the normal contact force took out (positive) or put in (negative), Hyp 1's model work apart",
    );
    all.real(
        "model_work_J",
        "J",
        "work of the normal force that Hyp 1's approximate gap does not account for; null with other detections",
    );
    all.real("energy_error", "", "largest error of the energy balance over the largest total energy");
    all.count(
        "no_fixed_point_steps",
        "steps in which one exact contact point had no fixed point; solved with several points, or at the predicted place",
    );
    all.count("several_points_steps", "steps with more than one contact point on the ring");
    all.count(
        "several_minima_steps",
        "contact steps whose predicted ring is penetrated at more than one local minimum of the distance; null with hyp1",
    );
    all.count("slip_reversal_steps", "contact steps whose slip velocity changed sign");
    all.count("steps", "time steps");
    all.real("step_s", "s", "time step");
    all.count("iterations", "iterations of the non-linear solve, all steps together");
    all.real("stop_time_s", "s", "time at which the rotor came to rest; null unless it stopped");
    all.real(
        "twin_bearing_load_change",
        "",
        "how much larger max_bearing_load_N is in a second run whose initial speed is larger by run.twin of it, relative to this \
         run's; negative: smaller; null without such a run, and where one of the two failed",
    );
    all.choice("twin_status", TWIN_WORDS, "status of that second run; null without one");
    all.peak("max_blade_bending_stress", "Pa", "largest bending stress in a blade of the diaphragm, nominal");
    all.stresses("", "the shaft");
    let sections = match &machine.rotor.kind {
        RotorKind::Shaft(shaft) => shaft.elements.last().map_or(0, |element| element.section + 1),
        RotorKind::PointMass(_) => 0,
    };
    let room = MAX_COLUMNS.saturating_sub(all.0.len()) / SECTION_COLUMNS;
    for section in 0..sections.min(REPORTED_SECTIONS).min(room) {
        all.stresses(
            &format!("_section{section}"),
            &format!("shaft section {section} (from 0, in the order of the file)"),
        );
    }
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
    fn choice(&mut self, name: &str, words: &'static [&'static str], meaning: &str) {
        self.push(name.to_owned(), "", ColumnKind::Choice(words), meaning);
    }
    /// A peak, and time and speed at which it was reached.
    fn peak(&mut self, name: &str, unit: &'static str, meaning: &str) {
        let column = format!("{name}_{}", unit.replace(' ', ""));
        self.push(column.clone(), unit, ColumnKind::Real, meaning);
        self.push(format!("{name}_at_s"), "s", ColumnKind::Real, &format!("time of {column}"));
        self.push(format!("{name}_at_rad_s"), "rad/s", ColumnKind::Real, &format!("mean spin at the time of {column}"));
    }
    /// Moments and stresses of one section or of all.
    fn stresses(&mut self, place: &str, of: &str) {
        self.peak(&format!("max_torsional_moment{place}"), "N m", &format!("largest torsional moment in {of}"));
        self.peak(
            &format!("max_shear_stress{place}"),
            "Pa",
            &format!("largest torsional shear stress at the surface of {of}, nominal"),
        );
        self.peak(
            &format!("max_bending_stress{place}"),
            "Pa",
            &format!("largest bending stress at the surface of {of}, nominal"),
        );
    }
}
