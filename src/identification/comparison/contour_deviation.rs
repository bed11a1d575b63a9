//! Contour deviation: recorded positions against simulated ones, without differences of time.
//!
//! A recorded sample at t is compared with the simulated position at t − t0 − r̃(t) − δ, where t0 is the
//! recorded less the simulated time at the first mark. r̃ is 0 if the simulation is assumed to lose no time,
//! or else the median of the residual over [`MEDIAN_REACH_S`] on both sides, which keeps jumps. δ is a common
//! delay, as drives and recorders have; Newton steps determine it, δ = −Σ e·v / Σ v·v, with the difference e
//! and the simulated velocity v, over all samples or as the median of many parts. The part of e along the
//! motion is weighted by σ²/(σ² + (v τ)²), with the noise σ (mm) and the uncertainty τ (s) of stamps: at rapid
//! speed a millisecond is a third of a millimetre.
//! The remainder is the deviation of the path: lag at corners, backlash at reversals, vibration.
//!
//! Of a long recording, [`WINDOWS`] evenly spread windows of [`WINDOW_S`] are compared. Drives respond to the motion of the last
//! seconds, and backlash depends on where each axis last turned; the profile far from any window therefore keeps only the
//! rows at which an axis turns.

use std::ops::Range;

use crate::identification::alignment::{Alignment, Fix, Mark, median};
use crate::machine::Machine;
use crate::simulation::drive::AxisMotion;
use crate::simulation::feed::FeedPlan;
use crate::simulation::ordered::weighted_median;
use crate::simulation::profile::{Profile, Resolution, Samples};
use crate::simulation::toolpath::Toolpath;

/// Time before and after a mark over which the median of the residuals is taken, s.
const MEDIAN_REACH_S: f64 = 1.0;
/// Number of windows of a long recording, and the duration of each, s.
const WINDOWS: usize = 24;
const WINDOW_S: f64 = 2.0;
/// Time before a window for which the profile keeps all rows, s: drives settle in it.
const MARGIN_BEFORE_S: f64 = 5.0;
/// Time after a window for which the profile keeps all rows, s: delays are shorter.
const MARGIN_AFTER_S: f64 = 1.0;
/// Least ratio between the duration of a long recording and the duration of all windows with their margins.
const MIN_LONG_RATIO: f64 = 1.5;
/// Factor of the velocities in rows far from any window. Their signs show where an axis turns, and the cubics between such rows
/// do not overshoot.
const VELOCITY_RATIO_BETWEEN_WINDOWS: f64 = 1e-9;
/// Most samples compared.
const MAX_SAMPLES: usize = 8000;
/// Uncertainty of a recorder's stamps, s; multiplied by the speed it is a difference along the motion.
const STAMP_DEVIATION_S: f64 = 1e-3;
/// Number of parts of a recording whose errors have a geometric mean: enough for most of them to be free of the
/// places where a model is far off.
pub const TYPICAL_PARTS: usize = 256;
/// Most Newton steps for the delay, and the least step, s.
const MAX_DELAY_STEPS: usize = 8;
const MIN_DELAY_STEP_S: f64 = 1e-6;

/// Sums over the rows of a part of a recording, with the difference e and the simulated velocity v.
struct Part {
    /// Σ e·v, mm²/s.
    along: f64,
    /// Σ v·v, mm²/s².
    speeds: f64,
    /// Σ e·e, weighted along the motion, mm².
    squares: f64,
    rows: usize,
}

impl Part {
    fn mean_square(&self) -> f64 {
        self.squares / self.rows.max(1) as f64
    }
}

/// Recorded positions with their simulated times.
pub struct ContourDeviation {
    samples: Samples,
    /// Simulated time, s, and recorded position of each sample.
    rows: Vec<(f64, [f64; 3])>,
    recorded: [bool; 3],
    /// Standard deviation of a recorded coordinate, mm.
    noise: f64,
}

