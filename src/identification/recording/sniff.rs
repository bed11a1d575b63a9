//! The first bytes of a file → machine log or G-code program.
//!
//! A log is XML, JSON, events with stamps or rows of numbers; a line of a program begins with a letter, a
//! number and a letter, or a remark, and has no second number in a row without a letter before it. Any other
//! file, such as an empty or a binary one, counts as a program, whose reader reports the fault.

use crate::identification::recording::formats::{beckhoff, events};
use crate::identification::recording::packed;
use crate::identification::recording::text::{CellContent, decode, number};

/// Number of bytes that determine the kind of a file.
pub const SNIFFED_BYTES: usize = 1 << 16;

/// Number of lines that are inspected.
const SNIFFED_LINES: usize = 200;

/// Returns `true` if `bytes`, a file or its beginning, are a machine log.
pub fn is_recording(bytes: &[u8]) -> bool {
    if packed::is_packed_log(bytes) {
        return true;
    }
    let Ok(text) = decode(&bytes[..bytes.len().min(SNIFFED_BYTES)]) else { return false };
    let start = text.trim_start();
    if start.starts_with(['<', '{', '[']) || events::is_shdr(&text) || beckhoff::is_scope(&text) {
        return true;
    }
    let filled = text.lines().filter(|line| !line.trim().is_empty()).take(SNIFFED_LINES);
    let (mut rows, mut all) = (0, 0);
    for line in filled {
        all += 1;
        rows += usize::from(is_row(line));
    }
    // Even the shortest table has names and units above it.
    0 < rows && all <= 2 * rows + 2
}

/// Returns `true` for a row of at least two numbers, most of its fields. Brackets belong to the call of a
/// cycle.
fn is_row(line: &str) -> bool {
    if line.contains('(') {
        return false;
    }
    [";", "\t", ",", " ", "|"].iter().any(|separator| {
        let cells = line.split(separator).map(str::trim).filter(|cell| !cell.is_empty());
        let (mut numbers, mut others) = (0, 0);
        for cell in cells {
            match number(cell, *separator != ",") {
                CellContent::Number(_) | CellContent::Missing => numbers += 1,
                CellContent::Other => others += 1,
            }
        }
        2 <= numbers && others <= numbers
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logs_are_told_from_programs() {
        let logs: [&[u8]; 6] = [
            b"t_s,x_mm,y_mm\n0,1,2\n",
            b"time;feed\ns;mm/min\n0,01;5,0\n0,02;6,0\n",
            b"0 1.5 2.5\n1 1.6 2.6\n",
            b"2017-02-02T19:01:02.6Z|Block_Number|0\n2017-02-02T19:01:03.6Z|Block_Number|1\n",
            b"<?xml version=\"1.0\"?><MTConnectStreams>",
            b"time_s,line,status\n0,1,ACTIVE\n1,2,ACTIVE\n",
        ];
        for log in logs {
            assert!(is_recording(log), "{}", String::from_utf8_lossy(log));
        }
        let programs: [&[u8]; 8] = [
            b"",
            b"%\nO1\nG0 X1 Y2\nG1 X3, Y4 F100\n%\n",
            b"N10 G0 X0\nN20 G1 X10 F500\n",
            b"BEGIN PGM A MM\n1 L X+0 Y+0 R0 FMAX\n2 L X+10 F500\nEND PGM A MM\n",
            b"(1, 2, 3)\n(4, 5, 6)\nG1 X1\nG1 X2\nG1 X3\nG1 X4\nG1 X5\n",
            b"CYCLE81(5,0,2,-10)\nMCALL\nG0 X=R1 Y=2\n",
            b"PK\x03\x04",
            b"g1x1y2\nx2\ny3\n",
        ];
        for program in programs {
            assert!(!is_recording(program), "{}", String::from_utf8_lossy(program));
        }
    }
}
