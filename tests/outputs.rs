//! What commands write: never over an input, whole or not at all, through links, and into pipes as into files.

use std::fs::{File, metadata, read_link, read_to_string, set_permissions, write};
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};
use std::process::{Command, Stdio};

use crate::archive::{Bench, error, limited};

const PROGRAM: &str = "G1 X10 F600\nX20\nM30\n";

/// A folder with a program; what else a command reads is never read where its output is refused.
fn bench(name: &str) -> Bench {
    let bench = Bench::new(&format!("outputs-{name}"));
    for (file, text) in [("a.nc", PROGRAM), ("log.csv", "t_s,x_mm\n0,0\n1,10\n"), ("job.toml", "# a job\n")] {
        write(bench.path(file), text).expect("a writable folder");
    }
    bench
}

#[test]
fn no_output_replaces_an_input() {
    let bench = bench("inputs");
    symlink("a.nc", bench.path("link.nc")).expect("a link");
    std::fs::hard_link(bench.path("a.nc"), bench.path("twin.nc")).expect("a second name");
    write(bench.path("in/empty.nc"), "").expect("a writable folder");
    let inputs = ["a.nc", "m.toml", "job.toml", "log.csv", "in/empty.nc"];
    let content = || inputs.map(|name| read_to_string(bench.path(name)).expect("it is there"));
    let before = content();
    let cutting = ["predict", "a.nc", "--machine", "m.toml", "--cutting", "job.toml"];
    let calibrate = ["calibrate", "--machine", "m.toml", "--run", "a.nc", "log.csv", "--out"];
    let diagnose = ["diagnose", "a.nc", "log.csv", "--machine", "m.toml", "--out"];
    let archive = ["predict", "in", "--machine", "m.toml", "--ndjson", "--out"];
    for (command, outputs) in [
        (&[&cutting[..], &["--profile"]].concat()[..], &["a.nc", "m.toml", "job.toml"][..]),
        (&[&cutting[..], &["--profile"]].concat(), &["./in/../a.nc", "link.nc", "twin.nc"]),
        (&[&cutting[..], &["--forces"]].concat(), &["a.nc", "m.toml", "job.toml"]),
        (&calibrate, &["a.nc", "m.toml", "log.csv"]),
        (&diagnose, &["a.nc", "m.toml", "log.csv"]),
        (&["probe", "--machine", "m.toml", "--out"], &["m.toml"]),
        (&archive, &["m.toml", "in/empty.nc"]),
    ] {
        for out in outputs {
            let output = bench.truefeed(command).arg(out).output().expect("the command starts");
            assert_eq!(output.status.code(), Some(2), "{command:?} {out}");
            assert!(
                error(&output).contains("would replace the input"),
                "{command:?} {out}: {}",
                error(&output)
            );
            assert_eq!(content(), before, "{command:?} {out}");
        }
    }
    let program = File::open(bench.path("a.nc")).expect("it is there");
    let piped = bench.predict(&["-", "--profile", "a.nc"]).stdin(program).output().expect("it starts");
    assert_eq!(piped.status.code(), Some(2), "{}", error(&piped));
    assert_eq!(content(), before);
}

#[test]
fn two_outputs_go_to_two_files() {
    let bench = bench("two");
    for other in ["out.csv", "./out.csv"] {
        let output =
            bench.done(&["a.nc", "--cutting", "job.toml", "--profile", "out.csv", "--forces", other]);
        assert_eq!(output.status.code(), Some(2));
        assert!(error(&output).contains("two outputs"), "{}", error(&output));
    }
}

#[test]
fn a_file_is_replaced_behind_its_links_and_keeps_its_mode() {
    let bench = bench("links");
    let names = || {
        let mut names: Vec<_> = std::fs::read_dir(&bench.folder).expect("a folder").collect::<Vec<_>>();
        names.sort_by_key(|entry| entry.as_ref().expect("an entry").file_name());
        names.into_iter().map(|entry| entry.expect("an entry").file_name()).collect::<Vec<_>>()
    };
    write(bench.path("target.csv"), "old").expect("a writable folder");
    set_permissions(bench.path("target.csv"), PermissionsExt::from_mode(0o640)).expect("our own file");
    write(bench.path("link.csv.part"), "the user's").expect("a writable folder");
    symlink("target.csv", bench.path("link.csv")).expect("a link");
    symlink("link.csv", bench.path("second.csv")).expect("a link");
    symlink("in/new.csv", bench.path("dangling.csv")).expect("a link");
    let before = names();
    for name in ["second.csv", "dangling.csv"] {
        let output = bench.done(&["a.nc", "--profile", name]);
        assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    }
    assert_eq!(names(), before, "nothing stays beside them");
    assert_eq!(read_link(bench.path("link.csv")).expect("a link still").to_str(), Some("target.csv"));
    let profile = read_to_string(bench.path("target.csv")).expect("the profile");
    assert!(profile.starts_with("time_s,"), "{profile}");
    assert_eq!(read_to_string(bench.path("in/new.csv")).expect("the profile"), profile);
    assert_eq!(metadata(bench.path("target.csv")).expect("a file").mode() & 0o777, 0o640);
    let usual = metadata(bench.path("a.nc")).expect("a file").mode();
    assert_eq!(metadata(bench.path("in/new.csv")).expect("a file").mode(), usual, "as any new file");
    assert_eq!(read_to_string(bench.path("link.csv.part")).expect("it is there"), "the user's");
}

