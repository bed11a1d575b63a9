//! The machine: every parameter of control and axes that the simulation reads.
//!
//! Each physical effect is a parameter with a neutral value at which it has no effect: infinity for a limit,
//! 1 for a ratio, 0 for a time. The simulation reads only these fields, and the diagnosis fits them. Derived
//! quantities are computed where they are needed, never stored.
//!
//! Source of the interpolator's fields: Ward, Sencer, Jones and Ozturk 2021, Sect. 2 and 3.

mod calibrated_on;
mod halts;
mod handle;
mod junction;
mod parameter;
mod parameters;
mod planner;
mod presets;
mod block_supply;
mod times;
mod tolerance;
mod keyword;

use crate::machine::keyword::keyword_of;
use std::collections::BTreeMap;

pub use block_supply::CornerPlanning;
pub use calibrated_on::{CalibratedOn, Extent, MAX_RAMP_MISFIT};
pub use halts::{Halts, InPosition};
pub use handle::Handle;
pub use junction::Junction;
pub use parameter::{Access, Parameter};
pub use parameters::{PARAMETERS, parameter};
pub use planner::{
    CHORD_ERROR_RATIOS, FREE_BLEND_MM, GRBL_STEP_SEGMENT_S, GRBL_STEP_TIMER_HZ, KLIPPER_MIN_CRUISE_RATIO,
    PLANNER_FILTER_S, Planner,
};
pub use presets::{Preset, presets};
pub use times::{FunctionTimes, MCodeGroup, SpindleDirection, SpindleState, SpindleTimes};
pub use tolerance::{
    ToleranceError, USUAL_TOLERANCES_MM, checked_tolerance, deviation_label, tolerance_from_text,
    tolerance_label, tolerance_label_in,
};

/// Names of the linear axes, in the order of the coordinates of a point.
pub const AXES: [char; 3] = ['X', 'Y', 'Z'];

/// A machine tool with its control.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Name shown to people.
    pub name: String,
    /// Origin of the numbers; may be empty.
    pub provenance: String,
    /// Relative error of the cycle time at the calibration; `None` if unknown.
    pub cycle_time_error: Option<f64>,
    /// Sum of the sizes of the unexplained times of all regions after the calibration, as a part of the
    /// recorded time.
    pub unexplained_time: Option<f64>,
    /// RMS distance of recorded from simulated positions at equal times after the calibration, mm.
    pub form_error: Option<f64>,
    /// Geometric mean of that distance over short parts of the runs, mm.
    pub typical_form_error: Option<f64>,
    /// Contour tolerances at which `cycle_time_error` was measured, mm; if empty, the interpolator's.
    pub calibrated_at: Vec<f64>,
    /// Programs and errors of the calibration.
    pub calibrated_on: CalibratedOn,
    /// Filters, tolerance and block handling of the control.
    pub interpolator: Interpolator,
    /// Settings of rapid moves.
    pub rapid: RapidMoves,
    /// Tolerances that a program selects by a level.
    pub path_modes: PathModes,
    /// Limits along the path.
    pub path: PathLimits,
    /// Axes X, Y, Z.
    pub axes: [Axis; 3],
    /// Rotary axes A, B, C.
    pub rotary_axes: [RotaryAxis; 3],
    /// Machine coordinates of the zero points of G54 to G59, mm; neutral `None`: zero, and unknown.
    pub work_offsets: [Option<[f64; 3]>; 6],
    /// Override switches.
    pub overrides: Overrides,
    /// Recorder of the machine's runs.
    pub recorder: Recorder,
    /// Settings that cycles leave to the control.
    pub cycles: CycleSettings,
    /// Interpretation of programs.
    pub program: ProgramReading,
    /// Times without motion.
    pub times: FunctionTimes,
    /// Halts that the program does not request.
    pub halts: Halts,
    /// Tools by number; none when neutral.
    pub tools: BTreeMap<u32, Tool>,
    /// Costs.
    pub rates: Rates,
}

