//! Text output of a comparison.

use super::circle::is_angle;
use super::found::{Apart, Compared, Difference, Differs, Interval, Judged, Pair, PairChange};
use super::paired::is_reached;
use crate::ask::{counted, percent_given};
use crate::summary::{Align, TextTable};
use bladeoff_text::document::units::format_digits;
use bladeoff_text::document::{cut, visible};
use std::borrow::Cow;

/// Significant digits of values.
const DIGITS: usize = 5;
/// Largest number of unchanged columns listed by name.
const MOST_NAMES: usize = 10;
/// Significant digits of differences.
const FEWER: usize = 3;
/// Largest number of pairs listed for a change of status or a column.
const NAMED: usize = 3;
/// Largest number of columns whose pairs are listed if no tolerance selects columns.
const COLUMNS: usize = 3;
/// Characters of a provenance value.
const LONGEST: usize = 100;
/// Characters of a hash.
const HASH: usize = 12;

/// The complete text, for a terminal of this width or for a file.
#[must_use]
pub fn told(found: &Compared, width: Option<usize>) -> String {
    let found = &in_lines(found);
    let mut text = String::new();
    for (name, side) in [("A", &found.a), ("B", &found.b)] {
        text.push_str(&format!("{name}: {}, {}, {} ok\n", side.name, counted(side.rows, "row"), side.ok));
    }
    text.push_str(&sources(&found.differs));
    text.push_str(&columns(found));
    text.push_str(&matching(found));
    text.push_str(&statuses(found));
    text.push_str(&paired(found, width));
    text.push_str(&words(found));
    text.push_str(&apart(found, width));
    text.push_str(&largest_changes(found));
    text.push_str(&tolerances(found));
    text
}

/// A copy in which every name and value read from a file is shown in one line.
fn in_lines(found: &Compared) -> Compared {
    fn line(text: &mut String) {
        if let Cow::Owned(shown) = visible(text) {
            *text = shown;
        }
    }
    fn pair(pair: &mut Pair) {
        pair.inputs.0.iter_mut().flat_map(|(column, value)| [column, value]).for_each(line);
    }
    let mut found = found.clone();
    [&mut found.a.name, &mut found.b.name].into_iter().for_each(line);
    for one in &mut found.differs {
        [Some(&mut one.what), one.a.as_mut(), one.b.as_mut()].into_iter().flatten().for_each(line);
    }
    for list in [
        &mut found.inputs,
        &mut found.ignored,
        &mut found.only_in_a,
        &mut found.only_in_b,
        &mut found.of_another_kind,
        &mut found.notes,
    ] {
        list.iter_mut().for_each(line);
    }
    for change in &mut found.status.changes {
        [&mut change.from, &mut change.to].into_iter().for_each(line);
        change.pairs.iter_mut().for_each(pair);
    }
    for one in &mut found.paired {
        [&mut one.column, &mut one.unit].into_iter().for_each(line);
        one.largest_changes.iter_mut().chain(&mut one.one_sided).for_each(|change| pair(&mut change.pair));
    }
    for one in &mut found.words {
        line(&mut one.column);
        one.changes.iter_mut().flat_map(|(a, b, _)| [a.as_mut(), b.as_mut()]).flatten().for_each(line);
        one.first.iter_mut().for_each(pair);
    }
    found.apart.iter_mut().flat_map(|one| [&mut one.column, &mut one.unit]).for_each(line);
    for one in &mut found.tolerances {
        [&mut one.tolerance, &mut one.column].into_iter().for_each(line);
        one.pairs().for_each(pair);
    }
    found
}

fn sources(differs: &[Differs]) -> String {
    if differs.is_empty() {
        return "Provenance is the same.\n".to_owned();
    }
    let shown = |one: &Differs, value: &Option<String>| {
        let longest = if one.what.ends_with("_blake3") { HASH } else { LONGEST };
        value.as_deref().map_or("nothing".to_owned(), |value| cut(value, longest))
    };
    let lines =
        differs.iter().map(|one| format!("  {}: {} in A, {} in B\n", one.what, shown(one, &one.a), shown(one, &one.b)));
    format!("\nProvenance differs:\n{}", lines.collect::<String>())
}

