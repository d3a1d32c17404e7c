//! Chain of causes of an error.

use std::error::Error;

/// The chain of errors that caused this one, the nearest first, without the error itself.
pub fn causes<'a>(error: &'a (dyn Error + 'static)) -> impl Iterator<Item = &'a (dyn Error + 'static)> {
    std::iter::successors(error.source(), |&cause| cause.source())
}

/// An error with its chain of causes, in one line.
#[must_use]
pub fn with_causes(error: &(dyn Error + 'static)) -> String {
    causes(error).fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("{0}")]
    struct Link(&'static str, #[source] Option<Box<Link>>);

    #[test]
    fn every_cause_is_told_once_and_in_order() {
        let link = |text, source| Link(text, source);
        let error = link("outermost", Some(Box::new(link("middle", Some(Box::new(link("first", None)))))));
        assert_eq!(causes(&error).map(ToString::to_string).collect::<Vec<_>>(), ["middle", "first"]);
        assert_eq!(with_causes(&error), "outermost: middle: first");
        assert_eq!(with_causes(&link("alone", None)), "alone");
    }
}
