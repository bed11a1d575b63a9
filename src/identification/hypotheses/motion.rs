//! Effects on motion along the path: limits, filters, corners, overrides, block handling.

use std::sync::Arc;

use crate::identification::calibration::become_planner;
use crate::identification::fit::{Freed, Run, Scale};
use crate::identification::hypotheses::{Hypothesis, Report, Reported, Trace, ratios};
use crate::machine::{AXES, Junction, Machine, PlannedBy, TimeConstants};
use crate::simulation::feed::rounding;
use crate::simulation::toolpath::{Curve, Motion, Segment, Vector};
use crate::units::mm_per_min;

/// What the programs ask for, by which limits are tried below it.
struct Demand {
    /// Fastest programmed motion of each axis, mm/s.
    axis_feedrate: Vector,
    /// Fastest programmed feedrate, mm/s.
    feedrate: f64,
    /// Whether there are rapid moves, arcs, programmed tolerances.
    has_rapid: bool,
    has_arc: bool,
    has_tolerance: bool,
}

pub fn hypotheses(machine: &Machine, runs: &[Run]) -> Vec<Hypothesis> {
    let demand = demand(machine, runs);
    let mut all = Vec::new();
    for axis in 0..3 {
        all.extend(axis_limits(axis, &demand));
    }
    all.extend(accelerations(
        "path_acceleration_limit",
        "path.acceleration_mm_s2",
        String::new(),
        |machine, value| machine.path.acceleration = value,
    ));
    if demand.has_arc {
        all.push(single(
            "centripetal_acceleration_limit",
            Freed::number("path.centripetal_acceleration_mm_s2", 1e3, (1.0, 1e6), Scale::Ratio),
            // Arcs are as slow as their root: one that makes them 10 % slower must not lie between two that are worse than none.
            ratios(10.0, 5e3, 32),
            |value| vec![("a_mm_s2", Reported::Number(value))],
        ));
    }
    all.extend(filters(machine, &demand));
    all.push(if demand.has_tolerance { programmed_tolerance(machine) } else { tolerance(machine) });
    if demand.has_arc {
        all.push(arcs(machine));
    }
    all.extend(junctions(machine));
    all.extend(planners(machine));
    all.push(smoothing(machine, runs));
    all.push(corner_smoothing(machine, runs));
    all.extend(overrides(machine, &demand));
    all.extend(blocks(runs));
    all.push(single(
        "recorder_clock",
        Freed::number("recorder.clock_ratio", 1.0, (0.8, 1.25), Scale::Ratio),
        vec![0.9, 0.97, 0.99, 1.01, 1.03, 1.1],
        |value| vec![("ratio", Reported::Number(value))],
    ));
    all.into_iter().flatten().collect()
}

