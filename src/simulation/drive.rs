//! Profile → actual motion: the motion of the axes that follow the interpolator's command.
//!
//! Each axis follows the filtered position through, in this order,
//!
//! ```text
//! compensation      x = c ± b'/2 in the direction of motion of the command c, b' compensated backlash, mm;
//!                   from −b'/2 to b'/2 as fast as half the acceleration of the axis allows
//! servo lag         τ ẏ + y = x                      τ = 1/Kv, s
//! structural mode   z̈ + 2ζω ż + ω² z = ω² y           ω = 2π f, rad/s; ζ damping ratio
//! backlash          the table rests while the drive crosses the backlash b, mm:
//!                   w stays, until |z − w| would exceed b/2
//! ```
//!
//! An encoder at the motor shows the compensation without the backlash. A scale at the table shows the backlash that
//! the compensation does not cover.
//!
//! None of them changes the cycle time. Between two rows of the profile the command is taken as the cubic
//! through position and velocity at both, for which the two differential equations are solved in closed form.
//! Rows are first added, so that a time constant or a radian of vibration spans at least two rows, until the
//! response to the earlier motion has decayed. From there on the motion bends no more than its command, so
//! that a dwell or a slow move costs the same however long it lasts. The error of the cubic falls with the
//! fourth power of the spacing. Over steps that are very short against the time constant the higher terms of
//! the cubic are only rounding, and its mean is used. An axis without all of these keeps its columns bit for bit.
//!
//! Source: the usual models, as in vendors' manuals; the compensation as LinuxCNC makes it (control.c,
//! `compute_screw_comp`). Limits: no friction, no coupling between axes, no feedforward.

use std::borrow::Cow;

use crate::machine::{Axis, Machine, StructuralMode};
use crate::simulation::profile::Samples;
use crate::simulation::sampled::rows_around;

/// Returns the actual motion of a machine from the commanded profile.
///
/// # Examples
///
/// ```
/// use truefeed::machine::Machine;
/// use truefeed::simulation::profile::{Profile, Resolution};
/// use truefeed::simulation::{drive::actual_motion, gcode::read, simulate, interpreter::trace};
///
/// let mut machine = Machine::default();
/// machine.axes[0].servo_lag = 0.01;
/// let toolpath = trace(&read(b"G21 G90 G1 X100 F6000"), &machine);
/// let plan = simulate(&toolpath, &machine);
/// let samples = Profile::new(&toolpath, &plan).samples(Resolution::CHART);
/// let actual = actual_motion(&samples, &machine);
/// let half = 0.5 * plan.cycle_time();
/// let row = actual.time.partition_point(|time| *time < half);
/// let commanded = 50.0 + 100.0 * (actual.time[row] - half);
/// assert!((commanded - actual.position[0][row] - 0.01 * 100.0).abs() < 1e-6, "mm: the lag at 100 mm/s");
/// ```
pub fn actual_motion(commanded: &Samples, machine: &Machine) -> Samples {
    if !machine.axes.iter().any(Axis::has_drive) {
        return commanded.clone();
    }
    let finest = machine.axes.iter().map(longest_spacing).fold(f64::INFINITY, f64::min);
    let settling = machine.axes.iter().map(settling_time).fold(0.0, f64::max);
    let mut actual = refined(commanded, finest, settling);
    for (axis, own) in machine.axes.iter().enumerate() {
        follow_drives(&actual.time, &mut actual.position[axis], &mut actual.velocity[axis], own);
    }
    let [x, y, z] = &actual.velocity;
    actual.feedrate = x.iter().zip(y).zip(z).map(|((x, y), z)| x.hypot(*y).hypot(*z)).collect();
    actual
}

/// The actual motion of one axis. An axis without drives moves as commanded.
pub struct AxisMotion<'a> {
    time: Cow<'a, [f64]>,
    position: Cow<'a, [f64]>,
    velocity: Cow<'a, [f64]>,
}

