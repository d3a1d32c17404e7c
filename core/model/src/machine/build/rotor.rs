//! `[rotor]`: model of the rotor, its bearings and unbalances, initial state.

use super::bearing_table::bearing_table;
use super::layer::layer;
use super::lost::{MOST_LOST, overdrawn};
use super::path::{below, joined};
use super::places::{self, Nodes};
use super::reader::Reader;
use super::run::speed_law;
use super::shaft;
use super::support::{check_axial, check_lateral};
use crate::machine::model::{
    Bearing, Disc, InitialState, Pedestal, PointMass, Presence, Rayleigh, Release, Rotor, RotorKind, RunSettings,
    Shaft, Unbalance, UnbalanceKind,
};
use crate::machine::schema::END_TIME;
use crate::machine::some_of;
use bladeoff_text::document::units::format_digits;

/// Largest number of bearings and pedestals together.
const MOST_SUPPORTS: usize = 50;

pub(super) struct BuiltRotor {
    /// `None`: a problem was reported.
    pub rotor: Option<Rotor>,
    /// Nodes at which contacts may be; also available if other values are wrong.
    pub nodes: Option<Nodes>,
}

pub(super) fn rotor(reader: &mut Reader<'_>, run: Option<&RunSettings>) -> BuiltRotor {
    let point = reader.is_point_mass();
    let mut elements = None;
    let nodes = match point {
        Some(true) => Some(Nodes::Point),
        Some(false) => shaft::line(reader).map(|line| {
            elements = line.elements;
            Nodes::Line(line.nodes)
        }),
        None => None,
    };
    let layers = each(reader, "rotor.layers", |reader, name, table| {
        layer(reader, nodes.as_ref(), elements.as_deref(), name, table)
    });
    let discs = if point == Some(true) { Some(Vec::new()) } else { discs(reader, nodes.as_ref()) };
    let bearings = each(reader, "rotor.bearings", |reader, name, table| bearing(reader, nodes.as_ref(), name, table));
    let unbalances = each(reader, "rotor.unbalances", |reader, name, table| {
        unbalance(reader, nodes.as_ref(), discs.as_deref(), name, table)
    });
    let end_time = run.map(|run| run.end_time).or_else(|| reader.number(END_TIME));
    let speed_law = speed_law(reader, end_time);
    if let Some(bearings) = &bearings {
        check_pedestals(reader, bearings);
        check_lateral(reader, bearings, nodes.as_ref());
        if point == Some(false) {
            check_axial(reader, bearings);
        }
    }
    let mass_point = if point == Some(true) { mass_point(reader, unbalances.as_deref()) } else { None };
    let assemble = || {
        let kind = match (&nodes, mass_point) {
            (Some(Nodes::Point), Some(point)) => RotorKind::PointMass(point),
            (Some(Nodes::Line(nodes)), _) => {
                RotorKind::Shaft(Shaft { nodes: nodes.clone(), elements: elements?, layers: layers?, discs: discs? })
            }
            _ => return None,
        };
        Some(Rotor {
            kind,
            initial_speed: reader.number("rotor.initial_speed")?,
            gravity: reader.vector("rotor.gravity")?,
            speed_law: speed_law?,
            initial: InitialState {
                displacement: reader.vector("rotor.initial.displacement")?,
                velocity: reader.vector("rotor.initial.velocity")?,
                angle: reader.number("rotor.initial.angle")?,
            },
            bearings: bearings?,
            unbalances: unbalances?,
            damping: rayleigh(reader, "rotor.damping")?,
            torsional_damping: torsional(reader)?,
        })
    };
    let rotor = assemble();
    if let Some(rotor) = &rotor {
        check_lost(reader, rotor);
    }
    BuiltRotor { rotor, nodes }
}

/// Limits the number of supports: each bearing and each pedestal has its own result columns, and a message between processes has limited space.
fn check_pedestals(reader: &mut Reader<'_>, bearings: &[Bearing]) {
    let pedestals = bearings.iter().filter(|bearing| bearing.pedestal.is_some()).count();
    if pedestals > 0 && bearings.len() + pedestals > MOST_SUPPORTS {
        let message = format!("{} bearings and {pedestals} pedestals", bearings.len());
        reader.fail("rotor.bearings", message, format!("at most {MOST_SUPPORTS} bearings and pedestals together"));
    }
}

