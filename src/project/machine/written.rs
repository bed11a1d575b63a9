//! Parameters as written in machine files and forms: values in the units of their keys, and the rules between keys.

use crate::machine::{Access, Machine, PARAMETERS, Parameter, TimeConstants, Tool, parameter};
use crate::project::TextFault;
use crate::units::Unit;

/// Keys of a machine's calibration: its errors and programs.
pub const CALIBRATION_KEYS: [&str; 23] = [
    "calibration.cycle_time_error_percent",
    "calibration.unexplained_percent",
    "calibration.form_error_mm",
    "calibration.typical_form_error_mm",
    "calibration.range_percent",
    "calibration.ramp_misfit_percent",
    "calibration.turns_deg",
    "calibration.radii_mm",
    "calibration.blocks_mm",
    "calibration.feeds_mm_min",
    "calibration.rapids_mm",
    "calibration.velocities_mm_min",
    "calibration.travels_mm",
    "calibration.assumed_accelerations",
    "calibration.least_accelerations_mm_s2",
    "calibration.least_jerks_mm_s3",
    "calibration.acceleration_deviations_percent",
    "calibration.largest_override_percent",
    "calibration.other_chords_percent",
    "calibration.only_rapid_feed_mm_min",
    "calibration.assumed_rapids",
    "calibration.m_codes",
    "calibration.tolerances_mm",
];

/// Keys that a machine must have; every other number is neutral if missing.
pub const REQUIRED_KEYS: [&str; 3] =
    ["interpolator.filters", "interpolator.contour_tolerance_mm", "times.tool_change_s"];

/// Key that is also required unless each axis has a rapid feedrate.
pub const RAPID_KEY: &str = "rapid.feed_mm_min";

/// A value as written, in the unit of its key.
#[derive(Clone, Debug, PartialEq)]
pub enum WrittenValue {
    Number(f64),
    Text(String),
    Flag(bool),
    List(Vec<f64>),
    Codes(Vec<(String, f64)>),
    /// Diameters by tool number.
    Tools(Vec<(String, f64)>),
    /// An empty field.
    Empty,
}

/// Returns the row of a key, or a fault that names the nearest known key.
pub fn known_parameter(key: &str) -> Result<&'static Parameter, TextFault> {
    parameter(key).ok_or_else(|| {
        let distance = |known: &&Parameter| strsim::damerau_levenshtein(known.key, key);
        let nearest = PARAMETERS.iter().min_by_key(distance).expect("the table is not empty");
        TextFault::at_key(key, format!("unknown key; the nearest known one is {}", nearest.key))
    })
}

/// Returns the index of a key in the table. Values are set in this order, because some depend on others: a
/// damping ratio on its mode.
pub fn position(key: &str) -> usize {
    PARAMETERS.iter().position(|row| row.key == key).unwrap_or(PARAMETERS.len())
}

/// Sets a parameter of the machine to a written value.
pub fn set(machine: &mut Machine, key: &str, written: WrittenValue) -> Result<(), TextFault> {
    let row = known_parameter(key)?;
    let expected = |what: String| Err(TextFault::at_key(key, format!("expected {what}")));
    let within = |value: f64, min: f64, max: f64, symbol: &str| -> Result<(), TextFault> {
        if value.is_finite() && min <= value && value <= max {
            return Ok(());
        }
        let unit = if symbol.is_empty() { String::new() } else { format!(" {symbol}") };
        Err(TextFault::at_key(key, format!("{value} is outside {min} to {max}{unit}")))
    };
    match (&row.access, written) {
        (Access::Number { unit, min, max, whole, set, .. }, WrittenValue::Number(value)) => {
            within(value, *min, *max, unit.symbol())?;
            if *whole && value.fract() != 0.0 {
                return expected(format!("a whole number from {min} to {max}"));
            }
            set(machine, Some(unit.to_core(value)));
        }
        (Access::Number { set, .. }, WrittenValue::Empty) if !REQUIRED_KEYS.contains(&key) => {
            set(machine, None)
        }
        (Access::List { unit, min, max, whole, most, set, .. }, WrittenValue::List(values)) => {
            if values.is_empty() || *most < values.len() {
                return expected(format!("one to {most} numbers"));
            }
            for &value in &values {
                within(value, *min, *max, unit.symbol())?;
                if *whole && value.fract() != 0.0 {
                    return expected(format!("whole numbers from {min} to {max}"));
                }
            }
            set(machine, values.into_iter().map(|value| unit.to_core(value)).collect());
        }
        (Access::List { .. }, WrittenValue::Empty) => {}
        (Access::Choice { words, set, .. }, WrittenValue::Text(word)) if words.contains(&word.as_str()) => {
            set(machine, &word);
        }
        (Access::Flag { set, .. }, WrittenValue::Flag(value)) => set(machine, value),
        (Access::Text { set, .. }, WrittenValue::Text(text)) => set(machine, &text),
        (Access::Codes { letter, unit, min, max, get_mut, .. }, WrittenValue::Codes(codes)) => {
            let table = get_mut(machine);
            table.clear();
            for (code, seconds) in codes {
                let digits = code.strip_prefix([*letter, letter.to_ascii_lowercase()]);
                let Some(number) = digits.and_then(|digits| digits.parse().ok()) else {
                    return Err(TextFault::at_key(key, format!("{code} is not a word such as {letter}3")));
                };
                within(seconds, *min, *max, unit.symbol())?;
                table.insert(number, seconds);
            }
        }
        (Access::Codes { get_mut, .. }, WrittenValue::Empty) => get_mut(machine).clear(),
        // In a form all tables of numbers look alike.
        (Access::Tools, WrittenValue::Tools(tools) | WrittenValue::Codes(tools)) => {
            machine.tools.clear();
            for (tool, diameter) in tools {
                let Ok(number) = tool.parse() else {
                    return Err(TextFault::at_key(key, format!("{tool} is not a tool number such as 5")));
                };
                within(diameter, -1000.0, 1000.0, "mm")?;
                machine.tools.insert(number, Tool { diameter });
            }
        }
        (Access::Tools, WrittenValue::Empty) => machine.tools.clear(),
        (access, other) => return expected(form_of(access, &other)),
    }
    Ok(())
}

