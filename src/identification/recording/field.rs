//! The field of a column or item, identified by its name.
//!
//! A unit in brackets or at the end is removed from the name first. The rest is divided into words at
//! everything that is not a letter or digit and where capitals begin, so that `act_pos_x`, `ActPosX` and `X
//! actual position [mm]` have the same meaning. The words come from controls, from MTConnect and from the
//! people who write exports, in English and German. Names of Okuma's and Hurco's MTConnect adapters,
//! Heidenhain's scope (`x_s_actual`: s position, v speed) and Siemens' recorders (`DES_POS|1`) are recognised
//! as a whole.
//!
//! Not read: loads, torques, currents, accelerations, speeds of single axes, feed per revolution, rotary
//! axes, machine coordinates in addition to work coordinates. A remark names such columns.

use crate::identification::recording::unit::{Dimension, LogUnit};

/// The side of the servo loop of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoopSide {
    /// The command of the drives.
    Commanded,
    /// The motion of the drives.
    Actual,
    /// The file does not state the side.
    Unstated,
}

/// The meaning of a column or item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChannelField {
    /// Time.
    Time,
    /// A count of samples.
    SampleNumber,
    /// A coordinate; the axis is 0 for X, 1 for Y, 2 for Z.
    Position(LoopSide, usize),
    /// X, Y and Z in one value, separated by blanks.
    Point(LoopSide),
    /// Speed along the path.
    Feed(LoopSide),
    /// Line or block number of the program.
    Line,
    /// Text of the block.
    Block,
    /// Part of the programmed feed.
    FeedOverride,
    /// Part of the rapid feed.
    RapidOverride,
    /// State of the control.
    Status,
    /// Name of the program.
    Program,
    /// Number or name of the tool.
    Tool,
    /// Spindle speed.
    SpindleSpeed,
}

impl ChannelField {
    /// Returns `true` for a field with the position, the speed or the block of the machine.
    pub(super) fn tells_motion(self) -> bool {
        matches!(
            self,
            ChannelField::Position(..)
                | ChannelField::Point(_)
                | ChannelField::Feed(_)
                | ChannelField::Line
                | ChannelField::Block
        )
    }

    /// Returns `true` if values are words rather than numbers.
    pub(super) fn is_text(self) -> bool {
        matches!(
            self,
            ChannelField::Block
                | ChannelField::Status
                | ChannelField::Program
                | ChannelField::Tool
                | ChannelField::Point(_)
        )
    }

    /// Returns the dimension of the field's unit; `None` if it has no unit.
    pub(super) fn dimension(self) -> Option<Dimension> {
        match self {
            ChannelField::Time => Some(Dimension::Time),
            ChannelField::Position(..) | ChannelField::Point(_) => Some(Dimension::Length),
            ChannelField::Feed(_) => Some(Dimension::Feed),
            ChannelField::FeedOverride | ChannelField::RapidOverride => Some(Dimension::Ratio),
            ChannelField::SpindleSpeed => Some(Dimension::Rotation),
            _ => None,
        }
    }
}

/// The name of a column with its field and unit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ChannelLabel {
    /// Name in the file.
    pub(super) name: String,
    /// Field; `None` if the column is not read.
    pub(super) field: Option<ChannelField>,
    /// Stated unit.
    pub(super) unit: Option<LogUnit>,
}

impl ChannelLabel {
    /// Interprets `name`; `stated` is a unit stated elsewhere.
    pub(super) fn read(name: &str, stated: Option<LogUnit>) -> ChannelLabel {
        let name = name.trim().trim_matches('"').trim();
        let (bare, bracketed) = without_brackets(name);
        let mut label = ChannelLabel { name: name.to_owned(), field: None, unit: stated.or(bracketed) };
        // A name may end with a unit, or with a word that only looks like one (`x_s`).
        for (front, unit) in endings(&bare) {
            let field = field_of(&front);
            if field.is_some_and(|field| field.dimension() == Some(unit.dimension)) {
                label.field = field;
                label.unit = label.unit.or(Some(unit));
                return label;
            }
        }
        label.field = field_of(&bare);
        if let (Some(field), Some(unit)) = (label.field, label.unit)
            && field.dimension().is_some_and(|dimension| dimension != unit.dimension)
        {
            // A unit of another dimension excludes the field: an axis in degrees is a rotary axis.
            label.field = None;
        }
        label
    }
}

