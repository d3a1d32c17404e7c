//! Maps: contours, regimes, cells without samples, bad runs, smoothed values and their limits.

use super::support::made::column;
use bladeoff_answers::ask::{Given, Known, Names, Question, QuestionDef, answer};
use bladeoff_answers::estimate::formula::Formula;
use bladeoff_answers::estimate::input::{Cells, Design, DesignKind, Ended, Group, Label, Layout, Nature, Study};
use bladeoff_answers::figures;
use bladeoff_answers::map::boundary::boundary;
use bladeoff_answers::map::contour::contour;
use bladeoff_answers::map::{Map, Of, REGIME, Shows, Wanted, maps};
use bladeoff_model::outcome::{CauseSet, Status};

/// Rows with two parameters, an output and a regime.
#[derive(Default, Clone)]
pub(crate) struct Rows {
    pub(crate) x: Vec<Option<f64>>,
    pub(crate) y: Vec<Option<f64>>,
    pub(crate) start: Vec<Option<f64>>,
    pub(crate) way: Vec<Option<String>>,
    pub(crate) z: Vec<Option<f64>>,
    pub(crate) regime: Vec<Option<String>>,
    pub(crate) status: Vec<Status>,
    /// Points of a random design, each with several rows; `None` for chosen values.
    pub(crate) points: Option<usize>,
}

impl Rows {
    pub(crate) fn add(&mut self, (x, y): (f64, f64), start: f64, way: &str, z: f64) {
        self.x.push(Some(x));
        self.y.push(Some(y));
        self.start.push(Some(start));
        self.way.push(Some(way.to_owned()));
        self.z.push(Some(z));
        self.regime.push(Some(if z < 1.0 { "free" } else { "heavy" }.to_owned()));
        self.status.push(Status::Ok);
    }

    pub(crate) fn maps(&self, wanted: &Wanted) -> Vec<Map> {
        let causes = vec![CauseSet::default(); self.status.len()];
        let ends = vec![Ended::Limit; self.status.len()];
        let points = self.points.unwrap_or(self.status.len());
        let replicate = vec![0; points];
        let ways = ["a".to_owned(), "b".to_owned()];
        let regimes = ["free", "light", "heavy"].map(str::to_owned);
        let study = Study {
            columns: vec![
                column("x", "m", Cells::Numbers(&self.x, Nature::Given)),
                column("y", "", Cells::Numbers(&self.y, Nature::Given)),
                column("start", "rad", Cells::Numbers(&self.start, Nature::Given)),
                column("way", "", Cells::Words(&self.way, &ways)),
                column("z", "N", Cells::Numbers(&self.z, Nature::Free)),
                column(REGIME, "", Cells::Words(&self.regime, &regimes)),
            ],
            status: &self.status,
            causes: &causes,
            ends: &ends,
            groups: (0..self.status.len() / points)
                .map(|at| Group(vec![("g".into(), Label::Number(at as f64))]))
                .collect(),
            design: Design {
                kind: if self.points.is_some() { DesignKind::MonteCarlo } else { DesignKind::Chosen },
                scrambled: true,
                replicates: 1,
                replicate: &replicate,
                complete: true,
                layout: Layout::Points,
                share: 1.0,
                refined: false,
            },
        };
        study.check().expect("a study");
        maps(&study, wanted, 0.05).expect("maps")
    }
}

pub(crate) fn known() -> Known {
    let columns = ["x", "y", "start", "z"].map(|name| (name.to_owned(), true));
    Known { columns: columns.into_iter().chain([("way".to_owned(), false)]).collect(), ..Known::default() }
}

pub(crate) fn of_z(is_grid: bool) -> Wanted {
    let of = Of::Value("z".into());
    Wanted {
        x: "x".into(),
        y: "y".into(),
        is_grid,
        varied: (false, false),
        of,
        panels: vec![],
        starts: vec![],
        paired: None,
    }
}

pub(crate) fn over(bound: f64) -> Of {
    Of::Probability(Formula::condition(&format!("z > {bound}"), &known()).expect("a condition"))
}

