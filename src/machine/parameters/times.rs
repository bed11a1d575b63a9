//! Rows of the times without motion.
//!
//! If a time is empty, the time of all other M-words applies, which is 0 by default.

use crate::machine::FunctionTimes;
use crate::machine::parameter::{
    MAX_WORDS, Parameter, WORD_BOUNDS, read_words, row, whole_list, written_words,
};

/// Bounds of the time of a machine function, s: up to an hour.
const TIME_BOUNDS_S: (f64, f64) = (0.0, 3600.0);

pub(super) const TIMES: [Parameter; 24] = [
    row!("times.start_s", "Program start", value Second TIME_BOUNDS_S [times.start] or 0.0,
        "Time from the start of the program to its first block; 0: none."),
    row!("times.dwell_excess_s", "Dwell excess", value Second (0.0, 1.0) [times.dwell_excess] or 0.0,
        "Extra time of each dwell beyond the programmed time: a control resumes only in a later cycle of its task. 0: none."),
    row!("times.tool_change_s", "Tool change", value Second TIME_BOUNDS_S [times.tool_change] or FunctionTimes::default().tool_change,
        "Time of a tool change at M6, from the stop of the spindle until the new tool is clamped. A chip-to-chip time also includes the start of the spindle and the moves to the change position."),
    row!("times.first_tool_change_s", "First tool change", optional Second TIME_BOUNDS_S [times.first_tool_change],
        "Time of the first tool change of a program, when the spindle is empty. Empty: as others."),
    row!("times.tools", "Tools with their own change time", codes 'T' Second TIME_BOUNDS_S [times.tools],
        "Seconds by tool, for example T12 = 9.0 for a heavy tool that the changer moves slowly."),
    row!("times.spindle_start_s", "Spindle start", optional Second TIME_BOUNDS_S [times.spindle.start],
        "Time of M3 and M4 from standstill, without the ramp. Empty: as other M-codes."),
    row!("times.spindle_stop_s", "Spindle stop", optional Second TIME_BOUNDS_S [times.spindle.stop],
        "Time of M5 and M19 to standstill, without the ramp. Empty: as other M-codes."),
    row!("times.spindle_s_per_1000_rpm", "Spindle ramp", value SecondPerThousandRpm (0.0, 100.0) [times.spindle.ramp] or 0.0,
        "Time for each 1000 rpm by which the speed changes. 0: none, and an S word alone does not stop the motion."),
    row!("times.spindle_exponent", "Exponent of the spindle ramp", optional Number (1.0, 4.0) [times.spindle.exponent],
        "The time of the ramp grows with this power of the speed: 1 at constant torque, 2 at constant power, up to 3 where power falls. The time to 10 000 rpm does not change. Empty: 1."),
    row!(
        "times.spindle_awaited_by",
        "M-codes that wait for the spindle",
        whole_list(
            WORD_BOUNDS,
            MAX_WORDS,
            |m| Some(written_words(&m.times.spindle_awaited_by)).filter(|words| !words.is_empty()),
            |m, v| m.times.spindle_awaited_by = read_words(v),
        ),
        "Numbers of the M-codes that wait until the spindle has its speed, on controls where M3 and M5 only start the ramp: for example [8, 1, 30]. Empty: M3 to M5 wait themselves."
    ),
    row!("times.spindle_change_s", "Wait at S words", value Second TIME_BOUNDS_S [times.spindle_change] or 0.0,
        "Time that the feed waits at an S word in a block of motion until the spindle has its speed. 0: it does not wait."),
    row!("times.spindle_at_feed_s", "Wait of the first feed move for the spindle", value Second TIME_BOUNDS_S [times.spindle_at_feed] or 0.0,
        "Time that the first feed move after a start of the spindle, or a change of its speed, waits until the spindle has its speed; rapid moves do not wait. 0: it does not wait either."),
    row!("times.spindle_at_feed_s_per_1000_rpm", "Spindle ramp that the first feed move waits for", value SecondPerThousandRpm (0.0, 100.0) [times.spindle_ramp_at_feed] or 0.0,
        "Ramp time for each 1000 rpm of a change of speed, on controls where only the first feed move waits for the spindle. Dwells and rapid moves overlap the ramp. 0: the feed move does not wait."),
    row!("times.coolant_on_s", "Coolant on", optional Second TIME_BOUNDS_S [times.coolant_on],
        "Time of M7 and M8. Empty: as other M-codes."),
    row!("times.coolant_off_s", "Coolant off", optional Second TIME_BOUNDS_S [times.coolant_off],
        "Time of M9. Empty: as other M-codes."),
    row!("times.program_stop_s", "Program stop", optional Second TIME_BOUNDS_S [times.program_stop],
        "How long the machine waits at M0 until somebody restarts it. Empty: as other M-codes."),
    row!(
        "times.optional_stop",
        "Optional stop taken",
        flag[times.takes_optional_stop],
        "The optional-stop switch is on, and the machine waits at M1; otherwise M1 takes the time of other M-codes."
    ),
    row!("times.optional_stop_s", "Optional stop", optional Second TIME_BOUNDS_S [times.optional_stop],
        "How long the machine waits at M1 with the switch on. Empty: as at M0."),
    row!("times.pallet_change_s", "Pallet change", optional Second TIME_BOUNDS_S [times.pallet_change],
        "Time of the M-codes that change the pallet. Empty: as other M-codes."),
    row!(
        "times.pallet_words",
        "M-codes that change the pallet",
        words[times.pallet_words],
        "Numbers of the M-codes that change the pallet."
    ),
    row!("times.clamp_s", "Clamping", optional Second TIME_BOUNDS_S [times.clamp],
        "Time of each M-code that clamps or unclamps an axis or the part. Empty: as other M-codes."),
    row!(
        "times.clamp_words",
        "M-codes that clamp",
        words[times.clamp_words],
        "Numbers of the M-codes that clamp and unclamp."
    ),
    row!("times.m_code_s", "Other M-codes", value Second TIME_BOUNDS_S [times.m_code] or 0.0,
        "Time of every M-code without its own time, in addition to stopping. 0: none."),
    row!("times.m_codes", "M-codes with their own time", codes 'M' Second TIME_BOUNDS_S [times.m_codes],
        "Seconds by M-code, instead of the time of its group: M8 = 3.0 for a coolant that needs 3 s. Not for tool changes."),
];
