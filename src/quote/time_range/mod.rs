//! The range of a program's time on a machine that was calibrated on other programs.
//!
//! ```text
//! half of the range = √(r² + s²) + Σ U · (time of an unshown feature / time of the motion)
//! ```
//!
//! r is the error on other programs within the features shown, from the machine file; s is the relative change
//! of the time if all accelerations are lower by [`NORMAL_QUANTILE_95`] standard deviations. Slow feeds have ramps so short that
//! they show accelerations only roughly, and a program that stops at each block consists of ramps. U is r times
//! [`UNSHOWN_ERROR_RATIO`] or [`UNSHOWN_FEED_ERROR_RATIO`]. Features that the calibrating programs did not show are
//! corners that turn more, arcs and blocks of other size, faster feeds, and faster rapids of an axis. Most
//! features are measured by length over feedrate, as is the motion then; around a corner at most [`CORNER_REACH_S`] counts. Rapids,
//! M-words and differences of two simulations are measured by simulated times, as is the motion then.
//!
//! If the runs show no corner at all, the corner law is unknown: a corner may cost anything from no time to a full
//! stop, and an arc twice as long as at its feedrate if they show no arc either. Each end of a segment of length L at
//! a corner may then lose half of t(v) + D − L/F, with t as below for the length and acceleration of the segment, F
//! its feedrate, v the velocity that it reaches, and D the filter delay.
//!
//! If the recorded ramps do not have the shape of the simulated ones, beyond [`MAX_RAMP_MISFIT`](crate::machine::MAX_RAMP_MISFIT), the machine follows
//! another law than its file, which was fitted to the programs of the calibration alone: then U =
//! [`UNKNOWN_LAW_ERROR_RATIO`] for all of the time.
//!
//! If no calibrating program contains an M-word, its time comes from the machine file before the calibration. The true
//! time may be between nothing and twice as much: U = 1, and both times of the fraction include the time of the word.
//!
//! If the runs do not show for which override the control plans its corners, the largest one that they allow may make the
//! corners of a program faster; and an acceleration or a jerk that the calibration assumed may be [`ASSUMED_ACCELERATION_RATIO`]
//! times as high, or as low as the runs allow. If no run has an arc, or none whose chords would slow it if they were longer or
//! shorter, the chords may be so ([`CHORD_ERROR_RATIOS`]). If all rapids of the runs hold one F, that may be their rate. Then the
//! differences between these cycle times add to the range.
//!
//! A feed is faster if it moves an axis faster than any move of the runs, feed or rapid: if the runs recorded
//! positions, an axis can cut as fast as it moved in rapid. A rapid is faster if an axis whose full rapid
//! rate no run showed travels a distance w (mm) that is long enough to exceed V (mm/s), its highest velocity
//! in the runs, or half the velocity of the fastest axis if larger. The rapid rate of the axis may be as low as V, or is V
//! at least if the machine file has assumed a lower one, so that with its acceleration A (mm/s²)
//!
//! ```text
//! U = |t(V) / t(R) − 1|,  t(v) = w / v + v / A        R velocity reached in the simulation, at most √(A w)
//! ```

use crate::machine::{ArcChords, CHORD_ERROR_RATIOS, CalibratedOn, Extent, Machine};
use crate::quote::shares::programmed;
use crate::simulation::feed::limits::{acceleration, largest_share, rapid_feedrate, requested_feedrate};
use crate::simulation::feed::{FeedPlan, stop_time};
use crate::simulation::ordered::sort_by_number;
use crate::simulation::simulate;
use crate::simulation::toolpath::{Curve, Motion, Segment, Stop, Toolpath};

