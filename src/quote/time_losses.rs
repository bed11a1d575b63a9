//! The places where a plan loses most time against length over feedrate, with the reasons.
//!
//! A move of length L (mm) at the feedrate F (mm/s) would take L / F. All time beyond that is lost, and so is
//! all time without a move. A pulse of the command that lasts t over the distance s loses t − s / F. The
//! fastest pulses of a block divide it:
//!
//! ```text
//!  F   - - - - - - - - - - - - -
//!            ______________          body: the feedrate is held below F
//!       ____/              \____     head and tail: they belong to the corners
//! ```
//!
//! | place | what it holds |
//! |---|---|
//! | corner | tail of the block before and head of the block after, if the motion continues |
//! | short blocks | blocks in a row that are shorter than the filter delay D (L / F < D) or too short to reach their command, with the corners at both ends |
//! | limit | body of any other block: an arc at its tolerance, a limit of an axis, an override |
//! | acceleration | what a block loses behind the filters |
//! | ramp | tail and head at a full stop, and half of D before and after it |
//! | rapid | rapid moves in a row, against the rapid feedrate, with their ramps |
//! | wait, halt, start | time without a move; the time of a turn of rotary axes beyond the programmed one |
//!
//! Each lost second belongs to one place, so that the places add up to the whole. A row of blocks is divided
//! if it would be longer than a hundredth of the path, so that a long surface is not a single place.

use crate::machine::Machine;
use crate::quote::shares::{programmed, programmed_wait};
use crate::simulation::feed::{FeedPlan, Phase, Pulse, RestToRest, Tolerances};
use crate::simulation::gcode::LineNumber;
use crate::simulation::running_sum::running_sum;
use crate::simulation::toolpath::{Curve, Segment, StopCause, Toolpath};

/// Number of places that are reported.
pub const MAX_LISTED_LOSSES: usize = 10;
/// Largest length of a row of blocks that is one place, as a part of the path.
const MAX_PART_OF_PATH: f64 = 0.01;
/// Part of a command from which on the command counts as reached.
const REACHED_COMMAND_RATIO: f64 = 0.999;

/// The reason for lost time at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LossReason {
    /// A corner that is passed within its tolerance.
    Corner {
        /// Angle by which the path turns, rad.
        turn: f64,
        /// Contour tolerance there, mm.
        tolerance: f64,
    },
    /// Blocks too short for their feedrate.
    ShortBlocks {
        /// Number of blocks.
        blocks: usize,
    },
    /// A feedrate held below the programmed one.
    Limit {
        /// Actual feedrate, mm/s.
        feedrate: f64,
        /// Programmed feedrate, mm/s.
        programmed: f64,
        /// `true` along an arc.
        is_arc: bool,
    },
    /// Acceleration limits behind the filters.
    Acceleration,
    /// The motion stops and starts again.
    Ramp(StopReason),
    /// Rapid moves that do not reach, or do not keep, their feedrate.
    Rapid {
        /// Number of blocks.
        blocks: usize,
    },
    /// A function, a dwell or a turn of rotary axes.
    Wait(StopCause),
    /// A halt that the program does not request.
    Halt,
    /// Before the first block.
    Start,
}

/// The reason for a full stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopReason {
    /// The program begins.
    Begin,
    /// The program ends.
    End,
    /// A function, a dwell or a turn of rotary axes.
    For(StopCause),
    /// An exact stop, of the program or of the machine.
    Exact,
}

/// A place where time is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeLoss {
    /// Reason.
    pub reason: LossReason,
    /// First and last line of the program involved.
    pub lines: (LineNumber, LineNumber),
    /// Distance along the path at which the place begins and ends, mm.
    pub distance: (f64, f64),
    /// Time lost, s; below 0 if time is gained.
    pub seconds: f64,
}

/// The time that a plan loses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LostTimes {
    /// Total, s: cycle time less length over feedrate.
    pub total: f64,
    /// The places that lose most, by lost time.
    pub places: Vec<TimeLoss>,
}

