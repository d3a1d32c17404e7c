//! Which structure a basis belongs to: a hash of what the modes depend on, written out field by field.
//!
//! ```text
//! basis 3
//! shaft | point-mass MASS POLAR_INERTIA
//! nodes Z ...
//! element LENGTH DIAMETER INNER_DIAMETER YOUNG_MODULUS POISSON_RATIO DENSITY SHEAR_COEFFICIENT     one line each, from left to right
//! disc NODE MASS TRANSVERSE_INERTIA POLAR_INERTIA                                                  in the order of the file
//! bearing NODE KXX KXY KYX KYY
//! table                                                                                            where the bearing above it has one
//! pedestal MASS_X MASS_Y STIFFNESS_X STIFFNESS_Y                                                   where the bearing above it has one
//! ring YOUNG_MODULUS DENSITY MEAN_RADIUS THICKNESS WIDTH ELEMENTS                                  each flexible ring
//! blades COUNT LENGTH THICKNESS WIDTH ELEMENTS                                                     where that ring has any
//! modes ROTOR TWIST RING
//! ```
//! Numbers are the bits of an f64 in 16 hexadecimal digits, counts are decimal, what is not given is a dash. Every line says by its
//! first word how it is read, so that two structures never have one text. Names and the numbers of sections are left out: no mode depends on them.
//!
//! The key is at rest in every result directory (`basis.bin`), and its bytes are part of the keys of the samples. So this text is a format: it changes with its
//! version alone. It contains no Rust name, so a field can be renamed without changing a key. Every pattern here names all fields of its struct, so that a new one does not
//! compile until it is decided whether the modes depend on it. Verified by `keys_are_those_at_rest`,
//! `what_the_modes_depend_on_is_in_the_key_and_nothing_else`.

use bladeoff_model::machine::{
    Bearing, Blades, Diaphragm, DiaphragmKind, Disc, FlexibleStator, Layer, Machine, Pedestal, PointMass, Ring, Rotor,
    RotorKind, RunSettings, Shaft, ShaftElement,
};

/// The key of a machine's basis.
pub(crate) fn modal_key(machine: &Machine) -> [u8; 32] {
    *blake3::hash(text(machine).as_bytes()).as_bytes()
}

/// Whether a basis with this key belongs to the machine.
pub(crate) fn is_key_of(key: &[u8; 32], machine: &Machine) -> bool {
    *key == modal_key(machine)
}

fn text(machine: &Machine) -> String {
    let Machine { name: _, run, rotor, braking: _, diaphragms, monitors: _ } = machine;
    let Rotor {
        kind,
        initial_speed: _,
        gravity: _,
        speed_law: _,
        initial: _,
        bearings,
        unbalances: _,
        damping: _,
        torsional_damping: _,
    } = rotor;
    let mut text = Text("basis 3\n".to_owned());
    match kind {
        RotorKind::PointMass(PointMass { mass, polar_inertia }) => {
            text.word("point-mass").numbers(&[*mass, *polar_inertia]).end();
        }
        RotorKind::Shaft(shaft) => of_shaft(&mut text, shaft),
    }
    for bearing in bearings {
        let Bearing {
            name: _,
            node,
            stiffness,
            damping: _,
            axial_stiffness: _,
            clearance: _,
            elevation: _,
            pedestal,
            table,
        } = bearing;
        text.word("bearing").count(*node).numbers(stiffness.as_flattened()).end();
        if table.is_some() {
            text.word("table").end();
        }
        if let Some(Pedestal { mass, stiffness, damping: _ }) = pedestal {
            text.word("pedestal").numbers(mass).numbers(stiffness).end();
        }
    }
    for diaphragm in diaphragms {
        let Diaphragm { name: _, kind, angle: _, contact: _ } = diaphragm;
        match kind {
            DiaphragmKind::Flexible(stator) => of_ring(&mut text, stator),
            // raises the number of twist modes
            DiaphragmKind::Rigid | DiaphragmKind::RadialSpring { stiffness: _ } => {
                text.word("rigid").end();
            }
        }
    }
    of_run(&mut text, run);
    text.0
}

/// How many modes are kept.
fn of_run(text: &mut Text, run: &RunSettings) {
    let RunSettings {
        end_time: _,
        end_speed: _,
        engine: _,
        step: _,
        contact_step: _,
        force_location: _,
        rotor_modes,
        twist_modes,
        ring_modes,
        static_residual: _,
        step_limit: _,
        twin: _,
        twin_limit: _,
        guard: _,
        limits: _,
        end_beyond: _,
    } = run;
    text.word("modes");
    for modes in [*rotor_modes, *twist_modes, *ring_modes] {
        match modes {
            Some(modes) => text.count(modes),
            None => text.word("-"),
        };
    }
    text.end();
}

fn of_shaft(text: &mut Text, shaft: &Shaft) {
    let Shaft { nodes, elements, layers, discs } = shaft;
    text.word("shaft").end();
    text.word("nodes").numbers(nodes).end();
    elements.iter().for_each(|element| of_element(text, "element", element));
    for Layer { name: _, first, elements } in layers {
        text.word("layer").count(*first).end();
        elements.iter().for_each(|element| of_element(text, "part", element));
    }
    for disc in discs {
        let Disc { name: _, node, mass, transverse_inertia, polar_inertia } = disc;
        text.word("disc").count(*node).numbers(&[*mass, *transverse_inertia, *polar_inertia]).end();
    }
}

fn of_element(text: &mut Text, word: &str, element: &ShaftElement) {
    let ShaftElement {
        length,
        diameter,
        inner_diameter,
        end_diameter,
        end_inner_diameter,
        young_modulus,
        poisson_ratio,
        density,
        shear_coefficient,
        yield_strength: _,
        section: _,
    } = *element;
    text.word(word);
    text.numbers(&[length, diameter, inner_diameter, young_modulus, poisson_ratio, density]);
    match shear_coefficient {
        Some(coefficient) => text.numbers(&[coefficient]),
        None => text.word("-"),
    };
    // nothing for a cylinder: the key of a machine without tapers is that of earlier builds
    if element.is_tapered() {
        text.word("to").numbers(&[end_diameter, end_inner_diameter]);
    }
    text.end();
}

fn of_ring(text: &mut Text, stator: &FlexibleStator) {
    // planar Euler-Bernoulli beams have no use for Poisson's ratio
    let FlexibleStator { young_modulus, poisson_ratio: _, density, yield_strength: _, ring, blades, damping: _ } =
        stator;
    let Ring { mean_radius, thickness, width, elements } = *ring;
    text.word("ring").numbers(&[*young_modulus, *density, mean_radius, thickness, width]).count(elements).end();
    if let Some(Blades { count, length, thickness, width, elements }) = *blades {
        text.word("blades").count(count).numbers(&[length, thickness, width]).count(elements).end();
    }
}

/// Lines of words with one space behind each.
struct Text(String);

impl Text {
    fn word(&mut self, word: &str) -> &mut Self {
        self.0.push_str(word);
        self.0.push(' ');
        self
    }
    fn count(&mut self, count: usize) -> &mut Self {
        self.word(&count.to_string())
    }
    fn numbers(&mut self, numbers: &[f64]) -> &mut Self {
        for number in numbers {
            self.word(&format!("{:016x}", number.to_bits()));
        }
        self
    }
    fn end(&mut self) {
        self.0.push('\n');
    }
}

#[cfg(test)]
#[path = "key_tests.rs"]
mod tests;