/// Ratio of the additional error of features that were not shown to that of others. Faster feeds have longer ramps, whose
/// acceleration slow feeds hardly show. The parameters of the other laws remain valid beyond the features shown if the
/// calibration found the family of the control. Set on the two mills of docs/diagnosis.md: beyond r, their errors are up to
/// 10 r of the time at faster feeds.
const UNSHOWN_FEED_ERROR_RATIO: f64 = 10.0;
const UNSHOWN_ERROR_RATIO: f64 = 2.5;
/// Ratio of an assumed acceleration to the true one, or of the true one to it, that nine in ten do not exceed: of 13 that
/// calibrations of LinuxCNC assumed, twelve are within 1.15, and one is 1.3 times too high.
const ASSUMED_ACCELERATION_RATIO: f64 = 1.25;
/// Quantile of the normal distribution below which 95 % lie: nine in ten are within as many standard deviations.
pub const NORMAL_QUANTILE_95: f64 = 1.645;
/// Largest relative change of a motion time, divided by the relative change of all accelerations: ramps from rest to rest
/// last in proportion to 1/√a.
const MAX_TIME_TO_ACCELERATION_CHANGE_RATIO: f64 = 0.5;
/// Relative error of other programs that nine in ten do not exceed on a machine of another law: 13 pairs of programs
/// of two such planners (seed 71) are off by 17 % in the median and by 41 % at most.
pub const UNKNOWN_LAW_ERROR_RATIO: f64 = 0.4;
/// Time on either side of a corner that the corner affects, s.
const CORNER_REACH_S: f64 = 0.1;
/// Least turn of a corner, rad.
const MIN_TURN_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Least difference of turns beyond the largest one shown, rad.
const MIN_TURN_EXCESS_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Ratio of radii or lengths from which on they count as of other size.
const MIN_SIZE_RATIO: f64 = 2.0;
/// Ratio of feedrates from which on one counts as faster.
const MIN_FASTER_RATIO: f64 = 1.25;
/// Rounding error of the velocity at which an axis limits a rapid, as a part of it.
const RATE_TOLERANCE_RATIO: f64 = 1e-9;
/// Ratio of the lengths of rapids from which on one counts as longer.
const MIN_LONGER_RATIO: f64 = 1.5;
/// Least time of a block that is not short, s: length over feedrate.
const MAX_SHORT_BLOCK_S: f64 = 0.1;

/// Least time of a program, s.
const MIN_WHOLE_S: f64 = 1e-9;
/// Largest ratio of an independent error to the error on other programs at which it is negligible: it widens the range by a
/// hundredth.
const MAX_NEGLIGIBLE_ERROR_RATIO: f64 = 0.14;

/// M-word of the end of a program, which every program has, written or not.
const PROGRAM_END: u32 = 30;

/// A feature of a program that a calibration did not show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum UnshownFeature {
    /// Corners that turn more.
    Corners,
    /// Arcs of other radii.
    Arcs,
    /// Shorter blocks.
    Blocks,
    /// Faster feeds.
    Feeds,
    /// Corners planned for a larger override.
    Overrides,
    /// Accelerations that the calibration assumed.
    Accelerations,
    /// Accelerations that the runs show roughly.
    RoughAccelerations,
    /// Faster rapids.
    Rapids,
    /// Rapids at programmed feedrates.
    RapidFeedrates,
    /// M-words.
    MWords,
    /// Ramps by another law.
    Ramps,
}

impl UnshownFeature {
    /// All features.
    pub const ALL: [UnshownFeature; 11] = [
        UnshownFeature::Corners,
        UnshownFeature::Arcs,
        UnshownFeature::Blocks,
        UnshownFeature::Feeds,
        UnshownFeature::Overrides,
        UnshownFeature::Accelerations,
        UnshownFeature::RoughAccelerations,
        UnshownFeature::Rapids,
        UnshownFeature::RapidFeedrates,
        UnshownFeature::MWords,
        UnshownFeature::Ramps,
    ];

    /// Returns the additional error of the time of the feature, as a part of that time, if features that were shown
    /// have the relative error `shown`.
    fn error(self, shown: f64) -> f64 {
        let ratio =
            if self == UnshownFeature::Feeds { UNSHOWN_FEED_ERROR_RATIO } else { UNSHOWN_ERROR_RATIO };
        (ratio * shown).min(MAX_UNSHOWN_ERROR)
    }

    /// Returns the words for people.
    pub fn words(self) -> &'static str {
        match self {
            UnshownFeature::Corners => "corners that turn more",
            UnshownFeature::Arcs => "arcs of other radii",
            UnshownFeature::Blocks => "shorter blocks",
            UnshownFeature::Feeds => "faster feeds",
            UnshownFeature::Overrides => "corners that the control may plan for a larger override",
            UnshownFeature::Accelerations => {
                "ramps at accelerations or jerks that the calibration had to assume"
            }
            UnshownFeature::RoughAccelerations => "ramps at accelerations that the calibration shows roughly",
            UnshownFeature::Rapids => "faster rapids",
            UnshownFeature::RapidFeedrates => "rapids, which may run at F or at a rate",
            UnshownFeature::MWords => "M words such as a tool change",
            UnshownFeature::Ramps => "ramps, which this machine runs by another law than its file",
        }
    }
}

