//! Matches rows of A with rows of B by their inputs.
//!
//! Several rows of a table can have the same inputs (repeats, or ignored inputs). If their number is the same in A and B, they are
//! matched in the order of their samples. If it differs, the assignment is ambiguous and none of them is matched.

use super::side::Side;

/// Matched and unmatched rows.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Matching {
    /// Row indices in A and B, in the order of the samples of A.
    pub pairs: Vec<(usize, usize)>,
    /// Unmatched rows of A, in the order of samples.
    pub only_a: Vec<usize>,
    /// Unmatched rows of B, in the order of samples.
    pub only_b: Vec<usize>,
    /// Pairs whose inputs occur in several rows.
    pub repeated: u64,
    /// Unmatched rows of A and of B whose inputs occur in the other table a different number of times.
    pub unclear: (u64, u64),
}

impl Matching {
    /// Result without any pair.
    pub fn none(a: &Side, b: &Side) -> Self {
        Self { only_a: by_sample(a), only_b: by_sample(b), ..Self::default() }
    }

    /// Matches rows by the keys of their inputs.
    pub fn of(a: &Side, b: &Side) -> Self {
        let (rows_a, rows_b) = (by_key(a), by_key(b));
        let mut found = Self::default();
        let (mut from_a, mut from_b) = (0, 0);
        while from_a < rows_a.len() || from_b < rows_b.len() {
            let next = |rows: &[usize], side: &Side, from: usize| rows.get(from).map(|&row| side.keys[row]);
            let (key_a, key_b) = (next(&rows_a, a, from_a), next(&rows_b, b, from_b));
            let key = match (key_a, key_b) {
                (Some(x), Some(y)) => x.min(y),
                (x, y) => x.or(y).unwrap_or_default(),
            };
            let run = |rows: &[usize], side: &Side, from: usize| {
                from + rows[from..].iter().take_while(|&&row| side.keys[row] == key).count()
            };
            let (to_a, to_b) = (run(&rows_a, a, from_a), run(&rows_b, b, from_b));
            let (of_a, of_b) = (&rows_a[from_a..to_a], &rows_b[from_b..to_b]);
            if of_a.len() == of_b.len() {
                found.pairs.extend(of_a.iter().copied().zip(of_b.iter().copied()));
                found.repeated += if of_a.len() > 1 { of_a.len() as u64 } else { 0 };
            } else {
                found.only_a.extend(of_a);
                found.only_b.extend(of_b);
                if !of_a.is_empty() && !of_b.is_empty() {
                    found.unclear.0 += of_a.len() as u64;
                    found.unclear.1 += of_b.len() as u64;
                }
            }
            (from_a, from_b) = (to_a, to_b);
        }
        found.pairs.sort_unstable_by_key(|&(row, _)| (a.samples[row], row));
        found.only_a.sort_unstable_by_key(|&row| (a.samples[row], row));
        found.only_b.sort_unstable_by_key(|&row| (b.samples[row], row));
        found
    }
}

fn by_sample(side: &Side) -> Vec<usize> {
    let mut rows: Vec<usize> = (0..side.rows()).collect();
    rows.sort_unstable_by_key(|&row| (side.samples[row], row));
    rows
}

fn by_key(side: &Side) -> Vec<usize> {
    let mut rows: Vec<usize> = (0..side.rows()).collect();
    rows.sort_unstable_by_key(|&row| (side.keys[row], side.samples[row], row));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(keys: &[u128]) -> Side {
        let samples = (0..keys.len() as u64).collect();
        Side { samples, verdicts: vec![0; keys.len()], keys: keys.to_vec() }
    }

    #[test]
    fn rows_match_whatever_their_order() {
        let found = Matching::of(&side(&[7, 8, 9]), &side(&[9, 5, 7]));
        assert_eq!(found.pairs, [(0, 2), (2, 0)]);
        assert_eq!((found.only_a, found.only_b, found.repeated, found.unclear), (vec![1], vec![1], 0, (0, 0)));
    }

    #[test]
    fn repeats_are_matched_in_order_where_there_are_as_many() {
        let found = Matching::of(&side(&[7, 8, 7, 6, 6]), &side(&[8, 7, 7, 6]));
        assert_eq!(found.pairs, [(0, 1), (1, 0), (2, 2)]);
        assert_eq!((found.only_a, found.only_b), (vec![3, 4], vec![3]));
        assert_eq!((found.repeated, found.unclear), (2, (2, 1)));
    }

    #[test]
    fn a_table_without_rows_leaves_all_alone() {
        let found = Matching::of(&side(&[]), &side(&[1]));
        assert_eq!((found.pairs, found.only_b), (vec![], vec![0]));
        assert_eq!(Matching::of(&side(&[]), &side(&[])), Matching::default());
    }
}
