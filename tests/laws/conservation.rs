//! What goes in comes out: length, time, and no feedrate that was not commanded.

use crate::laws::paths::{cases, stretches};
use truefeed::simulation::feed::Phase;
use truefeed::simulation::profile::Profile;

fn case_count() -> usize {
    crate::shared::case_count(10_000)
}

#[test]
fn pulses_add_up_to_the_length_and_keep_to_the_feedrate() {
    for (case, _) in cases(1, case_count()) {
        let plan = case.plan();
        let mut areas = vec![0.0; case.toolpath.segments.len()];
        for pulse in &plan.pulses {
            let segment = case.toolpath.segments.at(pulse.segment as usize);
            let area = &mut areas[pulse.segment as usize];
            assert!((pulse.offset - *area).abs() <= 1e-9 * segment.length, "case {}", case.number);
            *area += 0.5 * pulse.duration * (pulse.feedrate[0] + pulse.feedrate[1]);
            assert!(0.0 < pulse.duration, "case {}: {pulse:?}", case.number);
            for feedrate in pulse.feedrate {
                let most = case.requested(&segment);
                assert!((0.0..=most).contains(&feedrate), "case {}: {pulse:?}, {most}", case.number);
            }
        }
        for (segment, area) in case.toolpath.segments.iter().zip(&areas) {
            assert!((area / segment.length - 1.0).abs() <= 1e-9, "case {}: {area} {segment:?}", case.number);
        }
    }
}

#[test]
fn the_profile_ends_where_the_program_ends() {
    for (case, mut random) in cases(2, case_count()) {
        let plan = case.plan();
        let profile = Profile::new(&case.toolpath, &plan);
        let segments = &case.toolpath.segments;
        let length: f64 = segments.iter().map(|segment| segment.length).sum();
        let scale = 1e-9 * length;
        assert!((profile.length() - length).abs() <= scale);
        let beyond = random.between(0.0, 1.0);
        for time in [profile.cycle_time(), profile.cycle_time() + beyond] {
            let state = profile.at_time(time);
            let end = segments.last().expect("a path has segments").end;
            assert!((state.distance - length).abs() <= scale, "case {}", case.number);
            assert!((state.position - end).norm() <= scale, "case {}", case.number);
            assert!(state.velocity.norm() <= 1e-9 * 1000.0, "case {}", case.number);
        }
        let start = profile.at_time(0.0);
        assert_eq!((start.distance, start.velocity.norm()), (0.0, 0.0));
        assert!((start.position - segments.at(0).start).norm() <= scale);
        // Distance and time are each other's inverse.
        let distance = random.between(0.0, length);
        let there = profile.at_time(profile.time_at_distance(distance)).distance;
        assert!((there - distance).abs() <= scale, "case {}: {there}, not {distance}", case.number);
    }
}

#[test]
fn feedrate_stays_below_the_highest_command_within_the_filters() {
    for (case, mut random) in cases(3, case_count()) {
        let plan = case.plan();
        let profile = Profile::new(&case.toolpath, &plan);
        let stretches = stretches(&plan);
        let fastest = plan.pulses.iter().flat_map(|pulse| pulse.feedrate).fold(0.0, f64::max);
        let mut distance = 0.0;
        let mut times: Vec<f64> = (0..50).map(|_| random.between(0.0, profile.cycle_time())).collect();
        times.sort_by(f64::total_cmp);
        for time in times {
            let state = profile.at_time(time);
            assert!(distance <= state.distance * (1.0 + 1e-12), "case {}: distance grows", case.number);
            distance = state.distance;
            let begun = stretches.partition_point(|&(start, _)| start <= time);
            let Some((start, stretch)) = begun.checked_sub(1).map(|last| stretches[last]) else {
                assert_eq!(state.velocity.norm(), 0.0);
                continue;
            };
            // A hair wider than the window, for times that are equal but for rounding.
            let delay = plan.filters[stretch.filter].delay() + 1e-12 * (1.0 + time);
            let mut begin = start;
            let mut highest = 0.0f64;
            for pulse in plan.pulses.range(stretch.pulses.clone()) {
                let end = begin + pulse.duration;
                if begin <= time && time - delay <= end {
                    let at = |t: f64| {
                        let part = ((t - begin) / pulse.duration).clamp(0.0, 1.0);
                        pulse.feedrate[0] + part * (pulse.feedrate[1] - pulse.feedrate[0])
                    };
                    highest = highest.max(at(time)).max(at(time - delay));
                }
                begin = end;
            }
            let feedrate = state.velocity.norm();
            assert!(
                feedrate <= highest * (1.0 + 1e-9) + 1e-12 * fastest,
                "case {} at {time} s: {feedrate} mm/s, commanded {highest}",
                case.number
            );
        }
    }
}

/// The value as a whole number of 2⁻⁹⁰, exactly, but for what is smaller.
fn whole(value: f64) -> i128 {
    (value * 90f64.exp2()) as i128
}

#[test]
fn cycle_time_is_the_sum_of_its_parts() {
    for (case, _) in cases(4, case_count()) {
        let plan = case.plan();
        let phases = plan.phases.iter().map(|phase| match phase {
            Phase::Wait(wait) => whole(wait.duration),
            Phase::Motion(stretch) => {
                let pulses = plan.pulses.range(stretch.pulses.clone());
                let filter = &plan.filters[stretch.filter];
                let delay: i128 = filter.time_constants().iter().map(|constant| whole(*constant)).sum();
                pulses.map(|pulse| whole(pulse.duration)).sum::<i128>() + delay
            }
        });
        let exact: i128 = phases.sum();
        let time = plan.cycle_time();
        let profile = Profile::new(&case.toolpath, &plan);
        let last_digits = whole(4.0 * f64::EPSILON * time);
        assert!((whole(time) - exact).abs() <= last_digits, "case {}", case.number);
        assert!((whole(profile.cycle_time()) - exact).abs() <= last_digits, "case {}", case.number);
    }
}