/// Filters, tolerance and block handling of the control.
#[derive(Clone, Debug, PartialEq)]
pub struct Interpolator {
    /// Number of first-order filters in series, 1 to 4.
    pub filters: usize,
    /// Time constants.
    pub time_constants: TimeConstants,
    /// Contour tolerance at corners, mm.
    pub contour_tolerance: f64,
    /// Contour tolerance along arcs, mm; neutral `None`: that of corners.
    pub arc_tolerance: Option<f64>,
    /// Places at which the tolerance is kept.
    pub corner_mode: CornerMode,
    /// Junction law; neutral the tolerance alone.
    pub junction: Junction,
    /// `true` if short blocks at a corner with a junction deviation are chords of an arc, and the corner has at most the
    /// acceleration of the block after it; neutral `false`.
    pub short_blocks_are_chords: bool,
    /// Turn of the path beyond which the motion stops, rad; neutral π.
    pub exact_stop_angle: f64,
    /// Corners are slowed by the fourth power of their turn, down to a full stop at this turn, rad; neutral
    /// infinite.
    pub slowing_angle: f64,
    /// Turn of a chord of an arc, rad: a command held for a corner on an arc ends with the first chord.
    /// Neutral at 20π or more: an arc is one block. Default 1°.
    pub arc_step: f64,
    /// Chords into which an arc is cut before planning; none when neutral.
    pub arc_chords: ArcChords,
    /// Largest feed override for which the control plans blends, as a ratio.
    pub max_override: f64,
    /// Least share of cruising in a move that speeds up and slows down, 0 to 1; neutral 0.
    pub minimum_cruise_ratio: f64,
    /// `true` if ramps of constant acceleration take the same time on a curve of fifth order; neutral `false`.
    pub quintic_ramps: bool,
    /// Block processing time: the shortest time of a block, s; neutral 0.
    pub block_time: f64,
    /// Look-ahead, blocks; neutral infinite.
    pub look_ahead: f64,
    /// Time for which the step timer holds one feedrate within a block, s; neutral 0: it follows every ramp.
    pub step_segment: f64,
    /// Frequency of the step timer, which takes one cycle more for each tick, Hz; neutral infinite: it is exact.
    pub step_timer: f64,
    /// Feedrate by which corners are planned if block processing limits the feedrate.
    pub planned_by: CornerPlanning,
    /// Largest distance of points from a line that replaces the lines between them, mm; 0 merges none;
    /// neutral `None`: as the program sets it under the junction law of LinuxCNC, else 0.
    pub path_smoothing: Option<f64>,
    /// Distance within which a curve must pass a corner between lines for the corner not to be slowed, mm;
    /// neutral 0.
    pub corner_smoothing: f64,
}

/// The time constants of the filters.
#[derive(Clone, Debug, PartialEq)]
pub enum TimeConstants {
    /// All equal, s.
    Equal(f64),
    /// All equal, from the jerk limit J (mm/s³) and the feedrate F: T1 = √(F/J), Eq. 8.
    FromJerk(f64),
    /// One for each filter, s.
    Unequal(Vec<f64>),
}

/// The chords into which a control cuts an arc before planning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ArcChords {
    /// None: an arc is one block.
    Whole,
    /// The longest chords within this distance of the arc, mm.
    Within(f64),
    /// Chords of at least this length along the arc, mm.
    Long(f64),
}

/// The places at which the contour tolerance is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CornerMode {
    /// At each corner as if it were isolated, as published.
    Paper,
    /// Along the whole filtered path.
    Guaranteed,
}

impl Interpolator {
    /// Returns the filter delay at a feedrate (mm/s), s: the sum of the time constants.
    pub fn filter_delay(&self, feedrate: f64) -> f64 {
        match &self.time_constants {
            TimeConstants::Equal(constant) => self.filters as f64 * constant,
            TimeConstants::FromJerk(jerk) => self.filters as f64 * (feedrate / jerk).sqrt(),
            TimeConstants::Unequal(constants) => constants.iter().sum(),
        }
    }

    /// Returns the turn at which corners become full stops, rad; π if none do.
    pub fn stopping_angle(&self) -> f64 {
        self.exact_stop_angle.min(self.slowing_angle)
    }
}

