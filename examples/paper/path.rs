//! Toolpaths as a CAM system writes them: straight blocks only, curves as chords.

use truefeed::machine::{Machine, TimeConstants};
use truefeed::simulation::feed::{CornerPolicy, FeedPlan};
use truefeed::simulation::gcode::LineNumber;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::{Curve, Motion, Point, Rotation, Segment, Segments, Toolpath, Vector};
use truefeed::units::mm_per_s;

/// T1 = Tacc/3 of Sect. 2.2, s.
pub const TIME_CONSTANT: f64 = 0.0255;

/// A path being drawn, with the distances of places worth a look.
#[derive(Clone, Debug)]
pub struct Pen {
    points: Vec<Point>,
    heading: f64,
    /// Length so far, mm.
    pub length: f64,
}

impl Pen {
    /// At the origin, towards X.
    pub fn new() -> Pen {
        Pen { points: vec![Point::origin()], heading: 0.0, length: 0.0 }
    }

    /// Goes straight on by so much, mm.
    pub fn straight(&mut self, length: f64) {
        let end = self.points[self.points.len() - 1]
            + length * Vector::new(self.heading.cos(), self.heading.sin(), 0.0);
        self.points.push(end);
        self.length += length;
    }

    /// Turns on the spot, degrees.
    pub fn turn(&mut self, degrees: f64) {
        self.heading += degrees.to_radians();
    }

    /// Runs along an arc of `radius` (mm) that turns by `degrees`, as chords that turn by about
    /// `chord` degrees each and are tangent at both ends.
    pub fn arc(&mut self, radius: f64, degrees: f64, chord: f64) {
        let chords = (degrees.abs() / chord).round().max(1.0);
        let each = degrees / chords;
        for _ in 0..chords as usize {
            self.turn(0.5 * each);
            self.straight(2.0 * radius * (0.5 * each.abs()).to_radians().sin());
            self.turn(0.5 * each);
        }
    }

    /// The toolpath at `feedrate` (mm/min), cut or drawn out at its end to `length` (mm).
    pub fn toolpath(&self, length: f64, feedrate: f64) -> Toolpath {
        let mut segments = Segments::default();
        let mut left = length;
        let last = self.points.len() - 2;
        for (index, pair) in self.points.windows(2).enumerate() {
            let whole = (pair[1] - pair[0]).norm();
            if whole == 0.0 {
                continue;
            }
            let own = if index == last { left } else { whole.min(left) };
            let end = pair[0] + (own / whole) * (pair[1] - pair[0]);
            segments.push(Segment {
                start: pair[0],
                end,
                curve: Curve::Line,
                length: (end - pair[0]).norm(),
                motion: Motion::Feed { feedrate: mm_per_s(feedrate) },
                rotation: Rotation::NONE,
                exact_stop: false,
                exact_path: false,
                line: LineNumber(index as u32 + 1),
            });
            left -= own;
            if left <= 1e-9 {
                break;
            }
        }
        Toolpath { segments, ..Toolpath::default() }
    }
}

/// The machine of the paper with so many filters of one time constant (s).
pub fn machine(filters: usize, time_constant: f64) -> Machine {
    let mut machine = Machine::default();
    machine.interpolator.filters = filters;
    machine.interpolator.time_constants = TimeConstants::Equal(time_constant);
    machine
}

/// The plan as published: every corner as if it were alone; tolerance in µm.
pub fn plan_of(toolpath: &Toolpath, tolerance: f64) -> FeedPlan {
    simulate::with_policy(toolpath, &machine(3, TIME_CONSTANT), CornerPolicy::Isolated(1e-3 * tolerance))
}

/// Feedrate of the tool when it has run `distance` (mm), mm/min.
pub fn feedrate_at(profile: &Profile, distance: f64) -> f64 {
    truefeed::units::mm_per_min(profile.at_time(profile.time_at_distance(distance)).velocity.norm())
}
