//! Signs of a lathe program, which Truefeed declines. In such a program X words are diameters, the feed may depend
//! on the spindle, whose speed depends on the diameter, and turning cycles divide their cuts themselves. None of
//! that is modelled, so the time of such a program would be wrong.
//!
//! | sign | weight |
//! |---|---|
//! | a turning cycle (G71 to G73 with P, Q and U or W, G70 P Q, G76 P of six digits; CYCLE95 and others of Siemens) | enough |
//! | turning mode of Heidenhain | enough |
//! | DIAMON, DIAM90 and the like in any dialect, G7 of LinuxCNC (X words are diameters), G76 P I J K (threading) | enough without Y |
//! | G96 (constant surface speed) | enough without Y |
//! | G90 or G94 with X or U, Z or W and a feed below 1 mm or 0.1 inch, without G0 to G3 (a pass of turning or facing) | half, without Y |
//! | G99 outside a cycle (feeds per revolution) | half, without Y |
//! | a limit of the spindle speed (G50 S, G92 S) | half, without Y |
//! | X and Z by increments U and W, without V | half, without Y |
//! | T with an offset (T0101) in a program without M6 | half, without Y |
//! | threads (G32, G33; G92 with X, Z and F) | half, without Y |
//! | F below 1 per minute, which is one per revolution | half, without Y |
//! | G12.1, G112 (polar interpolation) | half, without Y |
//!
//! Mills have G70 to G76 and G90 to G99 with other meanings or words, and hardly ever a program without any Y.
//! Half of the weight leaves the time in doubt if mills hardly ever have that sign.
//!
//! Sources: Fanuc Series 0i-TD, Operator's Manual (Lathe System); SINUMERIK 840D sl, Programming Manual Turning;
//! LinuxCNC 2.9, G7, G76, G96; Okuma OSP-P200L programming manual; TNC 640, turning.

mod signs;

use crate::simulation::gcode::LineNumber;

/// Least sum of weights that shows a lathe program.
const MIN_WEIGHT: u32 = 2;

/// A sign of lathe programs.
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
    ThreadingPass,
    TurningPass,
    FeedsPerRevolution,
    FeedPerRevolution,
    PolarInterpolation,
}

impl Sign {
    /// Returns its meaning, which remarks give beside the word.
    fn meaning(self) -> &'static str {
        match self {
            Sign::TurningCycle => "a turning cycle",
            Sign::Diameters => "X in diameters",
            Sign::TurningMode => "turning mode",
            Sign::ThreadingCycle | Sign::Thread | Sign::ThreadingPass => "a thread",
            Sign::TurningPass => "a pass of turning or facing",
            Sign::FeedsPerRevolution => "feeds per revolution",
            Sign::SurfaceSpeed => "constant surface speed",
            Sign::SpeedLimit => "a limit of the spindle speed",
            Sign::IncrementsByUW => "increments of X and Z",
            Sign::ToolWithOffset => "a tool with its offset",
            Sign::FeedPerRevolution => "a feed per revolution",
            Sign::PolarInterpolation => "polar interpolation",
        }
    }

    /// Returns `true` if mills never have the sign.
    fn is_of_lathes_alone(self) -> bool {
        matches!(self, Sign::TurningCycle | Sign::TurningMode)
    }

    /// Returns `true` if mills hardly ever have the sign, so that even alone it leaves the time in doubt.
    fn is_suspicious_alone(self) -> bool {
        matches!(self, Sign::SpeedLimit | Sign::ThreadingPass | Sign::TurningPass | Sign::FeedPerRevolution)
    }

    /// Returns its weight.
    fn weight(self) -> u32 {
        match self {
            Sign::Diameters | Sign::ThreadingCycle | Sign::SurfaceSpeed => MIN_WEIGHT,
            _ if self.is_of_lathes_alone() => MIN_WEIGHT,
            _ => 1,
        }
    }
}

/// The result of the signs of a program, with the first line and the reasons.
enum LatheVerdict {
    Mill,
    PerhapsLathe { line: LineNumber, reasons: String },
    Lathe { line: LineNumber, reasons: String },
}

/// The signs of a program so far, each at its first line.
#[derive(Debug, Default)]
pub(super) struct Turning {
    signs: Vec<(Sign, LineNumber, String)>,
    /// `true` if the program has a position in Y.
    pub(super) names_y: bool,
}

impl Turning {
    /// Adds a sign with its word.
    pub(super) fn note(&mut self, sign: Sign, line: LineNumber, word: impl FnOnce() -> String) {
        if self.signs.iter().all(|(known, ..)| *known != sign) {
            self.signs.push((sign, line, word()));
        }
    }

    /// Returns the result of the signs so far; `changes_tool` if the program has a tool change.
    fn verdict(&self, changes_tool: bool) -> LatheVerdict {
        let counts = |sign: Sign| match sign {
            Sign::ToolWithOffset => !self.names_y && !changes_tool,
            sign => !self.names_y || sign.is_of_lathes_alone(),
        };
        let counted: Vec<_> = self.signs.iter().filter(|(sign, ..)| counts(*sign)).collect();
        let is_lathe = MIN_WEIGHT <= counted.iter().map(|(sign, ..)| sign.weight()).sum();
        if !is_lathe && counted.iter().all(|(sign, ..)| !sign.is_suspicious_alone()) {
            return LatheVerdict::Mill;
        }
        let reasons = counted
            .iter()
            .map(|(sign, line, word)| format!("{word} in line {} ({})", line.0, sign.meaning()));
        let reasons = reasons.collect::<Vec<_>>().join(", ");
        let line = counted[0].1;
        if is_lathe {
            LatheVerdict::Lathe { line, reasons }
        } else {
            LatheVerdict::PerhapsLathe { line, reasons }
        }
    }
}

#[cfg(test)]
mod tests;
