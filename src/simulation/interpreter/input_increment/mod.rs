//! Lengths without a decimal point on controls that count them in their least input increment.
//!
//! Fanuc controls and their relatives, Okuma too, may be set to read `X10000` as 10000 increments of
//! 0.001 mm, that is 10 mm, while `X10.` is 10 mm. The machine file says so by its increment; in
//! inch one increment is a tenth of its number (0.0001 inch for 0.001 mm). It holds for X Y Z U V W
//! I J K R Q; not for rotary axes, nor for words that are no lengths: those of macro calls (G65,
//! G66), of M98, of look-ahead and contour modes (G5.1, G8, G187). Values of formulas count as
//! written with a point, as on Fanuc controls. X and U of G4 count the same
//! increments of a second, in inch too.
//!
//! LinuxCNC, grbl, Mach, SINUMERIK and Heidenhain controls read a number as it is written.
//!
//! Where the machine file gives no increment, words are taken as they are; a program that writes
//! points and has a large number without one is told of it once, and so is one that writes none and
//! whose path reaches farther than machines do.
//!
//! Source: Fanuc B-63944EN, decimal point programming.

mod lengths;

use crate::simulation::gcode::{Place, Word};
use crate::simulation::interpreter::remark::TraceRemark;

/// G words in whose blocks these letters are no lengths.
const OTHER_G: [f64; 6] = [5.1, 8.0, 65.0, 66.0, 66.1, 187.0];

/// M words in whose blocks they are none.
const OTHER_M: [f64; 3] = [97.0, 98.0, 198.0];

/// What a program shows of its decimal points.
#[derive(Default)]
pub(super) struct Points {
    /// Some length has one.
    are_written: bool,
    /// The first large length that has none.
    missing: Option<(Place, TraceRemark)>,
}

/// Whether the letter of a word is that of a length.
fn is_length(word: &Word) -> bool {
    matches!(word.letter, b'X' | b'Y' | b'Z' | b'U' | b'V' | b'W' | b'I' | b'J' | b'K' | b'R' | b'Q')
}

fn has_lengths(words: &[Word]) -> bool {
    !words.iter().any(|word| match word.letter {
        b'G' => OTHER_G.contains(&word.value),
        b'M' => OTHER_M.contains(&word.value),
        _ => false,
    })
}

/// Whether the X or U of a block is a time.
fn is_dwell(words: &[Word]) -> bool {
    words.iter().any(|word| word.letter == b'G' && word.value == 4.0)
}

#[cfg(test)]
mod tests;
