//! Minimum of the gap between rotor and ring, between the ring points.
//!
//! ```text
//! xi = -(g_+ - g_-)/(2 (g_+ - 2 g_c + g_-))          offset of the minimum from a point c whose neighbours are not nearer          (1)
//! ```
//! g_-, g_c, g_+: gaps at the point and its neighbours \[m\]; xi in spacings of the points. The displacement of the ring there is
//! that of the parabola through the three points.

/// Largest offset of a minimum from its point, in spacings: one half, and a margin because minima of clearances and of gaps
/// differ a little.
pub(super) const MAX_OFFSET: f64 = 0.75;

/// Minimum of the gap between rotor and ring.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct GapMinimum {
    /// Nearest ring point, and offset of the minimum from it in spacings.
    pub index: usize,
    pub offset: f64,
    /// Gap \[m\].
    pub gap: f64,
    /// Unit vector from the rotor's centre to the minimum: in its polar axes (radial, tangential), and in the stator's axes.
    pub polar: [f64; 2],
    pub normal: [f64; 2],
}

/// Offset (1) of three gaps.
#[inline(always)]
pub(super) fn parabola_offset([before, here, next]: [f64; 3]) -> f64 {
    let (slope, curvature) = (0.5 * (next - before), next - 2.0 * here + before);
    if curvature > 0.0 && slope.abs() <= MAX_OFFSET * curvature { -slope / curvature } else { 0.0 }
}
