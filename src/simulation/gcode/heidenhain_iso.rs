//! Lines of Heidenhain DIN/ISO programs, each put into the statements of Klartext that say the same.
//!
//! ```text
//! %NAME G71 *                BEGIN PGM NAME MM          G98 L1         LBL 1
//! G00 X Y, G01 X Y F         L X Y FMAX, L X Y F        L1,3           CALL LBL 1 REP 3
//! G02, G03, G05 X Y          C X Y DR-, DR+             L1, L1,0       CALL LBL 1
//! … with R                   CR X Y R DR±               G200 Q200=2 …  CYCL DEF 200 Q200=2 …
//! I, J                       CC X Y                     G79            CYCL CALL
//! G06 X Y, G16 R H           CT X Y, CTP PR PA          G38            STOP
//! G10, G11 R H               LP PR PA FMAX, LP PR PA    G04 F1         CYCL DEF 9.1 1
//! G12, G13, G15 H            CP PA DR-, DR+             G62 T0.02      CYCL DEF 32.1 T0.02
//! G24 R, G25 R               CHF R, RND R               G54 X, G28 X   CYCL DEF 7.1 X, 8.1 X
//! G40, G41, G42              R0, RL, RR                 G73 H, G72 F   CYCL DEF 10.1 H, 11.1 F
//! T1 G17 S3000               TOOL CALL 1 Z S3000        D00 Q1 P01 5   FN 0: Q1 = 5
//! D09 P01 Q1 P02 0 P03 7     FN 9: IF Q1 EQU 0 GOTO LBL 7
//! ```
//!
//! What is wrong in a line is said of the whole line. Not read, and said: G26 and G27 (tangential
//! approach), G83 to G86 with P01 and on, touch probes.
//!
//! Source: TNC 640, DIN/ISO Programming, 2018.

use crate::simulation::gcode::line::{Line, excerpt, semicolon};
use crate::simulation::gcode::number::{is_blank, number, skip_blanks};
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use std::fmt::Write;

/// Words that stay in force from line to line.
#[derive(Default)]
pub(super) struct Modal {
    /// The G word of the motion.
    motion: u32,
    is_incremental: bool,
}

/// The G words that are read, apart from cycles from 200 on; G17 to G20, G40, G50 and G51 without more.
const KNOWN: &[u32] = &[
    0, 1, 2, 3, 4, 5, 6, 10, 11, 12, 13, 15, 16, 17, 18, 19, 20, 24, 25, 26, 27, 28, 30, 31, 38, 40, 41, 42,
    50, 51, 54, 62, 70, 71, 72, 73, 79, 90, 91, 98, 99,
];

/// The columns of a whole line.
const WHOLE_LINE: (u32, u32) = (1, 1);

impl Reader<'_> {
    /// Reads one line of a Heidenhain DIN/ISO program.
    pub(super) fn heidenhain_iso_line(&mut self, text: &[u8], line: &mut Line) -> Result<(), Refusal> {
        let end = semicolon(text, 0);
        if end + 1 < text.len() {
            line.comment = Some((end + 1, text.len()));
        }
        let code = text[..end].trim_ascii();
        let code = code.strip_suffix(b"*").unwrap_or(code).trim_ascii_end();
        if code.is_empty() {
            return Ok(());
        }
        let mut modal = std::mem::take(&mut self.heidenhain.din);
        let statements = statements(code, &mut modal);
        self.heidenhain.din = modal;
        let statements = statements.map_err(|text| (Unread::Text { text }, WHOLE_LINE))?;
        for statement in statements {
            let (words, formulas) = (self.program.words.len(), self.program.formulas.len());
            let mut own = Line::default();
            let outcome = self.klartext_statement(statement.as_bytes(), 0, &mut own);
            // The columns of a statement are not those of its line.
            for word in self.program.words.iter_mut().skip(words) {
                word.columns = WHOLE_LINE.into();
            }
            for formula in self.program.formulas.iter_mut().skip(formulas) {
                formula.columns = WHOLE_LINE;
            }
            outcome.map_err(|(remark, _)| (remark, WHOLE_LINE))?;
            self.end_block();
        }
        Ok(())
    }
}

