//! The chain from program coordinates p to machine coordinates m, mm:
//!
//! ```text
//! m = T(external + work + tool) · R(θ) · T(shift + local) · O1 · O2 · … · p
//! ```
//!
//! T is a shift; external is the offset that Fanuc and Haas controls add to all work offsets (G10 L2 P0); work is
//! the one in force (G54 to G59.3, G54.1 Pn) and θ its rotation in X Y (G10 L2 R of LinuxCNC); tool is the length
//! offset (G43), shift the offset of G92, local the one of G52. O1, O2 … are the operations on coordinates in
//! force — mirror image, scaling, rotation — the later one within the earlier one; a new one replaces the one of
//! its kind in its position. Rotary axes have offsets alone.
//!
//! While the chain consists of shifts only, each axis is computed on its own, so that axes without words keep
//! every digit.
//!
//! Sources: NIST RS274/NGC, Sect. 3.5; LinuxCNC, G10 and G92; Fanuc operator's manual, coordinate system, scaling,
//! coordinate rotation and programmable mirror image. Limits: a work offset without a value in the machine file
//! and the program is zero.

mod polar_words;
mod target;
mod affine;
mod arc;
mod polar;
#[cfg(test)]
mod tests;
mod words;

pub(super) use affine::Affine;
pub(super) use polar::Polar;

use crate::machine::Machine;
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::{Point, Vector};
use std::collections::BTreeMap;

/// An offset of all axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Shift {
    /// X, Y and Z, mm.
    pub(super) linear: Vector,
    /// A, B and C, rad.
    pub(super) rotary: Vector,
}

/// A work offset.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct WorkOffset {
    pub(super) origin: Shift,
    /// About Z, rad.
    pub(super) rotation: f64,
}

/// The kind of an operation on coordinates; a new one replaces the one of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Datum shift of Heidenhain controls.
    Datum,
    Mirror,
    Scaling,
    Rotation,
}

/// The chain of coordinates in force.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// By number: 1 to 9 for G54 to G59.3, above [`ADDITIONAL`] for G54.1 Pn, and [`EXTERNAL`].
    work_offsets: BTreeMap<u16, WorkOffset>,
    /// Number of the work offset in force.
    pub(super) work_offset: u16,
    /// The offset of G92.
    shift: Shift,
    /// The last offset of G92, for G92.3.
    stored: Shift,
    /// The offset of G52.
    local: Shift,
    /// Tool lengths in the program, by number.
    tool_lengths: BTreeMap<u32, Vector>,
    /// Length offset in force, mm.
    tool: Vector,
    operations: Vec<(Kind, Affine)>,
    /// Coordinates of the mirrors of G51.1, mm.
    mirrors: [Option<f64>; 3],
    /// Polar coordinates, if they are in force.
    pub(super) polar: Option<Polar>,
    /// The offset of program coordinates beside `shift` and `local`, while the chain consists of shifts.
    base: Vector,
    /// The whole chain and its inverse, if it is more than shifts.
    turned: Option<Box<[Affine; 2]>>,
}

/// The number of G54.1 P0, beyond those of G54 to G59.3.
pub(super) const ADDITIONAL: u16 = 9;

/// The number of the offset that adds to all others; no word selects it.
const EXTERNAL: u16 = u16::MAX;

impl Frame {
    pub(super) fn new(machine: &Machine) -> Frame {
        let offset = |linear: &[f64; 3]| {
            let origin = Shift { linear: Vector::from(*linear), rotary: Vector::zeros() };
            WorkOffset { origin, rotation: 0.0 }
        };
        let known = machine.work_offsets.iter().zip(1..);
        let mut frame = Frame {
            work_offsets: known.filter_map(|(origin, n)| Some((n, offset(origin.as_ref()?)))).collect(),
            work_offset: 1,
            shift: Shift::default(),
            stored: Shift::default(),
            local: Shift::default(),
            tool_lengths: BTreeMap::new(),
            tool: Vector::zeros(),
            operations: Vec::new(),
            mirrors: [None; 3],
            polar: None,
            base: Vector::zeros(),
            turned: None,
        };
        frame.refresh();
        frame
    }

