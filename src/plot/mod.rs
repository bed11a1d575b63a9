//! The chart of feedrate and contour error over distance: data in, picture out, on any plotters
//! backend.
//!
//! One chart has two panels. The upper one shows the programmed feedrate of every segment as steps
//! and, over it, one curve for each simulated tolerance; the lower one the contour error of each
//! beside its tolerance. The abscissa of both is the distance along the programmed path, mm,
//! which all curves share although they differ in time; the ordinates are the feedrate, mm/min,
//! and the contour error, µm.
//! Stretches of rapid motion are shaded, because the first view fits the cutting feedrates and
//! rapids may leave it at the top.
//!
//! Beside a recording the curves are the recorded and the simulated feedrate, and the lower panel shows
//! the time the recorded machine lost since the start, s, instead of the contour error.
//!
//! The same curves can be drawn over time (`over_time`), and each in a panel of its own.
//!
//! What is drawn is decimated to the pixel columns of the picture (`decimate`), so that a
//! profile of a million samples is redrawn at each turn of the wheel. A drawing returns its
//! [`Frame`], which turns pixels into data and back.

mod column;
mod decimate;
mod draw;
mod error_panel;
mod feed_panel;
mod loads;
mod lost_panel;
mod markup;
mod over_time;
mod panel;
pub mod path;
mod svg;
mod table;
mod theme;
mod tolerances;
mod view;

pub use column::{Column, Extremes};
pub use draw::draw;
pub use loads::{LoadChart, LoadCurves, draw_loads};
pub use markup::escaped;
pub use svg::{svg, svg_of_loads, svg_of_tolerances, svg_of_view};
pub use table::{Cell, Row};
pub use theme::{PALETTE, Theme};
pub use tolerances::{Mark, TimeCurve, ToleranceChart, ToleranceFrame, curve_tolerances, draw_tolerances};
pub use view::{Frame, View};

use std::ops::Range;

use crate::machine::Machine;
use crate::simulation::contour::ContourErrors;
use crate::simulation::feed::limits::rapid_feedrate;
use crate::simulation::sampled::rows_around;
use crate::simulation::toolpath::{Motion, Toolpath};

/// Everything one chart shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FeedChart {
    /// What the program asks for.
    pub programmed: Programmed,
    /// What the machine does, one curve for each tolerance.
    pub curves: Vec<Curve>,
    /// Time lost against a recording, shown instead of contour errors; none without one.
    pub lost: Option<LostTime>,
    /// The same against a machine that was changed since, drawn over it; the curves then are those of the
    /// recording, of the machine before, and of the machine after.
    pub lost_after: Option<LostTime>,
    /// What the curves are drawn over.
    pub abscissa: Abscissa,
    /// Every curve in a panel of its own instead of all in one.
    pub stacked: bool,
}

/// What curves are drawn over.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Abscissa {
    /// Distance along the programmed path, mm.
    #[default]
    Distance,
    /// Time since the start, s, as in [`FeedChart::over_time`].
    Time,
}

impl Abscissa {
    /// Its name on the axis.
    fn title(self) -> &'static str {
        match self {
            Abscissa::Distance => "Distance along the path (mm)",
            Abscissa::Time => "Time since the start (s)",
        }
    }
}

/// How much later a recorded machine is than the simulated one, over distance, straight lines between
/// the rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LostTime {
    /// Distance along the programmed path, mm; ascending, with equal values where the tool waits.
    pub distance: Vec<f64>,
    /// Time lost since the start, s.
    pub seconds: Column,
}

/// The programmed feedrate as steps over distance, one step a segment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Programmed {
    /// Where each segment ends, distance along the path, mm; ascending.
    pub end: Vec<f64>,
    /// Programmed feedrate of each segment, or the machine's rapid feedrate, mm/s.
    pub feedrate: Column,
    /// Whether each segment is a rapid move.
    pub rapid: Vec<bool>,
    /// Line of the program each segment comes from.
    pub line: Vec<u32>,
    /// The segments that are rapid moves, one range for all that follow one another.
    rapids: Vec<Range<usize>>,
    /// The highest feedrate of all others, mm/s.
    highest_cutting: f64,
}

