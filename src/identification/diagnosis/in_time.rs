//! The search for the causes that leave time along the path, from those that the recordings show directly to the review
//! of those that were found before the others were known.
//!
//! No law is exact, so of two limits that slow the same places the one that fits the times better may leave more lost time,
//! added up place by place. If a single limit or setting leaves too much, the search names another one that passes every
//! test and leaves little, and counts the first one as alike.

use crate::identification::diagnosis::acceptance::id_beside;
use crate::identification::diagnosis::cause::{AcceptedCause, candidates};
use crate::identification::diagnosis::confidence::weighed;
use crate::identification::diagnosis::evidence::{Looked, with_all};
use crate::identification::diagnosis::model_error::{
    describes_another_machine, doubt_of_law, is_of_machine, is_worth_a_search, without_story,
};
use crate::identification::diagnosis::search::FamilyCheck;
use crate::identification::diagnosis::{Candidate, Cause, Pulsation, compared, read_off, regions, search};
use crate::identification::effects::Hypothesis;
use crate::identification::fit::Run;
use crate::machine::Machine;

/// Maximum number of rounds of the search for causes, each of which names the next one.
const MAX_SEARCH_ROUNDS: usize = 4;
/// Maximum number of rounds in which a named cause may give way to another.
const MAX_RECONSIDERING_ROUNDS: usize = 2;
/// Part of the progress of the search that falls to finding the causes, before they are reconsidered.
const FINDING_PROGRESS_SHARE: f64 = 0.7;

/// The causes that leave time along the path.
#[derive(Default)]
pub struct InTime {
    /// Causes that the recording shows directly, with the values read off it.
    pub read_off: Vec<AcceptedCause>,
    /// Causes whose values were fitted.
    pub named: Vec<AcceptedCause>,
    /// Pulsation of the feedrate that the causes leave.
    pub pulsation: Option<Pulsation>,
    /// Message that limits or settings would explain the runs, but the control has another law than the machine file;
    /// `None` if there are none.
    pub doubt_of_law: Option<&'static str>,
}

impl InTime {
    /// Returns all causes of time that the search finds on a machine, until `is_of_other_family` says that its file has the
    /// wrong family: no cause turns one family into another.
    pub fn searched(
        start: &Machine,
        looked: &Looked,
        library: &mut Vec<Hypothesis>,
        is_of_other_family: &mut FamilyCheck,
        progress: &mut dyn FnMut(f64),
    ) -> InTime {
        let runs = looked.whole;
        let (read_off, first) = read_off::read_off(start, looked, library);
        let base = with_all(start, &candidates(&read_off));
        let mut search = CauseSearch { start, base: &base, looked, first: &first, progress };
        let mut named = search.causes(library, is_of_other_family);
        // What a search finds beside a pace that pulsates, and goes on to, is a part of that.
        let seen = |machine: &Machine| Pulsation::seen(&compared(machine, runs), runs);
        let mut pulsation = seen(&with_all(&base, &candidates(&named)));
        if pulsation.is_some_and(|with| seen(start).is_some_and(|before| before.is_as_fast(&with))) {
            named.clear();
            pulsation = seen(&base);
        }
        let doubt_of_law = doubt_of_law(start, &with_all(&base, &candidates(&named)));
        let found = named.len();
        let named = match doubt_of_law {
            Some(_) => without_story(start, &base, runs, named),
            None => search.believable(library, named),
        };
        let doubt_of_law = doubt_of_law.filter(|_| named.len() < found);
        InTime { named: weighed(&base, runs, named), read_off, pulsation, doubt_of_law }
    }

    /// Returns `true` if there is no cause.
    pub fn is_empty(&self) -> bool {
        self.read_off.is_empty() && self.named.is_empty()
    }

