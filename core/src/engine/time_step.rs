//! Time step of a run, its stability limit, and the checks before a run starts.

use crate::rotor::UnbalanceSite;
use crate::structure::Structure;
use bladeoff_model::machine::{
    Contact, ContactPoints, Detection, DiaphragmKind, Engine, Machine, RotorKind, Unbalance, UnbalanceKind,
};
use bladeoff_numerics::linalg::{EigenError, Matrix, add_outer, symmetric_generalised};
use bladeoff_text::document::units::{format_digits, format_quantity};

/// Default time step as a fraction of the stability limit.
///
/// On both reference machines, halving this step changes robust outputs less than a change of the contact detection does
/// (`docs/theory/convergence.md`).
const DEFAULT_FRACTION: f64 = 0.5;

/// Minimum number of default steps per period. The period is the shorter of a revolution at the highest speed and the period of the lowest lateral
/// mode. The scheme's relative error of a period is then `(omega dt)^2/24 = 1.6e-6`. This bound applies to rotors with few degrees of freedom, whose
/// highest frequency is low.
const PARTS: f64 = 1000.0;
/// Minimum number of default steps per period with a radial spring. Contact begins and ends within a step, and positions after an
/// impact are of second order.
const SPRING_PARTS: f64 = 4.0 * PARTS;

/// Default contact step as a fraction of `2/omega_max` of the ring's modes. On random machines, averaged over nine starts, the error of a rub
/// is a quarter of the reduced engine's at its default step (`core/tests/exponential/exponential_random.rs`). No whip of 1260 runs of a
/// turbine violates a guard.
pub(super) const CONTACT_FRACTION: f64 = 0.9;
/// Default contact step of `hyp2-frozen` as a fraction of `2/omega_max`. The nearest point is found before the impulses are known. Penetration next
/// to that point falls with the step. At this fraction the penetration equals that of the reduced engine at its default step.
const FROZEN_CONTACT_FRACTION: f64 = 0.5;
/// Default contact step on a radial spring or a rigid ring, as a fraction of `2/omega_max` of the rotor held by it.
const SPRING_CONTACT_FRACTION: f64 = 0.25;
/// Minimum number of default contact steps per period with a ring; the period is that of [`PARTS`]. A step of free motion of 16 contact
/// steps is then an eighth of a radian. Without a ring the number is [`PARTS`], as for the other engines, because torsion may peak between
/// two steps of free motion.
const CONTACT_PARTS: f64 = 800.0;
/// Minimum number of contact steps per period. A step of free motion of 16 contact steps is then half a radian; longer steps turn by less
/// (`MAX_TURN` of the engine).
const PARTS_LEAST: f64 = 200.0;

/// Whether the contact point is the one found under its own impulse. It is not for `hyp2-frozen`, nor for `hyp2` at one point: where no point is the
/// nearest under its own impulse, `hyp2` at one point takes the point of `hyp2-frozen`.
fn has_converged_place(contact: &Contact) -> bool {
    match contact.detection {
        Detection::Hyp1 => true,
        Detection::Hyp2 => contact.points == ContactPoints::Several,
        Detection::Hyp2Frozen => false,
    }
}

/// Smallest time step \[s\]. At this step a filter of 1 ms has ten million steps, and adding the step still changes the time.
pub const LEAST_STEP: f64 = 1e-10;
/// Maximum number of steps of a run: a week on one core at 60 us per step. It is below 2^53, so counts and times are exact.
const MOST_STEPS: f64 = 1e10;

/// Time step of a run that can be started, and its stability limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeStep {
    /// Time step \[s\].
    pub step: f64,
    /// Largest stable step `2/omega_max` \[s\].
    pub largest_step: f64,
    /// Highest frequency of the model \[rad/s\].
    pub highest_frequency: f64,
}

