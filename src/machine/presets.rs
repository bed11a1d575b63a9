//! Presets: machines to begin with, each with the source of its numbers and their limits.

use crate::machine::{Interpolator, Machine, RapidMoves, TimeConstants};

/// A machine to begin with, and notes on its numbers.
pub struct Preset {
    /// The machine.
    pub machine: Machine,
    /// Source of the numbers.
    pub source: &'static str,
    /// Limits of the numbers.
    pub caveat: &'static str,
}

/// Largest error of the model's cycle times against the paper's measurements, in the last column of Table 1
/// of `docs/paper.md`.
const MAX_ERROR_OF_PAPER: f64 = 0.079;

/// Returns the presets, the default first.
pub fn presets() -> Vec<Preset> {
    let with = |name: &str, time_constant: f64, tolerance: f64, rapid_feedrate: f64, tool_change: f64| {
        let mut machine = Machine { name: name.to_string(), ..Machine::default() };
        machine.interpolator = Interpolator {
            time_constants: TimeConstants::Equal(time_constant),
            contour_tolerance: tolerance,
            ..machine.interpolator
        };
        machine.rapid = RapidMoves { feedrate: rapid_feedrate, ..machine.rapid };
        machine.times.tool_change = tool_change;
        machine
    };
    let mut measured = with("5-axis machining centre (DMG Mori eVo 40, TNC 640)", 0.0255, 0.010, 500.0, 4.0);
    measured.cycle_time_error = Some(MAX_ERROR_OF_PAPER);
    measured.calibrated_at = vec![0.010, 0.050];
    measured.provenance = "eight test pockets (Ward et al. 2021, Table 1)".to_string();
    let typical = "Typical values, not of a particular machine.";
    vec![
        Preset {
            machine: measured,
            source: "T1 from the ramp of 0.0765 s measured in Ward et al. 2021, Sect. 2.2.",
            caveat: "Rapid feedrate and tool change are typical values, not measured.",
        },
        Preset {
            machine: with("Vertical machining centre, mid-range", 0.030, 0.020, 400.0, 6.0),
            source: typical,
            caveat: "Calibrate before quoting.",
        },
        Preset {
            machine: with("Older or heavy machine", 0.050, 0.050, 200.0, 10.0),
            source: typical,
            caveat: "Calibrate before quoting.",
        },
        Preset {
            machine: with("Router or light gantry", 0.060, 0.100, 250.0, 20.0),
            source: typical,
            caveat: "Assumes manual tool changes. Calibrate before quoting.",
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_the_measured_preset_is_the_largest_of_the_table() {
        let table = include_str!("../../docs/paper.md").split("| pocket |").nth(1).expect("Table 1");
        let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
        let cells =
            rows.map(|row| row.trim_matches(['|', ' ']).split('|').map(str::trim).collect::<Vec<_>>());
        let (misses, tolerances): (Vec<f64>, Vec<f64>) = cells
            .map(|cells| {
                let miss = cells[cells.len() - 1].trim_end_matches(" %").parse::<f64>();
                let tolerance = cells[2].parse::<f64>().expect("micrometres");
                (miss.expect("a percentage").abs() / 100.0, tolerance / 1000.0)
            })
            .unzip();
        assert_eq!(misses.len(), 8);
        let largest = misses.into_iter().fold(0.0, f64::max);
        assert_eq!(largest, MAX_ERROR_OF_PAPER);
        let measured = &presets()[0].machine;
        assert_eq!(measured.cycle_time_error, Some(largest));
        assert!(tolerances.iter().all(|tolerance| measured.calibrated_at.contains(tolerance)));
        assert!(measured.calibrated_at.iter().all(|tolerance| tolerances.contains(tolerance)));
        assert!(presets()[1..].iter().all(|preset| preset.machine.cycle_time_error.is_none()));
    }
}
