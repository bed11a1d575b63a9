//! Machines as they are declared to LinuxCNC: limits of acceleration and velocity for each axis.

use serde_json::{Value, json};

use crate::random::Random;

pub const AXES: [&str; 3] = ["x", "y", "z"];

/// What each axis may do, mm/s² and mm/s.
#[derive(Clone, Debug)]
pub struct Limits {
    pub acceleration: [f64; 3],
    pub velocity: [f64; 3],
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
        Limits { acceleration: all.map(|pair| pair.0), velocity: all.map(|pair| pair.1) }
    }

    /// The options by which the recorder declares them.
    pub fn options(&self) -> Vec<String> {
        let mut options = Vec::new();
        for (axis, letter) in AXES.iter().enumerate() {
            options.extend([format!("--acc-{letter}"), self.acceleration[axis].to_string()]);
            options.extend([format!("--vel-{letter}"), self.velocity[axis].to_string()]);
        }
        options
    }

    /// Returns the limits that [`Limits::to_json`] wrote.
    pub fn from_json(json: &Value) -> Limits {
        let of = |key: &str| std::array::from_fn(|axis| json[key][axis].as_f64().unwrap_or(f64::NAN));
        Limits { acceleration: of("acceleration_mm_s2"), velocity: of("velocity_mm_s") }
    }

    pub fn to_json(&self) -> Value {
        json!({ "acceleration_mm_s2": self.acceleration, "velocity_mm_s": self.velocity })
    }
}
