//! The values of all variables of a sample: a pure function of (study, seed, index).
//!
//! ```text
//! index -> coordinates (plan) -> dependent coordinates (correlation) -> values (uncertain), values of [[vary]] -> derived values
//! ```
//! The caller passes the values of `[[vary]]`: the design is crossed with them, so that each of their combinations has the same points. No
//! state except scratch memory is kept between calls, so any thread can draw any sample.

use crate::correlation::Copula;
use crate::derived::{Derived, NotFinite, Variable};
use crate::sampling::layout::SamplingLayout;
use crate::uncertain::Uncertain;
use bladeoff_model::machine::ParamValue;

/// Values of samples, drawn and derived.
#[derive(Debug, Clone)]
pub struct SampleValues {
    laws: Vec<Uncertain>,
    copula: Copula,
    /// Layout of the points; `None` without uncertain inputs.
    layout: Option<SamplingLayout>,
    derived: Derived,
    /// Number of samples drawn so far, by all clones.
    #[cfg(test)]
    pub(crate) drawn: std::sync::Arc<std::sync::atomic::AtomicU64>,
}

/// Scratch memory, reused between samples.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    point: Vec<f64>,
    coordinates: Vec<(f64, f64)>,
    normals: Vec<f64>,
    stack: Vec<f64>,
}

impl SampleValues {
    /// Combines valid parts. The variables of `derived` are the uncertain ones, those of `[[vary]]` and the derived ones.
    #[must_use]
    pub fn new(laws: Vec<Uncertain>, copula: Copula, layout: Option<SamplingLayout>, derived: Derived) -> Self {
        assert_eq!(layout.is_none(), laws.is_empty(), "what is uncertain is planned");
        assert!(
            laws.len() + derived.count() <= derived.variables().len(),
            "the variables begin with the uncertain ones"
        );
        Self {
            laws,
            copula,
            layout,
            derived,
            #[cfg(test)]
            drawn: std::sync::Arc::default(),
        }
    }

    /// Distributions of the uncertain variables.
    #[must_use]
    pub fn laws(&self) -> &[Uncertain] {
        &self.laws
    }

    /// Whether the uncertain variables are independent.
    #[must_use]
    pub fn is_independent(&self) -> bool {
        self.copula.is_independent()
    }

    /// Layout of the points; `None` without uncertain inputs.
    #[must_use]
    pub fn layout(&self) -> Option<&SamplingLayout> {
        self.layout.as_ref()
    }

    /// Keeps a fraction `factor` of the points of each replicate, from the first on.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.layout = self.layout.map(|layout| layout.scaled(factor));
        self
    }

    /// Whether any value is derived from others.
    #[must_use]
    pub fn derives(&self) -> bool {
        self.derived.count() > 0
    }

    /// The variables, in the order of the values.
    #[must_use]
    pub fn variables(&self) -> &[Variable] {
        self.derived.variables()
    }

    /// Writes the values of all variables of a sample to `values`: numbers in SI, for words the position in their list. `varied`: the values of
    /// `[[vary]]`.
    ///
    /// # Errors
    /// A derived value that is not finite.
    pub fn values(
        &self,
        index: u64,
        varied: &[f64],
        scratch: &mut Scratch,
        values: &mut Vec<f64>,
    ) -> Result<(), NotFinite> {
        #[cfg(test)]
        self.drawn.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        values.clear();
        match self.layout.as_ref().map(|layout| (layout, layout.steps())) {
            None => {}
            Some((_, Some(steps))) => steps.values(index, values),
            Some((layout, None)) => {
                scratch.point.resize(self.laws.len(), 0.0);
                layout.fill(index, &mut scratch.point);
                scratch.coordinates.clear();
                // exact except for Halton's sequence, whose cells are not powers of two
                scratch.coordinates.extend(scratch.point.iter().map(|&p| (p, 1.0 - p)));
                self.copula.apply(&mut scratch.coordinates, &mut scratch.normals);
                // `+ 0.0`: -0 would print and hash differently from 0 with the same meaning
                let drawn = self.laws.iter().zip(&scratch.coordinates).map(|(law, &(p, q))| law.quantile(p, q) + 0.0);
                values.extend(drawn);
            }
        }
        values.extend_from_slice(varied);
        self.derived.extend(values, &mut scratch.stack)
    }

    /// Converts a drawn number to the value of a parameter.
    #[must_use]
    pub fn param(&self, variable: usize, value: f64) -> ParamValue {
        match self.laws.get(variable).and_then(Uncertain::words) {
            Some(words) => ParamValue::Choice(words[value as usize].clone()),
            None => ParamValue::Number(value),
        }
    }
}
