//! The factory: draws programs and machines, records each program clean and with its changes, writes the answers.
//!
//! Two or three programs share a machine, so that what is learned on one can be tested on the others. A program that
//! LinuxCNC refuses, or that takes too short or too long, is counted and drawn again.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde_json::{Value, json};

use crate::changes::{Case, Drawn, KINDS, Kind};
use crate::geometry::Job;
use crate::kinds;
use crate::machine::Limits;
use crate::random::Random;
use crate::recorder::{Outcome, Recorder};
use crate::trace::{Row, Scale, Trace};
use crate::words::Manner;
use crate::{Refusal, side_by_side};

/// What is to be made.
pub struct Order {
    pub seed: u64,
    pub programs: usize,
    pub changes: usize,
    /// The kinds of changes to draw from; all if empty.
    pub kinds: Vec<String>,
    /// About how long each program takes, min; a single operation of less than two minutes if `None`.
    pub minutes: Option<f64>,
    pub recorder: Recorder,
    /// Recorders at work at a time.
    pub jobs: usize,
}

/// The shortest and the longest motion of a program, s.
const MOTION: RangeInclusive<f64> = 15.0..=110.0;
/// Ratios of the motion of a program to the time that was ordered, the least and the largest one.
const MOTION_RATIOS: (f64, f64) = (0.4, 2.5);
/// How often a program is drawn before the factory gives up.
const DRAWS: u64 = 20;

/// What is drawn for what, so that drawing more of one thing leaves the others as they are.
mod purpose {
    pub const MACHINES: u64 = 1;
    pub const KINDS: u64 = 2;
    pub const CHANGES: u64 = 3;
    pub const SETTINGS: u64 = 4;
    pub const PROGRAM: u64 = 1000;
    pub const CHANGE: u64 = 1_000_000;
}

/// A program with its clean recording.
struct Part {
    name: String,
    kind: &'static str,
    machine: usize,
    limits: Limits,
    manner: Manner,
    every: usize,
    clean: Trace,
    /// Why those drawn before it were not taken.
    refused: Vec<String>,
}

/// Makes everything that was ordered in `folder`.
pub fn record(order: &Order, folder: &Path) -> Result<(), Refusal> {
    std::fs::create_dir_all(folder)?;
    let machines = machines(order);
    let kinds = kinds_drawn(order);
    let parts = side_by_side(order.jobs, order.programs, |number| {
        let (machine, limits) = &machines[number];
        let part = part(order, folder, number, (*machine, limits), kinds[number])?;
        eprintln!("{}: {}, {:.1} s", part.name, part.kind, part.clean.duration());
        Ok(part)
    })?;
    let planned = changes_drawn(order, &parts);
    let done: Mutex<Vec<(usize, Value)>> = Mutex::new(Vec::new());
    write_answers(order, folder, &parts, &planned, &[])?;
    side_by_side(order.jobs, planned.len(), |number| {
        let (part, slot, kind) = planned[number];
        let answer = change(order, folder, &parts[part], slot, &KINDS[kind])?;
        eprintln!("{} {}: {} {}", parts[part].name, answer["file"], answer["kind"], answer["effect_s"]);
        let mut done = done.lock().map_err(|_| "a thread panicked")?;
        done.push((number, answer));
        write_answers(order, folder, &parts, &planned, &done)
    })?;
    Ok(())
}

/// The machine of each program, with its number.
fn machines(order: &Order) -> Vec<(usize, Limits)> {
    let mut random = Random::new(order.seed, purpose::MACHINES);
    let mut of_planner = Random::new(order.seed, purpose::SETTINGS);
    let mut all = Vec::new();
    for number in 0.. {
        if all.len() >= order.programs {
            break;
        }
        let limits = Limits::draw(&mut random).on(order.recorder.family, &mut of_planner);
        all.extend((0..2 + random.below(2)).map(|_| (number, limits.clone())));
    }
    all.truncate(order.programs);
    all
}

