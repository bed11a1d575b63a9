//! Everything that crosses a border as text: machine files, the page's form, results.
//!
//! This is the only keeper of file and message formats, and so of serde. Names carry their units
//! here (`cycle_time_s`), and values are converted on the way through the parameter table
//! ([`PARAMETERS`]), so that the core sees mm, s and rad.

mod archive;
mod calibrated_view;
mod comparison;
mod cutting_file;
mod cutting_results;
mod diagnosis;
mod dropped;
mod form;
mod machine_file;
mod offer;
mod offer_csv;
mod offer_facts;
mod offer_html;
mod request;
mod places;
mod results;
mod settings;
mod terms;
mod trust;

pub use archive::{ArchiveLine, Keys, LineOwner, begins_a_line};
pub use calibrated_view::CalibrationReport;
pub use comparison::{ComparisonReport, Refusal, lost_label};
pub use cutting_file::{EXAMPLE_CUTTING, cutting_from_toml};
pub use cutting_results::{cutting_refusal, cutting_remarks, cutting_table, loads_csv, materials_json};
pub use diagnosis::{DiagnosisReport, RunChart, diagnosis_chart, extended};
pub use dropped::{FileKind, file_kind};
pub use form::{arc_centers, dialects, edited, faults_to_json, form, machine_from_form, machine_values};
pub use machine_file::{machine_from_toml, motion_of_machine, toml_from_machine};
pub use offer::OfferReport;
pub use request::{QuoteRequest, RequestError};
pub use results::{HeldTolerance, Prediction, profile_csv, severity_word, spacing_note};
pub use settings::{SettingsError, settings_from_text, settings_text};
pub use terms::{terms_form, terms_from_form};
pub use trust::doubt_sentence;

use crate::machine::{Access, Machine, PARAMETERS, Parameter, TimeConstants, Tool, parameter};
use crate::units::Unit;

/// The version of this build, which no two commits share (`build.rs`): `0.1.0`, or `0.1.0+12.gc32ad9a` 12 commits later.
pub const VERSION: &str = env!("TRUEFEED_VERSION");

/// How far off a machine was when it was calibrated, and at which tolerances.
const CALIBRATION: [&str; 4] = [
    "calibration.cycle_time_error_percent",
    "calibration.unexplained_percent",
    "calibration.form_error_mm",
    "calibration.tolerances_mm",
];

/// Keys without which a machine says too little; every other number is neutral when left out.
const REQUIRED: [&str; 3] =
    ["interpolator.filters", "interpolator.contour_tolerance_mm", "times.tool_change_s"];

/// Needed too, unless each axis has a rapid of its own.
const RAPID: &str = "rapid.feed_mm_min";

/// Something wrong with a machine as written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}{}{message}", line_and_column(.place), .key.as_ref().map(|key| format!("{key}: ")).unwrap_or_default())]
pub struct Fault {
    /// Line and column in the text, 1-based, where there is a text.
    pub place: Option<(usize, usize)>,
    /// Key it concerns.
    pub key: Option<String>,
    /// What is wrong and what would do instead.
    pub message: String,
}

fn line_and_column(place: &Option<(usize, usize)>) -> String {
    place.map(|(line, column)| format!("line {line}, column {column}: ")).unwrap_or_default()
}

impl Fault {
    fn at_key(key: &str, message: String) -> Fault {
        Fault { place: None, key: Some(key.to_string()), message }
    }
}

/// A value as written, in the unit of its key.
#[derive(Clone, Debug, PartialEq)]
enum Written {
    Number(f64),
    Text(String),
    Flag(bool),
    List(Vec<f64>),
    Codes(Vec<(String, f64)>),
    /// Diameters by tool number.
    Tools(Vec<(String, f64)>),
    /// The field was left empty.
    Empty,
}

/// The row of the table for a key, or a fault that names the nearest known key.
fn known_parameter(key: &str) -> Result<&'static Parameter, Fault> {
    parameter(key).ok_or_else(|| {
        let distance = |known: &&Parameter| strsim::damerau_levenshtein(known.key, key);
        let nearest = PARAMETERS.iter().min_by_key(distance).expect("the table is not empty");
        Fault::at_key(key, format!("unknown key; the nearest known one is {}", nearest.key))
    })
}

