//! Key of a basis: a hash of all data that determine the modes, written out field by field.
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
//! Numbers are the bits of an f64 in 16 hexadecimal digits. Counts are decimal. A missing value is a dash. The first word of a line
//! determines its format, so two different structures never have the same text. Names and section numbers are excluded, because no mode
//! depends on them.
//!
//! The key is stored in every result directory (`basis.bin`), and its bytes are part of the keys of the samples. So this text is a file
//! format: it changes only together with its version. It contains no Rust name, so renaming a field does not change a key. Every pattern
//! here names all fields of its struct. So a new field does not compile until this file states whether the modes depend on it. Verified by
//! `keys_are_those_at_rest`, `what_the_modes_depend_on_is_in_the_key_and_nothing_else`.

use bladeoff_model::machine::{
    Bearing, Blades, Diaphragm, DiaphragmKind, Disc, FlexibleStator, Layer, Machine, Pedestal, PointMass, Ring, Rotor,
    RotorKind, RunSettings, Shaft, ShaftElement,
};

/// Returns the key of a machine's basis.
pub(crate) fn modal_key(machine: &Machine) -> [u8; 32] {
    *blake3::hash(text(machine).as_bytes()).as_bytes()
}

/// Returns whether a basis with this key belongs to the machine.
pub(crate) fn is_key_of(key: &[u8; 32], machine: &Machine) -> bool {
    *key == modal_key(machine)
}

fn text(machine: &Machine) -> String {
    let Machine { name: _, run, rotor, braking: _, torques: _, diaphragms, monitors: _ } = machine;
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
            // a rigid stator raises the number of torsional modes
            DiaphragmKind::Rigid | DiaphragmKind::RadialSpring { stiffness: _ } => {
                text.word("rigid").end();
            }
        }
    }
    of_run(&mut text, run);
    text.0
}

/// Appends the requested numbers of modes.
fn of_run(text: &mut Text, run: &RunSettings) {
    let RunSettings {
        end_time: _,
        end_speed: _,
        engine: _,
        step: _,
        contact_step: _,
        force_location: _,
        rotor_modes,
        torsional_modes,
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
    for modes in [*rotor_modes, *torsional_modes, *ring_modes] {
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
    // no entry for a cylinder: its right end is its left end
    if element.is_tapered() {
        text.word("to").numbers(&[end_diameter, end_inner_diameter]);
    }
    text.end();
}

fn of_ring(text: &mut Text, stator: &FlexibleStator) {
    // planar Euler-Bernoulli beams do not use Poisson's ratio
    let FlexibleStator { young_modulus, poisson_ratio: _, density, yield_strength: _, ring, blades, damping: _ } =
        stator;
    let Ring { mean_radius, thickness, width, elements } = *ring;
    text.word("ring").numbers(&[*young_modulus, *density, mean_radius, thickness, width]).count(elements).end();
    if let Some(Blades { count, length, thickness, width, elements }) = *blades {
        text.word("blades").count(count).numbers(&[length, thickness, width]).count(elements).end();
    }
}

/// Lines of words, each followed by one space.
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