/// The numbers below `count`, in an order that is drawn.
fn shuffled(random: &mut Random, count: usize) -> Vec<usize> {
    let mut all: Vec<usize> = (0..count).collect();
    for place in (1..count).rev() {
        all.swap(place, random.below(place + 1));
    }
    all
}

/// Each kind once before any comes again.
fn kinds_drawn(order: &Order) -> Vec<usize> {
    let mut random = Random::new(order.seed, purpose::KINDS);
    let rounds = order.programs.div_ceil(kinds::KINDS.len());
    (0..rounds).flat_map(|_| shuffled(&mut random, kinds::KINDS.len())).collect()
}

/// Draws a program until LinuxCNC runs it in a time that is wanted.
fn part(
    order: &Order,
    folder: &Path,
    number: usize,
    (machine, limits): (usize, &Limits),
    kind: usize,
) -> Result<Part, Refusal> {
    let name = format!("p{:02}", number + 1);
    let place = folder.join(&name);
    std::fs::create_dir_all(&place)?;
    let ordered = order.minutes.map(|minutes| 60.0 * minutes);
    let motion = ordered.map_or(MOTION, |time| MOTION_RATIOS.0 * time..=MOTION_RATIOS.1 * time);
    let mut refused = Vec::new();
    for draw in 0..DRAWS {
        let mut random = Random::new(order.seed, purpose::PROGRAM + DRAWS * number as u64 + draw);
        let manner = Manner::draw(&mut random).on(order.recorder.family, limits);
        let every = random.pick(&[1, 2, 4, 5, 8]);
        let clearance = random.uniform(3.0, 12.0).round();
        let (kind, moves) = match order.minutes {
            Some(minutes) => {
                ("several operations", kinds::operations(&mut random, 60.0 * minutes, clearance))
            }
            None => {
                let mut job = Job::new(random.uniform(18.0, 55.0), clearance);
                let (kind, fill) = kinds::KINDS[kind];
                fill(&mut random, &mut job);
                (kind, job.moves)
            }
        };
        let program = place.join("program.ngc");
        std::fs::write(&program, manner.write(kind, clearance, &moves))?;
        match order.recorder.record(&program, &place.join("raw.csv.gz"), every, &limits.options())? {
            Outcome::Recorded(clean) if !motion.contains(&clean.duration()) => {
                refused.push(format!("{kind}: {:.1} s of motion", clean.duration()));
            }
            Outcome::Refused(why) => refused.push(format!("{kind}: {why}")),
            Outcome::Recorded(clean) => {
                clean.write(&place.join("clean.csv.gz"), Scale::Command)?;
                let limits = limits.clone();
                return Ok(Part { name, kind, machine, limits, manner, every, clean, refused });
            }
        }
        eprintln!("{name} is drawn again: {}", refused.last().map_or("", String::as_str));
    }
    Err(format!("{name}: {DRAWS} programs were refused, the last one: {:?}", refused.last()).into())
}

/// Which change is made where: every kind comes before any comes again, as far as programs have what it changes.
fn changes_drawn(order: &Order, parts: &[Part]) -> Vec<(usize, usize, usize)> {
    let mut random = Random::new(order.seed, purpose::CHANGES);
    let family = order.recorder.family;
    let is_ordered =
        |kind: &usize| order.kinds.is_empty() || order.kinds.iter().any(|name| name == KINDS[*kind].name);
    let possible: Vec<usize> = (0..KINDS.len()).filter(|kind| KINDS[*kind].on.contains(&family)).collect();
    let mut deck = Vec::new();
    let mut planned: Vec<(usize, usize, usize)> = Vec::new();
    for slot in 0..order.changes {
        for part in shuffled(&mut random, parts.len()) {
            let fits = |kind: &usize| {
                let taken = planned.iter().any(|(other, _, had)| *other == part && had == kind);
                !taken && (KINDS[*kind].applies)(&parts[part].manner)
            };
            let place = deck.iter().position(fits).unwrap_or_else(|| {
                let begin = deck.len();
                let all = shuffled(&mut random, possible.len()).into_iter().map(|place| possible[place]);
                deck.extend(all.filter(is_ordered));
                deck[begin..].iter().position(fits).map_or(begin, |place| begin + place)
            });
            planned.push((part, slot, deck.remove(place)));
        }
    }
    planned
}

