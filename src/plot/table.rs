//! A chart as a table, for readers who cannot see the chart and readers who want its numbers.
//!
//! Each row covers an equal part of the view, like a pixel column of the picture, and contains the least and
//! the largest feedrate of each curve and its largest contour error. The curves are also read at both ends of
//! the part, so that no row is empty where a curve has few points.

use crate::plot::{Extremes, FeedChart, FeedrateCurve, LostTime, Programmed};

/// A part of the abscissa (mm, or s over time) with its values.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartRow {
    /// Beginning.
    pub from: f64,
    /// End.
    pub to: f64,
    /// Least and largest programmed feedrate, mm/s; `None` if nothing is programmed.
    pub programmed: Option<Extremes>,
    /// Values of each curve; `None` for an empty one.
    pub curves: Vec<Option<CurveRange>>,
    /// Time lost against a recording at the end of the part, s; `None` without a recording.
    pub lost: Option<f64>,
    /// Time lost against the machine after a change, s.
    pub lost_after: Option<f64>,
}

/// One curve in a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveRange {
    /// Least and largest feedrate, mm/s.
    pub feedrate: Extremes,
    /// Largest contour error, mm; `None` without a corner or an arc.
    pub error: Option<f64>,
}

impl FeedChart {
    /// Returns `rows` rows between two places of the abscissa, as far as the chart reaches.
    pub fn table(&self, (low, high): (f64, f64), rows: usize) -> Vec<ChartRow> {
        let (low, high) = (low.max(0.0), high.min(self.length()));
        let border = |row: usize| low + (high - low) * row as f64 / rows as f64;
        let rows = if low < high { rows } else { 0 };
        (0..rows).map(|row| self.row((border(row), border(row + 1)))).collect()
    }

    fn row(&self, between: (f64, f64)) -> ChartRow {
        let cell = |curve: &FeedrateCurve| {
            let error = curve.largest_error(&self.programmed, between);
            curve.range(between).map(|feedrate| CurveRange { feedrate, error })
        };
        let lost = |lost: &Option<LostTime>| lost.as_ref().and_then(|lost| lost.at(between.1));
        ChartRow {
            from: between.0,
            to: between.1,
            programmed: self.programmed.range(between),
            curves: self.curves.iter().map(cell).collect(),
            lost: lost(&self.lost),
            lost_after: lost(&self.lost_after),
        }
    }

    /// Returns the first and the last line of the program between two distances, mm.
    pub fn lines(&self, between: (f64, f64)) -> Option<(u32, u32)> {
        let lines = self.programmed.line.get(self.programmed.within(between))?;
        Some((*lines.first()?, *lines.last()?))
    }
}

impl Programmed {
    /// Returns the least and the largest feedrate (mm/s) between two places.
    fn range(&self, between: (f64, f64)) -> Option<Extremes> {
        self.feedrate.extremes(self.within(between))
    }
}

impl FeedrateCurve {
    /// Returns the least and the largest feedrate (mm/s) between two places.
    fn range(&self, (low, high): (f64, f64)) -> Option<Extremes> {
        let [first, last] = [self.at(low)?.0, self.at(high)?.0];
        let inside =
            self.distance.partition_point(|&at| at < low)..self.distance.partition_point(|&at| at <= high);
        let ends = Extremes::of(first).and(Extremes::of(last));
        Some(self.feedrate.extremes(inside).map_or(ends, |inside| inside.and(ends)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::tests::ramp;

    /// A curve, and one that is empty.
    fn chart() -> FeedChart {
        let mut chart = ramp();
        chart.curves.push(FeedrateCurve::default());
        chart
    }

    #[test]
    fn rows_are_equal_stretches_with_the_extremes_of_each() {
        let rows = chart().table((-1.0, 99.0), 4);
        let ends: Vec<_> = rows.iter().map(|row| (row.from, row.to)).collect();
        assert_eq!(ends, [(0.0, 5.0), (5.0, 10.0), (10.0, 15.0), (15.0, 20.0)]);
        let feedrates: Vec<_> = rows.iter().map(|row| row.curves[0].map(|cell| cell.feedrate)).collect();
        let range = |lowest: f64, highest: f64| Some(Extremes { lowest, highest });
        assert_eq!(feedrates, [range(0.0, 2.5), range(2.5, 5.0), range(2.5, 5.0), range(0.0, 2.5)]);
        assert_eq!(rows[0].curves[0].and_then(|cell| cell.error), Some(0.012));
        assert_eq!(rows[3].curves[0].and_then(|cell| cell.error), Some(0.003));
        assert_eq!(rows[0].programmed, range(100.0, 100.0));
        assert_eq!(rows[1].programmed, range(10.0, 10.0));
        assert!(rows.iter().all(|row| row.curves[1].is_none() && row.lost.is_none()));
        assert_eq!(chart().lines((0.0, 5.0)), Some((3, 3)));
        assert_eq!(chart().lines((4.0, 6.0)), Some((3, 4)));
    }

    #[test]
    fn no_sample_falls_between_two_rows() {
        let distance: Vec<f64> = (0..=1000).map(f64::from).collect();
        let feedrate = (0..=1000).map(|k| if k % 97 == 0 { 40.0 } else { f64::from(k % 7) });
        let feedrate = feedrate.collect::<Vec<_>>().into();
        let curve = FeedrateCurve { time: distance.clone(), distance, feedrate, ..FeedrateCurve::default() };
        let chart = FeedChart { curves: vec![curve], ..FeedChart::default() };
        for rows in [1, 3, 20, 333, 5000] {
            let all = chart.table((0.0, 1000.0), rows);
            assert_eq!(all.len(), rows);
            let peaks = (0..=1000).step_by(97).map(f64::from);
            for peak in peaks {
                let row =
                    all.iter().find(|row| row.from <= peak && peak <= row.to).expect("rows leave no gap");
                assert_eq!(
                    row.curves[0].map(|cell| cell.feedrate.highest),
                    Some(40.0),
                    "{rows} rows, {peak} mm"
                );
            }
        }
    }

    #[test]
    fn what_is_out_of_reach_has_no_rows() {
        assert_eq!(chart().table((30.0, 40.0), 5), []);
        assert_eq!(FeedChart::default().table((0.0, 1.0), 5), []);
        assert_eq!(chart().table((0.0, 20.0), 0), []);
    }
}
