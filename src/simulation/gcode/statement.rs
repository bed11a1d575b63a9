//! Statements: requests of a block by a keyword instead of letters.
//!
//! A statement stores its keyword by type, and its arguments beside the words of the block, so that a word remains
//! small. Its arguments have values once the formulas of the block are computed; the dialect then gives them names
//! ([`SiemensStatement`], [`KlartextStatement`]).

use crate::simulation::gcode::klartext::KlartextStatement;
use crate::simulation::gcode::siemens::SiemensKeyword;
use crate::simulation::gcode::{Columns, LineNumber, Place};
use std::ops::Range;

#[cfg(doc)]
use crate::simulation::gcode::SiemensStatement;

/// A statement of a block.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// Index of its block.
    pub block: u32,
    /// The columns of its keyword in the line.
    pub columns: Columns,
    /// Its keyword.
    pub keyword: Keyword,
    /// Its arguments in [`Program::arguments`](crate::simulation::gcode::Program::arguments).
    pub arguments: Range<u32>,
}

/// The keyword of a statement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Keyword {
    /// Of a SINUMERIK program.
    Siemens(&'static SiemensKeyword),
    /// Of a Heidenhain program, in Klartext or in DIN/ISO.
    Klartext(KlartextStatement),
    /// A word by which X words are diameters, in its spelling: the only item kept of a block that is not run.
    Diameters(&'static str),
}

/// An argument of a statement that is not left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Argument {
    /// Number of arguments before it.
    pub position: u8,
    /// Its value; NaN until its formula is computed.
    pub value: f64,
}

impl Statement {
    /// Returns the place of its keyword.
    pub fn place(&self, line: LineNumber) -> Place {
        Place { line, columns: self.columns.into() }
    }
}
