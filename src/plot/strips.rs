//! Strips: a curve that rises and falls more often than the picture can show is drawn as its mean, with a
//! band behind it.
//!
//! The abscissa is divided into sections, and these into strips. The mean feedrate of a strip is its length
//! ΔS over its time ΔT: length ÷ height is time, for any width of the strips and including waits. Behind the
//! mean the band covers all but the slowest and the fastest tenth of the strip, and a paler band below it
//! reaches down to the least feedrate.
//!
//! ```text
//! | section: exact | 12 strips: means | 12 strips: means | section: exact |
//! ```
//!
//! Each section has the finest drawing that rises and falls by at most [`MAX_RISE_HEIGHTS`] and so still
//! looks like a line: exact, or strips of 4, 8 or 16 points. All curves of a chart have the same drawing in a
//! section, so that they can be compared, and hiding one of them does not change the others. Sections begin
//! at multiples of their width, and do not change when the user moves the picture.

use crate::plot::decimate::count_before;
use crate::plot::{Abscissa, Extremes, FeedChart, FeedrateCurve, Programmed, View};
use crate::simulation::sampled::{RowsAround, rows_around};

/// Width of the finest strips, points.
const MIN_STRIP_PT: f64 = 4.0;
/// Number of finest strips in a section.
const STRIPS_PER_SECTION: usize = 12;
/// Possible numbers of finest strips that are drawn as one strip.
const STRIPS_PER_MEAN: [usize; 3] = [1, 2, 4];
/// Largest rise and fall of a line in a section, in heights of the panel: once from bottom to top and back,
/// with a margin.
const MAX_RISE_HEIGHTS: f64 = 2.2;
/// Number of places at which a strip is read for its band.
const READINGS_PER_STRIP: usize = 20;
/// Number of the least, and of the largest, of these readings that the band leaves out.
const READINGS_OUTSIDE_BAND: usize = READINGS_PER_STRIP / 10;

/// The drawing of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SectionGrain {
    /// Every sample is drawn.
    Exact,
    /// Means of strips, each of this number of finest strips.
    Means(usize),
}

/// The drawing of each section in view.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grains {
    /// Width of the finest strips on the abscissa; 0 if nothing is drawn.
    strip: f64,
    /// Index of the first section, counted from 0 on the abscissa.
    first: usize,
    sections: Vec<SectionGrain>,
}

/// A strip as drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strip {
    /// Beginning and end on the abscissa.
    pub ends: (f64, f64),
    /// Mean feedrate, mm/s.
    pub mean: f64,
    /// Least and largest feedrate without the slowest and the fastest tenth, mm/s.
    pub band: Extremes,
    /// Least and largest feedrate, mm/s.
    pub all: Extremes,
}

/// A quantity over the abscissa with the columns for its means.
#[derive(Clone, Copy)]
pub(crate) struct QuantityLine<'a> {
    abscissa: Abscissa,
    at: &'a [f64],
    /// Time over distance, or distance over time.
    other: &'a [f64],
}

