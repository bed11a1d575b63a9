//! Feed plan → quote: where the time goes, and what it costs.
//!
//! The breakdown adds up to the cycle time: each pulse counts for the motion of its segment, the
//! filter delay of a stretch half for its first and half for its last segment, and each wait for
//! its cause.

use crate::machine::Machine;
use crate::simulation::contour::{ContourErrors, Region, regions_beyond};
use crate::simulation::feed::{FeedPlan, Held, Phase, Tolerances, running_sum};
use crate::simulation::toolpath::{Motion, StopCause, Toolpath};
use crate::units::{MINUTES_PER_HOUR, SECONDS_PER_MINUTE};

/// Where the cycle time goes, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Breakdown {
    /// Feed moves.
    pub cutting: f64,
    /// Rapid moves.
    pub rapid: f64,
    /// Programmed dwells.
    pub dwell: f64,
    /// Tool changes.
    pub tool_change: f64,
    /// Other M-words.
    pub other: f64,
}

impl Breakdown {
    /// All of it, s.
    pub fn total(&self) -> f64 {
        self.cutting + self.rapid + self.dwell + self.tool_change + self.other
    }
}

/// Where the cycle time of a plan goes.
pub fn breakdown(toolpath: &Toolpath, plan: &FeedPlan) -> Breakdown {
    let mut breakdown = Breakdown::default();
    let is_rapid = |segment: usize| toolpath.segments[segment].motion == Motion::Rapid;
    let sum = |values: &mut dyn Iterator<Item = f64>| running_sum(values).last().unwrap_or(0.0);
    let of_pulses = |rapid: bool| {
        let pulses = plan.pulses.iter().filter(move |pulse| is_rapid(pulse.segment as usize) == rapid);
        pulses.map(|pulse| pulse.duration)
    };
    breakdown.cutting = sum(&mut of_pulses(false));
    breakdown.rapid = sum(&mut of_pulses(true));
    for phase in &plan.phases {
        match phase {
            Phase::Motion(stretch) => {
                for end in [stretch.segments.start, stretch.segments.end - 1] {
                    let half = plan.filters[stretch.filter].half_delay();
                    *(if is_rapid(end) { &mut breakdown.rapid } else { &mut breakdown.cutting }) += half;
                }
            }
            Phase::Wait(wait) => {
                let part = match wait.cause {
                    StopCause::Dwell { .. } => &mut breakdown.dwell,
                    StopCause::ToolChange { .. } => &mut breakdown.tool_change,
                    StopCause::MCode { .. } => &mut breakdown.other,
                };
                *part += wait.duration;
            }
        }
    }
    breakdown
}

/// What CAM would say, s: length over programmed feedrate, rapids at the rapid feedrate, dwells;
/// no ramps, no corners, no changes, no overrides.
pub fn programmed_time(toolpath: &Toolpath, machine: &Machine) -> f64 {
    let moves = toolpath.segments.iter().map(|segment| match segment.motion {
        Motion::Rapid => segment.length / machine.rapid.feedrate,
        Motion::Feed { feedrate } => segment.length / feedrate,
    });
    let dwells = toolpath.stops.iter().map(|stop| match stop.cause {
        StopCause::Dwell { seconds } => seconds,
        _ => 0.0,
    });
    running_sum(moves.chain(dwells)).last().unwrap_or(0.0)
}

/// What is said about one program at one tolerance.
#[derive(Clone, Debug, PartialEq)]
pub struct Quote {
    /// Contour tolerance, mm; where the program sets several the one that prevails.
    pub tolerance: f64,
    /// Where each of the program's own tolerances holds; empty where one is laid over all of it.
    pub held: Vec<Held>,
    /// Cycle time, s.
    pub cycle_time: f64,
    /// Where it goes.
    pub breakdown: Breakdown,
    /// Largest distance of the filtered path from the programmed one, mm.
    pub max_contour_error: f64,
    /// Where the contour error is above the tolerance by more than a hundredth of it.
    pub beyond_tolerance: Vec<Region>,
    /// Price of one part without set-up, in the currency of the hourly rate.
    pub price: f64,
}

/// An isolated corner takes the whole tolerance; what is above it by rounding is not worth a word.
const ABOVE_TOLERANCE: f64 = 1.01;

/// The quote of a plan.
pub fn quote(
    toolpath: &Toolpath,
    machine: &Machine,
    plan: &FeedPlan,
    tolerances: impl Into<Tolerances>,
    errors: &ContourErrors,
) -> Quote {
    let tolerances = tolerances.into();
    let held = tolerances.held(toolpath, machine);
    let bounds = tolerances.bounds(toolpath, machine);
    let cycle_time = plan.cycle_time();
    Quote {
        tolerance: tolerances.prevailing(&held, machine),
        held,
        cycle_time,
        breakdown: breakdown(toolpath, plan),
        max_contour_error: errors.largest(),
        beyond_tolerance: regions_beyond(toolpath, errors, bounds, ABOVE_TOLERANCE),
        price: price(cycle_time, machine),
    }
}

/// Price of one part without set-up, in the currency of the hourly rate.
pub fn price(cycle_time: f64, machine: &Machine) -> f64 {
    machine.rates.hourly * cycle_time / (MINUTES_PER_HOUR * SECONDS_PER_MINUTE)
}
