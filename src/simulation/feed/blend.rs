//! The pulses of a stretch whose corners are circles.
//!
//! A circle of radius R that turns by φ leaves one leg d = R tan(φ/2) before the corner and joins the
//! other d after it. It is only Rφ long, not 2d, and has a feedrate limit and an acceleration of its
//! own. A segment of length L is so three pieces, each run as a trapezoid of path speed v:
//!
//! ```text
//!   half a circle        line           half a circle
//!  |<-- κ1 d1 -->|<-- L − d1 − d2 -->|<-- κ2 d2 -->|        κ = ½ φ / tan(φ/2) ≤ 1
//! ```
//!
//! Along the whole stretch v² changes by no more than 2 A s over a piece of acceleration A (mm/s²)
//! and length s (mm), forwards and backwards. Distance is measured along the programmed path, where a
//! circle at v is passed at v/κ, but never faster than the segment is asked for.
//!
//! A line between two circles that the second, at its fastest, would pass in less than four servo
//! periods becomes part of that.
//!
//! Limits: a circle belongs to both legs in equal parts, and each is run at no more than the feedrate
//! of its own leg. Source: derived; the division, and the gap of four periods, are those of LinuxCNC
//! (src/emc/tp, tp.c and blendmath.c).

use crate::simulation::feed::Pulse;
use crate::simulation::feed::block::{End, parts};

/// A circle in place of a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blend {
    /// Fastest command along it, mm/s; 0 at a full stop.
    pub feedrate: f64,
    /// The same if legs were run as fast as axes allow, mm/s.
    pub fastest: f64,
    /// How far before the corner it begins, and after it ends, mm.
    pub distance: f64,
    /// κ, its length over that of the legs it replaces.
    pub shortening: f64,
    /// Acceleration along it, mm/s².
    pub acceleration: f64,
    /// Share of the acceleration of both legs that the turn takes all along them.
    pub taken: f64,
}

impl Blend {
    /// No circle: the corner itself, passed at `feedrate`, mm/s.
    pub fn none(feedrate: f64) -> Blend {
        Blend {
            feedrate,
            fastest: feedrate,
            distance: 0.0,
            shortening: 1.0,
            acceleration: f64::INFINITY,
            taken: 0.0,
        }
    }

    /// The part of the circle that stands for `length` (mm) of a leg run at `feedrate`, mm/s.
    fn piece(&self, length: f64, feedrate: f64) -> Piece {
        let slower = feedrate.min(self.feedrate);
        let shortening = self.shortening;
        Piece { length, shortening, feedrate: slower, acceleration: self.acceleration }
    }
}

/// A segment between its corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Length, mm.
    pub length: f64,
    /// Feedrate asked for, mm/s.
    pub feedrate: f64,
    /// Acceleration along it, mm/s².
    pub acceleration: f64,
}

/// What is run as one trapezoid.
#[derive(Clone, Copy)]
struct Piece {
    /// Length along the programmed path, mm.
    length: f64,
    /// Length of the path over that.
    shortening: f64,
    /// Fastest path speed, mm/s.
    feedrate: f64,
    /// mm/s².
    acceleration: f64,
}

/// A line left between two circles becomes part of the second where this, at its fastest, would take
/// less time for it, s.
const SHORTEST_LINE: f64 = 4e-3;

/// The circle that ends a leg, the line before it and the circle that begins the leg.
fn pieces(leg: &Leg, first: &Blend, last: &Blend) -> [Piece; 3] {
    let half = 0.5 * leg.length;
    let (begin, end) = (first.distance.min(half), last.distance.min(half));
    let acceleration = leg.acceleration * (1.0 - first.taken.max(last.taken));
    let mut line =
        Piece { length: leg.length - begin - end, shortening: 1.0, feedrate: leg.feedrate, acceleration };
    if 0.0 < end && line.length < SHORTEST_LINE * last.fastest {
        line.feedrate = line.feedrate.min(last.feedrate);
        line.acceleration = line.acceleration.min(last.acceleration);
    }
    [first.piece(begin, leg.feedrate), line, last.piece(end, leg.feedrate)]
}

/// The pulses of a stretch of legs, and the path speed at its corners (mm/s). There is one more corner
/// than there are legs; those at the ends are full stops. Segments count from `segment`.
pub fn pulses(legs: &[Leg], corners: &[Blend], segment: usize) -> (Vec<Pulse>, Vec<f64>) {
    let pieces: Vec<[Piece; 3]> =
        legs.iter().zip(corners.windows(2)).map(|(leg, ends)| pieces(leg, &ends[0], &ends[1])).collect();
    let chain = pieces.as_flattened();
    let mut speeds: Vec<f64> = vec![f64::INFINITY; chain.len() + 1];
    for (i, corner) in corners.iter().enumerate() {
        speeds[3 * i] = corner.feedrate;
    }
    for (i, piece) in chain.iter().enumerate().filter(|(_, piece)| 0.0 < piece.length) {
        speeds[i] = speeds[i].min(piece.feedrate);
        speeds[i + 1] = speeds[i + 1].min(piece.feedrate);
    }
    let reach = |from: f64, piece: &Piece| {
        (from * from + 2.0 * piece.acceleration * piece.shortening * piece.length).sqrt()
    };
    let moving = |piece: &Piece| 0.0 < piece.length;
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
        let end = |feedrate: f64| End { feedrate, hold: 0.0 };
        let (first, last) = (end(speeds[i]), end(speeds[i + 1]));
        let path = piece.shortening * piece.length;
        let mut offset = match i % 3 {
            0 => 0.0,
            1 => pieces[i / 3][0].length,
            _ => legs[i / 3].length - piece.length,
        };
        for (duration, first, last) in parts(path, piece.feedrate, piece.acceleration, first, last) {
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
