//! `truefeed calibrate`: a machine file fitted to recordings.

use std::path::{Path, PathBuf};

use lexopt::prelude::*;
use truefeed::identification::calibration::calibrate as fitted;
use truefeed::identification::diagnosis::ModelError;
use truefeed::identification::fit::{AlignedRun, Run};
use truefeed::identification::measured::{calibrated_on, measure};
use truefeed::identification::recording::ReadingOptions;
use truefeed::project::{CalibrationReport, MoveReport, toml_from_machine};

use crate::command::input::{bytes_of, machine_of};
use crate::command::output::Output;
use crate::command::runs::{INTERVAL_OPTION, ProgramRun, options, refusal};
use crate::command::{CommandError, help, once, print, value};

/// Runs `calibrate`.
pub fn calibrate(parser: &mut lexopt::Parser) -> Result<(), CommandError> {
    let (mut machine, mut out, mut interval) = (None, None, None);
    let (mut pairs, mut moves, mut json) = (Vec::new(), Vec::<PathBuf>::new(), false);
    while let Some(argument) = parser.next().map_err(|error| error.to_string())? {
        match argument {
            Long("machine") => once(&mut machine, value(parser)?, "--machine")?,
            Long("out") => once(&mut out, value(parser)?, "--out")?,
            Long("run") => pairs.push(ProgramRun::of_option(parser)?),
            Long("move") => moves.push(value(parser)?.into()),
            Long("interval-s") => once(&mut interval, value(parser)?, INTERVAL_OPTION)?,
            Long("json") => json = true,
            Long("help") | Short('h') => return print(help::CALIBRATE),
            other => return Err(other.unexpected().to_string()),
        }
    }
    let machine: PathBuf = machine.ok_or("no machine; give --machine M.toml")?;
    let out: PathBuf = out.ok_or("no output; give --out FITTED.toml")?;
    if pairs.is_empty() && moves.is_empty() {
        return Err(
            "no runs; give --run PROGRAM RECORDING, once or several times, or --move RECORDING".to_string()
        );
    }
    let inputs = pairs.iter().flat_map(ProgramRun::paths).chain(moves.iter().map(|path| &**path));
    let inputs: Vec<&Path> = inputs.chain([&*machine]).collect();
    let out = Output::new(out, &inputs)?;
    let mut machine = machine_of(&machine)?;
    let options = options(interval)?;
    let mut told = Vec::new();
    for path in &moves {
        let report = of_move(path, &options)?;
        machine = report.apply(&machine);
        told.push(report);
    }
    if pairs.is_empty() {
        out.write(&toml_from_machine(&machine))?;
        let of_all = |of: fn(&MoveReport) -> String| told.iter().map(of).collect::<Vec<_>>().join("\n");
        return print(&of_all(if json { MoveReport::to_json } else { MoveReport::to_text }));
    }
    let mut recorded: Vec<AlignedRun> = Vec::new();
    for pair in &pairs {
        recorded.push(pair.read(&machine, &options)?.map_err(|error| refusal(&pair.recording, &error))?);
    }
    let runs: Vec<Run> = recorded.iter().map(AlignedRun::run).collect();
    let names: Vec<String> = pairs.iter().map(ProgramRun::name).collect();
    let mut calibration = fitted(&machine, &runs, &mut |_| {});
    let error = ModelError::of(&calibration.machine, &runs);
    let measured = measure(&calibration.machine, &runs);
    calibration.machine.calibrated_on = calibrated_on(&calibration.machine, &runs, &calibration.fitted);
    let report = CalibrationReport::new(&machine, &calibration, error, &names).measured(&measured);
    let machine = report.machine().map_err(|faults| {
        let faults: Vec<String> = faults.iter().map(ToString::to_string).collect();
        format!("the fit left the bounds of the machine file: {}", faults.join("; "))
    })?;
    out.write(&toml_from_machine(&machine))?;
    print(&if json { report.to_json() } else { report.to_text() })
}

/// Identifies the filters from the recording of one move.
fn of_move(path: &Path, options: &ReadingOptions) -> Result<MoveReport, CommandError> {
    let name = path.file_name().unwrap_or(path.as_os_str());
    MoveReport::read(&bytes_of(path)?, options, &name.to_string_lossy())
}
