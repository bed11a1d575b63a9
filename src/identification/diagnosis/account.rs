//! The account of a diagnosis: how the simulated time becomes the recorded one.
//!
//! ```text
//! simulated + calibration + Σ causes + unexplained = recorded
//! ```
//!
//! Each entry is a time between the first and the last mark of a run, by the recorder's clock as the machine file has
//! it, so that a wrong clock is a cause like any other. With T(S) for the simulated time with the causes S:
//!
//! | entry | seconds |
//! |---|---|
//! | simulated | the time on the machine of the file |
//! | calibration | T(none) − simulated, if the machine was calibrated before the search for causes |
//! | a cause | its share of T(all) − T(none) |
//! | unexplained | recorded − T(all) |
//!
//! The time that a cause adds depends on the causes that act already: a slow axis costs less where an override slows
//! the feed. In one order of the causes, the times that each adds to those before it sum to T(all) − T(none), and
//! nothing counts twice. The share of a cause is the mean over several orders, so the shares have the same sum and
//! prefer no cause:
//!
//! | causes | orders | |
//! |---|---|---|
//! | up to [`ALL_ORDERS`] | all n!, which need 2ⁿ simulations | the value of Shapley (1953) |
//! | more, mostly holds | as they act, and backwards, which need 2n simulations | the Shapley value up to pairs |
//!
//! Up to pairs means: T(all) − T(none) is the sum of the effects of each cause alone, of each pair only together, of
//! each three only together, and so on. The effect of a pair counts for the later of the two, which is one of them in
//! one direction and the other one backwards: each gets half, as over all orders. The effects of three and more are
//! not shared evenly.
//!
//! Unexplained times of different regions may cancel. `unexplained_sum` adds up their sizes region by region, so it is
//! never less than the size of `unexplained`.

use crate::identification::alignment::{ProgramPlace, times};
use crate::identification::comparison::Comparison;
use crate::identification::diagnosis::evidence::{Candidate, with_all};
use crate::identification::diagnosis::regions;
use crate::identification::effects::Effect;
use crate::identification::fit::Run;
use crate::machine::Machine;
use crate::simulation::feed::FeedPlan;

/// Maximum number of causes for which the share is the mean over all orders.
const ALL_ORDERS: usize = 4;

/// The account of one run or of several together. All entries are in s.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Account {
    /// Simulated time on the machine of the file.
    pub simulated: f64,
    /// Time that calibrating the machine first adds; `None` if the machine was not calibrated first.
    pub calibration: Option<f64>,
    /// Causes with the time that each adds, its share.
    pub causes: Vec<(Effect, f64)>,
    /// Recorded time less the simulated one with all causes.
    pub unexplained: f64,
    /// Unexplained time with the sizes of the regions added up, so that lost and gained times do not cancel.
    pub unexplained_sum: f64,
    /// Recorded time.
    pub recorded: f64,
}

impl Account {
    /// Returns the account of several runs together, all with the same causes.
    pub fn together(accounts: &[Account]) -> Account {
        let Some((first, others)) = accounts.split_first() else { return Account::default() };
        others.iter().fold(first.clone(), |mut sum, account| {
            sum.simulated += account.simulated;
            sum.calibration = sum.calibration.zip(account.calibration).map(|(a, b)| a + b);
            sum.causes.iter_mut().zip(&account.causes).for_each(|(sum, own)| sum.1 += own.1);
            sum.unexplained += account.unexplained;
            sum.unexplained_sum += account.unexplained_sum;
            sum.recorded += account.recorded;
            sum
        })
    }

    /// Returns the account with its causes in another order; `order` holds their present indices.
    pub fn reordered(self, order: &[usize]) -> Account {
        Account { causes: order.iter().map(|at| self.causes[*at]).collect(), ..self }
    }
}

/// The steps from the machine of the file to the one with all causes.
#[derive(Clone, Copy)]
pub struct Steps<'a> {
    /// The machine of the file.
    pub believed: &'a Machine,
    /// The machine calibrated from the recording; `None` if the search for causes began with the machine file.
    pub calibrated: Option<&'a Machine>,
    /// Causes in the order in which they act.
    pub causes: &'a [Candidate],
}

