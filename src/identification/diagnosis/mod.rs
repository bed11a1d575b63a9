//! Machine and runs → [`Diagnosis`]: where simulation and recording differ, the causes that the machine file lacks, and
//! their confidence.
//!
//! The search accepts one hypothesis at a time, first the one that explains most; it names a hypothesis only if that
//! passes every test of `acceptance`. Causes that a recording shows directly come before all others
//! (`read_off`). A long run is searched in `excerpts` of it, and a cause is kept if it holds on the whole run.
//!
//! After each cause the search repeats on the remaining lost time. At the end it removes every cause that the others
//! make unnecessary, and replaces a cause that was named before the others were known by one that is worth much more
//! beside them. Other effects that fit the runs as well as the best make the result ambiguous.
//!
//! The remaining lost time is judged by itself (`verdict`): if it is large and has no cause, the result is unknown, and
//! the diagnosis locates it.

mod acceptance;
mod account;
mod cause;
mod confidence;
mod crossed;
mod dips;
mod evidence;
mod form;
mod gates;
mod in_time;
mod model_error;
mod places;
mod plateaus;
mod pulsation;
mod read_off;
mod regions;
mod rests;
mod search;
mod shown;
mod speeds;
mod standing;
mod verdict;
mod waits;

pub use account::{Account, Steps, accounts};
pub use crossed::Crossed;
pub use evidence::{Candidate, Evidence};
pub use model_error::ModelError;
pub use plateaus::{Plateau, plateau};
pub use pulsation::Pulsation;
pub use regions::{Region, regions};
pub use rests::feed_holds;

use crate::identification::calibration::{DIAGNOSIS_WINDOWS_S, Excerpt, calibrate, excerpts};
use crate::identification::comparison::{Comparison, compare};
use crate::identification::diagnosis::cause::candidates;
use crate::identification::diagnosis::confidence::CHANCE_OF_LIBRARY;
use crate::identification::diagnosis::evidence::{Looked, with_all};
use crate::identification::diagnosis::form::Forms;
use crate::identification::diagnosis::gates::HeldOut;
use crate::identification::diagnosis::in_time::InTime;
use crate::identification::diagnosis::model_error::{
    MAX_CHANGED_SETTINGS, count_of_machine, is_other_family, is_worth_a_search, lost_time_worth_a_search,
};
use crate::identification::diagnosis::search::FamilyCheck;
use crate::identification::diagnosis::standing::Standing;
use crate::identification::diagnosis::verdict::{Left, MAX_SILENT_PART};
use crate::identification::effects::{self, Effect, Hypothesis, Nature, library};
use crate::identification::fit::Run;
use crate::machine::Machine;
use crate::simulation::ordered::sort_by_number;

/// Least lost time that a cause must explain, s; less may remain unexplained without a remark.
const MIN_LOST_TIME_S: f64 = 0.015;
/// Largest ratio of two lost times, that which remains after a calibration and that which remains without it, at which one of
/// the two explains much more than the other.
const MAX_CALIBRATED_LOST_RATIO: f64 = 0.5;

/// The result of a diagnosis in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Recording and simulation agree as far as the recording shows.
    NothingMissing,
    /// Named causes explain the differences.
    Explained,
    /// Another effect fits the runs as well as a named cause.
    Ambiguous,
    /// Simulation and recording differ at known places, and nothing in the library explains it.
    Unknown,
}

/// A named cause.
#[derive(Clone, Debug)]
pub struct Cause {
    /// The hypothesis with its values.
    pub candidate: Candidate,
    /// Time that the cause explains, s, all runs together: its entry in the account.
    pub seconds: f64,
    /// Form error that the cause explains, mm; 0 for causes of time.
    pub form: f64,
    /// Lines on which the cause acts, as ranges.
    pub lines: Vec<(u32, u32)>,
    /// Confidence, 0 to 1.
    pub confidence: f64,
    /// Ids of the effects that fit these runs as well as the cause, such as `axis_velocity_limit (Y)` beside a limit of X.
    pub alike: Vec<String>,
    /// Result in the sections to which the cause was not fitted; `None` if they do not decide.
    pub held_out: Option<HeldOut>,
}

