//! The names of Klartext: statements with how they are written, words, cycle parameters.

use crate::simulation::gcode::address;

/// What the tracer acts on, or names in a diagnostic; the value of a statement word is its place
/// here.
pub const STATEMENTS: &[&str] = &[
    "L",
    "LN",
    "LP",
    "C",
    "CC",
    "CR",
    "CT",
    "CP",
    "CTP",
    "RND",
    "CHF",
    "APPR LT",
    "APPR LN",
    "APPR CT",
    "APPR LCT",
    "DEP LT",
    "DEP LN",
    "DEP CT",
    "DEP LCT",
    "TOOL CALL",
    "TOOL DEF",
    "STOP",
    "CYCL DEF",
    "CYCL CALL",
    "CYCL CALL POS",
    "CYCL CALL PAT",
    "MM",
    "INCH",
    "M",
    "PLANE",
    "FUNCTION TCPM",
    "FUNCTION RESET TCPM",
    "TRANS DATUM",
    "TRANS DATUM RESET",
    "TRANS MIRROR",
    "TRANS MIRROR RESET",
    "TRANS ROTATION",
    "TRANS ROTATION RESET",
    "TRANS SCALE",
    "TRANS SCALE RESET",
    "PATTERN DEF",
    "SEL PATTERN",
    "CONTOUR DEF",
    "SEL CONTOUR",
    "DECLARE CONTOUR",
    "SEL TABLE",
    "PRESET",
    "TCH PROBE",
    "FK",
    "SPL",
    "SEL PGM",
    "CALL SELECTED PGM",
    "FN 14",
    "FN 16",
    "FN 18",
    "FN 18 POSITION",
    "FN 19",
    "FN 20",
    "FN 26",
    "FN 27",
    "FN 28",
    "FN 29",
    "FN 37",
    "FN 38",
    "FUNCTION FEED",
    "FUNCTION DWELL",
    "FUNCTION TURNDATA",
    "FUNCTION MODE TURN",
    "LIFT-OFF",
    "LBL QS",
    "QS",
    "IS UNDEFINED",
    "G06",
    "BLOCK",
    "G26",
    "G27",
];

/// How statements that take path words are written, the longer one first where two begin alike.
pub(super) const PATHS: &[(&[&str], &str)] = &[
    (&["L"], "L"),
    (&["LN"], "LN"),
    (&["LP"], "LP"),
    (&["C"], "C"),
    (&["CC"], "CC"),
    (&["CR"], "CR"),
    (&["CT"], "CT"),
    (&["CP"], "CP"),
    (&["CTP"], "CTP"),
    (&["RND"], "RND"),
    (&["CHF"], "CHF"),
    (&["APPR", "LT"], "APPR LT"),
    (&["APPR", "LN"], "APPR LN"),
    (&["APPR", "CT"], "APPR CT"),
    (&["APPR", "LCT"], "APPR LCT"),
    (&["APPR", "PLT"], "APPR LT"),
    (&["APPR", "PLN"], "APPR LN"),
    (&["APPR", "PCT"], "APPR CT"),
    (&["APPR", "PLCT"], "APPR LCT"),
    (&["DEP", "LT"], "DEP LT"),
    (&["DEP", "LN"], "DEP LN"),
    (&["DEP", "CT"], "DEP CT"),
    (&["DEP", "LCT"], "DEP LCT"),
    (&["DEP", "PLCT"], "DEP LCT"),
    (&["STOP"], "STOP"),
    (&["CYCL", "CALL", "POS"], "CYCL CALL POS"),
    (&["CYCL", "CALL", "PAT"], "CYCL CALL PAT"),
    (&["CYCL", "CALL"], "CYCL CALL"),
    (&["TRANS", "DATUM", "AXIS"], "TRANS DATUM"),
    (&["TRANS", "MIRROR", "AXIS"], "TRANS MIRROR"),
    (&["TRANS", "ROTATION"], "TRANS ROTATION"),
    (&["TRANS", "SCALE"], "TRANS SCALE"),
];

/// Statements whose line says nothing more that is read. Nothing is said of those without a name.
pub(super) const WHOLE_LINES: &[(&[&str], &str)] = &[
    (&["BLK", "FORM"], ""),
    (&["PLANE", "RESET"], ""),
    (&["PLANE"], "PLANE"),
    (&["FUNCTION", "TCPM"], "FUNCTION TCPM"),
    (&["FUNCTION", "RESET", "TCPM"], "FUNCTION RESET TCPM"),
    (&["FUNCTION", "FEED", "DWELL"], "FUNCTION FEED"),
    (&["FUNCTION", "DWELL"], "FUNCTION DWELL"),
    (&["FUNCTION", "TURNDATA"], "FUNCTION TURNDATA"),
    (&["FUNCTION", "MODE", "TURN"], "FUNCTION MODE TURN"),
    (&["FUNCTION"], ""),
    (&["TRANS", "DATUM", "RESET"], "TRANS DATUM RESET"),
    (&["TRANS", "DATUM", "TABLE"], "SEL TABLE"),
    (&["TRANS", "MIRROR", "RESET"], "TRANS MIRROR RESET"),
    (&["TRANS", "ROTATION", "RESET"], "TRANS ROTATION RESET"),
    (&["TRANS", "SCALE", "RESET"], "TRANS SCALE RESET"),
    (&["PATTERN", "DEF"], "PATTERN DEF"),
    (&["SEL", "PATTERN"], "SEL PATTERN"),
    (&["CONTOUR", "DEF"], "CONTOUR DEF"),
    (&["SEL", "CONTOUR"], "SEL CONTOUR"),
    (&["DECLARE", "CONTOUR"], "DECLARE CONTOUR"),
    (&["DECLARE"], ""),
    (&["SEL", "TABLE"], "SEL TABLE"),
    (&["SEL", "PGM"], "SEL PGM"),
    (&["SEL"], ""),
    (&["CALL", "SELECTED"], "CALL SELECTED PGM"),
    (&["PRESET"], "PRESET"),
    (&["TCH", "PROBE"], "TCH PROBE"),
    (&["FPOL"], "FK"),
    (&["FL"], "FK"),
    (&["FLT"], "FK"),
    (&["FC"], "FK"),
    (&["FCT"], "FK"),
    (&["FSELECT"], ""),
    (&["SPL"], "SPL"),
    (&["GLOBAL", "DEF"], ""),
    (&["POLARKIN"], ""),
    (&["CORRDATA"], ""),
    (&["OPEN", "FILE"], ""),
    (&["FILE"], ""),
    (&["SECTION"], ""),
    (&["STRUCTURE"], ""),
    (&["CALL", "LBL", "QS"], "LBL QS"),
];

