//! Machine and two causes → [`Probe`]: a short program on which the two look different.
//!
//! A machine with a cause at some value is a point: what a recorder would see of it on a snippet, in
//! standard deviations of its noise. All values of a cause are a curve, here the chords through its trials
//! and a few between. The separation of a cause at one value from another cause is the distance of
//! its point from the other's curve,
//!
//! ```text
//! σ² = min_value Σ_snippets |w(cause) − w(other, value)|²
//! ```
//!
//! so the other cause has been fitted to it (T-optimality: Atkinson and Fedorov 1975). What is seen is
//! the time at places along the path, whitened as in `fit`, with [`STAMP`] a mark; where a cause leaves no
//! time but form, positions at equal times, the common delay taken out.
//!
//! Snippets are taken greedily, those first that separate most a second, until every pair of variants (axes,
//! rules), either way round, is [`ENOUGH`] apart and `SHORTEST` s are filled, or [`LONGEST`] s are used.
//!
//! Limits: a cause is tried at one middle strength; other parameters of the machine are taken as known.

mod separation;
mod snippets;

pub use snippets::{SPACE, Snippet, bank, top};

use thiserror::Error;

use crate::identification::effects::{self, Effect, Hypothesis, Trace, library};
use crate::identification::probe::separation::{Bench, Rivalry, rivalries};
use crate::machine::Machine;

/// Separated, in standard deviations.
pub const ENOUGH: f64 = 10.0;
/// Less than this is not told apart.
const LEAST: f64 = 5.0;
/// The longest program for two causes, s.
pub const LONGEST: f64 = 90.0;
/// A shorter program is made longer: other causes and held-out stretches want motion as well, s.
const SHORTEST: f64 = 20.0;
/// Standard deviation of the time of a mark, s: a recorder at 500 Hz.
pub const STAMP: f64 = 1e-3;

/// A program with what it is for.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// The program, G-code.
    pub program: String,
    /// What it does and how well, one sentence a line.
    pub summary: Vec<String>,
    /// How long it takes on the machine believed in, s.
    pub seconds: f64,
    /// How far apart the two causes are on it, in standard deviations; none where it is for all effects.
    pub separation: Option<f64>,
}

/// Why there is no such program.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ProbeError {
    /// No cause of this id.
    #[error("unknown cause {id}; the nearest known one is {nearest}")]
    Unknown {
        /// What was asked for.
        id: String,
        /// What there is.
        nearest: &'static str,
    },
    /// The same id twice.
    #[error("{0} is named twice; give two different causes")]
    Same(String),
    /// Nothing in a program brings it out.
    #[error("{id} cannot be probed: {why}")]
    Unprovoked {
        /// The cause.
        id: &'static str,
        /// Why, and what instead.
        why: &'static str,
    },
    /// The machine does not have it, or hides it.
    #[error("{0} shows on no program within this machine's limits; check what the machine file says of it")]
    Hidden(&'static str),
    /// Both look alike on everything.
    #[error(
        "{0} and {1} cannot be told apart by a program of {LONGEST} s: {2:.1} standard deviations; \
         change one of the two on the machine and record again"
    )]
    Alike(&'static str, &'static str, f64),
}

/// A program that separates two causes on a machine.
pub fn probe_between(machine: &Machine, causes: [&str; 2]) -> Result<Probe, ProbeError> {
    let [one, other] = [provoked(causes[0])?, provoked(causes[1])?];
    if one == other {
        return Err(ProbeError::Same(one.id.to_string()));
    }
    let bank = bank(machine);
    let programs: Vec<String> = bank.iter().map(|snippet| whole(&[], &snippet.lines)).collect();
    let benches: Vec<Bench> = programs.iter().map(|program| Bench::new(machine, program)).collect();
    let runs: Vec<_> = benches.iter().map(Bench::run).collect();
    let library = library(machine, &runs);
    let of = |effect: Effect| {
        let own: Vec<&Hypothesis> = library.iter().filter(|hypothesis| hypothesis.effect == effect).collect();
        if own.is_empty() { Err(ProbeError::Hidden(effect.id)) } else { Ok(own) }
    };
    let sides = [of(one)?, of(other)?];
    let is_form = sides.iter().flatten().any(|hypothesis| hypothesis.trace() == Trace::Form);
    let found = rivalries(machine, &benches, &sides, is_form);
    if let Some(side) = (0..2).find(|side| found.is_hidden[*side]) {
        return Err(ProbeError::Hidden([one, other][side].id));
    }
    let costs: Vec<f64> = benches.iter().map(Bench::seconds).collect();
    let chosen = chosen(&found.rivalries, &costs);
    let lines: String = chosen.iter().map(|at| bank[*at].lines.as_str()).collect();
    // What is stated is of the program as it is written, not of its parts.
    let bench = Bench::new(machine, &whole(&[], &lines));
    let seconds = bench.seconds();
    let reached = rivalries(machine, &[bench], &sides, is_form);
    let separation = least(&reached.rivalries, &[0]);
    if separation < LEAST {
        return Err(ProbeError::Alike(one.id, other.id, separation));
    }
    let summary = vec![
        format!("Probe for {}", machine.name),
        format!("separates {} from {}", one.id, other.id),
        format!("{seconds:.1} s, expected separation at least {separation:.0} standard deviations"),
        format!("recorded at 500 Hz with {:.0} ms of noise", 1e3 * STAMP),
    ];
    let mut heads = vec![space()];
    heads.extend(summary.iter().cloned());
    heads.extend(chosen.iter().map(|at| bank[*at].name.clone()));
    let program = whole(&heads, &lines);
    Ok(Probe { program, summary, seconds, separation: Some(separation) })
}

