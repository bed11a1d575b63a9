//! The command line: files in, text out, over the same core as the page.
//!
//! Exit status 0: done. 2: the request cannot be carried out; one line on standard error says
//! what is wrong and where. Nothing is written before everything is known to be right.

use std::ffi::OsString;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lexopt::prelude::*;
use truefeed::cutting::{CuttingError, Engagement, Loads, engagement, programmed_and_predicted};
use truefeed::project::{
    Prediction, cutting_from_toml, cutting_refusal, cutting_remarks, cutting_table, loads_csv,
    machine_from_toml, profile_csv, severity_word,
};
use truefeed::quote::{Functions, Quote, Share, programmed_time, quote};
use truefeed::simulation::contour::plan_within;
use truefeed::simulation::drive::actual_motion;
use truefeed::simulation::feed::{Held, Tolerances};
use truefeed::simulation::gcode::{Dialect, Options, read_with};
use truefeed::simulation::profile::{Profile, Resolution};
use truefeed::simulation::toolpath::{Blending, Toolpath, trace};

const USAGE: &str = "\
truefeed predict PROGRAM --machine M.toml [--tolerance MM]... [--dialect D] [--json] [--profile OUT.csv]
                 [--cutting JOB.toml [--forces OUT.csv]]

What the machine will do with a G-code program: cycle time for each contour tolerance.
PROGRAM is a G-code file, or - for standard input. Without --tolerance the program's own tolerances
hold (G64 P, G187 E and so on), and the machine's where it sets none; a --tolerance replaces all of
them, but for exact stops.
The control the program was written for is found by what stands in it; --dialect chooses it: iso,
linuxcnc, siemens, klartext, heidenhain-iso, grbl, mach or okuma.
--json prints the result as JSON; --profile writes time, distance, feedrate, position and line
for the first tolerance.
--cutting adds what the cut asks of tool and spindle: stock, tools, material and limits are in JOB.toml.
--forces writes force, torque, power and removal rate along the path, by the programmed and by the
predicted feedrate, for the first tolerance.";

/// What is wrong with a request, in one line.
type Refusal = String;

