//! Detection of the control that a program was written for.
//!
//! Truefeed searches the first lines for marks that only one family of controls reads. The dialect with the
//! highest score wins; without marks it is plain ISO, which Fanuc, Haas and most others read. Two tables below
//! list the marks with their scores: marks of the code, and the few in comments.
//!
//! Sources: the programming manuals of SINUMERIK 840D sl (2013), TNC 640 (Klartext and DIN/ISO),
//! Fanuc 30i, OSP-P300M, LinuxCNC 2.9, grbl 1.1 and Mach3.

use crate::simulation::gcode::diameters::diameter_word;
use crate::simulation::gcode::line::lines;

/// A family of controls that read the same words.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Dialect {
    /// ISO 6983 as on Fanuc, Haas and their relatives, with custom macro B.
    #[default]
    Iso,
    /// RS274/NGC as on LinuxCNC.
    LinuxCnc,
    /// SINUMERIK 840D.
    Siemens,
    /// Heidenhain conversational.
    Klartext,
    /// Heidenhain DIN/ISO.
    HeidenhainIso,
    /// grbl.
    Grbl,
    /// Mach3 and Mach4.
    Mach,
    /// Okuma OSP.
    Okuma,
}

impl Dialect {
    /// All dialects, each with its word in options and its name for people.
    pub const WORDS: [(&'static str, Dialect, &'static str); 8] = [
        ("iso", Dialect::Iso, "ISO, Fanuc, Haas"),
        ("linuxcnc", Dialect::LinuxCnc, "LinuxCNC (RS274/NGC)"),
        ("siemens", Dialect::Siemens, "Siemens SINUMERIK"),
        ("klartext", Dialect::Klartext, "Heidenhain Klartext"),
        ("heidenhain-iso", Dialect::HeidenhainIso, "Heidenhain DIN/ISO"),
        ("grbl", Dialect::Grbl, "grbl"),
        ("mach", Dialect::Mach, "Mach3, Mach4"),
        ("okuma", Dialect::Okuma, "Okuma OSP"),
    ];

    /// Returns its word in options.
    pub fn word(self) -> &'static str {
        Dialect::WORDS.iter().find(|(_, dialect, _)| *dialect == self).expect("every dialect has a word").0
    }

    /// Returns its name for people.
    pub fn name(self) -> &'static str {
        Dialect::WORDS.iter().find(|(_, dialect, _)| *dialect == self).expect("every dialect has a name").2
    }

    /// Returns `true` if I, J and K of arcs depend on a setting of the control unless the program states it.
    pub fn has_unknown_arc_centers(self) -> bool {
        matches!(self, Dialect::Iso | Dialect::Mach)
    }

    /// Returns `true` if each move states whether it is in rapid or in feed, so that no motion word is modal.
    pub fn names_each_motion(self) -> bool {
        self == Dialect::Klartext
    }

    /// Returns the dialect with this word in options.
    pub fn from_word(word: &str) -> Option<Dialect> {
        Dialect::WORDS.iter().find(|(own, ..)| own.eq_ignore_ascii_case(word)).map(|(_, dialect, _)| *dialect)
    }
}

/// The reference point of I, J and K of arcs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArcCenters {
    /// The start of the arc, G91.1.
    Incremental,
    /// The origin, G90.1.
    Absolute,
}

impl ArcCenters {
    /// Both, each with its word in options and its meaning.
    pub const WORDS: [(&'static str, ArcCenters, &'static str); 2] = [
        ("incremental", ArcCenters::Incremental, "from the start of the arc"),
        ("absolute", ArcCenters::Absolute, "from the origin"),
    ];

    /// Returns its word in options.
    pub fn word(self) -> &'static str {
        ArcCenters::WORDS.iter().find(|(_, own, _)| *own == self).expect("both have a word").0
    }

    /// Returns the reference point with this word in options.
    pub fn from_word(word: &str) -> Option<ArcCenters> {
        ArcCenters::WORDS.iter().find(|(own, ..)| own.eq_ignore_ascii_case(word)).map(|(_, own, _)| *own)
    }
}

