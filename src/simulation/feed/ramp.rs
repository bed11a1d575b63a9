//! Curved changes of the commanded feedrate: with constant jerk, and of fifth order.
//!
//! ```text
//!  T = 2 √(Δv/J)           while Δv J ≤ A²,
//!  T = Δv/A + A/J          beyond;           length = (v1 + v2) T / 2
//! ```
//!
//! (Δv step of the feedrate, J jerk and A acceleration along the path.) On a planner without filters, J is at most
//! min_k J_k / |u_k|, with the jerk limit J_k of axis k and the unit tangent u. A block then has the shape of
//! [`block`]: holds at its corners, ramps, and F between them; if there is no room for F the ramps meet below
//! F. The filters smooth the rest, so that corners keep their tolerance. A ramp becomes [`PIECES_PER_RAMP`]
//! linear pieces, without filters [`PIECES_WITHOUT_FILTERS`]. Their ends lie on the curve, which is symmetric about its
//! middle, so that the area is exact.
//!
//! Ramps of constant acceleration may run on a curve of fifth order instead, which takes as long and begins and ends without
//! acceleration: after the part τ of the time the part 10 τ³ − 15 τ⁴ + 6 τ⁵ of the step is done. It is symmetric, too. Source:
//! Marlin, stepper.cpp (`S_CURVE_ACCELERATION`).
//!
//! Source: textbooks on jerk-limited motion; examples are SOFT of Siemens and Heidenhain's law of the jerk
//! alone. On two recorded mills rapids and feed moves both follow T = 2 √(Δv/J). Limits: the law describes a
//! whole step; a ramp through several blocks starts again at each corner that slows it down.
//!
//! [`block`]: crate::simulation::feed::block

use crate::simulation::feed::block::{BlockEnd, BlockPart};

/// Number of linear pieces that make a ramp.
const PIECES_PER_RAMP: usize = 6;
/// Number of linear pieces that make a ramp which no filter smooths. The time is the same; the shape of recorded ramps is off
/// by less than a hundredth.
const PIECES_WITHOUT_FILTERS: usize = 16;

/// The law of ramps.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    /// Jerk, mm/s³; finite.
    jerk: f64,
    /// Acceleration, mm/s²; may be infinite.
    acceleration: f64,
}

impl Ramp {
    /// Returns the law of these limits along the path (mm/s³, mm/s²); `None` if the jerk is not limited.
    #[inline]
    pub fn of(jerk: f64, acceleration: f64) -> Option<Ramp> {
        jerk.is_finite().then_some(Ramp { jerk, acceleration })
    }

    /// Returns the time for which the acceleration rises, or falls, within a step of the feedrate (mm/s), s.
    fn rise(&self, step: f64) -> f64 {
        (step / self.jerk).sqrt().min(self.acceleration / self.jerk)
    }

    /// Returns the duration of a ramp between two feedrates (mm/s), s.
    fn time(&self, from: f64, to: f64) -> f64 {
        let step = (to - from).abs();
        let rise = self.rise(step);
        if step == 0.0 { 0.0 } else { rise + step / (self.jerk * rise) }
    }

    /// Returns the length of a ramp between two feedrates (mm/s), mm.
    fn length(&self, from: f64, to: f64) -> f64 {
        0.5 * (from + to) * self.time(from, to)
    }

    /// Returns the largest feedrate, at most `most`, that is reached from `from` (mm/s) within `length` (mm).
    pub fn reach(&self, from: f64, length: f64, most: f64) -> f64 {
        if most <= from || self.length(from, most) <= length {
            return most;
        }
        largest(from, most, |to| (self.length(from, to) - length, self.slope(from, to)))
    }

    /// Returns the derivative of the length of a ramp by the feedrate of its faster end (mm/s), s.
    fn slope(&self, slower: f64, faster: f64) -> f64 {
        let rise = self.rise(faster - slower);
        let change = if rise < self.acceleration / self.jerk { self.jerk * rise } else { self.acceleration };
        0.5 * (self.time(slower, faster) + (slower + faster) / change)
    }