/// One simulated profile over distance, straight lines between the rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Name in the legend.
    pub label: String,
    /// Distance along the programmed path, mm; ascending, with equal values where the tool waits.
    pub distance: Vec<f64>,
    /// Feedrate, mm/s.
    pub feedrate: Column,
    /// Time since the start, s.
    pub time: Vec<f64>,
    /// Contour tolerances and where they hold, in the order of the path.
    pub tolerances: Vec<Stretch>,
    /// Contour errors, by the segments of the programmed steps; empty where they are unknown.
    pub errors: Errors,
    /// Where segments end on the abscissa, where that is not where the programmed steps end; else empty.
    pub ends: Vec<f64>,
}

/// Contour errors, by the segments of the programmed steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors {
    /// At the corner that ends each segment and on arcs near it, mm.
    pub corner: Column,
    /// The segments that are arcs along which there is an error, by index; ascending.
    pub arcs: Vec<u32>,
    /// The largest along each of these, away from its corners, mm.
    pub along_arcs: Column,
}

/// A part of the path with one contour tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Distance along the path where it begins, mm.
    pub from: f64,
    /// Where it ends, mm; infinite for the whole path.
    pub to: f64,
    /// Contour tolerance, mm.
    pub tolerance: f64,
}

/// What a chart says about one distance.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Distance along the programmed path, mm.
    pub distance: f64,
    /// Line of the program that is run there, where there is one.
    pub line: Option<u32>,
    /// Programmed feedrate there, mm/s, where there is a segment.
    pub programmed: Option<f64>,
    /// Whether that segment is a rapid move.
    pub rapid: bool,
    /// What each curve says there; none where the curve is empty.
    pub curves: Vec<Option<CurveReading>>,
    /// Time lost up to there, s; none without a recording.
    pub lost: Option<f64>,
    /// The same against the machine after, s; none where there is but one.
    pub lost_after: Option<f64>,
}

/// What a curve says about one distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveReading {
    /// Feedrate, mm/s.
    pub feedrate: f64,
    /// Time since the start, s.
    pub time: f64,
    /// Largest contour error nearby, mm; none where neither a corner nor an arc is near.
    pub error: Option<f64>,
}

impl FeedChart {
    /// Length of the path, mm.
    pub fn length(&self) -> f64 {
        let ends = self.curves.iter().map(|curve| &curve.distance).chain([&self.programmed.end]);
        ends.filter_map(|column| column.last()).fold(0.0, |length, &end| length.max(end))
    }

    /// The first view: the whole path, with the feedrates of cutting, or of rapids as well.
    pub fn full_view(&self, with_rapids: bool) -> View {
        let Programmed { feedrate, highest_cutting: cutting, .. } = &self.programmed;
        let all = || feedrate.extremes(0..feedrate.len()).map_or(0.0, |all| all.highest);
        let top = if with_rapids || *cutting == 0.0 { all() } else { *cutting };
        View::up_to(self.length(), top)
    }

