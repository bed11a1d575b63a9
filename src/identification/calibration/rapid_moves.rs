//! Rapids of a recording, one by one: how fast each becomes, and whether it holds a velocity.
//!
//! The highest velocity v of a move from rest that only its ramps hold back grows with the length s:
//!
//! | ramps | v |
//! |---|---|
//! | of an acceleration A | (A s)^(1/2) |
//! | of a jerk J, both ways within the move | (J s² / 4)^(1/3) |
//! | of a filter with a time constant T, longer than the programmed move | s / T |
//!
//! so that of two lengths the longer makes at least the root of their ratio in velocity. If an axis moves along different
//! lengths and reaches one highest velocity in all of them, then a limit holds it back.
//!
//! A velocity is held if its means over three successive windows are equal. Ramps of a jerk J are the flattest that meet:
//! around the highest velocity J T², over windows of a part q of the move's time 4 T, the means differ by 8 q² of it. For
//! [`MIN_WINDOW_RATIO`] that is 2 %.
//!
//! Limits: if all rapids have one length and none holds a velocity, their velocity does not tell a limit from the ramps. A
//! filter makes a short move hold s / T, which is no limit, so what this module finds applies to planners alone.

use crate::identification::alignment::{Fix, Track};
use crate::identification::fit::Run;
use crate::machine::KLIPPER_MIN_CRUISE_RATIO;
use crate::simulation::toolpath::{Motion, Vector};

/// Largest change of the velocity on a plateau, as a part of it.
pub const PLATEAU_TOLERANCE_RATIO: f64 = 0.005;
/// Largest relative difference of two velocities that are equal: each of them may be off by the tolerance of a plateau.
pub const MAX_VELOCITY_DIFFERENCE_RATIO: f64 = 2.0 * PLATEAU_TOLERANCE_RATIO;

/// Least ratio of a window to the time of its move.
const MIN_WINDOW_RATIO: f64 = 0.05;
/// Least number of samples in a window.
const MIN_SAMPLES: usize = 2;
/// Largest turn of the velocity in a straight move, whatever the noise, rad; a blend of two rapids turns by much
/// more.
const MAX_TURN_RAD: f64 = 0.05;
/// Least ratio of the difference that ramps make between two velocities to the tolerance within which the velocities are
/// equal: moves that begin or end in a blend are not from rest.
const MIN_RAMP_DIFFERENCE_RATIO: f64 = 10.0;
/// Largest usual minimum cruise ratio, with a tenth for the windows that reach into the ramps: Klipper's default is 0.5.
const MAX_CRUISE_RATIO: f64 = 1.1 * KLIPPER_MIN_CRUISE_RATIO;
/// Least part of the distance of a rapid that its samples cover. A few samples at one of its ends are too short for ramps
/// to show.
const MIN_COVERED_RATIO: f64 = 0.5;

/// A rapid of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct RapidMove {
    /// First and last sample on it.
    samples: (usize, usize),
    /// Distance that each axis moves, mm.
    length: Vector,
    /// Programmed feedrate in force, with the feed override that the recording states, mm/s; infinite if there is none.
    feedrate: f64,
}

/// The velocities of a rapid, each axis without its sign, mm/s.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RapidVelocity {
    /// Velocities on plateaus.
    pub held: Vec<Vector>,
    /// `true` if a usual minimum cruise ratio does not explain the plateaus.
    pub exceeds_cruise_ratio: bool,
    /// Highest velocity along the rapid.
    pub peak: Option<RapidPeak>,
    /// Highest velocity of each axis.
    pub fastest: Vector,
    /// Highest velocity that each axis reached twice.
    pub twice: Vector,
    /// Rapid override.
    pub override_ratio: f64,
    /// Programmed feedrate, as in [`RapidMove`].
    pub feedrate: f64,
}

impl RapidVelocity {
    /// Returns the highest velocity along the path, mm/s.
    pub fn along(&self) -> f64 {
        let peak = self.peak.map(|peak| peak.velocity);
        self.held.iter().chain(&peak).map(Vector::norm).fold(0.0, f64::max)
    }
}

/// The highest velocity of a rapid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RapidPeak {
    /// Mean velocity over the fastest window, each axis without its sign, mm/s.
    pub velocity: Vector,
    /// Distance that each axis moves, mm.
    pub length: Vector,
}

