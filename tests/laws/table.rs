//! The profile as a table: straight lines between its rows are as close as was asked for.

use crate::laws::paths::{Case, cases};
use truefeed::simulation::profile::{Profile, Resolution};
use truefeed::simulation::toolpath::Point;

/// What is promised of straight lines between the rows, as a part of the commanded feedrate.
const PROMISED: f64 = 1e-3;

/// Cases with a pulse of a tenth of a millisecond through a single filter, which rows at an eighth
/// of its delay pass over.
const SHORT_PULSES: [usize; 3] = [4656, 6842, 11855];

#[test]
fn straight_lines_between_fine_rows_follow_the_profile() {
    let wanted = |case: &Case| case.number.is_multiple_of(6) || SHORT_PULSES.contains(&case.number);
    for (case, mut random) in cases(31, 12_000).filter(|(case, _)| wanted(case)) {
        let plan = case.plan();
        let profile = Profile::new(&case.toolpath, &plan);
        let samples = profile.samples(Resolution::FINE);
        let rows = samples.time.len();
        assert!(samples.time.is_sorted() && samples.distance.is_sorted(), "case {}", case.number);
        assert!(samples.line.is_sorted(), "case {}", case.number);
        let columns = samples.position.iter().chain(&samples.velocity).map(Vec::len);
        let columns = columns.chain([samples.distance.len(), samples.feedrate.len(), samples.line.len()]);
        assert!(columns.into_iter().all(|length| length == rows));

        let (time, length) = (profile.cycle_time(), profile.length());
        assert_eq!((samples.time[0], samples.distance[0], samples.feedrate[0]), (0.0, 0.0, 0.0));
        assert!((samples.time[rows - 1] - time).abs() <= 1e-12 * time, "case {}", case.number);
        assert!((samples.distance[rows - 1] - length).abs() <= 1e-9 * length, "case {}", case.number);
        let end = case.toolpath.segments.last().expect("a path has segments").end;
        (0..3).for_each(|k| assert!((samples.position[k][rows - 1] - end[k]).abs() <= 1e-9 * length));

        let fastest = plan.pulses.iter().flat_map(|pulse| pulse.feedrate).fold(0.0, f64::max);
        // The line of a row is the number of its segment.
        let commanded = |row: usize| {
            let segment = case.toolpath.segments.at(samples.line[row] as usize - 1);
            if segment.motion.is_rapid() { fastest } else { case.requested(&segment) }
        };
        for _ in 0..200 {
            let at = random.between(0.0, time);
            let after = samples.time.partition_point(|&row| row <= at).clamp(1, rows - 1);
            let before = after - 1;
            let width = samples.time[after] - samples.time[before];
            let part = if 0.0 < width { (at - samples.time[before]) / width } else { 0.5 };
            let mix = |column: &[f64]| column[before] + part * (column[after] - column[before]);
            let state = profile.at_time(at);
            let miss = (mix(&samples.feedrate) - state.velocity.norm()).abs();
            let allowed = PROMISED * commanded(before).min(commanded(after));
            assert!(
                miss <= allowed,
                "case {} at {at} s of {time}: off by {miss} mm/s, allowed {allowed}",
                case.number
            );
            let position = Point::from([0, 1, 2].map(|k| mix(&samples.position[k])));
            let away = (position - state.position).norm();
            assert!(away <= 2e-3, "case {} at {at} s: off by {away} mm", case.number);
        }
    }
}