impl ContourDeviation {
    /// Returns the profile of a plan as [`ContourDeviation::new`] needs it.
    pub fn samples(toolpath: &Toolpath, plan: &FeedPlan) -> Samples {
        Profile::new(toolpath, plan).samples(Resolution::MOTION)
    }

    /// Returns the deviations of a run from its simulated profile, given the simulated times at the marks (s) and the
    /// residuals there (s) if the run lost time; `None` without positions.
    pub fn new(
        samples: &Samples,
        alignment: &Alignment,
        simulated: &[f64],
        residuals: Option<&[f64]>,
    ) -> Option<ContourDeviation> {
        let track = alignment.track.as_ref()?;
        let smooth =
            residuals.map_or(vec![0.0; simulated.len()], |residuals| running_medians(simulated, residuals));
        let windows = windows(&alignment.fixes);
        let compared: usize = windows.iter().map(Range::len).sum();
        let every = compared.div_ceil(MAX_SAMPLES).max(1);
        let mut clock = SimulatedClock::new(&alignment.marks, simulated, &smooth)?;
        let (mut rows, mut spans) = (Vec::new(), Vec::new());
        for window in windows {
            let first = rows.len();
            for fix in alignment.fixes[window].iter().step_by(every) {
                let Some(sample) = fix.sample else { continue };
                rows.push((clock.at(fix.time), track.position[sample].into()));
            }
            spans.extend(rows.get(first).zip(rows.last()).map(|((from, _), (to, _))| *from..*to));
        }
        let samples = if 1 < spans.len() { near(samples, &spans) } else { samples.clone() };
        Some(ContourDeviation { samples, rows, recorded: track.recorded, noise: track.noise.max(2e-3) })
    }

    /// Returns the RMS distance between recorded and simulated positions on a machine with these drives, mm,
    /// and the delay that minimises it, s.
    pub fn error(&self, machine: &Machine) -> (f64, f64) {
        let (parts, delay) = self.in_step(&self.actual(machine), 1);
        (parts.first().map_or(0.0, Part::mean_square).sqrt(), delay)
    }

    /// Returns the geometric mean of the RMS distances of [`TYPICAL_PARTS`] parts of the recording, mm, each with
    /// the noise; a part that is far off counts no more than one that is a little off.
    pub fn typical_error(&self, machine: &Machine) -> f64 {
        let squares = self.mean_squares(machine, TYPICAL_PARTS);
        geometric_mean(squares.into_iter()).sqrt()
    }

    /// Returns the mean squared deviation of each of `count` parts of the recording, with the variance of the
    /// noise, mm², at the common delay of the parts.
    pub fn mean_squares(&self, machine: &Machine, count: usize) -> Vec<f64> {
        let (parts, _) = self.in_step(&self.actual(machine), count);
        parts.iter().map(|part| part.mean_square() + self.noise * self.noise).collect()
    }

    /// Returns the sum of squared deviations (mm²) of each of `count` contiguous parts of the recording, at the
    /// delay of the whole.
    pub fn parts(&self, machine: &Machine, count: usize) -> Vec<f64> {
        let actual = self.actual(machine);
        let (_, delay) = self.in_step(&actual, 1);
        self.parts_at(&actual, delay, count).iter().map(|part| part.squares).collect()
    }

    /// Returns the actual motion of each axis on a machine.
    fn actual(&self, machine: &Machine) -> [AxisMotion<'_>; 3] {
        [0, 1, 2].map(|axis| AxisMotion::of(&self.samples, machine, axis))
    }

