//! Remarks of a stage on a program; a stage remarks on faults and continues.
//!
//! A stage stores its remarks as data, one enum a stage, in [`Remarks`], which bounds the list: a million bad
//! lines make a few hundred messages and one count.

use crate::simulation::gcode::{Doubt, DoubtCause, DoubtEffect, LineNumber};
use crate::simulation::ordered::sort_by_number;
use std::fmt::Display;
use std::mem::{Discriminant, discriminant};

/// The importance of a diagnostic for the quote.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The program was read as meant; the user may want to know.
    Info,
    /// Words were left out or assumed; the time may be off.
    Warning,
    /// The block could not be read or run as written.
    Error,
}

/// One remark about one line of the program.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// Line of the program.
    pub line: LineNumber,
    /// Columns it concerns, 1-based, first and one past the last; equal where the whole line is meant.
    pub columns: (u32, u32),
    /// Its importance.
    pub severity: Severity,
    /// The fault and its consequence, in one sentence.
    pub message: String,
}

/// The place in the program that a remark is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Line of the program.
    pub line: LineNumber,
    /// Columns as in [`Diagnostic::columns`].
    pub columns: (u32, u32),
}

impl Place {
    /// Returns the whole of `line` as a place.
    pub fn line(line: LineNumber) -> Place {
        Place { line, columns: (1, 1) }
    }
}

/// A remark as data; `Display` gives its sentence.
pub trait Remark: Display + PartialEq {
    /// Returns its importance.
    fn severity(&self) -> Severity;

    /// Returns `true` if the remark holds for the whole program, so that one entry is enough.
    fn holds_for_program(&self) -> bool {
        false
    }

    /// Returns the times that it leaves in doubt, with the cause; `None` if it leaves none.
    fn doubt(&self) -> Option<(DoubtCause, DoubtEffect)> {
        None
    }
}

/// Returns a count with its noun: 1 block, 2 blocks.
pub fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

/// Most remarks of one kind in the list; further ones are only counted.
const MAX_LISTED: usize = 200;

/// The remarks of one stage, bounded.
#[derive(Debug)]
pub struct Remarks<R> {
    diagnostics: Vec<Diagnostic>,
    kinds: Vec<KindCount<R>>,
    for_program: Vec<R>,
    /// The remarks of the list by ascending place.
    listed: Vec<Listed<R>>,
    /// Number of blocks or segments before the current place.
    after: usize,
    /// The doubts that the remarks leave, in order; unlike the list, all of them.
    pub(crate) doubts: Vec<Doubt>,
}

/// The number of remarks of one kind.
#[derive(Debug)]
struct KindCount<R> {
    kind: Discriminant<R>,
    count: usize,
    /// Index in the list of the first remark beyond `MAX_LISTED`.
    first_unlisted: usize,
}

/// A remark of the list.
#[derive(Debug)]
struct Listed<R> {
    place: Place,
    remark: R,
    /// Its index in the list.
    index: usize,
    /// Number of equal remarks at this place.
    times: usize,
}

impl<R> Default for Remarks<R> {
    fn default() -> Remarks<R> {
        Remarks {
            diagnostics: Vec::new(),
            kinds: Vec::new(),
            for_program: Vec::new(),
            listed: Vec::new(),
            after: 0,
            doubts: Vec::new(),
        }
    }
}

impl<R: Remark> Remarks<R> {
    /// Adds `remark` at `place`.
    pub fn add(&mut self, place: Place, remark: R) {
        if let Some((cause, effect)) = remark.doubt() {
            self.doubt(place.line, cause, effect);
        }
        if remark.holds_for_program() {
            if !self.for_program.contains(&remark) {
                self.list(place, &remark);
                self.for_program.push(remark);
            }
            return;
        }
        let next = self.listed.partition_point(|listed| listed.place <= place);
        let mut at_place = self.listed[..next].iter_mut().rev().take_while(|listed| listed.place == place);
        if let Some(known) = at_place.find(|listed| listed.remark == remark) {
            known.times += 1;
            return;
        }
        let kind = discriminant(&remark);
        let index = self.kinds.iter().position(|known| known.kind == kind).unwrap_or_else(|| {
            self.kinds.push(KindCount { kind, count: 0, first_unlisted: 0 });
            self.kinds.len() - 1
        });
        let known = &mut self.kinds[index];
        known.count += 1;
        if known.count == MAX_LISTED + 1 {
            known.first_unlisted = self.diagnostics.len();
        }
        if known.count <= MAX_LISTED + 1 {
            let index = self.diagnostics.len();
            self.list(place, &remark);
            self.listed.insert(next, Listed { place, remark, index, times: 1 });
        }
    }

    /// Adds a doubt about the time without a remark.
    pub(crate) fn doubt(&mut self, line: LineNumber, cause: DoubtCause, effect: DoubtEffect) {
        let (after, until) = (self.after, self.after);
        self.doubts.push(Doubt { line, cause, effect, after, until });
    }

    /// Sets the number of blocks or segments before the current place.
    pub(crate) fn set_place(&mut self, after: usize) {
        self.after = after;
    }

    /// Returns the number of blocks or segments before the current place.
    pub(crate) fn place(&self) -> usize {
        self.after
    }

    /// Returns `true` if there are no remarks.
    pub fn is_empty(&self) -> bool {
        self.diagnostics.is_empty()
    }

    fn list(&mut self, place: Place, remark: &R) {
        self.diagnostics.push(Diagnostic {
            line: place.line,
            columns: place.columns,
            severity: remark.severity(),
            // Names and excerpts of a program may hold anything.
            message: remark.to_string().replace(char::is_control, " "),
        });
    }

    /// Returns the list in line order, with one diagnostic for the remarks of a kind beyond `MAX_LISTED`.
    pub fn finish(mut self) -> Vec<Diagnostic> {
        for Listed { index, times, .. } in self.listed.into_iter().filter(|listed| 1 < listed.times) {
            self.diagnostics[index].message += &format!(" ({times} times)");
        }
        for KindCount { count, first_unlisted, .. } in self.kinds {
            if MAX_LISTED + 1 < count {
                let message = &mut self.diagnostics[first_unlisted].message;
                *message =
                    format!("{} more of this kind from here on, the first: {message}", count - MAX_LISTED);
            }
        }
        in_line_order(self.diagnostics)
    }
}

/// Sorts diagnostics by line, stably, and returns them.
pub fn in_line_order(mut diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
    sort_by_number(&mut diagnostics, |diagnostic| f64::from(diagnostic.line.0));
    diagnostics
}
