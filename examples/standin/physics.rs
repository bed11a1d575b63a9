//! What the stand-in machine really does. Each field is neutral unless an effect is concealed in it.
//!
//! Units: mm, s, rad; infinite limits do not act.

use std::f64::consts::PI;

/// Seconds a sample of the kernels lasts.
pub const TICK: f64 = 0.001;

/// The whole of a machine's physics but its recorder.
#[derive(Clone, Debug)]
pub struct Physics {
    /// Time constants of the filters in series, s.
    pub boxes: Vec<f64>,
    /// Contour tolerance, mm.
    pub tolerance: f64,
    /// Rapid feed along the path, mm/s, and what a tool change takes, s.
    pub rapid: f64,
    pub tool_change: f64,
    /// Limits: per axis and along the path, mm/s, mm/s², mm/s³.
    pub axis_velocity: [f64; 3],
    pub axis_acceleration: [f64; 3],
    pub path_acceleration: f64,
    pub centripetal: f64,
    pub jerk: f64,
    /// The largest step of one axis' velocity at a corner, mm/s.
    pub axis_step: f64,
    /// Corners that turn by more than this are exact stops, rad.
    pub exact_stop: f64,
    /// Wait in position at the end of every rapid, s; 0 leaves rapids blended.
    pub in_position: f64,
    /// The least time of a block, s, and the number of blocks seen ahead.
    pub block_time: f64,
    pub look_ahead: f64,
    /// Corners that rounding by so much removes are taken at full feed, mm.
    pub smoothing: f64,
    /// Feed override: ratio from one line to another.
    pub feed_override: (f64, u32, u32),
    pub rapid_override: f64,
    /// A stop in the middle of a line, and a wait at one: line and seconds.
    pub hold: Option<(u32, f64)>,
    pub wait: Option<(u32, f64)>,
    /// Outside every library: feed modulation (depth, Hz), a slow place (axis 0 from, to in mm, ratio),
    /// and a feed limit that falls along axis 0 (mm/s at 0, mm/s per mm).
    pub modulation: Option<(f64, f64)>,
    pub zone: Option<(f64, f64, f64)>,
    pub falling: Option<(f64, f64)>,
    pub drive: Drive,
    /// Seconds of the recorder per second of the machine.
    pub clock: f64,
}

/// What the axes do with the command.
#[derive(Clone, Debug, Default)]
pub struct Drive {
    /// First-order lag, s, and the share of it that feed-forward takes away.
    pub lag: f64,
    pub feed_forward: f64,
    /// Play of one axis, mm.
    pub backlash: Option<(usize, f64)>,
    /// A mode of one axis: Hz and damping ratio.
    pub mode: Option<(usize, f64, f64)>,
    /// Coulomb friction: after a reversal the axis sticks for so many mm, and catches up in so many s.
    pub friction: Option<(f64, f64)>,
}

impl Physics {
    /// Nothing but the filters, the tolerance, the rapid feed and the tool change.
    pub fn base(filters: usize, time_constant: f64, tolerance: f64) -> Physics {
        Physics {
            boxes: vec![time_constant; filters],
            tolerance,
            rapid: 200.0,
            tool_change: 4.0,
            axis_velocity: [f64::INFINITY; 3],
            axis_acceleration: [f64::INFINITY; 3],
            path_acceleration: f64::INFINITY,
            centripetal: f64::INFINITY,
            jerk: f64::INFINITY,
            axis_step: f64::INFINITY,
            exact_stop: 2.0 * PI,
            in_position: 0.0,
            block_time: 0.0,
            look_ahead: f64::INFINITY,
            smoothing: 0.0,
            feed_override: (1.0, 0, 0),
            rapid_override: 1.0,
            hold: None,
            wait: None,
            modulation: None,
            zone: None,
            falling: None,
            drive: Drive::default(),
            clock: 1.0,
        }
    }
}

/// What a kernel commands: a position every [`TICK`], the line it belongs to, and each line's seconds.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    pub position: Vec<[f64; 3]>,
    pub line: Vec<u32>,
    pub line_seconds: std::collections::BTreeMap<u32, f64>,
    pub cycle_time: f64,
}
