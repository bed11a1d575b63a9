//! Execution of the words of one family of controls.

use crate::simulation::gcode::{Dialect, Place};
use crate::simulation::interpreter::block::{AXIS_WORDS, Block, UNMODELLED_WORDS, bits};
use crate::simulation::interpreter::bounds::MAX_HOLES;
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::frame::ADDITIONAL;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::rotary::ROTARY_WORDS;
use crate::simulation::interpreter::state::{Interpreter, Request};
use crate::simulation::interpreter::vendor_codes::{SETTINGS, VendorCode, VendorModal};
use crate::simulation::interpreter::words::Special;
use crate::simulation::toolpath::Point;

impl Interpreter<'_> {
    /// Reads a G word that acts before the axis words.
    pub(crate) fn vendor_g_word(
        &mut self,
        block: Block,
        place: Place,
        code: Code,
        word: VendorModal,
        request: &mut Request,
    ) {
        let h = block.words.iter().rfind(|word| word.letter == b'H').map(|word| word.value);
        match word {
            VendorModal::OffsetByH => match h {
                Some(number) if (0.0..=1000.0).contains(&number) && number.fract() == 0.0 => {
                    let number = number as u16;
                    let number = if number <= ADDITIONAL { number } else { ADDITIONAL + number };
                    if code.value == 16.0 {
                        self.vendor.offset_after = Some(self.frame.work_offset);
                    }
                    self.select_work_offset(code, place, number);
                }
                _ => {
                    let what = "needs H with the number of a work offset: left out";
                    self.remarks.add(place, TraceRemark::Unsupported { code, what });
                }
            },
            VendorModal::OffsetByCode => {
                self.select_work_offset(code, place, ADDITIONAL + code.value as u16 - 109);
            }
            VendorModal::LengthByH if code.value == 53.0 => {
                request.tool_length = Some(Code { letter: 'G', value: 49.0 });
            }
            VendorModal::LengthByH => request.tool_length = Some(code),
            VendorModal::RigidTap(tenths) => {
                self.begin_cycle(code, tenths);
                self.cycle.m_word(Some(29));
            }
            VendorModal::NotModelled(name, what) => {
                self.remarks.add(place, TraceRemark::Statement { name, what });
                request.has_foreign_axis_words = true;
            }
        }
    }

    /// Runs a word that uses the axis words of its block.
    pub(crate) fn vendor_word(&mut self, block: Block, word: VendorCode, code: Code) {
        match word {
            VendorCode::Unsupported(what) => {
                self.remarks.add(block.place(), TraceRemark::Unsupported { code, what })
            }
            VendorCode::BoltHoles => self.bolt_holes(block, code),
            VendorCode::KeepReference => {
                self.vendor.kept[usize::from(code.value > 29.0)] = Some(self.canonical.position);
            }
            VendorCode::FromOneSide => {
                let what = "positioning from one side: the overrun and the return are missing from the time";
                self.remarks.add(block.place(), TraceRemark::Statement { name: "G60", what });
                if let Some(target) = self.target(block) {
                    self.uncompensated(|interpreter| interpreter.rapid_to(block, target));
                }
            }
            VendorCode::ReturnLevel => {
                let normal = self.canonical.plane.axes()[2];
                let Some(value) = self.given.get(b"XYZ"[normal]) else {
                    let what = "needs the height that cycles return to: left out";
                    self.remarks.add(block.place(), TraceRemark::Unsupported { code, what });
                    return;
                };
                let height =
                    self.frame.coordinate_at(&self.canonical.position, normal, value * self.modal.unit);
                if self.is_within_reach(block, char::from(b"XYZ"[normal]), height) {
                    self.vendor.return_level = Some(height);
                }
            }
            VendorCode::OneTouchChange if self.given.has(bits(b"T")) => {
                self.uncompensated(|interpreter| interpreter.go_to_work(block))
            }
            VendorCode::OneTouchChange => self.change_frame(block, Special::Unmirror, code),
        }
    }

    /// Runs the tool change of G100, which comes before the M words of its block.
    pub(crate) fn one_touch_change(&mut self, block: Block, special: Option<(Special, Code)>) {
        let is_requested = matches!(special, Some((Special::Vendor(VendorCode::OneTouchChange), _)));
        if is_requested && self.given.has(bits(b"T")) {
            self.change_tool(block);
        }
    }

    /// Moves after a tool change to the destination of the axis words: first above the work, then down to it.
    fn go_to_work(&mut self, block: Block) {
        let Some(target) = self.target(block) else { return };
        self.read_rotary_words(block);
        let mut above = target;
        above.z = self.canonical.position.z;
        self.rapid_to(block, above);
        self.rapid_to(block, target);
        self.turn_alone(block, true);
    }

    /// Drops the words of a block that belong to a setting.
    pub(crate) fn leave_out_settings(&mut self, block: Block) {
        let is_possible =
            matches!(self.dialect, Dialect::Iso | Dialect::LinuxCnc | Dialect::Grbl | Dialect::Mach);
        let Some(first) = block.words.first().filter(|word| is_possible && word.letter == b'M') else {
            return;
        };
        let is_setting = SETTINGS.iter().any(|number| f64::from(*number) == first.value);
        let has_motion = || block.words.iter().any(|word| word.letter == b'G');
        if is_setting && self.given.has(AXIS_WORDS | UNMODELLED_WORDS | ROTARY_WORDS) && !has_motion() {
            let code = Code { letter: 'M', value: first.value };
            self.remarks.add(block.place(), TraceRemark::Setting { code });
            self.given.clear();
        }
    }

    /// Reads an M word of one family; returns `true` if it causes no stop of the machine.
    pub(crate) fn vendor_m_word(&mut self, number: Option<u32>) -> bool {
        let is_return = self.dialect == Dialect::Okuma && matches!(number, Some(52..=54));
        if is_return {
            self.vendor.returns_by = number;
        }
        is_return
    }

    /// Returns `true` if an M word ends the program.
    pub(crate) fn is_end(&mut self, block: Block, number: Option<u32>) -> bool {
        if self.dialect == Dialect::Mach && number == Some(47) {
            let what = "the program repeats for ever: one run is timed";
            self.remarks.add(block.place(), TraceRemark::Statement { name: "M47", what });
            return true;
        }
        matches!(number, Some(2 | 30))
    }

    /// Ends the words that hold for one block alone.
    pub(crate) fn end_vendor_words(&mut self) {
        if let Some(number) = self.vendor.offset_after.take() {
            self.frame.select_work_offset(number);
        }
    }

    /// Runs G70 to G72: a hole of the cycle in force at each place of a pattern about X Y.
    fn bolt_holes(&mut self, block: Block, code: Code) {
        let words = [b'I', b'J', b'K', b'L'].map(|letter| self.given.take(letter));
        let (Some(distance), Some(count)) = (words[0], words[3]) else {
            self.remarks.add(block.place(), TraceRemark::UnknownG { code });
            return;
        };
        let what = match () {
            () if !self.cycle.is_active() => "no cycle is in force: no holes are made",
            () if !(1.0..=MAX_HOLES).contains(&count.abs()) => "L is no number of holes: none is made",
            () if code.value == 71.0 && words[2].is_none() => "K is missing: no holes are made",
            () => "",
        };
        let Some(mut center) = self.target(block).filter(|_| what.is_empty()) else {
            if !what.is_empty() {
                self.remarks.add(block.place(), TraceRemark::Unsupported { code, what });
            }
            return;
        };
        let [a, b, normal] = self.canonical.plane.axes();
        center[normal] = self.canonical.position[normal];
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