/// A symmetric range around the motion time.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeRange {
    /// Half of the range, as a part of the time.
    pub ratio: f64,
    /// Features that were not shown, with their part of the time, the largest first.
    pub unshown: Vec<(UnshownFeature, f64)>,
}

/// Returns the extents of the features that programs show.
pub fn features_of<'a>(toolpaths: impl IntoIterator<Item = &'a Toolpath>) -> CalibratedOn {
    let mut asked = CalibratedOn::default();
    let mut m_codes = vec![PROGRAM_END];
    for toolpath in toolpaths {
        for code in toolpath.stops.iter().filter_map(|stop| stop.cause.m_code()) {
            if !m_codes.contains(&code) {
                m_codes.push(code);
            }
        }
        for segment in 0..toolpath.segments.len() {
            add(&mut asked, toolpath, segment);
        }
        if !is_among(&asked.travels, toolpath) {
            asked.travels.push(travel(toolpath));
        }
    }
    sort_by_number(&mut m_codes, |code| f64::from(*code));
    asked.m_codes = Some(m_codes);
    asked
}

/// Largest relative difference between travels that identify one program.
const EQUAL_TRAVEL_RATIO: f64 = 1e-4;

/// Returns `true` if one of these travels, along the path and in each axis, equals the program's travel.
fn is_among(travels: &[[f64; 4]], toolpath: &Toolpath) -> bool {
    let own = travel(toolpath);
    let apart = EQUAL_TRAVEL_RATIO * own[0];
    travels.iter().any(|travel| travel.iter().zip(own).all(|(travel, own)| (travel - own).abs() <= apart))
}

/// Returns the travel of a program along the path and along each axis, from end to end of its segments, mm.
fn travel(toolpath: &Toolpath) -> [f64; 4] {
    (0..toolpath.segments.len()).fold([0.0; 4], |sum, segment| {
        let [x, y, z] = axis_travels(toolpath, segment);
        let of = [toolpath.segments.length(segment), x, y, z];
        [0, 1, 2, 3].map(|at| sum[at] + of[at])
    })
}

/// Returns the possible error of the time of a program's motion, as a part of it, on a machine calibrated on other
/// programs; `None` for programs of the calibration, and on machines without this value.
pub fn error_beyond_calibration(toolpath: &Toolpath, machine: &Machine) -> Option<f64> {
    let travels = &machine.calibrated_on.travels;
    if travels.is_empty() || is_among(travels, toolpath) {
        return None;
    }
    let motion_time = simulate(toolpath, machine).motion_time();
    of_motion(toolpath, machine, motion_time).map(|found| found.range().ratio)
}

fn add(asked: &mut CalibratedOn, toolpath: &Toolpath, segment: usize) {
    match toolpath.segments.motion(segment) {
        Motion::Rapid { .. } => {
            let way = axis_travels(toolpath, segment);
            let longest = asked.rapids.get_or_insert([0.0; 3]);
            longest.iter_mut().zip(way).for_each(|(longest, way)| *longest = longest.max(way));
        }
        Motion::Feed { feedrate } => {
            asked.feedrates = asked.feedrates.with(feedrate);
            match toolpath.segments.curve(segment) {
                Curve::Arc(arc) => asked.radii = asked.radii.with(arc.mean_radius()),
                Curve::Line => asked.blocks = asked.blocks.with(toolpath.segments.length(segment)),
            }
            if let Some(turn) = turn_after(toolpath, segment) {
                asked.turns = asked.turns.with(turn);
            }
        }
    }
}

/// Returns the travel of each axis along a segment, mm.
fn axis_travels(toolpath: &Toolpath, segment: usize) -> [f64; 3] {
    let way = toolpath.segments.direction(segment) * toolpath.segments.length(segment);
    [way.x.abs(), way.y.abs(), way.z.abs()]
}

