//! One job in the words of each dialect.

use std::f64::consts::TAU;
use std::fmt::Write;

use crate::jobs::{Move, Point};

/// A dialect as a CAM system's post-processor writes it.
pub struct Dialect {
    /// The word by which `--dialect` chooses it.
    pub name: &'static str,
    pub extension: &'static str,
    pub write: fn(&[Move]) -> String,
}

pub const ALL: [Dialect; 8] = [
    Dialect { name: "iso", extension: "nc", write: |moves| Letters::ISO.write(moves) },
    Dialect { name: "linuxcnc", extension: "ngc", write: |moves| Letters::LINUXCNC.write(moves) },
    Dialect { name: "grbl", extension: "gcode", write: |moves| Letters::GRBL.write(moves) },
    Dialect { name: "mach", extension: "tap", write: |moves| Letters::MACH.write(moves) },
    Dialect { name: "okuma", extension: "min", write: |moves| Letters::OKUMA.write(moves) },
    Dialect { name: "siemens", extension: "mpf", write: |moves| Letters::SIEMENS.write(moves) },
    Dialect { name: "klartext", extension: "h", write: klartext },
    Dialect { name: "heidenhain-iso", extension: "i", write: heidenhain_iso },
];

/// A retract to this height follows each hole, mm.
const RETRACT_MM: f64 = 5.0;
/// Drilling begins at this distance above the surface, mm.
const SAFETY_MM: f64 = 2.0;

/// A number as post-processors write it: no more digits than it needs.
fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

/// A decimal that a Fanuc reads in millimetres: with a point, always.
fn pointed(value: f64) -> String {
    let text = number(value);
    if text.contains('.') { text } else { text + "." }
}

/// The words of dialects whose moves are letters with numbers.
struct Letters {
    begin: &'static str,
    end: &'static str,
    comment: fn(&str) -> String,
    tool: fn(u32, u32) -> String,
    dwell: fn(f64) -> String,
    hole: HoleWords,
    /// Precedes a drilling cycle: the spindle returns to the height it came from.
    return_word: &'static str,
    number: fn(f64) -> String,
}

/// How holes are written.
enum HoleWords {
    /// Moves, for controls without cycles.
    Moves,
    /// G81 and G83 at each position; the R plane stands at the safety distance.
    Cycles,
    /// MCALL CYCLE81 and CYCLE83, positions after it.
    ModalCall,
}

fn parentheses(text: &str) -> String {
    format!("({text})")
}

impl Letters {
    const ISO: Letters = Letters {
        begin: "%\nO1000\nG21 G17 G90 G94 G40 G49 G80\n",
        end: "M5\nM30\n%\n",
        comment: parentheses,
        tool: |tool, rpm| format!("T{tool} M6\nS{rpm} M3\n"),
        dwell: |seconds| format!("G4 P{}\n", (1000.0 * seconds).round()),
        hole: HoleWords::Cycles,
        return_word: "G98",
        number: pointed,
    };
    const LINUXCNC: Letters = Letters {
        begin: "G21 G17 G90 G94 G40 G49 G80\nG64 P0.02\n",
        end: "M5\nM2\n",
        dwell: |seconds| format!("G4 P{}\n", number(seconds)),
        number,
        ..Letters::ISO
    };
    const GRBL: Letters = Letters {
        begin: "G21 G17 G90 G94\n",
        tool: |_, rpm| format!("S{rpm} M3\n"),
        hole: HoleWords::Moves,
        ..Letters::LINUXCNC
    };
    const MACH: Letters =
        Letters { begin: "G21 G17 G90 G94 G91.1 G40 G49 G80\nG64\n", end: "M5\nM30\n", ..Letters::LINUXCNC };
    const OKUMA: Letters = Letters {
        begin: "G15 H1\nG21 G17 G90 G94 G40 G80\nG71 Z5.\n",
        return_word: "M53",
        end: "M5\nM02\n",
        dwell: |seconds| format!("G04 F{}\n", pointed(seconds)),
        ..Letters::ISO
    };
    const SIEMENS: Letters = Letters {
        begin: "G71 G17 G90 G94 G40\nG64\n",
        end: "M5\nM30\n",
        comment: |text| format!("; {text}"),
        tool: |tool, rpm| format!("T{tool} M6\nS{rpm} M3\n"),
        dwell: |seconds| format!("G4 F{}\n", number(seconds)),
        hole: HoleWords::ModalCall,
        return_word: "",
        number,
    };

    /// Only the coordinates that change; all of them in the first move.
    fn coordinates(&self, at: &mut Option<Point>, end: &Point) -> String {
        let mut text = String::new();
        for (axis, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
            if at.is_none_or(|at| at[axis] != end[axis]) {
                text += &format!(" {letter}{}", (self.number)(end[axis]));
            }
        }
        *at = Some(*end);
        text
    }

