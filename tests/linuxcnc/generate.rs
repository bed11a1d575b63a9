//! Random NGC programs, the same on every run: valid for LinuxCNC by construction, and of words
//! that our tracer runs.
//!
//! The position is followed on the way, in program coordinates and the unit in force, since arcs
//! need it: a centre is as far from the end as from the start, a radius reaches across.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use crate::shared::random::Random;

/// The letters of axes and centres.
const AXES: [char; 3] = ['X', 'Y', 'Z'];
const CENTERS: [char; 3] = ['I', 'J', 'K'];

struct Writer {
    random: Random,
    text: String,
    /// Program coordinates in the unit in force.
    position: [f64; 3],
    /// Lengths are about this, in the unit in force: 1 for mm.
    scale: f64,
    is_incremental: bool,
    has_incremental_center: bool,
    plane: [usize; 3],
    /// How many parameters hold a value.
    parameters: usize,
    /// The work offset in force, 0 for G54, and which of them are turned.
    system: usize,
    is_turned: [bool; 6],
    /// The shift of G92 is in force, suspended or neither; then by how much on each axis.
    shift: Option<[f64; 3]>,
}

/// Program number `seed`, of at most some 60 blocks.
pub fn program(seed: u64) -> String {
    let mut writer = Writer {
        random: Random::new(seed),
        text: String::from("G21 G90 G91.1 G17 G94 G0 X0 Y0 Z0 F500\n"),
        position: [0.0; 3],
        scale: 1.0,
        is_incremental: false,
        has_incremental_center: true,
        plane: [0, 1, 2],
        parameters: 0,
        system: 0,
        is_turned: [false; 6],
        shift: None,
    };
    let blocks = 5 + writer.random.below(55);
    for _ in 0..blocks {
        writer.block();
    }
    writer.text.push_str("M2\n");
    writer.text
}

impl Writer {
    fn line(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
    }

    fn block(&mut self) {
        match self.random.below(108) {
            0..30 => self.straight(),
            30..50 => self.arc_by_center(),
            50..65 => self.arc_by_radius(),
            65..69 => self.change_unit(),
            69..73 => {
                self.is_incremental = !self.is_incremental;
                self.line(if self.is_incremental { "G91" } else { "G90" });
            }
            73..76 => {
                self.has_incremental_center = !self.has_incremental_center;
                self.line(if self.has_incremental_center { "G91.1" } else { "G90.1" });
            }
            76..81 if !self.is_turned[self.system] => {
                let (word, plane) =
                    [("G17", [0, 1, 2]), ("G18", [2, 0, 1]), ("G19", [1, 2, 0])][self.random.below(3)];
                self.plane = plane;
                self.line(word);
            }
            81..85 => {
                let feed = self.number(50.0, 3000.0, 1);
                self.line(&format!("F{feed}"));
            }
            85..88 => {
                let seconds = self.number(0.0, 3.0, 1);
                self.line(&format!("G4 P{seconds}"));
            }
            88..91 => self.assignment(),
            91..96 => self.shift(),
            96 => self.cycle(),
            97 => {
                let word = ["M3 S1000", "M4 S200", "M5", "M7", "M8", "M9", "M0", "M1"][self.random.below(8)];
                self.line(word);
            }
            100..104 => self.offset(),
            104..106 => self.feed_mode(),
            106..108 => self.cycle(),
            98 => {
                let word = ["G61", "G61.1", "G64", "G64 P0.01"][self.random.below(4)];
                self.line(word);
            }
            _ => {
                let tool = 1 + self.random.below(9);
                self.line(&format!("T{tool} M6"));
            }
        }
    }

    /// A number in the unit in force, with that many decimals: few, so that LinuxCNC's four say all.
    fn number(&mut self, low: f64, high: f64, decimals: i32) -> f64 {
        let digits = 10f64.powi(decimals);
        (self.random.between(low, high) * self.scale * digits).round() / digits
    }

    /// A number as written: now and then as an expression of the same value.
    fn written(&mut self, value: f64) -> String {
        // Five decimals bring arcs onto their circle well within what LinuxCNC tolerates.
        // Adding zero takes the sign of a negative one away.
        let value = rounded(value) + 0.0;
        match self.random.below(14) {
            0 => format!("[{} + {}]", value - 2.5, 2.5),
            1 => format!("[{value} * [3 - 2]]"),
            2 => format!("[0 - {}]", -value),
            3 if 0 < self.parameters => {
                let number = 1 + self.random.below(self.parameters);
                format!("[#{number} - #{number} + {value}]")
            }
            4 => format!("[SQRT[4] * {}]", 0.5 * value),
            5 => format!("[{value}]"),
            6 if 0.0 <= value => format!("+{value}"),
            _ => format!("{value}"),
        }
    }