impl CornerMode {
    /// All modes with their keywords.
    pub const WORDS: [(&'static str, CornerMode); 2] =
        [("paper", CornerMode::Paper), ("guaranteed", CornerMode::Guaranteed)];

    /// Returns the keyword.
    pub fn word(self) -> &'static str {
        keyword_of(&CornerMode::WORDS, self)
    }
}

/// Settings of rapid moves.
#[derive(Clone, Debug, PartialEq)]
pub struct RapidMoves {
    /// Feedrate along the path, mm/s; neutral infinite if each axis has a rapid feedrate.
    pub feedrate: f64,
    /// Rate at which a rotary axis turns in rapid, rad/s.
    pub rotary_rate: f64,
    /// Rapids run at the programmed feedrate where that is lower, as feed moves do, and under the feed override; neutral
    /// `false`. So do Klipper (gcode_move.py) and Marlin (G0_G1.cpp), whose G0 is G1.
    pub at_feedrate: bool,
    /// Full stop at both ends of a chain of rapid moves; neutral `false`: blended like feed moves.
    pub exact_stop: bool,
    /// Time constants of the filters during rapid moves; neutral `None`: those of feed moves.
    pub time_constants: Option<TimeConstants>,
    /// Jerk of the axis that moves farthest, mm/s³, if each rapid runs from rest to rest with ramps that grow
    /// with the speed it reaches; neutral infinite: rapids have the ramps of other moves.
    pub positioning_jerk: f64,
}

/// Tolerances of the control's levels, mm; neutral `None`: unknown, so that the machine's contour tolerance
/// applies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathModes {
    /// Of G187 P1.
    pub rough: Option<f64>,
    /// Of G187 P2.
    pub medium: Option<f64>,
    /// Of G187 P3.
    pub finish: Option<f64>,
    /// Of G5.1 R1; levels between this and R10 are interpolated.
    pub level_1: Option<f64>,
    /// Of G5.1 R10.
    pub level_10: Option<f64>,
    /// Tolerance that replaces every tolerance of a program.
    pub tolerance_override: Option<f64>,
}

/// Limits along the path, whatever its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathLimits {
    /// Velocity along the path, of feeds and rapids, mm/s; neutral infinite.
    pub velocity: f64,
    /// Acceleration along the path, mm/s²; neutral infinite.
    pub acceleration: f64,
    /// Jerk along the path of each change of the command, mm/s³; neutral infinite.
    pub jerk: f64,
    /// `true` if the acceleration limits of path and axes shape the command before the filters; neutral
    /// `false`: the machine runs the filtered motion more slowly where it exceeds a limit.
    pub limits_command: bool,
    /// Acceleration towards the centre of an arc, mm/s²; neutral infinite.
    pub centripetal_acceleration: f64,
}

/// One axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Velocity limit, mm/s; neutral infinite.
    pub velocity: f64,
    /// Rapid feedrate, mm/s; neutral infinite.
    pub rapid: f64,
    /// Largest acceleration, mm/s²; neutral infinite.
    pub acceleration: f64,
    /// Largest jerk at a corner and, without filters, on ramps, mm/s³; neutral infinite.
    pub jerk: f64,
    /// Distance of one step, at multiples of which the control plans the ends of blocks, mm; neutral 0.
    pub step: f64,
    /// Reference position in the program's coordinates, mm; `None` if unknown.
    pub home: Option<f64>,
    /// Time constant of the position loop, s; neutral 0.
    pub servo_lag: f64,
    /// Backlash between drive and table, mm; neutral 0.
    pub backlash: f64,
    /// Compensation of backlash that recorded positions contain, mm; neutral 0.
    pub backlash_compensation: f64,
    /// First structural mode; neutral `None`.
    pub mode: Option<StructuralMode>,
}

impl Axis {
    /// Returns `true` if the axis does not follow its command exactly.
    pub fn has_drive(&self) -> bool {
        self.without_drive() != *self
    }

    /// Returns the axis that follows its command exactly within the same limits.
    pub fn without_drive(self) -> Axis {
        Axis { servo_lag: 0.0, backlash: 0.0, backlash_compensation: 0.0, mode: None, ..self }
    }
}

/// One rotary axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotaryAxis {
    /// Velocity limit, rad/s; neutral infinite.
    pub velocity: f64,
}

/// Rapid rate of rotary axes if the machine gives none, rad/s: 9000 °/min, 25 rev/min, usual for tables and
/// heads of machining centres.
const DEFAULT_ROTARY_RATE_RAD_S: f64 = 50.0 * std::f64::consts::PI / 60.0;

/// Default turn of a chord, rad: 1°.
pub(crate) const DEFAULT_ARC_STEP_RAD: f64 = std::f64::consts::PI / 180.0;

