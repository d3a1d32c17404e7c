//! Modes and inverses of a ring of equal sectors, by cyclic symmetry: one small problem for each number of nodal diameters n.
//!
//! ```text
//! x_s = Re(c e^{i n s t}),  t = 2 pi/S                 DOFs of sector s of S, from one blade to the next; n nodal diameters, 0 to S/2
//! A^_n = sum_s A_0s e^{i n s t}                        A x = b  is  A^_n c = b_n;  A_0s: from sector s to sector 0                         (1)
//! c = T y                                              T: columns even or odd about the blade's axis; entry at a node times e^{i n s t}
//! A~_n = T* A^_n T                                     real, because the ring is symmetric about the axis of a blade                       (2)
//! modes        K~ y = omega^2 M~ y;   Re and Im of T y e^{i n s t} are two modes of one frequency, for 0 < n < S/2                          (3)
//! inverses     (A^-1)_0s = 1/S sum over n, and -n, of  T A~_n^-1 T* e^{-i n s t}                                                            (4)
//! ```
//! Source: Bloch waves of a cyclic structure (Thomas, Int. J. Numer. Methods Eng. 14, 1979). A ring without blades has one sector per element. A
//! sector of a turbine's ring has 19 of its 228 degrees of freedom (DOFs), so seven small problems replace a large one. The two modes of a pair have
//! the same frequency to the last digit and the same mode shape, shifted by a quarter of a wavelength.
//! Limits: matrices of rings and of whole mode pairs, which have the same mirror symmetry.
//! Verified by `modes_are_those_of_the_whole_ring`, `inverses_are_those_of_the_whole_ring`.

use bladeoff_numerics::linalg::lanes::add_scaled;
use bladeoff_numerics::linalg::{EigenError, Matrix, column_of, mul, mul_tn, spd_inverse, symmetric_generalised};
use std::ops::Range;

/// Largest difference between corresponding entries of two sectors, as a share of the diagonal: rounding of the ring's modes.
const SAME: f64 = 1e-8;

/// Arrangement of the ring's degrees of freedom (DOFs) in sectors.
#[derive(Debug, Clone, PartialEq)]
pub struct Sectors {
    /// Number of sectors S.
    pub count: usize,
    /// DOFs of one sector: first those of its arc of the ring, then those inside its blade.
    freedoms: Vec<Freedom>,
    /// Number of the DOFs of a sector on the ring.
    of_ring: usize,
}

/// One DOF of a sector.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Freedom {
    /// Index of the mirror-image DOF, which may belong to the neighbouring sector.
    mirror: usize,
    /// Whether reflection about the blade's axis keeps the sign of the DOF.
    even: bool,
    /// Angle from the blade, as a fraction of the sector angle.
    along: f64,
}

/// One number of nodal diameters n.
struct Waves {
    /// cos and sin of the phase n s t at each sector s.
    turns: Vec<(f64, f64)>,
    /// Real and imaginary part of T; `None` for n = 0 and n = S/2, where modes are single and real.
    mirrored: Option<[Matrix; 2]>,
}

impl Sectors {
    /// Arrangement of a ring of `nodes` nodes, a multiple of `count`. The DOFs of `inside` nodes in each blade follow those of the ring.
    pub(super) fn new(count: usize, nodes: usize, inside: usize) -> Self {
        let per_sector = nodes / count;
        let ring = (0..per_sector).flat_map(|m| {
            // u, u_s, v, v_s
            [false, true, true, false].into_iter().enumerate().map(move |(k, even)| Freedom {
                mirror: 4 * ((per_sector - m) % per_sector) + k,
                even,
                along: m as f64 / per_sector as f64,
            })
        });
        // axial, transverse, slope
        let blade = (0..3 * inside).map(|k| Freedom { mirror: 4 * per_sector + k, even: k % 3 == 0, along: 0.0 });
        Self { count, freedoms: ring.chain(blade).collect(), of_ring: 4 * per_sector }
    }

    /// Index ranges of a sector's DOFs among all DOFs: on its arc of the ring, and inside its blade.
    fn places(&self, sector: usize) -> [Range<usize>; 2] {
        let (of_ring, of_blade) = (self.of_ring, self.freedoms.len() - self.of_ring);
        let blades = self.count * of_ring;
        [of_ring * sector..of_ring * (sector + 1), blades + of_blade * sector..blades + of_blade * (sector + 1)]
    }

