//! How wide the ranges of calibrated machines are, and how often they hold the truth: each machine is calibrated on some
//! of its programs, and predicts the motion of the others.
//!
//! ```text
//! cargo run --release --example ranges -- [--programs N] FOLDER...
//! ```
//!
//! A folder holds recordings of one control with `answers.json` as those in `../shared/recordings` (runs by file, of
//! which the clean ones are taken), or as `examples/controller` records them (programs with a clean run each, by machine).
//! Of machines with more than N programs each N that follow one another are calibrated on, N being 1 where it is not said.
//! What is compared is the time of the motion between the first and the last mark of the alignment.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde_json::Value;
use truefeed::identification::calibration::calibrate;
use truefeed::identification::comparison::compare;
use truefeed::identification::fit::{AlignedRun, Run};
use truefeed::identification::measured::calibrated_on;
use truefeed::machine::Machine;
use truefeed::project::machine_from_toml;
use truefeed::quote::range;
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;

/// A machine file that knows nothing of the control.
const GENERIC: &str = include_str!("../../tests/data/machines/generic.toml");

type Refusal = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(refusal) => {
            eprintln!("ranges: {refusal}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<(), Refusal> {
    let (mut programs, mut folders) = (1, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match &*argument {
            "--programs" => {
                programs = arguments.next().ok_or("--programs: how many?")?.parse::<usize>()?.max(1)
            }
            _ => folders.push(PathBuf::from(argument)),
        }
    }
    let machine = machine_from_toml(GENERIC).map_err(|faults| format!("{faults:?}"))?;
    println!("| machine | calibrated on | program | error | range | not shown |");
    println!("| --- | --- | --- | ---: | ---: | --- |");
    let mut all: Vec<(f64, f64)> = Vec::new();
    for folder in &folders {
        for (name, pairs) in machines(folder)? {
            all.extend(of_machine(&machine, &name, &pairs, programs)?);
        }
    }
    summary(&all);
    Ok(())
}

/// The clean runs of each machine in a folder: program and recording.
fn machines(folder: &Path) -> Result<BTreeMap<String, Vec<[PathBuf; 2]>>, Refusal> {
    let answers: Value = serde_json::from_slice(&std::fs::read(folder.join("answers.json"))?)?;
    let control = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut machines: BTreeMap<String, Vec<[PathBuf; 2]>> = BTreeMap::new();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
    if let Some(programs) = answers["programs"].as_array() {
        for program in programs {
            let own = folder.join(text(&program["name"]));
            let pair = [own.join("program.ngc"), own.join("clean.csv.gz")];
            machines.entry(format!("{control} {}", program["machine"])).or_default().push(pair);
        }
        return Ok(machines);
    }
    let runs = answers.as_object().ok_or("answers.json: expected an object")?;
    for (run, answer) in runs.iter().filter(|(_, answer)| answer["effect"].is_null()) {
        let pair = [folder.join(text(&answer["program"])), folder.join(run)];
        machines.entry(control.clone()).or_default().push(pair);
    }
    Ok(machines)
}

/// Size of the error and half of the range of each program that a machine was not calibrated on.
fn of_machine(
    generic: &Machine,
    name: &str,
    pairs: &[[PathBuf; 2]],
    programs: usize,
) -> Result<Vec<(f64, f64)>, Refusal> {
    let mut recorded: Vec<(String, AlignedRun)> = Vec::new();
    for [program, recording] in pairs {
        let toolpath = trace(&read(&std::fs::read(program)?), generic);
        let label = recording.strip_prefix(recording.ancestors().nth(2).unwrap_or(recording))?;
        match AlignedRun::new(toolpath, &std::fs::read(recording)?, generic) {
            Ok(own) => recorded.push((label.display().to_string(), own)),
            Err(error) => eprintln!("{}: {error}", recording.display()),
        }
    }
    let mut all = Vec::new();
    let count = recorded.len();
    for first in (0..count).filter(|_| programs < count) {
        let chosen: Vec<usize> = (0..programs).map(|at| (first + at) % count).collect();
        let runs: Vec<Run> = chosen.iter().map(|at| recorded[*at].1.run()).collect();
        let found = calibrate(generic, &runs, &mut |_| {});
        let mut machine = found.machine;
        machine.calibrated_on = calibrated_on(&machine, &runs, &found.fitted);
        let names: Vec<&str> = chosen.iter().map(|at| &*recorded[*at].0).collect();
        for other in (0..count).filter(|other| !chosen.contains(other)) {
            let (label, own) = &recorded[other];
            let run = own.run();
            let plan = run.plan(&machine);
            let motion = compare(run.toolpath, &plan, run.alignment).motion;
            let error = motion.simulated / motion.recorded - 1.0;
            let Some(range) = range(run.toolpath, &machine, &plan) else { continue };
            let unshown: Vec<String> = (range.unshown.iter())
                .map(|(what, share)| format!("{} {:.1} %", what.words(), 100.0 * share))
                .collect();
            println!(
                "| {name} | {} | {label} | {:+.2} % | ±{:.2} % | {} |",
                names.join(", "),
                100.0 * error,
                100.0 * range.ratio,
                unshown.join(", ")
            );
            all.push((error.abs(), range.ratio));
        }
    }
    Ok(all)
}

/// How often the range holds the error, and how large both are.
fn summary(all: &[(f64, f64)]) {
    let held = all.iter().filter(|(error, range)| error <= range).count();
    let median = |of: fn(&(f64, f64)) -> f64| {
        let mut values: Vec<f64> = all.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).map_or(f64::NAN, |value| 100.0 * value)
    };
    let worst = all.iter().map(|(error, _)| 100.0 * error).fold(0.0, f64::max);
    println!(
        "\nThe range holds {held} of {}; its median width is {:.1} %. Errors: {:.2} % in the median, {worst:.2} % at worst.",
        all.len(),
        2.0 * median(|(_, range)| *range),
        median(|(error, _)| *error),
    );
}
