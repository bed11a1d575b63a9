//! Program flow as it is stored: where a block sends the program, apart from its words.
//!
//! Jumps, loops and subprograms of all dialects come down to a few actions on blocks. Structured
//! words (`WHILE … END`, `o100 if … o100 endif`, `FOR … ENDFOR`) are matched when the text is
//! read and become jumps to known blocks:
//!
//! ```text
//! while c    →  head:  jump to past if not c          if a      →  jump to next if not a
//!   …                    …                              …             …
//! endwhile   →         jump to head                   else      →  jump to past
//!               past:                                   …        next: …
//!                                                     endif     →  past:
//! ```
//!
//! Labels are looked up when they are reached, since a number may be worked out by the program.
//! A program without flow carries empty lists.

/// What one block does apart from its words.
#[derive(Clone, Debug, PartialEq)]
pub struct Flow {
    /// Index of its block.
    pub block: u32,
    /// What it does.
    pub action: Action,
}

/// An action on the order in which blocks are run.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Goes on elsewhere.
    Jump {
        /// Where.
        to: Destination,
        /// Under which condition.
        when: When,
    },
    /// Sets how often the [`Action::Again`] at `end` goes back, one less than the block's count;
    /// with a count of 0 goes on past it.
    Repeat {
        /// Index of the block with the `Again`.
        end: u32,
    },
    /// Goes back as often as was set or, where nothing was, as its own count says.
    Again {
        /// Where to.
        to: Destination,
    },
    /// Runs a subprogram with the block's arguments, as often as its count says, and comes back.
    Call {
        /// Which.
        to: Destination,
        /// Arguments not given have no value in it, and its numbered parameters are its own.
        has_own_parameters: bool,
    },
    /// Runs a section of the program once more, as often as the block's count says.
    Section {
        /// Where it begins.
        from: Label,
        /// Where it ends.
        until: SectionEnd,
    },
    /// Leaves the subprogram; at the top, ends the program.
    Return,
    /// Leaves the subprogram; at the top, does nothing.
    SubprogramEnd,
    /// Ends the program where no subprogram is being run: the text of a subprogram begins here.
    Border,
    /// Words of the block (M98, M99, G65 and the like) call or return, as their values say.
    Words,
    /// What the words would do is not to be run: the message is its index in
    /// [`Program::texts`](crate::simulation::gcode::Program::texts).
    Alarm {
        /// Index of the message.
        text: u32,
    },
}

/// Where a section that is run once more ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SectionEnd {
    /// After its first block.
    Block,
    /// After the block of this label.
    Label(Label),
    /// The same or, where there is no such label, before the block that asks for the section.
    LabelOrHere(Label),
}

/// When a jump is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Each time.
    Always,
    /// If the block's condition is not 0.
    True,
    /// If the block's condition is 0.
    False,
}

/// Where a jump or a call goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Destination {
    /// To this block; an index past the last one ends the program.
    Block(u32),
    /// To a label.
    Label(Label, Direction),
    /// To the label of this kind whose number the block works out.
    Computed(LabelKind),
}

/// Where a label is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// After the jump, then before it.
    Either,
    /// After the jump.
    Forward,
    /// Before the jump, the nearest first.
    Backward,
}

/// A name or number that a block can be found by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Label {
    /// What it names.
    pub kind: LabelKind,
    /// Its number, or the index of its name in [`Program::names`](crate::simulation::gcode::Program::names).
    pub id: u32,
}

/// What a label names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LabelKind {
    /// The block with an N number.
    Sequence,
    /// The program with an O number.
    Program,
    /// A numbered label or subroutine: `o100 sub`, `LBL 1`, `L100`.
    Numbered,
    /// A named label or subroutine: `o<bore> sub`, `LBL "A"`, `START:`.
    Named,
}
