//! One hole along its axis: from the values of a drilling, tapping or boring cycle to steps.
//!
//! Heights are on the drilling axis, in mm, and increase out of the part. The tool is above or below the centre of
//! the hole at any height. The steps bring it to the reference height R, work down to the bottom Z and end at the
//! return height.
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
//! Depths of the pecks: p(1) is given, p(n+1) = max(p(n) · ratio − decrease, least), and the last peck ends at the
//! bottom. A peck that would leave less than the resolution of a control continues to the bottom, whatever the
//! rounding of z(n) = R − p(1) − … − p(n). Length of feed with N pecks: (R − Z) + (N − 1) c, as long as no z + c
//! is above the ceiling.
//!
//! A tap in N pecks of depth q is reversed by d after each but the last, out to R if d is infinite. The spindle
//! reverses for the way back and again for the next peck: 2 N reversals, and (R − Z) + 2 Σ d_n + (R − Z) of feed.
//!
//! Limits: a hole has at most [`MAX_PECKS`] pecks; if it needs more, they are deeper than programmed.

use thiserror::Error;

/// Most pecks of one hole.
pub const MAX_PECKS: u32 = 1000;

/// Least rest above the bottom that makes another peck, mm.
const MIN_PECK_MM: f64 = 1e-6;

/// The work at one hole.
#[derive(Clone, Debug, PartialEq)]
pub struct Hole {
    /// The operation.
    pub kind: HoleKind,
    /// Height at which feed begins, mm.
    pub reference: f64,
    /// Height at which it ends, mm; not above the reference.
    pub bottom: f64,
    /// Height at which a feed out of the hole ends, mm.
    pub feed_out_to: f64,
    /// Height at which the tool ends, mm.
    pub return_to: f64,
    /// Feedrate into the part, mm/s.
    pub feed_in: f64,
    /// Feedrate out of it, mm/s.
    pub feed_out: f64,
    /// Dwell at the bottom, s.
    pub dwell: f64,
    /// Dwell after a feed out, s.
    pub dwell_outside: f64,
}

impl Hole {
    /// Returns a drilled hole between these heights (mm), left in rapid, without dwells; `feedrate` in mm/s.
    pub fn drilled(reference: f64, bottom: f64, return_to: f64, feedrate: f64) -> Hole {
        Hole {
            kind: HoleKind::Drill,
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

/// The operation at a hole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HoleKind {
    /// Feed in, rapid out.
    Drill,
    /// Feed in by pecks, and between them a rapid move up by `retract`, mm.
    ChipBreak {
        /// Depths of the pecks.
        pecks: Pecks,
        /// Length of the retract, mm.
        retract: f64,
        /// Highest end of a retract, mm.
        ceiling: f64,
    },
    /// Feed in by pecks, and between them a rapid move out to the reference height and back.
    Peck {
        /// Depths of the pecks.
        pecks: Pecks,
        /// Height above the last depth at which feed starts again, mm.
        clearance: f64,
        /// Highest point at which feed starts again, mm.
        ceiling: f64,
    },
    /// Feed in, the spindle reversed, feed out, the spindle reversed again.
    Tap {
        /// Direction of the spindle on the way in.
        turn: SpindleTurn,
        /// `true` if the spindle reverses at once, with the feed coupled to it; otherwise it stops first.
        is_rigid: bool,
        /// Pecks, each with a way out and the spindle reversed for both; `None` for a single pass.
        pecks: Option<TapPecks>,
    },
    /// Feed in, feed out.
    Bore,
    /// Feed in, the spindle stopped, rapid out, and the spindle started again.
    BoreAndStop {
        /// Direction of the spindle.
        turn: SpindleTurn,
        /// `true` if the program stops at the bottom, for the operator to take the tool out by hand.
        by_hand: bool,
    },
    /// As `BoreAndStop`, but the spindle is oriented and the tool moved off the wall.
    FineBore {
        /// Direction of the spindle.
        turn: SpindleTurn,
        /// Displacement off the wall, in the plane of the holes, mm.
        shift: [f64; 2],
    },
    /// Through the hole with an oriented spindle, and a bore from below.
    BackBore {
        /// Direction of the spindle.
        turn: SpindleTurn,
        /// Displacement off the wall, in the plane of the holes, mm.
        shift: [f64; 2],
        /// Height at which the bore ends, above the bottom, mm.
        top: f64,
        /// `true` if the tool returns to the bottom in feed.
        feeds_back: bool,
    },
}

/// The depths of pecks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pecks {
    /// Depth of the first, mm; positive.
    pub first: f64,
    /// Ratio of a depth to the one before; neutral 1.
    pub ratio: f64,
    /// Difference of a depth to the one before, mm; neutral 0.
    pub decrease: f64,
    /// Least depth except for the last peck, mm; neutral 0.
    pub least: f64,
}

impl Pecks {
    /// Returns pecks of one depth, mm.
    pub fn equal(depth: f64) -> Pecks {
        Pecks { first: depth, ratio: 1.0, decrease: 0.0, least: 0.0 }
    }
}

/// The pecks of a tap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TapPecks {
    /// Depth of each, mm.
    pub depth: f64,
    /// Length by which the tap is reversed between them, mm; it ends no higher than the reference height.
    pub back: f64,
}

