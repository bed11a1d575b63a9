//! Programs in several dialects, and damage that no control reads: what is left out or put in is drawn by a seed.

/// Draws numbers (xorshift64*).
pub struct Draw(u64);

impl Draw {
    pub fn new(seed: u64) -> Draw {
        Draw(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.next() >> 33) as usize % count
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn of<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())]
    }
}

/// How a program is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Style {
    Fanuc,
    LinuxCnc,
    Grbl,
    Mach,
    Siemens,
    Klartext,
}

pub const STYLES: [Style; 6] =
    [Style::Fanuc, Style::LinuxCnc, Style::Grbl, Style::Mach, Style::Siemens, Style::Klartext];

/// Where the tool of a program that is being written is.
struct Writer {
    style: Style,
    lines: Vec<String>,
    at: [f64; 2],
    /// Motion words are written only where they change.
    is_modal: bool,
    motion: &'static str,
    feed: u32,
}

impl Writer {
    fn motion(&mut self, word: &'static str) -> &'static str {
        let is_same = self.motion == word;
        self.motion = word;
        if is_same && self.is_modal { "" } else { word }
    }

    fn rapid(&mut self, x: f64, y: f64) {
        self.at = [x, y];
        let line = match self.style {
            Style::Klartext => format!("L X{x:+.3} Y{y:+.3} R0 FMAX"),
            _ => format!("{} X{x:.3} Y{y:.3}", self.motion("G0")),
        };
        self.lines.push(line);
    }

    fn height(&mut self, z: f64, feed: Option<u32>) {
        let line = match (self.style, feed) {
            (Style::Klartext, None) => format!("L Z{z:+.3} R0 FMAX"),
            (Style::Klartext, Some(feed)) => format!("L Z{z:+.3} F{feed}"),
            (_, None) => format!("{} Z{z:.3}", self.motion("G0")),
            (_, Some(feed)) => format!("{} Z{z:.3} F{feed}", self.motion("G1")),
        };
        self.lines.push(line);
    }

    fn line(&mut self, x: f64, y: f64, has_feed: bool) {
        self.at = [x, y];
        let sign = if self.style == Style::Klartext { "+" } else { "" };
        let word = if self.style == Style::Klartext { "L" } else { self.motion("G1") };
        let coordinate =
            |value: f64| if sign.is_empty() { format!("{value:.3}") } else { format!("{value:+.3}") };
        let feed = if has_feed { format!(" F{}", self.feed) } else { String::new() };
        self.lines.push(format!("{word} X{} Y{}{feed}", coordinate(x), coordinate(y)));
    }

    /// To the end of an arc about a centre by an angle, rad; positive counter-clockwise.
    fn arc(&mut self, center: [f64; 2], angle: f64) {
        let [x, y] = self.at;
        let (sin, cos) = angle.sin_cos();
        let (a, b) = (x - center[0], y - center[1]);
        let end = [center[0] + a * cos - b * sin, center[1] + a * sin + b * cos];
        if self.style == Style::Klartext {
            let turn = if angle < 0.0 { "DR-" } else { "DR+" };
            self.lines.push(format!("CC X{:+.4} Y{:+.4}", center[0], center[1]));
            self.lines.push(format!("C X{:+.4} Y{:+.4} {turn}", end[0], end[1]));
        } else {
            let word = self.motion(if angle < 0.0 { "G2" } else { "G3" });
            self.lines.push(format!("{word} X{:.4} Y{:.4} I{:.4} J{:.4}", end[0], end[1], -a, -b));
        }
        self.at = end;
    }
}

/// A sound program: passes of lines, arcs and curves of short lines at several depths, with retractions between.
pub fn program(style: Style, draw: &mut Draw) -> String {
    let is_modal = style != Style::Klartext && draw.below(2) == 0;
    let mut writer = Writer { style, lines: Vec::new(), at: [0.0, 0.0], is_modal, motion: "", feed: 0 };
    let head: &[&str] = match style {
        Style::Fanuc => &["%", "O1234 (PART)", "G21 G17 G40 G49 G80 G90", "T1 M6", "S8000 M3"],
        Style::LinuxCnc => &["G21 G17 G90 G64 P0.01", "T1 M6", "S8000 M3"],
        Style::Grbl => &["; grbl 1.1", "G21 G17 G90", "M3 S8000"],
        Style::Mach => &["(Mach3)", "G21 G17 G90 G91.1", "M6 T1", "S8000 M3"],
        Style::Siemens => &["; PART", "G17 G71 G90 G64", "T=\"MILL\" ", "M6", "S8000 M3"],
        Style::Klartext => &["BEGIN PGM PART MM", "TOOL CALL 1 Z S8000"],
    };
    writer.lines.extend(head.iter().map(ToString::to_string));
    let size = draw.between(20.0, 150.0);
    let feeds: Vec<u32> = (0..2).map(|_| 100 * (4 + draw.below(26)) as u32).collect();
    let plunge = feeds[0] / 3;
    writer.height(50.0, None);
    for pass in 0..2 + draw.below(4) {
        let (x, y) = (draw.between(0.0, size), draw.between(0.0, size));
        writer.rapid(x, y);
        writer.height(2.0, None);
        writer.height(-0.5 * f64::from(1 + pass as u32), Some(plunge));
        writer.feed = draw.of(&feeds);
        let mut has_feed = true;
        for _ in 0..3 + draw.below(8) {
            match draw.below(4) {
                0 => {
                    let steps = 5 + draw.below(30);
                    let (step, bend) = (draw.between(0.2, 1.5), draw.between(-0.2, 0.2));
                    let mut heading = draw.between(0.0, 6.0);
                    for _ in 0..steps {
                        heading += bend;
                        let [x, y] = writer.at;
                        writer.line(x + step * heading.cos(), y + step * heading.sin(), has_feed);
                        has_feed = false;
                    }
                }
                1 | 2 => {
                    let (x, y) = (draw.between(0.0, size), draw.between(0.0, size));
                    writer.line(x, y, has_feed);
                    has_feed = false;
                }
                _ => {
                    // The first move of a pass has the feed.
                    let [x, y] = writer.at;
                    writer.line(x + 1.0, y + 0.5, has_feed);
                    has_feed = false;
                    let [x, y] = writer.at;
                    let (radius, heading) = (draw.between(2.0, 25.0), draw.between(0.0, 6.0));
                    let center = [x + radius * heading.cos(), y + radius * heading.sin()];
                    let angle = draw.between(0.4, 5.5) * draw.of(&[-1.0, 1.0]);
                    writer.arc(center, angle);
                }
            }
        }
        writer.height(2.0, None);
    }
    writer.height(50.0, None);
    let tail: &[&str] = match style {
        Style::Fanuc => &["M5", "M30", "%"],
        Style::LinuxCnc => &["M5", "M2"],
        Style::Klartext => &["M30", "END PGM PART MM"],
        _ => &["M5", "M30"],
    };
    writer.lines.extend(tail.iter().map(ToString::to_string));
    if style == Style::Klartext {
        return writer.lines.iter().enumerate().map(|(index, line)| format!("{index} {line}\n")).collect();
    }
    writer.lines.join("\n") + "\n"
}

/// What is done to a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Damage {
    /// A number of an axis, centre or feed that does not read: two points, letters within.
    Word,
    /// The number of a word is lost.
    Number,
    /// A line ends within a word, behind its letter or sign.
    Truncated,
    /// A character of a line becomes one that no word has.
    Character,
    /// End or centre of an arc is put elsewhere.
    Arc,
    /// The feeds of the program are lost up to a line.
    Feeds,
}

