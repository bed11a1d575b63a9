//! Where a plan loses most time against length over feedrate, and why.
//!
//! A move of length L (mm) at the feedrate F (mm/s) would take L / F; what it takes beyond that is lost, and so is
//! all time without a move. A pulse of the command that lasts t over the distance s loses t − s / F. The fastest
//! pulses of a block divide it:
//!
//! ```text
//!  F   - - - - - - - - - - - - -
//!            ______________          body: the feedrate is held below F
//!       ____/              \____     head and tail: they belong to the corners
//! ```
//!
//! | place | what it holds |
//! |---|---|
//! | corner | tail of the block before and head of the block after, where the motion goes on |
//! | short blocks | blocks in a row that are shorter than the filter delay D (L / F < D) or too short to reach their command, with the corners at both ends |
//! | limit | body of any other block: an arc at its tolerance, a limit of an axis, an override |
//! | acceleration | what a block loses behind the filters |
//! | ramp | tail and head at a full stop, and half of D before and after it |
//! | rapid | rapid moves in a row, against the rapid feedrate, with their ramps |
//! | wait, halt, start | time without a move; a turn of rotary axes as far as it is slower than programmed |
//!
//! Each second lost is in one place, so that all of them add up to the whole. Blocks in a row are divided where they
//! would be longer than a hundredth of the path, so that a place is one on a long surface too.

use crate::machine::Machine;
use crate::quote::shares::{programmed, programmed_wait};
use crate::simulation::feed::{FeedPlan, Phase, Pulse, Stretch, Tolerances};
use crate::simulation::gcode::LineNumber;
use crate::simulation::running_sum::running_sum;
use crate::simulation::toolpath::{Curve, Motion, Segment, StopCause, Toolpath};

/// How many places are told.
pub const MOST_PLACES: usize = 10;
/// The longest row of blocks that is one place, as a part of the path.
const LONGEST: f64 = 0.01;
/// A command is reached where no more than this part of it is missing.
const REACHED: f64 = 0.999;

/// Why time is lost at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reason {
    /// A corner that is passed at its tolerance.
    Corner {
        /// Angle by which the path turns, rad.
        turn: f64,
        /// What is allowed there, mm.
        tolerance: f64,
    },
    /// Blocks too short for their feedrate.
    ShortBlocks {
        /// How many.
        blocks: usize,
    },
    /// A feedrate held below the programmed one.
    Limit {
        /// Feedrate that is held, mm/s.
        feedrate: f64,
        /// Programmed feedrate, mm/s.
        programmed: f64,
        /// Whether it is along an arc.
        is_arc: bool,
    },
    /// Acceleration limits behind the filters.
    Acceleration,
    /// The motion ends and begins anew.
    Ramp(Standing),
    /// Rapid moves that do not reach, or do not keep, their feedrate.
    Rapid {
        /// How many.
        blocks: usize,
    },
    /// A function, a dwell or a turn of rotary axes.
    Wait(StopCause),
    /// A halt that the program does not ask for.
    Halt,
    /// Before the first block.
    Start,
}

/// Why the motion ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Standing {
    /// It begins with the program.
    Begin,
    /// It ends with the program.
    End,
    /// A function, a dwell or a turn of rotary axes.
    For(StopCause),
    /// An exact stop, of the program or of the machine.
    Exact,
}

/// A place where time is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LostAt {
    /// Why.
    pub reason: Reason,
    /// First and last line of the program that take part.
    pub lines: (LineNumber, LineNumber),
    /// Where it begins and ends along the path, mm.
    pub distance: (f64, f64),
    /// Time lost, s; below 0 where it is gained.
    pub seconds: f64,
}

/// The time a plan loses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lost {
    /// All of it, s: cycle time less length over feedrate.
    pub total: f64,
    /// The places that lose most, in order of their time.
    pub places: Vec<LostAt>,
}

/// What a plan loses, with the places that cost most.
pub fn lost(toolpath: &Toolpath, machine: &Machine, plan: &FeedPlan, tolerances: Tolerances) -> Lost {
    let mut places: Vec<LostAt> = Vec::with_capacity(MOST_PLACES + 1);
    each_place(toolpath, machine, plan, tolerances, &mut |place| {
        // What a rounding leaves behind is no place.
        if 1e-6 < place.seconds {
            let index = places.partition_point(|other| place.seconds <= other.seconds);
            if index < MOST_PLACES {
                places.truncate(MOST_PLACES - 1);
                places.insert(index, place);
            }
        }
    });
    Lost { total: total(toolpath, machine, plan), places }
}