/// Returns the time that a plan loses, with the places that cost most.
pub fn lost_times(
    toolpath: &Toolpath,
    machine: &Machine,
    plan: &FeedPlan,
    tolerances: Tolerances,
) -> LostTimes {
    let mut places: Vec<TimeLoss> = Vec::with_capacity(MAX_LISTED_LOSSES + 1);
    each_place(toolpath, machine, plan, tolerances, &mut |place| {
        // A place that loses less is only rounding.
        if 1e-6 < place.seconds {
            let index = places.partition_point(|other| place.seconds <= other.seconds);
            if index < MAX_LISTED_LOSSES {
                places.truncate(MAX_LISTED_LOSSES - 1);
                places.insert(index, place);
            }
        }
    });
    LostTimes { total: total(toolpath, machine, plan), places }
}

/// Returns the cycle time less length over feedrate, s.
fn total(toolpath: &Toolpath, machine: &Machine, plan: &FeedPlan) -> f64 {
    let moves = toolpath.segments.iter().map(|segment| -segment.length / programmed(&segment, machine));
    let turns = toolpath.stops.iter().filter(|stop| matches!(stop.cause, StopCause::Rotary { .. }));
    let turns = turns.map(|stop| -programmed_wait(&stop.cause, machine));
    running_sum([plan.cycle_time()].into_iter().chain(moves).chain(turns)).last().unwrap_or(0.0)
}

/// Time lost by a block before, on and after its fastest pulses (s), and the distances of these pulses along
/// the block (mm).
#[derive(Clone, Copy, Default)]
struct BlockDivision {
    head: f64,
    body: f64,
    tail: f64,
    from: f64,
    to: f64,
    peak: f64,
    halt: f64,
}

impl BlockDivision {
    fn of(pulses: &[Pulse], feedrate: f64) -> BlockDivision {
        let speed = |pulse: &Pulse| pulse.feedrate[0].max(pulse.feedrate[1]);
        let way = |pulse: &Pulse| pulse.duration * 0.5 * (pulse.feedrate[0] + pulse.feedrate[1]);
        // Where two ramps meet, the meeting point is the body.
        let cruise = |pulse: &Pulse| pulse.feedrate[0].min(pulse.feedrate[1]);
        let peak = pulses.iter().map(speed).fold(0.0, f64::max);
        let is_body = |pulse: &&Pulse| !pulse.is_halt() && REACHED_COMMAND_RATIO * peak <= cruise(pulse);
        let turning = pulses.iter().find(|pulse| REACHED_COMMAND_RATIO * peak <= speed(pulse));
        let turning = turning.map_or(0.0, |pulse| pulse.offset + way(pulse));
        let from = pulses.iter().find(is_body).map_or(turning, |pulse| pulse.offset);
        let to = pulses.iter().rfind(is_body).map_or(turning, |pulse| pulse.offset + way(pulse));
        let mut division = BlockDivision { from, to, peak, ..BlockDivision::default() };
        for pulse in pulses {
            let lost = pulse.duration - way(pulse) / feedrate;
            let middle = pulse.offset + 0.5 * way(pulse);
            *(if pulse.is_halt() {
                &mut division.halt
            } else if middle < from {
                &mut division.head
            } else if to < middle {
                &mut division.tail
            } else {
                &mut division.body
            }) += lost;
        }
        division
    }
}

/// The tail of a block, which belongs to the corner or full stop after the block.
struct BlockTail {
    line: LineNumber,
    /// Distance along the path at which the tail begins and ends, mm.
    distance: (f64, f64),
    /// Time lost, s.
    seconds: f64,
}