impl<'a> QuantityLine<'a> {
    pub fn of_curve(chart: &FeedChart, curve: &'a FeedrateCurve) -> QuantityLine<'a> {
        QuantityLine { abscissa: chart.abscissa, at: &curve.distance, other: &curve.time }
    }

    pub fn of_programmed(chart: &FeedChart, programmed: &'a Programmed) -> QuantityLine<'a> {
        QuantityLine { abscissa: chart.abscissa, at: &programmed.end, other: &programmed.other }
    }

    /// Returns the end of the line on the abscissa.
    fn end(&self) -> f64 {
        self.at.last().copied().unwrap_or(0.0)
    }

    /// Returns the mean feedrates (mm/s) between ascending borders; `None` beyond the end of the line.
    pub fn means(&self, borders: &[f64]) -> Vec<Option<f64>> {
        let mut rows = AscendingReader::of(self.at);
        let mut last: Option<(f64, f64)> = None;
        let mut means = Vec::new();
        for &border in borders {
            let at = border.max(0.0).min(self.end());
            let other = self.other_at(at, &mut rows);
            if let Some((from, before)) = last {
                let (along, across) = (at - from, other - before);
                let (way, time) = match self.abscissa {
                    Abscissa::Distance => (along, across),
                    Abscissa::Time => (across, along),
                };
                means.push((0.0 < along && 0.0 < time).then(|| way / time));
            }
            last = Some((at, other));
        }
        means
    }

    /// Returns the other quantity at a place: before a wait at that place, except at the end, where it is
    /// after the wait.
    fn other_at(&self, at: f64, rows: &mut AscendingReader) -> f64 {
        let (Some(&first), Some(&last)) = (self.at.first(), self.other.last()) else { return 0.0 };
        if self.end() <= at {
            last
        } else if at <= first {
            // Segments begin at the start of the path, curves at their first row.
            self.other[0] * if 0.0 < first { at / first } else { 1.0 }
        } else {
            rows.around(at).map_or(last, |around| around.between(self.other))
        }
    }
}

/// A reader of ascending places in an ascending column, which searches from the last place on.
struct AscendingReader<'a> {
    at: &'a [f64],
    row: usize,
    likely: usize,
}

impl<'a> AscendingReader<'a> {
    fn of(at: &'a [f64]) -> AscendingReader<'a> {
        AscendingReader { at, row: 0, likely: at.len() / 2 }
    }

    fn around(&mut self, place: f64) -> Option<RowsAround> {
        self.likely = count_before(&self.at[self.row..], place, self.likely);
        self.row = (self.row + self.likely).saturating_sub(1);
        rows_around(self.at, place, &mut self.row)
    }
}

impl Grains {
    /// Returns the drawing of each section of a chart in a view that is `width` points wide; `exact` holds
    /// each curve decimated to its pixels.
    pub(crate) fn of(chart: &FeedChart, exact: &[Vec<(f64, f64)>], view: View, width: f64) -> Grains {
        let (low, high) = view.distance;
        let strip = MIN_STRIP_PT * (high - low) / width;
        let width = strip * STRIPS_PER_SECTION as f64;
        let first = (low.max(0.0) / width) as usize;
        let count = ((high / width).ceil() as usize).saturating_sub(first).max(1);
        let mut grains = Grains { strip, first, sections: vec![SectionGrain::Exact; count] };
        for (curve, exact) in chart.curves.iter().zip(exact) {
            let rises = grains.rises(exact.iter().copied(), view);
            let line = QuantityLine::of_curve(chart, curve);
            let by_group = STRIPS_PER_MEAN.map(|group| {
                let whole = (grains.border(0), grains.border(count * STRIPS_PER_SECTION));
                let borders = grains.borders(group, whole);
                let points = borders.iter().zip(line.means(&borders));
                grains.rises(points.filter_map(|(at, mean)| Some((*at, mean?))), view)
            });
            for (section, grain) in grains.sections.iter_mut().enumerate() {
                if rises[section] <= MAX_RISE_HEIGHTS {
                    continue;
                }
                let fine = (0..STRIPS_PER_MEAN.len() - 1).find(|&k| by_group[k][section] <= MAX_RISE_HEIGHTS);
                let group = STRIPS_PER_MEAN[fine.unwrap_or(STRIPS_PER_MEAN.len() - 1)];
                *grain = match *grain {
                    SectionGrain::Means(coarser) if group < coarser => *grain,
                    _ => SectionGrain::Means(group),
                };
            }
        }
        grains
    }

    /// Returns the beginning of a finest strip, counted from the first section.
    fn border(&self, strip: usize) -> f64 {
        self.strip * (self.first * STRIPS_PER_SECTION + strip) as f64
    }

    /// Returns the section of a place, or the nearest section in view.
    fn section(&self, at: f64) -> usize {
        let section = (at / (self.strip * STRIPS_PER_SECTION as f64)) as usize;
        section.saturating_sub(self.first).min(self.sections.len().saturating_sub(1))
    }

