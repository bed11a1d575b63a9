//! Views and frames: the visible part of the data, and its place on the picture.
//!
//! A view is a rectangle of data, distance in mm by feedrate in mm/s. A frame ties it to the
//! pixels of the plotting area; both axes are linear:
//!
//! ```text
//! distance = d0 + (x − left) (d1 − d0) / (right − left)
//! feedrate = f0 + (bottom − y) (f1 − f0) / (bottom − top)
//! ```

use crate::plot::Grains;

/// A rectangle of data; each side from low to high, never empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Distance along the path, mm.
    pub distance: (f64, f64),
    /// Feedrate, mm/s.
    pub feedrate: (f64, f64),
}

/// Ratio of the height of a view to the highest feedrate.
const HEADROOM_RATIO: f64 = 1.06;

/// Least part of the whole that a view may show.
const MIN_VIEW_SHARE: f64 = 1e-6;

impl View {
    /// Returns the view from zero to a length (mm) and to a feedrate (mm/s) with some room above it.
    pub fn up_to(length: f64, feedrate: f64) -> View {
        let or_one = |value: f64| if value > 0.0 && value.is_finite() { value } else { 1.0 };
        View { distance: (0.0, or_one(length)), feedrate: (0.0, HEADROOM_RATIO * or_one(feedrate)) }
    }

    /// Returns the view magnified by `factor` along the distance about the distance `center` (mm), within
    /// `whole`.
    pub fn zoomed(self, factor: f64, center: f64, whole: View) -> View {
        let (low, high) = self.distance;
        let distance = (center + (low - center) / factor, center + (high - center) / factor);
        View { distance: within(distance, whole.distance), ..self }
    }

    /// Returns the view moved by `distance` (mm) and `feedrate` (mm/s), within `whole`.
    pub fn moved(self, distance: f64, feedrate: f64, whole: View) -> View {
        View {
            distance: within((self.distance.0 + distance, self.distance.1 + distance), whole.distance),
            feedrate: within((self.feedrate.0 + feedrate, self.feedrate.1 + feedrate), whole.feedrate),
        }
    }

    /// Returns the view with the range between two distances (mm) in its middle half, with all feedrates.
    pub fn around((low, high): (f64, f64), whole: View) -> View {
        let margin = 0.5 * (high - low);
        View { distance: within((low - margin, high + margin), whole.distance), ..whole }
    }

    /// Returns the view between two distances (mm) at the same feedrates, within `whole`.
    pub fn over(self, distance: (f64, f64), whole: View) -> View {
        View { distance: within(distance, whole.distance), ..self }
    }

    /// Returns the rectangle between two corners, within `whole`.
    pub fn between(a: (f64, f64), b: (f64, f64), whole: View) -> View {
        View {
            distance: within((a.0.min(b.0), a.0.max(b.0)), whole.distance),
            feedrate: within((a.1.min(b.1), a.1.max(b.1)), whole.feedrate),
        }
    }
}

/// Returns a range shifted into `whole`, cut only if it is longer than that, and extended if it is too small.
fn within((low, high): (f64, f64), whole: (f64, f64)) -> (f64, f64) {
    let size = whole.1 - whole.0;
    let length = (high - low).clamp(MIN_VIEW_SHARE * size, size);
    let start = (0.5 * (low + high - length)).clamp(whole.0, whole.1 - length);
    (start, start + length)
}

/// The place of a view on a picture, in pixels from its top left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// The view.
    pub view: View,
    /// Left and right border of the plotting area, pixels.
    pub x: (f64, f64),
    /// Top and bottom border of the plotting area of feedrates, pixels.
    pub y: (f64, f64),
    /// Distance to the panel of the next curve below, pixels; 0 if all curves share one panel.
    pub pitch: f64,
    /// Top and bottom border of the plotting area of contour errors, pixels.
    pub errors_y: (f64, f64),
    /// Drawing of the sections in view.
    pub grains: Grains,
}

impl Frame {
    /// Returns the distance (mm) at a pixel.
    pub fn distance_at(&self, x: f64) -> f64 {
        let (low, high) = self.view.distance;
        low + (x - self.x.0) * (high - low) / (self.x.1 - self.x.0)
    }

    /// Returns the feedrate (mm/s) at a pixel.
    pub fn feedrate_at(&self, y: f64) -> f64 {
        let (low, high) = self.view.feedrate;
        let panel = if 0.0 < self.pitch { ((y - self.y.0) / self.pitch).floor().max(0.0) } else { 0.0 };
        low + (self.y.1 + panel * self.pitch - y) * (high - low) / (self.y.1 - self.y.0)
    }

    /// Returns the pixel of a distance (mm).
    pub fn x_of(&self, distance: f64) -> f64 {
        let (low, high) = self.view.distance;
        self.x.0 + (distance - low) * (self.x.1 - self.x.0) / (high - low)
    }

    /// Returns the pixel of a feedrate (mm/s).
    pub fn y_of(&self, feedrate: f64) -> f64 {
        let (low, high) = self.view.feedrate;
        self.y.1 - (feedrate - low) * (self.y.1 - self.y.0) / (high - low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: View = View { distance: (0.0, 100.0), feedrate: (0.0, 50.0) };

    #[test]
    fn zooming_keeps_the_centre_in_place() {
        let view = WHOLE.zoomed(2.0, 30.0, WHOLE);
        assert_eq!(view.distance, (15.0, 65.0));
        let frame = |view| Frame {
            view,
            x: (50.0, 850.0),
            y: (10.0, 400.0),
            pitch: 0.0,
            errors_y: (420.0, 600.0),
            grains: Grains::default(),
        };
        assert!((frame(view).x_of(30.0) - frame(WHOLE).x_of(30.0)).abs() < 1e-9);
    }

    #[test]
    fn no_view_leaves_the_whole_or_vanishes() {
        let mut view = WHOLE.zoomed(1e12, 99.999, WHOLE);
        assert!(view.distance.0 < view.distance.1 && view.distance.1 <= 100.0);
        view = view.moved(1e9, -1e9, WHOLE);
        assert!(view.distance.1 <= 100.0 && view.feedrate == WHOLE.feedrate);
        assert_eq!(view.zoomed(1e-12, 3.0, WHOLE).distance, WHOLE.distance);
        let point = View::between((5.0, 5.0), (5.0, 5.0), WHOLE);
        assert!(point.distance.0 < point.distance.1 && point.feedrate.0 < point.feedrate.1);
    }

    #[test]
    fn a_place_is_shown_with_what_is_around_it() {
        assert_eq!(View::around((40.0, 50.0), WHOLE).distance, (35.0, 55.0));
        let at_the_end = View::around((90.0, 100.0), WHOLE);
        assert!(at_the_end.distance.0 <= 90.0 && at_the_end.distance.1 == 100.0);
        let point = View::around((7.0, 7.0), WHOLE).distance;
        assert!(point.0 < point.1);
    }

    #[test]
    fn pixels_and_data_are_inverse() {
        let frame = Frame {
            view: WHOLE.zoomed(3.0, 40.0, WHOLE),
            x: (61.0, 911.0),
            y: (28.0, 377.0),
            pitch: 0.0,
            errors_y: (390.0, 500.0),
            grains: Grains::default(),
        };
        for pixel in [61.0, 200.5, 911.0] {
            assert!((frame.x_of(frame.distance_at(pixel)) - pixel).abs() < 1e-9);
            assert!((frame.y_of(frame.feedrate_at(pixel)) - pixel).abs() < 1e-9);
        }
    }
}
