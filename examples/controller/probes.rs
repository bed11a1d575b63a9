//! The project's probe, recorded on each machine of a folder: what one recording is worth that exercises every limit.
//!
//! The tool under test writes it for the machine file that a user begins with, since nobody knows the machine yet.

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use crate::judge::Bench;
use crate::machine::Limits;
use crate::recorder::{Outcome, Recorder};
use crate::trace::Scale;
use crate::{Refusal, side_by_side};

/// Milliseconds between two rows.
const EVERY: usize = 4;

/// Records the probe on each machine of `folder`, and adds what was recorded to the answers there.
pub fn record(bench: &Bench, recorder: &Recorder, folder: &Path) -> Result<(), Refusal> {
    let place = folder.join("answers.json");
    let mut answers: Value = serde_json::from_slice(&std::fs::read(&place)?)?;
    let program = folder.join("probe.ngc");
    write(bench, folder, &program)?;
    let programs = answers["programs"].as_array().ok_or("the answers name no programs")?;
    let mut machines: Vec<(&Value, &Value)> =
        programs.iter().map(|program| (&program["machine"], &program["limits"])).collect();
    machines.dedup();
    let probes = side_by_side(bench.jobs, machines.len(), |number| {
        let (machine, limits) = machines[number];
        let name = format!("m{machine:02}");
        let place = folder.join(&name);
        std::fs::create_dir_all(&place)?;
        std::fs::copy(&program, place.join("program.ngc"))?;
        let run = match recorder.record(
            &program,
            &place.join("raw.csv.gz"),
            EVERY,
            &Limits::from_json(limits).options(),
        )? {
            Outcome::Recorded(run) => run,
            Outcome::Refused(why) => return Err(format!("{name}: {why}").into()),
        };
        run.write(&place.join("clean.csv.gz"), Scale::Command)?;
        eprintln!("{name}: probe, {:.1} s", run.duration());
        Ok(json!({ "name": name, "kind": "probe", "machine": machine, "limits": limits,
                   "row_ms": EVERY, "clean_seconds": run.duration() }))
    })?;
    answers["probes"] = json!(probes);
    std::fs::write(place, serde_json::to_string_pretty(&answers)?)?;
    Ok(())
}

/// Lets the tool under test write the probe.
fn write(bench: &Bench, folder: &Path, program: &Path) -> Result<(), Refusal> {
    let preset = folder.join("preset.toml");
    std::fs::write(&preset, bench.begin_with()?)?;
    let mut command = Command::new(&bench.truefeed);
    let status = command.arg("probe").arg("--machine").arg(&preset).arg("--out").arg(program).status()?;
    if status.success() { Ok(()) } else { Err(format!("truefeed probe ended with {status}").into()) }
}