/// Records a change and says what it was.
fn change(order: &Order, folder: &Path, part: &Part, slot: usize, kind: &Kind) -> Result<Value, Refusal> {
    let place = folder.join(&part.name);
    let number: u64 = part.name[1..].parse()?;
    let mut random = Random::new(order.seed, purpose::CHANGE + 100 * number + slot as u64);
    let case = Case {
        limits: &part.limits,
        manner: &part.manner,
        seconds: part.clean.duration(),
        fastest: part.clean.fastest(),
    };
    let drawn = (kind.draw)(&mut random, &case);
    // Of an option given twice the last one holds.
    let options = [part.limits.options(), drawn.options.clone()].concat();
    let file = format!("change-{}.csv.gz", slot + 1);
    let raw = place.join(format!("raw-{}.csv.gz", slot + 1));
    match order.recorder.record(&place.join("program.ngc"), &raw, part.every, &options)? {
        Outcome::Refused(why) => {
            Ok(json!({ "file": file, "kind": kind.name, "value": drawn.value, "refused": why }))
        }
        Outcome::Recorded(run) => {
            run.write(&place.join(&file), drawn.scale)?;
            Ok(answer(part, &run, kind, &drawn, &file))
        }
    }
}

/// What is concealed in a recording, and what it does to it.
fn answer(part: &Part, run: &Trace, kind: &Kind, drawn: &Drawn, file: &str) -> Value {
    let switched = |so: &dyn Fn(&Row) -> bool| {
        let found = run.while_so(so)?;
        Some(json!({ "time_s": found.0, "lines": found.1 }))
    };
    let interval = match kind.name {
        "feed_override_interval" => switched(&|row| (row.feed_override - 1.0).abs() > 1e-6),
        "feed_hold" => switched(&|row| row.held),
        "operator_pause" => {
            let at = drawn.value["at_s"].as_f64().unwrap_or(0.0);
            run.rows.iter().find(|row| row.t >= at).map(|row| json!({ "time_s": [at], "lines": [row.line] }))
        }
        _ => None,
    };
    json!({
        "file": file,
        "kind": kind.name,
        "value": drawn.value,
        "options": drawn.options,
        "effect_s": run.duration() - part.clean.duration(),
        "effect_mm": run.bend(drawn.scale),
        "lines_changed": run.lines_changed(&part.clean),
        "interval": interval,
        "seconds": run.duration(),
    })
}

/// Writes what is known so far, whole or not at all.
fn write_answers(
    order: &Order,
    folder: &Path,
    parts: &[Part],
    planned: &[(usize, usize, usize)],
    done: &[(usize, Value)],
) -> Result<(), Refusal> {
    let programs: Vec<Value> = (0..)
        .zip(parts)
        .map(|(index, part)| {
            let mut changes: Vec<&Value> =
                done.iter().filter(|(at, _)| planned[*at].0 == index).map(|(_, answer)| answer).collect();
            changes.sort_by_key(|answer| answer["file"].as_str());
            json!({
                "name": part.name, "kind": part.kind, "machine": part.machine, "limits": part.limits.to_json(),
                "manner": part.manner.to_json(), "row_ms": part.every, "clean_seconds": part.clean.duration(),
                "drawn_again": part.refused, "changes": changes,
            })
        })
        .collect();
    let answers = json!({ "seed": order.seed, "programs": programs });
    let draft: PathBuf = folder.join("answers.json.part");
    std::fs::write(&draft, serde_json::to_string_pretty(&answers)?)?;
    std::fs::rename(draft, folder.join("answers.json"))?;
    Ok(())
}