/// A plane over 5 x 4 given values, unevenly spaced along x, with two starts.
fn plane() -> Rows {
    let mut rows = Rows::default();
    for x in [0.0, 1.0, 1.5, 3.0, 4.0] {
        for y in [0.0, 1.0, 2.0, 3.0] {
            for start in [0.0, 1.0] {
                rows.add((x, y), start, "a", x + 2.0 * y + start);
            }
        }
    }
    rows
}

#[test]
fn a_plane_has_straight_contours_where_they_belong() {
    let found = plane().maps(&of_z(true));
    let [map] = &found[..] else { panic!("one panel") };
    assert_eq!((map.shows, map.cells.len(), map.n), (Shows::Median, 20, 40));
    let (table, upper) = (map.table(), |i: usize, j: usize| map.table()[i][j].and_then(|cell| cell.upper));
    let value = |i: usize, j: usize| table[i][j].and_then(|cell| cell.estimate);
    // with two starts the lower one is the median, the larger one the 95 % quantile
    for (of, shift) in [(&value as &dyn Fn(usize, usize) -> Option<f64>, 0.0), (&upper, 1.0)] {
        let pieces = contour(&map.x.at, &map.y.at, of, 4.3);
        assert!(pieces.len() >= 4, "{pieces:?}");
        for (x, y) in pieces.into_iter().flatten() {
            assert!((x + 2.0 * y + shift - 4.3).abs() < 1e-12, "{x} {y}");
        }
    }
    // its whole length: from (0, 2.15) to (4, 0.15)
    let length: f64 = contour(&map.x.at, &map.y.at, value, 4.3)
        .iter()
        .map(|[a, b]| ((a.0 - b.0) * (a.0 - b.0) + (a.1 - b.1) * (a.1 - b.1)).sqrt())
        .sum();
    assert!((length - 20f64.sqrt()).abs() < 1e-12, "{length}");
    assert_eq!(map.x.edges(), [-0.5, 0.5, 1.25, 2.25, 3.5, 4.5]);
}

#[test]
fn the_boundary_of_regimes_is_the_edge_between_their_cells() {
    let mut rows = Rows::default();
    // below 1 where x < 2: free
    for x in 0..5 {
        for y in 0..3 {
            rows.add((f64::from(x), f64::from(y)), 0.0, "a", f64::from(x) / 1.9);
        }
    }
    let map = &rows.maps(&of_z(true))[0];
    let edges = boundary(map);
    // one line from the lower edge of the map to the upper one
    let [line] = &edges[..] else { panic!("{edges:?}") };
    let ends = [line[0], line[line.len() - 1]].map(|(_, y)| y);
    assert!(line.iter().all(|(x, _)| *x == 1.5) && ends.contains(&-0.5) && ends.contains(&2.5), "{line:?}");
    // a bad run has no regime: the line ends beside it
    rows.status[2 * 3 + 1] = Status::Failed;
    let map = &rows.maps(&of_z(true))[0];
    let edges = boundary(map);
    assert_eq!(edges.len(), 2, "{edges:?}");
    assert!(edges.iter().flatten().all(|(_, y)| *y <= 0.5 || *y >= 1.5), "{edges:?}");
    assert_eq!(map.table()[2][1].expect("a cell").regime, None);
}

#[test]
fn cells_without_samples_are_not_there() {
    let mut rows = plane();
    // nothing was computed at x = 3, y = 2
    let gone: Vec<usize> = (0..40).filter(|row| rows.x[*row] == Some(3.0) && rows.y[*row] == Some(2.0)).collect();
    assert_eq!(gone.len(), 2);
    for row in gone {
        rows.y[row] = None;
    }
    let map = &rows.maps(&of_z(true))[0];
    assert_eq!((map.cells.len(), map.table()[3][2].is_none()), (19, true));
    assert!(map.notes.iter().any(|note| note.contains("2 runs have no value of x or y")), "{:?}", map.notes);
    let value = |i: usize, j: usize| map.table()[i][j].and_then(|cell| cell.estimate);
    let pieces = contour(&map.x.at, &map.y.at, value, 6.5);
    assert!(!pieces.is_empty() && pieces.iter().flatten().all(|(x, y)| !(*x > 1.5 && *y > 1.0)), "{pieces:?}");
    let svg = figures::maps("m", std::slice::from_ref(map));
    assert!(svg.svg().contains("hatched: no sample, or too few"));
}

