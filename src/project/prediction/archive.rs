//! Predictions of many programs: one JSON object per line, identified by path and key.
//!
//! ```text
//! {"path": "parts/a.nc", "key": "0f3a…", <what predict --json prints>}
//! {"path": "parts/b.nc", "key": "77c1…", "error": "why there is no prediction"}
//! ```
//!
//! The key is a hash of everything that the line depends on: the bytes of the program, the machine, the
//! tolerances, the dialect, the arc centres and the version of the build. A line is current while its key
//! matches; an unreadable program has no key, and its line is never current.

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use crate::machine::Machine;
use crate::project::{Prediction, VERSION, toml_from_machine};
use crate::simulation::gcode::{ArcCenters, Dialect, Options};

/// A line of an archive.
#[derive(Clone, Debug, Serialize)]
pub struct ArchiveLine<'a> {
    /// Path of the program as given, or as found in a folder.
    pub path: &'a str,
    /// Key of the program and its request.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub key: Option<&'a str>,
    /// Prediction.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub prediction: Option<&'a Prediction>,
    /// Reason for a missing prediction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<&'a str>,
}

impl ArchiveLine<'_> {
    /// Returns the line as JSON text, with its line ending.
    pub fn to_line(&self) -> String {
        let mut line = serde_json::to_string(self).expect("text and finite numbers have a JSON form");
        line.push('\n');
        line
    }
}

/// The program of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineOwner {
    /// Path of the program.
    pub path: String,
    /// Key of the program and its request.
    pub key: Option<String>,
}

impl LineOwner {
    /// Returns the owner of a line; `None` if it is not a whole line of an archive.
    pub fn of(line: &[u8]) -> Option<LineOwner> {
        #[derive(Deserialize)]
        struct Fields {
            path: String,
            key: Option<String>,
            error: Option<IgnoredAny>,
        }
        let Fields { path, key, error } = serde_json::from_slice(line).ok()?;
        let is_key =
            |key: &String| key.len() == KEY_DIGITS && key.bytes().all(|byte| byte.is_ascii_hexdigit());
        let is_ours = line.starts_with(LINE_BEGINNING) && key.as_ref().map_or(error.is_some(), is_key);
        is_ours.then_some(LineOwner { path, key })
    }
}

/// Beginning of every line of an archive.
const LINE_BEGINNING: &[u8] = b"{\"path\":\"";

/// Text that follows the path.
const AFTER_PATH: [&[u8]; 2] = [b",\"key\":\"", b",\"error\":\""];

/// The kind of text that bytes without an end of line may begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineBeginning {
    /// The bytes do not begin a line of an archive.
    Other,
    /// The bytes may begin a line of an archive, or another text with the same beginning.
    Perhaps,
    /// The bytes begin a line of an archive: they contain a whole path and the name of the next field.
    Line,
}

impl LineBeginning {
    /// Returns the kind of text that `bytes` begin.
    pub fn of(bytes: &[u8]) -> LineBeginning {
        let perhaps = |is_so: bool| if is_so { LineBeginning::Perhaps } else { LineBeginning::Other };
        let Some(mut path) = bytes.strip_prefix(LINE_BEGINNING) else {
            return perhaps(LINE_BEGINNING.starts_with(bytes));
        };
        loop {
            path = match path {
                [] | [b'\\'] => return LineBeginning::Perhaps,
                [b'\\', _, rest @ ..] => rest,
                [b'"', after @ ..] => {
                    // Complete JSON is not the beginning of a line.
                    let is_whole = serde_json::from_slice::<IgnoredAny>(bytes).is_ok();
                    return match AFTER_PATH.iter().any(|word| after.starts_with(word)) {
                        true if !is_whole => LineBeginning::Line,
                        _ => perhaps(!is_whole && AFTER_PATH.iter().any(|word| word.starts_with(after))),
                    };
                }
                [_, rest @ ..] => rest,
            };
        }
    }
}

/// The keys of programs for one request.
pub struct ArchiveKeys {
    request: u64,
}

impl ArchiveKeys {
    /// Returns the keys for a machine, tolerances (mm) and reading options.
    pub fn new(machine: &Machine, tolerances: &[f64], options: &Options) -> ArchiveKeys {
        ArchiveKeys::by_version(VERSION, machine, tolerances, options)
    }

