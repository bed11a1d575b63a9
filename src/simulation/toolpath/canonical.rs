//! The canonical machining functions: the commands of an interpreter to a machine, whatever the dialect of the
//! program.
//!
//! | function | RS274/NGC | what it does |
//! |---|---|---|
//! | [`straight_traverse`](Canonical::straight_traverse) | STRAIGHT_TRAVERSE | goes straight to a point in rapid |
//! | [`straight_feed`](Canonical::straight_feed) | STRAIGHT_FEED | goes straight to a point at a feedrate |
//! | [`arc_feed`](Canonical::arc_feed) | ARC_FEED | goes along an arc or helix at a feedrate |
//! | [`nurbs_feed`](Canonical::nurbs_feed) | NURBS_FEED of LinuxCNC | goes along a curve at a feedrate |
//! | [`turn_rotary_axes`](Canonical::turn_rotary_axes) | STRAIGHT_TRAVERSE, STRAIGHT_FEED | turns rotary axes alone |
//! | [`dwell`](Canonical::dwell) | DWELL | waits |
//! | [`change_tool`](Canonical::change_tool) | CHANGE_TOOL | brings a tool into the spindle |
//! | [`turn_spindle`](Canonical::turn_spindle) | START_SPINDLE_CLOCKWISE and so on, STOP_SPINDLE_TURNING, ORIENT_SPINDLE | starts, stops or orients the spindle |
//! | [`set_spindle_speed`](Canonical::set_spindle_speed) | SET_SPINDLE_SPEED | changes the speed of a running spindle |
//! | [`machine_function`](Canonical::machine_function) | FLOOD_ON, MIST_ON, PROGRAM_STOP, OPTIONAL_PROGRAM_STOP, PROGRAM_END and so on | any other M word |
//! | [`set_path_mode`](Canonical::set_path_mode) | SET_MOTION_CONTROL_MODE | chooses what holds at corners |
//! | [`exact_stop`](Canonical::exact_stop) | SET_MOTION_CONTROL_MODE | requests a full stop after each move of a block |
//! | [`plane`](Canonical::plane) | SELECT_PLANE | the plane of compensation and of corner treatments |
//! | [`set_compensation`](Canonical::set_compensation) | SET_CUTTER_RADIUS_COMPENSATION and so on | runs the path of the tool centre beside the contour |
//! | [`treat_next_corner`](Canonical::treat_next_corner) | | rounds or chamfers a corner |
//! | [`position`](Canonical::position) | GET_EXTERNAL_POSITION | where the program has the tool |
//!
//! These functions separate meaning from geometry: coordinates are those of the machine, in mm, feedrates in mm/s,
//! and no word of a program passes through them. Each function takes the program line that calls it.
//!
//! Source: NIST RS274/NGC (Kramer, Proctor, Messina 2000), Sect. 4 and Appendix D; LinuxCNC 2.9, `canon.hh`.

use crate::machine::SpindleState;
use crate::simulation::gcode::{Comment, LineNumber};
use crate::simulation::toolpath::compensation::{
    CompensationRemark, Contour, CornerTreatment, LeadIn, OuterCorner, Setting,
};
use crate::simulation::toolpath::nurbs::PathPiece;
use crate::simulation::toolpath::operations::operations;
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::{
    Arc, Blending, Curve, MIN_MOVE_MM, Motion, PathMode, Point, Rotation, Segment, Stop, StopCause, Toolpath,
    Vector,
};

/// Most segments that the moves kept back for compensation can become.
const MAX_SEGMENTS_KEPT_BACK: usize = 100;

/// The machine that an interpreter commands, with the toolpath that results.
pub(crate) struct Canonical {
    /// Programmed position, mm; a compensated tool is beside it.
    pub(crate) position: Point,
    /// The plane of compensation and of corner treatments.
    pub(crate) plane: Plane,
    /// `true` if each move from here on ends with a full stop.
    pub(crate) exact_stop: bool,
    /// `true` if that stop belongs to a cycle, not to the words of the program.
    pub(crate) stops_for_cycle: bool,
    /// The tool in the spindle, once a change has named it.
    tool: Option<u32>,
    spin: SpindleState,
    blending: Blending,
    contour: Contour,
    /// Indices of the path modes that were set while moves were kept back.
    early_modes: Vec<usize>,
    toolpath: Toolpath,
}

