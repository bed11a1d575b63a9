//! The settings of a control. Options set them, named as those of LinuxCNC's recorder, with a few more for these planners.

use crate::Refusal;
use crate::machine::AXES;

/// The settings of a run, mm and s.
#[derive(Clone)]
pub struct Settings {
    pub acceleration: [f64; 3],
    pub velocity: [f64; 3],
    /// The highest velocity along the path.
    pub path_velocity: f64,
    /// grbl's `$11`, mm.
    pub junction_deviation: f64,
    /// Klipper's `square_corner_velocity`, mm/s.
    pub square_corner_velocity: f64,
    /// Klipper's `minimum_cruise_ratio`.
    pub cruise_ratio: f64,
    /// Marlin's largest step of an axis' velocity, mm/s.
    pub corner_step: Option<f64>,
    /// Whether the junction deviation is Marlin's, with `JD_HANDLE_SMALL_SEGMENTS`.
    pub has_short_blocks_as_chords: bool,
    /// Whether Marlin's ramps are curves.
    pub is_curved: bool,
    /// The time after which TinyG's jerk has built up the acceleration of an axis, s.
    pub jerk_time: Option<f64>,
    /// Blocks that the planner knows, the one in execution among them.
    pub look_ahead: usize,
    pub rapid_override: f64,
    /// From which time of the run which part of the programmed feedrate is run.
    pub feed_overrides: Vec<(f64, f64)>,
    /// When the operator halts the motion, and for how long.
    pub hold: Option<(f64, f64)>,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            acceleration: [500.0; 3],
            velocity: [100.0; 3],
            path_velocity: f64::INFINITY,
            junction_deviation: 0.01,
            square_corner_velocity: 5.0,
            cruise_ratio: 0.5,
            corner_step: None,
            has_short_blocks_as_chords: false,
            is_curved: false,
            jerk_time: None,
            look_ahead: 15,
            rapid_override: 1.0,
            feed_overrides: Vec::new(),
            hold: None,
        }
    }
}

impl Settings {
    /// Returns the settings that `options` name. Of an option given twice the last one holds.
    pub fn from_options(options: &[String]) -> Result<Settings, Refusal> {
        let mut settings = Settings::default();
        for pair in options.chunks(2) {
            let [option, value] = pair else { return Err(format!("{pair:?} has no value").into()) };
            settings.set(option, value)?;
        }
        Ok(settings)
    }

    fn set(&mut self, option: &str, value: &str) -> Result<(), Refusal> {
        let pairs = || -> Result<Vec<(f64, f64)>, Refusal> {
            let pair = |text: &str| -> Result<(f64, f64), Refusal> {
                let (time, number) = text.split_once(':').ok_or_else(|| format!("{text} is no pair"))?;
                Ok((time.parse()?, number.parse()?))
            };
            value.split(',').map(pair).collect()
        };
        let axis = |prefix: &str| AXES.iter().position(|axis| option.strip_prefix(prefix) == Some(*axis));
        match option {
            "--override" => self.feed_overrides = vec![(0.0, value.parse()?)],
            "--override-at" => self.feed_overrides = pairs()?,
            "--rapid-override" => self.rapid_override = value.parse()?,
            "--hold-at" => self.hold = pairs()?.first().copied(),
            "--max-vel-slider" => self.path_velocity = value.parse()?,
            "--junction-deviation" => self.junction_deviation = value.parse()?,
            "--square-corner-velocity" => self.square_corner_velocity = value.parse()?,
            "--cruise-ratio" => self.cruise_ratio = value.parse()?,
            "--corner-step" => self.corner_step = Some(value.parse()?),
            "--short-blocks" => self.has_short_blocks_as_chords = value != "0",
            "--s-curve" => self.is_curved = value != "0",
            "--jerk-time" => self.jerk_time = Some(value.parse()?),
            "--look-ahead" => self.look_ahead = value.parse()?,
            _ => match (axis("--acc-"), axis("--vel-")) {
                (Some(axis), _) => self.acceleration[axis] = value.parse()?,
                (_, Some(axis)) => self.velocity[axis] = value.parse()?,
                _ => return Err(format!("a planner knows no {option}").into()),
            },
        }
        Ok(())
    }
}
