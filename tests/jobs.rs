//! `truefeed job`: the price of a part that several programs make, by the command alone.

use std::fs::{read_to_string, write};
use std::process::Output;

use serde_json::{Value, json};

use crate::archive::{Bench, error};

const FACE: &str = "%\nO0001(FACE)\nT1 M6\nG0 X0 Y0 Z5\nG1 Z0 F500\nX100 F2000\nG0 Z50\nM30\n%\n";
const DRILL: &str = "T2 M6\nG0 X0 Y0 Z5\nG1 Z-10 F200\nG0 Z5\nX50\nG1 Z-10\nG0 Z5\nM30\n";

/// A folder with a job below it: the job finds its files from its own folder.
fn bench(name: &str) -> Bench {
    let bench = Bench::new(&format!("jobs-{name}"));
    let machine = read_to_string(bench.path("m.toml")).expect("the machine");
    write(bench.path("in/mill.toml"), machine + "[rates]\nhourly = 90\n").expect("a writable folder");
    for (file, text) in [("in/op10.nc", FACE), ("in/op20.nc", DRILL)] {
        write(bench.path(file), text).expect("a writable folder");
    }
    put(&bench, "in/job.json", &job());
    bench
}

fn job() -> Value {
    json!({
        "truefeed_job": 1, "name": "Plate", "machine": "mill.toml", "tolerance_mm": 0.01,
        "terms": {"quantity": 25, "set_up_min": 15, "material": 3.5, "breaks": [1, 100]},
        "operations": [{"program": "op10.nc"}, {"program": "op20.nc", "set_up_min": 5, "loading_s": 30}],
        "offer": {"customer": "A customer", "number": "Q-7"},
    })
}

fn put(bench: &Bench, name: &str, job: &Value) {
    write(bench.path(name), job.to_string()).expect("a writable folder");
}

fn run(bench: &Bench, arguments: &[&str]) -> Output {
    bench.truefeed(&[&["job"], arguments].concat()).output().expect("the command starts")
}

