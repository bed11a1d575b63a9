//! Effects of the drives on the form of the path: they cost no time.

use std::sync::Arc;

use crate::identification::fit::{Freed, Run, Scale};
use crate::identification::hypotheses::{Hypothesis, Report, Reported, Trace, ratios};
use crate::machine::{AXES, Mode};

/// Damping tried first.
const DAMPING: f64 = 0.04;

pub fn hypotheses(runs: &[Run]) -> Vec<Hypothesis> {
    let recorded = |axis: usize| {
        runs.iter().any(|run| run.alignment.track.as_ref().is_some_and(|track| track.recorded[axis]))
    };
    let axes: Vec<usize> = (0..3).filter(|axis| recorded(*axis)).collect();
    if axes.is_empty() {
        return Vec::new();
    }
    let report: Report = Arc::new(|values| vec![("time_constant_s", Reported::Number(values[0]))]);
    let lag = Freed::new("axis.x.servo_lag_s", 0.01, (1e-5, 0.5), Scale::Ratio, |machine, value| {
        machine.axes.iter_mut().for_each(|axis| axis.servo_lag = value);
    });
    let mut all = vec![Hypothesis {
        id: "servo_lag",
        variant: String::new(),
        trace: Trace::Form,
        freed: vec![lag],
        trials: ratios(1e-3, 0.15, 9).into_iter().map(|value| vec![value]).collect(),
        is_continuous: true,
        report,
    }];
    // Vibrations that the recorder cannot show are not looked for: a little less than half the sampling rate at most.
    let interval = runs.iter().filter_map(|run| run.alignment.track.as_ref()).map(|track| track.interval);
    let highest = 0.45 / interval.fold(f64::INFINITY, f64::min);
    for axis in axes {
        let name = AXES[axis];
        let word = move || ("axis", Reported::Word(name.to_string()));
        let key = |what: &str| format!("axis.{}.{what}", name.to_ascii_lowercase());
        let width = Freed::new(key("backlash_mm"), 0.01, (1e-4, 2.0), Scale::Ratio, move |machine, value| {
            machine.axes[axis].backlash = value;
        });
        all.push(Hypothesis {
            id: "backlash",
            variant: name.to_string(),
            trace: Trace::Form,
            freed: vec![width],
            trials: ratios(2e-3, 0.2, 7).into_iter().map(|value| vec![value]).collect(),
            is_continuous: true,
            report: Arc::new(move |values| vec![word(), ("width_mm", Reported::Number(values[0]))]),
        });
        let frequency = Freed::new(
            key("vibration_hz"),
            10.0,
            (1.0, highest.max(2.0)),
            Scale::Ratio,
            move |machine, value| {
                let damping = machine.axes[axis].mode.map_or(DAMPING, |mode| mode.damping);
                machine.axes[axis].mode = Some(Mode { frequency: value, damping });
            },
        );
        let damping = Freed::new(
            key("vibration_damping"),
            DAMPING,
            (1e-3, 0.7),
            Scale::Ratio,
            move |machine, value| {
                if let Some(mode) = &mut machine.axes[axis].mode {
                    mode.damping = value;
                }
            },
        );
        let count = (6.0 * (highest / 3.0).max(1.0).log2()).ceil().clamp(1.0, 40.0) as usize + 1;
        all.push(Hypothesis {
            id: "structural_vibration",
            variant: name.to_string(),
            trace: Trace::Form,
            freed: vec![frequency, damping],
            trials: ratios(3.0, highest.max(3.1), count)
                .into_iter()
                .map(|value| vec![value, DAMPING])
                .collect(),
            is_continuous: true,
            report: Arc::new(move |values| {
                vec![
                    word(),
                    ("frequency_hz", Reported::Number(values[0])),
                    ("damping", Reported::Number(values[1])),
                ]
            }),
        });
    }
    all
}
