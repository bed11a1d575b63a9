//! The text of a job → the job, and back. An invalid file is refused at its first fault.

use serde_json::{Map, Value};

use crate::machine::{Machine, checked_tolerance};
use crate::project::TextFault;
use crate::project::machine::form::{filled, values};
use crate::project::machine::written::{RAPID_KEY, REQUIRED_KEYS, TIME_CONSTANT_KEYS, tidy};
use crate::project::quote::job::fields::Fields;
use crate::project::quote::job::letter::Letter;
use crate::project::quote::terms::{terms_from_values, terms_values};
use crate::project::request::machine_of;
use crate::quote::{Fixture, Terms};
use crate::simulation::feed::Tolerances;
use crate::simulation::gcode::{ArcCenters, Dialect, Options};
use crate::units::Unit;

/// Version of the format.
const JOB_VERSION: u64 = 1;

/// Most operations of a job: each needs a simulation.
const MAX_OPERATIONS: usize = 200;

/// Largest number of characters of a name.
const MAX_NAME_CHARACTERS: usize = 200;
/// Largest number of characters of the path of a file.
const MAX_PATH_CHARACTERS: usize = 4000;

/// Bounds of the parts on a fixture.
const PARTS_PER_LOAD_BOUNDS: (f64, f64) = (1.0, 10_000.0);

const JOB_FIELDS: [&str; 11] = [
    "truefeed_job",
    "name",
    "machine",
    "tolerance_mm",
    "dialect",
    "arc_centres",
    "fixture",
    "terms",
    "operations",
    "offer",
    "company",
];

const OPERATION_FIELDS: [&str; 10] = [
    "program",
    "name",
    "text",
    "machine",
    "tolerance_mm",
    "dialect",
    "arc_centres",
    "fixture",
    "set_up_min",
    "loading_s",
];

/// The content of the file of a job; programs and machine files are read later.
#[derive(Clone, Debug, PartialEq)]
pub struct JobFile {
    /// Name of the part; may be empty.
    pub name: String,
    /// Operations in order; at least one.
    pub operations: Vec<JobOperationFile>,
    /// The terms of the quote.
    pub terms: Terms,
    /// Letter around the prices of an offer.
    pub(in crate::project) letter: Letter,
}

/// An operation of a job, including the settings that the job makes for all operations.
#[derive(Clone, Debug, PartialEq)]
pub struct JobOperationFile {
    /// File of the program, relative to the folder of the job, or the name of the program in `text`.
    pub program: String,
    /// Text of the program, if the job contains it.
    pub text: Option<String>,
    /// Name; if empty, the program's.
    pub name: String,
    /// Machine.
    pub machine: MachineSource,
    /// One contour tolerance, or those of the program.
    pub tolerances: Tolerances,
    /// Reading options of the program.
    pub options: Options,
    /// Set-up time, s.
    pub set_up: f64,
    /// Time to load and unload a part, s.
    pub loading: f64,
    /// Fixture for several parts at a time.
    pub fixture: Option<Fixture>,
}

/// The source of a machine.
#[derive(Clone, Debug, PartialEq)]
pub enum MachineSource {
    /// The job contains it.
    Inline(Box<Machine>),
    /// A file, relative to the folder of the job.
    File(String),
}

impl JobFile {
    /// Reads the text of a job.
    ///
    /// # Errors
    ///
    /// Returns the first fault, with its field, such as `operations[1].set_up_min`.
    pub fn from_json(text: &str) -> Result<JobFile, TextFault> {
        let value: Value = serde_json::from_str(text).map_err(|error| TextFault {
            place: Some((error.line(), error.column())),
            key: None,
            message: format!("this is no JSON ({error})"),
        })?;
        JobFile::from_value(&value)
    }

