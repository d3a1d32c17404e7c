//! Forces at coupled contact points by pivoting on their states: open, sticking or sliding.
//!
//! The linear system of the present states gives forces (open: no force; sticking: g = s = 0; sliding: g = 0 and lambda_T = mu sign lambda). The most
//! violated condition changes one state, until no condition is violated. From the states of the last solution this takes a few rounds.
//! Source: principal pivoting for complementarity (Cottle, Pang, Stone 1992, ch. 4).

use super::conditions::{Coupled, POINTS};
use crate::contact::ContactReaction;
use bladeoff_model::machine::FrictionLaw;

/// Smallest pivot of the elimination, as a share of its column's largest entry.
const SINGULAR: f64 = 1e-13;
/// Smallest violation that is not rounding, as a share of the largest force, gap or slip.
const ROUNDING: f64 = 1e-10;
/// Number of rounds that follow the worst violation, and maximum number of rounds.
const WORST: usize = 24;
const ROUNDS: usize = 60;
/// Added to the violation of a point in tension: other violations are unknown until this point is open.
const PULLS: f64 = 1e6;

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    Open,
    Sticks,
    /// Sliding with this sign of the slip.
    Slides(f64),
}

/// Finds forces that satisfy the conditions, starting from the present ones, for at most P points and U unknowns (a normal and a tangential force
/// each); `None` if the states cycle. (Few points are common. Clearing space for all of them would take longer than solving their system.)
pub(super) fn pivot<const P: usize, const U: usize>(coupled: &Coupled, forces: &mut [ContactReaction]) -> Option<()> {
    let mut states = [State::Open; P];
    for (state, force) in states.iter_mut().zip(&*forces) {
        *state = match (force.normal > 0.0, coupled.law) {
            (false, _) => State::Open,
            (true, FrictionLaw::Slip) => State::Slides(coupled.sign),
            (true, FrictionLaw::StickSlip) if force.sticks => State::Sticks,
            (true, FrictionLaw::StickSlip) => State::Slides(force.tangential.signum()),
        };
    }
    let states = &mut states[..forces.len()];
    for round in 0..ROUNDS {
        let solution = forces_in::<P, U>(coupled, states)?;
        // the worst violation leads to the solution fastest but may cycle; the first one does not cycle (Murty 1974)
        let change = violation(coupled, states, &solution, round < WORST);
        let Some((_, k, state)) = change else {
            for (force, (state, [normal, tangential])) in forces.iter_mut().zip(states.iter().zip(solution)) {
                *force = match state {
                    State::Open => ContactReaction::NONE,
                    State::Sticks => ContactReaction { normal, tangential, sticks: true },
                    State::Slides(_) => ContactReaction { normal, tangential, sticks: false },
                };
            }
            return Some(());
        };
        states[k] = state;
    }
    None
}

/// Force of a single point that keeps sliding in the same direction, with its own compliance multiplied by `yields`. It equals the result of the
/// first round of [`pivot`] to the last bit; `None` if the point does not keep sliding.
pub(super) fn slides_on(coupled: &Coupled, yields: f64, last: &ContactReaction) -> Option<ContactReaction> {
    let slips = coupled.law == FrictionLaw::Slip;
    if last.normal <= 0.0 || (last.sticks && !slips) {
        return None;
    }
    let sign = if slips { coupled.sign } else { last.tangential.signum() };
    let ([[nn, nt], [tn, tt]], [gap, slip]) = (coupled.w[0][0], coupled.start[0]);
    let along = yields * nn + coupled.friction * sign * nt;
    let normal = -gap / along;
    let tangential = coupled.friction * sign * normal;
    let slides = slip + (tn * normal + yields * tt * tangential);
    // NaN does not satisfy the condition
    let holds = along != 0.0 && normal >= 0.0 && (slips || -sign * slides / slip.abs() <= ROUNDING);
    holds.then_some(ContactReaction { normal, tangential, sticks: false })
}

/// Larger of two numbers; the first one beside NaN. (`f64::max` takes four instructions.)
#[inline(always)]
fn larger(one: f64, other: f64) -> f64 {
    if other > one { other } else { one }
}

