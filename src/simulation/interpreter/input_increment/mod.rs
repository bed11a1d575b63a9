//! Lengths without a decimal point on controls that count them in their least input increment.
//!
//! Fanuc controls and their relatives, including Okuma, may be set to read `X10000` as 10000 increments of 0.001
//! mm, which is 10 mm, while `X10.` is 10 mm. The machine file gives that increment; in inch an increment is a
//! tenth of its number (0.0001 inch for 0.001 mm). It holds for X Y Z U V W I J K R Q. It does not hold for rotary
//! axes, nor for words that are not lengths: those of macro calls (G65, G66), of M98, of look-ahead and contour
//! modes (G5.1, G8, G187). Values of formulas count as written with a point, as on Fanuc controls. X and U of G4
//! count the same increments of a second, in inch too.
//!
//! LinuxCNC, grbl, Mach, SINUMERIK and Heidenhain controls read a number at its value.
//!
//! Without an increment in the machine file, words count at their value. A program with points that has a large
//! number without one gets one remark, and so does a program without points whose path extends further than
//! machines travel.
//!
//! Source: Fanuc B-63944EN, decimal point programming.

mod lengths;

use crate::simulation::gcode::{Place, Word};
use crate::simulation::interpreter::remark::TraceRemark;

/// G words in whose blocks the letters of lengths have another meaning.
const OTHER_G: [f64; 6] = [5.1, 8.0, 65.0, 66.0, 66.1, 187.0];

/// M words in whose blocks these letters have another meaning.
const OTHER_M: [f64; 3] = [97.0, 98.0, 198.0];

/// The decimal points of a program.
#[derive(Default)]
pub(super) struct Points {
    /// `true` if a length has one.
    are_written: bool,
    /// The first large length without one.
    missing: Option<(Place, TraceRemark)>,
}

/// Returns `true` if the letter of a word is a length's.
fn is_length(word: &Word) -> bool {
    matches!(word.letter, b'X' | b'Y' | b'Z' | b'U' | b'V' | b'W' | b'I' | b'J' | b'K' | b'R' | b'Q')
}

/// Returns `true` if the letters of lengths have that meaning in a block.
fn has_lengths(words: &[Word]) -> bool {
    !words.iter().any(|word| match word.letter {
        b'G' => OTHER_G.contains(&word.value),
        b'M' => OTHER_M.contains(&word.value),
        _ => false,
    })
}

#[cfg(test)]
mod tests;
