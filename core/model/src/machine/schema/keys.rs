//! The table of keys, in the order of a file; within a table plain keys before subtables.

use super::key::{Key, Kind, Need, When};
use super::range::Range;
use crate::machine::model::{Detection, Engine};

// Paths that other modules use.

/// Path of the end of a run.
pub const END_TIME: &str = "run.end_time";
/// Path of the engine.
pub const ENGINE: &str = "run.engine";
/// Path of the time step.
pub const STEP: &str = "run.step";
/// Path of the contact step of the exponential engine.
pub const CONTACT_STEP: &str = "run.contact_step";
/// Path of the only parameter without influence on a machine's identity.
pub const STEP_LIMIT: &str = "run.step_limit";
/// Path of the relative shift of a twin's initial speed.
pub const TWIN: &str = "run.twin";
/// Path of the largest change between a run and its twin; above it the run is sensitive.
pub const TWIN_LIMIT: &str = "run.twin_limit";

/// Default of [`TWIN_LIMIT`].
pub const TWIN_LIMIT_DEFAULT: f64 = 0.02;
/// Defaults of two guards.
pub const NORMAL_WORK: f64 = 0.01;
pub const PENETRATION: f64 = 0.02;

/// Treatment of a run that exceeds a limit of the model.
const ON_EXCEED: [&str; 2] = ["beyond", "note"];

/// Words of a key that is true or false in a file.
pub const FLAG: [&str; 2] = ["false", "true"];

const POISSON: Range = Range::between(-1.0, 0.5);
/// Bounds on counts limit the memory that a file can request.
const ELEMENTS: Range = Range::from_to(1.0, 500.0);
const RING_ELEMENTS: Range = Range::from_to(4.0, 600.0);
const BLADE_ELEMENTS: Range = Range::from_to(1.0, 1_000.0);
const BLADES: Range = Range::from_to(0.0, 600.0);
const MODES_FROM_0: Range = Range::from_to(0.0, 10_000.0);
const MODES_FROM_1: Range = Range::from_to(1.0, 10_000.0);
const MODES_FROM_2: Range = Range::from_to(2.0, 10_000.0);
const TWIN_SHIFT: Range = Range::from_to(0.0, 0.01);
const STEPS: Range = Range::from_to(1.0, 1e15);
const FRICTION: Range = Range::from_to(0.0, 100.0);
const SHEAR: Range = Range::from_to(1e-3, 1e3);