/// Returns the dialect of `text`.
pub(super) fn detect(text: &[u8]) -> Dialect {
    let mut scores = [0_usize; Dialect::WORDS.len()];
    let (mut whole, mut code) = (Vec::new(), Vec::new());
    let (mut has_unit, mut has_parenthesis) = (false, false);
    for line in lines(text).take(SEARCHED_LINES) {
        plain(line, &mut whole);
        if is_bare_move(&whole) {
            continue;
        }
        without_comments(&whole, &mut code);
        has_unit |= has_unit_of_siemens(&code);
        has_parenthesis |= whole.starts_with(b"(");
        for (marks, text) in [(CODE_MARKS.as_slice(), &code), (COMMENT_MARKS.as_slice(), &whole)] {
            for mark in marks.iter().filter(|mark| (mark.is_in)(text)) {
                scores[mark.dialect as usize] += mark.score;
            }
        }
    }
    // Controls that take comments in parentheses may have these words too.
    if has_unit && !has_parenthesis {
        scores[Dialect::Siemens as usize] += 2;
    }
    let best = Dialect::WORDS
        .iter()
        .max_by_key(|(_, dialect, _)| (scores[*dialect as usize], *dialect == Dialect::Iso));
    best.map_or(Dialect::Iso, |(_, dialect, _)| *dialect)
}

/// Number of lines that are searched: enough to pass any header.
const SEARCHED_LINES: usize = 3_000;

/// Longest part of a line that is searched, bytes.
const MAX_WIDTH_BYTES: usize = 200;

