//! Results as text: the JSON of `predict` and the profile as CSV, in their documented form.

use std::fmt::Write;

use serde::Serialize;

use crate::cutting::{CuttingError, Engagement, LoadCurve, Setup};
use crate::project::VERSION;
use crate::project::cutting::results::{Cutting, OperationLoadRow, cutting_refusal, cutting_remarks};
use crate::project::prediction::time_losses::LostTimesRow;
use crate::project::prediction::time_range::RangeRow;
use crate::project::prediction::trust::{TrustRow, doubt_sentence};
use crate::quote::{self, OperationShare, Quote, TimeShare, ToolShare};
use crate::simulation::contour::ErrorRegion;
use crate::simulation::feed::ToleranceRange;
use crate::simulation::gcode::Severity;
use crate::simulation::profile::Samples;
use crate::simulation::toolpath::{Blending, Toolpath};
use crate::units::mm_per_min;

/// The output of `predict --json`.
#[derive(Clone, Debug, Serialize)]
pub struct Prediction {
    program: String,
    /// Keyword of the dialect.
    dialect: &'static str,
    programmed_time_s: f64,
    runs: Vec<RunRow>,
    diagnostics: Vec<RemarkRow>,
    /// Trust in the first run.
    trust: TrustRow,
    /// Version of the build.
    version: &'static str,
}

/// The results at one tolerance for the whole program, or at the tolerances of the program.
#[derive(Clone, Debug, Serialize)]
struct RunRow {
    /// Contour tolerance; if the program sets several, the one along most of the cut length.
    tolerance_mm: f64,
    /// Ranges of the program's tolerances; left out if one tolerance replaces them or the program sets none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    tolerances: Vec<ToleranceRangeRow>,
    cycle_time_s: f64,
    breakdown: BreakdownRow,
    /// Operations in the order they are run; they add up to the breakdown.
    operations: Vec<OperationShareRow>,
    /// Tools in the order of first use; they add up to the breakdown.
    tools: Vec<ToolShareRow>,
    /// Time lost against length over feedrate.
    lost: LostTimesRow,
    max_contour_error_mm: f64,
    /// Regions with a contour error above the tolerance.
    beyond_tolerance: Vec<RegionRow>,
    price: f64,
    /// Range of the time on a calibrated machine; left out on other machines.
    #[serde(skip_serializing_if = "Option::is_none")]
    range: Option<RangeRow>,
    /// Doubts about the cycle time and their reasons, one sentence; left out if there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    in_doubt: Option<String>,
    /// Forces, if a cutting job is given and they can be computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    cutting: Option<Cutting>,
}

/// The range of one tolerance of the program.
#[derive(Clone, Debug, Serialize)]
pub struct ToleranceRangeRow {
    lines: [u32; 2],
    distance_mm: [f64; 2],
    /// Largest deviation; along arcs between exact stops.
    tolerance_mm: f64,
    /// Blending that the program requests: exact_stop, machine, tolerance or distance.
    mode: &'static str,
    /// The words that request the blending; empty before the first of them.
    source: String,
}

impl From<&ToleranceRange> for ToleranceRangeRow {
    fn from(held: &ToleranceRange) -> ToleranceRangeRow {
        ToleranceRangeRow {
            lines: [held.lines.0.0, held.lines.1.0],
            distance_mm: [held.distance.0, held.distance.1],
            tolerance_mm: held.tolerance,
            mode: mode_word(held.blending),
            source: held.source.clone(),
        }
    }
}

/// Returns the keyword of a blending.
fn mode_word(blending: Blending) -> &'static str {
    match blending {
        Blending::ExactStop | Blending::ExactPath => "exact_stop",
        Blending::Machine => "machine",
        Blending::Within(_) => "tolerance",
        Blending::Distance(_) => "distance",
    }
}

#[derive(Clone, Debug, Serialize)]
struct RegionRow {
    lines: [u32; 2],
    distance_mm: [f64; 2],
    max_contour_error_mm: f64,
}

#[derive(Clone, Debug, Serialize)]
struct BreakdownRow {
    cutting_s: f64,
    rapid_s: f64,
    dwell_s: f64,
    tool_change_s: f64,
    other_s: f64,
    /// Parts of `other_s`.
    other: FunctionsRow,
}

