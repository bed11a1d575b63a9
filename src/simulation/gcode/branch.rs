//! Opening and closing words of all dialects: the jumps of branches and loops.
//!
//! ```text
//! IF c           jump to the next branch unless c          WHILE c    jump past the end unless c
//! ELSE, ELSEIF   jump past the end; the next branch        END        jump back to the opening word
//! ENDIF          past the end
//! ```

use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::structure::{Kind, Open};
use crate::simulation::gcode::{Action, Destination, When};

impl Reader<'_> {
    /// Opens a structure at the block being read; `columns` are those of its opening word.
    ///
    /// # Errors
    ///
    /// If too many structures are open.
    pub(super) fn open(&mut self, kind: Kind, key: u32, columns: (u32, u32)) -> Result<&mut Open, Refusal> {
        let (line, head) = (self.line, self.index());
        self.structures.push(kind, key, line, head).ok_or((Unread::DeepFlow, columns))
    }

    /// Closes the innermost structure of these kinds with this key, and remarks on those within it that were never
    /// closed. Returns `None` if there is none.
    pub(super) fn close(&mut self, kinds: &[Kind], key: u32) -> Option<Open> {
        let (open, within) = self.structures.close(kinds, key)?;
        for inner in within {
            self.unclosed(&inner);
        }
        Some(open)
    }

    /// Opens a branch whose condition was read.
    ///
    /// # Errors
    ///
    /// If too many structures are open.
    pub(super) fn open_branch(&mut self, key: u32, columns: (u32, u32)) -> Result<(), Refusal> {
        let jump = self.program.jump_later(self.index(), When::False);
        self.open(Kind::If, key, columns)?.next = Some(jump);
        Ok(())
    }

    /// Ends a branch with the block being read; another one follows. Returns `None` if no branch is open.
    pub(super) fn next_branch(&mut self, key: u32) -> Option<()> {
        let index = self.index();
        let exit = self.program.jump_later(index, When::Always);
        let open = self.structures.find(&[Kind::If], key)?;
        open.exits.push(exit);
        let jump = open.next.take();
        self.end_block();
        self.program.complete(jump.as_slice(), index + 1);
        Some(())
    }

    /// Closes a branch: the jumps out of its parts lead to the block being read. Returns `None` if no branch is
    /// open.
    pub(super) fn close_branch(&mut self, key: u32) -> Option<()> {
        let open = self.close(&[Kind::If], key)?;
        let jumps: Vec<usize> = open.next.into_iter().chain(open.exits).collect();
        self.program.complete(&jumps, self.index());
        Some(())
    }

    /// Opens a loop whose condition was read, and which ends when the condition is false.
    ///
    /// # Errors
    ///
    /// If too many structures are open.
    pub(super) fn open_while(&mut self, key: u32, columns: (u32, u32)) -> Result<(), Refusal> {
        let exit = self.program.jump_later(self.index(), When::False);
        self.open(Kind::While, key, columns)?.exits.push(exit);
        Ok(())
    }

    /// Ends a loop by a jump back to its opening word; the jumps out of the loop lead to the block after.
    pub(super) fn jump_back(&mut self, open: &Open) {
        self.act(Action::Jump { to: Destination::Block(open.head), when: When::Always });
        self.end_block();
        self.program.complete(&open.exits, self.index());
    }
}
