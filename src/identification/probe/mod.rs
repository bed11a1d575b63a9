//! Machine and two causes → [`Probe`]: a short program that separates the causes.
//!
//! A machine with a cause at one value is a point: its recording on a snippet, in standard deviations of the
//! noise. All values of a cause form a curve, approximated by chords through its trials and a few points
//! between them. The separation of a cause at one value from another cause is the distance σ of the point w
//! of the first from the curve of the other,
//! ```text
//! σ² = min_value Σ_snippets |w(cause) − w(other, value)|²
//! ```
//!
//! which fits the other cause to the first (T-optimality: Atkinson and Fedorov 1975). A recording consists of
//! times at places along the path, whitened as in `fit`, with the standard deviation [`STAMP_DEVIATION_S`]
//! per mark; for a cause that affects only the form of the path, of positions at equal times without the
//! common delay.
//!
//! Snippets are chosen greedily by separation per second. The choice ends when every pair of variants (axes,
//! rules), in both directions, is [`TARGET_SEPARATION_SIGMAS`] apart and the probe lasts `MIN_PROBE_S`, or
//! when it lasts [`MAX_PROBE_S`].
//!
//! Limits: the first cause is tried at one middle strength; other parameters of the machine are assumed to be
//! known.

mod separation;
mod snippets;

pub use snippets::{SNIPPET_SPACE_MM, Snippet, bank, top};

use thiserror::Error;

use crate::identification::effects::{self, Effect, Hypothesis, Trace, library};
use crate::identification::probe::separation::{ProbeTrial, Separation, separations};
use crate::machine::Machine;
use crate::simulation::ordered::sort_by_number;

/// Separation at which the choice of snippets ends, in standard deviations.
pub const TARGET_SEPARATION_SIGMAS: f64 = 10.0;
/// Least separation of a probe, in standard deviations.
const MIN_SEPARATION_SIGMAS: f64 = 5.0;
/// Longest program for two causes, s.
pub const MAX_PROBE_S: f64 = 90.0;
/// Shortest program, s: other causes and held-out sections need motion as well.
const MIN_PROBE_S: f64 = 20.0;
/// Standard deviation of the time of a mark, s: a recorder at 500 Hz.
pub const STAMP_DEVIATION_S: f64 = 1e-3;

/// A program with its purpose.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// G-code.
    pub program: String,
    /// Purpose and quality, one sentence per line.
    pub summary: Vec<String>,
    /// Duration on the assumed machine, s.
    pub seconds: f64,
    /// Separation of the two causes, in standard deviations; `None` for a program for all effects.
    pub separation: Option<f64>,
}

/// The reason why there is no such program.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ProbeError {
    /// No cause of this id.
    #[error("unknown cause {id}; the nearest known one is {nearest}")]
    Unknown {
        /// Given id.
        id: String,
        /// Nearest known id.
        nearest: &'static str,
    },
    /// Both ids are equal.
    #[error("both causes are {0}; give two different causes")]
    Same(String),
    /// No program shows the cause.
    #[error("{id} cannot be probed: {why}")]
    Unprovoked {
        /// The cause.
        id: &'static str,
        /// Reason and alternative.
        why: &'static str,
    },
    /// The machine does not have the cause, or hides it.
    #[error("{0} shows on no program within this machine's limits; check its values in the machine file")]
    Hidden(&'static str),
    /// Both causes have the same effect on every snippet.
    #[error(
        "no program of {MAX_PROBE_S} s separates {0} from {1}: {2:.1} standard deviations; change one of the two on the machine and record again"
    )]
    Alike(String, String, f64),
}