    /// Reads a job from a JSON value.
    pub(super) fn from_value(value: &Value) -> Result<JobFile, TextFault> {
        let of_version = value.get("truefeed_job").and_then(Value::as_u64);
        if let Some(other) = of_version.filter(|version| *version != JOB_VERSION) {
            let message = format!("version {other} is not known; this build reads version {JOB_VERSION}");
            return Err(TextFault::at_key("truefeed_job", message));
        }
        let job = Fields::of(value, "", &JOB_FIELDS)?;
        if of_version.is_none() {
            return Err(job.fault("truefeed_job", &format!("this field is missing; it is {JOB_VERSION}")));
        }
        let terms = match job.value("terms") {
            None => Terms::default(),
            Some(Value::Object(terms)) => {
                terms_from_values(terms).map_err(|faults| job.at("terms", &faults))?
            }
            Some(_) => return Err(job.fault("terms", "expected an object, {…}")),
        };
        let for_all = SharedSettings::of(&job)?;
        let operations = match job.value("operations") {
            Some(Value::Array(operations)) if (1..=MAX_OPERATIONS).contains(&operations.len()) => operations,
            _ => {
                let message = format!("expected a list of 1 to {MAX_OPERATIONS} operations");
                return Err(job.fault("operations", &message));
            }
        };
        let operation = |(index, value): (usize, &Value)| {
            let fields = Fields::of(value, &format!("operations[{index}]"), &OPERATION_FIELDS)?;
            operation(&fields, &for_all, &terms)
        };
        let operations = operations.iter().enumerate().map(operation).collect::<Result<_, _>>()?;
        Ok(JobFile {
            name: job.text("name", MAX_NAME_CHARACTERS)?,
            operations,
            terms,
            letter: Letter::of(&job)?,
        })
    }

    /// Returns the text of a job, each operation with all of its settings; machines and terms contain values
    /// that are not neutral. It begins with its version, which identifies the file as a job.
    pub fn to_json(&self) -> String {
        let rest =
            serde_json::to_string_pretty(&self.values()).expect("text and finite numbers have a JSON form");
        format!("{{\n  \"truefeed_job\": {JOB_VERSION},{}", rest.trim_start_matches('{'))
    }

    /// Returns all fields except the version.
    fn values(&self) -> Map<String, Value> {
        let mut job = Map::new();
        let neutral = terms_values(&Terms::default());
        let mut terms = terms_values(&self.terms);
        terms.retain(|key, value| neutral.get(key) != Some(value));
        let maps = [
            ("terms", terms),
            ("offer", self.letter.offer_values()),
            ("company", self.letter.company_values()),
        ];
        if !self.name.is_empty() {
            job.insert("name".to_string(), Value::from(self.name.as_str()));
        }
        let maps = maps.into_iter().filter(|(_, map)| !map.is_empty());
        job.extend(maps.map(|(key, map)| (key.to_string(), Value::Object(map))));
        let operations: Vec<Value> = self.operations.iter().map(JobOperationFile::to_value).collect();
        job.insert("operations".to_string(), Value::from(operations));
        job
    }
}

impl JobOperationFile {
    fn to_value(&self) -> Value {
        let seconds = |unit: Unit, time: f64| Value::from(tidy(unit.from_core(time)));
        let machine = match &self.machine {
            MachineSource::File(file) => Value::from(file.as_str()),
            MachineSource::Inline(machine) => {
                let neutral = values(&Machine::default());
                let mut own = values(machine);
                let is_needed = |key: &str| {
                    REQUIRED_KEYS.contains(&key) || TIME_CONSTANT_KEYS.contains(&key) || key == RAPID_KEY
                };
                own.retain(|key, value| neutral.get(key) != Some(value) || is_needed(key));
                Value::Object(own)
            }
        };
        let tolerance = match self.tolerances {
            Tolerances::One(tolerance) => Value::from(tolerance),
            Tolerances::Programmed => Value::Null,
        };
        let Options { dialect, arc_centers, .. } = self.options;
        let said = |text: &str| (!text.is_empty()).then(|| Value::from(text));
        let given = [
            ("program", said(&self.program)),
            ("name", said(&self.name)),
            ("text", self.text.as_deref().map(Value::from)),
            ("machine", Some(machine)),
            ("tolerance_mm", Some(tolerance)),
            ("dialect", dialect.map(|dialect| Value::from(dialect.word()))),
            ("arc_centres", arc_centers.map(|centers| Value::from(centers.word()))),
            ("fixture", self.fixture.map(|fixture| serde_json::json!({ "parts": fixture.parts }))),
            ("set_up_min", Some(seconds(Unit::Minute, self.set_up))),
            ("loading_s", Some(seconds(Unit::Second, self.loading))),
        ];
        let given = given.into_iter().filter_map(|(key, value)| Some((key.to_string(), value?)));
        Value::Object(filled(given))
    }
}

