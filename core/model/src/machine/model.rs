//! The validated machine: every number in SI units, every reference resolved to a node, every default filled in.
//!
//! A `MachineDef` (the content of a file) becomes a [`Machine`] once all checks pass; later code does not check again.
//! Angles in rad, speeds in rad/s. Frame OXYZ of `docs/theory/01-shaft-line.md`: Z along the shaft, spin positive about +Z.

use super::bearing_table::BearingTable;
use crate::outcome::Limit;

pub use super::braking::Braking;
pub use super::torque::{ShortCircuit, Torque};
pub use super::unbalance::{Presence, Release, Unbalance, UnbalanceKind};

/// One machine, ready for the solver.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Name given in the file.
    pub name: String,
    /// End conditions and numerical settings.
    pub run: RunSettings,
    /// The shaft line.
    pub rotor: Rotor,
    /// Torque that slows the shaft line.
    pub braking: Braking,
    /// Torques over time, in the order of the file.
    pub torques: Vec<Torque>,
    /// Diaphragms in the order of the file; empty: no contact.
    pub diaphragms: Vec<Diaphragm>,
    /// Places whose displacement is monitored, in the order of the file.
    pub monitors: Vec<Monitor>,
}

/// A place of the shaft whose displacement is monitored; the shaft touches nothing there.
#[derive(Debug, Clone, PartialEq)]
pub struct Monitor {
    /// Name of its table.
    pub name: String,
    /// Its node.
    pub node: usize,
    /// Clearance \[m\] > 0: the time with a larger displacement is reported.
    pub gap: f64,
}

/// Engine that integrates the transient.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Engine {
    /// Modes of the rotor on its bearings and of the ring.
    Reduced,
    /// All finite-element degrees of freedom, as in the paper.
    Full,
    /// Modes, propagated exactly, with contact by impulses.
    Exponential,
}

/// Contact place at which the contact force of step n acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ForceLocation {
    /// At the contact place of step n+1 (the paper's choice, default).
    Next,
    /// At the contact place of step n.
    Current,
}

/// Thresholds of the validity guard (docs/theory/03-contact.md).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guard {
    /// Normal contact work over max(friction energy, 1e-3 of the initial energy) \[-\]; default 0.01.
    pub normal_work: f64,
    /// Energy balance error over the largest total energy \[-\]; default 1e-6.
    pub energy_balance: f64,
    /// Residual penetration over the gap \[-\]; default 0.02.
    pub penetration: f64,
    /// Smallest equivalent number of steps of a contact phase with a flexible ring; default 20 with the exponential engine, otherwise 64.
    pub impact_steps: f64,
}

/// Treatment of a run that exceeds a limit of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OnExceed {
    /// The run gets the status `beyond`.
    Beyond,
    /// The status is kept and the limit is noted in the row.
    Note,
}

/// One limit of the physical model: `[run.limit.NAME]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelLimit {
    /// Kind of limit.
    pub limit: Limit,
    /// Largest allowed value of its quantity \[-\] > 0.
    pub value: f64,
    /// Treatment of a run above it.
    pub on_exceed: OnExceed,
}

/// `[run]`.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSettings {
    /// Last simulated time \[s\] > 0.
    pub end_time: f64,
    /// The run ends once the mean spin falls to this speed \[rad/s\] >= 0.
    pub end_speed: f64,
    /// Engine.
    pub engine: Engine,
    /// Time step \[s\]; `None`: chosen from the highest frequency of the model.
    pub step: Option<f64>,
    /// Contact step of the exponential engine \[s\]; `None`: chosen by its rule, or another engine.
    pub contact_step: Option<f64>,
    /// Location of the contact force.
    pub force_location: ForceLocation,
    /// Lateral rotor modes of the reduced and the exponential engine; `None`: the default of the engine.
    pub rotor_modes: Option<usize>,
    /// Elastic torsional modes of the reduced and the exponential engine; `None`: the default of the engine.
    pub torsional_modes: Option<usize>,
    /// Ring modes of the reduced and the exponential engine (each diaphragm); `None`: the default of the engine.
    pub ring_modes: Option<usize>,
    /// Whether the reduced engine adds the residual flexibility of the truncated modes at the contact.
    pub static_residual: bool,
    /// Largest number of steps; beyond it the run fails with `step_limit`. `None`: no limit.
    pub step_limit: Option<u64>,
    /// Relative shift of the initial speed of a twin run \[-\]; 0: no twin.
    pub twin: f64,
    /// Largest relative change of a result between a run and its twin \[-\]; above it the run is sensitive.
    pub twin_limit: f64,
    /// Validity guard.
    pub guard: Guard,
    /// Limits of the physical model, in the order of [`Limit::ALL`].
    pub limits: [ModelLimit; Limit::ALL.len()],
    /// Whether the run ends at the first exceeded limit with [`OnExceed::Beyond`].
    pub end_beyond: bool,
}

