//! The judge: asks the tool under test about every recording of a folder, and holds what it says against the answers.
//!
//! Each machine is calibrated on the clean run of one program, from a preset and nothing else. With that machine file
//! the clean run itself is diagnosed, and so are the runs with a change and the clean runs of the other programs of the
//! same machine, whose cycle times are predicted too. Each clean run is also diagnosed from the preset itself.
//! Where the project's probe was recorded on a machine, it is calibrated
//! on that as well, and every program of the machine is diagnosed and predicted with it.
//!
//! What can be seen is laid down here, before anything is run: a change counts as visible where it changes the time of
//! the run by [`VISIBLE_SHARE`] and [`VISIBLE_S`], or bends the recorded path by [`VISIBLE_MM`].

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use truefeed::machine::presets;
use truefeed::project::toml_from_machine;

use crate::changes;
use crate::estimates;
use crate::figures;
use crate::names::{is_right, is_right_name};
use crate::trial::ask;
use crate::{Refusal, side_by_side};

/// Of the time of the clean run.
const VISIBLE_SHARE: f64 = 0.003;
/// Of the time of the run, s.
const VISIBLE_S: f64 = 0.1;
/// Of the recorded path, mm.
const VISIBLE_MM: f64 = 0.01;

/// What is judged, and how.
pub struct Bench {
    pub truefeed: PathBuf,
    /// The machine file to begin with; the preset of the project where none is given.
    pub preset: Option<PathBuf>,
    /// Trials at a time.
    pub jobs: usize,
}

impl Bench {
    /// Returns the machine file that a user starts from, before any calibration. In a preset of the project the tool
    /// change takes no time: the recorded control has no tool changer, and a program without a tool change cannot show
    /// its time.
    pub fn begin_with(&self) -> Result<String, Refusal> {
        if let Some(file) = &self.preset {
            return Ok(std::fs::read_to_string(file)?);
        }
        let all = presets();
        let of = |word: &str| all.iter().find(|preset| preset.machine.name.contains(word));
        let preset =
            of("LinuxCNC").or_else(|| of("mid-range")).ok_or("the project has no preset to begin with")?;
        let mut machine = preset.machine.clone();
        machine.times.tool_change = 0.0;
        Ok(toml_from_machine(&machine))
    }
}

/// One diagnosis that is asked for.
struct Trial<'a> {
    /// The program whose clean run the machine file is calibrated on.
    of: &'a str,
    /// Whether the machine file is the preset instead.
    is_from_preset: bool,
    /// Whether that program is the probe.
    is_probed: bool,
    /// The program that was run.
    program: &'a Value,
    /// The recording of it.
    file: String,
    /// What is concealed in it.
    change: Option<&'a Value>,
}

/// Asks about everything in `folder`, prints the figures and writes them to `reports`.
pub fn score(bench: &Bench, folder: &Path, reports: &Path) -> Result<(), Refusal> {
    let answers: Value = serde_json::from_slice(&std::fs::read(folder.join("answers.json"))?)?;
    let programs = answers["programs"].as_array().ok_or("the answers name no programs")?;
    let version = std::process::Command::new(&bench.truefeed).arg("--version").output()?;
    let version = String::from_utf8_lossy(&version.stdout).trim().to_string();
    std::fs::create_dir_all(reports)?;
    let begin_with = bench.begin_with()?;
    claim(reports, &json!({ "seed": answers["seed"], "truefeed": version, "preset": begin_with }))?;
    let preset = reports.join("preset.toml");
    std::fs::write(&preset, begin_with)?;
    let probes = answers["probes"].as_array().map_or(&[][..], Vec::as_slice);
    let sources: Vec<&Value> = programs.iter().chain(probes).collect();
    let said = side_by_side(bench.jobs, sources.len(), |number| {
        calibrate(bench, folder, reports, &preset, name(sources[number]))
    })?;
    let said = || sources.iter().zip(&said);
    let limits: Vec<Value> =
        said().flat_map(|(source, said)| estimates::limits_of(source, &said["report"])).collect();
    let refused: Vec<Value> = said()
        .filter(|(_, said)| said["report"].is_null())
        .map(|(source, said)| json!({ "program": source["name"], "refused": said["refused"] }))
        .collect();
    let calibrated = |program: &Value| !refused.iter().any(|one| one["program"] == program["name"]);
    let trials = trials(programs, &sources, &calibrated);
    let cases = side_by_side(bench.jobs, trials.len(), |number| {
        let case = case(bench, folder, reports, &trials[number])?;
        eprintln!("{} {}: {} {}", case["case"], case["kind"], case["outcome"], case["named"]);
        Ok(case)
    })?;
    let transfers = transfers(bench, folder, reports, programs, &sources, &calibrated)?;
    let mut results = figures::results(&answers, cases, transfers);
    results["limits_within"] = estimates::within(&limits);
    results["limits"] = json!(limits);
    results["calibrations"] = json!({ "of": sources.len(), "refused": refused });
    results["truefeed"] = json!(version);
    std::fs::write(reports.join("results.json"), serde_json::to_string_pretty(&results)?)?;
    let page = figures::page(&results);
    std::fs::write(reports.join("figures.md"), &page)?;
    print!("{page}");
    Ok(())
}

