//! A feed hold in the pulses of a motion: rest at a place of the path.
//!
//! A hold of t seconds costs t exactly, however short it is: the command is later by t from there on, and its area does not
//! change. Where accelerations limit the command, it brakes for the place and speeds up behind it as on its segments,
//!
//! ```text
//!  v(s)² ≤ 2 ∫ a ds  from the place,        rest = t − c
//!
//!  v │ ────╮                 ╭────
//!    │      ╲               ╱
//!    └───────╲_____________╱───────  time
//!             │←  t − c  →│
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | s | distance from the place along the path | mm |
//! | a | acceleration limit of the segment | mm/s² |
//! | c | what both ramps cost | s |
//!
//! Without such limits c is 0: the command is interrupted, and filters make the ramps. A hold that costs less than c would not
//! bring the tool to rest; it interrupts the command as well.
//!
//! Source: the planner's own ramps to a stop, as in LinuxCNC, grbl and Klipper. Limits: a jerk limit does not shape these
//! ramps. On an arc that blends a corner LinuxCNC brakes with half of the acceleration; here it has the whole one.

use crate::machine::Machine;
use crate::simulation::feed::{Pulse, junction};
use crate::simulation::toolpath::Segments;

/// A feed hold.
#[derive(Clone, Copy, Debug)]
pub struct FeedHold {
    /// Index of the segment.
    pub segment: usize,
    /// Distance along the segment, mm.
    pub along: f64,
    /// Duration, s.
    pub duration: f64,
}

impl FeedHold {
    /// Returns the pulses of a motion with the hold among them.
    pub fn put_into(self, pulses: &[Pulse], segments: &Segments, machine: &Machine) -> Vec<Pulse> {
        let limit = |pulse: &Pulse| {
            if !machine.limits_command() {
                return f64::INFINITY;
            }
            let segment = segments.at(pulse.segment as usize);
            let own = junction::acceleration_before_turn(&segment, machine);
            junction::acceleration_of_ramps(&segment, own, machine)
        };
        let (before, after) = self.divided(pulses);
        let reversed = |pulses: &[Pulse]| pulses.iter().rev().map(Pulse::reversed).collect::<Vec<Pulse>>();
        let (braking, cost_before) = from_rest(&reversed(&before), limit);
        let (speeding_up, cost_after) = from_rest(&after, limit);
        let rest = |duration: f64| Pulse {
            segment: self.segment as u32,
            duration,
            offset: self.along,
            feedrate: [0.0, 0.0],
        };
        let remaining = self.duration - cost_before - cost_after;
        match remaining <= 0.0 {
            true => [before, vec![rest(self.duration)], after].concat(),
            false => [reversed(&braking), vec![rest(remaining)], speeding_up].concat(),
        }
    }

    /// Returns the pulses before and behind the place of the hold.
    fn divided(self, pulses: &[Pulse]) -> (Vec<Pulse>, Vec<Pulse>) {
        let is_before = |pulse: &Pulse| (pulse.segment as usize, pulse.offset) <= (self.segment, self.along);
        let index = pulses.iter().rposition(is_before).unwrap_or(0);
        let (first, last) = pulses.split_at(index);
        let Some((pulse, last)) = last.split_first() else { return (first.to_vec(), Vec::new()) };
        let is_on_segment = pulse.segment as usize == self.segment;
        let way = if is_on_segment { self.along - pulse.offset } else { f64::INFINITY };
        let [before, after] = pulse.divided(way);
        let before = first.iter().copied().chain(before);
        let after = after.into_iter().chain(last.iter().copied());
        (before.collect(), after.collect())
    }
}

impl Pulse {
    /// Returns the length of its path, mm.
    fn length(&self) -> f64 {
        0.5 * self.duration * (self.feedrate[0] + self.feedrate[1])
    }

    /// Returns the parts before and behind a way from its beginning, mm; `None` for a part without length.
    fn divided(&self, way: f64) -> [Option<Pulse>; 2] {
        let [first, last] = self.feedrate;
        if way <= 0.0 {
            return [None, Some(*self)];
        }
        if self.length() <= way {
            return [Some(*self), None];
        }
        let slope = (last - first) / self.duration;
        // first t + slope t²/2 = way, without a difference of like numbers.
        let there = (first * first + 2.0 * slope * way).max(0.0).sqrt();
        let duration = (2.0 * way / (first + there)).min(self.duration);
        let offset = self.offset + way;
        let rest = Pulse { duration: self.duration - duration, offset, feedrate: [there, last], ..*self };
        [Some(Pulse { duration, feedrate: [first, there], ..*self }), (0.0 < rest.duration).then_some(rest)]
    }

    /// Returns the pulse run backwards, with the sign of distances along its segment changed.
    fn reversed(&self) -> Pulse {
        let [first, last] = self.feedrate;
        Pulse { offset: -(self.offset + self.length()), feedrate: [last, first], ..*self }
    }
}