/// Returns the turn to the next feed move, rad; `None` if there is no corner.
fn turn_after(toolpath: &Toolpath, segment: usize) -> Option<f64> {
    let next = segment + 1;
    let is_feed = |at: usize| !toolpath.segments.motion(at).is_rapid();
    if toolpath.segments.len() <= next || !is_feed(segment) || !is_feed(next) {
        return None;
    }
    let (_, [_, end]) = toolpath.segments.length_and_tangents(segment);
    let (_, [begin, _]) = toolpath.segments.length_and_tangents(next);
    Some(end.dot(&begin).clamp(-1.0, 1.0).acos()).filter(|turn| MIN_TURN_RAD <= *turn)
}

/// A part of a program that was not shown.
struct Unshown {
    feature: UnshownFeature,
    /// Time of the part, s.
    lasts: f64,
    /// Largest error of that time, as a part of it.
    error: f64,
    /// Time of the whole program that `lasts` is compared with.
    whole: Whole,
}

/// A time of a whole program.
#[derive(Clone, Copy)]
enum Whole {
    /// Length over feedrate.
    Programmed,
    /// Simulated time.
    Simulated,
}

/// Largest error of the time of a feature that was not shown, as a part of that time.
const MAX_UNSHOWN_ERROR: f64 = 1.0;
/// Least velocity of an axis relative to the fastest one of the same machine.
const MIN_AXIS_RATIO: f64 = 0.5;

/// Returns the largest velocity of each axis along a segment at its requested feedrate, mm/s.
fn axis_velocities(segment: &Segment, machine: &Machine) -> [f64; 3] {
    (requested_feedrate(segment, machine) * largest_share(segment)).into()
}

/// Returns the highest velocity that a move over the distance `way` (mm) from rest to rest reaches, at most
/// `velocity`, mm/s.
fn reached_velocity(way: f64, velocity: f64, acceleration: f64) -> f64 {
    velocity.min((way * acceleration).sqrt())
}

/// Returns the time of a move over the distance `way` (mm) from rest to rest that reaches the velocity
/// `reached` (mm/s), s.
fn rest_to_rest_time(way: f64, reached: f64, acceleration: f64) -> f64 {
    way / reached + reached / acceleration
}

/// Returns the part of a rapid in which an axis whose rate was assumed is faster than in any move of the runs, or
/// slower than they show it to be; `None` if there is none.
fn faster_rapid(segment: &Segment, machine: &Machine, shown: [f64; 3]) -> Option<Unshown> {
    let velocities = axis_velocities(segment, machine);
    let of_others = MIN_AXIS_RATIO * shown.into_iter().fold(0.0, f64::max);
    let of_axis = |axis: usize| {
        let shown = shown[axis].max(of_others);
        let acceleration = machine.axes[axis].acceleration;
        let way = (segment.end[axis] - segment.start[axis]).abs();
        let reached = reached_velocity(way, velocities[axis], acceleration);
        let lasts = |velocity: f64| rest_to_rest_time(way, velocity, acceleration);
        // The rate may be as low as shown, or be that if the machine file has a lower one.
        let possible = reached_velocity(way, shown, acceleration);
        let error =
            if 0.0 < shown { (lasts(possible) / lasts(reached) - 1.0).abs() } else { MAX_UNSHOWN_ERROR };
        // A higher rate of an axis that others hold back makes the rapid no faster.
        let may_differ = possible < reached || reached < possible && holds_back(axis, segment, machine);
        may_differ.then(|| Unshown {
            feature: UnshownFeature::Rapids,
            lasts: lasts(reached),
            error: error.min(MAX_UNSHOWN_ERROR),
            whole: Whole::Simulated,
        })
    };
    let is_assumed = |axis: &usize| machine.calibrated_on.assumed_rapids[*axis];
    // An axis at rest has no time to be off in.
    let is_moving = |axis: &usize| segment.start[*axis] != segment.end[*axis];
    let all = (0..3).filter(is_assumed).filter(is_moving).filter_map(of_axis);
    all.max_by(|one, other| (one.error * one.lasts).total_cmp(&(other.error * other.lasts)))
}

/// Returns `true` if the rate of an axis limits a rapid.
fn holds_back(axis: usize, segment: &Segment, machine: &Machine) -> bool {
    let velocity = rapid_feedrate(segment, machine) * largest_share(segment)[axis];
    machine.axes[axis].rapid <= (1.0 + RATE_TOLERANCE_RATIO) * velocity
}

