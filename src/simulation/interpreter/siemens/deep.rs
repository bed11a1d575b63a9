//! Holes in several strokes: CYCLE83, and CYCLE84 with VARI 1 or 2.
//!
//! ```text
//! CYCLE83, strokes t below RFP, s(1) = FDEP or FDPR:
//!   t(n) = t(n-1) + s(n)
//!   s(n+1) = s(n)                         DAM = 0
//!          = max(s(n) |DAM|, MDEP)        DAM a factor
//!          = max(s(n) - DAM, DAM)         DAM an amount; two equal strokes instead of the last
//!                                         two where less than 2 DAM is left
//! ```
//!
//! The first stroke is made with the feed times FRF. At each depth the tool waits DTB, at the last one DTD if it
//! is given. To break chips (VARI 0) it moves up by VRT (1 mm if that is 0) in feed. To remove them (VARI 1) it
//! moves out to the reference height in rapid, waits DTS, and returns in rapid to DIS1 above the last depth; if
//! that is 0, to 0.6 mm, or a 50th of holes deeper than 30 mm, at most 7 mm.
//!
//! CYCLE84 taps DAM after DAM. Between them the spindle reverses, and the tap moves up by VRT or to the reference
//! height, as fast as out of the hole.
//!
//! Source: SINUMERIK 840D sl, Programming Manual Cycles, 2013, CYCLE83 and CYCLE84.

use crate::simulation::gcode::{DrillingCycle, DrillingKind};
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::cycle::hole::{
    HoleKind, HolePlan, HoleStep, MAX_PECKS, SpindleTurn, written_per_made,
};
use crate::simulation::interpreter::cycle::{Hole, NoHole};
use crate::simulation::interpreter::siemens::cycle::mode;
use crate::simulation::interpreter::state::Interpreter;

/// Retract of chip breaking without a value in the program, mm.
const CHIP_BREAK_RETRACT_MM: f64 = 1.0;

/// Least rest above the bottom that makes another stroke, mm.
const MIN_STROKE_MM: f64 = 1e-6;

/// The law by which strokes decrease.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Degression {
    None,
    /// By a factor, down to a least stroke, mm.
    Factor(f64, f64),
    /// By an amount, mm.
    Amount(f64),
}

impl Interpreter<'_> {
    /// Returns the steps of a hole in several strokes, or `None` if the hole is not one.
    pub(super) fn siemens_deep_work(
        &mut self,
        block: Block,
        cycle: &DrillingCycle,
        hole: &Hole,
    ) -> Result<Option<HolePlan>, NoHole> {
        let unit = self.modal.unit;
        let clearance = cycle.clearance.abs() * unit;
        let depth = hole.reference - clearance - hole.bottom;
        let strokes = match cycle.kind {
            DrillingKind::DeepHole { first_depth, first_relative_depth, degression, min_stroke, .. } => {
                let first = match (first_relative_depth, first_depth, mode(cycle, 4)) {
                    (Some(relative), _, 0 | 1) => relative.abs() * unit,
                    (None, Some(relative), 1) => relative.abs() * unit,
                    (_, Some(height), _) => (cycle.part_height - height) * unit,
                    _ => depth,
                };
                let degression = match (degression, mode(cycle, 5)) {
                    (0.0, _) => Degression::None,
                    (percent, 2) => Degression::Factor(0.01 * percent.abs(), min_stroke.abs() * unit),
                    (factor, 0) if factor < 0.0 => Degression::Factor(-factor, min_stroke.abs() * unit),
                    (amount, _) => Degression::Amount(amount.abs() * unit),
                };
                strokes(depth, first, degression)
            }
            DrillingKind::RigidTap { stroke: Some(stroke), .. } => {
                strokes(depth, stroke.abs() * unit, Degression::None)
            }
            _ => return Ok(None),
        };
        if depth < 0.0 {
            return Err(NoHole::BottomAboveReference { bottom: hole.bottom, reference: hole.reference });
        }
        let (depths, pecks_per_made) = strokes?;
        self.remark_on_deeper_pecks(block, pecks_per_made);
        let surface = hole.reference - clearance;
        let heights = depths.into_iter().map(|below| surface - below);
        let steps = match cycle.kind {
            DrillingKind::RigidTap { retract, removes_chips, .. } => {
                tapping(hole, heights, retract, unit, removes_chips)
            }
            _ => self.deep_drilling(cycle, hole, heights, depth),
        };
        Ok(Some(HolePlan { steps, pecks_per_made }))
    }

    /// Returns the steps of CYCLE83.
    fn deep_drilling(
        &self,
        cycle: &DrillingCycle,
        hole: &Hole,
        heights: impl Iterator<Item = f64>,
        depth: f64,
    ) -> Vec<HoleStep> {
        let unit = self.modal.unit;
        let DrillingKind::DeepHole {
            dwell_outside,
            last_dwell,
            first_feed_factor,
            removes_chips,
            retract,
            limit,
            ..
        } = cycle.kind
        else {
            return Vec::new();
        };
        let dwell = self.siemens_seconds(cycle.dwell, mode(cycle, 1));
        let last_dwell = last_dwell.map_or(dwell, |value| self.siemens_seconds(value, mode(cycle, 3)));
        let outside = self.siemens_seconds(dwell_outside, mode(cycle, 2));
        let retract = retract.map_or(CHIP_BREAK_RETRACT_MM, |retract| retract.abs() * unit);
        let automatic = if depth <= 30.0 { 0.6 } else { (depth / 50.0).min(7.0) };
        let limit = limit.map_or(automatic, |limit| limit.abs() * unit);
        // Newer calls give the factor in percent.
        let factor = match first_feed_factor.abs() {
            0.0 => 1.0,
            percent if 1.0 < percent => 0.01 * percent,
            factor => factor.max(0.001),
        };
        let mut steps = vec![HoleStep::Rapid(hole.reference)];
        let mut feedrate = hole.feed_in * factor;
        for to in heights {
            steps.push(HoleStep::Feed { to, feedrate });
            feedrate = hole.feed_in;
            if to <= hole.bottom {
                steps.push(HoleStep::Dwell(last_dwell));
            } else if removes_chips {
                let again = (to + limit).min(hole.reference);
                steps.extend([
                    HoleStep::Dwell(dwell),
                    HoleStep::Rapid(hole.reference),
                    HoleStep::Dwell(outside),
                    HoleStep::Rapid(again),
                ]);
            } else {
                let up = (to + retract).min(hole.reference);
                steps.extend([HoleStep::Dwell(dwell), HoleStep::Feed { to: up, feedrate }]);
            }
        }
        steps.push(HoleStep::Rapid(hole.return_to));
        steps.retain(|step| !matches!(step, HoleStep::Dwell(seconds) if *seconds <= 0.0));
        steps
    }

    /// Returns a dwell of a cycle, s; it is in revolutions of the spindle if it is negative, or by the mode 2.
    pub(crate) fn siemens_seconds(&self, value: f64, mode: u32) -> f64 {
        let is_turns = mode == 2 || mode == 0 && value < 0.0;
        let value = value.abs();
        let seconds =
            if is_turns { 60.0 * value / self.functions.speed.unwrap_or(f64::INFINITY) } else { value };
        if (0.0..=1e5).contains(&seconds) { seconds } else { 0.0 }
    }
}

