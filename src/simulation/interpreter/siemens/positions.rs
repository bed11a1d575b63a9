//! Patterns of holes: the positions at which the cycle of MCALL is run.
//!
//! | pattern | its holes |
//! |---|---|
//! | HOLES1 | a row: the first hole FDIS from SPCA, SPCO |
//! | HOLES2 | a circle; INDA 0 spreads the holes evenly |
//! | CYCLE801 | a grid; VARI 1 its frame alone |
//! | CYCLE802 | up to nine positions |
//!
//! NUM1 holes with the distance DIS1 are along STA1, NUM2 rows with DIS2 at a right angle to it; rows run to and
//! fro. A position of CYCLE802 has X or Y. A digit of XA and YA, the one of X0 at the units, is 1 for a
//! coordinate, 2 for an increment from the position before. Moves between the holes are rapids.
//!
//! Source: SINUMERIK 840D sl, Programming Manuals Cycles and Job Planning, 2013. Not read: the order by the
//! shortest way, shear angles and hidden positions of CYCLE801.

use crate::simulation::gcode::{HolePattern, PatternShape, whole_number};
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::bounds::MAX_HOLES;
use crate::simulation::interpreter::cycle::NoHole;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;

impl Interpreter<'_> {
    /// Makes the holes of the modal cycle in a pattern.
    pub(super) fn siemens_holes(&mut self, block: Block, pattern: &HolePattern) {
        let name = pattern.name;
        let Some(drilling) = self.siemens.modal else {
            let what = "no cycle is in force (MCALL): no hole is made";
            self.remarks.add(block.place(), TraceRemark::Statement { name, what });
            return;
        };
        let places = match places(&pattern.shape) {
            Ok(places) => places,
            Err(no_hole) => {
                self.remarks.add(block.place(), TraceRemark::NoSiemensHole { name, no_hole });
                return;
            }
        };
        for place in places {
            let mut program = self.frame.to_program(&self.canonical.position);
            let [first, second, _] = self.canonical.plane.axes();
            (program[first], program[second]) = (place[0] * self.modal.unit, place[1] * self.modal.unit);
            let target = self.frame.to_machine(&program);
            if !self.is_within_reach(block, 'X', target.coords.amax()) {
                return;
            }
            self.rapid_to(block, target);
            self.siemens_hole(block, &drilling);
        }
    }
}

/// Returns the positions of a pattern in the plane, in the program's unit.
fn places(shape: &PatternShape) -> Result<Vec<[f64; 2]>, NoHole> {
    let count = |value: f64| match whole_number(value) {
        Some(count) if (1.0..=MAX_HOLES).contains(&f64::from(count)) => Ok(count as usize),
        _ => Err(NoHole::NoCount(value)),
    };
    let along = |from: [f64; 2], degrees: f64, distance: f64| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        [from[0] + distance * cosine, from[1] + distance * sine]
    };
    Ok(match *shape {
        PatternShape::Row { start, angle, first_distance, spacing, count: holes } => (0..count(holes)?)
            .map(|index| along(start, angle, first_distance + spacing * index as f64))
            .collect(),
        PatternShape::Circle { center, radius, start_angle, step_angle, count: holes } => {
            let count = count(holes)?;
            let step = if step_angle == 0.0 { 360.0 / count as f64 } else { step_angle };
            (0..count).map(|index| along(center, start_angle + step * index as f64, radius)).collect()
        }
        PatternShape::Grid { start, angle, spacings, counts, is_frame } => {
            let (columns, rows) = (count(counts[0])?, count(counts[1])?);
            count((columns * rows) as f64)?;
            let (sine, cosine) = angle.to_radians().sin_cos();
            let at = |row: usize, column: usize| {
                let (u, v) = (spacings[0] * column as f64, spacings[1] * row as f64);
                [start[0] + u * cosine - v * sine, start[1] + u * sine + v * cosine]
            };
            let to_and_fro = |row: usize| {
                (0..columns)
                    .map(move |index| (row, if row.is_multiple_of(2) { index } else { columns - 1 - index }))
            };
            let is_there = |(row, column): &(usize, usize)| {
                !is_frame || [0, rows - 1].contains(row) || [0, columns - 1].contains(column)
            };
            (0..rows).flat_map(to_and_fro).filter(is_there).map(|(row, column)| at(row, column)).collect()
        }
        PatternShape::Positions { modes, ref positions } => listed(modes, positions)?,
    })
}

/// Returns the positions of CYCLE802.
fn listed(modes: [f64; 2], positions: &[[Option<f64>; 2]]) -> Result<Vec<[f64; 2]>, NoHole> {
    let digit = |value: f64, place: usize| (value.abs().min(1e9) / 10f64.powi(place as i32)) as u32 % 10;
    let mut last = [0.0; 2];
    let mut places = Vec::new();
    for (index, position) in positions.iter().enumerate().filter(|(_, position)| **position != [None; 2]) {
        for axis in 0..2 {
            let value = position[axis].unwrap_or(0.0);
            let is_increment = digit(modes[axis], index) == 2;
            last[axis] = if is_increment { last[axis] + value } else { value };
        }
        places.push(last);
    }
    if places.is_empty() { Err(NoHole::NoCount(0.0)) } else { Ok(places) }
}