    /// Returns `count` parts of the recording at their common delay, and this delay (s). Newton steps find it: each step
    /// is the median of the steps of the parts, and a part has the weight √Σ v·v, the inverse of its uncertainty. A wait
    /// that the simulation lacks therefore shifts only the parts near it.
    fn in_step(&self, actual: &[AxisMotion; 3], count: usize) -> (Vec<Part>, f64) {
        let mut delay = 0.0;
        let mut best = (Vec::new(), delay);
        let mut least = f64::INFINITY;
        for _ in 0..MAX_DELAY_STEPS {
            let parts = self.parts_at(actual, delay, count);
            let found = geometric_mean(parts.iter().map(|part| part.mean_square() + self.noise * self.noise));
            let moving = parts.iter().filter(|part| 0.0 < part.speeds);
            let steps = moving.map(|part| (part.along / part.speeds, part.speeds.sqrt())).collect();
            if best.0.is_empty() || found < least {
                (least, best) = (found, (parts, delay));
            }
            let Some(step) = weighted_median(steps) else { break };
            if step.abs() < MIN_DELAY_STEP_S {
                break;
            }
            delay -= step;
        }
        best
    }

    /// Returns `count` contiguous parts of the recording, compared at a delay (s).
    fn parts_at(&self, actual: &[AxisMotion; 3], delay: f64, count: usize) -> Vec<Part> {
        let mut near = [0; 3];
        let mut part_of = |rows: &[(f64, [f64; 3])]| {
            let mut part = Part { along: 0.0, speeds: 0.0, squares: 0.0, rows: rows.len() };
            for (time, position) in rows {
                let (along, speed, square) = self.difference(actual, time - delay, position, &mut near);
                part.along += along;
                part.speeds += speed;
                part.squares += square;
            }
            part
        };
        self.rows.chunks(self.rows.len().div_ceil(count).max(1)).map(&mut part_of).collect()
    }

    /// Returns e·v, v·v and the weighted square of e at a time (s), where e is the recorded position less the simulated one.
    /// For each axis `near` holds the row that the last search found.
    fn difference(
        &self,
        actual: &[AxisMotion; 3],
        time: f64,
        position: &[f64; 3],
        near: &mut [usize; 3],
    ) -> (f64, f64, f64) {
        let difference = PositionDifference::of(actual, self.recorded, time, position, near);
        let PositionDifference { square: all, along: forward, .. } = difference;
        let own = difference.speed_square();
        // The difference along the motion is weighted by the uncertainty of the stamps.
        let ahead = if 0.0 < own { forward * forward / own } else { 0.0 };
        let certain = self.noise * self.noise;
        let square = (all - ahead).max(0.0)
            + ahead * certain / (certain + own * STAMP_DEVIATION_S * STAMP_DEVIATION_S);
        (forward, own, square)
    }
}

/// The clock of a simulation during a recording. At each moment it differs from the recorder's clock as at the last mark.
pub(super) struct SimulatedClock<'a> {
    marks: &'a [Mark],
    /// Residuals at the marks, s.
    residuals: &'a [f64],
    /// Recorded less simulated time at the first mark, s.
    offset: f64,
    mark: usize,
}

impl<'a> SimulatedClock<'a> {
    /// Returns the clock of a recording with these marks, given the simulated times and the residuals there, s; `None`
    /// without marks.
    pub(super) fn new(
        marks: &'a [Mark],
        simulated: &[f64],
        residuals: &'a [f64],
    ) -> Option<SimulatedClock<'a>> {
        let offset = marks.first()?.time - simulated.first()?;
        Some(SimulatedClock { marks, residuals, offset, mark: 0 })
    }

    /// Returns the simulated time at a recorded time, s. Recorded times must not decrease from call to call.
    pub(super) fn at(&mut self, time: f64) -> f64 {
        while self.mark + 1 < self.marks.len() && self.marks[self.mark + 1].time <= time {
            self.mark += 1;
        }
        time - self.offset - self.residuals[self.mark]
    }
}

/// The difference e of a recorded position from the simulated one, with the simulated velocity v.
pub(super) struct PositionDifference {
    /// e·e, mm².
    pub square: f64,
    /// e·v, mm²/s.
    pub along: f64,
    /// Squared velocity of each recorded axis, mm²/s².
    pub velocity_squares: [f64; 3],
}

