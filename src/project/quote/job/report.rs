//! A job with the times of its programs → times and price, for the command and the page. Amounts are in the
//! currency of the terms, times in s.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::machine::{Machine, tolerance_label};
use crate::project::TextFault;
use crate::project::prediction::time_range::RangeRow;
use crate::project::prediction::trust::doubt_sentence;
use crate::project::quote::job::file::{JobFile, JobOperationFile, MachineSource};
use crate::project::quote::job::letter::Letter;
use crate::project::quote::offer::facts::uncertainty_row;
use crate::project::quote::offer::report::{AddendRow, Batch, Fact, Kinds, RemarkCounts, UncertaintyRow};
use crate::project::quote::offer::request::{addend_row, rounding_note};
use crate::quote::{
    Addend, BatchTimes, Fixture, JobOperation, OperationShare, PlannedOperation, Quote, QuotedJob,
    Uncertainty,
};
use crate::simulation::feed::Tolerances;
use crate::simulation::gcode::Severity;
use crate::simulation::toolpath::Toolpath;
use crate::units::Unit;

/// The simulation of an operation's program.
#[derive(Clone, Debug, Default)]
pub struct PlannedProgram {
    /// Title in the program; empty if it has none.
    pub title: String,
    planned: PlannedOperation,
    range: Option<RangeRow>,
    in_doubt: String,
    remarks: RemarkCounts,
}

impl PlannedProgram {
    /// Returns the result of a quote; `title` is the program's title, `programmed` CAM's estimate, s.
    pub fn of(title: Option<String>, toolpath: &Toolpath, quote: &Quote, programmed: f64) -> PlannedProgram {
        let count = |severity: Severity| {
            toolpath.diagnostics.iter().filter(|diagnostic| diagnostic.severity == severity).count()
        };
        PlannedProgram {
            // A program with one operation has the name of that operation.
            title: title.or_else(|| only_name(&quote.operations)).unwrap_or_default(),
            planned: PlannedOperation::of(quote, programmed),
            range: quote.range.as_ref().map(|range| RangeRow::new(range, quote.cycle_time)),
            in_doubt: doubt_sentence(&quote.trust).unwrap_or_default(),
            remarks: RemarkCounts { errors: count(Severity::Error), warnings: count(Severity::Warning) },
        }
    }
}

/// Returns the name of the only operation.
fn only_name(operations: &[OperationShare]) -> Option<String> {
    match operations {
        [only] => only.operation.name.clone(),
        _ => None,
    }
}

/// A job for people and for other programs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JobReport {
    pub(super) name: String,
    pub(super) currency: String,
    /// Decimals of the amounts.
    pub(super) decimals: u32,
    pub(super) operations: Vec<OperationRow>,
    /// CAM's estimate for a part.
    pub(super) programmed_time_s: f64,
    /// Cycle time of a part: all operations.
    pub(super) cycle_time_s: f64,
    /// Range of the cycle time; null if the uncertainty of an operation is unknown.
    pub(super) cycle_time_range_s: Option<[f64; 2]>,
    pub(super) breakdown: Kinds,
    /// Loading of a part: all operations.
    pub(super) loading_s: f64,
    /// Set-up of the batch: all operations.
    pub(super) set_up_s: f64,
    /// Time of the batch, its operations one after the other.
    pub(super) batch_time_s: f64,
    /// Largest error of the cycle time of a part by the doubts that have a bound.
    pub(super) in_doubt_s: f64,
    pub(super) bounded: bool,
    pub(super) addends: Vec<JobAddend>,
    pub(super) once: f64,
    pub(super) part: f64,
    pub(super) batch: Batch,
    /// Other quantities, ascending, including the batch.
    pub(super) breaks: Vec<Batch>,
    /// Terms and rates missing from the price.
    pub(super) missing: Vec<MissingRow>,
    /// Notes on the numbers, one sentence each.
    pub(super) notes: Vec<String>,
    /// Facts about the job for people.
    pub(super) facts: Vec<Fact>,
    /// Uncertainty of the cycle time of a part.
    pub(super) uncertainty: UncertaintyRow,
    pub(super) offer: Letter,
}

