//! A run without a number excludes its block and nothing else.

use super::support::{DELTA, ishigami, names, points, saltelli, trajectories};
use bladeoff_answers::sensitivity::{Given, Input, Parts, given_data, morris, sobol};

#[test]
fn a_bad_run_takes_its_base_point_out() {
    let base = points(8, 40, 6);
    let mut rows = saltelli(ishigami, &base, false);
    // B of point 0, AB_2 and AB_3 of point 17, A of the last
    for row in [4, 17 * 5 + 2, 17 * 5 + 3, 39 * 5] {
        rows[row] = None;
    }
    let found = sobol(&names(3), &rows, false, 0.05).expect("indices");
    let kept: Vec<Vec<f64>> =
        base.iter().enumerate().filter(|(j, _)| ![0, 17, 39].contains(j)).map(|(_, p)| p.clone()).collect();
    let clean = sobol(&names(3), &saltelli(ishigami, &kept, false), false, 0.05).expect("indices");
    assert_eq!((found.n, found.left_out, clean.left_out), (37, 3, 0));
    assert_eq!(found.of, clean.of);
    assert_eq!(found.notes, ["4 runs without a number: 3 of 40 base points left out (7.5 %)"]);
    // NaN is not a number, and an incomplete block is ignored
    rows[4] = Some(f64::NAN);
    assert_eq!(sobol(&names(3), &rows, false, 0.05).expect("indices").of, clean.of);
    rows.extend([Some(1.0), Some(2.0)]);
    assert_eq!(sobol(&names(3), &rows, false, 0.05).expect("indices").of, clean.of);
}

#[test]
fn a_bad_run_takes_its_trajectory_out() {
    let (mut rows, moves) = trajectories(&ishigami, 3, 20, 3);
    let (short, short_moves) = (rows[4..].to_vec(), moves[4..].to_vec());
    rows[2] = None;
    let found = morris(&names(3), &rows, &moves, DELTA, 0.05).expect("effects");
    let clean = morris(&names(3), &short, &short_moves, DELTA, 0.05).expect("effects");
    assert_eq!((found.n, found.left_out), (19, 1));
    assert_eq!(found.of, clean.of);
    assert_eq!(found.notes, ["1 run without a number: 1 of 20 trajectories left out (5 %)"]);
    rows.fill(None);
    let none = morris(&names(3), &rows, &moves, DELTA, 0.05).expect("effects");
    assert!(none.n == 0 && none.of.iter().all(|(_, of)| of.mu_star.is_some_and(|index| index.estimate.is_none())));
}

#[test]
fn a_bad_row_of_a_random_table_is_left_out() {
    let base = points(8, 400, 3);
    let columns: Vec<Vec<f64>> = (0..3).map(|i| base.iter().map(|u| u[i]).collect()).collect();
    let mut output: Vec<Option<f64>> = base.iter().map(|u| Some(ishigami(u))).collect();
    output[7] = None;
    output[399] = Some(f64::INFINITY);
    let given = |columns: &[Vec<f64>], output: &[Option<f64>]| {
        let input = |(name, values)| Input { name, values, has_words: false };
        let inputs = names(3).into_iter().zip(columns.iter().map(Vec::as_slice)).map(input).collect();
        given_data(&Given { inputs, output, parts: Parts::Independent }, 0.05).expect("figures")
    };
    let found = given(&columns, &output);
    let kept =
        |list: &[f64]| list.iter().enumerate().filter(|(row, _)| ![7, 399].contains(row)).map(|(_, x)| *x).collect();
    let columns: Vec<Vec<f64>> = columns.iter().map(|list| kept(list)).collect();
    let output: Vec<Option<f64>> = base.iter().map(|u| Some(ishigami(u))).collect();
    let output: Vec<Option<f64>> =
        output.into_iter().enumerate().filter(|(row, _)| ![7, 399].contains(row)).map(|(_, y)| y).collect();
    let clean = given(&columns, &output);
    assert_eq!((found.n, found.left_out), (398, 2));
    assert_eq!((found.of, found.r2), (clean.of, clean.r2));
    assert_eq!(found.notes[0], "2 runs without a number: 2 of 400 rows left out (0.5 %)");
}
