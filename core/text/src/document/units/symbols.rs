//! The table of unit symbols, and products of units.

use crate::document::cut;

use super::error::QuantityError;

/// Exponents of metre, kilogram, second and radian.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dimension {
    /// Length.
    pub m: i32,
    /// Mass.
    pub kg: i32,
    /// Time.
    pub s: i32,
    /// Angle: distinguishes rpm and deg from 1/s and pure numbers.
    pub rad: i32,
}

impl Dimension {
    const fn new(m: i32, kg: i32, s: i32, rad: i32) -> Self {
        Self { m, kg, s, rad }
    }

    /// Whether a quantity of dimension `given` is allowed where `self` is expected.
    ///
    /// An angle is not a pure number here ("5 1/s" is not a spin speed, "0.5 deg" not a friction coefficient), except in the denominator of a
    /// torque or stiffness, where "N m/rad" and "N m" are equivalent.
    #[must_use]
    pub fn accepts(self, given: Dimension) -> bool {
        let same_but_angle = (self.m, self.kg, self.s) == (given.m, given.kg, given.s);
        let per_angle = self.kg != 0 && (self.m, self.s) != (0, 0) && self.rad == 0 && given.rad < 0;
        same_but_angle && (self.rad == given.rad || per_angle)
    }
}

/// A unit: dimension and the factor to SI, `10^ten * num / den * pi^pi`, kept apart so that "353 mm" is 0.353 exactly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unit {
    pub dimension: Dimension,
    pub ten: i32,
    pub num: u64,
    pub den: u64,
    pub pi: i32,
}

impl Unit {
    pub const ONE: Unit = Unit { dimension: Dimension::new(0, 0, 0, 0), ten: 0, num: 1, den: 1, pi: 0 };

    /// `self * other^power`; `None` if the numbers overflow.
    pub fn times(self, other: Unit, power: i32) -> Option<Unit> {
        let steps = power.unsigned_abs();
        let (up, down) = if power >= 0 { (other.num, other.den) } else { (other.den, other.num) };
        let add = |a: i32, b: i32| a.checked_add(b.checked_mul(power)?);
        let (d, o) = (self.dimension, other.dimension);
        Some(Unit {
            dimension: Dimension::new(add(d.m, o.m)?, add(d.kg, o.kg)?, add(d.s, o.s)?, add(d.rad, o.rad)?),
            ten: add(self.ten, other.ten)?,
            num: self.num.checked_mul(up.checked_pow(steps)?)?,
            den: self.den.checked_mul(down.checked_pow(steps)?)?,
            pi: add(self.pi, other.pi)?,
        })
    }
}

struct Symbol {
    name: &'static str,
    /// SI prefixes that the symbol may have.
    prefixes: &'static str,
    unit: Unit,
}

const fn symbol(name: &'static str, prefixes: &'static str, dimension: [i32; 4], ten: i32) -> Symbol {
    ratio(name, prefixes, dimension, ten, [1, 1], 0)
}

const fn ratio(
    name: &'static str,
    prefixes: &'static str,
    [m, kg, s, rad]: [i32; 4],
    ten: i32,
    [num, den]: [u64; 2],
    pi: i32,
) -> Symbol {
    Symbol { name, prefixes, unit: Unit { dimension: Dimension::new(m, kg, s, rad), ten, num, den, pi } }
}

