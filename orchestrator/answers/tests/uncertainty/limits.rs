//! Limits compared with those of Clopper and Pearson by mpmath, and published ranks.

use bladeoff_answers::estimate::limits::{band, lower_limit, lower_order, upper_limit, upper_order, wilks};

#[test]
fn limits_of_a_probability_are_those_of_the_reference() {
    let (mut count, mut worst) = (0, 0.0f64);
    for line in include_str!("support/clopper_pearson.csv").lines().filter(|line| !line.starts_with(['#', 'n'])) {
        let cells: Vec<&str> = line.split(';').collect();
        let whole = |at: usize| cells[at].parse::<u64>().expect("a count");
        let number = |at: usize| cells[at].parse::<f64>().expect("a number");
        let (n, k, alpha, expected) = (whole(0), whole(1), number(2), number(4));
        // the reference used 1 - alpha/2 rounded to a double for the upper limits, which changes those of 1e-6 by 5e-12
        let rounded = 1.0 - (1.0 - alpha / 2.0);
        let found = if cells[3] == "l" { lower_limit(k, n, alpha / 2.0) } else { upper_limit(k, n, rounded) };
        let off = if expected == 0.0 { found.abs() } else { (found / expected - 1.0).abs() };
        // for large n the continued fraction of the beta function begins next to 1 and loses digits in proportion
        assert!(off < (2e-18 * n as f64).max(1e-12), "{line}: {found:e}, off by {off:e}");
        worst = worst.max(off);
        count += 1;
    }
    println!("{count} limits, worst {worst:e}");
    assert!(count > 100, "{count}");
    // 1 - (5e-7)^(1/100), with 30 digits
    assert!((upper_limit(0, 100, 5e-7) / 0.135_052_595_015_716_6 - 1.0).abs() < 1e-15);
    assert_eq!((lower_limit(0, 10, 0.05), upper_limit(10, 10, 0.05)), (0.0, 1.0));
}

#[test]
fn order_statistics_are_the_published_ones() {
    // S. S. Wilks (1941): numbers of samples whose r-th largest is above the 95 % quantile at level 95 %
    for (order, n) in [(1, 59), (2, 93), (3, 124), (4, 153), (5, 181)] {
        assert_eq!(upper_order(0.95, n, 0.05), Some(n + 1 - order));
        assert_eq!(upper_order(0.95, n - 1, 0.05), Some(n + 1 - order).filter(|_| order > 1));
    }
    assert_eq!((wilks(0.05, 0.05), wilks(0.5, 0.25), wilks(0.5, 0.125), wilks(0.9, 0.5)), (59.0, 2.0, 3.0, 1.0));
    assert_eq!((lower_order(0.5, 100, 0.025), upper_order(0.5, 100, 0.025)), (Some(40), Some(61)));
    assert_eq!(lower_order(0.5, 3, 0.01), None);
    // ln(0.025)/ln(1 - p): mpmath, 30 digits
    for (beyond, n) in [(1e-6, 3_688_878.0), (1e-15, 3_688_879_454_113_934.0), (1e-17, 3.688_879_454_113_936e17)] {
        assert!((wilks(beyond, 0.025) / n - 1.0).abs() < 1e-15, "{beyond}: {}", wilks(beyond, 0.025));
    }
    assert!((wilks(1e-300, 0.025) / 3.688_879_454_113_936e300 - 1.0).abs() < 1e-15);
    assert!((band(1000, 0.05) - (40f64.ln() / 2000.0).sqrt()).abs() < 1e-15);
}
