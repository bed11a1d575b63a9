//! Execution of the statements of SINUMERIK programs.

use crate::machine::AXES;
use crate::simulation::gcode::{
    FrameChange, Keyword, Place, SiemensStatement, Statement, Unmodelled, address,
};
use crate::simulation::interpreter::block::{AXIS_WORDS, Block, POLAR_WORDS};
use crate::simulation::interpreter::bounds::{FEEDRATES_MM_S, SCALE_FACTORS};
use crate::simulation::interpreter::frame::{Affine, Kind};
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::siemens::SiemensAction;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::interpreter::turning::Sign;
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::{Blending, Curve, Motion, Point, Vector};

/// The one operation on coordinates of SINUMERIK programs.
const FRAME_KIND: Kind = Kind::Rotation;

const TURNED_PLANE: &str = "a swivelled plane is not modelled: lengths in it are right, but the time to swivel and the moves to the next plane are wrong";
const SHIFTED_PLANE: &str =
    "the shift of its origin is not modelled: the first move after it is too short or too long";
const DIAMETERS: &str = "X in diameters is not modelled: moves are taken as written";

/// Returns the consequence for the time of a statement without a model, and the names of its group if it has
/// several.
fn consequence(what: Unmodelled) -> (Option<&'static str>, &'static str) {
    match what {
        Unmodelled::Orientation => (
            None,
            "the path and feed of the tool tip are taken as written; the motion of the head is not modelled",
        ),
        Unmodelled::Transformation => {
            (None, "the transformation is not modelled: moves are taken as written")
        }
        Unmodelled::Compressor => {
            (None, "the compressor, which joins short blocks, is not modelled: each block is run as written")
        }
        Unmodelled::Measuring => (
            None,
            "measuring is not modelled: its move is run over the full travel, which the machine ends at the contact",
        ),
        Unmodelled::ToolDirection => (
            Some("A3, B3, C3, LEAD, TILT"),
            "the direction of the tool is not modelled: the path of its tip is taken as written, the turning of the head is not timed",
        ),
        Unmodelled::SynchronizedAction => {
            (Some("WHEN, WHENEVER, EVERY, DO"), "synchronized actions are not modelled: left out")
        }
        Unmodelled::SystemFrame => (
            Some("$P_UIFR and the like"),
            "frames by system variables are not applied: moves to and from the offset are too short or too long",
        ),
        Unmodelled::ContourAllowance => (None, "the allowance is not modelled: the path is taken without it"),
        Unmodelled::FeedPerTooth => (None, "a feed per tooth needs the number of teeth: F in force is taken"),
        Unmodelled::PositioningAxis => {
            (Some("POS, POSA"), "positioning axes are not modelled: their moves are missing from the time")
        }
        Unmodelled::FurtherAxis => (
            Some("axes with a number beyond 1"),
            "only X, Y, Z, A, B and C are modelled: their moves are missing from the time",
        ),
        Unmodelled::ToolFrame => (None, "this frame is not modelled: coordinates are taken as written"),
    }
}