#[test]
fn bad_runs_stay_in_their_cells() {
    let mut rows = plane();
    for row in [0, 6, 7] {
        rows.status[row] = Status::Failed;
    }
    let map = &rows.maps(&of_z(true))[0];
    let cell = |i: usize, j: usize| map.table()[i][j].expect("a cell").clone();
    // one of two starts is bad: harmless it is below the other, harmful above
    let one = cell(0, 0);
    assert_eq!((one.n, one.bad, one.estimate, one.estimate_if_bad_harmful), (2, 1, None, Some(1.0)));
    assert_eq!((one.upper, one.upper_if_bad_harmful), (Some(1.0), None));
    let both = cell(0, 3);
    assert_eq!((both.n, both.bad, both.estimate, both.estimate_if_bad_harmful), (2, 2, None, None));
    assert_eq!(map.bad, 3);
    // a probability has bounds in every cell
    let map = &rows.maps(&Wanted { of: over(0.5), ..of_z(true) })[0];
    let cell = |i: usize, j: usize| map.table()[i][j].expect("a cell").clone();
    assert_eq!((cell(0, 0).estimate, cell(0, 0).estimate_if_bad_harmful), (Some(0.5), Some(1.0)));
    assert_eq!((cell(0, 3).estimate, cell(0, 3).estimate_if_bad_harmful), (Some(0.0), Some(1.0)));
    assert_eq!((cell(1, 1).estimate, cell(1, 1).estimate_if_bad_harmful), (Some(1.0), Some(1.0)));
    assert_eq!(cell(1, 1).low, None, "chosen values are no sample");
    let svg = figures::maps("m", std::slice::from_ref(map));
    assert!(svg.svg().contains("3 of them bad") && svg.svg().contains("cross: bad runs"), "{}", svg.svg());
}

#[test]
fn runs_beyond_the_model_have_marks_and_counts_of_their_own() {
    let mut rows = plane();
    rows.status[0] = Status::Failed;
    rows.status[6] = Status::Beyond;
    rows.status[7] = Status::Beyond;
    let map = &rows.maps(&Wanted { of: over(0.5), ..of_z(true) })[0];
    assert_eq!((map.bad, map.beyond, map.failing(), map.bad_at.len(), map.beyond_at.len()), (3, 2, 1, 1, 2));
    let cell = map.table()[0][3].expect("a cell");
    assert_eq!((cell.n, cell.bad, cell.beyond), (2, 2, 2));
    let svg = figures::maps("m", std::slice::from_ref(map));
    for part in ["1 of them bad, 2 beyond the model", "cross: bad runs", "diamond: runs beyond the model"] {
        assert!(svg.svg().contains(part), "{part}: {}", svg.svg());
    }
    // no mark without such runs
    rows.status[0] = Status::Ok;
    let map = &rows.maps(&Wanted { of: over(0.5), ..of_z(true) })[0];
    let svg = figures::maps("m", std::slice::from_ref(map));
    assert!(!svg.svg().contains("cross: bad runs") && svg.svg().contains("diamond: runs beyond the model"));
}

#[test]
fn a_panel_is_named_in_the_unit_of_its_axis() {
    let mut rows = Rows::default();
    for (x, start, y) in [(4e-4, 0.0, 0.0), (4e-4, 1.0, 1.0), (1e-3, 0.0, 0.0), (1e-3, 1.0, 1.0)] {
        rows.add((x, y), start, "a", 1.0);
    }
    let wanted = Wanted { x: "start".into(), panels: vec!["x".into()], ..of_z(true) };
    let found = rows.maps(&wanted);
    assert_eq!([&found[0].panel, &found[1].panel], ["x = 0.4 mm", "x = 1 mm"]);
    let drawn = figures::maps("m", &found);
    assert!(drawn.svg().contains("x = 0.4 mm: one run a cell"), "{}", drawn.svg());
}

