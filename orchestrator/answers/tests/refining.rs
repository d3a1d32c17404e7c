//! Refinement of maps.

use bladeoff_answers::estimate::input::Group;
use bladeoff_answers::map::refine::{Grid, Kind, Next, Place, kinds};
use bladeoff_answers::map::{Axis, Cell, Map, Shows};
use std::collections::{BTreeMap, BTreeSet};

const WORDS: [&str; 3] = ["free", "light", "heavy"];

fn axis(length: usize) -> Vec<f64> {
    (0..length).map(|at| 0.25 * at as f64).collect()
}

/// A panel without cells.
fn panel(shows: Shows) -> Map {
    let axis = |column: &str| Axis { column: column.into(), unit: String::new(), at: Vec::new() };
    Map {
        group: Group(Vec::new()),
        panel: String::new(),
        less: String::new(),
        x: axis("x"),
        y: axis("y"),
        of: "z".into(),
        unit: String::new(),
        shows,
        difference: None,
        width: None,
        undrawn: None,
        runs: None,
        confidence: 0.95,
        regimes: WORDS.map(str::to_owned).to_vec(),
        n: 0,
        bad: 0,
        beyond: 0,
        bad_at: Vec::new(),
        beyond_at: Vec::new(),
        refined: true,
        notes: Vec::new(),
        cells: Vec::new(),
    }
}

fn cell((x, y): Place, regime: Option<usize>, shares: [f64; 2]) -> Cell {
    Cell {
        at: (0, 0),
        x: 0.25 * x as f64,
        y: 0.25 * y as f64,
        n: 20,
        bad: 0,
        beyond: 0,
        estimate: Some(shares[0]),
        estimate_if_bad_harmful: Some(shares[1]),
        low: None,
        high: None,
        upper: None,
        upper_if_bad_harmful: None,
        regime: regime.map(|regime| WORDS[regime].to_owned()),
        half_width: None,
        is_open: false,
    }
}

/// Kinds after these combinations have been computed; `regime` gives the regime of each.
fn known(places: &BTreeSet<Place>, regime: impl Fn(Place) -> Option<usize>) -> BTreeMap<Place, Kind> {
    let mut map = panel(Shows::Median);
    map.cells = places.iter().map(|&place| cell(place, regime(place), [0.0; 2])).collect();
    let all = axis(100);
    kinds(&[map], [&all, &all])
}

/// All computed combinations, and the combinations added in each step.
fn refined(grid: &Grid, room: usize, regime: impl Fn(Place) -> Option<usize>) -> (BTreeSet<Place>, Vec<Vec<Place>>) {
    let (mut places, mut looks) = (BTreeSet::new(), Vec::new());
    loop {
        let left = room.saturating_sub(places.len());
        let Next { places: next, is_all } = grid.next(&known(&places, &regime), left);
        assert!(next.iter().all(|place| places.insert(*place)), "a combination that is there comes again: {next:?}");
        assert!(places.len() <= room.max(grid.first().len()), "{} of {room}", places.len());
        let is_last = next.is_empty() || !is_all;
        if !next.is_empty() {
            looks.push(next);
        }
        if is_last {
            return (places, looks);
        }
    }
}

/// Squares of neighbours on the finest grid that have more than one regime.
fn crossed(length: usize, regime: impl Fn(Place) -> Option<usize>) -> Vec<[Place; 4]> {
    let squares = (1..length).flat_map(|x| (1..length).map(move |y| [(x - 1, y - 1), (x, y - 1), (x, y), (x - 1, y)]));
    squares.filter(|corners| corners.iter().any(|place| regime(*place) != regime(corners[0]))).collect()
}

/// A straight boundary, steep enough to cross rectangles through every side.
fn straight((x, y): Place) -> Option<usize> {
    Some(usize::from(3 * y > 2 * x + 19))
}

