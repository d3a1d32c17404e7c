//! Steps of a comparison in order: names, rows, partners, then a few columns at a time.

use super::apart::{Rest, apart};
use super::asked::{Asked, Source};
use super::circle::{is_angle, unwrapped};
use super::draw::{Clusters, Draw};
use super::error::CompareError;
use super::found::{Change, Compared, Inputs, Judged, Matched, Pair, SCHEMA, Sided, Statuses};
use super::load::{Loaded, Words, at_once, load};
use super::matching::Matching;
use super::names::{Columns, Names};
use super::paired::{Pairs, difference, is_reached, judge, words};
use super::side::{Side, Verdicts};
use super::sources::differing;
use super::{inputs, notes};
use crate::ask::CONFIDENCE;
use crate::tables::column_heads;
use std::collections::BTreeMap;

/// Largest number of pairs listed for a change of status.
const MOST_CHANGED: usize = 100;

/// Compares B with A.
///
/// # Errors
/// A table cannot be read or is not a result table; an option is invalid.
pub fn compare(a: &Source<'_>, b: &Source<'_>, asked: &Asked<'_>) -> Result<Compared, CompareError> {
    let columns = |source: &Source<'_>| Columns::of(column_heads(&source.files[0])?, &source.files[0]);
    let names = Names::of(&columns(a)?, &columns(b)?, asked)?;
    let mut verdicts = Verdicts::default();
    let by: Vec<_> = names.by.iter().collect();
    let (of_a, of_b) = (Side::read(a.files, &by, &mut verdicts)?, Side::read(b.files, &by, &mut verdicts)?);
    let can_match = names.alone.0.is_empty() && names.alone.1.is_empty();
    let matching = if can_match { Matching::of(&of_a, &of_b) } else { Matching::none(&of_a, &of_b) };
    let (ok, alike, status) = statuses(&matching.pairs, &of_a, &of_b, &verdicts);
    let sided = |source: &Source<'_>, side: &Side| Sided {
        name: source.name.clone(),
        rows: side.rows() as u64,
        ok: side.count_ok(),
    };
    let mut found = Compared {
        schema: SCHEMA,
        a: sided(a, &of_a),
        b: sided(b, &of_b),
        confidence: CONFIDENCE,
        differs: differing(&a.files[0], &b.files[0])?,
        inputs: names.by.iter().map(|head| head.name.clone()).collect(),
        ignored: names.ignored.clone(),
        only_in_a: names.only.0.clone(),
        only_in_b: names.only.1.clone(),
        of_another_kind: names.of_another_kind.clone(),
        matched: matched(&matching),
        notes: notes::of(&names, &matching, (a, &of_a), (b, &of_b))?,
        status,
        paired: Vec::new(),
        words: Vec::new(),
        apart: Vec::new(),
        tolerances: Vec::new(),
        out_of_tolerance: None,
    };
    let work = Work { a, b, of_a: &of_a, of_b: &of_b, names: &names, matching: &matching, ok: &ok, alike: &alike };
    work.columns(&mut found)?;
    find_inputs(&mut found, a, b, &names)?;
    found.out_of_tolerance = (!names.tolerances.is_empty()).then(|| {
        let held = found.tolerances.iter().all(Judged::holds);
        !held || found.status.changed > 0 || found.matched.only_in_a > 0
    });
    Ok(found)
}

fn matched(matching: &Matching) -> Matched {
    Matched {
        pairs: matching.pairs.len() as u64,
        repeated: matching.repeated,
        only_in_a: matching.only_a.len() as u64,
        only_in_b: matching.only_b.len() as u64,
        unclear_in_a: matching.unclear.0,
        unclear_in_b: matching.unclear.1,
    }
}

/// Row indices in the two tables.
type Rows = (usize, usize);

/// Pairs that are ok in both tables, pairs with equal status and cause (ok or not), and the counts of all.
fn statuses(pairs: &[Rows], a: &Side, b: &Side, verdicts: &Verdicts) -> (Vec<Rows>, Vec<Rows>, Statuses) {
    let (mut ok, mut found) = (Vec::with_capacity(pairs.len()), Statuses::default());
    let mut alike = Vec::with_capacity(pairs.len());
    let mut changes: BTreeMap<(u16, u16), (u64, Vec<Pair>)> = BTreeMap::new();
    for &(row_a, row_b) in pairs {
        let (from, to) = (a.verdicts[row_a], b.verdicts[row_b]);
        if from == to {
            alike.push((row_a, row_b));
        }
        if a.is_ok(row_a) && b.is_ok(row_b) {
            ok.push((row_a, row_b));
        } else if from == to {
            found.bad_alike += 1;
        } else {
            let (count, first) = changes.entry((from, to)).or_default();
            *count += 1;
            if first.len() < MOST_CHANGED {
                first.push(Pair::new((row_a, row_b), (a.samples[row_a], b.samples[row_b])));
            }
        }
    }
    found.ok = ok.len() as u64;
    found.changed = changes.values().map(|(count, _)| count).sum();
    let change = |((from, to), (count, pairs)): (&(u16, u16), &(u64, Vec<Pair>))| Change {
        from: verdicts.label(*from).to_owned(),
        to: verdicts.label(*to).to_owned(),
        count: *count,
        pairs: pairs.clone(),
    };
    found.changes = changes.iter().map(change).collect();
    found.changes.sort_by(|x, y| (y.count, &x.from, &x.to).cmp(&(x.count, &y.from, &y.to)));
    (ok, alike, found)
}

/// Inputs of the comparison of columns.
struct Work<'a> {
    a: &'a Source<'a>,
    b: &'a Source<'a>,
    of_a: &'a Side,
    of_b: &'a Side,
    names: &'a Names,
    matching: &'a Matching,
    ok: &'a [Rows],
    alike: &'a [Rows],
}

