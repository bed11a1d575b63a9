//! The pulses of one block: from the command at its first corner to that at its last.
//!
//! A block of length L commanded at F holds the corner commands c1 and c2 for the times h1 and h2 that the
//! corners require, and F between them; with an acceleration limit A, ramps join them:
//!
//! ```text
//!  F            _____________
//!              /             \
//!  c1  -------/               \
//!                              \-----  c2
//!      |<-h1->|               |<-h2->|
//! ```
//!
//! The area below the command is exactly L (Eq. 17). If the block is too short for this shape:
//!
//! 1. the ramps meet below F (only with a finite A);
//! 2. if it is too short for both holds as well, **the slower corner wins**: its hold keeps its length, up to
//!    the whole block, and the faster corner's hold takes the rest. This is continuous with Eq. 17, and a
//!    corner that becomes faster never makes the block slower; shrinking both holds in proportion would,
//!    because a faster corner's shorter hold leaves more of the block to the slower one.
//!
//! Limits: |c1² − c2²| ≤ 2 A L, which the look-ahead ensures.

/// One end of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockEnd {
    /// Command at the corner, mm/s; 0 at a full stop.
    pub feedrate: f64,
    /// Duration of that command if the block has the room, s; 0 at a full stop.
    pub hold: f64,
}

/// A part of a block: its duration (s) and the command at its beginning and end (mm/s).
pub type BlockPart = (f64, f64, f64);

/// Returns the parts of a block of `length` (mm) at `feedrate` (mm/s) and `acceleration` (mm/s², may be
/// infinite) in order: hold, ramp, cruise, ramp, hold. A part that is not needed lasts 0 s. If the block has
/// room for both holds, the parts follow Eq. 17 of Ward et al. 2021.
#[inline]
pub fn parts(
    length: f64,
    feedrate: f64,
    acceleration: f64,
    first: BlockEnd,
    last: BlockEnd,
) -> [BlockPart; 5] {
    // Without a limit a ramp takes neither room nor time, and divisions are slow.
    let is_limited = acceleration != f64::INFINITY;
    let over = |change: f64, acceleration: f64| if is_limited { change / acceleration } else { 0.0 };
    let ramp_length = |a: f64, b: f64| over(((a - b) * (a + b)).abs(), 2.0 * acceleration);
    let ramp = |a: f64, b: f64| (over((a - b).abs(), acceleration), a, b);
    let holds = first.feedrate * first.hold + last.feedrate * last.hold;
    let cruise =
        length - holds - ramp_length(first.feedrate, feedrate) - ramp_length(feedrate, last.feedrate);
    let (first_hold, peak, cruise_time, last_hold) = if 0.0 <= cruise {
        (first.hold, feedrate, cruise / feedrate, last.hold)
    } else if ramp_length(first.feedrate, last.feedrate) <= length - holds && acceleration.is_finite() {
        let square = acceleration * (length - holds)
            + 0.5 * (first.feedrate * first.feedrate + last.feedrate * last.feedrate);
        (first.hold, square.sqrt(), 0.0, last.hold)
    } else {
        let room = (length - ramp_length(first.feedrate, last.feedrate)).max(0.0);
        let (slower, faster) = if first.feedrate <= last.feedrate { (first, last) } else { (last, first) };
        let kept = slower.hold.min(room / slower.feedrate);
        let left = (room - kept * slower.feedrate).max(0.0) / faster.feedrate;
        if first.feedrate <= last.feedrate {
            (kept, faster.feedrate, 0.0, left)
        } else {
            (left, faster.feedrate, 0.0, kept)
        }
    };
    [
        (first_hold, first.feedrate, first.feedrate),
        ramp(first.feedrate, peak),
        (cruise_time, peak, peak),
        ramp(peak, last.feedrate),
        (last_hold, last.feedrate, last.feedrate),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(parts: &[BlockPart]) -> f64 {
        parts.iter().map(|(time, a, b)| time * 0.5 * (a + b)).sum()
    }

    fn time(parts: &[BlockPart]) -> f64 {
        parts.iter().map(|(time, ..)| time).sum()
    }

    /// Blocks from 1 µm to 100 mm between all kinds of corners, for which `check` gets the length,
    /// feedrate, acceleration, half delay and corner commands.
    fn many(mut check: impl FnMut(f64, f64, f64, f64, f64, f64)) {
        for length in [1e-3, 0.01, 0.1, 0.5, 1.0, 2.0, 5.0, 100.0] {
            for feedrate in [5.0, 50.0, 300.0] {
                for acceleration in [f64::INFINITY, 5000.0, 300.0] {
                    for i in 1..=20 {
                        for j in 1..=20 {
                            let (c1, c2) = (feedrate * i as f64 / 20.0, feedrate * j as f64 / 20.0);
                            if (c1 * c1 - c2 * c2).abs() <= 2.0 * acceleration * length {
                                check(length, feedrate, acceleration, 0.038, c1, c2);
                            }
                        }
                    }
                }
            }
        }
    }

    fn block(length: f64, f: f64, a: f64, h: f64, c1: f64, c2: f64) -> [BlockPart; 5] {
        let end = |c: f64| BlockEnd { feedrate: c, hold: h * (1.0 - c / f) };
        parts(length, f, a, end(c1), end(c2))
    }

    #[test]
    fn area_is_the_length() {
        many(|length, f, a, h, c1, c2| {
            let parts = block(length, f, a, h, c1, c2);
            assert!((area(&parts) / length - 1.0).abs() < 1e-12, "{parts:?}");
            assert!(
                parts
                    .iter()
                    .all(|&(time, v0, v1)| 0.0 <= time && v0 <= f * (1.0 + 1e-12) && v1 <= f * (1.0 + 1e-12))
            );
        });
    }

    #[test]
    fn a_faster_corner_never_makes_the_block_slower() {
        many(|length, f, a, h, c1, c2| {
            let faster = (c1 * 1.01).min(f);
            if (faster * faster - c2 * c2).abs() <= 2.0 * a * length {
                let (slow, fast) =
                    (time(&block(length, f, a, h, c1, c2)), time(&block(length, f, a, h, faster, c2)));
                assert!(
                    fast <= slow * (1.0 + 1e-12),
                    "L {length}, F {f}, A {a}, c {c1} → {faster}, {c2}: {slow} → {fast}"
                );
            }
        });
    }

    #[test]
    fn a_block_run_backwards_is_its_mirror_image() {
        many(|length, f, a, h, c1, c2| {
            let (one, other) = (block(length, f, a, h, c1, c2), block(length, f, a, h, c2, c1));
            assert!((time(&one) - time(&other)).abs() <= 1e-14 * time(&one));
        });
    }

    #[test]
    fn a_block_without_corners_at_full_stops_is_one_pulse() {
        let stop = BlockEnd { feedrate: 0.0, hold: 0.0 };
        let parts = parts(6.0, 50.0, f64::INFINITY, stop, stop);
        assert_eq!(parts[2], (0.12, 50.0, 50.0));
        assert_eq!(time(&parts), 0.12);
    }
}
