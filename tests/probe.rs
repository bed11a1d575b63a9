//! Programs that separate two causes: within the machine's limits and their own space, and the diagnosis of a
//! run names the right one.

use std::fmt::Write;

use truefeed::identification::diagnosis::{Diagnosis, Verdict, diagnose};
use truefeed::identification::fit::AlignedRun;
use truefeed::identification::probe::{Probe, ProbeError, SNIPPET_SPACE_MM, probe_all, probe_between};
use truefeed::machine::{Machine, Planner, parameter};
use truefeed::project::machine_from_toml;
use truefeed::simulation::drive::actual_motion;
use truefeed::simulation::gcode::{Severity, read};
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::{Profile, Resolution};
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Motion;

/// A machine file with these lines at its end.
fn machine(more: &str) -> Machine {
    let base = "name = \"M\"\n[interpolator]\nfilters = 3\ntime_constant_s = 0.024\n\
                contour_tolerance_mm = 0.03\n[rapid]\nfeed_mm_min = 12000\n[times]\ntool_change_s = 4.0\n";
    machine_from_toml(&format!("{base}{more}")).expect("a machine file")
}

/// What a recorder at 500 Hz sees, to a micrometre, as a table.
fn recording(program: &str, machine: &Machine) -> String {
    let toolpath = trace(&read(program.as_bytes()), machine);
    let plan = simulate(&toolpath, machine);
    let commanded =
        Profile::new(&toolpath, &plan).samples(Resolution { feedrate: 2e-3, position: 2e-4, spacing: 0.0 });
    let actual = actual_motion(&commanded, machine);
    let mut seed = 1u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        2e-3 * ((seed >> 33) as f64 / 2f64.powi(31) - 0.5)
    };
    let mut text = String::from("t_s,x_mm,y_mm,z_mm\n");
    let last = actual.time.last().copied().unwrap_or(0.0);
    let mut row = 0;
    for sample in 0..=(last * 500.0) as u32 {
        let time = f64::from(sample) / 500.0;
        while row + 2 < actual.time.len() && actual.time[row + 1] <= time {
            row += 1;
        }
        let span = actual.time[row + 1] - actual.time[row];
        let share = if 0.0 < span { ((time - actual.time[row]) / span).clamp(0.0, 1.0) } else { 0.0 };
        let [x, y, z] = [0, 1, 2].map(|axis: usize| {
            let column = &actual.position[axis];
            column[row] + share * (column[row + 1] - column[row]) + noise()
        });
        let _ = writeln!(text, "{:.5},{x:.4},{y:.4},{z:.4}", time * machine.recorder.clock_ratio);
    }
    text
}

fn diagnosed(program: &str, believed: &Machine, truth: &Machine) -> Diagnosis {
    let toolpath = trace(&read(program.as_bytes()), believed);
    let recorded = AlignedRun::new(toolpath, recording(program, truth).as_bytes(), believed)
        .expect("a recording of this program");
    diagnose(believed, &[recorded.run_ignoring_overrides()], &mut |_| {})
}

/// The probe for a pair names each of the two where it is concealed.
fn separates(one: (&str, &str, f64), other: (&str, &str, f64)) {
    names([one.0, other.0], &[one, other]);
}

/// The probe for a pair names the one that is concealed.
fn names(pair: [&str; 2], concealed: &[(&str, &str, f64)]) {
    let believed = machine("");
    let probe = probe_between(&believed, pair).expect("the two can be separated");
    for &(id, key, value) in concealed {
        let mut truth = believed.clone();
        assert!(parameter(key).is_some(), "{key}");
        let (table, key) = key.rsplit_once('.').expect("a key in a table");
        truth = match table {
            "interpolator" => {
                let text = truefeed::project::toml_from_machine(&truth);
                let lines = text.lines().filter(|line| !line.starts_with(&format!("{key} =")));
                let text: String = lines.map(|line| format!("{line}\n")).collect();
                let text = text.replace("[interpolator]\n", &format!("[interpolator]\n{key} = {value}\n"));
                machine_from_toml(&text).expect("a machine file")
            }
            _ => machine(&format!("[{table}]\n{key} = {value}\n")),
        };
        let diagnosis = diagnosed(&probe.program, &believed, &truth);
        let found: Vec<&str> =
            diagnosis.causes.iter().map(|cause| cause.candidate.hypothesis.effect.id).collect();
        assert_eq!(found.first(), Some(&id), "{id} {value}: {found:?} {:?}", diagnosis.verdict);
        assert_ne!(diagnosis.verdict, Verdict::Unknown, "{id} {value} is all there is: {found:?}");
    }
}

#[test]
fn tolerance_and_filter() {
    separates(
        ("corner_tolerance", "interpolator.contour_tolerance_mm", 0.012),
        ("filter_time_constant", "interpolator.time_constant_s", 0.036),
    );
}

#[test]
#[ignore = "full suite: diagnoses two probes; tolerance_and_filter does for another pair"]
fn accelerations_of_an_axis_and_of_the_path() {
    separates(
        ("axis_acceleration_limit", "axis.x.acceleration_mm_s2", 700.0),
        ("path_acceleration_limit", "path.acceleration_mm_s2", 800.0),
    );
}

