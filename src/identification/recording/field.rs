//! What a column or item is, told by its name.
//!
//! A name is cut into words at everything that is not a letter or digit and where capitals begin,
//! so that `act_pos_x`, `ActPosX` and `X actual position [mm]` are the same words; a unit in
//! brackets or at the end is taken off first. The words are those of controls, of MTConnect and of
//! the people who write exports, in English and German. Names of Okuma's and Hurco's MTConnect
//! adapters, Heidenhain's scope (`x_s_actual`: s position, v speed) and Siemens' recorders
//! (`DES_POS|1`) are known as such.
//!
//! Not read, by intent: loads, torques, currents, accelerations, speeds of single axes, feed per
//! revolution, rotary axes, machine coordinates beside work coordinates. They are named in a remark.

use crate::identification::recording::unit::{Dimension, Unit};

/// Which side of the servo loop a value is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// What the drives are told.
    Commanded,
    /// What they do.
    Actual,
    /// The file does not say.
    Unstated,
}

/// What a column or item tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Field {
    /// When.
    Time,
    /// A count of samples.
    SampleNumber,
    /// A coordinate; the axis is 0 for X, 1 for Y, 2 for Z.
    Position(Side, usize),
    /// X, Y and Z in one value, separated by blanks.
    Point(Side),
    /// Speed along the path.
    Feed(Side),
    /// Line or block number of the program.
    Line,
    /// Text of the block.
    Block,
    /// Part of the programmed feed.
    FeedOverride,
    /// Part of the rapid feed.
    RapidOverride,
    /// What the control is doing.
    Status,
    /// Name of the program.
    Program,
    /// Number or name of the tool.
    Tool,
    /// Spindle speed.
    SpindleSpeed,
}

impl Field {
    /// Whether it tells where the machine is, how fast it moves or which block it runs.
    pub(super) fn tells_motion(self) -> bool {
        matches!(self, Field::Position(..) | Field::Point(_) | Field::Feed(_) | Field::Line | Field::Block)
    }

    /// Whether values are words rather than numbers.
    pub(super) fn is_text(self) -> bool {
        matches!(self, Field::Block | Field::Status | Field::Program | Field::Tool | Field::Point(_))
    }

    /// What its unit must measure, if it has one.
    pub(super) fn dimension(self) -> Option<Dimension> {
        match self {
            Field::Time => Some(Dimension::Time),
            Field::Position(..) | Field::Point(_) => Some(Dimension::Length),
            Field::Feed(_) => Some(Dimension::Feed),
            Field::FeedOverride | Field::RapidOverride => Some(Dimension::Ratio),
            Field::SpindleSpeed => Some(Dimension::Rotation),
            _ => None,
        }
    }
}

/// A column's name, understood.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Label {
    /// As in the file.
    pub(super) name: String,
    /// What it tells; none where nothing is made of it.
    pub(super) field: Option<Field>,
    /// The unit stated.
    pub(super) unit: Option<Unit>,
}

impl Label {
    /// Understands `name`, with a unit stated elsewhere if `stated`.
    pub(super) fn read(name: &str, stated: Option<Unit>) -> Label {
        let name = name.trim().trim_matches('"').trim();
        let (bare, bracketed) = without_brackets(name);
        let mut label = Label { name: name.to_owned(), field: None, unit: stated.or(bracketed) };
        // A unit may end the name, but so may a word that only looks like one (`x_s`).
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
            // An axis in degrees is a rotary axis, a line number has no unit to contradict.
            label.field = None;
        }
        label
    }
}

/// The name without what stands in brackets, and the unit that stood there.
fn without_brackets(name: &str) -> (String, Option<Unit>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let (Some(from), Some(to)) = (name.find(open), name.rfind(close))
            && from < to
            && let Some(unit) = Unit::parse(&name[from + 1..to])
        {
            return (format!("{} {}", &name[..from], &name[to + 1..]), Some(unit));
        }
    }
    (name.to_owned(), None)
}

