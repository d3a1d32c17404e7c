//! `[diaphragms.NAME]`: ring, blades and contact.

use super::path::{below, joined};
use super::places::{self, Nodes};
use super::reader::Reader;
use super::rotor::rayleigh;
use crate::machine::model::{
    Blades, Contact, ContactPoints, ContactSurface, Detection, Diaphragm, DiaphragmKind, FlexibleStator, FrictionLaw,
    Ring,
};
use bladeoff_text::document::units::format_digits;

/// Largest number of diaphragms: each has some 60 result columns, and a message between processes has limited space.
const MOST: usize = 12;

pub(super) fn diaphragms(reader: &mut Reader<'_>, nodes: Option<&Nodes>) -> Option<Vec<Diaphragm>> {
    let members = reader.layout.group("diaphragms");
    if let Some(first_above) = members.get(MOST) {
        let path = below("diaphragms", &first_above.name);
        reader.fail(&path, format!("{} diaphragms", members.len()), format!("at most {MOST}"));
        return None;
    }
    let all: Vec<Option<Diaphragm>> = members.iter().map(|member| diaphragm(reader, nodes, &member.name)).collect();
    all.into_iter().collect()
}

fn diaphragm(reader: &mut Reader<'_>, nodes: Option<&Nodes>, name: &str) -> Option<Diaphragm> {
    let table = &*below("diaphragms", name);
    let contact = contact(reader, nodes, &below(table, "contact"));
    let kind = match reader.word(&below(table, "kind")) {
        Some("rigid") => Some(DiaphragmKind::Rigid),
        Some("radial-spring") => {
            reader.number(&below(table, "stiffness")).map(|stiffness| DiaphragmKind::RadialSpring { stiffness })
        }
        Some(_) => flexible(reader, table).map(DiaphragmKind::Flexible),
        None => None,
    };
    if let Some(contact) = &contact {
        check_inside(reader, name, contact);
    }
    let angle = reader.number(&below(table, "angle"))?;
    Some(Diaphragm { name: name.to_owned(), kind: kind?, angle, contact: contact? })
}

/// Checks that the rotor is inside the diaphragm at t = 0: there is no rub outside the ring. With gravity, the position of the rotor includes the
/// sag, which requires the matrices of the shaft: the solver then checks the start, before the first step.
fn check_inside(reader: &mut Reader<'_>, name: &str, contact: &Contact) {
    const START: &str = "rotor.initial.displacement";
    let Some(start) = reader.vector(START) else { return };
    if reader.vector("rotor.gravity").is_none_or(|gravity| gravity != [0.0; 2]) {
        return;
    }
    // a radial spring may be compressed beyond its radius at the start, so only the position of its centre is checked
    let spring = reader.word(&joined(&["diaphragms.", name, ".kind"])) == Some("radial-spring");
    let start = if spring { [0.0; 2] } else { start };
    let away = [0, 1].map(|axis| start[axis] - contact.offset[axis]);
    let (distance, radius) = (away[0].hypot(away[1]), contact.rotor_radius + contact.gap);
    if distance < radius {
        return;
    }
    let moved = start[0].hypot(start[1]) > contact.offset[0].hypot(contact.offset[1]);
    let of = if moved { start } else { contact.offset };
    let axis = usize::from(of[1].abs() > of[0].abs());
    let offset = joined(&["diaphragms.", name, ".contact.offset"]);
    let path = format!("{}[{axis}]", if moved { START } else { &*offset });
    let metres = |value: f64| format_digits(value, "m", 6);
    let message = format!(
        "the rotor would start outside diaphragm {name}: {} off the ring's centre, the ring's radius is {}",
        metres(distance),
        metres(radius)
    );
    let allowed = format!("a start within the gap of {}; a number without a unit is in m", metres(contact.gap));
    reader.fail(&path, message, allowed);
}

fn contact(reader: &mut Reader<'_>, nodes: Option<&Nodes>, table: &str) -> Option<Contact> {
    let node = places::node(reader, nodes, table);
    let number = |key: &str| reader.number(&below(table, key));
    Some(Contact {
        node: node?,
        rotor_radius: number("rotor_radius")?,
        gap: number("gap")?,
        friction: number("friction")?,
        friction_law: match reader.word(&below(table, "friction_law"))? {
            "slip" => FrictionLaw::Slip,
            _ => FrictionLaw::StickSlip,
        },
        detection: Detection::from_word(reader.word(&below(table, "detection"))?)?,
        points: match reader.word(&below(table, "points"))? {
            "one" => ContactPoints::One,
            _ => ContactPoints::Several,
        },
        offset: reader.vector(&below(table, "offset"))?,
        surface: match reader.word(&below(table, "surface"))? {
            "mean-line" => ContactSurface::MeanLine,
            _ => ContactSurface::InnerFace,
        },
    })
}

