//! Comments of a program → its tools: number, name, diameter and teeth, as CAM systems and people write them.
//!
//! ```text
//! (T24 2" FACE MILL|H0|XY STOCK TO LEAVE - -2.4)      T24, 50.8 mm
//! (T1 D=10. CR=0. - ZMIN=-5. - FLAT END MILL)         T1, 10 mm
//! N50 T2 M6 (1/2 FLAT ENDMILL, 4 FLUTE)               T2, 12.7 mm, 4 teeth
//! TOOL CALL 3 Z S5000 ; BOHRER D8.5                    T3, 8.5 mm
//! ```
//!
//! A length with an inch mark, or a fraction, is in inches; any other length is in the unit of the program.

use serde::Serialize;

use crate::simulation::ordered::sort_by_number;
use crate::units::MM_PER_INCH;

/// A tool that a program describes.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct DescribedTool {
    tool: u32,
    name: String,
    diameter_mm: Option<f64>,
    teeth: Option<u32>,
}

/// Most tools of a program, more than a magazine has.
const MAX_TOOLS: usize = 400;
/// Bounds of the diameter of a tool; a number outside them is not a diameter.
const DIAMETER_BOUNDS_MM: (f64, f64) = (0.05, 500.0);
/// Most teeth of a tool.
const MAX_TEETH: u32 = 40;
/// Largest diameter that counts as inches; a larger one is in millimetres.
const MAX_INCHES: f64 = 5.0;

/// Returns the tools that the head of a program describes, by number, as JSON text. If a tool has several
/// descriptions, the first with a diameter counts, or else the first.
pub fn described_tools_json(head: &[u8]) -> String {
    serde_json::to_string(&described_tools(&String::from_utf8_lossy(head)))
        .expect("text and finite numbers have a JSON form")
}

fn described_tools(text: &str) -> Vec<DescribedTool> {
    let upper = text.to_uppercase();
    let is_inch = ["G20", "G70"].iter().any(|word| has_word(&upper, word));
    let mut tools: Vec<DescribedTool> = Vec::new();
    for line in upper.lines() {
        let (code, comment) = parted(line);
        let called = number_after(&code, &["T", "TOOL CALL"]);
        for description in descriptions(&comment) {
            let name = name_of(description);
            let Some(tool) =
                number_after(description, &["T", "TOOL"]).or(called).filter(|_| !name.is_empty())
            else {
                continue;
            };
            let own =
                DescribedTool { tool, diameter_mm: diameter(&name, is_inch), teeth: teeth(&name), name };
            match tools.iter().position(|known| known.tool == tool) {
                Some(at) if tools[at].diameter_mm.is_none() && own.diameter_mm.is_some() => tools[at] = own,
                None if tools.len() < MAX_TOOLS => tools.push(own),
                _ => {}
            }
        }
    }
    sort_by_number(&mut tools, |own| f64::from(own.tool));
    tools
}

/// Returns `true` if a text contains a word, as N10G20G90 contains G20; G200 is a different word.
fn has_word(text: &str, word: &str) -> bool {
    text.match_indices(word).any(|(at, _)| {
        let is_first = text[..at].chars().next_back().is_none_or(|before| !before.is_ascii_alphabetic());
        is_first && !text[at + word.len()..].starts_with(|c: char| c.is_ascii_digit() || c == '.')
    })
}

/// Returns the parts of a comment, each of which describes one tool: (T1 END MILL D10, T2 BALL MILL D6) has
/// two.
fn descriptions(comment: &str) -> Vec<&str> {
    let starts = comment.match_indices('T').map(|(at, _)| at).filter(|&at| {
        let is_first = comment[..at].trim_end().is_empty() || comment[..at].ends_with([' ', ',', ';']);
        is_first && comment[at + 1..].starts_with(|c: char| c.is_ascii_digit())
    });
    let mut ends: Vec<usize> = starts.skip_while(|at| *at == 0).collect();
    ends.insert(0, 0);
    ends.push(comment.len());
    ends.windows(2).map(|ends| comment[ends[0]..ends[1]].trim()).filter(|part| !part.is_empty()).collect()
}

/// Returns the code of a line, and its comments.
fn parted(line: &str) -> (String, String) {
    let (mut code, mut comment) = (String::new(), String::new());
    let mut depth = 0;
    for (index, letter) in line.char_indices() {
        match letter {
            ';' if depth == 0 => {
                comment.push_str(&line[index + 1..]);
                break;
            }
            '(' => depth += 1,
            ')' => {
                depth -= 1;
                comment.push(' ');
            }
            _ if depth > 0 => comment.push(letter),
            _ => code.push(letter),
        }
    }
    (code.trim().to_string(), comment.trim().to_string())
}