/// One word: its letter in upper case, and its value as written.
struct Word {
    letter: char,
    value: String,
}

impl Word {
    fn number(&self) -> Option<f64> {
        number(self.value.as_bytes(), 0).map(|found| found.value)
    }
}

/// The words of a line; what is no word is given back.
fn words(code: &[u8]) -> Result<Vec<Word>, String> {
    let mut words = Vec::new();
    let mut at = 0;
    while at < code.len() {
        let letter = code[at].to_ascii_uppercase();
        if is_blank(letter) {
            at += 1;
            continue;
        }
        if !b"ABCFGHIJKLMPQRSTUVWXYZ".contains(&letter) {
            return Err(excerpt(&code[at..]));
        }
        let start = skip_blanks(code, at + 1);
        // A value goes on to the next letter, but for Q after a sign, an `=` or at once.
        let mut end = start;
        if code.get(start) == Some(&b'"') {
            // The name of a label.
            let length = code[start + 1..].iter().position(|byte| *byte == b'"');
            end = length.map_or(code.len(), |length| start + length + 2);
        }
        while end < code.len() {
            let byte = code[end].to_ascii_uppercase();
            let is_parameter =
                byte == b'Q' && code[start..end].iter().all(|byte| matches!(byte, b'+' | b'-' | b' ' | b'='));
            let follows_equals =
                letter == b'Q' && byte == b'Q' && code[start..end].trim_ascii_end().ends_with(b"=");
            if byte.is_ascii_alphabetic() && !is_parameter && !follows_equals {
                break;
            }
            end += 1;
        }
        let value = String::from_utf8_lossy(code[start..end].trim_ascii()).into_owned();
        words.push(Word { letter: char::from(letter), value });
        at = end;
    }
    Ok(words)
}

