//! `truefeed probe`: a short program on which two causes look different.

use lexopt::prelude::*;

use crate::command::{Refusal, value};

/// Carries out `probe`.
pub fn probe(parser: &mut lexopt::Parser) -> Result<(), Refusal> {
    while let Some(argument) = parser.next().map_err(|error| error.to_string())? {
        match argument {
            Long("machine") => drop(value(parser)?),
            other => return Err(other.unexpected().to_string()),
        }
    }
    Err(String::new())
}
