//! Sizes, margins, axes and numbers common to the panels of a picture.
//!
//! plotters draws on whole pixels of the device, so that every size is in points of the page times `scale`,
//! the number of device pixels per point.

use std::ops::Range;

use plotters::chart::ChartContext;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use crate::plot::Theme;

/// An error of a backend.
pub(crate) type DrawError<B> = DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>;

/// The font, given as a family name. From a text, plotters would first search the names of generic families
/// in lower case, which needs the letters of all languages.
pub(crate) const FONT: FontFamily = FontFamily::Name("system-ui, sans-serif");
pub(crate) const FONT_SIZE_PT: f64 = 12.0;
/// Width of a wide character over the size of the font.
const CHARACTER_WIDTH_RATIO: f64 = 0.62;

/// Theme and scale of a picture.
#[derive(Clone, Copy)]
pub(crate) struct Look {
    pub theme: Theme,
    /// Device pixels per point.
    pub scale: f64,
    /// Width of the numbers of an ordinate, characters; equal in all panels, so that they align.
    pub label_characters: usize,
}

/// The plotting area of a panel, pixels of the whole picture.
pub(crate) struct Borders {
    /// Left and right.
    pub x: (f64, f64),
    /// Top and bottom.
    pub y: (f64, f64),
}

/// The axes of a panel.
pub(crate) struct Axes {
    /// Distances in view, mm.
    pub distance: (f64, f64),
    /// Title of the distance axis; `None` leaves out title and numbers.
    pub distance_title: Option<String>,
    /// Size of the unit in that title, in the unit of the distances.
    pub distance_unit_size: f64,
    /// Values in view.
    pub value: (f64, f64),
    /// Title of the values.
    pub value_title: String,
}

pub(crate) type PanelContext<'a, B> = ChartContext<'a, B, Cartesian2d<DistanceCoord, RangedCoordf64>>;

/// The coordinate of distances, with ticks at round numbers of the unit shown.
pub(crate) struct DistanceCoord {
    /// In the unit of the data.
    data: RangedCoordf64,
    /// In the unit shown.
    shown: RangedCoordf64,
    unit_size: f64,
}

impl DistanceCoord {
    fn new((low, high): (f64, f64), unit_size: f64) -> DistanceCoord {
        let shown = low / unit_size..high / unit_size;
        DistanceCoord { data: (low..high).into(), shown: shown.into(), unit_size }
    }
}

impl Ranged for DistanceCoord {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.data.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        self.shown.key_points(hint).into_iter().map(|tick| tick * self.unit_size).collect()
    }

    fn range(&self) -> Range<f64> {
        self.data.range()
    }
}

impl Look {
    /// Converts points to device pixels.
    pub fn points(&self, size: f64) -> u32 {
        (size * self.scale).round() as u32
    }

