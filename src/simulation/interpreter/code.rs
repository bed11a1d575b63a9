//! Spelling of a word, such as G1 or M30.

/// A letter with its number, as people write it: G91.1, M30.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Code {
    /// `G` or `M`.
    pub(super) letter: char,
    /// Its number.
    pub(super) value: f64,
}

impl std::fmt::Display for Code {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}{}", self.letter, self.value)
    }
}
