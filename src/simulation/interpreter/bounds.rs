//! The bounds within which words are taken at their word, and within which a program may ask for work.

/// Feedrate of feed moves before the first F, mm/s: 1000 mm/min.
pub(super) const ASSUMED_FEEDRATE: f64 = 1000.0 / 60.0;

/// The feedrates that are taken at their word, mm/s.
pub(super) const FEEDRATES_MM_S: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// Coordinates and radii beyond this are slips of the pen, mm.
pub(super) const MAX_COORDINATE_MM: f64 = 1e7;

/// The longest dwell that is taken at its word, s: some 11 days.
pub(super) const MAX_DWELL_S: f64 = 1e6;

/// The most blocks that are run beyond once each, where no other number is asked for.
pub(super) const MAX_REPEATED: usize = 2_000_000;

/// The most calls within calls.
pub(super) const MAX_CALL_DEPTH: usize = 100;

/// The most often a loop or call is repeated by a count.
pub(super) const MAX_COUNT: f64 = 1e6;

/// The most turns of a loop whose condition goes by a parameter of the call that nothing was assigned to.
pub(super) const MAX_TURNS_BY_MISSING: u32 = 1_000;
