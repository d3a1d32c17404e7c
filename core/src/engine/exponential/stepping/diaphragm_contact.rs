//! Contact of the rotor with all diaphragms in one contact step: their impulses are found together, coupled through the shaft.
//!
//! ```text
//! x_i(n+1) = x_i(free) + sum_j D_ij J_j + S_ij (2 J_j - J_j(n-1))         at a flexible ring                                  (1)
//! x_i(n)   = x_i(modes) + sum_j S_ij J_j                                  at a radial spring                                  (2)
//! turn_i   = turn_i(free) + sum_j T_ij tau_j                              of the rotor's section over the step                (3)
//! J_i      = contact(x_i, turn_i under all J_j, j != i)                   for each i in turn, until no impulse changes        (4)
//! v_i      = v_i(n) + (jumps by all impulses)/2                           works of the impulses: mean of both sides of them
//! ```
//! x: displacement of the rotor; J, tau: impulse and angular impulse on the rotor at n; D, T: response over the step; S: static
//! correction with the flexibility of the truncated modes. Own impulses (j = i) belong to the solver of the diaphragm.
//!
//! All diaphragms have one contact step. A diaphragm that nothing touches adds no impulse, so it changes no digit of the others. A
//! ring at rest that the rotor does not reach costs one comparison in a contact step.
//!
//! Whether a point of a ring joins depends on its penetration, so the impulses of a ring jump with those at another diaphragm. Rounds
//! around such a jump would alternate. From [`SETTLING_ROUNDS`] on a ring therefore keeps all points of the rounds before.
//!
//! Source: block Gauss-Seidel iteration on the Delassus operator of all diaphragms, as in `engine::together`. The rounds contract by
//! the coupling of two seats over a step, `D_ij D_ji/(D_ii D_jj)`. Limits: rounds whose direction of slip alternates end the run
//! after [`MAX_ROUNDS`]. Verified by `tests/exponential/several_diaphragms.rs`.

use super::free_motion::FreeMotion;
use super::shared_model::ring_points_of;
use crate::engine::exponential::ExponentialError;
use crate::engine::exponential::contact::contact_step::ContactStep;
use crate::engine::exponential::contact::contact_step_result::{ContactStepResult, FreeStep};
use crate::engine::exponential::contact::radial_spring::RadialSpring;
use crate::engine::exponential::contact::stator::{Stator, StatorContact};
use crate::engine::exponential::contact::stator_axes::StatorAxes;
use crate::engine::exponential::modal::impulse_response::Coupling;
use crate::engine::exponential::plane::{length, times};
use crate::engine::exponential::torsion::spin::ContactImpulse;
use crate::engine::time_step::StartError;
use crate::structure::Structure;
use bladeoff_model::machine::{Diaphragm, DiaphragmKind, Machine};

/// Largest number of rounds over all diaphragms.
const MAX_ROUNDS: usize = 100;
/// Change of an impulse between two rounds that is negligible, relative to the largest impulse of the step.
const MAX_CHANGE: f64 = 1e-9;
/// Rounds after which [`MAX_LATE_CHANGE`] is negligible, and rings keep their points: close points of a ring may exchange impulses in every round.
const SETTLING_ROUNDS: usize = 30;
const MAX_LATE_CHANGE: f64 = 1e-6;

/// Contact with one diaphragm.
pub(crate) struct DiaphragmContact {
    /// Index of the diaphragm, in the machine's order.
    index: usize,
    /// Stator, and the solver of its contact steps.
    pub stator: StatorContact,
    /// Turn of the rotor's section here over a contact step, per angular impulse on that at each diaphragm \[rad/(N m s)\].
    rolling: Vec<f64>,
    /// Jump of this section's rate of turn per angular impulse at each diaphragm \[1/(kg m2)\].
    jumps: Vec<f64>,
    /// Displacement of the rotor's truncated modes here per impulse at each diaphragm \[m/(N s)\].
    truncated: Vec<[[f64; 2]; 2]>,
    /// Displacement of the rotor from the stator's centre in the machine's axes, and clearance of the stator, where they were updated
    /// last \[m\].
    pub clearance: ([f64; 2], f64),
    /// Displacement \[m\] and velocity \[m/s\] of the rotor here at the beginning of the last step, in the machine's axes.
    pub displacement: [f64; 2],
    pub velocity: [f64; 2],
    /// Rotation of the section then beside the mean angle \[rad\], and its rate of turn \[rad/s\].
    rotation: f64,
    rate: f64,
    /// Impulses and works of the last step; `None` without contact.
    pub impact: Option<ContactStepResult>,
    /// Impulse of the step before that one; impulse that was found last in the present step, and whether to look for it again.
    before: Option<ContactImpulse>,
    found: Option<ContactImpulse>,
    is_due: bool,
}

