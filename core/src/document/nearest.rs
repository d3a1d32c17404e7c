//! The known name that a mistyped one most likely means.

/// Longer words are not names that somebody mistyped; comparing them would only cost time.
const LONGEST: usize = 128;

/// The candidate nearest to `given`; `None` if none is near enough to be worth showing.
///
/// Near: at most one edit per three characters (two always for words of four and more), or Jaro-Winkler similarity
/// above 0.9 (catches endings that were left out).
#[must_use]
pub fn nearest<'a>(given: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let length = given.chars().count();
    if length == 0 || length > LONGEST {
        return None;
    }
    let lower = given.to_lowercase();
    let mut best: Option<(usize, &str)> = None;
    for candidate in candidates {
        if candidate == given || candidate.len() > LONGEST {
            continue;
        }
        let other = candidate.to_lowercase();
        let edits = strsim::damerau_levenshtein(&lower, &other);
        let allowed = if length < 4 { 1 } else { (length / 3).max(2) };
        let near = edits <= allowed && edits < other.chars().count() || strsim::jaro_winkler(&lower, &other) > 0.9;
        if near && best.is_none_or(|(least, _)| edits < least) {
            best = Some((edits, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
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
    fn a_name_unlike_all_others_finds_none() {
        assert_eq!(nearest("colour", ["stiffness", "gap"]), None);
        assert_eq!(nearest("x", ["y", "gap"]), None);
        assert_eq!(nearest("", ["gap"]), None);
        assert_eq!(nearest(&"a".repeat(1_000_000), ["gap"]), None);
    }
}