/// Three regimes in rings.
fn rings((x, y): Place) -> Option<usize> {
    let square = x * x + y * y;
    Some(if square < 13 * 13 {
        0
    } else if square < 25 * 25 {
        1
    } else {
        2
    })
}

#[test]
fn every_square_that_a_boundary_crosses_is_computed_and_little_else() {
    let grid = Grid::new([33, 33], [5, 5]).expect("a grid");
    for (name, regime) in [("straight", straight as fn(Place) -> Option<usize>), ("rings", rings)] {
        let (places, looks) = refined(&grid, 33 * 33, regime);
        let crossed = crossed(33, regime);
        assert!(crossed.len() > 30, "{name}: the boundary crosses {} squares", crossed.len());
        for corners in &crossed {
            assert!(
                corners.iter().all(|place| places.contains(place)),
                "{name}: {corners:?} is crossed and not computed"
            );
        }
        assert!(places.len() < 33 * 33 / 2, "{name}: {} of {}", places.len(), 33 * 33);
        assert_eq!(looks[0].len(), 25, "first every eighth value");
        // nothing is added far from the boundary
        let is_near =
            |place: &Place| crossed.iter().any(|[a, ..]| a.0.abs_diff(place.0) <= 8 && a.1.abs_diff(place.1) <= 8);
        assert!(looks[1..].iter().flatten().all(is_near), "{name}");
    }
}

#[test]
fn where_nothing_changes_nothing_is_added_and_an_island_between_the_first_values_is_not_seen() {
    let grid = Grid::new([33, 17], [5, 3]).expect("a grid");
    let (places, looks) = refined(&grid, 1000, |_| Some(1));
    assert_eq!((places.len(), looks.len()), (15, 1));
    let island = |(x, y): Place| Some(usize::from((10..15).contains(&x) && (2..7).contains(&y)));
    assert_eq!(refined(&grid, 1000, island).0, places);
    // an island that contains a first combination is found completely
    let island = |(x, y): Place| Some(usize::from((7..14).contains(&x) && (6..11).contains(&y)));
    let (places, _) = refined(&grid, 1000, island);
    let inside = crossed(17, island);
    assert!(inside.len() > 15 && inside.iter().flatten().all(|place| places.contains(place)));
}

#[test]
fn a_rectangle_with_like_corners_is_halved_where_a_neighbour_finds_another_regime_on_their_side() {
    let grid = Grid::new([17, 9], [3, 2]).expect("a grid");
    // a tongue from the left, with its end beyond x = 8 between the corners of the right rectangle; it contains a first combination on the left
    let tongue = |(x, y): Place| Some(usize::from(x <= 11 && (3..=5).contains(&y) || (x, y) == (0, 0)));
    let (places, looks) = refined(&grid, 1000, tongue);
    assert!([(8, 0), (8, 8), (16, 0), (16, 8)].iter().all(|place| tongue(*place) == Some(0)), "corners on the right");
    assert!(looks[1].iter().all(|place| place.0 <= 8), "{:?}", looks[1]);
    assert!(places.contains(&(11, 4)) && places.contains(&(12, 4)), "the end of the tongue: {places:?}");
    assert!(crossed(9, tongue).iter().flatten().all(|place| places.contains(place)));
}

#[test]
fn less_room_gives_a_part_of_what_more_room_gives() {
    let grid = Grid::new([33, 33], [5, 5]).expect("a grid");
    let (all, _) = refined(&grid, 33 * 33, rings);
    let mut last = BTreeSet::new();
    for room in 0..=all.len() {
        let (places, _) = refined(&grid, room, rings);
        assert!(last.is_subset(&places), "{room}");
        assert!(places.len() + 5 > room.max(25), "{} of {room} are used", places.len());
        last = places;
    }
    assert_eq!(last, all);
    // the forty additions are spread over the map, not in one corner
    let (some, looks) = refined(&grid, 25 + 20, rings);
    let added: Vec<&Place> = looks[1..].iter().flatten().collect();
    assert!(added.iter().any(|place| place.0 < 12) && added.iter().any(|place| place.1 < 12), "{some:?}");
}

