//! Bearings with speed-dependent coefficients, in steps of central differences.
//!
//! ```text
//! K(W) = K_c + dK(W),  C(W) = C_c + dC(W)        K_c, C_c: constant part, in the operator of the step; the rest acts as a force                  (1)
//! -dK(W_n) x_n                                    known at n
//! -dC(W_n) v_n                                    iterated with the other forces of centred velocities; |dC| < C_c, so the iteration contracts
//! stored   x_{n+1}^T dKs_n x_n/2                  dKs: symmetric part, in the form in which the balance of the scheme is exact                   (2)
//! put in   x_n^T (dKs_n - dKs_{n-1}) x_{n-1}/2    by the change of the stiffness with the speed, where the journal is                            (3)
//! ```
//! W_n is the spin computed by the previous steps, of second order.
//! Source: (2), (3) follow from (1) by the telescoping sum of `x^T K x` over the steps.
//! Limits: the shift of the static equilibrium position does no work. Verified by `tests/rotor/bearing_tables.rs`.

use crate::rotor::{BearingSite, RotorMatrices};

/// Speed-dependent part of the bearing coefficients at n.
#[derive(Debug, Clone)]
pub(crate) struct Tables {
    /// Changes dK and dC at n and at n-1, by bearing.
    now: Vec<BearingSite>,
    before: Vec<BearingSite>,
    /// Indices of these bearings in the machine's list.
    places: Vec<usize>,
    /// Speed of `now` \[rad/s\].
    speed: f64,
}

impl Tables {
    /// Tables at the initial speed \[rad/s\], for n and n-1.
    pub fn new(rotor: &RotorMatrices, speed: f64) -> Self {
        let (places, now): (Vec<usize>, Vec<BearingSite>) = rotor.table_changes(speed).unzip();
        Self { before: now.clone(), now, places, speed }
    }

    /// Tables before the last call of [`Tables::at_speed`].
    pub fn repeated(&self) -> Self {
        Self { now: self.before.clone(), ..self.clone() }
    }

    /// Advances to the speed at n \[rad/s\].
    pub fn at_speed(&mut self, rotor: &RotorMatrices, speed: f64) {
        if self.now.is_empty() {
            return;
        }
        self.speed = speed;
        std::mem::swap(&mut self.before, &mut self.now);
        self.now.clear();
        self.now.extend(rotor.table_changes(speed).map(|(_, site)| site));
    }

    /// Whether every table covers a speed \[rad/s\].
    pub fn cover(rotor: &RotorMatrices, speed: f64) -> bool {
        rotor.tables.iter().all(|(_, table)| table.covers(speed))
    }

    /// Difference between a bearing's coefficients at n and their constant part; `None` without a table.
    pub fn change(&self, bearing: usize) -> Option<&BearingSite> {
        self.places.iter().position(|place| *place == bearing).map(|at| &self.now[at])
    }

    /// Differences dK and dC of all bearings with a table at n.
    pub fn changes(&self) -> &[BearingSite] {
        &self.now
    }

    pub(super) fn add_stiffness_forces(&self, x: &[f64], force: &mut [f64]) {
        for site in &self.now {
            site.push(site.load(site.across(x), [0.0; 2]).map(|part| -part), force);
        }
    }

    pub(super) fn add_damping_forces(&self, v: &[f64], force: &mut [f64]) {
        for site in &self.now {
            site.push(site.load([0.0; 2], site.across(v)).map(|part| -part), force);
        }
    }

    /// Stored energy (2) \[J\], from displacements at n and increments to n+1.
    pub fn stored(&self, x: &[f64], increments: &[f64]) -> f64 {
        let energy = |site: &BearingSite| {
            let (x, d) = (site.across(x), site.across(increments));
            0.5 * site.stiffness_form([x[0] + d[0], x[1] + d[1]], x)
        };
        self.now.iter().map(energy).sum()
    }

    /// Energy supply (3) \[J\], from displacements at n and increments from n-1.
    pub fn put_in(&self, x: &[f64], previous: &[f64]) -> f64 {
        let energy = |(now, before): (&BearingSite, &BearingSite)| {
            let (x, d) = (now.across(x), now.across(previous));
            let last = [x[0] - d[0], x[1] - d[1]];
            0.5 * (now.stiffness_form(x, last) - before.stiffness_form(x, last))
        };
        self.now.iter().zip(&self.before).map(energy).sum()
    }
}
