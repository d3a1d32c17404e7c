//! Bearing coefficients over the speed.
//!
//! ```text
//! linear    p(W) between two nodes on the straight line
//! pchip     cubic Hermite with monotone slopes: where both neighbouring chords have one sign, their weighted harmonic mean, otherwise 0         (1)
//! ```
//! Each of the eight coefficients is interpolated on its own. Neither rule leaves the range of two neighbouring nodes, so no damping becomes negative between two
//! nodes that have none. Source: (1) Fritsch, Butland (1984), SIAM J. Sci. Stat. Comput. 5, 300-304, with the one-sided three-point slopes at both ends; the rule of
//! `pchip` of other programs. Limits: outside its speeds the table has no value; `at` then takes the nearest end, and a run ends. `extended` continues it a little for
//! a grid of speeds.
//! Verified by `both_interpolations_are_those_of_the_reference`, `a_monotone_coefficient_stays_monotone`.

/// Rule between two speeds of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight lines.
    Linear,
    /// Monotone cubic polynomials.
    Pchip,
}

/// Stiffness and damping of a bearing at one speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// Stiffness [[kxx, kxy], [kyx, kyy]] \[N/m\].
    pub stiffness: [[f64; 2]; 2],
    /// Damping [[cxx, cxy], [cyx, cyy]] \[N s/m\].
    pub damping: [[f64; 2]; 2],
}

/// Number of coefficients: kxx, kxy, kyx, kyy, cxx, cxy, cyx, cyy.
pub(super) const COEFFICIENTS: usize = 8;

/// Largest distance beyond the table, as a share of its highest speed, over which [`BearingTable::extended`] continues it.
const EXTENSION: f64 = 0.04;

/// Table of a bearing's coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct BearingTable {
    /// Speeds \[rad/s\], ascending, two or more.
    speeds: Vec<f64>,
    /// Coefficients at these speeds, with the factors of the machine, and their slopes for [`Interpolation::Pchip`].
    values: Vec<[f64; COEFFICIENTS]>,
    slopes: Vec<[f64; COEFFICIENTS]>,
    interpolation: Interpolation,
}

impl BearingTable {
    /// Table of ascending speeds and the coefficients at each.
    #[must_use]
    pub fn new(speeds: Vec<f64>, values: Vec<[f64; COEFFICIENTS]>, interpolation: Interpolation) -> Self {
        let slopes = match interpolation {
            Interpolation::Linear => Vec::new(),
            Interpolation::Pchip => slopes(&speeds, &values),
        };
        Self { speeds, values, slopes, interpolation }
    }

    /// Speeds of the table \[rad/s\], ascending.
    #[must_use]
    pub fn speeds(&self) -> &[f64] {
        &self.speeds
    }

    /// Lowest and highest speed \[rad/s\].
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        [self.speeds[0], self.speeds[self.speeds.len() - 1]]
    }

    /// Whether the table has a value at a speed \[rad/s\].
    #[must_use]
    pub fn covers(&self, speed: f64) -> bool {
        let [low, high] = self.range();
        (low..=high).contains(&speed)
    }

    /// Coefficients at a speed \[rad/s\]; outside the table those of its nearer end.
    #[must_use]
    pub fn at(&self, speed: f64) -> Coefficients {
        let [low, high] = self.range();
        coefficients(&self.values_at(speed.clamp(low, high)))
    }

    /// Coefficients at a speed \[rad/s\]; beyond the table those on the tangent of its nearer end, for at most `EXTENSION`.
    ///
    /// The last speed of a grid lies beyond the table. Constant coefficients there would make a bend at the end of the table.
    #[must_use]
    pub fn extended(&self, speed: f64) -> Coefficients {
        let [low, high] = self.range();
        let inside = speed.clamp(low, high);
        let beyond = (speed - inside).clamp(-EXTENSION * high, EXTENSION * high);
        let mut values = self.values_at(inside);
        if beyond != 0.0 {
            let (end, other) = if beyond < 0.0 { (0, 1) } else { (self.speeds.len() - 1, self.speeds.len() - 2) };
            for (i, value) in values.iter_mut().enumerate() {
                let chord = (self.values[end][i] - self.values[other][i]) / (self.speeds[end] - self.speeds[other]);
                *value += beyond * self.slopes.get(end).map_or(chord, |slopes| slopes[i]);
            }
        }
        coefficients(&values)
    }

    /// Coefficients at the speeds of the table.
    pub fn at_nodes(&self) -> impl Iterator<Item = Coefficients> {
        self.values.iter().map(coefficients)
    }

    /// The eight coefficients at a speed within the table.
    fn values_at(&self, speed: f64) -> [f64; COEFFICIENTS] {
        let right = self.speeds.partition_point(|node| *node < speed).clamp(1, self.speeds.len() - 1);
        let (left, h) = (right - 1, self.speeds[right] - self.speeds[right - 1]);
        let t = (speed - self.speeds[left]) / h;
        std::array::from_fn(|i| {
            let (a, b) = (self.values[left][i], self.values[right][i]);
            match self.interpolation {
                Interpolation::Linear => a + t * (b - a),
                Interpolation::Pchip => {
                    let (p, q) = (h * self.slopes[left][i], h * self.slopes[right][i]);
                    let s = 1.0 - t;
                    // written with b - a: between equal values the rounding of both terms would not cancel
                    a + t * t * (3.0 - 2.0 * t) * (b - a) + s * t * (s * p - t * q)
                }
            }
        })
    }

    /// Constant coefficients for the model: the largest magnitude of each direct coefficient, the middle of the range of each cross coefficient. The
    /// difference from the coefficients at a speed acts as a force; no part of it exceeds the constant part of a step.
    #[must_use]
    pub fn constant_part(&self) -> Coefficients {
        coefficients(&std::array::from_fn(|i| {
            let (low, high) = self
                .values
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value[i]), high.max(value[i])));
            if matches!(i % 4, 0 | 3) { high } else { 0.5 * (low + high) }
        }))
    }
}

