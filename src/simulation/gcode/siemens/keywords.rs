//! The keywords of SINUMERIK programs, and what their arguments are called.

use crate::simulation::gcode::siemens::statement::{
    DrillingCycle, DrillingKind, FrameChange, HolePattern, PatternShape, SiemensStatement, ThreadPitch,
    Unmodelled,
};
use crate::simulation::gcode::{Argument, Keyword};
use Kind::*;

/// A keyword and what it asks for.
#[derive(Debug, PartialEq)]
pub struct SiemensKeyword {
    /// As it is written.
    pub name: &'static str,
    kind: Kind,
}

/// What a keyword asks for, its arguments aside.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    ModalCall,
    Drilling(Cycle),
    Pattern(Holes),
    Frame(FrameChange, bool),
    MachineCoordinates,
    CircleThroughPoint,
    TangentialCircle,
    ContourTolerance,
    SwivelPlane,
    MillingCycle,
    TurningCycle,
    Diameters,
    Curve,
    Unmodelled(Unmodelled),
    Neutral,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Cycle {
    Drill,
    DrillAndDwell,
    DeepHole,
    RigidTap,
    FloatingTap,
    Bore,
    FineBore,
    BoreAndStop,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Holes {
    Row,
    Circle,
    Grid,
    Positions,
}

/// The names of the arguments of a statement in their order, as the manuals call them.
fn signature(name: &str) -> &'static str {
    match name {
        "CYCLE81" | "CYCLE82" => "RTP RFP SDIS DP DPR DTB GMODE DMODE AMODE",
        "CYCLE83" => {
            "RTP RFP SDIS DP DPR FDEP FDPR DAM DTB DTS FRF VARI AXN MDEP VRT DTD DIS1 GMODE DMODE AMODE"
        }
        "CYCLE84" => {
            "RTP RFP SDIS DP DPR DTB SDAC MPIT PIT POSS SST SST1 AXN PITA TECHNO VARI DAM VRT PITM PTAB PTABA GMODE DMODE AMODE"
        }
        "CYCLE840" => {
            "RTP RFP SDIS DP DPR DTB SDR SDAC ENC MPIT PIT AXN PITA TECHNO PITM PTAB PTABA GMODE DMODE AMODE"
        }
        "CYCLE85" => "RTP RFP SDIS DP DPR DTB FFR RFF GMODE DMODE AMODE",
        "CYCLE86" => "RTP RFP SDIS DP DPR DTB SDIR RPA RPO RPAP POSS GMODE DMODE AMODE",
        "CYCLE87" => "RTP RFP SDIS DP DPR SDIR",
        "CYCLE88" => "RTP RFP SDIS DP DPR DTB SDIR",
        "CYCLE89" => "RTP RFP SDIS DP DPR DTB",
        "CYCLE800" => "FR TC ST MODE X0 Y0 Z0 A B C X1 Y1 Z1",
        "CYCLE801" => "SPCA SPCO STA1 DIS1 DIS2 NUM1 NUM2 VARI",
        "CYCLE802" => "XA YA X0 Y0 X1 Y1 X2 Y2 X3 Y3 X4 Y4 X5 Y5 X6 Y6 X7 Y7 X8 Y8",
        "CYCLE832" => "TOL TYPE",
        "HOLES1" => "SPCA SPCO STA1 FDIS DBH NUM",
        "HOLES2" => "CPA CPO RAD STA1 INDA NUM",
        _ => "",
    }
}

/// The arguments of a statement by name.
struct Arguments<'a> {
    signature: &'static str,
    values: &'a [Argument],
}

