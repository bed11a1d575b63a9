//! Depth cues for a picture of lines without a surface: farther lines fade into the background, lines behind
//! their neighbours are darker (the lighting of point clouds, after Boucheny), and lines still to be run are
//! pale.
//!
//! With the nearness n of a pixel, 0 to 1 over the diagonal of the part, and n₁ … n₄ of its neighbours:
//!
//! ```text
//! colour = ((1 − f) ink + f ground) ÷ (1 + k Σ max(0, nᵢ − n)),     f = fade (1 − n)
//! ```

use plotters::style::RGBColor;

/// Part of the background in the colour of the farthest line, and of lines still to be run.
const MAX_FADE: f32 = 0.45;
const PENDING_FADE: f32 = 0.8;
/// Darkness k of a pixel behind its neighbours.
const SHADOW_STRENGTH: f32 = 9.0;
/// Least factor of a shadow on the colour.
const MIN_SHADOW_FACTOR: f32 = 0.45;

/// The lighting of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Background that distant lines fade into.
    pub ground: RGBColor,
    /// Distance of the neighbours that cast shadows, pixels.
    pub reach: usize,
    /// Index of the first edge still to be run.
    pub first_pending: u32,
}

impl Light {
    /// Returns the colour of a line without depth.
    pub fn bare(&self, ink: RGBColor, edge: u32) -> [u8; 4] {
        self.mixed(ink, if self.first_pending <= edge { PENDING_FADE } else { 0.0 }, 1.0)
    }

    /// Returns the colour of an edge at the nearness `near`, given the nearness of the neighbours, `around`.
    pub fn lit(&self, ink: RGBColor, edge: u32, near: f32, around: [f32; 4]) -> [u8; 4] {
        let above: f32 = around.iter().map(|other| (other - near).max(0.0)).sum();
        let fade = MAX_FADE * (1.0 - near);
        let fade = if self.first_pending <= edge { PENDING_FADE + (1.0 - PENDING_FADE) * fade } else { fade };
        self.mixed(ink, fade, (1.0 / (1.0 + SHADOW_STRENGTH * above)).max(MIN_SHADOW_FACTOR))
    }

    fn mixed(&self, ink: RGBColor, fade: f32, shadow: f32) -> [u8; 4] {
        let mix = |ink: u8, ground: u8| {
            (shadow * (f32::from(ink) + fade * (f32::from(ground) - f32::from(ink)))) as u8
        };
        let RGBColor(r, g, b) = self.ground;
        [mix(ink.0, r), mix(ink.1, g), mix(ink.2, b), 255]
    }
}
