//! The error of the model of a machine: the time and form that it leaves unexplained by itself, and the consequences
//! for the named causes.
//!
//! `standing` decides how far a machine file is believed. The lost time that remains with a file that describes its
//! machine is no cause.

use crate::identification::comparison::Comparison;
use crate::identification::diagnosis::cause::{AcceptedCause, candidates};
use crate::identification::diagnosis::evidence::{Candidate, with_all};
use crate::identification::diagnosis::form::Forms;
use crate::identification::diagnosis::standing::Standing;
use crate::identification::diagnosis::verdict::Left;
use crate::identification::diagnosis::{MIN_LOST_TIME_S, compared, located, regions};
use crate::identification::effects::{MIN_EXPLAINED_SHARE, Nature};
use crate::identification::fit::Run;
use crate::machine::Machine;

/// Maximum number of settings and limits of machine and control that may have changed at once.
pub const MAX_CHANGED_SETTINGS: usize = 2;

/// Message if the runs fit a control of another family than the machine file has.
const OTHER_FAMILY: &str = "the recording fits a control that plans its ramps by accelerations better than the filters of the machine file: calibrate the machine again with this recording beside the former ones";

/// Message if limits or settings would explain lost time of a control whose law is unknown.
const UNKNOWN_LAW: &str = "the calibrated ramps are not those of this control, so Truefeed names no limit or setting of it: a change of one and the error of the law look alike";

/// The unexplained rest of runs on the machine that was calibrated on them: the error of the model itself, which is no
/// cause.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelError {
    /// Sum of the sizes of the lost times of the regions, as a part of the recorded time; lost and gained times do not
    /// cancel.
    pub unexplained_time: f64,
    /// Root mean square distance between recorded and simulated positions at equal times, mm; `None` without recorded
    /// positions.
    pub form: Option<f64>,
    /// Geometric mean of that distance over short parts of the runs, mm.
    pub typical_form: Option<f64>,
}

impl ModelError {
    /// Returns the error of a machine on the runs that it was calibrated on.
    pub fn of(machine: &Machine, runs: &[Run]) -> ModelError {
        let left = Remainder::of(machine, runs);
        let forms = Forms::of(machine, runs);
        ModelError {
            unexplained_time: left.seconds / left.recorded().max(1e-9),
            form: forms.error(machine),
            typical_form: forms.typical_error(machine),
        }
    }

    /// Writes the error into the machine that has it.
    pub fn keep_in(self, machine: &mut Machine) {
        machine.unexplained_time = Some(self.unexplained_time);
        machine.form_error = self.form;
        machine.typical_form_error = self.typical_form;
    }
}

/// Returns `true` if the lost time that `machine` leaves of the runs is worth a search, as in [`lost_time_worth_a_search`].
pub fn is_worth_a_search(believed: &Machine, machine: &Machine, runs: &[Run], is_beside: bool) -> bool {
    lost_time_worth_a_search(believed, machine, runs, is_beside).is_some()
}

/// Returns the lost time that `machine` leaves of the runs, s, if it is worth a search for a cause, or, if `is_beside`, for a
/// further one beside others. `believed` is the machine without causes.
pub fn lost_time_worth_a_search(
    believed: &Machine,
    machine: &Machine,
    runs: &[Run],
    is_beside: bool,
) -> Option<f64> {
    let left = Remainder::of(machine, runs);
    let is_worth = match Standing::of(believed) {
        Standing::Unchecked => MIN_LOST_TIME_S.max(MIN_EXPLAINED_SHARE * left.recorded()) < left.seconds,
        Standing::Describes(_) => left.asks(believed, runs, is_beside),
        Standing::Misses => false,
    };
    is_worth.then_some(left.seconds)
}

/// Returns `true` if `machine` leaves so much lost time of the runs that it requires a cause, or, if `is_beside`, a
/// further one beside others. `believed` is the machine without causes.
pub fn leaves_much(believed: &Machine, machine: &Machine, runs: &[Run], is_beside: bool) -> bool {
    Remainder::of(machine, runs).asks(believed, runs, is_beside)
}

/// The lost time that a machine leaves of the runs.
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

    /// Returns `true` if the lost time requires a cause, or, if `is_beside`, a further one beside others.
    fn asks(&self, believed: &Machine, runs: &[Run], is_beside: bool) -> bool {
        let before = if is_beside { Remainder::of(believed, runs).seconds } else { self.seconds };
        Left::of(believed, (before, self.seconds), None, &self.compared).asks(is_beside)
    }
}

/// Returns `true` if a cause is a limit or a setting of machine or control.
pub fn is_of_machine(candidate: &Candidate) -> bool {
    matches!(candidate.hypothesis.effect.nature, Nature::Limit | Nature::Setting)
}

/// Returns the number of causes that are a limit or a setting of machine or control.
pub fn count_of_machine<'a>(causes: impl Iterator<Item = &'a Candidate>) -> usize {
    causes.filter(|candidate| is_of_machine(candidate)).count()
}

/// Returns `true` if a machine file was never checked and the named causes change as many of its limits and settings as
/// change at once. A file that needs further changes describes another machine, which a calibration finds sooner than a
/// search.
pub fn describes_another_machine(start: &Machine, named: &[AcceptedCause]) -> bool {
    Standing::of(start) == Standing::Unchecked
        && MAX_CHANGED_SETTINGS <= count_of_machine(named.iter().map(|cause| &cause.candidate))
}

/// Returns `true` if causes turn the control of a machine into one of another family: no change of a machine does that, so
/// its file has the wrong family.
pub fn is_other_family(start: &Machine, with_causes: &Machine) -> bool {
    start.has_filters() != with_causes.has_filters()
}

/// Returns a message if the control does not follow the law of the machine file; `None` if nothing shows that. Either the
/// recorded ramps have another shape, or the causes turn a checked machine file into a control of another family
/// ([`is_other_family`]).
pub fn doubt_of_law(start: &Machine, with_causes: &Machine) -> Option<&'static str> {
    let is_unknown = start.calibrated_on.misfit_of_unknown_law().is_some();
    let is_checked = Standing::of(start) != Standing::Unchecked;
    let other_family = || (is_checked && is_other_family(start, with_causes)).then_some(OTHER_FAMILY);
    is_unknown.then_some(UNKNOWN_LAW).or_else(other_family)
}

/// Returns the causes without the limits and settings of machine and control, if these are not believable: if the control
/// has another law ([`doubt_of_law`]); if there are more of them than change at once ([`MAX_CHANGED_SETTINGS`]); or if much
/// lost time remains beside them, as a part of something unknown has no name. All causes remain if the machine file was never
/// checked.
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
    let of_machine = count_of_machine(named.iter().map(|cause| &cause.candidate));
    let with = with_all(base, &candidates(&named));
    let is_story = MAX_CHANGED_SETTINGS < of_machine || doubt_of_law(start, &with).is_some();
    if is_story || 0 < of_machine && leaves_much(start, &with, runs, true) {
        named.retain(|cause| !is_of_machine(cause));
    }
    named
}
