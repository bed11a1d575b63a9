//! Input files of commands. Each has a largest length, so that an endless input is refused before it fills
//! the memory.

use std::fs::File;
use std::io::{Read, stdin};
use std::path::Path;

use truefeed::machine::Machine;
use truefeed::project::machine_from_toml;
use truefeed::simulation::gcode::Options;
use truefeed::simulation::interpreter::trace_text;
use truefeed::simulation::toolpath::Toolpath;

use crate::command::{CommandError, declined};

/// Maximum length of a program or a recording, bytes: three times the longest program known to the project.
const MAX_DATA_BYTES: u64 = 1 << 30;

/// Maximum length of a machine file or a cutting job, bytes: a thousand times a usual one.
const MAX_SETTINGS_BYTES: u64 = 1 << 20;

/// The path that means standard input.
const STANDARD_INPUT: &str = "-";

/// Returns the machine of a machine file.
pub fn machine_of(path: &Path) -> Result<Machine, CommandError> {
    machine_from_toml(&settings_of(path)?).map_err(|fault| format!("{}: {fault}", path.display()))
}

/// Returns the toolpath of a program on a machine; the error names the reason if the program is declined.
pub fn toolpath_of(program: &Path, options: &Options, machine: &Machine) -> Result<Toolpath, CommandError> {
    let toolpath = trace_text(bytes_of(program)?, options, machine);
    match declined(&toolpath) {
        Some(reason) => Err(format!("{}: {reason}", program.display())),
        None => Ok(toolpath),
    }
}

/// Returns the bytes of a program or a recording.
pub fn bytes_of(path: &Path) -> Result<Vec<u8>, CommandError> {
    read(path, MAX_DATA_BYTES)
}

/// Returns the text of a machine file or a cutting job.
pub fn settings_of(path: &Path) -> Result<String, CommandError> {
    String::from_utf8(read(path, MAX_SETTINGS_BYTES)?).map_err(|error| {
        format!("{}: not UTF-8 text at byte {}", path.display(), error.utf8_error().valid_up_to())
    })
}

/// Returns the operating system's path of an input, standard input included.
pub fn system_path(path: &Path) -> &Path {
    if path == Path::new(STANDARD_INPUT) { Path::new("/dev/stdin") } else { path }
}

/// Reads a file, or standard input, of at most `max_bytes`.
fn read(path: &Path, max_bytes: u64) -> Result<Vec<u8>, CommandError> {
    let refused = |error: std::io::Error| format!("{}: {error}", path.display());
    let outcome = if path == Path::new(STANDARD_INPUT) {
        read_within(stdin().lock(), 0, max_bytes)
    } else {
        let file = File::open(path).map_err(refused)?;
        let length = file.metadata().map_err(refused)?.len();
        read_within(file, length, max_bytes)
    };
    outcome.map_err(refused)?.ok_or_else(|| {
        format!("{}: longer than {} MiB; is it the right file?", path.display(), max_bytes >> 20)
    })
}

/// Reads to the end of a source that announces `length` bytes. Returns `None` if the source holds more than
/// `max_bytes`.
fn read_within(source: impl Read, length: u64, max_bytes: u64) -> std::io::Result<Option<Vec<u8>>> {
    if max_bytes < length {
        return Ok(None);
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length as usize)?;
    source.take(max_bytes + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= max_bytes).then_some(bytes))
}

#[cfg(test)]
mod tests {
    use std::io::repeat;

    use super::*;

    #[test]
    fn a_source_without_an_end_is_read_up_to_the_bound() {
        assert_eq!(read_within(repeat(b'G'), 0, 100_000).expect("it can be read"), None);
        assert_eq!(read_within(&b"G1"[..], 3, 2).expect("it can be read"), None);
        assert_eq!(read_within(&b"G1"[..], 2, 2).expect("it can be read"), Some(b"G1".to_vec()));
        assert_eq!(read_within(&b"G1X"[..], 0, 2).expect("it can be read"), None);
    }
}