/// The direction of a spindle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SpindleTurn {
    /// Clockwise, M3.
    #[default]
    Right,
    /// Counter-clockwise, M4.
    Left,
}

impl SpindleTurn {
    /// Returns the number of its M word.
    pub fn code(self) -> u32 {
        match self {
            SpindleTurn::Right => 3,
            SpindleTurn::Left => 4,
        }
    }

    /// Returns the opposite direction.
    pub fn reversed(self) -> SpindleTurn {
        match self {
            SpindleTurn::Right => SpindleTurn::Left,
            SpindleTurn::Left => SpindleTurn::Right,
        }
    }
}

/// One step of an operation at a hole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HoleStep {
    /// A move along the axis to a height, mm, in rapid.
    Rapid(f64),
    /// A move along the axis to a height in feed.
    Feed {
        /// Height, mm.
        to: f64,
        /// Feedrate, mm/s.
        feedrate: f64,
    },
    /// A move in the plane to this displacement from the centre of the hole, mm, in rapid.
    Shift([f64; 2]),
    /// A dwell, s.
    Dwell(f64),
    /// A stop of the spindle.
    Stop,
    /// A stop of the spindle in a known position.
    Orient,
    /// A start or reversal of the spindle.
    Start(SpindleTurn),
    /// A wait for the operator.
    Wait,
}

/// The steps of one hole, and how they differ from the program.
#[derive(Clone, Debug, PartialEq)]
pub struct HolePlan {
    /// The steps, in order.
    pub steps: Vec<HoleStep>,
    /// Largest ratio of programmed to modelled pecks: 1 if all are modelled, infinite without a bound.
    pub pecks_per_made: f64,
}

impl From<Vec<HoleStep>> for HolePlan {
    /// Returns steps without pecks.
    fn from(steps: Vec<HoleStep>) -> HolePlan {
        HolePlan { steps, pecks_per_made: 1.0 }
    }
}

/// The reason why a hole is not made. Heights in mm.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum NoHole {
    /// A hole without a reference height.
    #[error("no R")]
    NoReference,
    /// A hole without a bottom.
    #[error("no depth ({0})")]
    NoBottom(char),
    /// A bottom above the reference height.
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
        /// End of the counterbore.
        top: f64,
        /// Start of the counterbore.
        bottom: f64,
    },
    /// A counterbore without an end.
    #[error("no top of the bore ({0})")]
    NoTop(char),
    /// Pecks without a depth.
    #[error("no Q")]
    NoPeck,
    /// A depth of pecks that is not positive.
    #[error("pecks of {0} mm")]
    BadPeck(f64),
    /// A height beyond any machine.
    #[error("a height is out of reach")]
    OutOfReach,
    /// More steps in all holes of the program than the bound.
    #[error("all holes together need more than {0} moves and stops")]
    TooMuchWork(usize),
    /// A pattern of no hole, or of too many.
    #[error("{0} is no number of holes from 1 to 10000")]
    NoCount(f64),
    /// A threading cycle with the same name.
    #[error("threading (with I, J and K) is not modelled")]
    Threading,
}

