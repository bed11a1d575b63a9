//! The words that change the chain of coordinates.
//!
//! ```text
//! G54 … G59.3, G54.1 Pn, G154 Pn      work offset in force
//! G10 L2 Pn X… A… [R]                 its values; R its rotation in X Y (LinuxCNC); P0 the one in force,
//!                                     on Fanuc and Haas the one that adds to all
//! G10 L20 Pn X…                       LinuxCNC, grbl, Mach: the values that give the position these
//!                                     coordinates; Fanuc, Haas: the values of G54.1 Pn
//! G10 L1 Pn Z…                        length of tool n
//! G92 G92.1 G92.2 G92.3, G52          shifts
//! G68 X… Y… R…, G69                   rotation; without a centre about the position
//! G51 X… P… or I… J… K…, G50          scaling; without a centre about the position
//! G51.1 X…, G24 X…; G50.1 X…, G25     mirror at X…
//! G43 Hn, G44 Hn, G43.1 Z…, G43.2 Hn, G49   tool length
//! ```

use crate::machine::AXES;
use crate::simulation::gcode::{Dialect, Place};
use crate::simulation::interpreter::block::{AXIS_WORDS, Block, CENTER_WORDS, bits};
use crate::simulation::interpreter::bounds::{MAX_TOOL_NUMBER, SCALE_FACTORS};
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::frame::{ADDITIONAL, Affine, EXTERNAL, Kind, Shift};
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::rotary::ROTARY_AXES;
use crate::simulation::interpreter::state::{Family, Interpreter};
use crate::simulation::interpreter::words::Special;
use crate::simulation::toolpath::{Point, Vector};

/// Least whole factor without a decimal point that counts thousandths.
const MIN_THOUSANDTHS: f64 = 100.0;