    /// Returns the rise and fall of a polyline in each section, in heights of the view.
    fn rises(&self, points: impl Iterator<Item = (f64, f64)>, view: View) -> Vec<f64> {
        let (low, high) = view.feedrate;
        let mut rises = vec![0.0; self.sections.len()];
        let mut last = None;
        for (at, feedrate) in points {
            let feedrate = feedrate.clamp(low, high);
            if let Some(before) = last {
                rises[self.section(at)] += f64::abs(feedrate - before) / (high - low);
            }
            last = Some(feedrate);
        }
        rises
    }

    /// Returns the runs of sections drawn alike, with their range on the abscissa.
    pub(crate) fn runs(&self) -> impl Iterator<Item = (SectionGrain, (f64, f64))> {
        let mut next = 0;
        self.sections.chunk_by(|a, b| a == b).map(move |alike| {
            let first = next;
            next += alike.len();
            (alike[0], (self.border(first * STRIPS_PER_SECTION), self.border(next * STRIPS_PER_SECTION)))
        })
    }

    /// Returns the borders of the strips of `group` finest ones between two places of [`Grains::runs`].
    pub(crate) fn borders(&self, group: usize, (from, to): (f64, f64)) -> Vec<f64> {
        let width = self.strip * group as f64;
        let [first, last] = [from, to].map(|end| (end / width).round() as usize);
        (first..=last).map(|k| width * k as f64).collect()
    }

    /// Returns the strip of a curve at a place; `None` in an exact section or outside the curve.
    pub fn strip_at(&self, chart: &FeedChart, curve: &FeedrateCurve, at: f64) -> Option<Strip> {
        let SectionGrain::Means(group) = *self.sections.get(self.section(at))? else { return None };
        let width = self.strip * group as f64;
        let from = width * (at / width).floor();
        strips(chart, curve, &[from, from + width]).pop()
    }
}

/// Returns the strips of a curve between ascending borders, as far as it reaches.
pub(crate) fn strips(chart: &FeedChart, curve: &FeedrateCurve, borders: &[f64]) -> Vec<Strip> {
    let line = QuantityLine::of_curve(chart, curve);
    let means = line.means(borders);
    let ends = borders.windows(2).map(|ends| (ends[0], ends[1].min(line.end())));
    let (mut rows, mut sides) = (AscendingReader::of(&curve.distance), AscendingReader::of(&curve.distance));
    let mut strips = Vec::new();
    for ((from, to), mean) in ends.zip(means) {
        let Some(mean) = mean else { continue };
        // The readings, sorted as they are added.
        let mut read = [mean; READINGS_PER_STRIP];
        for k in 0..READINGS_PER_STRIP {
            let at = from + (to - from) * (k as f64 + 0.5) / READINGS_PER_STRIP as f64;
            let feedrate = rows.around(at).map_or(mean, |rows| rows.between(&curve.feedrate[..]));
            let place = read[..k].partition_point(|other| *other < feedrate);
            read.copy_within(place..k, place + 1);
            read[place] = feedrate;
        }
        let band = Extremes {
            lowest: read[READINGS_OUTSIDE_BAND],
            highest: read[READINGS_PER_STRIP - 1 - READINGS_OUTSIDE_BAND],
        };
        let seen = Extremes { lowest: read[0], highest: read[READINGS_PER_STRIP - 1] };
        let [first, end] = [from, to].map(|side| sides.around(side).map_or(0, |rows| rows.after));
        let all = curve.feedrate.extremes(first..end).map_or(seen, |inside| inside.and(seen));
        strips.push(Strip { ends: (from, to), mean, band, all });
    }
    strips
}

#[cfg(test)]
mod tests {
    use plotters::prelude::SVGBackend;

    use super::*;
    use crate::machine::presets;
    use crate::plot::decimate::decimated;
    use crate::plot::{Frame, Theme, draw};
    use crate::simulation::feed::Tolerances;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;
    use crate::simulation::profile::Profile;
    use crate::simulation::simulate;