/// Returns a description of the format of a parameter, for a user who wrote a different one.
fn form_of(access: &Access, written: &WrittenValue) -> String {
    let in_unit = |unit: &Unit| match unit.symbol() {
        "" => String::new(),
        symbol => format!(" in {symbol}"),
    };
    match access {
        Access::Number { unit, min, max, whole, .. } if matches!(written, WrittenValue::Empty) => {
            let kind = if *whole { "a whole number" } else { "a number" };
            format!("{kind} from {min} to {max} {}", unit.symbol()).trim_end().to_string()
        }
        Access::Number { unit, .. } => {
            let set_apart = matches!(written, WrittenValue::Text(text) if text.contains([',', '.']));
            let advice = if set_apart { ", with nothing between thousands, such as 1250" } else { "" };
            format!("a number{}{advice}", in_unit(unit))
        }
        Access::List { unit, .. } => format!("a list of numbers{}, such as [10, 11]", in_unit(unit)),
        Access::Choice { words, .. } => format!("one of: {}", words.join(", ")),
        Access::Flag { .. } => "true or false".to_string(),
        Access::Text { .. } => "text".to_string(),
        Access::Tools => "a table of diameters by tool number".to_string(),
        Access::Codes { letter, unit, .. } => {
            let what = if *unit == Unit::Second { "seconds" } else { "numbers" };
            format!("a table of {what} by word, such as {letter}3 = 4.0")
        }
    }
}

/// Returns the value of a parameter as written; `None` if the machine has none.
pub fn written(machine: &Machine, row: &Parameter) -> Option<WrittenValue> {
    match &row.access {
        Access::Number { unit, get, .. } => {
            get(machine).map(|value| WrittenValue::Number(tidy(unit.from_core(value))))
        }
        Access::List { unit, get, .. } => get(machine).map(|values| {
            WrittenValue::List(values.into_iter().map(|value| unit.from_core(value)).collect())
        }),
        Access::Choice { get, .. } => Some(WrittenValue::Text(get(machine).to_string())),
        Access::Flag { get, .. } => Some(WrittenValue::Flag(get(machine))),
        Access::Text { get, .. } => Some(WrittenValue::Text(get(machine).to_string())),
        Access::Tools if machine.tools.is_empty() => None,
        Access::Tools => {
            let tools = machine.tools.iter().map(|(number, tool)| (number.to_string(), tool.diameter));
            Some(WrittenValue::Tools(tools.collect()))
        }
        Access::Codes { get, .. } if get(machine).is_empty() => None,
        Access::Codes { letter, get, .. } => {
            let codes = get(machine).iter().map(|(code, seconds)| (format!("{letter}{code}"), *seconds));
            Some(WrittenValue::Codes(codes.collect()))
        }
    }
}

/// Rounds a number to a short decimal if the difference is only rounding: 12000 mm/min must not come back
/// from mm/s as 11999.999999999998.
pub fn tidy(value: f64) -> f64 {
    let short: f64 = format!("{value:.12e}").parse().expect("a number as printed is a number");
    if (short - value).abs() <= 4.0 * f64::EPSILON * value.abs() { short } else { value }
}

/// Keys of the filters' time constants: exactly one is required.
pub const TIME_CONSTANT_KEYS: [&str; 3] =
    ["interpolator.time_constant_s", "interpolator.max_jerk_mm_s3", "interpolator.time_constants_s"];

/// Keys of the chords of arcs: a machine has at most one.
pub const ARC_CHORD_KEYS: [&str; 2] = ["interpolator.arc_chord_error_mm", "interpolator.arc_chord_mm"];

/// Keys of the time constants of rapids: a machine has at most one.
pub const RAPID_TIME_CONSTANT_KEYS: [&str; 2] = ["rapid.time_constant_s", "rapid.max_jerk_mm_s3"];

/// Returns the pairs of given keys that exclude each other.
pub fn rivals(is_given: &dyn Fn(&str) -> bool) -> Vec<(&'static str, &'static str)> {
    let alternatives: [&[&'static str]; 3] =
        [&TIME_CONSTANT_KEYS, &RAPID_TIME_CONSTANT_KEYS, &ARC_CHORD_KEYS];
    let pair = |keys: &[&'static str]| {
        let mut given = keys.iter().copied().filter(|key| is_given(key));
        given.next().zip(given.next())
    };
    alternatives.into_iter().filter_map(pair).collect()
}

/// Returns a fault if several settings contradict each other.
pub fn contradiction(machine: &Machine) -> Option<TextFault> {
    if machine.rapid.feedrate == f64::INFINITY && !machine.has_rapids_of_axes() {
        let message = "this key is missing; give it, or axis.x.rapid_mm_min, axis.y.rapid_mm_min and axis.z.rapid_mm_min";
        return Some(TextFault::at_key(RAPID_KEY, message.to_string()));
    }
    let constants = &machine.interpolator.time_constants;
    match constants {
        TimeConstants::Unequal(list) if list.len() != machine.interpolator.filters => {
            let message = format!(
                "{} time constants for {} filters; give one for each",
                list.len(),
                machine.interpolator.filters
            );
            Some(TextFault::at_key("interpolator.time_constants_s", message))
        }
        _ => None,
    }
}
