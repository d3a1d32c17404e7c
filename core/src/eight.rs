//! Eight numbers as one value, with the same operations in the same order at every vector width, and so the same bytes.
//!
//! The compiler chooses the vectors for loops over arrays; for several loops in one function it generates gathers. Code on [`Eight`] has one
//! instruction per operation and vector. No product is fused with a sum.
//! Verified by `operations_are_the_same_at_every_width`, `tests/program/widths.rs`.

use bladeoff_numerics::linalg::lanes::{LANES, Lane};
use std::ops::{Add, Div, Mul, Sub};

/// Eight numbers with element-wise operations.
pub(crate) trait Eight:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// All eight elements equal to `x`.
    fn all(x: f64) -> Self;
    /// Loads the eight elements of a lane.
    fn load(lane: &Lane) -> Self;
    /// Stores the elements in a lane.
    fn store(self, lane: &mut Lane);
    /// Square root of each element.
    fn root(self) -> Self;
    /// Absolute value of each element.
    fn size(self) -> Self;
    /// Sum of the elements, by halves as in `lanes::sum`.
    fn sum(self) -> f64;
    /// Minimum of the elements, by halves as in `lanes::least_of`.
    fn least(self) -> f64;
    /// Bit mask: bit k is set where element k is less than that of `than`.
    fn less(self, than: Self) -> u8;
    /// Elements shifted up by one: element k becomes k + 1, `first` becomes element 0, the last one is lost.
    fn before(self, first: f64) -> Self;
    /// Elements shifted down by one: element k becomes k - 1, `last` becomes element 7, the first one is lost.
    fn behind(self, last: f64) -> Self;
}

/// Portable form for every processor.
#[derive(Clone, Copy)]
pub(crate) struct Plain([f64; LANES]);

macro_rules! plain_operation {
    ($trait:ident, $name:ident, $assign:tt) => {
        impl $trait for Plain {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let mut all = self.0;
                for k in 0..LANES {
                    all[k] $assign other.0[k];
                }
                Self(all)
            }
        }
    };
}
plain_operation!(Add, add, +=);
plain_operation!(Sub, sub, -=);
plain_operation!(Mul, mul, *=);
plain_operation!(Div, div, /=);

impl Eight for Plain {
    #[inline(always)]
    fn all(x: f64) -> Self {
        Self([x; LANES])
    }
    #[inline(always)]
    fn load(lane: &Lane) -> Self {
        Self(lane.0)
    }
    #[inline(always)]
    fn store(self, lane: &mut Lane) {
        lane.0 = self.0;
    }
    #[inline(always)]
    fn root(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }
    #[inline(always)]
    fn size(self) -> Self {
        Self(self.0.map(f64::abs))
    }
    #[inline(always)]
    fn sum(self) -> f64 {
        bladeoff_numerics::linalg::lanes::sum(self.0)
    }
    #[inline(always)]
    fn least(self) -> f64 {
        bladeoff_numerics::linalg::lanes::least_of(self.0)
    }
    #[inline(always)]
    fn less(self, than: Self) -> u8 {
        (0..LANES).fold(0, |bits, k| bits | u8::from(self.0[k] < than.0[k]) << k)
    }
    #[inline(always)]
    fn before(self, first: f64) -> Self {
        let [a, b, c, d, e, f, g, _] = self.0;
        Self([first, a, b, c, d, e, f, g])
    }
    #[inline(always)]
    fn behind(self, last: f64) -> Self {
        let [_, b, c, d, e, f, g, h] = self.0;
        Self([b, c, d, e, f, g, h, last])
    }
}

#[cfg(target_arch = "x86_64")]
pub(crate) use wide::{Avx2, Avx512};

#[cfg(target_arch = "x86_64")]
#[expect(unsafe_code, reason = "vectors: values of these types are made in kernels of their width alone")]
mod wide {
    // SAFETY of all functions here: only `by_width` names these types, in functions that are called if the processor has their width; every function
    // here is inlined into these. The compiler does not check this. Code that names `Avx2` or `Avx512` elsewhere has to ensure it.
    use super::{Add, Div, Eight, LANES, Lane, Mul, Sub};
    use std::arch::x86_64::*;

