//! Contact at one point: force, place and velocities are iterated together until the linearised gap at n+1 is zero.
//!
//! Source: paper, Algorithm 1, with its loop condition corrected.

use super::axes::{directions, on_rotor};
use super::bodies::Bodies;
use super::rounds::{Rounds, TOLERANCE, Work};
use super::step_contact::{ContactFailure, StepContact};
use crate::contact::{Compliance, ContactReaction, Gap, NotUnique, PlaceSearch, slide, stick_or_slide};
use crate::engine::shaft_line::{Increments, ShaftLine};
use bladeoff_model::machine::{Detection, FrictionLaw};
use bladeoff_numerics::linalg::dot;

/// Initial data of a contact step.
pub(super) struct Attempt {
    /// Time at n \[s\].
    pub time: f64,
    /// Rotor centre at n in the stator's frame \[m\].
    pub x_n: [f64; 2],
    /// Slip direction of [`FrictionLaw::Slip`], +1 or -1.
    pub sign: f64,
    /// Gap of the prediction without contact.
    pub predicted: Gap,
    /// Place of the force, if it differs from the place of the gap.
    pub force_place: Option<Gap>,
    /// Whether the rotor penetrates the predicted ring at more than one local minimum.
    pub several_minima: bool,
}

/// Iterates force, places and velocities from the prediction `d`; `None` if the iteration does not converge. `updating`: the place is updated in each
/// round; otherwise it is the predicted one.
pub(super) fn iterate(
    bodies: &mut Bodies<'_>,
    line: &mut ShaftLine<'_>,
    attempt: &Attempt,
    updating: bool,
    d: &mut Increments,
    work: &mut Work,
) -> Result<Option<(ContactReaction, Gap)>, ContactFailure> {
    let (mut last, mut last_acting) = (ContactReaction::NONE, attempt.predicted);
    let mut search = PlaceSearch::default();
    let mut rounds = Rounds::default();
    loop {
        work.iterations += 1;
        bodies.left_out.spring_back();
        bodies.give_way(&last_acting, &last);
        let x = bodies.after(attempt.x_n, d);
        bodies.field_after();
        let stator = &mut bodies.stator;
        let gap = if updating { stator.own_gap(x) } else { stator.fixed_gap(x, attempt.predicted.place) };
        let acting = match attempt.force_place {
            Some(place) => place,
            None if !updating => gap,
            None => match search.next(gap.place.alpha) {
                None => return Ok(None),
                Some(alpha) if alpha == gap.place.alpha => gap,
                Some(alpha) => stator.acting_at(alpha, x, &gap),
            },
        };
        bodies.load_rows(&acting, &gap);
        let driven = line.spin.driven();
        line.respond(attempt.time, d, &mut work.free);
        // the gap contains the effect of the last force: the truncated modes follow the new force instead
        let sprung = Gap { value: gap.value - bodies.left_out_between(&gap, &last_acting) * last.normal, ..gap };
        let force =
            solve(bodies, &sprung, &acting, attempt.sign, (d, &work.free)).map_err(ContactFailure::NotUnique)?;
        bodies.push(&force, &acting, &mut work.free);
        line.spin.add_drive_torque(bodies.section.drive_torque(force.tangential) * bodies.section.radius);
        let change = (force.normal - last.normal).abs().max((force.tangential - last.tangential).abs());
        let moved = bodies.change(line, driven, (d, &work.free), force.normal, bodies.rounding_of_force());
        let scale = bodies.scale();
        let radius = bodies.section.radius.max(bodies.stator.gap);
        let steady = change * scale <= 1e-14 * radius + 1e-11 * force.normal * scale;
        d.copy_from(&work.free);
        (last, last_acting) = (force, acting);
        if rounds.done > 0 && moved <= TOLERANCE && steady && bodies.ring_settled() {
            return Ok(Some((force, gap)));
        }
        if !rounds.another(moved) {
            return Ok(None);
        }
    }
}

/// Contact force for the linearised gap and slip; `free` are the increments of the round without it.
fn solve(
    bodies: &Bodies<'_>,
    gap: &Gap,
    acting: &Gap,
    sign: f64,
    (d, free): (&Increments, &Increments),
) -> Result<ContactReaction, NotUnique> {
    let section = &bodies.section;
    let (dx, dx_free) = (section.increment(&d.lateral), section.increment(&free.lateral));
    let change = gap.place.polar([dx_free[0] - dx[0], dx_free[1] - dx[1]]);
    let mut g0 = gap.value + gap.rotor_gradient[0] * change[0] + gap.rotor_gradient[1] * change[1];
    let (normal, tangent) = directions(acting);
    let gradient = gap.place.cartesian(gap.rotor_gradient);
    let mut w = Compliance {
        nn: -section.along(gradient, normal),
        nt: -section.along(gradient, tangent),
        tn: -section.along(tangent, normal),
        tt: -section.along(tangent, tangent) - section.rolling(),
    };
    let mut slip = tangent[0] * dx_free[0] + tangent[1] * dx_free[1] + section.radius * section.turn(&free.torsion);
    if let Some(ring) = &bodies.stator.ring {
        g0 += dot(&ring.gap_row, &ring.free) - dot(&ring.gap_row, &ring.d);
        w.nn += dot(&ring.gap_row, &ring.normal.response);
        w.nt += dot(&ring.gap_row, &ring.tangent.response);
        w.tn -= dot(&ring.tangent.force, &ring.normal.response);
        w.tt -= dot(&ring.tangent.force, &ring.tangent.response);
        slip -= dot(&ring.tangent.force, &ring.free);
    }
    w.nn += bodies.left_out_between(gap, acting);
    match bodies.law {
        FrictionLaw::Slip => slide(g0, w, bodies.friction, sign),
        FrictionLaw::StickSlip => stick_or_slide(g0, slip, w, bodies.friction),
    }
}

/// Contact quantities and works of a converged step.
pub(super) fn account(
    bodies: &mut Bodies<'_>,
    line: &ShaftLine<'_>,
    attempt: &Attempt,
    (force, gap, no_fixed_point): (ContactReaction, Gap, bool),
    d: &Increments,
) -> StepContact {
    let acting = attempt.force_place.unwrap_or(gap);
    let slip = bodies.centred_slip(line, &acting, d);
    let (normal, _) = directions(&acting);
    let step = bodies.section.centred_step(line, d);
    let mut opening = -(normal[0] * step[0] + normal[1] * step[1]);
    if let Some(ring) = &bodies.stator.ring {
        opening += ring.centred_step(&ring.normal.force);
    }
    // Hyp 1: the approximate gap opens by v_alpha d(gamma) in addition to the relative displacement of the bodies
    let model_work = force.normal * acting.model_slope * acting.place.polar(step)[1];
    bodies.left_out.held = 0.5 * force.normal * force.normal * bodies.left_out_between(&acting, &acting);
    bodies.left_out.spring_back();
    bodies.give_way(&acting, &force);
    let left = if bodies.stator.detection == Detection::Hyp2Frozen || no_fixed_point {
        let x = bodies.after(attempt.x_n, d);
        bodies.field_after();
        bodies.stator.own_gap(x)
    } else {
        gap
    };
    StepContact {
        force,
        on_rotor: on_rotor(&force, &acting),
        gap: left,
        slip,
        reversed: bodies.law == FrictionLaw::Slip && slip * attempt.sign < 0.0,
        no_fixed_point,
        several_minima: attempt.several_minima,
        points: 1,
        friction_work: force.tangential * slip * line.dt,
        normal_work: -force.normal * opening - model_work,
        model_work,
    }
}