/// A run that cannot be started.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StartError {
    /// The step is beyond the stability limit of central differences.
    #[error(
        "the step {} is too large for the {engine} engine: largest allowed {} = 2/omega_max, highest frequency of the model {}",
        seconds(*.step), seconds(below(*.limit)), hertz(*.hz)
    )]
    StepTooLarge {
        /// Requested step \[s\].
        step: f64,
        /// Largest allowed step \[s\].
        limit: f64,
        /// Highest frequency \[Hz\].
        hz: f64,
        /// Name of the engine.
        engine: &'static str,
    },
    /// The run has more steps than allowed.
    #[error(
        "the run may take {} steps of {} up to run.end_time = {}: at most {} steps are computed, which ends at {}",
        format_digits(*.steps, "", 4), seconds(*.step), seconds(*.end_time), format_digits(*.most, "", 4),
        seconds(floor_to_digits(.most * .step, 4))
    )]
    TooManySteps {
        /// Number of steps up to `end_time`, or the step limit. The rotor may stop, or reach its end speed, earlier.
        steps: f64,
        /// Step \[s\].
        step: f64,
        /// `run.end_time` \[s\].
        end_time: f64,
        /// Maximum number of steps.
        most: f64,
    },
    /// The stable step of the model is below the smallest step.
    #[error(
        "the stable step of the model is below {}, the smallest that is computed: its highest frequency is {} (a very stiff or \
         very light part)",
        seconds(*.least), hertz(*.hz)
    )]
    StepTooSmall {
        /// Smallest step \[s\].
        least: f64,
        /// Highest frequency \[Hz\].
        hz: f64,
    },
    /// The rotor starts in contact with the diaphragm.
    #[error("the rotor starts inside diaphragm {diaphragm}: gap {} at t = 0", metres(*.gap))]
    StartsInContact {
        /// Name of the diaphragm.
        diaphragm: String,
        /// Gap at the start \[m\], negative for penetration.
        gap: f64,
    },
    /// The rotor starts outside the diaphragm.
    #[error(
        "the rotor starts outside diaphragm {diaphragm}: its centre is {} from the ring's at t = 0, the ring's radius is {}; \
         contact.offset is ({}, {}): is its unit right?",
        metres(*.eccentricity), metres(*.radius), metres(.offset[0]), metres(.offset[1])
    )]
    StartsOutside {
        /// Name of the diaphragm.
        diaphragm: String,
        /// Distance between the centres of rotor and ring \[m\].
        eccentricity: f64,
        /// Radius of the ring's contact line \[m\].
        radius: f64,
        /// Offset of the ring's centre \[m\].
        offset: [f64; 2],
    },
    /// The contact step is larger than contact and spin can be computed with.
    #[error(
        "the contact step {} is too large; largest allowed {}. Bounds: 2/omega_max of the ring's modes (of the rotor \
         in a radial spring or a rigid ring), 1/{PARTS_LEAST} of a revolution, and 1/{PARTS_LEAST} of the lowest \
         mode's period",
        seconds(*.step), seconds(below(*.limit))
    )]
    ContactStepTooLarge {
        /// Requested contact step \[s\].
        step: f64,
        /// Largest allowed contact step \[s\].
        limit: f64,
    },
    /// The exponential engine does not cover a feature of the machine.
    #[error("the exponential engine does not cover {what}: use run.engine = \"reduced\"")]
    NotCovered {
        /// Name of the feature.
        what: &'static str,
    },
    /// The whirl modes at a speed have no usable basis.
    #[error(
        "the whirl modes at {speed} rad/s have no basis that the exponential engine can use (condition \
         {condition:.1e}, at most {limit:.0e}). Two motions are nearly identical: by cross stiffness on one side, or \
         by very strong bearing damping. Use run.engine = \"reduced\""
    )]
    NoBasis {
        /// Speed \[rad/s\].
        speed: f64,
        /// Condition number in the 2-norm; infinite if the modes do not span the state space.
        condition: f64,
        /// Largest allowed condition number.
        limit: f64,
    },
    /// The exponential engine displaces a ring under a constant force otherwise than its stiffness does.
    #[error(
        "a constant force displaces the ring of diaphragm {diaphragm} by {found:.6e} m/N in contact steps, and by {expected:.6e} m/N by its \
         stiffness: an internal error, please report it with the machine"
    )]
    StaticCompliance {
        /// Name of the diaphragm.
        diaphragm: String,
        /// Radial displacement per force in contact steps \[m/N\].
        found: f64,
        /// Radial displacement per force by the stiffness of ring and blades \[m/N\].
        expected: f64,
    },
    /// A mass or stiffness matrix is singular in some direction.
    #[error("the {what} matrix of {part} is singular: the rotor has no {what} in some direction")]
    Singular {
        /// "mass" or "stiffness".
        what: &'static str,
        /// Name of the part.
        part: &'static str,
    },
    /// The eigenvalue problem of the stability limit failed.
    #[error(transparent)]
    Eigen(#[from] EigenError),
}

