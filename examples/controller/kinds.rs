//! The kinds of jobs that shops run, drawn with sizes, feedrates and tools of their own, and three of the corpus.

use std::f64::consts::{PI, TAU};

use crate::geometry::{Job, rounded};
use crate::jobs::{self, Move};
use crate::random::Random;

/// A kind of job by its name, and how one is drawn.
pub type Kind = (&'static str, fn(&mut Random, &mut Job));

pub const KINDS: [Kind; 11] = [
    ("finishing", finishing),
    ("waterline", waterline),
    ("pocket", pocket),
    ("drilling", drilling),
    ("engraving", engraving),
    ("adaptive", adaptive),
    ("contour", contour),
    ("facing", facing),
    ("corpus-spiral", |random, job| of_corpus("spiral", random, job)),
    ("corpus-trochoid", |random, job| of_corpus("trochoid", random, job)),
    ("corpus-roughing", |random, job| of_corpus("roughing", random, job)),
];

/// Several operations of different kinds, one after another, which take about `seconds` together.
pub fn operations(random: &mut Random, seconds: f64, clearance: f64) -> Vec<Move> {
    let mut kinds: Vec<Kind> = KINDS.to_vec();
    let count = 3 + random.below(4);
    let mut moves = Vec::new();
    for _ in 0..count {
        let (_, fill) = kinds.swap_remove(random.below(kinds.len()));
        let mut job = Job::new(seconds / count as f64 * random.uniform(0.5, 1.5), clearance);
        fill(random, &mut job);
        moves.append(&mut job.moves);
    }
    moves
}

/// A feedrate in steps of 10 mm/min.
fn feed(random: &mut Random, low: f64, high: f64) -> f64 {
    10.0 * (random.log_uniform(low, high) / 10.0).round()
}

/// A speed of the spindle in steps of 100 rpm.
fn speed(random: &mut Random, low: f64, high: f64) -> u32 {
    100 * (random.uniform(low, high) / 100.0).round() as u32
}

/// A surface of two waves, finished in rows of short chords at an angle to the axes, to and fro or one way.
fn finishing(random: &mut Random, job: &mut Job) {
    let (width, over) = (random.uniform(25.0, 60.0), random.uniform(0.3, 1.2));
    let (waves, height) =
        ([random.uniform(12.0, 40.0), random.uniform(12.0, 40.0)], random.log_uniform(0.5, 6.0));
    let (feed, chord) = (feed(random, 1500.0, 6000.0), random.log_uniform(0.15, 1.0));
    let (angle, one_way) = (random.pick(&[0.0, 0.0, 0.5 * PI, 0.25 * PI, 0.3]), random.chance(0.3));
    job.tool(1, speed(random, 12e3, 24e3), "BALL D6");
    let surface = |u: f64, v: f64| height * ((TAU * u / waves[0]).sin() * (TAU * v / waves[1]).cos() - 1.0);
    let at = |u: f64, v: f64| {
        [u * angle.cos() - v * angle.sin(), u * angle.sin() + v * angle.cos(), surface(u, v) - 0.2]
    };
    let steps = (width / chord).ceil() as usize;
    let mut row = 0;
    while row == 0 || !job.has_filled(1.0) {
        let v = over * f64::from(row);
        if row > 0 && one_way {
            job.retract();
        }
        for step in 0..=steps {
            let u = width * step as f64 / steps as f64;
            let end = at(if one_way || row % 2 == 0 { u } else { width - u }, v);
            match step {
                0 if row == 0 || one_way => job.approach(end, 600.0),
                _ => job.line(end, feed),
            }
        }
        row += 1;
    }
    job.retract();
}

/// Levels of a lobed boss, each a closed polygon of short chords, joined by a step outwards and down.
fn waterline(random: &mut Random, job: &mut Job) {
    let (mut radius, lobes, depth) =
        (random.uniform(6.0, 18.0), f64::from(2 + random.below(5) as u32), random.uniform(0.02, 0.2));
    let (step, down) = (random.uniform(0.2, 0.8), random.uniform(0.2, 0.8));
    let (feed, chord) = (feed(random, 1200.0, 5000.0), random.log_uniform(0.2, 1.2));
    job.tool(2, speed(random, 10e3, 20e3), "BULL D6 R1");
    let mut z = -down;
    let mut begun = false;
    while !job.has_filled(1.0) {
        let count = (TAU * radius / chord).ceil() as usize;
        for number in 0..=count {
            let turn = TAU * (number % count) as f64 / count as f64;
            let r = radius * (1.0 + depth * (lobes * turn).cos());
            let end = [r * turn.cos(), r * turn.sin(), z];
            if begun {
                job.line(end, feed);
            } else {
                job.approach(end, 500.0);
                begun = true;
            }
        }
        radius += step;
        z = rounded(z - down);
    }
    job.retract();
}

/// A pocket with round corners from the inside out, level by level, entered on a helix.
fn pocket(random: &mut Random, job: &mut Job) {
    let (length, width) = (random.uniform(30.0, 80.0), random.uniform(20.0, 45.0));
    let (corner, step) = (random.uniform(3.0, 9.0), random.uniform(1.5, 4.0));
    let (feed, clockwise) = (feed(random, 800.0, 4000.0), random.chance(0.3));
    let (down, finish) = (random.uniform(0.4, 1.5), random.chance(0.5));
    job.tool(3, speed(random, 6e3, 16e3), "FLAT D8");
    let mut z = 0.0;
    while !job.has_filled(1.0) {
        job.approach([1.5, 0.0, rounded(z + 0.2)], 400.0);
        z = rounded(z - down);
        job.arc([-1.5, 0.0, rounded(z + 0.5 * down)], [0.0, 0.0], clockwise, 0.5 * feed);
        job.arc([1.5, 0.0, z], [0.0, 0.0], clockwise, 0.5 * feed);
        let rings = (0.5 * width / step) as usize;
        for ring in (0..rings).rev() {
            let inset = step * ring as f64;
            ring_around(
                job,
                0.5 * length - inset,
                0.5 * width - inset,
                corner - 0.5 * inset,
                clockwise,
                feed,
            );
        }
        if finish {
            ring_around(job, 0.5 * length + 0.2, 0.5 * width + 0.2, corner, clockwise, 0.7 * feed);
        }
        job.retract();
    }
}

/// A rectangle with round corners, from the middle of its lower side and back to it.
fn ring_around(job: &mut Job, a: f64, b: f64, corner: f64, clockwise: bool, feed: f64) {
    let (a, b, z) = (rounded(a.max(0.6)), rounded(b.max(0.6)), job.at[2]);
    // A narrow ring has less room than the least radius.
    let r = rounded(corner.max(0.5).min(0.8 * a.min(b)));
    let side = if clockwise { -1.0 } else { 1.0 };
    job.line([0.0, -b, z], feed);
    for (quadrant, (sx, sy)) in [(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)].into_iter().enumerate() {
        let centre = [side * sx * (a - r), sy * (b - r)];
        let ends = [[centre[0], sy * b], [side * sx * a, centre[1]]];
        let [from, to] = if quadrant % 2 == 0 { ends } else { [ends[1], ends[0]] };
        job.line([from[0], from[1], z], feed);
        job.arc([to[0], to[1], z], centre, clockwise, feed);
    }
    job.line([0.0, -b, z], feed);
}

/// Holes on a grid and a circle: spotted, then drilled in one go or with pecks.
fn drilling(random: &mut Random, job: &mut Job) {
    let (pitch, columns) = (random.uniform(5.0, 25.0), 3 + random.below(5));
    let depth = rounded(random.uniform(5.0, 25.0));
    let peck = if random.chance(0.7) { rounded(depth / random.uniform(2.0, 6.0)) } else { 0.0 };
    let circle = random.chance(0.4).then(|| random.uniform(10.0, 40.0));
    let place = |number: usize| match circle {
        Some(radius) => {
            let turn = 0.618 * TAU * number as f64;
            [radius * turn.cos(), radius * turn.sin()]
        }
        None => {
            let (column, row) = (number % columns, number / columns);
            let column = if row % 2 == 0 { column } else { columns - 1 - column };
            [pitch * column as f64, pitch * row as f64]
        }
    };
    job.tool(7, speed(random, 3e3, 8e3), "SPOT D8");
    let (spot, drill) = (feed(random, 150.0, 500.0), feed(random, 150.0, 800.0));
    let mut holes = 0;
    while holes < 3 || !job.has_filled(0.3) {
        job.hole(place(holes), rounded(-random.uniform(0.8, 2.0)), 0.0, spot);
        holes += 1;
    }
    if random.chance(0.5) {
        job.dwell((10.0 * random.uniform(0.2, 1.5)).round() / 10.0);
    }
    job.tool(8, speed(random, 2e3, 6e3), "DRILL D5");
    let mut hole = 0;
    while hole < 3 || !job.has_filled(1.0) {
        job.hole(place(hole % holes), -depth, peck, drill);
        hole += 1;
    }
}

/// Strokes like those of letters: lines, small arcs and wavy curves of chords, with a lift between them.
fn engraving(random: &mut Random, job: &mut Job) {
    let (feed, height) = (feed(random, 400.0, 2400.0), random.uniform(3.0, 12.0));
    let depth = rounded(-random.uniform(0.1, 0.5));
    job.tool(6, speed(random, 12e3, 24e3), "V BIT 60");
    let mut letter = 0;
    while !job.has_filled(1.0) {
        let base = [0.8 * height * f64::from(letter % 12), 1.4 * height * f64::from(letter / 12)];
        job.approach([base[0], base[1], depth], 250.0);
        for _ in 0..1 + random.below(3) {
            stroke(random, job, height, feed);
        }
        job.retract();
        letter += 1;
    }
}

fn stroke(random: &mut Random, job: &mut Job, height: f64, feed: f64) {
    let [x, y, z] = job.at;
    let heading = TAU * f64::from(random.below(8) as u32) / 8.0;
    let size = height * random.uniform(0.2, 0.8);
    match random.below(3) {
        0 => job.line([x + size * heading.cos(), y + size * heading.sin(), z], feed),
        1 => {
            let centre = [rounded(x + 0.5 * size * heading.cos()), rounded(y + 0.5 * size * heading.sin())];
            let end = [2.0 * centre[0] - x, 2.0 * centre[1] - y, z];
            job.arc(end, centre, random.chance(0.5), feed);
        }
        _ => {
            let bend = random.uniform(-0.4, 0.4);
            let (mut x, mut y) = (x, y);
            for chord in 0..(3 + random.below(15)) {
                let towards = heading + bend * chord as f64;
                (x, y) = (x + 0.08 * height * towards.cos(), y + 0.08 * height * towards.sin());
                job.line([x, y, z], feed);
            }
        }
    }
}

/// Adaptive roughing: crescents at the feed of the cut, back at a higher one just above the floor.
fn adaptive(random: &mut Random, job: &mut Job) {
    let (radius, step) = (rounded(random.uniform(4.0, 14.0)), random.uniform(0.3, 1.5));
    let (cut, back) = (feed(random, 1200.0, 4500.0), random.uniform(1.0, 2.5));
    let (lift, length) = (random.pick(&[0.0, 0.2, 0.5]), random.uniform(25.0, 70.0));
    let back = 10.0 * (0.1 * cut * back).round();
    job.tool(5, speed(random, 6e3, 14e3), "FLAT D10");
    let mut z = -rounded(random.uniform(2.0, 6.0));
    while !job.has_filled(1.0) {
        let mut x = 0.0;
        job.approach([0.0, -radius, z], 400.0);
        while x < length && !job.has_filled(1.0) {
            x = rounded(x + step);
            job.line([x, -radius, z], cut);
            job.arc([x, radius, z], [x, 0.0], false, cut);
            if lift > 0.0 {
                job.line([rounded(x - 0.3), rounded(radius - 0.3), rounded(z + lift)], back);
                job.line([rounded(x - 0.3), rounded(0.3 - radius), rounded(z + lift)], back);
            } else {
                job.line([x, -radius, z], back);
            }
        }
        job.retract();
        z = rounded(z - 2.0);
    }
}

/// The outside of a part: lines with fillets, entered on an arc, level by level, with tabs on the last ones.
fn contour(random: &mut Random, job: &mut Job) {
    let (corners, feed) = (4 + random.below(5), feed(random, 800.0, 3500.0));
    let (fillet, down) = (random.uniform(0.5, 6.0), random.uniform(0.5, 2.0));
    let (tabs, tab) = (random.chance(0.7), (random.uniform(3.0, 8.0), random.uniform(0.5, 1.5)));
    let size = random.uniform(20.0, 50.0);
    let points: Vec<[f64; 2]> = (0..corners)
        .map(|corner| {
            let turn = TAU * (corner as f64 + random.uniform(-0.25, 0.25)) / corners as f64;
            let r = size * random.uniform(0.8, 1.0);
            [r * turn.cos(), r * turn.sin()]
        })
        .collect();
    job.tool(4, speed(random, 8e3, 18e3), "FLAT D6");
    let mut z = 0.0;
    let mut level = 0;
    while !job.has_filled(1.0) {
        z = rounded(z - down);
        level += 1;
        let [from, to] = [points[corners - 1], points[0]];
        let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
        let along = direction(from, to);
        let centre = [middle[0] + 3.0 * along[1], middle[1] - 3.0 * along[0]].map(rounded);
        let start = [centre[0] - 3.0 * along[0], centre[1] - 3.0 * along[1], z];
        job.approach(start, 300.0);
        job.arc([middle[0], middle[1], z], centre, false, feed);
        for corner in 0..corners {
            let [v, next] = [points[corner], points[(corner + 1) % corners]];
            let before = points[(corner + corners - 1) % corners];
            round(job, before, v, next, fillet, feed);
            if tabs && level > 1 && corner % 2 == 0 {
                over_tab(job, v, next, tab, feed);
            }
        }
        job.line([middle[0], middle[1], z], feed);
        job.retract();
    }
}

fn direction(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    let away = [to[0] - from[0], to[1] - from[1]];
    away.map(|part| part / away[0].hypot(away[1]))
}

/// To the corner `v` and around it with a fillet that touches both sides.
fn round(job: &mut Job, before: [f64; 2], v: [f64; 2], next: [f64; 2], fillet: f64, feed: f64) {
    let (u, w, z) = (direction(before, v), direction(v, next), job.at[2]);
    let cross = u[0] * w[1] - u[1] * w[0];
    let turn = cross.atan2(u[0] * w[0] + u[1] * w[1]);
    let shortest = (v[0] - before[0]).hypot(v[1] - before[1]).min((next[0] - v[0]).hypot(next[1] - v[1]));
    let reach = (fillet * (0.5 * turn.abs()).tan()).min(0.2 * shortest);
    let r = reach / (0.5 * turn.abs()).tan();
    let side = turn.signum();
    let begin = [v[0] - reach * u[0], v[1] - reach * u[1]];
    job.line([begin[0], begin[1], z], feed);
    let centre = [begin[0] - side * r * u[1], begin[1] + side * r * u[0]];
    job.arc([v[0] + reach * w[0], v[1] + reach * w[1], z], centre, side < 0.0, feed);
}

/// Along a side from `v`, up over a tab in its middle and down again.
fn over_tab(job: &mut Job, v: [f64; 2], next: [f64; 2], (length, height): (f64, f64), feed: f64) {
    let (along, side) = (direction(v, next), (next[0] - v[0]).hypot(next[1] - v[1]));
    if side < 3.0 * length {
        return;
    }
    let z = job.at[2];
    let at = |distance: f64, z: f64| [v[0] + distance * along[0], v[1] + distance * along[1], z];
    let (begin, end) = (0.5 * (side - length), 0.5 * (side + length));
    job.line(at(begin, z), feed);
    job.line(at(begin, z + height), 0.3 * feed);
    job.line(at(end, z + height), feed);
    job.line(at(end, z), 0.3 * feed);
}

/// Long passes over a face, joined by half circles, by steps, or by rapids back to the same side.
fn facing(random: &mut Random, job: &mut Job) {
    let (length, step) = (rounded(random.uniform(40.0, 150.0)), 2.0 * rounded(random.uniform(2.0, 8.0)));
    let (feed, manner, along_y) = (feed(random, 1000.0, 6000.0), random.below(3), random.chance(0.3));
    job.tool(9, speed(random, 2e3, 8e3), "FACE D25");
    let at = |u: f64, v: f64, z: f64| if along_y { [v, u, z] } else { [u, v, z] };
    let mut z = -0.5;
    let mut row = 0;
    job.approach(at(0.0, 0.0, z), 800.0);
    while !job.has_filled(1.0) {
        let v = step * f64::from(row % 10);
        let forth = manner == 2 || row % 2 == 0;
        let (from, to) = if forth { (0.0, length) } else { (length, 0.0) };
        job.line(at(to, v, z), feed);
        row += 1;
        let next = step * f64::from(row % 10);
        if row % 10 == 0 || manner == 2 {
            z = if row % 10 == 0 { z - 0.5 } else { z };
            job.retract();
            job.approach(at(if manner == 2 { from } else { to }, next, z), 800.0);
        } else if manner == 1 {
            let centre = at(to, 0.5 * (v + next), z);
            job.arc(at(to, next, z), [centre[0], centre[1]], forth == along_y, feed);
        } else {
            job.line(at(to, next, z), feed);
        }
    }
    job.retract();
}

/// A job of the corpus, ended where it has taken long enough.
fn of_corpus(kind: &str, random: &mut Random, job: &mut Job) {
    let (_, moves) = jobs::all(1 + random.below(1 << 30) as u64)
        .into_iter()
        .find(|(name, _)| *name == kind)
        .expect("the corpus has this kind");
    for next in moves {
        if job.has_filled(1.0) {
            break;
        }
        match next {
            Move::Tool { number, rpm, name } => job.tool(number, rpm, name),
            Move::Rapid(end) => job.rapid(end),
            Move::Line { end, feed } => job.line(end, feed),
            Move::Arc { end, centre, clockwise, feed } => job.arc(end, centre, clockwise, feed),
            Move::Hole { at, bottom, peck, feed, .. } => job.hole(at, bottom, peck, feed),
            Move::Dwell { seconds } => job.dwell(seconds),
        }
    }
    job.retract();
}