/// Cycle time less length over feedrate, s.
fn total(toolpath: &Toolpath, machine: &Machine, plan: &FeedPlan) -> f64 {
    let moves = toolpath.segments.iter().map(|segment| -segment.length / programmed(&segment, machine));
    let turns = toolpath.stops.iter().filter(|stop| matches!(stop.cause, StopCause::Rotary { .. }));
    let turns = turns.map(|stop| -programmed_wait(&stop.cause, machine));
    running_sum([plan.cycle_time()].into_iter().chain(moves).chain(turns)).last().unwrap_or(0.0)
}

/// What a block loses before, on and after its fastest pulses (s), and where these lie along it (mm).
#[derive(Clone, Copy, Default)]
struct Division {
    head: f64,
    body: f64,
    tail: f64,
    from: f64,
    to: f64,
    peak: f64,
    halt: f64,
}

impl Division {
    fn of(pulses: &[Pulse], feedrate: f64) -> Division {
        let speed = |pulse: &Pulse| pulse.feedrate[0].max(pulse.feedrate[1]);
        let way = |pulse: &Pulse| pulse.duration * 0.5 * (pulse.feedrate[0] + pulse.feedrate[1]);
        // Of ramps that meet, the point where they do is the body.
        let cruise = |pulse: &Pulse| pulse.feedrate[0].min(pulse.feedrate[1]);
        let peak = pulses.iter().map(speed).fold(0.0, f64::max);
        let is_body = |pulse: &&Pulse| !pulse.is_halt() && REACHED * peak <= cruise(pulse);
        let turning = pulses.iter().find(|pulse| REACHED * peak <= speed(pulse));
        let turning = turning.map_or(0.0, |pulse| pulse.offset + way(pulse));
        let from = pulses.iter().find(is_body).map_or(turning, |pulse| pulse.offset);
        let to = pulses.iter().rfind(is_body).map_or(turning, |pulse| pulse.offset + way(pulse));
        let mut division = Division { from, to, peak, ..Division::default() };
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

/// The end of a block, which belongs to what comes after: a corner or a full stop.
struct Tail {
    line: LineNumber,
    /// Where it begins and ends along the path, mm.
    distance: (f64, f64),
    /// Time lost, s.
    seconds: f64,
}

/// A plan on its way from place to place.
struct Walk<'a> {
    toolpath: &'a Toolpath,
    machine: &'a Machine,
    found: &'a mut dyn FnMut(LostAt),
    /// The longest row of blocks, mm.
    longest: f64,
    /// Distance travelled, mm.
    travelled: f64,
    /// Blocks in a row that may go on: short ones, or rapids.
    row: Option<LostAt>,
    tail: Option<Tail>,
}

fn each_place(
    toolpath: &Toolpath,
    machine: &Machine,
    plan: &FeedPlan,
    tolerances: Tolerances,
    found: &mut dyn FnMut(LostAt),
) {
    let segments = &toolpath.segments;
    let longest = LONGEST * (0..segments.len()).map(|index| segments.length(index)).sum::<f64>();
    let mut walk = Walk { toolpath, machine, found, longest, travelled: 0.0, row: None, tail: None };
    let first = toolpath.segments.first().map_or(LineNumber(1), |segment| segment.line);
    walk.tell(Reason::Start, (first, first), (0.0, 0.0), plan.start);
    let mut corners = tolerances.bounds(toolpath, machine).map(|bound| bound.corner);
    let mut standing = Standing::Begin;
    for phase in &plan.phases {
        match phase {
            Phase::Wait(wait) => {
                walk.end_row();
                let turned = match wait.cause {
                    StopCause::Rotary { .. } => programmed_wait(&wait.cause, machine),
                    _ => 0.0,
                };
                let here = walk.travelled;
                walk.tell(
                    Reason::Wait(wait.cause),
                    (wait.line, wait.line),
                    (here, here),
                    wait.duration - turned,
                );
                if !matches!(standing, Standing::For(_)) {
                    standing = Standing::For(wait.cause);
                }
            }
            Phase::Motion(stretch) => {
                walk.stretch(plan, stretch, &mut corners, standing);
                standing = Standing::Exact;
            }
        }
    }
    walk.end_row();
    if !matches!(standing, Standing::For(_)) {
        standing = Standing::End;
    }
    if let Some(tail) = walk.tail.take() {
        walk.tell(Reason::Ramp(standing), (tail.line, tail.line), tail.distance, tail.seconds);
    }
}

impl Walk<'_> {
    fn tell(&mut self, reason: Reason, lines: (LineNumber, LineNumber), distance: (f64, f64), seconds: f64) {
        if seconds != 0.0 {
            (self.found)(LostAt { reason, lines, distance, seconds });
        }
    }

    fn end_row(&mut self) {
        if let Some(row) = self.row.take() {
            (self.found)(row);
        }
    }

