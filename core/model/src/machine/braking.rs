//! Braking torque of the shaft line.

/// Braking torque on the mean spin, of coefficients and of a table over the speed.
///
/// ```text
/// T = -[c0 sign(W) + c1 W + c2 W|W| + B(|W|) sign(W)]       W: inertia-weighted mean spin [rad/s]
/// ```
/// B is linear between the speeds of the table and constant above the last one. T acts as `T s_i` on node i with the weights `s = j/J_t`, so that its
/// power `T W` is never positive.
/// Source: docs/theory/01-shaft-line.md (paper, section 3: aerodynamic and Newtonian fluid friction).
/// Verified by `braking_always_takes_energy`, `a_table_is_linear_between_its_speeds`, `core/tests/runs/torques.rs`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Braking {
    /// c0 \[N m\] >= 0.
    pub constant: f64,
    /// c1 [N m s] >= 0.
    pub linear: f64,
    /// c2 [N m s2] >= 0.
    pub quadratic: f64,
    /// Points (W, B) of the table \[rad/s, N m\], ascending from W = 0, B >= 0; empty: B = 0.
    pub table: Vec<[f64; 2]>,
}

impl Braking {
    /// T \[N m\], opposite to W; 0 at W = 0, where [`Braking::at_rest`] holds the rotor.
    #[must_use]
    #[inline]
    pub fn torque(&self, speed: f64) -> f64 {
        if speed == 0.0 {
            return 0.0;
        }
        let torque = -(self.constant * speed.signum() + self.linear * speed + self.quadratic * speed * speed.abs());
        if self.table.is_empty() { torque } else { torque - self.table_torque(speed.abs()) * speed.signum() }
    }

    /// Largest torque that holds a rotor at rest, c0 + B(0) \[N m\].
    #[must_use]
    pub fn at_rest(&self) -> f64 {
        self.table.first().map_or(self.constant, |first| self.constant + first[1])
    }

    /// Part of T that does not depend on the magnitude of W: `-(c0 + B(0)) sign(W)` \[N m\].
    #[must_use]
    pub fn constant_torque(&self, speed: f64) -> f64 {
        if speed == 0.0 { 0.0 } else { -self.at_rest() * speed.signum() }
    }

    /// Slope `-dT/dW` \[N m s\].
    #[must_use]
    pub fn slope(&self, speed: f64) -> f64 {
        let slope = self.linear + 2.0 * self.quadratic * speed.abs();
        if self.table.is_empty() { slope } else { slope + self.of_table(speed.abs())[1] }
    }

    /// Bound of the magnitude of the slope up to a speed \[N m s\].
    #[must_use]
    pub fn largest_slope(&self, speed: f64) -> f64 {
        let slopes = self.table.windows(2).map(|ends| ((ends[1][1] - ends[0][1]) / (ends[1][0] - ends[0][0])).abs());
        self.linear + 2.0 * self.quadratic * speed.abs() + slopes.fold(0.0, f64::max)
    }

    /// B at a speed >= 0 \[N m\].
    #[must_use]
    pub fn table_torque(&self, speed: f64) -> f64 {
        self.of_table(speed)[0]
    }

    /// B \[N m\] and dB/dW \[N m s\] at a speed >= 0.
    fn of_table(&self, speed: f64) -> [f64; 2] {
        let next = self.table.partition_point(|point| point[0] <= speed);
        match (next.checked_sub(1).and_then(|last| self.table.get(last)), self.table.get(next)) {
            (Some([from, low]), Some([to, high])) => {
                let slope = (high - low) / (to - from);
                [low + slope * (speed - from), slope]
            }
            (Some([_, value]), None) | (None, Some([_, value])) => [*value, 0.0],
            (None, None) => [0.0; 2],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn braking_always_takes_energy() {
        let table = vec![[0.0, 1.5], [4.0, 0.5], [20.0, 3.0]];
        for table in [Vec::new(), table] {
            let braking = Braking { constant: 2.0, linear: 3.0, quadratic: 0.5, table };
            for speed in [-30.0, -10.0, -0.1, 0.1, 10.0] {
                assert!(braking.torque(speed) * speed < 0.0);
            }
            let of_table = if braking.table.is_empty() { 0.0 } else { 1.0 };
            assert!((braking.torque(2.0) + 10.0 + of_table).abs() < 1e-15);
            assert!(braking.torque(0.0).abs() < f64::MIN_POSITIVE);
        }
    }

    #[test]
    fn a_table_is_linear_between_its_speeds() {
        let braking = Braking { table: vec![[0.0, 1.0], [10.0, 3.0], [20.0, 2.0]], ..Braking::default() };
        for (speed, torque, slope) in [(5.0, 2.0, 0.2), (10.0, 3.0, -0.1), (15.0, 2.5, -0.1), (40.0, 2.0, 0.0)] {
            assert!((braking.torque(speed) + torque).abs() < 1e-15, "{speed}");
            assert!((braking.torque(-speed) - torque).abs() < 1e-15, "{speed}");
            assert!((braking.slope(speed) - slope).abs() < 1e-15, "{speed}");
        }
        assert_eq!([braking.at_rest(), braking.constant_torque(-3.0), braking.largest_slope(9.0)], [1.0, 1.0, 0.2]);
    }
}
