//! Cutting forces as text: the file of a cutting job, the tools that a program describes, and the results.

pub mod file;
pub mod results;
pub mod tool_list;
