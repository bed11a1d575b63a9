//! The commands, one module each, and what all of them do: read files, write them whole, refuse in one line.

mod archive;
mod calibrate;
mod cutting;
mod diagnose;
mod predict;
mod probe;
mod programs;
mod runs;

pub use calibrate::calibrate;
pub use diagnose::diagnose;
pub use predict::predict;
pub use probe::probe;

use std::ffi::OsString;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use truefeed::machine::Machine;
use truefeed::project::machine_from_toml;
use truefeed::simulation::gcode::{Dialect, Options};
use truefeed::simulation::toolpath::{Toolpath, trace_text};

/// What is wrong with a request, in one line.
pub type Refusal = String;

/// The value of the option that was read last.
pub fn value(parser: &mut lexopt::Parser) -> Result<OsString, Refusal> {
    parser.value().map_err(|error| error.to_string())
}

/// Fills a slot that can be given once.
pub fn once(slot: &mut Option<PathBuf>, value: OsString, what: &str) -> Result<(), Refusal> {
    match slot.replace(value.into()) {
        None => Ok(()),
        Some(_) => Err(format!("{what} is given twice")),
    }
}

/// The value of `--dialect`.
pub fn dialect(parser: &mut lexopt::Parser) -> Result<Dialect, Refusal> {
    let word = value(parser)?.to_string_lossy().into_owned();
    let known = Dialect::WORDS.map(|(word, ..)| word).join(", ");
    Dialect::from_word(&word).ok_or_else(|| format!("--dialect {word}: expected one of {known}"))
}

/// The machine of a machine file.
pub fn machine_of(path: &Path) -> Result<Machine, Refusal> {
    machine_from_toml(&text_of(path)?).map_err(|fault| format!("{}: {fault}", path.display()))
}

/// The toolpath of a program on a machine.
pub fn toolpath_of(program: &Path, dialect: Option<Dialect>, machine: &Machine) -> Result<Toolpath, Refusal> {
    let options = Options { dialect, ..Options::default() };
    Ok(trace_text(bytes_of(program)?, &options, machine))
}

/// The bytes of a file, or of standard input for `-`.
pub fn bytes_of(path: &Path) -> Result<Vec<u8>, Refusal> {
    let mut bytes = Vec::new();
    let outcome = if path == Path::new("-") {
        std::io::stdin().read_to_end(&mut bytes).map(drop)
    } else {
        std::fs::read(path).map(|read| bytes = read)
    };
    outcome.map(|()| bytes).map_err(|error| format!("{}: {error}", path.display()))
}

/// The text of a file.
pub fn text_of(path: &Path) -> Result<String, Refusal> {
    String::from_utf8(bytes_of(path)?).map_err(|error| {
        format!("{}: not UTF-8 text at byte {}", path.display(), error.utf8_error().valid_up_to())
    })
}

/// Writes beside the target first, so that there is never half a file.
pub fn write_whole(path: &Path, text: &str) -> Result<(), Refusal> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    std::fs::write(&beside, text)
        .and_then(|()| std::fs::rename(&beside, path))
        .inspect_err(|_| drop(std::fs::remove_file(&beside)))
        .map_err(|error| format!("{}: {error}", path.display()))
}

/// Prints a text; a reader that went away is not our error.
pub fn print(text: &str) -> Result<(), Refusal> {
    match writeln!(std::io::stdout(), "{text}") {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.to_string()),
        _ => Ok(()),
    }
}
