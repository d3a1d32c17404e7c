//! One diaphragm during a run: motion of the ring and its contact with the rotor.
//!
//! A step consists of [`Rub::prepare`], [`Rub::correct`] for the prediction without contact, and [`Rub::advance`]. The two [`bodies`] in contact are
//! the rotor's [`section`] and the [`stator`]. Contact forces are found as [`multipliers`], or are those of a [`spring`].

mod axes;
mod bodies;
mod left_out;
mod multipliers;
mod one_point;
mod ring;
mod rounds;
mod section;
mod several;
mod spring;
mod stator;
mod step_contact;

pub(super) use step_contact::StepContact;

use axes::Axes;
use bodies::Bodies;
use left_out::LeftOut;
use multipliers::Multipliers;
use rounds::Work;
use section::Section;
use spring::Spring;
use stator::Stator;
use step_contact::ContactFailure;

use super::shaft_line::{Increments, OtherForces, ShaftLine};
use crate::contact::Gap;
use crate::record::RingState;
use crate::stator::NodalForces;
use crate::structure::{RingPart, Structure};
use bladeoff_model::machine::{Diaphragm, DiaphragmKind, ForceLocation};

/// Contact and motion of one diaphragm.
pub(super) struct Rub<'a> {
    /// Axes of the diaphragm.
    axes: Axes,
    /// Rotor section, stator and truncated modes.
    bodies: Bodies<'a>,
    /// Method for the contact force.
    forces: Forces,
    /// Scratch and counter of the iteration.
    work: Work,
}

/// Method for the contact force of a step.
enum Forces {
    /// Lagrange multipliers that close the gap at n+1.
    Multipliers(Multipliers),
    /// Force of a massless radial spring.
    Spring(Spring),
}

impl<'a> Rub<'a> {
    /// Diaphragm with its ring at rest; `None` if the operator of the ring is singular.
    pub fn new(
        diaphragm: &Diaphragm,
        structure: &'a Structure,
        ring: Option<&'a RingPart>,
        line: &ShaftLine<'_>,
        location: ForceLocation,
    ) -> Option<Self> {
        let contact = &diaphragm.contact;
        let axes = Axes::new(diaphragm);
        let bodies = Bodies {
            section: Section::new(line, contact.node, contact.rotor_radius, &axes),
            stator: Stator::new(diaphragm, ring, line.dt)?,
            left_out: LeftOut::new(structure, contact.node, &axes, ring, line.dt),
            friction: contact.friction,
            law: contact.friction_law,
        };
        let forces = match diaphragm.kind {
            DiaphragmKind::RadialSpring { stiffness } => Forces::Spring(Spring { stiffness, gap: contact.gap }),
            DiaphragmKind::Rigid | DiaphragmKind::Flexible(_) => {
                Forces::Multipliers(Multipliers::new(contact, location))
            }
        };
        let free = Increments::zeros(line.lateral.size(), line.torsion.size());
        Some(Self { axes, bodies, forces, work: Work { free, iterations: 0 } })
    }

    /// Begins the step with the ring's motion without contact.
    pub fn prepare(&mut self) {
        self.bodies.left_out.prepare();
        if let Some(ring) = &mut self.bodies.stator.ring {
            ring.prepare();
        }
    }

    /// Returns to the beginning of the step, with the matrices of another shaft line.
    pub fn begin_again(&mut self, line: &ShaftLine<'_>) {
        self.bodies.left_out.begin_again();
        let Section { node, radius, .. } = self.bodies.section;
        self.bodies.section = Section::new(line, node, radius, &self.axes);
    }

    /// Corrects the predicted increments `d` for contact (input: without contact, output: with contact); `None` without a contact
    /// force. `time` is the time at n.
    ///
    /// [`ShaftLine::settle`] must follow with the result.
    pub fn correct(
        &mut self,
        line: &mut ShaftLine<'_>,
        time: f64,
        d: &mut Increments,
    ) -> Result<Option<StepContact>, ContactFailure> {
        let start = (time, self.place(line));
        match &mut self.forces {
            Forces::Multipliers(multipliers) => multipliers.correct(&mut self.bodies, line, start, d, &mut self.work),
            Forces::Spring(spring) => spring.correct(&mut self.bodies, line, start, d, &mut self.work),
        }
    }

    /// Adds the response to the contact forces of a step to `sum`.
    pub fn respond(&self, contact: &StepContact, sum: &mut OtherForces) {
        let (section, tangential) = (&self.bodies.section, contact.force.tangential);
        section.push(contact.on_rotor, tangential, &mut sum.increments);
        sum.drive_torque += section.drive_torque(tangential) * section.radius;
    }

