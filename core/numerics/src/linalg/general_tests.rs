//! Matrices of all kinds, checked by the defining equations of eigenvalues and eigenvectors.

use super::Matrix;
use super::general::general_eigen;
use super::mul;

fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
}

/// Checks A z = lambda z to rounding of A.
fn checked(a: &Matrix) -> Vec<[f64; 2]> {
    let n = a.nrows();
    let (values, re, im) = general_eigen(a).expect("ends");
    let (by_re, by_im) = (mul(a, &re), mul(a, &im));
    let rounding = 4e-15 * n as f64 * a.amax();
    for (k, &[p, w]) in values.iter().enumerate() {
        let length = re.column(k).norm_squared() + im.column(k).norm_squared();
        assert!((length - 1.0).abs() < 1e-13, "{n}: {k} {length}");
        for i in 0..n {
            let real = by_re[(i, k)] - p * re[(i, k)] + w * im[(i, k)];
            let imaginary = by_im[(i, k)] - p * im[(i, k)] - w * re[(i, k)];
            assert!(real.abs().max(imaginary.abs()) <= rounding, "{n}: {k} {p} {w}: {real:e} {imaginary:e}");
        }
    }
    let sum: f64 = values.iter().map(|value| value[0]).sum();
    assert!((sum - a.trace()).abs() <= rounding, "{n}: trace {sum}");
    assert!(values.iter().map(|value| value[1]).sum::<f64>().abs() <= rounding, "conjugates both");
    values
}

#[test]
fn pairs_give_the_matrix_back() {
    let mut seed = 1;
    for n in [1, 2, 3, 4, 5, 8, 17, 48, 96, 130] {
        for _ in 0..if n < 20 { 50 } else { 2 } {
            let a = Matrix::from_fn(n, n, |_, _| random(&mut seed));
            checked(&a);
            checked(&Matrix::from_fn(n, n, |i, j| a[(i, j)] * libm::exp2(-(60.0 / n as f64) * (i + j) as f64)));
            checked(&(&a + a.transpose()));
            checked(&(&a - a.transpose()));
            checked(&Matrix::from_fn(n, n, |i, j| if i <= j { a[(i, j)] } else { 0.0 }));
        }
    }
}

#[test]
fn the_roots_of_a_polynomial_are_those_of_its_companion() {
    // z^n = 1: corners of a polygon, where shifts do not change
    for n in [3, 4, 6, 24] {
        let a = Matrix::from_fn(n, n, |i, j| f64::from(u8::from(i == (j + 1) % n)));
        for [re, im] in checked(&a) {
            let turn = libm::atan2(im, re) * n as f64 / (2.0 * std::f64::consts::PI);
            assert!((turn - libm::round(turn)).abs() < 1e-12 && (libm::hypot(re, im) - 1.0).abs() < 1e-13);
        }
    }
}

#[test]
fn pairs_of_equal_motions_without_damping_come_apart() {
    // (omega^-2, y) of two equal planes, over twelve decades: [0 -M; 1 0]
    let mut seed = 7;
    for n in [4, 24, 73, 73, 73] {
        let graded = |i: usize| libm::exp2(-20.0 * i as f64 / n as f64);
        let near = Matrix::from_fn(n, n, |_, _| random(&mut seed));
        let mass = Matrix::from_fn(n, n, |i, j| {
            let own = if i == j { 1.0 } else { 0.0 };
            graded(i) * graded(j) * (own + 0.5 * (near[(i, j)] + near[(j, i)]) / (n as f64).sqrt())
        });
        let mut a = Matrix::zeros(4 * n, 4 * n);
        for row in 0..2 * n {
            a[(2 * n + row, row)] = 1.0;
            for column in (row % 2..2 * n).step_by(2) {
                a[(row, 2 * n + column)] = -mass[(row / 2, column / 2)];
            }
        }
        let values = checked(&a);
        assert!(values.iter().all(|value| value[0].abs() < 1e-7), "{n}: {values:?}");
    }
}