pub const DAMAGES: [Damage; 6] =
    [Damage::Word, Damage::Number, Damage::Truncated, Damage::Character, Damage::Arc, Damage::Feeds];

/// The words of a line that move: where the letter is, and where its number ends.
fn words(line: &str, letters: &str) -> Vec<(usize, usize)> {
    let bytes = line.as_bytes();
    let is_start = |at: usize| {
        letters.contains(bytes[at] as char)
            && (at == 0 || !bytes[at - 1].is_ascii_alphabetic())
            && bytes.get(at + 1).is_some_and(|next| next.is_ascii_digit() || b"+-.".contains(next))
    };
    let end = |at: usize| {
        let number = bytes[at + 1..].iter().take_while(|byte| byte.is_ascii_digit() || b"+-.".contains(byte));
        at + 1 + number.count()
    };
    (0..bytes.len()).filter(|&at| is_start(at)).map(|at| (at, end(at))).collect()
}

/// Lines that move and are no header.
fn moves(lines: &[String], letters: &str) -> Vec<usize> {
    let is_comment = |line: &String| line.starts_with([';', '(', '%']);
    (0..lines.len())
        .filter(|&index| !is_comment(&lines[index]) && !words(&lines[index], letters).is_empty())
        .collect()
}

/// Damages `text` once; none where it has nothing of the kind.
pub fn damage(text: &str, kind: Damage, draw: &mut Draw) -> Option<String> {
    let mut lines: Vec<String> = text.lines().map(str::to_string).collect();
    let letters = "XYZIJF";
    let pick = |draw: &mut Draw, lines: &[String], letters: &str| {
        let found = moves(lines, letters);
        if found.is_empty() { None } else { Some(draw.of(&found)) }
    };
    match kind {
        Damage::Word | Damage::Number | Damage::Truncated | Damage::Character => {
            let index = pick(draw, &lines, letters)?;
            let line = lines[index].clone();
            let (start, end) = draw.of(&words(&line, letters));
            let number = &line[start + 1..end];
            lines[index] = match kind {
                Damage::Word => {
                    let bad = draw.of(&["..", ".1.2", "-", "?", "O.O", ",5", "--", "#"]);
                    let cut = 1 + draw.below(number.len());
                    format!("{}{}{bad}{}", &line[..start + 1], &number[..cut], &line[end..])
                }
                Damage::Number => format!("{}{}", &line[..start + 1], &line[end..]),
                Damage::Truncated => {
                    let sign = usize::from(number.starts_with(['-', '+']));
                    line[..start + 1 + sign].to_string()
                }
                _ => {
                    let at = start + draw.below(end - start);
                    format!("{}{}{}", &line[..at], draw.of(&["?", "&", "!", "\"", "$"]), &line[at + 1..])
                }
            };
        }
        Damage::Arc => {
            let is_arc = |line: &str| {
                let has_center = 2 <= words(line, "IJ").len();
                let is_klartext = line.contains(" C X") || line.contains(" CC X");
                (has_center && !line.contains("G8") && !line.contains("G7")) || is_klartext
            };
            let arcs: Vec<usize> = (0..lines.len()).filter(|&index| is_arc(&lines[index])).collect();
            if arcs.is_empty() {
                return None;
            }
            let index = draw.of(&arcs);
            let line = lines[index].clone();
            let (start, end) = draw.of(&words(&line, "XYIJ"));
            let value: f64 = line[start + 1..end].parse().ok()?;
            let off = draw.between(0.5, 20.0) * draw.of(&[-1.0, 1.0]);
            lines[index] = format!("{}{:+.4}{}", &line[..start + 1], value + off, &line[end..]);
        }
        Damage::Feeds => {
            let fed = moves(&lines, "F");
            if fed.is_empty() {
                return None;
            }
            let last = draw.of(&fed);
            for index in fed.into_iter().filter(|&index| index <= last) {
                let line = lines[index].clone();
                let (start, end) = words(&line, "F")[0];
                lines[index] = format!("{}{}", line[..start].trim_end(), &line[end..]);
            }
        }
    }
    Some(lines.join("\n") + "\n")
}
