//! `truefeed probe`: a short program that separates two causes.

use std::path::PathBuf;

use lexopt::prelude::*;
use truefeed::identification::probe::{probe_all, probe_between};

use crate::command::input::machine_of;
use crate::command::output::Output;
use crate::command::{CommandError, help, once, print, value};

/// Runs `probe`.
pub fn probe(parser: &mut lexopt::Parser) -> Result<(), CommandError> {
    let (mut machine, mut out) = (None, None);
    let mut between: Option<[String; 2]> = None;
    while let Some(argument) = parser.next().map_err(|error| error.to_string())? {
        match argument {
            Long("machine") => once(&mut machine, value(parser)?, "--machine")?,
            Long("out") => once(&mut out, value(parser)?, "--out")?,
            Long("between") => {
                if between.is_some() {
                    return Err("--between is given twice".to_string());
                }
                let mut values = parser
                    .values()
                    .map_err(|_| "--between needs two causes")?
                    .map(|word| word.to_string_lossy().into_owned());
                let pair = values.next().zip(values.next());
                let (one, other) = pair.ok_or("--between needs two causes: --between CAUSE CAUSE")?;
                if let Some(more) = values.next() {
                    return Err(format!("--between takes two causes; remove {more}"));
                }
                between = Some([one, other]);
            }
            Long("help") | Short('h') => return print(help::PROBE),
            other => return Err(other.unexpected().to_string()),
        }
    }
    let machine: PathBuf = machine.ok_or("no machine; give --machine M.toml")?;
    let out = out.map(|out| Output::new(out, &[&*machine])).transpose()?;
    let machine = machine_of(&machine)?;
    let probe = match &between {
        Some([one, other]) => probe_between(&machine, [one, other]).map_err(|error| error.to_string())?,
        None => probe_all(&machine),
    };
    match out {
        Some(out) => {
            out.write(&probe.program)?;
            print(&probe.summary.join("\n"))
        }
        None => print(probe.program.trim_end()),
    }
}
