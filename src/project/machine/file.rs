//! The machine file: TOML with units in the names of keys; an unknown key is an error.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::machine::{Machine, PARAMETERS, Parameter};
use crate::project::TextFault;
use crate::project::machine::written::{
    RAPID_KEY, REQUIRED_KEYS, TIME_CONSTANT_KEYS, WrittenValue, contradiction, known_parameter, position,
    rivals, set, written,
};
use crate::simulation::ordered::sort_by_number;

/// Returns the machine that the text of a machine file describes.
///
/// # Errors
///
/// Returns the first fault of the text, with its place.
///
/// # Examples
///
/// ```
/// use truefeed::project::machine_from_toml;
///
/// let text = "name = 'a mill'\n[interpolator]\nfilters = 3\ntime_constant_s = 0.02\ncontour_tolerance_mm = 0.01\n\
///             [rapid]\nfeed_mm_min = 12000\n[times]\ntool_change_s = 4";
/// assert_eq!(machine_from_toml(text).expect("it is complete").rapid.feedrate, 200.0, "mm/s");
/// let fault = machine_from_toml(&text.replace("filters", "filter")).unwrap_err();
/// assert_eq!(fault.place, Some((3, 1)), "line and column");
/// ```
pub fn machine_from_toml(text: &str) -> Result<Machine, TextFault> {
    let at = |span: Range<usize>| Some(place(text, span.start));
    let table = DeTable::parse(text).map_err(|error| TextFault {
        place: error.span().and_then(at),
        key: None,
        message: error.message().replace('\n', " "),
    })?;
    let mut entries = Vec::new();
    collect(table.get_ref(), "", &mut entries).map_err(|(span, key, message)| TextFault {
        place: at(span),
        key: Some(key),
        message,
    })?;
    sort_by_number(&mut entries, |(key, ..)| position(key) as f64);
    let mut machine = Machine::default();
    machine.rapid.feedrate = f64::INFINITY;
    for (key, span, value) in &entries {
        set(&mut machine, key, value.clone())
            .map_err(|fault| TextFault { place: at(span.clone()), ..fault })?;
    }
    let is_given = |key: &str| entries.iter().any(|(known, ..)| known == key);
    let missing = |key: &str| TextFault {
        place: None,
        key: Some(key.to_string()),
        message: "this key is missing".to_string(),
    };
    if let Some(key) = REQUIRED_KEYS.iter().find(|key| !is_given(key)) {
        return Err(missing(key));
    }
    if !TIME_CONSTANT_KEYS.iter().any(|key| is_given(key)) {
        return Err(missing(TIME_CONSTANT_KEYS[0]));
    }
    if let Some((first, second)) = rivals(&is_given).first() {
        return Err(TextFault::at_key(second, format!("give either this or {first}")));
    }
    contradiction(&machine).map_or(Ok(machine), Err)
}

/// Returns the machine file of a machine: the required values, and those that are not neutral.
pub fn toml_from_machine(machine: &Machine) -> String {
    let neutral = Machine::default();
    let mut text = String::new();
    let mut table = "";
    for row in by_table() {
        let Some(value) = written(machine, row) else { continue };
        let needed = row.key == "name"
            || row.key == RAPID_KEY
            || REQUIRED_KEYS.contains(&row.key)
            || TIME_CONSTANT_KEYS.contains(&row.key);
        if !needed && written(&neutral, row).as_ref() == Some(&value) {
            continue;
        }
        if let WrittenValue::Tools(tools) = &value {
            for (number, diameter) in tools {
                text += &format!("\n[tools.{number}]\n{DIAMETER_KEY} = {}\n", toml::Value::Float(*diameter));
            }
            table = row.key;
            continue;
        }
        let (own_table, key) = row.key.rsplit_once('.').unwrap_or(("", row.key));
        if own_table != table {
            text += &format!("\n[{own_table}]\n");
            table = own_table;
        }
        text += &format!("{key} = {}\n", toml_value(&value));
    }
    text
}

/// Returns all rows grouped by table, in the order of their first rows: a file names a table only once.
fn by_table() -> Vec<&'static Parameter> {
    let table = |row: &Parameter| row.key.rsplit_once('.').map_or(row.key, |(table, _)| table);
    let first = |row: &Parameter| PARAMETERS.iter().take_while(|other| table(other) != table(row)).count();
    let mut rows: Vec<&Parameter> = PARAMETERS.iter().collect();
    sort_by_number(&mut rows, |row| first(row) as f64);
    rows
}