impl Canonical {
    /// Returns a machine at its zero point. The first move under cutter compensation ends as `lead_in` says.
    pub(crate) fn new(lead_in: LeadIn, toolpath: Toolpath) -> Canonical {
        Canonical {
            position: Point::origin(),
            plane: Plane::Xy,
            exact_stop: false,
            stops_for_cycle: false,
            tool: None,
            spin: SpindleState::default(),
            blending: Blending::Machine,
            contour: Contour::new(lead_in),
            early_modes: Vec::new(),
            toolpath,
        }
    }

    /// Reserves memory for a number of segments, if there is enough.
    pub(crate) fn reserve(&mut self, segments: usize) {
        self.toolpath.segments.try_reserve_exact(segments).ok();
    }

    /// Returns the toolpath so far; compensation may keep the last moves back.
    pub(crate) fn toolpath(&self) -> &Toolpath {
        &self.toolpath
    }

    /// Returns the number of segments so far.
    pub(crate) fn segment_count(&self) -> usize {
        self.toolpath.segments.len()
    }

    /// Returns the tool in the spindle, once a change has named it.
    pub(crate) fn tool(&self) -> Option<u32> {
        self.tool
    }

    /// Returns how the spindle turns.
    pub(crate) fn spin(&self) -> SpindleState {
        self.spin
    }

    /// Moves straight to `end`, over `length` (mm), in rapid, and turns the rotary axes with it. `modal_feedrate` (mm/s) is
    /// that of [`Motion::Rapid`].
    pub(crate) fn straight_traverse(
        &mut self,
        line: LineNumber,
        (end, length): (Point, f64),
        modal_feedrate: f64,
        rotation: Rotation,
    ) {
        let motion = Motion::Rapid { modal_feedrate };
        self.go(line, PathPiece { end, curve: Curve::Line, length }, motion, rotation);
    }

    /// Moves straight to `end`, over `length` (mm), at a feedrate (mm/s), and turns the rotary axes with it.
    pub(crate) fn straight_feed(
        &mut self,
        line: LineNumber,
        (end, length): (Point, f64),
        feedrate: f64,
        rotation: Rotation,
    ) {
        self.go(line, PathPiece { end, curve: Curve::Line, length }, Motion::Feed { feedrate }, rotation);
    }

    /// Moves along an arc to `end`, over `length` (mm), at a feedrate (mm/s), and turns the rotary axes with it.
    pub(crate) fn arc_feed(
        &mut self,
        line: LineNumber,
        (end, arc, length): (Point, std::sync::Arc<Arc>, f64),
        feedrate: f64,
        rotation: Rotation,
    ) {
        self.go(line, PathPiece { end, curve: Curve::Arc(arc), length }, Motion::Feed { feedrate }, rotation);
    }

    /// Moves along the biarcs of a curve at a feedrate (mm/s), and turns the rotary axes with the first.
    pub(crate) fn nurbs_feed(
        &mut self,
        line: LineNumber,
        pieces: Vec<PathPiece>,
        feedrate: f64,
        rotation: Rotation,
    ) {
        let mut rotation = rotation;
        for piece in pieces {
            if piece.length < MIN_MOVE_MM && !self.is_beside() {
                continue;
            }
            let rotation = std::mem::replace(&mut rotation, Rotation::NONE);
            self.go(line, piece, Motion::Feed { feedrate }, rotation);
        }
    }

