//! The machine: every parameter of control and axes that the simulation reads.
//!
//! Each physical effect is a parameter with a neutral value at which it does nothing; a limit
//! is neutral at infinity, a ratio at 1, a time at 0. The simulation reads these fields and
//! nothing else, and the diagnosis will later free them one by one. Derived quantities are
//! computed where they are needed, never stored.
//!
//! Source of the interpolator's fields: Ward, Sencer, Jones and Ozturk 2021, Sect. 2 and 3.

mod halts;
mod handle;
mod junction;
mod parameter;
mod parameters;
mod planner;
mod presets;
mod supply;
mod times;
mod tolerance;
mod words;

use crate::machine::words::word_of;
use std::collections::BTreeMap;

pub use halts::{Halts, InPosition};
pub use handle::Handle;
pub use junction::Junction;
pub use parameter::{Access, Parameter};
pub use parameters::{PARAMETERS, parameter};
pub use planner::{PLANNER_FILTER_S, Planner};
pub use presets::{Preset, presets};
pub use supply::PlannedBy;
pub use times::{Direction, Function, Spin, SpindleTimes, Times};
pub use tolerance::{
    ToleranceError, USUAL_TOLERANCES, checked_tolerance, deviation_label, tolerance_from_text,
    tolerance_label,
};

/// The axes a limit can belong to, in the order of the coordinates of a point.
pub const AXES: [char; 3] = ['X', 'Y', 'Z'];

/// A machine tool with its control.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Name shown to people.
    pub name: String,
    /// Where the numbers come from; may be empty.
    pub provenance: String,
    /// How far off the cycle time was where these numbers were calibrated, as a part of it; none where nobody knows.
    pub cycle_time_error: Option<f64>,
    /// Lost time, by region and nothing set off, that calibration left unexplained, as a part of the recorded time.
    pub unexplained_time: Option<f64>,
    /// Distance of recorded from simulated positions at equal times that calibration left, rms, mm.
    pub form_error: Option<f64>,
    /// The contour tolerances it was so far off at, mm; none named: that of the interpolator.
    pub calibrated_at: Vec<f64>,
    /// How feed pulses become motion.
    pub interpolator: Interpolator,
    /// What is particular to rapid moves.
    pub rapid: Rapid,
    /// Tolerances that a program asks for by a level.
    pub path_modes: PathModes,
    /// Limits along the path.
    pub path: PathLimits,
    /// Each axis X, Y, Z.
    pub axes: [Axis; 3],
    /// Each rotary axis A, B, C.
    pub rotary_axes: [RotaryAxis; 3],
    /// Machine coordinates of the zero points of G54 to G59, mm; neutral none: zero, and unknown.
    pub work_offsets: [Option<[f64; 3]>; 6],
    /// Override switches.
    pub overrides: Overrides,
    /// What records its runs.
    pub recorder: Recorder,
    /// What cycles leave to the control.
    pub cycles: Cycles,
    /// How the control reads a program.
    pub program: Reading,
    /// Times that are not motion.
    pub times: Times,
    /// Halts that the program does not ask for.
    pub halts: Halts,
    /// The tools it holds, by number; neutral none.
    pub tools: BTreeMap<u32, Tool>,
    /// What an hour costs.
    pub rates: Rates,
}

/// Filters, tolerance and block handling of the control.
#[derive(Clone, Debug, PartialEq)]
pub struct Interpolator {
    /// Number of first-order filters in series, 1 to 4.
    pub filters: usize,
    /// Their time constants.
    pub time_constants: TimeConstants,
    /// Contour tolerance at corners, mm.
    pub contour_tolerance: f64,
    /// Contour tolerance along arcs, mm; neutral none: that of corners.
    pub arc_tolerance: Option<f64>,
    /// What the tolerance is held for.
    pub corner_mode: CornerMode,
    /// What else limits the feedrate at corners; neutral the tolerance alone.
    pub junction: Junction,
    /// Full stop where the path turns by more than this, rad; neutral π.
    pub exact_stop_angle: f64,
    /// Corners are slowed by the fourth power of their turn, down to a full stop from this turn on, rad; neutral infinite.
    pub slowing_angle: f64,
    /// An arc is run as chords that turn by so much, rad, and what the command holds for a corner on
    /// an arc ends with the first of them; neutral at 20π or more: an arc is one block. 1° where nothing is said.
    pub arc_step: f64,
    /// Into which chords an arc is cut before it is planned; neutral into none.
    pub arc_chords: ArcChords,
    /// The least part of a move that speeds up and slows down at which it cruises, 0 to 1; neutral 0.
    pub minimum_cruise_ratio: f64,
    /// Shortest time the control needs for a block, s; neutral 0.
    pub block_time: f64,
    /// Blocks the control sees ahead; neutral infinite.
    pub look_ahead: f64,
    /// By which feedrate corners are planned where blocks are short.
    pub planned_by: PlannedBy,
    /// Chains of lines whose points lie within this distance of one line are run as that line, mm; 0: no
    /// line is; neutral none: as the program says where the law of junctions is LinuxCNC's, else as 0.
    pub path_smoothing: Option<f64>,
    /// Corners between lines that a curve passes within this distance are not slowed, mm; neutral 0.
    pub corner_smoothing: f64,
}