impl AxisMotion<'_> {
    /// Returns the actual motion of the axis `axis` (0 to 2) of a machine from the commanded profile, in rows as close as this
    /// axis alone needs them.
    pub fn of<'a>(commanded: &'a Samples, machine: &Machine, axis: usize) -> AxisMotion<'a> {
        let own = &machine.axes[axis];
        if !own.has_drive() {
            return AxisMotion {
                time: Cow::Borrowed(&commanded.time),
                position: Cow::Borrowed(&commanded.position[axis]),
                velocity: Cow::Borrowed(&commanded.velocity[axis]),
            };
        }
        let rows = || refined_rows(&commanded.time, longest_spacing(own), settling_time(own));
        let time: Vec<f64> = rows().map(|row| row.time(&commanded.time)).collect();
        let (mut position, mut velocity): (Vec<f64>, Vec<f64>) =
            rows().map(|row| row.motion(commanded, axis)).unzip();
        follow_drives(&time, &mut position, &mut velocity, own);
        AxisMotion { time: time.into(), position: position.into(), velocity: velocity.into() }
    }

    /// Returns position (mm) and velocity (mm/s) at a time (s), as [`Samples::motion_at`].
    pub fn at(&self, time: f64, row: &mut usize) -> (f64, f64) {
        let rows = rows_around(&self.time, time, row);
        rows.map_or((0.0, 0.0), |rows| rows.motion(&self.time, &self.position, &self.velocity))
    }
}

/// Applies the drives of an axis to its commanded columns, time in s, position in mm and velocity in mm/s.
fn follow_drives(time: &[f64], position: &mut [f64], velocity: &mut [f64], axis: &Axis) {
    if 0.0 < axis.backlash_compensation {
        compensate(time, position, velocity, axis);
    }
    if 0.0 < axis.servo_lag {
        lag(time, position, velocity, axis.servo_lag);
    }
    if let Some(mode) = axis.mode {
        vibrate(time, position, velocity, mode);
    }
    if 0.0 < axis.backlash {
        cross_play(position, velocity, axis.backlash);
    }
}

/// Returns the widest spacing of rows that resolves the compensation, the lag and the vibration of an axis, s.
fn longest_spacing(axis: &Axis) -> f64 {
    let lag = if 0.0 < axis.servo_lag { 0.5 * axis.servo_lag } else { f64::INFINITY };
    let mode = axis.mode.map_or(f64::INFINITY, |mode| 0.5 / angular(mode));
    let compensation = compensation_time(axis);
    let compensated = if 0.0 < compensation { compensation / RAMP_ROWS } else { f64::INFINITY };
    lag.min(mode).min(compensated)
}

/// Rows within the ramp of a compensation.
const RAMP_ROWS: f64 = 16.0;

/// Returns the acceleration with which the compensation of an axis changes, mm/s².
fn compensating_acceleration(axis: &Axis) -> f64 {
    0.5 * axis.acceleration
}

/// Returns the time in which the compensation of an axis changes its side, s: the whole width b at the acceleration a,
/// half of it in each direction, 2 √(b/a).
fn compensation_time(axis: &Axis) -> f64 {
    2.0 * (axis.backlash_compensation / compensating_acceleration(axis)).sqrt()
}

/// Number of time constants after which an axis has settled: e⁻³⁰ of any earlier motion remains, a part of
/// 10¹³.
const SETTLING_TIME_CONSTANTS: f64 = 30.0;

/// Returns the time after which an axis moves as its command again, s.
fn settling_time(axis: &Axis) -> f64 {
    let constants = axis.servo_lag + axis.mode.map_or(0.0, |mode| 1.0 / (mode.damping * angular(mode)));
    SETTLING_TIME_CONSTANTS * constants + compensation_time(axis)
}

fn angular(mode: StructuralMode) -> f64 {
    2.0 * std::f64::consts::PI * mode.frequency
}

