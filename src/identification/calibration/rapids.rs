//! Velocity limits of axes: the recorded velocity where it is constant for a while.
//!
//! A rapid that shows a plateau was as fast as the machine allows; one that speeds up and slows down without a
//! plateau shows only that the machine is no slower. On a plateau, the mean velocities over three successive
//! windows on one rapid segment are equal to the part [`PLATEAU_TOLERANCE_RATIO`]; those over two windows are
//! also equal where a ramp up meets a ramp down in the middle.
//!
//! A line that is cut more slowly than programmed, at a constant velocity, is held back by the axis that moves
//! furthest, if that axis is nowhere faster where it cuts.

use crate::identification::alignment::{Fix, Track};
use crate::identification::calibration::rapid_feedrates::{RapidFeedrates, is_at_feedrate};
use crate::identification::calibration::rapid_moves::{
    MAX_VELOCITY_DIFFERENCE_RATIO, PLATEAU_TOLERANCE_RATIO, RapidVelocity, at_limit, plateau, rapid_moves,
};
use crate::identification::fit::Run;
use crate::machine::{Junction, Machine, Planner};
use crate::simulation::feed::limits;
use crate::simulation::ordered::sort_by_number;
use crate::simulation::toolpath::{Curve, Segment, Vector};

/// Window over which a velocity is taken, s.
const WINDOW_S: f64 = 0.02;
/// Least number of samples in a window.
const MIN_SAMPLES: usize = 4;
/// Ratio of a velocity to another one below which it is slower.
const MAX_SLOWER_RATIO: f64 = 1.0 - MAX_VELOCITY_DIFFERENCE_RATIO;
/// Least number of moments at which a recorded velocity is met for it to be a limit.
const MIN_VISITS: usize = 4;
/// Least time between two such moments, s.
const MIN_VISIT_INTERVAL_S: f64 = 0.2;
/// Least number of rapids that show a velocity: a jump of the recorder may be in one.
const MIN_RAPIDS: usize = 2;
/// Largest error of a velocity by noise, in standard deviations.
const MAX_NOISE_DEVIATIONS: f64 = 4.0;
/// The rates of rapids that plateaus show, mm/s; `None` if there is no plateau.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RapidRates {
    /// Rate along the path.
    pub path: Option<f64>,
    /// Rate of each axis.
    pub axes: [Option<f64>; 3],
    /// `true` for each axis whose rate may be no limit: in each diagonal that shows it, another axis may have held it
    /// back, unless axes are alike; or rapids of one length hold it so briefly that a minimum cruise ratio may be the reason; or
    /// no plateau shows it.
    pub guessed_axes: [bool; 3],
}

/// The velocities of rapids and feed moves that runs show, mm/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RapidPlateaus {
    /// Rates of a control that runs rapids at separate rates.
    pub rates: RapidRates,
    /// Rates of a control that runs rapids at the programmed feedrate. That is no limit of the machine, nor is what a minimum
    /// cruise ratio may explain: such a control is usually Klipper.
    pub rates_below_feedrate: RapidRates,
    /// Evidence of the feedrate of rapids.
    pub feedrates: RapidFeedrates,
    /// Velocities of each axis in rapids, whether they are on a plateau or not.
    pub reached: [ReachedVelocity; 3],
    /// Velocity of each axis on lines that are cut: first on lines where the axis was held back below its
    /// programmed velocity, then on all others.
    pub cut: [[Option<f64>; 3]; 2],
    /// Velocity along lines that are cut at one height, as in `cut`.
    pub cut_along: [Option<f64>; 2],
    /// Highest velocity along the path that feed moves reached repeatedly for a window, mm/s; 0 if there is none.
    pub fastest_along: f64,
    /// Highest programmed velocity of feed moves along the path, mm/s.
    pub asked_along: f64,
    /// Highest velocity that each axis reached repeatedly for a window in feed moves of any form, mm/s; 0 if there
    /// is none.
    pub fastest_cut: [f64; 3],
    /// Highest programmed velocity of each axis in feed moves, mm/s.
    pub fastest_asked: [f64; 3],
}