/// Returns the whole number after one of these words, which begins the text or follows a blank or a number.
fn number_after(text: &str, words: &[&str]) -> Option<u32> {
    words.iter().find_map(|word| {
        text.match_indices(word).find_map(|(at, _)| {
            let is_word = text[..at].chars().next_back().is_none_or(|before| !before.is_ascii_alphabetic());
            let rest = text[at + word.len()..].trim_start_matches([' ', '=', '#', ':']);
            let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
            digits.parse().ok().filter(|_| is_word)
        })
    })
}

/// Returns the name of the tool in a comment, without its number and without the text after a bar.
fn name_of(comment: &str) -> String {
    let comment = comment.trim();
    let numbered = comment.strip_prefix("TOOL").or_else(|| comment.strip_prefix('T'));
    let number = numbered.map(|rest| rest.trim_start_matches([' ', '=', '#', ':']));
    let rest = number.filter(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
    let name = rest.map_or(comment, |rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()));
    let marks = [' ', '-', ':', ',', '=', '|'];
    name.trim_matches(marks).split('|').next().unwrap_or_default().trim_matches(marks).to_string()
}

/// Returns the diameter in a name, mm: after a D or Ø, or the first length that reads as one.
fn diameter(name: &str, is_inch: bool) -> Option<f64> {
    let tokens: Vec<&str> = name.split([' ', ',', '(', ')']).filter(|token| !token.is_empty()).collect();
    let marked = |token: &&str| {
        ["DIA.", "DIA", "D=", "D", "Ø", "⌀"]
            .iter()
            .find_map(|mark| token.strip_prefix(mark))
            .map(|rest| rest.trim_start_matches('=').to_string())
    };
    let behind_mark = tokens.iter().enumerate().find_map(|(at, token)| {
        let rest = marked(token)?;
        length(if rest.is_empty() { tokens.get(at + 1)? } else { &rest }, is_inch)
    });
    let is_meant = |token: &&&str| {
        token.contains(['"', '/'])
            || token.ends_with("MM")
            || token.starts_with('.')
            || (token.contains('.') && token.starts_with(|c: char| c.is_ascii_digit()))
    };
    let plain = || tokens.iter().filter(is_meant).find_map(|token| length(token, is_inch));
    behind_mark.or_else(plain).filter(|own| DIAMETER_BOUNDS_MM.0 <= *own && *own <= DIAMETER_BOUNDS_MM.1)
}

/// Returns a length, mm: 10, 10MM, .250, 1/2, 3", 1-1/2".
fn length(token: &str, is_inch: bool) -> Option<f64> {
    let token = token.trim_end_matches(['.', ';', ':']);
    let (number, unit) = match token {
        _ if token.ends_with("MM") => (token.trim_end_matches("MM"), 1.0),
        _ if token.ends_with(['"', '\'']) || token.contains('/') => {
            (token.trim_end_matches(['"', '\'']), MM_PER_INCH)
        }
        // A diameter too large for inches is in millimetres.
        _ if token.parse::<f64>().is_ok_and(|own| MAX_INCHES < own) => (token, 1.0),
        _ => (token, if is_inch { MM_PER_INCH } else { 1.0 }),
    };
    let (whole, fraction) = number.split_once('-').unwrap_or(("0", number));
    let value = match fraction.split_once('/') {
        Some((above, below)) => {
            whole.parse::<f64>().ok()? + above.parse::<f64>().ok()? / below.parse::<f64>().ok()?
        }
        None if number.contains('-') => return None,
        None => number.parse().ok()?,
    };
    (value.is_finite() && 0.0 < value).then_some(value * unit)
}

