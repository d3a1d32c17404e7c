//! Tests of the selection of rows from a long table.

use super::*;
use bladeoff_answers::tables::Cells;

fn coordinate(column: &str, is_word: bool, is_result: bool) -> Coordinate {
    Coordinate {
        column: column.into(),
        name: column.into(),
        unit: String::new(),
        is_word,
        is_result,
        held: Held::Reached("guarded_y".into()),
    }
}

/// Rows of these samples: every thousandth has failed, sample 77 777 with a different cause.
fn piece(samples: &[u64]) -> Table {
    let status = |sample: &u64| match sample {
        77_777 => ("quarantined", Some("crashed")),
        sample if sample % 1000 == 3 => ("failed", Some("diverged")),
        _ => ("ok", None),
    };
    let words = |cells: Vec<Option<String>>| Cells::Words(cells);
    let (said, why): (Vec<_>, Vec<_>) = samples.iter().map(status).unzip();
    let numbers = |of: &dyn Fn(u64) -> f64| Cells::Numbers(samples.iter().map(|sample| Some(of(*sample))).collect());
    Table::from_columns(
        samples.len(),
        vec![
            ("sample".into(), numbers(&|sample| sample as f64)),
            ("status".into(), words(said.into_iter().map(|word| Some(word.to_owned())).collect())),
            ("cause".into(), words(why.into_iter().map(|word| word.map(str::to_owned)).collect())),
            (
                "way".into(),
                words(samples.iter().map(|sample| Some(if sample % 2 == 0 { "b" } else { "a" }.to_owned())).collect()),
            ),
            ("y".into(), numbers(&|sample| (sample % 997) as f64)),
            // values of failed rows, which are not results in the column itself
            ("guarded_y".into(), Cells::Numbers(samples.iter().map(|sample| reached(*sample)).collect())),
            ("regime".into(), words(samples.iter().map(|sample| regime(*sample)).collect())),
        ],
    )
}

/// Values that failed rows reached: sample 5003 has a larger one than any ok row, the quarantined row has none.
fn reached(sample: u64) -> Option<f64> {
    (sample % 1000 == 3).then_some(if sample == 5003 { 2000.0 } else { 1.0 })
}

/// A failed run may have no regime.
fn regime(sample: u64) -> Option<String> {
    let word = if sample == 5003 { "backward" } else { "forward" };
    (sample % 1000 != 3 || sample < 6000).then(|| word.to_owned())
}

fn seen(pieces: &[Vec<u64>]) -> Seen {
    let coordinates = vec![coordinate("way", true, false), coordinate("y", false, true)];
    let mut reading = Reading {
        kinds: Vec::new(),
        words: vec![Vec::new(); 2],
        ends: vec![Ends::default(); 2],
        regimes: BTreeMap::new(),
        rows: 0,
    };
    pieces.iter().for_each(|samples| reading.add(&piece(samples), &coordinates, &["regime"]));
    reading.done(coordinates)
}

#[test]
fn what_is_kept_does_not_depend_on_the_order_of_rows_and_no_cause_is_lost() {
    let all: Vec<u64> = (0..100_000).collect();
    let once = seen(std::slice::from_ref(&all));
    let mut pieces: Vec<Vec<u64>> = all.chunks(33_333).map(|chunk| chunk.iter().rev().copied().collect()).collect();
    pieces.reverse();
    assert_eq!(once, seen(&pieces));
    assert_eq!((once.rows, once.ok()), (100_000, 99_899));
    let kinds: Vec<(&str, u64, u64)> = once.kinds.iter().map(|of| (of.kind.0.as_str(), of.count, of.first)).collect();
    assert_eq!(kinds, [("ok", 99_899, 0), ("failed", 100, 3), ("quarantined", 1, 77_777)]);
    let of = |kind: usize| once.picked.iter().filter(|row| row.kind == kind).count();
    assert_eq!([of(0), of(1), of(2)], [MOST_GOOD, 100, 1], "the good ones are thinned, the others are whole");
    let lost = once.picked.iter().find(|row| row.sample == 77_777).expect("kept");
    assert_eq!((once.words[0].as_slice(), lost.values[0]), (["a".to_owned(), "b".to_owned()].as_slice(), Some(0.0)));
    // a failed run is ranked by the value that it reached, and the worst ok run is listed beside it
    let Ends { largest, least, unknown, recorded } = &once.ends[1];
    let recorded = recorded.as_ref().expect("of a failed run");
    assert_eq!((recorded.kind.0.as_str(), recorded.value, recorded.sample), ("failed", 300.0, 99_003));
    let values: Vec<(f64, u64)> = largest.all.iter().map(|row| (row.value, row.sample)).collect();
    assert_eq!(values, [(2000.0, 5003), (996.0, 996), (996.0, 1993), (996.0, 2990), (996.0, 3987)]);
    assert_eq!((largest.all[0].kind.0.as_str(), largest.all[0].recorded), ("failed", Some((5003 % 997) as f64)));
    assert_eq!(largest.ok.as_ref().map(|row| row.sample), Some(996));
    assert_eq!((least.all[0].value, least.all[0].sample, *unknown), (0.0, 0, 1));
}

#[test]
fn regimes_are_of_all_runs_by_status() {
    let all: Vec<u64> = (0..100_000).collect();
    let regimes = seen(&[all]).regimes;
    let of = |word: &str, status: &str| {
        regimes.get(&("regime".to_owned(), String::new(), word.to_owned())).and_then(|by| by.get(status)).copied()
    };
    assert_eq!((of("backward", "failed"), of("backward", "ok")), (Some(1), None));
    assert_eq!((of("forward", "ok"), of("forward", "failed")), (Some(99_899), Some(5)));
    assert_eq!((of("", "failed"), of("", "ok")), (Some(94), None), "they have none, and are counted");
    assert_eq!(of("forward", "quarantined"), Some(1));
}
