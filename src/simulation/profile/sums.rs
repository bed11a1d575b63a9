//! The sums of the first values of long lists, kept at checkpoints.
//!
//! When a pulse begins, and how far along the path a segment does, is the sum of all that come before it. To keep each of
//! these sums takes a third of what the pulses themselves do. So one in [`EVERY`] is kept, with what Neumaier's summation
//! has lost so far, and those that follow are worked out from it: value by value, as they were the first time, and bit for
//! bit the same. Whoever goes along a list remembers the sums around where he is, and works each out once.
//!
//! ```text
//! values     | | | | | | | | | | | | | | | | | | | | | |
//! run        0------------------->0-------------------->       of each stretch its own
//! kept               *               *               *
//! ```

use crate::simulation::feed::Pulses;
use crate::simulation::running_sum::RunningSum;
use crate::simulation::toolpath::Segments;
use std::ops::Range;

/// One sum in so many is kept.
const EVERY: usize = 16;

/// Blocks of sums, each from one that is kept to the next, that are remembered: the pulses within one filter delay have
/// room.
const BLOCKS: usize = 4;

/// What is summed.
pub trait Values {
    /// The value with this index.
    fn value(&self, index: usize) -> f64;
}

/// How long pulses last, s.
impl Values for Pulses {
    #[inline]
    fn value(&self, index: usize) -> f64 {
        self.duration(index)
    }
}

/// How long segments are, mm.
impl Values for Segments {
    #[inline]
    fn value(&self, index: usize) -> f64 {
        self.length(index)
    }
}

/// The sums that are kept of a list, in which runs follow one another whose sums begin anew.
pub struct Checkpoints {
    /// The sum before each value whose index is a multiple of [`EVERY`], and of the last run the whole if it ends there.
    kept: Vec<RunningSum>,
    /// How many values were added.
    count: usize,
}

impl Checkpoints {
    /// Those of a list without values, with room for so many and no more.
    pub fn with_room(values: usize) -> Checkpoints {
        Checkpoints { kept: Vec::with_capacity(values / EVERY + 1), count: 0 }
    }

    /// Adds the values of a run.
    pub fn add_run(&mut self, values: impl Iterator<Item = f64>) {
        // Where the run before ended this one begins.
        self.kept.truncate(self.count.div_ceil(EVERY));
        let mut sum = RunningSum::default();
        self.keep(sum);
        for value in values {
            sum.add(value);
            self.count += 1;
            self.keep(sum);
        }
    }

    fn keep(&mut self, sum: RunningSum) {
        if self.count == EVERY * self.kept.len() {
            self.kept.push(sum);
        }
    }

    /// The sum of the values of a run, which begins with the index `first`, before `index`.
    pub fn before(&self, values: &impl Values, first: usize, index: usize) -> f64 {
        let (from, mut sum) = self.last_kept(first, index);
        (from..index).for_each(|index| sum.add(values.value(index)));
        sum.value()
    }

    /// The last sum of a run that is kept before `index`, and where.
    fn last_kept(&self, first: usize, index: usize) -> (usize, RunningSum) {
        let kept = index / EVERY;
        if kept * EVERY <= first { (first, RunningSum::default()) } else { (kept * EVERY, self.kept[kept]) }
    }

    /// For how many sums there is room.
    #[cfg(test)]
    pub fn room(&self) -> usize {
        self.kept.capacity()
    }
}

/// The sums of one run, of which those are remembered that were asked for last.
pub struct Sums<'a, V> {
    checkpoints: &'a Checkpoints,
    values: &'a V,
    /// The indices before which there is a sum.
    range: Range<usize>,
    /// Which blocks are remembered, each at its remainder.
    blocks: [usize; BLOCKS],
    /// Their sums, each at the remainder of its index.
    sums: [f64; BLOCKS * EVERY],
}