#[derive(Clone, Debug, Serialize)]
struct FunctionsRow {
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
struct OperationShareRow {
    /// First line.
    line: u32,
    /// Least and greatest line of the operation.
    lines: [u32; 2],
    distance_mm: [f64; 2],
    tool: Option<u32>,
    tool_name: Option<String>,
    name: Option<String>,
    #[serde(flatten)]
    part: ShareFields,
    /// Demands of the cut on tool and spindle in the operation.
    #[serde(skip_serializing_if = "Option::is_none")]
    cutting: Option<OperationLoadRow>,
}

#[derive(Clone, Debug, Serialize)]
struct ToolShareRow {
    tool: Option<u32>,
    tool_name: Option<String>,
    operations: usize,
    #[serde(flatten)]
    part: ShareFields,
}

/// Time and moves of a part of a program.
#[derive(Clone, Debug, Serialize)]
struct ShareFields {
    time_s: f64,
    programmed_time_s: f64,
    /// Time less programmed time.
    lost_s: f64,
    breakdown: BreakdownRow,
    feed_mm: f64,
    rapid_mm: f64,
    blocks: usize,
}

#[derive(Clone, Debug, Serialize)]
struct RemarkRow {
    line: u32,
    severity: &'static str,
    message: String,
}

impl From<&ErrorRegion> for RegionRow {
    fn from(region: &ErrorRegion) -> RegionRow {
        RegionRow {
            lines: [region.lines.0.0, region.lines.1.0],
            distance_mm: [region.distance.0, region.distance.1],
            max_contour_error_mm: region.largest,
        }
    }
}

impl From<&quote::Breakdown> for BreakdownRow {
    fn from(breakdown: &quote::Breakdown) -> BreakdownRow {
        let functions = &breakdown.functions;
        BreakdownRow {
            cutting_s: breakdown.cutting,
            rapid_s: breakdown.rapid,
            dwell_s: breakdown.dwell,
            tool_change_s: breakdown.tool_change,
            other_s: breakdown.other,
            other: FunctionsRow {
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

impl From<&TimeShare> for ShareFields {
    fn from(share: &TimeShare) -> ShareFields {
        ShareFields {
            time_s: share.time(),
            programmed_time_s: share.programmed,
            lost_s: share.lost(),
            breakdown: BreakdownRow::from(&share.breakdown),
            feed_mm: share.feed_length,
            rapid_mm: share.rapid_length,
            blocks: share.moves,
        }
    }
}

impl From<&OperationShare> for OperationShareRow {
    fn from(OperationShare { operation, lines, distance, share }: &OperationShare) -> OperationShareRow {
        OperationShareRow {
            line: operation.line.0,
            lines: [lines.0.0, lines.1.0],
            distance_mm: [distance.0, distance.1],
            tool: operation.tool,
            tool_name: operation.tool_name.clone(),
            name: operation.name.clone(),
            part: ShareFields::from(share),
            cutting: None,
        }
    }
}

impl From<&ToolShare> for ToolShareRow {
    fn from(ToolShare { tool, name, operations, share }: &ToolShare) -> ToolShareRow {
        ToolShareRow {
            tool: *tool,
            tool_name: name.clone(),
            operations: *operations,
            part: ShareFields::from(share),
        }
    }
}

/// Returns the keyword of a severity.
pub fn severity_word(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Info => "info",
    }
}

impl Prediction {
    /// Returns the prediction for a program: its name, CAM's estimate (s), one quote per tolerance, and the
    /// remarks on the program.
    pub fn new(program: &str, toolpath: &Toolpath, programmed_time: f64, quotes: &[Quote]) -> Prediction {
        let runs = quotes.iter().map(|quote| RunRow {
            tolerance_mm: quote.tolerance,
            tolerances: quote.tolerance_ranges.iter().map(ToleranceRangeRow::from).collect(),
            cycle_time_s: quote.cycle_time,
            breakdown: BreakdownRow::from(&quote.breakdown),
            operations: quote.operations.iter().map(OperationShareRow::from).collect(),
            tools: quote.tools.iter().map(ToolShareRow::from).collect(),
            lost: LostTimesRow::from(&quote.lost),
            max_contour_error_mm: quote.max_contour_error,
            beyond_tolerance: quote.beyond_tolerance.iter().map(RegionRow::from).collect(),
            price: quote.price,
            range: quote.range.as_ref().map(|range| RangeRow::new(range, quote.cycle_time)),
            in_doubt: doubt_sentence(&quote.trust),
            cutting: None,
        });
        let remarks = toolpath.diagnostics.iter().map(|diagnostic| RemarkRow {
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
            trust: TrustRow::from(quotes.first().map_or(&quote::Trust::default(), |quote| &quote.trust)),
            version: VERSION,
        }
    }

    /// Adds the loads of a cut at the programmed and the predicted feedrate, one pair per run, or the reason
    /// why there are no loads.
    pub fn with_cutting(
        mut self,
        setup: &Setup,
        engagement: &Result<Engagement, CuttingError>,
        runs: &[Result<[LoadCurve; 2], CuttingError>],
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
                                operation.cutting = Some(OperationLoadRow::from(load));
                            }
                        }
                    }
                }
            }
        }
        // Runs of several tolerances have nearly the same remarks.
        remarks.sort();
        remarks.dedup();
        self.diagnostics.extend(remarks.into_iter().map(|(line, is_error, message)| RemarkRow {
            line,
            severity: severity_word(if is_error { Severity::Error } else { Severity::Warning }),
            message,
        }));
        self
    }

    /// Returns the prediction as JSON text.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("text and finite numbers have a JSON form")
    }
}

/// Returns a sentence on the features that a table with this spacing (s) leaves out; `None` if the table
/// follows the profile.
pub fn spacing_note(spacing: Option<f64>) -> Option<String> {
    spacing.map(|spacing| {
        format!("The program is long, so there is one point every {spacing:.3} s: shorter dips of the feedrate may be missing. Times and errors are exact.")
    })
}

/// Returns a profile as CSV, one row per sample.
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
