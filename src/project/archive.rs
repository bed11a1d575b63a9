//! Predictions of many programs: one JSON object a line, told apart by path and key.
//!
//! ```text
//! {"path": "parts/a.nc", "key": "0f3a…", <what predict --json prints>}
//! {"path": "parts/b.nc", "key": "77c1…", "error": "why there is no prediction"}
//! ```
//!
//! The key is that of everything the line follows from: the bytes of the program, the machine, the tolerances, the
//! dialect, the arc centres and the version of the build. A line is current while its key is; a program that could not be
//! read has no key, and
//! its line is never current.

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use crate::machine::Machine;
use crate::project::{Prediction, VERSION, toml_from_machine};
use crate::simulation::gcode::{ArcCenters, Dialect, Options};

/// One line.
#[derive(Clone, Debug, Serialize)]
pub struct ArchiveLine<'a> {
    /// The program, as it was named or found.
    pub path: &'a str,
    /// What the line follows from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub key: Option<&'a str>,
    /// What was predicted.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub prediction: Option<&'a Prediction>,
    /// Why nothing was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<&'a str>,
}

impl ArchiveLine<'_> {
    /// As JSON text on one line, with its end.
    pub fn to_line(&self) -> String {
        let mut line = serde_json::to_string(self).expect("text and finite numbers have a JSON form");
        line.push('\n');
        line
    }
}

/// Whose line it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineOwner {
    /// The program.
    pub path: String,
    /// What the line follows from.
    pub key: Option<String>,
}

impl LineOwner {
    /// Returns the owner of a line, or `None` if it is not a whole line of an archive.
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
        let is_ours = line.starts_with(HEAD) && key.as_ref().map_or(error.is_some(), is_key);
        is_ours.then_some(LineOwner { path, key })
    }
}

/// How a line begins.
const HEAD: &[u8] = b"{\"path\":\"";

/// What follows its path.
const AFTER_PATH: [&[u8]; 2] = [b",\"key\":\"", b",\"error\":\""];

/// Whether bytes without an end of line are the beginning of a line of an archive, and not all of something else.
pub fn begins_a_line(bytes: &[u8]) -> bool {
    let Some(mut path) = bytes.strip_prefix(HEAD) else { return HEAD.starts_with(bytes) };
    loop {
        path = match path {
            [] | [b'\\'] => return true,
            [b'\\', _, rest @ ..] => rest,
            [b'"', after @ ..] => {
                let begins = |word: &&[u8]| after.starts_with(word) || word.starts_with(after);
                return AFTER_PATH.iter().any(begins) && serde_json::from_slice::<IgnoredAny>(bytes).is_err();
            }
            [_, rest @ ..] => rest,
        };
    }
}

/// Keys of programs for one request.
pub struct Keys {
    request: u64,
}

impl Keys {
    /// Those of a machine, tolerances (mm) and the options of reading.
    pub fn new(machine: &Machine, tolerances: &[f64], options: &Options) -> Keys {
        Keys::by_version(VERSION, machine, tolerances, options)
    }

    /// Those of a version, which is a model: another one may predict another time.
    fn by_version(version: &str, machine: &Machine, tolerances: &[f64], options: &Options) -> Keys {
        let machine = toml_from_machine(machine);
        let dialect = options.dialect.map_or("", Dialect::word);
        let arc_centers = options.arc_centers.map_or("", ArcCenters::word);
        let request = format!("{version}\n{machine}\n{tolerances:?}\n{dialect}{arc_centers}");
        Keys { request: digest(OFFSET, request.as_bytes()) }
    }

    /// That of a program.
    pub fn of(&self, program: &[u8]) -> String {
        format!("{:0KEY_DIGITS$x}", digest(self.request, program))
    }
}

/// Hexadecimal digits of a key.
const KEY_DIGITS: usize = 16;

/// Where FNV-1a begins.
const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;

/// FNV-1a (Fowler, Noll, Vo) over 64 bits: tells a program from its earlier self, and guards against nobody.
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
            Keys::new(&machine, &[], &options).of(b"G1"),
            Keys::new(&machine, &[], &options).of(b"G2"),
            Keys::new(&machine, &[0.01], &options).of(b"G1"),
            Keys::new(&machine, &[], &iso).of(b"G1"),
            Keys::new(&machine, &[], &absolute).of(b"G1"),
            Keys::new(&other, &[], &options).of(b"G1"),
            Keys::by_version("0.1.0+1.g0000000", &machine, &[], &options).of(b"G1"),
            Keys::by_version("0.1.0+2.g0000000", &machine, &[], &options).of(b"G1"),
        ];
        let mut distinct = keys.to_vec();
        distinct.sort();
        distinct.dedup();
        assert_eq!(distinct.len(), keys.len());
        assert_eq!(Keys::new(&machine, &[], &options).of(b"G1"), keys[0]);
    }

    #[test]
    fn half_a_line_has_no_owner_and_begins_one() {
        let key = Keys::new(&Machine::default(), &[], &Options::default()).of(b"G1");
        for (key, error) in [(Some(&*key), None), (Some(&*key), Some("no\nway")), (None, Some("no"))] {
            let line = ArchiveLine { path: "a \"b\\.nc", key, prediction: None, error }.to_line();
            assert_eq!(line.matches('\n').count(), 1);
            let owner = LineOwner { path: "a \"b\\.nc".to_string(), key: key.map(str::to_string) };
            assert_eq!(LineOwner::of(line.as_bytes()), Some(owner));
            for end in 0..line.trim_end().len() {
                assert_eq!(LineOwner::of(&line.as_bytes()[..end]), None);
                assert!(begins_a_line(&line.as_bytes()[..end]), "{}", &line[..end]);
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
            assert!(!begins_a_line(text.as_bytes()), "{text}");
        }
    }
}
