//! Recordings that cannot be compared say why; those that can be repaired say how; none is compared wrongly.

use truefeed::identification::comparison::compare;

use crate::sceptic::{Rows, csv, laid, machine, program, recorded};

/// What is said of a recording: the refusal, or what was repaired and by how much the times differ, s.
fn said(recording: &str) -> Result<(String, f64), String> {
    let machine = machine();
    let recorded = laid(&program(), recording, &machine).map_err(|error| error.to_string())?;
    let plan = recorded.run().plan(&machine);
    let whole = compare(&recorded.toolpath, &plan, &recorded.alignment).whole;
    let log = recorded.log.remarks.0.iter().map(|remark| remark.message.clone());
    let all: Vec<String> = log.chain(recorded.alignment.remarks.iter().cloned()).collect();
    Ok((all.join("; "), whole.recorded - whole.simulated))
}

fn clean() -> Rows {
    recorded(&program(), &machine(), 100.0)
}

fn changed(change: impl Fn(&mut [f64; 4])) -> String {
    let mut rows = clean();
    rows.iter_mut().for_each(change);
    csv(&rows)
}

/// A refusal with a reason in which each of these words stands.
fn refused(recording: &str, words: &[&str]) {
    match said(recording) {
        Err(reason) => {
            let lower = reason.to_lowercase();
            assert!(words.iter().all(|word| lower.contains(word)), "{reason}, expected {words:?}");
        }
        Ok((remarks, lost)) => panic!("compared, {lost} s off: {remarks}"),
    }
}

#[test]
fn the_recording_itself_is_compared() {
    let (_, lost) = said(&csv(&clean())).expect("it is of this program");
    assert!(lost.abs() < 0.01, "{lost} s");
}

#[test]
fn another_program_is_refused() {
    let other = "G21 G90\nG0 X0 Y0 Z5\nG1 X10 Y40 F2000\nG1 X-30 Y12\nG1 X5 Y-20\nG0 X0 Y0\nM30\n";
    refused(&csv(&recorded(other, &machine(), 100.0)), &["another program"]);
}

#[test]
fn other_units_are_named() {
    refused(&changed(|row| row[1..].iter_mut().for_each(|value| *value /= 25.4)), &["inch"]);
    refused(&changed(|row| row[1..].iter_mut().for_each(|value| *value *= 1000.0)), &["µm"]);
}

#[test]
fn another_unit_of_time_is_named() {
    for factor in [1e-3, 1e-6, 1e-9, 1e3] {
        let rows: Rows = clean().into_iter().map(|[t, x, y, z]| [factor * t, x, y, z]).collect();
        let row = |row: &[f64; 4]| format!("{:.14},{:.4},{:.4},{:.4}\n", row[0], row[1], row[2], row[3]);
        let text = String::from("t_s,x_mm,y_mm,z_mm\n") + &rows.iter().map(row).collect::<String>();
        refused(&text, &["time", "unit"]);
    }
    // A tenth of the feed is an override.
    let (_, lost) = said(&changed(|row| row[0] *= 10.0)).expect("it is of this program");
    assert!(100.0 < lost, "{lost} s");
}

#[test]
fn swapped_axes_are_named() {
    refused(&changed(|row| row.swap(1, 2)), &["exchanged"]);
}

#[test]
fn a_reversed_file_is_refused_or_repaired_by_name() {
    let mut rows = clean();
    let times: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    rows.reverse();
    let as_is = csv(&rows);
    rows.iter_mut().zip(times).for_each(|(row, time)| row[0] = time);
    // The same places at ascending times: the path is run backwards.
    refused(&csv(&rows), &["revers"]);
    // Descending times are those of a file written last row first.
    match said(&as_is) {
        Err(reason) => assert!(reason.contains("time"), "{reason}"),
        Ok((remarks, lost)) => {
            assert!(lost.abs() < 0.01 && remarks.contains("time"), "{lost} s: {remarks}");
        }
    }
}

#[test]
fn a_truncated_file_is_compared_as_far_as_it_goes() {
    let mut rows = clean();
    rows.truncate(rows.len() / 2);
    let mut text = csv(&rows);
    text.truncate(text.len() - 7);
    let (_, lost) = said(&text).expect("half a run is one");
    assert!(lost.abs() < 0.02, "{lost} s");
}

#[test]
fn files_without_a_motion_are_refused() {
    refused("", &["empty"]);
    refused("t_s,x_mm,y_mm,z_mm\n", &["no"]);
    refused("t_s,x_mm,y_mm,z_mm\n0,1,2,3\n", &["sample"]);
    let still: String = (0..500).map(|row| format!("{},1.5,2.5,0\n", f64::from(row) * 0.01)).collect();
    refused(&format!("t_s,x_mm,y_mm,z_mm\n{still}"), &["mov"]);
    assert!(laid(&program(), "\u{0}\u{1}\u{2}\u{3}PK\u{0}\u{0}", &machine()).is_err());
    let bytes: Vec<u8> = (0..4000u32).map(|value| (value.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    let toolpath = crate::sceptic::toolpath(&program(), &machine());
    let error = truefeed::identification::fit::AlignedRun::new(toolpath, &bytes, &machine());
    assert!(error.is_err(), "bytes of any kind are no recording");
}

#[test]
fn a_constant_column_is_said() {
    match said(&changed(|row| row[1] = 12.0)) {
        Err(reason) => assert!(reason.to_lowercase().contains('x') || reason.contains("path"), "{reason}"),
        Ok((remarks, lost)) => {
            assert!(lost.abs() < 0.05 && remarks.to_lowercase().contains('x'), "{lost} s: {remarks}");
        }
    }
}

#[test]
fn what_is_no_number_and_what_goes_back_is_repaired_by_name() {
    let mut lines: Vec<String> = csv(&clean()).lines().map(str::to_string).collect();
    for row in [200, 201, 700] {
        let time = lines[row].split(',').next().expect("a time").to_string();
        lines[row] = format!("{time},NaN,NaN,NaN");
    }
    let (remarks, lost) = said(&lines.join("\n")).expect("most rows are whole");
    assert!(lost.abs() < 0.01 && !remarks.is_empty(), "{lost} s: {remarks}");

    let mut rows = clean();
    let moved = rows.remove(400);
    rows.insert(390, moved);
    match said(&csv(&rows)) {
        Err(reason) => assert!(reason.contains("time"), "{reason}"),
        Ok((remarks, lost)) => {
            assert!(lost.abs() < 0.01 && remarks.contains("time"), "{lost} s: {remarks}");
        }
    }
}
