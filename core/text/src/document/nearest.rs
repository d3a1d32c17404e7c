//! The known name that a mistyped one most likely means.

/// Longer words are not names that somebody mistyped; comparing them would only cost time.
const LONGEST: usize = 128;

/// A whole word too many or too few counts as so many edits.
const WORD: usize = 2;

/// The candidate nearest to `given`; `None` if none is near enough to be worth showing.
///
/// Near: at most one edit per three characters (two always for words of four and more), or all words of one in the other
/// in their order (`run.time_step` means `run.step`), or Jaro-Winkler similarity above 0.9 (catches endings that were left out).
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

/// How many words one name has more than the other, if it has all of the other's in their order.
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