#[test]
fn what_comes_next_does_not_depend_on_how_one_came_there() {
    let grid = Grid::new([20, 31], [4, 5]).expect("a grid");
    let (places, looks) = refined(&grid, 400, straight);
    let mut there = BTreeSet::new();
    for next in &looks {
        assert_eq!(&grid.next(&known(&there, straight), 400 - there.len()).places, next);
        there.extend(next.iter().copied());
    }
    assert_eq!(there, places);
}

#[test]
fn first_combinations_reach_both_ends_and_a_grid_needs_two_values_along_each_axis() {
    let grid = Grid::new([10, 7], [4, 3]).expect("a grid");
    let first = grid.first();
    assert_eq!(first.len(), 12);
    assert_eq!((first[0], first[11]), ((0, 0), (9, 6)));
    assert_eq!(grid.next(&BTreeMap::new(), 0).places, first, "whatever the room");
    for (lengths, first) in [([10, 7], [1, 3]), ([10, 7], [4, 8]), ([1, 7], [1, 3])] {
        assert_eq!(Grid::new(lengths, first), None);
    }
    let whole = Grid::new([4, 3], [4, 3]).expect("a grid");
    assert_eq!(refined(&whole, 100, |(x, y)| Some((x + y) % 2)).0.len(), 12, "a grid that is there as a whole");
}

#[test]
fn bad_runs_that_decide_the_event_and_cells_of_bad_runs_alone_make_no_boundary() {
    let grid = Grid::new([3, 3], [2, 2]).expect("a grid");
    let all = axis(3);
    let next = |shows: Shows, cells: [(Option<usize>, [f64; 2]); 4]| {
        let mut map = panel(shows);
        map.cells =
            grid.first().into_iter().zip(cells).map(|(place, (regime, shares))| cell(place, regime, shares)).collect();
        grid.next(&kinds(&[map], [&all, &all]), 9).places.len()
    };
    let (no, yes, open) = ([0.1, 0.2], [0.5, 0.8], [0.4, 0.6]);
    assert_eq!(next(Shows::Probability, [(Some(0), no), (Some(0), no), (Some(0), no), (Some(0), yes)]), 5);
    assert_eq!(next(Shows::Probability, [(Some(0), no), (Some(0), no), (Some(0), no), (Some(0), open)]), 0);
    assert_eq!(next(Shows::Probability, [(Some(0), no), (Some(0), no), (Some(2), no), (Some(0), no)]), 5);
    assert_eq!(next(Shows::Probability, [(Some(0), no), (Some(0), no), (None, no), (Some(0), no)]), 0);
    // differences of values are not differences of shares; smoothed cells are ignored
    assert_eq!(next(Shows::Median, [(Some(0), no), (Some(0), no), (Some(0), no), (Some(0), yes)]), 0);
    assert_eq!(next(Shows::SmoothedProbability, [(Some(0), no), (Some(0), no), (Some(0), no), (Some(0), yes)]), 4);
}

#[test]
fn one_panel_that_changes_is_enough() {
    let grid = Grid::new([3, 3], [2, 2]).expect("a grid");
    let all = axis(3);
    let of = |regimes: [usize; 4]| {
        let mut map = panel(Shows::Median);
        map.cells =
            grid.first().into_iter().zip(regimes).map(|(place, regime)| cell(place, Some(regime), [0.0; 2])).collect();
        map
    };
    // panels that differ from each other, but not along the map
    assert_eq!(grid.next(&kinds(&[of([0; 4]), of([2; 4])], [&all, &all]), 9).places.len(), 0);
    assert_eq!(grid.next(&kinds(&[of([0; 4]), of([2, 2, 1, 2])], [&all, &all]), 9).places.len(), 5);
}
