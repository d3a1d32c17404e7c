//! The words for engines and contact detections in files, commands, tables and histories.

use super::model::{Detection, Engine};

impl Engine {
    /// Words of all engines.
    pub const WORDS: [&str; 3] = [Self::Reduced.word(), Self::Full.word(), Self::Exponential.word()];
    /// The word that selects the engine by the machine ([`super::EngineChoice`]).
    pub const AUTO: &str = "auto";
    /// Allowed words in a file, the default first.
    pub const CHOICES: [&str; 4] = [Self::AUTO, Self::Reduced.word(), Self::Full.word(), Self::Exponential.word()];

    /// The word of this engine.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Reduced => "reduced",
            Self::Full => "full",
            Self::Exponential => "exponential",
        }
    }

    /// The engine with this word.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        [Self::Reduced, Self::Full, Self::Exponential].into_iter().find(|engine| engine.word() == word)
    }
}

impl Detection {
    /// Words of all detections, in the order of the paper.
    pub const WORDS: [&str; 3] = [Self::Hyp1.word(), Self::Hyp2.word(), Self::Hyp2Frozen.word()];

    /// The word of this detection.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Hyp1 => "hyp1",
            Self::Hyp2 => "hyp2",
            Self::Hyp2Frozen => "hyp2-frozen",
        }
    }

    /// The detection with this word.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        [Self::Hyp1, Self::Hyp2, Self::Hyp2Frozen].into_iter().find(|detection| detection.word() == word)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_is_that_of_what_it_names() {
        for word in Engine::WORDS {
            assert_eq!(Engine::from_word(word).map(Engine::word), Some(word));
        }
        assert_eq!((Engine::CHOICES[0], &Engine::CHOICES[1..]), (Engine::AUTO, &Engine::WORDS[..]));
        for word in Detection::WORDS {
            assert_eq!(Detection::from_word(word).map(Detection::word), Some(word));
        }
        assert_eq!((Engine::from_word("hyp2"), Detection::from_word("full")), (None, None));
    }
}
