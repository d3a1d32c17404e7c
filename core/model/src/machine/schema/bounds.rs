//! Bounds of the quantities of a machine, by unit.
//!
//! The bounds are far outside the values of any machine, and far inside the range of the arithmetic: products of several such numbers and their
//! squares stay finite and above zero, and counts of steps and entries stay whole numbers. Without bounds, a file could have a rotor of
//! 1e300 rad/s, whose square is infinite.
//!
//! Verified by `extremes_end_with_a_word` (`core/tests/runs/extremes.rs`).

/// Unit, smallest number above zero, largest number.
const BOUNDS: &[(&str, f64, f64)] = &[
    ("", 1e-30, 1e15),
    ("s", 1e-10, 1e6),
    ("1/s", 1e-12, 1e9),
    ("rad", 1e-12, 1e6),
    ("rad/s", 1e-9, 1e6),
    ("rad/s2", 1e-9, 1e9),
    ("m", 1e-9, 1e6),
    ("m/s", 1e-9, 1e6),
    ("m/s2", 1e-9, 1e6),
    ("kg", 1e-12, 1e9),
    ("kg m2", 1e-15, 1e15),
    ("kg/m3", 1e-9, 1e9),
    ("Pa", 1e-3, 1e18),
    ("N/m", 1e-9, 1e18),
    ("N s/m", 1e-9, 1e18),
    ("N m", 1e-12, 1e15),
    ("N m s", 1e-12, 1e15),
    ("N m s2", 1e-12, 1e15),
];

/// Smallest number above zero and largest number of a quantity in this SI unit.
///
/// # Panics
/// The unit has no bounds; then the table of keys does not compile.
pub(super) const fn of(unit: &str) -> (f64, f64) {
    let mut i = 0;
    while i < BOUNDS.len() {
        if same(BOUNDS[i].0.as_bytes(), unit.as_bytes()) {
            return (BOUNDS[i].1, BOUNDS[i].2);
        }
        i += 1;
    }
    panic!("a unit of a key has bounds here")
}

/// `a == b` in constant expressions.
const fn same(a: &[u8], b: &[u8]) -> bool {
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}