/// The velocities that an axis reaches in rapids over a window, mm/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReachedVelocity {
    /// Highest velocity.
    pub fastest: f64,
    /// Highest velocity that noise cannot explain: the axis held it on a plateau, or reached it in [`MIN_RAPIDS`]
    /// rapids or twice in one.
    pub certain: f64,
}

impl RapidRates {
    /// Returns the rates of the machine that hold rapids back, without their override. Those that a minimum cruise ratio may
    /// explain are guessed rates or, unless `guesses_count`, none.
    fn of<'a>(rapids: impl Iterator<Item = &'a RapidVelocity>, guesses_count: bool) -> RapidRates {
        let (mut all, mut peaks) = (Vec::new(), Vec::new());
        // Highest velocity of each axis that no minimum cruise ratio explains.
        let mut limited = Vector::zeros();
        for RapidVelocity { held, exceeds_cruise_ratio, peak, override_ratio, .. } in rapids {
            let at_full_rate = held.iter().map(|held| held / *override_ratio);
            if *exceeds_cruise_ratio {
                limited = at_full_rate.clone().fold(limited, |limited, held| limited.sup(&held));
            }
            if *exceeds_cruise_ratio || guesses_count {
                all.extend(at_full_rate);
            }
            peaks.extend(peak.map(|peak| peak.at_full_rate(*override_ratio)));
        }
        for velocity in at_limit(&peaks) {
            all.push(velocity);
            limited = limited.sup(&velocity);
        }
        let path = all.iter().map(Vector::norm).reduce(f64::max);
        let (axes, mut guessed_axes) = rates(&all);
        for (axis, guessed) in guessed_axes.iter_mut().enumerate() {
            let is_limited = |rate: f64| (1.0 - PLATEAU_TOLERANCE_RATIO) * rate <= limited[axis];
            *guessed |= !axes[axis].is_none_or(is_limited);
        }
        RapidRates { path, axes, guessed_axes }
    }

    /// Returns the rates without that along the path.
    pub fn without_path(self) -> RapidRates {
        RapidRates { path: None, ..self }
    }

    /// Returns the rates with one of an axis (mm/s) that no plateau shows.
    pub fn with_guessed(self, axis: usize, rate: f64) -> RapidRates {
        let mut rates = self;
        (rates.axes[axis], rates.guessed_axes[axis]) = (Some(rate), true);
        rates
    }

    /// Returns the rates without that of Z.
    pub fn without_z(self) -> RapidRates {
        RapidRates { axes: [self.axes[0], self.axes[1], None], ..self }
    }
}

impl ReachedVelocity {
    /// Returns the velocities from the highest one of each rapid and the highest one that a rapid reached `twice` (mm/s), of
    /// which none is off by more than `error` (mm/s), and from the highest plateau (mm/s).
    fn of(mut fastest_of_each: Vec<f64>, twice: f64, error: f64, plateau: f64) -> ReachedVelocity {
        sort_by_number(&mut fastest_of_each, |speed| -speed);
        let often = fastest_of_each.get(MIN_RAPIDS - 1).copied().unwrap_or(0.0).max(twice) - error;
        let fastest = fastest_of_each.first().copied().unwrap_or(0.0);
        ReachedVelocity { fastest: fastest.max(plateau), certain: often.max(plateau) }
    }
}

/// Returns the largest error of the distance between two recorded positions of an axis, mm: a step, if nothing but rounding
/// to whole steps makes it.
pub fn largest_error(track: &Track) -> f64 {
    let step = track.steps.into_iter().fold(0.0, f64::max);
    if track.noise <= step { step } else { MAX_NOISE_DEVIATIONS * std::f64::consts::SQRT_2 * track.noise }
}

