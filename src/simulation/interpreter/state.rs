//! The state of a run: what stays in force from block to block, and what came out so far.

use crate::machine::Machine;
use crate::simulation::gcode::{ArcCenters, Dialect, Place, Program, Remarks, Statement};
use crate::simulation::interpreter::block::{Block, BlockWords};
use crate::simulation::interpreter::center::Centers;
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::compensation::CompensationWords;
use crate::simulation::interpreter::cycle::Cycles;
use crate::simulation::interpreter::doubt::OpenDoubts;
use crate::simulation::interpreter::fast::plain::Plain;
use crate::simulation::interpreter::feed_mode::Feed;
use crate::simulation::interpreter::frame::Frame;
use crate::simulation::interpreter::input_increment::Points;
use crate::simulation::interpreter::klartext::Klartext;
use crate::simulation::interpreter::path_mode::{InForce, PathWord};
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::rotary::Rotary;
use crate::simulation::interpreter::siemens::{Siemens, SiemensAction, SiemensWord};
use crate::simulation::interpreter::spindle_and_tool::Functions;
use crate::simulation::interpreter::spline::{Spline, SplineState};
use crate::simulation::interpreter::turning::Turning;
use crate::simulation::interpreter::vendor_codes::VendorState;
use crate::simulation::interpreter::words::{Mode, Special};
use crate::simulation::toolpath::canonical::Canonical;
use crate::simulation::toolpath::compensation::LeadIn;
use crate::simulation::toolpath::{Curve, Point, Toolpath};

/// What stays in force from block to block.
pub(super) struct Modal {
    pub(super) mode: Option<Mode>,
    /// Millimetres in the unit of length in force.
    pub(super) unit: f64,
    pub(super) is_incremental: bool,
    pub(super) has_incremental_center: bool,
    pub(super) feed: Feed,
    /// By F under G94, mm/s.
    pub(super) feedrate: Option<f64>,
    pub(super) tool: Option<u32>,
    pub(super) has_work_offset: bool,
    pub(super) has_several_offsets: bool,
}

/// What the G words of a block ask for beyond the modal state.
pub(super) struct Request {
    pub(super) special: Option<(Special, Code)>,
    pub(super) exact_stop: bool,
    /// What the statements and G words of a SINUMERIK program ask for.
    pub(super) siemens: Option<Box<SiemensAction>>,
    pub(super) path_words: Vec<(PathWord, Code, Place)>,
    pub(super) has_motion_word: bool,
    /// The axis words belong to a G word that is not run.
    pub(super) has_foreign_axis_words: bool,
    pub(super) has_m_word: bool,
    pub(super) work_offset: Option<(Code, Place)>,
    pub(super) tool_length: Option<Code>,
    /// The word of each modal group so far.
    pub(super) groups: [Option<Code>; 15],
}

/// Whose rules hold where controls read the same word in two ways.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Family {
    /// RS274/NGC and LinuxCNC: G10 L20 names the position, G10 L2 R turns X Y, G52 is a G92 by
    /// its values, F holds along X Y Z.
    #[default]
    Rs274,
    /// Fanuc and Haas: G10 L20 gives the values of G54.1 Pn, G10 under G91 adds, F counts a degree
    /// of a rotary axis as a unit of length.
    Fanuc,
}

impl Family {
    fn of(dialect: Dialect) -> Family {
        match dialect {
            // TNC controls too count a degree of a rotary axis as a millimetre.
            Dialect::Iso | Dialect::Okuma | Dialect::Klartext | Dialect::HeidenhainIso => Family::Fanuc,
            _ => Family::Rs274,
        }
    }
}

/// What few programs need: the statements and G words of Siemens programs, and splines.
#[derive(Clone, Copy)]
pub(super) struct Rare {
    pub(super) siemens_statement: fn(&mut Interpreter, Block, &Statement, &mut Option<Box<SiemensAction>>),
    pub(super) siemens_g_word: fn(&mut Interpreter, Block, Place, Code, SiemensWord, &mut Request),
    pub(super) siemens_act: fn(&mut Interpreter, Block, &SiemensAction),
    pub(super) siemens_after_move: fn(&mut Interpreter, Block),
    pub(super) spline_to: fn(&mut Interpreter, Block, Spline, Point),
    pub(super) end_nurbs: fn(&mut Interpreter, Block, Code),
}

