//! The known name that a misspelled one most likely means.

/// Longest name that is compared. Longer words are hardly misspelled names, and comparing them would take time.
const LONGEST: usize = 128;

/// Number of edits that a missing or additional whole word counts as.
const WORD: usize = 2;

/// The candidate nearest to `given`; `None` if no candidate is near enough.
///
/// Near means one of: at most one edit per three characters (at least two edits for names of four or more); all words of one name occur in
/// the other in the same order (`run.time_step` means `run.step`); Jaro-Winkler similarity above 0.9 (catches missing endings).
#[must_use]
pub fn nearest<'a>(given: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let length = given.chars().count();
    if length == 0 || length > LONGEST {
        return None;
    }
    let lower = given.to_lowercase();
    let mut best: Option<((usize, usize), &str)> = None;
    for candidate in candidates {
        if candidate == given || candidate.len() > LONGEST {
            continue;
        }
        let other = candidate.to_lowercase();
        let edits = strsim::damerau_levenshtein(&lower, &other);
        let words = words_apart(&lower, &other).map(|words| words * WORD);
        let allowed = if length < 4 { 1 } else { (length / 3).max(2) };
        let near = edits <= allowed && edits < other.chars().count() || strsim::jaro_winkler(&lower, &other) > 0.9;
        let distance = (words.map_or(edits, |words| words.min(edits)), edits);
        if (near || words.is_some()) && best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

/// Difference in the number of words, if one name has all words of the other in the same order.
fn words_apart(a: &str, b: &str) -> Option<usize> {
    let words = |name: &'_ str| name.split(['_', '-', '.']).count();
    let (long, short) = if words(a) > words(b) { (a, b) } else { (b, a) };
    let mut rest = long.split(['_', '-', '.']);
    short.split(['_', '-', '.']).all(|word| rest.any(|other| other == word)).then(|| words(long) - words(short))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mistyped_name_finds_the_one_meant() {
        let names = ["stiffness", "damping", "axial_stiffness", "position"];
        assert_eq!(nearest("stifness", names), Some("stiffness"));
        assert_eq!(nearest("Damping", names), Some("damping"));
        assert_eq!(nearest("postion", names), Some("position"));
    }

    #[test]
    fn a_word_too_many_or_too_few_is_nearer_than_another_word() {
        let run = ["run.end_time", "run.end_speed", "run.step", "run.step_limit", "run.guard.penetration"];
        assert_eq!(nearest("run.time_step", run), Some("run.step"));
        assert_eq!(nearest("run.step_size", run), Some("run.step"));
        assert_eq!(nearest("run.limit", run), Some("run.step_limit"));
        assert_eq!(nearest("run.stepp", run), Some("run.step"));
        assert_eq!(nearest("run.step_limt", run), Some("run.step_limit"));
        assert_eq!(nearest("seal_gap", ["gap", "offset"]), Some("gap"));
        assert_eq!(nearest("time", ["end_time", "times"]), Some("times"), "one edit");
    }

    #[test]
    fn a_name_unlike_all_others_finds_none() {
        assert_eq!(nearest("colour", ["stiffness", "gap"]), None);
        assert_eq!(nearest("x", ["y", "gap"]), None);
        assert_eq!(nearest("", ["gap"]), None);
        assert_eq!(nearest(&"a".repeat(1_000_000), ["gap"]), None);
    }
}