/// Returns the steps of a tap in strokes, with the spindle reversed for each way up.
fn tapping(
    hole: &Hole,
    heights: impl Iterator<Item = f64>,
    retract: Option<f64>,
    unit: f64,
    removes_chips: bool,
) -> Vec<HoleStep> {
    let turn = match hole.kind {
        HoleKind::Tap { turn, .. } => turn,
        _ => SpindleTurn::Right,
    };
    let back = if turn == SpindleTurn::Right { SpindleTurn::Left } else { SpindleTurn::Right };
    let retract = retract.map_or(CHIP_BREAK_RETRACT_MM, |retract| retract.abs() * unit);
    let mut steps = vec![HoleStep::Rapid(hole.reference)];
    for to in heights {
        let is_last = to <= hole.bottom;
        let up = if is_last || removes_chips { hole.reference } else { (to + retract).min(hole.reference) };
        steps.push(HoleStep::Feed { to, feedrate: hole.feed_in });
        steps.extend((0.0 < hole.dwell).then_some(HoleStep::Dwell(hole.dwell)));
        steps.extend([
            HoleStep::Start(back),
            HoleStep::Feed { to: up, feedrate: hole.feed_out },
            HoleStep::Start(turn),
        ]);
    }
    steps.push(HoleStep::Rapid(hole.return_to));
    steps
}

/// Returns the depths below the surface at the ends of the strokes, mm, the last one `depth`, and the largest ratio of
/// programmed to modelled strokes.
fn strokes(depth: f64, first: f64, degression: Degression) -> Result<(Vec<f64>, f64), NoHole> {
    if !depth.is_finite() {
        return Err(NoHole::OutOfReach);
    }
    if first.is_nan() || first <= 0.0 {
        return Err(NoHole::BadPeck(first));
    }
    let shallowest = depth / f64::from(MAX_PECKS);
    let (mut depths, mut at, mut stroke, mut has_deeper) = (Vec::new(), 0.0, first, false);
    while MIN_STROKE_MM < depth - at - stroke {
        has_deeper |= stroke < shallowest;
        at += stroke.max(shallowest);
        depths.push(at);
        let left = depth - at;
        stroke = match degression {
            Degression::None => stroke,
            Degression::Factor(factor, least) => (stroke * factor).max(least),
            Degression::Amount(amount) => {
                let next = (stroke - amount).max(amount);
                // The last two strokes are equal.
                if next == amount && amount < left && left < 2.0 * amount { 0.5 * left } else { next }
            }
        };
    }
    depths.push(depth);
    let least = match degression {
        Degression::None => first,
        Degression::Factor(_, least) => least.min(first),
        // The last two strokes may be half of the least one.
        Degression::Amount(amount) => 0.5 * amount.min(first),
    };
    let made = depths.len() as u32;
    Ok((depths, if has_deeper { written_per_made(depth, least, made) } else { 1.0 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn depths(depth: f64, first: f64, degression: Degression) -> Vec<f64> {
        strokes(depth, first, degression).expect("strokes").0
    }

    #[test]
    fn strokes_shrink_as_the_manual_says() {
        assert_eq!(depths(20.0, 5.0, Degression::None), [5.0, 10.0, 15.0, 20.0]);
        assert_eq!(depths(3.0, 5.0, Degression::None), [3.0]);
        assert_eq!(depths(20.0, 8.0, Degression::Factor(0.5, 3.0)), [8.0, 12.0, 15.0, 18.0, 20.0]);
        assert_eq!(depths(10.0, 4.0, Degression::Amount(1.0)), [4.0, 7.0, 9.0, 10.0]);
        assert_eq!(depths(13.5, 5.0, Degression::Amount(3.0)), [5.0, 8.0, 10.75, 13.5]);
    }

    #[test]
    fn strokes_are_few() {
        let (depths, per_made) = strokes(10.0, 5.0, Degression::Factor(0.1, 0.0)).expect("strokes");
        assert!(per_made == f64::INFINITY && depths.len() <= MAX_PECKS as usize + 1);
        assert!(depths.windows(2).all(|pair| pair[0] < pair[1]), "{depths:?}");
        assert!(strokes(10.0, 0.0, Degression::None).is_err());
    }
}
