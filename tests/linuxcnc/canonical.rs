//! LinuxCNC's interpreter by its command `rs274 -g`: what it prints, and what that means.
//!
//! It prints one canonical command a line, with lengths in the unit in force (G20 or G21), four
//! decimals each. Positions are those of the program, p; the offsets it prints beside them, in
//! the same unit, make machine coordinates of them, as in LinuxCNC's `emccanon.cc`:
//!
//! ```text
//! m = tool + g5x + R (p + g92)
//! ```
//!
//! R the rotation about Z. We know no tool but by G10 L1, so the tool table it is given has no
//! lengths and no diameters either.
//!
//! An arc is `(first end, second end, first centre, second centre, turns, end on the normal, …)`
//! in the plane in force: XY, ZX (first is Z) or YZ; turns are positive counter-clockwise, and
//! ±1 is at most one full turn.
//!
//! Tapping, which is known by its disabling the override of the speed, turns the spindle round
//! (M5 and M4) before the dwell at the bottom; our toolpath has the dwell first, as other controls
//! do. That takes the same time, and is compared as if it were in our order.
//!
//! Of what it does by itself at M2 and M30 (offsets back to G54, spindle off), and at M6 (spindle
//! off), nothing counts but the word.

use crate::linuxcnc::event::{Circle, Deed, Event, Move};
use std::f64::consts::TAU;
use std::process::{Command, Stdio};
use truefeed::simulation::toolpath::{Point, Vector};

/// What LinuxCNC makes of a program.
pub struct Run {
    pub events: Vec<Event>,
    /// What it prints when it does not run the program to its end.
    pub refusal: Option<String>,
    /// How far a printed coordinate may be from the true one, mm.
    pub rounding: f64,
}

/// Whether `rs274` is there.
pub fn is_installed() -> bool {
    Command::new("rs274").arg("-h").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
}

/// Runs a program with it, in a folder of its own, since it writes its parameters to a file.
pub fn run(program: &[u8]) -> Run {
    static NUMBER: std::sync::atomic::AtomicUsize = std::sync::atomic::AtomicUsize::new(0);
    let number = NUMBER.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("truefeed-rs274-{}-{number}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a writable folder for temporary files");
    std::fs::write(folder.join("program.ngc"), program).expect("a writable folder");
    let tools: String = (1..=20).map(|tool| format!("T{tool} P{tool} Z0 D0\n")).collect();
    std::fs::write(folder.join("tools.tbl"), tools).expect("a writable folder");
    let output = Command::new("rs274")
        .args(["-g", "-t", "tools.tbl", "-v", "parameters.var", "program.ngc"])
        .current_dir(&folder)
        // It keeps its tool table in a file there, which two runs at a time would share.
        .env("HOME", &folder)
        .stdin(Stdio::null())
        .output()
        .expect("rs274 starts");
    std::fs::remove_dir_all(&folder).expect("the folder is ours");
    let said = String::from_utf8_lossy(&output.stderr);
    let said = said.lines().filter(|line| *line != "executing" && !line.starts_with("link ("));
    let refusal = (!output.status.success()).then(|| said.collect::<Vec<_>>().join(" | "));
    let mut control = Control::default();
    for (index, line) in String::from_utf8_lossy(&output.stdout).lines().enumerate() {
        control.command(line, index as u32 + 1);
    }
    Run { events: control.events, refusal, rounding: control.rounding }
}

/// The state behind the printed commands.
struct Control {
    /// mm.
    unit: f64,
    /// Axes of the plane: first, second, normal.
    plane: [usize; 3],
    tool: Vector,
    g5x: Vector,
    g92: Vector,
    /// rad.
    rotation: f64,
    position: Point,
    /// As printed, and the speed it is multiplied by under G95.
    feed: f64,
    speed: f64,
    is_per_revolution: bool,
    is_exact: bool,
    is_changing_tool: bool,
    is_shuttling: bool,
    is_tapping: bool,
    /// How many events there were when G5x was last set.
    before_offset: usize,
    rounding: f64,
    events: Vec<Event>,
}

