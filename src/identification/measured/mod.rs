//! Aligned runs → [`Measured`]: the laws of a machine as its recordings show them, without a model of its control.
//!
//! An event is one place at which a law shows, read off the recorded motion in steady conditions:
//!
//! | law | over | value | steady where |
//! |---|---|---|---|
//! | corner feedrate | turn of the path | lowest feedrate | no stop, one programmed feedrate, two windows on either side |
//! | arc feedrate | radius | feedrate | three windows one after another agree, below the programmed feedrate |
//! | ramp time | speed step | time from 10 % to 90 % of it | from or to a full stop, and a plateau at the other end |
//! | rapid time | length | time | a full stop or a reversal at both ends |
//! | block time | length | time | in a chain of blocks that are all short and turn little |
//! | wait | programmed wait | time at the place | one word alone at the place |
//!
//! A feedrate is the mean over a window W (s), as long as the noise σ (mm) of a position requires. At a
//! corner, where the feedrate ramps, it is extrapolated from the two windows before the corner (and from the
//! two behind):
//!
//! ```text
//! v(t) = |p(t + W/2) − p(t − W/2)| / W,   W ≥ √2 σ / (0.02 F),   v_corner = v₁ + (v₁ − v₂)/(t₁ − t₂) · (t_corner − t₁)
//! ```
//!
//! On a blend the tool is faster than the feedrate at which its ramps would meet: v_corner is at least the
//! mean over the window across the corner, less W |v'| / 4, which the ramps add to that mean.
//!
//! F is the programmed feedrate, and ρ the ratio of the run's plateaus to it, which contains an override over
//! the whole run. If a dip by an override, a hold or a neighbouring stop keeps a block below ρ F, its corners
//! count among corners of short blocks, whose law is a lower bound. A corner, an arc or a block passed at ρ F
//! does not show its law.
//!
//! Events of similar abscissa form a point: mean, standard deviation, count. The curve through the points is
//! the nearest monotone one (`curve`). The same code measures the simulation of a machine on its motion,
//! sampled like the recording (`simulated`). The error of the machine's law is the mean and spread of the
//! differences over the events in both.
//!
//! Limits: a polled log of lines and feedrates shows only waits. Corners of rapid moves are not read.

mod blocks;
mod corners;
mod run_course;
mod curve;
mod events;
mod program_left_out;
mod ramps;
mod simulated;
mod waits;

pub use corners::centripetal_accelerations;
pub use curve::{CurveLevel, LawPoint};
pub use events::{Absence, LawEvent, LawKind};
pub use program_left_out::calibrated_on;

use std::collections::BTreeMap;

use crate::identification::fit::Run;
use crate::identification::measured::curve::{monotone, points};
use crate::identification::measured::events::LawEvents;
use crate::identification::measured::run_course::RunCourse;
use crate::identification::measured::simulated::simulated;
use crate::machine::Machine;

/// One law as measured.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredLaw {
    /// Law.
    pub kind: LawKind,
    /// An axis, long blocks, or a word; empty if there is only one.
    pub variant: String,
    /// Groups of events, by ascending abscissa, core units.
    pub points: Vec<LawPoint>,
    /// The monotone curve at the points.
    pub curve: Vec<CurveLevel>,
    /// Points of the simulated machine at the same events; empty if none was simulated.
    pub simulated: Vec<LawPoint>,
    /// Simulated less measured value, event by event; `None` if no event is in both.
    pub error: Option<LawError>,
}

/// The error of a machine's law, core units of the value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawError {
    /// Mean of simulated less measured values.
    pub mean: f64,
    /// Standard deviation of simulated less measured values.
    pub spread: f64,
    /// Number of events.
    pub count: usize,
}

/// The laws of a machine as its recordings show them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Measured laws.
    pub laws: Vec<MeasuredLaw>,
    /// Laws that were not measured, with the reason.
    pub absent: Vec<(LawKind, Absence)>,
}

/// Returns the laws that runs show, with those of the simulated machine.
pub fn measure(machine: &Machine, runs: &[Run]) -> Measured {
    let mut found: BTreeMap<LawKind, LawEvents> = BTreeMap::new();
    // The simulated values at each place, including those limited by the programmed feedrate.
    let mut of_machine: BTreeMap<LawKind, BTreeMap<(usize, usize), f64>> = BTreeMap::new();
    for (index, run) in runs.iter().enumerate() {
        for (kind, own) in events(run) {
            found.entry(kind).or_default().add(index, own);
        }
        let alignment = simulated(machine, run);
        for (kind, own) in events(&Run { alignment: &alignment, ..run.clone() }) {
            let values = own.events.iter().map(|event| ((index, event.place), event.value));
            of_machine.entry(kind).or_default().extend(values);
        }
    }
    let mut by_variant: BTreeMap<(LawKind, &str), Vec<&LawEvent>> = BTreeMap::new();
    for (kind, own) in &found {
        for event in own.events.iter().filter(|event| !event.is_at_feed) {
            by_variant.entry((*kind, &event.variant)).or_default().push(event);
        }
    }
    let none = BTreeMap::new();
    let laws = by_variant
        .iter()
        .map(|((kind, variant), events)| law(*kind, variant, events, of_machine.get(kind).unwrap_or(&none)));
    let laws: Vec<MeasuredLaw> = laws.collect();
    let is_absent = |kind: &LawKind| !laws.iter().any(|law| law.kind == *kind);
    let absent = LawKind::ALL.into_iter().filter(is_absent);
    let reason = |kind: LawKind| (kind, found.get(&kind).map_or(Absence::NotRecorded, LawEvents::absence));
    Measured { absent: absent.map(reason).collect(), laws }
}

/// Returns the events of one run by law, for the laws that its recording can show.
fn events(run: &Run) -> Vec<(LawKind, LawEvents)> {
    let mut all = vec![(LawKind::Wait, waits::waits(run))];
    if let Some(course) = RunCourse::of(run) {
        all.extend([
            (LawKind::Corner, corners::corners(&course)),
            (LawKind::Arc, corners::arcs(&course)),
            (LawKind::Ramp, ramps::ramps(&course)),
            (LawKind::Rapid, ramps::rapids(&course)),
            (LawKind::Block, blocks::blocks(&course)),
        ]);
    }
    all
}

fn law(
    kind: LawKind,
    variant: &str,
    recorded: &[&LawEvent],
    simulated: &BTreeMap<(usize, usize), f64>,
) -> MeasuredLaw {
    let points_of = |pairs: Vec<(f64, f64)>| points(pairs, kind.apart());
    let own = |event: &LawEvent| simulated.get(&(event.run, event.place)).copied();
    let both = || recorded.iter().filter_map(|event| Some((event.over, event.value, own(event)?)));
    let errors = both().map(|(_, value, simulated)| (0.0, simulated - value));
    let error = points(errors.collect(), (1.0, 0.0));
    let measured = points_of(recorded.iter().map(|event| (event.over, event.value)).collect());
    MeasuredLaw {
        kind,
        variant: variant.to_string(),
        curve: monotone(&measured, kind.is_rising()),
        points: measured,
        simulated: points_of(both().map(|(over, _, simulated)| (over, simulated)).collect()),
        error: error.first().map(|one| LawError { mean: one.value, spread: one.spread, count: one.count }),
    }
}
