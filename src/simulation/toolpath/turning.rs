//! Signs of a lathe program, which is declined: X words are diameters there, the feed may follow the spindle, whose
//! speed follows the diameter, and turning cycles make their cuts themselves. None of that is modelled, so that a
//! time of such a program would be wrong.
//!
//! | sign | weight |
//! |---|---|
//! | a turning cycle (G71 to G73 with P, Q and U or W, G70 P Q, G76 P of six digits; CYCLE95 and others of Siemens) | enough |
//! | turning mode of Heidenhain | enough |
//! | DIAMON, DIAM90, G7 of LinuxCNC (X words are diameters), G76 P I J K (threading) | enough without Y |
//! | G96 (constant surface speed) | enough without Y |
//! | a limit of the spindle speed (G50 S, G92 S) | half, without Y |
//! | X and Z by increments U and W, without V | half, without Y |
//! | T with an offset (T0101) in a program without M6 | half, without Y |
//! | threads (G32, G33, G92 with F) | half, without Y |
//! | F below 1 per minute, which is one per revolution | half, without Y |
//! | G12.1, G112 (polar interpolation) | half, without Y |
//!
//! Mills have G70 to G76, G92 and G96 with other meanings or words, and hardly a program without any Y.
//!
//! Sources: Fanuc Series 0i-TD, Operator's Manual (Lathe System); SINUMERIK 840D sl, Programming Manual Turning;
//! LinuxCNC 2.9, G7, G76, G96; Okuma OSP-P200L programming manual; TNC 640, turning.

use crate::simulation::gcode::{Diagnostic, Dialect, LineNumber, Place, Severity};
use crate::simulation::toolpath::block::{AXIS_WORDS, Block, POLAR_WORDS, bits};
use crate::simulation::toolpath::feed_mode::FeedMode;
use crate::simulation::toolpath::trace::Tracer;
use crate::simulation::toolpath::{StopCause, Toolpath};

/// What signs weigh together that show a lathe program.
const ENOUGH: u32 = 2;

/// Something that lathe programs hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sign {
    TurningCycle,
    Diameters,
    TurningMode,
    ThreadingCycle,
    SurfaceSpeed,
    SpeedLimit,
    IncrementsByUW,
    ToolWithOffset,
    Thread,
    FeedPerRevolution,
    PolarInterpolation,
}

impl Sign {
    /// What it says of the program, beside the word.
    fn meaning(self) -> &'static str {
        match self {
            Sign::TurningCycle => "a turning cycle",
            Sign::Diameters => "X in diameters",
            Sign::TurningMode => "turning mode",
            Sign::ThreadingCycle | Sign::Thread => "a thread",
            Sign::SurfaceSpeed => "constant surface speed",
            Sign::SpeedLimit => "a limit of the spindle speed",
            Sign::IncrementsByUW => "increments of X and Z",
            Sign::ToolWithOffset => "a tool with its offset",
            Sign::FeedPerRevolution => "a feed per revolution",
            Sign::PolarInterpolation => "polar interpolation",
        }
    }

    /// Mills do not have it at all.
    fn is_of_lathes_alone(self) -> bool {
        matches!(self, Sign::TurningCycle | Sign::TurningMode)
    }

    fn weight(self) -> u32 {
        match self {
            Sign::Diameters | Sign::ThreadingCycle | Sign::SurfaceSpeed => ENOUGH,
            _ if self.is_of_lathes_alone() => ENOUGH,
            _ => 1,
        }
    }
}

/// The signs of a program so far, each where it comes up first.
#[derive(Debug, Default)]
pub(super) struct Turning {
    signs: Vec<(Sign, LineNumber, String)>,
    /// The program names a position in Y.
    pub(super) names_y: bool,
}

impl Turning {
    /// Keeps a sign and its word.
    pub(super) fn note(&mut self, sign: Sign, line: LineNumber, word: impl FnOnce() -> String) {
        if self.signs.iter().all(|(known, ..)| *known != sign) {
            self.signs.push((sign, line, word()));
        }
    }

    /// The line and the reasons why the program is one of a lathe.
    fn reasons(&self, changes_tool: bool) -> Option<(LineNumber, String)> {
        let counts = |sign: Sign| match sign {
            Sign::ToolWithOffset => !self.names_y && !changes_tool,
            sign => !self.names_y || sign.is_of_lathes_alone(),
        };
        let counted: Vec<_> = self.signs.iter().filter(|(sign, ..)| counts(*sign)).collect();
        if counted.iter().map(|(sign, ..)| sign.weight()).sum::<u32>() < ENOUGH {
            return None;
        }
        let reasons: Vec<String> = counted
            .iter()
            .map(|(sign, line, word)| format!("{word} in line {} ({})", line.0, sign.meaning()))
            .collect();
        Some((counted[0].1, reasons.join(", ")))
    }
}