impl RapidPeak {
    /// Returns the peak without the rapid override `ratio` of its run.
    pub fn at_full_rate(self, ratio: f64) -> RapidPeak {
        RapidPeak { velocity: self.velocity / ratio, ..self }
    }
}

/// Returns the rapids of a run whose samples have no gap and cover most of it. `segment` returns the segment on which a fix
/// is.
pub fn rapid_moves(run: &Run, track: &Track, segment: impl Fn(&Fix) -> usize) -> Vec<RapidMove> {
    let segments = &run.toolpath.segments;
    let mut moves: Vec<RapidMove> = Vec::new();
    let mut of_last = None;
    for fix in &run.alignment.fixes {
        let index = segment(fix);
        let motion = (index < segments.len()).then(|| segments.motion(index));
        let (Some(sample), Some(Motion::Rapid { modal_feedrate })) = (fix.sample, motion) else { continue };
        match moves.last_mut().filter(|own| of_last == Some(index) && own.samples.1 + 1 == sample) {
            Some(own) => own.samples.1 = sample,
            None => {
                let segment = segments.at(index);
                let length = (segment.end - segment.start).abs();
                let feedrate = modal_feedrate * run.overrides.0.unwrap_or(1.0);
                moves.push(RapidMove { samples: (sample, sample), length, feedrate });
            }
        }
        of_last = Some(index);
    }
    moves.retain(|own| own.is_covered(track));
    moves
}

impl RapidMove {
    /// Returns the velocities under the rapid override `override_ratio`. `error` is the largest error of a distance between
    /// two samples, mm; `window` is the number of samples over which velocities count that are not held.
    pub fn velocity(&self, track: &Track, window: usize, error: f64, override_ratio: f64) -> RapidVelocity {
        let held: Vec<Vector> = self.held(track, error).collect();
        RapidVelocity {
            exceeds_cruise_ratio: self.exceeds_cruise_ratio(track, &held, error),
            held,
            peak: self.peak(track, window, error),
            fastest: self.fastest(track, window),
            twice: self.fastest_twice(track, window),
            override_ratio,
            feedrate: self.feedrate,
        }
    }

    /// Returns the velocities that the move holds, each axis without its sign, mm/s; `error` is the largest
    /// error of a distance between two samples, mm.
    fn held(&self, track: &Track, error: f64) -> impl Iterator<Item = Vector> {
        let (first, last) = self.samples;
        let window = self.window(track, error);
        let begins = first..(last + 1).saturating_sub(window.saturating_mul(3));
        begins.filter_map(move |begin| steady(track.successive_velocities(begin, window)))
    }

    /// Returns `true` if the move is at the velocities that it holds (mm/s) for a larger part of its length than any usual
    /// minimum cruise ratio. `error` is as for [`RapidMove::held`].
    fn exceeds_cruise_ratio(&self, track: &Track, held: &[Vector], error: f64) -> bool {
        let fastest = held.iter().map(Vector::norm).fold(0.0, f64::max);
        let windows =
            held.iter().filter(|held| (1.0 - PLATEAU_TOLERANCE_RATIO) * fastest <= held.norm()).count();
        // Each further window begins an interval later.
        let intervals = windows.saturating_sub(1) + 3 * self.window(track, error);
        MAX_CRUISE_RATIO * self.length.norm() < intervals as f64 * track.interval * fastest
    }

    /// Returns the shortest window, in samples, over which a velocity that the move holds differs from ramps that meet, and
    /// is known as accurately as velocities on a plateau agree.
    fn window(&self, track: &Track, error: f64) -> usize {
        let by_ramps = MIN_WINDOW_RATIO * self.seconds(track) / track.interval;
        (by_ramps.ceil() as usize).max(self.window_of_noise(track, error))
    }

    /// Returns the shortest window, in samples, over which a velocity is known as accurately as velocities on a plateau
    /// agree.
    fn window_of_noise(&self, track: &Track, error: f64) -> usize {
        let mean_speed = self.length.norm() / self.seconds(track);
        let window = error / (PLATEAU_TOLERANCE_RATIO * mean_speed * track.interval);
        (window.ceil() as usize).max(MIN_SAMPLES)
    }

    /// Returns `true` if the samples cover most of the move.
    fn is_covered(&self, track: &Track) -> bool {
        let (first, last) = self.samples;
        let covered = (track.position[last] - track.position[first]).norm();
        MIN_COVERED_RATIO * self.length.norm() <= covered
    }

    /// Returns the time of the move, s.
    fn seconds(&self, track: &Track) -> f64 {
        track.time[self.samples.1] - track.time[self.samples.0]
    }