fn metres(value: f64) -> String {
    format_quantity(value, "m")
}

fn seconds(value: f64) -> String {
    format_quantity(value, "s")
}

fn hertz(value: f64) -> String {
    format_digits(value, "Hz", 4)
}

impl TimeStep {
    /// Largest allowed step, rounded down to five digits \[s\].
    #[must_use]
    pub fn largest_allowed(&self) -> f64 {
        below(self.largest_step)
    }

    /// Chooses or checks the step of a run.
    ///
    /// # Errors
    /// [`StartError::StepTooLarge`], [`StartError::StepTooSmall`], [`StartError::TooManySteps`], [`StartError::Eigen`].
    pub fn new(machine: &Machine, structure: &Structure) -> Result<Self, StartError> {
        if machine.run.engine == Engine::Exponential {
            return Self::of_contact(machine, structure);
        }
        let lateral = rotor_limit(machine, structure)?;
        let rings = structure.rings.iter().flatten().map(|ring| ring.part.highest);
        let highest_frequency = rings.fold(lateral.max(structure.torsion.highest), f64::max);
        let largest_step = 2.0 / highest_frequency;
        let step = match machine.run.step {
            None => {
                let parts = if has_spring(machine) { SPRING_PARTS } else { PARTS };
                let resolved = 2.0 * std::f64::consts::PI / (parts * slowest_to_resolve(machine, structure));
                floor_to_digits((DEFAULT_FRACTION * largest_step).min(resolved), 2).min(machine.run.end_time)
            }
            // equality is marginally stable, so it is rejected too
            Some(step) if step < largest_step => step,
            Some(step) => {
                return Err(StartError::StepTooLarge {
                    step,
                    limit: largest_step,
                    hz: highest_frequency / (2.0 * std::f64::consts::PI),
                    engine: machine.run.engine.word(),
                });
            }
        };
        Self { step, largest_step, highest_frequency }.allowed(machine)
    }

    /// Contact step of the exponential engine. It depends on the frequencies of the ring alone; with a radial spring or a rigid
    /// ring, on those of the rotor.
    fn of_contact(machine: &Machine, structure: &Structure) -> Result<Self, StartError> {
        let rings = structure.rings.iter().flatten().map(|ring| ring.part.highest);
        let held = if has_rigid(machine) || has_spring(machine) { rotor_limit(machine, structure)? } else { 0.0 };
        let highest_frequency = rings.fold(held, f64::max);
        let period = 2.0 * std::f64::consts::PI / slowest_to_resolve(machine, structure);
        let largest_step = (2.0 / highest_frequency).min(period / PARTS_LEAST);
        let step = match machine.run.contact_step {
            None => {
                let is_frozen = machine.diaphragms.iter().any(|ring| !has_converged_place(&ring.contact));
                let (fraction, parts) = match () {
                    () if machine.diaphragms.is_empty() => (CONTACT_FRACTION, PARTS),
                    () if has_rigid(machine) || has_spring(machine) => (SPRING_CONTACT_FRACTION, SPRING_PARTS),
                    () if is_frozen => (FROZEN_CONTACT_FRACTION, CONTACT_PARTS),
                    () => (CONTACT_FRACTION, CONTACT_PARTS),
                };
                let chosen = (fraction * 2.0 / highest_frequency).min(period / parts);
                floor_to_digits(chosen, 2).min(machine.run.end_time)
            }
            Some(step) if step < largest_step => step,
            Some(step) => return Err(StartError::ContactStepTooLarge { step, limit: largest_step }),
        };
        Self { step, largest_step, highest_frequency }.allowed(machine)
    }

    /// This step times `ratio`, at least `least` \[s\], rounded down to two digits; `None` if that is not finer.
    pub(super) fn finer(self, ratio: f64, least: f64) -> Option<Self> {
        let step = floor_to_digits((ratio * self.step).max(least), 2);
        (step < self.step).then_some(Self { step, ..self })
    }

    /// Rejects a step that is too small and a run that has too many steps.
    pub(super) fn allowed(self, machine: &Machine) -> Result<Self, StartError> {
        let Self { step, highest_frequency, .. } = self;
        // this form of the comparison rejects NaN
        if !(step >= LEAST_STEP.min(machine.run.end_time) && highest_frequency.is_finite()) {
            let hz = highest_frequency / (2.0 * std::f64::consts::PI);
            return Err(StartError::StepTooSmall { least: LEAST_STEP, hz });
        }
        let steps = machine.run.end_time / step;
        let steps = machine.run.step_limit.map_or(steps, |limit| steps.min(limit as f64));
        if steps > MOST_STEPS {
            return Err(StartError::TooManySteps { steps, step, end_time: machine.run.end_time, most: MOST_STEPS });
        }
        Ok(self)
    }
}