/// Returns all parameters that the simulation reads, as text for comparison: machines with equal texts have
/// the same motion, even if their names and costs differ.
pub fn motion_of_machine(machine: &Machine) -> String {
    let neutral = Machine::default();
    let machine = Machine {
        name: neutral.name,
        provenance: neutral.provenance,
        cycle_time_error: neutral.cycle_time_error,
        unexplained_time: neutral.unexplained_time,
        form_error: neutral.form_error,
        typical_form_error: neutral.typical_form_error,
        calibrated_at: neutral.calibrated_at,
        calibrated_on: neutral.calibrated_on,
        rates: neutral.rates,
        ..machine.clone()
    };
    PARAMETERS.iter().map(|row| format!("{:?} ", written(&machine, row))).collect()
}

fn toml_value(value: &WrittenValue) -> String {
    let number = |value: &f64| match *value {
        whole if whole.fract() == 0.0 && whole.abs() < 1e15 => format!("{whole:.0}"),
        other => toml::Value::Float(other).to_string(),
    };
    match value {
        WrittenValue::Number(value) => number(value),
        WrittenValue::Text(text) => toml::Value::String(text.clone()).to_string(),
        WrittenValue::Flag(value) => value.to_string(),
        WrittenValue::List(values) => {
            format!("[{}]", values.iter().map(number).collect::<Vec<_>>().join(", "))
        }
        WrittenValue::Codes(codes) => {
            let entries = codes.iter().map(|(code, seconds)| format!("{code} = {}", number(seconds)));
            format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
        }
        WrittenValue::Tools(_) => unreachable!("tools are written as tables of their own"),
        WrittenValue::Empty => unreachable!("an empty value is never read from a machine"),
    }
}

/// Returns line and column, 1-based, of a byte of the text.
pub(in crate::project) fn place(text: &str, byte: usize) -> (usize, usize) {
    let before = &text[..text.floor_char_boundary(byte)];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

type FileEntry = (String, Range<usize>, WrittenValue);

/// Key of a tool's diameter.
const DIAMETER_KEY: &str = "diameter_mm";

/// Reads the tool table, `[tools.5]` and so on.
fn tools(table: &DeTable) -> Result<WrittenValue, (Range<usize>, String, String)> {
    let mut tools = Vec::new();
    for (number, tool) in table {
        let key = format!("tools.{}", number.get_ref());
        let DeValue::Table(tool) = tool.get_ref() else {
            let message = format!("expected a table, [{key}], with {DIAMETER_KEY}");
            return Err((tool.span(), key, message));
        };
        for (name, value) in tool {
            let key = format!("{key}.{}", name.get_ref());
            if name.get_ref() != DIAMETER_KEY {
                let message = format!(
                    "unknown key; the nearest known one is tools.{}.{DIAMETER_KEY}",
                    number.get_ref()
                );
                return Err((name.span(), key, message));
            }
            let diameter = self::number(value).map_err(|message| (value.span(), key, message.to_string()))?;
            tools.push((number.get_ref().to_string(), diameter));
        }
    }
    Ok(WrittenValue::Tools(tools))
}

/// Collects all keys of a table with dotted names; tables that are values remain whole.
fn collect(
    table: &DeTable,
    prefix: &str,
    entries: &mut Vec<FileEntry>,
) -> Result<(), (Range<usize>, String, String)> {
    for (name, value) in table {
        let key = if prefix.is_empty() {
            name.get_ref().to_string()
        } else {
            format!("{prefix}.{}", name.get_ref())
        };
        let is_prefix =
            PARAMETERS.iter().any(|row| row.key.strip_prefix(&key).is_some_and(|rest| rest.starts_with('.')));
        match value.get_ref() {
            DeValue::Table(inner) if key == "tools" => entries.push((key, value.span(), tools(inner)?)),
            DeValue::Table(inner) if is_prefix => collect(inner, &key, entries)?,
            _ => {
                known_parameter(&key).map_err(|fault| (name.span(), key.clone(), fault.message))?;
                let written = value_as_written(value)
                    .map_err(|message| (value.span(), key.clone(), message.to_string()))?;
                entries.push((key, value.span(), written));
            }
        }
    }
    Ok(())
}

fn value_as_written(value: &Spanned<DeValue>) -> Result<WrittenValue, &'static str> {
    match value.get_ref() {
        DeValue::String(text) => Ok(WrittenValue::Text(text.to_string())),
        DeValue::Boolean(flag) => Ok(WrittenValue::Flag(*flag)),
        DeValue::Integer(_) | DeValue::Float(_) => number(value).map(WrittenValue::Number),
        DeValue::Array(values) => values.iter().map(number).collect::<Result<_, _>>().map(WrittenValue::List),
        DeValue::Table(table) => {
            let codes =
                table.iter().map(|(code, seconds)| Ok((code.get_ref().to_string(), number(seconds)?)));
            codes.collect::<Result<_, _>>().map(WrittenValue::Codes)
        }
        DeValue::Datetime(_) => Err("a date is not expected here"),
    }
}