/// Returns `true` if a segment moves an axis faster than any move of the runs.
fn has_faster_axis(segment: &Segment, machine: &Machine, shown: [f64; 3]) -> bool {
    let velocities = axis_velocities(segment, machine);
    velocities.iter().zip(shown).any(|(velocity, shown)| MIN_FASTER_RATIO * shown < *velocity)
}

/// Returns the part of a segment, which takes the time `lasts` (s), next to corners that turn more than any
/// corner of the runs.
fn unshown_corners(toolpath: &Toolpath, machine: &Machine, segment: usize, lasts: f64) -> Unshown {
    let turns = machine.calibrated_on.turns;
    let is_sharper = |end: &usize| {
        turn_after(toolpath, *end).is_some_and(|turn| turns.is_below(turn - MIN_TURN_EXCESS_RAD))
    };
    let ends =
        [segment.checked_sub(1), Some(segment)].into_iter().flatten().filter(is_sharper).count() as f64;
    let lasts_at_corners = lasts.min(CORNER_REACH_S * ends);
    let error = match turns {
        Extent(None) if 0.0 < lasts_at_corners => {
            let loss = 0.5 * ends * stopping_loss(&toolpath.segments.at(segment), machine);
            (loss / lasts_at_corners).min(MAX_UNSHOWN_ERROR)
        }
        _ => UnshownFeature::Corners.error(machine.calibrated_on.range.unwrap_or(0.0)),
    };
    Unshown { feature: UnshownFeature::Corners, lasts: lasts_at_corners, error, whole: Whole::Programmed }
}

/// Returns by how much the time of a program would change at other overrides, accelerations, chords and feedrates of rapids that
/// the runs allow.
fn at_other_allowed_values(toolpath: &Toolpath, machine: &Machine) -> Vec<Unshown> {
    let on = &machine.calibrated_on;
    let planned_for = |max_override: f64| {
        let mut other = machine.clone();
        other.interpolator.max_override = max_override;
        other
    };
    let least = on.least_accelerations.unwrap_or_default();
    let least_jerks = on.least_jerks.unwrap_or_default();
    let accelerating = |ratio: f64| {
        let mut other = machine.clone();
        for axis in (0..3).filter(|axis| on.assumed_accelerations[*axis]) {
            other.axes[axis].acceleration = (ratio * other.axes[axis].acceleration).max(least[axis]);
        }
        for axis in (0..3).filter(|axis| 0.0 < least_jerks[*axis]) {
            other.axes[axis].jerk = (ratio * other.axes[axis].jerk).max(least_jerks[axis]);
        }
        other
    };
    let has_chords = machine.interpolator.arc_chords != ArcChords::Whole
        && toolpath.segments.iter().any(|segment| segment.curve != Curve::Line);
    let ratios: &[f64] = if on.radii == Extent(None) { &CHORD_ERROR_RATIOS } else { &on.other_chord_ratios };
    let ratios = ratios.iter().filter(|_| has_chords);
    let chords: Vec<Machine> = ratios.map(|ratio| machine.with_scaled_chords(*ratio)).collect();
    let overrides: Vec<Machine> = on.largest_override.map(planned_for).into_iter().collect();
    let accelerations = match on.assumed_accelerations.contains(&true) || on.least_jerks.is_some() {
        true => [1.0 / ASSUMED_ACCELERATION_RATIO, ASSUMED_ACCELERATION_RATIO].map(accelerating).to_vec(),
        false => Vec::new(),
    };
    let at_rate = |feedrate: f64| {
        let mut other = machine.clone();
        other.rapid.at_feedrate = false;
        other.rapid.feedrate = other.rapid.feedrate.min(feedrate);
        other
    };
    let is_doubtful = machine.rapid.at_feedrate && toolpath.has_rapid();
    let at_feedrate = on.only_rapid_feedrate.filter(|_| is_doubtful);
    let rapids: Vec<Machine> = at_feedrate.map(at_rate).into_iter().collect();
    if overrides.is_empty() && accelerations.is_empty() && chords.is_empty() && rapids.is_empty() {
        return Vec::new();
    }
    let time = |machine: &Machine| simulate(toolpath, machine).cycle_time();
    let own = time(machine);
    let unshown = |feature, others: Vec<Machine>| {
        let lasts = others.iter().map(|other| (time(other) - own).abs()).fold(0.0, f64::max);
        Unshown { feature, lasts, error: 1.0, whole: Whole::Simulated }
    };
    vec![
        unshown(UnshownFeature::Overrides, overrides),
        unshown(UnshownFeature::Accelerations, accelerations),
        unshown(UnshownFeature::Arcs, chords),
        unshown(UnshownFeature::RapidFeedrates, rapids),
    ]
}