/// `[rotor]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Rotor {
    /// Model of the rotor.
    pub kind: RotorKind,
    /// Spin speed at t = 0 \[rad/s\] >= 0.
    pub initial_speed: f64,
    /// Gravity along X and Y \[m/s2\].
    pub gravity: [f64; 2],
    /// Prescribed speed; `None`: the spin follows from the equations of motion (the normal case).
    pub speed_law: Option<SpeedLaw>,
    /// Disturbance of the initial state.
    pub initial: InitialState,
    /// Bearings in the order of the file.
    pub bearings: Vec<Bearing>,
    /// Unbalances in the order of the file.
    pub unbalances: Vec<Unbalance>,
    /// Rayleigh damping of the shaft in the fixed frame (lateral only).
    pub damping: Rayleigh,
    /// Factor b of the torsional damping `C = b K` \[s\]. The rigid spin is in the null space of K, so this damping does not brake it.
    pub torsional_damping: f64,
}

/// Model of the rotor.
#[derive(Debug, Clone, PartialEq)]
pub enum RotorKind {
    /// Timoshenko shaft with rigid discs.
    Shaft(Shaft),
    /// Jeffcott rotor: one node with two translations and the spin, carried by its bearings.
    PointMass(PointMass),
}

/// Shaft line of finite elements.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaft {
    /// Node positions along Z \[m\], ascending; one more than elements.
    pub nodes: Vec<f64>,
    /// Elements from left to right; element i joins nodes i and i+1.
    pub elements: Vec<ShaftElement>,
    /// Layers on the elements, in the order of the file.
    pub layers: Vec<Layer>,
    /// Discs in the order of the file.
    pub discs: Vec<Disc>,
}

impl Shaft {
    /// Parts of the layers that lie on an element, in the order of the file.
    pub fn layers_on(&self, element: usize) -> impl Iterator<Item = &ShaftElement> {
        self.layers.iter().filter_map(move |layer| layer.elements.get(element.checked_sub(layer.first)?))
    }
}

/// A sleeve or another layer on the shaft: its stiffness and mass are added to those of the elements below it.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Name of its table.
    pub name: String,
    /// First shaft element of the layer.
    pub first: usize,
    /// Parts of the layer on its elements, from left to right, each as long as its element.
    pub elements: Vec<ShaftElement>,
}

/// One shaft element, round, hollow if it has an inner diameter; diameters vary linearly between its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShaftElement {
    /// Length \[m\] > 0.
    pub length: f64,
    /// Outer diameter at its left end \[m\] > 0.
    pub diameter: f64,
    /// Inner diameter at its left end \[m\], 0 <= inner < outer.
    pub inner_diameter: f64,
    /// Outer diameter at its right end \[m\] > 0.
    pub end_diameter: f64,
    /// Inner diameter at its right end \[m\], 0 <= inner < outer.
    pub end_inner_diameter: f64,
    /// Young's modulus \[Pa\].
    pub young_modulus: f64,
    /// Poisson's ratio \[-\].
    pub poisson_ratio: f64,
    /// Density [kg/m3].
    pub density: f64,
    /// k in k G S; the calculated number if the file has "cowper"; `None` ("none" in the file): no shear deformation.
    pub shear_coefficient: Option<f64>,
    /// Yield strength \[Pa\] > 0; `None`: the file gives none.
    pub yield_strength: Option<f64>,
    /// Index of the `[[rotor.shaft]]` section this element belongs to.
    pub section: usize,
}

