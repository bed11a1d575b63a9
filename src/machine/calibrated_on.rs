//! The programs and errors of a machine's calibration.

/// The least and the largest of some values; `None` if there were none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extent(pub Option<(f64, f64)>);

impl Extent {
    /// Returns the extent of some values.
    pub fn of(values: &[f64]) -> Extent {
        values.iter().fold(Extent::default(), |extent, value| extent.with(*value))
    }

    /// Returns the extent with one more value.
    pub fn with(self, value: f64) -> Extent {
        let (least, largest) = self.0.unwrap_or((value, value));
        Extent(Some((least.min(value), largest.max(value))))
    }

    /// Returns `true` if no value is as large as `value`.
    pub fn is_below(self, value: f64) -> bool {
        self.0.is_none_or(|(_, largest)| largest < value)
    }

    /// Returns `true` if no value is as small as `value`.
    pub fn is_above(self, value: f64) -> bool {
        self.0.is_none_or(|(least, _)| value < least)
    }
}

/// Largest misfit of ramps by the law of the machine. Accelerations that are off by a twentieth have 0.05, the nearest
/// trapezoids to ramps of constant jerk 0.08 and more.
pub const MAX_RAMP_MISFIT: f64 = 0.075;

/// The features of the programs that a machine was calibrated on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CalibratedOn {
    /// Half of the range that contains the motion time of nine in ten other programs within these features,
    /// as a part of that time; `None` if unknown.
    pub range: Option<f64>,
    /// Misfit of the shape of ramps in the runs, the relative error of accelerations within ramps; `None` if unknown.
    pub ramp_misfit: Option<f64>,
    /// Turns of corners between feed moves, rad.
    pub turns: Extent,
    /// Radii of arcs, mm.
    pub radii: Extent,
    /// Lengths of straight feed blocks, mm.
    pub blocks: Extent,
    /// Programmed feedrates, mm/s.
    pub feedrates: Extent,
    /// Longest travel of each axis in one rapid, mm; `None` if there was no rapid.
    pub rapids: Option<[f64; 3]>,
    /// Highest velocity of each axis in the runs, mm/s; `None` if unknown.
    pub velocities: Option<[f64; 3]>,
    /// Travel of each program along the path and in each axis, mm, by which a program is recognised.
    pub travels: Vec<[f64; 4]>,
    /// `true` for each of the axes X, Y, Z whose acceleration the runs do not determine: it was taken from
    /// other axes, or is known only together with the acceleration of other axes.
    pub assumed_accelerations: [bool; 3],
    /// Accelerations that X, Y and Z have at least, mm/s², 0 for an axis whose acceleration was not assumed: with lower
    /// ones the runs would have been slower. `None` if no acceleration was assumed.
    pub least_accelerations: Option<[f64; 3]>,
    /// Jerks that X, Y and Z have at least on ramps, mm/s³, 0 for an axis whose jerk was not assumed; with lower ones the runs
    /// would have been slower. The jerk of such an axis was taken from other axes, or is the least one. `None` if no jerk was
    /// assumed.
    pub least_jerks: Option<[f64; 3]>,
    /// Relative standard deviations of the accelerations of X, Y and Z: 0 for an assumed one, `None` if all are unknown. If the
    /// machine limits the acceleration along the path, an axis without a limit has the deviation of that.
    pub acceleration_deviations: Option<[f64; 3]>,
    /// Largest override for which the control may plan its corners as far as the runs show; `None` if they determine that
    /// override, or if the control does not plan corners for one.
    pub largest_override: Option<f64>,
    /// [`CHORD_ERROR_RATIOS`](crate::machine::CHORD_ERROR_RATIOS) at which the runs would have been the same; empty if the runs
    /// determine the chords, or if arcs have none.
    pub other_chord_ratios: Vec<f64>,
    /// The only programmed feedrate that the rapids of the runs hold, mm/s, which may be their rate by coincidence; `None` if they
    /// hold several or none.
    pub only_rapid_feedrate: Option<f64>,
    /// `true` for each of the axes X, Y, Z that the runs do not show at its full rapid feedrate.
    pub assumed_rapids: [bool; 3],
    /// M-words that stop the motion in the programs, 3 and 5 for any word that starts or stops the spindle, and 30 for
    /// the end; `None` if unknown. The time of any other word was assumed.
    pub m_codes: Option<Vec<u32>>,
}

impl CalibratedOn {
    /// Returns the misfit of the shape of ramps if the machine follows a law that its file does not have; `None` otherwise.
    pub fn misfit_of_unknown_law(&self) -> Option<f64> {
        self.ramp_misfit.filter(|misfit| MAX_RAMP_MISFIT < *misfit)
    }
}
