//! `[design]` as it is written, and what is wrong with it.

use crate::design::Design;
use thiserror::Error;

/// Most points of a plan: a study has no more samples.
pub const MOST_POINTS: u64 = Design::LIMIT;
/// Most uncertain parameters.
pub const MOST_PARAMETERS: usize = 128;
/// Most replicates.
pub const MOST_REPLICATES: u64 = 1024;
/// Fewest replicates of which an interval is made.
pub const FEWEST_REPLICATES: u64 = 16;
/// Most quantiles of a one-at-a-time design.
pub const MOST_QUANTILES: usize = 100;

/// How points are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Independent points.
    MonteCarlo,
    /// One point in each slice of every parameter.
    LatinHypercube,
    /// Sobol's sequence.
    Sobol,
    /// Halton's sequence.
    Halton,
    /// A base point, then one parameter at a time.
    OneAtATime,
}

impl Kind {
    /// All of them with their words in a file.
    pub const ALL: [(&'static str, Kind); 5] = [
        ("monte-carlo", Kind::MonteCarlo),
        ("latin-hypercube", Kind::LatinHypercube),
        ("sobol", Kind::Sobol),
        ("halton", Kind::Halton),
        ("one-at-a-time", Kind::OneAtATime),
    ];

    /// By its word.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.iter().find(|(known, _)| *known == word).map(|(_, kind)| *kind)
    }

    /// Its word.
    #[must_use]
    pub fn word(self) -> &'static str {
        Self::ALL.iter().find(|(_, known)| *known == self).map_or("", |(word, _)| *word)
    }

    /// Whether a replicate is what it should be at powers of two only.
    #[must_use]
    pub fn needs_powers_of_two(self) -> bool {
        matches!(self, Kind::LatinHypercube | Kind::Sobol)
    }
}

/// The base point of a one-at-a-time design.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Base {
    /// Medians; of words the most probable.
    #[default]
    Median,
    /// Present values of the machine; `None`: there is none. Of words the place in their list.
    Nominal(Vec<Option<f64>>),
}

/// `[design]` as it is written.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanDef {
    /// `kind`.
    pub kind: Kind,
    /// `samples`: points of a replicate.
    pub samples: Option<u64>,
    /// `replicates`, by default 1.
    pub replicates: Option<u64>,
    /// `scramble`, by default true.
    pub scramble: Option<bool>,
    /// `base`, by default the medians.
    pub base: Option<Base>,
    /// `quantiles`, by default 0.1 and 0.9.
    pub quantiles: Option<Vec<f64>>,
}

impl PlanDef {
    /// Of a kind, with nothing else given.
    #[must_use]
    pub fn new(kind: Kind) -> Self {
        Self { kind, samples: None, replicates: None, scramble: None, base: None, quantiles: None }
    }
}

/// A mistake in `[design]`; [`PlanError::key`] is where it stands.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlanError {
    /// A key is not there.
    #[error("`{key}` is missing; allowed: {allowed}")]
    Missing {
        /// The key.
        key: &'static str,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A key that the kind does not have.
    #[error("`{key}` with kind = \"{}\": {reason}", kind.word())]
    Surplus {
        /// The key.
        key: &'static str,
        /// Not of this.
        kind: Kind,
        /// Why.
        reason: String,
    },
    /// A value that cannot be.
    #[error("`{key}` = {given}; allowed: {allowed}")]
    Value {
        /// The key.
        key: &'static str,
        /// As given.
        given: String,
        /// What is allowed.
        allowed: String,
    },
    /// A value of a list that cannot be.
    #[error("`{key}`, value {} = {given}; allowed: {allowed}", position + 1)]
    Element {
        /// The key.
        key: &'static str,
        /// Position in the list, from 0.
        position: usize,
        /// As given.
        given: f64,
        /// What is allowed.
        allowed: String,
    },
    /// More uncertain parameters than there may be, or none.
    #[error("the design has {given} uncertain parameters; allowed: 1 to {MOST_PARAMETERS}")]
    Parameters {
        /// How many.
        given: usize,
    },
    /// A first point at the ends of laws that have none.
    #[error(
        "`scramble` = false puts the first point at the lowest value of every parameter, and {name} has none; allowed: `scramble` = true, or laws with a `lower`"
    )]
    Unbounded {
        /// The parameter.
        name: String,
    },
    /// A first point at minus infinity of correlated normal numbers.
    #[error(
        "`scramble` = false puts the first point at minus infinity of the correlated normal numbers; allowed: `scramble` = true"
    )]
    UnboundedByCorrelation,
    /// One parameter cannot change alone if it is correlated.
    #[error(
        "kind = \"one-at-a-time\" changes one parameter while the others stay, which [[correlation]] says they do not; allowed: another kind, or no [[correlation]]"
    )]
    Correlated,
    /// The machine gives no value to start from.
    #[error("`base` = \"nominal\": the machine gives {name} no value; allowed: `base` = \"median\"")]
    NoNominal {
        /// The parameter.
        name: String,
    },
}

