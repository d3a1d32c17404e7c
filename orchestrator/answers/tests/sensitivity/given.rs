//! Indices that need no design, compared with other programs, with manual calculations and over all permutations.

use super::support::{ISHIGAMI, figure, holds, ishigami, names, near, points};
use bladeoff_answers::sensitivity::{
    FEWEST_FOR_SUCCESSORS, Given, Input, MOST_ROWS, Parts, SensitivityError, Similar, dependence, first_order_by_ranks,
    given_data, midranks, rank_regression, spearman,
};

/// Three columns, the first two with ties, the last with four values, and an output computed from them.
fn made() -> ([Vec<f64>; 3], Vec<f64>) {
    let column = |of: fn(usize) -> usize| (0..60).map(|row| of(row) as f64).collect::<Vec<f64>>();
    let x = [column(|j| 37 * j % 101), column(|j| j * j % 53), column(|j| j % 4)];
    let y = (0..60).map(|j| x[0][j] * x[0][j] + 100.0 * x[1][j] + 50.0 * (j % 7) as f64 - 300.0 * x[2][j]).collect();
    (x, y)
}

#[test]
fn equal_values_share_their_rank() {
    assert_eq!(midranks(&[3.0, 1.0, 3.0, -2.0, 3.0, -0.0, 0.0]), [6.0, 4.0, 6.0, 1.0, 6.0, 2.5, 2.5]);
    assert_eq!(spearman(&[1.0, 2.0, 3.0, 4.0], &[1.0, 8.0, 27.0, 64.0]), Some(1.0));
    assert_eq!(spearman(&[1.0, 2.0, 3.0], &[5.0, 5.0, 5.0]), None);
}

/// Reference values from NumPy 2.4 and SciPy 1.17 (`spearmanr`; `lstsq` of standardised `rankdata`; matrices written out).
#[test]
fn figures_are_those_of_other_programs() {
    let (x, y) = made();
    let close = |found: f64, expected: f64| {
        assert!((found - expected).abs() < 1e-12 * expected.abs().max(1e-3), "{found} {expected}")
    };
    for (x, expected) in x.iter().zip([0.8665184773548209, 0.5817475246850282, -0.02496269329042719]) {
        close(spearman(x, &y).expect("a correlation"), expected);
    }
    let found = rank_regression(&[&x[0], &x[1], &x[2]], &y);
    let (coefficients, r2) = found.coefficients.expect("a regression");
    for (found, expected) in coefficients.iter().zip([0.7917107109200668, 0.44719463233523843, -0.09395528922864867]) {
        close(found.expect("a coefficient"), expected);
    }
    close(r2, 0.9485317072134429);
    for (x, expected) in x.iter().zip([0.7720181978018346, 0.4003439698005141, -0.23993985091823]) {
        close(first_order_by_ranks(x, &y).expect("an index"), expected);
    }
    for (x, similar, hsic, normalised, p_value) in [
        (&x[0], Similar::Near, 0.06042058335019465, 0.6729086789616037, 5.66505385989677e-18),
        (&x[1], Similar::Near, 0.01695256772071728, 0.17667818640898428, 0.00023773941038843132),
        (&x[2], Similar::Same, 0.000993923598685164, 0.008125148619753546, 0.9906027475224678),
    ] {
        let found = dependence(x, similar, &y).expect("a dependence");
        close(found.hsic, hsic);
        close(found.normalised, normalised);
        assert!((found.p_value - p_value).abs() < 1e-9 * p_value, "{}", found.p_value);
    }
}

/// Values around 1e14 with a scatter of some thousands: an offset of a column changes no index.
#[test]
fn an_offset_changes_nothing() {
    let (x, y) = made();
    let off = |values: &[f64]| values.iter().map(|value| value + 1e14).collect::<Vec<f64>>();
    let far = off(&y);
    for x in &x {
        assert_eq!(first_order_by_ranks(x, &far), first_order_by_ranks(x, &y));
        assert_eq!(first_order_by_ranks(&off(x), &far), first_order_by_ranks(x, &y));
        let (near, apart) = (dependence(x, Similar::Near, &y), dependence(&off(x), Similar::Near, &far));
        assert_eq!((near.is_some(), near), (true, apart));
    }
}

/// Manual calculation: ranks of x 2 0 3 1, so y in order is 4 1 3 2, mean 2.5; squares of successive differences 9 + 4 + 1 over twice 5.
#[test]
fn successors_by_hand() {
    let found = first_order_by_ranks(&[0.5, 0.1, 0.9, 0.3], &[3.0, 4.0, 2.0, 1.0]).expect("an index");
    assert!((found - -4.0 / 10.0).abs() < 1e-15, "{found}");
    assert_eq!(first_order_by_ranks(&[1.0, 2.0], &[3.0, 3.0]), None);
}

