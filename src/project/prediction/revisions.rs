//! Two revisions of a program for people: the lines that cost or save most, and the remainder.

use serde::{Deserialize, Serialize};

use crate::machine::Machine;
use crate::project::{TextFault, machine_from_form};
use crate::quote::{RevisedLines, Revisions};
use crate::simulation::feed::Tolerances;
use crate::simulation::gcode::Options;
use crate::simulation::ordered::sort_by_number;

/// Most runs of lines that are listed; more are only summed.
const MAX_LISTED_RUNS: usize = 24;
/// Least difference of time of a run that is listed, s.
const MIN_TIME_DIFFERENCE_S: f64 = 0.01;
/// Least difference of length of a run that is listed, mm.
const MIN_LENGTH_DIFFERENCE_MM: f64 = 0.001;

/// The settings of one revision in the page's request.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RevisedSide {
    /// Filled machine form as JSON.
    machine: String,
    /// Dialect, arc centres, or both; `None` to detect them from the program.
    dialect: Option<String>,
    /// Contour tolerance, mm; `None` for the tolerances of the program.
    tolerance: Option<f64>,
}

impl RevisedSide {
    /// Reads both sides from a JSON text.
    ///
    /// # Errors
    ///
    /// Returns the faults of the text, or of a machine.
    pub fn both(json: &str) -> Result<[(Machine, Options, Tolerances); 2], Vec<TextFault>> {
        let sides: [RevisedSide; 2] = serde_json::from_str(json)
            .map_err(|error| vec![TextFault { place: None, key: None, message: error.to_string() }])?;
        let [first, second] = sides.map(RevisedSide::read);
        Ok([first?, second?])
    }

    fn read(self) -> Result<(Machine, Options, Tolerances), Vec<TextFault>> {
        let machine = machine_from_form(&self.machine)?;
        let options = Options::from_words(&self.dialect.unwrap_or_default());
        Ok((machine, options, self.tolerance.map_or(Tolerances::Programmed, Tolerances::One)))
    }
}

/// The differences between two revisions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RevisionsReport {
    /// `true` if both have the same lines in the same order.
    is_same: bool,
    /// Cycle times of the first and of the second, s.
    cycle_time_s: [f64; 2],
    difference_s: f64,
    /// Lengths of the moves of the first and of the second, mm.
    length_mm: [f64; 2],
    /// Runs of lines with the largest difference of time, the largest first.
    runs: Vec<RevisedRow>,
    /// Difference of all other lines together, s.
    elsewhere_s: f64,
}

/// A run of lines.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct RevisedRow {
    /// First and last line in each revision; `None` if it has none.
    lines: [Option<[u32; 2]>; 2],
    is_same: bool,
    seconds: [f64; 2],
    difference_s: f64,
    length_mm: [f64; 2],
    /// Distances of the lines of the second revision along its path.
    distance_mm: Option<[f64; 2]>,
}

impl RevisionsReport {
    /// Returns the report of two revisions.
    pub fn new(revisions: &Revisions) -> RevisionsReport {
        let sums = |of: fn(&RevisedLines) -> [f64; 2]| {
            revisions.runs.iter().map(of).fold([0.0, 0.0], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
        };
        let cycle_time_s = sums(|run| run.seconds);
        let mut rows: Vec<RevisedRow> = revisions.runs.iter().map(row).filter(RevisedRow::differs).collect();
        sort_by_number(&mut rows, |row| -row.difference_s.abs());
        rows.truncate(MAX_LISTED_RUNS);
        let difference_s = cycle_time_s[1] - cycle_time_s[0];
        RevisionsReport {
            is_same: revisions.runs.iter().all(|run| run.is_same),
            cycle_time_s,
            difference_s,
            length_mm: sums(|run| run.length),
            elsewhere_s: difference_s - rows.iter().map(|row| row.difference_s).sum::<f64>(),
            runs: rows,
        }
    }
}

impl RevisedRow {
    /// Returns `true` if time or length of the lines differ; lines that are only written differently do not
    /// differ.
    fn differs(&self) -> bool {
        MIN_TIME_DIFFERENCE_S <= self.difference_s.abs()
            || MIN_LENGTH_DIFFERENCE_MM <= (self.length_mm[1] - self.length_mm[0]).abs()
    }
}

fn row(run: &RevisedLines) -> RevisedRow {
    let lines = run.lines.clone();
    RevisedRow {
        lines: lines.map(|lines| (!lines.is_empty()).then(|| [lines.start, lines.end - 1])),
        is_same: run.is_same,
        seconds: run.seconds,
        difference_s: run.seconds[1] - run.seconds[0],
        length_mm: run.length,
        distance_mm: run.distance.map(|(from, to)| [from, to]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(lines: [std::ops::Range<u32>; 2], is_same: bool, seconds: [f64; 2]) -> RevisedLines {
        RevisedLines { lines, is_same, seconds, length: [10.0, 10.0], distance: Some((0.0, 10.0)) }
    }

    #[test]
    fn what_differs_most_comes_first_and_all_of_it_adds_up() {
        let mut runs = vec![
            run([1..4, 1..4], true, [5.0, 5.001]),
            run([4..5, 4..4], false, [2.0, 0.0]),
            run([5..9, 4..8], true, [5.0, 9.0]),
        ];
        runs.extend(
            (0..40).map(|at| run([at..at + 1, at..at + 1], false, [1.0, 1.0 + 0.02 * f64::from(at)])),
        );
        let report = RevisionsReport::new(&Revisions { runs, ..Revisions::default() });
        assert!(!report.is_same);
        assert_eq!(report.runs.len(), MAX_LISTED_RUNS);
        assert_eq!(report.runs[0].lines, [Some([5, 8]), Some([4, 7])]);
        assert_eq!(report.runs[1].lines, [Some([4, 4]), None]);
        let told: f64 = report.runs.iter().map(|row| row.difference_s).sum();
        assert!((told + report.elsewhere_s - report.difference_s).abs() < 1e-9);
        assert!(report.elsewhere_s > 0.0);
    }

    #[test]
    fn a_side_without_a_machine_or_with_an_unknown_field_is_refused() {
        let fault = |json: &str| RevisedSide::both(json).expect_err("it is refused")[0].message.clone();
        assert!(fault("[]").contains("invalid length"), "{}", fault("[]"));
        let side = r#"{"machine": "{}", "dialect": null, "tolerance": null, "more": 1}"#;
        assert!(fault(&format!("[{side}, {side}]")).contains("more"));
    }
}
