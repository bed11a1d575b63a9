//! The figures of the paper, each as an SVG.

use std::f64::consts::TAU;

use truefeed::identification::step::{
    Filters, Identification, Outcome, RecordedQuantity, Recording, identify,
};
use truefeed::simulation::feed::corner::CornerLaw;
use truefeed::simulation::feed::{CornerPolicy, FeedPlan};
use truefeed::simulation::filter::FilterChain;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Toolpath;
use truefeed::units::mm_per_s;

use super::chart::{Curve, Panel, curve, svg};
use super::path::{Pen, TIME_CONSTANT, machine};

const TIME: &str = "time (ms)";
/// Acceleration and deceleration time of the move in Sect. 2.2, s.
const RAMP: f64 = 0.0765;

fn panel(title: &str, x: &'static str, y: &'static str, curves: Vec<Curve>) -> Panel {
    Panel { title: title.to_string(), x, y, curves }
}

/// A curve over time in ms.
fn over_time(name: &str, until: f64, value: impl Fn(f64) -> f64) -> Curve {
    curve(name, (0.0, 1e3 * until), 400, |ms| value(1e-3 * ms))
}

fn count(filters: usize) -> String {
    if filters == 1 { "1 filter".to_string() } else { format!("{filters} filters") }
}

/// All figures: file name without extension, and SVG.
pub fn all() -> Vec<(&'static str, String)> {
    vec![
        ("fig-02", impulse_response()),
        ("fig-03", magnitude()),
        ("fig-04", pulse()),
        ("fig-05", recording_against_filters()),
        ("fig-07", right_angle()),
        ("fig-08", pulse_train()),
        ("fig-09", corner_kinematics(2)),
        ("fig-11", cornering_feed()),
        ("fig-17", corner_kinematics(3)),
    ]
}

fn impulse_response() -> String {
    let filter = FilterChain::equal(1, TIME_CONSTANT);
    let response = over_time("", 2.0 * TIME_CONSTANT, |t| filter.impulse(t));
    svg(&[panel("One filter, T1 = 25.5 ms", TIME, "impulse response (1/s)", vec![response])], 1)
}

fn magnitude() -> String {
    let filter = |frequency: f64| {
        let half = 0.5 * TAU * frequency * TIME_CONSTANT;
        if half == 0.0 { 1.0 } else { (half.sin() / half).abs() }
    };
    let curves = (1..=4).map(|n| {
        let decibel = move |frequency: f64| (20.0 * f64::from(n) * filter(frequency).log10()).max(-120.0);
        curve(&count(n as usize), (0.0, 160.0), 600, decibel)
    });
    svg(&[panel("Magnitude, T1 = 25.5 ms", "frequency (Hz)", "magnitude (dB)", curves.collect())], 1)
}

fn pulse() -> String {
    let (feedrate, duration) = (50.0, 0.12);
    let until = duration + 3.0 * TIME_CONSTANT;
    let chains: Vec<FilterChain> = (1..=3).map(|n| FilterChain::equal(n, TIME_CONSTANT)).collect();
    let curves = |from: usize, value: &dyn Fn(&FilterChain, f64) -> f64, scale: f64| -> Vec<Curve> {
        let named = chains.iter().enumerate().skip(from);
        let curves = named.map(|(n, chain)| {
            let pulse = |t: f64| scale * feedrate * (value(chain, t) - value(chain, t - duration));
            over_time(&count(n + 1), until, pulse)
        });
        curves.collect()
    };
    let mut velocity = curves(0, &|chain, t| chain.step(t), 1.0);
    velocity.push(over_time("command", until, |t| if t < duration { feedrate } else { 0.0 }));
    svg(
        &[
            panel("Velocity", TIME, "mm/s", velocity),
            panel("Acceleration", TIME, "m/s²", curves(0, &|chain, t| chain.impulse(t), 1e-3)),
            panel("Jerk", TIME, "m/s³", curves(1, &|chain, t| chain.impulse_slope(t), 1e-3)),
        ],
        3,
    )
}

/// The move of Sect. 2.2 as four filters would record it, with noise of 0.2 % of the feedrate.
pub struct Recorded {
    pub times: Vec<f64>,
    pub feedrates: Vec<f64>,
    pub start: f64,
    pub found: Identification,
}

/// 6 mm at 3000 mm/min, sampled every 3 ms.
pub fn recorded() -> Recorded {
    let chain = FilterChain::equal(4, RAMP / 4.0);
    let (feedrate, start) = (mm_per_s(3000.0), 0.0205);
    let duration = 6.0 / feedrate;
    let mut state = 1u64;
    let mut noise = || {
        // A sum of twelve uniform numbers is near enough to a normal one.
        let uniform = (0..12).map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        });
        uniform.sum::<f64>() - 6.0
    };
    let times: Vec<f64> = (0..=80).map(|i| 0.003 * f64::from(i)).collect();
    let step = |t: f64| chain.step(t - start) - chain.step(t - start - duration);
    let feedrates: Vec<f64> = times.iter().map(|&t| feedrate * (step(t) + 0.002 * noise())).collect();
    let recording = Recording { times: &times, values: &feedrates, quantity: RecordedQuantity::Feedrate };
    let found = match identify(&recording) {
        Outcome::Converged(found) => found,
        other => panic!("a clean recording is identified: {other:?}"),
    };
    Recorded { times, feedrates, start, found }
}