fn coefficients(v: &[f64; COEFFICIENTS]) -> Coefficients {
    Coefficients { stiffness: [[v[0], v[1]], [v[2], v[3]]], damping: [[v[4], v[5]], [v[6], v[7]]] }
}

/// Slopes (1) of all coefficients at all nodes.
fn slopes(x: &[f64], y: &[[f64; COEFFICIENTS]]) -> Vec<[f64; COEFFICIENTS]> {
    let last = x.len() - 1;
    let h: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let slope = |k: usize, i: usize| {
        let chord = |k: usize| (y[k + 1][i] - y[k][i]) / h[k];
        if last == 1 {
            return chord(0);
        }
        if k == 0 {
            return end_slope([h[0], h[1]], [chord(0), chord(1)]);
        }
        if k == last {
            return end_slope([h[last - 1], h[last - 2]], [chord(last - 1), chord(last - 2)]);
        }
        let (before, after) = (chord(k - 1), chord(k));
        if before * after <= 0.0 {
            return 0.0;
        }
        let (a, b) = (2.0 * h[k] + h[k - 1], h[k] + 2.0 * h[k - 1]);
        (a + b) / (a / before + b / after)
    };
    (0..=last).map(|k| std::array::from_fn(|i| slope(k, i))).collect()
}

/// Slope at an end from the two intervals and chords next to it, limited so that the curve stays monotone.
fn end_slope([h, next]: [f64; 2], [chord, other]: [f64; 2]) -> f64 {
    let slope = ((2.0 * h + next) * chord - h * other) / (h + next);
    if slope * chord <= 0.0 {
        0.0
    } else if chord * other <= 0.0 && slope.abs() > 3.0 * chord.abs() {
        3.0 * chord
    } else {
        slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(values: &[f64], interpolation: Interpolation) -> BearingTable {
        let speeds = [100.0, 200.0, 300.0, 450.0, 700.0][..values.len()].to_vec();
        BearingTable::new(speeds, values.iter().map(|value| [*value; COEFFICIENTS]).collect(), interpolation)
    }

    /// Speed, value on straight lines, value of the monotone cubic.
    const REFERENCE: [(f64, f64, f64); 7] = [
        (100.0, 90000000.0, 90000000.0),
        (137.0, 82600000.0, 81290755.0),
        (150.0, 80000000.0, 78541666.66666666),
        (260.0, 64000000.0, 63407567.567567565),
        (400.0, 53333333.333333336, 52508018.222303934),
        (500.0, 48800000.0, 48200489.79591837),
        (699.0, 44024000.0, 44000140.88097959),
    ];

    /// Values between five nodes at unequal distances by an independent implementation (SciPy).
    #[test]
    fn both_interpolations_are_those_of_the_reference() {
        let values = [9e7, 7e7, 6e7, 5e7, 4.4e7];
        for (speed, linear, pchip) in REFERENCE {
            for (interpolation, wanted) in [(Interpolation::Linear, linear), (Interpolation::Pchip, pchip)] {
                let found = table(&values, interpolation).at(speed).stiffness[0][0];
                assert!((found / wanted - 1.0).abs() < 1e-14, "{interpolation:?} at {speed}: {found:?} {wanted:?}");
            }
        }
        for interpolation in [Interpolation::Linear, Interpolation::Pchip] {
            let table = table(&values, interpolation);
            assert!(table.covers(100.0) && table.covers(700.0) && !table.covers(99.9) && !table.covers(700.1));
            assert_eq!([table.at(90.0), table.at(800.0)], [table.at(100.0), table.at(700.0)]);
        }
    }

    #[test]
    fn a_table_continues_on_its_tangents_beyond_its_ends() {
        let values = [9e7, 7e7, 6e7, 5e7, 4.4e7];
        for interpolation in [Interpolation::Linear, Interpolation::Pchip] {
            let table = table(&values, interpolation);
            let at = |speed: f64| table.extended(speed).stiffness[0][1];
            for (end, inwards) in [(100.0, 1.0), (700.0, -1.0)] {
                let slope = (at(end + inwards * 1e-3) - at(end)) / (inwards * 1e-3);
                let beyond = (at(end - inwards * 20.0) - at(end)) / (inwards * -20.0);
                // the slope of pchip is zero at one end; chords are 6e4 and more
                assert!((beyond - slope).abs() < 1.0, "{interpolation:?} at {end}: {beyond} {slope}");
                // and stays constant beyond 28 rad/s, 4 % of the highest speed
                assert_eq!(at(end - inwards * 29.0).to_bits(), at(end - inwards * 60.0).to_bits());
            }
            assert_eq!(table.extended(333.0), table.at(333.0));
        }
    }

    #[test]
    fn a_monotone_coefficient_stays_monotone() {
        for values in [[9.0, 8.9, 1.0, 0.9, 0.0], [0.0, 1.0, 1.0, 5.0, 100.0]] {
            let table = table(&values, Interpolation::Pchip);
            let at = |k: u32| table.at(100.0 + f64::from(k)).damping[1][1];
            let rises = values[4] > values[0];
            assert!((0..600).all(|k| if rises { at(k) <= at(k + 1) } else { at(k) >= at(k + 1) }));
        }
        // two nodes: a straight line
        assert!((table(&[1.0, 3.0], Interpolation::Pchip).at(150.0).stiffness[1][0] - 2.0).abs() < 1e-15);
    }
}
