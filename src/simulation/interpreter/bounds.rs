//! Bounds of values that count as meant, and of the work that a program may cause.

/// Feedrate of feed moves before the first F, mm/s: 1000 mm/min.
pub(super) const ASSUMED_FEEDRATE: f64 = 1000.0 / 60.0;

/// The feedrates that count as meant, mm/s.
pub(super) const FEEDRATES_MM_S: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// The factors of scaling that count as meant.
pub(super) const SCALE_FACTORS: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// Greatest number of a tool.
pub(super) const MAX_TOOL_NUMBER: f64 = 99_999_999.0;

/// Most holes of one pattern.
pub(super) const MAX_HOLES: f64 = 10_000.0;

/// Larger coordinates and radii are typing errors, mm.
pub(super) const MAX_COORDINATE_MM: f64 = 1e7;

/// Longest dwell that counts as meant, s: about 11 days.
pub(super) const MAX_DWELL_S: f64 = 1e6;

/// Most blocks that are run beyond once each, unless another number is chosen.
pub(super) const MAX_REPEATED: usize = 2_000_000;

/// Most nested calls.
pub(super) const MAX_CALL_DEPTH: usize = 100;

/// Most repetitions of a loop or call by a count.
pub(super) const MAX_COUNT: f64 = 1e6;

/// Most iterations of a loop whose condition depends on a parameter that was never assigned.
pub(super) const MAX_ITERATIONS_BY_MISSING: u32 = 1_000;
