//! grbl 1.1: trapezoids of path velocity within per-axis limits, a junction deviation δ at corners, and as many blocks of
//! look-ahead as its buffer holds.
//!
//! v² = a δ sin(θ/2) / (1 − sin(θ/2)) at a corner, θ the angle between the lines, a the acceleration along their bisector
//! (`planner.c`). Velocity is constant within segments of 10 ms, and each interval of the step timer is one cycle longer
//! than it was set (`stepper.c`).

use std::f64::consts::FRAC_PI_4;

use super::piece::{Piece, ramps};
use super::reader::{Block, Item, Reading, known, limit_along};
use super::settings::Settings;

/// A step of a motor, mm: 250 a millimetre.
pub const STEP_MM: f64 = 0.004;

/// `$12`, the largest distance of an arc from its chords, mm.
const ARC_TOLERANCE_MM: f64 = 0.002;
const SEGMENT_S: f64 = 0.01;
const CYCLES_PER_S: f64 = 16e6;
/// Above these numbers of cycles between two steps the timer runs 8, 4 and 2 times as often.
const SMOOTHED_FROM_CYCLES: [(f64, f64); 3] = [(8000.0, 8.0), (4000.0, 4.0), (2000.0, 2.0)];

pub const READING: Reading = Reading {
    chords: |radius, angle, _| {
        0.5 * angle * radius / (ARC_TOLERANCE_MM * (2.0 * radius - ARC_TOLERANCE_MM)).sqrt()
    },
    step: Some(STEP_MM),
    rapids_have_feed: false,
    dwell_unit: 1.0,
    spindle_waits: true,
};

/// The run so far.
struct Control<'a> {
    items: &'a [Item],
    settings: &'a Settings,
    pieces: Vec<Piece>,
    time: f64,
    velocity: f64,
    feed_override: f64,
    /// Overrides that are still to come.
    overrides: &'a [(f64, f64)],
    hold: Option<(f64, f64)>,
    /// Until when the motion is held.
    held_until: Option<f64>,
}

/// Returns the motion of a program.
pub fn run(items: &[Item], settings: &Settings) -> Vec<Piece> {
    let mut control = Control {
        items,
        settings,
        pieces: Vec::new(),
        time: 0.0,
        velocity: 0.0,
        feed_override: 1.0,
        overrides: &settings.feed_overrides,
        hold: settings.hold,
        held_until: None,
    };
    let mut at = [0.0; 3];
    for (number, item) in items.iter().enumerate() {
        match item {
            Item::Move(block) => {
                control.runs(number, block);
                at = block.point(block.length);
            }
            Item::Rest { seconds, line } => control.adds(Piece::rest(at, *seconds, *line)),
        }
    }
    in_segments(&control.pieces)
}

impl Control<'_> {
    fn adds(&mut self, piece: Piece) {
        self.time += piece.seconds;
        self.pieces.push(Piece {
            feed_override: self.feed_override,
            held: self.held_until.is_some(),
            ..piece
        });
    }

    fn nominal(&self, block: &Block) -> f64 {
        let rapid = block.along(&self.settings.velocity);
        match block.feed {
            Some(feed) => (feed * self.feed_override).min(rapid),
            None => rapid * self.settings.rapid_override,
        }
        .min(self.settings.path_velocity)
    }

    /// The velocity at the end of item `number` that lets all known blocks end in rest.
    fn exit(&self, number: usize) -> f64 {
        let known = known(self.items, number, self.settings.look_ahead);
        let mut squared: f64 = 0.0;
        for pair in known.windows(2).rev() {
            let reachable = squared + 2.0 * pair[1].along(&self.settings.acceleration) * pair[1].length;
            let slower = self.nominal(pair[0]).min(self.nominal(pair[1]));
            squared = reachable.min(slower * slower).min(junction(pair[0], pair[1], self.settings));
        }
        squared.sqrt()
    }

    /// When the operator acts next.
    fn next_act(&self) -> f64 {
        let change = self.overrides.first().map_or(f64::INFINITY, |change| change.0);
        change.min(self.hold.map_or(f64::INFINITY, |hold| hold.0))
    }

    /// Applies the overrides and the hold whose time has come.
    fn obeys(&mut self) {
        while let Some((_, ratio)) = self.overrides.first().filter(|change| change.0 <= self.time) {
            self.feed_override = *ratio;
            self.overrides = &self.overrides[1..];
        }
        if let Some((from, seconds)) = self.hold.filter(|hold| hold.0 <= self.time) {
            self.held_until = Some(from + seconds);
            self.hold = None;
        }
    }

    fn runs(&mut self, number: usize, block: &Block) {
        let mut done = 0.0;
        let acceleration = block.along(&self.settings.acceleration);
        while block.length - done > 1e-9 {
            self.obeys();
            if let Some(until) = self.held_until.filter(|_| self.velocity < 1e-9) {
                self.adds(Piece::rest(block.point(done), (until - self.time).max(0.0), block.line));
                self.held_until = None;
            }
            let (cruise, exit) = match self.held_until {
                Some(_) => (0.0, 0.0),
                None => (self.nominal(block), self.exit(number)),
            };
            let mut is_cut = false;
            for (a, seconds) in ramps(self.velocity, cruise, exit, block.length - done, acceleration) {
                let lasts = seconds.min(self.next_act() - self.time).max(0.0);
                is_cut = lasts < seconds;
                let piece = Piece::of(block, done, self.velocity, a, lasts);
                let (way, velocity) = piece.after(lasts);
                (done, self.velocity) = (done + way, velocity.max(0.0));
                self.adds(piece);
                if is_cut {
                    break;
                }
            }
            if !is_cut && self.held_until.is_none() {
                break;
            }
        }
    }
}