/// One operation; costs are without margin.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct OperationRow {
    pub(super) name: String,
    pub(super) program: String,
    pub(super) machine: String,
    /// Contour tolerance in words, for example `10 µm`, or `as programmed`.
    pub(super) tolerance: String,
    pub(super) tolerance_mm: f64,
    pub(super) parts_per_load: u32,
    pub(super) set_up_s: f64,
    pub(super) loading_s: f64,
    pub(super) programmed_time_s: f64,
    /// Cycle time of a part.
    pub(super) cycle_time_s: f64,
    pub(super) cycle_time_range_s: Option<[f64; 2]>,
    /// Time of the operation's tool changes that is charged to other parts and operations.
    pub(super) shared_s: f64,
    pub(super) breakdown: Kinds,
    pub(super) in_doubt_s: f64,
    pub(super) bounded: bool,
    /// Doubts and their reasons; empty if there are none.
    pub(super) in_doubt: String,
    pub(super) remarks: RemarkCounts,
    /// Uncertainty of the cycle time.
    pub(super) uncertainty: String,
    #[serde(skip)]
    kind: &'static str,
    pub(super) hourly: f64,
    pub(super) set_up_cost: f64,
    pub(super) part_cost: f64,
}

/// An amount with the index of its operation; null for the part or the batch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct JobAddend {
    pub(super) operation: Option<usize>,
    #[serde(flatten)]
    pub(super) row: AddendRow,
}

/// A missing term, with its operation unless it concerns the whole job.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct MissingRow {
    pub(super) key: &'static str,
    pub(super) label: &'static str,
    pub(super) operation: Option<usize>,
}

impl JobReport {
    /// Returns the report of a job, given its machines and programs, one per operation.
    pub fn new(file: &JobFile, machines: Vec<Machine>, programs: Vec<PlannedProgram>) -> JobReport {
        let operations = file.operations.iter().zip(machines).zip(&programs);
        let operations = operations.map(|((operation, machine), program)| JobOperation {
            machine,
            set_up: operation.set_up,
            loading: operation.loading,
            fixture: operation.fixture,
            planned: program.planned.clone(),
        });
        let job = QuotedJob { operations: operations.collect(), terms: file.terms.clone() };
        let quantity = job.terms.quantity;
        let (times, offer) = (job.times(quantity), job.offer(quantity));
        let cost = |index: usize, once: bool| {
            let own = |addend: &&Addend| addend.operation == Some(index) && addend.once == once;
            offer.amount(offer.addends.iter().filter(own).map(|addend| addend.steps).sum())
        };
        let rows = file.operations.iter().zip(&programs).enumerate().map(|(index, (operation, program))| {
            OperationRow {
                set_up_cost: cost(index, true),
                part_cost: cost(index, false),
                ..operation_row(operation, program, &job, &times, index)
            }
        });
        let mut quantities = job.terms.breaks.clone();
        quantities.push(quantity);
        quantities.sort_unstable();
        quantities.dedup();
        let planned = || job.operations.iter().map(|operation| &operation.planned);
        let mut cycle = crate::quote::Breakdown::default();
        times.cycles.iter().for_each(|own| cycle += *own);
        let addend = |addend: &Addend| JobAddend {
            operation: addend.operation,
            row: addend_row(addend, &offer, &job.terms),
        };
        let missing = job.missing().into_iter().map(|missing| MissingRow {
            key: missing.key,
            label: missing.label(),
            operation: missing.operation,
        });
        let rows: Vec<OperationRow> = rows.collect();
        let mut report = JobReport {
            uncertainty: uncertainty(&rows, times.range),
            facts: Vec::new(),
            name: file.name.clone(),
            currency: job.terms.currency.clone(),
            decimals: job.terms.rounding.decimals(),
            operations: rows,
            programmed_time_s: planned().map(|planned| planned.programmed).sum(),
            cycle_time_s: times.part,
            cycle_time_range_s: times.range,
            breakdown: Kinds::of(&cycle),
            loading_s: times.loading,
            set_up_s: times.set_up,
            batch_time_s: times.batch,
            in_doubt_s: planned().fold(0.0, |sum, planned| sum + planned.in_doubt),
            bounded: planned().all(|planned| planned.is_bounded),
            addends: offer.addends.iter().map(addend).collect(),
            once: offer.amount(offer.once),
            part: offer.amount(offer.part),
            batch: batch(&job, quantity),
            breaks: quantities.into_iter().map(|quantity| batch(&job, quantity)).collect(),
            missing: missing.collect(),
            notes: notes(&job),
            offer: file.letter.clone(),
        };
        report.facts = report.told();
        report
    }