    /// Returns the parts of a block of `length` (mm) at `feedrate` (mm/s) in order: hold, ramp, cruise, ramp,
    /// hold.
    pub fn parts(&self, length: f64, feedrate: f64, first: BlockEnd, last: BlockEnd) -> [BlockPart; 5] {
        let through = |peak: f64| self.length(first.feedrate, peak) + self.length(peak, last.feedrate);
        let between = self.length(first.feedrate, last.feedrate);
        let room = length - first.feedrate * first.hold - last.feedrate * last.hold;
        let (slower, faster) = if first.feedrate <= last.feedrate { (first, last) } else { (last, first) };
        let (peak, cruise, [slow, fast]) = if through(feedrate) <= room {
            (feedrate, (room - through(feedrate)) / feedrate, [slower.hold, faster.hold])
        } else if between < room {
            let slope = |peak: f64| self.slope(first.feedrate, peak) + self.slope(last.feedrate, peak);
            let peak = largest(faster.feedrate, feedrate, |peak| (through(peak) - room, slope(peak)));
            (peak, (room - through(peak)).max(0.0) / peak, [slower.hold, faster.hold])
        } else {
            let room = (length - between).max(0.0);
            let hold = |end: BlockEnd, room: f64| if end.feedrate == 0.0 { 0.0 } else { room / end.feedrate };
            let kept = slower.hold.min(hold(slower, room));
            (faster.feedrate, 0.0, [kept, hold(faster, (room - kept * slower.feedrate).max(0.0))])
        };
        let [before, after] = if first.feedrate <= last.feedrate { [slow, fast] } else { [fast, slow] };
        let ramp = |from: f64, to: f64| (self.time(from, to), from, to);
        [
            (before, first.feedrate, first.feedrate),
            ramp(first.feedrate, peak),
            (cruise, peak, peak),
            ramp(peak, last.feedrate),
            (after, last.feedrate, last.feedrate),
        ]
    }

    /// Returns the linear pieces of a part, which filters smooth or not.
    pub fn pieces(
        self,
        (duration, from, to): BlockPart,
        has_filters: bool,
    ) -> impl Iterator<Item = BlockPart> {
        let count = if has_filters { PIECES_PER_RAMP } else { PIECES_WITHOUT_FILTERS };
        let along =
            move |piece: usize| self.along(from, to, duration * piece as f64 / count as f64, duration);
        pieces_on_curve((duration, from, to), count, along)
    }

    /// Returns the feedrate at a time within a ramp, mm/s.
    fn along(&self, from: f64, to: f64, time: f64, duration: f64) -> f64 {
        let (left, step) = (duration - time, (to - from).abs());
        let rise = self.rise(step);
        let covered = if time <= rise {
            0.5 * self.jerk * time * time
        } else if rise <= left {
            self.jerk * rise * (time - 0.5 * rise)
        } else {
            step - 0.5 * self.jerk * left * left
        };
        from + (to - from).signum() * covered
    }
}

/// Returns the linear pieces of a part whose ramps are curves of fifth order.
pub fn quintic((duration, from, to): BlockPart) -> impl Iterator<Item = BlockPart> {
    let along = move |piece: usize| {
        let part = piece as f64 / PIECES_WITHOUT_FILTERS as f64;
        from + (to - from) * part.powi(3) * (10.0 - 15.0 * part + 6.0 * part * part)
    };
    pieces_on_curve((duration, from, to), PIECES_WITHOUT_FILTERS, along)
}

/// Returns `count` linear pieces of a part, one if the feedrate does not change; `along` returns the feedrate at the beginning
/// of each piece but the first, mm/s.
fn pieces_on_curve(
    (duration, from, to): BlockPart,
    count: usize,
    along: impl Fn(usize) -> f64,
) -> impl Iterator<Item = BlockPart> {
    let count = if from == to { 1 } else { count };
    let at = move |piece: usize| match piece {
        0 => from,
        _ if piece == count => to,
        _ => along(piece),
    };
    (0..count).map(move |piece| (duration / count as f64, at(piece), at(piece + 1)))
}