    fn write(&self, moves: &[Move]) -> String {
        let mut text = String::from(self.begin);
        let mut at: Option<Point> = None;
        let mut cycle: Option<(f64, f64)> = None;
        let mut feed_in_force = None;
        for next in moves {
            if cycle.is_some() && !matches!(next, Move::Hole { .. }) {
                text += match self.hole {
                    HoleWords::ModalCall => "MCALL\n",
                    _ => "G80\n",
                };
                cycle = None;
            }
            let mut feed_word = |feed: f64| match feed_in_force.replace(feed) {
                Some(before) if before == feed => String::new(),
                _ => format!(" F{}", number(feed)),
            };
            match next {
                Move::Tool { number, rpm, name } => {
                    let _ = writeln!(text, "{}", (self.comment)(name));
                    text += &(self.tool)(*number, *rpm);
                }
                Move::Rapid(end) => text += &format!("G0{}\n", self.coordinates(&mut at, end)),
                Move::Line { end, feed } => {
                    let coordinates = self.coordinates(&mut at, end);
                    if !coordinates.is_empty() {
                        text += &format!("G1{coordinates}{}\n", feed_word(*feed));
                    }
                }
                Move::Arc { end, centre, clockwise, feed } => {
                    let from = at.expect("an arc begins somewhere");
                    let word = if *clockwise { "G2" } else { "G3" };
                    let mut coordinates = format!(" X{} Y{}", (self.number)(end[0]), (self.number)(end[1]));
                    if end[2] != from[2] {
                        coordinates += &format!(" Z{}", (self.number)(end[2]));
                    }
                    at = Some(*end);
                    let (i, j) = (centre[0] - from[0], centre[1] - from[1]);
                    let centre = format!(" I{} J{}", (self.number)(i), (self.number)(j));
                    text += &format!("{word}{coordinates}{centre}{}\n", feed_word(*feed));
                }
                Move::Hole { at: [x, y], top, bottom, peck, feed } => match self.hole {
                    HoleWords::Moves => {
                        let mut to = |text: &mut String, word: &str, end: Point, feed: &str| {
                            let coordinates = self.coordinates(&mut at, &end);
                            *text += &format!("{word}{coordinates}{feed}\n");
                        };
                        to(&mut text, "G0", [*x, *y, RETRACT_MM], "");
                        to(&mut text, "G0", [*x, *y, top + SAFETY_MM], "");
                        to(&mut text, "G1", [*x, *y, *bottom], &feed_word(*feed));
                        to(&mut text, "G0", [*x, *y, RETRACT_MM], "");
                    }
                    HoleWords::Cycles => {
                        let (x, y) = ((self.number)(*x), (self.number)(*y));
                        if cycle.replace((*bottom, *peck)) == Some((*bottom, *peck)) {
                            text += &format!("X{x} Y{y}\n");
                        } else {
                            let (word, pecks) = match *peck {
                                0.0 => ("G81", String::new()),
                                peck => ("G83", format!(" Q{}", (self.number)(peck))),
                            };
                            let (z, r) = ((self.number)(*bottom), (self.number)(top + SAFETY_MM));
                            let (back, feed) = (self.return_word, feed_word(*feed));
                            text += &format!("{back} {word} X{x} Y{y} Z{z} R{r}{pecks}{feed}\n");
                        }
                        at = None;
                    }
                    HoleWords::ModalCall => {
                        if cycle.replace((*bottom, *peck)) != Some((*bottom, *peck)) {
                            let _ = writeln!(text, "F{}", number(*feed));
                            feed_in_force = Some(*feed);
                            let (retract, top, safety) =
                                (number(RETRACT_MM), number(*top), number(SAFETY_MM));
                            let bottom = number(*bottom);
                            text += &match *peck {
                                0.0 => format!("MCALL CYCLE81({retract},{top},{safety},{bottom})\n"),
                                peck => format!(
                                    "MCALL CYCLE83({retract},{top},{safety},{bottom},,,{0},0,0,0,1,1,,{0})\n",
                                    number(peck)
                                ),
                            };
                        }
                        text += &format!("X{} Y{}\n", number(*x), number(*y));
                        at = None;
                    }
                },
                Move::Dwell { seconds } => text += &(self.dwell)(*seconds),
            }
        }
        text + self.end
    }
}

/// A number with its sign, as Heidenhain controls write it.
fn signed(value: f64) -> String {
    let text = number(value);
    if text.starts_with('-') { text } else { format!("+{text}") }
}

/// The coordinates of `end` that differ from those of `at`, as words.
fn changed_words(at: &Point, end: &Point) -> String {
    let axes = [("X", 0), ("Y", 1), ("Z", 2)].into_iter().filter(|(_, axis)| end[*axis] != at[*axis]);
    axes.map(|(letter, axis)| format!(" {letter}{}", signed(end[axis]))).collect()
}

/// The angle a helix turns by, degrees, positive if counterclockwise.
fn turn(from: Point, end: &Point, centre: &[f64; 2], clockwise: bool) -> f64 {
    let angle = |p: &Point| (p[1] - centre[1]).atan2(p[0] - centre[0]);
    let turned = (angle(end) - angle(&from)).rem_euclid(TAU);
    let turned = if clockwise { turned - TAU } else { turned };
    turned.to_degrees()
}

