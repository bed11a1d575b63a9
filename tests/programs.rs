//! Whole programs, from bytes to toolpath.
//!
//! Our own programs in `tests/data/programs` have what is expected of them beside them, written
//! out once by running with `TRUEFEED_UPDATE_EXPECTED=1`, then read and checked by hand. Programs
//! of others lie outside the repository, in `../shared`; where they are absent the tests say so.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use truefeed::machine::Machine;
use truefeed::simulation::gcode::{self, Dialect, Severity};
use truefeed::simulation::interpreter;
use truefeed::simulation::toolpath::{self, Curve, Motion, PathMode, StopCause, Toolpath};
use truefeed::units::mm_per_min;

use crate::shared::corpus;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The files below `folder`, in order; none, and a note, where it is absent.
fn files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        eprintln!("skipped: programs of others: {} is not there", folder.display());
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("a readable folder").path()).collect();
    paths.sort();
    paths.into_iter().flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// The toolpath of the program read whole, which is that of the program read part by part.
fn trace(path: &Path) -> Toolpath {
    let bytes = std::fs::read(path).expect("a readable file");
    let (options, machine) = (gcode::Options::default(), Machine::default());
    let toolpath = interpreter::trace(&gcode::read(&bytes), &machine);
    assert_eq!(interpreter::trace_text(bytes, &options, &machine), toolpath, "{}", path.display());
    toolpath
}

/// A dozen lines that say what a toolpath holds.
fn summary(toolpath: &Toolpath) -> String {
    let (mut feed, mut rapid, mut feed_time, mut arcs, mut exact) = (0.0, 0.0, 0.0, 0, 0);
    for segment in &toolpath.segments {
        match segment.motion {
            Motion::Rapid { .. } => rapid += segment.length,
            Motion::Feed { feedrate } => {
                feed += segment.length;
                feed_time += segment.length / feedrate;
            }
        }
        arcs += usize::from(matches!(segment.curve, Curve::Arc(_)));
        exact += usize::from(segment.exact_stop);
    }
    let mut text = String::new();
    let segments = toolpath.segments.len();
    writeln!(text, "segments {segments}, arcs {arcs}, exact stops {exact}").expect("text grows");
    writeln!(text, "feed {feed:.4} mm in {feed_time:.4} s, rapid {rapid:.4} mm").expect("text grows");
    if let Some(last) = toolpath.segments.last() {
        let [x, y, z] = [last.end.x, last.end.y, last.end.z];
        let feedrate = match last.motion {
            Motion::Rapid { .. } => "rapid".to_string(),
            Motion::Feed { feedrate } => format!("{:.4} mm/min", mm_per_min(feedrate)),
        };
        let line = last.line.0;
        writeln!(text, "last: line {line} to X{x:.4} Y{y:.4} Z{z:.4}, {feedrate}").expect("text grows");
    }
    for stop in &toolpath.stops {
        let cause = match stop.cause {
            StopCause::Dwell { seconds } => format!("dwell {seconds} s"),
            StopCause::Rotary { rotation, rate } => {
                let [a, b, c] = rotation.map(f64::to_degrees).into();
                let rate = rate
                    .map_or("rapid".to_string(), |rate| format!("{:.4} deg/min", 60.0 * rate.to_degrees()));
                format!("turn by A{a:.4} B{b:.4} C{c:.4}, {rate}")
            }
            StopCause::ToolChange { tool: Some(tool) } => format!("tool change to {tool}"),
            StopCause::ToolChange { tool: None } => "tool change".to_string(),
            StopCause::SameTool { tool } => format!("tool {tool} is there already"),
            StopCause::MCode { code } | StopCause::Spindle { code: Some(code), .. } => format!("M{code}"),
            StopCause::Spindle { to, .. } => format!("spindle to {} rpm", to.signed_speed()),
        };
        writeln!(text, "stop after {}: {cause}, line {}", stop.after, stop.line.0).expect("text grows");
    }
    for mode in &toolpath.path_modes {
        let PathMode { from, line, source, blending, merging: _ } = mode;
        writeln!(text, "path mode from {from}: {blending:?} by {source}, line {}", line.0)
            .expect("text grows");
    }
    for diagnostic in &toolpath.diagnostics {
        let (line, severity, message) = (diagnostic.line.0, diagnostic.severity, &diagnostic.message);
        let (first, past) = diagnostic.columns;
        let columns = if first == past { String::new() } else { format!(":{first}-{}", past - 1) };
        writeln!(text, "{severity:?} {line}{columns}: {message}").expect("text grows");
    }
    text
}

/// What every toolpath holds, whatever its program.
fn check_laws(path: &Path, toolpath: &Toolpath) {
    let name = path.display();
    for segment in &toolpath.segments {
        let line = segment.line.0;
        assert!(0.0 < segment.length && segment.length.is_finite(), "{name}: length in line {line}");
        if let Motion::Feed { feedrate } = segment.motion {
            assert!(0.0 < feedrate && feedrate.is_finite(), "{name}: feedrate in line {line}");
        }
        let radius = if let Curve::Arc(arc) = &segment.curve { arc.mean_radius() } else { 0.0 };
        let size = 1.0 + radius + segment.end.coords.norm() + segment.start.coords.norm();
        let (first, last) = (segment.point(0.0), segment.point(segment.length));
        assert!((first - segment.start).norm() <= 1e-9 * size, "{name}: start of line {line}");
        assert!((last - segment.end).norm() <= 1e-9 * size, "{name}: end of line {line}");
    }
    assert!(toolpath.stops.is_sorted_by_key(|stop| stop.after), "{name}: stops");
    assert!(toolpath.stops.iter().all(|stop| stop.after <= toolpath.segments.len()), "{name}: stops");
    assert!(toolpath.diagnostics.is_sorted_by_key(|diagnostic| diagnostic.line), "{name}: diagnostics");
}