#[test]
fn a_difference_is_that_of_runs_with_the_same_inputs() {
    let mut rows = Rows::default();
    for (x, y) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)] {
        // the starts of b in another order
        for (start, other) in [(0.0, 2.0), (1.0, 0.0), (2.0, 1.0)] {
            rows.add((x, y), start, "a", 10.0 * start + x);
            rows.add((x, y), other, "b", 10.0 * other + 3.0 + 5.0 * y);
        }
    }
    let pair = ["b", "a"].map(|word| Label::Word(word.into()));
    let wanted = Wanted {
        panels: vec!["way".into()],
        starts: vec!["start".into()],
        paired: Some(("way".into(), vec![pair])),
        ..of_z(true)
    };
    let found = rows.maps(&wanted);
    assert_eq!(found.len(), 3);
    assert_eq!(found[0].group, Group(vec![("way".into(), Label::Word("a".into()))]));
    let less = &found[2];
    assert_eq!((found[0].panel.as_str(), less.less.as_str()), ("way = a", "way = b less a"));
    assert!(less.difference.is_some() && less.n == 12);
    for cell in &less.cells {
        let expected = 3.0 + 5.0 * cell.y - cell.x;
        // median and 95 % quantile: apart from the start all are equal
        assert_eq!((cell.n, cell.estimate, cell.upper), (3, Some(expected), Some(expected)), "{cell:?}");
    }
    // a run without partner is in no difference, which is reported
    rows.start[1] = Some(9.0);
    let less = &rows.maps(&wanted)[2];
    assert_eq!((less.n, less.table()[0][0].expect("a cell").n), (11, 2));
    assert!(less.notes.iter().any(|note| note.contains("2 runs of both have no partner")), "{:?}", less.notes);
    // bad in one of the panels: unknown
    rows.status[3] = Status::Failed;
    let less = &rows.maps(&wanted)[2];
    assert_eq!(less.bad, 1);
}

/// Points that fill the square at random, from a separate generator.
pub(crate) fn scattered(count: usize, z: impl Fn(f64, f64, f64) -> f64) -> Rows {
    let mut state = 1u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut rows = Rows { points: Some(count), ..Rows::default() };
    for _ in 0..count {
        let (x, y, u) = (next(), next(), next());
        rows.add((x, y), 0.0, "a", z(x, y, u));
    }
    rows
}

#[test]
fn a_smoothed_plane_is_the_plane() {
    let map = &scattered(400, |x, y, _| 3.0 * x - 2.0 * y).maps(&of_z(false))[0];
    assert!(map.shows == Shows::SmoothedMean && map.cells.len() > 1500, "{}", map.cells.len());
    for cell in &map.cells {
        let off = cell.estimate.expect("a number") - (3.0 * cell.x - 2.0 * cell.y);
        assert!(off.abs() < 1e-9, "{cell:?}");
        // rounding errors are not uncertainty
        assert_eq!((cell.low, cell.high), (cell.estimate, cell.estimate));
    }
    assert!(map.cells.iter().map(|cell| cell.n).sum::<u64>() <= 400);
}

#[test]
fn a_few_values_are_columns_and_few_samples_are_not_smoothed() {
    // five values along x, any along y: each value separately, so a step between them stays a step
    let mut rows = scattered(400, |_, _, _| 0.0);
    for row in 0..400 {
        let x = f64::from((row % 5) as u32);
        rows.x[row] = Some(x);
        rows.z[row] = Some(if x > 2.5 { 10.0 } else { 0.0 } + rows.y[row].expect("a number"));
    }
    let map = &rows.maps(&of_z(false))[0];
    assert_eq!(map.x.at, [0.0, 1.0, 2.0, 3.0, 4.0]);
    assert!(map.cells.len() > 150, "{}", map.cells.len());
    for cell in &map.cells {
        let expected = if cell.x > 2.5 { 10.0 } else { 0.0 } + cell.y;
        assert!((cell.estimate.expect("a number") - expected).abs() < 1e-9, "{cell:?}");
    }
    let map = &scattered(12, |x, y, _| x + y).maps(&of_z(false))[0];
    assert!(map.x.at.len() == 8 && !map.cells.is_empty());
    let map = &scattered(6, |x, y, _| x + y).maps(&of_z(false))[0];
    assert!(map.cells.is_empty() && map.notes.iter().any(|note| note.contains("fewer than 10")), "{:?}", map.notes);
    assert!(figures::maps("m", std::slice::from_ref(map)).svg().contains("no cell is drawn: no samples, or too few"));
}