impl RapidPlateaus {
    /// Returns the fastest plateaus of the runs; `None` if no run has positions.
    pub fn of(runs: &[Run]) -> Option<RapidPlateaus> {
        let mut seen = RapidPlateaus::default();
        let mut rapids = Vec::new();
        let with_positions = runs.iter().filter(|run| run.alignment.track.is_some());
        let count = with_positions.clone().map(|run| seen.take(run, &mut rapids)).count();
        let tracks = with_positions.filter_map(|run| run.alignment.track.as_ref());
        let error = tracks.map(|track| largest_error(track)).fold(0.0, f64::max) / WINDOW_S;
        seen.feedrates = RapidFeedrates::of(&rapids);
        seen.rates = RapidRates::of(rapids.iter(), true);
        let below_feedrate = rapids.iter().filter(|rapid| !is_at_feedrate(rapid));
        seen.rates_below_feedrate = RapidRates::of(below_feedrate, false);
        seen.reached = [0, 1, 2].map(|axis| {
            let fastest_of_each = rapids.iter().map(|rapid| rapid.fastest[axis]).collect();
            let twice = rapids.iter().map(|rapid| rapid.twice[axis]).fold(0.0, f64::max);
            let held = rapids.iter().flat_map(|rapid| &rapid.held).map(|held| held[axis]).fold(0.0, f64::max);
            ReachedVelocity::of(fastest_of_each, twice, error, held)
        });
        (0 < count).then_some(seen)
    }

    /// Returns the rates of the machine that the rapids show if they run as this machine runs them.
    pub fn rates(&self, machine: &Machine) -> RapidRates {
        if machine.rapid.at_feedrate { self.rates_below_feedrate } else { self.rates }
    }

    /// Returns the same with changed rates.
    pub fn with_rates(self, change: impl Fn(RapidRates) -> RapidRates) -> RapidPlateaus {
        let [rates, rates_below_feedrate] = [self.rates, self.rates_below_feedrate].map(change);
        RapidPlateaus { rates, rates_below_feedrate, ..self }
    }

    /// Adds the plateaus of a run, to `rapids` its rapids.
    fn take(&mut self, run: &Run, rapids: &mut Vec<RapidVelocity>) {
        let (Some(track), segments) = (&run.alignment.track, &run.toolpath.segments) else { return };
        let error = largest_error(track);
        let window = ((WINDOW_S / track.interval).ceil() as usize).max(MIN_SAMPLES);
        let distances = run.toolpath.distances();
        self.take_fastest(run, window);
        let segment = |fix: &Fix| segment_of(fix, &distances);
        let ratio = run.overrides.1.filter(|ratio| 0.0 < *ratio).unwrap_or(1.0);
        let moves = rapid_moves(run, track, segment);
        rapids.extend(moves.iter().map(|rapid| rapid.velocity(track, window, error, ratio)));
        for fixes in run.alignment.fixes.windows(3 * window + 1).step_by(window.div_ceil(2)) {
            let (begin, end) = (&fixes[0], &fixes[3 * window]);
            let (Some(first), Some(last)) = (begin.sample, end.sample) else { continue };
            let index = segment(begin);
            let is_one = index == segment(end) && last - first == 3 * window;
            let is_cut = index < segments.len()
                && !segments.motion(index).is_rapid()
                && *segments.curve(index) == Curve::Line;
            if is_one && is_cut {
                let velocity_error = error / (window as f64 * track.interval);
                let velocities = track.successive_velocities(first, window);
                self.add_cut(velocities, &segments.at(index), velocity_error);
            }
        }
    }

    /// Adds the highest velocities of the axes in the feed moves of a run, programmed and recorded over `window`
    /// samples.
    fn take_fastest(&mut self, run: &Run, window: usize) {
        let (Some(track), segments) = (&run.alignment.track, &run.toolpath.segments) else { return };
        for segment in segments.iter().filter(|segment| !segment.motion.is_rapid()) {
            let asked = limits::requested_feedrate(&segment, &Machine::default());
            // On an arc an axis may be fastest between its ends.
            let shares = limits::largest_share(&segment);
            for (fastest, share) in self.fastest_asked.iter_mut().zip(shares.iter()) {
                *fastest = fastest.max(asked * share);
            }
            self.asked_along = self.asked_along.max(asked);
        }
        let distances = run.toolpath.distances();
        let is_feed = |fix: &Fix| {
            let at = segment_of(fix, &distances);
            at < segments.len() && !segments.motion(at).is_rapid()
        };
        let mut speeds: [Vec<(f64, f64)>; 3] = Default::default();
        let mut along = Vec::new();
        for fixes in run.alignment.fixes.windows(window + 1).step_by(window.div_ceil(2)) {
            let (Some(first), Some(last)) = (fixes[0].sample, fixes[window].sample) else { continue };
            if last - first == window && fixes.iter().all(is_feed) {
                let velocity = track.velocity_between(first, last);
                for (axis, speeds) in speeds.iter_mut().enumerate() {
                    speeds.push((track.time[first], velocity[axis].abs()));
                }
                along.push((track.time[first], velocity.norm()));
            }
        }
        for (fastest, speeds) in self.fastest_cut.iter_mut().zip(&speeds) {
            *fastest = fastest.max(ceiling(speeds));
        }
        self.fastest_along = self.fastest_along.max(ceiling(&along));
    }

