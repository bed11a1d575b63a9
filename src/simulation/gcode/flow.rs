//! Flow of a program: the actions of blocks on the order of execution.
//!
//! Jumps, loops and subprograms of all dialects become a few actions on blocks. The reader matches structured
//! words (`WHILE … END`, `o100 if … o100 endif`, `FOR … ENDFOR`) and turns them into jumps to known blocks:
//!
//! ```text
//! while c    →  head:  jump to past if not c          if a      →  jump to next if not a
//!   …                    …                              …             …
//! endwhile   →         jump to head                   else      →  jump to past
//!               past:                                   …        next: …
//!                                                     endif     →  past:
//! ```
//!
//! The interpreter looks up a label when it reaches the jump, since the program may compute its number. A program
//! without flow has empty lists.

/// The effect of one block on the order of execution.
#[derive(Clone, Debug, PartialEq)]
pub struct Flow {
    /// Index of its block.
    pub block: u32,
    /// Its action.
    pub action: Action,
}

/// An action on the order in which blocks are run.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Continues elsewhere.
    Jump {
        /// The destination.
        to: Destination,
        /// The condition.
        when: When,
    },
    /// Sets the number of jumps of the [`Action::Again`] at `end`, to one less than the block's count; with a
    /// count of 0, continues past it.
    Repeat {
        /// Index of the block with the `Again`.
        end: u32,
    },
    /// Jumps back as often as an [`Action::Repeat`] set or, without one, as its own count says.
    Again {
        /// The destination.
        to: Destination,
    },
    /// Runs a subprogram with the block's arguments, as often as its count says, and returns.
    Call {
        /// The subprogram.
        to: Destination,
        /// `true` if the subprogram has its own numbered parameters, in which arguments that are not given have no
        /// value.
        has_own_parameters: bool,
    },
    /// Runs a section of the program once more, as often as the block's count says.
    Section {
        /// The first block.
        from: Label,
        /// The end.
        until: SectionEnd,
    },
    /// Leaves the subprogram; in the main program, ends the program.
    Return,
    /// Leaves the subprogram; in the main program, does nothing.
    SubprogramEnd,
    /// Ends the program unless a subprogram is being run: the text of a subprogram begins here.
    Border,
    /// Calls or returns by words of the block (M98, M99, G65 and the like), as their values say.
    Words,
    /// Reports a message in place of an action that Truefeed cannot run.
    Alarm {
        /// Index of the message in [`Program::texts`](crate::simulation::gcode::Program::texts).
        text: u32,
    },
}

/// The end of a section that is run once more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SectionEnd {
    /// After its first block.
    Block,
    /// After the block of this label.
    Label(Label),
    /// After the block of this label; if there is no such label, before the block with this action.
    LabelOrHere(Label),
}

/// The condition of a jump.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Each time.
    Always,
    /// If the block's condition is not 0.
    True,
    /// If the block's condition is 0.
    False,
}

/// The destination of a jump or a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Destination {
    /// This block; an index past the last one ends the program.
    Block(u32),
    /// A label.
    Label(Label, Direction),
    /// The label of this kind whose number the block computes.
    Computed(LabelKind),
}

/// The direction in which a label is searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// After the jump, then before it.
    Either,
    /// After the jump.
    Forward,
    /// Before the jump, the nearest first.
    Backward,
}

/// A name or number by which a jump finds a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Label {
    /// The kind of block that it names.
    pub kind: LabelKind,
    /// Its number, or the index of its name in [`Program::names`](crate::simulation::gcode::Program::names).
    pub id: u32,
}

/// The kind of block that a label names.
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