    /// Two vectors of four numbers.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx2(__m256d, __m256d);

    /// One vector of eight numbers.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx512(__m512d);

    macro_rules! wide_operation {
        ($trait:ident, $name:ident, $four:ident, $eight:ident) => {
            impl $trait for Avx2 {
                type Output = Self;
                #[inline(always)]
                fn $name(self, other: Self) -> Self {
                    unsafe { Self($four(self.0, other.0), $four(self.1, other.1)) }
                }
            }
            impl $trait for Avx512 {
                type Output = Self;
                #[inline(always)]
                fn $name(self, other: Self) -> Self {
                    unsafe { Self($eight(self.0, other.0)) }
                }
            }
        };
    }
    wide_operation!(Add, add, _mm256_add_pd, _mm512_add_pd);
    wide_operation!(Sub, sub, _mm256_sub_pd, _mm512_sub_pd);
    wide_operation!(Mul, mul, _mm256_mul_pd, _mm512_mul_pd);
    wide_operation!(Div, div, _mm256_div_pd, _mm512_div_pd);

    /// Sum of four numbers, by halves.
    #[inline(always)]
    unsafe fn sum_of(four: __m256d) -> f64 {
        unsafe {
            let two = _mm_add_pd(_mm256_castpd256_pd128(four), _mm256_extractf128_pd::<1>(four));
            _mm_cvtsd_f64(_mm_add_sd(two, _mm_unpackhi_pd(two, two)))
        }
    }

    /// Minimum of four numbers, by halves.
    #[inline(always)]
    unsafe fn least_of(four: __m256d) -> f64 {
        unsafe {
            let two = _mm_min_pd(_mm256_castpd256_pd128(four), _mm256_extractf128_pd::<1>(four));
            _mm_cvtsd_f64(_mm_min_sd(two, _mm_unpackhi_pd(two, two)))
        }
    }

