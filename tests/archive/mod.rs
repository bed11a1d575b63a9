//! Archives: a thousand programs by one command, which is killed and continues, say what `predict` says of each.

mod programs;

use std::collections::BTreeMap;
#[cfg(unix)]
use std::fs::{File, OpenOptions, remove_file};
use std::fs::{create_dir_all, read_to_string, remove_dir_all, write};
#[cfg(unix)]
use std::io::Write;
#[cfg(unix)]
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::process::{Child, Stdio};
use std::process::{Command, Output};

use crate::archive::programs::write_programs;
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

#[cfg(unix)]
const GATE: &str = "G1 X10 F100\n";

/// The folder of a test, with a machine file in it.
pub struct Bench {
    pub folder: PathBuf,
}

impl Bench {
    pub fn new(name: &str) -> Bench {
        let folder =
            Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("archive-{name}-{}", std::process::id()));
        let _ = remove_dir_all(&folder);
        create_dir_all(folder.join("in")).expect("a writable folder");
        write(folder.join("m.toml"), MACHINE).expect("a writable folder");
        Bench { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// `truefeed` in the folder.
    pub fn truefeed(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_truefeed"));
        command.current_dir(&self.folder).args(arguments);
        command
    }

    /// `truefeed predict` with the machine; `in` is the folder of programs.
    pub fn predict(&self, arguments: &[&str]) -> Command {
        let mut command = self.truefeed(&["predict", "--machine", "m.toml"]);
        command.args(arguments);
        command
    }

    pub fn done(&self, arguments: &[&str]) -> Output {
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

/// The command with files that grow to no more than `blocks` of 512 or 1,024 bytes; more is refused and no signal.
#[cfg(unix)]
pub fn limited(command: &Command, blocks: u32) -> Command {
    let mut limited = Command::new("sh");
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    limited.args(["-c", &script]).arg(command.get_program()).args(command.get_args());
    limited.current_dir(command.get_current_dir().expect("a folder"));
    limited
}

/// What a command says on standard error.
pub fn error(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A program that a run cannot read to its end before the test lets it: a pipe. What stands before it in the request is
/// done then, and the run still holds its file.
#[cfg(unix)]
pub struct Gate {
    path: PathBuf,
    run: Child,
    entry: File,
}

#[cfg(unix)]
impl Gate {
    /// Starts the run and returns when it waits at the program `name`.
    pub fn new(bench: &Bench, name: &str, run: &mut Command) -> Gate {
        let path = bench.path(name);
        let made = Command::new("mkfifo").arg(&path).status().expect("mkfifo starts");
        assert!(made.success());
        let run = run.stderr(Stdio::null()).spawn().expect("the command starts");
        // Opening a pipe takes until the other end is opened too.
        let entry = OpenOptions::new().write(true).open(&path).expect("the run opens it");
        Gate { path, run, entry }
    }

    /// Waits until the run, which waits for its program, has written `count` lines.
    pub fn wait_for_lines(&mut self, out: &Path, count: usize) {
        while read_to_string(out).unwrap_or_default().matches('\n').count() < count {
            assert_eq!(self.run.try_wait().expect("a child"), None, "it waits for its program");
            std::thread::yield_now();
        }
    }

    /// Kills the run, and puts a program in the place of the pipe.
    pub fn kill(mut self, program: &str) {
        self.run.kill().expect("it runs");
        self.run.wait().expect("it ends");
        remove_file(&self.path).expect("a pipe");
        write(&self.path, program).expect("a writable folder");
    }

    /// Lets the run read the program; its exit status.
    pub fn open(mut self, program: &str) -> Option<i32> {
        self.entry.write_all(program.as_bytes()).expect("the run reads");
        drop(self.entry);
        self.run.wait().expect("it ends").code()
    }
}

#[cfg(unix)]
#[test]
fn a_thousand_programs_killed_and_continued_are_those_predicted_without_a_break_and_one_by_one() {
    let bench = Bench::new("thousand");
    let paths = write_programs(&bench.path("in"), 1000);
    let before: usize = paths.iter().filter(|path| path.starts_with(bench.path("in/job 0"))).count();
    let tolerances = ["--tolerance", "0.01", "--tolerance", "0.05"];
    let request = [&["in/job 0", "gate.nc", "in", "--ndjson", "--out", "o"], &tolerances[..]].concat();

    let mut gate = Gate::new(&bench, "gate.nc", bench.predict(&request).args(["--jobs", "1"]));
    gate.wait_for_lines(&bench.path("o"), before);
    gate.kill(GATE);
    let whole = read_to_string(bench.path("o")).expect("lines");
    assert_eq!(by_path(&whole).len(), before, "a run writes whole lines");
    // A kill in the middle of a write leaves half a line.
    write(bench.path("o"), format!("{whole}{{\"path\":\"in/job 1/0/par")).expect("a writable file");

    let resumed = bench.done(&request);
    assert_eq!(resumed.status.code(), Some(0), "{}", error(&resumed));
    let left = 1001 - before;
    let said = format!("{left} of {left} programs, 0 with an error");
    assert!(error(&resumed).contains(&said), "{}", error(&resumed));
    let text = read_to_string(bench.path("o")).expect("lines");
    assert!(text.starts_with(&whole), "what was there stays");

    let lines = by_path(&text);
    let unbroken = bench.done(&[&["in", "gate.nc", "--ndjson"], &tolerances[..]].concat());
    assert_eq!(lines, by_path(&String::from_utf8(unbroken.stdout).expect("UTF-8")));
    // Each of the kinds of programs, and some more.
    for path in [0, 11, 21, 31, 41, 42, 500, 711, 821, 999].map(|index: usize| &paths[index]) {
        let named = path.strip_prefix(&bench.folder).expect("below").to_str().expect("UTF-8");
        let one = bench.done(&[&[named, "--json"], &tolerances[..]].concat());
        assert_eq!(prediction(&lines[named]), json(&one.stdout), "{named}");
    }
    let times: Vec<f64> =
        lines.values().map(|line| line["runs"][0]["cycle_time_s"].as_f64().expect("a time")).collect();
    assert!(900 < times.iter().filter(|time| 1.0 < **time).count(), "programs that take time");

    let again = bench.done(&request);
    assert!(error(&again).contains("0 of 0 programs"), "{}", error(&again));
    assert_eq!(read_to_string(bench.path("o")).expect("lines"), text, "nothing was left to do");
}

#[cfg(unix)]
#[test]
fn a_second_run_to_the_same_file_is_refused_and_the_first_loses_nothing() {
    let bench = Bench::new("two");
    write_programs(&bench.path("in"), 20);
    let request = ["in", "gate.nc", "--ndjson", "--out", "o"];
    let mut gate = Gate::new(&bench, "gate.nc", bench.predict(&request).args(["--jobs", "1"]));
    gate.wait_for_lines(&bench.path("o"), 20);
    symlink("o", bench.path("other name")).expect("a link");
    for out in ["o", "other name"] {
        let second = bench.done(&["in", "--ndjson", "--tolerance", "0.5", "--out", out]);
        assert_eq!(second.status.code(), Some(2));
        assert!(error(&second).contains("another run is writing"), "{}", error(&second));
    }
    assert_eq!(gate.open(GATE), Some(0));
    assert_eq!(bench.lines("o").len(), 21);
}

/// A file that somebody else wrote is no place for lines, even where it is a single line without an end.
#[test]
fn a_file_of_something_else_stays_as_it_is() {
    let bench = Bench::new("precious");
    write(bench.path("in/a.nc"), "G1 X1 F100\n").expect("a writable folder");
    for text in [
        "{\"precious\":1}",
        "{",
        "{\"pa",
        "{\"path\":\"in/a.nc\",\"ke",
        "G1X1F100 G1X2",
        "{\"path\":\"in/a.nc\"}\n",
        "{\"path\":\"in/a.nc\",\"customer\":\"Smith\"}\n",
        "{\"path\":\"in/a.nc\",\"customer\":\"Smith\"}",
        "\0\0\0\0",
    ] {
        write(bench.path("o"), text).expect("a writable folder");
        for more in [&[][..], &["--list"]] {
            let output = bench.done(&[&["in", "--ndjson", "--out", "o"], more].concat());
            assert_eq!(output.status.code(), Some(2), "{text}");
            assert!(error(&output).contains("o: line 1 is not a prediction"), "{}", error(&output));
        }
        assert_eq!(read_to_string(bench.path("o")).expect("it is there"), text);
    }
}

#[test]
fn a_whole_line_without_an_end_stays() {
    let bench = Bench::new("unterminated");
    write(bench.path("in/a.nc"), "G1 X1 F100\n").expect("a writable folder");
    write(bench.path("in/b.nc"), "G1 X2 F100\n").expect("a writable folder");
    bench.done(&["in/a.nc", "--ndjson", "--out", "o"]);
    let line = read_to_string(bench.path("o")).expect("a line");
    write(bench.path("o"), line.trim_end()).expect("a writable file");
    bench.done(&["in/b.nc", "--ndjson", "--out", "o"]);
    assert!(read_to_string(bench.path("o")).expect("lines").starts_with(&line));
    assert_eq!(bench.lines("o").len(), 2);
}

/// A limit on the length of files fails a write in the middle of a line, as a full disk does.
#[cfg(unix)]
#[test]
fn a_run_that_a_full_disk_stopped_continues() {
    let bench = Bench::new("full");
    write_programs(&bench.path("in"), 30);
    let request = ["in", "--ndjson", "--out", "o"];
    let stopped = limited(&bench.predict(&request), 20).output().expect("a shell starts");
    assert_eq!(stopped.status.code(), Some(2), "{}", error(&stopped));
    assert!(error(&stopped).contains("truefeed: o: "), "{}", error(&stopped));
    let before = read_to_string(bench.path("o")).expect("lines");
    let whole = &before[..=before.rfind('\n').expect("a whole line")];
    assert!(whole.len() < before.len(), "it stopped in the middle of a line");
    assert_eq!(bench.done(&request).status.code(), Some(0));
    assert!(read_to_string(bench.path("o")).expect("lines").starts_with(whole));
    assert_eq!(bench.lines("o").len(), 30);
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

/// As many as a shop has from twenty years: neither the list of files nor the resumption may look at each for each.
#[test]
#[ignore = "writes and reads 100,000 files"]
fn a_hundred_thousand_small_files_are_predicted_and_then_known() {
    const FOLDERS: usize = 100;
    const FILES: usize = 1000;
    let bench = Bench::new("many");
    for folder in 0..FOLDERS {
        let path = bench.path("in").join(folder.to_string());
        create_dir_all(&path).expect("a writable folder");
        for file in 0..FILES {
            let program = format!("G1 X{} F100\n", 1 + file);
            write(path.join(format!("{file}.nc")), program).expect("a writable folder");
        }
    }
    let run = || bench.done(&["in", "--ndjson", "--out", "o"]);
    let first = run();
    assert_eq!(first.status.code(), Some(0), "{}", error(&first));
    let count = FOLDERS * FILES;
    assert!(
        error(&first).contains(&format!("{count} of {count} programs, 0 with an error")),
        "{}",
        error(&first)
    );
    let text = read_to_string(bench.path("o")).expect("lines");
    assert_eq!((text.matches('\n').count(), by_path(&text).len()), (count, count));
    let again = run();
    assert!(error(&again).contains("0 of 0 programs"), "{}", error(&again));
    assert!(read_to_string(bench.path("o")).expect("lines") == text, "nothing was left to do");
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
    symlink(bench.path("in"), bench.path("in/loop")).expect("a link");
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
        (&["--ndjson"], "no programs"),
        (&["-", "--ndjson"], "no name"),
        (&["in", "--ndjson", "--json"], "single program"),
        (&["in", "--ndjson", "--out", "other"], "line 1 is not a prediction"),
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
