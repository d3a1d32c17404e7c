//! Refinement of a map of given values: between combinations of different regime, or on different sides of the event.
//!
//! The values of both axes form the finest grid. Some of its combinations are computed first, spread evenly over both axes. A rectangle
//! between them is halved along both axes as long as any two results on it differ:
//!
//! ```text
//! a . . . a     a . a . a     a . a . a      a, b  computed, of different kinds
//! . . . . .     . . . . .     . . + + +         +  next
//! . . . . .     a . a . b     a . a + b
//! . . . . .     . . . . .     . . + + +
//! a . . . b     a . a . b     a . a . b
//! ```
//! The sides belong to a rectangle: if the neighbour's half turns out to be of a different kind, the rectangle that shares the side is halved
//! too. [`Grid::next`] has no state: it depends on the known kinds only, so a resumed run continues with the same combinations.
//!
//! Limits: an island of another kind that contains none of the first combinations is not found, nor is a tongue between two of them. The
//! event boundary is where half of the starts of a combination have the event; the line of a rarer event (a share of 5 %) lies elsewhere.
//! With bad runs the event counts only if they do not determine it. A combination in which every run is bad has no kind, so failures are
//! not refined.
//!
//! Verified by `tests/refining.rs`.

use super::Map;
use std::collections::{BTreeMap, BTreeSet};

/// A combination: indices of its two values on the axes, ascending.
pub type Place = (usize, usize);

/// Share of the starts from which a combination counts as one with the event.
const HALF: f64 = 0.5;

/// Kind of a combination: in each panel its regime and whether it has the event, as numbers; `None` if unknown.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Kind(Vec<Option<usize>>);

impl Kind {
    /// Merges another kind into this one. Returns whether they differ where both are known.
    fn differs(&mut self, other: &Self) -> bool {
        self.0.resize(self.0.len().max(other.0.len()), None);
        let mut differs = false;
        for (own, other) in self.0.iter_mut().zip(&other.0) {
            differs |= own.is_some() && other.is_some() && *own != *other;
            *own = own.or(*other);
        }
        differs
    }
}

/// Kinds of the combinations that have runs, from the panels of a map; differences and smoothed panels are ignored. `axes`:
/// all values of the finest grid, ascending.
#[must_use]
pub fn kinds(maps: &[Map], axes: [&[f64]; 2]) -> BTreeMap<Place, Kind> {
    let panels: Vec<&Map> = maps.iter().filter(|map| map.difference.is_none() && !map.is_smoothed()).collect();
    let mut found: BTreeMap<Place, Kind> = BTreeMap::new();
    let place = |axis: &[f64], value: f64| axis.binary_search_by(|known| known.total_cmp(&value)).ok();
    for (panel, map) in panels.iter().enumerate() {
        for cell in &map.cells {
            let (Some(x), Some(y)) = (place(axes[0], cell.x), place(axes[1], cell.y)) else { continue };
            let kind = found.entry((x, y)).or_insert_with(|| Kind(vec![None; 2 * panels.len()]));
            let regime = cell.regime.as_ref();
            kind.0[2 * panel] = regime.and_then(|regime| map.regimes.iter().position(|known| known == regime));
            let harmless = cell.estimate.map(|share| share >= HALF);
            let is_sure = harmless == cell.estimate_if_bad_harmful.map(|share| share >= HALF);
            kind.0[2 * panel + 1] = harmless.filter(|_| map.is_share() && is_sure).map(usize::from);
        }
    }
    found
}

/// A rectangle of the grid: first and last index along each axis.
type Sides = [(usize, usize); 2];

/// The finest grid of a map, and its lines that are computed first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Grid {
    lines: [Vec<usize>; 2],
}

