//! Predictions of many programs: one JSON object a line, told apart by path and key.
//!
//! ```text
//! {"path": "parts/a.nc", "key": "0f3a…", <what predict --json prints>}
//! {"path": "parts/b.nc", "key": "77c1…", "error": "why there is no prediction"}
//! ```
//!
//! The key is that of everything the line follows from: the bytes of the program, the machine, the tolerances, the
//! dialect and the version. A line is current while its key is; a program that could not be read has no key, and
//! its line is never current.

use serde::{Deserialize, Serialize};

use crate::machine::Machine;
use crate::project::{Prediction, toml_from_machine};
use crate::simulation::gcode::Dialect;

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
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct LineOwner {
    /// The program.
    pub path: String,
    /// What the line follows from.
    #[serde(default)]
    pub key: Option<String>,
}

impl LineOwner {
    /// The owner of a line; none where it is not a whole line of an archive.
    pub fn of(line: &[u8]) -> Option<LineOwner> {
        serde_json::from_slice(line).ok()
    }
}

/// Keys of programs for one request.
pub struct Keys {
    request: u64,
}

impl Keys {
    /// Those of a machine, tolerances (mm) and a dialect.
    pub fn new(machine: &Machine, tolerances: &[f64], dialect: Option<Dialect>) -> Keys {
        let request = format!(
            "{}\n{}\n{tolerances:?}\n{}",
            env!("CARGO_PKG_VERSION"),
            toml_from_machine(machine),
            dialect.map_or("", Dialect::word)
        );
        Keys { request: digest(OFFSET, request.as_bytes()) }
    }

    /// That of a program.
    pub fn of(&self, program: &[u8]) -> String {
        format!("{:016x}", digest(self.request, program))
    }
}

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
        let keys = [
            Keys::new(&machine, &[], None).of(b"G1"),
            Keys::new(&machine, &[], None).of(b"G2"),
            Keys::new(&machine, &[0.01], None).of(b"G1"),
            Keys::new(&machine, &[], Some(Dialect::Iso)).of(b"G1"),
            Keys::new(&other, &[], None).of(b"G1"),
        ];
        let mut distinct = keys.to_vec();
        distinct.sort();
        distinct.dedup();
        assert_eq!(distinct.len(), keys.len());
        assert_eq!(Keys::new(&machine, &[], None).of(b"G1"), keys[0]);
    }

    #[test]
    fn half_a_line_has_no_owner() {
        let line =
            ArchiveLine { path: "a \"b\".nc", key: Some("1"), prediction: None, error: Some("no\nway") }
                .to_line();
        assert_eq!(line.matches('\n').count(), 1);
        let owner = LineOwner { path: "a \"b\".nc".to_string(), key: Some("1".to_string()) };
        assert_eq!(LineOwner::of(line.as_bytes()), Some(owner));
        for end in 0..line.trim_end().len() {
            assert_eq!(LineOwner::of(&line.as_bytes()[..end]), None);
        }
    }
}