/// State that a violated condition asks for: (violation, point, state); of the worst violation, the last one of equal ones, or of the first.
#[inline(always)]
fn violation<const P: usize>(
    coupled: &Coupled,
    states: &[State],
    forces: &[[f64; 2]; P],
    finds_worst: bool,
) -> Option<(f64, usize, State)> {
    let count = states.len();
    let most = forces[..count].iter().fold(0.0, |most, force| larger(most, force[0].abs()));
    let deepest = coupled.start[..count].iter().fold(0.0, |most, start| larger(most, start[0].abs()));
    let furthest = coupled.start[..count].iter().fold(0.0, |most, start| larger(most, start[1].abs()));
    let stick_slip = coupled.law == FrictionLaw::StickSlip;
    let mut found: Option<(f64, usize, State)> = None;
    for k in 0..count {
        let [normal, tangential] = forces[k];
        let moved = || coupled.moved(k, &forces[..count]);
        let (violation, state) = match states[k] {
            State::Open => {
                let [gap, slip] = moved();
                (-gap / deepest, State::Slides(if stick_slip { slip.signum() } else { coupled.sign }))
            }
            // a point in tension because it should stick may be in compression when it slides
            State::Sticks => {
                ((tangential.abs() - coupled.friction * normal) / most, State::Slides(tangential.signum()))
            }
            State::Slides(_) if normal < -ROUNDING * most => (PULLS - normal / most, State::Open),
            State::Slides(sign) if stick_slip => (-sign * moved()[1] / furthest, State::Sticks),
            State::Slides(_) => (0.0, State::Open),
        };
        if violation > ROUNDING && found.is_none_or(|(worst, ..)| worst.total_cmp(&violation).is_le()) {
            found = Some((violation, k, state));
            if !finds_worst {
                break;
            }
        }
    }
    found
}

/// Normal and tangential forces of the present states; `None` if their linear system is singular.
fn forces_in<const P: usize, const U: usize>(coupled: &Coupled, states: &[State]) -> Option<[[f64; 2]; P]> {
    // one unknown per normal force, and one per tangential force of a sticking point: (point, row of (1))
    let mut unknowns = [(0, 0); U];
    let mut size = 0;
    for (k, state) in states.iter().enumerate() {
        let rows = match state {
            State::Open => 0,
            State::Sticks => 2,
            State::Slides(_) => 1,
        };
        for row in 0..rows {
            unknowns[size] = (k, row);
            size += 1;
        }
    }
    let (unknowns, mut solution) = (&unknowns[..size], [0.0; U]);
    match size {
        0..=2 => solved::<2>(coupled, states, unknowns, &mut solution)?,
        3..=4 => solved::<4>(coupled, states, unknowns, &mut solution)?,
        5..=8 => solved::<8>(coupled, states, unknowns, &mut solution)?,
        9..=16 => solved::<16>(coupled, states, unknowns, &mut solution)?,
        17..=24 => solved::<24>(coupled, states, unknowns, &mut solution)?,
        _ => solved::<{ 2 * POINTS }>(coupled, states, unknowns, &mut solution)?,
    }
    let mut forces = [[0.0; 2]; P];
    for (&(k, row), value) in unknowns.iter().zip(solution) {
        forces[k][row] = value;
        if let State::Slides(sign) = states[k] {
            forces[k][1] = coupled.friction * sign * value;
        }
    }
    Some(forces)
}

/// Values of at most N unknowns.
fn solved<const N: usize>(
    coupled: &Coupled,
    states: &[State],
    unknowns: &[(usize, usize)],
    solution: &mut [f64],
) -> Option<()> {
    let (mut system, mut right) = ([[0.0; N]; N], [0.0; N]);
    for (j, &(other, column)) in unknowns.iter().enumerate() {
        let rows = system.iter_mut().zip(unknowns).map(|(line, &(k, row))| (&mut line[j], &coupled.w[k][other][row]));
        match states[other] {
            State::Slides(sign) => {
                let grip = coupled.friction * sign;
                rows.for_each(|(entry, [normal, tangential])| *entry = normal + grip * tangential);
            }
            _ => rows.for_each(|(entry, both)| *entry = both[column]),
        }
        right[j] = -coupled.start[other][column];
    }
    eliminate(&mut system, &mut right, unknowns.len(), solution)
}

/// Gaussian elimination with row pivoting. Rows are processed at their full, fixed length: entries before the pivot's column are not read again, and
/// entries after the last unknown are zero.
fn eliminate<const N: usize>(
    system: &mut [[f64; N]; N],
    right: &mut [f64; N],
    size: usize,
    solution: &mut [f64],
) -> Option<()> {
    let mut scale = [0.0_f64; N];
    for row in &system[..size] {
        for (scale, entry) in scale.iter_mut().zip(row) {
            *scale = larger(*scale, entry.abs());
        }
    }
    for column in 0..size {
        let (mut pivot, mut largest) = (column, system[column][column].abs());
        for row in column + 1..size {
            let entry = system[row][column].abs();
            // the last of several equally large entries
            if entry >= largest {
                (pivot, largest) = (row, entry);
            }
        }
        if largest.is_nan() || largest <= SINGULAR * scale[column] {
            return None;
        }
        if pivot != column {
            system.swap(column, pivot);
            right.swap(column, pivot);
        }
        let (top, side) = (system[column], right[column]);
        for (row, right) in system[column + 1..size].iter_mut().zip(&mut right[column + 1..size]) {
            let factor = row[column] / top[column];
            for (entry, above) in row.iter_mut().zip(&top) {
                *entry -= factor * above;
            }
            *right -= factor * side;
        }
    }
    for i in (0..size).rev() {
        let mut sum = right[i];
        for j in i + 1..size {
            sum -= system[i][j] * solution[j];
        }
        solution[i] = sum / system[i][i];
        if solution[i].is_nan() {
            return None;
        }
    }
    Some(())
}
