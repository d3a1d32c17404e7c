//! The slots of one machine: every scalar or choice that its file can set, with its position.

use std::collections::{BTreeMap, HashMap};
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::Range as Span;

use super::schema::{Key, Kind, Need, Range, When};

/// One scalar or choice of a machine.
#[derive(Debug, Clone)]
pub(super) struct Slot {
    /// Full path: `rotor.shaft[0].diameter`, `diaphragms.mid.contact.offset[1]`.
    pub path: String,
    /// Entry of the slot in the table of keys.
    pub key: &'static Key,
    /// Whether the slot is a component of a vector, matrix or list.
    pub part: bool,
    /// Position of the value, or of the table without it.
    pub span: Span<usize>,
}

impl Slot {
    /// Allowed numbers. The range of a matrix key applies to its isotropic form; its components may be negative.
    pub fn range(&self) -> Range {
        if self.part && matches!(self.key.kind, Kind::Matrix(_)) { self.key.range.mirrored() } else { self.key.range }
    }

    /// Allowed words.
    pub fn words(&self) -> &'static [&'static str] {
        match self.key.kind {
            Kind::Choice(words) | Kind::NumberOr(_, words) => words,
            _ => &[],
        }
    }

    /// Description of the allowed values.
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

/// Value of a slot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Scalar {
    /// No value.
    Absent,
    /// An invalid value that has been reported.
    Bad,
    /// A number in SI.
    Number(f64),
    /// One of the slot's allowed words.
    Word(&'static str),
}

/// Source of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Origin {
    /// Default of the format.
    Default,
    /// Machine file.
    File,
    /// Call of `set`.
    Set,
}

/// Value of a slot, the only part that differs between the samples of a study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct State {
    pub scalar: Scalar,
    pub origin: Origin,
}

impl State {
    /// The value of a key that the file does not have.
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

/// A text of a table, such as a reference by name; not a parameter.
#[derive(Debug, Clone)]
pub(super) struct Text {
    pub key: &'static Key,
    /// `None`: invalid, which has been reported.
    pub value: Option<String>,
    pub span: Span<usize>,
}

/// Index of each slot by its path.
pub(super) type ByPath = HashMap<String, usize, BuildHasherDefault<PathHasher>>;

/// Hash of a path, eight bytes at a time. Building a machine takes hundreds of look-ups, a third of whose time would go into a hash that
/// resists chosen keys. A file has at most a thousand names, so chosen collisions cost little.
#[derive(Default)]
pub(super) struct PathHasher(u64);

impl PathHasher {
    fn add(&mut self, word: u64) {
        // an odd number without structure: 2^64 divided by the golden ratio
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
        // the map uses the lower bits, which depend on fewer bytes of the path
        self.0 ^ self.0 >> 32
    }
}

/// Everything in a machine file that `set` does not change; shared by all clones.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub file: String,
    pub text: String,
    pub name: String,
    pub slots: Vec<Slot>,
    /// Index of each slot by its path.
    pub by_path: ByPath,
    /// For each slot, the `kind` slot that it depends on, and the word required there.
    pub conditions: Vec<Option<(usize, &'static str)>>,
    /// Tables of the file by path (`rotor.damping`, `diaphragms.mid.blades`), with the position of their name.
    pub tables: BTreeMap<String, Span<usize>>,
    /// Named tables and sections by their parent path (`rotor.bearings`, `rotor.shaft`), in the order of the file.
    pub groups: BTreeMap<String, Vec<Named>>,
    /// Lengths of the file's lists by path; 0 for an unreadable list.
    pub lengths: BTreeMap<String, usize>,
    /// Texts in the file's tables, by path. They are not slots, so that the identity of a machine without them is that of earlier formats.
    pub texts: BTreeMap<String, Text>,
}

impl Layout {
    /// Builds the indices once all slots are present.
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

    /// Position of a text, or of the innermost table of the path that the file has.
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

    /// The `kind` slot on which a key depends, and the required word.
    pub fn condition(&self, path: &str, when: When) -> Option<(usize, &'static str)> {
        // `kind` of the table with this number of path segments: `diaphragms.NAME`, `rotor.bearings.NAME`
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