/// A hypothesis of one parameter; none where its key is unknown.
fn single(
    id: &'static str,
    freed: Option<Freed>,
    trials: Vec<f64>,
    report: impl Fn(f64) -> Vec<(&'static str, Reported)> + Send + Sync + 'static,
) -> Option<Hypothesis> {
    let report: Report = Arc::new(move |values| report(values[0]));
    Some(Hypothesis {
        id,
        variant: String::new(),
        trace: Trace::Time,
        freed: vec![freed?],
        trials: trials.into_iter().map(|value| vec![value]).collect(),
        is_continuous: true,
        report,
    })
}

fn demand(machine: &Machine, runs: &[Run]) -> Demand {
    let mut demand = Demand {
        axis_feedrate: Vector::zeros(),
        feedrate: 0.0,
        has_rapid: false,
        has_arc: false,
        has_tolerance: false,
    };
    for run in runs {
        demand.has_tolerance |= !run.toolpath.path_modes.is_empty();
        for segment in &run.toolpath.segments {
            let feedrate = match segment.motion {
                Motion::Feed { feedrate } => feedrate,
                Motion::Rapid => {
                    demand.has_rapid = true;
                    machine.rapid.feedrate
                }
            };
            demand.has_arc |= segment.curve != Curve::Line;
            demand.feedrate = demand.feedrate.max(feedrate);
            let share = match &segment.curve {
                Curve::Line => segment.tangent(0.0).abs(),
                Curve::Arc(arc) => arc.e1.abs() + arc.e2.abs(),
            };
            for axis in 0..3 {
                let own = feedrate * share[axis].min(1.0);
                demand.axis_feedrate[axis] = demand.axis_feedrate[axis].max(own);
            }
        }
    }
    demand
}

fn axis_limits(axis: usize, demand: &Demand) -> Vec<Option<Hypothesis>> {
    let name = AXES[axis];
    if demand.axis_feedrate[axis] <= 0.0 {
        return Vec::new();
    }
    let fastest = demand.axis_feedrate[axis];
    let velocity = Freed::new(
        format!("axis.{}.velocity_mm_min", name.to_ascii_lowercase()),
        fastest,
        (1e-3 * fastest, 2.0 * fastest),
        Scale::Ratio,
        move |machine, value| machine.axes[axis].velocity = value,
    );
    let of_axis = |hypothesis: Option<Hypothesis>| {
        hypothesis.map(|hypothesis| Hypothesis { variant: name.to_string(), ..hypothesis })
    };
    let word = move || ("axis", Reported::Word(name.to_string()));
    let key = format!("axis.{}.acceleration_mm_s2", name.to_ascii_lowercase());
    let mut all = accelerations("axis_acceleration_limit", &key, name.to_string(), move |machine, value| {
        machine.axes[axis].acceleration = value;
    });
    all.push(of_axis(single(
        "axis_velocity_limit",
        Some(velocity),
        ratios(0.02 * fastest, 0.97 * fastest, 14),
        move |value| vec![word(), ("v_mm_min", Reported::Number(mm_per_min(value)))],
    )));
    all
}

/// A limit of acceleration: on what leaves the filters, and on the command before them.
fn accelerations(
    id: &'static str,
    key: &str,
    axis: String,
    set: impl Fn(&mut Machine, f64) + Send + Sync + Copy + 'static,
) -> Vec<Option<Hypothesis>> {
    let of = |is_before: bool| {
        let freed = Freed::new(key, 1e3, (10.0, 2e5), Scale::Ratio, move |machine, value| {
            set(machine, value);
            machine.path.limits_command |= is_before;
        });
        let word = (!axis.is_empty()).then(|| ("axis", Reported::Word(axis.clone())));
        let place = is_before.then(|| ("at", Reported::Word("command".to_string())));
        let hypothesis = single(id, Some(freed), ratios(50.0, 2e4, 10), move |value| {
            let limit = ("a_mm_s2", Reported::Number(value));
            word.iter().cloned().chain([limit]).chain(place.clone()).collect()
        });
        let before = if is_before { "before the filters" } else { "" };
        let variant = [&axis[..], before].into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>();
        hypothesis.map(|hypothesis| Hypothesis { variant: variant.join(", "), ..hypothesis })
    };
    vec![of(false), of(true)]
}

fn filters(machine: &Machine, demand: &Demand) -> Vec<Option<Hypothesis>> {
    let TimeConstants::Equal(constant) = machine.interpolator.time_constants else { return Vec::new() };
    let order = machine.interpolator.filters;
    let trials = |ratios: &[f64]| -> Vec<f64> { ratios.iter().map(|ratio| ratio * constant).collect() };
    let freed = Freed::number("interpolator.time_constant_s", constant, (2e-4, 0.5), Scale::Ratio);
    let mut all = vec![single(
        "filter_time_constant",
        freed,
        trials(&[0.3, 0.5, 0.7, 0.85, 0.95, 1.05, 1.15, 1.3, 1.6, 2.0, 3.0]),
        |value| vec![("time_constant_s", Reported::Number(value))],
    )];
    // Another order has the same delay in all, or it would be another constant as well.
    // As many more or fewer of the same length, or of another one with the same delay in all.
    let orders: Vec<f64> = (1..=4).filter(|other| *other != order).map(|other| other as f64).collect();
    let freed = Freed::new(
        "interpolator.filters",
        order as f64,
        (1.0, 4.0),
        Scale::Difference,
        move |machine, value| machine.interpolator.filters = value.round().clamp(1.0, 4.0) as usize,
    );
    let found = single("filter_order", Some(freed), orders.clone(), |value| {
        vec![("filters", Reported::Number(value.round()))]
    });
    let variant = "each as long".to_string();
    all.push(found.map(|hypothesis| Hypothesis { is_continuous: false, variant, ..hypothesis }));
    let of_order = Freed::new(
        "interpolator.filters",
        order as f64,
        (1.0, 4.0),
        Scale::Difference,
        move |machine, value| {
            let other = value.round().clamp(1.0, 4.0);
            let delay = constant * order as f64;
            machine.interpolator.filters = other as usize;
            machine.interpolator.time_constants = TimeConstants::Equal(delay / other);
        },
    );
    all.push(
        single("filter_order", Some(of_order), orders, |value| {
            vec![("filters", Reported::Number(value.round()))]
        })
        .map(|hypothesis| Hypothesis { is_continuous: false, ..hypothesis }),
    );
    if 1 < order {
        // The same delay in all, one filter longer and the others shorter.
        let split = move |spread: f64| {
            let rest = order as f64 - 1.0;
            let longest = constant * (1.0 + rest * spread);
            let mut constants = vec![longest];
            constants.resize(order, constant * (1.0 - spread));
            constants
        };
        let freed = Freed::new(
            "interpolator.time_constants_s",
            0.3,
            (0.02, 0.95),
            Scale::Difference,
            move |machine, spread| {
                machine.interpolator.time_constants = TimeConstants::Unequal(split(spread));
            },
        );
        all.push(single(
            "unequal_filters",
            Some(freed),
            vec![0.04, 0.08, 0.15, 0.3, 0.45, 0.6, 0.8],
            move |spread| vec![("time_constants_s", Reported::List(split(spread)))],
        ));
    }
    let jerk = demand.feedrate / (constant * constant);
    let freed = Freed::new(
        "interpolator.max_jerk_mm_s3",
        jerk,
        (1e-3 * jerk, 1e3 * jerk),
        Scale::Ratio,
        |machine, value| {
            machine.interpolator.time_constants = TimeConstants::FromJerk(value);
        },
    );
    all.push(single("jerk_limit", Some(freed), ratios(0.1 * jerk, 10.0 * jerk, 9), |value| {
        vec![("j_mm_s3", Reported::Number(value))]
    }));
    all
}

fn tolerance(machine: &Machine) -> Option<Hypothesis> {
    let own = machine.interpolator.contour_tolerance;
    let freed = Freed::number("interpolator.contour_tolerance_mm", own, (1e-5, 5.0), Scale::Ratio);
    let trials = [0.05, 0.15, 0.3, 0.5, 0.75, 0.9, 1.1, 1.3, 2.0, 3.5, 8.0];
    single("corner_tolerance", freed, trials.iter().map(|ratio| ratio * own).collect(), |value| {
        vec![("contour_tolerance_mm", Reported::Number(value))]
    })
}

/// Where the program sets the tolerance, the control may hold another one.
fn programmed_tolerance(machine: &Machine) -> Option<Hypothesis> {
    let own = machine.interpolator.contour_tolerance;
    let freed = Freed::number("path_modes.tolerance_override_mm", own, (1e-5, 5.0), Scale::Ratio);
    single("corner_tolerance", freed, ratios(5e-4, 0.5, 12), |value| {
        vec![("contour_tolerance_mm", Reported::Number(value))]
    })
}

/// Arcs that the tolerance does not slow, as on controls that know it at corners alone; a tolerance of arcs that is
/// but a little wider is not offered, as it would take up what other causes leave.
fn arcs(machine: &Machine) -> Option<Hypothesis> {
    let own = machine.interpolator.contour_tolerance;
    let held = machine.interpolator.arc_tolerance;
    if machine.interpolator.junction != Junction::Tolerance || held.is_some() {
        return None;
    }
    let freed =
        Freed::number("interpolator.arc_tolerance_mm", 10.0 * own, (5.0 * own, 1e5 * own), Scale::Ratio);
    let trials = [10.0, 30.0, 100.0].iter().map(|ratio| ratio * own).collect();
    let found = single("corner_tolerance", freed, trials, |value| {
        vec![("at", Reported::Word("arcs".to_string())), ("arc_tolerance_mm", Reported::Number(value))]
    });
    found.map(|hypothesis| Hypothesis { variant: "arcs".to_string(), ..hypothesis })
}

/// Lines that the control runs as one. It acts by whole lines, so that between two distances may lie nothing; the
/// controls that are known to have the junctions of LinuxCNC do it by themselves, and may be kept from it.
fn smoothing(machine: &Machine, runs: &[Run]) -> Option<Hypothesis> {
    let freed = Freed::number("interpolator.path_smoothing_mm", 0.02, (0.0, 10.0), Scale::Difference);
    let trials = match machine.interpolator.junction {
        Junction::AccelerationBlend => std::iter::once(0.0).chain(ratios(1e-3, 1.0, 31)).collect(),
        _ => {
            let least = least_joint(runs);
            if WIDEST_JOINT < least {
                return None;
            }
            ratios(least.max(1e-3), WIDEST_JOINT, 14)
        }
    };
    let found =
        single("path_smoothing", freed, trials, |value| vec![("tolerance_mm", Reported::Number(value))]);
    found.map(|hypothesis| Hypothesis { is_continuous: false, ..hypothesis })
}

/// Joints of lines that are farther from the line past them than this are corners that no control smooths, mm.
const WIDEST_JOINT: f64 = 0.3;

/// How far the joint of two feed moves along lines is from the line past it, mm, where it is least but not nothing.
fn least_joint(runs: &[Run]) -> f64 {
    let pairs = runs.iter().flat_map(|run| run.toolpath.segments.pairs());
    let joints = pairs.filter_map(|(before, after)| {
        let is_cut = |segment: &Segment| segment.curve == Curve::Line && segment.motion != Motion::Rapid;
        if !is_cut(&before) || !is_cut(&after) || before.motion != after.motion || before.exact_stop {
            return None;
        }
        let (before, after) = (before.length * before.tangent(0.0), after.length * after.tangent(0.0));
        let past = before + after;
        Some(before.cross(&after).norm() / past.norm()).filter(|joint| 1e-6 < *joint)
    });
    joints.fold(f64::INFINITY, f64::min)
}

/// Distances of curves that are tried, each passing so many more corners, and how much farther they are than the last of these.
const ROUNDED: usize = 16;
const FARTHER: f64 = 1.08;

/// Corners that the control passes on a curve, more and more of them.
fn corner_smoothing(machine: &Machine, runs: &[Run]) -> Option<Hypothesis> {
    if machine.interpolator.junction == Junction::AccelerationBlend {
        return None;
    }
    let corners = runs.iter().flat_map(|run| run.toolpath.segments.pairs());
    let mut distances: Vec<f64> = corners
        .filter_map(|(before, after)| rounding(&before, &after))
        .filter(|distance| (1e-4..WIDEST_JOINT).contains(distance))
        .collect();
    distances.sort_by(f64::total_cmp);
    let last = distances.len().checked_sub(1)?;
    let mut trials: Vec<f64> = (0..=ROUNDED).map(|part| FARTHER * distances[last * part / ROUNDED]).collect();
    trials.dedup_by(|b, a| *b < 1.01 * *a);
    let freed = Freed::number(
        "interpolator.corner_smoothing_mm",
        trials[0],
        (5e-5, 2.0 * WIDEST_JOINT),
        Scale::Ratio,
    );
    let found = single("path_smoothing", freed, trials, |value| {
        vec![("tolerance_mm", Reported::Number(value)), ("at", Reported::Word("corners".to_string()))]
    });
    found.map(|hypothesis| Hypothesis { variant: "corners".to_string(), ..hypothesis })
}

fn junctions(machine: &Machine) -> Vec<Option<Hypothesis>> {
    let mut all = Vec::new();
    let mut rule = |word: &'static str, key: &'static str, trials: Vec<f64>, unit: fn(f64) -> f64| {
        // Below the least of them every corner is a full stop, which is another cause.
        let Some(freed) = Freed::number(key, trials[0], (0.5 * trials[0], 1e5), Scale::Ratio) else { return };
        // These laws are laws of an acceleration; without one the usual value of a machining centre.
        let needs = machine.path.acceleration.is_infinite()
            && machine.axes.iter().all(|axis| axis.acceleration.is_infinite());
        if needs && word != "axis_velocity_step" {
            return;
        }
        let hypothesis = single("junction_rule", Some(freed), trials, move |value| {
            vec![("rule", Reported::Word(word.to_string())), ("value", Reported::Number(unit(value)))]
        });
        all.push(hypothesis.map(|hypothesis| Hypothesis { variant: word.replace('_', " "), ..hypothesis }));
    };
    rule("junction_deviation", "interpolator.junction_deviation_mm", ratios(1e-3, 0.3, 8), |value| value);
    rule(
        "square_corner_velocity",
        "interpolator.square_corner_velocity_mm_min",
        ratios(0.3, 60.0, 8),
        mm_per_min,
    );
    rule("axis_velocity_step", "interpolator.axis_velocity_step_mm_min", ratios(0.3, 60.0, 10), mm_per_min);
    all
}

/// Another family of controls: no filters, trapezoids within the acceleration of the axes.
fn planners(machine: &Machine) -> Vec<Option<Hypothesis>> {
    if machine.interpolator.junction != Junction::Tolerance {
        return Vec::new();
    }
    let of = |by_axis: bool| {
        let freed =
            Freed::new("axis.acceleration", 500.0, (10.0, 1e5), Scale::Ratio, move |machine, value| {
                become_planner(machine, value, by_axis);
            });
        let hypothesis = single("axis_acceleration_limit", Some(freed), ratios(50.0, 2e4, 14), |value| {
            vec![
                ("axis", Reported::Word("XYZ".to_string())),
                ("a_mm_s2", Reported::Number(value)),
                ("planner", Reported::Word("acceleration_blend".to_string())),
            ]
        });
        let variant =
            if by_axis { "planner of trapezoids" } else { "planner of trapezoids, rapid along the path" };
        hypothesis.map(|hypothesis| Hypothesis { variant: variant.to_string(), ..hypothesis })
    };
    vec![of(true), of(false)]
}

fn overrides(machine: &Machine, demand: &Demand) -> Vec<Option<Hypothesis>> {
    let ratio = |value: f64| vec![("ratio", Reported::Number(value))];
    let feed = machine.overrides.feed;
    let rapid = machine.overrides.rapid;
    let mut all = vec![single(
        "feed_override",
        Freed::number("override.feed", feed, (0.01, 2.0), Scale::Ratio),
        [0.2, 0.4, 0.6, 0.75, 0.9, 0.97, 0.99, 1.01, 1.03, 1.1, 1.25, 1.5]
            .iter()
            .map(|part| part * feed)
            .collect(),
        ratio,
    )];
    if demand.has_rapid {
        all.push(single(
            "rapid_override",
            Freed::number("override.rapid", rapid, (0.01, 2.0), Scale::Ratio),
            [0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.1, 1.3].iter().map(|part| part * rapid).collect(),
            ratio,
        ));
    }
    all
}

/// Parts of all blocks that are shorter than a block time that is tried, and how much longer it is than the
/// programmed time of the longest of them.
const SHORTER: [f64; 12] = [0.002, 0.01, 0.03, 0.06, 0.1, 0.2, 0.3, 0.45, 0.6, 0.75, 0.9, 1.0];
const LONGER: f64 = 1.08;
/// Where all blocks are about as long, block times between are tried as well, no farther apart than this ratio.
const CLOSE: f64 = 1.5;

/// Block times that act on more and more blocks, s; below the least of them none is shorter.
fn block_times(runs: &[Run]) -> Vec<f64> {
    let segments = runs.iter().flat_map(|run| &run.toolpath.segments);
    let mut durations: Vec<f64> = segments
        .filter_map(|segment| match segment.motion {
            Motion::Feed { feedrate } => Some(segment.length / feedrate),
            Motion::Rapid => None,
        })
        .filter(|duration| 0.0 < *duration && duration.is_finite())
        .collect();
    durations.sort_by(f64::total_cmp);
    let at = |part: f64| {
        let place = (durations.len() as f64 * part) as usize;
        durations.get(place.min(durations.len().saturating_sub(1)))
    };
    let mut times: Vec<f64> =
        SHORTER.iter().filter_map(|part| at(*part)).map(|time| (LONGER * time).clamp(1e-5, 1.0)).collect();
    times.dedup_by(|b, a| *b < 1.01 * *a);
    let between = times.windows(2).flat_map(|pair| {
        let count = ((pair[1] / pair[0]).ln() / CLOSE.ln()).ceil() as usize;
        ratios(pair[0], pair[1], count + 1).into_iter().take(count)
    });
    between.chain(times.last().copied()).collect()
}

/// Blocks that come late, to a control that knows of it when it plans corners, and to one that does not.
fn blocks(runs: &[Run]) -> Vec<Option<Hypothesis>> {
    let block_times = block_times(runs);
    let of = |by: PlannedBy| {
        let said = move |reported: (&'static str, Reported)| {
            let by = (by != PlannedBy::default())
                .then(|| ("corners_planned_by", Reported::Word(by.word().into())));
            [Some(reported), by].into_iter().flatten().collect()
        };
        let block_time = Freed::new(
            "interpolator.block_time_s",
            0.005,
            (1e-5, 1.0),
            Scale::Ratio,
            move |machine, value| {
                (machine.interpolator.block_time, machine.interpolator.planned_by) = (value, by);
            },
        );
        let look_ahead = Freed::new(
            "interpolator.look_ahead_blocks",
            10.0,
            (1.0, 1e6),
            Scale::Ratio,
            move |machine, value| {
                (machine.interpolator.look_ahead, machine.interpolator.planned_by) = (value.round(), by);
            },
        );
        let block_time =
            single("block_processing_time", Some(block_time), block_times.clone(), move |value| {
                said(("seconds", Reported::Number(value)))
            });
        let seen = [1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 50.0, 80.0, 120.0];
        let look_ahead = single("look_ahead", Some(look_ahead), seen.to_vec(), move |value| {
            said(("blocks", Reported::Number(value.round())))
        });
        let look_ahead = look_ahead.map(|hypothesis| Hypothesis { is_continuous: false, ..hypothesis });
        let variant = if by == PlannedBy::default() { "" } else { "planned as requested" };
        [block_time, look_ahead]
            .map(|found| found.map(|hypothesis| Hypothesis { variant: variant.to_string(), ..hypothesis }))
    };
    PlannedBy::WORDS.into_iter().flat_map(|(_, by)| of(by)).collect()
}