/// A program that brings out every effect on a machine.
pub fn probe_all(machine: &Machine) -> Probe {
    let bank = bank(machine);
    let lines: String = bank.iter().map(|snippet| snippet.lines.as_str()).collect();
    let seconds = Bench::new(machine, &whole(&[], &lines)).seconds();
    let summary = vec![
        format!("Probe for {}", machine.name),
        format!("exercises all effects in {} parts", bank.len()),
        format!("{seconds:.1} s"),
    ];
    let mut heads = vec![space()];
    heads.extend(summary.iter().cloned());
    Probe { program: whole(&heads, &lines), summary, seconds, separation: None }
}

/// What space a program needs, for people.
fn space() -> String {
    let [x, y, z] = SPACE;
    format!("Needs X0..{x} Y0..{y} Z0..{z} mm in air: no stock, no clamps")
}

/// A program of these lines with comments before them.
fn whole(heads: &[String], lines: &str) -> String {
    // Brackets would end a comment, and controls read no more than ASCII.
    let plain = |text: &String| -> String {
        let text = text.replace('°', " deg").replace(['(', ')', '%', ';'], " ");
        text.chars().map(|sign| if sign.is_ascii() && !sign.is_control() { sign } else { '?' }).collect()
    };
    let heads: String = heads.iter().map(|head| format!("({})\n", plain(head))).collect();
    format!("{heads}G21 G90 G94 G17\n{lines}M30\n")
}

/// The effect with this id, if a program can bring it out.
fn provoked(id: &str) -> Result<Effect, ProbeError> {
    let Some(effect) = effects::with_id(id) else {
        let distance = |effect: &&Effect| strsim::damerau_levenshtein(effect.id, id);
        let nearest = effects::ALL.iter().min_by_key(distance).expect("there are effects").id;
        return Err(ProbeError::Unknown { id: id.to_string(), nearest });
    };
    match effect.unprovoked {
        Some(why) => Err(ProbeError::Unprovoked { id: effect.id, why }),
        None => Ok(effect),
    }
}

/// The least separation over all rivalries on these snippets.
fn least(rivalries: &[Rivalry], chosen: &[usize]) -> f64 {
    rivalries.iter().map(|rivalry| rivalry.squared(chosen).sqrt()).fold(f64::INFINITY, f64::min)
}

/// The snippets that separate most a second, one after another, in their order in the bank.
fn chosen(rivalries: &[Rivalry], costs: &[f64]) -> Vec<usize> {
    // Somewhat more than enough: chords are not the curve.
    let goal = (1.5 * ENOUGH).powi(2);
    let score =
        |chosen: &[usize]| -> f64 { rivalries.iter().map(|rivalry| rivalry.squared(chosen).ln_1p()).sum() };
    let mut chosen: Vec<usize> = Vec::new();
    let mut used = 0.0;
    while used < SHORTEST || least(rivalries, &chosen) < goal.sqrt() {
        let now = score(&chosen);
        let gain = |at: usize| {
            let mut more = chosen.clone();
            more.push(at);
            (score(&more) - now) / costs[at].max(1e-3)
        };
        let open = (0..costs.len()).filter(|at| !chosen.contains(at));
        let fits = open.filter(|at| chosen.is_empty() || used + costs[*at] <= LONGEST);
        let best = fits.map(|at| (at, gain(at))).max_by(|a, b| a.1.total_cmp(&b.1));
        match best {
            Some((at, gain)) if 0.0 < gain || chosen.is_empty() => {
                used += costs[at];
                chosen.push(at);
            }
            _ => break,
        }
    }
    chosen.sort_unstable();
    chosen
}