/// Rigid disc at a node.
#[derive(Debug, Clone, PartialEq)]
pub struct Disc {
    /// Name of its table.
    pub name: String,
    /// Node.
    pub node: usize,
    /// Mass \[kg\] >= 0.
    pub mass: f64,
    /// Moment of inertia about a diameter \[kg m2\] >= 0.
    pub transverse_inertia: f64,
    /// Moment of inertia about Z \[kg m2\] >= 0.
    pub polar_inertia: f64,
}

/// Jeffcott rotor.
#[derive(Debug, Clone, PartialEq)]
pub struct PointMass {
    /// Mass \[kg\] >= 0 (0 when an added unbalance is all the mass).
    pub mass: f64,
    /// Moment of inertia about Z \[kg m2\] > 0.
    pub polar_inertia: f64,
}

/// Bearing at a node, between rotor and ground or pedestal.
#[derive(Debug, Clone, PartialEq)]
pub struct Bearing {
    /// Name of its table.
    pub name: String,
    /// Node.
    pub node: usize,
    /// Stiffness [[kxx, kxy], [kyx, kyy]] \[N/m\]; force on the rotor = -K x.
    pub stiffness: [[f64; 2]; 2],
    /// Damping [[cxx, cxy], [cyx, cyy]] \[N s/m\].
    pub damping: [[f64; 2]; 2],
    /// Axial stiffness \[N/m\] >= 0.
    pub axial_stiffness: f64,
    /// Radial clearance \[m\] > 0 for the limit `journal_clearance`; without effect on the motion.
    pub clearance: Option<f64>,
    /// Position of the bearing's seat relative to the bearing line \[m\], where the bearing force is zero.
    pub elevation: [f64; 2],
    /// Pedestal between bearing and ground; `None`: rigid ground.
    pub pedestal: Option<Pedestal>,
    /// Coefficients over the speed; `stiffness` and `damping` then have the constant part of the table.
    pub table: Option<BearingTable>,
}

impl Bearing {
    /// Static stiffness of bearing and pedestal in series to ground \[N/m\]: `(K^-1 + K_p^-1)^-1`; zero without a static equilibrium.
    #[must_use]
    pub fn stiffness_to_ground(&self) -> [[f64; 2]; 2] {
        let Some(pedestal) = &self.pedestal else { return self.stiffness };
        let ([[a, b], [c, d]], [p, q]) = (self.stiffness, pedestal.stiffness);
        // K_p (K + K_p)^-1 K, by the determinant of K + K_p
        let determinant = (a + p) * (d + q) - b * c;
        if determinant <= 0.0 {
            return [[0.0; 2]; 2];
        }
        let own = a * d - b * c;
        let scale = 1.0 / determinant;
        [[p * (own + a * q) * scale, p * q * b * scale], [p * q * c * scale, q * (own + d * p) * scale]]
    }
}

/// Pedestal: mass, spring and damper between a bearing and the ground, along X and Y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pedestal {
    /// Mass \[kg\] >= 0.
    pub mass: [f64; 2],
    /// Stiffness to ground \[N/m\] > 0.
    pub stiffness: [f64; 2],
    /// Damping to ground \[N s/m\] >= 0.
    pub damping: [f64; 2],
}

/// Rayleigh damping C = a M + b K.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rayleigh {
    /// a \[1/s\] >= 0.
    pub mass_proportional: f64,
    /// b \[s\] >= 0.
    pub stiffness_proportional: f64,
}

/// Prescribed speed, piecewise linear in time; constant after the last point.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedLaw {
    /// Times \[s\], strictly ascending, the first 0.
    pub times: Vec<f64>,
    /// Speeds \[rad/s\] at these times; the first equals `initial_speed`.
    pub speeds: Vec<f64>,
}

/// Disturbance of the initial state, added to static sag and steady state.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct InitialState {
    /// Translation of all nodes \[m\].
    pub displacement: [f64; 2],
    /// Velocity of all nodes \[m/s\].
    pub velocity: [f64; 2],
    /// Spin angle at t = 0 \[rad\].
    pub angle: f64,
}

