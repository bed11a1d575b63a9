//! The chart of feedrate and contour error over distance: data in, picture out, on any plotters
//! backend.
//!
//! One chart has two panels. The upper one shows the programmed feedrate of every segment as steps and, over
//! it, one curve for each simulated tolerance; the lower one the contour error of each with its tolerance.
//! The abscissa of both is the distance along the programmed path, mm, which all curves share although they
//! differ in time; the ordinates are the feedrate, mm/min, and the contour error, µm. Stretches of rapid
//! motion are shaded, because the first view fits the cutting feedrates and rapids may leave it at the top.
//!
//! With a recording the curves are the recorded and the simulated feedrate, and the lower panel shows the
//! time that the recorded machine has lost since the start, s, instead of the contour error.
//!
//! If the [`Theme`] has inches, the axes are in inches and inches per minute; data, views and frames stay in
//! mm.
//!
//! The same curves can be drawn over time (`over_time`), and each in its own panel.
//!
//! Where the curves rise and fall more often than the picture can show, their means are drawn, with a band
//! behind them (`strips`). The drawn curves are decimated to the pixel columns of the picture (`decimate`),
//! so that a profile of a million samples can be redrawn at each turn of the mouse wheel. A drawing returns
//! its [`Frame`], which converts between pixels and data.

mod column;
mod decimate;
mod draw;
mod error_panel;
mod feed_panel;
mod law;
mod loads;
mod lost_panel;
mod markup;
mod measuring;
mod over_time;
mod overview;
mod panel;
pub mod path;
mod programmed;
mod strips;
mod svg;
mod table;
mod theme;
mod tolerances;
mod view;

pub use column::{Column, Extremes};
pub use draw::draw;
pub use law::{LawChart, draw_law};
pub use loads::{LoadChart, LoadCurves, draw_loads};
pub use markup::escaped;
pub use measuring::{Measuring, TextMeasure};
pub use overview::draw_overview;
pub use programmed::Programmed;
pub use strips::{Grains, SectionGrain, Strip};
pub use svg::{svg, svg_of_law, svg_of_loads, svg_of_tolerances, svg_of_view};
pub use table::{ChartRow, CurveRange};
pub use theme::{PALETTE_SIZE, Theme};
pub use tolerances::{
    TimeCurve, ToleranceChart, ToleranceFrame, ToleranceMark, curve_tolerances, draw_tolerances,
};
pub use view::{Frame, View};

use std::ops::Range;

use crate::simulation::contour::ContourErrors;
use crate::simulation::sampled::rows_around;
use crate::units::LengthUnit;

/// Data of a chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FeedChart {
    /// The programmed feedrates.
    pub programmed: Programmed,
    /// The simulated or recorded motions, one curve per tolerance.
    pub curves: Vec<FeedrateCurve>,
    /// Time lost against a recording, shown instead of contour errors; `None` without a recording.
    pub lost: Option<LostTime>,
    /// Time lost against the machine after a change, drawn over `lost`; the curves then are those of the
    /// recording, of the machine before, and of the machine after.
    pub lost_after: Option<LostTime>,
    /// Abscissa of the curves.
    pub abscissa: Abscissa,
    /// `true` if every curve has its own panel.
    pub stacked: bool,
    /// Index of the curve that is drawn on top.
    pub on_top: usize,
}

/// The abscissa of a chart.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Abscissa {
    /// Distance along the programmed path, mm.
    #[default]
    Distance,
    /// Time since the start, s, as in [`FeedChart::over_time`].
    Time,
}

impl Abscissa {
    /// Returns the title of the axis if lengths are shown in `unit`.
    fn title(self, unit: LengthUnit) -> String {
        match self {
            Abscissa::Distance => format!("Distance along the path ({})", unit.symbol()),
            Abscissa::Time => "Time since the start (s)".to_string(),
        }
    }

    /// Returns the size of the unit in the title, mm or s.
    fn unit_size(self, unit: LengthUnit) -> f64 {
        match self {
            Abscissa::Distance => unit.in_mm(),
            Abscissa::Time => 1.0,
        }
    }
}

/// The lost time over distance: the delay of a recorded machine against the simulated one, linear between
/// rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LostTime {
    /// Distance along the programmed path, mm; ascending, with equal values where the tool waits.
    pub distance: Vec<f64>,
    /// Time lost since the start, s.
    pub seconds: Column,
}

