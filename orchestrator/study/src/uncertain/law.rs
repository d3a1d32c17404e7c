//! Continuous distributions: quantiles from both tail probabilities and back, so that neither loses digits.

use bladeoff_numerics::probability::{Beta, beta_tails, gamma_quantile, gamma_tails, normal_quantile, normal_tails};

/// A continuous distribution with the parameters of its formula.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Law {
    /// Mean, standard deviation.
    Normal(f64, f64),
    /// Mean and standard deviation of ln x.
    LogNormal(f64, f64),
    /// Lower and upper end.
    Uniform(f64, f64),
    /// Lower and upper end, both above 0: ln x is uniform.
    LogUniform(f64, f64),
    /// Lower end, mode, upper end.
    Triangular(f64, f64, f64),
    /// Distribution on 0 .. 1, lower and upper end.
    Beta(Beta, f64, f64),
    /// Shape, scale.
    Gamma(f64, f64),
    /// Shape, scale.
    Weibull(f64, f64),
    /// Location and scale; for maxima.
    Gumbel(f64, f64),
    /// Mean.
    Exponential(f64),
}

impl Law {
    /// The x with the probability p below and q = 1 - p above it.
    pub fn quantile(&self, p: f64, q: f64) -> f64 {
        let blend = |from: f64, to: f64| if p <= q { from + p * (to - from) } else { to - q * (to - from) };
        // -ln(1 - p)
        let survived = || if p < 0.5 { -libm::log1p(-p) } else { -libm::log(q) };
        match self {
            Law::Normal(mean, sd) => mean + sd * normal_quantile(p, q),
            Law::LogNormal(mu, sigma) => libm::exp(mu + sigma * normal_quantile(p, q)),
            Law::Uniform(from, to) => blend(*from, *to),
            Law::LogUniform(from, to) => libm::exp(blend(libm::log(*from), libm::log(*to))),
            Law::Triangular(from, mode, to) => {
                let (left, right, all) = (mode - from, to - mode, to - from);
                if p * all <= left {
                    from + libm::sqrt(p * left) * libm::sqrt(all)
                } else {
                    to - libm::sqrt(q * right) * libm::sqrt(all)
                }
            }
            Law::Beta(beta, from, to) => {
                let (x, y) = beta.quantile(p, q);
                if x <= y { from + x * (to - from) } else { to - y * (to - from) }
            }
            Law::Gamma(shape, scale) => scale * gamma_quantile(*shape, p, q),
            Law::Weibull(shape, scale) => scale * libm::pow(survived(), 1.0 / shape),
            // -ln(-ln p)
            Law::Gumbel(location, scale) => {
                let inner = if p < 0.5 { -libm::log(p) } else { -libm::log1p(-q) };
                location - scale * libm::log(inner)
            }
            Law::Exponential(mean) => mean * survived(),
        }
    }

    /// F(x) and 1 - F(x).
    pub fn tails(&self, x: f64) -> (f64, f64) {
        let ramp = |from: f64, to: f64, x: f64| {
            let x = x.clamp(from, to);
            ((x - from) / (to - from), (to - x) / (to - from))
        };
        let survived = |hazard: f64| (-libm::expm1(-hazard), libm::exp(-hazard));
        match self {
            Law::Normal(mean, sd) => normal_tails((x - mean) / sd),
            Law::LogNormal(mu, sigma) if x > 0.0 => normal_tails((libm::log(x) - mu) / sigma),
            Law::LogUniform(from, to) if x > 0.0 => ramp(libm::log(*from), libm::log(*to), libm::log(x)),
            Law::LogNormal(..) | Law::LogUniform(..) => (0.0, 1.0),
            Law::Uniform(from, to) => ramp(*from, *to, x),
            Law::Triangular(from, mode, to) => {
                let all = to - from;
                if x <= *from {
                    (0.0, 1.0)
                } else if x >= *to {
                    (1.0, 0.0)
                } else if x <= *mode {
                    let p = (x - from) * (x - from) / (all * (mode - from));
                    (p, 1.0 - p)
                } else {
                    let q = (to - x) * (to - x) / (all * (to - mode));
                    (1.0 - q, q)
                }
            }
            Law::Beta(beta, from, to) => {
                let (a, b) = beta.parameters();
                beta_tails(a, b, (x - from) / (to - from))
            }
            Law::Gamma(shape, scale) => gamma_tails(*shape, x / scale),
            Law::Weibull(shape, scale) => survived(libm::pow((x / scale).max(0.0), *shape)),
            Law::Gumbel(location, scale) => {
                let inner = libm::exp(-(x - location) / scale);
                (libm::exp(-inner), -libm::expm1(-inner))
            }
            Law::Exponential(mean) => survived((x / mean).max(0.0)),
        }
    }
}