/// Returns the steps of `hole`, from any height above its centre.
///
/// # Errors
///
/// If the hole has no depth, its pecks have none, or a height is out of reach.
pub fn work(hole: &Hole) -> Result<HolePlan, NoHole> {
    let Hole { kind, reference, bottom, feed_out_to, return_to, dwell, dwell_outside, .. } = *hole;
    let depth = reference - bottom;
    if !depth.is_finite() || !return_to.is_finite() || !feed_out_to.is_finite() {
        return Err(NoHole::OutOfReach);
    }
    if depth < 0.0 {
        return Err(NoHole::BottomAboveReference { bottom, reference });
    }
    let feed_in = |to| HoleStep::Feed { to, feedrate: hole.feed_in };
    let feed_out = HoleStep::Feed { to: feed_out_to, feedrate: hole.feed_out };
    let mut pecks_per_made = 1.0;
    let mut steps = vec![HoleStep::Rapid(reference)];
    match kind {
        HoleKind::Drill => steps.extend([feed_in(bottom), HoleStep::Dwell(dwell)]),
        HoleKind::ChipBreak { pecks, retract, ceiling } => {
            pecks_per_made = peck(depth, pecks, |left| {
                steps.push(feed_in(bottom + left));
                if 0.0 < left {
                    steps.push(HoleStep::Rapid((bottom + left + retract).min(ceiling)));
                }
            })?;
            steps.push(HoleStep::Dwell(dwell));
        }
        HoleKind::Peck { pecks, clearance, ceiling } => {
            pecks_per_made = peck(depth, pecks, |left| {
                steps.push(feed_in(bottom + left));
                if 0.0 < left {
                    let again = (bottom + left + clearance).min(ceiling);
                    steps.extend([HoleStep::Rapid(reference), HoleStep::Rapid(again)]);
                }
            })?;
            steps.push(HoleStep::Dwell(dwell));
        }
        HoleKind::Tap { turn, is_rigid, pecks } => {
            pecks_per_made = tap(hole, (turn, is_rigid), pecks, &mut steps)?;
        }
        HoleKind::Bore => {
            steps.extend([feed_in(bottom), HoleStep::Dwell(dwell), feed_out, HoleStep::Dwell(dwell_outside)]);
        }
        HoleKind::BoreAndStop { turn, by_hand } => {
            steps.extend([feed_in(bottom), HoleStep::Dwell(dwell), HoleStep::Stop]);
            steps.extend(by_hand.then_some(HoleStep::Wait));
            steps.extend([HoleStep::Rapid(return_to), HoleStep::Start(turn)]);
        }
        HoleKind::FineBore { turn, shift } => {
            steps.extend([feed_in(bottom), HoleStep::Dwell(dwell), HoleStep::Orient, HoleStep::Shift(shift)]);
            steps.extend([HoleStep::Rapid(return_to), HoleStep::Shift([0.0; 2]), HoleStep::Start(turn)]);
        }
        HoleKind::BackBore { top, .. } if top < bottom => return Err(NoHole::TopBelowBottom { top, bottom }),
        HoleKind::BackBore { turn, shift, top, feeds_back } => {
            steps.extend([
                HoleStep::Orient,
                HoleStep::Shift(shift),
                HoleStep::Rapid(bottom),
                HoleStep::Shift([0.0; 2]),
            ]);
            steps.extend([HoleStep::Start(turn), feed_in(top), HoleStep::Dwell(dwell)]);
            steps.extend(feeds_back.then_some(feed_in(bottom)));
            steps.extend([HoleStep::Orient, HoleStep::Shift(shift), HoleStep::Rapid(return_to)]);
            steps.extend([HoleStep::Shift([0.0; 2]), HoleStep::Start(turn)]);
        }
    }
    if !matches!(kind, HoleKind::BoreAndStop { .. } | HoleKind::FineBore { .. } | HoleKind::BackBore { .. }) {
        steps.push(HoleStep::Rapid(return_to));
    }
    steps.retain(|step| !matches!(step, HoleStep::Dwell(seconds) if *seconds <= 0.0));
    Ok(HolePlan { steps, pecks_per_made })
}

/// Appends the steps of a tap from the reference height; returns the largest ratio of programmed to modelled pecks.
fn tap(
    hole: &Hole,
    (turn, is_rigid): (SpindleTurn, bool),
    pecks: Option<TapPecks>,
    steps: &mut Vec<HoleStep>,
) -> Result<f64, NoHole> {
    let Hole { reference, bottom, feed_in, feed_out, .. } = *hole;
    let stop = (!is_rigid).then_some(HoleStep::Stop);
    let start = |turn| stop.into_iter().chain([HoleStep::Start(turn)]);
    let TapPecks { depth, back } = pecks.unwrap_or(TapPecks { depth: f64::INFINITY, back: 0.0 });
    let pecks_per_made = peck(reference - bottom, Pecks::equal(depth), |left| {
        steps.push(HoleStep::Feed { to: bottom + left, feedrate: feed_in });
        if 0.0 < left {
            steps.extend(start(turn.reversed()));
            let to = (bottom + left + back).min(reference);
            steps.push(HoleStep::Feed { to, feedrate: feed_out });
            steps.extend(start(turn));
        }
    })?;
    steps.push(HoleStep::Dwell(hole.dwell));
    let out = HoleStep::Feed { to: hole.feed_out_to, feedrate: feed_out };
    steps.extend(start(turn.reversed()).chain([out]));
    steps.push(HoleStep::Dwell(hole.dwell_outside));
    steps.extend(start(turn));
    Ok(pecks_per_made)
}

/// Calls `each` with the height of every peck above the bottom, mm, which is 0 for the last one. Returns the largest
/// ratio of programmed to modelled pecks.
///
/// # Errors
///
/// If the first depth is not positive.
pub(crate) fn peck(depth: f64, pecks: Pecks, mut each: impl FnMut(f64)) -> Result<f64, NoHole> {
    if pecks.first.is_nan() || pecks.first <= 0.0 {
        return Err(NoHole::BadPeck(pecks.first));
    }
    // The rest is measured from the bottom, so it always shrinks, however far from zero the heights are.
    let shallowest = depth / f64::from(MAX_PECKS);
    let (mut left, mut next, mut made, mut has_deeper) = (depth, pecks.first, 0_u32, false);
    loop {
        has_deeper |= next < shallowest;
        made += 1;
        let peck = next.max(shallowest);
        if left - peck < MIN_PECK_MM {
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

/// Returns the largest ratio of programmed pecks, of at least `least` (mm), to the number `made` over a depth
/// (mm).
pub(crate) fn written_per_made(depth: f64, least: f64, made: u32) -> f64 {
    (depth / least.max(0.0) / f64::from(made)).max(1.0)
}

#[cfg(test)]
#[path = "hole_tests.rs"]
mod tests;