/// Returns pulses that begin at rest and are no faster than an acceleration `limit` (mm/s²) and the given pulses allow, with the
/// same area, and the time that they last longer, s.
fn from_rest(pulses: &[Pulse], limit: impl Fn(&Pulse) -> f64) -> (Vec<Pulse>, f64) {
    let mut slowed = Vec::new();
    let mut cost = 0.0;
    let mut feedrate = 0.0;
    for (index, pulse) in pulses.iter().enumerate() {
        let (length, acceleration) = (pulse.length(), limit(pulse));
        let [first, last] = pulse.feedrate;
        if first <= feedrate || length == 0.0 || acceleration == f64::INFINITY {
            slowed.extend(&pulses[index..]);
            break;
        }
        // The feedrate² of both grows evenly with the distance; where they meet, the ramp ends.
        let approach = 2.0 * acceleration - (last * last - first * first) / length;
        let meeting = if 0.0 < approach { (first * first - feedrate * feedrate) / approach } else { length };
        let way = meeting.min(length);
        let reached = (feedrate * feedrate + 2.0 * acceleration * way).sqrt();
        let ramp =
            Pulse { duration: 2.0 * way / (feedrate + reached), feedrate: [feedrate, reached], ..*pulse };
        let [replaced, rest] = pulse.divided(way);
        cost += ramp.duration - replaced.map_or(0.0, |own| own.duration);
        slowed.push(ramp);
        if meeting < length {
            slowed.extend(rest);
            slowed.extend(&pulses[index + 1..]);
            break;
        }
        feedrate = reached;
    }
    (slowed, cost)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Planner;
    use crate::simulation::feed::{Tolerances, command};
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    /// Returns a machine with 500 mm/s² in each axis and a hold at a part of a line.
    fn held(planner: Option<Planner>, line: u32, place: f64, seconds: f64) -> Machine {
        let mut machine = Machine::default();
        if let Some(planner) = planner {
            machine.become_planner(planner, 500.0);
        }
        machine.halts.feed_holds.insert(line, seconds);
        machine.halts.feed_hold_places.insert(line, place);
        machine
    }

    /// Short blocks, a corner and an arc: ramps of a hold go through several of them.
    const PROGRAM: &str = "G1 X30 F3000\nX31\nX32 Y0.5\nX33 Y1\nY20\nG3 X23 Y30 I-10 J0\nG1 X0\nY0";

    #[test]
    fn a_hold_costs_its_duration_on_every_control() {
        for planner in [None].into_iter().chain(Planner::ALL.map(Some)) {
            for (line, place) in [(1, 0.5), (1, 0.99), (3, 0.0), (4, 0.3), (6, 0.7), (8, 1.0)] {
                for seconds in [0.01, 0.08, 0.3, 5.0] {
                    let machine = held(planner, line, place, seconds);
                    let mut without = machine.clone();
                    without.halts.feed_holds.clear();
                    let toolpath = trace(&read(PROGRAM.as_bytes()), &machine);
                    let [with, without] = [machine, without]
                        .map(|own| command(&toolpath, &own, Tolerances::Programmed.into()).cycle_time());
                    let cost = with - without;
                    assert!((cost - seconds).abs() < 1e-9, "{planner:?}, line {line}: {cost} of {seconds} s");
                }
            }
        }
    }

    /// Returns the pulses of a program before and behind the rest of its only hold, outwards, and the duration of the rest, s.
    fn around_rest(program: &str, machine: &Machine) -> ([Vec<Pulse>; 2], f64) {
        let toolpath = trace(&read(program.as_bytes()), machine);
        let plan = command(&toolpath, machine, Tolerances::Programmed.into());
        let pulses: Vec<Pulse> = plan.pulses.range(0..plan.pulses.len()).collect();
        let rest = pulses.iter().position(Pulse::is_halt).expect("the machine halts");
        let before = pulses[..rest].iter().rev().map(Pulse::reversed).collect();
        ([before, pulses[rest + 1..].to_vec()], pulses[rest].duration)
    }

    /// On a long line of 50 mm/s with 500 mm/s², both ramps take 0.1 s and cost half of that, and they are 2.5 mm long.
    #[test]
    fn a_planner_brakes_for_a_hold_within_its_acceleration() {
        for planner in Planner::ALL {
            let machine = held(Some(planner), 1, 0.5, 1.0);
            let (sides, rest) = around_rest("G1 X100 F3000", &machine);
            assert!((rest - 0.9).abs() < 1e-9, "{planner:?}: {rest} s");
            for ramp in sides.map(|side| side[0]) {
                assert!((ramp.duration - 0.1).abs() < 1e-9 && (ramp.length() - 2.5).abs() < 1e-9, "{ramp:?}");
                assert_eq!(ramp.feedrate[0], 0.0);
                assert!((ramp.offset.abs() - 50.0).abs() < 1e-9, "{ramp:?}");
            }
        }
    }

    /// At a distance s from the place of a hold the command is √(2 a s).
    #[test]
    fn ramps_of_a_hold_go_through_short_blocks() {
        let machine = held(Some(Planner::JunctionDeviation), 20, 0.5, 2.0);
        let program = format!("G1 F3000\n{}", (1..40).map(|mm| format!("X{mm}\n")).collect::<String>());
        let (sides, _) = around_rest(&program, &machine);
        for side in sides {
            let ramp: Vec<&Pulse> = side.iter().take_while(|pulse| pulse.feedrate[0] < 49.0).collect();
            assert_eq!(ramp.len(), 3);
            let mut way = 0.0;
            for pulse in ramp {
                way += pulse.length();
                let expected = f64::sqrt(2.0 * 500.0 * way);
                assert!((pulse.feedrate[1] / expected - 1.0).abs() < 1e-9, "{pulse:?} after {way} mm");
            }
        }
    }
}
