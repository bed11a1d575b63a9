//! Table 4: roughing, finishing of floors and finishing of walls at 8000 mm/min, rebuilt.
//!
//! Known are the lengths, CAD time × feed. Each section is taken to be curves written as chords,
//! straights between them, and sharp corners, in proportions chosen by trying a grid on some rows.

use super::path::{Pen, plan_of};

/// mm/min.
pub const FEEDRATE: f64 = 8000.0;

/// A section: times (s) at 10, 20 and 50 µm, and whether the geometry was chosen on them.
pub struct Section {
    pub name: &'static str,
    pub cam: f64,
    pub measured: [f64; 3],
    pub paper: [f64; 3],
    pub used: [bool; 3],
}

/// µm.
pub const TOLERANCES: [f64; 3] = [10.0, 20.0, 50.0];

pub const SECTIONS: [Section; 3] = [
    Section {
        name: "roughing",
        cam: 332.0,
        measured: [1017.40, 752.40, 551.52],
        paper: [1032.80, 711.05, 478.66],
        used: [true, false, true],
    },
    Section {
        name: "finish floor",
        cam: 213.0,
        measured: [543.75, 435.01, 334.37],
        paper: [606.75, 420.85, 368.28],
        used: [true, false, false],
    },
    Section {
        name: "finish walls",
        cam: 92.0,
        measured: [133.31, 125.61, 115.92],
        paper: [114.30, 111.01, 107.90],
        used: [true, false, true],
    },
];

/// What is free in a section.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Part of the length that is curves.
    pub share: f64,
    /// Turn from chord to chord, degrees.
    pub chord: f64,
    /// Sharp corners in every metre.
    pub corners: f64,
}

/// Radius of the curves, mm.
pub const RADIUS: f64 = 5.0;

impl Section {
    /// mm.
    fn length(&self) -> f64 {
        self.cam * FEEDRATE / 60.0
    }

    /// Predicted cycle time at each tolerance, s. A tenth of the section is computed, which it repeats.
    pub fn times(&self, shape: Shape) -> [f64; 3] {
        let length = 0.1 * self.length();
        let curve = std::f64::consts::PI * RADIUS;
        let straight = if shape.share > 0.0 { curve * (1.0 - shape.share) / shape.share } else { 50.0 };
        let mut pen = Pen::new();
        let mut corners = 0.0;
        let mut side = 1.0;
        while pen.length < length {
            // As many sharp corners as are due lie evenly along the straight.
            let due = ((pen.length + straight) * 1e-3 * shape.corners - corners).max(0.0).floor();
            for _ in 0..due as usize {
                pen.straight(straight / (due + 1.0));
                pen.turn(90.0);
            }
            pen.straight(straight / (due + 1.0));
            corners += due;
            if shape.share > 0.0 {
                pen.arc(RADIUS, 180.0 * side, shape.chord);
                side = -side;
            }
        }
        let toolpath = pen.toolpath(length, FEEDRATE);
        TOLERANCES.map(|tolerance| 10.0 * plan_of(&toolpath, tolerance).cycle_time())
    }

    fn misfit(&self, shape: Shape) -> f64 {
        let times = self.times(shape);
        (0..3).filter(|&k| self.used[k]).map(|k| (times[k] / self.paper[k] - 1.0).powi(2)).sum()
    }
}

/// The shapes that meet the rows in use best, section by section. The floor has only one row in use,
/// and so keeps the chords and corners of the roughing; the walls keep its chords.
pub fn chosen() -> [Shape; 3] {
    let best = |section: &Section, shapes: &[Shape]| {
        let rated = shapes.iter().map(|shape| (section.misfit(*shape), *shape));
        rated.min_by(|a, b| a.0.total_cmp(&b.0)).expect("there are shapes").1
    };
    let mut roughing = Vec::new();
    for part in 1..=10 {
        for chord in [3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0] {
            for corners in [0.0, 5.0, 10.0, 20.0, 30.0, 40.0, 60.0, 80.0] {
                roughing.push(Shape { share: 0.1 * f64::from(part) - 0.05, chord, corners });
            }
        }
    }
    let roughing = best(&SECTIONS[0], &roughing);
    let floor: Vec<Shape> = (1..20).map(|part| Shape { share: 0.05 * f64::from(part), ..roughing }).collect();
    let mut walls = Vec::new();
    for part in 0..=5 {
        for corners in 0..=15 {
            let (share, corners) = (0.02 * f64::from(part), 2.0 * f64::from(corners));
            walls.push(Shape { share, corners, ..roughing });
        }
    }
    [roughing, best(&SECTIONS[1], &floor), best(&SECTIONS[2], &walls)]
}