fn flexible(reader: &mut Reader<'_>, table: &str) -> Option<FlexibleStator> {
    let ring = ring(reader, table);
    let blades = blades(reader, table);
    let material = |key: &str| reader.number(&joined(&[table, ".material.", key]));
    Some(FlexibleStator {
        young_modulus: material("young_modulus")?,
        poisson_ratio: material("poisson_ratio")?,
        density: material("density")?,
        yield_strength: material("yield_strength"),
        ring: ring?,
        blades: blades?,
        damping: rayleigh(reader, &below(table, "damping"))?,
    })
}

fn ring(reader: &mut Reader<'_>, table: &str) -> Option<Ring> {
    let path = |key: &str| joined(&[table, ".ring.", key]);
    let (mean_radius, thickness) = (reader.number(&path("mean_radius")), reader.number(&path("thickness")));
    if let (Some(radius), Some(thickness)) = (mean_radius, thickness) {
        if thickness >= 2.0 * radius {
            let allowed = format!("below twice mean_radius = {}", format_digits(radius, "m", 10));
            reader.fail(&path("thickness"), "the ring has no inner edge", allowed);
        }
        if thickness < 2.0 * radius {
            check_fit(reader, table, radius, thickness);
        }
    }
    let elements = reader.count(&path("elements"));
    let count = reader.count(&below(table, "blades.count"));
    if let (Some(elements), Some(count)) = (elements, count)
        && count > 0
        && elements % count != 0
    {
        let message = "not a multiple of the number of blades: each blade is at a node of the ring";
        reader.fail(&path("elements"), message, format!("a multiple of blades.count = {count}"));
    }
    Some(Ring {
        mean_radius: mean_radius?,
        thickness: thickness?,
        width: reader.number(&path("width"))?,
        elements: elements?,
    })
}

/// Checks that the contact surface, `R_i = rotor_radius + gap`, is within the ring. A study may vary the gap alone, so the surface may differ from
/// the inner face of the ring's section, `mean_radius - thickness/2`: inwards by one thickness (a seal on the ring), outwards up to the mean
/// line. Beyond, radius and gap belong to another ring.
fn check_fit(reader: &mut Reader<'_>, table: &str, mean: f64, thickness: f64) {
    let (radius_path, gap_path) = (below(table, "contact.rotor_radius"), below(table, "contact.gap"));
    let (Some(radius), Some(gap)) = (reader.number(&radius_path), reader.number(&gap_path)) else { return };
    let (surface, face) = (radius + gap, mean - thickness / 2.0);
    let (least, most) = (face - thickness, mean);
    // 1.9 mm + 50.1 mm must count as 52 mm despite rounding
    let slack = 1e-9 * mean;
    if (least - slack..=most + slack).contains(&surface) {
        return;
    }
    let metres = |length: f64| format_digits(length, "m", 6);
    let gap_there = if face > radius {
        format!("from this rotor_radius to that face there are {}", metres(face - radius))
    } else {
        format!("this rotor_radius lies {} beyond that face", metres(radius - face))
    };
    let message = format!(
        "rotor_radius + gap = {} does not fit the ring, whose inner face (mean_radius - thickness/2) is at {}: {gap_there}",
        metres(surface),
        metres(face)
    );
    let allowed = format!(
        "rotor_radius + gap from {} to {} (a thickness inside that face, to the mean radius)",
        metres(least.max(0.0)),
        metres(most)
    );
    // If the radius alone fits, the gap is reported as wrong.
    let path = if (least..=face).contains(&radius) { gap_path } else { radius_path };
    reader.fail(&path, message, allowed);
}

/// Blades; inner `None`: a free ring, outer `None`: invalid.
fn blades(reader: &mut Reader<'_>, table: &str) -> Option<Option<Blades>> {
    const MOST_ELEMENTS: usize = 600;
    let path = |key: &str| joined(&[table, ".blades.", key]);
    let any_given = ["length", "thickness", "width", "elements"].iter().any(|key| reader.is_given(&path(key)));
    if any_given && reader.is_default(&path("count")) {
        reader.missing_here(&path("count"), "diaphragms.NAME.blades.count");
        return None;
    }
    let count = reader.count(&path("count"))?;
    if count == 0 {
        return Some(None);
    }
    for key in ["length", "thickness", "width", "elements"] {
        if !reader.is_given(&path(key)) {
            reader.missing_here(&path(key), &format!("diaphragms.NAME.blades.{key}"));
        }
    }
    let elements = reader.count(&path("elements"))?;
    if count * elements > MOST_ELEMENTS {
        let allowed = format!("at most {MOST_ELEMENTS} in all blades together");
        reader.fail(&path("elements"), format!("{} blade elements", count * elements), allowed);
    }
    let number = |key: &str| reader.number(&path(key));
    Some(Some(Blades {
        count,
        length: number("length")?,
        thickness: number("thickness")?,
        width: number("width")?,
        elements,
    }))
}
