//! The account of a diagnosis in hundredths of a second: as data, as a table and as a waterfall.
//!
//! Entries that are rounded one by one would no longer add up to the recorded time. Recorded and simulated
//! time are rounded; the entries between them that were rounded farthest in the opposite direction absorb the
//! difference, so that no entry of a few is off by more than a hundredth. An account of several runs is the
//! sum of their rounded accounts.

use serde::Serialize;

use crate::identification::diagnosis::Account;
use crate::project::recording::comparison::signed;
use crate::simulation::ordered::sort_by_number;

/// Id of the step from the machine file to the calibrated machine.
const CALIBRATION_ID: &str = "calibration";
/// Least part of the width that the steps of a waterfall occupy: if they are a smaller part of the time, its
/// bars do not begin at 0.
const MIN_STEPS_SHARE: f64 = 0.5;
/// Part of the width before the lowest step in bars that do not begin at 0.
const LEADING_SHARE: f64 = 0.2;

/// An account for people and programs.
#[derive(Clone, Debug, Serialize)]
pub struct AccountRow {
    simulated_s: f64,
    /// Ids and seconds, the largest first.
    causes_s: Vec<(&'static str, f64)>,
    unexplained_s: f64,
    /// Sum of the sizes of the unexplained times of all regions, without cancellation.
    unexplained_sum_s: f64,
    recorded_s: f64,
    /// Time at which the bars begin; above 0 if the steps would be too small to see next to the whole.
    begins_s: f64,
    /// The account of each run, if there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    runs: Vec<AccountRow>,
    /// Rows of the table for people; empty for one run among several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    steps: Vec<WaterfallStep>,
    /// Notes on parts that the table does not show, for people.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<String>,
    #[serde(skip)]
    pub(super) balance: RoundedAccount,
}

/// A row of the table, with its bar.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WaterfallStep {
    pub name: String,
    /// Seconds with unit, and a sign for added ones.
    pub text: String,
    /// `total`, `cause` or `unexplained`.
    pub kind: &'static str,
    /// Beginning and end of the bar, as parts of the width.
    pub bar: [f64; 2],
}

/// An account in hundredths of a second.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RoundedAccount {
    pub simulated: i64,
    pub calibration: Option<i64>,
    pub causes: Vec<i64>,
    pub unexplained: i64,
    pub unexplained_sum: i64,
    pub recorded: i64,
}

impl RoundedAccount {
    /// Rounds an account so that it adds up.
    fn of(account: &Account) -> RoundedAccount {
        let round = |seconds: f64| (100.0 * seconds).round() as i64;
        let (simulated, recorded) = (round(account.simulated), round(account.recorded));
        // The unexplained part comes first: of two entries that are equally far off, it absorbs the
        // difference.
        let entries: Vec<f64> = ([account.unexplained].into_iter())
            .chain(account.calibration)
            .chain(account.causes.iter().map(|(_, seconds)| *seconds))
            .map(|seconds| 100.0 * seconds)
            .collect();
        let mut rounded = added_up(&entries, recorded - simulated).into_iter();
        let unexplained = rounded.next().unwrap_or(0);
        let calibration = account.calibration.and_then(|_| rounded.next());
        let unexplained_sum = round(account.unexplained_sum).max(unexplained.abs());
        RoundedAccount {
            simulated,
            calibration,
            causes: rounded.collect(),
            unexplained,
            unexplained_sum,
            recorded,
        }
    }

    fn together(all: &[RoundedAccount]) -> RoundedAccount {
        let Some((first, others)) = all.split_first() else { return RoundedAccount::default() };
        others.iter().fold(first.clone(), |sum, own| RoundedAccount {
            simulated: sum.simulated + own.simulated,
            calibration: sum.calibration.zip(own.calibration).map(|(a, b)| a + b),
            causes: sum.causes.iter().zip(&own.causes).map(|(a, b)| a + b).collect(),
            unexplained: sum.unexplained + own.unexplained,
            unexplained_sum: sum.unexplained_sum + own.unexplained_sum,
            recorded: sum.recorded + own.recorded,
        })
    }

