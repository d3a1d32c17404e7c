//! The standard normal distribution, on the error function of `libm`, and its inverse by rational functions.

use core::f64::consts::FRAC_1_SQRT_2;

/// Phi(x) and 1 - Phi(x).
#[must_use]
pub fn normal_tails(x: f64) -> (f64, f64) {
    (0.5 * libm::erfc(-x * FRAC_1_SQRT_2), 0.5 * libm::erfc(x * FRAC_1_SQRT_2))
}

/// The x with Phi(x) = p, from p and q = 1 - p.
///
/// ```text
/// d = 1/2 - p, p <= 1/2      x = -d P(r)/Q(r), r = 0.180625 - d^2                for d <= 0.425
///                            x = -P(s - 1.6)/Q(s - 1.6), s = sqrt(-ln p)         for s <= 5
///                            x = -P(s - 5)/Q(s - 5)                              beyond; and -x for the upper half
/// ```
/// Source: M. J. Wichura, "Algorithm AS 241: the percentage points of the normal distribution", Applied Statistics 37 (1988) 477-484, PPND16.
/// Deviation: the upper tail is computed from q. Limits: p and q above 1e-317. Relative error below 1e-15 (4000 points from 1e-300 on against 40
/// digits). Each drawn value of a variable takes one call; iterations on the error function would cost twenty times as much.
///
/// Verified by `quantiles_and_tails_are_those_of_the_reference`.
#[must_use]
pub fn normal_quantile(p: f64, q: f64) -> f64 {
    if p <= 0.0 {
        return f64::NEG_INFINITY;
    }
    if q <= 0.0 {
        return f64::INFINITY;
    }
    let smaller = p.min(q);
    let middle = 0.5 - smaller;
    let magnitude = if middle <= 0.425 {
        let r = 0.180_625 - middle * middle;
        middle * ratio(&MIDDLE, r)
    } else {
        let s = libm::sqrt(-libm::log(smaller));
        if s <= 5.0 { ratio(&TAIL, s - 1.6) } else { ratio(&FAR_TAIL, s - 5.0) }
    };
    if p <= q { -magnitude } else { magnitude }
}

/// Coefficients of numerator and denominator, beginning with the constant.
type Ratio = [[f64; 8]; 2];

const MIDDLE: Ratio = [
    [
        3.387_132_872_796_366_5,
        133.141_667_891_784_38,
        1_971.590_950_306_551_3,
        13_731.693_765_509_46,
        45_921.953_931_549_87,
        67_265.770_927_008_7,
        33_430.575_583_588_13,
        2_509.080_928_730_122_7,
    ],
    [
        1.0,
        42.313_330_701_600_91,
        687.187_007_492_057_9,
        5_394.196_021_424_751,
        21_213.794_301_586_597,
        39_307.895_800_092_71,
        28_729.085_735_721_943,
        5_226.495_278_852_854,
    ],
];
const TAIL: Ratio = [
    [
        1.423_437_110_749_683_5,
        4.630_337_846_156_546,
        5.769_497_221_460_691,
        3.647_848_324_763_204_5,
        1.270_458_252_452_368_4,
        0.241_780_725_177_450_6,
        0.022_723_844_989_269_184,
        0.000_774_545_014_278_341_4,
    ],
    [
        1.0,
        2.053_191_626_637_759,
        1.676_384_830_183_803_8,
        0.689_767_334_985_1,
        0.148_103_976_427_480_08,
        0.015_198_666_563_616_457,
        0.000_547_593_808_499_534_5,
        1.050_750_071_644_416_9e-9,
    ],
];
const FAR_TAIL: Ratio = [
    [
        6.657_904_643_501_103,
        5.463_784_911_164_114,
        1.784_826_539_917_291_3,
        0.296_560_571_828_504_87,
        0.026_532_189_526_576_124,
        0.001_242_660_947_388_078_4,
        2.711_555_568_743_487_6e-5,
        2.010_334_399_292_288_1e-7,
    ],
    [
        1.0,
        0.599_832_206_555_888,
        0.136_929_880_922_735_8,
        0.014_875_361_290_850_615,
        0.000_786_869_131_145_613_3,
        1.846_318_317_510_054_8e-5,
        1.421_511_758_316_446e-7,
        2.044_263_103_389_939_7e-15,
    ],
];

fn ratio([above, below]: &Ratio, r: f64) -> f64 {
    let value = |coefficients: &[f64; 8]| coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * r + coefficient);
    value(above) / value(below)
}
