//! Path modes: what a program itself says about stops and tolerances.
//!
//! Two things are in force side by side. Exact stop (G61) makes the tool stand after each move. A
//! tolerance says how far the motion may leave the path at corners and along arcs; where the
//! program sets none it is the machine's. A [`PathMode`] is what the two come to from one segment
//! on: while exact stop is in force there are no corners, and arcs keep the machine's tolerance.
//!
//! | word | meaning here |
//! | --- | --- |
//! | G61, G61.1 | exact stop, until G64 |
//! | G9 | exact stop in its own block; it changes no mode |
//! | G64 | no exact stop; takes back what a `G64 P` set |
//! | G64 P | no exact stop, tolerance P in the program's unit (LinuxCNC); P0 as without P |
//! | G64 Q | distance within which LinuxCNC runs lines as one; without it P |
//! | G187 E | tolerance E in the program's unit, through G61 and G64 (Haas, largest rounding of a corner); E0 exact stop |
//! | G187 P1, P2, P3 | the machine's tolerance for rough, medium, finish, where it is known (Haas) |
//! | G187 | takes back what G187 set |
//! | G5.1 Q1 R1 to R10 | between the machine's tolerances for level 1 and 10, where they are known (Fanuc AI contour control) |
//! | G5.1 Q0 | takes back what G5.1 set |
//! | G8 P, G5 P | look-ahead on and off (Fanuc): sets no tolerance |
//!
//! LinuxCNC's G64 without P is "as fast as possible, however far from the path". No machine is
//! infinitely far: here it is the tolerance that the machine was found, or set, to run with. Its
//! naive CAM detector, which merges lines within Q (or else P) of one line, is in the path smoothing of
//! the feed plan, and at work where the machine file gives LinuxCNC's junctions.
//!
//! Sources differ on whether G187 P1 or P3 is rough: 1 rough, 2 medium, 3 finish is taken, and an E
//! beside it counts alone.
//!
//! Sources: LinuxCNC manual, G64, and what its interpreter does with P0 and without Q; Haas,
//! G187 and Setting 85; Fanuc, machining condition selecting function.

use thiserror::Error;

use crate::machine::Junction;
use crate::simulation::gcode::{LineNumber, Place, Severity};
use crate::simulation::toolpath::Toolpath;
use crate::simulation::toolpath::block::{AXIS_WORDS, CENTER_WORDS, bits};
use crate::simulation::toolpath::remark::{Code, Untraced};
use crate::simulation::toolpath::trace::Tracer;

/// The path mode from one segment on, up to that of the next entry.
#[derive(Clone, Debug, PartialEq)]
pub struct PathMode {
    /// The first segment it holds for.
    pub from: usize,
    /// Line of the program that set it.
    pub line: LineNumber,
    /// The words that set it, such as `G64 P0.01`.
    pub source: String,
    /// What holds at corners and along arcs.
    pub blending: Blending,
    /// Distance within which lines are to be merged into one, mm (Q of G64); none: the tolerance.
    pub merging: Option<f64>,
}

/// How far the motion may leave the programmed path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Blending {
    /// Not at all between segments: a full stop after each. Arcs keep the machine's tolerance.
    ExactStop,
    /// The machine's own tolerance.
    #[default]
    Machine,
    /// A contour tolerance, mm.
    Within(f64),
    /// A distance along the path before each corner at which its rounding may begin, mm.
    Distance(f64),
}

/// The most segments that moves kept back can become.
const MOST_KEPT_BACK: usize = 100;

/// The tolerances and distances that are taken at their word, mm.
const LENGTHS: std::ops::RangeInclusive<f64> = 1e-6..=10.0;

/// Words that keep a tolerance of their own; what one of them set another does not take back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keeper {
    /// G64 P, and other modes of the same group: a plain G64 takes it back.
    Group,
    /// A word of its own (G187, G5.1, a cycle): it holds through exact stop and G64.
    Own,
}

/// A word about the path mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PathWord {
    /// G61 and G61.1.
    ExactStop,
    /// G64.
    Continuous,
    /// G187.
    Smoothness,
    /// G5.1.
    ContourControl,
    /// G5 and G8.
    LookAhead,
}

/// What is in force.
#[derive(Default)]
pub(super) struct InForce {
    exact_stop: Option<String>,
    tolerance: Option<(Blending, String, Keeper)>,
    /// Q of G64, mm.
    merging: Option<f64>,
    /// Modes of the toolpath that were set while compensation kept moves back, by index.
    early: Vec<usize>,
}

impl InForce {
    pub(super) fn has_exact_stop(&self) -> bool {
        self.exact_stop.is_some() || matches!(self.tolerance, Some((Blending::ExactStop, ..)))
    }
}