#[test]
fn own_programs_give_what_is_expected() {
    let programs = files(&root().join("tests/data/programs"));
    let programs: Vec<_> = programs
        .iter()
        .filter(|path| path.extension().is_some_and(|e| e != "expected" && e != "ngc"))
        .collect();
    assert!(!programs.is_empty(), "the programs of the repository are always there");
    for path in programs {
        let toolpath = trace(path);
        check_laws(path, &toolpath);
        let (found, expected_path) = (summary(&toolpath), path.with_extension("expected"));
        if std::env::var_os("TRUEFEED_UPDATE_EXPECTED").is_some() {
            std::fs::write(&expected_path, &found).expect("a writable folder");
        }
        let expected = std::fs::read_to_string(&expected_path).unwrap_or_default();
        assert_eq!(found, expected, "{} is not as beside it", path.display());
    }
}

#[test]
fn recorded_programs_and_those_of_others_are_traced() {
    let shared = root().join("../shared");
    let iso = ["fanuc_haas", "linuxcnc", "camotics", "grbl", "mach3"];
    let folders = iso.map(|folder| shared.join("gcode").join(folder));
    let recorded = ["plant", "linuxcnc"].map(|folder| corpus::recordings().join(folder));
    let folders = folders.into_iter().chain(recorded).chain([shared.join("recordings/nist-hurco/programs")]);
    let is_program = |path: &PathBuf| {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        ["nc", "ngc", "gcode"].iter().any(|known| extension == *known)
    };
    for path in folders.flat_map(|folder| files(&folder)).filter(is_program) {
        let toolpath = trace(&path);
        check_laws(&path, &toolpath);
        let is_understood = !toolpath.segments.is_empty() || !toolpath.diagnostics.is_empty();
        assert!(is_understood, "{}: nothing moves and nothing is said", path.display());
        println!("=== {}\n{}", path.display(), summary(&toolpath));
    }
}

/// Length of feed moves over their feedrates, as the origin of the programs states it, s.
#[test]
fn programmed_times_of_recorded_programs_agree() {
    let folder = root().join("../shared/recordings/nist-hurco/programs");
    for (name, expected) in [("box-op1.nc", 1338.0), ("box-op2.nc", 62.0), ("box-op3.nc", 307.0)] {
        let path = folder.join(name);
        if !path.exists() {
            eprintln!("skipped: programs of others: {} is not there", path.display());
            continue;
        }
        let feed_time = |segment: toolpath::Segment| match segment.motion {
            Motion::Rapid { .. } => 0.0,
            Motion::Feed { feedrate } => segment.length / feedrate,
        };
        let time: f64 = trace(&path).segments.iter().map(feed_time).sum();
        assert!((time - expected).abs() < 0.5, "{name}: {time:.2} s, stated {expected} s");
    }
}

/// Its head says: a block of 100 × 100 × 50 mm with the zero point at the centre of its top, and a
/// cutter of 10 mm. Every coordinate of it is an expression.
#[test]
fn a_program_of_expressions_stays_on_its_part() {
    let path = root().join("../shared/gcode/linuxcnc/linuxcnc__3D_Chips.ngc");
    if !path.exists() {
        eprintln!("skipped: programs of others: {} is not there", path.display());
        return;
    }
    let toolpath = trace(&path);
    assert_eq!(toolpath.segments.len(), 4684);
    assert_eq!(toolpath.diagnostics.iter().filter(|found| found.severity == Severity::Error).count(), 0);
    for segment in &toolpath.segments {
        let (end, line) = (segment.end, segment.line.0);
        assert!(end.x.abs() <= 60.0 && end.y.abs() <= 60.0, "line {line}: beside the part");
        assert!((-50.0..=10.0).contains(&end.z), "line {line}: above or below the part");
        assert!(segment.length <= 120.0, "line {line}: {} mm", segment.length);
    }
}

/// The programs of others lie in folders that say what they were written for; one of plain words
/// is plain ISO.
#[test]
fn programs_of_others_are_told_apart() {
    let folders = [
        ("fanuc_haas", [Dialect::Iso].as_slice()),
        ("linuxcnc", &[Dialect::LinuxCnc, Dialect::Iso]),
        ("camotics", &[Dialect::LinuxCnc, Dialect::Iso]),
        ("grbl", &[Dialect::Grbl, Dialect::Iso]),
        ("mach3", &[Dialect::Mach]),
        ("siemens840d", &[Dialect::Siemens]),
        ("heidenhain", &[Dialect::Klartext]),
    ];
    for (folder, dialects) in folders {
        for path in files(&root().join("../shared/gcode").join(folder)) {
            let found = gcode::read(&std::fs::read(&path).expect("a readable file")).dialect;
            assert!(dialects.contains(&found), "{}: {found:?}", path.display());
        }
    }
}