/// Returns the number of teeth in a name: 4 FLUTE, 4FL, Z=4.
fn teeth(name: &str) -> Option<u32> {
    let tokens: Vec<&str> = name.split([' ', ',', '-']).filter(|token| !token.is_empty()).collect();
    let before = |token: &str| {
        ["FLUTES", "FLUTE", "FLT", "FL", "TEETH"]
            .iter()
            .find_map(|word| token.strip_suffix(word))
            .map(str::to_string)
    };
    tokens
        .iter()
        .enumerate()
        .find_map(|(at, token)| {
            let written = match before(token) {
                Some(own) if own.is_empty() => tokens.get(at.checked_sub(1)?)?.to_string(),
                Some(own) => own,
                None => token.strip_prefix("Z=").or_else(|| token.strip_prefix('Z'))?.to_string(),
            };
            written.parse().ok()
        })
        .filter(|own| (1..=MAX_TEETH).contains(own))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tools_are_read_as_cam_systems_write_them() {
        type Case = (&'static str, u32, &'static str, Option<f64>, Option<u32>);
        let cases: [Case; 13] = [
            ("(T1| 3/4 FLAT ENDMILL|H0|XY STOCK TO LEAVE - .005)", 1, "3/4 FLAT ENDMILL", Some(19.05), None),
            ("T1M6(D26)", 1, "D26", Some(26.0), None),
            ("( TOOL: T1 = 10.0 DIA. ENDMILLM1000:REG )", 1, "10.0 DIA. ENDMILLM1000:REG", Some(10.0), None),
            ("( T0 : 3.175 )", 0, "3.175", Some(3.175), None),
            ("(T24 2\" FACE MILL|H0|XY STOCK TO LEAVE - -2.4)", 24, "2\" FACE MILL", Some(50.8), None),
            (
                "(T1 D=10. CR=0. - ZMIN=-5. - FLAT END MILL)",
                1,
                "D=10. CR=0. - ZMIN=-5. - FLAT END MILL",
                Some(10.0),
                None,
            ),
            ("N50 T2 M6 (1/2 FLAT ENDMILL, 4 FLUTE)", 2, "1/2 FLAT ENDMILL, 4 FLUTE", Some(12.7), Some(4)),
            ("TOOL CALL 3 Z S5000 ; BOHRER D8.5", 3, "BOHRER D8.5", Some(8.5), None),
            (
                "T7 M06 ( 1/4\" DIA. X .032\" RADIUS 2 FLUTE STUBBY BULLNOSE E.M )",
                7,
                "1/4\" DIA. X .032\" RADIUS 2 FLUTE STUBBY BULLNOSE E.M",
                Some(6.35),
                Some(2),
            ),
            ("(TOOL 5: 12MM ENDMILL Z4)", 5, "12MM ENDMILL Z4", Some(12.0), Some(4)),
            ("T12 M6 (EDGE FINDER)", 12, "EDGE FINDER", None, None),
            ("T3 M6 (1-1/2\" SHELL MILL 6FL)", 3, "1-1/2\" SHELL MILL 6FL", Some(38.1), Some(6)),
            ("T4 M6 (DRILL Ø 5)", 4, "DRILL Ø 5", Some(5.0), None),
        ];
        for (line, tool, name, diameter, teeth) in cases {
            let found = described_tools(&format!("G21\n{line}\nG0 X0 (APPROACH)\n"));
            assert_eq!(found.len(), 1, "{line}: {found:?}");
            let own = &found[0];
            let is_near = own
                .diameter_mm
                .zip(diameter)
                .map_or(own.diameter_mm == diameter, |(a, b)| (a - b).abs() < 1e-9);
            assert!(own.tool == tool && own.name == name && is_near && own.teeth == teeth, "{line}: {own:?}");
        }
    }

    #[test]
    fn lengths_are_in_the_unit_of_the_program_and_the_first_with_a_diameter_counts() {
        let text = "G20 G90\n(T1 FACE MILL)\nT1 M6 (D=.5 FACE MILL)\nT1 M6 (D=2 OTHER)\n";
        let [tool] = &described_tools(text)[..] else { panic!("one tool") };
        assert_eq!((tool.diameter_mm, tool.name.as_str()), (Some(12.7), "D=.5 FACE MILL"));
        let both = described_tools("(T1 END MILL D10, T2 BALL MILL D6)\n");
        let both: Vec<_> = both.iter().map(|own| (own.tool, own.name.as_str(), own.diameter_mm)).collect();
        assert_eq!(both, [(1, "END MILL D10", Some(10.0)), (2, "BALL MILL D6", Some(6.0))]);
        let [tool, other] = &described_tools("(T5|   6. FLAT ENDMILL|H0)\nN100G20\nT6M6(D=.5)\n")[..] else {
            panic!("two tools")
        };
        assert_eq!((tool.diameter_mm, other.diameter_mm), (Some(6.0), Some(12.7)));
        assert!(described_tools("G21\nG1 X10 (TO THE LEFT)\n(TOTAL 3 PARTS)\n").is_empty());
    }
}
