//! Tests of the report of a job and its documents.

use serde_json::json;

use crate::project::JobComparison;
use serde_json::Value;

use crate::project::quote::job::report::*;
use crate::project::quote::offer::report::OfferReport;

/// A job of three operations on two machines, as the page requests it.
pub(in crate::project::quote::job) fn asked(terms: Value) -> Value {
    let mut dear = crate::project::machine::form::values(&crate::machine::presets()[0].machine);
    dear.insert("rates.hourly".to_string(), Value::from(90.0));
    let mut cheap = crate::project::machine::form::values(&crate::machine::presets()[1].machine);
    cheap.insert("rates.hourly".to_string(), Value::from(60.0));
    let part = |tool: Option<u32>, change: f64| {
        json!({"line": 1, "tool": tool, "time_s": 10, "breakdown":
            {"cutting_s": 10, "rapid_s": 0, "dwell_s": 0, "tool_change_s": change, "other_s": 0, "other": {}}})
    };
    let run = |cutting: f64| {
        json!({"title": "FROM THE PROGRAM", "programmed_time_s": 90.0, "tolerance_mm": 0.01, "cycle_time_s": cutting + 20.0, "price": 3.0,
            "breakdown": {"cutting_s": cutting, "rapid_s": 12.0, "dwell_s": 0.0, "tool_change_s": 8.0, "other_s": 0.0, "other": {}},
            "operations": [part(None, 0.0), part(Some(1), 4.0), part(Some(2), 4.0)],
            "trust": {"seconds_in_doubt": 1.5, "bounded": true, "reasons": [], "causes": []}, "in_doubt": "In doubt: 1.5 s (1 arc)",
            "remarks": {"errors": 0, "warnings": 2}})
    };
    json!({
        "job": {"truefeed_job": 1, "name": "Bracket <A>", "machine": dear, "terms": terms,
            "operations": [
                {"program": "in/op10.nc", "set_up_min": 30, "tolerance_mm": 0.01}, {"program": "op20.nc", "name": "=Drill", "machine": cheap},
                {"program": "op30.nc", "name": "Finish", "loading_s": 20}],
            "offer": {"customer": "Customer & Sons\nTown", "number": "Q-17", "date": "2026-11-23", "valid_until": "2026-12-23", "tax_percent": 19},
            "company": {"name": "Our <Shop>", "address": "Street 1"}},
        "planned": [run(100.0), run(50.0), run(7000.0)],
    })
}

fn report(terms: Value) -> JobReport {
    JobReport::from_json(&asked(terms).to_string()).expect("right")
}

fn terms() -> Value {
    json!({"quantity": 25, "loading_s": 45, "material": 4.37, "margin_percent": 12, "uncertainty_percent": 5, "breaks": [1, 100]})
}

fn cents(amount: f64) -> i64 {
    (100.0 * amount).round() as i64
}

#[test]
fn what_is_shown_adds_up() {
    let report = report(terms());
    let of_batch: i64 = report.addends.iter().map(|addend| cents(addend.row.of_batch)).sum();
    assert_eq!(of_batch, cents(report.batch.total));
    assert_eq!(cents(report.once) + 25 * cents(report.part), cents(report.batch.total));
    for (index, row) in report.operations.iter().enumerate() {
        let own = |once: bool| -> i64 {
            let own = report.addends.iter().filter(|addend| addend.operation == Some(index));
            own.filter(|addend| addend.row.once == once).map(|addend| cents(addend.row.amount)).sum()
        };
        assert_eq!((own(true), own(false)), (cents(row.set_up_cost), cents(row.part_cost)));
    }
    let times: f64 = report.operations.iter().map(|row| row.cycle_time_s).sum();
    assert_eq!((times, report.cycle_time_s), (7210.0, 7210.0));
    assert_eq!((report.set_up_s, report.loading_s, report.in_doubt_s), (1800.0, 110.0, 4.5));
    assert_eq!(report.batch_time_s, 1800.0 + 25.0 * (7210.0 + 110.0));
    assert_eq!(report.cycle_time_range_s.map(|ends| ends.map(f64::round)), Some([6850.0, 7571.0]));
    let names: Vec<&str> = report.operations.iter().map(|row| row.name.as_str()).collect();
    assert_eq!(names, ["FROM THE PROGRAM", "=Drill", "Finish"]);
    let tolerances: Vec<&str> = report.operations.iter().map(|row| row.tolerance.as_str()).collect();
    assert_eq!(tolerances, ["10 µm", "as programmed (10 µm)", "as programmed (10 µm)"]);
    let missing: Vec<_> = report.missing.iter().map(|row| (row.key, row.operation)).collect();
    let expected = [
        ("set_up_min", Some(1)),
        ("set_up_min", Some(2)),
        ("operator_hourly", None),
        ("other", None),
        ("fixed", None),
    ];
    assert_eq!(missing, expected);
}

#[test]
fn a_job_of_one_operation_has_the_amounts_of_todays_quote() {
    let mut asked = asked(terms());
    asked["job"]["terms"]["set_up_min"] = json!(17);
    asked["job"]["operations"] = json!([{"program": "op10.nc"}]);
    asked["planned"].as_array_mut().expect("a list").truncate(1);
    let job = JobReport::from_json(&asked.to_string()).expect("right");
    let mut run = asked["planned"][0].clone();
    run["tolerance"] = json!("10 µm");
    run["operations"] = json!([]);
    run["tools"] = json!([]);
    let plain = json!({"machine": asked["job"]["machine"], "terms": asked["job"]["terms"], "program": "op10.nc",
        "programmed_time_s": 90.0, "runs": [run], "chosen": 0});
    let plain = OfferReport::from_json(&plain.to_string()).expect("right");
    let rows: Vec<_> = job.addends.iter().map(|addend| addend.row.clone()).collect();
    assert_eq!(rows, plain.addends);
    assert_eq!(
        (job.once, job.part, &job.batch, &job.breaks),
        (plain.once, plain.part, &plain.batch, &plain.breaks)
    );
    assert_eq!((job.cycle_time_s, job.breakdown), (plain.cycle_time_s, plain.breakdown));
}

