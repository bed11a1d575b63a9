//! Rows of linear axes, rotary axes and work offsets.

use crate::machine::StructuralMode;
use crate::machine::parameter::{Parameter, row};

/// The rows of one axis; the compiler needs a literal index and literal keys.
macro_rules! axis {
    ($name:literal, $index:literal) => {
        [
            row!(concat!("axis.", $name, ".velocity_mm_min"), concat!("Velocity limit ", $name), limit MillimetrePerMinute (1.0, 1e6) [axes[$index].velocity],
                "Highest velocity of the axis, in feed and rapid. Empty: no limit."),
            row!(concat!("axis.", $name, ".rapid_mm_min"), concat!("Rapid ", $name), limit MillimetrePerMinute (1.0, 1e6) [axes[$index].rapid],
                "Highest velocity of the axis in rapid. A rapid along several axes runs as fast as all their limits allow. Empty: no limit."),
            row!(concat!("axis.", $name, ".acceleration_mm_s2"), concat!("Acceleration limit ", $name), limit MillimetrePerSecond2 (1.0, 1e6) [axes[$index].acceleration],
                "Largest acceleration of the axis, on ramps and at corners; empty: no limit."),
            row!(concat!("axis.", $name, ".jerk_mm_s3"), concat!("Jerk limit ", $name), limit MillimetrePerSecond3 (1.0, 1e9) [axes[$index].jerk],
                "Largest jerk of the axis at corners; of a planner without filters, on ramps, as in TinyG. Empty: no limit."),
            row!(concat!("axis.", $name, ".step_mm"), concat!("Step ", $name), value Millimetre (0.0, 1.0) [axes[$index].step] or 0.0,
                "Distance of one step of a stepping motor. The control plans the ends of blocks at whole steps, so short lines and chords turn by other angles than the program says; grbl: 1/$100 to 1/$102. 0: no steps."),
            row!(concat!("axis.", $name, ".servo_lag_s"), concat!("Servo lag ", $name), value Second (0.0, 1.0) [axes[$index].servo_lag] or 0.0,
                "Time by which the axis lags its command, 1/Kv. 0: no lag. Does not change the cycle time."),
            row!(concat!("axis.", $name, ".backlash_mm"), concat!("Backlash ", $name), value Millimetre (0.0, 5.0) [axes[$index].backlash] or 0.0,
                "Play that the axis crosses at each reversal before the table follows. 0: none."),
            row!(concat!("axis.", $name, ".backlash_compensation_mm"), concat!("Backlash compensation ", $name), value Millimetre (0.0, 5.0) [axes[$index].backlash_compensation] or 0.0,
                "Compensation of backlash as an encoder at the motor shows it: after each reversal the motor is ahead of the programmed position by half of it. 0: none, or a scale at the table is recorded."),
            row!(concat!("axis.", $name, ".vibration_hz"), concat!("Vibration frequency ", $name), Hertz (0.5, 1000.0),
                |m| m.axes[$index].mode.map(|mode| mode.frequency),
                |m, v| {
                    let damping = m.axes[$index].mode.map_or(DEFAULT_DAMPING, |mode| mode.damping);
                    m.axes[$index].mode = v.map(|frequency| StructuralMode { frequency, damping })
                },
                "First structural mode of the axis, undamped frequency; empty: rigid."),
            row!(concat!("axis.", $name, ".vibration_damping"), concat!("Vibration damping ", $name), Number (0.001, 0.9),
                |m| m.axes[$index].mode.map(|mode| mode.damping),
                |m, v| {
                    if let Some(mode) = &mut m.axes[$index].mode {
                        mode.damping = v.unwrap_or(DEFAULT_DAMPING)
                    }
                },
                "Damping ratio of the structural mode; empty: 0.03."),
            row!(concat!("axis.", $name, ".home_mm"), concat!("Reference point ", $name), optional Millimetre (-1e5, 1e5) [axes[$index].home],
                "Position of G28 and of the machine zero (G53) in program coordinates. Empty: unknown; Truefeed does not time moves to them."),
        ]
    };
}

/// The row of one rotary axis.
macro_rules! rotary_axis {
    ($name:literal, $index:literal) => {
        [row!(concat!("axis.", $name, ".velocity_deg_min"), concat!("Velocity limit ", $name), limit DegreePerMinute (1.0, 1e7) [rotary_axes[$index].velocity],
            "Highest rate of the rotary axis, in feed and rapid. Empty: no limit.")]
    };
}

/// The rows of one work offset.
macro_rules! work_offset {
    ($name:literal, $index:literal) => {
        [
            work_offset!($name, $index, "x", 0),
            work_offset!($name, $index, "y", 1),
            work_offset!($name, $index, "z", 2),
        ]
    };
    ($name:literal, $index:literal, $letter:literal, $axis:literal) => {
        row!(
            concat!("work_offsets.", $name, ".", $letter, "_mm"),
            concat!($name, " ", $letter),
            Millimetre(-1e5, 1e5),
            |m| m.work_offsets[$index].map(|point| point[$axis]),
            |m, v| {
                if let Some(value) = v {
                    m.work_offsets[$index].get_or_insert_default()[$axis] = value
                }
            },
            "Machine coordinate of the zero point. Empty: 0. Affects moves between zero points, G53 and G28."
        )
    };
}

/// Default damping ratio of a structural mode: typical of machine tools.
const DEFAULT_DAMPING: f64 = 0.03;

/// Returns the rows of all axes.
pub(super) fn axes() -> impl Iterator<Item = Parameter> {
    let axes = axis!("x", 0).into_iter().chain(axis!("y", 1)).chain(axis!("z", 2));
    let rotary_axes =
        rotary_axis!("a", 0).into_iter().chain(rotary_axis!("b", 1)).chain(rotary_axis!("c", 2));
    let first =
        work_offset!("G54", 0).into_iter().chain(work_offset!("G55", 1)).chain(work_offset!("G56", 2));
    let last = work_offset!("G57", 3).into_iter().chain(work_offset!("G58", 4)).chain(work_offset!("G59", 5));
    axes.chain(rotary_axes).chain(first).chain(last)
}
