//! Contact of the circle of a blended corner with the two legs.
//!
//! A circle of radius R touches two lines that turn by φ at R tan(φ/2) from the corner. An arc of radius r is convex if it
//! bends to the inner side of the turn (σ = 1), otherwise concave (σ = −1). The circle touches an arc if the distance between
//! the two centers is r − σR. Each leg sets one such condition, and both together determine the center. Of two solutions the
//! function takes the one nearer to the corner. Source: LinuxCNC 2.9, src/emc/tp/blendmath.c (blendLineArcPostProcess,
//! blendArcArcPostProcess).

use nalgebra::Vector2;

/// An arc before or behind a corner.
#[derive(Clone, Copy)]
pub struct ArcLeg {
    /// Radius, mm.
    pub radius: f64,
    /// `true` if it bends to the side of the turn.
    pub is_convex: bool,
    /// Largest angle of the arc that the circle may take, rad.
    pub most: f64,
}

/// The contact of a circle with both legs.
pub struct CircleContact {
    /// Distances before and behind the corner, mm.
    pub distances: [f64; 2],
    /// Angle of the circle between both contacts, rad.
    pub turn: f64,
}

impl ArcLeg {
    /// Returns σ.
    fn sign(&self) -> f64 {
        if self.is_convex { 1.0 } else { -1.0 }
    }
}

/// Returns the contact of a circle of `radius` (mm) with the legs of a corner that turns by `angle` (rad), of which `None`
/// is a line; `None` if the circle passes the corner at more than `tolerance` (mm) or takes too much of an arc.
pub fn contact(radius: f64, angle: f64, legs: [Option<ArcLeg>; 2], tolerance: f64) -> Option<CircleContact> {
    match legs {
        [None, None] => Some(CircleContact { distances: [radius * (0.5 * angle).tan(); 2], turn: angle }),
        [Some(arc), None] => with_line(radius, angle, arc, tolerance, 0),
        [None, Some(arc)] => with_line(radius, angle, arc, tolerance, 1),
        [Some(before), Some(after)] => with_arcs(radius, angle, [before, after], tolerance),
    }
}

/// Returns the contact with a line and an arc, which is the leg `side`.
fn with_line(radius: f64, angle: f64, arc: ArcLeg, tolerance: f64, side: usize) -> Option<CircleContact> {
    // The line runs along x to the corner at the origin; the circle lies above it, around (−x, R).
    let sign = arc.sign();
    let center = Vector2::new(-sign * arc.radius * angle.sin(), sign * arc.radius * angle.cos());
    let between = arc.radius - sign * radius;
    let root = (between * between - (radius - center.y).powi(2)).sqrt();
    let ends = [-center.x + root, -center.x - root];
    let along = ends.into_iter().map(f64::abs).reduce(f64::min).filter(|end| end.is_finite())?;
    let trimmed = trimmed_angle(center, Vector2::new(-along, radius));
    if tolerance < along.hypot(radius) - radius || arc.most < trimmed {
        return None;
    }
    let mut distances = [along; 2];
    distances[side] = trimmed * arc.radius;
    Some(CircleContact { distances, turn: angle + sign * trimmed })
}

/// Returns the contact with two arcs.
fn with_arcs(radius: f64, angle: f64, arcs: [ArcLeg; 2], tolerance: f64) -> Option<CircleContact> {
    let (sin, cos) = angle.sin_cos();
    // The first arc runs along x to the corner at the origin; the turn is to the left.
    let inward = [Vector2::y(), Vector2::new(-sin, cos)];
    let centers = [0, 1].map(|side| arcs[side].sign() * arcs[side].radius * inward[side]);
    let away = arcs.map(|arc| arc.radius - arc.sign() * radius);
    let between: Vector2<f64> = centers[1] - centers[0];
    let apart = between.norm();
    let along = (away[0].powi(2) - away[1].powi(2) + apart * apart) / (2.0 * apart);
    let beside = (away[0].powi(2) - along * along).sqrt();
    let across = Vector2::new(-between.y, between.x) / apart;
    let middle = centers[0] + along / apart * between;
    let own = if middle.dot(&across) < 0.0 { middle + beside * across } else { middle - beside * across };
    let trimmed = centers.map(|center| trimmed_angle(center, own));
    // If no circle touches both arcs, `beside` is NaN, and no comparison holds.
    let fits = (0..2).all(|side| trimmed[side] <= arcs[side].most) && own.norm() - radius <= tolerance;
    fits.then_some(CircleContact {
        distances: [0, 1].map(|side| trimmed[side] * arcs[side].radius),
        turn: angle + arcs[0].sign() * trimmed[0] + arcs[1].sign() * trimmed[1],
    })
}

/// Returns the angle that a circle with the center `own` cuts off an arc around `center` that meets the corner at the
/// origin, rad.
fn trimmed_angle(center: Vector2<f64>, own: Vector2<f64>) -> f64 {
    let (corner, contact) = (-center, own - center);
    corner.perp(&contact).abs().atan2(corner.dot(&contact))
}