    /// Lays out a panel without drawing it.
    ///
    /// # Errors
    ///
    /// Returns an error if the backend fails.
    pub fn panel<'a, B: DrawingBackend>(
        &self,
        area: &'a DrawingArea<B, Shift>,
        axes: &Axes,
    ) -> Result<PanelContext<'a, B>, DrawError<B>> {
        let below = if axes.distance_title.is_some() { 42.0 } else { 8.0 };
        ChartBuilder::on(area)
            .margin_top(self.points(6.0))
            .margin_right(self.points(36.0))
            .margin_left(self.points(4.0))
            .margin_bottom(self.points(4.0))
            .x_label_area_size(self.points(below))
            .y_label_area_size(
                self.points(CHARACTER_WIDTH_RATIO * FONT_SIZE_PT * self.label_characters as f64 + 32.0),
            )
            .build_cartesian_2d(
                DistanceCoord::new(axes.distance, axes.distance_unit_size),
                axes.value.0..axes.value.1,
            )
    }

    /// Returns a title that fits along `pixels`: only its unit if the whole title is too long.
    fn short<'a>(&self, title: &'a str, pixels: u32) -> &'a str {
        let is_long =
            pixels < self.points(CHARACTER_WIDTH_RATIO * FONT_SIZE_PT * title.chars().count() as f64);
        let unit = title.split_once('(').and_then(|(_, rest)| rest.strip_suffix(')'));
        unit.filter(|_| is_long).unwrap_or(title)
    }

    /// Draws grid, axes and numbers.
    ///
    /// # Errors
    ///
    /// Returns an error if the backend fails.
    pub fn mesh<B: DrawingBackend>(
        &self,
        context: &mut PanelContext<B>,
        axes: &Axes,
    ) -> Result<(), DrawError<B>> {
        let Theme { text, axis, grid, .. } = self.theme;
        let font = (FONT, self.points(FONT_SIZE_PT)).into_font().color(&text);
        let (width, height) = context.plotting_area().dim_in_pixel();
        let labels =
            |pixels: u32, spacing: f64| ((f64::from(pixels) / (spacing * self.scale)) as usize).clamp(2, 12);
        let theme = &self.theme;
        let number = |(low, high): (f64, f64), unit_size: f64| {
            move |value: &f64| axis_number(theme, value / unit_size, (high - low) / unit_size)
        };
        let distance = number(axes.distance, axes.distance_unit_size);
        let value = number(axes.value, 1.0);
        let mut mesh = context.configure_mesh();
        mesh.x_labels(labels(width, 105.0))
            .y_labels(labels(height, 28.0))
            .x_label_formatter(&distance)
            .y_label_formatter(&value)
            .y_desc(self.short(&axes.value_title, height))
            .label_style(font.clone())
            .axis_desc_style(font)
            .axis_style(axis.stroke_width(self.points(1.0)))
            .bold_line_style(grid.stroke_width(self.points(1.0)))
            .light_line_style(TRANSPARENT)
            .set_all_tick_mark_size(self.points(4.0));
        match &axes.distance_title {
            Some(title) => mesh.x_desc(title).draw(),
            None => mesh.x_label_formatter(&|_| String::new()).draw(),
        }
    }
}

/// Returns the plotting area of a panel.
pub(crate) fn borders<B: DrawingBackend>(context: &PanelContext<B>) -> Borders {
    let (x, y) = context.plotting_area().get_pixel_range();
    let ends = |range: Range<i32>| (f64::from(range.start), f64::from(range.end));
    Borders { x: ends(x), y: ends(y) }
}

/// Formats a number with the decimals that an axis over `span` needs.
pub(crate) fn axis_number(theme: &Theme, value: f64, span: f64) -> String {
    let decimals = (1.5 - span.log10()).ceil().clamp(0.0, 9.0) as usize;
    (theme.numbers)(value, decimals)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_title_without_room_is_its_unit() {
        let look = Look { theme: Theme::LIGHT, scale: 2.0, label_characters: 5 };
        assert_eq!(look.short("Contour error (µm)", 300), "Contour error (µm)");
        assert_eq!(look.short("Contour error (µm)", 200), "µm");
        assert_eq!(look.short("mm/min", 10), "mm/min");
    }

    #[test]
    fn ticks_are_round_numbers_of_the_unit_shown() {
        let (mm, inches) = (DistanceCoord::new((0.0, 508.0), 1.0), DistanceCoord::new((0.0, 508.0), 25.4));
        assert_eq!(mm.key_points(6), [0.0, 100.0, 200.0, 300.0, 400.0, 500.0]);
        assert_eq!(inches.key_points(6), [0.0, 5.0, 10.0, 15.0, 20.0].map(|tick| tick * 25.4));
        assert_eq!(inches.map(&254.0, (0, 800)), 400);
    }

    #[test]
    fn numbers_on_axes_are_short_and_grouped() {
        assert_eq!(axis_number(&Theme::LIGHT, 12000.0, 12000.0), "12\u{202f}000");
        assert_eq!(axis_number(&Theme::LIGHT, 1500.0, 2000.0), "1500");
        assert_eq!(axis_number(&Theme::LIGHT, 0.5, 2.0), "0.5");
        assert_eq!(axis_number(&Theme::LIGHT, 0.0, 2.0), "0");
        assert_eq!(axis_number(&Theme::LIGHT, 123.456, 0.01), "123.456");
    }
}
