//! `[design]` as written, and its possible mistakes.

use crate::sampling::combinations::Combinations;
use thiserror::Error;

/// Most points of a layout, the same as the most samples of a study.
pub const MOST_POINTS: u64 = Combinations::LIMIT;
/// Most uncertain parameters.
pub const MOST_PARAMETERS: usize = 128;
/// Most replicates.
pub const MOST_REPLICATES: u64 = 1024;
/// Fewest replicates for an interval.
pub const FEWEST_REPLICATES: u64 = 16;
/// Most quantiles of a one-at-a-time design.
pub const MOST_QUANTILES: usize = 100;
/// Most levels of a Morris design.
pub const MOST_LEVELS: u64 = 64;
/// Default number of levels.
pub const LEVELS: u64 = 4;

/// Placement of the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LayoutKind {
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
    /// Trajectories of one parameter at a time, from random points.
    Morris,
    /// Pairs of points, and one parameter at a time exchanged between them.
    Saltelli,
}

impl LayoutKind {
    /// All kinds with their words in a file.
    pub const ALL: [(&'static str, LayoutKind); 7] = [
        ("monte-carlo", LayoutKind::MonteCarlo),
        ("latin-hypercube", LayoutKind::LatinHypercube),
        ("sobol", LayoutKind::Sobol),
        ("halton", LayoutKind::Halton),
        ("one-at-a-time", LayoutKind::OneAtATime),
        ("morris", LayoutKind::Morris),
        ("saltelli", LayoutKind::Saltelli),
    ];

    /// The kind with this word.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.iter().find(|(known, _)| *known == word).map(|(_, kind)| *kind)
    }

    /// Word of this kind.
    #[must_use]
    pub fn word(self) -> &'static str {
        Self::ALL.iter().find(|(_, known)| *known == self).map_or("", |(word, _)| *word)
    }

    /// Whether a replicate has its properties only at powers of two.
    #[must_use]
    pub fn needs_powers_of_two(self) -> bool {
        matches!(self, LayoutKind::LatinHypercube | LayoutKind::Sobol | LayoutKind::Saltelli)
    }

    /// Whether points differ in one parameter alone, which is impossible for dependent parameters.
    #[must_use]
    pub fn moves_one_parameter(self) -> bool {
        matches!(self, LayoutKind::OneAtATime | LayoutKind::Morris | LayoutKind::Saltelli)
    }
}

/// The base point of a one-at-a-time design.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Base {
    /// Medians; for words, the most probable one.
    #[default]
    Median,
    /// Present values of the machine; `None`: the machine has no value. For words, the position in their list.
    Nominal(Vec<Option<f64>>),
}

/// `[design]` as written.
#[derive(Debug, Clone, PartialEq)]
pub struct LayoutDef {
    /// `kind`.
    pub kind: LayoutKind,
    /// `samples`: points of a replicate, base points of a Saltelli design.
    pub samples: Option<u64>,
    /// `replicates`, by default 1.
    pub replicates: Option<u64>,
    /// `scramble`, by default true.
    pub scramble: Option<bool>,
    /// `base`, by default the medians.
    pub base: Option<Base>,
    /// `quantiles`, by default 0.1 and 0.9.
    pub quantiles: Option<Vec<f64>>,
    /// `trajectories` of a Morris design.
    pub trajectories: Option<u64>,
    /// `levels` of a Morris design, by default 4.
    pub levels: Option<u64>,
    /// `second_order` of a Saltelli design, by default false.
    pub second_order: Option<bool>,
}

impl LayoutDef {
    /// A design of this kind with all other keys missing.
    #[must_use]
    pub fn new(kind: LayoutKind) -> Self {
        Self {
            kind,
            samples: None,
            replicates: None,
            scramble: None,
            base: None,
            quantiles: None,
            trajectories: None,
            levels: None,
            second_order: None,
        }
    }
}

/// A mistake in `[design]`; [`LayoutError::key`] returns the key at fault.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LayoutError {
    /// A required key is missing.
    #[error("`{key}` is missing; allowed: {allowed}")]
    Missing {
        /// The key.
        key: &'static str,
        /// Allowed values.
        allowed: &'static str,
    },
    /// A key that the kind does not have.
    #[error("`{key}` with kind = \"{}\": {reason}", kind.word())]
    Surplus {
        /// The key.
        key: &'static str,
        /// Kind without this key.
        kind: LayoutKind,
        /// Reason.
        reason: String,
    },
    /// A value outside the allowed range.
    #[error("`{key}` = {given}; allowed: {allowed}")]
    Value {
        /// The key.
        key: &'static str,
        /// Value given.
        given: String,
        /// Allowed values.
        allowed: String,
    },
    /// An invalid value in a list.
    #[error("`{key}`, value {} = {given}; allowed: {allowed}", position + 1)]
    Element {
        /// The key.
        key: &'static str,
        /// Position in the list, from 0.
        position: usize,
        /// Value given.
        given: f64,
        /// Allowed values.
        allowed: String,
    },
    /// No uncertain parameters, or too many.
    #[error("the design has {given} uncertain parameters; allowed: 1 to {MOST_PARAMETERS}")]
    Parameters {
        /// Number found.
        given: usize,
    },
    /// A first point at the ends of distributions with infinite ends.
    #[error(
        "`scramble` = false puts the first point at the lowest value of every parameter, and {name} has none; allowed: `scramble` = true, or distributions with a `lower`"
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
        "kind = \"{}\" changes one parameter at a time, which [[correlation]] rules out; allowed: another kind, or no \
         [[correlation]]",
        kind.word()
    )]
    Correlated {
        /// Kind that requires independent parameters.
        kind: LayoutKind,
    },
    /// The machine has no value for the base point.
    #[error("`base` = \"nominal\": the machine gives {name} no value; allowed: `base` = \"median\"")]
    NoNominal {
        /// The parameter.
        name: String,
    },
}

impl LayoutError {
    /// The key at fault.
    #[must_use]
    pub fn key(&self) -> &'static str {
        match self {
            LayoutError::Missing { key, .. }
            | LayoutError::Surplus { key, .. }
            | LayoutError::Value { key, .. }
            | LayoutError::Element { key, .. } => key,
            LayoutError::Unbounded { .. } | LayoutError::UnboundedByCorrelation => "scramble",
            LayoutError::Correlated { .. } | LayoutError::Parameters { .. } => "kind",
            LayoutError::NoNominal { .. } => "base",
        }
    }
}