/// A plan whose places are visited one after another.
struct LossWalk<'a> {
    toolpath: &'a Toolpath,
    machine: &'a Machine,
    found: &'a mut dyn FnMut(TimeLoss),
    /// Largest length of a row of blocks, mm.
    max_row_length: f64,
    /// Distance travelled, mm.
    travelled: f64,
    /// A row of blocks that may continue: short ones, or rapids.
    row: Option<TimeLoss>,
    tail: Option<BlockTail>,
}

fn each_place(
    toolpath: &Toolpath,
    machine: &Machine,
    plan: &FeedPlan,
    tolerances: Tolerances,
    found: &mut dyn FnMut(TimeLoss),
) {
    let segments = &toolpath.segments;
    let longest = MAX_PART_OF_PATH * (0..segments.len()).map(|index| segments.length(index)).sum::<f64>();
    let mut walk =
        LossWalk { toolpath, machine, found, max_row_length: longest, travelled: 0.0, row: None, tail: None };
    let first = toolpath.segments.first().map_or(LineNumber(1), |segment| segment.line);
    walk.report(LossReason::Start, (first, first), (0.0, 0.0), plan.start);
    let mut corners = tolerances.bounds(toolpath, machine).map(|bound| bound.corner);
    let mut standing = StopReason::Begin;
    for phase in &plan.phases {
        match phase {
            Phase::Wait(wait) => {
                walk.end_row();
                let turned = match wait.cause {
                    StopCause::Rotary { .. } => programmed_wait(&wait.cause, machine),
                    _ => 0.0,
                };
                let here = walk.travelled;
                walk.report(
                    LossReason::Wait(wait.cause),
                    (wait.line, wait.line),
                    (here, here),
                    wait.duration - turned,
                );
                if !matches!(standing, StopReason::For(_)) {
                    standing = StopReason::For(wait.cause);
                }
            }
            Phase::Motion(rest_to_rest) => {
                walk.rest_to_rest(plan, rest_to_rest, &mut corners, standing);
                standing = StopReason::Exact;
            }
        }
    }
    walk.end_row();
    if !matches!(standing, StopReason::For(_)) {
        standing = StopReason::End;
    }
    if let Some(tail) = walk.tail.take() {
        walk.report(LossReason::Ramp(standing), (tail.line, tail.line), tail.distance, tail.seconds);
    }
}