fn columns(found: &Compared) -> String {
    let mut text = String::new();
    for (what, names) in [
        ("Results of A alone", &found.only_in_a),
        ("Results of B alone", &found.only_in_b),
        ("Results of another kind in B, not compared", &found.of_another_kind),
    ] {
        if !names.is_empty() {
            text.push_str(&format!("{what}: {}\n", names.join(", ")));
        }
    }
    text
}

fn matching(found: &Compared) -> String {
    let matched = &found.matched;
    let by = if found.inputs.is_empty() { "no input".to_owned() } else { found.inputs.join(", ") };
    let ignored =
        if found.ignored.is_empty() { String::new() } else { format!(" (without {})", found.ignored.join(", ")) };
    let mut text = format!("\nMatched by {by}{ignored}: {}", counted(matched.pairs, "pair"));
    for (rows, side) in [(matched.only_in_a, "A"), (matched.only_in_b, "B")] {
        if rows > 0 {
            text.push_str(&format!(", {} of {side} without partner", counted(rows, "row")));
        }
    }
    text.push('\n');
    found.notes.iter().for_each(|note| text.push_str(&format!("  {note}\n")));
    text
}

fn statuses(found: &Compared) -> String {
    let status = &found.status;
    if found.matched.pairs == 0 {
        return String::new();
    }
    let mut text = format!("\nStatus: {} ok in both", counted(status.ok, "pair"));
    if status.bad_alike > 0 {
        text.push_str(&format!(
            ", {} not ok in both for the same cause (only guarded_ columns and beyond_s are compared)",
            status.bad_alike
        ));
    }
    text.push_str(&match status.changed {
        0 => ", none changed\n".to_owned(),
        changed => format!(", {changed} changed\n"),
    });
    for change in &status.changes {
        text.push_str(&format!("  {} in A, {} in B: {}\n", change.from, change.to, counted(change.count, "pair")));
        change.pairs.iter().take(NAMED).for_each(|pair| text.push_str(&format!("    {}\n", located(pair))));
        let more = change.count.saturating_sub(NAMED as u64);
        if more > 0 {
            text.push_str(&format!("    and {more} more\n"));
        }
    }
    text
}

/// "sample 7: x = 1.0", "sample 7 of A, 9 of B: ...".
fn located(pair: &Pair) -> String {
    let samples = samples(pair);
    let inputs: Vec<String> = pair.inputs.0.iter().map(|(column, value)| format!("{column} = {value}")).collect();
    if inputs.is_empty() { samples } else { format!("{samples}: {}", inputs.join(", ")) }
}

fn samples(pair: &Pair) -> String {
    if pair.a == pair.b { format!("sample {}", pair.a) } else { format!("sample {} of A, {} of B", pair.a, pair.b) }
}

fn value(value: Option<f64>, unit: &str) -> String {
    value.map_or("none".to_owned(), |value| format_digits(value, unit, DIGITS))
}

fn signed(value: f64, unit: &str) -> String {
    let sign = if value > 0.0 { "+" } else { "" };
    format!("{sign}{}", format_digits(value, unit, FEWER))
}

fn interval(found: &Interval, unit: &str) -> String {
    let end = |end: Option<f64>| end.map(|end| signed(end, unit));
    match (end(found.low), end(found.high)) {
        (Some(low), Some(high)) => format!("{low} to {high}"),
        (Some(low), None) => format!("from {low}"),
        (None, Some(high)) => format!("up to {high}"),
        (None, None) => "no interval".to_owned(),
    }
}

