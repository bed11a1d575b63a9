//! Words that wait for the spindle, and the growth of its ramp with the speed.
//!
//! A control may continue while the spindle ramps: M3 takes a moment, and the coolant's M8 that follows takes
//! seconds, the more of them the faster the spindle is to run. Of the words between one change of the speed and the
//! next, the one that takes longest is the one that waits; a word counts as waiting if that holds for most changes.
//! Each of its visits then takes
//!
//! ```text
//! t = t_word + k x,      x = N |f(n2) − f(n1)|     of `SpindleTimes::ramp`
//! ```
//!
//! k is the median of the slopes between two visits of one word at different x (Theil 1950, Sen 1968), which needs
//! runs at two speeds; t_word is the median of the remaining times t − k x. The exponents tried are those of
//! constant torque, constant power and less; runs on real mills have shown the last.

use std::collections::BTreeMap;

use crate::identification::alignment::median;
use crate::identification::effects::StopKind;
use crate::identification::fit::Run;
use crate::machine::{Machine, SpindleState, SpindleTimes};
use crate::simulation::toolpath::StopCause;

/// Exponents of the ramp tried.
const EXPONENTS: [Option<f64>; 3] = [None, Some(2.0), Some(3.0)];
/// Least relative difference of two ramps from which a slope is taken.
const MIN_RAMP_DIFFERENCE_RATIO: f64 = 0.1;

/// A visit of a word while the spindle ramps.
struct Waited {
    code: u32,
    /// Speeds before and after, rpm, signed by the direction.
    speeds: [f64; 2],
    /// Time of the visit, s.
    seconds: f64,
}

/// Returns the machines whose words wait for the spindle, one for each exponent with the ramp that the runs show;
/// empty if they show none or the machine already has one.
pub fn guesses(found: &Machine, runs: &[Run]) -> Vec<Machine> {
    let times = &found.times;
    if times.spindle.ramp != 0.0 || !times.spindle_awaited_by.is_empty() {
        return Vec::new();
    }
    let (words, waited) = awaiting(found, runs);
    let guess = |exponent: &Option<f64>| {
        let law = SpindleTimes { ramp: 1.0, exponent: *exponent, ..times.spindle };
        let size = |visit: &Waited| law.ramp(visit.speeds[0], visit.speeds[1]);
        let mut slopes = Vec::new();
        for (at, one) in waited.iter().enumerate() {
            for other in waited[..at].iter().filter(|other| other.code == one.code) {
                let step = size(one) - size(other);
                if MIN_RAMP_DIFFERENCE_RATIO * size(one).max(size(other)) < step.abs() {
                    slopes.push((one.seconds - other.seconds) / step);
                }
            }
        }
        let slope = if slopes.is_empty() { 0.0 } else { median(&mut slopes) };
        (0.0 < slope).then(|| {
            let mut machine = found.clone();
            machine.times.spindle.ramp = slope;
            machine.times.spindle.exponent = *exponent;
            machine.times.spindle_awaited_by.clone_from(&words);
            for word in &words {
                let own = waited.iter().filter(|visit| visit.code == *word);
                let mut left: Vec<f64> = own.map(|visit| visit.seconds - slope * size(visit)).collect();
                machine.times.m_codes.insert(*word, median(&mut left).max(0.0));
            }
            machine
        })
    };
    EXPONENTS.iter().filter_map(guess).collect()
}

/// Returns the words that wait, and every visit of one that follows a change of the speed.
fn awaiting(found: &Machine, runs: &[Run]) -> (Vec<u32>, Vec<Waited>) {
    // For each word how often it took longest of those after a change, and how often another did.
    let mut votes: BTreeMap<u32, [usize; 2]> = BTreeMap::new();
    let mut all = Vec::new();
    for run in runs {
        let comparison = run.compared(found);
        let mut change: Option<[f64; 2]> = None;
        let mut since: Vec<Waited> = Vec::new();
        let mut close = |since: &mut Vec<Waited>| {
            let longest = since.iter().map(|visit| visit.seconds).fold(0.0, f64::max);
            for visit in since.iter() {
                votes.entry(visit.code).or_default()[usize::from(visit.seconds < longest)] += 1;
            }
            all.append(since);
        };
        for visit in &comparison.lost {
            let causes = run.toolpath.stops[visit.stops.clone()].iter().map(|stop| &stop.cause);
            let of_words: Vec<&StopCause> = causes.filter(|cause| cause.m_code().is_some()).collect();
            let [cause] = of_words[..] else { continue };
            let signed = |spin: &SpindleState| spin.signed_speed();
            if let StopCause::Spindle { from, to, .. } = cause {
                close(&mut since);
                change = Some([signed(from), signed(to)]);
            } else if let (Some(kind @ StopKind::MWord(code)), Some(speeds)) = (StopKind::of(cause), change) {
                let seconds = kind.value(found) + visit.seconds();
                since.push(Waited { code, speeds, seconds });
            }
        }
        close(&mut since);
    }
    let waits = |word: &u32| votes.get(word).is_some_and(|[most, others]| others < most);
    let words: Vec<u32> = votes.keys().copied().filter(waits).collect();
    all.retain(|visit| words.contains(&visit.code));
    (words, all)
}
