//! The command line: files in, text out, over the same core as the page.
//!
//! Exit status 0: done. 1: done for an archive, and some of its lines say an error. 2: the request cannot be carried out;
//! one line on standard error says what is wrong and where, and no file is written in part.

mod command;

use std::process::ExitCode;

use lexopt::prelude::*;
use truefeed::project::VERSION;

use crate::command::{Refusal, calibrate, diagnose, predict, print, probe};

const USAGE: &str = "\
truefeed predict   PROGRAM --machine M.toml [--tolerance MM]... [--dialect D] [--arc-centres A] [--json]
                   [--profile OUT.csv] [--cutting JOB.toml [--forces OUT.csv]]
truefeed predict   PROGRAM|FOLDER... --machine M.toml --ndjson [--out OUT.ndjson] [--list] [--jobs N]
                   [--tolerance MM]... [--dialect D] [--arc-centres A]
truefeed calibrate --machine M.toml --run PROGRAM RECORDING [--run PROGRAM RECORDING]... --out FITTED.toml [--json]
                   [--interval-s S]
truefeed diagnose  PROGRAM RECORDING [--run PROGRAM RECORDING]... --machine M.toml [--json] [--out EXTENDED.toml]
                   [--interval-s S]
truefeed probe     --machine M.toml [--between CAUSE CAUSE] [--out PROGRAM]

predict: what the machine will do with a G-code program: cycle time for each contour tolerance.
PROGRAM is a G-code file, or - for standard input. Without --tolerance the program's own tolerances
hold (G64 P, G187 E and so on), and the machine's where it sets none; a --tolerance replaces all of
them, but for exact stops.
The control the program was written for is found by what stands in it; --dialect chooses it: iso,
linuxcnc, siemens, klartext, heidenhain-iso, grbl, mach or okuma.
Where neither program nor control say what I, J and K of arcs count from, the arcs that close tell;
--arc-centres incremental or absolute chooses it.
What is in doubt is by how much the time may be off for what the program leaves open or Truefeed does not read.
--json prints the result as JSON; --profile writes time, distance, feedrate, position and line
for the first tolerance.
--cutting adds what the cut asks of tool and spindle: stock, tools, material and limits are in JOB.toml.
--forces writes force, torque, power and removal rate along the path, by the programmed and by the
predicted feedrate, for the first tolerance.
--ndjson takes many programs and folders, and prints a line of JSON for each as it is done, on all
processors; --out adds the lines to a file and leaves out programs whose lines it has already, so that a run
that was stopped goes on. A program that cannot be read gets a line with an error, and the exit status is 1.
--list only prints what there is to do; --jobs sets how many programs are at work at a time.

calibrate: fits filters, tolerance, rapid feedrate and the times of changes to recordings of real runs, and
writes the machine file that predicts the next program.
diagnose: says where a recording differs from the simulation, which physics was left out and how sure that
is; --out writes the machine file extended by it.
probe: writes a short program on which two causes look different; CAUSE is an id as diagnose names it.
Without --between the program exercises every effect.
RECORDING is a log of the machine: CSV, MTConnect, halsampler, scope or trace files are told by content, also
packed by gzip or alone in a ZIP archive. --interval-s is the time between the rows of one without a column of time.";

fn main() -> ExitCode {
    match run(std::env::args_os()) {
        Ok(status) => status,
        Err(refusal) => {
            eprintln!("truefeed: {refusal}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: impl Iterator<Item = std::ffi::OsString>) -> Result<ExitCode, Refusal> {
    let mut parser = lexopt::Parser::from_iter(arguments);
    let done = match parser.next().map_err(|error| error.to_string())? {
        Some(Value(command)) => match &*command.to_string_lossy() {
            "predict" => return predict(&mut parser),
            "calibrate" => calibrate(&mut parser),
            "diagnose" => diagnose(&mut parser),
            "probe" => probe(&mut parser),
            unknown => Err(format!(
                "unknown command {unknown}; the commands are: predict, calibrate, diagnose, probe"
            )),
        },
        Some(Long("help") | Short('h')) => print(USAGE),
        Some(Long("version") | Short('V')) => print(&format!("truefeed {VERSION}")),
        Some(other) => Err(other.unexpected().to_string()),
        None => Err("what to do? Try: truefeed predict PROGRAM --machine M.toml".to_string()),
    };
    done.map(|()| ExitCode::SUCCESS)
}