/// A row of a refined profile: a row of the profile, or one inserted before it.
#[derive(Clone, Copy)]
struct RefinedRow {
    /// Row of the profile, at or after this one.
    row: usize,
    /// Time since the row before, s, and the part of the way from it; `None` at a row of the profile.
    inserted: Option<(f64, f64)>,
}

impl RefinedRow {
    /// Returns the time of the row, s. `time` is the column of times of the profile.
    fn time(&self, time: &[f64]) -> f64 {
        self.inserted.map_or(time[self.row], |(elapsed, _)| time[self.row - 1] + elapsed)
    }

    /// Returns the value of a column on the straight line between the rows of the profile.
    fn between(&self, column: &[f64]) -> f64 {
        let Some((_, part)) = self.inserted else { return column[self.row] };
        column[self.row - 1] + (column[self.row] - column[self.row - 1]) * part
    }

    /// Returns the row of the profile that has the line number of this one.
    fn line(&self) -> usize {
        self.row - usize::from(self.inserted.is_some())
    }

    /// Returns position (mm) and velocity (mm/s) of an axis on the cubic between the rows of the profile.
    fn motion(&self, samples: &Samples, axis: usize) -> (f64, f64) {
        let Some((elapsed, _)) = self.inserted else {
            return (samples.position[axis][self.row], samples.velocity[axis][self.row]);
        };
        let cubic = Cubic::between(samples, axis, self.row);
        (cubic.at(elapsed), cubic.slope_at(elapsed))
    }
}

/// Returns the rows of a profile, given their times (s), with rows inserted where they are farther apart than `spacing`
/// (s), until `settling` (s) after a row.
fn refined_rows(time: &[f64], spacing: f64, settling: f64) -> impl Iterator<Item = RefinedRow> {
    (0..time.len()).flat_map(move |row| {
        let duration = row.checked_sub(1).map_or(0.0, |before| time[row] - time[before]);
        let parts = (duration / spacing).ceil().max(1.0);
        let inserted =
            (1..parts as usize).map(move |part| (duration * part as f64 / parts, part as f64 / parts));
        let unsettled = inserted.take_while(move |(elapsed, _)| *elapsed <= settling);
        let of = move |inserted: Option<(f64, f64)>| RefinedRow { row, inserted };
        unsettled.map(Some).chain([None]).map(of)
    })
}

/// Returns the profile in the rows of [`refined_rows`], without feedrates: drives change them.
fn refined(samples: &Samples, spacing: f64, settling: f64) -> Samples {
    let rows = || refined_rows(&samples.time, spacing, settling);
    let mut refined = Samples {
        time: rows().map(|row| row.time(&samples.time)).collect(),
        distance: rows().map(|row| row.between(&samples.distance)).collect(),
        line: rows().map(|row| samples.line[row.line()]).collect(),
        ..Samples::default()
    };
    for axis in 0..3 {
        (refined.position[axis], refined.velocity[axis]) =
            rows().map(|row| row.motion(samples, axis)).unzip();
    }
    refined
}

/// c0 + c1 t + c2 t² + c3 t³, t in s since the earlier of two rows.
#[derive(Clone, Copy)]
struct Cubic([f64; 4]);

impl Cubic {
    /// Returns the cubic through the positions p (mm) and velocities v (mm/s) at both ends of `duration` (s).
    fn new(duration: f64, p: [f64; 2], v: [f64; 2]) -> Cubic {
        if duration <= 0.0 {
            return Cubic([p[1], v[1], 0.0, 0.0]);
        }
        let mean = (p[1] - p[0]) / duration;
        Cubic([
            p[0],
            v[0],
            (3.0 * mean - 2.0 * v[0] - v[1]) / duration,
            (v[0] + v[1] - 2.0 * mean) / (duration * duration),
        ])
    }

