//! What a move or a rename must not change by a single bit: profiles, remarks, diagnoses and a calibration of what comes with
//! the repository. What unifies a rule or corrects a fault writes the file again, which shows what changed:
//! `TRUEFEED_UPDATE_EXPECTED=1 cargo test --test integration guard -- --include-ignored`.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use serde_json::Value;
use truefeed::identification::calibration::calibrate;
use truefeed::identification::diagnosis::diagnose;
use truefeed::identification::fit::{AlignedRun, Run};
use truefeed::identification::recording;
use truefeed::machine::Machine;
use truefeed::project::{DiagnosisReport, machine_from_toml, machine_values};
use truefeed::simulation::gcode::{Diagnostic, Dialect, Options, Severity, read_with};
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Toolpath;

use crate::shared::corpus;
use crate::shared::kept::{digest, kept};
use crate::shared::samples::samples;

/// Moments of a profile that are looked at.
const MOMENTS: u32 = 500;

/// Contour tolerance of the profiles, mm.
const TOLERANCE_MM: f64 = 0.02;

fn digest_of_numbers(numbers: impl IntoIterator<Item = f64>) -> u64 {
    digest(numbers.into_iter().flat_map(|number| number.to_bits().to_le_bytes()))
}

/// How the system's mathematics library rounds, by which bits may differ elsewhere.
fn rounding() -> u64 {
    let arguments = (1..=1000).map(|index| f64::from(index) * 0.01234);
    let functions: [fn(f64) -> f64; 6] = [f64::sin, f64::cos, f64::tan, f64::exp, f64::ln, f64::atan];
    digest_of_numbers(
        arguments
            .flat_map(|x| functions.map(|function| function(x)).into_iter().chain([x.powf(0.37), x.cbrt()])),
    )
}

