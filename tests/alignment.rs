//! Recordings as they come, on programs: shifted, several times in a file, with ways before and behind, and of another
//! program. The truth is simulated and sampled here; what is refused, or taken for another, is counted over all pairs.

use truefeed::identification::alignment::{Alignment, AlignmentError, Pairing, align_log, pair};
use truefeed::identification::comparison::compare;
use truefeed::identification::diagnosis::regions;
use truefeed::identification::recording::{Log, read};
use truefeed::machine::{Machine, TimeConstants};
use truefeed::simulation::gcode;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Toolpath;

use crate::sceptic::{Rows, csv, recorded};
use crate::shared::recordings_of_others;

const HEAD: &str = "G21 G90 G94 G17\nG0 X3 Y2 Z5\n";

fn machine() -> Machine {
    let mut machine = Machine::default();
    machine.interpolator.time_constants = TimeConstants::Equal(0.015);
    machine.interpolator.contour_tolerance = 0.02;
    machine.rapid.feedrate = 200.0;
    machine
}

/// 3-D finishing in chords of a third of a millimetre.
fn finishing() -> String {
    let mut text = format!("{HEAD}G1 Z0 F900\nF2500\n");
    for row in 0..5 {
        let y = 2.0 + 1.2 * f64::from(row);
        for step in 0..70 {
            let x = 3.0 + 0.35 * f64::from(if row % 2 == 0 { step } else { 69 - step });
            text += &format!("X{x:.4} Y{y:.4} Z{:.4}\n", -1.5 * (x / 6.0).sin() * (y / 4.0).cos());
        }
    }
    text + "G0 Z12\nX0 Y0\nM30\n"
}

/// A pocket from the inside to the outside, with arcs in its corners.
fn pocket(inner: f64) -> String {
    let mut text = format!("{HEAD}G0 X25 Y20\nG1 Z-2 F400\nF1800\n");
    for turn in 1..6 {
        let (a, b, r) = (inner * f64::from(turn), 1.6 * f64::from(turn), 1.2);
        text += &format!("G1 X{} Y{}\nG3 X{} Y{} J{r}\n", 25.0 + a - r, 20.0 - b, 25.0 + a, 20.0 - b + r);
        text += &format!("G1 Y{}\nG3 X{} Y{} I-{r}\n", 20.0 + b - r, 25.0 + a - r, 20.0 + b);
        text += &format!("G1 X{}\nG3 X{} Y{} J-{r}\n", 25.0 - a + r, 25.0 - a, 20.0 + b - r);
        text += &format!("G1 Y{}\nG3 X{} Y{} I{r}\n", 20.0 - b + r, 25.0 - a + r, 20.0 - b);
    }
    text + "G0 Z10\nX60 Y5\nG1 Z-1 F500\nG2 I6 F1500\nG0 Z20\nM30\n"
}

fn drilling() -> String {
    let mut text = HEAD.to_string();
    for hole in 0..20 {
        let (column, row) = (f64::from(hole % 5), f64::from(hole / 5));
        text += &format!(
            "G0 X{} Y{}\nZ1\nG1 Z-4 F350\nG0 Z5\n",
            8.0 * column + 1.5 * row,
            7.0 * row + 0.5 * column
        );
    }
    text + "G0 Z30\nM30\n"
}

fn engraving() -> String {
    let mut text = HEAD.to_string();
    let mut seed = 7u32;
    let mut next = |most: f64| {
        seed = seed.wrapping_mul(1_103_515_245).wrapping_add(12_345);
        most * f64::from(seed >> 16) / 65_536.0
    };
    for letter in 0..9 {
        let x = 6.0 * f64::from(letter) + 4.0;
        text += &format!("G0 X{x} Y10\nG1 Z-0.3 F300\nF1200\n");
        for _ in 0..5 {
            text += &format!("G1 X{:.3} Y{:.3}\n", x + next(4.0), 10.0 + next(6.0));
        }
        text += "G0 Z2\n";
    }
    text + "G0 X0 Y0\nM30\n"
}

/// Rows of roughing, `step` (mm) apart.
fn roughing(step: f64) -> String {
    let mut text = format!("{HEAD}G0 X-4 Y0\nG1 Z-3 F600\nF3500\n");
    for row in 0..8 {
        let y = step * f64::from(row);
        text += &format!("G1 X{}\nY{}\n", if row % 2 == 0 { 70.0 } else { -4.0 }, y + step);
    }
    text + "G0 Z15\nX0 Y0\nM30\n"
}

fn programs() -> Vec<(&'static str, String)> {
    vec![
        ("finishing", finishing()),
        ("pocket", pocket(2.2)),
        ("longer pocket", pocket(2.9)),
        ("drilling", drilling()),
        ("engraving", engraving()),
        ("roughing", roughing(4.5)),
        ("closer roughing", roughing(3.5)),
    ]
}

fn toolpath(text: &str) -> Toolpath {
    trace(&gcode::read(text.as_bytes()), &machine())
}

