//! Machine files with numbers at the ends of their bounds and beyond: each gives a finite result, or a refusal in a sentence.

use std::collections::BTreeMap;
use std::path::Path;

use toml::Value;
use truefeed::machine::{Access, PARAMETERS};
use truefeed::project::{TextFault, machine_from_toml};
use truefeed::quote::{Quote, quote};
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::simulate;

/// Moves of every kind, with all that takes time beside them.
const PROGRAM: &str = "G21 G90 G17\nT1 M6\nS3000 M3\nM8\nG54 G0 X0 Y0 Z5\nG1 Z-1 F500\nX20 F2000\nX20.01\nX20.02 Y0.01\nG3 X30 Y10 I0 J10\nG2 X35 Y10 I2.5 J0 Z-2\nG1 X0.5 Y20\nA90\nX10 A0\nG61 X15\nG64 X15 Y0\nG4 P0.5\nG0 Z50\nG81 X1 Y1 Z-3 R1 F300\nX9\nG80\nG95 F0.1 G1 X20\nG94\nT2 M6\nS500 M4\nG0 Z0\nM9\nM0\nG28 Z0\nM30\n";

/// Tolerances, mm: sharp, and as wide as the path.
const TOLERANCES_MM: [f64; 2] = [0.001, 5.0];

/// The keys of a machine file, each with its value as written.
type Keys = BTreeMap<String, String>;

fn keys(text: &str) -> Keys {
    fn collect(table: &toml::Table, before: &str, keys: &mut Keys) {
        for (key, value) in table {
            let key = format!("{before}{key}");
            match value {
                Value::Table(inner) => collect(inner, &format!("{key}."), keys),
                value => drop(keys.insert(key, value.to_string())),
            }
        }
    }
    let mut keys = Keys::new();
    collect(&text.parse().expect("a machine file"), "", &mut keys);
    keys
}

/// The machine files of the tests, by name.
fn files() -> Vec<(String, Keys)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/machines");
    let paths = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("a file").path());
    let mut files: Vec<_> = paths
        .map(|path| {
            let text = std::fs::read_to_string(&path).expect("text");
            (path.file_stem().expect("a name").to_string_lossy().into_owned(), keys(&text))
        })
        .collect();
    files.sort();
    files
}

/// A machine file with one value, without the keys that exclude it.
fn text_with(file: &Keys, key: &str, value: &str) -> String {
    let constants =
        ["interpolator.time_constant_s", "interpolator.time_constants_s", "interpolator.jerk_mm_s3"];
    let mut keys = file.clone();
    if constants.contains(&key) {
        keys.retain(|known, _| !constants.contains(&known.as_str()));
    }
    keys.insert(key.to_string(), value.to_string());
    keys.iter().map(|(key, value)| format!("{key} = {value}\n")).collect()
}

/// The quotes of the program, or why the file is refused.
fn quotes(text: &str) -> Result<Vec<Quote>, TextFault> {
    let machine = machine_from_toml(text)?;
    let toolpath = trace(&read(PROGRAM.as_bytes()), &machine);
    let quotes = TOLERANCES_MM.map(|tolerance| {
        let (plan, errors) = simulate::within(&toolpath, &machine, tolerance, &mut |_| {});
        quote(&toolpath, &machine, &plan, tolerance, &errors)
    });
    Ok(quotes.into())
}

/// Whether all that is shown of a quote is a number.
fn is_finite(quote: &Quote) -> bool {
    let shares = quote.operations.iter().flat_map(|own| [own.distance.0, own.distance.1]);
    let numbers = [quote.cycle_time, quote.price, quote.max_contour_error, quote.trust.seconds_in_doubt()];
    numbers.into_iter().chain(shares).all(|number| number.is_finite() && 0.0 <= number)
}

/// A numeric key with its bounds, in the unit of the file, and what stands around a value.
struct Numeric {
    key: &'static str,
    bounds: [f64; 2],
    around: [String; 2],
}

fn numeric() -> Vec<Numeric> {
    let numeric = PARAMETERS.iter().filter_map(|row| {
        let (min, max, before, after) = match row.access {
            Access::Number { min, max, .. } => (min, max, String::new(), ""),
            Access::List { min, max, .. } => (min, max, "[".to_string(), "]"),
            Access::Codes { letter, min, max, .. } => (min, max, format!("{{ {letter}8 = "), " }"),
            _ => return None,
        };
        Some(Numeric { key: row.key, bounds: [min, max], around: [before, after.to_string()] })
    });
    numeric.collect()
}

/// Values at the bounds and beyond, as a file writes them, and whether they are legal.
fn values([min, max]: [f64; 2]) -> Vec<(String, bool)> {
    // Keys of whole numbers refuse a point.
    let written = |value: f64| {
        if value.fract() == 0.0 && value.abs() < 1e15 { format!("{value:.0}") } else { format!("{value:e}") }
    };
    let beyond = |bound: f64| 1e-3 * bound.abs().max(1e-9);
    let beyond = [min - beyond(min), max + beyond(max), -1e300, 1e300].map(written);
    let none = ["nan", "inf", "-inf", "\"much\""].map(str::to_string);
    let legal = [min, max].map(written).into_iter().map(|value| (value, true));
    legal.chain(beyond.into_iter().chain(none).map(|value| (value, false))).collect()
}

fn check(files: &[(String, Keys)]) {
    let (mut results, mut refusals) = (0, Vec::new());
    for (name, file) in files {
        for Numeric { key, bounds, around: [before, after] } in numeric() {
            for (value, is_legal) in values(bounds) {
                let case = format!("{name}: {key} = {value}");
                match quotes(&text_with(file, key, &format!("{before}{value}{after}"))) {
                    Ok(quotes) => {
                        assert!(is_legal, "{case} is taken");
                        assert!(quotes.iter().all(is_finite), "{case}: {quotes:?}");
                        results += 1;
                    }
                    Err(fault) => {
                        let sentence = fault.to_string();
                        assert!(sentence.contains(' ') && !sentence.contains('\n'), "{case}: {sentence}");
                        refusals.extend(is_legal.then(|| format!("{case}: {sentence}")));
                    }
                }
            }
        }
    }
    // A legal value may contradict another key of the file.
    assert!(10 * refusals.len() < results, "{results} give a result, refused are {refusals:#?}");
}

#[test]
fn numbers_at_and_beyond_their_bounds_give_a_result_or_a_refusal() {
    let files = files();
    let generic: Vec<_> = files.into_iter().filter(|(name, _)| name == "generic").collect();
    assert_eq!(generic.len(), 1);
    check(&generic);
}

#[test]
#[ignore = "the same on every kind of machine"]
fn numbers_at_and_beyond_their_bounds_on_every_machine() {
    check(&files());
}