/// One motion over distance, linear between rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FeedrateCurve {
    /// Name in the legend.
    pub label: String,
    /// Distance along the programmed path, mm; ascending, with equal values where the tool waits.
    pub distance: Vec<f64>,
    /// Feedrate, mm/s.
    pub feedrate: Column,
    /// Time since the start, s.
    pub time: Vec<f64>,
    /// Contour tolerances with their ranges, in the order of the path.
    pub tolerances: Vec<TolerancePart>,
    /// Contour errors, by the segments of the programmed steps; empty if they are unknown.
    pub errors: CurveErrors,
    /// Ends of segments on the abscissa; empty if they are those of the programmed steps.
    pub ends: Vec<f64>,
    /// `true` if the curve is not drawn.
    pub hidden: bool,
}

/// Contour errors by the segments of the programmed steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveErrors {
    /// At the corner that ends each segment and on arcs near it, mm.
    pub corner: Column,
    /// Indices of the arcs with an error along them, ascending.
    pub arcs: Vec<u32>,
    /// Largest error along each of these arcs, away from its corners, mm.
    pub along_arcs: Column,
}

/// A part of the path with one contour tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TolerancePart {
    /// Distance along the path at which the part begins, mm.
    pub from: f64,
    /// Distance along the path at which the part ends, mm; infinite for the whole path.
    pub to: f64,
    /// Contour tolerance, mm.
    pub tolerance: f64,
}

/// The values of a chart at one distance.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartValues {
    /// Distance along the programmed path, mm.
    pub distance: f64,
    /// Line of the program at the distance; `None` if there is none.
    pub line: Option<u32>,
    /// Programmed feedrate at the distance, mm/s; `None` if there is no segment.
    pub programmed: Option<f64>,
    /// `true` if the segment at the distance is a rapid move.
    pub rapid: bool,
    /// Values of each curve at the distance; `None` for an empty curve.
    pub curves: Vec<Option<CurveValues>>,
    /// Time lost up to the distance, s; `None` without a recording.
    pub lost: Option<f64>,
    /// Time lost against the machine after a change, s; `None` if there is one machine only.
    pub lost_after: Option<f64>,
}

/// The values of a curve at one distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveValues {
    /// Feedrate, mm/s.
    pub feedrate: f64,
    /// Time since the start, s.
    pub time: f64,
    /// Largest contour error nearby, mm; `None` if no corner or arc is near.
    pub error: Option<f64>,
}

impl FeedChart {
    /// Returns the length of the path, mm.
    pub fn length(&self) -> f64 {
        let ends = self.curves.iter().map(|curve| &curve.distance).chain([&self.programmed.end]);
        ends.filter_map(|column| column.last()).fold(0.0, |length, &end| length.max(end))
    }

    /// Returns the first view: the whole path, with the feedrates of cutting, and of rapids on request.
    pub fn full_view(&self, with_rapids: bool) -> View {
        let Programmed { feedrate, highest_cutting: cutting, .. } = &self.programmed;
        let all = || feedrate.extremes(0..feedrate.len()).map_or(0.0, |all| all.highest);
        let top = if with_rapids || *cutting == 0.0 { all() } else { *cutting };
        View::up_to(self.length(), top)
    }

    /// Returns the values at the distance `distance` (mm), with the largest contour errors within `reach`
    /// (mm) of it.
    pub fn reading(&self, distance: f64, reach: f64) -> ChartValues {
        let segment = self.programmed.end.partition_point(|&end| end < distance);
        let nearby = (distance - reach, distance + reach);
        let curves = self.curves.iter().map(|curve| {
            let (feedrate, time) = curve.at(distance)?;
            Some(CurveValues { feedrate, time, error: curve.largest_error(&self.programmed, nearby) })
        });
        ChartValues {
            distance,
            line: self.programmed.line.get(segment).copied(),
            programmed: self.programmed.feedrate.get(segment).copied(),
            rapid: self.programmed.rapid.get(segment).copied().unwrap_or(false),
            curves: curves.collect(),
            lost: self.lost.as_ref().and_then(|lost| lost.at(distance)),
            lost_after: self.lost_after.as_ref().and_then(|lost| lost.at(distance)),
        }
    }
}

impl From<ContourErrors> for CurveErrors {
    fn from(errors: ContourErrors) -> CurveErrors {
        let (arcs, along_arcs) = errors.arc.into_columns();
        CurveErrors { corner: errors.corner.into(), arcs, along_arcs: along_arcs.into() }
    }
}

impl LostTime {
    /// Returns the time lost (s) at a distance (mm), excluding a wait at that distance.
    fn at(&self, distance: f64) -> Option<f64> {
        Some(rows_around(&self.distance, distance, &mut 0)?.between(&self.seconds[..]))
    }
}

/// Returns the indices of the segments that end in `ends` and overlap two places.
fn within(ends: &[f64], (low, high): (f64, f64)) -> Range<usize> {
    let first = ends.partition_point(|&end| end <= low);
    let last = ends.partition_point(|&end| end < high);
    first..(last + 1).min(ends.len())
}