/// Ways to cut a unit off the end of `name`, longest unit first.
fn endings(name: &str) -> Vec<(String, Unit)> {
    let cuts: Vec<usize> =
        name.char_indices().filter(|(_, c)| matches!(c, '_' | ' ' | '/')).map(|(at, _)| at).collect();
    let last = cuts.len().saturating_sub(3);
    cuts[last..]
        .iter()
        .filter_map(|at| Some((name[..*at].to_owned(), Unit::parse(name[*at + 1..].trim())?)))
        .collect()
}

/// Words of `name` in lower case.
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

/// Words that tell of something not read, wherever they stand.
const NOT_READ: &[&str] = &[
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

const COMMANDED: &[&str] = &[
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
const ACTUAL: &[&str] = &[
    "act", "actual", "ist", "enc", "enc1", "enc2", "encoder", "meas", "measured", "fb", "feedback", "actpos",
    "actvelo", "fact", "encpos",
];
const POSITION: &[&str] = &[
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
const FEED: &[&str] = &[
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
const OVERRIDE: &[&str] =
    &["ovr", "override", "ovrd", "ovw", "ovrt", "fovr", "feedovr", "frapidovr", "rapidovr", "fov"];

/// What `name` tells, its unit taken off.
fn field_of(name: &str) -> Option<Field> {
    if let Some(field) = vendor(name) {
        return field;
    }
    let mut words = words(name);
    // A path or device in front, such as `p1`, says whose value it is, not what.
    if 1 < words.len() && is_path(&words[0]) {
        words.remove(0);
    }
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    let only = |list: &[&str]| words.len() == 1 && list.contains(&words[0].as_str());
    if words.is_empty() || has(NOT_READ) {
        return None;
    }
    if only(&["t", "time", "zeit", "timestamp", "stamp", "datetime", "seconds", "elapsed", "ts"])
        || has(&["time", "timestamp", "zeit"])
            && words.len() <= 2
            && !has(&["spindle", "cycle", "run", "dwell"])
    {
        return Some(Field::Time);
    }
    if only(&["sample", "samples", "index", "nr", "cycle"])
        || words == ["hf", "probe", "counter"]
        || has(&["sample"]) && has(&["number", "no", "nr"])
    {
        return Some(Field::SampleNumber);
    }
    let side = match (has(COMMANDED), has(ACTUAL)) {
        (true, false) => Side::Commanded,
        (false, true) => Side::Actual,
        _ => Side::Unstated,
    };
    if has(OVERRIDE) {
        return match () {
            _ if has(&["spindle", "s", "s1", "s2", "s6"]) => None,
            _ if has(&["rapid", "eilgang", "frapidovr", "rapidovr", "g0"]) => Some(Field::RapidOverride),
            _ => Some(Field::FeedOverride),
        };
    }
    if has(&[
        "line",
        "lineno",
        "linenumber",
        "zeile",
        "satznummer",
        "blocknumber",
        "blockno",
        "seekoffset",
        "motion_line",
    ]) || has(&["block", "satz", "n", "sequence"]) && has(&["number", "no", "nr", "num"])
        || only(&["n"])
    {
        return Some(Field::Line);
    }
    if only(&["block", "gcode", "satz", "blocktext"]) || has(&["block"]) && has(&["text"]) {
        return Some(Field::Block);
    }
    if has(&["status", "execution", "state", "exec"])
        && !has(&["door", "coolant", "chuck", "tool", "spindle"])
    {
        return Some(Field::Status);
    }
    if has(&["program", "programname", "prog"]) && (words.len() == 1 || has(&["name", "running", "active"])) {
        return Some(Field::Program);
    }
    if has(&["tool", "toolnumber", "toolid", "werkzeug", "toolno"]) {
        return Some(Field::Tool);
    }
    if has(&["spindle", "s1speed", "rpm", "spindel", "drehzahl", "s1", "rotaryvelocity"])
        && has(&["speed", "rpm", "s1speed", "velocity", "drehzahl", "rotaryvelocity"])
    {
        // What was asked for is no speed of the spindle.
        return (side != Side::Commanded).then_some(Field::SpindleSpeed);
    }
    let axis = words.iter().find_map(|word| axis(word));
    let moves = has(FEED) && !has(&["s", "pos", "position"]);
    match axis {
        Some(_) if moves || has(&["current", "strom"]) => None,
        Some(axis) if words.len() == 1 || has(POSITION) || side != Side::Unstated => {
            Some(Field::Position(side, axis))
        }
        Some(_) => None,
        None if moves && !has(&["rev", "frcmd", "fract"]) => Some(Field::Feed(side)),
        None if has(&["pathpos", "pathposition"]) || has(&["path"]) && has(&["pos", "position"]) => {
            Some(Field::Point(side))
        }
        None => None,
    }
}

/// X, Y or Z, alone or numbered: X, X1, MX1.
fn axis(word: &str) -> Option<usize> {
    let bare = word.strip_prefix('m').filter(|rest| 2 <= rest.len()).unwrap_or(word);
    match bare {
        "x" | "x1" | "xpos" | "posx" => Some(0),
        "y" | "y1" | "ypos" | "posy" => Some(1),
        "z" | "z1" | "zpos" | "posz" => Some(2),
        _ => None,
    }
}

/// A path's or channel's number in front of a name.
fn is_path(word: &str) -> bool {
    let rest =
        word.strip_prefix("path").or_else(|| word.strip_prefix('p')).or_else(|| word.strip_prefix("ch"));
    rest.is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_digit()))
}

/// Names whose makers do not follow the rules of words; `Some(None)` is known and not read.
fn vendor(name: &str) -> Option<Option<Field>> {
    let lower = name.trim().to_lowercase();
    // Okuma's adapter: axis, turret, `act`, `w`ork or `m`achine coordinates.
    if let Some(front) = lower.strip_suffix("actw")
        && (1..=3).contains(&front.len())
    {
        // `YI1` is the Y axis made of the slanted X and Y; turret 4 is another path's.
        return Some(axis(&front.replace('i', "")).map(|axis| Field::Position(Side::Actual, axis)));
    }
    if lower.ends_with("actm") && lower.len() <= 7 {
        return Some(None);
    }
    // Adapters name what belongs to a path `p` or `p1`, in one word with the item.
    let bare = lower
        .strip_prefix('p')
        .map_or(lower.as_str(), |rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()));
    match bare {
        "lpathpos" => return Some(Some(Field::Point(Side::Actual))),
        "fact" => return Some(Some(Field::Feed(Side::Actual))),
        "fovr" => return Some(Some(Field::FeedOverride)),
        "linenumber" | "blocknumber" => return Some(Some(Field::Line)),
        "block" => return Some(Some(Field::Block)),
        "execution" => return Some(Some(Field::Status)),
        "program" if lower != "program" => return Some(Some(Field::Program)),
        "currenttool" => return Some(Some(Field::Tool)),
        // Feed per revolution, and a command whose unit follows G94 and G95.
        "fract" | "frcmd" | "fcmd" | "toolassetid" => return Some(None),
        _ => {}
    }
    if matches!(bare, "xact" | "xabs" | "yact" | "yabs" | "zact" | "zabs") {
        return Some(axis(&bare[..1]).map(|axis| Field::Position(Side::Actual, axis)));
    }
    if matches!(bare, "xcom" | "ycom" | "zcom") {
        return Some(axis(&bare[..1]).map(|axis| Field::Position(Side::Commanded, axis)));
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
        "des_pos" => Some(axis.map(|axis| Field::Position(Side::Commanded, axis))),
        "enc_pos" | "enc1_pos" | "enc2_pos" => Some(axis.map(|axis| Field::Position(Side::Actual, axis))),
        _ => Some(None),
    }
}

/// Whether `names` are those of a SINUMERIK recorder, whose table counts position-control cycles.
pub(super) fn is_siemens_recorder(names: &[&str]) -> bool {
    let counts = |name: &&str| matches!(*name, "CYCLE" | "HFProbeCounter");
    let tells = |name: &&str| {
        *name == "SeekOffset" || name.split('|').next().is_some_and(|name| name.ends_with("_POS"))
    };
    names.iter().any(counts) && names.iter().any(tells)
}

/// Whether names without a time are those of Heidenhain's scope: an axis and `s`, `v`, `a` or `j`
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
