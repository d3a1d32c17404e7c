//! Structure: the data that many samples share, namely matrices, modes and coordinates of one machine. It is immutable.
//!
//! Coordinates of the full engine are the finite-element degrees of freedom, those of the reduced engine modal amplitudes. The transient uses both
//! through [`Coordinates`] and evaluates every non-linear term at the nodes.

mod bearings;
mod coordinates;
mod engine_cache;
mod part;
mod short_impacts;
mod truncation_error;

pub use coordinates::Coordinates;
pub use part::Part;
pub use truncation_error::MAX_TRUNCATION_ERROR;

use crate::modal::{Basis, BasisError, ModeSet, is_key_of, modal_key, table_mode_count};
use crate::rotor::RotorMatrices;
use crate::stator::RingMatrices;
use bladeoff_model::machine::{
    Bearing, Diaphragm, DiaphragmKind, Engine, Machine, ModelLimit, OnExceed, Rotor, RotorKind,
};
use bladeoff_numerics::linalg::{Matrix, mul_vec};

/// Flexible ring of a diaphragm.
#[derive(Debug, Clone, PartialEq)]
pub struct RingPart {
    /// Finite-element matrices and surface.
    pub matrices: RingMatrices,
    /// Linear equations of motion of ring and blades.
    pub part: Part,
    /// Static flexibility of the truncated modes: displacements of the ring's degrees of freedom by forces on those of ring and blades. `None` where no
    /// mode is truncated, the correction is switched off, or a mode is not stiff (a free ring, bearings of indefinite stiffness).
    pub residual: Option<Matrix>,
    /// Truncation errors of the ring's nodes in the radial direction.
    pub(crate) truncation_errors: Vec<truncation_error::TruncationError>,
    /// Cache of an engine for runs that share the ring.
    pub(crate) engine_cache: engine_cache::EngineCache,
    /// Cache of its stress recovery.
    pub(crate) stress_cache: engine_cache::EngineCache,
}

/// All data that samples of one structure share.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    /// Machine with everything that varies between samples set to one value.
    structural: Machine,
    /// Finite-element shaft line.
    pub rotor: RotorMatrices,
    /// Linear part of the lateral motion.
    pub lateral: Part,
    /// Linear part of the torsion; coordinates of absolute angles.
    pub torsion: Part,
    /// Static flexibility of the truncated lateral modes, on the nodal degrees of freedom; `None` as for a ring.
    pub lateral_residual: Option<Matrix>,
    /// One entry per diaphragm; `None` for a stator without degrees of freedom.
    pub rings: Vec<Option<RingPart>>,
    /// Truncation errors of the shaft's nodes.
    rotor_truncation_errors: Vec<truncation_error::TruncationError>,
    /// Modal basis of rotor, torsion and rings.
    basis: Basis,
    /// Number of attachment modes at the end of the lateral basis.
    attachments: usize,
    /// Whether the basis was computed by this build and not frozen earlier.
    computed: bool,
    /// Cache of an engine for runs that share the structure.
    pub(crate) engine_cache: engine_cache::EngineCache,
    /// Cache of the damping of whirl modes at speeds where it has been computed.
    pub(crate) stability_cache: engine_cache::EngineCache,
}

impl Structure {
    /// Builds matrices and coordinates. A frozen basis is used unchanged, after a check of its key.
    ///
    /// # Errors
    /// [`BasisError`] if a mode problem fails or the basis belongs to another structure.
    pub fn build(machine: &Machine, frozen: Option<&Basis>) -> Result<Self, BasisError> {
        if let Some(basis) = frozen.filter(|basis| !is_key_of(&basis.key, machine)) {
            let expected = hex(&modal_key(machine));
            return Err(BasisError::OtherStructure { expected, found: hex(&basis.key) });
        }
        let rotor = RotorMatrices::assemble(&machine.rotor);
        let rings: Vec<Option<RingMatrices>> = machine
            .diaphragms
            .iter()
            .map(|d| match &d.kind {
                DiaphragmKind::Flexible(stator) => Some(RingMatrices::assemble(stator)),
                DiaphragmKind::Rigid | DiaphragmKind::RadialSpring { .. } => None,
            })
            .collect();
        let basis = match frozen {
            Some(basis) => basis.clone(),
            None => {
                let flexible: Vec<RingMatrices> = rings.iter().flatten().cloned().collect();
                Basis::compute(machine, &rotor, &flexible)?
            }
        };
        let (coordinates, by_sectors) = (coordinates(machine), machine.run.engine == Engine::Exponential);
        let mut sets = basis.rings.iter();
        let rings = rings.into_iter().map(|ring| {
            ring.map(|matrices| ring_part(matrices, sets.next().expect("one set per ring"), coordinates, by_sectors))
        });
        let rings = rings.collect();
        Ok(Self { computed: frozen.is_none(), ..Self::about(machine, rotor, basis, rings) })
    }