impl Interpreter<'_> {
    /// Reads a statement.
    pub(crate) fn siemens_statement(
        &mut self,
        block: Block,
        statement: &Statement,
        action: &mut Option<Box<SiemensAction>>,
    ) {
        let Keyword::Siemens(keyword) = statement.keyword else { return };
        let (name, place) = (keyword.name, statement.place(block.line));
        let read = match keyword.with(block.arguments_of(statement)) {
            SiemensStatement::ModalCall => SiemensAction::Modal(None),
            SiemensStatement::Drilling(cycle) => match action.as_deref() {
                Some(SiemensAction::Modal(_)) => SiemensAction::Modal(Some(cycle)),
                _ => SiemensAction::Cycle(cycle),
            },
            SiemensStatement::Holes(pattern) => SiemensAction::Holes(pattern),
            SiemensStatement::Frame { change, is_added } => SiemensAction::Frame { change, is_added },
            SiemensStatement::MachineCoordinates => SiemensAction::MachineCoordinates,
            SiemensStatement::CircleThroughPoint => SiemensAction::Through,
            SiemensStatement::TangentialCircle => SiemensAction::Tangential,
            SiemensStatement::ContourTolerance { tolerance, is_off } => {
                return self.siemens_tolerance(place, tolerance, is_off);
            }
            SiemensStatement::SwivelPlane { turns: true, .. } => {
                return self.no_model(place, name, TURNED_PLANE);
            }
            SiemensStatement::SwivelPlane { shifts: true, .. } => {
                return self.no_model(place, name, SHIFTED_PLANE);
            }
            SiemensStatement::MillingCycle => {
                return self.remarks.add(place, TraceRemark::MillingCycle { name });
            }
            SiemensStatement::TurningCycle => {
                return self.turning.note(Sign::TurningCycle, block.line, || name.to_string());
            }
            SiemensStatement::Diameters => {
                self.turning.note(Sign::Diameters, block.line, || name.to_string());
                return self.no_model(place, name, DIAMETERS);
            }
            SiemensStatement::Curve => return self.remarks.add(place, TraceRemark::Curve { name }),
            SiemensStatement::Unmodelled(what) => {
                let (names, what) = consequence(what);
                return self.no_model(place, names.unwrap_or(name), what);
            }
            SiemensStatement::SwivelPlane { .. } | SiemensStatement::Neutral => return,
        };
        *action = Some(Box::new(read));
    }

    /// Remarks on a statement without a model.
    pub(super) fn no_model(&mut self, place: Place, name: &'static str, what: &'static str) {
        self.remarks.add(place, TraceRemark::Statement { name, what });
    }

    /// Runs CYCLE832, with a tolerance in the unit of the program.
    fn siemens_tolerance(&mut self, place: Place, tolerance: f64, is_off: bool) {
        let source = format!("CYCLE832({tolerance})");
        let mut blending = Blending::Machine;
        if !is_off {
            blending = Blending::Within(tolerance * self.modal.unit);
            // The cycle includes a continuous-path mode.
            self.set_continuous_path(place, source.clone());
        }
        self.set_tolerance(place, source, blending);
    }

    /// Runs the action of the statements of a block.
    pub(crate) fn siemens_act(&mut self, block: Block, action: &SiemensAction) {
        match action {
            SiemensAction::Frame { change, is_added } => self.siemens_frame(block, *change, *is_added),
            SiemensAction::Modal(cycle) => self.siemens.modal = *cycle,
            SiemensAction::Cycle(cycle) => self.siemens_hole(block, cycle),
            SiemensAction::Holes(pattern) => self.siemens_holes(block, pattern),
            SiemensAction::Through => self.arc_through(block),
            SiemensAction::Tangential => self.tangential_arc(block),
            SiemensAction::Pole(code) => self.set_pole(block, *code),
            SiemensAction::Thread(turn) => self.thread_stroke(block, *turn),
            SiemensAction::FloatingTap => {
                self.canonical.exact_stop = true;
                if let Some(target) = self.target(block) {
                    self.feed_to(block, target);
                }
            }
            SiemensAction::MachineCoordinates => {
                self.uncompensated(|interpreter| interpreter.machine_coordinates(block));
            }
        }
    }

    /// Runs TRANS, ROT, SCALE, MIRROR, and these with an A before them.
    fn siemens_frame(&mut self, block: Block, change: FrameChange, is_added: bool) {
        let unit = self.modal.unit;
        if !is_added {
            self.frame.unset(FRAME_KIND);
        }
        let values = AXES.map(|axis| self.given.get(axis as u8));
        let operation = match change {
            FrameChange::Shift => {
                let shift = Vector::from(values.map(|value| value.unwrap_or(0.0) * unit));
                if !self.is_within_reach(block, 'X', shift.amax()) {
                    return;
                }
                Affine::shift(shift)
            }
            FrameChange::Scaling => {
                let factors = values.map(|factor| factor.unwrap_or(1.0));
                if !factors.iter().all(|factor| SCALE_FACTORS.contains(&factor.abs())) {
                    self.remarks.add(block.place(), TraceRemark::BadScale);
                    return;
                }
                Affine::scaling(Point::origin(), factors)
            }
            FrameChange::Mirror => Affine::mirror(values.map(|value| value.map(|_| 0.0))),
            FrameChange::Rotation => self.siemens_rotation(values),
        };
        self.frame.compose(FRAME_KIND, operation);
    }

    /// Returns the rotation by RPL in the plane in force, or about Z, Y and X in turn (RPY angles).
    fn siemens_rotation(&self, values: [Option<f64>; 3]) -> Affine {
        if let Some(angle) = self.given.get(address::PLANE_ANGLE) {
            return Affine::rotation(self.canonical.plane, Point::origin(), angle.to_radians());
        }
        let [x, y, z] = values.map(|value| value.unwrap_or(0.0).to_radians());
        let about = |plane, angle| Affine::rotation(plane, Point::origin(), angle);
        about(Plane::Xy, z).after(&about(Plane::Zx, y)).after(&about(Plane::Yz, x))
    }

    /// Runs G331, G332 and G33: the feedrate is the pitch (I, J or K of the axis) times the spindle speed.
    fn thread_stroke(&mut self, block: Block, turn: Option<u32>) {
        let pitch = b"IJK".iter().find_map(|letter| self.given.get(*letter));
        if let Some(pitch) = pitch {
            self.siemens.pitch = Some(pitch.abs() * self.modal.unit);
        }
        let speed = self.given.get(b'S').or(self.functions.speed);
        let Some(target) = self.target(block) else { return };
        let length = (target - self.canonical.position).norm();
        match self.siemens.pitch.zip(speed).map(|(pitch, speed)| pitch * speed / 60.0) {
            Some(feedrate) if FEEDRATES_MM_S.contains(&feedrate) => {
                self.canonical.exact_stop |= turn.is_some();
                self.push(block, target, Curve::Line, length, Motion::Feed { feedrate });
                if let Some(turn) = turn {
                    self.turn_spindle(block, turn);
                }
            }
            _ => {
                self.remarks.add(block.place(), TraceRemark::NoTapFeed);
                self.feed_to(block, target);
            }
        }
    }

    /// Makes the hole of a modal call after a move.
    pub(crate) fn siemens_after_move(&mut self, block: Block) {
        self.check_angle(block);
        let moves = self.given.has(AXIS_WORDS | POLAR_WORDS);
        if let (true, Some(drilling)) = (moves, self.siemens.modal) {
            self.siemens_hole(block, &drilling);
        }
    }
}