impl Steps<'_> {
    /// Returns the machine with some of the causes, given by their indices in ascending order.
    fn machine(&self, causes: &[usize]) -> Machine {
        let start = self.calibrated.unwrap_or(self.believed);
        with_all(start, &causes.iter().map(|at| self.causes[*at].clone()).collect::<Vec<_>>())
    }
}

/// Returns the account of each run. `after` holds the comparisons with the machine that has all causes.
pub fn accounts(steps: &Steps, runs: &[Run], after: &[Comparison]) -> Vec<Account> {
    let Steps { believed, calibrated, causes } = steps;
    let clock = believed.recorder.clock_ratio;
    let by_clock = |machine: &Machine| {
        simulated(machine, runs).into_iter().map(|time| time / clock).collect::<Vec<f64>>()
    };
    let by_set = |set: &[usize]| by_clock(&steps.machine(set));
    let Shares { without, each, with } = shares(causes.len(), by_set);
    let believed_in = if calibrated.is_some() { by_clock(believed) } else { without.clone() };
    let fitted = steps.machine(&(0..causes.len()).collect::<Vec<_>>());
    let of_run = |(at, (run, after)): (usize, (&Run, &Comparison))| {
        let marks = &run.alignment.marks;
        let recorded =
            marks.last().zip(marks.first()).map_or(0.0, |(last, first)| last.time - first.time) / clock;
        let unexplained = recorded - with[at];
        let sizes = regions::sizes(after, &run.by_clock(&fitted)) * fitted.recorder.clock_ratio / clock;
        Account {
            simulated: believed_in[at],
            calibration: calibrated.map(|_| without[at] - believed_in[at]),
            causes: causes.iter().zip(&each).map(|(cause, own)| (cause.hypothesis.effect, own[at])).collect(),
            unexplained,
            // Both say the same of the ends of the run, but for the last digits.
            unexplained_sum: sizes.max(unexplained.abs()),
            recorded,
        }
    };
    runs.iter().zip(after).enumerate().map(of_run).collect()
}

/// Returns the simulated time between the first and the last mark of each run, s by the clock of the recorder.
/// Consecutive runs of one program share their plan.
fn simulated(machine: &Machine, runs: &[Run]) -> Vec<f64> {
    let mut last: Option<(&Run, FeedPlan)> = None;
    let of_run = |run| {
        let plan = match last.take() {
            Some((before, plan)) if before.is_like(run, machine) => plan,
            _ => run.plan(machine),
        };
        let marks = &run.alignment.marks;
        let ends: Vec<ProgramPlace> =
            marks.first().into_iter().chain(marks.last()).map(|mark| mark.place).collect();
        let times = times(run.toolpath, &plan, &ends);
        last = Some((run, plan));
        times.last().zip(times.first()).map_or(0.0, |(end, begin)| end - begin) * machine.recorder.clock_ratio
    };
    runs.iter().map(of_run).collect()
}

/// The shares of a number of causes, run by run. All times are in s.
struct Shares {
    /// Times of the runs without any cause.
    without: Vec<f64>,
    /// Times that each cause adds, by cause and run.
    each: Vec<Vec<f64>>,
    /// Times of the runs with all causes.
    with: Vec<f64>,
}

