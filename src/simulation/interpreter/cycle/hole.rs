//! One hole along its axis: from the numbers of a drilling, tapping or boring cycle to steps.
//!
//! Heights lie on the drilling axis, in mm, and grow out of the part. The tool stands above or
//! below the hole's centre at any height; the list brings it to the reference height R, works down
//! to the bottom Z and ends at the return height.
//!
//! ```text
//!            full retract                          chip breaking
//!
//!   return ·                     ↑        return ·                     ↑
//!            |                   :                 |                   :
//!        R · ↓  ↑ ↓     ↑ ↓      :             R · ↓                   :
//!            |  : :     : :      :                 |                   :
//!   z1+c     |  : ↓     : :      :        z1+c     |  ↑|               :
//!       z1   ↓··: |     : :      :            z1   ↓··:|               :
//!   z2+c          |     : ↓      :        z2+c         |  ↑|           :
//!       z2        ↓·····: |      :            z2       ↓··:|           :
//!        Z                ↓······:             Z           ↓···········:
//!
//!            |  feed, over p1, then c + p2, c + p3 …        :  rapid
//! ```
//!
//! Depths of the pecks: p(1) is given, p(n+1) = max(p(n) · ratio − decrease, least), and the
//! last peck ends at the bottom. A peck that would leave less than a control resolves goes on to
//! the bottom, whatever the rounding of z(n) = R − p(1) − … − p(n). Length of feed with N pecks:
//! (R − Z) + (N − 1) c, as long as no z + c is above the ceiling.
//!
//! A tap in N pecks of depth q is turned back by d after each but the last, out to R where d is infinite, with the spindle
//! turned round for the way back and again for the next peck: 2 N reversals, and (R − Z) + 2 Σ d_n + (R − Z) of feed.
//!
//! Limits: a hole has at most [`MAX_PECKS`] pecks, and deeper ones than written where that is
//! not enough.

use thiserror::Error;

/// The most pecks of one hole.
pub const MAX_PECKS: u32 = 1000;

/// What is left above the bottom is no peck of its own below this, mm.
const RESOLUTION_MM: f64 = 1e-6;

/// The work at one hole.
#[derive(Clone, Debug, PartialEq)]
pub struct Hole {
    /// What is done.
    pub kind: Kind,
    /// Where feed begins, mm.
    pub reference: f64,
    /// Where it ends, mm; not above the reference.
    pub bottom: f64,
    /// Where a feed out of the hole ends, mm.
    pub feed_out_to: f64,
    /// Where the tool is left, mm.
    pub return_to: f64,
    /// Feedrate into the part, mm/s.
    pub feed_in: f64,
    /// Feedrate out of it, mm/s.
    pub feed_out: f64,
    /// Waiting time at the bottom, s.
    pub dwell: f64,
    /// Waiting time after a feed out, s.
    pub dwell_outside: f64,
}

impl Hole {
    /// A drilled hole between these heights (mm), left in rapid, without waits; `feedrate` in mm/s.
    pub fn drilled(reference: f64, bottom: f64, return_to: f64, feedrate: f64) -> Hole {
        Hole {
            kind: Kind::Drill,
            reference,
            bottom,
            feed_out_to: reference,
            return_to,
            feed_in: feedrate,
            feed_out: feedrate,
            dwell: 0.0,
            dwell_outside: 0.0,
        }
    }
}

/// What is done at a hole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Feed in, rapid out.
    Drill,
    /// Feed in by pecks, and between them a rapid move up by `retract`, mm.
    ChipBreak {
        /// Their depths.
        pecks: Pecks,
        /// How far the tool is lifted, mm.
        retract: f64,
        /// The highest it is lifted to, mm.
        ceiling: f64,
    },
    /// Feed in by pecks, and between them a rapid move out to the reference height and back.
    Peck {
        /// Their depths.
        pecks: Pecks,
        /// How far above the last depth feed begins again, mm.
        clearance: f64,
        /// The highest that feed begins again at, mm.
        ceiling: f64,
    },
    /// Feed in, the spindle turned round, feed out, the spindle turned back.
    Tap {
        /// How it turns on its way in.
        turn: Turn,
        /// Turned round in one, with the feed coupled to it; otherwise it is stopped first.
        is_rigid: bool,
        /// In pecks, each with a way out and the spindle turned round for both; `None`: in one.
        pecks: Option<TapPecks>,
    },
    /// Feed in, feed out.
    Bore,
    /// Feed in, the spindle stopped, rapid out, and the spindle started again.
    BoreAndStop {
        /// How it turns.
        turn: Turn,
        /// The program stops at the bottom, for the tool to be taken out by hand.
        by_hand: bool,
    },
    /// As `BoreAndStop`, but the spindle is oriented and the tool taken off the wall.
    FineBore {
        /// How the spindle turns.
        turn: Turn,
        /// Off the wall, in the plane of the holes, mm.
        shift: [f64; 2],
    },
    /// Through the hole with an oriented spindle, and a bore from below.
    BackBore {
        /// How the spindle turns.
        turn: Turn,
        /// Off the wall, in the plane of the holes, mm.
        shift: [f64; 2],
        /// Where the bore ends, above the bottom, mm.
        top: f64,
        /// Back to the bottom in feed.
        feeds_back: bool,
    },
}