impl Grid {
    /// A grid with these numbers of values along each axis, and of first lines, evenly spread; `None` if there are fewer than 2 first lines, or
    /// more than values.
    #[must_use]
    pub fn new(lengths: [usize; 2], first: [usize; 2]) -> Option<Self> {
        let fits = (0..2).all(|axis| (2..=lengths[axis]).contains(&first[axis]));
        let lines = |axis: usize| (0..first[axis]).map(|at| at * (lengths[axis] - 1) / (first[axis] - 1)).collect();
        fits.then(|| Self { lines: [lines(0), lines(1)] })
    }

    /// Combinations computed first.
    #[must_use]
    pub fn first(&self) -> Vec<Place> {
        self.lines[0].iter().flat_map(|&x| self.lines[1].iter().map(move |&y| (x, y))).collect()
    }

    /// Combinations to compute next, at most `room`: first [`Grid::first`] regardless of the room, then those that complete the rectangles
    /// to be halved, the largest rectangles first. A larger room returns a superset.
    #[must_use]
    pub fn next(&self, known: &BTreeMap<Place, Kind>, room: usize) -> Next {
        let missing: Vec<Place> = self.first().into_iter().filter(|place| !known.contains_key(place)).collect();
        if !missing.is_empty() {
            return Next { places: missing, is_all: true };
        }
        let mut halved = Halved { depth: usize::MAX, missing: Vec::new() };
        for x in self.lines[0].windows(2) {
            for y in self.lines[1].windows(2) {
                halve([(x[0], x[1]), (y[0], y[1])], 0, known, &mut halved);
            }
        }
        // if the room does not suffice, the rectangles are taken from all over the map: every second, every fourth, ... first
        let mut order: Vec<usize> = (0..halved.missing.len()).collect();
        order.sort_unstable_by_key(|at| at.reverse_bits());
        let (mut next, mut is_all) = (BTreeSet::new(), true);
        for at in order {
            let more: Vec<Place> = halved.missing[at].iter().copied().filter(|place| !next.contains(place)).collect();
            if next.len() + more.len() > room {
                is_all = false;
                break;
            }
            next.extend(more);
        }
        Next { places: next.into_iter().collect(), is_all }
    }
}

/// Combinations to compute next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Next {
    /// The combinations, ascending; empty if all known differences are between adjacent combinations.
    pub places: Vec<Place>,
    /// Whether the room sufficed for all rectangles to be halved; if not, the refinement ends.
    pub is_all: bool,
}

/// Missing combinations of the largest rectangles to be halved.
struct Halved {
    depth: usize,
    missing: Vec<Vec<Place>>,
}

/// Collects the missing combinations of a rectangle, or of its existing halves.
fn halve(sides: Sides, depth: usize, known: &BTreeMap<Place, Kind>, halved: &mut Halved) {
    let lines = sides.map(middle);
    let is_finest = lines.iter().all(|lines| lines.len() == 2);
    if depth > halved.depth || is_finest || !has_unlike(sides, known) {
        return;
    }
    let all = lines[0].iter().flat_map(|&x| lines[1].iter().map(move |&y| (x, y)));
    let missing: Vec<Place> = all.filter(|place| !known.contains_key(place)).collect();
    if missing.is_empty() {
        for x in lines[0].windows(2) {
            for y in lines[1].windows(2) {
                halve([(x[0], x[1]), (y[0], y[1])], depth + 1, known, halved);
            }
        }
        return;
    }
    if depth < halved.depth {
        (halved.depth, halved.missing) = (depth, Vec::new());
    }
    halved.missing.push(missing);
}

/// First, middle and last index of a side; without the middle if first and last are adjacent.
fn middle((first, last): (usize, usize)) -> Vec<usize> {
    let middle = first + (last - first) / 2;
    if middle > first { vec![first, middle, last] } else { vec![first, last] }
}

/// Whether any two known kinds on a rectangle differ, sides included.
fn has_unlike([x, y]: Sides, known: &BTreeMap<Place, Kind>) -> bool {
    let mut seen = Kind::default();
    (x.0..=x.1).any(|x| known.range((x, y.0)..=(x, y.1)).any(|(_, kind)| seen.differs(kind)))
}
