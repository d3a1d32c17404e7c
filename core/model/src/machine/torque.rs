//! Torques on the shaft over time: points with straight lines between, and the alternating torque of a generator's short circuit.
//!
//! ```text
//! T(t) = L(t) + S(t)
//! L    linear between its points, the first value before the first point, the last value after the last; two points of one time: a jump      (1)
//! S    A1 e^(-s/D1) sin(w s) + A2 e^(-s/D2) sin(2 w s),  s = t - start >= 0;  0 before                                                        (2)
//! I0 = integral of T over [a, b],  I1 = integral of (t - (a + b)/2) T                                                                        (3)
//! ```
//! w: circular frequency of the grid \[rad/s\]; A1, A2: amplitudes at the frequency of the grid and at its double \[N m\]; D1, D2: time constants \[s\].
//! The electrical torque of a short circuit has a slowly changing part, a part of the grid's frequency and one of its double, all of them damped. The
//! first is L here.
//!
//! Source: D. N. Walker, Torsional Vibration of Turbomachinery, McGraw-Hill, 2004 (parts of the torque). (3) is in closed form.
//! Limits: T does not depend on the speed or on the torsion of the shaft. Verified by the tests below.

/// Torque at a node of the shaft, positive in the direction of the spin.
#[derive(Debug, Clone, PartialEq)]
pub struct Torque {
    /// Name of its table.
    pub name: String,
    /// Node.
    pub node: usize,
    /// Times of L \[s\], ascending, at most two of them equal; empty: L = 0.
    pub times: Vec<f64>,
    /// Values of L at these times \[N m\].
    pub values: Vec<f64>,
    /// S; `None`: S = 0.
    pub short_circuit: Option<ShortCircuit>,
}

/// Alternating torque (2) of a short circuit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShortCircuit {
    /// Time at which it begins \[s\] >= 0.
    pub start: f64,
    /// Circular frequency of the grid w \[rad/s\] > 0.
    pub frequency: f64,
    /// Amplitudes A1 and A2 \[N m\].
    pub amplitudes: [f64; 2],
    /// Time constants D1 and D2 \[s\] > 0.
    pub decays: [f64; 2],
}

impl Torque {
    /// Torque before t = 0, and at t = 0 before any jump there \[N m\].
    #[must_use]
    pub fn before(&self) -> f64 {
        self.values.first().copied().unwrap_or(0.0)
    }

    /// Torque at a time \[N m\]; at a jump the value after it.
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        let line = match self.times.partition_point(|start| *start <= time) {
            0 => self.before(),
            next if next == self.times.len() => self.values[next - 1],
            next => self.line(next, time),
        };
        line + self.short_circuit.map_or(0.0, |short_circuit| short_circuit.at(time))
    }

    /// I0 \[N m s\] and I1 \[N m s2\] of (3).
    #[must_use]
    pub fn moments(&self, [from, to]: [f64; 2]) -> [f64; 2] {
        let middle = 0.5 * (from + to);
        let mut sums = self.short_circuit.map_or([0.0; 2], |short_circuit| short_circuit.moments([from, to]));
        let mut add = |[a, b]: [f64; 2], [left, right]: [f64; 2]| {
            let (length, mean) = (b - a, 0.5 * (left + right));
            sums[0] += length * mean;
            sums[1] += length * ((0.5 * (a + b) - middle) * mean + length * (right - left) / 12.0);
        };
        let mut next = self.times.partition_point(|start| *start <= from);
        let mut start = from;
        while start < to {
            let end = self.times.get(next).map_or(to, |time| time.min(to));
            let ends = match next {
                0 => [self.before(); 2],
                _ if next == self.times.len() => [self.values[next - 1]; 2],
                _ => [self.line(next, start), self.line(next, end)],
            };
            add([start, end], ends);
            (start, next) = (end, next + 1);
        }
        sums
    }

    /// Time from which the torque changes \[s\]; `None`: it is constant.
    #[must_use]
    pub fn first_change(&self) -> Option<f64> {
        let of_line = self.values.windows(2).position(|ends| ends[0] != ends[1]).map(|at| self.times[at]);
        let of_fault = self.short_circuit.map(|short_circuit| short_circuit.start);
        of_line.into_iter().chain(of_fault).reduce(f64::min)
    }

    /// Times at which the torque has a jump or a corner \[s\].
    pub fn corners(&self) -> impl Iterator<Item = f64> {
        self.times.iter().copied().chain(self.short_circuit.map(|short_circuit| short_circuit.start))
    }

    /// Value at a time on the straight line that ends at point `next`.
    fn line(&self, next: usize, time: f64) -> f64 {
        let [[from, to], [left, right]] = [&self.times, &self.values].map(|list| [list[next - 1], list[next]]);
        if to > from { left + (right - left) * ((time - from) / (to - from)) } else { right }
    }
}

impl ShortCircuit {
    /// Whether any of its amplitudes is not 0.
    #[must_use]
    pub fn acts(&self) -> bool {
        self.amplitudes != [0.0; 2]
    }