    /// Entries of a column at the DOFs of a sector, in these two ranges.
    fn parts<'a>(&self, column: &'a [f64], sector: usize) -> [&'a [f64]; 2] {
        self.places(sector).map(|places| &column[places])
    }

    /// Number of DOFs of ring and blades.
    fn size(&self) -> usize {
        self.count * self.freedoms.len()
    }

    /// All solutions of `K phi = omega^2 M phi`: omega^2 ascending, mode shapes phi mass-normalised in columns. The first mode of a pair has its
    /// antinode at the blade of sector 0.
    ///
    /// # Errors
    /// [`EigenError`] if M is not positive definite or an iteration fails.
    pub fn modes(&self, k: &Matrix, m: &Matrix, what: &'static str) -> Result<(Vec<f64>, Matrix), EigenError> {
        let (own, size) = (self.freedoms.len(), self.size());
        let mut found = Vec::with_capacity(size);
        for waves in self.waves() {
            let (values, y) = symmetric_generalised(&self.seen(k, &waves), &self.seen(m, &waves), what)?;
            let parts = self.amplitudes(&waves, &y);
            for (j, value) in values.into_iter().enumerate() {
                for [re, im] in &parts {
                    let of_sector = |&(cos, sin): &(f64, f64)| {
                        column_of(re, j).iter().zip(column_of(im, j)).map(move |(re, im)| re * cos - im * sin)
                    };
                    found.push((value, waves.turns.iter().flat_map(of_sector).collect::<Vec<f64>>()));
                }
            }
        }
        found.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        let mut shapes = Matrix::zeros(size, size);
        for (column, (_, shape)) in shapes.as_mut_slice().chunks_exact_mut(size).zip(&found) {
            for (sector, entries) in shape.chunks_exact(own).enumerate() {
                let (ring, blade) = entries.split_at(self.of_ring);
                for (places, part) in self.places(sector).into_iter().zip([ring, blade]) {
                    column[places].copy_from_slice(part);
                }
            }
        }
        Ok((found.into_iter().map(|(value, _)| value).collect(), shapes))
    }

    /// Inverse of a symmetric positive definite matrix of the ring; `None` if the matrix is not positive definite. A matrix without cyclic symmetry
    /// is inverted as a whole (for example a matrix of half a mode pair).
    #[must_use]
    pub fn inverse(&self, a: &Matrix) -> Option<Matrix> {
        if !self.turns(a) {
            return spd_inverse(a);
        }
        let (own, size) = (self.freedoms.len(), self.size());
        let mut blocks = vec![Matrix::zeros(own, own); self.count];
        let mut add = |block: usize, times: f64, part: &Matrix| {
            add_scaled(times, part.as_slice(), blocks[block].as_mut_slice());
        };
        for waves in self.waves() {
            let seen = spd_inverse(&self.seen(a, &waves))?;
            let share = 1.0 / self.count as f64;
            match &waves.mirrored {
                None => waves.turns.iter().enumerate().for_each(|(s, turn)| add(s, share * turn.0, &seen)),
                Some([re, im]) => {
                    let [by_re, by_im] = [re, im].map(|part| mul(&seen, &part.transpose()));
                    let (real, imaginary) = (mul(re, &by_re) + mul(im, &by_im), mul(im, &by_re) - mul(re, &by_im));
                    for (s, (cos, sin)) in waves.turns.iter().enumerate() {
                        add(s, 2.0 * share * cos, &real);
                        add(s, 2.0 * share * sin, &imaginary);
                    }
                }
            }
        }
        let mut inverse = Matrix::zeros(size, size);
        for t in 0..self.count {
            for (j, column) in self.places(t).into_iter().flatten().enumerate() {
                for s in 0..self.count {
                    let block = column_of(&blocks[(t + self.count - s) % self.count], j);
                    let (ring, blade) = block.split_at(self.of_ring);
                    for (places, part) in self.places(s).into_iter().zip([ring, blade]) {
                        inverse.as_mut_slice()[column * size..][places].copy_from_slice(part);
                    }
                }
            }
        }
        Some(inverse)
    }

    /// Whether a matrix has the cyclic symmetry of the ring.
    fn turns(&self, a: &Matrix) -> bool {
        let sizes: Vec<f64> = (0..self.size()).map(|i| a[(i, i)].abs().sqrt()).collect();
        let next = |sector: usize| (sector + 1) % self.count;
        let same = |[column, turned]: [usize; 2], s: usize| {
            let (one, other) = (self.parts(column_of(a, column), s), self.parts(column_of(a, turned), next(s)));
            let of = self.parts(&sizes, s);
            (0..2).all(|part| {
                let both = one[part].iter().zip(other[part]).zip(of[part]);
                both.fold(true, |same, ((x, y), size)| same & ((x - y).abs() <= SAME * sizes[column] * size))
            })
        };
        (0..self.count).all(|t| {
            let columns = self.places(t).into_iter().flatten().zip(self.places(next(t)).into_iter().flatten());
            columns.into_iter().all(|(column, turned)| (0..self.count).all(|s| same([column, turned], s)))
        })
    }

    /// All numbers of nodal diameters, 0 to S/2.
    fn waves(&self) -> impl Iterator<Item = Waves> {
        (0..=self.count / 2).map(move |n| {
            let alone = n == 0 || 2 * n == self.count;
            let turns = (0..self.count).map(|s| {
                // exact for a whole or a half turn
                match (n * s) % self.count {
                    0 => (1.0, 0.0),
                    part if 2 * part == self.count => (-1.0, 0.0),
                    part => turn(part as f64 / self.count as f64),
                }
            });
            Waves { turns: turns.collect(), mirrored: (!alone).then(|| self.mirrored(n)) }
        })
    }

    /// Real and imaginary part of T for n nodal diameters.
    fn mirrored(&self, n: usize) -> [Matrix; 2] {
        let own = self.freedoms.len();
        let (mut re, mut im) = (Matrix::zeros(own, own), Matrix::zeros(own, own));
        for (l, freedom) in self.freedoms.iter().enumerate() {
            let phase = |freedom: &Freedom| turn(n as f64 * freedom.along / self.count as f64);
            let mut put =
                |row: usize, column: usize, (a, b): (f64, f64)| (re[(row, column)], im[(row, column)]) = (a, b);
            // multiplies by i
            let quarter = |(cos, sin): (f64, f64)| (-sin, cos);
            let (here, other) = (phase(freedom), freedom.mirror);
            if other == l {
                put(l, l, if freedom.even { here } else { quarter(here) });
            } else if l < other {
                let sign = if freedom.even { 0.5_f64.sqrt() } else { -(0.5_f64.sqrt()) };
                let (there, half) = (phase(&self.freedoms[other]), 0.5_f64.sqrt());
                let times = |a: f64, (cos, sin): (f64, f64)| (a * cos, a * sin);
                put(l, l, times(half, here));
                put(other, l, times(sign, there));
                put(l, other, times(half, quarter(here)));
                put(other, other, times(-sign, quarter(there)));
            }
        }
        [re, im]
    }

    /// Matrix A~ of (2); A^ of (1) for n = 0 and n = S/2.
    fn seen(&self, a: &Matrix, waves: &Waves) -> Matrix {
        let own = self.freedoms.len();
        let (mut real, mut imaginary) = (Matrix::zeros(own, own), Matrix::zeros(own, own));
        for (s, &(cos, sin)) in waves.turns.iter().enumerate() {
            for (j, column) in self.places(s).into_iter().flatten().enumerate() {
                let mut from = j * own;
                for part in self.parts(column_of(a, column), 0) {
                    let to = from + part.len();
                    add_scaled(cos, part, &mut real.as_mut_slice()[from..to]);
                    add_scaled(sin, part, &mut imaginary.as_mut_slice()[from..to]);
                    from = to;
                }
            }
        }
        let seen = match &waves.mirrored {
            None => real,
            Some([re, im]) => {
                let by_real = mul(&real, re) - mul(&imaginary, im);
                let by_imaginary = mul(&real, im) + mul(&imaginary, re);
                mul_tn(re, &by_real) + mul_tn(im, &by_imaginary)
            }
        };
        (&seen + seen.transpose()) * 0.5
    }

    /// Amplitudes c = T y of the shapes (3), real and imaginary part, scaled to unit modal mass; y in columns. For a pair, a second entry has the
    /// shapes shifted by a quarter of a wavelength.
    fn amplitudes(&self, waves: &Waves, y: &Matrix) -> Vec<[Matrix; 2]> {
        let sectors = self.count as f64;
        match &waves.mirrored {
            None => vec![[y * (1.0 / sectors).sqrt(), Matrix::zeros(y.nrows(), y.ncols())]],
            Some(parts) => {
                let [re, im] = parts.each_ref().map(|part| mul(part, y) * (2.0 / sectors).sqrt());
                let behind = -&re;
                vec![[re, im.clone()], [im, behind]]
            }
        }
    }
}

