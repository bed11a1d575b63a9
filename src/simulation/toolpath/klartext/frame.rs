//! Transformations of Heidenhain programs, each in place of the one before of its kind.
//!
//! ```text
//! cycle 7, TRANS DATUM AXIS      shift, absolute or by increments (IX)
//! cycle 8, TRANS MIRROR AXIS     mirror image in the axes that are named, about the datum; none: off
//! cycle 10, TRANS ROTATION       rotation about the datum in the plane of the tool
//! cycle 11, TRANS SCALE          scaling about the datum, all axes
//! cycle 26                       scaling by axis, about a centre (CCX, CCY, CCZ)
//! ```
//!
//! Source: TNC 640, Cycle Programming 2018, ch. 11.

use crate::machine::AXES;
use crate::simulation::gcode::address;
use crate::simulation::toolpath::block::Block;
use crate::simulation::toolpath::frame::{Affine, Kind};
use crate::simulation::toolpath::klartext::KlartextRemark;
use crate::simulation::toolpath::trace::Tracer;
use crate::simulation::toolpath::{Point, Vector};

/// The factors of scaling that are taken at their word.
const FACTORS: std::ops::RangeInclusive<f64> = 1e-6..=99.999_999;

impl Tracer<'_> {
    /// A line of cycle 7, 8, 10, 11 or 26.
    pub(super) fn transform_by_cycle(&mut self, block: Block, number: u32) {
        let setting = self.given.get(address::SETTING);
        match number {
            7 if setting.is_some() => {
                let what = "the datum table is not in this file: its shift is not applied";
                self.remark(block.place(), KlartextRemark::CycleSetting { number, what });
            }
            7 => self.shift_datum(block),
            8 => self.mirror_axes(),
            10 => self.rotate_datum(setting, self.is_added(block, address::SETTING)),
            11 => self.scale_datum(block, [setting.unwrap_or(1.0); 3], Point::origin()),
            _ => {
                let factors = AXES.map(|axis| self.given.get(axis as u8).unwrap_or(1.0));
                let center =
                    [b'I', b'J', b'K'].map(|axis| self.given.get(axis).unwrap_or(0.0) * self.modal.unit);
                self.scale_datum(block, factors, Point::from(center));
            }
        }
    }

    /// `TRANS …`.
    pub(super) fn transform(&mut self, block: Block, name: &str) {
        match name {
            "TRANS DATUM" => self.shift_datum(block),
            "TRANS DATUM RESET" => {
                self.klartext.datum = Vector::zeros();
                self.frame.unset(Kind::Datum);
            }
            "TRANS MIRROR" => self.mirror_axes(),
            "TRANS MIRROR RESET" => self.frame.unset(Kind::Mirror),
            "TRANS ROTATION" => {
                let angle = self.given.get(address::PLANE_ANGLE);
                self.rotate_datum(angle, self.is_added(block, address::PLANE_ANGLE));
            }
            "TRANS ROTATION RESET" => self.rotate_datum(Some(0.0), false),
            "TRANS SCALE" => {
                let factor = self.given.get(address::SETTING).unwrap_or(1.0);
                self.scale_datum(block, [factor; 3], Point::origin());
            }
            _ => self.frame.unset(Kind::Scaling),
        }
    }

    fn shift_datum(&mut self, block: Block) {
        let mut datum = self.klartext.datum;
        let values = self.axis_words(&datum);
        for (axis, value) in values.into_iter().enumerate() {
            datum[axis] = value.unwrap_or(datum[axis]);
            if !self.is_within_reach(block, AXES[axis], datum[axis]) {
                return;
            }
        }
        self.klartext.datum = datum;
        if datum == Vector::zeros() {
            self.frame.unset(Kind::Datum);
        } else {
            self.frame.set(Kind::Datum, Affine::shift(datum));
        }
    }

    fn mirror_axes(&mut self) {
        let places = AXES.map(|axis| self.given.get(axis as u8).map(|_| 0.0));
        if places == [None; 3] {
            self.frame.unset(Kind::Mirror);
        } else {
            self.frame.set(Kind::Mirror, Affine::mirror(places));
        }
    }

    fn rotate_datum(&mut self, degrees: Option<f64>, is_added: bool) {
        let degrees = degrees.filter(|degrees| degrees.abs() <= 1e6).unwrap_or(0.0).to_radians();
        self.klartext.angle = if is_added { self.klartext.angle + degrees } else { degrees };
        if self.klartext.angle == 0.0 {
            self.frame.unset(Kind::Rotation);
        } else {
            let turn = Affine::rotation(self.modal.plane, Point::origin(), self.klartext.angle);
            self.frame.set(Kind::Rotation, turn);
        }
    }

    fn scale_datum(&mut self, block: Block, factors: [f64; 3], center: Point) {
        if !factors.iter().all(|factor| FACTORS.contains(factor)) {
            let what = "this factor is not possible: coordinates are not scaled";
            self.remark(block.place(), KlartextRemark::CycleSetting { number: 11, what });
        } else if factors == [1.0; 3] {
            self.frame.unset(Kind::Scaling);
        } else {
            self.frame.set(Kind::Scaling, Affine::scaling(center, factors));
        }
    }
}