/// What is done otherwise in Heidenhain programs. Handed over as functions, so that a module that runs none of them does
/// not carry what they need.
pub(super) struct Heidenhain {
    /// Runs one block.
    pub(super) block: fn(&mut Interpreter, Block),
    /// Takes notice of a move before it is made.
    pub(super) before_move: fn(&mut Interpreter, Point, &Curve, f64),
    /// Does what is left at the end of the program.
    pub(super) end: fn(&mut Interpreter),
}

/// The modal state, and what came out so far.
pub(super) struct Interpreter<'a> {
    pub(super) machine: &'a Machine,
    pub(super) rare: Rare,
    /// Some of it was asked for that is not here.
    pub(super) needs_rare: bool,
    /// Times without a point are in milliseconds.
    pub(super) is_tape: bool,
    pub(super) modal: Modal,
    pub(super) given: BlockWords,
    pub(super) cycle: Cycles,
    /// From program coordinates to the machine's.
    pub(super) frame: Frame,
    /// Where the last probing move ended, mm.
    pub(super) probed: Option<Point>,
    pub(super) rotary: Rotary,
    pub(super) family: Family,
    pub(super) dialect: Dialect,
    pub(super) siemens: Siemens,
    pub(super) vendor: VendorState,
    pub(super) spline: SplineState,
    pub(super) klartext: Klartext,
    pub(super) heidenhain: Option<Heidenhain>,
    /// As long as nothing else is run than plain blocks, or `None` if it is to be looked for.
    pub(super) plain: Option<Plain>,
    /// Plain blocks are run by the fast path.
    pub(super) takes_fast_path: bool,
    pub(super) functions: Functions,
    pub(super) path_mode: InForce,
    pub(super) ended: Option<Code>,
    pub(super) compensation: CompensationWords,
    pub(super) points: Points,
    pub(super) turning: Turning,
    pub(super) doubts: OpenDoubts,
    pub(super) centers: Centers,
    /// The machine that the program commands.
    pub(super) canonical: Canonical,
    pub(super) remarks: Remarks<TraceRemark>,
}

impl<'a> Interpreter<'a> {
    /// Before the first block of `program`.
    pub(super) fn new(
        machine: &'a Machine,
        program: &Program,
        centers: Centers,
        rare: Rare,
    ) -> Interpreter<'a> {
        let Program { dialect, is_tape, arc_centers, .. } = *program;
        Interpreter {
            machine,
            rare,
            needs_rare: false,
            is_tape: is_tape || dialect == Dialect::Okuma,
            modal: Modal {
                mode: None,
                unit: 1.0,
                is_incremental: false,
                has_incremental_center: !centers.are_absolute() && arc_centers != Some(ArcCenters::Absolute),
                feed: Feed::default(),
                feedrate: None,
                tool: None,
                has_work_offset: false,
                has_several_offsets: false,
            },
            given: BlockWords::default(),
            cycle: Cycles::default(),
            frame: Frame::new(machine),
            probed: None,
            rotary: Rotary::default(),
            family: Family::of(dialect),
            dialect,
            siemens: Siemens::default(),
            vendor: VendorState::default(),
            spline: SplineState::default(),
            klartext: Klartext::default(),
            heidenhain: None,
            plain: None,
            takes_fast_path: true,
            functions: Functions::default(),
            path_mode: InForce::default(),
            ended: None,
            compensation: CompensationWords::default(),
            points: Points::default(),
            turning: Turning::default(),
            doubts: OpenDoubts::default(),
            centers,
            canonical: Canonical::new(lead_in(dialect), Toolpath { dialect, ..Toolpath::default() }),
            remarks: Remarks::default(),
        }
    }
}

/// How cutter compensation begins.
fn lead_in(dialect: Dialect) -> LeadIn {
    match dialect {
        Dialect::Iso | Dialect::Okuma | Dialect::Siemens => LeadIn::SquareToNext,
        _ => LeadIn::SquareToItself,
    }
}
