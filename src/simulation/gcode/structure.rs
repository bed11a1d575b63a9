//! Structured flow → jumps: loops, branches and subprograms by the words that open and close them.
//!
//! The reader keeps each opening word until its closing word follows. It adds the jumps of a structure where they
//! begin, and completes them when the closing word gives their destination. A closing word without an opening one,
//! and an opening word that is never closed, get a remark and have no effect, so the blocks between are run once.

use crate::simulation::gcode::{Action, Destination, Flow, LineNumber, Program, Step, When};

/// The kind of a structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A loop that is tested at its head.
    While,
    /// A loop that is tested at its end, or never.
    Do,
    /// A loop with a count.
    Repeat,
    /// A branch.
    If,
    /// A subprogram.
    Sub,
    /// A loop with a counting variable.
    For,
}

impl Kind {
    /// Returns the spelling of the opening word.
    pub(super) fn word(self) -> &'static str {
        match self {
            Kind::While => "WHILE",
            Kind::Do => "DO",
            Kind::Repeat => "REPEAT",
            Kind::If => "IF",
            Kind::Sub => "SUB",
            Kind::For => "FOR",
        }
    }
}

/// The variable that counts a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Counter {
    /// The parameter with this number.
    Number(u32),
    /// The parameter with this index of its name.
    Name(u32),
}

impl Counter {
    /// Pushes its value.
    pub(super) fn load(self, steps: &mut Vec<Step>) {
        match self {
            Counter::Number(number) => steps.extend([Step::Number(f64::from(number)), Step::Numbered]),
            Counter::Name(index) => steps.push(Step::Named(index)),
        }
    }
}

/// An opening word that waits for its closing one.
#[derive(Debug)]
pub(super) struct Open {
    pub(super) kind: Kind,
    /// The key among structures of its kind: its number or the index of its name.
    pub(super) key: u32,
    pub(super) line: LineNumber,
    /// Index of its block.
    pub(super) head: u32,
    /// The jump of the branch being read to the next branch.
    pub(super) next: Option<usize>,
    /// Jumps past the end, as indices of the flow.
    pub(super) exits: Vec<usize>,
    /// Jumps to the closing word, as indices of the flow.
    pub(super) to_end: Vec<usize>,
    pub(super) counter: Option<Counter>,
}

/// Most structures that may be open at once.
pub(super) const MAX_OPEN: usize = 100;

/// The open structures, the innermost last.
#[derive(Debug, Default)]
pub(super) struct Structures {
    open: Vec<Open>,
}

/// The destination of a jump that is completed later.
pub(super) const UNKNOWN: Destination = Destination::Block(u32::MAX);

impl Structures {
    /// Opens a structure; returns `None` if too many are open.
    pub(super) fn push(&mut self, kind: Kind, key: u32, line: LineNumber, head: u32) -> Option<&mut Open> {
        if self.open.len() == MAX_OPEN {
            return None;
        }
        self.open.push(Open {
            kind,
            key,
            line,
            head,
            next: None,
            exits: Vec::new(),
            to_end: Vec::new(),
            counter: None,
        });
        self.open.last_mut()
    }

    /// Returns the innermost open structure of these kinds with this key.
    pub(super) fn find(&mut self, kinds: &[Kind], key: u32) -> Option<&mut Open> {
        self.open.iter_mut().rev().find(|open| open.key == key && kinds.contains(&open.kind))
    }

    /// Removes the innermost structure of these kinds with this key. Returns it with the structures within it that
    /// were not closed; `None` if there is none.
    pub(super) fn close(&mut self, kinds: &[Kind], key: u32) -> Option<(Open, Vec<Open>)> {
        let index = self.open.iter().rposition(|open| open.key == key && kinds.contains(&open.kind))?;
        let within = self.open.split_off(index + 1);
        Some((self.open.pop().expect("it was found there"), within))
    }

    /// Removes the structures and jumps of a block with a fault; `block` is its index, and `flow` the length of
    /// the flow before it.
    pub(super) fn drop_block(&mut self, block: u32, flow: usize) {
        self.open.retain(|open| open.head < block);
        for open in &mut self.open {
            open.next = open.next.filter(|index| *index < flow);
            for jumps in [&mut open.exits, &mut open.to_end] {
                while jumps.pop_if(|index| flow <= *index).is_some() {}
            }
        }
    }

    /// Returns the structures that were never closed.
    pub(super) fn finish(&mut self) -> Vec<Open> {
        std::mem::take(&mut self.open)
    }
}

impl Program {
    /// Adds an action of the block with this index; returns its index in the flow.
    pub(super) fn act(&mut self, block: u32, action: Action) -> usize {
        self.flow.push(Flow { block, action });
        self.flow.len() - 1
    }

    /// Completes the jumps at `indices` with the destination `block`.
    pub(super) fn complete(&mut self, indices: &[usize], block: u32) {
        for index in indices {
            match &mut self.flow[*index].action {
                Action::Jump { to, .. } => *to = Destination::Block(block),
                Action::Repeat { end } => *end = block,
                _ => {}
            }
        }
    }

    /// Adds a jump to a block still unknown; returns its index in the flow.
    pub(super) fn jump_later(&mut self, block: u32, when: When) -> usize {
        self.act(block, Action::Jump { to: UNKNOWN, when })
    }
}