impl Arguments<'_> {
    /// Returns an argument that is not left out.
    fn option(&self, name: &str) -> Option<f64> {
        let position = self.signature.split(' ').position(|known| known == name)?;
        let argument = self.values.iter().find(|argument| usize::from(argument.position) == position);
        argument.map(|argument| argument.value)
    }

    /// Returns an argument; 0 if it is left out.
    fn value(&self, name: &str) -> f64 {
        self.option(name).unwrap_or(0.0)
    }

    /// Returns an argument that is not 0.
    fn given(&self, name: &str) -> Option<f64> {
        self.option(name).filter(|value| *value != 0.0)
    }

    /// Returns whether one of these arguments is not 0.
    fn any(&self, names: &[&str]) -> bool {
        names.iter().any(|name| self.given(name).is_some())
    }

    fn pitch(&self) -> ThreadPitch {
        ThreadPitch { metric: self.value("MPIT"), pitch: self.value("PIT"), unit: self.value("PITA") }
    }

    fn drilling(&self, name: &'static str, cycle: Cycle) -> DrillingCycle {
        let is_left_hand = self.value("SDIR") == 4.0;
        let kind = match cycle {
            Cycle::Drill => {
                DrillingKind::Drill { is_centring: (self.value("GMODE") / 10.0) as i64 % 10 == 1 }
            }
            Cycle::DrillAndDwell => DrillingKind::Drill { is_centring: false },
            Cycle::DeepHole => DrillingKind::DeepHole {
                first_depth: self.given("FDEP"),
                first_relative_depth: self.given("FDPR"),
                degression: self.value("DAM"),
                min_stroke: self.value("MDEP"),
                dwell_outside: self.value("DTS"),
                last_dwell: self.given("DTD"),
                first_feed_factor: self.value("FRF"),
                removes_chips: self.value("VARI") != 0.0,
                retract: self.given("VRT"),
                limit: self.given("DIS1"),
            },
            Cycle::RigidTap => {
                let variant = self.value("VARI");
                DrillingKind::RigidTap {
                    pitch: self.pitch(),
                    speed: self.value("SST"),
                    speed_out: self.given("SST1"),
                    stroke: self.given("DAM").filter(|_| variant == 1.0 || variant == 2.0),
                    removes_chips: variant == 2.0,
                    retract: self.given("VRT").filter(|_| variant == 1.0),
                }
            }
            Cycle::FloatingTap => DrillingKind::FloatingTap { pitch: self.pitch() },
            Cycle::Bore => DrillingKind::Bore { feed_in: self.given("FFR"), feed_out: self.given("RFF") },
            Cycle::FineBore => {
                DrillingKind::FineBore { is_left_hand, shift: [self.value("RPA"), self.value("RPO")] }
            }
            Cycle::BoreAndStop => DrillingKind::BoreAndStop { is_left_hand },
        };
        DrillingCycle {
            name,
            return_height: self.value("RTP"),
            part_height: self.value("RFP"),
            clearance: self.value("SDIS"),
            depth: self.given("DP"),
            relative_depth: self.given("DPR"),
            dwell: self.value("DTB"),
            modes: self.value("AMODE"),
            kind,
        }
    }

    fn pattern(&self, name: &'static str, holes: Holes) -> HolePattern {
        let pair = |first: &str, second: &str| [self.value(first), self.value(second)];
        let shape = match holes {
            Holes::Row => PatternShape::Row {
                start: pair("SPCA", "SPCO"),
                angle: self.value("STA1"),
                first_distance: self.value("FDIS"),
                spacing: self.value("DBH"),
                count: self.value("NUM"),
            },
            Holes::Circle => PatternShape::Circle {
                center: pair("CPA", "CPO"),
                radius: self.value("RAD"),
                start_angle: self.value("STA1"),
                step_angle: self.value("INDA"),
                count: self.value("NUM"),
            },
            Holes::Grid => PatternShape::Grid {
                start: pair("SPCA", "SPCO"),
                angle: self.value("STA1"),
                spacings: pair("DIS1", "DIS2"),
                counts: pair("NUM1", "NUM2"),
                is_frame: self.value("VARI") == 1.0,
            },
            Holes::Positions => {
                let position = |index: u32| ["X", "Y"].map(|axis| self.option(&format!("{axis}{index}")));
                let positions = (0..9).map(position).collect();
                PatternShape::Positions { modes: pair("XA", "YA"), positions }
            }
        };
        HolePattern { name, shape }
    }
}

/// Returns the keyword with this name in capital letters.
pub(super) fn keyword(name: &[u8]) -> Option<Keyword> {
    KEYWORDS.iter().find(|known| known.name.as_bytes() == name).map(Keyword::Siemens)
}

/// Returns a keyword that is in the table.
pub(super) fn known(name: &str) -> Keyword {
    keyword(name.as_bytes()).expect("the keyword is in the table")
}

impl SiemensKeyword {
    /// Whether this is MCALL.
    pub(super) fn is_modal_call(&self) -> bool {
        self.kind == ModalCall
    }