    /// Returns calibration and causes by id and name, the largest first.
    fn entries(&self, causes: &[(&'static str, String)]) -> Vec<(&'static str, String, i64)> {
        let calibration = self.calibration.map(|own| (CALIBRATION_ID, CALIBRATION_ID.to_string(), own));
        let causes = causes.iter().zip(&self.causes).map(|((id, name), own)| (*id, name.clone(), *own));
        let mut all: Vec<_> = calibration.into_iter().chain(causes).collect();
        sort_by_number(&mut all, |(.., own)| -own.abs() as f64);
        all
    }
}

/// Returns whole numbers as close to `entries` as possible that add up to `sum`.
fn added_up(entries: &[f64], sum: i64) -> Vec<i64> {
    let mut rounded: Vec<i64> = entries.iter().map(|entry| entry.round() as i64).collect();
    loop {
        let missing = (sum - rounded.iter().sum::<i64>()).signum();
        let behind = |at: usize| missing as f64 * (entries[at] - rounded[at] as f64);
        let farthest = (0..entries.len()).rev().max_by(|a, b| behind(*a).total_cmp(&behind(*b)));
        match farthest {
            Some(at) if missing != 0 => rounded[at] += missing,
            _ => return rounded,
        }
    }
}

/// Converts hundredths of a second to seconds.
pub fn seconds_of(hundredths: i64) -> f64 {
    hundredths as f64 / 100.0
}

/// Formats hundredths of a second.
pub fn written(hundredths: i64) -> String {
    format!("{:.2} s", seconds_of(hundredths)).replace('-', "−")
}

/// Formats hundredths of a second as an added amount, with its sign.
fn added(hundredths: i64) -> String {
    signed(format!("{:+.2} s", seconds_of(hundredths)))
}

impl AccountRow {
    /// Returns the row of the accounts of all runs, with id and name of each cause.
    pub fn new(accounts: &[Account], causes: &[(&'static str, String)]) -> AccountRow {
        let balances: Vec<RoundedAccount> = accounts.iter().map(RoundedAccount::of).collect();
        let mut row = AccountRow::figures(RoundedAccount::together(&balances), causes);
        if 1 < balances.len() {
            row.runs = balances.into_iter().map(|own| AccountRow::figures(own, causes)).collect();
        }
        let from = row.begins();
        row.begins_s = seconds_of(from);
        row.steps = row.waterfall(causes, from);
        row.notes.push(format!(
            "Unexplained, added up region by region: {}.",
            written(row.balance.unexplained_sum)
        ));
        if from != 0 {
            row.notes.push(format!("The bars begin at {}.", written(from)));
        }
        row
    }

    fn figures(balance: RoundedAccount, causes: &[(&'static str, String)]) -> AccountRow {
        AccountRow {
            simulated_s: seconds_of(balance.simulated),
            causes_s: (balance.entries(causes).into_iter())
                .map(|(id, _, own)| (id, seconds_of(own)))
                .collect(),
            unexplained_s: seconds_of(balance.unexplained),
            unexplained_sum_s: seconds_of(balance.unexplained_sum),
            recorded_s: seconds_of(balance.recorded),
            begins_s: 0.0,
            runs: Vec::new(),
            steps: Vec::new(),
            notes: Vec::new(),
            balance,
        }
    }

    /// Returns the time after each step, from the simulated to the recorded one.
    fn levels(&self) -> Vec<i64> {
        let RoundedAccount { simulated, calibration, causes, unexplained, .. } = &self.balance;
        let mut steps: Vec<i64> = calibration.iter().chain(causes).copied().collect();
        sort_by_number(&mut steps, |own| -own.abs() as f64);
        let mut levels = vec![*simulated];
        levels.extend(steps.into_iter().chain([*unexplained]).scan(*simulated, |level, own| {
            *level += own;
            Some(*level)
        }));
        levels
    }

    /// Returns the time at which the bars begin: 0, unless the steps would be too small next to the whole.
    fn begins(&self) -> i64 {
        let levels = self.levels();
        let (lowest, highest) = (levels.iter().min().unwrap_or(&0), levels.iter().max().unwrap_or(&0));
        let spread = (highest - lowest) as f64;
        let before = (LEADING_SHARE / (1.0 - LEADING_SHARE) * spread).ceil() as i64;
        if spread == 0.0 || MIN_STEPS_SHARE * *highest as f64 <= spread {
            0
        } else {
            (lowest - before).max(0)
        }
    }

    /// Returns the rows of the table, with bars that begin at `from`.
    fn waterfall(&self, causes: &[(&'static str, String)], from: i64) -> Vec<WaterfallStep> {
        let RoundedAccount { simulated, unexplained, recorded, .. } = self.balance;
        let levels = self.levels();
        let width = (levels.iter().max().unwrap_or(&0) - from).max(1) as f64;
        let part = |level: i64| ((level - from) as f64 / width).clamp(0.0, 1.0);
        let total = |name: &str, level: i64| WaterfallStep {
            name: name.to_string(),
            text: written(level),
            kind: "total",
            bar: [0.0, part(level)],
        };
        let entries = self.balance.entries(causes).into_iter().map(|(_, name, own)| (name, own, "cause"));
        let entries = entries.chain([("unexplained".to_string(), unexplained, "unexplained")]);
        let step = |((name, own, kind), ends): ((String, i64, &'static str), &[i64])| WaterfallStep {
            name,
            text: added(own),
            kind,
            bar: [part(ends[0].min(ends[1])), part(ends[0].max(ends[1]))],
        };
        let steps = entries.zip(levels.windows(2)).map(step);
        [total("simulated", simulated)]
            .into_iter()
            .chain(steps)
            .chain([total("recorded", recorded)])
            .collect()
    }

    /// Returns the table with its notes, for a document or a page.
    pub fn table(&self) -> (&[WaterfallStep], &[String]) {
        (&self.steps, &self.notes)
    }

    /// Returns the table as lines of text in columns, with the note on the unexplained part below.
    pub fn to_text(&self) -> String {
        let width =
            |of: fn(&WaterfallStep) -> &str| self.steps.iter().map(|step| of(step).chars().count()).max();
        let (name, text) = (width(|step| &step.name).unwrap_or(0), width(|step| &step.text).unwrap_or(0));
        let row = |step: &WaterfallStep| format!("{:<name$}  {:>text$}\n", step.name, step.text);
        let rows: String = self.steps.iter().map(row).collect();
        rows + self.notes.first().map_or("", String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::effects::{AXIS_ACCELERATION_LIMIT, FEED_OVERRIDE};

    /// Numbers from 0 to below 1.
    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / 53f64.exp2()
    }

    fn account(simulated: f64, calibration: Option<f64>, causes: &[f64], unexplained: f64) -> Account {
        let effects = [AXIS_ACCELERATION_LIMIT, FEED_OVERRIDE].into_iter().cycle();
        let recorded = simulated + calibration.unwrap_or(0.0) + causes.iter().sum::<f64>() + unexplained;
        Account {
            simulated,
            calibration,
            causes: effects.zip(causes.iter().copied()).collect(),
            unexplained,
            unexplained_sum: unexplained.abs(),
            recorded,
        }
    }

    #[test]
    fn what_is_shown_adds_up_and_is_a_hundredth_off_at_most() {
        let mut state = 5;
        for case in 0..2000 {
            let mut within = |low: f64, high: f64| low + (high - low) * random(&mut state);
            let causes: Vec<f64> = (0..case % 6).map(|_| within(-3.0, 9.0)).collect();
            let calibration = (case % 4 == 0).then(|| within(-2.0, 2.0));
            let own = account(within(1.0, 900.0), calibration, &causes, within(-0.5, 0.5));
            let shown = RoundedAccount::of(&own);
            let entries =
                shown.causes.iter().sum::<i64>() + shown.calibration.unwrap_or(0) + shown.unexplained;
            assert_eq!(shown.simulated + entries, shown.recorded, "{own:?}");
            let pairs = shown.causes.iter().zip(&causes).map(|(shown, own)| (*shown, *own));
            let others = [(shown.simulated, own.simulated), (shown.recorded, own.recorded)];
            for (shown, own) in pairs.chain(others).chain([(shown.unexplained, own.unexplained)]) {
                assert!((shown as f64 - 100.0 * own).abs() <= 1.0, "{own} s is shown as {shown}");
            }
            assert!(shown.unexplained.abs() <= shown.unexplained_sum);
        }
    }

    #[test]
    fn runs_add_up_to_their_sum_as_shown() {
        let accounts =
            [1.004, 2.004, 3.004].map(|simulated| account(simulated, None, &[0.104, -0.004], 0.004));
        let names = [("axis_acceleration_limit", "a".to_string()), ("feed_override", "b".to_string())];
        let row = AccountRow::new(&accounts, &names);
        let sum = |of: fn(&AccountRow) -> f64| row.runs.iter().map(of).sum::<f64>();
        assert!((row.recorded_s - sum(|run| run.recorded_s)).abs() < 1e-9);
        assert!((row.unexplained_s - sum(|run| run.unexplained_s)).abs() < 1e-9);
        assert!((row.simulated_s - sum(|run| run.simulated_s)).abs() < 1e-9);
    }

    #[test]
    fn the_largest_comes_first_and_bars_join_each_other() {
        let names = [("axis_acceleration_limit", "a".to_string()), ("feed_override", "b".to_string())];
        let row = AccountRow::new(&[account(40.0, Some(-0.5), &[0.3, 4.0], 0.01)], &names);
        let ids: Vec<&str> = row.causes_s.iter().map(|(id, _)| *id).collect();
        assert_eq!(ids, ["feed_override", "calibration", "axis_acceleration_limit"]);
        let (steps, notes) = row.table();
        let shown: Vec<(&str, &str)> = steps.iter().map(|step| (&*step.name, &*step.text)).collect();
        let wanted = [
            ("simulated", "40.00 s"),
            ("b", "+4.00 s"),
            ("calibration", "−0.50 s"),
            ("a", "+0.30 s"),
            ("unexplained", "+0.01 s"),
            ("recorded", "43.81 s"),
        ];
        assert_eq!(shown, wanted);
        assert_eq!(steps[1].bar[0], steps[0].bar[1], "the first step begins where the simulated time ends");
        assert_eq!(steps[1].bar[1], 1.0, "the highest level is the width");
        assert_eq!((steps[2].bar[1], steps[5].bar[1]), (1.0, steps[4].bar[1]));
        assert!(steps.iter().all(|step| 0.0 <= step.bar[0] && step.bar[0] <= step.bar[1]));
        assert_eq!(row.begins_s, 39.0);
        assert_eq!(notes, ["Unexplained, added up region by region: 0.01 s.", "The bars begin at 39.00 s."]);
        let text = row.to_text();
        assert!(text.starts_with("simulated    40.00 s\nb            +4.00 s\n"), "{text}");
    }

    #[test]
    fn bars_begin_at_nothing_where_steps_are_much_of_the_time_or_there_are_none() {
        let names = [("feed_override", "b".to_string())];
        for own in [account(2.0, None, &[3.0], 0.0), account(5.0, None, &[0.0], 0.0)] {
            assert_eq!(AccountRow::new(&[own], &names).begins(), 0);
        }
    }
}
