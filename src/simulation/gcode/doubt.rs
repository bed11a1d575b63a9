//! Doubts about the time that a remark leaves. A later stage, which knows the times, bounds each in seconds.

use crate::simulation::gcode::LineNumber;

/// The cause of a doubt about the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DoubtCause {
    /// Words without a readable number.
    UnreadWords,
    /// Blocks that are not run.
    BlocksNotRun,
    /// G and M words with an unknown meaning.
    UnknownWords,
    /// Arcs with a centre that is not as far from their end as from their start.
    OpenArcs,
    /// Arcs that may have more or fewer turns.
    UnclearTurns,
    /// Arcs without a circle.
    MissingArcs,
    /// Moves without a feedrate.
    MissingFeeds,
    /// Moves programmed faster than the machine moves in rapid.
    FeedsBeyondRapid,
    /// Lengths without a decimal point.
    MissingPoints,
    /// Waiting times that are missing or in an unknown unit.
    UnclearDwells,
    /// Moves to a reference position that the machine file does not give.
    UnknownHome,
    /// Work offsets without a known value.
    UnknownOffsets,
    /// Holes that are not drilled as programmed.
    UnmadeHoles,
    /// Cycles and patterns without motion.
    UnmodelledCycles,
    /// Functions of the control without a model.
    UnmodelledFunctions,
    /// Splines that are run as straight lines.
    UnmodelledCurves,
    /// Threads without a feed.
    UnmodelledThreads,
    /// Signs of a lathe program that mills may have too.
    PerhapsLathe,
    /// Probing, which ends where the probe touches.
    Probing,
    /// Subprograms that are not in the file.
    MissingSubprograms,
    /// Jumps, loops and conditions that cannot be followed.
    BrokenFlow,
    /// Parameters without a value.
    UnknownParameters,
    /// Tool compensation without a diameter, or that does not fit.
    Compensation,
}

/// The part of a program whose time is in doubt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DoubtEffect {
    /// Words of a block that are missing. In a toolpath these are axes and centres alone, up to where the program gives
    /// the axes again.
    Words(Letters),
    /// Moves up to the next motion word, which may be in rapid or in feed.
    MotionWord,
    /// Moves up to the next motion word, at the end of which a hole may be made.
    CycleWord,
    /// The next move is an arc, or should be one.
    Arc,
    /// The next move is an arc, which may have up to this number of full turns more or fewer.
    Turns(f64),
    /// The next move is a helix that may advance by this pitch in a full turn, mm.
    Pitch(f64),
    /// The holes of the block have at most this multiple of the modelled pecks.
    Pecks(f64),
    /// Feed moves up to the next F.
    Feed,
    /// A move by rapid over an unknown distance, and the way back.
    Travel,
    /// A hole more or less.
    Hole,
    /// All moves of the block that is run next.
    Block,
    /// No bound is known.
    Unbounded,
}

/// A set of address letters, with one bit for a word that calls a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Letters(u32);

impl Letters {
    /// The axes X, Y and Z.
    pub const AXES: Letters = Letters::of(b"XYZ");
    /// A motion word (G1).
    pub const MOTION: Letters = Letters::of(b"G");
    /// A word that calls a cycle (G81).
    pub const CYCLE: Letters = Letters(1 << 31);

    /// Returns the set of these capital letters; other bytes are ignored.
    pub const fn of(letters: &[u8]) -> Letters {
        let (mut bits, mut index) = (0, 0);
        while index < letters.len() {
            if letters[index].is_ascii_uppercase() {
                bits |= 1 << (letters[index] - b'A');
            }
            index += 1;
        }
        Letters(bits)
    }

    /// Returns `true` if any letter is in both sets.
    pub fn meets(self, other: Letters) -> bool {
        self.0 & other.0 != 0
    }

    /// Returns the letters of either set.
    pub const fn with(self, other: Letters) -> Letters {
        Letters(self.0 | other.0)
    }

    /// Returns the letters of this set that are not in the other.
    pub fn without(self, other: Letters) -> Letters {
        Letters(self.0 & !other.0)
    }

