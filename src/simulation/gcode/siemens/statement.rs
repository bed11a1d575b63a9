//! The statements of SINUMERIK programs with their arguments by name.
//!
//! Source: SINUMERIK 840D sl, Programming Manuals Cycles and Job Planning (external programming of cycles), 2013.

/// A statement with its arguments by name; lengths in the unit of the program, angles in degrees.
#[derive(Clone, Debug, PartialEq)]
pub enum SiemensStatement {
    /// MCALL: the cycle after it is run after each move; alone, it ends that.
    ModalCall,
    /// CYCLE81 to CYCLE89, and CYCLE840.
    Drilling(DrillingCycle),
    /// HOLES1, HOLES2, CYCLE801 and CYCLE802.
    Holes(HolePattern),
    /// TRANS, ROT, SCALE and MIRROR; with an A before them they add to the frame in force.
    Frame {
        /// The change of coordinates.
        change: FrameChange,
        /// `true` if it adds to the frame in force, `false` if it replaces it.
        is_added: bool,
    },
    /// SUPA.
    MachineCoordinates,
    /// CIP.
    CircleThroughPoint,
    /// CT.
    TangentialCircle,
    /// CYCLE832.
    ContourTolerance {
        /// TOL.
        tolerance: f64,
        /// `true` if TYPE says so, or there is no tolerance.
        is_off: bool,
    },
    /// CYCLE800.
    SwivelPlane {
        /// `true` if A, B or C is not 0.
        turns: bool,
        /// `true` if X0, Y0, Z0, X1, Y1 or Z1 is not 0.
        shifts: bool,
    },
    /// A milling cycle.
    MillingCycle,
    /// A turning cycle.
    TurningCycle,
    /// DIAMON, DIAM90, DIAMCYCA and DIAMCYCOF: X in diameters.
    Diameters,
    /// A spline or another curve.
    Curve,
    /// A function without a model.
    Unmodelled(Unmodelled),
    /// A statement that changes neither path nor time.
    Neutral,
}

/// A change of coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameChange {
    /// TRANS, ATRANS.
    Shift,
    /// ROT, AROT.
    Rotation,
    /// SCALE, ASCALE.
    Scaling,
    /// MIRROR, AMIRROR.
    Mirror,
}

/// A function without a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unmodelled {
    /// TRAORI.
    Orientation,
    /// TRACYL, TRANSMIT.
    Transformation,
    /// COMPON, COMPCURV, COMPCAD.
    Compressor,
    /// MEAS, MEAW and measuring cycles.
    Measuring,
    /// A3, B3, C3, LEAD, TILT and the like.
    ToolDirection,
    /// WHEN, WHENEVER, EVERY, DO.
    SynchronizedAction,
    /// `$P_UIFR` and the like.
    SystemFrame,
    /// OFFN.
    ContourAllowance,
    /// FZ.
    FeedPerTooth,
    /// POS, POSA.
    PositioningAxis,
    /// An axis with a number beyond 1.
    FurtherAxis,
    /// ROTS, TOROT and the like.
    ToolFrame,
}

/// A drilling cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrillingCycle {
    /// Its keyword.
    pub name: &'static str,
    /// RTP: the height that the tool returns to.
    pub return_height: f64,
    /// RFP: the height of the part.
    pub part_height: f64,
    /// SDIS: the clearance above the part.
    pub clearance: f64,
    /// DP: the depth.
    pub depth: Option<f64>,
    /// DPR: the depth below the part.
    pub relative_depth: Option<f64>,
    /// DTB: the dwell at the bottom, or at each depth; s or, if negative, revolutions of the spindle.
    pub dwell: f64,
    /// AMODE: a decimal digit for each argument that has several meanings, the units first; 0 for the meaning by
    /// its sign.
    pub modes: f64,
    /// The operation at the hole.
    pub kind: DrillingKind,
}