/// Reports lost masses that exceed the mass or inertia at their node: a brake would accelerate such a rotor.
fn check_lost(reader: &mut Reader<'_>, rotor: &Rotor) {
    let Some(found) = overdrawn(rotor) else { return };
    let unbalance = &rotor.unbalances[found.unbalance];
    let table = below("rotor.unbalances", &unbalance.name);
    let shown = |value: f64, unit: &str| format_digits(value, unit, 4);
    let (mass, square) = (unbalance.mass, unbalance.mass * unbalance.radius * unbalance.radius);
    let carried = unbalance.torsional_node != unbalance.node;
    let whole = if carried { "what is there" } else { "the node's" };
    let most = format!("less than {:.0} % of {whole}", 100.0 * MOST_LOST);
    let path = if mass < MOST_LOST * found.mass { below(&table, "radius") } else { below(&table, "mass") };
    let message = format!(
        "{} is lost where less is: mass {} of {} and m r^2 {} of {}{}, together {:.0} % of what {}",
        unbalance.name,
        shown(mass, "kg"),
        shown(found.mass, "kg"),
        shown(square, "kg m2"),
        shown(found.polar_inertia, "kg m2"),
        if carried { " of its disc" } else { "" },
        100.0 * found.share,
        if carried { "is there" } else { "the node has" }
    );
    // limit for this mass alone; other lost masses at the node reduce it
    let radius = ((MOST_LOST / mass - 1.0 / found.mass) * found.polar_inertia).max(0.0).sqrt();
    let allowed = if radius > 0.0 {
        format!("{most}, here a radius up to {}{}", shown(radius, "m"), disc_hint(rotor, found.unbalance))
    } else {
        format!("{most}{}", disc_hint(rotor, found.unbalance))
    };
    reader.fail(&path, message, allowed);
}

/// Suggests a disc for a lost mass: a part of a disc is lost from the inertia of the disc.
fn disc_hint(rotor: &Rotor, index: usize) -> String {
    let RotorKind::Shaft(shaft) = &rotor.kind else { return String::new() };
    let unbalance = &rotor.unbalances[index];
    let away = |disc: &&Disc| (shaft.nodes[disc.node] - shaft.nodes[unbalance.torsional_node]).abs();
    // whether the disc has enough inertia for this mass, whatever later masses take
    let bears = |disc: &Disc| {
        let mut carried = rotor.clone();
        carried.unbalances[index].torsional_node = disc.node;
        overdrawn(&carried).is_none_or(|found| found.unbalance > index)
    };
    match shaft.discs.iter().min_by(|a, b| away(a).total_cmp(&away(b))) {
        Some(disc) if disc.node == unbalance.torsional_node => format!(
            "; disc {}{} has polar_inertia {}, which includes what is lost",
            disc.name,
            if unbalance.torsional_node == unbalance.node { " there" } else { "" },
            format_digits(disc.polar_inertia, "kg m2", 4)
        ),
        Some(disc) if bears(disc) => format!(
            "; no disc is there: an unbalance of disc {0} at {1} has disc = \"{0}\"",
            disc.name,
            format_digits(shaft.nodes[disc.node], "m", 10)
        ),
        Some(disc) => format!(
            "; no disc is there, the nearest is {} at {}: a mass that a disc loses has the position of the disc",
            disc.name,
            format_digits(shaft.nodes[disc.node], "m", 10)
        ),
        None => {
            "; a shaft without discs can lose at most its own section there; a disc needs [rotor.discs.NAME]".to_owned()
        }
    }
}