impl Work<'_> {
    fn columns(&self, found: &mut Compared) -> Result<(), CompareError> {
        let (of_ok, of_alike) = (self.clusters_of_pairs(self.ok), self.clusters_of_pairs(self.alike));
        let of_rests = self.clusters_of_rests();
        let samples = (self.of_a.samples.as_slice(), self.of_b.samples.as_slice());
        let ok = Pairs { rows: self.ok, samples, clusters: &of_ok };
        let alike = Pairs { rows: self.alike, samples, clusters: &of_alike };
        let (is_ok_a, is_ok_b) = (|row| self.of_a.is_ok(row), |row| self.of_b.is_ok(row));
        let rest_a = Rest { rows: &self.matching.only_a, samples: samples.0, is_ok: &is_ok_a, clusters: &of_rests.0 };
        let rest_b = Rest { rows: &self.matching.only_b, samples: samples.1, is_ok: &is_ok_b, clusters: &of_rests.1 };
        let has_rests = !rest_a.rows.is_empty() && !rest_b.rows.is_empty();
        let mut known = Words::default();
        let (rows_a, rows_b) = (self.of_a.rows(), self.of_b.rows());
        let mut judged: Vec<Option<Judged>> = self.names.tolerances.iter().map(|_| None).collect();
        for some in self.names.results.chunks(at_once(rows_a.max(rows_b))) {
            let heads: Vec<_> = some.iter().collect();
            let of_a = load(self.a.files, &heads, rows_a, &mut known)?;
            let of_b = load(self.b.files, &heads, rows_b, &mut known)?;
            for (head, (cells_a, cells_b)) in heads.iter().zip(of_a.iter().zip(&of_b)) {
                let pairs = if is_reached(&head.name) { &alike } else { &ok };
                match (cells_a, cells_b) {
                    (Loaded::Numbers(a), Loaded::Numbers(b)) => {
                        found.paired.push(difference(head, a, b, pairs));
                        if has_rests && is_angle(&head.unit) {
                            let [a, b] = unwrapped(&head.unit, a, b);
                            found.apart.push(apart(head, (&a, &rest_a), (&b, &rest_b)));
                        } else if has_rests {
                            found.apart.push(apart(head, (a, &rest_a), (b, &rest_b)));
                        }
                        for (place, tolerance) in judged.iter_mut().zip(&self.names.tolerances) {
                            if tolerance.column == head.name {
                                *place = Some(judge(tolerance, a, b, pairs));
                            }
                        }
                    }
                    (Loaded::Words(a), Loaded::Words(b)) => found.words.extend(words(head, a, b, pairs, &known)),
                    // results whose kind differs are not compared
                    _ => {}
                }
            }
        }
        found.tolerances = judged.into_iter().flatten().collect();
        Ok(())
    }

    /// Clusters of pairs. They are a random sample only if they contain all rows of a study.
    fn clusters_of_pairs(&self, rows: &[Rows]) -> Clusters {
        let all_of_a = self.matching.only_a.is_empty();
        if all_of_a || self.matching.only_b.is_empty() {
            let (draw, side) = if all_of_a { (self.a.draw, self.of_a) } else { (self.b.draw, self.of_b) };
            let sample = |&(a, b): &(usize, usize)| side.samples[if all_of_a { a } else { b }];
            return draw.clusters(rows.iter().map(sample));
        }
        let why = "no interval: only part of each study has partners, and that part is not a random sample";
        Draw::without(why).clusters(std::iter::empty())
    }

    /// Clusters of the unmatched rows. They are random samples only if no row has a partner.
    fn clusters_of_rests(&self) -> (Clusters, Clusters) {
        let of = |source: &Source<'_>, side: &Side, rows: &[usize]| {
            if self.matching.pairs.is_empty() {
                return source.draw.clusters(rows.iter().map(|&row| side.samples[row]));
            }
            let why = "no interval: rows without partner are part of their study, and that part is not a random sample";
            Draw::without(why).clusters(std::iter::empty())
        };
        (of(self.a, self.of_a, &self.matching.only_a), of(self.b, self.of_b, &self.matching.only_b))
    }
}

/// Adds the identifying inputs to every pair that is listed.
fn find_inputs(found: &mut Compared, a: &Source<'_>, b: &Source<'_>, names: &Names) -> Result<(), CompareError> {
    let mut pairs: Vec<&mut Pair> = Vec::new();
    pairs.extend(found.status.changes.iter_mut().flat_map(|change| change.pairs.iter_mut()));
    for moved in &mut found.paired {
        pairs.extend(moved.largest_changes.iter_mut().chain(&mut moved.one_sided).map(|change| &mut change.pair));
    }
    pairs.extend(found.words.iter_mut().filter_map(|change| change.first.as_mut()));
    pairs.extend(found.tolerances.iter_mut().flat_map(Judged::pairs));
    let in_a = inputs::of_rows(a.files, &names.inputs, pairs.iter().map(|pair| pair.rows.0))?;
    let in_b = inputs::of_rows(b.files, &names.inputs, pairs.iter().map(|pair| pair.rows.1))?;
    for pair in pairs {
        let (of_a, of_b) = (&in_a[&pair.rows.0], &in_b[&pair.rows.1]);
        let both = names.inputs.iter().zip(of_a.iter().zip(of_b));
        let told = both
            .map(|(head, (a, b))| (head.name.clone(), if a == b { a.clone() } else { format!("{a} in A, {b} in B") }));
        pair.inputs = Inputs(told.collect());
    }
    Ok(())
}
