//! Files that nobody wrote: mutations of our own programs and machine files must be read without
//! a panic and within bounds, and what comes out must hold the laws. `scripts/fuzz` does the same
//! for long, led by coverage.

pub mod borders;
mod laws;
pub mod mutate;

use crate::fuzz::mutate::Random;
use std::path::{Path, PathBuf};
use truefeed::simulation::gcode::Dialect;

/// How many files are made of each kind; more by `TRUEFEED_EXECUTIONS=100000`.
const EXECUTIONS: usize = 2_000;

fn executions() -> usize {
    let asked = std::env::var("TRUEFEED_EXECUTIONS").ok();
    asked.map_or(EXECUTIONS, |asked| asked.parse().expect("TRUEFEED_EXECUTIONS is a number"))
}

/// All files below a folder but what is expected of them.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("the programs of the repository are always there");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("a readable folder").path()).collect();
    paths.sort();
    let inside = |path: PathBuf| if path.is_dir() { files(&path) } else { vec![path] };
    let is_seed = |path: &PathBuf| path.extension().is_none_or(|extension| extension != "expected");
    paths.into_iter().flat_map(inside).filter(is_seed).collect()
}

fn seeds(folder: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(folder);
    files(&folder).iter().map(|path| std::fs::read(path).expect("a readable file")).collect()
}

/// Checks mutations of `seeds`; one that fails is written to a file whose name is said.
fn run(name: &str, seeds: &[Vec<u8>], seed: u64, law: fn(&[u8])) {
    let words = mutate::words(include_str!("words.dict"));
    assert!(100 < words.len() && !seeds.is_empty());
    let mut random = Random(seed);
    let executions = executions();
    for number in 0..executions {
        let bytes = mutate::mutated(&mut random, seeds, &words);
        if let Err(panic) = std::panic::catch_unwind(|| law(&bytes)) {
            let path = std::env::temp_dir().join(format!("truefeed-{name}-{number}"));
            std::fs::write(&path, &bytes).expect("a writable folder");
            eprintln!("{name}: execution {number} fails; its file is {}", path.display());
            std::panic::resume_unwind(panic);
        }
    }
    println!("{name}: {executions} executions over {} seeds", seeds.len());
}

#[test]
fn mutated_programs_hold_the_laws() {
    run("program", &seeds("programs"), 0x5eed_0001, laws::program);
}

#[test]
fn mutated_machine_files_hold_the_laws() {
    let machines = seeds("machines");
    for bytes in &machines {
        let text = std::str::from_utf8(bytes).expect("our own files are UTF-8");
        assert_eq!(truefeed::project::machine_from_toml(text).err().map(|fault| fault.message), None);
    }
    run("machine_file", &machines, 0x5eed_0002, laws::machine_file);
}

#[test]
fn mutated_recordings_hold_the_laws() {
    run("recording", &seeds("recordings"), 0x5eed_0003, borders::recording);
}

#[test]
fn mutated_requests_hold_the_laws() {
    run("request", &seeds("requests"), 0x5eed_0004, borders::request);
}

#[test]
fn mutated_settings_hold_the_laws() {
    run("settings", &seeds("settings"), 0x5eed_0005, borders::settings);
}

#[test]
fn mutated_forms_hold_the_laws() {
    run("forms", &seeds("forms"), 0x5eed_0006, borders::forms);
}

#[test]
fn mutated_cutting_jobs_hold_the_laws() {
    run("cutting_job", &seeds("cutting"), 0x5eed_0007, borders::cutting_job);
}

#[test]
fn seeds_of_the_other_borders_are_understood() {
    let text = |bytes: &Vec<u8>| String::from_utf8(bytes.clone()).expect("our own files are UTF-8");
    for json in seeds("requests").iter().map(text) {
        assert!(truefeed::project::QuoteRequest::from_json(&json).is_ok(), "{json}");
    }
    for json in seeds("settings").iter().map(text) {
        assert_eq!(truefeed::project::settings_from_text(&json).err(), None, "{json}");
    }
    for toml in seeds("cutting").iter().map(text) {
        let setup = truefeed::project::cutting_from_toml(&toml, &truefeed::machine::Machine::default());
        assert_eq!(setup.err().map(|fault| fault.to_string()), None);
    }
    let forms: Vec<String> = seeds("forms").iter().map(text).collect();
    assert!(forms.iter().any(|json| truefeed::project::machine_from_form(json).is_ok()));
    assert!(forms.iter().any(|json| truefeed::project::terms_from_form(json).is_ok()));
    let offers: Vec<_> = forms.iter().map(|json| truefeed::project::OfferReport::from_json(json)).collect();
    assert!(offers.iter().any(Result::is_ok), "{offers:?}");
}

