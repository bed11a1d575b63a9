//! Title of a program, from its head: the comment beside its O number, `BEGIN PGM name`, `%_N_name_MPF`.
//!
//! Other comments at the head may be about anything (the author, the machine, the tools), and are not a title.

use crate::simulation::gcode::encoding;

/// Length of the head in which a title is searched, bytes.
const MAX_HEAD_BYTES: usize = 8192;

/// Length of the head in which a title is searched, lines.
const MAX_HEAD_LINES: usize = 40;

/// Longest title, in characters.
const MAX_TITLE_CHARACTERS: usize = 80;

/// Words before a title that only announce it.
const PREFIXES: [&str; 4] = ["program name", "part name", "program", "name"];

/// Returns the title of a program, or `None` if it has none.
pub fn title(bytes: &[u8]) -> Option<String> {
    let (text, _) = encoding::text(&bytes[..bytes.len().min(MAX_HEAD_BYTES)]);
    let text = encoding::characters(&text);
    let found = text.lines().take(MAX_HEAD_LINES).find_map(of_line)?;
    let mut title = found.trim();
    for prefix in PREFIXES {
        let head = title.get(..prefix.len()).filter(|head| head.eq_ignore_ascii_case(prefix));
        let rest = head.map(|_| &title[prefix.len()..]);
        if let Some(rest) = rest.filter(|rest| rest.starts_with([' ', ':', '=', '-'])) {
            title = rest.trim_start_matches([' ', ':', '=', '-']);
            break;
        }
    }
    // A number alone is usually the name of the file.
    let is_title = title.chars().any(char::is_alphabetic);
    is_title.then(|| title.chars().filter(|letter| !letter.is_control()).take(MAX_TITLE_CHARACTERS).collect())
}

/// Returns the title in a line, or `None` if it has none.
fn of_line(line: &str) -> Option<&str> {
    let line = line.trim().trim_start_matches('\0');
    if let Some(name) = line.strip_prefix("%_N_") {
        return name.rsplit_once('_').map(|(name, _)| name);
    }
    let unnumbered = line.trim_start_matches(|letter: char| letter.is_ascii_digit()).trim_start();
    if let Some(name) = unnumbered.strip_prefix("BEGIN PGM ") {
        let name = name.trim();
        return Some(name.rsplit_once(' ').map_or(name, |(name, _)| name));
    }
    let number = line.strip_prefix(['O', 'o', ':'])?;
    let rest = number.trim_start_matches(|letter: char| letter.is_ascii_digit());
    let comment = rest.trim_start().strip_prefix('(').filter(|_| rest.len() < number.len())?;
    comment.split(')').next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_says_what_it_is_called_where_its_number_is() {
        for (text, expected) in [
            ("%\nO0001(VINT)\nG0 X0\n", Some("VINT")),
            ("%\nO1001(PROGRAM NAME 827-9999-904, OP1)\nN100 G20\n", Some("827-9999-904, OP1")),
            ("%\n:3003 ( Holes in spiral )\n", Some("Holes in spiral")),
            ("0  BEGIN PGM Plan-Beispiel MM \n1 L X0\n", Some("Plan-Beispiel")),
            ("BEGIN PGM PROFILE  MM\n", Some("PROFILE")),
            ("%_N_BRACKET_OP20_MPF\n;$PATH=/_N_WKS_DIR\nG0 X0\n", Some("BRACKET_OP20")),
            ("%\nO0001(1001)\nG0\n", None),
            ("%\nO0001\n(written by a person)\nG0\n", None),
            ("( This program is copyright )\nG1 X1\n", None),
            ("o100 sub\n(inner)\n", None),
            ("PROGRAM\n", None),
            ("", None),
        ] {
            assert_eq!(title(text.as_bytes()).as_deref(), expected, "{text}");
        }
        let wide: Vec<u8> = "O1(Größe)\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(title(&wide).as_deref(), Some("Größe"));
        assert_eq!(title(b"O1(Gr\xf6\xdfe)").as_deref(), Some("Größe"));
        assert_eq!(title(format!("O1({})", "x".repeat(500)).as_bytes()).map(|title| title.len()), Some(80));
    }
}
