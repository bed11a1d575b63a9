//! `truefeed calibrate`: a machine file fitted to recordings.

use std::path::PathBuf;

use lexopt::prelude::*;
use truefeed::identification::calibration::calibrate as fitted;
use truefeed::identification::fit::{Recorded, Run};
use truefeed::project::{CalibrationReport, toml_from_machine};

use crate::command::runs::{Pair, refusal};
use crate::command::{Refusal, machine_of, once, print, value, write_whole};

/// Carries out `calibrate`.
pub fn calibrate(parser: &mut lexopt::Parser) -> Result<(), Refusal> {
    let (mut machine, mut out, mut pairs, mut json) = (None, None, Vec::new(), false);
    while let Some(argument) = parser.next().map_err(|error| error.to_string())? {
        match argument {
            Long("machine") => once(&mut machine, value(parser)?, "--machine")?,
            Long("out") => once(&mut out, value(parser)?, "--out")?,
            Long("run") => pairs.push(Pair::of_option(parser)?),
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
    let machine = machine_of(&machine)?;
    let mut recorded: Vec<Recorded> = Vec::new();
    for pair in &pairs {
        recorded.push(pair.read(&machine)?.map_err(|error| refusal(&pair.recording, &error))?);
    }
    let runs: Vec<Run> = recorded.iter().map(Recorded::run).collect();
    let names: Vec<String> = pairs.iter().map(Pair::name).collect();
    let report = CalibrationReport::new(&machine, &fitted(&machine, &runs, &mut |_| {}), &names);
    let machine = report.machine().map_err(|faults| {
        let faults: Vec<String> = faults.iter().map(ToString::to_string).collect();
        format!("the fit left the bounds of the machine file: {}", faults.join("; "))
    })?;
    write_whole(&out, &toml_from_machine(&machine))?;
    print(&if json { report.to_json() } else { report.to_text() })
}
