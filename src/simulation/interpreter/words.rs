//! Meaning of G words: one row a word, with its modal group.
//!
//! Source: NIST RS274/NGC, Table 4; group 9 (cycles) separate from group 1 (motion) as on Fanuc controls, so that
//! a safe-start line may have both G0 and G80.

use crate::simulation::gcode::Word;
use crate::simulation::interpreter::compensation::{CompensationWord, Side};
use crate::simulation::interpreter::feed_mode::FeedMode;
use crate::simulation::interpreter::frame::Kind;
use crate::simulation::interpreter::path_mode::PathWord;
use crate::simulation::interpreter::siemens::SiemensWord;
use crate::simulation::interpreter::spline::Spline;
use crate::simulation::interpreter::vendor_codes::{VendorCode, VendorModal};
use crate::simulation::toolpath::plane::{Plane, Turn};

/// The motion of axis words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// G0.
    Rapid,
    /// G1.
    Straight,
    /// G2 and G3.
    Arc(Turn),
    /// G5, G5.1, G5.2 and G6.2 of LinuxCNC.
    Spline(Spline),
}

/// A word that uses the axis words of its block for something else than a move by the motion in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Special {
    /// G4.
    Dwell,
    /// G10.
    DataSetting,
    /// G28 and G30.
    Reference,
    /// G52.
    LocalShift,
    /// G53.
    MachineCoordinates,
    /// G92.
    SetPosition,
    /// G92.1, which removes the shift.
    ForgetShift,
    /// G92.2, which suspends the shift until G92.3.
    SuspendShift,
    /// G92.3.
    RestoreShift,
    /// G68.
    Rotate,
    /// G51.
    Scale,
    /// G51.1.
    Mirror,
    /// G50.1.
    Unmirror,
    /// G43.1 with axis words.
    ToolOffset,
    /// G31 and G38.2 to G38.5.
    Probe,
    /// G33, and G33.1 with the way back.
    Thread { is_tapping: bool },
    /// G5.3.
    NurbsEnd,
    /// A word of one family of controls.
    Vendor(VendorCode),
}

