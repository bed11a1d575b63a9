//! What the model of a machine leaves unexplained by itself, and what follows for the causes that are named.
//!
//! How far a machine file is believed is in `standing`; what a file that describes its machine leaves is no cause.

use crate::identification::comparison::Comparison;
use crate::identification::diagnosis::cause::{AcceptedCause, candidates};
use crate::identification::diagnosis::evidence::{Candidate, with_all};
use crate::identification::diagnosis::standing::Standing;
use crate::identification::diagnosis::verdict::Left;
use crate::identification::diagnosis::{LEAST, compared, form, located, regions, search};
use crate::identification::effects::Nature;
use crate::identification::fit::Run;
use crate::machine::Machine;

/// Settings and limits of machine and control that may have changed at once.
pub const AT_ONCE: usize = 2;

/// What a machine leaves unexplained of runs that it was calibrated on: the error of the model itself, which is no cause.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelError {
    /// Lost time by region, nothing set off, as a part of the recorded time.
    pub unexplained_time: f64,
    /// Root mean square distance of recorded from simulated positions at equal times, mm; `None` without positions.
    pub form: Option<f64>,
}

impl ModelError {
    /// Of a machine on the runs that it was calibrated on.
    pub fn of(machine: &Machine, runs: &[Run]) -> ModelError {
        let left = Remainder::of(machine, runs);
        ModelError {
            unexplained_time: left.seconds / left.recorded().max(1e-9),
            form: form::error(machine, runs),
        }
    }

    /// Writes it into the machine that leaves it.
    pub fn keep_in(self, machine: &mut Machine) {
        machine.unexplained_time = Some(self.unexplained_time);
        machine.form_error = self.form;
    }
}

/// Whether what a machine leaves of the runs is worth a search for a cause.
pub fn is_worth_a_search(believed: &Machine, machine: &Machine, runs: &[Run], is_beside: bool) -> bool {
    let left = Remainder::of(machine, runs);
    match Standing::of(believed) {
        Standing::Unchecked => LEAST.max(search::SIZE * left.recorded()) < left.seconds,
        Standing::Describes(_) => left.asks(believed, runs, is_beside),
        Standing::Misses => false,
    }
}

/// Whether a machine leaves so much of the runs that it asks for a cause, or beside others for a further one.
pub fn leaves_much(believed: &Machine, machine: &Machine, runs: &[Run], is_beside: bool) -> bool {
    Remainder::of(machine, runs).asks(believed, runs, is_beside)
}

/// What a machine leaves of the runs.
struct Remainder {
    /// Lost time, s.
    seconds: f64,
    compared: Vec<Comparison>,
}

impl Remainder {
    fn of(machine: &Machine, runs: &[Run]) -> Remainder {
        let compared = compared(machine, runs);
        Remainder { seconds: regions::left(&compared, &located(&compared, runs, machine), runs), compared }
    }

    fn recorded(&self) -> f64 {
        self.compared.iter().map(|comparison| comparison.whole.recorded).sum()
    }

    /// Whether it asks for a cause, or, beside others, for a further one.
    fn asks(&self, believed: &Machine, runs: &[Run], is_beside: bool) -> bool {
        let before = if is_beside { Remainder::of(believed, runs).seconds } else { self.seconds };
        Left::of(believed, (before, self.seconds), None, &self.compared).asks(is_beside)
    }
}

/// Whether a cause is a limit or a setting of machine or control.
pub fn is_of_machine(candidate: &Candidate) -> bool {
    matches!(candidate.hypothesis.effect.nature, Nature::Limit | Nature::Setting)
}

/// The causes without those that lie in machine and control, where these make a story: more of them than change at once,
/// or much left beside them. A part of something unknown has no name. A machine file that was never checked is taken at
/// its word.
pub fn without_story(
    start: &Machine,
    base: &Machine,
    runs: &[Run],
    mut named: Vec<AcceptedCause>,
) -> Vec<AcceptedCause> {
    if Standing::of(start) == Standing::Unchecked {
        return named;
    }
    let is_of_machine = |cause: &AcceptedCause| is_of_machine(&cause.candidate);
    let of_machine = named.iter().filter(|cause| is_of_machine(cause)).count();
    let with = || with_all(base, &candidates(&named));
    if AT_ONCE < of_machine || 0 < of_machine && leaves_much(start, &with(), runs, true) {
        named.retain(|cause| !is_of_machine(cause));
    }
    named
}
