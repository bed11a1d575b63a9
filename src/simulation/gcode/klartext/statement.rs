//! The statements of Heidenhain programs; their further arguments are the words of the block.

/// A statement of Klartext, or one of DIN/ISO that says the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KlartextStatement {
    /// L.
    Line,
    /// LN, whose surface normal is left out.
    LineWithNormal,
    /// LP.
    PolarLine,
    /// CC.
    CircleCenter,
    /// C.
    Circle,
    /// CP.
    PolarCircle,
    /// CR.
    CircleByRadius,
    /// CT.
    TangentialArc,
    /// CTP.
    PolarTangentialArc,
    /// RND.
    Rounding,
    /// CHF.
    Chamfer,
    /// APPR.
    Approach(ContourWay),
    /// DEP.
    Departure(ContourWay),
    /// TOOL CALL.
    ToolCall,
    /// TOOL DEF.
    ToolDefinition,
    /// STOP.
    Stop,
    /// CYCL DEF.
    CycleDefinition {
        /// Number of the cycle.
        number: u32,
        /// Number of the line of the definition: 1 in `CYCL DEF 7.1`.
        step: Option<u32>,
    },
    /// CYCL CALL.
    CycleCall,
    /// CYCL CALL POS.
    CycleCallAt,
    /// BEGIN PGM gives the unit of lengths.
    Unit {
        /// INCH, and not MM.
        is_inch: bool,
    },
    /// M functions alone.
    Functions,
    /// FUNCTION TCPM, or its end.
    TipControl(bool),
    /// TRANS.
    Transform(Transformation),
    /// TRANS … RESET.
    ResetTransform(Transformation),
    /// FUNCTION MODE TURN.
    TurningMode,
    /// Something without a model, by its name.
    Unmodelled(&'static str),
    /// It changes neither path nor time.
    Neutral,
}

/// The shape of a way to or from a contour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContourWay {
    /// LT: straight, along the element.
    Along,
    /// LN: straight, square to the element.
    Across,
    /// CT: an arc that touches the element.
    Arc,
    /// LCT: an arc that touches the element, and a line that touches the arc.
    ArcAndLine,
}

/// A change of coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transformation {
    /// DATUM.
    Datum,
    /// MIRROR.
    Mirror,
    /// ROTATION.
    Rotation,
    /// SCALE.
    Scale,
}

impl KlartextStatement {
    /// Returns the statement as it is written.
    pub fn name(self) -> &'static str {
        use KlartextStatement::*;
        match self {
            Line => "L",
            LineWithNormal => "LN",
            PolarLine => "LP",
            CircleCenter => "CC",
            Circle => "C",
            PolarCircle => "CP",
            CircleByRadius => "CR",
            TangentialArc => "CT",
            PolarTangentialArc => "CTP",
            Rounding => "RND",
            Chamfer => "CHF",
            Approach(ContourWay::Along) => "APPR LT",
            Approach(ContourWay::Across) => "APPR LN",
            Approach(ContourWay::Arc) => "APPR CT",
            Approach(ContourWay::ArcAndLine) => "APPR LCT",
            Departure(ContourWay::Along) => "DEP LT",
            Departure(ContourWay::Across) => "DEP LN",
            Departure(ContourWay::Arc) => "DEP CT",
            Departure(ContourWay::ArcAndLine) => "DEP LCT",
            ToolCall => "TOOL CALL",
            ToolDefinition => "TOOL DEF",
            Stop => "STOP",
            CycleDefinition { .. } => "CYCL DEF",
            CycleCall => "CYCL CALL",
            CycleCallAt => "CYCL CALL POS",
            Unit { is_inch: true } => "INCH",
            Unit { is_inch: false } => "MM",
            Functions | Neutral => "M",
            TipControl(_) => "FUNCTION TCPM",
            Transform(_) | ResetTransform(_) => "TRANS",
            TurningMode => "FUNCTION MODE TURN",
            Unmodelled(name) => name,
        }
    }
}
