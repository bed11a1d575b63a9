//! Effects of the drives on the form of the path; they take no time.

use crate::identification::effects::effect::{Context, Effect, Hypothesis, ratios};
use crate::identification::effects::parameters::{self, Adjustable};
use crate::identification::effects::report::{AXIS, DAMPING, FREQUENCY, RECORDED_AT, TIME_CONSTANT, WIDTH};
use crate::identification::fit::Run;
use crate::machine::{AXES, StructuralMode};

/// Damping ratio tried first.
const FIRST_DAMPING: f64 = 0.04;
/// Ratio of the highest frequency that a recording shows to its sampling rate: a little less than half.
const HIGHEST_FREQUENCY: f64 = 0.45;

/// Returns the axes whose positions were recorded in at least one run.
fn recorded(runs: &[Run]) -> impl Iterator<Item = usize> {
    let is_recorded = |axis: usize| {
        runs.iter().any(|run| run.alignment.track.as_ref().is_some_and(|track| track.recorded[axis]))
    };
    (0..3).filter(move |axis| is_recorded(*axis))
}

/// Returns the hypotheses of one lag for all axes, as controls are tuned, and of a lag of each recorded axis alone.
pub fn servo_lag(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let of_all = |_| {
        let freed = parameters::SERVO_LAG[0]
            .tried()
            .with(|machine, value| machine.axes.iter_mut().for_each(|axis| axis.servo_lag = value));
        let report = |value| vec![TIME_CONSTANT.number(value)];
        Hypothesis::single(effect, freed, ratios(1e-3, 0.15, 9), report)
    };
    let of_one = |axis: usize| {
        let report = move |value| vec![AXIS.word(AXES[axis]), TIME_CONSTANT.number(value)];
        let freed = parameters::SERVO_LAG[axis].tried();
        Hypothesis::single(effect, freed, ratios(1e-3, 0.15, 9), report).variant(AXES[axis])
    };
    recorded(context.runs).take(1).map(of_all).chain(recorded(context.runs).map(of_one)).collect()
}

/// Returns the hypotheses of a backlash of each recorded axis, as a scale at the table shows it, and of its
/// compensation, as an encoder at the motor does.
pub fn backlash(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let of = |parameter: Adjustable, axis: usize, recorded_at: Option<&'static str>| {
        let report = move |value| {
            let place = recorded_at.map(|place| RECORDED_AT.word(place));
            [AXIS.word(AXES[axis]), WIDTH.number(value)].into_iter().chain(place).collect()
        };
        Hypothesis::single(effect, parameter.tried(), ratios(2e-3, 0.2, 7), report)
    };
    let of_axis = |axis: usize| {
        let at_table = of(parameters::BACKLASH[axis], axis, None);
        let at_motor = of(parameters::BACKLASH_COMPENSATION[axis], axis, Some("motor"));
        [at_table.variant(AXES[axis]), at_motor.variant(format!("{}, compensated", AXES[axis]))]
    };
    recorded(context.runs).flat_map(of_axis).collect()
}

pub fn vibration(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let tracks = context.runs.iter().filter_map(|run| run.alignment.track.as_ref());
    let interval = tracks.map(|track| track.interval).fold(f64::INFINITY, f64::min);
    let of_axis = |axis: usize| {
        let mut frequency = parameters::VIBRATION_FREQUENCY[axis].tried().with(move |machine, value| {
            let damping = machine.axes[axis].mode.map_or(FIRST_DAMPING, |mode| mode.damping);
            machine.axes[axis].mode = Some(StructuralMode { frequency: value, damping });
        });
        let highest = (HIGHEST_FREQUENCY / interval).min(frequency.bounds.1);
        frequency.bounds.1 = highest.max(2.0);
        let damping = parameters::VIBRATION_DAMPING[axis].tried().with(move |machine, value| {
            if let Some(mode) = &mut machine.axes[axis].mode {
                mode.damping = value;
            }
        });
        let count = (6.0 * (highest / 3.0).max(1.0).log2()).ceil().clamp(1.0, 40.0) as usize + 1;
        let trials = ratios(3.0, highest.max(3.1), count)
            .into_iter()
            .map(|value| vec![value, FIRST_DAMPING])
            .collect();
        let report = move |values: &[f64]| {
            vec![AXIS.word(AXES[axis]), FREQUENCY.number(values[0]), DAMPING.number(values[1])]
        };
        Hypothesis::new(effect, vec![frequency, damping], trials, report).variant(AXES[axis])
    };
    recorded(context.runs).map(of_axis).collect()
}