/// Slightly damped and gyroscopic motions, over up to forty decades: such blocks once separated after 300 steps or not at all.
#[test]
fn pairs_of_nearly_equal_motions_come_apart() {
    let mut seed = 11;
    for turn in 0..60 {
        let n = 24;
        let span = 40.0 + 40.0 * f64::from(turn % 4);
        let graded = |i: usize| libm::exp2(-0.5 * span * i as f64 / n as f64);
        let near = Matrix::from_fn(n, n, |_, _| random(&mut seed));
        let gyroscopic = if turn % 3 == 0 { 0.0 } else { 1e-3 * random(&mut seed) };
        let damping = if turn % 5 == 0 { 0.0 } else { 1e-3 * random(&mut seed).abs() };
        let mut a = Matrix::zeros(4 * n, 4 * n);
        for (i, plane) in (0..n).flat_map(|i| [(i, 0), (i, 1)]) {
            let row = 2 * i + plane;
            a[(2 * n + row, row)] = 1.0;
            a[(row, row)] = -damping * graded(i);
            a[(row, 2 * i + 1 - plane)] = if plane == 0 { gyroscopic } else { -gyroscopic } * graded(i);
            for j in 0..n {
                let own = if i == j { 1.0 } else { 0.0 };
                a[(row, 2 * n + 2 * j + plane)] = -graded(i) * graded(j) * (own + 0.1 * (near[(i, j)] + near[(j, i)]));
            }
        }
        checked(&a);
    }
}

#[test]
fn eigenvalues_that_differ_by_little_come_apart_wherever_they_are() {
    let mut seed = 3;
    for n in [3, 4, 8, 24, 40] {
        for (distance, shift) in [(1e-6, 1.0), (1e-9, 1.0), (1e-10, -1.0), (1.0, 1e8)] {
            let near = Matrix::from_fn(n, n, |_, _| random(&mut seed));
            let unit = Matrix::identity(n, n) * shift;
            checked(&(&near * distance + &unit));
            checked(&((&near - near.transpose()) * distance + &unit));
            let turned = Matrix::from_fn(n, n, |i, j| f64::from(u8::from(i == (j + 1) % n)));
            checked(&(turned * distance + &unit));
        }
    }
}

#[test]
fn any_size_of_numbers_will_do() {
    let mut seed = 5;
    for n in [2, 5, 12] {
        let a = Matrix::from_fn(n, n, |_, _| random(&mut seed));
        let (plain, ..) = general_eigen(&a).expect("ends");
        for power in [-1000, -500, 500, 1000] {
            let scale = libm::exp2(f64::from(power));
            let (values, re, im) = general_eigen(&(&a * scale)).expect("ends");
            assert!(
                values.iter().zip(&plain).all(|(value, plain)| value.map(|part| part / scale) == *plain),
                "{power}"
            );
            assert!(re.iter().chain(im.iter()).all(|part| part.is_finite()));
        }
    }
}

#[test]
fn what_has_one_vector_and_what_has_many() {
    assert!(general_eigen(&Matrix::zeros(0, 0)).is_some_and(|(values, ..)| values.is_empty()));
    assert_eq!(checked(&Matrix::zeros(3, 3)), [[0.0; 2]; 3]);
    assert_eq!(checked(&(Matrix::identity(5, 5) * -2.0)), [[-2.0, 0.0]; 5]);
    // a double eigenvalue with one eigenvector
    for value in checked(&Matrix::from_row_slice(2, 2, &[3.0, 0.0, 1.0, 3.0])) {
        assert_eq!(value, [3.0, 0.0]);
    }
    let jordan = Matrix::from_fn(6, 6, |i, j| if i == j { 1.0 } else { f64::from(u8::from(i + 1 == j)) });
    checked(&jordan);
    // almost critically damped
    checked(&Matrix::from_row_slice(2, 2, &[0.0, 1.0, -1.0, -2.0]));
    let mut bad = Matrix::identity(3, 3);
    bad[(2, 0)] = f64::INFINITY;
    assert!(general_eigen(&bad).is_none());
}
