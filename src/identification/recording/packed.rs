//! Packed logs → the bytes inside: gzip, and ZIP archives of one file.
//!
//! A ZIP archive is read by the directory at its end; folders and files that systems add (`__MACOSX/`,
//! `.DS_Store`) are ignored. Not read: ZIP64, encryption, and methods other than stored and deflated.
//!
//! Sources: RFC 1952; PKWARE's APPNOTE.TXT, sections 4.3.7, 4.3.12 and 4.3.16.

use std::borrow::Cow;
use std::io::Read;

use flate2::read::{DeflateDecoder, MultiGzDecoder};

use crate::identification::recording::RecordingError;

/// Most bytes of an unpacked log.
const MAX_UNPACKED_BYTES: u64 = 1 << 30;
/// Most unpacked bytes per packed byte: rows of numbers shrink to a hundredth at best.
const MAX_UNPACKED_RATIO: u64 = 300;

const GZIP_BEGINNING: &[u8] = b"\x1f\x8b";
const LOCAL_HEADER: &[u8] = b"PK\x03\x04";
const DIRECTORY_ENTRY: &[u8] = b"PK\x01\x02";
const DIRECTORY_END: &[u8] = b"PK\x05\x06";
/// Packing methods.
const STORED_METHOD: usize = 0;
const DEFLATED_METHOD: usize = 8;
/// Length of the end of a directory without its comment, bytes.
const DIRECTORY_END_BYTES: usize = 22;
/// Longest comment at the end of a directory, bytes.
const MAX_COMMENT_BYTES: usize = 65_535;

/// File extensions of logs; the first file of an Office document is `[Content_Types].xml` or `mimetype`.
const LOG_ENDINGS: [&str; 7] = ["csv", "json", "log", "shdr", "tsv", "txt", "xml"];

const DAMAGED_ARCHIVE: RecordingError =
    RecordingError::Binary("a ZIP archive that is damaged or packed in an unusual way");

const OVERSIZED_ARCHIVE: RecordingError =
    RecordingError::Binary("a ZIP archive that unpacks to far too much");

/// Returns the bytes of a log, unpacked if they are packed.
///
/// # Errors
///
/// Returns [`RecordingError::Binary`] if the archive is damaged, and [`RecordingError::Archive`] if it
/// contains several files.
pub(super) fn unpacked(bytes: &[u8]) -> Result<Cow<'_, [u8]>, RecordingError> {
    if bytes.starts_with(GZIP_BEGINNING) {
        whole(MultiGzDecoder::new(bytes), bytes.len())
            .map(Cow::Owned)
            .ok_or(RecordingError::Binary("a gzip file that is damaged or far too large unpacked"))
    } else if bytes.starts_with(LOCAL_HEADER) {
        only_file(bytes)
    } else {
        Ok(Cow::Borrowed(bytes))
    }
}

/// Returns `true` if a file that begins with `head` is a packed log. The name of the first file identifies an
/// archive without unpacking it. Programs are never packed by gzip.
pub fn is_packed_log(head: &[u8]) -> bool {
    head.starts_with(GZIP_BEGINNING)
        || number(head, 26, 2)
            .filter(|_| head.starts_with(LOCAL_HEADER))
            .and_then(|name| head.get(30..30 + name))
            .filter(|name| !name.starts_with(b"["))
            .and_then(|name| name.rsplit(|byte| *byte == b'.').next())
            .is_some_and(|ending| LOG_ENDINGS.iter().any(|log| ending.eq_ignore_ascii_case(log.as_bytes())))
}

/// Returns all bytes of a decoder; `None` if it fails, or returns far more than is plausible for `packed`
/// bytes.
fn whole(decoder: impl Read, packed: usize) -> Option<Vec<u8>> {
    let most = MAX_UNPACKED_BYTES.min(MAX_UNPACKED_RATIO * packed as u64 + (1 << 16));
    let mut bytes = Vec::new();
    decoder.take(most + 1).read_to_end(&mut bytes).ok()?;
    (bytes.len() as u64 <= most).then_some(bytes)
}

/// A file in the directory of an archive.
struct ArchiveEntry {
    name: String,
    is_encrypted: bool,
    method: usize,
    packed: usize,
    header: usize,
}

