//! The colours of a picture, on light and on dark ground, its number format and its unit of length.

use plotters::style::RGBColor;

use crate::units::LengthUnit;

/// Colours of a picture, its numbers and its unit of length.
#[derive(Clone, Copy, Debug)]
pub struct Theme {
    /// Background of the picture.
    pub background: RGBColor,
    /// Text.
    pub text: RGBColor,
    /// Grid lines.
    pub grid: RGBColor,
    /// Ranges of rapid motion.
    pub rapid: RGBColor,
    /// Axes and their ticks.
    pub axis: RGBColor,
    /// The programmed feedrate: broad and pale, so that it remains visible on both sides of a curve drawn
    /// over it.
    pub programmed: RGBColor,
    /// Curves in their order.
    pub curves: [RGBColor; PALETTE_SIZE],
    /// Opacity of the band behind a curve.
    pub band: f64,
    /// Formats a number with at most this number of decimals.
    pub numbers: fn(f64, usize) -> String,
    /// Unit of lengths and feedrates.
    pub unit: LengthUnit,
}

/// Number of curves with a colour each.
pub const PALETTE_SIZE: usize = 6;

impl Theme {
    /// Dark on white. The curves have the colours of Okabe and Ito, which people with any kind of colour
    /// vision can distinguish.
    pub const LIGHT: Theme = Theme {
        background: RGBColor(255, 255, 255),
        text: RGBColor(64, 72, 82),
        grid: RGBColor(229, 232, 236),
        rapid: RGBColor(243, 244, 246),
        axis: RGBColor(120, 128, 138),
        programmed: RGBColor(196, 202, 210),
        curves: [
            RGBColor(0, 114, 178),
            RGBColor(213, 94, 0),
            RGBColor(0, 158, 115),
            RGBColor(204, 121, 167),
            RGBColor(230, 159, 0),
            RGBColor(86, 180, 233),
        ],
        band: 0.12,
        numbers: grouped,
        unit: LengthUnit::Millimetre,
    };

    /// Light on dark, with the same colours in an order that begins with the light ones.
    pub const DARK: Theme = Theme {
        background: RGBColor(22, 26, 31),
        text: RGBColor(190, 198, 207),
        grid: RGBColor(45, 51, 59),
        rapid: RGBColor(31, 36, 43),
        axis: RGBColor(135, 145, 156),
        programmed: RGBColor(84, 94, 105),
        curves: [
            RGBColor(86, 180, 233),
            RGBColor(230, 159, 0),
            RGBColor(0, 158, 115),
            RGBColor(204, 121, 167),
            RGBColor(240, 228, 66),
            RGBColor(213, 94, 0),
        ],
        band: 0.16,
        numbers: grouped,
        unit: LengthUnit::Millimetre,
    };
}

/// Formats a number with at most `decimals` decimals, thousands separated by a thin space.
fn grouped(value: f64, decimals: usize) -> String {
    let text = format!("{:.decimals$}", value + 0.0);
    let (whole, fraction) = text.split_once('.').unwrap_or((&text, ""));
    let (sign, digits) = whole.strip_prefix('-').map_or(("", whole), |digits| ("−", digits));
    let mut out = sign.to_string();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && digits.len() > 4 && (digits.len() - place) % 3 == 0 {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    let fraction = fraction.trim_end_matches('0');
    if fraction.is_empty() { out } else { format!("{out}.{fraction}") }
}
