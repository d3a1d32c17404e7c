//! One key of the format: what it holds, what holds without it, where it belongs.

use super::range::Range;

/// One key of the machine file.
#[derive(Debug)]
pub struct Key {
    /// Path with `NAME` for a named table and `[i]` for a section.
    pub path: &'static str,
    /// What it holds.
    pub kind: Kind,
    /// What holds when it is absent.
    pub need: Need,
    /// Allowed numbers.
    pub range: Range,
    /// Machines it belongs to.
    pub when: When,
    /// Meaning in one sentence.
    pub meaning: &'static str,
}

/// What a key holds. Units are SI symbols.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The format's version.
    Schema,
    /// Free text.
    Text,
    /// A quantity.
    Number(&'static str),
    /// A quantity or one of some words.
    NumberOr(&'static str, &'static [&'static str]),
    /// A whole number.
    Count,
    /// One of some words.
    Choice(&'static [&'static str]),
    /// `[x, y]`.
    Vector(&'static str),
    /// A quantity (times the unit matrix) or `[[xx, xy], [yx, yy]]`; the range is that of the scalar.
    Matrix(&'static str),
    /// A quantity (the same along X and Y) or `[x, y]`.
    Diagonal(&'static str),
    /// A list of quantities.
    List(&'static str),
}

/// What holds when a key is absent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Need {
    /// It may not be absent.
    Required,
    /// A number (for vectors: both components).
    Number(f64),
    /// A word.
    Word(&'static str),
    /// Nothing; says what then happens.
    Optional(&'static str),
}

/// Machines a key belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum When {
    /// All.
    Always,
    /// `rotor.kind = "shaft"`.
    Shaft,
    /// `rotor.kind = "point-mass"`.
    PointMass,
    /// `kind = "flexible"` of its diaphragm.
    Flexible,
    /// `kind = "radial-spring"` of its diaphragm.
    RadialSpring,
    /// `kind = "linear"` of its bearing.
    LinearBearing,
    /// `kind = "table"` of its bearing.
    TableBearing,
}

impl When {
    /// The condition in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            When::Always => "",
            When::Shaft => "rotor.kind = \"shaft\"",
            When::PointMass => "rotor.kind = \"point-mass\"",
            When::Flexible => "kind = \"flexible\"",
            When::RadialSpring => "kind = \"radial-spring\"",
            When::LinearBearing => "kind = \"linear\"",
            When::TableBearing => "kind = \"table\"",
        }
    }
}

impl Key {
    /// SI unit, "" for a pure number, count or word.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match self.kind {
            Kind::Number(unit)
            | Kind::NumberOr(unit, _)
            | Kind::Vector(unit)
            | Kind::Matrix(unit)
            | Kind::Diagonal(unit)
            | Kind::List(unit) => unit,
            Kind::Schema | Kind::Text | Kind::Count | Kind::Choice(_) => "",
        }
    }

    /// Last segment of the path.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.path.rsplit('.').next().unwrap_or(self.path)
    }
}