/// How the time constants of the filters are known.
#[derive(Clone, Debug, PartialEq)]
pub enum TimeConstants {
    /// All equal, s.
    Equal(f64),
    /// All equal, from the jerk limit J (mm/s³) and the feedrate F: T1 = √(F/J), Eq. 8.
    FromJerk(f64),
    /// One for each filter, s.
    Unequal(Vec<f64>),
}

/// Into which chords a control cuts an arc before it plans it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ArcChords {
    /// Into none: an arc is one block.
    Whole,
    /// Into as long ones as lie within this distance of the arc, mm.
    Within(f64),
    /// Into ones of at least this length along the arc, mm.
    Long(f64),
}

/// Where the contour tolerance is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CornerMode {
    /// At each corner as if it were alone, as published.
    Paper,
    /// By the filtered path, everywhere.
    Guaranteed,
}

impl Interpolator {
    /// The turn from which on corners are full stops, rad; π where none is.
    pub fn stopping_angle(&self) -> f64 {
        self.exact_stop_angle.min(self.slowing_angle)
    }
}

impl CornerMode {
    /// All modes with the word they are written with.
    pub const WORDS: [(&'static str, CornerMode); 2] =
        [("paper", CornerMode::Paper), ("guaranteed", CornerMode::Guaranteed)];

    /// The word it is written with.
    pub fn word(self) -> &'static str {
        word_of(&CornerMode::WORDS, self)
    }
}

/// Rapid moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Rapid {
    /// Feedrate along the path, mm/s; neutral infinite where each axis has a rapid of its own.
    pub feedrate: f64,
    /// Rate at which a rotary axis turns in rapid, rad/s.
    pub rotary_rate: f64,
    /// Full stop at both ends of a chain of rapid moves; neutral false: blended like feed moves.
    pub exact_stop: bool,
    /// Time constants of the filters during rapid moves; neutral none: those of feed moves.
    pub time_constants: Option<TimeConstants>,
    /// Jerk of the axis that moves furthest, mm/s³, where each rapid is run from stand to stand with ramps
    /// that grow with the speed it reaches; neutral infinite: rapids are not run so.
    pub positioning_jerk: f64,
}

/// Tolerances behind the levels of the control, mm; neutral none: they are not known, and the
/// machine's contour tolerance holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathModes {
    /// Of G187 P1.
    pub rough: Option<f64>,
    /// Of G187 P2.
    pub medium: Option<f64>,
    /// Of G187 P3.
    pub finish: Option<f64>,
    /// Of G5.1 R1; levels between this and the next lie evenly between both.
    pub level_1: Option<f64>,
    /// Of G5.1 R10.
    pub level_10: Option<f64>,
    /// What the control holds in place of every tolerance that a program sets.
    pub tolerance_override: Option<f64>,
}

/// Limits along the path, whatever its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathLimits {
    /// Acceleration along the path, mm/s²; neutral infinite.
    pub acceleration: f64,
    /// Jerk along the path of each change of the command, mm/s³; neutral infinite.
    pub jerk: f64,
    /// Whether the limits of acceleration, of the axes too, shape the command that goes into the filters; neutral
    /// false: what leaves them is run slower where it is beyond one.
    pub limits_command: bool,
    /// Acceleration towards the centre of an arc, mm/s²; neutral infinite.
    pub centripetal_acceleration: f64,
}