/// Returns the largest value between `low` and `high` at which an excess is not positive, by Newton steps within the
/// interval that is left. `excess` returns the excess, which grows from at most 0 at `low` to more than 0 at `high`,
/// and its derivative.
fn largest(mut low: f64, mut high: f64, excess: impl Fn(f64) -> (f64, f64)) -> f64 {
    let mut value = high;
    while 1e-13 * high < high - low {
        let (over, slope) = excess(value);
        if over <= 0.0 {
            low = value
        } else {
            high = value
        }
        let middle = 0.5 * (low + high);
        // A little further, so that the last steps come from both sides.
        let next = value - over / slope - 2e-14 * high * over.signum();
        value = if low < next && next < high { next } else { middle };
        if middle <= low || high <= middle {
            break;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{Machine, Planner};
    use crate::simulation::feed::{Tolerances, command};
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    const STOP: BlockEnd = BlockEnd { feedrate: 0.0, hold: 0.0 };

    fn area(ramp: Ramp, parts: &[BlockPart]) -> f64 {
        let pieces = parts.iter().flat_map(|part| ramp.pieces(*part, false));
        pieces.map(|(time, from, to)| 0.5 * time * (from + to)).sum()
    }

    #[test]
    fn the_area_is_the_length() {
        for jerk in [1e3, 33e3, 1e7] {
            for acceleration in [f64::INFINITY, 2000.0, 50.0] {
                let ramp = Ramp { jerk, acceleration };
                for length in [0.01, 0.3, 5.0, 200.0] {
                    for (one, other) in [(0.0, 0.0), (3.0, 0.0), (2.0, 9.0), (9.0, 9.0)] {
                        let other = ramp.reach(one, length, other).max(0.0);
                        let end =
                            |feedrate: f64| BlockEnd { feedrate, hold: 0.004 * f64::from(feedrate > 0.0) };
                        for (first, last) in [(end(one), end(other)), (end(other), end(one))] {
                            if ramp.length(one, other) <= length {
                                let parts = ramp.parts(length, 90.0, first, last);
                                assert!(
                                    (area(ramp, &parts) / length - 1.0).abs() < 1e-9,
                                    "{ramp:?} {parts:?}"
                                );
                            }
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_ramp_lasts_as_long_as_the_law_says() {
        let ramp = Ramp { jerk: 33e3, acceleration: f64::INFINITY };
        assert!((ramp.time(0.0, 500.0) - 2.0 * (500.0f64 / 33e3).sqrt()).abs() < 1e-12);
        let ramp = Ramp { jerk: 33e3, acceleration: 1000.0 };
        assert!((ramp.time(100.0, 500.0) - (0.4 + 1.0 / 33.0)).abs() < 1e-12);
    }

    #[test]
    fn a_move_from_stand_to_stand_takes_the_cube_root_of_its_length() {
        let ramp = Ramp { jerk: 33e3, acceleration: f64::INFINITY };
        for length in [0.01f64, 1.0, 60.0] {
            let time: f64 = ramp.parts(length, 1e6, STOP, STOP).iter().map(|part| part.0).sum();
            assert!((time / (32.0 * length / 33e3).powf(1.0 / 3.0) - 1.0).abs() < 1e-9);
        }
    }

    /// Between the ends of a piece of h s, a curve of constant jerk J is up to J h²/8 off its chord.
    #[test]
    fn pieces_lie_on_the_curve_and_are_finer_without_filters() {
        let ramp = Ramp { jerk: 12e3, acceleration: f64::INFINITY };
        let duration = ramp.time(10.0, 60.0);
        let furthest = |has_filters: bool| {
            let (mut time, mut furthest) = (0.0, 0.0_f64);
            let pieces: Vec<BlockPart> = ramp.pieces((duration, 10.0, 60.0), has_filters).collect();
            for (lasts, from, to) in &pieces {
                assert!((from - ramp.along(10.0, 60.0, time, duration)).abs() < 1e-9);
                let middle = ramp.along(10.0, 60.0, time + 0.5 * lasts, duration);
                furthest = furthest.max((0.5 * (from + to) - middle).abs());
                time += lasts;
            }
            let piece = duration / pieces.len() as f64;
            assert!((furthest / (12e3 * piece * piece / 8.0) - 1.0).abs() < 1e-9, "{furthest}");
            furthest
        };
        assert!((furthest(true) / furthest(false) - (16.0_f64 / 6.0).powi(2)).abs() < 1e-6);
    }

    /// The steepest piece is in the middle, where the derivative of the curve is 15/8.
    #[test]
    fn quintic_ramps_keep_time_and_length_and_begin_gently() {
        for (from, to) in [(5.0, 60.0), (60.0, 5.0), (60.0, 60.0)] {
            let pieces: Vec<BlockPart> = quintic((0.4, from, to)).collect();
            let time: f64 = pieces.iter().map(|piece| piece.0).sum();
            let area: f64 = pieces.iter().map(|(time, a, b)| 0.5 * time * (a + b)).sum();
            assert!((time - 0.4).abs() < 1e-12);
            assert!((area - 0.4 * 0.5 * (from + to)).abs() < 1e-12);
            let slope = |(time, a, b): &BlockPart| (b - a) / time * 0.4;
            let steepest = pieces.iter().map(|piece| slope(piece).abs()).fold(0.0, f64::max);
            assert!((steepest / (to - from).abs().max(1e-9) - 1.875).abs() < 0.02 || from == to);
            assert!(slope(&pieces[0]).abs() <= 0.05 * (to - from).abs());
        }
    }

    #[test]
    fn more_jerk_never_takes_longer() {
        let program = "G1 X10 F3000\nY5\nX10.5\nY5.2\nX20 Y9\nG2 X25 Y14 I0 J5\nG1 X25.1 F500\nX60 F5000\n";
        let mut before = f64::INFINITY;
        for jerk in [1e3, 1e4, 1e5, 1e6, 1e9, f64::INFINITY] {
            let mut machine = Machine::default();
            machine.path.jerk = jerk;
            let toolpath = trace(&read(program.as_bytes()), &machine);
            let time = command(&toolpath, &machine, Tolerances::Programmed.into()).cycle_time();
            assert!(time <= before, "{jerk}: {time}, {before}");
            before = time;
        }
    }

    /// Two axes of equal jerk that share a motion equally have √2 times that jerk along the path.
    #[test]
    fn the_axis_that_moves_furthest_limits_the_jerk() {
        let time = |program: &str, change: &dyn Fn(&mut Machine)| {
            let mut machine = Machine::default();
            machine.become_planner(Planner::JunctionDeviation, 5000.0);
            change(&mut machine);
            let toolpath = trace(&read(program.as_bytes()), &machine);
            command(&toolpath, &machine, Tolerances::Programmed.into()).cycle_time()
        };
        let of_axes = |machine: &mut Machine| machine.axes.iter_mut().for_each(|axis| axis.jerk = 20e3);
        let along = |jerk: f64| move |machine: &mut Machine| machine.path.jerk = jerk;
        assert_eq!(time("G1 X9 F3000\nX0\n", &of_axes), time("G1 X9 F3000\nX0\n", &along(20e3)));
        let diagonal = "G1 X9 Y9 F3000\nX0 Y0\n";
        let expected = time(diagonal, &along(20e3 * std::f64::consts::SQRT_2));
        assert!((time(diagonal, &of_axes) - expected).abs() < 1e-9);
        // The lower of both limits holds.
        let both = |machine: &mut Machine| (machine.axes[0].jerk, machine.path.jerk) = (20e3, 5e3);
        assert_eq!(time("G1 X9 F3000\n", &both), time("G1 X9 F3000\n", &along(5e3)));
        // Filters smooth their ramps themselves.
        let without = |machine: &mut Machine| {
            *machine = Machine::default();
            machine.interpolator.filters = 1;
        };
        let with_jerks = |machine: &mut Machine| {
            without(machine);
            of_axes(machine);
        };
        assert_eq!(time(diagonal, &with_jerks), time(diagonal, &without));
    }

    /// A planner that knows few blocks stops within these, and each ramp ends in its block.
    #[test]
    fn a_short_look_ahead_slows_chains_of_short_blocks() {
        let program: String = (1..=60).map(|x| format!("G1 X{x} F6000\n")).collect();
        let mut machine = Machine::default();
        machine.become_planner(Planner::JunctionDeviation, 5000.0);
        machine.path.jerk = 20e3;
        let toolpath = trace(&read(program.as_bytes()), &machine);
        let fastest = |look_ahead: f64| {
            let mut machine = machine.clone();
            machine.interpolator.look_ahead = look_ahead;
            let plan = command(&toolpath, &machine, Tolerances::Programmed.into());
            plan.corner_feedrates.iter().copied().fold(0.0, f64::max)
        };
        let ramp = Ramp { jerk: 20e3, acceleration: 5000.0 };
        // Of five blocks the first is run, so a stop takes the other four.
        let reached = (0..4).fold(0.0, |from, _| ramp.reach(from, 1.0, 100.0));
        assert!((fastest(5.0) - reached).abs() < 1e-9, "{} {reached}", fastest(5.0));
        assert!(fastest(5.0) < 0.8 * fastest(15.0));
    }
}