    /// Programs of more than 2,000 blocks, each of another kind.
    fn programs() -> Vec<(&'static str, String)> {
        let head = "G21 G90 G94\nG0 X0 Y0 Z5\nG1 Z0 F1200\n";
        let text = |lines: &mut dyn Iterator<Item = String>| {
            head.to_string() + &lines.collect::<Vec<_>>().join("\n")
        };
        let surface = |k: u32| {
            let (row, column) = (k / 100, k % 100);
            let x = 0.5 * f64::from(if row % 2 == 0 { column } else { 99 - column });
            let z = 2.0 * (0.3 * x).sin();
            format!("G1 X{x:.3} Y{:.2} Z{z:.3} F{}", 0.4 * f64::from(row), 2000 + 60 * (row % 20))
        };
        let pocket = |k: u32| {
            // There and back, and on: a corner after each 2 to 8 mm.
            let (x, y) =
                (f64::from(k.div_ceil(2) % 2) * (2.0 + f64::from(k / 2 % 7)), 0.5 * f64::from(k / 2));
            format!("G1 X{x:.2} Y{y:.2} F3000")
        };
        let holes = |k: u32| match k % 3 {
            0 => format!("G0 X{} Y{}", 8 * (k / 3 % 30), 8 * (k / 90)),
            1 => "G1 Z-6 F400".to_string(),
            _ => "G0 Z2".to_string(),
        };
        let loops = |k: u32| {
            format!(
                "G3 X{:.2} Y0 I{:.2} J0 F2500",
                0.6 * f64::from(k + 1) + 2.0 * f64::from(k % 2),
                1.0 + 0.1 * f64::from(k % 5)
            )
        };
        let chords = |k: u32| {
            let turn = 0.09 * f64::from(k);
            format!(
                "G1 X{:.3} Y{:.3} F4000",
                (3.0 + 0.02 * turn) * turn.cos(),
                (3.0 + 0.02 * turn) * (1.3 * turn).sin()
            )
        };
        vec![
            ("surface", text(&mut (0..2400).map(surface))),
            ("pocket", text(&mut (0..2400).map(pocket))),
            ("holes", text(&mut (0..2400).map(holes))),
            ("loops", text(&mut (0..2100).map(loops))),
            ("chords", text(&mut (0..2400).map(chords))),
        ]
    }

    /// A program for three tolerances on a machine that has to slow down for them.
    fn chart_of(program: &str) -> FeedChart {
        let machine = presets().swap_remove(0).machine;
        let toolpath = trace(&read(program.as_bytes()), &machine);
        let curves = [0.01, 0.02, 0.05].map(|tolerance| {
            let (plan, errors) =
                simulate::within(&toolpath, &machine, Tolerances::One(tolerance), &mut |_| {});
            let curve = Profile::new(&toolpath, &plan).drawn();
            FeedrateCurve {
                label: format!("{} µm", 1000.0 * tolerance),
                distance: curve.distance,
                feedrate: curve.feedrate.into(),
                time: curve.time,
                errors: errors.into(),
                ..FeedrateCurve::default()
            }
        });
        FeedChart {
            programmed: Programmed::of(&toolpath, &machine),
            curves: curves.to_vec(),
            ..FeedChart::default()
        }
    }

    /// Returns the drawing of a chart over 1,000 pixels.
    fn grains_of(chart: &FeedChart, view: View) -> Grains {
        let exact = |curve: &FeedrateCurve| decimated(&curve.distance, &curve.feedrate, view.distance, 1000);
        Grains::of(chart, &chart.curves.iter().map(exact).collect::<Vec<_>>(), view, 1000.0)
    }

    const SIZE: (u32, u32) = (1100, 500);

    /// The index of a curve, and pixels that it goes through.
    type Polyline = (usize, Vec<(f64, f64)>);