/// A key; infinite ends of its range are replaced by the bounds of its unit ([`super::bounds`]).
const fn key(path: &'static str, kind: Kind, need: Need, range: Range, when: When, meaning: &'static str) -> Key {
    let range = match kind {
        Kind::Number(unit)
        | Kind::NumberOr(unit, _)
        | Kind::Vector(unit)
        | Kind::Matrix(unit)
        | Kind::Diagonal(unit)
        | Kind::List(unit) => range.bounded(unit),
        Kind::Schema | Kind::Text | Kind::Count | Kind::Choice(_) => range,
    };
    Key { path, kind, need, range, when, meaning }
}

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    // The file.
    key("schema", Kind::Schema, Need::Required, Range::ANY, When::Always,
        "version of this format"),
    key("name", Kind::Text, Need::Required, Range::ANY, When::Always,
        "name of the machine in results and reports"),
    // `[run]`.
    key(END_TIME, Kind::Number("s"), Need::Required, Range::POSITIVE, When::Always,
        "the run ends at the step nearest to this time"),
    key("run.end_speed", Kind::Number("rad/s"), Need::Number(0.0), Range::NOT_NEGATIVE, When::Always,
        "the run ends once the mean spin falls to this speed"),
    key(ENGINE, Kind::Choice(&Engine::CHOICES), Need::Word(Engine::AUTO), Range::ANY, When::Always,
        "central differences over modes of rotor and ring or over all finite-element degrees of freedom, or exact propagation of the modes \
         with contact by impulses (much faster). `auto`: `exponential` where it covers the machine (in a study all \
         samples), otherwise `reduced`"),
    key(STEP, Kind::Number("s"), Need::Optional("chosen from the highest frequency of the model"), Range::POSITIVE, When::Always,
        "time step of `reduced` and `full`; `auto` is `reduced` then"),
    key(CONTACT_STEP, Kind::Number("s"), Need::Optional("chosen from the ring's frequencies and the initial speed; down to an eighth of it where impacts are short"), Range::POSITIVE, When::Always,
        "time step of `exponential` where rotor and ring may touch; while they are apart, one step covers many of these; `auto` is `exponential` then"),
    key("run.force_location", Kind::Choice(&["next", "current"]), Need::Word("next"), Range::ANY, When::Always,
        "contact force of step n acts at the contact place of step n+1 (as the paper) or n"),
    key("run.rotor_modes", Kind::Count, Need::Optional("chosen by the engine: 24, more where bearings are stiff"), MODES_FROM_2, When::Always,
        "lateral rotor modes of `reduced` and `exponential`; too few for the contact: the run is invalid (`modal_basis`)"),
    key("run.torsional_modes", Kind::Count, Need::Optional("chosen by the engine"), MODES_FROM_0, When::Always,
        "torsional modes of `reduced` and `exponential`"),
    key("run.ring_modes", Kind::Count, Need::Optional("chosen by the engine"), MODES_FROM_1, When::Always,
        "ring modes of `reduced` and `exponential`, each diaphragm"),
    key("run.static_residual", Kind::Choice(&["on", "off"]), Need::Word("on"), Range::ANY, When::Always,
        "whether the reduced engine adds the static flexibility of the modes it leaves out, at the contact and in bearing loads; off: \
         a run whose contact lacks more than 3 % of its flexibility is invalid (`modal_basis`)"),
    key(STEP_LIMIT, Kind::Count, Need::Optional("no limit"), STEPS, When::Always,
        "a run with more steps fails with cause step_limit; each repeat with a finer step counts alone"),
    key(TWIN, Kind::Number(""), Need::Number(0.0), TWIN_SHIFT, When::Always,
        "relative shift of the initial speed of a second run, whose results are compared (1e-6 is enough); 0: none"),
    key(TWIN_LIMIT, Kind::Number(""), Need::Number(TWIN_LIMIT_DEFAULT), Range::POSITIVE, When::Always,
        "a run is `sensitive` if a result of its twin differs by more than this part of its own"),
    key("run.guard.normal_work", Kind::Number(""), Need::Number(NORMAL_WORK), Range::POSITIVE, When::Always,
        "run invalid if the normal contact work exceeds this part of the largest of: friction energy, energy of the lateral motion during contact, a thousandth of the initial energy"),
    key("run.guard.energy_balance", Kind::Number(""), Need::Optional("1e-6, with the engine exponential 1e-5"), Range::POSITIVE, When::Always,
        "run invalid if the energy error exceeds this part of the largest total energy"),
    key("run.guard.penetration", Kind::Number(""), Need::Number(PENETRATION), Range::POSITIVE, When::Always,
        "run invalid if the residual penetration exceeds this part of the gap"),
    key("run.guard.impact_steps", Kind::Number(""), Need::Optional("32, with the engine exponential 20"), Range::NOT_NEGATIVE, When::Always,
        "run invalid if contact phases with a flexible ring that have ended have fewer steps than this (column steps_per_impact); 0: not judged; not judged on full, and on reduced with all modes"),
    key("run.end_beyond", Kind::Choice(&["on", "off"]), Need::Word("on"), Range::ANY, When::Always,
        "whether the run ends at the first exceeded limit of the model whose on_exceed is beyond"),
    key("run.limit.ring_displacement.value", Kind::Number(""), Need::Number(0.05), Range::POSITIVE, When::Always,
        "largest allowed (eccentricity at the ring - gap) / mean radius; the planar ring model is linear"),
    key("run.limit.ring_displacement.on_exceed", Kind::Choice(&ON_EXCEED), Need::Word("beyond"), Range::ANY, When::Always,
        "whether a run above this limit gets status beyond, or keeps its status with a note"),
    key("run.limit.ring_yield.value", Kind::Number(""), Need::Number(1.0), Range::POSITIVE, When::Always,
        "largest allowed ring stress / yield strength of the diaphragm's material"),
    key("run.limit.ring_yield.on_exceed", Kind::Choice(&ON_EXCEED), Need::Word("beyond"), Range::ANY, When::Always,
        "whether a run above this limit gets status beyond, or keeps its status with a note"),
    key("run.limit.blade_yield.value", Kind::Number(""), Need::Number(1.0), Range::POSITIVE, When::Always,
        "largest allowed blade stress / yield strength of the diaphragm's material"),
    key("run.limit.blade_yield.on_exceed", Kind::Choice(&ON_EXCEED), Need::Word("beyond"), Range::ANY, When::Always,
        "whether a run above this limit gets status beyond, or keeps its status with a note"),
    key("run.limit.shaft_yield.value", Kind::Number(""), Need::Number(1.0), Range::POSITIVE, When::Always,
        "largest allowed von Mises stress of the shaft / yield strength of the section's material"),
    key("run.limit.shaft_yield.on_exceed", Kind::Choice(&ON_EXCEED), Need::Word("beyond"), Range::ANY, When::Always,
        "whether a run above this limit gets status beyond, or keeps its status with a note"),
    key("run.limit.journal_clearance.value", Kind::Number(""), Need::Number(1.0), Range::POSITIVE, When::Always,
        "largest allowed journal displacement / clearance of the bearing"),
    key("run.limit.journal_clearance.on_exceed", Kind::Choice(&ON_EXCEED), Need::Word("note"), Range::ANY, When::Always,
        "whether a run above this limit gets status beyond, or keeps its status with a note"),
    key("run.limit.unstable_rotor.value", Kind::Number(""), Need::Number(1.0), Range::POSITIVE, When::Always,
        "largest allowed growth of a whirl mode's amplitude over one of its revolutions; above 1 the mode is unstable"),
    key("run.limit.unstable_rotor.on_exceed", Kind::Choice(&ON_EXCEED), Need::Word("note"), Range::ANY, When::Always,
        "whether a run above this limit gets status beyond, or keeps its status with a note"),
    // `[rotor]`.
    key("rotor.kind", Kind::Choice(&["shaft", "point-mass"]), Need::Word("shaft"), Range::ANY, When::Always,
        "finite-element shaft, or one mass point on its bearings (Jeffcott rotor)"),
    key("rotor.initial_speed", Kind::Number("rad/s"), Need::Required, Range::NOT_NEGATIVE, When::Always,
        "spin speed at t = 0"),
    key("rotor.gravity", Kind::Vector("m/s2"), Need::Number(0.0), Range::ANY, When::Always,
        "gravity along X and Y"),
    key("rotor.mass", Kind::Number("kg"), Need::Required, Range::NOT_NEGATIVE, When::PointMass,
        "mass of the mass point; 0 if an added unbalance is all the mass"),
    key("rotor.polar_inertia", Kind::Number("kg m2"), Need::Required, Range::POSITIVE, When::PointMass,
        "moment of inertia of the mass point about Z"),
    key("rotor.material.young_modulus", Kind::Number("Pa"), Need::Required, Range::POSITIVE, When::Shaft,
        "Young's modulus of the shaft"),
    key("rotor.material.poisson_ratio", Kind::Number(""), Need::Required, POISSON, When::Shaft,
        "Poisson's ratio of the shaft"),
    key("rotor.material.density", Kind::Number("kg/m3"), Need::Required, Range::POSITIVE, When::Shaft,
        "density of the shaft"),
    key("rotor.material.shear_coefficient", Kind::NumberOr("", &["cowper", "none"]), Need::Word("cowper"), SHEAR, When::Shaft,
        "k in k G S: a number, Cowper's formula for the section, or no shear deformation"),
    key("rotor.material.yield_strength", Kind::Number("Pa"), Need::Optional("no limit"), Range::POSITIVE, When::Shaft,
        "yield strength of the shaft: the largest von Mises stress is compared with it"),
    key("rotor.shaft[i].length", Kind::Number("m"), Need::Optional("given by element_lengths"), Range::POSITIVE, When::Shaft,
        "length of the section, cut into equal elements"),
    key("rotor.shaft[i].elements", Kind::Count, Need::Optional("given by element_lengths"), ELEMENTS, When::Shaft,
        "number of equal elements of the section"),
    key("rotor.shaft[i].element_lengths", Kind::List("m"), Need::Optional("length and elements say it"), Range::POSITIVE, When::Shaft,
        "length of each element, instead of length and elements"),
    key("rotor.shaft[i].diameter", Kind::Number("m"), Need::Required, Range::POSITIVE, When::Shaft,
        "outer diameter of the section"),
    key("rotor.shaft[i].inner_diameter", Kind::Number("m"), Need::Number(0.0), Range::NOT_NEGATIVE, When::Shaft,
        "diameter of the bore"),
    key("rotor.shaft[i].end_diameter", Kind::Number("m"), Need::Optional("as diameter: a cylinder"), Range::POSITIVE, When::Shaft,
        "outer diameter at the right end of a tapered section; linear between the ends"),
    key("rotor.shaft[i].end_inner_diameter", Kind::Number("m"), Need::Optional("as inner_diameter"), Range::NOT_NEGATIVE, When::Shaft,
        "diameter of the bore at the right end"),
    key("rotor.shaft[i].shear_coefficient", Kind::NumberOr("", &["cowper", "none"]), Need::Optional("as in rotor.material"), SHEAR, When::Shaft,
        "k in k G S of this section"),
    key("rotor.shaft[i].material.young_modulus", Kind::Number("Pa"), Need::Optional("as in rotor.material"), Range::POSITIVE, When::Shaft,
        "Young's modulus of this section"),
    key("rotor.shaft[i].material.poisson_ratio", Kind::Number(""), Need::Optional("as in rotor.material"), POISSON, When::Shaft,
        "Poisson's ratio of this section"),
    key("rotor.shaft[i].material.density", Kind::Number("kg/m3"), Need::Optional("as in rotor.material"), Range::POSITIVE, When::Shaft,
        "density of this section"),
    key("rotor.shaft[i].material.shear_coefficient", Kind::NumberOr("", &["cowper", "none"]), Need::Optional("as in rotor.material"), SHEAR, When::Shaft,
        "k in k G S of this section (the same as rotor.shaft[i].shear_coefficient)"),
    key("rotor.shaft[i].material.yield_strength", Kind::Number("Pa"), Need::Optional("as in rotor.material"), Range::POSITIVE, When::Shaft,
        "yield strength of this section"),
    key("rotor.layers.NAME.position", Kind::Number("m"), Need::Required, Range::NOT_NEGATIVE, When::Shaft,
        "left end of a sleeve or another layer on the shaft, whose stiffness and mass add to those of the sections below; both ends are nodes"),
    key("rotor.layers.NAME.length", Kind::Number("m"), Need::Required, Range::POSITIVE, When::Shaft,
        "length of the layer; it has the elements of the shaft below"),
    key("rotor.layers.NAME.diameter", Kind::Number("m"), Need::Required, Range::POSITIVE, When::Shaft,
        "outer diameter of the layer"),
    key("rotor.layers.NAME.inner_diameter", Kind::Number("m"), Need::Required, Range::NOT_NEGATIVE, When::Shaft,
        "inner diameter of the layer"),
    key("rotor.layers.NAME.end_diameter", Kind::Number("m"), Need::Optional("as diameter: a cylinder"), Range::POSITIVE, When::Shaft,
        "outer diameter at the right end of a tapered layer; linear between the ends"),
    key("rotor.layers.NAME.end_inner_diameter", Kind::Number("m"), Need::Optional("as inner_diameter"), Range::NOT_NEGATIVE, When::Shaft,
        "inner diameter at the right end"),
    key("rotor.layers.NAME.shear_coefficient", Kind::NumberOr("", &["cowper", "none"]), Need::Optional("as in rotor.material"), SHEAR, When::Shaft,
        "k in k G S of the layer"),
    key("rotor.layers.NAME.material.young_modulus", Kind::Number("Pa"), Need::Optional("as in rotor.material"), Range::POSITIVE, When::Shaft,
        "Young's modulus of the layer; small for a layer that adds mass only"),
    key("rotor.layers.NAME.material.poisson_ratio", Kind::Number(""), Need::Optional("as in rotor.material"), POISSON, When::Shaft,
        "Poisson's ratio of the layer"),
    key("rotor.layers.NAME.material.density", Kind::Number("kg/m3"), Need::Optional("as in rotor.material"), Range::POSITIVE, When::Shaft,
        "density of the layer"),
    key("rotor.discs.NAME.position", Kind::Number("m"), Need::Required, Range::NOT_NEGATIVE, When::Shaft,
        "place along the shaft; between two nodes it makes a node of its own"),
    key("rotor.discs.NAME.mass", Kind::Number("kg"), Need::Required, Range::NOT_NEGATIVE, When::Shaft,
        "mass of the disc"),
    key("rotor.discs.NAME.transverse_inertia", Kind::Number("kg m2"), Need::Required, Range::NOT_NEGATIVE, When::Shaft,
        "moment of inertia of the disc about a diameter"),
    key("rotor.discs.NAME.polar_inertia", Kind::Number("kg m2"), Need::Required, Range::NOT_NEGATIVE, When::Shaft,
        "moment of inertia of the disc about Z"),
    key("rotor.bearings.NAME.position", Kind::Number("m"), Need::Required, Range::NOT_NEGATIVE, When::Shaft,
        "place along the shaft; between two nodes it makes a node of its own"),
    key("rotor.bearings.NAME.kind", Kind::Choice(&["linear", "table"]), Need::Word("linear"), Range::ANY, When::Always,
        "constant stiffness and damping, or a table over the speed"),
    key("rotor.bearings.NAME.stiffness", Kind::Matrix("N/m"), Need::Required, Range::NOT_NEGATIVE, When::LinearBearing,
        "stiffness to ground or to its pedestal: isotropic, or [[kxx, kxy], [kyx, kyy]]"),
    key("rotor.bearings.NAME.damping", Kind::Matrix("N s/m"), Need::Number(0.0), Range::NOT_NEGATIVE, When::LinearBearing,
        "damping to ground or to its pedestal: isotropic, or [[cxx, cxy], [cyx, cyy]]"),
    key("rotor.bearings.NAME.table", Kind::Text, Need::Optional("lists in rotor.bearings.NAME.coefficients"), Range::ANY, When::TableBearing,
        "CSV file beside the machine file with the columns speed, kxx to kyy, cxx to cyy"),
    key("rotor.bearings.NAME.interpolation", Kind::Choice(&["linear", "pchip"]), Need::Word("linear"), Range::ANY, When::TableBearing,
        "between two speeds of the table: straight lines, or monotone cubic polynomials"),
    key("rotor.bearings.NAME.stiffness_factor", Kind::Number(""), Need::Number(1.0), Range::POSITIVE, When::TableBearing,
        "factor on all stiffnesses of the table"),
    key("rotor.bearings.NAME.damping_factor", Kind::Number(""), Need::Number(1.0), Range::POSITIVE, When::TableBearing,
        "factor on all damping coefficients of the table"),
    key("rotor.bearings.NAME.clearance", Kind::Number("m"), Need::Optional("no run.limit.journal_clearance for it"), Range::POSITIVE, When::Always,
        "radial clearance, against which the journal's displacement is judged; the linear bearing itself has none"),
    key("rotor.bearings.NAME.axial_stiffness", Kind::Number("N/m"), Need::Number(0.0), Range::NOT_NEGATIVE, When::Shaft,
        "axial stiffness to ground; at least one bearing of a shaft has some"),
    key("rotor.bearings.NAME.elevation", Kind::Vector("m"), Need::Number(0.0), Range::ANY, When::LinearBearing,
        "place of the bearing's seat from the bearing line: its force is zero where the journal is there"),
    key("rotor.bearings.NAME.coefficients.speeds", Kind::List("rad/s"), Need::Optional("required"), Range::NOT_NEGATIVE, When::TableBearing,
        "speeds of the table, ascending; displacements count from the equilibrium at each speed"),
    key("rotor.bearings.NAME.coefficients.kxx", Kind::List("N/m"), Need::Optional("required"), Range::ANY, When::TableBearing,
        "stiffness at these speeds: force along X per displacement along X"),
    key("rotor.bearings.NAME.coefficients.kxy", Kind::List("N/m"), Need::Optional("0"), Range::ANY, When::TableBearing,
        "force along X per displacement along Y"),
    key("rotor.bearings.NAME.coefficients.kyx", Kind::List("N/m"), Need::Optional("0"), Range::ANY, When::TableBearing,
        "force along Y per displacement along X"),
    key("rotor.bearings.NAME.coefficients.kyy", Kind::List("N/m"), Need::Optional("required"), Range::ANY, When::TableBearing,
        "force along Y per displacement along Y"),
    key("rotor.bearings.NAME.coefficients.cxx", Kind::List("N s/m"), Need::Optional("0"), Range::ANY, When::TableBearing,
        "damping at these speeds: force along X per velocity along X"),
    key("rotor.bearings.NAME.coefficients.cxy", Kind::List("N s/m"), Need::Optional("0"), Range::ANY, When::TableBearing,
        "force along X per velocity along Y"),
    key("rotor.bearings.NAME.coefficients.cyx", Kind::List("N s/m"), Need::Optional("0"), Range::ANY, When::TableBearing,
        "force along Y per velocity along X"),
    key("rotor.bearings.NAME.coefficients.cyy", Kind::List("N s/m"), Need::Optional("0"), Range::ANY, When::TableBearing,
        "force along Y per velocity along Y"),
    key("rotor.bearings.NAME.pedestal.mass", Kind::Diagonal("kg"), Need::Optional("0"), Range::NOT_NEGATIVE, When::Always,
        "mass of the pedestal between bearing and ground, the same in both directions or [x, y]; gravity acts on it"),
    key("rotor.bearings.NAME.pedestal.stiffness", Kind::Diagonal("N/m"), Need::Optional("the bearing is on rigid ground"), Range::POSITIVE, When::Always,
        "stiffness of the pedestal to ground, the same in both directions or [x, y]"),
    key("rotor.bearings.NAME.pedestal.damping", Kind::Diagonal("N s/m"), Need::Optional("0"), Range::NOT_NEGATIVE, When::Always,
        "damping of the pedestal to ground, the same in both directions or [x, y]"),
    key("rotor.unbalances.NAME.disc", Kind::Text, Need::Optional("turns with the shaft at its position"), Range::ANY, When::Shaft,
        "name of the disc that carries it: it turns with that disc, whose polar inertia a lost mass is part of"),
    key("rotor.unbalances.NAME.position", Kind::Number("m"), Need::Optional("that of its disc; required without"), Range::NOT_NEGATIVE, When::Shaft,
        "position along the shaft; between two nodes it adds a node"),
    key("rotor.unbalances.NAME.mass", Kind::Number("kg"), Need::Required, Range::NOT_NEGATIVE, When::Always,
        "mass of the unbalance"),
    key("rotor.unbalances.NAME.radius", Kind::Number("m"), Need::Required, Range::NOT_NEGATIVE, When::Always,
        "eccentricity of that mass"),
    key("rotor.unbalances.NAME.phase", Kind::Number("rad"), Need::Number(0.0), Range::ANY, When::Always,
        "angle of that mass in the rotor"),
    key("rotor.unbalances.NAME.kind", Kind::Choice(&["added", "lost"]), Need::Word("added"), Range::ANY, When::Always,
        "mass added (as the paper) or mass lost there"),
    key("rotor.unbalances.NAME.present", Kind::Choice(&["at release", "before"]), Need::Word("at release"), Range::ANY, When::Always,
        "appears at t = 0, or was present before: the run starts from its steady state"),
    key("rotor.unbalances.NAME.release_time", Kind::Number("s"), Need::Optional("appears at t = 0"), Range::NOT_NEGATIVE, When::Always,
        "time at which the mass is released; at most one of release_time and release_speed"),
    key("rotor.unbalances.NAME.release_speed", Kind::Number("rad/s"), Need::Optional("appears at t = 0"), Range::POSITIVE, When::Always,
        "speed at which the mass is released: the first time at which the mean spin is there, rising or falling"),
    key("rotor.damping.mass_proportional", Kind::Number("1/s"), Need::Number(0.0), Range::NOT_NEGATIVE, When::Shaft,
        "a in C = a M + b K of the shaft; lateral, fixed frame"),
    key("rotor.damping.stiffness_proportional", Kind::Number("s"), Need::Number(0.0), Range::NOT_NEGATIVE, When::Shaft,
        "b in C = a M + b K of the shaft; lateral, fixed frame"),
    key("rotor.damping.torsional", Kind::Number("s"), Need::Optional("as rotor.damping.stiffness_proportional"), Range::NOT_NEGATIVE, When::Shaft,
        "b in C = b K of the torsion of the shaft; it never brakes the spin"),
    key("rotor.speed_law.acceleration", Kind::Number("rad/s2"), Need::Optional("the spin is an unknown"), Range::ANY, When::Always,
        "prescribed speed: initial_speed + acceleration t, never below 0"),
    key("rotor.speed_law.times", Kind::List("s"), Need::Optional("the spin is an unknown"), Range::NOT_NEGATIVE, When::Always,
        "times of a prescribed speed, ascending from 0"),
    key("rotor.speed_law.speeds", Kind::List("rad/s"), Need::Optional("the spin is an unknown"), Range::NOT_NEGATIVE, When::Always,
        "speeds at these times, linear between; the first is initial_speed"),
    key("rotor.initial.displacement", Kind::Vector("m"), Need::Number(0.0), Range::ANY, When::Always,
        "displacement of the whole rotor at t = 0, added to its steady state"),
    key("rotor.initial.velocity", Kind::Vector("m/s"), Need::Number(0.0), Range::ANY, When::Always,
        "velocity of the whole rotor at t = 0, added to its steady state"),
    key("rotor.initial.angle", Kind::Number("rad"), Need::Number(0.0), Range::ANY, When::Always,
        "spin angle at t = 0"),
    // `[braking]`.
    key("braking.constant", Kind::Number("N m"), Need::Number(0.0), Range::NOT_NEGATIVE, When::Always,
        "c0 in T = c0 + c1 W + c2 W|W|; braking.speeds and braking.torques add a table"),
    key("braking.linear", Kind::Number("N m s"), Need::Number(0.0), Range::NOT_NEGATIVE, When::Always,
        "c1 in T = c0 + c1 W + c2 W|W|"),
    key("braking.quadratic", Kind::Number("N m s2"), Need::Number(0.0), Range::NOT_NEGATIVE, When::Always,
        "c2 in T = c0 + c1 W + c2 W|W|"),
    key("braking.speeds", Kind::List("rad/s"), Need::Optional("no table"), Range::NOT_NEGATIVE, When::Always,
        "speeds of a table of braking torques, ascending from 0 to at least rotor.initial_speed"),
    key("braking.torques", Kind::List("N m"), Need::Optional("no table"), Range::NOT_NEGATIVE, When::Always,
        "braking torques at these speeds, linear between, constant above the last; they add to constant, linear and quadratic"),
    // `[torques.NAME]`.
    key("torques.NAME.position", Kind::Number("m"), Need::Required, Range::NOT_NEGATIVE, When::Shaft,
        "place along the shaft where the torque acts; between two nodes it makes a node of its own"),
    key("torques.NAME.times", Kind::List("s"), Need::Optional("constant, with balance"), Range::NOT_NEGATIVE, When::Always,
        "times of the torque, ascending; the same time twice: a jump"),
    key("torques.NAME.values", Kind::List("N m"), Need::Optional("0, or that of balance"), Range::ANY, When::Always,
        "torques at these times, positive with the spin; linear between, constant before the first and after the last"),
    key("torques.NAME.balance", Kind::Choice(&FLAG), Need::Word(FLAG[0]), Range::ANY, When::Always,
        "true: this torque takes what the sum of all others and braking lacks to 0 at t = 0; at most one torque"),
    key("torques.NAME.factors", Kind::List(""), Need::Optional("1"), Range::ANY, When::Always,
        "with balance: factors on its torque at times, the first of them 1"),
    key("torques.NAME.short_circuit.start", Kind::Number("s"), Need::Optional("required in a short_circuit"), Range::NOT_NEGATIVE, When::Always,
        "time of a short circuit, from which a decaying alternating torque is added"),
    key("torques.NAME.short_circuit.frequency", Kind::Number("rad/s"), Need::Optional("required in a short_circuit"), Range::POSITIVE, When::Always,
        "circular frequency of the grid (3000 rpm is 50 Hz)"),
    key("torques.NAME.short_circuit.amplitude", Kind::Number("N m"), Need::Optional("required in a short_circuit"), Range::ANY, When::Always,
        "amplitude of the part with the frequency of the grid"),
    key("torques.NAME.short_circuit.decay", Kind::Number("s"), Need::Optional("required in a short_circuit"), Range::POSITIVE, When::Always,
        "time constant of that part"),
    key("torques.NAME.short_circuit.double_amplitude", Kind::Number("N m"), Need::Optional("0"), Range::ANY, When::Always,
        "amplitude of the part with twice the frequency of the grid"),
    key("torques.NAME.short_circuit.double_decay", Kind::Number("s"), Need::Optional("as decay"), Range::POSITIVE, When::Always,
        "time constant of the part with twice the frequency of the grid"),
    // `[diaphragms.NAME]`.
    key("diaphragms.NAME.kind", Kind::Choice(&["flexible", "rigid", "radial-spring"]), Need::Word("flexible"), Range::ANY, When::Always,
        "ring on blades, a circle that does not move, or a massless quasi-static radial spring"),
    key("diaphragms.NAME.angle", Kind::Number("rad"), Need::Number(0.0), Range::ANY, When::Always,
        "rotation of the stator about Z: blade k is at angle + 2 pi k / count"),
    key("diaphragms.NAME.stiffness", Kind::Number("N/m"), Need::Required, Range::POSITIVE, When::RadialSpring,
        "contact force over penetration"),
    key("diaphragms.NAME.material.young_modulus", Kind::Number("Pa"), Need::Required, Range::POSITIVE, When::Flexible,
        "Young's modulus of ring and blades"),
    key("diaphragms.NAME.material.poisson_ratio", Kind::Number(""), Need::Required, POISSON, When::Flexible,
        "Poisson's ratio of ring and blades (not used by the planar model)"),
    key("diaphragms.NAME.material.density", Kind::Number("kg/m3"), Need::Required, Range::POSITIVE, When::Flexible,
        "density of ring and blades"),
    key("diaphragms.NAME.material.yield_strength", Kind::Number("Pa"), Need::Optional("no limit"), Range::POSITIVE, When::Flexible,
        "yield strength of ring and blades: the largest stresses are compared with it"),
    key("diaphragms.NAME.ring.mean_radius", Kind::Number("m"), Need::Required, Range::POSITIVE, When::Flexible,
        "mean radius of the ring"),
    key("diaphragms.NAME.ring.thickness", Kind::Number("m"), Need::Required, Range::POSITIVE, When::Flexible,
        "radial thickness of the ring"),
    key("diaphragms.NAME.ring.width", Kind::Number("m"), Need::Required, Range::POSITIVE, When::Flexible,
        "axial width of the ring"),
    key("diaphragms.NAME.ring.elements", Kind::Count, Need::Required, RING_ELEMENTS, When::Flexible,
        "curved elements of the ring, a multiple of the number of blades"),
    key("diaphragms.NAME.blades.count", Kind::Count, Need::Number(0.0), BLADES, When::Flexible,
        "number of blades, evenly spaced; 0: a free ring"),
    key("diaphragms.NAME.blades.length", Kind::Number("m"), Need::Optional("only with blades"), Range::POSITIVE, When::Flexible,
        "length of a blade, from the mean line of the ring to the casing"),
    key("diaphragms.NAME.blades.thickness", Kind::Number("m"), Need::Optional("only with blades"), Range::POSITIVE, When::Flexible,
        "tangential thickness of a blade"),
    key("diaphragms.NAME.blades.width", Kind::Number("m"), Need::Optional("only with blades"), Range::POSITIVE, When::Flexible,
        "axial width of a blade"),
    key("diaphragms.NAME.blades.elements", Kind::Count, Need::Optional("only with blades"), BLADE_ELEMENTS, When::Flexible,
        "beam elements of a blade"),
    key("diaphragms.NAME.damping.mass_proportional", Kind::Number("1/s"), Need::Number(0.0), Range::NOT_NEGATIVE, When::Flexible,
        "a in C = a M + b K of ring and blades"),
    key("diaphragms.NAME.damping.stiffness_proportional", Kind::Number("s"), Need::Number(0.0), Range::NOT_NEGATIVE, When::Flexible,
        "b in C = a M + b K of ring and blades"),
    key("diaphragms.NAME.contact.position", Kind::Number("m"), Need::Required, Range::NOT_NEGATIVE, When::Shaft,
        "place along the shaft; between two nodes it makes a node of its own"),
    key("diaphragms.NAME.contact.rotor_radius", Kind::Number("m"), Need::Required, Range::POSITIVE, When::Always,
        "radius of the rotor at the contact"),
    key("diaphragms.NAME.contact.gap", Kind::Number("m"), Need::Required, Range::POSITIVE, When::Always,
        "radial gap; the contact surface has radius rotor_radius + gap"),
    key("diaphragms.NAME.contact.friction", Kind::Number(""), Need::Required, FRICTION, When::Always,
        "Coulomb friction coefficient"),
    key("diaphragms.NAME.contact.friction_law", Kind::Choice(&["stick-slip", "slip"]), Need::Word("stick-slip"), Range::ANY, When::Always,
        "Coulomb's law with stick, or sliding only (as the paper): then a run whose slip changes sign is invalid"),
    key("diaphragms.NAME.contact.detection", Kind::Choice(&Detection::WORDS), Need::Word(Detection::Hyp2.word()), Range::ANY, When::Always,
        "contact place: at the rotor's angle, closest point, or closest point after the prediction"),
    key("diaphragms.NAME.contact.points", Kind::Choice(&["several", "one"]), Need::Word("several"), Range::ANY, When::Always,
        "hyp2, where one contact point has no fixed point: several points on the ring, or the predicted one (as the paper)"),
    key("diaphragms.NAME.contact.offset", Kind::Vector("m"), Need::Number(0.0), Range::ANY, When::Always,
        "centre of the diaphragm from the bearing line"),
    key("diaphragms.NAME.contact.surface", Kind::Choice(&["inner-face", "mean-line"]), Need::Word("inner-face"), Range::ANY, When::Always,
        "line of the ring that touches: inner face, or mean line (as the paper)"),
    // `[monitors.NAME]`.
    key("monitors.NAME.position", Kind::Number("m"), Need::Required, Range::NOT_NEGATIVE, When::Shaft,
        "place along the shaft whose displacement is reported; between two nodes it makes a node of its own"),
    key("monitors.NAME.gap", Kind::Number("m"), Need::Required, Range::POSITIVE, When::Always,
        "clearance at that place: the time with a larger displacement is reported; nothing touches there"),
];

/// Returns the default of a key; `None`: the format has no such key.
#[must_use]
pub fn default_of(path: &str) -> Option<Need> {
    KEYS.iter().find(|key| key.path == path).map(|key| key.need)
}

/// Every key, in the order of the format.
#[must_use]
pub fn keys() -> &'static [Key] {
    KEYS
}
