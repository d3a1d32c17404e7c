//! The reference table that `bladeoff verify` prints.

use bladeoff_core::verification::{Check, verify};
use std::sync::OnceLock;

/// All checks, computed once for all tests.
fn checks() -> &'static [Check] {
    static CHECKS: OnceLock<Vec<Check>> = OnceLock::new();
    CHECKS.get_or_init(verify)
}

#[test]
fn every_reference_case_holds() {
    let checks = checks();
    for check in checks {
        println!(
            "{:36} {:12} {:36} {:?} {} {:.1e} of {:.1e}",
            check.case,
            check.engine,
            check.quantity,
            check.ours,
            check.reference,
            check.error().unwrap_or(f64::NAN),
            check.tolerance
        );
    }
    let broken: Vec<_> = checks.iter().filter(|check| !check.holds()).collect();
    assert!(broken.is_empty(), "{broken:#?}");
    assert!((25..=150).contains(&checks.len()), "{}", checks.len());
}

#[test]
fn the_table_would_notice_a_wrong_number() {
    // a reference that is changed by a few tolerances must fail
    for check in checks() {
        let mut check = check.clone();
        check.reference *= 1.0 + 5.0 * check.tolerance;
        assert!(!check.holds(), "{check:?}");
    }
}