    /// Reads a request as JSON text and returns its report. The request has a job, and for each operation a
    /// run of `predict --json` with the programmed time and the count of remarks.
    ///
    /// # Errors
    ///
    /// Returns the first fault of the text.
    pub fn from_json(json: &str) -> Result<JobReport, TextFault> {
        let malformed =
            |error: serde_json::Error| TextFault { place: None, key: None, message: error.to_string() };
        let asked: JobRequest = serde_json::from_str(json).map_err(malformed)?;
        let file = JobFile::from_value(&asked.job)?;
        if file.operations.len() != asked.planned.len() {
            let message = format!("{} operations, {} planned", file.operations.len(), asked.planned.len());
            return Err(TextFault::at_key("planned", message));
        }
        let machine = |operation: &JobOperationFile| match &operation.machine {
            MachineSource::Inline(machine) => Ok((**machine).clone()),
            MachineSource::File(path) => {
                Err(TextFault::at_key("machine", format!("{path} is a file; give its values")))
            }
        };
        let machines = file.operations.iter().map(machine).collect::<Result<_, _>>()?;
        Ok(JobReport::new(&file, machines, asked.planned.into_iter().map(PlannedRun::planned).collect()))
    }

    /// Returns the report as JSON text.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("text and finite numbers have a JSON form")
    }
}

/// The page's request for a report.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct JobRequest {
    job: Value,
    planned: Vec<PlannedRun>,
}

#[derive(Deserialize)]
struct PlannedRun {
    #[serde(default)]
    title: String,
    programmed_time_s: f64,
    tolerance_mm: f64,
    breakdown: Kinds,
    operations: Vec<PlannedPart>,
    #[serde(default)]
    range: Option<RangeRow>,
    #[serde(default)]
    in_doubt: Option<String>,
    trust: RunDoubt,
    #[serde(default)]
    remarks: RemarkCounts,
}

#[derive(Deserialize)]
struct PlannedPart {
    tool: Option<u32>,
    breakdown: Kinds,
}

#[derive(Deserialize)]
struct RunDoubt {
    seconds_in_doubt: f64,
    bounded: bool,
}

impl PlannedRun {
    fn planned(self) -> PlannedProgram {
        let tools = || self.operations.iter().filter_map(|part| Some((part.tool?, part)));
        let planned = PlannedOperation {
            tolerance: self.tolerance_mm,
            cycle: self.breakdown.cycle(),
            programmed: self.programmed_time_s,
            first_tool: tools().next().map(|(tool, part)| (tool, part.breakdown.cycle().tool_change)),
            last_tool: tools().next_back().map(|(tool, _)| tool),
            range: self.range.as_ref().map(|range| Unit::Percent.to_core(range.percent)),
            in_doubt: self.trust.seconds_in_doubt,
            is_bounded: self.trust.bounded,
        };
        PlannedProgram {
            planned,
            title: self.title,
            range: self.range,
            in_doubt: self.in_doubt.unwrap_or_default(),
            remarks: self.remarks,
        }
    }
}

