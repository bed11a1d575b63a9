//! G and M words that one family of controls has for itself, and those that are known, not run.
//!
//! ```text
//! Haas    G70 I J L        holes on a circle of radius I, from the angle J on, L of them
//!         G71 I J K L      the same on an arc, K degrees from hole to hole
//!         G72 I J L        holes on a line at the angle J, I from hole to hole, the first here
//!         G100 G101 X      mirror off and on        G110 … G129   work offsets, G154 P1 … P20
//!         G84.2 G84.3      rigid tapping, right and left hand
//! Fanuc   G60 X Y Z        positioning from one side: the overrun and return are not timed
//! Brother G100 T X Y Z     change to the tool, then in rapid to X Y and from there to Z; T tells it from Haas
//! NGC     G28.1 G30.1      keep the position as the reference point of G28, G30
//! Mach    M47              begin again: one run is timed
//!         G70, G71         inch and mm
//! Okuma   G15 Hn, G16 Hn   work offset n from here on, or in this block; H0 is the machine's zero
//!         G54 … G59 Hn     tool length, G53 none
//!         G71 Z, M53       cycles return to Z        M54   cycles return to R
//!         NCYL             to the place of the hole, and no hole
//!         G284             rigid tapping
//! ```
//!
//! Angles are in degrees, counter-clockwise from X. Each word of the second kind says what is
//! missing: the tool stays where it is.
//!
//! On controls of printers some M words set what the control does, axis by axis (`M201 X500 Y500`): where one
//! begins a block that has no G word, the other words of the block are its own.
//!
//! Okuma: M52 (return to the upper limit) needs the reference point of Z. That G80 stops the
//! spindle on some of its machines is not modelled.
//!
//! Sources: Haas, Mill Operator's Manual, G70 to G72; Yaskawa, YASNAC PC NC programming manual,
//! Sect. 4.1; LinuxCNC 2.9, G28; Okuma, post processors for OSP-E100M and OSP-P300 and the OSP-P300M
//! programming manual; Brother, CNC-C00 programming manual, G100.

use crate::simulation::gcode::{Dialect, Place, address};
use crate::simulation::toolpath::Point;
use crate::simulation::toolpath::block::{AXIS_WORDS, Block, UNMODELLED_WORDS, bits};
use crate::simulation::toolpath::frame::ADDITIONAL;
use crate::simulation::toolpath::remark::{Code, Untraced};
use crate::simulation::toolpath::rotary::ROTARY_WORDS;
use crate::simulation::toolpath::spline::Spline;
use crate::simulation::toolpath::trace::{Request, Tracer};
use crate::simulation::toolpath::words::{Meaning, Mode, NO_GROUP, Special};

/// A word of one family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Own {
    /// Left out with its axis words, for the reason given.
    Left(&'static str),
    /// G70 to G72.
    BoltHoles,
    /// G28.1 and G30.1.
    KeepReference,
    /// G60.
    FromOneSide,
    /// G71 Z.
    ReturnLevel,
    /// G100: with T the tool change and the way to the work in one, else the end of G101.
    OneTouchChange,
}

/// A word of one family that acts before the axis words of its block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OwnModal {
    /// G15 Hn and, for this block alone, G16 Hn.
    OffsetByH,
    /// G110 to G129.
    OffsetByCode,
    /// G53, and G54 to G59.
    LengthByH,
    /// A tapping cycle with the feed coupled to the spindle, of this number.
    RigidTap(u16),
    /// It has a say in what the control does that is not modelled: name and what.
    Said(&'static str, &'static str),
}

const PROBING: Own = Own::Left(
    "probing: where the contact is made is unknown, so the move is left out, its time is missing, and the tool stays where it is",
);
const MEASURING: Own = Own::Left("measuring cycle: not modelled, its moves are missing from the time");
const POCKET: Own = Own::Left("pocket: not modelled, its moves are missing from the time");
const THREAD: Own =
    Own::Left("threading (motion coupled to the spindle): not modelled, its moves are missing from the time");
const TAPPING_BY_PECKS: Own =
    Own::Left("tapping with chip breaking: not modelled, its holes are missing from the time");