impl DiaphragmContact {
    /// Creates the contacts with all diaphragms of a machine at t = 0, in contact steps of `h` \[s\].
    ///
    /// # Errors
    /// [`ExponentialError`] for a diaphragm that is not covered, or a rotor that starts in contact.
    pub fn all(
        machine: &Machine,
        structure: &Structure,
        free_motion: &FreeMotion,
        h: f64,
    ) -> Result<Vec<Self>, ExponentialError> {
        let spin = free_motion.spin();
        let step = spin.step(h);
        let nodes: Vec<usize> = machine.diaphragms.iter().map(|diaphragm| diaphragm.contact.node).collect();
        let rows: Vec<Vec<f64>> = nodes.iter().map(|&node| spin.rotation_row(structure, node)).collect();
        let create = |(index, diaphragm): (usize, &Diaphragm)| {
            starts_inside(diaphragm, free_motion.contact_displacement(index))?;
            Ok(Self {
                index,
                rolling: (0..nodes.len()).map(|acting| spin.contact_turn_compliance(&step, index, acting)).collect(),
                jumps: rows.iter().map(|acting| spin.rate_jump(&rows[index], acting)).collect(),
                truncated: nodes.iter().map(|&acting| truncated(structure, [nodes[index], acting], h)).collect(),
                stator: stator_of(machine, index, structure, free_motion, h),
                clearance: ([0.0; 2], 0.0),
                displacement: [0.0; 2],
                velocity: [0.0; 2],
                rotation: 0.0,
                rate: 0.0,
                impact: None,
                before: None,
                found: None,
                is_due: false,
            })
        };
        machine.diaphragms.iter().enumerate().map(create).collect()
    }

    /// Follows a change of the rotor's masses.
    pub fn follow(&mut self, machine: &Machine, structure: &Structure, free_motion: &FreeMotion, h: f64) {
        let spin = free_motion.spin();
        let step = spin.step(h);
        let nodes = machine.diaphragms.iter().map(|diaphragm| diaphragm.contact.node);
        let rows: Vec<Vec<f64>> = nodes.map(|node| spin.rotation_row(structure, node)).collect();
        self.rolling = (0..rows.len()).map(|acting| spin.contact_turn_compliance(&step, self.index, acting)).collect();
        self.jumps = rows.iter().map(|acting| spin.rate_jump(&rows[self.index], acting)).collect();
    }

    /// Index of the diaphragm, in the machine's order.
    pub fn index(&self) -> usize {
        self.index
    }

    /// Updates the displacement of the rotor from the stator's centre to n, and returns it \[m\].
    pub fn update_displacement(&mut self, free_motion: &FreeMotion) -> [f64; 2] {
        self.clearance.0 = self.stator.axes.displacement_from_centre(free_motion.contact_displacement(self.index));
        self.clearance.0
    }

    /// Updates the clearance to n. Returns whether the rotor is within it.
    pub fn is_within_clearance(&mut self) -> bool {
        self.clearance.1 = self.stator.clearance();
        length(self.clearance.0) < self.clearance.1
    }

    /// Place of the rotor in the stator's axes at n \[m\], with the static correction of the last impulses at the other diaphragms.
    pub fn place(&self, free_motion: &FreeMotion, impulses: &[ContactImpulse]) -> [f64; 2] {
        let mut place = free_motion.contact_displacement(self.index);
        for contact in impulses.iter().filter(|contact| contact.diaphragm != self.index) {
            let coupling = self.coupling(contact.diaphragm, free_motion);
            add(self.settled(coupling, contact.diaphragm, contact.impulse), &mut place);
        }
        self.stator.axes.place(place)
    }

