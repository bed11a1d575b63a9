//! Machines to begin with. Each says where its numbers come from and what they are not.

use crate::machine::{Interpolator, Machine, Rapid, TimeConstants};

/// A machine to begin with, and what to know about its numbers.
pub struct Preset {
    /// The machine.
    pub machine: Machine,
    /// Where the numbers come from.
    pub source: &'static str,
}

/// The presets, the default first.
pub fn presets() -> Vec<Preset> {
    let with = |name: &str, time_constant: f64, tolerance: f64, rapid_feedrate: f64, tool_change: f64| {
        let mut machine = Machine { name: name.to_string(), ..Machine::default() };
        machine.interpolator = Interpolator {
            time_constants: TimeConstants::Equal(time_constant),
            contour_tolerance: tolerance,
            ..machine.interpolator
        };
        machine.rapid = Rapid { feedrate: rapid_feedrate, ..machine.rapid };
        machine.times.tool_change = tool_change;
        machine
    };
    vec![
        Preset {
            machine: with("5-axis machining centre (DMG Mori eVo 40, TNC 640)", 0.0255, 0.010, 500.0, 4.0),
            source: "T1 from the ramp of 0.0765 s measured in Ward et al. 2021, Sect. 2.2. Rapid feedrate and tool change are typical values, not measured.",
        },
        Preset {
            machine: with("Vertical machining centre, mid-range", 0.030, 0.020, 400.0, 6.0),
            source: "Typical values, not of a particular machine. Calibrate before quoting.",
        },
        Preset {
            machine: with("Older or heavy machine", 0.050, 0.050, 200.0, 10.0),
            source: "Typical values, not of a particular machine. Calibrate before quoting.",
        },
        Preset {
            machine: with("Router or light gantry", 0.060, 0.100, 250.0, 20.0),
            source: "Typical values, not of a particular machine. Tool changes are taken as manual.",
        },
    ]
}
