//! Whether two interpreters do the same: the same deeds in the same order.
//!
//! Positions agree within 1e-4 mm, or within the rounding of what LinuxCNC prints where that is
//! coarser (inches, sums of offsets). Moves of zero length, of which our toolpath has none, and
//! dwells of no time are left out on both sides; a move that may be rounding (a few last digits) is
//! left out where only one side has it.

use crate::linuxcnc::canonical::Run;
use crate::linuxcnc::event::{Circle, Deed, Event, Move};
use std::fmt::Write;

/// How far positions may be apart, mm.
const APART: f64 = 1e-4;

/// What agreed.
#[derive(Default, Debug, Clone, Copy)]
pub struct Count {
    pub moves: usize,
    pub arcs: usize,
    pub others: usize,
}

impl std::ops::AddAssign for Count {
    fn add_assign(&mut self, other: Count) {
        self.moves += other.moves;
        self.arcs += other.arcs;
        self.others += other.others;
    }
}

/// Compares what we make of a program with what LinuxCNC makes of it; of one that it refuses, as
/// far as it came.
pub fn compare(ours: &[Event], theirs: &Run) -> Result<Count, String> {
    let tolerance = APART.max(1.01 * theirs.rounding);
    let is_short = |event: &Event| matches!(&event.deed, Deed::Move(step) if step.size() < 4.0 * tolerance);
    let is_nothing = |event: &Event| match &event.deed {
        Deed::Move(step) => step.size() == 0.0,
        Deed::Dwell(seconds) => *seconds == 0.0,
        _ => false,
    };
    let ours: Vec<&Event> = ours.iter().filter(|event| !is_nothing(event)).collect();
    let mut count = Count::default();
    let (mut left, mut right) = (0, 0);
    let expected: Vec<&Event> = theirs.events.iter().filter(|event| !is_nothing(event)).collect();
    loop {
        let difference = match (ours.get(left), expected.get(right)) {
            (None, None) => return Ok(count),
            (Some(_), None) if theirs.refusal.is_some() => return Ok(count),
            (Some(a), Some(b)) => difference(&a.deed, &b.deed, tolerance),
            _ => Some("one ends before the other".to_string()),
        };
        let Some(difference) = difference else {
            match &ours[left].deed {
                Deed::Move(step) if step.arc.is_some() => count.arcs += 1,
                Deed::Move(_) => count.moves += 1,
                _ => count.others += 1,
            }
            (left, right) = (left + 1, right + 1);
            continue;
        };
        if ours.get(left).is_some_and(|event| is_short(event)) {
            left += 1;
        } else if expected.get(right).is_some_and(|event| is_short(event)) {
            right += 1;
        } else {
            return Err(described(
                &difference,
                ours.get(left).copied(),
                expected.get(right).copied(),
                theirs,
            ));
        }
    }
}

fn described(difference: &str, ours: Option<&Event>, theirs: Option<&Event>, run: &Run) -> String {
    let mut text = difference.to_string();
    match ours {
        Some(event) => write!(text, "\n  ours      line {}: {}", event.line, event.deed),
        None => write!(text, "\n  ours      nothing more"),
    }
    .expect("text grows");
    match theirs {
        Some(event) => write!(text, "\n  LinuxCNC  line {} of its output: {}", event.line, event.deed),
        None => write!(text, "\n  LinuxCNC  nothing more"),
    }
    .expect("text grows");
    if let Some(refusal) = &run.refusal {
        write!(text, "\n  LinuxCNC stops with: {refusal}").expect("text grows");
    }
    text
}

fn difference(ours: &Deed, theirs: &Deed, tolerance: f64) -> Option<String> {
    match (ours, theirs) {
        (Deed::Move(a), Deed::Move(b)) => difference_of_moves(a, b, tolerance),
        (Deed::Dwell(a), Deed::Dwell(b)) => (1e-4 < (a - b).abs()).then(|| "another dwell".to_string()),
        (Deed::ToolChange(_), Deed::ToolChange(_)) | (Deed::MWord(_), Deed::MWord(_)) => {
            (ours != theirs).then(|| "another word".to_string())
        }
        _ => Some("something else".to_string()),
    }
}

fn difference_of_moves(ours: &Move, theirs: &Move, tolerance: f64) -> Option<String> {
    let apart = (ours.end - theirs.end).amax();
    if tolerance < apart {
        return Some(format!("ends {apart:.2e} mm apart"));
    }
    match (ours.feedrate, theirs.feedrate) {
        (None, None) => {}
        (Some(a), Some(b)) if (a - b).abs() <= 13e-4 + 1e-6 * b => {}
        _ => return Some("another feedrate".to_string()),
    }
    if ours.is_exact != theirs.is_exact {
        return Some("exact stop or not".to_string());
    }
    match (&ours.arc, &theirs.arc) {
        (None, None) => None,
        (Some(a), Some(b)) => difference_of_circles(ours, a, b, tolerance),
        _ => Some("a line and an arc".to_string()),
    }
}

fn difference_of_circles(step: &Move, ours: &Circle, theirs: &Circle, tolerance: f64) -> Option<String> {
    if ours.normal != theirs.normal {
        return Some("arcs in two planes".to_string());
    }
    let apart = (ours.center - theirs.center).amax();
    if tolerance < apart {
        return Some(format!("centres {apart:.2e} mm apart"));
    }
    // Ends and centre are rounded: so is the angle between them.
    let angle = 6.0 * tolerance / (step.start - ours.center).norm();
    (angle + 1e-9 < (ours.sweep - theirs.sweep).abs()).then(|| "another angle".to_string())
}