/// Returns the row of an operation, without its costs.
fn operation_row(
    file: &JobOperationFile,
    program: &PlannedProgram,
    job: &QuotedJob,
    times: &BatchTimes,
    index: usize,
) -> OperationRow {
    let JobOperation { machine, set_up, loading, fixture, planned } = &job.operations[index];
    let cycle = &times.cycles[index];
    let uncertainty = Uncertainty::of(&job.terms, machine, planned.tolerance, planned.range);
    let sure =
        uncertainty_row(uncertainty, cycle.total(), planned.tolerance, machine, program.range.as_ref());
    let label = tolerance_label(planned.tolerance);
    OperationRow {
        name: operation_name(file, program),
        program: file.program.clone(),
        machine: machine.name.clone(),
        tolerance: match file.tolerances {
            Tolerances::One(_) => label,
            Tolerances::Programmed => format!("as programmed ({label})"),
        },
        tolerance_mm: planned.tolerance,
        parts_per_load: fixture.map_or(1, |Fixture { parts }| parts),
        set_up_s: *set_up,
        loading_s: *loading,
        programmed_time_s: planned.programmed,
        cycle_time_s: cycle.total(),
        cycle_time_range_s: sure.cycle_time_s,
        shared_s: planned.cycle.tool_change - cycle.tool_change,
        breakdown: Kinds::of(cycle),
        in_doubt_s: planned.in_doubt,
        bounded: planned.is_bounded,
        in_doubt: program.in_doubt.trim_start_matches("In doubt: ").to_string(),
        remarks: program.remarks,
        uncertainty: sure.sentence,
        kind: sure.kind,
        hourly: machine.rates.hourly,
        set_up_cost: 0.0,
        part_cost: 0.0,
    }
}

/// Returns the uncertainty of a part's cycle time: the sentences of its operations, each once.
fn uncertainty(operations: &[OperationRow], range: Option<[f64; 2]>) -> UncertaintyRow {
    let mut sentences: Vec<&str> = Vec::new();
    for row in operations {
        if !sentences.contains(&row.uncertainty.as_str()) {
            sentences.push(&row.uncertainty);
        }
    }
    let kinds: Vec<&str> = operations.iter().map(|row| row.kind).collect();
    let kind = ["unknown", "given"].into_iter().find(|kind| kinds.contains(kind)).unwrap_or("calibrated");
    let middle = range.map(|[low, high]| (low + high) / 2.0);
    let ratio =
        range.zip(middle).map(|([_, high], middle)| high / middle - 1.0).filter(|ratio| ratio.is_finite());
    UncertaintyRow { kind, ratio, cycle_time_s: range, sentence: sentences.join(" ") }
}

/// Returns the name of an operation: that in the job, or else the title of the program, or the name of its
/// file.
fn operation_name(file: &JobOperationFile, program: &PlannedProgram) -> String {
    let path = file.program.replace('\\', "/");
    let last = path.rsplit('/').next().unwrap_or(&path);
    let stem = last.rsplit_once('.').map_or(last, |(stem, _)| stem);
    let names = [&file.name, &program.title, stem, last];
    names.into_iter().find(|name| !name.is_empty()).unwrap_or_default().to_string()
}

/// Returns a batch of `quantity` parts with its price.
fn batch(job: &QuotedJob, quantity: u32) -> Batch {
    let (middle, ends) = (job.offer(quantity), job.ends(quantity));
    Batch {
        quantity,
        unit_price: middle.unit_price(quantity),
        total: middle.amount(middle.total()),
        unit_price_range: ends.as_ref().map(|ends| ends.each_ref().map(|end| end.unit_price(quantity))),
        total_range: ends.map(|ends| ends.map(|end| end.amount(end.total()))),
    }
}

fn notes(job: &QuotedJob) -> Vec<String> {
    let mut notes = vec![rounding_note(&job.terms)];
    if job.operations.iter().any(|operation| operation.fixture.is_some()) {
        notes.push(
            "Parts of one load share its tool changes; the time does not include travel between parts."
                .to_string(),
        );
    }
    if 1 < job.operations.len() && job.times(1).range.is_some() {
        notes.push("The range assumes that all operations are off in the same direction.".to_string());
    }
    notes
}