/// Modal group and meaning of a G word, given ten times its number, where the dialect has one of its
/// own; none where ISO's holds.
pub(super) fn meaning(dialect: Dialect, tenths: u16) -> Option<(usize, Meaning)> {
    use Meaning::{Neutral, Transformation, TransformationAbout, WorkOffset};
    let own = |own| Some((0, Meaning::Special(Special::Own(own))));
    let modal = |group, word| Some((group, Meaning::Own(word)));
    match (dialect, tenths) {
        (Dialect::Siemens | Dialect::Klartext | Dialect::HeidenhainIso, _) => None,

        (Dialect::Okuma, 150 | 160) => modal(12, OwnModal::OffsetByH),
        (Dialect::Okuma, 530 | 540 | 550 | 560 | 570 | 580 | 590) => modal(8, OwnModal::LengthByH),
        (Dialect::Okuma, 710) => own(Own::ReturnLevel),
        (Dialect::Okuma, 2840) => modal(9, OwnModal::RigidTap(840)),
        (Dialect::Okuma, 2730 | 2830) => own(TAPPING_BY_PECKS),
        (Dialect::Okuma, 110) => Some((NO_GROUP, TransformationAbout("parallel shift and rotation"))),
        (Dialect::Okuma, 620) => Some((NO_GROUP, TransformationAbout("mirror image"))),
        (Dialect::Okuma, 680) => Some((NO_GROUP, TransformationAbout("conversion of coordinates"))),
        (Dialect::Okuma, 1310) => modal(
            NO_GROUP,
            OwnModal::Said("G131", "high-speed contouring is not modelled: the machine's tolerance holds"),
        ),

        (Dialect::LinuxCnc | Dialect::Iso, 52) => Some((1, Meaning::Motion(Mode::Spline(Spline::Nurbs)))),
        (Dialect::LinuxCnc | Dialect::Iso, 53) => Some((0, Meaning::Special(Special::NurbsEnd))),
        (Dialect::LinuxCnc | Dialect::Iso, 62) => {
            Some((1, Meaning::Motion(Mode::Spline(Spline::GivenKnots))))
        }
        (Dialect::LinuxCnc, 63) => Some((1, Meaning::NeutralAbout)),
        (Dialect::LinuxCnc, 70) => Some((NO_GROUP, Transformation("X words as diameters"))),
        (Dialect::LinuxCnc, 80) => Some((NO_GROUP, Neutral)),
        (Dialect::LinuxCnc | Dialect::Grbl, 281 | 301) => own(Own::KeepReference),
        (Dialect::Mach, 281 | 301) => own(Own::Left(
            "homing: where the switches are is unknown, so its moves are missing from the time and the tool stays where it is",
        )),
        (Dialect::Mach, 120 | 130) => own(POCKET),
        (Dialect::Mach, 700 | 710) => Some((6, Meaning::Inch(tenths == 700))),
        (_, 311..=313) => own(PROBING),
        (_, 320) => own(THREAD),

        (Dialect::Iso, 120 | 130 | 1500) => own(POCKET),
        (Dialect::Iso, 350 | 360 | 370 | 1360) => own(MEASURING),
        (Dialect::Iso, 270) => own(Own::Left("check of the reference point: the move to it is not timed")),
        (Dialect::Iso, 290) => {
            own(Own::Left("return from the reference point: not modelled, the tool stays where it is"))
        }
        (Dialect::Iso, 470) => own(Own::Left("engraving: not modelled, its moves are missing from the time")),
        (Dialect::Iso, 600) => own(Own::FromOneSide),
        (Dialect::Iso, 700 | 710 | 720) => own(Own::BoltHoles),
        (Dialect::Iso, 842) => modal(9, OwnModal::RigidTap(840)),
        (Dialect::Iso, 843) => modal(9, OwnModal::RigidTap(740)),
        (Dialect::Iso, 1000) => own(Own::OneTouchChange),
        (Dialect::Iso, 1010) => Some((NO_GROUP, Meaning::Special(Special::Mirror))),
        (Dialect::Iso, 1100 | 1110 | 1140..=1290) if tenths.is_multiple_of(10) => {
            modal(12, OwnModal::OffsetByCode)
        }
        (Dialect::Iso, 1030) => modal(
            NO_GROUP,
            OwnModal::Said(
                "G103",
                "the program's limit of look-ahead is not modelled; interpolator.look_ahead_blocks would limit it throughout",
            ),
        ),
        (Dialect::Okuma, 1540) => Some((12, WorkOffset)),
        _ => None,
    }
}

/// M words that set speeds, accelerations, steps and the like, as Marlin and RepRapFirmware number them.
const SETTINGS: [u16; 31] = [
    92, 201, 202, 203, 204, 205, 206, 207, 208, 209, 218, 220, 221, 301, 303, 304, 350, 425, 566, 569, 572,
    574, 584, 593, 665, 666, 851, 906, 907, 913, 914,
];

/// What these words keep from block to block.
#[derive(Default)]
pub(super) struct OwnState {
    /// The work offset to go back to after this block.
    offset_after: Option<u16>,
    /// G28.1 and G30.1, mm.
    kept: [Option<Point>; 2],
    /// G71, mm along the axis of the holes.
    return_level: Option<f64>,
    /// M52, M53 or M54.
    returns_by: Option<u32>,
}