/// Returns the name without the text in brackets, and the unit in it.
fn without_brackets(name: &str) -> (String, Option<LogUnit>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let (Some(from), Some(to)) = (name.find(open), name.rfind(close))
            && from < to
            && let Some(unit) = LogUnit::parse(&name[from + 1..to])
        {
            return (format!("{} {}", &name[..from], &name[to + 1..]), Some(unit));
        }
    }
    (name.to_owned(), None)
}

/// Returns the ways to cut a unit off the end of `name`, longest unit first.
fn endings(name: &str) -> Vec<(String, LogUnit)> {
    let cuts: Vec<usize> =
        name.char_indices().filter(|(_, c)| matches!(c, '_' | ' ' | '/')).map(|(at, _)| at).collect();
    let last = cuts.len().saturating_sub(3);
    cuts[last..]
        .iter()
        .filter_map(|at| Some((name[..*at].to_owned(), LogUnit::parse(name[*at + 1..].trim())?)))
        .collect()
}

/// Returns the words of `name` in lower case.
fn words(name: &str) -> Vec<String> {
    let letters: Vec<char> = name.chars().collect();
    let mut words = vec![String::new()];
    for (at, letter) in letters.iter().enumerate() {
        if !letter.is_alphanumeric() {
            words.push(String::new());
            continue;
        }
        let before = if at == 0 { None } else { letters.get(at - 1) };
        let after = letters.get(at + 1);
        let begins = letter.is_uppercase()
            && before.is_some_and(|b| {
                b.is_lowercase()
                    || b.is_ascii_digit() && 2 <= at
                    || b.is_uppercase() && after.is_some_and(|a| a.is_lowercase())
            });
        if begins {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut() {
            word.extend(letter.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Words of fields that are not read, anywhere in a name.
const UNREAD_WORDS: &[&str] = &[
    "surface",
    "load",
    "torque",
    "power",
    "force",
    "acc",
    "accel",
    "acceleration",
    "jerk",
    "temp",
    "temperature",
    "error",
    "lag",
    "diff",
    "dev",
    "deviation",
    "editing",
    "runtime",
    "header",
    "count",
    "cutting",
    "parts",
    "part",
    "asset",
    "offset",
    "diameter",
    "radius",
    "life",
    "comment",
    "editor",
    "mode",
    "label",
    "nc",
    "ffw",
    "raw",
];

const COMMANDED_WORDS: &[&str] = &[
    "cmd",
    "command",
    "commanded",
    "com",
    "nom",
    "nominal",
    "soll",
    "set",
    "setpoint",
    "des",
    "desired",
    "prog",
    "programmed",
    "target",
    "ref",
    "reference",
    "setpos",
    "setvelo",
    "frcmd",
    "fcmd",
    "cmdpos",
    "despos",
];
const ACTUAL_WORDS: &[&str] = &[
    "act", "actual", "ist", "enc", "enc1", "enc2", "encoder", "meas", "measured", "fb", "feedback", "actpos",
    "actvelo", "fact", "encpos",
];
const POSITION_WORDS: &[&str] = &[
    "pos",
    "position",
    "abs",
    "work",
    "wcs",
    "axis",
    "axes",
    "coord",
    "coordinate",
    "s",
    "joint",
    "actpos",
    "setpos",
    "pathpos",
    "despos",
    "encpos",
    "cmdpos",
];
const FEED_WORDS: &[&str] = &[
    "feed",
    "feedrate",
    "feedrateact",
    "pathfeedrate",
    "f",
    "fact",
    "fcmd",
    "vorschub",
    "velocity",
    "vel",
    "speed",
    "v",
    "geschwindigkeit",
    "bahngeschwindigkeit",
    "feedrateipo",
];
const OVERRIDE_WORDS: &[&str] =
    &["ovr", "override", "ovrd", "ovw", "ovrt", "fovr", "feedovr", "frapidovr", "rapidovr", "fov"];

/// The words of a name.
struct NameWords(Vec<String>);

impl NameWords {
    /// Returns `true` if the name contains a word of the list.
    fn has(&self, list: &[&str]) -> bool {
        self.0.iter().any(|word| list.contains(&word.as_str()))
    }

    /// Returns `true` if the name is a single word of the list.
    fn only(&self, list: &[&str]) -> bool {
        self.0.len() == 1 && self.has(list)
    }
}

/// Returns the field of `name` without its unit; `None` if it is not read.
fn field_of(name: &str) -> Option<ChannelField> {
    if let Some(field) = vendor(name) {
        return field;
    }
    let mut words = words(name);
    // A leading path or device, such as `p1`, is the owner of the value.
    if 1 < words.len() && is_path(&words[0]) {
        words.remove(0);
    }
    let words = NameWords(words);
    if words.0.is_empty() || words.has(UNREAD_WORDS) {
        return None;
    }
    let side = match (words.has(COMMANDED_WORDS), words.has(ACTUAL_WORDS)) {
        (true, false) => LoopSide::Commanded,
        (false, true) => LoopSide::Actual,
        _ => LoopSide::Unstated,
    };
    if let Some(count) = time_or_count(&words) {
        return Some(count);
    }
    if words.has(OVERRIDE_WORDS) {
        let is_of_spindle = words.has(&["spindle", "s", "s1", "s2", "s6"]);
        let is_of_rapids = words.has(&["rapid", "eilgang", "frapidovr", "rapidovr", "g0"]);
        let field = if is_of_rapids { ChannelField::RapidOverride } else { ChannelField::FeedOverride };
        return (!is_of_spindle).then_some(field);
    }
    if let Some(state) = state_of_program(&words) {
        return Some(state);
    }
    if words.has(&["spindle", "s1speed", "rpm", "spindel", "drehzahl", "s1", "rotaryvelocity"])
        && words.has(&["speed", "rpm", "s1speed", "velocity", "drehzahl", "rotaryvelocity"])
    {
        // A commanded value is not the actual speed of the spindle.
        return (side != LoopSide::Commanded).then_some(ChannelField::SpindleSpeed);
    }
    motion(&words, side)
}

/// Recognises a time, or the number of a sample.
fn time_or_count(words: &NameWords) -> Option<ChannelField> {
    if words.only(&["t", "time", "zeit", "timestamp", "stamp", "datetime", "seconds", "elapsed", "ts"])
        || words.has(&["time", "timestamp", "zeit"])
            && words.0.len() <= 2
            && !words.has(&["spindle", "cycle", "run", "dwell"])
    {
        return Some(ChannelField::Time);
    }
    let is_number = words.only(&["sample", "samples", "index", "nr", "cycle"])
        || words.0 == ["hf", "probe", "counter"]
        || words.has(&["sample"]) && words.has(&["number", "no", "nr"]);
    is_number.then_some(ChannelField::SampleNumber)
}

/// Recognises the active line, block, program or tool, or the state of the control.
fn state_of_program(words: &NameWords) -> Option<ChannelField> {
    const LINE: &[&str] = &[
        "line",
        "lineno",
        "linenumber",
        "zeile",
        "satznummer",
        "blocknumber",
        "blockno",
        "seekoffset",
        "motion_line",
    ];
    let is_line = words.has(LINE)
        || words.has(&["block", "satz", "n", "sequence"]) && words.has(&["number", "no", "nr", "num"])
        || words.only(&["n"]);
    let is_block =
        words.only(&["block", "gcode", "satz", "blocktext"]) || words.has(&["block"]) && words.has(&["text"]);
    let is_status = words.has(&["status", "execution", "state", "exec"])
        && !words.has(&["door", "coolant", "chuck", "tool", "spindle"]);
    let is_program = words.has(&["program", "programname", "prog"])
        && (words.0.len() == 1 || words.has(&["name", "running", "active"]));
    let is_tool = words.has(&["tool", "toolnumber", "toolid", "werkzeug", "toolno"]);
    let fields = [
        (is_line, ChannelField::Line),
        (is_block, ChannelField::Block),
        (is_status, ChannelField::Status),
        (is_program, ChannelField::Program),
        (is_tool, ChannelField::Tool),
    ];
    fields.into_iter().find(|(is_it, _)| *is_it).map(|(_, field)| field)
}

/// Recognises a position or a feedrate.
fn motion(words: &NameWords, side: LoopSide) -> Option<ChannelField> {
    let axis = words.0.iter().find_map(|word| axis(word));
    let is_feed = words.has(FEED_WORDS) && !words.has(&["s", "pos", "position"]);
    match axis {
        Some(_) if is_feed || words.has(&["current", "strom"]) => None,
        Some(axis) if words.0.len() == 1 || words.has(POSITION_WORDS) || side != LoopSide::Unstated => {
            Some(ChannelField::Position(side, axis))
        }
        Some(_) => None,
        None if is_feed && !words.has(&["rev", "frcmd", "fract"]) => Some(ChannelField::Feed(side)),
        None if words.has(&["pathpos", "pathposition"])
            || words.has(&["path"]) && words.has(&["pos", "position"]) =>
        {
            Some(ChannelField::Point(side))
        }
        None => None,
    }
}

/// Returns the axis of X, Y or Z, alone or numbered: X, X1, MX1.
fn axis(word: &str) -> Option<usize> {
    let bare = word.strip_prefix('m').filter(|rest| 2 <= rest.len()).unwrap_or(word);
    match bare {
        "x" | "x1" | "xpos" | "posx" => Some(0),
        "y" | "y1" | "ypos" | "posy" => Some(1),
        "z" | "z1" | "zpos" | "posz" => Some(2),
        _ => None,
    }
}

/// Returns `true` for the number of a path or channel in front of a name.
fn is_path(word: &str) -> bool {
    let rest =
        word.strip_prefix("path").or_else(|| word.strip_prefix('p')).or_else(|| word.strip_prefix("ch"));
    rest.is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_digit()))
}

/// Recognises the names of vendors that do not follow the rules of words; `Some(None)` is known and not read.
fn vendor(name: &str) -> Option<Option<ChannelField>> {
    let lower = name.trim().to_lowercase();
    // Okuma's adapter: axis, turret, `act`, `w`ork or `m`achine coordinates.
    if let Some(front) = lower.strip_suffix("actw")
        && (1..=3).contains(&front.len())
    {
        // `YI1` is the Y axis made of the slanted X and Y; turret 4 belongs to another path.
        return Some(
            axis(&front.replace('i', "")).map(|axis| ChannelField::Position(LoopSide::Actual, axis)),
        );
    }
    if lower.ends_with("actm") && lower.len() <= 7 {
        return Some(None);
    }
    // Adapters put the path, `p` or `p1`, before the item, in one word.
    let bare = lower
        .strip_prefix('p')
        .map_or(lower.as_str(), |rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()));
    match bare {
        "lpathpos" => return Some(Some(ChannelField::Point(LoopSide::Actual))),
        "fact" => return Some(Some(ChannelField::Feed(LoopSide::Actual))),
        "fovr" => return Some(Some(ChannelField::FeedOverride)),
        "linenumber" | "blocknumber" => return Some(Some(ChannelField::Line)),
        "block" => return Some(Some(ChannelField::Block)),
        "execution" => return Some(Some(ChannelField::Status)),
        "program" if lower != "program" => return Some(Some(ChannelField::Program)),
        "currenttool" => return Some(Some(ChannelField::Tool)),
        // Feed per revolution, and a command whose unit follows G94 and G95.
        "fract" | "frcmd" | "fcmd" | "toolassetid" => return Some(None),
        _ => {}
    }
    if matches!(bare, "xact" | "xabs" | "yact" | "yabs" | "zact" | "zabs") {
        return Some(axis(&bare[..1]).map(|axis| ChannelField::Position(LoopSide::Actual, axis)));
    }
    if matches!(bare, "xcom" | "ycom" | "zcom") {
        return Some(axis(&bare[..1]).map(|axis| ChannelField::Position(LoopSide::Commanded, axis)));
    }
    // Siemens' data recorder: signal and number of the axis.
    let (signal, number) = lower.split_once('|')?;
    let axis = number
        .trim()
        .parse::<usize>()
        .ok()
        .filter(|number| (1..=3).contains(number))
        .map(|number| number - 1);
    match signal.trim() {
        "des_pos" => Some(axis.map(|axis| ChannelField::Position(LoopSide::Commanded, axis))),
        "enc_pos" | "enc1_pos" | "enc2_pos" => {
            Some(axis.map(|axis| ChannelField::Position(LoopSide::Actual, axis)))
        }
        _ => Some(None),
    }
}

/// Returns `true` if `names` are those of a SINUMERIK recorder, whose table counts position-control cycles.
pub(super) fn is_siemens_recorder(names: &[&str]) -> bool {
    let counts = |name: &&str| matches!(*name, "CYCLE" | "HFProbeCounter");
    let tells = |name: &&str| {
        *name == "SeekOffset" || name.split('|').next().is_some_and(|name| name.ends_with("_POS"))
    };
    names.iter().any(counts) && names.iter().any(tells)
}

/// Returns `true` if names without a time are those of Heidenhain's scope: an axis and `s`, `v`, `a` or `j`
/// with `actual`, `nominal` or `diff`.
pub(super) fn is_scope(names: &[&str]) -> bool {
    names.iter().all(|name| {
        let words = words(name);
        let signal = |word: &String| matches!(word.as_str(), "s" | "v" | "a" | "j" | "i" | "ipodbg" | "f");
        let side =
            |word: &String| matches!(word.as_str(), "actual" | "act" | "nominal" | "nom" | "noml" | "diff");
        words.iter().any(signal) && (words.iter().any(side) || words.len() == 1)
    })
}