    /// Returns the machine in which axes, or the path on a control that limits that instead, were programmed to be faster and
    /// are limited to their highest recorded velocity; `None` if there are none. A ramp may also have kept an axis below its
    /// programmed velocity, so the machine is only a start for comparison.
    pub fn limited_to_fastest(&self, planner: Planner, machine: &Machine) -> Option<Machine> {
        let mut limited = machine.clone();
        if planner == Planner::SquareCorner {
            let is_limit = 0.0 < self.fastest_along
                && self.fastest_along < MAX_SLOWER_RATIO * self.asked_along
                && self.fastest_along < machine.path.velocity;
            limited.path.velocity = self.fastest_along;
            return is_limit.then_some(limited);
        }
        for (axis, (fastest, asked)) in
            limited.axes.iter_mut().zip(self.fastest_cut.iter().zip(self.fastest_asked))
        {
            if 0.0 < *fastest && *fastest < MAX_SLOWER_RATIO * asked && *fastest < axis.velocity {
                (axis.velocity, axis.rapid) = (*fastest, axis.rapid.min(*fastest));
            }
        }
        (limited.axes != machine.axes).then_some(limited)
    }

    /// Returns the machine with each velocity limit of an axis that the rapids of the runs exceed raised to their
    /// highest velocity, and the number of limits raised.
    pub fn raised(&self, machine: &Machine) -> (Machine, usize) {
        let (mut raised, mut count) = (machine.clone(), 0);
        for (axis, reached) in raised.axes.iter_mut().zip(self.reached) {
            for limit in [&mut axis.rapid, &mut axis.velocity] {
                if *limit < (1.0 - PLATEAU_TOLERANCE_RATIO) * reached.certain {
                    (*limit, count) = (reached.fastest, count + 1);
                }
            }
        }
        (raised, count)
    }

    /// Adds the plateau of the velocities in three successive windows on a line that is cut; noise changes none of them by
    /// more than `error` (mm/s).
    fn add_cut(&mut self, velocities: [Vector; 3], line: &Segment, error: f64) {
        let axis = velocities[1].iamax();
        let asked = limits::requested_feedrate(line, &Machine::default()) * line.tangent(0.0)[axis].abs();
        let found = plateau(velocities.map(|velocity| velocity[axis].abs()));
        let place = |found: Option<f64>, asked: f64| {
            usize::from(!found.is_some_and(|found| found + error < MAX_SLOWER_RATIO * asked))
        };
        faster(&mut self.cut[place(found, asked)][axis], found);
        // A line that rises may be held back by Z.
        if line.tangent(0.0)[2] == 0.0 {
            let asked = limits::requested_feedrate(line, &Machine::default());
            let found = plateau(velocities.map(|velocity| velocity.norm()));
            faster(&mut self.cut_along[place(found, asked)], found);
        }
    }

    /// Limits the axes that were held back where they cut, and their rapids with them: such a limit is one of the axis.
    /// A control with a limit along the path has that and one of Z instead.
    pub fn limit_feed(&self, planner: Planner, machine: &mut Machine) {
        let limit = |[held_back, free]: [Option<f64>; 2]| {
            let slowest = free.map_or(0.0, |free| (1.0 - PLATEAU_TOLERANCE_RATIO) * free);
            held_back.filter(|most| slowest <= *most)
        };
        let is_along_path = planner == Planner::SquareCorner;
        if let Some(most) = limit(self.cut_along).filter(|_| is_along_path) {
            machine.path.velocity = most;
        }
        let axes = machine.axes.iter_mut().enumerate().skip(if is_along_path { 2 } else { 0 });
        for (at, axis) in axes {
            if let Some(most) = limit(self.cut.map(|axes| axes[at])) {
                (axis.velocity, axis.rapid) = (most, axis.rapid.min(most));
            }
        }
    }

