//! `truefeed diagnose`: the differences between recordings and simulation, and the physical effects behind
//! them.

use std::path::{Path, PathBuf};

use lexopt::prelude::*;
use truefeed::identification::diagnosis::diagnose as diagnosed;
use truefeed::identification::fit::{AlignedRun, AlignedRunError, Run};
use truefeed::identification::measured::measure;
use truefeed::project::{DiagnosisReport, extended, toml_from_machine};

use crate::command::input::machine_of;
use crate::command::output::Output;
use crate::command::runs::{INTERVAL_OPTION, ProgramRun, options, refusal};
use crate::command::{CommandError, help, once, print, value};

/// Runs `diagnose`.
pub fn diagnose(parser: &mut lexopt::Parser) -> Result<(), CommandError> {
    let (mut machine, mut out, mut interval, mut json) = (None, None, None, false);
    let (mut files, mut pairs): (Vec<PathBuf>, Vec<ProgramRun>) = (Vec::new(), Vec::new());
    while let Some(argument) = parser.next().map_err(|error| error.to_string())? {
        match argument {
            Long("machine") => once(&mut machine, value(parser)?, "--machine")?,
            Long("out") => once(&mut out, value(parser)?, "--out")?,
            Long("run") => pairs.push(ProgramRun::of_option(parser)?),
            Long("interval-s") => once(&mut interval, value(parser)?, INTERVAL_OPTION)?,
            Long("json") => json = true,
            Long("help") | Short('h') => return print(help::DIAGNOSE),
            Value(file) if files.len() < 2 => files.push(file.into()),
            other => return Err(other.unexpected().to_string()),
        }
    }
    let machine: PathBuf = machine.ok_or("no machine; give --machine M.toml")?;
    match <[PathBuf; 2]>::try_from(files) {
        Ok([program, recording]) => pairs.insert(0, ProgramRun { program, recording }),
        Err(files) if !files.is_empty() || pairs.is_empty() => {
            return Err("no run; give PROGRAM RECORDING".to_string());
        }
        Err(_) => {}
    }
    let inputs: Vec<&Path> = pairs.iter().flat_map(ProgramRun::paths).chain([&*machine]).collect();
    let out = out.map(|out| Output::new(out, &inputs)).transpose()?;
    let machine = machine_of(&machine)?;
    let options = options(interval)?;
    let mut recorded: Vec<AlignedRun> = Vec::new();
    for pair in &pairs {
        match pair.read(&machine, &options)? {
            Ok(own) => recorded.push(own),
            Err(AlignedRunError::Alignment(error)) if pairs.len() == 1 => {
                let report = DiagnosisReport::not_comparable(&error);
                return print(&if json { report.to_json() } else { report.to_text() });
            }
            Err(error) => return Err(refusal(&pair.recording, &error)),
        }
    }
    // Recorded switches are ignored, so that the diagnosis finds the operator's actions with or without them.
    let runs: Vec<Run> = recorded.iter().map(AlignedRun::run_ignoring_overrides).collect();
    let names: Vec<String> = pairs.iter().map(ProgramRun::name).collect();
    let diagnosis = diagnosed(&machine, &runs, &mut |_| {});
    let measured = measure(&diagnosis.machine, &runs);
    let report = DiagnosisReport::new(&diagnosis, &names).aligned(&recorded[0].alignment).measured(&measured);
    if let Some(out) = out {
        out.write(&toml_from_machine(&extended(&diagnosis.machine, &names)))?;
    }
    print(&if json { report.to_json() } else { report.to_text() })
}
