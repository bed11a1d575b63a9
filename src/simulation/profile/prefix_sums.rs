//! Prefix sums of long lists, kept at checkpoints.
//!
//! A pulse begins at the sum of the durations before it, and a segment at the sum of the lengths before it.
//! All these sums would take a third of the memory of the pulses. Therefore only one in
//! [`CHECKPOINT_SPACING`] is kept, with the compensation of Neumaier's summation; the others are computed
//! from it value by value, with the same bits as the first time. [`PrefixSums`] remembers the sums near the
//! last query.
//!
//! ```text
//! values     | | | | | | | | | | | | | | | | | | | | | |
//! run        0------------------->0-------------------->       of each rest-to-rest motion its own
//! kept               *               *               *
//! ```

use crate::simulation::feed::Pulses;
use crate::simulation::running_sum::RunningSum;
use crate::simulation::toolpath::Segments;
use std::ops::Range;

/// Number of values from one kept sum to the next.
const CHECKPOINT_SPACING: usize = 16;

/// Number of remembered blocks, each from one checkpoint to the next: enough for the pulses within one filter
/// delay.
const REMEMBERED_BLOCKS: usize = 4;

/// A list of values to sum.
pub trait SummedValues {
    /// Returns the value at `index`.
    fn value(&self, index: usize) -> f64;
}

/// Durations of pulses, s.
impl SummedValues for Pulses {
    #[inline]
    fn value(&self, index: usize) -> f64 {
        self.duration(index)
    }
}

/// Lengths of segments, mm.
impl SummedValues for Segments {
    #[inline]
    fn value(&self, index: usize) -> f64 {
        self.length(index)
    }
}

/// Checkpoints of a list of consecutive runs, each with sums that begin at 0.
pub struct SumCheckpoints {
    /// The sum before each value whose index is a multiple of [`CHECKPOINT_SPACING`], and the total of the
    /// last run if it ends there.
    kept: Vec<RunningSum>,
    /// Number of values added.
    count: usize,
}

impl SumCheckpoints {
    /// Returns empty checkpoints with the exact capacity for `values` values.
    pub fn with_room(values: usize) -> SumCheckpoints {
        SumCheckpoints { kept: Vec::with_capacity(values / CHECKPOINT_SPACING + 1), count: 0 }
    }

    /// Adds the values of a run.
    pub fn add_run(&mut self, values: impl Iterator<Item = f64>) {
        // This run begins where the last one ended.
        self.kept.truncate(self.count.div_ceil(CHECKPOINT_SPACING));
        let mut sum = RunningSum::default();
        self.keep(sum);
        for value in values {
            sum.add(value);
            self.count += 1;
            self.keep(sum);
        }
    }

    fn keep(&mut self, sum: RunningSum) {
        if self.count == CHECKPOINT_SPACING * self.kept.len() {
            self.kept.push(sum);
        }
    }

    /// Returns the sum of the values of a run, which begins at the index `first`, before `index`.
    pub fn before(&self, values: &impl SummedValues, first: usize, index: usize) -> f64 {
        let (from, mut sum) = self.last_kept(first, index);
        (from..index).for_each(|index| sum.add(values.value(index)));
        sum.value()
    }

    /// Returns the index and value of the last checkpoint of a run before `index`.
    fn last_kept(&self, first: usize, index: usize) -> (usize, RunningSum) {
        let kept = index / CHECKPOINT_SPACING;
        if kept * CHECKPOINT_SPACING <= first {
            (first, RunningSum::default())
        } else {
            (kept * CHECKPOINT_SPACING, self.kept[kept])
        }
    }

    /// Returns the capacity, in sums.
    #[cfg(test)]
    pub fn room(&self) -> usize {
        self.kept.capacity()
    }
}

/// The prefix sums of one run, which remembers those near the last query.
pub struct PrefixSums<'a, V> {
    checkpoints: &'a SumCheckpoints,
    values: &'a V,
    /// The indices that have a sum.
    range: Range<usize>,
    /// Numbers of the remembered blocks, each at the place of its remainder by [`REMEMBERED_BLOCKS`].
    blocks: [usize; REMEMBERED_BLOCKS],
    /// Sums of the remembered blocks, each at the place of the remainder of its index.
    sums: [f64; REMEMBERED_BLOCKS * CHECKPOINT_SPACING],
}

