//! Results as text: the JSON of `predict` and the profile as CSV, as the contract fixes them.

use std::fmt::Write;

use serde::Serialize;

use crate::quote::Quote;
use crate::simulation::contour::Region;
use crate::simulation::feed::Held;
use crate::simulation::gcode::{Diagnostic, Severity};
use crate::simulation::profile::Samples;
use crate::simulation::toolpath::Blending;
use crate::units::mm_per_min;

/// What `predict --json` prints.
#[derive(Clone, Debug, Serialize)]
pub struct Prediction {
    program: String,
    programmed_time_s: f64,
    runs: Vec<Run>,
    diagnostics: Vec<Remark>,
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
    max_contour_error_mm: f64,
    /// Where the contour error is above the tolerance.
    beyond_tolerance: Vec<Place>,
    price: f64,
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
    pub fn new(
        program: &str,
        programmed_time: f64,
        quotes: &[Quote],
        diagnostics: &[Diagnostic],
    ) -> Prediction {
        let runs = quotes.iter().map(|quote| Run {
            tolerance_mm: quote.tolerance,
            tolerances: quote.held.iter().map(HeldTolerance::from).collect(),
            cycle_time_s: quote.cycle_time,
            breakdown: Breakdown {
                cutting_s: quote.breakdown.cutting,
                rapid_s: quote.breakdown.rapid,
                dwell_s: quote.breakdown.dwell,
                tool_change_s: quote.breakdown.tool_change,
                other_s: quote.breakdown.other,
            },
            max_contour_error_mm: quote.max_contour_error,
            beyond_tolerance: quote.beyond_tolerance.iter().map(Place::from).collect(),
            price: quote.price,
        });
        let remarks = diagnostics.iter().map(|diagnostic| Remark {
            line: diagnostic.line.0,
            severity: severity_word(diagnostic.severity),
            message: diagnostic.message.clone(),
        });
        Prediction {
            program: program.to_string(),
            programmed_time_s: programmed_time,
            runs: runs.collect(),
            diagnostics: remarks.collect(),
        }
    }

    /// As JSON text.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("text and finite numbers have a JSON form")
    }
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
