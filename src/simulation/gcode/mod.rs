//! G-code bytes → blocks: what was written, not what the machine would do.
//!
//! Reading never fails: every byte sequence gives a [`Program`], and what could not be
//! understood is in its diagnostics, each with line and columns.

mod diagnostic;

pub use diagnostic::{Diagnostic, Severity};

/// 1-based number of a line in the program text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct LineNumber(pub u32);