    /// Returns the highest velocity of each axis over `window` samples, mm/s.
    fn fastest(&self, track: &Track, window: usize) -> Vector {
        self.velocities(track, window).fold(Vector::zeros(), |fastest, own| fastest.sup(&own))
    }

    /// Returns the highest velocity of each axis that two separate times of `window` samples reach, mm/s: a jump of the recorder is
    /// in one of them only.
    fn fastest_twice(&self, track: &Track, window: usize) -> Vector {
        let velocities: Vec<Vector> = self.velocities(track, window).collect();
        let mut fastest_later = Vector::zeros();
        let separate = velocities.iter().zip(velocities.iter().skip(window)).rev();
        separate.fold(Vector::zeros(), |fastest, (own, later)| {
            fastest_later = fastest_later.sup(later);
            fastest.sup(&own.inf(&fastest_later))
        })
    }

    /// Returns the highest velocity; `None` if the move has fewer than `window` samples. It is that over `window` samples if
    /// the move holds it for so long, otherwise that over the shortest window that noise allows, so that a limit that the
    /// move reaches for a moment is not averaged with its ramps. `error` is the largest error of a distance between two
    /// samples, mm.
    fn peak(&self, track: &Track, window: usize, error: f64) -> Option<RapidPeak> {
        let fastest =
            |window: usize| self.velocities(track, window).max_by(|a, b| a.norm().total_cmp(&b.norm()));
        let [long, short] = [window, window.min(self.window_of_noise(track, error))].map(fastest);
        let (long, short) = long.zip(short)?;
        let is_held = (1.0 - PLATEAU_TOLERANCE_RATIO) * short.norm() <= long.norm();
        Some(RapidPeak { velocity: if is_held { long } else { short }, length: self.length })
    }

    /// Returns the mean velocity over each `window` samples, each axis without its sign, mm/s.
    fn velocities(&self, track: &Track, window: usize) -> impl Iterator<Item = Vector> {
        let (first, last) = self.samples;
        let begins = first..(last + 1).saturating_sub(window);
        begins.map(move |begin| track.velocity_between(begin, begin + window).abs())
    }
}

/// Returns the velocity on a plateau of a rapid, each axis without its sign; `None` if the velocity is not
/// constant, or if its direction changes, as where two rapids blend at constant speed.
fn steady(velocities: [Vector; 3]) -> Option<Vector> {
    plateau(velocities.map(|velocity| velocity.norm()))?;
    (!turns(&velocities)).then(|| velocities[1].abs())
}

/// Returns `true` if the direction of successive velocities changes.
pub fn turns(velocities: &[Vector; 3]) -> bool {
    let within = velocities[1];
    let turns = |other: &Vector| MAX_TURN_RAD * within.norm() * other.norm() < within.cross(other).norm();
    velocities.iter().any(turns)
}

/// Returns the velocity `within`; `None` if it is not the same before and after.
pub fn plateau([before, within, after]: [f64; 3]) -> Option<f64> {
    let is_same = |other: f64| (other - within).abs() <= PLATEAU_TOLERANCE_RATIO * within;
    (0.0 < within && is_same(before) && is_same(after)).then_some(within)
}