/// Whether any diaphragm is a rigid ring.
fn has_rigid(machine: &Machine) -> bool {
    machine.diaphragms.iter().any(|diaphragm| matches!(diaphragm.kind, DiaphragmKind::Rigid))
}

/// Whether any diaphragm is a radial spring.
fn has_spring(machine: &Machine) -> bool {
    machine.diaphragms.iter().any(|diaphragm| matches!(diaphragm.kind, DiaphragmKind::RadialSpring { .. }))
}

/// The larger of the highest spin speed and the lowest lateral frequency \[rad/s\].
pub(super) fn slowest_to_resolve(machine: &Machine, structure: &Structure) -> f64 {
    let law = machine.rotor.speed_law.iter().flat_map(|law| law.speeds.iter().copied());
    let speed = law.fold(machine.rotor.initial_speed, f64::max);
    let part = &structure.lateral;
    // Rayleigh quotients of the coordinates bound the lowest frequency from above, which is enough for a resolution
    let mut lowest = (0..part.coordinates.size())
        .map(|i| part.stiffness[(i, i)] / part.mass[(i, i)])
        .filter(|square| square.is_finite())
        .fold(f64::INFINITY, f64::min);
    if let RotorKind::PointMass(point) = &machine.rotor.kind {
        // with all its mass in unbalances, the point swings with their total mass
        let unbalances = || machine.rotor.unbalances.iter().map(|u| u.mass).sum::<f64>();
        let mass = if point.mass > 0.0 { point.mass } else { unbalances() };
        // the softer principal axis, for any orientation of the axes
        lowest = principal(&part.stiffness)[0] / mass;
    }
    let lowest = if lowest.is_finite() { lowest.max(0.0).sqrt() } else { 0.0 };
    speed.max(lowest).max(f64::MIN_POSITIVE)
}

/// Smallest and largest principal stiffness of a point mass \[N/m\].
fn principal(k: &Matrix) -> [f64; 2] {
    let (mean, half) = (0.5 * (k[(0, 0)] + k[(1, 1)]), 0.5 * (k[(0, 0)] - k[(1, 1)]));
    let radius = libm::hypot(half, k[(0, 1)]);
    [mean - radius, mean + radius]
}

/// Highest frequency of the rotor's lateral motion, and of its torsion where the two are coupled \[rad/s\].
///
/// Added masses only lower the frequencies of the structure, which is then an upper bound. The run's own matrices are needed for a lost mass, a
/// radial spring at the contact, and a point mass (which may have all its mass in an unbalance). An unbalance couples torsion and deflection by
/// `m d psi''` across its arm:
/// - A lost mass leaves less inertia in the coupled motion than in torsion or deflection alone.
/// - A point mass has only the inertia `m J/(J + m d^2)` of an added mass across the arm, unless its speed is prescribed.
/// - The unbalance of a point mass turns its arm across the stiffer principal axis at some time.
fn rotor_limit(machine: &Machine, structure: &Structure) -> Result<f64, StartError> {
    let lost = machine.rotor.unbalances.iter().any(|u| u.kind == UnbalanceKind::Lost);
    let point = matches!(machine.rotor.kind, RotorKind::PointMass(_));
    let springs: Vec<(usize, f64)> = machine
        .diaphragms
        .iter()
        .filter_map(|d| match d.kind {
            DiaphragmKind::RadialSpring { stiffness } => Some((d.contact.node, stiffness)),
            _ => None,
        })
        .collect();
    let turns = lost || point && machine.rotor.speed_law.is_none();
    if !(lost || point || !springs.is_empty()) {
        return Ok(structure.lateral.highest);
    }
    let (lateral, torsion) = (&structure.lateral, &structure.torsion);
    let size = lateral.coordinates.size();
    let all = size + if turns { torsion.coordinates.size() } else { 0 };
    let (mut mass, mut stiffness) = (Matrix::zeros(all, all), Matrix::zeros(all, all));
    mass.view_mut((0, 0), (size, size)).copy_from(&lateral.mass);
    stiffness.view_mut((0, 0), (size, size)).copy_from(&lateral.stiffness);
    if point {
        // the first two degrees of freedom are those of the mass point; the following ones belong to pedestals
        stiffness.view_mut((0, 0), (2, 2)).copy_from(&(Matrix::identity(2, 2) * principal(&lateral.stiffness)[1]));
    }
    if turns {
        mass.view_mut((size, size), (all - size, all - size)).copy_from(&torsion.mass);
        stiffness.view_mut((size, size), (all - size, all - size)).copy_from(&torsion.stiffness);
    }
    // an added mass with a later release is absent before it
    let is_there = |one: &&Unbalance| one.release.is_none() || one.kind == UnbalanceKind::Lost;
    for site in machine.rotor.unbalances.iter().filter(is_there).map(UnbalanceSite::new) {
        let (sin, cos) = libm::sincos(site.phase);
        let arm = [-site.radius * sin, site.radius * cos];
        for (dof, arm) in structure.rotor.plane_places(site.node).into_iter().zip(arm) {
            let mut row = lateral.coordinates.row(dof);
            if turns {
                row.extend(torsion.coordinates.row(site.torsional_node).iter().map(|psi| arm * psi));
            }
            add_outer(&mut mass, site.mass, &row);
        }
    }
    for (node, spring) in springs {
        for dof in structure.rotor.plane_places(node) {
            let mut row = lateral.coordinates.row(dof);
            row.resize(all, 0.0);
            add_outer(&mut stiffness, spring, &row);
        }
    }
    let (values, _) = symmetric_generalised(&stiffness, &mass, "the rotor with its unbalances")?;
    Ok(values.last().map_or(0.0, |square| square.max(0.0).sqrt()))
}