/// The operation at a hole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DrillingKind {
    /// CYCLE81 and CYCLE82.
    Drill {
        /// `true` if the tens of GMODE say that the depth is the diameter of a centring.
        is_centring: bool,
    },
    /// CYCLE83.
    DeepHole {
        /// FDEP: the first depth.
        first_depth: Option<f64>,
        /// FDPR: the first depth below the part.
        first_relative_depth: Option<f64>,
        /// DAM: the amount by which strokes shrink, or the factor if it is negative.
        degression: f64,
        /// MDEP: the least stroke.
        min_stroke: f64,
        /// DTS: the dwell outside.
        dwell_outside: f64,
        /// DTD: the dwell at the last depth.
        last_dwell: Option<f64>,
        /// FRF: the factor of the feedrate of the first stroke.
        first_feed_factor: f64,
        /// `true` if VARI says that chips are removed, not broken.
        removes_chips: bool,
        /// VRT: the retract that breaks chips.
        retract: Option<f64>,
        /// DIS1: the height above the last depth at which feed starts again.
        limit: Option<f64>,
    },
    /// CYCLE84.
    RigidTap {
        /// MPIT, PIT and PITA.
        pitch: ThreadPitch,
        /// SST: the speed of the spindle, rpm; 0 for the speed in force.
        speed: f64,
        /// SST1: the speed on the way out, rpm.
        speed_out: Option<f64>,
        /// VARI 1 and 2 with DAM: the depth of a stroke.
        stroke: Option<f64>,
        /// `true` for VARI 2: the tap leaves the hole after each stroke.
        removes_chips: bool,
        /// VRT of VARI 1: the retract that breaks chips.
        retract: Option<f64>,
    },
    /// CYCLE840.
    FloatingTap {
        /// MPIT, PIT and PITA.
        pitch: ThreadPitch,
    },
    /// CYCLE85 and CYCLE89.
    Bore {
        /// FFR: the feed per minute into the part.
        feed_in: Option<f64>,
        /// RFF: the feed per minute out of it.
        feed_out: Option<f64>,
    },
    /// CYCLE86.
    FineBore {
        /// `true` for SDIR 4: the spindle turns counter-clockwise.
        is_left_hand: bool,
        /// RPA and RPO: the displacement off the wall, in the plane.
        shift: [f64; 2],
    },
    /// CYCLE87 and CYCLE88.
    BoreAndStop {
        /// `true` for SDIR 4: the spindle turns counter-clockwise.
        is_left_hand: bool,
    },
}

/// The pitch of a thread; negative for a left-hand one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreadPitch {
    /// MPIT: the diameter of a metric thread.
    pub metric: f64,
    /// PIT; 0 for the pitch of the metric thread.
    pub pitch: f64,
    /// PITA: 1 for millimetres, 2 for threads per inch, 3 for inches, else the unit of the program.
    pub unit: f64,
}

/// A pattern of holes, in the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct HolePattern {
    /// Its keyword.
    pub name: &'static str,
    /// The positions of its holes.
    pub shape: PatternShape,
}

/// The positions of the holes of a pattern.
#[derive(Clone, Debug, PartialEq)]
pub enum PatternShape {
    /// HOLES1.
    Row {
        /// SPCA and SPCO: a point of the row.
        start: [f64; 2],
        /// STA1: its angle.
        angle: f64,
        /// FDIS: from the point to the first hole.
        first_distance: f64,
        /// DBH: from hole to hole.
        spacing: f64,
        /// NUM.
        count: f64,
    },
    /// HOLES2.
    Circle {
        /// CPA and CPO.
        center: [f64; 2],
        /// RAD.
        radius: f64,
        /// STA1: the angle of the first hole.
        start_angle: f64,
        /// INDA: from hole to hole; 0 spreads the holes evenly.
        step_angle: f64,
        /// NUM.
        count: f64,
    },
    /// CYCLE801.
    Grid {
        /// SPCA and SPCO: its corner.
        start: [f64; 2],
        /// STA1: the angle of its rows.
        angle: f64,
        /// DIS1 and DIS2: from hole to hole, and from row to row.
        spacings: [f64; 2],
        /// NUM1 and NUM2: holes of a row, and rows.
        counts: [f64; 2],
        /// `true` for VARI 1: only the holes of the border.
        is_frame: bool,
    },
    /// CYCLE802.
    Positions {
        /// XA and YA: a decimal digit for each position, the units first: 2 for an increment.
        modes: [f64; 2],
        /// X0, Y0 to X8, Y8.
        positions: Vec<[Option<f64>; 2]>,
    },
}
