//! `docs/job.schema.json` agrees with the reader on every field: its values, its bounds, and that there is no other.

use serde_json::{Value, json};

use crate::project::JobFile;
use crate::quote::TERMS;

const SCHEMA: &str = include_str!("../../../../docs/job.schema.json");

fn schema() -> Value {
    serde_json::from_str(SCHEMA).expect("the schema is JSON")
}

/// A job with every object of the format in it.
fn job() -> Value {
    json!({
        "truefeed_job": 1, "machine": crate::machine::presets()[0].machine.name, "fixture": {"parts": 2},
        "terms": {"margin_of": "cost"}, "offer": {}, "company": {},
        "operations": [{"program": "a.nc", "machine": "mill.toml", "fixture": {"parts": 2}}],
    })
}

/// The objects of the format: where the schema has them and where the job does.
const OBJECTS: [(&str, &str); 7] = [
    ("", ""),
    ("/$defs/operation", "/operations/0"),
    ("/$defs/fixture", "/fixture"),
    ("/$defs/fixture", "/operations/0/fixture"),
    ("/$defs/terms", "/terms"),
    ("/$defs/offer", "/offer"),
    ("/$defs/company", "/company"),
];

/// Returns `true` if the reader accepts the job with this value there.
fn is_read(place: &str, key: &str, value: &Value) -> bool {
    let mut job = job();
    job.pointer_mut(place).expect("it is there")[key] = value.clone();
    JobFile::from_json(&job.to_string()).is_ok()
}

/// A property without its reference.
fn resolved<'a>(schema: &'a Value, property: &'a Value) -> &'a Value {
    match property["$ref"].as_str() {
        Some(reference) => schema.pointer(reference.trim_start_matches('#')).expect("it is defined"),
        None => property,
    }
}

/// Values that the schema takes, and values that it refuses.
fn samples(property: &Value) -> (Vec<Value>, Vec<Value>) {
    let types = match &property["type"] {
        Value::Array(types) => types.clone(),
        other => vec![other.clone()],
    };
    let has = |name: &str| types.contains(&json!(name));
    if let Some(only) = property.get("const") {
        return (vec![only.clone()], vec![json!(2), json!("1")]);
    }
    if let Some(words) = property["enum"].as_array() {
        return (words.clone(), vec![json!("no such word"), json!(1)]);
    }
    let (mut right, mut wrong) = (Vec::new(), vec![json!(true)]);
    if has("null") {
        right.push(Value::Null);
    }
    if has("number") || has("integer") {
        let [min, max] =
            ["minimum", "maximum"].map(|end| property[end].as_f64().expect("numbers have bounds"));
        right.extend([json!(min), json!(max)]);
        wrong.extend([json!(min - 1e-7), json!(max * 1.001), json!("1")]);
    }
    if has("integer") {
        wrong.push(json!(1.5));
    }
    if let Some(most) = property["maxLength"].as_u64() {
        let start = if property.get("pattern").is_some() { "data:image/png;base64," } else { "" };
        let text = |length: u64| json!(format!("{start}{}", "A".repeat(length as usize - start.len())));
        right.push(text(most));
        wrong.extend([text(most + 1), json!(1)]);
    }
    if property["minLength"] == 1 {
        wrong.push(json!(""));
    }
    if property.get("pattern").is_some() {
        wrong.extend([json!("https://example.org/a.png"), json!("data:image/svg+xml;base64,AAAA")]);
    }
    (right, wrong)
}

#[test]
fn every_field_of_the_schema_is_read_within_its_bounds_and_not_beyond() {
    let schema = schema();
    let mut checked = 0;
    for (definition, place) in OBJECTS {
        let object = schema.pointer(definition).expect("it is defined");
        assert_eq!(object["additionalProperties"], json!(false), "{definition}");
        assert!(!is_read(place, "no_such_field", &Value::Null), "{definition}");
        for (key, property) in object["properties"].as_object().expect("properties") {
            let (right, wrong) = samples(resolved(&schema, property));
            for value in right {
                assert!(is_read(place, key, &value), "{place}/{key}: {value} is refused");
                checked += 1;
            }
            for value in wrong {
                assert!(!is_read(place, key, &value), "{place}/{key}: {value} is read");
            }
        }
        for key in object["required"].as_array().into_iter().flatten() {
            let mut without = job();
            let owner = without.pointer_mut(place).expect("it is there").as_object_mut().expect("an object");
            if owner.remove(key.as_str().expect("a name")).is_some() {
                assert!(JobFile::from_json(&without.to_string()).is_err(), "{place}/{key} can be left out");
            }
        }
    }
    assert!(100 < checked, "{checked} values were tried");
}

#[test]
fn the_schema_has_every_field_that_the_reader_names() {
    let schema = schema();
    for (definition, place) in OBJECTS {
        let properties =
            schema.pointer(definition).expect("it is defined")["properties"].as_object().expect("them");
        // What the reader holds for nearest to any name it knows.
        for letter in 'a'..='z' {
            for length in 1..24 {
                let mut job = job();
                job.pointer_mut(place).expect("it is there")[letter.to_string().repeat(length)] = Value::Null;
                let fault = JobFile::from_json(&job.to_string()).expect_err("unknown").to_string();
                let nearest = fault.rsplit(' ').next().expect("words").to_string();
                assert!(properties.contains_key(&nearest), "{place}: {nearest} of {fault}");
            }
        }
    }
    let terms = &schema["$defs"]["terms"]["properties"];
    for term in &TERMS {
        assert!(terms.get(term.key).is_some(), "{} is not in the schema", term.key);
    }
    assert_eq!(terms.as_object().map(|terms| terms.len()), Some(TERMS.len()));
}

#[test]
fn a_machine_is_what_the_schema_says() {
    let values = crate::project::machine_values(&crate::machine::presets()[0].machine);
    let values: Value = serde_json::from_str(&values).expect("JSON");
    let file = crate::project::toml_from_machine(&crate::machine::presets()[0].machine);
    for machine in [
        json!("mill.toml"),
        json!(file),
        values,
        json!({"preset": crate::machine::presets()[1].machine.name}),
    ] {
        assert!(is_read("", "machine", &machine), "{machine}");
    }
}
