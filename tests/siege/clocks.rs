//! Recordings whose times are in another unit than they say, or lie an age apart: refused or taken apart at once.

use truefeed::identification::alignment::{AlignmentError, align_log};
use truefeed::identification::recording::read;
use truefeed::simulation::gcode;
use truefeed::simulation::interpreter::trace;

use crate::sceptic::{Rows, csv, machine, program, recorded};

/// What the alignment says of a recording of the program.
fn refusal(text: &str) -> Option<AlignmentError> {
    let log = read(text.as_bytes()).unwrap_or_else(|error| panic!("{error}"));
    let toolpath = trace(&gcode::read(program().as_bytes()), &machine());
    align_log(&log, &toolpath, &machine()).err()
}

/// Times in seconds under a head of milliseconds or microseconds, and factors that no head explains. A diagnosis of the
/// first had not ended after 50 s.
#[test]
fn times_in_another_unit_are_refused_with_both_durations() {
    let run = recorded(&program(), &machine(), 100.0);
    let lasts = run[run.len() - 1][0];
    let table = csv(&run);
    assert!(table.starts_with("t_s,"), "{}", &table[..40]);
    assert_eq!(refusal(&table), None);
    let scaled = |factor: f64| -> String {
        csv(&run.iter().map(|[time, x, y, z]| [time * factor, *x, *y, *z]).collect::<Rows>())
    };
    let cases = [
        ("t_ms", 1e-3, table.replacen("t_s", "t_ms", 1)),
        ("t_us", 1e-6, table.replacen("t_s", "t_us", 1)),
        ("milliseconds as seconds", 1e3, scaled(1e3)),
        ("microseconds as seconds", 1e6, scaled(1e6)),
    ];
    for (name, factor, text) in cases {
        match refusal(&text) {
            Some(AlignmentError::TimeUnit { recorded, simulated }) => {
                assert!((0.5..1.5).contains(&(recorded / (factor * lasts))), "{name}: {recorded} s");
                assert!((0.5..1.5).contains(&(simulated / lasts)), "{name}: {simulated} s");
            }
            other => panic!("{name}: {other:?}"),
        }
    }
}

/// What follows thirty years of silence is another recording.
#[test]
fn an_age_without_samples_parts_recordings() {
    let mut run = recorded(&program(), &machine(), 100.0);
    let half = run.len() / 2;
    run[half..].iter_mut().for_each(|row| row[0] += 1e9);
    let log = read(csv(&run).as_bytes()).unwrap_or_else(|error| panic!("{error}"));
    let lasts: Vec<f64> = log.recordings.iter().map(|recording| recording.duration).collect();
    assert_eq!(log.recordings.len(), 2, "{lasts:?}");
    assert!(lasts.iter().all(|seconds| *seconds < 100.0), "{lasts:?}");
}
