//! Rows of a calibration: its programs and its errors.

use crate::machine::parameter::{
    Parameter, TOLERANCE_BOUNDS_MM, WORD_BOUNDS, list, read_words, row, whole_list, written_words,
};
use crate::units::Unit;

/// Bounds of the number of an axis, X as 1.
const AXIS_BOUNDS: (f64, f64) = (1.0, 3.0);

/// Returns the set of axes with these numbers.
fn axes_of(numbers: Vec<f64>) -> [bool; 3] {
    [1.0, 2.0, 3.0].map(|axis| numbers.contains(&axis))
}

/// Returns the numbers of the axes in a set, X as 1; `None` if it is empty.
fn numbers_of(axes: [bool; 3]) -> Option<Vec<f64>> {
    let numbers = axes.iter().zip(1u8..).filter(|(is_meant, _)| **is_meant);
    Some(numbers.map(|(_, axis)| f64::from(axis)).collect()).filter(|all: &Vec<f64>| !all.is_empty())
}

/// The rows, in the order of forms and files; an edit of the motion clears them.
pub const CALIBRATED: [Parameter; 23] = [
    row!("calibration.cycle_time_error_percent", "Error of the cycle time", optional Percent (0.0, 100.0) [cycle_time_error],
        "By how much the cycle time was off when these numbers were calibrated; the uncertainty of a quote. Empty: unknown. Editing the motion empties it."),
    row!("calibration.unexplained_percent", "Time left unexplained", optional Percent (0.0, 1000.0) [unexplained_time],
        "Lost time that the calibration left unexplained, added up place by place without cancelling. A diagnosis treats it as the error of the model. Empty: unknown."),
    row!("calibration.form_error_mm", "Error of the form", optional Millimetre (0.0, 1000.0) [form_error],
        "Root mean square distance between recorded and simulated positions at equal times, at the calibration. Empty: unknown."),
    row!("calibration.typical_form_error_mm", "Typical error of the form", optional Millimetre (0.0, 1000.0) [typical_form_error],
        "Geometric mean of the same distance over short parts of the run, at the calibration: unlike the root mean square, a few places where the form is far off do not raise it. Empty: unknown."),
    row!("calibration.range_percent", "Range on other programs", optional Percent (0.0, 100.0) [calibrated_on.range],
        "On nine in ten other programs, the time of the motion is off by at most this much, if they ask for nothing that the calibration did not see. Empty: unknown."),
    row!("calibration.ramp_misfit_percent", "Misfit of ramps", optional Percent (0.0, 1000.0) [calibrated_on.ramp_misfit],
        "By how much the acceleration within ramps was off when these numbers were calibrated, half of it more and half less. Above 7.5 % the machine ramps by a law that this file does not have, and the time of other programs is far less certain. Empty: unknown."),
    row!("calibration.turns_deg", "Corners calibrated on", extent Degree (0.0, 180.0) [calibrated_on.turns],
        "Smallest and largest turn of a corner in the calibrating runs. Other corners make a quote less certain."),
    row!("calibration.radii_mm", "Arcs calibrated on", extent Millimetre (0.0, 1e6) [calibrated_on.radii],
        "Smallest and largest radius of an arc in the calibrating runs. Other arcs make a quote less certain."),
    row!("calibration.blocks_mm", "Blocks calibrated on", extent Millimetre (0.0, 1e6) [calibrated_on.blocks],
        "Lengths of the shortest and the longest straight feed block in the calibrating runs. Shorter blocks make a quote less certain."),
    row!("calibration.feeds_mm_min", "Feedrates calibrated on", extent MillimetrePerMinute (0.0, 1e6) [calibrated_on.feedrates],
        "Lowest and highest programmed feedrate in the calibrating runs. Higher feedrates make a quote less certain."),
    row!("calibration.rapids_mm", "Rapids calibrated on", axes Millimetre (0.0, 1e6) [calibrated_on.rapids],
        "Longest travel of X, Y and Z in one rapid of the calibrating runs. Longer rapids make a quote less certain."),
    row!("calibration.velocities_mm_min", "Velocities calibrated on", axes MillimetrePerMinute (0.0, 1e6) [calibrated_on.velocities],
        "Highest velocity of X, Y and Z in the calibrating runs. Faster moves make a quote less certain."),
    row!(
        "calibration.travels_mm",
        "Travels calibrated on",
        list(
            Unit::Millimetre,
            (0.0, 1e12),
            4000,
            |m| Some(m.calibrated_on.travels.concat()).filter(|list| !list.is_empty()),
            |m, v| m.calibrated_on.travels = v.as_chunks().0.to_vec(),
        ),
        "How far each program it was calibrated on travels: along the path, in X, in Y and in Z, one program after another. On a program that travels otherwise, a diagnosis ignores differences within the range of this file."
    ),
    row!(
        "calibration.assumed_accelerations",
        "Assumed accelerations",
        whole_list(
            AXIS_BOUNDS,
            3,
            |m| numbers_of(m.calibrated_on.assumed_accelerations),
            |m, v| m.calibrated_on.assumed_accelerations = axes_of(v),
        ),
        "Axes (1 X, 2 Y, 3 Z) whose acceleration the calibrating runs do not determine. It comes from the other axes, or holds only together with theirs. A diagnosis fits it again beside each cause."
    ),
    row!("calibration.least_accelerations_mm_s2", "Least accelerations", axes MillimetrePerSecond2 (0.0, 1e7) [calibrated_on.least_accelerations],
        "Accelerations that X, Y and Z have at least: with lower ones the calibrating runs would have been slower. A diagnosis that fits an assumed acceleration again goes no lower. 0 for an axis whose acceleration was not assumed."),
    row!("calibration.least_jerks_mm_s3", "Least jerks", axes MillimetrePerSecond3 (0.0, 1e9) [calibrated_on.least_jerks],
        "Jerks that X, Y and Z have at least on ramps, of axes whose jerk the calibrating runs do not determine: with lower ones these runs would have been slower. Programs that a higher jerk would make faster are less certain, and a diagnosis of them takes the jerk from the recording first. 0 for an axis whose jerk is known. Empty: all are known, or none is limited."),
    row!("calibration.acceleration_deviations_percent", "Deviations of accelerations", axes Percent (0.0, 1000.0) [calibrated_on.acceleration_deviations],
        "Standard deviations of the fitted accelerations of X, Y and Z. Programs with more ramps than the calibrating ones are less certain. 0 for an axis whose acceleration was assumed. Empty: unknown."),
    row!("calibration.largest_override_percent", "Largest override to plan for", optional Percent (100.0, 1000.0) [calibrated_on.largest_override],
        "Largest override that the control may plan its corners for as far as the calibrating runs show: their corners would be the same. Programs whose corners would not be the same are less certain, and a diagnosis of them takes the override from the recording first. Empty: the runs determine the override, or the control plans for none."),
    row!(
        "calibration.other_chords_percent",
        "Other chords of arcs",
        list(
            Unit::Percent,
            (0.01, 1e5),
            2,
            |m| Some(m.calibrated_on.other_chord_ratios.clone()).filter(|list| !list.is_empty()),
            |m, v| m.calibrated_on.other_chord_ratios = v,
        ),
        "Distances between arcs and their chords that the calibrating runs allow as well as that of this machine, in per cent of it. Programs that other chords would slow are less certain. Empty: the runs determine the chords, or arcs have none."
    ),
    row!("calibration.only_rapid_feed_mm_min", "Only F of rapids", optional MillimetrePerMinute (0.001, 1e6) [calibrated_on.only_rapid_feedrate],
        "Only programmed feedrate that the rapids of the calibrating runs hold. The rate of the machine may be the same by coincidence. Programs whose rapids have another feedrate are therefore less certain. Empty: the rapids hold several feedrates or none."),
    row!(
        "calibration.assumed_rapids",
        "Assumed rapids",
        whole_list(
            AXIS_BOUNDS,
            3,
            |m| numbers_of(m.calibrated_on.assumed_rapids),
            |m, v| m.calibrated_on.assumed_rapids = axes_of(v),
        ),
        "Axes (1 X, 2 Y, 3 Z) that reached their rapid rate in no calibrating run. The rate comes from the machine file before, or from other axes. A diagnosis of another program takes it from the recording first."
    ),
    row!(
        "calibration.m_codes",
        "M words calibrated on",
        whole_list(
            WORD_BOUNDS,
            1000,
            |m| m.calibrated_on.m_codes.as_deref().map(written_words),
            |m, v| m.calibrated_on.m_codes = Some(read_words(v)),
        ),
        "M words of the calibrating programs: 6 for a tool change, 3 and 5 for the start and the stop of the spindle, 30 for the end. The times of all others come from the machine file before: they make a quote less certain, and a diagnosis of another program takes them from the recording first. Empty: unknown."
    ),
    row!(
        "calibration.tolerances_mm",
        "Tolerances of that error",
        list(
            Unit::Millimetre,
            TOLERANCE_BOUNDS_MM,
            20,
            |m| Some(m.calibrated_at.clone()).filter(|list| !list.is_empty()),
            |m, v| m.calibrated_at = v,
        ),
        "The error of the cycle time holds at these contour tolerances only. Empty: at the contour tolerance."
    ),
];