    /// The axis words that lead to a position, of which the axes in `needed` are always written.
    fn words(&mut self, target: [f64; 3], needed: &[usize]) -> String {
        let mut text = String::new();
        for axis in 0..3 {
            let is_there = (target[axis] - self.position[axis]).abs() < 1e-9;
            if is_there && !needed.contains(&axis) {
                continue;
            }
            let value = if self.is_incremental { target[axis] - self.position[axis] } else { target[axis] };
            let value = self.written(value);
            write!(text, " {}{value}", AXES[axis]).expect("text grows");
        }
        self.position = target;
        text
    }

    fn straight(&mut self) {
        let mut target = self.position;
        for coordinate in &mut target {
            if self.random.chance(0.6) {
                *coordinate = self.number(-80.0, 80.0, 2);
            }
        }
        let words = self.words(target, &[]);
        if words.is_empty() {
            return;
        }
        let word = if self.random.chance(0.3) { "G0" } else { "G1" };
        self.line(&format!("{word}{words}"));
    }

    /// Where an arc rises to, mostly nowhere.
    fn rise(&mut self) -> f64 {
        let normal = self.position[self.plane[2]];
        if self.random.chance(0.3) { normal + self.number(-5.0, 5.0, 2) } else { normal }
    }

    fn arc_by_center(&mut self) {
        let [first, second, normal] = self.plane;
        let radius = self.random.between(1.0, 60.0) * self.scale;
        let from = self.random.between(0.0, TAU);
        let (along, across) = (rounded(-radius * from.cos()), rounded(-radius * from.sin()));
        let center = [self.position[first] + along, self.position[second] + across];
        // The radius as it is after rounding, so that start and end agree.
        let (radius, from) = (along.hypot(across), (-across).atan2(-along));
        let is_full = self.random.chance(0.15);
        let to = from + self.random.between(0.1, TAU - 0.1);
        let mut target = self.position;
        target[normal] = self.rise();
        if !is_full {
            target[first] = rounded(center[0] + radius * to.cos());
            target[second] = rounded(center[1] + radius * to.sin());
        }
        let turns = if self.random.chance(0.2) { 1 + self.random.below(4) } else { 1 };
        let needed = if is_full { vec![] } else { vec![first, second] };
        let ends = self.words(target, &needed);
        let [along, across] = if self.has_incremental_center { [along, across] } else { center };
        let (along, across) = (self.written(along), self.written(across));
        let word = if self.random.chance(0.5) { "G2" } else { "G3" };
        let (i, j) = (CENTERS[first], CENTERS[second]);
        let turns = if 1 < turns { format!(" P{turns}") } else { String::new() };
        self.line(&format!("{word}{ends} {i}{along} {j}{across}{turns}"));
    }

    fn arc_by_radius(&mut self) {
        let [first, second, normal] = self.plane;
        let direction = self.random.between(-PI, PI);
        let chord = self.random.between(0.5, 50.0) * self.scale;
        let mut target = self.position;
        target[first] = rounded(target[first] + chord * direction.cos());
        target[second] = rounded(target[second] + chord * direction.sin());
        target[normal] = self.rise();
        let least = 0.5 * chord;
        let radius = rounded(least * self.random.between(1.01, 3.0))
            * if self.random.chance(0.3) { -1.0 } else { 1.0 };
        let ends = self.words(target, &[first, second]);
        let radius = self.written(radius);
        let word = if self.random.chance(0.5) { "G2" } else { "G3" };
        self.line(&format!("{word}{ends} R{radius}"));
    }

    fn change_unit(&mut self) {
        let is_inch = self.scale == 1.0;
        let factor = if is_inch { 1.0 / 25.4 } else { 25.4 };
        self.scale = if is_inch { 1.0 / 25.4 } else { 1.0 };
        self.line(if is_inch { "G20" } else { "G21" });
        self.position = self.position.map(|coordinate| coordinate * factor);
        self.shift = self.shift.map(|shift| shift.map(|shift| shift * factor));
        // What is left of the other unit is not a round number; a move makes it one.
        let target = [0; 3].map(|_| self.number(-50.0, 50.0, 2));
        let was_incremental = std::mem::take(&mut self.is_incremental);
        let words = self.words(target, &[0, 1, 2]);
        self.is_incremental = was_incremental;
        let back = if was_incremental { "\nG91" } else { "" };
        self.line(&format!("G90 G1{words}{back}"));
    }

    fn assignment(&mut self) {
        self.parameters = (self.parameters + 1).min(20);
        let (number, value) = (self.parameters, self.number(-9.0, 9.0, 3));
        self.line(&format!("#{number}={value}"));
    }