    /// Whether the forces on the rotor of two solutions of a step differ by more than the convergence tolerance.
    pub fn differs(&self, one: Option<&StepContact>, other: Option<&StepContact>) -> bool {
        let force = |contact: Option<&StepContact>| contact.map_or([0.0; 2], |contact| contact.on_rotor);
        let ([x, y], [u, v]) = (force(one), force(other));
        let (change, size) = (libm::hypot(u - x, v - y), libm::hypot(u, v));
        let radius = self.bodies.section.radius.max(self.bodies.stator.gap);
        let scale = self.bodies.scale();
        change * scale > 1e-14 * radius + 1e-11 * size * scale + self.bodies.rounding_of_force() * scale
    }

    /// Accepts the ring's increment.
    pub fn advance(&mut self) {
        if let Some(ring) = &mut self.bodies.stator.ring {
            ring.advance();
        }
    }

    /// Node of the rotor in contact.
    pub fn node(&self) -> usize {
        self.bodies.section.node
    }

    /// Rotor centre at n in the stator's frame \[m\].
    pub fn place(&self, line: &ShaftLine<'_>) -> [f64; 2] {
        self.axes.place(line.place(self.node()))
    }

    /// Rotor centre at n \[m\] and its centred velocity \[m/s\] in the stator's frame, after [`ShaftLine::settle`].
    pub fn motion(&self, line: &ShaftLine<'_>) -> ([f64; 2], [f64; 2]) {
        let (place, velocity) = line.node(self.node());
        (self.axes.place(place), self.axes.direction(velocity))
    }

    /// Rotates a force from the stator's frame to the machine's axes.
    pub fn outwards(&self, force: [f64; 2]) -> [f64; 2] {
        self.axes.outwards(force)
    }

    /// Whether the stator is a massless spring, which may start loaded.
    pub fn is_spring(&self) -> bool {
        matches!(self.forces, Forces::Spring(_))
    }

    /// Gap at n in the run's own gap function, as the contact of the previous step left it. The contact force of that step is the
    /// one that closes this gap.
    pub fn gap_at_n(&mut self, line: &ShaftLine<'_>) -> Gap {
        let place = self.place(line);
        self.bodies.gap_at_n(place)
    }

    /// Whether the rotor's centre at n is outside the ring's contact line. A radial spring yields without limit, and its contact line with it.
    pub fn is_outside(&mut self, line: &ShaftLine<'_>) -> bool {
        let place = self.place(line);
        !self.is_spring() && self.bodies.stator.is_outside(place, &self.bodies.left_out)
    }

    /// Adds the contact forces of the step to their mean. Called once per step.
    pub fn average_forces(&mut self) {
        self.bodies.left_out.average_forces();
    }

    /// Coordinates of the ring at n with the mean contact forces, as soon as the ring moves or a force acts.
    pub fn ring_state(&self) -> Option<RingState<'_>> {
        const NONE: &NodalForces = &NodalForces::none();
        let forces = self.bodies.left_out.mean_forces().unwrap_or(NONE);
        let ring = self.bodies.stator.ring.as_ref().filter(|ring| ring.moving || !forces.is_empty())?;
        Some(RingState { coordinates: &ring.stepper.q, forces })
    }

    /// Nodal degrees of freedom of the ring at n, after [`Rub::gap_at_n`].
    pub fn ring_field(&self) -> Option<&[f64]> {
        self.bodies.stator.field()
    }

    /// Radial and tangential displacement of the ring at the place of a gap \[m\], after [`Rub::gap_at_n`].
    pub fn ring_displacement(&self, gap: &Gap) -> [f64; 2] {
        self.bodies.stator.displacement(&gap.place)
    }

    /// Kinetic and strain energy of the ring between n and n+1 \[J\].
    pub fn ring_energies(&self) -> (f64, f64) {
        let ring = self.bodies.stator.ring.as_ref();
        ring.map_or((0.0, 0.0), |ring| (ring.stepper.kinetic_energy(&ring.d), ring.stepper.strain_energy(&ring.d)))
    }

    /// Energy dissipated by the ring's damping over the step at n \[J\].
    pub fn ring_damping_work(&mut self) -> f64 {
        let ring = self.bodies.stator.ring.as_mut().filter(|ring| ring.moving);
        ring.map_or(0.0, |ring| ring.stepper.damping_work(&ring.d))
    }

    /// Potential energy of a radial spring between n and n+1 \[J\], after [`ShaftLine::settle`].
    pub fn spring_energy(&self, line: &ShaftLine<'_>) -> f64 {
        let Forces::Spring(spring) = &self.forces else { return 0.0 };
        let (x, dx) = (line.place(self.node()), line.rotor.at(self.node(), &line.lateral.d));
        spring.energy(self.axes.place(x), self.axes.place([x[0] + dx[0], x[1] + dx[1]]))
    }

    /// Strain energy in the static flexibility of the truncated modes, at this step and the previous one \[J\].
    pub fn held(&self) -> [f64; 2] {
        [self.bodies.left_out.held, self.bodies.left_out.held_before]
    }

    /// Number of rounds of all steps.
    pub fn iterations(&self) -> u64 {
        self.work.iterations
    }

    /// Resets the number of rounds.
    pub fn forget_iterations(&mut self) {
        self.work.iterations = 0;
    }
}