    fn stretch(
        &mut self,
        plan: &FeedPlan,
        stretch: &Stretch,
        corners: &mut impl Iterator<Item = f64>,
        standing: Standing,
    ) {
        let (delay, half) = (plan.filters[stretch.filter].delay(), plan.filters[stretch.filter].half_delay());
        // Those left, and those of one block.
        let (mut pulses, mut own) = (stretch.pulses.clone(), Vec::new());
        let lost =
            plan.time_scaling.as_ref().map_or(&[][..], |found| found.lost_on(stretch.segments.clone()));
        let mut lost = lost.iter().peekable();
        let (first, last) = (stretch.segments.start, stretch.segments.end - 1);
        // What is allowed at the corner before.
        let mut tolerance = 0.0;
        self.end_row();
        for index in stretch.segments.clone() {
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
            let division = Division::of(&own, feedrate);
            let command = plan.segment_feedrates.get(index).copied().unwrap_or(feedrate).min(feedrate);
            let is_rapid = segment.motion == Motion::Rapid;
            let is_short =
                !is_rapid && (segment.length < delay * feedrate || division.peak < REACHED * command);
            let is_whole = is_rapid || is_short;

            let Division { head, body, tail, .. } = division;
            let begins = |stands: bool| if stands { half } else { 0.0 };
            let (before, after) = (begins(index == first), begins(index == last));
            let (here, there) = (self.travelled, self.travelled + segment.length);

            // The end of the block before, with the beginning of this one.
            let entering = if is_whole { 0.0 } else { head } + if is_rapid { 0.0 } else { before };
            let entered = if is_whole { here } else { here + division.from };
            self.pass(
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
                    self.tail = Some(Tail { line: segment.line, distance: (there, there), seconds: after });
                }
            } else {
                self.end_row();
                let held = Reason::Limit {
                    feedrate: division.peak,
                    programmed: feedrate,
                    is_arc: segment.curve != Curve::Line,
                };
                let lines = (segment.line, segment.line);
                self.tell(held, lines, (here + division.from, here + division.to), body);
                self.tell(Reason::Acceleration, lines, (here, there), behind);
                let distance = (here + division.to, there);
                self.tail = Some(Tail { line: segment.line, distance, seconds: tail + after });
            }
            self.tell(Reason::Halt, (segment.line, segment.line), (here, there), division.halt);
            tolerance = corners.next().unwrap_or(0.0);
            self.travelled = there;
        }
    }

    /// The border between the block before and this one is passed, which takes `seconds` more up to `to` (mm):
    /// a full stop, a corner, or part of a row of short blocks.
    fn pass(
        &mut self,
        (index, segment): (usize, &Segment),
        seconds: f64,
        to: f64,
        standing: Option<Standing>,
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
            return self.tell(Reason::Ramp(standing), lines, (from, to), seconds);
        }
        let is_row = |row: &LostAt| matches!(row.reason, Reason::ShortBlocks { .. });
        if is_short && !self.row.as_ref().is_some_and(is_row) {
            self.end_row();
            let reason = Reason::ShortBlocks { blocks: 0 };
            self.row = Some(LostAt { reason, lines, distance: (from, to), seconds });
        } else if let Some(row) = self.row.as_mut().filter(|row| is_row(row)) {
            row.seconds += seconds;
            row.distance.1 = to;
        } else if let Some(before) = index.checked_sub(1) {
            let before = self.toolpath.segments.at(before);
            let (u1, u2) = (before.tangent(before.length), segment.tangent(0.0));
            let turn = 2.0 * (u2 - u1).norm().atan2((u2 + u1).norm());
            self.tell(Reason::Corner { turn, tolerance }, lines, (from, to), seconds);
        }
    }

    fn extend_row(&mut self, segment: &Segment, is_rapid: bool, seconds: f64, (from, to): (f64, f64)) {
        let line = segment.line;
        let is_like = |row: &LostAt| matches!(row.reason, Reason::Rapid { .. }) == is_rapid;
        let is_too_long = |row: &LostAt| !is_rapid && self.longest < to - row.distance.0;
        let goes_on = self.row.as_ref().is_some_and(|row| is_like(row) && !is_too_long(row));
        let is_begun = self.row.as_ref().is_some_and(|row| row.reason == Reason::ShortBlocks { blocks: 0 });
        if !(goes_on || is_begun && !is_rapid) {
            self.end_row();
        }
        let none = if is_rapid { Reason::Rapid { blocks: 0 } } else { Reason::ShortBlocks { blocks: 0 } };
        let begun = LostAt { reason: none, lines: (line, line), distance: (from, to), seconds: 0.0 };
        let row = self.row.get_or_insert(begun);
        if let Reason::Rapid { blocks } | Reason::ShortBlocks { blocks } = &mut row.reason {
            *blocks += 1;
        }
        row.lines = (row.lines.0.min(line), row.lines.1.max(line));
        row.distance.1 = to;
        row.seconds += seconds;
    }
}

#[cfg(test)]
mod tests;