    /// Returns the machine whose rapids each axis limits. An axis without a plateau has its velocity limit, if any.
    /// Otherwise it is as fast as the fastest axis that showed a plateau or was held back where it cut, since axes are
    /// alike, and at least as fast as it was cut. If there is no such axis, or if the rapids were faster without a
    /// plateau, those of X and Y counting for both, the machine file gives the rate, and the axis is at least as fast as it was.
    pub fn limited_by_axis(&self, machine: &Machine, file: &Machine) -> Machine {
        let held_back = machine.axes.iter().map(|axis| axis.velocity).filter(|velocity| velocity.is_finite());
        let mut limited = machine.clone();
        limited.rapid.feedrate = f64::INFINITY;
        limited.rapid.at_feedrate = self.feedrates.are_programmed(machine.rapid.at_feedrate);
        let rates = self.rates(&limited).axes;
        let fastest = rates.iter().flatten().copied().chain(held_back).reduce(f64::max);
        for (at, axis) in limited.axes.iter_mut().enumerate() {
            let reached = self.reached[at];
            let known = axis.velocity.is_finite().then_some(axis.velocity);
            let alike = fastest.map(|fastest| fastest.max(self.fastest_cut[at]));
            // X and Y are more alike than Z: if one of them was faster, the other one may be as fast.
            let pair = if at < 2 { &self.reached[..2] } else { &self.reached[2..] };
            let alike = alike.filter(|alike| pair.iter().all(|reached| reached.certain <= *alike));
            let of_file = axis.rapid.min(file.rapid.feedrate).max(reached.fastest);
            axis.rapid = rates[at].or(known).or(alike).unwrap_or(of_file);
        }
        limited
    }

    /// Returns the machine whose rapids are limited along the path, as on the plateaus, or else as in the machine file, by
    /// Z if that is slower, and by the programmed feedrate unless they exceed it: so does Klipper.
    pub fn limited_along_path(&self, machine: &Machine, file: &Machine) -> Machine {
        let mut limited = machine.clone();
        limited.rapid.at_feedrate = self.feedrates.are_programmed(machine.rapid.at_feedrate);
        let rates = self.rates(&limited);
        // What a rapid held at its feedrate, the machine can do.
        let can_do = file.fastest_rapid().max(self.rates.path.unwrap_or(0.0));
        let along_path = rates.path.unwrap_or(can_do);
        limited.rapid.feedrate = along_path;
        limited.axes.iter_mut().for_each(|axis| axis.rapid = f64::INFINITY);
        let is_slower = |own: &f64| *own < MAX_SLOWER_RATIO * along_path;
        limited.axes[2].rapid = rates.axes[2].filter(is_slower).unwrap_or(f64::INFINITY);
        limited
    }
}

/// Returns the segment on which a fix is; `distances` are 0 and those at the ends of segments, mm.
fn segment_of(fix: &Fix, distances: &[f64]) -> usize {
    distances.partition_point(|at| *at <= fix.distance).saturating_sub(1)
}