/// The parameters of Heidenhain's cycle 200 for a hole between these heights, mm; a `peck` of 0 is one down to the
/// bottom.
fn drilling_parameters(top: f64, bottom: f64, peck: f64, feed: f64) -> String {
    let infeed = if peck == 0.0 { top - bottom } else { peck };
    format!(
        "Q200={} Q201={} Q206={} Q202={} Q210=0 Q203={} Q204={} Q211=0",
        number(SAFETY_MM),
        signed(bottom - top),
        number(feed),
        number(infeed),
        signed(top),
        number(RETRACT_MM),
    )
}

fn klartext(moves: &[Move]) -> String {
    let mut lines = vec!["BEGIN PGM PART MM".to_string()];
    let mut at = [0.0; 3];
    let mut cycle: Option<(f64, f64)> = None;
    for next in moves {
        match next {
            Move::Tool { number, rpm, name } => {
                lines.push(format!("; {name}"));
                lines.push(format!("TOOL CALL {number} Z S{rpm}"));
                lines.push("M3".into());
            }
            Move::Rapid(end) => {
                lines.push(format!("L X{} Y{} Z{} R0 FMAX", signed(end[0]), signed(end[1]), signed(end[2])));
                at = *end;
            }
            Move::Line { end, feed } => {
                let words = changed_words(&at, end);
                if !words.is_empty() {
                    lines.push(format!("L{words} F{}", number(*feed)));
                }
                at = *end;
            }
            Move::Arc { end, centre, clockwise, feed } => {
                lines.push(format!("CC X{} Y{}", signed(centre[0]), signed(centre[1])));
                let direction = if *clockwise { "DR-" } else { "DR+" };
                if end[2] == at[2] {
                    lines.push(format!(
                        "C X{} Y{} {direction} F{}",
                        signed(end[0]),
                        signed(end[1]),
                        number(*feed)
                    ));
                } else {
                    let turn = signed(turn(at, end, centre, *clockwise));
                    lines.push(format!("CP IPA{turn} Z{} {direction} F{}", signed(end[2]), number(*feed)));
                }
                at = *end;
            }
            Move::Hole { at: [x, y], top, bottom, peck, feed } => {
                if cycle.replace((*bottom, *peck)) != Some((*bottom, *peck)) {
                    let parameters = drilling_parameters(*top, *bottom, *peck, *feed);
                    lines.push(format!("CYCL DEF 200 DRILLING {parameters}"));
                }
                lines.push(format!("L X{} Y{} R0 FMAX M99", signed(*x), signed(*y)));
            }
            Move::Dwell { seconds } => {
                lines.push("CYCL DEF 9.0 DWELL TIME".into());
                lines.push(format!("CYCL DEF 9.1 DWELL {}", number(*seconds)));
            }
        }
    }
    lines.extend(["M5".to_string(), "M30".into(), "END PGM PART MM".into()]);
    lines.iter().enumerate().map(|(number, line)| format!("{number} {line}\n")).collect()
}

fn heidenhain_iso(moves: &[Move]) -> String {
    let mut lines = vec!["G17 G90".to_string()];
    let mut at = [0.0; 3];
    let mut cycle: Option<(f64, f64)> = None;
    for next in moves {
        match next {
            Move::Tool { number, rpm, .. } => lines.extend([format!("T{number} G17 S{rpm}"), "M3".into()]),
            Move::Rapid(end) => {
                lines.push(format!("G00 G40 X{} Y{} Z{}", signed(end[0]), signed(end[1]), signed(end[2])));
                at = *end;
            }
            Move::Line { end, feed } => {
                let words = changed_words(&at, end);
                if !words.is_empty() {
                    lines.push(format!("G01{words} F{}", number(*feed)));
                }
                at = *end;
            }
            Move::Arc { end, centre, clockwise, feed } => {
                lines.push(format!("I{} J{}", signed(centre[0]), signed(centre[1])));
                if end[2] == at[2] {
                    let word = if *clockwise { "G02" } else { "G03" };
                    lines.push(format!("{word} X{} Y{} F{}", signed(end[0]), signed(end[1]), number(*feed)));
                } else {
                    let word = if *clockwise { "G12" } else { "G13" };
                    let turn = signed(turn(at, end, centre, *clockwise));
                    lines.push(format!("G91 {word} H{turn} Z{} F{}", signed(end[2] - at[2]), number(*feed)));
                    lines.push("G90".into());
                }
                at = *end;
            }
            Move::Hole { at: [x, y], top, bottom, peck, feed } => {
                if cycle.replace((*bottom, *peck)) != Some((*bottom, *peck)) {
                    lines.push(format!("G200 {}", drilling_parameters(*top, *bottom, *peck, *feed)));
                }
                lines.push(format!("G00 X{} Y{} M99", signed(*x), signed(*y)));
            }
            Move::Dwell { seconds } => lines.push(format!("G04 F{}", number(*seconds))),
        }
    }
    lines.extend(["M5".to_string(), "M30".into()]);
    let body: String =
        (1..).zip(&lines).map(|(number, line)| format!("N{} {line} *\n", 10 * number)).collect();
    format!("%PART G71 *\n{body}N99999999 %PART G71 *\n")
}
