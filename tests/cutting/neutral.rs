//! Switched off, cutting changes nothing; switched on, it only adds.

use serde_json::Value;
use truefeed::cutting::{Mill, Setup, engagement, material, programmed_and_predicted};
use truefeed::machine::Machine;
use truefeed::project::Prediction;
use truefeed::quote::{programmed_time, quote};
use truefeed::simulation::feed::Tolerances;
use truefeed::simulation::profile::{Profile, Resolution};
use truefeed::simulation::simulate;

use crate::cutting::{mill, setup, toolpath};

const PROGRAM: &str = "G21 G90 T1 M6\nM3 S8000\n(SLOT)\nG0 X-10 Y5 Z5\nZ-3\nG1 X30 F1200\nG0 Z5\n(BACK)\nX20 Y3\nZ-4\nG1 X0 F600\nG0 Z5\nM30";

/// The prediction as JSON, without cutting or with the outcome of a set-up.
fn predicted(setup: Option<&Setup>) -> Value {
    predicted_of(PROGRAM, setup)
}

/// The same of a program.
fn predicted_of(program: &str, setup: Option<&Setup>) -> Value {
    let (machine, toolpath) = (Machine::default(), toolpath(program));
    let (plan, errors) = simulate::within(&toolpath, &machine, Tolerances::Programmed, &mut |_| {});
    let quotes = [quote(&toolpath, &machine, &plan, Tolerances::Programmed, &errors)];
    let prediction = Prediction::new("part.nc", &toolpath, programmed_time(&toolpath, &machine), &quotes);
    let prediction = match setup {
        None => prediction,
        Some(setup) => {
            let cut = engagement(&toolpath, setup);
            let curve = Profile::new(&toolpath, &plan).feed_curve(Resolution::CHART);
            let loads =
                cut.iter().map(|cut| programmed_and_predicted(cut, &toolpath, setup, &curve, &mut |_| {}));
            let loads: Vec<_> = loads.collect();
            prediction.with_cutting(setup, &cut, &loads)
        }
    };
    serde_json::from_str(&prediction.to_json()).expect("it is JSON")
}

fn base() -> Setup {
    setup([0.0, 0.0, -5.0], [20.0, 10.0, 0.0], mill(6.0), 0.2)
}

/// Takes everything about cutting out again.
fn bare(mut prediction: Value) -> Value {
    let run = prediction["runs"][0].as_object_mut().expect("a run");
    run.remove("cutting");
    for operation in run["operations"].as_array_mut().expect("operations") {
        operation.as_object_mut().expect("an operation").remove("cutting");
    }
    let remarks = prediction["diagnostics"].as_array_mut().expect("a list");
    let is_other = |remark: &Value| !remark["message"].as_str().expect("text").contains("material");
    remarks.retain(|remark| is_other(remark) && !remark["message"].to_string().contains("cutting"));
    prediction
}

#[test]
fn switched_off_there_is_no_trace_and_switched_on_it_only_adds() {
    let off = predicted(None);
    assert_eq!(off["runs"][0].get("cutting"), None);
    let on = predicted(Some(&base()));
    assert_ne!(on, off);
    assert_eq!(bare(on), off);
}

#[test]
fn what_is_missing_is_a_diagnostic_and_the_quote_goes_on() {
    let on = predicted(Some(&Setup { stock: None, ..base() }));
    let last = on["diagnostics"].as_array().expect("a list").last().expect("one").clone();
    assert_eq!(last["message"], "cutting forces are not computed: the cutting job has no stock");
    assert_eq!(last["severity"], "warning");
    assert_eq!(on["runs"][0].get("cutting"), None);
    assert_eq!(bare(on), predicted(None));
}

#[test]
fn chips_that_no_mill_cuts_and_coefficients_that_nobody_checked_are_remarked() {
    let said = |setup: &Setup| predicted(Some(setup))["diagnostics"].to_string();
    assert!(!said(&base()).contains("check spindle speed") && !said(&base()).contains("are not checked"));
    let one = Setup { tool: Some(Mill { teeth: Some(1), ..mill(6.0) }), ..base() };
    assert!(!said(&one).contains("check spindle speed"));
    let slow = predicted_of(&PROGRAM.replace("S8000", "S800"), Some(&one))["diagnostics"].to_string();
    assert!(slow.contains("chips would be 1.50 mm thick"), "{slow}");
    let titanium = material("ti6al4v").expect("known");
    let doubted = Setup { coefficients: Some(titanium.coefficients), material: Some(titanium), ..base() };
    assert!(said(&doubted).contains("the coefficients of titanium Ti-6Al-4V are not checked"));
}

#[test]
fn operations_have_their_volume_and_their_peaks() {
    let on = predicted(Some(&base()));
    let run = &on["runs"][0];
    let operations = run["operations"].as_array().expect("operations");
    assert_eq!(operations.len(), 2);
    let number = |value: &Value| value.as_f64().expect("a number");
    let volumes: Vec<f64> =
        operations.iter().map(|operation| number(&operation["cutting"]["removed_mm3"])).collect();
    assert!((volumes[0] / (20.0 * 6.0 * 3.0) - 1.0).abs() < 0.05, "{volumes:?}");
    assert!(0.0 < volumes[1] && volumes[1] < volumes[0]);
    let peak = |operation: &Value| number(&operation["cutting"]["peak_force_n"]["value"]);
    let largest = operations.iter().map(peak).fold(0.0, f64::max);
    assert_eq!(number(&run["cutting"]["predicted"]["force_n"]["value"]), largest);
    // The second one goes down into the stock in rapid.
    assert_eq!(run["cutting"]["rapids_through_stock"][0]["line"], 10);
    assert_eq!(operations[0]["cutting"]["peak_force_n"]["line"], 6);
    // The programmed feedrate is never less.
    let of = |feed: &str| number(&run["cutting"][feed]["power_w"]["value"]);
    assert!(of("predicted") <= of("programmed"));
}