/// The result of a diagnosis.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// Result in one word.
    pub verdict: Verdict,
    /// Causes, the one that explains most time first.
    pub causes: Vec<Cause>,
    /// Account of each run, from the simulated to the recorded time, with the causes in the order of `causes`.
    pub accounts: Vec<Account>,
    /// Regions in which simulation and recording differ, with or without a cause, run by run.
    pub regions: Vec<Region>,
    /// Lost time that the causes leave, s, all runs together, and the region with at least half of it, if there is one.
    pub left: (f64, Option<Region>),
    /// Relative error of the cycle time that the machine file may have on these runs, if it was calibrated on other
    /// programs; otherwise `None`.
    pub elsewhere: Option<f64>,
    /// `true` if the verdict is unknown because of the form of the path alone, which loses no time.
    pub is_of_form: bool,
    /// Pulsation of the feedrate, with which it rises and falls in time; no effect of the library does that.
    pub pulsation: Option<Pulsation>,
    /// The machine calibrated from the runs before the search for causes; `None` if the machine file was right enough.
    pub calibrated: Option<Machine>,
    /// The machine with the causes.
    pub machine: Machine,
    /// Comparisons with the machine of the file, run by run.
    pub before: Vec<Comparison>,
    /// Comparisons with the machine that has the causes, run by run.
    pub after: Vec<Comparison>,
    /// Form errors without and with the causes, mm; `None` without recorded positions.
    pub form: Option<(f64, f64)>,
    /// Feedrate errors on stretches to which nothing was fitted; `None` if no cause is named or no feedrate is known.
    pub held_out: Option<Crossed>,
    /// Ids of the effects that the programs do not excite.
    pub not_excited: Vec<String>,
    /// Remarks for the user.
    pub messages: Vec<String>,
}

/// Diagnoses runs against the machine of the file. If the machine was never calibrated, and the causes are too many or leave
/// lost time, its file may describe another machine: `diagnose` calibrates it from the runs first. `progress` receives the
/// completed part, 0 to 1.
pub fn diagnose(machine: &Machine, runs: &[Run], progress: &mut dyn FnMut(f64)) -> Diagnosis {
    let (machine, elsewhere) = &standing::on_these(machine, runs);
    let shown = elsewhere.and_then(|_| shown::shown(machine, runs));
    let Some(shown) = shown else {
        return Diagnosis { elsewhere: *elsewhere, ..diagnose_on(machine, runs, progress) };
    };
    let own = diagnose_as_it_is(&shown, Some(machine), runs, &mut |_, _| false, progress);
    let message = "this program shows accelerations, velocities or times of M words that the calibration had to assume or took too low, so Truefeed took them from the recording first; changes by that are not causes";
    let of_file = (compared(machine, runs), Forms::of(machine, runs).error(machine));
    Diagnosis { elsewhere: *elsewhere, ..own.after_calibration(of_file, shown, message) }
}

/// Diagnoses runs against a machine that states the error it may have on them; see [`diagnose`].
fn diagnose_on(machine: &Machine, runs: &[Run], progress: &mut dyn FnMut(f64)) -> Diagnosis {
    let is_checked = Standing::of(machine) != Standing::Unchecked;
    let (mut calibrated_first, mut has_other_family) = (None, false);
    let mut is_of_other_family = |with_best_cause: &Machine, progress: &mut dyn FnMut(f64)| {
        if is_checked || calibrated_first.is_some() {
            return has_other_family;
        }
        let Some(lost) = lost_time_worth_a_search(machine, with_best_cause, runs, true) else { return false };
        let first = calibrated_first.insert(CalibratedFirst::of(machine, runs, progress));
        // A cause that makes another family of a file is a part of a calibration.
        let is_replaced = is_other_family(machine, with_best_cause) || first.replaces_file(lost, true);
        has_other_family = is_other_family(machine, &first.machine) && is_replaced;
        has_other_family
    };
    let as_it_is =
        diagnose_as_it_is(machine, None, runs, &mut is_of_other_family, &mut |part| progress(0.5 * part));
    let of_machine = count_of_machine(as_it_is.causes.iter().map(|cause| &cause.candidate));
    let is_story = || {
        MAX_CHANGED_SETTINGS < of_machine
            || is_other_family(machine, &as_it_is.machine)
            || !as_it_is.causes.is_empty() && is_worth_a_search(machine, &as_it_is.machine, runs, true)
            || as_it_is.verdict == Verdict::Unknown && !as_it_is.is_of_form
    };
    if !has_other_family && (is_checked || as_it_is.pulsation.is_some() || !is_story()) {
        progress(1.0);
        return as_it_is;
    }
    let first = calibrated_first
        .unwrap_or_else(|| CalibratedFirst::of(machine, runs, &mut |part| progress(0.5 + 0.5 * part)));
    progress(1.0);
    // Causes of drives do not count: they explain the form of the path and no time.
    let is_of_time = |cause: &Cause| cause.candidate.hypothesis.effect.nature != Nature::Drive;
    let has_causes = as_it_is.causes.iter().any(is_of_time);
    has_other_family |=
        is_other_family(machine, &as_it_is.machine) && is_other_family(machine, &first.machine);
    if !has_other_family && !first.replaces_file(as_it_is.left.0, has_causes) {
        return as_it_is;
    }
    let message = "the machine file does not describe this machine, so Truefeed calibrated it from the recording first; changes by that calibration are not causes";
    let form = as_it_is.form.map(|(before, _)| before);
    first.own.after_calibration((as_it_is.before, form), first.machine, message)
}