impl Default for Control {
    fn default() -> Control {
        Control {
            unit: 1.0,
            plane: [0, 1, 2],
            tool: Vector::zeros(),
            g5x: Vector::zeros(),
            g92: Vector::zeros(),
            rotation: 0.0,
            position: Point::origin(),
            feed: 0.0,
            speed: 0.0,
            is_per_revolution: false,
            is_exact: false,
            is_changing_tool: false,
            is_shuttling: false,
            is_tapping: false,
            before_offset: 0,
            rounding: 0.0,
            events: Vec::new(),
        }
    }
}

impl Control {
    /// Takes in one line of output: number, N word, name and arguments.
    fn command(&mut self, text: &str, line: u32) {
        let Some((head, arguments)) = text.split_once('(') else { return };
        let name = head.split_whitespace().last().unwrap_or_default();
        let numbers: Vec<f64> =
            arguments.split([',', ' ', ')']).filter_map(|number| number.parse().ok()).collect();
        let number = |index: usize| numbers.get(index).copied().unwrap_or_default();
        let unit = self.unit;
        let vector = |from: usize| Vector::new(number(from), number(from + 1), number(from + 2)) * unit;
        let deed = match name {
            "USE_LENGTH_UNITS" => {
                self.unit = if arguments.starts_with("CANON_UNITS_INCHES") { 25.4 } else { 1.0 };
                None
            }
            "SELECT_PLANE" => {
                self.plane = match arguments.trim_end_matches(')') {
                    "CANON_PLANE_XY" => [0, 1, 2],
                    "CANON_PLANE_XZ" => [2, 0, 1],
                    "CANON_PLANE_YZ" => [1, 2, 0],
                    other => panic!("a plane we do not know: {other}"),
                };
                None
            }
            "SET_G5X_OFFSET" => {
                (self.g5x, self.before_offset) = (vector(1), self.events.len());
                None
            }
            "SET_G92_OFFSET" => {
                self.g92 = vector(0);
                None
            }
            "USE_TOOL_LENGTH_OFFSET" => {
                self.tool = vector(0);
                None
            }
            "SET_XY_ROTATION" => {
                self.rotation = number(0).to_radians();
                None
            }
            "SET_FEED_RATE" => {
                self.feed = number(0) * unit;
                None
            }
            "SET_FEED_MODE" => {
                self.is_per_revolution = number(1) != 0.0;
                None
            }
            "SET_SPINDLE_SPEED" => {
                self.speed = number(1);
                None
            }
            "SET_MOTION_CONTROL_MODE" => {
                self.is_exact = !arguments.starts_with("CANON_CONTINUOUS");
                None
            }
            "STRAIGHT_TRAVERSE" => Some(self.step(Point::from(vector(0)), None, None)),
            "STRAIGHT_FEED" | "STRAIGHT_PROBE" => {
                Some(self.step(Point::from(vector(0)), Some(self.feedrate()), None))
            }
            "ARC_FEED" => Some(self.arc(&numbers)),
            "DWELL" if self.is_tapping => {
                let before_turning = self.events.len().saturating_sub(2);
                self.events.insert(before_turning, Event { deed: Deed::Dwell(number(0)), line });
                None
            }
            "DWELL" => Some(Deed::Dwell(number(0))),
            "START_CHANGE" => {
                self.is_changing_tool = true;
                None
            }
            "CHANGE_TOOL" => {
                self.is_changing_tool = false;
                Some(Deed::ToolChange(Some(number(0) as u32)))
            }
            // M60 is printed as PALLET_SHUTTLE and PROGRAM_STOP.
            "PROGRAM_STOP" => (!self.is_shuttling).then_some(Deed::MWord(0)),
            "OPTIONAL_PROGRAM_STOP" => Some(Deed::MWord(1)),
            "PROGRAM_END" => {
                self.events.truncate(self.before_offset);
                Some(Deed::MWord(2))
            }
            "START_SPINDLE_CLOCKWISE" => Some(Deed::MWord(3)),
            "START_SPINDLE_COUNTERCLOCKWISE" => Some(Deed::MWord(4)),
            "DISABLE_SPEED_OVERRIDE" | "ENABLE_SPEED_OVERRIDE" => {
                self.is_tapping = name.starts_with('D');
                None
            }
            "STOP_SPINDLE_TURNING" => (!self.is_changing_tool).then_some(Deed::MWord(5)),
            // Cycles stop the spindle before they orient it, which with us is one deed.
            "ORIENT_SPINDLE" => {
                self.events.pop_if(|event| event.deed == Deed::MWord(5) && event.line + 1 == line);
                Some(Deed::MWord(19))
            }
            "MIST_ON" => Some(Deed::MWord(7)),
            "FLOOD_ON" => Some(Deed::MWord(8)),
            // M9 is printed as MIST_OFF and FLOOD_OFF.
            "FLOOD_OFF" => Some(Deed::MWord(9)),
            "PALLET_SHUTTLE" => Some(Deed::MWord(60)),
            _ => None,
        };
        self.is_shuttling = name == "PALLET_SHUTTLE";
        self.events.extend(deed.map(|deed| Event { deed, line }));
    }