/// Returns the rates of the axes (mm/s) from the velocities on the plateaus of rapids, for machines that limit each
/// axis separately, `None` for an axis whose rate they do not show; and `true` for each axis whose rate is a guess. The
/// highest velocity of an axis is its rate if the axis reached it while no other axis was at its highest. A rapid that
/// no such axis holds back, to within [`MAX_SLOWER_RATIO`], is held back by the
/// axis that moves furthest, if axes are alike. If all rapids are equally fast along the path, the limit may be on the path,
/// as on controls that run G0 at the programmed feedrate, and an axis that is slower than that may have no such rate.
fn rates(rapids: &[Vector]) -> ([Option<f64>; 3], [bool; 3]) {
    let fastest = rapids.iter().fold(Vector::zeros(), |fastest, velocity| fastest.sup(velocity));
    let is_fastest = |velocity: &Vector, axis: usize| {
        0.0 < fastest[axis] && (1.0 - PLATEAU_TOLERANCE_RATIO) * fastest[axis] <= velocity[axis]
    };
    let is_alone = |velocity: &Vector, axis: usize| {
        is_fastest(velocity, axis) && (0..3).all(|other| other == axis || !is_fastest(velocity, other))
    };
    let mut told = [0, 1, 2].map(|axis| rapids.iter().any(|velocity| is_alone(velocity, axis)));
    let mut guessed = [false; 3];
    for velocity in rapids {
        let holds_back = |axis: usize| told[axis] && MAX_SLOWER_RATIO * fastest[axis] <= velocity[axis];
        if !(0..3).any(holds_back) {
            (told[velocity.iamax()], guessed[velocity.iamax()]) = (true, true);
        }
    }
    let along_path = rapids.iter().map(Vector::norm).fold(0.0, f64::max);
    let is_slower = |velocity: f64| velocity < MAX_SLOWER_RATIO * along_path;
    if !rapids.iter().any(|velocity| is_slower(velocity.norm())) {
        (0..3).for_each(|axis| guessed[axis] |= told[axis] && is_slower(fastest[axis]));
    }
    ([0, 1, 2].map(|axis| told[axis].then_some(fastest[axis])), guessed)
}

/// Limits the axes to the rates of their rapids if the control has one velocity of an axis for feed and rapids
/// alike: LinuxCNC's MAX_VELOCITY, grbl's $110. LinuxCNC plans corners by it, however slow the feed. An axis that was
/// programmed to cut faster keeps the limit that was fitted.
pub fn limit_feed_as_rapids(machine: &mut Machine, plateaus: Option<RapidPlateaus>) {
    let Some(seen) =
        plateaus.filter(|seen| seen.rates(machine).axes != [None; 3] && limits_rapids_as_feed(machine))
    else {
        return;
    };
    for (axis, asked) in machine.axes.iter_mut().zip(seen.fastest_asked) {
        if asked <= axis.rapid {
            axis.velocity = axis.velocity.min(axis.rapid);
        }
    }
}

/// Returns `true` if the velocity of an axis is that of its rapids, as [`limit_feed_as_rapids`] makes it.
pub fn is_limited_as_rapids(machine: &Machine, axis: usize, plateaus: Option<RapidPlateaus>) -> bool {
    let own = &machine.axes[axis];
    let is_slower = |seen: RapidPlateaus| seen.fastest_asked[axis] <= own.rapid;
    limits_rapids_as_feed(machine)
        && own.rapid.is_finite()
        && own.velocity == own.rapid
        && plateaus.is_some_and(is_slower)
}

/// Returns `true` if the control has one velocity of an axis for feed and rapids.
fn limits_rapids_as_feed(machine: &Machine) -> bool {
    let junction = machine.interpolator.junction;
    !machine.has_filters()
        && (junction.blends_in_time() || matches!(junction, Junction::Deviation(_) | Junction::AxisStep(_)))
}

/// Returns `true` for each axis whose rapid rate no run showed for certain; `false` for all of them if no run has positions.
pub fn assumed(machine: &Machine, plateaus: Option<RapidPlateaus>) -> [bool; 3] {
    let Some(seen) = plateaus else { return [false; 3] };
    let is_along_path = machine.rapid.feedrate.is_finite();
    let rates = seen.rates(machine);
    let is_assumed = |axis: usize| match is_along_path {
        true => rates.path.is_none(),
        false => rates.axes[axis].is_none() || rates.guessed_axes[axis],
    };
    [0, 1, 2].map(is_assumed)
}

/// Returns the rapid rate of an axis of a planner that the runs show, mm/s; `None` if they do not show it, or if the rate is
/// `before`. It is more accurate than what a fit makes of the little time that such a limit costs.
pub fn recorded(axis: usize, before: f64, machine: &Machine, plateaus: Option<RapidPlateaus>) -> Option<f64> {
    let seen = plateaus.filter(|_| !machine.has_filters() && !assumed(machine, plateaus)[axis])?;
    seen.rates(machine).axes[axis].filter(|rate| PLATEAU_TOLERANCE_RATIO * rate < (before - rate).abs())
}

