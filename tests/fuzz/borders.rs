//! What holds at the other borders: recordings, requests of pages that embed, settings of a saved link, forms, offers,
//! cutting jobs, requests for probes, and plans of whatever was read. The fuzz targets and the tests share it.
#![allow(dead_code)]

use serde_json::Value;
use truefeed::identification::probe::probe_between;
use truefeed::identification::recording::{Recording, is_recording, read};
use truefeed::machine::{CornerMode, Machine, presets};
use truefeed::project::{
    OfferReport, QuoteRequest, TextFault, cutting_from_toml, machine_from_form, machine_from_toml,
    settings_from_text, settings_text, terms_from_form, toml_from_machine,
};
use truefeed::quote::{programmed_time, quote};
use truefeed::simulation::feed::Tolerances;
use truefeed::simulation::gcode::read as read_program;
use truefeed::simulation::interpreter::{trace, trace_within};
use truefeed::simulation::profile::{Profile, Resolution};
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Toolpath;

/// Plans are checked of programs of no more moves than this, so that an execution stays short.
const MOST_PLANNED: usize = 300;

/// Blocks that loops may run here: a loop that runs further has more moves than that, or none.
const MOST_REPEATED: usize = 2_000;

/// Bytes → log; stamps in order, everything finite.
pub fn recording(bytes: &[u8]) {
    let _ = is_recording(bytes);
    match read(bytes) {
        Ok(log) => {
            assert!(!log.recordings.is_empty(), "a log without a recording");
            log.recordings.iter().for_each(check_recording);
        }
        Err(error) => one_line(&error.to_string()),
    }
}

fn check_recording(recording: &Recording) {
    assert!(recording.duration.is_finite() && 0.0 <= recording.duration, "{} s", recording.duration);
    assert!(!recording.runs.is_empty(), "a recording without a run");
    let axes = recording.commanded.iter().chain(&recording.actual);
    let rates =
        [&recording.feed, &recording.commanded_feed, &recording.feed_override, &recording.spindle_speed];
    for channel in axes.chain(rates).flatten() {
        assert_eq!(channel.time.len(), channel.values.len());
        assert!(channel.time.is_sorted_by(|one, next| one < next), "stamps out of order");
        assert!(channel.time.iter().chain(&channel.values).all(|value| value.is_finite()), "not finite");
    }
    for run in &recording.runs {
        assert!(run.time.start <= run.time.end, "a run ends before it begins: {:?}", run.time);
    }
}

/// A message for people: something, and nothing that breaks a line of output.
fn one_line(text: &str) {
    assert!(!text.is_empty() && !text.contains(char::is_control), "message: {text:?}");
}

fn said(faults: &[TextFault]) {
    assert!(!faults.is_empty(), "refused without a fault");
    assert!(faults.iter().all(|fault| !fault.message.is_empty()));
}

/// Text → request for a quote: allowed in every value, or refused as JSON with a kind.
pub fn request(bytes: &[u8]) {
    match QuoteRequest::from_json(&String::from_utf8_lossy(bytes)) {
        Ok(request) => {
            assert!(!request.tolerances.is_empty());
            allowed(&request.machine);
        }
        Err(error) => {
            let refusal: Value = serde_json::from_str(&error.to_json()).expect("a refusal is JSON");
            assert!(refusal["kind"].as_str().is_some_and(|kind| !kind.is_empty()), "{refusal}");
            assert!(refusal["message"].as_str().is_some_and(|message| !message.is_empty()), "{refusal}");
        }
    }
}

/// A machine whose own file is read again.
fn allowed(machine: &Machine) {
    let written = toml_from_machine(machine);
    if let Err(fault) = machine_from_toml(&written) {
        panic!("{fault}\n{written}");
    }
}