    /// Structure of another machine, as [`Structure::build`] computes it without a frozen basis. Rings that both machines share are copied, because
    /// they take longest to compute. Rings of a frozen basis are not copied: an earlier version may have computed them with other last digits, and a
    /// sample's result would depend on the samples before it.
    ///
    /// # Errors
    /// [`BasisError`] if a mode problem fails.
    pub fn rebuilt(&self, machine: &Machine) -> Result<Self, BasisError> {
        let of_rings = |machine: &Machine| (machine.diaphragms.clone(), machine.run.clone());
        if !self.computed || of_rings(&structural(machine)) != of_rings(&self.structural) {
            return Self::build(machine, None);
        }
        let rotor = RotorMatrices::assemble(&machine.rotor);
        let basis = Basis::beside(machine, &rotor, self.basis.rings.clone())?;
        Ok(Self::about(machine, rotor, basis, self.rings.clone()))
    }

    fn about(machine: &Machine, rotor: RotorMatrices, basis: Basis, rings: Vec<Option<RingPart>>) -> Self {
        let (reduced, correct) = coordinates(machine);
        let point = matches!(machine.rotor.kind, RotorKind::PointMass(_));
        let lateral = if reduced && !point {
            Part::reduced(&basis.lateral, &rotor.damping)
        } else {
            Part::full(&rotor.mass, &rotor.damping, &rotor.stiffness, basis.lateral.full_limit)
        };
        let torsion = if reduced {
            Part::proportional(&basis.torsion, 0.0, rotor.torsional_damping)
        } else {
            let damping = &rotor.torsional_stiffness * rotor.torsional_damping;
            Part::full(&rotor.torsional_mass, &damping, &rotor.torsional_stiffness, basis.torsion.full_limit)
        };
        let places = (0..rotor.nodes).map(|node| rotor.plane_places(node));
        let added = table_mode_count(&rotor, (&basis.lateral.omega_squared, &basis.lateral.shapes));
        let whole = truncation_error::FullPart { stiffness: &rotor.stiffness, mass: &rotor.mass, sectors: None, added };
        let (lateral_residual, rotor_lags) = truncation_error::truncated_flexibility(
            &lateral,
            &basis.lateral,
            whole,
            correct,
            rotor.lateral_size(),
            places,
        );
        Self {
            structural: structural(machine),
            rotor,
            lateral,
            torsion,
            lateral_residual,
            rings,
            rotor_truncation_errors: rotor_lags,
            basis,
            attachments: added,
            computed: true,
            engine_cache: engine_cache::EngineCache::default(),
            stability_cache: engine_cache::EngineCache::default(),
        }
    }

    /// Whether a machine has this structure. It may differ in every value that a study varies between samples.
    #[must_use]
    pub fn fits(&self, machine: &Machine) -> bool {
        self.structural == structural(machine)
    }

    /// Static displacements of the truncated modes under the forces of bearing seats off the bearing line [m, rad]; `None` without such a seat, or
    /// without static correction.
    #[must_use]
    pub fn truncated_seats(&self, rotor: &Rotor) -> Option<Vec<f64>> {
        let residual = self.lateral_residual.as_ref()?;
        let is_raised = |bearing: &Bearing| bearing.elevation != [0.0; 2];
        rotor.bearings.iter().find(|bearing| is_raised(bearing))?;
        let mut force = vec![0.0; residual.ncols()];
        for (site, bearing) in self.rotor.bearings.iter().zip(&rotor.bearings) {
            site.push(site.seat_force(bearing.elevation), &mut force);
        }
        let mut lateral = vec![0.0; residual.nrows()];
        mul_vec(residual, &force, &mut lateral);
        Some(lateral)
    }

    /// Largest share (3) of `truncation_error` over the contacts of all diaphragms, 0 to 1: the share of the flexibility whose inertia is neglected.
    /// The share is 1 for a rigid ring next to a flexible one if modes of the rotor are truncated. The rigid ring then takes up to 67 % too much of
    /// an impact (`a_rigid_ring_beside_a_flexible_one_is_computed_with_all_modes_alone`).
    #[must_use]
    pub fn truncation_error_at_contact(&self, machine: &Machine) -> f64 {
        let is_truncated = |diaphragm: &Diaphragm| {
            let rotor = self.rotor_truncation_errors.get(diaphragm.contact.node);
            truncation_error::at_contact(rotor, &[], &DiaphragmKind::Rigid) > 0.0
        };
        if has_rigid_and_flexible_rings(machine) && machine.diaphragms.iter().any(is_truncated) {
            return 1.0;
        }
        let shares = machine.diaphragms.iter().zip(&self.rings).map(|(diaphragm, ring)| {
            let rotor = self.rotor_truncation_errors.get(diaphragm.contact.node);
            truncation_error::at_contact(
                rotor,
                ring.as_ref().map_or(&[][..], |ring| &ring.truncation_errors),
                &diaphragm.kind,
            )
        });
        shares.fold(0.0, f64::max)
    }