/// Returns the standard deviation of a rate (mm/s) that is read off plateaus, mm/s: rates that agree to the part
/// [`PLATEAU_TOLERANCE_RATIO`] count as equal.
pub fn deviation_of_plateau(rate: f64) -> f64 {
    PLATEAU_TOLERANCE_RATIO * rate / 3f64.sqrt()
}

/// Sets `own` to the faster of both.
fn faster(own: &mut Option<f64>, found: Option<f64>) {
    *own = [*own, found].into_iter().flatten().reduce(f64::max);
}

/// Returns the fastest of the speeds of an axis (mm/s), each after its time (s), if the speed recurs; 0 if it is a
/// single peak: ramps end at other speeds each time, a limit at the same.
fn ceiling(speeds: &[(f64, f64)]) -> f64 {
    let fastest = speeds.iter().map(|(_, speed)| *speed).fold(0.0, f64::max);
    let mut visits = 0;
    let mut left = f64::NEG_INFINITY;
    for (time, _) in speeds.iter().filter(|(_, speed)| (1.0 - PLATEAU_TOLERANCE_RATIO) * fastest <= *speed) {
        visits += usize::from(MIN_VISIT_INTERVAL_S < time - left);
        left = *time;
    }
    if MIN_VISITS <= visits { fastest } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    #[test]
    fn an_axis_has_the_rate_at_which_it_holds_the_others_back() {
        let x_alone = Vector::new(170.0, 20.0, 0.0);
        let held_back_by_y = Vector::new(123.0, 90.0, 0.0);
        assert_eq!(rates(&[x_alone, held_back_by_y]), ([Some(170.0), Some(90.0), None], [false; 3]));
        // Of one diagonal nobody knows which axis holds it back, and axes are alike.
        assert_eq!(rates(&[held_back_by_y]), ([Some(123.0), None, None], [true, false, false]));
        // A rapid that ends in a ramp within the last window is no other one.
        let [x, slower] = [170.0, 168.6].map(|x| Vector::new(x, 0.0, 0.0));
        assert_eq!(rates(&[x, slower]), ([Some(170.0), None, None], [false; 3]));
        assert_eq!(rates(&[]), ([None; 3], [false; 3]));
    }

    #[test]
    fn rapids_that_are_equally_fast_along_the_path_show_no_rate_of_a_slower_axis() {
        let diagonal = |angle: f64| 165.0 * Vector::new(angle.cos(), angle.sin(), 0.0);
        let by_axis = Vector::new(165.0, 0.0, 0.0);
        let z = Vector::new(0.0, 0.0, 165.0);
        let (axes, guessed) = rates(&[diagonal(0.2), diagonal(1.5), z]);
        assert_eq!(axes.map(|rate| rate.is_some()), [true; 3]);
        assert_eq!(guessed, [true, false, false]);
        assert_eq!(rates(&[by_axis, diagonal(1.5), z]).1, [false; 3]);
        // Here the diagonals are faster than Z, so axes are limited.
        assert_eq!(rates(&[diagonal(0.2), diagonal(1.5), 0.9 * z]).1, [false; 3]);
    }

    #[test]
    fn a_rate_that_is_guessed_counts_as_assumed() {
        let mut machine = Machine::default();
        machine.interpolator.junction = Junction::AccelerationBlend;
        machine.rapid.feedrate = f64::INFINITY;
        let axes = [Some(123.0), Some(90.0), None];
        let rates = RapidRates { path: None, axes, guessed_axes: [true, false, false] };
        let seen = RapidPlateaus { rates, ..RapidPlateaus::default() };
        assert_eq!(assumed(&machine, Some(seen)), [true, false, true]);
        // Filters are no other in this: here their rapids are limited along the path.
        assert_eq!(assumed(&Machine::default(), Some(seen)), [true; 3]);
        let with_path = seen.with_rates(|rates| RapidRates { path: Some(123.0), ..rates });
        assert_eq!(assumed(&Machine::default(), Some(with_path)), [false; 3]);
    }

    #[test]
    fn an_axis_of_which_nothing_is_known_is_as_fast_as_those_that_were_held_back() {
        let mut machine = Machine::default();
        machine.axes[1].velocity = 60.0;
        let given =
            |seen: RapidPlateaus| seen.limited_by_axis(&machine, &machine).axes.map(|axis| axis.rapid);
        assert_eq!(given(RapidPlateaus::default()), [60.0; 3]);
        let faster = [70.0, 50.0, 0.0].map(|certain| ReachedVelocity { certain, fastest: 75.0 });
        let without_plateau = RapidPlateaus { reached: faster, ..RapidPlateaus::default() };
        assert_eq!(given(without_plateau), [machine.rapid.feedrate, 60.0, 60.0]);
        // Z shows 50 mm/s and Y was faster: X may be as fast as Y.
        let z_and_y = RapidPlateaus {
            rates: RapidRates { axes: [None, None, Some(50.0)], ..RapidRates::default() },
            reached: [0.0, 70.0, 50.0].map(|certain| ReachedVelocity { certain, fastest: certain }),
            ..RapidPlateaus::default()
        };
        let limited = z_and_y.limited_by_axis(&Machine::default(), &Machine::default());
        assert_eq!(
            limited.axes.map(|axis| axis.rapid),
            [machine.rapid.feedrate, machine.rapid.feedrate, 50.0]
        );
        let cut_faster = RapidPlateaus { fastest_cut: [80.0, 60.0, 0.0], ..RapidPlateaus::default() };
        assert_eq!(given(cut_faster), [80.0, 60.0, 60.0]);
    }

    /// A plunge at F400 recorded in steps of 0.004 mm: 6.6 mm/s over 20 ms is 6.667 mm/s as well as the steps can show it.
    #[test]
    fn a_line_that_rounding_makes_slower_is_not_held_back() {
        let machine = Machine::default();
        let toolpath = trace(&read(b"G1 Z-10 F400\n"), &machine);
        let held_back = |velocity: f64| {
            let mut seen = RapidPlateaus::default();
            seen.add_cut([Vector::new(0.0, 0.0, velocity); 3], &toolpath.segments.at(0), 0.004 / 0.02);
            seen.cut[0][2]
        };
        assert_eq!(held_back(6.6 - 1e-9), None);
        assert_eq!(held_back(5.0), Some(5.0));
    }

    #[test]
    fn a_limit_that_a_run_exceeds_is_none() {
        let mut machine = Machine::default();
        (machine.axes[0].velocity, machine.axes[0].rapid) = (50.0, 50.0);
        machine.axes[1].velocity = 70.1;
        let reached =
            [(vec![90.0, 101.0, 80.0, 100.0, 99.0], 85.0, 0.0), (vec![120.0], 0.0, 70.0), (vec![], 0.0, 0.0)];
        let reached = reached.map(|(each, twice, plateau)| ReachedVelocity::of(each, twice, 0.4, plateau));
        assert_eq!(reached.map(|own| own.certain), [100.0 - 0.1 * MAX_NOISE_DEVIATIONS, 70.0, 0.0]);
        let seen = RapidPlateaus { reached, ..RapidPlateaus::default() };
        let (raised, count) = seen.raised(&machine);
        assert_eq!(count, 2);
        assert_eq!((raised.axes[0].velocity, raised.axes[0].rapid), (101.0, 101.0));
        assert_eq!(raised.axes[1..], machine.axes[1..]);
    }

    #[test]
    fn a_speed_that_comes_again_is_a_limit_and_a_single_peak_is_none() {
        let again: Vec<(f64, f64)> =
            (0..8).map(|at| (0.5 * f64::from(at), 60.0 - 0.01 * f64::from(at % 3))).collect();
        assert_eq!(ceiling(&again), 60.0);
        let peaks: Vec<(f64, f64)> =
            (0..8).map(|at| (0.5 * f64::from(at), 40.0 + 3.0 * f64::from(at))).collect();
        assert_eq!(ceiling(&peaks), 0.0);
    }
}
