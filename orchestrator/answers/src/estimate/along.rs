//! Groups along one varied parameter, as compared by differences and fragility curves.
//!
//! ```text
//! crossed    a x b       along a: one family for each b
//! zipped     (a, b) x c  along a: one family for each c; b goes with a
//! ```
//! Two parameters are zipped where not every pair of their values occurs. If zipped values recur (a = 1 with b = 0 and with b = 1), a value
//! of the parameter does not identify one group, and the parameter is rejected.

use super::input::{Group, InputError, Label};
use std::collections::{BTreeMap, BTreeSet};

/// Groups that differ in one parameter only.
#[derive(Debug, Clone, PartialEq)]
pub struct Family {
    /// Parameters and values that all groups of the family share.
    pub rest: Group,
    /// Value of the parameter and index of the group, for each group.
    pub members: Vec<(Label, usize)>,
}

/// Sort key of a label.
fn key(label: &Label) -> (u64, &str) {
    match label {
        Label::Number(number) => (number.to_bits(), ""),
        Label::Word(word) => (0, word),
    }
}

/// Parameters that are zipped with `path`.
#[must_use]
pub fn together(groups: &[Group], path: &str) -> Vec<String> {
    let others = groups.first().map(|group| group.0.as_slice()).unwrap_or_default();
    let goes_along = |other: &str| {
        let (mut here, mut there, mut pairs) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
        for group in groups {
            if let (Some(a), Some(b)) = (group.label(path), group.label(other)) {
                here.insert(key(a));
                there.insert(key(b));
                pairs.insert((key(a), key(b)));
            }
        }
        pairs.len() < here.len() * there.len()
    };
    others.iter().map(|(other, _)| other).filter(|other| *other != path && goes_along(other)).cloned().collect()
}

/// Groups along a parameter, one family for each combination of the parameters that are not zipped with it; empty if it is not varied.
///
/// # Errors
/// The values recur along the axis of the parameter.
pub fn families(groups: &[Group], path: &str) -> Result<Vec<Family>, InputError> {
    let along = together(groups, path);
    let mut families: Vec<Family> = Vec::new();
    let mut places: BTreeMap<Vec<(u64, String)>, usize> = BTreeMap::new();
    let mut seen = BTreeSet::new();
    for (at, group) in groups.iter().enumerate() {
        let Some(label) = group.label(path) else { continue };
        let rest = along.iter().fold(group.without(path), |rest, other| rest.without(other));
        let name = rest.0.iter().map(|(_, label)| key(label)).map(|(bits, word)| (bits, word.to_owned())).collect();
        let place = *places.entry(name).or_insert_with(|| {
            families.push(Family { rest, members: Vec::new() });
            families.len() - 1
        });
        if !seen.insert((place, key(label))) {
            return Err(InputError::Method(recurs(path, label, &along)));
        }
        families[place].members.push((label.clone(), at));
    }
    Ok(families)
}

fn recurs(path: &str, label: &Label, along: &[String]) -> String {
    let others = along.iter().map(|other| format!("`{other}`")).collect::<Vec<_>>().join(" or ");
    format!("{label} occurs more than once along `{path}`, with other values of {others}: ask along {others}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn groups(of: &[(f64, f64, f64)]) -> Vec<Group> {
        let named = |name: &str, value| (name.to_owned(), Label::Number(value));
        of.iter().map(|(a, b, c)| Group(vec![named("a", *a), named("b", *b), named("c", *c)])).collect()
    }

    #[test]
    fn what_is_zipped_goes_along_and_what_is_crossed_stays() {
        let zipped = groups(&[(1.0, 0.0, 5.0), (1.0, 0.0, 6.0), (2.0, 1.0, 5.0), (2.0, 1.0, 6.0)]);
        assert_eq!(together(&zipped, "a"), ["b"]);
        assert_eq!(together(&zipped, "c"), Vec::<String>::new());
        let along = families(&zipped, "a").unwrap();
        let members = |at: [usize; 2]| vec![(Label::Number(1.0), at[0]), (Label::Number(2.0), at[1])];
        assert_eq!(
            along.iter().map(|family| family.members.clone()).collect::<Vec<_>>(),
            [members([0, 2]), members([1, 3])]
        );
        assert_eq!(along[0].rest, Group(vec![("c".to_owned(), Label::Number(5.0))]));
        // along c, each of the two zipped pairs is a family
        assert_eq!(families(&zipped, "c").unwrap().len(), 2);
        assert_eq!(families(&zipped, "d").unwrap(), []);
    }

    #[test]
    fn zipped_values_that_recur_are_refused() {
        let twice = groups(&[(1.0, 0.0, 5.0), (1.0, 1.0, 5.0), (2.0, 2.0, 5.0)]);
        let said = families(&twice, "a").unwrap_err().to_string();
        assert!(said.contains("1 occurs more than once along `a`") && said.contains("`b`"), "{said}");
        assert_eq!(families(&twice, "b").unwrap().len(), 1);
    }
}
