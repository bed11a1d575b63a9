//! Packed logs → the bytes inside: gzip, and ZIP archives of one file.
//!
//! Of a ZIP archive the directory at its end is read; folders and what systems add (`__MACOSX/`, `.DS_Store`) do not
//! count as files. Left out: ZIP64, encryption, and methods other than stored and deflated.
//!
//! Sources: RFC 1952; PKWARE's APPNOTE.TXT, sections 4.3.7, 4.3.12 and 4.3.16.

use std::borrow::Cow;
use std::io::Read;

use flate2::read::{DeflateDecoder, MultiGzDecoder};

use crate::identification::recording::RecordingError;

/// Bytes inside a packed log at most, and how many for each packed one: rows of numbers shrink to a hundredth at best.
const MAX_UNPACKED_BYTES: u64 = 1 << 30;
const MAX_UNPACKED_RATIO: u64 = 300;

const GZIP: &[u8] = b"\x1f\x8b";
const LOCAL_HEADER: &[u8] = b"PK\x03\x04";
const DIRECTORY_ENTRY: &[u8] = b"PK\x01\x02";
const DIRECTORY_END: &[u8] = b"PK\x05\x06";
/// Methods of packing.
const STORED: usize = 0;
const DEFLATED: usize = 8;
/// Length of the end of a directory without its comment, and of the longest comment.
const END_BYTES: (usize, usize) = (22, 65_535);

/// Endings of logs; the first file of an Office document is `[Content_Types].xml` or `mimetype`.
const LOG_ENDINGS: [&str; 7] = ["csv", "json", "log", "shdr", "tsv", "txt", "xml"];

const DAMAGED: RecordingError =
    RecordingError::Binary("a ZIP archive that is damaged or packed in a way of its own");

/// The bytes of a log, unpacked where they are packed.
///
/// # Errors
/// [`RecordingError::Binary`] where the archive is damaged, [`RecordingError::Archive`] where it holds several files.
pub(super) fn unpacked(bytes: &[u8]) -> Result<Cow<'_, [u8]>, RecordingError> {
    if bytes.starts_with(GZIP) {
        whole(MultiGzDecoder::new(bytes), bytes.len())
            .map(Cow::Owned)
            .ok_or(RecordingError::Binary("a gzip file that is damaged or unpacks to far too much"))
    } else if bytes.starts_with(LOCAL_HEADER) {
        only_file(bytes)
    } else {
        Ok(Cow::Borrowed(bytes))
    }
}

/// Whether a file that begins so is a packed log: of an archive the name of its first file tells, so that nothing is
/// unpacked for it. A program is never read from gzip.
pub fn is_packed_log(head: &[u8]) -> bool {
    head.starts_with(GZIP)
        || number(head, 26, 2)
            .filter(|_| head.starts_with(LOCAL_HEADER))
            .and_then(|name| head.get(30..30 + name))
            .filter(|name| !name.starts_with(b"["))
            .and_then(|name| name.rsplit(|byte| *byte == b'.').next())
            .is_some_and(|ending| LOG_ENDINGS.iter().any(|log| ending.eq_ignore_ascii_case(log.as_bytes())))
}

/// All that a decoder gives; none where it fails, or gives out of all proportion to what is `packed`.
fn whole(decoder: impl Read, packed: usize) -> Option<Vec<u8>> {
    let most = MAX_UNPACKED_BYTES.min(MAX_UNPACKED_RATIO * packed as u64 + (1 << 16));
    let mut bytes = Vec::new();
    decoder.take(most + 1).read_to_end(&mut bytes).ok()?;
    (bytes.len() as u64 <= most).then_some(bytes)
}

/// A file in the directory of an archive.
struct Entry {
    name: String,
    is_encrypted: bool,
    method: usize,
    packed: usize,
    header: usize,
}

fn only_file(bytes: &[u8]) -> Result<Cow<'_, [u8]>, RecordingError> {
    let mut files = entries(bytes).ok_or(DAMAGED)?;
    files.retain(|file| {
        !file.name.ends_with('/') && !file.name.starts_with("__MACOSX/") && !file.name.ends_with(".DS_Store")
    });
    let file = match files.as_slice() {
        [file] => file,
        _ => {
            return Err(RecordingError::Archive { names: files.into_iter().map(|file| file.name).collect() });
        }
    };
    if file.is_encrypted {
        return Err(RecordingError::Binary("an encrypted ZIP archive"));
    }
    let packed = data(bytes, file.header).and_then(|data| data.get(..file.packed)).ok_or(DAMAGED)?;
    match file.method {
        STORED => Ok(Cow::Borrowed(packed)),
        DEFLATED => whole(DeflateDecoder::new(packed), packed.len()).map(Cow::Owned).ok_or(DAMAGED),
        _ => Err(DAMAGED),
    }
}

/// The entries of the directory; none where it is damaged.
fn entries(bytes: &[u8]) -> Option<Vec<Entry>> {
    let from = bytes.len().saturating_sub(END_BYTES.0 + END_BYTES.1);
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
        entries.push(Entry {
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

/// What follows the local header at `header`.
fn data(bytes: &[u8], header: usize) -> Option<&[u8]> {
    if bytes.get(header..header + 4)? != LOCAL_HEADER {
        return None;
    }
    bytes.get(header + 30 + number(bytes, header + 26, 2)? + number(bytes, header + 28, 2)?..)
}

/// A number of `count` bytes, the least significant first.
fn number(bytes: &[u8], at: usize, count: usize) -> Option<usize> {
    let bytes = bytes.get(at..at.checked_add(count)?)?;
    Some(bytes.iter().rev().fold(0, |number, byte| (number << 8) | usize::from(*byte)))
}