/// The statements that a line says.
fn statements(code: &[u8], modal: &mut Modal) -> Result<Vec<String>, String> {
    let after_number = match code[0].to_ascii_uppercase() {
        b'N' => number(code, 1).map_or(1, |found| found.end),
        _ => 0,
    };
    let code = code.get(after_number..).unwrap_or_default().trim_ascii();
    if code.is_empty() {
        return Ok(Vec::new());
    }
    if let Some(header) = code.strip_prefix(b"%") {
        return Ok(program_border(header, after_number == 0));
    }
    if let Some(cycle) = cycle_with_parameters(code) {
        return Ok(vec![cycle]);
    }
    if code.first().is_some_and(|byte| byte.eq_ignore_ascii_case(&b'D')) {
        return function(code);
    }
    if let Some(label) = code.strip_prefix(b"L").or(code.strip_prefix(b"l")) {
        return Ok(vec![call(label)]);
    }
    let words = words(code)?;
    let codes: Vec<f64> = words.iter().filter(|word| word.letter == 'G').filter_map(Word::number).collect();
    let is_known = |code: &f64| KNOWN.iter().any(|known| f64::from(*known) == *code);
    if let Some(unknown) = codes.iter().find(|code| !is_known(code)) {
        return Err(format!("G{unknown}"));
    }
    let codes: Vec<u32> = codes.into_iter().map(|code| code as u32).collect();
    let given =
        |letter: char| words.iter().rfind(|word| word.letter == letter).map(|word| word.value.as_str());
    let has = |code: u32| codes.contains(&code);
    for code in &codes {
        match code {
            0..=3 | 5 | 6 | 10..=13 | 15 | 16 => modal.motion = *code,
            90 | 91 => modal.is_incremental = *code == 91,
            _ => {}
        }
    }
    let axes = |letters: &str, incremental: bool| {
        let mut text = String::new();
        for letter in letters.chars() {
            if let Some(value) = given(letter) {
                let sign = if incremental { "I" } else { "" };
                write!(text, " {sign}{letter}{value}").expect("text grows");
            }
        }
        text
    };
    let mut statements = Vec::new();
    if has(98) {
        return Ok(vec![format!("LBL {}", given('L').unwrap_or_default())]);
    }
    if has(99) {
        let (length, radius) = (given('L').unwrap_or("+0"), given('R').unwrap_or("+0"));
        return Ok(vec![format!("TOOL DEF {} L{length} R{radius}", given('T').unwrap_or("0"))]);
    }
    for (code, cycle, letter) in [(4, 9, 'F'), (62, 32, 'T'), (73, 10, 'H'), (72, 11, 'F')] {
        if has(code) {
            let value = given(letter).unwrap_or_default();
            let step = if value.is_empty() { 0 } else { 1 };
            return Ok(vec![
                format!("CYCL DEF {cycle}.0"),
                format!("CYCL DEF {cycle}.{step} {letter}{value}"),
            ]);
        }
    }
    if has(54) {
        return Ok(vec![format!("CYCL DEF 7.1{}", axes("XYZABC", modal.is_incremental))]);
    }
    if has(28) {
        let named: String = words
            .iter()
            .filter(|word| "XYZ".contains(word.letter))
            .map(|word| format!(" {}", word.letter))
            .collect();
        return Ok(vec![format!("CYCL DEF 8.1{named}")]);
    }
    if has(79) {
        return Ok(vec!["CYCL CALL".to_string()]);
    }
    if has(30) || has(31) {
        return Ok(statements);
    }
    if has(38) {
        statements.push("STOP".to_string());
    }
    if has(26) || has(27) {
        return Err(excerpt(code));
    }
    if let Some(tool) = given('T').filter(|_| !has(51)) {
        let axis = if has(18) {
            "Y"
        } else if has(19) {
            "X"
        } else {
            "Z"
        };
        let speed = given('S').map_or(String::new(), |speed| format!(" S{speed}"));
        let feed = given('F').map_or(String::new(), |feed| format!(" F{feed}"));
        statements.push(format!("TOOL CALL {tool} {axis}{speed}{feed}"));
    }
    if given('I').is_some() || given('J').is_some() || given('K').is_some() {
        let sign = if modal.is_incremental { "I" } else { "" };
        let pole = [('I', 'X'), ('J', 'Y'), ('K', 'Z')]
            .iter()
            .filter_map(|(letter, axis)| Some(format!(" {sign}{axis}{}", given(*letter)?)));
        statements.push(format!("CC{}", pole.collect::<String>()));
    }
    let feed = given('F').filter(|_| given('T').is_none()).map_or(String::new(), |feed| format!(" F{feed}"));
    let side = if has(41) {
        " RL"
    } else if has(42) {
        " RR"
    } else if has(40) {
        " R0"
    } else {
        ""
    };
    let functions: String =
        words.iter().filter(|word| word.letter == 'M').map(|word| format!(" M{}", word.value)).collect();
    if let Some(code) = [24, 25].into_iter().find(|code| has(*code)) {
        let (name, radius) = if code == 24 {
            ("CHF ", given('R').unwrap_or_default())
        } else {
            ("RND R", given('R').unwrap_or_default())
        };
        statements.push(format!("{name}{radius}{feed}"));
        return Ok(statements);
    }
    let path = axes("XYZABC", modal.is_incremental);
    let sign = if modal.is_incremental { "I" } else { "" };
    let polar = || {
        let radius = given('R').map_or(String::new(), |radius| format!(" PR{radius}"));
        let angle = given('H').map_or(String::new(), |angle| format!(" {sign}PA{angle}"));
        radius + &angle
    };
    let has_polar = matches!(modal.motion, 10..=16) && (given('R').is_some() || given('H').is_some());
    if path.is_empty() && !has_polar {
        if !(functions.is_empty() && feed.is_empty() && side.is_empty()) {
            statements.push(format!("L{side}{feed}{functions}"));
        }
        return Ok(statements);
    }
    let sense = match modal.motion {
        2 | 12 => " DR-",
        3 | 13 => " DR+",
        _ => "",
    };
    statements.push(match modal.motion {
        0 => format!("L{path}{side} FMAX{functions}"),
        2 | 3 | 5 => match given('R') {
            Some(radius) => format!("CR{path} R{radius}{sense}{side}{feed}{functions}"),
            None => format!("C{path}{sense}{side}{feed}{functions}"),
        },
        6 => format!("CT{path}{side}{feed}{functions}"),
        10 => format!("LP{}{path}{side} FMAX{functions}", polar()),
        11 => format!("LP{}{path}{side}{feed}{functions}", polar()),
        12 | 13 | 15 => format!("CP{}{path}{sense}{side}{feed}{functions}", polar()),
        16 => format!("CTP{}{path}{side}{feed}{functions}", polar()),
        _ => format!("L{path}{side}{feed}{functions}"),
    });
    Ok(statements)
}