/// Returns a short program that separates two causes on a machine. A cause is the id of an effect, with its axes in
/// brackets if only those are meant, as in `axis_velocity_limit (Y)`.
///
/// # Errors
///
/// Returns an error if a cause is unknown, both are equal, no program shows one of them, or no program
/// separates the two.
///
/// # Examples
///
/// ```
/// use truefeed::identification::probe::probe_between;
/// use truefeed::machine::Machine;
///
/// let probe = probe_between(&Machine::default(), ["exact_stop", "feed_override"]).expect("they differ at corners");
/// assert!(probe.program.contains("G1"));
/// assert!(probe_between(&Machine::default(), ["exact_stop", "weather"]).is_err());
/// ```
pub fn probe_between(machine: &Machine, causes: [&str; 2]) -> Result<Probe, ProbeError> {
    let [one, other] = [provoked(causes[0])?, provoked(causes[1])?];
    if one == other {
        return Err(ProbeError::Same(one.name()));
    }
    let bank = bank(machine);
    let programs: Vec<String> = bank.iter().map(|snippet| whole(&[], &snippet.lines)).collect();
    let trials: Vec<ProbeTrial> = programs.iter().map(|program| ProbeTrial::new(machine, program)).collect();
    let runs: Vec<_> = trials.iter().map(ProbeTrial::run).collect();
    let library = library(machine, &runs);
    let of = |cause: &ProbedCause| {
        let own: Vec<&Hypothesis> = library.iter().filter(|hypothesis| cause.is_of(hypothesis)).collect();
        if own.is_empty() { Err(ProbeError::Hidden(cause.effect.id)) } else { Ok(own) }
    };
    let sides = [of(&one)?, of(&other)?];
    let is_form = sides.iter().flatten().any(|hypothesis| hypothesis.trace() == Trace::Form);
    let found = separations(machine, &trials, &sides, is_form);
    if let Some(side) = (0..2).find(|side| found.is_hidden[*side]) {
        return Err(ProbeError::Hidden([&one, &other][side].effect.id));
    }
    let costs: Vec<f64> = trials.iter().map(ProbeTrial::seconds).collect();
    let chosen = chosen(&found.separations, &costs);
    let lines: String = chosen.iter().map(|at| bank[*at].lines.as_str()).collect();
    // The stated separation is that of the whole program, not of its parts.
    let trial = ProbeTrial::new(machine, &whole(&[], &lines));
    let seconds = trial.seconds();
    let reached = separations(machine, &[trial], &sides, is_form);
    let separation = least(&reached.separations, &[0]);
    if separation < MIN_SEPARATION_SIGMAS {
        return Err(ProbeError::Alike(one.name(), other.name(), separation));
    }
    let summary = vec![
        format!("Probe for {}", machine.name),
        format!("separates {} from {}", one.name(), other.name()),
        format!("{seconds:.1} s, expected separation at least {separation:.0} standard deviations"),
        format!("recorded at 500 Hz with {:.0} ms of noise", 1e3 * STAMP_DEVIATION_S),
    ];
    let mut heads = vec![space()];
    heads.extend(summary.iter().cloned());
    heads.extend(chosen.iter().map(|at| bank[*at].name.clone()));
    let program = whole(&heads, &lines);
    Ok(Probe { program, summary, seconds, separation: Some(separation) })
}

/// Returns a program that shows every effect on a machine.
pub fn probe_all(machine: &Machine) -> Probe {
    let bank = bank(machine);
    let lines: String = bank.iter().map(|snippet| snippet.lines.as_str()).collect();
    let seconds = ProbeTrial::new(machine, &whole(&[], &lines)).seconds();
    let summary = vec![
        format!("Probe for {}", machine.name),
        format!("exercises all effects in {} parts", bank.len()),
        format!("{seconds:.1} s"),
    ];
    let mut heads = vec![space()];
    heads.extend(summary.iter().cloned());
    Probe { program: whole(&heads, &lines), summary, seconds, separation: None }
}

/// Returns a sentence on the space that a program needs.
fn space() -> String {
    let [x, y, z] = SNIPPET_SPACE_MM;
    format!("Needs X0..{x} Y0..{y} Z0..{z} mm in air: no stock, no clamps")
}

/// Returns a program of these lines with comments before them.
fn whole(heads: &[String], lines: &str) -> String {
    // Brackets would end a comment, and controls read only ASCII.
    let plain = |text: &String| -> String {
        let text = text.replace('°', " deg").replace(['(', ')', '%', ';'], " ");
        text.chars().map(|sign| if sign.is_ascii() && !sign.is_control() { sign } else { '?' }).collect()
    };
    let heads: String = heads.iter().map(|head| format!("({})\n", plain(head))).collect();
    format!("{heads}G21 G90 G94 G17\n{lines}M30\n")
}

