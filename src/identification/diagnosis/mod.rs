//! Machine and runs → [`Diagnosis`]: where simulation and recording differ, what was left out, and how sure.
//!
//! Hypotheses are taken in one at a time, the one first that explains most. Of each the values are searched
//! over its trials, then by least squares with all that was named before; the best are compared at the
//! noise that the best of them leaves. One is named only if it passes every gate:
//!
//! | gate | what must hold |
//! |---|---|
//! | likelihood | the cost falls by more than `GAIN` + k ln n, n sections of the path, not samples |
//! | held out | fitted without a section, it is better there, in most sections where it acts |
//! | place | where it explains little of all, it fits where it is better than anywhere else it is shifted to |
//! | feedrate | feedrates differ no more with it than without it |
//! | size | it explains more than `SIZE` of the cycle time, than `LEAST` s, and than `BESIDE` of what is explained |
//!
//! What stands for itself is taken in before all of them: an override that `plateaus` reads off, waits at functions
//! as `waits` does, and feed holds, as `rests` finds them. A long run is searched in `excerpts` of it, and what was found is kept if it holds
//! on the whole.
//!
//! After each the rest is looked at again; at the end every one that the others make unnecessary is taken
//! back. Others of which the best cannot be told from the runs are its ambiguity.
//!
//! What is left is judged by itself: lost time that is larger than noise, than `LEFT` of the cycle time, and than
//! what the machine file is known to be off by where it was calibrated, is unknown, and located. What the
//! operator did is explained all the same where it is certain and more than what is left.

mod confidence;
mod crossed;
mod evidence;
mod excerpts;
mod form;
mod gates;
mod places;
mod plateaus;
mod regions;
mod rests;
mod waits;

pub use crossed::Crossed;
pub use evidence::{Candidate, Evidence};
pub use plateaus::{Plateau, plateau};
pub use regions::{Region, regions};
pub use rests::feed_holds;

use crate::identification::comparison::{Comparison, compare};
use crate::identification::diagnosis::confidence::{odds, weighed};
use crate::identification::diagnosis::evidence::with_all;
use crate::identification::diagnosis::excerpts::{Excerpt, excerpts};
use crate::identification::diagnosis::gates::HeldOut;
use crate::identification::diagnosis::plateaus::Said;
use crate::identification::fit::{Run, Scale};
use crate::identification::hypotheses::{Hypothesis, Trace, library};
use crate::machine::Machine;

/// By how much the cost must fall, beside ln n a parameter.
const GAIN: f64 = 12.0;
/// What a cause must explain, as a part of the cycle time.
const SIZE: f64 = 3e-4;
/// What a cause must explain, s.
const LEAST: f64 = 0.015;
/// What a further cause must explain, as a part of what those before it do.
const BESIDE: f64 = 0.02;
/// What a cause moves back and forth counts by this part.
const NETTED: f64 = 0.2;
/// A gain of this part of what is left needs no test of its place.
const LARGE: f64 = 0.5;
/// What is left unexplained without a word, as a part of the cycle time.
const LEFT: f64 = 2e-3;
/// By what ratio feedrates may differ more with a cause than without it.
const WORSE: f64 = 1.03;
/// What is left of what there was, from which on it is not explained.
const MUCH: f64 = 0.25;
/// Candidates whose cost is this close to the best's cannot be told from it, over how much more than independent
/// ones the residuals vary.
const SAME: f64 = 6.0;
/// What is farther from the best, as a part of what that leaves, is not looked at again.
const NEAR: f64 = 1.0;
/// A setting this close to the believed one, as a ratio, is that one; what an operator or a clock does is
/// known to be exactly 1.
const BELIEVED: f64 = 6e-3;
const SWITCHES: [&str; 3] = ["feed_override", "rapid_override", "recorder_clock"];
/// What an operator does.
pub const OPERATOR: [&str; 3] = ["feed_override", "rapid_override", "feed_hold"];
/// A confidence from which on a cause is certain.
const CERTAIN: f64 = 0.9;
/// A cause that is less sure than this is not named.
const UNSURE: f64 = 0.1;
/// Candidates that are refined by least squares.
const REFINED: usize = 5;
/// Causes named at most.
const MOST: usize = 4;