    impl Eight for Avx2 {
        #[inline(always)]
        fn all(x: f64) -> Self {
            unsafe { Self(_mm256_set1_pd(x), _mm256_set1_pd(x)) }
        }
        #[inline(always)]
        fn load(lane: &Lane) -> Self {
            let from = lane.0.as_ptr();
            unsafe { Self(_mm256_load_pd(from), _mm256_load_pd(from.add(LANES / 2))) }
        }
        #[inline(always)]
        fn store(self, lane: &mut Lane) {
            let to = lane.0.as_mut_ptr();
            unsafe {
                _mm256_store_pd(to, self.0);
                _mm256_store_pd(to.add(LANES / 2), self.1);
            }
        }
        #[inline(always)]
        fn root(self) -> Self {
            unsafe { Self(_mm256_sqrt_pd(self.0), _mm256_sqrt_pd(self.1)) }
        }
        #[inline(always)]
        fn size(self) -> Self {
            unsafe {
                let sign = _mm256_set1_pd(-0.0);
                Self(_mm256_andnot_pd(sign, self.0), _mm256_andnot_pd(sign, self.1))
            }
        }
        #[inline(always)]
        fn sum(self) -> f64 {
            unsafe { sum_of(_mm256_add_pd(self.0, self.1)) }
        }
        #[inline(always)]
        fn least(self) -> f64 {
            unsafe { least_of(_mm256_min_pd(self.0, self.1)) }
        }
        #[inline(always)]
        fn less(self, than: Self) -> u8 {
            // a closure would be a function without the vector instructions
            unsafe {
                let one = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(self.0, than.0));
                let other = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(self.1, than.1));
                (one | other << (LANES / 2)) as u8
            }
        }
        #[inline(always)]
        fn before(self, first: f64) -> Self {
            unsafe {
                let [one, other] = [_mm256_permute4x64_pd::<0x90>(self.0), _mm256_permute4x64_pd::<0x90>(self.1)];
                let middle = _mm256_permute4x64_pd::<0xff>(self.0);
                Self(_mm256_blend_pd::<1>(one, _mm256_set1_pd(first)), _mm256_blend_pd::<1>(other, middle))
            }
        }
        #[inline(always)]
        fn behind(self, last: f64) -> Self {
            unsafe {
                let [one, other] = [_mm256_permute4x64_pd::<0x39>(self.0), _mm256_permute4x64_pd::<0x39>(self.1)];
                let middle = _mm256_permute4x64_pd::<0>(self.1);
                Self(_mm256_blend_pd::<8>(one, middle), _mm256_blend_pd::<8>(other, _mm256_set1_pd(last)))
            }
        }
    }

    impl Eight for Avx512 {
        #[inline(always)]
        fn all(x: f64) -> Self {
            unsafe { Self(_mm512_set1_pd(x)) }
        }
        #[inline(always)]
        fn load(lane: &Lane) -> Self {
            unsafe { Self(_mm512_load_pd(lane.0.as_ptr())) }
        }
        #[inline(always)]
        fn store(self, lane: &mut Lane) {
            unsafe { _mm512_store_pd(lane.0.as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn root(self) -> Self {
            unsafe { Self(_mm512_sqrt_pd(self.0)) }
        }
        #[inline(always)]
        fn size(self) -> Self {
            unsafe { Self(_mm512_abs_pd(self.0)) }
        }
        #[inline(always)]
        fn sum(self) -> f64 {
            unsafe { sum_of(_mm256_add_pd(_mm512_castpd512_pd256(self.0), _mm512_extractf64x4_pd::<1>(self.0))) }
        }
        #[inline(always)]
        fn least(self) -> f64 {
            unsafe { least_of(_mm256_min_pd(_mm512_castpd512_pd256(self.0), _mm512_extractf64x4_pd::<1>(self.0))) }
        }
        #[inline(always)]
        fn less(self, than: Self) -> u8 {
            unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, than.0) }
        }
        #[inline(always)]
        fn before(self, first: f64) -> Self {
            unsafe {
                let (all, first) = (_mm512_castpd_si512(self.0), _mm512_castpd_si512(_mm512_set1_pd(first)));
                Self(_mm512_castsi512_pd(_mm512_alignr_epi64::<7>(all, first)))
            }
        }
        #[inline(always)]
        fn behind(self, last: f64) -> Self {
            unsafe {
                let (all, last) = (_mm512_castpd_si512(self.0), _mm512_castpd_si512(_mm512_set1_pd(last)));
                Self(_mm512_castsi512_pd(_mm512_alignr_epi64::<1>(last, all)))
            }
        }
    }
}