impl Interpreter<'_> {
    /// Runs a word that changes the chain with the axis words of its block. The tool does not move.
    pub(crate) fn change_frame(&mut self, block: Block, special: Special, code: Code) {
        match special {
            Special::DataSetting => self.data_setting(block, code),
            Special::SetPosition => self.set_position(block),
            Special::LocalShift => self.local_shift(block),
            Special::ForgetShift => {
                self.frame.shift = Shift::default();
                self.frame.stored = Shift::default();
            }
            Special::SuspendShift => self.frame.shift = Shift::default(),
            Special::RestoreShift => self.frame.shift = self.frame.stored,
            Special::Rotate => self.rotate(block),
            Special::Scale => self.scale(block),
            Special::Mirror => self.mirror(block, true),
            Special::Unmirror => self.mirror(block, false),
            Special::ToolOffset => {
                let given = self.axis_values().map(Option::unwrap_or_default);
                self.frame.set_tool(Vector::from(given));
            }
            Special::Dwell
            | Special::Reference
            | Special::MachineCoordinates
            | Special::Probe
            | Special::Thread { .. }
            | Special::NurbsEnd
            | Special::Vendor(_) => {}
        }
        self.frame.refresh();
    }

    /// Runs G92.
    fn set_position(&mut self, block: Block) {
        let mut named = self.frame.to_program(&self.canonical.position);
        let mut shift = self.frame.shift;
        let is_turned = self.frame.turned().is_some();
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = self.given.get(letter as u8) else { continue };
            named[axis] = value * self.modal.unit;
            // An axis without a word keeps every digit of its shift.
            let moved = self.frame.shift_naming(&self.canonical.position, &named);
            if !self.is_within_reach(block, letter, moved.amax()) {
                return;
            }
            if is_turned {
                shift.linear = moved;
            } else {
                shift.linear[axis] = moved[axis];
            }
        }
        for (axis, value) in self.rotary_values() {
            shift.rotary[axis] += self.rotary.position[axis] - self.frame.rotary_coordinate(axis, value);
        }
        (self.frame.shift, self.frame.stored) = (shift, shift);
    }

    /// Runs G52. On LinuxCNC it and G92 share one shift.
    fn local_shift(&mut self, block: Block) {
        let mut local = match self.family {
            Family::Rs274 => self.frame.shift,
            Family::Fanuc => self.frame.local,
        };
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = self.given.get(letter as u8) else { continue };
            let shift = value * self.modal.unit;
            if self.is_within_reach(block, letter, shift) {
                local.linear[axis] = shift;
            }
        }
        for (axis, value) in self.rotary_values() {
            local.rotary[axis] = value;
        }
        match self.family {
            Family::Rs274 => (self.frame.shift, self.frame.stored) = (local, local),
            Family::Fanuc => self.frame.local = local,
        }
    }

    /// Runs G10.
    fn data_setting(&mut self, block: Block, code: Code) {
        let whole = |value: f64| (0.0..=1000.0).contains(&value) && value.fract() == 0.0;
        let number = self.given.get(b'P').filter(|value| whole(*value)).map(|value| value as u16);
        let setting = self.given.get(b'L').filter(|value| whole(*value)).map(|value| value as u16);
        match (setting, number, self.family) {
            (Some(2), Some(0), Family::Fanuc) => self.set_offset(block, EXTERNAL, false),
            (Some(2), Some(0), Family::Rs274) => self.set_offset(block, self.frame.work_offset, false),
            (Some(2), Some(n @ 1..=ADDITIONAL), _) => self.set_offset(block, n, false),
            (Some(20), Some(n @ 1..), Family::Fanuc) => self.set_offset(block, ADDITIONAL + n, false),
            (Some(20), Some(0), Family::Rs274) => self.set_offset(block, self.frame.work_offset, true),
            (Some(20), Some(n @ 1..=ADDITIONAL), Family::Rs274) => self.set_offset(block, n, true),
            (Some(1), Some(tool), _) if self.given.has(AXIS_WORDS) => {
                let tool = u32::from(tool);
                let mut length = self.frame.tool_lengths.get(&tool).copied().unwrap_or_default();
                for (axis, value) in self.axis_values().into_iter().enumerate() {
                    length[axis] = value.unwrap_or(length[axis]);
                }
                self.frame.tool_lengths.insert(tool, length);
            }
            (Some(12), Some(register), Family::Fanuc) if self.set_diameter(u32::from(register)) => {}
            _ => self.remarks.add(block.place(), TraceRemark::DataSetting { code }),
        }
    }

    /// Sets a work offset to the values of the block or, if `is_named`, so that the position has these values as
    /// coordinates.
    fn set_offset(&mut self, block: Block, number: u16, is_named: bool) {
        let mut offset = self.frame.work_offset_of(number).unwrap_or_default();
        if let Some(degrees) = self.given.get(b'R').filter(|_| self.family == Family::Rs274) {
            offset.rotation = degrees.to_radians();
        }
        let mut named = offset.origin.linear;
        let is_added = self.family == Family::Fanuc && self.modal.is_incremental;
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = self.given.get(letter as u8) else { continue };
            let value = value * self.modal.unit;
            if !self.is_within_reach(block, letter, value) {
                return;
            }
            named[axis] = if is_added { named[axis] + value } else { value };
        }
        if is_named {
            named = self.origin_naming(offset.origin.linear, offset.rotation, &named);
        }
        offset.origin.linear = named;
        for (axis, value) in self.rotary_values() {
            let shifts = self.frame.shift.rotary[axis] + self.frame.local.rotary[axis];
            let before = offset.origin.rotary[axis];
            offset.origin.rotary[axis] = match (is_named, is_added) {
                (true, _) => self.rotary.position[axis] - value - shifts,
                (false, true) => before + value,
                (false, false) => value,
            };
        }
        self.frame.set_work_offset(number, offset);
    }

    /// Returns the origin of a work offset that gives the position the coordinates `named` in the axes of the
    /// block's words; the other axes keep `origin`.
    fn origin_naming(&self, origin: Vector, rotation: f64, named: &Vector) -> Vector {
        let mut probe = self.frame.clone();
        let number = probe.work_offset;
        let mut offset = probe.work_offset_of(number).unwrap_or_default();
        (offset.origin.linear, offset.rotation) = (origin, rotation);
        probe.set_work_offset(number, offset);
        let mut program = probe.to_program(&self.canonical.position);
        for (axis, letter) in AXES.into_iter().enumerate() {
            if self.given.get(letter as u8).is_some() {
                program[axis] = named[axis];
            }
        }
        origin + (self.canonical.position - probe.to_machine(&program))
    }

    /// Runs G54 to G59.3, G54.1 Pn and G154 Pn.
    pub(crate) fn choose_work_offset(&mut self, code: Code, place: Place) {
        let tenths = (10.0 * code.value).round() as u16;
        let number = match tenths {
            541 | 1540 => match self.given.get(b'P') {
                Some(n) if (1.0..=1000.0).contains(&n) && n.fract() == 0.0 => ADDITIONAL + n as u16,
                _ => {
                    self.remarks.add(place, TraceRemark::NoOffsetNumber { code });
                    return;
                }
            },
            591..=593 => tenths - 584,
            _ => tenths / 10 - 53,
        };
        self.select_work_offset(code, place, number);
    }

    /// Selects the work offset with this number.
    pub(crate) fn select_work_offset(&mut self, code: Code, place: Place, number: u16) {
        let before = self.frame.work_offset;
        let is_known = |number: u16| self.frame.work_offset_of(number).is_some();
        let leaves_the_known = number != before && !(is_known(number) && is_known(before));
        if leaves_the_known && self.modal.has_work_offset && !self.modal.has_several_offsets {
            self.modal.has_several_offsets = true;
            self.remarks.add(place, TraceRemark::WorkOffsets { code });
        }
        self.modal.has_work_offset = true;
        self.frame.select_work_offset(number);
    }

    /// Returns the centre in the words of a block; without a word it is the position in that axis.
    fn named_center(&mut self, block: Block) -> Option<Point> {
        let mut center = self.frame.to_program(&self.canonical.position);
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = self.given.get(letter as u8) else { continue };
            center[axis] = value * self.modal.unit;
            if !self.is_within_reach(block, letter, center[axis]) {
                return None;
            }
        }
        Some(center)
    }

    /// Runs G68; under G91 it adds a rotation in the coordinates in force.
    fn rotate(&mut self, block: Block) {
        let Some(degrees) = self.given.get(b'R').filter(|degrees| degrees.abs() <= 1e6) else {
            self.remarks.add(block.place(), TraceRemark::NoAngle);
            return;
        };
        if !self.modal.is_incremental {
            self.frame.unset(Kind::Rotation);
        }
        let Some(center) = self.named_center(block) else { return };
        let turn = Affine::rotation(self.canonical.plane, center, degrees.to_radians());
        self.frame.compose(Kind::Rotation, turn);
    }

    /// Runs G51.
    fn scale(&mut self, block: Block) {
        let factor = |letter: u8| {
            let word = block.words.iter().rfind(|word| word.letter == letter)?;
            let counts_thousandths =
                !word.has_point && word.value.fract() == 0.0 && MIN_THOUSANDTHS <= word.value.abs();
            Some(if counts_thousandths { word.value / 1000.0 } else { word.value })
        };
        // On Mach X, Y and Z are the factors, about the origin.
        let has_factors_by_axis = self.dialect == Dialect::Mach && !self.given.has(CENTER_WORDS | bits(b"P"));
        let factors = if has_factors_by_axis {
            AXES.map(|axis| factor(axis as u8).unwrap_or(1.0))
        } else if self.given.has(CENTER_WORDS) {
            [b'I', b'J', b'K'].map(|letter| factor(letter).unwrap_or(1.0))
        } else {
            [factor(b'P').unwrap_or(0.0); 3]
        };
        if !factors.iter().all(|factor| SCALE_FACTORS.contains(&factor.abs())) {
            self.remarks.add(block.place(), TraceRemark::BadScale);
            return;
        }
        self.frame.unset(Kind::Scaling);
        let center = if has_factors_by_axis { Some(Point::origin()) } else { self.named_center(block) };
        let Some(center) = center else { return };
        self.frame.set(Kind::Scaling, Affine::scaling(center, factors));
    }

    /// Runs G51.1 and G50.1; G50.1 without axis words ends all mirrors.
    fn mirror(&mut self, block: Block, is_on: bool) {
        let ends_all = !is_on && !self.given.has(AXIS_WORDS);
        for (axis, letter) in AXES.into_iter().enumerate() {
            let value = self.given.get(letter as u8).map(|value| value * self.modal.unit);
            if let Some(place) = value.filter(|_| is_on) {
                if self.is_within_reach(block, letter, place) {
                    self.frame.mirrors[axis] = Some(place);
                }
            } else if ends_all || value.is_some() {
                self.frame.mirrors[axis] = None;
            }
        }
        if self.frame.mirrors == [None; 3] {
            self.frame.unset(Kind::Mirror);
        } else {
            self.frame.set(Kind::Mirror, Affine::mirror(self.frame.mirrors));
        }
    }

    /// Runs G43, G44, G43.1, G43.2 and G49. Returns G43.1 without H as a word that takes the axis words of its
    /// block.
    pub(crate) fn choose_tool_length(&mut self, block: Block, code: Code) -> Option<(Special, Code)> {
        let tenths = (10.0 * code.value).round() as u16;
        if tenths == 490 {
            self.frame.set_tool(Vector::zeros());
            return None;
        }
        if tenths == 431 && !self.given.has(bits(b"H")) && self.given.has(AXIS_WORDS) {
            return Some((Special::ToolOffset, code));
        }
        let number = match self.given.get(b'H') {
            Some(number) if (0.0..=MAX_TOOL_NUMBER).contains(&number) => Some(number as u32),
            Some(_) => None,
            None => self.modal.tool,
        };
        let length = number.and_then(|number| self.frame.tool_lengths.get(&number).copied());
        if length.is_none() && self.given.has(bits(b"H")) && number != Some(0) {
            self.remarks.add(block.place_of_letter(b'H'), TraceRemark::NoToolLength { code });
        }
        let length = length.unwrap_or_default();
        self.frame.set_tool(match tenths {
            440 => -length,
            432 => self.frame.tool + length,
            _ => length,
        });
        None
    }

    /// Returns the rotary words of the block, as axis and value (rad).
    fn rotary_values(&self) -> impl Iterator<Item = (usize, f64)> + use<> {
        let values = ROTARY_AXES.map(|axis| self.given.get(axis as u8).map(f64::to_radians));
        values.into_iter().enumerate().filter_map(|(axis, value)| Some((axis, value?)))
    }
}