fn paired(found: &Compared, width: Option<usize>) -> String {
    if found.status.ok + found.status.bad_alike == 0 || found.paired.is_empty() {
        return String::new();
    }
    let has_moved = |one: &&Difference| one.same < one.pairs || one.only_in_a + one.only_in_b > 0;
    let moved: Vec<&Difference> = found.paired.iter().filter(has_moved).collect();
    let still: Vec<&str> = found.paired.iter().filter(|one| !has_moved(one)).map(|one| one.column.as_str()).collect();
    let mut text = String::new();
    if !moved.is_empty() {
        let level = percent_given(found.confidence);
        let others = match found.status.bad_alike {
            0 => String::new(),
            count => format!("; guarded_ columns and beyond_s also over {count} that are not"),
        };
        let pairs = counted(found.status.ok, "pair");
        text.push_str(&format!("\nB - A, over {pairs} that are ok in both{others}:\n"));
        let titles =
            ["column", "pairs", "moved", "mean of A", "mean of B - A", &level, "largest change", "sample of A"];
        let aligned = titles.iter().enumerate();
        let header: Vec<_> =
            aligned.map(|(at, title)| (*title, if at == 0 { Align::Left } else { Align::Right })).collect();
        let mut table = TextTable::new(&header);
        for one in &moved {
            let farthest = one.largest_changes.first();
            table.row(vec![
                one.column.clone(),
                one.pairs.to_string(),
                (one.pairs - one.same).to_string(),
                value(one.mean_a, &one.unit),
                one.mean.estimate.map_or("none".to_owned(), |mean| signed(mean, &one.unit)),
                interval(&one.mean, &one.unit),
                farthest
                    .and_then(|change| change.difference(&one.unit))
                    .map_or(String::new(), |apart| signed(apart, &one.unit)),
                farthest.map_or(String::new(), |change| change.pair.a.to_string()),
            ]);
        }
        text.push_str(&table.fitting("  ", width));
        for one in moved.iter().filter(|one| one.only_in_a + one.only_in_b > 0) {
            let first = one.one_sided.first().map(|change| format!("; first {}", located(&change.pair)));
            text.push_str(&format!(
                "  {}: {} with a value in A alone, {} in B alone{}\n",
                one.column,
                counted(one.only_in_a, "pair"),
                one.only_in_b,
                first.unwrap_or_default()
            ));
        }
        text.push_str(&notes(moved.iter().map(|one| (&*one.column, &one.mean))));
    }
    match still.len() {
        0 => {}
        1..=MOST_NAMES => text.push_str(&format!("\nThe same in every pair: {}\n", still.join(", "))),
        many => text.push_str(&format!("\nThe same in every pair: {many} other columns\n")),
    }
    text
}

/// Notes on the intervals of columns: each kind once, with its columns.
fn notes<'a>(intervals: impl Iterator<Item = (&'a str, &'a Interval)>) -> String {
    let mut all: Vec<(&str, Vec<&str>)> = Vec::new();
    for (column, note) in intervals.flat_map(|(column, interval)| interval.notes.iter().map(move |note| (column, note)))
    {
        // numbers in parentheses differ from column to column
        let kind = |note: &'a str| note.split(" (").next();
        match all.iter_mut().find(|(other, _)| kind(other) == kind(note)) {
            None => all.push((note, vec![column])),
            Some((_, columns)) if columns.contains(&column) => {}
            Some((_, columns)) => columns.push(column),
        }
    }
    let line = |(note, columns): &(&str, Vec<&str>)| match &columns[..] {
        [one] => format!("  {one}: {note}\n"),
        [first, ..] => {
            let names = columns.iter().take(NAMED).copied().collect::<Vec<_>>().join(", ");
            let more = if columns.len() > NAMED { ", ..." } else { "" };
            format!("  {} columns ({names}{more}); of {first}: {note}\n", columns.len())
        }
        [] => String::new(),
    };
    all.iter().map(line).collect()
}

