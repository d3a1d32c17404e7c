//! Reads a distribution from the keys of a table, with all mistakes at once.
//!
//! ```text
//! normal     mean (= median), sd or cv |mean|
//! lognormal  mu = ln median = ln mean - sigma^2/2
//!            sigma^2 = ln(1 + cv^2) = ln(1 + (sd/mean)^2) = ln((1 + sqrt(1 + 4 (sd/median)^2))/2)
//! ```
//! Moments and medians apply before truncation.

use super::Uncertain;
use super::continuous::Continuous;
use super::discrete::Discrete;
use super::empirical::Empirical;
use super::error::UncertainError;
use super::keys::{Distribution, Holds, KEYS, Values, Written};
use super::law::Law;
use super::words::law_in_words;
use bladeoff_numerics::probability::Beta;
use bladeoff_text::document::units::format_quantity;

/// Most values of a discrete parameter.
const MOST_VALUES: usize = 10_000;
/// Smallest distance of a design's coordinates from 0 and 1.
const NEAREST: f64 = 1.0 / (1u64 << 53) as f64;

impl Uncertain {
    /// The distribution of a table; `unit` is the SI unit of the parameter.
    ///
    /// # Errors
    /// All mistakes, in the order of the keys of [`Written`], missing keys last.
    pub fn new(distribution: Distribution, written: &Written, unit: &str) -> Result<Self, Vec<UncertainError>> {
        let mut reader = Reader { distribution, written, unit, errors: Vec::new() };
        reader.keys();
        reader.numbers();
        reader.lists();
        if reader.errors.is_empty() {
            reader.relations();
        }
        if !reader.errors.is_empty() {
            return Err(reader.errors);
        }
        reader.law().map_err(|error| vec![error])
    }
}

struct Reader<'a> {
    distribution: Distribution,
    written: &'a Written,
    unit: &'a str,
    errors: Vec<UncertainError>,
}