const SYMBOLS: &[Symbol] = &[
    symbol("m", "kdcmun", [1, 0, 0, 0], 0),
    symbol("g", "kmu", [0, 1, 0, 0], -3),
    symbol("t", "", [0, 1, 0, 0], 3),
    symbol("s", "mun", [0, 0, 1, 0], 0),
    symbol("N", "mkMG", [1, 1, -2, 0], 0),
    symbol("Pa", "kMG", [-1, 1, -2, 0], 0),
    symbol("bar", "", [-1, 1, -2, 0], 5),
    symbol("J", "mkM", [2, 1, -2, 0], 0),
    symbol("W", "mkM", [2, 1, -3, 0], 0),
    symbol("Nm", "mkM", [2, 1, -2, 0], 0),
    symbol("Ns", "", [1, 1, -1, 0], 0),
    symbol("rad", "m", [0, 0, 0, 1], 0),
    ratio("min", "", [0, 0, 1, 0], 0, [60, 1], 0),
    ratio("h", "", [0, 0, 1, 0], 0, [3600, 1], 0),
    ratio("in", "", [1, 0, 0, 0], -4, [254, 1], 0),
    ratio("ft", "", [1, 0, 0, 0], -4, [3048, 1], 0),
    ratio("mil", "", [1, 0, 0, 0], -7, [254, 1], 0),
    // The pound is 0.45359237 kg, its weight this times 9.80665 m/s2, both exactly (NIST SP 811, B.8).
    ratio("lb", "", [0, 1, 0, 0], -8, [45_359_237, 1], 0),
    ratio("lbm", "", [0, 1, 0, 0], -8, [45_359_237, 1], 0),
    ratio("lbf", "", [1, 1, -2, 0], -13, [44_482_216_152_605, 1], 0),
    // The ounce is a sixteenth of the pound, the slug 1 lbf s2/ft, the kilogram-force 1 kg times 9.80665 m/s2.
    ratio("oz", "", [0, 1, 0, 0], -12, [28_349_523_125, 1], 0),
    ratio("slug", "", [0, 1, 0, 0], -9, [44_482_216_152_605, 3048], 0),
    ratio("kgf", "", [1, 1, -2, 0], -5, [980_665, 1], 0),
    symbol("cc", "", [3, 0, 0, 0], -6),
    ratio("psi", "kM", [-1, 1, -2, 0], -5, [44_482_216_152_605, 64_516], 0),
    ratio("ksi", "", [-1, 1, -2, 0], -2, [44_482_216_152_605, 64_516], 0),
    ratio("deg", "", [0, 0, 0, 1], 0, [1, 180], 1),
    ratio("°", "", [0, 0, 0, 1], 0, [1, 180], 1),
    ratio("rev", "", [0, 0, 0, 1], 0, [2, 1], 1),
    ratio("rpm", "k", [0, 0, -1, 1], 0, [1, 30], 1),
    symbol("%", "", [0, 0, 0, 0], -2),
];

fn prefix(letter: char) -> Option<(char, i32)> {
    Some(match letter {
        'G' => ('G', 9),
        'M' => ('M', 6),
        'k' => ('k', 3),
        'd' => ('d', -1),
        'c' => ('c', -2),
        'm' => ('m', -3),
        'u' | 'µ' | 'μ' => ('u', -6),
        'n' => ('n', -9),
        _ => return None,
    })
}

/// The unit of one symbol, including a prefix.
pub(super) fn look_up(name: &str) -> Result<Unit, QuantityError> {
    // Whole symbols before prefixed ones: "min" is a minute, "m" a metre.
    if let Some(found) = SYMBOLS.iter().find(|symbol| symbol.name == name) {
        return Ok(found.unit);
    }
    let mut letters = name.chars();
    if let Some((letter, ten)) = letters.next().and_then(prefix)
        && let Some(found) =
            SYMBOLS.iter().find(|symbol| symbol.name == letters.as_str() && symbol.prefixes.contains(letter))
    {
        return Ok(Unit { ten: found.unit.ten + ten, ..found.unit });
    }
    if is_hertz(name) {
        return Err(QuantityError::Hertz { unit: name.to_owned(), instead: Vec::new() });
    }
    Err(QuantityError::UnknownUnit { unit: cut(name, 60), nearest: None })
}

/// Whether a symbol is the hertz, in any letter case and with any prefix.
fn is_hertz(name: &str) -> bool {
    let is_plain = |name: &str| name.eq_ignore_ascii_case("hz");
    let mut letters = name.chars();
    is_plain(name) || letters.next().and_then(prefix).is_some() && is_plain(letters.as_str())
}

/// Whether `name` is `spelling` with another or an additional prefix: a unit of another size, not a misspelling.
fn is_another_size(name: &str, spelling: &str) -> bool {
    let symbol_behind_prefix = |text: &str| {
        let mut letters = text.chars();
        letters.next().and_then(prefix)?;
        SYMBOLS.iter().find(|symbol| symbol.name == letters.as_str()).map(|symbol| symbol.name)
    };
    symbol_behind_prefix(name)
        .is_some_and(|symbol| spelling == symbol || symbol_behind_prefix(spelling) == Some(symbol))
}

