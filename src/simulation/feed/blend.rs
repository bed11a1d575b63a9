//! The pulses of a rest-to-rest motion whose corners are circles or parabolas.
//!
//! A circle of radius R that turns by φ leaves one leg d = R tan(φ/2) before the corner and joins the other d
//! after it. It is Rφ long instead of 2d, and it has its own feedrate limit and acceleration. A segment of
//! length L therefore consists of three pieces, each run as a trapezoid of path speed v:
//!
//! ```text
//!  half of the arc       line          half of the arc
//!  |<-- κ1 d1 -->|<-- L − d1 − d2 -->|<-- κ2 d2 -->|        κ = ½ φ / tan(φ/2) ≤ 1
//! ```
//!
//! Along the whole rest-to-rest motion v² changes by no more than 2 A s over a piece of acceleration A
//! (mm/s²) and length s (mm), forwards and backwards. Distances are measured along the programmed path. A
//! circle run at the path speed v advances at v/κ along the programmed path, but never faster than the
//! requested feedrate.
//!
//! A line before a circle becomes part of the circle if the largest speed of that circle would cover the line in less than
//! four servo periods, unless the line begins with a parabola (`blendCheckConsume`, `tcCanConsume`).
//!
//! A feed move between two blends that takes less than 10 ms at the mean of its first and its last speed is one ramp
//! between the two, unless a parabola or a stop ends it: it speeds up no further in between (`arcBlendRampFreq`,
//! 100 Hz).
//!
//! The planner sees at most N lines and circles ahead and must be able to stop within them. Where piece k
//! begins,
//!
//! ```text
//! v² ≤ Σ 2 A s   over k, k+1, …, k+N−1          N look-ahead; where the rest-to-rest motion ends earlier, up to its end
//! ```
//!
//! A parabola is the part of the motion in which the first leg brakes while the second already speeds up. Its
//! path speed changes from the first value to the last with one acceleration. The first leg would come to a
//! stop at its own end, so the motion can always stop at a parabola. A parabola among these pieces lifts the limit.
//!
//! Limits: if a circle takes different lengths of the two legs, κ is the same for both. Circles are trapezoids however
//! short they are. Source: derived; the division, the gap of four periods, the short ramps (`tpActivateSegment`) and
//! the look-ahead (`tpRunOptimization`) are LinuxCNC's (src/emc/tp, tp.c and blendmath.c), and recordings of it.

use crate::simulation::feed::Pulse;
use crate::simulation::feed::block::{BlockEnd, BlockPart, parts};

/// A circle, or a parabola, in place of a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blend {
    /// Largest command at the corner, mm/s; 0 at a full stop.
    pub feedrate: f64,
    /// Largest command where the blend begins and where it ends, mm/s.
    pub ends: [f64; 2],
    /// Largest command at the corner if axes and overrides alone limited the legs, mm/s.
    pub fastest: f64,
    /// Distance before the corner at which the blend begins, and after it at which it ends, mm.
    pub distances: [f64; 2],
    /// κ: length of the blend over the length of the legs that it replaces.
    pub shortening: f64,
    /// Acceleration along it, mm/s².
    pub acceleration: f64,
    /// Share of the acceleration of both legs that the turn uses along their whole length.
    pub taken: f64,
    /// The parabola, if it is one: both legs run at once, each with half of its acceleration.
    pub parabola: Option<Parabola>,
}

/// The tolerance of a parabola, and what decides when its second leg starts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parabola {
    /// Tolerance, mm.
    pub tolerance: f64,
    /// Time for which the first leg holds its feedrate, s.
    pub holding: f64,
    /// Time in which the first leg brakes from its feedrate to the velocity below which the second one starts, s.
    pub braking: f64,
    /// Time in which the first leg brakes from that velocity to rest, s.
    pub stopping: f64,
}

impl Blend {
    /// Returns the corner without a blend, passed at `feedrate`, mm/s.
    pub fn none(feedrate: f64) -> Blend {
        Blend {
            feedrate,
            ends: [feedrate; 2],
            fastest: feedrate,
            distances: [0.0; 2],
            shortening: 1.0,
            acceleration: f64::INFINITY,
            taken: 0.0,
            parabola: None,
        }
    }

