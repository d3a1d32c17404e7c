//! Differences between two panels at the same inputs: the common scatter cancels.

use super::Frame;
use super::place::{Item, Items, Seen, codes, of_pair, point_of};
use std::collections::BTreeMap;

/// Inputs shared by both runs of a pair: place, given angles, point of the design.
type Key = (u64, u64, Vec<u32>, usize);

/// Pairs of runs of `a` and `b` with equal inputs; a run whose inputs occur several times has no partner.
pub(super) fn paired(frame: &Frame<'_>, a: &Items, b: &Items) -> Items {
    let starts: Vec<Vec<u32>> =
        frame.wanted.starts.iter().filter_map(|column| Some(codes(frame.study, column).ok()?.0)).collect();
    let key = |item: &Item| -> Key {
        let angles = starts.iter().map(|codes| codes[item.row]).collect();
        (item.x.to_bits(), item.y.to_bits(), angles, point_of(frame.study, item.row))
    };
    let keyed = |items: &Items| {
        let mut found: BTreeMap<Key, Vec<Item>> = BTreeMap::new();
        items.list.iter().for_each(|item| found.entry(key(item)).or_default().push(*item));
        found
    };
    let others = keyed(b);
    let mut found = Items::default();
    for (key, first) in keyed(a) {
        let second = others.get(&key).map(Vec::as_slice).unwrap_or_default();
        let ([a], [b]) = (first.as_slice(), second) else { continue };
        let seen = less(a.seen, b.seen);
        found.empty += u64::from(seen == Seen::Empty);
        // a pair has no regime
        found.list.push(Item { status: of_pair(a.status, b.status), regime: None, seen, ..*a });
    }
    found.list.sort_unstable_by_key(|item| item.row);
    found.unpaired = (a.list.len() + b.list.len() - 2 * found.list.len()) as u64;
    found
}

/// Bounds of the difference a - b.
fn less(a: Seen, b: Seen) -> Seen {
    match (a, b) {
        (Seen::Truth(a), Seen::Truth(b)) => Seen::Truths(a, b),
        (Seen::Value(low, high), Seen::Value(other_low, other_high)) => Seen::Value(low - other_high, high - other_low),
        _ => Seen::Empty,
    }
}