impl Reader<'_> {
    /// Checks which keys are present.
    fn keys(&mut self) {
        let takes = self.distribution.takes();
        let names = self.written.names(self.distribution);
        for (place, key) in names.iter().enumerate() {
            let known = takes.needed.iter().copied().flatten().chain(takes.optional).any(|known| known == key);
            if !known {
                self.errors.push(UncertainError::Surplus { key: (*key).to_owned(), distribution: self.distribution });
                continue;
            }
            let Some(group) = takes.needed.iter().find(|group| group.contains(key)) else { continue };
            if let Some(other) = group.iter().find(|other| *other != key && names[..place].contains(other)) {
                self.errors.push(UncertainError::Both { key: (*key).to_owned(), other });
            }
        }
        for keys in takes.needed {
            if !keys.iter().any(|key| names.contains(key)) {
                self.errors.push(UncertainError::Missing { keys, distribution: self.distribution });
            }
        }
    }

    fn shown(&self, key: &str, number: f64) -> String {
        let quantity = KEYS.iter().any(|(known, holds)| *known == key && *holds == Holds::Quantity);
        format_quantity(number, if quantity { self.unit } else { "" })
    }

    fn refuse(&mut self, key: &str, number: f64, allowed: impl Into<String>) {
        let given = self.shown(key, number);
        self.errors.push(UncertainError::Value { key: key.to_owned(), given, allowed: allowed.into() });
    }

    /// Checks each number alone.
    fn numbers(&mut self) {
        use Distribution::{Exponential, LogNormal, LogUniform, Normal};
        for (key, number) in &self.written.numbers {
            let positive = matches!(
                (key.as_str(), self.distribution),
                ("sd" | "cv" | "a" | "b" | "shape" | "scale", _)
                    | ("mean" | "median", LogNormal | Exponential)
                    | ("lower" | "upper", LogUniform)
            );
            if !number.is_finite() {
                self.refuse(key, *number, "a finite number");
            } else if positive && *number <= 0.0 {
                self.refuse(key, *number, "above 0");
            } else if matches!(key.as_str(), "a" | "b" | "shape") && !(1e-3..=1e6).contains(number) {
                // range in which the quantiles were verified
                self.refuse(key, *number, "0.001 to 1e6");
            } else if key == "cv"
                && self.distribution == Normal
                && self.number("mean").or(self.number("median")) == Some(0.0)
            {
                self.refuse(key, *number, "`sd` in place of `cv` where the mean is 0");
            }
        }
    }

    /// Checks each list alone.
    fn lists(&mut self) {
        let mut count = None;
        if let Some(values) = &self.written.values {
            let length = match values {
                Values::Numbers(numbers) => numbers.len(),
                Values::Words(words) => words.len(),
            };
            count = Some(length);
            let (key, most) = match self.distribution {
                Distribution::Empirical => ("column", usize::MAX),
                _ => ("values", MOST_VALUES),
            };
            let least = if self.distribution == Distribution::Empirical { 2 } else { 1 };
            if length < least || length > most {
                let allowed = if length < least { format!("at least {least}") } else { format!("at most {most}") };
                self.errors.push(UncertainError::Length { key, given: length, allowed });
            }
            match values {
                Values::Numbers(numbers) => self.numbers_of(key, numbers),
                Values::Words(words) => self.words_of(key, words),
            }
        }
        let Some(weights) = &self.written.weights else { return };
        for (position, weight) in weights.iter().enumerate() {
            if !(weight.is_finite() && *weight >= 0.0) {
                let (given, allowed) = (weight.to_string(), "0 or more".to_owned());
                self.errors.push(UncertainError::Element { key: "weights", position, given, allowed });
            }
        }
        if let Some(count) = count.filter(|count| *count != weights.len()) {
            let allowed = format!("{count}, one for each of `values`");
            self.errors.push(UncertainError::Length { key: "weights", given: weights.len(), allowed });
        } else if !weights.is_empty() && weights.iter().all(|weight| *weight == 0.0) {
            self.refuse("weights", 0.0, "at least one above 0");
        }
    }

    fn numbers_of(&mut self, key: &'static str, numbers: &[f64]) {
        for (position, number) in numbers.iter().enumerate() {
            if !number.is_finite() {
                let given = number.to_string();
                self.errors.push(UncertainError::Element {
                    key,
                    position,
                    given,
                    allowed: "a finite number".to_owned(),
                });
            }
        }
        if self.distribution == Distribution::Discrete && numbers.len() <= MOST_VALUES {
            let mut order: Vec<usize> = (0..numbers.len()).collect();
            // `+ 0.0` makes -0 equal to 0
            order.sort_by(|&a, &b| (numbers[a] + 0.0).total_cmp(&(numbers[b] + 0.0)).then(a.cmp(&b)));
            let mut again: Vec<usize> =
                order.windows(2).filter(|pair| numbers[pair[0]] == numbers[pair[1]]).map(|pair| pair[1]).collect();
            again.sort_unstable();
            for position in again {
                let given = format_quantity(numbers[position], self.unit);
                self.errors.push(UncertainError::Element {
                    key,
                    position,
                    given,
                    allowed: "each value once".to_owned(),
                });
            }
        }
        if self.distribution == Distribution::Empirical
            && numbers.len() > 1
            && numbers.iter().all(|number| *number == numbers[0])
        {
            let given = format!("{} values, all the same", numbers.len());
            let allowed = "at least two different values".to_owned();
            self.errors.push(UncertainError::Value { key: key.to_owned(), given, allowed });
        }
    }

    fn words_of(&mut self, key: &'static str, words: &[String]) {
        if self.distribution == Distribution::Empirical {
            let allowed = "a column of numbers".to_owned();
            self.errors.push(UncertainError::Value { key: key.to_owned(), given: "words".to_owned(), allowed });
            return;
        }
        let mut seen = std::collections::HashSet::new();
        for (position, word) in words.iter().enumerate() {
            if !seen.insert(word) {
                let given = format!("{word:?}");
                self.errors.push(UncertainError::Element {
                    key,
                    position,
                    given,
                    allowed: "each value once".to_owned(),
                });
            }
        }
    }

    fn number(&self, key: &str) -> Option<f64> {
        self.written.number(key)
    }

    /// Checks relations between keys that are each valid.
    fn relations(&mut self) {
        let (Some(lower), Some(upper)) = (self.number("lower"), self.number("upper")) else { return };
        if lower >= upper {
            let than = format!("below `upper` = {}", self.shown("upper", upper));
            self.refuse("lower", lower, than);
        } else if !(upper - lower).is_finite() {
            self.refuse("upper", upper, "less than 1e308 above `lower`");
        } else if let Some(mode) = self.number("mode").filter(|mode| *mode < lower || *mode > upper) {
            let within = format!("{} to {}", self.shown("lower", lower), self.shown("upper", upper));
            self.refuse("mode", mode, within);
        }
    }

    /// The distribution, from valid keys.
    fn law(&self) -> Result<Uncertain, UncertainError> {
        let of = |key: &str| self.number(key).expect("a needed key is there");
        let law = match self.distribution {
            Distribution::Periodic => return Ok(Uncertain::Periodic(of("lower"), of("upper"))),
            Distribution::Discrete => {
                let values = self.written.values.clone().expect("a needed key is there");
                let count = match &values {
                    Values::Numbers(numbers) => numbers.len(),
                    Values::Words(words) => words.len(),
                };
                let weights = self.written.weights.clone().unwrap_or_else(|| vec![1.0; count]);
                return Ok(Uncertain::Discrete(Discrete::new(values, &weights)));
            }
            Distribution::Empirical => return self.empirical(),
            Distribution::Normal => {
                let mean = self.number("mean").unwrap_or_else(|| of("median"));
                Law::Normal(mean, self.number("sd").unwrap_or_else(|| of("cv") * mean.abs()))
            }
            Distribution::LogNormal => {
                let square = match (self.number("cv"), self.number("mean")) {
                    (Some(cv), _) => libm::log1p(cv * cv),
                    (None, Some(mean)) => {
                        let cv = of("sd") / mean;
                        libm::log1p(cv * cv)
                    }
                    // w = e^(sigma^2): w^2 - w = (sd/median)^2, and w - 1 without cancellation
                    (None, None) => {
                        let ratio = of("sd") / of("median");
                        let root = libm::sqrt(1.0 + 4.0 * ratio * ratio);
                        libm::log1p(2.0 * ratio * ratio / (1.0 + root))
                    }
                };
                let mu = match self.number("median") {
                    Some(median) => libm::log(median),
                    None => libm::log(of("mean")) - 0.5 * square,
                };
                Law::LogNormal(mu, libm::sqrt(square))
            }
            Distribution::Uniform => Law::Uniform(of("lower"), of("upper")),
            Distribution::LogUniform => Law::LogUniform(of("lower"), of("upper")),
            Distribution::Triangular => Law::Triangular(of("lower"), of("mode"), of("upper")),
            Distribution::Beta => Law::Beta(Beta::new(of("a"), of("b")), of("lower"), of("upper")),
            Distribution::Gamma => Law::Gamma(of("shape"), of("scale")),
            Distribution::Weibull => Law::Weibull(of("shape"), of("scale")),
            Distribution::Gumbel => Law::Gumbel(of("location"), of("scale")),
            Distribution::Exponential => Law::Exponential(of("mean")),
        };
        let (lower, upper) = self.cut();
        let said = law_in_words(self.distribution, self.written, self.unit);
        let law = Continuous::new(law, lower, upper, said.clone()).map_err(|left| self.nothing_left(left, &said))?;
        let extremes = [law.quantile(NEAREST, 1.0), law.quantile(1.0, NEAREST)];
        let (mean, sd) = law.moments();
        if [extremes[0], extremes[1], mean, sd].iter().all(|value| value.is_finite()) {
            return Ok(Uncertain::Continuous(law));
        }
        let wide = ["sd", "cv", "shape", "scale", "mean", "upper"];
        let key = wide.into_iter().find(|key| self.number(key).is_some()).unwrap_or("distribution");
        let given = self.number(key).map_or_else(String::new, |number| self.shown(key, number));
        let allowed = match key {
            "shape" => "a larger shape, or `upper`".to_owned(),
            _ => format!("a smaller `{key}`, or `lower` and `upper`"),
        };
        Err(UncertainError::TooWide { key: key.to_owned(), given, law: said, allowed })
    }

    /// Limits of truncation, if `lower` and `upper` are not parameters of the distribution.
    fn cut(&self) -> (Option<f64>, Option<f64>) {
        if self.distribution.takes().optional.contains(&"lower") {
            (self.number("lower"), self.number("upper"))
        } else {
            (None, None)
        }
    }

    fn nothing_left(&self, probability: f64, law: &str) -> UncertainError {
        let key = if self.cut().0.is_some() { "lower" } else { "upper" };
        let shown = |key: &'static str| self.number(key).map(|number| self.shown(key, number));
        let between = match (shown("lower"), shown("upper")) {
            (Some(lower), Some(upper)) => format!("{lower} to {upper}"),
            (Some(lower), None) => format!("above {lower}"),
            (_, upper) => format!("below {}", upper.unwrap_or_default()),
        };
        UncertainError::NothingLeft { key, between, probability, law: law.to_owned() }
    }

    fn empirical(&self) -> Result<Uncertain, UncertainError> {
        let Some(Values::Numbers(numbers)) = &self.written.values else {
            // the reader of the file has reported why it is unreadable
            return Err(UncertainError::Length { key: "column", given: 0, allowed: "at least 2".to_owned() });
        };
        // `+ 0.0` makes -0 equal to 0
        let mut sorted: Vec<f64> = numbers.iter().map(|number| number + 0.0).collect();
        sorted.sort_by(f64::total_cmp);
        let (lower, upper) = self.cut();
        let law = Empirical::new(sorted, lower, upper);
        if law.left() > 0.0 {
            return Ok(Uncertain::Empirical(law));
        }
        let said = law_in_words(self.distribution, self.written, self.unit);
        Err(self.nothing_left(0.0, &said))
    }
}
