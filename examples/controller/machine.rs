//! Machines as they are declared to a control: limits of acceleration and velocity for each axis, and what else its
//! planner is set to.

use serde_json::{Value, json};

use crate::random::Random;

pub const AXES: [&str; 3] = ["x", "y", "z"];

/// Which control runs the programs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Family {
    /// The real one, by its recorder.
    LinuxCnc,
    /// Written after the real one, as [`crate::planners`] says.
    Grbl,
    Klipper,
    Marlin,
    /// Marlin with a junction deviation, its default.
    MarlinDeviation,
    TinyG,
}

impl Family {
    pub const NAMES: [(&'static str, Family); 6] = [
        ("linuxcnc", Family::LinuxCnc),
        ("grbl", Family::Grbl),
        ("klipper", Family::Klipper),
        ("marlin", Family::Marlin),
        ("marlin-deviation", Family::MarlinDeviation),
        ("tinyg", Family::TinyG),
    ];

    /// Its name as people write it.
    pub fn title(self) -> &'static str {
        match self {
            Family::LinuxCnc => "LinuxCNC",
            Family::Grbl => "grbl",
            Family::Klipper => "Klipper",
            Family::Marlin => "Marlin",
            Family::MarlinDeviation => "Marlin, junction deviation",
            Family::TinyG => "TinyG",
        }
    }

    pub fn named(name: &str) -> Option<Family> {
        Family::NAMES.into_iter().find_map(|(own, family)| (own == name).then_some(family))
    }
}

/// What each axis may do, mm/s² and mm/s, and further settings as options of the recorder.
#[derive(Clone, Debug)]
pub struct Limits {
    pub acceleration: [f64; 3],
    pub velocity: [f64; 3],
    pub settings: Vec<(String, f64)>,
}

impl Limits {
    /// Two thirds of the machines have axes that differ, the third axis then mostly the weakest.
    pub fn draw(random: &mut Random) -> Limits {
        let base = (random.log_uniform(300.0, 3000.0), random.log_uniform(60.0, 400.0));
        let unequal = random.chance(0.67);
        let mut axis = |factor_low: f64| {
            let mut part = || if unequal { random.uniform(factor_low, 1.0) } else { 1.0 };
            let acceleration = (base.0 * part()).clamp(300.0, 3000.0);
            let velocity = (base.1 * part()).clamp(60.0, 400.0);
            ((acceleration / 10.0).round() * 10.0, velocity.round())
        };
        let all = [axis(0.6), axis(0.5), axis(0.3)];
        Limits {
            acceleration: all.map(|pair| pair.0),
            velocity: all.map(|pair| pair.1),
            settings: Vec::new(),
        }
    }

    /// These limits on a control of `family`, with the settings of its planner. Klipper has one velocity and one
    /// acceleration along the path, and those of Z.
    pub fn on(mut self, family: Family, random: &mut Random) -> Limits {
        let rounded = |value: f64| (value * 1e3).round() / 1e3;
        match family {
            Family::LinuxCnc => {}
            Family::Grbl => {
                let deviation = rounded(random.log_uniform(0.004, 0.06));
                self.settings = vec![("--junction-deviation".into(), deviation)];
            }
            Family::Marlin | Family::MarlinDeviation => {
                self.settings = match family {
                    Family::Marlin => vec![("--corner-step".into(), rounded(random.log_uniform(1.0, 15.0)))],
                    _ => vec![
                        ("--junction-deviation".into(), rounded(random.log_uniform(0.005, 0.08))),
                        ("--short-blocks".into(), 1.0),
                    ],
                };
                self.settings.push(("--s-curve".into(), if random.chance(0.5) { 1.0 } else { 0.0 }));
            }
            Family::TinyG => {
                let deviation = rounded(random.log_uniform(0.01, 0.1));
                let seconds = rounded(random.log_uniform(0.02, 0.2));
                self.settings =
                    vec![("--junction-deviation".into(), deviation), ("--jerk-time".into(), seconds)];
            }
            Family::Klipper => {
                self.acceleration[1] = self.acceleration[0];
                self.velocity[1] = self.velocity[0];
                let corner = rounded(random.log_uniform(1.0, 15.0));
                let ratio = random.pick(&[0.5, 0.5, 0.25, 0.0]);
                self.settings =
                    vec![("--square-corner-velocity".into(), corner), ("--cruise-ratio".into(), ratio)];
            }
        }
        self
    }

    fn setting(&self, option: &str) -> Option<f64> {
        self.settings.iter().find(|(own, _)| own == option).map(|setting| setting.1)
    }

    /// grbl's junction deviation, mm.
    pub fn junction_deviation(&self) -> f64 {
        self.setting("--junction-deviation").unwrap_or(f64::NAN)
    }

    /// Klipper's square-corner velocity, mm/s.
    pub fn square_corner_velocity(&self) -> f64 {
        self.setting("--square-corner-velocity").unwrap_or(f64::NAN)
    }

    /// The options by which the recorder declares them.
    pub fn options(&self) -> Vec<String> {
        let mut options = Vec::new();
        for (axis, letter) in AXES.iter().enumerate() {
            options.extend([format!("--acc-{letter}"), self.acceleration[axis].to_string()]);
            options.extend([format!("--vel-{letter}"), self.velocity[axis].to_string()]);
        }
        options.extend(self.settings.iter().flat_map(|(option, value)| [option.clone(), value.to_string()]));
        options
    }

    /// Returns the limits that [`Limits::to_json`] wrote.
    pub fn from_json(json: &Value) -> Limits {
        let of = |key: &str| std::array::from_fn(|axis| json[key][axis].as_f64().unwrap_or(f64::NAN));
        let settings = json["settings"].as_object().into_iter().flatten();
        Limits {
            acceleration: of("acceleration_mm_s2"),
            velocity: of("velocity_mm_s"),
            settings: settings
                .filter_map(|(option, value)| Some((option.clone(), value.as_f64()?)))
                .collect(),
        }
    }

    pub fn to_json(&self) -> Value {
        let settings: serde_json::Map<String, Value> =
            self.settings.iter().map(|(option, value)| (option.clone(), json!(value))).collect();
        json!({ "acceleration_mm_s2": self.acceleration, "velocity_mm_s": self.velocity, "settings": settings })
    }
}
