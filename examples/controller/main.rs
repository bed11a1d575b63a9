//! A factory of truth from controllers: programs as shops have them, run by an unmodified LinuxCNC, or by planners
//! written after grbl and Klipper, or by two planners whose ramps no law of Truefeed was written after (Marlin,
//! TinyG), once as declared and again with exactly one thing changed, and the scoring of what `truefeed` says about
//! them.
//!
//! Programs, machines, changes and strengths follow from the seed. LinuxCNC itself repeats a recording to the period,
//! but for some 20 ms wherever a word empties its queue. `record` needs root and the recorder that it is pointed to.
//! The answers lie in one file beside the programs, which the tool under test never opens.
//!
//! ```text
//! cargo run --release --example controller -- record --seed 1 --programs 12 --changes 3 --out DIR
//!     [--control grbl --kinds backlash,servo_lag --recorder ../shared/recorders/linuxcnc/record.py --jobs 2 --nice 10
//!      --minutes 10]
//! cargo run --release --example controller -- probe DIR [--control grbl --preset M.toml --recorder … --jobs 2]
//! cargo run --release --example controller -- score DIR --out REPORTS
//!     [--truefeed target/release/truefeed --preset M.toml --jobs 2]
//! cargo run --release --example controller -- pool docs/diagnosis > docs/seeds.md
//! ```
//!
//! With `--minutes`, each program consists of several operations of different kinds and takes about that long.
//!
//! `probe` records the project's probe on each machine of DIR as well; `score` then calibrates on it, too. `score`
//! keeps the report of each case in REPORTS and does not ask again for those in there, so an interrupted run
//! continues. It refuses a folder with the reports of another seed, build or preset. `pool` sums up the results of all seeds.

mod changes;
mod estimates;
mod factory;
mod figures;
mod geometry;
mod interval;
mod judge;
#[allow(dead_code, reason = "the corpus writes these moves in every dialect")]
#[path = "../corpus/jobs.rs"]
mod jobs;
mod kinds;
mod machine;
mod names;
mod planners;
mod pool;
mod probes;
#[allow(dead_code, reason = "the stand-in draws more from it")]
#[path = "../standin/random.rs"]
mod random;
mod recorder;
mod trace;
mod trial;
mod words;

use std::path::PathBuf;
use std::process::ExitCode;

use lexopt::prelude::*;

/// What is wrong with a request, in one line.
type Refusal = Box<dyn std::error::Error + Send + Sync>;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(refusal) => {
            eprintln!("controller: {refusal}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<(), Refusal> {
    let mut order = factory::Order {
        seed: 1,
        programs: 12,
        changes: 3,
        kinds: Vec::new(),
        minutes: None,
        recorder: recorder::Recorder {
            family: machine::Family::LinuxCnc,
            script: "../shared/recorders/linuxcnc/record.py".into(),
            nice: 0,
            speed: 8.0,
            wall_limit_s: recorder::WALL_LIMIT_S,
        },
        jobs: 2,
    };
    let mut bench = judge::Bench { truefeed: "target/release/truefeed".into(), preset: None, jobs: 2 };
    let mut out = None;
    let mut words: Vec<PathBuf> = Vec::new();
    let mut arguments = lexopt::Parser::from_env();
    while let Some(argument) = arguments.next()? {
        match argument {
            Value(word) => words.push(word.into()),
            Long("seed") => order.seed = arguments.value()?.parse()?,
            Long("programs") => order.programs = arguments.value()?.parse()?,
            Long("changes") => order.changes = arguments.value()?.parse()?,
            Long("kinds") => {
                let names = arguments.value()?.string()?;
                order.kinds = names.split(',').map(str::to_owned).collect();
                if let Some(other) = order.kinds.iter().find(|name| changes::named(name).is_none()) {
                    return Err(format!("no kind of change is called '{other}'").into());
                }
            }
            Long("minutes") => {
                let minutes: f64 = arguments.value()?.parse()?;
                order.minutes = Some(minutes);
                order.recorder.wall_limit_s = recorder::WALL_LIMIT_S + 60.0 * minutes;
            }
            Long("control") => {
                let name = arguments.value()?.string()?;
                order.recorder.family = machine::Family::named(&name).ok_or_else(|| {
                    let known = machine::Family::NAMES.map(|(own, _)| own).join(", ");
                    format!("no control is called '{name}': {known}")
                })?;
            }
            Long("recorder") => order.recorder.script = arguments.value()?.into(),
            Long("nice") => order.recorder.nice = arguments.value()?.parse()?,
            Long("speed") => order.recorder.speed = arguments.value()?.parse()?,
            Long("truefeed") => bench.truefeed = arguments.value()?.into(),
            Long("preset") => bench.preset = Some(arguments.value()?.into()),
            Long("jobs") => {
                order.jobs = arguments.value()?.parse()?;
                bench.jobs = order.jobs;
            }
            Long("out") => out = Some(PathBuf::from(arguments.value()?)),
            other => return Err(other.unexpected().into()),
        }
    }
    let command = words.first().and_then(|word| word.to_str()).unwrap_or_default();
    match (command, out, &words[words.len().min(1)..]) {
        ("record", Some(folder), []) => factory::record(&order, &folder),
        ("probe", None, [folder]) => probes::record(&bench, &order.recorder, folder),
        ("score", Some(reports), [folder]) => judge::score(&bench, folder, &reports),
        ("pool", None, [folder]) => {
            let (page, others) = pool::page(folder)?;
            others.iter().for_each(|file| eprintln!("controller: {file} belongs to no control"));
            print!("{page}");
            Ok(())
        }
        _ => Err("say `record --out DIR`, `probe DIR`, `score DIR --out REPORTS` or `pool RESULTS`".into()),
    }
}

/// Runs `work` for each number below `count` on `jobs` threads, and returns the results in the order of the numbers; the
/// first refusal ends it.
fn side_by_side<T: Send>(
    jobs: usize,
    count: usize,
    work: impl Fn(usize) -> Result<T, Refusal> + Sync,
) -> Result<Vec<T>, Refusal> {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let next = AtomicUsize::new(0);
    let one = || {
        let mut done = Vec::new();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count {
                return Ok(done);
            }
            match work(number) {
                Ok(result) => done.push((number, result)),
                Err(refusal) => {
                    next.store(count, Ordering::Relaxed);
                    return Err(refusal);
                }
            }
        }
    };
    let mut all = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..jobs.max(1)).map(|_| scope.spawn(one)).collect();
        let mut all = Vec::new();
        for thread in threads {
            let done: Result<_, Refusal> = thread.join().map_err(|_| "a thread panicked")?;
            all.extend(done?);
        }
        Ok::<_, Refusal>(all)
    })?;
    all.sort_by_key(|(number, _)| *number);
    Ok(all.into_iter().map(|(_, result)| result).collect())
}