/// Writes into the folder `reports` which seed, build and preset it belongs to. Refuses a folder that belongs to others,
/// because its reports would count as answers of this build.
fn claim(reports: &Path, scored: &Value) -> Result<(), Refusal> {
    let place = reports.join("scored.json");
    let kept: Option<Value> =
        std::fs::read(&place).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    if let Some(kept) = kept.filter(|kept| kept != scored) {
        let of = format!("{} by {}", kept["seed"], kept["truefeed"]);
        return Err(
            format!("{} holds the reports of the seed {of}: give another --out", reports.display()).into()
        );
    }
    std::fs::write(place, serde_json::to_string(scored)?)?;
    Ok(())
}

fn is_probe(program: &Value) -> bool {
    program["kind"] == "probe"
}

fn name(program: &Value) -> &str {
    program["name"].as_str().unwrap_or_default()
}

/// The machine file calibrated on the clean run of a program; the preset where that is refused.
fn calibrate(
    bench: &Bench,
    folder: &Path,
    reports: &Path,
    preset: &Path,
    name: &str,
) -> Result<Value, Refusal> {
    let place = reports.join(name);
    std::fs::create_dir_all(&place)?;
    let [program, run] = ["program.ngc", "clean.csv.gz"].map(|file| folder.join(name).join(file));
    let out = place.join("machine.toml");
    let words = [
        "calibrate",
        "--machine",
        &text(preset),
        "--run",
        &text(&program),
        &text(&run),
        "--out",
        &text(&out),
    ];
    let said = ask(&bench.truefeed, &words, &place.join("calibrate.json"))?;
    if !out.exists() {
        std::fs::copy(preset, &out)?;
    }
    Ok(said)
}

fn text(path: &Path) -> String {
    path.display().to_string()
}

/// Every clean run with the machine file of its program and with the preset, every change with the file of its program,
/// and the clean runs of the other programs
/// of its machine, unless the calibration was refused.
fn trials<'a>(
    programs: &'a [Value],
    sources: &[&'a Value],
    calibrated: &dyn Fn(&Value) -> bool,
) -> Vec<Trial<'a>> {
    let mut trials = Vec::new();
    for &program in sources {
        let (of, is_probed) = (name(program), is_probe(program));
        let run = |program, file: &str, change| Trial {
            of,
            is_from_preset: false,
            is_probed,
            program,
            file: file.into(),
            change,
        };
        let clean = |program| run(program, "clean.csv.gz", None);
        trials.push(clean(program));
        if !is_probed {
            trials.push(Trial { is_from_preset: true, ..clean(program) });
        }
        for change in program["changes"].as_array().into_iter().flatten() {
            if change["refused"].is_null() {
                trials.push(run(program, change["file"].as_str().unwrap_or_default(), Some(change)));
            }
        }
        if calibrated(program) {
            trials.extend(others(programs, program).map(clean));
        }
    }
    trials
}

/// The other programs of the same machine.
fn others<'a>(programs: &'a [Value], program: &'a Value) -> impl Iterator<Item = &'a Value> {
    programs
        .iter()
        .filter(move |other| other["machine"] == program["machine"] && name(other) != name(program))
}

/// Asks for one diagnosis and judges it.
fn case(bench: &Bench, folder: &Path, reports: &Path, trial: &Trial) -> Result<Value, Refusal> {
    let (ran, stem) = (name(trial.program), trial.file.trim_end_matches(".csv.gz"));
    let [program, run] = ["program.ngc", &trial.file].map(|file| folder.join(ran).join(file));
    let place = reports.join(trial.of);
    let (kept, machine) = match (trial.is_from_preset, ran == trial.of) {
        (true, _) => (format!("{stem}-from-preset.json"), reports.join("preset.toml")),
        (false, true) => (format!("{stem}.json"), place.join("machine.toml")),
        (false, false) => (format!("{stem}-of-{ran}.json"), place.join("machine.toml")),
    };
    let words = ["diagnose", &text(&program), &text(&run), "--machine", &text(&machine)];
    let said = ask(&bench.truefeed, &words, &place.join(kept))?;
    let role = match (trial.change, ran == trial.of) {
        _ if trial.is_from_preset => "preset",
        (Some(_), _) => "change",
        (None, true) => "clean",
        (None, false) if trial.is_probed => "probed",
        (None, false) => "other",
    };
    let mut case = judged(&said, trial.change);
    case["case"] = json!(format!("{ran}/{stem}"));
    case["calibrated_on"] = json!((!trial.is_from_preset).then_some(trial.of));
    case["role"] = json!(role);
    case["program_kind"] = trial.program["kind"].clone();
    case["visible"] = json!(trial.change.is_some_and(|change| is_visible(change, trial.program)));
    Ok(case)
}