/// The meaning of a G word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Meaning {
    Motion(Mode),
    Plane(Plane),
    /// `true` for lengths in inches, `false` in millimetres.
    Inch(bool),
    /// `true` if axis words are increments.
    Incremental(bool),
    /// `true` if I, J and K are increments from the start of the arc.
    IncrementalCenter(bool),
    FeedMode(FeedMode),
    Path(PathWord),
    /// G9.
    ExactStopHere,
    Special(Special),
    /// A canned cycle.
    Cycle,
    /// G80.
    CycleEnd,
    /// `true` for cycles that end at R (G99), `false` at the initial height (G98).
    ReturnToReference(bool),
    WorkOffset,
    /// G43 and its like, and G49.
    ToolLength,
    /// G69 or G50: the end of an operation on coordinates.
    EndOf(Kind),
    /// `true` for G16, `false` for G15.
    Polar(bool),
    /// Tool centre point control by its name.
    TipControl(&'static str),
    Compensation(CompensationWord),
    SurfaceSpeed,
    /// A change of coordinates by its name.
    Transformation(&'static str),
    /// A change of coordinates by its name, whose block has axis words for it.
    TransformationAbout(&'static str),
    /// A word of SINUMERIK controls.
    Siemens(SiemensWord),
    /// A word of one family of controls.
    Vendor(VendorModal),
    /// A word that changes neither path nor time.
    Neutral,
    /// A word that changes neither path nor time, whose block has axis words for it.
    NeutralAbout,
}

/// The number of no group: such words may be combined. Modal groups have the numbers of RS274/NGC and Fanuc.
pub(super) const NO_GROUP: usize = 31;

/// Returns ten times the number of a G word, or `None` if no G word has such a number.
pub(super) fn tenths(word: &Word) -> Option<u16> {
    let whole = word.value as u16;
    if whole < 1000 && f64::from(whole) == word.value {
        return Some(10 * whole);
    }
    let tenths = (10.0 * word.value).round();
    let exists = (10.0 * word.value - tenths).abs() < 1e-6 && (0.0..10_000.0).contains(&tenths);
    exists.then_some(tenths as u16)
}

/// Returns the modal group and meaning of a G word, given ten times its number.
pub(super) fn meaning(tenths: u16) -> Option<(usize, Meaning)> {
    use Meaning::*;
    Some(match tenths {
        0 => (1, Motion(Mode::Rapid)),
        10 => (1, Motion(Mode::Straight)),
        20 => (1, Motion(Mode::Arc(Turn::Clockwise))),
        30 => (1, Motion(Mode::Arc(Turn::Counterclockwise))),

        40 => (0, Special(self::Special::Dwell)),
        100 => (0, Special(self::Special::DataSetting)),
        280 | 300 => (0, Special(self::Special::Reference)),
        520 => (0, Special(self::Special::LocalShift)),
        530 => (0, Special(self::Special::MachineCoordinates)),
        920 => (0, Special(self::Special::SetPosition)),
        921 => (0, Special(self::Special::ForgetShift)),
        922 => (0, Special(self::Special::SuspendShift)),
        923 => (0, Special(self::Special::RestoreShift)),

        310 | 382..=385 => (0, Special(self::Special::Probe)),
        330 | 331 => (0, Special(self::Special::Thread { is_tapping: tenths == 331 })),

        170 => (2, Plane(self::Plane::Xy)),
        180 => (2, Plane(self::Plane::Zx)),
        190 => (2, Plane(self::Plane::Yz)),
        900 => (3, Incremental(false)),
        910 => (3, Incremental(true)),
        901 => (4, IncrementalCenter(false)),
        911 => (4, IncrementalCenter(true)),
        930 => (5, FeedMode(self::FeedMode::InverseTime)),
        940 => (5, FeedMode(self::FeedMode::PerMinute)),
        950 => (5, FeedMode(self::FeedMode::PerRevolution)),
        200 => (6, Inch(true)),
        210 => (6, Inch(false)),
        400 => (7, Compensation(CompensationWord::Off)),
        410 => (7, Compensation(CompensationWord::ByTool(Side::Left))),
        411 => (7, Compensation(CompensationWord::ByDiameter(Side::Left))),
        420 => (7, Compensation(CompensationWord::ByTool(Side::Right))),
        421 => (7, Compensation(CompensationWord::ByDiameter(Side::Right))),
        430..=432 | 440 | 490 => (8, ToolLength),

        730 | 740 | 760 | 810 | 820 | 830 | 840 | 850 | 860 | 870 | 880 | 890 => (9, Cycle),
        800 => (9, CycleEnd),

        980 => (10, ReturnToReference(false)),
        990 => (10, ReturnToReference(true)),
        540 | 541 | 550 | 560 | 570 | 580 | 590..=593 | 1540 => (12, WorkOffset),
        610 => (13, Path(PathWord::ExactPath)),
        611 => (13, Path(PathWord::ExactStop)),
        // Of the two others, G62 slows compensated inner corners, and G63 ignores overrides.
        620 | 630 | 640 => (13, Path(PathWord::Continuous)),
        960 => (14, SurfaceSpeed),
        970 => (14, Neutral),

        90 => (NO_GROUP, ExactStopHere),
        50 | 80 => (NO_GROUP, Path(PathWord::LookAhead)),
        51 => (NO_GROUP, Path(PathWord::ContourControl)),
        1870 => (NO_GROUP, Path(PathWord::Smoothness)),
        71 | 1070 => (NO_GROUP, TransformationAbout("cylindrical interpolation")),
        121 | 1120 => (NO_GROUP, Transformation("polar interpolation")),
        150 => (NO_GROUP, Polar(false)),
        160 => (NO_GROUP, Polar(true)),
        434 => (8, TipControl("G43.4")),
        435 => (8, TipControl("G43.5")),
        500 => (NO_GROUP, EndOf(Kind::Scaling)),
        510 => (NO_GROUP, Special(self::Special::Scale)),
        240 | 511 => (NO_GROUP, Special(self::Special::Mirror)),
        250 | 501 => (NO_GROUP, Special(self::Special::Unmirror)),
        680 => (NO_GROUP, Special(self::Special::Rotate)),
        690 => (NO_GROUP, EndOf(Kind::Rotation)),
        531 => (NO_GROUP, Transformation("turning the tool's axis into the tilted plane")),
        542 => (NO_GROUP, Transformation("dynamic fixture offset")),
        682 => (NO_GROUP, TransformationAbout("tilted working plane")),
        // Words that cancel a mode that is not in force, or that does not affect the path.
        110 | 131 | 1130 | 230 | 260 | 670 | 691 => (NO_GROUP, Neutral),
        // The limits of a protected zone.
        220 => (NO_GROUP, NeutralAbout),
        _ => return None,
    })
}