fn read_text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn machine(path: &Path) -> Machine {
    machine_from_toml(&read_text(path)).unwrap_or_else(|fault| panic!("{}: {fault}", path.display()))
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The machine files of the tests, by name.
fn machines() -> BTreeMap<String, Machine> {
    let files = std::fs::read_dir(root().join("tests/data/machines")).expect("a folder");
    let paths = files.map(|entry| entry.expect("a readable folder").path());
    paths
        .map(|path| (path.file_stem().expect("a name").to_string_lossy().into_owned(), machine(&path)))
        .collect()
}

/// Position and feedrate at moments of equal distance in time.
fn profile(toolpath: &Toolpath, machine: &Machine) -> u64 {
    let (plan, _) = simulate::within(toolpath, machine, TOLERANCE_MM, &mut |_| {});
    let profile = Profile::new(toolpath, &plan);
    let whole = profile.cycle_time();
    let moments = (0..=MOMENTS).map(|moment| profile.at_time(whole * f64::from(moment) / f64::from(MOMENTS)));
    let numbers = moments.flat_map(|now| {
        let (at, along) = (now.position, now.velocity);
        [at.x, at.y, at.z, along.x, along.y, along.z, now.distance]
    });
    digest_of_numbers([whole].into_iter().chain(numbers))
}

/// How many remarks of each severity, and a digest of their places; words may change.
fn remarks(diagnostics: &[Diagnostic]) -> String {
    let count = |severity| diagnostics.iter().filter(|remark| remark.severity == severity).count();
    let [errors, warnings, infos] = [Severity::Error, Severity::Warning, Severity::Info].map(count);
    let places = diagnostics
        .iter()
        .map(|remark| format!("{:?} {} {:?}\n", remark.severity, remark.line.0, remark.columns));
    format!("{errors} {warnings} {infos} {:016x}", digest(places.collect::<String>().bytes()))
}

/// A run of the stand-in machine, as recorded.
fn recorded(case: &str) -> (Machine, AlignedRun) {
    let folder = corpus::recordings().join("plant").join(case);
    let machine = machine(&folder.join("machine.toml"));
    let program = read_with(read_text(&folder.join("program.nc")).as_bytes(), &Options::default());
    let bytes = std::fs::read(folder.join("recording.csv")).expect("a recording");
    let toolpath = trace(&program, &machine);
    let recorded = AlignedRun::with(toolpath, &bytes, &recording::ReadingOptions::default(), &machine);
    (machine, recorded.unwrap_or_else(|error| panic!("{case}: {error:?}")))
}

fn diagnosis(case: &str, table: &mut String) {
    let (machine, recorded) = recorded(case);
    let diagnosis = diagnose(&machine, &[recorded.run_ignoring_overrides()], &mut |_| {});
    let json = DiagnosisReport::new(&diagnosis, &[case.to_string()]).to_json();
    let report: Value = serde_json::from_str(&json).expect("JSON");
    let _ = writeln!(table, "diagnosis {case} {:016x}", digest(json.bytes()));
    for cause in report["causes"].as_array().expect("a list") {
        let _ =
            writeln!(table, "diagnosis {case} {} {} {}", cause["id"], cause["parameters"], cause["seconds"]);
    }
}

fn calibration(case: &str, table: &mut String) {
    let (_, recorded) = recorded(case);
    let start = machine(&root().join("tests/data/machines/generic.toml"));
    let runs: [Run; 1] = [recorded.run()];
    let calibration = calibrate(&start, &runs, &mut |_| {});
    let values =
        |machine: &Machine| -> Value { serde_json::from_str(&machine_values(machine)).expect("JSON") };
    let (before, after) = (values(&start), values(&calibration.machine));
    let changed =
        after.as_object().expect("an object").iter().filter(|(key, value)| before[key.as_str()] != **value);
    for (key, value) in changed.filter(|(key, _)| *key != "provenance") {
        let _ = writeln!(table, "calibration {case} {key} {value}");
    }
}

fn simulated() -> String {
    let mut table = format!("rounding {:016x}\n", rounding());
    let machines = machines();
    for sample in samples() {
        let (name, options) = (sample.name(), &sample.options);
        let program = read_with(&sample.bytes, options);
        let toolpath = trace(&program, &Machine::default());
        let _ = writeln!(table, "remarks {name} {}", remarks(&toolpath.diagnostics));
        if options.dialect == Some(Dialect::Iso) {
            for (of, machine) in &machines {
                let digest = profile(&trace(&program, machine), machine);
                let _ = writeln!(table, "profile {name} {of} {digest:016x}");
            }
        }
    }
    table
}

fn identified() -> String {
    let mut table = format!("rounding {:016x}\n", rounding());
    diagnosis("case-03", &mut table);
    diagnosis("case-09", &mut table);
    calibration("case-20", &mut table);
    table
}

/// Compares a table with the one kept; its bits only where the mathematics library rounds as on the system that wrote it.
fn is_as_kept(table: &str, name: &str) {
    let kept = kept(name, table);
    if table.lines().next() != kept.lines().next() {
        println!("skipped: bits of {name}: the mathematics library of this system rounds in its own way");
        let of_any_system = |text: &str| -> Vec<String> {
            text.lines().filter(|row| row.starts_with("remarks")).map(str::to_string).collect()
        };
        assert_eq!(of_any_system(table), of_any_system(&kept));
        return;
    }
    let differing: Vec<_> = kept.lines().zip(table.lines()).filter(|(kept, now)| kept != now).collect();
    assert!(differing.is_empty(), "kept and now: {differing:#?}");
    assert_eq!(table.lines().count(), kept.lines().count());
}

#[test]
#[ignore = "minutes: scripts/test --all"]
fn remarks_and_profiles_are_those_kept() {
    is_as_kept(&simulated(), "simulated.txt");
}

#[test]
#[ignore = "minutes: scripts/test --all"]
fn diagnoses_and_calibrations_are_those_kept() {
    is_as_kept(&identified(), "identified.txt");
}