    /// Returns the statement with these arguments.
    pub fn with(&self, arguments: &[Argument]) -> SiemensStatement {
        let arguments = Arguments { signature: signature(self.name), values: arguments };
        match self.kind {
            ModalCall => SiemensStatement::ModalCall,
            Drilling(cycle) => SiemensStatement::Drilling(arguments.drilling(self.name, cycle)),
            Pattern(holes) => SiemensStatement::Holes(arguments.pattern(self.name, holes)),
            Frame(change, is_added) => SiemensStatement::Frame { change, is_added },
            MachineCoordinates => SiemensStatement::MachineCoordinates,
            CircleThroughPoint => SiemensStatement::CircleThroughPoint,
            TangentialCircle => SiemensStatement::TangentialCircle,
            ContourTolerance => {
                let tolerance = arguments.value("TOL");
                // Units of the type: 0 off, 1 to 4 finish to rough.
                let is_off = arguments.option("TYPE").is_some_and(|kind| kind % 10.0 == 0.0);
                SiemensStatement::ContourTolerance { tolerance, is_off: is_off || tolerance == 0.0 }
            }
            SwivelPlane => SiemensStatement::SwivelPlane {
                turns: arguments.any(&["A", "B", "C"]),
                shifts: arguments.any(&["X0", "Y0", "Z0", "X1", "Y1", "Z1"]),
            },
            MillingCycle => SiemensStatement::MillingCycle,
            TurningCycle => SiemensStatement::TurningCycle,
            Diameters => SiemensStatement::Diameters,
            Curve => SiemensStatement::Curve,
            Unmodelled(what) => SiemensStatement::Unmodelled(what),
            Neutral => SiemensStatement::Neutral,
        }
    }
}

