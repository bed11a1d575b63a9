//! Archives: a thousand programs by one command, killed in the middle and gone on with, say what `predict` says of each.

mod programs;

use std::collections::BTreeMap;
use std::fs::{create_dir_all, read_to_string, remove_dir_all, write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use programs::write_programs;
use serde_json::Value;

const MACHINE: &str = "name = \"of the test\"
[interpolator]
filters = 3
time_constant_s = 0.0255
contour_tolerance_mm = 0.01
[rapid]
feed_mm_min = 12000
[times]
tool_change_s = 4.0
";

/// A folder of its own for a test, with a machine file in it.
struct Bench {
    folder: PathBuf,
}

impl Bench {
    fn new(name: &str) -> Bench {
        let folder =
            Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("archive-{name}-{}", std::process::id()));
        let _ = remove_dir_all(&folder);
        create_dir_all(folder.join("in")).expect("a writable folder");
        write(folder.join("m.toml"), MACHINE).expect("a writable folder");
        Bench { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// `truefeed predict` with the machine; `in` stands for the folder of programs.
    fn predict(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_truefeed"));
        command.current_dir(&self.folder).args(["predict", "--machine", "m.toml"]).args(arguments);
        command
    }

    fn done(&self, arguments: &[&str]) -> Output {
        self.predict(arguments).output().expect("the command starts")
    }

    /// What the file of lines holds, by path; each path once.
    fn lines(&self, out: &str) -> BTreeMap<String, Value> {
        by_path(&read_to_string(self.path(out)).expect("a file of lines"))
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = remove_dir_all(&self.folder);
    }
}

fn by_path(text: &str) -> BTreeMap<String, Value> {
    let mut lines = BTreeMap::new();
    for line in text.lines() {
        let value: Value = serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"));
        let path = value["path"].as_str().expect("a path").to_string();
        assert!(lines.insert(path.clone(), value).is_none(), "{path} has two lines");
    }
    lines
}

/// What is left of a line without what only archives say.
fn prediction(line: &Value) -> Value {
    let mut own = line.as_object().expect("an object").clone();
    assert!(own.remove("path").is_some() && own.remove("key").is_some(), "{line}");
    Value::Object(own)
}

fn json(text: &[u8]) -> Value {
    serde_json::from_slice(text).expect("JSON")
}

fn error(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_thousand_programs_killed_and_gone_on_with_are_those_predicted_one_by_one() {
    let bench = Bench::new("thousand");
    let paths = write_programs(&bench.path("in"), 1000);
    let request = ["in", "--ndjson", "--out", "out.ndjson", "--tolerance", "0.01", "--tolerance", "0.05"];

    let mut killed = bench.predict(&request).stderr(Stdio::null()).spawn().expect("the command starts");
    let lines = || read_to_string(bench.path("out.ndjson")).unwrap_or_default().matches('\n').count();
    let patience = Instant::now();
    while lines() < 300 {
        assert!(patience.elapsed() < Duration::from_secs(120), "{} lines after two minutes", lines());
        std::thread::sleep(Duration::from_millis(1));
    }
    killed.kill().expect("it runs");
    killed.wait().expect("it ends");
    let before = read_to_string(bench.path("out.ndjson")).expect("lines");
    let whole = &before[..=before.rfind('\n').expect("whole lines")];
    let kept = whole.lines().count();
    assert!((300..1000).contains(&kept), "killed in the middle, at {kept}");
    // A kill in the middle of a write leaves half a line.
    write(bench.path("out.ndjson"), format!("{whole}{{\"path\":\"in/job 1/0/par")).expect("a writable file");

    let resumed = bench.done(&request);
    assert_eq!(resumed.status.code(), Some(0), "{}", error(&resumed));
    let left = 1000 - kept;
    assert!(
        error(&resumed).contains(&format!("{left} of {left} programs, 0 with an error")),
        "{}",
        error(&resumed)
    );
    let text = read_to_string(bench.path("out.ndjson")).expect("lines");
    assert!(text.starts_with(whole), "what was there stays");

    let lines = by_path(&text);
    assert_eq!(lines.len(), 1000);
    for path in &paths {
        let named = path.strip_prefix(&bench.folder).expect("below").to_str().expect("UTF-8");
        let one = bench.done(&[named, "--json", "--tolerance", "0.01", "--tolerance", "0.05"]);
        assert_eq!(prediction(&lines[named]), json(&one.stdout), "{named}");
    }
    let times: Vec<f64> =
        lines.values().map(|line| line["runs"][0]["cycle_time_s"].as_f64().expect("a time")).collect();
    assert!(900 < times.iter().filter(|time| 1.0 < **time).count(), "programs that take time");

    let again = bench.done(&request);
    assert!(error(&again).contains("0 of 0 programs"), "{}", error(&again));
    assert_eq!(read_to_string(bench.path("out.ndjson")).expect("lines"), text, "nothing was left to do");
}

#[test]
fn one_bad_program_never_stops_the_rest() {
    let bench = Bench::new("bad");
    write_programs(&bench.path("in"), 20);
    write(bench.path("in/noise.nc"), [0u8, 159, 146, 150, b'G', b'1', 0, 0]).expect("a writable folder");
    let output = bench.done(&["missing.nc", "in", "in/noise.nc", "--ndjson"]);
    assert_eq!(output.status.code(), Some(1), "{}", error(&output));
    let lines = by_path(&String::from_utf8(output.stdout).expect("UTF-8"));
    assert_eq!(lines.len(), 22, "twenty, one that is missing, and one that only its name makes a program");
    let missing = &lines["missing.nc"];
    assert!(missing["error"].as_str().is_some_and(|error| error.contains("missing.nc")), "{missing}");
    assert_eq!(lines.values().filter(|line| line.get("error").is_some()).count(), 1);
    assert!(lines["in/noise.nc"]["diagnostics"].as_array().is_some_and(|remarks| !remarks.is_empty()));
}

#[test]
fn a_line_is_current_while_program_machine_and_request_are() {
    let bench = Bench::new("current");
    let paths = write_programs(&bench.path("in"), 10);
    let to_do = |arguments: &[&str]| {
        let listed = bench.done(&[&["in", "--ndjson", "--out", "o", "--list"], arguments].concat());
        assert_eq!(listed.status.code(), Some(0), "{}", error(&listed));
        by_path(&String::from_utf8(listed.stdout).expect("UTF-8")).len()
    };
    let run = |arguments: &[&str]| bench.done(&[&["in", "--ndjson", "--out", "o"], arguments].concat());
    assert_eq!(to_do(&[]), 10);
    run(&[]);
    assert_eq!((to_do(&[]), bench.lines("o").len()), (0, 10));

    let old = bench.lines("o");
    write(&paths[3], "G1 X10 F100\n").expect("a writable file");
    assert_eq!(to_do(&[]), 1, "the program that changed");
    run(&[]);
    let new = bench.lines("o");
    assert_eq!(new.len(), 10);
    assert_eq!(old.iter().filter(|(path, line)| new[*path] != **line).count(), 1);

    run(&["--tolerance", "0.02"]);
    assert_eq!(bench.lines("o").len(), 10, "another tolerance replaces all lines");
    assert_eq!(to_do(&["--tolerance", "0.02"]), 0);
    write(bench.path("m.toml"), MACHINE.replace("12000", "24000")).expect("a writable file");
    assert_eq!(to_do(&["--tolerance", "0.02"]), 10, "another machine");
}

#[test]
fn what_is_no_program_is_left_out_of_a_folder() {
    let bench = Bench::new("folder");
    for (name, text) in [
        ("a.nc", "G1 X1 F100\n"),
        ("letter.txt", "Dear reader,\nG1 is a move.\n"),
        ("program.txt", "%\nO1\nG0 X0\nG1 X10 F100\nM30\n"),
        ("log.nc", "time_s,x_mm,y_mm\n0,1,2\n0.1,2,3\n0.2,3,4\n"),
        ("part.h", "0 BEGIN PGM A MM\n1 L X+0 Y+0 R0 FMAX\n2 TOOL CALL 1 Z\n3 END PGM A MM\n"),
        ("header.h", "#pragma once\nint f();\nint g();\n"),
        ("m.toml", MACHINE),
        (".hidden.nc", "G1 X1 F100\n"),
    ] {
        write(bench.path("in").join(name), text).expect("a writable folder");
    }
    write(bench.path("in/blob.nc"), [0u8; 100]).expect("a writable folder");
    #[cfg(unix)]
    std::os::unix::fs::symlink(bench.path("in"), bench.path("in/loop")).expect("a link");
    let output = bench.done(&["in", "--ndjson"]);
    let lines = by_path(&String::from_utf8(output.stdout).expect("UTF-8"));
    let found: Vec<&str> = lines.keys().map(String::as_str).collect();
    assert_eq!(found, ["in/a.nc", "in/part.h", "in/program.txt"]);
}

#[test]
fn requests_that_cannot_be_carried_out_are_refused() {
    let bench = Bench::new("refused");
    write(bench.path("in/a.nc"), "G1 X1 F100\n").expect("a writable folder");
    write(bench.path("other"), "name,value\n").expect("a writable folder");
    for (arguments, said) in [
        (&["in/a.nc", "in/a.nc"][..], "--ndjson"),
        (&["in/a.nc", "--out", "x"], "need --ndjson"),
        (&["in", "--ndjson", "--jobs", "0"], "--jobs 0"),
        (&["--ndjson"], "which programs"),
        (&["-", "--ndjson"], "no name"),
        (&["in", "--ndjson", "--json"], "single program"),
        (&["in", "--ndjson", "--out", "other"], "not a file of predictions"),
        (&["in", "--ndjson", "--out", "nowhere/o"], "nowhere/o"),
    ] {
        let output = bench.done(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert_eq!(error(&output).trim_end().lines().count(), 1, "{}", error(&output));
        assert!(error(&output).contains(said), "{arguments:?}: {}", error(&output));
    }
    assert_eq!(read_to_string(bench.path("other")).expect("it is there"), "name,value\n");
}

/// The example that spreads the command over Dask, where `scripts/setup` could install that.
#[test]
fn the_engine_gives_the_lines_of_the_command_though_a_worker_is_killed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = root.join("target/dask/bin/python");
    if !python.exists() {
        return println!(
            "skipped: {} is not there; scripts/setup test installs Dask where it can",
            python.display()
        );
    }
    let bench = Bench::new("engine");
    write_programs(&bench.path("in"), 1000);
    let output = Command::new(python)
        .arg(root.join("examples/archive/test_archive.py"))
        .args([Path::new(env!("CARGO_BIN_EXE_truefeed")), &bench.path("m.toml"), &bench.path("in")])
        .output()
        .expect("Python starts");
    assert!(output.status.success(), "{}", error(&output));
    print!("{}", String::from_utf8_lossy(&output.stdout));
}
