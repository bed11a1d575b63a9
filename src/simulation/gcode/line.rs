//! One line of the program: where it ends, how its columns count, where its comments close.

/// The most words of a block; controls take lines of some hundred characters.
pub(super) const MAX_WORDS: usize = 250;

/// The first line of `text` and what follows its end, or `None` if nothing is left.
pub(super) fn split_line(text: &[u8]) -> Option<(&[u8], &[u8])> {
    if text.is_empty() {
        return None;
    }
    let Some(end) = memchr::memchr2(b'\n', b'\r', text) else {
        return Some((text, &[]));
    };
    let after = if text[end..].starts_with(b"\r\n") { end + 2 } else { end + 1 };
    Some((&text[..end], &text[after..]))
}

/// The lines of `text`.
pub fn lines(mut text: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        let (line, after) = split_line(text)?;
        text = after;
        Some(line)
    })
}

/// What is known of the line being read.
#[derive(Default)]
pub(super) struct Line {
    /// Bytes so far that belong to a character already counted.
    pub(super) continuation: usize,
    /// Something but an N word stands before.
    pub(super) begun: bool,
    /// A `/` stands before.
    pub(super) is_optional: bool,
    /// An O word stands before.
    pub(super) has_o_word: bool,
    /// A word that calls or returns stands before.
    pub(super) has_call_words: bool,
    /// The jump over the rest of the line, as index of the flow.
    pub(super) skips: Option<usize>,
    /// The first comment without the signs around it, as bytes of the line.
    pub(super) comment: Option<(usize, usize)>,
    /// A comment before had parentheses within that did not match.
    pub(super) is_unbalanced: bool,
}

impl Line {
    /// Columns of the bytes from `start` to `end`, counted in characters as editors do. What stands before a text that is
    /// counted already comes out too far left, but within the line.
    pub(super) fn columns(&self, start: usize, end: usize) -> (u32, u32) {
        let column = |at: usize| at.saturating_sub(self.continuation) as u32 + 1;
        (column(start), column(end))
    }
}

/// Where a comment closes, as its length.
pub(super) enum CommentEnd {
    Matching(usize),
    First(usize),
    Missing,
}

/// The end of the comment that `text` begins with. Comments do not nest on controls, yet people
/// write `(D10 (NEW))`: the matching parenthesis closes where there is one, else the first. Once
/// a line is known to be unbalanced the first one does, so that no line is searched twice over.
pub(super) fn comment_end(text: &[u8], is_unbalanced: bool) -> CommentEnd {
    let (mut depth, mut first) = (0_usize, CommentEnd::Missing);
    for (index, byte) in text.iter().enumerate() {
        match byte {
            b'(' => depth += 1,
            b')' => {
                depth -= 1;
                if depth == 0 {
                    return CommentEnd::Matching(index + 1);
                }
                if is_unbalanced {
                    return CommentEnd::First(index + 1);
                }
                if matches!(first, CommentEnd::Missing) {
                    first = CommentEnd::First(index + 1);
                }
            }
            _ => {}
        }
    }
    first
}

/// Where the code from `at` on ends: at a comment or the end of the line.
pub(super) fn code_end(text: &[u8], at: usize) -> usize {
    let length = text[at..].iter().take_while(|byte| !matches!(byte, b'(' | b';')).count();
    at + text[at..at + length].trim_ascii_end().len()
}

/// Digits to the end of the line, as in `*71`.
pub(super) fn is_checksum(text: &[u8]) -> bool {
    let digits = text.trim_ascii();
    !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
}

/// Where a comment behind `;` begins, looked for from `at` on, or the line ends.
pub(super) fn semicolon(text: &[u8], at: usize) -> usize {
    text[at..].iter().position(|byte| *byte == b';').map_or(text.len(), |length| at + length)
}

/// Bytes of `text` that belong to a character already counted.
pub(super) fn continuation(text: &[u8]) -> usize {
    text.iter().filter(|byte| is_continuation(**byte)).count()
}

/// The second to fourth byte of a character in UTF-8.
pub(super) fn is_continuation(byte: u8) -> bool {
    byte & 0xc0 == 0x80
}

/// Bytes of the character that `text` begins with.
pub(super) fn character_length(text: &[u8]) -> usize {
    1 + text[1..].iter().take_while(|byte| is_continuation(**byte)).count()
}

/// The offending text, short whatever its bytes are.
pub(super) fn excerpt(text: &[u8]) -> String {
    const MAX_CHARACTERS: usize = 24;
    let mut shown: String = String::from_utf8_lossy(&text[..text.len().min(4 * MAX_CHARACTERS)])
        .chars()
        .take(MAX_CHARACTERS)
        .collect();
    if MAX_CHARACTERS < text.len() {
        shown.push('…');
    }
    shown
}