    fn between(samples: &Samples, axis: usize, row: usize) -> Cubic {
        let (position, velocity) = (&samples.position[axis], &samples.velocity[axis]);
        let duration = samples.time[row] - samples.time[row - 1];
        Cubic::new(duration, [position[row - 1], position[row]], [velocity[row - 1], velocity[row]])
    }

    fn at(&self, t: f64) -> f64 {
        let c = &self.0;
        c[0] + t * (c[1] + t * (c[2] + t * c[3]))
    }

    fn slope_at(&self, t: f64) -> f64 {
        let c = &self.0;
        c[1] + t * (2.0 * c[2] + t * 3.0 * c[3])
    }

    /// Returns the steady response to this cubic c: the cubic p with p + a ṗ + b p̈ = c, a in s and b in s².
    fn steady_response(&self, a: f64, b: f64) -> Cubic {
        let c = &self.0;
        let p3 = c[3];
        let p2 = c[2] - 3.0 * a * p3;
        let p1 = c[1] - 2.0 * a * p2 - 6.0 * b * p3;
        let p0 = c[0] - a * p1 - 2.0 * b * p2;
        Cubic([p0, p1, p2, p3])
    }
}

/// Duration of a step, as a part of a time constant, below which the mean of the command is used.
const SHORT_STEP_RATIO: f64 = 5e-3;

/// Applies `step(state, command, duration) -> state` from row to row, beginning at rest, and replaces the
/// columns by the states (position, velocity). `constant` is the time constant, s.
fn follow(
    time: &[f64],
    position: &mut [f64],
    velocity: &mut [f64],
    constant: f64,
    step: impl Fn((f64, f64), Cubic, f64) -> (f64, f64),
) {
    let Some(&start) = position.first() else { return };
    let mut state = (start, 0.0);
    let mut before = (position[0], velocity[0]);
    for row in 1..time.len() {
        let duration = time[row] - time[row - 1];
        let command = match duration < SHORT_STEP_RATIO * constant {
            true => {
                let bulge = duration * (before.1 - velocity[row]) / 12.0;
                Cubic([0.5 * (before.0 + position[row]) + bulge, 0.0, 0.0, 0.0])
            }
            false => Cubic::new(duration, [before.0, position[row]], [before.1, velocity[row]]),
        };
        before = (position[row], velocity[row]);
        state = step(state, command, duration);
        (position[row], velocity[row]) = state;
    }
    velocity[0] = 0.0;
}

/// Applies a first-order lag with the time constant `constant`, s: y = p + (y0 − p0) e^(−t/τ).
fn lag(time: &[f64], position: &mut [f64], velocity: &mut [f64], constant: f64) {
    follow(time, position, velocity, constant, |(y, _), command, duration| {
        let steady = command.steady_response(constant, 0.0);
        let left = (y - steady.at(0.0)) * (-duration / constant).exp();
        (steady.at(duration) + left, steady.slope_at(duration) - left / constant)
    });
}

/// Applies a damped oscillator: z = p + e^(−ζωt) (A cos ω't + B sin ω't), ω' = ω √(1 − ζ²).
fn vibrate(time: &[f64], position: &mut [f64], velocity: &mut [f64], mode: StructuralMode) {
    let omega = angular(mode);
    let decay = mode.damping * omega;
    let damped = omega * (1.0 - mode.damping * mode.damping).sqrt();
    follow(time, position, velocity, 1.0 / omega, |(z, slope), command, duration| {
        let steady = command.steady_response(2.0 * mode.damping / omega, 1.0 / (omega * omega));
        let a = z - steady.at(0.0);
        let b = (slope - steady.slope_at(0.0) + decay * a) / damped;
        let (sin, cos) = (damped * duration).sin_cos();
        let fading = (-decay * duration).exp();
        let free = fading * (a * cos + b * sin);
        let free_slope = fading * damped * (b * cos - a * sin) - decay * free;
        (steady.at(duration) + free, steady.slope_at(duration) + free_slope)
    });
}

