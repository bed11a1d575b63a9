//! Rows of single axes, rotary axes and work offsets.

use crate::machine::Mode;
use crate::machine::parameter::{Parameter, finite, number};
use crate::units::Unit;

/// Rows of one axis; the compiler needs a literal index and literal keys.
macro_rules! axis {
    ($name:literal, $index:literal) => {
        [
            Parameter {
                key: concat!("axis.", $name, ".velocity_mm_min"),
                label: concat!("Velocity limit ", $name),
                doc: "Fastest the axis moves, in feed and rapid; empty: no limit.",
                access: number(Unit::MillimetrePerMinute, (1.0, 1e6), |m| finite(m.axes[$index].velocity), |m, v| {
                    m.axes[$index].velocity = v.unwrap_or(f64::INFINITY)
                }),
            },
            Parameter {
                key: concat!("axis.", $name, ".rapid_mm_min"),
                label: concat!("Rapid ", $name),
                doc: "Fastest the axis moves in rapid: a rapid along several axes is as fast as none of them exceeds its own; empty: no limit.",
                access: number(Unit::MillimetrePerMinute, (1.0, 1e6), |m| finite(m.axes[$index].rapid), |m, v| {
                    m.axes[$index].rapid = v.unwrap_or(f64::INFINITY)
                }),
            },
            Parameter {
                key: concat!("axis.", $name, ".acceleration_mm_s2"),
                label: concat!("Acceleration limit ", $name),
                doc: "Largest acceleration of the axis, on ramps and at corners; empty: no limit.",
                access: number(Unit::MillimetrePerSecond2, (1.0, 1e6), |m| finite(m.axes[$index].acceleration), |m, v| {
                    m.axes[$index].acceleration = v.unwrap_or(f64::INFINITY)
                }),
            },
            Parameter {
                key: concat!("axis.", $name, ".jerk_mm_s3"),
                label: concat!("Jerk limit ", $name),
                doc: "Largest jerk of the axis at corners; empty: no limit.",
                access: number(Unit::MillimetrePerSecond3, (1.0, 1e9), |m| finite(m.axes[$index].jerk), |m, v| {
                    m.axes[$index].jerk = v.unwrap_or(f64::INFINITY)
                }),
            },
            Parameter {
                key: concat!("axis.", $name, ".servo_lag_s"),
                label: concat!("Servo lag ", $name),
                doc: "Time by which the axis trails its command, 1/Kv; 0: not at all. Does not change the cycle time.",
                access: number(Unit::Second, (0.0, 1.0), |m| Some(m.axes[$index].servo_lag), |m, v| {
                    m.axes[$index].servo_lag = v.unwrap_or(0.0)
                }),
            },
            Parameter {
                key: concat!("axis.", $name, ".backlash_mm"),
                label: concat!("Backlash ", $name),
                doc: "Play that the axis crosses at each reversal before the table follows; 0: none.",
                access: number(Unit::Millimetre, (0.0, 5.0), |m| Some(m.axes[$index].backlash), |m, v| {
                    m.axes[$index].backlash = v.unwrap_or(0.0)
                }),
            },
            Parameter {
                key: concat!("axis.", $name, ".vibration_hz"),
                label: concat!("Vibration frequency ", $name),
                doc: "First structural mode of the axis, undamped frequency; empty: rigid.",
                access: number(Unit::Hertz, (0.5, 1000.0), |m| m.axes[$index].mode.map(|mode| mode.frequency), |m, v| {
                    let damping = m.axes[$index].mode.map_or(DAMPING, |mode| mode.damping);
                    m.axes[$index].mode = v.map(|frequency| Mode { frequency, damping })
                }),
            },
            Parameter {
                key: concat!("axis.", $name, ".vibration_damping"),
                label: concat!("Vibration damping ", $name),
                doc: "Damping ratio of the structural mode; empty: 0.03.",
                access: number(Unit::Number, (0.001, 0.9), |m| m.axes[$index].mode.map(|mode| mode.damping), |m, v| {
                    if let Some(mode) = &mut m.axes[$index].mode {
                        mode.damping = v.unwrap_or(DAMPING)
                    }
                }),
            },
            Parameter {
                key: concat!("axis.", $name, ".home_mm"),
                label: concat!("Reference point ", $name),
                doc: "Where G28 and G53 zero lie in the program's coordinates; empty: unknown, such moves are not timed.",
                access: number(Unit::Millimetre, (-1e5, 1e5), |m| m.axes[$index].home, |m, v| m.axes[$index].home = v),
            },
        ]
    };
}

/// The row of one rotary axis.
macro_rules! rotary_axis {
    ($name:literal, $index:literal) => {
        [Parameter {
            key: concat!("axis.", $name, ".velocity_deg_min"),
            label: concat!("Velocity limit ", $name),
            doc: "Fastest the rotary axis turns, in feed and rapid; empty: no limit.",
            access: number(
                Unit::DegreePerMinute,
                (1.0, 1e7),
                |m| finite(m.rotary_axes[$index].velocity),
                |m, v| m.rotary_axes[$index].velocity = v.unwrap_or(f64::INFINITY),
            ),
        }]
    };
}

/// Rows of one work offset.
macro_rules! work_offset {
    ($name:literal, $index:literal) => {
        [
            work_offset!($name, $index, "x", 0),
            work_offset!($name, $index, "y", 1),
            work_offset!($name, $index, "z", 2),
        ]
    };
    ($name:literal, $index:literal, $letter:literal, $axis:literal) => {
        Parameter {
            key: concat!("work_offsets.", $name, ".", $letter, "_mm"),
            label: concat!($name, " ", $letter),
            doc: "Machine coordinate of the zero point; empty: zero. Matters to moves between zero points and to G53 and G28.",
            access: number(Unit::Millimetre, (-1e5, 1e5), |m| m.work_offsets[$index].map(|point| point[$axis]), |m, v| {
                if let Some(value) = v {
                    m.work_offsets[$index].get_or_insert_default()[$axis] = value
                }
            }),
        }
    };
}

/// Damping ratio of a structural mode for which none is given: typical of machine tools.
const DAMPING: f64 = 0.03;

/// The rows of all axes.
pub(super) fn axes() -> impl Iterator<Item = Parameter> {
    let axes = axis!("x", 0).into_iter().chain(axis!("y", 1)).chain(axis!("z", 2));
    let rotary_axes =
        rotary_axis!("a", 0).into_iter().chain(rotary_axis!("b", 1)).chain(rotary_axis!("c", 2));
    let first =
        work_offset!("G54", 0).into_iter().chain(work_offset!("G55", 1)).chain(work_offset!("G56", 2));
    let last = work_offset!("G57", 3).into_iter().chain(work_offset!("G58", 4)).chain(work_offset!("G59", 5));
    axes.chain(rotary_axes).chain(first).chain(last)
}
