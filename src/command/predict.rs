//! `truefeed predict`: the cycle time of a program at each contour tolerance.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lexopt::prelude::*;
use truefeed::project::{
    Prediction, doubt_sentence, profile_csv, range_sentence, severity_word, spacing_note,
};
use truefeed::quote::{FunctionBreakdown, Quote, TimeShare, programmed_time, quote};
use truefeed::side_by_side::side_by_side;
use truefeed::simulation::drive::actual_motion;
use truefeed::simulation::feed::{ToleranceRange, Tolerances};
use truefeed::simulation::gcode::{ArcCenters, Dialect, Options};
use truefeed::simulation::profile::Profile;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::{Blending, Toolpath};

use crate::command::archive::ArchiveRequest;
use crate::command::cutting::CutForces;
use crate::command::input::{machine_of, toolpath_of};
use crate::command::output::Output;
use crate::command::{CommandError, arc_centers, dialect, help, once, print, value};

/// The request of `predict`.
#[derive(Default)]
struct PredictRequest {
    programs: Vec<PathBuf>,
    machine: Option<PathBuf>,
    tolerances: Vec<f64>,
    dialect: Option<Dialect>,
    arc_centers: Option<ArcCenters>,
    json: bool,
    profile: Option<PathBuf>,
    cutting: Option<PathBuf>,
    forces: Option<PathBuf>,
    is_archive: bool,
    out: Option<PathBuf>,
    is_list: bool,
    jobs: Option<NonZero<usize>>,
}

/// Runs `predict`.
pub fn predict(parser: &mut lexopt::Parser) -> Result<ExitCode, CommandError> {
    match request(parser)? {
        None => print(help::PREDICT).map(|()| ExitCode::SUCCESS),
        Some(request) if request.is_archive => archive(request)?.run(),
        Some(request) => predict_one(request).map(|()| ExitCode::SUCCESS),
    }
}

/// Returns the request for an archive.
fn archive(request: PredictRequest) -> Result<ArchiveRequest, CommandError> {
    let PredictRequest { programs, machine, tolerances, dialect, arc_centers, out, is_list, jobs, .. } =
        request;
    let others = [
        ("--json", request.json),
        ("--profile", request.profile.is_some()),
        ("--cutting", request.cutting.is_some()),
        ("--forces", request.forces.is_some()),
    ];
    if let Some((other, _)) = others.iter().find(|(_, is_given)| *is_given) {
        return Err(format!("{other} works for a single program only; remove it, or --ndjson"));
    }
    if programs.is_empty() {
        return Err("no programs; give G-code files or folders".to_string());
    }
    let machine_path = machine.ok_or("no machine; give --machine M.toml")?;
    let machine = machine_of(&machine_path)?;
    let options = Options { dialect, arc_centers, ..Options::default() };
    Ok(ArchiveRequest { paths: programs, machine, machine_path, tolerances, options, out, is_list, jobs })
}

/// Runs `predict` for one program.
fn predict_one(request: PredictRequest) -> Result<(), CommandError> {
    if request.out.is_some() || request.is_list || request.jobs.is_some() {
        return Err("--out, --list and --jobs need --ndjson".to_string());
    }
    let mut programs = request.programs.into_iter();
    let program = programs.next().ok_or("no program; give a G-code file, or - for standard input")?;
    if programs.next().is_some() {
        return Err("PROGRAM is given twice; several programs and folders need --ndjson".to_string());
    }
    let machine_path = request.machine.ok_or("no machine; give --machine M.toml")?;
    if request.forces.is_some() && request.cutting.is_none() {
        return Err("--forces needs --cutting JOB.toml".to_string());
    }
    let inputs: Vec<&Path> =
        [&program, &machine_path].into_iter().chain(&request.cutting).map(PathBuf::as_path).collect();
    let [profile, forces] = Output::all([request.profile, request.forces], &inputs)?;
    let machine = machine_of(&machine_path)?;
    let PredictRequest { dialect, arc_centers, .. } = request;
    let options = Options { dialect, arc_centers, ..Options::default() };
    let toolpath = toolpath_of(&program, &options, &machine)?;

    let mut cut = match &request.cutting {
        Some(job) => Some(CutForces::new(job, forces, &machine, &toolpath)?),
        None => None,
    };
    let tolerances = match request.tolerances {
        none if none.is_empty() => vec![Tolerances::Programmed],
        given => given.into_iter().map(Tolerances::One).collect(),
    };
    // A plan is large, and so is dropped once its results are computed.
    let is_kept = |index: usize| cut.is_some() || (index == 0 && profile.is_some());
    let results = side_by_side(
        tolerances.len(),
        |index| {
            let tolerance = tolerances[index];
            let (plan, errors) = simulate::within(&toolpath, &machine, tolerance, &mut |_| {});
            let quote = quote(&toolpath, &machine, &plan, tolerance, &errors);
            (quote, is_kept(index).then_some(plan))
        },
        &mut |_| {},
    );
    let mut quotes = Vec::with_capacity(tolerances.len());
    for (index, (quote, plan)) in results.into_iter().enumerate() {
        quotes.push(quote);
        if let (0, Some(profile), Some(plan)) = (index, &profile, &plan) {
            let commanded = Profile::new(&toolpath, plan).written();
            if let Some(note) = spacing_note(commanded.spacing) {
                eprintln!("truefeed: {}: {note}", profile.path.display());
            }
            profile.write(&profile_csv(&actual_motion(&commanded, &machine)))?;
        }
        if let (Some(cut), Some(plan)) = (&mut cut, &plan) {
            cut.load(&toolpath, &Profile::new(&toolpath, plan).drawn())?;
        }
    }
    let programmed = programmed_time(&toolpath, &machine);
    let name = program.file_name().unwrap_or(program.as_os_str()).to_string_lossy();
    if request.json {
        let prediction = Prediction::new(&name, &toolpath, programmed, &quotes);
        let prediction = match &cut {
            Some(cut) => cut.added_to(prediction),
            None => prediction,
        };
        print(&prediction.to_json())
    } else {
        let cutting = cut.map_or(String::new(), |cut| cut.text(&toolpath));
        print(&(table(&name, programmed, &quotes, &toolpath) + &cutting))
    }
}