/// The square of the highest velocity at the corner between two blocks.
///
/// On Marlin, A is at most the acceleration of the second block, and two blocks that turn little are chords of an arc if the
/// second one is short: v² = A L / φ.
pub fn junction(before: &Block, after: &Block, settings: &Settings) -> f64 {
    let cos: f64 = -(0..3).map(|axis| before.direction[axis] * after.direction[axis]).sum::<f64>();
    if cos > 0.999_999 {
        return 0.0;
    }
    if cos < -0.999_999 {
        return f64::INFINITY;
    }
    let along: [f64; 3] = std::array::from_fn(|axis| after.direction[axis] - before.direction[axis]);
    let size = along.iter().map(|part| part * part).sum::<f64>().sqrt();
    let mut acceleration = limit_along(&along.map(|part| part / size), &settings.acceleration);
    if settings.has_short_blocks_as_chords {
        acceleration = acceleration.min(after.along(&settings.acceleration));
    }
    let half_sine = (0.5 * (1.0 - cos)).sqrt();
    let of_deviation = acceleration * settings.junction_deviation * half_sine / (1.0 - half_sine);
    let turn = (-cos).acos();
    let is_chord = settings.has_short_blocks_as_chords && after.length < 1.0 && turn < FRAC_PI_4;
    if is_chord { of_deviation.min(acceleration * after.length / turn) } else { of_deviation }
}

/// Cuts each block into segments of constant velocity, each longer by the error of the step timer.
fn in_segments(pieces: &[Piece]) -> Vec<Piece> {
    let mut segments: Vec<Piece> = Vec::new();
    let mut open: Option<(Piece, f64)> = None;
    let mut close = |open: &mut Option<(Piece, f64)>| {
        if let Some((mut segment, way)) = open.take() {
            segment.velocity = way / segment.seconds;
            segment.acceleration = 0.0;
            segment.seconds *= lateness(&segment);
            segments.push(segment);
        }
    };
    for piece in pieces.iter().filter(|piece| piece.seconds > 0.0) {
        let mut begun = 0.0;
        while begun < piece.seconds {
            let joins = open.as_ref().is_some_and(|(segment, _)| {
                segment.line == piece.line
                    && segment.direction == piece.direction
                    && segment.held == piece.held
            });
            if !joins {
                close(&mut open);
            }
            let from = piece.point(piece.after(begun).0);
            let (segment, way) =
                open.get_or_insert_with(|| (Piece { from, seconds: 0.0, ..piece.clone() }, 0.0));
            let lasts = (SEGMENT_S - segment.seconds).min(piece.seconds - begun);
            *way += piece.after(begun + lasts).0 - piece.after(begun).0;
            segment.seconds += lasts;
            begun += lasts;
            if segment.seconds >= SEGMENT_S - 1e-12 {
                close(&mut open);
            }
        }
    }
    close(&mut open);
    segments
}

/// How many times longer a segment takes: one cycle of the timer more per tick.
fn lateness(segment: &Piece) -> f64 {
    let fastest = segment.direction.iter().map(|part| part.abs()).fold(0.0, f64::max) * segment.velocity;
    if fastest <= 0.0 {
        return 1.0;
    }
    let cycles = CYCLES_PER_S * STEP_MM / fastest;
    let finer = SMOOTHED_FROM_CYCLES.iter().find(|(from, _)| cycles >= *from).map_or(1.0, |level| level.1);
    1.0 + finer / cycles
}
