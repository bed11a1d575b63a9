//! The camera: an orthographic projection of the path.
//!
//! ```text
//! right = (cos ψ, sin ψ, 0)
//! up    = (−sin ψ sin θ, cos ψ sin θ, cos θ)
//! ahead = (sin ψ cos θ, −cos ψ cos θ, sin θ)
//! x = w/2 + k (P − T)·right,     y = h/2 − k (P − T)·up
//! ```
//!
//! ψ yaw and θ pitch (rad; θ = π/2 from above, 0 from the side), T the target (mm) in the middle of a picture of
//! w × h pixels, k pixels per mm. Pixels count from the top left corner.

use std::f64::consts::FRAC_PI_2;

use crate::plot::path::Scene;
use crate::units::LengthUnit;

/// A direction of view and its target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Turn about the vertical, rad.
    pub yaw: f64,
    /// Angle above the horizon, rad.
    pub pitch: f64,
    /// Position in the middle of the picture, mm.
    pub target: [f64; 3],
    /// Pixels per mm.
    pub scale: f64,
    /// Width and height of the picture, pixels.
    pub size: (f64, f64),
}

/// Margin around a fitted path, as a part of the picture.
const MARGIN_SHARE: f64 = 0.08;
/// Least and greatest scale, pixels per mm.
const SCALE_BOUNDS_PX_PER_MM: (f64, f64) = (1e-4, 1e5);

impl Camera {
    /// Returns a camera that looks from above.
    pub fn new() -> Camera {
        Camera { yaw: 0.0, pitch: FRAC_PI_2, target: [0.0; 3], scale: 1.0, size: (1.0, 1.0) }
    }

    /// Returns the directions to the right and up in the picture.
    pub fn axes(&self) -> [[f64; 3]; 2] {
        let ((sy, cy), (sp, cp)) = (self.yaw.sin_cos(), self.pitch.sin_cos());
        [[cy, sy, 0.0], [-sy * sp, cy * sp, cp]]
    }

    /// Returns the direction towards the viewer.
    pub fn ahead(&self) -> [f64; 3] {
        let ((sy, cy), (sp, cp)) = (self.yaw.sin_cos(), self.pitch.sin_cos());
        [sy * cp, -cy * cp, sp]
    }

    /// Returns the place of a position (mm) in the picture, pixels.
    pub fn project(&self, point: [f64; 3]) -> (f64, f64) {
        let along = self
            .axes()
            .map(|axis| self.scale * (0..3).map(|k| (point[k] - self.target[k]) * axis[k]).sum::<f64>());
        (0.5 * self.size.0 + along[0], 0.5 * self.size.1 - along[1])
    }

    /// Fits all cuts of a scene, or the whole scene if nothing is cut.
    pub fn fit(&mut self, scene: &Scene) {
        let axes = self.axes();
        let along =
            |point: &[f32; 3]| axes.map(|axis| (0..3).map(|k| axis[k] * f64::from(point[k])).sum::<f64>());
        let mut reach = [(f64::INFINITY, f64::NEG_INFINITY); 2];
        let mut take = |point: &[f32; 3]| {
            for (reach, at) in reach.iter_mut().zip(along(point)) {
                *reach = (reach.0.min(at), reach.1.max(at));
            }
        };
        for ends in scene.cut() {
            ends.iter().for_each(&mut take);
        }
        let [low, high] = scene.bounds.map(|corner| corner.map(f64::from));
        self.target = std::array::from_fn(|k| 0.5 * (low[k] + high[k]));
        if reach.iter().any(|reach| reach.1 < reach.0) {
            self.scale = 1.0;
            return;
        }
        let middle = along(&self.target.map(|axis| axis as f32));
        for (axis, (reach, middle)) in axes.iter().zip(reach.iter().zip(middle)) {
            let off = 0.5 * (reach.0 + reach.1) - middle;
            (0..3).for_each(|k| self.target[k] += off * axis[k]);
        }
        let free = 1.0 - 2.0 * MARGIN_SHARE;
        let [width, height] = reach.map(|reach| reach.1 - reach.0);
        let scale = (free * self.size.0 / width).min(free * self.size.1 / height);
        self.scale = if scale.is_finite() {
            scale.clamp(SCALE_BOUNDS_PX_PER_MM.0, SCALE_BOUNDS_PX_PER_MM.1)
        } else {
            1.0
        };
    }

    /// Moves the picture by pixels.
    pub fn pan(&mut self, dx: f64, dy: f64) {
        let [right, up] = self.axes();
        for k in 0..3 {
            self.target[k] += (up[k] * dy - right[k] * dx) / self.scale;
        }
    }

    /// Magnifies about a pixel.
    pub fn zoom(&mut self, factor: f64, (x, y): (f64, f64)) {
        let scale = (self.scale * factor).clamp(SCALE_BOUNDS_PX_PER_MM.0, SCALE_BOUNDS_PX_PER_MM.1);
        let factor = scale / self.scale;
        let (dx, dy) = (x - 0.5 * self.size.0, y - 0.5 * self.size.1);
        self.pan(dx / factor - dx, dy / factor - dy);
        self.scale = scale;
    }

    /// Turns by angles, rad; never past the poles.
    pub fn turn(&mut self, yaw: f64, pitch: f64) {
        self.yaw += yaw;
        self.pitch = (self.pitch + pitch).clamp(-FRAC_PI_2, FRAC_PI_2);
    }

    /// Returns the view in a picture of another size in pixels.
    pub fn resized(&self, ratio: f64) -> Camera {
        Camera { scale: self.scale * ratio, size: (self.size.0 * ratio, self.size.1 * ratio), ..*self }
    }

    /// Returns a length (mm) of at most about 80 pixels that is round in a unit.
    pub fn round_length(&self, unit: LengthUnit) -> f64 {
        let longest = unit.from_mm(80.0 / self.scale);
        let power = 10f64.powf(longest.log10().floor());
        let round = [5.0, 2.0, 1.0].into_iter().map(|step| step * power).find(|&length| length <= longest);
        unit.to_mm(round.unwrap_or(power))
    }
}

impl Default for Camera {
    fn default() -> Camera {
        Camera::new()
    }
}