/// Returns the velocities (mm/s) of rapids that a limit holds back: for each axis those of rapids mainly in its direction
/// that reach its highest velocity, to the part [`PLATEAU_TOLERANCE_RATIO`], if it moves along unequal lengths in them.
pub fn at_limit(peaks: &[RapidPeak]) -> Vec<Vector> {
    let of = |axis: usize| {
        let along = peaks.iter().filter(|peak| peak.velocity.iamax() == axis);
        let fastest = along.clone().map(|peak| peak.velocity[axis]).fold(0.0, f64::max);
        let tolerance = PLATEAU_TOLERANCE_RATIO * fastest;
        let reach: Vec<&RapidPeak> =
            along.filter(|peak| fastest - tolerance <= peak.velocity[axis]).collect();
        let lengths = reach.iter().map(|peak| peak.length[axis]);
        let shortest = lengths.clone().fold(f64::INFINITY, f64::min);
        let ratio_by_ramps = (lengths.fold(0.0, f64::max) / shortest).sqrt();
        let is_limited = MIN_RAMP_DIFFERENCE_RATIO * tolerance <= (ratio_by_ramps - 1.0) * fastest;
        reach.into_iter().filter(move |_| is_limited).map(|peak| peak.velocity).collect::<Vec<Vector>>()
    };
    (0..3).flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::toolpath::Point;

    /// A rapid in Z, every 2 ms, at a velocity (mm/s) over the time (s).
    fn rapid(seconds: f64, velocity: impl Fn(f64) -> f64) -> (Track, RapidMove) {
        const INTERVAL_S: f64 = 0.002;
        let time: Vec<f64> = (0..=(seconds / INTERVAL_S) as usize).map(|at| INTERVAL_S * at as f64).collect();
        let mut z = 0.0;
        let position: Vec<Point> = time
            .iter()
            .map(|time| {
                z += velocity(*time) * INTERVAL_S;
                Point::new(0.0, 0.0, z)
            })
            .collect();
        let length = Vector::new(0.0, 0.0, z);
        let rapid = RapidMove { samples: (0, time.len() - 1), length, feedrate: f64::INFINITY };
        (
            Track { time, position, recorded: [true; 3], noise: 1e-4, interval: INTERVAL_S, steps: [0.0; 3] },
            rapid,
        )
    }

    fn holds_a_velocity((track, rapid): &(Track, RapidMove)) -> bool {
        rapid.held(track, 4.0 * std::f64::consts::SQRT_2 * track.noise).next().is_some()
    }

    fn of(velocities: [[f64; 3]; 3]) -> Option<Vector> {
        steady(velocities.map(|[x, y, z]| Vector::new(x, y, z)))
    }

    #[test]
    fn ramps_that_meet_are_no_plateau() {
        let peak = [[90.0, 0.0, 0.0], [95.0, 0.0, 0.0], [90.0, 0.0, 0.0]];
        let ramp = [[80.0, 0.0, 0.0], [90.0, 0.0, 0.0], [100.0, 0.0, 0.0]];
        let stand = [[0.0; 3]; 3];
        for velocities in [peak, ramp, stand] {
            assert_eq!(of(velocities), None);
        }
        // A rapid in X blends with one in Z.
        assert_eq!(of([[80.0, 0.0, 60.0], [70.0, 0.0, 71.4], [60.0, 0.0, 80.0]]), None);
        assert_eq!(
            of([[-80.0, 60.0, 0.0], [-80.1, 60.0, 0.0], [-80.0, 60.1, 0.0]]),
            Some(Vector::new(80.1, 60.0, 0.0))
        );
    }

    #[test]
    fn a_rapid_may_hold_its_velocity_briefly_and_no_ramp_does() {
        let trapezoid = |time: f64| (730.0 * time.min(0.22 - time)).min(62.0);
        assert!(holds_a_velocity(&rapid(0.22, trapezoid)));
        let triangle = |time: f64| 730.0 * time.min(0.2 - time);
        assert!(!holds_a_velocity(&rapid(0.2, triangle)));
        for seconds in [0.05, 0.2, 1.0, 2.0] {
            let quarter = seconds / 4.0;
            let by_jerk = |time: f64| {
                let from_end = time.min(seconds - time) / quarter;
                let until_peak = 2.0 - from_end;
                60.0 * if from_end < 1.0 { from_end.powi(2) / 2.0 } else { 1.0 - until_peak.powi(2) / 2.0 }
            };
            assert!(!holds_a_velocity(&rapid(seconds, by_jerk)), "{seconds} s");
        }
        // A few samples have no windows.
        assert!(!holds_a_velocity(&rapid(0.004, |_| 62.0)));
    }

    #[test]
    fn a_ramp_reaches_nearly_its_peak_twice_and_a_jump_does_not() {
        let twice = |velocity: &dyn Fn(f64) -> f64| {
            let (track, rapid) = rapid(0.2, velocity);
            rapid.fastest_twice(&track, 10)[2]
        };
        let ramps = |time: f64| 730.0 * time.min(0.2 - time);
        let peak = 730.0 * 0.1;
        assert!((0.8 * peak..peak).contains(&twice(&ramps)), "{}", twice(&ramps));
        let jump = |time: f64| ramps(time) + if (time - 0.1).abs() < 0.0005 { 1500.0 } else { 0.0 };
        assert!(twice(&jump) < peak, "{}", twice(&jump));
        // Too short for two windows.
        let (track, short) = rapid(0.03, ramps);
        assert_eq!(short.fastest_twice(&track, 10), Vector::zeros());
    }

    /// Klipper holds the velocity of a move for half of its length, however short the move is.
    #[test]
    fn a_velocity_held_for_half_of_a_move_may_be_no_limit() {
        let exceeds = |velocity: f64, seconds: f64| {
            let (track, rapid) = rapid(seconds, |time| (730.0 * time.min(seconds - time)).min(velocity));
            let error = 4.0 * std::f64::consts::SQRT_2 * track.noise;
            let held: Vec<Vector> = rapid.held(&track, error).collect();
            assert!(!held.is_empty());
            rapid.exceeds_cruise_ratio(&track, &held, error)
        };
        // Of a ramp for v/A at either end, half of the length is cruised in the same time.
        assert!(!exceeds(62.0, 3.0 * 62.0 / 730.0));
        assert!(exceeds(62.0, 5.0 * 62.0 / 730.0));
        // However few samples there are.
        assert!(!exceeds(29.2, 3.0 * 29.2 / 730.0));
        assert!(exceeds(29.2, 5.0 * 29.2 / 730.0));
    }

    /// grbl runs segments of 10 ms at constant velocity.
    #[test]
    fn a_few_samples_of_a_rapid_are_none() {
        let (track, rapid) = rapid(0.2, |time| 300.0 * time.min(0.2 - time));
        assert!(rapid.is_covered(&track));
        let beginning = RapidMove { samples: (0, 6), ..rapid };
        assert!(!beginning.is_covered(&track));
    }

    fn limits_of(peaks: &[([f64; 2], f64)]) -> Vec<[f64; 2]> {
        let peak = |([x, z], seconds): &([f64; 2], f64)| {
            let velocity = Vector::new(*x, 0.0, *z);
            RapidPeak { velocity, length: *seconds * velocity }
        };
        let limits = at_limit(&peaks.iter().map(peak).collect::<Vec<RapidPeak>>());
        limits.into_iter().map(|velocity| [velocity.x, velocity.z]).collect()
    }

    #[test]
    fn rapids_of_two_lengths_that_are_equally_fast_show_a_limit() {
        let (short, long) = ([0.0, 61.96], [0.0, 62.0]);
        assert_eq!(limits_of(&[(short, 0.11), (long, 0.14), ([0.0, 27.0], 0.05)]), [short, long]);
        // In whichever direction the axis moves at its limit.
        let (straight, diagonal) = ([60.0, 0.0], [60.0, 15.0]);
        assert_eq!(limits_of(&[(straight, 0.1), (diagonal, 0.2)]), [straight, diagonal]);
    }

    #[test]
    fn a_limit_that_two_rapids_reach_for_a_moment_is_not_averaged_with_their_ramps() {
        // The second rapid begins in a blend, so that LinuxCNC plans it at half of the acceleration.
        let ramps = [(1480.0_f64, 0.09), (740.0_f64, 0.166)];
        let peaks = ramps.map(|(acceleration, seconds)| {
            let velocity = |time: f64| (acceleration * time.min(seconds - time)).clamp(0.0, 60.0);
            let (track, rapid) = rapid(seconds, velocity);
            rapid.peak(&track, 10, 4.0 * std::f64::consts::SQRT_2 * track.noise).expect("samples")
        });
        let limits = at_limit(&peaks);
        assert!(!limits.is_empty());
        assert!(
            limits.iter().all(|limit| (limit.z / 60.0 - 1.0).abs() < PLATEAU_TOLERANCE_RATIO),
            "{limits:?}"
        );
    }

    #[test]
    fn ramps_show_no_limit() {
        let by_acceleration = |length: f64| (730.0 * length).sqrt();
        let by_filter = |length: f64| length / 0.2;
        for ramp in [by_acceleration as fn(f64) -> f64, by_filter] {
            let lengths = (0..40).map(|at| 5.0 + 0.03 * f64::from(at));
            let peaks: Vec<([f64; 2], f64)> =
                lengths.map(|length| ([0.0, ramp(length)], length / ramp(length))).collect();
            assert!(limits_of(&peaks).is_empty());
        }
    }

    #[test]
    fn one_length_shows_no_limit() {
        assert!(limits_of(&[([0.0, 62.0], 0.11), ([0.0, 62.0], 0.11)]).is_empty());
    }

    #[test]
    fn what_is_equally_fast_below_the_highest_velocity_is_at_no_limit() {
        assert!(limits_of(&[([0.0, 45.6], 0.1), ([0.0, 45.6], 0.2), ([0.0, 60.0], 0.2)]).is_empty());
    }
}
