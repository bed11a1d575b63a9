//! The summary of a diagnosis: the account in words, with the duration of the run, its difference from the
//! simulation, the causes, and the unexplained part.

use crate::identification::diagnosis::{Diagnosis, Pulsation, Verdict};
use crate::identification::effects::FEED_HOLD;
use crate::project::diagnosis::account::{RoundedAccount, seconds_of, written};
use crate::project::diagnosis::rows::CauseRow;
use crate::simulation::ordered::sort_by_number;

/// Most lines of halts that are named.
const MAX_NAMED_LINES: usize = 12;
/// Most causes that are named, the largest first.
const MAX_NAMED_CAUSES: usize = 4;
/// Least excess of the sum of the sizes of unexplained regions over their net at which the summary reports
/// the sum, hundredths of a second.
const MIN_CANCELLED_HUNDREDTHS: i64 = 5;
/// Least ratio of that sum to the net at which the summary reports the sum.
const MIN_CANCELLED_RATIO: i64 = 2;
/// Least part of the time that the summary reports as unexplained.
const MIN_UNEXPLAINED_SHARE: f64 = 2e-3;

/// Returns the diagnosis in a few words.
pub fn sentence(diagnosis: &Diagnosis, causes: &[CauseRow], balance: &RoundedAccount) -> String {
    let head = took(balance, diagnosis.accounts.len());
    let said = causes_in_words(causes, balance);
    let named = |end: String| match &said[..] {
        "" => format!("{head}: {end}."),
        said => format!("{head}: {said}; {end}."),
    };
    let left = left(balance);
    let place = diagnosis.left.1.as_ref().map_or(String::new(), |region| match region.lines {
        (first, last) if first == last => format!(", most of it in line {first}"),
        (first, last) => format!(", most of it in lines {first} to {last}"),
    });
    let whole = seconds_of(balance.recorded.max(1));
    if let Some(pulsation) = diagnosis.pulsation {
        return format!("{} {}", named(left), of_pace(pulsation));
    }
    match diagnosis.verdict {
        Verdict::NothingMissing if let Some(off) = diagnosis.elsewhere.filter(|_| is_much(balance)) => {
            named(format!(
                "that is within the {:.1} % by which the machine file may be off on a program that it was not calibrated on",
                100.0 * off
            ))
        }
        Verdict::NothingMissing => named(match hidden(balance) {
            true => format!("this recording shows nothing missing; {left}"),
            false => "this recording shows nothing missing".to_string(),
        }),
        Verdict::Unknown if diagnosis.is_of_form => format!(
            "{head}, but the path differs by {:.1} µm on average, more than noise, and no known cause explains it.",
            1e3 * diagnosis.form.map_or(0.0, |(_, after)| after)
        ),
        Verdict::Unknown if causes.is_empty() => {
            named(format!("{left}, and no known cause explains them{place}"))
        }
        Verdict::Unknown => named(format!(
            "that is not all: {left}, {:.1} % of the time, and no known cause explains them{place}",
            100.0 * seconds_of(balance.unexplained_sum) / whole
        )),
        Verdict::Explained | Verdict::Ambiguous => named(left),
    }
}

/// Returns a clause on the durations of the runs and of the simulation.
fn took(balance: &RoundedAccount, runs: usize) -> String {
    let who = if runs == 1 { "The run took".to_string() } else { format!("The {runs} runs together took") };
    let longer = balance.recorded - balance.simulated;
    let size = seconds_of(longer.abs());
    let size = if size < 1.0 { format!("{size:.2}") } else { format!("{size:.1}") };
    let beside = match longer {
        0 => "as long as simulated".to_string(),
        1.. => format!("{size} s longer than simulated"),
        _ => format!("{size} s shorter than simulated"),
    };
    format!("{who} {:.1} s, {beside}", seconds_of(balance.recorded))
}

