//! Feed plan → quote: where the time goes, and what it costs.
//!
//! The breakdown is of the whole program, of each operation and of each tool; see [`Breakdown`].

mod breakdown;
mod places;
mod offer;
mod shares;
mod terms;
mod trust;

pub use breakdown::{Breakdown, Functions, breakdown};
pub use offer::{Addend, Item, Offer, Uncertainty, offer};
pub use places::{Lost, LostAt, MOST_PLACES, Reason, Standing, lost};
pub use shares::{OperationShare, Share, ToolShare, programmed_time};
pub use terms::{LARGEST_MARGIN_OF_PRICE, MarginOf, QUANTITY, Rounding, TERMS, Term, TermAccess, Terms};

pub use trust::{ASSUMED_TRAVEL, InDoubt, MIN_FEEDRATE, Trust, trust};

use crate::machine::Machine;
use crate::simulation::contour::{ContourErrors, Region, regions_beyond};
use crate::simulation::feed::{FeedPlan, Held, Tolerances};
use crate::simulation::toolpath::Toolpath;
use crate::units::{MINUTES_PER_HOUR, SECONDS_PER_MINUTE};

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
    /// Where it goes by operation, in the order they are run; together the whole.
    pub operations: Vec<OperationShare>,
    /// Where it goes by tool, in the order of first use; together the whole.
    pub tools: Vec<ToolShare>,
    /// What is lost against length over feedrate, with the places that cost most.
    pub lost: Lost,
    /// Largest distance of the filtered path from the programmed one, mm.
    pub max_contour_error: f64,
    /// Where the contour error is above the tolerance by more than a hundredth of it.
    pub beyond_tolerance: Vec<Region>,
    /// Price of one part without set-up, in the currency of the hourly rate.
    pub price: f64,
    /// How far the cycle time can be trusted.
    pub trust: Trust,
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
    let operations = shares::of_operations(toolpath, machine, plan);
    Quote {
        tolerance: tolerances.prevailing(&held, machine),
        held,
        cycle_time,
        breakdown: breakdown(toolpath, machine, plan),
        tools: shares::of_tools(&operations),
        operations,
        lost: lost(toolpath, machine, plan, tolerances),
        max_contour_error: errors.largest(),
        beyond_tolerance: regions_beyond(toolpath, errors, bounds, ABOVE_TOLERANCE),
        price: price(cycle_time, machine),
        trust: trust(toolpath, machine, plan),
    }
}

/// Price of one part without set-up, in the currency of the hourly rate.
pub fn price(cycle_time: f64, machine: &Machine) -> f64 {
    machine.rates.hourly * cycle_time / (MINUTES_PER_HOUR * SECONDS_PER_MINUTE)
}
