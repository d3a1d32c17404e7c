//! What is kept of a long table.

use super::*;
use bladeoff_answers::tables::Cells;

fn coordinate(column: &str, is_word: bool, is_result: bool) -> Coordinate {
    Coordinate { column: column.into(), name: column.into(), unit: String::new(), is_word, is_result }
}

/// Rows of these samples: every thousandth failed, sample 77 777 by a cause of its own.
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
        ],
    )
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
    pieces.iter().for_each(|samples| reading.add(&piece(samples), &coordinates, &[]));
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
    assert_eq!(once.ends[1].largest, [996, 1993, 2990, 3987, 4984].map(|sample| (996.0, sample)));
    assert_eq!(once.ends[1].least[0], (0.0, 0));
}
