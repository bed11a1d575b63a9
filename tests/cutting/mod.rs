//! Cutting forces: closed forms, laws of scale, volumes and engagements of exact geometry.

mod engagements;
mod forces;
mod headroom;
mod jobs;
#[allow(dead_code)]
mod neutral;
mod refusals;
mod volumes;

use truefeed::cutting::{Mill, Setup, StockBox, material};
use truefeed::machine::Machine;
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::toolpath::Toolpath;

/// The toolpath of a program on the neutral machine.
fn toolpath(program: &str) -> Toolpath {
    trace(&read(program.as_bytes()), &Machine::default())
}

/// A mill of this diameter (mm) with two straight teeth.
fn mill(diameter: f64) -> Mill {
    Mill { diameter: Some(diameter), teeth: Some(2), ..Mill::default() }
}

/// A set-up in aluminium 7075 at 8000 rpm.
fn setup(min: [f64; 3], max: [f64; 3], mill: Mill, resolution: f64) -> Setup {
    Setup {
        stock: Some(StockBox { min, max }),
        resolution: Some(resolution),
        coefficients: Some(material("al7075").expect("known").coefficients),
        tool: Some(mill),
        spindle_speed: Some(8000.0),
        ..Setup::default()
    }
}

/// A program that brings the tool straight down to a place and goes on; what follows begins in line 3.
fn from(x: f64, y: f64, z: f64, rest: &str) -> String {
    format!("G21 G90 M3 S8000 G0 X{x} Y{y} Z5\nG1 Z{z} F1000\n{rest}")
}