/// A lightly damped oscillation between drive and tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StructuralMode {
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
    /// First and last line of the program to which the override of feed moves applies; neutral all.
    pub lines: (u32, u32),
    /// Distances along the path (mm) to which the override of feed moves is limited in addition; neutral all.
    /// An operator may turn the switch in the middle of a line.
    pub span: (f64, f64),
    /// Ratios of feed moves from each line of the program to the next entry; none when neutral.
    pub feed_by_line: BTreeMap<u32, f64>,
    /// Ratios of rapid moves from each line of the program to the next entry; none when neutral.
    pub rapid_by_line: BTreeMap<u32, f64>,
}

impl Overrides {
    /// Returns the override of feed moves on a line of the program.
    pub fn of_feed(&self, line: u32) -> f64 {
        self.of_feed_within(line) * Overrides::at(&self.feed_by_line, line)
    }

    /// Returns the override of feed moves on a line within `span`, which depends only on `lines` and `feed`.
    pub fn of_feed_within(&self, line: u32) -> f64 {
        if self.lines.0 <= line && line <= self.lines.1 { self.feed } else { 1.0 }
    }

    /// Returns the override of rapid moves on a line of the program.
    pub fn of_rapid(&self, line: u32) -> f64 {
        self.rapid * Overrides::at(&self.rapid_by_line, line)
    }

    /// Returns `true` if all lines have one override of feed moves.
    pub fn is_even(&self) -> bool {
        self.lines == (0, u32::MAX) && self.feed_by_line.is_empty()
    }

    /// Returns `true` if the override of feed moves begins or ends along the path.
    pub fn has_span(&self) -> bool {
        self.feed != 1.0 && self.span != Overrides::WHOLE_PATH_BOUNDS_MM
    }

    /// Span of an override that applies to the whole path.
    pub const WHOLE_PATH_BOUNDS_MM: (f64, f64) = (0.0, f64::INFINITY);

    fn at(by_line: &BTreeMap<u32, f64>, line: u32) -> f64 {
        if by_line.is_empty() {
            return 1.0;
        }
        by_line.range(..=line).next_back().map_or(1.0, |(_, ratio)| *ratio)
    }
}

/// The recorder of the machine's runs; it does not change the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recorder {
    /// Time on the recorder's clock over true time; neutral 1.
    pub clock_ratio: f64,
}

/// Settings that cycles leave to the control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleSettings {
    /// Retract of chip breaking (G73) between pecks, mm; `None`: as usual for the dialect.
    pub peck_retract: Option<f64>,
    /// Clearance above the last depth at which pecking (G83) feeds again, mm; `None`: as usual for the
    /// dialect.
    pub peck_clearance: Option<f64>,
    /// `true` if tapping in pecks (Q of G84) returns to the reference height between them; neutral `false`:
    /// it retracts as in chip breaking.
    pub taps_out: bool,
}

/// Interpretation of programs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProgramReading {
    /// Least input increment: length of one unit of a number without a decimal point, mm; in inch programs a
    /// unit is a tenth of this number in inches. Neutral `None`: such a number is a length as written.
    pub increment: Option<f64>,
}

/// A tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tool {
    /// Diameter of the circle that the tool cuts, mm.
    pub diameter: f64,
}

/// Costs of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// Price of an hour of machine time, in the user's currency.
    pub hourly: f64,
}

impl Machine {
    /// Returns the rapid feedrate r of a move of which axis k takes the part u_k, mm/s: r = min(r_path, min_k
    /// r_k / |u_k|), limited by the path and by each axis.
    pub fn rapid_feedrate(&self, shares: [f64; 3]) -> f64 {
        let axes = self.axes.iter().zip(shares).map(|(axis, share)| axis.rapid / share.abs());
        axes.fold(self.rapid.feedrate, f64::min)
    }

    /// Returns the ratio of the rapid feedrate at a feed override (a ratio) to that without it. It is 1 on controls that
    /// override rapids by a separate switch. On those that run rapids at the programmed feedrate it is the override. Klipper is
    /// one, but if its machine file does not say so, rapids run at a rate that is usually the limit of the machine, and no
    /// override makes them faster.
    pub fn rapid_ratio_at(&self, feed_override: f64) -> f64 {
        match self.interpolator.junction {
            _ if self.rapid.at_feedrate => feed_override,
            Junction::SquareCorner(_) => feed_override.min(1.0),
            _ => 1.0,
        }
    }

