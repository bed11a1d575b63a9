//! Conversion between variants and their keywords.

/// Returns the keyword of a variant.
pub(super) fn keyword_of<T: PartialEq>(words: &[(&'static str, T)], choice: T) -> &'static str {
    words.iter().find(|(_, own)| *own == choice).expect("each has a word").0
}

/// Returns the variant of a keyword; `None` if there is none.
pub(super) fn variant_of<T: Copy>(words: &[(&'static str, T)], written: &str) -> Option<T> {
    words.iter().find(|(word, _)| *word == written).map(|(_, choice)| *choice)
}

/// Returns the keywords of all variants, in their order.
pub(super) const fn keywords<T, const N: usize>(words: &[(&'static str, T); N]) -> [&'static str; N] {
    let mut keywords = [""; N];
    let mut index = 0;
    while index < N {
        keywords[index] = words[index].0;
        index += 1;
    }
    keywords
}