    /// Returns the causes in the order in which they act, each with the lines on which it acts beside the others.
    pub fn causes(
        &self,
        start: &Machine,
        drives: &[Candidate],
        fitted: &Machine,
        runs: &[Run],
    ) -> Vec<Cause> {
        let all: Vec<&AcceptedCause> = self.read_off.iter().chain(&self.named).collect();
        let cause = |at: usize| {
            let others =
                (0..all.len()).filter(|other| *other != at).map(|other| all[other].candidate.clone());
            let without = with_all(&with_all(start, &others.collect::<Vec<_>>()), drives);
            let lines = regions::acts_on(&without, fitted, runs);
            let AcceptedCause { candidate, alike, held_out, confidence } = all[at].clone();
            Cause { candidate, seconds: 0.0, form: 0.0, lines, confidence, alike, held_out }
        };
        (0..all.len()).map(cause).collect()
    }
}

/// A search for causes beside those that were read off.
struct CauseSearch<'a> {
    start: &'a Machine,
    /// The machine with the causes whose values do not change any more.
    base: &'a Machine,
    looked: &'a Looked<'a>,
    /// The causes that were read off and are fitted again with each of the others.
    first: &'a [AcceptedCause],
    progress: &'a mut dyn FnMut(f64),
}

impl CauseSearch<'_> {
    /// Returns the causes that a library offers and that pass every test; see [`InTime::searched`].
    fn causes(&mut self, library: &[Hypothesis], is_of_other_family: &mut FamilyCheck) -> Vec<AcceptedCause> {
        let CauseSearch { start, base, looked, first, progress } = self;
        let (runs, mut named) = (looked.whole, first.to_vec());
        for round in 0..MAX_SEARCH_ROUNDS {
            let with = with_all(base, &candidates(&named));
            // A cause of lost time within the error of the model would only imitate that error.
            if describes_another_machine(start, &named)
                || !is_worth_a_search(start, &with, runs, !named.is_empty())
            {
                break;
            }
            let mut progress =
                |part| progress(FINDING_PROGRESS_SHARE * (round as f64 + part) / MAX_SEARCH_ROUNDS as f64);
            let all =
                search::with_next(base, looked, library, &named, &mut *is_of_other_family, &mut progress);
            let Some(all) = all else { break };
            named = all;
        }
        named = search::without_unnecessary(base, looked, named);
        for round in 0..MAX_RECONSIDERING_ROUNDS {
            let rounds = |part: f64| (round as f64 + part) / MAX_RECONSIDERING_ROUNDS as f64;
            let mut progress =
                |part| progress(FINDING_PROGRESS_SHARE + (1.0 - FINDING_PROGRESS_SHARE) * rounds(part));
            let Some(all) = search::reconsidered(base, looked, library, &named, &mut progress) else {
                break;
            };
            named = search::without_unnecessary(base, looked, all);
        }
        if looked.in_parts {
            named = search::held(base, runs, named);
        }
        named
    }

    /// Returns the causes that are believable. If a single limit or setting leaves too much lost time and another one
    /// leaves little, returns the other one in its place, with the first one as alike.
    fn believable(&self, library: &[Hypothesis], named: Vec<AcceptedCause>) -> Vec<AcceptedCause> {
        let CauseSearch { start, base, looked, first, .. } = *self;
        let story = |named: &[AcceptedCause]| without_story(start, base, looked.whole, named.to_vec());
        let believed = story(&named);
        let [dropped] = &named[first.len().min(named.len())..] else { return believed };
        if believed.len() == named.len() {
            return believed;
        }
        let dropped = &dropped.candidate.hypothesis;
        let frees = |other: &Hypothesis| other.freed.first().map(|freed| freed.handle);
        let rest: Vec<Hypothesis> =
            library.iter().filter(|other| frees(other) != frees(dropped)).cloned().collect();
        let is_believable = |other: &[AcceptedCause]| {
            let is_of_machine = other.last().is_some_and(|cause| is_of_machine(&cause.candidate));
            is_of_machine && story(other).len() == other.len()
        };
        let Some(mut other) = search::with_believable(base, looked, &rest, first, is_believable) else {
            return believed;
        };
        if let Some(cause) = other.last_mut() {
            cause.add_alike(id_beside(dropped, &cause.candidate.hypothesis));
        }
        other
    }
}
