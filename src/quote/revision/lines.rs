//! Two texts → the lines that both have, in the same order.
//!
//! Lines that occur once in each text are candidates for anchors; the anchors are the longest list of them
//! that is in order in both texts (patience diff). The text between anchors is compared recursively, after
//! the equal lines at its beginning and end. A line is compared without its blanks, its case and its block
//! number, which changes with every other line.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;

use crate::simulation::gcode::lines;
use crate::simulation::ordered::sort_by_number;

/// Consecutive lines of both texts, from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct LineRun {
    /// Line numbers in the first text and in the second.
    pub lines: [Range<u32>; 2],
    /// `true` if the lines are equal.
    pub is_same: bool,
}

/// Returns all lines of both texts in runs, in order, and the number of lines of each text.
pub fn runs(first: &[u8], second: &[u8]) -> (Vec<LineRun>, [usize; 2]) {
    let texts = [first, second].map(|text| lines(text).map(line_hash).collect::<Vec<u64>>());
    let mut pairs = Vec::new();
    let mut open = vec![[0..texts[0].len(), 0..texts[1].len()]];
    while let Some([one, other]) = open.pop() {
        compare(&texts, one, other, &mut pairs, &mut open);
    }
    // Each line of the first text has at most one partner.
    sort_by_number(&mut pairs, |(first, _)| *first as f64);
    (joined(&pairs, [texts[0].len(), texts[1].len()]), [texts[0].len(), texts[1].len()])
}

/// Returns a hash of a line.
fn line_hash(line: &[u8]) -> u64 {
    let mut line = line.trim_ascii_start();
    if let [b'N' | b'n', rest @ ..] = line
        && rest.first().is_some_and(u8::is_ascii_digit)
    {
        line = rest;
    }
    let digits = line.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let mut hasher = DefaultHasher::new();
    for byte in line[digits..].iter().filter(|byte| !byte.is_ascii_whitespace()) {
        byte.to_ascii_uppercase().hash(&mut hasher);
    }
    hasher.finish()
}

/// Finds pairs of equal lines in two ranges, and the ranges that remain to be compared.
fn compare(
    texts: &[Vec<u64>; 2],
    mut one: Range<usize>,
    mut other: Range<usize>,
    pairs: &mut Vec<(usize, usize)>,
    open: &mut Vec<[Range<usize>; 2]>,
) {
    let is_alike = |a: usize, b: usize| texts[0][a] == texts[1][b];
    while !one.is_empty() && !other.is_empty() && is_alike(one.start, other.start) {
        pairs.push((one.start, other.start));
        (one.start, other.start) = (one.start + 1, other.start + 1);
    }
    while !one.is_empty() && !other.is_empty() && is_alike(one.end - 1, other.end - 1) {
        (one.end, other.end) = (one.end - 1, other.end - 1);
        pairs.push((one.end, other.end));
    }
    if one.is_empty() || other.is_empty() {
        return;
    }
    let anchors = in_order(&anchors(texts, &one, &other));
    if anchors.is_empty() {
        return;
    }
    let mut from = (one.start, other.start);
    for (a, b) in anchors {
        open.push([from.0..a, from.1..b]);
        pairs.push((a, b));
        from = (a + 1, b + 1);
    }
    open.push([from.0..one.end, from.1..other.end]);
}

/// Returns the indices of the lines that occur once in each range, in the order of the first.
fn anchors(texts: &[Vec<u64>; 2], one: &Range<usize>, other: &Range<usize>) -> Vec<(usize, usize)> {
    // Index of a line, as long as it occurs once.
    let single = |text: &[u64], stretch: &Range<usize>| {
        let mut places: HashMap<u64, Option<usize>> = HashMap::new();
        for place in stretch.clone() {
            places.entry(text[place]).and_modify(|found| *found = None).or_insert(Some(place));
        }
        places
    };
    let [first, second] = [single(&texts[0], one), single(&texts[1], other)];
    let pair = |place: usize| {
        let line = texts[0][place];
        (first[&line] == Some(place)).then(|| second.get(&line).copied().flatten()).flatten()
    };
    one.clone().filter_map(|place| Some((place, pair(place)?))).collect()
}

/// Returns the longest list of pairs, ascending by the first index, that also ascends by the second.
fn in_order(pairs: &[(usize, usize)]) -> Vec<(usize, usize)> {
    // The pair that ends the best list of each length, and its predecessor.
    let mut ends: Vec<usize> = Vec::new();
    let mut before: Vec<Option<usize>> = Vec::with_capacity(pairs.len());
    for (index, pair) in pairs.iter().enumerate() {
        let length = ends.partition_point(|&end| pairs[end].1 < pair.1);
        before.push(length.checked_sub(1).map(|shorter| ends[shorter]));
        if length == ends.len() { ends.push(index) } else { ends[length] = index }
    }
    let mut found = Vec::with_capacity(ends.len());
    let mut at = ends.last().copied();
    while let Some(index) = at {
        found.push(pairs[index]);
        at = before[index];
    }
    found.reverse();
    found
}

/// Joins consecutive pairs of lines to runs, with the unmatched lines between them.
fn joined(pairs: &[(usize, usize)], counts: [usize; 2]) -> Vec<LineRun> {
    let line = |place: usize| place as u32 + 1;
    let mut runs: Vec<LineRun> = Vec::new();
    let mut from = (0, 0);
    for &(a, b) in pairs.iter().chain([&(counts[0], counts[1])]) {
        if from != (a, b) {
            runs.push(LineRun { lines: [line(from.0)..line(a), line(from.1)..line(b)], is_same: false });
        }
        from = (a + 1, b + 1);
        if (a, b) == (counts[0], counts[1]) {
            break;
        }
        match runs.last_mut() {
            Some(LineRun { lines, is_same: true }) => lines.iter_mut().for_each(|lines| lines.end += 1),
            _ => runs.push(LineRun { lines: [line(a)..line(a + 1), line(b)..line(b + 1)], is_same: true }),
        }
    }
    runs
}
