//! Mutations of files: bytes turned over, words from the dictionary put in, lines repeated, taken
//! out or borrowed from another file.

/// Marsaglia's xorshift.
pub struct Random(pub u64);

impl Random {
    /// From 0 to below `bound`; 0 where there is nothing to choose from.
    pub fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % bound.max(1)
    }
}

/// The longest file that is made, bytes.
const LONGEST: usize = 4096;

/// The words of a dictionary of libFuzzer: one a line, in quotes, with `\x` escapes.
pub fn words(dictionary: &str) -> Vec<Vec<u8>> {
    let lines = dictionary.lines().filter(|line| !line.starts_with('#'));
    let quoted = lines.filter_map(|line| line.strip_prefix('"')?.strip_suffix('"'));
    quoted.map(unescaped).collect()
}

fn unescaped(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.bytes().next() {
        let (byte, length) = match rest.strip_prefix('\\') {
            Some(escaped) if escaped.starts_with('x') => {
                (u8::from_str_radix(&escaped[1..3], 16).expect("two hexadecimal digits"), 4)
            }
            Some(escaped) => (escaped.as_bytes()[0], 2),
            None => (first, 1),
        };
        bytes.push(byte);
        rest = &rest[length..];
    }
    bytes
}

/// One of `seeds` after a few mutations.
pub fn mutated(random: &mut Random, seeds: &[Vec<u8>], words: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = seeds[random.below(seeds.len())].clone();
    for _ in 0..1 + random.below(6) {
        mutate(random, &mut bytes, seeds, words);
    }
    bytes.truncate(LONGEST);
    bytes
}

fn mutate(random: &mut Random, bytes: &mut Vec<u8>, seeds: &[Vec<u8>], words: &[Vec<u8>]) {
    let at = random.below(bytes.len());
    match random.below(9) {
        0 if !bytes.is_empty() => bytes[at] ^= 1 << random.below(8),
        1 if !bytes.is_empty() => bytes[at] = random.below(256) as u8,
        2 => {
            let end = (at + random.below(12)).min(bytes.len());
            bytes.drain(at..end);
        }
        3 | 4 => put(bytes, at, &words[random.below(words.len())]),
        5 => {
            let mut word = words[random.below(words.len())].clone();
            word.push(b'\n');
            let start = line(bytes, at).start;
            put(bytes, start, &word);
        }
        6 => {
            let copy = bytes[line(bytes, at)].to_vec();
            let to = random.below(bytes.len());
            let to = line(bytes, to).start;
            put(bytes, to, &copy);
        }
        7 => {
            bytes.drain(line(bytes, at));
        }
        _ => {
            let other = &seeds[random.below(seeds.len())];
            let from = random.below(other.len());
            let end = (from + random.below(400)).min(other.len());
            put(bytes, at, &other[from..end]);
        }
    }
}

fn put(bytes: &mut Vec<u8>, at: usize, new: &[u8]) {
    bytes.splice(at..at, new.iter().copied());
}

/// The line around a byte, with its end.
fn line(bytes: &[u8], at: usize) -> std::ops::Range<usize> {
    let start = bytes[..at].iter().rposition(|byte| *byte == b'\n').map_or(0, |index| index + 1);
    let end = bytes[at..].iter().position(|byte| *byte == b'\n').map_or(bytes.len(), |index| at + index + 1);
    start..end
}
