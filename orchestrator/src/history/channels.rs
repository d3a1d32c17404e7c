//! Channels of a history: names with units, meanings, and the evaluation of each channel at an instant.
//!
//! A name is `GROUP.QUANTITY_UNIT`, such as `contact.gap_m` or `bearing.front.load_N`. In MCAP the group is the topic (`/bearing/front`)
//! and the rest is the field.

use super::HistoryError;
use bladeoff_answers::history::{History, matches};
use bladeoff_core::record::{ContactFrame, Energies, Frame, LastMillisecond};
use bladeoff_core::stress::{LargestMoments, ShaftStresses};
use bladeoff_core::structure::Structure;
use bladeoff_model::machine::{Diaphragm, DiaphragmKind, Machine, RotorKind};

/// A scalar time series.
#[derive(Debug, Clone)]
pub struct Channel {
    /// Group: `rotor`, `bearing.front`, `contact`, ...
    pub group: String,
    /// Quantity with its unit: `gap_m`.
    pub field: String,
    /// SI unit, "" for a pure number.
    pub unit: &'static str,
    /// Meaning, in one sentence.
    pub meaning: String,
    /// Whether it is recorded if no channels are named.
    pub by_default: bool,
    source: Source,
}

/// Source of a value.
#[derive(Debug, Clone, Copy)]
enum Source {
    Angle,
    Speed,
    Displacement(usize),
    Twist(usize),
    Load { bearing: usize, axis: usize },
    LoadNorm(usize),
    PedestalLoad { pedestal: usize, axis: usize },
    PedestalLoadNorm(usize),
    Contact { diaphragm: usize, read: fn(&ContactFrame<'_>) -> f64 },
    PeakForce(usize),
    FilteredForce(usize),
    Energy(fn(&Energies) -> f64),
    Torsion(usize),
    Bending(usize),
    Ring { diaphragm: usize, place: usize },
}

/// Contact forces on one diaphragm since the last record.
pub(super) struct ContactForces {
    /// Forces of the last 1 ms \[N\].
    last: LastMillisecond,
    /// Largest force since the last record \[N\].
    peak: f64,
    /// Contact impulse of the last 1 ms divided by 1 ms \[N\], at the last call of `filter`.
    filtered: f64,
}

impl ContactForces {
    pub fn new(step: f64) -> Self {
        Self { last: LastMillisecond::new(step), peak: 0.0, filtered: 0.0 }
    }

    /// Adds the force of a step.
    pub fn see(&mut self, force: f64) {
        self.last.slide(force);
        if force > self.peak {
            self.peak = force;
        }
    }

    /// Updates the filtered force before a record.
    pub fn filter(&mut self) {
        self.filtered = self.last.sum().unwrap_or(0.0) / self.last.length() as f64;
    }

    /// Resets the peak after a record.
    pub fn recorded(&mut self) {
        self.peak = 0.0;
    }
}

/// Values that an instant does not contain.
pub(super) struct Context<'a> {
    /// Contact forces of each diaphragm.
    pub forces: &'a [ContactForces],
    /// Moments of the shaft, if a channel needs them.
    pub shaft: Option<&'a ShaftStresses>,
    /// Displacements of the shaft, including the static ones of the truncated modes.
    pub bent: &'a [f64],
}

impl Channel {
    /// Full name, `GROUP.FIELD`.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{}.{}", self.group, self.field)
    }

    /// Value at an instant.
    pub(super) fn value(&self, frame: &Frame<'_>, context: &Context<'_>) -> f64 {
        let moments = |section: usize| {
            let of = |shaft: &ShaftStresses| shaft.largest(section, context.bent, frame.torsion_angles);
            context.shaft.map_or_else(LargestMoments::default, of)
        };
        match self.source {
            Source::Angle => frame.angle,
            Source::Speed => frame.speed,
            Source::Displacement(place) => frame.displacement[place],
            Source::Twist(node) => frame.torsion_angles[node],
            Source::Load { bearing, axis } => frame.bearing_loads[bearing][axis],
            Source::LoadNorm(bearing) => frame.bearing_loads[bearing][0].hypot(frame.bearing_loads[bearing][1]),
            Source::PedestalLoad { pedestal, axis } => frame.pedestal_loads[pedestal][axis],
            Source::PedestalLoadNorm(pedestal) => {
                frame.pedestal_loads[pedestal][0].hypot(frame.pedestal_loads[pedestal][1])
            }
            Source::Contact { diaphragm, read } => read(&frame.contacts[diaphragm]),
            Source::PeakForce(diaphragm) => context.forces[diaphragm].peak,
            Source::FilteredForce(diaphragm) => context.forces[diaphragm].filtered,
            Source::Energy(read) => read(&frame.energies),
            Source::Torsion(section) => moments(section).torsion,
            Source::Bending(section) => moments(section).bending_square.sqrt(),
            Source::Ring { diaphragm, place } => frame.contacts[diaphragm].field.map_or(0.0, |field| field[place]),
        }
    }
}