fn recording_against_filters() -> String {
    let Recorded { times, feedrates, start, .. } = recorded();
    let feedrate = mm_per_s(3000.0);
    let duration = 6.0 / feedrate;
    let difference = |values: &[f64]| -> Vec<f64> {
        let inner =
            (1..values.len() - 1).map(|i| (values[i + 1] - values[i - 1]) / (times[i + 1] - times[i - 1]));
        [0.0].into_iter().chain(inner).chain([0.0]).collect()
    };
    let accelerations = difference(&feedrates);
    let jerks = difference(&accelerations);
    let recorded = |values: &[f64], scale: f64| Curve {
        name: "recorded".to_string(),
        points: times.iter().zip(values).map(|(t, value)| (1e3 * t, scale * value)).collect(),
    };
    let mut panels = Vec::new();
    type Response = fn(&FilterChain, f64) -> f64;
    let rows: [(&str, &str, &[f64], f64, Response); 3] = [
        ("Velocity", "mm/s", &feedrates, 1.0, FilterChain::step),
        ("Acceleration", "m/s²", &accelerations, 1e-3, FilterChain::impulse),
        ("Jerk", "m/s³", &jerks, 1e-3, FilterChain::impulse_slope),
    ];
    for (title, unit, values, scale, response) in rows {
        for order in [2usize, 3] {
            let chain = FilterChain::equal(order, RAMP / order as f64);
            let model = over_time(&format!("{order} filters, T1 = Tacc/{order}"), 0.24, |t| {
                let t = t - start;
                scale * feedrate * (response(&chain, t) - response(&chain, t - duration))
            });
            let title = format!("{title}, {order} filters");
            panels.push(Panel { title, x: TIME, y: unit, curves: vec![recorded(values, scale), model] });
        }
    }
    svg(&panels, 2)
}

/// What identification says of the synthetic recording, as a Markdown table.
pub fn identified() -> String {
    let recorded = recorded();
    let found = &recorded.found;
    let name = |filters: Filters| match filters {
        Filters::Equal(1) => "1".to_string(),
        Filters::Equal(order) => format!("{order} equal"),
        Filters::UnequalPair => "2 unequal".to_string(),
    };
    let rows = found.fits.iter().map(|fit| {
        let name = name(fit.filters);
        let constants = fit
            .time_constants
            .iter()
            .map(|constant| format!("{:.2} ± {:.2}", 1e3 * constant.value, 1e3 * constant.uncertainty));
        format!(
            "| {name} | {} | {:.1} ± {:.1} | {:.0} ± {:.0} | {:.3} | {:.0} |\n",
            constants.collect::<Vec<_>>().join(", "),
            1e3 * fit.start.value,
            1e3 * fit.start.uncertainty,
            60.0 * fit.feedrate.value,
            60.0 * fit.feedrate.uncertainty,
            fit.residual_rms,
            fit.bic - found.best().bic,
        )
    });
    let rivals: Vec<String> = found.rivals.iter().map(|&rival| name(found.fits[rival].filters)).collect();
    format!(
        "| filters | time constants ms | start ms | feedrate mm/min | residual mm/s | BIC above the best |\n\
         |---|---:|---:|---:|---:|---:|\n{}\nChosen: {}. At this sampling and noise {}.\n",
        rows.collect::<String>(),
        name(found.best().filters),
        if rivals.is_empty() {
            "no other can be meant".to_string()
        } else {
            format!("these cannot be excluded: {}", rivals.join(", "))
        }
    )
}

/// How much of the path is shown around a corner, mm.
const SHOWN: f64 = 0.3;

/// A right angle of 10 mm legs at 3000 mm/min and 50 µm, as in Fig. 7.
fn right_angle_plan(filters: usize) -> (Toolpath, FeedPlan) {
    let mut pen = Pen::new();
    pen.straight(10.0);
    pen.turn(90.0);
    pen.straight(10.0);
    let toolpath = pen.toolpath(20.0, 3000.0);
    let plan = simulate::with_policy(
        &toolpath,
        &machine(filters, RAMP / filters as f64),
        CornerPolicy::Isolated(0.05),
    );
    (toolpath, plan)
}

