//! The keywords of SINUMERIK programs, and the names of their arguments.

use crate::simulation::gcode::siemens::statement::{
    DrillingCycle, DrillingKind, FrameChange, HolePattern, PatternShape, SiemensStatement, ThreadPitch,
    Unmodelled,
};
use crate::simulation::gcode::{Argument, Keyword};
use SiemensStatement::*;

/// A keyword with the kind of its statement.
#[derive(Debug, PartialEq)]
pub struct SiemensKeyword {
    /// Its spelling.
    pub name: &'static str,
    kind: Kind,
}

/// The statement of a keyword.
#[derive(Debug, PartialEq)]
enum Kind {
    /// This statement, whatever its arguments.
    Plain(&'static SiemensStatement),
    /// CYCLE81 to CYCLE89, and CYCLE840.
    Drilling(CycleKind),
    /// HOLES1, HOLES2, CYCLE801 and CYCLE802.
    Pattern(Holes),
    /// CYCLE832.
    ContourTolerance,
    /// CYCLE800.
    SwivelPlane,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum CycleKind {
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

/// Returns the names of the arguments of a statement in their order, as in the manuals.
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

    /// Returns `true` if one of these arguments is not 0.
    fn any(&self, names: &[&str]) -> bool {
        names.iter().any(|name| self.given(name).is_some())
    }

    /// Returns the pitch of a tapping cycle.
    fn pitch(&self) -> ThreadPitch {
        ThreadPitch { metric: self.value("MPIT"), pitch: self.value("PIT"), unit: self.value("PITA") }
    }

    /// Returns the drilling cycle with these arguments.
    fn drilling(&self, name: &'static str, cycle: CycleKind) -> DrillingCycle {
        let is_left_hand = self.value("SDIR") == 4.0;
        let kind = match cycle {
            CycleKind::Drill => {
                DrillingKind::Drill { is_centring: (self.value("GMODE") / 10.0) as i64 % 10 == 1 }
            }
            CycleKind::DrillAndDwell => DrillingKind::Drill { is_centring: false },
            CycleKind::DeepHole => DrillingKind::DeepHole {
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
            CycleKind::RigidTap => {
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
            CycleKind::FloatingTap => DrillingKind::FloatingTap { pitch: self.pitch() },
            CycleKind::Bore => DrillingKind::Bore { feed_in: self.given("FFR"), feed_out: self.given("RFF") },
            CycleKind::FineBore => {
                DrillingKind::FineBore { is_left_hand, shift: [self.value("RPA"), self.value("RPO")] }
            }
            CycleKind::BoreAndStop => DrillingKind::BoreAndStop { is_left_hand },
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

    /// Returns the pattern of holes with these arguments.
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
    /// Returns `true` for MCALL.
    pub(super) fn is_modal_call(&self) -> bool {
        matches!(self.kind, Kind::Plain(SiemensStatement::ModalCall))
    }

    /// Returns the statement with these arguments.
    pub fn with(&self, arguments: &[Argument]) -> SiemensStatement {
        let arguments = Arguments { signature: signature(self.name), values: arguments };
        match &self.kind {
            Kind::Plain(statement) => (*statement).clone(),
            Kind::Drilling(cycle) => SiemensStatement::Drilling(arguments.drilling(self.name, *cycle)),
            Kind::Pattern(holes) => SiemensStatement::Holes(arguments.pattern(self.name, *holes)),
            Kind::ContourTolerance => {
                let tolerance = arguments.value("TOL");
                // Units of the type: 0 off, 1 to 4 finish to rough.
                let is_off = arguments.option("TYPE").is_some_and(|kind| kind % 10.0 == 0.0);
                SiemensStatement::ContourTolerance { tolerance, is_off: is_off || tolerance == 0.0 }
            }
            Kind::SwivelPlane => SiemensStatement::SwivelPlane {
                turns: arguments.any(&["A", "B", "C"]),
                shifts: arguments.any(&["X0", "Y0", "Z0", "X1", "Y1", "Z1"]),
            },
        }
    }
}

/// The keywords that the interpreter runs or names in a remark, and those that make a block of their line.
static KEYWORDS: &[SiemensKeyword] = &[
    plain("MCALL", &ModalCall),
    row("CYCLE81", Kind::Drilling(CycleKind::Drill)),
    row("CYCLE82", Kind::Drilling(CycleKind::DrillAndDwell)),
    row("CYCLE83", Kind::Drilling(CycleKind::DeepHole)),
    row("CYCLE84", Kind::Drilling(CycleKind::RigidTap)),
    row("CYCLE840", Kind::Drilling(CycleKind::FloatingTap)),
    row("CYCLE85", Kind::Drilling(CycleKind::Bore)),
    row("CYCLE86", Kind::Drilling(CycleKind::FineBore)),
    row("CYCLE87", Kind::Drilling(CycleKind::BoreAndStop)),
    row("CYCLE88", Kind::Drilling(CycleKind::BoreAndStop)),
    row("CYCLE89", Kind::Drilling(CycleKind::Bore)),
    row("CYCLE832", Kind::ContourTolerance),
    row("CYCLE800", Kind::SwivelPlane),
    row("HOLES1", Kind::Pattern(Holes::Row)),
    row("HOLES2", Kind::Pattern(Holes::Circle)),
    plain("POCKET1", &MillingCycle),
    plain("POCKET2", &MillingCycle),
    plain("POCKET3", &MillingCycle),
    plain("POCKET4", &MillingCycle),
    plain("SLOT1", &MillingCycle),
    plain("SLOT2", &MillingCycle),
    plain("LONGHOLE", &MillingCycle),
    plain("CYCLE60", &MillingCycle),
    plain("CYCLE61", &MillingCycle),
    plain("CYCLE62", &Neutral),
    plain("CYCLE63", &MillingCycle),
    plain("CYCLE64", &MillingCycle),
    plain("CYCLE70", &MillingCycle),
    plain("CYCLE71", &MillingCycle),
    plain("CYCLE72", &MillingCycle),
    plain("CYCLE73", &MillingCycle),
    plain("CYCLE74", &MillingCycle),
    plain("CYCLE75", &MillingCycle),
    plain("CYCLE76", &MillingCycle),
    plain("CYCLE77", &MillingCycle),
    plain("CYCLE78", &MillingCycle),
    plain("CYCLE79", &MillingCycle),
    plain("CYCLE90", &MillingCycle),
    row("CYCLE801", Kind::Pattern(Holes::Grid)),
    row("CYCLE802", Kind::Pattern(Holes::Positions)),
    plain("CYCLE899", &MillingCycle),
    plain("CYCLE977", &Unmodelled(Unmodelled::Measuring)),
    plain("CYCLE978", &Unmodelled(Unmodelled::Measuring)),
    plain("CYCLE979", &Unmodelled(Unmodelled::Measuring)),
    plain("CYCLE998", &Unmodelled(Unmodelled::Measuring)),
    plain("MEAS", &Unmodelled(Unmodelled::Measuring)),
    plain("MEAW", &Unmodelled(Unmodelled::Measuring)),
    plain("TRANS", &Frame { change: FrameChange::Shift, is_added: false }),
    plain("ATRANS", &Frame { change: FrameChange::Shift, is_added: true }),
    plain("ROT", &Frame { change: FrameChange::Rotation, is_added: false }),
    plain("AROT", &Frame { change: FrameChange::Rotation, is_added: true }),
    plain("SCALE", &Frame { change: FrameChange::Scaling, is_added: false }),
    plain("ASCALE", &Frame { change: FrameChange::Scaling, is_added: true }),
    plain("MIRROR", &Frame { change: FrameChange::Mirror, is_added: false }),
    plain("AMIRROR", &Frame { change: FrameChange::Mirror, is_added: true }),
    plain("SUPA", &MachineCoordinates),
    plain("TRAORI", &Unmodelled(Unmodelled::Orientation)),
    plain("TRAFOOF", &Neutral),
    plain("TRACYL", &Unmodelled(Unmodelled::Transformation)),
    plain("TRANSMIT", &Unmodelled(Unmodelled::Transformation)),
    plain("CIP", &CircleThroughPoint),
    plain("CT", &TangentialCircle),
    plain("ASPLINE", &Curve),
    plain("BSPLINE", &Curve),
    plain("CSPLINE", &Curve),
    plain("POLY", &Curve),
    plain("INVCW", &Curve),
    plain("INVCCW", &Curve),
    plain("MSG", &Neutral),
    plain("COMPON", &Unmodelled(Unmodelled::Compressor)),
    plain("COMPCURV", &Unmodelled(Unmodelled::Compressor)),
    plain("COMPCAD", &Unmodelled(Unmodelled::Compressor)),
    plain("COMPOF", &Neutral),
    plain("SOFT", &Neutral),
    plain("BRISK", &Neutral),
    plain("DRIVE", &Neutral),
    plain("GOTOS", &Neutral),
    plain("SETAL", &Neutral),
    plain("NORM", &Neutral),
    plain("KONT", &Neutral),
    plain("KONTC", &Neutral),
    plain("KONTT", &Neutral),
    plain("SBLON", &Neutral),
    plain("SBLOF", &Neutral),
    plain("CFC", &Neutral),
    plain("CFTCP", &Neutral),
    plain("CFIN", &Neutral),
    plain("SETMS", &Neutral),
    plain("WORKPIECE", &Neutral),
    plain("REPOSA", &Neutral),
    plain("ROTS", &Unmodelled(Unmodelled::ToolFrame)),
    plain("AROTS", &Unmodelled(Unmodelled::ToolFrame)),
    plain("TOFFON", &Neutral),
    plain("TOROT", &Unmodelled(Unmodelled::ToolFrame)),
    plain("PAROT", &Unmodelled(Unmodelled::ToolFrame)),
    plain("OEMIPO1", &Curve),
    plain("SPCON", &Neutral),
    plain("SPCOF", &Neutral),
    plain("A3", &Unmodelled(Unmodelled::ToolDirection)),
    plain("OFFN", &Unmodelled(Unmodelled::ContourAllowance)),
    plain("FZ", &Unmodelled(Unmodelled::FeedPerTooth)),
    plain("POS", &Unmodelled(Unmodelled::PositioningAxis)),
    plain("X2", &Unmodelled(Unmodelled::FurtherAxis)),
    plain("WHEN", &Unmodelled(Unmodelled::SynchronizedAction)),
    plain("DIAMON", &Diameters),
    plain("DIAM90", &Diameters),
    plain("DIAMCYCA", &Diameters),
    plain("DIAMCYCOF", &Diameters),
    plain("CYCLE92", &TurningCycle),
    plain("CYCLE93", &TurningCycle),
    plain("CYCLE94", &TurningCycle),
    plain("CYCLE95", &TurningCycle),
    plain("CYCLE96", &TurningCycle),
    plain("CYCLE97", &TurningCycle),
    plain("CYCLE98", &TurningCycle),
    plain("CYCLE99", &TurningCycle),
    plain("CYCLE930", &TurningCycle),
    plain("CYCLE940", &TurningCycle),
    plain("CYCLE950", &TurningCycle),
    plain("CYCLE951", &TurningCycle),
    plain("CYCLE952", &TurningCycle),
    plain("$P_UIFR", &Unmodelled(Unmodelled::SystemFrame)),
];

/// Returns a row of the table with a statement that depends on its arguments.
const fn row(name: &'static str, kind: Kind) -> SiemensKeyword {
    SiemensKeyword { name, kind }
}

/// Returns a row of the table with a statement that does not depend on its arguments.
const fn plain(name: &'static str, statement: &'static SiemensStatement) -> SiemensKeyword {
    row(name, Kind::Plain(statement))
}