    /// Returns `true` if the blend is a parabola.
    pub fn is_parabola(&self) -> bool {
        self.parabola.is_some()
    }

    /// Returns the blend with the command at the corner limited to `feedrate`, mm/s.
    pub fn no_faster_than(self, feedrate: f64) -> Blend {
        let most = |own: f64| own.min(feedrate);
        Blend { feedrate: most(self.feedrate), ends: self.ends.map(most), ..self }
    }

    /// Returns the part of the blend that replaces `length` (mm) of a leg.
    fn piece(&self, length: f64, joins_next: bool) -> BlendPiece {
        let feedrate = self.ends[0].max(self.ends[1]);
        let Blend { shortening, acceleration, .. } = *self;
        let is_parabola = self.is_parabola();
        BlendPiece { length, shortening, feedrate, acceleration, joins_next, is_parabola, may_be_ramp: false }
    }
}

/// A segment between its corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Length, mm.
    pub length: f64,
    /// Requested feedrate, mm/s.
    pub feedrate: f64,
    /// Acceleration along it, mm/s².
    pub acceleration: f64,
    /// `true` for a line.
    pub is_line: bool,
    /// `true` for a rapid move.
    pub is_rapid: bool,
}

/// A piece that is run as one trapezoid.
#[derive(Clone, Copy)]
struct BlendPiece {
    /// Length along the programmed path, mm.
    length: f64,
    /// Length of the path over `length`.
    shortening: f64,
    /// Largest path speed, mm/s.
    feedrate: f64,
    /// Acceleration along the path, mm/s².
    acceleration: f64,
    /// `true` if the piece is run as one with the next.
    joins_next: bool,
    /// `true` for a part of a parabola.
    is_parabola: bool,
    /// `true` if a short piece is one ramp.
    may_be_ramp: bool,
}

impl BlendPiece {
    /// Returns the parts between two speeds (mm/s): a trapezoid, or one ramp if that is short.
    fn parts(&self, first: f64, last: f64) -> impl Iterator<Item = BlockPart> {
        let path = self.shortening * self.length;
        let duration = 2.0 * path / (first + last);
        let is_ramp = self.may_be_ramp && 0.0 < last && duration < MAX_RAMP_DURATION_S;
        let end = |feedrate: f64| BlockEnd { feedrate, hold: 0.0 };
        let trapezoid =
            (!is_ramp).then(|| parts(path, self.feedrate, self.acceleration, end(first), end(last)));
        is_ramp.then_some((duration, first, last)).into_iter().chain(trapezoid.into_iter().flatten())
    }

    /// Returns the largest change of v² along the piece, mm²/s².
    fn braked(&self) -> f64 {
        2.0 * self.acceleration * self.shortening * self.length
    }
}

/// Sums over the pieces from the start of a chain.
#[derive(Clone, Copy, Default)]
struct ChainSum {
    /// Largest change of v², mm²/s².
    braked: f64,
    /// Number of parts of parabolas.
    parabolas: usize,
}

/// Duration (s) below which a line becomes part of the circle behind it: the time in which the largest speed of that circle
/// covers the line.
const MIN_LINE_DURATION_S: f64 = 4e-3;

/// Duration (s) below which a feed move between two blends is one ramp.
const MAX_RAMP_DURATION_S: f64 = 10e-3;

/// Returns the lengths of a leg of `length` that the blends at its beginning and at its end replace, all mm.
pub fn blended_lengths(length: f64, first: &Blend, last: &Blend) -> [f64; 2] {
    let begin = first.distances[1].min(length);
    [begin, last.distances[0].min(length - begin)]
}

/// Returns the blend that begins a leg, the line behind it and the blend that ends the leg.
fn pieces(leg: &Leg, first: &Blend, last: &Blend) -> [BlendPiece; 3] {
    let [begin, end] = blended_lengths(leg.length, first, last);
    let acceleration = leg.acceleration * (1.0 - first.taken.max(last.taken));
    let length = leg.length - begin - end;
    let mut line = BlendPiece {
        length,
        shortening: 1.0,
        feedrate: leg.feedrate,
        acceleration,
        joins_next: false,
        is_parabola: false,
        may_be_ramp: !leg.is_rapid && !last.is_parabola(),
    };
    let is_circle = !last.is_parabola() && 0.0 < end;
    let may_join = is_circle && leg.is_line && !first.is_parabola();
    if may_join && line.length < MIN_LINE_DURATION_S * last.fastest {
        line.feedrate = line.feedrate.min(last.feedrate);
        line.acceleration = line.acceleration.min(last.acceleration);
        (line.joins_next, line.may_be_ramp) = (true, false);
    }
    [first.piece(begin, false), line, last.piece(end, true)]
}

