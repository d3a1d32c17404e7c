//! Tests of [`super`]: motion, energy and torques of the torsional modes.

use super::*;

/// Eight modes, damped and undamped, under torques and impulses.
#[test]
fn damping_dissipates_the_work_less_the_energy() {
    for damping in [0.0, 3.0] {
        let modes: Vec<(f64, f64)> = (1..=8).map(|j| (f64::from(j * j) * 100.0, damping)).collect();
        let row = |a: f64, b: f64| -> Vec<f64> { (0..8).map(|j| a + b * f64::from(j)).collect() };
        let rows = [row(0.5, -0.2), row(-0.3, 0.1), row(0.2, 0.05), row(-0.1, 0.07)];
        let mut torsion = TorsionalModes::new(&modes, &rows, 2);
        let step = torsion.step(0.02);
        let mut work = 0.0;
        for n in 0..50 {
            let before = torsion.clone();
            torsion.propagate_free(&step);
            let impulse = if n % 7 == 0 { 1.3 } else { 0.0 };
            let impulses = [impulse, -0.4 * impulse];
            let mut rate = before.rate.clone();
            for (diaphragm, impulse) in impulses.into_iter().enumerate() {
                torsion.apply_impulse(&step, diaphragm, impulse);
                let row = &rows[2 + diaphragm];
                work += impulse * (dot(row, &rate) + 0.5 * impulse * dot(row, row));
                rate.iter_mut().zip(row).for_each(|(rate, row)| *rate += impulse * row);
            }
            let torques = [4.0 * libm::sin(0.3 * f64::from(n)), -2.0];
            torsion.torques().copy_from_slice(&torques);
            torsion.apply_torques(&step);
            for (torque, row) in torques.iter().zip(&rows) {
                work += torque * (torsion.along(row) - before.along(row));
            }
            for (r, row) in rows.iter().enumerate() {
                assert!((torsion.at_row(r)[0] - torsion.along(row)).abs() < 1e-14);
                assert!((torsion.at_row(r)[1] - dot(row, &torsion.rate)).abs() < 1e-13);
            }
        }
        let dissipated = work - torsion.energies().iter().sum::<f64>();
        assert!(
            (dissipated - torsion.dissipation()).abs() < 1e-11,
            "{damping}: {dissipated} {}",
            torsion.dissipation()
        );
        assert!(if damping > 0.0 { dissipated > 0.1 } else { dissipated.abs() < 1e-11 }, "{damping}: {dissipated}");
    }
}

/// The modes turn by up to a third of a turn a step.
#[test]
fn a_steady_train_of_blows_makes_the_static_turn() {
    let (h, impulse) = (0.02, 0.7);
    let modes: Vec<(f64, f64)> = (1..=7).map(|j| (f64::from(j * j) * 200.0, 3.0 + f64::from(j))).collect();
    let row: Vec<f64> = (0..8).map(|j| if j < 7 { 0.5 - 0.2 * f64::from(j) } else { 0.0 }).collect();
    // one behind the last mode
    let mut torsion = TorsionalModes::new(&[modes.as_slice(), &[(1.0, 0.0)]].concat(), &[vec![0.0; 8], row.clone()], 1);
    let (step, static_correction) = (torsion.step(h), torsion.static_correction(0, h));
    for _ in 0..4000 {
        torsion.propagate_free(&step);
        torsion.apply_impulse(&step, 0, impulse);
        torsion.apply_torques(&step);
    }
    let mut most = 0.0_f64;
    for (j, (square, _)) in modes.iter().enumerate() {
        let static_turn = row[j] * impulse / (square * h);
        let found = torsion.displacement()[j] + static_correction[j] * impulse;
        assert!((found / static_turn - 1.0).abs() < 1e-9, "{j}: {found} {static_turn}");
        most = most.max((torsion.displacement()[j] / static_turn - 1.0).abs());
    }
    assert!(most > 0.3, "what a train correction is much: {most}");
    assert!(static_correction[7] == 0.0);
    let fast = TorsionalModes::new(&[[(1e5, 0.1); 1].as_slice(), &[(1.0, 0.0); 7]].concat(), &[vec![0.0; 8], row], 1);
    assert!((fast.static_correction(0, h)[0] * 1e5 * h / 0.5 - 1.0).abs() < 1e-12, "half a turn and more: all of it");
}