/// A machine calibrated from the runs, with the diagnosis of the runs on it.
struct CalibratedFirst {
    machine: Machine,
    own: Diagnosis,
}

impl CalibratedFirst {
    fn of(file: &Machine, runs: &[Run], progress: &mut dyn FnMut(f64)) -> CalibratedFirst {
        let calibration = calibrate(file, runs, &mut |part| progress(0.5 * part));
        let mut machine = calibration.machine.clone();
        machine.cycle_time_error = Some(calibration.worst_error(|comparison| comparison.whole));
        ModelError::of(&machine, runs).keep_in(&mut machine);
        let own = diagnose_as_it_is(&machine, Some(file), runs, &mut |_, _| false, &mut |part| {
            progress(0.5 + 0.5 * part)
        });
        CalibratedFirst { machine, own }
    }

    /// Returns `true` if the calibration replaces the machine file, with which this time (s) is lost, with or without
    /// causes of time. If causes leave much time, the file is wrong even with them: then it must explain much more than the
    /// calibration, and otherwise the calibration much more than the file.
    fn replaces_file(&self, lost: f64, has_causes: bool) -> bool {
        let recorded: f64 = self.own.after.iter().map(|comparison| comparison.whole.recorded).sum();
        let is_misfit = has_causes && MAX_SILENT_PART * recorded < lost;
        let max_ratio = if is_misfit { 1.0 / MAX_CALIBRATED_LOST_RATIO } else { MAX_CALIBRATED_LOST_RATIO };
        self.own.left.0 <= max_ratio * lost
    }
}

impl Diagnosis {
    /// Returns the diagnosis of a machine file that was calibrated from the runs first, given the comparisons and the form error
    /// (mm) of the file itself, with a message that says so.
    fn after_calibration(
        self,
        (before, form): (Vec<Comparison>, Option<f64>),
        calibrated: Machine,
        message: &str,
    ) -> Diagnosis {
        Diagnosis {
            before,
            form: form.zip(self.form).map(|(before, (_, after))| (before, after)),
            messages: [message.to_string()].into_iter().chain(self.messages).collect(),
            calibrated: Some(calibrated),
            ..self
        }
    }
}

