//! Contact force of one step: unilateral contact and Coulomb friction for the linearised gap and slip.
//!
//! ```text
//! g = g0 + W_nn lambda + W_nt lambda_T          gap at n+1                                   (1)
//! s = s0 + W_tn lambda + W_tt lambda_T          slip over the step, W_tt < 0                  (2)
//! lambda >= 0, g >= 0, lambda g = 0;   |lambda_T| <= mu lambda;   s = 0 or lambda_T = mu lambda sign(s)
//! ```
//! The rotor is subject to `-lambda n - lambda_T t` and the torque `-lambda_T R_r`, the ring to the opposite force.
//! Source: paper section 2 and its reference 10 (forward-increment Lagrange multipliers); docs/theory/03-contact.md. The normal and the tangential
//! condition are solved together. Verified by the tests below.

use bladeoff_text::document::units::format_digits;

/// Linear response of gap and slip to the contact force \[m/N\]: the Delassus operator W of one contact point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compliance {
    /// W_nn: gap per unit normal force.
    pub nn: f64,
    /// W_nt: gap per unit tangential force.
    pub nt: f64,
    /// W_tn: slip per unit normal force.
    pub tn: f64,
    /// W_tt: slip per unit tangential force (negative).
    pub tt: f64,
}

/// Reaction of a contact point over a step: a force \[N\] in the full and the reduced engine, an impulse \[N s\] in the exponential engine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactReaction {
    /// Normal reaction lambda >= 0 (pressure).
    pub normal: f64,
    /// Tangential reaction lambda_T, positive along the slip of the rotor relative to the ring; friction opposes the slip.
    pub tangential: f64,
    /// Whether the point sticks: zero slip, |lambda_T| <= mu lambda.
    pub sticks: bool,
}

impl ContactReaction {
    /// No contact.
    pub const NONE: Self = Self { normal: 0.0, tangential: 0.0, sticks: false };
}

/// `W <= 0`: the contact force of a step is not unique (Painleve).
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("W = {} <= 0: the contact force is not unique", format_digits(*.w, "m/N", 4))]
pub struct NotUnique {
    /// Compliance W of the gap along the combined force \[m/N\].
    pub w: f64,
}

/// Contact force for sliding in a given direction, with the scalar compliance `W = W_nn + mu sign W_nt`.
///
/// # Errors
/// [`NotUnique`] if `W <= 0` where a force is needed.
pub fn slide(gap: f64, w: Compliance, mu: f64, sign: f64) -> Result<ContactReaction, NotUnique> {
    let along = w.nn + mu * sign * w.nt;
    if along.is_nan() || along <= 0.0 {
        return if gap >= 0.0 { Ok(ContactReaction::NONE) } else { Err(NotUnique { w: along }) };
    }
    let normal = (-gap / along).max(0.0);
    Ok(ContactReaction { normal, tangential: mu * sign * normal, sticks: false })
}

/// Contact force for sticking if the friction cone allows it, otherwise for sliding in the direction of the slip that friction cannot prevent.
///
/// # Errors
/// [`NotUnique`] if neither has a solution.
pub fn stick_or_slide(gap: f64, slip: f64, w: Compliance, mu: f64) -> Result<ContactReaction, NotUnique> {
    if gap >= 0.0 {
        return Ok(ContactReaction::NONE);
    }
    let Some(trial) = stick(gap, slip, w) else {
        return slide(gap, w, mu, slip.signum());
    };
    if trial.normal >= 0.0 && trial.tangential.abs() <= mu * trial.normal {
        return Ok(trial);
    }
    // friction opposes the direction of the sticking force that it cannot supply; the opposite direction is used if it is the consistent one (because
    // the normal force changes the slip)
    let first = if trial.tangential != 0.0 { trial.tangential.signum() } else { slip.signum() };
    let mut refused = None;
    for sign in [first, -first] {
        match slide(gap, w, mu, sign) {
            Ok(force) => {
                let after = slip + w.tn * force.normal + w.tt * force.tangential;
                if force.normal == 0.0 || after * sign >= 0.0 {
                    return Ok(force);
                }
            }
            Err(error) => refused = Some(error),
        }
    }
    match refused {
        Some(error) => Err(error),
        None => slide(gap, w, mu, first),
    }
}

/// Solution of g = 0 and s = 0.
fn stick(gap: f64, slip: f64, w: Compliance) -> Option<ContactReaction> {
    let determinant = w.nn * w.tt - w.nt * w.tn;
    // with W_nn > 0 and W_tt < 0, the determinant of a definite response is negative
    if determinant.is_nan() || determinant >= 0.0 {
        return None;
    }
    let normal = (-gap * w.tt + slip * w.nt) / determinant;
    let tangential = (-slip * w.nn + gap * w.tn) / determinant;
    Some(ContactReaction { normal, tangential, sticks: true })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const W: Compliance = Compliance { nn: 2.0, nt: 0.3, tn: -0.3, tt: -1.5 };

    #[test]
    fn an_open_gap_needs_no_force() {
        assert_eq!(slide(1e-3, W, 0.2, 1.0), Ok(ContactReaction::NONE));
        assert_eq!(stick_or_slide(1e-3, 0.5, W, 0.2).map(|f| f.normal), Ok(0.0));
    }

    #[test]
    fn a_negative_compliance_is_said() {
        let w = Compliance { nn: 1.0, nt: -6.0, tn: 0.0, tt: -1.0 };
        assert_eq!(slide(-1.0, w, 0.5, 1.0), Err(NotUnique { w: -2.0 }));
    }

    proptest! {
        #[test]
        fn the_laws_hold(gap in -1.0..-1e-6, slip in -2.0..2.0, nt in -0.5..0.5f64, mu in 0.0..0.8f64) {
            let w = Compliance { nt, tn: -nt, ..W };
            let f = stick_or_slide(gap, slip, w, mu).expect("definite compliance");
            let g = gap + w.nn * f.normal + w.nt * f.tangential;
            let s = slip + w.tn * f.normal + w.tt * f.tangential;
            prop_assert!(f.normal > 0.0 && g.abs() < 1e-12);
            prop_assert!(f.tangential.abs() <= mu * f.normal * (1.0 + 1e-12));
            if f.sticks {
                prop_assert!(s.abs() < 1e-12);
            } else {
                prop_assert!((f.tangential - mu * f.normal * s.signum()).abs() < 1e-9 || s.abs() < 1e-9);
            }
            prop_assert!(f.tangential * s >= -1e-12);
        }

        #[test]
        fn sliding_closes_the_gap(gap in -1.0..-1e-6, mu in 0.0..0.5f64, forward in any::<bool>()) {
            let sign = if forward { 1.0 } else { -1.0 };
            let f = slide(gap, W, mu, sign).expect("positive");
            prop_assert!((gap + W.nn * f.normal + W.nt * f.tangential).abs() < 1e-12);
            prop_assert_eq!(f.tangential, mu * sign * f.normal);
        }
    }
}