/// Returns the shares of `causes` causes. `times` returns the times of the runs with some of the causes, given by their
/// indices in ascending order; it is called once for each set.
fn shares(causes: usize, times: impl Fn(&[usize]) -> Vec<f64>) -> Shares {
    let mut known: Vec<(Vec<usize>, Vec<f64>)> = Vec::new();
    let mut of = |set: &[usize]| {
        if let Some((_, found)) = known.iter().find(|(own, _)| own == set) {
            return found.clone();
        }
        known.push((set.to_vec(), times(set)));
        known[known.len() - 1].1.clone()
    };
    let without = of(&[]);
    let with = of(&(0..causes).collect::<Vec<usize>>());
    let mut each = vec![vec![0.0; without.len()]; causes];
    let orders = orders(causes);
    for order in &orders {
        let mut set: Vec<usize> = Vec::new();
        let mut before = without.clone();
        for cause in order {
            set.insert(set.partition_point(|other| other < cause), *cause);
            let after = of(&set);
            for (share, (after, before)) in each[*cause].iter_mut().zip(after.iter().zip(&before)) {
                *share += (after - before) / orders.len() as f64;
            }
            before = after;
        }
    }
    Shares { without, each, with }
}

/// Returns the orders of causes over which a share is the mean.
fn orders(causes: usize) -> Vec<Vec<usize>> {
    if causes <= ALL_ORDERS {
        return permutations(causes);
    }
    vec![(0..causes).collect(), (0..causes).rev().collect()]
}

/// Returns all orders of the numbers below `count`.
fn permutations(count: usize) -> Vec<Vec<usize>> {
    let Some(last) = count.checked_sub(1) else { return vec![Vec::new()] };
    let with_last = |order: Vec<usize>| {
        (0..count).map(move |place| {
            let mut order = order.clone();
            order.insert(place, last);
            order
        })
    };
    permutations(last).into_iter().flat_map(with_last).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    /// The times of causes that add `alone`, with `pair` more for every two of them that act together.
    fn in_pairs(alone: &[f64], pair: fn(usize, usize) -> f64, set: &[usize]) -> Vec<f64> {
        let pairs = set.iter().flat_map(|a| set.iter().filter(move |b| a < b).map(move |b| pair(*a, *b)));
        vec![10.0 + set.iter().map(|at| alone[*at]).sum::<f64>() + pairs.sum::<f64>()]
    }

    #[test]
    fn what_two_do_only_together_is_halved_whatever_the_number_of_causes() {
        let pair = |a: usize, b: usize| 0.01 * (a + 1) as f64 * (b + 1) as f64;
        for count in 0..9 {
            let alone: Vec<f64> = (0..count).map(|at| at as f64 - 2.5).collect();
            let Shares { each, .. } = shares(count, |set| in_pairs(&alone, pair, set));
            for (at, own) in each.iter().enumerate() {
                let others = (0..count).filter(|other| *other != at);
                let wanted = alone[at] + others.map(|other| 0.5 * pair(at, other)).sum::<f64>();
                assert!((own[0] - wanted).abs() < 1e-12, "{at} of {count}: {} is not {wanted}", own[0]);
            }
        }
    }

    #[test]
    fn what_three_do_only_together_falls_to_each_alike() {
        let times = |set: &[usize]| vec![if set.len() == 3 { 0.9 } else { 0.0 }];
        let Shares { each, .. } = shares(3, times);
        assert!(each.iter().all(|own| (own[0] - 0.3).abs() < 1e-12), "{each:?}");
    }

    #[test]
    fn shares_sum_up_and_each_set_is_simulated_once() {
        for count in 0..8 {
            let asked: RefCell<Vec<Vec<usize>>> = RefCell::default();
            let times = |set: &[usize]| {
                asked.borrow_mut().push(set.to_vec());
                // The largest of them alone counts, and less in the second run.
                let most = set.iter().map(|at| 1.0 + *at as f64).fold(0.0, f64::max);
                vec![5.0 + most, 5.0 + 0.3 * most.sqrt()]
            };
            let Shares { without, each, with } = shares(count, times);
            for run in 0..2 {
                let sum: f64 = each.iter().map(|own| own[run]).sum();
                assert!((without[run] + sum - with[run]).abs() < 1e-12, "{count} causes");
            }
            let mut asked = asked.into_inner();
            let all = asked.len();
            asked.sort();
            asked.dedup();
            assert_eq!(asked.len(), all, "{count} causes: none is simulated twice");
            assert_eq!(all, if count <= ALL_ORDERS { 1 << count } else { 2 * count }, "{count} causes");
        }
    }
}
