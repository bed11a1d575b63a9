//! Choices and the words they are written with.

/// The word of a choice; each has one.
pub(super) fn word_of<T: PartialEq>(words: &[(&'static str, T)], choice: T) -> &'static str {
    words.iter().find(|(_, own)| *own == choice).expect("each has a word").0
}

/// The choice that is written with a word.
pub(super) fn choice_of<T: Copy>(words: &[(&'static str, T)], written: &str) -> Option<T> {
    words.iter().find(|(word, _)| *word == written).map(|(_, choice)| *choice)
}