    /// Begins a step at n.
    #[inline(always)]
    pub fn begin_step(&mut self, free_motion: &FreeMotion) {
        [self.displacement, self.velocity] = free_motion.contact_motion(self.index);
        let [rotation, rate] = free_motion.spin().contact_rotation(self.index);
        (self.rotation, self.rate) = (rotation, free_motion.spin().speed + rate);
        self.before = self.impact.take().map(|impact| impact.contact);
    }

    /// Contact step without contact at any diaphragm, after [`FreeMotion::propagate`].
    #[inline(always)]
    fn free_step<'a>(&self, free_motion: &'a FreeMotion) -> FreeStep<'a> {
        FreeStep {
            diaphragm: self.index,
            start: self.displacement,
            end: free_motion.contact_displacement(self.index),
            velocity: self.velocity,
            response: free_motion.impulse_response(self.index),
            surface_turn: free_motion.spin().contact_turn(self.index, self.rotation),
            rolling: self.rolling[self.index],
            rate: self.rate,
            jump: self.jumps[self.index],
            other_velocity: [0.0; 2],
            other_rate: 0.0,
            spin: free_motion.spin(),
        }
    }

    /// Contact step under the impulses at the other diaphragms that were found last, by (1) to (3), and those of the step before.
    fn free_step_under<'a>(&self, contacts: &[Self], free_motion: &'a FreeMotion) -> FreeStep<'a> {
        let [start, end] = self.ends_under(contacts, free_motion);
        let mut free = FreeStep {
            start,
            end,
            surface_turn: self.turn_under(contacts, free_motion),
            ..self.free_step(free_motion)
        };
        for contact in self.others(contacts).filter_map(|other| other.found) {
            let of_unbalances = free_motion.spin().contact_velocity_jump(contact, &free.response.at_unbalances);
            let jump = times(&self.coupling(contact.diaphragm, free_motion).velocity_jump, contact.impulse);
            add([0, 1].map(|i| 0.5 * (jump[i] + of_unbalances[i])), &mut free.other_velocity);
            free.other_rate += 0.5 * (self.jumps[contact.diaphragm] * contact.torque + contact.speed_jump);
        }
        free
    }

    /// Displacements of the rotor here at n and n+1 \[m\], by (1) or (2).
    #[inline(always)]
    fn ends_under(&self, contacts: &[Self], free_motion: &FreeMotion) -> [[f64; 2]; 2] {
        let [mut start, mut end] = self.free_ends(free_motion);
        let is_ring = matches!(self.stator.stator, Stator::Ring(_));
        for other in contacts.iter().filter(|other| other.found.is_some() || other.before.is_some()) {
            if other.index == self.index {
                continue;
            }
            let of = |contact: Option<ContactImpulse>| contact.map_or([0.0; 2], |contact| contact.impulse);
            let (now, before) = (of(other.found), of(other.before));
            let coupling = self.coupling(other.index, free_motion);
            add(times(&coupling.displacement, now), &mut end);
            // a ring has the force extrapolated to n+1, a spring that of n
            let [at_start, at_end] =
                if is_ring { [before, [0, 1].map(|i| 2.0 * now[i] - before[i])] } else { [now, now] };
            add(self.settled(coupling, other.index, at_start), &mut start);
            add(self.settled(coupling, other.index, at_end), &mut end);
        }
        [start, end]
    }

    /// Displacements of the rotor here at n and n+1 without contact at any diaphragm \[m\].
    #[inline(always)]
    fn free_ends(&self, free_motion: &FreeMotion) -> [[f64; 2]; 2] {
        [self.displacement, free_motion.contact_displacement(self.index)]
    }

    /// Whether nothing can touch here in the step, for these displacements of the rotor at n and n+1 \[m\].
    #[inline(always)]
    fn is_clear(&self, [start, end]: [[f64; 2]; 2]) -> bool {
        self.stator.is_clear([start, end, self.velocity])
    }

    /// Turn of the rotor's section here over the step, by (3) \[rad\].
    #[inline(always)]
    fn turn_under(&self, contacts: &[Self], free_motion: &FreeMotion) -> f64 {
        let found = self.others(contacts).filter_map(|other| other.found);
        let turn = free_motion.spin().contact_turn(self.index, self.rotation);
        found.fold(turn, |turn, contact| turn + self.rolling[contact.diaphragm] * contact.torque)
    }

    /// Contacts with all other diaphragms.
    fn others<'a>(&self, contacts: &'a [Self]) -> impl Iterator<Item = &'a Self> {
        let own = self.index;
        contacts.iter().filter(move |other| other.index != own)
    }

    /// Response here to impulses on the node of another diaphragm.
    #[inline(always)]
    fn coupling<'a>(&self, acting: usize, free_motion: &'a FreeMotion) -> &'a Coupling {
        &free_motion.impulse_response(acting).at_diaphragms[self.index]
    }

    /// Static correction of the displacement here for an impulse at another diaphragm, S J \[m\].
    #[inline(always)]
    fn settled(&self, coupling: &Coupling, acting: usize, impulse: [f64; 2]) -> [f64; 2] {
        let mut settled = times(&coupling.static_correction, impulse);
        add(times(&self.truncated[acting], impulse), &mut settled);
        settled
    }
}

