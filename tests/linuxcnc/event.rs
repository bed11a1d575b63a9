//! What a program does, in one form for both interpreters: moves, dwells, tool changes and
//! M-words in order, in mm, mm/min and machine coordinates. Rotary axes are left out.

use truefeed::machine::Machine;
use truefeed::simulation::gcode::{Dialect, Options, read_with};
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::toolpath::{Curve, Motion, Point, Segment, StopCause, Toolpath};

/// The M-words that both report: stops, end, spindle, coolant, pallet. M30 counts as M2, since
/// LinuxCNC reports the end of a program in one way.
const M_WORDS: &[u32] = &[0, 1, 2, 3, 4, 5, 7, 8, 9, 19, 30, 60];

/// One thing that happens.
#[derive(Clone, Debug, PartialEq)]
pub enum Deed {
    Move(Move),
    /// s.
    Dwell(f64),
    ToolChange(Option<u32>),
    MWord(u32),
}

/// One move.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// Where it begins and ends, mm.
    pub start: Point,
    pub end: Point,
    /// mm/min; none in rapid.
    pub feedrate: Option<f64>,
    /// None for a straight line.
    pub arc: Option<Circle>,
    /// The control halts at its end, or at least does not round it off.
    pub is_exact: bool,
}

/// The circle of an arc or helix.
#[derive(Clone, Debug, PartialEq)]
pub struct Circle {
    /// In the plane of its start, mm.
    pub center: Point,
    /// Direction of its normal: X, Y or Z.
    pub normal: usize,
    /// Angle run through, rad; positive counter-clockwise.
    pub sweep: f64,
}

/// A deed and where it stands: for us the line of the program, for LinuxCNC that of its output.
#[derive(Clone, Debug)]
pub struct Event {
    pub deed: Deed,
    pub line: u32,
}

impl Move {
    /// Chord, mm; of a closed arc the diameter.
    pub fn size(&self) -> f64 {
        let chord = (self.end - self.start).norm();
        match &self.arc {
            Some(arc) if 1.0 < arc.sweep.abs() => chord.max(2.0 * (self.start - arc.center).norm()),
            _ => chord,
        }
    }
}

impl std::fmt::Display for Deed {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Deed::Move(step) => {
                let shape = match (&step.arc, step.feedrate) {
                    (None, None) => "rapid",
                    (None, _) => "line",
                    _ => "arc",
                };
                let [x, y, z] = [step.end.x, step.end.y, step.end.z];
                write!(formatter, "{shape} to X{x:.5} Y{y:.5} Z{z:.5}")?;
                if let Some(arc) = &step.arc {
                    let ([x, y, z], normal) = ([arc.center.x, arc.center.y, arc.center.z], arc.normal);
                    let (normal, degrees) = (["X", "Y", "Z"][normal], arc.sweep.to_degrees());
                    write!(formatter, " around X{x:.5} Y{y:.5} Z{z:.5}, {degrees:.3}° about {normal}")?;
                }
                if let Some(feedrate) = step.feedrate {
                    write!(formatter, " at {feedrate:.4} mm/min")?;
                }
                if step.is_exact { write!(formatter, ", exactly") } else { Ok(()) }
            }
            Deed::Dwell(seconds) => write!(formatter, "dwell of {seconds} s"),
            Deed::ToolChange(Some(tool)) => write!(formatter, "change to tool {tool}"),
            Deed::ToolChange(None) => write!(formatter, "tool change"),
            Deed::MWord(code) => write!(formatter, "M{code}"),
        }
    }
}

/// Our toolpath of a program for LinuxCNC, on a machine whose reference point is its zero point, as it is for
/// LinuxCNC when no parameter file says otherwise.
pub fn traced(program: &[u8]) -> Toolpath {
    let mut machine = Machine::default();
    machine.axes.iter_mut().for_each(|axis| axis.home = Some(0.0));
    let options = Options { dialect: Some(Dialect::LinuxCnc), ..Options::default() };
    trace(&read_with(program, &options), &machine)
}

/// What happens on it.
pub fn events(toolpath: &Toolpath) -> Vec<Event> {
    let mut events = Vec::new();
    let mut stops = toolpath.stops.iter().peekable();
    for index in 0..=toolpath.segments.len() {
        while let Some(stop) = stops.next_if(|stop| stop.after <= index) {
            events.extend(deed_of_stop(stop.cause).map(|deed| Event { deed, line: stop.line.0 }));
        }
        if let Some(segment) = toolpath.segments.get(index) {
            events.push(Event { deed: Deed::Move(move_of(&segment)), line: segment.line.0 });
        }
    }
    events
}

fn deed_of_stop(cause: StopCause) -> Option<Deed> {
    match cause {
        StopCause::Dwell { seconds } => Some(Deed::Dwell(seconds)),
        StopCause::ToolChange { tool } => Some(Deed::ToolChange(tool)),
        StopCause::SameTool { tool } => Some(Deed::ToolChange(Some(tool))),
        StopCause::Spindle { code, .. } => code.map(Deed::MWord),
        StopCause::MCode { code } if M_WORDS.contains(&code) => {
            Some(Deed::MWord(if code == 30 { 2 } else { code }))
        }
        StopCause::MCode { .. } | StopCause::Rotary { .. } => None,
    }
}

fn move_of(segment: &Segment) -> Move {
    let feedrate = match segment.motion {
        Motion::Rapid { .. } => None,
        Motion::Feed { feedrate } => Some(60.0 * feedrate),
    };
    let arc = match &segment.curve {
        Curve::Line => None,
        Curve::Arc(arc) => {
            let normal = arc.e1.cross(&arc.e2);
            let axis = normal.iamax();
            Some(Circle { center: arc.center, normal: axis, sweep: arc.sweep * normal[axis].signum() })
        }
    };
    Move { start: segment.start, end: segment.end, feedrate, arc, is_exact: segment.exact_stop }
}