impl PlanError {
    /// The key at fault.
    #[must_use]
    pub fn key(&self) -> &'static str {
        match self {
            PlanError::Missing { key, .. }
            | PlanError::Surplus { key, .. }
            | PlanError::Value { key, .. }
            | PlanError::Element { key, .. } => key,
            PlanError::Unbounded { .. } | PlanError::UnboundedByCorrelation => "scramble",
            PlanError::Correlated | PlanError::Parameters { .. } => "kind",
            PlanError::NoNominal { .. } => "base",
        }
    }
}

/// Every mistake in the keys themselves.
pub(super) fn mistakes(def: &PlanDef) -> Vec<PlanError> {
    let mut errors = Vec::new();
    let kind = def.kind;
    let mut surplus = |key: &'static str, given: bool, reason: &dyn Fn() -> String| {
        if given {
            errors.push(PlanError::Surplus { key, kind, reason: reason() });
        }
    };
    let stepped = kind == Kind::OneAtATime;
    surplus("samples", stepped && def.samples.is_some(), &|| {
        "the number of points follows from the parameters and `quantiles`".to_owned()
    });
    surplus("replicates", stepped && def.replicates.is_some(), &|| "nothing in it is random".to_owned());
    surplus("scramble", stepped && def.scramble.is_some(), &|| "nothing in it is random".to_owned());
    surplus("replicates", kind == Kind::MonteCarlo && def.replicates.is_some(), &|| {
        let points = def.samples.unwrap_or(0).saturating_mul(def.replicates.unwrap_or(1));
        format!("its points are independent already; allowed: `samples` = {points} alone")
    });
    surplus("scramble", matches!(kind, Kind::MonteCarlo | Kind::LatinHypercube) && def.scramble.is_some(), &|| {
        "its points are random in any case; `scramble` belongs to \"sobol\" and \"halton\"".to_owned()
    });
    let steps = || "it belongs to \"one-at-a-time\"".to_owned();
    surplus("base", !stepped && def.base.is_some(), &steps);
    surplus("quantiles", !stepped && def.quantiles.is_some(), &steps);
    if stepped {
        errors.extend(quantile_mistakes(def));
    } else {
        errors.extend(size_mistakes(def));
    }
    errors
}

fn size_mistakes(def: &PlanDef) -> Vec<PlanError> {
    let mut errors = Vec::new();
    let replicates = if def.kind == Kind::MonteCarlo { 1 } else { def.replicates.unwrap_or(1) };
    if !(1..=MOST_REPLICATES).contains(&replicates) {
        let allowed = format!("1 to {MOST_REPLICATES}");
        errors.push(PlanError::Value { key: "replicates", given: replicates.to_string(), allowed });
    }
    if def.scramble == Some(false) && def.kind != Kind::LatinHypercube && replicates > 1 {
        let allowed = "1: without scrambling all replicates would be the same".to_owned();
        errors.push(PlanError::Value { key: "replicates", given: replicates.to_string(), allowed });
    }
    let Some(samples) = def.samples else {
        errors.push(PlanError::Missing { key: "samples", allowed: "the number of points of a replicate" });
        return errors;
    };
    let most = MOST_POINTS / replicates.clamp(1, MOST_REPLICATES);
    let given = samples.to_string();
    if samples == 0 || samples > most {
        let allowed = match replicates {
            1 => format!("1 to {most}"),
            _ => format!("1 to {most} ({MOST_POINTS} points in {replicates} replicates)"),
        };
        errors.push(PlanError::Value { key: "samples", given, allowed });
    } else if def.kind.needs_powers_of_two() && !samples.is_power_of_two() {
        let above = samples.next_power_of_two();
        let above = if above <= most { format!(" or {above}") } else { String::new() };
        let allowed = format!("a power of two: {}{above}", 1u64 << samples.ilog2());
        errors.push(PlanError::Value { key: "samples", given, allowed });
    }
    errors
}

fn quantile_mistakes(def: &PlanDef) -> Vec<PlanError> {
    let Some(quantiles) = &def.quantiles else { return Vec::new() };
    if quantiles.is_empty() || quantiles.len() > MOST_QUANTILES {
        let (given, allowed) = (format!("{} values", quantiles.len()), format!("1 to {MOST_QUANTILES} values"));
        return vec![PlanError::Value { key: "quantiles", given, allowed }];
    }
    let is_median = def.base.as_ref().is_none_or(|base| *base == Base::Median);
    let wrong = |(position, &given): (usize, &f64)| {
        let allowed = if !(0.0..=1.0).contains(&given) {
            "0 to 1"
        } else if quantiles[..position].contains(&given) {
            "each once"
        } else if is_median && given == 0.5 {
            "another than 0.5, which is the base point"
        } else {
            return None;
        };
        Some(PlanError::Element { key: "quantiles", position, given, allowed: allowed.to_owned() })
    };
    quantiles.iter().enumerate().filter_map(wrong).collect()
}
