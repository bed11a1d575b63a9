//! What SINUMERIK programs say beyond ISO: statements, frames, poles, tolerances.
//!
//! - `TRANS`, `ROT`, `SCALE`, `MIRROR` put a frame in place of all that are programmed; with an A
//!   before them they add to it. Without words they take all back. `ROT` turns by RPL in the plane
//!   in force, or about X, Y and Z one after the other.
//! - `SUPA`, G53 and G153 take the words of their block in machine coordinates.
//! - G110, G111 and G112 set the pole of AP and RP, from the position, the origin and the last pole.
//! - G60 and G9 stop at the end of a move; G64 does not; G641 begins a rounding ADIS before a corner;
//!   G642 to G645 and `CYCLE832` keep a contour tolerance.
//! - Modal calls and drilling cycles are those of the cycle module.
//!
//! Not modelled, and said: swivelled planes (`CYCLE800`), orientation transformations (`TRAORI`),
//! splines, compressors, milling cycles, measuring.
//!
//! Source: SINUMERIK 840D sl, Programming Manual Fundamentals and Job Planning, 2013.

mod cycle;
mod words;

pub(super) use cycle::Drilling;
pub(super) use words::{SiemensWord, meaning};

use crate::machine::AXES;
use crate::simulation::gcode::{Dialect, SIEMENS_STATEMENTS, Word, address};
use crate::simulation::toolpath::block::{AXIS_WORDS, Block, POLAR_WORDS};
use crate::simulation::toolpath::frame::{Affine, Kind};
use crate::simulation::toolpath::motion::LONGEST_DWELL;
use crate::simulation::toolpath::path_mode::Blending;
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::remark::{Code, Untraced};
use crate::simulation::toolpath::trace::Tracer;
use crate::simulation::toolpath::words::Special;
use crate::simulation::toolpath::{Arc, Curve, Motion, Point, StopCause, Vector};

