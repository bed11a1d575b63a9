//! Search for the signs of a lathe program.

use crate::simulation::gcode::{Diagnostic, Dialect, Keyword, Place, Severity, Statement, Word};
use crate::simulation::interpreter::block::{AXIS_WORDS, Block, POLAR_WORDS, bits, is_dwell};
use crate::simulation::interpreter::feed_mode::FeedMode;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::interpreter::turning::{LatheVerdict, Sign};
use crate::simulation::toolpath::{StopCause, Toolpath};
use crate::units::MM_PER_INCH;

/// Feeds below the least one per minute, in mm and in inches; a turning pass has one of them.
const LOW_FEEDS: [std::ops::Range<f64>; 2] = [0.001..1.0, 0.001..0.1];

impl Interpreter<'_> {
    /// Reads a block that has only the word by which X words are diameters; returns `false` for other blocks.
    #[inline]
    pub(crate) fn note_diameters(&mut self, block: Block) -> bool {
        let [Statement { keyword: Keyword::Diameters(word), .. }] = block.statements.list else {
            return false;
        };
        self.turning.note(Sign::Diameters, block.line, || word.to_string());
        true
    }

    /// Searches a block of ISO words for signs of a lathe.
    pub(crate) fn look_for_turning(&mut self, block: Block) {
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
                920 if is_like_fanuc && has(b"X") && has(b"Z") && has(b"F") => Sign::ThreadingPass,
                900 | 940 if is_like_fanuc && self.is_turning_pass(block) => Sign::TurningPass,
                990 if is_like_fanuc && !self.cycle.is_active() => Sign::FeedsPerRevolution,
                320 | 330 if has(b"Z") && (has(b"F") || has(b"K")) => Sign::Thread,
                121 | 1120 if is_like_fanuc => Sign::PolarInterpolation,
                _ => continue,
            };
            self.turning.note(sign, line, || match sign {
                Sign::SpeedLimit => format!("G{} S", word.value),
                Sign::TurningCycle if word.value < 76.0 => format!("G{} with P and Q", word.value),
                Sign::TurningPass | Sign::ThreadingPass => format!("G{} with X and Z", word.value),
                _ => format!("G{}", word.value),
            });
        }
        if is_like_fanuc && has(b"UW") && !has(b"V") && !is_dwell(block.words) {
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
        if let Some(feed) = feed.filter(|_| is_like_fanuc && is_per_minute && !is_dwell(block.words)) {
            self.turning.note(Sign::FeedPerRevolution, line, || format!("F{feed}"));
        }
        let is_threading = block.words.iter().any(|word| word.letter == b'G' && word.value == 76.0);
        self.turning.names_y |= has(b"YV") || self.given.has(POLAR_WORDS) || (has(b"J") && !is_threading);
    }

    /// Returns `true` if a block with G90 or G94 is a pass of a lathe: across X and Z at a feed too low for one
    /// per minute.
    fn is_turning_pass(&self, block: Block) -> bool {
        let has = |letters: &[u8]| self.given.has(bits(letters));
        let is_move = |word: &Word| word.letter == b'G' && (0.0..4.0).contains(&word.value);
        let feed = self.given.get(b'F').or(self.modal.feed.per_minute);
        let low = &LOW_FEEDS[usize::from(self.modal.unit == MM_PER_INCH)];
        has(b"XU")
            && has(b"ZW")
            && self.modal.feed.mode == FeedMode::PerMinute
            && feed.is_some_and(|feed| low.contains(&feed))
            && !self.cycle.is_active()
            && !block.words.iter().any(is_move)
    }

    /// Returns the empty toolpath of a lathe program, which is not quoted, with the reason as its remark; `None`
    /// for other programs. A program that may be one for a lathe is run, with a remark that puts its time in
    /// doubt.
    pub(crate) fn declined(&mut self) -> Option<Toolpath> {
        let is_change =
            |cause: &StopCause| matches!(cause, StopCause::ToolChange { .. } | StopCause::SameTool { .. });
        let changes_tool = self.canonical.toolpath().stops.iter().any(|stop| is_change(&stop.cause));
        let (line, reasons) = match self.turning.verdict(changes_tool) {
            LatheVerdict::Mill => return None,
            LatheVerdict::PerhapsLathe { line, reasons } => {
                self.remarks.add(Place::line(line), TraceRemark::PerhapsLathe { reasons });
                return None;
            }
            LatheVerdict::Lathe { line, reasons } => (line, reasons),
        };
        let message = format!(
            "this is a lathe program, by {reasons}: Truefeed does not model turning and quotes nothing; give a program for a mill"
        );
        let columns = Place::line(line).columns;
        let declined = Diagnostic { line, columns, severity: Severity::Error, message };
        let diagnostics = vec![declined.clone()];
        Some(Toolpath { dialect: self.dialect, declined: Some(declined), diagnostics, ..Toolpath::default() })
    }
}
