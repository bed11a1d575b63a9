//! The state of a run: modal state, and the toolpath so far.

use crate::machine::Machine;
use crate::simulation::gcode::{ArcCenters, Dialect, Place, Program, Remarks, Statement};
use crate::simulation::interpreter::block::{Block, BlockWords};
use crate::simulation::interpreter::center::Centers;
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::compensation::CompensationWords;
use crate::simulation::interpreter::cycle::Cycles;
use crate::simulation::interpreter::doubt::OpenDoubts;
use crate::simulation::interpreter::fast::plain::PlainBlockState;
use crate::simulation::interpreter::feed_mode::Feed;
use crate::simulation::interpreter::frame::Frame;
use crate::simulation::interpreter::input_increment::Points;
use crate::simulation::interpreter::klartext::Klartext;
use crate::simulation::interpreter::path_mode::{PathModeState, PathWord};
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

/// The state of modal words.
pub(super) struct ModalState {
    pub(super) mode: Option<Mode>,
    /// Millimetres in the unit of length in force.
    pub(super) unit: f64,
    pub(super) is_incremental: bool,
    pub(super) has_incremental_center: bool,
    pub(super) feed: Feed,
    /// Feedrate by F under G94, mm/s.
    pub(super) feedrate: Option<f64>,
    pub(super) tool: Option<u32>,
    pub(super) has_work_offset: bool,
    pub(super) has_several_offsets: bool,
}

/// The requests of the G words of a block beyond the modal state.
pub(super) struct Request {
    pub(super) special: Option<(Special, Code)>,
    pub(super) exact_stop: bool,
    /// The action of the statements and G words of a SINUMERIK program.
    pub(super) siemens: Option<Box<SiemensAction>>,
    pub(super) path_words: Vec<(PathWord, Code, Place)>,
    pub(super) has_motion_word: bool,
    /// `true` if the axis words belong to a G word that is not run.
    pub(super) has_foreign_axis_words: bool,
    pub(super) has_m_word: bool,
    pub(super) work_offset: Option<(Code, Place)>,
    pub(super) tool_length: Option<Code>,
    /// The word of each modal group so far.
    pub(super) groups: [Option<Code>; 15],
}

/// The family of controls whose rules hold for words with two meanings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Family {
    /// RS274/NGC and LinuxCNC: G10 L20 names the position, G10 L2 R turns X Y, G52 is a G92 by its values, F holds
    /// along X Y Z.
    #[default]
    Rs274,
    /// Fanuc and Haas: G10 L20 gives the values of G54.1 Pn, G10 under G91 adds, F counts a degree of a rotary
    /// axis as a unit of length.
    Fanuc,
}

impl Family {
    /// Returns the family of a dialect.
    fn of(dialect: Dialect) -> Family {
        match dialect {
            // TNC controls too count a degree of a rotary axis as a millimetre.
            Dialect::Iso | Dialect::Okuma | Dialect::Klartext | Dialect::HeidenhainIso => Family::Fanuc,
            _ => Family::Rs274,
        }
    }
}

/// Functions that few programs need: for the statements and G words of Siemens programs, and splines.
#[derive(Clone, Copy)]
pub(super) struct Rare {
    pub(super) siemens_statement: fn(&mut Interpreter, Block, &Statement, &mut Option<Box<SiemensAction>>),
    pub(super) siemens_g_word: fn(&mut Interpreter, Block, Place, Code, SiemensWord, &mut Request),
    pub(super) siemens_act: fn(&mut Interpreter, Block, &SiemensAction),
    pub(super) siemens_after_move: fn(&mut Interpreter, Block),
    pub(super) spline_to: fn(&mut Interpreter, Block, Spline, Point),
    pub(super) end_nurbs: fn(&mut Interpreter, Block, Code),
}

/// Functions for Heidenhain programs, as pointers, so that a WebAssembly module without them does not include
/// their code.
pub(super) struct HeidenhainFunctions {
    /// Runs one block.
    pub(super) block: fn(&mut Interpreter, Block),
    /// Runs before each move.
    pub(super) before_move: fn(&mut Interpreter, Point, &Curve, f64),
    /// Completes the program at its end.
    pub(super) end: fn(&mut Interpreter),
}

/// The modal state, and the toolpath so far.
pub(super) struct Interpreter<'a> {
    pub(super) machine: &'a Machine,
    pub(super) rare: Rare,
    /// `true` if the program needs a rare function that is missing.
    pub(super) needs_rare_functions: bool,
    /// `true` if times without a decimal point are in milliseconds.
    pub(super) is_tape: bool,
    pub(super) modal: ModalState,
    /// The words of the block being run other than G and M.
    pub(super) given: BlockWords,
    pub(super) cycle: Cycles,
    /// The chain from program coordinates to the machine's.
    pub(super) frame: Frame,
    /// End of the last probing move, mm.
    pub(super) probed: Option<Point>,
    pub(super) rotary: Rotary,
    pub(super) family: Family,
    pub(super) dialect: Dialect,
    pub(super) siemens: Siemens,
    pub(super) vendor: VendorState,
    pub(super) spline: SplineState,
    pub(super) klartext: Klartext,
    pub(super) heidenhain: Option<HeidenhainFunctions>,
    /// The state for plain blocks while only those are run; `None` if it is to be determined.
    pub(super) plain: Option<PlainBlockState>,
    /// `true` if plain blocks are run by the fast path.
    pub(super) takes_fast_path: bool,
    pub(super) functions: Functions,
    pub(super) path_mode: PathModeState,
    /// The M word that ended the program.
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
    /// Returns the state before the first block of `program`.
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
            needs_rare_functions: false,
            is_tape: is_tape || dialect == Dialect::Okuma,
            modal: ModalState {
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
            path_mode: PathModeState::default(),
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

/// Returns the way in which cutter compensation begins.
fn lead_in(dialect: Dialect) -> LeadIn {
    match dialect {
        Dialect::Iso | Dialect::Okuma | Dialect::Siemens => LeadIn::SquareToNext,
        _ => LeadIn::SquareToItself,
    }
}
