//! Edges → pixels, without a graphics card: each pixel stores its edge and its nearness.
//!
//! A pixel is one number that consists of its nearness, the rank of its shade and the index of its edge, in
//! this order. The greatest of several numbers is therefore the nearest edge, at equal nearness the worst,
//! and then the later one. Rapids lie behind everything. The work is the projection of every end of an edge
//! and the setting of visible pixels; edges within the pixel of the edge before are skipped.

use plotters::style::RGBColor;

use crate::plot::path::light::Light;
use crate::plot::path::{Camera, MARKED_RANK, RAPID_RANK, Scene};

/// Lowest bit of the rank in a pixel; below it is the index of the edge, above the rank the nearness.
const RANK_BIT: u32 = 32;
const NEAR_BIT: u32 = 40;
/// Largest nearness of an edge that is not marked.
const MAX_NEARNESS: f32 = 65534.0;

/// The settings of a drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawing {
    /// Camera.
    pub camera: Camera,
    /// Width of lines, pixels.
    pub pen: usize,
    /// Length of the dashes of rapids, pixels.
    pub dash: f32,
    /// Marked range of the path, mm.
    pub marked: Option<(f64, f64)>,
}

/// A picture of a path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Raster {
    width: usize,
    height: usize,
    pixels: Vec<u64>,
}

/// The end of an edge: pixels, and nearness.
type ProjectedPoint = [f32; 3];

/// Draws a scene over the pixels drawn before.
pub fn raster(scene: &Scene, drawing: &Drawing, into: &mut Raster) {
    let Drawing { camera, pen, dash, marked } = *drawing;
    into.width = camera.size.0.round().max(1.0) as usize;
    into.height = camera.size.1.round().max(1.0) as usize;
    into.pixels.clear();
    into.pixels.resize(into.width * into.height, 0);
    let project = projection(scene, &camera);
    let Some(&first) = scene.points.first() else { return };
    let mut from = project(first);
    let mut dashed = 0.0;
    let mut last = None;
    for (edge, &point) in scene.points[1..].iter().enumerate() {
        let to = project(point);
        let rank = scene.rank[edge];
        let value = u64::from(rank) << RANK_BIT | edge as u64;
        // Many blocks lie within one pixel.
        let pixels = (to[0] as i32, to[1] as i32, rank);
        if last != Some(pixels) || (to[0] - from[0]).abs() + (to[1] - from[1]).abs() > 1.0 {
            if rank == RAPID_RANK {
                let behind = |[x, y, _]: ProjectedPoint| [x, y, 0.0];
                into.line(behind(from), behind(to), value, pen.div_ceil(2), Some((&mut dashed, dash)));
            } else {
                into.line(from, to, value, pen, None);
            }
            last = Some(pixels);
        }
        from = to;
    }
    if let Some((begin, end)) = marked {
        let first = scene.distance.partition_point(|&distance| distance <= begin).saturating_sub(1);
        for edge in first..scene.points.len() - 1 {
            if end < scene.distance[edge] {
                break;
            }
            let [Some(a), Some(b)] = [
                scene.point(scene.distance[edge].max(begin)),
                scene.point(scene.distance[edge + 1].min(end)),
            ] else {
                break;
            };
            let [a, b] = [a, b].map(|point| {
                let [x, y, _] = project(point.map(|axis| axis as f32));
                [x, y, MAX_NEARNESS + 1.0]
            });
            let value = u64::from(MARKED_RANK) << RANK_BIT | edge as u64;
            into.line(a, b, value, 2 * pen + 1, None);
        }
    }
}

