//! Refinement of a map of given values: between combinations of unlike regime, or on different sides of the event.
//!
//! The values of both axes are the finest grid there will be. Of it some are computed first, evenly over both axes; a rectangle between
//! them is halved along both axes as long as anything known on it differs:
//!
//! ```text
//! a . . . a     a . a . a     a . a . a      a, b  known, of unlike kinds
//! . . . . .     . . . . .     . . + + +         +  next
//! . . . . .     a . a . b     a . a + b
//! . . . . .     . . . . .     . . + + +
//! a . . . b     a . a . b     a . a . b
//! ```
//! What is known on a rectangle is known on its sides as well: where a neighbour's half turns out to be of another kind, the rectangle
//! that shares the side is halved too. [`Grid::next`] remembers nothing: it is a function of what is known, so whoever has the rows of a look
//! has what comes next, whether or not a run was ended before.
//!
//! Limits: an island of another kind that contains none of the first combinations is not seen, nor a tongue between two of them. The event
//! changes where half of a combination's starts have it; a rarer one (a share of 5 %) has its line elsewhere. With bad runs the event
//! counts only where they do not decide it; a combination of which every run is bad differs from none, so failures are not refined.
//!
//! Verified by `tests/refining.rs`.

use super::Map;
use std::collections::{BTreeMap, BTreeSet};

/// A combination: the places of its two values among those of the axes, ascending.
pub type Place = (usize, usize);

/// Share of the starts from which on a combination counts as one with the event.
const HALF: f64 = 0.5;

/// What a combination is: in each panel its regime and whether it has the event, as numbers; `None`: not known.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Kind(Vec<Option<usize>>);

impl Kind {
    /// Takes in what another one is; whether they differ in anything that is known of both.
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

/// What is known of the combinations that have runs, from the panels of a map; differences and smoothed panels say nothing. `axes`:
/// the values that there will be, ascending.
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

/// A rectangle of the grid: first and last place along each axis.
type Sides = [(usize, usize); 2];

/// The combinations of a map that may be computed, and those that are computed first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Grid {
    lines: [Vec<usize>; 2],
}

impl Grid {
    /// Of so many values along each axis, of which so many come first, evenly spread; `None`: fewer than 2 of them, or more than there are.
    #[must_use]
    pub fn new(lengths: [usize; 2], first: [usize; 2]) -> Option<Self> {
        let fits = (0..2).all(|axis| (2..=lengths[axis]).contains(&first[axis]));
        let lines = |axis: usize| (0..first[axis]).map(|at| at * (lengths[axis] - 1) / (first[axis] - 1)).collect();
        fits.then(|| Self { lines: [lines(0), lines(1)] })
    }

    /// The combinations that are computed first.
    #[must_use]
    pub fn first(&self) -> Vec<Place> {
        self.lines[0].iter().flat_map(|&x| self.lines[1].iter().map(move |&y| (x, y))).collect()
    }

    /// What comes next, with room for so many: first [`Grid::first`], whatever the room, then what rectangles lack that are to be halved, the
    /// largest before smaller ones. What comes with less room also comes with more.
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
        // where there is no room for all of them, they are spread over the map: every second, every fourth, ... rectangle first
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

/// What comes next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Next {
    /// The combinations, ascending. None: whatever differs is next to each other, as far as it is known.
    pub places: Vec<Place>,
    /// Whether there was room for everything that is to be halved; if not, nothing comes after.
    pub is_all: bool,
}

/// What the largest rectangles lack that are to be halved.
struct Halved {
    depth: usize,
    missing: Vec<Vec<Place>>,
}

/// Finds what a rectangle, or the halves of it that are there, lack to be halved.
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

/// The ends of a side with its middle, where there is one between them.
fn middle((first, last): (usize, usize)) -> Vec<usize> {
    let middle = first + (last - first) / 2;
    if middle > first { vec![first, middle, last] } else { vec![first, last] }
}

/// Whether anything known on a rectangle differs, its sides included.
fn has_unlike([x, y]: Sides, known: &BTreeMap<Place, Kind>) -> bool {
    let mut seen = Kind::default();
    (x.0..=x.1).any(|x| known.range((x, y.0)..=(x, y.1)).any(|(_, kind)| seen.differs(kind)))
}
