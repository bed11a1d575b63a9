//! `truefeed calibrate`: a machine file fitted to recordings.

use std::path::{Path, PathBuf};

use lexopt::prelude::*;
use truefeed::identification::calibration::calibrate as fitted;
use truefeed::identification::diagnosis::ModelError;
use truefeed::identification::fit::{Recorded, Run};
use truefeed::project::{CalibrationReport, toml_from_machine};

use crate::command::input::machine_of;
use crate::command::output::Output;
use crate::command::runs::{INTERVAL, Pair, options, refusal};
use crate::command::{Refusal, once, print, value};

/// Carries out `calibrate`.
pub fn calibrate(parser: &mut lexopt::Parser) -> Result<(), Refusal> {
    let (mut machine, mut out, mut interval) = (None, None, None);
    let (mut pairs, mut json) = (Vec::new(), false);
    while let Some(argument) = parser.next().map_err(|error| error.to_string())? {
        match argument {
            Long("machine") => once(&mut machine, value(parser)?, "--machine")?,
            Long("out") => once(&mut out, value(parser)?, "--out")?,
            Long("run") => pairs.push(Pair::of_option(parser)?),
            Long("interval-s") => once(&mut interval, value(parser)?, INTERVAL)?,
            Long("json") => json = true,
            Long("help") | Short('h') => return print(crate::USAGE),
            other => return Err(other.unexpected().to_string()),
        }
    }
    let machine: PathBuf = machine.ok_or("which machine? Give --machine M.toml")?;
    let out: PathBuf = out.ok_or("where to? Give --out FITTED.toml")?;
    if pairs.is_empty() {
        return Err("from which runs? Give --run PROGRAM RECORDING, once or several times".to_string());
    }
    let inputs: Vec<&Path> = pairs.iter().flat_map(Pair::paths).chain([&*machine]).collect();
    let out = Output::new(out, &inputs)?;
    let machine = machine_of(&machine)?;
    let options = options(interval)?;
    let mut recorded: Vec<Recorded> = Vec::new();
    for pair in &pairs {
        recorded.push(pair.read(&machine, &options)?.map_err(|error| refusal(&pair.recording, &error))?);
    }
    let runs: Vec<Run> = recorded.iter().map(Recorded::run).collect();
    let names: Vec<String> = pairs.iter().map(Pair::name).collect();
    let calibration = fitted(&machine, &runs, &mut |_| {});
    let error = ModelError::of(&calibration.machine, &runs);
    let report = CalibrationReport::new(&machine, &calibration, error, &names);
    let machine = report.machine().map_err(|faults| {
        let faults: Vec<String> = faults.iter().map(ToString::to_string).collect();
        format!("the fit left the bounds of the machine file: {}", faults.join("; "))
    })?;
    out.write(&toml_from_machine(&machine))?;
    print(&if json { report.to_json() } else { report.to_text() })
}