/// The parts one after the other, with straight ways at 100 mm/s between them.
fn joined(parts: &[Rows]) -> Rows {
    let mut all: Rows = Vec::new();
    for part in parts {
        if let (Some(last), Some(first)) = (all.last().copied(), part.first()) {
            let way: f64 = (1..4).map(|axis| (first[axis] - last[axis]).powi(2)).sum::<f64>().sqrt();
            let steps = way.ceil() + 1.0;
            for step in 1..steps as usize {
                let share = step as f64 / steps;
                let at = |axis: usize| last[axis] + share * (first[axis] - last[axis]);
                all.push([last[0] + 0.01 * step as f64, at(1), at(2), at(3)]);
            }
        }
        let begin = all.last().map_or(0.0, |row| row[0] + 0.01);
        all.extend(part.iter().map(|[time, x, y, z]| [begin + time - part[0][0], *x, *y, *z]));
    }
    all
}

/// A way far away from every program.
fn away() -> Rows {
    (0..60).map(|row| [0.02 * f64::from(row), 180.0, 140.0 - f64::from(row), 90.0]).collect()
}

fn shifted(rows: &Rows, by: [f64; 3]) -> Rows {
    rows.iter().map(|[time, x, y, z]| [*time, x + by[0], y + by[1], z + by[2]]).collect()
}

fn log(rows: &Rows) -> Log {
    read(csv(rows).as_bytes()).expect("a table")
}

fn aligned(rows: &Rows, program: &str) -> Result<Alignment, AlignmentError> {
    align_log(&log(rows), &toolpath(program), &machine()).map(|(_, alignment)| alignment)
}

fn part(alignment: &Alignment) -> f64 {
    (alignment.covered.end - alignment.covered.start) / alignment.length
}

#[test]
fn machine_coordinates_are_found_with_ways_before_and_behind() {
    let by = [-412.37, 118.02, -233.61];
    for (name, program) in programs() {
        let run = recorded(&program, &machine(), 100.0);
        for rows in [run.clone(), joined(&[away(), run, away()])] {
            let alignment = aligned(&shifted(&rows, by), &program).unwrap_or_else(|e| panic!("{name}: {e}"));
            let off = (0..3).map(|axis| (alignment.shift[axis] - by[axis]).abs()).fold(0.0, f64::max);
            assert!(off < 0.02, "{name}: {:?} is {off} mm off", alignment.shift);
            assert!(0.95 < part(&alignment), "{name}: {} of the path", part(&alignment));
            assert_eq!(alignment.passes, 1, "{name}");
        }
    }
}

#[test]
fn passes_are_taken_apart() {
    let by = [55.5, -71.25, 12.125];
    for (name, program) in programs() {
        let run = recorded(&program, &machine(), 50.0);
        let tail: Rows = run[4 * run.len() / 5..].to_vec();
        let rows = joined(&[tail, run.clone(), run.clone(), run.clone()]);
        for rows in [rows.clone(), shifted(&rows, by)] {
            let alignment = aligned(&rows, &program).unwrap_or_else(|e| panic!("{name}: {e}"));
            let last = run[run.len() - 1][0];
            let took = alignment.fixes[alignment.fixes.len() - 1].time - alignment.fixes[0].time;
            assert_eq!(alignment.passes, 3, "{name}");
            assert!(0.95 < part(&alignment), "{name}: {} of the path", part(&alignment));
            assert!((took / last - 1.0).abs() < 0.1, "{name}: a pass of {last} s took {took} s");
        }
    }
}

#[test]
fn a_run_at_half_the_feed_is_one_and_one_at_five_times_is_not() {
    let program = pocket(2.2);
    let run = recorded(&program, &machine(), 100.0);
    let paced = |pace: f64| -> Rows { run.iter().map(|[time, x, y, z]| [time / pace, *x, *y, *z]).collect() };
    assert!(aligned(&paced(0.5), &program).is_ok());
    assert!(aligned(&paced(1.5), &program).is_ok());
    let refusal = aligned(&paced(5.0), &program).expect_err("no dial goes there");
    assert!(matches!(refusal, AlignmentError::TooFast { .. }), "{refusal}");
}

/// Corners rounded far wider than the machine file says are those of the program; a sibling's lines are not.
#[test]
fn wide_blends_are_aligned_and_siblings_are_not() {
    let mut wide = machine();
    wide.interpolator.contour_tolerance = 0.4;
    for program in [roughing(4.5), pocket(2.9)] {
        let run = recorded(&program, &wide, 100.0);
        let alignment = aligned(&run, &program).unwrap_or_else(|e| panic!("{e}"));
        assert!(0.95 < part(&alignment), "{} of the path", part(&alignment));
    }
    let refusal = aligned(&recorded(&roughing(4.5), &wide, 100.0), &roughing(3.5));
    assert!(refusal.is_err(), "rows that lie millimetres beside those of the program");
}

