//! The chart of feedrates over time instead of distance.
//!
//! At one moment the curves are at different places, so that the segments of each curve end at different
//! times; the programmed steps have the times of length over feedrate, without acceleration. In the resulting
//! chart every column of distances contains times, s, and the column of times distances, mm.

use crate::plot::{Abscissa, FeedChart, FeedrateCurve, Programmed, TolerancePart};
use crate::simulation::sampled::rows_around;

impl FeedChart {
    /// Returns the chart over the time since the start.
    pub fn over_time(&self) -> FeedChart {
        let curves = self.curves.iter().map(|curve| curve.over_time(&self.programmed.end)).collect();
        FeedChart {
            programmed: self.programmed.over_time(),
            curves,
            abscissa: Abscissa::Time,
            stacked: self.stacked,
            on_top: self.on_top,
            ..FeedChart::default()
        }
    }

    /// Returns the time (s) at which the first curve with rows is at a distance (mm), of a chart over
    /// distance.
    pub fn time_at(&self, distance: f64) -> Option<f64> {
        let curve = self.curves.iter().find(|curve| !curve.time.is_empty())?;
        between(&curve.distance, &curve.time, distance)
    }

    /// Returns the distance (mm) at which the first curve with rows is at a time (s), of a chart over
    /// distance.
    pub fn distance_at(&self, time: f64) -> Option<f64> {
        let curve = self.curves.iter().find(|curve| !curve.time.is_empty())?;
        between(&curve.time, &curve.distance, time)
    }
}

impl FeedrateCurve {
    fn over_time(&self, ends: &[f64]) -> FeedrateCurve {
        let time = |distance: f64| between(&self.distance, &self.time, distance).unwrap_or(0.0);
        let stretch = |stretch: &TolerancePart| {
            let to = if stretch.to.is_finite() { time(stretch.to) } else { stretch.to };
            TolerancePart { from: time(stretch.from), to, ..*stretch }
        };
        FeedrateCurve {
            label: self.label.clone(),
            distance: self.time.clone(),
            feedrate: self.feedrate.clone(),
            time: self.distance.clone(),
            tolerances: self.tolerances.iter().map(stretch).collect(),
            errors: self.errors.clone(),
            ends: ends.iter().map(|&end| time(end)).collect(),
            hidden: self.hidden,
        }
    }
}

impl Programmed {
    fn over_time(&self) -> Programmed {
        Programmed { end: self.other.clone(), other: self.end.clone(), ..self.clone() }
    }
}

/// Returns the value of the column `of` at the place where the ascending `column` has the value `value`.
fn between(column: &[f64], of: &[f64], value: f64) -> Option<f64> {
    Some(rows_around(column, value, &mut 0)?.between(of))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::CurveErrors;
    use crate::plot::tests::ramp;

    fn chart() -> FeedChart {
        let curve = |slower: f64| FeedrateCurve {
            distance: vec![0.0, 10.0, 10.0, 20.0],
            feedrate: vec![0.0, 5.0, 5.0, 0.0].into(),
            time: [0.0, 4.0, 6.0, 10.0].map(|time| slower * time).to_vec(),
            tolerances: vec![TolerancePart { from: 10.0, to: 20.0, tolerance: 0.01 }],
            errors: CurveErrors { corner: vec![0.012, 0.0].into(), ..CurveErrors::default() },
            ..FeedrateCurve::default()
        };
        let programmed = ramp().programmed;
        FeedChart { programmed, curves: vec![curve(1.0), curve(3.0)], ..FeedChart::default() }
    }

    #[test]
    fn every_curve_has_its_own_times_and_ends_with_its_cycle_time() {
        let timed = chart().over_time();
        assert_eq!(timed.programmed.end, [0.05, 1.55]);
        assert_eq!(timed.length(), 30.0);
        assert_eq!(timed.curves[0].ends, [2.0, 10.0]);
        assert_eq!(timed.curves[1].ends, [6.0, 30.0]);
        assert_eq!(timed.curves[1].tolerances[0], TolerancePart { from: 12.0, to: 30.0, tolerance: 0.01 });
    }

    #[test]
    fn errors_lie_where_their_segments_end_in_time() {
        let timed = chart().over_time();
        let errors = |time: f64| {
            timed.reading(time, 0.1).curves.iter().map(|at| at.and_then(|at| at.error)).collect::<Vec<_>>()
        };
        assert_eq!(errors(2.0), [Some(0.012), None]);
        assert_eq!(errors(6.0), [None, Some(0.012)]);
    }

    #[test]
    fn times_and_distances_are_inverse_but_in_a_wait() {
        let chart = chart();
        for distance in [0.0, 3.0, 9.9, 12.0, 20.0] {
            let time = chart.time_at(distance).expect("there is a curve");
            assert!((chart.distance_at(time).expect("there is a curve") - distance).abs() < 1e-9);
        }
        assert_eq!((chart.time_at(10.0), chart.distance_at(5.0)), (Some(4.0), Some(10.0)));
        assert_eq!(FeedChart::default().time_at(1.0), None);
    }
}