/// Settings of an operation, or of the job for all operations.
struct SharedSettings {
    machine: Option<MachineSource>,
    tolerances: Option<Tolerances>,
    dialect: Option<Dialect>,
    arc_centers: Option<ArcCenters>,
    fixture: Option<Fixture>,
}

impl SharedSettings {
    fn of(fields: &Fields) -> Result<SharedSettings, TextFault> {
        let dialects = Dialect::WORDS.map(|(word, ..)| word);
        let centers = ArcCenters::WORDS.map(|(word, ..)| word);
        Ok(SharedSettings {
            machine: machine(fields)?,
            tolerances: tolerances(fields)?,
            dialect: fields.word("dialect", &dialects, Dialect::from_word)?,
            arc_centers: fields.word("arc_centres", &centers, ArcCenters::from_word)?,
            fixture: fixture(fields)?,
        })
    }
}

fn operation(fields: &Fields, job: &SharedSettings, terms: &Terms) -> Result<JobOperationFile, TextFault> {
    let own = SharedSettings::of(fields)?;
    // Bounds and units are those of the terms.
    let times = ["set_up_min", "loading_s"].into_iter();
    let times = times.filter_map(|key| Some((key.to_string(), fields.value(key)?.clone())));
    let times = filled(times.filter(|(_, value)| !value.is_null()));
    let read = terms_from_values(&times).map_err(|faults| {
        let key = faults[0].key.clone().unwrap_or_default();
        fields.fault(&key, &faults[0].message)
    })?;
    let time = |key: &str, own: f64, of_all: f64| if times.contains_key(key) { own } else { of_all };
    let machine = own.machine.or_else(|| job.machine.clone());
    Ok(JobOperationFile {
        program: fields.needed_text("program", MAX_PATH_CHARACTERS)?,
        text: match fields.value("text") {
            None | Some(Value::Null) => None,
            Some(Value::String(text)) => Some(text.clone()),
            Some(_) => return Err(fields.fault("text", "expected the text of a program")),
        },
        name: fields.text("name", MAX_NAME_CHARACTERS)?,
        machine: machine
            .ok_or_else(|| fields.fault("machine", "this field is missing; give it here or for the job"))?,
        tolerances: own.tolerances.or(job.tolerances).unwrap_or(Tolerances::Programmed),
        options: Options {
            dialect: own.dialect.or(job.dialect),
            arc_centers: own.arc_centers.or(job.arc_centers),
            ..Options::default()
        },
        set_up: time("set_up_min", read.set_up, terms.set_up),
        loading: time("loading_s", read.loading, terms.loading),
        fixture: own.fixture.or(job.fixture),
    })
}

/// Reads the machine of an operation: the path of a machine file, or a machine itself.
fn machine(fields: &Fields) -> Result<Option<MachineSource>, TextFault> {
    match fields.value("machine") {
        None | Some(Value::Null) => Ok(None),
        Some(Value::String(path)) if path.ends_with(".toml") && !path.contains('\n') => {
            Ok(Some(MachineSource::File(path.clone())))
        }
        Some(value) => {
            let machine = machine_of(value.clone());
            machine
                .map(|machine| Some(MachineSource::Inline(Box::new(machine))))
                .map_err(|error| fields.fault("machine", &error.to_string()))
        }
    }
}