impl FeedrateCurve {
    /// Returns the ends of the segments on the abscissa.
    fn segment_ends<'a>(&'a self, programmed: &'a Programmed) -> &'a [f64] {
        if self.ends.is_empty() { &programmed.end } else { &self.ends }
    }

    /// Returns the largest contour error (mm) between two distances (mm); `None` without a corner or an arc.
    fn largest_error(&self, programmed: &Programmed, between: (f64, f64)) -> Option<f64> {
        let ends = self.segment_ends(programmed);
        self.largest_error_on(ends, within(ends, between), between.1)
    }

    /// Returns the largest contour error (mm) on segments that end in `ends` and all begin before a place.
    fn largest_error_on(&self, ends: &[f64], segments: Range<usize>, before: f64) -> Option<f64> {
        // The last segment may end, at its corner, beyond the place.
        let is_beyond = ends[segments.clone()].last().is_some_and(|&end| before < end);
        let CurveErrors { corner, arcs, along_arcs } = &self.errors;
        let [first, end] =
            [segments.start, segments.end - usize::from(is_beyond)].map(|k| k.min(corner.len()));
        let arcs_before = |segment: usize| arcs.partition_point(|&arc| (arc as usize) < segment);
        let of_both = [
            corner.extremes(first..end),
            along_arcs.extremes(arcs_before(segments.start)..arcs_before(segments.end)),
        ];
        of_both.into_iter().flatten().map(|own| own.highest).reduce(f64::max)
    }

    /// Returns feedrate (mm/s) and time (s) at a distance (mm); if the tool waits there, those at the
    /// beginning of the wait.
    fn at(&self, distance: f64) -> Option<(f64, f64)> {
        let rows = rows_around(&self.distance, distance, &mut 0)?;
        Some((rows.between(&self.feedrate[..]), rows.between(&self.time[..])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From rest to 5 mm/s over 10 mm, a wait, and back to rest over as much; a rapid of 5 mm before a cut of 15 mm.
    pub(super) fn ramp() -> FeedChart {
        let curve = FeedrateCurve {
            label: "10 µm".to_string(),
            distance: vec![0.0, 10.0, 10.0, 20.0],
            feedrate: vec![0.0, 5.0, 5.0, 0.0].into(),
            time: vec![0.0, 4.0, 6.0, 10.0],
            tolerances: vec![TolerancePart { from: 0.0, to: 20.0, tolerance: 0.01 }],
            errors: CurveErrors {
                corner: vec![0.012, 0.0].into(),
                arcs: vec![1],
                along_arcs: vec![0.003].into(),
            },
            ..FeedrateCurve::default()
        };
        let programmed = Programmed::new(vec![5.0, 20.0], vec![100.0, 10.0], vec![true, false], vec![3, 4]);
        FeedChart { programmed, curves: vec![curve], ..FeedChart::default() }
    }

    #[test]
    fn reads_between_samples_and_at_waits() {
        let chart = ramp();
        assert_eq!(chart.curves[0].at(5.0), Some((2.5, 2.0)));
        assert_eq!(chart.curves[0].at(10.0), Some((5.0, 4.0)));
        assert_eq!(chart.curves[0].at(20.0), Some((0.0, 10.0)));
        assert_eq!(chart.curves[0].at(99.0), Some((0.0, 10.0)));
        assert_eq!(FeedrateCurve::default().at(1.0), None);
    }

    #[test]
    fn reads_the_largest_contour_error_nearby() {
        let chart = ramp();
        let error =
            |distance: f64| chart.reading(distance, 0.5).curves[0].expect("the curve is not empty").error;
        assert_eq!(error(2.0), None);
        assert_eq!(error(4.6), Some(0.012));
        assert_eq!(error(5.4), Some(0.012));
        assert_eq!(error(12.0), Some(0.003));
        assert_eq!(error(20.0), Some(0.003));
    }

    #[test]
    fn a_boundary_belongs_to_the_segment_that_ends_there() {
        let chart = ramp();
        assert_eq!(chart.reading(5.0, 0.1).line, Some(3));
        assert_eq!(chart.reading(5.1, 0.1).line, Some(4));
        assert_eq!(chart.reading(21.0, 0.1).line, None);
    }

    #[test]
    fn the_first_view_fits_cutting_unless_rapids_are_wanted() {
        let chart = ramp();
        let (cutting, all) = (chart.full_view(false), chart.full_view(true));
        assert_eq!(cutting.distance, (0.0, 20.0));
        assert!(10.0 < cutting.feedrate.1 && cutting.feedrate.1 < 100.0);
        assert!(100.0 < all.feedrate.1);
    }
}