struct List {
    channels: Vec<Channel>,
    group: String,
    by_default: bool,
}

impl List {
    fn group(&mut self, group: &str, by_default: bool) -> &mut Self {
        group.clone_into(&mut self.group);
        self.by_default = by_default;
        self
    }
    fn add(&mut self, field: &str, unit: &'static str, source: Source, meaning: &str) -> &mut Self {
        self.channels.push(Channel {
            group: self.group.clone(),
            field: field.to_owned(),
            unit,
            meaning: meaning.to_owned(),
            by_default: self.by_default,
            source,
        });
        self
    }
}

/// Energies by field name.
const ENERGIES: [(&str, fn(&Energies) -> f64, &str); 12] = [
    ("kinetic_J", |e| e.kinetic, "kinetic energy of rotor and ring"),
    ("strain_J", |e| e.strain, "strain energy of shaft, bearings and ring"),
    ("gravity_J", |e| e.gravity, "potential energy in gravity and of bearing seats off the bearing line"),
    ("bearings_J", |e| e.bearings, "energy dissipated by bearings and pedestals so far"),
    ("structure_J", |e| e.structure, "energy dissipated by the shaft's structural damping so far"),
    ("stator_J", |e| e.stator, "energy dissipated by the diaphragm's damping so far"),
    ("braking_J", |e| e.braking, "energy taken by braking so far"),
    ("friction_J", |e| e.friction, "energy dissipated by contact friction so far"),
    ("normal_J", |e| e.normal, "energy taken out by the normal contact force so far"),
    ("model_J", |e| e.model, "model work of Hyp 1 so far"),
    ("skew_J", |e| e.skew, "energy put in by skew bearing stiffness so far"),
    ("drive_J", |e| e.drive, "energy put in by the drive of a prescribed speed so far"),
];