/// What the diagnosis comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Recording and simulation agree as far as the recording shows.
    NothingMissing,
    /// What differs has named causes.
    Explained,
    /// A cause cannot be told from another.
    Ambiguous,
    /// Something differs, here, and nothing in the library explains it.
    Unknown,
}

/// A named cause.
#[derive(Clone, Debug)]
pub struct Cause {
    /// What it is, with its values.
    pub candidate: Candidate,
    /// Time it explains, s, all runs together.
    pub seconds: f64,
    /// Form error it explains, mm; 0 for causes of time.
    pub form: f64,
    /// Lines on which it acts, as ranges.
    pub lines: Vec<(u32, u32)>,
    /// How sure, 0 to 1.
    pub confidence: f64,
    /// Ids of what it cannot be told from on these runs.
    pub alike: Vec<String>,
    /// Whether it was better where it was not fitted.
    pub held_out: Option<HeldOut>,
}

/// What was found.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// In one word.
    pub verdict: Verdict,
    /// The causes, the one that explains most first.
    pub causes: Vec<Cause>,
    /// Where simulation and recording differ, cause or no cause, run by run.
    pub regions: Vec<Region>,
    /// Lost time that the causes leave, s, all runs together, and where most of it is.
    pub left: (f64, Option<Region>),
    /// The machine with the causes.
    pub machine: Machine,
    /// Against the machine believed in, run by run.
    pub before: Vec<Comparison>,
    /// Against the machine with the causes, run by run.
    pub after: Vec<Comparison>,
    /// Form error before and after, mm; none without positions.
    pub form: Option<(f64, f64)>,
    /// How far feedrates differ where nothing was fitted; none where nothing is named or no feed is known.
    pub held_out: Option<Crossed>,
    /// Ids of what the program does not excite.
    pub not_excited: Vec<String>,
    /// What to know, for people.
    pub messages: Vec<String>,
}