/// One diaphragm and the contact at its inner edge.
#[derive(Debug, Clone, PartialEq)]
pub struct Diaphragm {
    /// Name of its table.
    pub name: String,
    /// Model of the stator.
    pub kind: DiaphragmKind,
    /// Rotation of the stator about Z \[rad\]: blade k is at `angle + 2 pi k / count`.
    pub angle: f64,
    /// The contact.
    pub contact: Contact,
}

/// Stator model.
#[derive(Debug, Clone, PartialEq)]
pub enum DiaphragmKind {
    /// Ring of curved beams on radial blades.
    Flexible(FlexibleStator),
    /// A fixed circle.
    Rigid,
    /// Massless, quasi-static radial spring: force = stiffness x penetration \[N/m\].
    RadialSpring {
        /// Stiffness \[N/m\] > 0.
        stiffness: f64,
    },
}

/// Flexible ring with blades.
#[derive(Debug, Clone, PartialEq)]
pub struct FlexibleStator {
    /// Young's modulus \[Pa\].
    pub young_modulus: f64,
    /// Poisson's ratio \[-\] (not used by the planar Euler-Bernoulli model).
    pub poisson_ratio: f64,
    /// Density [kg/m3].
    pub density: f64,
    /// Yield strength of ring and blades \[Pa\] > 0; `None`: the file gives none.
    pub yield_strength: Option<f64>,
    /// The ring.
    pub ring: Ring,
    /// The blades; `None`: a free ring.
    pub blades: Option<Blades>,
    /// Rayleigh damping of ring and blades.
    pub damping: Rayleigh,
}

/// Inner ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring {
    /// Mean radius R_c \[m\].
    pub mean_radius: f64,
    /// Radial thickness \[m\].
    pub thickness: f64,
    /// Axial width \[m\].
    pub width: f64,
    /// Number of curved elements, a multiple of the blade count, at least 4.
    pub elements: usize,
}

/// Radial blades from the ring's mean line to the casing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blades {
    /// Number of evenly spaced blades, >= 1.
    pub count: usize,
    /// Length \[m\].
    pub length: f64,
    /// Tangential thickness \[m\].
    pub thickness: f64,
    /// Axial width \[m\].
    pub width: f64,
    /// Elements of each blade >= 1.
    pub elements: usize,
}

/// Coulomb friction, with or without sticking.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrictionLaw {
    /// `|lambda_T| <= mu lambda` with zero slip, or sliding ("stick-slip", default).
    StickSlip,
    /// Sliding only, its direction frozen at the prediction ("slip", the paper's choice); a run whose slip changes sign is
    /// invalid with cause `slip_reversal`.
    Slip,
}

/// Method of finding the contact place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detection {
    /// At the angle of the rotor centre.
    Hyp1,
    /// Closest point of the deformed ring, updated in every iteration.
    Hyp2,
    /// Closest point after the prediction, then kept.
    Hyp2Frozen,
}

/// Treatment of a step in which the exact contact place has no fixed point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactPoints {
    /// Several contact points on the ring ("several", default).
    Several,
    /// One point at the predicted place ("one", the paper's assumption).
    One,
}

/// Line of the ring that touches the rotor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactSurface {
    /// Inner face: u_P = u - (R_c - R_i) theta_z (default).
    InnerFace,
    /// Mean line: u_P = u (the paper's choice).
    MeanLine,
}

/// Contact between rotor and diaphragm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Node of the rotor.
    pub node: usize,
    /// Rotor radius R_r \[m\] > 0.
    pub rotor_radius: f64,
    /// Gap \[m\] > 0; the contact surface has radius R_i = R_r + gap.
    pub gap: f64,
    /// Coulomb friction \[-\] >= 0.
    pub friction: f64,
    /// Friction law.
    pub friction_law: FrictionLaw,
    /// Detection of the contact place.
    pub detection: Detection,
    /// Treatment of a step without a fixed point, for [`Detection::Hyp2`].
    pub points: ContactPoints,
    /// Centre of the diaphragm from the bearing line \[m\].
    pub offset: [f64; 2],
    /// Contact surface.
    pub surface: ContactSurface,
}
