//! The colours of shades. The worse the shade, the higher its contrast with the background.
//!
//! Feedrate and loss use viridis, whose colours differ in lightness and so are distinct for any kind of
//! colour vision: on a light background from its middle to the dark end, on a dark background to the light
//! end, so that each colour has a contrast of three to one. Time lost runs from blue over grey to vermilion,
//! of Okabe and Ito.

use plotters::style::RGBColor;

use crate::plot::Theme;
use crate::plot::path::{Coloring, FIRST_SHADE_RANK, MARKED_RANK, RAPID_RANK, SHADES};

/// Viridis at equal steps.
const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 44.0, 122.0],
    [59.0, 81.0, 139.0],
    [44.0, 113.0, 142.0],
    [33.0, 144.0, 141.0],
    [39.0, 173.0, 129.0],
    [92.0, 200.0, 99.0],
    [170.0, 220.0, 50.0],
    [253.0, 231.0, 37.0],
];
const DIVERGING_LIGHT: [[f64; 3]; 3] = [[0.0, 90.0, 160.0], [140.0, 140.0, 140.0], [190.0, 70.0, 0.0]];
const DIVERGING_DARK: [[f64; 3]; 3] = [[86.0, 180.0, 233.0], [120.0, 120.0, 120.0], [255.0, 150.0, 40.0]];

/// Colours of parts, without an order.
const PARTS_LIGHT: [[u8; 3]; 8] = [
    [0, 114, 178],
    [200, 85, 0],
    [0, 135, 98],
    [170, 68, 153],
    [133, 104, 0],
    [51, 34, 136],
    [190, 40, 60],
    [90, 100, 110],
];
const PARTS_DARK: [[u8; 3]; 8] = [
    [86, 180, 233],
    [230, 159, 0],
    [44, 194, 149],
    [221, 143, 192],
    [240, 228, 66],
    [176, 164, 255],
    [255, 127, 100],
    [170, 180, 190],
];

/// Returns the colours of all shades, from the best to the worst.
pub fn palette(coloring: Coloring, dark: bool) -> [RGBColor; SHADES] {
    std::array::from_fn(|shade| {
        let part = shade as f64 / (SHADES - 1) as f64;
        match (coloring, dark) {
            (Coloring::Part, _) => {
                let [r, g, b] = (if dark { PARTS_DARK } else { PARTS_LIGHT })[shade % PARTS_LIGHT.len()];
                RGBColor(r, g, b)
            }
            (Coloring::Lost(_), false) => between(&DIVERGING_LIGHT, part),
            (Coloring::Lost(_), true) => between(&DIVERGING_DARK, part),
            (_, false) => between(&VIRIDIS, 0.55 * (1.0 - part)),
            (_, true) => between(&VIRIDIS, 0.4 + 0.6 * part),
        }
    })
}

/// Returns the background of a path.
pub fn ground(dark: bool) -> RGBColor {
    let theme = if dark { Theme::DARK } else { Theme::LIGHT };
    theme.background
}

/// Returns the colour of each rank; `None` for the empty one.
pub fn ink(shades: &[RGBColor; SHADES], dark: bool) -> [Option<RGBColor>; 32] {
    let mut inks = [None; 32];
    inks[RAPID_RANK as usize] = Some(if dark { RGBColor(70, 79, 89) } else { RGBColor(200, 206, 213) });
    for (shade, color) in shades.iter().enumerate() {
        inks[FIRST_SHADE_RANK as usize + shade] = Some(*color);
    }
    inks[MARKED_RANK as usize] = Some(if dark { RGBColor(255, 105, 160) } else { RGBColor(214, 0, 96) });
    inks
}

fn between<const N: usize>(anchors: &[[f64; 3]; N], part: f64) -> RGBColor {
    let place = part * (N - 1) as f64;
    let before = (place as usize).min(N - 2);
    let part = place - before as f64;
    let [r, g, b] =
        [0, 1, 2].map(|k| (anchors[before][k] * (1.0 - part) + anchors[before + 1][k] * part).round() as u8);
    RGBColor(r, g, b)
}
