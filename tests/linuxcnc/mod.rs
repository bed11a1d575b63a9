//! Our toolpath against LinuxCNC's own interpreter, where its command `rs274` (Debian package
//! linuxcnc-uspace) is installed; otherwise each test says that it is skipped.
//!
//! One more file: `TRUEFEED_PROGRAM=part.ngc cargo test --test integration linuxcnc::programs_agree -- --nocapture`

mod canonical;
mod compare;
mod event;
mod generate;

use crate::linuxcnc::compare::Count;
use crate::shared::corpus;
use std::path::{Path, PathBuf};
use truefeed::simulation::gcode::Severity;

/// Programs on which we differ, and what for. The list is to shrink: one that agrees is a fault.
const DIFFERENCES: &[(&str, &str)] = &[
    ("cycles_boring.ngc", "G87 orients the spindle before it shifts, as on Fanuc controls, not after"),
    ("stops_beside_moves.ngc", "M5 and M9 wait for the move, as on Fanuc controls"),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Says and tells whether there is nothing to compare with.
fn is_skipped() -> bool {
    let is_skipped = !canonical::is_installed();
    if is_skipped {
        eprintln!(
            "skipped: LinuxCNC's interpreter: rs274 is not there; scripts/test --with-linuxcnc installs it"
        );
    }
    is_skipped
}

/// The NGC programs below a folder, in order.
fn programs(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        eprintln!("skipped: programs of others: {} is not there", folder.display());
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("a readable folder").path()).collect();
    paths.sort();
    let inside = |path: PathBuf| if path.is_dir() { programs(&path) } else { vec![path] };
    let is_program = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "ngc");
    paths.into_iter().flat_map(inside).filter(is_program).collect()
}

/// Whether we do the same as LinuxCNC. What it refuses must not pass without a word with us.
fn agrees(program: &[u8]) -> Result<Count, String> {
    let toolpath = event::traced(program);
    let run = canonical::run(program);
    let count = compare::compare(&event::events(&toolpath), &run)?;
    let is_warned = toolpath.diagnostics.iter().any(|found| Severity::Warning <= found.severity);
    match run.refusal {
        Some(refusal) if !is_warned => Err(format!("LinuxCNC refuses it and we say nothing: {refusal}")),
        _ => Ok(count),
    }
}

#[test]
fn programs_agree() {
    if is_skipped() {
        return;
    }
    let folders = [
        root().join("tests/data/programs"),
        corpus::programs(),
        corpus::recordings().join("linuxcnc"),
        root().join("../shared/gcode/linuxcnc"),
    ];
    let mut faults = Vec::new();
    let mut total = Count::default();
    let named = std::env::var_os("TRUEFEED_PROGRAM").map(PathBuf::from);
    let all: Vec<PathBuf> = folders.iter().flat_map(|folder| programs(folder)).chain(named).collect();
    for path in &all {
        let name = path.file_name().expect("a file").to_string_lossy();
        let expected = DIFFERENCES.iter().find(|(program, _)| *program == name);
        match (agrees(&std::fs::read(path).expect("a readable file")), expected) {
            (Ok(count), None) => {
                println!(
                    "{name}: agrees in {} lines, {} arcs, {} others",
                    count.moves, count.arcs, count.others
                );
                total += count;
            }
            (Err(difference), Some((_, why))) => println!("{name}: differs, as known ({why}): {difference}"),
            (Ok(_), Some(_)) => {
                faults.push(format!("{name} agrees now: take it off the list of differences"))
            }
            (Err(difference), None) => faults.push(format!("{name}: {difference}")),
        }
    }
    println!("{} programs, {total:?} agree", all.len());
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// How many random programs are run; thousands by `TRUEFEED_PROGRAMS=5000`.
const PROGRAMS: u64 = 200;

#[test]
fn random_programs_agree() {
    if is_skipped() {
        return;
    }
    let asked = std::env::var("TRUEFEED_PROGRAMS").ok();
    let programs = asked.map_or(PROGRAMS, |asked| asked.parse().expect("TRUEFEED_PROGRAMS is a number"));
    let (mut total, mut faults) = (Count::default(), Vec::new());
    for seed in 0..programs {
        let text = generate::program(seed);
        let run = canonical::run(text.as_bytes());
        let result = match &run.refusal {
            Some(refusal) => Err(format!("it is no program for LinuxCNC: {refusal}")),
            None => compare::compare(&event::events(&event::traced(text.as_bytes())), &run),
        };
        match result {
            Ok(count) => total += count,
            Err(fault) => faults.push((seed, fault, text)),
        }
    }
    println!("{} of {programs} random programs agree: {total:?}", programs as usize - faults.len());
    let shortest = faults.iter().min_by_key(|(.., text)| text.len());
    if let Some((seed, fault, text)) = shortest {
        let path = std::env::temp_dir().join(format!("truefeed-random-{seed}.ngc"));
        std::fs::write(&path, text).expect("a writable folder");
        let seeds: Vec<u64> = faults.iter().map(|(seed, ..)| *seed).collect();
        panic!("programs {seeds:?} differ; the shortest of them, {}: {fault}", path.display());
    }
}