impl LossWalk<'_> {
    fn report(
        &mut self,
        reason: LossReason,
        lines: (LineNumber, LineNumber),
        distance: (f64, f64),
        seconds: f64,
    ) {
        if seconds != 0.0 {
            (self.found)(TimeLoss { reason, lines, distance, seconds });
        }
    }

    fn end_row(&mut self) {
        if let Some(row) = self.row.take() {
            (self.found)(row);
        }
    }

    fn rest_to_rest(
        &mut self,
        plan: &FeedPlan,
        rest_to_rest: &RestToRest,
        corners: &mut impl Iterator<Item = f64>,
        standing: StopReason,
    ) {
        let (delay, half) =
            (plan.filters[rest_to_rest.filter].delay(), plan.filters[rest_to_rest.filter].half_delay());
        // The pulses that remain, and those of one block.
        let (mut pulses, mut own) = (rest_to_rest.pulses.clone(), Vec::new());
        let lost =
            plan.time_scaling.as_ref().map_or(&[][..], |found| found.lost_on(rest_to_rest.segments.clone()));
        let mut lost = lost.iter().peekable();
        let (first, last) = (rest_to_rest.segments.start, rest_to_rest.segments.end - 1);
        // The tolerance at the corner before.
        let mut tolerance = 0.0;
        self.end_row();
        for index in rest_to_rest.segments.clone() {
            let segment = self.toolpath.segments.at(index);
            let is_later = |&pulse: &usize| index < plan.pulses.segment(pulse);
            let end = pulses.clone().find(is_later).unwrap_or(pulses.end);
            own.clear();
            own.extend(plan.pulses.range(std::mem::replace(&mut pulses.start, end)..end));
            let mut behind = 0.0;
            while let Some((_, seconds)) = lost.next_if(|(at, _)| *at <= index) {
                behind += seconds;
            }
            let feedrate = programmed(&segment, self.machine);
            let division = BlockDivision::of(&own, feedrate);
            let command = plan.segment_feedrates.get(index).copied().unwrap_or(feedrate).min(feedrate);
            let is_rapid = segment.motion.is_rapid();
            let is_short = !is_rapid
                && (segment.length < delay * feedrate || division.peak < REACHED_COMMAND_RATIO * command);
            let is_whole = is_rapid || is_short;

            let BlockDivision { head, body, tail, .. } = division;
            let begins = |stands: bool| if stands { half } else { 0.0 };
            let (before, after) = (begins(index == first), begins(index == last));
            let (here, there) = (self.travelled, self.travelled + segment.length);

            // The tail of the block before and the head of this one belong together.
            let entering = if is_whole { 0.0 } else { head } + if is_rapid { 0.0 } else { before };
            let entered = if is_whole { here } else { here + division.from };
            self.pass_boundary(
                (index, &segment),
                entering,
                entered,
                (index == first).then_some(standing),
                tolerance,
                is_short,
            );

            if is_whole {
                let seconds = head + body + tail + behind + if is_rapid { before + after } else { 0.0 };
                self.extend_row(&segment, is_rapid, seconds, (here, there));
                if !is_rapid && index == last {
                    self.tail =
                        Some(BlockTail { line: segment.line, distance: (there, there), seconds: after });
                }
            } else {
                self.end_row();
                let held = LossReason::Limit {
                    feedrate: division.peak,
                    programmed: feedrate,
                    is_arc: segment.curve != Curve::Line,
                };
                let lines = (segment.line, segment.line);
                self.report(held, lines, (here + division.from, here + division.to), body);
                self.report(LossReason::Acceleration, lines, (here, there), behind);
                let distance = (here + division.to, there);
                self.tail = Some(BlockTail { line: segment.line, distance, seconds: tail + after });
            }
            self.report(LossReason::Halt, (segment.line, segment.line), (here, there), division.halt);
            tolerance = corners.next().unwrap_or(0.0);
            self.travelled = there;
        }
    }

    /// Adds `seconds` lost at the boundary before this block, up to `to` (mm), to a stop, a corner, or a row
    /// of short blocks.
    fn pass_boundary(
        &mut self,
        (index, segment): (usize, &Segment),
        seconds: f64,
        to: f64,
        standing: Option<StopReason>,
        tolerance: f64,
        is_short: bool,
    ) {
        let line = segment.line;
        let tail = self.tail.take();
        let (first_line, from) =
            tail.as_ref().map_or((line, self.travelled), |tail| (tail.line, tail.distance.0));
        let seconds = seconds + tail.map_or(0.0, |tail| tail.seconds);
        let lines = (first_line.min(line), first_line.max(line));
        if let Some(standing) = standing {
            return self.report(LossReason::Ramp(standing), lines, (from, to), seconds);
        }
        let is_row = |row: &TimeLoss| matches!(row.reason, LossReason::ShortBlocks { .. });
        if is_short && !self.row.as_ref().is_some_and(is_row) {
            self.end_row();
            let reason = LossReason::ShortBlocks { blocks: 0 };
            self.row = Some(TimeLoss { reason, lines, distance: (from, to), seconds });
        } else if let Some(row) = self.row.as_mut().filter(|row| is_row(row)) {
            row.seconds += seconds;
            row.distance.1 = to;
        } else if let Some(before) = index.checked_sub(1) {
            let before = self.toolpath.segments.at(before);
            let (u1, u2) = (before.tangent(before.length), segment.tangent(0.0));
            let turn = 2.0 * (u2 - u1).norm().atan2((u2 + u1).norm());
            self.report(LossReason::Corner { turn, tolerance }, lines, (from, to), seconds);
        }
    }

    fn extend_row(&mut self, segment: &Segment, is_rapid: bool, seconds: f64, (from, to): (f64, f64)) {
        let line = segment.line;
        let is_like = |row: &TimeLoss| matches!(row.reason, LossReason::Rapid { .. }) == is_rapid;
        let is_too_long = |row: &TimeLoss| !is_rapid && self.max_row_length < to - row.distance.0;
        let goes_on = self.row.as_ref().is_some_and(|row| is_like(row) && !is_too_long(row));
        let is_begun =
            self.row.as_ref().is_some_and(|row| row.reason == LossReason::ShortBlocks { blocks: 0 });
        if !(goes_on || is_begun && !is_rapid) {
            self.end_row();
        }
        let none =
            if is_rapid { LossReason::Rapid { blocks: 0 } } else { LossReason::ShortBlocks { blocks: 0 } };
        let begun = TimeLoss { reason: none, lines: (line, line), distance: (from, to), seconds: 0.0 };
        let row = self.row.get_or_insert(begun);
        if let LossReason::Rapid { blocks } | LossReason::ShortBlocks { blocks } = &mut row.reason {
            *blocks += 1;
        }
        row.lines = (row.lines.0.min(line), row.lines.1.max(line));
        row.distance.1 = to;
        row.seconds += seconds;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;
    use crate::simulation::simulate;

    /// Returns all places of a program on a machine at 10 µm, and the total lost time.
    fn places(program: &str, machine: &Machine) -> (Vec<TimeLoss>, f64) {
        let toolpath = trace(&read(program.as_bytes()), machine);
        let tolerances = Tolerances::One(0.010);
        let (plan, _) = simulate::within(&toolpath, machine, tolerances, &mut |_| {});
        let mut all = Vec::new();
        each_place(&toolpath, machine, &plan, tolerances, &mut |place| all.push(place));
        (all, total(&toolpath, machine, &plan))
    }

    /// A program with every kind of place.
    fn of_all_kinds() -> String {
        let mut program = String::from(
            "G21 G90 G94\nT1 M6\nG0 X0 Y0\nG1 X30 F3000\nG1 Y30\nG2 X40 Y20 I0 J-10\nG4 P0.5\nM8\nG0 Z5\nG0 X0\n",
        );
        for i in 1..200 {
            program += &format!("G1 X{:.3} Y{:.3}\n", i as f64 * 0.2, if i % 3 == 0 { 0.3 } else { 0.0 });
        }
        program + "G1 X200\nG9 G1 Y80\nG1 X0\nM30\n"
    }

    fn machines() -> Vec<Machine> {
        let plain = Machine::default();
        let mut limited = plain.clone();
        for axis in &mut limited.axes {
            axis.acceleration = 900.0;
        }
        let mut halting = plain.clone();
        halting.halts.feed_holds.insert(4, 2.5);
        halting.times.start = 3.0;
        halting.rapid.exact_stop = true;
        vec![plain, limited, halting]
    }

    #[test]
    fn places_add_up_to_all_that_is_lost() {
        for machine in machines() {
            let (all, total) = places(&of_all_kinds(), &machine);
            let sum: f64 = all.iter().map(|place| place.seconds).sum();
            assert!(0.0 < total);
            assert!((sum / total - 1.0).abs() < 1e-9, "{sum} s in places, {total} s in all");
        }
    }

    #[test]
    fn places_follow_one_another_along_the_path() {
        for machine in machines() {
            let (all, _) = places(&of_all_kinds(), &machine);
            for place in &all {
                assert!(place.distance.0 <= place.distance.1, "{place:?}");
                assert!(place.lines.0 <= place.lines.1, "{place:?}");
            }
        }
    }

    #[test]
    fn the_costliest_come_first_and_are_the_largest() {
        let machine = Machine::default();
        let toolpath = trace(&read(of_all_kinds().as_bytes()), &machine);
        let tolerances = Tolerances::One(0.010);
        let (plan, _) = simulate::within(&toolpath, &machine, tolerances, &mut |_| {});
        let told = lost_times(&toolpath, &machine, &plan, tolerances);
        let (mut all, total) = places(&of_all_kinds(), &machine);
        all.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
        assert_eq!(told.total, total);
        assert_eq!(told.places.len(), MAX_LISTED_LOSSES);
        let seconds = |places: &[TimeLoss]| places.iter().map(|place| place.seconds).collect::<Vec<_>>();
        assert_eq!(seconds(&told.places), seconds(&all[..MAX_LISTED_LOSSES]));
    }

    #[test]
    fn a_corner_between_long_lines_is_one_place() {
        let (all, total) = places("G21 G90 G94\nG1 X50 F3000\nG1 Y50\nG1 X51\n", &Machine::default());
        let corner =
            all.iter().find(|place| matches!(place.reason, LossReason::Corner { .. })).expect("a corner");
        let LossReason::Corner { turn, tolerance } = corner.reason else { unreachable!() };
        assert!((turn - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert_eq!(tolerance, 0.010);
        assert_eq!(corner.lines, (LineNumber(2), LineNumber(3)));
        assert!(corner.distance.0 < 50.0 && 50.0 < corner.distance.1);
        assert!(0.0 < corner.seconds && corner.seconds < total);
    }

    #[test]
    fn a_staircase_is_one_row_of_short_blocks() {
        let stairs: String =
            (1..=40).map(|i| format!("G1 X{} Y{}\n", 20.0 + i as f64 * 0.1, (i % 2) as f64 * 0.1)).collect();
        let (all, total) =
            places(&format!("G21 G90 G94\nG1 X20 F3000\n{stairs}G1 X2000\n"), &Machine::default());
        let rows: Vec<_> =
            all.iter().filter(|place| matches!(place.reason, LossReason::ShortBlocks { .. })).collect();
        assert_eq!(rows.len(), 1, "{all:?}");
        assert_eq!(rows[0].reason, LossReason::ShortBlocks { blocks: 40 });
        assert!(0.5 * total < rows[0].seconds);
    }

    #[test]
    fn a_long_surface_is_divided() {
        let surface: String =
            (1..=4000).map(|i| format!("G1 X{:.2} Y{}\n", i as f64 * 0.1, (i % 2) as f64 * 0.1)).collect();
        let (all, _) = places(&format!("G21 G90 G94\nF3000\n{surface}"), &Machine::default());
        let length = all.iter().map(|place| place.distance.1).fold(0.0, f64::max);
        assert!(90 < all.len());
        assert!(all.iter().all(|place| place.distance.1 - place.distance.0 < 0.011 * length));
    }

    #[test]
    fn waits_are_lost_whole() {
        let mut machine = Machine::default();
        machine.times.tool_change = 4.0;
        let (all, _) = places("G21 G90 G94\nT1 M6\nG1 X50 F3000\nG4 P1.5\nG1 X100\n", &machine);
        let waits: Vec<(StopCause, f64)> = all
            .iter()
            .filter_map(|place| match place.reason {
                LossReason::Wait(cause) => Some((cause, place.seconds)),
                _ => None,
            })
            .collect();
        assert_eq!(waits.len(), 2, "{all:?}");
        assert!(matches!(waits[0], (StopCause::ToolChange { tool: Some(1) }, 4.0)));
        assert!(matches!(waits[1], (StopCause::Dwell { .. }, 1.5)));
        let ramps: Vec<LossReason> = all
            .iter()
            .map(|place| place.reason)
            .filter(|reason| matches!(reason, LossReason::Ramp(_)))
            .collect();
        assert_eq!(ramps.len(), 3, "before, at and after the dwell: {ramps:?}");
        assert!(matches!(ramps[1], LossReason::Ramp(StopReason::For(StopCause::Dwell { .. }))));
        assert_eq!(ramps[2], LossReason::Ramp(StopReason::End));
    }
}