fn words(found: &Compared) -> String {
    let mut text = String::new();
    for one in &found.words {
        let word = |word: &Option<String>| word.as_deref().map_or("none".to_owned(), |word| cut(word, 40));
        let changes: Vec<String> = one
            .changes
            .iter()
            .take(NAMED)
            .map(|(a, b, count)| format!("{} in A, {} in B: {count}", word(a), word(b)))
            .collect();
        let first = one.first.as_ref().map(|pair| format!("; first {}", located(pair))).unwrap_or_default();
        text.push_str(&format!(
            "\n{} differs in {} ({}){first}\n",
            one.column,
            counted(one.changed, "pair"),
            changes.join("; ")
        ));
    }
    text
}

fn apart(found: &Compared, width: Option<usize>) -> String {
    if found.apart.is_empty() {
        return String::new();
    }
    let (a, b) = (found.matched.only_in_a, found.matched.only_in_b);
    let level = percent_given(found.confidence);
    let titles = ["column", "figure", "of A", "of B", "B less A", &level];
    let header: Vec<_> = titles
        .iter()
        .enumerate()
        .map(|(at, title)| (*title, if at < 2 { Align::Left } else { Align::Right }))
        .collect();
    let mut table = TextTable::new(&header);
    for one in found.apart.iter().filter(|one| one.values_a + one.values_b > 0) {
        let mut row = |figure: String, a: Option<f64>, b: Option<f64>, found: &Interval| {
            let estimate = found.estimate.map_or("none".to_owned(), |estimate| signed(estimate, &one.unit));
            let cells = [one.column.clone(), figure, value(a, &one.unit), value(b, &one.unit), estimate];
            table.row(cells.into_iter().chain([interval(found, &one.unit)]).collect());
        };
        row("mean".to_owned(), one.mean_a, one.mean_b, &one.mean);
        for quantile in &one.quantiles {
            let figure = format!("{} quantile", percent_given(quantile.quantile));
            row(figure, quantile.a, quantile.b, &quantile.difference);
        }
    }
    let bad = |of: fn(&Apart) -> u64| found.apart.first().map_or(0, of);
    let (bad_a, bad_b) = (bad(|one| one.bad_a), bad(|one| one.bad_b));
    let mut text = format!("\nRows without partner, {} of A and {b} of B, as two samples:\n", counted(a, "row"));
    text.push_str(&table.fitting("  ", width));
    if bad_a + bad_b > 0 {
        text.push_str(&format!(
            "  {bad_a} of A and {bad_b} of B are not ok: means are those of the others, quantiles count them as anything at all\n"
        ));
    }
    let all = found.apart.iter();
    text + &notes(all.flat_map(intervals_of))
}

/// All intervals of a column, with its name.
fn intervals_of(one: &Apart) -> impl Iterator<Item = (&str, &Interval)> {
    let quantiles = one.quantiles.iter().map(|one| &one.difference);
    std::iter::once(&one.mean).chain(quantiles).map(|interval| (one.column.as_str(), interval))
}

/// "123 N in A, 124 N in B (+1 N, +0.8 %)".
fn both(change: &PairChange, unit: &str) -> String {
    let mut text = format!("{} in A, {} in B", value(change.value_a, unit), value(change.value_b, unit));
    if let (Some(apart), Some(a)) = (change.difference(unit), change.value_a) {
        text.push_str(&format!(" ({}", signed(apart, unit)));
        let part = 100.0 * apart / a.abs();
        text.push_str(&if part.is_finite() && !is_angle(unit) {
            format!(", {} %)", signed(part, ""))
        } else {
            ")".to_owned()
        });
    }
    text
}