/// All members of a group of named tables; `None` if one of them is invalid.
fn each<T>(
    reader: &mut Reader<'_>,
    group: &str,
    mut read: impl FnMut(&mut Reader<'_>, &str, &str) -> Option<T>,
) -> Option<Vec<T>> {
    let members = reader.layout.group(group);
    let all: Vec<Option<T>> =
        members.iter().map(|member| read(reader, &member.name, &below(group, &member.name))).collect();
    all.into_iter().collect()
}

pub(super) fn rayleigh(reader: &Reader<'_>, table: &str) -> Option<Rayleigh> {
    Some(Rayleigh {
        mass_proportional: reader.number(&below(table, "mass_proportional"))?,
        stiffness_proportional: reader.number(&below(table, "stiffness_proportional"))?,
    })
}

/// Torsional damping; by default the stiffness-proportional damping of bending.
fn torsional(reader: &Reader<'_>) -> Option<f64> {
    const OWN: &str = "rotor.damping.torsional";
    reader.number(if reader.is_given(OWN) { OWN } else { "rotor.damping.stiffness_proportional" })
}

fn discs(reader: &mut Reader<'_>, nodes: Option<&Nodes>) -> Option<Vec<Disc>> {
    each(reader, "rotor.discs", |reader, name, table| {
        let node = places::node(reader, nodes, table);
        let number = |key: &str| reader.number(&below(table, key));
        Some(Disc {
            name: name.to_owned(),
            node: node?,
            mass: number("mass")?,
            transverse_inertia: number("transverse_inertia")?,
            polar_inertia: number("polar_inertia")?,
        })
    })
}

fn bearing(reader: &mut Reader<'_>, nodes: Option<&Nodes>, name: &str, table: &str) -> Option<Bearing> {
    let node = places::node(reader, nodes, table);
    let pedestal = pedestal(reader, &below(table, "pedestal"));
    let over_speed =
        if reader.word(&below(table, "kind"))? == "table" { Some(bearing_table(reader, table)?) } else { None };
    let (stiffness, damping) = match &over_speed {
        Some(over_speed) => {
            let constant = over_speed.constant_part();
            (constant.stiffness, constant.damping)
        }
        None => (reader.matrix(&below(table, "stiffness"))?, reader.matrix(&below(table, "damping"))?),
    };
    Some(Bearing {
        name: name.to_owned(),
        node: node?,
        stiffness,
        damping,
        axial_stiffness: reader.number(&below(table, "axial_stiffness"))?,
        clearance: reader.number(&below(table, "clearance")),
        elevation: reader.vector(&below(table, "elevation"))?,
        pedestal: pedestal?,
        table: over_speed,
    })
}

/// `None`: invalid; `Some(None)`: rigid ground.
#[expect(clippy::option_option, reason = "an optional part that may be wrong")]
fn pedestal(reader: &mut Reader<'_>, table: &str) -> Option<Option<Pedestal>> {
    let is_given = |reader: &Reader<'_>, key: &str| {
        reader.is_given(&below(table, key)) || reader.is_given(&joined(&[table, ".", key, "[0]"]))
    };
    if !is_given(reader, "stiffness") {
        if is_given(reader, "mass") || is_given(reader, "damping") {
            reader.missing_here(&below(table, "stiffness"), "rotor.bearings.NAME.pedestal.stiffness");
            return None;
        }
        return Some(None);
    }
    let or_zero = |key: &str| if is_given(reader, key) { reader.diagonal(&below(table, key)) } else { Some([0.0; 2]) };
    Some(Some(Pedestal {
        mass: or_zero("mass")?,
        stiffness: reader.diagonal(&below(table, "stiffness"))?,
        damping: or_zero("damping")?,
    }))
}