/// Diagnoses runs against the machine believed in. `progress` is told the part that is done.
pub fn diagnose(machine: &Machine, runs: &[Run], progress: &mut dyn FnMut(f64)) -> Diagnosis {
    let mut library = library(machine, runs);
    let not_excited = not_excited(&library);
    let before = compared(machine, runs);
    let mut messages = Vec::new();
    let form_before = form::error(machine, runs);
    // Drives come first where they explain the form of the path whole: they also blur its times.
    let drives = form::explained(machine, runs, &library, true);
    let start = with_all(machine, &drives);
    progress(0.1);
    // Where the form is explained whole, at times as they are, no time is missing either.
    let rounds = if drives.is_empty() { MOST } else { 0 };
    let excerpts = if 0 < rounds { excerpts(runs) } else { None };
    let parts: Option<Vec<Run>> =
        excerpts.as_ref().map(|excerpts| excerpts.iter().flatten().map(Excerpt::run).collect());
    let looked = Looked { runs: parts.as_deref().unwrap_or(runs), whole: runs, in_parts: parts.is_some() };
    // What is read off stays as it is; what is fitted is fitted again with everything that comes after.
    let mut read_off: Vec<(Candidate, Details)> = Vec::new();
    let mut named: Vec<Candidate> = Vec::new();
    let mut details: Vec<Details> = Vec::new();
    if 0 < rounds {
        let said = plateaus::feed_override(&start, runs, &library);
        if !matches!(said, Said::Nothing) {
            library.retain(|hypothesis| hypothesis.id != "feed_override");
        }
        if let Said::Other(candidate) = said {
            read_off.push((candidate, (Vec::new(), None, 1.0)));
        }
        let price = gates::price(runs, 1);
        let own = |gain: f64| (Vec::new(), None, odds(gain, price));
        let now = with_all(&start, &candidates_of(&read_off));
        for (candidate, gain) in waits::at_functions(&now, runs, &library, price) {
            let known = candidate.hypothesis.freed[0].key.clone();
            library.retain(|other| other.freed.first().is_none_or(|freed| freed.key != known));
            read_off.push((candidate, own(gain)));
        }
        let now = with_all(&start, &candidates_of(&read_off));
        for (candidate, gain) in rests::feed_holds(&now, runs, price) {
            let own = own(gain);
            if looked.in_parts {
                read_off.push((candidate, own));
            } else {
                named.push(candidate);
                details.push(own);
            }
        }
    }
    let base = with_all(&start, &candidates_of(&read_off));
    for round in 0..rounds {
        let current = with_all(&base, &named);
        let Some(found) = next_cause(&base, &current, &looked, &library, &named, &mut |part| {
            progress(0.1 + 0.7 * (round as f64 + part) / MOST as f64);
        }) else {
            break;
        };
        named = found.others;
        named.push(found.candidate);
        details.push((found.alike, found.held_out, found.confidence));
    }
    let (named, details) = without_unnecessary(&base, &looked, named, details);
    let (named, details) = if looked.in_parts { held(&base, runs, named, details) } else { (named, details) };
    let details = weighed(&base, runs, &named, details);
    let with_time = with_all(&base, &named);
    let mut drives = drives;
    if 0 < rounds {
        drives = form::explained(&with_time, runs, &library, false);
    }
    let fitted = with_all(&with_time, &drives);
    let after = compared(&fitted, runs);
    progress(0.9);
    let (mut all, mut all_details): (Vec<Candidate>, Vec<Details>) = read_off.into_iter().unzip();
    all.extend(named.iter().cloned());
    all_details.extend(details);
    let mut causes: Vec<Cause> = all
        .iter()
        .zip(all_details)
        .enumerate()
        .map(|(at, (candidate, (alike, held_out, confidence)))| {
            let mut others = all.clone();
            others.remove(at);
            let without = with_all(&with_all(&start, &others), &drives);
            let (seconds, lines) = regions::acts_on(&without, &fitted, runs);
            Cause { candidate: candidate.clone(), seconds, form: 0.0, lines, confidence, alike, held_out }
        })
        .collect();
    causes.sort_by(|a, b| b.seconds.abs().total_cmp(&a.seconds.abs()));
    let form_after = form::error(&fitted, runs);
    let form = form_before.zip(form_after);
    causes.extend(drives.iter().map(|candidate| Cause {
        candidate: candidate.clone(),
        seconds: 0.0,
        form: form.map_or(0.0, |(before, after)| (before * before - after * after).max(0.0).sqrt()),
        lines: regions::all_lines(runs),
        confidence: form.map_or(0.5, |(before, after)| 1.0 - (after / before).powi(2)),
        alike: Vec::new(),
        held_out: None,
    }));
    let located = |side: &[Comparison], machine: &Machine| -> Vec<Region> {
        (0..runs.len()).flat_map(|run| regions(&side[run], &runs[run].by_clock(machine), run)).collect()
    };
    let left = regions::left(&after, runs, &fitted);
    let left_most =
        located(&after, &fitted).into_iter().max_by(|a, b| a.seconds.abs().total_cmp(&b.seconds.abs()));
    let whole: f64 = after.iter().map(|comparison| comparison.whole.recorded).sum();
    let known_error = machine.cycle_time_error.map_or(0.0, f64::abs);
    // Beside what causes explain, what they leave is judged by that; else by what no cycle time shows.
    let is_much = !causes.is_empty() && MUCH * regions::left(&before, runs, machine) < left;
    let is_left = 0 < rounds && LEAST.max(known_error * whole) < left && (is_much || LEFT * whole < left);
    if is_left && !causes.is_empty() {
        messages.push(format!("{left:.2} s of lost time are left that nothing in the library explains"));
    } else if LEFT * whole < left && left <= known_error * whole {
        messages.push(format!(
            "{left:.2} s of lost time are left, which is no more than the {:.1} % that the machine file was off by \
             where it was calibrated",
            100.0 * known_error
        ));
    }
    let is_done = |cause: &&Cause| OPERATOR.contains(&cause.candidate.hypothesis.id);
    let sure = causes.iter().filter(is_done).filter(|cause| CERTAIN <= cause.confidence);
    let by_operator: f64 = sure.map(|cause| cause.seconds.abs()).sum();
    let verdict = match (causes.is_empty(), is_left) {
        (true, true) => Verdict::Unknown,
        (true, false) => Verdict::NothingMissing,
        _ if causes.iter().any(|cause| !cause.alike.is_empty()) => Verdict::Ambiguous,
        (false, true) if by_operator < left && is_much => Verdict::Unknown,
        _ => Verdict::Explained,
    };
    progress(1.0);
    let held_out = match &excerpts {
        Some(excerpts) if !all.is_empty() => crossed::outside(machine, &fitted, runs, excerpts),
        Some(_) => None,
        None => crossed::crossed(machine, &with_all(&base, &drives), &named, runs),
    };
    Diagnosis {
        verdict,
        causes,
        regions: located(&before, machine),
        left: (left, left_most),
        machine: fitted,
        before,
        after,
        form,
        held_out,
        not_excited,
        messages,
    }
}