impl<'a, V: Values> Sums<'a, V> {
    /// Those before each of these indices, which are of one run from its beginning on.
    pub fn of(checkpoints: &'a Checkpoints, values: &'a V, range: Range<usize>) -> Sums<'a, V> {
        Sums { checkpoints, values, range, blocks: [usize::MAX; BLOCKS], sums: [0.0; BLOCKS * EVERY] }
    }

    /// The sum before `index`.
    #[inline]
    pub fn before(&mut self, index: usize) -> f64 {
        self.work_out(index / EVERY);
        self.sums[index % self.sums.len()]
    }

    /// The first index from `from` on whose sum, with `more` added, is above `limit`; where there is none the end of the
    /// run. Sums do not fall.
    #[inline]
    pub fn first_above(&mut self, from: usize, more: f64, limit: f64) -> usize {
        let (number, end) = (from / EVERY, self.range.end);
        if end <= from {
            return end;
        }
        // Most are near.
        let is_within = |sum: f64| sum + more <= limit;
        let sums = &self.block(number)[from % EVERY..];
        match sums.iter().position(|&sum| !is_within(sum)) {
            Some(after) if from + after < end => from + after,
            _ => self.first_above_in(number + 1, more, limit),
        }
    }

    /// The same in the blocks from `number` on.
    #[inline(never)]
    fn first_above_in(&mut self, number: usize, more: f64, limit: f64) -> usize {
        let end = self.range.end;
        let Some(kept) = self.checkpoints.kept.get(number..end.div_ceil(EVERY)) else { return end };
        let is_within = |sum: f64| sum + more <= limit;
        let mut reach = 1;
        while reach < kept.len() && is_within(kept[reach].value()) {
            reach *= 2;
        }
        let near = &kept[..reach.min(kept.len())];
        let begun = near.partition_point(|sum| is_within(sum.value()));
        if begun == 0 {
            return end.min(number * EVERY);
        }
        let last = number + begun - 1;
        let sums = &self.block(last)[..EVERY.min(end - last * EVERY)];
        last * EVERY + sums.partition_point(|&sum| is_within(sum))
    }

    /// The sums of a block, of which those have a meaning that are of the run.
    #[inline]
    fn block(&mut self, number: usize) -> &[f64] {
        self.work_out(number);
        &self.sums[number % BLOCKS * EVERY..][..EVERY]
    }

    /// Has a block remembered.
    #[inline]
    fn work_out(&mut self, number: usize) {
        if self.blocks[number % BLOCKS] != number {
            self.work_out_anew(number);
        }
    }

    #[inline(never)]
    fn work_out_anew(&mut self, number: usize) {
        self.blocks[number % BLOCKS] = number;
        let (from, mut sum) = self.checkpoints.last_kept(self.range.start, number * EVERY);
        let end = self.range.end.min((number + 1) * EVERY);
        for index in from..end {
            self.sums[index % (BLOCKS * EVERY)] = sum.value();
            // There may be no value behind the last sum.
            if index + 1 < end {
                sum.add(self.values.value(index));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::running_sum::running_sum;
    use crate::simulation::toolpath::random::Random;

    impl Values for Vec<f64> {
        fn value(&self, index: usize) -> f64 {
            self[index]
        }
    }

    /// Values of all sizes, of which sums lose digits, and runs of them.
    fn random_runs(random: &mut Random) -> (Vec<f64>, Vec<Range<usize>>) {
        let mut value = || (1 + random.below(999)) as f64 * 0.1f64.powi(random.below(18) as i32 - 2);
        let values: Vec<f64> = (0..400).map(|_| value()).collect();
        let (mut runs, mut end) = (Vec::new(), 0);
        while end < values.len() {
            let begin = end;
            let longest = [3, 20, 400][random.below(3)];
            end = values.len().min(begin + 1 + random.below(longest));
            runs.push(begin..end);
        }
        (values, runs)
    }

    /// What is kept of these runs, in the room that was made for it.
    fn kept(values: &[f64], runs: &[Range<usize>]) -> Checkpoints {
        let mut checkpoints = Checkpoints::with_room(values.len());
        let room = checkpoints.room();
        runs.iter().for_each(|run| checkpoints.add_run(values[run.clone()].iter().copied()));
        assert_eq!(checkpoints.room(), room);
        checkpoints
    }

    /// The sums before each value of a run, and the whole.
    fn plain_sums(values: &[f64], run: &Range<usize>) -> Vec<f64> {
        [0.0].into_iter().chain(running_sum(values[run.clone()].iter().copied())).collect()
    }

    #[test]
    fn sums_are_those_of_all_values_bit_for_bit() {
        let mut random = Random(0x5a5);
        for _ in 0..100 {
            let (values, runs) = random_runs(&mut random);
            let checkpoints = kept(&values, &runs);
            let last = runs.len() - 1;
            for (number, run) in runs.iter().enumerate() {
                let expected = plain_sums(&values, run);
                // Behind the last value of all there is a sum as well.
                let range = run.start..run.end + usize::from(number == last);
                let mut sums = Sums::of(&checkpoints, &values, range.clone());
                let there = range.clone().chain(range.clone().rev());
                let anywhere = (0..50).map(|_| range.start + random.below(range.len()));
                for index in there.chain(anywhere) {
                    let bits = expected[index - run.start].to_bits();
                    assert_eq!(sums.before(index).to_bits(), bits, "{index} of {run:?}");
                    assert_eq!(checkpoints.before(&values, run.start, index).to_bits(), bits);
                }
            }
        }
    }

    #[test]
    fn the_first_sum_above_a_limit_is_found_from_anywhere() {
        let mut random = Random(0xf1d);
        for _ in 0..100 {
            let (values, runs) = random_runs(&mut random);
            let checkpoints = kept(&values, &runs);
            for run in runs {
                let all = &plain_sums(&values, &run)[..run.len()];
                let mut sums = Sums::of(&checkpoints, &values, run.clone());
                for _ in 0..50 {
                    let from = random.below(run.len());
                    let more = [0.0, 0.25][random.below(2)];
                    // At a sum, beside one, and beyond all of them.
                    let limit = all[random.below(run.len())] * [0.5, 1.0, 1.0, 2.0][random.below(4)] + more;
                    let above = all[from..].partition_point(|sum| sum + more <= limit);
                    let found = sums.first_above(run.start + from, more, limit);
                    assert_eq!(found, run.start + from + above, "from {from} of {run:?} up to {limit}");
                }
            }
        }
    }

    #[test]
    fn a_list_without_values_has_one_sum() {
        let mut checkpoints = Checkpoints::with_room(0);
        checkpoints.add_run([].into_iter());
        let values: Vec<f64> = Vec::new();
        assert_eq!(checkpoints.before(&values, 0, 0), 0.0);
        assert_eq!(Sums::of(&checkpoints, &values, 0..1).before(0), 0.0);
    }
}