    /// Returns the polylines of the three curves in drawing order, pixels, and the frame.
    fn drawn(chart: &FeedChart, view: View) -> (Vec<Polyline>, Frame) {
        let mut text = String::new();
        let frame = draw(chart, view, &Theme::LIGHT, 1.0, false, SVGBackend::with_string(&mut text, SIZE))
            .expect("an SVG in memory can be drawn");
        let color = |index: usize| {
            let c = Theme::LIGHT.curves[index];
            format!("stroke=\"#{:02X}{:02X}{:02X}\"", c.0, c.1, c.2)
        };
        let colors = [0, 1, 2].map(color);
        let lines = text.lines().filter(|line| line.starts_with("<polyline")).filter_map(|line| {
            let index = colors.iter().position(|color| line.contains(color))?;
            let points = line.split("points=\"").nth(1)?.split('"').next()?;
            let points = points.split_whitespace().filter_map(|pair| {
                let (x, y) = pair.split_once(',')?;
                Some((x.parse().ok()?, y.parse().ok()?))
            });
            Some((index, points.collect::<Vec<(f64, f64)>>()))
        });
        let lines =
            lines.filter(|(_, points)| points.iter().all(|point| point.1 <= frame.y.1 + 2.0)).collect();
        (lines, frame)
    }

    /// The picture of the feedrates: which curve a pixel shows.
    fn pixels(lines: &[Polyline], frame: &Frame) -> Vec<Vec<Option<usize>>> {
        let (width, height) = (SIZE.0 as usize, frame.y.1 as usize + 2);
        let mut pixels = vec![vec![None; height]; width];
        for (index, points) in lines {
            for pair in points.windows(2) {
                let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
                let steps = 2.0 * f64::max((x1 - x0).abs(), (y1 - y0).abs()).ceil().max(1.0);
                for step in 0..=steps as usize {
                    let part = step as f64 / steps;
                    let (x, y) = (x0 + part * (x1 - x0), y0 + part * (y1 - y0));
                    // Lines are two pixels wide.
                    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                        let place = (x as usize + dx, y as usize + dy);
                        if let Some(pixel) =
                            pixels.get_mut(place.0).and_then(|column| column.get_mut(place.1))
                        {
                            *pixel = Some(*index);
                        }
                    }
                }
            }
        }
        pixels
    }

    /// Half the widest strip, pixels.
    const REACH: usize = 8;

    #[test]
    fn curves_of_long_programs_are_lines_that_can_be_told_apart() {
        for (name, program) in programs() {
            let chart = chart_of(&program);
            assert!(2000 < chart.programmed.end.len(), "{name}");
            let (lines, frame) = drawn(&chart, chart.full_view(false));
            let pixels = pixels(&lines, &frame);
            let (left, right) = (frame.x.0 as usize + 3, frame.x.1 as usize - 3);
            let columns = &pixels[left..right];
            let inked = columns.iter().flatten().flatten().count() as f64;
            let share = inked / (columns.len() as f64 * (frame.y.1 - frame.y.0));
            assert!(share <= 0.25, "{name}: ink on {share} of the plot");
            // Where a curve is not seen itself it is under one that is as fast there, or beyond the top.
            let strips: Vec<_> = chart.curves.iter().map(|curve| by_pixel(&chart, curve, &frame)).collect();
            for (index, own) in strips.iter().enumerate() {
                // On a slope the one below is beside the one above, for less than a strip.
                let near = |x: usize| x.saturating_sub(REACH)..(x + REACH).min(pixels.len());
                let seen = (left..right).filter(|&x| {
                    let is_covered =
                        |(other, all): (usize, &Vec<f64>)| other != index && (all[x] - own[x]).abs() <= 3.0;
                    pixels[near(x)].iter().any(|column| column.contains(&Some(index)))
                        || strips.iter().enumerate().any(is_covered)
                });
                let part = seen.count() as f64 / (right - left) as f64;
                assert!(0.95 <= part, "{name}: curve {index} can be traced over {part} of the width");
            }
        }
    }

    /// Where a curve lies in each pixel column by what the frame says, pixels.
    fn by_pixel(chart: &FeedChart, curve: &FeedrateCurve, frame: &Frame) -> Vec<f64> {
        let y = |x: u32| {
            let at = frame.distance_at(f64::from(x));
            let strip = frame.grains.strip_at(chart, curve, at).map(|strip| strip.mean);
            frame.y_of(strip.or(curve.at(at).map(|at| at.0)).unwrap_or(0.0)).max(frame.y.0)
        };
        (0..SIZE.0).map(y).collect()
    }