/// Largest step of five digits that is allowed: strictly below the stability limit, which itself is rejected.
fn below(limit: f64) -> f64 {
    let floor = floor_to_digits(limit, 5);
    if floor < limit { floor } else { floor_to_digits(limit * (1.0 - 1e-6), 5) }
}

/// Largest number with `digits` decimal digits that does not exceed `value`. For a step, the rounding keeps the last digits of the eigenvalue solver
/// out of the results. For a limit, the rounded value is allowed.
fn floor_to_digits(value: f64, digits: i32) -> f64 {
    let exponent = libm::floor(libm::log10(value));
    let unit = libm::pow(10.0, exponent - f64::from(digits - 1));
    let whole = libm::floor(value / unit);
    // parsing decimal text gives the f64 nearest to the decimal number
    format!("{whole:.0}e{}", (exponent as i32).saturating_sub(digits - 1)).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::float_cmp, reason = "the point is the exact decimal")]
    fn the_default_step_is_a_short_decimal_below_its_bound() {
        assert_eq!(floor_to_digits(4.789e-5, 2), 4.7e-5);
        assert_eq!(floor_to_digits(3.5e-6, 2), 3.5e-6);
        assert_eq!(floor_to_digits(0.9, 2), 0.9);
        assert_eq!(floor_to_digits(6.951_987_654e-6, 5), 6.9519e-6);
        assert_eq!(below(6.951_987_654e-6), 6.9519e-6);
        // equality is rejected
        assert_eq!((below(2.0), below(1e-5)), (1.9999, 9.9999e-6));
    }

    #[test]
    fn refusals_have_units_a_person_would_choose_and_a_limit_that_is_allowed() {
        let (step, limit, hz) = (1.0, 6.951_987_654e-6, 45_787.123);
        let refused = StartError::StepTooLarge { step, limit, hz, engine: "reduced" };
        assert_eq!(
            refused.to_string(),
            "the step 1 s is too large for the reduced engine: largest allowed 6.9519 us = 2/omega_max, highest frequency of the \
             model 45790 Hz"
        );
        let inside = StartError::StartsInContact { diaphragm: "seal".into(), gap: -5.000_000_000_000_004e-4 };
        assert_eq!(inside.to_string(), "the rotor starts inside diaphragm seal: gap -0.5 mm at t = 0");
        let many = StartError::TooManySteps { steps: 1e300, step: 1e-9, end_time: 1e15, most: MOST_STEPS };
        assert_eq!(
            many.to_string(),
            "the run may take 1e300 steps of 0.001 us up to run.end_time = 1e15 s: at most 1e10 steps are computed, which ends \
             at 10 s"
        );
    }
}
