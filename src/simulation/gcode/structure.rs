//! Structured flow → jumps: loops, branches and subprograms by the words that open and close them.
//!
//! Each opening word is kept until its closing word is met; the jumps it stands for are entered
//! where they are known, and completed when the closing word says where they go. A closing word
//! whose opening is missing, and an opening that is never closed, are said and do nothing, so that
//! the blocks between are run once.

use crate::simulation::gcode::{Action, Destination, Flow, LineNumber, Program, Step, When};

/// What is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Tested at its head.
    While,
    /// Tested at its end, or never.
    Do,
    /// Counted.
    Repeat,
    /// A branch.
    If,
    /// A subprogram.
    Sub,
    /// Counted by a variable.
    For,
}

impl Kind {
    /// How the opening word is written.
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
    /// Leaves its value.
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
    /// What tells it from others of its kind: its number or the index of its name.
    pub(super) key: u32,
    pub(super) line: LineNumber,
    /// Index of its block.
    pub(super) head: u32,
    /// The jump of the branch being read to the next branch.
    pub(super) next: Option<usize>,
    /// Jumps to past the end, as indices of the flow.
    pub(super) exits: Vec<usize>,
    /// Jumps to the closing word, as indices of the flow.
    pub(super) to_end: Vec<usize>,
    pub(super) counter: Option<Counter>,
}

/// The most that may be open at once.
pub(super) const MAX_OPEN: usize = 100;

/// Everything open, the innermost last.
#[derive(Debug, Default)]
pub(super) struct Structures {
    open: Vec<Open>,
}

/// A jump that is completed later.
pub(super) const UNKNOWN: Destination = Destination::Block(u32::MAX);

impl Structures {
    /// Opens one, or `None` if too many are open.
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

    /// The innermost open one of these kinds with this key.
    pub(super) fn find(&mut self, kinds: &[Kind], key: u32) -> Option<&mut Open> {
        self.open.iter_mut().rev().find(|open| open.key == key && kinds.contains(&open.kind))
    }

    /// Takes out the innermost one of these kinds with this key; what was opened within it and not
    /// closed is given back to be said.
    pub(super) fn close(&mut self, kinds: &[Kind], key: u32) -> Option<(Open, Vec<Open>)> {
        let index = self.open.iter().rposition(|open| open.key == key && kinds.contains(&open.kind))?;
        let within = self.open.split_off(index + 1);
        Some((self.open.pop().expect("it was found there"), within))
    }

    /// Forgets what a block with a fault opened and the jumps it entered; `block` is its index, and
    /// `flow` the length of the flow before it.
    pub(super) fn drop_block(&mut self, block: u32, flow: usize) {
        self.open.retain(|open| open.head < block);
        for open in &mut self.open {
            open.next = open.next.filter(|index| *index < flow);
            for jumps in [&mut open.exits, &mut open.to_end] {
                while jumps.pop_if(|index| flow <= *index).is_some() {}
            }
        }
    }

    /// Everything that was never closed.
    pub(super) fn finish(&mut self) -> Vec<Open> {
        std::mem::take(&mut self.open)
    }
}

impl Program {
    /// Enters an action of the block with this index; returns its index in the flow.
    pub(super) fn act(&mut self, block: u32, action: Action) -> usize {
        self.flow.push(Flow { block, action });
        self.flow.len() - 1
    }

    /// Completes the jumps at `indices`.
    pub(super) fn complete(&mut self, indices: &[usize], block: u32) {
        for index in indices {
            match &mut self.flow[*index].action {
                Action::Jump { to, .. } => *to = Destination::Block(block),
                Action::Repeat { end } => *end = block,
                _ => {}
            }
        }
    }

    /// A jump to a block still unknown; returns its index in the flow.
    pub(super) fn jump_later(&mut self, block: u32, when: When) -> usize {
        self.act(block, Action::Jump { to: UNKNOWN, when })
    }
}