fn only_file(bytes: &[u8]) -> Result<Cow<'_, [u8]>, RecordingError> {
    match files(bytes)?.as_slice() {
        [file] => inside(bytes, file),
        several => {
            Err(RecordingError::Archive { names: several.iter().map(|file| file.name.clone()).collect() })
        }
    }
}

/// Returns all files of a ZIP archive with their names, including their folders. Their total size is at most
/// the largest size of one packed log.
///
/// # Errors
///
/// Returns [`RecordingError::Binary`] if the archive is damaged, encrypted or too large.
pub fn archived(bytes: &[u8]) -> Result<Vec<(String, Vec<u8>)>, RecordingError> {
    let mut room = MAX_UNPACKED_BYTES;
    let unpacked = files(bytes)?.into_iter().map(|file| {
        let inside = inside(bytes, &file)?.into_owned();
        room = room.checked_sub(inside.len() as u64).ok_or(OVERSIZED_ARCHIVE)?;
        Ok((file.name, inside))
    });
    unpacked.collect()
}

/// Returns the files of the directory, without folders and files that systems add.
fn files(bytes: &[u8]) -> Result<Vec<ArchiveEntry>, RecordingError> {
    let mut files = entries(bytes).ok_or(DAMAGED_ARCHIVE)?;
    files.retain(|file| {
        !file.name.ends_with('/') && !file.name.starts_with("__MACOSX/") && !file.name.ends_with(".DS_Store")
    });
    Ok(files)
}

/// Returns the bytes of a file of the archive.
fn inside<'a>(bytes: &'a [u8], file: &ArchiveEntry) -> Result<Cow<'a, [u8]>, RecordingError> {
    if file.is_encrypted {
        return Err(RecordingError::Binary("an encrypted ZIP archive"));
    }
    let packed = data(bytes, file.header).and_then(|data| data.get(..file.packed)).ok_or(DAMAGED_ARCHIVE)?;
    match file.method {
        STORED_METHOD => Ok(Cow::Borrowed(packed)),
        DEFLATED_METHOD => {
            whole(DeflateDecoder::new(packed), packed.len()).map(Cow::Owned).ok_or(DAMAGED_ARCHIVE)
        }
        _ => Err(DAMAGED_ARCHIVE),
    }
}

/// Returns the entries of the directory; `None` if it is damaged.
fn entries(bytes: &[u8]) -> Option<Vec<ArchiveEntry>> {
    let from = bytes.len().saturating_sub(DIRECTORY_END_BYTES + MAX_COMMENT_BYTES);
    let end = bytes[from..].windows(4).rposition(|window| window == DIRECTORY_END)? + from;
    let count = number(bytes, end + 10, 2)?;
    let mut at = number(bytes, end + 16, 4)?;
    let mut entries = Vec::new();
    for _ in 0..count {
        if bytes.get(at..at + 4)? != DIRECTORY_ENTRY {
            return None;
        }
        let name = number(bytes, at + 28, 2)?;
        let beside = number(bytes, at + 30, 2)? + number(bytes, at + 32, 2)?;
        entries.push(ArchiveEntry {
            name: String::from_utf8_lossy(bytes.get(at + 46..at + 46 + name)?).into_owned(),
            is_encrypted: number(bytes, at + 8, 2)? & 1 == 1,
            method: number(bytes, at + 10, 2)?,
            packed: number(bytes, at + 20, 4)?,
            header: number(bytes, at + 42, 4)?,
        });
        at += 46 + name + beside;
    }
    Some(entries)
}

/// Returns the bytes after the local header at `header`.
fn data(bytes: &[u8], header: usize) -> Option<&[u8]> {
    if bytes.get(header..header + 4)? != LOCAL_HEADER {
        return None;
    }
    bytes.get(header + 30 + number(bytes, header + 26, 2)? + number(bytes, header + 28, 2)?..)
}

/// Reads a number of `count` bytes, the least significant first.
fn number(bytes: &[u8], at: usize, count: usize) -> Option<usize> {
    let bytes = bytes.get(at..at.checked_add(count)?)?;
    Some(bytes.iter().rev().fold(0, |number, byte| (number << 8) | usize::from(*byte)))
}