    /// Moves straight to `end` while no compensation, corner treatment or exact stop is in force: the fast path of
    /// plain moves.
    #[inline]
    pub(crate) fn straight_plain(&mut self, line: LineNumber, (end, length): (Point, f64), motion: Motion) {
        let (start, curve, rotation) = (self.position, Curve::Line, Rotation::NONE);
        let (exact_stop, exact_path) = (false, false);
        let segment = Segment { start, end, curve, length, motion, rotation, exact_stop, exact_path, line };
        self.toolpath.segments.push(segment);
        self.position = end;
    }

    /// Ends each move from here on with the full stop of a cycle.
    pub(crate) fn stop_as_in_cycles(&mut self) {
        (self.exact_stop, self.stops_for_cycle) = (true, true);
    }

    #[inline]
    fn go(
        &mut self,
        line: LineNumber,
        PathPiece { end, curve, length }: PathPiece,
        motion: Motion,
        rotation: Rotation,
    ) {
        let (start, exact_stop) = (self.position, self.exact_stop);
        // RS274/NGC runs cycles in exact path mode, whatever mode the program is in.
        let exact_path = exact_stop && (self.blending == Blending::ExactPath || self.stops_for_cycle);
        let segment = Segment { start, end, curve, length, motion, rotation, exact_stop, exact_path, line };
        self.contour.add(segment, self.plane, &mut self.toolpath);
        self.position = end;
    }

    fn stop(&mut self, line: LineNumber, cause: StopCause) {
        let after = self.toolpath.segments.len();
        self.contour.stop(Stop { after, cause, line }, &mut self.toolpath);
    }

    /// Turns rotary axes alone by `rotation` (rad), at `rate` (rad/s) along all three, or in rapid.
    pub(crate) fn turn_rotary_axes(&mut self, line: LineNumber, rotation: Vector, rate: Option<f64>) {
        self.stop(line, StopCause::Rotary { rotation, rate });
    }

    /// Waits for a number of seconds.
    pub(crate) fn dwell(&mut self, line: LineNumber, seconds: f64) {
        self.stop(line, StopCause::Dwell { seconds });
    }

    /// Changes to a tool; `None` if the program does not number it. The spindle stops. Returns `false` if the tool
    /// is in the spindle already, which needs no change.
    pub(crate) fn change_tool(&mut self, line: LineNumber, tool: Option<u32>) -> bool {
        if let Some(present) = tool.filter(|_| tool == self.tool) {
            self.stop(line, StopCause::SameTool { tool: present });
            return false;
        }
        self.tool = tool;
        self.set_spin(SpindleState::AT_REST);
        self.stop(line, StopCause::ToolChange { tool });
        true
    }

    /// Turns the spindle as `to` says, and waits for it; `code` is the M word.
    pub(crate) fn turn_spindle(&mut self, line: LineNumber, to: SpindleState, code: u32) {
        let from = self.spin;
        self.set_spin(to);
        self.stop(line, StopCause::Spindle { from, to, code: Some(code) });
    }

    /// Changes the speed (rpm) of a running spindle, and waits for it if `waits`.
    pub(crate) fn set_spindle_speed(&mut self, line: LineNumber, speed: f64, waits: bool) {
        let from = self.spin;
        let to = SpindleState { speed, ..from };
        self.set_spin(to);
        if waits {
            self.stop(line, StopCause::Spindle { from, to, code: None });
        }
    }

    fn set_spin(&mut self, spin: SpindleState) {
        self.spin = spin;
        let after = self.toolpath.segments.len();
        let spins = &mut self.toolpath.spins;
        spins.pop_if(|known| known.0 == after);
        spins.push((after, spin));
    }

    /// Runs any other M word, such as coolant, stops and the end of the program.
    pub(crate) fn machine_function(&mut self, line: LineNumber, code: u32) {
        self.stop(line, StopCause::MCode { code });
    }

