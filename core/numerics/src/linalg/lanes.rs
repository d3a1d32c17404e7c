//! Loops over eight columns or rows at a time, with the widest vectors of the processor: the operations and their order are always the same, so the
//! bytes are, too.
//!
//! A kernel is written once, as plain loops over arrays of eight numbers without sums across them, and compiled for each [`Width`]. Products and sums
//! are not fused. `BLADEOFF_SIMD` forces a width, for tests and comparisons; the row of a run does not depend on it.
//! Verified by `tests/program/widths.rs`.

use std::sync::OnceLock;

/// Number of values processed together.
pub const LANES: usize = 8;
/// Environment variable that forces a width.
pub const WIDTH_VARIABLE: &str = "BLADEOFF_SIMD";

/// Values processed together, aligned so that one vector of the processor can load them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(align(64))]
pub struct Lane(pub [f64; LANES]);

/// Instruction set of one vector width.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Width {
    /// Two numbers at once; available on every processor of this architecture.
    Sse2,
    /// Four numbers at once.
    Avx2,
    /// Eight numbers at once.
    Avx512,
}

/// A width that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WidthError {
    /// Unknown name.
    #[error("{WIDTH_VARIABLE} = \"{0}\": allowed are \"sse2\", \"avx2\" and \"avx512\"")]
    Unknown(String),
    /// Not supported by this processor.
    #[error("{WIDTH_VARIABLE} = \"{asked}\": this processor has \"{has}\" at most")]
    NotThere {
        /// Requested width.
        asked: Width,
        /// Widest supported width.
        has: Width,
    },
}

impl std::fmt::Display for Width {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Sse2 => "sse2",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        })
    }
}

impl Width {
    /// All widths, from the narrowest on.
    pub const ALL: [Self; 3] = [Self::Sse2, Self::Avx2, Self::Avx512];

    /// Widest width of this processor.
    #[must_use]
    pub fn widest() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            let all = [is_x86_feature_detected!("avx512f"), is_x86_feature_detected!("avx512dq")];
            if all == [true; 2] && is_x86_feature_detected!("avx512vl") && is_x86_feature_detected!("avx512bw") {
                return Self::Avx512;
            }
            if is_x86_feature_detected!("avx2") {
                return Self::Avx2;
            }
        }
        Self::Sse2
    }

    /// Width of this process: the value of [`WIDTH_VARIABLE`], or the widest supported one if the variable is unset or empty.
    ///
    /// # Errors
    /// [`WidthError`].
    pub fn chosen() -> Result<Self, WidthError> {
        let Some(word) = std::env::var_os(WIDTH_VARIABLE).filter(|word| !word.is_empty()) else {
            return Ok(Self::widest());
        };
        let word = word.to_string_lossy();
        let has = Self::widest();
        match Self::ALL.into_iter().find(|width| width.to_string() == word) {
            None => Err(WidthError::Unknown(word.into_owned())),
            Some(asked) if asked > has => Err(WidthError::NotThere { asked, has }),
            Some(asked) => Ok(asked),
        }
    }
}

/// Width of this process. The program rejects an unusable value of [`WIDTH_VARIABLE`] at its start; here it means the widest supported width.
#[inline]
pub fn width() -> Width {
    static WIDTH: OnceLock<Width> = OnceLock::new();
    #[cold]
    fn choose() -> Width {
        *WIDTH.get_or_init(|| Width::chosen().unwrap_or_else(|_| Width::widest()))
    }
    WIDTH.get().copied().unwrap_or_else(choose)
}