    /// Returns the keys for a version of the build: a different version may predict a different time.
    fn by_version(version: &str, machine: &Machine, tolerances: &[f64], options: &Options) -> ArchiveKeys {
        let machine = toml_from_machine(machine);
        let dialect = options.dialect.map_or("", Dialect::word);
        let arc_centers = options.arc_centers.map_or("", ArcCenters::word);
        let request = format!("{version}\n{machine}\n{tolerances:?}\n{dialect}{arc_centers}");
        ArchiveKeys { request: digest(FNV_OFFSET_BASIS, request.as_bytes()) }
    }

    /// Returns the key of a program.
    pub fn of(&self, program: &[u8]) -> String {
        format!("{:0KEY_DIGITS$x}", digest(self.request, program))
    }
}

/// Number of hexadecimal digits of a key.
const KEY_DIGITS: usize = 16;

/// Offset basis of FNV-1a.
const FNV_OFFSET_BASIS: u64 = 0xcbf2_9ce4_8422_2325;

/// Returns the 64-bit FNV-1a hash (Fowler, Noll, Vo): it detects changes of a program, but does not protect
/// against attacks.
fn digest(start: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(start, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_of_everything_that_a_line_follows_from() {
        let machine = Machine::default();
        let mut other = machine.clone();
        other.rapid.feedrate *= 2.0;
        let options = Options::default();
        let iso = Options { dialect: Some(Dialect::Iso), ..Options::default() };
        let absolute = Options { arc_centers: Some(ArcCenters::Absolute), ..Options::default() };
        let keys = [
            ArchiveKeys::new(&machine, &[], &options).of(b"G1"),
            ArchiveKeys::new(&machine, &[], &options).of(b"G2"),
            ArchiveKeys::new(&machine, &[0.01], &options).of(b"G1"),
            ArchiveKeys::new(&machine, &[], &iso).of(b"G1"),
            ArchiveKeys::new(&machine, &[], &absolute).of(b"G1"),
            ArchiveKeys::new(&other, &[], &options).of(b"G1"),
            ArchiveKeys::by_version("0.1.0+1.g0000000", &machine, &[], &options).of(b"G1"),
            ArchiveKeys::by_version("0.1.0+2.g0000000", &machine, &[], &options).of(b"G1"),
        ];
        let mut distinct = keys.to_vec();
        distinct.sort();
        distinct.dedup();
        assert_eq!(distinct.len(), keys.len());
        assert_eq!(ArchiveKeys::new(&machine, &[], &options).of(b"G1"), keys[0]);
    }

    #[test]
    fn half_a_line_has_no_owner_and_begins_one() {
        let key = ArchiveKeys::new(&Machine::default(), &[], &Options::default()).of(b"G1");
        for (key, error) in [(Some(&*key), None), (Some(&*key), Some("no\nway")), (None, Some("no"))] {
            let line = ArchiveLine { path: "a \"b\\.nc", key, prediction: None, error }.to_line();
            assert_eq!(line.matches('\n').count(), 1);
            let owner = LineOwner { path: "a \"b\\.nc".to_string(), key: key.map(str::to_string) };
            assert_eq!(LineOwner::of(line.as_bytes()), Some(owner));
            let after_path = if key.is_some() { ",\"key\":\"" } else { ",\"error\":\"" };
            let shown = line.find(after_path).expect("it follows the path") + after_path.len();
            for end in 0..line.trim_end().len() {
                assert_eq!(LineOwner::of(&line.as_bytes()[..end]), None);
                let is_sure = shown <= end;
                let expected = if is_sure { LineBeginning::Line } else { LineBeginning::Perhaps };
                assert_eq!(LineBeginning::of(&line.as_bytes()[..end]), expected, "{}", &line[..end]);
            }
        }
    }

    #[test]
    fn what_somebody_else_wrote_is_no_line_and_begins_none() {
        for text in [
            "{\"precious\":1}",
            "{\"path\":\"a.nc\"}",
            "{\"path\":\"a.nc\",\"customer\":\"Smith\"}",
            "{\"path\":\"a.nc\",\"key\":\"C major\"}",
            "{\"path\":\"a.nc\",\"customer\":",
            "[{\"path\":\"a.nc\",\"key\":\"0123456789abcdef\"}]",
            "G1X1F100 G1X2",
        ] {
            assert_eq!(LineOwner::of(text.as_bytes()), None, "{text}");
            assert_eq!(LineBeginning::of(text.as_bytes()), LineBeginning::Other, "{text}");
        }
    }
}