/// The most holes of one pattern.
const MOST_HOLES: f64 = 10_000.0;

impl Tracer<'_> {
    /// Takes in a G word that acts before the axis words.
    pub(super) fn own_g_word(
        &mut self,
        block: Block,
        place: Place,
        code: Code,
        word: OwnModal,
        request: &mut Request,
    ) {
        let h = block.words.iter().rfind(|word| word.letter == b'H').map(|word| word.value);
        match word {
            OwnModal::OffsetByH => match h {
                Some(number) if (0.0..=1000.0).contains(&number) && number.fract() == 0.0 => {
                    let number = number as u16;
                    let number = if number <= ADDITIONAL { number } else { ADDITIONAL + number };
                    if code.value == 16.0 {
                        self.own.offset_after = Some(self.frame.work_offset);
                    }
                    self.take_work_offset(code, place, number);
                }
                _ => {
                    let what = "needs H with the number of a work offset: left out";
                    self.remarks.add(place, Untraced::Left { code, what });
                }
            },
            OwnModal::OffsetByCode => {
                self.take_work_offset(code, place, ADDITIONAL + code.value as u16 - 109);
            }
            OwnModal::LengthByH if code.value == 53.0 => {
                request.tool_length = Some(Code { letter: 'G', value: 49.0 });
            }
            OwnModal::LengthByH => request.tool_length = Some(code),
            OwnModal::RigidTap(tenths) => {
                self.begin_cycle(code, tenths);
                self.cycle.m_word(Some(29));
            }
            OwnModal::Said(name, what) => {
                self.remarks.add(place, Untraced::Statement { name, what });
                request.has_foreign_axis_words = true;
            }
        }
    }

    /// Runs a word that decides what its block does.
    pub(super) fn own_word(&mut self, block: Block, word: Own, code: Code) {
        match word {
            Own::Left(what) => self.remarks.add(block.place(), Untraced::Left { code, what }),
            Own::BoltHoles => self.bolt_holes(block, code),
            Own::KeepReference => {
                self.own.kept[usize::from(code.value > 29.0)] = Some(self.position);
            }
            Own::FromOneSide => {
                let what = "positioning from one side: the overrun and the return are missing from the time";
                self.remarks.add(block.place(), Untraced::Statement { name: "G60", what });
                if let Some(target) = self.target(block) {
                    self.uncompensated(|tracer| tracer.rapid_to(block, target));
                }
            }
            Own::ReturnLevel => {
                let normal = self.modal.plane.axes()[2];
                let Some(value) = self.given.get(b"XYZ"[normal]) else {
                    let what = "needs the height that cycles return to: left out";
                    self.remarks.add(block.place(), Untraced::Left { code, what });
                    return;
                };
                let height = self.frame.coordinate_at(&self.position, normal, value * self.modal.unit);
                if self.is_within_reach(block, char::from(b"XYZ"[normal]), height) {
                    self.own.return_level = Some(height);
                }
            }
            Own::OneTouchChange if self.given.has(bits(b"T")) => {
                self.uncompensated(|tracer| tracer.go_to_work(block))
            }
            Own::OneTouchChange => self.change_frame(block, Special::Unmirror, code),
        }
    }

    /// The tool change of G100, which comes before what the M words of its block ask for.
    pub(super) fn one_touch_change(&mut self, block: Block, special: Option<(Special, Code)>) {
        let is_asked_for = matches!(special, Some((Special::Own(Own::OneTouchChange), _)));
        if is_asked_for && self.given.has(bits(b"T")) {
            let cause = self.change_tool(block);
            self.stop(block, cause);
        }
    }

    /// From a tool change to where the axis words say: first beside the work, then down to it.
    fn go_to_work(&mut self, block: Block) {
        let Some(target) = self.target(block) else { return };
        self.take_rotary(block);
        let mut above = target;
        above.z = self.position.z;
        self.rapid_to(block, above);
        self.rapid_to(block, target);
        self.turn_alone(block, true);
    }

    /// Forgets the words of a block that are those of a setting.
    pub(super) fn leave_out_settings(&mut self, block: Block) {
        let is_possible =
            matches!(self.dialect, Dialect::Iso | Dialect::LinuxCnc | Dialect::Grbl | Dialect::Mach);
        let Some(first) = block.words.first().filter(|word| is_possible && word.letter == b'M') else {
            return;
        };
        let is_setting = SETTINGS.iter().any(|number| f64::from(*number) == first.value);
        let has_motion = || block.words.iter().any(|word| word.letter == b'G');
        if is_setting && self.given.has(AXIS_WORDS | UNMODELLED_WORDS | ROTARY_WORDS) && !has_motion() {
            let code = Code { letter: 'M', value: first.value };
            self.remarks.add(block.place(), Untraced::Setting { code });
            self.given.clear();
        }
    }

    /// Takes notice of an M word of one family; whether it is no stop of the machine.
    pub(super) fn own_m_word(&mut self, number: Option<u32>) -> bool {
        let is_return = self.dialect == Dialect::Okuma && matches!(number, Some(52..=54));
        if is_return {
            self.own.returns_by = number;
        }
        is_return
    }

    /// Whether an M word ends the program.
    pub(super) fn is_end(&mut self, block: Block, number: Option<u32>) -> bool {
        if self.dialect == Dialect::Mach && number == Some(47) {
            let what = "the program begins again for ever: one run is timed";
            self.remarks.add(block.place(), Untraced::Statement { name: "M47", what });
            return true;
        }
        matches!(number, Some(2 | 30))
    }

    /// Forgets what holds for one block alone.
    pub(super) fn end_own_words(&mut self) {
        if let Some(number) = self.own.offset_after.take() {
            self.frame.select_work_offset(number);
        }
    }

    /// The reference point of G28 or G30 on an axis, mm: what the program kept, or else the machine's.
    pub(super) fn reference_point(&mut self, block: Block, axis: usize, code: Code) -> Option<f64> {
        let kept = self.own.kept[usize::from(code.value > 29.0)];
        kept.map(|point| point[axis]).or_else(|| self.home(block, axis))
    }

    /// Where cycles return to by G71 and the M words of Okuma, mm along the axis of the holes; none
    /// where G98 and G99 hold.
    pub(super) fn return_by_m_word(&mut self, block: Block, normal: usize, reference: f64) -> Option<f64> {
        if self.dialect != Dialect::Okuma {
            return None;
        }
        let said = |what| Untraced::Statement { name: "M52, M53, M54", what };
        let height = match self.own.returns_by {
            Some(54) => return Some(reference),
            Some(53) => self.own.return_level,
            Some(_) => self.machine.axes[normal].home,
            None => None,
        };
        if height.is_none() {
            let what = "the height that cycles return to is not known (G71 Z with M53, or M54): they return to the height they began at";
            self.remarks.add(block.place(), said(what));
        }
        height.map(|height| height.max(reference))
    }

    /// NCYL: to the place of the hole, without a hole.
    pub(super) fn is_without_hole(&mut self, block: Block) -> bool {
        let is_so = self.dialect == Dialect::Okuma && self.given.has(bits(&[address::STATEMENT]));
        if is_so && let Some(mut target) = self.target(block) {
            let normal = self.modal.plane.axes()[2];
            target[normal] = self.position[normal];
            self.rapid_to(block, target);
        }
        is_so
    }

    /// G70 to G72: a hole of the cycle in force at each place of a pattern about X Y.
    fn bolt_holes(&mut self, block: Block, code: Code) {
        let words = [b'I', b'J', b'K', b'L'].map(|letter| self.given.take(letter));
        let (Some(distance), Some(count)) = (words[0], words[3]) else {
            self.remarks.add(block.place(), Untraced::UnknownG { code });
            return;
        };
        let what = match () {
            () if !self.cycle.is_active() => "no cycle is in force: no holes are made",
            () if !(1.0..=MOST_HOLES).contains(&count.abs()) => "L is no number of holes: none is made",
            () if code.value == 71.0 && words[2].is_none() => "K is missing: no holes are made",
            () => "",
        };
        let Some(mut center) = self.target(block).filter(|_| what.is_empty()) else {
            if !what.is_empty() {
                self.remarks.add(block.place(), Untraced::Left { code, what });
            }
            return;
        };
        let [a, b, normal] = self.modal.plane.axes();
        center[normal] = self.position[normal];
        let center = self.frame.to_program(&center);
        for letter in [b"XYZ"[a], b"XYZ"[b]] {
            self.given.take(letter);
        }
        let (distance, begin) = (distance * self.modal.unit, words[1].unwrap_or(0.0));
        let step = match code.value as u16 {
            70 => 360.0 / count.trunc() * distance.signum(),
            _ => words[2].unwrap_or(0.0),
        };
        let place = |index: usize| {
            let index = index as f64;
            let (along, degrees) = match code.value as u16 {
                72 => (distance * index, begin),
                _ => (distance.abs(), begin + step * index),
            };
            let (sin, cos) = degrees.to_radians().sin_cos();
            let mut place = center;
            place[a] += along * cos;
            place[b] += along * sin;
            place
        };
        let places: Vec<Point> =
            (0..count.abs() as usize).map(|index| self.frame.to_machine(&place(index))).collect();
        if places.iter().all(|place| self.is_within_reach(block, 'I', place.coords.amax())) {
            self.holes_at(block, &places);
        }
    }
}

#[cfg(test)]
mod tests;