fn tolerances(fields: &Fields) -> Result<Option<Tolerances>, TextFault> {
    match fields.value("tolerance_mm") {
        None => Ok(None),
        Some(Value::Null) => Ok(Some(Tolerances::Programmed)),
        Some(value) => match value.as_f64().map(checked_tolerance) {
            Some(Ok(tolerance)) => Ok(Some(Tolerances::One(tolerance))),
            Some(Err(error)) => Err(fields.fault("tolerance_mm", &error.to_string())),
            None => {
                Err(fields.fault("tolerance_mm", "expected millimetres, or null for those of the program"))
            }
        },
    }
}

fn fixture(fields: &Fields) -> Result<Option<Fixture>, TextFault> {
    let Some(value) = fields.value("fixture").filter(|value| !value.is_null()) else { return Ok(None) };
    let fixture = Fields::of(value, &fields.place_of("fixture"), &["parts"])?;
    match fixture.number("parts", PARTS_PER_LOAD_BOUNDS)?.filter(|parts| parts.fract() == 0.0) {
        Some(parts) => Ok(Some(Fixture { parts: parts as u32 })),
        None => Err(fixture.fault(
            "parts",
            &format!(
                "expected a whole number from {} to {}",
                PARTS_PER_LOAD_BOUNDS.0, PARTS_PER_LOAD_BOUNDS.1
            ),
        )),
    }
}

#[cfg(test)]
mod tests {
    // What the file of a job may say, and where it is refused.

    use serde_json::json;

    use super::*;
    use crate::machine::presets;

    fn job() -> Value {
        json!({
            "truefeed_job": 1, "name": "Bracket", "machine": presets()[0].machine.name, "tolerance_mm": 0.01, "dialect": "siemens",
            "fixture": {"parts": 4}, "terms": {"quantity": 25, "set_up_min": 30, "loading_s": 10, "material": 4.2},
            "operations": [
                {"program": "op10.nc", "name": "Face", "set_up_min": 20, "tolerance_mm": null, "dialect": "iso", "arc_centres": "absolute"},
                {"program": "op20.nc", "machine": "mill.toml", "loading_s": 0, "fixture": {"parts": 1}, "text": "G1 X1 F100"},
            ],
            "offer": {"customer": "A\nB", "number": "Q-1", "tax_percent": 19},
            "company": {"name": "Us", "logo": "data:image/png;base64,AAAA"},
        })
    }

    fn refused(job: &Value) -> String {
        JobFile::from_json(&job.to_string()).expect_err("it is wrong").to_string()
    }

    #[test]
    fn what_an_operation_does_not_say_the_job_says() {
        let job = JobFile::from_json(&job().to_string()).expect("right");
        let [face, other] = &job.operations[..] else { panic!("two operations") };
        assert_eq!((face.set_up, face.loading, face.fixture), (1200.0, 10.0, Some(Fixture { parts: 4 })));
        assert_eq!(face.tolerances, Tolerances::Programmed);
        assert_eq!(face.options.dialect, Some(Dialect::Iso));
        assert_eq!(face.options.arc_centers, Some(ArcCenters::Absolute));
        assert_eq!(face.machine, MachineSource::Inline(Box::new(presets()[0].machine.clone())));
        assert_eq!((other.set_up, other.loading, other.fixture), (1800.0, 0.0, Some(Fixture { parts: 1 })));
        assert_eq!(other.tolerances, Tolerances::One(0.01));
        assert_eq!((other.options.dialect, other.options.arc_centers), (Some(Dialect::Siemens), None));
        assert_eq!(other.machine, MachineSource::File("mill.toml".to_string()));
        assert_eq!(other.text.as_deref(), Some("G1 X1 F100"));
        assert_eq!(job.terms.quantity, 25);
    }

    #[test]
    fn a_job_comes_back_from_its_own_text() {
        for preset in presets() {
            let mut given = job();
            given["machine"] = Value::from(preset.machine.name);
            let read = JobFile::from_json(&given.to_string()).expect("right");
            let text = read.to_json();
            assert_eq!(JobFile::from_json(&text), Ok(read), "{text}");
        }
        let mut jerk = presets()[0].machine.clone();
        jerk.interpolator.time_constants = crate::machine::TimeConstants::FromJerk(4e4);
        let mut given = job();
        given["machine"] = Value::from(crate::project::toml_from_machine(&jerk));
        let read = JobFile::from_json(&given.to_string()).expect("right");
        assert_eq!(JobFile::from_json(&read.to_json()), Ok(read));
    }

