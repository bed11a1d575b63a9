//! What the user reads first: what the operator did, then what the machine does, then what is left.

use crate::identification::diagnosis::{Diagnosis, Pulsation, Verdict};
use crate::identification::effects::FEED_HOLD;
use crate::project::comparison::seconds;
use crate::project::diagnosis::CauseRow;

/// Lines of halts that are named.
const NAMED: usize = 12;

/// The diagnosis in a few words.
pub fn sentence(diagnosis: &Diagnosis, causes: &[CauseRow]) -> String {
    let lost: f64 = diagnosis.before.iter().map(|side| side.whole.recorded - side.whole.simulated).sum();
    let (left, most) = &diagnosis.left;
    let place = most.as_ref().map_or(String::new(), |region| match region.lines {
        (first, last) if first == last => format!(", most of it in line {first}"),
        (first, last) => format!(", most of it in lines {first} to {last}"),
    });
    let is_operators = |cause: &&CauseRow| cause.effect.is_by_operator();
    let operators: Vec<&CauseRow> = causes.iter().filter(is_operators).collect();
    let machines: Vec<&CauseRow> = causes.iter().filter(|cause| !is_operators(cause)).collect();
    let mut told = of_operator(&operators);
    if let Some(pulsation) = diagnosis.pulsation {
        told.extend(machines.iter().map(|cause| cause.sentence.clone()));
        told.push(of_pace(pulsation));
        return told.join(" ");
    }
    match diagnosis.verdict {
        Verdict::NothingMissing => format!(
            "Nothing is missing: recording and simulation agree within {} as far as this recording shows.",
            seconds(lost.abs().max(0.01))
        ),
        Verdict::Unknown if diagnosis.is_of_form => format!(
            "Times agree, but the path differs by {:.1} µm in the mean, more than noise, and nothing known explains it.",
            1e3 * diagnosis.form.map_or(0.0, |(_, after)| after)
        ),
        Verdict::Unknown if causes.is_empty() => {
            format!(
                "Something differs by {} that nothing known explains{place}.",
                seconds(lost.abs().max(0.01))
            )
        }
        Verdict::Unknown => {
            if told.is_empty() {
                told.extend(machines.first().map(|cause| cause.sentence.clone()));
            }
            let whole: f64 = diagnosis.after.iter().map(|side| side.whole.recorded).sum();
            told.push(format!(
                "That is not all: {} are left, {:.1} % of the time, that nothing known explains{place}.",
                seconds(*left),
                100.0 * left / whole
            ));
            told.join(" ")
        }
        Verdict::Explained | Verdict::Ambiguous => {
            told.extend(machines.iter().map(|cause| cause.sentence.clone()));
            told.join(" ")
        }
    }
}

/// A pace that rises and falls.
fn of_pace(Pulsation { frequency, depth }: Pulsation) -> String {
    format!(
        "The feedrate rises and falls {frequency:.1} times a second by {:.1} %, with the clock and not with the \
         program, as under adaptive control or a load that swings: no setting of the machine does.",
        100.0 * depth
    )
}

/// What the operator did; several halts are one sentence.
fn of_operator(causes: &[&CauseRow]) -> Vec<String> {
    let is_hold = |cause: &&&CauseRow| cause.effect == FEED_HOLD;
    let holds: Vec<&&CauseRow> = causes.iter().filter(is_hold).collect();
    let others = causes.iter().filter(|cause| !is_hold(cause)).map(|cause| cause.sentence.clone());
    let mut told: Vec<String> = others.collect();
    if let [one] = holds[..] {
        told.push(one.sentence.clone());
    } else if !holds.is_empty() {
        let whole: f64 = holds.iter().filter_map(|cause| cause.seconds).sum();
        let mut lines: Vec<u64> =
            holds.iter().filter_map(|cause| cause.parameters["line"].as_u64()).collect();
        lines.sort_unstable();
        let named = lines.iter().take(NAMED).map(u64::to_string).collect::<Vec<String>>().join(", ");
        let more = if NAMED < lines.len() { " and others" } else { "" };
        told.push(format!(
            "The operator held the feed {} times, for {} in all: in lines {named}{more}.",
            holds.len(),
            seconds(whole)
        ));
    }
    told
}
