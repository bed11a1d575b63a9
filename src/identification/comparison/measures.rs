//! How far apart two motions are, in one number each.

use crate::identification::alignment::Alignment;
use crate::identification::comparison::pointwise::{Pointwise, pointwise};
use crate::simulation::feed::FeedPlan;
use crate::simulation::profile::Profile;
use crate::simulation::toolpath::Toolpath;

/// Half the time around a mark over which the residual is a mean, s.
const AROUND: f64 = 0.25;

/// How far feedrates differ on feed moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeedError {
    /// Root mean square of recorded less simulated feedrate over distance, mm/s.
    pub rms: f64,
    /// The same of recorded less programmed feedrate, mm/s: what length ÷ feed amounts to.
    pub programmed_rms: f64,
    /// Mean programmed feedrate over distance, mm/s.
    pub programmed: f64,
}

/// How far positions differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionError {
    /// Root mean square of the distance between recorded and simulated position at the same place, mm.
    pub rms: f64,
    /// Largest of it, mm.
    pub largest: f64,
}

impl FeedError {
    /// Of rows at the same places; none where none is on a feed move.
    pub fn of(rows: &Pointwise) -> Option<FeedError> {
        let (mut squares, mut programmed_squares, mut sum, mut way) = (0.0, 0.0, 0.0, 0.0);
        for row in 1..rows.distance.len() {
            let Some(programmed) = rows.programmed[row] else { continue };
            let step = rows.distance[row] - rows.distance[row - 1];
            squares += step * (rows.recorded[row] - rows.simulated[row]).powi(2);
            programmed_squares += step * (rows.recorded[row] - programmed).powi(2);
            sum += step * programmed;
            way += step;
        }
        (0.0 < way).then(|| FeedError {
            rms: (squares / way).sqrt(),
            programmed_rms: (programmed_squares / way).sqrt(),
            programmed: sum / way,
        })
    }
}

pub fn feed_error(
    toolpath: &Toolpath,
    plan: &FeedPlan,
    alignment: &Alignment,
    _simulated: &[f64],
    _residuals: &[f64],
) -> Option<FeedError> {
    FeedError::of(&pointwise(toolpath, plan, alignment, alignment.feed.as_ref()))
}

pub fn position_error(
    toolpath: &Toolpath,
    plan: &FeedPlan,
    alignment: &Alignment,
    simulated: &[f64],
    residuals: &[f64],
) -> Option<PositionError> {
    let track = alignment.track.as_ref()?;
    let profile = Profile::new(toolpath, plan);
    let smooth = smoothed(alignment, simulated, residuals);
    let offset = alignment.marks.first()?.time - simulated.first()?;
    let (mut squares, mut largest, mut count) = (0.0, 0.0f64, 0.0);
    let mut mark = 0;
    for fix in &alignment.fixes {
        let Some(sample) = fix.sample else { continue };
        while mark + 1 < alignment.marks.len() && alignment.marks[mark + 1].time <= fix.time {
            mark += 1;
        }
        let state = profile.at_time(fix.time - offset - smooth[mark]);
        let apart = (0..3)
            .filter(|axis| track.recorded[*axis])
            .map(|axis| (track.position[sample][axis] - state.position[axis]).powi(2))
            .sum::<f64>();
        squares += apart;
        largest = largest.max(apart);
        count += 1.0;
    }
    (0.0 < count).then(|| PositionError { rms: f64::sqrt(squares / count), largest: largest.sqrt() })
}

/// The residual as its mean around each mark, by the certainty of the marks; a jump as at a stop stays.
fn smoothed(alignment: &Alignment, simulated: &[f64], residuals: &[f64]) -> Vec<f64> {
    let marks = &alignment.marks;
    let (mut from, mut to) = (0, 0);
    let (mut sum, mut weight) = (0.0, 0.0);
    let certainty = |at: usize| marks[at].deviation.powi(-2);
    let mut smooth = Vec::with_capacity(marks.len());
    for at in 0..marks.len() {
        while to < marks.len() && simulated[to] <= simulated[at] + AROUND {
            sum += certainty(to) * residuals[to];
            weight += certainty(to);
            to += 1;
        }
        while simulated[from] < simulated[at] - AROUND {
            sum -= certainty(from) * residuals[from];
            weight -= certainty(from);
            from += 1;
        }
        smooth.push(if 0.0 < weight { sum / weight } else { residuals[at] });
    }
    smooth
}
