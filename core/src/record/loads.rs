//! Largest loads of bearings and pedestals: forces of the rotor on a bearing, and of a pedestal on the ground.

use super::Loads;
use super::peak::{At, Peak};
use super::row::Row;
use bladeoff_model::machine::Rotor;
use bladeoff_model::outcome::Empty;

/// Recorder of the load of each bearing and pedestal: its norm in the X-Y plane, both components, and the component against gravity.
#[derive(Debug, Clone)]
pub(crate) struct LoadRecorder {
    bearings: Vec<Watched>,
    /// Pedestals, in the order of the bearings that have one.
    pedestals: Vec<Watched>,
    /// Largest |F|^2 of all bearings \[N2\].
    any: Peak,
    /// Unit vector against gravity; +Y without gravity.
    up: [f64; 2],
}

/// Load of one bearing or pedestal.
#[derive(Debug, Clone)]
struct Watched {
    /// Name of the bearing.
    name: String,
    /// Largest |F|^2 \[N2\]; the root is taken once, at the end.
    square: Peak,
    /// Largest |F_x| and |F_y| \[N\].
    components: [Peak; 2],
    /// Largest component against gravity \[N\]; a downward component counts as 0.
    upward: Peak,
    /// The last two instants of smooth motion, oldest first.
    last: [Sample; 2],
    /// Number of valid instants in `last`.
    samples: usize,
}

/// Quantities of [`Watched`] at one instant: |F|^2 \[N2\], |F_x|, |F_y| and upward component \[N\].
#[derive(Debug, Clone, Copy, Default)]
struct Sample {
    /// |F|^2 \[N2\], |F_x|, |F_y| and upward component \[N\].
    values: [f64; 4],
    at: At,
}

/// Time and value of the vertex of the parabola through three samples, of which the middle one is the largest.
///
/// With steps of length h, the peak of a motion of circular frequency w is too small by a share of `(w h)^2/8` without the parabola, and
/// `(w h)^4/32` with it. Verified by `the_vertex_of_unequal_steps_is_that_of_the_parabola`.
fn vertex([a, b, c]: [f64; 3], [t0, t1, t2]: [f64; 3]) -> (f64, f64) {
    let (h, k) = (t1 - t0, t2 - t1);
    let (before, after) = ((b - a) / h, (c - b) / k);
    let (slope, curvature) = ((before * k + after * h) / (h + k), 2.0 * (after - before) / (h + k));
    (t1 - slope / curvature, b - 0.5 * slope * slope / curvature)
}

impl Watched {
    fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            square: Peak::default(),
            components: [Peak::default(); 2],
            upward: Peak::default(),
            last: [Sample::default(); 2],
            samples: 0,
        }
    }

    /// Records a load \[N\]; returns |F|^2 \[N2\].
    #[inline]
    fn see(&mut self, [x, y]: [f64; 2], up: [f64; 2], at: At) -> f64 {
        let square = x * x + y * y;
        self.square.see(square, at);
        self.components[0].see(x.abs(), at);
        self.components[1].see(y.abs(), at);
        self.upward.see((x * up[0] + y * up[1]).max(0.0), at);
        square
    }

    /// Records the interpolated peaks between the last three instants, the last of which has this load. No impulse acts at this instant.
    #[inline]
    fn see_between(&mut self, [x, y]: [f64; 2], up: [f64; 2], at: At) {
        let now = Sample { values: [x * x + y * y, x.abs(), y.abs(), (x * up[0] + y * up[1]).max(0.0)], at };
        let [first, middle] = self.last;
        if self.samples == 2 {
            let [px, py] = &mut self.components;
            for (i, peak) in [&mut self.square, px, py, &mut self.upward].into_iter().enumerate() {
                let [a, b, c] = [first, middle, now].map(|sample| sample.values[i]);
                // the error of a poorly sampled peak is below one per cent
                let counts = b > a && b >= c && peak.value.is_none_or(|largest| b > 0.99 * largest);
                if counts {
                    let (time, value) = vertex([a, b, c], [first.at.time, middle.at.time, at.time]);
                    peak.see(value, At { time, speed: middle.at.speed });
                }
            }
        }
        self.last = [middle, now];
        self.samples = (self.samples + 1).min(2);
    }

    fn hold(&mut self) {
        self.square.hold();
        self.components.iter_mut().for_each(Peak::hold);
        self.upward.hold();
    }

    /// Reports the component columns. `what`: "bearing" or "pedestal"; `of`: the bodies between which the force acts.
    fn report(&self, what: &str, of: &str, row: &mut Row<'_>) {
        for (axis, peak) in ["x", "y"].into_iter().zip(self.components) {
            row.peak(
                format_args!("max_{what}_force_{axis}_{}", self.name),
                "N",
                format_args!("largest size of the force {of} along {}", axis.to_uppercase()),
                Some(peak),
            );
        }
        row.peak(
            format_args!("max_upward_{what}_force_{}", self.name),
            "N",
            format_args!("largest force {of} against gravity (along +Y without gravity); 0 where it never points up"),
            Some(self.upward),
        );
    }
}