/// The depths of pecks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pecks {
    /// Depth of the first, mm; positive.
    pub first: f64,
    /// What of a depth is left in the next; neutral 1.
    pub ratio: f64,
    /// What a depth is less than the one before, mm; neutral 0.
    pub decrease: f64,
    /// The least depth but for the last peck, mm; neutral 0.
    pub least: f64,
}

impl Pecks {
    /// All of the same depth, mm.
    pub fn equal(depth: f64) -> Pecks {
        Pecks { first: depth, ratio: 1.0, decrease: 0.0, least: 0.0 }
    }
}

/// The pecks of a tap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TapPecks {
    /// Their depth, mm.
    pub depth: f64,
    /// How far the tap is turned back between them, mm; no higher than the reference height.
    pub back: f64,
}

/// How a spindle turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Turn {
    /// Clockwise, M3.
    #[default]
    Right,
    /// Counter-clockwise, M4.
    Left,
}

impl Turn {
    /// The number of its M word.
    pub fn code(self) -> u32 {
        match self {
            Turn::Right => 3,
            Turn::Left => 4,
        }
    }

    /// The other way.
    pub fn reversed(self) -> Turn {
        match self {
            Turn::Right => Turn::Left,
            Turn::Left => Turn::Right,
        }
    }
}

/// One step of the work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Along the axis to a height, mm, in rapid.
    Rapid(f64),
    /// Along the axis to a height.
    Feed {
        /// Height, mm.
        to: f64,
        /// Feedrate, mm/s.
        feedrate: f64,
    },
    /// In the plane, to this distance from the centre of the hole, mm, in rapid.
    Shift([f64; 2]),
    /// Waiting time, s.
    Dwell(f64),
    /// The spindle stops.
    Stop,
    /// The spindle stops in a known position.
    Orient,
    /// The spindle starts, or turns round.
    Start(Turn),
    /// The program waits for the operator.
    Wait,
}

/// The steps of one hole.
#[derive(Clone, Debug, PartialEq)]
pub struct Work {
    /// In order.
    pub steps: Vec<Step>,
    /// How many pecks are written for each that is made, at most: 1 where all are made, infinite where nothing bounds them.
    pub pecks_per_made: f64,
}

impl From<Vec<Step>> for Work {
    /// Steps without pecks.
    fn from(steps: Vec<Step>) -> Work {
        Work { steps, pecks_per_made: 1.0 }
    }
}

/// Why there is nothing to do at a hole. Heights in mm.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum NoHole {
    /// No reference height.
    #[error("no R")]
    NoReference,
    /// No bottom.
    #[error("no depth ({0})")]
    NoBottom(char),
    /// Nothing to drill downwards.
    #[error("the bottom ({bottom:.4} mm) lies above R ({reference:.4} mm)")]
    BottomAboveReference {
        /// Z.
        bottom: f64,
        /// R.
        reference: f64,
    },
    /// The counterbore ends below the bottom.
    #[error("the top of the bore ({top:.4} mm) lies below its bottom ({bottom:.4} mm)")]
    TopBelowBottom {
        /// Its end.
        top: f64,
        /// Its begin.
        bottom: f64,
    },
    /// No end of a counterbore.
    #[error("no top of the bore ({0})")]
    NoTop(char),
    /// No depth of pecks.
    #[error("no Q")]
    NoPeck,
    /// No depth to peck by.
    #[error("pecks of {0} mm")]
    BadPeck(f64),
    /// Numbers without measure.
    #[error("a height is out of reach")]
    OutOfReach,
    /// The program's holes have more steps than this.
    #[error("all holes together need more than {0} moves and stops")]
    TooMuchWork(usize),
    /// A pattern of no hole, or of more than can be made.
    #[error("{0} is no number of holes from 1 to 10000")]
    NoCount(f64),
    /// Another cycle has the same name.
    #[error("threading (with I, J and K) is not modelled")]
    Threading,
}

