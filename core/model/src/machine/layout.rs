//! The slots of one machine: every scalar or choice its file could set, with the place where it stands.

use std::collections::{BTreeMap, HashMap};
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::Range as Span;

use super::schema::{Key, Kind, Need, Range, When};

/// One scalar or choice of one machine.
#[derive(Debug, Clone)]
pub(super) struct Slot {
    /// Full path: `rotor.shaft[0].diameter`, `diaphragms.mid.contact.offset[1]`.
    pub path: String,
    /// What the format says of it.
    pub key: &'static Key,
    /// Component of a vector, matrix or list.
    pub part: bool,
    /// Where its value stands, or else the table that lacks it.
    pub span: Span<usize>,
}

impl Slot {
    /// Allowed numbers: the range of a matrix key is that of its isotropic form, its components may be negative.
    pub fn range(&self) -> Range {
        if self.part && matches!(self.key.kind, Kind::Matrix(_)) { self.key.range.mirrored() } else { self.key.range }
    }

    /// The words it may hold.
    pub fn words(&self) -> &'static [&'static str] {
        match self.key.kind {
            Kind::Choice(words) | Kind::NumberOr(_, words) => words,
            _ => &[],
        }
    }

    /// What is allowed, in words.
    pub fn allowed(&self) -> String {
        let quoted = || self.words().iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ");
        match self.key.kind {
            Kind::Choice(_) => quoted(),
            Kind::NumberOr(unit, _) => format!("{}, {}", self.range().words(unit), quoted()),
            Kind::Count => format!("a whole number, {}", self.range().words("")),
            _ => self.range().words(self.key.unit()),
        }
    }
}

/// What a slot holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Scalar {
    /// Nothing.
    Absent,
    /// Something wrong that has been reported.
    Bad,
    /// A number in SI.
    Number(f64),
    /// A word of its list.
    Word(&'static str),
}

/// Who said it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Origin {
    /// The format.
    Default,
    /// The file.
    File,
    /// `set`.
    Set,
}

/// Value of a slot: all that differs between the samples of a study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct State {
    pub scalar: Scalar,
    pub origin: Origin,
}

impl State {
    /// What holds when the file says nothing.
    pub fn default_of(key: &Key) -> Self {
        let scalar = match key.need {
            Need::Required | Need::Optional(_) => Scalar::Absent,
            Need::Number(number) => Scalar::Number(number),
            Need::Word(word) => Scalar::Word(word),
        };
        Self { scalar, origin: Origin::Default }
    }
}

/// A named table or section.
#[derive(Debug, Clone)]
pub(super) struct Named {
    pub name: String,
}

/// A text of a table: it names something, and is no parameter.
#[derive(Debug, Clone)]
pub(super) struct Text {
    pub key: &'static Key,
    /// `None`: something wrong that has been reported.
    pub value: Option<String>,
    pub span: Span<usize>,
}

/// Index of each slot by its path.
pub(super) type ByPath = HashMap<String, usize, BuildHasherDefault<PathHasher>>;

/// Hash of a path, eight bytes at a time. A machine is built of hundreds of look-ups, and a hash that resists chosen keys would take a
/// third of that time; a file has at most a thousand names, so chosen collisions cost little.
#[derive(Default)]
pub(super) struct PathHasher(u64);

impl PathHasher {
    fn add(&mut self, word: u64) {
        // an odd number without structure: 2^64 over the golden section
        self.0 = (self.0.rotate_left(5) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}

impl Hasher for PathHasher {
    fn write(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks();
        words.iter().for_each(|word| self.add(u64::from_le_bytes(*word)));
        if !rest.is_empty() {
            self.add(rest.iter().fold(0, |word, byte| word << 8 | u64::from(*byte)));
        }
    }

    fn write_u8(&mut self, byte: u8) {
        self.add(u64::from(byte));
    }

    fn finish(&self) -> u64 {
        // the map takes its place from the lower bits, which depend on fewer of the path's
        self.0 ^ self.0 >> 32
    }
}

/// Everything about a machine file that `set` does not change; shared by all clones.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub file: String,
    pub text: String,
    pub name: String,
    pub slots: Vec<Slot>,
    /// Index of each slot by its path.
    pub by_path: ByPath,
    /// For each slot the `kind` slot that it depends on, and the word that must stand there.
    pub conditions: Vec<Option<(usize, &'static str)>>,
    /// Tables that the file has, by path (`rotor.damping`, `diaphragms.mid.blades`), with the place of their name.
    pub tables: BTreeMap<String, Span<usize>>,
    /// Named tables and sections by the path above them (`rotor.bearings`, `rotor.shaft`), in the order of the file.
    pub groups: BTreeMap<String, Vec<Named>>,
    /// Lengths of the lists that the file has, by path; 0 for one that could not be read.
    pub lengths: BTreeMap<String, usize>,
    /// Texts that the file has in tables, by path. They are no slots, so that a machine without them is what it was before
    /// the format had them.
    pub texts: BTreeMap<String, Text>,
}

impl Layout {
    /// Makes what slots are found by, once there are all of them.
    pub fn index(&mut self) {
        self.by_path = self.slots.iter().enumerate().map(|(index, slot)| (slot.path.clone(), index)).collect();
        self.conditions = self.slots.iter().map(|slot| self.condition(&slot.path, slot.key.when)).collect();
    }

    /// The members of a group.
    pub fn group(&self, path: &str) -> &[Named] {
        self.groups.get(path).map_or(&[], Vec::as_slice)
    }

    /// Index of a slot.
    pub fn find(&self, path: &str) -> Option<usize> {
        self.by_path.get(path).copied()
    }

    /// Where a text stands, or the innermost table of a path that the file has.
    pub fn table_span(&self, path: &str) -> Span<usize> {
        if let Some(text) = self.texts.get(path) {
            return text.span.clone();
        }
        let mut path = path;
        loop {
            if let Some(span) = self.tables.get(path) {
                return span.clone();
            }
            match path.rfind(['.', '[']) {
                Some(at) => path = &path[..at],
                None => return 0..0,
            }
        }
    }

    /// The `kind` slot a condition looks at, and the word it wants.
    pub fn condition(&self, path: &str, when: When) -> Option<(usize, &'static str)> {
        // `kind` of the table with so many steps: `diaphragms.NAME`, `rotor.bearings.NAME`
        let of_table = |steps: usize| {
            let end = path.match_indices('.').nth(steps - 1)?.0;
            self.find(&format!("{}.kind", &path[..end]))
        };
        match when {
            When::Always => None,
            When::Shaft => Some((self.find("rotor.kind")?, "shaft")),
            When::PointMass => Some((self.find("rotor.kind")?, "point-mass")),
            When::Flexible => Some((of_table(2)?, "flexible")),
            When::RadialSpring => Some((of_table(2)?, "radial-spring")),
            When::LinearBearing => Some((of_table(3)?, "linear")),
            When::TableBearing => Some((of_table(3)?, "table")),
        }
    }
}