    /// Sets an operation, in place of the one of its kind, else within all others.
    pub(super) fn set(&mut self, kind: Kind, operation: Affine) {
        match self.operations.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, known)) => *known = operation,
            None => self.operations.push((kind, operation)),
        }
        self.refresh();
    }

    /// Adds an operation within the one of its kind.
    pub(super) fn compose(&mut self, kind: Kind, operation: Affine) {
        let known = self.operations.iter().find(|(known, _)| *known == kind);
        let outer = known.map_or(Affine::identity(), |(_, known)| *known);
        self.set(kind, outer.after(&operation));
    }

    /// Removes the operation of a kind.
    pub(super) fn unset(&mut self, kind: Kind) {
        self.operations.retain(|(known, _)| *known != kind);
        self.refresh();
    }

    /// Sets the values of a work offset; the tool does not move, even if it is in force.
    pub(super) fn set_work_offset(&mut self, number: u16, offset: WorkOffset) {
        self.work_offsets.insert(number, offset);
        self.refresh();
    }

    /// Returns the work offset with a number, or `None` if neither machine file nor program has it.
    pub(super) fn work_offset_of(&self, number: u16) -> Option<WorkOffset> {
        self.work_offsets.get(&number).copied()
    }

    /// Selects a work offset.
    pub(super) fn select_work_offset(&mut self, number: u16) {
        self.work_offset = number;
        self.refresh();
    }

    /// Returns the work offset in force.
    fn work(&self) -> WorkOffset {
        self.work_offset_of(self.work_offset).unwrap_or_default()
    }

    /// Returns the offset that adds to all others.
    fn external(&self) -> Shift {
        self.work_offset_of(EXTERNAL).unwrap_or_default().origin
    }

    /// Sets the tool length offset, mm.
    pub(super) fn set_tool(&mut self, offset: Vector) {
        self.tool = offset;
        self.refresh();
    }

    /// Returns the part of the chain outside the shifts of G92 and G52.
    fn outer(&self) -> Affine {
        let work = self.work();
        let outer = Affine::shift(self.external().linear + work.origin.linear + self.tool);
        match work.rotation {
            0.0 => outer,
            angle => outer.after(&Affine::rotation(Plane::Xy, Point::origin(), angle)),
        }
    }

    /// Returns the part of the chain within these shifts.
    fn inner(&self) -> Affine {
        let operations = self.operations.iter();
        operations.fold(Affine::identity(), |outer, (_, operation)| outer.after(operation))
    }

    /// Computes the fields that depend on others.
    fn refresh(&mut self) {
        let (outer, inner) = (self.outer(), self.inner());
        if let (Some(outer), Some(inner)) = (outer.as_shift(), inner.as_shift()) {
            self.base = outer + inner;
            self.turned = None;
        } else {
            let shifts = Affine::shift(self.shift.linear + self.local.linear);
            let chain = outer.after(&shifts).after(&inner);
            self.turned = chain.inverse().map(|inverse| Box::new([chain, inverse]));
        }
    }

    /// Returns the chain, or `None` if it consists of shifts.
    pub(super) fn turned(&self) -> Option<&Affine> {
        self.turned.as_ref().map(|maps| &maps[0])
    }

    /// Returns the machine coordinate, mm, of a program coordinate while the chain consists of shifts.
    #[inline]
    pub(super) fn coordinate(&self, axis: usize, value: f64) -> f64 {
        value + self.shift.linear[axis] + self.local.linear[axis] + self.base[axis]
    }

    /// Returns the machine coordinates of program coordinates, mm.
    pub(super) fn to_machine(&self, program: &Point) -> Point {
        match &self.turned {
            Some(maps) => maps[0].point(program),
            None => Point::from(Vector::from_fn(|axis, _| self.coordinate(axis, program[axis]))),
        }
    }

    /// Returns the machine coordinate of an axis, mm, for its program coordinate at the position `at`.
    pub(super) fn coordinate_at(&self, at: &Point, axis: usize, value: f64) -> f64 {
        if self.turned.is_none() {
            return self.coordinate(axis, value);
        }
        let mut program = self.to_program(at);
        program[axis] = value;
        self.to_machine(&program)[axis]
    }

    /// Returns the program coordinates of machine coordinates, mm.
    pub(super) fn to_program(&self, machine: &Point) -> Point {
        match &self.turned {
            Some(maps) => maps[1].point(machine),
            None => machine - self.shift.linear - self.local.linear - self.base,
        }
    }

    /// Returns the machine coordinate of a rotary axis, rad, for its program coordinate.
    pub(super) fn rotary_coordinate(&self, axis: usize, value: f64) -> f64 {
        let work = self.external().rotary[axis] + self.work().origin.rotary[axis];
        value + self.shift.rotary[axis] + self.local.rotary[axis] + work
    }

    /// Returns the shift of G92 that gives the point `at` in machine coordinates the program coordinates `named`,
    /// mm.
    fn shift_naming(&self, at: &Point, named: &Point) -> Vector {
        if self.turned.is_none() {
            return at - named - self.local.linear - self.base;
        }
        let outer = self.outer().inverse().expect("a shift with a rotation can be undone");
        outer.point(at) - self.inner().point(named) - self.local.linear
    }
}