/// Lowers the speeds (mm/s) at which lines and circles begin to those from which the motion can stop within
/// the next `look_ahead` lines and circles. The motion can always stop at the first parabola ahead.
fn see_ahead(chain: &[BlendPiece], look_ahead: f64, speeds: &mut [f64]) {
    if look_ahead == f64::INFINITY {
        return;
    }
    // The beginning of each piece in the chain, and the sums up to its end.
    let (mut begins, mut sums) = (Vec::new(), vec![ChainSum::default()]);
    let mut goes_on = false;
    for (i, piece) in chain.iter().enumerate().filter(|(_, piece)| 0.0 < piece.length) {
        let before = sums.last().copied().unwrap_or_default();
        if goes_on {
            sums.pop();
        } else {
            begins.push(i);
        }
        sums.push(ChainSum {
            braked: before.braked + piece.braked(),
            parabolas: before.parabolas + usize::from(piece.is_parabola),
        });
        goes_on = piece.joins_next;
    }
    let seen = look_ahead as usize;
    for (k, &i) in begins.iter().enumerate().skip(1) {
        let is_end_seen = begins.len() <= k + seen;
        if is_end_seen || sums[k].parabolas < sums[k + seen].parabolas || sums[k + seen].braked.is_infinite()
        {
            continue;
        }
        speeds[i] = speeds[i].min((sums[k + seen].braked - sums[k].braked).max(0.0).sqrt());
    }
}

