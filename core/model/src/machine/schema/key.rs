//! One key of the format: type, default, condition.

use super::range::Range;

/// One key of the machine file.
#[derive(Debug)]
pub struct Key {
    /// Path with `NAME` for a named table and `[i]` for a section.
    pub path: &'static str,
    /// Type.
    pub kind: Kind,
    /// Default.
    pub need: Need,
    /// Allowed numbers.
    pub range: Range,
    /// Machines that have this key.
    pub when: When,
    /// Meaning in one sentence.
    pub meaning: &'static str,
}

/// Type of a key. Units are SI symbols.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Version of the format.
    Schema,
    /// Free text.
    Text,
    /// A quantity.
    Number(&'static str),
    /// A quantity or one of these words.
    NumberOr(&'static str, &'static [&'static str]),
    /// A whole number.
    Count,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// `[x, y]`.
    Vector(&'static str),
    /// A quantity (times the identity matrix) or `[[xx, xy], [yx, yy]]`; the range applies to the scalar.
    Matrix(&'static str),
    /// A quantity (for both X and Y) or `[x, y]`.
    Diagonal(&'static str),
    /// A list of quantities.
    List(&'static str),
}

/// Default of a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Need {
    /// No default: the key is required.
    Required,
    /// A number (for vectors: both components).
    Number(f64),
    /// A word.
    Word(&'static str),
    /// No value; the text describes the effect.
    Optional(&'static str),
}

/// Machines that have a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum When {
    /// All machines.
    Always,
    /// `rotor.kind = "shaft"`.
    Shaft,
    /// `rotor.kind = "point-mass"`.
    PointMass,
    /// `kind = "flexible"` in the table of the diaphragm.
    Flexible,
    /// `kind = "radial-spring"` in the table of the diaphragm.
    RadialSpring,
    /// `kind = "linear"` in the table of the bearing.
    LinearBearing,
    /// `kind = "table"` in the table of the bearing.
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