/// One axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Fastest the axis moves, mm/s; neutral infinite.
    pub velocity: f64,
    /// Fastest the axis moves in rapid, mm/s; neutral infinite.
    pub rapid: f64,
    /// Largest acceleration, mm/s²; neutral infinite.
    pub acceleration: f64,
    /// Largest jerk at a corner, mm/s³; neutral infinite.
    pub jerk: f64,
    /// Reference position in the program's coordinates, mm, where it is known.
    pub home: Option<f64>,
    /// Time constant of the position loop, s: how far the axis trails; neutral 0.
    pub servo_lag: f64,
    /// Play between drive and table, mm; neutral 0.
    pub backlash: f64,
    /// First structural mode; neutral none.
    pub mode: Option<Mode>,
}

/// One rotary axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotaryAxis {
    /// Fastest the axis turns, rad/s; neutral infinite.
    pub velocity: f64,
}

/// Rapid rate of rotary axes where the machine does not give one, rad/s: 9000 °/min, 25 rev/min,
/// usual for tables and heads of machining centres.
const RAPID_ROTARY_RATE: f64 = 50.0 * std::f64::consts::PI / 60.0;

/// What arcs are cut into where the machine does not say, rad: 1°.
pub(crate) const ARC_STEP: f64 = std::f64::consts::PI / 180.0;

/// A lightly damped oscillation between drive and tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Undamped frequency, Hz.
    pub frequency: f64,
    /// Damping ratio, 0 to 1.
    pub damping: f64,
}

/// Override switches, as ratios.
#[derive(Clone, Debug, PartialEq)]
pub struct Overrides {
    /// Of feed moves; neutral 1.
    pub feed: f64,
    /// Of rapid moves; neutral 1.
    pub rapid: f64,
    /// First and last line of the program on which the override of feed moves is in force; neutral all.
    pub lines: (u32, u32),
    /// Ratios of feed moves from a line of the program on, until another line has another one; neutral none.
    pub feed_by_line: BTreeMap<u32, f64>,
    /// The same of rapid moves.
    pub rapid_by_line: BTreeMap<u32, f64>,
}

impl Overrides {
    /// The override of feed moves on a line of the program.
    pub fn of_feed(&self, line: u32) -> f64 {
        let whole = if self.lines.0 <= line && line <= self.lines.1 { self.feed } else { 1.0 };
        whole * Overrides::at(&self.feed_by_line, line)
    }

    /// The override of rapid moves on a line of the program.
    pub fn of_rapid(&self, line: u32) -> f64 {
        self.rapid * Overrides::at(&self.rapid_by_line, line)
    }

    /// Whether that of feed moves is the same on all lines.
    pub fn is_even(&self) -> bool {
        self.lines == (0, u32::MAX) && self.feed_by_line.is_empty()
    }

    fn at(by_line: &BTreeMap<u32, f64>, line: u32) -> f64 {
        if by_line.is_empty() {
            return 1.0;
        }
        by_line.range(..=line).next_back().map_or(1.0, |(_, ratio)| *ratio)
    }
}

/// What is particular to recordings of the machine; it changes no motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recorder {
    /// Time its clock shows over the time that passes; neutral 1.
    pub clock_ratio: f64,
}

/// What cycles leave to the control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycles {
    /// How far chip breaking (G73) lifts the tool between pecks, mm; none: what is usual for the
    /// dialect.
    pub peck_retract: Option<f64>,
    /// How far above the last depth pecking (G83) feeds again, mm; none: as above.
    pub peck_clearance: Option<f64>,
    /// Whether tapping in pecks (Q of G84) comes out to the reference height between them; neutral false: it is turned
    /// back by the retract of chip breaking.
    pub taps_out: bool,
}

/// How the control reads a program.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Length of one unit of the last place of a number without a decimal point, mm; in inch its
    /// tenth in inch; neutral none: such a number is a length as written.
    pub increment: Option<f64>,
}

/// A tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tool {
    /// Diameter of the circle it cuts, mm.
    pub diameter: f64,
}

/// What the machine costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// Price of an hour of machine time, in the user's currency.
    pub hourly: f64,
}