impl PositionDifference {
    /// Returns the difference in the recorded axes at a simulated time (s). For each axis `near` holds the row that the
    /// last search found.
    pub(super) fn of(
        simulated: &[AxisMotion; 3],
        recorded: [bool; 3],
        time: f64,
        position: &[f64; 3],
        near: &mut [usize; 3],
    ) -> PositionDifference {
        let mut sums = PositionDifference { square: 0.0, along: 0.0, velocity_squares: [0.0; 3] };
        for axis in (0..3).filter(|axis| recorded[*axis]) {
            let (there, velocity) = simulated[axis].at(time, &mut near[axis]);
            let difference = position[axis] - there;
            sums.square += difference * difference;
            sums.along += difference * velocity;
            sums.velocity_squares[axis] = velocity * velocity;
        }
        sums
    }

    /// Returns v·v, mm²/s².
    pub(super) fn speed_square(&self) -> f64 {
        self.velocity_squares.iter().sum()
    }
}

/// Returns the windows of a recording as ranges of its fixes; the only one is the whole recording if that is not long.
fn windows(fixes: &[Fix]) -> Vec<Range<usize>> {
    let Some((first, last)) = fixes.first().zip(fixes.last()) else { return Vec::new() };
    let duration = last.time - first.time;
    if duration < MIN_LONG_RATIO * WINDOWS as f64 * (MARGIN_BEFORE_S + WINDOW_S + MARGIN_AFTER_S) {
        let whole = 0..fixes.len();
        return vec![whole];
    }
    let at = |time: f64| fixes.partition_point(|fix| fix.time < time);
    let window = |number: usize| {
        let begin = first.time + (duration - WINDOW_S) * (number as f64 + 0.5) / WINDOWS as f64;
        at(begin)..at(begin + WINDOW_S)
    };
    (0..WINDOWS).map(window).collect()
}

/// Returns the rows of a profile that drives need for their motion in some spans of simulated time, s, in ascending order.
fn near(samples: &Samples, spans: &[Range<f64>]) -> Samples {
    let mut kept = Samples::default();
    let mut signs = [0.0; 3];
    let mut span = 0;
    let last = samples.time.len().saturating_sub(1);
    for row in 0..samples.time.len() {
        // The rows around the span belong to it, too.
        let [before, after] = [row.saturating_sub(1), (row + 1).min(last)].map(|row| samples.time[row]);
        while span + 1 < spans.len() && spans[span].end + MARGIN_AFTER_S < before {
            span += 1;
        }
        let is_near =
            spans[span].start - MARGIN_BEFORE_S <= after && before <= spans[span].end + MARGIN_AFTER_S;
        let mut is_turn = false;
        for (sign, velocities) in signs.iter_mut().zip(&samples.velocity) {
            let velocity = velocities[row];
            if velocity != 0.0 && velocity.signum() != *sign {
                (*sign, is_turn) = (velocity.signum(), true);
            }
        }
        if is_near {
            push_row(&mut kept, samples, row, 1.0);
        } else if is_turn {
            // The place where the axis turns is between both rows.
            for row in row.saturating_sub(1)..=row {
                if kept.time.last().is_none_or(|last| *last < samples.time[row]) {
                    push_row(&mut kept, samples, row, VELOCITY_RATIO_BETWEEN_WINDOWS);
                }
            }
        }
    }
    kept
}

/// Adds a row of other samples, with its velocities multiplied by a ratio.
fn push_row(kept: &mut Samples, samples: &Samples, row: usize, velocity_ratio: f64) {
    kept.time.push(samples.time[row]);
    kept.distance.push(samples.distance[row]);
    kept.feedrate.push(samples.feedrate[row]);
    kept.line.push(samples.line[row]);
    for axis in 0..3 {
        kept.position[axis].push(samples.position[axis][row]);
        kept.velocity[axis].push(velocity_ratio * samples.velocity[axis][row]);
    }
}

fn geometric_mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    (values.map(f64::ln).sum::<f64>() / count).exp()
}