/// Takes all diaphragms over a contact step that has begun, after [`FreeMotion::propagate`].
///
/// # Errors
/// [`ExponentialError::NoImpulses`] where no impulses fulfil the conditions.
#[inline(always)]
pub(crate) fn solve(contacts: &mut [DiaphragmContact], free_motion: &FreeMotion) -> Result<(), ExponentialError> {
    match contacts {
        [contact] => {
            let free = contact.free_step(free_motion);
            contact.stator.solve(&free, &mut contact.impact)
        }
        _ => solve_several(contacts, free_motion),
    }
}

/// Takes several diaphragms over a contact step.
fn solve_several(contacts: &mut [DiaphragmContact], free_motion: &FreeMotion) -> Result<(), ExponentialError> {
    contacts.iter_mut().for_each(|contact| (contact.found, contact.is_due) = (contact.before, true));
    let reached = only_reached(contacts, free_motion);
    let free = reached.map(|at| contacts[at].free_step(free_motion));
    let mut is_alone = false;
    if let (Some(at), Some(free)) = (reached, &free) {
        contacts[at].found = contacts[at].stator.find(free, false)?;
        contacts[at].is_due = false;
        let is_clear = |other: &DiaphragmContact| other.is_clear(other.ends_under(contacts, free_motion));
        is_alone = contacts.iter().all(|other| other.index == at || is_clear(other));
    }
    if !is_alone {
        solve_together(contacts, free_motion)?;
    }
    for at in 0..contacts.len() {
        match &free {
            Some(free) if is_alone && reached == Some(at) => {
                contacts[at].impact = contacts[at].stator.finish_step(free);
            }
            _ if contacts[at].stator.is_searched() => {
                let free = contacts[at].free_step_under(contacts, free_motion);
                contacts[at].impact = contacts[at].stator.finish_step(&free);
            }
            _ => {
                let turn = contacts[at].turn_under(contacts, free_motion);
                contacts[at].stator.pass_step(turn);
            }
        }
    }
    Ok(())
}

/// Finds impulses that fulfil the conditions at all diaphragms together, by (4).
fn solve_together(contacts: &mut [DiaphragmContact], free_motion: &FreeMotion) -> Result<(), ExponentialError> {
    let mut rounds = 0;
    while contacts.iter().any(|contact| contact.is_due) {
        if rounds == MAX_ROUNDS {
            return Err(ExponentialError::NoImpulses);
        }
        rounds += 1;
        let is_late = rounds > SETTLING_ROUNDS;
        let max_change = if is_late { MAX_LATE_CHANGE } else { MAX_CHANGE };
        for at in 0..contacts.len() {
            if !std::mem::take(&mut contacts[at].is_due) {
                continue;
            }
            let found = if contacts[at].is_clear(contacts[at].ends_under(contacts, free_motion)) {
                None
            } else {
                let free = contacts[at].free_step_under(contacts, free_motion);
                contacts[at].stator.find(&free, is_late)?
            };
            let last = std::mem::replace(&mut contacts[at].found, found);
            if change(last, found, contacts) > max_change {
                contacts.iter_mut().for_each(|other| other.is_due |= other.index != at);
            }
        }
    }
    Ok(())
}

