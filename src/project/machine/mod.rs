//! A machine as text: the machine file, the form of the page, and the values that both write.

pub mod file;
pub mod form;
pub mod written;