/// Returns the camera as a function of 32-bit numbers.
fn projection(scene: &Scene, camera: &Camera) -> impl Fn([f32; 3]) -> ProjectedPoint {
    let (x0, y0) = camera.project([0.0; 3]);
    let [right, up] = camera.axes().map(|axis| axis.map(|part| (part * camera.scale) as f32));
    let (x0, y0) = (x0 as f32, y0 as f32);
    // The nearest corner of the box around the cuts has the greatest nearness, and the diagonal of the box
    // spans the whole range.
    let ahead = camera.ahead();
    let [low, high] = scene.bounds.map(|corner| corner.map(f64::from));
    let nearest: f64 = (0..3).map(|k| (ahead[k] * low[k]).max(ahead[k] * high[k])).sum();
    let diagonal = (0..3).map(|k| (high[k] - low[k]).powi(2)).sum::<f64>().sqrt().max(1e-6);
    let unit = f64::from(MAX_NEARNESS) / diagonal;
    let ahead = ahead.map(|part| (part * unit) as f32);
    let offset = f64::from(MAX_NEARNESS) - nearest * unit;
    move |[x, y, z]| {
        let near = offset as f32 + ahead[0] * x + ahead[1] * y + ahead[2] * z;
        [
            x0 + right[0] * x + right[1] * y + right[2] * z,
            y0 - (up[0] * x + up[1] * y + up[2] * z),
            near.clamp(1.0, MAX_NEARNESS),
        ]
    }
}

impl Raster {
    /// Sets the pixels of a line; with a phase (pixels) the line is dashed from that phase on.
    fn line(
        &mut self,
        from: ProjectedPoint,
        to: ProjectedPoint,
        value: u64,
        pen: usize,
        phase: Option<(&mut f32, f32)>,
    ) {
        let reach = pen as f32;
        let (width, height) = (self.width as f32 + reach, self.height as f32 + reach);
        let is_beyond = |a: f32, b: f32, high: f32| (a < -reach && b < -reach) || (high < a && high < b);
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let near = |near: f32| (near as u64) << NEAR_BIT | value;
        if phase.is_none() {
            if is_beyond(from[0], to[0], width) || is_beyond(from[1], to[1], height) {
                return;
            }
            // Most blocks of a long program are no longer than a pixel.
            if dx.abs().max(dy.abs()) <= 1.0 {
                return self.column(to[0], to[1] - 0.5 * (reach - 1.0), pen, near(to[2]));
            }
        }
        let length = dx.hypot(dy);
        let (begun, dash) = match phase {
            Some((phase, dash)) => {
                let begun = *phase;
                *phase = (begun + length) % (2.0 * dash);
                (begun, dash)
            }
            None => (0.0, f32::INFINITY),
        };
        let (a, b) = ((from[0], from[1]), (to[0], to[1]));
        let Some((t0, t1)) = clipped(a, b, (-reach, width), (-reach, height)) else { return };
        let at = |t: f32| [0, 1, 2].map(|k| from[k] + t * (to[k] - from[k]));
        let (begin, end) = (at(t0), at(t1));
        let [dx, dy, dz] = [0, 1, 2].map(|k| end[k] - begin[k]);
        let pace = (t1 - t0) * length;
        let steps = dx.abs().max(dy.abs()).ceil().max(1.0);
        let is_flat = dy.abs() <= dx.abs();
        let half = 0.5 * (pen as f32 - 1.0);
        for step in 0..=steps as usize {
            let part = step as f32 / steps;
            if dash.is_finite() && dash < (begun + t0 * length + part * pace) % (2.0 * dash) {
                continue;
            }
            let (x, y) = (begin[0] + part * dx, begin[1] + part * dy);
            let value = near(begin[2] + part * dz);
            if is_flat { self.column(x, y - half, pen, value) } else { self.row(x - half, y, pen, value) }
        }
    }

    fn column(&mut self, x: f32, y: f32, pen: usize, value: u64) {
        let (x, y) = (x.floor() as i32, (y + 0.5).floor() as i32);
        if x < 0 || self.width as i32 <= x {
            return;
        }
        for y in y.max(0)..y.saturating_add(pen as i32).min(self.height as i32) {
            let pixel = &mut self.pixels[y as usize * self.width + x as usize];
            *pixel = value.max(*pixel);
        }
    }

    fn row(&mut self, x: f32, y: f32, pen: usize, value: u64) {
        let (x, y) = ((x + 0.5).floor() as i32, y.floor() as i32);
        if y < 0 || self.height as i32 <= y {
            return;
        }
        for x in x.max(0)..x.saturating_add(pen as i32).min(self.width as i32) {
            let pixel = &mut self.pixels[y as usize * self.width + x as usize];
            *pixel = value.max(*pixel);
        }
    }