fn report(bench: &Bench, arguments: &[&str]) -> Value {
    let output = run(bench, &[arguments, &["--json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// The cycle time that `predict` says of a program.
fn predicted(bench: &Bench, program: &str) -> f64 {
    let arguments = ["predict", program, "--machine", "in/mill.toml", "--tolerance", "0.01", "--json"];
    let output = bench.truefeed(&arguments).output().expect("the command starts");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    json["runs"][0]["cycle_time_s"].as_f64().expect("a time")
}

/// Files of a job may have any ending, also those of its documents.
#[test]
fn no_document_of_a_job_replaces_what_the_job_reads() {
    let bench = bench("inputs");
    let mut job = job();
    job["operations"][0]["program"] = json!("op10.html");
    std::fs::rename(bench.path("in/op10.nc"), bench.path("in/op10.html")).expect("our own file");
    put(&bench, "in/job.html", &job);
    std::os::unix::fs::symlink("op10.html", bench.path("in/link.html")).expect("a link");
    let inputs = ["in/job.html", "in/mill.toml", "in/op10.html", "in/op20.nc"];
    let content = || inputs.map(|name| read_to_string(bench.path(name)).expect("it is there"));
    let before = content();
    for (option, out) in [
        ("--out", "in/job.html"),
        ("--out", "in/op10.html"),
        ("--out", "in/../in/link.html"),
        ("--offer", "in/job.html"),
        ("--offer", "in/op10.html"),
        ("--offer", "in/link.html"),
    ] {
        let output = run(&bench, &["in/job.html", option, out]);
        assert_eq!(output.status.code(), Some(2), "{option} {out}");
        assert!(error(&output).contains("would replace the input"), "{option} {out}: {}", error(&output));
        assert!(content() == before, "{option} {out}");
    }
    let output = run(&bench, &["in/job.html", "--out", "same.html", "--offer", "./same.html"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(error(&output).contains("two outputs"), "{}", error(&output));
    let output = run(&bench, &["in/job.html", "--out", "costing.csv", "--offer", "offer.html"]);
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    assert!(content() == before);
}

#[test]
fn a_job_takes_what_its_programs_take_and_costs_the_sum() {
    let bench = bench("sum");
    let report = report(&bench, &["in/job.json"]);
    let times: Vec<f64> =
        ["in/op10.nc", "in/op20.nc"].iter().map(|program| predicted(&bench, program)).collect();
    let cycles = report["operations"].as_array().expect("a list").iter();
    let cycles: Vec<f64> = cycles.map(|row| row["cycle_time_s"].as_f64().expect("a time")).collect();
    assert!(
        cycles.iter().zip(&times).all(|(own, predicted)| (own - predicted).abs() < 1e-9),
        "{cycles:?} {times:?}"
    );
    assert!((report["cycle_time_s"].as_f64().expect("a time") - times.iter().sum::<f64>()).abs() < 1e-9);
    assert_eq!(report["set_up_s"], 1200.0);
    let names = [&report["operations"][0]["name"], &report["operations"][1]["name"]];
    assert_eq!(names, ["FACE", "op20"]);
    let cents = |value: &Value| (100.0 * value.as_f64().expect("an amount")).round() as i64;
    let addends = report["addends"].as_array().expect("a list").iter();
    let sum: i64 = addends.map(|addend| cents(&addend["of_batch"])).sum();
    assert_eq!(sum, cents(&report["batch"]["total"]));
    let keys: Vec<_> =
        report["missing"].as_array().expect("a list").iter().map(|row| row["key"].clone()).collect();
    assert_eq!(keys, ["loading_s", "operator_hourly", "other", "fixed", "margin_percent"]);

    let text = run(&bench, &["in/job.json"]);
    let text = String::from_utf8(text.stdout).expect("UTF-8");
    for said in [
        "Plate: 25 parts",
        "FACE",
        "op20",
        "cycle time of a part 0:00:",
        "Not in the price yet: Load and unload of FACE,",
    ] {
        assert!(text.contains(said), "{said}: {text}");
    }
}

#[test]
fn a_job_is_the_same_from_any_folder_and_with_its_programs_in_it() {
    let bench = bench("folders");
    let outside = report(&bench, &["in/job.json"]);
    let inside = bench
        .truefeed(&["job", "job.json", "--json"])
        .current_dir(bench.path("in"))
        .output()
        .expect("it starts");
    assert_eq!(outside, serde_json::from_slice::<Value>(&inside.stdout).expect("JSON"));
    let mut whole = job();
    whole["machine"] = Value::from(read_to_string(bench.path("in/mill.toml")).expect("the machine"));
    for (index, text) in [FACE, DRILL].into_iter().enumerate() {
        whole["operations"][index]["text"] = Value::from(text);
    }
    put(&bench, "whole.json", &whole);
    assert_eq!(report(&bench, &["whole.json"]), outside);
}

#[test]
fn its_documents_are_written_and_never_over_an_input() {
    let bench = bench("documents");
    let output = run(&bench, &["in/job.json", "--out", "costing.html", "--offer", "offer.html"]);
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    let [costing, offer] =
        ["costing.html", "offer.html"].map(|name| read_to_string(bench.path(name)).expect("it is there"));
    assert!(costing.contains("FACE") && costing.contains("Set-up, machine") && costing.contains("op20.nc"));
    assert!(
        offer.contains("A customer")
            && offer.contains("Q-7")
            && !offer.contains("FACE")
            && !offer.contains("Set-up")
    );
    let output = run(&bench, &["in/job.json", "--out", "costing.csv"]);
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    assert!(
        read_to_string(bench.path("costing.csv"))
            .expect("it is there")
            .starts_with("sequence,operation,program,")
    );

    std::fs::hard_link(bench.path("in/op10.nc"), bench.path("op10.html")).expect("a second name");
    std::fs::hard_link(bench.path("in/mill.toml"), bench.path("mill.csv")).expect("a second name");
    std::fs::hard_link(bench.path("in/job.json"), bench.path("job.html")).expect("a second name");
    for (option, out) in [("--out", "op10.html"), ("--out", "mill.csv"), ("--offer", "job.html")] {
        let output = run(&bench, &["in/job.json", option, out]);
        assert_eq!(output.status.code(), Some(2), "{out}");
        assert!(error(&output).contains("would replace the input"), "{}", error(&output));
    }
    assert_eq!(read_to_string(bench.path("in/op10.nc")).expect("it is there"), FACE);
    let same = run(&bench, &["in/job.json", "--out", "one.html", "--offer", "one.html"]);
    assert!(error(&same).contains("two outputs"), "{}", error(&same));
}

#[test]
fn two_jobs_are_compared_by_operation_and_together() {
    let bench = bench("compare");
    let mut slower = job();
    slower["operations"][1] = json!({"program": "new.nc", "name": "op20"});
    put(&bench, "in/slower.json", &slower);
    write(bench.path("in/new.nc"), DRILL.replace("F200", "F100")).expect("a writable folder");
    let both = report(&bench, &["in/job.json", "--compare", "in/slower.json"]);
    let [first, second] = ["in/job.json", "in/slower.json"].map(|job| report(&bench, &[job]));
    let time = |report: &Value| report["cycle_time_s"].as_f64().expect("a time");
    assert_eq!(both["cycle_time_s"]["difference"].as_f64(), Some(time(&second) - time(&first)));
    assert_eq!(both["operations"][0]["cycle_time_difference_s"], 0.0);
    assert!(0.0 < both["operations"][1]["cycle_time_difference_s"].as_f64().expect("a time"));
    let text = String::from_utf8(run(&bench, &["in/job.json", "--compare", "in/slower.json"]).stdout)
        .expect("UTF-8");
    assert!(text.starts_with("Plate → Plate\noperation") && text.contains("\nprice of a part: "), "{text}");
}

#[test]
fn what_cannot_be_done_is_said_in_one_line() {
    let bench = bench("refusals");
    let with = |name: &str, key: &str, value: Value| {
        let mut job = job();
        job[key] = value;
        put(&bench, name, &job);
    };
    with("in/unknown.json", "quantity", json!(25));
    with("in/nothing.json", "operations", json!([]));
    with("in/missing.json", "operations", json!([{"program": "op99.nc"}]));
    with("in/machine.json", "machine", json!("lathe.toml"));
    with("in/lathe.json", "operations", json!([{"program": "turned.nc"}]));
    write(bench.path("in/turned.nc"), "G96 S200 M3\nG50 S3000\nG0 X50 Z2\nG71 U2 R1\nG71 P10 Q20 U0.5 W0.1 F0.2\nN10 G0 X20\nN20 G1 X50\nM30\n")
        .expect("a writable folder");
    for (arguments, said) in [
        (&["in/unknown.json"][..], "in/unknown.json: quantity: unknown field; the nearest known one is"),
        (&["in/nothing.json"], "operations: expected a list of 1 to 200 operations"),
        (&["in/missing.json"], "in/op99.nc: "),
        (&["in/machine.json"], "in/lathe.toml: "),
        (&["in/lathe.json"], "in/turned.nc: line "),
        (&["in/op10.nc"], "in/op10.nc: line 1, column 1: this is no JSON"),
        (&["nowhere.json"], "nowhere.json: "),
        (&[], "which job?"),
        (&["in/job.json", "in/job.json"], "JOB.json is given twice"),
        (&["in/job.json", "--out", "quote.pdf"], "quote.pdf: name a file that ends in .csv or .html"),
        (&["in/job.json", "--offer", "offer.csv"], "offer.csv: name a file that ends in .html"),
        (&["in/job.json", "--compare", "in/job.json", "--out", "a.csv"], "--out and --offer are for one job"),
        (&["in/job.json", "--compare", "in/unknown.json"], "in/unknown.json: quantity"),
    ] {
        let output = run(&bench, arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(error(&output).contains(said), "{arguments:?}: {}", error(&output));
        assert_eq!(error(&output).lines().count(), 1, "{}", error(&output));
    }
}