fn largest_changes(found: &Compared) -> String {
    let moved = found.paired.iter().filter(|one| !one.largest_changes.is_empty());
    let mut shown: Vec<&Difference> = moved.collect();
    let is_asked = |one: &&Difference| found.tolerances.iter().any(|judged| judged.column == one.column);
    if found.tolerances.is_empty() {
        // a column that is 0 in A has no relative size and comes first
        let size = |one: &Difference| one.relative.unwrap_or(f64::INFINITY);
        shown.sort_by(|x, y| size(y).total_cmp(&size(x)));
        shown.truncate(COLUMNS);
    } else {
        shown.retain(is_asked);
    }
    if shown.is_empty() {
        return String::new();
    }
    let mut text = "\nLargest changes:\n".to_owned();
    for one in shown {
        text.push_str(&format!("  {}\n", one.column));
        for change in one.largest_changes.iter().take(NAMED) {
            text.push_str(&format!("    {}\n      {}\n", both(change, &one.unit), located(&change.pair)));
        }
    }
    text
}

fn tolerances(found: &Compared) -> String {
    let Some(is_out) = found.out_of_tolerance else { return String::new() };
    let mut text = "\nTolerances:\n".to_owned();
    for judged in &found.tolerances {
        text.push_str(&format!("  {}: {}\n", judged.tolerance, judgement(judged, found)));
    }
    if found.status.changed > 0 {
        text.push_str(&format!(
            "  {} of another status count as out of tolerance\n",
            counted(found.status.changed, "pair")
        ));
    }
    if found.matched.only_in_a > 0 {
        let rows = counted(found.matched.only_in_a, "row");
        text.push_str(&format!("  {rows} of A without partner: not compared, which counts as out of tolerance\n"));
    }
    let is_partial = |judged: &Judged| judged.empty + left_out(judged, found) > 0;
    text + match (is_out, found.tolerances.iter().any(is_partial)) {
        (true, _) => "Out of tolerance.\n",
        (false, true) => "Within the tolerances, in the pairs that could be compared.\n",
        (false, false) => "Within the tolerances.\n",
    }
}

/// Pairs that are not ok in either table, if this column is not compared for them.
fn left_out(judged: &Judged, found: &Compared) -> u64 {
    if is_reached(&judged.column) { 0 } else { found.status.bad_alike }
}

/// "; not compared: 16 pairs without a value in either (first sample 3)"; empty if all pairs are compared.
fn not_compared(judged: &Judged, found: &Compared) -> String {
    let mut parts = Vec::new();
    if judged.empty > 0 {
        parts.push(format!(
            "{} without a value in either{}",
            counted(judged.empty, "pair"),
            first(&judged.first_empty)
        ));
    }
    let others = left_out(judged, found);
    if others > 0 {
        let guarded = format!("guarded_{}", judged.column);
        let has = found.paired.iter().any(|one| one.column == guarded);
        let hint = if has { format!(" (see {guarded})") } else { String::new() };
        parts.push(format!("{} not ok in both{hint}", counted(others, "pair")));
    }
    if parts.is_empty() { String::new() } else { format!("; not compared: {}", parts.join(", ")) }
}

/// " (first sample 3)".
fn first(pair: &Option<Pair>) -> String {
    pair.as_ref().map_or_else(String::new, |pair| format!(" (first {})", samples(pair)))
}

fn judgement(judged: &Judged, found: &Compared) -> String {
    let missing = not_compared(judged, found);
    if judged.compared + judged.one_sided == 0 {
        return format!("nothing could be compared, which counts as out of tolerance{missing}");
    }
    let all = counted(judged.compared + judged.one_sided, "pair");
    let mut text = if judged.holds() {
        format!("within in {all}")
    } else {
        format!("out of tolerance in {} of {all}", judged.out)
    };
    if judged.one_sided > 0 {
        let first = first(&judged.first_one_sided);
        text.push_str(&format!(" and a value in one alone in {}{first}", judged.one_sided));
    }
    let unit = found.paired.iter().find(|one| one.column == judged.column).map_or("", |one| one.unit.as_str());
    let text = match &judged.worst {
        Some(worst) if worst.value_a != worst.value_b => {
            text + &format!("; farthest {}, {}", both(worst, unit), samples(&worst.pair))
        }
        _ => text,
    };
    text + &missing
}
