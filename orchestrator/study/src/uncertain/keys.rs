//! Keys of the distributions.

/// The distributions of `[[uncertain]]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Distribution {
    /// `mean` or `median`, `sd` or `cv`.
    Normal,
    /// `mean` or `median`, `sd` or `cv`.
    LogNormal,
    /// `lower`, `upper`.
    Uniform,
    /// `lower`, `upper`: the logarithm is uniform.
    LogUniform,
    /// `lower`, `mode`, `upper`.
    Triangular,
    /// `a`, `b` on `lower`, `upper`.
    Beta,
    /// `shape`, `scale`.
    Gamma,
    /// `shape`, `scale`.
    Weibull,
    /// `location`, `scale`; of maxima.
    Gumbel,
    /// `mean`.
    Exponential,
    /// `values`, `weights`.
    Discrete,
    /// `file`, `column`.
    Empirical,
    /// `lower`, `upper`.
    Periodic,
}

/// Type of the value of a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holds {
    /// A number in the unit of the parameter.
    Quantity,
    /// A pure number.
    Number,
    /// A list of values of the parameter.
    Values,
    /// A list of pure numbers.
    Weights,
    /// A text.
    Text,
}

/// All keys and their types.
pub(super) const KEYS: [(&str, Holds); 16] = [
    ("mean", Holds::Quantity),
    ("median", Holds::Quantity),
    ("sd", Holds::Quantity),
    ("cv", Holds::Number),
    ("lower", Holds::Quantity),
    ("upper", Holds::Quantity),
    ("mode", Holds::Quantity),
    ("a", Holds::Number),
    ("b", Holds::Number),
    ("shape", Holds::Number),
    ("scale", Holds::Quantity),
    ("location", Holds::Quantity),
    ("values", Holds::Values),
    ("weights", Holds::Weights),
    ("file", Holds::Text),
    ("column", Holds::Text),
];

/// Exactly one key of each group of `needed` is required; the others are optional.
pub(super) struct Takes {
    pub needed: &'static [&'static [&'static str]],
    pub optional: &'static [&'static str],
}

impl Distribution {
    /// All distributions with their words in a file.
    pub const ALL: [(&'static str, Distribution); 13] = [
        ("normal", Distribution::Normal),
        ("lognormal", Distribution::LogNormal),
        ("uniform", Distribution::Uniform),
        ("log-uniform", Distribution::LogUniform),
        ("triangular", Distribution::Triangular),
        ("beta", Distribution::Beta),
        ("gamma", Distribution::Gamma),
        ("weibull", Distribution::Weibull),
        ("gumbel", Distribution::Gumbel),
        ("exponential", Distribution::Exponential),
        ("discrete", Distribution::Discrete),
        ("empirical", Distribution::Empirical),
        ("periodic", Distribution::Periodic),
    ];

    /// The distribution with this word.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.iter().find(|(known, _)| *known == word).map(|(_, distribution)| *distribution)
    }

    /// Word of this distribution.
    #[must_use]
    pub fn word(self) -> &'static str {
        Self::ALL.iter().find(|(_, known)| *known == self).map_or("", |(word, _)| *word)
    }

    /// Keys of all distributions.
    #[cfg(test)]
    pub fn keys() -> impl Iterator<Item = &'static str> {
        KEYS.iter().map(|(key, _)| *key)
    }

    /// Type of the value of a key; `None`: no distribution has this key.
    #[must_use]
    pub fn holds(key: &str) -> Option<Holds> {
        KEYS.iter().find(|(known, _)| *known == key).map(|(_, holds)| *holds)
    }

    pub(super) fn takes(self) -> Takes {
        const CUT: &[&str] = &["lower", "upper"];
        let (needed, optional): (&[&[&str]], &[&str]) = match self {
            Distribution::Normal | Distribution::LogNormal => (&[&["mean", "median"], &["sd", "cv"]], CUT),
            Distribution::Uniform | Distribution::LogUniform | Distribution::Periodic => {
                (&[&["lower"], &["upper"]], &[])
            }
            Distribution::Triangular => (&[&["lower"], &["mode"], &["upper"]], &[]),
            Distribution::Beta => (&[&["a"], &["b"], &["lower"], &["upper"]], &[]),
            Distribution::Gamma | Distribution::Weibull => (&[&["shape"], &["scale"]], CUT),
            Distribution::Gumbel => (&[&["location"], &["scale"]], CUT),
            Distribution::Exponential => (&[&["mean"]], CUT),
            Distribution::Discrete => (&[&["values"]], &["weights"]),
            // the values are read from the file
            Distribution::Empirical => (&[&["file"], &["column"]], CUT),
        };
        Takes { needed, optional }
    }

    /// The keys in words: "`mean` or `median`, `sd` or `cv`; with or without `lower`, `upper`".
    #[must_use]
    pub fn keys_in_words(self) -> String {
        let takes = self.takes();
        let quoted =
            |keys: &[&str], joint: &str| keys.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(joint);
        let needed: Vec<String> = takes.needed.iter().map(|group| quoted(group, " or ")).collect();
        let needed = needed.join(", ");
        if takes.optional.is_empty() {
            needed
        } else {
            format!("{needed}; with or without {}", quoted(takes.optional, ", "))
        }
    }
}

/// Values of a list, all of one type.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Numbers (SI).
    Numbers(Vec<f64>),
    /// Words.
    Words(Vec<String>),
}

/// The keys of a table of `[[uncertain]]` as read, numbers in SI.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Written {
    /// Keys with a number, in the order of the file.
    pub numbers: Vec<(String, f64)>,
    /// `values`; for `empirical`, those of the file's column.
    pub values: Option<Values>,
    /// `weights`.
    pub weights: Option<Vec<f64>>,
    /// `file` and `column` of `empirical`, if given.
    pub texts: Vec<(String, String)>,
}

impl Written {
    /// The number of a key.
    #[must_use]
    pub fn number(&self, key: &str) -> Option<f64> {
        self.numbers.iter().find(|(known, _)| known == key).map(|(_, number)| *number)
    }

    /// Names of all given keys; the values of an empirical distribution are not a key.
    pub(super) fn names(&self, distribution: Distribution) -> Vec<&str> {
        let numbers = self.numbers.iter().map(|(key, _)| key.as_str());
        let values = self.values.as_ref().filter(|_| distribution != Distribution::Empirical).map(|_| "values");
        let weights = self.weights.as_ref().map(|_| "weights");
        numbers.chain(values).chain(weights).chain(self.texts.iter().map(|(key, _)| key.as_str())).collect()
    }
}