/// The command of each axis as a staircase, mm/s over ms.
fn commands(toolpath: &Toolpath, plan: &FeedPlan) -> [Curve; 2] {
    ["X command", "Y command"].map(|name| {
        let axis = usize::from(name.starts_with('Y'));
        let mut points = vec![(0.0, 0.0)];
        let mut begin = 0.0;
        for pulse in &plan.pulses {
            let direction = toolpath.segments.at(pulse.segment as usize).tangent(0.0)[axis];
            let end = begin + pulse.duration;
            points.push((1e3 * begin, direction * pulse.feedrate[0]));
            points.push((1e3 * end, direction * pulse.feedrate[1]));
            begin = end;
        }
        points.push((1e3 * begin, 0.0));
        Curve { name: name.to_string(), points }
    })
}

/// The filtered velocity of each axis, and along the path.
fn velocities(profile: &Profile) -> Vec<Curve> {
    let until = profile.cycle_time();
    vec![
        over_time("X", until, |t| profile.at_time(t).velocity.x),
        over_time("Y", until, |t| profile.at_time(t).velocity.y),
        over_time("tool", until, |t| profile.at_time(t).velocity.norm()),
    ]
}

fn right_angle() -> String {
    let (toolpath, plan) = right_angle_plan(2);
    let profile = Profile::new(&toolpath, &plan);
    let corner = toolpath.segments.at(0).end;
    let middle = profile.time_at_distance(10.0);
    let near = |i: u32| profile.at_time(middle + 0.09 * (f64::from(i) / 200.0 - 0.5)).position - corner;
    let path = Curve {
        name: "filtered".to_string(),
        points: (0..=200)
            .map(|i| (near(i).x, near(i).y))
            .filter(|(x, y)| -SHOWN < *x && *y < SHOWN)
            .collect(),
    };
    let programmed =
        Curve { name: "programmed".to_string(), points: vec![(-SHOWN, 0.0), (0.0, 0.0), (0.0, SHOWN)] };
    svg(
        &[
            panel("Pulses", TIME, "mm/s", commands(&toolpath, &plan).into()),
            panel("Filtered velocities, 2 filters", TIME, "mm/s", velocities(&profile)),
            panel("Blending, 50 µm", "X from the corner (mm)", "Y (mm)", vec![path, programmed]),
        ],
        3,
    )
}

fn pulse_train() -> String {
    let mut pen = Pen::new();
    for turn in [45.0, 90.0, -60.0, -30.0, 0.0] {
        pen.straight(6.0);
        pen.turn(turn);
    }
    let toolpath = pen.toolpath(pen.length, 3000.0);
    let plan = simulate::with_policy(&toolpath, &machine(3, TIME_CONSTANT), CornerPolicy::Isolated(0.05));
    let profile = Profile::new(&toolpath, &plan);
    svg(
        &[
            panel("Pulse train of five blocks", TIME, "mm/s", commands(&toolpath, &plan).into()),
            panel("Filtered velocities, 3 filters", TIME, "mm/s", velocities(&profile)),
        ],
        2,
    )
}

fn corner_kinematics(filters: usize) -> String {
    let (toolpath, plan) = right_angle_plan(filters);
    let profile = Profile::new(&toolpath, &plan);
    let middle = profile.time_at_distance(10.0);
    let around = |name: &str, value: &dyn Fn(f64) -> f64| {
        curve(name, (-60.0, 60.0), 400, |ms| value(middle + 1e-3 * ms))
    };
    let dynamics = |t: f64| profile.dynamics_at_time(t).expect("the machine moves");
    let both = |value: &dyn Fn(f64, usize) -> f64| {
        vec![around("X", &|t| value(t, 0)), around("Y", &|t| value(t, 1))]
    };
    let x = "time from the corner (ms)";
    svg(
        &[
            panel("Velocity", x, "mm/s", both(&|t, axis| profile.at_time(t).velocity[axis])),
            panel("Acceleration", x, "m/s²", both(&|t, axis| 1e-3 * dynamics(t).acceleration[axis])),
            panel("Jerk", x, "m/s³", both(&|t, axis| 1e-3 * dynamics(t).jerk[axis])),
        ],
        3,
    )
}

/// Command αF (mm/min) at a corner between equal legs at `feedrate` (mm/min) that enclose `degrees`;
/// tolerance in µm.
pub fn cornering(filters: usize, feedrate: f64, tolerance: f64, degrees: f64) -> f64 {
    let chain = FilterChain::equal(filters, RAMP / filters as f64);
    let change = (2.0 + 2.0 * degrees.to_radians().cos()).max(0.0).sqrt();
    feedrate * CornerLaw::new(&chain).alpha(1e-3 * tolerance / (mm_per_s(feedrate) * change))
}

fn cornering_feed() -> String {
    let curves = [(2, 10.0), (3, 10.0), (2, 50.0), (3, 50.0)].map(|(filters, tolerance)| {
        let name = format!("n = {filters}, {tolerance:.0} µm");
        curve(&name, (0.0, 180.0), 361, |degrees| cornering(filters, 2000.0, tolerance, degrees))
    });
    svg(
        &[panel(
            "2000 mm/min, n filters",
            "cornering angle θ (degrees)",
            "cornering feed (mm/min)",
            curves.into(),
        )],
        1,
    )
}