/// A cause that a program is to show.
#[derive(Clone, PartialEq)]
struct ProbedCause {
    effect: Effect,
    /// The axes of the only hypothesis meant; `None` for all hypotheses of the effect.
    axes: Option<String>,
}

impl ProbedCause {
    fn name(&self) -> String {
        self.effect.id_on(self.axes.as_deref())
    }

    fn is_of(&self, hypothesis: &Hypothesis) -> bool {
        hypothesis.effect == self.effect && (self.axes.is_none() || hypothesis.axes() == self.axes)
    }
}

/// Returns the cause with this name if a program can show it.
fn provoked(name: &str) -> Result<ProbedCause, ProbeError> {
    let (id, axes) = match name.strip_suffix(')').and_then(|name| name.split_once(" (")) {
        Some((id, axes)) => (id, Some(axes.to_ascii_uppercase())),
        None => (name, None),
    };
    let Some(effect) = effects::with_id(id) else {
        let distance = |effect: &&Effect| strsim::damerau_levenshtein(effect.id, id);
        let nearest = effects::ALL.iter().min_by_key(distance).expect("there are effects").id;
        return Err(ProbeError::Unknown { id: id.to_string(), nearest });
    };
    match effect.unprovoked {
        Some(why) => Err(ProbeError::Unprovoked { id: effect.id, why }),
        None => Ok(ProbedCause { effect, axes }),
    }
}

/// Returns the least separation over all pairs on these snippets.
fn least(separations: &[Separation], chosen: &[usize]) -> f64 {
    separations.iter().map(|separation| separation.squared(chosen).sqrt()).fold(f64::INFINITY, f64::min)
}

/// Returns the indices of the snippets that separate most per second, chosen one after another, in the order
/// of the bank.
fn chosen(separations: &[Separation], costs: &[f64]) -> Vec<usize> {
    // Above the target, as chords only approximate the curve.
    let goal = (1.5 * TARGET_SEPARATION_SIGMAS).powi(2);
    let score = |chosen: &[usize]| -> f64 {
        separations.iter().map(|separation| separation.squared(chosen).ln_1p()).sum()
    };
    let mut chosen: Vec<usize> = Vec::new();
    let mut used = 0.0;
    while used < MIN_PROBE_S || least(separations, &chosen) < goal.sqrt() {
        let now = score(&chosen);
        let gain = |at: usize| {
            let mut more = chosen.clone();
            more.push(at);
            (score(&more) - now) / costs[at].max(1e-3)
        };
        let open = (0..costs.len()).filter(|at| !chosen.contains(at));
        let fits = open.filter(|at| chosen.is_empty() || used + costs[*at] <= MAX_PROBE_S);
        let best = fits.map(|at| (at, gain(at))).max_by(|a, b| a.1.total_cmp(&b.1));
        match best {
            Some((at, gain)) if 0.0 < gain || chosen.is_empty() => {
                used += costs[at];
                chosen.push(at);
            }
            _ => break,
        }
    }
    sort_by_number(&mut chosen, |at| *at as f64);
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_cause_is_refused_with_the_nearest_known_one() {
        let refused = |id: &str| probe_between(&Machine::default(), [id, "feed_override"]).unwrap_err();
        assert_eq!(
            refused("exact_stops"),
            ProbeError::Unknown { id: "exact_stops".to_string(), nearest: "exact_stop" }
        );
        assert_eq!(refused("feed_override"), ProbeError::Same("feed_override".to_string()));
    }

    #[test]
    fn comments_hold_nothing_that_ends_them() {
        let program = whole(&["a (b) 45° %;\u{7}é".to_string()], "G1 X1\n");
        assert_eq!(program.lines().next(), Some("(a  b  45 deg   ??)"));
        assert!(program.ends_with("G1 X1\nM30\n"));
    }
}
