//! Results as text: the JSON of `predict` and the profile as CSV, as the contract fixes them.

use std::fmt::Write;

use serde::Serialize;

use crate::cutting::{CuttingError, Engagement, Loads, Setup};
use crate::project::VERSION;
use crate::project::cutting_results::{Cutting, OfOperation, cutting_refusal, cutting_remarks};
use crate::project::places::Lost;
use crate::project::trust::{Trust, doubt_sentence};
use crate::quote::{self, OperationShare, Quote, Share, ToolShare};
use crate::simulation::contour::Region;
use crate::simulation::feed::Held;
use crate::simulation::gcode::Severity;
use crate::simulation::profile::Samples;
use crate::simulation::toolpath::{Blending, Toolpath};
use crate::units::mm_per_min;

/// What `predict --json` prints.
#[derive(Clone, Debug, Serialize)]
pub struct Prediction {
    program: String,
    /// The control it was read for, by the word that chooses it.
    dialect: &'static str,
    programmed_time_s: f64,
    runs: Vec<Run>,
    diagnostics: Vec<Remark>,
    /// Of the first run.
    trust: Trust,
    /// Of the build that predicts.
    version: &'static str,
}

/// One tolerance for all of the program, or the program's own.
#[derive(Clone, Debug, Serialize)]
struct Run {
    /// Where the program sets several, the one under which most of the way is cut.
    tolerance_mm: f64,
    /// Where each of the program's own tolerances holds; left out where one is laid over all of it
    /// and where the program sets none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    tolerances: Vec<HeldTolerance>,
    cycle_time_s: f64,
    breakdown: Breakdown,
    /// In the order they are run; they add up to the breakdown.
    operations: Vec<Operation>,
    /// In the order of first use; they add up to the breakdown.
    tools: Vec<Tool>,
    /// Against length over feedrate.
    lost: Lost,
    max_contour_error_mm: f64,
    /// Where the contour error is above the tolerance.
    beyond_tolerance: Vec<Place>,
    price: f64,
    /// What of the cycle time is in doubt and why, one sentence; left out where nothing is.
    #[serde(skip_serializing_if = "Option::is_none")]
    in_doubt: Option<String>,
    /// Forces, where a cutting job is given and they can be computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    cutting: Option<Cutting>,
}

/// Where one tolerance of the program holds.
#[derive(Clone, Debug, Serialize)]
pub struct HeldTolerance {
    lines: [u32; 2],
    distance_mm: [f64; 2],
    /// Largest deviation; along arcs between exact stops.
    tolerance_mm: f64,
    /// What the program asks for: exact_stop, machine, tolerance or distance.
    mode: &'static str,
    /// The words that ask for it; empty before the first.
    source: String,
}

impl From<&Held> for HeldTolerance {
    fn from(held: &Held) -> HeldTolerance {
        HeldTolerance {
            lines: [held.lines.0.0, held.lines.1.0],
            distance_mm: [held.distance.0, held.distance.1],
            tolerance_mm: held.tolerance,
            mode: mode_word(held.blending),
            source: held.source.clone(),
        }
    }
}

/// The word for what the program asks for.
fn mode_word(blending: Blending) -> &'static str {
    match blending {
        Blending::ExactStop => "exact_stop",
        Blending::Machine => "machine",
        Blending::Within(_) => "tolerance",
        Blending::Distance(_) => "distance",
    }
}

#[derive(Clone, Debug, Serialize)]
struct Place {
    lines: [u32; 2],
    distance_mm: [f64; 2],
    max_contour_error_mm: f64,
}

#[derive(Clone, Debug, Serialize)]
struct Breakdown {
    cutting_s: f64,
    rapid_s: f64,
    dwell_s: f64,
    tool_change_s: f64,
    other_s: f64,
    /// What `other_s` is made of.
    other: Functions,
}

#[derive(Clone, Debug, Serialize)]
struct Functions {
    spindle_s: f64,
    coolant_s: f64,
    stops_s: f64,
    pallet_s: f64,
    clamp_s: f64,
    m_words_s: f64,
    start_s: f64,
    halts_s: f64,
}

#[derive(Clone, Debug, Serialize)]
struct Operation {
    /// Line that begins it.
    line: u32,
    /// Least and greatest line that it runs.
    lines: [u32; 2],
    distance_mm: [f64; 2],
    tool: Option<u32>,
    tool_name: Option<String>,
    name: Option<String>,
    #[serde(flatten)]
    part: Part,
    /// As of the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    cutting: Option<OfOperation>,
}

#[derive(Clone, Debug, Serialize)]
struct Tool {
    tool: Option<u32>,
    tool_name: Option<String>,
    operations: usize,
    #[serde(flatten)]
    part: Part,
}

/// What a part of a program takes.
#[derive(Clone, Debug, Serialize)]
struct Part {
    time_s: f64,
    programmed_time_s: f64,
    /// Time less programmed time.
    lost_s: f64,
    breakdown: Breakdown,
    feed_mm: f64,
    rapid_mm: f64,
    blocks: usize,
}

#[derive(Clone, Debug, Serialize)]
struct Remark {
    line: u32,
    severity: &'static str,
    message: String,
}

impl From<&Region> for Place {
    fn from(region: &Region) -> Place {
        Place {
            lines: [region.lines.0.0, region.lines.1.0],
            distance_mm: [region.distance.0, region.distance.1],
            max_contour_error_mm: region.largest,
        }
    }
}

