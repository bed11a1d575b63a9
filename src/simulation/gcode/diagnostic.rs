//! What a stage has to say about a program, without stopping.
//!
//! A stage keeps its remarks as data, one enum a stage, and puts them down through [`Remarks`],
//! which bounds the list: a million bad lines make a few hundred messages and one count.

use crate::simulation::gcode::{Cause, Doubt, Effect, LineNumber};
use std::fmt::Display;
use std::mem::{Discriminant, discriminant};

/// How much a diagnostic matters to the quote.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Read as meant; the user may want to know.
    Info,
    /// Something was left out or assumed; the time may be off.
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
    /// How much it matters.
    pub severity: Severity,
    /// What is wrong and what was done instead, one sentence.
    pub message: String,
}

/// Where in the program a remark belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Line of the program.
    pub line: LineNumber,
    /// Columns as in [`Diagnostic::columns`].
    pub columns: (u32, u32),
}

impl Place {
    /// The whole of `line`.
    pub fn line(line: LineNumber) -> Place {
        Place { line, columns: (1, 1) }
    }
}

/// A remark as data; its `Display` is the sentence people read.
pub trait Remark: Display + PartialEq {
    /// How much it matters.
    fn severity(&self) -> Severity;

    /// It holds for the whole program, so that repeating it says nothing new.
    fn is_said_once(&self) -> bool {
        false
    }

    /// What it leaves in doubt of the time, if anything.
    fn doubt(&self) -> Option<(Cause, Effect)> {
        None
    }
}

/// A count with its noun: 1 block, 2 blocks.
pub fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

/// How many remarks of one kind are listed before the rest are only counted.
const MAX_LISTED: usize = 200;

/// The remarks of one stage, bounded.
#[derive(Debug)]
pub struct Remarks<R> {
    diagnostics: Vec<Diagnostic>,
    /// How often each kind came up, and where in the list its first unlisted one stands.
    kinds: Vec<(Discriminant<R>, usize, usize)>,
    said_once: Vec<R>,
    /// Those of the list by ascending place, with how often each came up.
    listed: Vec<Listed<R>>,
    /// How many blocks or segments come before what is looked at.
    after: usize,
    /// What the remarks leave in doubt, in order; unlike the list, all of it.
    pub(crate) doubts: Vec<Doubt>,
}

/// A remark of the list.
#[derive(Debug)]
struct Listed<R> {
    place: Place,
    remark: R,
    index: usize,
    times: usize,
}

impl<R> Default for Remarks<R> {
    fn default() -> Remarks<R> {
        Remarks {
            diagnostics: Vec::new(),
            kinds: Vec::new(),
            said_once: Vec::new(),
            listed: Vec::new(),
            after: 0,
            doubts: Vec::new(),
        }
    }
}

impl<R: Remark> Remarks<R> {
    /// Puts down `remark` at `place`.
    pub fn add(&mut self, place: Place, remark: R) {
        if let Some((cause, effect)) = remark.doubt() {
            self.doubt(place.line, cause, effect);
        }
        if remark.is_said_once() {
            if !self.said_once.contains(&remark) {
                self.list(place, &remark);
                self.said_once.push(remark);
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
        let index = self.kinds.iter().position(|(known, ..)| *known == kind).unwrap_or_else(|| {
            self.kinds.push((kind, 0, 0));
            self.kinds.len() - 1
        });
        let (_, seen, first_unlisted) = &mut self.kinds[index];
        *seen += 1;
        if *seen == MAX_LISTED + 1 {
            *first_unlisted = self.diagnostics.len();
        }
        if *seen <= MAX_LISTED + 1 {
            let index = self.diagnostics.len();
            self.list(place, &remark);
            self.listed.insert(next, Listed { place, remark, index, times: 1 });
        }
    }

    /// Puts down a doubt of the time without a remark.
    pub(crate) fn doubt(&mut self, line: LineNumber, cause: Cause, effect: Effect) {
        let (after, until) = (self.after, self.after);
        self.doubts.push(Doubt { line, cause, effect, after, until });
    }

    /// Tells how many blocks or segments come before what is looked at from here on.
    pub(crate) fn look_behind(&mut self, after: usize) {
        self.after = after;
    }

    /// How many blocks or segments come before what is looked at.
    pub(crate) fn behind(&self) -> usize {
        self.after
    }

    /// Nothing has been put down.
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

    /// The list in line order, with one line for those of a kind that were too many.
    pub fn finish(mut self) -> Vec<Diagnostic> {
        for Listed { index, times, .. } in self.listed.into_iter().filter(|listed| 1 < listed.times) {
            self.diagnostics[index].message += &format!(" ({times} times)");
        }
        for (_, seen, first_unlisted) in self.kinds {
            if MAX_LISTED + 1 < seen {
                let message = &mut self.diagnostics[first_unlisted].message;
                *message =
                    format!("{} more of this kind from here on, the first: {message}", seen - MAX_LISTED);
            }
        }
        in_line_order(self.diagnostics)
    }
}

/// The same diagnostics by ascending line; those of one line stay in their order.
pub fn in_line_order(mut diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
    diagnostics.sort_by_key(|diagnostic| diagnostic.line);
    diagnostics
}
