//! What a chart shows as a table, for those who do not see it and those who want its numbers.
//!
//! One row tells an equal stretch of what is in sight, as a pixel column of the picture does: least and largest of every
//! feedrate in it and its largest contour error. Straight lines between the samples are read at both ends of the stretch, so
//! that no row is empty where a curve is coarse.

use crate::plot::{Curve, Extremes, FeedChart, LostTime, Programmed};

/// A stretch of the abscissa (mm, or s over time) and what is in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Where it begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// Programmed feedrate, least and largest, mm/s; none where nothing is programmed.
    pub programmed: Option<Extremes>,
    /// Each curve in it; none where it is empty.
    pub curves: Vec<Option<Cell>>,
    /// Time lost against a recording at its end, s; none without one.
    pub lost: Option<f64>,
    /// The same against the machine after, s.
    pub lost_after: Option<f64>,
}

/// One curve in a stretch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Feedrate, least and largest, mm/s.
    pub feedrate: Extremes,
    /// Largest contour error, mm; none where there is neither a corner nor an arc.
    pub error: Option<f64>,
}

impl FeedChart {
    /// So many rows between two places of the abscissa, as far as the chart reaches.
    pub fn table(&self, (low, high): (f64, f64), rows: usize) -> Vec<Row> {
        let (low, high) = (low.max(0.0), high.min(self.length()));
        let border = |row: usize| low + (high - low) * row as f64 / rows as f64;
        let rows = if low < high { rows } else { 0 };
        (0..rows).map(|row| self.row((border(row), border(row + 1)))).collect()
    }

    fn row(&self, between: (f64, f64)) -> Row {
        let cell = |curve: &Curve| {
            let error = curve.largest_error(&self.programmed, between);
            curve.range(between).map(|feedrate| Cell { feedrate, error })
        };
        let lost = |lost: &Option<LostTime>| lost.as_ref().and_then(|lost| lost.at(between.1));
        Row {
            from: between.0,
            to: between.1,
            programmed: self.programmed.range(between),
            curves: self.curves.iter().map(cell).collect(),
            lost: lost(&self.lost),
            lost_after: lost(&self.lost_after),
        }
    }

    /// The first and the last line (of the program) between two distances, mm.
    pub fn lines(&self, between: (f64, f64)) -> Option<(u32, u32)> {
        let lines = self.programmed.line.get(self.programmed.within(between))?;
        Some((*lines.first()?, *lines.last()?))
    }
}

impl Programmed {
    /// Least and largest feedrate (mm/s) between two places.
    fn range(&self, between: (f64, f64)) -> Option<Extremes> {
        self.feedrate.extremes(self.within(between))
    }
}

impl Curve {
    /// Least and largest feedrate (mm/s) between two places.
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
        chart.curves.push(Curve::default());
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
        let curve = Curve { time: distance.clone(), distance, feedrate, ..Curve::default() };
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