#[test]
fn a_pipe_is_written_through() {
    let bench = bench("pipes");
    assert!(Command::new("mkfifo").arg(bench.path("pipe")).status().expect("mkfifo starts").success());
    let mut run =
        bench.predict(&["a.nc", "--profile", "pipe"]).stdout(Stdio::null()).spawn().expect("it starts");
    let profile = read_to_string(bench.path("pipe")).expect("the run opens it");
    assert_eq!(run.wait().expect("it ends").code(), Some(0));
    assert!(profile.starts_with("time_s,"), "{profile}");
    assert!(metadata(bench.path("pipe")).expect("it is there").file_type().is_fifo());

    let piped = bench.done(&["a.nc", "--profile", "/dev/stdout"]);
    let text = String::from_utf8(piped.stdout).expect("UTF-8");
    assert!(text.starts_with(&profile) && text.contains("cycle time"), "{text}");
    let file = File::create(bench.path("both")).expect("a writable folder");
    bench.predict(&["a.nc", "--profile", "/dev/stdout"]).stdout(file).status().expect("it starts");
    assert_eq!(read_to_string(bench.path("both")).expect("it is there"), text, "a file as a pipe");
    let lines = bench.done(&["a.nc", "--ndjson", "--out", "/dev/stdout"]);
    assert!(lines.stdout.starts_with(b"{\"path\":\"a.nc\""), "{}", error(&lines));
}

#[test]
fn a_write_that_fails_leaves_the_old_file_and_no_other() {
    let bench = bench("full");
    write(bench.path("out.csv"), "old").expect("a writable folder");
    let files = || std::fs::read_dir(&bench.folder).expect("a folder").count();
    let before = files();
    let output = limited(&bench.predict(&["a.nc", "--profile", "out.csv"]), 1).output().expect("it starts");
    assert_eq!(output.status.code(), Some(2), "{}", error(&output));
    assert_eq!(error(&output).lines().count(), 1, "{}", error(&output));
    assert_eq!(read_to_string(bench.path("out.csv")).expect("it is there"), "old");
    assert_eq!(files(), before);
}

#[test]
fn a_place_that_takes_no_file_is_refused_before_the_work() {
    let bench = bench("places");
    for (out, said) in [("in", "a folder"), ("nowhere/out.csv", "nowhere"), ("a.nc/out.csv", "a.nc/out.csv")]
    {
        // A program that is not there would be refused with its own name.
        let output = bench.done(&["missing.nc", "--profile", out]);
        assert_eq!(output.status.code(), Some(2));
        assert!(error(&output).contains(said), "{}", error(&output));
    }
}

#[test]
fn an_input_without_an_end_is_refused() {
    let bench = bench("endless");
    let long = File::create(bench.path("in/long.nc")).expect("a writable folder");
    long.set_len(1 << 31).expect("a file that is all hole");
    write(bench.path("in/short.nc"), PROGRAM).expect("a writable folder");
    let run = |arguments: &[&str]| bench.truefeed(arguments).output().expect("the command starts");
    let zero = "/dev/zero: longer than 1 MiB";
    for (output, said) in [
        (run(&["predict", "a.nc", "--machine", "/dev/zero"]), zero),
        (run(&["predict", "a.nc", "--machine", "m.toml", "--cutting", "/dev/zero"]), zero),
        (run(&["predict", "in/long.nc", "--machine", "m.toml"]), "in/long.nc: longer than 1024 MiB"),
        (run(&["diagnose", "a.nc", "in/long.nc", "--machine", "m.toml"]), "in/long.nc: longer than 1024 MiB"),
    ] {
        assert_eq!(output.status.code(), Some(2));
        assert!(error(&output).contains(said), "{}", error(&output));
    }
    let archive = bench.done(&["in/long.nc", "in/short.nc", "--ndjson"]);
    assert_eq!(archive.status.code(), Some(1), "one line says an error, and the other program is predicted");
    assert_eq!(archive.stdout.iter().filter(|byte| **byte == b'\n').count(), 2);
}
