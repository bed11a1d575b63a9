//! Words of lathes by which X words are diameters. Only SINUMERIK has them, so a program with one of them is a
//! lathe program, whatever the dialect it is read in.
//!
//! Source: SINUMERIK 840D sl, Programming Manual Fundamentals, diameter programming.

/// The words; some of them continue with the axis that they hold for (`DIAMONA[X]`).
const DIAMETER_WORDS: &[&str] =
    &["DIAMON", "DIAM90", "DIAMCYCA", "DIAMCYCOF", "DIAMONA", "DIAM90A", "DIACYCOFA"];

/// Returns the first such word in `code`, a line in upper case without comments.
pub(super) fn diameter_word(code: &[u8]) -> Option<&'static str> {
    let is_in_name = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    let mut at = 0;
    while let Some(found) = memchr::memchr(b'D', code.get(at..)?) {
        let start = at + found;
        let is_start = start == 0 || !(code[start - 1].is_ascii_alphabetic() || code[start - 1] == b'_');
        let length = code[start..].iter().take_while(|byte| is_in_name(byte)).count();
        let name = &code[start..start + length];
        let word = DIAMETER_WORDS.iter().find(|word| word.as_bytes() == name);
        if is_start && let Some(word) = word {
            return Some(word);
        }
        at = start + 1;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_as_wholes() {
        for (code, word) in [
            ("DIAMON", Some("DIAMON")),
            ("G18 G90 DIAM90 F1", Some("DIAM90")),
            ("G90DIAMON", Some("DIAMON")),
            ("G18 DIAMONA[X]", Some("DIAMONA")),
            ("D1 DIAMCYCOF", Some("DIAMCYCOF")),
            ("DIAMOF", None),
            ("#<DIAMON_RADIUS>=1", None),
            ("T=\"DIAMOND\"", None),
            ("MY_DIAMON=1", None),
            ("D1 X5", None),
            ("", None),
        ] {
            assert_eq!(diameter_word(code.as_bytes()), word, "{code}");
        }
    }
}