/// Reads the rest of the command line; `None` if it requests help.
fn request(parser: &mut lexopt::Parser) -> Result<Option<PredictRequest>, CommandError> {
    let mut request = PredictRequest::default();
    while let Some(argument) = parser.next().map_err(|error| error.to_string())? {
        match argument {
            Long("machine") => once(&mut request.machine, value(parser)?, "--machine")?,
            Long("profile") => once(&mut request.profile, value(parser)?, "--profile")?,
            Long("cutting") => once(&mut request.cutting, value(parser)?, "--cutting")?,
            Long("forces") => once(&mut request.forces, value(parser)?, "--forces")?,
            Long("json") => request.json = true,
            Long("ndjson") => request.is_archive = true,
            Long("out") => once(&mut request.out, value(parser)?, "--out")?,
            Long("list") => request.is_list = true,
            Long("jobs") => {
                let text = value(parser)?.to_string_lossy().into_owned();
                let jobs = text
                    .parse()
                    .map_err(|_| format!("--jobs {text}: expected a number of programs, such as 2"));
                request.jobs = Some(jobs?);
            }
            Long("dialect") => {
                request.dialect = Some(dialect(parser)?);
            }
            Long("arc-centres") => request.arc_centers = Some(arc_centers(parser)?),
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
            Value(program) => request.programs.push(program.into()),
            other => return Err(other.unexpected().to_string()),
        }
    }
    Ok(Some(request))
}

/// Returns the result for people.
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
    if let Some(range) = quotes.first().and_then(|quote| quote.range.as_ref()) {
        text += &format!("\nCycle time {}", range_sentence(range));
    }
    if let Some(sentence) = quotes.first().and_then(|quote| doubt_sentence(&quote.trust)) {
        text += &format!("\n{sentence}");
    }
    for held in quotes.iter().flat_map(|quote| &quote.tolerance_ranges) {
        text += &format!("\n{}", tolerance_range_text(held));
    }
    // Functions and tool changes take equally long at all tolerances.
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

/// Returns the parts of the other time, a line for each that is not 0.
fn other_parts(functions: &FunctionBreakdown) -> String {
    let FunctionBreakdown { spindle, coolant, stops, pallet, clamp, m_words, start, halts } = *functions;
    let names = [
        "spindle",
        "coolant",
        "program stops",
        "pallet changes",
        "clamping",
        "other M-codes",
        "program start",
        "halts",
    ];
    let times = [spindle, coolant, stops, pallet, clamp, m_words, start, halts];
    let parts = names.into_iter().zip(times).filter(|(_, seconds)| *seconds != 0.0);
    parts.map(|(name, seconds)| format!("\nother: {name} {seconds:.2} s")).collect()
}

/// Returns operations and tools at one tolerance, if there are several.
fn parts(quote: &Quote) -> String {
    const TITLES: &str = "     time s     lost s  cutting s    rapid s    dwell s  changes s    other s    feed mm   rapid mm  blocks";
    let mut text = String::new();
    let row = |share: &TimeShare| {
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

/// Returns a line on the range of one tolerance of the program.
fn tolerance_range_text(held: &ToleranceRange) -> String {
    let (first, last) = (held.lines.0.0, held.lines.1.0);
    let what = match held.blending {
        Blending::ExactStop | Blending::ExactPath => "exact stop".to_string(),
        Blending::Machine => format!("{} mm, the machine's", held.tolerance),
        Blending::Within(tolerance) => format!("{tolerance} mm"),
        Blending::Distance(distance) => {
            format!("from {distance} mm before each corner, deviating by up to {} mm", held.tolerance)
        }
    };
    let source = if held.source.is_empty() { String::new() } else { format!(" ({})", held.source) };
    format!("tolerance in lines {first} to {last}: {what}{source}")
}