    /// Returns `true` if the set has no letter.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

/// Returns the letters of axes, centres, feeds, motion words and cycles in a line that is not or not fully
/// readable. A line without any of them may have held any axis.
pub(super) fn letters_of_line(text: &[u8]) -> Letters {
    let mut letters = Letters::default();
    let mut depth = 0_usize;
    for (at, byte) in text.iter().enumerate().take_while(|(_, byte)| **byte != b';') {
        match byte {
            b'(' => depth += 1,
            b')' => depth = depth.saturating_sub(1),
            _ if 0 < depth => {}
            b'G' | b'g' => letters = letters.with(kind_of_g(&text[at + 1..])),
            _ if is_address(text, at) => letters = letters.with(Letters::of(&[byte.to_ascii_uppercase()])),
            _ if is_lost_address(text, at) => letters = letters.with(ANY_ADDRESS),
            _ => {}
        }
    }
    if breaks_off(text) {
        letters = letters.with(Letters::of(b"F"));
    }
    let relevant = Letters::of(b"XYZIJKRFG").with(Letters::CYCLE);
    if letters.meets(relevant) { letters } else { letters.with(Letters::AXES) }
}

/// Returns `true` if a line ends behind the address of an axis or a centre, or its sign: further words may be
/// missing, most often F.
pub(super) fn breaks_off(text: &[u8]) -> bool {
    let text = text.trim_ascii_end();
    let text = text.strip_suffix(b"-").or(text.strip_suffix(b"+")).unwrap_or(text);
    let Some((last, before)) = text.split_last() else { return false };
    let is_alone = before.last().is_none_or(|before| !before.is_ascii_alphabetic());
    is_alone && b"XYZIJKxyzijk".contains(last)
}

/// The addresses that an unknown sign may replace.
const ANY_ADDRESS: Letters = Letters::of(b"XYZF");

/// Returns `true` for a sign that begins no word before a number, in the place of an address.
fn is_lost_address(text: &[u8], at: usize) -> bool {
    let is_sign = text[at].is_ascii_punctuation() && !b"+-./%*[]=<>#_,:@^".contains(&text[at]);
    is_sign
        && (at == 0 || text[at - 1] <= b' ')
        && text.get(at + 1).is_some_and(|next| next.is_ascii_digit() || *next == b'-')
}

/// Returns `true` if the letter at `at` is an address: alone, or before a number.
fn is_address(text: &[u8], at: usize) -> bool {
    let is_letter = |at: usize| text.get(at).is_some_and(u8::is_ascii_alphabetic);
    // The text behind is only read after letters: a line may consist of a million blanks.
    if !is_letter(at) || is_letter(at + 1) {
        return false;
    }
    let is_alone = at == 0 || !is_letter(at - 1);
    let rest = text.get(at + 1..).unwrap_or_default().trim_ascii_start();
    let is_number = rest.first().is_some_and(|sign| matches!(sign, b'0'..=b'9' | b'.' | b'+' | b'-'));
    is_alone || is_number
}

/// Returns the kind of a G word by the text behind its letter; without a number it is a motion word.
fn kind_of_g(rest: &[u8]) -> Letters {
    let rest = rest.trim_ascii_start();
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let number = std::str::from_utf8(&rest[..digits]).ok().and_then(|digits| digits.parse().ok());
    match number {
        None if rest.first().is_some_and(u8::is_ascii_alphabetic) => Letters::default(),
        None | Some(0..4) => Letters::of(b"G"),
        Some(73..90) => Letters::CYCLE,
        Some(_) => Letters::default(),
    }
}

/// A reason for which the time of a program is in doubt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    /// Line of the program.
    pub line: LineNumber,
    /// Its cause.
    pub cause: DoubtCause,
    /// The part of the program in doubt.
    pub effect: DoubtEffect,
    /// Number of blocks before it in a [`Program`](crate::simulation::gcode::Program), number of segments before
    /// it in a toolpath.
    pub after: usize,
    /// One past the last segment in doubt; in a program equal to `after`.
    pub until: usize,
}
