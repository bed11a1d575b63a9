//! The file of an archive, `--ndjson --out`: whole lines, by one run at a time, and nothing lost.
//!
//! A line is written by a single call, so that a run that is killed leaves whole lines and at most half of one more,
//! which the next run removes. Lines of programs that are not asked for stay. A file with anything else in it is
//! refused.

use std::collections::HashSet;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Write, stdout};
use std::path::{Path, PathBuf};

use truefeed::project::{LineOwner, begins_a_line};

use crate::command::Refusal;
use crate::command::output::{Kind, is_at, prepared, stream};

/// Where lines go.
pub enum Sink {
    /// To standard output.
    Standard,
    /// To a file, which is locked if it is a regular one.
    File(File, PathBuf),
}

/// What becomes of a line of an earlier run.
pub enum Earlier {
    /// Its program is not asked for: it stays.
    Other,
    /// It says what this run would say: it stays, and its program is skipped.
    Current,
    /// Its program, the machine or the version has changed: this run replaces it.
    Outdated,
}

/// The lines of earlier runs.
struct Lines {
    /// Those that stay.
    kept: Vec<u8>,
    /// The programs whose lines are current.
    current: HashSet<String>,
}

/// Opens `out` to add lines to. Returns it with the programs whose lines in it are current.
///
/// # Errors
///
/// Says why no line can be added: `out` is among the `inputs`, holds something else, or another run writes to it.
pub fn open(
    out: &Path,
    inputs: &[&Path],
    state: &dyn Fn(&LineOwner) -> Earlier,
) -> Result<(Sink, HashSet<String>), Refusal> {
    let refused = |error: std::io::Error| format!("{}: {error}", out.display());
    let place = match Kind::of(out, inputs)? {
        Kind::Standard => return Ok((Sink::Standard, HashSet::new())),
        Kind::Stream => {
            return Ok((Sink::File(stream(out).map_err(refused)?, out.to_path_buf()), HashSet::new()));
        }
        Kind::File(place) => place,
    };
    let mut file = locked(&place, out)?;
    let mut before = Vec::new();
    file.read_to_end(&mut before).map_err(refused)?;
    let Lines { kept, current } = lines(&before, out, state)?;
    if kept != before {
        let replacement = prepared(&place, &kept).map_err(refused)?;
        lock(replacement.as_file(), out)?;
        // The former file is locked until the new one has its place.
        file = replacement.persist(&place).map_err(|error| refused(error.error))?;
    }
    Ok((Sink::File(file, out.to_path_buf()), current))
}

/// Sorts the lines of earlier runs.
fn lines(before: &[u8], out: &Path, state: &dyn Fn(&LineOwner) -> Earlier) -> Result<Lines, Refusal> {
    let (mut kept, mut current) = (Vec::new(), HashSet::new());
    for (index, line) in before.split_inclusive(|byte| *byte == b'\n').enumerate() {
        let Some(owner) = LineOwner::of(line) else {
            // A run that was killed in the middle of a line.
            if !line.ends_with(b"\n") && begins_a_line(line) {
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
    Ok(Lines { kept, current })
}

/// Opens the file at `place`, creates it if there is none, and locks it.
fn locked(place: &Path, out: &Path) -> Result<File, Refusal> {
    let refused = |error: std::io::Error| format!("{}: {error}", out.display());
    loop {
        let file = OpenOptions::new().read(true).append(true).create(true).open(place).map_err(refused)?;
        lock(&file, out)?;
        // Between the two another run may have put a new file in its place.
        if is_at(&file, place).map_err(refused)? {
            return Ok(file);
        }
    }
}

/// Keeps a second run from adding to the same file.
fn lock(file: &File, out: &Path) -> Result<(), Refusal> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(format!(
            "{}: another run writes to it; wait for its end, or give another --out",
            out.display()
        )),
        // Some file systems have no locks.
        Err(TryLockError::Error(_)) => Ok(()),
    }
}

impl Sink {
    /// Adds a line.
    pub fn put(&mut self, line: &str) -> Result<(), Refusal> {
        match self {
            Sink::File(file, path) => {
                file.write_all(line.as_bytes()).map_err(|error| format!("{}: {error}", path.display()))
            }
            Sink::Standard => {
                stdout().write_all(line.as_bytes()).and_then(|()| stdout().flush()).map_err(|error| {
                    match error.kind() {
                        ErrorKind::BrokenPipe => "nobody reads the lines any more".to_string(),
                        _ => error.to_string(),
                    }
                })
            }
        }
    }
}