/// Index of the only diaphragm that the rotor may reach; `None` where it may reach several, or none.
fn only_reached(contacts: &[DiaphragmContact], free_motion: &FreeMotion) -> Option<usize> {
    let may_touch =
        |contact: &&DiaphragmContact| contact.before.is_some() || !contact.is_clear(contact.free_ends(free_motion));
    let mut reached = contacts.iter().filter(may_touch);
    let only = reached.next().filter(|_| reached.next().is_none())?;
    Some(only.index)
}

/// Change of the impulse at one diaphragm between two rounds, relative to the largest impulse of the step.
fn change(last: Option<ContactImpulse>, found: Option<ContactImpulse>, contacts: &[DiaphragmContact]) -> f64 {
    let of = |contact: Option<ContactImpulse>| contact.map_or([0.0; 2], |contact| contact.impulse);
    let ([u, v], [x, y]) = (of(last), of(found));
    let largest = contacts.iter().map(|contact| length(of(contact.found))).fold(length([u, v]), f64::max);
    length([x - u, y - v]) / largest.max(f64::MIN_POSITIVE)
}

/// Adds a vector.
fn add([x, y]: [f64; 2], sum: &mut [f64; 2]) {
    *sum = [sum[0] + x, sum[1] + y];
}

/// Displacement of one node by the truncated modes per impulse on another, in steps of `h` \[m/(N s)\].
fn truncated(structure: &Structure, nodes: [usize; 2], h: f64) -> [[f64; 2]; 2] {
    let [at, acting] = nodes.map(|node| structure.rotor.plane_places(node));
    structure
        .lateral_residual
        .as_ref()
        .map_or([[0.0; 2]; 2], |all| at.map(|row| acting.map(|column| all[(row, column)] / h)))
}

/// Contact with the stator of a diaphragm, in contact steps of `h` \[s\].
fn stator_of(
    machine: &Machine,
    index: usize,
    structure: &Structure,
    free_motion: &FreeMotion,
    h: f64,
) -> StatorContact {
    let diaphragm = &machine.diaphragms[index];
    let (axes, contact) = (StatorAxes::new(diaphragm), &diaphragm.contact);
    if let DiaphragmKind::RadialSpring { stiffness } = &diaphragm.kind {
        let start = (free_motion.contact_displacement(index), free_motion.impulse_response(index));
        let spring = RadialSpring::new((axes, contact, *stiffness), structure, h, start);
        return StatorContact::of_spring(axes, spring, contact.gap);
    }
    let points = ring_points_of(machine, index, structure, h);
    StatorContact::of_ring(axes, ContactStep::new(diaphragm, structure, index, &points, h))
}

/// Checks that a rotor with this initial displacement in the machine's axes is inside its ring, without contact. A radial spring
/// may start pressed.
fn starts_inside(diaphragm: &Diaphragm, place: [f64; 2]) -> Result<(), StartError> {
    let contact = &diaphragm.contact;
    if matches!(diaphragm.kind, DiaphragmKind::RadialSpring { .. }) {
        return Ok(());
    }
    let eccentricity = length([place[0] - contact.offset[0], place[1] - contact.offset[1]]);
    let radius = contact.rotor_radius + contact.gap;
    let name = || diaphragm.name.clone();
    if eccentricity >= radius {
        return Err(StartError::StartsOutside { diaphragm: name(), eccentricity, radius, offset: contact.offset });
    }
    let gap = contact.gap - eccentricity;
    if gap < 0.0 { Err(StartError::StartsInContact { diaphragm: name(), gap }) } else { Ok(()) }
}
