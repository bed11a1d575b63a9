//! Feed plan → profile.

/// A profile as columns of equal length, straight lines between the rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// Time since the start, s.
    pub time: Vec<f64>,
    /// Distance along the programmed path, mm.
    pub distance: Vec<f64>,
    /// Feedrate of the tool, mm/s.
    pub feedrate: Vec<f64>,
    /// Position of the tool, mm, one column an axis.
    pub position: [Vec<f64>; 3],
    /// Line of the program being run.
    pub line: Vec<u32>,
}