#[test]
fn smoothed_limits_hold_the_truth() {
    // a share that increases along x, and a mean with scatter: limits hold in about 95 of 100 cells
    let share = |x: f64| 0.1 + 0.6 * x;
    let rows = scattered(3000, |x, _, u| if u < share(x) { 2.0 } else { 0.0 });
    let map = &rows.maps(&Wanted { of: over(1.0), ..of_z(false) })[0];
    let held = |map: &Map, truth: &dyn Fn(f64, f64) -> f64| {
        let inside = |cell: &&bladeoff_answers::map::Cell| {
            let truth = truth(cell.x, cell.y);
            cell.low.expect("a limit") <= truth && truth <= cell.high.expect("a limit")
        };
        map.cells.iter().filter(inside).count() as f64 / map.cells.len() as f64
    };
    let found = held(map, &|x, _| share(x));
    assert!(map.cells.len() > 1000 && found > 0.8, "{found} of {}", map.cells.len());
    let rows = scattered(3000, |x, y, u| libm_free(x, y) + 2.0 * (u - 0.5));
    let map = &rows.maps(&of_z(false))[0];
    let found = held(map, &libm_free);
    assert!(found > 0.8, "{found}");
    // narrower with more samples
    let width = |map: &Map| {
        map.cells.iter().map(|cell| cell.high.unwrap_or(9.0) - cell.low.unwrap_or(0.0)).sum::<f64>()
            / map.cells.len() as f64
    };
    let few = &scattered(300, |x, y, u| libm_free(x, y) + 2.0 * (u - 0.5)).maps(&of_z(false))[0];
    assert!(width(few) > 1.4 * width(map), "{} {}", width(few), width(map));
}

fn libm_free(x: f64, y: f64) -> f64 {
    x * x + 0.5 * y
}

#[test]
fn nothing_is_smoothed_into_what_has_no_sample() {
    // a strip of half the square is empty
    let mut rows = scattered(900, |x, _, _| x);
    for row in 0..900 {
        if rows.x[row].is_some_and(|x| x > 0.3 && x < 0.7) {
            rows.x[row] = Some(0.0);
        }
    }
    let map = &rows.maps(&of_z(false))[0];
    assert!(!map.cells.is_empty() && map.cells.iter().all(|cell| !(0.36..0.64).contains(&cell.x)));
    // open runs: both shares, and limits around both
    for row in 0..90 {
        rows.status[row] = Status::Failed;
    }
    let map = &rows.maps(&Wanted { of: over(0.5), ..of_z(false) })[0];
    assert_eq!(map.bad, 90);
    let apart = map.cells.iter().filter(|cell| cell.estimate_if_bad_harmful > cell.estimate);
    assert!(apart.count() > 100);
    assert!(map.cells.iter().all(|cell| cell.low <= cell.estimate && cell.estimate_if_bad_harmful <= cell.high));
    assert!(map.cells.iter().all(|cell| cell.high <= Some(1.0) && cell.low >= Some(0.0)));
}

