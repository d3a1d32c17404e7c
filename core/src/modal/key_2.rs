//! The key of version 2, by which result directories made before version 3 know their basis; none is made with it any more.
//!
//! It hashes a text that once was Rust's own of the structs of that time. Here it is written out, so that it stays what it was whatever
//! the structs are called today. Fields that they get later are no part of it: a structure in which such a field matters has to be
//! refused before this key is asked. Verified by `keys_are_those_at_rest`.

use bladeoff_model::machine::{Blades, DiaphragmKind, Disc, FlexibleStator, Machine, Ring, RotorKind, ShaftElement};

/// The key that an earlier build gave the basis of this machine.
pub(super) fn key_2(machine: &Machine) -> [u8; 32] {
    *blake3::hash(text(machine).as_bytes()).as_bytes()
}

pub(super) fn text(machine: &Machine) -> String {
    let bearings = machine.rotor.bearings.iter().map(|bearing| {
        let [[xx, xy], [yx, yy]] = bearing.stiffness.map(|row| row.map(number));
        format!("({}, [[{xx}, {xy}], [{yx}, {yy}]])", bearing.node)
    });
    let rings = machine.diaphragms.iter().filter_map(|diaphragm| match &diaphragm.kind {
        DiaphragmKind::Flexible(stator) => Some(ring(stator)),
        _ => None,
    });
    let (rotor, bearings, rings) = (rotor(&machine.rotor.kind), list(bearings), list(rings));
    let modes = [machine.run.rotor_modes, machine.run.twist_modes, machine.run.ring_modes];
    let [lateral, twist, of_ring] = modes.map(|modes| option(modes.map(|modes| modes.to_string())));
    format!("basis 2 {rotor} {bearings} {rings} ({lateral}, {twist}, {of_ring})")
}

fn rotor(kind: &RotorKind) -> String {
    match kind {
        RotorKind::PointMass(point) => format!(
            "PointMass(PointMass {{ mass: {}, polar_inertia: {} }})",
            number(point.mass),
            number(point.polar_inertia)
        ),
        RotorKind::Shaft(shaft) => format!(
            "Shaft(Shaft {{ nodes: {}, elements: {}, discs: {} }})",
            list(shaft.nodes.iter().copied().map(number)),
            list(shaft.elements.iter().map(element)),
            list(shaft.discs.iter().map(disc))
        ),
    }
}

fn element(element: &ShaftElement) -> String {
    format!(
        "ShaftElement {{ length: {}, diameter: {}, inner_diameter: {}, young_modulus: {}, poisson_ratio: {}, density: {}, \
         shear_coefficient: {}, section: {} }}",
        number(element.length),
        number(element.diameter),
        number(element.inner_diameter),
        number(element.young_modulus),
        number(element.poisson_ratio),
        number(element.density),
        option(element.shear_coefficient.map(number)),
        element.section
    )
}

fn disc(disc: &Disc) -> String {
    format!(
        "Disc {{ name: {:?}, node: {}, mass: {}, transverse_inertia: {}, polar_inertia: {} }}",
        disc.name,
        disc.node,
        number(disc.mass),
        number(disc.transverse_inertia),
        number(disc.polar_inertia)
    )
}

fn ring(stator: &FlexibleStator) -> String {
    let Ring { mean_radius, thickness, width, elements } = stator.ring;
    let blades = stator.blades.map(|Blades { count, length, thickness, width, elements }| {
        let [length, thickness, width] = [length, thickness, width].map(number);
        format!(
            "Blades {{ count: {count}, length: {length}, thickness: {thickness}, width: {width}, elements: {elements} }}"
        )
    });
    let [modulus, density, radius, thickness, width] =
        [stator.young_modulus, stator.density, mean_radius, thickness, width].map(number);
    format!(
        "({modulus}, {density}, Ring {{ mean_radius: {radius}, thickness: {thickness}, width: {width}, elements: {elements} }}, \
         {})",
        option(blades)
    )
}

/// The shortest digits that read back as the same f64, with an exponent below 1e-4 and from 1e16 on.
fn number(value: f64) -> String {
    format!("{value:?}")
}

fn option(value: Option<String>) -> String {
    value.map_or_else(|| "None".to_owned(), |value| format!("Some({value})"))
}

fn list(items: impl Iterator<Item = String>) -> String {
    format!("[{}]", items.collect::<Vec<_>>().join(", "))
}