impl<'a, V: SummedValues> PrefixSums<'a, V> {
    /// Returns the prefix sums of the values in `range`, a run from its beginning.
    pub fn of(checkpoints: &'a SumCheckpoints, values: &'a V, range: Range<usize>) -> PrefixSums<'a, V> {
        PrefixSums {
            checkpoints,
            values,
            range,
            blocks: [usize::MAX; REMEMBERED_BLOCKS],
            sums: [0.0; REMEMBERED_BLOCKS * CHECKPOINT_SPACING],
        }
    }

    /// Returns the sum before `index`.
    #[inline]
    pub fn before(&mut self, index: usize) -> f64 {
        self.ensure_block(index / CHECKPOINT_SPACING);
        self.sums[index % self.sums.len()]
    }

    /// Returns the first index from `from` on whose sum plus `more` exceeds `limit`, or the end of the run.
    /// Sums do not decrease.
    #[inline]
    pub fn first_above(&mut self, from: usize, more: f64, limit: f64) -> usize {
        let (number, end) = (from / CHECKPOINT_SPACING, self.range.end);
        if end <= from {
            return end;
        }
        // Most results are near.
        let is_within = |sum: f64| sum + more <= limit;
        let sums = &self.block(number)[from % CHECKPOINT_SPACING..];
        match sums.iter().position(|&sum| !is_within(sum)) {
            Some(after) if from + after < end => from + after,
            _ => self.first_above_in(number + 1, more, limit),
        }
    }

    /// Searches as [`first_above`](Self::first_above) does, in the blocks from `number` on.
    #[inline(never)]
    fn first_above_in(&mut self, number: usize, more: f64, limit: f64) -> usize {
        let end = self.range.end;
        let Some(kept) = self.checkpoints.kept.get(number..end.div_ceil(CHECKPOINT_SPACING)) else {
            return end;
        };
        let is_within = |sum: f64| sum + more <= limit;
        let mut reach = 1;
        while reach < kept.len() && is_within(kept[reach].value()) {
            reach *= 2;
        }
        let near = &kept[..reach.min(kept.len())];
        let begun = near.partition_point(|sum| is_within(sum.value()));
        if begun == 0 {
            return end.min(number * CHECKPOINT_SPACING);
        }
        let last = number + begun - 1;
        let sums = &self.block(last)[..CHECKPOINT_SPACING.min(end - last * CHECKPOINT_SPACING)];
        last * CHECKPOINT_SPACING + sums.partition_point(|&sum| is_within(sum))
    }

    /// Returns the sums of a block; only those of the run are meaningful.
    #[inline]
    fn block(&mut self, number: usize) -> &[f64] {
        self.ensure_block(number);
        &self.sums[number % REMEMBERED_BLOCKS * CHECKPOINT_SPACING..][..CHECKPOINT_SPACING]
    }

    /// Makes sure that a block is remembered.
    #[inline]
    fn ensure_block(&mut self, number: usize) {
        if self.blocks[number % REMEMBERED_BLOCKS] != number {
            self.compute_block(number);
        }
    }

    #[inline(never)]
    fn compute_block(&mut self, number: usize) {
        self.blocks[number % REMEMBERED_BLOCKS] = number;
        let (from, mut sum) = self.checkpoints.last_kept(self.range.start, number * CHECKPOINT_SPACING);
        let end = self.range.end.min((number + 1) * CHECKPOINT_SPACING);
        for index in from..end {
            self.sums[index % (REMEMBERED_BLOCKS * CHECKPOINT_SPACING)] = sum.value();
            // The last sum may have no value behind it.
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

    impl SummedValues for Vec<f64> {
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

    /// Returns the checkpoints of these runs, and asserts that they fit the reserved capacity.
    fn kept(values: &[f64], runs: &[Range<usize>]) -> SumCheckpoints {
        let mut checkpoints = SumCheckpoints::with_room(values.len());
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
                let mut sums = PrefixSums::of(&checkpoints, &values, range.clone());
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
                let mut sums = PrefixSums::of(&checkpoints, &values, run.clone());
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
        let mut checkpoints = SumCheckpoints::with_room(0);
        checkpoints.add_run([].into_iter());
        let values: Vec<f64> = Vec::new();
        assert_eq!(checkpoints.before(&values, 0, 0), 0.0);
        assert_eq!(PrefixSums::of(&checkpoints, &values, 0..1).before(0), 0.0);
    }
}