/// Returns the running median of the residuals within [`MEDIAN_REACH_S`] of each mark, s. Marks closer
/// together than a tenth of that time share one median, so that the work is linear in the number of marks.
fn running_medians(simulated: &[f64], residuals: &[f64]) -> Vec<f64> {
    let mut smooth = vec![0.0; residuals.len()];
    let mut window = Vec::new();
    let (mut from, mut to) = (0, 0);
    let mut last = f64::NEG_INFINITY;
    for at in 0..residuals.len() {
        if simulated[at] - last < 0.1 * MEDIAN_REACH_S && 0 < at {
            smooth[at] = smooth[at - 1];
            continue;
        }
        last = simulated[at];
        while to < residuals.len() && simulated[to] <= simulated[at] + MEDIAN_REACH_S {
            to += 1;
        }
        while simulated[from] < simulated[at] - MEDIAN_REACH_S {
            from += 1;
        }
        window.clear();
        window.extend_from_slice(&residuals[from..to]);
        smooth[at] = median(&mut window);
    }
    smooth
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::StructuralMode;
    use crate::simulation::drive::actual_motion;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;
    use crate::simulation::simulate;

    #[test]
    fn a_running_median_keeps_a_jump_and_drops_an_outlier() {
        let simulated: Vec<f64> = (0..100).map(|mark| 0.2 * f64::from(mark)).collect();
        let mut residuals: Vec<f64> =
            simulated.iter().map(|time| if *time < 10.0 { 0.0 } else { 1.0 }).collect();
        residuals[20] = 50.0;
        let medians = running_medians(&simulated, &residuals);
        for (time, median) in simulated.iter().zip(&medians) {
            let expected = if *time < 10.0 { 0.0 } else { 1.0 };
            // At the jump itself the window has marks of both sides.
            assert!(*median == expected || (time - 10.0).abs() < 0.25, "{median} at {time} s");
        }
    }

    /// A square of 20 mm, commanded on each axis as the samples of a machine without drives.
    fn square() -> Samples {
        let mut samples = Samples::default();
        for row in 0..400 {
            let time = 0.01 * f64::from(row);
            let side = time.floor() as usize;
            let part = 20.0 * (time - time.floor());
            let ([x, y], [vx, vy]) = [
                ([part, 0.0], [20.0, 0.0]),
                ([20.0, part], [0.0, 20.0]),
                ([20.0 - part, 20.0], [-20.0, 0.0]),
                ([0.0, 20.0 - part], [0.0, -20.0]),
            ][side];
            samples.time.push(time);
            samples.distance.push(20.0 * time);
            samples.feedrate.push(20.0);
            samples.line.push(1);
            for (axis, (position, velocity)) in [(x, vx), (y, vy), (0.0, 0.0)].into_iter().enumerate() {
                samples.position[axis].push(position);
                samples.velocity[axis].push(velocity);
            }
        }
        samples
    }

    /// The square as a machine with these drives runs it, with each row changed.
    fn recorded(machine: &Machine, change: impl Fn(f64, [f64; 3]) -> (f64, [f64; 3])) -> ContourDeviation {
        let samples = square();
        let actual = actual_motion(&samples, machine);
        let mut row = 0;
        let rows = (1..380).map(|row| 0.01 * f64::from(row)).map(|time| {
            let (position, _) = actual.motion_at(time, &mut row);
            change(time, [position.x, position.y, position.z])
        });
        let rows = rows.collect();
        ContourDeviation { samples, rows, recorded: [true; 3], noise: 2e-3 }
    }

    #[test]
    fn a_recorded_lag_is_found_and_a_common_delay_is_no_deviation() {
        let machine = Machine::default();
        let mut lagging = machine.clone();
        lagging.axes[0].servo_lag = 0.02;
        let delay = 0.03;
        let deviation = recorded(&lagging, |time, position| (time + delay, position));
        let (right, found) = deviation.error(&lagging);
        let (wrong, _) = deviation.error(&machine);
        assert!(right < 0.01, "{right} mm with the lag");
        assert!((found - delay).abs() < 1e-3, "{found} s");
        assert!(10.0 * right < wrong, "{wrong} mm without it");
        let parts = deviation.parts(&machine, 8);
        let sum: f64 = parts.iter().sum();
        assert!((f64::sqrt(sum / 379.0) - wrong).abs() < 1e-9, "the parts add up to the whole");
        // One part has the delay of the whole.
        let squares = deviation.mean_squares(&machine, 1);
        assert!((sum / 379.0 + 4e-6 - squares[0]).abs() < 1e-12);
    }

    /// A wait that the simulation lacks shifts the delay of least squares; most parts keep theirs.
    #[test]
    fn a_wait_shifts_no_typical_delay() {
        let machine = Machine::default();
        let waits = |time: f64, position| (time + if time < 3.0 { 0.0 } else { 0.05 }, position);
        let waiting = recorded(&machine, waits);
        let (_, delay) = waiting.error(&machine);
        assert!(5e-3 < delay, "{delay} s");
        let squares = waiting.mean_squares(&machine, TYPICAL_PARTS);
        let exact = squares.iter().filter(|square| **square < 4.1e-6).count();
        assert!(0.7 * squares.len() as f64 <= exact as f64, "{exact} of {}", squares.len());
    }

    /// One place that is far off hides nothing in the geometric mean.
    #[test]
    fn a_typical_error_is_that_of_most_parts() {
        let machine = Machine::default();
        let mut bent = machine.clone();
        bent.axes[0].backlash = 0.02;
        let far_off = |time: f64, [x, y, z]: [f64; 3]| {
            let off = if (1.5..1.7).contains(&time) { 3.0 } else { 0.0 };
            (time, [x + off, y, z])
        };
        let ratio = |measure: &dyn Fn(&ContourDeviation) -> f64| {
            measure(&recorded(&bent, far_off)) / measure(&recorded(&machine, far_off))
        };
        assert!(ratio(&|one| one.error(&machine).0) < 1.01);
        // In 43 % of the parts X is off by half of the backlash, 0.01 mm, beside noise of 2e-3 mm: √26^0.43.
        let typical = ratio(&|one| one.typical_error(&machine));
        assert!((typical - 2.01).abs() < 0.03, "{typical}");
    }

    /// Squares with sides of 4 s, after a plunge of Z, for 800 s.
    #[test]
    fn drives_respond_near_windows_as_to_the_whole_profile() {
        let mut machine = Machine::default();
        machine.axes[0].servo_lag = 0.02;
        machine.axes[1].mode = Some(StructuralMode { frequency: 12.0, damping: 0.05 });
        machine.axes[1].backlash = 0.03;
        machine.axes[2].backlash = 0.05;
        let program = format!("G1 F600\nZ-3\n{}", "X40\nY40\nX0\nY0\n".repeat(50));
        let toolpath = trace(&read(program.as_bytes()), &machine);
        let samples = ContourDeviation::samples(&toolpath, &simulate(&toolpath, &machine));
        let fix = |at: u32| Fix { time: 0.02 * f64::from(at), distance: 0.0, sample: None };
        let fixes: Vec<Fix> = (0..40_000).map(fix).collect();
        let spans = windows(&fixes).into_iter().map(|own| fixes[own.start].time..fixes[own.end - 1].time);
        let spans: Vec<Range<f64>> = spans.collect();
        assert_eq!(spans.len(), WINDOWS);
        let thinned = near(&samples, &spans);
        assert!(2 * thinned.time.len() < samples.time.len(), "{} rows", thinned.time.len());
        for axis in 0..3 {
            let [whole, near] = [&samples, &thinned].map(|samples| AxisMotion::of(samples, &machine, axis));
            let (mut row, mut near_row) = (0, 0);
            for time in spans.iter().flat_map(|span| [span.start, 0.5 * (span.start + span.end), span.end]) {
                let (expected, found) = (whole.at(time, &mut row).0, near.at(time, &mut near_row).0);
                assert!(
                    (expected - found).abs() < 1e-4,
                    "axis {axis} at {time} s: {found} for {expected} mm"
                );
            }
        }
    }
}