/// Text → settings, which their own text gives again.
pub fn settings(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    match settings_from_text(&text) {
        Ok(full) => {
            let short = settings_text(&full).expect("what was read can be written");
            assert_eq!(
                settings_from_text(&short).as_ref(),
                Ok(&full),
                "other settings come back from {short}"
            );
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Text → machine, terms and offer by the forms of the page.
pub fn forms(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    match machine_from_form(&text) {
        Ok(machine) => allowed(&machine),
        Err(faults) => said(&faults),
    }
    if let Err(faults) = terms_from_form(&text) {
        said(&faults);
    }
    match OfferReport::from_json(&text) {
        Ok(offer) => {
            let json = offer.to_json();
            serde_json::from_str::<Value>(&json).expect("an offer is JSON");
            assert!(!offer.to_csv().is_empty() && offer.to_html(&[]).contains("</html>"));
        }
        Err(faults) => said(&faults),
    }
}

/// Text → cutting job, or a fault within the text.
pub fn cutting_job(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Err(fault) = cutting_from_toml(&text, &Machine::default()) {
        assert!(!fault.message.is_empty());
        if let Some((line, column)) = fault.place {
            let lines: Vec<&str> = text.split('\n').collect();
            assert!((1..=lines.len()).contains(&line), "line {line}: {fault}");
            assert!((1..=lines[line - 1].chars().count() + 2).contains(&column), "column {column}: {fault}");
        }
    }
}

/// One request of so many is carried out: a probe takes a second, its refusal a microsecond.
const PROBED: usize = 61;

/// Two words → probe on a machine of the library, or why there is none.
pub fn probe_request(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let mut words = text.splitn(3, ' ');
    let (one, other) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
    let machine = &presets()[bytes.len() % presets().len()].machine;
    for word in [one, other] {
        let refusal = probe_between(machine, [word, word]).expect_err("nothing is told from itself");
        assert!(!refusal.to_string().is_empty());
    }
    if !bytes.len().is_multiple_of(PROBED) {
        return;
    }
    match probe_between(machine, [one, other]) {
        Ok(probe) => {
            assert!(probe.seconds.is_finite() && 0.0 < probe.seconds, "{} s", probe.seconds);
            let toolpath = trace(&read_program(probe.program.as_bytes()), machine);
            assert!(!toolpath.segments.is_empty(), "a probe that does not move");
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Program → plan → profile → quote, on one of the machines of the library: finite, in order, adding up.
pub fn planned(bytes: &[u8]) {
    let mut machine = presets()[bytes.len() % presets().len()].machine.clone();
    if bytes.len().is_multiple_of(3) {
        machine.axes[0].acceleration = 800.0;
        machine.path.acceleration = 1500.0;
    }
    if bytes.len().is_multiple_of(5) {
        machine.interpolator.corner_mode = CornerMode::Guaranteed;
    }
    let toolpath = trace_within(&read_program(bytes), &machine, MOST_REPEATED);
    if toolpath.segments.len() <= MOST_PLANNED {
        check_plan(&toolpath, &machine);
    }
}

/// What holds of every plan.
pub fn check_plan(toolpath: &Toolpath, machine: &Machine) {
    let (plan, errors) = simulate::within(toolpath, machine, Tolerances::Programmed, &mut |_| {});
    let quote = quote(toolpath, machine, &plan, Tolerances::Programmed, &errors);
    assert!(quote.cycle_time.is_finite() && 0.0 <= quote.cycle_time, "cycle time {}", quote.cycle_time);
    assert!(quote.max_contour_error.is_finite(), "contour error {}", quote.max_contour_error);
    let total = quote.breakdown.total();
    assert!(
        (total - quote.cycle_time).abs() <= 1e-9 * (1.0 + quote.cycle_time),
        "{total} of {}",
        quote.cycle_time
    );
    let programmed = programmed_time(toolpath, machine);
    assert!(programmed.is_finite() && 0.0 <= programmed, "programmed time {programmed}");
    let profile = Profile::new(toolpath, &plan);
    let samples = profile.samples(Resolution::CHART);
    assert!(samples.time.is_sorted(), "time runs back");
    let mut columns =
        [&samples.time, &samples.distance, &samples.feedrate].into_iter().chain(&samples.position);
    assert!(columns.all(|column| column.iter().all(|value| value.is_finite())), "a sample is not finite");
    assert!(samples.feedrate.iter().all(|feedrate| -1e-6 <= *feedrate), "a feedrate below zero");
}