/// Returns by how much longer a program would take, at its own tolerances, with accelerations that are lower by
/// [`NORMAL_QUANTILE_95`] standard deviations, s; 0 if that is certainly at most a part `negligible` of its time.
fn at_lower_accelerations(toolpath: &Toolpath, machine: &Machine, negligible: f64) -> f64 {
    let lower_by = machine
        .calibrated_on
        .acceleration_deviations
        .unwrap_or_default()
        .map(|deviation| NORMAL_QUANTILE_95 * deviation);
    let largest = lower_by.into_iter().fold(0.0, f64::max);
    if MAX_TIME_TO_ACCELERATION_CHANGE_RATIO * largest <= negligible {
        return 0.0;
    }
    let mut lower = machine.clone();
    lower.path.acceleration /= 1.0 + largest;
    lower.axes.iter_mut().zip(lower_by).for_each(|(axis, ratio)| axis.acceleration /= 1.0 + ratio);
    let [own, other] = [machine, &lower].map(|machine| simulate(toolpath, machine).cycle_time());
    (other - own).max(0.0)
}

/// Returns the time by which a segment takes longer from rest to rest than at its feedrate, s.
fn stopping_loss(segment: &Segment, machine: &Machine) -> f64 {
    let (feedrate, acceleration) = (requested_feedrate(segment, machine), acceleration(segment, machine));
    let reached = reached_velocity(segment.length, feedrate, acceleration);
    let from_rest_to_rest = rest_to_rest_time(segment.length, reached, acceleration);
    from_rest_to_rest + machine.interpolator.filter_delay(feedrate) - segment.length / feedrate
}

/// Returns the part of a segment, which takes the time `lasts` (s), that the runs did not show; `None` if
/// they showed all of it.
fn unshown(toolpath: &Toolpath, machine: &Machine, segment: usize, lasts: f64) -> Option<Unshown> {
    let on = &machine.calibrated_on;
    if let (Motion::Rapid { .. }, Some(shown)) = (toolpath.segments.motion(segment), on.velocities) {
        return faster_rapid(&toolpath.segments.at(segment), machine, shown);
    }
    let feature = unshown_feature(toolpath, machine, segment)?;
    let shows_no_turn = on.turns == Extent(None) && on.radii == Extent(None);
    let error = match feature {
        UnshownFeature::Arcs if shows_no_turn => MAX_UNSHOWN_ERROR,
        _ => feature.error(on.range.unwrap_or(0.0)),
    };
    Some(Unshown { feature, lasts, error, whole: Whole::Programmed })
}

/// Returns a feature of a segment that the runs did not show; `None` if they showed all of them.
fn unshown_feature(toolpath: &Toolpath, machine: &Machine, segment: usize) -> Option<UnshownFeature> {
    let on = &machine.calibrated_on;
    let length = toolpath.segments.length(segment);
    let is_faster = |feedrate: f64| {
        on.feedrates.is_below(feedrate / MIN_FASTER_RATIO)
            && on
                .velocities
                .is_none_or(|shown| has_faster_axis(&toolpath.segments.at(segment), machine, shown))
    };
    match (toolpath.segments.motion(segment), toolpath.segments.curve(segment)) {
        (Motion::Rapid { .. }, _) => {
            let longest = on.rapids.unwrap_or_default();
            let is_longer =
                |(way, longest): (f64, f64)| MIN_LONGER_RATIO * longest < way && 0.5 * length < way;
            axis_travels(toolpath, segment)
                .into_iter()
                .zip(longest)
                .any(is_longer)
                .then_some(UnshownFeature::Rapids)
        }
        (Motion::Feed { feedrate }, _) if is_faster(feedrate) => Some(UnshownFeature::Feeds),
        (Motion::Feed { .. }, Curve::Arc(arc)) => {
            let radius = arc.mean_radius();
            let is_known =
                !on.radii.is_below(radius / MIN_SIZE_RATIO) && !on.radii.is_above(radius * MIN_SIZE_RATIO);
            (!is_known).then_some(UnshownFeature::Arcs)
        }
        (Motion::Feed { feedrate }, Curve::Line) => {
            let is_shorter =
                length < MAX_SHORT_BLOCK_S * feedrate && on.blocks.is_above(MIN_SIZE_RATIO * length);
            is_shorter.then_some(UnshownFeature::Blocks)
        }
    }
}