fn compared(machine: &Machine, runs: &[Run]) -> Vec<Comparison> {
    runs.iter().map(|run| compare(run.toolpath, &run.plan(machine), &run.by_clock(machine))).collect()
}

fn candidates_of(read_off: &[(Candidate, Details)]) -> Vec<Candidate> {
    read_off.iter().map(|(candidate, _)| candidate.clone()).collect()
}

/// Where causes are looked for.
struct Looked<'a> {
    /// The runs, or excerpts of them.
    runs: &'a [Run<'a>],
    /// The runs.
    whole: &'a [Run<'a>],
    /// Whether they are excerpts.
    in_parts: bool,
}

impl<'a> Looked<'a> {
    fn evidence(&self, machine: &Machine) -> Evidence<'a> {
        match self.in_parts {
            true => Evidence::in_common(self.runs, machine),
            false => Evidence::of(self.runs, machine),
        }
    }
}

/// Those of the causes found in excerpts that also hold on the whole, each with those before it.
fn held(
    base: &Machine,
    runs: &[Run],
    named: Vec<Candidate>,
    details: Vec<Details>,
) -> (Vec<Candidate>, Vec<Details>) {
    let whole = Evidence::of(runs, &with_all(base, &named));
    let state = |machine: &Machine| (whole.cost(machine), feed_error(machine, runs));
    let mut kept: (Vec<Candidate>, Vec<Details>) = (Vec::new(), Vec::new());
    let mut before = state(base);
    for (candidate, details) in named.into_iter().zip(details) {
        let mut with = kept.0.clone();
        with.push(candidate.clone());
        let after = state(&with_all(base, &with));
        let is_as_close = before.1.zip(after.1).is_none_or(|(before, after)| after <= WORSE * before);
        if after.0 + GAIN < before.0 && is_as_close {
            kept.0.push(candidate);
            kept.1.push(details);
            before = after;
        }
    }
    kept
}

/// A cause that passed the gates.
struct Found {
    candidate: Candidate,
    /// What was named before, fitted again with it.
    others: Vec<Candidate>,
    alike: Vec<String>,
    held_out: Option<HeldOut>,
    /// At most; what the likelihood says of it is known when all causes are.
    confidence: f64,
}

