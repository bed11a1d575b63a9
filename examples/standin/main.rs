//! The project's own stand-in machine: recordings in which an effect is concealed, and the scoring of what a
//! diagnosis says about them.
//!
//! It shares no code with the predictor: only G-code text goes in, and only recording files come out.
//! Two kernels command the motion: [`fir`] samples the FIR interpolation in the time domain, so that with no
//! effect concealed the predictor's base model fits within noise; [`planner`] is a look-ahead planner with
//! limited jerk, a machine of another family. [`drive`] then bends the command, [`recorder`] samples it.
//! Everything follows from the seed.
//!
//! ```text
//! cargo run --release --example standin -- generate --seed 1 --out DIR [--singles N --negatives N
//!     --doubles N --outside N --ambiguous N --planners N]
//! cargo run --release --example standin -- score DIR REPORTS        (REPORTS/case-01/report.json …)
//! cargo run --release --example standin -- pictures DIR REPORTS --out docs/diagnosis
//! cargo run --release --example standin -- sample --out www/samples
//! ```

mod cases;
mod drive;
mod effects;
mod fir;
mod path;
mod physics;
mod pictures;
mod planner;
mod program;
mod ramp;
mod random;
mod reader;
mod recorder;
mod schedule;
mod score;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lexopt::prelude::*;

/// What is wrong with a request, in one line.
type Refusal = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(refusal) => {
            eprintln!("standin: {refusal}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<(), Refusal> {
    let mut arguments = lexopt::Parser::from_env();
    let (mut seed, mut out) = (1, None);
    let mut counts =
        cases::Counts { singles: 48, negatives: 16, doubles: 8, outside: 8, ambiguous: 4, planners: 4 };
    let mut words: Vec<PathBuf> = Vec::new();
    while let Some(argument) = arguments.next()? {
        match argument {
            Value(word) => words.push(word.into()),
            Long("seed") => seed = arguments.value()?.parse()?,
            Long("out") => out = Some(PathBuf::from(arguments.value()?)),
            Long("singles") => counts.singles = arguments.value()?.parse()?,
            Long("negatives") => counts.negatives = arguments.value()?.parse()?,
            Long("doubles") => counts.doubles = arguments.value()?.parse()?,
            Long("outside") => counts.outside = arguments.value()?.parse()?,
            Long("ambiguous") => counts.ambiguous = arguments.value()?.parse()?,
            Long("planners") => counts.planners = arguments.value()?.parse()?,
            other => return Err(other.unexpected().into()),
        }
    }
    let command = words.first().and_then(|word| word.to_str()).unwrap_or_default();
    match (command, out, &words[words.len().min(1)..]) {
        ("generate", Some(folder), []) => {
            let cases = cases::cases(seed, &counts);
            let seal = cases::write(&cases, &folder)?;
            println!("{} cases, answers sealed: {seal}", cases.len());
        }
        ("sample", Some(folder), []) => write_sample(&folder)?,
        ("score", None, [folder, reports]) => print!("{}", score::page(folder, reports)?),
        ("pictures", Some(out), [folder, reports]) => pictures::write(folder, reports, &out)?,
        _ => {
            return Err("say `generate --out DIR`, `sample --out DIR`, `score DIR REPORTS` or \
                        `pictures DIR REPORTS --out DIR`"
                .into());
        }
    }
    Ok(())
}

fn write_sample(folder: &Path) -> std::io::Result<()> {
    let sample = cases::sample();
    std::fs::create_dir_all(folder)?;
    std::fs::write(folder.join("standin.nc"), sample.program)?;
    std::fs::write(folder.join("standin.toml"), sample.machine)?;
    std::fs::write(folder.join("standin.csv"), sample.recording)?;
    println!("{}", sample.answer);
    Ok(())
}
