//! The path modes by the words of a program.

use crate::simulation::gcode::{LineNumber, Place};
use crate::simulation::interpreter::block::{AXIS_WORDS, CENTER_WORDS, bits};
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::path_mode::{PathRemark, PathWord, ToleranceGroup};
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::Blending;

/// The tolerances and distances that count as meant, mm.
const TOLERANCES_MM: std::ops::RangeInclusive<f64> = 1e-6..=10.0;

/// Rules for every dialect. `place` is the place of the words, `source` the words as people write them; lengths
/// are in mm.
impl Interpreter<'_> {
    /// Runs a word of the group of G61 and G64 (G60, G641, G642 …): exact stop, or another mode and no exact stop.
    /// A plain G64 ends it.
    pub(crate) fn set_path_mode(&mut self, place: Place, source: String, blending: Blending) {
        if matches!(blending, Blending::ExactStop | Blending::ExactPath) {
            self.path_mode.exact_stop = Some((blending, source));
        } else {
            self.path_mode.exact_stop = None;
            self.keep(place, blending, source, ToleranceGroup::Group);
        }
        self.note_path_mode(place.line);
    }

    /// Runs a word with a separate tolerance (G187, CYCLE832, cycle 32), which remains through exact stop and G64;
    /// [`Blending::Machine`] ends it.
    pub(crate) fn set_tolerance(&mut self, place: Place, source: String, blending: Blending) {
        self.keep(place, blending, source, ToleranceGroup::Own);
        self.note_path_mode(place.line);
    }

    /// Runs a word that ends exact stop and states no tolerance (a plain G64). It ends a tolerance of the
    /// same group; any other tolerance remains.
    pub(crate) fn set_continuous_path(&mut self, place: Place, source: String) {
        self.path_mode.exact_stop = None;
        if matches!(self.path_mode.tolerance, Some((_, _, ToleranceGroup::Group)) | None) {
            if let Some((Blending::Within(_) | Blending::Distance(_), ..)) = self.path_mode.tolerance {
                self.remark_on_path(place, PathRemark::NoTolerance { source_words: source.clone() });
            }
            self.path_mode.tolerance = Some((Blending::Machine, source, ToleranceGroup::Group));
        }
        self.note_path_mode(place.line);
    }

    /// Sets the tolerance; one out of bounds becomes the machine's, with a remark.
    fn keep(&mut self, place: Place, blending: Blending, source: String, keeper: ToleranceGroup) {
        let blending = match blending {
            Blending::Within(value) | Blending::Distance(value) if !TOLERANCES_MM.contains(&value) => {
                let remark = PathRemark::BadTolerance { source_words: source.clone(), value };
                self.remark_on_path(place, remark);
                Blending::Machine
            }
            _ => blending,
        };
        self.path_mode.tolerance = Some((blending, source, keeper));
    }

    /// Passes the mode in force on to the toolpath from the next segment on.
    fn note_path_mode(&mut self, line: LineNumber) {
        let (blending, source) = match (&self.path_mode.exact_stop, &self.path_mode.tolerance) {
            (Some((blending, source)), _) => (*blending, source.as_str()),
            (None, Some((blending, source, _))) => (*blending, source.as_str()),
            (None, None) => (Blending::Machine, ""),
        };
        let merging = self.path_mode.merging;
        self.canonical.set_path_mode(line, source, blending, merging);
    }

    /// Adds a remark on path modes.
    fn remark_on_path(&mut self, place: Place, remark: PathRemark) {
        self.remarks.add(place, TraceRemark::PathMode(remark));
    }
}

