//! The file of an archive, `--ndjson --out`: whole lines, written without loss by one run at a time.
//!
//! Each line is written by a single call, so that a killed run leaves whole lines and at most a part of one
//! further line, which the next run removes. Lines of programs outside the request are kept. A file with
//! other content is refused.

use std::collections::HashSet;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Write, stdout};
use std::path::{Path, PathBuf};

use truefeed::project::{LineBeginning, LineOwner};

use crate::command::CommandError;
use crate::command::output::{OutputKind, is_at, prepared, stream};

/// The destination of lines.
pub enum Sink {
    /// Standard output.
    Standard,
    /// A file, locked if it is a regular one.
    File(File, PathBuf),
}

/// The fate of a line of an earlier run.
pub enum Earlier {
    /// Its program is outside the request: the line is kept.
    Other,
    /// The line is current: it is kept, and its program is skipped.
    Current,
    /// Its program, the machine or the version has changed: this run replaces it.
    Outdated,
}

/// The lines of earlier runs.
struct EarlierLines {
    /// Lines to keep.
    kept: Vec<u8>,
    /// Programs with a current line.
    current: HashSet<String>,
}

/// Opens `out` to append lines. Returns it with the programs whose lines in it are current.
///
/// # Errors
///
/// Returns an error if `out` is among the `inputs`, has other content, or another run writes to it.
pub fn open(
    out: &Path,
    inputs: &[&Path],
    state: &dyn Fn(&LineOwner) -> Earlier,
) -> Result<(Sink, HashSet<String>), CommandError> {
    let refused = |error: std::io::Error| format!("{}: {error}", out.display());
    let place = match OutputKind::of(out, inputs)? {
        OutputKind::Standard => return Ok((Sink::Standard, HashSet::new())),
        OutputKind::Stream => {
            return Ok((Sink::File(stream(out).map_err(refused)?, out.to_path_buf()), HashSet::new()));
        }
        OutputKind::File(place) => place,
    };
    let mut file = locked(&place, out)?;
    let mut before = Vec::new();
    file.read_to_end(&mut before).map_err(refused)?;
    let EarlierLines { kept, current } = lines(&before, out, state)?;
    if kept != before {
        let replacement = prepared(&place, &kept).map_err(refused)?;
        lock(replacement.as_file(), out)?;
        // The old file is locked until the new one has replaced it.
        file = replacement.persist(&place).map_err(|error| refused(error.error))?;
    }
    Ok((Sink::File(file, out.to_path_buf()), current))
}

/// Sorts the lines of earlier runs.
fn lines(
    before: &[u8],
    out: &Path,
    state: &dyn Fn(&LineOwner) -> Earlier,
) -> Result<EarlierLines, CommandError> {
    let (mut kept, mut current) = (Vec::new(), HashSet::new());
    for (index, line) in before.split_inclusive(|byte| *byte == b'\n').enumerate() {
        let Some(owner) = LineOwner::of(line) else {
            // A part of a line, from a killed run; if it is the first line, it must be recognisable as a
            // prediction.
            let is_part = match LineBeginning::of(line) {
                LineBeginning::Line => true,
                LineBeginning::Perhaps => 0 < index,
                LineBeginning::Other => false,
            };
            if is_part && !line.ends_with(b"\n") {
                continue;
            }
            let (out, number) = (out.display(), index + 1);
            return Err(format!("{out}: line {number} is not a prediction; give another --out"));
        };
        let is_kept = match state(&owner) {
            Earlier::Other => true,
            Earlier::Current => current.insert(owner.path),
            Earlier::Outdated => false,
        };
        if is_kept {
            kept.extend_from_slice(line);
            if !line.ends_with(b"\n") {
                kept.push(b'\n');
            }
        }
    }
    Ok(EarlierLines { kept, current })
}

/// Opens the file at `place`, creates it if it is missing, and locks it.
fn locked(place: &Path, out: &Path) -> Result<File, CommandError> {
    let refused = |error: std::io::Error| format!("{}: {error}", out.display());
    loop {
        let file = OpenOptions::new().read(true).append(true).create(true).open(place).map_err(refused)?;
        lock(&file, out)?;
        // Another run may have replaced the file between the two calls.
        if is_at(&file, place).map_err(refused)? {
            return Ok(file);
        }
    }
}

/// Prevents a second run from appending to the file.
fn lock(file: &File, out: &Path) -> Result<(), CommandError> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(format!(
            "{}: another run is writing to this file; wait until it ends, or give another --out",
            out.display()
        )),
        // Some file systems have no locks.
        Err(TryLockError::Error(_)) => Ok(()),
    }
}

impl Sink {
    /// Writes a line.
    pub fn put(&mut self, line: &str) -> Result<(), CommandError> {
        match self {
            Sink::File(file, path) => {
                file.write_all(line.as_bytes()).map_err(|error| format!("{}: {error}", path.display()))
            }
            Sink::Standard => {
                stdout().write_all(line.as_bytes()).and_then(|()| stdout().flush()).map_err(|error| {
                    match error.kind() {
                        ErrorKind::BrokenPipe => "the reader of the lines has closed its end".to_string(),
                        _ => error.to_string(),
                    }
                })
            }
        }
    }
}
