//! Quantiles against values with 60 digits and closed forms, and against their inverse functions.

use super::*;

fn off(found: f64, expected: f64) -> f64 {
    if expected == 0.0 { found.abs() } else { (found / expected - 1.0).abs() }
}

#[test]
fn quantiles_and_tails_are_those_of_the_reference() {
    let text = include_str!("../../tests/reference/quantiles.csv");
    let (mut worst, mut count) = (0.0f64, 0);
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let cells: Vec<&str> = line.split(';').collect();
        let number = |cell: &str| cell.parse::<f64>().expect("a number");
        let shape = |place: usize| number(cells[1].split(' ').nth(place).expect("a parameter"));
        let tails: &dyn Fn(f64) -> (f64, f64) = match cells[0] {
            "normal" => &normal_tails,
            "gamma" => &|x| gamma_tails(shape(0), x),
            "beta" => &|x| beta_tails(shape(0), shape(1), x),
            _ => continue,
        };
        let (p, expected) = (number(cells[2]), number(cells[3]));
        let q = 1.0 - p;
        let found = match cells[0] {
            "normal" => normal_quantile(p, q),
            "gamma" => gamma_quantile(shape(0), p, q),
            _ => beta_quantile(shape(0), shape(1), p, q).0,
        };
        assert!(off(found, expected) < 1e-12, "{line}: {found:e}");
        (worst, count) = (worst.max(off(found, expected)), count + 1);
        // inverse, if the argument has the digits that the probability needs
        if found > 1e-290 && found < 1.0 {
            let (below, above) = tails(found);
            let back = if p <= 0.5 { off(below, p) } else { off(above, q) };
            assert!(back < 1e-9, "{line}: {below:e} {above:e}");
        }
    }
    println!("{count} quantiles, worst {worst:e}");
    assert_eq!(count, 126);
}

/// Limits of a probability from a few events in a million, where logarithms of the gamma function would lose nine digits.
#[test]
fn beta_quantiles_keep_their_digits_where_parameters_are_large() {
    // a, b, p, x: Clopper and Pearson's limits by mpmath, for the decimal p
    let cases = [
        (1.0, 1_000_000.0, 0.025, 2.531_780_766_379_418e-8),
        (2.0, 999_999.0, 0.025, 2.422_093_703_160_032e-7),
        (10.0, 999_991.0, 0.025, 4.795_398_777_545_603e-6),
        (11.0, 999_990.0, 1.0 - 5e-7, 3.538_492_889_062_461e-5),
        (10.0, 999_991.0, 5e-7, 1.181_100_285_000_875e-6),
    ];
    for (a, b, p, expected) in cases {
        let q = if p > 0.5 { 5e-7 } else { 1.0 - p };
        let (x, y) = beta_quantile(a, b, p, q);
        assert!(off(x, expected) < 1e-12, "{a} {b} {p}: {x:e}");
        let (mirrored, complement) = beta_quantile(b, a, q, p);
        assert_eq!((mirrored, complement), (y, x));
    }
}

#[test]
fn tails_are_the_closed_forms_and_add_up_to_one() {
    for x in [1e-200, 1e-9, 0.1, 0.5, 0.9, 0.999_999] {
        for a in [0.1f64, 1.0, 7.0, 300.0] {
            let (below, above) = beta_tails(a, 1.0, x);
            let expected = x.powf(a);
            assert!(expected < 1e-290 || off(below, expected) < 1e-12, "{a} {x}: {below:e}");
            assert!((below + above - 1.0).abs() < 1e-15);
        }
        let (below, above) = gamma_tails(1.0, x);
        assert!(off(below, -libm::expm1(-x)) < 1e-12 && off(above, libm::exp(-x)) < 1e-12);
    }
    assert_eq!((beta_tails(2.0, 3.0, 0.0), beta_tails(2.0, 3.0, 1.0)), ((0.0, 1.0), (1.0, 0.0)));
    assert_eq!(gamma_tails(2.0, -1.0), (0.0, 1.0));
    assert_eq!((normal_quantile(0.0, 1.0), normal_quantile(1.0, 0.0)), (f64::NEG_INFINITY, f64::INFINITY));
    assert_eq!((gamma_quantile(2.0, 0.0, 1.0), gamma_quantile(2.0, 1.0, 0.0)), (0.0, f64::INFINITY));
    assert_eq!(normal_quantile(0.5, 0.5), 0.0);
}

#[test]
fn students_t_is_the_closed_form_of_few_freedoms_and_normal_for_many() {
    for alpha in [1e-9, 1e-3, 0.05, 0.3, 0.9] {
        let one = 1.0 / libm::tan(0.5 * core::f64::consts::PI * alpha);
        // P(|T| < t) = t/sqrt(2 + t^2)
        let two = (1.0 - alpha) * libm::sqrt(2.0 / (alpha * (2.0 - alpha)));
        assert!(off(student(1.0, alpha), one) < 1e-12, "{alpha}: {}", student(1.0, alpha));
        assert!(off(student(2.0, alpha), two) < 1e-12, "{alpha}: {}", student(2.0, alpha));
        // Abramowitz and Stegun 26.7.5
        let (z, nu) = (-normal_quantile(0.5 * alpha, 1.0 - 0.5 * alpha), 1e6);
        let square = z * z;
        let many = z + z * (square + 1.0) / (4.0 * nu) + z * ((5.0 * square + 16.0) * square + 3.0) / (96.0 * nu * nu);
        assert!(off(student(nu, alpha), many) < 1e-12, "{alpha}: {}", student(nu, alpha));
    }
    // the printed tables
    assert!((student(15.0, 0.05) - 2.131_449_546).abs() < 1e-9 && (student(31.0, 0.05) - 2.039_513_446).abs() < 1e-9);
}

/// A search that alternates between two neighbouring numbers ends when its state repeats; without that rule it needed 200 rounds, 36 us per quantile.
#[test]
fn a_beta_quantile_is_found_in_few_rounds() {
    use std::cell::Cell;
    let rounds = Cell::new(0u32);
    // ln p of x^2 alternates for many p; every round is counted
    let count = 2000;
    for number in 1..count {
        let p = f64::from(number) / f64::from(count);
        let found = super::root::solve(super::root::Tail::smaller(p, 1.0 - p), -20.0, 0.0, |t| {
            rounds.set(rounds.get() + 1);
            let ln = 2.0 * t;
            (ln, super::beta::other(ln), ln + std::f64::consts::LN_2)
        });
        assert!(off(libm::exp(found), p.sqrt()) < 1e-14, "{p}");
    }
    assert!(rounds.get() < 15 * count as u32, "{}", rounds.get());
    let beta = Beta::new(2.0, 3.0);
    assert_eq!(beta.parameters(), (2.0, 3.0));
    assert_eq!(beta.quantile(0.3, 0.7), beta_quantile(2.0, 3.0, 0.3, 0.7));
}