    /// Rate -1/D and frequency of both parts, with their amplitudes.
    fn parts(&self) -> [(f64, [f64; 2]); 2] {
        [0, 1].map(|i| (self.amplitudes[i], [-1.0 / self.decays[i], self.frequency * (i + 1) as f64]))
    }

    fn at(&self, time: f64) -> f64 {
        let s = time - self.start;
        if s <= 0.0 {
            return 0.0;
        }
        self.parts()
            .iter()
            .map(|(amplitude, [rate, turn])| amplitude * (libm::exp(rate * s) * libm::sin(turn * s)))
            .sum()
    }

    /// (3) from `f = e^(z s)`, z = rate + i turn: integrals `f/z` and `f [(s - m)/z - 1/z^2]`, imaginary parts.
    fn moments(&self, ends: [f64; 2]) -> [f64; 2] {
        let middle = 0.5 * (ends[0] + ends[1]) - self.start;
        let [from, to] = ends.map(|time| (time - self.start).max(0.0));
        if to <= from {
            return [0.0; 2];
        }
        let mut sums = [0.0; 2];
        for (amplitude, [rate, turn]) in self.parts() {
            // 1/z
            let square = rate * rate + turn * turn;
            let [x, y] = [rate / square, -turn / square];
            let primitive = |s: f64| {
                let size = libm::exp(rate * s);
                let (sin, cos) = libm::sincos(turn * s);
                let [re, im] = [size * cos, size * sin];
                // f/z, and f/z^2
                let [a, b] = [re * x - im * y, re * y + im * x];
                [b, (s - middle) * b - (a * y + b * x)]
            };
            let (begin, end) = (primitive(from), primitive(to));
            (0..2).for_each(|i| sums[i] += amplitude * (end[i] - begin[i]));
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn torque(points: &[(f64, f64)], short_circuit: Option<ShortCircuit>) -> Torque {
        let (times, values) = points.iter().copied().unzip();
        Torque { name: "t".to_owned(), node: 0, times, values, short_circuit }
    }

    const FAULT: ShortCircuit =
        ShortCircuit { start: 0.11, frequency: 314.0, amplitudes: [4.0, -3.0], decays: [0.2, 0.07] };

    #[test]
    fn a_torque_is_linear_between_its_points_and_may_jump() {
        let torque = torque(&[(0.1, 2.0), (0.2, 4.0), (0.2, -1.0), (0.4, 1.0)], None);
        for (time, value) in [(-1.0, 2.0), (0.05, 2.0), (0.15, 3.0), (0.2, -1.0), (0.3, 0.0), (0.4, 1.0), (9.0, 1.0)] {
            assert!((torque.at(time) - value).abs() < 1e-14, "{time}: {}", torque.at(time));
        }
        assert_eq!(torque.before(), 2.0);
        let at_start = self::torque(&[(0.0, 5.0), (0.0, 0.0)], None);
        assert_eq!([at_start.before(), at_start.at(0.0)], [5.0, 0.0]);
        assert_eq!([torque.first_change(), at_start.first_change()], [Some(0.1), Some(0.0)]);
        assert_eq!(self::torque(&[(0.3, 5.0), (0.5, 5.0)], None).first_change(), None);
    }

    /// Midpoint sums of many short intervals; jumps are at their ends.
    #[test]
    fn moments_are_the_integrals() {
        let points = [(0.1, 2.0), (0.2, 4.0), (0.2, -1.0), (0.4, 1.0)];
        for torque in [torque(&points, None), torque(&points, Some(FAULT)), torque(&[], Some(FAULT))] {
            for [from, to] in
                [[-0.05, 0.05], [0.0, 0.4], [0.15, 0.2], [0.2, 0.25], [0.09, 0.14], [0.3, 0.9], [0.1, 0.1]]
            {
                let count = 200_000;
                let h = (to - from) / f64::from(count);
                let sum = |power: i32| -> f64 {
                    let parts = (0..count).map(|i| from + (f64::from(i) + 0.5) * h);
                    parts.map(|t| h * torque.at(t) * (t - 0.5 * (from + to)).powi(power)).sum()
                };
                let [mean, first] = torque.moments([from, to]);
                assert!((mean - sum(0)).abs() < 1e-7, "{from} {to}: {mean} {}", sum(0));
                assert!((first - sum(1)).abs() < 1e-7, "{from} {to}: {first} {}", sum(1));
            }
        }
    }

    #[test]
    fn a_short_circuit_starts_at_zero_and_decays() {
        let torque = torque(&[], Some(FAULT));
        assert_eq!([torque.at(0.0), torque.at(0.11), torque.before()], [0.0; 3]);
        let s = 0.013_f64;
        let by_hand = 4.0 * (-s / 0.2).exp() * (314.0 * s).sin() - 3.0 * (-s / 0.07).exp() * (628.0 * s).sin();
        assert!((torque.at(0.11 + s) - by_hand).abs() < 1e-11, "{} {by_hand}", torque.at(0.11 + s));
        assert!(torque.at(20.0).abs() < 1e-12);
    }
}