fn number(value: &Spanned<DeValue>) -> Result<f64, &'static str> {
    let number = match value.get_ref() {
        DeValue::Integer(integer) => integer.as_str().parse().ok(),
        DeValue::Float(float) => float.as_str().parse().ok(),
        _ => None,
    };
    number.ok_or("expected a decimal number")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{SpindleTimes, StructuralMode, TimeConstants, Tool};

    const SMALL: &str = r#"
name = "DMG Mori eVo 40, TNC640"
[interpolator]
filters = 3
time_constant_s = 0.0255
contour_tolerance_mm = 0.010
corner_mode = "paper"
[rapid]
feed_mm_min = 12000
[times]
tool_change_s = 4.0
"#;

    fn fault(text: &str) -> String {
        machine_from_toml(text).expect_err("the text is wrong").to_string()
    }

    #[test]
    fn the_contracts_example_is_read() {
        let machine = machine_from_toml(SMALL).expect("right");
        assert_eq!(machine.rapid.feedrate, 200.0);
        assert_eq!(machine.interpolator.time_constants, TimeConstants::Equal(0.0255));
        assert_eq!(machine, Machine { name: "DMG Mori eVo 40, TNC640".to_string(), ..Machine::default() });
    }

    #[test]
    fn a_machine_survives_being_written_and_read() {
        let mut machine = machine_from_toml(SMALL).expect("right");
        assert_eq!(machine_from_toml(&toml_from_machine(&machine)), Ok(machine.clone()));
        machine.interpolator.filters = 2;
        machine.interpolator.time_constants = TimeConstants::Unequal(vec![0.03, 0.0123456789]);
        machine.axes[1].acceleration = 1234.5;
        machine.axes[2].home = Some(-17.25);
        machine.axes[2].mode = Some(StructuralMode { frequency: 11.0, damping: 0.05 });
        machine.rapid.exact_stop = true;
        machine.rapid.time_constants = Some(TimeConstants::Equal(0.05));
        machine.interpolator.exact_stop_angle = 35f64.to_radians();
        machine.times.m_codes = [(3, 4.0), (8, 2.5)].into();
        machine.times.tools = [(12, 9.0)].into();
        machine.times.spindle =
            SpindleTimes { start: Some(1.5), stop: None, ramp: 2.5e-4, exponent: Some(2.0) };
        machine.times.spindle_awaited_by = vec![8, 30];
        machine.times.pallet_words = vec![60, 150];
        machine.times.takes_optional_stop = true;
        machine.tools = [(5, Tool { diameter: 10.0 }), (12, Tool { diameter: 6.35 })].into();
        machine.name = "a \"quoted\" name\nin two lines".to_string();
        assert_eq!(machine_from_toml(&toml_from_machine(&machine)), Ok(machine));
    }

    #[test]
    fn rapids_of_all_axes_take_the_place_of_the_rapid_along_the_path() {
        let axes = |letters: &str| {
            let tables = letters.chars().map(|axis| format!("\n[axis.{axis}]\nrapid_mm_min = 9000\n"));
            SMALL.replace("feed_mm_min = 12000", "") + &tables.collect::<String>()
        };
        let machine = machine_from_toml(&axes("xyz")).expect("each axis has a rapid");
        assert_eq!((machine.rapid.feedrate, machine.axes[2].rapid), (f64::INFINITY, 150.0));
        assert_eq!(machine_from_toml(&toml_from_machine(&machine)), Ok(machine));
        assert!(fault(&axes("xz")).starts_with("rapid.feed_mm_min: this key is missing; give it, or axis.x"));
    }

    #[test]
    fn a_table_is_written_once() {
        let mut machine = machine_from_toml(SMALL).expect("right");
        machine.interpolator.arc_tolerance = Some(0.03);
        machine.rapid.exact_stop = true;
        machine.rapid.positioning_jerk = 90e3;
        machine.path.jerk = 12e3;
        machine.path.centripetal_acceleration = 500.0;
        let text = toml_from_machine(&machine);
        assert_eq!(text.matches("[interpolator]").count(), 1, "{text}");
        assert_eq!(machine_from_toml(&text), Ok(machine), "{text}");
    }

    #[test]
    fn name_and_rates_do_not_change_the_motion_and_the_rest_does() {
        let machine = machine_from_toml(SMALL).expect("right");
        let motion = motion_of_machine(&machine);
        let with = |line: &str| {
            let text = format!("{}\n{line}", SMALL.replace("DMG Mori eVo 40, TNC640", "another"));
            motion_of_machine(&machine_from_toml(&text).expect("right"))
        };
        assert_eq!(with("[rates]\nhourly = 90"), motion);
        assert_ne!(with("[axis.y]\nacceleration_mm_s2 = 3000"), motion);
        assert_ne!(with("m_code_s = 1"), motion);
    }

    #[test]
    fn faults_say_where_and_what() {
        assert_eq!(
            fault(&SMALL.replace("filters = 3", "filter = 3")),
            "line 4, column 1: interpolator.filter: unknown key; the nearest known one is interpolator.filters"
        );
        assert_eq!(
            fault(&SMALL.replace("filters = 3", "filters = 5")),
            "line 4, column 11: interpolator.filters: 5 is outside 1 to 4"
        );
        assert_eq!(
            fault(&SMALL.replace("filters = 3", "filters = 2.5")),
            "line 4, column 11: interpolator.filters: expected a whole number from 1 to 4"
        );
        assert_eq!(
            fault(&SMALL.replace("0.0255", "\"fast\"")),
            "line 5, column 19: interpolator.time_constant_s: expected a number in s"
        );
        assert_eq!(
            fault(&SMALL.replace("0.0255", "nan")),
            "line 5, column 19: interpolator.time_constant_s: NaN is outside 0.00001 to 2 s"
        );
        assert_eq!(
            fault(&SMALL.replace("feed_mm_min = 12000", "")),
            "rapid.feed_mm_min: this key is missing; give it, or axis.x.rapid_mm_min, axis.y.rapid_mm_min and axis.z.rapid_mm_min"
        );
        assert_eq!(
            fault(&SMALL.replace("[rapid]", "max_jerk_mm_s3 = 50000\n[rapid]")),
            "interpolator.max_jerk_mm_s3: give either this or interpolator.time_constant_s"
        );
        assert_eq!(
            fault(&SMALL.replace("time_constant_s = 0.0255", "time_constants_s = [0.02, 0.01]")),
            "interpolator.time_constants_s: 2 time constants for 3 filters; give one for each"
        );
        assert_eq!(
            fault(&SMALL.replace("\"paper\"", "\"fast\"")),
            "line 7, column 15: interpolator.corner_mode: expected one of: paper, guaranteed"
        );
        assert_eq!(
            fault(&SMALL.replace("[times]", "time_constant_s = 0.05\nmax_jerk_mm_s3 = 50000\n[times]")),
            "rapid.max_jerk_mm_s3: give either this or rapid.time_constant_s"
        );
        let tool = |line: &str| fault(&format!("{SMALL}[tools.5]\n{line}"));
        assert_eq!(
            tool("diameter = 10.0"),
            "line 13, column 1: tools.5.diameter: unknown key; the nearest known one is tools.5.diameter_mm"
        );
        assert_eq!(
            tool("diameter_mm = 1e9"),
            "line 12, column 2: tools: 1000000000 is outside -1000 to 1000 mm"
        );
        assert_eq!(
            fault(&format!("{SMALL}[tools]\n5 = 10.0")),
            "line 13, column 5: tools.5: expected a table, [tools.5], with diameter_mm"
        );
        assert_eq!(
            fault(&format!("{SMALL}[tools.mill]\ndiameter_mm = 10.0")),
            "line 12, column 2: tools: mill is not a tool number such as 5"
        );
        assert!(fault("name = ").starts_with("line 1, column 8: "));
        assert!(
            fault(&SMALL.replace("tool_change_s = 4.0", "tool_change_s = 4.0\nm_codes = { X3 = 1.0 }"))
                .contains("X3 is not a word such as M3")
        );
        let with = |line: &str| {
            fault(&SMALL.replace("tool_change_s = 4.0", &format!("tool_change_s = 4.0\n{line}")))
        };
        assert!(with("tools = { M3 = 1.0 }").ends_with("times.tools: M3 is not a word such as T3"));
        assert!(with("clamp_words = [10, 10.5]").ends_with("expected whole numbers from 0 to 9999"));
        assert!(with("pallet_words = []").ends_with("expected one to 20 numbers"));
        assert!(with("pallet_words = 60").ends_with("expected a list of numbers, such as [10, 11]"));
    }

    #[test]
    fn numbers_come_back_as_they_were_written() {
        for mm_per_min in [12000.0, 11999.99, 1.0, 763.0, 30_000.5] {
            let machine =
                machine_from_toml(&SMALL.replace("12000", &format!("{mm_per_min}"))).expect("right");
            assert!(
                toml_from_machine(&machine).contains(&format!("feed_mm_min = {mm_per_min}\n")),
                "{mm_per_min}"
            );
        }
    }
}