#[test]
#[ignore = "full suite: diagnoses two probes; tolerance_and_filter does for another pair"]
fn clock_and_override() {
    separates(("recorder_clock", "recorder.clock_ratio", 1.02), ("feed_override", "override.feed", 0.93));
}

#[test]
#[ignore = "full suite: diagnoses two probes; tolerance_and_filter does for another pair"]
fn tolerance_and_junction_rule() {
    separates(
        ("corner_tolerance", "interpolator.contour_tolerance_mm", 0.012),
        ("junction_rule", "interpolator.axis_velocity_step_mm_min", 250.0),
    );
}

#[test]
#[ignore = "full suite: diagnoses two probes; tolerance_and_filter does for another pair"]
fn block_time_and_look_ahead() {
    separates(
        ("block_processing_time", "interpolator.block_time_s", 0.012),
        ("look_ahead", "interpolator.look_ahead_blocks", 4.0),
    );
}

/// The diagnosis takes a form error below 10 µm for none, which a play of 20 µm does not reach.
#[test]
fn play_beside_lag() {
    names(["backlash", "servo_lag"], &[("backlash", "axis.x.backlash_mm", 0.06)]);
}

#[test]
fn lag_beside_play() {
    names(["backlash", "servo_lag"], &[("servo_lag", "axis.x.servo_lag_s", 0.02)]);
}

/// Every law a program must hold on its machine.
fn holds_the_laws(machine: &Machine, probe: &Probe) {
    let program = read(probe.program.as_bytes());
    let toolpath = trace(&program, machine);
    let errors: Vec<_> =
        toolpath.diagnostics.iter().filter(|remark| remark.severity == Severity::Error).collect();
    assert!(errors.is_empty(), "{errors:?}\n{}", probe.program);
    assert!(probe.program.starts_with("(Needs X0..120 Y0..120 Z0..20 mm"), "{}", probe.program);
    for segment in toolpath.segments.iter().skip(1) {
        for part in 0..=20 {
            let at = segment.point(segment.length * f64::from(part) / 20.0);
            for axis in 0..3 {
                assert!((0.0..=SNIPPET_SPACE_MM[axis]).contains(&at[axis]), "{at:?}");
            }
        }
        if let Motion::Feed { feedrate } = segment.motion {
            assert!(feedrate <= machine.rapid.feedrate * (1.0 + 1e-3), "{feedrate}");
            assert!(machine.axes.iter().all(|axis| feedrate <= axis.velocity * (1.0 + 1e-3)), "{feedrate}");
        }
    }
}

#[test]
fn any_machine_gives_a_program_within_its_limits() {
    for more in ["", "[axis.x]\nvelocity_mm_min = 300\n", "[axis.z]\nvelocity_mm_min = 1500\n"] {
        let machine = machine(more);
        let probe = probe_all(&machine);
        holds_the_laws(&machine, &probe);
        assert_eq!(probe, probe_all(&machine), "the same every time");
    }
}

/// How widely LinuxCNC blends a corner depends on the override that it plans for, unless a block is too short for that.
#[test]
fn the_whole_program_shows_the_override_that_corners_are_planned_for() {
    let preset = machine("");
    let toolpath = trace(&read(probe_all(&preset).program.as_bytes()), &preset);
    for acceleration in [250.0, 700.0, 2000.0] {
        let mut planner = preset.clone();
        planner.become_planner(Planner::AccelerationBlend, acceleration);
        let [usual, larger, largest] = [1.2, 1.5, 2.0].map(|max_override| {
            planner.interpolator.max_override = max_override;
            simulate(&toolpath, &planner).cycle_time()
        });
        // A fit takes no difference below 15 ms for certain.
        assert!(larger + 0.015 < usual && largest + 0.015 < larger, "{usual} {larger} {largest} s");
    }
}

#[test]
fn what_cannot_be_separated_is_refused_with_a_reason() {
    let machine = machine("");
    let refused = |one: &str, other: &str| probe_between(&machine, [one, other]).expect_err("refused");
    assert!(matches!(refused("corner_tolerence", "backlash"), ProbeError::Unknown { nearest, .. }
        if nearest == "corner_tolerance"));
    assert!(matches!(refused("backlash", "backlash"), ProbeError::Same(_)));
    assert!(matches!(refused("axis_velocity_limit (X)", "axis_velocity_limit (x)"), ProbeError::Same(_)));
    assert!(matches!(refused("feed_hold", "backlash"), ProbeError::Unprovoked { .. }));
    let mut one_filter = machine.clone();
    one_filter.interpolator.filters = 1;
    let refused = probe_between(&one_filter, ["unequal_filters", "backlash"]).expect_err("refused");
    assert!(matches!(refused, ProbeError::Hidden("unequal_filters")), "{refused}");
}

#[test]
fn a_limit_is_told_from_that_of_another_axis() {
    let machine = machine("[axis.x]\nvelocity_mm_min = 3000\n[axis.y]\nvelocity_mm_min = 3000\n");
    let probe =
        probe_between(&machine, ["axis_velocity_limit (X)", "axis_velocity_limit (Y)"]).expect("they differ");
    assert!(probe.summary[1].contains("axis_velocity_limit (Y)"), "{:?}", probe.summary);
    holds_the_laws(&machine, &probe);
}