    /// Returns the machine without the errors of its calibration, as the basis for values with another
    /// `provenance`.
    pub fn to_be_changed(&self, provenance: String) -> Machine {
        Machine {
            provenance,
            cycle_time_error: None,
            unexplained_time: None,
            form_error: None,
            typical_form_error: None,
            calibrated_at: Vec::new(),
            calibrated_on: CalibratedOn::default(),
            ..self.clone()
        }
    }

    /// Returns the largest rapid feedrate in any direction, mm/s: if axes have rapid feedrates, the
    /// feedrate of a move on which all axes reach theirs.
    pub fn fastest_rapid(&self) -> f64 {
        let squares = self.axes.iter().map(|axis| axis.rapid * axis.rapid);
        self.rapid.feedrate.min(squares.sum::<f64>().sqrt())
    }

    /// Returns `true` if each axis has a rapid feedrate.
    pub fn has_rapids_of_axes(&self) -> bool {
        self.axes.iter().all(|axis| axis.rapid.is_finite())
    }

    /// Returns the contour tolerances at which the error of the cycle time is known, mm.
    pub fn tolerances_of_error(&self) -> &[f64] {
        match self.calibrated_at.as_slice() {
            [] => std::slice::from_ref(&self.interpolator.contour_tolerance),
            named => named,
        }
    }

    /// Returns `true` if acceleration limits shape the command before any filter: junction laws of
    /// acceleration plan their ramps by themselves.
    pub fn limits_command(&self) -> bool {
        self.path.limits_command || self.interpolator.junction != Junction::Tolerance
    }

    /// Returns `true` if ramps have a limited jerk.
    pub fn limits_jerk(&self) -> bool {
        self.path.jerk.is_finite() || self.limits_jerk_of_axes()
    }

    /// Returns `true` if the jerk limits of axes shape ramps: in a planner without filters whose corners have a feedrate.
    pub fn limits_jerk_of_axes(&self) -> bool {
        self.axes.iter().any(|axis| axis.jerk.is_finite())
            && !self.has_filters()
            && !self.interpolator.junction.blends_in_time()
    }
}

/// A machine without any optional effect; the five numbers that a machine file must give come from the
/// first preset.
impl Default for Machine {
    fn default() -> Machine {
        Machine {
            name: "Machining centre".to_string(),
            provenance: String::new(),
            cycle_time_error: None,
            unexplained_time: None,
            form_error: None,
            typical_form_error: None,
            calibrated_at: Vec::new(),
            calibrated_on: CalibratedOn::default(),
            interpolator: Interpolator {
                filters: 3,
                time_constants: TimeConstants::Equal(0.0255),
                contour_tolerance: 0.010,
                arc_tolerance: None,
                corner_mode: CornerMode::Paper,
                junction: Junction::Tolerance,
                exact_stop_angle: std::f64::consts::PI,
                slowing_angle: f64::INFINITY,
                arc_step: DEFAULT_ARC_STEP_RAD,
                arc_chords: ArcChords::Whole,
                max_override: 1.0,
                minimum_cruise_ratio: 0.0,
                short_blocks_are_chords: false,
                quintic_ramps: false,
                block_time: 0.0,
                look_ahead: f64::INFINITY,
                step_segment: 0.0,
                step_timer: f64::INFINITY,
                planned_by: CornerPlanning::Supply,
                path_smoothing: None,
                corner_smoothing: 0.0,
            },
            rapid: RapidMoves {
                feedrate: 200.0,
                rotary_rate: DEFAULT_ROTARY_RATE_RAD_S,
                at_feedrate: false,
                exact_stop: false,
                time_constants: None,
                positioning_jerk: f64::INFINITY,
            },
            path_modes: PathModes::default(),
            path: PathLimits {
                velocity: f64::INFINITY,
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
                span: Overrides::WHOLE_PATH_BOUNDS_MM,
                feed_by_line: BTreeMap::new(),
                rapid_by_line: BTreeMap::new(),
            },
            recorder: Recorder { clock_ratio: 1.0 },
            cycles: CycleSettings { peck_retract: None, peck_clearance: None, taps_out: false },
            program: ProgramReading::default(),
            times: FunctionTimes::default(),
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
            backlash_compensation: 0.0,
            step: 0.0,
            mode: None,
        }
    }
}
