//! Diagnoses the cases of the stand-in, and measures what each explanation is worth on a program that
//! nothing was fitted to, beside those of its [`rivals`].
//!
//! ```text
//! cargo run --release --example standin -- generate --seed 7 --out CASES
//! cargo run --release --example proof -- CASES REPORTS        (REPORTS/case-NN/report.json, chart.svg, transfer.json)
//! cargo run --release --example standin -- score CASES REPORTS
//! ```
//!
//! `scripts/proof` runs the three. The answers are not read here; only `score` opens them. A case whose
//! report exists is passed over, so that a run that was cut off goes on where it was.

mod rivals;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use serde_json::{Value, json};
use truefeed::identification::diagnosis::diagnose;
use truefeed::identification::fit::{AlignedRun, AlignedRunError};
use truefeed::machine::Machine;
use truefeed::plot::{Theme, svg};
use truefeed::project::{DiagnosisReport, diagnosis_chart, machine_from_toml};
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;

use crate::rivals::Rivals;

/// The tolerance of the second program, in multiples of the first one's, as the stand-in writes it.
const TRANSFER: f64 = 2.0;

/// Width and height of the picture of a case, pixels.
const CHART: (u32, u32) = (900, 420);

/// What is wrong with a request, in one line.
type Refusal = Box<dyn std::error::Error + Send + Sync>;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(refusal) => {
            eprintln!("proof: {refusal}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<(), Refusal> {
    let folders: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [cases, reports] = &folders[..] else { return Err("give CASES and REPORTS".into()) };
    let mut all: Vec<PathBuf> =
        std::fs::read_dir(cases)?.map(|entry| Ok(entry?.path())).collect::<Result<_, Refusal>>()?;
    all.retain(|case| case.is_dir());
    all.sort();
    let next = AtomicUsize::new(0);
    let work = || -> Result<(), Refusal> {
        while let Some(case) = all.get(next.fetch_add(1, Ordering::Relaxed)) {
            let name = case.file_name().unwrap_or_default();
            let out = reports.join(name);
            if !out.join("report.json").exists() {
                let start = Instant::now();
                one(case, &out).map_err(|fault| format!("{}: {fault}", case.display()))?;
                eprintln!("{}: {:.1} s", name.to_string_lossy(), start.elapsed().as_secs_f64());
            }
        }
        Ok(())
    };
    let workers = std::thread::available_parallelism()?.get();
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        threads.into_iter().try_for_each(|thread| thread.join().map_err(|_| "a case panicked")?)
    })
}

/// Diagnoses a case, and measures on its second program where it has one.
fn one(case: &Path, out: &Path) -> Result<(), Refusal> {
    std::fs::create_dir_all(out)?;
    let machine = machine_from_toml(&std::fs::read_to_string(case.join("machine.toml"))?)?;
    let start = Instant::now();
    let (report, transfer) = match recorded(case, &machine)? {
        Err(AlignedRunError::Alignment(error)) => (DiagnosisReport::not_comparable(&error), None),
        Err(error) => return Err(error.into()),
        Ok(recorded) => {
            let run = recorded.run_ignoring_overrides();
            let diagnosis = diagnose(&machine, std::slice::from_ref(&run), &mut |_| {});
            let charts = diagnosis_chart(&diagnosis, &machine, std::slice::from_ref(&run), 0);
            let charts = Vec::from_iter(charts);
            let report = DiagnosisReport::new(&diagnosis, &["recording.csv".into()]).drawn_by(&charts);
            if let Some(picture) = charts.first().and_then(|run| svg(&run.chart, &Theme::LIGHT, CHART)) {
                std::fs::write(out.join("chart.svg"), picture)?;
            }
            let second = case.join("transfer");
            let transfer = second.exists().then(|| -> Result<Value, Refusal> {
                let other = recorded_at(&second, &machine)?;
                Ok(Rivals { machine: &machine, run: &run, diagnosed: &diagnosis.machine, ratio: TRANSFER }
                    .on(&other))
            });
            (report, transfer.transpose()?)
        }
    };
    if let Some(transfer) = transfer {
        std::fs::write(out.join("transfer.json"), serde_json::to_string_pretty(&transfer)?)?;
    }
    let mut report: Value = serde_json::from_str(&report.to_json())?;
    report["seconds_of_diagnosis"] = json!(start.elapsed().as_secs_f64());
    std::fs::write(out.join("report.json"), serde_json::to_string_pretty(&report)?)?;
    Ok(())
}

/// The program and the recording of a folder.
fn recorded(folder: &Path, machine: &Machine) -> Result<Result<AlignedRun, AlignedRunError>, Refusal> {
    let toolpath = trace(&read(&std::fs::read(folder.join("program.nc"))?), machine);
    Ok(AlignedRun::new(toolpath, &std::fs::read(folder.join("recording.csv"))?, machine))
}

/// The same where nothing speaks against a comparison.
fn recorded_at(folder: &Path, machine: &Machine) -> Result<AlignedRun, Refusal> {
    Ok(recorded(folder, machine)??)
}
