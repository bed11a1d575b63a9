//! Laws of the work at one hole.
use super::*;
