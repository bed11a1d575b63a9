//! Our own programs: seven kinds of jobs, each in the words of eight dialects (`examples/corpus`).

use std::collections::BTreeMap;
use std::fmt::Write;

use truefeed::machine::Machine;
use truefeed::quote::programmed_time;
use truefeed::simulation::feed::CornerPolicy;
use truefeed::simulation::gcode::{Dialect, Severity, read_with};
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::{Segment, Toolpath};

use crate::shared::kept::assert_kept;
use crate::shared::samples::{Sample, samples};

/// Coordinates are written to the micrometre and helices by their angle, so that rounding remains, mm.
const ROUNDING_MM: f64 = 1e-9;

/// The toolpaths by kind of job and dialect.
fn toolpaths() -> BTreeMap<String, BTreeMap<String, Toolpath>> {
    let mut jobs: BTreeMap<String, BTreeMap<String, Toolpath>> = BTreeMap::new();
    for Sample { kind, word, options, bytes } in samples() {
        let toolpath = trace(&read_with(&bytes, &options), &Machine::default());
        jobs.entry(kind).or_default().insert(word, toolpath);
    }
    assert_eq!(jobs.len(), 7);
    assert!(jobs.values().all(|dialects| dialects.len() == Dialect::WORDS.len()));
    jobs
}

fn is_alike(a: &Segment, b: &Segment) -> bool {
    (a.end - b.end).norm() < ROUNDING_MM
        && (a.length - b.length).abs() < ROUNDING_MM
        && (a.tangent(0.0) - b.tangent(0.0)).norm() < ROUNDING_MM
        && a.motion == b.motion
}

#[test]
fn a_job_is_the_same_toolpath_in_every_dialect() {
    for (kind, dialects) in toolpaths() {
        // How far a cycle retracts between pecks is each control's own.
        if kind == "drilling" {
            continue;
        }
        let reference = &dialects["iso"];
        assert!(1000 < reference.segments.len(), "{kind} moves");
        for (word, toolpath) in &dialects {
            assert_eq!(toolpath.segments.len(), reference.segments.len(), "{kind}, {word}");
            let mut pairs = toolpath.segments.iter().zip(reference.segments.iter());
            let differing = pairs.find(|(a, b)| !is_alike(a, b));
            assert!(differing.is_none(), "{kind}, {word}: {differing:?}");
        }
    }
}

#[test]
fn every_dialect_drills_the_holes_to_their_depth() {
    for (word, toolpath) in &toolpaths()["drilling"] {
        let depths = toolpath.segments.iter().map(|segment| segment.end.z);
        let deepest = depths.clone().fold(0.0, f64::min);
        let bottoms = depths.filter(|depth| (depth - deepest).abs() < ROUNDING_MM).count();
        assert_eq!(bottoms, 96, "{word}: {deepest} mm");
    }
}

#[test]
fn nothing_in_them_is_an_error() {
    for (kind, dialects) in toolpaths() {
        for (word, toolpath) in &dialects {
            let errors: Vec<_> =
                toolpath.diagnostics.iter().filter(|found| found.severity == Severity::Error).collect();
            assert!(errors.is_empty(), "{kind}, {word}: {errors:?}");
        }
    }
}

#[test]
fn times_are_those_kept() {
    let mut table = String::from("kind,dialect,segments,programmed_s,cycle_s\n");
    let machine = Machine::default();
    for (kind, dialects) in toolpaths() {
        for (word, toolpath) in &dialects {
            let plan = simulate::with_policy(toolpath, &machine, CornerPolicy::Programmed);
            let (programmed, cycle) = (programmed_time(toolpath, &machine), plan.cycle_time());
            let _ = writeln!(table, "{kind},{word},{},{programmed:.9},{cycle:.9}", toolpath.segments.len());
        }
    }
    assert_kept("times.csv", &table);
}