/// Contact quantities by field name.
const CONTACT: [(&str, &str, fn(&ContactFrame<'_>) -> f64, &str); 10] = [
    ("rotor_x_m", "m", |c| c.rotor[0], "rotor centre from the diaphragm's centre, in the diaphragm's axes"),
    ("rotor_y_m", "m", |c| c.rotor[1], "rotor centre from the diaphragm's centre, in the diaphragm's axes"),
    (
        "eccentricity_m",
        "m",
        |c| c.rotor[0].hypot(c.rotor[1]),
        "distance of the rotor centre from the diaphragm's centre",
    ),
    (
        "gap_m",
        "m",
        |c| c.gap,
        "smallest gap, in the run's own gap function, as the contact force of the step before left it",
    ),
    ("angle_rad", "rad", |c| c.angle, "angle of the ring point closest to the rotor"),
    ("normal_force_N", "N", |c| c.normal_force, "normal contact force of this one step"),
    ("friction_force_N", "N", |c| c.friction_force, "friction force of this one step"),
    ("slip_m_s", "m/s", |c| c.slip, "slip velocity; 0 without contact"),
    ("ring_radial_m", "m", |c| c.ring[0], "radial displacement of the ring at the point closest to the rotor"),
    ("ring_tangential_m", "m", |c| c.ring[1], "tangential displacement of the ring at the point closest to the rotor"),
];

/// Every channel of a machine, in the order of the file.
#[must_use]
pub fn catalogue(machine: &Machine, structure: &Structure) -> Vec<Channel> {
    let rotor = &structure.rotor;
    let mut list = List { channels: Vec::new(), group: String::new(), by_default: true };
    list.group("rotor", true).add("speed_rad_s", "rad/s", Source::Speed, "inertia-weighted mean spin").add(
        "angle_rad",
        "rad",
        Source::Angle,
        "mean spin angle",
    );
    for (i, bearing) in machine.rotor.bearings.iter().enumerate() {
        let [u, v] = rotor.plane_places(bearing.node);
        list.group(&format!("bearing.{}", plain(&bearing.name)), true)
            .add("x_m", "m", Source::Displacement(u), "displacement of the shaft at the bearing along X")
            .add("y_m", "m", Source::Displacement(v), "displacement of the shaft at the bearing along Y")
            .add("load_x_N", "N", Source::Load { bearing: i, axis: 0 }, "bearing load along X")
            .add("load_y_N", "N", Source::Load { bearing: i, axis: 1 }, "bearing load along Y")
            .add("load_N", "N", Source::LoadNorm(i), "bearing load, norm in the X-Y plane");
    }
    for monitor in &machine.monitors {
        let [u, v] = rotor.plane_places(monitor.node);
        list.group(&format!("monitor.{}", plain(&monitor.name)), true)
            .add("x_m", "m", Source::Displacement(u), "displacement of the shaft at the monitor along X")
            .add("y_m", "m", Source::Displacement(v), "displacement of the shaft at the monitor along Y");
    }
    let on_pedestals = machine.rotor.bearings.iter().filter(|bearing| bearing.pedestal.is_some());
    for (pedestal, (bearing, site)) in on_pedestals.zip(&rotor.pedestals).enumerate() {
        let [u, v] = site.places;
        list.group(&format!("pedestal.{}", plain(&bearing.name)), true)
            .add("x_m", "m", Source::Displacement(u), "displacement of the pedestal along X")
            .add("y_m", "m", Source::Displacement(v), "displacement of the pedestal along Y")
            .add("load_x_N", "N", Source::PedestalLoad { pedestal, axis: 0 }, "pedestal force on the ground along X")
            .add("load_y_N", "N", Source::PedestalLoad { pedestal, axis: 1 }, "pedestal force on the ground along Y")
            .add(
                "load_N",
                "N",
                Source::PedestalLoadNorm(pedestal),
                "pedestal force on the ground, norm in the X-Y plane",
            );
    }
    for (diaphragm, found) in machine.diaphragms.iter().enumerate() {
        list.group(&of_ring("contact", machine, found), true);
        for (field, unit, read, meaning) in CONTACT {
            list.add(field, unit, Source::Contact { diaphragm, read }, meaning);
        }
        list.add(
            "peak_force_N",
            "N",
            Source::PeakForce(diaphragm),
            "largest normal contact force of all steps since the last record",
        )
        .add(
            "filtered_force_N",
            "N",
            Source::FilteredForce(diaphragm),
            "contact impulse of the last 1 ms divided by 1 ms",
        );
    }
    list.group("energy", true);
    for (field, read, meaning) in ENERGIES {
        list.add(field, "J", Source::Energy(read), meaning);
    }
    if !rotor.tables.is_empty() {
        let meaning = "energy put in so far by bearing tables, whose stiffness changes with the speed";
        list.add("tables_J", "J", Source::Energy(|energies| energies.tables), meaning);
    }
    if !machine.torques.is_empty() {
        let meaning = "energy put in so far by torques over time";
        list.add("torques_J", "J", Source::Energy(|energies| energies.torques), meaning);
    }
    if machine.rotor.unbalances.iter().any(|unbalance| unbalance.release.is_some()) {
        let meaning = "energy put in so far by masses that were released, negative of a lost mass";
        list.add("released_J", "J", Source::Energy(|energies| energies.released), meaning);
    }
    if let RotorKind::Shaft(shaft) = &machine.rotor.kind {
        for section in 0..ShaftStresses::new(shaft).sections() {
            list.group(&format!("section{section}"), true)
                .add("torsional_moment_Nm", "N m", Source::Torsion(section), "largest torsional moment in the section")
                .add("bending_moment_Nm", "N m", Source::Bending(section), "largest bending moment in the section");
        }
    }
    for node in 0..rotor.nodes {
        let [u, v] = rotor.plane_places(node);
        list.group(&format!("node{node}"), false)
            .add("x_m", "m", Source::Displacement(u), "displacement of the node along X")
            .add("y_m", "m", Source::Displacement(v), "displacement of the node along Y")
            .add("twist_rad", "rad", Source::Twist(node), "torsion angle of the node relative to the mean spin angle");
    }
    for (diaphragm, found) in machine.diaphragms.iter().enumerate() {
        let DiaphragmKind::Flexible(stator) = &found.kind else { continue };
        list.group(&of_ring("ring", machine, found), false);
        for node in 0..stator.ring.elements {
            list.add(
                &format!("radial{node:03}_m"),
                "m",
                Source::Ring { diaphragm, place: 4 * node + 2 },
                "radial displacement of the ring node",
            )
            .add(
                &format!("tangential{node:03}_m"),
                "m",
                Source::Ring { diaphragm, place: 4 * node },
                "tangential displacement of the ring node",
            );
        }
    }
    list.channels
}

/// Group of a diaphragm; includes its name if there are several diaphragms.
pub(super) fn of_ring(group: &str, machine: &Machine, diaphragm: &Diaphragm) -> String {
    if machine.diaphragms.len() > 1 { format!("{group}.{}", plain(&diaphragm.name)) } else { group.to_owned() }
}

/// A name of the machine file with characters that are valid in a topic and an identifier.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}

/// Channels that match the patterns, in the order of the catalogue; without patterns, the default channels.
///
/// A pattern is a full name, a name without its unit, a group (all of it), either with `*` for any characters, or `all`.
///
/// # Errors
/// [`HistoryError::Channel`] for a pattern that matches no channel.
pub fn select(catalogue: Vec<Channel>, patterns: &[String]) -> Result<Vec<Channel>, HistoryError> {
    for pattern in patterns {
        if !catalogue.iter().any(|channel| fits(channel, pattern)) {
            return Err(unknown(pattern, &catalogue.iter().map(Channel::name).collect::<Vec<_>>()));
        }
    }
    let wanted = |channel: &Channel| {
        if patterns.is_empty() { channel.by_default } else { patterns.iter().any(|pattern| fits(channel, pattern)) }
    };
    Ok(catalogue.into_iter().filter(wanted).collect())
}

/// Error for a pattern that matches no channel, with the nearest name and all groups.
fn unknown(pattern: &str, names: &[String]) -> HistoryError {
    let nearest = names
        .iter()
        .map(|name| (strsim::jaro_winkler(name, pattern), name))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(likeness, _)| *likeness > 0.7)
        .map(|(_, name)| name.clone());
    HistoryError::Channel { pattern: pattern.to_owned(), nearest, known: groups(names) }
}

/// One entry per group with its fields, to keep the message short.
fn groups(names: &[String]) -> Vec<String> {
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for name in names {
        let (group, field) = name.rsplit_once('.').unwrap_or(("", name));
        match groups.last_mut().filter(|(known, _)| *known == group) {
            Some((_, fields)) => fields.push(field),
            None => groups.push((group, vec![field])),
        }
    }
    let shown = |(group, mut fields): (&str, Vec<&str>)| {
        let more = fields.len() > 12;
        fields.truncate(12);
        format!("{group}.{{{}{}}}", fields.join(", "), if more { ", ..." } else { "" })
    };
    groups.into_iter().map(shown).collect()
}

fn fits(channel: &Channel, pattern: &str) -> bool {
    let name = channel.name();
    let bare = name.strip_suffix(&unit_suffix(channel.unit)).unwrap_or(&name);
    pattern == "all" || matches(&channel.group, pattern) || matches(&name, pattern) || matches(bare, pattern)
}

/// "m/s" -> "_m_s", "N m" -> "_Nm".
fn unit_suffix(unit: &str) -> String {
    format!("_{}", unit.replace(' ', "").replace('/', "_"))
}

/// Error for a pattern that matches no channel of this history, with the nearest name.
#[must_use]
pub fn unknown_in(history: &History, pattern: &str) -> HistoryError {
    let names: Vec<String> = history.channels.iter().map(|channel| channel.name.clone()).collect();
    unknown(pattern, &names)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bladeoff_model::machine::{Detection, MachineDef};
    use std::collections::BTreeSet;

    /// With several diaphragms, every channel and picture names its diaphragm.
    #[test]
    fn several_rings_carry_their_names() {
        let text = include_str!("../../../studies/machines/lab_rig.toml");
        let mut machine = MachineDef::parse("rig.toml", text).expect("a machine").build().expect("a machine");
        let names = |machine: &Machine| {
            let structure = Structure::build(machine, None).expect("modes");
            let report = crate::engine::modes(machine, &[]).expect("modes");
            let pictures = crate::pictures::ring_shapes(machine, &structure, &report);
            let channels = catalogue(machine, &structure).iter().map(Channel::name).collect::<Vec<_>>();
            (channels, pictures.into_iter().map(|(name, _)| name).collect::<Vec<_>>())
        };
        let (alone, pictures) = names(&machine);
        assert!(
            alone.iter().any(|name| name == "contact.gap_m") && alone.iter().any(|name| name == "ring.radial000_m")
        );
        let own = machine.diaphragms[0].name.clone();
        assert_eq!(pictures, [own.as_str()]);
        let detection = crate::engine::detection(&machine);
        assert!(detection.is_some());
        let mut other = machine.diaphragms[0].clone();
        other.name = "wide-one".to_owned();
        machine.diaphragms.push(other);
        let (both, pictures) = names(&machine);
        assert_eq!(both.iter().collect::<BTreeSet<_>>().len(), both.len(), "no name stands twice");
        assert_eq!(pictures, [own.as_str(), "wide-one"]);
        for name in [format!("contact.{own}.gap_m"), "ring.wide_one.radial000_m".to_owned()] {
            assert!(both.contains(&name), "{name}: {both:?}");
        }
        assert_eq!(crate::engine::detection(&machine), detection);
        let hyp1 = machine.diaphragms[1].contact.detection == Detection::Hyp1;
        machine.diaphragms[1].contact.detection = if hyp1 { Detection::Hyp2 } else { Detection::Hyp1 };
        assert_eq!(crate::engine::detection(&machine), None, "no word for two of them");
    }
}