/// Diagnoses runs against a machine, however much lost time remains, without a calibration first. If the machine was
/// already calibrated from the runs, `file` is the machine before that. For `is_of_other_family` see [`InTime::searched`].
fn diagnose_as_it_is(
    machine: &Machine,
    file: Option<&Machine>,
    runs: &[Run],
    is_of_other_family: &mut FamilyCheck,
    progress: &mut dyn FnMut(f64),
) -> Diagnosis {
    let mut library = library(machine, runs);
    let not_excited = not_excited(&library);
    // Drives come first where they explain the form of the path whole: they also blur its times. At times as they
    // are, no time is missing then either.
    let excerpts = excerpts(runs, DIAGNOSIS_WINDOWS_S);
    let parts: Option<Vec<Run>> =
        excerpts.as_ref().map(|excerpts| excerpts.iter().flatten().map(Excerpt::run).collect());
    let looked = Looked { runs: parts.as_deref().unwrap_or(runs), whole: runs, in_parts: parts.is_some() };
    let forms = Forms::of(machine, runs);
    let mut drives = forms.explained(machine, &looked, &library, true);
    let start = with_all(machine, &drives.causes);
    progress(0.1);
    let is_in_time = drives.causes.is_empty();
    let in_time = match is_in_time {
        true => InTime::searched(&start, &looked, &mut library, is_of_other_family, &mut |part| {
            progress(0.1 + 0.7 * part)
        }),
        false => InTime::default(),
    };
    let base = with_all(&start, &candidates(&in_time.read_off));
    let with_time = with_all(&base, &candidates(&in_time.named));
    // Drives change no command.
    let other_forms = (!in_time.is_empty()).then(|| Forms::of(&with_time, runs));
    let forms_with_time = other_forms.as_ref().unwrap_or(&forms);
    // What is left of the time has moved the path as well, and a drive would only imitate that.
    if is_in_time && !model_error::leaves_much(machine, &with_time, runs, !in_time.is_empty()) {
        drives = forms_with_time.explained(&with_time, &looked, &library, false);
    }
    let fitted = with_all(&with_time, &drives.causes);
    progress(0.9);
    let (before, after) = (compared(machine, runs), compared(&fitted, runs));
    let form = forms.error(machine).zip(forms_with_time.error(&fitted));
    let mut causes = in_time.causes(&start, &drives.causes, &fitted, runs);
    causes.extend(drives.as_causes(runs));
    causes.iter_mut().for_each(|cause| cause.confidence *= CHANCE_OF_LIBRARY);
    let steps = file.map_or((machine, None), |file| (file, Some(machine)));
    let accounts = accounted(steps, &mut causes, runs, &after);
    let (regions, rest) = (located(&before, runs, machine), located(&after, runs, &fitted));
    let seconds = regions::left(&after, &rest, runs);
    // Where drives explain the form of the path whole, nothing is missing in time.
    let asked = if is_in_time { seconds } else { 0.0 };
    let pulsation = in_time.pulsation;
    let left = Left::of(machine, (regions::left(&before, &regions, runs), asked), pulsation, &after)
        .with_form(form.is_some_and(|(_, after)| form::is_seen(after, runs)));
    let held_out = match &excerpts {
        Some(excerpts) if !in_time.is_empty() => crossed::outside(machine, &fitted, runs, excerpts),
        Some(_) => None,
        None => {
            crossed::crossed(machine, &with_all(&base, &drives.causes), &candidates(&in_time.named), runs)
        }
    };
    let doubt_of_law = in_time.doubt_of_law.map(str::to_string);
    progress(1.0);
    Diagnosis {
        verdict: left.verdict(&causes),
        is_of_form: left.is_of_form(&causes),
        messages: doubt_of_law.into_iter().chain(left.message(&causes)).collect(),
        left: (seconds, regions::with_most(rest, seconds)),
        causes,
        accounts,
        regions,
        pulsation,
        elsewhere: None,
        calibrated: None,
        machine: fitted,
        before,
        after,
        form,
        held_out,
        not_excited,
    }
}

/// Returns the accounts of the runs. The causes, given in the order in which they act, receive their seconds and are
/// sorted, the one that explains most first.
fn accounted(
    (believed, calibrated): (&Machine, Option<&Machine>),
    causes: &mut Vec<Cause>,
    runs: &[Run],
    after: &[Comparison],
) -> Vec<Account> {
    let acting: Vec<Candidate> = causes.iter().map(|cause| cause.candidate.clone()).collect();
    let accounts = accounts(&Steps { believed, calibrated, causes: &acting }, runs, after);
    for (cause, (_, seconds)) in causes.iter_mut().zip(Account::together(&accounts).causes) {
        cause.seconds = seconds;
    }
    let mut order: Vec<usize> = (0..causes.len()).collect();
    sort_by_number(&mut order, |index| -causes[*index].seconds.abs());
    *causes = order.iter().map(|at| causes[*at].clone()).collect();
    accounts.into_iter().map(|account| account.reordered(&order)).collect()
}

fn compared(machine: &Machine, runs: &[Run]) -> Vec<Comparison> {
    runs.iter().map(|run| compare(run.toolpath, &run.plan(machine), &run.by_clock(machine))).collect()
}

/// Returns the regions in which the runs lost time in their comparisons with a machine, run by run.
fn located(comparisons: &[Comparison], runs: &[Run], machine: &Machine) -> Vec<Region> {
    let each = comparisons.iter().zip(runs).enumerate();
    each.flat_map(|(at, (comparison, run))| regions(comparison, &run.by_clock(machine), at)).collect()
}

/// Returns the ids of the effects that a program can excite and these runs do not.
fn not_excited(library: &[Hypothesis]) -> Vec<String> {
    let is_missing = |effect: &&Effect| {
        effect.unprovoked.is_none() && !library.iter().any(|hypothesis| hypothesis.effect == **effect)
    };
    effects::ALL.iter().filter(is_missing).map(|effect| effect.id.to_string()).collect()
}
