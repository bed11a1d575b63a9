//! A toolpath that is planned in place of the program's, and the transfer of its plan to the program.
//!
//! Controls that merge short lines, or run arcs as chords, do not run the segments that the program has. A
//! segment of the substitute, of length l, covers a part of length S of the program, which may begin and end
//! within segments of it. The substitute is planned by itself, and its plan is transferred to the program
//! with distances and feedrates multiplied by S/l: the substitute gives the time, each block has a share of it
//! in proportion to its length, and distances refer to the program.
//!
//! Limits: positions along chords refer to the arcs of the program, from which the machine's differ by as much as the
//! chords do; those along merged lines refer to these lines ([`MergedPath`]).

use crate::machine::SpindleState;
use crate::simulation::feed::{
    CornerCurve, CornerPolicy, FeedPlan, MergedPath, Phase, Pulse, Pulses, RestToRest,
};
use crate::simulation::toolpath::{PathMode, Segment, Stop, Toolpath};

/// A toolpath to plan in place of the program's, with the part of the program that each segment covers.
#[derive(Default)]
pub struct Substitute {
    /// The segments as the control runs them. The part that each covers begins where the part of the one
    /// before ends.
    pub toolpath: Toolpath,
    /// The part of the program that each segment covers.
    pub covers: Vec<Cover>,
    /// Number of stops, path modes and spindle states copied from the program.
    stops: usize,
    path_modes: usize,
    spins: usize,
}

/// The part of the program that a segment covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cover {
    /// Index of the first segment in the program.
    pub first: usize,
    /// Distance along the first segment at which the part begins, mm.
    pub offset: f64,
    /// Index of the last segment, which may also be the first of the next part.
    pub last: usize,
    /// Length along the program, mm.
    pub length: f64,
}

impl Cover {
    /// Returns the part that is one segment of the program, given its index and length, mm.
    pub fn whole(number: usize, length: f64) -> Cover {
        Cover { first: number, offset: 0.0, last: number, length }
    }
}

impl Substitute {
    /// Adds a segment and the part that it covers.
    pub fn push(&mut self, segment: Segment, cover: Cover) {
        self.toolpath.segments.push(segment);
        self.covers.push(cover);
    }

    /// Copies a path mode of the program, which applies from the next segment on.
    pub fn take_path_mode(&mut self, mode: &PathMode) {
        self.toolpath.path_modes.push(PathMode { from: self.covers.len(), ..mode.clone() });
    }

    /// Copies the spindle state, which applies from the next segment on.
    pub fn take_spin(&mut self, spin: SpindleState) {
        self.toolpath.spins.push((self.covers.len(), spin));
    }

    /// Copies the path modes, spindle states and stops of the program that come before its segment `number`.
    pub fn take_before(&mut self, program: &Toolpath, number: usize) {
        while let Some(mode) = program.path_modes.get(self.path_modes).filter(|mode| mode.from <= number) {
            self.take_path_mode(mode);
            self.path_modes += 1;
        }
        while let Some((_, spin)) = program.spins.get(self.spins).filter(|(from, _)| *from <= number) {
            self.take_spin(*spin);
            self.spins += 1;
        }
        self.take_stops(program, number);
    }

    /// Returns `true` if the program has a stop before its segment `number` that was not copied.
    pub fn stops_before(&self, program: &Toolpath, number: usize) -> bool {
        program.stops.get(self.stops).is_some_and(|stop| stop.after <= number)
    }

    /// Copies the stops up to a segment of the program.
    pub fn take_stops(&mut self, program: &Toolpath, number: usize) {
        while self.stops_before(program, number) {
            let after = self.covers.len();
            self.toolpath.stops.push(Stop { after, ..program.stops[self.stops] });
            self.stops += 1;
        }
    }

    /// Plans the substitute with `plan` and returns the result as a plan of the program.
    pub fn planned(
        &self,
        program: &Toolpath,
        policy: CornerPolicy,
        plan: impl FnOnce(&Toolpath, CornerPolicy) -> FeedPlan,
    ) -> FeedPlan {
        let given = self.given(policy);
        let policy =
            given.as_ref().map_or(policy, |(corners, segments)| CornerPolicy::Given { corners, segments });
        self.spread(plan(&self.toolpath, policy), program)
    }

    /// Returns the given feedrates of corners and segments (mm/s) for the substitute: along a chain the
    /// smallest of its segments, and at its end the feedrate of the corner there. `None` if the policy gives no
    /// feedrates.
    fn given(&self, policy: CornerPolicy) -> Option<(Vec<f64>, Vec<f64>)> {
        let CornerPolicy::Given { corners, segments } = policy else { return None };
        let at_end = |(index, cover): (usize, &Cover)| {
            let goes_on = self.covers.get(index + 1).is_some_and(|next| next.first == cover.last);
            if goes_on { f64::INFINITY } else { corners[cover.last] }
        };
        let slowest =
            |cover: &Cover| segments[cover.first..=cover.last].iter().copied().fold(f64::INFINITY, f64::min);
        Some((
            self.covers.iter().enumerate().map(at_end).collect(),
            self.covers.iter().map(slowest).collect(),
        ))
    }