/// Applies backlash of `width` (mm), centred at the start: the table rests while the drive crosses it.
fn cross_play(position: &mut [f64], velocity: &mut [f64], width: f64) {
    let Some(&start) = position.first() else { return };
    let mut table = start;
    for (drive, speed) in position.iter_mut().zip(velocity) {
        let next = table.clamp(*drive - 0.5 * width, *drive + 0.5 * width);
        if next == table {
            *speed = 0.0;
        }
        table = next;
        *drive = table;
    }
}

/// Adds the compensation of backlash, which is 0 at the start.
fn compensate(time: &[f64], position: &mut [f64], velocity: &mut [f64], axis: &Axis) {
    let half = 0.5 * axis.backlash_compensation;
    let acceleration = compensating_acceleration(axis);
    let (mut offset, mut speed, mut target) = (0.0, 0.0, 0.0);
    for row in 1..time.len() {
        if velocity[row] != 0.0 {
            target = half * velocity[row].signum();
        }
        let duration = time[row] - time[row - 1];
        (offset, speed) = approached((offset, speed), target, acceleration, duration);
        position[row] += offset;
        velocity[row] += speed;
    }
}

/// Returns the position (mm) and velocity (mm/s) after `duration` (s) on the way to a target (mm) within an acceleration
/// (mm/s²), from which the motion can still stop at the target.
fn approached((position, velocity): (f64, f64), target: f64, acceleration: f64, duration: f64) -> (f64, f64) {
    let left = target - position;
    if !acceleration.is_finite()
        || left.abs() <= 0.5 * acceleration * duration * duration && velocity.abs() <= acceleration * duration
    {
        return (target, 0.0);
    }
    // At the end of the step the velocity v must still stop: v²/(2a) ≤ the way that is left then.
    let step = acceleration * duration;
    let way = left.abs() - 0.5 * velocity * left.signum() * duration;
    let stopping =
        ((0.25 * step * step + 2.0 * acceleration * way.max(0.0)).sqrt() - 0.5 * step) * left.signum();
    let next = stopping.clamp(velocity - step, velocity + step);
    (position + 0.5 * (velocity + next) * duration, next)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine of frequency `f` on the X axis for two seconds, in rows 1 ms apart, after half a
    /// second of rest for it to begin from.
    fn sine(f: f64) -> Samples {
        let mut samples = Samples::default();
        for row in 0..4000 {
            let t = row as f64 * 1e-3;
            let omega = 2.0 * std::f64::consts::PI * f;
            samples.time.push(t);
            samples.distance.push(0.0);
            samples.feedrate.push((omega * (omega * t).sin()).abs());
            samples.position[0].push(1.0 - (omega * t).cos());
            samples.velocity[0].push(omega * (omega * t).sin());
            for axis in 1..3 {
                samples.position[axis].push(0.0);
                samples.velocity[axis].push(0.0);
            }
            samples.line.push(1);
        }
        samples
    }

    /// Largest deviation of X from 1 − Re(H e^{iωt}) in the last second.
    fn misfit(samples: &Samples, f: f64, (re, im): (f64, f64)) -> f64 {
        let omega = 2.0 * std::f64::consts::PI * f;
        let rows = samples.time.iter().zip(&samples.position[0]).filter(|(t, _)| 3.0 < **t);
        rows.map(|(t, x)| (1.0 - (re * (omega * t).cos() - im * (omega * t).sin()) - x).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn a_sine_is_answered_by_the_transfer_function() {
        let f = 5.0;
        let omega = 2.0 * std::f64::consts::PI * f;
        let mut machine = Machine::default();
        machine.axes[0].servo_lag = 0.03;
        // 1 / (1 + iωτ)
        let size = 1.0 + (omega * 0.03).powi(2);
        let lag = (1.0 / size, -omega * 0.03 / size);
        assert!(misfit(&actual_motion(&sine(f), &machine), f, lag) < 1e-6);

        machine.axes[0].servo_lag = 0.0;
        machine.axes[0].mode = Some(StructuralMode { frequency: 11.0, damping: 0.3 });
        let own = 2.0 * std::f64::consts::PI * 11.0;
        let (a, b) = (own * own - omega * omega, 2.0 * 0.3 * own * omega);
        let mode = (own * own * a / (a * a + b * b), -own * own * b / (a * a + b * b));
        assert!(misfit(&actual_motion(&sine(f), &machine), f, mode) < 1e-5);
    }

    /// LinuxCNC with 0.08 mm and 500 mm/s², recorded every millisecond: from one side to the other in 36 ms, half the
    /// way in the first half of the time.
    #[test]
    fn compensation_of_backlash_changes_sides_within_half_the_acceleration() {
        let mut axis = Axis { backlash_compensation: 0.08, acceleration: 500.0, ..Axis::default() };
        assert!((compensation_time(&axis) - 0.0358).abs() < 1e-4);
        let mut machine = Machine::default();
        let largest = |machine: &Machine| {
            let commanded = sine(0.5);
            let ahead = actual_motion(&commanded, machine);
            let mut row = 0;
            let away = commanded.time.iter().zip(&commanded.position[0]).map(|(time, own)| {
                let (there, _) = ahead.motion_at(*time, &mut row);
                there[0] - own
            });
            away.collect::<Vec<f64>>()
        };
        machine.axes[0] = axis;
        // The sine turns at 1 s, 2 s, 3 s; it is ahead on the way out, and as much on the way back.
        let away = largest(&machine);
        assert!((away[500] - 0.04).abs() < 1e-9 && (away[1500] + 0.04).abs() < 1e-9);
        let turned = away.iter().skip(1000).position(|away| *away <= -0.04 + 1e-6).expect("it changes sides");
        assert!((36..=39).contains(&turned), "{turned} ms");
        assert!(away[1018].abs() < 4e-3, "{} mm after half the time", away[1018]);

        axis.acceleration = f64::INFINITY;
        machine.axes[0] = axis;
        let away = largest(&machine);
        assert!((away[1002] + 0.04).abs() < 1e-9, "at once without a limit");
        // A scale at the table shows neither, once the backlash is crossed.
        machine.axes[0].backlash = 0.08;
        let away = largest(&machine);
        assert!(away[500].abs() < 1e-9 && away[1500].abs() < 1e-9);
    }

    #[test]
    fn nothing_to_follow_through_changes_nothing() {
        let commanded = sine(3.0);
        assert_eq!(actual_motion(&commanded, &Machine::default()), commanded);
    }

    #[test]
    fn rows_of_any_closeness_change_nothing() {
        let f = 5.0;
        let mut close = Samples::default();
        let wide = sine(f);
        let omega = 2.0 * std::f64::consts::PI * f;
        for row in 0..wide.time.len() {
            for gap in [0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5] {
                let t = wide.time[row] + gap;
                close.time.push(t);
                close.distance.push(0.0);
                close.feedrate.push(0.0);
                close.position[0].push(1.0 - (omega * t).cos());
                close.velocity[0].push(omega * (omega * t).sin());
                for axis in 1..3 {
                    close.position[axis].push(0.0);
                    close.velocity[axis].push(0.0);
                }
                close.line.push(1);
            }
        }
        let mut machine = Machine::default();
        machine.axes[0].servo_lag = 0.03;
        machine.axes[0].mode = Some(StructuralMode { frequency: 11.0, damping: 0.3 });
        let (wide, close) = (actual_motion(&wide, &machine), actual_motion(&close, &machine));
        let last = |samples: &Samples| samples.position[0][samples.position[0].len() - 7];
        let at = wide.time.len() - 1;
        assert_eq!(wide.time[at], close.time[close.time.len() - 7]);
        assert!((wide.position[0][at] - last(&close)).abs() < 1e-5);
    }

    #[test]
    fn backlash_is_half_the_play_behind_and_stands_at_reversals() {
        let mut machine = Machine::default();
        machine.axes[0].backlash = 0.04;
        let (commanded, actual) = (sine(1.0), actual_motion(&sine(1.0), &machine));
        for row in 500..4000 {
            let behind = commanded.position[0][row] - actual.position[0][row];
            assert!(behind.abs() <= 0.02 + 1e-12);
            if actual.velocity[0][row] != 0.0 {
                assert!((behind - 0.02 * commanded.velocity[0][row].signum()).abs() < 1e-12);
            }
        }
        assert!(actual.velocity[0].iter().filter(|&&v| v == 0.0).count() > 100);
    }

    #[test]
    fn a_standing_machine_comes_to_rest() {
        let mut samples = sine(2.0);
        for axis in 0..3 {
            samples.position[axis].truncate(251);
            samples.velocity[axis].truncate(251);
            samples.velocity[axis].push(0.0);
            let last = samples.position[axis][250];
            samples.position[axis].push(last);
        }
        for column in [&mut samples.time, &mut samples.distance, &mut samples.feedrate] {
            column.truncate(252);
        }
        samples.line.truncate(252);
        samples.time[251] = 20.0;
        let mut machine = Machine::default();
        machine.axes[0].servo_lag = 0.05;
        machine.axes[0].mode = Some(StructuralMode { frequency: 20.0, damping: 0.05 });
        let actual = actual_motion(&samples, &machine);
        let last = actual.time.len() - 1;
        assert!((actual.position[0][last] - 2.0).abs() < 1e-9);
        assert!(300 < actual.time.len(), "rows were added while it settles");
    }

    #[test]
    fn what_settles_needs_no_more_rows_and_loses_nothing() {
        let mut machine = Machine::default();
        machine.axes[0].servo_lag = 0.05;
        machine.axes[0].mode = Some(StructuralMode { frequency: 20.0, damping: 0.05 });
        // It runs to a rest of this duration (s), creeps for as long, and stops.
        let ended = |seconds: f64| {
            let mut samples = sine(2.0);
            for column in [&mut samples.time, &mut samples.distance, &mut samples.feedrate] {
                column.truncate(251);
            }
            samples.line.truncate(251);
            for column in samples.position.iter_mut().chain(&mut samples.velocity) {
                column.truncate(251);
            }
            let at = samples.position[0][250];
            let rows =
                [(seconds, at, 0.0), (0.1, at + 1e-4, 2e-3), (seconds, at + 1e-4 + 2e-3 * seconds, 2e-3)];
            for (after, position, velocity) in rows {
                let before = samples.time[samples.time.len() - 1];
                samples.time.push(before + after);
                samples.distance.push(0.0);
                samples.feedrate.push(velocity);
                samples.line.push(1);
                for axis in 0..3 {
                    samples.position[axis].push(if axis == 0 { position } else { 0.0 });
                    samples.velocity[axis].push(if axis == 0 { velocity } else { 0.0 });
                }
            }
            samples
        };
        let rows = |seconds| actual_motion(&ended(seconds), &machine).time.len();
        // Rows divide their gap evenly, so that the last one before all is settled may be another.
        assert!(rows(3600.0) <= rows(60.0) + 2, "an hour is no more than a minute");

        let sparse = actual_motion(&ended(60.0), &machine);
        let everywhere = refined(&ended(60.0), longest_spacing(&machine.axes[0]), f64::INFINITY);
        let dense = actual_motion(&everywhere, &machine);
        assert!(4 * sparse.time.len() < dense.time.len());
        for (row, time) in sparse.time.iter().enumerate() {
            let same = dense.time.partition_point(|other| other < time);
            assert!((dense.time[same] - time).abs() < 1e-9);
            assert!((dense.position[0][same] - sparse.position[0][row]).abs() < 1e-11);
            assert!((dense.velocity[0][same] - sparse.velocity[0][row]).abs() < 1e-9);
        }
    }
}
