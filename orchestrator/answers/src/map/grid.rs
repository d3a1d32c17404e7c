//! Map cells for given values: one cell for each combination of the two axes; the runs of a cell are its starts.

use super::place::{Item, Items, Seen, most_frequent, point_of};
use super::{Cell, Frame, Map, Shows, UPPER};
use crate::estimate::difference::of_probabilities;
use crate::estimate::figures::Figures;
use crate::estimate::input::DesignKind;
use crate::estimate::known::{Truths, Values};
use crate::estimate::proportion::{proportion_by, tallies};
use crate::estimate::quantile::quantile;
use crate::estimate::truth::Truth;

/// Fills the cells of a map.
pub(super) fn fill(frame: &Frame<'_>, items: &Items, map: &mut Map, is_share: bool) {
    let (columns, rows) = (map.x.at.len(), map.y.at.len());
    let place = |at: &[f64], value: f64| at.binary_search_by(|known| known.total_cmp(&value)).ok();
    let mut cells: Vec<Vec<Item>> = vec![Vec::new(); columns * rows];
    for item in &items.list {
        if let (Some(x), Some(y)) = (place(&map.x.at, item.x), place(&map.y.at, item.y)) {
            cells[x * rows + y].push(*item);
        }
    }
    let most = cells.iter().map(Vec::len).max().unwrap_or(0);
    // the chosen values that finish first are not random; of random points only complete ones are in the table
    let is_partial = !frame.study.design.complete && frame.study.design.kind == DesignKind::Chosen;
    let mut begun = 0;
    map.shows = match (is_share, most) {
        (true, _) => Shows::Probability,
        (false, 0 | 1) => Shows::Value,
        (false, _) => Shows::Median,
    };
    for (at, list) in cells.iter().enumerate().filter(|(_, list)| !list.is_empty()) {
        if is_partial && list.len() < most {
            begun += 1;
            continue;
        }
        let mut cell = Cell {
            at: (at / rows, at % rows),
            x: map.x.at[at / rows],
            y: map.y.at[at % rows],
            n: list.len() as u64,
            bad: list.iter().filter(|item| item.is_bad()).count() as u64,
            beyond: list.iter().filter(|item| item.is_beyond()).count() as u64,
            estimate: None,
            estimate_if_bad_harmful: None,
            low: None,
            high: None,
            upper: None,
            upper_if_bad_harmful: None,
            regime: most_frequent(list.iter().filter_map(|item| Some((item.regime?, 1.0))), &map.regimes),
            // the event of a bad run may be known all the same
            half_width: None,
            is_open: list.iter().any(|item| if is_share { item.seen.is_open() } else { item.is_bad() }),
        };
        if is_share {
            take(&mut cell, &share(frame, list));
        } else {
            let values = values(frame, list);
            take(&mut cell, &of(frame, &values, 0.5));
            if map.shows == Shows::Median {
                let upper = of(frame, &values, UPPER);
                (cell.upper, cell.upper_if_bad_harmful) = (upper.estimate, upper.harmful);
            }
        }
        map.cells.push(cell);
    }
    if begun > 0 {
        let cells = if begun == 1 { "1 cell is".to_owned() } else { format!("{begun} cells are") };
        map.notes.push(format!("{cells} left out so far: some of their runs are not finished"));
    }
}

fn take(cell: &mut Cell, figures: &Figures) {
    (cell.estimate, cell.estimate_if_bad_harmful) = (figures.estimate, figures.harmful);
    (cell.low, cell.high) = (figures.low, figures.high);
}

fn share(frame: &Frame<'_>, list: &[Item]) -> Figures {
    let part = |at: usize| frame.part(list[at].row);
    let of = |truth: fn(Seen) -> Truth| list.iter().map(|item| truth(item.seen)).collect();
    if list.iter().any(|item| matches!(item.seen, Seen::Truths(..))) {
        let first = of(|seen| if let Seen::Truths(a, _) = seen { a } else { Truth::Open });
        let second = of(|seen| if let Seen::Truths(_, b) = seen { b } else { Truth::Open });
        let (a, b) = (Truths { of: first, ..Truths::default() }, Truths { of: second, ..Truths::default() });
        return of_probabilities(&a, &b, &frame.scheme, part, frame.alpha);
    }
    let truths = Truths { of: of(|seen| if let Seen::Truth(a) = seen { a } else { Truth::Open }), ..Truths::default() };
    proportion_by(&tallies(&truths, frame.scheme.parts(), part), &frame.scheme, frame.alpha, frame.t)
}

fn values(frame: &Frame<'_>, list: &[Item]) -> Values {
    let mut found = Values::default();
    for item in list {
        let Seen::Value(low, high) = item.seen else { continue };
        found.point.push(point_of(frame.study, item.row) as u32);
        found.low.push(low);
        found.high.push(high);
        found.bad.see(item.status, false);
    }
    found
}

fn of(frame: &Frame<'_>, values: &Values, u: f64) -> Figures {
    quantile(values, u, &frame.scheme, |point| frame.scheme.part(&frame.study.design, point), frame.alpha)
}

impl Frame<'_> {
    /// Part of the scheme to which a row belongs.
    fn part(&self, row: usize) -> usize {
        self.scheme.part(&self.study.design, point_of(self.study, row))
    }
}
