//! Tables 1 to 3: the contour pocket and the trochoidal pocket, rebuilt.
//!
//! What the paper tells: length = CAD time × feed, a pocket of 40 × 60 mm, a tool of 12 mm. What it
//! does not tell is chosen by trying a grid of geometries on half of the rows of Table 1.

use truefeed::simulation::profile::Profile;

use super::path::{Pen, feedrate_at, plan_of};

/// A row of Table 1 with its features of Tables 2 and 3: mm/min, µm, and s.
pub struct Row {
    pub feedrate: f64,
    pub tolerance: f64,
    pub measured: f64,
    pub cam: f64,
    pub paper: f64,
    /// Name, measured and predicted feedrate, mm/min.
    pub features: &'static [(&'static str, f64, f64)],
    /// Whether the geometry was chosen on it.
    pub used: bool,
}

pub const CONTOUR: [Row; 4] = [
    Row {
        feedrate: 1000.0,
        tolerance: 10.0,
        measured: 27.07,
        cam: 26.56,
        paper: 27.32,
        features: &[("straight", 1003.0, 1004.0), (SHARP, 124.0, 143.0), (ROUNDED, 994.0, 940.0)],
        used: true,
    },
    Row {
        feedrate: 1000.0,
        tolerance: 50.0,
        measured: 26.82,
        cam: 26.56,
        paper: 26.95,
        features: &[("straight", 1003.0, 1004.0), (SHARP, 482.0, 446.0), (ROUNDED, 998.0, 995.0)],
        used: false,
    },
    Row {
        feedrate: 3000.0,
        tolerance: 10.0,
        measured: 10.37,
        cam: 8.85,
        paper: 10.46,
        features: &[("straight", 3008.0, 3005.0), (SHARP, 113.0, 93.0), (ROUNDED, 1120.0, 1093.0)],
        used: false,
    },
    Row {
        feedrate: 3000.0,
        tolerance: 50.0,
        measured: 9.60,
        cam: 8.85,
        paper: 9.73,
        features: &[("straight", 3008.0, 3004.0), (SHARP, 465.0, 370.0), (ROUNDED, 2996.0, 2929.0)],
        used: true,
    },
];

pub const TROCHOID: [Row; 4] = [
    Row {
        feedrate: 1000.0,
        tolerance: 10.0,
        measured: 42.38,
        cam: 40.69,
        paper: 44.75,
        features: &[("stepover", 1005.0, 1003.0), (ARC, 938.0, 872.0)],
        used: true,
    },
    Row {
        feedrate: 1000.0,
        tolerance: 50.0,
        measured: 40.78,
        cam: 40.69,
        paper: 41.30,
        features: &[("stepover", 1005.0, 1004.0), (ARC, 1002.0, 994.0)],
        used: false,
    },
    Row {
        feedrate: 3000.0,
        tolerance: 10.0,
        measured: 30.13,
        cam: 13.56,
        paper: 30.99,
        features: &[("stepover", 2994.0, 2687.0), (ARC, 973.0, 958.0)],
        used: false,
    },
    Row {
        feedrate: 3000.0,
        tolerance: 50.0,
        measured: 14.04,
        cam: 13.56,
        paper: 14.40,
        features: &[("stepover", 3014.0, 2985.0), (ARC, 2986.0, 2838.0)],
        used: true,
    },
];

pub const SHARP: &str = "sharp corner";
const ROUNDED: &str = "rounded corner";
const ARC: &str = "main arc";

/// How much the feedrate on curves counts against the time where it is used for choosing.
pub const WEIGHT_OF_CURVES: f64 = 0.1;

/// Length of the paths: CAD time at 1000 mm/min, mm.
const CONTOUR_LENGTH: f64 = 26.56 * 1000.0 / 60.0;
const TROCHOID_LENGTH: f64 = 40.69 * 1000.0 / 60.0;

/// A path with the distances of the features of Tables 2 and 3, mm.
pub struct Pocket {
    pub pen: Pen,
    pub length: f64,
    pub features: Vec<(&'static str, f64)>,
}

impl Pocket {
    /// Predicted cycle time, s.
    pub fn time(&self, feedrate: f64, tolerance: f64) -> f64 {
        plan_of(&self.pen.toolpath(self.length, feedrate), tolerance).cycle_time()
    }

    /// Predicted feedrate at each feature, mm/min.
    pub fn feedrates(&self, feedrate: f64, tolerance: f64) -> Vec<f64> {
        let toolpath = self.pen.toolpath(self.length, feedrate);
        let plan = plan_of(&toolpath, tolerance);
        let profile = Profile::new(&toolpath, &plan);
        self.features.iter().map(|(_, distance)| feedrate_at(&profile, *distance)).collect()
    }