/// Writes `line` in upper case to `into`, without its block number and with single blanks.
fn plain(line: &[u8], into: &mut Vec<u8>) {
    into.clear();
    for byte in line.iter().take(MAX_WIDTH_BYTES).map(u8::to_ascii_uppercase) {
        let byte = if byte <= b' ' { b' ' } else { byte };
        if byte != b' ' || into.last().is_some_and(|last| *last != b' ') {
            into.push(byte);
        }
    }
    let start = match into.first() {
        Some(b'N') if into.get(1).is_some_and(u8::is_ascii_digit) => 1,
        Some(byte) if byte.is_ascii_digit() => 0,
        _ => return,
    };
    let digits = into[start..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    // A number alone at the head of a line is the block number of Klartext.
    let end = start + digits;
    let end = end + into[end..].iter().take_while(|byte| **byte == b' ').count();
    into.drain(..end);
}

/// Writes `whole` to `into` without the text in parentheses and behind a semicolon; the parentheses remain.
pub(super) fn without_comments(whole: &[u8], into: &mut Vec<u8>) {
    into.clear();
    let mut depth = 0_usize;
    for byte in whole.iter().take_while(|byte| **byte != b';') {
        depth -= usize::from(*byte == b')' && 0 < depth);
        if depth == 0 {
            into.push(*byte);
        }
        depth += usize::from(*byte == b'(');
    }
    into.truncate(into.trim_ascii_end().len());
}

/// A sign of a dialect in a line.
struct DialectMark {
    dialect: Dialect,
    score: usize,
    is_in: fn(&[u8]) -> bool,
}

/// Returns a row of a table of marks.
const fn mark(dialect: Dialect, score: usize, is_in: fn(&[u8]) -> bool) -> DialectMark {
    DialectMark { dialect, score, is_in }
}

/// The marks of the code of a line.
const CODE_MARKS: [DialectMark; 12] = [
    mark(Dialect::Klartext, 100, |code| code.starts_with(b"BEGIN PGM ")),
    mark(Dialect::Klartext, 2, |code| begins_with_any(code, KLARTEXT)),
    mark(Dialect::Siemens, 50, |code| code.starts_with(b"%_N_")),
    mark(Dialect::Siemens, 2, is_siemens),
    mark(Dialect::LinuxCnc, 3, is_linuxcnc),
    mark(Dialect::HeidenhainIso, 100, |code| {
        code.starts_with(b"%") && (contains(code, b" G71 *") || contains(code, b" G70 *"))
    }),
    mark(Dialect::HeidenhainIso, 2, |code| {
        code.ends_with(b"*") && (code.starts_with(b"G") || code.starts_with(b"X"))
    }),
    mark(Dialect::Okuma, 50, |code| code.starts_with(b"$") && contains(code, b".MIN%")),
    mark(Dialect::Okuma, 3, is_okuma),
    mark(Dialect::Iso, 3, |code| {
        code.starts_with(b"IF[") || code.starts_with(b"IF [") || code.starts_with(b"WHILE[")
    }),
    mark(Dialect::Grbl, 5, is_grbl),
    mark(Dialect::Mach, 3, |code| code.ends_with(b"M47")),
];

/// The marks of a line with its comments: names of controls, and comments that a control acts on.
const COMMENT_MARKS: [DialectMark; 4] = [
    mark(Dialect::Siemens, 50, |line| line.starts_with(b";$PATH=")),
    mark(Dialect::LinuxCnc, 3, |line| contains(line, b"(DEBUG,") || contains(line, b"(PRINT,")),
    mark(Dialect::Grbl, 5, |line| contains(line, b"GRBL")),
    mark(Dialect::Mach, 5, |line| contains(line, b"MACH3") || contains(line, b"MACH4")),
];

const KLARTEXT: &[&[u8]] = &[
    b"L X",
    b"L Y",
    b"L Z",
    b"L IX",
    b"L IY",
    b"L IZ",
    b"CC X",
    b"CC Y",
    b"CC IX",
    b"C X",
    b"C IX",
    b"CR X",
    b"CT X",
    b"LP PR",
    b"CP IPA",
    b"CP PA",
    b"TOOL CALL",
    b"TOOL DEF",
    b"CYCL DEF",
    b"CYCL CALL",
    b"CALL LBL",
    b"LBL ",
    b"BLK FORM",
    b"FN 0:",
    b"FN0:",
    b"APPR ",
    b"DEP ",
    b"END PGM",
];

const OKUMA: &[&[u8]] = &[b"CALL O", b"NOEX", b"NCYL", b"DEF WORK", b"MODIN", b"MODOUT", b"VZOF", b"VTOF"];

const SIEMENS: &[&[u8]] = &[
    b"DEF REAL",
    b"DEF INT",
    b"DEF BOOL",
    b"MCALL",
    b"CYCLE",
    b"MSG(",
    b"MSG (",
    b"TRANS ",
    b"ATRANS",
    b"AROT",
    b"ROT ",
    b"SUPA",
    b"GOTOF",
    b"GOTOB",
    b"TRAORI",
    b"TRAFOOF",
    b"STOPRE",
    b"FFWON",
    b"PROC ",
    b"EXTERN",
    b"WORKPIECE(",
    b"POCKET",
    b"HOLES1",
    b"HOLES2",
    b"ENDIF",
    b"ENDFOR",
    b"ENDWHILE",
    b"SOFT",
    b"COMPCAD",
    b"COMPOF",
    b"G500",
    b"WHILE R",
    b"FOR R",
    b"IF R",
    b"IF $",
    b"UNTIL ",
];

/// Returns `true` if a line has only the end of a move and a feedrate, which mark no dialect. Nearly all lines do.
fn is_bare_move(line: &[u8]) -> bool {
    let words = line.strip_prefix(b"G0").or(line.strip_prefix(b"G1")).unwrap_or(line);
    words.iter().all(|byte| matches!(byte, b'X'..=b'Z' | b'F' | b'0'..=b'9' | b'.' | b'-' | b'+' | b' '))
}

fn is_okuma(code: &[u8]) -> bool {
    let by_h = [&b"G15 H"[..], b"G15H", b"G16 H", b"G16H", b"G56 H", b"G56H", b"[VC"];
    begins_with_any(code, OKUMA)
        || is_numbered(code, b"VC", b"=")
        || (!contains(code, b"G43") && by_h.iter().any(|mark| contains(code, mark)))
        || (code.ends_with(b"M53") && contains(code, b"G8"))
        || code == b"RTS"
}

/// Returns `true` for a line to the control itself: `$H`, `$110=500`, `$J=G91 X10`, or a real-time character
/// alone.
fn is_grbl(code: &[u8]) -> bool {
    let Some(command) = code.strip_prefix(b"$") else { return matches!(code, b"!" | b"~" | b"?") };
    let digits = |text: &[u8]| text.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let is_setting = |text: &[u8]| text.get(digits(text)) == Some(&b'=');
    match command {
        [] | [b'$' | b'#' | b'G' | b'I' | b'C' | b'X' | b'N' | b'H'] | b"SLP" => true,
        [b'H', axis] => b"XYZABC".contains(axis),
        [b'J', b'=', ..] | [b'R', b'S', b'T', b'=', ..] => true,
        [b'N', rest @ ..] => is_setting(rest),
        rest => 0 < digits(rest) && is_setting(rest),
    }
}

fn is_siemens(code: &[u8]) -> bool {
    begins_with_any(code, SIEMENS)
        || is_numbered(code, b"R", b"=")
        || [
            &b" CR="[..],
            b"=AC(",
            b"=IC(",
            b" SUPA",
            b" SPOS=",
            b" AP=",
            b" RP=",
            b" ANG=",
            b" CHR=",
            b" FB=",
            b"G331",
            b"G642",
            b" TURN=",
            b" RND=",
            b" CHF=",
            b"$P_",
            b"$A",
        ]
        .iter()
        .any(|mark| contains(code, mark))
        || code.starts_with(b"T=\"")
        || contains(code, b"DIAMOF")
        || diameter_word(code).is_some()
}

/// Returns `true` if G70, G71, G700 or G710 sets the unit, as in a block of settings alone. With axis words or
/// parameters such a word is a cycle of other controls.
fn has_unit_of_siemens(code: &[u8]) -> bool {
    let is_setting = |byte: &u8| b"GNMTSDF. ".contains(byte) || byte.is_ascii_digit();
    let words = || code.split(|byte| *byte == b'G').skip(1);
    let is_unit = |word: &[u8]| {
        let digits = word.iter().take_while(|byte| byte.is_ascii_digit()).count();
        matches!(&word[..digits], b"70" | b"71" | b"700" | b"710")
    };
    code.iter().all(is_setting) && words().any(is_unit)
}

fn is_linuxcnc(code: &[u8]) -> bool {
    let is_o_word = || {
        let rest = code.strip_prefix(b"O").unwrap_or_default();
        let name = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let rest = rest[name..].trim_ascii_start();
        0 < name
            && begins_with_any(
                rest,
                &[b"SUB", b"CALL", b"IF", b"WHILE", b"DO", b"REPEAT", b"ENDSUB", b"ENDIF"],
            )
    };
    // Alone on its line, `O<BRACKET>` is the name of a program on Fanuc controls.
    let is_name_alone = || {
        let end = code.iter().position(|byte| *byte == b'(').unwrap_or(code.len());
        code[..end].trim_ascii_end().ends_with(b">")
    };
    (code.starts_with(b"O<") && !is_name_alone())
        || is_o_word()
        || contains(code, b"#<")
        || code.iter().any(|byte| matches!(byte, b'@' | b'^'))
        || (contains(code, b"G64 P") || contains(code, b"G64P"))
}

fn begins_with_any(code: &[u8], marks: &[&[u8]]) -> bool {
    let Some(first) = code.first() else { return false };
    marks.iter().any(|mark| *first == mark[0] && code.starts_with(mark))
}

/// Returns `true` if `code` begins with `name`, digits and `then`.
fn is_numbered(code: &[u8], name: &[u8], then: &[u8]) -> bool {
    let Some(rest) = code.strip_prefix(name) else { return false };
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    0 < digits && rest[digits..].trim_ascii_start().starts_with(then)
}

fn contains(code: &[u8], mark: &[u8]) -> bool {
    // Most lines do not have its first byte, whose search is much faster than that of the whole mark.
    let mut rest = code;
    while let Some(at) = rest.iter().position(|byte| *byte == mark[0]) {
        if rest[at..].starts_with(mark) {
            return true;
        }
        rest = &rest[at + 1..];
    }
    false
}

#[cfg(test)]
#[path = "dialect_tests.rs"]
mod tests;