    /// Modal basis, for freezing.
    #[must_use]
    pub fn basis(&self) -> &Basis {
        &self.basis
    }
}

/// Whether two machines have the same structure, by the criterion of [`Structure::fits`].
#[must_use]
pub fn same_structure(one: &Machine, other: &Machine) -> bool {
    structural(one) == structural(other)
}

/// Whether the coordinates are modal, and whether the truncated modes follow forces statically.
fn coordinates(machine: &Machine) -> (bool, bool) {
    let reduced = machine.run.engine != Engine::Full;
    (reduced, reduced && machine.run.static_residual)
}

/// Whether the machine has both a rigid and a flexible ring.
fn has_rigid_and_flexible_rings(machine: &Machine) -> bool {
    let kinds = || machine.diaphragms.iter().map(|diaphragm| &diaphragm.kind);
    kinds().any(|kind| matches!(kind, DiaphragmKind::Rigid))
        && kinds().any(|kind| matches!(kind, DiaphragmKind::Flexible(_)))
}

/// Ring with its modal basis. `by_sectors`: the static flexibility uses cyclic symmetry, as the modes do. Other engines use the whole matrix.
fn ring_part(matrices: RingMatrices, modes: &ModeSet, (reduced, correct): (bool, bool), by_sectors: bool) -> RingPart {
    let (a, b) = (matrices.mass_proportional, matrices.stiffness_proportional);
    let part = if reduced {
        Part::proportional(modes, a, b)
    } else {
        let damping = &matrices.mass * a + &matrices.stiffness * b;
        Part::full(&matrices.mass, &damping, &matrices.stiffness, modes.full_limit)
    };
    let radial = (0..matrices.nodes).map(|node| [4 * node + 2; 2]);
    let sectors = by_sectors.then_some(&matrices.sectors);
    let whole = truncation_error::FullPart { stiffness: &matrices.stiffness, mass: &matrices.mass, sectors, added: 0 };
    let (residual, lags) =
        truncation_error::truncated_flexibility(&part, modes, whole, correct, 4 * matrices.nodes, radial);
    RingPart {
        matrices,
        part,
        residual,
        truncation_errors: lags,
        engine_cache: engine_cache::EngineCache::default(),
        stress_cache: engine_cache::EngineCache::default(),
    }
}

/// The machine with everything that varies between samples set to one value.
fn structural(machine: &Machine) -> Machine {
    let mut kept = machine.clone();
    kept.name.clear();
    kept.run = bladeoff_model::machine::RunSettings {
        end_time: 0.0,
        end_speed: 0.0,
        engine: machine.run.engine,
        step: None,
        contact_step: None,
        force_location: bladeoff_model::machine::ForceLocation::Next,
        rotor_modes: machine.run.rotor_modes,
        torsional_modes: machine.run.torsional_modes,
        ring_modes: machine.run.ring_modes,
        static_residual: machine.run.static_residual,
        step_limit: None,
        twin: 0.0,
        twin_limit: 0.0,
        guard: bladeoff_model::machine::Guard {
            normal_work: 0.0,
            energy_balance: 0.0,
            penetration: 0.0,
            impact_steps: 0.0,
        },
        limits: machine.run.limits.map(|limit| ModelLimit { value: 0.0, on_exceed: OnExceed::Note, ..limit }),
        end_beyond: true,
    };
    // an engine prepares for the presence of a journal clearance, not for its value
    kept.rotor
        .bearings
        .iter_mut()
        .filter_map(|bearing| bearing.clearance.as_mut())
        .for_each(|clearance| *clearance = 0.0);
    kept.monitors.iter_mut().for_each(|monitor| monitor.gap = 0.0);
    kept.rotor.bearings.iter_mut().for_each(|bearing| bearing.elevation = [0.0; 2]);
    kept.rotor.initial_speed = 0.0;
    kept.rotor.gravity = [0.0; 2];
    kept.rotor.speed_law = None;
    kept.rotor.initial = bladeoff_model::machine::InitialState::default();
    kept.rotor.unbalances.clear();
    kept.braking = bladeoff_model::machine::Braking::default();
    kept.torques.clear();
    for diaphragm in &mut kept.diaphragms {
        diaphragm.angle = 0.0;
        if let DiaphragmKind::RadialSpring { stiffness } = &mut diaphragm.kind {
            *stiffness = 0.0;
        }
        diaphragm.contact = bladeoff_model::machine::Contact {
            node: 0,
            rotor_radius: 0.0,
            gap: 0.0,
            friction: 0.0,
            friction_law: bladeoff_model::machine::FrictionLaw::StickSlip,
            detection: bladeoff_model::machine::Detection::Hyp2,
            points: bladeoff_model::machine::ContactPoints::Several,
            offset: [0.0; 2],
            surface: bladeoff_model::machine::ContactSurface::InnerFace,
        };
    }
    kept
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().take(8).map(|byte| format!("{byte:02x}")).collect()
}