/// A file may allow blends of millimetres. Where the machine stands it blends nothing, be it at a corner or where the path
/// turns back, and the time is lost at that very line.
#[test]
fn a_wait_is_known_where_corners_may_be_cut_by_millimetres() {
    let program = "G21 G90 G94\nG0 Z10\nT1 M6\nG0 Z1\nG1 Z-1 F600\nX40 F1500\nT2 M6\nY30\nX0\nG0 Z10\nM30\n";
    let [quick, mut slow, mut wide] = [(); 3].map(|()| machine());
    (slow.times.tool_change, wide.interpolator.contour_tolerance) = (quick.times.tool_change + 0.5, 10.0);
    let toolpath = toolpath(program);
    let (_, alignment) =
        align_log(&log(&recorded(program, &slow, 250.0)), &toolpath, &wide).expect("it is of this program");
    let comparison = compare(&toolpath, &simulate(&toolpath, &quick), &alignment);
    let mut lost = regions(&comparison, &alignment, 0);
    lost.sort_by_key(|region| region.lines);
    assert_eq!(lost.iter().map(|region| region.lines.0).collect::<Vec<_>>(), [3, 7], "{lost:?}");
    assert!(lost.iter().all(|region| (region.seconds - 0.5).abs() < 0.01), "{lost:?}");
}

/// Ways out and back of which no two have quite the same direction, since coordinates are rounded, and a ramp into the
/// material: the recorded tool is on the way on which it is, and not on a later one, where it would have to wait.
#[test]
fn a_tool_that_goes_out_and_back_is_on_the_right_way() {
    let rounded = "X0.866 Y0.5\nX0 Y0\nX3.4641 Y2\nX0 Y0\nX12.9904 Y7.5\nX0 Y0\n";
    let ramp = "X6 Y0 Z-0.05\nX0 Z-0.1\nX6 Z-0.15\nX0 Z-0.2\nX6 Z-0.25\n";
    let mut wide = machine();
    wide.interpolator.contour_tolerance = 10.0;
    for ways in [rounded, ramp] {
        let program = format!("{HEAD}G0 X0 Y0 Z1\nG1 Z0 F600\nF1500\n{ways}G0 Z10\nM30\n");
        let toolpath = toolpath(&program);
        let rows = recorded(&program, &machine(), 250.0);
        let (_, alignment) = align_log(&log(&rows), &toolpath, &wide).expect("it is of this program");
        let comparison = compare(&toolpath, &simulate(&toolpath, &machine()), &alignment);
        let lost = regions(&comparison, &alignment, 0);
        assert!(lost.iter().all(|region| region.seconds.abs() < 0.03), "{lost:?}");
    }
}

/// Each run on each program, as it is and in machine coordinates: its own fits, and no other.
#[test]
fn runs_find_their_programs_among_others() {
    let programs = programs();
    let toolpaths: Vec<Toolpath> = programs.iter().map(|(_, text)| toolpath(text)).collect();
    let all: Vec<&Toolpath> = toolpaths.iter().collect();
    let (mut accepted, mut refused) = (Vec::new(), Vec::new());
    for (index, (name, program)) in programs.iter().enumerate() {
        let run = recorded(program, &machine(), 50.0);
        assert_eq!(pair(&log(&run), &all, &machine()), Pairing::Of(index), "{name}");
        let log = log(&shifted(&run, [101.5, -37.75, 212.0]));
        for (other, (of, _)) in programs.iter().enumerate() {
            match (align_log(&log, all[other], &machine()), index == other) {
                (Ok(_), false) => accepted.push(format!("{name} on {of}")),
                (Err(error), true) => refused.push(format!("{name}: {error}")),
                _ => {}
            }
        }
    }
    assert!(refused.is_empty(), "{refused:?}");
    // Two pockets of which one is a third wider: shifted, the one still passes for the other, and only beside it is
    // told from it.
    accepted.retain(|pair| !pair.contains("longer pocket"));
    assert!(accepted.is_empty(), "{accepted:?}");
}

/// Logs of a shop with feed and line numbers alone, on each other's programs.
#[test]
fn a_shops_logs_fit_their_programs_alone() {
    let Some(folder) = recordings_of_others("nist-hurco") else { return };
    let names = ["box-op1", "box-op2", "box-op3", "plate-1", "plate-12", "plate-13"];
    let mut machine = machine();
    machine.interpolator.time_constants = TimeConstants::Equal(0.03);
    let programs = names.map(|name| {
        let text = std::fs::read(folder.join(format!("programs/{name}.nc"))).expect("the program is there");
        trace(&gcode::read(&text), &machine)
    });
    let runs = [("box-op1-03", 0), ("box-op2-12", 1), ("box-op3-06", 2), ("plate-01", 3), ("plate-12", 4)];
    for (run, own) in runs {
        let text = std::fs::read(folder.join(format!("runs/{run}.shdr"))).expect("the run is there");
        let log = read(&text).expect("a log");
        for (other, name) in names.iter().enumerate() {
            match align_log(&log, &programs[other], &machine) {
                Ok(_) => assert!(own == other || run == "plate-12" && *name == "plate-13", "{run} on {name}"),
                Err(error) => assert_ne!(own, other, "{run}: {error}"),
            }
        }
    }
}
