//! The compared quantities, and the format of their numbers.

use super::done::Done;
use super::separation::Spread;
use bladeoff_model::machine::Detection;

/// The contact detections, in the order of the paper's columns.
pub(super) const DETECTIONS: [&str; 3] = Detection::WORDS;

/// A row of the table.
pub(super) struct Quantity {
    pub name: &'static str,
    /// The paper's values for hyp1, hyp2, hyp2-frozen in the displayed unit; `None`: the paper has no such row.
    pub paper: Option<[f64; 3]>,
    /// The value of this program in the displayed unit.
    pub ours: fn(&Done) -> Option<f64>,
}

pub(super) const CPU: Quantity =
    Quantity { name: "CPU time [s]", paper: Some([7742.0, 24743.0, 6845.0]), ours: |run| Some(run.cpu) };
pub(super) const LOAD: Quantity = Quantity {
    name: "max load on bearing [1e5 N]",
    paper: Some([5.46, 4.95, 5.36]),
    ours: |run| Some(run.value("max_bearing_load_N")? * 1e-5),
};
pub(super) const FORCE: Quantity = Quantity {
    name: "max contact force [MN]",
    paper: Some([3.49, 4.29, 7.53]),
    ours: |run| Some(run.value("max_contact_force_N")? * 1e-6),
};
pub(super) const PENETRATION: Quantity = Quantity {
    name: "residual penetration [1e-2 mm]",
    paper: Some([5.88, 6.75, 12.36]),
    ours: |run| Some(run.value("residual_penetration_m")? * 1e5),
};
pub(super) const MEAN_FORCE: Quantity = Quantity {
    name: "max contact force, 1 ms mean [MN]",
    paper: None,
    ours: |run| Some(run.value("max_filtered_contact_force_N")? * 1e-6),
};

/// Three significant digits, four from 100 on.
pub(super) fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e5).contains(&size) {
        return format!("{value:.1e}");
    }
    let decimals = (2 - size.log10().floor() as i32).max(1) as usize;
    let decimals = if size >= 1e3 { 0 } else { decimals };
    format!("{value:.decimals$}")
}

/// A ratio; if the smaller value is only rounding error, a lower bound.
pub(super) fn ratio(large: f64, small: f64) -> String {
    if large > 1e6 * small { "×>1e6".to_owned() } else { format!("×{}", digits(large / small)) }
}

pub(super) fn spreads(done: &[Done], engine: &str, quantity: &Quantity) -> [Option<Spread>; 3] {
    DETECTIONS.map(|detection| Spread::of(done, engine, detection, quantity.ours))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_three_digits() {
        for (value, text) in
            [(13.0, "13.0"), (1.0, "1.00"), (118.23, "118.2"), (7742.0, "7742"), (2.2e-10, "2.2e-10"), (0.0, "0")]
        {
            assert_eq!(digits(value), text);
        }
        assert_eq!(ratio(6.5, 2e-10), "×>1e6");
    }

    #[test]
    fn the_paper_s_numbers_are_the_paper_s() {
        assert_eq!(CPU.paper, Some([7742.0, 24743.0, 6845.0]));
        assert_eq!(LOAD.paper, Some([5.46, 4.95, 5.36]));
        assert_eq!(FORCE.paper, Some([3.49, 4.29, 7.53]));
        assert_eq!(PENETRATION.paper, Some([5.88, 6.75, 12.36]));
    }
}