/// The range of a program's time, gathered part by part.
struct Gathered {
    /// Error of the time, as a part of it.
    ratio: f64,
    /// Length over feedrate of the program, s.
    programmed_time: f64,
    /// Simulated time, s.
    simulated_time: f64,
    /// Part of the time of each feature.
    shares: [f64; UnshownFeature::ALL.len()],
}

impl Gathered {
    fn add(&mut self, Unshown { feature, lasts, error, whole }: Unshown) {
        let whole = match whole {
            Whole::Programmed => self.programmed_time,
            Whole::Simulated => self.simulated_time,
        };
        let share = lasts / whole.max(MIN_WHOLE_S);
        self.shares[feature as usize] += share;
        self.ratio += error * share;
    }

    /// Adds the deviations of the accelerations, which are independent of the error on other programs.
    fn add_rough_accelerations(&mut self, toolpath: &Toolpath, machine: &Machine) {
        let own = self.ratio;
        let longer = at_lower_accelerations(toolpath, machine, MAX_NEGLIGIBLE_ERROR_RATIO * own);
        let wider = own.hypot(longer / self.simulated_time.max(MIN_WHOLE_S)) - own;
        self.ratio += wider;
        self.shares[UnshownFeature::RoughAccelerations as usize] += wider;
    }

    fn range(self) -> TimeRange {
        let shares = UnshownFeature::ALL.into_iter().zip(self.shares);
        let mut unshown: Vec<(UnshownFeature, f64)> = shares.filter(|(_, share)| 0.0 < *share).collect();
        sort_by_number(&mut unshown, |one| -one.1);
        TimeRange { ratio: self.ratio, unshown }
    }
}

/// Returns the range of a program's motion that takes the time `simulated_time` (s), of which the range is a part; `None` on a
/// machine that was not calibrated.
fn of_motion(toolpath: &Toolpath, machine: &Machine, simulated_time: f64) -> Option<Gathered> {
    let ratio = machine.calibrated_on.range?;
    let programmed_times: Vec<f64> =
        toolpath.segments.iter().map(|segment| segment.length / programmed(&segment, machine)).collect();
    let programmed_time = programmed_times.iter().sum();
    let mut found = Gathered { ratio, programmed_time, simulated_time, shares: Default::default() };
    found.add_rough_accelerations(toolpath, machine);
    for (segment, lasts) in programmed_times.into_iter().enumerate() {
        let unshown = unshown(toolpath, machine, segment, lasts)
            .unwrap_or_else(|| unshown_corners(toolpath, machine, segment, lasts));
        found.add(unshown);
    }
    if machine.calibrated_on.misfit_of_unknown_law().is_some() {
        found.add(Unshown {
            feature: UnshownFeature::Ramps,
            lasts: programmed_time,
            error: UNKNOWN_LAW_ERROR_RATIO,
            whole: Whole::Programmed,
        });
    }
    at_other_allowed_values(toolpath, machine).into_iter().for_each(|unshown| found.add(unshown));
    Some(found)
}

/// Returns the range of a program with its plan; `None` on a machine that was not calibrated.
pub fn range(toolpath: &Toolpath, machine: &Machine, plan: &FeedPlan) -> Option<TimeRange> {
    let mut found = of_motion(toolpath, machine, plan.cycle_time())?;
    let shown = &machine.calibrated_on.m_codes;
    let is_unshown = |stop: &&Stop| {
        stop.cause.m_code().zip(shown.as_ref()).is_some_and(|(code, shown)| !shown.contains(&code))
    };
    for stop in toolpath.stops.iter().filter(is_unshown) {
        found.add(Unshown {
            feature: UnshownFeature::MWords,
            lasts: stop_time(stop, machine),
            error: MAX_UNSHOWN_ERROR,
            whole: Whole::Simulated,
        });
    }
    Some(found.range())
}

#[cfg(test)]
mod tests;