/// A parameter that is the only driver of the output: 95 % intervals contain its index for random points, Latin hypercubes and Sobol
/// points. With the smallest value as the successor of the largest, the index was 6/n too small, and no interval contained it.
#[test]
fn the_index_of_an_only_driver_is_held() {
    let exact = 1.0 / (1.0 + 0.05 * 0.05);
    for n in [256_usize, 1024] {
        let mut held = 0;
        for seed in 0..20 {
            let points = points(100 + seed, n, 2);
            let output: Vec<Option<f64>> = points.iter().map(|u| Some(u[1] + 0.05 * u[0])).collect();
            let columns = columns(&points);
            let found = given_data(&given(&columns, &output), 0.05).expect("indices");
            let first = found.of[1].1.first.expect("an index");
            let (low, high) = (first.low.expect("a limit"), first.high.expect("a limit"));
            held += usize::from((low..=high).contains(&exact));
            assert!((first.estimate.expect("an estimate") - exact).abs() < 4.0 / n as f64, "{n}: {first:?}");
        }
        println!("{n} points: {held} of 20");
        assert!(held >= 16, "{n} points: {held} of 20");
    }
}

#[test]
fn hsic_has_the_moments_of_all_permutations() {
    let (x, y) = ([0.1, 0.9, 0.4, 0.45, 2.0, 0.0, -1.0], [1.0, 5.0, 2.0, 2.5, 2.4, -1.0, 0.5]);
    for similar in [Similar::Near, Similar::Same] {
        let x = if similar == Similar::Same { [0.0, 1.0, 1.0, 2.0, 0.0, 1.0, 0.0] } else { x };
        let mut all = Vec::new();
        permute(&mut y.clone(), 0, &mut |y| all.push(dependence(&x, similar, y).expect("a dependence").hsic));
        assert_eq!(all.len(), 5040);
        let mean = all.iter().sum::<f64>() / 5040.0;
        let variance = all.iter().map(|one| (one - mean) * (one - mean)).sum::<f64>() / 5040.0;
        let (expected, scatter) = dependence(&x, similar, &y).expect("a dependence").moments;
        assert!((mean - expected).abs() < 1e-12 * mean && (variance - scatter).abs() < 1e-9 * variance, "{similar:?}");
    }
    assert_eq!(dependence(&[1.0; 7], Similar::Near, &y), None);
    assert_eq!(dependence(&x[..3], Similar::Near, &y[..3]), None);
}

fn permute(values: &mut [f64], from: usize, see: &mut dyn FnMut(&[f64])) {
    if from == values.len() {
        return see(values);
    }
    for other in from..values.len() {
        values.swap(from, other);
        permute(values, from + 1, see);
        values.swap(from, other);
    }
}

fn columns(points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    (0..points[0].len()).map(|i| points.iter().map(|u| u[i]).collect()).collect()
}

fn given<'a>(columns: &'a [Vec<f64>], output: &'a [Option<f64>]) -> Given<'a> {
    let input = |(name, values)| Input { name, values, has_words: false };
    let inputs = names(columns.len()).into_iter().zip(columns.iter().map(Vec::as_slice)).map(input).collect();
    Given { inputs, output, parts: Parts::Independent }
}

#[test]
fn a_random_table_tells_first_orders_and_dependences() {
    let base = points(11, 5000, 4);
    let columns = columns(&base);
    let output: Vec<Option<f64>> = base.iter().map(|u| Some(ishigami(u))).collect();
    let found = given_data(&given(&columns, &output), 0.002).expect("figures");
    assert_eq!((found.n, found.interval), (5000, "replicates-t"));
    for i in 0..4 {
        let exact = ISHIGAMI.get(i).map_or(0.0, |of| of.0);
        near(figure(&found, i, |of| of.first), exact, 0.07);
        holds(figure(&found, i, |of| of.first), exact);
    }
    // the third acts only through the first: no first order, no rank correlation, but a dependence; the fourth has no effect
    let p_value = |i: usize| found.of[i].1.hsic.expect("a dependence").p_value;
    assert!(p_value(0) < 1e-6 && p_value(1) < 1e-6 && p_value(2) < 1e-6 && p_value(3) > 0.01, "{:?}", found.of);
    assert!(figure(&found, 2, |of| of.spearman).estimate.expect("a correlation").abs() < 0.1);
    let r2 = found.r2.expect("a regression").estimate.expect("R2");
    assert!(r2 > 0.1 && r2 < 0.3, "{r2}");
    assert_eq!(found.notes, [format!("HSIC of the first {MOST_ROWS} rows")]);
    assert_eq!(found, given_data(&given(&columns, &output), 0.002).expect("the same"));
}