#[test]
fn the_customer_sees_prices_and_nothing_of_the_house() {
    let report = report(terms());
    let offer = report.to_offer();
    let (first, rest) = offer.split_once('\n').expect("it has lines");
    assert_eq!(first, "<!doctype html>");
    roxmltree::Document::parse(rest).expect("it is well-formed");
    for said in [
        "Customer &amp; Sons\nTown",
        "Our &lt;Shop&gt;",
        "Q-17",
        "2026-12-23",
        "Bracket &lt;A&gt;",
        "Tax, 19 %",
    ] {
        assert!(offer.contains(said), "{said}: {offer}");
    }
    // Styles have margins.
    let (_, body) = rest.split_once("<body>").expect("it has a body");
    let tax = (0.19 * report.batch.total * 100.0).round() / 100.0;
    assert!(offer.contains(&report.money(report.batch.total + tax)), "{offer}");
    assert!(offer.contains(&report.unit_price(report.batch.unit_price)));
    for secret in [
        "Drill", "op20.nc", "hour", "Margin", "margin", "Machine", "Set-up", "doubt", "DMG", "±", "µm",
        "Truefeed",
    ] {
        assert!(!body.contains(secret), "{secret}: {body}");
    }
}

#[test]
fn the_costing_says_every_amount_and_every_time() {
    let report = report(terms());
    let html = report
        .to_costing(&[("<svg xmlns=\"http://www.w3.org/2000/svg\"/>".to_string(), "a <chart>".to_string())]);
    roxmltree::Document::parse(html.split_once('\n').expect("it has lines").1).expect("it is well-formed");
    for addend in &report.addends {
        let amount = crate::project::grouped(addend.row.of_batch, 2);
        assert!(html.contains(&format!("<td>{amount}</td>")), "{}: {amount}", addend.row.item);
    }
    let label = report.missing[0].label;
    let missing = format!("Not in the price yet: {label} of =Drill, {label} of Finish, ");
    for said in ["2:00:10", "1:57:00", &missing, "4.5 s of a part are in doubt"] {
        assert!(html.contains(said), "{said}: {html}");
    }
}

#[test]
fn a_shared_result_has_times_and_pictures_and_no_money() {
    let report = report(terms());
    let html = report
        .to_result(&[("<svg xmlns=\"http://www.w3.org/2000/svg\"/>".to_string(), "the path".to_string())]);
    roxmltree::Document::parse(html.split_once('\n').expect("it has lines").1).expect("it is well-formed");
    for said in ["2:00:10 per part", "1:54:10 to 2:06:11", "=Drill", "the path", "op20.nc"] {
        assert!(html.contains(said), "{said}: {html}");
    }
    for secret in ["EUR", "Q-17", "Customer", "Set-up", "cost", "Cost", "price"] {
        assert!(!html.contains(secret), "{secret}: {html}");
    }
}

#[test]
fn a_table_has_every_operation_and_no_formula() {
    let csv = report(terms()).to_csv();
    assert!(csv.starts_with("sequence,operation,program,machine,"), "{csv}");
    assert!(csv.contains("\n2,'=Drill,op20.nc,"), "{csv}");
    assert!(csv.contains("\ncycle of a part,7210,120.167,2:00:10\n"), "{csv}");
    assert!(csv.contains(",Total,25 parts,,,"), "{csv}");
}

#[test]
fn two_jobs_differ_by_operation_and_together() {
    let first = report(terms());
    let mut other = asked(terms());
    other["job"]["operations"][0]["name"] = json!("Face");
    other["job"]["operations"].as_array_mut().expect("a list").swap(1, 2);
    other["job"]["operations"][1]["name"] = json!("Finish");
    other["job"]["operations"][2] = json!({"program": "new.nc", "name": "Deburr"});
    other["planned"][1]["breakdown"]["cutting_s"] = json!(6000.0);
    let second = JobReport::from_json(&other.to_string()).expect("right");
    let both = JobComparison::new(&first, &second);
    let rows: Vec<_> = both
        .operations
        .iter()
        .map(|row| (row.name.as_str(), row.cycle_time_s, row.cycle_time_difference_s))
        .collect();
    let expected = [
        ("FROM THE PROGRAM", [Some(120.0), Some(120.0)], 0.0),
        ("=Drill", [Some(70.0), None], -70.0),
        ("Finish", [Some(7020.0), Some(6020.0)], -1000.0),
        ("Deburr", [None, Some(7020.0)], 7020.0),
    ];
    assert_eq!(rows, expected);
    let sum: f64 = both.operations.iter().map(|row| row.cycle_time_difference_s).sum();
    assert_eq!(both.cycle_time_s.difference, sum);
    assert_eq!(both.total.difference, second.batch.total - first.batch.total);
    assert_eq!(both.remarks, Vec::<String>::new());
    let itself = JobComparison::new(&first, &first);
    assert!(itself.operations.iter().all(|row| row.cycle_time_difference_s == 0.0));
}