/// Where a key stands in the table. Values are set in this order, because some need another one
/// to be there: a damping ratio its mode.
fn position(key: &str) -> usize {
    PARAMETERS.iter().position(|row| row.key == key).unwrap_or(PARAMETERS.len())
}

/// Gives a parameter of the machine the value written for it.
fn set(machine: &mut Machine, key: &str, written: Written) -> Result<(), Fault> {
    let row = known_parameter(key)?;
    let expected = |what: String| Err(Fault::at_key(key, format!("expected {what}")));
    let within = |value: f64, min: f64, max: f64, symbol: &str| -> Result<(), Fault> {
        if value.is_finite() && min <= value && value <= max {
            return Ok(());
        }
        let unit = if symbol.is_empty() { String::new() } else { format!(" {symbol}") };
        Err(Fault::at_key(key, format!("{value} is outside {min} to {max}{unit}")))
    };
    match (&row.access, written) {
        (Access::Number { unit, min, max, whole, set, .. }, Written::Number(value)) => {
            within(value, *min, *max, unit.symbol())?;
            if *whole && value.fract() != 0.0 {
                return expected(format!("a whole number from {min} to {max}"));
            }
            set(machine, Some(unit.to_core(value)));
        }
        (Access::Number { unit, min, max, whole, .. }, Written::Empty) if REQUIRED.contains(&key) => {
            let kind = if *whole { "a whole number" } else { "a number" };
            return expected(format!("{kind} from {min} to {max} {}", unit.symbol()).trim_end().to_string());
        }
        (Access::Number { set, .. }, Written::Empty) => set(machine, None),
        (Access::Number { unit, .. }, other) => {
            let unit =
                if unit.symbol().is_empty() { String::new() } else { format!(" in {}", unit.symbol()) };
            let set_apart = matches!(&other, Written::Text(text) if text.contains([',', '.']));
            let advice = if set_apart { ", with nothing between thousands, such as 1250" } else { "" };
            return expected(format!("a number{unit}{advice}"));
        }
        (Access::List { unit, min, max, whole, most, set, .. }, Written::List(values)) => {
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
        (Access::List { .. }, Written::Empty) => {}
        (Access::List { unit, .. }, _) => {
            let unit =
                if unit.symbol().is_empty() { String::new() } else { format!(" in {}", unit.symbol()) };
            return expected(format!("a list of numbers{unit}, such as [10, 11]"));
        }
        (Access::Choice { words, set, .. }, Written::Text(word)) if words.contains(&word.as_str()) => {
            set(machine, &word);
        }
        (Access::Choice { words, .. }, _) => return expected(format!("one of: {}", words.join(", "))),
        (Access::Flag { set, .. }, Written::Flag(value)) => set(machine, value),
        (Access::Flag { .. }, _) => return expected("true or false".to_string()),
        (Access::Text { set, .. }, Written::Text(text)) => set(machine, &text),
        (Access::Text { .. }, _) => return expected("text".to_string()),
        (Access::Codes { letter, unit, min, max, get_mut, .. }, Written::Codes(codes)) => {
            let table = get_mut(machine);
            table.clear();
            for (code, seconds) in codes {
                let digits = code.strip_prefix([*letter, letter.to_ascii_lowercase()]);
                let Some(number) = digits.and_then(|digits| digits.parse().ok()) else {
                    return Err(Fault::at_key(key, format!("{code} is not a word such as {letter}3")));
                };
                within(seconds, *min, *max, unit.symbol())?;
                table.insert(number, seconds);
            }
        }
        // A form does not tell one table of numbers from another.
        (Access::Tools, Written::Tools(tools) | Written::Codes(tools)) => {
            machine.tools.clear();
            for (tool, diameter) in tools {
                let Ok(number) = tool.parse() else {
                    return Err(Fault::at_key(key, format!("{tool} is not a tool number such as 5")));
                };
                within(diameter, -1000.0, 1000.0, "mm")?;
                machine.tools.insert(number, Tool { diameter });
            }
        }
        (Access::Tools, Written::Empty) => machine.tools.clear(),
        (Access::Tools, _) => return expected("a table of diameters by tool number".to_string()),
        (Access::Codes { get_mut, .. }, Written::Empty) => get_mut(machine).clear(),
        (Access::Codes { letter, unit, .. }, _) => {
            let what = if *unit == Unit::Second { "seconds" } else { "numbers" };
            return expected(format!("a table of {what} by word, such as {letter}3 = 4.0"));
        }
    }
    Ok(())
}

/// The value of a parameter as it would be written; none where the machine does not have it.
fn written(machine: &Machine, row: &Parameter) -> Option<Written> {
    match &row.access {
        Access::Number { unit, get, .. } => {
            get(machine).map(|value| Written::Number(tidy(unit.from_core(value))))
        }
        Access::List { unit, get, .. } => get(machine)
            .map(|values| Written::List(values.into_iter().map(|value| unit.from_core(value)).collect())),
        Access::Choice { get, .. } => Some(Written::Text(get(machine).to_string())),
        Access::Flag { get, .. } => Some(Written::Flag(get(machine))),
        Access::Text { get, .. } => Some(Written::Text(get(machine).to_string())),
        Access::Tools if machine.tools.is_empty() => None,
        Access::Tools => {
            let tools = machine.tools.iter().map(|(number, tool)| (number.to_string(), tool.diameter));
            Some(Written::Tools(tools.collect()))
        }
        Access::Codes { get, .. } if get(machine).is_empty() => None,
        Access::Codes { letter, get, .. } => {
            let codes = get(machine).iter().map(|(code, seconds)| (format!("{letter}{code}"), *seconds));
            Some(Written::Codes(codes.collect()))
        }
    }
}

/// A number that differs from a short decimal by rounding alone, as that decimal: 12000 mm/min
/// must not come back from mm/s as 11999.999999999998.
fn tidy(value: f64) -> f64 {
    let short: f64 = format!("{value:.12e}").parse().expect("a number as printed is a number");
    if (short - value).abs() <= 4.0 * f64::EPSILON * value.abs() { short } else { value }
}

/// The form of the filters' constants: exactly one of these keys must be there.
const TIME_CONSTANTS: [&str; 3] =
    ["interpolator.time_constant_s", "interpolator.max_jerk_mm_s3", "interpolator.time_constants_s"];

/// Keys of how long the chords of arcs are, of which a machine gives one at most.
const CHORDS_OF_ARCS: [&str; 2] = ["interpolator.arc_chord_error_mm", "interpolator.arc_chord_mm"];

/// The same for rapids, which need none of their own.
const TIME_CONSTANTS_OF_RAPIDS: [&str; 2] = ["rapid.time_constant_s", "rapid.max_jerk_mm_s3"];

/// Pairs of keys that are given, of which a machine can only have one.
fn rivals(is_given: &dyn Fn(&str) -> bool) -> Vec<(&'static str, &'static str)> {
    let alternatives: [&[&'static str]; 3] = [&TIME_CONSTANTS, &TIME_CONSTANTS_OF_RAPIDS, &CHORDS_OF_ARCS];
    let pair = |keys: &[&'static str]| {
        let mut given = keys.iter().copied().filter(|key| is_given(key));
        given.next().zip(given.next())
    };
    alternatives.into_iter().filter_map(pair).collect()
}

/// What no single key shows: settings that contradict each other.
fn contradiction(machine: &Machine) -> Option<Fault> {
    if machine.rapid.feedrate == f64::INFINITY && !machine.has_rapids_of_axes() {
        let message = "this key is missing; give it, or axis.x.rapid_mm_min, axis.y.rapid_mm_min and axis.z.rapid_mm_min";
        return Some(Fault::at_key(RAPID, message.to_string()));
    }
    let constants = &machine.interpolator.time_constants;
    match constants {
        TimeConstants::Unequal(list) if list.len() != machine.interpolator.filters => {
            let message = format!(
                "{} time constants for {} filters; give one for each",
                list.len(),
                machine.interpolator.filters
            );
            Some(Fault::at_key("interpolator.time_constants_s", message))
        }
        _ => None,
    }
}
