//! Patterns of holes: where the cycle of MCALL is run.
//!
//! ```text
//! HOLES1  (SPCA, SPCO, STA1, FDIS, DBH, NUM)       a row: the first hole FDIS from SPCA, SPCO
//! HOLES2  (CPA, CPO, RAD, STA1, INDA, NUM)         a circle; INDA 0 spreads the holes evenly
//! CYCLE801(SPCA, SPCO, STA1, DIS1, DIS2, NUM1, NUM2, VARI)    a grid; VARI 1 its frame alone
//! CYCLE802(XA, YA, X0, Y0, X1, Y1 … X8, Y8)        up to nine positions
//! ```
//!
//! NUM1 holes with the distance DIS1 lie along STA1, NUM2 rows with DIS2 square to it; rows are run to
//! and fro. A position of CYCLE802 is one of which X or Y is given; a digit of XA and YA, that of X0
//! at the units, says 1 for a coordinate, 2 for an increment from the position before. Moves between the holes are rapids.
//!
//! Source: SINUMERIK 840D sl, Programming Manuals Cycles and Job Planning, 2013. Left out: the order by
//! the shortest way, shear angles and hidden positions of CYCLE801.

use crate::simulation::gcode::address;
use crate::simulation::toolpath::block::Block;
use crate::simulation::toolpath::cycle::NoHole;
use crate::simulation::toolpath::remark::Untraced;
use crate::simulation::toolpath::siemens::Drilling;
use crate::simulation::toolpath::trace::Tracer;

/// The most holes of one pattern.
const MOST_HOLES: f64 = 10_000.0;

impl Tracer<'_> {
    /// The holes of the modal cycle in a pattern.
    pub(super) fn siemens_holes(&mut self, block: Block, name: &'static str) {
        let Some(Drilling { arguments, .. }) = self.siemens_drilling(block, name) else { return };
        let Some(drilling) = self.siemens.modal else {
            self.remarks.add(
                block.place(),
                Untraced::Statement { name, what: "no cycle is in force (MCALL): no hole is made" },
            );
            return;
        };
        let is_given = |index: usize| {
            block.words.iter().any(|word| usize::from(word.letter) == usize::from(address::ARGUMENT) + index)
        };
        let places = match places(name, &arguments, is_given) {
            Ok(places) => places,
            Err(no_hole) => {
                self.remarks.add(block.place(), Untraced::NoSiemensHole { name, no_hole });
                return;
            }
        };
        for place in places {
            let mut program = self.frame.to_program(&self.position);
            let [first, second, _] = self.modal.plane.axes();
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

/// The positions of a pattern in the plane, in the program's unit.
fn places(name: &str, a: &[f64], is_given: impl Fn(usize) -> bool) -> Result<Vec<[f64; 2]>, NoHole> {
    let count = |value: f64| match value {
        1.0..=MOST_HOLES => Ok(value as usize),
        _ => Err(NoHole::NoCount(value)),
    };
    let along = |degrees: f64, distance: f64| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        [a[0] + distance * cosine, a[1] + distance * sine]
    };
    Ok(match name {
        "HOLES1" => (0..count(a[5])?).map(|index| along(a[2], a[3] + a[4] * index as f64)).collect(),
        "HOLES2" => {
            let count = count(a[5])?;
            let step = if a[4] == 0.0 { 360.0 / count as f64 } else { a[4] };
            (0..count).map(|index| along(a[3] + step * index as f64, a[2])).collect()
        }
        "CYCLE801" => {
            let (columns, rows) = (count(a[5])?, count(a[6])?);
            count((columns * rows) as f64)?;
            let (sine, cosine) = a[2].to_radians().sin_cos();
            let is_frame = a[7] == 1.0;
            let at = |row: usize, column: usize| {
                let (u, v) = (a[3] * column as f64, a[4] * row as f64);
                [a[0] + u * cosine - v * sine, a[1] + u * sine + v * cosine]
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
        _ => {
            let digit =
                |value: f64, place: usize| (value.abs().min(1e9) / 10f64.powi(place as i32)) as u32 % 10;
            let mut last = [0.0; 2];
            let mut places = Vec::new();
            for index in 0..9 {
                let ways = [digit(a[0], index), digit(a[1], index)];
                if ![2, 3].into_iter().any(|axis| is_given(2 * index + axis)) {
                    continue;
                }
                for axis in 0..2 {
                    let value = a[2 + 2 * index + axis];
                    last[axis] = if ways[axis] == 2 { last[axis] + value } else { value };
                }
                places.push(last);
            }
            if places.is_empty() {
                return Err(NoHole::NoCount(0.0));
            }
            places
        }
    })
}