    /// One canned cycle of a few holes, in absolute coordinates, ended by G80.
    fn cycle(&mut self) {
        let [first, second, normal] = self.plane;
        let was_incremental = std::mem::take(&mut self.is_incremental);
        let retract = self.number(10.0, 20.0, 2);
        let bottom = self.number(-20.0, 5.0, 2);
        let code = [73, 81, 82, 83, 85, 86, 89][self.random.below(7)];
        let back = if self.random.chance(0.5) { "G98" } else { "G99" };
        let mut text = String::from("G90 M3 S1000\n");
        for hole in 0..1 + self.random.below(4) {
            self.position[first] = self.number(-50.0, 50.0, 2);
            self.position[second] = self.number(-50.0, 50.0, 2);
            if hole == 0 {
                write!(text, "{back} G{code} {}{bottom} R{retract} ", AXES[normal]).expect("text grows");
                match code {
                    // Where the depth is a whole number of pecks, LinuxCNC makes one more or not,
                    // as its sum of pecks happens to be rounded.
                    73 | 83 => {
                        let pecks = self.random.below(6) as f64 + self.random.between(0.3, 0.7);
                        write!(text, "Q{} ", rounded((retract - bottom) / pecks))
                    }
                    82 | 86 | 89 => write!(text, "P{} ", self.random.below(10) as f64 / 10.0),
                    _ => Ok(()),
                }
                .expect("text grows");
            }
            let (x, y) = (self.position[first], self.position[second]);
            writeln!(text, "{}{x} {}{y}", AXES[first], AXES[second]).expect("text grows");
        }
        // Where the tool is now depends on G98 and on how high it was; a move says it.
        self.position[normal] = self.number(25.0, 30.0, 2);
        write!(text, "G80\nG0 {}{}", AXES[normal], self.position[normal]).expect("text grows");
        if was_incremental {
            text.push_str("\nG91");
        }
        self.is_incremental = was_incremental;
        self.line(&text);
    }

    /// A work offset, turned now and then, and a move that makes the position known again. Only
    /// arcs in X Y are written under a rotation: the others would lie in no plane of axes.
    fn offset(&mut self) {
        let system = self.random.below(6);
        let is_xy = self.plane == [0, 1, 2];
        let mut text = String::new();
        if self.random.chance(0.6) || (self.is_turned[system] && !is_xy) {
            let [x, y] = [0; 2].map(|_| self.number(-40.0, 40.0, 2));
            let z = self.number(-9.0, 9.0, 2);
            self.is_turned[system] = is_xy && self.random.chance(0.4);
            let degrees = if self.is_turned[system] { self.random.between(1.0, 360.0).floor() } else { 0.0 };
            writeln!(text, "G10 L2 P{} X{x} Y{y} Z{z} R{degrees}", system + 1).expect("text grows");
        }
        self.system = system;
        self.position = [0; 3].map(|_| self.number(-50.0, 50.0, 2));
        let ([x, y, z], word) = (self.position, ["G54", "G55", "G56", "G57", "G58", "G59"][system]);
        write!(text, "{word}\nG90 G1 X{x} Y{y} Z{z}").expect("text grows");
        if self.is_incremental {
            text.push_str("\nG91");
        }
        self.line(&text);
    }

    /// Inverse time for a few lines, each with its F, or feed per revolution.
    fn feed_mode(&mut self) {
        let is_inverse = self.random.chance(0.5);
        let was_incremental = std::mem::take(&mut self.is_incremental);
        let mut text = String::from(if is_inverse { "G90 G93" } else { "G90 G95 M3 S500\nF0.25" });
        for _ in 0..1 + self.random.below(4) {
            let target = [0; 3].map(|_| self.number(-80.0, 80.0, 2));
            let words = self.words(target, &[0, 1, 2]);
            let feed = if is_inverse { format!(" F{}", 1 + self.random.below(20)) } else { String::new() };
            write!(text, "\nG1{words}{feed}").expect("text grows");
        }
        let feed = self.number(50.0, 3000.0, 1);
        write!(text, "\nG94 F{feed}").expect("text grows");
        if was_incremental {
            text.push_str("\nG91");
        }
        self.is_incremental = was_incremental;
        self.line(&text);
    }

    /// G92 and its relatives.
    fn shift(&mut self) {
        match (self.random.below(4), self.shift) {
            (0, Some(shift)) => {
                self.line("G92.1");
                self.shift = None;
                (0..3).for_each(|axis| self.position[axis] += shift[axis]);
            }
            (1, Some(shift)) => {
                self.line("G92.2");
                (0..3).for_each(|axis| self.position[axis] += shift[axis]);
                self.straight();
                self.line("G92.3");
                (0..3).for_each(|axis| self.position[axis] -= shift[axis]);
            }
            _ => {
                let mut shift = self.shift.unwrap_or_default();
                let mut text = String::from("G92");
                for (axis, letter) in AXES.into_iter().enumerate() {
                    if axis == 0 || self.random.chance(0.5) {
                        let value = self.number(-40.0, 40.0, 2);
                        write!(text, " {letter}{value}").expect("text grows");
                        shift[axis] += self.position[axis] - value;
                        self.position[axis] = value;
                    }
                }
                self.shift = Some(shift);
                self.line(&text);
            }
        }
    }
}

/// To the fifth decimal.
fn rounded(value: f64) -> f64 {
    (1e5 * value).round() / 1e5
}
