//! From where the path is seen: an orthographic camera.
//!
//! ```text
//! right = (cos ψ, sin ψ, 0)
//! up    = (−sin ψ sin θ, cos ψ sin θ, cos θ)
//! x = w/2 + k (P − T)·right,     y = h/2 − k (P − T)·up
//! ```
//!
//! ψ yaw and θ pitch (rad; θ = π/2 from above, 0 from the side), T the target (mm) in the middle of a picture of
//! w × h pixels, k pixels per mm. Pixels count from the top left corner.

use std::f64::consts::FRAC_PI_2;

/// A direction to look from, and what is in the middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Turn about the vertical, rad.
    pub yaw: f64,
    /// Height above the horizon, rad.
    pub pitch: f64,
    /// What is in the middle, mm.
    pub target: [f64; 3],
    /// Pixels per mm.
    pub scale: f64,
    /// Width and height of the picture, pixels.
    pub size: (f64, f64),
}

/// What is left free around a path that is fitted, as a part of the picture.
const MARGIN: f64 = 0.08;
/// Least and greatest number of pixels per mm.
const SCALES: (f64, f64) = (1e-4, 1e5);

impl Camera {
    /// From above.
    pub fn new() -> Camera {
        Camera { yaw: 0.0, pitch: FRAC_PI_2, target: [0.0; 3], scale: 1.0, size: (1.0, 1.0) }
    }

    /// The directions of the picture: to the right and up.
    pub fn axes(&self) -> [[f64; 3]; 2] {
        let ((sy, cy), (sp, cp)) = (self.yaw.sin_cos(), self.pitch.sin_cos());
        [[cy, sy, 0.0], [-sy * sp, cy * sp, cp]]
    }

    /// Where a position (mm) is in the picture, pixels.
    pub fn project(&self, point: [f64; 3]) -> (f64, f64) {
        let along = self
            .axes()
            .map(|axis| self.scale * (0..3).map(|k| (point[k] - self.target[k]) * axis[k]).sum::<f64>());
        (0.5 * self.size.0 + along[0], 0.5 * self.size.1 - along[1])
    }

    /// Shows all of these positions, mm.
    pub fn fit(&mut self, points: &[[f32; 3]]) {
        let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        for point in points {
            for k in 0..3 {
                bounds[0][k] = bounds[0][k].min(point[k]);
                bounds[1][k] = bounds[1][k].max(point[k]);
            }
        }
        if points.is_empty() {
            bounds = [[0.0; 3]; 2];
        }
        self.target = std::array::from_fn(|k| 0.5 * (f64::from(bounds[0][k]) + f64::from(bounds[1][k])));
        let reach = self
            .axes()
            .map(|axis| (0..3).map(|k| f64::from(bounds[1][k] - bounds[0][k]) * axis[k].abs()).sum::<f64>());
        let free = 1.0 - 2.0 * MARGIN;
        let scale = (free * self.size.0 / reach[0]).min(free * self.size.1 / reach[1]);
        self.scale = if scale.is_finite() { scale.clamp(SCALES.0, SCALES.1) } else { 1.0 };
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
        let scale = (self.scale * factor).clamp(SCALES.0, SCALES.1);
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

    /// The same view in a picture of other pixels.
    pub fn resized(&self, ratio: f64) -> Camera {
        Camera { scale: self.scale * ratio, size: (self.size.0 * ratio, self.size.1 * ratio), ..*self }
    }

    /// A round length (mm) that has about 80 pixels at most.
    pub fn round_length(&self) -> f64 {
        let longest = 80.0 / self.scale;
        let power = 10f64.powf(longest.log10().floor());
        [5.0, 2.0, 1.0]
            .into_iter()
            .map(|step| step * power)
            .find(|&length| length <= longest)
            .unwrap_or(power)
    }
}

impl Default for Camera {
    fn default() -> Camera {
        Camera::new()
    }
}
