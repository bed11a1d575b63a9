//! Files and folders → the programs among them.
//!
//! A file given by its path is a program, whatever its content. In a folder and its subfolders a file is a
//! program if it has the extension of one and contains neither binary data nor a recording, or if most of its
//! first lines are blocks. Names that begin with a dot are ignored, and links to folders are not followed, so
//! that the search ends.

use std::ffi::OsStr;
use std::fs::{DirEntry, File};
use std::io::Read;
use std::path::{Path, PathBuf};

use truefeed::identification::recording::{SNIFFED_BYTES, is_recording};

/// Extensions of programs, in lower case; for others (`.h`, `.txt`, none) the content decides.
const PROGRAM_EXTENSIONS: [&str; 11] =
    ["nc", "ngc", "cnc", "ncp", "tap", "gcode", "gco", "mpf", "spf", "eia", "hnc"];

/// Number of the first nonempty lines that are inspected.
const INSPECTED_LINES: usize = 100;

/// A program, or a place that cannot be read with the reason.
pub type FoundProgram = Result<PathBuf, (PathBuf, String)>;

/// Returns the programs of files and folders, folders in the order of names, each once.
pub fn programs(paths: &[PathBuf]) -> Vec<FoundProgram> {
    let mut found = Vec::new();
    for path in paths {
        if path.is_dir() { walk(path, &mut found) } else { found.push(Ok(path.clone())) }
    }
    let place = |found: &FoundProgram| match found {
        Ok(path) | Err((path, _)) => path.clone(),
    };
    let mut seen = std::collections::HashSet::new();
    found.retain(|found| seen.insert(place(found)));
    found
}

fn walk(folder: &Path, found: &mut Vec<FoundProgram>) {
    let refused = |error: std::io::Error| Err((folder.to_path_buf(), error.to_string()));
    let entries = match std::fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<DirEntry>, _>>) {
        Ok(entries) => entries,
        Err(error) => return found.push(refused(error)),
    };
    let mut entries: Vec<PathBuf> = entries.iter().map(DirEntry::path).collect();
    entries.sort();
    for path in entries.into_iter().filter(|path| !is_hidden(path)) {
        if path.is_dir() {
            if !path.is_symlink() {
                walk(&path, found);
            }
        } else if path.is_file() {
            match is_program(&path) {
                Ok(true) => found.push(Ok(path)),
                Ok(false) => {}
                Err(error) => found.push(Err((path, error.to_string()))),
            }
        }
    }
}

fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."))
}

fn is_program(path: &Path) -> std::io::Result<bool> {
    let mut head = Vec::new();
    File::open(path)?.take(SNIFFED_BYTES as u64).read_to_end(&mut head)?;
    let extension = path.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
    let is_text = !head.contains(&0) || head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff");
    let is_named = extension.is_some_and(|extension| PROGRAM_EXTENSIONS.contains(&extension.as_str()));
    Ok(is_text && !is_recording(&head) && (is_named || holds_blocks(&head)))
}

/// Returns `true` if most of the first lines are blocks or remarks, and some line moves or sets a mode.
fn holds_blocks(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head);
    let lines: Vec<&str> =
        text.lines().map(str::trim).filter(|line| !line.is_empty()).take(INSPECTED_LINES).collect();
    let blocks = lines.iter().filter(|line| is_block(line)).count();
    let words = lines.iter().filter(|line| has_word(line)).count();
    0 < words && lines.len() * 9 <= blocks * 10
}

/// Returns `true` for `%`, `(remark)`, `;remark`, `N10 …`, `/…`, or an address directly followed by its
/// number.
fn is_block(line: &str) -> bool {
    let line = line.trim_start_matches('/');
    if line.is_empty() || line.starts_with(['%', '(', ';', '#', ':']) {
        return true;
    }
    // Conversational blocks of Heidenhain begin with their number.
    let numbered = line.trim_start_matches(|c: char| c.is_ascii_digit()).trim_start();
    let is_statement =
        ["L ", "CC ", "C ", "TOOL ", "BEGIN PGM", "END PGM", "CYCL ", "BLK FORM", "FN ", "LBL ", "CALL "];
    is_word(line)
        || (numbered.len() < line.len()
            && (is_word(numbered) || is_statement.iter().any(|word| numbered.starts_with(word))))
}

/// Returns `true` if the text begins with a letter and a number, as a block does.
fn is_word(text: &str) -> bool {
    let mut characters = text.chars();
    let letter = characters.next().is_some_and(|first| first.is_ascii_alphabetic());
    let number = characters.as_str().trim_start_matches([' ', '+', '-', '=', '.']);
    letter && number.starts_with(|first: char| first.is_ascii_digit())
}

/// Returns `true` for a line with a G word, or a line or tool of a conversational program.
fn has_word(line: &str) -> bool {
    let upper = line.to_ascii_uppercase();
    upper.split(['G', ' ']).skip(1).any(|rest| rest.starts_with(|first: char| first.is_ascii_digit()))
        && (upper.contains('G') || upper.contains(" L ") || upper.contains("TOOL CALL"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_are_told_by_their_content() {
        let programs: [&str; 4] = [
            "%\nO1000 (PART)\nN10 G0 X0 Y0\nN20 G1 X10 F500\nM30\n%\n",
            "g21\ng0x1y2\nx2\ny3\n",
            "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000\n2 L X+0 Y+0 R0 FMAX\n3 END PGM A MM\n",
            "; grbl\nG90\nG1 X1 F100\n",
        ];
        for program in programs {
            assert!(holds_blocks(program.as_bytes()), "{program}");
        }
        let others = [
            "",
            "Dear Sir or Madam,\nthe G54 offset is wrong.\n",
            "# Notes\n\n- G1 is a move\n- see above\n",
            "name = \"a machine\"\n[interpolator]\nfilters = 3\n",
            "int main() {\n  return 0;\n}\n",
            "A1\nB2\nC3\n",
        ];
        for other in others {
            assert!(!holds_blocks(other.as_bytes()), "{other}");
        }
    }
}
