//! One line of the program: its end, its columns, the ends of its comments.

/// Most words of a block; controls accept lines of some hundred characters.
pub(super) const MAX_WORDS: usize = 250;

/// Returns the first line of `text` and the text behind its end, or `None` if `text` is empty.
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

/// Returns the lines of `text`.
pub fn lines(mut text: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        let (line, after) = split_line(text)?;
        text = after;
        Some(line)
    })
}

/// State of the line being read.
#[derive(Default)]
pub(super) struct Line {
    /// Bytes so far that continue a character of several bytes.
    pub(super) continuation: usize,
    /// `true` if an item other than an N word came before.
    pub(super) begun: bool,
    /// `true` if a `/` came before.
    pub(super) is_optional: bool,
    /// `true` if an O word came before.
    pub(super) has_o_word: bool,
    /// `true` if a word that calls or returns came before.
    pub(super) has_call_words: bool,
    /// Index in the flow of the jump over the rest of the line.
    pub(super) skips: Option<usize>,
    /// Start and end of the first comment without its delimiters, in bytes of the line.
    pub(super) comment: Option<(usize, usize)>,
    /// `true` if an earlier comment had unmatched parentheses in it.
    pub(super) is_unbalanced: bool,
}

impl Line {
    /// Returns the columns of the bytes from `start` to `end`, 1-based, counted in characters as editors do.
    /// Columns of a text before one that is already counted are too far left, but within the line.
    pub(super) fn columns(&self, start: usize, end: usize) -> (u32, u32) {
        let column = |at: usize| at.saturating_sub(self.continuation) as u32 + 1;
        (column(start), column(end))
    }
}

/// Length of a comment, by the way its end was found.
pub(super) enum CommentEnd {
    Matching(usize),
    First(usize),
    Missing,
}

/// Returns the end of the comment that `text` begins with. Comments do not nest on controls, yet people write
/// `(D10 (NEW))`: the matching parenthesis closes the comment if there is one, else the first. In a line known to
/// be unbalanced the first one closes it, so that no line is searched twice.
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

/// Returns the end of the code from `at` on: at a comment or at the end of the line.
pub(super) fn code_end(text: &[u8], at: usize) -> usize {
    let length = text[at..].iter().take_while(|byte| !matches!(byte, b'(' | b';')).count();
    at + text[at..at + length].trim_ascii_end().len()
}

/// Returns `true` for digits to the end of the line, as in `*71`.
pub(super) fn is_checksum(text: &[u8]) -> bool {
    let digits = text.trim_ascii();
    !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
}

/// Returns the start of a comment behind `;`, searched from `at` on, or the end of the line.
pub(super) fn semicolon(text: &[u8], at: usize) -> usize {
    text[at..].iter().position(|byte| *byte == b';').map_or(text.len(), |length| at + length)
}

/// Returns the number of bytes of `text` that continue a character of several bytes.
pub(super) fn continuation(text: &[u8]) -> usize {
    text.iter().filter(|byte| is_continuation(**byte)).count()
}

/// Returns `true` for the second to fourth byte of a character in UTF-8.
pub(super) fn is_continuation(byte: u8) -> bool {
    byte & 0xc0 == 0x80
}

/// Returns the length of the character that `text` begins with, bytes.
pub(super) fn character_length(text: &[u8]) -> usize {
    1 + text[1..].iter().take_while(|byte| is_continuation(**byte)).count()
}

/// Returns the beginning of a faulty text, short whatever its bytes are.
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