/// Declares a kernel: its body is compiled once for each width, and the version for [`width`] is called. The narrowest version is a separate function too: inlined
/// beside the choice, it would make every call save registers.
#[macro_export]
macro_rules! kernel {
    ($(#[$meta:meta])* $vis:vis fn $name:ident($($arg:ident: $type:ty),* $(,)?) $(-> $out:ty)? $body:block) => {
        $(#[$meta])*
        #[inline]
        $vis fn $name($($arg: $type),*) $(-> $out)? {
            #[inline(always)]
            fn plain($($arg: $type),*) $(-> $out)? $body
            #[inline(never)]
            fn narrowest($($arg: $type),*) $(-> $out)? { plain($($arg),*) }
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn avx2($($arg: $type),*) $(-> $out)? { plain($($arg),*) }
                #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
                fn avx512($($arg: $type),*) $(-> $out)? { plain($($arg),*) }
                match $crate::linalg::lanes::width() {
                    $crate::linalg::lanes::Width::Sse2 => {}
                    // SAFETY: `width` is at most the widest width that this processor supports
                    #[expect(unsafe_code, reason = "vectors")]
                    $crate::linalg::lanes::Width::Avx2 => return unsafe { avx2($($arg),*) },
                    // SAFETY: the same
                    #[expect(unsafe_code, reason = "vectors")]
                    $crate::linalg::lanes::Width::Avx512 => return unsafe { avx512($($arg),*) },
                }
            }
            narrowest($($arg),*)
        }
    };
}
pub use crate::kernel;

/// Sum of eight numbers, by halves.
#[inline(always)]
pub fn sum([a, b, c, d, e, f, g, h]: [f64; LANES]) -> f64 {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// Smallest of eight numbers, by halves.
#[inline(always)]
pub fn least_of([a, b, c, d, e, f, g, h]: [f64; LANES]) -> f64 {
    let least = |x: f64, y: f64| if x < y { x } else { y };
    least(least(least(a, e), least(c, g)), least(least(b, f), least(d, h)))
}

/// Scalar products of eight rows with y, the entries of the rows stored column by column; for use inside a kernel.
#[inline(always)]
pub fn rows_times_inline(columns: &[Lane], y: &[f64]) -> [f64; LANES] {
    // two independent chains, because each addition waits for the previous one of its chain
    let mut sums = [[0.0; LANES]; 2];
    let (fours, last) = columns.as_chunks::<TOGETHER>();
    let (ys, rest) = y[..y.len().min(columns.len())].as_chunks::<TOGETHER>();
    for (four, y) in fours.iter().zip(ys) {
        for c in 0..TOGETHER {
            for k in 0..LANES {
                sums[c % 2][k] += four[c].0[k] * y[c];
            }
        }
    }
    for (c, (column, y)) in last.iter().zip(rest).enumerate() {
        for k in 0..LANES {
            sums[c % 2][k] += column.0[k] * y;
        }
    }
    std::array::from_fn(|k| sums[0][k] + sums[1][k])
}

kernel! {
    /// [`rows_times_inline`].
    pub fn rows_times(columns: &[Lane], y: &[f64]) -> [f64; LANES] {
        rows_times_inline(columns, y)
    }
}

/// Numbers in groups of eight, filled up with zeros.
pub fn lanes_of(numbers: &[f64]) -> Vec<Lane> {
    let of = |eight: &[f64]| Lane(std::array::from_fn(|k| eight.get(k).copied().unwrap_or(0.0)));
    numbers.chunks(LANES).map(of).collect()
}

/// Groups of eight as one slice.
#[inline]
pub fn flat(lanes: &[Lane]) -> &[f64] {
    let all: *const [Lane] = lanes;
    // SAFETY: a lane is eight numbers of eight bytes in 64 bytes, so `lanes` is eight times as many without a gap between them
    #[expect(unsafe_code, reason = "vectors are loaded from aligned lanes, and read as plain numbers elsewhere")]
    unsafe {
        std::slice::from_raw_parts(all.cast::<f64>(), LANES * lanes.len())
    }
}

kernel! {
    /// y += a x.
    pub fn add_scaled(a: f64, x: &[f64], y: &mut [f64]) {
        for (yi, xi) in y.iter_mut().zip(x) {
            *yi += a * xi;
        }
    }
}

/// Number of columns that [`product`] computes together.
const TOGETHER: usize = 4;

kernel! {
    /// `C = A B` for the given numbers of rows, inner indices and columns, column by column; each entry is summed over the inner index in ascending
    /// order.
    pub fn product(sizes: [usize; 3], a: &[f64], b: &[f64], c: &mut [f64]) {
        let [rows, inner, columns] = sizes;
        let whole = columns - columns % TOGETHER;
        for j in (0..whole).step_by(TOGETHER) {
            let factors: [&[f64]; TOGETHER] = std::array::from_fn(|n| &b[(j + n) * inner..(j + n + 1) * inner]);
            let c = &mut c[j * rows..(j + TOGETHER) * rows];
            let mut i = 0;
            while i < rows {
                i += match rows - i {
                    LANES.. => rows_of::<LANES>(rows, i, a, factors, c),
                    4.. => rows_of::<4>(rows, i, a, factors, c),
                    2.. => rows_of::<2>(rows, i, a, factors, c),
                    _ => rows_of::<1>(rows, i, a, factors, c),
                };
            }
        }
        // remaining columns, one by one
        c[whole * rows..].fill(0.0);
        for j in whole..columns {
            for k in 0..inner {
                let factor = b[j * inner + k];
                for (sum, entry) in c[j * rows..(j + 1) * rows].iter_mut().zip(&a[k * rows..(k + 1) * rows]) {
                    *sum += factor * entry;
                }
            }
        }
    }
}

/// Computes some rows of the columns that are computed together; returns their number. For use inside a kernel.
#[inline(always)]
fn rows_of<const SOME: usize>(
    rows: usize,
    i: usize,
    a: &[f64],
    [f, g, h, l]: [&[f64]; TOGETHER],
    c: &mut [f64],
) -> usize {
    let mut sums = [[0.0; SOME]; TOGETHER];
    for ((((column, f), g), h), l) in a.chunks_exact(rows).zip(f).zip(g).zip(h).zip(l) {
        let Some(some) = column[i..].first_chunk::<SOME>() else { break };
        for (sums, factor) in sums.iter_mut().zip([f, g, h, l]) {
            for k in 0..SOME {
                sums[k] += factor * some[k];
            }
        }
    }
    for (n, sums) in sums.iter().enumerate() {
        c[n * rows + i..][..SOME].copy_from_slice(sums);
    }
    SOME
}

kernel! {
    /// `(x, y) = (c x - s y, s x + c y)`.
    pub fn turn_both(cos: f64, sin: f64, x: &mut [f64], y: &mut [f64]) {
        let count = x.len();
        let y = &mut y[..count];
        for i in 0..count {
            let (a, b) = (x[i], y[i]);
            x[i] = cos * a - sin * b;
            y[i] = sin * a + cos * b;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_is_that_of_plain_loops_to_the_last_bit() {
        let value = |i: usize| ((i * 7919 % 1013) as f64 - 506.3) / 97.1;
        for (rows, inner, columns) in (0..=17).flat_map(|r| (0..=9).flat_map(move |k| (0..=9).map(move |c| (r, k, c))))
        {
            let a: Vec<f64> = (0..rows * inner).map(value).collect();
            let b: Vec<f64> = (0..inner * columns).map(|i| value(i + 31)).collect();
            let mut plain = vec![0.0; rows * columns];
            for j in 0..columns {
                for k in 0..inner {
                    for i in 0..rows {
                        plain[j * rows + i] += b[j * inner + k] * a[k * rows + i];
                    }
                }
            }
            let mut ours = vec![f64::NAN; rows * columns];
            product([rows, inner, columns], &a, &b, &mut ours);
            let bits = |c: &[f64]| c.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&ours), bits(&plain), "{rows} {inner} {columns}");
        }
    }
}