fn unbalance(
    reader: &mut Reader<'_>,
    nodes: Option<&Nodes>,
    discs: Option<&[Disc]>,
    name: &str,
    table: &str,
) -> Option<Unbalance> {
    let place = below(table, "position");
    let placed = reader.is_point_mass() == Some(true) || reader.is_given(&place);
    let own = places::node(reader, nodes, table);
    // the node of its force and the node it rotates with
    let (node, torsional_node) = match reader.text(&below(table, "disc")) {
        Some(disc) if reader.is_point_mass() != Some(true) => {
            let carrier = carrier(reader, discs, table, disc?);
            (if placed { own } else { carrier }, carrier)
        }
        _ => {
            if !placed && reader.is_point_mass().is_some() {
                reader.missing_here(&place, "rotor.unbalances.NAME.position");
            }
            (own, own)
        }
    };
    let release = release(reader, table);
    let number = |key: &str| reader.number(&below(table, key));
    let word = |key: &str| reader.word(&below(table, key));
    Some(Unbalance {
        name: name.to_owned(),
        node: node?,
        torsional_node: torsional_node?,
        mass: number("mass")?,
        radius: number("radius")?,
        phase: number("phase")?,
        kind: match word("kind")? {
            "lost" => UnbalanceKind::Lost,
            _ => UnbalanceKind::Added,
        },
        presence: match word("present")? {
            "before" => Presence::Before,
            _ => Presence::AtRelease,
        },
        release,
    })
}

/// The event at which an unbalance appears.
fn release(reader: &mut Reader<'_>, table: &str) -> Option<Release> {
    let [time, speed] = ["release_time", "release_speed"].map(|key| below(table, key));
    if reader.is_given(&time) && reader.is_given(&speed) {
        reader.fail(&speed, "release_time is given too", "at most one of release_time and release_speed");
        return None;
    }
    let release = match (reader.number(&time), reader.number(&speed)) {
        (Some(time), _) => Release::Time(time),
        (_, Some(speed)) => Release::Speed(speed),
        (None, None) => return None,
    };
    if reader.word(&below(table, "present")) == Some("before") {
        let path = if matches!(release, Release::Time(_)) { time } else { speed };
        reader.fail(&path, "an unbalance that is present before has no release", "present = \"at release\"");
    }
    Some(release)
}

/// The node of the disc that an unbalance names; `None`: invalid.
fn carrier(reader: &mut Reader<'_>, discs: Option<&[Disc]>, table: &str, name: &str) -> Option<usize> {
    let names: Vec<&str> = reader.layout.group("rotor.discs").iter().map(|disc| disc.name.as_str()).collect();
    if !names.contains(&name) {
        let nearest = reader.problems.nearest(name, names.iter().copied());
        let allowed = if names.is_empty() {
            "the name of a disc; there is no [rotor.discs.NAME]".to_owned()
        } else {
            some_of(&names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>())
        };
        reader.fail(&below(table, "disc"), "no disc has this name", allowed).nearest = nearest;
    }
    discs?.iter().find(|disc| disc.name == name).map(|disc| disc.node)
}

/// The mass point, which must have positive mass and inertia including its unbalances.
fn mass_point(reader: &mut Reader<'_>, unbalances: Option<&[Unbalance]>) -> Option<PointMass> {
    let (mass, polar_inertia) = (reader.number("rotor.mass"), reader.number("rotor.polar_inertia"));
    if let Some(unbalances) = unbalances {
        // before its release, an added mass does not contribute
        let least =
            |one: &Unbalance| if one.release.is_some() { one.signed_mass().min(0.0) } else { one.signed_mass() };
        let total = mass.map(|mass| mass + unbalances.iter().map(least).sum::<f64>());
        if total.is_some_and(|total| total <= 0.0) {
            let allowed = "a positive sum of rotor.mass, added and (negative) lost unbalance masses";
            reader.fail("rotor.mass", "the mass point has no mass, its unbalances included", allowed);
            return None;
        }
        let lost = |unbalance: &Unbalance| unbalance.signed_mass().min(0.0) * unbalance.radius * unbalance.radius;
        let inertia = polar_inertia.map(|inertia| inertia + unbalances.iter().map(lost).sum::<f64>());
        if inertia.is_some_and(|inertia| inertia <= 0.0) {
            let allowed = "more than the mass times squared radius of all lost unbalances";
            reader.fail("rotor.polar_inertia", "the lost unbalances have more inertia than the rotor", allowed);
            return None;
        }
    }
    Some(PointMass { mass: mass?, polar_inertia: polar_inertia? })
}
