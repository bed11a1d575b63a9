//! Program families: pockets, arcs, zig-zag, drilling, a free-form surface of short lines, trochoids and
//! tool changes, each drawn by seed and laid side by side along X.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use crate::random::Random;

/// The families a program is put together from.
pub const FAMILIES: [&str; 7] = ["rect", "arcs", "zigzag", "drill", "surf", "troch", "tool"];

/// A program under construction: its text and where the next family begins.
struct Writer {
    text: String,
    x: f64,
    y: f64,
}

impl Writer {
    fn say(&mut self, words: std::fmt::Arguments) {
        self.text.write_fmt(words).expect("text takes any length");
        self.text.push('\n');
    }

    fn feed(&mut self, x: f64, y: f64) {
        self.say(format_args!("G1 X{x:.4} Y{y:.4}"));
        (self.x, self.y) = (x, y);
    }
}

/// A program of four families, and their names.
pub fn draw(random: &mut Random) -> (String, Vec<&'static str>) {
    let mut left: Vec<&str> = FAMILIES.to_vec();
    let families: Vec<&str> = (0..4).map(|_| left.remove(random.below(left.len()))).collect();
    (write(&families, random), families)
}

/// A program of the families named, in that order.
pub fn write(families: &[&str], random: &mut Random) -> String {
    let mut w = Writer { text: "G21 G90 G17\n".into(), x: 0.0, y: 0.0 };
    for family in families {
        w.say(format_args!("G0 Z5.0000"));
        w.x += random.uniform(5.0, 15.0);
        w.y = random.uniform(-15.0, 15.0);
        let (x, y) = (w.x, w.y);
        w.say(format_args!("G0 X{x:.4} Y{y:.4}"));
        let feed = random.pick(&[1000.0, 1500.0, 2000.0, 3000.0, 4000.0]);
        if !matches!(*family, "drill" | "tool") {
            w.say(format_args!("G1 Z-1.0000 F600"));
            w.say(format_args!("F{feed:.0}"));
        }
        match *family {
            "rect" => pocket(&mut w, random),
            "arcs" => arcs(&mut w, random),
            "zigzag" => zigzag(&mut w, random),
            "drill" => drill(&mut w, random),
            "surf" => surface(&mut w, random),
            "troch" => trochoid(&mut w, random),
            _ => {
                let tool = 1 + random.below(20);
                w.say(format_args!("G0 Z30.0000\nT{tool} M6\nM3 S8000\nG0 Z10.0000"));
            }
        }
    }
    w.say(format_args!("G0 Z5.0000\nM30"));
    w.text
}

fn pocket(w: &mut Writer, random: &mut Random) {
    let (x, y) = (w.x, w.y);
    let (width, height) = (random.uniform(30.0, 55.0), random.uniform(20.0, 35.0));
    let step = random.uniform(3.0, 5.0);
    let tilt: f64 = random.pick(&[0.0, 0.0, 0.35]);
    for k in 0..3 + random.below(2) {
        let inset = k as f64 * step;
        let (a, b) = (inset, inset);
        let (c, d) = (width - inset, height - inset);
        for (u, v) in [(a, b), (c, b), (c, d), (a, d), (a, b)] {
            w.feed(x + u * tilt.cos() - v * tilt.sin(), y + u * tilt.sin() + v * tilt.cos());
        }
    }
    w.x = x + width;
}

fn arcs(w: &mut Writer, random: &mut Random) {
    for _ in 0..16 + random.below(10) {
        if random.chance(0.35) {
            let (x, y) = (w.x, random.uniform(-25.0, 25.0));
            w.feed(x, y);
        } else {
            let (radius, side) = (random.pick(&[1.5, 2.5, 4.0, 8.0, 15.0]), random.pick(&[2, 3]));
            w.x += 2.0 * radius;
            let (x, y) = (w.x, w.y);
            w.say(format_args!("G{side} X{x:.4} Y{y:.4} I{radius:.4} J0.0000"));
        }
    }
}

fn zigzag(w: &mut Writer, random: &mut Random) {
    for k in 0..10 + random.below(8) {
        let side = if k % 2 == 0 { 1.0 } else { -1.0 };
        let (x, y) = (w.x + random.uniform(3.0, 18.0), side * random.uniform(1.0, 18.0));
        w.feed(x, y);
    }
}

fn drill(w: &mut Writer, random: &mut Random) {
    w.say(format_args!("F{}", random.pick(&[400, 600, 900])));
    for _ in 0..5 + random.below(4) {
        let (x, y, z) =
            (w.x + random.uniform(8.0, 22.0), random.uniform(-15.0, 15.0), random.uniform(-12.0, -4.0));
        w.say(format_args!("G0 X{x:.4} Y{y:.4}\nG0 Z2.0000\nG1 Z{z:.4}"));
        if random.chance(0.3) {
            w.say(format_args!("G4 P0.25"));
        }
        w.say(format_args!("G0 Z5.0000"));
        (w.x, w.y) = (x, y);
    }
}

fn surface(w: &mut Writer, random: &mut Random) {
    let (x0, y0) = (w.x, w.y);
    let (width, chord) = (random.uniform(25.0, 45.0), random.uniform(0.25, 0.8));
    let (wave, depth, phase) =
        (random.uniform(6.0, 15.0), random.uniform(0.5, 2.0), random.uniform(0.0, TAU));
    let count = (width / chord) as usize;
    for row in 0..5 + random.below(4) {
        let y = y0 + row as f64 * 1.2;
        for i in 0..=count {
            let along = if row % 2 == 0 { i } else { count - i };
            let x = along as f64 * chord;
            let z = -2.0 + depth * (TAU * x / wave + phase).sin() + 0.3 * (TAU * (x + y) / 31.0).cos();
            w.say(format_args!("G1 X{:.4} Y{y:.4} Z{z:.4}", x0 + x));
        }
    }
    (w.x, w.y) = (x0 + width, y0);
}

fn trochoid(w: &mut Writer, random: &mut Random) {
    let (x0, y0) = (w.x, w.y);
    let (radius, pitch, chords) = (random.uniform(3.0, 6.0), random.uniform(0.8, 1.6), 40);
    for i in 0..chords * (6 + random.below(6)) {
        let turn = i as f64 / chords as f64;
        let angle = PI + TAU * turn;
        w.feed(x0 + pitch * turn + radius * (1.0 + angle.cos()), y0 + radius * angle.sin());
    }
    w.x += 2.0 * radius;
}

/// Causes that [`one_axis`] cannot tell apart: with one axis and one feed, a slower feed is a limit of the
/// axis, and a limit along the path is one of the axis.
pub const AMBIGUOUS: [&[&str]; 2] =
    [&["feed_override", "axis_velocity_limit"], &["path_acceleration_limit", "axis_acceleration_limit"]];

/// Moves along X only, at one feed, without a rapid.
pub fn one_axis(random: &mut Random) -> String {
    let feed = random.pick(&[1500, 2000, 3000, 4000]);
    let mut text = format!("G21 G90 G17\nF{feed}\n");
    for k in 0..24 {
        let x = if k % 2 == 0 { random.uniform(15.0, 60.0) } else { random.uniform(-40.0, 5.0) };
        writeln!(text, "G1 X{x:.4}\nG4 P0.2").expect("text takes any length");
    }
    text + "M30\n"
}
