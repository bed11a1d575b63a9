//! What the user reads first: how long the run took, by how much that differs from the simulation, what causes that,
//! and what is left. The balance of the account in words.

use crate::identification::diagnosis::{Diagnosis, Pulsation, Verdict};
use crate::identification::effects::FEED_HOLD;
use crate::project::diagnosis::CauseRow;
use crate::project::diagnosis::account::{Balance, in_seconds, written};

/// Lines of halts that are named.
const LINES: usize = 12;
/// Causes that are named, the largest first.
const NAMED: usize = 4;
/// What is left region by region is said beside its net where it is more by this, hundredths of a second, ...
const HIDDEN: i64 = 5;
/// ... and by this factor.
const TIMES: i64 = 2;

/// The diagnosis in a few words.
pub fn sentence(diagnosis: &Diagnosis, causes: &[CauseRow], balance: &Balance) -> String {
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
    let whole = in_seconds(balance.recorded.max(1));
    if let Some(pulsation) = diagnosis.pulsation {
        return format!("{} {}", named(left), of_pace(pulsation));
    }
    match diagnosis.verdict {
        Verdict::NothingMissing => named(match hidden(balance) {
            true => format!("nothing is missing as far as this recording shows; {left}"),
            false => "nothing is missing as far as this recording shows".to_string(),
        }),
        Verdict::Unknown if diagnosis.is_of_form => format!(
            "{head}, but the path differs by {:.1} µm in the mean, more than noise, and nothing known explains it.",
            1e3 * diagnosis.form.map_or(0.0, |(_, after)| after)
        ),
        Verdict::Unknown if causes.is_empty() => {
            named(format!("{left}, and nothing known explains it{place}"))
        }
        Verdict::Unknown => named(format!(
            "that is not all: {left}, {:.1} % of the time, and nothing known explains it{place}",
            100.0 * in_seconds(balance.unexplained_sum) / whole
        )),
        Verdict::Explained | Verdict::Ambiguous => named(left),
    }
}

/// How long a number of runs took, beside the simulation.
fn took(balance: &Balance, runs: usize) -> String {
    let who = if runs == 1 { "The run took".to_string() } else { format!("The {runs} runs together took") };
    let longer = balance.recorded - balance.simulated;
    let size = in_seconds(longer.abs());
    let size = if size < 1.0 { format!("{size:.2}") } else { format!("{size:.1}") };
    let beside = match longer {
        0 => "as long as simulated".to_string(),
        1.. => format!("{size} s longer than simulated"),
        _ => format!("{size} s shorter than simulated"),
    };
    format!("{who} {:.1} s, {beside}", in_seconds(balance.recorded))
}

/// Whether much of what is left cancels.
fn hidden(balance: &Balance) -> bool {
    let net = balance.unexplained.abs();
    net + HIDDEN <= balance.unexplained_sum && TIMES * net <= balance.unexplained_sum
}

/// What is left.
fn left(balance: &Balance) -> String {
    let net = written(balance.unexplained);
    match (hidden(balance), balance.unexplained) {
        (true, _) => {
            format!("{net} are left, {} if losses and gains are added up", written(balance.unexplained_sum))
        }
        (false, 0) => "nothing is left".to_string(),
        (false, _) => format!("{net} are left"),
    }
}

/// The causes with what each adds, the largest first; several holds are one.
fn causes_in_words(causes: &[CauseRow], balance: &Balance) -> String {
    let is_hold = |cause: &&CauseRow| cause.effect == FEED_HOLD;
    let holds: Vec<&CauseRow> = causes.iter().filter(is_hold).collect();
    let mut said: Vec<(i64, String)> = Vec::new();
    for (cause, hundredths) in causes.iter().zip(&balance.causes) {
        if 1 < holds.len() && is_hold(&cause) {
            continue;
        }
        said.push((*hundredths, cause.clause.clone()));
    }
    if 1 < holds.len() {
        let each = causes.iter().zip(&balance.causes).filter(|(cause, _)| is_hold(cause));
        said.push((each.map(|(_, hundredths)| hundredths).sum(), of_holds(&holds)));
    }
    said.extend(balance.calibration.map(|own| (own, "what calibration changes".to_string())));
    said.sort_by_key(|(hundredths, _)| -hundredths.abs());
    let clause = |(hundredths, clause): &(i64, String)| match hundredths {
        0 => clause.clone(),
        _ => format!("{clause} ({})", written(*hundredths)),
    };
    let mut clauses: Vec<String> = said.iter().take(NAMED).map(clause).collect();
    if NAMED < said.len() {
        let others = said[NAMED..].iter().map(|(hundredths, _)| hundredths).sum();
        clauses.push(format!("and {} more ({})", said.len() - NAMED, written(others)));
    }
    clauses.join("; ")
}

/// Several halts as one clause.
fn of_holds(holds: &[&CauseRow]) -> String {
    let mut lines: Vec<u64> = holds.iter().filter_map(|cause| cause.parameters["line"].as_u64()).collect();
    lines.sort_unstable();
    let named = lines.iter().take(LINES).map(u64::to_string).collect::<Vec<String>>().join(", ");
    let more = if LINES < lines.len() { " and others" } else { "" };
    format!("the operator held the feed {} times, in lines {named}{more}", holds.len())
}

/// A pace that rises and falls.
fn of_pace(Pulsation { frequency, depth }: Pulsation) -> String {
    format!(
        "The feedrate rises and falls {frequency:.1} times a second by {:.1} %, with the clock and not with the \
         program, as under adaptive control or a load that swings: no setting of the machine does.",
        100.0 * depth
    )
}
