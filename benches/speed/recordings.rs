//! Hour-long recordings for measuring the speed of identification: simulated for each measurement, never stored.
//!
//! The recorded machine is a planner with junction deviation. It runs each program for at least an hour, and its positions
//! are recorded every 10 ms, rounded to a micrometre. The preset has filters instead, so a diagnosis has to calibrate it first.

use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

use truefeed::identification::calibration::calibrate;
use truefeed::identification::diagnosis::diagnose;
use truefeed::identification::fit::{AlignedRun, Run};
use truefeed::machine::{Machine, Planner};
use truefeed::simulation::gcode::Options;
use truefeed::simulation::interpreter::trace_text;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Toolpath;

use crate::programs::Made;

/// Least duration of a recorded run, s.
const RUN_S: f64 = 3600.0;
/// Time between the rows of a recording, s.
const ROW_S: f64 = 0.01;
/// Accelerations of the axes of the recorded machine, mm/s².
const ACCELERATIONS_MM_S2: [f64; 3] = [650.0, 480.0, 320.0];
/// Lines of the first program, and lines added to each estimate of how many a run of [`RUN_S`] needs.
const PROGRAM_STEP_LINES: usize = 1_000;

/// The work of a measurement on recordings of an hour.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum LogWork {
    /// Reads the recording and aligns it with the program.
    Align,
    /// Calibrates the preset by one recording.
    Calibrate,
    /// Calibrates the preset by recordings of two programs.
    CalibrateByTwo,
    /// Diagnoses the recording from the preset.
    Diagnose,
}

impl LogWork {
    pub const ALL: [LogWork; 4] =
        [LogWork::Align, LogWork::Calibrate, LogWork::CalibrateByTwo, LogWork::Diagnose];

    pub fn word(self) -> &'static str {
        match self {
            LogWork::Align => "align",
            LogWork::Calibrate => "calibrate",
            LogWork::CalibrateByTwo => "calibrate by two",
            LogWork::Diagnose => "diagnose",
        }
    }

    /// Does the work once on all processors. Returns the time that passed, s.
    pub fn seconds(self) -> f64 {
        let preset = Machine::default();
        let programs: &[Made] =
            if self == LogWork::CalibrateByTwo { &[Made::Roughing, Made::Arcs] } else { &[Made::Roughing] };
        let recorded: Vec<Recorded> = programs.iter().map(|made| Recorded::of(*made)).collect();
        let align = || recorded.into_iter().map(|own| own.aligned(&preset)).collect::<Vec<AlignedRun>>();
        if self == LogWork::Align {
            return seconds(align);
        }
        let aligned = align();
        let runs: Vec<Run> = aligned.iter().map(AlignedRun::run).collect();
        match self {
            LogWork::Diagnose => seconds(|| diagnose(&preset, &runs, &mut |_| {})),
            _ => seconds(|| calibrate(&preset, &runs, &mut |_| {})),
        }
    }
}

/// Returns the time that work takes, s.
fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let begin = Instant::now();
    black_box(work());
    begin.elapsed().as_secs_f64()
}

/// The path of a program, and the text of its recording.
struct Recorded {
    toolpath: Toolpath,
    csv: String,
}

impl Recorded {
    /// Returns the run of a program of this kind that lasts an hour.
    fn of(made: Made) -> Recorded {
        let mut machine = Machine::default();
        machine.become_planner(Planner::JunctionDeviation, ACCELERATIONS_MM_S2[0]);
        machine.axes.iter_mut().zip(ACCELERATIONS_MM_S2).for_each(|(axis, own)| axis.acceleration = own);
        let mut lines = PROGRAM_STEP_LINES;
        loop {
            let toolpath = trace_text(made.text(lines), &Options::default(), &machine);
            let plan = simulate(&toolpath, &machine);
            if RUN_S <= plan.cycle_time() {
                let csv = rows(&Profile::new(&toolpath, &plan));
                return Recorded { toolpath, csv };
            }
            lines = (lines as f64 * RUN_S / plan.cycle_time()) as usize + PROGRAM_STEP_LINES;
        }
    }

    /// Returns the recording aligned with its program.
    fn aligned(self, machine: &Machine) -> AlignedRun {
        AlignedRun::new(self.toolpath, self.csv.as_bytes(), machine)
            .expect("the recording is of this program")
    }
}

/// Returns the positions of a run as CSV.
fn rows(profile: &Profile) -> String {
    let mut text = "t_s,x_mm,y_mm,z_mm\n".to_string();
    for row in 0..=(profile.cycle_time() / ROW_S) as usize {
        let time = ROW_S * row as f64;
        let at = profile.at_time(time).position;
        writeln!(text, "{time:.2},{:.3},{:.3},{:.3}", at.x, at.y, at.z).expect("text grows");
    }
    text
}
