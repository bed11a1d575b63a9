//! Edges → pixels, without a graphics card: a picture in which each pixel knows its edge.
//!
//! A pixel holds the rank of what it shows and the index of the edge, rank first, so that the greater of two numbers is
//! the worse shade, and of equal ones the later edge. The cost is that of projecting every end of an edge and of
//! setting the pixels in sight; edges within the pixel that the one before has set are left out.

use plotters::style::RGBColor;

use crate::plot::path::{Camera, MARKED, RAPID, Scene};

/// Bits of the index of an edge below its rank.
const INDEX_BITS: u32 = 27;
const INDEX: u32 = (1 << INDEX_BITS) - 1;

/// How a scene is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawing {
    /// From where.
    pub camera: Camera,
    /// Width of lines, pixels.
    pub pen: usize,
    /// Length of the dashes of rapids, pixels.
    pub dash: f32,
    /// The stretch of the path that is marked, mm.
    pub marked: Option<(f64, f64)>,
}

/// A picture of a path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Raster {
    width: usize,
    height: usize,
    pixels: Vec<u32>,
}

/// Draws a scene over what was drawn before.
pub fn raster(scene: &Scene, drawing: &Drawing, into: &mut Raster) {
    let Drawing { camera, pen, dash, marked } = *drawing;
    into.width = camera.size.0.round().max(1.0) as usize;
    into.height = camera.size.1.round().max(1.0) as usize;
    into.pixels.clear();
    into.pixels.resize(into.width * into.height, 0);
    let project = projection(&camera);
    let Some(&first) = scene.points.first() else { return };
    let mut from = project(first);
    let mut dashed = 0.0;
    let mut last = None;
    for (edge, &point) in scene.points[1..].iter().enumerate() {
        let to = project(point);
        let rank = scene.rank[edge];
        let value = u32::from(rank) << INDEX_BITS | (edge as u32 & INDEX);
        // Many blocks lie within one pixel.
        let pixels = (to.0 as i32, to.1 as i32, rank);
        if last != Some(pixels) || (to.0 - from.0).abs() + (to.1 - from.1).abs() > 1.0 {
            let phase = if rank == RAPID { Some((&mut dashed, dash)) } else { None };
            into.line(from, to, value, pen, phase);
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
            let [a, b] = [a, b].map(|point| project(point.map(|axis| axis as f32)));
            let value = u32::from(MARKED) << INDEX_BITS | (edge as u32 & INDEX);
            into.line(a, b, value, 2 * pen + 1, None);
        }
    }
}

/// A camera as a function of 32-bit numbers.
fn projection(camera: &Camera) -> impl Fn([f32; 3]) -> (f32, f32) {
    let (x0, y0) = camera.project([0.0; 3]);
    let [right, up] = camera.axes().map(|axis| axis.map(|part| (part * camera.scale) as f32));
    let (x0, y0) = (x0 as f32, y0 as f32);
    move |[x, y, z]| {
        (x0 + right[0] * x + right[1] * y + right[2] * z, y0 - (up[0] * x + up[1] * y + up[2] * z))
    }
}

