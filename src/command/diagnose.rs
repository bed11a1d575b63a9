//! `truefeed diagnose`: where recordings differ from the simulation, and which physics was left out.

use std::path::{Path, PathBuf};

use lexopt::prelude::*;
use truefeed::identification::diagnosis::diagnose as diagnosed;
use truefeed::identification::fit::{Recorded, RecordedError, Run};
use truefeed::project::{DiagnosisReport, extended, toml_from_machine};

use crate::command::input::machine_of;
use crate::command::output::Output;
use crate::command::runs::{INTERVAL, Pair, options, refusal};
use crate::command::{Refusal, once, print, value};

/// Carries out `diagnose`.
pub fn diagnose(parser: &mut lexopt::Parser) -> Result<(), Refusal> {
    let (mut machine, mut out, mut interval, mut json) = (None, None, None, false);
    let (mut files, mut pairs): (Vec<PathBuf>, Vec<Pair>) = (Vec::new(), Vec::new());
    while let Some(argument) = parser.next().map_err(|error| error.to_string())? {
        match argument {
            Long("machine") => once(&mut machine, value(parser)?, "--machine")?,
            Long("out") => once(&mut out, value(parser)?, "--out")?,
            Long("run") => pairs.push(Pair::of_option(parser)?),
            Long("interval-s") => once(&mut interval, value(parser)?, INTERVAL)?,
            Long("json") => json = true,
            Long("help") | Short('h') => return print(crate::USAGE),
            Value(file) if files.len() < 2 => files.push(file.into()),
            other => return Err(other.unexpected().to_string()),
        }
    }
    let machine: PathBuf = machine.ok_or("which machine? Give --machine M.toml")?;
    match <[PathBuf; 2]>::try_from(files) {
        Ok([program, recording]) => pairs.insert(0, Pair { program, recording }),
        Err(files) if !files.is_empty() || pairs.is_empty() => {
            return Err("which run? Give PROGRAM RECORDING".to_string());
        }
        Err(_) => {}
    }
    let inputs: Vec<&Path> = pairs.iter().flat_map(Pair::paths).chain([&*machine]).collect();
    let out = out.map(|out| Output::new(out, &inputs)).transpose()?;
    let machine = machine_of(&machine)?;
    let options = options(interval)?;
    let mut recorded: Vec<Recorded> = Vec::new();
    for pair in &pairs {
        match pair.read(&machine, &options)? {
            Ok(own) => recorded.push(own),
            Err(RecordedError::Alignment(error)) if pairs.len() == 1 => {
                let report = DiagnosisReport::not_comparable(&error);
                return print(&if json { report.to_json() } else { report.to_text() });
            }
            Err(error) => return Err(refusal(&pair.recording, &error)),
        }
    }
    // What the operator did is to be found, whether or not a switch was recorded.
    let runs: Vec<Run> = recorded.iter().map(Recorded::unswitched).collect();
    let names: Vec<String> = pairs.iter().map(Pair::name).collect();
    let diagnosis = diagnosed(&machine, &runs, &mut |_| {});
    let report = DiagnosisReport::new(&diagnosis, &names).aligned(&recorded[0].alignment);
    if let Some(out) = out {
        out.write(&toml_from_machine(&extended(&diagnosis.machine, &names)))?;
    }
    print(&if json { report.to_json() } else { report.to_text() })
}