/// `%NAME G71` begins a program; with a block number before it, it ends one.
fn program_border(header: &[u8], begins: bool) -> Vec<String> {
    let text = String::from_utf8_lossy(header).to_ascii_uppercase();
    let mut parts = text.split_whitespace();
    let name = parts.next().unwrap_or("A").to_string();
    let unit = if parts.any(|part| part == "G70") { "INCH" } else { "MM" };
    if begins { vec![format!("BEGIN PGM {name} {unit}")] } else { vec![format!("END PGM {name} {unit}")] }
}

/// `G200 Q200=2 …` and `Q200=2 …`.
fn cycle_with_parameters(code: &[u8]) -> Option<String> {
    if code[..1].eq_ignore_ascii_case(b"Q") {
        return Some(String::from_utf8_lossy(code).into_owned());
    }
    if !code[..1].eq_ignore_ascii_case(b"G") {
        return None;
    }
    let found = number(code, 1)?;
    let is_cycle = (200.0..=299.0).contains(&found.value) && found.value.fract() == 0.0;
    is_cycle.then(|| format!("CYCL DEF {} {}", found.value, String::from_utf8_lossy(&code[found.end..])))
}

/// `L1`, `L1,0`, `L1,3`, the L taken away.
fn call(label: &[u8]) -> String {
    let text = String::from_utf8_lossy(label).into_owned();
    match text.split_once([',', '.']) {
        Some((label, times)) if times.trim() != "0" => {
            format!("CALL LBL {} REP {}", label.trim(), times.trim())
        }
        Some((label, _)) => format!("CALL LBL {}", label.trim()),
        None => format!("CALL LBL {}", text.trim()),
    }
}

/// `D00 Q1 P01 +5`, `D01 Q1 P01 +Q2 P02 +3`, `D09 P01 +Q1 P02 +0 P03 5` and on: the FN function of the same number.
fn function(code: &[u8]) -> Result<Vec<String>, String> {
    let text = String::from_utf8_lossy(code).to_ascii_uppercase();
    let mut parts = text[1..].split(" P0");
    let mut head = parts.next().unwrap_or_default().split_whitespace();
    let number = head.next().and_then(|number| number.parse::<u32>().ok()).ok_or_else(|| excerpt(code))?;
    let target = head.next();
    // First the second digit of P01, P02, P03.
    let operands: Option<Vec<&str>> = parts.map(|part| part.get(1..).map(str::trim)).collect();
    let statement = match (number, target, operands.as_deref()) {
        (0, Some(target), Some([value])) => format!("{target} = {value}"),
        (5..=7, Some(target), Some([value])) => {
            let name = ["SQRT", "SIN", "COS"][number as usize - 5];
            format!("{target} = {name} ( {value} )")
        }
        (1..=4 | 8 | 13, Some(target), Some([left, right])) => {
            let operator = match number {
                1 => "+",
                2 => "-",
                3 => "*",
                4 => "/",
                8 => "LEN",
                _ => "ANG",
            };
            format!("{target} = ( {left} ) {operator} ( {right} )")
        }
        (9..=12, None, Some([left, right, label])) => {
            let comparison = ["EQU", "NE", "GT", "LT"][number as usize - 9];
            format!("FN {number}: IF {left} {comparison} {right} GOTO LBL {label}")
        }
        (18, Some(target), Some([system, place @ ..])) => {
            let place: String =
                ["NR", "IDX"].iter().zip(place).map(|(name, value)| format!(" {name}{value}")).collect();
            format!("FN 18: SYSREAD {target} = ID{system}{place}")
        }
        (14..=17 | 19 | 20 | 26..=29 | 37 | 38, ..) => format!("FN {number}: {}", excerpt(code)),
        _ => return Err(excerpt(code)),
    };
    Ok(vec![statement])
}