#[test]
fn words_have_no_order() {
    let base = points(2, 600, 2);
    let mut columns = columns(&base);
    columns[1].iter_mut().for_each(|u| *u = (3.0 * *u).floor());
    // the middle word has the large value: no trend
    let value = |row: usize| columns[0][row] + if columns[1][row] == 1.0 { 1.0 } else { 0.0 };
    let output: Vec<Option<f64>> = (0..600).map(|row| Some(value(row))).collect();
    let mut table = given(&columns, &output);
    table.inputs[1].has_words = true;
    let found = given_data(&table, 0.05).expect("figures");
    let words = &found.of[1].1;
    assert!(words.spearman.is_none() && words.rank_regression.is_none());
    // 2/9 of 2/9 + 1/12
    near(words.first.expect("a first order"), 8.0 / 11.0, 0.06);
    assert!(words.hsic.expect("a dependence").p_value < 1e-6);
    assert!(found.notes.iter().any(|note| note.contains("the regression leaves them out")), "{:?}", found.notes);
    holds(figure(&found, 0, |of| of.first), 3.0 / 11.0);
}

#[test]
fn replicates_tell_the_scatter_where_there_are_sixteen() {
    let base = points(2, 640, 2);
    let columns = columns(&base);
    let output: Vec<Option<f64>> = base.iter().map(|u| Some(u[0] + 0.3 * u[1])).collect();
    let table = |parts| Given { parts, ..given(&columns, &output) };
    let replicate: Vec<u32> = (0..640).map(|row| row % 16).collect();
    let all = given_data(&table(Parts::Replicates(&replicate, 16)), 0.05).expect("figures");
    // independent points are split into every sixteenth row; a first order has another interval with replicates
    let alone = given_data(&table(Parts::Independent), 0.05).expect("figures");
    assert_eq!((figure(&all, 0, |of| of.spearman), all.r2), (figure(&alone, 0, |of| of.spearman), alone.r2));
    let first = [&all, &alone].map(|found| figure(found, 0, |of| of.first));
    assert!(first[0].estimate == first[1].estimate && first[0].low != first[1].low, "{first:?}");
    let few: Vec<u32> = (0..640).map(|row| row % 4).collect();
    let found = given_data(&table(Parts::Replicates(&few, 4)), 0.05).expect("figures");
    assert!(found.interval == "none" && found.notes[0].contains("4 replicates show too little"), "{:?}", found.notes);
    assert_eq!(figure(&found, 0, |of| of.spearman).low, None);
    let none = given_data(&table(Parts::Without("no sample".to_owned())), 0.05).expect("figures");
    assert!(none.notes[0] == "no sample" && figure(&none, 0, |of| of.first).high.is_none());
    let wrong = given_data(&table(Parts::Replicates(&replicate, 8)), 0.05);
    assert_eq!(wrong, Err(SensitivityError::Part { row: 8, found: 8, parts: 8 }));
}

#[test]
fn what_does_not_vary_or_fit_is_said() {
    let base = points(2, 100, 3);
    let mut columns = columns(&base);
    columns[1].fill(2.0);
    columns[2] = columns[0].iter().map(|u| u * u).collect();
    let output: Vec<Option<f64>> = base.iter().map(|u| Some(u[0])).collect();
    let found = given_data(&given(&columns, &output), 0.05).expect("figures");
    assert_eq!(found.r2, None);
    for words in ["ranks of one parameter follow from those of others", "x1 does not vary", "from 256 rows on"] {
        assert!(found.notes.iter().any(|note| note.contains(words)), "{words}: {:?}", found.notes);
    }
    assert_eq!(FEWEST_FOR_SUCCESSORS, 256);
    assert!(found.of[1].1.first.is_none() && found.of[1].1.hsic.is_none());
    assert_eq!(figure(&found, 0, |of| of.spearman).estimate.map(|rho| (rho - 1.0).abs() < 1e-12), Some(true));
    let flat: Vec<Option<f64>> = vec![Some(1.0); 100];
    let found = given_data(&given(&columns, &flat), 0.05).expect("figures");
    assert!(found.notes[0].contains("does not vary") && found.of[0].1.first.is_none());
    let few = given_data(&given(&columns[..1], &output[..5]), 0.05);
    assert!(matches!(few, Err(SensitivityError::Length { found: 100, rows: 5, .. })), "{few:?}");
    let short = vec![columns[0][..20].to_vec()];
    let found = given_data(&given(&short, &output[..20]), 0.05).expect("figures");
    assert!(found.interval == "none" && found.notes[0].contains("no interval: 20 rows"), "{:?}", found.notes);
    let empty = vec![Vec::new()];
    let nothing = given_data(&given(&empty, &[]), 0.05).expect("figures");
    assert_eq!((nothing.n, nothing.r2), (0, None));
    assert_eq!(given_data(&given(&[], &[]), 0.05), Err(SensitivityError::Parameters));
}
