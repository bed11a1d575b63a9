//! Changes of coordinates: cycles 7, 8, 10, 11 and 26, and TRANS.
//!
//! Each is an operation of the chain of coordinates, in the order in which they were first programmed; a new one
//! replaces the one of its kind in its position. Missing values of cycle 7 do not change; cycle 8 mirrors the axes
//! of its words and no others.

use crate::machine::AXES;
use crate::simulation::gcode::{Transformation, address};
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::bounds::SCALE_FACTORS;
use crate::simulation::interpreter::frame::{Affine, Kind};
use crate::simulation::interpreter::klartext::KlartextRemark;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::{Point, Vector};

impl Interpreter<'_> {
    /// Runs TRANS DATUM, MIRROR, ROTATION and SCALE.
    pub(super) fn transform(&mut self, block: Block, transformation: Transformation) {
        match transformation {
            Transformation::Datum => self.shift_datum(block),
            Transformation::Mirror => self.mirror_axes(),
            Transformation::Rotation => self.rotate_plane(block, address::PLANE_ANGLE),
            Transformation::Scale => self.scale_all(block),
        }
    }

    /// Runs TRANS DATUM RESET and the like.
    pub(super) fn reset_transform(&mut self, transformation: Transformation) {
        self.frame.unset(match transformation {
            Transformation::Datum => {
                self.klartext.datum = Vector::zeros();
                Kind::Datum
            }
            Transformation::Mirror => Kind::Mirror,
            Transformation::Rotation => {
                self.klartext.angle = 0.0;
                Kind::Rotation
            }
            Transformation::Scale => Kind::Scaling,
        });
    }

    /// Shifts the datum by the axis words of the block.
    pub(super) fn shift_datum(&mut self, block: Block) {
        if self.given.get(address::SETTING).is_some() {
            let (name, what) = ("datum table", "its rows are not in this file: its shifts are not applied");
            self.remark(block.place(), KlartextRemark::Statement { name, what });
        }
        let mut datum = self.klartext.datum;
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = self.given.get(letter as u8) else { continue };
            let value = value * self.modal.unit;
            datum[axis] =
                if self.given.is_incremental(letter as u8, false) { datum[axis] + value } else { value };
            if !self.is_within_reach(block, letter, datum[axis]) {
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

    /// Mirrors the axes of the block's words at the datum; without words, ends the mirror.
    pub(super) fn mirror_axes(&mut self) {
        let places = AXES.map(|axis| self.given.get(axis as u8).map(|_| 0.0));
        if places == [None; 3] {
            self.frame.unset(Kind::Mirror);
        } else {
            self.frame.set(Kind::Mirror, Affine::mirror(places));
        }
    }

    /// Rotates the plane about the datum by the angle in the word with this address.
    pub(super) fn rotate_plane(&mut self, block: Block, address: u8) {
        let Some(degrees) = self.given.get(address).filter(|degrees| degrees.abs() <= 1e6) else {
            let (name, what, instead) = ("rotation", "angle", "coordinates do not change");
            self.remark(block.place(), KlartextRemark::Missing { name, what, instead });
            return;
        };
        let is_further = self.given.is_incremental(address, false);
        let before = if is_further { self.klartext.angle } else { 0.0 };
        self.klartext.angle = before + degrees.to_radians();
        if self.klartext.angle == 0.0 {
            self.frame.unset(Kind::Rotation);
        } else {
            let turn = Affine::rotation(self.canonical.plane, Point::origin(), self.klartext.angle);
            self.frame.set(Kind::Rotation, turn);
        }
    }

    /// Scales all axes by one factor.
    pub(super) fn scale_all(&mut self, block: Block) {
        let factor = self.given.get(address::SETTING).unwrap_or(0.0);
        self.scale_by(block, [factor; 3], Point::origin());
    }

    /// Scales each axis by its own factor about a centre (CCX, CCY, CCZ).
    pub(super) fn scale_axes(&mut self, block: Block) {
        let factors = AXES.map(|axis| self.given.get(axis as u8).unwrap_or(1.0));
        let center = b"IJK".map(|letter| self.given.get(letter).unwrap_or(0.0) * self.modal.unit);
        self.scale_by(block, factors, Point::from(center));
    }

    /// Scales the axes by `factors` about `center` (mm).
    fn scale_by(&mut self, block: Block, factors: [f64; 3], center: Point) {
        if !factors.iter().all(|factor| SCALE_FACTORS.contains(factor)) {
            self.remarks.add(block.place(), TraceRemark::BadScale);
        } else if factors == [1.0; 3] {
            self.frame.unset(Kind::Scaling);
        } else {
            self.frame.set(Kind::Scaling, Affine::scaling(center, factors));
        }
    }
}