    /// Returns the plan of the substitute as a plan of the program.
    fn spread(&self, plan: FeedPlan, program: &Toolpath) -> FeedPlan {
        let segments = program.segments.len();
        let (corner_curves, merged_path) = self.run_path(plan.corner_curves, plan.merged_path, program);
        let mut spread = FeedPlan {
            start: plan.start,
            phases: Vec::with_capacity(plan.phases.len()),
            pulses: Pulses::default(),
            filters: plan.filters,
            corner_feedrates: vec![f64::INFINITY; segments],
            segment_feedrates: vec![f64::INFINITY; segments],
            corner_curves,
            merged_path,
            time_scaling: None,
        };
        spread.pulses.try_reserve_exact(plan.pulses.len() + segments).ok();
        for (index, cover) in self.covers.iter().enumerate() {
            let ratio = self.ratio(index);
            for feedrate in &mut spread.segment_feedrates[cover.first..=cover.last] {
                *feedrate = feedrate.min(ratio * plan.segment_feedrates[index]);
            }
            spread.corner_feedrates[cover.last] = plan.corner_feedrates[index];
        }
        for phase in &plan.phases {
            let Phase::Motion(rest_to_rest) = phase else {
                spread.phases.push(phase.clone());
                continue;
            };
            let first_pulse = spread.pulses.len();
            let mut place = (0, 0.0);
            let mut now = usize::MAX;
            for pulse in plan.pulses.range(rest_to_rest.pulses.clone()) {
                let index = pulse.segment as usize;
                let cover = &self.covers[index];
                if index != now {
                    (now, place) = (index, (cover.first, cover.offset));
                }
                let ratio = self.ratio(index);
                place_pulse(&pulse, ratio, cover.last, &mut place, program, &mut spread);
            }
            let covered = rest_to_rest.segments.clone();
            spread.phases.push(Phase::Motion(RestToRest {
                segments: self.covers[covered.start].first..self.covers[covered.end - 1].last + 1,
                pulses: first_pulse..spread.pulses.len(),
                filter: rest_to_rest.filter,
            }));
        }
        spread
    }

    /// Converts the corner curves and the merged path of the substitute's plan for the program. For a control without corner
    /// curves both are empty.
    fn run_path(
        &self,
        curves: Vec<CornerCurve>,
        merged: Option<MergedPath>,
        program: &Toolpath,
    ) -> (Vec<CornerCurve>, Option<MergedPath>) {
        if curves.is_empty() {
            return Default::default();
        }
        if merged.is_some() {
            // Distances along the program are those along the substitute, unless that has other lengths.
            let is_as_long = (0..self.covers.len()).all(|index| (self.ratio(index) - 1.0).abs() < 1e-9);
            return if is_as_long { (curves, merged) } else { Default::default() };
        }
        if self.covers.iter().any(|cover| cover.first < cover.last) {
            return (curves, Some(MergedPath::of(self)));
        }
        let mut of_program = vec![CornerCurve::NONE; program.segments.len()];
        for (cover, curve) in self.covers.iter().zip(curves) {
            // The last part of a segment comes last.
            of_program[cover.last] = curve;
        }
        (of_program, None)
    }

    /// Returns S/l: the length along the program over the length that is run.
    fn ratio(&self, index: usize) -> f64 {
        let (run, written) = (self.toolpath.segments.length(index), self.covers[index].length);
        if run == written { 1.0 } else { written / run }
    }
}

/// Adds a pulse to the plan of the program. It begins at `place`, a segment and the distance along it (mm),
/// and extends at most to the segment `last`. A pulse that crosses the end of a segment is cut there: it
/// reaches the distance x after
///
/// ```text
/// |t = 2 x / (f + √(f² + 2 b x))         f command at its beginning, b its slope, mm/s²
/// ```
fn place_pulse(
    pulse: &Pulse,
    ratio: f64,
    last: usize,
    place: &mut (usize, f64),
    program: &Toolpath,
    plan: &mut FeedPlan,
) {
    let mut left = pulse.duration;
    let mut feedrate = pulse.feedrate.map(|feedrate| ratio * feedrate);
    let slope = (feedrate[1] - feedrate[0]) / pulse.duration;
    loop {
        let (number, offset) = *place;
        let room = program.segments.length(number) - offset;
        let passed = left * 0.5 * (feedrate[0] + feedrate[1]);
        if number == last || passed < room {
            let segment = number as u32;
            plan.pulses.push(Pulse { segment, duration: left, offset, feedrate });
            place.1 += passed;
            return;
        }
        let end = (feedrate[0] * feedrate[0] + 2.0 * slope * room).max(0.0).sqrt();
        let duration = (2.0 * room / (feedrate[0] + end)).min(left);
        if 0.0 < duration {
            let segment = number as u32;
            plan.pulses.push(Pulse { segment, duration, offset, feedrate: [feedrate[0], end] });
            left -= duration;
        }
        feedrate[0] = end;
        plan.corner_feedrates[number] = end;
        *place = (number + 1, 0.0);
        if left <= 0.0 {
            return;
        }
    }
}