impl Raster {
    /// Sets the pixels of a line; with a phase it is dashed, beginning so far (pixels) in the dashes.
    fn line(
        &mut self,
        from: (f32, f32),
        to: (f32, f32),
        value: u32,
        pen: usize,
        phase: Option<(&mut f32, f32)>,
    ) {
        let reach = pen as f32;
        let (width, height) = (self.width as f32 + reach, self.height as f32 + reach);
        let is_beyond = |a: f32, b: f32, high: f32| (a < -reach && b < -reach) || (high < a && high < b);
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        if phase.is_none() {
            if is_beyond(from.0, to.0, width) || is_beyond(from.1, to.1, height) {
                return;
            }
            // Most blocks of a long program are no longer than a pixel.
            if dx.abs().max(dy.abs()) <= 1.0 {
                return self.column(to.0, to.1 - 0.5 * (reach - 1.0), pen, value);
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
        let Some((t0, t1)) = clipped(from, to, (-reach, width), (-reach, height)) else { return };
        let at = |t: f32| (from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1));
        let ((xa, ya), (xb, yb)) = (at(t0), at(t1));
        let (dx, dy) = (xb - xa, yb - ya);
        let pace = (t1 - t0) * length;
        let steps = dx.abs().max(dy.abs()).ceil().max(1.0);
        let is_flat = dy.abs() <= dx.abs();
        let half = 0.5 * (pen as f32 - 1.0);
        for step in 0..=steps as usize {
            let part = step as f32 / steps;
            if dash.is_finite() && dash < (begun + t0 * length + part * pace) % (2.0 * dash) {
                continue;
            }
            let (x, y) = (xa + part * dx, ya + part * dy);
            if is_flat { self.column(x, y - half, pen, value) } else { self.row(x - half, y, pen, value) }
        }
    }

    fn column(&mut self, x: f32, y: f32, pen: usize, value: u32) {
        let (x, y) = (x.floor() as i32, (y + 0.5).floor() as i32);
        if x < 0 || self.width as i32 <= x {
            return;
        }
        for y in y.max(0)..y.saturating_add(pen as i32).min(self.height as i32) {
            let pixel = &mut self.pixels[y as usize * self.width + x as usize];
            *pixel = value.max(*pixel);
        }
    }

    fn row(&mut self, x: f32, y: f32, pen: usize, value: u32) {
        let (x, y) = ((x + 0.5).floor() as i32, y.floor() as i32);
        if y < 0 || self.height as i32 <= y {
            return;
        }
        for x in x.max(0)..x.saturating_add(pen as i32).min(self.width as i32) {
            let pixel = &mut self.pixels[y as usize * self.width + x as usize];
            *pixel = value.max(*pixel);
        }
    }

    /// Width and height, pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Red, green, blue and opacity of all pixels, row by row, by ranks.
    pub fn colors(&self, inks: &[Option<RGBColor>; 32], into: &mut Vec<u8>) {
        let inks = inks.map(|ink| ink.map_or([0; 4], |color| [color.0, color.1, color.2, 255]));
        into.clear();
        into.resize(4 * self.pixels.len(), 0);
        for (color, pixel) in into.chunks_exact_mut(4).zip(&self.pixels) {
            if *pixel != 0 {
                color.copy_from_slice(&inks[(pixel >> INDEX_BITS) as usize]);
            }
        }
    }

    /// The distance along the path (mm) nearest to a pixel, within `reach` pixels; none where nothing is drawn.
    pub fn pick(&self, scene: &Scene, camera: &Camera, (x, y): (f64, f64), reach: usize) -> Option<f64> {
        let reach = reach as i64;
        let mut found: Option<(i64, u32)> = None;
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let (column, row) = (x as i64 + dx, y as i64 + dy);
                let inside =
                    (0..self.width as i64).contains(&column) && (0..self.height as i64).contains(&row);
                let far = dx * dx + dy * dy;
                if inside && far <= reach * reach && found.is_none_or(|(nearest, _)| far < nearest) {
                    let pixel = self.pixels[row as usize * self.width + column as usize];
                    if pixel != 0 {
                        found = Some((far, pixel & INDEX));
                    }
                }
            }
        }
        let edge = found?.1 as usize;
        let (a, b) = (scene.points.get(edge)?, scene.points.get(edge + 1)?);
        let [a, b] = [a, b].map(|point| camera.project(point.map(f64::from)));
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let square = dx * dx + dy * dy;
        let part =
            if 0.0 < square { ((x - a.0) * dx + (y - a.1) * dy) / square } else { 0.5 }.clamp(0.0, 1.0);
        Some(scene.distance[edge] + part * (scene.distance[edge + 1] - scene.distance[edge]))
    }
}

/// The part of a line from `a` to `b` within these bounds, as fractions of it; none where it is outside.
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
