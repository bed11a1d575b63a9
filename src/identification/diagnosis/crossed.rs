//! Cross-validation: the feedrate error on stretches to which nothing was fitted.
//!
//! Each run is cut into stretches of equal time. The values of all named causes are fitted to every second
//! stretch, and the feedrates are compared on the others; then the other way round. In a long run the causes
//! are fitted to excerpts, and the feedrates are compared outside of them.

use crate::identification::calibration::Excerpt;
use crate::identification::comparison::PooledFeedError;
use crate::identification::diagnosis::evidence::{Candidate, Evidence, with_all};
use crate::identification::diagnosis::speeds;
use crate::identification::fit::Run;
use crate::machine::Machine;

/// Number of stretches of a run.
const STRETCHES: f64 = 8.0;

/// Root mean squares of recorded less simulated feedrates, mm/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossed {
    /// Error without the causes.
    pub before: f64,
    /// Error with the causes, at the values fitted to other stretches.
    pub after: f64,
}

/// Returns the feedrate errors on each half of the stretches, with the causes at the values fitted to the other half.
/// `base` is the machine with the causes that are not fitted to times. `None` if no feedrate was recorded or no cause
/// is named.
pub fn crossed(machine: &Machine, base: &Machine, named: &[Candidate], runs: &[Run]) -> Option<Crossed> {
    let (last, others) = named.split_last()?;
    let whole = Evidence::of(runs, &with_all(base, named));
    let mut sums = [PooledFeedError::default(); 2];
    for fold in 0..2 {
        let is_held = |run: &Run, time: f64| {
            let Some((first, last)) = run.alignment.marks.first().zip(run.alignment.marks.last()) else {
                return false;
            };
            let stretch = (time - first.time) / (last.time - first.time).max(1e-9) * STRETCHES;
            stretch.max(0.0) as usize % 2 == fold
        };
        let mut rest = whole.clone();
        for (run, whitening) in runs.iter().zip(&mut rest.whitenings) {
            let marks = &run.alignment.marks;
            whitening.ignore(|mark| is_held(run, marks[mark].time));
        }
        let (last, mut all) = rest.refined(base, last, others);
        all.push(last);
        let fitted = with_all(base, &all);
        for (machine, sum) in [machine, &fitted].into_iter().zip(&mut sums) {
            for run in runs {
                sum.add(speeds::error(machine, run, &|time| is_held(run, time)));
            }
        }
    }
    sums[0].rms().zip(sums[1].rms()).map(|(before, after)| Crossed { before, after })
}

/// Returns the feedrate errors outside of the excerpts, where nothing was fitted; `None` if no feedrate was recorded
/// there.
pub fn outside(
    machine: &Machine,
    fitted: &Machine,
    runs: &[Run],
    excerpts: &[Vec<Excerpt>],
) -> Option<Crossed> {
    let mut sums = [PooledFeedError::default(); 2];
    for (machine, sum) in [machine, fitted].into_iter().zip(&mut sums) {
        for (run, excerpts) in runs.iter().zip(excerpts) {
            let held = |time: f64| !excerpts.iter().any(|excerpt| excerpt.time().contains(&time));
            sum.add(speeds::error(machine, run, &held));
        }
    }
    sums[0].rms().zip(sums[1].rms()).map(|(before, after)| Crossed { before, after })
}