    /// Everything known about the distance `distance` (mm), and the largest contour errors within
    /// `reach` (mm) of it.
    pub fn reading(&self, distance: f64, reach: f64) -> Reading {
        let segment = self.programmed.end.partition_point(|&end| end < distance);
        let nearby = (distance - reach, distance + reach);
        let curves = self.curves.iter().map(|curve| {
            let (feedrate, time) = curve.at(distance)?;
            Some(CurveReading { feedrate, time, error: curve.largest_error(&self.programmed, nearby) })
        });
        Reading {
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

impl From<ContourErrors> for Errors {
    fn from(errors: ContourErrors) -> Errors {
        let (arcs, along_arcs) = errors.arc.into_columns();
        Errors { corner: errors.corner.into(), arcs, along_arcs: along_arcs.into() }
    }
}

impl LostTime {
    /// Time lost (s) at a distance (mm); before a wait there.
    fn at(&self, distance: f64) -> Option<f64> {
        Some(rows_around(&self.distance, distance, &mut 0)?.between(&self.seconds[..]))
    }
}

impl Programmed {
    /// The steps of a toolpath on a machine.
    pub fn of(toolpath: &Toolpath, machine: &Machine) -> Programmed {
        let (end, feedrate, rapid, line) = Programmed::columns(toolpath, machine);
        Programmed::new(end, feedrate, rapid, line)
    }

    /// Their columns, as [`Programmed::new`] takes them.
    pub fn columns(toolpath: &Toolpath, machine: &Machine) -> (Vec<f64>, Vec<f64>, Vec<bool>, Vec<u32>) {
        let (mut ends, mut feedrates, mut rapids, mut lines) = (vec![], vec![], vec![], vec![]);
        let mut end = 0.0;
        for segment in &toolpath.segments {
            end += segment.length;
            let (feedrate, rapid) = match segment.motion {
                Motion::Rapid => (rapid_feedrate(&segment, machine), true),
                Motion::Feed { feedrate } => (feedrate, false),
            };
            ends.push(end);
            feedrates.push(feedrate);
            rapids.push(rapid);
            lines.push(segment.line.0);
        }
        (ends, feedrates, rapids, lines)
    }

    /// Steps in columns of equal length: where each segment ends (mm), its feedrate (mm/s), whether it is a rapid move
    /// and its line of the program.
    pub fn new(end: Vec<f64>, feedrate: Vec<f64>, rapid: Vec<bool>, line: Vec<u32>) -> Programmed {
        let cutting = feedrate.iter().zip(&rapid).filter(|(_, rapid)| !**rapid);
        let highest_cutting = cutting.fold(0.0, |top: f64, (feedrate, _)| top.max(*feedrate));
        let mut rapids = Vec::new();
        let mut next = 0;
        for alike in rapid.chunk_by(|a, b| a == b) {
            let own = next..next + alike.len();
            next = own.end;
            if alike[0] {
                rapids.push(own);
            }
        }
        Programmed { end, feedrate: feedrate.into(), rapid, line, rapids, highest_cutting }
    }

    /// Where a segment begins, mm.
    fn start(&self, index: usize) -> f64 {
        index.checked_sub(1).map_or(0.0, |before| self.end[before])
    }

    /// The segments of which some part lies between two distances (mm).
    fn within(&self, between: (f64, f64)) -> Range<usize> {
        within(&self.end, between)
    }
}

/// The segments that end in `ends` of which some part lies between two places.
fn within(ends: &[f64], (low, high): (f64, f64)) -> Range<usize> {
    let first = ends.partition_point(|&end| end <= low);
    let last = ends.partition_point(|&end| end < high);
    first..(last + 1).min(ends.len())
}

impl Curve {
    /// Where its segments end on the abscissa.
    fn segment_ends<'a>(&'a self, programmed: &'a Programmed) -> &'a [f64] {
        if self.ends.is_empty() { &programmed.end } else { &self.ends }
    }

    /// The largest contour error (mm) between two distances (mm); none where there is neither a
    /// corner nor an arc.
    fn largest_error(&self, programmed: &Programmed, between: (f64, f64)) -> Option<f64> {
        let ends = self.segment_ends(programmed);
        self.largest_error_on(ends, within(ends, between), between.1)
    }

    /// The largest contour error (mm) on segments that end in `ends` and all begin before a place.
    fn largest_error_on(&self, ends: &[f64], segments: Range<usize>, before: f64) -> Option<f64> {
        // The last of them may have its corner beyond.
        let is_beyond = ends[segments.clone()].last().is_some_and(|&end| before < end);
        let Errors { corner, arcs, along_arcs } = &self.errors;
        let [first, end] =
            [segments.start, segments.end - usize::from(is_beyond)].map(|k| k.min(corner.len()));
        let arcs_before = |segment: usize| arcs.partition_point(|&arc| (arc as usize) < segment);
        let of_both = [
            corner.extremes(first..end),
            along_arcs.extremes(arcs_before(segments.start)..arcs_before(segments.end)),
        ];
        of_both.into_iter().flatten().map(|own| own.highest).reduce(f64::max)
    }

    /// Feedrate (mm/s) and time (s) at a distance (mm); the earliest where the tool waits there.
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
        let curve = Curve {
            label: "10 µm".to_string(),
            distance: vec![0.0, 10.0, 10.0, 20.0],
            feedrate: vec![0.0, 5.0, 5.0, 0.0].into(),
            time: vec![0.0, 4.0, 6.0, 10.0],
            tolerances: vec![Stretch { from: 0.0, to: 20.0, tolerance: 0.01 }],
            errors: Errors { corner: vec![0.012, 0.0].into(), arcs: vec![1], along_arcs: vec![0.003].into() },
            ..Curve::default()
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
        assert_eq!(Curve::default().at(1.0), None);
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
