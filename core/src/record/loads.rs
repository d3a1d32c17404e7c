//! Largest loads of bearings and pedestals: forces of the rotor on a bearing, and of a pedestal on the ground.

use super::Loads;
use super::peak::{At, Peak};
use super::row::Row;
use bladeoff_model::machine::Rotor;
use bladeoff_model::outcome::Empty;

/// Watches the load of each bearing and of each pedestal: its norm in the X-Y plane, both components, and the component against gravity.
#[derive(Debug, Clone)]
pub(crate) struct LoadRecorder {
    bearings: Vec<Watched>,
    /// In the order of the bearings that have one.
    pedestals: Vec<Watched>,
    /// |F|^2 of all bearings.
    any: Peak,
    /// Unit vector against gravity; +Y without gravity.
    up: [f64; 2],
}

/// One bearing or pedestal.
#[derive(Debug, Clone)]
struct Watched {
    /// Name of the bearing.
    name: String,
    /// |F|^2, one root at the end.
    square: Peak,
    /// |F_x| and |F_y|.
    components: [Peak; 2],
    /// Component against gravity, 0 where it points down.
    upward: Peak,
}

impl Watched {
    fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            square: Peak::default(),
            components: [Peak::default(); 2],
            upward: Peak::default(),
        }
    }

    /// Takes a load; returns |F|^2.
    #[inline]
    fn see(&mut self, [x, y]: [f64; 2], up: [f64; 2], at: At) -> f64 {
        let square = x * x + y * y;
        self.square.see(square, at);
        self.components[0].see(x.abs(), at);
        self.components[1].see(y.abs(), at);
        self.upward.see((x * up[0] + y * up[1]).max(0.0), at);
        square
    }

    fn hold(&mut self) {
        self.square.hold();
        self.components.iter_mut().for_each(Peak::hold);
        self.upward.hold();
    }

    /// `what`: "bearing" or "pedestal"; `from`: what the force comes from and acts on.
    fn report(&self, what: &str, of: &str, row: &mut Row<'_>) {
        for (axis, peak) in ["x", "y"].into_iter().zip(self.components) {
            row.peak_of_one(
                format_args!("max_{what}_force_{axis}_{}", self.name),
                "N",
                format_args!("largest size of the force {of} along {}", axis.to_uppercase()),
                Some(peak),
            );
        }
        row.peak_of_one(
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

    /// Takes the loads of an instant.
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

    /// All guards hold.
    pub fn hold(&mut self) {
        self.bearings.iter_mut().chain(&mut self.pedestals).for_each(Watched::hold);
        self.any.hold();
    }

    /// Largest load of all bearings \[N\]; `None` where none has been seen.
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
            row.peak_of_one(
                format_args!("max_bearing_load_{name}"),
                "N",
                format_args!("largest load of bearing {name}, norm in the X-Y plane"),
                Some(square.map(f64::sqrt)),
            );
        }
        for Watched { name, square, .. } in &self.pedestals {
            row.peak_of_one(
                format_args!("max_pedestal_load_{name}"),
                "N",
                format_args!("largest load of the pedestal of bearing {name}, norm in the X-Y plane"),
                Some(square.map(f64::sqrt)),
            );
        }
    }

    /// Number of columns of [`LoadRecorder::report_components`].
    pub(super) fn component_columns(&self) -> usize {
        9 * (self.bearings.len() + self.pedestals.len())
    }

    /// Components, which stand behind the columns that builds without them had.
    pub(super) fn report_components(&self, row: &mut Row<'_>) {
        for watched in &self.bearings {
            watched.report("bearing", &format!("on bearing {}", watched.name), row);
        }
        for watched in &self.pedestals {
            watched.report("pedestal", &format!("of the pedestal of bearing {} on the ground", watched.name), row);
        }
    }
}
