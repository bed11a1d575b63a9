//! What SINUMERIK programs say beyond ISO: statements, frames, poles, tolerances.
//!
//! - `TRANS`, `ROT`, `SCALE`, `MIRROR` put a frame in place of all that are programmed; with an A
//!   before them they add to it. Without words they take all back. `ROT` turns by RPL in the plane
//!   in force, or about X, Y and Z one after the other.
//! - `SUPA`, G53 and G153 take the words of their block in machine coordinates.
//! - G110, G111 and G112 set the pole of AP and RP, from the position, the origin and the last pole.
//! - G60 and G9 stop at the end of a move; G64 does not; G641 begins a rounding ADIS before a corner;
//!   G642 to G645 and `CYCLE832` keep a contour tolerance.
//! - G70 and G71 give the unit of lengths, pitches among them, and leave feeds in that of the machine, which is
//!   taken as metric; G700 and G710 give the unit of feeds too.
//! - Modal calls, drilling cycles and patterns of holes are those of the modules below.
//! - G33, G331 and G332 run at the pitch times the spindle speed, G63 at F.
//!
//! Not modelled, and said: swivelled planes (`CYCLE800`), orientation transformations (`TRAORI`),
//! splines, compressors, milling cycles, measuring.
//!
//! Source: SINUMERIK 840D sl, Programming Manual Fundamentals and Job Planning, 2013.

mod cycle;
mod deep;
mod points;
mod positions;
mod variables;
mod words;

pub(super) use cycle::Drilling;
pub(super) use words::{SiemensWord, meaning};

use crate::machine::AXES;
use crate::simulation::gcode::{SIEMENS_STATEMENTS, Word, address};
use crate::simulation::toolpath::block::{AXIS_WORDS, Block, POLAR_WORDS};
use crate::simulation::toolpath::feed_mode::FEEDRATES;
use crate::simulation::toolpath::frame::{Affine, Kind};
use crate::simulation::toolpath::motion::LONGEST_DWELL;
use crate::simulation::toolpath::path_mode::Blending;
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::remark::{Code, Untraced};
use crate::simulation::toolpath::trace::Tracer;
use crate::simulation::toolpath::turning::Sign;
use crate::simulation::toolpath::words::Special;
use crate::simulation::toolpath::{Curve, Motion, Point, StopCause, Vector};

/// What stays in force in SINUMERIK programs alone.
#[derive(Default)]
pub(super) struct Siemens {
    /// G70 or G71 is in force: F is in the machine's own unit of length.
    pub(super) leaves_feeds: bool,
    /// The pole of AP and RP in program coordinates, mm.
    pole: Point,
    /// The cycle of MCALL.
    pub(super) modal: Option<Drilling>,
    /// The last polar angle, rad, and radius, mm.
    polar: (f64, f64),
    /// The pitch of the last G331 or G33, mm.
    pitch: Option<f64>,
}