    #[test]
    fn an_unknown_field_is_named_with_the_nearest_known_one() {
        for (pointer, key, said) in [
            ("", "quantities", "quantities: unknown field; the nearest known one is "),
            ("", "operation", "operation: unknown field; the nearest known one is operations"),
            (
                "/operations/1",
                "tolerance_um",
                "operations[1].tolerance_um: unknown field; the nearest known one is tolerance_mm",
            ),
            (
                "/operations/0/fixture",
                "part",
                "operations[0].fixture.part: unknown field; the nearest known one is parts",
            ),
            ("/offer", "costumer", "offer.costumer: unknown field; the nearest known one is customer"),
            ("/company", "adress", "company.adress: unknown field; the nearest known one is address"),
            (
                "/terms",
                "quantitty",
                "terms.quantitty: there is no such term; the nearest known one is quantity",
            ),
        ] {
            let mut wrong = job();
            wrong["operations"][0]["fixture"] = json!({"parts": 2});
            wrong.pointer_mut(pointer).expect("it is there")[key] = Value::from(1);
            let told = refused(&wrong);
            assert!(told.starts_with(said), "{told}");
        }
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        for (pointer, value, said) in [
            ("/truefeed_job", json!(2), "truefeed_job: version 2 is not known; this build reads version 1"),
            ("/truefeed_job", json!("1"), "truefeed_job: this field is missing; it is 1"),
            ("/operations", json!([]), "operations: expected a list of 1 to 200 operations"),
            ("/operations/0", json!(7), "operations[0]: expected an object"),
            ("/operations/0/program", json!(""), "operations[0].program: this field is missing"),
            (
                "/operations/0/set_up_min",
                json!(-1),
                "operations[0].set_up_min: expected a number from 0 to 10000",
            ),
            ("/operations/0/tolerance_mm", json!(1e9), "operations[0].tolerance_mm: "),
            (
                "/operations/0/dialect",
                json!("basic"),
                "operations[0].dialect: expected one of: iso, linuxcnc",
            ),
            ("/operations/1/text", json!(3), "operations[1].text: expected the text of a program"),
            (
                "/operations/1/fixture",
                json!({"parts": 1.5}),
                "operations[1].fixture.parts: expected a whole number",
            ),
            ("/machine", json!("a mill"), "machine: there is no machine “a mill”; the presets are"),
            (
                "/machine",
                json!({"rapid.feed": 1}),
                "machine: the machine has faults: rapid.feed: unknown key",
            ),
            ("/terms/quantity", json!(0), "terms.quantity: expected a whole number"),
            ("/name", json!(["x"]), "name: expected a text of 200 characters at most"),
            ("/offer/tax_percent", json!(120), "offer.tax_percent: expected a number from 0 to 100"),
            ("/company/logo", json!("https://example.org/logo.png"), "company.logo: expected a picture"),
            (
                "/company/logo",
                json!("data:image/png;base64,\" onload=\""),
                "company.logo: expected a picture",
            ),
        ] {
            let mut wrong = job();
            *wrong.pointer_mut(pointer).expect("it is there") = value;
            let told = refused(&wrong);
            assert!(told.starts_with(said), "{pointer}: {told}");
        }
        let mut without = job();
        without.as_object_mut().expect("an object").remove("machine");
        assert!(
            refused(&without)
                .starts_with("operations[0].machine: this field is missing; give it here or for the job")
        );
        assert!(refused(&json!([])).contains("expected an object"));
        let broken = JobFile::from_json("{\n \"truefeed_job\": 1,,").expect_err("no JSON").to_string();
        assert!(broken.starts_with("line 2, column 20: this is no JSON"), "{broken}");
        let many: Vec<Value> = vec![job()["operations"][0].clone(); 201];
        let mut wrong = job();
        wrong["operations"] = Value::from(many);
        assert!(refused(&wrong).starts_with("operations: expected a list of 1 to 200"));
    }
}
