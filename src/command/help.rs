//! The texts of `--help`. `docs/cli.md` is generated from them.

/// `truefeed --help`.
pub const OVERVIEW: &str = "\
Predicts the cycle time of G-code programs, and explains recordings of their runs.

  truefeed predict     cycle time of a program at each contour tolerance, or of a whole archive
  truefeed calibrate   fits a machine file to recordings
  truefeed diagnose    explains why a recorded run differs from the simulation
  truefeed probe       writes a test program that shows what yours cannot
  truefeed job         times and price of a part that several programs make

truefeed COMMAND --help describes a command; truefeed --version names the build.

Exit status: 0 done; 1 an archive is done, but some of its lines hold an error; 2 the command refused the
request and says why in one line on standard error. A command never replaces one of its inputs, and writes a
file whole or not at all.";

/// `truefeed predict --help`.
pub const PREDICT: &str = "\
truefeed predict PROGRAM --machine M.toml [OPTION]...
truefeed predict PROGRAM|FOLDER... --machine M.toml --ndjson [OPTION]...

Predicts the cycle time of a G-code program, or of each program in an archive. PROGRAM is a file, or - for
standard input.

  --machine M.toml      the machine file
  --tolerance MM        replaces every tolerance the program sets, except exact stops; repeat it to compare
                        several. Without it the program's own tolerances hold (G64 P, G187 E, CYCLE832 ...),
                        and the machine's where the program sets none
  --dialect D           reads the program for iso, linuxcnc, siemens, klartext, heidenhain-iso, grbl, mach or
                        okuma; without it, Truefeed recognises the control from the program
  --arc-centres A       incremental or absolute: how to read I, J and K where neither the program nor the
                        control decides it; without it, Truefeed chooses the reading in which arcs close
  --json                prints the result as JSON
  --profile OUT.csv     writes time, distance, feedrate, position and line at the first tolerance
  --cutting JOB.toml    also computes cutting forces; the job file gives stock, tools, material and limits
  --forces OUT.csv      with --cutting: writes force, torque, power and removal rate along the path, for the
                        programmed and the predicted feedrate, at the first tolerance

A line `In doubt: ...` gives the seconds by which the time may be off because the program leaves something
open or contains something Truefeed does not read.

Archives:
  --ndjson              takes many programs and folders, uses all processors and prints one line of JSON for
                        each program. A program that cannot be read gets a line with `error`
  --out OUT.ndjson      appends the lines to a file. Run the same command again to resume: Truefeed removes a
                        truncated last line and skips programs whose line is up to date
  --list                only lists the programs left to do
  --jobs N              predicts N programs at a time";

/// `truefeed calibrate --help`.
pub const CALIBRATE: &str = "\
truefeed calibrate --machine M.toml --run PROGRAM RECORDING [--run ...]... --out FITTED.toml [OPTION]...

Fits a machine file to recordings of real runs: filters or a planner, tolerance, rapids, and the times of tool
changes and M-codes. Parameters that the recordings cannot determine keep their values, and the report lists them.
RECORDING is a log of the machine: CSV, MTConnect, halsampler, scope or trace files, also packed by gzip or
alone in a ZIP archive.

  --machine M.toml      the machine file to start from
  --run PROGRAM RECORDING
                        a program and the recording of one of its runs; repeat it for each run
  --move RECORDING      the recording of one straight move from rest to rest: order and time constants of the
                        filters; alone, or before the runs are fitted
  --out FITTED.toml     the machine file to write
  --interval-s S        the time between two rows, for a recording without a time column
  --json                prints the report as JSON";

/// `truefeed diagnose --help`.
pub const DIAGNOSE: &str = "\
truefeed diagnose PROGRAM RECORDING [--run PROGRAM RECORDING]... --machine M.toml [OPTION]...

Explains where and why a recorded run differs from the simulation, how sure that is, and what else could
explain it. Every second of the difference appears in the account, as a cause or as unexplained.

  --machine M.toml      the machine file
  --run PROGRAM RECORDING
                        another run of the same machine
  --out EXTENDED.toml   writes the machine file with the causes found
  --interval-s S        the time between two rows, for a recording without a time column
  --json                prints the report as JSON";

/// `truefeed probe --help`.
pub const PROBE: &str = "\
truefeed probe --machine M.toml [--between CAUSE CAUSE] [--out PROGRAM]

Writes a short program to run and record on the machine. With --between, two causes that your own program
cannot separate look different on it; without, it exercises every effect that Truefeed knows.

  --machine M.toml      the machine file
  --between CAUSE CAUSE two causes, by the ids that diagnose --json prints
  --out PROGRAM         writes the program to a file instead of standard output";

/// `truefeed job --help`.
pub const JOB: &str = "\
truefeed job JOB.json [OPTION]...

Computes the times and the price of a part that several programs make. JOB.json names the programs in order,
their machines and the terms of the quote (docs/job.schema.json describes it); paths in it start from its folder.

  --out COSTING.html    writes the internal costing; .csv writes it as a table
  --offer OFFER.html    writes the offer for the customer
  --compare OTHER.json  prints how much longer and dearer another job is, by operation and in total
  --json                prints the result as JSON";