/// Returns the pulses of a rest-to-rest motion and the path speed at its corners (mm/s). `corners` has one
/// more entry than `legs`; its first and last are full stops. The planner sees `look_ahead` lines and
/// circles; `segment` is the index of the first leg in the toolpath.
pub fn pulses(legs: &[Leg], corners: &[Blend], look_ahead: f64, segment: usize) -> (Vec<Pulse>, Vec<f64>) {
    let pieces: Vec<[BlendPiece; 3]> =
        legs.iter().zip(corners.windows(2)).map(|(leg, ends)| pieces(leg, &ends[0], &ends[1])).collect();
    let chain = pieces.as_flattened();
    let mut speeds: Vec<f64> = vec![f64::INFINITY; chain.len() + 1];
    for (i, corner) in corners.iter().enumerate() {
        speeds[3 * i] = corner.feedrate;
        let is_blended = corner.distances != [0.0; 2];
        if is_blended && 0 < i {
            speeds[3 * i - 1] = corner.ends[0];
        }
        if is_blended && let Some(end) = speeds.get_mut(3 * i + 1) {
            *end = corner.ends[1];
        }
    }
    for (i, piece) in chain.iter().enumerate().filter(|(_, piece)| 0.0 < piece.length) {
        speeds[i] = speeds[i].min(piece.feedrate);
        speeds[i + 1] = speeds[i + 1].min(piece.feedrate);
    }
    see_ahead(chain, look_ahead, &mut speeds);
    let reach = |from: f64, piece: &BlendPiece| (from * from + piece.braked()).sqrt();
    let moving = |piece: &BlendPiece| 0.0 < piece.length;
    for (i, piece) in chain.iter().enumerate() {
        let most = if moving(piece) { reach(speeds[i], piece) } else { speeds[i] };
        speeds[i + 1] = speeds[i + 1].min(most);
    }
    for (i, piece) in chain.iter().enumerate().rev() {
        let most = if moving(piece) { reach(speeds[i + 1], piece) } else { speeds[i + 1] };
        speeds[i] = speeds[i].min(most);
    }
    let mut pulses = Vec::with_capacity(2 * legs.len());
    for (i, piece) in chain.iter().enumerate().filter(|(_, piece)| moving(piece)) {
        let mut offset = match i % 3 {
            0 => 0.0,
            1 => pieces[i / 3][0].length,
            _ => legs[i / 3].length - piece.length,
        };
        for (duration, first, last) in piece.parts(speeds[i], speeds[i + 1]) {
            if 0.0 < duration {
                let feedrate = [first / piece.shortening, last / piece.shortening];
                pulses.push(Pulse { segment: (segment + i / 3) as u32, duration, offset, feedrate });
                offset += duration * 0.5 * (feedrate[0] + feedrate[1]);
            }
        }
    }
    let at_corners = speeds.into_iter().step_by(3).skip(1).collect();
    (pulses, at_corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines of 1 mm that go straight on, at 100 mm/s and 500 mm/s².
    fn line(count: usize) -> (Vec<Leg>, Vec<Blend>) {
        let leg = Leg { length: 1.0, feedrate: 100.0, acceleration: 500.0, is_line: true, is_rapid: false };
        let mut corners = vec![Blend::none(f64::INFINITY); count + 1];
        (corners[0], corners[count]) = (Blend::none(0.0), Blend::none(0.0));
        (vec![leg; count], corners)
    }

    #[test]
    fn the_motion_stops_within_what_is_in_sight() {
        let (legs, corners) = line(40);
        let (_, all) = pulses(&legs, &corners, f64::INFINITY, 0);
        let (_, seen) = pulses(&legs, &corners, 4.0, 0);
        let fastest = |speeds: &[f64]| speeds.iter().copied().fold(0.0, f64::max);
        assert!((fastest(&all) - 100.0).abs() < 1e-9);
        assert!((fastest(&seen) - (2.0f64 * 500.0 * 4.0).sqrt()).abs() < 1e-9, "{seen:?}");
        // Whoever sees the end stops there all the same.
        let (legs, corners) = line(5);
        let both = [f64::INFINITY, 5.0].map(|seen| pulses(&legs, &corners, seen, 0).1);
        assert_eq!(both[0], both[1]);
    }

    #[test]
    fn the_motion_can_stop_at_a_parabola() {
        let (legs, mut corners) = line(40);
        for corner in &mut corners[1..40] {
            // At one speed the parabola itself hardly accelerates.
            *corner = Blend {
                distances: [0.5; 2],
                acceleration: 0.5,
                parabola: Some(Parabola::default()),
                ..Blend::none(20.0)
            };
        }
        let both = [f64::INFINITY, 4.0].map(|seen| pulses(&legs, &corners, seen, 0).1);
        assert_eq!(both[0], both[1]);
        // Far from the only parabola the look-ahead still limits the motion.
        for corner in &mut corners[2..40] {
            *corner = Blend::none(f64::INFINITY);
        }
        let (_, seen) = pulses(&legs, &corners, 4.0, 0);
        let fastest = seen.iter().copied().fold(0.0, f64::max);
        assert!((fastest - (2.0f64 * 500.0 * 4.0).sqrt()).abs() < 1e-9, "{fastest}");
    }

    #[test]
    fn a_short_line_is_part_of_the_circle_behind_it_unless_it_begins_with_a_parabola() {
        let leg = Leg { length: 0.3, feedrate: 100.0, acceleration: 500.0, is_line: true, is_rapid: false };
        let circle = Blend { distances: [0.1; 2], acceleration: 300.0, ..Blend::none(50.0) };
        let parabola = Blend { parabola: Some(Parabola::default()), ..circle };
        let of_line = |first: Blend| pieces(&leg, &first, &circle)[1];
        assert!(of_line(circle).joins_next && !of_line(parabola).joins_next);
        assert_eq!([circle, parabola].map(|first| of_line(first).acceleration), [300.0, 500.0]);
    }

    #[test]
    fn both_halves_of_a_circle_are_one() {
        let (legs, mut corners) = line(40);
        for corner in &mut corners[1..40] {
            *corner = Blend { distances: [0.5; 2], acceleration: 500.0, ..Blend::none(90.0) };
        }
        let (_, seen) = pulses(&legs, &corners, 4.0, 0);
        let fastest = seen.iter().copied().fold(0.0, f64::max);
        // In the middle of a circle its second half counts in addition to the look-ahead of four.
        assert!((fastest - (2.0f64 * 500.0 * 4.5).sqrt()).abs() < 1e-9, "{fastest}");
    }
}