/// Something about path modes that was not taken as a control would, or that the user may want to know.
/// Lengths are in mm.
#[derive(Clone, Debug, PartialEq, Error)]
pub(super) enum PathRemark {
    #[error(
        "{source_words} asks for {value} mm, which is not from 0.000001 to 10 mm: the tolerance of the machine holds"
    )]
    BadTolerance { source_words: String, value: f64 },
    #[error(
        "lines within Q (or P) of one line are merged by LinuxCNC after G64 P: this machine runs each line as written; with interpolator.junction_rule = acceleration_blend it merges them"
    )]
    NaiveCam,
    #[error(
        "{source_words} sets no tolerance from here on (on LinuxCNC: as fast as possible): that of the machine holds"
    )]
    NoTolerance { source_words: String },
    #[error("the tolerance of {source_words} is not known: that of the machine holds; set {keys}")]
    UnknownLevel { source_words: String, keys: &'static str },
    #[error("{source_words} is no level of the control: left out")]
    BadLevel { source_words: String },
    #[error(
        "{source_words} switches the control's look-ahead: it sets no tolerance, and look-ahead is taken as the machine has it"
    )]
    LookAhead { source_words: String },
}

impl PathRemark {
    pub(super) fn severity(&self) -> Severity {
        match self {
            PathRemark::BadTolerance { .. } | PathRemark::BadLevel { .. } => Severity::Error,
            PathRemark::NaiveCam | PathRemark::UnknownLevel { .. } => Severity::Warning,
            PathRemark::NoTolerance { .. } | PathRemark::LookAhead { .. } => Severity::Info,
        }
    }

    pub(super) fn is_said_once(&self) -> bool {
        !matches!(self, PathRemark::BadTolerance { .. } | PathRemark::BadLevel { .. })
    }
}

/// For every dialect. `place` is where the words stand, `source` the words as people write them;
/// lengths are in mm.
impl Tracer<'_> {
    /// A word of the group of G61 and G64 (G60, G641, G642 …): exact stop, or none from here on and
    /// this instead. A plain G64 takes it back.
    pub(super) fn set_path_mode(&mut self, place: Place, source: String, blending: Blending) {
        if blending == Blending::ExactStop {
            self.path_mode.exact_stop = Some(source);
        } else {
            self.path_mode.exact_stop = None;
            self.keep(place, blending, source, Keeper::Group);
        }
        self.note_path_mode(place.line);
    }

    /// A word that sets a tolerance of its own (G187, CYCLE832, cycle 32), which stays through exact
    /// stop and G64; [`Blending::Machine`] takes it back.
    pub(super) fn set_tolerance(&mut self, place: Place, source: String, blending: Blending) {
        self.keep(place, blending, source, Keeper::Own);
        self.note_path_mode(place.line);
    }

    /// A word that ends exact stop and says nothing about tolerances (a plain G64): what a word of
    /// the same group set is taken back, a tolerance by any other word holds on.
    pub(super) fn set_continuous_path(&mut self, place: Place, source: String) {
        self.path_mode.exact_stop = None;
        if matches!(self.path_mode.tolerance, Some((_, _, Keeper::Group)) | None) {
            if let Some((Blending::Within(_) | Blending::Distance(_), ..)) = self.path_mode.tolerance {
                self.remark_on_path(place, PathRemark::NoTolerance { source_words: source.clone() });
            }
            self.path_mode.tolerance = Some((Blending::Machine, source, Keeper::Group));
        }
        self.note_path_mode(place.line);
    }

    fn keep(&mut self, place: Place, blending: Blending, source: String, keeper: Keeper) {
        let blending = match blending {
            Blending::Within(value) | Blending::Distance(value) if !LENGTHS.contains(&value) => {
                let remark = PathRemark::BadTolerance { source_words: source.clone(), value };
                self.remark_on_path(place, remark);
                Blending::Machine
            }
            _ => blending,
        };
        self.path_mode.tolerance = Some((blending, source, keeper));
    }

    /// Puts down what is in force from the next segment on, where that is another mode.
    fn note_path_mode(&mut self, line: LineNumber) {
        let (blending, source) = match (&self.path_mode.exact_stop, &self.path_mode.tolerance) {
            (Some(source), _) => (Blending::ExactStop, source.as_str()),
            (None, Some((blending, source, _))) => (*blending, source.as_str()),
            (None, None) => (Blending::Machine, ""),
        };
        let merging = self.path_mode.merging;
        let from = self.toolpath.segments.len();
        let modes = &mut self.toolpath.path_modes;
        modes.pop_if(|last| last.from == from);
        let is_in_force = match modes.last() {
            Some(last) => last.blending == blending && last.source == source && last.merging == merging,
            None => blending == Blending::Machine && merging.is_none(),
        };
        if !is_in_force {
            if self.contour.keeps_back() {
                self.path_mode.early.push(modes.len());
            }
            modes.push(PathMode { from, line, source: source.to_string(), blending, merging });
        }
    }

    /// Moves on the modes that were set while compensation kept moves back: such a move comes out
    /// after the mode was noted, and is told by its line.
    pub(super) fn settle_path_modes(&mut self) {
        let Toolpath { segments, path_modes, .. } = &mut self.toolpath;
        let mut least = 0;
        for index in std::mem::take(&mut self.path_mode.early) {
            let Some(mode) = path_modes.get_mut(index) else { continue };
            let from = mode.from.max(least);
            let kept_back = segments.range(from..segments.len()).take(MOST_KEPT_BACK);
            mode.from = from + kept_back.take_while(|segment| segment.line < mode.line).count();
            least = mode.from;
        }
    }

    fn remark_on_path(&mut self, place: Place, remark: PathRemark) {
        self.remarks.add(place, Untraced::PathMode(remark));
    }
}

