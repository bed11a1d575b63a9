//! Statements of Heidenhain programs; their further arguments are words of the block.

/// A statement of Klartext, or its equivalent in DIN/ISO.
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
    /// BEGIN PGM with the unit of lengths.
    Unit {
        /// `true` for INCH, `false` for MM.
        is_inch: bool,
    },
    /// M functions alone.
    Functions,
    /// FUNCTION TCPM with `true`, its end with `false`.
    TipControl(bool),
    /// TRANS.
    Transform(Transformation),
    /// TRANS … RESET.
    ResetTransform(Transformation),
    /// FUNCTION MODE TURN.
    TurningMode,
    /// A statement without a model, by its name.
    Unmodelled(&'static str),
    /// A statement that changes neither path nor time.
    Neutral,
}

/// The shape of an approach to a contour or a departure from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContourWay {
    /// LT: straight, along the element.
    Along,
    /// LN: straight, at a right angle to the element.
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
    /// Returns the spelling of the statement.
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