/// What a word of a path asks for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Word {
    /// It has a value.
    Value(u8),
    /// It has a value that counts from where the tool is.
    Increment(u8),
    /// It stands alone.
    Flag(u8, i8),
    /// It has a sign alone.
    Sense,
    /// It has a value and is not needed: the normal of a surface and the like.
    Unneeded,
}

/// The words of paths, the longer one first where two begin alike.
pub(super) const WORDS: &[(&str, Word)] = &[
    ("FMAX", Word::Flag(address::RAPID, 1)),
    ("F MAX", Word::Flag(address::RAPID, 1)),
    ("FAUTO", Word::Flag(address::AUTO_FEED, 1)),
    ("F AUTO", Word::Flag(address::AUTO_FEED, 1)),
    ("FU", Word::Value(address::FEED_PER_REVOLUTION)),
    ("FZ", Word::Value(address::FEED_PER_TOOTH)),
    ("FTMAX", Word::Value(address::FEED_TIME)),
    ("FT", Word::Value(address::FEED_TIME)),
    ("F", Word::Value(b'F')),
    ("IPA", Word::Increment(address::POLAR_ANGLE)),
    ("IPR", Word::Increment(address::POLAR_RADIUS)),
    ("IROT", Word::Increment(address::PLANE_ANGLE)),
    ("IX", Word::Increment(b'X')),
    ("IY", Word::Increment(b'Y')),
    ("IZ", Word::Increment(b'Z')),
    ("IA", Word::Increment(b'A')),
    ("IB", Word::Increment(b'B')),
    ("IC", Word::Increment(b'C')),
    ("IU", Word::Increment(b'U')),
    ("IV", Word::Increment(b'V')),
    ("IW", Word::Increment(b'W')),
    ("PA", Word::Value(address::POLAR_ANGLE)),
    ("PR", Word::Value(address::POLAR_RADIUS)),
    ("ROT", Word::Value(address::PLANE_ANGLE)),
    ("SCL", Word::Value(address::SETTING)),
    ("DR", Word::Sense),
    ("RL", Word::Flag(address::SIDE, 1)),
    ("RR", Word::Flag(address::SIDE, -1)),
    ("R", Word::Value(address::CIRCLE_RADIUS)),
    ("CCA", Word::Value(address::OPENING_ANGLE)),
    ("LEN", Word::Value(address::APPROACH_LENGTH)),
    ("MB MAX", Word::Flag(address::RETRACTION, -1)),
    ("MBMAX", Word::Flag(address::RETRACTION, -1)),
    ("MB", Word::Value(address::RETRACTION)),
    ("LA", Word::Unneeded),
    ("NX", Word::Unneeded),
    ("NY", Word::Unneeded),
    ("NZ", Word::Unneeded),
    ("TX", Word::Unneeded),
    ("TY", Word::Unneeded),
    ("TZ", Word::Unneeded),
    ("M", Word::Value(b'M')),
    ("S", Word::Value(b'S')),
    ("X", Word::Value(b'X')),
    ("Y", Word::Value(b'Y')),
    ("Z", Word::Value(b'Z')),
    ("A", Word::Value(b'A')),
    ("B", Word::Value(b'B')),
    ("C", Word::Value(b'C')),
    ("U", Word::Value(b'U')),
    ("V", Word::Value(b'V')),
    ("W", Word::Value(b'W')),
];

/// The parameters that cycles read; those of a `CYCL DEF` are arguments from [`FIRST_PARAMETER`]
/// on, by their place here.
pub const CYCLE_PARAMETERS: &[u32] = &[
    200, 201, 202, 203, 204, 205, 206, 207, 208, 209, 210, 211, 212, 213, 214, 216, 217, 224, 225, 226, 237,
    238, 239, 241, 242, 243, 244, 245, 246, 247, 249, 250, 251, 252, 253, 254, 255, 256, 257, 258, 259, 301,
    334, 335, 336, 339, 342, 343, 344, 351, 379, 395, 403, 365, 435, 427,
];

/// The argument with the number of a cycle.
pub const CYCLE_NUMBER: u8 = address::ARGUMENT;

/// The argument with the number of its line: 1 in `CYCL DEF 7.1`.
pub const CYCLE_STEP: u8 = address::ARGUMENT + 1;

/// The argument of the first of [`CYCLE_PARAMETERS`].
pub const FIRST_PARAMETER: u8 = address::ARGUMENT + 3;

/// Numbers of parameters, of no program, that hold the position in X, Y and Z.
pub const POSITION_PARAMETERS: [u32; 3] = [3_000_001, 3_000_002, 3_000_003];

/// The code of a statement.
pub(in crate::simulation::gcode) fn statement(name: &str) -> f64 {
    STATEMENTS.iter().position(|known| *known == name).expect("it is in the table") as f64
}