/// The next cause; none where nothing passes the gates.
fn next_cause(
    base: &Machine,
    current: &Machine,
    looked: &Looked,
    library: &[Hypothesis],
    named: &[Candidate],
    progress: &mut dyn FnMut(f64),
) -> Option<Found> {
    let runs = looked.runs;
    let is_named = |id: &str, variant: &str| {
        named.iter().any(|named| named.hypothesis.id == id && named.hypothesis.variant == variant)
    };
    let mut hypotheses: Vec<_> = library
        .iter()
        .filter(|hypothesis| hypothesis.trace == Trace::Time && !is_named(hypothesis.id, &hypothesis.variant))
        .filter(|hypothesis| !named.iter().any(|named| hypothesis.is_fitted_beside(&named.hypothesis)))
        .cloned()
        .collect();
    let coarse = looked.evidence(current);
    let is_open = library.iter().any(|hypothesis| hypothesis.id == "feed_override");
    let whole = if looked.in_parts { &Evidence::of(looked.whole, current) } else { &coarse };
    hypotheses.extend(places::hypotheses(current, looked.whole, whole, is_open));
    let count = hypotheses.len() as f64;
    let mut candidates: Vec<Candidate> = Vec::new();
    for (at, hypothesis) in hypotheses.iter().enumerate() {
        progress(0.7 * at as f64 / count);
        candidates.extend(coarse.screened(current, hypothesis));
    }
    candidates.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    candidates.truncate(3 * REFINED);
    let best = candidates.first()?;
    // At the noise that the best leaves the good ones are told apart.
    let fine = looked.evidence(&best.hypothesis.machine(current, &best.values));
    let mut screened: Vec<Candidate> = candidates
        .iter()
        .map(|candidate| {
            let cost = fine.cost(&candidate.hypothesis.machine(current, &candidate.values));
            Candidate { cost, ..candidate.clone() }
        })
        .collect();
    screened.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    screened.truncate(REFINED);
    let mut refined: Vec<(Candidate, Vec<Candidate>)> =
        screened.iter().map(|candidate| fine.refined(base, candidate, named)).collect();
    refined.retain(|(candidate, _)| !is_as_believed(candidate, base) && !is_at_bound(candidate));
    // Times between marks can be had by speeds that nobody saw.
    let speeds = feed_error(current, runs);
    refined.retain(|(candidate, others)| {
        let mut all = others.clone();
        all.push(candidate.clone());
        speeds
            .zip(feed_error(&with_all(base, &all), runs))
            .is_none_or(|(before, after)| after <= WORSE * before)
    });
    // Of two that are as good, the one with fewer parameters; the same price as below.
    let priced = |candidate: &Candidate| candidate.cost + gates::price(runs, candidate.values.len());
    refined.sort_by(|a, b| priced(&a.0).total_cmp(&priced(&b.0)));
    progress(0.9);
    let (candidate, others) = refined.first()?.clone();
    // The noise once more, that of the refined one; else its last digits are those of the first guess.
    let mut all = others.clone();
    all.push(candidate.clone());
    let last = looked.evidence(&with_all(base, &all));
    let (candidate, others) = last.refined(base, &candidate, &others);
    let without = last.cost(current);
    let gain = without - candidate.cost;
    let price = gates::price(runs, candidate.values.len());
    if gain <= price {
        return None;
    }
    let mut all = others.clone();
    all.push(candidate.clone());
    let with = with_all(base, &all);
    let (seconds, _) = regions::acts_on(current, &with, runs);
    let moved = regions::moved(current, &with, runs);
    let whole: f64 = runs.iter().map(|run| run.plan(current).cycle_time()).sum();
    let explained = regions::acts_on(base, current, runs).0.abs();
    if seconds.abs().max(NETTED * moved) < LEAST.max(SIZE * whole).max(BESIDE * explained) {
        return None;
    }
    if gain < LARGE * candidate.cost && !gates::stays_in_place(&last, current, &with) {
        return None;
    }
    let held_out = gates::held_out(&last, current, &with);
    if held_out.as_ref().is_some_and(|held_out| !held_out.holds()) {
        return None;
    }
    // The last digits of the others are those of the first guess, too.
    let dispersion = last.dispersion(&with);
    let fine_cost = refined[0].0.cost;
    let near = (SAME * dispersion).max(NEAR * fine_cost);
    let alike = refined
        .iter()
        .skip(1)
        .filter(|(other, _)| other.hypothesis.id != candidate.hypothesis.id && other.cost < fine_cost + near)
        .map(|(other, others)| last.refined(base, other, others).0)
        .filter(|other| other.cost - candidate.cost < SAME * dispersion)
        .map(|other| other.hypothesis.id.to_string())
        .collect::<std::collections::BTreeSet<String>>();
    let alike: Vec<String> = alike.into_iter().collect();
    let most = held_out.as_ref().map_or(1.0, HeldOut::share) / (1.0 + alike.len() as f64);
    let is_sure = UNSURE <= most * odds(gain / dispersion, price);
    is_sure.then_some(Found { candidate, others, alike, held_out, confidence: most })
}