impl From<&quote::Breakdown> for Breakdown {
    fn from(breakdown: &quote::Breakdown) -> Breakdown {
        let functions = &breakdown.functions;
        Breakdown {
            cutting_s: breakdown.cutting,
            rapid_s: breakdown.rapid,
            dwell_s: breakdown.dwell,
            tool_change_s: breakdown.tool_change,
            other_s: breakdown.other,
            other: Functions {
                spindle_s: functions.spindle,
                coolant_s: functions.coolant,
                stops_s: functions.stops,
                pallet_s: functions.pallet,
                clamp_s: functions.clamp,
                m_words_s: functions.m_words,
                start_s: functions.start,
                halts_s: functions.halts,
            },
        }
    }
}

impl From<&Share> for Part {
    fn from(share: &Share) -> Part {
        Part {
            time_s: share.time(),
            programmed_time_s: share.programmed,
            lost_s: share.lost(),
            breakdown: Breakdown::from(&share.breakdown),
            feed_mm: share.feed_length,
            rapid_mm: share.rapid_length,
            blocks: share.moves,
        }
    }
}

impl From<&OperationShare> for Operation {
    fn from(OperationShare { operation, lines, distance, share }: &OperationShare) -> Operation {
        Operation {
            line: operation.line.0,
            lines: [lines.0.0, lines.1.0],
            distance_mm: [distance.0, distance.1],
            tool: operation.tool,
            tool_name: operation.tool_name.clone(),
            name: operation.name.clone(),
            part: Part::from(share),
            cutting: None,
        }
    }
}

impl From<&ToolShare> for Tool {
    fn from(ToolShare { tool, name, operations, share }: &ToolShare) -> Tool {
        Tool { tool: *tool, tool_name: name.clone(), operations: *operations, part: Part::from(share) }
    }
}

/// The word for a severity.
pub fn severity_word(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Info => "info",
    }
}

impl Prediction {
    /// The prediction for a program: its name, what CAM would say (s), one quote a tolerance, and
    /// what there is to say about the program.
    pub fn new(program: &str, toolpath: &Toolpath, programmed_time: f64, quotes: &[Quote]) -> Prediction {
        let runs = quotes.iter().map(|quote| Run {
            tolerance_mm: quote.tolerance,
            tolerances: quote.held.iter().map(HeldTolerance::from).collect(),
            cycle_time_s: quote.cycle_time,
            breakdown: Breakdown::from(&quote.breakdown),
            operations: quote.operations.iter().map(Operation::from).collect(),
            tools: quote.tools.iter().map(Tool::from).collect(),
            lost: Lost::from(&quote.lost),
            max_contour_error_mm: quote.max_contour_error,
            beyond_tolerance: quote.beyond_tolerance.iter().map(Place::from).collect(),
            price: quote.price,
            in_doubt: doubt_sentence(&quote.trust),
            cutting: None,
        });
        let remarks = toolpath.diagnostics.iter().map(|diagnostic| Remark {
            line: diagnostic.line.0,
            severity: severity_word(diagnostic.severity),
            message: diagnostic.message.clone(),
        });
        Prediction {
            program: program.to_string(),
            dialect: toolpath.dialect.word(),
            programmed_time_s: programmed_time,
            runs: runs.collect(),
            diagnostics: remarks.collect(),
            trust: Trust::from(quotes.first().map_or(&quote::Trust::default(), |quote| &quote.trust)),
            version: VERSION,
        }
    }

    /// Adds the loads of a cut by the programmed and the predicted feedrate, one pair a run, or why
    /// there are none.
    pub fn with_cutting(
        mut self,
        setup: &Setup,
        engagement: &Result<Engagement, CuttingError>,
        runs: &[Result<[Loads; 2], CuttingError>],
    ) -> Prediction {
        let mut remarks = Vec::new();
        match engagement {
            Err(error) => remarks.push(cutting_refusal(error)),
            Ok(engagement) => {
                for (run, loads) in self.runs.iter_mut().zip(runs) {
                    match loads {
                        Err(error) => remarks.push(cutting_refusal(error)),
                        Ok(loads) => {
                            remarks.extend(cutting_remarks(engagement, setup, loads));
                            run.cutting = Some(Cutting::new(engagement, setup, loads));
                            for (operation, load) in run.operations.iter_mut().zip(&loads[1].operations) {
                                operation.cutting = Some(OfOperation::from(load));
                            }
                        }
                    }
                }
            }
        }
        // Runs of several tolerances say much the same.
        remarks.sort();
        remarks.dedup();
        self.diagnostics.extend(remarks.into_iter().map(|(line, is_error, message)| Remark {
            line,
            severity: severity_word(if is_error { Severity::Error } else { Severity::Warning }),
            message,
        }));
        self
    }

    /// As JSON text.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("text and finite numbers have a JSON form")
    }
}

/// What a table with this spacing (s) leaves out, as a sentence; none where it follows the profile.
pub fn spacing_note(spacing: Option<f64>) -> Option<String> {
    spacing.map(|spacing| {
        format!("One point every {spacing:.3} s, as the program is long: shorter dips of the feedrate may be missing. Times and errors are exact.")
    })
}

/// A profile as CSV, one row a sample.
pub fn profile_csv(samples: &Samples) -> String {
    let mut csv = String::from("time_s,distance_mm,feed_mm_min,x_mm,y_mm,z_mm,line\n");
    for row in 0..samples.time.len() {
        let [x, y, z] = [0, 1, 2].map(|axis: usize| samples.position[axis][row]);
        writeln!(
            csv,
            "{:.9},{:.9},{:.6},{x:.7},{y:.7},{z:.7},{}",
            samples.time[row],
            samples.distance[row],
            mm_per_min(samples.feedrate[row]),
            samples.line[row]
        )
        .expect("writing to a string cannot fail");
    }
    csv
}