/// Declares a function that calls a generic one with the [`Eight`] of this process's vector width. It is the only caller of the generic
/// function, which is inlined.
macro_rules! by_width {
    ($(#[$meta:meta])* $vis:vis fn $name:ident($($arg:ident: $type:ty),* $(,)?) $(-> $out:ty)? = $generic:path) => {
        $(#[$meta])*
        #[inline]
        $vis fn $name($($arg: $type),*) $(-> $out)? {
            use $generic as generic;
            #[inline(never)]
            fn narrowest($($arg: $type),*) $(-> $out)? { generic::<$crate::eight::Plain>($($arg),*) }
            #[cfg(target_arch = "x86_64")]
            {
                use $crate::eight::{Avx2, Avx512};
                use bladeoff_numerics::linalg::lanes::{Width, width};
                #[target_feature(enable = "avx2")]
                #[inline(never)]
                fn avx2($($arg: $type),*) $(-> $out)? { generic::<Avx2>($($arg),*) }
                #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
                #[inline(never)]
                fn avx512($($arg: $type),*) $(-> $out)? { generic::<Avx512>($($arg),*) }
                match width() {
                    Width::Sse2 => {}
                    // SAFETY: `width` is at most the width that the processor was found to have
                    #[expect(unsafe_code, reason = "vectors")]
                    Width::Avx2 => return unsafe { avx2($($arg),*) },
                    // SAFETY: as above
                    #[expect(unsafe_code, reason = "vectors")]
                    Width::Avx512 => return unsafe { avx512($($arg),*) },
                }
            }
            narrowest($($arg),*)
        }
    };
}
pub(crate) use by_width;

/// Matrix-vector product of eight rows. `columns` has the entries of the rows, column by column; `numbers` has the vector in groups of eight.
#[inline(always)]
pub(crate) fn columns_times<V: Eight>(columns: &[Lane], numbers: &[Lane]) -> V {
    // four independent chains: each addition waits for the one before it in its chain
    let mut sums = [V::all(0.0); 4];
    let (eights, rest) = columns.as_chunks::<LANES>();
    for (eight, numbers) in eights.iter().zip(numbers) {
        for n in 0..LANES {
            sums[n % 4] = sums[n % 4] + V::load(&eight[n]) * V::all(numbers.0[n]);
        }
    }
    if let Some(numbers) = numbers.get(eights.len()) {
        for (n, column) in rest.iter().enumerate() {
            sums[n % 4] = sums[n % 4] + V::load(column) * V::all(numbers.0[n]);
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

by_width! {
    /// Overwrites `sums` with the combination of two lists, `times[0]` times the first plus `times[1]` times the second.
    pub(crate) fn mix(lists: [&[Lane]; 2], times: [f64; 2], sums: &mut Vec<Lane>) = mix_in
}

#[inline(always)]
fn mix_in<V: Eight>([one, other]: [&[Lane]; 2], [a, b]: [f64; 2], sums: &mut Vec<Lane>) {
    sums.resize(one.len(), Lane::default());
    let (a, b) = (V::all(a), V::all(b));
    let ((fours, left), (ones, one)) = (sums.as_chunks_mut::<4>(), one.as_chunks::<4>());
    let (others, other) = other.as_chunks::<4>();
    for ((sums, one), other) in fours.iter_mut().zip(ones).zip(others) {
        for n in 0..4 {
            (a * V::load(&one[n]) + b * V::load(&other[n])).store(&mut sums[n]);
        }
    }
    for ((sum, x), y) in left.iter_mut().zip(one).zip(other) {
        (a * V::load(x) + b * V::load(y)).store(sum);
    }
}

by_width! {
    /// Products of eight rows with a list, the entries of the rows column by column. Each is summed in the order of
    /// [`bladeoff_numerics::linalg::dot`].
    pub(crate) fn dots(columns: &[Lane], list: &[f64], products: &mut Lane) = dots_in
}

#[inline(always)]
fn dots_in<V: Eight>(columns: &[Lane], list: &[f64], products: &mut Lane) {
    products_of::<V>(columns, list).store(products);
}

by_width! {
    /// Largest absolute value of all products of rows with a list; 0 for an empty list. Rows are in blocks of eight, and each product is computed as
    /// in [`dots`]. `added` is added to the products of each block, as far as it has entries.
    pub(crate) fn largest_dot(columns: &[Lane], list: &[f64], added: &[Lane]) -> f64 = largest_dot_in
}

#[inline(always)]
fn largest_dot_in<V: Eight>(columns: &[Lane], list: &[f64], added: &[Lane]) -> f64 {
    let mut least = 0.0_f64;
    for (at, block) in columns.chunks_exact(list.len().max(1)).enumerate() {
        let products = products_of::<V>(block, list);
        let sums = added.get(at).map_or(products, |added| products + V::load(added));
        let largest = (V::all(0.0) - sums.size()).least();
        least = if largest < least { largest } else { least };
    }
    -least
}

#[inline(always)]
fn products_of<V: Eight>(columns: &[Lane], list: &[f64]) -> V {
    let (mut sums, mut tail) = ([V::all(0.0); 4], V::all(0.0));
    let ((fours, rest), (numbers, left)) = (columns.as_chunks::<4>(), list.as_chunks::<4>());
    for (four, numbers) in fours.iter().zip(numbers) {
        for n in 0..4 {
            sums[n] = sums[n] + V::load(&four[n]) * V::all(numbers[n]);
        }
    }
    for (column, number) in rest.iter().zip(left) {
        tail = tail + V::load(column) * V::all(*number);
    }
    ((sums[0] + sums[1]) + (sums[2] + sums[3])) + tail
}

#[cfg(test)]
mod tests {
    use super::*;

    #[inline(always)]
    fn everything<V: Eight>(lanes: &[Lane; 3], out: &mut [f64]) {
        let [a, b, c] = [0, 1, 2].map(|i| V::load(&lanes[i]));
        let mut lane = Lane::default();
        (((a + b) * c - a) / b).store(&mut lane);
        out[..LANES].copy_from_slice(&lane.0);
        (a * a + V::all(0.3)).root().store(&mut lane);
        out[LANES..2 * LANES].copy_from_slice(&lane.0);
        (a - b).size().store(&mut lane);
        out[2 * LANES..3 * LANES].copy_from_slice(&lane.0);
        a.before(0.1).store(&mut lane);
        out[3 * LANES..4 * LANES].copy_from_slice(&lane.0);
        a.behind(0.2).store(&mut lane);
        out[4 * LANES..5 * LANES].copy_from_slice(&lane.0);
        let last = [a.sum(), (a - c).least(), f64::from(a.less(b)), columns_times::<V>(lanes, &lanes[..1]).sum()];
        out[5 * LANES..].copy_from_slice(&last);
    }

    #[test]
    fn eight_products_are_dots_to_the_last_bit() {
        let value = |i: usize| ((i * 7919 % 1013) as f64 - 506.3) / 97.1;
        for size in [0, 1, 3, 4, 7, 36, 41] {
            let columns: Vec<Lane> = (0..size).map(|j| Lane(std::array::from_fn(|k| value(8 * j + k)))).collect();
            let list: Vec<f64> = (0..size).map(|j| value(j + 500)).collect();
            let mut products = Lane::default();
            dots(&columns, &list, &mut products);
            for k in 0..LANES {
                let row: Vec<f64> = columns.iter().map(|column| column.0[k]).collect();
                assert_eq!(
                    products.0[k].to_bits(),
                    bladeoff_numerics::linalg::dot(&row, &list).to_bits(),
                    "{size} {k}"
                );
            }
        }
    }

    by_width! { fn at_this_width(lanes: &[Lane; 3], out: &mut [f64]) = everything }

    #[test]
    fn operations_are_the_same_at_every_width() {
        let value = |i: usize| ((i * 7919 % 1013) as f64 - 506.3) / 97.1;
        let mut masks = [false; 2];
        for round in 0..200 {
            let lanes: [Lane; 3] =
                std::array::from_fn(|i| Lane(std::array::from_fn(|k| value(round * 24 + 8 * i + k))));
            let (mut plain, mut ours) = ([0.0; 5 * LANES + 4], [f64::NAN; 5 * LANES + 4]);
            everything::<Plain>(&lanes, &mut plain);
            at_this_width(&lanes, &mut ours);
            assert_eq!(plain.map(f64::to_bits), ours.map(f64::to_bits), "{round}");
            let [[a, b, c], _] = [[0, 1, 2].map(|i| lanes[i].0); 2];
            assert!((plain[1] - ((a[1] + b[1]) * c[1] - a[1]) / b[1]).abs() < 1e-12);
            assert!((plain[5 * LANES] - a.iter().sum::<f64>()).abs() < 1e-10);
            assert!(plain[3 * LANES] == 0.1 && plain[3 * LANES + 1..4 * LANES] == a[..LANES - 1]);
            assert!(plain[5 * LANES - 1] == 0.2 && plain[4 * LANES..5 * LANES - 1] == a[1..]);
            let bits = plain[5 * LANES + 2] as u8;
            assert!((0..LANES).all(|k| (bits >> k & 1 == 1) == (a[k] < b[k])));
            masks = [masks[0] || bits != 0, masks[1] || bits != 255];
        }
        assert_eq!(masks, [true; 2]);
    }
}