    /// Sets the path mode from the next segment on, unless it is in force already. `source` are the words that set
    /// it, `merging` the distance within which lines are merged, mm.
    pub(crate) fn set_path_mode(
        &mut self,
        line: LineNumber,
        source: &str,
        blending: Blending,
        merging: Option<f64>,
    ) {
        self.blending = blending;
        let from = self.toolpath.segments.len();
        let modes = &mut self.toolpath.path_modes;
        modes.pop_if(|last| last.from == from);
        let is_in_force = match modes.last() {
            Some(last) => last.blending == blending && last.source == source && last.merging == merging,
            None => blending == Blending::Machine && merging.is_none(),
        };
        if !is_in_force {
            if self.contour.keeps_back() {
                self.early_modes.push(modes.len());
            }
            modes.push(PathMode { from, line, source: source.to_string(), blending, merging });
        }
    }

    /// Corrects the first segment of modes that were set while compensation kept moves back: a move of an earlier
    /// line than the mode comes out after it.
    fn settle_path_modes(&mut self) {
        let Toolpath { segments, path_modes, .. } = &mut self.toolpath;
        let mut first = 0;
        for index in std::mem::take(&mut self.early_modes) {
            let Some(mode) = path_modes.get_mut(index) else { continue };
            let from = mode.from.max(first);
            let kept_back = segments.range(from..segments.len()).take(MAX_SEGMENTS_KEPT_BACK);
            mode.from = from + kept_back.take_while(|segment| segment.line < mode.line).count();
            first = mode.from;
        }
    }

    /// Returns the compensation in force.
    pub(crate) fn compensation(&self) -> Option<Setting> {
        self.contour.setting()
    }

    /// Sets the compensation from the next move on, or ends it.
    pub(crate) fn set_compensation(&mut self, setting: Option<Setting>) {
        self.contour.set(setting, &mut self.toolpath);
    }

    /// Sets the compensation from the next move on; the tool is at its distance from the contour already, at `at`.
    pub(crate) fn begin_beside(&mut self, setting: Setting, at: Point) {
        self.contour.begin_beside(setting, at, &mut self.toolpath);
    }

    /// Ends the compensation without a move: the position of the tool becomes the programmed one.
    pub(crate) fn end_compensation_in_place(&mut self) {
        self.contour.set(None, &mut self.toolpath);
        if let Some(at) = self.contour.take_offset_position() {
            self.position = at;
        }
    }

    /// Returns `true` if the tool is beside the programmed position, so that even a move of no length moves it.
    pub(crate) fn is_beside(&self) -> bool {
        self.contour.is_beside()
    }

    /// Returns `true` if moves come out unchanged and at once.
    pub(crate) fn is_idle(&self) -> bool {
        self.contour.is_idle()
    }

    /// Sets how the compensated tool passes outer corners from here on.
    pub(crate) fn set_outer_corner_rule(&mut self, outer_corner: OuterCorner) {
        self.contour.set_outer_corner_rule(outer_corner);
    }

    /// Treats the corner between the last move and the next one.
    pub(crate) fn treat_next_corner(&mut self, treatment: CornerTreatment) {
        self.contour.treat_next_corner(treatment, self.plane, &mut self.toolpath);
    }

    /// Treats every corner between two feed moves from here on; `None` ends that.
    pub(crate) fn treat_every_corner(&mut self, treatment: Option<CornerTreatment>) {
        self.contour.treat_every_corner(treatment);
    }

    /// Takes the remarks on compensation and corner treatments since the last call: where they deviate from a
    /// control.
    #[inline]
    pub(crate) fn take_remarks(&mut self) -> Vec<(LineNumber, CompensationRemark)> {
        self.contour.take_remarks()
    }

    /// Writes out the moves kept back, and cuts the toolpath into operations by the comments of the program.
    /// Returns the number of operations beyond the most that are kept.
    pub(crate) fn finish(&mut self, comments: &[Comment]) -> usize {
        self.contour.finish(&mut self.toolpath);
        self.settle_path_modes();
        let (operations, beyond) = operations(&self.toolpath.segments, &self.toolpath.stops, comments);
        self.toolpath.operations = operations;
        beyond
    }

    /// Returns the toolpath.
    pub(crate) fn into_toolpath(self) -> Toolpath {
        self.toolpath
    }
}