/// Names in common use for symbols; in lower case and singular.
const NAMES: &[(&str, &str)] = &[
    ("meter", "m"),
    ("metre", "m"),
    ("micron", "um"),
    ("inch", "in"),
    ("inche", "in"),
    ("foot", "ft"),
    ("feet", "ft"),
    ("mil", "mil"),
    ("thou", "mil"),
    ("gram", "g"),
    ("tonne", "t"),
    ("ton", "t"),
    ("pound", "lb"),
    ("lb", "lb"),
    ("lb", "lbf"),
    ("second", "s"),
    ("sec", "s"),
    ("minute", "min"),
    ("hour", "h"),
    ("hr", "h"),
    ("newton", "N"),
    ("pascal", "Pa"),
    ("joule", "J"),
    ("watt", "W"),
    ("degree", "deg"),
    ("radian", "rad"),
    ("revolution", "rev"),
    ("turn", "rev"),
    ("u", "rev"),
    ("r", "rev"),
    ("percent", "%"),
];

/// Prefixes in words.
const PREFIXES: [(&str, &str); 7] =
    [("milli", "m"), ("micro", "u"), ("nano", "n"), ("centi", "c"), ("kilo", "k"), ("mega", "M"), ("giga", "G")];

/// The symbols of a unit given as a word: "inches", "kilogram", "usec".
fn named(name: &str) -> Vec<String> {
    let lower = name.to_lowercase();
    let single = lower.strip_suffix('s').filter(|rest| !rest.is_empty()).unwrap_or(&lower);
    let without = PREFIXES.iter().filter_map(|(word, letter)| Some((single.strip_prefix(word)?, *letter)));
    let with_letter = ["m", "u", "n"].into_iter().filter_map(|letter| Some((single.strip_prefix(letter)?, letter)));
    let mut readings = vec![(single, "")];
    readings.extend(without.chain(with_letter));
    let symbols = readings.into_iter().flat_map(|(word, letter)| {
        NAMES.iter().filter(move |(known, _)| *known == word).map(move |(_, symbol)| format!("{letter}{symbol}"))
    });
    symbols.filter(|symbol| look_up(symbol).is_ok()).collect()
}

/// Symbols that `name` may mean, the likeliest first: a word ("inches"), another letter case ("mpa", "RPM"), then one edit away.
pub(super) fn similar(name: &str) -> Vec<String> {
    if name.len() > 16 {
        return Vec::new();
    }
    let spellings = SYMBOLS
        .iter()
        .flat_map(|s| std::iter::once(s.name.to_owned()).chain(s.prefixes.chars().map(|p| format!("{p}{}", s.name))));
    let mut ranked: Vec<(usize, String)> = spellings
        .filter_map(|spelling| {
            let rank = match (spelling.eq_ignore_ascii_case(name), strsim::damerau_levenshtein(&spelling, name)) {
                (true, _) => 0,
                // a single letter is one edit away from every other letter
                (false, 1) if name.chars().count() > 1 && !is_another_size(name, &spelling) => {
                    1 + spelling.len().abs_diff(name.len())
                }
                _ => return None,
            };
            Some((rank, spelling))
        })
        .collect();
    ranked.sort_by_key(|(rank, _)| *rank);
    named(name).into_iter().chain(ranked.into_iter().map(|(_, spelling)| spelling)).collect()
}

/// Examples of quantities in this SI unit, for messages.
#[must_use]
pub fn examples(si: &str) -> &'static str {
    match si {
        "" => "a pure number such as 0.2 or \"20 %\"",
        "m" => "\"8 mm\", \"0.55 m\"",
        "kg" => "\"12 kg\", \"10 g\"",
        "s" => "\"6 s\", \"10 us\"",
        "rad" => "\"30 deg\", \"0.5 rad\"",
        "rad/s" => "\"1500 rpm\", \"157 rad/s\"",
        "rad/s2" => "\"50 rpm/s\", \"-3 rad/s2\"",
        "m/s" => "\"0.1 m/s\", \"5 mm/s\"",
        "m/s2" => "\"9.81 m/s2\"",
        "Pa" => "\"210 GPa\", \"2.1e11 Pa\"",
        "kg/m3" => "\"7850 kg/m3\"",
        "kg m2" => "\"490 kg m2\", \"6.5e-4 kg m^2\"",
        "N/m" => "\"6e8 N/m\", \"600 kN/mm\"",
        "N s/m" => "\"600 N s/m\", \"6e5 N s/m\"",
        "N m" => "\"30 N m\", \"1 kN m\"",
        "N m s" => "\"30 N m s\"",
        "N m s2" => "\"0.66 N m s2\"",
        "1/s" => "\"20 1/s\"",
        _ => "a number with its unit",
    }
}