fn main() -> ExitCode {
    match run(std::env::args_os()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(refusal) => {
            eprintln!("truefeed: {refusal}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: impl Iterator<Item = OsString>) -> Result<(), Refusal> {
    let mut parser = lexopt::Parser::from_iter(arguments);
    match parser.next().map_err(|error| error.to_string())? {
        Some(Value(command)) if command == "predict" => predict(&mut parser),
        Some(Value(command)) => {
            Err(format!("unknown command {}; the commands are: predict", command.to_string_lossy()))
        }
        Some(Long("help") | Short('h')) => print(USAGE),
        Some(Long("version") | Short('V')) => print(concat!("truefeed ", env!("CARGO_PKG_VERSION"))),
        Some(other) => Err(other.unexpected().to_string()),
        None => Err("what to do? Try: truefeed predict PROGRAM --machine M.toml".to_string()),
    }
}

/// The request of `predict`.
#[derive(Default)]
struct Request {
    program: Option<PathBuf>,
    machine: Option<PathBuf>,
    tolerances: Vec<f64>,
    dialect: Option<Dialect>,
    json: bool,
    profile: Option<PathBuf>,
    cutting: Option<PathBuf>,
    forces: Option<PathBuf>,
}

fn predict(parser: &mut lexopt::Parser) -> Result<(), Refusal> {
    let Some(request) = request(parser)? else { return print(USAGE) };
    let program = request.program.ok_or("which program? Give a G-code file, or - for standard input")?;
    let machine_path = request.machine.ok_or("which machine? Give --machine M.toml")?;
    let machine = machine_from_toml(&text_of(&machine_path)?)
        .map_err(|fault| format!("{}: {fault}", machine_path.display()))?;
    let toolpath = {
        let options = Options { dialect: request.dialect, ..Options::default() };
        trace(&read_with(&bytes_of(&program)?, &options), &machine)
    };

    let setup = match &request.cutting {
        Some(path) => {
            let setup = cutting_from_toml(&text_of(path)?, &machine);
            Some(setup.map_err(|fault| format!("{}: {fault}", path.display()))?)
        }
        None if request.forces.is_some() => return Err("--forces needs --cutting JOB.toml".to_string()),
        None => None,
    };
    let cut = setup.as_ref().map(|setup| engagement(&toolpath, setup));
    let mut loads = Vec::new();

    let tolerances = match request.tolerances {
        none if none.is_empty() => vec![Tolerances::Programmed],
        given => given.into_iter().map(Tolerances::One).collect(),
    };
    let mut quotes = Vec::with_capacity(tolerances.len());
    for (index, &tolerance) in tolerances.iter().enumerate() {
        let (plan, errors) = plan_within(&toolpath, &machine, tolerance, &mut |_| {});
        quotes.push(quote(&toolpath, &machine, &plan, tolerance, &errors));
        if let (0, Some(path)) = (index, &request.profile) {
            let commanded = Profile::new(&toolpath, &plan).samples(Resolution::FINE);
            write_whole(path, &profile_csv(&actual_motion(&commanded, &machine)))?;
        }
        if let (Some(setup), Some(Ok(cut))) = (&setup, &cut) {
            let samples = Profile::new(&toolpath, &plan).samples(Resolution::CHART);
            let both = programmed_and_predicted(cut, &toolpath, setup, &samples);
            if let (0, Some(path), Ok(both)) = (index, &request.forces, &both) {
                write_whole(path, &loads_csv(cut, both))?;
            }
            loads.push(both);
        }
    }
    let programmed = programmed_time(&toolpath, &machine);
    let name = program.file_name().unwrap_or(program.as_os_str()).to_string_lossy();
    if request.json {
        let prediction = Prediction::new(&name, &toolpath, programmed, &quotes);
        print(
            &match &cut {
                Some(cut) => prediction.with_cutting(cut, &loads),
                None => prediction,
            }
            .to_json(),
        )
    } else {
        let cutting = cut.map_or(String::new(), |cut| cutting_text(&cut, &loads));
        print(&(table(&name, programmed, &quotes, &toolpath) + &cutting))
    }
}

/// Reads the rest of the command line; none where help was asked for.
fn request(parser: &mut lexopt::Parser) -> Result<Option<Request>, Refusal> {
    let mut request = Request::default();
    let once = |slot: &mut Option<PathBuf>, value: OsString, what: &str| match slot.replace(value.into()) {
        None => Ok(()),
        Some(_) => Err(format!("{what} is given twice")),
    };
    while let Some(argument) = parser.next().map_err(|error| error.to_string())? {
        let value = |parser: &mut lexopt::Parser| parser.value().map_err(|error| error.to_string());
        match argument {
            Long("machine") => once(&mut request.machine, value(parser)?, "--machine")?,
            Long("profile") => once(&mut request.profile, value(parser)?, "--profile")?,
            Long("cutting") => once(&mut request.cutting, value(parser)?, "--cutting")?,
            Long("forces") => once(&mut request.forces, value(parser)?, "--forces")?,
            Long("json") => request.json = true,
            Long("dialect") => {
                let word = value(parser)?.to_string_lossy().into_owned();
                let known = Dialect::WORDS.map(|(word, ..)| word).join(", ");
                let dialect = Dialect::from_word(&word);
                request.dialect =
                    Some(dialect.ok_or_else(|| format!("--dialect {word}: expected one of {known}"))?);
            }
            Long("tolerance") => {
                let text = value(parser)?.to_string_lossy().into_owned();
                let tolerance: f64 = text.parse().unwrap_or(f64::NAN);
                if !(1e-6..=10.0).contains(&tolerance) {
                    return Err(format!(
                        "--tolerance {text}: expected millimetres from 0.000001 to 10, such as 0.01"
                    ));
                }
                request.tolerances.push(tolerance);
            }
            Long("help") | Short('h') => return Ok(None),
            Value(program) => once(&mut request.program, program, "PROGRAM")?,
            other => return Err(other.unexpected().to_string()),
        }
    }
    Ok(Some(request))
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, Refusal> {
    let mut bytes = Vec::new();
    let outcome = if path == Path::new("-") {
        std::io::stdin().read_to_end(&mut bytes).map(drop)
    } else {
        std::fs::read(path).map(|read| bytes = read)
    };
    outcome.map(|()| bytes).map_err(|error| format!("{}: {error}", path.display()))
}

fn text_of(path: &Path) -> Result<String, Refusal> {
    String::from_utf8(bytes_of(path)?).map_err(|error| {
        format!("{}: not UTF-8 text at byte {}", path.display(), error.utf8_error().valid_up_to())
    })
}

/// Writes beside the target first, so that there is never half a file.
fn write_whole(path: &Path, text: &str) -> Result<(), Refusal> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    std::fs::write(&beside, text)
        .and_then(|()| std::fs::rename(&beside, path))
        .inspect_err(|_| drop(std::fs::remove_file(&beside)))
        .map_err(|error| format!("{}: {error}", path.display()))
}

/// Prints a text; a reader that went away is not our error.
fn print(text: &str) -> Result<(), Refusal> {
    match writeln!(std::io::stdout(), "{text}") {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.to_string()),
        _ => Ok(()),
    }
}

/// What the cut asks of tool and spindle, for people: peaks of the first tolerance, and remarks.
fn cutting_text(
    cut: &Result<Engagement, CuttingError>,
    loads: &[Result<[Loads; 2], CuttingError>],
) -> String {
    let line = |(line, is_error, text): (u32, bool, String)| {
        let severity = if is_error { "error" } else { "warning" };
        let place = if line == 0 { String::new() } else { format!("line {line}: ") };
        format!("\n{severity}: {place}{text}")
    };
    match (cut, loads.first()) {
        (Err(error), _) | (_, Some(Err(error))) => line(cutting_refusal(error)),
        (Ok(cut), Some(Ok(both))) => {
            let remarks: String = cutting_remarks(cut, both).into_iter().map(line).collect();
            format!("\n{}{remarks}", cutting_table(both))
        }
        (Ok(_), None) => String::new(),
    }
}

/// The result for people.
fn table(name: &str, programmed: f64, quotes: &[Quote], toolpath: &Toolpath) -> String {
    let mut text = format!(
        "{name} ({}): {} blocks of motion, programmed time {programmed:.2} s\n",
        toolpath.dialect.name(),
        toolpath.segments.len()
    );
    text += "tolerance mm   cycle time s   difference   cutting s    rapid s    dwell s   changes s    other s   error mm";
    for quote in quotes {
        let difference = 100.0 * (quote.cycle_time / programmed - 1.0);
        let b = &quote.breakdown;
        text += &format!(
            "\n{:12} {:14.3} {:11} {:11.2} {:10.2} {:10.2} {:11.2} {:10.2} {:10.4}",
            quote.tolerance,
            quote.cycle_time,
            if difference.is_finite() { format!("{difference:+.1} %") } else { "-".to_string() },
            b.cutting,
            b.rapid,
            b.dwell,
            b.tool_change,
            b.other,
            quote.max_contour_error
        );
    }
    for held in quotes.iter().flat_map(|quote| &quote.held) {
        text += &format!("\n{}", held_text(held));
    }
    // What functions and whole changes take is the same for all tolerances.
    text += &quotes.first().map_or(String::new(), |quote| other_parts(&quote.breakdown.functions));
    for quote in quotes {
        text += &parts(quote);
    }
    for diagnostic in &toolpath.diagnostics {
        let severity = severity_word(diagnostic.severity);
        text += &format!("\n{severity}: line {}: {}", diagnostic.line.0, diagnostic.message);
    }
    text
}

/// What the other time is made of, a line for each part that takes any.
fn other_parts(functions: &Functions) -> String {
    let Functions { spindle, coolant, stops, pallet, clamp, m_words, start } = *functions;
    let names = [
        "spindle",
        "coolant",
        "program stops",
        "pallet changes",
        "clamping",
        "other M-words",
        "program start",
    ];
    let times = [spindle, coolant, stops, pallet, clamp, m_words, start];
    let parts = names.into_iter().zip(times).filter(|(_, seconds)| *seconds != 0.0);
    parts.map(|(name, seconds)| format!("\nother: {name} {seconds:.2} s")).collect()
}

/// Operations and tools of one tolerance, where there is more than one.
fn parts(quote: &Quote) -> String {
    const TITLES: &str = "     time s     lost s  cutting s    rapid s    dwell s  changes s    other s    feed mm   rapid mm  blocks";
    let mut text = String::new();
    let row = |share: &Share| {
        let b = &share.breakdown;
        let times = [share.time(), share.lost(), b.cutting, b.rapid, b.dwell, b.tool_change, b.other];
        let columns = times.into_iter().chain([share.feed_length, share.rapid_length]);
        columns.map(|value| format!(" {value:10.2}")).collect::<String>() + &format!(" {:7}", share.moves)
    };
    let number = |tool: Option<u32>| tool.map_or("-".to_string(), |tool| format!("T{tool}"));
    if 1 < quote.operations.len() {
        text += &format!("\noperations at {} mm\n    line  tool{TITLES}  name", quote.tolerance);
        for found in &quote.operations {
            let (line, tool) = (found.operation.line.0, number(found.operation.tool));
            let name = found.operation.name.as_deref().unwrap_or("");
            text += format!("\n{line:8} {tool:>5}{}  {name}", row(&found.share)).trim_end();
        }
    }
    if 1 < quote.tools.len() {
        text += &format!("\ntools at {} mm\n          tool{TITLES}  name", quote.tolerance);
        for found in &quote.tools {
            let (tool, name) = (number(found.tool), found.name.as_deref().unwrap_or(""));
            text += format!("\n         {tool:>5}{}  {name}", row(&found.share)).trim_end();
        }
    }
    text
}

/// Where a tolerance of the program holds.
fn held_text(held: &Held) -> String {
    let (first, last) = (held.lines.0.0, held.lines.1.0);
    let what = match held.blending {
        Blending::ExactStop => "exact stop".to_string(),
        Blending::Machine => format!("{} mm, the machine's", held.tolerance),
        Blending::Within(tolerance) => format!("{tolerance} mm"),
        Blending::Distance(distance) => {
            format!("{distance} mm before each corner, up to {} mm beside it", held.tolerance)
        }
    };
    let source = if held.source.is_empty() { String::new() } else { format!(" ({})", held.source) };
    format!("tolerance in lines {first} to {last}: {what}{source}")
}