/// What the statements of a block ask for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Statement {
    /// TRANS and the like, by name.
    Frame(&'static str),
    /// MCALL, with the cycle that may follow.
    Modal(Option<&'static str>),
    /// A drilling cycle at the place.
    Cycle(&'static str),
    /// HOLES1, HOLES2, CYCLE801, CYCLE802.
    Holes(&'static str),
    /// CIP.
    Through,
    /// CT.
    Tangential,
    /// SUPA.
    MachineCoordinates,
    /// G110 to G112.
    Pole(u16),
    /// G331, or G332 for the way back, with the M word that says how the spindle turns after it; G33
    /// to G35 without.
    Thread(Option<u32>),
    /// G63.
    FloatingTap,
}

/// A rotation, scaling or mirror image in place of an earlier one.
const FRAME: Kind = Kind::Rotation;

impl Tracer<'_> {
    /// Takes in a statement word.
    pub(super) fn siemens_statement(&mut self, block: Block, word: &Word, asked: &mut Option<Statement>) {
        let name = SIEMENS_STATEMENTS.get(word.value as usize).copied().unwrap_or_default();
        let place = block.place_of(word);
        let argument = |index: u8| {
            block.words.iter().find(|word| word.letter == address::ARGUMENT + index).map(|word| word.value)
        };
        match name {
            "MCALL" => *asked = Some(Statement::Modal(None)),
            "CYCLE81" | "CYCLE82" | "CYCLE83" | "CYCLE84" | "CYCLE840" | "CYCLE85" | "CYCLE86" | "CYCLE87"
            | "CYCLE88" | "CYCLE89" => {
                *asked = Some(match asked {
                    Some(Statement::Modal(_)) => Statement::Modal(Some(name)),
                    _ => Statement::Cycle(name),
                });
            }
            "HOLES1" | "HOLES2" | "CYCLE801" | "CYCLE802" => *asked = Some(Statement::Holes(name)),
            "TRANS" | "ATRANS" | "ROT" | "AROT" | "SCALE" | "ASCALE" | "MIRROR" | "AMIRROR" => {
                *asked = Some(Statement::Frame(name));
            }
            "SUPA" => *asked = Some(Statement::MachineCoordinates),
            "CIP" => *asked = Some(Statement::Through),
            "CT" => *asked = Some(Statement::Tangential),
            "CYCLE832" => {
                let tolerance = argument(0).unwrap_or(0.0);
                // Units of the type: 0 off, 1 to 4 finish to rough.
                let is_off = argument(1).is_some_and(|kind| kind % 10.0 == 0.0) || tolerance == 0.0;
                let blending = if is_off { Blending::Machine } else { Blending::Within(tolerance * self.modal.unit) };
let source = format!("CYCLE832({tolerance})");
                // The cycle calls a continuous-path mode itself.
                if !is_off {
                    self.set_continuous_path(place, source.clone());
                }
                self.set_tolerance(place, source, blending);
            }
            "CYCLE800" => {
                let is_given = |mut arguments: std::ops::Range<u8>| arguments.any(|index| argument(index).unwrap_or(0.0) != 0.0);
                // X0, Y0, Z0; A, B, C; X1, Y1, Z1.
                let what = if is_given(7..10) {
                    "a swivelled plane is not modelled: lengths in it are right, the time to swivel and the moves to the next plane are not"
                } else if is_given(4..7) || is_given(10..13) {
                    "the shift of its origin is not modelled: the first move after it is too short or too long"
                } else {
                    return;
                };
                self.remarks.add(place, Untraced::Statement { name, what });
            }
            "TRAORI" => self.remarks.add(place, Untraced::Statement { name, what: "the path of the tool tip and its feed are taken as written; the movement of the head is not modelled" }),
            "TRACYL" | "TRANSMIT" => self.remarks.add(place, Untraced::Statement { name, what: "the transformation is not modelled: moves are taken as written" }),
            "COMPON" | "COMPCURV" | "COMPCAD" => self.remarks.add(place, Untraced::Statement { name, what: "the compressor, which joins short blocks, is not modelled: each block is run as written" }),
            "ASPLINE" | "BSPLINE" | "CSPLINE" | "POLY" | "INVCW" | "INVCCW" | "OEMIPO1" => self.remarks.add(place, Untraced::Curve { name }),
            "MEAS" | "MEAW" | "CYCLE977" | "CYCLE978" | "CYCLE979" | "CYCLE998" => self.remarks.add(place, Untraced::Statement { name, what: "measuring is not modelled: its moves and its time are missing" }),
            "DIAMON" | "DIAM90" => {
                self.turning.note(Sign::Diameters, block.line, || name.to_string());
                self.remarks.add(place, Untraced::Statement { name, what: "X in diameters is not modelled: moves are taken as written" });
            }
            "CYCLE92" | "CYCLE93" | "CYCLE94" | "CYCLE95" | "CYCLE96" | "CYCLE97" | "CYCLE98" | "CYCLE99"
            | "CYCLE930" | "CYCLE940" | "CYCLE950" | "CYCLE951" | "CYCLE952" => {
                self.turning.note(Sign::TurningCycle, block.line, || name.to_string());
            }
            name if name.starts_with("POCKET") || name.starts_with("SLOT") || name == "LONGHOLE" || (name.starts_with("CYCLE") && name != "CYCLE62") => {
                self.remarks.add(place, Untraced::MillingCycle { name });
            }
            "A3" => self.remarks.add(place, Untraced::Statement { name: "A3, B3, C3, LEAD, TILT", what: "the direction of the tool is not modelled: the path of its tip is taken as written, the turning of the head is not timed" }),
            "WHEN" => self.remarks.add(place, Untraced::Statement { name: "WHEN, WHENEVER, EVERY, DO", what: "synchronized actions are not modelled: left out" }),
            "$P_UIFR" => self.remarks.add(place, Untraced::Statement { name: "$P_UIFR and the like", what: "frames by system variables are not applied: moves to and from the offset are too short or too long" }),
            "OFFN" => self.remarks.add(place, Untraced::Statement { name, what: "the allowance is not modelled: the path is taken without it" }),
            "FZ" => self.remarks.add(place, Untraced::Statement { name, what: "a feed per tooth needs the number of teeth: F in force is taken" }),
            "POS" => self.remarks.add(place, Untraced::Statement { name: "POS, POSA", what: "positioning axes are not modelled: their moves are missing from the time" }),
            "X2" => self.remarks.add(place, Untraced::Statement { name: "axes with a number beyond 1", what: "only X, Y, Z, A, B and C are modelled: their moves are missing from the time" }),
            "ROTS" | "AROTS" | "TOROT" | "PAROT" => self.remarks.add(place, Untraced::Statement { name, what: "this frame is not modelled: coordinates are taken as written" }),
            _ => {}
        }
    }

    /// Runs what the statements of a block asked for.
    pub(super) fn siemens_act(&mut self, block: Block, statement: Statement) {
        match statement {
            Statement::Frame(name) => self.siemens_frame(block, name),
            Statement::Modal(None) => self.siemens.modal = None,
            Statement::Modal(Some(name)) => self.siemens.modal = self.siemens_drilling(block, name),
            Statement::Cycle(name) => {
                if let Some(drilling) = self.siemens_drilling(block, name) {
                    self.siemens_hole(block, &drilling);
                }
            }
            Statement::Holes(name) => self.siemens_holes(block, name),
            Statement::Through => self.arc_through(block),
            Statement::Tangential => self.tangential_arc(block),
            Statement::Pole(code) => self.set_pole(block, code),
            Statement::Thread(turn) => self.thread_stroke(block, turn),
            Statement::FloatingTap => {
                self.exact_stop = true;
                if let Some(target) = self.target(block) {
                    self.feed_to(block, target);
                }
            }
            Statement::MachineCoordinates => {
                let code = Code { letter: 'G', value: 53.0 };
                self.special(block, Special::MachineCoordinates, code);
            }
        }
    }

    /// TRANS, ROT, SCALE, MIRROR, and with an A before them.
    fn siemens_frame(&mut self, block: Block, name: &'static str) {
        let unit = self.modal.unit;
        let value = |tracer: &Self, axis: char| tracer.given.get(axis as u8);
        let (is_added, kind) = match name.strip_prefix('A') {
            Some(kind) => (true, kind),
            None => (false, name),
        };
        if !is_added {
            self.frame.unset(FRAME);
        }
        let values = AXES.map(|axis| value(self, axis));
        let operation = match kind {
            "TRANS" => {
                let shift = Vector::from(values.map(|value| value.unwrap_or(0.0) * unit));
                if !self.is_within_reach(block, 'X', shift.amax()) {
                    return;
                }
                Affine::shift(shift)
            }
            "SCALE" => {
                let factors = values.map(|factor| factor.unwrap_or(1.0));
                if !factors.iter().all(|factor| (1e-6..=1e6).contains(&factor.abs())) {
                    self.remarks.add(block.place(), Untraced::BadScale);
                    return;
                }
                Affine::scaling(Point::origin(), factors)
            }
            "MIRROR" => Affine::mirror(values.map(|value| value.map(|_| 0.0))),
            _ => self.siemens_rotation(values),
        };
        self.frame.compose(FRAME, operation);
    }

    /// By RPL in the plane in force, or about Z, Y and X in turn (RPY angles).
    fn siemens_rotation(&self, values: [Option<f64>; 3]) -> Affine {
        if let Some(angle) = self.given.get(address::PLANE_ANGLE) {
            return Affine::rotation(self.modal.plane, Point::origin(), angle.to_radians());
        }
        let [x, y, z] = values.map(|value| value.unwrap_or(0.0).to_radians());
        let about = |plane, angle| Affine::rotation(plane, Point::origin(), angle);
        about(Plane::Xy, z).after(&about(Plane::Zx, y)).after(&about(Plane::Yz, x))
    }

    /// G331, G332 and G33: feed is the pitch (I, J or K of the axis) times the spindle speed.
    fn thread_stroke(&mut self, block: Block, turn: Option<u32>) {
        let pitch = b"IJK".iter().find_map(|letter| self.given.get(*letter));
        if let Some(pitch) = pitch {
            self.siemens.pitch = Some(pitch.abs() * self.modal.unit);
        }
        let speed = self.given.get(b'S').or(self.functions.speed);
        let Some(target) = self.target(block) else { return };
        let length = (target - self.position).norm();
        match self.siemens.pitch.zip(speed).map(|(pitch, speed)| pitch * speed / 60.0) {
            Some(feedrate) if FEEDRATES.contains(&feedrate) => {
                self.exact_stop |= turn.is_some();
                self.push(block, target, Curve::Line, length, Motion::Feed { feedrate });
                if let Some(turn) = turn {
                    self.spindle_stop(block, turn);
                }
            }
            _ => {
                self.remarks.add(block.place(), Untraced::NoTapFeed);
                self.feed_to(block, target);
            }
        }
    }

    /// G4 F (s) and G4 S (turns of the spindle).
    pub(super) fn dwell_by_feed(&mut self, block: Block) {
        let given_as =
            |letter: u8| block.words.iter().rfind(|word| word.letter == letter).map(|word| word.value);
        let seconds = match (given_as(b'F'), given_as(b'S')) {
            (Some(seconds), _) => seconds,
            (None, Some(turns)) => match self.functions.speed.filter(|speed| 0.0 < *speed) {
                Some(speed) => 60.0 * turns / speed,
                None => {
                    let what = "turns of a spindle whose speed is unknown: no dwell";
                    self.remarks.add(block.place(), Untraced::Statement { name: "G4 S", what });
                    return;
                }
            },
            (None, None) => {
                self.remarks.add(block.place(), Untraced::NoDwellTime);
                return;
            }
        };
        if (0.0..=LONGEST_DWELL).contains(&seconds) {
            self.stop(block, StopCause::Dwell { seconds });
        } else {
            self.remarks.add(block.place(), Untraced::BadDwell { seconds });
        }
    }

    /// Makes the hole of a modal call after a move.
    pub(super) fn siemens_after_move(&mut self, block: Block) {
        self.check_angle(block);
        let moves = self.given.has(AXIS_WORDS | POLAR_WORDS);
        if let (true, Some(drilling)) = (moves, self.siemens.modal) {
            self.siemens_hole(block, &drilling);
        }
    }
}

#[cfg(test)]
mod tests;