impl Machine {
    /// Returns the rapid feedrate r of a move of which axis k takes the part u_k, mm/s: that along the path, and no axis above
    /// its own, r = min(r_path, min_k r_k / |u_k|).
    pub fn rapid_feedrate(&self, shares: [f64; 3]) -> f64 {
        let axes = self.axes.iter().zip(shares).map(|(axis, share)| axis.rapid / share.abs());
        axes.fold(self.rapid.feedrate, f64::min)
    }

    /// Returns the fastest rapid feedrate in any direction, mm/s: with rapids of axes, that of the move on which all of them
    /// run at their own.
    pub fn fastest_rapid(&self) -> f64 {
        let squares = self.axes.iter().map(|axis| axis.rapid * axis.rapid);
        self.rapid.feedrate.min(squares.sum::<f64>().sqrt())
    }

    /// Whether each axis has a rapid of its own.
    pub fn has_rapids_of_axes(&self) -> bool {
        self.axes.iter().all(|axis| axis.rapid.is_finite())
    }

    /// The contour tolerances at which it is known how far off the cycle time is, where that is known, mm.
    pub fn tolerances_of_error(&self) -> &[f64] {
        match self.calibrated_at.as_slice() {
            [] => std::slice::from_ref(&self.interpolator.contour_tolerance),
            named => named,
        }
    }

    /// Whether limits of acceleration shape the command, before any filter: laws of junctions that are laws of
    /// acceleration plan their ramps by themselves.
    pub fn limits_command(&self) -> bool {
        self.path.limits_command || self.interpolator.junction != Junction::Tolerance
    }
}

/// Free of every optional effect; the five numbers a machine file must give are those of the
/// first preset.
impl Default for Machine {
    fn default() -> Machine {
        Machine {
            name: "Machining centre".to_string(),
            provenance: String::new(),
            cycle_time_error: None,
            unexplained_time: None,
            form_error: None,
            calibrated_at: Vec::new(),
            interpolator: Interpolator {
                filters: 3,
                time_constants: TimeConstants::Equal(0.0255),
                contour_tolerance: 0.010,
                arc_tolerance: None,
                corner_mode: CornerMode::Paper,
                junction: Junction::Tolerance,
                exact_stop_angle: std::f64::consts::PI,
                slowing_angle: f64::INFINITY,
                arc_step: ARC_STEP,
                arc_chords: ArcChords::Whole,
                minimum_cruise_ratio: 0.0,
                block_time: 0.0,
                look_ahead: f64::INFINITY,
                planned_by: PlannedBy::Supply,
                path_smoothing: None,
                corner_smoothing: 0.0,
            },
            rapid: Rapid {
                feedrate: 200.0,
                rotary_rate: RAPID_ROTARY_RATE,
                exact_stop: false,
                time_constants: None,
                positioning_jerk: f64::INFINITY,
            },
            path_modes: PathModes::default(),
            path: PathLimits {
                acceleration: f64::INFINITY,
                jerk: f64::INFINITY,
                limits_command: false,
                centripetal_acceleration: f64::INFINITY,
            },
            axes: [Axis::default(); 3],
            rotary_axes: [RotaryAxis::default(); 3],
            work_offsets: [None; 6],
            overrides: Overrides {
                feed: 1.0,
                rapid: 1.0,
                lines: (0, u32::MAX),
                feed_by_line: BTreeMap::new(),
                rapid_by_line: BTreeMap::new(),
            },
            recorder: Recorder { clock_ratio: 1.0 },
            cycles: Cycles { peck_retract: None, peck_clearance: None, taps_out: false },
            program: Reading::default(),
            times: Times::default(),
            halts: Halts::default(),
            tools: BTreeMap::new(),
            rates: Rates { hourly: 0.0 },
        }
    }
}

/// A rotary axis without limits.
impl Default for RotaryAxis {
    fn default() -> RotaryAxis {
        RotaryAxis { velocity: f64::INFINITY }
    }
}

/// An axis without limits that follows its command exactly.
impl Default for Axis {
    fn default() -> Axis {
        Axis {
            velocity: f64::INFINITY,
            rapid: f64::INFINITY,
            acceleration: f64::INFINITY,
            jerk: f64::INFINITY,
            home: None,
            servo_lag: 0.0,
            backlash: 0.0,
            mode: None,
        }
    }
}