#[test]
fn the_words_of_a_map_are_understood_or_told() {
    let given = |column: &str, axis| Given {
        column: column.into(),
        axis,
        is_angle: column == "start",
        is_detection: column == "way",
    };
    let words = ["a", "b", "c"].map(|word| Label::Word(word.into())).to_vec();
    let numbers = |count: u32| (0..count).map(|at| Label::Number(f64::from(at))).collect::<Vec<_>>();
    let mut names = Names {
        known: known(),
        varied: vec![
            ("x".into(), numbers(5)),
            ("y".into(), numbers(4)),
            ("start".into(), numbers(2)),
            ("way".into(), words),
        ],
        given: vec![given("x", Some(0)), given("y", Some(1)), given("start", Some(2)), given("way", Some(3))],
        ..Names::default()
    };
    let def = |x: &str, y: &str, of: &str| QuestionDef {
        name: "m".into(),
        map: Some([x.into(), y.into()]),
        of: Some(of.into()),
        ..QuestionDef::default()
    };
    let read = |def: &QuestionDef, names: &Names| Question::new(def, names);
    for of in ["P(z > 1)", " P ( z > 1 ) ", "z > 1"] {
        let question = read(&def("x", "y", of), &names).expect("understood");
        let bladeoff_answers::ask::Ask::Map(wanted) = question.ask else { panic!("a map") };
        assert!(matches!(wanted.of, Of::Probability(_)) && wanted.is_grid);
        assert_eq!((wanted.panels, wanted.starts), (vec!["way".to_owned()], vec!["start".to_owned()]));
        let (column, pairs) = wanted.paired.expect("differences");
        assert_eq!((column.as_str(), pairs.len()), ("way", 2));
        assert_eq!(pairs[1], ["c", "a"].map(|word| Label::Word(word.into())));
    }
    for (def, part) in [
        (def("x", "u", "z"), "`u` is not a varied parameter or variable"),
        (def("way", "y", "z"), "`way` is a column of words"),
        (def("x", "x", "z"), "both axes are `x`"),
        (def("x", "y", "P(zz > 1)"), "zz"),
        (def("x", "y", "zz"), "there is no column `zz`"),
        (QuestionDef { of: None, ..def("x", "y", "") }, "needs `of = COLUMN`"),
        (QuestionDef { mean: Some("z".into()), ..def("x", "y", "z") }, "a question asks for one of"),
        (QuestionDef { fragility: Some("x".into()), ..def("x", "y", "z") }, "a map has no fragility"),
    ] {
        let told = read(&def, &names).expect_err(part);
        assert!(told.iter().any(|problem| problem.message.contains(part)), "{part}: {told:?}");
    }
    // the place of an error within P(...)
    let told = read(&def("x", "y", "P(z > 1 N + q)"), &names).expect_err("a mistake");
    assert!(told[0].key == "of" && told[0].place.as_ref().is_some_and(|place| place.start >= 2), "{told:?}");
    names.varied[3].1 = numbers(30);
    let told = read(&def("x", "y", "z"), &names).expect_err("too many panels");
    assert!(told[0].message.contains("30 are more than 24"), "{told:?}");
}

#[test]
fn a_map_answers_in_a_sentence_and_as_json() {
    let rows = plane();
    let causes = vec![CauseSet::default(); rows.status.len()];
    let ends = vec![Ended::Other; rows.status.len()];
    let replicate = vec![0; rows.status.len()];
    let column = |name, unit, values| column(name, unit, Cells::Numbers(values, Nature::Given));
    let study = Study {
        columns: vec![column("x", "m", &rows.x), column("y", "", &rows.y), column("z", "N", &rows.z)],
        status: &rows.status,
        causes: &causes,
        ends: &ends,
        groups: vec![Group::default()],
        design: Design {
            kind: DesignKind::Chosen,
            scrambled: false,
            replicates: 1,
            replicate: &replicate,
            complete: true,
            layout: Layout::Points,
            share: 1.0,
            refined: false,
        },
    };
    let names = Names {
        known: known(),
        given: ["x", "y"]
            .iter()
            .enumerate()
            .map(|(at, name)| Given {
                column: (*name).to_owned(),
                axis: Some(at),
                is_angle: false,
                is_detection: false,
            })
            .collect(),
        ..Names::default()
    };
    let map = Some(["x".to_owned(), "y".to_owned()]);
    let def = QuestionDef { name: "m".into(), map, of: Some("P(z > 8.5)".into()), ..QuestionDef::default() };
    let found = answer(&study, &Question::new(&def, &names).expect("a map")).expect("answered").answers.remove(0);
    assert!(
        found.sentence.contains(
            "P(z > 8.5) over x and y: at most 100 %, at 4 m and 3; at least 0 %; half or more in 15 % of the cells"
        ),
        "{}",
        found.sentence
    );
    let json = serde_json::to_value(&found).expect("JSON");
    assert_eq!((&json["kind"], &json["map"]["shows"]), (&"map".into(), &"probability".into()));
    assert_eq!(json["map"]["cells"].as_array().map(Vec::len), Some(20));
    assert_eq!(json["map"]["cells"][19]["estimate"], 1.0);
    assert_eq!(json["map"]["x"]["unit"], "m");
}