/// cos and sin of a fraction of a turn.
fn turn(part: f64) -> (f64, f64) {
    let (sin, cos) = libm::sincos(2.0 * std::f64::consts::PI * part);
    (cos, sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::ModeSet;
    use crate::stator::RingMatrices;
    use bladeoff_model::machine::{Blades, FlexibleStator, Rayleigh, Ring};

    /// Calls `then` for rings with blades and without, over all arrangements of sectors.
    fn rings(mut then: impl FnMut(&RingMatrices, &str)) {
        for (elements, count, of_blade) in
            [(48, 12, 2), (16, 8, 1), (15, 5, 3), (12, 3, 2), (12, 2, 2), (8, 1, 1), (8, 8, 2), (7, 0, 0), (10, 0, 0)]
        {
            let blades = Blades { count, length: 0.25, thickness: 0.02, width: 0.06, elements: of_blade };
            let stator = FlexibleStator {
                young_modulus: 2e11,
                poisson_ratio: 0.3,
                density: 7850.0,
                yield_strength: None,
                ring: Ring { mean_radius: 0.353, thickness: 0.05, width: 0.1, elements },
                blades: (count > 0).then_some(blades),
                damping: Rayleigh::default(),
            };
            then(&RingMatrices::assemble(&stator), &format!("{elements} elements, {count} blades of {of_blade}"));
        }
    }

    #[test]
    fn modes_are_those_of_the_whole_ring() {
        rings(|ring, name| {
            let (k, m, size) = (&ring.stiffness, &ring.mass, ring.size());
            let (squares, shapes) = ring.sectors.modes(k, m, "test").expect("solvable");
            let (whole, _) = symmetric_generalised(k, m, "test").expect("solvable");
            let highest = whole[size - 1];
            assert!(squares.len() == size && squares.is_sorted(), "{name}");
            // rounding of K, and the accuracy that `symmetric_generalised` documents
            let shift = 1e-6 * (0..size).map(|i| k[(i, i)] / m[(i, i)]).fold(0.0, f64::max);
            for (j, (one, other)) in squares.iter().zip(&whole).enumerate() {
                let rounding =
                    f64::EPSILON * (highest + 10.0 * size as f64 * other.abs() * (1.0 + other.abs() / shift));
                assert!((one - other).abs() < rounding, "{name}, {j}: {one} {other}");
            }
            assert!((mul_tn(&shapes, &mul(m, &shapes)) - Matrix::identity(size, size)).amax() < 1e-10, "{name}");
            let stiff = mul_tn(&shapes, &mul(k, &shapes));
            let off = stiff - Matrix::from_diagonal(&bladeoff_numerics::linalg::Vector::from_vec(squares.clone()));
            assert!(off.amax() < 1e-13 * highest, "{name}: {}", off.amax() / highest);
            // frequencies of a pair are equal to the last digit
            let pairs = squares.windows(2).filter(|pair| pair[0].to_bits() == pair[1].to_bits()).count();
            let own = size / ring.sectors.count;
            assert_eq!(pairs, own * ((ring.sectors.count - 1) / 2), "{name}");
        });
    }

    #[test]
    fn inverses_are_those_of_the_whole_ring() {
        rings(|ring, name| {
            let size = ring.size();
            let (squares, shapes) = ring.sectors.modes(&ring.stiffness, &ring.mass, "test").expect("solvable");
            // as for the static flexibility of the truncated modes: the lowest modes, in whole pairs, with raised frequencies
            let kept = (size / 2..size).find(|&j| squares[j] != squares[j - 1]).unwrap_or(size);
            let kept = ModeSet {
                omega_squared: squares[..kept].to_vec(),
                shapes: shapes.columns(0, kept).into_owned(),
                full_limit: squares[size - 1].sqrt(),
            };
            let momenta = mul(&ring.mass, &kept.shapes);
            let mut rows = momenta.transpose();
            for (j, square) in kept.omega_squared.iter().enumerate() {
                rows.row_mut(j).scale_mut(kept.highest() * kept.highest() - square);
            }
            for matrix in [&ring.mass * 1.0, &ring.stiffness + mul(&momenta, &rows)] {
                let inverse = ring.sectors.inverse(&matrix).expect("definite");
                let whole = spd_inverse(&matrix).expect("definite");
                let size = inverse.amax();
                assert!((inverse - &whole).amax() < 1e-10 * size, "{name}");
            }
            assert!(ring.sectors.inverse(&(&ring.mass * -1.0)).is_none(), "{name}");
            // a matrix that a single mode of a pair stiffens has no cyclic symmetry
            let half = squares.windows(2).position(|pair| pair[0].to_bits() == pair[1].to_bits());
            if let Some(j) = half {
                let momentum = mul(&ring.mass, &shapes.columns(j, 1).into_owned());
                let stiffened = &ring.mass + mul(&momentum, &momentum.transpose());
                let wanted = spd_inverse(&stiffened).expect("definite");
                let found = ring.sectors.inverse(&stiffened).expect("definite");
                assert!((&found - &wanted).amax() < 1e-12 * wanted.amax(), "{name}");
            }
        });
    }
}
