//! Errors of `[[correlation]]`.

use thiserror::Error;

/// A mistake; [`CorrelationError::pair`] returns its table.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CorrelationError {
    /// A parameter correlated with itself.
    #[error("`between` names {name} twice; allowed: two different parameters")]
    Itself {
        /// Number of the table.
        pair: usize,
        /// The parameter.
        name: String,
    },
    /// A repeated pair.
    #[error("table {} already gives the correlation of {a} and {b}", first + 1)]
    Repeated {
        /// Number of the table.
        pair: usize,
        /// The earlier one.
        first: usize,
        /// The parameters.
        a: String,
        /// The other.
        b: String,
    },
    /// A value that is not between -1 and 1.
    #[error(
        "`{key}` = {given}; allowed: above -1 and below 1 (use [[derived]] for a parameter that another one determines)"
    )]
    Value {
        /// Number of the table.
        pair: usize,
        /// The key.
        key: &'static str,
        /// Value given.
        given: f64,
    },
    /// `rank` or `linear` for values without a continuous order.
    #[error(
        "`{key}` of {name}, which is {law}; allowed: `normal`, the correlation of the normal numbers behind the values"
    )]
    NotContinuous {
        /// Number of the table.
        pair: usize,
        /// The key.
        key: &'static str,
        /// The parameter.
        name: String,
        /// Its kind.
        law: &'static str,
    },
    /// The two distributions cannot have this linear correlation.
    #[error(
        "`linear` = {given}: the distributions of {a} and {b} can have from {low:.6} to {high:.6}; allowed: between these, or `rank`"
    )]
    Unreachable {
        /// Number of the table.
        pair: usize,
        /// Value given.
        given: f64,
        /// The parameters.
        a: String,
        /// The other.
        b: String,
        /// Smallest possible value.
        low: f64,
        /// Largest possible value.
        high: f64,
    },
    /// A correlation that could not be computed with the required accuracy.
    #[error(
        "`linear` = {given} of {a} and {b} cannot be computed to 1e-8 (only to {bound:.0e}): {reason}; allowed: `rank`"
    )]
    Unresolved {
        /// Number of the table.
        pair: usize,
        /// Value given.
        given: f64,
        /// The parameters.
        a: String,
        /// The other.
        b: String,
        /// Accuracy reached.
        bound: f64,
        /// Reason.
        reason: &'static str,
    },
    /// Each correlation is possible, but not all together.
    #[error(
        "these correlations contradict each other: their matrix is not positive definite (one parameter would be \
         fixed by others); the nearest possible ones: {}",
        in_words(nearest)
    )]
    Impossible {
        /// Index of the first table of the pairs.
        pair: usize,
        /// The nearest possible correlations, including those not given if they are not 0.
        nearest: Vec<Possible>,
    },
}

/// A pair of the nearest possible matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct Possible {
    /// Index of the table, if the pair was given.
    pub pair: Option<usize>,
    /// The parameters.
    pub names: [String; 2],
    /// Kind of correlation: `rank`, `linear` or `normal`.
    pub key: &'static str,
    /// Value given.
    pub given: Option<f64>,
    /// Nearest possible value.
    pub nearest: f64,
}

/// Most pairs that are listed.
const SHOWN: usize = 20;

fn in_words(nearest: &[Possible]) -> String {
    let one = |pair: &Possible| {
        let [a, b] = &pair.names;
        let given = pair.given.map_or_else(|| "not given".to_owned(), |given| format!("given: {given}"));
        format!("{a} and {b} {} = {} ({given})", pair.key, pair.nearest)
    };
    let shown: Vec<String> = nearest.iter().take(SHOWN).map(one).collect();
    let more = match nearest.len().saturating_sub(SHOWN) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    shown.join(", ") + &more
}

impl CorrelationError {
    /// The table at fault, in the order of the file.
    #[must_use]
    pub fn pair(&self) -> usize {
        match self {
            CorrelationError::Itself { pair, .. }
            | CorrelationError::Repeated { pair, .. }
            | CorrelationError::Value { pair, .. }
            | CorrelationError::NotContinuous { pair, .. }
            | CorrelationError::Unreachable { pair, .. }
            | CorrelationError::Unresolved { pair, .. }
            | CorrelationError::Impossible { pair, .. } => *pair,
        }
    }
}