/// The steps of `hole`, from any height above its centre.
///
/// # Errors
///
/// If the hole has no depth, no pecks or no reach.
pub fn work(hole: &Hole) -> Result<Work, NoHole> {
    let Hole { kind, reference, bottom, feed_out_to, return_to, dwell, dwell_outside, .. } = *hole;
    let depth = reference - bottom;
    if !depth.is_finite() || !return_to.is_finite() || !feed_out_to.is_finite() {
        return Err(NoHole::OutOfReach);
    }
    if depth < 0.0 {
        return Err(NoHole::BottomAboveReference { bottom, reference });
    }
    let feed_in = |to| Step::Feed { to, feedrate: hole.feed_in };
    let feed_out = Step::Feed { to: feed_out_to, feedrate: hole.feed_out };
    let mut pecks_per_made = 1.0;
    let mut steps = vec![Step::Rapid(reference)];
    match kind {
        Kind::Drill => steps.extend([feed_in(bottom), Step::Dwell(dwell)]),
        Kind::ChipBreak { pecks, retract, ceiling } => {
            pecks_per_made = peck(depth, pecks, |left| {
                steps.push(feed_in(bottom + left));
                if 0.0 < left {
                    steps.push(Step::Rapid((bottom + left + retract).min(ceiling)));
                }
            })?;
            steps.push(Step::Dwell(dwell));
        }
        Kind::Peck { pecks, clearance, ceiling } => {
            pecks_per_made = peck(depth, pecks, |left| {
                steps.push(feed_in(bottom + left));
                if 0.0 < left {
                    let again = (bottom + left + clearance).min(ceiling);
                    steps.extend([Step::Rapid(reference), Step::Rapid(again)]);
                }
            })?;
            steps.push(Step::Dwell(dwell));
        }
        Kind::Tap { turn, is_rigid, pecks } => {
            let stop = (!is_rigid).then_some(Step::Stop);
            let start = |turn| stop.into_iter().chain([Step::Start(turn)]);
            let TapPecks { depth: peck_depth, back } =
                pecks.unwrap_or(TapPecks { depth: f64::INFINITY, back: 0.0 });
            pecks_per_made = peck(depth, Pecks::equal(peck_depth), |left| {
                steps.push(feed_in(bottom + left));
                if 0.0 < left {
                    steps.extend(start(turn.reversed()));
                    let to = (bottom + left + back).min(reference);
                    steps.push(Step::Feed { to, feedrate: hole.feed_out });
                    steps.extend(start(turn));
                }
            })?;
            steps.push(Step::Dwell(dwell));
            steps.extend(start(turn.reversed()).chain([feed_out]));
            steps.push(Step::Dwell(dwell_outside));
            steps.extend(start(turn));
        }
        Kind::Bore => {
            steps.extend([feed_in(bottom), Step::Dwell(dwell), feed_out, Step::Dwell(dwell_outside)]);
        }
        Kind::BoreAndStop { turn, by_hand } => {
            steps.extend([feed_in(bottom), Step::Dwell(dwell), Step::Stop]);
            steps.extend(by_hand.then_some(Step::Wait));
            steps.extend([Step::Rapid(return_to), Step::Start(turn)]);
        }
        Kind::FineBore { turn, shift } => {
            steps.extend([feed_in(bottom), Step::Dwell(dwell), Step::Orient, Step::Shift(shift)]);
            steps.extend([Step::Rapid(return_to), Step::Shift([0.0; 2]), Step::Start(turn)]);
        }
        Kind::BackBore { top, .. } if top < bottom => return Err(NoHole::TopBelowBottom { top, bottom }),
        Kind::BackBore { turn, shift, top, feeds_back } => {
            steps.extend([Step::Orient, Step::Shift(shift), Step::Rapid(bottom), Step::Shift([0.0; 2])]);
            steps.extend([Step::Start(turn), feed_in(top), Step::Dwell(dwell)]);
            steps.extend(feeds_back.then_some(feed_in(bottom)));
            steps.extend([Step::Orient, Step::Shift(shift), Step::Rapid(return_to)]);
            steps.extend([Step::Shift([0.0; 2]), Step::Start(turn)]);
        }
    }
    if !matches!(kind, Kind::BoreAndStop { .. } | Kind::FineBore { .. } | Kind::BackBore { .. }) {
        steps.push(Step::Rapid(return_to));
    }
    steps.retain(|step| !matches!(step, Step::Dwell(seconds) if *seconds <= 0.0));
    Ok(Work { steps, pecks_per_made })
}

/// Calls `each` with what is left below every peck, mm, the last of which is 0; returns how many pecks are written for each
/// that is made, as [`Work::pecks_per_made`].
pub(crate) fn peck(depth: f64, pecks: Pecks, mut each: impl FnMut(f64)) -> Result<f64, NoHole> {
    if pecks.first.is_nan() || pecks.first <= 0.0 {
        return Err(NoHole::BadPeck(pecks.first));
    }
    // Whatever is left is measured from the bottom, so that it always shrinks, however far from
    // zero the hole lies.
    let shallowest = depth / f64::from(MAX_PECKS);
    let (mut left, mut next, mut made, mut has_deeper) = (depth, pecks.first, 0_u32, false);
    loop {
        has_deeper |= next < shallowest;
        made += 1;
        let peck = next.max(shallowest);
        if left - peck < RESOLUTION_MM {
            each(0.0);
            let is_equal = pecks.ratio == 1.0 && pecks.decrease == 0.0;
            let least = if is_equal { pecks.first } else { pecks.least.min(pecks.first) };
            return Ok(if has_deeper { written_per_made(depth, least, made) } else { 1.0 });
        }
        left -= peck;
        each(left);
        next = (peck * pecks.ratio - pecks.decrease).max(pecks.least);
    }
}

/// How many pecks of at least `least`, mm, are written for each of those `made` over a depth, at most.
pub(crate) fn written_per_made(depth: f64, least: f64, made: u32) -> f64 {
    (depth / least.max(0.0) / f64::from(made)).max(1.0)
}

#[cfg(test)]
#[path = "hole_tests.rs"]
mod tests;
