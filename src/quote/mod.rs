//! Feed plan → quote: the cycle time by kind, operation and tool, and its price.
//!
//! There is a breakdown of the whole program, of each operation and of each tool; see [`Breakdown`].

mod breakdown;
mod job;
mod time_losses;
mod offer;
mod time_range;
mod revision;
mod shares;
mod terms;
mod trust;

pub use breakdown::{Breakdown, FunctionBreakdown, breakdown};
pub use job::{BatchTimes, Fixture, JobOperation, MissingTerm, PlannedOperation, QuotedJob};
pub use offer::{Addend, AddendKind, Offer, Uncertainty, offer};
pub use revision::{RevisedLines, Revision, Revisions, revisions};
pub use shares::{OperationShare, TimeShare, ToolShare, programmed_time};
pub use terms::{MAX_MARGIN_OF_PRICE, MarginOf, QUANTITY_BOUNDS, Rounding, TERMS, Term, TermAccess, Terms};
pub use time_losses::{LossReason, LostTimes, MAX_LISTED_LOSSES, StopReason, TimeLoss, lost_times};
pub use time_range::{
    NORMAL_QUANTILE_95, TimeRange, UNKNOWN_LAW_ERROR_RATIO, UnshownFeature, error_beyond_calibration,
    features_of, range,
};

pub use trust::{ASSUMED_TRAVEL_MM, CauseInDoubt, MIN_FEEDRATE_MM_S, Trust, trust};

use crate::machine::Machine;
use crate::simulation::contour::{ContourErrors, ErrorRegion, regions_beyond};
use crate::simulation::feed::{FeedPlan, ToleranceRange, Tolerances};
use crate::simulation::toolpath::Toolpath;
use crate::units::{MINUTES_PER_HOUR, SECONDS_PER_MINUTE};

/// The quote of one program at one tolerance.
#[derive(Clone, Debug, PartialEq)]
pub struct Quote {
    /// Contour tolerance, mm; the prevailing one if the program sets several.
    pub tolerance: f64,
    /// The ranges of the tolerances that the program sets; empty if one tolerance replaces them.
    pub tolerance_ranges: Vec<ToleranceRange>,
    /// Cycle time, s.
    pub cycle_time: f64,
    /// Cycle time by kind.
    pub breakdown: Breakdown,
    /// Shares of the operations in the order they are run; they add up to the whole.
    pub operations: Vec<OperationShare>,
    /// Shares of the tools in the order of first use; they add up to the whole.
    pub tools: Vec<ToolShare>,
    /// Time lost against length over feedrate, with the places that lose most.
    pub lost: LostTimes,
    /// Largest distance between the filtered path and the programmed one, mm.
    pub max_contour_error: f64,
    /// Regions with a contour error more than a hundredth above the tolerance.
    pub beyond_tolerance: Vec<ErrorRegion>,
    /// Price of one part without set-up, in the currency of the hourly rate.
    pub price: f64,
    /// Range of the motion time on a calibrated machine; `None` on other machines.
    pub range: Option<TimeRange>,
    /// Doubts about the cycle time.
    pub trust: Trust,
}

/// Multiple of the tolerance up to which a contour error counts as within it: an isolated corner uses the
/// whole tolerance, to within rounding.
const MAX_TOLERANCE_RATIO: f64 = 1.01;

/// Returns the quote of a plan.
///
/// # Examples
///
/// ```
/// use truefeed::machine::Machine;
/// use truefeed::quote::{programmed_time, quote};
/// use truefeed::simulation::{gcode::read, simulate, interpreter::trace};
///
/// let mut machine = Machine::default();
/// machine.rates.hourly = 90.0;
/// let toolpath = trace(&read(b"G21 G90 G1 X40 F3000\nY40\nX0"), &machine);
/// let (plan, errors) = simulate::within(&toolpath, &machine, 0.010, &mut |_| {});
/// let quote = quote(&toolpath, &machine, &plan, 0.010, &errors);
/// assert!(programmed_time(&toolpath, &machine) < quote.cycle_time);
/// assert_eq!(quote.price, 90.0 * quote.cycle_time / 3600.0);
/// assert_eq!(quote.trust.seconds_in_doubt(), 0.0);
/// ```
pub fn quote(
    toolpath: &Toolpath,
    machine: &Machine,
    plan: &FeedPlan,
    tolerances: impl Into<Tolerances>,
    errors: &ContourErrors,
) -> Quote {
    let tolerances = tolerances.into();
    let held = tolerances.ranges(toolpath, machine);
    let bounds = tolerances.bounds(toolpath, machine);
    let cycle_time = plan.cycle_time();
    let operations = shares::operation_shares(toolpath, machine, plan);
    Quote {
        tolerance: tolerances.prevailing(&held, machine),
        tolerance_ranges: held,
        cycle_time,
        breakdown: breakdown(toolpath, machine, plan),
        tools: shares::tool_shares(&operations),
        operations,
        lost: lost_times(toolpath, machine, plan, tolerances),
        max_contour_error: errors.largest(),
        beyond_tolerance: regions_beyond(toolpath, errors, bounds, MAX_TOLERANCE_RATIO),
        price: price(cycle_time, machine),
        range: range(toolpath, machine, plan),
        trust: trust(toolpath, machine, plan),
    }
}

/// Returns the price of one part without set-up, in the currency of the hourly rate; `cycle_time` in s.
pub fn price(cycle_time: f64, machine: &Machine) -> f64 {
    machine.rates.hourly * cycle_time / (MINUTES_PER_HOUR * SECONDS_PER_MINUTE)
}
