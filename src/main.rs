//! The command line: files in, text out, with the same core as the page.
//!
//! Exit status 0: done. 1: an archive is complete, and some of its lines contain an error. 2: the request
//! failed; one line on standard error states the fault and its place, and no file is written partially.

mod command;

use std::process::ExitCode;

use lexopt::prelude::*;
use truefeed::project::VERSION;

use crate::command::{CommandError, calibrate, diagnose, help, job, predict, print, probe};

fn main() -> ExitCode {
    match run(std::env::args_os()) {
        Ok(status) => status,
        Err(refusal) => {
            eprintln!("truefeed: {refusal}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: impl Iterator<Item = std::ffi::OsString>) -> Result<ExitCode, CommandError> {
    let mut parser = lexopt::Parser::from_iter(arguments);
    let done = match parser.next().map_err(|error| error.to_string())? {
        Some(Value(command)) => match &*command.to_string_lossy() {
            "predict" => return predict(&mut parser),
            "calibrate" => calibrate(&mut parser),
            "diagnose" => diagnose(&mut parser),
            "probe" => probe(&mut parser),
            "job" => job(&mut parser),
            unknown => Err(format!(
                "unknown command {unknown}; the commands are predict, calibrate, diagnose, probe and job"
            )),
        },
        Some(Long("help") | Short('h')) => print(help::OVERVIEW),
        Some(Long("version") | Short('V')) => print(&format!("truefeed {VERSION}")),
        Some(other) => Err(other.unexpected().to_string()),
        None => {
            Err("no command; try truefeed predict PROGRAM --machine M.toml, or truefeed --help".to_string())
        }
    };
    done.map(|()| ExitCode::SUCCESS)
}