/// Returns `true` if the unexplained part exceeds the usual error of a prediction.
fn is_much(balance: &RoundedAccount) -> bool {
    MIN_UNEXPLAINED_SHARE * seconds_of(balance.recorded) < seconds_of(balance.unexplained_sum)
}

/// Returns `true` if much of the unexplained time cancels.
fn hidden(balance: &RoundedAccount) -> bool {
    let net = balance.unexplained.abs();
    net + MIN_CANCELLED_HUNDREDTHS <= balance.unexplained_sum
        && MIN_CANCELLED_RATIO * net <= balance.unexplained_sum
}

/// Returns a clause on the unexplained part.
fn left(balance: &RoundedAccount) -> String {
    let net = written(balance.unexplained);
    match (hidden(balance), balance.unexplained) {
        (true, _) => {
            let sum = written(balance.unexplained_sum);
            format!("{net} remain, of {sum} of losses and gains that partly cancel")
        }
        (false, 0) => "fully explained".to_string(),
        (false, _) => format!("{net} remain"),
    }
}

/// Returns the causes with their times, the largest first; several halts are one entry.
fn causes_in_words(causes: &[CauseRow], balance: &RoundedAccount) -> String {
    let is_hold = |cause: &&CauseRow| cause.effect == FEED_HOLD;
    let holds: Vec<&CauseRow> = causes.iter().filter(is_hold).collect();
    let mut said: Vec<(i64, String)> = Vec::new();
    for (cause, hundredths) in causes.iter().zip(&balance.causes) {
        if 1 < holds.len() && is_hold(&cause) {
            continue;
        }
        said.push((*hundredths, with_rivals(cause)));
    }
    if 1 < holds.len() {
        let each = causes.iter().zip(&balance.causes).filter(|(cause, _)| is_hold(cause));
        said.push((each.map(|(_, hundredths)| hundredths).sum(), of_holds(&holds)));
    }
    said.extend(balance.calibration.map(|own| (own, "what calibration changes".to_string())));
    sort_by_number(&mut said, |(hundredths, _)| -hundredths.abs() as f64);
    let clause = |(hundredths, clause): &(i64, String)| match hundredths {
        0 => clause.clone(),
        _ => format!("{clause} ({})", written(*hundredths)),
    };
    let mut clauses: Vec<String> = said.iter().take(MAX_NAMED_CAUSES).map(clause).collect();
    if MAX_NAMED_CAUSES < said.len() {
        let others = said[MAX_NAMED_CAUSES..].iter().map(|(hundredths, _)| hundredths).sum();
        clauses.push(format!("and {} more ({})", said.len() - MAX_NAMED_CAUSES, written(others)));
    }
    clauses.join("; ")
}

/// Returns the clause of a cause, with the causes that it cannot be told from.
fn with_rivals(cause: &CauseRow) -> String {
    let rivals: Vec<String> = cause.indistinguishable_from.iter().map(|id| id.replace('_', " ")).collect();
    match rivals.as_slice() {
        [] => cause.clause.clone(),
        rivals => format!("{} or, as likely, {}", cause.clause, rivals.join(" or ")),
    }
}

/// Returns several halts as one clause.
fn of_holds(holds: &[&CauseRow]) -> String {
    let mut lines: Vec<u64> = holds.iter().filter_map(|cause| cause.parameters["line"].as_u64()).collect();
    lines.sort_unstable();
    let named = lines.iter().take(MAX_NAMED_LINES).map(u64::to_string).collect::<Vec<String>>().join(", ");
    let more = if MAX_NAMED_LINES < lines.len() { " and others" } else { "" };
    format!("the operator held the feed {} times, in lines {named}{more}", holds.len())
}

/// Returns a sentence on a periodic pulsation of the feedrate.
fn of_pace(Pulsation { frequency, depth }: Pulsation) -> String {
    format!(
        "The feedrate oscillates {frequency:.1} times a second by {:.1} %, with time and not with the program, as under adaptive control or an oscillating load: no setting of the machine causes that.",
        100.0 * depth
    )
}