    /// mm/min.
    fn feedrate(&self) -> f64 {
        if self.is_per_revolution { self.feed * self.speed } else { self.feed }
    }

    /// A program position in machine coordinates.
    fn machine(&self, program: Point) -> Point {
        Point::from(self.tool + self.g5x + self.turned(program.coords + self.g92))
    }

    fn turned(&self, vector: Vector) -> Vector {
        let (sin, cos) = self.rotation.sin_cos();
        Vector::new(cos * vector.x - sin * vector.y, sin * vector.x + cos * vector.y, vector.z)
    }

    fn step(&mut self, program: Point, feedrate: Option<f64>, arc: Option<Circle>) -> Deed {
        // Half of the last digit for each number that is not exactly zero, √2 as much when turned.
        let offsets = [self.tool, self.g5x, self.g92];
        let terms = 1 + offsets.iter().filter(|offset| offset.norm() != 0.0).count();
        let turned = if self.rotation == 0.0 { 1.0 } else { std::f64::consts::SQRT_2 };
        self.rounding = self.rounding.max(0.5e-4 * self.unit * terms as f64 * turned);
        let (start, end) = (self.position, self.machine(program));
        self.position = end;
        Deed::Move(Move { start, end, feedrate, arc, is_exact: self.is_exact })
    }

    fn arc(&mut self, numbers: &[f64]) -> Deed {
        let [first, second, normal] = self.plane;
        let (mut end, mut center) = (Point::origin(), Point::origin());
        (end[first], end[second], end[normal]) = (numbers[0], numbers[1], numbers[5]);
        (center[first], center[second]) = (numbers[2], numbers[3]);
        let (end, center, turns) = (end * self.unit, center * self.unit, numbers[4]);
        let mut center = self.machine(center);
        center[normal] = self.position[normal];
        let (start, to) = (self.position - center, self.machine(end) - center);
        let cross = start[first] * to[second] - start[second] * to[first];
        let angle = turns.signum() * cross.atan2(start[first] * to[first] + start[second] * to[second]);
        // Rounding may bring the end of a full circle to either side of its start.
        let chord = (to[first] - start[first]).hypot(to[second] - start[second]);
        let is_closed = chord <= 4e-4 * self.unit;
        let once = if is_closed { TAU } else { angle.rem_euclid(TAU) };
        let sweep = turns.signum() * (once + (turns.abs() - 1.0) * TAU);
        self.step(end, Some(self.feedrate()), Some(Circle { center, normal, sweep }))
    }
}