impl LoadRecorder {
    pub fn new(rotor: &Rotor) -> Self {
        let [x, y] = rotor.gravity;
        let size = libm::hypot(x, y);
        let bearings = || rotor.bearings.iter();
        Self {
            bearings: bearings().map(|bearing| Watched::new(&bearing.name)).collect(),
            pedestals: bearings()
                .filter(|bearing| bearing.pedestal.is_some())
                .map(|bearing| Watched::new(&bearing.name))
                .collect(),
            any: Peak::default(),
            up: if size > 0.0 { [-x / size, -y / size] } else { [0.0, 1.0] },
        }
    }

    /// Records the loads of an instant.
    #[inline]
    pub fn see(&mut self, loads: Loads<'_>, at: At) {
        for (watched, load) in self.bearings.iter_mut().zip(loads.bearings) {
            let square = watched.see(*load, self.up, at);
            self.any.see(square, at);
        }
        for (watched, load) in self.pedestals.iter_mut().zip(loads.pedestals) {
            watched.see(*load, self.up, at);
        }
    }

    /// Records the interpolated peaks between the last three instants, for an engine with long steps; `loads` belongs to the last instant
    /// and is already recorded. `smooth`: no impulse acts at this instant.
    #[inline]
    pub fn see_between(&mut self, loads: Loads<'_>, at: At, smooth: bool) {
        if !smooth {
            self.bearings.iter_mut().chain(&mut self.pedestals).for_each(|watched| watched.samples = 0);
            return;
        }
        for (watched, load) in self.bearings.iter_mut().zip(loads.bearings) {
            watched.see_between(*load, self.up, at);
            self.any.include(&watched.square);
        }
        for (watched, load) in self.pedestals.iter_mut().zip(loads.pedestals) {
            watched.see_between(*load, self.up, at);
        }
    }

    /// Marks the values reached so far as guarded.
    pub fn hold(&mut self) {
        self.bearings.iter_mut().chain(&mut self.pedestals).for_each(Watched::hold);
        self.any.hold();
    }

    /// Largest load of all bearings \[N\]; `None` without a recorded load.
    pub fn largest(&self) -> Option<f64> {
        self.any.map(f64::sqrt).value.filter(|load| load.is_finite())
    }

    pub(super) fn report(&self, row: &mut Row<'_>) {
        let has_bearings = !self.bearings.is_empty();
        row.with(Empty::Absent, (!has_bearings).then_some("a bearing"), |row| {
            row.peak(
                "max_bearing_load",
                "N",
                "largest bearing load of all bearings, norm in the X-Y plane",
                has_bearings.then(|| self.any.map(f64::sqrt)),
            );
        });
        for Watched { name, square, .. } in &self.bearings {
            row.peak(
                format_args!("max_bearing_load_{name}"),
                "N",
                format_args!("largest load of bearing {name}, norm in the X-Y plane"),
                Some(square.map(f64::sqrt)),
            );
        }
        for Watched { name, square, .. } in &self.pedestals {
            row.peak(
                format_args!("max_pedestal_load_{name}"),
                "N",
                format_args!("largest load of the pedestal of bearing {name}, norm in the X-Y plane"),
                Some(square.map(f64::sqrt)),
            );
        }
    }

    /// Reports the components, after the columns that older builds also had.
    pub(super) fn report_components(&self, row: &mut Row<'_>) {
        for watched in &self.bearings {
            watched.report("bearing", &format!("on bearing {}", watched.name), row);
        }
        for watched in &self.pedestals {
            watched.report("pedestal", &format!("of the pedestal of bearing {} on the ground", watched.name), row);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vertex_of_unequal_steps_is_that_of_the_parabola() {
        let parabola = |t: f64| 3.0 - 2.0 * (t - 0.7) * (t - 0.7);
        let times = [0.2, 0.6, 1.4];
        let (time, value) = vertex(times.map(parabola), times);
        assert!((time - 0.7).abs() < 1e-15 && (value - 3.0).abs() < 1e-15, "{time} {value}");
    }
}