/// The words of ISO dialects.
impl Tracer<'_> {
    /// Runs a path word of the block; false where the word is another control's, with the axis words
    /// of the block as its own. `owns_p` is false where another word of the block takes P.
    pub(super) fn path_word(&mut self, place: Place, word: PathWord, code: Code, owns_p: bool) -> bool {
        match word {
            PathWord::ExactStop => self.set_path_mode(place, code.to_string(), Blending::ExactStop),
            PathWord::Continuous => self.continuous(place, code, owns_p),
            PathWord::Smoothness => self.smoothness(place, code),
            // With axis words G5 and G5.1 are splines of LinuxCNC, or name the axes to be smoothed.
            PathWord::ContourControl | PathWord::LookAhead
                if self.given.has(AXIS_WORDS | CENTER_WORDS) && !self.given.has(bits(b"Q")) =>
            {
                return false;
            }
            PathWord::ContourControl => {
                // They name the axes to be smoothed.
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

    /// G64, G64 P Q.
    fn continuous(&mut self, place: Place, code: Code, owns_p: bool) {
        let p = if owns_p { self.given.take(b'P') } else { None };
        let q = if owns_p { self.given.take(b'Q') } else { None };
        let merging = q.map(|q| q * self.modal.unit).filter(|q| *q == 0.0 || LENGTHS.contains(q));
        self.path_mode.merging = merging;
        let source = words(code, 'P', p);
        match p {
            Some(p) if p != 0.0 => {
                self.set_path_mode(place, source, Blending::Within(p * self.modal.unit));
                let merges = self.machine.interpolator.junction == Junction::AccelerationBlend
                    || self.machine.interpolator.path_smoothing.is_some();
                if q != Some(0.0) && !merges {
                    self.remark_on_path(place, PathRemark::NaiveCam);
                }
            }
            _ => self.set_continuous_path(place, source),
        }
    }

    /// G187 P E.
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

    /// G5.1 Q R.
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

    /// The tolerance of a level of the control, where the machine file says it.
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

/// A G word with the word beside it, where there is one.
fn words(code: Code, letter: char, value: Option<f64>) -> String {
    value.map_or_else(|| code.to_string(), |value| format!("{code} {letter}{value}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use crate::simulation::gcode::read;
    use crate::simulation::toolpath::trace;

    fn blendings(program: &str, machine: &Machine) -> Vec<(usize, Blending)> {
        let modes = trace(&read(program.as_bytes()), machine).path_modes;
        modes.into_iter().map(|mode| (mode.from, mode.blending)).collect()
    }

    #[test]
    fn levels_are_those_of_the_machine() {
        let mut machine = Machine::default();
        machine.path_modes.finish = Some(0.002);
        (machine.path_modes.level_1, machine.path_modes.level_10) = (Some(0.1), Some(0.01));
        let found =
            blendings("G1 F1 X1\nG187 P3\nX2\nG187 P1\nX3\nG5.1 Q1 R1\nX4\nG5.1 Q1 R10\nX5", &machine);
        let within = Blending::Within;
        assert_eq!(found, [(1, within(0.002)), (2, Blending::Machine), (3, within(0.1)), (4, within(0.01))]);
    }

    #[test]
    fn a_mode_is_put_down_once_and_only_where_it_changes_something() {
        let machine = Machine::default();
        assert_eq!(blendings("G64\nG1 F1 X1\nG61\nG64\nX2\nG64 P0\nX3", &machine), []);
        let twice = "G64 P.1\nG1 F1 X1\nG64 P.1\nX2\nG64 P.2\nG64 P.1\nX3";
        assert_eq!(blendings(twice, &machine), [(0, Blending::Within(0.1))]);
    }

    #[test]
    fn a_tolerance_of_its_own_word_outlives_exact_stop_and_g64() {
        let program = "G187 E.02\nG1 F1 X1\nG61\nX2\nG64\nX3\nG187\nX4";
        let toolpath = trace(&read(program.as_bytes()), &Machine::default());
        let sources: Vec<&str> = toolpath.path_modes.iter().map(|mode| mode.source.as_str()).collect();
        assert_eq!(sources, ["G187 E0.02", "G61", "G187 E0.02", "G187"]);
        let stops: Vec<bool> = toolpath.segments.iter().map(|segment| segment.exact_stop).collect();
        assert_eq!(stops, [false, true, false, false]);
    }
}