/// The keywords that the interpreter acts on, or names in a remark, and those that make a block of their line.
static KEYWORDS: &[SiemensKeyword] = &[
    row("MCALL", ModalCall),
    row("CYCLE81", Drilling(Cycle::Drill)),
    row("CYCLE82", Drilling(Cycle::DrillAndDwell)),
    row("CYCLE83", Drilling(Cycle::DeepHole)),
    row("CYCLE84", Drilling(Cycle::RigidTap)),
    row("CYCLE840", Drilling(Cycle::FloatingTap)),
    row("CYCLE85", Drilling(Cycle::Bore)),
    row("CYCLE86", Drilling(Cycle::FineBore)),
    row("CYCLE87", Drilling(Cycle::BoreAndStop)),
    row("CYCLE88", Drilling(Cycle::BoreAndStop)),
    row("CYCLE89", Drilling(Cycle::Bore)),
    row("CYCLE832", ContourTolerance),
    row("CYCLE800", SwivelPlane),
    row("HOLES1", Pattern(Holes::Row)),
    row("HOLES2", Pattern(Holes::Circle)),
    row("POCKET1", MillingCycle),
    row("POCKET2", MillingCycle),
    row("POCKET3", MillingCycle),
    row("POCKET4", MillingCycle),
    row("SLOT1", MillingCycle),
    row("SLOT2", MillingCycle),
    row("LONGHOLE", MillingCycle),
    row("CYCLE60", MillingCycle),
    row("CYCLE61", MillingCycle),
    row("CYCLE62", Neutral),
    row("CYCLE63", MillingCycle),
    row("CYCLE64", MillingCycle),
    row("CYCLE70", MillingCycle),
    row("CYCLE71", MillingCycle),
    row("CYCLE72", MillingCycle),
    row("CYCLE73", MillingCycle),
    row("CYCLE74", MillingCycle),
    row("CYCLE75", MillingCycle),
    row("CYCLE76", MillingCycle),
    row("CYCLE77", MillingCycle),
    row("CYCLE78", MillingCycle),
    row("CYCLE79", MillingCycle),
    row("CYCLE90", MillingCycle),
    row("CYCLE801", Pattern(Holes::Grid)),
    row("CYCLE802", Pattern(Holes::Positions)),
    row("CYCLE899", MillingCycle),
    row("CYCLE977", Unmodelled(Unmodelled::Measuring)),
    row("CYCLE978", Unmodelled(Unmodelled::Measuring)),
    row("CYCLE979", Unmodelled(Unmodelled::Measuring)),
    row("CYCLE998", Unmodelled(Unmodelled::Measuring)),
    row("MEAS", Unmodelled(Unmodelled::Measuring)),
    row("MEAW", Unmodelled(Unmodelled::Measuring)),
    row("TRANS", Frame(FrameChange::Shift, false)),
    row("ATRANS", Frame(FrameChange::Shift, true)),
    row("ROT", Frame(FrameChange::Rotation, false)),
    row("AROT", Frame(FrameChange::Rotation, true)),
    row("SCALE", Frame(FrameChange::Scaling, false)),
    row("ASCALE", Frame(FrameChange::Scaling, true)),
    row("MIRROR", Frame(FrameChange::Mirror, false)),
    row("AMIRROR", Frame(FrameChange::Mirror, true)),
    row("SUPA", MachineCoordinates),
    row("TRAORI", Unmodelled(Unmodelled::Orientation)),
    row("TRAFOOF", Neutral),
    row("TRACYL", Unmodelled(Unmodelled::Transformation)),
    row("TRANSMIT", Unmodelled(Unmodelled::Transformation)),
    row("CIP", CircleThroughPoint),
    row("CT", TangentialCircle),
    row("ASPLINE", Curve),
    row("BSPLINE", Curve),
    row("CSPLINE", Curve),
    row("POLY", Curve),
    row("INVCW", Curve),
    row("INVCCW", Curve),
    row("MSG", Neutral),
    row("COMPON", Unmodelled(Unmodelled::Compressor)),
    row("COMPCURV", Unmodelled(Unmodelled::Compressor)),
    row("COMPCAD", Unmodelled(Unmodelled::Compressor)),
    row("COMPOF", Neutral),
    row("SOFT", Neutral),
    row("BRISK", Neutral),
    row("DRIVE", Neutral),
    row("GOTOS", Neutral),
    row("SETAL", Neutral),
    row("NORM", Neutral),
    row("KONT", Neutral),
    row("KONTC", Neutral),
    row("KONTT", Neutral),
    row("SBLON", Neutral),
    row("SBLOF", Neutral),
    row("CFC", Neutral),
    row("CFTCP", Neutral),
    row("CFIN", Neutral),
    row("SETMS", Neutral),
    row("WORKPIECE", Neutral),
    row("REPOSA", Neutral),
    row("ROTS", Unmodelled(Unmodelled::ToolFrame)),
    row("AROTS", Unmodelled(Unmodelled::ToolFrame)),
    row("TOFFON", Neutral),
    row("TOROT", Unmodelled(Unmodelled::ToolFrame)),
    row("PAROT", Unmodelled(Unmodelled::ToolFrame)),
    row("OEMIPO1", Curve),
    row("SPCON", Neutral),
    row("SPCOF", Neutral),
    row("A3", Unmodelled(Unmodelled::ToolDirection)),
    row("OFFN", Unmodelled(Unmodelled::ContourAllowance)),
    row("FZ", Unmodelled(Unmodelled::FeedPerTooth)),
    row("POS", Unmodelled(Unmodelled::PositioningAxis)),
    row("X2", Unmodelled(Unmodelled::FurtherAxis)),
    row("WHEN", Unmodelled(Unmodelled::SynchronizedAction)),
    row("DIAMON", Diameters),
    row("DIAM90", Diameters),
    row("DIAMCYCA", Diameters),
    row("DIAMCYCOF", Diameters),
    row("CYCLE92", TurningCycle),
    row("CYCLE93", TurningCycle),
    row("CYCLE94", TurningCycle),
    row("CYCLE95", TurningCycle),
    row("CYCLE96", TurningCycle),
    row("CYCLE97", TurningCycle),
    row("CYCLE98", TurningCycle),
    row("CYCLE99", TurningCycle),
    row("CYCLE930", TurningCycle),
    row("CYCLE940", TurningCycle),
    row("CYCLE950", TurningCycle),
    row("CYCLE951", TurningCycle),
    row("CYCLE952", TurningCycle),
    row("$P_UIFR", Unmodelled(Unmodelled::SystemFrame)),
];

const fn row(name: &'static str, kind: Kind) -> SiemensKeyword {
    SiemensKeyword { name, kind }
}