    /// Sum of the squared relative misses of the paper's predictions on the rows in use: of the time,
    /// and of the feedrate on curves with a weight of its own.
    fn misfit(&self, rows: &[Row], weight_of_curves: f64) -> f64 {
        let squared = |ours: f64, paper: f64| (ours / paper - 1.0).powi(2);
        let on_curve = self.features.iter().position(|(name, _)| [ROUNDED, ARC].contains(name));
        let misses = rows.iter().filter(|row| row.used).map(|row| {
            let toolpath = self.pen.toolpath(self.length, row.feedrate);
            let plan = plan_of(&toolpath, row.tolerance);
            let time = squared(plan.cycle_time(), row.paper);
            let Some(place) = on_curve.filter(|_| weight_of_curves > 0.0) else { return time };
            let (name, distance) = self.features[place];
            let ours = feedrate_at(&Profile::new(&toolpath, &plan), distance);
            let paper = row.features.iter().filter(|feature| feature.0 == name);
            time + weight_of_curves * paper.map(|feature| squared(ours, feature.2)).sum::<f64>()
        });
        misses.sum()
    }
}

/// What is free in the contour pocket.
#[derive(Clone, Copy, Debug)]
pub struct ContourShape {
    /// Of the four loops, counted from the innermost, so many have sharp corners.
    pub sharp_loops: usize,
    /// Radius of the other corners, mm.
    pub radius: f64,
    /// Turn from chord to chord in them, degrees.
    pub chord: f64,
}

/// Between one loop and the next, mm: a third of the tool.
pub const STEPOVER: f64 = 4.0;

/// Four rectangular loops from the inside out, 4 × 24 to 28 × 48 mm, joined by steps at right angles,
/// after a way in that makes up the length.
pub fn contour(shape: ContourShape) -> Pocket {
    let (loops, _) = contour_loops(shape, 0.0);
    contour_loops(shape, CONTOUR_LENGTH - loops.length).1
}

fn contour_loops(shape: ContourShape, way_in: f64) -> (Pen, Pocket) {
    let mut pen = Pen::new();
    let (mut straight, mut sharp, mut round) = (0.0, None, None);
    if way_in > 0.0 {
        pen.straight(way_in);
        sharp = Some(pen.length);
        pen.turn(90.0);
    }
    for (index, short) in [4.0, 12.0, 20.0, 28.0].into_iter().enumerate() {
        let long = short + 20.0;
        let radius = if index < shape.sharp_loops { 0.0 } else { shape.radius };
        if index > 0 {
            pen.turn(-90.0);
            pen.straight(STEPOVER);
            pen.turn(90.0);
        }
        for (side, ends) in [(0.5 * long, 1.0), (short, 2.0), (long, 2.0), (short, 2.0)] {
            let before = pen.length;
            pen.straight(side - ends * radius);
            straight = if side == long { 0.5 * (before + pen.length) } else { straight };
            let before = pen.length;
            if radius > 0.0 {
                pen.arc(radius, 90.0, shape.chord);
                round = round.or(Some(0.5 * (before + pen.length)));
            } else {
                pen.turn(90.0);
            }
        }
        pen.straight(0.5 * long - radius);
    }
    let features = [("straight", Some(straight)), (SHARP, sharp), (ROUNDED, round)];
    let features = features.into_iter().filter_map(|(name, place)| Some((name, place?))).collect();
    (pen.clone(), Pocket { pen, length: CONTOUR_LENGTH, features })
}

/// What is free in the trochoid.
#[derive(Clone, Copy, Debug)]
pub struct TrochoidShape {
    /// Radius of the arcs, mm.
    pub radius: f64,
    /// Part of the length that is arcs.
    pub share: f64,
    /// Turn from chord to chord, degrees.
    pub chord: f64,
    /// Turn where the stepover meets the arc at either end, degrees.
    pub corner: f64,
}

/// Full circles of chords, each left and joined at an angle by a straight stepover.
pub fn trochoid(shape: TrochoidShape) -> Pocket {
    let mut pen = Pen::new();
    let circle = std::f64::consts::TAU * shape.radius;
    let straight = circle * (1.0 - shape.share) / shape.share;
    let mut features = Vec::new();
    while pen.length < TROCHOID_LENGTH {
        let before = pen.length;
        pen.turn(shape.corner);
        pen.straight(straight);
        pen.turn(-shape.corner);
        let stepover = 0.5 * (before + pen.length);
        let before = pen.length;
        pen.arc(shape.radius, 360.0, shape.chord);
        let arc = 0.5 * (before + pen.length);
        if pen.length < 0.5 * TROCHOID_LENGTH {
            features = vec![("stepover", stepover), (ARC, arc)];
        }
    }
    Pocket { pen, length: TROCHOID_LENGTH, features }
}

/// The contour that meets the rows in use best.
pub fn chosen_contour(weight_of_curves: f64) -> ContourShape {
    let mut best = (f64::INFINITY, ContourShape { sharp_loops: 0, radius: 1.0, chord: 5.0 });
    for sharp_loops in 0..=4 {
        for radius in [0.5, 1.0, 1.5, 2.0] {
            for chord in [4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0] {
                let shape = ContourShape { sharp_loops, radius, chord };
                let misfit = contour(shape).misfit(&CONTOUR, weight_of_curves);
                if misfit < best.0 {
                    best = (misfit, shape);
                }
            }
        }
    }
    best.1
}

/// The trochoid that meets the rows in use best.
pub fn chosen_trochoid(weight_of_curves: f64) -> TrochoidShape {
    rated_trochoids(weight_of_curves)[0].1
}

/// All trochoids of the grid with their misfits, the best first.
pub fn rated_trochoids(weight_of_curves: f64) -> Vec<(f64, TrochoidShape)> {
    let mut rated = Vec::new();
    for radius in [2.0, 3.0, 4.0, 5.0, 6.0] {
        for part in 8..=19 {
            for half_degrees in 8..=20 {
                for corner in [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0] {
                    let (share, chord) = (0.05 * f64::from(part), 0.5 * f64::from(half_degrees));
                    let shape = TrochoidShape { radius, share, chord, corner };
                    rated.push((trochoid(shape).misfit(&TROCHOID, weight_of_curves), shape));
                }
            }
        }
    }
    rated.sort_by(|a, b| a.0.total_cmp(&b.0));
    rated
}