/// Words of the ISO dialects.
impl Interpreter<'_> {
    /// Runs a path word of the block. Returns `false` if the word belongs to another control and takes the axis
    /// words of the block. `owns_p` is `false` if another word of the block takes P.
    pub(crate) fn path_word(&mut self, place: Place, word: PathWord, code: Code, owns_p: bool) -> bool {
        match word {
            PathWord::ExactStop => self.set_path_mode(place, code.to_string(), Blending::ExactStop),
            PathWord::ExactPath => self.set_path_mode(place, code.to_string(), Blending::ExactPath),
            PathWord::Continuous => self.continuous(place, code, owns_p),
            PathWord::Smoothness => self.smoothness(place, code),
            // With axis words G5 and G5.1 are splines of LinuxCNC, or name the axes to smooth.
            PathWord::ContourControl | PathWord::LookAhead
                if self.given.has(AXIS_WORDS | CENTER_WORDS) && !self.given.has(bits(b"Q")) =>
            {
                return false;
            }
            PathWord::ContourControl => {
                // Axis words name the axes to smooth.
                for axis in *b"XYZABC" {
                    self.given.take(axis);
                }
                self.contour_control(place, code);
            }
            PathWord::LookAhead => {
                let p = self.given.take(b'P');
                self.remark_on_path(place, PathRemark::LookAhead { source_words: words(code, 'P', p) });
            }
        }
        true
    }

    /// Runs G64 and G64 P Q.
    fn continuous(&mut self, place: Place, code: Code, owns_p: bool) {
        let p = if owns_p { self.given.take(b'P') } else { None };
        let q = if owns_p { self.given.take(b'Q') } else { None };
        let merging = q.map(|q| q * self.modal.unit).filter(|q| *q == 0.0 || TOLERANCES_MM.contains(q));
        self.path_mode.merging = merging;
        let source = words(code, 'P', p);
        match p {
            Some(p) if p != 0.0 => {
                self.set_path_mode(place, source, Blending::Within(p * self.modal.unit));
                let merges = self.machine.interpolator.junction.blends_in_time()
                    || self.machine.interpolator.path_smoothing.is_some();
                if q != Some(0.0) && !merges {
                    self.remark_on_path(place, PathRemark::NaiveCam);
                }
            }
            _ => self.set_continuous_path(place, source),
        }
    }

    /// Runs G187 P E.
    fn smoothness(&mut self, place: Place, code: Code) {
        let (level, rounding) = (self.given.take(b'P'), self.given.take(b'E'));
        let levels = &self.machine.path_modes;
        let source = words(code, 'P', level);
        let blending = match (level, rounding) {
            (_, Some(0.0)) => Blending::ExactStop,
            (_, Some(rounding)) => Blending::Within(rounding * self.modal.unit),
            (None, None) => Blending::Machine,
            (Some(level), None) => {
                let known = match level {
                    1.0 => (levels.rough, "path_modes.rough_mm"),
                    2.0 => (levels.medium, "path_modes.medium_mm"),
                    3.0 => (levels.finish, "path_modes.finish_mm"),
                    _ => return self.remark_on_path(place, PathRemark::BadLevel { source_words: source }),
                };
                self.level(place, &source, known)
            }
        };
        let source = if rounding.is_some() { words(code, 'E', rounding) } else { source };
        self.set_tolerance(place, source, blending);
    }

    /// Runs G5.1 Q R.
    fn contour_control(&mut self, place: Place, code: Code) {
        let (q, level) = (self.given.take(b'Q'), self.given.take(b'R'));
        let levels = &self.machine.path_modes;
        let Some(level) = level.filter(|_| q != Some(0.0)) else {
            if q == Some(0.0) {
                self.set_tolerance(place, words(code, 'Q', q), Blending::Machine);
            }
            return self.remark_on_path(place, PathRemark::LookAhead { source_words: words(code, 'Q', q) });
        };
        let source = format!("{} R{level}", words(code, 'Q', q));
        if !(1.0..=10.0).contains(&level) {
            return self.remark_on_path(place, PathRemark::BadLevel { source_words: source });
        }
        let between =
            |(first, last): (f64, f64)| first * ((10.0 - level) / 9.0) + last * ((level - 1.0) / 9.0);
        let known = levels.level_1.zip(levels.level_10).map(between);
        let blending =
            self.level(place, &source, (known, "path_modes.level_1_mm and path_modes.level_10_mm"));
        self.set_tolerance(place, source, blending);
    }

    /// Returns the tolerance of a level of the control; if the machine file does not have it, the machine's, with
    /// a remark.
    fn level(&mut self, place: Place, source: &str, known: (Option<f64>, &'static str)) -> Blending {
        known.0.map_or_else(
            || {
                let remark = PathRemark::UnknownLevel { source_words: source.to_string(), keys: known.1 };
                self.remark_on_path(place, remark);
                Blending::Machine
            },
            Blending::Within,
        )
    }
}

/// Returns a G word with the word beside it, if there is one.
fn words(code: Code, letter: char, value: Option<f64>) -> String {
    value.map_or_else(|| code.to_string(), |value| format!("{code} {letter}{value}"))
}