    /// Returns width and height, pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Writes red, green, blue and opacity of all pixels, row by row, from the colours of the ranks and the
    /// lighting.
    pub fn colors(&self, inks: &[Option<RGBColor>; 32], light: &Light, into: &mut Vec<u8>) {
        into.clear();
        into.resize(4 * self.pixels.len(), 0);
        for (index, pixel) in self.pixels.iter().enumerate().filter(|(_, pixel)| **pixel != 0) {
            let rank = (pixel >> RANK_BIT) as u8;
            let Some(ink) = inks.get(usize::from(rank)).copied().flatten() else { continue };
            let color = if rank == RAPID_RANK || rank == MARKED_RANK {
                light.bare(ink, *pixel as u32)
            } else {
                light.lit(ink, *pixel as u32, nearness(*pixel), self.around(index, light.reach))
            };
            into[4 * index..4 * index + 4].copy_from_slice(&color);
        }
    }

    /// Returns the nearness of the pixels to the left and right, above and below at the distance `reach`; 0
    /// if there are none.
    fn around(&self, index: usize, reach: usize) -> [f32; 4] {
        let column = index % self.width;
        let at = |index: Option<usize>, is_inside: bool| {
            let pixel = index.filter(|_| is_inside).and_then(|index| self.pixels.get(index));
            pixel.map_or(0.0, |pixel| nearness(*pixel))
        };
        [
            at(index.checked_sub(reach), reach <= column),
            at(Some(index + reach), column + reach < self.width),
            at(index.checked_sub(reach * self.width), true),
            at(Some(index + reach * self.width), true),
        ]
    }

    /// Returns the distance along the path (mm) nearest to a pixel, within `reach` pixels; `None` if nothing
    /// is drawn there.
    pub fn pick(&self, scene: &Scene, camera: &Camera, (x, y): (f64, f64), reach: usize) -> Option<f64> {
        let reach = reach as i64;
        let mut found: Option<(i64, u64)> = None;
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let (column, row) = (x as i64 + dx, y as i64 + dy);
                let inside =
                    (0..self.width as i64).contains(&column) && (0..self.height as i64).contains(&row);
                let far = dx * dx + dy * dy;
                if inside && far <= reach * reach && found.is_none_or(|(nearest, _)| far < nearest) {
                    let pixel = self.pixels[row as usize * self.width + column as usize];
                    if pixel != 0 {
                        found = Some((far, pixel));
                    }
                }
            }
        }
        let edge = found?.1 as u32 as usize;
        let (a, b) = (scene.points.get(edge)?, scene.points.get(edge + 1)?);
        let [a, b] = [a, b].map(|point| camera.project(point.map(f64::from)));
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let square = dx * dx + dy * dy;
        let part =
            if 0.0 < square { ((x - a.0) * dx + (y - a.1) * dy) / square } else { 0.5 }.clamp(0.0, 1.0);
        Some(scene.distance[edge] + part * (scene.distance[edge + 1] - scene.distance[edge]))
    }
}

/// Returns the nearness of a pixel, 0 to 1.
fn nearness(pixel: u64) -> f32 {
    ((pixel >> NEAR_BIT) as f32 / MAX_NEARNESS).min(1.0)
}

/// Returns the part of a line from `a` to `b` within these bounds, as fractions of it; `None` if it is
/// outside.
fn clipped(a: (f32, f32), b: (f32, f32), xs: (f32, f32), ys: (f32, f32)) -> Option<(f32, f32)> {
    let mut inside = (0.0f32, 1.0f32);
    for (from, to, (low, high)) in [(a.0, b.0, xs), (a.1, b.1, ys)] {
        let change = to - from;
        if change == 0.0 {
            if from < low || high < from {
                return None;
            }
            continue;
        }
        let (t0, t1) = ((low - from) / change, (high - from) / change);
        inside = (inside.0.max(t0.min(t1)), inside.1.min(t0.max(t1)));
    }
    (inside.0 <= inside.1).then_some(inside)
}