/// What stays in force in SINUMERIK programs alone.
#[derive(Default)]
pub(super) struct Siemens {
    /// The pole of AP and RP in program coordinates, mm.
    pole: Point,
    /// The cycle of MCALL.
    pub(super) modal: Option<Drilling>,
    /// The last polar angle, rad, and radius, mm.
    polar: (f64, f64),
    /// The pitch of the last G331, mm.
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
    /// HOLES1, HOLES2.
    Holes(&'static str),
    /// CIP.
    Through,
    /// CT.
    Tangential,
    /// SUPA.
    MachineCoordinates,
    /// G110 to G112.
    Pole(u16),
    /// G331, or G332 for the way back.
    Tap(bool),
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
            "HOLES1" | "HOLES2" => *asked = Some(Statement::Holes(name)),
            "TRANS" | "ATRANS" | "ROT" | "AROT" | "SCALE" | "ASCALE" | "MIRROR" | "AMIRROR" => {
                *asked = Some(Statement::Frame(name));
            }
            "SUPA" => *asked = Some(Statement::MachineCoordinates),
            "CIP" => *asked = Some(Statement::Through),
            "CT" => *asked = Some(Statement::Tangential),
            "CYCLE832" => {
                let tolerance = argument(0).unwrap_or(0.0);
                let is_off = argument(1) == Some(0.0) || tolerance == 0.0;
                let blending = if is_off { Blending::Machine } else { Blending::Within(tolerance * self.modal.unit) };
let source = format!("CYCLE832({tolerance})");
                // The cycle calls a continuous-path mode itself.
                if !is_off {
                    self.set_continuous_path(place, source.clone());
                }
                self.set_tolerance(place, source, blending);
            }
            "CYCLE800" if block.words.iter().any(|word| address::ARGUMENT <= word.letter && word.value != 0.0) => {
                self.remarks.add(place, Untraced::Statement { name, what: "a swivelled plane is not modelled: moves are taken as written" });
            }
            "TRAORI" => self.remarks.add(place, Untraced::Statement { name, what: "the path of the tool tip and its feed are taken as written; the movement of the head is not modelled" }),
            "TRACYL" | "TRANSMIT" => self.remarks.add(place, Untraced::Statement { name, what: "the transformation is not modelled: moves are taken as written" }),
            "COMPON" | "COMPCURV" | "COMPCAD" => self.remarks.add(place, Untraced::Statement { name, what: "the compressor, which joins short blocks, is not modelled: each block is run as written" }),
            "ASPLINE" | "BSPLINE" | "CSPLINE" | "POLY" | "INVCW" | "INVCCW" | "OEMIPO1" => self.remarks.add(place, Untraced::Curve { name }),
            "MEAS" | "MEAW" | "CYCLE977" | "CYCLE978" | "CYCLE979" | "CYCLE998" => self.remarks.add(place, Untraced::Statement { name, what: "measuring is not modelled: its moves and its time are missing" }),
            name if name.starts_with("POCKET") || name.starts_with("SLOT") || name == "LONGHOLE" || (name.starts_with("CYCLE") && name != "CYCLE800") => {
                self.remarks.add(place, Untraced::MillingCycle { name });
            }
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
            Statement::Tap(is_way_in) => self.tap_stroke(block, is_way_in),
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

    /// G110 to G112.
    fn set_pole(&mut self, block: Block, code: u16) {
        let from = match code {
            110 => self.frame.to_program(&self.position),
            111 => Point::origin(),
            _ => self.siemens.pole,
        };
        let mut pole = from;
        for (axis, letter) in AXES.into_iter().enumerate() {
            let value = self.given.get(letter as u8).unwrap_or(0.0) * self.modal.unit;
            pole[axis] += value;
            if !self.is_within_reach(block, letter, pole[axis]) {
                return;
            }
        }
        self.siemens.pole = pole;
    }

    /// The program coordinates in the plane that AP and RP mean, mm.
    pub(super) fn siemens_polar(&mut self) -> Option<[(usize, f64); 2]> {
        if self.dialect != Dialect::Siemens {
            return None;
        }
        let (angle, radius) = (self.given.get(address::POLAR_ANGLE), self.given.get(address::POLAR_RADIUS));
        if angle.is_none() && radius.is_none() {
            return None;
        }
        let polar = &mut self.siemens.polar;
        polar.0 = angle.map_or(polar.0, f64::to_radians);
        polar.1 = radius.map_or(polar.1, |radius| radius * self.modal.unit);
        let ([a, b, _], (angle, radius)) = (self.modal.plane.axes(), *polar);
        let pole = self.siemens.pole;
        Some([(a, pole[a] + radius * angle.cos()), (b, pole[b] + radius * angle.sin())])
    }

    /// CIP: the arc through a point of its own, in any plane of the axes.
    fn arc_through(&mut self, block: Block) {
        let Some(end) = self.target(block) else { return };
        let mut middle = self.frame.to_program(&self.position);
        for (axis, address) in
            [address::MIDDLE_X, address::MIDDLE_Y, address::MIDDLE_Z].into_iter().enumerate()
        {
            if let Some(value) = self.given.get(address) {
                let value = value * self.modal.unit;
                middle[axis] = if self.modal.is_incremental { middle[axis] + value } else { value };
            }
        }
        let middle = self.frame.to_machine(&middle);
        match Arc::through(self.position, middle, end) {
            Some(arc) => self.feed_along(block, end, arc),
            None => {
                self.remarks.add(block.place(), Untraced::NoArcThrough);
                self.feed_to(block, end);
            }
        }
    }

    /// CT: the arc that goes on in the direction of the last move.
    fn tangential_arc(&mut self, block: Block) {
        let Some(end) = self.target(block) else { return };
        let direction = self.toolpath.segments.last().map(|last| last.tangent(last.length));
        let normal = self.modal.plane.axes()[2];
        match direction.and_then(|direction| Arc::along(self.position, direction, end, normal)) {
            Some(arc) => self.feed_along(block, end, arc),
            None => self.feed_to(block, end),
        }
    }

    /// G331 and G332: feed is the pitch (I, J or K of the axis) times the spindle speed.
    fn tap_stroke(&mut self, block: Block, is_way_in: bool) {
        let pitch = b"IJK".iter().find_map(|letter| self.given.get(*letter));
        if let Some(pitch) = pitch {
            self.siemens.pitch = Some(pitch.abs() * self.modal.unit);
        }
        let speed = self.given.get(b'S').or(self.functions.speed);
        let Some(target) = self.target(block) else { return };
        let length = (target - self.position).norm();
        match self.siemens.pitch.zip(speed).map(|(pitch, speed)| pitch * speed / 60.0) {
            Some(feedrate) if (1e-6..=1e6).contains(&feedrate) => {
                self.exact_stop = true;
                self.push(block, target, Curve::Line, length, Motion::Feed { feedrate });
                let cause = self.turn_spindle(block, if is_way_in { 4 } else { 3 });
                self.stop(block, cause);
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
            (None, Some(turns)) => 60.0 * turns / self.functions.speed.unwrap_or(f64::NAN),
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

    /// The radius of CR, or that which AR gives with both ends, in the program's unit; negative for
    /// the longer arc.
    pub(super) fn siemens_radius(&self, (start, end): (Point, Point)) -> Option<f64> {
        let opening = self.given.get(address::OPENING_ANGLE).filter(|angle| (1e-6..360.0).contains(angle));
        let by_angle = opening.map(|degrees| {
            let [a, b, _] = self.modal.plane.axes();
            let chord = (end[a] - start[a]).hypot(end[b] - start[b]) / self.modal.unit;
            let radius = 0.5 * chord / (0.5 * degrees.to_radians()).sin();
            if 180.0 < degrees { -radius } else { radius }
        });
        self.given.get(address::CIRCLE_RADIUS).or(by_angle)
    }

    /// Makes the hole of a modal call after a move.
    pub(super) fn siemens_after_move(&mut self, block: Block) {
        let moves = self.given.has(AXIS_WORDS | POLAR_WORDS);
        if let (true, Some(drilling)) = (moves, self.siemens.modal) {
            self.siemens_hole(block, &drilling);
        }
    }
}

#[cfg(test)]
mod tests;