impl Tracer<'_> {
    /// Looks for signs of a lathe in a block of ISO words.
    pub(super) fn look_for_turning(&mut self, block: Block) {
        let has = |letters: &[u8]| self.given.has(bits(letters));
        let line = block.line;
        let is_like_fanuc = matches!(self.dialect, Dialect::Iso | Dialect::Okuma | Dialect::Mach);
        let is_rs274 = self.dialect == Dialect::LinuxCnc;
        let tenths = |number: f64| (10.0 * number).round() as i64;
        for word in block.words.iter().filter(|word| word.letter == b'G') {
            let is_setting = !self.given.has(AXIS_WORDS);
            let sign = match tenths(word.value) {
                700 if is_like_fanuc && has(b"P") && has(b"Q") && !has(b"I") => Sign::TurningCycle,
                710 | 720 if is_like_fanuc && has(b"P") && has(b"Q") && (has(b"U") || has(b"W")) => {
                    Sign::TurningCycle
                }
                730 if is_like_fanuc && has(b"P") && has(b"Q") && has(b"U") && has(b"W") => {
                    Sign::TurningCycle
                }
                760 if is_like_fanuc && is_setting && self.given.get(b'P').is_some_and(|p| 10_000.0 <= p) => {
                    Sign::TurningCycle
                }
                760 if is_rs274 && has(b"I") && has(b"J") && has(b"K") && has(b"P") => Sign::ThreadingCycle,
                70 if is_rs274 => Sign::Diameters,
                960 if self.dialect != Dialect::Klartext => Sign::SurfaceSpeed,
                500 if is_like_fanuc && is_setting && has(b"S") => Sign::SpeedLimit,
                920 if self.dialect != Dialect::Siemens && is_setting && has(b"S") => Sign::SpeedLimit,
                920 if is_like_fanuc && has(b"X") && has(b"Z") && has(b"F") => Sign::Thread,
                320 | 330 if has(b"Z") && (has(b"F") || has(b"K")) => Sign::Thread,
                121 | 1120 if is_like_fanuc => Sign::PolarInterpolation,
                _ => continue,
            };
            self.turning.note(sign, line, || match sign {
                Sign::SpeedLimit => format!("G{} S", word.value),
                Sign::TurningCycle if word.value < 76.0 => format!("G{} with P and Q", word.value),
                _ => format!("G{}", word.value),
            });
        }
        if is_like_fanuc && has(b"UW") && !has(b"V") && !is_dwell(block) {
            let letter = if has(b"U") { "U" } else { "W" };
            self.turning.note(Sign::IncrementsByUW, line, || letter.to_string());
        }
        let tool = self.given.get(b'T').filter(|_| is_like_fanuc);
        if let Some(tool) =
            tool.filter(|tool| (101.0..=9999.0).contains(tool) && (1.0..=99.0).contains(&(tool % 100.0)))
        {
            self.turning.note(Sign::ToolWithOffset, line, || format!("T{tool:04}"));
        }
        let feed = self.given.get(b'F').filter(|feed| (0.001..1.0).contains(feed));
        let is_per_minute = self.modal.feed.mode == FeedMode::PerMinute;
        if let Some(feed) = feed.filter(|_| is_like_fanuc && is_per_minute && !is_dwell(block)) {
            self.turning.note(Sign::FeedPerRevolution, line, || format!("F{feed}"));
        }
        let is_threading = block.words.iter().any(|word| word.letter == b'G' && word.value == 76.0);
        self.turning.names_y |= has(b"YV") || self.given.has(POLAR_WORDS) || (has(b"J") && !is_threading);
    }

    /// The toolpath of a program that shows itself as one for a lathe: nothing of it is quoted, and its first remark
    /// says why.
    pub(super) fn declined(&mut self) -> Option<Toolpath> {
        let is_change =
            |cause: &StopCause| matches!(cause, StopCause::ToolChange { .. } | StopCause::SameTool { .. });
        let changes_tool = self.toolpath.stops.iter().any(|stop| is_change(&stop.cause));
        let (line, reasons) = self.turning.reasons(changes_tool)?;
        let message = format!(
            "this is a lathe program, by {reasons}: turning is not modelled, so nothing of it is quoted; give a program for a mill"
        );
        let columns = Place::line(line).columns;
        let declined = Diagnostic { line, columns, severity: Severity::Error, message };
        let diagnostics = vec![declined.clone()];
        Some(Toolpath { dialect: self.dialect, declined: Some(declined), diagnostics, ..Toolpath::default() })
    }
}

fn is_dwell(block: Block) -> bool {
    block.words.iter().any(|word| word.letter == b'G' && word.value == 4.0)
}

#[cfg(test)]
mod tests;