#[test]
fn mutated_plans_hold_the_laws() {
    run("planned", &seeds("programs"), 0x5eed_0008, borders::planned);
}

/// What `scripts/fuzz` found to break a law, by target or dialect; `tests/recording_readers.rs` has the recordings.
#[test]
fn files_that_broke_a_law_break_it_no_more() {
    let mut count = 0;
    for path in files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/known")) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let bytes = std::fs::read(&path).expect("a readable file");
        println!("{name}");
        match name.split('-').next() {
            Some("recording") => continue,
            Some("program") => laws::program(&bytes),
            Some("planned") => borders::planned(&bytes),
            dialect => {
                laws::program_in(&bytes, Some(dialect.and_then(Dialect::from_word).expect("a dialect")))
            }
        }
        count += 1;
    }
    assert!(0 < count);
}

/// Found by `scripts/fuzz`: a cell with a control character, which the refusal showed, on a line of its own.
#[test]
fn cells_of_recordings_are_shown_without_control_characters() {
    let mut log = "t_s,x_mm,feed_mm_min,line\n".to_string();
    for row in 0..60 {
        let feed = if row % 10 == 5 { "1\u{12}00.0" } else { "1200.0" };
        log += &format!("0.{row:02},{row},{feed},10\n");
    }
    borders::recording(log.as_bytes());
    let refusal =
        truefeed::identification::recording::read(log.as_bytes()).expect_err("not numbers").to_string();
    assert!(refusal.contains("1\u{fffd}00.0"), "{refusal}");
}

#[test]
fn programs_cut_off_anywhere_hold_the_laws() {
    let mut executions = 0;
    for bytes in seeds("programs") {
        for end in (0..=bytes.len()).step_by(7) {
            laws::program(&bytes[..end]);
            executions += 1;
        }
    }
    println!("{executions} executions");
}

/// Reads one that fuzzing found, in the dialect that it was found in.
fn in_linuxcnc(bytes: &[u8]) {
    laws::program_in(bytes, Some(Dialect::LinuxCnc));
}

/// A block that opened a loop and was then found faulty left its jump behind.
#[test]
fn a_faulty_block_opens_nothing() {
    in_linuxcnc(b"o1 repeat [10] ?\nG1 X1\nM2\n");
    in_linuxcnc(b"o1 while [#1 LT 3] ?\nG1 X1\no1 endwhile\nM2");
}

/// A program that ran into its bound within a subprogram went back from there and on.
#[test]
fn an_endless_subprogram_ends_the_program() {
    in_linuxcnc(b"o1 sub\no2 while [1]\nG4 P0\no2 endwhile\no1 endsub\no1 call\nM2\n");
}

/// Found by `scripts/fuzz`: a move of no length after G40, where the tool was on the path already.
#[test]
fn a_move_of_no_length_after_compensation_is_none() {
    let text = "G42.1 D4\nG3 X30 Y30 I-10 J0\nG1 X0\nY0\nG40 X-2\nY0";
    laws::program_in(text.as_bytes(), Some(Dialect::LinuxCnc));
}

/// Found by `scripts/fuzz`: the name of a parameter with a control character, which a remark showed.
#[test]
fn names_of_parameters_hold_no_control_characters() {
    laws::program_in(b"X#<wid\x7fth>\nX#<wid\xc2\x85th>\nO<a\x7f> CALL", Some(Dialect::LinuxCnc));
}

/// Found by mutation: blocks of nothing but a number or a slash.
#[test]
fn empty_blocks_of_heidenhain_programs_are_none() {
    laws::program_in(b"N10\nN20 *\n/\n*", Some(Dialect::HeidenhainIso));
    laws::program_in(b"10 /\n/\n20", Some(Dialect::Klartext));
}
