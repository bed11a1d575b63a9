//! A recording as LinuxCNC gives it, and as a shop would have it: time, positions, feedrate and line, no more.

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::path::Path;

use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;

use crate::Refusal;

/// Which positions were recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// What the drives are told.
    Command,
    /// What the motors did.
    Motor,
    /// Where the table is behind a play that nothing compensates: as far on the other side of the command as LinuxCNC's
    /// compensation puts the motor.
    Table,
}

/// One row of a recording.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    pub t: f64,
    pub line: i64,
    pub command: [f64; 3],
    pub motor: [f64; 3],
    /// Along the path, mm/s.
    pub speed: f64,
    pub feed_override: f64,
    pub held: bool,
}

impl Row {
    pub fn position(&self, scale: Scale) -> [f64; 3] {
        std::array::from_fn(|axis| match scale {
            Scale::Command => self.command[axis],
            Scale::Motor => self.motor[axis],
            Scale::Table => 2.0 * self.command[axis] - self.motor[axis],
        })
    }
}

/// A recording with all that the factory needs to know.
pub struct Trace {
    pub rows: Vec<Row>,
}

impl Trace {
    /// The file that the recorder wrote.
    pub fn read(path: &Path) -> Result<Trace, Refusal> {
        let mut text = String::new();
        GzDecoder::new(std::fs::File::open(path)?).read_to_string(&mut text)?;
        let mut lines = text.lines();
        let head: Vec<&str> = lines.next().ok_or("an empty recording")?.split(',').collect();
        let column =
            |name: &str| head.iter().position(|word| *word == name).ok_or(format!("no column {name}"));
        let (t, line, speed) = (column("t_s")?, column("line")?, column("current_vel")?);
        let (feed_override, held) = (column("feed_override")?, column("feed_hold")?);
        let (command, motor) = (column("x_mm")?, column("x_motor_fb")?);
        let row = |text: &str| -> Result<Row, Refusal> {
            let cells: Vec<f64> = text.split(',').map(str::parse).collect::<Result<_, _>>()?;
            let three = |first: usize| std::array::from_fn(|axis| cells[first + axis]);
            Ok(Row {
                t: cells[t],
                line: cells[line] as i64,
                command: three(command),
                motor: three(motor),
                speed: cells[speed],
                feed_override: cells[feed_override],
                held: cells[held] != 0.0,
            })
        };
        Ok(Trace { rows: lines.map(row).collect::<Result<_, _>>()? })
    }

    /// Writes what a shop would have.
    pub fn write(&self, path: &Path, scale: Scale) -> Result<(), Refusal> {
        let mut text = String::from("t_s,x_mm,y_mm,z_mm,feed_mm_min,line\n");
        for row in &self.rows {
            let [x, y, z] = row.position(scale);
            use std::fmt::Write;
            writeln!(text, "{:.3},{x:.4},{y:.4},{z:.4},{:.1},{}", row.t, 60.0 * row.speed, row.line)?;
        }
        let mut file = GzEncoder::new(std::fs::File::create(path)?, Compression::new(6));
        file.write_all(text.as_bytes())?;
        file.finish()?;
        Ok(())
    }

    fn step(&self) -> f64 {
        self.rows.get(1).map_or(0.0, |second| second.t - self.rows[0].t)
    }

    /// From the first motion to the last, s.
    pub fn duration(&self) -> f64 {
        let mut moving = self.rows.iter().filter(|row| row.speed > 1e-6).map(|row| row.t);
        let first = moving.next();
        first.map_or(0.0, |first| moving.next_back().unwrap_or(first) - first + self.step())
    }

    /// The highest speed along the path, mm/s.
    pub fn fastest(&self) -> f64 {
        self.rows.iter().map(|row| row.speed).fold(0.0, f64::max)
    }

    fn seconds_by_line(&self) -> BTreeMap<i64, f64> {
        let mut seconds = BTreeMap::new();
        for row in &self.rows {
            *seconds.entry(row.line).or_default() += self.step();
        }
        seconds
    }

    /// Lines that take longer or shorter than in `clean` by more than its rows can say, as ranges.
    pub fn lines_changed(&self, clean: &Trace) -> Vec<[i64; 2]> {
        let (here, there) = (self.seconds_by_line(), clean.seconds_by_line());
        let mut ranges: Vec<[i64; 2]> = Vec::new();
        let mut last = None;
        for (line, before) in there {
            let change = (here.get(&line).copied().unwrap_or(0.0) - before).abs();
            if change > (2.5 * self.step()).max(0.01 * before) {
                match ranges.last_mut() {
                    Some(range) if last == Some(range[1]) => range[1] = line,
                    _ => ranges.push([line, line]),
                }
            }
            last = Some(line);
        }
        ranges
    }

    /// By how much the recorded path is bent: the largest distance between positions recorded and commanded, mm, once
    /// the command is as late as they are on the whole. A delay common to all axes bends nothing, and no recording tells
    /// it from a clock that began earlier.
    pub fn bend(&self, scale: Scale) -> f64 {
        let mut delay = 0.0;
        for _ in 0..8 {
            let (mut along, mut speed) = (0.0, 0.0);
            for row in &self.rows {
                let (command, velocity) = self.commanded(row.t - delay);
                let at = row.position(scale);
                along += (0..3).map(|axis| (at[axis] - command[axis]) * velocity[axis]).sum::<f64>();
                speed += velocity.iter().map(|own| own * own).sum::<f64>();
            }
            if speed == 0.0 {
                break;
            }
            delay -= along / speed;
        }
        let away = |row: &Row| {
            let (command, at) = (self.commanded(row.t - delay).0, row.position(scale));
            (0..3).map(|axis| (at[axis] - command[axis]).powi(2)).sum::<f64>().sqrt()
        };
        self.rows.iter().map(away).fold(0.0, f64::max)
    }

    /// The commanded position (mm) and its velocity (mm/s) at a time, on lines between the rows.
    fn commanded(&self, time: f64) -> ([f64; 3], [f64; 3]) {
        let after = self.rows.partition_point(|row| row.t <= time).clamp(1, self.rows.len() - 1);
        let (from, to) = (&self.rows[after - 1], &self.rows[after]);
        let part = ((time - from.t) / (to.t - from.t)).clamp(0.0, 1.0);
        let velocity = std::array::from_fn(|axis| (to.command[axis] - from.command[axis]) / (to.t - from.t));
        let position =
            std::array::from_fn(|axis| from.command[axis] + part * (to.command[axis] - from.command[axis]));
        (position, velocity)
    }

    /// The first and last moment, from the first row, in which a row is as asked, with its line.
    pub fn while_so(&self, so: impl Fn(&Row) -> bool) -> Option<([f64; 2], [i64; 2])> {
        let first = self.rows.iter().find(|row| so(row))?;
        let last = self.rows.iter().rev().find(|row| so(row))?;
        Some(([first.t, last.t], [first.line, last.line]))
    }
}