/// Whether a change does enough that a recording could show it, by the answers alone.
fn is_visible(change: &Value, program: &Value) -> bool {
    let number = |value: &Value| value.as_f64().unwrap_or(0.0).abs();
    let bends = change["kind"].as_str().and_then(changes::named).is_some_and(|kind| kind.bends_path);
    if bends {
        return number(&change["effect_mm"]) >= VISIBLE_MM;
    }
    number(&change["effect_s"]) >= (VISIBLE_SHARE * number(&program["clean_seconds"])).max(VISIBLE_S)
}

/// What was said beside what is true.
fn judged(said: &Value, change: Option<&Value>) -> Value {
    let report = &said["report"];
    let causes: Vec<&Value> = report["causes"].as_array().into_iter().flatten().collect();
    let kind = change.and_then(|change| change["kind"].as_str()).unwrap_or("none");
    let value = change.map_or(&Value::Null, |change| &change["value"]);
    let rights: Vec<bool> = causes.iter().map(|cause| is_right(kind, value, cause)).collect();
    let alike = |cause: &&Value| {
        let set = cause["indistinguishable_from"].as_array().into_iter().flatten();
        set.filter_map(|other| other.as_str().or(other["id"].as_str()))
            .any(|name| is_right_name(kind, value, name))
    };
    let refused = report.is_null() || report["verdict"] == "not_comparable";
    let outcome = match (refused, rights.first(), report["verdict"].as_str()) {
        (true, ..) => "refused",
        (_, None, Some("nothing_missing")) => "silent",
        (_, None, _) => "unknown",
        (_, Some(_), _) if change.is_none() => "named",
        (_, Some(true), _) => "first",
        _ if rights.contains(&true) || causes.first().is_some_and(alike) => "later",
        _ => "wrong",
    };
    let named: Vec<Value> = causes
        .iter()
        .zip(&rights)
        .map(|(cause, right)| {
            json!({ "id": cause["id"], "parameters": cause["parameters"], "seconds": cause["seconds"],
                    "confidence": cause["confidence"], "right": right })
        })
        .collect();
    json!({
        "kind": kind, "truth": value, "effect_s": change.map(|change| &change["effect_s"]),
        "effect_mm": change.map(|change| &change["effect_mm"]), "outcome": outcome, "verdict": report["verdict"],
        "named": named, "seconds": said["seconds"], "refused": said["refused"], "said": report["sentence"],
        "exit_status": said["exit_status"],
        "cycle_time_error_s": report["fit"]["cycle_time_error_s"],
    })
}

/// The predicted cycle times of each program by every machine file that was calibrated on a program of its machine,
/// itself included, and by the preset.
fn transfers(
    bench: &Bench,
    folder: &Path,
    reports: &Path,
    programs: &[Value],
    sources: &[&Value],
    calibrated: &dyn Fn(&Value) -> bool,
) -> Result<Vec<Value>, Refusal> {
    let mut all = Vec::new();
    for program in programs {
        let ran = name(program);
        let recorded = program["clean_seconds"].as_f64().unwrap_or(f64::NAN);
        let path = text(&folder.join(ran).join("program.ngc"));
        let predicted = |machine: &Path, kept: PathBuf| -> Result<(Option<f64>, Value), Refusal> {
            let said = ask(&bench.truefeed, &["predict", &path, "--machine", &text(machine)], &kept)?;
            let run = &said["report"]["runs"][0];
            Ok((run["cycle_time_s"].as_f64().map(|time| time / recorded - 1.0), run["range"].clone()))
        };
        let (before, _) =
            predicted(&reports.join("preset.toml"), reports.join(ran).join("predict-preset.json"))?;
        let is_of_machine = |of: &&&Value| of["machine"] == program["machine"] && calibrated(of);
        for source in sources.iter().filter(is_of_machine) {
            let of = name(source);
            let place = reports.join(of);
            let kept = place.join(format!("predict-{ran}.json"));
            let (after, range) = predicted(&place.join("machine.toml"), kept)?;
            let half = range["percent"].as_f64().map(|percent| percent / 100.0);
            all.push(json!({ "program": ran, "program_kind": program["kind"], "calibrated_on": of,
                             "own": of == ran, "probed": is_probe(source), "error": after, "range": half, "unshown": range["unshown"], "error_of_preset": before }));
        }
    }
    Ok(all)
}