/// Whether a setting is found at the value that the machine file has, within what a calibration is sure of.
fn is_as_believed(candidate: &Candidate, machine: &Machine) -> bool {
    let hypothesis = &candidate.hypothesis;
    let [freed] = &hypothesis.freed[..] else { return false };
    // Filters of other lengths but the same delay are seen by the sum of their squares, which is that of a constant
    // longer by the square of the spread, as a part of it.
    if hypothesis.id == "unequal_filters" && candidate.values[0].powi(2) < BELIEVED {
        return true;
    }
    let believed = freed.of(machine).filter(|value| 0.0 < *value);
    !SWITCHES.contains(&hypothesis.id)
        && hypothesis.is_continuous
        && believed.is_some_and(|believed| (candidate.values[0] / believed).ln().abs() < BELIEVED)
}

/// Root mean square of recorded less simulated feedrates, mm/s; none where none are known.
fn feed_error(machine: &Machine, runs: &[Run]) -> Option<f64> {
    let squares: Vec<f64> =
        compared(machine, runs).iter().filter_map(|run| run.feed).map(|feed| feed.rms * feed.rms).collect();
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

/// Whether a value went as far as it may go: what it is to explain is something else.
fn is_at_bound(candidate: &Candidate) -> bool {
    let of = candidate.hypothesis.freed.iter().zip(&candidate.values);
    candidate.hypothesis.is_continuous
        && of.filter(|(freed, _)| freed.scale == Scale::Ratio).any(|(freed, value)| {
            let (low, high) = freed.bounds;
            *value <= low * (1.0 + BELIEVED) || high * (1.0 - BELIEVED) <= *value
        })
}

/// What was named for a cause.
type Details = (Vec<String>, Option<HeldOut>, f64);

/// Takes back every cause that the others make unnecessary.
fn without_unnecessary(
    base: &Machine,
    looked: &Looked,
    mut named: Vec<Candidate>,
    mut details: Vec<Details>,
) -> (Vec<Candidate>, Vec<Details>) {
    while 1 < named.len() {
        let all = looked.evidence(&with_all(base, &named));
        let cost = all.cost(&with_all(base, &named));
        let cheapest = (0..named.len())
            .map(|at| {
                let mut others = named.clone();
                let dropped = others.remove(at);
                let others = match others.split_last() {
                    Some((last, rest)) => {
                        let (last, mut rest) = all.refined(base, last, rest);
                        rest.push(last);
                        rest
                    }
                    None => others,
                };
                let _ = dropped;
                (at, all.cost(&with_all(base, &others)) - cost, others)
            })
            .min_by(|a, b| a.1.total_cmp(&b.1));
        match cheapest {
            Some((at, rise, others)) if rise < GAIN => {
                named = others;
                details.remove(at);
            }
            _ => break,
        }
    }
    (named, details)
}

/// Ids of the contract that these runs do not excite.
fn not_excited(library: &[Hypothesis]) -> Vec<String> {
    const ALL: [&str; 21] = [
        "axis_acceleration_limit",
        "path_acceleration_limit",
        "axis_velocity_limit",
        "jerk_limit",
        "centripetal_acceleration_limit",
        "filter_time_constant",
        "filter_order",
        "unequal_filters",
        "corner_tolerance",
        "junction_rule",
        "exact_stop",
        "in_position_wait",
        "block_processing_time",
        "look_ahead",
        "path_smoothing",
        "feed_override",
        "rapid_override",
        "unmodelled_wait",
        "servo_lag",
        "backlash",
        "structural_vibration",
    ];
    let offered = |id: &&&str| library.iter().any(|hypothesis| hypothesis.id == **id);
    ALL.iter().filter(|id| !offered(id)).map(|id| id.to_string()).collect()
}
