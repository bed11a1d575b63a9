//! `truefeed job`: times and price of a part made by several programs.

use std::path::{Path, PathBuf};

use lexopt::prelude::*;
use truefeed::machine::Machine;
use truefeed::project::{JobComparison, JobFile, JobOperationFile, JobReport, MachineSource, PlannedProgram};
use truefeed::quote::{programmed_time, quote};
use truefeed::side_by_side::side_by_side;
use truefeed::simulation::gcode::title;
use truefeed::simulation::interpreter::trace_text;
use truefeed::simulation::simulate;

use crate::command::input::{bytes_of, machine_of};
use crate::command::output::Output;
use crate::command::{CommandError, declined, help, once, print, value};

/// The request of `job`.
#[derive(Default)]
struct JobArguments {
    job: Option<PathBuf>,
    compare: Option<PathBuf>,
    json: bool,
    out: Option<PathBuf>,
    offer: Option<PathBuf>,
}

/// Runs `job`.
pub fn job(parser: &mut lexopt::Parser) -> Result<(), CommandError> {
    let Some(request) = request(parser)? else { return print(help::JOB) };
    let path = request.job.ok_or("which job? Give JOB.json")?;
    let is_csv = match &request.out {
        Some(out) => has_ending(out, &["csv", "html", "htm"])? == "csv",
        None => false,
    };
    if let Some(offer) = &request.offer {
        has_ending(offer, &["html", "htm"])?;
    }
    if request.compare.is_some() && (request.out.is_some() || request.offer.is_some()) {
        return Err("--out and --offer are for one job; leave them out, or leave out --compare".to_string());
    }
    let first = JobFiles::new(path)?;
    let inputs = first.paths();
    let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
    let [out, offer] = Output::all([request.out, request.offer], &inputs)?;
    let second = request.compare.map(JobFiles::new).transpose()?;
    let report = first.report()?;
    if let Some(out) = out {
        out.write(&if is_csv { report.to_csv() } else { report.to_costing(&[]) })?;
    }
    if let Some(offer) = offer {
        offer.write(&report.to_offer())?;
    }
    match second {
        Some(second) => {
            let comparison = JobComparison::new(&report, &second.report()?);
            print(&if request.json { comparison.to_json() } else { comparison.to_text() })
        }
        None => print(&if request.json { report.to_json() } else { report.to_text() }),
    }
}

/// A job with its path, to which the names of its files are relative.
struct JobFiles {
    path: PathBuf,
    job: JobFile,
}

impl JobFiles {
    fn new(path: PathBuf) -> Result<JobFiles, CommandError> {
        // A job may contain its programs, so that it may be as long as these.
        let text = String::from_utf8(bytes_of(&path)?).map_err(|error| {
            format!("{}: not UTF-8 text at byte {}", path.display(), error.utf8_error().valid_up_to())
        })?;
        let job = JobFile::from_json(&text).map_err(|fault| format!("{}: {fault}", path.display()))?;
        Ok(JobFiles { path, job })
    }

    /// Returns the path of a file that the job names.
    fn file(&self, name: &str) -> PathBuf {
        match self.path.parent() {
            Some(folder) if folder != Path::new("") => folder.join(name),
            // With a folder before it, `-` is a file of that name.
            _ => Path::new(".").join(name),
        }
    }

    /// Returns the paths of the job, its machine files and its programs, in this order.
    fn paths(&self) -> Vec<PathBuf> {
        let of = |operation: &JobOperationFile| {
            let machine = match &operation.machine {
                MachineSource::File(name) => Some(self.file(name)),
                MachineSource::Inline(_) => None,
            };
            let program = operation.text.is_none().then(|| self.file(&operation.program));
            [machine, program].into_iter().flatten().collect::<Vec<_>>()
        };
        [self.path.clone()].into_iter().chain(self.job.operations.iter().flat_map(of)).collect()
    }

    /// Returns the report, with all programs simulated.
    fn report(&self) -> Result<JobReport, CommandError> {
        let machine = |operation: &JobOperationFile| match &operation.machine {
            MachineSource::File(name) => machine_of(&self.file(name)),
            MachineSource::Inline(machine) => Ok((**machine).clone()),
        };
        let operations = &self.job.operations;
        let machines: Vec<Machine> = operations.iter().map(machine).collect::<Result<_, _>>()?;
        let planned = side_by_side(
            operations.len(),
            |index| self.planned(&operations[index], &machines[index]),
            &mut |_| {},
        );
        let planned = planned.into_iter().collect::<Result<_, _>>()?;
        Ok(JobReport::new(&self.job, machines, planned))
    }

    /// Simulates the program of an operation.
    fn planned(
        &self,
        operation: &JobOperationFile,
        machine: &Machine,
    ) -> Result<PlannedProgram, CommandError> {
        let (path, bytes) = match &operation.text {
            Some(text) => (PathBuf::from(&operation.program), text.clone().into_bytes()),
            None => {
                let path = self.file(&operation.program);
                let bytes = bytes_of(&path)?;
                (path, bytes)
            }
        };
        let title = title(&bytes);
        let toolpath = trace_text(bytes, &operation.options, machine);
        if let Some(reason) = declined(&toolpath) {
            return Err(format!("{}: {reason}", path.display()));
        }
        let (plan, errors) = simulate::within(&toolpath, machine, operation.tolerances, &mut |_| {});
        let quote = quote(&toolpath, machine, &plan, operation.tolerances, &errors);
        let programmed = programmed_time(&toolpath, machine);
        Ok(PlannedProgram::of(title, &toolpath, &quote, programmed))
    }
}

/// Returns the extension of an output file, in lower case; it must be one of `known`.
fn has_ending(path: &Path, known: &[&'static str]) -> Result<&'static str, CommandError> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    let found = known.iter().copied().find(|known| *known == ending);
    found.ok_or_else(|| format!("{}: name a file that ends in .{}", path.display(), known.join(" or .")))
}

/// Reads the rest of the command line; `None` if it requests help.
fn request(parser: &mut lexopt::Parser) -> Result<Option<JobArguments>, CommandError> {
    let mut request = JobArguments::default();
    while let Some(argument) = parser.next().map_err(|error| error.to_string())? {
        match argument {
            Long("json") => request.json = true,
            Long("out") => once(&mut request.out, value(parser)?, "--out")?,
            Long("offer") => once(&mut request.offer, value(parser)?, "--offer")?,
            Long("compare") => once(&mut request.compare, value(parser)?, "--compare")?,
            Long("help") | Short('h') => return Ok(None),
            Value(job) => once(&mut request.job, job, "JOB.json")?,
            other => return Err(other.unexpected().to_string()),
        }
    }
    Ok(Some(request))
}