    #[test]
    fn length_over_mean_is_the_time_at_every_zoom() {
        for (name, program) in programs() {
            let chart = chart_of(&program);
            let timed = chart.over_time();
            for parts in [1.0, 7.0, 60.0] {
                for (chart, is_timed) in [(&chart, false), (&timed, true)] {
                    let whole = chart.full_view(false);
                    let view = whole.zoomed(parts, 0.4 * whole.distance.1, whole);
                    let grains = grains_of(chart, view);
                    for (index, curve) in chart.curves.iter().enumerate() {
                        for (grain, ends) in grains.runs() {
                            let SectionGrain::Means(group) = grain else { continue };
                            let strips = strips(chart, curve, &grains.borders(group, ends));
                            let Some((first, last)) = strips.first().zip(strips.last()) else { continue };
                            let sum: f64 = strips
                                .iter()
                                .map(|strip| strip.ends.1 - strip.ends.0)
                                .zip(&strips)
                                .map(
                                    |(along, strip)| {
                                        if is_timed { along * strip.mean } else { along / strip.mean }
                                    },
                                )
                                .sum();
                            let mut rows = AscendingReader::of(&curve.distance);
                            let line = QuantityLine::of_curve(chart, curve);
                            let [from, to] =
                                [first.ends.0, last.ends.1].map(|at| line.other_at(at, &mut rows));
                            assert!(
                                (sum - (to - from)).abs() <= 1e-9 * to.max(1.0),
                                "{name}, curve {index}: {sum} of {}",
                                to - from
                            );
                            for strip in &strips {
                                let Strip { mean, band, all, .. } = strip;
                                assert!(
                                    all.lowest <= band.lowest
                                        && band.lowest <= band.highest
                                        && band.highest <= all.highest
                                );
                                assert!(0.0 < *mean);
                            }
                        }
                    }
                }
            }
            let whole = chart.full_view(false);
            let grains = grains_of(&chart, whole);
            assert!(grains.runs().any(|(grain, _)| grain != SectionGrain::Exact), "{name} is drawn exactly");
            let near = whole.zoomed(2000.0, 0.4 * whole.distance.1, whole);
            let grains = grains_of(&chart, near);
            assert!(
                grains.runs().all(|(grain, _)| grain == SectionGrain::Exact),
                "{name} has no exact curve"
            );
        }
    }

    #[test]
    fn waits_count_in_means_wherever_they_are() {
        // 4 s of wait at the start, 1 s on the way and 2 s at the end of 20 mm at 10 mm/s.
        let curve = FeedrateCurve {
            distance: vec![0.0, 0.0, 10.0, 10.0, 20.0, 20.0],
            feedrate: vec![10.0; 6].into(),
            time: vec![0.0, 4.0, 5.0, 6.0, 7.0, 9.0],
            ..FeedrateCurve::default()
        };
        let chart = FeedChart { curves: vec![curve], ..FeedChart::default() };
        let line = QuantityLine::of_curve(&chart, &chart.curves[0]);
        let means: Vec<f64> = line.means(&[0.0, 5.0, 15.0, 25.0]).into_iter().flatten().collect();
        for (mean, seconds) in means.iter().zip([4.5, 2.0, 2.5]) {
            let way = if seconds == 2.0 { 10.0 } else { 5.0 };
            assert!((mean * seconds / way - 1.0).abs() < 1e-12, "{mean} over {seconds} s");
        }
        assert_eq!(means.len(), 3);
        assert_eq!(line.means(&[20.0, 30.0, 40.0]), [None, None]);
    }

    #[test]
    fn programmed_means_begin_with_the_path() {
        let programmed = Programmed::new(vec![10.0, 20.0], vec![5.0, 10.0], vec![false; 2], vec![1, 2]);
        let chart = FeedChart { programmed, ..FeedChart::default() };
        let line = QuantityLine::of_programmed(&chart, &chart.programmed);
        assert_eq!(line.means(&[0.0, 5.0, 20.0]), [Some(5.0), Some(15.0 / 2.0)]);
    }
}
